"""The kinds of singular configurations, and what an arm reaches, which decides whether they are at a boundary."""

import re
from collections.abc import Sequence
from itertools import product

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Base, Chain, Joint
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import make_symbolic_arm
from qdot.exercises.derivation.lengths import are_unrelated, replace_lengths_by_symbols, substitute_in_arm
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.singularities import reach, reason
from qdot.exercises.singularities.appearance import ZERO_TOLERANCE, Statement, describe_appearance, find_reason
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.classification import (
    classify,
    classify_conditions,
    generalize_conditions,
    make_domain,
    sample_condition,
    split_by_value,
)
from qdot.exercises.singularities.meanings import list_candidate_meanings
from qdot.exercises.singularities.normalized_arm import is_independent_of_joint_1, normalize_arm, normalize_conditions
from qdot.exercises.singularities.reach import reaches_beyond, reaches_displaced_pose, reaches_point
from qdot.exercises.singularities.singular_set import Component, find_singular_set
from qdot.exercises.singularities.singularity_kinds import can_establish_kind, classify_samples
from qdot.exercises.verify.singularity_statements import sample_component, statement_holds
from tests.exercises.arm.sets import compute_rank_ratios, list_task_rows
from tests.support.suites import few_or_all_families, on_families, sample_for_suite, select_for_suite

FAMILIES = ("elbow-3r", "spherical", "spherical-offset")
BESIDE = (
    *FAMILIES, "planar-2r", "planar-3r", "polar-rp", "planar-pr", "planar-rpr", "planar-rrp", "planar-prr",
    "planar-3r-pose", "cylindrical", "scara", "scara-rrrp", "scara-prrr",
)  # fmt: skip


def arms(family: str) -> list[tuple[NumericChain, list[int]]]:
    chains = [sample_chain(ProblemId(family, seed)) for seed in range(4)]
    lengths = ({symbol.name: 0.35 + 0.11 * k for k, symbol in enumerate(chain.parameters)} for chain in chains)
    rows = ([VELOCITY_NAMES.index(row) for row in chain.task] for chain in chains)
    return list(zip(map(NumericChain, chains, lengths), rows, strict=True))


@on_families(FAMILIES)
def test_where_a_pose_has_the_point_it_is_reached(family: str) -> None:
    random = np.random.default_rng(6)
    for arm, _ in arms(family):
        places = arm.compute_point(random.uniform(-3, 3, (50, len(arm.kinds))))
        answers = [reaches_point(arm, place) for place in places]
        assert False not in answers and answers.count(True) > 45


def test_a_place_on_the_first_axis_is_reached_by_a_slide_through_it() -> None:
    """The arm has no length but its slide, so that rounding is not small against its links."""
    arm = NumericChain(normalize_arm(sample_chain(ProblemId.parse("spherical/10007").with_variation("full"))), {})
    for height in (1.0, 1e-2, 1e-4, -1e-4):
        for aside in (0.0, 1e-17, -1e-19):
            assert reaches_point(arm, np.array([0.0, aside, height])), (height, aside)


@on_families(BESIDE)
def test_what_another_pose_has_is_reached_from_a_pose(family: str) -> None:
    """The point and the angle, if it counts, of one pose as seen from another."""
    random = np.random.default_rng(8)
    for arm, task in arms(family):
        q = random.uniform(-2, 2, (50, 2, len(arm.kinds)))
        said = [_told(arm, task, here, there) for here, there in q]
        assert False not in said
        assert said.count(True) > 45


def _told(arm: NumericChain, task: list[int], here: np.ndarray, there: np.ndarray) -> bool | None:
    frames, others = arm.compute_frames(here), arm.compute_frames(there)
    turn = others[-1, :3, :3] @ frames[-1, :3, :3].T
    third = max(task) - 3 if max(task) > 2 else 2
    first, second = (third + 1) % 3, (third + 2) % 3
    angles = np.zeros(3)
    angles[third] = np.arctan2(turn[second, first], turn[first, first])
    shift = np.concatenate([arm.compute_point_of(others) - arm.compute_point_of(frames), angles])
    return reaches_displaced_pose(arm, frames, task, shift[task])


