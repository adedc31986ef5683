"""Define a page of the site: its path, title and body, and the data that the template around the body needs."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from qdot.exercises.writing.languages import LANGUAGES, load_catalogue

INDEX_FILE, ROBOTS_FILE = "bank/index.json", "bank/robots.json"
"""The list of the problems in the bank (`bank`), and the example tables of arms (`robots`)."""

MAX_DEPTH = 7
"""Maximum number of folders above a missing address in which the error page searches for the site."""


@dataclass(frozen=True)
class Page:
    """A page of the site.

    - `path`: its path in the site
    - `script`: the name of the script that it loads (`pages.SCRIPT_SOURCES`)
    - `section`: its item in the main menu, "" for none
    - `kind`: its layout: "" for running text, "wide", "home", "practice", or "docs" with a list of the documentation
    - `allows_frames`: whether it may show other pages of the site in frames
    - `is_error_page`: whether a server shows it for missing addresses; it searches the folders above for the site
    - `translations`: title and body in other languages, if the site's own catalogue lacks them
    """

    path: str
    title: str
    body: str
    script: str = "pages"
    section: str = ""
    kind: str = ""
    allows_frames: bool = False
    is_error_page: bool = False
    translations: Mapping[str, tuple[str, str]] = field(default_factory=dict)

    @property
    def parent_paths(self) -> list[str]:
        """The relative paths of the folders in which the page searches for its script and styles, such as "../"."""
        return ["../" * count for count in range(MAX_DEPTH if self.is_error_page else 1)]

    @property
    def data_file(self) -> str:
        """The path of the bank's file that is loaded together with the script, "" if there is none."""
        return {"pages": "", "check": "", "own": ROBOTS_FILE}.get(self.script, INDEX_FILE)

    def make_translated_path(self, language: str) -> str:
        """Return the path of the file with the page's title and body in another language."""
        return f"{self.path.removesuffix('.html')}.{language}.json"


def translate_message(message: str) -> dict[str, str]:
    """Map each language to the translation of a message; scripts replace the English text with a translation."""
    return {code: load_catalogue(code).gettext(message) for code in LANGUAGES}
