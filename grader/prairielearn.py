"""What the server.py of an exported PrairieLearn question calls: make a variant, read what was typed, grade it.

`data` is PrairieLearn's dictionary, JSON all through. Solutions are among `correct_answers` only, which no panel but
the answer's shows. Answers are text until the grammar of formulas reads them; nothing of them is ever executed.
"""

import json
from pathlib import Path
from typing import Any

from exercises.assignment import Slot, load_assignment
from exercises.errors import QdotError
from exercises.exports.prairielearn import BANK_FILE
from exercises.figure import figure_svg, part_svg
from exercises.notebook import points_text, solution_figure
from exercises.problem import ENGINE, Part, Problem
from exercises.quizzes import ASKED
from exercises.writing.markup import to_html_for_mathjax
from exercises.writing.statement import hints, prompt, statement, worked_solution
from grader.levels import at_least
from grader.marking import mark
from grader.reading import read_answer
from grader.verdict import Outcome, Verdict

Data = dict[str, Any]

LONGEST = 20_000
"""Characters of an answer; the longest reference has a tenth of that."""


def generate(data: Data, folder: str, slot: str) -> None:
    """Put a variant into `params`, and its worked solutions into `correct_answers`."""
    place, assignment_hints = _place(data, folder, slot)
    seeds = json.loads((_folder(data, folder) / BANK_FILE).read_text(encoding="utf-8"))["seeds"][slot]
    seed = seeds[int(data["variant_seed"]) % len(seeds)]
    problem = place.problem_with(int(seed))
    data["params"].update(
        seed=seed,
        engine=ENGINE,
        statement=to_html_for_mathjax(statement(problem, "")),
        figure=figure_svg(problem.chain, f"{folder}-{slot}".replace("/", "-")),
        parts=[_shown(problem, part, assignment_hints) for part in problem.parts],
    )
    data["correct_answers"]["parts"] = [_solved(problem, part) for part in problem.parts]


def parse(data: Data, folder: str, slot: str) -> None:
    """Say of each answer that can't be read why; the submission is then not graded, and costs no attempt."""
    problem = _problem(data, folder, slot)
    typed = {part.name: _typed(data, part) for part in problem.parts}
    for part in problem.parts:
        error = _unreadable(problem, part, typed[part.name])
        if error:
            data["format_errors"][part.name] = error
    if not any(typed.values()):
        data["format_errors"][problem.parts[0].name] = "no part is answered"


def grade(data: Data, folder: str, slot: str) -> None:
    """Mark every part as `qdot grade` does: share of the points, what follows from earlier answers, the mistake.

    What fails in qdot itself makes the submission invalid, so that it costs nothing.
    """
    problem = _problem(data, folder, slot)
    answers = {part.name: typed for part in problem.parts if (typed := _typed(data, part))}
    assignment = load_assignment(_folder(data, folder))
    verdicts = mark(
        problem, answers, secret=assignment.secret, credit=assignment.follow_through, oftener=assignment.oftener
    )
    said = []
    for part, verdict in zip(problem.parts, verdicts, strict=True):
        if verdict.points is None:
            data["format_errors"][part.name] = verdict.judgement.reason
            continue
        data["partial_scores"][part.name] = {"score": verdict.points / part.points, "weight": part.points}
        is_told = at_least(assignment.feedback, "mistake")
        advice = verdict.diagnosis.says if is_told and verdict.diagnosis is not None else ""
        words = _said(verdict) if is_told else _OUTCOMES[verdict.judgement.outcome]
        said.append({"title": ASKED[part.kind].title, "said": words, "advice": advice})
    earned = sum(verdict.points or 0.0 for verdict in verdicts)
    data["score"] = min(1.0, earned / problem.max_points)
    data["feedback"]["parts"] = said


# --- a variant ---


def _folder(data: Data, folder: str) -> Path:
    return Path(data["options"]["server_files_course_path"]) / folder


def _place(data: Data, folder: str, slot: str) -> tuple[Slot, bool]:
    assignment = load_assignment(_folder(data, folder))
    return next(place for place in assignment.slots if place.name == slot), assignment.hints


def _problem(data: Data, folder: str, slot: str) -> Problem:
    """Return the problem of a variant. Raises QdotError where another engine made it."""
    if data["params"]["engine"] != ENGINE:
        raise QdotError(
            f"this variant was made by engine {data['params']['engine']} of qdot, and engine {ENGINE} is installed"
        )
    return _place(data, folder, slot)[0].problem_with(int(data["params"]["seed"]))


def _shown(problem: Problem, part: Part, hinted: bool) -> Data:
    given = hints(problem, part) if hinted else ()
    return {
        "name": part.name,
        "title": ASKED[part.kind].title,
        "points": points_text(part.points),
        "prompt": to_html_for_mathjax(prompt(problem, part)),
        "figure": part_svg(problem.chain, part, part.name),
        "hints": [{"name": f"Hint {i}", "text": to_html_for_mathjax(hint)} for i, hint in enumerate(given, 1)],
        "multiline": "false" if part.answer.is_one_line else "true",
        "placeholder": _placeholder(part),
        "weight": max(1, round(part.points)),
    }


def _placeholder(part: Part) -> str:
    """Return the form of an answer, for the box it is typed into."""
    if part.answer.typed_as:
        return part.answer.typed_as
    shape = part.answer.placeholder().removeprefix("Matrix(").removesuffix(")")
    return "" if shape == "blank" else " ".join(shape.split()).replace("blank", "…")


def _solved(problem: Problem, part: Part) -> Data:
    return {
        "title": ASKED[part.kind].title,
        "solution": to_html_for_mathjax(worked_solution(problem, part)),
        "figure": solution_figure(problem, part, f"{part.name}-solution"),
    }


# --- answers ---


def _typed(data: Data, part: Part) -> str:
    """Return what was typed, "" where that is nothing."""
    typed = data["submitted_answers"].get(part.name)
    return typed.strip() if isinstance(typed, str) else ""


def _unreadable(problem: Problem, part: Part, typed: str) -> str:
    """Return why an answer can't be read, "" where it can be, or is left blank."""
    if len(typed) > LONGEST:
        return f"an answer has at most {LONGEST} characters, and this has {len(typed)}"
    if not typed:
        return ""
    refusal = read_answer(problem, part, typed).refusal
    return "" if refusal is None or refusal.outcome is Outcome.MISSING else refusal.reason


def _said(verdict: Verdict) -> str:
    """Return what is said of an answer, which gives nothing away: a variant may be tried again."""
    outcome, entries = verdict.judgement.outcome, verdict.judgement.entries
    words = _OUTCOMES[outcome]
    if verdict.followed_from is not None:
        return f"it follows from your answer to {verdict.followed_from!r}, which is not right."
    if outcome in (Outcome.WRONG, Outcome.PARTIAL) and entries is not None and sum(map(len, entries)) > 1:
        off = [f"({i}, {j})" for i, row in enumerate(entries, 1) for j, same in enumerate(row, 1) if not same]
        return f"{words} Not right: {', '.join(off)}."
    return words


_OUTCOMES = {
    Outcome.CORRECT: "right.",
    Outcome.PARTIAL: "right in part.",
    Outcome.WRONG: "not right.",
    Outcome.MISSING: "left blank.",
    Outcome.UNGRADED: "not graded.",
}
