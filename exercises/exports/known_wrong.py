"""The wrong answers that known mistakes lead to, for platforms that compare submissions with fixed answers.

qdot's own comparison finds each of them wrong. No two of them are equal.
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
from qdot.exercises.formula.identity import READABLE, Domain, compare_entries
from qdot.exercises.formula.parser import read
from qdot.exercises.formula.sympy_text import text_of
from qdot.exercises.mistakes.base import Mistake
from qdot.exercises.mistakes.catalogue import Wrong, mistaken_answers, wrong_answers
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.problem.problem import OneOfSeveral, Part, Problem
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.results import is_derived, result
from qdot.exercises.quizzes.wrong import MOST_JOINTS, NO_NUMBER, differ, in_formulas, tidy_entry

POINTS = 5
LONGEST = 1500
"""Maximum length of a wrong answer in characters, all entries together; longer ones are left out."""
LONGEST_RAW = 20_000
"""Maximum length before simplification, which would take too long for longer ones."""
LEAST = 1e-9
"""Answers smaller than this are zero, and zero identifies no mistake."""
TRIED = 3
"""Number of mistakes to try per wrong answer, because the answers of some are too long."""
CLEARLY = 3
"""A wrong number must differ by more than this multiple of the tolerance."""


@dataclass(frozen=True)
class KnownWrongAnswer:
    """A wrong answer: the mistake behind it, the message about it, and which of its entries are correct (`equal`)."""

    mistake: str
    title: str
    says: str
    answer: sp.Matrix | tuple[Component, ...]
    equal: tuple[bool, ...] = ()


def known_wrong(problem: Problem, part: Part, most: int) -> tuple[KnownWrongAnswer, ...]:
    """Return at most `most` wrong answers to a part, each by a different mistake, the likely ones first."""
    if part.answer.is_a_set:
        return tuple(_wrong_sets(problem, part))[:most]
    if not is_derived(part):
        return ()
    if part.answer.units_due:
        return tuple(_wrong_numbers(problem, part, most))
    if not part.answer.is_formulas:
        return ()
    alternative = part.details if isinstance(part.details, OneOfSeveral) else None
    subject = _Subject(structure(problem.chain).chain, part.kind, alternative, part)
    mistakes = (_apply_mistake(subject, index) for index in range(min(TRIED * most, len(_wrong_in_numbers(subject)))))
    return tuple(islice(_for_this_arm(problem, part, filter(None, mistakes)), most))


def domain_of(problem: Problem) -> Domain:
    """Return the domain of each symbol without a value. Lengths with a value appear in references as numbers."""
    kinds = {"length": "length", "angle": "angle", "joint rad": "angle"}
    roles: dict[str, str | float | Fraction] = {}
    for name, info in problem.symbols().items():
        if info.value is None:
            kind = f"joint {info.unit}" if info.role == "joint" else info.role
            roles[name] = kinds.get(kind, "signed")
    return Domain(roles)


def _distinct_wrong_answers(right: np.ndarray, wrongs: Iterable[Wrong]) -> Iterator[Wrong]:
    """Yield one numeric wrong answer per mistake: finite, of the expected shape, and different from earlier ones."""
    accepted, mistake_names = [right], set[str]()
    for wrong in wrongs:
        answer = wrong.answer
        if wrong.mistake.name in mistake_names or answer.shape != right.shape or not np.isfinite(answer).all():
            continue
        if np.abs(answer).max() > LEAST and all(differ(answer, earlier) for earlier in accepted):
            accepted.append(answer)
            mistake_names.add(wrong.mistake.name)
            yield wrong


# --- formulas ---


@dataclass(frozen=True)
class _Subject:
    """A question about a structure; `which` distinguishes questions of one kind that ask for different results."""

    generic: Chain
    kind: str
    which: OneOfSeveral | None
    part: Part = field(compare=False)


@dataclass(frozen=True)
class _GenericMistake:
    """A mistake on a structure and the answer that it leads to.

    If the mistake only alters the final result, `answer` is None, and `changes` are to be applied to the reference.
    """

    mistake: Mistake
    says: str
    answer: sp.Matrix | None
    changes: tuple[Change, ...] = ()


@lru_cache(maxsize=512)
def _wrong_in_numbers(subject: _Subject) -> tuple[Wrong, ...]:
    """Return the numeric wrong answers of the mistakes that change the answer."""
    generic, part = subject.generic, subject.part
    roles = classification.domain_of(generic).roles
    names = {*roles, *(rate.name for rate in generic.rates), *generic.task, *part.symbols}
    samples = Domain(roles).sample(names, READABLE + POINTS, Stream(f"known/{subject.kind}"))
    working = numbers(generic, {name: values[READABLE:] for name, values in samples.items()})
    return tuple(_distinct_wrong_answers(result(working, part), wrong_answers(working, part)))


@lru_cache(maxsize=2048)
def _apply_mistake(subject: _Subject, index: int) -> _GenericMistake | None:
    """Return the formulas that a mistake leads to; None if they are too long or can't be simplified."""
    generic, part, wrong = subject.generic, subject.part, _wrong_in_numbers(subject)[index]
    changes = wrong.working.changes
    if all(stage == RESULT for stage, _ in changes):
        return _GenericMistake(wrong.mistake, wrong.sentence, None, tuple(change for _, change in changes))
    if generic.n > MOST_JOINTS and QUESTIONS[part.kind].is_made_of_minors:
        return None  # it would take minutes
    formulas = as_formulas(result(in_formulas(generic).with_mistakes(dict(changes)), part))
    if formulas.has(*NO_NUMBER) or len(str(formulas.tolist())) > LONGEST_RAW:
        return None
    try:
        return _GenericMistake(wrong.mistake, wrong.sentence, formulas.applyfunc(tidy_entry))
    except (TypeError, ValueError, BasePolynomialError):  # not a trigonometric polynomial
        return None


