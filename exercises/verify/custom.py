"""Check the answers of custom questions against numbers from the arm's geometry and from finite differences."""

import ast
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.derivation.arithmetic import compile_expressions
from qdot.exercises.formula.program import evaluate
from qdot.exercises.problem.problem import Part, list_table_numbers
from qdot.exercises.questions.custom.question import CustomDetails, DefinitionEvaluator
from qdot.exercises.questions.language import compute
from qdot.exercises.questions.quantities import (
    NUMPY_FUNCTIONS,
    STENCIL,
    STEP,
    list_result_names,
    name_accelerations,
    name_load,
    parse_frame_name,
    select_components,
)
from qdot.exercises.reference_answers import ConditionSet, Number
from qdot.exercises.singularities.singular_set import Component
from qdot.exercises.verify.formulas import DIFFERENCE_TOLERANCE, check_agreement
from qdot.exercises.verify.numeric_model import (
    Check,
    Checks,
    NumericModel,
    choose_random_configurations,
    compute_exponential_jacobian,
    compute_modified_frames,
)


class ArmConfigurations(NamedTuple):
    """An arm with numeric lengths, these lengths by name, and several configurations of the arm, (k, n)."""

    arm: NumericChain
    lengths: dict[str, float]
    q: np.ndarray


@lru_cache(maxsize=64)
def _make_arm(chain: Chain, lengths: tuple[tuple[str, float], ...]) -> NumericChain:
    return NumericChain(chain, dict(lengths))


