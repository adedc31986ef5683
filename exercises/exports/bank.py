"""A bank of problems: so many different variants of each of an assignment's, certified, the same at every export."""

from collections.abc import Generator
from contextlib import closing
from dataclasses import dataclass

from exercises.assignment import Assignment, Slot
from exercises.errors import QdotError
from exercises.exports.outlet import Failures, Order
from exercises.parallel import ordered_map
from exercises.problem import Problem
from exercises.record import digests

PATIENCE = 10
"""So many times as many problems as are wanted are drawn where a family has few that differ."""


@dataclass(frozen=True)
class Variant:
    """A problem of the bank: of which place in the assignment, and the how-manieth of that place, from 1."""

    slot: Slot
    number: int
    problem: Problem

    @property
    def key(self) -> str:
        """A short name that no other variant of the assignment has, and that stays, as in "p1-007"."""
        return f"{self.slot.name}-{self.number:03d}"


def bank(order: Order) -> Generator[Variant, None, None]:
    """Yield the variants of every place in turn. A bank of 20 is how a bank of 50 begins.

    They are drawn with the assignment's secret, so that who has qdot can't draw them again; no student has the same
    ones but by chance. Raises QdotError where a problem fails its certificate.
    """
    for slot in order.assignment.slots:
        made = 0
        for problem in _different(order, slot):
            made += 1
            order.each()
            yield Variant(slot, made, problem)
        if made < order.variants:
            order.note(f"{slot.name}: {slot.family.name} has only {made} such problems that differ")
        for _ in range(order.variants - made):
            order.each()


def _different(order: Order, slot: Slot) -> Generator[Problem, None, None]:
    seen: set[str] = set()
    drawn = 0
    while len(seen) < order.variants and drawn < PATIENCE * order.variants:
        numbers = range(drawn, drawn + order.variants - len(seen))
        drawn = numbers.stop
        state = (order.assignment, slot, order.failures)
        with closing(ordered_map(_draw, numbers, order.jobs, _all, state)) as every:
            for problem in every:
                known_by = repr(digests(problem))
                if known_by not in seen:
                    seen.add(known_by)
                    yield problem


def _all(assignment: Assignment, slot: Slot, failures: Failures) -> tuple[Assignment, Slot, Failures]:
    return assignment, slot, failures


def _draw(state: tuple[Assignment, Slot, Failures], number: int) -> Problem:
    assignment, slot, failures = state
    problem = slot.problem(assignment.secret, f"bank/{number}")  # no student's identifier has a slash
    failed = failures(problem)
    if failed:
        raise QdotError(f"{problem.id}: the problem does not pass its certificate: {failed[0]}; please report it")
    return problem
