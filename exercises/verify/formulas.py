"""Tests of formulas and numbers: references evaluated at random places and held against the arm in numbers."""

from collections.abc import Callable, Iterator

import numpy as np
import sympy as sp

from qdot.exercises.answers import Number
from qdot.exercises.arm.chain import TASK_ROWS
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.differentiation import AlongAxis, moving_rows
from qdot.exercises.questions.inversion import InSituation, well_conditioned
from qdot.exercises.questions.propagation import OfFrame
from qdot.exercises.questions.recursion import FromFrameToFrame
from qdot.exercises.verify.numeric_reference import Check, NumericReference

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


Expected = Callable[[NumericReference, Part], dict[str, tuple[np.ndarray, float]]]


def formula(expected: Expected) -> Callable[[NumericReference, Part], Iterator[Check]]:
    """Return the check that a symbolic reference has the values expected, by each way of finding them."""

    def check(numeric: NumericReference, part: Part) -> Iterator[Check]:
        claimed = numeric.read(part.answer.as_matrix())
        for name, (values, allowed) in expected(numeric, part).items():
            yield agree(name, claimed, values, allowed)

    return check


def both(by_product: np.ndarray, by_difference: np.ndarray) -> dict[str, tuple[np.ndarray, float]]:
    """Return both ways of finding values, each with the error allowed."""
    return {"frames": (by_product, EXACT), "finite differences": (by_difference, DIFFERENCED)}


def each_way(
    numeric: NumericReference, take: Callable[[np.ndarray], np.ndarray]
) -> dict[str, tuple[np.ndarray, float]]:
    """Return what `take` makes of the 6 x n Jacobian: by propagation, finite differences and exponentials."""
    due = both(take(numeric.jacobian), take(numeric.differenced_jacobian))
    return {**due, "product of exponentials": (take(numeric.exponential_jacobian), EXACT)}


def _position(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"frames": (numeric.point[:, moving_rows(numeric.chain), None], EXACT)}


def _velocity(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    rows = moving_rows(numeric.chain)
    return each_way(numeric, lambda jacobian: jacobian[:, rows] @ numeric.rates)


def _component(numeric: NumericReference, part: Part) -> dict[str, tuple[np.ndarray, float]]:
    row = part.about(AlongAxis).row
    return each_way(numeric, lambda jacobian: jacobian[:, [row]] @ numeric.rates)


def _jacobian(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return each_way(numeric, lambda jacobian: jacobian[:, numeric.task])


def _axes(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"frames": (numeric.frames[:, :-1, :3, 2].transpose(0, 2, 1), EXACT)}


def _vectors(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    first, n = convention_of(numeric.chain).frame_on_axis(1), numeric.chain.n
    origins = numeric.told[:, first : first + n, :3, 3]
    return {"frames": ((numeric.point[:, None] - origins).transpose(0, 2, 1), EXACT)}


def _geometric(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    order = [TASK_ROWS.index(row) for row in convention_of(numeric.chain).velocities]
    return each_way(numeric, lambda jacobian: jacobian[:, order])


def _twist(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    order = [TASK_ROWS.index(row) for row in convention_of(numeric.chain).velocities]
    return each_way(numeric, lambda jacobian: jacobian[:, order] @ numeric.rates)


def _link_velocity(numeric: NumericReference, part: Part) -> dict[str, tuple[np.ndarray, float]]:
    frame = part.about(OfFrame).frame
    carried = numeric.told_carried[:, :, frame].transpose(0, 2, 1)
    return {"finite differences": (carried @ numeric.rates, DIFFERENCED)}


def _own_frame(numeric: NumericReference, part: Part) -> dict[str, tuple[np.ndarray, float]]:
    frame = part.about(FromFrameToFrame).frame
    moved = (numeric.told_carried[:, :, frame].transpose(0, 2, 1) @ numeric.rates)[..., 0]
    turn = numeric.told[:, frame, :3, :3].swapaxes(1, 2)
    own = np.concatenate([np.einsum("kij,kj->ki", turn, half) for half in (moved[:, :3], moved[:, 3:])], axis=1)
    return {"finite differences": (own[..., None], DIFFERENCED)}


def _determinant(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"LU decomposition": (np.linalg.det(numeric.task_jacobian)[:, None, None], EXACT)}


def _inverse(numeric: NumericReference, part: Part) -> Iterator[Check]:
    """Multiply the Jacobian by its inverse; the result is 1."""
    yield _undone(numeric, part, np.broadcast_to(np.eye(numeric.chain.n), numeric.task_jacobian.shape))


def _rate_law(numeric: NumericReference, part: Part) -> Iterator[Check]:
    """Multiply the Jacobian by the rates; the result is the velocity asked for."""
    yield _undone(numeric, part, numeric.velocity)


def _undone(numeric: NumericReference, part: Part, expected: np.ndarray) -> Check:
    claimed = numeric.read(part.answer.as_matrix())
    if claimed.shape != expected.shape:
        return agree("J times it", claimed, expected, EXACT)
    size = (np.abs(numeric.task_jacobian) @ np.abs(claimed)).max(axis=(1, 2), keepdims=True)
    return agree("J times it", numeric.task_jacobian @ claimed / size, expected / size, EXACT)


def _joint_rates(numeric: NumericReference, part: Part) -> Iterator[Check]:
    """Solve J qd = v in floating point, at a pose where small errors stay small."""
    situation = part.about(InSituation).situation
    arm = NumericChain(numeric.chain, {symbol.name: float(value) for symbol, value in situation.lengths.items()})
    jacobian = arm.jacobian(np.array([float(situation.joints[q]) for q in numeric.chain.q]))[numeric.task]
    velocity = np.array([float(situation.velocity[sp.Symbol(row)]) for row in numeric.chain.task])
    expected = np.linalg.solve(jacobian, velocity)
    claimed = np.array(part.answer.as_matrix().tolist(), dtype=float)
    yield agree("linear solve", claimed[None], expected[None, :, None], 1e-8)
    sigma = np.linalg.svd(jacobian, compute_uv=False)
    detail = f"sigma_min/sigma_max = {sigma[-1] / sigma[0]:.3f}"
    enough = WELL_CONDITIONED * well_conditioned(numeric.chain)
    yield Check("well conditioned", bool(sigma[-1] / sigma[0] > enough), detail)
    yield three_digits(part)


def three_digits(part: Part) -> Check:
    """Look whether numbers stay right when they are rounded to three digits."""
    answer = part.of(Number)
    due = np.array([float(value) for value in answer.reference])
    rounded = np.array([float(f"{value:.2e}") for value in due])
    return Check("three digits", bool(np.all(np.abs(rounded - due) <= answer.room(None))), "rounding keeps it right")


CHECKS: dict[str, Callable[[NumericReference, Part], Iterator[Check]]] = {
    "position": formula(_position),
    "velocity": formula(_velocity),
    "velocity-component": formula(_component),
    "jacobian": formula(_jacobian),
    "joint-axes": formula(_axes),
    "position-vectors": formula(_vectors),
    "geometric-jacobian": formula(_geometric),
    "twist": formula(_twist),
    "link-velocity": formula(_link_velocity),
    "own-frame-velocity": formula(_own_frame),
    "determinant": formula(_determinant),
    "inverse-jacobian": _inverse,
    "inverse-velocity": _rate_law,
    "joint-rates": _joint_rates,
}
