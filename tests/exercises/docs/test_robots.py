"""docs/robots.md lists the real robots, and their derived singular sets are described as recorded."""

import json

import pytest

from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.robots.library import list_robots
from qdot.exercises.robots.robot_file import read_robot_file
from qdot.exercises.solve.solver import solve
from tests.support import DATA
from tests.tools.docs_pages import PAGE, robots_page

RECORDED = json.loads((DATA / "singular_robots.json").read_text(encoding="utf-8"))
"""The descriptions of each robot's singular configurations; none if a condition is too long."""
SOME = ("cobra600", "stanford", "ur5")
LONG = ("baxter", "gen3", "panda", "sawyer")
"""Arms with seven joints and offsets, whose singularity conditions are too long."""
MOST_TERMS = 10
"""The most terms of a condition that is described in words."""


def describe_singular_set(name: str) -> tuple[str, ...]:
    """Describe each component of a robot's singular set; nothing if a condition is too long."""
    if name in LONG:
        return ()
    chain = read_robot_file(list_robots()[name].path).chain
    components = solve(chain).singular or ()
    if any(len(condition.args) > MOST_TERMS for component in components for condition in component.conditions):
        return ()
    return tuple(convention_of(chain).rename_origins(component.classification.meaning) for component in components)


def test_every_robot_has_a_row() -> None:
    section = PAGE.read_text(encoding="utf-8").partition("## Real robots")[2].partition("\n## ")[0]
    for robot in list_robots().values():
        assert f"| `{robot.name}` | {robot.title} | {robot.joints} |" in section


def test_robots_page_is_up_to_date_and_keeps_handwritten_text(monkeypatch: pytest.MonkeyPatch) -> None:
    """If the first assertion fails, run: make docs"""
    page = PAGE.read_text(encoding="utf-8")
    assert robots_page() == page
    assert page.startswith("# Your own arm\n") and "\n## What is derived\n" in page


def test_singular_sets_of_all_robots_are_recorded() -> None:
    assert list(RECORDED) == list(list_robots())
    assert all(RECORDED[name] == [] for name in LONG)


@pytest.mark.parametrize(
    "name", [name if name in SOME else pytest.param(name, marks=pytest.mark.whole) for name in list_robots()]
)
def test_derived_singular_set_is_described_as_recorded(name: str) -> None:
    """If this fails and the new description is right, correct tests/data/singular_robots.json."""
    assert list(describe_singular_set(name)) == RECORDED[name]
