"""Formulas for the reach of simple arms agree with the positions of poses and with searches from many starts."""

from collections.abc import Sequence

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.singularities import reach
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.normalized_arm import normalize_arm
from qdot.exercises.singularities.reach import reaches_beyond, reaches_displaced_pose, reaches_point
from tests.support.suites import on_families

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
