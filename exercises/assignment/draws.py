"""Problems drawn until one passes its certificate; where no draw does, what could be asked instead is tried.

A student's problem has a few draws, each with a seed of its own, in an order that depends on nothing but the assignment
and redrawn.csv. So nobody's problem holds up, or changes, anybody else's.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from typing import Generic, TypeVar

from qdot.exercises.arm.chain import CONVENTIONS
from qdot.exercises.assignment.assignment import Assignment, Slot
from qdot.exercises.assignment.redrawn import DRAWS, REDRAWN, Redraw, write_redrawn
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.input_file import toml_text
from qdot.exercises.common.parallel import ordered_map
from qdot.exercises.common.variation import STEPS
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import listing_of
from qdot.exercises.problem.problem import Problem
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.verify import FULL_RANK

Vouched = TypeVar("Vouched")

TRIED_WITH = 3
"""Students with whose problems it is tried what could be asked instead."""
TRIED_FAMILIES, NAMED_FAMILIES = 6, 2
"""Families that are tried in the place of one, and how many of those that can be asked are named."""


class Uncertified(QdotError):
    """A problem does not pass its certificate, and another draw may."""


Failures = Callable[[Problem], Sequence[str]]
"""Returns what is wrong with a problem; it is handed to other processes, so it is a function of a module."""
Vouch = Callable[[Problem], Vouched]
"""Returns what is kept of a problem that passes its certificate. Raises Uncertified for one that does not."""


@dataclass(frozen=True)
class Drawn(Generic[Vouched]):
    """A problem that passed, which draw it is, and what was wrong with the first that was tried."""

    problem: Problem
    draw: int
    vouched: Vouched
    why: str = ""


@dataclass(frozen=True)
class GivenUp:
    """A place of the assignment for which no draw of a student's passed, and what was wrong with the first.

    `student` is empty where it was to be for a bank.
    """

    student: str
    slot: str
    family: str
    why: str

    def __str__(self) -> str:
        whose = f"{self.student}: " if self.student else ""
        return f"{whose}{self.slot} ({self.family}): none of {DRAWS} draws can be asked. The first: {self.why}"


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


def check(problem: Problem, failed: Sequence[str]) -> None:
    """Raise Uncertified where a problem has failed, and QdotError where its arm would, whatever was drawn."""
    if failed and failed[0].startswith(FULL_RANK):
        raise QdotError(
            f"the problem {problem.id} failed its own certificate and is not handed out: {failed[0]}; name another task"
        )
    if failed:
        raise Uncertified(failed[0])


def vouching(failures: Failures) -> Vouch[None]:
    """Return what vouches for a problem in which nothing is found wrong."""
    return partial(_vouch, failures)


def _vouch(failures: Failures, problem: Problem) -> None:
    check(problem, failures(problem))


def certified(problem: Problem, failures: Failures) -> Problem:
    """Return a problem that has no other draws, if nothing is found wrong in it. Raises QdotError."""
    try:
        check(problem, failures(problem))
    except Uncertified as error:
        raise QdotError(f"{problem.id}: the problem does not pass its certificate: {error}; please report it") from None
    return problem


def attempt(make: Callable[[], Problem], vouch: Vouch[Vouched]) -> tuple[Problem, Vouched] | str:
    """Return a problem and what is kept of it, or why it can't be asked, as there is nothing to ask or it fails.

    A failure of qdot's own is one problem's, too: nobody else is to wait for it. Raises QdotError where no other draw
    would do better, and whatever the machine lacks.
    """
    try:
        problem = make()
    except (QdotError, RuntimeError) as error:  # of this arm there is nothing to ask
        return str(error)
    except (OSError, MemoryError):
        raise
    except Exception as error:
        return own_failure(error)
    try:
        return problem, vouch(problem)
    except Uncertified as error:
        return str(error)
    except (QdotError, OSError, MemoryError):
        raise
    except Exception as error:
        return own_failure(error)


def own_failure(error: Exception) -> str:
    """Return how it is told that qdot itself failed on a problem."""
    return f"qdot itself failed: {type(error).__name__}: {error}; please report it"


def draw(assignment: Assignment, slot: Slot, student: str, vouch: Vouch[Vouched]) -> Drawn[Vouched] | GivenUp:
    """Return the first draw of a student's problem that passes, beginning with the one that the student has."""
    first, why = assignment.draw_of(slot, student), ""
    for number in (first, *(other for other in range(1, DRAWS + 1) if other != first)):
        made = attempt(partial(slot.problem, assignment.secret, student, number), vouch)
        if not isinstance(made, str):
            return Drawn(made[0], number, made[1], why)
        why = why or made
    return GivenUp(student, slot.name, slot.family.name, why)


