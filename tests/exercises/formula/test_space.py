"""Pieces of sets: parsing conditions, sampling poses on them, and deciding containment."""

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
from qdot.exercises.formula.trees import ParseError, format_tree
from tests.support import read_cases

SETS = read_cases("sets")

JOINTS = ("theta1", "theta2", "d3")
ROLES = {"theta1": "angle", "theta2": "angle", "d3": "signed", "a1": "length", "a2": "length"}
SPACE = ConfigurationSpace(JOINTS, Domain(ROLES))


def read_pieces(text: str) -> list[Piece]:
    return parse_pieces(parse_formula(text), JOINTS)


def list_piece_joints(text: str) -> list[list[str | None]]:
    return [[atom.joint for atom in piece] for piece in read_pieces(text)]


def compare(claimed: str, reference: str, space: ConfigurationSpace = SPACE) -> SetComparison:
    return compare_sets(read_pieces(claimed), read_pieces(reference), space, "seed")


def sample_poses(text: str, count: int = SAMPLE_COUNT, space: ConfigurationSpace = SPACE) -> dict[str, np.ndarray]:
    (piece,) = read_pieces(text)
    return space.sample_piece(piece, space.collect_names([[piece]]), Stream("poses"), count)


def compute_residuals(text: str, residuals: list[str]) -> np.ndarray:
    """Return the residuals of the poses on a piece, one row for each of `residuals`."""
    values = sample_poses(text)
    program = compile_program([parse_formula(residual) for residual in residuals])
    assert set(values) >= set(JOINTS)
    return np.abs(evaluate(program, values, len(values["theta1"])).values)


@pytest.mark.parametrize(("text", "expected"), SETS["pieces"])
def test_set_is_split_into_pieces(text: str, expected: list[list[str]]) -> None:
    assert list_piece_joints(text) == [[joint or None for joint in piece] for piece in expected]


@pytest.mark.parametrize(
    ("text", "message"),
    [*SETS["refused"], (" and ".join(["(theta1 = 0 or theta1 = pi)"] * 9), "512 alternatives; at most 500")],
)
def test_invalid_condition_is_refused(text: str, message: str) -> None:
    with pytest.raises(ParseError, match=message):
        read_pieces(text)


def test_integers_range_from_minus_six_to_six_modulo_full_turns() -> None:
    assert [format_tree(node).strip("()") for node in WHOLE_NUMBER_VALUES] == [str(k) for k in range(-6, 7)]
    counts = {"k*pi": 2, "k*pi/6": 12, "2*k*pi": 1, "pi/4 + n*pi/2": 4, "k*a1": 13, "k*pi + a1": 13, "(k + n)*pi/6": 12}
    assert {text: len(list_piece_joints(f"theta2 = {text}")) for text in counts} == counts
    assert len(list_piece_joints("sin(theta2) = k")) == 13


@pytest.mark.parametrize(("text", "residuals"), SETS["poses"])
def test_sampled_poses_satisfy_the_conditions(text: str, residuals: list[str]) -> None:
    """They do to 1e-9, even at a double zero; nearly all starts converge."""
    off = compute_residuals(text, residuals)
    assert 40 <= off.shape[1] <= SAMPLE_COUNT
    assert off.max() < 1e-9


def test_free_joints_of_sampled_poses_vary() -> None:
    samples = sample_poses("cos(theta2) = 0", 200)
    assert np.std(samples["theta1"]) > 1.5
    assert 0.3 < np.mean(samples["theta2"] > 0) < 0.7
    assert 0 < len(sample_poses("cos(theta2) = 0", 7)["theta1"]) <= 7


@pytest.mark.parametrize("text", read_cases("sets")["empty"])
def test_empty_piece_has_no_poses(text: str) -> None:
    assert len(sample_poses(text)["theta1"]) == 0


def test_poses_are_sampled_only_where_values_are_real() -> None:
    samples = sample_poses("theta2 = acos(a1/a2)", 400)
    assert 100 < len(samples["a1"]) < 300
    assert (samples["a1"] <= samples["a2"]).all()
    assert np.cos(samples["theta2"]) == pytest.approx(samples["a1"] / samples["a2"])


@pytest.mark.parametrize(("text", "residuals"), SETS["flat"])
def test_zeros_without_a_slope_are_sampled(text: str, residuals: list[str]) -> None:
    """Such as those of sqrt(det(J J^T)); some starts converge."""
    off = compute_residuals(text, residuals)
    assert off.shape[1] > 15 and off.max() < 1e-8


def test_smallest_residual_of_a_condition_is_estimated() -> None:
    def compute_residual(text: str) -> float:
        (piece,) = read_pieces(text)
        return SPACE.compute_smallest_residual(piece, SPACE.collect_names([[piece]]), Stream("miss"))

    assert compute_residual("theta2 = 0") == compute_residual("a1 = 0") == compute_residual("1 = 0") == float("inf")
    assert compute_residual("cos(theta2) = 0") < 0.1
    assert compute_residual("cos(theta2) = 3") == pytest.approx(0.5, abs=0.05)  # |1 - 3| of terms 1 + 3
    both, one = (compute_residual(text) for text in ("cos(theta2) = 0 and cos(theta2) = 3", "cos(theta2) = 3"))
    assert both == pytest.approx(one, abs=0.2)


