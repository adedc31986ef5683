"""Replace nbgrader's own steps so that `nbgrader autograde` marks with qdot: `configure(c)`.

qdot marks the assignments that have a folder qdot/ASSIGNMENT in the course; nbgrader grades all others itself. No
kernel is started: qdot runs the submitted notebook in its sandbox, and compares the answers with the problems of the
student whom nbgrader names. This module needs nbgrader, and no other module imports it.
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
from qdot.exercises.exports.nbgrader import MARKS_COMMENT, find_text_parts
from qdot.grader.grading.batch import grade_one, make_limits
from qdot.grader.grading.result import Result
from qdot.grader.integrations.nbgrader_cells import EXPORT_AGAIN, fill_in_marks, remove_self_checks, restore_cells
from qdot.grader.marking.marking import compute_points, format_points, map_max_points
from qdot.grader.reports.part_rows import make_part_rows
from qdot.grader.sandbox.guarantees import note_sandbox_weakness
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import find_student_files

QDOT_FOLDER = "qdot"
"""The folder of a course that contains the folders of assignments that qdot marks."""
NotebookAndResources = tuple[NotebookNode, Any]
"""What a step of nbgrader passes to the next one: the notebook, and nbgrader's resources."""


def configure(c: Any) -> None:
    """Set qdot's steps in nbgrader's configuration `c`; other settings don't change.

    Raises QdotError if this version of nbgrader lacks a step that qdot replaces.
    """
    traits = Autograde.class_traits()
    sanitizing_steps = traits["sanitize_preprocessors"].default()
    grading_steps = list(traits["autograde_preprocessors"].default())
    if grading_steps.count(Execute) != 1 or grading_steps.count(AssignLatePenalties) != 1:
        raise QdotError("qdot can't grade in this version of nbgrader, whose steps differ from those of nbgrader 0.9")
    replacements = {Execute: Mark, AssignLatePenalties: ApplyLateRule}
    c.Autograde.sanitize_preprocessors = [RestoreCells, *sanitizing_steps]
    c.Autograde.autograde_preprocessors = [replacements.get(step, step) for step in grading_steps]


class RestoreCells(NbGraderPreprocessor):
    """nbgrader step that restores the cells of a student's notebook before nbgrader inspects them."""

    def preprocess(self, nb: NotebookNode, resources: Any) -> NotebookAndResources:
        """Return the notebook with restored cells. Raises QdotError if the folder of a qdot assignment is missing."""
        info = resources["nbgrader"]
        with Gradebook(info["db_url"]) as gradebook:
            source_notebook = gradebook.find_notebook(info["notebook"], info["assignment"])
            sources = [cell.source for cell in source_notebook.source_cells]
        assignment = _load_qdot_assignment(self, info["assignment"])
        if assignment is None:
            if any(source.startswith(MARKS_COMMENT) for source in sources):
                folder = f"{QDOT_FOLDER}/{info['assignment']}"
                raise QdotError(f"{folder} is missing, but qdot needs it to grade {info['assignment']}")
            return nb, resources
        points, text_parts = map_max_points(assignment), find_text_parts(assignment)
        if sum(source.startswith(MARKS_COMMENT) for source in sources) != len(points) - len(text_parts):
            raise QdotError(f"the cells in nbgrader's database are not those of {info['assignment']}; {EXPORT_AGAIN}")
        nb.cells = [from_dict(cell) for cell in restore_cells(nb.cells, points, text_parts)]
        return nb, resources


class Mark(Execute):
    """nbgrader step that marks with qdot; nbgrader itself runs notebooks of assignments that are not qdot's."""

    seconds = Float(Limits.seconds, help="Processor time that a student's notebook may take.").tag(config=True)

    def preprocess(self, nb: NotebookNode, resources: Any, *others: Any, **options: Any) -> NotebookAndResources:
        """Return the notebook with the marks and the reasons. Raises QdotError if it can't be marked."""
        info = resources["nbgrader"]
        assignment = _load_qdot_assignment(self, info["assignment"])
        if assignment is None:
            return super().preprocess(nb, resources, *others, **options)
        result = _grade(assignment, info, self)
        rows = make_part_rows(result, assignment, assignment.feedback)
        fill_in_marks(nb.cells, rows)
        problems = assignment.generate_problems(info["student"])
        nb.cells = [from_dict(cell) for cell in remove_self_checks(nb.cells, problems)]
        late, penalty = result.late, None
        if late is not None:  # the penalty is rounded as in qdot's own results
            penalty = compute_points(late.points_before, share=1.0, factor=Fraction(str(late.penalty)))
        resources["qdot"] = {"late_penalty": penalty}
        if result.override is not None and result.override.points is not None:
            total = format_points(result.override.points)
            note(f"{info['student']}: overrides.csv sets the total to {total}, but nbgrader uses the sum of the parts")
        return nb, resources


class ApplyLateRule(AssignLatePenalties):
    """nbgrader step that applies the late rule of assignment.toml; other assignments use nbgrader's own rule."""

    def preprocess(self, nb: NotebookNode, resources: Any) -> NotebookAndResources:
        """Write the late penalty to nbgrader's database, and return the notebook unchanged."""
        if "qdot" not in resources:
            return super().preprocess(nb, resources)
        info = resources["nbgrader"]
        with Gradebook(info["db_url"]) as gradebook:
            names = info["notebook"], info["assignment"], info["student"]
            gradebook.find_submission_notebook(*names).late_submission_penalty = resources["qdot"]["late_penalty"]
            gradebook.db.commit()
        return nb, resources


def _load_qdot_assignment(step: Any, key: str) -> Assignment | None:
    """Return the qdot assignment with a key; None if it has no folder.

    Raises QdotError if the folder contains another assignment.
    """
    folder = Path(step.parent.parent.coursedir.root, QDOT_FOLDER, key)
    if not folder.is_dir():
        return None
    assignment = load_assignment(folder)
    if assignment.key != key:
        raise QdotError(f"{folder} contains the assignment {assignment.key!r}; the folder must have this name")
    return assignment


def _grade(assignment: Assignment, info: Any, step: Mark) -> Result:
    """Return the result of the submission that nbgrader describes."""
    student, course = assignment.find_student(info["student"]), step.parent.parent.coursedir
    _note_sandbox_weakness_once(assignment.sandbox == "strict")
    folder = Path(course.root, course.format_path(course.submitted_directory, student.id, info["assignment"]))
    received_time = course.get_existing_timestamp(str(folder))
    if received_time is not None and received_time.tzinfo is None:
        received_time = received_time.replace(tzinfo=datetime.UTC)
    files = find_student_files(assignment, folder / f"{info['notebook']}.ipynb", received_time, "nbgrader")
    return grade_one(assignment, student, files, make_limits(step.seconds))


_note_sandbox_weakness_once = cache(note_sandbox_weakness)
"""Warns about a weak sandbox only once, not for every notebook of a class."""
