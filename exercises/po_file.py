"""A file of translations (.po), as Poedit, Weblate and `make messages` write it, read for Python's gettext.

What is not translated, or is marked as fuzzy, is left out: it is shown in English.
"""

import io
import re
import struct
from collections.abc import Iterator, Mapping
from gettext import GNUTranslations
from pathlib import Path

_LINE = re.compile(r'(?:(?P<key>msgctxt|msgid|msgid_plural|msgstr(?:\[\d\])?)\s+)?"(?P<text>(?:[^"\\]|\\.)*)"')
_ESCAPED = re.compile(r"\\(.)")
_ESCAPES = {"n": "\n", "t": "\t", "r": "\r"}

Entry = dict[str, str]
"""The texts of a message by their keywords: msgctxt, msgid, msgstr, …"""


def read_po(path: Path) -> GNUTranslations:
    """Return the translations in a file. Raises ValueError with the line that is none of such a file."""
    texts = dict(_translated(path.read_text(encoding="utf-8"), path.name))
    return GNUTranslations(io.BytesIO(_compiled(texts)))


def _translated(text: str, name: str) -> Iterator[tuple[str, str]]:
    """Yield messages and their translations as gettext knows them: with a context before, plurals behind."""
    for entry in _entries(text, name):
        strings = [string for key, string in entry.items() if key.startswith("msgstr")]
        if not all(strings):
            continue
        context = f"{entry['msgctxt']}\x04" if "msgctxt" in entry else ""
        plural = f"\0{entry['msgid_plural']}" if "msgid_plural" in entry else ""
        yield f"{context}{entry['msgid']}{plural}", "\0".join(strings)


def _entries(text: str, name: str) -> Iterator[Entry]:
    """Yield the messages that are in use and not fuzzy; one ends where a comment or the next begins."""
    entry: Entry = {}
    key, is_fuzzy = "", False
    for number, line in enumerate([*text.split("\n"), ""], 1):
        said = line.strip()
        if key.startswith("msgstr") and (not said or said.startswith(("#", "msgctxt ", "msgid "))):
            if not is_fuzzy or not entry.get("msgid"):  # the file's head is no text
                yield entry
            entry, key, is_fuzzy = {}, "", False
        if not said or said.startswith("#"):
            is_fuzzy |= said.startswith("#,") and "fuzzy" in re.split(r"[,\s]+", said)
            continue
        found = _LINE.fullmatch(said)
        if found is None or not (found["key"] or key):
            raise ValueError(f"{name}: line {number} is none of a .po file: {said[:80]}")
        key = found["key"] or key
        entry[key] = entry.get(key, "") + _ESCAPED.sub(lambda one: _ESCAPES.get(one[1], one[1]), found["text"])


def _compiled(texts: Mapping[str, str]) -> bytes:
    """Return a compiled catalogue (.mo): a head, where each message and each translation lies, and all of them."""
    columns = [[text.encode() for text in column] for column in zip(*sorted(texts.items()), strict=True)]
    tables, pieces, begin = bytearray(), bytearray(), 28 + 16 * len(texts)
    for piece in (piece for column in columns for piece in column):
        tables += struct.pack("<II", len(piece), begin + len(pieces))
        pieces += piece + b"\0"
    head = struct.pack("<7I", 0x950412DE, 0, len(texts), 28, 28 + 8 * len(texts), 0, 28)
    return b"".join((head, tables, pieces))
