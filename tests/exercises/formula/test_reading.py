"""Typed answers: correct answers are accepted in any notation, and unclear ones are refused quickly."""

import pytest

from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.names import split_name
from qdot.exercises.formula.notation import to_plain_text
from qdot.exercises.formula.parser import parse_formula
from qdot.grader.judging.verdict import Outcome
from tests.support.judging import judge_expression, judge_matrix, judge_singular
from tests.support.suites import sample_for_suite, select_for_suite

ANGLES = dict.fromkeys(("theta1", "theta2", "theta3", "alpha1"), "angle")
LENGTHS = dict.fromkeys(("a1", "a2", "a3"), "length")
DOMAIN = Domain({**ANGLES, **LENGTHS, **dict.fromkeys(("d3", "qd1", "qd2", "vx", "vy", "wz"), "signed")})
POSITION = "a1*cos(theta1) + a2*cos(theta1 + theta2)"
POSITIONS = [
    r"a_1 \cos\theta_1 + a_2\cos(\theta_1+\theta_2)",
    r"a_{1}\cos{\theta_{1}}+a_{2}\cos{\left(\theta_{1}+\theta_{2}\right)}", r"$a_1 c_1 + a_2 c_{12}$",
    r"\(a_1\mathrm{c}_1 + a_2 \mathrm{c}_{12}\)", r"a_1\cos(\theta_1)+\frac{2a_2}{2}\cos(\theta_1+\theta_2)",
    r"a_1\cos(\theta_1)+\dfrac{a_2^{2}}{a_2}\cos\left(\theta_1+\theta_2\right)",
    r"a_1 \cdot \cos \theta_1 + a_2 \times \cos(\theta_1 + \theta_2)", "a_1 c_{1} + a_2 c_{1 2}", "a1*c1+a2*c_{12}",
    "a1 cos θ1 + a2 cos(θ1+θ2)", "a1 cos theta1 + a2 cos(theta1+theta2)", "a1·cos(θ₁) + a2·cos(θ₁ + θ₂)",
    "a1*cosθ1+a2*cos(θ1+θ2)", "a1cos(theta1)+a2cos(theta1+theta2)", "a1c1 + a2c12", "a1*c1+a2*(c1c2-s1s2)",
    "a1*cos(q1)+a2*cos(q1+q2)", "a1*cos(th1)+a2*cos(th1+th2)", "a1*cos(theta1)+a2*cos(theta12)",
    "a1*cos(theta_1(t))+a2*cos(theta_1(t)+theta_2(t))", "a1*np.cos(theta1)+a2*np.cos(theta1+theta2)",
    "a1*math.cos(theta1)+a2*math.cos(theta1+theta2)", "a1*cos(theta1)+a2*cos(theta1+theta2) m",
    "(a1*cos(theta1)+a2*cos(theta1+theta2))*m", "x = a1*cos(theta1)+a2*cos(theta1+theta2)",
    "a1*c1+a2*cos(theta1+theta2);", "a1*c1+a2*c12.", "a1*cos(theta1)+a2*cos(theta1+theta2) + 0j",
    "cos(theta1)a1+cos(theta1+theta2)a2", "a1*Cos[theta1]+a2*Cos[theta1+theta2]",
    "a1*cos(deg2rad(180/pi*theta1))+a2*cos(theta1+theta2)", "1.0*a1*cos(theta1)+\n1.*a2*cos(theta1+theta2)",
    "lambda theta1, theta2: a1*cos(theta1)+a2*cos(theta1+theta2)", "lambda q: a1*cos(q[0])+a2*cos(q[0]+q[1])",
    "a1*cos(q(1))+a2*cos(q(1)+q(2))", "a1*cos(Theta1)+A2*COS(THETA1+Theta_2)",
    "a1*cos(theta1)+a2*cos(theta1+theta2) [m]", "sp.simplify(a1*cos(theta1)+a2*cos(theta1+theta2))",
    "det(J) = a1*c1+a2*c12", "det J = a1*c1+a2*c12", "|J| = a1*c1+a2*c12", r"$\det(J) = a_1 c_1 + a_2 c_{12}$",
    r"\left|J\right| = a_1 c_1 + a_2 c_{12}",
    "a1 cθ1 + a2 cθ12", "a1cθ₁ + a2cθ₁₂", "a1*c(theta1) + a2*c(theta1+theta2)", "a1 C(θ1) + a2 C(q1+q2)",
    r"a_1 c\theta_1+a_2 c\theta_{12}", r"a_1c_{\theta_1}+a_2c_{\theta_1+\theta_2}", r"a_1\mathrm{c}\theta_1+a_2c_{1+2}",
    r"a_1 c\left(\theta_1\right)+a_2(c\theta_1c\theta_2-s\theta_1s\theta_2)", "a1 cth1 + a2 c_q12",
    "a1 cos_1 + a2 cos_{12}", "a1c theta1 + a2c(theta12)",
]  # fmt: skip
WRITINGS = {
    "qd1": ["Derivative(theta1(t), t)", "diff(theta1,t)", "theta1.diff(t)", r"\dot{\theta}_1", r"\dot\theta_1",
            r"\dot{\theta_1}", r"\dot{\theta_{1}}",
            "thetadot1", "theta1(t).diff(t)", "theta1.diff()", "q[0].diff(t)", "dq[0]", "qd(1)", "dθ1/dt",
            "dtheta1/dt", "(dtheta1/dt)", "q1'", "theta1(t)'", r"\frac{d\theta_1}{dt}",
            r"\frac{\mathrm{d}\theta_{1}}{\mathrm{d}t}", r"\frac{d}{dt}\theta_1", "theta1_dot", "dtheta1",
            "theta_dot_1", "θ̇1", "q̇1", "qdot1", "dq1", "qd_1", r"\dot{q}_{1}", "thetad1"],
    "3/10": ["0.3 m", "30 cm", "300 mm", "0.3 rad/s", "0,3", ".3"],
    "sqrt(3)*a1/2": ["√3/2 a1", "sqrt3/2*a1", "a1 sin(60 deg)", "a1 cos(30.0 degrees)", "√(3) a1/2",
                     r"\frac{\sqrt3}{2}a_1"],
    "pi/6": ["30 deg", "30°", "30 degrees", r"\frac{\pi}{6}", "π/6", "radians(30)", "np.pi/6"],
    "sin(alpha1)": ["sin(alpha_1)", "sinα1", r"\sin\alpha_1", "sin α_1", "sα1", r"s\alpha_1"], "vx": ["v_x", "v_{x}"],
    "wz": ["omega_z", "ω_z", r"\omega_z", "w_z"],
    "wz*(a1 + a2)": [r"\omega_z (a_1 + a_2)", r"\omega_{z} \left(a_1 + a_2\right)", "ω_z (a1 + a2)"],
    "a1*sin(theta2)^2": ["a1s2²", "a1s2^2", "a1sin(theta2)**2", "a1.s2^2", "a1sθ2²", "a1 . (s2)^2"],
    "a1^2*cos(theta1)^4/a1": ["a1c1^4", "(a1c1)^2c1^2/a1", "a1c1^2^2"],
    "a1*a2*sin(theta2)": ["a1.a2.sin(theta2)", "a1.a2.s2", "a1.(a2).sin θ2", "a_1.a_2.s_2"],
    "2.5*a1": ["2.5.a1", "5.a1/2."],
    "a1*abs(sin(theta2))": ["a1*|s2|", r"a_1\cdot\left|\sin\theta_2\right|", r"\lvert a_1 s_2 \rvert", "|a1|*|s2|",
                           "a1|s2|", "a1 |sin(theta2)|", "|a1| |s2|", "a1|(a2|s2|)|/a2",
                           r"a_1\left|\sin\theta_2\right|"],
    "a1/2": ["1/2 a1", "½ a1", r"\tfrac12 a_1"], "a1^2*a2": ["a1^2 a2", "a1**2a2", "a1² a2", "a1^{2} a2"],
    "sin(theta1)^2": ["sin^2 theta1", "sin²θ1", r"\sin^2\theta_1", r"\sin^{2}{\left(\theta_{1} \right)}",
                      "s1^2", "s1**2", "sθ1²", "s²θ1", r"s^2\theta_1", "s²(θ1)", "s(theta1)**2"],
    "sin(theta1)*cos(theta2)": ["sin theta1 cos theta2", "s1c2", r"\sin\theta_1\cos\theta_2", "sinθ1cosθ2", "sθ1cθ2",
                                "Sθ1 Cθ2", "s_θ1 c_θ2", "stheta1*ctheta2", r"s\theta_1c\theta_2", "s(θ1)c(θ2)",
                                "st1ct2"],
    "sqrt(a1)": ["√(a1)", "√a1", "√ a_1", r"\sqrt{a_1}", "a1^(1/2)"], "a1^(1/3)": [r"\sqrt[3]{a_1}"],
    "cos(theta1) + I*sin(theta1)": ["e^(i*theta1)", "exp(j*theta1)", r"e^{i\theta_1}"],
    "1/sin(theta1)": ["sin(theta1)**-1", "sin(theta1)^{-1}", "csc(theta1)"],
    "asin(a1/40)": ["arcsin(a1/40)", r"\sin^{-1}(a_1/40)", r"\arcsin\left(\frac{a_1}{40}\right)", "np.arcsin(a1/40)"],
    "sin(2*theta1)": ["sin 2 theta1", "sin(2θ1)", r"\sin 2\theta_1"],
}  # fmt: skip