# --- a whole class ---


@dataclass(frozen=True)
class Draws(Generic[Vouched]):
    """The problems of a student by place, in order; where any is given up, the student has no notebook."""

    student: str
    drawn: dict[str, Drawn[Vouched]]
    given_up: tuple[GivenUp, ...] = ()

    def redrawn(self, assignment: Assignment) -> dict[str, Redraw]:
        """Return the draws that are others than the student had."""
        return {
            slot.name: Redraw(slot.family.name, drawn.draw, drawn.why)
            for slot in assignment.slots
            if (drawn := self.drawn.get(slot.name)) and drawn.draw != assignment.draw_of(slot, self.student)
        }


def draws_of(assignment: Assignment, student: str, vouch: Vouch[Vouched]) -> Draws[Vouched]:
    """Draw all problems of a student. Where one is given up, the others are drawn all the same, to tell of all."""
    made = {slot.name: draw(assignment, slot, student, vouch) for slot in assignment.slots}
    drawn = {name: one for name, one in made.items() if isinstance(one, Drawn)}
    return Draws(student, drawn, tuple(one for one in made.values() if isinstance(one, GivenUp)))


def recorded(assignment: Assignment, student: str, redrawn: Mapping[str, Redraw]) -> Assignment:
    """Return the assignment with a student's new draws, which are in redrawn.csv from now on."""
    changed = {**assignment.redrawn, **{(student, place): redraw for place, redraw in redrawn.items()}}
    write_redrawn(assignment.folder, changed)
    return replace(assignment, redrawn=changed)


def settled(
    assignment: Assignment, students: Sequence[str], failures: Failures, jobs: int, each: Callable[[], None]
) -> tuple[Assignment, list[GivenUp]]:
    """Return the assignment with draws that pass for these students, and what had to be given up.

    `each` is told of every student. Raises QdotError.
    """
    given_up: list[GivenUp] = []
    with closing(ordered_map(_settle, students, jobs, _both, (assignment, failures))) as every:
        for student, redrawn, given in every:
            if redrawn:
                assignment = recorded(assignment, student, redrawn)
            given_up += given
            each()
    return assignment, given_up


def _both(assignment: Assignment, failures: Failures) -> tuple[Assignment, Failures]:
    return assignment, failures


def _settle(state: tuple[Assignment, Failures], student: str) -> tuple[str, dict[str, Redraw], tuple[GivenUp, ...]]:
    assignment, failures = state
    draws = draws_of(assignment, student, vouching(failures))
    return student, draws.redrawn(assignment), draws.given_up


def redrawn_since(before: Assignment, after: Assignment) -> list[str]:
    """Return what the staff is told of draws that are new: nothing, or one line."""
    new = [whose for whose, redraw in after.redrawn.items() if before.redrawn.get(whose) != redraw]
    if not new:
        return []
    said = "1 problem did" if len(new) == 1 else f"{len(new)} problems did"
    path = after.folder / REDRAWN
    return [f"{said} not pass the certificate at first and had to be drawn anew; keep {path} with assignment.toml"]


