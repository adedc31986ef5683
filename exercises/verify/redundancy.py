"""Test det(J J^T), least-norm rates and self-motions: determinants, pseudo-inverse and null space by NumPy."""

from collections.abc import Callable, Iterator

import numpy as np

from qdot.exercises.answers import Direction, Number
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.inversion import InSituation, Situation, least_conditioning
from qdot.exercises.verify.formulas import EXACT, WELL_CONDITIONED, agree, expect_by_each_route, formula_check
from qdot.exercises.verify.numeric_reference import Check, NumericReference

NUMBERS = 1e-8
"""Relative error allowed for numbers of ten digits."""


def jacobian_at(numeric: NumericReference, situation: Situation) -> np.ndarray:
    """Return the task Jacobian of a situation (m x n), by products of 4 x 4 matrices."""
    arm = NumericChain(numeric.chain, {symbol.name: float(value) for symbol, value in situation.lengths.items()})
    return np.asarray(arm.jacobian(np.array([float(situation.joints[q]) for q in numeric.chain.q]))[numeric.task])


def reference_numbers(part: Part) -> np.ndarray:
    """Return a reference of numbers as (1, rows, columns)."""
    return np.array(part.answer.as_matrix().tolist(), dtype=float)[None]


def check_conditioning(numeric: NumericReference, jacobian: np.ndarray) -> Check:
    """Return the check that small errors stay small."""
    sigma = np.linalg.svd(jacobian, compute_uv=False)
    ratio = float(sigma[-1] / sigma[0])
    least = WELL_CONDITIONED * least_conditioning(numeric.chain)
    return Check("well conditioned", ratio > least, f"sigma_min/sigma_max = {ratio:.3f}")


def check_three_digits(part: Part, expected: np.ndarray) -> Check:
    """Return the check that a student who rounds the right numbers to three digits is right."""
    answer = part.of(Number)
    allowed = np.maximum(answer.tolerance * np.abs(expected), answer.floor)
    rounded = np.array([float(f"{value:.2e}") for value in expected])
    return Check("three digits", bool(np.all(np.abs(rounded - expected) <= allowed)), "rounding keeps it right")


def _gram(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    def determinant(jacobian: np.ndarray) -> np.ndarray:
        rows = jacobian[:, numeric.task]
        return np.asarray(np.linalg.det(rows @ rows.swapaxes(1, 2)))[:, None, None]

    return expect_by_each_route(numeric, determinant)


def _check_least_norm(numeric: NumericReference, part: Part) -> Iterator[Check]:
    """Find the rates by the singular value decomposition, and compare."""
    situation = part.about(InSituation).situation
    jacobian = jacobian_at(numeric, situation)
    velocity = np.array([float(value) for value in situation.velocity.values()])
    expected = np.linalg.pinv(jacobian) @ velocity
    claimed = reference_numbers(part)
    yield agree("pseudo-inverse", claimed, expected[None, :, None], NUMBERS)
    if claimed.shape[1:] == (numeric.chain.n, 1):
        yield agree("velocity", jacobian @ claimed, velocity[None, :, None], NUMBERS)
    yield check_conditioning(numeric, jacobian)
    yield check_three_digits(part, expected)


def _check_self_motion(numeric: NumericReference, part: Part) -> Iterator[Check]:
    """Test that the Jacobian times the motion is zero, and the motion is not."""
    answer = part.of(Direction)
    formulas = answer.tolerance is None
    claimed = numeric.read(part.answer.as_matrix()) if formulas else reference_numbers(part)
    situation = None if formulas else part.about(InSituation).situation
    jacobian = numeric.task_jacobian if situation is None else jacobian_at(numeric, situation)[None]
    size = np.linalg.norm(claimed, axis=1, keepdims=True) if np.all(np.isfinite(claimed)) else np.zeros(1)
    if claimed.shape[1:] != (numeric.chain.n, 1) or not np.all(size > EXACT):
        yield Check("motion", False, f"no motion of {numeric.chain.n} joints at some place")
        return
    yield agree("null space", jacobian @ (claimed / size), np.zeros((len(claimed), len(numeric.task), 1)), NUMBERS)
    if not formulas:
        yield agree("unit vector", size, np.ones((1, 1, 1)), NUMBERS)
        yield check_conditioning(numeric, jacobian[0])


CHECKS: dict[str, Callable[[NumericReference, Part], Iterator[Check]]] = {
    "gram-determinant": formula_check(_gram),
    "least-norm-rates": _check_least_norm,
    "self-motion": _check_self_motion,
}
