"""Test the questions of `questions.screws`: screws by frames at home, the rest by exponentials of the axes.

The screws at home are computed from 4 x 4 products of the table at zero joint variables, by z and o x z. Everything
else comes from the axes in the statement (which `certify` compares with those products, too): each joint is an axis in
the space frame at home, the arm is the product of the joints' exponentials, and no link frame is used. If link frames
give a third way, it is tested as well. Twists and adjoints have the arm's order, (omega, v) of Lynch and Park or
(v, omega) of Murray, Li and Sastry, each with its own adjoint.
"""

from collections.abc import Callable

import numpy as np

from qdot.exercises.arm.axes_to_dh import Axis
from qdot.exercises.arm.standard_table import axes_of
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.screws import DECIMALS, InNumbers
from qdot.exercises.verify.formulas import DIFFERENCED, EXACT, Expected, PartCheck, agree, formula_check
from qdot.exercises.verify.numbers import check_three_digits
from qdot.exercises.verify.numeric_reference import Check, Checks, NumericReference, at_place, exponential, hat


def _is_linear_first(numeric: NumericReference) -> bool:
    """Whether twists of an arm are (v, omega)."""
    return numeric.chain.twist_order == "v-omega"


def _twist(numeric: NumericReference, omega: np.ndarray, v: np.ndarray, axis: int = -1) -> np.ndarray:
    """Return the twist of an angular velocity and a velocity, in the order of an arm."""
    return np.concatenate([v, omega] if _is_linear_first(numeric) else [omega, v], axis=axis)


def _adjoint(numeric: NumericReference, pose: np.ndarray) -> np.ndarray:
    """Return [Ad T] of poses (…, 4, 4) for twists in the order of an arm, (…, 6, 6)."""
    turn, zero = pose[..., :3, :3], np.zeros_like(pose[..., :3, :3])
    moved = hat(pose[..., :3, 3]) @ turn
    blocks = [[turn, moved], [zero, turn]] if _is_linear_first(numeric) else [[turn, zero], [moved, turn]]
    return np.concatenate([np.concatenate(row, -1) for row in blocks], -2)


class _Axes:
    """The arm by the axes in its statement, in numbers, at the places of a reference.

    Pose (…, 4, 4), space and body Jacobian (…, 6, n).
    """

    def __init__(self, numeric: NumericReference) -> None:
        axes, point = axes_of(numeric.chain)
        self.q = np.stack([numeric.values[q.name] for q in numeric.chain.q], axis=1)
        before, carried = np.broadcast_to(np.eye(4), (len(self.q), 4, 4)), []
        for i, axis in enumerate(axes):
            omega, v = self._screw(numeric, axis)
            carried.append((_adjoint(numeric, before) @ _twist(numeric, omega, v)[..., None])[..., 0])
            before = before @ exponential(omega, v, self.q[:, i])
        self.space = np.stack(carried, axis=2)
        home = np.broadcast_to(np.eye(4), before.shape).copy()
        home[:, :3, 3] = numeric.numbers(point)
        self.pose = before @ home
        self.body = _adjoint(numeric, np.linalg.inv(self.pose)) @ self.space

    @staticmethod
    def _screw(numeric: NumericReference, axis: Axis) -> tuple[np.ndarray, np.ndarray]:
        """Return omega and v of a joint at home, (…, 3) each."""
        u, o = numeric.numbers(axis.direction), numeric.numbers(axis.point)
        return (u, np.cross(o, u)) if axis.kind == "R" else (0 * u, u)


def _home(numeric: NumericReference, _: Part) -> Expected:
    """By the frames on the links at home: z, and o x z of the origin o of a frame on the axis."""
    z, o = numeric.home[:, :-1, :3, 2], numeric.home[:, :-1, :3, 3]
    turning = np.array([joint.kind == "R" for joint in numeric.chain.joints])[:, None]
    screws = np.where(turning, _twist(numeric, z, np.cross(o, z)), _twist(numeric, 0 * z, z))
    return {"frames at home": (screws.swapaxes(1, 2), EXACT)}


def _pose(numeric: NumericReference, _: Part) -> Expected:
    """By exponentials, and from the last frame."""
    return {"product of exponentials": (_Axes(numeric).pose, EXACT), "frames": (_pose_of_last_frame(numeric), EXACT)}


def _conjugate(numeric: NumericReference, pose: np.ndarray, twists: np.ndarray) -> np.ndarray:
    """Return twists (…, 6, k) in another frame, T [V] T^-1, by 4 x 4 matrices of twists."""
    columns = []
    for k in range(twists.shape[-1]):
        upper, lower = twists[..., :3, k], twists[..., 3:, k]
        omega, v = (lower, upper) if _is_linear_first(numeric) else (upper, lower)
        matrix = np.zeros((*omega.shape[:-1], 4, 4))
        matrix[..., :3, :3], matrix[..., :3, 3] = hat(omega), v
        seen = pose @ matrix @ np.linalg.inv(pose)
        turning = np.stack([seen[..., 2, 1], seen[..., 0, 2], seen[..., 1, 0]], -1)
        columns.append(_twist(numeric, turning, seen[..., :3, 3]))
    return np.stack(columns, axis=-1)


