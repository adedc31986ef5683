"""Compute the frames and the Jacobian of an arm, symbolically and numerically, in the chapter's notation.

Vectors are in the world frame:

- T_i is the pose of frame i, R_i its rotation, O_i its origin;
- z_{i-1} = R_{i-1} (0, 0, 1) is the axis of joint i (z_i if the arm is described by a modified table);
- p*_{i-1} is the vector from O_{i-1} to the point of interest, and p*_n the vector from O_n.

The rows of a 6 x n Jacobian are vx vy vz wx wy wz (6.6).

The symbolic Jacobian is derived by two routes. Route 1 differentiates the position (6.1-6.4), which is computed here.
Route 2, the stages of `derivation.graph`, propagates velocities (6.9-6.13). The two routes share only the DH table.
Route 1 adds the angles of successive parallel joints, so that formulas have cos(theta1 + theta2); the sum is called an
absolute angle. Route 2 multiplies rotation matrices joint by joint.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import sympy as sp

from qdot.exercises.arm.axes_to_dh import Pose
from qdot.exercises.arm.chain import Base, Chain, Joint
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.standard_dh import StandardDh
from qdot.exercises.arm.vectors import cross, rot_x, rot_z

Z = sp.Matrix([0, 0, 1])
"""The z axis of a frame, in the frame's own coordinates."""


@dataclass(frozen=True)
class _FactoredFrame:
    """A frame whose rotation is `outer` Rz(`angle`).

    While successive joints are parallel, only the absolute angle `angle` changes.
    """

    outer: sp.Matrix
    angle: sp.Expr
    origin: sp.Matrix

    def move_along_z(self, angle: sp.Expr, length: sp.Expr) -> "_FactoredFrame":
        """Return the frame after a rotation about its z axis and a shift along it."""
        return replace(self, angle=self.angle + angle, origin=self.compute_point(sp.S.Zero, sp.S.Zero, length))

    def move_along_x(self, angle: sp.Expr, length: sp.Expr) -> "_FactoredFrame":
        """Return the frame after a rotation about its x axis and a shift along it."""
        origin = self.compute_point(length, sp.S.Zero, sp.S.Zero)
        if angle == 0:
            return replace(self, origin=origin)
        if angle in (sp.pi, -sp.pi):  # Rz(phi) Rx(pi) = Rx(pi) Rz(-phi): the next axis is parallel, with opposite sense
            return _FactoredFrame(self.outer * rot_x(angle), -self.angle, origin)
        return _FactoredFrame(self.multiply_out().rotation * rot_x(angle), sp.S.Zero, origin)

    def multiply_out(self) -> Pose:
        """Return the frame with its rotation as one matrix."""
        return Pose(self.outer * rot_z(self.angle), self.origin)

    def compute_point(self, x: sp.Expr, y: sp.Expr, z: sp.Expr) -> sp.Matrix:
        """Return the position in the world (3 x 1) of a point with these coordinates in the frame."""
        c, s = sp.cos(self.angle), sp.sin(self.angle)
        return self.origin + self.outer * sp.Matrix([x * c - y * s, x * s + y * c, z])


def _walk_frames(
    base: Base, rows: Iterable[Joint], split_row: Callable[[Joint], Iterable[tuple[str, sp.Expr, sp.Expr]]]
) -> Iterator[_FactoredFrame]:
    """Yield frame 0 and the frame after each row; `split_row` yields the screw motions of a row (`Convention`)."""
    frame = _FactoredFrame(sp.eye(3), sp.S.Zero, sp.Matrix(base.position))
    frame = frame.move_along_z(base.yaw, sp.S.Zero).move_along_x(base.tilt, sp.S.Zero)
    yield frame
    for row in rows:
        for axis, angle, length in split_row(row):
            frame = frame.move_along_x(angle, length) if axis == "x" else frame.move_along_z(angle, length)
        yield frame


class FramesAndPoint(NamedTuple):
    """The standard frames 0 ... n of an arm, and the position of its point of interest (3 x 1, m)."""

    frames: tuple[Pose, ...]
    point: sp.Matrix


@lru_cache(maxsize=512)
def compute_frames_and_point(chain: Chain) -> FramesAndPoint:
    """Return the standard frames and the point of interest, with absolute angles; copy a matrix before you change it.

    The result is cached, because every derivation begins with these frames.
    """
    frames = list(_walk_frames(chain.base, chain.joints, StandardDh.split_row))
    point = frames[chain.point.frame].compute_point(*chain.point.offset)
    return FramesAndPoint(tuple(frame.multiply_out() for frame in frames), point)


