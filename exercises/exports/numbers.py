"""The values of formulas at a configuration, for platforms that can't compare formulas.

Lengths and the configuration are sampled from the problem's own stream, away from singular configurations. They are
chosen so that no entry is tiny or zero by chance and the numbers distinguish as many mistakes as possible. All values
are computed twice: from the reference and by a numeric derivation.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.answer_types import Number
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation_graph import StageResults, compute_numeric_stages
from qdot.exercises.arm.mpmath_kinematics import evaluate_in_context, round_to_ten_digits
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.equality import Domain
from qdot.exercises.mistakes import catalogue
from qdot.exercises.mistakes.base import name_chapter
from qdot.exercises.mistakes.configurations import SymbolValues, sample_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions import inversion
from qdot.exercises.questions.geometry import sample_unequal_lengths
from qdot.exercises.questions.results import compute_answer, is_derived, is_made_of_jacobian
from qdot.exercises.singularities.classification import domain_of
from qdot.exercises.writing.latex import tex, tex_angle, tex_length, tex_value
from qdot.exercises.writing.wording import Wording

CONFIGURATION_COUNT = 12
"""Number of configurations to sample. The one that distinguishes the most mistakes is used."""
TINY_SHARE = 0.02
"""An entry is hard to give to three digits if it is below this fraction of the largest one."""
ABSOLUTE_TOLERANCE = 0.001
"""Absolute tolerance of any entry, as a fraction of the largest one; it matters for zeros."""
MIN_DIFFERENCE = 0.03
"""A mistake is distinguishable if it changes an entry by more than this fraction of the largest one."""
MAX_JOINTS_FOR_ALL_MISTAKES = 4
"""Maximum number of joints for which all mistakes in results derived from J are computed; more joints take too long."""
MAX_DISAGREEMENT = 1e-8
"""Maximum difference of the two computations, as a fraction of the largest entry."""


@dataclass(frozen=True)
class GivenValues:
    """The values that a question gives, in LaTeX: names and values in the order of the question.

    `values` has the numeric value of every symbol.
    """

    joints: tuple[tuple[str, str], ...]
    others: tuple[tuple[str, str], ...]
    values: Mapping[str, float]


@dataclass(frozen=True)
class NumericPart:
    """A part whose answer is numbers (rows x columns), with the given values and the answers that mistakes lead to.

    For a direction, `unit_entry` is the index (from 0) of the entry that is scaled to 1; None for other answers.
    """

    part: Part
    values: np.ndarray
    given_values: GivenValues | None
    wrong_answers: tuple[tuple[str, str, np.ndarray], ...]
    unit_entry: int | None = None


def ask_in_numbers(problem: Problem, part: Part) -> NumericPart | None:
    """Return a part with numbers as its answer; None if that is impossible.

    Raises QdotError if the two computations of the numbers do not agree.
    """
    answer = part.answer
    if answer.is_numeric and not answer.counts_up_to_a_factor:
        return _take_numbers(problem, part)
    if answer.is_numeric:
        number_part = replace(part, answer=_make_number(part, answer.as_matrix()))
        return _scale_direction(_take_numbers(problem, number_part, is_direction=True))
    if not answer.list_entries() or not is_derived(part):
        return None
    numeric_part = _evaluate_formulas(problem, part)
    return _scale_direction(numeric_part) if answer.counts_up_to_a_factor and numeric_part is not None else numeric_part


def _make_number(part: Part, values: sp.Matrix) -> Number:
    absolute_tolerance = ABSOLUTE_TOLERANCE * float(max(map(abs, values)))
    return Number(
        values, part.details.units or ("",) * len(values), inversion.THREE_DIGIT_TOLERANCE, absolute_tolerance
    )


def _take_numbers(problem: Problem, part: Part, is_direction: bool = False) -> NumericPart:
    answer = part.answer_as(Number)
    reference = _to_floats(answer)
    wrong_answers = [
        (mistake.title, name_chapter(mistake.sentence(mistaken.words)), _to_floats(mistaken.answer))
        for mistake, mistaken in catalogue.generate_mistaken_answers(problem.chain, part)
        if isinstance(mistaken.answer, Number)
    ]
    if is_derived(part):
        domain = _make_domain(problem, part)
        values = sample_configurations(problem.chain, part, domain, 1, Stream(f"{problem.id}/{part.name}/wrong"))
        working = compute_numeric_stages(problem.chain, values)
        _check_agreement(problem, part, reference, compute_answer(working, part)[..., 0], is_direction)
        wrong_answers += [
            _describe_wrong(mistake, mistake.answer[..., 0]) for mistake in _list_wrong_answers(working, part)
        ]
    return NumericPart(part, reference, None, tuple(wrong_answers))


def _to_floats(answer: Number) -> np.ndarray:
    return np.array(answer.reference.tolist(), dtype=float)


def _describe_wrong(wrong_answer: catalogue.PredictedAnswer, values: np.ndarray) -> tuple[str, str, np.ndarray]:
    return wrong_answer.mistake.title, name_chapter(wrong_answer.sentence), values


def _check_agreement(
    problem: Problem, part: Part, reference: np.ndarray, derived_values: np.ndarray, is_direction: bool
) -> None:
    """Raise QdotError unless both computations agree; directions are compared up to a factor."""
    if reference.shape == derived_values.shape and is_direction:
        largest_index = np.abs(reference).argmax()
        derived_values = derived_values / derived_values.ravel()[largest_index]
        reference = reference / reference.ravel()[largest_index]
    max_difference = MAX_DISAGREEMENT * max(np.abs(reference).max(), 1e-9)
    if reference.shape != derived_values.shape or not np.abs(reference - derived_values).max() <= max_difference:
        raise QdotError(f"{problem.id}: {part.name}: its numbers do not agree; please report it")


def _list_wrong_answers(w: StageResults, part: Part) -> list[catalogue.PredictedAnswer]:
    """Return the answers that mistakes lead to. If the derivation is long, only those in ONE_NUMBER are considered."""
    if w.n > MAX_JOINTS_FOR_ALL_MISTAKES and is_made_of_jacobian(part):
        mistakes = [m for m in catalogue.list_likely_mistakes(part) if m.name in catalogue.MISTAKES_FOR_ONE_NUMBER]
        return [wrong for mistake in mistakes for wrong in catalogue.apply_mistake(mistake, w, part)]
    return list(catalogue.predict_wrong_answers(w, part))


# --- formulas ---


def _evaluate_formulas(problem: Problem, part: Part) -> NumericPart | None:
    """Return a part with its formulas evaluated at the best of several sampled configurations."""
    chain, stream = problem.chain, Stream(f"qdot/{problem.id.engine}/{problem.id}/{part.name}/in numbers")
    reference = part.answer.as_matrix()
    configurations = list(_sample_configurations(chain, part, stream))
    values = _collect_values(chain, part, configurations)
    as_number = replace(part, answer=_make_number(part, sp.ones(*reference.shape)))
    working = compute_numeric_stages(chain, values)
    derived_answer = compute_answer(working, as_number)
    mistakes = [
        wrong for wrong in _list_wrong_answers(working, as_number) if wrong.answer.shape == derived_answer.shape
    ]
    best_index = _choose_configuration(derived_answer, mistakes)
    if best_index is None:
        return None
    exact_values = _evaluate_reference(reference, _add_given_joints(part, configurations[best_index]))
    as_number = replace(part, answer=_make_number(part, exact_values))
    float_values = np.array(exact_values.tolist(), dtype=float)
    _check_agreement(problem, part, float_values, derived_answer[..., best_index], part.answer.counts_up_to_a_factor)
    wrong_answers = tuple(_describe_wrong(wrong, wrong.answer[..., best_index]) for wrong in mistakes)
    given_values = _describe_given_values(chain, part, configurations[best_index], reference)
    return NumericPart(as_number, float_values, given_values, wrong_answers)


Configuration = dict[sp.Symbol, sp.Expr]


def _sample_configurations(chain: Chain, part: Part, stream: Stream) -> Iterator[Configuration]:
    """Yield values of all symbols, with joint values at which J is well-conditioned, if possible."""
    needs_full_rank = min(len(chain.task), chain.n) and not part.details.given_joints
    for _ in range(CONFIGURATION_COUNT):
        for _ in range(30):
            lengths = {
                symbol: _sample_angle(stream) if symbol.name.startswith(("alpha", "beta")) else value
                for symbol, value in sample_unequal_lengths(chain, stream).items()
            }
            joints = inversion.sample_joint_values(chain, stream)
            if (
                not needs_full_rank
                or inversion.compute_conditioning(chain, lengths, joints) > inversion.min_conditioning(chain) / 2
            ):
                break
        rate_values = {rate: sp.Rational(_sample_nonzero(stream, 9), 10) for rate in chain.rates}
        velocity_values = {sp.Symbol(row): sp.Rational(_sample_nonzero(stream, 8), 20) for row in chain.task}
        load_values = {sp.Symbol(name): sp.Integer(_sample_nonzero(stream, 20)) for name in part.symbols}
        yield {**lengths, **joints, **rate_values, **velocity_values, **load_values}


def _sample_angle(stream: Stream) -> sp.Expr:
    return sp.pi * sp.Rational(_sample_nonzero(stream, 16), 18)


def _sample_nonzero(stream: Stream, maximum: int) -> int:
    """Return a random nonzero integer from -maximum to maximum."""
    return stream.choice([k for k in range(-maximum, maximum + 1) if k])


def _add_given_joints(part: Part, configuration: Configuration) -> Configuration:
    """Return a configuration in which the joint values given by the question replace the sampled ones."""
    return {**configuration, **{q: value.xreplace(configuration) for q, value in part.details.given_joints.items()}}


def _collect_values(chain: Chain, part: Part, configurations: Sequence[Configuration]) -> SymbolValues:
    """Return the values (N,) of each symbol at all N configurations."""
    exact_configurations = [_add_given_joints(part, configuration) for configuration in configurations]
    columns = {
        symbol.name: np.array([float(configuration[symbol]) for configuration in exact_configurations])
        for symbol in exact_configurations[0]
    }
    other_names = {*domain_of(chain).roles} - set(columns)
    return columns | {name: np.ones(len(configurations)) for name in sorted(other_names)}


def _evaluate_reference(reference: sp.Matrix, values: Configuration) -> sp.Matrix:
    return reference.applyfunc(lambda entry: round_to_ten_digits(evaluate_in_context(entry.xreplace(values))))


def _choose_configuration(correct: np.ndarray, wrong_results: Sequence[catalogue.PredictedAnswer]) -> int | None:
    """Return the index of the best configuration, or None if none is usable.

    The best configuration has the fewest tiny entries. If several have equally few, the best one distinguishes the most
    mistakes.
    """
    max_entry = np.abs(correct).max(axis=(0, 1))
    max_values = np.nan_to_num(np.abs(correct)).max(axis=-1)
    is_nonzero = max_values > MAX_DISAGREEMENT * max_values.max()
    tiny_count = ((np.abs(correct) < TINY_SHARE * max_entry) & is_nonzero[..., None]).sum(axis=(0, 1))
    distinguished_count = np.zeros(correct.shape[-1], dtype=int)
    for mistake_result in wrong_results:
        difference = np.nan_to_num(np.abs(mistake_result.answer - correct), posinf=0.0)
        distinguished_count += difference.max(axis=(0, 1)) > MIN_DIFFERENCE * max_entry
    is_usable = np.isfinite(correct).all(axis=(0, 1)) & (max_entry > MAX_DISAGREEMENT)
    rankings = [(tiny_count[k], -distinguished_count[k], k) for k in range(correct.shape[-1]) if is_usable[k]]
    return min(rankings)[2] if rankings else None


def _scale_direction(direction: NumericPart) -> NumericPart:
    """Return a direction scaled so that its largest entry is 1, because only the direction matters."""
    unit = int(np.abs(np.round(direction.values, 6)).argmax())
    values = direction.values / direction.values.ravel()[unit]
    with np.errstate(all="ignore"):
        wrong_answers = tuple(
            (title, text, answer / answer.ravel()[unit]) for title, text, answer in direction.wrong_answers
        )
    reference = sp.Matrix(values.tolist())
    answer = Number(reference, ("",) * len(reference), inversion.THREE_DIGIT_TOLERANCE, ABSOLUTE_TOLERANCE)
    part = replace(direction.part, answer=answer)
    return NumericPart(part, values, direction.given_values, wrong_answers, unit)


# --- words ---


def _describe_given_values(chain: Chain, part: Part, configuration: Configuration, reference: sp.Matrix) -> GivenValues:
    """Return the given values: joint values that the prompt doesn't give, and all others that the answer depends on."""
    wording, used_symbols = Wording(chain), reference.free_symbols
    joints = tuple((tex(q), tex_value(configuration[q], q)) for q in chain.q if q not in part.details.given_joints)
    other_values: list[tuple[str, str]] = []
    if used_symbols & set(chain.rates):
        units = zip(chain.rates, wording.rate_units, strict=True)
        other_values += [(tex(rate, chain), rf"{tex(configuration[rate])}\,\text{{{unit}}}") for rate, unit in units]
    rows = [sp.Symbol(row) for row in chain.task]
    if used_symbols & set(rows):
        other_values += [(tex(row), wording.velocity_value(row, configuration[row])) for row in rows]
    other_values += [
        (tex(sp.Symbol(name)), rf"{tex(configuration[sp.Symbol(name)])}\,\text{{{info.unit}}}")
        for name, info in part.symbols.items()
    ]
    lengths_and_angles = {symbol: configuration[symbol] for symbol in chain.parameters}
    other_values += [(tex(s), _format_length_or_angle(s, value)) for s, value in lengths_and_angles.items()]
    values = {symbol.name: float(value) for symbol, value in _add_given_joints(part, configuration).items()}
    return GivenValues(joints, tuple(other_values), values)


def _format_length_or_angle(symbol: sp.Symbol, value: sp.Expr) -> str:
    return tex_angle(value) if symbol.name.startswith(("alpha", "beta")) else tex_length(value)


def _make_domain(problem: Problem, part: Part) -> Domain:
    """Return the domain of a problem's symbols, including those of the part."""
    roles: Mapping[str, Any] = domain_of(problem.chain).roles
    return Domain({**roles, **dict.fromkeys(part.symbols, "signed")})
