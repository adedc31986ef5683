"""Translate problems and the site with gettext: a file `locale/CODE.po` has the translation of each English message.

Messages are sentences that are marked by `gettext` in Python and by `{% trans %}` in a template. Values to fill in have
names, as in "row %(n)s". `make messages` collects the messages. The files are parsed with polib, which is imported only
for languages other than English.

A problem also contains English words: titles, descriptions of configurations, sentences on mistakes. These words are
messages, too. Some are listed where they are defined; for others, `translatable_phrases` has a pattern. In a pattern,
braces mark the parts that are copied to the translation, as in "row {n}".
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
"""The languages other than English: each code, which is also the name of the message file, with the language's name."""

LOCALE = Path(__file__).parents[1] / "locale"
"""The folder of the message files."""

ARM_HEADING, ARM_IN_SENTENCE, FAMILY, QUESTION, PHRASE, SOURCE = (
    "arm, as a heading", "arm, behind “The figure shows”", "family", "question", "phrase", "source, behind “See”",
)  # fmt: skip
"""Contexts of messages. A context distinguishes messages with the same English text."""

PhraseTranslation = tuple[re.Pattern[str], str]
"""A regular expression for an English phrase, and the translation with names in braces."""


def is_formula_number(reference: str) -> bool:
    """Return whether a reference to the chapter is just a formula's number, as in "(6.1)"."""
    return re.fullmatch(r"\(\d+\.\d+\)", reference) is not None


def name_mistake_context(name: str) -> str:
    """Return the context of a mistake's title and sentence."""
    return f"mistake {name}"


@cache
def load_catalogue(language: str) -> "Catalogue":
    """Return the messages of a language."""
    return Catalogue() if language == ENGLISH else read_catalogue(LOCALE / f"{language}.po")


def read_catalogue(path: Path) -> "Catalogue":
    """Return the messages in a file. Python's gettext needs a compiled catalogue, which polib makes."""
    import polib

    return Catalogue(GNUTranslations(io.BytesIO(polib.pofile(str(path)).to_binary())))


