"""The formulas for what simple arms reach grant every place that a pose has, and agree with a search."""

from collections.abc import Sequence

import numpy as np
import pytest

from exercises.arm import beyond
from exercises.arm.axes import Sample
from exercises.arm.bare import bare
from exercises.arm.chain import TASK_ROWS
from exercises.arm.kinematics import NumericChain
from exercises.arm.reach import reaches, reaches_beside
from exercises.arm.three_joints import UNSURE
from exercises.generation import sample_chain
from exercises.problem import ProblemId
from tests.support.suites import of_families

FAMILIES = ("planar-2r", "planar-3r", "polar-rp", "elbow-3r", "spherical", "spherical-offset")
BESIDE = (
    *FAMILIES, "planar-pr", "planar-rpr", "planar-rrp", "planar-prr", "planar-3r-pose", "cylindrical", "scara",
    "scara-rrrp", "scara-prrr",
)  # fmt: skip


def arms(family: str) -> list[tuple[NumericChain, list[int]]]:
    """Return some arms of a family in numbers, with the rows of their task."""
    chains = [sample_chain(ProblemId(family, seed)) for seed in range(4)]
    lengths = ({symbol.name: 0.35 + 0.11 * k for k, symbol in enumerate(chain.parameters)} for chain in chains)
    rows = ([TASK_ROWS.index(row) for row in chain.task] for chain in chains)
    return list(zip(map(NumericChain, chains, lengths), rows, strict=True))


@of_families(FAMILIES)
def test_where_a_pose_has_the_point_it_is_reached(family: str) -> None:
    random = np.random.default_rng(6)
    for arm, task in arms(family):
        places = arm.point(random.uniform(-3, 3, (50, len(arm.kinds))))
        found = [reaches(arm, task, place) for place in places]
        assert False not in found
        assert found.count(True) > 45


def test_a_place_on_the_first_axis_is_reached_by_a_slide_through_it() -> None:
    """The arm has no length but its slide, so that rounding is not small against its links."""
    arm = NumericChain(bare(sample_chain(ProblemId.parse("spherical/10007").varied("full"))), {})
    for height in (1.0, 1e-2, 1e-4, -1e-4):
        for aside in (0.0, 1e-17, -1e-19):
            assert reaches(arm, [0, 1, 2], np.array([0.0, aside, height])), (height, aside)


@of_families(BESIDE)
def test_what_another_pose_has_is_reached_from_a_pose(family: str) -> None:
    """The point and the angle, if it counts, of one pose as seen from another."""
    random = np.random.default_rng(8)
    for arm, task in arms(family):
        q = random.uniform(-2, 2, (50, 2, len(arm.kinds)))
        said = [_told(arm, task, here, there) for here, there in q]
        assert False not in said
        assert said.count(True) > 45


def _told(arm: NumericChain, task: list[int], here: np.ndarray, there: np.ndarray) -> bool | None:
    frames, others = arm.frames(here), arm.frames(there)
    turn = others[-1, :3, :3] @ frames[-1, :3, :3].T
    third = max(task) - 3 if max(task) > 2 else 2
    first, second = (third + 1) % 3, (third + 2) % 3
    angles = np.zeros(3)
    angles[third] = np.arctan2(turn[second, first], turn[first, first])
    shift = np.concatenate([arm.point_of(others) - arm.point_of(frames), angles])
    return reaches_beside(arm, frames, task, shift[task])


@of_families(BESIDE)
def test_it_says_what_a_search_finds(family: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """At places well inside, well outside and in holes; the search takes a place beside the point of a pose."""
    random = np.random.default_rng(7)
    monkeypatch.setattr(beyond, "_BEYOND", 0.2)
    said = [_search(arm, task, random, monkeypatch) for arm, task in arms(family) for _ in range(4)]
    assert all(formula is None or formula is search for formula, search in said)
    assert sum(formula is not None for formula, _ in said) > len(said) / 2


def _search(
    arm: NumericChain, task: Sequence[int], random: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> tuple[bool | None, bool]:
    way = random.normal(size=len(task))
    given: list[bool | None] = []
    monkeypatch.setattr(beyond, "reaches_places", lambda arms, places: np.array([UNSURE]))
    monkeypatch.setattr(beyond, "reaches_beside", lambda *of: given.append(reaches_beside(*of)))
    sample = Sample(arm, random.uniform(-2, 2, len(arm.kinds)))
    (found,) = beyond.reached_beyond([sample], list(task), (way / np.linalg.norm(way))[None])
    return given[0], bool(found)


def test_of_other_arms_and_tasks_nothing_is_said() -> None:
    arm, _ = arms("scara")[0]
    assert reaches(arm, [0, 1, 2], np.zeros(3)) is None
    arm, _ = arms("planar-2r")[0]
    assert reaches(arm, [0, 1, 5], np.zeros(3)) is None


def test_a_place_and_a_turn_about_some_other_axis_are_not_told() -> None:
    arm, _ = arms("planar-3r-pose")[0]
    frames = arm.frames(np.zeros(3))
    assert reaches_beside(arm, frames, [0, 1, 5], np.zeros(3)) is not None
    assert reaches_beside(arm, frames, [0, 1, 3], np.zeros(3)) is None
    arm, _ = arms("orthogonal-3r")[0]
    assert reaches_beside(arm, arm.frames(np.zeros(3)), [0, 1, 2], np.zeros(3)) is None
