"""Define a page of the site: its path, title and body, and the data that the template around the body needs."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from qdot.exercises.writing.languages import LANGUAGES, load_catalogue

INDEX_FILE, ROBOTS_FILE = "bank/index.json", "bank/robots.json"

MAX_DEPTH = 7
"""Maximum depth of folders from which the page for missing addresses finds the site."""


@dataclass(frozen=True)
class Page:
    """A page: its path in the site, its title, its body, and the name of the script that it loads (`pages.ENTRIES`).

    `section` is its item in the main menu. `kind` is its layout: "" for running text, "wide", "home", "practice", or
    "docs" with a list of the documentation beside it. `allows_frames` allows it to show pages of the site in frames.
    `is_error_page` is for the page that a server shows for missing addresses: it searches the folders above for its
    script and styles. `translations` are title and body in other languages, if the site's own catalogue lacks them.
    """

    path: str
    title: str
    body: str
    entry: str = "pages"
    section: str = ""
    kind: str = ""
    allows_frames: bool = False
    is_error_page: bool = False
    translations: Mapping[str, tuple[str, str]] = field(default_factory=dict)

    @property
    def parent_paths(self) -> list[str]:
        """The relative paths of the folders in which the page searches for its script and styles."""
        return ["../" * count for count in range(MAX_DEPTH if self.is_error_page else 1)]

    @property
    def data_file(self) -> str:
        """The file of the bank that is loaded together with the script, "" if none."""
        return {"pages": "", "own": ROBOTS_FILE}.get(self.entry, INDEX_FILE)

    def translated_path(self, language: str) -> str:
        """Return the path of the file with its title and body in another language."""
        return f"{self.path.removesuffix('.html')}.{language}.json"


def translate_message(message: str) -> dict[str, str]:
    """Return a message in every language except English, for pages that replace the English text."""
    return {code: load_catalogue(code).gettext(message) for code in LANGUAGES}
