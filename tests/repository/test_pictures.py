"""Pictures of docs/: each is shown by a page, told in words, and small."""

import re
import struct

from qdot.exercises.site.guide import arrange_pages
from qdot.exercises.site.pages import link_pages
from qdot.exercises.writing.markup import to_html
from tests.support import ROOT

DOCS = ROOT / "docs"
PICTURES = sorted((DOCS / "pictures").glob("*"))
SHOWN = re.compile(r"!\[([^\]]*)\]\((pictures/[^)]+)\)")
LARGEST, WIDEST = 60_000, 900
"""Bytes and pixels, as the wheel and the site carry them."""
LEAST = 30
"""Characters in which a picture is told to those who don't see it."""


def shown() -> dict[str, list[str]]:
    """Return the words that stand for each picture, page by page."""
    found: dict[str, list[str]] = {}
    for page in sorted(DOCS.glob("*.md")):
        for words, path in SHOWN.findall(page.read_text(encoding="utf-8")):
            found.setdefault(path, []).append(words)
    return found


def test_every_picture_is_shown_by_a_page_and_every_page_shows_what_is_there() -> None:
    assert sorted(shown()) == [path.relative_to(DOCS).as_posix() for path in PICTURES] != []


def test_every_picture_is_told_in_words_of_its_own() -> None:
    told = [words for each in shown().values() for words in each]
    assert [words for words in told if len(words) < LEAST] == []
    assert len(set(told)) == len(told)


def test_pictures_are_small() -> None:
    for path in PICTURES:
        content = path.read_bytes()
        assert content.startswith(b"\x89PNG"), path
        (width,) = struct.unpack(">I", content[16:20])
        assert (width <= WIDEST, len(content) <= LARGEST) == (True, True), (path, width, len(content))


def test_the_site_shows_them_on_pages_that_its_guide_lists() -> None:
    listed = [entry.name for entries in arrange_pages(DOCS).values() for entry in entries]
    pages = [page for page in sorted(DOCS.glob("*.md")) if SHOWN.search(page.read_text(encoding="utf-8"))]
    for page in pages:
        text = page.read_text(encoding="utf-8")
        made = link_pages(to_html(text))
        assert page.stem in listed
        for words, path in SHOWN.findall(text):
            assert re.search(rf'<img src="{re.escape(path)}" alt="{re.escape(words)}"', made), (page, path)