def test_joint_rates_are_parsed_without_known_symbols() -> None:
    for text in WRITINGS["qd1"]:
        assert parse_formula(text).value == "qd1", text


@pytest.mark.parametrize("reference", [POSITION, *WRITINGS])
def test_formula_is_accepted_in_any_notation(reference: str) -> None:
    for text in WRITINGS.get(reference, POSITIONS):
        judged = judge_expression(text, reference, DOMAIN, "s")
        assert judged.outcome is Outcome.CORRECT, (text, judged.reason)


MATRICES = [
    r"\begin{bmatrix} a_1 & 0 \\ 0 & c_{12} \end{bmatrix}",
    r"\left[\begin{matrix}a_{1} & 0\\0 & \cos{\left(\theta_{1} + \theta_{2} \right)}\end{matrix}\right]",
    r"\begin{array}{cc} a_1 & 0 \\ 0 & c_{12} \\ \end{array}",
    "[a1, 0; 0, c12]", "np.array([[a1,0],[0,c12]])", "Matrix(2,2,[a1,0,0,c12])", "diag(a1,c12)", "[a1,0],[0,c12]",
    "((a1,0),(0,c12))", "[[a1, 0],\n [0, c12]]", "{a1,0;0,c12}", "{{a1,0},{0,c12}}", "J = Matrix([[a1, 0], [0, c12]])",
]  # fmt: skip


