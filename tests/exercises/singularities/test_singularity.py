"""Singular sets: those of the textbook arms, sound and complete, and which conditions can hold together."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.trigonometry import factor_trig
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import ConfigurationSpace
from qdot.exercises.singularities.classification import make_domain
from qdot.exercises.singularities.joint_solvability import drop_implied, is_implied, may_hold_simultaneously
from qdot.exercises.singularities.singular_set import (
    Search,
    find_common_zeros,
    find_singular_set,
    solve_condition,
    tidy_branches,
)
from tests.exercises.arm.sets import compare_with_book, compute_rank_ratios, read_singular_set, search_singularities
from tests.support.suites import select_for_suite

PI = sp.pi
T1, T2, T3 = sp.symbols("theta1 theta2 theta3")
A1, A2, A3 = sp.symbols("a1 a2 a3")
R = sp.Rational


def symbol(name: str) -> sp.Symbol:
    return sp.Symbol(name, positive=True)


def arm(task: str, *rows: tuple[Any, ...]) -> Chain:
    return Chain("own", tuple(Joint(*row) for row in rows), tuple(task.split()))


D1, D2, P1, P2, P4 = (symbol(name) for name in ("d1", "d2", "a1", "a2", "a4"))
TWO = arm("vx vy", ("R", T1, 0, A1, 0), ("R", T2, 0, A2, 0))


def elbow(a1: sp.Expr, a2: sp.Expr, a3: sp.Expr) -> Chain:
    return arm("vx vy vz", ("R", T1, sp.Symbol("d1"), a1, -PI / 2), ("R", T2, 0, a2, 0), ("R", T3, 0, a3, 0))


@pytest.mark.parametrize(("a1", "components"), [(R(1, 10), 2), (R(9, 10), 1), (R(2), 1)])
def test_a_shoulder_is_no_component_where_the_arm_does_not_reach_it_or_just_touches_it(
    a1: sp.Expr, components: int
) -> None:
    """a1 = a2 + a3: the point is above the shoulder in one configuration, and there it is stretched out."""
    elbow_, *others = find_singular_set(elbow(a1, R(1, 2), R(2, 5))) or ()
    assert elbow_.list_pieces() == ["theta3 = 0", "theta3 = pi"]
    assert len(others) == components - 1


def test_the_task_decides_what_is_singular() -> None:
    assert [part.list_pieces() for part in find_singular_set(TWO) or ()] == [["theta2 = 0", "theta2 = pi"]]
    assert find_singular_set(TWO.with_task(*VELOCITY_NAMES)) == ()
    assert find_singular_set(TWO.with_task("vx", "vz")) is None


def test_what_follows_from_other_conditions_is_not_said() -> None:
    """Two slides and three parallel axes: with s2 = 0 the long condition is that a4 c4 + a5 c45 = 0 once more."""
    q = [sp.Symbol(name) for name in ("d1", "theta2", "d3", "theta4", "theta5")]
    a2, a4, a5 = sp.symbols("a2 a4 a5")
    chain = arm(
        "vx vy vz", ("P", 0, q[0], 1, -PI / 2), ("R", q[1], 0, a2, 0), ("P", PI / 2, q[2], 0, PI / 2),
        ("R", q[3], 0, a4, 0), ("R", q[4], 0, a5, 0),
    )  # fmt: skip
    found = [component.conditions for component in find_singular_set(chain) or ()]
    assert sorted(map(len, found)) == [2, 3]
    assert not any(set(one) < set(other) for one in found for other in found)


@pytest.mark.parametrize("end", [1 - sp.sin(T1), 1 + sp.sin(T1), 1 + sp.cos(T1), 1 - sp.cos(T1)])
def test_what_follows_where_an_angle_is_at_an_end_is_not_said(end: sp.Expr) -> None:
    there = {T1: solve_condition(end, arm("vx", ("R", T1, 0, 1, 0)))[1][0]}  # type: ignore[index]
    long = sp.expand(end * A1 + sp.sin(T2 - there[T1] + T1))
    told = tidy_branches([(end, sp.sin(T2), long)], Search((T1, T2)), "what is tried")
    assert [set(one) for one in told] == [{end, sp.sin(T2)}]


def test_of_two_ways_that_are_the_same_one_is_kept() -> None:
    """Each lies in the other, so that both were left out, and singular configurations of an arm were missing."""
    same = [(sp.cos(T1), sp.sin(T2)), (sp.cos(T1), A1 * sp.cos(T1) + sp.sin(T1) * sp.sin(T2))]
    for ways in (same, same[::-1], [*same, (sp.cos(T1), sp.sin(T2), sp.cos(T3))]):
        assert [set(one) for one in tidy_branches(ways, Search((T1, T2, T3)), "what is tried")] == [set(same[0])]


def test_of_two_components_with_the_same_joint_values_one_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    told = [(sp.sin(T2),), (-sp.sin(T2),), (1 - sp.cos(T2),)]
    monkeypatch.setattr(
        "qdot.exercises.singularities.singular_set._substitute_values",
        lambda *_: ((conditions, True) for conditions in told),
    )
    chain = replace(TWO, name="two of one kind")
    assert [one.list_pieces() for one in find_singular_set(chain) or ()] == [["theta2 = 0", "theta2 = pi"]]


@pytest.mark.parametrize(
    ("chain", "values"),
    [
        (arm("vx vy", ("R", T1, 0, A1, 0), ("R", T2 + PI / 3, 0, A2, 0)), {"theta2 = -pi/3", "theta2 = 2*pi/3"}),
        (arm("vx vy", ("R", T1, 0, 0, PI / 2), ("P", 0, sp.Symbol("d2") + R(1, 4), 0, 0)), {"d2 = -1/4"}),
        # the slide is level, whatever its travel, as the two twists make up a right angle
        (arm("vz", ("R", T1, 0, 0, PI / 4), ("R", T2, 0, 0, PI / 4), ("P", 0, sp.Symbol("d3"), 0, 0)), {"theta2 = 0"}),
    ],
)
def test_values_are_those_of_the_joints_with_their_zeros(chain: Chain, values: set[str]) -> None:
    (component,) = find_singular_set(chain) or ()
    assert {*component.list_pieces()} == values


@pytest.mark.parametrize(
    ("condition", "count"),
    [
        *((a + b * sp.cos(T2 + PI / 7) + c * sp.sin(T2 + PI / 7), 2)
          for a, b, c in [(1, 2, 3), (-1, 2, -3), (0, 1, -5), (2, 0, -3), (-1, -4, 0), (0, -1, 2), (1, 0, 2)]),
        (sp.sin(T2), 2), (sp.cos(T2), 2), (1 + sp.cos(T2), 1), (2 + sp.cos(T2), 0), (3 + sp.cos(T2) + sp.sin(T2), 0),
    ],
)  # fmt: skip
def test_every_solution_of_a_condition_on_one_angle_solves_it(condition: sp.Expr, count: int) -> None:
    joint, values = solve_condition(condition, TWO) or (None, ())
    assert joint == T2 and len({*values}) == count
    for value in values:
        assert abs(float(condition.subs(T2, value))) < 1e-12
        assert -np.pi - 1e-12 < float(value) <= np.pi + 1e-12


def test_a_condition_on_several_joints_stays_a_condition() -> None:
    assert solve_condition(A1 + A2 * sp.cos(T2) + A3 * sp.cos(T2 + T3), elbow(A1, A2, A3)) is None
    shoulder = find_singular_set(elbow(A1, A2, A3)) or ()
    assert shoulder[1].solutions is None
    assert shoulder[1].list_pieces() == ["a1 + a2*cos(theta2) + a3*cos(theta2 + theta3) = 0"]


def test_a_condition_may_hold_at_one_root_of_an_angle_only() -> None:
    """Both minors are zero at theta1 = 0 and not at pi: 1 - cos(theta1) = 0 says so."""
    theta = sp.Symbol("theta1")
    minors = (factor_trig(sp.sin(theta)), factor_trig(1 - sp.cos(theta)))
    (conjunction,) = find_common_zeros(minors, Search((theta,))) or [()]
    assert conjunction == (1 - sp.cos(theta),)
    chain = Chain("arm", (Joint("R", theta, 0, 1, 0),), ("vx",))
    assert solve_condition(conjunction[0], chain) == (theta, (0,))


@pytest.mark.parametrize(
    ("chain", "right"),
    [
        # Besides c2 = 0 it was said: theta2 = 0 with theta1 at arctan(d2/a2) and at -arctan(a2/d2).
        (arm("vx vy vz", ("R", T1, D1, 0, PI / 2), ("R", T2, D2, P2, 0)), ["theta2 = pi/2", "theta2 = -pi/2"]),
        (arm("vx vy vz", ("R", T1, 0, R(7, 10), PI / 2), ("R", T2, D2, P2, 0)), []),
        (arm("vx vy vz", ("P", PI / 4, sp.Symbol("d1"), P1, PI / 3), ("R", T2, R(3, 5), P2, -PI / 2)), []),
        # A sine and a cosine of theta1 were to vanish together, of which one had been left out as if it followed.
        (arm("vx vy wz", ("R", T1, 0, R(1, 5), PI / 3), ("R", T2, 0, R(7, 10), 0)), []),
        # It was said: theta3 = arccos(-9/4 - 5 a1/2), which no length allows.
        (
            arm(
                "vx vy", ("R", T1, D1, P1, 0), ("P", 0, sp.Symbol("d2"), R(9, 10), PI / 2),
                ("R", T3, 0, R(2, 5), -PI / 2), ("R", sp.Symbol("theta4"), 0, P4, 0),
            ),
            [f"theta3 = {one} and theta4 = {other}" for one in ("0", "pi") for other in ("0", "pi")]
            + ["2/5 + a4*cos(theta4) = 0 and 2/5 + (a1 + 9/10)*cos(theta3) = 0"],
        ),
    ],
)  # fmt: skip
def test_conditions_that_never_hold_together_are_not_said(chain: Chain, right: list[str]) -> None:
    found = find_singular_set(chain)
    assert found is not None and bool(found) is bool(right)
    assert compare_with_book(chain, read_singular_set(chain), right).are_equal


@dataclass(frozen=True)
class Drawn:
    """A way to generate unusual arms: any twists, prismatic joints in any order, some numbers."""

    name: str
    lengths: Callable[[str], list[sp.Expr | int]]
    twists: list[sp.Expr]
    tasks: list[str]

    def arm(self, stream: Stream) -> Chain:
        rows = []
        for i in range(1, 3 + (stream.uniform(0, 1) < 0.65)):
            a, d = (stream.choice([*self.lengths(f"{name}{i}"), R(int(stream.uniform(1, 10)), 10)]) for name in "ad")
            slide, alpha = stream.uniform(0, 1) < 0.25, stream.choice(self.twists)
            joint = ("P", stream.choice([0, PI / 4]), sp.Symbol(f"d{i}")) if slide else ("R", f"theta{i}", d)
            rows.append((*joint, a, alpha))
        return arm(stream.choice(self.tasks), *rows)


DRAWN = [
    Drawn("open", lambda name: [0, 0, symbol(name)], [0, PI / 2, -PI / 2, PI, PI / 3],
          ["vx vy", "vx vy vz", "vx vz", "vx vy wz", " ".join(VELOCITY_NAMES)]),
    # equal lengths and twists, and sums that vanish, are common
    Drawn("special", lambda name: [0, 0, R(1, 2), R(1, 2), R(1, 4), 1],
          [0, PI / 4, PI / 4, -PI / 4, PI / 2, PI / 3, 2 * PI / 3],
          ["vz", "vx vy", "vx vy vz", "wz", "vx wz", "vx vy wz", "wx wy"]),
]  # fmt: skip


def assert_sound(chain: Chain, stream: Stream) -> None:
    """Assert that there are configurations on every piece for some lengths, and J has lost rank there."""
    joints = [q.name for q in chain.q]
    for piece in read_singular_set(chain):
        for _ in range(60):
            lengths = {symbol.name: 2 * 10 ** stream.uniform(-2, 0.5) for symbol in chain.parameters}
            space = ConfigurationSpace(joints, make_domain(chain, lengths))
            values = space.sample_piece(piece, space.collect_names([[piece]]), stream, count=6)
            q = np.stack([values[joint] for joint in joints], axis=1)
            assert (compute_rank_ratios(NumericChain(chain, lengths), chain, q) < 1e-7).all(), (chain, piece)
            if len(q):
                break
        else:
            pytest.fail(f"no configuration of {chain} is on {piece}")


@pytest.mark.parametrize(("kind", "first"), select_for_suite([(0, 5), (1, 10)], [*product((0, 1), range(0, 30, 5))]))
def test_the_set_of_an_arm_as_nobody_would_draw_it_is_sound_and_complete(kind: int, first: int) -> None:
    arms = DRAWN[kind]
    for seed in range(first, first + 5):
        stream = Stream(f"{arms.name}/{seed}")
        chain = arms.arm(stream)
        found = search_singularities(chain, f"{arms.name}/{seed}")
        if find_singular_set(chain) is None:
            assert len(found.reached) == len(found.starts), chain  # J loses rank wherever one looks
            continue
        assert found.are_in(read_singular_set(chain)).all(), (seed, chain)
        assert_sound(chain, stream)


T = sp.symbols("theta1:4")
A, B, H, ALPHA = sp.symbols("a1 a2 h alpha1")
SLIDE = sp.Symbol("d3")
s, c = sp.sin, sp.cos
NEVER_IN_GENERAL: list[tuple[sp.Expr, ...]] = [
    (s(T[0]), c(T[0])), (A * c(T[0]) + B * s(T[0]), A * s(T[0]) - B * c(T[0])),
    (A + B * c(T[1]), H + B * s(T[1])),  # for a2^2 = a1^2 + h^2 only
    (SLIDE - A, SLIDE + A), (c(T[0]) - c(ALPHA), s(T[0]) - 2 * s(ALPHA)),
    (c(T[0]) - c(R(7, 10)), c(2 * T[0]) - c(R(3, 5))), (c(T[0]) - sp.sqrt(5) / 3, s(T[0]) - R(1, 3)),
]  # fmt: skip
POSSIBLE: list[tuple[sp.Expr, ...]] = [
    (s(T[0]), s(2 * T[0])), (c(T[0]) - c(sp.pi / 7), c(2 * T[0]) - c(2 * sp.pi / 7)),
    (c(T[0]) - c(R(3, 10)), c(2 * T[0]) - c(R(6, 10))),
    (c(T[0]) - c(ALPHA), c(2 * T[0]) - c(2 * ALPHA), c(T[0] / 1) - c(ALPHA)),
    (c(T[0]) - c(ALPHA / 2), 2 * c(T[0]) ** 2 - 1 - c(ALPHA)), (c(T[0]) - sp.sqrt(5) / 3, s(T[0]) - R(2, 3)),
    (c(T[0]) - sp.sqrt(6) / 3, s(T[0]) - sp.sqrt(3) / 3), (A + B * c(T[1]), SLIDE - H),
]  # fmt: skip


@pytest.mark.parametrize("conditions", [*NEVER_IN_GENERAL, *POSSIBLE])
def test_impossible_combinations_are_recognised_and_possible_ones_kept(conditions: tuple[sp.Expr, ...]) -> None:
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