@pytest.mark.parametrize("text", ["sqrt({})", "-sqrt({})", "sqrt({}) = 0", "abs(-sqrt({})) = 0.0", "{} - 0", "{}"])
def test_root_on_one_side_is_replaced_by_its_operand(text: str) -> None:
    """Such as manipulability, sqrt(det(J J^T)) = 0, with terms of different sizes."""
    inner = "a1^2*sin(theta1)^2 + (a2*sin(theta2))^2"
    ((atom,),) = read_pieces(text.format(inner))
    assert format_tree(atom.expression) == format_tree(parse_formula(inner))
    assert compare(text.format(inner), "sin(theta1) = 0 and sin(theta2) = 0").are_equal
    assert not compare(text.format(inner), "sin(theta1) = 0").are_equal


def test_root_inside_a_side_is_kept() -> None:
    for text in ("sqrt(d3) = 1", "1 - sqrt(d3)", "sqrt(d3) + abs(a1)", "exp(d3)"):
        (piece,) = read_pieces(text)
        assert format_tree(piece[0].expression) == format_tree(parse_formula(text.replace(" = ", " - ")))


def are_inside(text: str, tolerance: float = SEARCH_TOLERANCE, **values: list[float]) -> list[bool]:
    count = len(next(iter(values.values())))
    every: dict[str, Any] = {name: np.full(count, 0.7) for name in (*JOINTS, "a1", "a2")}
    every |= {name: np.array(column) for name, column in values.items()}
    return [bool(held) for held in SPACE.contains(read_pieces(text), every, count, tolerance)]


def test_values_lie_in_a_set_within_a_tolerance() -> None:
    for tolerance in (SEARCH_TOLERANCE, TYPED_TOLERANCE):
        near = [0.0, 0.9 * tolerance, -0.9 * tolerance, 1.1 * tolerance, -1.1 * tolerance]
        assert are_inside("theta2 = 0", tolerance=tolerance, theta2=near) == [True, True, True, False, False]
        assert are_inside("d3 = 0", tolerance=tolerance, d3=near) == [True, True, True, False, False]
    assert (SEARCH_TOLERANCE, TYPED_TOLERANCE) == (1e-7, 1e-9)
    assert ConfigurationSpace(JOINTS, Domain(ROLES)).typed_tolerance == TYPED_TOLERANCE


def test_angles_are_periodic_and_slides_are_not() -> None:
    turns = [0.0, 2 * np.pi, -2 * np.pi, 3.0, np.pi]
    assert are_inside("theta2 = 0", theta2=turns) == [True, True, True, False, False]
    assert are_inside("d3 = 0", d3=turns) == [True, False, False, False, False]
    assert are_inside("theta2 = 4*pi", theta2=turns) == [True, True, True, False, False]
    assert are_inside("theta2 = 1/0", theta2=turns) == [False] * 5
    for sign in "+-":
        assert are_inside(f"theta2 = 0.5 {sign} I/100", theta2=[0.5]) == [False]


def test_set_is_a_union_of_pieces_and_piece_an_intersection() -> None:
    first, second = [0.0, 0.0, 1.0, 1.0], [0.0, 1.0, 0.0, 1.0]
    assert are_inside("theta1 = 0 or theta2 = 0", theta1=first, theta2=second) == [True, True, True, False]
    assert are_inside("theta1 = 0 and theta2 = 0", theta1=first, theta2=second) == [True, False, False, False]
    assert are_inside("theta1 = 0 and sin(theta2) = 0", theta1=first, theta2=second) == [True, False, False, False]
    assert SPACE.contains([], {"theta1": np.zeros(2)}, 2).tolist() == [False, False]
    assert SPACE.contains(read_pieces("theta1 = 0"), {}, 0).shape == (0,)


@pytest.mark.parametrize("unit", ["1e-9", "1", "1e9"])
def test_expression_vanishes_near_its_zero_at_any_scale(unit: str) -> None:
    near = [0.0, 0.9e-7, -0.9e-7, 1.2e-7, 0.1]
    assert are_inside(f"{unit}*sin(theta2) = 0", theta2=near) == [True, True, True, False, False]
    assert are_inside(f"{unit}*d3 = 0", d3=near) == [True, True, True, False, False]
    assert are_inside(f"{unit}*(cos(theta2) - 1) = 0", theta2=[0.0, 1e-9, 1e-3]) == [True, True, False]
    assert are_inside(f"{unit}*(a1 - a2) = 0", a1=[0.7, 0.8]) == [True, False]


def test_complex_or_undefined_value_does_not_vanish() -> None:
    assert are_inside("sqrt(d3) = 0", d3=[-1.0, 4.0]) == [False, False]
    assert are_inside("d3 + I = 0", d3=[0.0]) == [False]
    assert are_inside("1/d3 = 0", d3=[0.0]) == [False]