def test_matrix_is_accepted_in_any_notation() -> None:
    for text in MATRICES:
        judged = judge_matrix(text, [["a1", "0"], ["0", "cos(theta1+theta2)"]], DOMAIN, "s")
        assert judged.outcome is Outcome.CORRECT, (text, judged.reason)


REFUSED = [
    ("sin theta1/2", "expected '(' after sin"), ("sin theta1^2", "expected '(' after sin"),
    ("sin", "expected '(' after sin"), ("1 000*a1", "there is no operator between two numbers"),
    ("1.2.3", "there is no operator between two numbers"), ("a1.2", "the point in .2 can be a product"),
    ("a1.foo(2)", "the function 'a1.foo' is unknown"), ("a1 | s2 | a2", "found an alternative"),
    ("12.37 %", "percentages are not allowed; write a decimal"), ("a1|s2", "found an alternative"),
    ("sin 2 3", "there is no operator between two numbers"),
    ("C(a1)", "C means cos only before an angle"), ("S(1)/2", "write sin(…)"), ("sθ1 + θ2", "may or may not belong"),
    ("sin theta1cos(theta2)", "expected '(' after sin"), ("s*theta1", "'s' is not a symbol"),
    ("sin1", "'sin1' is not a symbol"), (r"\foo{a1}", "is unknown"), (r"\frac{a1}", ""),
    (r"\begin{align}a1", ""), ("x" * 70, "a name of 70 characters"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "message"), REFUSED)
