"""Pieces of sets and poses on them: how conditions are read, poses found, and what counts as lying in a set."""

from typing import Any

import numpy as np
import pytest

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import (
    SAMPLE_COUNT,
    SEARCH_TOLERANCE,
    TYPED_TOLERANCE,
    ConfigurationSpace,
    SetComparison,
    compare_sets,
)
from qdot.exercises.formula.equality import Domain, Rounding
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.set_parser import WHOLE_NUMBER_VALUES, Piece, parse_pieces
from qdot.exercises.formula.trees import ParseError, node_text

JOINTS = ("theta1", "theta2", "d3")
ROLES = {"theta1": "angle", "theta2": "angle", "d3": "signed", "a1": "length", "a2": "length"}
SPACE = ConfigurationSpace(JOINTS, Domain(ROLES))


def read_pieces(text: str) -> list[Piece]:
    return parse_pieces(parse_formula(text), JOINTS)


def shape(text: str) -> list[list[str | None]]:
    """The joints that a claim gives values to, None for a condition, piece by piece."""
    return [[atom.joint for atom in piece] for piece in read_pieces(text)]


def compared(claimed: str, reference: str, space: ConfigurationSpace = SPACE) -> SetComparison:
    return compare_sets(read_pieces(claimed), read_pieces(reference), space, "seed")


def poses(text: str, count: int = SAMPLE_COUNT, space: ConfigurationSpace = SPACE) -> dict[str, np.ndarray]:
    (piece,) = read_pieces(text)
    return space.sample_piece(piece, space.collect_names([[piece]]), Stream("poses"), count)


def residuals_at(text: str, residuals: list[str]) -> np.ndarray:
    """Return how far the poses on a piece are from meeting its conditions, a row for each of `residuals`."""
    values = poses(text)
    program = compile_program([parse_formula(residual) for residual in residuals])
    assert set(values) >= set(JOINTS)
    return np.abs(evaluate(program, values, len(values["theta1"]))[0])


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("theta2 = 0", [["theta2"]]), ("0 = theta2", [["theta2"]]), ("theta2 = theta1", [["theta2"]]),
        ("theta2 = cos(theta2)", [[None]]), ("2*theta2 = theta1", [["theta1"]]), ("2*theta2 = pi", [[None]]),
        ("a1 = a2", [[None]]), ("sin(theta2)", [[None]]), ("a1", [[None]]), ("a1 in {1, 2}", [[None]] * 2),
        ("theta2 = [0, pi]", [["theta2"]] * 2), ("2*theta2 = {0, 2*pi}", [[None]] * 2),
        ("2*theta2 in {0, 2*pi}", [[None]] * 2), ("theta2 in {0, pi}", [["theta2"]] * 2),
        ("{theta2: [0, pi], d3: 1}", [["theta2", "d3"]] * 2), ("{2*theta2: pi}", [[None]]),
        ("[theta2 = 0, pi, d3 = 1, 2]", [["theta2"], ["theta2"], ["d3"], ["d3"]]),
        ("[theta2, [0, pi]]", [["theta2"]] * 2), ("[theta2 in {0, pi}, pi/2]", [["theta2"]] * 3),
        ("[theta2 = 0, d3 = 1 and theta1 = 0]", [["theta2"], ["d3", "theta1"]]),
        ("theta2 = 0 or pi", [["theta2"]] * 2), ("[theta2 = 0, Eq(a1, a2)]", [["theta2"], [None]]),
        ("[theta2 = 0, {d3: 1}]", [["theta2"], ["d3"]]),
    ],
)  # fmt: skip
def test_pieces(text: str, found: list[list[str | None]]) -> None:
    assert shape(text) == found


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("theta2", "theta2 has no value"), ("[theta2]", "theta2 has no value"), ("[0, theta2 = pi]", "to no joint"),
        ("[theta2 = 0, sin(theta1) = 0, pi]", "to no joint"), ("[theta2 = 0, {d3: 1}, pi]", "to no joint"),
        ("[0 = theta2, pi]", "to no joint"), ("[a1 = 1, pi]", "to no joint"),
        ("theta2 = [[0]]", "found a list"), ("sin(theta2) = [[0]]", "found a list"),
        (" and ".join(["(theta1 = 0 or theta1 = pi)"] * 9), "512 cases; at most 500"),
    ],
)  # fmt: skip
def test_what_is_no_condition_is_told(text: str, said: str) -> None:
    with pytest.raises(ParseError, match=said):
        read_pieces(text)


