"""Tests of formulas and numbers: references evaluated at random places and held against the arm in numbers."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import sympy as sp

from exercises.answers import Number
from exercises.arm.kinematics import NumericChain
from exercises.problem import Part
from exercises.questions.differentiation import moving_rows
from exercises.questions.inversion import well_conditioned
from exercises.verify.ground import Check, Ground

WELL_CONDITIONED = 0.7
"""Least sigma_min/sigma_max of a pose given in numbers, of what was asked for when it was drawn."""

EXACT, DIFFERENCED = 1e-9, 1e-7
"""Relative error allowed against products of matrices, and against finite differences of them."""


def agree(name: str, found: np.ndarray, expected: np.ndarray, allowed: float) -> Check:
    """Hold values against those expected, both (…, rows, columns)."""
    if found.shape != expected.shape:
        shapes = [" x ".join(map(str, array.shape[1:])) for array in (found, expected)]
        return Check(name, False, f"the reference is {shapes[0]}, expected {shapes[1]}")
    scale = 1 + np.abs(expected).max(axis=(1, 2), keepdims=True)
    error = np.where(np.isfinite(found), np.abs(found - expected) / scale, np.inf)
    worst = np.unravel_index(int(error.argmax()), error.shape)
    if error[worst] <= allowed:
        return Check(name, True, f"{len(found)} places, error at most {error[worst]:.1e}")
    row, column = worst[1] + 1, worst[2] + 1
    return Check(name, False, f"entry ({row}, {column}): {found[worst]:.6g}, expected {expected[worst]:.6g}")


Expected = Callable[[Ground, Part], dict[str, tuple[np.ndarray, float]]]


def formula(expected: Expected) -> Callable[[Ground, Part], Iterator[Check]]:
    """Return the check that a symbolic reference has the values expected, by each way of finding them."""

    def check(ground: Ground, part: Part) -> Iterator[Check]:
        found = ground.read(part.answer.as_matrix())
        for name, (values, allowed) in expected(ground, part).items():
            yield agree(name, found, values, allowed)

    return check


def both(by_product: np.ndarray, by_difference: np.ndarray) -> dict[str, tuple[np.ndarray, float]]:
    """Return both ways of finding values, each with the error allowed."""
    return {"frames": (by_product, EXACT), "finite differences": (by_difference, DIFFERENCED)}


def each_way(ground: Ground, take: Callable[[np.ndarray], np.ndarray]) -> dict[str, tuple[np.ndarray, float]]:
    """Return what `take` makes of the 6 x n Jacobian: by propagation, finite differences and exponentials."""
    found = both(take(ground.jacobian), take(ground.differenced_jacobian))
    return {**found, "product of exponentials": (take(ground.exponential_jacobian), EXACT)}


def _position(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"frames": (ground.point[:, moving_rows(ground.chain), None], EXACT)}


def _velocity(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    rows = moving_rows(ground.chain)
    return each_way(ground, lambda jacobian: jacobian[:, rows] @ ground.rates)


def _component(ground: Ground, part: Part) -> dict[str, tuple[np.ndarray, float]]:
    row = "xyz".index(str(part.details["axis"]))
    return each_way(ground, lambda jacobian: jacobian[:, [row]] @ ground.rates)


def _jacobian(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return each_way(ground, lambda jacobian: jacobian[:, ground.task])


def _axes(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"frames": (ground.frames[:, :-1, :3, 2].transpose(0, 2, 1), EXACT)}


def _vectors(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"frames": ((ground.point[:, None] - ground.frames[:, :-1, :3, 3]).transpose(0, 2, 1), EXACT)}


def _geometric(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return each_way(ground, lambda jacobian: jacobian)


def _twist(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return each_way(ground, lambda jacobian: jacobian @ ground.rates)


def _link_velocity(ground: Ground, part: Part) -> dict[str, tuple[np.ndarray, float]]:
    frame = int(str(part.details["frame"]))
    carried = ground.carried[:, :, frame].transpose(0, 2, 1)
    return {"finite differences": (carried @ ground.rates, DIFFERENCED)}


def _determinant(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"LU decomposition": (np.linalg.det(ground.task_jacobian)[:, None, None], EXACT)}


def _inverse(ground: Ground, part: Part) -> Iterator[Check]:
    """Multiply the Jacobian by its inverse; the result is 1."""
    yield _undone(ground, part, np.broadcast_to(np.eye(ground.chain.n), ground.task_jacobian.shape))


def _rate_law(ground: Ground, part: Part) -> Iterator[Check]:
    """Multiply the Jacobian by the rates; the result is the velocity asked for."""
    yield _undone(ground, part, ground.velocity)


def _undone(ground: Ground, part: Part, expected: np.ndarray) -> Check:
    found = ground.read(part.answer.as_matrix())
    if found.shape != expected.shape:
        return agree("J times it", found, expected, EXACT)
    size = (np.abs(ground.task_jacobian) @ np.abs(found)).max(axis=(1, 2), keepdims=True)
    return agree("J times it", ground.task_jacobian @ found / size, expected / size, EXACT)


def _joint_rates(ground: Ground, part: Part) -> Iterator[Check]:
    """Solve J qd = v in floating point, at a pose where small errors stay small."""
    situation: Any = part.details["situation"]
    arm = NumericChain(ground.chain, {symbol.name: float(value) for symbol, value in situation.lengths.items()})
    jacobian = arm.jacobian(np.array([float(situation.joints[q]) for q in ground.chain.q]))[ground.task]
    velocity = np.array([float(situation.velocity[sp.Symbol(row)]) for row in ground.chain.task])
    expected = np.linalg.solve(jacobian, velocity)
    found = np.array(part.answer.as_matrix().tolist(), dtype=float)
    yield agree("linear solve", found[None], expected[None, :, None], 1e-8)
    sigma = np.linalg.svd(jacobian, compute_uv=False)
    detail = f"sigma_min/sigma_max = {sigma[-1] / sigma[0]:.3f}"
    enough = WELL_CONDITIONED * well_conditioned(ground.chain)
    yield Check("well conditioned", bool(sigma[-1] / sigma[0] > enough), detail)
    answer = part.of(Number)
    allowed = np.maximum(answer.tolerance * np.abs(expected), answer.floor)
    rounded = np.array([float(f"{value:.2e}") for value in expected])
    yield Check("three digits", bool(np.all(np.abs(rounded - expected) <= allowed)), "rounding keeps it right")


CHECKS: dict[str, Callable[[Ground, Part], Iterator[Check]]] = {
    "position": formula(_position),
    "velocity": formula(_velocity),
    "velocity-component": formula(_component),
    "jacobian": formula(_jacobian),
    "joint-axes": formula(_axes),
    "position-vectors": formula(_vectors),
    "geometric-jacobian": formula(_geometric),
    "twist": formula(_twist),
    "link-velocity": formula(_link_velocity),
    "determinant": formula(_determinant),
    "inverse-jacobian": _inverse,
    "inverse-velocity": _rate_law,
    "joint-rates": _joint_rates,
}
