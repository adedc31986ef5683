"""Formulas in other forms: sums of sines and cosines that are one of them, gathered products, angles by their names."""

import re

import numpy as np
import pytest
import sympy as sp

from exercises.answers import Matrix
from exercises.arm.chain import Base, Chain, Joint
from exercises.arm.derivation import derive
from exercises.figure.words import alt_text
from exercises.generation import generate, sample_chain
from exercises.problem import ProblemId
from exercises.solving import solution_text, solve
from exercises.stream import Stream
from exercises.writing.gathering import gathered
from exercises.writing.latex import tex
from exercises.writing.shortening import Theorem, added_up, in_plain_angles, theorem_used, with_plain_numbers
from exercises.writing.statement import answer_code, hints, worked_solution
from exercises.writing.turns import turns_of, with_turns
from exercises.writing.worked import AngleSums

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
    assert in_plain_angles(long) == (long if short is None else short)


@pytest.mark.parametrize(
    ("long", "short", "theorem"),
    [
        (C(T1) * C(T2) + S(T1) * S(T2), C(T1 - T2), "cos-"), (C(T1) * C(T1 + T2) + S(T1) * S(T1 + T2), C(T2), "cos-"),
        (A1 * (S(T1) * C(T1 + T2) - C(T1) * S(T1 + T2)), -A1 * S(T2), "sin-"),
        (C(T1) * C(T2) - S(T1) * S(T2), C(T1 + T2), "cos+"),
        (A1 * C(T1) * C(T2) - A1 * S(T1) * S(T2), A1 * C(T1 + T2), "cos+"),
        (S(T1) * C(T2) + C(T1) * S(T2), S(T1 + T2), "sin+"), (S(T1) * C(T2) - C(T1) * S(T2), S(T1 - T2), "sin-"),
        (S(ANGLE) * S(T3 + SIXTH) + C(ANGLE) * C(T3 + SIXTH), C(T2), "cos-"),
        (A1 * C(T1) * C(T2) - D1 * S(T1) * S(T2), None, ""), (C(T1) * C(T2) + C(T1) * S(T2), None, ""),
    ],
)  # fmt: skip
def test_the_addition_theorems(long: sp.Expr, short: sp.Expr | None, theorem: str) -> None:
    assert added_up(long, lambda angle: False) == long, "no angle comes in that has no name"
    if short is None:
        assert added_up(long, lambda angle: True) == long
        return
    assert sp.expand(added_up(long, lambda angle: True) - short) == 0
    assert theorem_used(long, short, lambda trig: trig) == Theorem(theorem, "")


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


def test_screws_of_a_shoulder_have_a_number_where_they_have_one() -> None:
    problem = generate("elbow-lateral/295@full@screws", ["home-screws", "body-jacobian"])
    screws, body = (worked_solution(problem, part) for part in problem.parts)
    assert r"\frac{\sqrt{3}}{40}" not in screws and "0.45" in screws
    assert r"0.5 c_{23} \cos \varphi_{1}" in body and r"\sin \varphi_{23} \sin \varphi_{3}" not in body
    assert "(0.312 m, minus 0.34 m, 0.6 m plus d1)" in alt_text(problem.chain)
    wrist = generate("wrist-rpy/745@zeros@screws", ["body-jacobian"])
    assert r"\varphi_{3}" not in worked_solution(wrist, wrist.parts[0])


# --- angles of parallel axes ---


def test_how_angles_are_put_together() -> None:
    assert AngleSums.of([T1 + T2 + SIXTH, T3]) == AngleSums(added=True, subtracted=False, neighbouring=True)
    assert AngleSums.of([T1 - T3]) == AngleSums(added=True, subtracted=True, neighbouring=False)
    assert AngleSums.of([T1, T2]) == AngleSums(added=False, subtracted=False, neighbouring=True)


@pytest.mark.parametrize(
    ("problem_id", "opposite"),
    [
        ("planar-rpr/835@frames", True), ("random-4/783@frames", True), ("scara/808@lengths", True),
        ("planar-2r/416@frames", False),
    ],
)  # fmt: skip
def test_the_rule_that_is_told_is_the_one_that_is_used(problem_id: str, opposite: bool) -> None:
    problem = generate(problem_id, ["transform"])
    texts = [worked_solution(problem, problem.parts[0])]
    texts += [hints(problem, problem.parts[0])[1]] * problem_id.startswith("scara")
    assert all(("opposite" in text) == ("subtracted" in text) == opposite for text in texts)


@pytest.mark.parametrize(("problem_id", "name"), [("planar-rpr/835@frames", "13"), ("random-4/783@frames", "14")])
def test_a_rotation_has_the_angle_that_has_a_name(problem_id: str, name: str) -> None:
    problem = generate(problem_id, ["tool-jacobian"])
    rotation = worked_solution(problem, problem.parts[0]).partition("where\n")[2].partition("$$\n\n")[0]
    assert rf"\cos \varphi_{{{name}}}" in rotation and rotation.count(r"\varphi") == 4


# --- the theorem that a last step uses ---


