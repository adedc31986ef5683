"""Evaluate formulas at a configuration, for platforms that can compare only numbers.

The lengths and the configuration are pseudorandom, but always the same for a problem, and away from singular
configurations. They are chosen so that no entry is tiny or zero by chance, and so that the numbers distinguish as many
mistakes as possible. All values are computed twice: from the reference answer and by a numeric derivation.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain, is_angle_symbol
from qdot.exercises.arm.mpmath_kinematics import evaluate_in_context, round_to_ten_digits
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.graph import StageResults, compute_numeric_stages
from qdot.exercises.formula.equality import Domain
from qdot.exercises.mistakes import catalogue
from qdot.exercises.mistakes.base import add_chapter_to_citation
from qdot.exercises.mistakes.configurations import SymbolValues, sample_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions import inversion
from qdot.exercises.questions.exact_configurations import sample_unequal_lengths
from qdot.exercises.questions.results import compute_answer, is_derived_step_by_step, is_made_of_jacobian
from qdot.exercises.reference_answers import Number
from qdot.exercises.singularities.classification import make_domain
from qdot.exercises.writing.latex import tex, tex_angle, tex_length, tex_value
from qdot.exercises.writing.units import tex_unit
from qdot.exercises.writing.wording import Wording

CONFIGURATION_COUNT = 12
"""Number of configurations to sample. The best one is used."""
TINY_SHARE = 0.02
"""An entry below this fraction of the largest entry is tiny: students can hardly compute it to three digits."""
ABSOLUTE_TOLERANCE = 0.001
"""Absolute tolerance of all entries, as a fraction of the largest entry; it matters for zeros."""
MIN_DIFFERENCE = 0.03
"""Numbers distinguish a mistake if it changes an entry by more than this fraction of the largest entry."""
MAX_JOINTS_FOR_ALL_MISTAKES = 4
"""For an arm with more joints, it would take too long to apply all mistakes to results that are derived from J."""
MAX_DISAGREEMENT = 1e-8
"""Maximum difference between the results of the two computations, as a fraction of the largest entry."""
MAX_TRIES = 30
"""Maximum number of attempts to sample a configuration with a well-conditioned J."""


@dataclass(frozen=True)
class GivenValues:
    """The values that a question states: pairs of a name and a value in LaTeX, in the order of the question.

    `values` has the numeric value of every symbol.
    """

    joints: tuple[tuple[str, str], ...]
    other_values: tuple[tuple[str, str], ...]
    values: Mapping[str, float]


@dataclass(frozen=True)
class NumericPart:
    """A part whose answer is numbers: `values` (rows x columns), computed with the `given_values`.

    `given_values` is None if the part itself asks for numbers. `wrong_answers` are pairs of the sentence on a mistake
    and the wrong values. For a direction, `unit_entry` is the index (from 0) of the entry that is scaled to 1; None for
    other answers.
    """

    part: Part
    values: np.ndarray
    given_values: GivenValues | None
    wrong_answers: tuple[tuple[str, np.ndarray], ...]
    unit_entry: int | None = None


def ask_in_numbers(problem: Problem, part: Part) -> NumericPart | None:
    """Return a part with numbers as its answer; None if that is impossible.

    Raises QdotError if the two computations of the numbers do not agree.
    """
    answer = part.answer
    numeric_part: NumericPart | None = None
    if answer.is_numeric:
        number_answer = _make_numeric_answer(part, answer.as_matrix()) if answer.is_direction else answer
        numeric_part = _convert_numeric_answer(problem, replace(part, answer=number_answer), answer.is_direction)
    elif answer.list_entries() and is_derived_step_by_step(part):
        numeric_part = _evaluate_formulas(problem, part)
    return _scale_direction(numeric_part) if numeric_part and answer.is_direction else numeric_part


def _make_numeric_answer(part: Part, values: sp.Matrix) -> Number:
    units = part.details.units or ("",) * len(values)
    return Number(values, units, inversion.THREE_DIGIT_TOLERANCE, ABSOLUTE_TOLERANCE * float(max(map(abs, values))))


def _convert_numeric_answer(problem: Problem, part: Part, is_direction: bool) -> NumericPart:
    """Convert a part that already asks for numbers, and add the wrong numbers that mistakes lead to."""
    answer = part.answer_as(Number)
    reference = _to_floats(answer)
    wrong_answers = [
        (add_chapter_to_citation(mistake.format_message(mistaken_answer.words)), _to_floats(mistaken_answer.answer))
        for mistake, mistaken_answer in catalogue.generate_mistaken_answers(problem.chain, part)
        if isinstance(mistaken_answer.answer, Number)
    ]
    if is_derived_step_by_step(part):
        roles: Mapping[str, Any] = make_domain(problem.chain).roles
        domain = Domain({**roles, **dict.fromkeys(part.symbols, "signed")})  # loads may be negative
        stream = Stream(f"{problem.id}/{part.name}/wrong")
        stages = compute_numeric_stages(problem.chain, sample_configurations(problem.chain, part, domain, 1, stream))
        _check_agreement(problem, part, reference, compute_answer(stages, part)[..., 0], is_direction)
        predictions = _list_wrong_answers(stages, part)
        wrong_answers += [
            (add_chapter_to_citation(prediction.sentence), prediction.answer[..., 0]) for prediction in predictions
        ]
    return NumericPart(part, reference, None, tuple(wrong_answers))


def _to_floats(answer: Number) -> np.ndarray:
    return np.array(answer.reference.tolist(), dtype=float)


def _check_agreement(
    problem: Problem, part: Part, reference: np.ndarray, derived_values: np.ndarray, is_direction: bool
) -> None:
    """Raise QdotError unless both computations agree; directions are compared up to a factor."""
    expected, derived = reference, derived_values
    if reference.shape == derived_values.shape and is_direction:
        largest_index = np.abs(reference).argmax()
        expected, derived = (values / values.ravel()[largest_index] for values in (reference, derived_values))
    max_difference = MAX_DISAGREEMENT * max(np.abs(expected).max(), 1e-9)
    if expected.shape != derived.shape or not np.abs(expected - derived).max() <= max_difference:
        raise QdotError(f"{problem.id}: {part.name}: its numbers do not agree; please report it")


def _list_wrong_answers(stages: StageResults, part: Part) -> list[catalogue.PredictedAnswer]:
    """Return the wrong answers that mistakes lead to.

    If the derivation is long, only the few mistakes are considered that are likely enough for a single number.
    """
    if stages.n > MAX_JOINTS_FOR_ALL_MISTAKES and is_made_of_jacobian(part):
        likely_mistakes = catalogue.list_likely_mistakes(part)
        mistakes = [mistake for mistake in likely_mistakes if mistake.name in catalogue.MISTAKES_FOR_ONE_NUMBER]
        return [prediction for mistake in mistakes for prediction in catalogue.apply_mistake(mistake, stages, part)]
    return list(catalogue.predict_wrong_answers(stages, part))


# --- formulas ---


def _evaluate_formulas(problem: Problem, part: Part) -> NumericPart | None:
    """Return a part with its formulas evaluated at the best of several sampled configurations."""
    chain, reference = problem.chain, part.answer.as_matrix()
    stream = Stream(f"qdot/{problem.id.stream_name}/{part.name}/in numbers")
    configurations = list(_sample_configurations(chain, part, stream))
    values = _collect_values(chain, part, configurations)
    # Only the shape of the placeholder's answer matters.
    placeholder_part = replace(part, answer=_make_numeric_answer(part, sp.ones(*reference.shape)))
    stages = compute_numeric_stages(chain, values)
    derived_answer = compute_answer(stages, placeholder_part)
    all_predictions = _list_wrong_answers(stages, placeholder_part)
    predictions = [prediction for prediction in all_predictions if prediction.answer.shape == derived_answer.shape]
    best_index = _choose_configuration(derived_answer, predictions)
    if best_index is None:
        return None
    substitutions = _add_given_joints(part, configurations[best_index])
    exact_values = reference.applyfunc(
        lambda entry: round_to_ten_digits(evaluate_in_context(entry.xreplace(substitutions)))
    )
    number_part = replace(part, answer=_make_numeric_answer(part, exact_values))
    float_values = np.array(exact_values.tolist(), dtype=float)
    _check_agreement(problem, part, float_values, derived_answer[..., best_index], part.answer.is_direction)
    wrong_answers = tuple(
        (add_chapter_to_citation(prediction.sentence), prediction.answer[..., best_index]) for prediction in predictions
    )
    given_values = _describe_given_values(chain, part, configurations[best_index], reference)
    return NumericPart(number_part, float_values, given_values, wrong_answers)


ExactValues = dict[sp.Symbol, sp.Expr]
"""The exact value of each symbol: joint variables, joint rates, velocities, loads, lengths and constant angles."""


def _sample_configurations(chain: Chain, part: Part, stream: Stream) -> Iterator[ExactValues]:
    """Yield values of all symbols; if possible, J is well-conditioned at the joint values.

    All values have few digits: angles are multiples of 10 degrees, rates of 0.1, velocities of 0.05, and loads of 1.
    """
    min_conditioning = inversion.find_min_conditioning(chain) / 2  # less strict than for questions that invert J
    for _ in range(CONFIGURATION_COUNT):
        for _ in range(MAX_TRIES):
            lengths = {
                symbol: sp.pi * sp.Rational(stream.nonzero_integer(16), 18) if is_angle_symbol(symbol) else value
                for symbol, value in sample_unequal_lengths(chain, stream).items()
            }
            joints = inversion.sample_joint_values(chain, stream)
            if part.details.given_joints or inversion.compute_conditioning(chain, lengths, joints) > min_conditioning:
                break
        rate_values = {rate: sp.Rational(stream.nonzero_integer(9), 10) for rate in chain.rates}
        velocity_values = {sp.Symbol(row): sp.Rational(stream.nonzero_integer(8), 20) for row in chain.task}
        load_numbers = {name: stream.nonzero_integer(20) for name in part.symbols}
        load_values = {
            sp.Symbol(name): sp.Integer(abs(number) if part.symbols[name].is_positive else number)
            for name, number in load_numbers.items()
        }
        yield {**lengths, **joints, **rate_values, **velocity_values, **load_values}


def _add_given_joints(part: Part, configuration: ExactValues) -> ExactValues:
    """Return a configuration in which the joint values that the question states replace sampled joint values."""
    return {**configuration, **{q: value.xreplace(configuration) for q, value in part.details.given_joints.items()}}


def _collect_values(chain: Chain, part: Part, configurations: Sequence[ExactValues]) -> SymbolValues:
    """Return the values (N,) of each symbol at all N configurations."""
    exact_configurations = [_add_given_joints(part, configuration) for configuration in configurations]
    columns = {
        symbol.name: np.array([float(configuration[symbol]) for configuration in exact_configurations])
        for symbol in exact_configurations[0]
    }
    unused_names = {*make_domain(chain).roles} - set(columns)  # the answer does not depend on these
    return columns | {name: np.ones(len(configurations)) for name in sorted(unused_names)}


def _choose_configuration(correct: np.ndarray, predictions: Sequence[catalogue.PredictedAnswer]) -> int | None:
    """Return the index of the best configuration; None if the answer is infinite or zero at all configurations.

    `correct` is the answer (rows, columns, configurations). The best configuration has the fewest tiny entries, apart
    from entries that are always zero. If several have equally few, the best one distinguishes the most mistakes.
    """
    max_by_configuration = np.abs(correct).max(axis=(0, 1))
    max_by_entry = np.nan_to_num(np.abs(correct)).max(axis=-1)
    is_nonzero = max_by_entry > MAX_DISAGREEMENT * max_by_entry.max()
    tiny_count = ((np.abs(correct) < TINY_SHARE * max_by_configuration) & is_nonzero[..., None]).sum(axis=(0, 1))
    distinguished_count = np.zeros(correct.shape[-1], dtype=int)
    for prediction in predictions:
        difference = np.nan_to_num(np.abs(prediction.answer - correct), posinf=0.0)
        distinguished_count += difference.max(axis=(0, 1)) > MIN_DIFFERENCE * max_by_configuration
    is_usable = np.isfinite(correct).all(axis=(0, 1)) & (max_by_configuration > MAX_DISAGREEMENT)
    return min(np.flatnonzero(is_usable).tolist(), key=lambda k: (tiny_count[k], -distinguished_count[k]), default=None)


def _scale_direction(direction: NumericPart) -> NumericPart:
    """Return a direction scaled so that its largest entry is 1, because only the direction matters."""
    unit_entry = int(np.abs(np.round(direction.values, 6)).argmax())
    values = direction.values / direction.values.ravel()[unit_entry]
    with np.errstate(all="ignore"):
        wrong_answers = tuple(
            (text, wrong_values / wrong_values.ravel()[unit_entry]) for text, wrong_values in direction.wrong_answers
        )
    reference = sp.Matrix(values.tolist())
    answer = Number(reference, ("",) * len(reference), inversion.THREE_DIGIT_TOLERANCE, ABSOLUTE_TOLERANCE)
    part = replace(direction.part, answer=answer)
    return NumericPart(part, values, direction.given_values, wrong_answers, unit_entry)


# --- given values ---


def _describe_given_values(chain: Chain, part: Part, configuration: ExactValues, reference: sp.Matrix) -> GivenValues:
    """Return the values to state: joint values that the prompt doesn't state, and others that the answer depends on."""
    wording, used_symbols = Wording(chain), reference.free_symbols
    joints = tuple((tex(q), tex_value(configuration[q], q)) for q in chain.q if q not in part.details.given_joints)
    other_values: list[tuple[str, str]] = []
    if used_symbols & set(chain.rates):
        units = zip(chain.rates, wording.rate_units, strict=True)
        other_values += [(tex(rate, chain), tex(configuration[rate]) + tex_unit(unit)) for rate, unit in units]
    velocities = [sp.Symbol(name) for name in chain.task]
    if used_symbols & set(velocities):
        other_values += [(tex(v), wording.write_velocity(v, configuration[v])) for v in velocities]
    other_values += [
        (tex(sp.Symbol(name)), tex(configuration[sp.Symbol(name)]) + tex_unit(info.unit))
        for name, info in part.symbols.items()
    ]
    for symbol in chain.parameters:
        value_latex = (tex_angle if is_angle_symbol(symbol) else tex_length)(configuration[symbol])
        other_values.append((tex(symbol), value_latex))
    values = {symbol.name: float(value) for symbol, value in _add_given_joints(part, configuration).items()}
    return GivenValues(joints, tuple(other_values), values)
