"""Compute the velocity kinematics of a chain by two independent routes, in the chapter's notation.

All vectors are in the world frame:

- T_i is the pose of frame i, R_i its rotation, O_i its origin;
- z_{i-1} = R_{i-1} (0, 0, 1) is the axis of joint i (z_i if the arm is described by a modified table);
- p*_{i-1} is the vector from O_{i-1} to the point of interest, and p*_n the vector from O_n.

The rows of a 6 x n Jacobian are vx vy vz wx wy wz (6.6).

Route 1 differentiates the position (6.1-6.4). Route 2, the stages of `derivation_graph`, propagates velocities
(6.9-6.13). They share only the DH table: route 1 uses absolute angles in runs of parallel joints, and route 2
multiplies rotation matrices joint by joint.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import TASK_ROWS, Base, Chain, Joint
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.standard_dh import StandardDh
from qdot.exercises.arm.vectors import cross, rot_x, rot_z

Z = sp.Matrix([0, 0, 1])


@dataclass(frozen=True)
class Frame:
    """A link frame: rotation R (3 x 3) and origin (3 x 1), in the world frame."""

    rotation: sp.Matrix
    origin: sp.Matrix


class _ParallelRun:
    """The rotation of a frame as `outer` Rz(`angle`); in a run of parallel joints, only the absolute angle changes."""

    def __init__(self, outer: sp.Matrix, angle: sp.Expr) -> None:
        self.outer, self.angle = outer, angle

    def rotate_z(self, angle: sp.Expr) -> None:
        self.angle = self.angle + angle

    def rotate_x(self, alpha: sp.Expr) -> None:
        if alpha == 0:
            return
        if alpha in (sp.pi, -sp.pi):  # Rz(phi) Rx(pi) = Rx(pi) Rz(-phi): still parallel, opposite sense
            self.outer, self.angle = self.outer * rot_x(alpha), -self.angle
        else:
            self.outer, self.angle = self.rotation() * rot_x(alpha), sp.S.Zero

    def rotation(self) -> sp.Matrix:
        return self.outer * rot_z(self.angle)

    def frame(self, origin: sp.Matrix) -> Frame:
        return Frame(self.rotation(), origin)

    def vector(self, x: sp.Expr, y: sp.Expr, z: sp.Expr) -> sp.Matrix:
        c, s = sp.cos(self.angle), sp.sin(self.angle)
        return self.outer * sp.Matrix([x * c - y * s, x * s + y * c, z])


def _walk_frames(
    base: Base, rows: Iterable[Joint], steps: Callable[[Joint], Iterable[tuple[str, sp.Expr, sp.Expr]]]
) -> Iterator[tuple[_ParallelRun, sp.Matrix]]:
    """Yield the run and the origin of every frame, starting with the base.

    All frames share one run object, which changes after it has been yielded.
    """
    run = _ParallelRun(sp.eye(3), sp.S.Zero)
    run.rotate_z(base.yaw)
    run.rotate_x(base.tilt)
    origin = sp.Matrix(base.position)
    yield run, origin
    for row in rows:
        for axis, angle, length in steps(row):
            if axis == "x":
                origin = origin + run.vector(length, sp.S.Zero, sp.S.Zero)
                run.rotate_x(angle)
            else:
                run.rotate_z(angle)
                origin = origin + run.vector(sp.S.Zero, sp.S.Zero, length)
        yield run, origin


@lru_cache(maxsize=512)
def frames_and_point(chain: Chain) -> tuple[tuple[Frame, ...], sp.Matrix]:
    """Return frames 0 ... n and the position of the point of interest (3 x 1, m), by runs of parallel joints.

    Angles are absolute, as in cos(theta1 + theta2), so that nothing needs to be simplified. The result is cached,
    because every derivation begins here; copy a matrix before you change it.
    """
    frames, point = [], sp.zeros(3, 1)
    for index, (run, origin) in enumerate(_walk_frames(chain.base, chain.joints, StandardDh.row_steps)):
        if index == chain.point.frame:
            point = origin + run.vector(*chain.point.offset)
        frames.append(run.frame(origin))
    return tuple(frames), point


@lru_cache(maxsize=512)
def link_frames(chain: Chain) -> tuple[Frame, ...]:
    """Return frames 0 ... n of the arm's convention, by runs of parallel joints."""
    convention = convention_of(chain)
    walk = _walk_frames(convention.base, convention.rows, convention.row_steps)
    return tuple(run.frame(origin) for run, origin in walk)


