"""The page that a student gets back: per part, what was right and what was not, and why."""

import math
import re
from typing import Any

from exercises.assignment import Assignment, Student
from exercises.questions import QUESTIONS
from exercises.render import render
from exercises.writing.markup import to_html
from exercises.writing.statement import worked_solution

WORDS = {
    "correct": "right", "partial": "partly right", "wrong": "wrong", "missing": "not answered",
    "ungraded": "not graded yet",
}  # fmt: skip

OURS = (
    r"the|these|this|its|it|not|nothing|no|entry|numbers?|an? \w+ is missing|a list|a singular|say|left|qdot failed"
    r"|cells?|right but|claimed"
)
"""Words with which the grader's reasons begin; whatever else begins one may be a name out of the notebook."""


def feedback_page(assignment: Assignment, student: Student, result: dict[str, Any]) -> str:
    """Return the student's page as self-contained HTML; nothing in it regenerates a problem.

    The worked solutions are on it where the assignment says `feedback = "solutions"`.
    """
    if result["obstacle"] is not None:
        return _page(assignment, student, result, [])
    solutions = _solutions(assignment, student) if assignment.feedback == "solutions" else {}
    problems = [
        {
            "title": f"Problem {number}: {slot.family.title}",
            "parts": [
                {**_part(number, index, part), "solution": solutions.get((slot.name, part["name"]))}
                for index, part in enumerate(entry["parts"], 1)
            ],
        }
        for number, (slot, entry) in enumerate(zip(assignment.slots, result["problems"], strict=True), 1)
    ]
    return _page(assignment, student, result, problems)


def _page(assignment: Assignment, student: Student, result: dict[str, Any], problems: list[dict[str, Any]]) -> str:
    return render(
        "feedback.html.j2",
        title=assignment.title,
        student=student,
        result=result,
        percent=f"{100 * result['score'] / result['max_score']:.0f}",
        score=f"{round(result['score'], 2):g}",
        max_score=f"{result['max_score']:g}",
        problems=problems,
    )


def _solutions(assignment: Assignment, student: Student) -> dict[tuple[str, str], str]:
    """Return the worked solution of every part as HTML, by slot and part."""
    return {
        (slot, part.name): to_html(worked_solution(problem, part))
        for slot, problem in assignment.problems(student.id)
        for part in problem.parts
    }


def _part(number: int, index: int, part: dict[str, Any]) -> dict[str, Any]:
    answer = part["answer"]
    return {
        "number": f"{number}.{index}",
        "title": QUESTIONS[part["name"]].title,
        "outcome": part["outcome"],
        "word": WORDS[part["outcome"]],
        "points": "–" if part["points"] is None else f"{round(part['points'], 2):g}",
        "max_points": f"{part['max_points']:g}",
        "reason": _sentence(part["reason"]),
        "advice": part["advice"],
        "sure": _how_sure(part["certificate"]) if part["outcome"] == "correct" else "",
        "answer": None if answer is None else answer if len(answer) <= 2000 else answer[:2000] + " …",
        "entries": part["entries"] if part["outcome"] in ("partial", "wrong") and _several(part["entries"]) else None,
    }


def _how_sure(certificate: dict[str, Any] | None) -> str:
    """Return how a right answer was compared, and the chance that a wrong one would have passed."""
    if certificate is None or (certificate["points"] < 2 and not certificate["bound"]):
        return ""
    points, bound = certificate["points"], certificate["bound"]
    if not bound:
        return f"Compared at {points} configurations."
    chance = f"would have passed with a chance below 1 in 10^{-math.ceil(math.log10(bound))}"
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