class Catalogue:
    """The messages of a language; without translations, messages are returned in English."""

    def __init__(self, translations: NullTranslations | None = None) -> None:
        self.is_english = translations is None
        self.translations = translations if translations is not None else NullTranslations()

    @property
    def language(self) -> str:
        """The code of the language, such as "de"."""
        return ENGLISH if self.is_english else self.translations.info().get("language", "")

    def gettext(self, message: str, **values: object) -> str:
        """Return a message with values filled in."""
        return self.translations.gettext(message) % values

    def pgettext(self, context: str, message: str, **values: object) -> str:
        """Return a message whose translation depends on the context, with values filled in."""
        return self.translations.pgettext(context, message) % values

    # --- words that problems carry ---

    def translate_phrase(self, english: object) -> str:
        """Translate a phrase by the first pattern that matches it; return it unchanged if no pattern matches."""
        text = str(english)
        if self.is_english:
            return text
        if re.fullmatch(r"-?\d+\.\d+", text):
            return text.replace(".", self._decimal_sign)
        return _translate_by_first_match(self._phrase_translations, text, self.translate_phrase)

    def translate_family(self, title: str) -> str:
        """Return the title of a family."""
        return self._translate(FAMILY, title)

    def translate_question(self, title: str) -> str:
        """Return the title of a question."""
        return self._translate(QUESTION, title)

    def translate_arm_title(self, name: str) -> str:
        """Return the heading for an arm that has a name, or the general heading if `name` is empty."""
        return _translate_by_first_match(self._list_arm_translations(ARM_HEADING), name or "arm")

    def translate_arm_in_sentence(self, name: str) -> str:
        """Return the name of an arm with an article, as it follows "The figure shows" in a sentence."""
        arm_name = name or "arm"
        if self.is_english:
            return f"{'an' if re.match(r'[aeiou]|R[RP]+ ', arm_name) else 'a'} {arm_name}"
        return _translate_by_first_match(self._list_arm_translations(ARM_IN_SENTENCE), arm_name)

    def translate_mistake_title(self, name: str, title: str) -> str:
        """Return the title of a mistake."""
        return self._translate(name_mistake_context(name), title)

    def translate_title_in_sentence(self, name: str, title: str) -> str:
        """Return the title of a mistake for the middle of a sentence: with a small initial, except in German.

        A name, such as Jacobian, and a symbol keep their capital letter.
        """
        translation = self.translate_mistake_title(name, title)
        initial = self.pgettext("first letter of a mistake's title inside of a sentence", "a")
        keeps_initial = initial.isupper() or re.match(r"Jacobian|[B-Z]\W", translation)
        return translation if keeps_initial else f"{translation[0].lower()}{translation[1:]}"

    def translate_mistake_sentence(self, name: str, english_pattern: str, english_source: str, sentence: str) -> str:
        """Return the translation of a `sentence` on a mistake, which was made from `english_pattern`.

        The translation ends with a reference to the chapter, `english_source`, unless this is empty.
        """
        pattern = make_phrase_pattern(english_pattern + ("{tail}" if english_source else ""), allows_empty=True)
        match = pattern.fullmatch(sentence)
        if self.is_english or match is None:
            return sentence
        words = {key: self.translate_phrase(word) for key, word in match.groupdict().items()}
        translation = self._translate(name_mistake_context(name), english_pattern).format(**words)
        if not english_source:
            return translation
        source = english_source if is_formula_number(english_source) else self._translate(SOURCE, english_source)
        reference = self.gettext("See %(where)s.", where=source)
        return f"{translation} {reference}"

    def add_article(self, text: str) -> str:
        """Return a text that comes before the name of a frame, with an article after a preposition at its end.

        In English, the names of frames contain their articles.

        >>> load_catalogue("de").add_article("Wo liegt $P$ in ")
        'Wo liegt $P$ im '
        """
        pairs = self.pgettext("prepositions before the name of a frame, and with an article", "in=in")
        articles = dict(re.findall(r"(\w+)=([\w ]+)", pairs))
        match = re.search(r"(\w+)\s+$", text)
        if match is None or match[1].lower() not in articles:
            return text
        return f"{text[: match.start() + 1]}{articles[match[1].lower()][1:]} "

    # --- numbers ---

    def localize_formulas(self, text: str) -> str:
        """Return Markdown with the language's decimal sign in its formulas; code and prose stay unchanged.

        In formulas with a decimal comma, commas between numbers become semicolons, because 0,5, 1 would be ambiguous.
        """
        return text if self._decimal_sign == "." else _FORMULA_OR_CODE.sub(self._localize_formula, text)

    def localize_number(self, number: str) -> str:
        """Return a number in a sentence with the decimal sign of the language.

        >>> load_catalogue("de").localize_number("−0.25 m/s")
        '−0,25 m/s'
        """
        return _DECIMAL_PATTERN.sub(rf"\1{self._decimal_sign}\2", number)

    @cached_property
    def _decimal_sign(self) -> str:
        return self.pgettext("decimal sign", ".")

    def _localize_formula(self, piece: re.Match[str]) -> str:
        formula = piece["formula"]
        if formula is None or not _DECIMAL_PATTERN.search(formula):
            return piece[0]
        return _DECIMAL_PATTERN.sub(rf"\1{{{self._decimal_sign}}}\2", re.sub(r"(?<!\\), (?!\\q)", "; ", formula))

    # --- messages with names in braces; a percent sign has no special meaning ---

    def _translate(self, context: str, message: str) -> str:
        return self.translations.pgettext(context, message)

    @cached_property
    def _phrase_translations(self) -> list[PhraseTranslation]:
        return [(make_phrase_pattern(english), self._translate(PHRASE, english)) for english in PHRASES]

    def _list_arm_translations(self, context: str) -> list[PhraseTranslation]:
        return [(make_phrase_pattern(name), self._translate(context, name)) for name in ARMS]


def _translate_by_first_match(
    phrase_translations: Iterable[PhraseTranslation], text: str, translate_word: Callable[[str], str] = str
) -> str:
    """Translate a text by the first phrase that matches the text, or return the text unchanged.

    `translate_word` is applied to the words that are copied to the translation.
    """
    for regex, translation in phrase_translations:
        match = regex.fullmatch(text)
        if match is not None:
            return translation.format(**{key: translate_word(word) for key, word in match.groupdict().items()})
    return text


_DECIMAL_PATTERN = re.compile(r"(\d)\.(\d)")
_FORMULA_OR_CODE = re.compile(r"`[^`]*`|(?P<formula>\$\$.*?\$\$|\$[^$]*\$)", re.DOTALL)


@cache
def make_phrase_pattern(phrase: str, allows_empty: bool = False) -> re.Pattern[str]:
    """Return a regular expression for a phrase with names in braces; a repeated name must match the same text.

    If `allows_empty`, a name may match an empty text.

    >>> make_phrase_pattern("row {n}").fullmatch("row 2")["n"]
    '2'
    """
    any_text = ".*?" if allows_empty else ".+?"
    pieces, seen_names = [], set()
    for i, piece in enumerate(re.split(r"\{(\w+)\}", phrase)):
        if i % 2 == 0:
            pieces.append(re.escape(piece))
        else:
            pieces.append(f"(?P={piece})" if piece in seen_names else f"(?P<{piece}>{any_text})")
            seen_names.add(piece)
    return re.compile("".join(pieces), re.DOTALL)
