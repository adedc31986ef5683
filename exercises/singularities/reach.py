"""Decide whether an arm without joint limits can reach a position, or a position just beyond its current one.

`reaches_point` decides for a point, and `reaches_displaced_pose` also for a point and an angle. `reaches_beyond`
decides for many arms at once whether they reach just beyond their current position. It uses the following rules if they
apply, else a damped Newton method from many starts. The rules are for planar arms, which joint 1 may rotate:

- An arm has only revolute joints with parallel axes. Each link can have any direction. By the triangle inequality, the
  greatest distance of P from the first axis is the sum of all links. The least distance is the longest link minus all
  other links, or 0 if this is negative.
- An RP arm reaches all distances from the first axis that are not less than that of the prismatic joint's line.
- Joint 1 rotates a planar arm about an axis in its plane, or parallel to its plane. The whole arm reaches a point if
  the planar arm reaches the point on either side of the axis.
- A prismatic joint along the normal of the plane reaches every height above the plane, and changes nothing else.
- The first joint in the plane is prismatic. The arm reaches all points whose distance from this joint's line is at most
  the total length of the later links.
- The task has an angle, and the last joint is revolute. This joint sets the angle, and the other joints must position
  its axis.
- The task has an angle, and the last joint is prismatic. The angle determines this joint's direction, and the other
  joints must bring its line to the right distance.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.vectors import cross
from qdot.exercises.common.stream import Stream
from qdot.exercises.singularities.axes import Sample, shorten_steps, stack_samples

_ZERO_TOLERANCE = 1e-9
"""A sine, or a distance as a fraction of the total length of all links, counts as zero below this limit."""

_UNDECIDED_MARGIN = 1e-6
"""No decision is made for points closer to the workspace boundary than this fraction of the total length."""


def reaches_point(arm: NumericChain, point: np.ndarray) -> bool | None:
    """Return whether a planar arm rotated by joint 1 reaches a point (a 3-vector in m).

    Return None if this is undecided, or for other arms.
    """
    rotated_arm = _find_rotated_planar_arm(arm)
    if rotated_arm is None:
        return None
    target = point - rotated_arm.foot
    height = float(target @ rotated_arm.axis)
    radius = float(np.linalg.norm(target - height * rotated_arm.axis))
    # the size includes the target, because the travel of a prismatic joint may be the arm's only length
    size = rotated_arm.size + float(np.linalg.norm(target))
    plane_offset = rotated_arm.plane_offset
    if abs(plane_offset) > _ZERO_TOLERANCE * size and abs(radius - abs(plane_offset)) < _UNDECIDED_MARGIN * size:
        return None
    if abs(plane_offset) > _ZERO_TOLERANCE * size and radius < abs(plane_offset):
        return False
    distance_in_plane = np.sqrt(max(radius**2 - plane_offset**2, 0.0))
    shoulder_radius, shoulder_height = rotated_arm.shoulder
    radii = distance_in_plane * np.array([1, -1]) - shoulder_radius  # on either side of the line
    answers = [_is_inside(float(x), rotated_arm.distance_range) for x in np.hypot(radii, height - shoulder_height)]
    return True if True in answers else None if None in answers else False


@dataclass(frozen=True)
class _RotatedPlanarArm:
    """A planar arm that joint 1 rotates about a line. The shoulder is the first axis of the planar arm.

    - `distance_range`: the minimum and the maximum distance from the shoulder that the planar arm reaches (m).
    - `axis`: the direction of the line.
    - `foot`: a point on the line.
    - `shoulder`: the position of the shoulder relative to `foot`: perpendicular to the line, and along the line (m).
    - `plane_offset`: the distance of the arm's plane from the line (m).
    - `size`: the total length of the arm (m).
    """

    distance_range: np.ndarray
    axis: np.ndarray
    foot: np.ndarray
    shoulder: tuple[float, float]
    plane_offset: float
    size: float


@lru_cache(maxsize=256)
def _find_rotated_planar_arm(arm: NumericChain) -> _RotatedPlanarArm | None:
    """Describe a planar arm that joint 1 rotates; return None for other arms."""
    moving_joint_count = arm.point_frame
    if moving_joint_count < 2 or not arm.is_revolute[0]:
        return None
    home = _compute_home_frames(arm)
    planar_frames, point = home[1:moving_joint_count], arm.compute_point_of(home)
    axes, origins = planar_frames[:, :3, 2], planar_frames[:, :3, 3]
    normal, foot, axis = axes[0], home[0, :3, 3], home[0, :3, 2]
    distance_range = _find_distance_range(arm.is_revolute[1:moving_joint_count], axes, origins, point)
    if distance_range is None or abs(axis @ normal) > _ZERO_TOLERANCE:
        return None
    offset, plane_offset = origins[0] - foot, float((point - foot) @ normal)
    finite_distances = distance_range[np.isfinite(distance_range)]
    size = float(np.sum(finite_distances)) + float(np.linalg.norm(offset)) + abs(plane_offset)
    shoulder = float(offset @ np.cross(normal, axis)), float(offset @ axis)
    return _RotatedPlanarArm(distance_range, axis, foot, shoulder, plane_offset, size)


@lru_cache(maxsize=256)
def _compute_home_frames(arm: NumericChain) -> np.ndarray:
    """Return the frames of an arm at home; cached, because many points are tested."""
    return arm.compute_frames(np.zeros(len(arm.kinds)))


def _find_distance_range(
    is_revolute: np.ndarray, axes: np.ndarray, origins: np.ndarray, point: np.ndarray
) -> np.ndarray | None:
    """Return the minimum and the maximum distance of P from the first axis of a planar arm; None for other arms.

    The arm is given by its joints, and by axes, origins and P at home. It has only revolute joints, or is an RP arm.
    """
    if not is_revolute[0]:
        return None
    normal = axes[0]
    projector = np.eye(3) - np.outer(normal, normal)
    if is_revolute.all():
        if np.max(np.abs(axes @ projector)) > _ZERO_TOLERANCE:
            return None
        link_lengths = np.linalg.norm(np.diff([*origins, point], axis=0) @ projector, axis=1)
        return np.array([max(0.0, 2 * link_lengths.max() - link_lengths.sum()), link_lengths.sum()])
    if len(is_revolute) == 2 and abs(axes[1] @ normal) < _ZERO_TOLERANCE:
        vector_to_point = (point - origins[0]) @ projector
        return np.array([np.linalg.norm(vector_to_point - (vector_to_point @ axes[1]) * axes[1]), np.inf])
    return None


def _is_inside(distance: float, limits: np.ndarray) -> bool | None:
    """Return whether a distance lies between two limits; None if it is too close to one of them."""
    minimum, maximum = limits
    tolerance = _UNDECIDED_MARGIN * float(np.max(limits[np.isfinite(limits)]) + distance)
    if abs(distance - maximum) < tolerance or (minimum > 0 and abs(distance - minimum) < tolerance):
        return None
    return bool(minimum < distance < maximum)


# --- a point and an angle, and prismatic joints along the normal ---


def reaches_displaced_pose(
    arm: NumericChain, frames: np.ndarray, task: Sequence[int], shift: np.ndarray
) -> bool | None:
    """Return whether the arm reaches a pose displaced from its current pose by `shift`; None if undecided.

    - `frames`: the arm's frames at its current configuration, as returned by `NumericChain.compute_frames`.
    - `task`: the indices of the task's rows.
    - `shift`: the displacement in each of these rows (m along a world axis, rad about a world axis).
    """
    displacement = np.zeros(6)
    displacement[list(task)] = shift
    point = arm.compute_point_of(frames)
    target = point + displacement[:3]
    if list(task) == [0, 1, 2]:
        answer = reaches_point(arm, target)
        if answer is not None:
            return answer
    planar_arm = _find_planar_arm(arm, tuple(task))
    if planar_arm is None:
        return None
    if not planar_arm.has_angle:
        return _reaches_in_plane(arm, planar_arm, planar_arm.joints, target)
    rotation, last_joint = _compute_axis_rotation(displacement[3:]), planar_arm.joints[-1]
    if arm.is_revolute[last_joint]:
        last_axis_target = target - rotation @ (point - frames[last_joint, :3, 3])
        return _reaches_in_plane(arm, planar_arm, planar_arm.joints[:-1], last_axis_target)
    if arm.is_revolute[list(planar_arm.joints)].tolist() != [True, True, False]:
        return None
    first_origin, second_origin = (frames[joint, :3, 3] for joint in planar_arm.joints[:2])
    line_normal = cross(planar_arm.normal, frames[last_joint, :3, 2])
    distance = float((rotation @ line_normal) @ (target - first_origin) - line_normal @ (point - second_origin))
    link_length = float(np.linalg.norm(planar_arm.plane_projector @ (second_origin - first_origin)))
    return _is_clearly_below(abs(distance), link_length)


@dataclass(frozen=True)
class _PlanarArm:
    """A planar arm that may also have prismatic joints along the normal of its plane.

    - `normal`: the normal of the plane.
    - `plane_projector`: the projection of a vector into the plane (3 x 3).
    - `joints`: the indices of the joints that move in the plane.
    - `has_angle`: whether the task has an angle.
    """

    normal: np.ndarray
    plane_projector: np.ndarray
    joints: tuple[int, ...]
    has_angle: bool


@lru_cache(maxsize=256)
def _find_planar_arm(arm: NumericChain, task: tuple[int, ...]) -> _PlanarArm | None:
    """Describe a planar arm; return None for other arms, and for tasks without the position in the plane.

    If the arm can change the height of P above the plane, the task must contain this height.
    """
    linear_axes, angle_axes = [row for row in task if row < 3], [row - 3 for row in task if row >= 3]
    home, moving_joint_count = _compute_home_frames(arm), arm.point_frame
    axes, is_revolute = home[:moving_joint_count, :3, 2], arm.is_revolute[:moving_joint_count]
    if not is_revolute.any() or (angle_axes and moving_joint_count != len(arm.kinds)):
        return None
    normal = axes[int(np.argmax(is_revolute))]
    cosines = np.abs(axes @ normal)
    is_parallel, is_in_plane = cosines > 1 - _ZERO_TOLERANCE, cosines < _ZERO_TOLERANCE
    if not np.all(is_parallel | (is_in_plane & ~is_revolute)):
        return None
    if linear_axes == [0, 1, 2]:
        if not np.any(is_parallel & ~is_revolute):
            return None
    # the third axis, with the number 3 - sum, must be the normal
    elif len(linear_axes) != 2 or abs(normal[3 - sum(linear_axes)]) < 1 - _ZERO_TOLERANCE:
        return None
    if angle_axes and (len(angle_axes) > 1 or abs(normal[angle_axes[0]]) < 1 - _ZERO_TOLERANCE):
        return None
    joints = tuple(np.flatnonzero(is_revolute | is_in_plane).tolist())
    return _PlanarArm(normal, np.eye(3) - np.outer(normal, normal), joints, bool(angle_axes))


def _reaches_in_plane(
    arm: NumericChain, planar_arm: _PlanarArm, joints: tuple[int, ...], target: np.ndarray
) -> bool | None:
    """Return whether the first `joints` of a planar arm can bring the axis of the next joint to `target` (3), or None.

    If no joint follows, they must bring P to the target. The height above the plane does not matter. None means
    undecided.
    """
    home = _compute_home_frames(arm)
    if not joints:
        return None
    later_joints = planar_arm.joints[len(joints) :]
    tip = home[later_joints[0], :3, 3] if later_joints else arm.compute_point_of(home)
    is_revolute, axes, origins = arm.is_revolute[list(joints)], home[joints, :3, 2], home[joints, :3, 3]
    if is_revolute[0]:
        distance_range = _find_distance_range(is_revolute, axes, origins, tip)
        distance = float(np.linalg.norm(planar_arm.plane_projector @ (target - origins[0])))
        return None if distance_range is None else _is_inside(distance, distance_range)
    if len(is_revolute) == 1 or not is_revolute[1:].all():
        return None
    distance = float(cross(planar_arm.normal, axes[0]) @ (target - origins[1]))
    link_lengths = np.linalg.norm(np.diff([*origins[1:], tip], axis=0) @ planar_arm.plane_projector, axis=1)
    return _is_clearly_below(abs(distance), float(link_lengths.sum()))


def _is_clearly_below(size: float, limit: float) -> bool | None:
    """Return whether a size is below a limit; None if the size is too close to the limit."""
    return None if abs(size - limit) < _UNDECIDED_MARGIN * (size + limit) else size < limit


def _compute_axis_rotation(angles: np.ndarray) -> np.ndarray:
    """Return the rotation (3 x 3) by angles (3) about the world axes; only one of the angles is nonzero."""
    axis = int(np.argmax(np.abs(angles)))
    next_axis, third_axis = (axis + 1) % 3, (axis + 2) % 3
    rotation, angle = np.eye(3), float(angles[axis])
    rotation[next_axis, next_axis] = rotation[third_axis, third_axis] = np.cos(angle)
    rotation[third_axis, next_axis], rotation[next_axis, third_axis] = np.sin(angle), -np.sin(angle)
    return rotation


# --- positions just beyond the current one, for many arms at once ---

_START_COUNT, _MAX_STEPS, _MAX_STEP_SIZE = 80, 40, 0.6
"""The search for a configuration beyond the current position: number of starts, maximum number of steps, and maximum
step of a joint (rad or m)."""
_CONVERGED_DISTANCE, _DAMPING = 1e-6, 1e-9
"""The distance, as a fraction of the arm's length, below which the target is reached, and the damping of the steps."""
_PRUNING_STEP, _KEPT_START_COUNT = 8, 20
"""After `_PRUNING_STEP` steps, only the `_KEPT_START_COUNT` searches that are nearest to the target continue."""

