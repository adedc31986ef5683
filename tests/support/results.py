"""Results made by hand, as results.jsonl holds them: nothing is run."""

from collections.abc import Sequence
from typing import Any

from qdot.exercises.assignment.assignment import Assignment
from qdot.grader.grading.marking import total

SHARES = {"correct": 1.0, "partial": 0.5, "wrong": 0.0, "missing": 0.0, "ungraded": None}


def part(
    name: str, outcome: str, max_points: float, answer: str | None = None, mistake: str | None = None, **others: Any
) -> dict[str, Any]:
    share = SHARES[outcome]
    made = {
        "name": name, "outcome": outcome, "over_limit": False, "points": None if share is None else share * max_points,
        "max_points": max_points, "override": None, "reason": "because", "mistake": mistake,
        "advice": None if mistake is None else f"advice on {mistake}", "followed_from": None, "attempt": None,
        "group": None, "certificate": None, "answer": answer, "entries": None,
    }  # fmt: skip
    return made | others


def result(
    assignment: Assignment,
    student: str,
    outcomes: Sequence[str] = (),
    answers: Sequence[str | None] = (),
    **others: Any,
) -> dict[str, Any]:
    """Return a student's result: an outcome a part, in order; without outcomes, nothing was handed in."""
    given = iter(outcomes or ["missing"] * 99)
    said = iter([*answers, *[None] * 99])
    problems: list[dict[str, Any]] = [
        {
            "id": str(assignment.identity(slot, student)),
            "slot": slot.name,
            "parts": [
                part(name, next(given), points, next(said))
                for name, points in zip(slot.questions, slot.max_points, strict=True)
            ],
        }
        for slot in assignment.slots
    ]
    parts: list[dict[str, Any]] = [each for problem in problems for each in problem["parts"]]
    submission = {"file": f"{student}.ipynb", "sha256": "0", "received": None, "received_from": "file"}
    made = {
        "student": student, "assignment": assignment.key, "submission": submission if outcomes else None,
        "score": total(each["points"] for each in parts), "max_score": total(each["max_points"] for each in parts),
        "late": None, "override": None, "attempts": [], "notes": [], "staff_notes": [], "made_from": {},
        "obstacle": None if outcomes else "nothing was handed in", "problems": problems,
    }  # fmt: skip
    return made | others
