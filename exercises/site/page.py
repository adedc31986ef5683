"""A page of the site: its path, title and body, and the data for the frame around it."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from qdot.exercises.writing.languages import LANGUAGES, catalogue

INDEX, ROBOTS = "bank/index.json", "bank/robots.json"

DEEPEST = 7
"""The page for missing addresses finds the site up to this depth of folders."""


@dataclass(frozen=True)
class Page:
    """A page: its path in the site, title, body, and the entry whose script it loads.

    `section` is its item of the main menu. `kind` is its width: "" for running text, "wide", "home", or "docs" with a
    list of the documentation beside it. `frames` allows it to show pages of the site in frames. `is_anywhere` is for
    the page shown instead of missing ones: it looks for its script and styles in the folders above, one of which is
    the site's. `translations` are title and body in other languages, if they are not in the site's own catalogue.
    """

    path: str
    title: str
    body: str
    entry: str = "pages"
    section: str = ""
    kind: str = ""
    frames: bool = False
    is_anywhere: bool = False
    translations: Mapping[str, tuple[str, str]] = field(default_factory=dict)

    @property
    def ups(self) -> list[str]:
        """The relative paths to folders that may have its script and styles."""
        return ["../" * count for count in range(DEEPEST if self.is_anywhere else 1)]

    @property
    def data(self) -> str:
        """The bank's file that its script needs first, "" if none; both are loaded at the same time."""
        return {"pages": "", "own": ROBOTS}.get(self.entry, INDEX)

    def translated_path(self, language: str) -> str:
        """Return the path of the file with its title and body in another language."""
        return f"{self.path.removesuffix('.html')}.{language}.json"


def translate_message(message: str) -> dict[str, str]:
    """Return a message in every language except English, for pages that replace the English text."""
    return {code: catalogue(code).gettext(message) for code in LANGUAGES}
