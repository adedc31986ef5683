"""The section of docs/robots.md on real robots: it has them all, and says where each is singular as is derived."""

import pytest

from qdot.exercises.arm.library import robots
from qdot.exercises.docs.robots import LONG, PAGE, kept, robots_page, singular_in_words

SOME = ("cobra600", "stanford", "ur5")


def test_every_robot_has_its_row_and_its_words() -> None:
    assert list(kept()) == list(robots())
    section = PAGE.read_text(encoding="utf-8").partition("## Real robots")[2].partition("\n## ")[0]
    for robot in robots().values():
        assert f"| `{robot.name}` | {robot.title} | {robot.joints} | " in section
        assert section.count(f"`{robot.name}`") >= 2
        assert all(words in section for words in kept()[robot.name])
    assert all(kept()[name] == () for name in LONG)


def test_what_is_written_by_hand_around_the_section_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the first line fails, run: python -m qdot.exercises.docs"""
    page = PAGE.read_text(encoding="utf-8")
    assert robots_page() == page
    assert page.startswith("# Your own arm\n") and "\n## What is derived\n" in page


@pytest.mark.parametrize(
    "name", [name if name in SOME else pytest.param(name, marks=pytest.mark.whole) for name in robots()]
)
def test_words_are_those_of_the_singular_set_that_is_derived(name: str) -> None:
    """Where this fails, run: python -m qdot.exercises.docs.robots"""
    assert singular_in_words(name) == kept()[name]
