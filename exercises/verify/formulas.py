"""Test formulas and numbers: evaluate references at random places and compare them with the arm in numbers."""

from collections.abc import Callable, Iterator

import numpy as np
import sympy as sp

from qdot.exercises.answers import Number
from qdot.exercises.arm.chain import TASK_ROWS
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.differentiation import AlongAxis, moving_rows
from qdot.exercises.questions.inversion import InSituation, least_conditioning
from qdot.exercises.questions.propagation import OfFrame
from qdot.exercises.questions.recursion import FromFrameToFrame
from qdot.exercises.verify.numeric_reference import Check, NumericReference

WELL_CONDITIONED = 0.7
"""Least sigma_min/sigma_max of a pose in numbers, as a part of what was required when it was sampled."""

EXACT, DIFFERENCED = 1e-9, 1e-7
"""Relative error allowed against products of matrices, and against finite differences of them."""


def agree(name: str, values: np.ndarray, expected: np.ndarray, allowed: float) -> Check:
    """Compare values with those expected, both (…, rows, columns)."""
    if values.shape != expected.shape:
        shapes = [" x ".join(map(str, array.shape[1:])) for array in (values, expected)]
        return Check(name, False, f"the reference is {shapes[0]}, expected {shapes[1]}")
    scale = 1 + np.abs(expected).max(axis=(1, 2), keepdims=True)
    error = np.where(np.isfinite(values), np.abs(values - expected) / scale, np.inf)
    worst = np.unravel_index(int(error.argmax()), error.shape)
    if error[worst] <= allowed:
        return Check(name, True, f"{len(values)} places, error at most {error[worst]:.1e}")
    row, column = worst[1] + 1, worst[2] + 1
    return Check(name, False, f"entry ({row}, {column}): {values[worst]:.6g}, expected {expected[worst]:.6g}")


Expected = Callable[[NumericReference, Part], dict[str, tuple[np.ndarray, float]]]


def formula_check(expected: Expected) -> Callable[[NumericReference, Part], Iterator[Check]]:
    """Return the check that a symbolic reference has the values expected, by each way of finding them."""

    def check(numeric: NumericReference, part: Part) -> Iterator[Check]:
        claimed = numeric.read(part.answer.as_matrix())
        for name, (values, allowed) in expected(numeric, part).items():
            yield agree(name, claimed, values, allowed)

    return check


def expect_by_both_routes(by_product: np.ndarray, by_difference: np.ndarray) -> dict[str, tuple[np.ndarray, float]]:
    """Return both ways of finding values, each with the error allowed."""
    return {"frames": (by_product, EXACT), "finite differences": (by_difference, DIFFERENCED)}


def expect_by_each_route(
    numeric: NumericReference, take: Callable[[np.ndarray], np.ndarray]
) -> dict[str, tuple[np.ndarray, float]]:
    """Return `take` of the 6 x n Jacobian by each route: propagation, finite differences and exponentials."""
    expected = expect_by_both_routes(take(numeric.jacobian), take(numeric.differenced_jacobian))
    return {**expected, "product of exponentials": (take(numeric.exponential_jacobian), EXACT)}


def _position(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"frames": (numeric.point[:, moving_rows(numeric.chain), None], EXACT)}