@lru_cache(maxsize=512)
def compute_link_frames(chain: Chain) -> tuple[Pose, ...]:
    """Return frames 0 ... n of the arm's convention, with absolute angles."""
    convention = convention_of(chain)
    frames = _walk_frames(convention.base, convention.rows, convention.split_row)
    return tuple(frame.multiply_out() for frame in frames)


def compute_frame_after(joints: Iterable[Joint]) -> Pose:
    """Return the frame after consecutive joints of an arm, in the coordinates of the frame before these joints."""
    *_, last_frame = _walk_frames(Base(), joints, StandardDh.split_row)
    return last_frame.multiply_out()


def compute_jacobian_in_frame(chain: Chain, frame: int, reference_frame: int | None) -> sp.Matrix:
    """Return a Jacobian in the coordinates of the standard frame with the number `frame`.

    - If `reference_frame` is a number, this is the 6 x n Jacobian of the last link about the origin of that frame.
    - If `reference_frame` is None, this is the 3 x n Jacobian of P. Then P must not be fixed in a frame before `frame`.
    """
    end_frame = chain.point.frame if reference_frame is None else reference_frame
    pose = compute_frame_after(chain.joints[min(frame, end_frame) : max(frame, end_frame)])
    point = pose.origin if end_frame >= frame else -(pose.rotation.T * pose.origin)
    if reference_frame is None:
        point += pose.rotation * sp.Matrix(chain.point.offset)
    columns = []
    for i, joint in enumerate(chain.joints):
        if reference_frame is None and i >= end_frame:
            columns.append(sp.zeros(3, 1))
            continue
        pose = compute_frame_after(chain.joints[min(i, frame) : max(i, frame)])
        if i < frame:
            z, origin = pose.rotation.T * Z, -(pose.rotation.T * pose.origin)
        else:
            z, origin = pose.rotation * Z, pose.origin
        linear_part, angular_part = (z.cross(point - origin), z) if joint.is_revolute else (z, sp.zeros(3, 1))
        columns.append(linear_part if reference_frame is None else linear_part.col_join(angular_part))
    return sp.Matrix.hstack(*columns)


_to_float = lru_cache(maxsize=4096)(float)
"""Converts a number of the table to a float; cached, because an arm uses the same number dozens of times."""


