"""Tests of det(J J^T), least-norm rates and self-motions: determinants, pseudo-inverse and null space by NumPy."""

from collections.abc import Callable, Iterator

import numpy as np

from qdot.exercises.answers import Direction, Number
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.inversion import InSituation, Situation, well_conditioned
from qdot.exercises.verify.formulas import EXACT, WELL_CONDITIONED, agree, each_way, formula
from qdot.exercises.verify.numeric_reference import Check, NumericReference

NUMBERS = 1e-8
"""Relative error allowed of numbers that are given to ten digits."""


def jacobian_at(numeric: NumericReference, situation: Situation) -> np.ndarray:
    """Return the task Jacobian of a situation (m x n), by products of 4 x 4 matrices."""
    arm = NumericChain(numeric.chain, {symbol.name: float(value) for symbol, value in situation.lengths.items()})
    return np.asarray(arm.jacobian(np.array([float(situation.joints[q]) for q in numeric.chain.q]))[numeric.task])


def numbers(part: Part) -> np.ndarray:
    """Return a reference of numbers as (1, rows, columns)."""
    return np.array(part.answer.as_matrix().tolist(), dtype=float)[None]


def stays_small(numeric: NumericReference, jacobian: np.ndarray) -> Check:
    """Return the check that small errors stay small."""
    sigma = np.linalg.svd(jacobian, compute_uv=False)
    ratio = float(sigma[-1] / sigma[0])
    least = WELL_CONDITIONED * well_conditioned(numeric.chain)
    return Check("well conditioned", ratio > least, f"sigma_min/sigma_max = {ratio:.3f}")


def three_digits(part: Part, expected: np.ndarray) -> Check:
    """Return the check that a student who rounds the right numbers to three digits is right."""
    answer = part.of(Number)
    allowed = np.maximum(answer.tolerance * np.abs(expected), answer.floor)
    rounded = np.array([float(f"{value:.2e}") for value in expected])
    return Check("three digits", bool(np.all(np.abs(rounded - expected) <= allowed)), "rounding keeps it right")


def _gram(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    def determinant(jacobian: np.ndarray) -> np.ndarray:
        rows = jacobian[:, numeric.task]
        return np.asarray(np.linalg.det(rows @ rows.swapaxes(1, 2)))[:, None, None]

    return each_way(numeric, determinant)


def _least_norm(numeric: NumericReference, part: Part) -> Iterator[Check]:
    """Find the rates by the singular value decomposition, and hold them against others with the same velocity."""
    situation = part.about(InSituation).situation
    jacobian = jacobian_at(numeric, situation)
    velocity = np.array([float(value) for value in situation.velocity.values()])
    expected = np.linalg.pinv(jacobian) @ velocity
    claimed = numbers(part)
    yield agree("pseudo-inverse", claimed, expected[None, :, None], NUMBERS)
    if claimed.shape[1:] == (numeric.chain.n, 1):
        yield agree("velocity", jacobian @ claimed, velocity[None, :, None], NUMBERS)
    yield stays_small(numeric, jacobian)
    yield three_digits(part, expected)


def _self_motion(numeric: NumericReference, part: Part) -> Iterator[Check]:
    """Multiply the Jacobian by the motion; the result is zero, and the motion is not."""
    answer = part.of(Direction)
    formulas = answer.tolerance is None
    claimed = numeric.read(part.answer.as_matrix()) if formulas else numbers(part)
    given = None if formulas else part.about(InSituation).situation
    jacobian = numeric.task_jacobian if given is None else jacobian_at(numeric, given)[None]
    size = np.linalg.norm(claimed, axis=1, keepdims=True) if np.all(np.isfinite(claimed)) else np.zeros(1)
    if claimed.shape[1:] != (numeric.chain.n, 1) or not np.all(size > EXACT):
        yield Check("motion", False, f"no motion of {numeric.chain.n} joints at some place")
        return
    yield agree("null space", jacobian @ (claimed / size), np.zeros((len(claimed), len(numeric.task), 1)), NUMBERS)
    if not formulas:
        yield agree("unit vector", size, np.ones((1, 1, 1)), NUMBERS)
        yield stays_small(numeric, jacobian[0])


CHECKS: dict[str, Callable[[NumericReference, Part], Iterator[Check]]] = {
    "gram-determinant": formula(_gram),
    "least-norm-rates": _least_norm,
    "self-motion": _self_motion,
}
