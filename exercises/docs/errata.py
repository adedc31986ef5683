"""Where the chapter is wrong as printed, as data, with numbers that show it, worked out from qdot's own results.

Every claim is computed: the right form comes from the derivation, the printed one is written down as it is printed, and
`values` are what both give in one configuration.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.classification import classify_pieces
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.writing.languages import Catalogue

A1, A2, A3, T1, T2, T3 = sp.symbols("a1 a2 a3 theta1 theta2 theta3")
QD1, QD2 = sp.symbols("qd1 qd2")
Numbers = Mapping[sp.Symbol, sp.Expr]


def degrees(value: int) -> sp.Expr:
    """Return an angle in radians."""
    return sp.pi * sp.Rational(value, 180)


TWO_R: Numbers = {A1: sp.Rational(1, 2), A2: sp.Rational(2, 5), T1: degrees(20), T2: degrees(40)}
RATES: Numbers = {QD1: sp.Integer(1), QD2: sp.Integer(2)}
ELBOW: Numbers = {
    A1: sp.Rational(1, 10), A2: sp.Rational(1, 2), A3: sp.Rational(2, 5),
    T1: degrees(30), T2: degrees(-40), T3: degrees(70),
}  # fmt: skip


@dataclass(frozen=True)
class Erratum:
    """One correction: where it is, what is printed, what is right, why it matters, and numbers that show it.

    `kind` is "wrong", "incomplete" or "lost in the layout". `at` tells the configuration, `values` what is found there
    as (what, number); formulas are LaTeX in dollar signs.
    """

    where: str
    kind: str
    printed: str
    right: str
    why: str
    at: str
    values: tuple[tuple[str, str], ...]


def errata(planar: Chain, scorbot: Chain, words: Catalogue) -> tuple[Erratum, ...]:
    """Return the corrections in the chapter's order and in a language; the arms are those of Examples 6.1 and 6.3."""
    corrections = (
        *_example_6_1(planar, words),
        _example_6_2(planar, words),
        *_example_6_3(scorbot, words),
        *_text_errata(planar, words),
    )
    return tuple(_with_decimals(each, words) for each in corrections)


def _with_decimals(erratum: Erratum, words: Catalogue) -> Erratum:
    """Return a correction with the decimal sign of a language, also of the numbers that stand in no formula."""
    convert = words.with_decimals
    return replace(
        erratum, printed=convert(erratum.printed), right=convert(erratum.right), at=convert(erratum.at),
        values=tuple((convert(what), words.with_decimal(value)) for what, value in erratum.values),
    )  # fmt: skip


def number(value: sp.Expr | float) -> str:
    """Return a number to four significant digits; what is zero but for rounding is 0.

    >>> number(0.123456), number(1e-17), number(2)
    ('0.1235', '0', '2')
    """
    double = float(value)
    return "0" if abs(double) < 1e-12 else f"{double:.4g}".replace("-", "−")


def configuration_text(numbers: Numbers) -> str:
    """Return a configuration in words: lengths in metres, angles in degrees, rates in rad/s."""
    texts = []
    for symbol, value in numbers.items():
        letter, index = symbol.name.rstrip("123"), symbol.name[-1]
        name = {"theta": r"\theta", "qd": r"\dot{\theta}"}.get(letter, letter)
        unit = {"theta": r"^\circ", "qd": r"\,\text{rad/s}"}.get(letter, r"\,\text{m}")
        size = sp.deg(value) if letter == "theta" else value
        texts.append(f"${name}_{{{index}}} = {float(size):.4g}{unit}$")
    return ", ".join(texts)