def test_whole_numbers_go_from_minus_six_to_six_and_whole_turns_are_one() -> None:
    assert [node_text(node).strip("()") for node in WHOLE_NUMBER_VALUES] == [str(k) for k in range(-6, 7)]
    counts = {"k*pi": 2, "k*pi/6": 12, "2*k*pi": 1, "pi/4 + n*pi/2": 4, "k*a1": 13, "k*pi + a1": 13, "(k + n)*pi/6": 12}
    assert {text: len(shape(f"theta2 = {text}")) for text in counts} == counts
    assert len(shape("sin(theta2) = k")) == 13


@pytest.mark.parametrize(
    ("text", "residuals"),
    [
        ("sin(theta2) = 0", ["sin(theta2)"]), ("a1 + 2*a1*cos(theta1 - theta2) = 0", ["1 + 2*cos(theta1 - theta2)"]),
        ("a1*d3 - a2*sin(theta2) = 0", ["d3 - a2*sin(theta2)/a1"]), ("d3^2 = 2", ["d3 - sqrt(2)*d3/abs(d3)"]),
        ("theta1 = a1 and sin(theta1 - theta2) = 0", ["sin(a1 - theta2)"]), ("theta1 = a1 - a2", ["theta1 - a1 + a2"]),
        ("sin(theta1)^2 + sin(theta2)^2 = 0", ["sin(theta1)", "sin(theta2)"]), ("sin(theta2)^2 = 0", ["sin(theta2)"]),
        ("1 - cos(theta2) = 0", ["sin(theta2)"]), ("1e-6*cos(theta2) = 0", ["cos(theta2)"]),
        ("1e6*cos(theta2) = 0", ["cos(theta2)"]),
        # values that follow other joints
        ("theta1 = theta2 and cos(theta1) = 0", ["cos(theta1)", "cos(theta2)", "theta1 - theta2"]),
        ("theta1 = theta2 and cos(theta2) = 0", ["cos(theta1)", "cos(theta2)", "theta1 - theta2"]),
        ("theta1 = 2*theta2 and theta2 = pi/3", ["theta2 - pi/3", "theta1 - 2*pi/3"]),
        ("{theta1: theta2, theta2: d3, d3: 1/2}", ["theta1 - 1/2", "theta2 - 1/2", "d3 - 1/2"]),
        ("theta1 = theta2 and theta1 = pi/3", ["theta1 - pi/3", "theta2 - pi/3"]),
        ("theta1 = theta2 and theta2 = theta1", ["theta1 - theta2"]),
        ("theta1 = theta2/2 + 1 and theta2 = theta1/2", ["theta1 - 4/3", "theta2 - 2/3"]),
        ("theta1 = a1 and sin(theta2 + theta1) = 0", ["theta1 - a1", "sin(theta2 + a1)"]),
    ],
)  # fmt: skip
def test_poses_meet_the_conditions(text: str, residuals: list[str]) -> None:
    """To 1e-9, at a double zero, too; nearly all that were drawn arrive."""
    off = residuals_at(text, residuals)
    assert 40 <= off.shape[1] <= SAMPLE_COUNT
    assert off.max() < 1e-9


def test_poses_of_all_free_joints_are_spread() -> None:
    found = poses("cos(theta2) = 0", 200)
    assert np.std(found["theta1"]) > 1.5
    assert 0.3 < np.mean(found["theta2"] > 0) < 0.7
    assert 0 < len(poses("cos(theta2) = 0", 7)["theta1"]) <= 7


@pytest.mark.parametrize(
    "text",
    [
        "theta2 = acos(2)", "theta2 = 1/0", "cos(theta2) = 2", "1 = 0", "a1 = 0", "d3^2 = -1",
        "cos(theta1) = 0 and a1 = 0",
    ],
)  # fmt: skip
def test_no_pose_is_on_a_piece_that_is_nowhere(text: str) -> None:
    assert len(poses(text)["theta1"]) == 0


def test_poses_are_where_values_are_real() -> None:
    found = poses("theta2 = acos(a1/a2)", 400)
    assert 100 < len(found["a1"]) < 300
    assert (found["a1"] <= found["a2"]).all()
    assert np.cos(found["theta2"]) == pytest.approx(found["a1"] / found["a2"])


