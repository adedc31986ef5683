"""Comparing two sets piece by piece: coverage, soundness, rounding, counterexamples, typed values and their limits."""

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from itertools import product
from typing import Any

import mpmath
import numpy as np
import pytest

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.angles import find_multiple_of_pi
from qdot.exercises.formula.conditions import (
    ROUNDED_JOINT_VALUE,
    SAMPLE_COUNT,
    SEARCH_TOLERANCE,
    ConfigurationSpace,
    agree_to_double_precision,
    compare_sets,
    vanishes_at,
)
from qdot.exercises.formula.equality import DOUBLE_TOLERANCE, Domain
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import evaluate_constant
from qdot.exercises.formula.set_parser import Piece, parse_pieces, parse_typed_set
from qdot.exercises.formula.trees import ParseError
from tests.support import read_cases

JOINTS = ("theta1", "theta2", "theta3")
DOMAIN = Domain({**dict.fromkeys(JOINTS, "angle"), "a1": "length", "a2": "length"})


def parse(*texts: str) -> list[Piece]:
    return [piece for text in texts for piece in parse_pieces(parse_formula(text), JOINTS)]


class FakeSpace(ConfigurationSpace):
    """A space with prescribed results: `count` poses on each piece, and a function that decides containment."""

    def __init__(
        self, contains_pose: Callable[[Sequence[Piece], int, float], np.ndarray], count: int = 4, exact: bool = True,
        miss: float = 1.0,
    ) -> None:  # fmt: skip
        super().__init__(JOINTS, DOMAIN)
        self.contains_pose, self.count, self.exact, self.miss = contains_pose, count, exact, miss

    def sample_piece(
        self, piece: Piece, used: set[str], stream: Stream, count: int = SAMPLE_COUNT
    ) -> dict[str, np.ndarray]:
        return {name: np.arange(1.0, self.count + 1) for name in sorted({*JOINTS, *used})}

    def contains(
        self, sets: Sequence[Piece], values: Mapping[str, np.ndarray], count: int, tolerance: float = SEARCH_TOLERANCE
    ) -> np.ndarray:
        return self.contains_pose(sets, count, tolerance)

    def holds_exactly(self, piece: Piece, outer: Sequence[Piece], symbols: Mapping[str, Any]) -> bool:
        return self.exact

    def compute_smallest_residual(self, piece: Piece, used: set[str], stream: Stream) -> float:
        return self.miss


def everywhere(outer: Sequence[Piece], count: int, tolerance: float) -> np.ndarray:
    return np.ones(count, dtype=bool)


def every_second(outer: Sequence[Piece], count: int, tolerance: float) -> np.ndarray:
    return np.arange(count) % 2 == 0


def only_rounded(outer: Sequence[Piece], count: int, tolerance: float) -> np.ndarray:
    return np.full(count, tolerance == ROUNDED_JOINT_VALUE.absolute)


ONE, TYPED, DECIMAL = parse("theta2 = pi/2"), parse("theta1 = 0 and theta2 = pi/2"), parse("theta2 = 1.57")
MIXED, TIED = parse("theta1 = 0 and theta2 = 1.57"), parse("cos(theta2 + theta3) = 0.5")


def every_second_if_rounded(outer: Sequence[Piece], count: int, tolerance: float) -> np.ndarray:
    return every_second(outer, count, tolerance) & (tolerance == ROUNDED_JOINT_VALUE.absolute)


INEXACT, NEAR = FakeSpace(everywhere, exact=False), FakeSpace(only_rounded)
JUDGED = [
    # claimed, reference, what the space says: sound, covered, rounded, theta1 of the surplus pose
    (TYPED, ONE, FakeSpace(everywhere), True, True, False, None),
    (ONE, ONE, INEXACT, False, False, True, 1.0),  # typed values that are wrong at fifty digits
    (TIED, ONE, INEXACT, True, False, False, None),  # an inexact reference does not mean rounding
    (TIED, TIED, INEXACT, True, True, False, None),  # conditions without a value are not checked at fifty digits
    (ONE, ONE, FakeSpace(every_second, exact=False), False, False, False, 2.0),  # the first pose that is not inside
    (DECIMAL, TIED, NEAR, False, False, True, 1.0),
    (MIXED, TIED, NEAR, False, False, True, 1.0),
    (TYPED, TIED, NEAR, False, False, True, 1.0),  # no decimals, as 22/7
    (TIED, ONE, NEAR, False, False, False, 1.0),  # a decimal in a condition
    (ONE, DECIMAL, NEAR, False, False, True, 1.0),
    (DECIMAL, ONE, FakeSpace(every_second_if_rounded), False, False, False, 1.0),
    (ONE, ONE, FakeSpace(everywhere, count=0), None, None, False, None),  # an empty set is no claim
    (DECIMAL, ONE, FakeSpace(only_rounded, count=0), None, None, False, None),
    (TIED, ONE, FakeSpace(everywhere, count=0, miss=1e-6), False, None, False, None),  # near zero, and not followed
    (TIED, ONE, FakeSpace(everywhere, count=0, miss=1e-2), None, None, False, None),
]


