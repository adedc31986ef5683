"""Poses as 4 x 4 matrices, multiplied out without anything of qdot; angles and ways may be arrays of values."""

from collections.abc import Sequence

import numpy as np

Matrix = np.ndarray


def about(axis: str, angle: float | Matrix) -> Matrix:
    """Return rotations about x, y or z, (..., 4, 4)."""
    angle = np.asarray(angle, dtype=float)
    c, s, made = np.cos(angle), np.sin(angle), np.zeros((*angle.shape, 4, 4)) + np.eye(4)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    made[..., i, i] = made[..., j, j] = c
    made[..., i, j], made[..., j, i] = -s, s
    return made


def shift(x: float, y: float, z: float | Matrix) -> Matrix:
    """Return translations, (..., 4, 4)."""
    made = np.zeros((*np.shape(z), 4, 4)) + np.eye(4)
    made[..., 0, 3], made[..., 1, 3], made[..., 2, 3] = x, y, z
    return made


def placed(xyz: Sequence[float], rpy: Sequence[float] | Matrix) -> Matrix:
    """Return the pose of an origin of a URDF."""
    return shift(xyz[0], xyz[1], xyz[2]) @ about("z", rpy[2]) @ about("y", rpy[1]) @ about("x", rpy[0])


def exponential(axis: Sequence[float] | Matrix, value: float | Matrix, slides: bool, through: object = 0.0) -> Matrix:
    """Return exp([S] value) of a joint whose axis leads through a point, by Rodrigues' formula, (..., 4, 4)."""
    u, point = np.array(axis, dtype=float) / np.linalg.norm(axis), np.zeros(3) + np.asarray(through)
    value = np.asarray(value, dtype=float)[..., None, None]
    if slides:
        return np.eye(4) + value * np.pad(u[:, None], ((0, 1), (3, 0)))
    cross = np.pad([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]], (0, 1))
    return shift(*point) @ (np.eye(4) + np.sin(value) * cross + (1 - np.cos(value)) * cross @ cross) @ shift(*-point)
