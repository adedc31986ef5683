"""Marks as Otter's autograder takes them: a submission marked by qdot, and the tests, which only look marks up.

Otter runs tests in the process that has run the student's code, so that nothing by which answers are found may be
there: qdot marks before, in its own sandbox, and what is handed over is what the student is told anyway.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.grader.grading.one_student import student_named
from qdot.grader.integrations.gradescope import marked, submitter
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import read_submission

Marks = Mapping[str, Mapping[str, Any]]
NAME = "qdot_marks"
"""What the marks are called where tests are run."""


def content_for(folder: Path, notebook: Path, metadata: Mapping[str, Any], seconds: float = Limits.seconds) -> Any:
    """Return a submission's results as Gradescope has them. Raises QdotError where there can be no mark.

    Without users in `metadata`, which Gradescope gives, it is the student's who is named in the notebook.
    """
    assignment = load_assignment(folder)
    if metadata.get("users"):
        student = submitter(assignment, dict(metadata), notebook.parent)
    else:
        student = _named_in(assignment, notebook)
    content = marked(assignment, student, notebook, metadata, seconds=seconds)
    for test in content["tests"]:
        if test["score"] is None:
            raise QdotError(f"{student.id}: {test['number']} is not marked: {test['output']}")
    return content


def _named_in(assignment: Assignment, notebook: Path) -> Student:
    claimed = read_submission(notebook, assignment.key).claims.get("student")
    if not isinstance(claimed, str):
        raise QdotError(f"{notebook.name} does not say whose it is; hand in the notebook that was handed out")
    return student_named(assignment, claimed)


def marks_of(content: Mapping[str, Any]) -> Marks:
    """Return the marks of all parts by their names: points, the most, and what is said."""
    return {
        test["number"]: {"points": test["score"], "of": test["max_score"], "said": test["output"]}
        for test in content["tests"]
    }


def handed_over(marks: Marks) -> str:
    """Return the code of a cell that has the marks ready for the tests, and nothing of the student's."""
    return f"import json\n{NAME} = json.loads({json.dumps(marks)!r})"


def hold(marks: Marks | None, part: str) -> None:
    """Raise AssertionError with what is said of an answer that does not earn all of its points."""
    if marks is None or part not in marks:
        raise AssertionError("qdot has not marked this notebook, so that it earns nothing")
    mark = marks[part]
    if mark["points"] < mark["of"]:
        raise AssertionError(mark["said"])
