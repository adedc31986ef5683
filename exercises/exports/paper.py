"""Handouts: a page for every student, with or without solutions."""

from collections.abc import Generator

from exercises.exports.outlet import File, Order
from exercises.show import show


def html_pages(order: Order) -> Generator[File, None, None]:
    """Yield every problem of every student as a page of its own."""
    for student in order.assignment.roster:
        for slot, problem in order.assignment.problems(student.id):
            page = show(problem, order.solutions, "html", hinted=order.assignment.hints)
            yield File(f"{student.id}/{slot}.html", page, private=order.solutions)
        order.each()