def _velocity(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    rows = moving_rows(numeric.chain)
    return expect_by_each_route(numeric, lambda jacobian: jacobian[:, rows] @ numeric.rates)


def _component(numeric: NumericReference, part: Part) -> dict[str, tuple[np.ndarray, float]]:
    row = part.about(AlongAxis).row
    return expect_by_each_route(numeric, lambda jacobian: jacobian[:, [row]] @ numeric.rates)


def _jacobian(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return expect_by_each_route(numeric, lambda jacobian: jacobian[:, numeric.task])


def _axes(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"frames": (numeric.frames[:, :-1, :3, 2].transpose(0, 2, 1), EXACT)}


def _vectors(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    first, n = convention_of(numeric.chain).frame_on_axis(1), numeric.chain.n
    origins = numeric.convention_frames[:, first : first + n, :3, 3]
    return {"frames": ((numeric.point[:, None] - origins).transpose(0, 2, 1), EXACT)}


def _geometric(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    order = [TASK_ROWS.index(row) for row in convention_of(numeric.chain).velocities]
    return expect_by_each_route(numeric, lambda jacobian: jacobian[:, order])


def _twist(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    order = [TASK_ROWS.index(row) for row in convention_of(numeric.chain).velocities]
    return expect_by_each_route(numeric, lambda jacobian: jacobian[:, order] @ numeric.rates)


def _link_velocity(numeric: NumericReference, part: Part) -> dict[str, tuple[np.ndarray, float]]:
    frame = part.about(OfFrame).frame
    carried = numeric.convention_velocities[:, :, frame].transpose(0, 2, 1)
    return {"finite differences": (carried @ numeric.rates, DIFFERENCED)}


def _own_frame(numeric: NumericReference, part: Part) -> dict[str, tuple[np.ndarray, float]]:
    frame = part.about(FromFrameToFrame).frame
    velocity = (numeric.convention_velocities[:, :, frame].transpose(0, 2, 1) @ numeric.rates)[..., 0]
    turn = numeric.convention_frames[:, frame, :3, :3].swapaxes(1, 2)
    local_velocity = np.concatenate(
        [np.einsum("kij,kj->ki", turn, half) for half in (velocity[:, :3], velocity[:, 3:])], axis=1
    )
    return {"finite differences": (local_velocity[..., None], DIFFERENCED)}


def _determinant(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"LU decomposition": (np.linalg.det(numeric.task_jacobian)[:, None, None], EXACT)}


def _check_inverse(numeric: NumericReference, part: Part) -> Iterator[Check]:
    """Multiply the Jacobian by its inverse; the result is 1."""
    yield _check_product(numeric, part, np.broadcast_to(np.eye(numeric.chain.n), numeric.task_jacobian.shape))


def _check_rate_law(numeric: NumericReference, part: Part) -> Iterator[Check]:
    """Multiply the Jacobian by the rates; the result is the velocity asked for."""
    yield _check_product(numeric, part, numeric.velocity)


def _check_product(numeric: NumericReference, part: Part, expected: np.ndarray) -> Check:
    claimed = numeric.read(part.answer.as_matrix())
    if claimed.shape != expected.shape:
        return agree("J times it", claimed, expected, EXACT)
    size = (np.abs(numeric.task_jacobian) @ np.abs(claimed)).max(axis=(1, 2), keepdims=True)
    return agree("J times it", numeric.task_jacobian @ claimed / size, expected / size, EXACT)


def _check_joint_rates(numeric: NumericReference, part: Part) -> Iterator[Check]:
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
    enough = WELL_CONDITIONED * least_conditioning(numeric.chain)
    yield Check("well conditioned", bool(sigma[-1] / sigma[0] > enough), detail)
    yield check_three_digits(part)


def check_three_digits(part: Part) -> Check:
    """Test whether numbers stay right when they are rounded to three digits."""
    answer = part.of(Number)
    exact = np.array([float(value) for value in answer.reference])
    rounded = np.array([float(f"{value:.2e}") for value in exact])
    return Check("three digits", bool(np.all(np.abs(rounded - exact) <= answer.room(None))), "rounding keeps it right")


CHECKS: dict[str, Callable[[NumericReference, Part], Iterator[Check]]] = {
    "position": formula_check(_position),
    "velocity": formula_check(_velocity),
    "velocity-component": formula_check(_component),
    "jacobian": formula_check(_jacobian),
    "joint-axes": formula_check(_axes),
    "position-vectors": formula_check(_vectors),
    "geometric-jacobian": formula_check(_geometric),
    "twist": formula_check(_twist),
    "link-velocity": formula_check(_link_velocity),
    "own-frame-velocity": formula_check(_own_frame),
    "determinant": formula_check(_determinant),
    "inverse-jacobian": _check_inverse,
    "inverse-velocity": _check_rate_law,
    "joint-rates": _check_joint_rates,
}
