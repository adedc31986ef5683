"""Serve an exported PrairieLearn question: generate a variant, parse the answers, and grade them.

The server.py of the question calls this module with `data`, PrairieLearn's dictionary, whose values are all JSON.
`correct_answers`, which only the answer panel shows, has the solutions and the correct options. PrairieLearn's elements
(its input fields) store the chosen or typed answers. This module converts each answer to the text that a student would
type in a notebook, then parses and marks the text as usual. No answer is executed.
"""

import json
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import Assignment, Slot, load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports.items import list_entry_labels, write_question_alone
from qdot.exercises.exports.platform_markup import write_line_html
from qdot.exercises.exports.prairielearn import BANK_FILE, list_input_names
from qdot.exercises.figure.arm_figure import draw_figure_svg, draw_part_svg
from qdot.exercises.mistakes.base import add_chapter_to_citation
from qdot.exercises.notebook.notebook import draw_singular_configurations
from qdot.exercises.problem.problem import ENGINE, Part, Problem
from qdot.exercises.reference_answers import LETTERS, TRUE_FALSE
from qdot.exercises.short_questions import question_of
from qdot.exercises.writing.markup import to_html_for_mathjax
from qdot.exercises.writing.problem_texts import (
    write_hints,
    write_option,
    write_prompt,
    write_solution,
    write_statement,
)
from qdot.exercises.writing.units import format_unit
from qdot.grader.judging.expected_form import read_answer
from qdot.grader.judging.verdict import Outcome, Verdict
from qdot.grader.marking.marking import MarkingRules, mark
from qdot.grader.reports.feedback_levels import shows_at_least

PrairieLearnData = dict[str, Any]
"""PrairieLearn's dictionary, or a part of it."""

MAX_ANSWER_LENGTH = 20_000
"""Maximum number of characters of an answer; the longest reference answer is a tenth as long."""


def generate(data: PrairieLearnData, folder: str, slot: str) -> None:
    """Store a variant of the problem `slot` in `params`, and its worked solutions in `correct_answers`.

    `folder` is the folder of the assignment among the server's course files.
    """
    assignment = _load_assignment(data, folder)
    seeds = json.loads((_find_assignment_folder(data, folder) / BANK_FILE).read_text(encoding="utf-8"))["seeds"][slot]
    seed = seeds[int(data["variant_seed"]) % len(seeds)]
    problem = _find_slot(assignment, slot).generate_from_seed(int(seed))
    figure = draw_figure_svg(problem.chain, f"{folder}-{slot}".replace("/", "-"))
    shown_parts = {part.name: _make_part_data(problem, part, assignment.hints) for part in problem.parts}
    statement = to_html_for_mathjax(write_statement(problem, ""))
    data["params"].update(seed=seed, engine=ENGINE, statement=statement, figure=figure, shown=shown_parts)
    choice_parts = [part for part in problem.parts if part.answer.offered_options]
    options = {part.name: _list_options(problem, part) for part in choice_parts}
    solutions = {part.name: _make_solution_data(problem, part) for part in problem.parts}
    data["correct_answers"].update(options=options, solutions=solutions)


def parse(data: PrairieLearnData, folder: str, slot: str) -> None:
    """Add the reasons why answers can't be parsed to `format_errors`, beside the errors from PrairieLearn's elements.

    A submission with such errors is not graded, and costs no attempt.
    """
    problem = _load_problem(data, folder, slot)
    errors = data["format_errors"]
    is_blank = not errors
    for part in problem.parts:
        names = list_input_names(part)
        if not {part.name, *names} & set(errors):
            text = _read_typed_answer(data, part)
            is_blank = is_blank and not text
            if error := _describe_missing_inputs(data, part) or _explain_unreadable(problem, part, text):
                errors[names[0]] = error
    if is_blank:
        errors[list_input_names(problem.parts[0])[0]] = "You have not answered any part."


