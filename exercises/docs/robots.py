"""The table of real robots in docs/robots.md, with their singular configurations in words, computed once and stored.

`python -m qdot.exercises.docs.robots` computes them (a minute) and stores them in robots.json. The rest of the page is
written by hand.
"""

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from qdot.exercises.arm.conventions import REGISTRY, convention_of
from qdot.exercises.arm.library import robots
from qdot.exercises.arm.robot_file import read_robot_file
from qdot.exercises.common.console import say
from qdot.exercises.common.files import write_atomically
from qdot.exercises.solve.solver import solve
from qdot.exercises.writing.render import render

KEPT = Path(__file__).with_name("robots.json")
PAGE = Path(__file__).resolve().parents[2] / "docs" / "robots.md"
SECTION, NEXT = "## Real robots\n", "\n## "
LONG = ("baxter", "gen3", "panda", "sawyer")
"""Arms of seven joints with offsets: the conditions under which they are singular fill lines."""
MOST_TERMS = 10
"""The most terms of a condition that has words; longer ones have none but that J loses rank."""


def robots_page() -> str:
    """Return docs/robots.md with an up-to-date section on real robots."""
    text = PAGE.read_text(encoding="utf-8")
    before, heading, after = text.partition(SECTION)
    assert heading, f"docs/robots.md has no section {SECTION.strip()!r}"
    _, end, rest = after.partition(NEXT)
    groups: dict[tuple[str, ...], list[str]] = {}
    for name, words in load_singular_words().items():
        groups.setdefault(words, []).append(name)
    section = render("docs/robots.md.j2", robots=robots().values(), conventions=REGISTRY, groups=groups)
    return f"{before}{SECTION}{section.rstrip()}\n{end}{rest}"


@cache
def load_singular_words() -> Mapping[str, tuple[str, ...]]:
    """Return the stored descriptions of each robot's singular configurations; empty if there is no short one."""
    return {name: tuple(words) for name, words in json.loads(KEPT.read_text(encoding="utf-8")).items()}


def describe_singular_set(name: str) -> tuple[str, ...]:
    """Describe the singular configurations of a robot, with a text for each component of the singular set."""
    if name in LONG:
        return ()
    chain = read_robot_file(robots()[name].path).chain
    components = solve(chain).singular or ()
    if any(len(condition.args) > MOST_TERMS for component in components for condition in component.conditions):
        return ()
    return tuple(convention_of(chain).rename_origins(component.kind.meaning) for component in components)


def singular_words_text() -> str:
    """Return the file that `kept` reads, worked out anew."""
    return json.dumps({name: describe_singular_set(name) for name in robots()}, indent=1) + "\n"


if __name__ == "__main__":
    write_atomically(KEPT, singular_words_text())
    say(f"wrote {KEPT.name}")