class NumericChain:
    """An arm in floating-point numbers; frames are computed by products of 4 x 4 matrices.

    `values` maps the name of each symbolic length or angle to its value. A configuration is an array of n joint values;
    methods take many configurations at once, an array of shape (…, n).

    - `kinds`, `is_revolute`, `joint_offsets`: the kind of each joint, whether it is revolute, and its joint offset.
    - `fixed_entries`, `a`: the entry d or theta of each joint that is constant, and a of each joint.
    - `point_frame`, `point_offset`: the frame in which P is fixed, and the homogeneous coordinates of P in it (4).
    - `base`: the pose of frame 0 in the world (4 x 4).
    """

    def __init__(self, chain: Chain, values: Mapping[str, float]) -> None:
        def to_float(expression: sp.Expr) -> float:
            if expression.is_Symbol:
                return float(values[expression.name])
            if not expression.free_symbols:
                return _to_float(expression)
            floats = {symbol: sp.Float(values[symbol.name]) for symbol in expression.free_symbols}
            return float(expression.xreplace(floats))

        self.kinds = tuple(joint.kind for joint in chain.joints)
        self.is_revolute = np.array([joint.is_revolute for joint in chain.joints])
        self.joint_offsets = np.array([to_float(value) for value in chain.offsets])
        constants = [[*map(to_float, (joint.fixed_entry, joint.a, joint.alpha))] for joint in chain.joints]
        self.fixed_entries, self.a, alpha = np.array(constants).T
        self._cos_sin_alpha = np.array([np.cos(alpha), np.sin(alpha)])
        self.point_frame = chain.point.frame
        self.point_offset = np.array([*map(to_float, chain.point.offset), 1.0])
        zero, tilt = np.zeros(()), np.array(to_float(chain.base.tilt))
        self.base = _compute_row_poses(
            np.array(to_float(chain.base.yaw)), zero, zero, np.array([np.cos(tilt), np.sin(tilt)])
        )
        self.base[:3, 3] = [to_float(value) for value in chain.base.position]

    @staticmethod
    def stack(arms: Sequence["NumericChain"]) -> "NumericChain":
        """Return k arms with the same structure as one object, for m configurations of each arm, (k, m, n)."""
        first_arm = arms[0]
        combined_arm = copy(first_arm)
        if all(arm is first_arm for arm in arms):
            return combined_arm
        for name in ("joint_offsets", "fixed_entries", "a", "point_offset", "base"):
            setattr(combined_arm, name, np.stack([getattr(arm, name) for arm in arms])[:, None])
        combined_arm._cos_sin_alpha = np.stack([arm._cos_sin_alpha for arm in arms], axis=1)[:, :, None]
        return combined_arm

    def with_point(self, frame: int) -> "NumericChain":
        """Return the same arm with the origin of the frame with this number as its point of interest."""
        changed_arm = copy(self)
        changed_arm.point_frame, changed_arm.point_offset = frame, np.array([0.0, 0.0, 0.0, 1.0])
        return changed_arm

    def keep_first_joints(self, joint_count: int, point_offset: tuple[float, float, float]) -> "NumericChain":
        """Return the arm of the first `joint_count` joints, with the point at `point_offset` in its last frame."""
        shortened_arm = copy(self)
        for name in ("kinds", "is_revolute", "joint_offsets", "fixed_entries", "a"):
            setattr(shortened_arm, name, getattr(self, name)[:joint_count])
        shortened_arm._cos_sin_alpha = self._cos_sin_alpha[:, :joint_count]
        shortened_arm.point_frame, shortened_arm.point_offset = joint_count, np.array([*point_offset, 1.0])
        return shortened_arm

    def compute_frames(self, q: np.ndarray) -> np.ndarray:
        """Return the poses of frames 0 ... n, shape (…, n + 1, 4, 4), at joint values q of shape (…, n)."""
        q = np.asarray(q, dtype=float)
        poses = np.empty((*q.shape[:-1], q.shape[-1] + 1, 4, 4))
        poses[..., 0, :, :] = self.base
        steps = _compute_row_poses(*self._compute_theta_and_d(q), self.a, self._cos_sin_alpha)
        for i in range(q.shape[-1]):
            np.matmul(poses[..., i, :, :], steps[..., i, :, :], out=poses[..., i + 1, :, :])
        return poses

    def _compute_theta_and_d(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return theta and d of every row of the table, shape (…, n); constant entries may have shape (n)."""
        variable_entries = q + self.joint_offsets
        if self.is_revolute.all():
            return variable_entries, self.fixed_entries
        theta = np.where(self.is_revolute, variable_entries, self.fixed_entries)
        return theta, np.where(self.is_revolute, self.fixed_entries, variable_entries)

    def compute_point(self, q: np.ndarray) -> np.ndarray:
        """Return the point of interest, shape (…, 3), at joint values q."""
        return self.compute_point_of(self.compute_frames(q))

    def compute_point_of(self, frames: np.ndarray) -> np.ndarray:
        """Return the point of interest, shape (…, 3), given the poses of the standard frames."""
        if self.point_offset.ndim > 1:  # `stack` combined several arms
            return np.asarray((frames[..., self.point_frame, :, :] @ self.point_offset[..., None])[..., :3, 0])
        return np.asarray((frames[..., self.point_frame, :, :] @ self.point_offset)[..., :3])

    def compute_jacobian(self, q: np.ndarray) -> np.ndarray:
        """Return the 6 x n Jacobian, shape (…, 6, n), at joint values q."""
        return self.compute_jacobian_of(self.compute_frames(q))

    def compute_jacobian_of(self, frames: np.ndarray) -> np.ndarray:
        """Return the 6 x n Jacobian, shape (…, 6, n), given the poses of the standard frames."""
        z, origins = frames[..., :-1, :3, 2], frames[..., :-1, :3, 3]
        rows = np.empty((*z.shape[:-1], 6))
        rows[..., :3], rows[..., 3:] = cross(z, self.compute_point_of(frames)[..., None, :] - origins), z
        for prismatic_joint in np.flatnonzero(~self.is_revolute).tolist():
            rows[..., prismatic_joint, :3] = z[..., prismatic_joint, :]
            rows[..., prismatic_joint, 3:] *= 0.0
        rows[..., self.point_frame :, :3] *= 0.0  # joints after the point's frame do not move the point
        return rows.swapaxes(-1, -2)


def _compute_row_poses(theta: np.ndarray, d: np.ndarray, a: np.ndarray, cos_sin_alpha: np.ndarray) -> np.ndarray:
    """Return the pose Rz(theta) Tz(d) Tx(a) Rx(alpha) for each theta, (…, 4, 4)."""
    (ct, st), (ca, sa) = (np.cos(theta), np.sin(theta)), cos_sin_alpha
    pose = np.zeros((*theta.shape, 4, 4))
    pose[..., 0, 0], pose[..., 0, 1], pose[..., 0, 2], pose[..., 0, 3] = ct, -st * ca, st * sa, a * ct
    pose[..., 1, 0], pose[..., 1, 1], pose[..., 1, 2], pose[..., 1, 3] = st, ct * ca, -ct * sa, a * st
    pose[..., 2, 1], pose[..., 2, 2], pose[..., 2, 3], pose[..., 3, 3] = sa, ca, d, 1.0
    return pose
