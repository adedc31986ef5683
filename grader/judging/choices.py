"""Parse and judge answers that choose options by letters: one option, several, one for each item, or true or false.

An answer that was refused when it was parsed must not be judged.
"""

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from qdot.exercises.common.errors import count_noun
from qdot.exercises.formula.equality import Certificate
from qdot.exercises.reference_answers import LETTERS, TRUE_FALSE
from qdot.grader.judging.answer_parser import BLANK_JUDGEMENT, ParsedAnswer, refuse
from qdot.grader.judging.verdict import Judgement, make_correct_judgement, make_partial_judgement, make_wrong_judgement

BLANK_TEXTS = ("", "blank", "ellipsis")
"""Texts that mean no answer, in lower case; "Ellipsis" is the text of Python's `...`."""
UNSET_VALUE = "None"
"""The text of a variable that was never set."""


# --- parsing ---


MAX_LENGTH = 1000
"""Maximum number of characters of an answer that are searched for an option."""
MIN_PARTIAL_LENGTH = 4
"""Minimum number of characters by which an option is recognised if only part of its text was typed."""


def is_blank_text(text: str) -> bool:
    """Return whether a text is no answer: empty, "blank", "Ellipsis", or "None", the text of an unset variable.

    The text "none" is an answer.

    >>> is_blank_text("None"), is_blank_text("( blank )"), is_blank_text("none")
    (True, True, False)
    """
    inner_text = text.strip("\"'()[]{}. \t\r\n")
    return inner_text == UNSET_VALUE or inner_text.casefold() in BLANK_TEXTS or not _strip_label(text)


def read_choice(text: str, options: Sequence[str]) -> ParsedAnswer:
    """Parse the choice of one option by its letter (in upper or lower case, brackets or quotes) or by its text."""
    option_index = find_option_index(text, options)
    names = options if tuple(options) == TRUE_FALSE else LETTERS[: len(options)]
    has_several_letters = len(parse_letters(text, len(options)) or ()) > 1
    complaint = "names several options; choose one of" if has_several_letters else "is not one of the options"
    option_indices = None if option_index is None else [option_index]
    return _make_parsed_answer(text, option_indices, f"{complaint} {', '.join(names)}")


def read_selection(text: str, option_count: int) -> ParsedAnswer:
    """Parse the letters of any number of options."""
    complaint = f'is not a choice of the letters {", ".join(LETTERS[:option_count])}, such as "AC"'
    return _make_parsed_answer(text, parse_letters(text, option_count), complaint)


def read_matching(text: str, items: Sequence[str], option_count: int) -> ParsedAnswer:
    """Parse a letter for each item, in the order of the items."""
    option_indices = parse_letters(text, option_count)
    letters = ", ".join(LETTERS[:option_count])
    is_complete = option_indices is not None and len(option_indices) == len(items)
    expected_form = f"{len(items)} letters ({letters}), one for each item from {items[0]} to {items[-1]}"
    parsed = _make_parsed_answer(text, option_indices if is_complete else None, f"must have exactly {expected_form}")
    # An incomplete answer is refused, but keeps its letters for the diagnosis.
    return parsed if parsed.refusal == BLANK_JUDGEMENT else replace(parsed, chosen_indices=tuple(option_indices or ()))


def _make_parsed_answer(text: str, option_indices: Sequence[int] | None, complaint: str) -> ParsedAnswer:
    """Return an answer with the indices of the chosen options, or a refused answer.

    The text is refused if it is blank, or if `option_indices` is None; the reason is the text and the `complaint`.
    """
    if is_blank_text(text):
        return ParsedAnswer(text, BLANK_JUDGEMENT)
    if option_indices is None:
        return refuse(text, f"{text[:40]!r} {complaint}")
    return ParsedAnswer(text, chosen_indices=tuple(option_indices))


def parse_letters(text: str, option_count: int) -> list[int] | None:
    r"""Return the indices of the options that letters name, with or without commas; None for any other text.

    >>> parse_letters("A, c", 4), parse_letters("['B', 'A']", 4), parse_letters("{1: 'B', 2: 'A'}", 4)
    ([0, 2], [1, 0], [1, 0])
    >>> parse_letters("joint 1: B\njoint 2: A", 4), parse_letters("joint 1 is B, joint 2 is A", 4)
    ([1, 0], [1, 0])
    >>> parse_letters("AF", 4), parse_letters("a1*cos(theta1)", 4)
    (None, None)
    """
    typed_letters = re.sub(r"\b(and|joints?)\b|\d+\s*(is\b|[:=.-]>?)|[\"'()\[\]{}.,;&+\s]", "", _normalize(text))
    letters = LETTERS[:option_count].casefold()
    is_valid = typed_letters and set(typed_letters) <= set(letters)
    return [letters.index(letter) for letter in typed_letters] if is_valid else None


