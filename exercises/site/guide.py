"""List the pages of the documentation in the site's order: in groups by reader, each with a line on its content."""

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path

REPLACED_PAGES = {"examples": "examples/index.html", "errata": "examples/errata.html", "families": "arms.html"}
"""Maps each page of docs/ that the site replaces to the path of the site's own page."""
COMMANDS = "commands"
"""The page on the command line, which is made from the program itself."""
GROUPS: dict[str, dict[str, tuple[str, str]]] = tomllib.loads(
    Path(__file__).with_name("guide.toml").read_text(encoding="utf-8")
)
"""Maps each group to its pages of docs/, and each of these pages to its title and a line on its content."""
OTHER_PAGES = "More"
"""The name of the last group, which has all other pages."""


@dataclass(frozen=True)
class DocumentationEntry:
    """A page of the documentation in a list: its name in docs/, its title, and a line on its content."""

    name: str
    title: str
    summary: str


def arrange_pages(docs: Path) -> dict[str, list[DocumentationEntry]]:
    """Map each group to its existing pages; pages without a group come last, with their headings as titles."""
    paths = {path.stem: path for path in sorted(docs.glob("*.md")) if path.stem not in REPLACED_PAGES}
    groups = {
        group: [DocumentationEntry(name, *texts) for name, texts in pages.items() if name in {*paths, COMMANDS}]
        for group, pages in GROUPS.items()
    }
    grouped_names = {entry.name for entries in groups.values() for entry in entries}
    groups[OTHER_PAGES] = [
        DocumentationEntry(name, _find_heading(path), "") for name, path in paths.items() if name not in grouped_names
    ]
    return {group: entries for group, entries in groups.items() if entries}


def _find_heading(path: Path) -> str:
    """Return the first-level heading of a page, or the name of its file if there is none."""
    match = re.search(r"^# (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return match.group(1) if match else path.stem