def _example_6_1(planar: Chain, words: Catalogue) -> tuple[Erratum, ...]:
    gettext, pgettext = words.gettext, words.pgettext
    d = derive(planar)
    rotation = d.rotations[2].xreplace(TWO_R)
    c12, s12 = sp.cos(T1 + T2), sp.sin(T1 + T2)
    printed_column = sp.Matrix([rotation[0, 0], c12.xreplace(TWO_R), rotation[2, 0]])
    moving = {**TWO_R, **RATES}
    right = (d.geometric[0, :] * sp.Matrix([QD1, QD2]))[0].xreplace(moving)
    printed = (-A1 * sp.sin(T1) * QD1 - A2 * s12 * QD1 + QD2).xreplace(moving)
    return (
        Erratum(
            gettext("Example 6.1, entry (2, 1) of $T$"),
            pgettext("erratum", "wrong"),
            gettext("a cosine"),
            "$s_{12}$",
            gettext(
                "The columns of a rotation have length 1 and are square to each other. Whoever copies the entry "
                "works with a matrix that stretches, and every frame behind it is misplaced."
            ),
            configuration_text(TWO_R),
            (
                (
                    gettext("length of the first column with $c_{12}$ there"),
                    number(sp.sqrt(printed_column.dot(printed_column))),
                ),
                (gettext("length of the right one"), number(sp.sqrt(rotation[:, 0].dot(rotation[:, 0])))),
            ),
        ),
        Erratum(
            gettext("Example 6.1, $v_x$ and $v_y$"),
            pgettext("erratum", "lost in the layout"),
            r"$-a_2 s_{12}\,\dot{\theta}_1 + \dot{\theta}_2$",
            r"$-a_2 s_{12}(\dot{\theta}_1 + \dot{\theta}_2)$",
            gettext(
                "Without the bracket a rate in rad/s is added to a velocity in m/s, and joint 2 would move $P$ "
                "equally fast whatever the length of its link."
            ),
            configuration_text(moving),
            ((gettext("$v_x$ as printed"), f"{number(printed)} m/s"), ("$v_x$", f"{number(right)} m/s")),
        ),
    )


def _example_6_2(planar: Chain, words: Catalogue) -> Erratum:
    gettext, pgettext = words.gettext, words.pgettext
    jacobian = derive(planar).jacobian
    right = jacobian.inv().xreplace(TWO_R).evalf()
    printed = right.as_mutable()
    printed[0, 1] = -printed[0, 1]
    wanted = sp.Matrix([0, sp.Rational(1, 5)])
    rates = printed * wanted
    reached = jacobian.xreplace(TWO_R).evalf() * rates
    return Erratum(
        gettext("Example 6.2, entry (1, 2) of $J^{-1}$"),
        pgettext("erratum", "wrong"),
        "$-a_2 s_{12}$",
        "$+a_2 s_{12}$",
        gettext(
            "$J J^{-1}$ is no longer the identity: an arm that is told to move along $y$ with the printed "
            "inverse moves another way. Multiplying the two matrices finds such a slip."
        ),
        gettext("%(arm)s, wanted $v_x = 0$, $v_y = 0.2$ m/s", arm=configuration_text(TWO_R)),
        (
            (gettext("$v_x$ reached with the printed inverse"), f"{number(reached[0])} m/s"),
            (gettext("$v_y$ reached"), f"{number(reached[1])} m/s"),
            (
                gettext("$v_x$ with the right one"),
                f"{number((jacobian.xreplace(TWO_R).evalf() * right * wanted)[0])} m/s",
            ),
        ),
    )


