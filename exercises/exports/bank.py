"""A bank of problems: several certified variants of each problem, the same at every export."""

from collections.abc import Callable, Generator
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import Generic, TypeVar

from qdot.exercises.assignment.assignment import Slot
from qdot.exercises.assignment.draws import CHANGE, FailedSlot, Variant, attempt, certify_by
from qdot.exercises.assignment.redrawn import DRAWS
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.json_form import as_json
from qdot.exercises.common.parallel import keep_state, ordered_map
from qdot.exercises.exports.export_format import Order
from qdot.exercises.families.base import describe_variation
from qdot.exercises.problem.problem import Problem
from qdot.exercises.problem.record import digests

Made = TypeVar("Made")

PATIENCE = 10
"""Maximum number of problems to generate for each variant, if a family has few that differ."""


Work = Callable[[Order, Slot, Problem], Made]
"""A function that converts a problem for an export. It must belong to a module, to be pickled for other processes."""


def bank(order: Order) -> Generator[Variant, None, None]:
    """Yield the variants of every slot in turn. A bank of 50 begins with the bank of 20.

    They are generated from the assignment's secret, and nobody can regenerate them without it. Students get the same
    problems only by chance. Problems that fail their certificate are skipped. Raises QdotError if none passes.
    """
    for variant, _ in process_bank(order, _add_nothing):
        yield variant


def process_bank(order: Order, work: Work[Made]) -> Generator[tuple[Variant, Made], None, None]:
    """Yield the variants of a bank, each with the result of `work`.

    `work` runs in the process that has generated and certified the problem. In this way, each arm is derived only once,
    and the processes share the work evenly.
    """
    for slot in order.assignment.slots:
        count, failures = 0, list[str]()
        for problem, work_result in _distinct_problems(order, slot, work, failures):
            count += 1
            order.each()
            yield Variant(slot, count, problem), work_result
        if not count:
            raise _no_variant_error(slot, failures[0])
        if failures:
            order.note(
                f"{slot.name}: {len(failures)} draws did not pass, and others were taken; the first: {failures[0]}"
            )
        if count < order.variants:
            number = "one such problem" if count == 1 else f"{count} such problems that differ"
            variation_words = describe_variation(slot.family, slot.variation)
            order.note(f"{slot.name}: {slot.family.name} has only {number} ({variation_words}), not {order.variants}")
        for _ in range(order.variants - count):
            order.each()


def _add_nothing(order: Order, slot: Slot, problem: Problem) -> None:
    """Return nothing: the `work` of a plain bank."""


def _distinct_problems(
    order: Order, slot: Slot, work: Work[Made], failed: list[str]
) -> Generator[tuple[Problem, Made], None, None]:
    """Yield distinct problems that pass their certificate. Append a message to `failed` for each that does not pass."""
    seen: set[str] = set()
    tried_count = 0
    while len(seen) < order.variants and tried_count < PATIENCE * order.variants and (seen or len(failed) < DRAWS):
        numbers = range(tried_count, tried_count + order.variants - len(seen))
        tried_count = numbers.stop
        state = _WorkerState(order.without_callbacks, slot, work, set(seen))
        with closing(ordered_map(_draw_candidate, numbers, order.jobs, keep_state, (state,))) as candidates:
            for candidate in candidates:
                if isinstance(candidate, str):
                    failed.append(candidate)
                elif candidate is not None and candidate.known_by not in seen:
                    seen.add(candidate.known_by)
                    yield candidate.problem, candidate.made


def _no_variant_error(slot: Slot, why: str) -> QdotError:
    failure = FailedSlot("", slot.name, slot.family.name, why)
    return QdotError(f"{failure}. Nothing is exported. {CHANGE.format(slot.name)}")


@dataclass(frozen=True)
class _Candidate(Generic[Made]):
    problem: Problem
    known_by: str
    made: Made


@dataclass
class _WorkerState(Generic[Made]):
    """The state of a worker process: its task, and the fingerprints of the problems that exist already."""

    order: Order
    slot: Slot
    work: Work[Made]
    seen: set[str]


def _draw_candidate(state: _WorkerState[Made], number: int) -> _Candidate[Made] | str | None:
    """Return a problem with the result of `work`, or a message if it fails, or None if it exists already.

    A process handles its numbers in ascending order. If two numbers give the same problem, the caller therefore
    receives the one with a result first.
    """
    order, slot = state.order, state.slot
    generate = partial(slot.problem, order.assignment.secret, f"bank/{number}")  # no student's identifier has a slash
    attempt_result = attempt(generate, certify_by(order.failures))
    if isinstance(attempt_result, str):
        return attempt_result
    problem = attempt_result[0]
    fingerprint = repr(as_json(digests(problem)))
    if fingerprint in state.seen:
        return None
    state.seen.add(fingerprint)
    return _Candidate(problem, fingerprint, state.work(order, slot, problem))
