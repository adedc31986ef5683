"""What mistakes of the catalogue make of an answer, written out, for platforms that compare with given answers.

Each is proved to be wrong, by the same comparison that grades, and differs from the others.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache
from itertools import chain as chained
from itertools import islice

import numpy as np
import sympy as sp
from sympy.polys.polyerrors import BasePolynomialError

from qdot.exercises.answers import ConditionSet, Number
from qdot.exercises.arm import classification
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive, structure
from qdot.exercises.arm.derivation_graph import RESULT, Change, as_formulas, formulas, numbers
from qdot.exercises.arm.singularity import Component
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.expression import read
from qdot.exercises.formula.identity import READABLE, Domain, compare_entries
from qdot.exercises.formula.text import text_of
from qdot.exercises.mistakes.base import Mistake
from qdot.exercises.mistakes.catalogue import Wrong, mistaken_answers, wrong_answers
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.problem.problem import OneOfSeveral, Part, Problem
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.results import is_derived, result
from qdot.exercises.quizzes.wrong import MOST_JOINTS, NO_NUMBER, differ, in_formulas, tidy_entry

POINTS = 5
LONGEST = 1500
"""Characters of a wrong answer, all entries together; a longer one is left out."""
LONGEST_RAW = 20_000
"""Characters before it is put into its shortest form, which would take too long beyond."""
LEAST = 1e-9
"""Answers that are smaller are zero, which is nobody's mistake."""
TRIED = 3
"""So many times as many mistakes as are wanted are written out, as some turn out too long."""
CLEARLY = 3
"""So many times what a number may be off, a wrong one is off at least."""


@dataclass(frozen=True)
class Known:
    """A wrong answer: the mistake and its sentence, the answer, and which of its entries are right nevertheless."""

    mistake: str
    title: str
    says: str
    answer: sp.Matrix | tuple[Component, ...]
    equal: tuple[bool, ...] = ()


def known_wrong(problem: Problem, part: Part, most: int) -> tuple[Known, ...]:
    """Return at most so many wrong answers to a part, the likely ones first, each by another mistake."""
    if part.answer.is_a_set:
        return tuple(_sets(problem, part))[:most]
    if not is_derived(part):
        return ()
    if part.answer.units_due:
        return tuple(_numbers(problem, part, most))
    if not part.answer.is_formulas:
        return ()
    which = part.details if isinstance(part.details, OneOfSeveral) else None
    subject = _Subject(structure(problem.chain).chain, part.kind, which, part)
    slips = (_slip(subject, index) for index in range(min(TRIED * most, len(_wrongs(subject)))))
    return tuple(islice(_filled(problem, part, filter(None, slips)), most))


def domain_of(problem: Problem) -> Domain:
    """Return what each open symbol of a problem may be; its references hold no length that is given as a number."""
    kinds = {"length": "length", "angle": "angle", "joint rad": "angle"}
    roles: dict[str, str | float | Fraction] = {}
    for name, info in problem.symbols().items():
        if info.value is None:
            kind = f"joint {info.unit}" if info.role == "joint" else info.role
            roles[name] = kinds.get(kind, "signed")
    return Domain(roles)


def _that_differ(right: np.ndarray, wrongs: Iterable[Wrong]) -> Iterator[Wrong]:
    """Yield a wrong answer of each mistake, in numbers: finite, of the right shape, and none that was there before."""
    seen, mistakes = [right], set[str]()
    for wrong in wrongs:
        answer = wrong.answer
        if wrong.mistake.name in mistakes or answer.shape != right.shape or not np.isfinite(answer).all():
            continue
        if np.abs(answer).max() > LEAST and all(differ(answer, other) for other in seen):
            seen.append(answer)
            mistakes.add(wrong.mistake.name)
            yield wrong


# --- formulas ---


@dataclass(frozen=True)
class _Subject:
    """A question about a structure; `which` tells those apart that ask for another of its results."""

    generic: Chain
    kind: str
    which: OneOfSeveral | None
    part: Part = field(compare=False)


@dataclass(frozen=True)
class _Slip:
    """A mistake on a structure, and what it makes of the answer there; None of it where it only alters the result."""

    mistake: Mistake
    says: str
    answer: sp.Matrix | None
    changes: tuple[Change, ...] = ()


@lru_cache(maxsize=512)
def _wrongs(subject: _Subject) -> tuple[Wrong, ...]:
    """Return the mistakes that change the answer, in numbers."""
    generic, part = subject.generic, subject.part
    roles = classification.domain_of(generic).roles
    names = {*roles, *(rate.name for rate in generic.rates), *generic.task, *part.symbols}
    drawn = Domain(roles).sample(names, READABLE + POINTS, Stream(f"known/{subject.kind}"))
    w = numbers(generic, {name: values[READABLE:] for name, values in drawn.items()})
    return tuple(_that_differ(result(w, part), wrong_answers(w, part)))