@pytest.mark.parametrize(("claimed", "reference", "space", "sound", "covered", "rounded", "surplus"), JUDGED)
def test_comparison_follows_from_containment_and_exactness(
    claimed: list[Piece], reference: list[Piece], space: FakeSpace, sound: bool | None, covered: bool | None,
    rounded: bool, surplus: float | None,
) -> None:  # fmt: skip
    compared = compare_sets(claimed, reference, space, "s")
    assert (compared.is_sound, compared.is_covered, compared.is_only_rounded) == ((sound,), (covered,), rounded)
    assert (compared.surplus or {}).get("theta1") == surplus
    assert (compared.configuration_count, compared.fewest_configurations) == (2 * space.count, space.count)
    assert compared.are_equal is (sound is not False and covered is not False)


def test_piece_with_a_condition_uses_the_search_tolerance() -> None:
    seen: list[float] = []

    def record_tolerance(outer: Sequence[Piece], count: int, tolerance: float) -> np.ndarray:
        seen.append(tolerance)
        return np.ones(count, dtype=bool)

    space = FakeSpace(record_tolerance)
    compare_sets(parse("theta1 = 0 and cos(theta2 + theta3) = 0"), ONE, space, "s")
    assert seen == [SEARCH_TOLERANCE, space.typed_tolerance]


@pytest.mark.parametrize(
    ("claimed", "reference", "sound", "covered"),
    [
        (["theta2 = acos(2)", "theta2 = pi/2"], "theta2 = pi/2", (None, True), (True,)),  # undefined for all lengths
        (["sqrt(-1 - cos(theta1 + theta2)^2) = 0", "theta2 = pi/2"], "theta2 = pi/2", (None, True), (True,)),
        (["-sqrt(-1 - cos(theta1 + theta2)^2) = 0", "theta2 = pi/2"], "theta2 = pi/2", (None, True), (True,)),
        # a double zero with a value beside it
        (["theta1 = 0 and 1 - cos(theta2 + theta3) = 0"], "theta1 = 0 and sin((theta2 + theta3)/2) = 0",
         (True,), (True,)),
        # poses on the simple zero must not be drawn to the double one
        (["1 - cos(theta1 + theta3) = 0"], "sin(theta2 + theta3) - cos(theta1 + theta3)*sin(theta2 + theta3) = 0",
         (True,), (False,)),
        # undefined on a part of the circle
        (["sqrt(cos(theta1)) = sin(theta2)/2 and sin(theta3 + theta2) = 1/5"],
         "2*sqrt(cos(theta1)) = sin(theta2) and 5*sin(theta3 + theta2) = 1", (True,), (True,)),
    ],
)  # fmt: skip
def test_double_zeros_and_undefined_values_are_handled(
    claimed: list[str], reference: str, sound: tuple[bool | None, ...], covered: tuple[bool | None, ...]
) -> None:
    compared = compare_sets(parse(*claimed), parse(reference), ConfigurationSpace(JOINTS, DOMAIN), "s")
    assert (compared.is_sound, compared.is_covered) == (sound, covered)


@pytest.mark.parametrize(
    ("text", "value"), [("pi/3", mpmath.pi / 3), ("acos(1/3)", mpmath.acos(mpmath.mpf(1) / 3)), ("sqrt(-4)*I", -2)]
)
def test_constant_is_evaluated_to_fifty_digits(text: str, value: mpmath.mpf) -> None:
    with mpmath.workdps(50):
        assert abs(evaluate_constant(parse_formula(text)) - mpmath.mpf(value)) < 1e-15
        assert mpmath.nstr(evaluate_constant(parse_formula("pi")), 49) == mpmath.nstr(+mpmath.pi, 49)


@pytest.mark.parametrize("text", ["acos(2)", "1/0", "log(0)", "a1", "theta1", "I", "-I", "1 + I/1000", "1 - I/1000"])
def test_non_real_constant_has_no_value(text: str) -> None:
    assert evaluate_constant(parse_formula(text)) is None


@pytest.mark.parametrize("off", [1e-3, -1e-3, 1.2e-12, -1.2e-12])
def test_different_values_do_not_agree(off: float) -> None:
    with mpmath.workdps(50):
        for value in (mpmath.mpf(0), mpmath.mpf(1), -mpmath.pi / 3):
            assert agree_to_double_precision(value, value, True)
            for is_angle in (True, False):
                assert not agree_to_double_precision(value + mpmath.mpf(off), value, is_angle)


