"""Mark a submission for Otter's autograder, whose tests only look up the marks.

Otter runs tests in the process that has run the student's code, so this process must contain nothing that reveals
answers. qdot marks the submission earlier, in its own sandbox, and passes only the student's points and feedback on.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.json_form import to_jsonable
from qdot.grader.grading.batch import find_student
from qdot.grader.integrations.gradescope import find_submitter, grade_submission
from qdot.grader.judging.verdict import AWAITS_PERSON
from qdot.grader.reports.gradescope import GradescopeResults
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import read_submission

MARKS_VARIABLE = "qdot_marks"
"""Name of the variable with the marks in the process that runs the tests."""


@dataclass(frozen=True)
class Mark:
    """The mark for a part: the points earned, the maximum points, and the feedback."""

    points: float
    max_points: float
    feedback: str


def grade_for_otter(
    folder: Path, notebook: Path, metadata: Mapping[str, Any], seconds: float = Limits.seconds
) -> GradescopeResults:
    """Return a submission's results in Gradescope's format. Raises QdotError if it can't be marked.

    `metadata` is Gradescope's description of the submission. If it lists no users, the notebook names the student.
    """
    assignment = load_assignment(folder)
    if metadata.get("users"):
        student = find_submitter(assignment, dict(metadata), notebook.parent)
    else:
        student_id = read_submission(notebook, assignment.key).qdot_metadata.get("student")
        if not isinstance(student_id, str):
            raise QdotError(f"{notebook.name} does not name its student; submit the notebook that you received")
        student = find_student(assignment, student_id)
    results = grade_submission(assignment, student, notebook, metadata, seconds=seconds)
    for test in results.tests:
        if test.score is None and AWAITS_PERSON not in test.output:
            raise QdotError(f"{student.id}: {test.number} has no mark: {test.output}")
    return results


def list_marks(results: GradescopeResults) -> dict[str, Mark]:
    """Return the marks by the names of the parts, such as "p1.jacobian"."""
    return {test.number: Mark(test.score or 0.0, test.max_score, test.output) for test in results.tests}


def write_marks_code(marks: Mapping[str, Mark]) -> str:
    """Return the code of a cell that loads the marks for the tests and runs no student code."""
    return f"import json\n{MARKS_VARIABLE} = json.loads({json.dumps(to_jsonable(marks))!r})"


def require_full_points(marks: Mapping[str, Mapping[str, Any]] | None, part: str) -> None:
    """Raise AssertionError with the feedback unless the answer to a part earns all points.

    `marks` are the marks that the code of `write_marks_code` has loaded; None if that code was not run.
    """
    if marks is None or part not in marks:
        raise AssertionError("this notebook earns no points, because qdot has not graded it")
    mark = Mark(**marks[part])
    if mark.points < mark.max_points:
        raise AssertionError(mark.feedback)