def test_no_theorem_is_told_where_none_or_two_are_used() -> None:
    two = C(T1) * C(T2) - S(T1) * S(T2) + C(T1) * S(T2) + S(T1) * C(T2)
    for line, result in ((C(T1) * C(T2) + D1, C(T1 + T2)), (two, C(T1 + T2) + S(T1 + T2))):
        assert theorem_used(line, result, lambda trig: trig) is None


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
        ("planar-2r/416@frames", r"= \sin(\alpha - \beta)", True),
        ("scara-rrrp/861@full", r"= \cos(\alpha - \beta)", False),
        ("scara-prrr/815@full", r"= \cos(\alpha - \beta)", True),
    ],
)
def test_a_determinant_cites_the_theorem_that_it_uses(problem_id: str, formula: str, turned: bool) -> None:
    problem = generate(problem_id, ["determinant"])
    line = worked_solution(problem, problem.parts[0]).partition("The last step")[2].partition("\n")[0]
    assert formula in line and ("90^" in line) == ("a quarter turn" in line) == turned


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
def test_what_is_gathered(written: sp.Expr, expected: sp.Expr) -> None:
    assert gathered(sp.expand(written)) == expected


def test_values_stay_and_products_become_fewer(family: str) -> None:
    for step in ("chapter", "full"):
        chain = sample_chain(ProblemId(family, 0, variation=step))
        d = derive(chain)
        for entry in (*d.position, *d.jacobian, *d.twist()):
            shorter = gathered(entry)
            assert same(entry, shorter, f"{family} {entry}")
            assert sp.count_ops(shorter) <= sp.count_ops(entry)


def arm(degrees: int | sp.Rational) -> Chain:
    alpha = sp.Rational(degrees) * sp.pi / 180
    joints = (Joint("R", sp.Symbol("theta1"), 0, 0, alpha), Joint("R", T2, 0, A2, 0))
    return Chain("oblique", joints, ("vx", "vy", "vz"))


@pytest.mark.parametrize(
    ("degrees", "shown"),
    [(75, ("75", "75")), (15, ("15", "15")), (105, ("75", "75")), (-75, ("75", "75")), (165, ("15", "15")),
     (72, ("72", "72")), (sp.Rational(45, 2), ("22.5", "22.5")), (54, ("54", "54"))],
)  # fmt: skip
def test_a_twist_is_said_as_the_table_has_it(degrees: int, shown: tuple[str, str]) -> None:
    chain = arm(degrees)
    (turn,) = turns_of(chain)
    cosine, sine = shown
    assert tex(sp.cos(turn) * A2, chain) == rf"\cos({cosine}^\circ) a_{{2}}"
    assert tex(sp.sin(turn) * A2, chain) == rf"\sin({sine}^\circ) a_{{2}}"


def test_no_root_is_left_of_it_in_a_whole_derivation() -> None:
    text = solution_text(solve(arm(75)))
    assert "cos(75°)" in text
    assert "15°" not in text
    assert "√" not in text


def test_angles_that_are_in_no_table_are_said_by_fifteen_degrees() -> None:
    assert tex(sp.cos(5 * sp.pi / 12) * A2) == r"\sin(15^\circ) a_{2}"
    assert tex(sp.cos(5 * sp.pi / 12) * A2, arm(90)) == r"\sin(15^\circ) a_{2}"


def test_base_and_zeros_of_joints_count_as_the_table_does() -> None:
    joints = (Joint("R", sp.Symbol("theta1") + 5 * sp.pi / 12, 0, A2, 0), Joint("P", sp.pi / 5, sp.Symbol("d2"), 0, 0))
    chain = Chain("turned", joints, ("vx",), Base(yaw=-3 * sp.pi / 8, tilt=sp.pi))
    assert turns_of(chain) == (5 * sp.pi / 12, sp.pi / 5, 3 * sp.pi / 8)


@pytest.mark.parametrize(
    "turn", [sp.pi / 12, 5 * sp.pi / 12, sp.pi / 8, 3 * sp.pi / 8, sp.pi / 5, sp.pi / 10, 2 * sp.pi / 5, 3 * sp.pi / 10]
)
def test_what_is_said_has_the_same_value(turn: sp.Expr) -> None:
    x = sp.Symbol("x")
    sine, cosine = sp.sin(turn), sp.cos(turn)
    for whole in (3 * sine * x - cosine / 7, cosine**2 * x + 2, x / sine, sp.expand((sine + x) * (cosine - 2) * 5)):
        said = with_turns(whole, (turn,))
        assert abs(sp.N((said - whole).subs(x, sp.Rational(5, 7)), 30)) < 1e-25
    assert with_turns(sine * x, (turn,)) == sp.sin(turn, evaluate=False) * x


def test_roots_that_are_lengths_stay_what_they_are() -> None:
    whole = sp.sqrt(2) * A2 / 4 + sp.sqrt(6) / 3 + sp.sqrt(5) * T2 + T2
    assert with_turns(whole, (5 * sp.pi / 12,)) == whole
