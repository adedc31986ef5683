"""The wrong answers that known mistakes lead to, for platforms that compare submissions with fixed answers.

qdot's own comparison finds each of them wrong. No two of them are equal.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import chain as chained
from itertools import islice

import numpy as np
import sympy as sp
from sympy.polys.polyerrors import BasePolynomialError

from qdot.exercises.answer_types import ConditionSet, Number
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive, structure
from qdot.exercises.arm.derivation_graph import (
    RESULT,
    Change,
    compute_numeric_stages,
    compute_symbolic_stages,
    to_sympy_matrix,
)
from qdot.exercises.arm.standard_table import wrap_angle
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.equality import READABLE_POINTS, Domain, compare_entries
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.sympy_text import expression_text
from qdot.exercises.mistakes.base import Mistake, name_chapter
from qdot.exercises.mistakes.catalogue import PredictedAnswer, generate_mistaken_answers, predict_wrong_answers
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.problem.problem import Part, Problem, ResultChoiceDetails
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.results import compute_answer, is_derived
from qdot.exercises.short_questions.wrong_formulas import (
    MAX_JOINTS_FOR_MINORS,
    NOT_A_NUMBER,
    derive_simplified_formulas,
    have_different_values,
    tidy_entry,
)
from qdot.exercises.singularities import classification
from qdot.exercises.singularities.singularity import Component

SAMPLE_COUNT = 5
MAX_CHARACTERS = 1500
"""Maximum length of a wrong answer in characters, all entries together; longer ones are left out."""
MAX_UNSIMPLIFIED_CHARACTERS = 20_000
"""Maximum length in characters of a wrong answer that is simplified; simplifying a longer one would take too long."""
ZERO_TOLERANCE = 1e-9
"""Answers smaller than this are zero, and zero identifies no mistake."""
MISTAKES_PER_ANSWER = 3
"""Number of mistakes to try per wrong answer, because the answers of some are too long."""
CLEAR_TOLERANCES = 3
"""A wrong number must differ by more than this multiple of the tolerance."""


@dataclass(frozen=True)
class KnownWrongAnswer:
    """A wrong answer: the mistake behind it, and the message about it.

    `entries_equal` says for each entry whether it is correct nevertheless.
    """

    mistake: str
    title: str
    feedback: str
    answer: sp.Matrix | tuple[Component, ...]
    entries_equal: tuple[bool, ...] = ()

    @property
    def matrix(self) -> sp.Matrix:
        """The answer as a matrix; call this only if the answer is not a set."""
        assert isinstance(self.answer, sp.MatrixBase)
        return self.answer


def find_known_wrong_answers(problem: Problem, part: Part, max_count: int) -> tuple[KnownWrongAnswer, ...]:
    """Return at most `max_count` wrong answers to a part, each by a different mistake, the likely ones first."""
    if part.answer.is_set:
        return tuple(_find_wrong_sets(problem, part))[:max_count]
    if not is_derived(part):
        return ()
    if part.answer.expected_units:
        return tuple(_find_wrong_numbers(problem, part, max_count))
    if not part.answer.is_symbolic:
        return ()
    alternative = part.details if isinstance(part.details, ResultChoiceDetails) else None
    subject = _StructureQuestion(structure(problem.chain).chain, part.kind, alternative, part)
    mistakes = (
        _apply_mistake(subject, index)
        for index in range(min(MISTAKES_PER_ANSWER * max_count, len(_find_numeric_wrong_answers(subject))))
    )
    return tuple(islice(_fill_with_arm_numbers(problem, part, filter(None, mistakes)), max_count))


def make_domain(problem: Problem) -> Domain:
    """Return the domain of each symbol without a value. Lengths with a value appear in references as numbers."""
    return Domain({name: role for name, role in problem.domain.roles.items() if isinstance(role, str)})


def _select_distinct(correct: np.ndarray, candidates: Iterable[PredictedAnswer]) -> Iterator[PredictedAnswer]:
    """Yield one numeric wrong answer per mistake: finite, of the expected shape, and different from earlier ones."""
    accepted_answers, mistake_names = [correct], set[str]()
    for wrong in candidates:
        answer = wrong.answer
        if wrong.mistake.name in mistake_names or answer.shape != correct.shape or not np.isfinite(answer).all():
            continue
        is_new = all(have_different_values(answer, earlier_answer) for earlier_answer in accepted_answers)
        if is_new and np.abs(answer).max() > ZERO_TOLERANCE:
            accepted_answers.append(answer)
            mistake_names.add(wrong.mistake.name)
            yield wrong


# --- formulas ---


@dataclass(frozen=True)
class _StructureQuestion:
    """A question about a structure.

    `alternative` distinguishes questions of one kind that ask for different results.
    """

    generic: Chain
    kind: str
    alternative: ResultChoiceDetails | None
    part: Part = field(compare=False)


@dataclass(frozen=True)
class _StructureMistake:
    """A mistake on a structure and the answer that it leads to.

    If the mistake only alters the final result, `answer` is None, and `changes` are to be applied to the reference.
    """

    mistake: Mistake
    feedback: str
    answer: sp.Matrix | None
    changes: tuple[Change, ...] = ()


@lru_cache(maxsize=512)
def _find_numeric_wrong_answers(subject: _StructureQuestion) -> tuple[PredictedAnswer, ...]:
    """Return the numeric wrong answers of the mistakes that change the answer."""
    generic, part = subject.generic, subject.part
    roles = classification.domain_of(generic).roles
    names = {*roles, *(rate.name for rate in generic.rates), *generic.task, *part.symbols}
    samples = Domain(roles).sample(names, READABLE_POINTS + SAMPLE_COUNT, Stream(f"known/{subject.kind}"))
    working = compute_numeric_stages(generic, {name: values[READABLE_POINTS:] for name, values in samples.items()})
    return tuple(_select_distinct(compute_answer(working, part), predict_wrong_answers(working, part)))


@lru_cache(maxsize=2048)
def _apply_mistake(subject: _StructureQuestion, index: int) -> _StructureMistake | None:
    """Return the formulas that a mistake leads to; None if they are too long or can't be simplified."""
    generic, part, wrong = subject.generic, subject.part, _find_numeric_wrong_answers(subject)[index]
    changes = wrong.working.changes
    if all(stage == RESULT for stage, _ in changes):
        return _StructureMistake(wrong.mistake, wrong.sentence, None, tuple(change for _, change in changes))
    if generic.n > MAX_JOINTS_FOR_MINORS and QUESTIONS[part.kind].is_made_of_minors:
        return None  # it would take minutes
    formulas = to_sympy_matrix(compute_answer(derive_simplified_formulas(generic).with_mistakes(dict(changes)), part))
    if formulas.has(*NOT_A_NUMBER) or len(str(formulas.tolist())) > MAX_UNSIMPLIFIED_CHARACTERS:
        return None
    try:
        return _StructureMistake(wrong.mistake, wrong.sentence, formulas.applyfunc(tidy_entry))
    except (TypeError, ValueError, BasePolynomialError):  # not a trigonometric polynomial
        return None


