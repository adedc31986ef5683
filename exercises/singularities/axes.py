"""Measure how joint axes and the point of interest P are arranged at a configuration: distances, angles, lines, planes.

A *measure* is zero if a relation holds exactly, for example if P is on an axis, or if two axes are collinear. A
relation that holds at every configuration can't explain a singular one. So measures are also evaluated near a singular
configuration.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.vectors import cross, dot, norms, remove_component

Measure = Callable[[NumericChain, np.ndarray], np.ndarray]
"""A function that returns for each configuration (… x n) of an arm how far the arm is from satisfying a relation.

The result is zero if the relation holds, else positive. If the arm combines k arms (`NumericChain.stack`), the
configurations are k x m x n.
"""

_ZERO_TOLERANCE = 1e-6
"""A sine, or a distance (m), counts as zero below this limit."""


@dataclass(frozen=True)
class Sample:
    """A numeric arm at one configuration q (n)."""

    arm: NumericChain
    q: np.ndarray

    @cached_property
    def frames(self) -> np.ndarray:
        """The poses of frames 0 ... n (n+1 x 4 x 4)."""
        return self.arm.compute_frames(self.q)

    @cached_property
    def axes(self) -> np.ndarray:
        """The directions z of the joint axes (n x 3) in the world frame."""
        return np.asarray(self.frames[: len(self.q), :3, 2])

    def evaluate(self, measure: Measure) -> float:
        """Return the value of a measure at this configuration."""
        return float(measure(self.arm, self.q[None])[0])


def stack_samples(samples: Sequence[Sample]) -> tuple[NumericChain, np.ndarray]:
    """Return the arms of k samples as one object, and the configurations (k x 1 x n).

    The arms have the same structure.
    """
    return NumericChain.stack([sample.arm for sample in samples]), np.stack([sample.q for sample in samples])[:, None]


def measure_samples(samples: Sequence[Sample], measure: Measure) -> np.ndarray:
    """Return the values of a measure (k) at k samples."""
    return np.asarray(measure(*stack_samples(samples))[:, 0])


def compute_jacobians(samples: Sequence[Sample]) -> np.ndarray:
    """Return the Jacobian of each sample (k x 6 x n)."""
    arms, q = stack_samples(samples)
    return arms.compute_jacobian(q)[:, 0]


def choose_nearby_configuration(sample: Sample, further_joint: int | None = None) -> np.ndarray:
    """Return a configuration (n) near a sample, at which no special relation holds by chance.

    If `further_joint` is given, the joint with this index is moved further than the others.
    """
    q = sample.q + 0.3 * np.arange(1, len(sample.q) + 1)  # a different step (rad or m) for each joint
    if further_joint is not None:
        q[further_joint] += 0.2
    return np.asarray(q)


def move_samples(samples: Sequence[Sample]) -> list[Sample]:
    """Return a sample near each of the samples, at which special relations no longer hold."""
    return [Sample(sample.arm, choose_nearby_configuration(sample)) for sample in samples]


def shorten_steps(steps: np.ndarray, max_size: float) -> np.ndarray:
    """Return the steps (… x n) of a search, shortened so that no component exceeds a maximum size (rad or m)."""
    sizes = np.abs(steps).max(axis=-1, keepdims=True)
    return np.asarray(steps * np.minimum(1.0, max_size / np.maximum(sizes, 1e-300)))


def measure_axis_distance(arm: NumericChain, q: np.ndarray, joint: int) -> np.ndarray:
    """Return the distance (m) of P from a joint's axis."""
    frames = arm.compute_frames(q)
    vector_to_point = arm.compute_point_of(frames) - frames[..., joint, :3, 3]
    return norms(cross(frames[..., joint, :3, 2], vector_to_point))


def measure_distance_change(arm: NumericChain, q: np.ndarray, joint: int, moving_joints: Sequence[int]) -> np.ndarray:
    """Return how fast some later joints change the squared distance of P from the axis of `joint`."""
    frames = arm.compute_frames(q)
    axis = frames[..., joint, :3, 2]
    vector_to_point = arm.compute_point_of(frames) - frames[..., joint, :3, 3]
    columns = arm.compute_jacobian_of(frames)[..., :3, list(moving_joints)]
    return norms(np.einsum("...j,...jm->...m", remove_component(vector_to_point, axis), columns))