def test_rounding_rule_sets_the_typed_tolerance() -> None:
    for rounding, typed in (
        (None, TYPED_TOLERANCE), (Rounding(0.005), 0.005 * np.pi), (Rounding(0.0, 0.01), 0.01),
        (Rounding(1e-12), TYPED_TOLERANCE),
    ):  # fmt: skip
        space = ConfigurationSpace(JOINTS, Domain(ROLES), rounding)
        assert space.typed_tolerance == pytest.approx(typed, rel=1e-12, abs=0)


def test_values_are_rounded_for_display() -> None:
    assert SPACE.round_value("theta1", 4.0) == -2.28319
    assert SPACE.round_value("theta1", 2.0) == 2.0
    assert SPACE.round_value("d3", 4.0) == 4.0
    assert SPACE.round_value("a1", 1.23456789) == 1.23457
    assert str(SPACE.round_value("d3", -0.0)) == str(SPACE.round_value("theta2", -5.305e-52)) == "0.0"


def test_names_of_sets_include_joints_and_symbols_of_conditions() -> None:
    sets = [read_pieces("theta1 = a1 and sin(theta2) = 0 or d3 = x"), read_pieces("y = 0")]
    assert SPACE.collect_names(sets) == {*JOINTS, "a1", "x", "y"}


def test_comparison_reports_coverage_soundness_and_counts() -> None:
    comparison = compare("theta2 = 0 or d3 = 1", "sin(theta2) = 0")
    assert (comparison.is_covered, comparison.is_sound, comparison.are_equal) == ((False,), (True, False), False)
    assert comparison.surplus is not None
    assert comparison.surplus["d3"] == 1
    assert comparison.missing is not None
    assert abs(comparison.missing["theta2"]) == pytest.approx(np.pi, abs=1e-5)
    assert (comparison.configuration_count, comparison.fewest_configurations) == (150, 50)
    comparison = compare("theta2 = acos(a1/a2) or theta2 = -acos(a1/a2)", "cos(theta2) = a1/a2")
    assert comparison.are_equal
    assert 0 < comparison.fewest_configurations < 40
    assert 2 * comparison.fewest_configurations < comparison.configuration_count < 150


def test_empty_claim_covers_nothing_and_is_not_wrong() -> None:
    comparison = compare("theta2 = 0 or theta2 = pi or cos(theta2) = 2", "sin(theta2) = 0")
    assert (comparison.is_covered, comparison.is_sound, comparison.are_equal) == ((True,), (True, True, None), True)
    comparison = compare("cos(theta2) = 2", "sin(theta2) = 0")
    assert (comparison.is_covered, comparison.is_sound, comparison.are_equal) == ((False,), (None,), False)
    comparison = compare("theta2 = 0", "theta2 = 0 or cos(theta2) = 2")
    assert (comparison.is_covered, comparison.is_sound, comparison.are_equal) == ((True, None), (True,), True)
    assert (comparison.configuration_count, comparison.fewest_configurations) == (100, 50)
    nothing = compare_sets([], read_pieces("sin(theta2) = 0"), SPACE, "seed")
    assert not nothing.are_equal and nothing.missing is not None


@pytest.mark.parametrize(("off", "rounded"), [("0.004", True), ("-0.004", True), ("0.006", False)])
def test_near_decimal_is_reported_as_rounded(off: str, rounded: bool) -> None:
    comparison = compare(f"theta2 = 0.5 + {off}", "theta2 = 1/2")
    assert (comparison.are_equal, comparison.is_only_rounded) == (False, rounded)
    assert compare(f"theta2 = 1/2 + {off.replace('0.00', '1/1000*')}", "theta2 = 1/2").is_only_rounded is rounded


def test_typed_values_need_the_digits_of_a_double_unless_rounding_is_allowed() -> None:
    loose = ConfigurationSpace(JOINTS, Domain(ROLES), Rounding(0.0, 0.01))
    for text, exact, allowed in (("theta2 = 3.14159265358979", True, True), ("theta2 = 3.1415926536", False, True),
                                 ("theta2 = 3.13", False, False),
                                 ("theta2 = 3.135", False, True), ("theta2 = pi", True, True)):  # fmt: skip
        assert compare(text, "theta2 = pi").are_equal is exact
        assert compare(text, "theta2 = pi", loose).are_equal is allowed
    comparison = compare("theta2 = 3.1415926536", "theta2 = pi")
    assert (comparison.is_sound, comparison.is_only_rounded) == ((False,), True)
    assert not compare("theta2 = pi", "theta2 = 3.1415926536").are_equal


def test_every_typed_value_of_a_piece_needs_the_digits_of_a_double() -> None:
    assert not compare("theta1 = 0 and theta2 = 3.1415926536", "theta1 = 0 and theta2 = pi").are_equal
    for value, expected in (("pi", True), ("3.14159265358979", True), ("3.1415926536", False)):
        claimed = f"{{theta1: 0, theta2: [0, {value}]}}"
        assert compare(claimed, "sin(theta2) = 0 and theta1 = 0").are_equal is expected
    tied = "cos(theta2)*theta1 = sqrt(2)*a1 and theta2 = 0"
    assert compare("theta2 = 0 and theta1 = sqrt(2)*a1", tied).are_equal
