"""The section of docs/robots.md on real robots: it has them all, and says where each is singular as is derived."""

import pytest

from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.library import robots
from qdot.exercises.arm.robot_file import read_robot_file
from qdot.exercises.solve.solver import solve
from tests.tools.docs_pages import PAGE, load_singular_words, robots_page

SOME = ("cobra600", "stanford", "ur5")
LONG = ("baxter", "gen3", "panda", "sawyer")
"""Arms of seven joints with offsets: the conditions under which they are singular fill lines."""
MOST_TERMS = 10
"""The most terms of a condition that has words; of longer ones it is only said that J loses rank."""


def describe_singular_set(name: str) -> tuple[str, ...]:
    """Describe each component of a robot's singular set; nothing if a condition is too long."""
    if name in LONG:
        return ()
    chain = read_robot_file(robots()[name].path).chain
    components = solve(chain).singular or ()
    if any(len(condition.args) > MOST_TERMS for component in components for condition in component.conditions):
        return ()
    return tuple(convention_of(chain).rename_origins(component.kind.meaning) for component in components)


def test_every_robot_has_its_row_and_its_words() -> None:
    assert list(load_singular_words()) == list(robots())
    section = PAGE.read_text(encoding="utf-8").partition("## Real robots")[2].partition("\n## ")[0]
    for robot in robots().values():
        assert f"| `{robot.name}` | {robot.title} | {robot.joints} | " in section
        assert section.count(f"`{robot.name}`") >= 2
        assert all(words in section for words in load_singular_words()[robot.name])
    assert all(load_singular_words()[name] == () for name in LONG)


def test_what_is_written_by_hand_around_the_section_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the first line fails, run: make docs"""
    page = PAGE.read_text(encoding="utf-8")
    assert robots_page() == page
    assert page.startswith("# Your own arm\n") and "\n## What is derived\n" in page


@pytest.mark.parametrize(
    "name", [name if name in SOME else pytest.param(name, marks=pytest.mark.whole) for name in robots()]
)
def test_words_are_those_of_the_singular_set_that_is_derived(name: str) -> None:
    """Where this fails, correct tests/tools/robots.json, then run: make docs"""
    assert describe_singular_set(name) == load_singular_words()[name]
