"""Singular sets: those of the textbook arms, sound and complete, and the solutions of single conditions."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from exercises.arm.chain import TASK_ROWS, Chain, Joint
from exercises.arm.classification import domain_of
from exercises.arm.derivation import derive
from exercises.arm.kinematics import NumericChain
from exercises.arm.searched import tried
from exercises.arm.singularity import (
    Component,
    Search,
    _changes_sign,
    _is_never_zero,
    common_zeros,
    singular_set,
    solve_condition,
    tidied,
)
from exercises.arm.trigonometry import factored
from exercises.formula.conditions import Space, compare_sets
from exercises.formula.expression import read
from exercises.formula.pieces import Piece, pieces
from exercises.formula.trees import Node
from exercises.stream import Stream
from exercises.verify.singular import singular_configurations
from tests.support import DATA

RECORDS = json.loads((DATA / "ground_truth.json").read_text(encoding="utf-8"))
PLAIN = [record["name"] for record in RECORDS if all(row[0] in "vw" and len(row) == 2 for row in record["task_rows"])]
PI = sp.pi
T1, T2, T3 = sp.symbols("theta1 theta2 theta3")
A1, A2, A3 = sp.symbols("a1 a2 a3")
R = sp.Rational


def claimed(components: Sequence[Component], joints: list[str]) -> list[Piece]:
    return [piece for part in components for text in part.pieces() for piece in pieces(read(text), joints)]


def stated(record: Mapping[str, Any], joints: list[str]) -> list[Piece]:
    together = [Node("and", tuple(read(text) for text in part["conditions"])) for part in record["singular_set"]]
    return [piece for node in together for piece in pieces(node, joints)]


@pytest.mark.parametrize("name", PLAIN)
def test_textbook_singular_sets(name: str, textbook_arms: Mapping[str, Any]) -> None:
    arm = textbook_arms[name]
    joints = [q.name for q in arm.chain.q]
    found = singular_set(arm.chain)
    assert found is not None
    space = Space(joints, domain_of(arm.chain))
    compared = compare_sets(claimed(found, joints), stated(arm.record, joints), space, name)
    assert compared.equal
    assert all(compared.covered)
    assert all(compared.sound)


@pytest.mark.parametrize("name", [name for name in PLAIN if name != "cartesian_PPP"])
def test_every_singular_configuration_found_by_search_is_in_the_set(
    name: str, textbook_arms: Mapping[str, Any]
) -> None:
    chain = textbook_arms[name].chain
    joints = [q.name for q in chain.q]
    stream = Stream(name)
    lengths = {symbol.name: stream.uniform(0.3, 1.0) for symbol in chain.parameters}
    starts = np.array([[stream.uniform(-3, 3) for _ in joints] for _ in range(12)])
    q = singular_configurations(NumericChain(chain, lengths), starts, [TASK_ROWS.index(row) for row in chain.task])
    assert len(q)
    space = Space(joints, domain_of(chain, lengths))
    values = {**dict(zip(joints, q.T, strict=True)), **{k: np.full(len(q), v) for k, v in lengths.items()}}
    found = singular_set(chain)
    assert found is not None
    assert space.contains(claimed(found, joints), values, len(q)).all()


def test_the_books_singular_set_of_the_scorbot_is_not_ours(textbook_arms: Mapping[str, Any]) -> None:
    """Printed: s2 = 0 and s3 = 0; right: s3 = 0 or the shoulder."""
    chain = textbook_arms["elbow_RRR_shoulder_offset_(Scorbot_point_P)"].chain
    joints = [q.name for q in chain.q]
    ours = claimed(singular_set(chain) or (), joints)
    for printed in ("And(Eq(sin(theta2), 0), Eq(sin(theta3), 0))", "sin(theta3) = 0", "[s2 = 0, s3 = 0]"):
        assert not compare_sets(pieces(read(printed), joints), ours, Space(joints, domain_of(chain)), "book").equal


def elbow(a1: sp.Expr, a2: sp.Expr, a3: sp.Expr) -> Chain:
    joints = (
        Joint("R", T1, sp.Symbol("d1"), a1, -PI / 2),
        Joint("R", T2, 0, a2, 0),
        Joint("R", T3, 0, a3, 0),
    )
    return Chain("elbow", joints, ("vx", "vy", "vz"))


def test_a_shoulder_that_the_numbers_rule_out_is_no_component() -> None:
    assert len(singular_set(elbow(R(1, 10), R(1, 2), R(2, 5))) or ()) == 2
    assert len(singular_set(elbow(R(2), R(1, 2), R(2, 5))) or ()) == 1


def test_a_shoulder_that_the_arm_just_touches_adds_nothing() -> None:
    """a1 = a2 + a3: the point is above the shoulder in one configuration, and there it is stretched out."""
    tenths = [sp.Rational(n, 10) for n in (8, 5, 3)]
    joints = [
        Joint("R", sp.Symbol(f"theta{i + 1}"), sp.S.Zero, a, alpha)
        for i, (a, alpha) in enumerate(zip(tenths, (sp.pi / 2, sp.S.Zero, sp.S.Zero), strict=True))
    ]
    elbow_, *others = singular_set(Chain("touching", tuple(joints), ("vx", "vy", "vz"))) or ()
    assert elbow_.pieces() == ["theta3 = 0", "theta3 = pi"]
    assert not others


def test_the_task_decides_what_is_singular() -> None:
    flat = Chain("2R", (Joint("R", T1, 0, A1, 0), Joint("R", T2, 0, A2, 0)), ("vx", "vy"))
    assert [part.pieces() for part in singular_set(flat) or ()] == [["theta2 = 0", "theta2 = pi"]]
    assert singular_set(flat.with_task("vx", "vy", "vz", "wx", "wy", "wz")) == ()
    assert singular_set(flat.with_task("vx", "vz")) is None


def test_what_follows_from_other_conditions_is_not_said() -> None:
    """Two slides and three parallel axes: with s2 = 0 the long condition is that a4 c4 + a5 c45 = 0 once more."""
    q = [sp.Symbol(name) for name in ("d1", "theta2", "d3", "theta4", "theta5")]
    a2, a4, a5 = sp.symbols("a2 a4 a5")
    zero, quarter = sp.S.Zero, PI / 2
    rows = [("P", zero, q[0], sp.S.One, -quarter), ("R", q[1], zero, a2, zero), ("P", quarter, q[2], zero, quarter),
            ("R", q[3], zero, a4, zero), ("R", q[4], zero, a5, zero)]  # fmt: skip
    joints = tuple(Joint(kind, t, d, a, alpha) for kind, t, d, a, alpha in rows)
    found = [component.conditions for component in singular_set(Chain("PRPRR", joints, ("vx", "vy", "vz"))) or ()]
    assert sorted(map(len, found)) == [2, 3]
    assert not any(set(one) < set(other) for one in found for other in found)


@pytest.mark.parametrize("end", [1 - sp.sin(T1), 1 + sp.sin(T1), 1 + sp.cos(T1), 1 - sp.cos(T1)])
def test_what_follows_where_an_angle_is_at_an_end_is_not_said(end: sp.Expr) -> None:
    there = {T1: solve_condition(end, arm("vx", ("R", T1, 0, 1, 0)))[1][0]}  # type: ignore[index]
    long = sp.expand(end * A1 + sp.sin(T2 - there[T1] + T1))
    told = tidied([(end, sp.sin(T2), long)], Search((T1, T2)), "what is tried")
    assert [set(one) for one in told] == [{end, sp.sin(T2)}]


def test_of_two_ways_that_are_the_same_one_is_kept() -> None:
    """Each lies in the other, so that both were left out, and singular configurations of an arm were missing."""
    same = [(sp.cos(T1), sp.sin(T2)), (sp.cos(T1), A1 * sp.cos(T1) + sp.sin(T1) * sp.sin(T2))]
    for ways in (same, same[::-1], [*same, (sp.cos(T1), sp.sin(T2), sp.cos(T3))]):
        assert [set(one) for one in tidied(ways, Search((T1, T2, T3)), "what is tried")] == [set(same[0])]


def test_of_two_components_with_the_same_joint_values_one_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    told = [(sp.sin(T2),), (-sp.sin(T2),), (1 - sp.cos(T2),)]
    monkeypatch.setattr("exercises.arm.singularity._filled", lambda *_: ((conditions, True) for conditions in told))
    chain = Chain("two of one kind", (Joint("R", T1, 0, A1, 0), Joint("R", T2, 0, A2, 0)), ("vx", "vy"))
    assert [one.pieces() for one in singular_set(chain) or ()] == [["theta2 = 0", "theta2 = pi"]]


@pytest.mark.whole
def test_long_conditions_that_never_hold_together_are_not_said() -> None:
    """It was said that J loses rank at theta3 = 180 and at 0 degrees under seven more conditions, which never hold."""
    t4, d5 = sp.symbols("theta4 d5")
    chain = arm(
        "vx vy", ("R", T1, R(7, 10), R(1, 5), PI), ("R", T2 + PI / 6, 0, R(3, 10), PI / 4),
        ("R", T3 + PI / 2, 0, -R(1, 5), PI / 2), ("R", t4 + PI / 6, R(1, 5), 0, -PI / 2),
        ("P", PI / 2, d5 + R(1, 10), 0, PI / 2),
    )  # fmt: skip
    found = singular_set(chain)
    assert found is not None and len(found) == 3
    out = tried(chain, [one.conditions for one in found])
    assert all(out.samples) and not out.wrong and not out.unexplained


def test_offsets_move_the_solutions() -> None:
    joints = (Joint("R", T1, 0, A1, 0), Joint("R", T2 + PI / 3, 0, A2, 0))
    (component,) = singular_set(Chain("2R", joints, ("vx", "vy"))) or ()
    assert set(component.pieces()) == {"theta2 = -pi/3", "theta2 = 2*pi/3"}


@pytest.mark.parametrize(
    ("condition", "values"),
    [
        (sp.sin(T2), {0.0, np.pi}),
        (sp.cos(T2), {np.pi / 2, -np.pi / 2}),
        (sp.sin(T2 + PI / 4), {-np.pi / 4, 3 * np.pi / 4}),
        (3 * sp.sin(T2) + 4 * sp.cos(T2), {-np.arctan(4 / 3), np.pi - np.arctan(4 / 3)}),
        (1 + 2 * sp.cos(T2), {2 * np.pi / 3, -2 * np.pi / 3}),
        (1 + 2 * sp.sin(T2), {-np.pi / 6, -5 * np.pi / 6}),
        (2 + sp.cos(T2), set()),
        (3 + sp.cos(T2) + sp.sin(T2), set()),
    ],
)
def test_a_condition_on_one_angle_is_solved(condition: sp.Expr, values: set[float]) -> None:
    chain = Chain("2R", (Joint("R", T1, 0, A1, 0), Joint("R", T2, 0, A2, 0)), ("vx", "vy"))
    solved = solve_condition(condition, chain)
    assert solved is not None
    assert solved[0] == T2
    assert sorted(float(value) for value in solved[1]) == pytest.approx(sorted(values))


def test_every_solution_of_a_trig_solves_it() -> None:
    chain = Chain("2R", (Joint("R", T1, 0, A1, 0), Joint("R", T2, 0, A2, 0)), ("vx", "vy"))
    for a, b, c in [(1, 2, 3), (-1, 2, -3), (0, 1, -5), (2, 0, -3), (-1, -4, 0), (0, -1, 2)]:
        trig = a + b * sp.cos(T2 + PI / 7) + c * sp.sin(T2 + PI / 7)
        solved = solve_condition(trig, chain)
        assert solved is not None
        assert len(solved[1]) == 2
        for value in solved[1]:
            assert abs(float(trig.subs(T2, value))) < 1e-12
            assert -np.pi - 1e-12 < float(value) <= np.pi + 1e-12


def test_a_condition_on_several_joints_stays_a_condition() -> None:
    assert solve_condition(A1 + A2 * sp.cos(T2) + A3 * sp.cos(T2 + T3), elbow(A1, A2, A3)) is None
    shoulder = singular_set(elbow(A1, A2, A3)) or ()
    assert shoulder[1].solutions is None
    assert shoulder[1].pieces() == ["a1 + a2*cos(theta2) + a3*cos(theta2 + theta3) = 0"]


def test_a_slide_is_solved_for_its_travel() -> None:
    joints = (Joint("R", T1, 0, 0, PI / 2), Joint("P", 0, sp.Symbol("d2") + R(1, 4), 0, 0))
    (component,) = singular_set(Chain("RP", joints, ("vx", "vy"))) or ()
    assert component.pieces() == ["d2 = -1/4"]


def test_symmetric_arms_have_symmetric_sets(textbook_arms: Mapping[str, Any]) -> None:
    """Turning or moving the base changes no singularity."""
    chain = textbook_arms["elbow_RRR"].chain
    moved = replace(chain, base=replace(chain.base, position=(R(1), R(2), R(3)), yaw=PI / 6, tilt=PI / 2))
    joints = [q.name for q in chain.q]
    ours, theirs = (claimed(singular_set(c) or (), joints) for c in (moved, chain))
    assert compare_sets(ours, theirs, Space(joints, domain_of(chain)), "moved").equal


def test_a_seven_joint_arm_is_singular_in_four_ways() -> None:
    """Elbow straight; or shoulder and wrist in line with their neighbours (known of every arm of this kind)."""
    twists, lengths = (-1, 1, 1, -1, -1, 1, 0), ("d1", 0, "d3", 0, "d5", 0, 0)
    joints = tuple(
        Joint("R", sp.Symbol(f"theta{i}"), d, 0, twist * sp.pi / 2)
        for i, (twist, d) in enumerate(zip(twists, lengths, strict=True), 1)
    )
    found = singular_set(Chain("lbr", joints, TASK_ROWS))
    assert found is not None
    assert [{str(condition) for condition in component.conditions} for component in found] == [
        {"sin(theta4)"},
        {"sin(theta2)", "sin(theta6)"},
        {"sin(theta2)", "cos(theta3)"},
        {"sin(theta6)", "cos(theta5)"},
    ]


@pytest.mark.parametrize("twist", [(1, -1), (-1, 1)])
def test_minors_of_six_rows_are_those_of_the_task_jacobian(twist: tuple[int, int]) -> None:
    a, b = (side * sp.pi / 2 for side in twist)
    rows = [("d1", "a1", a), (0, "a2", 0), (0, "a3", b), ("d4", 0, a), (0, 0, b), ("d6", 0, 0)]
    joints = tuple(Joint("R", sp.Symbol(f"theta{i}"), *row) for i, row in enumerate(rows, 1))
    chain = Chain("6R", joints, TASK_ROWS)
    values = {symbol: 0.3 + 0.17 * i for i, symbol in enumerate((*chain.q, *chain.parameters))}
    direct = sp.lambdify([], derive(chain).jacobian.xreplace(values))()
    assert float(derive(chain).determinant.xreplace(values)) == pytest.approx(float(np.linalg.det(direct)), rel=1e-9)


def test_a_condition_may_hold_at_one_root_of_an_angle_only() -> None:
    """Both minors are zero at theta1 = 0 and not at pi: 1 - cos(theta1) = 0 says so."""
    theta = sp.Symbol("theta1")
    minors = (factored(sp.sin(theta)), factored(1 - sp.cos(theta)))
    (conjunction,) = common_zeros(minors, Search((theta,))) or [()]
    assert conjunction == (1 - sp.cos(theta),)
    chain = Chain("arm", (Joint("R", theta, 0, 1, 0),), ("vx",))
    assert solve_condition(conjunction[0], chain) == (theta, (0,))


def arm(task: str, *rows: tuple[Any, ...]) -> Chain:
    return Chain("own", tuple(Joint(*row) for row in rows), tuple(task.split()))


def symbol(name: str) -> sp.Symbol:
    return sp.Symbol(name, positive=True)


D1, D2, P1, P2, P4 = (symbol(name) for name in ("d1", "d2", "a1", "a2", "a4"))


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
    joints = [q.name for q in chain.q]
    found = singular_set(chain)
    assert found is not None
    if not right:
        assert found == ()
        return
    reference = [piece for text in right for piece in pieces(read(text), joints)]
    assert compare_sets(claimed(found, joints), reference, Space(joints, domain_of(chain)), "never").equal


def drawn_arm(stream: Stream) -> Chain:
    """Return an arm of two or three joints as nobody would draw one: any twists, slides in any order, some numbers."""
    rows = []
    for i in range(1, 3 + (stream.uniform(0, 1) < 0.6)):
        a, d = (
            stream.choice([0, 0, sp.Symbol(f"{name}{i}", positive=True), R(int(stream.uniform(1, 10)), 10)])
            for name in ("a", "d")
        )
        alpha = stream.choice([0, PI / 2, -PI / 2, PI, PI / 3])
        slide = stream.uniform(0, 1) < 0.25
        joint = ("P", stream.choice([0, PI / 4]), sp.Symbol(f"d{i}")) if slide else ("R", sp.Symbol(f"theta{i}"), d)
        rows.append((*joint, a, alpha))
    return arm(stream.choice(["vx vy", "vx vy vz", "vx vz", "vx vy wz", "vx vy vz wx wy wz"]), *rows)


@pytest.mark.parametrize("seed", [*range(30), 315])
def test_every_piece_said_of_a_drawn_arm_is_there_and_costs_rank(seed: int) -> None:
    stream = Stream(f"drawn arms/{seed}")
    chain = drawn_arm(stream)
    joints, task = [q.name for q in chain.q], [TASK_ROWS.index(row) for row in chain.task]
    for piece in claimed(singular_set(chain) or (), joints):
        found = 0
        for _ in range(60):
            lengths = {symbol.name: 2 * 10 ** stream.uniform(-2, 0.5) for symbol in chain.parameters}
            space = Space(joints, domain_of(chain, lengths))
            values = space.on_piece(piece, space.names_of([[piece]]), stream, count=6)
            q = np.stack([values[joint] for joint in joints], axis=1)
            found += len(q)
            sigma = np.linalg.svd(NumericChain(chain, lengths).jacobian(q)[:, task], compute_uv=False)
            assert (sigma[:, -1] < 1e-7 * np.maximum(sigma[:, 0], 1e-6)).all(), (chain, piece)
            if found:
                break
        assert found, (chain, piece)


def special_arm(stream: Stream) -> Chain:
    """Return an arm in numbers that are few: equal lengths and twists, and sums that vanish, are common."""
    rows = []
    for i in range(1, 3 + (stream.uniform(0, 1) < 0.7)):
        a, d = (stream.choice([0, R(1, 2), R(1, 2), R(1, 4), 1]) for _ in "ad")
        alpha = stream.choice([0, PI / 4, PI / 4, -PI / 4, PI / 2, PI / 3, 2 * PI / 3])
        slide = stream.uniform(0, 1) < 0.3
        joint = ("P", stream.choice([0, PI / 4]), sp.Symbol(f"d{i}")) if slide else ("R", sp.Symbol(f"theta{i}"), d)
        rows.append((*joint, a, alpha))
    return arm(stream.choice(["vz", "vx vy", "vx vy vz", "wz", "vx wz", "vx vy wz", "wx wy"]), *rows)


DRAWN = {"drawn": drawn_arm, "special": special_arm}


@pytest.mark.parametrize("kind", DRAWN)
@pytest.mark.parametrize("seed", range(30))
def test_every_singular_configuration_of_a_drawn_arm_is_in_its_set(seed: int, kind: str) -> None:
    stream = Stream(f"{kind} arms/{seed}")
    chain = DRAWN[kind](stream)
    joints, task = [q.name for q in chain.q], [TASK_ROWS.index(row) for row in chain.task]
    said = singular_set(chain)
    lengths = {symbol.name: stream.uniform(0.3, 1.0) for symbol in chain.parameters}
    starts = np.array([[stream.uniform(-3, 3) for _ in joints] for _ in range(12)])
    q = singular_configurations(NumericChain(chain, lengths), starts, task)
    if said is None:
        assert len(q) == len(starts), chain  # J loses rank wherever one looks
        return
    values = {**dict(zip(joints, q.T, strict=True)), **{k: np.full(len(q), v) for k, v in lengths.items()}}
    space = Space(joints, domain_of(chain, lengths))
    assert space.contains(claimed(said, joints), values, len(q)).all(), (chain, said)


def test_equal_twists_of_an_arm_make_singular_what_in_general_is_not() -> None:
    """At theta2 = 0 the slide is level, whatever its travel, as the two twists make up a right angle."""
    rows = [("R", "theta1", 0, 0, PI / 4), ("R", "theta2", 0, 0, PI / 4), ("P", 0, "d3", 0, 0)]
    (found,) = singular_set(arm("vz", *rows)) or ()
    assert found.solutions == ((sp.Symbol("theta2"), (0,)),)


def test_long_conditions_come_down_to_values_of_joints() -> None:
    """An arm of which ten minors vanished together in nine conditions at a time: joints are put into one another."""
    joints = (
        Joint("R", sp.Symbol("theta1"), R(7, 10), R(1, 5), PI),
        Joint("R", sp.Symbol("theta2") + PI / 6, 0, R(3, 10), PI / 4),
        Joint("R", sp.Symbol("theta3") + PI / 2, 0, -R(1, 5), PI / 2),
        Joint("R", sp.Symbol("theta4") + PI / 6, R(1, 5), 0, -PI / 2),
        Joint("P", PI / 2, sp.Symbol("d5") + R(1, 10), 0, PI / 2),
    )
    chain = Chain("oblique", joints, ("vx", "vy"))
    found = singular_set(chain)
    assert found is not None
    assert all(component.solutions is not None for component in found)
    assert sorted(text for component in found for text in component.pieces()) == sorted(
        f"d5 = {d5} and theta2 = {theta2} and theta3 = {theta3} and theta4 = {theta4}"
        if d5 != "-1/10"
        else f"d5 = {d5} and theta2 = {theta2} and theta4 = {theta4} and theta3 = {theta3}"
        for d5, seconds, thirds, fourths in (
            ("1/10", ("-pi/6", "5*pi/6"), ("0", "pi"), ("-2*pi/3",)),
            ("-3/10", ("-pi/6", "5*pi/6"), ("0", "pi"), ("pi/3",)),
            ("-1/10", ("-pi/6", "5*pi/6"), ("pi/4", "-3*pi/4"), ("-pi/6", "5*pi/6")),
        )
        for theta2 in seconds
        for theta3 in thirds
        for theta4 in fourths
    )
    out = tried(chain, [component.conditions for component in found])
    assert all(out.samples)
    assert not out.wrong
    assert not out.unexplained


def test_what_is_put_into_others_rules_ways_out() -> None:
    """Where d3 = 0, a1 + d3 s2 is a1: the two never vanish together."""
    slide = sp.Symbol("d3")
    joints = (T1, T2, slide)
    assert tidied([(slide, A1 + slide * sp.sin(T2), sp.cos(T1))], Search(joints), "") == []
    (way,) = tidied([(slide, sp.sin(T2) + slide * sp.cos(T1))], Search(joints), "")
    assert set(way) == {slide, sp.sin(T2)}


def test_two_lines_whose_slopes_are_never_in_line_never_hold_together() -> None:
    """Of -3 s4 + 3 c4 c5 - 2 c4 and -3 s4 c5 + 2 s4 - 3 c4, what decides is (3 c5 - 2)^2 + 9, without a root."""
    t4, t5 = sp.symbols("theta4 theta5")
    s4, c4, c5 = sp.sin(t4), sp.cos(t4), sp.cos(t5)
    never = (-3 * s4 + 3 * c4 * c5 - 2 * c4, -3 * s4 * c5 + 2 * s4 - 3 * c4)
    sometimes = (-3 * s4 + 3 * c4 * c5 - 2 * c4, 3 * s4 * c5 - 2 * s4 - 3 * c4)
    assert tidied([never], Search((t4, t5)), "") == []
    assert len(tidied([sometimes], Search((t4, t5)), "")) == 1


def test_a_sum_of_squares_has_one_sign_and_a_difference_two() -> None:
    """What has both signs vanishes somewhere, and no algebra is needed to see it."""
    search, c3 = Search((T2, T3)), sp.cos(T3)
    square = (A1 * sp.cos(T2) - A2) ** 2
    for never, expression in ((True, square + A2**2), (True, -square - A2**2), (False, square - A2**2 * c3)):
        assert _changes_sign(expression, search) is not never
        assert _is_never_zero(expression, search) is never
