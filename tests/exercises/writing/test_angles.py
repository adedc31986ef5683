"""Angles in solutions: one name for each, and no other way to say it; in degrees; said once in a text on all parts."""

import re
from dataclasses import replace
from itertools import combinations

import pytest
import sympy as sp

from exercises import generate, show
from exercises.answers import Expression, Matrix
from exercises.arm.chain import Base, Chain, Joint
from exercises.problem import Problem
from exercises.writing.angles import angle_names, arm_angles, is_plain
from exercises.writing.gathering import gathered
from exercises.writing.latex import tex
from exercises.writing.statement import answer_code, worked_solution, worked_solutions
from exercises.writing.worked import Worked
from tests.support.problems import LONG_ARMS, parts_in_turn

T1, T2, T3, A1 = sp.symbols("theta1 theta2 theta3 a1")
S, C = sp.sin, sp.cos
RIGHT, THIRD = sp.pi / 2, sp.pi / 3
CALL = re.compile(r"\\(?:sin|cos)(?:\^\{\d+\})?(?:\\left)?\((?:[^()]|\([^()]*\))*\)")
"""A sine or cosine of something without a name."""


def are_alike(one: sp.Expr, other: sp.Expr) -> bool:
    """Return whether the sine and cosine of one angle are, up to signs, those of another."""
    return any((2 * sp.expand(one - sense * other) / sp.pi).is_Integer for sense in (1, -1))


@pytest.fixture
def problem(problem: Problem) -> Problem:
    """The problem of a sweep, of long arms with the parts of which it is the turn."""
    return replace(problem, parts=tuple(parts_in_turn(problem))) if problem.id.family in LONG_ARMS else problem


def test_every_angle_has_one_name_and_no_plain_one_has_any(problem: Problem) -> None:
    meanings = Worked(problem.chain).angles.meanings
    assert not any(are_alike(one, other) for one, other in combinations(meanings.values(), 2))
    assert not any(map(is_plain, meanings.values()))


def test_solutions_say_angles_by_their_names_only_and_in_degrees(problem: Problem) -> None:
    for name, text in worked_solutions(problem).items():
        assert r"\pi}" not in text and not re.search(r"\\theta[^$]*\\pi", text), name
        said = re.sub(r"^(?:In what follows, l|L)et .*", "", text)  # where it is said what names stand for
        unnamed = [call for call in CALL.findall(said) if r"\theta_{" in call]
        # In the configuration that is asked about, some joints are put to values, which gives sums of their own.
        assert name in ("lost-direction", "lost-motion") or not unnamed, (name, unnamed)


def test_names_are_said_before_they_are_used_and_mean_the_same_in_all_parts(problem: Problem) -> None:
    meanings: dict[str, str] = {}
    whole = "".join(worked_solutions(problem).values())
    for name, text in ((part.name, worked_solution(problem, part)) for part in problem.parts):
        first = text.split("\n\n")[0]
        said = dict(re.findall(r"\$(\\varphi'*_\{\d+\}) = ([^$]*)\$", first))
        assert set(re.findall(r"\\varphi'*_\{\d+\}", text)) == set(said), name
        assert all(meanings.setdefault(name, angle) == angle for name, angle in said.items()), name
        short = re.findall(r"(?<![A-Za-z\\])[cs]_\{(\d+)\}", text)
        assert (r"$c_i = \cos\theta_i$" in first) == any(len(digits) == 1 for digits in short), name
        assert bool(re.search(r"\$[cs]_\{\d\d+\} = \\(cos|sin)\(", first)) == any(len(d) > 1 for d in short), name
        # One sum in short is an example, where there are others.
        others = set(re.findall(r"(?<![A-Za-z\\])[cs]_\{\d\d+\}", text)) - set(re.findall(r"[cs]_\{\d\d+\}", first))
        assert first.endswith(", and so on.") == bool(others), (name, first, others)
    assert all(whole.count(f"${name} = {angle}$") == 1 for name, angle in meanings.items())


