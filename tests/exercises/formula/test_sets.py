"""How two sets are compared, piece by piece, whatever the poses are: what is covered, sound, rounded, and shown."""

import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from exercises.formula.conditions import MEMBER, ROUNDED, SAMPLES, Space, compare_sets
from exercises.formula.expression import read
from exercises.formula.identity import Domain
from exercises.formula.pieces import Piece, pieces
from exercises.stream import Stream

JOINTS = ("theta1", "theta2", "theta3")
DOMAIN = Domain({**dict.fromkeys(JOINTS, "angle"), "a1": "length", "a2": "length"})


def parsed(*texts: str) -> list[Piece]:
    return [piece for text in texts for piece in pieces(read(text), JOINTS)]


class Told(Space):
    """A space whose poses and tests are told: `count` poses on each piece, and what is inside at which tolerance."""

    def __init__(
        self, inside: Callable[[Sequence[Piece], int, float], np.ndarray], count: int = 4, exact: bool = True,
        miss: float = 1.0,
    ) -> None:  # fmt: skip
        super().__init__(JOINTS, DOMAIN)
        self.told, self.count, self.exact, self.miss = inside, count, exact, miss

    def on_piece(self, piece: Piece, used: set[str], stream: Stream, count: int = SAMPLES) -> dict[str, np.ndarray]:
        return {name: np.arange(1.0, self.count + 1) for name in sorted({*JOINTS, *used})}

    def contains(
        self, sets: Sequence[Piece], values: Mapping[str, np.ndarray], count: int, tolerance: float = MEMBER
    ) -> np.ndarray:
        return self.told(sets, count, tolerance)

    def holds_exactly(self, piece: Piece, outer: Sequence[Piece], symbols: Mapping[str, Any]) -> bool:
        return self.exact

    def nearest_miss(self, piece: Piece, used: set[str], stream: Stream) -> float:
        return self.miss


def everywhere(outer: Sequence[Piece], count: int, tolerance: float) -> np.ndarray:
    return np.ones(count, dtype=bool)


def half(outer: Sequence[Piece], count: int, tolerance: float) -> np.ndarray:
    return np.arange(count) % 2 == 0


def only_rounded(outer: Sequence[Piece], count: int, tolerance: float) -> np.ndarray:
    return np.full(count, tolerance == ROUNDED)


ONE, TYPED, DECIMAL = parsed("theta2 = pi/2"), parsed("theta1 = 0 and theta2 = pi/2"), parsed("theta2 = 1.57")
MIXED, TIED = parsed("theta1 = 0 and theta2 = 1.57"), parsed("cos(theta2 + theta3) = 0.5")


def test_what_is_inside_everywhere_and_exactly_is_equal() -> None:
    found = compare_sets(TYPED, ONE, Told(everywhere), "s")
    assert found.equal and not found.rounded and found.missing is None and found.surplus is None
    assert (found.points, found.least) == (8, 4)


def test_typed_values_that_miss_with_fifty_digits_are_rounded_ones() -> None:
    found = compare_sets(ONE, ONE, Told(everywhere, exact=False), "s")
    assert found.sound == (False,) and found.rounded
    assert found.surplus is not None and found.surplus["theta1"] == 1.0


def test_a_reference_that_misses_with_fifty_digits_says_nothing_of_rounding() -> None:
    found = compare_sets(TIED, ONE, Told(everywhere, exact=False), "s")
    assert found.sound == (True,) and found.covered == (False,) and not found.rounded


def test_what_is_inside_at_some_poses_only_is_neither_sound_nor_rounded() -> None:
    found = compare_sets(ONE, ONE, Told(half, exact=False), "s")
    assert found.sound == (False,) and not found.rounded
    assert found.surplus is not None and found.surplus["theta1"] == 2.0  # the first pose that is not


def test_conditions_without_a_value_are_not_held_to_fifty_digits() -> None:
    assert compare_sets(TIED, TIED, Told(everywhere, exact=False), "s").equal


@pytest.mark.parametrize("claimed", [DECIMAL, MIXED])
def test_a_decimal_near_to_what_is_due_is_a_rounded_one(claimed: list[Piece]) -> None:
    found = compare_sets(claimed, TIED, Told(only_rounded), "s")
    assert found.rounded and found.sound == (False,)


def test_rounding_is_told_of_decimals_that_were_claimed_as_values_and_are_near_at_every_pose() -> None:
    assert not compare_sets(TYPED, TIED, Told(only_rounded), "s").rounded  # no decimals
    assert not compare_sets(TIED, ONE, Told(only_rounded), "s").rounded  # a decimal in a condition
    assert not compare_sets(ONE, DECIMAL, Told(only_rounded), "s").rounded  # a decimal of the reference

    def near_somewhere(outer: Sequence[Piece], count: int, tolerance: float) -> np.ndarray:
        return half(outer, count, tolerance) & (tolerance == ROUNDED)

    assert not compare_sets(DECIMAL, ONE, Told(near_somewhere), "s").rounded