def _example_6_3(scorbot: Chain, words: Catalogue) -> tuple[Erratum, ...]:
    gettext, pgettext = words.gettext, words.pgettext
    d = derive(scorbot)
    right = d.geometric[1, 1].xreplace(ELBOW)
    printed = (-sp.sin(T1) * (A2 * sp.sin(T2) + A3 * sp.cos(T2 + T3))).xreplace(ELBOW)
    step = sp.Rational(1, 10**5)
    ahead, behind = ({**ELBOW, T2: ELBOW[T2] + side * step} for side in (1, -1))
    difference = (d.position[1].xreplace(ahead) - d.position[1].xreplace(behind)).evalf(30) / (2 * step)
    terms = sp.expand(d.jacobian.det(method="berkowitz"))
    factored = d.determinant
    straight = {**ELBOW, T2: sp.S.Zero}
    shoulder = _shoulder(d.determinant)
    return (
        Erratum(
            gettext(r"Example 6.3, $\partial p_y / \partial \theta_2$"),
            pgettext("erratum", "wrong"),
            "$-s_1(a_2 s_2 + a_3 c_{23})$",
            "$-s_1(a_2 s_2 + a_3 s_{23})$",
            gettext(
                "The derivative of $c_{23}$ is $-s_{23}$. A finite difference of the position, worked out with "
                "numbers, shows the slip at once."
            ),
            configuration_text(ELBOW),
            (
                (gettext("as printed"), number(printed)),
                (pgettext("erratum", "right"), number(right)),
                (gettext("finite difference"), number(difference)),
            ),
        ),
        Erratum(
            gettext(r"Example 6.3, $\det J$"),
            pgettext("erratum", "incomplete"),
            gettext("five terms, left as a sum"),
            "$a_2 a_3 s_3 (a_1 + a_2 c_2 + a_3 c_{23})$",
            gettext("Only the factors tell where the arm is singular; from the sum nothing can be read."),
            configuration_text(ELBOW),
            (
                (gettext("terms of the determinant, multiplied out and not tidied"), str(len(sp.Add.make_args(terms)))),
                (gettext("the sum"), number(terms.xreplace(ELBOW))),
                (gettext("the product"), number(factored.xreplace(ELBOW))),
            ),
        ),
        Erratum(
            gettext("Example 6.3, singular configurations"),
            pgettext("erratum", "wrong"),
            gettext("$s_2 = 0$ and $s_3 = 0$"),
            gettext("$s_3 = 0$, or $a_1 + a_2 c_2 + a_3 c_{23} = 0$"),
            gettext(
                r"$\theta_2 = 0$ by itself costs nothing, so that the printed set has configurations too many. And "
                r"it lacks the shoulder singularity, $P$ on the axis of joint 1, which a program that checks the "
                r"printed conditions would run into."
            ),
            gettext(
                r"the lengths above; first $\theta_2 = 0$, then $\theta_2 = %(angle)s^\circ$, $\theta_3 = "
                r"70^\circ$, where neither $s_2$ nor $s_3$ is zero",
                angle=number(sp.deg(shoulder[T2])),
            ),
            (
                (gettext(r"rank of $J$ at $\theta_2 = 0$"), str(_rank(scorbot, straight))),
                (gettext(r"$\det J$ there"), number(factored.xreplace(straight))),
                (gettext("rank of $J$ at the second place"), str(_rank(scorbot, shoulder))),
                (gettext(r"$\det J$ there"), number(factored.xreplace(shoulder))),
            ),
        ),
    )


def _shoulder(determinant: sp.Expr) -> dict[sp.Symbol, sp.Expr]:
    """Return numbers with P on the axis of joint 1, joint 3 being bent."""
    fixed = {symbol: value for symbol, value in ELBOW.items() if symbol != T2}
    root = sp.nsolve(determinant.xreplace(fixed), T2, 2.0, prec=30)
    return {**ELBOW, T2: root}


def _rank(chain: Chain, numbers: Numbers) -> int:
    jacobian = np.array(derive(chain).jacobian.xreplace(dict(numbers)).evalf(20).tolist(), dtype=float)
    return int(np.linalg.matrix_rank(jacobian, tol=1e-9))


