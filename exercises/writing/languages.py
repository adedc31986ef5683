"""The languages of problems and of the site: messages of gettext, known by their English, a file `locale/CODE.po` each.

Whoever writes sentences has them in English, marked as messages (`gettext` here, `{% trans %}` in a template), and what
is filled in is named: "row %(n)s". `make messages` collects them. polib reads the files, and is
imported only where a language other than English is asked for.

A problem carries English words, too: titles, what configurations look like, the sentence of a mistake. They are
messages by what they are registered as, or by `translatable_phrases`, in which braces stand for what is taken over:
"row {n}".
"""

import io
import re
from collections.abc import Callable, Iterable
from functools import cache, cached_property
from gettext import GNUTranslations, NullTranslations
from pathlib import Path

from qdot.exercises.writing.translatable_phrases import ARMS, PHRASES

ENGLISH = "en"

LANGUAGES: dict[str, str] = {"de": "Deutsch"}
"""By code, which names the file of its messages: what a language calls itself."""

LOCALE = Path(__file__).parents[1] / "locale"
"""The folder of those files."""

ARM, SHOWN, FAMILY, QUESTION, PHRASE, SOURCE = (
    "arm, as a heading", "arm, behind “The figure shows”", "family", "question", "phrase", "source, behind “See”",
)  # fmt: skip
"""Contexts: what a message is, where its English alone does not say it."""

Row = tuple[re.Pattern[str], str]


def is_formula(where: str) -> bool:
    """Return whether a place in the chapter is a formula, known by its number alone, as in "(6.1)"."""
    return re.fullmatch(r"\(\d+\.\d+\)", where) is not None


def mistake_context(name: str) -> str:
    """Return the context of a mistake's title and sentence."""
    return f"mistake {name}"


@cache
def catalogue(language: str) -> "Catalogue":
    """Return the messages of a language."""
    return Catalogue() if language == ENGLISH else read(LOCALE / f"{language}.po")


def read(path: Path) -> "Catalogue":
    """Return the messages in a file, by polib as a compiled catalogue, which is what Python's gettext reads."""
    import polib

    return Catalogue(GNUTranslations(io.BytesIO(polib.pofile(str(path)).to_binary())))


class Catalogue:
    """The messages of a language; without translations those of English, which are the messages themselves."""

    def __init__(self, translations: NullTranslations | None = None) -> None:
        self.is_english = translations is None
        self.translations = translations if translations is not None else NullTranslations()

    def gettext(self, message: str, **values: object) -> str:
        """Return a message with values filled in."""
        return self.translations.gettext(message) % values

    def pgettext(self, context: str, message: str, **values: object) -> str:
        """Return a message that says different things in different contexts."""
        return self.translations.pgettext(context, message) % values

    # --- words that problems carry ---

    def phrase(self, english: object) -> str:
        """Return a phrase in the language, by the first pattern that fits; what no pattern fits stays as it is."""
        text = str(english)
        if self.is_english:
            return text
        if re.fullmatch(r"-?\d+\.\d+", text):
            return text.replace(".", self._decimal)
        return _first(self._phrases, text, self.phrase)

    def family(self, title: str) -> str:
        """Return the title of a family."""
        return self._of(FAMILY, title)

    def question(self, title: str) -> str:
        """Return the title of a question."""
        return self._of(QUESTION, title)

    def arm_title(self, name: str) -> str:
        """Return the heading for an arm that has this name for its own."""
        return _first(self._arms(ARM), name or "arm")

    def arm_shown(self, name: str) -> str:
        """Return the words for such an arm behind "The figure shows", with an article."""
        named = name or "arm"
        if self.is_english:
            return f"{'an' if re.match(r'[aeiou]|R[RP]+ ', named) else 'a'} {named}"
        return _first(self._arms(SHOWN), named)

    def mistake_title(self, name: str, title: str) -> str:
        """Return the title of a mistake."""
        return self._of(mistake_context(name), title)

    def mistake_inside(self, name: str, title: str) -> str:
        """Return the title of a mistake inside of a sentence, where English has a small letter and German a capital."""
        translation = self.mistake_title(name, title)
        first = self.pgettext("first letter of a mistake's title inside of a sentence", "a")
        return translation if first.isupper() else f"{translation[0].lower()}{translation[1:]}"

    def mistake_said(self, name: str, says: str, where: str, sentence: str) -> str:
        """Return the sentence on a mistake; `says` is the English pattern that was filled in for `sentence`."""
        match = pattern(says + "{tail}").fullmatch(sentence)
        if self.is_english or match is None:
            return sentence
        place = where if is_formula(where) else self._of(SOURCE, where)
        words = {key: self.phrase(word) for key, word in match.groupdict().items()}
        see = self.gettext("See %(where)s.", where=place)
        return f"{self._of(mistake_context(name), says).format(**words)} {see}"

    # --- numbers ---

    def with_decimals(self, text: str) -> str:
        """Return Markdown with the decimal sign of the language in its formulas; code and prose stay as they are.

        Commas between numbers become semicolons there, as 0,5, 1 would be three numbers or two.
        """
        return text if self._decimal == "." else _PIECES.sub(self._own_decimals, text)

    def with_decimal(self, number: str) -> str:
        """Return a number, as it stands in a sentence, with the decimal sign of the language.

        >>> catalogue("de").with_decimal("−0.25 m/s")
        '−0,25 m/s'
        """
        return _DECIMAL.sub(rf"\1{self._decimal}\2", number)

    @cached_property
    def _decimal(self) -> str:
        return self.pgettext("decimal sign", ".")

    def _own_decimals(self, piece: re.Match[str]) -> str:
        formula = piece["formula"]
        if formula is None or not _DECIMAL.search(formula):
            return piece[0]
        return _DECIMAL.sub(rf"\1{{{self._decimal}}}\2", re.sub(r"(?<!\\), (?!\\q)", "; ", formula))

    # --- messages that are no templates of their own: their braces are filled in, and a percent sign is one ---

    def _of(self, context: str, message: str) -> str:
        return self.translations.pgettext(context, message)

    @cached_property
    def _phrases(self) -> list[Row]:
        return [(pattern(english), self._of(PHRASE, english)) for english in PHRASES]

    def _arms(self, context: str) -> list[Row]:
        return [(pattern(name), self._of(context, name)) for name in ARMS]


def _first(rows: Iterable[Row], text: str, inner: Callable[[str], str] = str) -> str:
    """Return a text by the first row that fits, with `inner` of the words taken over; as it is where none fits."""
    for fits, translation in rows:
        match = fits.fullmatch(text)
        if match is not None:
            return translation.format(**{key: inner(word) for key, word in match.groupdict().items()})
    return text


_DECIMAL = re.compile(r"(\d)\.(\d)")
_PIECES = re.compile(r"`[^`]*`|(?P<formula>\$\$.*?\$\$|\$[^$]*\$)", re.DOTALL)


@cache
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
