"""Sums of sines and cosines that are one of them: written as that one, and no value changes."""

import re

import numpy as np
import pytest
import sympy as sp

from exercises import generate
from exercises.answers import Matrix
from exercises.figure.words import alt_text
from exercises.problem import Problem
from exercises.stream import Stream
from exercises.writing.shortening import Theorem, added_up, in_plain_angles, theorem_used, with_plain_numbers
from exercises.writing.statement import answer_code, hints, worked_solution
from exercises.writing.worked import AngleSums

T1, T2, T3, A1, D1 = sp.symbols("theta1 theta2 theta3 a1 d1")
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
        (C(T2) + ROOT * S(T2), C(T2) + ROOT * S(T2)),  # no constant: it would need a name
        (
            C(T1 - T2 + SIXTH) * ROOT + S(T1 - T2 + SIXTH),
            C(T1 - T2 + SIXTH) * ROOT + S(T1 - T2 + SIXTH),
        ),  # as would this
        (A1 * C(ANGLE) + S(ANGLE), A1 * C(ANGLE) + S(ANGLE)),
        (2 * C(ANGLE) + S(ANGLE), 2 * C(ANGLE) + S(ANGLE)),
    ],
)
def test_a_constant_that_only_splits_a_sine_is_left_out(long: sp.Expr, short: sp.Expr) -> None:
    assert in_plain_angles(long) == short


@pytest.mark.parametrize(
    ("long", "short"),
    [
        (A1 * C(T1) * C(T2) - A1 * S(T1) * S(T2), A1 * C(T1 + T2)),
        (C(T1) * C(T2) + S(T1) * S(T2), C(T1 - T2)),
        (S(T1) * C(T2) - C(T1) * S(T2), S(T1 - T2)),
        (S(ANGLE) * S(T3 + SIXTH) + C(ANGLE) * C(T3 + SIXTH), C(T2)),
        (A1 * C(T1) * C(T2) - D1 * S(T1) * S(T2), A1 * C(T1) * C(T2) - D1 * S(T1) * S(T2)),
        (C(T1) * C(T2) + C(T1) * S(T2), C(T1) * C(T2) + C(T1) * S(T2)),
    ],
)
def test_the_addition_theorems(long: sp.Expr, short: sp.Expr) -> None:
    assert added_up(long, lambda angle: True) == short


def test_no_angle_comes_in_that_has_no_name() -> None:
    long = C(T1) * C(T2) + S(T1) * S(T2)
    assert added_up(long, lambda angle: False) == long


def test_numbers_are_multiplied_out_where_that_is_shorter() -> None:
    number = sp.Rational(9, 80) + ROOT / 40 - (sp.Rational(1, 20) - 9 * ROOT / 40) * ROOT / 2
    assert with_plain_numbers(number) == sp.Rational(9, 20)
    assert with_plain_numbers(D1 + number) == D1 + sp.Rational(9, 20)
    assert with_plain_numbers(ROOT * (D1 + HALF)) == ROOT * (D1 + HALF)


@pytest.mark.parametrize("problem_id", ["elbow-lateral/295@full@screws", "wrist-rpy/745@zeros@screws"])
def test_what_is_shown_of_screws_is_equal_to_the_reference_and_short(problem_id: str) -> None:
    names = ("home-screws", "body-pose", "body-jacobian", "body-twist")
    problem = generate(problem_id, [name for name in names if (name, problem_id[:5]) != ("body-pose", "wrist")])
    space = {name: getattr(sp, name) for name in ("Matrix", "Rational", "sin", "cos", "sqrt", "pi")}
    stream = Stream("shortening")
    for part in problem.parts:
        assert isinstance(part.answer, Matrix)
        reference = part.answer.reference
        symbols = sorted(reference.free_symbols, key=str)
        shown = eval(
            answer_code(problem, part), {**space, **{symbol.name: symbol for symbol in symbols}}
        )  # our own text
        at = [stream.uniform(0.2, 2) for _ in symbols]
        ours, theirs = (np.array(sp.lambdify(symbols, m)(*at), dtype=float) for m in (shown, reference))
        assert np.allclose(ours, theirs, atol=1e-12), part.name
        assert not re.search(r"\\sqrt\{3\}[^&]*\\cos[^&]*0\.25 \\sin", worked_solution(problem, part)), part.name


def problem_of(problem_id: str, *names: str) -> Problem:
    return generate(problem_id, list(names))


def test_screws_of_a_shoulder_have_a_number_where_they_have_one() -> None:
    problem = problem_of("elbow-lateral/295@full@screws", "home-screws", "body-jacobian")
    screws, body = (worked_solution(problem, part) for part in problem.parts)
    assert r"\frac{\sqrt{3}}{40}" not in screws and "0.45" in screws
    assert r"0.5 c_{23} \cos \varphi_{1}" in body and r"\sin \varphi_{23} \sin \varphi_{3}" not in body
    assert "(0.312 m, minus 0.34 m, 0.6 m plus d1)" in alt_text(problem.chain)


