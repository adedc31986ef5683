"""Boundary or internal: the kinds of the textbook arms' singularities, and of single configurations."""

import json
from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.singularities.appearance import describe_appearance
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.classification import classify, classify_conditions, make_domain
from qdot.exercises.singularities.singular_set import Component, find_singular_set
from qdot.exercises.singularities.singularity_kinds import can_establish_kind, classify_samples
from tests.support import DATA
from tests.support.suites import sample_for_suite, select_for_suite

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


RECORDS = json.loads((DATA / "ground_truth.json").read_text(encoding="utf-8"))

UNDECIDED = {"Scorbot_5R_full_6x5", "pan_tilt_2R"}
"""More rows than joints, six and five, three and two: what is reached is a surface, to whose boundary nobody would
think of; the records speak of other reaches."""

KINDS = [
    (record["name"], number)
    for record in RECORDS
    if record["name"] not in UNDECIDED and all(len(row) == 2 for row in record["task_rows"])
    for number in range(len(record["singular_set"]))
]


def expected(classification: str) -> tuple[str, bool]:
    """Return kind and uniformity that a record states: boundary, interior …, or one of both (mixed)."""
    if classification.startswith("interior"):
        return "internal", True
    return "boundary", classification == "boundary"


@pytest.mark.parametrize(("name", "number"), sample_for_suite(KINDS, 6))
def test_textbook_kinds(name: str, number: int, textbook_arms: Mapping[str, Any]) -> None:
    arm = textbook_arms[name]
    part = arm.record["singular_set"][number]
    condition = " and ".join(f"({text.removesuffix(' = 0')}) = 0" for text in part["conditions"])
    found = classify_conditions(arm.chain, (condition,))
    assert (found.kind, found.is_uniform) == expected(part["classification"])


def test_the_roles_of_an_arms_symbols() -> None:
    chain = Chain("RP", (Joint("R", "theta1", 0, "a1", "alpha1"), Joint("P", 0, "d2", 0, 0)), ("vx",))
    roles = make_domain(chain, {"a1": 0.5}).roles
    expected_roles = {"theta1": "angle", "d2": "signed", "qd1": "signed", "vx": "signed", "alpha1": "angle", "a1": 0.5}
    assert {name: roles[name] for name in expected_roles} == expected_roles


def meanings(family: str) -> list[str]:
    """Return what is said of the singularities of the chapter's arm of a family, whose point is the tip of its tool."""
    chain = replace(sample_chain(ProblemId(family, 1, variation="chapter")), tool=None)
    return [classify(chain, component).meaning for component in find_singular_set(chain) or ()]


def test_arms_of_six_joints_are_read_from_their_wrist_centre_and_axes() -> None:
    """The tip of a tool says little of such a pose; what lies on what line or plane does."""
    assert meanings("puma-560") == [
        "the axes of joints 4 and 6 coincide",
        "arm stretched out or folded back",
        "the wrist centre is as near to the axis of joint 1 as joint 2 can bring it",
    ]
    assert meanings("ur-6r")[:2] == [
        "the parallel axes of joints 2, 3 and 4 lie in one plane",
        "the axes of joints 2, 3, 4 and 6 are parallel",
    ]


@pytest.mark.parametrize("family", ["planar-2r", "elbow", "ur-6r", "puma-560", "wrist-zyz", "lbr-7r"])
def test_where_no_configuration_is_found_nothing_is_said_of_looks(family: str) -> None:
    assert describe_appearance(sample_chain(ProblemId(family, 1)), []).endswith(("meaning", "one line", "one plane"))


@pytest.mark.whole
def test_several_conditions_look_like_more_than_one_of_them_does() -> None:
    """Axes 1 and 3 of a 7R arm on one line cost no rank; with axes 5 and 7 on another they do."""
    said = meanings("lbr-7r")
    assert said[0] == "the axes of joints 3 and 5 coincide"
    assert "the axes of joints 1 and 3 coincide, and the axes of joints 5 and 7 coincide" in said


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


def test_the_wrist_of_a_stanford_arm_in_one_line_is_no_boundary() -> None:
    """All poses around are reached, also along what is lost: P without the wrist, which then turns the hand."""
    chain = sample_chain(ProblemId("stanford-6r", 2))
    kinds = {one.list_pieces()[0]: classify(chain, one) for one in find_singular_set(chain) or ()}
    assert [kind.kind for kind in kinds.values()] == ["boundary", "boundary", "internal"]
    assert list(kinds)[2] == "theta5 = pi/2" and kinds["theta5 = pi/2"].is_uniform


def test_a_slide_far_out_may_be_at_the_boundary_where_it_is_not_drawn_in() -> None:
    """Within two metres of slide 3, all that was found was internal; there are boundary singularities beyond."""
    quarter = sp.pi / 2
    rows = (
        Joint("R", "theta1", "h1", "a1", sp.pi),
        Joint("R", sp.Symbol("theta2") + quarter, "h3", "a3", -sp.pi / 6),
        Joint("P", quarter, "d3", "a3", 3 * sp.pi / 4),
        Joint("P", quarter, "d4", 0, quarter),
    )
    kind = classify_conditions(Chain("far out", rows, VELOCITY_NAMES[:3]), ("theta2 = pi and d4 = -sqrt(2)*a3",))
    assert (kind.kind, kind.is_uniform) == ("boundary", False)
