"""Write a student's result as Gradescope's results.json: a test for every part, with its points and its feedback.

No test is hidden, because a hidden test would hide the total from students, too. Information for the staff is in
`extra_data`, which only Gradescope's API shows.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.json_form import to_jsonable
from qdot.grader.grading.result import Lateness, MarkingVersions, Result
from qdot.grader.reports.answer_display import make_visible
from qdot.grader.reports.grades_table import list_staff_notes
from qdot.grader.reports.part_rows import get_only_result, list_notes, make_part_rows

VISIBILITY = ("visible", "after_due_date", "after_published", "hidden")
"""Gradescope's words for when students see a test."""
PASSED = "passed"
"""The status of a test whose part has full points."""


@dataclass(frozen=True)
class PartTest:
    """The test for a part: `name` is the title of the part, and `number` its name in the assignment ("p1.jacobian")."""

    name: str
    number: str
    score: float | None
    max_score: float
    status: str
    output: str
    output_format: str
    visibility: str


@dataclass(frozen=True)
class StaffData:
    """Information for the staff, which Gradescope shows in its API but not on its pages."""

    student: str
    assignment: str
    made_from: MarkingVersions
    late: Lateness | None
    staff_notes: tuple[str, ...]


@dataclass(frozen=True)
class GradescopeResults:
    """The contents of results.json; the score includes the late penalty and overrides."""

    score: float
    output: str
    output_format: str
    visibility: str
    stdout_visibility: str
    tests: tuple[PartTest, ...]
    extra_data: StaffData

    @property
    def text(self) -> str:
        """The content of the file."""
        return json.dumps(to_jsonable(self), ensure_ascii=False, indent=1) + "\n"


def make_results_json(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return results.json for the only student, with every test visible. Raises QdotError for several students."""
    return make_gradescope_results(get_only_result(results), assignment).text


def make_gradescope_results(result: Result, assignment: Assignment, visibility: str = "visible") -> GradescopeResults:
    """Return the contents of results.json; `visibility` says when students see the tests."""
    staff_notes = tuple(list_staff_notes(result))
    staff_data = StaffData(result.student, result.assignment, result.made_from, result.late, staff_notes)
    tests = tuple(
        PartTest(
            row.title, row.part, row.points, row.max_points, PASSED if row.has_full_points else "failed",
            make_visible(row.description), "text", visibility,
        )
        for row in make_part_rows(result, assignment, assignment.feedback)
    )  # fmt: skip
    output = make_visible("\n".join(list_notes(result)))
    return GradescopeResults(result.score, output, "text", visibility, "hidden", tests, staff_data)
