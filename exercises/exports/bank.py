"""A bank of problems: so many different variants of each of an assignment's, certified, the same at every export."""

from collections.abc import Generator
from contextlib import closing
from dataclasses import dataclass
from functools import partial

from exercises.assignment import Assignment, Slot
from exercises.drawing import Failures, GivenUp, attempt, instead, vouching
from exercises.errors import QdotError
from exercises.exports.outlet import Order
from exercises.families.base import how_varied
from exercises.parallel import ordered_map
from exercises.problem import Problem
from exercises.record import digests
from exercises.redrawn import DRAWS

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
    ones but by chance. What does not pass its certificate is passed over. Raises QdotError where nothing passes.
    """
    for slot in order.assignment.slots:
        made, failed = 0, list[str]()
        for problem in _different(order, slot, failed):
            made += 1
            order.each()
            yield Variant(slot, made, problem)
        if not made:
            raise _nothing_passes(order, slot, failed[0])
        if failed:
            order.note(f"{slot.name}: {len(failed)} draws did not pass, and others were taken; the first: {failed[0]}")
        if made < order.variants:
            number = "one such problem" if made == 1 else f"{made} such problems that differ"
            order.note(f"{slot.name}: {slot.family.name} has only {number} ({how_varied(slot.family, slot.variation)})")
        for _ in range(order.variants - made):
            order.each()


def _different(order: Order, slot: Slot, failed: list[str]) -> Generator[Problem, None, None]:
    """Yield problems that pass, no two of them the same; what is wrong with others goes into `failed`."""
    seen: set[str] = set()
    drawn = 0
    while len(seen) < order.variants and drawn < PATIENCE * order.variants and (seen or len(failed) < DRAWS):
        numbers = range(drawn, drawn + order.variants - len(seen))
        drawn = numbers.stop
        state = (order.assignment, slot, order.failures)
        with closing(ordered_map(_draw, numbers, order.jobs, _all, state)) as every:
            for problem in every:
                if isinstance(problem, str):
                    failed.append(problem)
                elif (known_by := repr(digests(problem))) not in seen:
                    seen.add(known_by)
                    yield problem


def _nothing_passes(order: Order, slot: Slot, why: str) -> QdotError:
    given_up = GivenUp("", slot.name, slot.family.name, why)
    ways = instead(order.assignment, given_up, vouching(order.failures))
    return QdotError(f"{given_up}. Nothing is exported. {ways}")


def _all(assignment: Assignment, slot: Slot, failures: Failures) -> tuple[Assignment, Slot, Failures]:
    return assignment, slot, failures


def _draw(state: tuple[Assignment, Slot, Failures], number: int) -> Problem | str:
    """Return a problem that passes, or what is wrong with it."""
    assignment, slot, failures = state
    make = partial(slot.problem, assignment.secret, f"bank/{number}")  # no student's identifier has a slash
    made = attempt(make, vouching(failures))
    return made if isinstance(made, str) else made[0]
