"""Write instructions for marking on paper: the right answer, points for known mistakes, a rule for all other answers.

The grader computes the points for an answer, so paper and notebooks are marked alike.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

from qdot.exercises import reference_answers
from qdot.exercises.exports.export_format import ShareOfTypedAnswer
from qdot.exercises.exports.known_wrong_answers import find_known_wrong_answers
from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.problem.credit import INCOMPLETE_CONDITION_FACTOR, MISTAKE_FACTOR, SIGN_OR_FACTOR_COST
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.results import is_product
from qdot.exercises.reference_answers import LETTERS
from qdot.exercises.short_questions.options import list_blames
from qdot.exercises.writing.line_breaking import estimate_width, fit_formula
from qdot.exercises.writing.short_answer import write_short_answer

MAX_MISTAKES = 4
"""Maximum number of known mistakes that a sheet lists for a part."""
MAX_CHARACTERS = 400
"""Maximum length of a wrong answer in characters; for a longer one, only the mistake is named."""
TOO_LONG = "too long to show"
NO_CREDIT = "0 points."
FORMULA_WIDTH, MAX_WIDTH_RATIO = 22.0, 1.25
"""Maximum width of a formula on a sheet, in em; a formula up to this many times as wide is shrunk to fit."""


@dataclass(frozen=True)
class MarkingLine:
    """A line of a marking sheet: "Right" or a mistake, the answer in Markdown ("" if not shown), and its points."""

    title: str
    answer: str
    points: str


@dataclass(frozen=True)
class MarkingInstructions:
    """The lines for a part, beginning with the correct answer, and the rule for all other answers."""

    lines: tuple[MarkingLine, ...]
    rule: str


def explain_marking(problem: Problem, part: Part, compute_earned_share: ShareOfTypedAnswer) -> MarkingInstructions:
    """Return the instructions for a part; `compute_earned_share` returns the share of the points for a typed answer."""
    correct_answer = _keep_if_legible(write_short_answer(problem, part)) or "see the key"
    correct_line = MarkingLine("Right", correct_answer, _format_points(part, Fraction(1)))
    legend = correct_answer[: max(0, correct_answer.find("$$"))]  # what s1, c12 … mean; other lines do not repeat it
    wrong_lines = _make_mistake_lines(problem, part, compute_earned_share)
    if part.answer.offered_options:
        wrong_lines = _make_option_lines(part)
    other_lines = (replace(line, answer=line.answer.removeprefix(legend)) for line in wrong_lines)
    return MarkingInstructions((correct_line, *other_lines), _state_rule(problem, part))


def _keep_if_legible(answer: str) -> str:
    """Return an answer in Markdown, or "" if its formulas would be too small to read on the sheet."""
    formulas = (parse_latex(latex) for latex in re.findall(r"\$\$(.*?)\$\$", answer, re.DOTALL))
    widths = (estimate_width(fit_formula(formula, FORMULA_WIDTH)) for formula in formulas)
    return answer if all(width <= MAX_WIDTH_RATIO * FORMULA_WIDTH for width in widths) else ""


def _format_points(part: Part, share: Fraction) -> str:
    return f"{float(share) * part.points:.3g}"


def _make_option_lines(part: Part) -> Iterator[MarkingLine]:
    """Yield a line for each wrong option that a known mistake leads to, if exactly one option is correct."""
    if isinstance(part.answer, reference_answers.Choice):
        for index in range(len(part.answer.options)):
            mistakes = dict.fromkeys(blame.title for blame in list_blames(part, index))
            if mistakes and index != part.answer.correct:
                yield MarkingLine(f"{LETTERS[index]}: {', and '.join(mistakes)}", "", _format_points(part, Fraction(0)))


def _make_mistake_lines(
    problem: Problem, part: Part, compute_earned_share: ShareOfTypedAnswer
) -> Iterator[MarkingLine]:
    """Yield a line for each answer that a known mistake leads to."""
    for known_answer in find_known_wrong_answers(problem, part, MAX_MISTAKES):
        wrong_part = replace(part, answer=known_answer.make_answer(part.answer))
        typed_answer = wrong_part.answer.as_typed()
        is_short = len(typed_answer) <= MAX_CHARACTERS
        shown_answer = _keep_if_legible(write_short_answer(problem, wrong_part)) if is_short else ""
        points = _format_points(part, compute_earned_share(problem, part, typed_answer))
        yield MarkingLine(known_answer.title, shown_answer or TOO_LONG, points)


def _state_rule(problem: Problem, part: Part) -> str:
    """Return the rule for partial credit of all other answers; docs/partial-credit.md explains the rules."""
    answer, credit = part.answer, part.credit
    if isinstance(answer, reference_answers.Words):
        return f"the marker's decision, from 0 to {_format_points(part, Fraction(1))} points."
    if credit.rule == "whole" or not credit.factor:
        return NO_CREDIT
    match answer:
        case reference_answers.ConditionSet():
            return (
                "Each missing condition and each wrong condition halves the points (several wrong "
                "values of a joint count as one). A condition with some values missing: "
                f"{_format_partial_points(part, INCOMPLETE_CONDITION_FACTOR)}. No points if more conditions are "
                "wrong than right."
            )
        case reference_answers.Selection():
            wrong_count = len(answer.options) - len(answer.correct)
            rule = f"Each right letter: {_format_partial_points(part, Fraction(1, len(answer.correct)))}"
            if wrong_count:
                rule += f"; each wrong letter deducts {_format_partial_points(part, Fraction(1, wrong_count))}"
            return f"{rule}."
        case reference_answers.Matching():
            letter_points = _format_partial_points(part, Fraction(1, len(answer.items)))
            return f"Each right letter: {letter_points}. A letter that is used twice does not count."
        case reference_answers.Expression() | reference_answers.Matrix() | reference_answers.Number():
            return " ".join(_list_rules_for_entries(problem, part)) or NO_CREDIT
    return NO_CREDIT


def _format_partial_points(part: Part, share: Fraction) -> str:
    return _format_points(part, share * part.credit.factor)


def _list_rules_for_entries(problem: Problem, part: Part) -> Iterator[str]:
    """Yield the rules for a formula, a matrix or numbers; no rule for a single constant, which is right or wrong."""
    entries, credit = part.answer.as_matrix(), part.credit
    counted_entries = [entry for entry in entries if entry != 0] or list(entries)
    is_varying = [bool({symbol.name for symbol in entry.free_symbols} - problem.constants) for entry in counted_entries]
    has_varying_entries, is_single = any(is_varying), part.answer.is_one_line
    if is_single and not has_varying_entries:
        return
    if credit.rule == "columns" and entries.cols > 1:
        count = sum(any(entries.col(k)) for k in range(entries.cols))
        yield f"Each right column: {_format_partial_points(part, Fraction(1, count))}."
    elif not is_single:
        nonzero_word = "nonzero " if 0 in entries else ""
        points = _format_partial_points(part, Fraction(1, len(counted_entries)))
        yield f"Each of the {len(counted_entries)} {nonzero_word}entries: {points}."
        if nonzero_word:
            yield "Each entry that should be zero but is not deducts as many points."
    if has_varying_entries and not all(is_varying):
        yield "No points if only constant entries are right."
    sign_words = "the sign is" if is_single else "signs are"
    points = _format_partial_points(part, 1 - SIGN_OR_FACTOR_COST)
    if has_varying_entries:
        points_for_both = _format_partial_points(part, 1 - 2 * SIGN_OR_FACTOR_COST)
        yield f"If only {sign_words} wrong, or only a constant factor: {points}; both: {points_for_both}."
    else:
        yield f"If only {sign_words} wrong: {points}."
    if credit.covers_known_mistakes and (has_varying_entries or part.answer.expected_units):
        yield f"If one other mistake explains everything that is wrong: {_format_partial_points(part, MISTAKE_FACTOR)}."
    if is_product(part) and credit.rule in ("", "factors"):
        yield "Each missing, wrong or extra factor with joint variables halves the points; at most two are allowed."
        yield "No points if more factors are wrong than right."
