"""Find the wrong answers that known mistakes lead to, for platforms that compare submissions with fixed answers.

qdot's grader judges each of these answers as wrong. No two of these answers are equal.
"""

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
import sympy as sp
from sympy.polys.polyerrors import BasePolynomialError

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.trigonometry import wrap_multiple_of_pi
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive, make_symbolic_arm
from qdot.exercises.derivation.graph import RESULT, compute_numeric_stages, compute_symbolic_stages, to_sympy_matrix
from qdot.exercises.formula.equality import READABLE_POINTS, Domain, compare_entries
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.formula.trees import Node
from qdot.exercises.mistakes.base import add_chapter_to_citation
from qdot.exercises.mistakes.catalogue import PredictedAnswer, generate_mistaken_answers, predict_wrong_answers
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.problem.problem import Part, Problem, ResultChoiceDetails
from qdot.exercises.questions.custom.definition import Definition
from qdot.exercises.questions.custom.question import CustomDetails
from qdot.exercises.questions.results import compute_answer, is_derived_step_by_step
from qdot.exercises.reference_answers import Answer, ConditionSet, Direction, Expression, Matrix, Number
from qdot.exercises.short_questions import question_of, wrong_formulas
from qdot.exercises.singularities import classification
from qdot.exercises.singularities.singular_set import Component

SAMPLE_COUNT = 5
"""Number of configurations at which answers are compared."""
MAX_CHARACTERS = 1500
"""Maximum length of a wrong answer in characters, all entries together; longer answers are left out."""
MAX_UNSIMPLIFIED_CHARACTERS = 20_000
"""Maximum length of a wrong answer before it is simplified; simplifying a longer answer would take too long."""
ZERO_TOLERANCE = 1e-9
"""Smaller answers count as zero. Zero is left out, because many mistakes lead to it."""
MISTAKES_PER_ANSWER = 3
"""Number of mistakes to try for each requested wrong answer, because some of the answers are too long."""
MIN_DIFFERENCE = 3
"""Minimum difference of two wrong numbers, and of a wrong number from zero, as a multiple of the tolerance."""
MAX_RATIO = 1e9
"""Maximum ratio of a wrong number to the largest correct one. Larger numbers come from a division by a number that is
zero except for rounding."""


@dataclass(frozen=True)
class KnownWrongAnswer:
    """A wrong answer, the mistake that leads to it (name and title), and the feedback on the mistake."""

    mistake: str
    title: str
    feedback: str
    answer: sp.Matrix | tuple[Component, ...]

    @property
    def matrix(self) -> sp.Matrix:
        """The answer as a matrix; only for answers that are not sets."""
        assert isinstance(self.answer, sp.MatrixBase)
        return self.answer

    def make_answer(self, correct_answer: Answer) -> Answer:
        """Return the wrong answer with the type and the units of the correct answer."""
        match correct_answer, self.answer:
            case ConditionSet(), tuple(components):
                return replace(correct_answer, components=components)
            case Expression(), matrix:
                return replace(correct_answer, reference=matrix[0])
            case ((Matrix() | Direction() | Number()), matrix):
                return replace(correct_answer, reference=matrix)
        raise TypeError(f"no known mistakes for answers of type {correct_answer.type}")


def find_known_wrong_answers(problem: Problem, part: Part, max_count: int) -> tuple[KnownWrongAnswer, ...]:
    """Return at most `max_count` wrong answers to a part, each from a different mistake, likely mistakes first."""
    if part.answer.is_set:
        return tuple(_find_wrong_sets(problem, part))[:max_count]
    if not is_derived_step_by_step(part):
        return ()
    if part.answer.expected_units:
        return tuple(_find_wrong_numbers(problem, part, max_count))
    if not part.answer.is_symbolic:
        return ()
    return tuple(itertools.islice(_find_wrong_formulas(problem, part, MISTAKES_PER_ANSWER * max_count), max_count))


def make_domain(problem: Problem) -> Domain:
    """Return the domain of the symbols in reference answers, without the lengths that have a value.

    Reference answers contain the value instead.
    """
    return Domain({name: role for name, role in problem.domain.roles.items() if isinstance(role, str)})


