"""The page that a student gets back: per part, what was right and what was not, and why."""

from typing import Any

from exercises.assignment import Assignment, Student
from exercises.questions import QUESTIONS
from exercises.render import render

WORDS = {
    "correct": "right", "partial": "partly right", "wrong": "wrong", "missing": "not answered",
    "ungraded": "not graded yet",
}  # fmt: skip


def feedback_page(assignment: Assignment, student: Student, result: dict[str, Any]) -> str:
    """Return the student's page as self-contained HTML; nothing in it regenerates a problem."""
    problems = [
        {
            "title": f"Problem {number}",
            "parts": [_part(number, index, part) for index, part in enumerate(entry["parts"], 1)],
        }
        for number, entry in enumerate(result["problems"], 1)
    ]
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


def _part(number: int, index: int, part: dict[str, Any]) -> dict[str, Any]:
    answer = part["answer"]
    return {
        "number": f"{number}.{index}",
        "title": QUESTIONS[part["name"]].title,
        "outcome": part["outcome"],
        "word": WORDS[part["outcome"]],
        "points": "–" if part["points"] is None else f"{round(part['points'], 2):g}",
        "max_points": f"{part['max_points']:g}",
        "reason": part["reason"][:1].upper() + part["reason"][1:],
        "answer": None if answer is None else answer if len(answer) <= 2000 else answer[:2000] + " …",
        "entries": part["entries"],
    }
