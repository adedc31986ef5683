"""A page of the site: its path, title and body, and what the frame around it is told."""

from dataclasses import dataclass

INDEX, ROBOTS = "bank/index.json", "bank/robots.json"


@dataclass(frozen=True)
class Page:
    """A page: its path in the site, title, body, and the entry whose script it loads.

    `section` is the item of the main menu that it belongs to; `kind` is how wide it is: "" for text to be read, "wide",
    "home", or "docs" with what there is to read beside it. One that shows pages of the site in `frames` may do so.
    """

    path: str
    title: str
    body: str
    entry: str = "pages"
    section: str = ""
    kind: str = ""
    frames: bool = False

    @property
    def data(self) -> str:
        """The file of the bank that its script asks for first, "" where it asks for none: both are loaded at once."""
        return {"pages": "", "own": ROBOTS}.get(self.entry, INDEX)