def _select_distinct(correct: np.ndarray, predictions: Iterable[PredictedAnswer]) -> Iterator[PredictedAnswer]:
    """Yield the numeric wrong answers that are finite, nonzero and of the correct shape, one for each mistake."""
    distinct_answers, mistake_names = [correct], set[str]()
    for prediction in predictions:
        answer = prediction.answer
        if prediction.mistake.name in mistake_names or answer.shape != correct.shape or not np.isfinite(answer).all():
            continue
        is_new = all(wrong_formulas.have_different_values(answer, known_answer) for known_answer in distinct_answers)
        if is_new and np.abs(answer).max() > ZERO_TOLERANCE:
            distinct_answers.append(answer)
            mistake_names.add(prediction.mistake.name)
            yield prediction


# --- formulas ---


@dataclass(frozen=True)
class _StructureQuestion:
    """A question about a structure: an arm with symbols for all lengths, which many arms share (see `derivation`).

    The results for a structure are cached. `content` distinguishes questions of one kind that ask for different
    results, and custom questions that have the same name in different assignments.
    """

    chain: Chain
    kind: str
    content: ResultChoiceDetails | Definition | None
    part: Part = field(compare=False)


@lru_cache(maxsize=512)
def _find_numeric_wrong_answers(question: _StructureQuestion) -> tuple[PredictedAnswer, ...]:
    """Return the numeric wrong answers of the mistakes that change the answer."""
    chain, part = question.chain, question.part
    roles = classification.make_domain(chain).roles
    names = {*roles, *(rate.name for rate in chain.rates), *chain.task, *part.symbols}
    # The first samples have few decimals, so different formulas may have equal values there.
    samples = Domain(roles).sample(names, READABLE_POINTS + SAMPLE_COUNT, Stream(f"known/{question.kind}"))
    stages = compute_numeric_stages(chain, {name: values[READABLE_POINTS:] for name, values in samples.items()})
    return tuple(_select_distinct(compute_answer(stages, part), predict_wrong_answers(stages, part)))


@lru_cache(maxsize=2048)
def _derive_wrong_formulas(question: _StructureQuestion, index: int) -> sp.Matrix | None:
    """Return the formulas that a mistake leads to; None if they are too long or can't be simplified.

    `index` is the index of the mistake's numeric wrong answer.
    """
    chain, part = question.chain, question.part
    if chain.n > wrong_formulas.MAX_JOINTS_FOR_MINORS and question_of(part).is_made_of_minors:
        return None  # the derivation would take minutes
    changes = dict(_find_numeric_wrong_answers(question)[index].stages.changes)
    formulas = to_sympy_matrix(
        compute_answer(wrong_formulas.derive_simplified_formulas(chain).with_mistakes(changes), part)
    )
    if formulas.has(*wrong_formulas.NOT_A_NUMBER) or len(str(formulas.tolist())) > MAX_UNSIMPLIFIED_CHARACTERS:
        return None
    try:
        return formulas.applyfunc(wrong_formulas.tidy_entry)
    except (TypeError, ValueError, BasePolynomialError):  # the formula is not a trigonometric polynomial
        return None


def _find_wrong_formulas(problem: Problem, part: Part, mistake_count: int) -> Iterator[KnownWrongAnswer]:
    """Yield the formulas that the likeliest mistakes lead to, if they are short and the grader judges them as wrong."""
    details = part.details
    result_choice = details if isinstance(details, ResultChoiceDetails) else None
    content = details.definition if isinstance(details, CustomDetails) else result_choice
    question = _StructureQuestion(make_symbolic_arm(problem.chain).chain, part.kind, content, part)
    reference = part.answer.as_matrix()
    for index, prediction in enumerate(_find_numeric_wrong_answers(question)[:mistake_count]):
        changes = prediction.stages.changes
        if all(stage == RESULT for stage, _ in changes):  # only the finished answer changes
            entries = np.array(reference.tolist(), dtype=object)[..., None]
            for _, change in changes:
                entries = change(compute_symbolic_stages(problem.chain), entries)
            answer = to_sympy_matrix(entries)
        else:
            formulas = _derive_wrong_formulas(question, index)
            if formulas is None:
                continue
            answer = derive(problem.chain).substitute_matrix(formulas)
        is_usable = answer.shape == reference.shape and len(str(answer.tolist())) <= MAX_CHARACTERS
        if is_usable and not all(compare_entry_by_entry(problem, answer, reference)):
            feedback, mistake = add_chapter_to_citation(prediction.sentence), prediction.mistake
            yield KnownWrongAnswer(mistake.name, mistake.title, feedback, answer)


