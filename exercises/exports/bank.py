"""A bank of problems: several certified variants of each problem, the same at every export."""

from collections.abc import Callable, Generator
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import Generic, TypeVar

from qdot.exercises.assignment.assignment import Slot
from qdot.exercises.assignment.draws import CHANGE_ADVICE, FailedSlot, Variant, certify_with, try_draw
from qdot.exercises.assignment.redrawn import MAX_DRAWS
from qdot.exercises.common.errors import QdotError, count_noun
from qdot.exercises.common.json_form import as_json
from qdot.exercises.common.parallel import keep_state, map_in_order
from qdot.exercises.exports.export_format import ExportRequest
from qdot.exercises.families.base import describe_variation
from qdot.exercises.problem.problem import Problem
from qdot.exercises.problem.record import compute_digests

WorkResult = TypeVar("WorkResult")

MAX_PROBLEMS_PER_VARIANT = 10
"""Maximum number of problems to generate for each variant, if a family has few that differ."""


Work = Callable[[ExportRequest, Slot, Problem], WorkResult]
"""A function that converts a problem for an export. It must belong to a module, to be pickled for other processes."""


def iterate_bank(order: ExportRequest) -> Generator[Variant, None, None]:
    """Yield the variants of every slot in turn. A bank of 50 variants begins with the variants of a bank of 20.

    They are generated from the assignment's secret, and nobody can regenerate them without it. Students get the same
    problems only by chance. Problems that fail their certificate are skipped. Raises QdotError if none passes.
    """
    for variant, _ in process_bank(order, _ignore_problem):
        yield variant


def process_bank(order: ExportRequest, work: Work[WorkResult]) -> Generator[tuple[Variant, WorkResult], None, None]:
    """Yield the variants of a bank, each with the result of `work`.

    `work` runs in the process that has generated and certified the problem. In this way, each arm is derived only once,
    and the processes share the work evenly.
    """
    for slot in order.assignment.slots:
        count, failures = 0, list[str]()
        for problem, work_result in _iterate_distinct_problems(order, slot, work, failures):
            count += 1
            order.on_step()
            yield Variant(slot, count, problem), work_result
        if not count:
            raise _make_no_variant_error(slot, failures[0])
        if failures:
            order.report(
                f"{slot.name}: {count_noun(len(failures), 'generated problem')} failed the certificate and "
                f"{'was' if len(failures) == 1 else 'were'} replaced; the first: {failures[0]}"
            )
        if count < order.variant_count:
            number = "one different problem" if count == 1 else f"{count} different problems"
            variation_words = describe_variation(slot.family, slot.variation)
            order.report(
                f"{slot.name}: {slot.family.name} has only {number} ({variation_words}), not {order.variant_count}"
            )
        for _ in range(order.variant_count - count):
            order.on_step()


def _ignore_problem(order: ExportRequest, slot: Slot, problem: Problem) -> None:
    """Return None: the `work` of a bank without further results."""


def _iterate_distinct_problems(
    order: ExportRequest, slot: Slot, work: Work[WorkResult], failure_messages: list[str]
) -> Generator[tuple[Problem, WorkResult], None, None]:
    """Yield distinct problems that pass their certificate.

    For each problem that fails its certificate, append a message to `failure_messages`.
    """
    seen_fingerprints: set[str] = set()
    tried_count = 0
    while (
        len(seen_fingerprints) < order.variant_count
        and tried_count < MAX_PROBLEMS_PER_VARIANT * order.variant_count
        and (seen_fingerprints or len(failure_messages) < MAX_DRAWS)
    ):
        numbers = range(tried_count, tried_count + order.variant_count - len(seen_fingerprints))
        tried_count = numbers.stop
        state = _WorkerState(order.without_callbacks, slot, work, set(seen_fingerprints))
        with closing(map_in_order(_generate_candidate, numbers, order.jobs, keep_state, (state,))) as candidates:
            for candidate in candidates:
                if isinstance(candidate, str):
                    failure_messages.append(candidate)
                elif candidate is not None and candidate.fingerprint not in seen_fingerprints:
                    seen_fingerprints.add(candidate.fingerprint)
                    yield candidate.problem, candidate.work_result


def _make_no_variant_error(slot: Slot, reason: str) -> QdotError:
    failure = FailedSlot("", slot.name, slot.family.name, reason)
    return QdotError(f"{failure}. Nothing is exported. {CHANGE_ADVICE.format(slot.name)}")


@dataclass(frozen=True)
class _Candidate(Generic[WorkResult]):
    problem: Problem
    fingerprint: str
    work_result: WorkResult


@dataclass
class _WorkerState(Generic[WorkResult]):
    """The state of a worker process: its task, and the fingerprints of the problems that exist already."""

    order: ExportRequest
    slot: Slot
    work: Work[WorkResult]
    known_fingerprints: set[str]


def _generate_candidate(state: _WorkerState[WorkResult], number: int) -> _Candidate[WorkResult] | str | None:
    """Return a problem with the result of `work`, or a message if it fails, or None if it exists already.

    A process handles its numbers in ascending order. If two numbers give the same problem, the caller therefore
    receives the one with a result first.
    """
    order, slot = state.order, state.slot
    generate = partial(slot.problem, order.assignment.secret, f"bank/{number}")  # no student's identifier has a slash
    attempt_result = try_draw(generate, partial(certify_with, order.find_failures))
    if isinstance(attempt_result, str):
        return attempt_result
    problem = attempt_result[0]
    fingerprint = repr(as_json(compute_digests(problem)))
    if fingerprint in state.known_fingerprints:
        return None
    state.known_fingerprints.add(fingerprint)
    return _Candidate(problem, fingerprint, state.work(order, slot, problem))