@pytest.mark.parametrize(
    ("text", "residuals"),
    [
        ("sqrt(1 + cos(theta2)) = 0", ["1 + cos(theta2)"]), ("abs(1 + cos(theta2)) = 0", ["1 + cos(theta2)"]),
        ("sqrt((1 + cos(theta2))^2)*d3^2 = 0", ["(1 + cos(theta2))*d3"]), ("log(d3) = 0", ["d3 - 1"]),
        ("sqrt(sin(theta1)^2 + sin(theta2)^2) = 0", ["sin(theta1)", "sin(theta2)"]),
        ("a1*sqrt(d3^2 + sin(theta1)^2) = 0", ["d3", "sin(theta1)"]),
        ("(1 + cos(theta2))^(1/4) = 0", ["1 + cos(theta2)"]),
        ("log(d3)*a1 = 0 and cos(theta1) = 0", ["d3 - 1", "cos(theta1)"]),
    ],
)  # fmt: skip
def test_zeros_without_a_slope_are_found(text: str, residuals: list[str]) -> None:
    """As of the square root of a determinant of J J^T; some of those that were drawn arrive."""
    off = residuals_at(text, residuals)
    assert off.shape[1] > 15 and off.max() < 1e-8


def test_how_near_conditions_come() -> None:
    def miss(text: str) -> float:
        (piece,) = read_pieces(text)
        return SPACE.compute_smallest_residual(piece, SPACE.collect_names([[piece]]), Stream("miss"))

    assert miss("theta2 = 0") == miss("a1 = 0") == miss("1 = 0") == float("inf")
    assert miss("cos(theta2) = 0") < 0.1
    assert miss("cos(theta2) = 3") == pytest.approx(0.5, abs=0.05)  # |1 - 3| of terms 1 + 3
    assert miss("cos(theta2) = 0 and cos(theta2) = 3") == pytest.approx(miss("cos(theta2) = 3"), abs=0.2)


@pytest.mark.parametrize("text", ["sqrt({})", "-sqrt({})", "sqrt({}) = 0", "abs(-sqrt({})) = 0.0", "{} - 0", "{}"])
def test_a_root_vanishes_where_its_operand_does(text: str) -> None:
    """As a measure of manipulability, sqrt(det(J J^T)) = 0, with terms of different sizes."""
    inner = "a1^2*sin(theta1)^2 + (a2*sin(theta2))^2"
    assert [node_text(atom.expression) for (atom,) in read_pieces(text.format(inner))] == [
        node_text(parse_formula(inner))
    ]
    assert compared(text.format(inner), "sin(theta1) = 0 and sin(theta2) = 0").are_equal
    assert not compared(text.format(inner), "sin(theta1) = 0").are_equal


def test_a_root_that_is_no_whole_side_is_left() -> None:
    for text in ("sqrt(d3) = 1", "0 - sqrt(d3)", "sqrt(d3) + abs(a1)", "exp(d3)"):
        (piece,) = read_pieces(text)
        assert node_text(piece[0].expression) == node_text(parse_formula(text.replace(" = ", " - ")))


@pytest.mark.parametrize(
    ("claimed", "reference", "equal"),
    [
        ("theta2 = theta1 and theta1 = pi/2", "theta1 = pi/2 and theta2 = pi/2", True),
        ("theta2 = theta1 and cos(theta2) = 0", "theta1 = theta2 and cos(theta1) = 0", True),
        ("sin(theta2) = 0 or (theta2 = theta1 and cos(theta2) = 0)", "sin(theta2) = 0", False),
        ("theta2 = theta1 and cos(theta2) = 0", "cos(theta2) = 0", False),
    ],
)
def test_conditions_that_are_tied_are_compared(claimed: str, reference: str, equal: bool) -> None:
    assert compared(claimed, reference).are_equal is equal
    assert compared(reference, claimed).are_equal is equal


def inside(text: str, tolerance: float = SEARCH_TOLERANCE, **values: list[float]) -> list[bool]:
    count = len(next(iter(values.values())))
    every: dict[str, Any] = {name: np.full(count, 0.7) for name in (*JOINTS, "a1", "a2")}
    every |= {name: np.array(column) for name, column in values.items()}
    return [bool(held) for held in SPACE.contains(read_pieces(text), every, count, tolerance)]


