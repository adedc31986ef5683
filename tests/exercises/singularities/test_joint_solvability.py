"""Test which combinations of conditions can hold at the same time, in exact arithmetic."""

import pytest
import sympy as sp

from qdot.exercises.common.stream import Stream
from qdot.exercises.singularities.joint_solvability import drop_implied, is_implied, may_hold_simultaneously

T = sp.symbols("theta1:4")
A, B, H, ALPHA = sp.symbols("a1 a2 h alpha1")
SLIDE = sp.Symbol("d3")
R = sp.Rational
s, c = sp.sin, sp.cos


NEVER_IN_GENERAL: list[tuple[sp.Expr, ...]] = [
    (s(T[0]), c(T[0])),
    (A * c(T[0]) + B * s(T[0]), A * s(T[0]) - B * c(T[0])),
    (A + B * c(T[1]), H + B * s(T[1])),  # for a2^2 = a1^2 + h^2 only
    (SLIDE - A, SLIDE + A),
    (c(T[0]) - c(ALPHA), s(T[0]) - 2 * s(ALPHA)),
    (c(T[0]) - c(R(7, 10)), c(2 * T[0]) - c(R(3, 5))),
    (c(T[0]) - sp.sqrt(5) / 3, s(T[0]) - R(1, 3)),
]
POSSIBLE: list[tuple[sp.Expr, ...]] = [
    (s(T[0]), s(2 * T[0])),
    (c(T[0]) - c(sp.pi / 7), c(2 * T[0]) - c(2 * sp.pi / 7)),
    (c(T[0]) - c(R(3, 10)), c(2 * T[0]) - c(R(6, 10))),
    (c(T[0]) - c(ALPHA), c(2 * T[0]) - c(2 * ALPHA), c(T[0] / 1) - c(ALPHA)),
    (c(T[0]) - c(ALPHA / 2), 2 * c(T[0]) ** 2 - 1 - c(ALPHA)),
    (c(T[0]) - sp.sqrt(5) / 3, s(T[0]) - R(2, 3)),
    (c(T[0]) - sp.sqrt(6) / 3, s(T[0]) - sp.sqrt(3) / 3),
    (A + B * c(T[1]), SLIDE - H),
]


@pytest.mark.parametrize("conditions", [*NEVER_IN_GENERAL, *POSSIBLE])
def test_impossible_combinations_are_recognised_and_possible_ones_kept(
    conditions: tuple[sp.Expr, ...],
) -> None:
    assert may_hold_simultaneously(conditions, (*T, SLIDE)) is (conditions in POSSIBLE)


@pytest.mark.parametrize("seed", range(25))
def test_conditions_through_a_common_point_may_hold(seed: int) -> None:
    """Random sums; a constant is subtracted so that each vanishes at a common point with rational sines and cosines."""
    stream = Stream(f"together/{seed}")
    point: dict[sp.Expr, sp.Expr] = {}
    for joint in T[:2]:
        t = R(stream.integer(-9, 9), 7)
        point |= {c(joint): (1 - t**2) / (1 + t**2), s(joint): 2 * t / (1 + t**2)}
    conditions = []
    for _ in range(stream.integer(2, 4)):
        terms = [stream.integer(1, 9) * stream.choice(list(point)) * stream.choice([A, B, 1]) for _ in range(3)]
        total = sp.Add(*terms)
        conditions.append(total - total.xreplace(point))
    assert may_hold_simultaneously(conditions, T)


@pytest.mark.whole
def test_a_contradiction_between_some_conditions_excludes_all_of_them() -> None:
    """A Gröbner basis of all three would take too long, but two suffice. Fixed joints are substituted first."""
    whole = sum((s(q) * c(p) * A + c(q) ** 2 * B for q in T for p in T), H)
    assert not may_hold_simultaneously([whole, whole**2 + 1, whole**3 - A], T)
    five = sp.symbols("theta1:6")
    long = sum((s(q) * c(p) * A + c(q) ** 2 * B for q in five for p in five), H)
    fixed = [1 - c(five[0]), s(five[1]), c(five[2] + ALPHA), s(five[3]) * B + A]
    at_all = [*fixed, long - long.xreplace({five[4]: 0}), c(five[4])]
    assert not may_hold_simultaneously(at_all, five)
    assert may_hold_simultaneously(at_all[:-1], five)
    assert may_hold_simultaneously([*fixed, s(five[0]), s(2 * five[1]), c(2 * five[2] + 2 * ALPHA) + 1], five)


def test_slow_cases_stay_undecided() -> None:
    four = sp.symbols("theta1:5")
    whole = sum((s(q) * c(p) * A + c(q) ** 2 * B for q in four for p in four), H)
    assert may_hold_simultaneously([whole, whole + 1], four)


def test_a_condition_follows_from_others() -> None:
    assert is_implied(s(2 * T[0]), [s(T[0])], T)
    assert is_implied(c(T[0]), [A * c(T[0]) + B * s(T[0]), A * c(T[0]) - B * s(T[0])], T)
    assert not is_implied(s(T[0]), [s(2 * T[0])], T)
    assert not is_implied(s(T[1]), [s(T[0])], T)


def test_conditions_that_follow_from_others_are_left_out() -> None:
    long = A * c(T[0]) * s(T[1]) + B * s(T[0]) * c(T[1])
    assert drop_implied([s(T[0]), s(T[1]), long], T) == (s(T[0]), s(T[1]))
    assert drop_implied([s(T[0]), s(T[1]), long + c(T[0]) * H], T) == (s(T[0]), s(T[1]), long + c(T[0]) * H)


def test_a_higher_limit_decides_more_cases() -> None:
    """The minors of two rows and three columns: where the first column is not zero, two of them make the third one."""
    minors = [s(T[0]) * c(T[1]) - c(T[0]) * s(T[1]) * A, s(T[0]) * c(T[2]) * B - c(T[0]) * s(T[2])]
    third = A * s(T[1]) * c(T[2]) * B - c(T[1]) * s(T[2])
    assert not is_implied(third, minors, T, 10)
    assert is_implied(third, minors, T, 10_000)