def test_ambiguous_or_meaningless_formula_is_refused(text: str, message: str) -> None:
    judged = judge_expression(text, "sin(theta1/2)", DOMAIN, "s")
    assert judged.outcome is Outcome.WRONG
    assert message in judged.reason


MANY = select_for_suite(8_000, 40_000)
HOSTILE = [
    " " * 200_000 + "x", "a1" + " " * 200_000 + "! ", "\n" * 100_000 + "$a1", "\\frac" * 3000, "\\frac{" * 3000,
    "{" * 20000, "\\sqrt[" * 3000, "\\begin{matrix}" * 2000, "_" * 5000, "^" * 5000, "_{" * 5000, "\\dot" * 5000,
    "a1c12" * 4000, "s1" * 20000, "cos" * 5000, "½" * 9000, "²" * 9000, "°" * 9000, "θ̇" * 9000, "[;" * 9000,
    "[" + ";" * 20000 + "]", "\ud800", "\x00", "a1" + "\u0307" * 500, "$" * 9000, "sin^" * 4000, "sin " * 4000,
    "Matrix(9**9,9**9,[1])", "Matrix(0,0,[])", "atan2a1", "diag(" + "a1," * 3000 + ")",
    "Lambda(x, " + "1+" * 5000 + "x)", "1e-400+" * MANY + "1", "sin(9e399" + "*9e399" * MANY + ")",
    "sqrt(" + "+".join(f"1/{10**12 + k}" for k in range(MANY // 2)) + ")", "t1" * 30, "theta1.diff(" * 3000,
]  # fmt: skip


@pytest.mark.parametrize("text", sample_for_suite(HOSTILE, 6), ids=lambda text: ascii(text[:12]))
def test_hostile_formula_ends_in_a_verdict(text: str) -> None:
    assert judge_expression(text, "a1", DOMAIN, "s").outcome in (Outcome.WRONG, Outcome.MISSING)
    assert judge_matrix(text, [["a1", "0"]], DOMAIN, "s").outcome in (Outcome.WRONG, Outcome.MISSING)


_SUM = "+".join(f"sin({k}*theta1 + theta2^2)" for k in range(1, 330))
_MANY = " or ".join("+".join(f"sin({k}*theta1+{i}*theta2)" for k in range(2, 9)) for i in range(2, 22))
LONG = [
    "theta2 = " + "a1+" * 3000 + "a1", "theta2 = k*pi" + "+a1" * 3000, "a1+" * 3000 + "cos(theta1) = 0",
    "{theta2: [" + "pi*(k+n)," * MANY + "0]}", "{" + "k+n+m," * MANY + "0}", "k*theta1 + n = m", f"{_SUM} = k",
    f"({_MANY}) and ({_MANY.replace('sin', 'cos')})", "theta1 = 0 or " * MANY + "theta1 = 0",
    "+".join(f"{k}*theta1^{k}" for k in range(1, 500, 9)) + " = 1",
    "cos(theta1) + log(theta2/0) = 1",
]  # fmt: skip


@pytest.mark.parametrize("text", sample_for_suite(LONG, 4), ids=lambda text: text[:12])
def test_hostile_condition_ends_in_a_verdict(text: str) -> None:
    judged = judge_singular(text, ["sin(theta2) = 0"], ["theta1", "theta2"], DOMAIN, "s")
    assert judged.outcome is Outcome.WRONG


WHOLE_TURNS = [
    "theta2 = pi*m", "theta2 = m*pi", "theta2 = pi m", "theta2 in {pi*m}", "{theta2: pi*m}",  # not metres
    "theta2 = k*n*m*pi", "theta2 in {" + ",".join(f"{k}*k*pi" for k in range(300)) + "}",
]  # fmt: skip


@pytest.mark.parametrize("text", WHOLE_TURNS, ids=lambda text: text[:20])
def test_integer_multiples_are_accepted_in_any_notation(text: str) -> None:
    judged = judge_singular(text, ["sin(theta2) = 0"], ["theta1", "theta2"], DOMAIN, "s")
    assert judged.outcome is Outcome.CORRECT, judged.reason


def test_symbols_of_the_problem_take_precedence_over_habits() -> None:
    known = frozenset({"c1", "q1", "e", "m", "theta12", "theta1", "theta2"})
    assert all(split_name(name, known)[0].names == (name,) for name in known)
    assert to_plain_text("c1*2 m", known) == "c1*2 m" and to_plain_text("pi*m", set()) == "pi*m"
    assert parse_formula("e*m", known).args[0].value == "e"


def test_names_are_split_only_at_dots_without_a_problem() -> None:
    assert parse_formula("a1a2").value == "a1a2"
    assert parse_formula("a1.a2.sin(theta2)") == parse_formula("a1*a2*sin(theta2)")
    assert parse_formula("a1.foo").value == "a1.foo"


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("[a1; a2]", "[[a1], [a2]]"), ("[a1, a2; a3, 0]", "[[a1, a2], [a3, 0]]"), ("a1; a2", "[a1, a2]"),
        ("a1, a2; a3, 0", "[[a1, a2], [a3, 0]]"), ("[a1, a2]^T", "[a1, a2]"), ("[[a1, a2]].T", "[[a1], [a2]]"),
        ("Matrix([[a1, a2]]).T", "[[a1], [a2]]"), ("transpose([[a1, a2]])", "[[a1], [a2]]"),
        ("[a1; a2]'", "[[a1, a2]]"), ("x: a1, y: a2", "{x: a1, y: a2}"), ("{'x': a1, \"y\": a2}", "{x: a1, y: a2}"),
        (r"[{\theta_2: 0}, {\theta_{2}(t): \pi}]", "[{theta2: 0}, {theta2: pi}]"),
        ("{theta_{2}: {0, pi}}", "{theta2: (0, pi)}"),
        (r"{\dot{\theta}_1: \frac{v_x}{a_1}, Derivative(\theta_{2}(t), t): 0}", "{qd1: (vx/a1), qd2: 0}"),
        ("x = a1\ny = a2", "x = a1, y = a2"), ("a1 cos 30°", "a1*cos(30*pi/180)"), ("2 sin 45 deg", "2*sin(45*pi/180)"),
        ("kπ", "k*pi"), ("2kπ", "2*(k*pi)"), ("theta2 = 0 or pi", "theta2 = {0, pi}"),
        ("theta2 = 0 and pi", "theta2 = {0, pi}"), ("theta2 = ±pi/2", "theta2 = {pi/2, -(pi/2)}"),
        ("theta2 = +/- pi", "theta2 = {pi, -pi}"), ("theta2 = +-pi", "theta2 = {pi, -pi}"),
        ("{theta2: [0, +- pi]}", "{theta2: [0, {pi, -pi}]}"), ("[a1+-a2, 1]", "[a1 + (-a2), 1]"),
        ("theta2 = 0 or pi and theta3 = 0 or pi", "And(theta2 = {0, pi}, theta3 = {0, pi})"),
        ("[theta1; theta2] = [0; pi]", "And(theta1 = 0, theta2 = pi)"), ("[theta2] = [0, pi]", "theta2 = [0, pi]"),
        ("theta2 % pi = 0", "theta2 + k*pi = 0"), ("theta2 = %pi", "theta2 = pi"), ("{theta2 => 0}", "{theta2 = 0}"),
        ("0 = sin(theta2) ==> theta2 = 0|pi", "Or(0 = sin(theta2), theta2 = {0, pi})"),
        (r"\begin{aligned} x &= a_1 \\ &+ a_2 \\ y &= a_2 \end{aligned}", "x = a1 + a2, y = a2"),
        ("x(θ) = a1, y(θ) = a2", "x = a1, y = a2"), ("x = a1 [m], y = a2 (m)", "x = a1, y = a2"),
        ("{}^{0}p = [a1, a2]", "p = [a1, a2]"), ("⁰p = [a1, a2]", "p = [a1, a2]"),
        ("theta2 = k*pi with k ∈ ℤ", "theta2 = k*pi, k in Z"), ("theta2 = k*pi for all k", "theta2 = k*pi, k in Z"),
        ("for all theta1, theta2 = 0", "theta2 = 0"), ("P = [x; y] = (a1, a2)", "And(x = a1, y = a2)"),
        ("[[a1], [a2]] = 2 [x, y]^T", "And(a1 = 2*x, a2 = 2*y)"), ("[a1 + 1, a2] = [x; y]", "And(x = a1 + 1, a2 = y)"),
        ("J(q) = [a1, a2]", "J = [a1, a2]"), ("theta2 = 0 or theta3 = 0", "Or(theta2 = 0, theta3 = 0)"),
        ("theta2 = 0 mod pi", "theta2 = 0 + k*pi"),
        ("theta2 = 0 (mod 2*pi)", "theta2 = 0 + k*(2*pi)"), ("d3 = -0.25 m", "d3 = -0.25"),
        ("d3 = 25 cm", "d3 = 25/100"), ("[theta1 = 30 deg, theta2 = pi rad]", "[theta1 = 30*pi/180, theta2 = pi]"),
        ("ConditionSet(theta2, Eq(sin(theta2), 0), Reals)", "sin(theta2) = 0"),
        ("Contains(theta2, {0, pi})", "theta2 in {0, pi}"),
        ("theta2 = -45°\ntheta2 = 135°", "theta2 = -45°; theta2 = 135°"),
        ("d3 = -0.2 m.\nsin(theta2) = 0", "d3 = -0.2, sin(theta2) = 0"), ("theta2 = 0\nor pi", "theta2 = 0 or pi"),
        ("0 = sin(theta2)*a1\n = 0", "0 = sin(theta2)*a1 = 0"), ("theta2 = 0°\nθ3 ∈ {0}", "theta2 = 0°; theta3 in {0}"),
        ("d3 = -0.2 m or theta2 = m*pi", "d3 = -0.2 or theta2 = m*pi"), ("theta2 = k 180°", "theta2 = k*(180°)"),
        ("theta2 = (2 m + 1) pi/2", "theta2 = (2*m + 1)*pi/2"),
        ("d3 = -20 cm or theta2 = 0", "d3 = -20/100 or theta2 = 0"),
        ("d3 = 0.2 metres or theta2 = 0", "d3 = 0.2 or theta2 = 0"),
        ("[(d3 - 0.2 m)*c1, 1/5 m s1 + a1 m]", "[(d3 - 0.2)*c1, 1/5*s1 + a1]"), ("P = (a1, a2) m", "P = (a1, a2)"),
        ("0.3 m^2 sin(theta1) + 20 cm*a1", "0.3*sin(theta1) + 20/100*a1"), ("theta2 = pi/2 m", "theta2 = pi/2*m"),
    ],
)  # fmt: skip
def test_equivalent_notations_parse_alike(text: str, same: str) -> None:
    assert parse_formula(text, DOMAIN.roles) == parse_formula(same, DOMAIN.roles)


def test_name_after_number_is_a_factor_inside_a_product() -> None:
    """A unit at the end of a product can elsewhere be a symbol of the problem or an integer variable."""
    assert parse_formula("a1 m*a2", DOMAIN.roles) == parse_formula("a1*m*a2", DOMAIN.roles)
    assert parse_formula("pi m", DOMAIN.roles) == parse_formula("pi*m", DOMAIN.roles)
    assert parse_formula("[2 m]", {"m"}) == parse_formula("[2*m]", {"m"})


def test_equal_symbols_of_long_sums_are_collected() -> None:
    long = POSITION + " + a1 - a1" * 300 + " - a2*2" + " - a2" * 200 + " + a2*202 + theta3 - theta3"
    assert judge_expression(long, POSITION, DOMAIN, "s").outcome is Outcome.CORRECT
    assert judge_expression(long + " + a1", POSITION, DOMAIN, "s").outcome is Outcome.WRONG
    assert "'k' is not a symbol" in judge_expression(long + " + k", POSITION, DOMAIN, "s").reason
    assert parse_formula("[" + "a1 + " * 150 + "a1, 0]", {"a1"}).args[1] == parse_formula("0")
