"""The page that a student gets back: per part, what was right and what was not, where, and why.

It is made from a result as results.jsonl holds it, and from the student's problems: their figures, the units of their
symbols, and the worked solutions where the assignment says `feedback = "solutions"`.
"""

import hashlib
import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from qdot.exercises.arm.convention_view import is_by_axes
from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.lateness import describe_duration
from qdot.exercises.assignment.store import load_stored_problems
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.quizzes import ASKED
from qdot.exercises.writing.markup import to_html
from qdot.exercises.writing.render import render
from qdot.exercises.writing.statement import worked_solution
from qdot.grader.reports.answers import answer_of, visible
from qdot.grader.reports.differs import SUPERSCRIPT, table_of
from qdot.grader.reports.example import example_svg
from qdot.grader.reports.feedback_levels import at_least, told, without_numbers

PAGE = 7
"""Version of the page: any change of what it shows raises it, and every page is written anew."""

WORDS = {
    "correct": "right", "partial": "partly right", "wrong": "wrong", "missing": "not answered",
    "ungraded": "not graded yet",
}  # fmt: skip
MANY = 6
"""More parts than that are listed at the top."""

OURS = (
    r"the|these|this|its|it|not|nothing|no|entry|numbers?|an? \w+ is missing|a (list|configuration|singular)|say|left"
    r"|qdot failed|cells?|right but|claimed|commas"
)
"""Words with which the grader's reasons begin; whatever else begins one may be a name out of the notebook."""

IN_SHORT = {
    r"\bit is not right; differs$": "it is not right",
    r"(?<![\w)] )\bdiffers$": "its value differs from the solution's",
    r"\bclaimed, but no singular configuration\b": "a configuration is claimed that is not singular",
}
"""What is left of a reason whose numbers stand in a table, and how it is said there."""


def made_from(assignment: Assignment, student: Student, result: Mapping[str, Any]) -> str:
    """Return a short text that changes whenever the page does; the page holds it."""
    content = [PAGE, assignment.edition, assignment.feedback, student.name, result]
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def feedback_page(assignment: Assignment, student: Student, result: dict[str, Any]) -> str:
    """Return the student's page as self-contained HTML; nothing in it regenerates a problem."""
    problems = [] if result["obstacle"] is not None else _problems(assignment, student, result)
    parts = [part for problem in problems for part in problem["parts"]]
    return render(
        "feedback.html.j2",
        title=assignment.title,
        student=student,
        made_from=made_from(assignment, student, result),
        obstacle=None if result["obstacle"] is None else visible(result["obstacle"]),
        notes=[visible(note) for note in (*_settled(result), *result["notes"])],
        marked=_marked(result),
        percent=f"{100 * result['score'] / result['max_score']:.0f}",
        score=_points(result["score"]),
        max_score=_points(result["max_score"]),
        problems=problems,
        outcomes=[name for name in WORDS if any(part["outcome"] == name for part in parts)],
        overview=len(parts) > MANY,
        kept_back=_kept_back(assignment.feedback, parts),
    )


def _marked(result: Mapping[str, Any]) -> str:
    """Return of how much there is a mark: "nothing", "some" parts, or "all"."""
    points = [part["points"] for problem in result["problems"] for part in problem["parts"]]
    if None not in points or result["override"] is not None:
        return "all"
    return "some" if any(each is not None for each in points) else "nothing"


def _kept_back(level: str, parts: Sequence[Mapping[str, Any]]) -> str:
    """Return what the page does not tell of answers that are not right, for the student; empty where it tells all."""
    if at_least(level, "values") or not any(part["outcome"] in ("partial", "wrong") for part in parts):
        return ""
    if at_least(level, "counterexample"):
        return "Where an answer differs is shown with its own value there; what is right is not told."
    if at_least(level, "mistake"):
        return "Mistakes are named; where an answer differs, and what is right, is not told."
    return "What came of each part is told, and no more."


def _settled(result: Mapping[str, Any]) -> list[str]:
    """Return what decided the points beside the answers: lateness, a total that was set, parts that aren't shown."""
    said = []
    late = result["late"]
    if late is not None:
        said.append(f"Handed in {describe_duration(late['seconds'])} after it was due")
        if late["penalty"]:
            share = f"{100 * late['penalty']:.4g} %"
            said[-1] += f": {share} of the {_points(late['points_before'])} points are taken off"
    if result["override"] is not None:
        said.append(_set_by(result["override"], "Total"))
    if result["obstacle"] is not None:
        for problem in result["problems"]:
            parts = [part for part in problem["parts"] if part["override"] is not None]
            said += [_set_by(part["override"], f"{problem['slot']}.{part['name']}") for part in parts]
    return said


def _set_by(override: Mapping[str, Any], what: str) -> str:
    """Return what a person set (`what`: the points of a part, the total) or says, in words for the student."""
    if override["points"] is None:
        return f"Your instructor says: {override['comment']}"
    comment = f": {override['comment']}" if override["comment"] else ""
    return f"{what} set by your instructor to {_points(override['points'])}{comment}"