def grade(data: PrairieLearnData, folder: str, slot: str) -> None:
    """Mark every part as `qdot grade` does, with partial credit, follow-through and the diagnosed mistake.

    If qdot itself fails, the submission is invalid and costs no attempt.
    """
    problem = _load_problem(data, folder, slot)
    assignment = _load_assignment(data, folder)
    texts = {part.name: _read_typed_answer(data, part) for part in problem.parts}
    answers = {name: text for name, text in texts.items() if text}
    verdicts = mark(problem, answers, secret=assignment.secret, rules=MarkingRules(assignment.follow_through))
    shows_mistakes = shows_at_least(assignment.feedback, "mistake")
    data["feedback"] = {}
    for part, verdict in zip(problem.parts, verdicts, strict=True):
        if verdict.points is None:
            data["format_errors"][list_input_names(part)[0]] = verdict.judgement.reason
            continue
        data["partial_scores"].update(_compute_scores(part, verdict, shows_mistakes))
        sentence, advice = _OUTCOME_SENTENCES[verdict.judgement.outcome], ""
        if shows_mistakes:
            sentence = _describe_outcome(problem, verdict)
            advice = "" if verdict.diagnosis is None else add_chapter_to_citation(verdict.diagnosis.feedback)
        data["feedback"][part.name] = {"said": sentence, "advice": advice}
    earned = sum(verdict.points or 0.0 for verdict in verdicts)
    data["score"] = min(1.0, earned / problem.max_points)


def _compute_scores(part: Part, verdict: Verdict, shows_entries: bool) -> PrairieLearnData:
    """Return the score of a part; if `shows_entries`, also a score of 0 or 1 for each number of a numeric answer."""
    assert verdict.points is not None
    scores: PrairieLearnData = {part.name: {"score": verdict.points / part.points, "weight": part.points}}
    names, entries = list_input_names(part), verdict.judgement.entries
    if shows_entries and part.answer.is_numeric and len(names) > 1 and entries is not None:
        flags = [is_correct for row in entries for is_correct in row]
        scores |= {name: {"score": int(flag), "weight": 0} for name, flag in zip(names, flags, strict=True)}
    return scores


# --- a variant ---


def _find_assignment_folder(data: PrairieLearnData, folder: str) -> Path:
    return Path(data["options"]["server_files_course_path"]) / folder


def _load_assignment(data: PrairieLearnData, folder: str) -> Assignment:
    assignment, _ = load_assignment(_find_assignment_folder(data, folder)).without_text_questions()
    return assignment


def _find_slot(assignment: Assignment, name: str) -> Slot:
    return next(slot for slot in assignment.slots if slot.name == name)


def _load_problem(data: PrairieLearnData, folder: str, slot: str) -> Problem:
    """Return the problem of a variant. Raises QdotError if another engine generated it."""
    if data["params"]["engine"] != ENGINE:
        engine = data["params"]["engine"]
        raise QdotError(f"engine {engine} of qdot generated this variant, but engine {ENGINE} is installed")
    return _find_slot(_load_assignment(data, folder), slot).generate_from_seed(int(data["params"]["seed"]))


def _make_part_data(problem: Problem, part: Part, has_hints: bool) -> PrairieLearnData:
    """Return what the question's template shows of a part."""
    shown_hints = write_hints(problem, part) if has_hints else ()
    question = write_question_alone(problem, part) if part.answer.offered_options else write_prompt(problem, part)
    return {
        "prompt": to_html_for_mathjax(question),
        "figure": draw_part_svg(problem.chain, part, part.name),
        "hints": [{"name": f"Hint {i}", "text": to_html_for_mathjax(hint)} for i, hint in enumerate(shown_hints, 1)],
        "fields": _list_input_fields(problem, part),
        "multiline": "false" if part.answer.is_one_line else "true",
        "placeholder": _make_placeholder(part),
    }


def _list_input_fields(problem: Problem, part: Part) -> list[PrairieLearnData]:
    """Return the input fields for numbers, each with its symbol and its unit."""
    units = part.answer.expected_units
    if part.shape is None or not units:
        return []
    labels = list_entry_labels(problem, part, part.shape)
    inputs = zip(list_input_names(part), labels, units, strict=True)
    return [{"name": name, "label": f"${label} =$", "unit": format_unit(unit)} for name, label, unit in inputs]


def _list_options(problem: Problem, part: Part) -> Any:
    """Return the options of a part for PrairieLearn's elements, in qdot's order, with the letters of worked solutions.

    For a matching question, return the items, too.
    """
    answer = part.answer
    texts = [write_line_html(write_option(problem, part, k)) for k in range(len(answer.offered_options))]
    if answer.matched_items:
        pairs = zip(answer.matched_items, answer.correct_indices, strict=True)
        offered_options = [{"letter": LETTERS[k], "html": text} for k, text in enumerate(texts)]
        return {"items": [{"html": item, "letter": LETTERS[k]} for item, k in pairs], "offered": offered_options}
    if answer.offered_options != TRUE_FALSE:
        texts = [f"<strong>{LETTERS[k]}.</strong> {text}" for k, text in enumerate(texts)]
    flags = ["true" if k in answer.correct_indices else "false" for k in range(len(texts))]
    return [{"right": flag, "html": text} for flag, text in zip(flags, texts, strict=True)]


