"""Generate a bank of problems: several certified variants of each problem, the same at every export."""

from collections.abc import Callable, Generator
from contextlib import closing
from functools import partial
from typing import Generic, NamedTuple, TypeVar

from qdot.exercises.assignment.assignment import Slot
from qdot.exercises.assignment.certified_problems import (
    CHANGE_ADVICE,
    FailedSlot,
    Variant,
    certify_with,
    generate_and_certify,
)
from qdot.exercises.assignment.replacements import MAX_SEEDS
from qdot.exercises.common.errors import QdotError, Reason, count_noun
from qdot.exercises.common.json_form import to_jsonable
from qdot.exercises.common.parallel import map_in_order, return_state
from qdot.exercises.exports.export_format import ExportRequest
from qdot.exercises.families.family import describe_variation
from qdot.exercises.problem.problem import Problem
from qdot.exercises.problem.record import compute_digests

Conversion = TypeVar("Conversion")

MAX_PROBLEMS_PER_VARIANT = 10
"""Maximum number of problems to generate for each variant. The limit matters if a family has few different problems."""

ConvertProblem = Callable[[ExportRequest, Slot, Problem], Conversion]
"""A function that converts a problem for an export. It must be defined in a module, so that other processes can
unpickle it."""
_WorkerState = tuple[ExportRequest, Slot, ConvertProblem[Conversion], set[str]]
"""The state of a worker process: the request, the slot, the function that converts problems, and the fingerprints of
existing problems."""


class _Candidate(NamedTuple, Generic[Conversion]):
    """A generated problem, its fingerprint (equal for equal problems), and the result of converting it."""

    problem: Problem
    fingerprint: str
    conversion: Conversion


def iterate_bank(request: ExportRequest) -> Generator[Variant, None, None]:
    """Yield the variants of every slot in turn. A bank of 50 variants begins with the variants of a bank of 20.

    The variants are generated from the assignment's secret, and nobody can regenerate them without the secret. A
    student's own problem equals one of them only by chance. Problems that fail their certificate are skipped. Raises
    QdotError if all problems of a slot fail.
    """
    for variant, _ in convert_bank(request, _ignore_problem):
        yield variant


def convert_bank(
    request: ExportRequest, convert: ConvertProblem[Conversion]
) -> Generator[tuple[Variant, Conversion], None, None]:
    """Yield the variants of a bank, each with the result of `convert`.

    `convert` runs in the process that has generated and certified the problem. So the formulas of each arm are derived
    only once, and the processes share the work evenly.
    """
    for slot in request.assignment.slots:
        count, failures = 0, list[str]()
        for problem, conversion in _iterate_distinct_problems(request, slot, convert, failures):
            count += 1
            request.on_step()
            yield Variant(slot, count, problem), conversion
        if not count:
            failed_slot = FailedSlot("", slot.name, slot.family.name, failures[0])
            raise QdotError(f"{failed_slot}. Nothing is exported. {CHANGE_ADVICE.format(slot.name)}")
        if failures:
            request.report(
                f"{slot.name}: {count_noun(len(failures), 'generated problem')} failed the certificate and "
                f"{'was' if len(failures) == 1 else 'were'} replaced; the first: {failures[0]}"
            )
        if count < request.variant_count:
            problems_text = "one different problem" if count == 1 else f"{count} different problems"
            variation_text = describe_variation(slot.family, slot.variation)
            request.report(
                f"{slot.name}: {slot.family.name} has only {problems_text} ({variation_text}), "
                f"not {request.variant_count}"
            )
        for _ in range(request.variant_count - count):  # so that the progress is complete
            request.on_step()


def _ignore_problem(request: ExportRequest, slot: Slot, problem: Problem) -> None:
    """Return None. Use this function as `convert` if only the variants are needed."""


def _iterate_distinct_problems(
    request: ExportRequest, slot: Slot, convert: ConvertProblem[Conversion], failure_messages: list[str]
) -> Generator[tuple[Problem, Conversion], None, None]:
    """Yield different problems that pass their certificate, each with the result of `convert`.

    For each problem that fails its certificate, append a message to `failure_messages`.
    """
    seen_fingerprints: set[str] = set()
    tried_count = 0
    while (
        len(seen_fingerprints) < request.variant_count
        and tried_count < MAX_PROBLEMS_PER_VARIANT * request.variant_count
        and (seen_fingerprints or len(failure_messages) < MAX_SEEDS)
    ):
        numbers = range(tried_count, tried_count + request.variant_count - len(seen_fingerprints))
        tried_count = numbers.stop
        state = request.without_callbacks, slot, convert, set(seen_fingerprints)
        with closing(
            map_in_order(_generate_candidate, numbers, request.jobs, setup=return_state, arguments=(state,))
        ) as candidates:
            for candidate in candidates:
                if isinstance(candidate, Reason):
                    failure_messages.append(candidate)
                elif candidate is not None and candidate.fingerprint not in seen_fingerprints:
                    seen_fingerprints.add(candidate.fingerprint)
                    yield candidate.problem, candidate.conversion


def _generate_candidate(state: _WorkerState[Conversion], number: int) -> _Candidate[Conversion] | Reason | None:
    """Return the bank's problem `number`, the reason why it fails its certificate, or None if an equal problem exists.

    Each process handles ascending numbers, so the first of several equal problems is the one that is returned.
    """
    request, slot, convert, known_fingerprints = state
    student = f"bank/{number}"  # no student has this identifier, because identifiers contain no slash
    generate = partial(slot.generate_problem, request.assignment.secret, student)
    result = generate_and_certify(generate, partial(certify_with, request.find_failures))
    if isinstance(result, Reason):
        return result
    problem, _ = result
    fingerprint = repr(to_jsonable(compute_digests(problem)))
    if fingerprint in known_fingerprints:
        return None
    known_fingerprints.add(fingerprint)
    return _Candidate(problem, fingerprint, convert(request, slot, problem))
