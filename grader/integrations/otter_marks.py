"""Mark a submission for Otter's autograder, in qdot's own sandbox."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.grader.integrations.gradescope import find_submitter, grade_submission
from qdot.grader.judging.verdict import AWAITS_PERSON
from qdot.grader.reports.gradescope import GradescopeResults
from qdot.grader.submissions.submission import read_submission


def grade_for_otter(folder: Path, notebook: Path, metadata: Mapping[str, Any]) -> GradescopeResults:
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
        student = assignment.find_student(student_id)
    results = grade_submission(assignment, student, notebook, metadata)
    for test in results.tests:
        if test.score is None and AWAITS_PERSON not in test.output:
            raise QdotError(f"{student.id}: {test.number} has no mark: {test.output}")
    return results