def _problems(assignment: Assignment, student: Student, result: dict[str, Any]) -> list[dict[str, Any]]:
    """Return every problem as the template shows it."""
    have = load_stored_problems(assignment, student.id)
    kept_problems = zip(have.problems, result["problems"], strict=True)
    made = []
    for number, ((name, problem), entry) in enumerate(kept_problems, 1):
        own = {part.name: part for part in problem.parts}
        numbers = {judged["name"]: f"{number}.{index}" for index, judged in enumerate(entry["parts"], 1)}
        parts = []
        for index, judged in enumerate(entry["parts"], 1):
            part = own[judged["name"]]
            solution = to_html(worked_solution(problem, part)) if assignment.feedback == "solutions" else None
            figure = have.part_figure(name, problem, part.name)
            said = {"number": numbers[part.name], "id": f"part-{number}-{index}"}
            said["asked"] = have.prompt(name, problem, part.name)
            shown = _part(problem, part, told(judged, assignment.feedback), numbers)
            parts.append({**said, **shown, "solution": solution, "figure": figure})
        title = f"Problem {number}: {problem.title}"
        drawn = {"figure": have.figure(name, problem), "given": _captioned(have.statement(name, problem), problem)}
        made.append({"id": f"problem-{number}", "title": title, **drawn, "parts": parts, **_sum(entry)})
    return made


def _captioned(given: str, problem: Problem) -> str:
    """Return what is given with a caption for its table, which a screen reader tells before it."""
    what = "Joint axes at home" if is_by_axes(problem.chain) else "Denavit–Hartenberg parameters"
    caption = f'<table><caption class="unseen">{what}</caption>'
    return re.sub(r"<th\b(?!ead)", '<th scope="col"', given.replace("<table>", caption))


def _sum(entry: Mapping[str, Any]) -> dict[str, str]:
    """Return the points of a problem."""
    points = sum(part["points"] or 0.0 for part in entry["parts"])
    return {"points": _points(points), "max_points": _points(sum(part["max_points"] for part in entry["parts"]))}


def _part(problem: Problem, part: Part, judged: Mapping[str, Any], numbers: Mapping[str, str]) -> dict[str, Any]:
    """Return what is said of a part; other parts are called by their numbers."""
    outcome, answer = judged["outcome"], judged["answer"]
    is_blank = outcome == "missing" and _is_blank(answer or "")
    table = table_of(problem, part, judged["certificate"]) if outcome in ("partial", "wrong") else None
    return {
        "title": ASKED[part.kind].title,
        "outcome": outcome,
        "word": WORDS[outcome],
        "points": "–" if judged["points"] is None else _points(judged["points"]),
        "max_points": _points(judged["max_points"]),
        "reason": _numbered(_sentence(_reason(judged, table is not None)), problem, numbers),
        "advice": _numbered(judged["advice"], problem, numbers) if judged["advice"] else None,
        "mistake": judged["mistake"],
        "override": None if judged["override"] is None else visible(_set_by(judged["override"], "Points")),
        "sure": _how_sure(judged["certificate"]) if outcome == "correct" else "",
        "answer": None if answer is None or is_blank else answer_of(problem, part, answer),
        "entries": _marks(judged) if outcome in ("partial", "wrong") and _several(judged["entries"]) else None,
        "followed_from": numbers.get(judged["followed_from"] or ""),
        "table": table,
        "example": example_svg(problem, part, judged) if table is not None else "",
    }


def _marks(judged: Mapping[str, Any]) -> list[list[str]]:
    """Return of each entry whether it is right, wrong, or follows from a wrong one before."""
    right = judged["entries"]
    follows = judged["follows"] or [[False] * len(row) for row in right]

    def mark(same: bool, does_follow: bool) -> str:
        return "right" if same else "follows" if does_follow else "wrong"

    return [list(map(mark, row, following)) for row, following in zip(right, follows, strict=True)]


def _numbered(said: str, problem: Problem, numbers: Mapping[str, str]) -> str:
    """Return a text in which parts of the problem are called by their numbers, as the page does."""
    for part in problem.parts:
        for called in (part.name, ASKED[part.kind].title):
            if part.name in numbers:
                said = re.sub(rf"(\bto|\bin) '{re.escape(called)}'", rf"\1 {numbers[part.name]}", said)
    return said


def _is_blank(answer: str) -> bool:
    """Tell whether nothing was answered; of a vector that was left blank in part, what is there is shown."""
    return not re.sub(r"blank|[\s\[\](),]", "", answer)


def _points(points: float) -> str:
    return f"{round(points, 2):g}"


def _reason(judged: Mapping[str, Any], is_short: bool) -> str:
    """Return why an answer is not right, without the numbers that stand in the table."""
    reason = str(judged["reason"])
    if is_short:
        reason = without_numbers(reason)
        for pattern, words in IN_SHORT.items():
            reason = re.sub(pattern, words, reason)
    return visible(reason)


def _how_sure(certificate: Mapping[str, Any] | None) -> str:
    """Return how a right answer was compared, and the chance that a wrong one would have passed."""
    if certificate is None or (certificate["points"] < 2 and not certificate["bound"]):
        return ""
    points, bound = certificate["points"], certificate["bound"]
    if not bound:
        return f"Compared at {points} configurations."
    power = str(-math.ceil(math.log10(bound))).translate(SUPERSCRIPT)
    chance = f"would have passed with a chance below 1 in 10{power}"
    if certificate["method"] == "exact":
        return f"Compared exactly: a wrong answer {chance}."
    share = 1 - bound ** (1 / points)
    return (
        f"Compared at {points} random configurations: an answer that is wrong at {share:.0%} of all of them {chance}."
    )


def _several(entries: list[list[bool]] | None) -> bool:
    return entries is not None and sum(map(len, entries)) > 1


def _sentence(reason: str) -> str:
    """Return a reason with a capital, if its first word is one of ours: `p1_jacobian` and `a2` are names."""
    return reason[:1].upper() + reason[1:] if re.match(rf"({OURS})\b", reason) else reason
