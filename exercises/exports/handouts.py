"""The notebooks for an export: unchanged ones from released/, and new ones for the other students."""

from collections.abc import Generator
from dataclasses import dataclass

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.draws import settle_problems
from qdot.exercises.assignment.release import is_released, new_handout, released_text
from qdot.exercises.exports.export_format import Order


@dataclass(frozen=True)
class Handouts:
    """The notebooks of a class. `students` lists the students who have a notebook.

    `settled_now` has the students whose notebooks are new. `order.each` has already been called for them, and for
    students without a notebook.
    """

    order: Order
    assignment: Assignment
    students: tuple[Student, ...]
    settled_now: frozenset[str]

    def all(self) -> Generator[tuple[Student, str], None, None]:
        """Yield every notebook, in roster order."""
        for student in self.students:
            if student.id in self.settled_now:
                yield student, new_handout(self.assignment, student.id)
            else:
                yield student, released_text(self.assignment, student.id)
                self.order.each()


def handouts(order: Order) -> Handouts:
    """Return the notebooks of a class, after recording regenerated problems in the assignment's folder.

    Call this before copying any file of the assignment.
    """
    unreleased = [student.id for student in order.assignment.roster if not is_released(order.assignment, student.id)]
    assignment, failures = settle_problems(order.assignment, unreleased, order.failures, order.jobs, order.each)
    for failure in failures:
        order.left_out(failure)
    left_out_students = {failure.student for failure in failures}
    students = tuple(student for student in assignment.roster if student.id not in left_out_students)
    return Handouts(order, assignment, students, frozenset(unreleased))