# --- what to take instead ---


def raise_left_out(assignment: Assignment, given_up: Sequence[GivenUp], vouch: Vouch[object]) -> None:
    """Raise QdotError where students were left out: who, and what to take instead in each place; others have theirs."""
    if not given_up:
        return
    students = list(dict.fromkeys(given.student for given in given_up))
    first = {given.slot: given for given in reversed(given_up)}
    ways = [instead(assignment, given, vouch) for _, given in sorted(first.items())]
    be = "is" if len(students) == 1 else "are"
    others = "" if len(students) == len(assignment.roster) else "; everybody else has theirs"
    raise QdotError(
        f"{len(students)} of {len(assignment.roster)} students {be} left out ({', '.join(students)}){others}. "
        f"{'. '.join(ways)}. Change assignment.toml and run the same command again"
    )


def instead(assignment: Assignment, given_up: GivenUp, vouch: Vouch[object]) -> str:
    """Return what can be asked in the place of what was given up, as was tried with the student's draws and others'."""
    slot = replace(next(slot for slot in assignment.slots if slot.name == given_up.slot), points=None)
    slot = replace(slot, decimals=(), credit=())
    others = [student.id for student in assignment.roster if student.id != given_up.student]
    students = [*filter(None, [given_up.student]), *others][:TRIED_WITH]

    def passes(tried: Slot) -> bool:
        return all(isinstance(draw(assignment, tried, student, vouch), Drawn) for student in students)

    like = _like(slot, students[0], assignment)
    ways = [*_fewer_questions(slot, passes), *_other_variation(slot, passes), *_other_families(slot, like, passes)]
    tried = f"tried for {', '.join(students)}"
    if not ways:
        return f"{slot.name}: neither fewer of its questions nor families like it can be asked instead ({tried})"
    return f"{slot.name}: take instead {', or '.join(ways)} ({tried})"


Passes = Callable[[Slot], bool]
"""Whether what a place of the assignment could be has draws that pass."""


def _fewer_questions(slot: Slot, passes: Passes) -> list[str]:
    faulty = [name for name in slot.questions if not passes(replace(slot, questions=(name,)))]
    rest = tuple(name for name in slot.questions if name not in faulty)
    if not faulty or not rest or not passes(replace(slot, questions=rest)):
        return []
    return [f"questions = {toml_text(list(rest))}, without {', '.join(faulty)}"]


def _other_variation(slot: Slot, passes: Passes) -> list[str]:
    """Return the first other step that passes; none for an instructor's robot, which has no steps."""
    steps = [step for step in STEPS if step != slot.variation and not slot.robot]
    passing = (f'variation = "{step}"' for step in steps if passes(replace(slot, variation=step)))
    return list(islice(passing, 1))


def _other_families(slot: Slot, names: Sequence[str], passes: Passes) -> list[str]:
    passing = (f'"{name}"' for name in names if passes(replace(slot, family=FAMILIES[name], robot="")))
    found = list(islice(passing, NAMED_FAMILIES))
    return [f"family = {' or '.join(found)} with the same questions"] if found else []


def _like(slot: Slot, student: str, assignment: Assignment) -> list[str]:
    """Return the families that can be asked the same questions, those with as many joints first."""
    try:
        joints = slot.problem(assignment.secret, student).chain.n
    except Exception:  # whatever it is, it has been told; the order is all that depends on it
        joints = 0
    asked = {  # what is listed is that of standard tables: whether others and short ones can be is found out by trying
        name for name in slot.questions if name in QUESTIONS and CONVENTIONS[0] in QUESTIONS[name].conventions
    }
    can = [
        name
        for name, family in FAMILIES.items()
        if name != slot.family.name and not family.varied and asked <= set(listing_of(name).questions)
    ]
    return sorted(can, key=lambda name: abs(len(listing_of(name).kinds) - joints))[:TRIED_FAMILIES]
