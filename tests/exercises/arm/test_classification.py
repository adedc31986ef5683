"""Boundary or internal: the kinds of the textbook arms' singularities, and of single configurations."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
import sympy as sp

from exercises.arm.axes import Sample
from exercises.arm.chain import TASK_ROWS, Chain, Joint
from exercises.arm.classification import classify, classify_pieces, domain_of, kind_at, kind_is_sure
from exercises.arm.kinematics import NumericChain
from exercises.arm.singularity import singular_set
from exercises.generation import sample_chain
from exercises.problem import ProblemId
from tests.support import DATA
from tests.support.suites import few_for, several

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
T1, T2, T3 = sp.symbols("theta1 theta2 theta3")


def expected(classification: str) -> tuple[str, bool]:
    """Return kind and uniformity that a record states: boundary, interior …, or one of both (mixed)."""
    if classification.startswith("interior"):
        return "internal", True
    return "boundary", classification == "boundary"


@pytest.mark.parametrize(("name", "number"), [KINDS[int(k)] for k in few_for("kinds", map(str, range(len(KINDS))), 6)])
def test_textbook_kinds(name: str, number: int, textbook_arms: Mapping[str, Any]) -> None:
    arm = textbook_arms[name]
    part = arm.record["singular_set"][number]
    condition = " and ".join(f"({text.removesuffix(' = 0')}) = 0" for text in part["conditions"])
    found = classify_pieces(arm.chain, [condition])
    assert (found.kind, found.uniform) == expected(part["classification"])


def planar(*lengths: float) -> tuple[Chain, NumericChain]:
    angles = sp.symbols("theta1 theta2 theta3")
    joints = (Joint("R", q, 0, sp.Float(a), 0) for q, a in zip(angles, lengths, strict=False))
    chain = Chain("planar", tuple(joints), ("vx", "vy"))
    return chain, NumericChain(chain, {})


@pytest.mark.parametrize(
    ("lengths", "q", "kind"),
    [
        ((0.5, 0.3), (0.4, 0.0), "boundary"),
        ((0.5, 0.3), (0.4, np.pi), "boundary"),
        ((0.4, 0.4), (0.4, np.pi), "internal"),
        ((0.5, 0.3), (0.4, 1.0), "regular"),
        ((0.9, 0.3, 0.2), (0.4, np.pi, 0.0), "boundary"),
        ((0.9, 0.3, 0.2), (0.4, 0.0, np.pi), "internal"),
        ((0.5, 0.4, 0.3), (0.4, np.pi, np.pi), "internal"),
        ((0.5, 0.4, 0.3), (0.4, 0.0, 0.0), "boundary"),
    ],
)
def test_the_kind_of_a_planar_pose_is_that_of_its_reach(
    lengths: tuple[float, ...], q: tuple[float, ...], kind: str
) -> None:
    """A fold is an edge of the annulus between the longest link less the others and all of them, or inside it."""
    chain, arm = planar(*lengths)
    assert kind_at(chain, Sample(arm, np.array(q))) == kind


def test_planar_kinds_are_those_of_the_annulus() -> None:
    """For every way to fold three links, the distance from the base tells the kind."""
    for lengths in [(0.9, 0.3, 0.2), (0.2, 0.9, 0.35), (0.5, 0.45, 0.3), (0.31, 0.22, 0.8)]:
        chain, arm = planar(*lengths)
        edges = {sum(lengths), max(0.0, 2 * max(lengths) - sum(lengths))}
        for second in (0.0, np.pi):
            for third in (0.0, np.pi):
                q = np.array([0.3, second, third])
                reach = float(np.linalg.norm(arm.point(q)))
                on_edge = any(abs(reach - edge) < 1e-9 and edge > 0 for edge in edges)
                assert kind_at(chain, Sample(arm, q)) == ("boundary" if on_edge else "internal"), (lengths, q)


def test_what_a_pose_looks_like_is_said() -> None:
    chain = Chain("2R", (Joint("R", T1, 0, sp.Symbol("a1"), 0), Joint("R", T2, 0, sp.Symbol("a2"), 0)), ("vx", "vy"))
    assert classify_pieces(chain, ["theta2 = 0"]).meaning == "arm stretched out"
    assert classify_pieces(chain, ["theta2 = pi"]).meaning == "arm folded back"


def test_the_roles_of_an_arms_symbols() -> None:
    chain = Chain("RP", (Joint("R", T1, 0, sp.Symbol("a1"), sp.Symbol("alpha1")), Joint("P", 0, "d2", 0, 0)), ("vx",))
    roles = domain_of(chain, {"a1": 0.5}).roles
    expected_roles = {"theta1": "angle", "d2": "signed", "qd1": "signed", "vx": "signed", "alpha1": "angle", "a1": 0.5}
    assert {name: roles[name] for name in expected_roles} == expected_roles


def test_a_narrow_hole_in_the_reach_is_a_boundary_still() -> None:
    for gap in (0.02, 0.005, 0.001):
        chain, arm = planar(0.5, 0.5 - gap)
        assert kind_at(chain, Sample(arm, np.array([0.4, np.pi]))) == "boundary"


def robot(rows: list[tuple[str, str, str, str]], task: tuple[str, ...] = TASK_ROWS) -> Chain:
    joints = tuple(
        Joint(kind, sp.Symbol(f"theta{i}") if kind == "R" else 0, d if kind == "R" else sp.Symbol(f"d{i}"), a, alpha)
        for i, (kind, d, a, alpha) in enumerate(rows, 1)
    )
    return Chain("robot", joints, task)


QUARTER = "pi/2"
TIPS = {
    "puma": [
        ("R", "d1", "0", QUARTER), ("R", "0", "a2", "0"), ("R", "d3", "a3", "-pi/2"),
        ("R", "d4", "0", QUARTER), ("R", "0", "0", "-pi/2"), ("R", "d6", "0", "0"),
    ],
    "ur": [
        ("R", "d1", "0", QUARTER), ("R", "0", "a2", "0"), ("R", "0", "a3", "0"),
        ("R", "d4", "0", QUARTER), ("R", "d5", "0", "-pi/2"), ("R", "d6", "0", "0"),
    ],
}  # fmt: skip


def test_arms_of_six_joints_are_read_from_their_wrist_centre_and_axes() -> None:
    """The tip of a tool says little of such a pose; what lies on what line or plane does."""
    arms = {name: robot(rows) for name, rows in TIPS.items()}
    said = {name: [classify(arm, found).meaning for found in singular_set(arm) or ()] for name, arm in arms.items()}
    assert said["puma"] == [
        "the axes of joints 4 and 6 lie on one line",
        "arm stretched out or folded back",
        "the wrist centre is as near to the axis of joint 1 as joint 2 can bring it",
    ]
    assert said["ur"] == [
        "the parallel axes of joints 2, 3 and 4 lie in one plane",
        "the axes of joints 2, 3, 4 and 6 are parallel",
        "the origin O5 is as near to the axis of joint 1 as joint 2 can bring it",
    ]


def test_several_conditions_look_like_more_than_one_of_them_does() -> None:
    """Axes 1 and 3 of a 7R arm on one line cost no rank; with axes 5 and 7 on another they do."""
    turns = [QUARTER, "-pi/2"] * 3 + ["0"]
    lengths = ["d1", "0", "d3", "0", "d5", "0", "d7"]
    rows = [("R", d, "0", alpha) for d, alpha in zip(lengths, turns, strict=True)]
    said = [classify(robot(rows), found).meaning for found in singular_set(robot(rows)) or ()]
    assert said[0] == "the axes of joints 3 and 5 lie on one line"
    first, second = "the axes of joints 1 and 3 lie on one line", "the axes of joints 5 and 7 lie on one line"
    assert f"{first}, and {second}" in said
    assert f"{first}, and the wrist centre is as near to the axis of joint 1 as joint 2 can bring it" in said


@pytest.mark.parametrize("size", [2, 3, 4])
def test_every_singularity_of_a_random_arm_looks_like_something(size: int) -> None:
    for seed in range(several(3, 6)):
        chain = sample_chain(ProblemId(f"random-{size}", seed))
        for component in singular_set(chain) or ():
            assert "linearly dependent" not in classify(chain, component).meaning


def test_kinds_are_told_only_where_the_rows_are_rates_of_coordinates_with_a_reach() -> None:
    def sure(*rows: tuple[float, float, float], task: tuple[str, ...]) -> bool:
        angles = sp.symbols("theta1:5")
        joints = (Joint("R", q, d, a, alpha * sp.pi / 2) for q, (d, a, alpha) in zip(angles, rows, strict=False))
        return kind_is_sure(Chain("arm", tuple(joints), task))

    planar, turning = [(0, 1, 0)] * 3, [(0, 0, 1), (0, 1, 1), (0, 0, 0)]
    assert sure(*planar, task=("vx", "vy", "wz"))
    assert sure(*turning, task=("wx", "wy", "wz"))
    assert not sure(*turning, task=("wx", "wy"))  # no angles whose rates these are
    assert not sure(*turning, task=("vx", "vy", "wz"))
    assert not sure(*turning[:2], task=("vx", "vy", "vz"))  # the reach is a surface


def test_one_joint_is_at_the_boundary_where_it_goes_no_farther() -> None:
    chain = Chain("one", (Joint("R", sp.Symbol("theta1"), 0, sp.Symbol("a1"), 0),), ("vx",))
    kind = classify(chain, (singular_set(chain) or ())[0])
    assert (kind.kind, kind.uniform) == ("boundary", True)


def test_the_tool_may_be_the_only_length_of_an_arm() -> None:
    """Two axes through one point: P is on a sphere, and seen along its first axis in the middle of what it reaches."""
    chain = sample_chain(ProblemId("random-2", 10033).varied("full"))
    assert all(joint.a == 0 and not joint.d.free_symbols for joint in chain.joints)
    kinds = [classify(chain, component) for component in singular_set(chain) or ()]
    assert sorted((kind.kind, kind.uniform) for kind in kinds) == [("boundary", True), ("internal", True)]