@on_families(BESIDE)
def test_it_says_what_a_search_finds(family: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """At places well inside, well outside and in holes; the search takes a place beside the point of a pose."""
    random = np.random.default_rng(7)
    monkeypatch.setattr(reach, "_TESTED_DISTANCE", 0.2)
    said = [_search(arm, task, random, monkeypatch) for arm, task in arms(family) for _ in range(4)]
    assert all(formula is None or formula is search for formula, search in said)
    assert sum(formula is not None for formula, _ in said) > len(said) / 2


def _search(
    arm: NumericChain, task: Sequence[int], random: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> tuple[bool | None, bool]:
    way = random.normal(size=len(task))
    answers: list[bool | None] = []
    monkeypatch.setattr(reach, "reaches_displaced_pose", lambda *of: answers.append(reaches_displaced_pose(*of)))
    sample = Sample(arm, random.uniform(-2, 2, len(arm.kinds)))
    (found,) = reach.reaches_beyond([sample], list(task), (way / np.linalg.norm(way))[None])
    return answers[0], bool(found)


def test_of_other_arms_and_tasks_nothing_is_said() -> None:
    assert reaches_point(arms("scara")[0][0], np.zeros(3)) is None
    for family, rows, known in (
        ("planar-3r-pose", [0, 1, 5], True), ("planar-3r-pose", [0, 1, 3], False), ("orthogonal-3r", [0, 1, 2], False)
    ):  # fmt: skip
        arm, _ = arms(family)[0]
        assert (reaches_displaced_pose(arm, arm.compute_frames(np.zeros(3)), rows, np.zeros(3)) is not None) is known


TASK = ("vx", "vy", "vz")


def elbow(*lengths: float) -> NumericChain:
    a1, a2, a3 = lengths
    rows = (Joint("R", "theta1", 0, a1, -sp.pi / 2), Joint("R", "theta2", 0, a2, 0), Joint("R", "theta3", 0, a3, 0))
    return NumericChain(Chain("elbow", rows, TASK), {})


def test_the_axis_of_an_elbow_is_inside_of_its_reach_up_to_a_hair() -> None:
    """Two pairs of roots are about to be one: the arm is nearly stretched, with the point on the first axis."""
    arm = elbow(0.2, 0.895, 0.6)
    sample = Sample(arm, np.array([0.03, 1.71462742, -0.02402041]))
    across = np.array([[np.sin(0.03), -np.cos(0.03), 0.0]])
    assert reaches_beyond([sample, sample], [0, 1, 2], np.concatenate([across, -across])).all()


def test_a_spherical_arm_whose_slide_is_all_it_has_reaches_what_is_beside_its_centre() -> None:
    rows = (Joint("R", "theta1", 0, 0, -sp.pi / 2), Joint("R", "theta2", 0, 0, sp.pi / 2), Joint("P", 0, "d3", 0, 0))
    sample = Sample(NumericChain(Chain("spherical", rows, TASK), {}), np.array([0.17, -0.28, 0.0]))
    ways = np.concatenate([np.eye(3), -np.eye(3)])
    assert reaches_beyond([sample] * 6, [0, 1, 2], ways).all()


T1, T2 = sp.symbols("theta1 theta2")


def planar(*lengths: float) -> tuple[Chain, NumericChain]:
    angles = sp.symbols("theta1 theta2 theta3")
    joints = (Joint("R", q, 0, sp.Float(a), 0) for q, a in zip(angles, lengths, strict=False))
    chain = Chain("planar", tuple(joints), ("vx", "vy"))
    return chain, NumericChain(chain, {})


def test_planar_kinds_are_those_of_the_annulus() -> None:
    """For every way to fold the links, the distance from the base tells the kind, however narrow the hole is.

    An edge is as far out as all links together, or as the longest less the others, unless that is the base itself.
    """
    three = [(0.9, 0.3, 0.2), (0.2, 0.9, 0.35), (0.5, 0.45, 0.3), (0.31, 0.22, 0.8)]
    for lengths in [(0.5, 0.3), (0.4, 0.4), (0.5, 0.48), (0.5, 0.495), (0.5, 0.499), *three]:
        chain, arm = planar(*lengths)
        edges = {sum(lengths), max(0.0, 2 * max(lengths) - sum(lengths))}
        for folds in product((0.0, np.pi), repeat=chain.n - 1):
            q = np.array([0.3, *folds])
            reach = float(np.linalg.norm(arm.compute_point(q)))
            on_edge = any(abs(reach - edge) < 1e-9 and edge > 0 for edge in edges)
            assert classify_samples(chain, [Sample(arm, q)])[0] == ("boundary" if on_edge else "internal"), (lengths, q)
        assert classify_samples(chain, [Sample(arm, np.array([0.4, 1.0, 0.7])[: chain.n])]) == ["regular"]


def test_kinds_are_told_only_where_the_rows_are_rates_of_coordinates_with_a_reach() -> None:
    def sure(*rows: tuple[float, float, float], task: tuple[str, ...]) -> bool:
        angles = sp.symbols("theta1:5")
        joints = (Joint("R", q, d, a, alpha * sp.pi / 2) for q, (d, a, alpha) in zip(angles, rows, strict=False))
        return can_establish_kind(Chain("arm", tuple(joints), task))

    planar, turning = [(0, 1, 0)] * 3, [(0, 0, 1), (0, 1, 1), (0, 0, 0)]
    assert sure(*planar, task=("vx", "vy", "wz"))
    assert sure(*turning, task=("wx", "wy", "wz"))
    assert not sure(*turning, task=("wx", "wy"))  # no angles whose rates these are
    assert not sure(*turning, task=("vx", "vy", "wz"))
    assert not sure(*turning[:2], task=("vx", "vy", "vz"))  # the reach is a surface


@pytest.mark.parametrize("offset", [3.0, 1.0, 0.3, 0.1, 0.03, 0.01, 0.001])
def test_a_corner_of_the_reach_is_a_boundary_however_blunt(offset: float) -> None:
    """Seen from the side, the arm reaches a disc between two lines; where they meet, both directions are lost at once.

    The corner is the blunter, and the directions that lead out of it the fewer, the smaller the offset.
    """
    rows = (Joint("R", T1, 0, 0, sp.pi / 2), Joint("R", T2, sp.Symbol("d2"), sp.Symbol("a2"), 0))
    chain = Chain("RR from the side", rows, ("vy", "vz"))
    arm = NumericChain(chain, {"d2": offset, "a2": 1.0})
    corners = [Sample(arm, np.array(q)) for q in ((0.0, np.pi / 2), (np.pi, np.pi / 2), (np.pi, -np.pi / 2))]
    assert np.allclose(arm.compute_jacobian(np.stack([corner.q for corner in corners]))[:, 1:3], 0)
    assert classify_samples(chain, corners) == ["boundary"] * 3


def test_the_roles_of_an_arms_symbols() -> None:
    chain = Chain("RP", (Joint("R", "theta1", 0, "a1", "alpha1"), Joint("P", 0, "d2", 0, 0)), ("vx",))
    roles = make_domain(chain, {"a1": 0.5}).roles
    expected_roles = {"theta1": "angle", "d2": "signed", "qd1": "signed", "vx": "signed", "alpha1": "angle", "a1": 0.5}
    assert {name: roles[name] for name in expected_roles} == expected_roles


@pytest.mark.parametrize("family", ["planar-2r", "elbow", "ur-6r", "puma-560", "wrist-zyz", "lbr-7r"])
def test_where_no_configuration_is_found_nothing_is_said_of_looks(family: str) -> None:
    assert describe_appearance(sample_chain(ProblemId(family, 1)), []).endswith(("meaning", "one line", "one plane"))


def test_what_is_so_at_many_configurations_of_a_value_but_not_at_all_is_not_said_of_it() -> None:
    """The point of this arm swings through the axis: near theta3 = 0, a quarter of the poses, far and near swap."""
    chain = sample_chain(ProblemId("random-3", 10085).with_variation("full"))
    (turning,) = [
        component for component in find_singular_set(chain) or () if component.conditions == (sp.cos(chain.q[1]),)
    ]
    for value in (sp.pi / 2, -sp.pi / 2):
        here = Component(turning.conditions, ((chain.q[1], (value,)),))
        far_or_near = "as far from or as near to the axis of joint 1 as joint 2 can bring it"
        assert classify(chain, here).meaning == f"the point is {far_or_near}"


@pytest.mark.parametrize("size", sample_for_suite([2, 3, 4], 2))
def test_every_singularity_of_a_random_arm_looks_like_something(size: int) -> None:
    for seed in range(select_for_suite(2, 6)):
        chain = sample_chain(ProblemId(f"random-{size}", seed))
        for component in find_singular_set(chain) or ():
            assert "no simple geometric meaning" not in classify(chain, component).meaning


def test_one_joint_is_at_the_boundary_where_it_goes_no_farther() -> None:
    chain = Chain("one", (Joint("R", sp.Symbol("theta1"), 0, sp.Symbol("a1"), 0),), ("vx",))
    kind = classify(chain, (find_singular_set(chain) or ())[0])
    assert (kind.kind, kind.is_uniform) == ("boundary", True)


def test_the_tool_may_be_the_only_length_of_an_arm() -> None:
    """Two axes through one point: P is on a sphere, and seen along its first axis in the middle of what it reaches."""
    chain = sample_chain(ProblemId("random-2", 10033).with_variation("full"))
    assert all(joint.a == 0 and not joint.d.free_symbols for joint in chain.joints)
    kinds = [classify(chain, component) for component in find_singular_set(chain) or ()]
    assert sorted((kind.kind, kind.is_uniform) for kind in kinds) == [("boundary", True), ("internal", True)]


def test_a_slide_far_out_may_be_at_the_boundary_where_it_is_not_drawn_in() -> None:
    """Within two metres of slide 3, all that was found was internal; there are boundary singularities beyond."""
    quarter = sp.pi / 2
    turning = Joint("R", "theta1", "h1", "a1", sp.pi), Joint("R", sp.Symbol("theta2") + quarter, "h3", "a3", -sp.pi / 6)
    rows = (*turning, Joint("P", quarter, "d3", "a3", 3 * sp.pi / 4), Joint("P", quarter, "d4", 0, quarter))
    kind = classify_conditions(Chain("far out", rows, VELOCITY_NAMES[:3]), ("theta2 = pi and d4 = -sqrt(2)*a3",))
    assert (kind.kind, kind.is_uniform) == ("boundary", False)


def arm(family: str, seed: int = 1) -> Chain:
    return make_symbolic_arm(sample_chain(ProblemId(family, seed, variation="chapter"))).chain


def samples_of(chain: Chain, condition: str) -> tuple[Sample, ...]:
    """Return configurations at which a condition holds, on arms with different lengths from those examined."""
    return sample_condition(chain, condition, "another draw", arm_count=4)


@on_families(("stanford-6r", "ur-6r", "scara", "scorbot-wrist", "puma-560", "industrial-6r"))
def test_parallel_axes_are_a_reason_only_where_their_own_columns_depend_on_each_other(family: str) -> None:
    """At s2 = 0 of a Stanford arm axes 1 and 4 are parallel, which costs no rank by itself."""
    chain = arm(family)
    rows = list_task_rows(chain)
    for component in find_singular_set(chain) or ():
        samples = [sample for piece in component.list_pieces() for sample in samples_of(chain, piece)]
        said = find_reason(chain, samples)
        if said is not None and (joints := re.search(r"axes of joints ([\d, and]+) are parallel", said.words)):
            columns = [int(number) - 1 for number in re.findall(r"\d", joints[1])]
            for sample in samples:
                part = sample.arm.compute_jacobian(sample.q)[np.ix_(rows, columns)]
                assert np.linalg.matrix_rank(part, 1e-6) < len(columns)


@few_or_all_families
def test_the_reason_that_is_told_holds_at_no_regular_configuration(
    family: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The search begins at other points, on arms with different lengths from those of the derivation."""
    chain = arm(family)
    for component in find_singular_set(chain) or ():
        read_from = [
            sample
            for piece in component.list_pieces()
            for sample in sample_condition(chain, piece, "classify", arm_count=3)
        ]
        said = find_reason(chain, read_from)
        others = [sample for piece in component.list_pieces() for sample in samples_of(chain, piece)]
        if said is None:
            continue
        assert all(sample.evaluate(said.measure) < ZERO_TOLERANCE for sample in others), said.words
        assert sum(map(said.predicate, others)) >= 0.9 * len(others), said.words  # here and there it can't be told
        with monkeypatch.context() as changed:
            changed.setattr(reason, "_sample_starts", starts)
            found = {id(sample.arm): zeros(sample.arm, said) for sample in others}
        for sample in others:
            for q in found[id(sample.arm)]:
                is_said = said.predicate(Sample(sample.arm, q))
                assert not is_said or compute_rank_ratios(sample.arm, chain, q) < 1e-4, said.words


def zeros(arm: NumericChain, said: Statement) -> np.ndarray:
    """Return configurations at which it is so, of those to which the search leads."""
    (q,) = reason._descend(arm, said.measure, 1)
    return np.asarray(q[said.measure(arm, q) < reason._CONVERGENCE_TOLERANCE])


def starts(kinds: tuple[str, ...]) -> np.ndarray:
    stream = Stream("other starts")
    return np.array(
        [[stream.uniform(-3, 3) if kind == "R" else stream.uniform(0, 1) for kind in kinds] for _ in range(40)]
    )


@pytest.mark.parametrize(("length", "is_told"), [(sp.Symbol("a1"), True), (0, False)])
def test_how_a_slide_runs_past_a_link_is_a_reason_where_the_link_has_a_length(
    length: sp.Expr | int, is_told: bool
) -> None:
    theta1, theta2, d3 = sp.symbols("theta1 theta2 d3")
    joints = (Joint("R", theta1, 0, length, 0), Joint("R", theta2, 0, 0, sp.pi / 2), Joint("P", 0, d3, 0, 0))
    chain = Chain("RRP", joints, ("vx", "vy", "wz"))
    told = {one.kind for one in list_candidate_meanings(chain, samples_of(chain, "sin(theta2)"))}
    assert ({"along", "across"} <= told) == is_told


def test_a_point_on_two_axes_that_meet_is_told_of_both() -> None:
    theta1, theta2, d3 = sp.symbols("theta1 theta2 d3")
    joints = (Joint("R", theta1, 0, 0, -sp.pi / 2), Joint("R", theta2, 0, 0, sp.pi / 2), Joint("P", 0, d3, 0, 0))
    chain = Chain("spherical", joints, ("vx", "vy", "vz"))
    told = "the point lies on the axes of joints 1 and 2, which then do not move it"
    assert describe_appearance(chain, samples_of(chain, "d3 = 0")) == told
    told = "the point lies on the axis of joint 1, which then does not move it"
    assert describe_appearance(chain, samples_of(chain, "sin(theta2)")) == told


A1, A2 = sp.symbols("a1 a2")


def two_links(*offsets: sp.Expr, base: Base = Base(), lengths: Sequence[sp.Expr] = (A1, A2)) -> Chain:  # noqa: B008
    q = sp.symbols("theta1 theta2")
    rows = (Joint("R", angle + offset, 0, a, 0) for angle, offset, a in zip(q, offsets, lengths, strict=True))
    return Chain("two", tuple(rows), ("vx", "vy"), base, title="two links")


def test_zeros_of_joints_and_the_place_of_the_base_are_left_out() -> None:
    moved = two_links(sp.pi / 6, -sp.pi / 2, base=Base((sp.Rational(1, 2), sp.Symbol("b_y"), sp.S.Zero), sp.pi / 3))
    assert normalize_arm(moved) == normalize_arm(two_links(sp.S.Zero, sp.S.Zero, base=Base(yaw=sp.pi / 3)))
    assert normalize_arm(moved).parameters == (A1, A2)
    assert normalize_arm(moved) != normalize_arm(two_links(sp.S.Zero, sp.S.Zero))


def test_the_same_configurations_are_the_same_pieces() -> None:
    chains = [two_links(sp.S.Zero, offset) for offset in (sp.S.Zero, sp.pi / 6, -sp.pi / 2, sp.pi)]
    components = [(chain, component) for chain in chains for component in find_singular_set(chain) or ()]
    pieces = {tuple(normalize_conditions(chain, component)) for chain, component in components}
    assert pieces == {("theta2 = 0", "theta2 = pi")}


def test_a_slide_is_counted_from_its_own_zero() -> None:
    rows = (Joint("R", "theta1", 0, 0, sp.pi / 2), Joint("P", 0, sp.Symbol("d2") + 4, 0, 0))
    chain = Chain("far", rows, ("vx", "vy"))
    (component,) = find_singular_set(chain) or ()
    assert component.list_pieces() == ["d2 = -4"]
    assert normalize_conditions(chain, component) == ["d2 = 0"]


@pytest.mark.parametrize(
    "name", ["planar-2r/3", "elbow-3r/8@full", "polar-rp/5", "planar-3r/2", "random-3/4", "scara/2@full"]
)
def test_a_kind_is_that_of_the_arm_by_itself(name: str) -> None:
    chain = sample_chain(ProblemId.parse(name))
    components = find_singular_set(chain) or ()
    assert components
    for component in components:
        assert classify(chain, component) == classify_conditions(chain, tuple(component.list_pieces()))


@pytest.mark.parametrize("name", ["planar-3r/2", "wrist-zyz/1", *select_for_suite((), ("spherical/3", "puma-560/1"))])
def test_kinds_are_the_same_one_by_one_and_at_once(name: str) -> None:
    chain = sample_chain(ProblemId.parse(name))
    pieces = [piece for component in find_singular_set(chain) or () for piece in component.list_pieces()]
    by_piece = (sample_condition(chain, piece, "at once", arm_count=2, samples_per_arm=2) for piece in pieces)
    samples = [sample for samples in by_piece for sample in samples]
    assert classify_samples(chain, samples) == [classify_samples(chain, [sample])[0] for sample in samples]
    assert len(samples) > 3
    assert classify_samples(chain, []) == []


@pytest.mark.parametrize(
    ("task", "tilt", "turns"),
    [
        (("vx", "vy"), 0, True), (("vx", "vy", "wz"), 0, True), (("vx", "vy", "vz"), sp.pi / 2, True),
        (VELOCITY_NAMES, sp.pi / 2, True), (("vx", "vz"), 0, False), (("vx", "vy"), sp.pi / 2, False),
        (("vx", "vy", "wx"), 0, False),
    ],
)  # fmt: skip
def test_a_turn_about_the_first_axis_changes_nothing_where_the_rows_turn_into_each_other(
    task: tuple[str, ...], tilt: sp.Expr, turns: bool
) -> None:
    rows = tuple(Joint("R", f"theta{i}", 0, 1, sp.pi / 2) for i in range(1, 4))
    assert is_independent_of_joint_1(Chain("turned", rows, task, Base(tilt=sp.S(tilt)))) is turns


def test_an_arm_with_its_lengths_put_in_again_moves_as_before(problem: Problem) -> None:
    general, lengths = replace_lengths_by_symbols(problem.chain)
    again = substitute_in_arm(general, lengths)
    assert again.parameters == problem.chain.parameters
    values = {symbol.name: 0.3 + 0.1 * k for k, symbol in enumerate(again.parameters)}
    q = np.array([0.4 - 0.3 * k for k in range(again.n)])
    offsets = np.array([float(offset) for offset in problem.chain.offsets])
    one, other = NumericChain(problem.chain, values), NumericChain(again, values)
    np.testing.assert_allclose(other.compute_jacobian(q + offsets), one.compute_jacobian(q), atol=1e-12)
    np.testing.assert_allclose(other.compute_point(q + offsets), one.compute_point(q), atol=1e-12)


@few_or_all_families
def test_what_is_told_of_a_structure_holds_for_the_arm(problem: Problem) -> None:
    for component in find_singular_set(problem.chain) or ():
        pieces, (_, known) = normalize_conditions(problem.chain, component), generalize_conditions(problem.chain)
        if all(piece in known for piece in pieces):
            kind = classify(problem.chain, component)
            own = classify_conditions(normalize_arm(problem.chain), tuple(pieces))
            samples = sample_component(problem.chain, component)
            assert all(statement_holds(problem.chain, kind.meaning, sample) for sample in samples)
            assert not (kind.is_uniform and own.is_uniform) or kind.kind == own.kind


def test_arms_with_special_lengths_are_looked_at_by_themselves() -> None:
    """Folded back, the point is on the axis of joint 1 where links are as long as each other: inside the reach."""
    kinds = {}
    for second in (4, 5):
        chain = two_links(sp.S.Zero, sp.S.Zero, lengths=(sp.Rational(1, 2), sp.Rational(second, 10)))
        (component,) = find_singular_set(chain) or ()
        parts = [part for _, part in split_by_value(component, classify(chain, component))]
        kinds[second] = [classify(chain, part).kind for part in parts]
        assert bool(generalize_conditions(chain)[1]) is (second == 4), component
    assert kinds == {4: ["boundary", "boundary"], 5: ["boundary", "internal"]}


@pytest.mark.parametrize(
    ("lengths", "apart"),
    [
        ((3, 4, 5), True), ((3, 4, 7), False), ((3, 3), False), ((1, 2, 4, 9), True), ((1, 2, 4, 7), False),
        ([3**k for k in range(8)], True), ([3**k for k in range(9)], False), ((1, sp.Symbol("a2")), False),
    ],
)  # fmt: skip
def test_lengths_that_are_sums_of_others_are_related_and_many_or_open_ones_may_be(
    lengths: Sequence[int], apart: bool
) -> None:
    assert are_unrelated([sp.S(length) / 20 for length in lengths]) is apart
