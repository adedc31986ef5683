"""Check numbers at a configuration with NumPy: joint rates, self-motions, manipulability and condition number."""

from collections.abc import Callable

import numpy as np
import sympy as sp

from qdot.exercises.formula.units import write_power_of_metres
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.inversion import VelocityDetails, find_min_conditioning
from qdot.exercises.reference_answers import Direction, Number
from qdot.exercises.verify.formulas import EXACT_TOLERANCE, PartCheck, check_agreement
from qdot.exercises.verify.numeric_model import Check, Checks, NumericModel, compute_conditioning_ratios

MIN_CONDITIONING_FACTOR = 0.7
"""Configurations are sampled with a minimum sigma_min/sigma_max; the check requires this fraction of the minimum."""

NUMBER_TOLERANCE = 1e-8
"""Relative error allowed for numbers of ten digits."""


def list_reference_numbers(part: Part) -> np.ndarray:
    """Return the numeric reference answer to a part, as an array of shape (1, rows, columns)."""
    return np.array(part.answer.as_matrix().tolist(), dtype=float)[None]


def check_three_digits(part: Part) -> Check:
    """Check that the reference's numbers are still accepted after rounding to three digits."""
    answer = part.answer_as(Number)
    exact_numbers = np.array([float(value) for value in answer.reference])
    rounded_numbers = np.array([float(f"{value:.2e}") for value in exact_numbers])
    is_accepted = bool(np.all(np.abs(rounded_numbers - exact_numbers) <= answer.list_allowed_errors(None)))
    return Check("three digits", is_accepted, "rounding keeps it right")


def _check_conditioning(model: NumericModel, jacobian: np.ndarray) -> Check:
    """Check that J is well conditioned at a configuration, so that small errors stay small."""
    ratio = float(compute_conditioning_ratios(jacobian))
    min_ratio = MIN_CONDITIONING_FACTOR * find_min_conditioning(model.chain)
    return Check("well conditioned", ratio > min_ratio, f"sigma_min/sigma_max = {ratio:.3f}")


def _check_rates(model: NumericModel, part: Part) -> Checks:
    """Compare the rates with the minimum-norm solution, which is the only solution if J is square."""
    configuration = part.details_as(VelocityDetails).configuration
    jacobian = model.jacobian_at(configuration)
    velocity = np.array([float(configuration.velocity[sp.Symbol(row)]) for row in model.chain.task])
    rates, expected = list_reference_numbers(part), np.linalg.pinv(jacobian) @ velocity
    yield check_agreement("pseudo-inverse", rates, expected[None, :, None], NUMBER_TOLERANCE)
    if rates.shape[1:] == (model.chain.n, 1):
        yield check_agreement("velocity", jacobian @ rates, velocity[None, :, None], NUMBER_TOLERANCE)
    yield _check_conditioning(model, jacobian)
    yield check_three_digits(part)


def _check_self_motion(model: NumericModel, part: Part) -> Checks:
    """Check that the Jacobian times the motion is zero and that the motion is not zero."""
    is_formula = part.answer_as(Direction).tolerance is None
    if is_formula:
        motion, jacobian = model.evaluate_printed_formulas(part.answer.as_matrix()), model.task_jacobian
    else:
        motion = list_reference_numbers(part)
        jacobian = model.jacobian_at(part.details_as(VelocityDetails).configuration)[None]
    norms = np.linalg.norm(motion, axis=1, keepdims=True) if np.all(np.isfinite(motion)) else np.zeros(1)
    if motion.shape[1:] != (model.chain.n, 1) or not np.all(norms > EXACT_TOLERANCE):
        yield Check("motion", False, f"no motion of {model.chain.n} joints at some place")
        return
    velocity = jacobian @ (motion / norms)
    yield check_agreement("null space", velocity, np.zeros((len(motion), len(model.task_rows), 1)), NUMBER_TOLERANCE)
    if not is_formula:
        yield check_agreement("unit vector", norms, np.ones((1, 1, 1)), NUMBER_TOLERANCE)
        yield _check_conditioning(model, jacobian[0])


def _make_measure_check(measure: Callable[[np.ndarray], float]) -> PartCheck:
    """Return the check that a number equals `measure(J)` for the task Jacobian J, which two methods compute."""

    def check(model: NumericModel, part: Part) -> Checks:
        configuration = part.details_as(VelocityDetails).configuration
        jacobian = model.jacobian_at(configuration)
        exponential_jacobian = model.exponential_jacobian_at(configuration)[model.task_rows]
        for name, matrix in (("singular values", jacobian), ("product of exponentials", exponential_jacobian)):
            expected = np.full((1, 1, 1), measure(matrix))
            yield check_agreement(name, list_reference_numbers(part), expected, NUMBER_TOLERANCE)
        yield _check_conditioning(model, jacobian)
        yield check_three_digits(part)
        if part.kind == "manipulability":
            yield _check_unit(model, part, jacobian)

    return check


def _check_unit(model: NumericModel, part: Part, jacobian: np.ndarray) -> Check:
    """Check the unit of the manipulability w by converting metres to half metres, which multiplies w by 2^k for m^k."""
    row_factors = np.array([[2.0 if row < 3 else 1.0] for row in model.task_rows])
    column_factors = np.array([1.0 if joint.is_revolute else 0.5 for joint in model.chain.joints])
    growth_factor = _compute_manipulability(jacobian * row_factors * column_factors) / _compute_manipulability(jacobian)
    power = round(float(np.log2(growth_factor)))
    unit = write_power_of_metres(power)
    is_power_of_two = abs(growth_factor - 2.0**power) < EXACT_TOLERANCE * growth_factor
    is_stated = part.answer_as(Number).units == (unit,)
    return Check("unit", bool(is_power_of_two and is_stated), f"{unit or 'a plain number'}")


def _compute_manipulability(jacobian: np.ndarray) -> float:
    """Return the product of the singular values, which is the manipulability."""
    return float(np.prod(np.linalg.svd(jacobian, compute_uv=False)))


CHECKS: dict[str, PartCheck] = {
    "joint-rates": _check_rates,
    "least-norm-rates": _check_rates,
    "self-motion": _check_self_motion,
    "manipulability": _make_measure_check(_compute_manipulability),
    "condition-number": _make_measure_check(lambda jacobian: float(np.linalg.cond(jacobian))),
}