@lru_cache(maxsize=2048)
def _slip(subject: _Subject, index: int) -> _Slip | None:
    """Return what a mistake makes of an answer in formulas, None where it can't be written."""
    generic, part, wrong = subject.generic, subject.part, _wrongs(subject)[index]
    changes = wrong.working.changes
    if all(stage == RESULT for stage, _ in changes):
        return _Slip(wrong.mistake, wrong.sentence, None, tuple(change for _, change in changes))
    if generic.n > MOST_JOINTS and QUESTIONS[part.kind].is_made_of_minors:
        return None  # it would take minutes
    formulas = as_formulas(result(in_formulas(generic).with_mistakes(dict(changes)), part))
    if formulas.has(*NO_NUMBER) or len(str(formulas.tolist())) > LONGEST_RAW:
        return None
    try:
        return _Slip(wrong.mistake, wrong.sentence, formulas.applyfunc(tidy_entry))
    except (TypeError, ValueError, BasePolynomialError):  # no trigonometric polynomial
        return None


def _filled(problem: Problem, part: Part, slips: Iterable[_Slip]) -> Iterator[Known]:
    """Yield the wrong answers with an arm's own numbers, those that are short and prove to be wrong."""
    reference, fill = _reference(part), derive(problem.chain).fill_matrix
    for slip in slips:
        if slip.answer is None:
            entries = np.array(reference.tolist(), dtype=object)[..., None]
            for change in slip.changes:
                entries = change(formulas(problem.chain), entries)
            answer = as_formulas(entries)
        else:
            answer = fill(slip.answer)
        if answer.shape == reference.shape and len(str(answer.tolist())) <= LONGEST:
            equal = same_entries(problem, answer, reference)
            if not all(equal):
                yield Known(slip.mistake.name, slip.mistake.title, slip.says, answer, equal)


def same_entries(problem: Problem, one: sp.Matrix, other: sp.Matrix) -> tuple[bool, ...]:
    """Tell of each entry, row by row, whether two matrices are the same function there, as grading would."""
    domain = domain_of(problem)
    left, right = ([read(text_of(entry), domain.roles) for entry in matrix] for matrix in (one, other))
    return compare_entries(left, right, domain, f"known/{problem.id}").equal


def _reference(part: Part) -> sp.Matrix:
    return part.answer.as_matrix()


# --- numbers and sets ---


def _numbers(problem: Problem, part: Part, most: int) -> Iterator[Known]:
    values = sample_configurations(
        problem.chain, part, domain_of(problem), POINTS, Stream(f"known/{problem.id}/{part.name}")
    )
    w = numbers(problem.chain, values)
    wrongs = _that_differ(result(w, part), wrong_answers(w, part))
    due = [float(value) for value in part.answer.as_matrix()]
    room = room_of(part)
    seen = [due]
    for wrong in wrongs:
        typed = [float(value) for value in wrong.answer[..., 0].ravel()]
        if all(_is_off(typed, other, room) for other in seen) and len(seen) <= most:
            seen.append(typed)
            near = [abs(value - right) <= allowed for value, right, allowed in zip(typed, due, room, strict=True)]
            shown = sp.Matrix([sp.Rational(f"{value:.6g}") for value in typed])
            yield Known(wrong.mistake.name, wrong.mistake.title, wrong.sentence, shown, tuple(near))


def _is_off(found: list[float], other: list[float], room: list[float]) -> bool:
    return any(abs(a - b) > CLEARLY * allowed for a, b, allowed in zip(found, other, room, strict=True))


def room_of(part: Part) -> list[float]:
    """Return what each number of an answer may be off, as grading allows."""
    return part.of(Number).room(part.rounding)


def _sets(problem: Problem, part: Part) -> Iterator[Known]:
    """Yield wrong sets, of which no two list the same conditions."""
    answer = part.of(ConditionSet)
    seen, mistakes = [_conditions(answer)], set[str]()
    for mistake, slip in mistaken_answers(problem.chain, part):
        if isinstance(slip.answer, ConditionSet) and mistake.name not in mistakes:
            conditions = _conditions(slip.answer)
            if conditions and conditions not in seen:
                seen.append(conditions)
                mistakes.add(mistake.name)
                says = mistake.sentence(slip.words)
                yield Known(mistake.name, mistake.title, says, slip.answer.components)


def _conditions(answer: ConditionSet) -> frozenset[str]:
    """Return the pieces of a set with angles in one turn, so that pi and -pi are the same."""
    turned = [
        component
        if component.solutions is None
        else replace(
            component,
            solutions=tuple((joint, tuple(map(in_one_turn, values))) for joint, values in component.solutions),
        )
        for component in answer.components
    ]
    return frozenset(chained.from_iterable(component.pieces() for component in turned))


def in_one_turn(angle: sp.Expr) -> sp.Expr:
    """Return an angle that is a share of pi in (-pi, pi], others as they are."""
    turns = angle / (2 * sp.pi)
    if not turns.is_Rational:
        return angle
    share = turns % 1
    return 2 * sp.pi * (share if share <= sp.Rational(1, 2) else share - 1)