def test_a_wrist_has_no_name_for_an_angle_that_is_not_needed() -> None:
    problem = problem_of("wrist-rpy/745@zeros@screws", "body-jacobian")
    assert r"\varphi_{3}" not in worked_solution(problem, problem.parts[0])


# --- angles of parallel axes ---


def test_how_angles_are_put_together() -> None:
    assert AngleSums.of([T1 + T2 + SIXTH, T3]) == AngleSums(added=True, subtracted=False, neighbouring=True)
    assert AngleSums.of([T1 - T3]) == AngleSums(added=True, subtracted=True, neighbouring=False)
    assert AngleSums.of([T1, T2]) == AngleSums(added=False, subtracted=False, neighbouring=True)


OPPOSITE = "Where axes are parallel, the angles add up; where they point in opposite directions, they are subtracted."


@pytest.mark.parametrize(
    ("problem_id", "said"),
    [
        ("planar-rpr/835@frames", OPPOSITE),
        ("random-4/783@frames", OPPOSITE),
        ("scara/808@lengths", OPPOSITE),
        ("planar-2r/416@frames", "Where neighbouring axes are parallel, the angles add up. For"),
    ],
)
def test_the_rule_that_is_told_is_the_one_that_is_used(problem_id: str, said: str) -> None:
    problem = problem_of(problem_id, "transform")
    assert said in worked_solution(problem, problem.parts[0])


@pytest.mark.parametrize(("problem_id", "name"), [("planar-rpr/835@frames", "13"), ("random-4/783@frames", "14")])
def test_a_rotation_has_the_angle_that_has_a_name(problem_id: str, name: str) -> None:
    problem = problem_of(problem_id, "tool-jacobian")
    rotation = worked_solution(problem, problem.parts[0]).partition("where\n")[2].partition("$$\n\n")[0]
    assert rf"\cos \varphi_{{{name}}}" in rotation and rotation.count(r"\varphi") == 4


def test_hints_tell_of_angles_that_are_subtracted() -> None:
    problem = problem_of("scara/808@lengths", "transform")
    plan = hints(problem, problem.parts[0])[1]
    assert "are subtracted where the axes point in opposite directions, here to" in plan


# --- the theorem that a last step uses ---


@pytest.mark.parametrize(
    ("line", "result", "used"),
    [
        (C(T1) * C(T2) + S(T1) * S(T2), C(T1 - T2), Theorem("cos-", "")),
        (C(T1) * C(T1 + T2) + S(T1) * S(T1 + T2), C(T2), Theorem("cos-", "")),
        (A1 * (S(T1) * C(T1 + T2) - C(T1) * S(T1 + T2)), -A1 * S(T2), Theorem("sin-", "")),
        (C(T1) * C(T2) - S(T1) * S(T2), C(T1 + T2), Theorem("cos+", "")),
        (S(T1) * C(T2) + C(T1) * S(T2), S(T1 + T2), Theorem("sin+", "")),
        (C(T1) * C(T2) + D1, C(T1 + T2), None),
        (C(T1) * C(T2) - S(T1) * S(T2) + C(T1) * S(T2) + S(T1) * C(T2), C(T1 + T2) + S(T1 + T2), None),
    ],
)
def test_the_theorem_that_is_used(line: sp.Expr, result: sp.Expr, used: Theorem | None) -> None:
    assert theorem_used(line, result, lambda trig: trig) == used


def test_a_turn_that_names_of_angles_bring_in_is_told() -> None:
    one, both = sp.symbols(r"\varphi_{1} \varphi_{12}")
    line = C(one) * S(both) - S(one) * C(both)
    quarter, half = ({both: T1 + T2 + turn, one: T1} for turn in (sp.pi / 2, sp.pi))
    assert theorem_used(line, C(T2), lambda trig: trig.xreplace(quarter)) == Theorem("sin-", "quarter")
    line = C(one) * C(both) + S(one) * S(both)
    assert theorem_used(line, -C(T2), lambda trig: trig.xreplace(half)) == Theorem("cos-", "half")


@pytest.mark.parametrize(
    ("problem_id", "formula", "turned"),
    [
        (
            "planar-2r/416@frames",
            r"\alpha \cos\beta - \cos\alpha \sin\beta = \sin(\alpha - \beta)$, and a quarter turn",
            True,
        ),
        ("scara-rrrp/861@full", r"\cos\alpha \cos\beta + \sin\alpha \sin\beta = \cos(\alpha - \beta)$.", False),
        ("scara-prrr/815@full", r"\sin\alpha \sin\beta = \cos(\alpha - \beta)$, and a quarter turn", True),
    ],
)
def test_a_determinant_cites_the_theorem_that_it_uses(problem_id: str, formula: str, turned: bool) -> None:
    problem = problem_of(problem_id, "determinant")
    text = worked_solution(problem, problem.parts[0])
    assert formula in text and ("90^" in text.partition("The last step")[2].partition("\n")[0]) == turned