def _fill_with_arm_numbers(
    problem: Problem, part: Part, mistakes: Iterable[_StructureMistake]
) -> Iterator[KnownWrongAnswer]:
    """Yield the wrong answers with the numbers of this arm, if they are short and grading finds them wrong."""
    reference, fill = part.answer.as_matrix(), derive(problem.chain).substitute_matrix
    for mistake in mistakes:
        if mistake.answer is None:
            entries = np.array(reference.tolist(), dtype=object)[..., None]
            for change in mistake.changes:
                entries = change(compute_symbolic_stages(problem.chain), entries)
            answer = to_sympy_matrix(entries)
        else:
            answer = fill(mistake.answer)
        if answer.shape == reference.shape and len(str(answer.tolist())) <= MAX_CHARACTERS:
            entries_equal = compare_entry_by_entry(problem, answer, reference)
            if not all(entries_equal):
                feedback = name_chapter(mistake.feedback)
                yield KnownWrongAnswer(mistake.mistake.name, mistake.mistake.title, feedback, answer, entries_equal)


def compare_entry_by_entry(problem: Problem, first: sp.Matrix, second: sp.Matrix) -> tuple[bool, ...]:
    """Return for each entry, row by row, whether grading considers the two matrices equal there."""
    domain = make_domain(problem)
    first_nodes, second_nodes = (
        [parse_formula(expression_text(entry), domain.roles) for entry in matrix] for matrix in (first, second)
    )
    return compare_entries(first_nodes, second_nodes, domain, f"known/{problem.id}").is_correct


# --- numbers and sets ---


def _find_wrong_numbers(problem: Problem, part: Part, max_count: int) -> Iterator[KnownWrongAnswer]:
    stream = Stream(f"known/{problem.id}/{part.name}")
    samples = sample_configurations(problem.chain, part, make_domain(problem), SAMPLE_COUNT, stream)
    working = compute_numeric_stages(problem.chain, samples)
    wrong_answers = _select_distinct(compute_answer(working, part), predict_wrong_answers(working, part))
    expected_numbers = np.array([float(value) for value in part.answer.as_matrix()])
    tolerances = np.array(list_tolerances(part))
    accepted_values = [expected_numbers]
    for wrong in wrong_answers:
        values = wrong.answer[..., 0].ravel()
        is_new = all(
            (np.abs(values - earlier_values) > CLEAR_TOLERANCES * tolerances).any()
            for earlier_values in accepted_values
        )
        if is_new and len(accepted_values) <= max_count:
            accepted_values.append(values)
            is_correct = tuple(map(bool, np.abs(values - expected_numbers) <= tolerances))
            rounded_answer = sp.Matrix([sp.Rational(f"{value:.6g}") for value in values])
            feedback = name_chapter(wrong.sentence)
            yield KnownWrongAnswer(wrong.mistake.name, wrong.mistake.title, feedback, rounded_answer, is_correct)


def list_tolerances(part: Part) -> list[float]:
    """Return the tolerance of each number of an answer, as in grading."""
    return part.answer_as(Number).allowed_errors(part.rounding)


def _find_wrong_sets(problem: Problem, part: Part) -> Iterator[KnownWrongAnswer]:
    """Yield wrong sets, one per mistake, all with different conditions."""
    answer = part.answer_as(ConditionSet)
    accepted_conditions, mistake_names = [_list_conditions(answer)], set[str]()
    for mistake, mistaken in generate_mistaken_answers(problem.chain, part):
        if isinstance(mistaken.answer, ConditionSet) and mistake.name not in mistake_names:
            conditions = _list_conditions(mistaken.answer)
            if conditions and conditions not in accepted_conditions:
                accepted_conditions.append(conditions)
                mistake_names.add(mistake.name)
                feedback = name_chapter(mistake.sentence(mistaken.words))
                yield KnownWrongAnswer(mistake.name, mistake.title, feedback, mistaken.answer.components)


def _list_conditions(answer: ConditionSet) -> frozenset[str]:
    """Return the conditions of a set as text. Angles are wrapped, so that pi and -pi are the same."""
    wrapped = (component.map_values(lambda _, angle: wrap_angle(angle)) for component in answer.components)
    return frozenset(chained.from_iterable(component.pieces() for component in wrapped))
