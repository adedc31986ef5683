"""The notebooks for an export: a student's notebook in released/ if it is up to date, otherwise a new one."""

from collections.abc import Generator
from dataclasses import dataclass
from typing import Any

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.certified_problems import certify_class
from qdot.exercises.assignment.release import is_released, make_notebook, notebook_path, read_if_present
from qdot.exercises.exports.export_format import ExportRequest
from qdot.exercises.exports.wheel import make_wheel
from qdot.exercises.notebook.notebook import notebook_text


@dataclass(frozen=True)
class Handouts:
    """The notebooks of a class. `students` lists the students who have a notebook.

    `new_ids` has the ids of the students whose notebooks are not in released/. For these students, and for students
    without a notebook, `collect_handouts` has already called `request.on_step`.
    """

    request: ExportRequest
    assignment: Assignment
    students: tuple[Student, ...]
    new_ids: frozenset[str]

    @property
    def context(self) -> dict[str, Any]:
        """The values that the templates of all these exports show: the title, the key, and the wheel's file name."""
        return {"title": self.assignment.title, "key": self.assignment.key, "wheel": make_wheel()[0]}

    def iterate_notebooks(self) -> Generator[tuple[Student, str], None, None]:
        """Yield every notebook, in roster order."""
        for student in self.students:
            if student.id in self.new_ids:
                problems = self.assignment.generate_problems(student.id)
                yield student, notebook_text(make_notebook(self.assignment, student.id, problems))
            else:
                yield student, read_if_present(notebook_path(self.assignment, student.id)) or ""
                self.request.on_step()


def collect_handouts(request: ExportRequest) -> Handouts:
    """Return the notebooks of a class, after recording replaced problems in the assignment's folder.

    Call this function before copying any file of the assignment, because redrawn.csv may change.
    """
    new_ids = [student.id for student in request.assignment.roster if not is_released(request.assignment, student.id)]
    assignment, failures = certify_class(
        request.assignment, new_ids, request.find_failures, request.jobs, request.on_step
    )
    for failure in failures:
        request.on_left_out(failure)
    left_out_ids = {failure.student for failure in failures}
    students = tuple(student for student in assignment.roster if student.id not in left_out_ids)
    return Handouts(request, assignment, students, frozenset(new_ids))
