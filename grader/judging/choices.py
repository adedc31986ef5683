"""Parse and judge answers that choose options by letters: one option, several, one for each item, or true or false."""

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from qdot.exercises.answers import LETTERS, TRUE_FALSE
from qdot.exercises.formula.identity import Certificate
from qdot.grader.judging.answer import ParsedAnswer, refuse
from qdot.grader.judging.verdict import Judgement, correct, missing, partial, wrong

NOTHING = ("", "blank", "ellipsis", "none")
"""Texts that mean no answer."""


# --- reading ---


LONGEST = 1000
"""Maximum number of characters of an answer, with single spaces, that are searched for an option."""


def read_choice(text: str, options: Sequence[str]) -> ParsedAnswer:
    """Parse one option, given by its letter (upper or lower case, in brackets or quotes) or by its text."""
    chosen = chosen_option(text, options)
    names = options if tuple(options) == TRUE_FALSE else LETTERS[: len(options)]
    return _parse(text, None if chosen is None else [chosen], f"is none of the options {', '.join(names)}")


def read_selection(text: str, options: int) -> ParsedAnswer:
    """Parse the letters of any number of options."""
    letters = ", ".join(LETTERS[:options])
    return _parse(text, chosen_letters(text, options), f'is no choice of the letters {letters}, as in "AC"')


def read_matching(text: str, items: Sequence[str], options: int) -> ParsedAnswer:
    """Parse a letter for each item, in the order of the items."""
    chosen, letters = chosen_letters(text, options), ", ".join(LETTERS[:options])
    is_complete = chosen is not None and len(chosen) == len(items)
    expected = f"{len(items)} of the letters {letters}, one for each of {items[0]} to {items[-1]}"
    parsed = _parse(text, chosen if is_complete else None, f"does not hold {expected}")
    return parsed if parsed.refusal == _BLANK else replace(parsed, chosen=tuple(chosen or ()))


def _parse(text: str, chosen: Sequence[int] | None, problem: str) -> ParsedAnswer:
    """Return the chosen options as an answer; refuse a blank text, or a text without options with the given reason."""
    if _strip(text) in NOTHING:
        return ParsedAnswer(text, _BLANK)
    return refuse(text, f"{text[:40]!r} {problem}") if chosen is None else ParsedAnswer(text, chosen=tuple(chosen))


_BLANK = missing("the answer was left blank")


def chosen_letters(student: str, options: int) -> list[int] | None:
    r"""Return the indices of the options that letters name, with or without commas; None for any other text.

    >>> chosen_letters("A, c", 4), chosen_letters("['B', 'A']", 4), chosen_letters("{1: 'B', 2: 'A'}", 4)
    ([0, 2], [1, 0], [1, 0])
    >>> chosen_letters("joint 1: B\njoint 2: A", 4), chosen_letters("joint 1 is B, joint 2 is A", 4)
    ([1, 0], [1, 0])
    >>> chosen_letters("AF", 4), chosen_letters("a1*cos(theta1)", 4)
    (None, None)
    """
    typed = re.sub(r"\b(and|joints?)\b|\d+\s*(is\b|[:=.-]>?)|[\"'()\[\]{}.,;&+\s]", "", _plain(student))
    letters = LETTERS[:options].casefold()
    return [letters.index(letter) for letter in typed] if typed and set(typed) <= set(letters) else None


def _plain(text: str) -> str:
    """Return a text in lower case, with full-width letters replaced by ordinary ones and without invisible characters.

    A text longer than any option is truncated, and a special character at its end ensures that it matches no option.
    """
    words = " ".join(text.split())
    characters = "".join(sign for sign in words[:LONGEST] if unicodedata.category(sign) != "Cf")
    characters += "\N{REPLACEMENT CHARACTER}" if len(words) > LONGEST else ""
    return unicodedata.normalize("NFKC", characters).casefold()


def _strip(student: str) -> str:
    return _LABEL.sub("", _plain(student)).strip("\"'()[]{}.„“”‚‘’«» ")


_LABEL = re.compile(r"^(?:answer|option|antwort|lösung|solution)(?: is| ist| ?[:=])? ?(?=[\"'(\[]?[a-h](?![a-z]))")
"""Matches the words before a letter, as in "Answer: C"."""


def chosen_option(student: str, options: Sequence[str]) -> int | None:
    """Return the index of the option with this letter or text; None if there is no such option, or several."""
    plain = _strip(student)
    if tuple(options) == TRUE_FALSE:
        plain = {"t": "true", "f": "false"}.get(plain, plain)
    if exact_matches := [index for index, option in enumerate(options) if plain == _strip(option)]:
        return exact_matches[0]
    letter_match = re.match(r"([a-h])\s*[.):]", plain)
    plain = plain if letter_match is None else letter_match.group(1)
    letters = LETTERS[: len(options)].casefold()
    partial_matches = [index for index, option in enumerate(options) if len(plain) > 3 and plain in option.casefold()]
    if len(plain) == 1 and plain in letters:
        return letters.index(plain)
    return partial_matches[0] if len(partial_matches) == 1 else None


# --- judging ---


_CERTIFICATE = Certificate("exact", 1, 0.0)


def judge_choice(parsed: ParsedAnswer, options: Sequence[str], right: int) -> Judgement:
    """Judge the choice of one option."""
    if parsed.refusal is not None:
        return parsed.refusal
    (chosen,) = parsed.chosen
    if chosen == right:
        return correct(_CERTIFICATE)
    name = options[chosen] if tuple(options) == TRUE_FALSE else LETTERS[chosen]
    return wrong(f"{name} is not the right option", _CERTIFICATE)


def judge_selection(parsed: ParsedAnswer, options: int, right: Sequence[int]) -> Judgement:
    """Judge a choice of letters.

    Each correct letter earns an equal share of the points. Each wrong letter costs an equal share of them, but the
    result is never negative.
    """
    if parsed.refusal is not None:
        return parsed.refusal
    hits, misses = len(set(parsed.chosen) & set(right)), len(set(parsed.chosen) - set(right))
    if hits == len(right) and not misses:
        return correct(_CERTIFICATE)
    share = Fraction(hits, len(right)) - Fraction(misses, max(options - len(right), 1))
    verbs = ["is" if count == 1 else "are" for count in (hits, misses)]
    reason = f"{hits} of the letters {verbs[0]} right, {misses} {verbs[1]} not"
    missed_words = f"; {len(right) - hits} more should be there" if hits < len(right) else ""
    return partial(float(max(share, Fraction(0))), reason + missed_words, _CERTIFICATE)


def judge_matching(parsed: ParsedAnswer, items: Sequence[str], right: Sequence[int]) -> Judgement:
    """Judge the letter for each item; a letter that is given more than once counts as wrong."""
    if parsed.refusal is not None:
        return parsed.refusal
    pairs = zip(items, parsed.chosen, right, strict=True)
    wrong_items = [item for item, chosen, expected in pairs if chosen != expected or parsed.chosen.count(chosen) > 1]
    if not wrong_items:
        return correct(_CERTIFICATE)
    share = float(Fraction(len(items) - len(wrong_items), len(items)))
    return partial(share, f"not right for {', '.join(wrong_items)}", _CERTIFICATE)