def test_values_lie_in_a_set_to_within_a_tolerance() -> None:
    for tolerance in (SEARCH_TOLERANCE, TYPED_TOLERANCE):
        near = [0.0, 0.9 * tolerance, -0.9 * tolerance, 1.1 * tolerance, -1.1 * tolerance]
        assert inside("theta2 = 0", tolerance=tolerance, theta2=near) == [True, True, True, False, False]
        assert inside("d3 = 0", tolerance=tolerance, d3=near) == [True, True, True, False, False]
    assert (SEARCH_TOLERANCE, TYPED_TOLERANCE) == (1e-7, 1e-9)
    assert ConfigurationSpace(JOINTS, Domain(ROLES)).typed_tolerance == TYPED_TOLERANCE


def test_angles_have_whole_turns_and_slides_have_none() -> None:
    turns = [0.0, 2 * np.pi, -2 * np.pi, 3.0, np.pi]
    assert inside("theta2 = 0", theta2=turns) == [True, True, True, False, False]
    assert inside("d3 = 0", d3=turns) == [True, False, False, False, False]
    assert inside("theta2 = 4*pi", theta2=turns) == [True, True, True, False, False]
    assert inside("theta2 = 1/0", theta2=turns) == [False] * 5
    for sign in "+-":
        assert inside(f"theta2 = 0.5 {sign} I/100", theta2=[0.5]) == [False]


def test_a_set_is_what_lies_in_any_piece_and_a_piece_what_meets_all_conditions() -> None:
    one, two = [0.0, 0.0, 1.0, 1.0], [0.0, 1.0, 0.0, 1.0]
    assert inside("theta1 = 0 or theta2 = 0", theta1=one, theta2=two) == [True, True, True, False]
    assert inside("theta1 = 0 and theta2 = 0", theta1=one, theta2=two) == [True, False, False, False]
    assert inside("theta1 = 0 and sin(theta2) = 0", theta1=one, theta2=two) == [True, False, False, False]
    assert SPACE.contains([], {"theta1": np.zeros(2)}, 2).tolist() == [False, False]
    assert SPACE.contains(read_pieces("theta1 = 0"), {}, 0).shape == (0,)


@pytest.mark.parametrize("unit", ["1e-9", "1", "1e9"])
def test_an_expression_vanishes_near_its_zero_whatever_its_scale(unit: str) -> None:
    near = [0.0, 0.9e-7, -0.9e-7, 1.2e-7, 0.1]
    assert inside(f"{unit}*sin(theta2) = 0", theta2=near) == [True, True, True, False, False]
    assert inside(f"{unit}*d3 = 0", d3=near) == [True, True, True, False, False]
    assert inside(f"{unit}*(cos(theta2) - 1) = 0", theta2=[0.0, 1e-9, 1e-3]) == [True, True, False]
    assert inside(f"{unit}*(a1 - a2) = 0", a1=[0.7, 0.8]) == [True, False]


def test_what_is_complex_or_undefined_vanishes_nowhere() -> None:
    assert inside("sqrt(d3) = 0", d3=[-1.0, 4.0]) == [False, False]
    assert inside("d3 + I = 0", d3=[0.0]) == [False]
    assert inside("1/d3 = 0", d3=[0.0]) == [False]


def test_what_values_may_be_off() -> None:
    for rounding, typed in (
        (None, TYPED_TOLERANCE), (Rounding(0.005), 0.005 * np.pi), (Rounding(0.0, 0.01), 0.01),
        (Rounding(1e-12), TYPED_TOLERANCE),
    ):  # fmt: skip
        assert ConfigurationSpace(JOINTS, Domain(ROLES), rounding).typed_tolerance == pytest.approx(
            typed, rel=1e-12, abs=0
        )


def test_how_values_are_shown() -> None:
    assert SPACE.round_value("theta1", 4.0) == -2.28319
    assert SPACE.round_value("theta1", 2.0) == 2.0
    assert SPACE.round_value("d3", 4.0) == 4.0
    assert SPACE.round_value("a1", 1.23456789) == 1.23457
    assert [str(SPACE.round_value(name, value)) for name, value in (("d3", -0.0), ("theta2", -5.305e-52))] == [
        "0.0"
    ] * 2


