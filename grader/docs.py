"""docs/outlets.md, made from the registries of outlets and of reports: `python -m grader.docs` writes it."""

from pathlib import Path

from exercises.console import say
from exercises.exports.registry import OUTLETS
from exercises.files import write_atomically
from exercises.render import render
from grader.reports.formats import FORMATS

PAGE = "outlets.md"


def outlets_page() -> str:
    """Return the page: what is written, which program reads it, and what in our tests reads it as that would."""
    return render("docs/outlets.md.j2", outlets=OUTLETS.values(), formats=FORMATS.values())


if __name__ == "__main__":
    write_atomically(Path(__file__).parents[1] / "docs" / PAGE, outlets_page())
    say(f"wrote {PAGE}")
