"""Replace nbgrader's own steps so that `nbgrader autograde` marks by qdot: `configure(c)`.

Assignments whose folder is qdot/ASSIGNMENT in the course are marked by qdot: no kernel is started, the notebook as it
was handed in runs in qdot's sandbox, and is compared with the problems of the student whom nbgrader names. Every other
assignment of the course is graded by nbgrader. It needs nbgrader, and is imported by nothing else.
"""

import datetime
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

from nbformat import NotebookNode, from_dict
from nbgrader.api import Gradebook
from nbgrader.converters import Autograde
from nbgrader.preprocessors import AssignLatePenalties, Execute, NbGraderPreprocessor
from traitlets import Float

from qdot.exercises.assignment.assignment import Assignment, load_assignment
from qdot.exercises.common.console import note
from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports.nbgrader import SIGN
from qdot.grader.cli.grade_command import check_sandbox
from qdot.grader.grading.batch import find_student, find_student_files, grade_one, make_limits
from qdot.grader.grading.marking import format_points, list_max_points
from qdot.grader.grading.result import Result
from qdot.grader.integrations.nbgrader_cells import GENERATE, fill_in, restore_cells, without_self_checks
from qdot.grader.reports.rows import make_rows
from qdot.grader.sandbox.sandbox import Limits

FOLDER = "qdot"
"""Where in a course the folders are by which assignments are marked."""
Handed = tuple[NotebookNode, Any]


def configure(c: Any) -> None:
    """Set nbgrader's configuration; what else is set in it stays.

    Raises QdotError if this nbgrader has other steps than those to be replaced.
    """
    traits = Autograde.class_traits()
    sanitize, steps = (list(traits[f"{name}_preprocessors"].default()) for name in ("sanitize", "autograde"))
    if steps.count(Execute) != 1 or steps.count(AssignLatePenalties) != 1:
        raise QdotError("this nbgrader has other steps than those of 0.9: qdot can't mark in it")
    ours = {Execute: Mark, AssignLatePenalties: Late}
    c.Autograde.sanitize_preprocessors = [MakeWhole, *sanitize]
    c.Autograde.autograde_preprocessors = [ours.get(step, step) for step in steps]


class MakeWhole(NbGraderPreprocessor):
    """Restore the cells of a student's notebook before nbgrader looks at them."""

    def preprocess(self, nb: NotebookNode, resources: Any) -> Handed:
        """Return the notebook with its cells. Raises QdotError if an assignment of qdot has lost its folder."""
        about = resources["nbgrader"]
        with Gradebook(about["db_url"]) as gradebook:
            pattern = gradebook.find_notebook(about["notebook"], about["assignment"])
            sources = [cell.source for cell in pattern.source_cells]
        assignment = _assignment_of_qdot(self, about["assignment"])
        if assignment is None:
            if any(source.startswith(SIGN) for source in sources):
                raise QdotError(
                    f"{about['assignment']} is marked by qdot, and {FOLDER}/{about['assignment']} is missing"
                )
            return nb, resources
        points = list_max_points(assignment)
        if sum(source.startswith(SIGN) for source in sources) != len(points):
            raise QdotError(f"nbgrader knows other cells than {about['assignment']} has; {GENERATE}")
        nb.cells = [from_dict(cell) for cell in restore_cells(nb.cells, points)]
        return nb, resources


class Mark(Execute):
    """Mark by qdot; assignments that are not qdot's are run by nbgrader."""

    seconds = Float(Limits.seconds, help="Processor time that a student's notebook may take.").tag(config=True)

    def preprocess(self, nb: NotebookNode, resources: Any, *others: Any, **named: Any) -> Handed:
        """Return the notebook with the marks and the reasons. Raises QdotError if there can be no mark."""
        about = resources["nbgrader"]
        assignment = _assignment_of_qdot(self, about["assignment"])
        if assignment is None:
            return super().preprocess(nb, resources, *others, **named)
        result = _grade(assignment, about, self)
        rows = make_rows(result, assignment.feedback)
        fill_in(nb.cells, rows)
        problems = assignment.problems(about["student"])
        nb.cells = [from_dict(cell) for cell in without_self_checks(nb.cells, problems)]
        resources["qdot"] = {"late": _late_penalty(result)}
        if result.override is not None and result.override.points is not None:
            total = format_points(result.override.points)
            note(f"{about['student']}: overrides.csv sets the total to {total}; nbgrader adds up the parts instead")
        return nb, resources


class Late(AssignLatePenalties):
    """Apply the late rule of assignment.toml, or nbgrader's own if the assignment is not qdot's."""

    def preprocess(self, nb: NotebookNode, resources: Any) -> Handed:
        """Return the notebook unchanged, after writing its penalty to the database."""
        if "qdot" not in resources:
            return super().preprocess(nb, resources)
        about = resources["nbgrader"]
        with Gradebook(about["db_url"]) as gradebook:
            names = about["notebook"], about["assignment"], about["student"]
            gradebook.find_submission_notebook(*names).late_submission_penalty = resources["qdot"]["late"]
            gradebook.db.commit()
        return nb, resources


def _course(step: Any) -> Any:
    """Return nbgrader's description of the course of a conversion step."""
    return step.parent.parent.coursedir


def _assignment_of_qdot(step: Any, key: str) -> Assignment | None:
    """Return the assignment by which qdot marks; None if it is not qdot's. Raises QdotError."""
    folder = Path(_course(step).root, FOLDER, key)
    if not folder.is_dir():
        return None
    assignment = load_assignment(folder)
    if assignment.key != key:
        raise QdotError(f"{folder} is of the assignment {assignment.key!r}; the folder has its name")
    return assignment


def _grade(assignment: Assignment, about: Any, step: Mark) -> Result:
    """Return the result of the submission that nbgrader describes."""
    student, course = find_student(assignment, about["student"]), _course(step)
    _check_sandbox_once(assignment.sandbox == "strict")
    folder = Path(course.root, course.format_path(course.submitted_directory, student.id, about["assignment"]))
    received = course.get_existing_timestamp(str(folder))
    if received is not None and received.tzinfo is None:
        received = received.replace(tzinfo=datetime.UTC)
    handed_in = find_student_files(assignment, folder / f"{about['notebook']}.ipynb", received, "nbgrader")
    return grade_one(assignment, student, handed_in, make_limits(step.seconds))


@cache
def _check_sandbox_once(strict: bool) -> None:
    """Report once what this machine does not enforce. Raises QdotError if the assignment requires it."""
    check_sandbox(strict)


def _late_penalty(result: Result) -> float | None:
    """Return the points that lateness costs, rounded as in qdot's own results."""
    late = result.late
    if late is None:
        return None
    return float(round(Fraction(str(late.points_before)) * Fraction(str(late.penalty)), 4))
