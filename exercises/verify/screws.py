"""Check the questions on screws, twists and the space and body Jacobians (`questions.screws`).

The screws at home are checked with the link frames at zero joint variables: the axis z, and o x z for the frame's
origin o. All other answers are checked with the product of exponentials of the axes in the problem statement, which
uses no link frame. If there is a second method with link frames, the answers are checked with both. `certify`
separately compares the axes with the link frames.

Twists and adjoints have the order that the arm sets: (omega, v) as in Lynch and Park, or (v, omega) as in Murray, Li
and Sastry. Each order has its own adjoint.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from qdot.exercises.arm.standard_table import compute_home_geometry
from qdot.exercises.problem.problem import Part
from qdot.exercises.verify.formulas import (
    DIFFERENCE_TOLERANCE,
    EXACT_TOLERANCE,
    ExpectedValues,
    PartCheck,
    make_formula_check,
)
from qdot.exercises.verify.numeric_model import NumericModel, compute_screw_exponential, make_skew_matrix


def _is_linear_first(model: NumericModel) -> bool:
    """Return whether the arm's twists have the order (v, omega)."""
    return model.chain.twist_order == "v-omega"


def _stack_twist(model: NumericModel, omega: np.ndarray, v: np.ndarray, axis: int = -1) -> np.ndarray:
    """Return the twist of an angular and a linear velocity, in the arm's order."""
    return np.concatenate([v, omega] if _is_linear_first(model) else [omega, v], axis=axis)


def _make_adjoint(model: NumericModel, pose: np.ndarray) -> np.ndarray:
    """Return [Ad T] of poses (…, 4, 4) for twists in the arm's order, (…, 6, 6)."""
    rotation, zero = pose[..., :3, :3], np.zeros_like(pose[..., :3, :3])
    cross_rotation = make_skew_matrix(pose[..., :3, 3]) @ rotation
    upper_right, lower_left = (cross_rotation, zero) if _is_linear_first(model) else (zero, cross_rotation)
    blocks = [[rotation, upper_right], [lower_left, rotation]]
    return np.concatenate([np.concatenate(row, -1) for row in blocks], -2)


class _BodyKinematics(NamedTuple):
    """The pose of the body frame, (…, 4, 4), and the space Jacobian, (…, 6, n)."""

    pose: np.ndarray
    space_jacobian: np.ndarray


def _compute_body_kinematics(model: NumericModel) -> _BodyKinematics:
    """Return the kinematics by exponentials of the screws of the axes in the problem statement."""
    axes, point = compute_home_geometry(model.chain)
    motion, columns = np.broadcast_to(np.eye(4), (model.sample_count, 4, 4)), []
    for i, axis in enumerate(axes):
        u, o = model.evaluate_constants(axis.direction), model.evaluate_constants(axis.point)
        omega, v = (u, np.cross(o, u)) if axis.is_revolute else (0 * u, u)
        columns.append((_make_adjoint(model, motion) @ _stack_twist(model, omega, v)[..., None])[..., 0])
        motion = motion @ compute_screw_exponential(omega, v, model.configurations[:, i])
    home = np.broadcast_to(np.eye(4), motion.shape).copy()
    home[:, :3, 3] = model.evaluate_constants(point)
    return _BodyKinematics(motion @ home, np.stack(columns, axis=2))


def _compute_home_screws(model: NumericModel, _: Part) -> ExpectedValues:
    """Return the screws at home, from the link frames: z, and o x z for the origin o of a frame on the axis."""
    z, o = model.home_frames[:, :-1, :3, 2], model.home_frames[:, :-1, :3, 3]
    is_revolute = np.array([joint.is_revolute for joint in model.chain.joints])[:, None]
    screws = np.where(is_revolute, _stack_twist(model, z, np.cross(o, z)), _stack_twist(model, 0 * z, z))
    return {"frames at home": (screws.swapaxes(1, 2), EXACT_TOLERANCE)}


def _compute_body_pose(model: NumericModel, _: Part) -> ExpectedValues:
    """Return the pose of the body frame, computed from exponentials and from the last frame."""
    return {
        "product of exponentials": (_compute_body_kinematics(model).pose, EXACT_TOLERANCE),
        "frames": (_compute_frame_pose(model), EXACT_TOLERANCE),
    }