def _text_errata(planar: Chain, words: Catalogue) -> tuple[Erratum, ...]:
    gettext, pgettext = words.gettext, words.pgettext
    determinant = derive(planar).determinant
    stretched, folded = ({**TWO_R, T2: angle} for angle in (sp.S.Zero, sp.pi))
    distance = NumericChain(planar, {"a1": 0.5, "a2": 0.4}).point(np.array([0.0, np.pi / 3]))
    away = number(float(np.linalg.norm(distance)))
    solutions = _solutions(0.5, 0.4, 0.9), _solutions(0.5, 0.4, float(np.linalg.norm(distance)))
    kinds = {"boundary": pgettext("erratum", "boundary"), "internal": pgettext("erratum", "internal")}
    alike = _folded_kind(planar, 0.5), _folded_kind(planar, 0.4)
    return (
        Erratum(
            gettext("singularity defined as two aligned joint axes"),
            pgettext("erratum", "wrong"),
            gettext("two joint axes align"),
            gettext("$J$ loses rank"),
            gettext(
                "The axes of the planar arm are parallel in every configuration, singular or not, and never "
                "coincide. Aligned axes are a reason that comes up in wrists, not the definition."
            ),
            gettext("the planar arm, axes parallel throughout"),
            (
                (gettext(r"rank at $\theta_2 = 40^\circ$"), str(_rank(planar, TWO_R))),
                (gettext(r"rank at $\theta_2 = 0$"), str(_rank(planar, stretched))),
            ),
        ),
        Erratum(
            gettext("how many inverse solutions there are at a singularity"),
            pgettext("erratum", "wrong"),
            gettext("infinitely many, always"),
            gettext("it depends on the singularity"),
            gettext(
                "A student who looks for the infinitely many poses of the stretched arm looks in vain: it is the "
                "only one that reaches so far. Infinitely many there are where $P$ lies on an axis, at a shoulder "
                "for one."
            ),
            gettext(r"the planar arm with $a_1 = 0.5$ m, $a_2 = 0.4$ m"),
            (
                (gettext("poses that reach a point at 0.9 m, stretched out"), str(solutions[0])),
                (
                    gettext("poses that reach a point at %(distance)s m", distance=words.with_decimal(away)),
                    str(solutions[1]),
                ),
            ),
        ),
        Erratum(
            gettext("boundary singularities"),
            pgettext("erratum", "wrong"),
            gettext("a joint at its physical limits"),
            gettext("the point at the boundary of what it can reach: arm stretched out or folded back"),
            gettext(
                "A limit of travel does not enter $J$: at a stop the Jacobian may have full rank, and at full "
                "stretch it has not, however far the joints could turn."
            ),
            gettext(r"a stop at $\theta_2 = 40^\circ$, against full stretch"),
            (
                (gettext(r"$\det J$ at the stop"), number(determinant.xreplace(TWO_R))),
                (r"$\det J$ at $\theta_2 = 0$", number(determinant.xreplace(stretched))),
            ),
        ),
        Erratum(
            gettext("“may render $J$ not invertible”"),
            pgettext("erratum", "wrong"),
            pgettext("erratum", "may"),
            pgettext("erratum", "does"),
            gettext(
                "That is what singular means: the determinant is zero and no inverse exists. Close to it the joint "
                "rates grow without bound."
            ),
            gettext("the planar arm"),
            (
                (r"$\det J$ at $\theta_2 = 0$", number(determinant.xreplace(stretched))),
                (r"at $\theta_2 = \pi$", number(determinant.xreplace(folded))),
            ),
        ),
        Erratum(
            gettext("Example 6.2, $s_2 = 0$"),
            pgettext("erratum", "incomplete"),
            "$s_2 = 0$",
            gettext(
                r"$\theta_2 = 0$ or $\theta_2 = \pi$, with $a_1, a_2 \neq 0$; for $a_1 = a_2$ the folded arm is "
                r"inside its reach"
            ),
            gettext(
                "With equal links $P$ comes to lie on the axis of joint 1, from where it can be reached past in "
                "every direction: an internal singularity, not a boundary."
            ),
            r"$\theta_2 = \pi$",
            (
                (gettext("kind for $a_1 = a_2 = 0.5$ m"), kinds[alike[0]]),
                (gettext("kind for $a_1 = 0.5$ m, $a_2 = 0.4$ m"), kinds[alike[1]]),
            ),
        ),
    )


def _solutions(a1: float, a2: float, reach: float) -> int:
    """Return in how many poses a planar 2R arm reaches a point at that distance, by the law of cosines."""
    cosine = (reach**2 - a1**2 - a2**2) / (2 * a1 * a2)
    return 1 if abs(abs(cosine) - 1) < 1e-12 else 2 if abs(cosine) < 1 else 0


def _folded_kind(planar: Chain, second: float) -> str:
    """Return the kind of the folded configuration for a1 = 0.5 m and a second link of that length."""
    lengths = (sp.Rational(1, 2), sp.Rational(str(second)))
    joints = tuple(replace(joint, a=a) for joint, a in zip(planar.joints, lengths, strict=True))
    return classify_pieces(replace(planar, joints=joints), ("theta2 = pi",)).kind