def test_names_of_sets_are_those_of_the_joints_and_of_all_conditions() -> None:
    sets = [read_pieces("theta1 = a1 and sin(theta2) = 0 or d3 = x"), read_pieces("y = 0")]
    assert SPACE.collect_names(sets) == {*JOINTS, "a1", "x", "y"}


def test_a_comparison_says_what_is_covered_and_sound_and_how_many_points() -> None:
    found = compared("theta2 = 0 or d3 = 1", "sin(theta2) = 0")
    assert (found.is_covered, found.is_sound, found.are_equal) == ((False,), (True, False), False)
    assert found.surplus is not None
    assert found.surplus["d3"] == 1
    assert found.missing is not None
    assert abs(found.missing["theta2"]) == pytest.approx(np.pi, abs=1e-5)
    assert (found.configuration_count, found.fewest_configurations) == (150, 50)
    found = compared("theta2 = acos(a1/a2) or theta2 = -acos(a1/a2)", "cos(theta2) = a1/a2")
    assert found.are_equal
    assert 0 < found.fewest_configurations < 40
    assert 2 * found.fewest_configurations < found.configuration_count < 150


def test_a_claim_that_holds_nowhere_covers_nothing_and_is_not_wrong() -> None:
    found = compared("theta2 = 0 or theta2 = pi or cos(theta2) = 2", "sin(theta2) = 0")
    assert (found.is_covered, found.is_sound, found.are_equal) == ((True,), (True, True, None), True)
    found = compared("cos(theta2) = 2", "sin(theta2) = 0")
    assert (found.is_covered, found.is_sound, found.are_equal) == ((False,), (None,), False)
    found = compared("theta2 = 0", "theta2 = 0 or cos(theta2) = 2")
    assert (found.is_covered, found.is_sound, found.are_equal) == ((True, None), (True,), True)
    assert (found.configuration_count, found.fewest_configurations) == (100, 50)
    nothing = compare_sets([], read_pieces("sin(theta2) = 0"), SPACE, "seed")
    assert not nothing.are_equal and nothing.missing is not None


@pytest.mark.parametrize(("off", "rounded"), [("0.004", True), ("-0.004", True), ("0.006", False)])
def test_a_decimal_that_is_near_is_told_to_be_rounded(off: str, rounded: bool) -> None:
    found = compared(f"theta2 = 0.5 + {off}", "theta2 = 1/2")
    assert (found.are_equal, found.is_only_rounded) == (False, rounded)
    assert compared(f"theta2 = 1/2 + {off.replace('0.00', '1/1000*')}", "theta2 = 1/2").is_only_rounded is rounded


def test_typed_values_are_held_to_the_digits_of_a_double_unless_rounding_is_allowed() -> None:
    loose = ConfigurationSpace(JOINTS, Domain(ROLES), Rounding(0.0, 0.01))
    for text, exact, allowed in (("theta2 = 3.14159265358979", True, True), ("theta2 = 3.1415926536", False, True),
                                 ("theta2 = 3.13", False, False),
                                 ("theta2 = 3.135", False, True), ("theta2 = pi", True, True)):  # fmt: skip
        assert compared(text, "theta2 = pi").are_equal is exact
        assert compared(text, "theta2 = pi", loose).are_equal is allowed
    found = compared("theta2 = 3.1415926536", "theta2 = pi")
    assert (found.is_sound, found.is_only_rounded) == ((False,), True)
    assert not compared("theta2 = pi", "theta2 = 3.1415926536").are_equal


def test_every_condition_is_held_to_the_digits_of_a_double_and_what_has_none_is_left_to_the_search() -> None:
    assert not compared("theta1 = 0 and theta2 = 3.1415926536", "theta1 = 0 and theta2 = pi").are_equal
    for value, due in (("pi", True), ("3.14159265358979", True), ("3.1415926536", False)):
        claimed = f"{{theta1: 0, theta2: [0, {value}]}}"
        assert compared(claimed, "sin(theta2) = 0 and theta1 = 0").are_equal is due
    tied = "cos(theta2)*theta1 = sqrt(2)*a1 and theta2 = 0"
    assert compared("theta2 = 0 and theta1 = sqrt(2)*a1", tied).are_equal
