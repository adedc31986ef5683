"""The notebooks that exports contain: those in released/ unchanged, and new ones for everybody else."""

from collections.abc import Generator
from dataclasses import dataclass

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.draws import settle_problems
from qdot.exercises.assignment.release import is_released, new_handout, released_text
from qdot.exercises.exports.export_format import Order


@dataclass(frozen=True)
class Handouts:
    """The notebooks of a class. `students` lists everybody who has one.

    `order.each` has already been called for everybody else, and for the students in `settled_now`.
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
    """Record which problems the students have, before any file of the assignment is handed out or copied."""
    new = [student.id for student in order.assignment.roster if not is_released(order.assignment, student.id)]
    assignment, given_up = settle_problems(order.assignment, new, order.failures, order.jobs, order.each)
    for failure in given_up:
        order.left_out(failure)
    without = {failure.student for failure in given_up}
    students = tuple(student for student in assignment.roster if student.id not in without)
    return Handouts(order, assignment, students, frozenset(new))
