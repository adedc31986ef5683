"""Boundary or internal: the kinds of the textbook arms' singularities, and of single configurations."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
import sympy as sp

from exercises.arm.appearance import meaning
from exercises.arm.chain import TASK_ROWS, Chain, Joint
from exercises.arm.classification import classify, classify_pieces, domain_of
from exercises.arm.singularity import Component, singular_set
from exercises.generation import sample_chain
from exercises.problem import ProblemId
from tests.support import DATA
from tests.support.suites import few_of, several

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


@pytest.mark.parametrize(("name", "number"), few_of(KINDS, 6))
def test_textbook_kinds(name: str, number: int, textbook_arms: Mapping[str, Any]) -> None:
    arm = textbook_arms[name]
    part = arm.record["singular_set"][number]
    condition = " and ".join(f"({text.removesuffix(' = 0')}) = 0" for text in part["conditions"])
    found = classify_pieces(arm.chain, [condition])
    assert (found.kind, found.uniform) == expected(part["classification"])


def test_what_a_pose_looks_like_is_said() -> None:
    chain = Chain("2R", (Joint("R", T1, 0, sp.Symbol("a1"), 0), Joint("R", T2, 0, sp.Symbol("a2"), 0)), ("vx", "vy"))
    assert classify_pieces(chain, ["theta2 = 0"]).meaning == "arm stretched out"
    assert classify_pieces(chain, ["theta2 = pi"]).meaning == "arm folded back"


def test_the_roles_of_an_arms_symbols() -> None:
    chain = Chain("RP", (Joint("R", T1, 0, sp.Symbol("a1"), sp.Symbol("alpha1")), Joint("P", 0, "d2", 0, 0)), ("vx",))
    roles = domain_of(chain, {"a1": 0.5}).roles
    expected_roles = {"theta1": "angle", "d2": "signed", "qd1": "signed", "vx": "signed", "alpha1": "angle", "a1": 0.5}
    assert {name: roles[name] for name in expected_roles} == expected_roles


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


@pytest.mark.parametrize("family", ["planar-2r", "elbow", "ur-6r", "puma-560", "wrist-zyz", "lbr-7r"])
def test_where_no_configuration_is_found_nothing_is_said_of_looks(family: str) -> None:
    assert meaning(sample_chain(ProblemId(family, 1)), []).endswith(("dependent", "one line", "one plane"))


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


def test_what_is_so_at_many_configurations_of_a_value_but_not_at_all_is_not_said_of_it() -> None:
    """The point of this arm swings through the axis: near theta3 = 0, a quarter of the poses, far and near swap."""
    chain = sample_chain(ProblemId("random-3", 10085).varied("full"))
    (turning,) = [component for component in singular_set(chain) or () if component.conditions == (sp.cos(chain.q[1]),)]
    for value in (sp.pi / 2, -sp.pi / 2):
        here = Component(turning.conditions, ((chain.q[1], (value,)),))
        far_or_near = "as far from or as near to the axis of joint 1 as joint 2 can bring it"
        assert classify(chain, here).meaning == f"the point is {far_or_near}"


@pytest.mark.parametrize("size", [2, 3, 4])
def test_every_singularity_of_a_random_arm_looks_like_something(size: int) -> None:
    for seed in range(several(3, 6)):
        chain = sample_chain(ProblemId(f"random-{size}", seed))
        for component in singular_set(chain) or ():
            assert "linearly dependent" not in classify(chain, component).meaning


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


# --- a Stanford arm, whose wrist is one line at c5 = 0, by a search of its own ---

STANFORD = sample_chain(ProblemId("stanford-6r", 2))
D1, D6 = 0.62, 0.41


def _frames(q: np.ndarray) -> list[np.ndarray]:
    """Return the frames of the table as it is printed, multiplied out."""
    rows = [
        (q[0] - np.pi / 2, D1, -np.pi / 2), (q[1] + np.pi / 6, 0.15, np.pi / 2), (0.0, q[2] - 0.45, 0.0),
        (q[3], 0.0, -np.pi / 2), (q[4] - np.pi / 2, 0.0, np.pi / 2), (q[5], D6, 0.0),
    ]  # fmt: skip
    frames = [np.eye(4)]
    for theta, d, alpha in rows:
        c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
        frames.append(
            frames[-1] @ np.array([[c, -s * ca, s * sa, 0], [s, c * ca, -c * sa, 0], [0, sa, ca, d], [0, 0, 0, 1]])
        )
    return frames


def _jacobian(frames: list[np.ndarray]) -> np.ndarray:
    p, axes = frames[4][:3, 3], [frame[:3, 2] for frame in frames]
    lever = [np.cross(axes[i], p - frames[i][:3, 3]) for i in range(6)]
    columns = [np.r_[axes[i], 0, 0, 0] if i == 2 else np.r_[lever[i] * (i < 4), axes[i]] for i in range(6)]
    return np.array(columns).T


def _turn(w: np.ndarray) -> np.ndarray:
    angle = max(float(np.linalg.norm(w)), 1e-12)
    k = np.cross(np.eye(3), w / angle)
    return np.asarray(np.eye(3) - np.sin(angle) * k + (1 - np.cos(angle)) * k @ k)


def _is_reached(p: np.ndarray, turned: np.ndarray, starts: np.ndarray) -> bool:
    """Whether damped Gauss and Newton's steps from some start lead to a pose."""
    for start in starts:
        q = start
        for _ in range(80):
            frames = _frames(q)
            off = turned @ frames[6][:3, :3].T
            w = np.array([off[2, 1] - off[1, 2], off[0, 2] - off[2, 0], off[1, 0] - off[0, 1]]) / 2
            sine = float(np.linalg.norm(w))
            w = w * np.arctan2(sine, (np.trace(off) - 1) / 2) / max(sine, 1e-12)
            error = np.r_[p - frames[4][:3, 3], w]
            if np.linalg.norm(error) < 1e-10:
                return True
            u, sigma, v = np.linalg.svd(_jacobian(frames))
            step = v.T @ (sigma / (sigma**2 + 1e-6 * np.linalg.norm(error)) * (u.T @ error))
            q = q + step * min(1.0, 0.5 / np.abs(step).max())
    return False


