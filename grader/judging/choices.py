"""Letters of options, read and judged: one, several, one for each item; true or false."""

import re
import unicodedata
from collections.abc import Sequence
from fractions import Fraction

from qdot.exercises.answers import LETTERS, TRUE_FALSE
from qdot.exercises.formula.identity import Certificate
from qdot.grader.judging.answer import Given
from qdot.grader.judging.verdict import Judgement, correct, graded, missing, wrong

NOTHING = ("", "blank", "ellipsis", "none")
"""What is said where nothing was answered."""


# --- reading ---


LONGEST = 1000
"""Characters of an answer, without blanks in a row, of which the option is looked for."""


def read_choice(text: str, options: Sequence[str]) -> Given:
    """Read an option, by its letter (in any case, in brackets or quotes) or its own text."""
    if _said(text) in NOTHING:
        return Given(text, _blank())
    one = chosen_option(text, options)
    if one is None:
        named = options if tuple(options) == TRUE_FALSE else LETTERS[: len(options)]
        return Given(text).refused(f"{text[:40]!r} is none of the options {', '.join(named)}")
    return Given(text, chosen=(one,))


def read_selection(text: str, options: int) -> Given:
    """Read letters of options, as many as were chosen."""
    chosen = chosen_letters(text, options)
    if _said(text) in NOTHING:
        return Given(text, _blank())
    if chosen is None:
        letters = ", ".join(LETTERS[:options])
        return Given(text).refused(f'{text[:40]!r} is no choice of the letters {letters}, as in "AC"')
    return Given(text, chosen=tuple(chosen))


def read_matching(text: str, items: Sequence[str], options: int) -> Given:
    """Read a letter for each item, in their order."""
    if _said(text) in NOTHING:
        return Given(text, _blank())
    given = Given(text, chosen=tuple(chosen_letters(text, options) or ()))
    if len(given.chosen) == len(items):
        return given
    return given.refused(
        f"{text[:40]!r} does not hold {len(items)} of the letters {', '.join(LETTERS[:options])}, one for each "
        f"of {items[0]} to {items[-1]}"
    )


def _blank() -> Judgement:
    return missing("the answer was left blank")


def chosen_letters(student: str, options: int) -> list[int] | None:
    r"""Return the options that are meant by letters in a row or with commas between; None where it is something else.

    >>> chosen_letters("A, c", 4), chosen_letters("['B', 'A']", 4), chosen_letters("{1: 'B', 2: 'A'}", 4)
    ([0, 2], [1, 0], [1, 0])
    >>> chosen_letters("joint 1: B\njoint 2: A", 4), chosen_letters("joint 1 is B, joint 2 is A", 4)
    ([1, 0], [1, 0])
    >>> chosen_letters("AF", 4), chosen_letters("a1*cos(theta1)", 4)
    (None, None)
    """
    said = re.sub(r"\b(and|joints?)\b|\d+\s*(is\b|[:=.-]>?)|[\"'()\[\]{}.,;&+\s]", "", _plain(student))
    letters = LETTERS[:options].casefold()
    return [letters.index(letter) for letter in said] if said and set(said) <= set(letters) else None


def _plain(text: str) -> str:
    """Return a text in small letters, wide ones as plain ones, without marks that nobody sees.

    Of one that is longer than any option, no more is looked at than shows that it is none.
    """
    words = " ".join(text.split())
    shown = "".join(sign for sign in words[:LONGEST] if unicodedata.category(sign) != "Cf")
    shown += "\N{REPLACEMENT CHARACTER}" if len(words) > LONGEST else ""
    return unicodedata.normalize("NFKC", shown).casefold()


def _said(student: str) -> str:
    return _LABEL.sub("", _plain(student)).strip("\"'()[]{}.„“”‚‘’«» ")


_LABEL = re.compile(r"^(?:answer|option|antwort|lösung|solution)(?: is| ist| ?[:=])? ?(?=[\"'(\[]?[a-h](?![a-z]))")
"""What stands before a letter, as in "Answer: C"."""


def chosen_option(student: str, options: Sequence[str]) -> int | None:
    """Return the option that is meant by its letter or its own text; None where that is not clear."""
    said = _said(student)
    if tuple(options) == TRUE_FALSE and said in ("t", "f"):
        said = {"t": "true", "f": "false"}[said]
    whole = [index for index, option in enumerate(options) if said == _said(option)]
    if whole:
        return whole[0]
    letters = [letter.casefold() for letter in LETTERS[: len(options)]]
    lettered = re.match(r"([a-h])\s*[.):]", said)
    if lettered is not None:
        said = lettered.group(1)
    meant = [index for index, option in enumerate(options) if len(said) > 3 and said in option.casefold()]
    return letters.index(said) if said in letters else meant[0] if len(meant) == 1 else None


# --- judging ---


def judge_choice(given: Given, options: Sequence[str], right: int) -> Judgement:
    """Judge the choice of one option."""
    if given.refusal is not None:
        return given.refusal
    (chosen,) = given.chosen
    if chosen == right:
        return correct(Certificate("exact", 1, 0.0))
    named = options[chosen] if tuple(options) == TRUE_FALSE else LETTERS[chosen]
    return wrong(f"{named} is not the right option", Certificate("exact", 1, 0.0))


def judge_selection(given: Given, options: int, right: Sequence[int]) -> Judgement:
    """Judge a choice of letters: those that are right share the points, those that are wrong take them off in equal
    shares, none below zero.
    """
    if given.refusal is not None:
        return given.refusal
    hits, misses = len(set(given.chosen) & set(right)), len(set(given.chosen) - set(right))
    if hits == len(right) and not misses:
        return correct(Certificate("exact", 1, 0.0))
    share = Fraction(hits, len(right)) - Fraction(misses, max(options - len(right), 1))
    said = f"{hits} of the letters {'is' if hits == 1 else 'are'} right, {misses} {'is' if misses == 1 else 'are'} not"
    left = f"; {len(right) - hits} more should be there" if hits < len(right) else ""
    return graded(float(max(share, Fraction(0))), said + left, Certificate("exact", 1, 0.0))


def judge_matching(given: Given, items: Sequence[str], right: Sequence[int]) -> Judgement:
    """Judge a letter for each item, in their order, one by one; a letter that is given twice is no choice."""
    if given.refusal is not None:
        return given.refusal
    pairs = zip(items, given.chosen, right, strict=True)
    off = [item for item, mine, due in pairs if mine != due or given.chosen.count(mine) > 1]
    if not off:
        return correct(Certificate("exact", 1, 0.0))
    share = float(Fraction(len(items) - len(off), len(items)))
    return graded(share, f"not right for {', '.join(off)}", Certificate("exact", 1, 0.0))
