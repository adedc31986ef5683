"""Pictures of docs/: each is shown by a page, has an alternative text, and is small."""

import re
import struct

from qdot.exercises.site.guide import arrange_pages
from qdot.exercises.site.pages import link_pages
from qdot.exercises.writing.markup import to_html
from tests.support import ROOT

DOCS = ROOT / "docs"
PICTURES = sorted((DOCS / "pictures").glob("*"))
PICTURE_LINK = re.compile(r"!\[([^\]]*)\]\((pictures/[^)]+)\)")
MAX_BYTES, MAX_WIDTH = 60_000, 900
"""Limits on bytes and pixels, because the wheel and the site contain the pictures."""
MIN_ALT_LENGTH = 30
"""The least number of characters of an alternative text."""


def find_alt_texts() -> dict[str, list[str]]:
    """Return the alternative texts of each picture, page by page."""
    alt_texts: dict[str, list[str]] = {}
    for page in sorted(DOCS.glob("*.md")):
        for words, path in PICTURE_LINK.findall(page.read_text(encoding="utf-8")):
            alt_texts.setdefault(path, []).append(words)
    return alt_texts


def test_every_picture_is_used_and_every_link_has_a_picture() -> None:
    assert sorted(find_alt_texts()) == [path.relative_to(DOCS).as_posix() for path in PICTURES] != []


def test_every_alternative_text_is_long_and_unique() -> None:
    alt_texts = [words for texts in find_alt_texts().values() for words in texts]
    assert [words for words in alt_texts if len(words) < MIN_ALT_LENGTH] == []
    assert len(set(alt_texts)) == len(alt_texts)


def test_pictures_are_small() -> None:
    for path in PICTURES:
        content = path.read_bytes()
        assert content.startswith(b"\x89PNG"), path
        (width,) = struct.unpack(">I", content[16:20])
        assert (width <= MAX_WIDTH, len(content) <= MAX_BYTES) == (True, True), (path, width, len(content))


def test_the_site_shows_pictures_on_listed_pages() -> None:
    listed = [entry.name for entries in arrange_pages(DOCS).values() for entry in entries]
    pages = [page for page in sorted(DOCS.glob("*.md")) if PICTURE_LINK.search(page.read_text(encoding="utf-8"))]
    for page in pages:
        text = page.read_text(encoding="utf-8")
        html = link_pages(to_html(text))
        assert page.stem in listed
        for words, path in PICTURE_LINK.findall(text):
            assert re.search(rf'<img src="{re.escape(path)}" alt="{re.escape(words)}"', html), (page, path)
