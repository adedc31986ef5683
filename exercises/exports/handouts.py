"""The notebooks for an export: a student's notebook in released/ if it is up to date, otherwise a new one."""

from collections.abc import Generator
from dataclasses import dataclass
from typing import Any

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.certified_problems import certify_class
from qdot.exercises.assignment.release import is_released, make_notebook, make_notebook_path, read_if_present
from qdot.exercises.exports.export_format import ExportRequest
from qdot.exercises.exports.wheel import make_wheel
from qdot.exercises.notebook.notebook import write_notebook


@dataclass(frozen=True)
class Handouts:
    """The notebooks of a class; `students` lists the students who have a notebook."""

    assignment: Assignment
    students: tuple[Student, ...]

    @property
    def context(self) -> dict[str, Any]:
        """The values that the templates of all these exports show: the title, the key, and the wheel's file name."""
        return {"title": self.assignment.title, "key": self.assignment.key, "wheel": make_wheel().file_name}

    def iterate_notebooks(self) -> Generator[tuple[Student, str], None, None]:
        """Yield every notebook, in roster order."""
        for student in self.students:
            if is_released(self.assignment, student.id):
                yield student, read_if_present(make_notebook_path(self.assignment, student.id)) or ""
            else:
                problems = self.assignment.generate_problems(student.id)
                yield student, write_notebook(make_notebook(self.assignment, student.id, problems))


def collect_handouts(request: ExportRequest) -> Handouts:
    """Return the notebooks of a class, after recording replaced problems in the assignment's folder.

    Call this function before copying any file of the assignment, because redrawn.csv may change. `request.on_step` is
    called for all students.
    """
    assignment, students = request.assignment, [student.id for student in request.assignment.roster]
    new_ids = [student for student in students if not is_released(assignment, student)]
    for _ in range(len(students) - len(new_ids)):
        request.on_step()
    assignment, failures = certify_class(assignment, new_ids, request.find_failures, request.jobs, request.on_step)
    for failure in failures:
        request.on_left_out(failure)
    left_out_ids = {failure.student for failure in failures}
    return Handouts(assignment, tuple(student for student in assignment.roster if student.id not in left_out_ids))