def _drawn(rng: np.random.Generator, joint: int, value: float) -> np.ndarray:
    """Return a configuration with a joint at a value, that is well inside of the reach but for this."""
    while True:
        q = rng.uniform(-np.pi, np.pi, 6)
        q[2] = rng.uniform(-0.6, 1.5)
        q[joint] = value
        others = [abs(q[2] - 0.45), abs(np.sin(q[1] + np.pi / 6)), abs(np.sin(q[4] - np.pi / 2))]
        if min(other for k, other in zip((2, 1, 4), others, strict=True) if k != joint) > 0.3:
            return q


def _turned_by(frames: list[np.ndarray], move: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return frames[4][:3, 3] + move[:3], _turn(move[3:]) @ frames[6][:3, :3]


def test_the_wrist_of_a_stanford_arm_in_one_line_is_no_boundary() -> None:
    """All poses around are reached, also along what is lost. The place of P is reached without the wrist, which turns
    the hand into every orientation; with its first axes crossing at a distance, P keeps 0.15 m off the axis of joint 1.
    """
    found = singular_set(STANFORD)
    assert found is not None
    kinds = {one.pieces()[0]: classify(STANFORD, one) for one in found}
    assert [kind.kind for kind in kinds.values()] == ["boundary", "boundary", "internal"]
    assert list(kinds)[2] == "theta5 = pi/2" and kinds["theta5 = pi/2"].uniform
    assert kinds["theta5 = pi/2"].meaning == "the axes of joints 4 and 6 lie on one line"
    rng = np.random.default_rng(27)
    for number in range(several(9, 60)):
        q = _drawn(rng, 4, np.pi / 2)
        frames = _frames(q)
        lost, sigma, _ = np.linalg.svd(_jacobian(frames))
        assert sigma[-1] < 1e-12 < 1e-3 < sigma[-2]
        move = (lost[:, -1], -lost[:, -1], rng.normal(size=6))[number % 3]
        assert _is_reached(*_turned_by(frames, 0.01 * move / np.linalg.norm(move)), q + rng.normal(size=(60, 6)) * 0.5)


def test_beside_the_first_axis_a_stanford_arm_is_at_its_boundary() -> None:
    """That the search fails is seen where P comes nearer to the axis of joint 1 than joint 2 can bring it."""
    rng = np.random.default_rng(28)
    for _ in range(several(2, 10)):
        q = _drawn(rng, 1, -np.pi / 6)
        frames = _frames(q)
        out = frames[4][:3, 3] * [1, 1, 0]
        assert np.linalg.norm(out) == pytest.approx(0.15)
        starts = q + rng.normal(size=(12, 6))
        for side, reached in ((1, True), (-1, False)):
            move = np.r_[side * 0.01 * out / np.linalg.norm(out), 0, 0, 0]
            assert _is_reached(*_turned_by(frames, move), starts) == reached


def test_a_slide_far_out_may_be_at_the_boundary_where_it_is_not_drawn_in() -> None:
    """Within two metres of slide 3, all that was found was internal; there are boundary singularities beyond."""
    quarter = sp.pi / 2
    rows = (
        Joint("R", "theta1", "h1", "a1", sp.pi),
        Joint("R", sp.Symbol("theta2") + quarter, "h3", "a3", -sp.pi / 6),
        Joint("P", quarter, "d3", "a3", 3 * sp.pi / 4),
        Joint("P", quarter, "d4", 0, quarter),
    )
    kind = classify_pieces(Chain("far out", rows, TASK_ROWS[:3]), ["theta2 = pi and d4 = -sqrt(2)*a3"])
    assert (kind.kind, kind.uniform) == ("boundary", False)
