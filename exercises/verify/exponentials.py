"""The Jacobian by the product of exponentials: a fourth route, with screw axes instead of link frames.

The arm is read from its table once, at home (all joint variables zero). There, joint i has the unit screw
S_i = (v, w): w = z, v = o x z for a revolute joint (z its axis, o a point on it), (z, 0) for a prismatic one. The
pose of the body is exp(S_1 q_1) ... exp(S_n q_n) M, and column i of the spatial Jacobian is S_i transformed by the
exponentials before it. World frame; linear part first, as in (6.6).
"""

import numpy as np

from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.vectors import cross


def exponential_jacobian(arm: NumericChain, q: np.ndarray) -> np.ndarray:
    """Return the 6 x n Jacobian of the point and of the last link, shape (…, 6, n), for q of shape (…, n)."""
    home = arm.frames(np.zeros(q.shape[-1]))
    z, origins = home[:-1, :3, 2], home[:-1, :3, 3]
    revolute = np.array([kind == "R" for kind in arm.kinds])
    rotation = np.broadcast_to(np.eye(3), (*q.shape[:-1], 3, 3))
    shift = np.zeros((*q.shape[:-1], 3))
    point = arm.point_of(home)
    screws = []
    for i in range(q.shape[-1]):
        if i == arm.point_frame:
            point = _transform_point(rotation, shift, arm.point_of(home))
        spin = np.einsum("...ij,j->...i", rotation, z[i] * revolute[i])
        slide = cross(origins[i], z[i]) if revolute[i] else z[i]
        screws.append((spin, np.einsum("...ij,j->...i", rotation, slide) + cross(shift, spin)))
        turn, step = _exponential(z[i], origins[i], q[..., i], bool(revolute[i]))
        shift = _transform_point(rotation, shift, step)
        rotation = rotation @ turn
    if arm.point_frame == q.shape[-1]:
        point = _transform_point(rotation, shift, arm.point_of(home))
    columns = []
    for i, (spin, slide) in enumerate(screws):
        linear = (slide + cross(spin, point)) * (i < arm.point_frame)
        columns.append(np.concatenate([linear, spin], axis=-1))
    return np.stack(columns, axis=-1)


def _transform_point(rotation: np.ndarray, shift: np.ndarray, point: np.ndarray) -> np.ndarray:
    return np.asarray(np.einsum("...ij,...j->...i", rotation, np.broadcast_to(point, shift.shape)) + shift)


def _exponential(
    axis: np.ndarray, on_axis: np.ndarray, value: np.ndarray, revolute: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return rotation (…, 3, 3) and shift (…, 3) of one joint's motion: Rodrigues' formula about a line, or a slide."""
    if not revolute:
        return np.broadcast_to(np.eye(3), (*value.shape, 3, 3)), value[..., None] * axis
    x, y, z = axis
    hat = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    s, c = np.sin(value)[..., None, None], np.cos(value)[..., None, None]
    turn = np.eye(3) + s * hat + (1 - c) * hat @ hat
    return turn, on_axis - turn @ on_axis