def test_angles_agree_modulo_full_turns_and_lengths_do_not() -> None:
    with mpmath.workdps(50):
        turn = 2 * mpmath.pi
        for turns in (-3, -1, 1, 2):
            assert agree_to_double_precision(mpmath.mpf(1) + turns * turn, mpmath.mpf(1), True)
            assert not agree_to_double_precision(mpmath.mpf(1) + turns * turn, mpmath.mpf(1), False)
        assert not agree_to_double_precision(mpmath.mpf(1) + mpmath.pi, mpmath.mpf(1), True)


def test_tolerance_is_relative_for_large_and_absolute_for_small_values() -> None:
    for size in (-40, -0.01, 0.01, 40):
        allowed = DOUBLE_TOLERANCE * max(1, abs(size))
        for sign in (1, -1):
            assert agree_to_double_precision(mpmath.mpf(size + sign * 0.9 * allowed), mpmath.mpf(size), False)
            assert not agree_to_double_precision(mpmath.mpf(size + sign * 1.1 * allowed), mpmath.mpf(size), False)


def test_condition_vanishes_only_at_its_zeros() -> None:
    zero = parse_formula("a1 + a2*cos(theta2)")
    with mpmath.workdps(50):
        symbols = {"a1": mpmath.mpf(1) / 4, "a2": mpmath.mpf(1) / 2}
        exact = 2 * mpmath.pi / 3
        tiny = {"a1": mpmath.mpf("0.25e-30"), "a2": mpmath.mpf("0.5e-30")}
        for off, holds in ((0, True), (1e-13, True), (-1e-13, True), (1e-11, False), (-1e-11, False)):
            for lengths, formula in product((symbols, tiny), (zero, parse_formula("1000*(a1 + a2*cos(theta2))"))):
                assert vanishes_at(formula, {"theta2": exact + off}, lengths) is holds
        assert not vanishes_at(parse_formula("1/(a1 - a1)"), {}, symbols)


@pytest.mark.parametrize(
    ("texts", "turns"),
    [
        (["0", "pi - pi"], 0), (["pi", "5*pi", "2*pi/3 + pi/3"], 1), (["-pi/2"], Fraction(3, 2)),
        (["1", "pi + 1", "theta1", "pi/2 + theta1", "acos(1/3)", "pi*a1", "pi + asin(1/3)", "I*pi"], None),
    ],
)  # fmt: skip
def test_rational_multiples_of_pi_are_recognized(texts: list[str], turns: Fraction | None) -> None:
    assert [find_multiple_of_pi(parse_formula(text)) for text in texts] == [turns] * len(texts)


@pytest.mark.parametrize(
    ("piece", "taken", "refused"),
    [
        ("cos(theta1 + {}*theta2) = 0", 200, 500),  # no joint is isolated, so zeros must be searched
        ("theta1 = theta2 + {} and theta2 = theta1/2", 200, 600),  # coupled values must be searched, too
        ("theta1 = theta2 + {} and theta3 = theta2", 600, None), ("theta2 = {}/1000", 2000, None),
    ],
)  # fmt: skip
def test_number_of_cases_is_limited(piece: str, taken: int, refused: int | None) -> None:
    def claim(count: int) -> str:
        return "{" + ", ".join(piece.format(k) for k in range(1, count + 1)) + "}"

    assert len(parse_typed_set(parse_formula(claim(taken)), JOINTS)) == taken
    if refused:
        with pytest.raises(ParseError, match=f"with their {refused} alternatives, are too long"):
            parse_typed_set(parse_formula(claim(refused)), JOINTS)


def test_each_integer_variable_multiplies_the_cases() -> None:
    terms = " + ".join(f"sin({k}*theta1)" for k in range(1, 20))
    assert len(parse_typed_set(parse_formula("theta1 = k*pi"), JOINTS)) == 2
    for tied in (f"{terms} = k + n + m", f"theta3 = 0 and {terms} = k + n + m", f"[{{{terms} - k*n*m}}]"):
        with pytest.raises(ParseError, match="too many integers"):
            parse_typed_set(parse_formula(tied), JOINTS)
        with pytest.raises(ParseError, match="with their"):  # fewer cases, refused later because of their steps
            parse_typed_set(parse_formula(tied.replace("m", "1").replace("*1", "")), JOINTS)


@pytest.mark.parametrize("text", read_cases("sets")["with_integers"])
def test_integers_of_different_conditions_do_not_multiply(text: str) -> None:
    """Each condition has 13 cases of some hundred nodes; multiplied they would be 2,197."""
    long = " + ".join(f"sin({k}*theta1)" for k in range(1, 20))
    claimed = parse_typed_set(parse_formula(text.replace("LONG2", "pi" + " + pi" * 40).replace("LONG", long)), JOINTS)
    assert claimed