def _body_adjoint(numeric: NumericReference, _: Part) -> Expected:
    """By the exponentials' pose, and by the matrix of each unit twist, between the poses of the last frame."""
    unit = np.broadcast_to(np.eye(6), (numeric.points, 6, 6))
    by_matrices = _conjugate(numeric, _pose_of_last_frame(numeric), unit)
    return {"product of exponentials": (_adjoint(numeric, _Axes(numeric).pose), EXACT), "frames": (by_matrices, EXACT)}


def _check_changed_twist(numeric: NumericReference, part: Part) -> Checks:
    """Transform the matrix of the twist, T [V] T^-1, by the last frame there and at home; test the given values."""
    details, chain = part.about(InNumbers), numeric.chain
    sample = at_place(numeric, details.place)
    arm, q = sample.arm, sample.q
    frames, home = arm.frames(q), arm.frames(0 * q)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = frames[-1, :3, :3] @ home[-1, :3, :3].T, arm.point_of(frames)
    omega, v = np.split(np.array(details.twist.tolist(), dtype=float), 2)
    twist = _twist(numeric, omega, v, axis=0)
    claimed = np.array(part.answer.as_matrix().tolist(), dtype=float)
    yield agree("matrix of the twist", claimed[None], _conjugate(numeric, pose, twist)[None], 1e-8)
    geometric, rates = arm.jacobian(q), np.array([float(details.rates[rate]) for rate in chain.rates])
    velocity, spin = (pose[:3, :3].T @ (half @ rates) for half in (geometric[:3], geometric[3:]))
    off = np.abs(_twist(numeric, spin, velocity) - twist[:, 0]).max()
    yield Check("the arm can", bool(off <= 0.51 * 10.0**-DECIMALS), f"its rates give the twist but for {off:.1e}")
    yield check_three_digits(part)


def _pose_of_last_frame(numeric: NumericReference) -> np.ndarray:
    """Return the pose of the body frame from the last frame, with its rotation at home removed, (…, 4, 4)."""
    pose = np.broadcast_to(np.eye(4), (numeric.points, 4, 4)).copy()
    pose[:, :3, :3] = numeric.frames[:, -1, :3, :3] @ numeric.home[:, -1, :3, :3].swapaxes(1, 2)
    pose[:, :3, 3] = numeric.point
    return pose


def _space_jacobian(numeric: NumericReference) -> Expected:
    """By exponentials, and from the velocities of the last frame by differences."""
    last = numeric.carried[:, :, numeric.chain.n]
    spin, velocity = last[..., 3:], last[..., :3]
    at_origin = velocity - np.cross(spin, numeric.frames[:, None, -1, :3, 3])
    differenced = _twist(numeric, spin, at_origin).swapaxes(1, 2)
    by_exponentials = (_Axes(numeric).space, EXACT)
    return {"product of exponentials": by_exponentials, "finite differences": (differenced, DIFFERENCED)}


def _body_jacobian(numeric: NumericReference) -> Expected:
    """By exponentials, and from the geometric Jacobian, rotated into the frame that is the world's at home."""
    axes = _Axes(numeric)
    back = axes.pose[:, :3, :3].swapaxes(1, 2)
    turned = _twist(numeric, back @ numeric.jacobian[:, 3:], back @ numeric.jacobian[:, :3], axis=1)
    return {"product of exponentials": (axes.body, EXACT), "frames": (turned, EXACT)}


def _check_twist(jacobian_by_route: Callable[[NumericReference], Expected]) -> PartCheck:
    """Return the check that multiplies the Jacobian of each route by the joint rates."""

    def twist(numeric: NumericReference, _: Part) -> Expected:
        routes = jacobian_by_route(numeric).items()
        return {name: (jacobian @ numeric.rates, allowed) for name, (jacobian, allowed) in routes}

    return formula_check(twist)


CHECKS: dict[str, PartCheck] = {
    "home-screws": formula_check(_home),
    "body-pose": formula_check(_pose),
    "body-adjoint": formula_check(_body_adjoint),
    "changed-twist": _check_changed_twist,
    "space-jacobian": formula_check(lambda numeric, _: _space_jacobian(numeric)),
    "body-jacobian": formula_check(lambda numeric, _: _body_jacobian(numeric)),
    "space-twist": _check_twist(_space_jacobian),
    "body-twist": _check_twist(_body_jacobian),
}