def compare_entry_by_entry(problem: Problem, answer: sp.Matrix, reference: sp.Matrix) -> tuple[bool, ...]:
    """Return for each entry, row by row, whether the grader judges an answer's entry as equal to the reference."""
    answer_trees, reference_trees = parse_entries(problem, answer), parse_entries(problem, reference)
    return compare_entries(answer_trees, reference_trees, make_domain(problem), f"known/{problem.id}").is_correct


def parse_entries(problem: Problem, entries: Iterable[sp.Expr]) -> list[Node]:
    """Return the entries of an answer as trees, for comparison by the grader."""
    roles = make_domain(problem).roles
    return [parse_formula(format_expression(entry), roles) for entry in entries]


# --- numbers and sets ---


def _find_wrong_numbers(problem: Problem, part: Part, max_count: int) -> Iterator[KnownWrongAnswer]:
    """Yield wrong numbers that differ clearly from the correct ones, from zeros and from each other."""
    stream = Stream(f"known/{problem.id}/{part.name}")
    samples = sample_configurations(problem.chain, part, make_domain(problem), SAMPLE_COUNT, stream)
    stages = compute_numeric_stages(problem.chain, samples)
    predictions = _select_distinct(compute_answer(stages, part), predict_wrong_answers(stages, part))
    expected_numbers = np.array([float(value) for value in part.answer.as_matrix()])
    tolerances = np.array(list_tolerances(part))
    other_answers = [expected_numbers, np.zeros_like(expected_numbers)]
    wrong_answers: list[np.ndarray] = []
    for prediction in predictions:
        values = prediction.answer[..., 0].ravel()
        is_new = all(
            (np.abs(values - answer) > MIN_DIFFERENCE * tolerances).any() for answer in other_answers + wrong_answers
        )
        if is_new and not is_divided_by_zero(values, expected_numbers) and len(wrong_answers) < max_count:
            wrong_answers.append(values)
            rounded_answer = sp.Matrix([sp.Rational(f"{value:.6g}") for value in values])
            feedback, mistake = add_chapter_to_citation(prediction.sentence), prediction.mistake
            yield KnownWrongAnswer(mistake.name, mistake.title, feedback, rounded_answer)


def is_divided_by_zero(wrong_numbers: np.ndarray, correct_numbers: np.ndarray) -> bool:
    """Return whether a mistake leads to a division by zero, or by a tiny number that is zero except for rounding."""
    limit = MAX_RATIO * max(np.abs(correct_numbers).max(), ZERO_TOLERANCE)
    return not np.isfinite(wrong_numbers).all() or bool(np.abs(wrong_numbers).max() > limit)


def list_tolerances(part: Part) -> list[float]:
    """Return the grader's tolerance for each number of an answer."""
    return part.answer_as(Number).list_allowed_errors(part.rounding)


def _find_wrong_sets(problem: Problem, part: Part) -> Iterator[KnownWrongAnswer]:
    """Yield a wrong set of singular configurations for each mistake; no two sets have the same conditions."""
    earlier_conditions, mistake_names = [_list_conditions(part.answer_as(ConditionSet))], set[str]()
    for mistake, mistaken_answer in generate_mistaken_answers(problem.chain, part):
        if isinstance(mistaken_answer.answer, ConditionSet) and mistake.name not in mistake_names:
            conditions = _list_conditions(mistaken_answer.answer)
            if conditions and conditions not in earlier_conditions:
                earlier_conditions.append(conditions)
                mistake_names.add(mistake.name)
                feedback = add_chapter_to_citation(mistake.format_message(mistaken_answer.words))
                yield KnownWrongAnswer(mistake.name, mistake.title, feedback, mistaken_answer.answer.components)


def _list_conditions(answer: ConditionSet) -> frozenset[str]:
    """Return the conditions of a set as text. Angles are wrapped, so that pi and -pi are the same."""
    wrapped_components = (
        component.map_values(lambda _, angle: wrap_multiple_of_pi(angle)) for component in answer.components
    )
    return frozenset(itertools.chain.from_iterable(component.list_pieces() for component in wrapped_components))