_TESTED_DISTANCE = 1e-4
"""Distance beyond the current position that is tested, as a fraction of the arm's length (`compute_arm_lengths`).

The distance must be smaller than the unreachable region around the base of a folded arm.
"""


def reaches_beyond(samples: Sequence[Sample], task: Sequence[int], directions: np.ndarray) -> np.ndarray:
    """Return for each of k samples whether the arm reaches just beyond its position at the sample.

    `directions` (k x m) are directions in the rows of the task, whose indices are `task`.
    """
    arms, q = stack_samples(samples)
    arm_lengths = compute_arm_lengths([sample.arm for sample in samples])
    is_linear = np.array([row < 3 for row in task])
    shifts = _TESTED_DISTANCE * arm_lengths[:, None] * directions * np.where(is_linear, 1.0, 1.0 / arm_lengths[:, None])
    frames = arms.compute_frames(q)[:, 0]
    poses_and_shifts = zip(samples, frames, shifts, strict=True)
    answers = [reaches_displaced_pose(sample.arm, pose, task, shift) for sample, pose, shift in poses_and_shifts]
    is_reached = np.array([bool(answer) for answer in answers])
    indices = [k for k, answer in enumerate(answers) if answer is None]
    if indices:
        arrays = frames[indices], shifts[indices], arm_lengths[indices]
        is_reached[indices] = _search_displaced_poses([samples[k].arm for k in indices], task, *arrays)
    return is_reached


