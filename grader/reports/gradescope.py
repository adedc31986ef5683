"""A student's result as Gradescope's results.json: a test for every part, with its points and the reason.

A hidden test hides the total from students, so there is none: what only staff should know is in `extra_data`, which
Gradescope shows to nobody but its API.
"""

import json
from collections.abc import Sequence
from typing import Any

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.json_form import as_json
from qdot.grader.grading.result import Result
from qdot.grader.reports.answers import visible
from qdot.grader.reports.rows import Row, lateness, rows_of, the_only
from qdot.grader.reports.tables import staff_notes

VISIBILITY = ("visible", "after_due_date", "after_published", "hidden")
"""When students see a test, in Gradescope's words."""


def results_json(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return results.json, with every test visible."""
    return as_text(content_of(the_only(results, "gradescope"), assignment.feedback))


def as_text(content: dict[str, Any]) -> str:
    """Return the file's text."""
    return json.dumps(content, ensure_ascii=False, indent=1) + "\n"


def content_of(result: Result, feedback: str, visibility: str = "visible") -> dict[str, Any]:
    """Return what results.json holds, told as the level `feedback` says.

    The score is after lateness and whatever a person set.
    """
    notes = [text for text in (*result.notes, lateness(result)) if text]
    if result.override is not None:
        notes.append(f"the total was set by your instructor: {result.override.comment}".rstrip(": "))
    return {
        "score": result.score,
        "output": visible("\n".join(notes)),
        "output_format": "text",
        "visibility": visibility,
        "stdout_visibility": "hidden",
        "tests": [_test(row, visibility) for row in rows_of(result, feedback)],
        "extra_data": {
            "student": result.student, "assignment": result.assignment, "made_from": as_json(result.made_from),
            "late": as_json(result.late), "staff_notes": staff_notes(result),
        },
    }  # fmt: skip


def _test(row: Row, visibility: str) -> dict[str, Any]:
    return {
        "name": row.title,
        "number": row.part,
        "score": row.points,
        "max_score": row.max_points,
        "status": "passed" if row.passed else "failed",
        "output": visible(f"{row.outcome}: {row.said}"),
        "output_format": "text",
        "visibility": visibility,
    }
