"""The notebooks for an export: unchanged ones from released/, and new ones for the other students."""

from collections.abc import Generator
from dataclasses import dataclass

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.draws import certify_class
from qdot.exercises.assignment.release import is_released, make_handout_text, released_text
from qdot.exercises.exports.export_format import ExportRequest


@dataclass(frozen=True)
class Handouts:
    """The notebooks of a class. `students` lists the students who have a notebook.

    `new_ids` contains the ids of students whose notebooks are new. `collect_handouts` has already called
    `request.on_step` for them and for students without a notebook.
    """

    request: ExportRequest
    assignment: Assignment
    students: tuple[Student, ...]
    new_ids: frozenset[str]

    def iterate_notebooks(self) -> Generator[tuple[Student, str], None, None]:
        """Yield every notebook, in roster order."""
        for student in self.students:
            if student.id in self.new_ids:
                yield student, make_handout_text(self.assignment, student.id)
            else:
                yield student, released_text(self.assignment, student.id)
                self.request.on_step()


def collect_handouts(request: ExportRequest) -> Handouts:
    """Return the notebooks of a class, after recording regenerated problems in the assignment's folder.

    Call this before copying any file of the assignment.
    """
    new_ids = [student.id for student in request.assignment.roster if not is_released(request.assignment, student.id)]
    assignment, failures = certify_class(
        request.assignment, new_ids, request.find_failures, request.jobs, request.on_step
    )
    for failure in failures:
        request.on_left_out(failure)
    left_out_students = {failure.student for failure in failures}
    students = tuple(student for student in assignment.roster if student.id not in left_out_students)
    return Handouts(request, assignment, students, frozenset(new_ids))
