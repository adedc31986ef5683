"""Measure how joint axes and the point of interest are arranged at a configuration: distances, angles, lines, planes.

Each measure is zero if a relation holds exactly, such as a point on an axis or two collinear axes. It takes one
configuration (n) or many (k x n). A measure that is zero everywhere is no evidence about a singular configuration, so
it is also evaluated at a `nearby_configuration`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.vectors import cross, norms

Measure = Callable[["NumericChain", np.ndarray], np.ndarray]
"""A measure of an arm at many configurations (… x n): how far each is from satisfying a relation, zero or more (…).

For several arms at once (`NumericChain.stack`), the configurations are k x m x n.
"""


@dataclass(frozen=True)
class Sample:
    """One numeric arm at one configuration q (n)."""

    arm: NumericChain
    q: np.ndarray

    @cached_property
    def frames(self) -> np.ndarray:
        """The poses of frames 0 ... n (n+1 x 4 x 4)."""
        return self.arm.frames(self.q)

    @cached_property
    def axes(self) -> np.ndarray:
        """The directions z of the joint axes (n x 3) in the world frame."""
        return np.asarray(self.frames[: len(self.q), :3, 2])

    def evaluate(self, measure: Measure) -> float:
        """Return the value of a measure at this configuration."""
        return float(measure(self.arm, self.q[None])[0])


def measure_samples(samples: Sequence[Sample], measure: Measure) -> np.ndarray:
    """Return the values of a measure (k) at k samples, whose arms have the same structure."""
    arms = NumericChain.stack([sample.arm for sample in samples])
    return np.asarray(measure(arms, np.stack([sample.q for sample in samples])[:, None])[:, 0])


def jacobians_of(samples: Sequence[Sample]) -> np.ndarray:
    """Return the Jacobian of each sample (k x 6 x n); the arms have the same structure."""
    arms = NumericChain.stack([sample.arm for sample in samples])
    return arms.jacobian(np.stack([sample.q for sample in samples])[:, None])[:, 0]


def nearby_configuration(sample: Sample, extra_joint: int | None = None) -> np.ndarray:
    """Return a configuration (n) near a sample, at which nothing is aligned by chance.

    If `extra_joint` is given, that joint is moved further.
    """
    q = sample.q + 0.3 * np.arange(1, len(sample.q) + 1)
    if extra_joint is not None:
        q[extra_joint] += 0.2
    return np.asarray(q)


def nearby_samples(samples: Sequence[Sample]) -> list[Sample]:
    """Return a sample near each of the samples, at which special relations no longer hold."""
    return [Sample(sample.arm, nearby_configuration(sample)) for sample in samples]


def axis_distance(arm: NumericChain, q: np.ndarray, joint: int) -> np.ndarray:
    """Return the distance of the point from a joint's axis, in metres."""
    frames = arm.frames(q)
    to_point = arm.point_of(frames) - frames[..., joint, :3, 3]
    return norms(cross(frames[..., joint, :3, 2], to_point))


def axis_distance_derivative(arm: NumericChain, q: np.ndarray, joint: int, movers: Sequence[int]) -> np.ndarray:
    """Return how fast later joints change the squared distance of the point from an axis; zero at an extreme."""
    frames = arm.frames(q)
    axis = frames[..., joint, :3, 2]
    to_point = arm.point_of(frames) - frames[..., joint, :3, 3]
    to_point = to_point - np.sum(to_point * axis, axis=-1)[..., None] * axis
    columns = arm.jacobian_of(frames)[..., :3, list(movers)]
    return norms(np.einsum("...j,...jm->...m", to_point, columns))


def axis_spread(arm: NumericChain, q: np.ndarray, joints: Sequence[int]) -> np.ndarray:
    """Return the area or volume spanned by the directions of two or three axes: 0 to 1."""
    frames = arm.frames(q)
    first, second, *third = (frames[..., joint, :3, 2] for joint in joints)
    normal = cross(first, second)
    return np.asarray(np.abs(np.sum(normal * third[0], axis=-1))) if third else norms(normal)