class GeometryQuantities:
    """The named quantities of an arm at N configurations, from products of 4 x 4 matrices and exponentials.

    `values` has the values (N,) of all symbols, and `step` is the size of a step of differences. No derivation is used.
    """

    def __init__(self, chain: Chain, values: Mapping[str, np.ndarray], step: float = STEP) -> None:
        self.chain, self.values, self.step = chain, dict(values), step
        self.count = len(next(iter(self.values.values())))
        self.numbers = list_table_numbers(chain)
        self.q = np.stack([self.values[q.name] for q in chain.q], axis=1)

    def halve_step(self) -> "GeometryQuantities":
        """Return the same quantities, with differences of half the step."""
        quantities = copy(self)
        quantities.step = self.step / 2
        return quantities

    @property
    def names(self) -> tuple[str, ...]:
        """All names that a formula may contain, except those of functions."""
        return (*list_result_names(self.chain), *self.values, *self.numbers, "pi")

    @cached_property
    def configurations_by_arm(self) -> list[ArmConfigurations]:
        """The configurations in their order, grouped by arm; consecutive ones with equal lengths share an arm."""
        names = [symbol.name for symbol in self.chain.parameters]
        lengths = np.stack([self.values[name] for name in names], axis=1) if names else np.zeros((self.count, 0))
        starts = [0, *(np.flatnonzero((lengths[1:] != lengths[:-1]).any(axis=1)) + 1).tolist()]
        lengths_by_name = [dict(zip(names, map(float, lengths[start]), strict=True)) for start in starts]
        pairs = zip(lengths_by_name, np.split(self.q, starts[1:]), strict=True)
        return [ArmConfigurations(_make_arm(self.chain, tuple(values.items())), values, q) for values, q in pairs]

    @cached_property
    def point(self) -> np.ndarray:
        """The position of the point, (3, N)."""
        return np.concatenate([arm.compute_point(q) for arm, _, q in self.configurations_by_arm]).T

    @cached_property
    def jacobian(self) -> np.ndarray:
        """The geometric Jacobian by exponentials, (6, n, N)."""
        jacobians = [compute_exponential_jacobian(arm, q) for arm, _, q in self.configurations_by_arm]
        return np.moveaxis(np.concatenate(jacobians), 0, -1)

    @cached_property
    def frames(self) -> np.ndarray:
        """The frames of the arm's convention, (n + 1, 4, 4, N)."""
        is_proximal = convention_of(self.chain).is_proximal
        frames = [
            compute_modified_frames(self.chain, lengths, q) if is_proximal else arm.compute_frames(q)
            for arm, lengths, q in self.configurations_by_arm
        ]
        return np.moveaxis(np.concatenate(frames), 0, -1)

    def look_up(self, name: str) -> np.ndarray | None:
        """Return the value of a name, (…, N); None if it is unknown."""
        if name in self.values:
            return self.values[name]
        if name == "pi" or name in self.numbers:
            return np.full(self.count, float(sp.pi if name == "pi" else self.numbers[name]))
        chain = self.chain
        vectors: dict[str, Sequence[Any]] = {"q": chain.q, "qd": chain.rates, "xd": chain.task}
        vectors |= {"qdd": name_accelerations(chain), "f": name_load(chain)}
        if name in vectors:
            return np.stack([self.values[str(symbol)] for symbol in vectors[name]])
        rows = {"J": chain.task_rows, "Jv": [0, 1, 2], "Jw": [3, 4, 5], "v": [0, 1, 2], "w": [3, 4, 5]}
        if name in rows:
            matrix = self.jacobian[rows[name]]
            rates = np.stack([self.values[rate.name] for rate in chain.rates])
            return np.einsum("ijk,jk->ik", matrix, rates) if name in "vw" else matrix
        if name == "p":
            return self.point
        frame_name = parse_frame_name(name, chain)
        if frame_name is None:
            return None
        letter, first_frame, last_frame = frame_name
        if letter in "oxyz":
            return np.asarray(self.frames[first_frame][:3, "xyzo".index(letter)])
        relative_pose = np.einsum("ijk,jlk->ilk", self._invert(self.frames[first_frame]), self.frames[last_frame])
        return relative_pose if letter == "T" else relative_pose[:3, :3]

    @staticmethod
    def _invert(pose: np.ndarray) -> np.ndarray:
        return np.moveaxis(np.linalg.inv(np.moveaxis(pose, -1, 0)), 0, -1)

    def make_constant(self, value: Fraction) -> np.ndarray:
        """Return a number, (N,)."""
        return np.full(self.count, float(value))

    def apply(self, function: str, value: np.ndarray) -> np.ndarray:
        """Return a function of each entry."""
        with np.errstate(all="ignore"):
            return np.asarray(NUMPY_FUNCTIONS[function](value))

    @property
    def time_rates(self) -> Mapping[str, np.ndarray]:
        """The rate of each symbol that changes with time."""
        chain = self.chain
        rates = {q.name: self.values[rate.name] for q, rate in zip(chain.q, chain.rates, strict=True)}
        accelerations = zip(chain.rates, name_accelerations(chain), strict=True)
        return rates | {rate.name: self.values[name] for rate, name in accelerations if name in self.values}

    def differentiate(self, formula: ast.expr, rates: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the derivative by central differences; the formula is evaluated once, at all steps together."""
        shifts = self.step * np.array([sign * steps for steps, _ in STENCIL for sign in (1, -1)])
        weights = np.array([sign * weight / self.step for _, weight in STENCIL for sign in (1, -1)])
        values = {name: np.repeat(value, len(shifts)) for name, value in self.values.items()}
        for name, rate in rates.items():
            values[name] += (rate[:, None] * shifts).ravel()
        results = compute(formula, GeometryQuantities(self.chain, values, self.step))
        return np.asarray(results.reshape(*results.shape[:-1], self.count, len(shifts)) @ weights)

    def substitute_values(self, formula: ast.expr, values: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the value of a formula at other values of some symbols."""
        return compute(formula, GeometryQuantities(self.chain, {**self.values, **values}, self.step))


def check_custom(model: NumericModel, part: Part) -> Checks:
    """Check the answer of a custom question, according to its type."""
    details = part.details_as(CustomDetails)
    evaluator = DefinitionEvaluator(details.definition)
    if details.definition.options:
        yield from _check_options(model, part, evaluator)
    elif isinstance(part.answer, ConditionSet):
        yield from _check_zeros(model, part.answer, evaluator)
    elif isinstance(part.answer, Number):
        yield _check_number(model, part.answer, details, evaluator)
    elif evaluator.formulas:
        yield from _check_formula(model, part, evaluator)


@lru_cache(maxsize=1)
def _make_quantities(model: NumericModel) -> GeometryQuantities:
    """Return the quantities at the configurations of a model; all parts of a problem share them."""
    return GeometryQuantities(model.chain, model.symbol_values)


def _convert_to_matrices(value: np.ndarray) -> np.ndarray:
    """Return a value (…, N) as matrices (N, rows, columns)."""
    rows = value[None] if value.ndim == 1 else value
    return np.moveaxis(rows if rows.ndim == 3 else rows[:, None], -1, 0)


MAX_HALVINGS, MIN_PRECISE_FRACTION = 6, 1 / 3
"""How often the step of differences is halved, and the fraction of the samples at which they must be precise."""


def _check_agreement(evaluator: DefinitionEvaluator, quantities: GeometryQuantities, reference: np.ndarray) -> Check:
    """Check that the reference, (N, rows, columns), agrees with numbers from the geometry and from differences.

    The step is halved until two results agree, because the usual step is too long near a pole or a corner. Samples at
    which no step is precise prove nothing, and are left out.
    """
    name, expected, finer_quantities = "geometry and differences", np.array(np.nan), quantities
    error, coarser_result = np.array(np.inf), expected
    for _ in range(MAX_HALVINGS):
        value = compute(evaluator.formulas[0], finer_quantities)
        result = _convert_to_matrices(select_components(value, evaluator.definition.rows))
        with np.errstate(invalid="ignore"):
            scale = 1 + np.abs(result).max(axis=(1, 2))
            difference = np.abs(result - coarser_result).max(axis=(1, 2)) / scale
        expected = np.where((difference < error)[:, None, None], result, expected)
        error, coarser_result = np.fmin(error, difference), result
        finer_quantities = finer_quantities.halve_step()
        is_precise = error < DIFFERENCE_TOLERANCE / 10
        if is_precise.all():
            break
    else:
        is_precise |= np.isnan(coarser_result).any(axis=(1, 2))  # an undefined number agrees with no reference
        if is_precise.mean() < MIN_PRECISE_FRACTION:
            return Check(name, False, "the differences are not precise enough to compare the reference with them")
    return check_agreement(name, reference[is_precise], expected[is_precise], DIFFERENCE_TOLERANCE)


def _check_formula(model: NumericModel, part: Part, evaluator: DefinitionEvaluator) -> Checks:
    reference = model.evaluate_printed_formulas(part.answer.as_matrix())
    yield _check_agreement(evaluator, _make_quantities(model), reference)
    is_varying = bool(np.ptp(reference, axis=0).max() > DIFFERENCE_TOLERANCE)
    detail = "its values differ between configurations" if is_varying else "it is constant"
    yield Check("it varies", is_varying, detail)


def _check_number(model: NumericModel, answer: Number, details: CustomDetails, evaluator: DefinitionEvaluator) -> Check:
    values = {name: value[:1] for name, value in model.symbol_values.items()}
    given_values = details.list_given_values(model.chain)
    values |= {name: np.array([number]) for name, number in given_values.items()}
    reference = np.array(answer.reference.tolist(), dtype=float)[None]
    return _check_agreement(evaluator, GeometryQuantities(model.chain, values), reference)


# --- options ---


def _check_options(model: NumericModel, part: Part, evaluator: DefinitionEvaluator) -> Checks:
    """Check that no two options have the same value, at several configurations."""
    details, quantities = part.details_as(CustomDetails), _make_quantities(model)
    formulas = ((index, evaluator.option_formulas[index]) for index in details.order)
    values = [(index, compute(formula, quantities)) for index, formula in formulas if formula is not None]
    pairs = [(first, second) for k, first in enumerate(values) for second in values[k + 1 :]]
    equal_pairs = [
        f"{details.definition.options[i].content} and {details.definition.options[j].content}"
        for (i, a), (j, b) in pairs
        if a.shape == b.shape and np.allclose(a, b, rtol=1e-9, atol=1e-9)
    ]
    detail = f"{equal_pairs[0]} are equal" if equal_pairs else f"{len(part.answer.offered_options)} options"
    yield Check("options differ", not equal_pairs, detail)
    contents = [details.definition.options[index].content for index in details.order]
    yield Check("options have different texts", len(set(contents)) == len(contents), ", ".join(contents))


# --- configurations at which formulas are zero ---

START_COUNT, STEP_COUNT = 16, 25
"""Number of configurations from which searches for zeros start, and number of Newton steps in each search."""
ZERO_TOLERANCE, MATCH_TOLERANCE, DIFFERENCE_STEP, NEAR_ZERO = 1e-9, 1e-5, 1e-6, 1e-11
"""Tolerances for zero and for a configuration, step of differences, and a small distance from a zero.

A formula is also evaluated at this distance from a zero, because it may be undefined at the zero itself.
"""

Function = Callable[[np.ndarray], np.ndarray]
"""A function of configurations (N, n) with values (N, m)."""


def _check_zeros(model: NumericModel, answer: ConditionSet, evaluator: DefinitionEvaluator) -> Checks:
    """Check that the formulas vanish at the listed configurations, and that Newton's method finds no other zero."""
    chain = model.chain
    lengths = {symbol.name: float(model.symbol_values[symbol.name][0]) for symbol in chain.parameters}

    def evaluate_formulas(q: np.ndarray) -> np.ndarray:
        values = {name: np.resize(value, len(q)) for name, value in model.symbol_values.items()}
        values |= {name: np.full(len(q), length) for name, length in lengths.items()}
        values |= {joint.name: q[:, i] for i, joint in enumerate(chain.q)}
        quantities = GeometryQuantities(chain, values)
        return np.stack([compute(formula, quantities) for formula in evaluator.formulas], axis=1)

    starts = choose_random_configurations(chain, model.rng, START_COUNT)
    zeros = _find_zeros(evaluate_formulas, starts)
    functions = [_make_distance_function(component, chain, lengths) for component in answer.components]
    is_listed = np.array([np.abs(function(zeros)).max(axis=1) < MATCH_TOLERANCE for function in functions]).any(axis=0)
    missing_zeros = zeros[~is_listed] if functions else zeros
    detail = f"{len(zeros)} zeros found by Newton's method"
    if len(missing_zeros):
        detail = f"{np.round(missing_zeros[0], 4)} is a zero, too"
    yield Check("complete", not len(missing_zeros), detail)
    for component, function in zip(answer.components, functions, strict=True):
        listed_zeros = _find_zeros(function, starts[:6])  # fewer starts suffice to find one zero of each component
        near_zeros = np.concatenate([listed_zeros, listed_zeros + NEAR_ZERO])  # sin(2*x)/sin(x) is undefined at 0
        if len(listed_zeros) and not np.fmax.reduce(np.abs(evaluate_formulas(near_zeros)), axis=None) < MATCH_TOLERANCE:
            yield Check("sound", False, f"the formulas are not zero at {component.list_pieces()[0]}")
            return
    yield Check("sound", True, "the formulas vanish at each listed configuration")


def _make_distance_function(component: Component, chain: Chain, lengths: Mapping[str, float]) -> Function:
    """Return a function that vanishes on a component: its conditions, or the differences from its joint values."""
    if component.solutions is None:
        programs = [compile_expressions(condition) for condition in component.conditions]

        def evaluate_conditions(q: np.ndarray) -> np.ndarray:
            values = {name: np.full(len(q), value) for name, value in lengths.items()}
            values |= {joint.name: column for joint, column in zip(chain.q, q.T, strict=True)}
            return np.stack([evaluate(program, values, len(q)).values[0].real for program in programs], axis=1)

        return evaluate_conditions
    numbers = {sp.Symbol(name): sp.Float(value) for name, value in lengths.items()}
    columns = []
    for joint, values in component.solutions:
        index, real_values = chain.q.index(joint), [_find_real_value(value.xreplace(numbers)) for value in values]
        columns.append((index, chain.joints[index].is_revolute, real_values))

    def measure_distances(q: np.ndarray) -> np.ndarray:
        distances = []
        for index, is_angle, values in columns:
            differences = q[:, [index]] - np.array(values)
            if is_angle:
                differences = (differences + np.pi) % (2 * np.pi) - np.pi
            nearest = np.abs(differences).argmin(axis=1)
            distances.append(np.take_along_axis(differences, nearest[:, None], axis=1)[:, 0])
        return np.stack(distances, axis=1)

    return measure_distances


def _find_real_value(formula: sp.Expr) -> float:
    """Return the value of a constant formula; nan if it is not real, such as the acos of 2."""
    value = complex(sp.N(formula))
    return value.real if abs(value.imag) < ZERO_TOLERANCE else np.nan


def _find_zeros(function: Function, starts: np.ndarray) -> np.ndarray:
    """Return the zeros of a function that Newton's method finds from some configurations.

    Each step is the smallest that solves the linearized equations. It changes no joint variable by more than 0.5 rad or
    0.5 m.
    """
    q, joint_count = starts.copy(), starts.shape[1]
    nudges = DIFFERENCE_STEP * np.concatenate([np.zeros((1, joint_count)), np.eye(joint_count), -np.eye(joint_count)])
    with np.errstate(all="ignore"):
        for _ in range(STEP_COUNT):
            all_values = function((q + nudges[:, None]).reshape(-1, joint_count)).reshape(len(nudges), len(q), -1)
            values, nudged_values = all_values[0], all_values[1:].reshape(2, joint_count, len(q), -1)
            if (np.abs(values).max(axis=1) < ZERO_TOLERANCE).all() or not np.isfinite(values).all():
                break
            slopes = np.moveaxis(nudged_values[0] - nudged_values[1], 0, -1) / (2 * DIFFERENCE_STEP)
            inverse = np.linalg.pinv(np.nan_to_num(slopes), rcond=1e-6)
            steps = (inverse @ np.nan_to_num(values)[:, :, None])[:, :, 0]
            q = q - steps * np.minimum(1.0, 0.5 / np.maximum(np.abs(steps).max(axis=1, keepdims=True), 1e-12))
        return q[np.abs(function(q)).max(axis=1) < ZERO_TOLERANCE]