def test_code_means_the_reference(problem: Problem) -> None:
    space = {name: getattr(sp, name) for name in ("Matrix", "Rational", "sin", "cos", "sqrt", "atan", "acos", "pi")}
    for part in problem.parts:
        if not isinstance(part.answer, (Expression, Matrix)):
            continue
        reference = sp.Matrix([part.answer.as_matrix()])
        symbols = {symbol.name: symbol for symbol in reference.free_symbols}
        value = sp.Matrix([eval(answer_code(problem, part), {**space, **symbols})])  # our own text, in a test
        at = {symbols[name]: sp.Float(0.3 + 0.17 * i, 30) for i, name in enumerate(sorted(symbols))}
        difference = (value - reference.reshape(*value.shape)).xreplace(at)
        assert max((abs(entry) for entry in difference.evalf(30)), default=0) < 1e-11, part.name


def planar(*thetas: sp.Expr, alphas: tuple[sp.Expr, ...] = (), base: Base | None = None) -> Chain:
    """Return a planar arm with these angles in its table."""
    twists = [*alphas, *[sp.S.Zero] * (len(thetas) - len(alphas))]
    rows = zip(thetas, twists, strict=True)
    joints = tuple(Joint("R", theta, sp.S.Zero, sp.Symbol(f"a{i}"), alpha) for i, (theta, alpha) in enumerate(rows, 1))
    return Chain("arm", joints, ("vx", "vy"), base or Base())


@pytest.mark.parametrize(
    ("chain", "meanings"),
    [
        (planar(T1, T2), {}),
        (planar(T1 + RIGHT, T2 - RIGHT), {}),  # quarter turns are worked out
        (planar(T1, T2, base=Base(yaw=RIGHT)), {}),
        (planar(T1 + THIRD, T2 + THIRD), {"1": T1 + THIRD, "12": T1 + T2 + 2 * THIRD, "2": T2 + THIRD}),
        (planar(T1, T2, alphas=(sp.pi,)), {"12": T1 - T2}),
        (planar(T1, T2, base=Base(yaw=THIRD)), {"1": T1 + THIRD, "12": T1 + T2 + THIRD}),
    ],
)
def test_zeros_senses_and_a_turned_base_are_in_the_angle_of_the_link(
    chain: Chain, meanings: dict[str, sp.Expr]
) -> None:
    names = angle_names(arm_angles(chain)).meanings
    assert {str(name): meaning for name, meaning in names.items()} == {
        rf"\varphi_{{{links}}}": meaning for links, meaning in meanings.items()
    }


@pytest.mark.parametrize(
    ("expression", "shown"),
    [
        (A1 * C(T1 + 5 * sp.pi / 6), r"a_{1} \cos \varphi_{1}"),
        (A1 * S(-T1 - 5 * sp.pi / 6), r"-a_{1} \sin \varphi_{1}"), (A1 * S(T1 + THIRD), r"-a_{1} \cos \varphi_{1}"),
        (S(2 * T1 + 5 * sp.pi / 3), r"\sin(2 \varphi_{1})"), (C(T1), "c_{1}"),
        (C(T1 + sp.pi / 4), r"\cos(\theta_{1} + 45^\circ)"),
    ],
)  # fmt: skip
def test_an_angle_is_known_in_every_form_that_sympy_gives_it(expression: sp.Expr, shown: str) -> None:
    assert tex(expression, None, angle_names([T1 + 5 * sp.pi / 6])) == shown


def test_a_text_on_a_whole_problem_says_the_names_once() -> None:
    problem = generate("stanford-6r/1@full", ["position", "jacobian"])
    counts = [show(problem, True, form).count("In what follows, let") for form in ("text", "latex", "html", "ipynb")]
    assert counts == [1] * 4 and "In what follows, let" not in show(problem, False, "text")


def test_names_are_put_in_as_if_every_formula_came_by_itself(problem: Problem) -> None:
    """What a part of a formula becomes is kept, and is the same in every formula."""
    worked = Worked(problem.chain)
    names = worked.angles
    for entry in (*worked.d.geometric, *worked.d.position, *worked.d.geometric):
        trigs = {trig: names._said(trig) for trig in entry.atoms(sp.sin, sp.cos)}
        assert names.put_into(entry) == gathered(entry.xreplace(trigs))
    assert names.put_into(worked.d.geometric) == worked.d.geometric.applyfunc(names.put_into)