def measure_axis_spread(arm: NumericChain, q: np.ndarray, joints: Sequence[int]) -> np.ndarray:
    """Return the area that the unit vectors along two axes span, or the volume that those along three axes span."""
    frames = arm.compute_frames(q)
    first_direction, second_direction, *third_direction = (frames[..., joint, :3, 2] for joint in joints)
    normal = cross(first_direction, second_direction)
    return np.asarray(np.abs(dot(normal, third_direction[0]))) if third_direction else norms(normal)


def measure_collinearity(arm: NumericChain, q: np.ndarray, joints: tuple[int, int]) -> np.ndarray:
    """Return the sine of the angle between axes i and j plus the distance (m) of O_j from axis i."""
    frames, (i, j) = arm.compute_frames(q), joints
    axis, offset = frames[..., i, :3, 2], frames[..., j, :3, 3] - frames[..., i, :3, 3]
    return norms(cross(axis, frames[..., j, :3, 2])) + norms(cross(axis, offset))


def measure_coplanarity(
    arm: NumericChain, q: np.ndarray, joints: Sequence[int], includes_point: bool = False
) -> np.ndarray:
    """Return how far parallel axes (and P, if `includes_point`) are from being coplanar.

    Each pair of vectors from the first axis to other axes spans an area in a plane at right angles to the axes. The
    result is the root of the sum of the squared areas.
    """
    frames, first_joint = arm.compute_frames(q), joints[0]
    points = [frames[..., i, :3, 3] for i in joints[1:]] + ([arm.compute_point_of(frames)] if includes_point else [])
    vectors = [point - frames[..., first_joint, :3, 3] for point in points]
    areas = [dot(frames[..., first_joint, :3, 2], cross(a, b)) for a, b in combinations(vectors, 2)]
    return np.asarray(np.sqrt(np.sum(np.square(areas), axis=0)))


def measure_common_direction(arm: NumericChain, q: np.ndarray, joints: Sequence[int]) -> np.ndarray:
    """Return the sine of the angle between the directions in which two joints move P."""
    velocity, other_velocity = (arm.compute_jacobian(q)[..., :3, joint] for joint in joints)
    product_of_speeds = norms(velocity) * norms(other_velocity)
    return np.asarray(norms(cross(velocity, other_velocity)) / np.maximum(product_of_speeds, 1e-12))


def are_parallel(samples: Sequence[Sample], i: int, j: int) -> bool:
    """Return whether two axes are parallel at all samples."""
    return all(np.linalg.norm(cross(sample.axes[i], sample.axes[j])) < _ZERO_TOLERANCE for sample in samples)


def measure_prismatic_slant(
    arm: NumericChain, q: np.ndarray, prismatic_joint: int, i: int, j: int, is_perpendicular: bool
) -> np.ndarray:
    """Return the sine of the angle between a prismatic joint and the shortest line from axis i to a parallel axis j.

    If `is_perpendicular`, return the cosine instead; it is zero if the joint is perpendicular to the line. Return 1 if
    the two axes coincide.
    """
    frames = arm.compute_frames(q)
    line = remove_component(frames[..., j, :3, 3] - frames[..., i, :3, 3], frames[..., i, :3, 2])
    direction, line_length = frames[..., prismatic_joint, :3, 2], norms(line)
    deviation = np.abs(dot(direction, line)) if is_perpendicular else norms(cross(direction, line))
    return np.where(line_length < _ZERO_TOLERANCE, 1.0, deviation / np.maximum(line_length, _ZERO_TOLERANCE))


def measure_origin_collinearity(arm: NumericChain, q: np.ndarray, k: int) -> np.ndarray:
    """Return the size of the cross product of the vectors from O_{k-1} to O_k and from O_k to O_{k+1}."""
    origins = arm.compute_frames(q)[..., k - 1 : k + 2, :3, 3]
    return norms(cross(origins[..., 1, :] - origins[..., 0, :], origins[..., 2, :] - origins[..., 1, :]))
