"""The section of docs/robots.md on real robots: their table, and their singular configurations in words (robots.json).

The rest of the page is written by hand.
"""

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from qdot.exercises.arm.conventions import REGISTRY
from qdot.exercises.arm.library import robots
from qdot.exercises.writing.render import render

KEPT = Path(__file__).with_name("robots.json")
PAGE = Path(__file__).resolve().parents[2] / "docs" / "robots.md"
SECTION, NEXT = "## Real robots\n", "\n## "


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
