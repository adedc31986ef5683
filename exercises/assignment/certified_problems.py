"""Generate the problems of students, and replace a problem that fails its certificate by one with another seed.

A certificate is the result of independent checks of a problem's answers (see `verify`). The seeds that are tried for a
problem depend only on the assignment and redrawn.csv (see `replacements`), and not on other students' problems.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from typing import Generic, TypeVar

from qdot.exercises.assignment.assignment import Assignment, Slot
from qdot.exercises.assignment.replacements import MAX_SEEDS, REPLACEMENTS_FILE, Replacement, write_replacements
from qdot.exercises.common.errors import QdotError, Reason, count_noun
from qdot.exercises.common.parallel import map_in_order, return_state
from qdot.exercises.problem.problem import Problem
from qdot.exercises.verify.certificate import FULL_RANK

Record = TypeVar("Record")

CHANGE_ADVICE = "Change the questions, the variation or the family of {} in assignment.toml"
"""Advice for the staff if a problem fails with every seed."""


class UncertifiedProblem(QdotError):
    """Raised if a problem does not pass its certificate, but a problem with another seed may pass."""


FailureFinder = Callable[[Problem], Sequence[str]]
"""A function that returns what is wrong with a problem. It is sent to other processes, so it must be defined at the
top level of a module."""
RecordMaker = Callable[[Problem], Record]
"""A function that certifies a problem and returns a record of it, or raises UncertifiedProblem."""


@dataclass(frozen=True)
class CertifiedProblem(Generic[Record]):
    """A problem that passed its certificate, with the number of its seed and the record of its certificate.

    `first_failure` says why the first problem failed, "" if this is the first problem.
    """

    problem: Problem
    seed_number: int
    record: Record
    first_failure: str = ""


@dataclass(frozen=True)
class FailedSlot:
    """A slot in which a problem failed with every seed; `first_failure` says why the first problem failed.

    `student` is empty if the problem is for a bank.
    """

    student: str
    slot: str
    family: str
    first_failure: str

    def __str__(self) -> str:
        prefix = f"{self.student}: " if self.student else ""
        name = f"{prefix}{self.slot} ({self.family})"
        return f"{name}: none of {MAX_SEEDS} attempts gave a valid problem. The first one failed: {self.first_failure}"


@dataclass(frozen=True)
class Variant:
    """A problem of a bank: its slot in the assignment, and its number within the slot, from 1."""

    slot: Slot
    number: int
    problem: Problem

    @property
    def key(self) -> str:
        """A short name that is unique in the assignment and permanent, as in "p1-007"."""
        return f"{self.slot.name}-{self.number:03d}"


def raise_failures(problem: Problem, failures: Sequence[str]) -> None:
    """Raise an error if there are failures: QdotError if every seed would fail like this, else UncertifiedProblem."""
    if failures and failures[0].startswith(FULL_RANK):
        raise QdotError(
            f"the problem {problem.id} failed its certificate, so it can't be used: {failures[0]}; choose another task"
        )
    if failures:
        raise UncertifiedProblem(failures[0])


def certify_with(find_failures: FailureFinder, problem: Problem) -> None:
    """Certify a problem in which `find_failures` finds nothing wrong. Raises UncertifiedProblem or QdotError."""
    raise_failures(problem, find_failures(problem))


def require_certified(problem: Problem, find_failures: FailureFinder) -> Problem:
    """Return a problem if it passes its certificate. Raises QdotError otherwise.

    No other seed is tried, because the problem's id contains the seed.
    """
    try:
        certify_with(find_failures, problem)
    except UncertifiedProblem as error:
        raise QdotError(f"{problem.id}: the problem failed its certificate: {error}; please report it") from None
    return problem


def generate_and_certify(
    generate: Callable[[], Problem], certify: RecordMaker[Record]
) -> tuple[Problem, Record] | Reason:
    """Generate and certify a problem; return it with its record, or return the reason why it can't be used.

    An internal error of qdot is returned as a reason, so that it affects only this problem. Raises QdotError if the
    problem would fail with every seed. OSError and MemoryError are not caught.
    """
    try:
        problem = generate()
    except (QdotError, RuntimeError) as error:  # the questions do not apply to this arm, or the derivation failed
        return Reason(error)
    except (OSError, MemoryError):
        raise
    except Exception as error:
        return Reason(describe_internal_error(error))
    try:
        return problem, certify(problem)
    except UncertifiedProblem as error:
        return Reason(error)
    except (QdotError, OSError, MemoryError):
        raise
    except Exception as error:
        return Reason(describe_internal_error(error))


def describe_internal_error(error: Exception) -> str:
    """Return the message about an internal error of qdot."""
    return f"qdot itself failed: {type(error).__name__}: {error}; please report it"


def generate_certified_problem(
    assignment: Assignment, slot: Slot, student: str, certify: RecordMaker[Record]
) -> CertifiedProblem[Record] | FailedSlot:
    """Return a student's first problem that passes its certificate; the seed in redrawn.csv is tried first."""
    recorded_number, first_failure = assignment.seed_number_of(slot, student), ""
    for number in (recorded_number, *(n for n in range(1, MAX_SEEDS + 1) if n != recorded_number)):
        result = generate_and_certify(partial(slot.generate_problem, assignment.secret, student, number), certify)
        if not isinstance(result, Reason):
            problem, record = result
            return CertifiedProblem(problem, number, record, first_failure)
        first_failure = first_failure or result
    return FailedSlot(student, slot.name, slot.family.name, first_failure)


