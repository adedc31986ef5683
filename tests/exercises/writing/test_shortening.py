"""Formulas in other forms: names of angles, sums of sines and cosines that are one of them, gather_sums products."""

import re
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Base, Chain, Joint
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.generation import generate, sample_chain
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.reference_answers import Expression, Matrix
from qdot.exercises.writing import shortening
from qdot.exercises.writing.angles import iterate_arm_angles, name_angles, needs_name
from qdot.exercises.writing.latex import tex
from qdot.exercises.writing.problem_texts import write_answer_code, write_solution, write_solutions
from qdot.exercises.writing.shortening import factor_sums, multiply_numbers, remove_constant_shifts, use_angle_sums
from qdot.exercises.writing.solution_steps import SolutionSteps
from tests.support.problems import LONG_ARMS, select_parts
from tests.support.suites import few_families, sample_for_suite

T1, T2, T3, A1, A2, A3, D1, D2 = sp.symbols("theta1 theta2 theta3 a1 a2 a3 d1 d2")
R1, R2, R3 = sp.symbols("qd1 qd2 qd3")
S, C, SIXTH, ROOT, HALF = sp.sin, sp.cos, sp.pi / 6, sp.sqrt(3), sp.Rational(1, 2)
ANGLE = T2 + T3 + SIXTH


@pytest.mark.parametrize(
    ("long", "short"),
    [
        (ROOT * C(ANGLE) / 4 + S(ANGLE) / 4, C(T2 + T3) / 2),
        (3 * C(ANGLE) / 4 + ROOT * S(ANGLE) / 4, ROOT * C(T2 + T3) / 2),
        (C(T3 + SIXTH) / 4 - ROOT * S(T3 + SIXTH) / 4, -S(T3) / 2),
        (A1 * (C(T2) * (ROOT * C(ANGLE) + S(ANGLE)) + D1), A1 * (2 * C(T2) * C(T2 + T3) + D1)),
        (D1 * ROOT * C(ANGLE) * S(T1) + D1 * S(ANGLE) * S(T1), 2 * D1 * C(T2 + T3) * S(T1)),
        (C(T2) + ROOT * S(T2), None),  # no constant: it would need a name
        (C(T1 - T2 + SIXTH) * ROOT + S(T1 - T2 + SIXTH), None),  # as would this
        (A1 * C(ANGLE) + S(ANGLE), None),
        (2 * C(ANGLE) + S(ANGLE), None),
    ],
)
def test_a_constant_that_only_splits_a_sine_is_left_out(long: sp.Expr, short: sp.Expr | None) -> None:
    assert remove_constant_shifts(long) == (long if short is None else short)


def test_a_sum_without_equal_remainders_is_not_expanded(monkeypatch: pytest.MonkeyPatch) -> None:
    """Expanding is slow, and takes much of the time of solutions."""
    monkeypatch.setattr(shortening, "_expand_shift", pytest.fail)
    total = 2 * R1 * A1 * C(ANGLE) + R2 * A1 * S(ANGLE) - D1 * R1 * C(ANGLE) + R1 * A2 * S(T2 + SIXTH)
    assert remove_constant_shifts(total) == total


@pytest.mark.parametrize(
    ("long", "short"),
    [
        (C(T1) * C(T2) + S(T1) * S(T2), C(T1 - T2)), (C(T1) * C(T1 + T2) + S(T1) * S(T1 + T2), C(T2)),
        (A1 * (S(T1) * C(T1 + T2) - C(T1) * S(T1 + T2)), -A1 * S(T2)),
        (C(T1) * C(T2) - S(T1) * S(T2), C(T1 + T2)),
        (A1 * C(T1) * C(T2) - A1 * S(T1) * S(T2), A1 * C(T1 + T2)),
        (S(T1) * C(T2) + C(T1) * S(T2), S(T1 + T2)), (S(T1) * C(T2) - C(T1) * S(T2), S(T1 - T2)),
        (S(ANGLE) * S(T3 + SIXTH) + C(ANGLE) * C(T3 + SIXTH), C(T2)),
        (A1 * C(T1) * C(T2) - D1 * S(T1) * S(T2), None), (C(T1) * C(T2) + C(T1) * S(T2), None),
    ],
)  # fmt: skip
def test_the_addition_theorems(long: sp.Expr, short: sp.Expr | None) -> None:
    assert use_angle_sums(long, lambda angle: False) == long, "no angle comes in that has no name"
    if short is None:
        assert use_angle_sums(long, lambda angle: True) == long
        return
    assert sp.expand(use_angle_sums(long, lambda angle: True) - short) == 0


