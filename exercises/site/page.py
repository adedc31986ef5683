"""A page of the site: its path, title and body, and what the frame around it is told."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from qdot.exercises.writing.languages import LANGUAGES, catalogue

INDEX, ROBOTS = "bank/index.json", "bank/robots.json"

DEEPEST = 7
"""So many folders deep a page that is not there still finds the site."""


@dataclass(frozen=True)
class Page:
    """A page: its path in the site, title, body, and the entry whose script it loads.

    `section` is the item of the main menu that it belongs to; `kind` is how wide it is: "" for text to be read, "wide",
    "home", or "docs" with what there is to read beside it. One that shows pages of the site in `frames` may do so.
    One that is_anywhere is shown in the place of pages that are not there, and asks for its script and styles in the
    folders above, one of which is the site's.
    `told` is title and body in other languages, where they are not texts of the site's own catalogue.
    """

    path: str
    title: str
    body: str
    entry: str = "pages"
    section: str = ""
    kind: str = ""
    frames: bool = False
    is_anywhere: bool = False
    told: Mapping[str, tuple[str, str]] = field(default_factory=dict)

    @property
    def ups(self) -> list[str]:
        """The ways to where its script and styles may be."""
        return ["../" * count for count in range(DEEPEST if self.is_anywhere else 1)]

    @property
    def data(self) -> str:
        """The file of the bank that its script asks for first, "" where it asks for none: both are loaded at once."""
        return {"pages": "", "own": ROBOTS}.get(self.entry, INDEX)

    def told_path(self, language: str) -> str:
        """Return the file with its title and body in another language."""
        return f"{self.path.removesuffix('.html')}.{language}.json"


def in_languages(message: str) -> dict[str, str]:
    """Return a message in every language but English, by which the page puts it in the place of the English one."""
    return {code: catalogue(code).gettext(message) for code in LANGUAGES}