def _search_displaced_poses(
    all_arms: Sequence[NumericChain],
    task: Sequence[int],
    frames: np.ndarray,
    shifts: np.ndarray,
    arm_lengths: np.ndarray,
) -> np.ndarray:
    """Return for each of k arms whether a search finds a configuration with a pose that is displaced by `shifts`.

    `frames` are the frames of the arms at the current poses. The search starts from many configurations of each arm.
    """
    is_reached = np.zeros(len(all_arms), dtype=bool)
    unsolved_indices = np.arange(len(all_arms))
    arms = NumericChain.stack(all_arms)
    q = np.tile(_sample_starts(len(arms.kinds)), (len(all_arms), 1, 1))
    for step in range(_MAX_STEPS):
        poses = arms.compute_frames(q)
        difference = _compute_pose_difference(arms, frames[unsolved_indices], poses)
        residual = difference[..., task] + shifts[unsolved_indices, None]
        distance = np.linalg.norm(residual, axis=2)
        has_converged = np.any(distance < _CONVERGED_DISTANCE * arm_lengths[unsolved_indices, None], axis=1)
        if has_converged.any():
            is_reached[unsolved_indices[has_converged]] = True
            is_unsolved = ~has_converged
            unsolved_indices = unsolved_indices[is_unsolved]
            if not len(unsolved_indices):
                break
            arms = NumericChain.stack([all_arms[k] for k in unsolved_indices])
            q, poses, residual, distance = (values[is_unsolved] for values in (q, poses, residual, distance))
        if step == _PRUNING_STEP:
            nearest_starts = np.argsort(distance, axis=1, kind="stable")[:, :_KEPT_START_COUNT]
            rows = np.arange(len(unsolved_indices))[:, None]
            q, residual, poses = (values[rows, nearest_starts] for values in (q, residual, poses))
        jacobian = arms.compute_jacobian_of(poses)[..., task, :]
        transposed_jacobian = jacobian.swapaxes(-1, -2)
        damped_gram_matrix = jacobian @ transposed_jacobian + _DAMPING * np.eye(len(task))
        steps = (transposed_jacobian @ np.linalg.solve(damped_gram_matrix, residual[..., None]))[..., 0]
        q += shorten_steps(steps, _MAX_STEP_SIZE)
    return is_reached