def _normalize(text: str) -> str:
    """Return a text in lower case, with full-width letters replaced by ordinary ones and without invisible characters.

    A text longer than MAX_LENGTH is truncated, and a special character at its end ensures that it matches no option.
    """
    spaced_text = " ".join(text.split())
    characters = "".join(character for character in spaced_text[:MAX_LENGTH] if unicodedata.category(character) != "Cf")
    ending = "\N{REPLACEMENT CHARACTER}" if len(spaced_text) > MAX_LENGTH else ""
    return unicodedata.normalize("NFKC", characters + ending).casefold()


def _strip_label(text: str) -> str:
    """Return a normalized text without a word such as "Answer:" before a letter, and without quotes and brackets."""
    return _LABEL_BEFORE_LETTER.sub("", _normalize(text)).strip("\"'()[]{}.„“”‚‘’«» ")


_LABEL_BEFORE_LETTER = re.compile(
    r"^(?:answer|option|antwort|lösung|solution)(?: is| ist| ?[:=])? ?(?=[\"'(\[]?[a-h](?![a-z]))"
)
"""Matches the words before a letter, as in "Answer: C"."""


def find_option_index(text: str, options: Sequence[str]) -> int | None:
    """Return the index of the option with this letter or text; None if no option or more than one option matches."""
    typed_choice = _strip_label(text)
    if tuple(options) == TRUE_FALSE:
        typed_choice = {"t": "true", "f": "false"}.get(typed_choice, typed_choice)
    if exact_matches := [index for index, option in enumerate(options) if typed_choice == _strip_label(option)]:
        return exact_matches[0]
    letter_match = re.match(r"([a-h])\s*[.):]", typed_choice)  # a letter before the text of the option
    letter_or_text = typed_choice if letter_match is None else letter_match.group(1)
    letters = LETTERS[: len(options)].casefold()
    if len(letter_or_text) == 1 and letter_or_text in letters:
        return letters.index(letter_or_text)
    partial_matches = [index for index, option in enumerate(options) if letter_or_text in option.casefold()]
    return partial_matches[0] if len(letter_or_text) >= MIN_PARTIAL_LENGTH and len(partial_matches) == 1 else None


# --- judging ---


_CERTIFICATE = Certificate("exact", points=1, bound=0.0)
"""The certificate of every comparison of letters; these comparisons are exact."""


def judge_choice(parsed: ParsedAnswer, options: Sequence[str], correct_index: int) -> Judgement:
    """Judge the choice of one option."""
    (option_index,) = parsed.chosen_indices
    if option_index == correct_index:
        return make_correct_judgement(_CERTIFICATE)
    name = options[option_index] if tuple(options) == TRUE_FALSE else LETTERS[option_index]
    return make_wrong_judgement(f"{name} is not the correct option", _CERTIFICATE)


def judge_selection(parsed: ParsedAnswer, option_count: int, correct_indices: Sequence[int]) -> Judgement:
    """Judge a choice of letters.

    With r correct and w wrong options, a correct letter earns 1/r of the points and a wrong letter costs 1/w. The
    result is never negative.
    """
    right_count = len(set(parsed.chosen_indices) & set(correct_indices))
    wrong_count = len(set(parsed.chosen_indices) - set(correct_indices))
    missing_count = len(correct_indices) - right_count
    if not missing_count and not wrong_count:
        return make_correct_judgement(_CERTIFICATE)
    wrong_option_count = max(option_count - len(correct_indices), 1)
    share = Fraction(right_count, len(correct_indices)) - Fraction(wrong_count, wrong_option_count)
    counts = {"right": right_count, "wrong": wrong_count, "missing": missing_count}
    verbs = {word: "is" if count == 1 else "are" for word, count in counts.items()}
    clauses = [f"{count_noun(count, 'letter')} {verbs[word]} {word}" for word, count in counts.items() if count]
    return make_partial_judgement(float(max(share, Fraction(0))), ", ".join(clauses), _CERTIFICATE)


def judge_matching(parsed: ParsedAnswer, items: Sequence[str], correct_indices: Sequence[int]) -> Judgement:
    """Judge the letter for each item; a letter that is given more than once counts as wrong."""
    indices = parsed.chosen_indices
    triples = zip(items, indices, correct_indices, strict=True)
    wrong_items = [item for item, index, expected in triples if index != expected or indices.count(index) > 1]
    if not wrong_items:
        return make_correct_judgement(_CERTIFICATE)
    share = float(Fraction(len(items) - len(wrong_items), len(items)))
    return make_partial_judgement(share, f"wrong for {', '.join(wrong_items)}", _CERTIFICATE)