def _transform_twists(model: NumericModel, pose: np.ndarray, twists: np.ndarray) -> np.ndarray:
    """Transform twists (…, 6, k) to another frame by their 4 x 4 matrices: T [V] T^-1."""
    columns = []
    for k in range(twists.shape[-1]):
        first_half, second_half = twists[..., :3, k], twists[..., 3:, k]
        omega, v = (second_half, first_half) if _is_linear_first(model) else (first_half, second_half)
        matrix = np.zeros((*omega.shape[:-1], 4, 4))
        matrix[..., :3, :3], matrix[..., :3, 3] = make_skew_matrix(omega), v
        new_matrix = pose @ matrix @ np.linalg.inv(pose)
        angular = np.stack([new_matrix[..., 2, 1], new_matrix[..., 0, 2], new_matrix[..., 1, 0]], -1)
        columns.append(_stack_twist(model, angular, new_matrix[..., :3, 3]))
    return np.stack(columns, axis=-1)


def _compute_body_adjoint(model: NumericModel, _: Part) -> ExpectedValues:
    """Return the adjoint of the body pose, from exponentials, and from the matrices T [V] T^-1 of unit twists V."""
    unit_twists = np.broadcast_to(np.eye(6), (model.sample_count, 6, 6))
    transformed_twists = _transform_twists(model, _compute_frame_pose(model), unit_twists)
    return {
        "product of exponentials": (_make_adjoint(model, _compute_body_kinematics(model).pose), EXACT_TOLERANCE),
        "frames": (transformed_twists, EXACT_TOLERANCE),
    }


def _compute_frame_pose(model: NumericModel) -> np.ndarray:
    """Return the pose of the body frame from the last frame: the frame's rotation since home, and P, (…, 4, 4)."""
    pose = np.broadcast_to(np.eye(4), (model.sample_count, 4, 4)).copy()
    pose[:, :3, :3] = model.frames[:, -1, :3, :3] @ model.home_frames[:, -1, :3, :3].swapaxes(1, 2)
    pose[:, :3, 3] = model.point
    return pose


def _compute_space_jacobian(model: NumericModel) -> ExpectedValues:
    """Return the space Jacobian, computed from exponentials, and from finite differences of the last frame."""
    frame_velocities = model.frame_velocities[:, :, model.chain.n]
    angular, velocity = frame_velocities[..., 3:], frame_velocities[..., :3]
    velocity_at_origin = velocity - np.cross(angular, model.frames[:, None, -1, :3, 3])
    jacobian = _stack_twist(model, angular, velocity_at_origin).swapaxes(1, 2)
    return {
        "product of exponentials": (_compute_body_kinematics(model).space_jacobian, EXACT_TOLERANCE),
        "finite differences": (jacobian, DIFFERENCE_TOLERANCE),
    }


def _compute_body_jacobian(model: NumericModel) -> ExpectedValues:
    """Return the body Jacobian, computed from exponentials, and from the geometric Jacobian in the body frame."""
    pose, space_jacobian = _compute_body_kinematics(model)
    rotation = pose[:, :3, :3].swapaxes(1, 2)
    jacobian = _stack_twist(model, rotation @ model.jacobian[:, 3:], rotation @ model.jacobian[:, :3], axis=1)
    return {
        "product of exponentials": (_make_adjoint(model, np.linalg.inv(pose)) @ space_jacobian, EXACT_TOLERANCE),
        "frames": (jacobian, EXACT_TOLERANCE),
    }


def _make_twist_check(compute_jacobians: Callable[[NumericModel], ExpectedValues]) -> PartCheck:
    """Return a function that checks a twist: the Jacobian that each method computes, times the joint rates."""
    return make_formula_check(
        lambda model, _: {
            name: (jacobian @ model.rates, tolerance)
            for name, (jacobian, tolerance) in compute_jacobians(model).items()
        }
    )


CHECKS: dict[str, PartCheck] = {
    "home-screws": make_formula_check(_compute_home_screws),
    "body-pose": make_formula_check(_compute_body_pose),
    "body-adjoint": make_formula_check(_compute_body_adjoint),
    "space-jacobian": make_formula_check(lambda model, _: _compute_space_jacobian(model)),
    "body-jacobian": make_formula_check(lambda model, _: _compute_body_jacobian(model)),
    "space-twist": _make_twist_check(_compute_space_jacobian),
    "body-twist": _make_twist_check(_compute_body_jacobian),
}
