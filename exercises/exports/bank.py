"""A bank of problems: so many different variants of each of an assignment's, certified, the same at every export."""

from collections.abc import Callable, Generator
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import Generic, TypeVar

from qdot.exercises.assignment.assignment import Slot
from qdot.exercises.assignment.draws import GivenUp, Variant, attempt, instead, vouching
from qdot.exercises.assignment.redrawn import DRAWS
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.json_form import as_json
from qdot.exercises.common.parallel import ordered_map
from qdot.exercises.exports.outlet import Order
from qdot.exercises.families.base import how_varied
from qdot.exercises.problem.problem import Problem
from qdot.exercises.problem.record import digests

Made = TypeVar("Made")

PATIENCE = 10
"""So many times as many problems as are wanted are drawn where a family has few that differ."""


Work = Callable[[Order, Slot, Problem], Made]
"""What is made of a problem, whatever its number will be; it is handed to other processes: a function of a module."""


def bank(order: Order) -> Generator[Variant, None, None]:
    """Yield the variants of every place in turn. A bank of 20 is how a bank of 50 begins.

    They are drawn with the assignment's secret, so that who has qdot can't draw them again; no student has the same
    ones but by chance. What does not pass its certificate is passed over. Raises QdotError where nothing passes.
    """
    for variant, _ in worked_out(order, _nothing_else):
        yield variant


def worked_out(order: Order, work: Work[Made]) -> Generator[tuple[Variant, Made], None, None]:
    """Yield the variants of a bank with what `work` makes of each, in the process that has drawn and certified it.

    So the many processes of an order share all of the work, and what was derived of an arm is derived once.
    """
    for slot in order.assignment.slots:
        count, failed = 0, list[str]()
        for problem, made in _different(order, slot, work, failed):
            count += 1
            order.each()
            yield Variant(slot, count, problem), made
        if not count:
            raise _nothing_passes(order, slot, failed[0])
        if failed:
            order.note(f"{slot.name}: {len(failed)} draws did not pass, and others were taken; the first: {failed[0]}")
        if count < order.variants:
            number = "one such problem" if count == 1 else f"{count} such problems that differ"
            varied = how_varied(slot.family, slot.variation)
            order.note(f"{slot.name}: {slot.family.name} has only {number} ({varied}), not {order.variants}")
        for _ in range(order.variants - count):
            order.each()


def _nothing_else(order: Order, slot: Slot, problem: Problem) -> None:
    """Make nothing of a problem but itself."""


def _different(
    order: Order, slot: Slot, work: Work[Made], failed: list[str]
) -> Generator[tuple[Problem, Made], None, None]:
    """Yield problems that pass, no two of them the same; what is wrong with others goes into `failed`."""
    seen: set[str] = set()
    drawn = 0
    while len(seen) < order.variants and drawn < PATIENCE * order.variants and (seen or len(failed) < DRAWS):
        numbers = range(drawn, drawn + order.variants - len(seen))
        drawn = numbers.stop
        drawing = (order.untold, slot, work, frozenset(seen))
        with closing(ordered_map(_draw, numbers, order.jobs, _Drawing, drawing)) as every:
            for found in every:
                if isinstance(found, str):
                    failed.append(found)
                elif found is not None and found.known_by not in seen:
                    seen.add(found.known_by)
                    yield found.problem, found.made


def _nothing_passes(order: Order, slot: Slot, why: str) -> QdotError:
    given_up = GivenUp("", slot.name, slot.family.name, why)
    ways = instead(order.assignment, given_up, vouching(order.failures))
    return QdotError(f"{given_up}. Nothing is exported. {ways}")


@dataclass(frozen=True)
class _Found(Generic[Made]):
    problem: Problem
    known_by: str
    made: Made


class _Drawing(Generic[Made]):
    """What a process knows: what it is to make, and which problems there are already, those of its own included."""

    def __init__(self, order: Order, slot: Slot, work: Work[Made], seen: frozenset[str]) -> None:
        self.order, self.slot, self.work, self.seen = order, slot, work, set(seen)


def _draw(drawing: _Drawing[Made], number: int) -> _Found[Made] | str | None:
    """Return a problem that passes, with what is made of it, or what is wrong with it; None of one that was there.

    A process draws the numbers that it gets in their order, so that whoever puts them in order sees the one first of
    which something was made.
    """
    order, slot = drawing.order, drawing.slot
    make = partial(slot.problem, order.assignment.secret, f"bank/{number}")  # no student's identifier has a slash
    tried = attempt(make, vouching(order.failures))
    if isinstance(tried, str):
        return tried
    problem = tried[0]
    known_by = repr(as_json(digests(problem)))
    if known_by in drawing.seen:
        return None
    drawing.seen.add(known_by)
    return _Found(problem, known_by, drawing.work(order, slot, problem))