def frame_after(joints: Iterable[Joint]) -> Frame:
    """Return the frame after consecutive joints of a chain, in the coordinates of the frame before them."""
    *_, (run, origin) = _walk_frames(Base(), joints, StandardDh.row_steps)
    return run.frame(origin)


def jacobian_seen_from(chain: Chain, frame: int, about: int | None) -> sp.Matrix:
    """Return the 6 x n Jacobian of the last link in the coordinates of a frame, about the origin of frame `about`.

    If `about` is None, return the 3 x n Jacobian of P, which must not be fixed in a frame before this one.
    """
    end_frame = chain.point.frame if about is None else about
    between = frame_after(chain.joints[min(frame, end_frame) : max(frame, end_frame)])
    point = between.origin if end_frame >= frame else -(between.rotation.T * between.origin)
    if about is None:
        point += between.rotation * sp.Matrix(chain.point.offset)
    columns = []
    for i, joint in enumerate(chain.joints):
        if about is None and i >= end_frame:
            columns.append(sp.zeros(3, 1))
            continue
        relative = frame_after(chain.joints[min(i, frame) : max(i, frame)])
        if i < frame:
            z, origin = relative.rotation.T * Z, -(relative.rotation.T * relative.origin)
        else:
            z, origin = relative.rotation * Z, relative.origin
        linear, angular = (z.cross(point - origin), z) if joint.kind == "R" else (z, sp.zeros(3, 1))
        columns.append(linear if about is None else linear.col_join(angular))
    return sp.Matrix.hstack(*columns)


def task_matrix(geometric: sp.Matrix, task: tuple[str, ...]) -> sp.Matrix:
    """Return the rows of a 6 x n Jacobian that belong to the task."""
    return geometric.extract([TASK_ROWS.index(row) for row in task], list(range(geometric.cols)))


@lru_cache(maxsize=4096)
def _float_value(expression: sp.Expr) -> float:
    """Return a number of the table as a float; it is cached, because an arm uses it dozens of times."""
    return float(expression)


