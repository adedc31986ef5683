"""How joint axes and the point of interest lie at a configuration: distances, angles, lines, planes.

Each measure is zero if a relation holds exactly: a point on an axis, two collinear axes. It takes one pose (n) or many
(k x n). A measure that is zero everywhere says nothing about a singular configuration, so it is also evaluated at a
`nearby_pose`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.vectors import cross

Off = Callable[["NumericChain", np.ndarray], np.ndarray]
"""A measure of an arm in many poses (… x n): how far each is from a relation, zero or more (…).

Of several arms at once (`NumericChain.stack`), the poses are k x m x n.
"""


@dataclass(frozen=True)
class Sample:
    """One arm in numbers at one configuration q (n)."""

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

    def off(self, measure: Off) -> float:
        """Return a measure at this configuration."""
        return float(measure(self.arm, self.q[None])[0])

    def off_nearby(self, measure: Off) -> float:
        """Return a measure in a pose near this one."""
        return float(measure(self.arm, nearby_pose(self)[None])[0])


def measure_samples(samples: Sequence[Sample], measure: Off) -> np.ndarray:
    """Return a measure at many configurations (k) of arms of one structure."""
    arms = NumericChain.stack([sample.arm for sample in samples])
    return np.asarray(measure(arms, np.stack([sample.q for sample in samples])[:, None])[:, 0])


def jacobians_of(samples: Sequence[Sample]) -> np.ndarray:
    """Return the Jacobian of each sample (k x 6 x n); the arms have one structure."""
    arms = NumericChain.stack([sample.arm for sample in samples])
    return arms.jacobian(np.stack([sample.q for sample in samples])[:, None])[:, 0]


def nearby_pose(sample: Sample, but: int | None = None) -> np.ndarray:
    """Return a pose (n) near a sample, in which nothing is aligned by chance; `but` moves one joint more."""
    moved = sample.q + 0.3 * np.arange(1, len(sample.q) + 1)
    if but is not None:
        moved[but] += 0.2
    return np.asarray(moved)


def nearby_samples(samples: Sequence[Sample]) -> list[Sample]:
    """Return samples nearby, at which special relations no longer hold."""
    return [Sample(sample.arm, nearby_pose(sample)) for sample in samples]


def distance(arm: NumericChain, q: np.ndarray, joint: int) -> np.ndarray:
    """Return the distance of the point from a joint's axis, in metres."""
    frames = arm.frames(q)
    away = arm.point_of(frames) - frames[..., joint, :3, 3]
    return _size(cross(frames[..., joint, :3, 2], away))


def slope(arm: NumericChain, q: np.ndarray, joint: int, movers: Sequence[int]) -> np.ndarray:
    """Return how fast the square of that distance changes with later joints; zero at an extreme."""
    frames = arm.frames(q)
    axis = frames[..., joint, :3, 2]
    away = arm.point_of(frames) - frames[..., joint, :3, 3]
    away = away - np.sum(away * axis, axis=-1)[..., None] * axis
    moving = arm.jacobian_of(frames)[..., :3, list(movers)]
    return _size(np.einsum("...j,...jm->...m", away, moving))


def spread(arm: NumericChain, q: np.ndarray, joints: Sequence[int]) -> np.ndarray:
    """Return the area or volume that the directions of two or three axes span: 0 to 1."""
    frames = arm.frames(q)
    first, second, *third = (frames[..., joint, :3, 2] for joint in joints)
    normal = cross(first, second)
    return np.asarray(np.abs(np.sum(normal * third[0], axis=-1))) if third else _size(normal)


def off_line(arm: NumericChain, q: np.ndarray, i: int, j: int) -> np.ndarray:
    """Return how far two axes are from collinear: sine of their angle plus distance of O_j from axis i."""
    frames = arm.frames(q)
    axis, between = frames[..., i, :3, 2], frames[..., j, :3, 3] - frames[..., i, :3, 3]
    return _size(cross(axis, frames[..., j, :3, 2])) + _size(cross(axis, between))


def off_plane(arm: NumericChain, q: np.ndarray, row: Sequence[int]) -> np.ndarray:
    """Return how far three or more parallel axes are from coplanar: the areas between their origins."""
    frames = arm.frames(q)
    axis, start = frames[..., row[0], :3, 2], frames[..., row[0], :3, 3]
    return _off_one_plane(axis, [frames[..., i, :3, 3] - start for i in row[1:]])


def off_level(arm: NumericChain, q: np.ndarray) -> np.ndarray:
    """Return how far the parallel axes of all joints and the point are from coplanar."""
    frames = arm.frames(q)
    count = q.shape[-1]
    axis, start = frames[..., 0, :3, 2], frames[..., 0, :3, 3]
    ends = [frames[..., i, :3, 3] - start for i in range(1, count)] + [arm.point_of(frames) - start]
    return _off_one_plane(axis, ends)


def _off_one_plane(axis: np.ndarray, places: Sequence[np.ndarray]) -> np.ndarray:
    """Return the root sum of squares of the areas that pairs of places span, projected along an axis."""
    areas = [np.sum(axis * cross(a, b), axis=-1) for k, a in enumerate(places) for b in places[k + 1 :]]
    return np.asarray(np.sqrt(np.sum(np.square(areas), axis=0)))


def off_common_direction(arm: NumericChain, q: np.ndarray, joints: Sequence[int]) -> np.ndarray:
    """Return the sine of the angle between the directions in which two joints move the point."""
    first, second = (arm.jacobian(q)[..., :3, joint] for joint in joints)
    sizes = _size(first) * _size(second)
    return np.asarray(_size(cross(first, second)) / np.maximum(sizes, 1e-12))


def parallel(samples: Sequence[Sample], i: int, j: int) -> bool:
    """Tell whether two axes are parallel in all samples."""
    return all(np.linalg.norm(cross(sample.axes[i], sample.axes[j])) < 1e-6 for sample in samples)


def slant(arm: NumericChain, q: np.ndarray, slide: int, i: int, j: int, across: bool) -> np.ndarray:
    """Return the sine of the angle by which a prismatic joint misses the direction from axis i to axis j, or `across`.

    The axes are parallel; the line is the shortest between them. If they coincide, return 1.
    """
    frames = arm.frames(q)
    line, along = frames[..., j, :3, 3] - frames[..., i, :3, 3], frames[..., slide, :3, 2]
    axis = frames[..., i, :3, 2]
    line = line - np.sum(line * axis, axis=-1)[..., None] * axis
    size = _size(line)
    leaning = np.abs(np.sum(along * line, axis=-1)) if across else _size(cross(along, line))
    return np.where(size < 1e-6, 1.0, leaning / np.maximum(size, 1e-6))


def bend(arm: NumericChain, q: np.ndarray, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the size of the cross product, and the scalar product, of O_{k-1} O_k and O_k O_{k+1}."""
    origins = arm.frames(q)[..., k - 1 : k + 2, :3, 3]
    first, second = origins[..., 1, :] - origins[..., 0, :], origins[..., 2, :] - origins[..., 1, :]
    return _size(cross(first, second)), np.asarray(np.sum(first * second, axis=-1))


def _size(vectors: np.ndarray) -> np.ndarray:
    return np.asarray(np.linalg.norm(vectors, axis=-1))