def test_a_piece_with_a_condition_in_it_is_held_to_the_tolerance_of_what_was_searched_for() -> None:
    seen: list[float] = []

    def asked(outer: Sequence[Piece], count: int, tolerance: float) -> np.ndarray:
        seen.append(tolerance)
        return np.ones(count, dtype=bool)

    space = Told(asked)
    compare_sets(parsed("theta1 = 0 and cos(theta2 + theta3) = 0"), ONE, space, "s")
    assert seen == [MEMBER, space.typed]


def test_what_holds_nowhere_is_no_claim_and_covers_nothing() -> None:
    found = compare_sets(ONE, ONE, Told(everywhere, count=0), "s")
    assert found.sound == (None,) and found.covered == (None,)
    assert (found.points, found.least) == (0, 0) and not found.rounded
    decimal = compare_sets(DECIMAL, ONE, Told(only_rounded, count=0), "s")
    assert decimal.sound == (None,) and not decimal.rounded and decimal.surplus is None


@pytest.mark.parametrize(("miss", "sound"), [(1e-6, False), (1e-2, None)])
def test_what_comes_near_to_zero_but_can_not_be_followed_is_not_sound(miss: float, sound: bool | None) -> None:
    found = compare_sets(TIED, ONE, Told(everywhere, count=0, miss=miss), "s")
    assert found.sound == (sound,)


def test_only_pieces_that_hold_somewhere_cover() -> None:
    seen: list[int] = []
    seeds = ["claimed", "reference"]

    class Empty(Told):
        def on_piece(self, piece: Piece, used: set[str], stream: Stream, count: int = SAMPLES) -> dict[str, np.ndarray]:
            count = 0 if piece == TIED[0] else 3 if "claimed" in seeds.pop(0) else 5
            return {name: np.ones(count) for name in JOINTS}

    def asked(outer: Sequence[Piece], count: int, tolerance: float) -> np.ndarray:
        seen.append(len(outer))
        return np.ones(count, dtype=bool)

    found = compare_sets([*TIED, *ONE], ONE, Empty(asked), "s")
    assert seen == [1, 1, 1] and found.sound == (None, True)
    assert (found.points, found.least) == (8, 3)


def test_a_value_that_is_undefined_for_all_lengths_claims_nothing() -> None:
    space = Space(JOINTS, DOMAIN)
    found = compare_sets(parsed("theta2 = acos(2)", "theta2 = pi/2"), ONE, space, "s")
    assert found.sound == (None, True) and found.covered == (True,)


def test_a_double_zero_with_a_value_beside_it_is_sound() -> None:
    space = Space(JOINTS, DOMAIN)
    claimed = parsed("theta1 = 0 and 1 - cos(theta2 + theta3) = 0")
    assert compare_sets(claimed, parsed("theta1 = 0 and sin((theta2 + theta3)/2) = 0"), space, "s").equal


@pytest.mark.parametrize("sign", ["", "-"])
def test_a_condition_whose_value_is_never_real_holds_nowhere(sign: str) -> None:
    space = Space(JOINTS, DOMAIN)
    never = parsed(f"{sign}sqrt(-1 - cos(theta1 + theta2)^2) = 0")
    assert compare_sets([*never, *ONE], ONE, space, "s").sound == (None, True)


def test_a_simple_zero_beside_a_double_one_is_looked_at_as_well() -> None:
    """Poses on the simple zero must not be drawn to the double one, where a claim of that alone would cover them."""
    both = parsed("(1 - cos(theta1 + theta3))*sin(theta2 + theta3) = 0")
    one = parsed("1 - cos(theta1 + theta3) = 0")
    found = compare_sets(one, both, Space(JOINTS, DOMAIN), "s")
    assert found.sound == (True,) and found.covered == (False,)


def test_conditions_that_are_undefined_on_a_part_of_the_circle_are_followed_on_the_rest() -> None:
    tied = parsed("sqrt(cos(theta1)) = sin(theta2)/2 and sin(theta3 + theta2) = 1/5")
    same = parsed("2*sqrt(cos(theta1)) = sin(theta2) and 5*sin(theta3 + theta2) = 1")
    assert compare_sets(tied, same, Space(JOINTS, DOMAIN), "s").equal


def test_a_value_of_thirteen_digits_is_not_exact_where_the_lengths_are() -> None:
    given = Domain({**DOMAIN.roles, "a1": Fraction(1, 2), "a2": Fraction(7, 10)})
    space = Space(JOINTS, given)
    due = parsed("a1 + a2*cos(theta2) = 0")
    exact = parsed("theta2 = acos(-5/7)", "theta2 = -acos(-5/7)")
    assert compare_sets(exact, due, space, "s").equal
    digits = f"{math.acos(-5 / 7):.12f}"
    found = compare_sets(parsed(f"theta2 = {digits}", f"theta2 = -{digits}"), due, space, "s")
    assert found.sound == (False, False) and found.rounded
