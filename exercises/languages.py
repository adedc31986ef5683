"""The languages of problems besides English: for each a catalogue of titles and phrases, a file beside its templates.

A problem carries English words: titles, what configurations look like, the sentence of a mistake. A catalogue has them
in its language, by registered name or by the English phrase, in which braces stand for what is taken over.
"""

import re
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

ENGLISH = "en"

LANGUAGES: dict[str, str] = {"de": "Deutsch"}
"""By code, which is the name of the folder in templates/ too: what a language calls itself."""

Row = tuple[re.Pattern[str], str]


@dataclass(frozen=True)
class Catalogue:
    """The words of a language.

    `decimal` is its decimal sign; `see` says where to look; titles by the names of `families` and `questions`; `arms`:
    a heading and the words for a sentence; `sources`: places in the chapter; `mistakes`: title and sentence, by name.
    """

    decimal: str
    see: str
    families: Mapping[str, str]
    questions: Mapping[str, str]
    arms: Mapping[str, tuple[str, str]]
    sources: Mapping[str, str]
    phrases: Mapping[str, str]
    mistakes: Mapping[str, tuple[str, str]]

    @staticmethod
    def read(path: Path) -> "Catalogue":
        """Return the catalogue that a file holds."""
        return Catalogue(**tomllib.loads(path.read_text(encoding="utf-8")))

    @cached_property
    def _phrases(self) -> list[Row]:
        return [(pattern(english), own) for english, own in self.phrases.items()]

    @cached_property
    def _arms(self) -> list[tuple[Row, Row]]:
        return [((pattern(name), title), (pattern(name), shown)) for name, (title, shown) in self.arms.items()]

    def phrase(self, english: object) -> str:
        """Return a phrase in the language, by the first pattern that fits; what no pattern fits stays as it is."""
        text = str(english)
        if re.fullmatch(r"-?\d+\.\d+", text):
            return text.replace(".", self.decimal)
        return _first(self._phrases, text, self.phrase)

    def arm_title(self, name: str) -> str:
        """Return the heading for an arm that has this name for its own."""
        return _first((row for row, _ in self._arms), name)

    def arm_shown(self, name: str) -> str:
        """Return the words for such an arm as the object of a sentence, with an article."""
        return _first((row for _, row in self._arms), name)

    def mistake_title(self, name: str) -> str:
        """Return the title of a mistake."""
        return self.mistakes[name][0]

    def mistake_said(self, name: str, says: str, source: str, sentence: str) -> str:
        """Return the sentence on a mistake; `says` is the English pattern that was filled in for `sentence`."""
        own = self.mistakes[name][1]
        found = pattern(says + "{tail}").fullmatch(sentence)
        if found is None:
            return sentence
        where = self.sources.get(source, f"({source})")
        words = {key: self.phrase(word) for key, word in found.groupdict().items()}
        return f"{own.format(**words)} {self.see.format(where=where)}"

    def with_decimals(self, text: str) -> str:
        """Return Markdown with the decimal sign of the language in its formulas; code and prose stay as they are.

        Commas between numbers become semicolons there, as 0,5, 1 would be three numbers or two.
        """
        if self.decimal == ".":
            return text
        return _PIECES.sub(self._own_decimals, text)

    def _own_decimals(self, piece: re.Match[str]) -> str:
        formula = piece["formula"]
        if formula is None or not _DECIMAL.search(formula):
            return piece[0]
        return _DECIMAL.sub(rf"\1{{{self.decimal}}}\2", re.sub(r"(?<!\\), (?!\\q)", "; ", formula))


def _first(rows: Iterable[Row], text: str, inner: Callable[[str], str] = str) -> str:
    """Return a text by the first row that fits, with `inner` of the words taken over; as it is where none fits."""
    for fits, own in rows:
        found = fits.fullmatch(text)
        if found is not None:
            return own.format(**{key: inner(word) for key, word in found.groupdict().items()})
    return text


_DECIMAL = re.compile(r"(\d)\.(\d)")
_PIECES = re.compile(r"`[^`]*`|(?P<formula>\$\$.*?\$\$|\$[^$]*\$)", re.DOTALL)


def pattern(phrase: str) -> re.Pattern[str]:
    """Return what fits a phrase with names in braces; a name that occurs twice stands for the same both times.

    >>> pattern("row {n}").fullmatch("row 2")["n"]
    '2'
    """
    parts, seen = [], set()
    for i, part in enumerate(re.split(r"\{(\w+)\}", phrase)):
        if i % 2 == 0:
            parts.append(re.escape(part))
        else:
            parts.append(f"(?P={part})" if part in seen else f"(?P<{part}>.+?)")
            seen.add(part)
    return re.compile("".join(parts), re.DOTALL)
