"""Comparing two sets piece by piece: coverage, soundness, rounding and counterexamples."""

import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import (
    ROUNDED_JOINT_VALUE,
    SAMPLE_COUNT,
    SEARCH_TOLERANCE,
    ConfigurationSpace,
    compare_sets,
)
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.set_parser import Piece, parse_pieces

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


def test_value_with_eleven_digits_is_not_exact() -> None:
    domain = Domain({**DOMAIN.roles, "a1": Fraction(1, 2), "a2": Fraction(7, 10)})
    space = ConfigurationSpace(JOINTS, domain)
    reference = parse("a1 + a2*cos(theta2) = 0")
    exact = parse("theta2 = acos(-5/7)", "theta2 = -acos(-5/7)")
    assert compare_sets(exact, reference, space, "s").are_equal
    digits = f"{math.acos(-5 / 7):.10f}"
    comparison = compare_sets(parse(f"theta2 = {digits}", f"theta2 = -{digits}"), reference, space, "s")
    assert comparison.is_sound == (False, False) and comparison.is_only_rounded
