"""The notebooks that outlets hand out: those in released/ as they are, all others made now of certified problems."""

from collections.abc import Generator
from dataclasses import dataclass

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.draws import settled
from qdot.exercises.assignment.release import is_released, new_handout, released_text
from qdot.exercises.exports.outlet import Order


@dataclass(frozen=True)
class Handouts:
    """The notebooks of a class whose draws are settled; in `students` are those who have one.

    `order.each` has been told of the others, and of those whose problems were drawn just now.
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
    """Settle which draws the students have, before anything of the assignment is handed out or copied."""
    new = [student.id for student in order.assignment.roster if not is_released(order.assignment, student.id)]
    assignment, given_up = settled(order.assignment, new, order.failures, order.jobs, order.each)
    for given in given_up:
        order.left_out(given)
    without = {given.student for given in given_up}
    students = tuple(student for student in assignment.roster if student.id not in without)
    return Handouts(order, assignment, students, frozenset(new))