class NumericChain:
    """The numeric arm: a third, purely numerical evaluation of the DH table by products of 4 x 4 matrices.

    `values` has a value for each symbolic parameter. A configuration is an array of n joint values; most methods take
    many of them at once (… x n).
    """

    def __init__(self, chain: Chain, values: Mapping[str, float]) -> None:
        def number(expression: sp.Expr) -> float:
            if expression.is_Symbol:
                return float(values[expression.name])
            if not expression.free_symbols:
                return _float_value(expression)
            floats = {symbol: sp.Float(values[symbol.name]) for symbol in expression.free_symbols}
            return float(expression.xreplace(floats))

        self.kinds = tuple(joint.kind for joint in chain.joints)
        self.offsets = [number(value) for value in chain.offsets]
        self.fixed = [(number(j.d if j.kind == "R" else j.theta), number(j.a), number(j.alpha)) for j in chain.joints]
        self._revolute = np.array([kind == "R" for kind in self.kinds])
        self._offsets = np.array(self.offsets)
        self._prismatic_joints = [i for i, kind in enumerate(self.kinds) if kind == "P"]
        self._fixed_entries, self._a, alpha = np.array(self.fixed).T
        self._twist = np.cos(alpha), np.sin(alpha)
        self._convention = convention_of(chain)
        self._base_position = np.array([number(value) for value in self._convention.base.position])
        self.point_frame = chain.point.frame
        self.offset = np.array([*map(number, chain.point.offset), 1.0])
        zero, tilt = np.zeros(()), np.array(number(chain.base.tilt))
        self.base = _pose(np.array(number(chain.base.yaw)), zero, zero, (np.cos(tilt), np.sin(tilt)))
        self.base[:3, 3] = [number(value) for value in chain.base.position]

    @staticmethod
    def stack(arms: Sequence["NumericChain"]) -> "NumericChain":
        """Return k arms of the same structure as one object, whose configurations are k x m x n: m for each arm."""
        first = arms[0]
        combined = copy(first)
        if all(arm is first for arm in arms):
            return combined
        for name in ("_offsets", "_fixed_entries", "_a", "offset"):
            setattr(combined, name, np.stack([getattr(arm, name) for arm in arms])[:, None])
        cosines, sines = (np.stack([arm._twist[k] for arm in arms])[:, None] for k in (0, 1))
        combined._twist = cosines, sines
        combined.base = np.stack([arm.base for arm in arms])[:, None]
        return combined

    def with_point(self, frame: int) -> "NumericChain":
        """Return the same arm with the origin of another frame as its point of interest."""
        changed = copy(self)
        changed.point_frame, changed.offset = frame, np.array([0.0, 0.0, 0.0, 1.0])
        return changed

    def first_joints(self, count: int, offset: tuple[float, float, float]) -> "NumericChain":
        """Return the arm of the first joints only, with a point of interest fixed in their last frame."""
        shortened = copy(self)
        for name in ("kinds", "offsets", "fixed", "_revolute", "_offsets", "_fixed_entries", "_a"):
            setattr(shortened, name, getattr(self, name)[:count])
        shortened._prismatic_joints = [i for i in self._prismatic_joints if i < count]
        shortened._twist = self._twist[0][:count], self._twist[1][:count]
        shortened.point_frame, shortened.offset = count, np.array([*offset, 1.0])
        return shortened

    def frames(self, q: np.ndarray) -> np.ndarray:
        """Return the poses of frames 0 ... n, shape (…, n + 1, 4, 4), at joint values q of shape (…, n)."""
        q = np.asarray(q, dtype=float)
        poses = np.empty((*q.shape[:-1], q.shape[-1] + 1, 4, 4))
        poses[..., 0, :, :] = self.base
        steps = _pose(*self._entries(q), self._a, self._twist)
        for i in range(q.shape[-1]):
            np.matmul(poses[..., i, :, :], steps[..., i, :, :], out=poses[..., i + 1, :, :])
        return poses

    def convention_frames(self, frames: np.ndarray) -> np.ndarray:
        """Return the frames of the arm's convention, for frames as returned by `frames`."""
        corners = frames[..., 1:, :3, 3] - self._a[:, None] * frames[..., 1:, :3, 0]
        return self._convention.numeric_frames(frames, corners, self._base_position)

    def _entries(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return theta and d of every row of the table, shape (…, n), or (n) if they are constant."""
        moving_values = q + self._offsets
        if not self._prismatic_joints:
            return moving_values, self._fixed_entries
        pairs = (moving_values, self._fixed_entries), (self._fixed_entries, moving_values)
        theta, d = (np.where(self._revolute, *pair) for pair in pairs)
        return theta, d

    def point(self, q: np.ndarray) -> np.ndarray:
        """Return the point of interest, shape (…, 3)."""
        return self.point_of(self.frames(q))

    def point_of(self, frames: np.ndarray) -> np.ndarray:
        """Return the point of interest for frames as returned by `frames`."""
        if self.offset.ndim > 1:  # several arms
            return np.asarray((frames[..., self.point_frame, :, :] @ self.offset[..., None])[..., :3, 0])
        return np.asarray((frames[..., self.point_frame, :, :] @ self.offset)[..., :3])

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Return the 6 x n Jacobian, shape (…, 6, n)."""
        return self.jacobian_of(self.frames(q))

    def jacobian_of(self, frames: np.ndarray) -> np.ndarray:
        """Return the 6 x n Jacobian for frames as returned by `frames`."""
        z, origins = frames[..., :-1, :3, 2], frames[..., :-1, :3, 3]
        rows = np.empty((*z.shape[:-1], 6))
        rows[..., :3], rows[..., 3:] = cross(z, self.point_of(frames)[..., None, :] - origins), z
        for prismatic in self._prismatic_joints:
            rows[..., prismatic, :3] = z[..., prismatic, :]
            rows[..., prismatic, 3:] *= 0.0
        rows[..., self.point_frame :, :3] *= 0.0  # joints that do not carry the point
        return rows.swapaxes(-1, -2)


def _pose(theta: np.ndarray, d: np.ndarray, a: np.ndarray, twist: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Return Rz(theta) Tz(d) Tx(a) Rx(alpha) as 4 x 4 matrices, one for each theta; `twist`: cos and sin of alpha."""
    (ct, st), (ca, sa) = (np.cos(theta), np.sin(theta)), twist
    pose = np.zeros((*theta.shape, 4, 4))
    pose[..., 0, 0], pose[..., 0, 1], pose[..., 0, 2], pose[..., 0, 3] = ct, -st * ca, st * sa, a * ct
    pose[..., 1, 0], pose[..., 1, 1], pose[..., 1, 2], pose[..., 1, 3] = st, ct * ca, -ct * sa, a * st
    pose[..., 2, 1], pose[..., 2, 2], pose[..., 2, 3], pose[..., 3, 3] = sa, ca, d, 1.0
    return pose