def test_numbers_are_multiplied_out_where_that_is_shorter() -> None:
    number = sp.Rational(9, 80) + ROOT / 40 - (sp.Rational(1, 20) - 9 * ROOT / 40) * ROOT / 2
    assert multiply_numbers(number) == sp.Rational(9, 20)
    assert multiply_numbers(D1 + number) == D1 + sp.Rational(9, 20)
    assert multiply_numbers(ROOT * (D1 + HALF)) == ROOT * (D1 + HALF)


@pytest.mark.parametrize(
    "problem_id", sample_for_suite(["wrist-rpy/745@zeros@screws", "elbow-lateral/295@full@screws"], 1)
)
def test_what_is_shown_of_screws_is_equal_to_the_reference_and_short(problem_id: str) -> None:
    names = ("home-screws", "body-pose", "body-jacobian", "body-twist")
    problem = generate(problem_id, [name for name in names if (name, problem_id[:5]) != ("body-pose", "wrist")])
    space = {name: getattr(sp, name) for name in ("Matrix", "Rational", "sin", "cos", "sqrt", "pi")}
    stream = Stream("shortening")
    for part in problem.parts:
        assert isinstance(part.answer, Matrix)
        reference = part.answer.reference
        symbols = sorted(reference.free_symbols, key=str)
        # Our own text.
        shown = eval(write_answer_code(problem, part), {**space, **{symbol.name: symbol for symbol in symbols}})
        at = [stream.uniform(0.2, 2) for _ in symbols]
        ours, theirs = (np.array(sp.lambdify(symbols, m)(*at), dtype=float) for m in (shown, reference))
        assert np.allclose(ours, theirs, atol=1e-12), part.name
        assert not re.search(r"\\sqrt\{3\}[^&]*\\cos[^&]*0\.25 \\sin", write_solution(problem, part)), part.name


def same(first: sp.Expr, second: sp.Expr, seed: str) -> bool:
    symbols = sorted(first.free_symbols | second.free_symbols, key=str)
    stream = Stream(seed)
    values = [[stream.uniform(-2, 2) for _ in symbols] for _ in range(3)]
    here, there = ([float(sp.lambdify(symbols, e)(*each)) for each in values] for e in (first, second))
    return bool(np.allclose(here, there, atol=1e-9))


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        (
            A2 * sp.cos(T1) * sp.cos(T2) + A3 * sp.cos(T1) + D2 * sp.sin(T1),
            (A2 * sp.cos(T2) + A3) * sp.cos(T1) + D2 * sp.sin(T1),
        ),
        (sp.sin(T1) * R2 + sp.sin(T1) * R3, sp.sin(T1) * (R2 + R3)),
        (sp.sin(T1) * R2 - sp.sin(T1) * R3, sp.sin(T1) * (R2 - R3)),
        (A2 * sp.cos(T1) + A3 * sp.cos(T1 + T2), A2 * sp.cos(T1) + A3 * sp.cos(T1 + T2)),  # each link by its own angle
        (sp.cos(T1) * R1 + sp.cos(T1) * A2 * R2, sp.cos(T1) * R1 + sp.cos(T1) * A2 * R2),  # two rates, two coefficients
        (sp.cos(T1) * A2 + D2, sp.cos(T1) * A2 + D2),
    ],
)
def test_sums_are_gathered(written: sp.Expr, expected: sp.Expr) -> None:
    assert factor_sums(sp.expand(written)) == expected


@few_families
def test_values_stay_and_products_become_fewer(family: str) -> None:
    for step in ("chapter", "full"):
        chain = sample_chain(ProblemId(family, 0, variation=step))
        d = derive(chain)
        for entry in (*d.position, *d.jacobian, *d.geometric_jacobian * sp.Matrix(d.chain.rates)):
            shorter = factor_sums(entry)
            assert same(entry, shorter, f"{family} {entry}")
            assert sp.count_ops(shorter) <= sp.count_ops(entry)