# --- a whole class ---


@dataclass(frozen=True)
class StudentProblems(Generic[Record]):
    """The problems of a student by slot, in order; if any slot failed (`failed_slots`), the student has no notebook."""

    student: str
    certified_problems: dict[str, CertifiedProblem[Record]]
    failed_slots: tuple[FailedSlot, ...] = ()

    def find_new_replacements(self, assignment: Assignment) -> dict[str, Replacement]:
        """Map each slot to its replaced problem, except for problems that redrawn.csv lists already."""
        return {
            slot.name: Replacement(slot.family.name, certified_problem.seed_number, certified_problem.first_failure)
            for slot in assignment.slots
            if (certified_problem := self.certified_problems.get(slot.name))
            and certified_problem.seed_number != assignment.seed_number_of(slot, self.student)
        }


def generate_student_problems(
    assignment: Assignment, student: str, certify: RecordMaker[Record]
) -> StudentProblems[Record]:
    """Generate all problems of a student. If one fails, the others are still generated, so that all are reported."""
    results = [(slot.name, generate_certified_problem(assignment, slot, student, certify)) for slot in assignment.slots]
    certified_problems = {name: result for name, result in results if isinstance(result, CertifiedProblem)}
    failed_slots = tuple(result for _, result in results if isinstance(result, FailedSlot))
    return StudentProblems(student, certified_problems, failed_slots)


def record_replacements(assignment: Assignment, student: str, replacements: Mapping[str, Replacement]) -> Assignment:
    """Record a student's replaced problems (by slot) in redrawn.csv, and return the assignment with them."""
    new_replacements = {(student, slot): replacement for slot, replacement in replacements.items()}
    all_replacements = {**assignment.replacements, **new_replacements}
    write_replacements(assignment.folder, all_replacements)
    return replace(assignment, replacements=all_replacements)


def certify_class(
    assignment: Assignment, students: Sequence[str], find_failures: FailureFinder, jobs: int,
    on_step: Callable[[], None],
) -> tuple[Assignment, list[FailedSlot]]:  # fmt: skip
    """Find certified problems for some students, and record the replaced ones.

    Return the assignment with the replaced problems, and the slots that failed. `on_step` is called after every
    student. Raises QdotError.
    """
    all_failed_slots: list[FailedSlot] = []
    state = assignment, partial(certify_with, find_failures)
    with closing(map_in_order(_certify_student, students, jobs, setup=return_state, arguments=(state,))) as results:
        for student, (replacements, failed_slots) in zip(students, results, strict=True):
            if replacements:
                assignment = record_replacements(assignment, student, replacements)
            all_failed_slots += failed_slots
            on_step()
    return assignment, all_failed_slots


def _certify_student(
    state: tuple[Assignment, RecordMaker[None]], student: str
) -> tuple[dict[str, Replacement], tuple[FailedSlot, ...]]:
    """Return a student's new replacements by slot, and the slots that failed.

    `state` contains the assignment and the function that certifies its problems.
    """
    assignment, certify = state
    student_problems = generate_student_problems(assignment, student, certify)
    return student_problems.find_new_replacements(assignment), student_problems.failed_slots


def describe_replacements(old_assignment: Assignment, new_assignment: Assignment) -> list[str]:
    """Return a message to the staff about newly replaced problems, as a list of at most one line."""
    old_replacements, new_replacements = old_assignment.replacements, new_assignment.replacements
    new_count = sum(old_replacements.get(slot) != replacement for slot, replacement in new_replacements.items())
    if not new_count:
        return []
    problems = count_noun(new_count, "problem")
    advice = f"store {new_assignment.folder / REPLACEMENTS_FILE} together with assignment.toml"
    return [f"{problems} did not pass the certificate at first and had to be regenerated; {advice}"]


def raise_failed_slots(assignment: Assignment, failed_slots: Sequence[FailedSlot]) -> None:
    """Raise QdotError if slots failed. The message says which students are left out, and which problems to change."""
    if not failed_slots:
        return
    students = list(dict.fromkeys(failure.student for failure in failed_slots))
    verb = "is" if len(students) == 1 else "are"
    others_note = "" if len(students) == len(assignment.roster) else "; all others have their notebooks"
    slots = " and ".join(sorted({failure.slot for failure in failed_slots}))
    raise QdotError(
        f"{len(students)} of {count_noun(len(assignment.roster), 'student')} {verb} left out "
        f"({', '.join(students)}){others_note}. {CHANGE_ADVICE.format(slots)}, and run the same command again"
    )