def _for_this_arm(problem: Problem, part: Part, mistakes: Iterable[_GenericMistake]) -> Iterator[KnownWrongAnswer]:
    """Yield the wrong answers with the numbers of this arm, if they are short and grading finds them wrong."""
    reference, fill = part.answer.as_matrix(), derive(problem.chain).fill_matrix
    for mistake in mistakes:
        if mistake.answer is None:
            entries = np.array(reference.tolist(), dtype=object)[..., None]
            for change in mistake.changes:
                entries = change(formulas(problem.chain), entries)
            answer = as_formulas(entries)
        else:
            answer = fill(mistake.answer)
        if answer.shape == reference.shape and len(str(answer.tolist())) <= LONGEST:
            equal = same_entries(problem, answer, reference)
            if not all(equal):
                yield KnownWrongAnswer(mistake.mistake.name, mistake.mistake.title, mistake.says, answer, equal)


def same_entries(problem: Problem, first: sp.Matrix, second: sp.Matrix) -> tuple[bool, ...]:
    """Return for each entry, row by row, whether grading considers the two matrices equal there."""
    domain = domain_of(problem)
    first_nodes, second_nodes = ([read(text_of(entry), domain.roles) for entry in matrix] for matrix in (first, second))
    return compare_entries(first_nodes, second_nodes, domain, f"known/{problem.id}").equal


# --- numbers and sets ---


def _wrong_numbers(problem: Problem, part: Part, most: int) -> Iterator[KnownWrongAnswer]:
    values = sample_configurations(
        problem.chain, part, domain_of(problem), POINTS, Stream(f"known/{problem.id}/{part.name}")
    )
    working = numbers(problem.chain, values)
    wrongs = _distinct_wrong_answers(result(working, part), wrong_answers(working, part))
    expected = [float(value) for value in part.answer.as_matrix()]
    tolerances = tolerances_of(part)
    accepted = [expected]
    for wrong in wrongs:
        wrong_values = [float(value) for value in wrong.answer[..., 0].ravel()]
        if all(_is_off(wrong_values, earlier, tolerances) for earlier in accepted) and len(accepted) <= most:
            accepted.append(wrong_values)
            is_correct = [
                abs(value - correct) <= tolerance
                for value, correct, tolerance in zip(wrong_values, expected, tolerances, strict=True)
            ]
            rounded = sp.Matrix([sp.Rational(f"{value:.6g}") for value in wrong_values])
            yield KnownWrongAnswer(wrong.mistake.name, wrong.mistake.title, wrong.sentence, rounded, tuple(is_correct))


def _is_off(values: list[float], earlier: list[float], room: list[float]) -> bool:
    return any(abs(a - b) > CLEARLY * tolerance for a, b, tolerance in zip(values, earlier, room, strict=True))


def tolerances_of(part: Part) -> list[float]:
    """Return the tolerance of each number of an answer, as in grading."""
    return part.of(Number).room(part.rounding)


def _wrong_sets(problem: Problem, part: Part) -> Iterator[KnownWrongAnswer]:
    """Yield wrong sets, one per mistake, all with different conditions."""
    answer = part.of(ConditionSet)
    accepted, mistake_names = [_conditions(answer)], set[str]()
    for mistake, mistaken in mistaken_answers(problem.chain, part):
        if isinstance(mistaken.answer, ConditionSet) and mistake.name not in mistake_names:
            conditions = _conditions(mistaken.answer)
            if conditions and conditions not in accepted:
                accepted.append(conditions)
                mistake_names.add(mistake.name)
                feedback = mistake.sentence(mistaken.words)
                yield KnownWrongAnswer(mistake.name, mistake.title, feedback, mistaken.answer.components)


def _conditions(answer: ConditionSet) -> frozenset[str]:
    """Return the conditions of a set as text. Angles are wrapped, so that pi and -pi are the same."""
    wrapped = [
        component
        if component.solutions is None
        else replace(
            component,
            solutions=tuple((joint, tuple(map(wrap_angle, values))) for joint, values in component.solutions),
        )
        for component in answer.components
    ]
    return frozenset(chained.from_iterable(component.pieces() for component in wrapped))


def wrap_angle(angle: sp.Expr) -> sp.Expr:
    """Return an angle wrapped to (-pi, pi] if it is a rational multiple of pi; other angles are unchanged."""
    turns = angle / (2 * sp.pi)
    if not turns.is_Rational:
        return angle
    fraction_of_turn = turns % 1
    return 2 * sp.pi * (fraction_of_turn if fraction_of_turn <= sp.Rational(1, 2) else fraction_of_turn - 1)