def _compute_pose_difference(arms: NumericChain, frames: np.ndarray, current_frames: np.ndarray) -> np.ndarray:
    """Return the displacements from poses to target poses, as changes in position and small rotations (k x m x 6).

    `current_frames` are the frames of k arms at m poses each. `frames` are the frames at one target pose for each arm.
    """
    target = arms.compute_point_of(frames[:, None])
    relative_rotation = frames[:, None, -1, :3, :3] @ current_frames[..., -1, :3, :3].swapaxes(-1, -2)
    skew_matrix = relative_rotation - relative_rotation.swapaxes(-1, -2)
    rotation = np.stack([skew_matrix[..., 2, 1], skew_matrix[..., 0, 2], skew_matrix[..., 1, 0]], axis=-1) / 2
    return np.concatenate([target - arms.compute_point_of(current_frames), rotation], axis=-1)


@lru_cache(maxsize=64)
def _sample_starts(n: int) -> np.ndarray:
    """Return random configurations of n joints, starts x n, which are the same in every call."""
    rng = Stream("starts")
    return np.array([[rng.uniform(-np.pi, np.pi) for _ in range(n)] for _ in range(_START_COUNT)])


def compute_arm_lengths(arms: Sequence[NumericChain]) -> np.ndarray:
    """Return the length (m) of each arm: the sum of its links and of the distance of P from its frame.

    Prismatic joints change the length of the links, so the median over random configurations is returned.
    """
    distinct_arms = list({id(arm): arm for arm in arms}.values())
    starts = np.stack([_sample_starts(len(arm.kinds)) for arm in distinct_arms])
    origins = NumericChain.stack(distinct_arms).compute_frames(starts)[..., :3, 3]
    link_lengths = np.median(np.linalg.norm(np.diff(origins, axis=2), axis=3).sum(axis=2), axis=1)
    offset_lengths = np.array([float(np.linalg.norm(arm.point_offset[:3])) for arm in distinct_arms])
    lengths = link_lengths + offset_lengths + 1e-9  # so that no length is zero
    lengths_by_id = {id(arm): length for arm, length in zip(distinct_arms, lengths, strict=True)}
    return np.array([lengths_by_id[id(arm)] for arm in arms])