RIGHT, THIRD = sp.pi / 2, sp.pi / 3
CALL = re.compile(r"\\(?:sin|cos)(?:\^\{\d+\})?(?:\\left)?\((?:[^()]|\([^()]*\))*\)")
"""A sine or cosine of something without a name."""


def are_alike(one: sp.Expr, other: sp.Expr) -> bool:
    """Return whether the sine and cosine of one angle are, up to signs, those of another."""
    return any((2 * sp.expand(one - sense * other) / sp.pi).is_Integer for sense in (1, -1))


@pytest.fixture
def problem(problem: Problem) -> Problem:
    """The problem of a sweep, of long arms with the parts of which it is the turn."""
    return replace(problem, parts=tuple(select_parts(problem))) if problem.id.family in LONG_ARMS else problem


def test_every_angle_has_one_name_and_no_plain_one_has_any(problem: Problem) -> None:
    meanings = SolutionSteps(problem.chain).angles.angle_by_name
    assert not any(are_alike(one, other) for one, other in combinations(meanings.values(), 2))
    assert all(map(needs_name, meanings.values()))


def test_solutions_say_angles_by_their_names_only_and_in_degrees(problem: Problem) -> None:
    for name, text in write_solutions(problem).items():
        assert r"\pi}" not in text and not re.search(r"\\theta[^$]*\\pi", text), name
        said = re.sub(r"^(?:In what follows, l|L)et .*", "", text)  # where it is said what names stand for
        unnamed = [call for call in CALL.findall(said) if r"\theta_{" in call]
        # In the configuration that is asked about, some joints are put to values, which gives sums of their own.
        assert name == "lost-direction" or not unnamed, (name, unnamed)


def test_names_are_said_before_they_are_used_and_mean_the_same_in_all_parts(problem: Problem) -> None:
    meanings: dict[str, str] = {}
    whole = "".join(write_solutions(problem).values())
    for name, text in ((part.name, write_solution(problem, part)) for part in problem.parts):
        first = text.split("\n\n")[0]
        said = dict(re.findall(r"\$(\\varphi'*_\{\d+\}) = ([^$]*)\$", first))
        assert set(re.findall(r"\\varphi'*_\{\d+\}", text)) == set(said), name
        assert all(meanings.setdefault(name, angle) == angle for name, angle in said.items()), name
        short = re.findall(r"(?<![A-Za-z\\])[cs]_\{(\d+)\}", text)
        assert (r"$c_i = \cos\theta_i$" in first) == any(len(digits) == 1 for digits in short), name
        assert (r"c_{ij \dots}" in first) == any(len(digits) > 1 for digits in short), name
    assert all(whole.count(f"${name} = {angle}$") == 1 for name, angle in meanings.items())


def test_code_means_the_reference(problem: Problem) -> None:
    space = {name: getattr(sp, name) for name in ("Matrix", "Rational", "sin", "cos", "sqrt", "atan", "acos", "pi")}
    for part in problem.parts:
        if not isinstance(part.answer, (Expression, Matrix)):
            continue
        reference = sp.Matrix([part.answer.as_matrix()])
        symbols = {symbol.name: symbol for symbol in reference.free_symbols}
        value = sp.Matrix([eval(write_answer_code(problem, part), {**space, **symbols})])  # our own text, in a test
        at = {symbols[name]: sp.Float(0.3 + 0.17 * i, 30) for i, name in enumerate(sorted(symbols))}
        difference = (value - reference.reshape(*value.shape)).xreplace(at)
        assert max((abs(entry) for entry in difference.evalf(30)), default=0) < 1e-11, part.name


def planar(*thetas: sp.Expr, alphas: tuple[sp.Expr, ...] = (), base: Base | None = None) -> Chain:
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
def test_names_stand_for_the_angles_of_the_links(chain: Chain, meanings: dict[str, sp.Expr]) -> None:
    names = name_angles(iterate_arm_angles(chain)).angle_by_name
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
    assert tex(expression, None, name_angles([T1 + 5 * sp.pi / 6])) == shown