def collinearity_error(arm: NumericChain, q: np.ndarray, joints: tuple[int, int]) -> np.ndarray:
    """Return how far two axes are from collinear: the sine of their angle plus the distance of O_j from axis i."""
    frames, (i, j) = arm.frames(q), joints
    axis, between = frames[..., i, :3, 2], frames[..., j, :3, 3] - frames[..., i, :3, 3]
    return norms(cross(axis, frames[..., j, :3, 2])) + norms(cross(axis, between))


def coplanarity_error(arm: NumericChain, q: np.ndarray, row: Sequence[int]) -> np.ndarray:
    """Return how far three or more parallel axes are from coplanar: the areas between their origins."""
    frames = arm.frames(q)
    axis, first_origin = frames[..., row[0], :3, 2], frames[..., row[0], :3, 3]
    return _spanned_area(axis, [frames[..., i, :3, 3] - first_origin for i in row[1:]])


def arm_coplanarity_error(arm: NumericChain, q: np.ndarray) -> np.ndarray:
    """Return how far the parallel axes of all joints and the point are from coplanar."""
    frames = arm.frames(q)
    count = q.shape[-1]
    axis, first_origin = frames[..., 0, :3, 2], frames[..., 0, :3, 3]
    offsets = [frames[..., i, :3, 3] - first_origin for i in range(1, count)] + [arm.point_of(frames) - first_origin]
    return _spanned_area(axis, offsets)


def _spanned_area(axis: np.ndarray, points: Sequence[np.ndarray]) -> np.ndarray:
    """Return the root sum of squares of the areas that pairs of points span, projected along an axis."""
    areas = [np.sum(axis * cross(a, b), axis=-1) for a, b in combinations(points, 2)]
    return np.asarray(np.sqrt(np.sum(np.square(areas), axis=0)))


def common_direction_error(arm: NumericChain, q: np.ndarray, joints: Sequence[int]) -> np.ndarray:
    """Return the sine of the angle between the directions in which two joints move the point."""
    first, second = (arm.jacobian(q)[..., :3, joint] for joint in joints)
    sizes = norms(first) * norms(second)
    return np.asarray(norms(cross(first, second)) / np.maximum(sizes, 1e-12))


def are_parallel(samples: Sequence[Sample], i: int, j: int) -> bool:
    """Return whether two axes are parallel at all samples."""
    return all(np.linalg.norm(cross(sample.axes[i], sample.axes[j])) < 1e-6 for sample in samples)


def prismatic_slant(arm: NumericChain, q: np.ndarray, prismatic: int, i: int, j: int, across: bool) -> np.ndarray:
    """Return the sine of the angle between a prismatic joint and the line from axis i to axis j.

    With `across`, return the sine of the angle by which the joint deviates from the perpendicular of that line. The
    axes are parallel; the line is the shortest between them. If they coincide, return 1.
    """
    frames = arm.frames(q)
    line, direction = frames[..., j, :3, 3] - frames[..., i, :3, 3], frames[..., prismatic, :3, 2]
    axis = frames[..., i, :3, 2]
    line = line - np.sum(line * axis, axis=-1)[..., None] * axis
    line_length = norms(line)
    deviation = np.abs(np.sum(direction * line, axis=-1)) if across else norms(cross(direction, line))
    return np.where(line_length < 1e-6, 1.0, deviation / np.maximum(line_length, 1e-6))


def origin_collinearity_error(arm: NumericChain, q: np.ndarray, k: int) -> np.ndarray:
    """Return the size of the cross product of O_{k-1} O_k and O_k O_{k+1}."""
    origins = arm.frames(q)[..., k - 1 : k + 2, :3, 3]
    return norms(cross(origins[..., 1, :] - origins[..., 0, :], origins[..., 2, :] - origins[..., 1, :]))
