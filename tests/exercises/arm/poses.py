"""Poses as 4 x 4 matrices, computed independently of qdot; angles and distances may be arrays."""

from collections.abc import Sequence

import numpy as np

Matrix = np.ndarray


def rotate_about(axis: str, angle: float | Matrix) -> Matrix:
    """Return rotations about x, y or z, (..., 4, 4)."""
    angle = np.asarray(angle, dtype=float)
    c, s, pose = np.cos(angle), np.sin(angle), np.zeros((*angle.shape, 4, 4)) + np.eye(4)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    pose[..., i, i] = pose[..., j, j] = c
    pose[..., i, j], pose[..., j, i] = -s, s
    return pose


def translate(x: float, y: float, z: float | Matrix) -> Matrix:
    """Return translations, (..., 4, 4)."""
    pose = np.zeros((*np.shape(z), 4, 4)) + np.eye(4)
    pose[..., 0, 3], pose[..., 1, 3], pose[..., 2, 3] = x, y, z
    return pose


def compute_origin_pose(xyz: Sequence[float], rpy: Sequence[float] | Matrix) -> Matrix:
    """Return the pose of an origin of a URDF."""
    turn = rotate_about("z", rpy[2]) @ rotate_about("y", rpy[1]) @ rotate_about("x", rpy[0])
    return translate(xyz[0], xyz[1], xyz[2]) @ turn


def compute_exponential(
    axis: Sequence[float] | Matrix, value: float | Matrix, is_prismatic: bool, axis_point: object = 0.0
) -> Matrix:
    """Return exp([S] value) of a joint whose axis passes through a point, by Rodrigues' formula, (..., 4, 4)."""
    u, point = np.array(axis, dtype=float) / np.linalg.norm(axis), np.zeros(3) + np.asarray(axis_point)
    value = np.asarray(value, dtype=float)[..., None, None]
    if is_prismatic:
        return np.eye(4) + value * np.pad(u[:, None], ((0, 1), (3, 0)))
    cross = np.pad([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]], (0, 1))
    turn = np.eye(4) + np.sin(value) * cross + (1 - np.cos(value)) * cross @ cross
    return translate(*point) @ turn @ translate(*-point)