def _make_placeholder(part: Part) -> str:
    """Return the text that an empty input field shows: the form of the answer, such as [[…, …]]."""
    if part.answer.typed_form:
        return part.answer.typed_form
    shape = part.answer.write_placeholder().removeprefix("Matrix(").removesuffix(")")
    return "" if shape == "blank" else " ".join(shape.split()).replace("blank", "…")


def _make_solution_data(problem: Problem, part: Part) -> PrairieLearnData:
    figure = draw_singular_configurations(problem, part, f"{part.name}-solution")
    return {"solution": to_html_for_mathjax(write_solution(problem, part)), "figure": figure}


# --- answers ---


def _read_typed_answer(data: PrairieLearnData, part: Part) -> str:
    """Return the chosen or typed answer as the text for a notebook; "" if there is no answer."""
    if part.answer.offered_options and not part.answer.matched_items:
        # PrairieLearn has its own keys for the options, in the same order.
        keys = [option["key"] for option in data["params"].get(part.name, ())]
        ticked_keys = data["submitted_answers"].get(part.name) or ()
        letters = "".join(LETTERS[keys.index(key)] for key in ticked_keys if key in keys)
        is_true_or_false = part.answer.offered_options == TRUE_FALSE and len(letters) == 1
        return TRUE_FALSE[LETTERS.index(letters)] if is_true_or_false else letters
    texts = _list_typed_texts(data, part)
    if part.answer.matched_items:
        return "".join(LETTERS[int(text)] for text in texts if text in _MATCHING_OPTION_NAMES)
    return f"[{', '.join(texts)}]" if len(texts) > 1 and any(texts) else texts[0]


_MATCHING_OPTION_NAMES = [str(number) for number in range(len(LETTERS))]
"""The names of options in the element for matching."""


def _list_typed_texts(data: PrairieLearnData, part: Part) -> list[str]:
    """Return the text in each input of a part, as it was typed and before the elements parsed numbers."""
    is_numeric = part.answer.is_numeric and part.answer.expected_units
    source = data["raw_submitted_answers"] if is_numeric else data["submitted_answers"]
    texts = (source.get(name) for name in list_input_names(part))
    return [str(text).strip() if isinstance(text, str | int) else "" for text in texts]


def _describe_missing_inputs(data: PrairieLearnData, part: Part) -> str:
    """Return a message on the missing numbers or matches of an incomplete part; "" if it is complete or blank."""
    texts = _list_typed_texts(data, part)
    items = part.answer.matched_items
    are_filled = [text in _MATCHING_OPTION_NAMES if items else bool(text) for text in texts]
    if all(are_filled) or not any(are_filled):
        return ""
    names = items or [f"number {number}" for number in range(1, len(texts) + 1)]
    missing_names = ", ".join(name for name, filled in zip(names, are_filled, strict=True) if not filled)
    return f"You have not chosen an option for {missing_names}." if items else f"You have not answered {missing_names}."


def _explain_unreadable(problem: Problem, part: Part, answer_text: str) -> str:
    """Return why an answer can't be parsed; "" if it can be parsed or is blank."""
    if len(answer_text) > MAX_ANSWER_LENGTH:
        return f"Your answer has {len(answer_text)} characters; at most {MAX_ANSWER_LENGTH} are allowed."
    if not answer_text:
        return ""
    refusal = read_answer(problem, part, answer_text).refusal
    return "" if refusal is None or refusal.outcome is Outcome.MISSING else refusal.reason


def _describe_outcome(problem: Problem, verdict: Verdict) -> str:
    """Return the feedback on an answer, without correct values, because students may try a variant again."""
    outcome, entries = verdict.judgement.outcome, verdict.judgement.entries
    sentence = _OUTCOME_SENTENCES[outcome]
    if verdict.followed_from is not None:
        earlier_title = question_of(problem[verdict.followed_from]).title
        return f"This follows from your answer to “{earlier_title}”, which is not right."
    if outcome in (Outcome.WRONG, Outcome.PARTIAL) and entries is not None and sum(map(len, entries)) > 1:
        flags = {(i, j): is_correct for i, row in enumerate(entries, 1) for j, is_correct in enumerate(row, 1)}
        wrong_entries = ", ".join(str(position) for position, is_correct in flags.items() if not is_correct)
        return f"{sentence} Wrong entries: {wrong_entries}."
    return sentence


_SENTENCES = ("Right.", "Partly right.", "Not right.", "Not answered.", "Not graded.")
_OUTCOME_SENTENCES = dict(zip(Outcome, _SENTENCES, strict=True))
