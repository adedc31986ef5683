"""Which places a point can reach, by the triangle inequality: for a planar arm, alone or rotated by joint 1.

In one more dimension, a place may be a point and an angle: see `reaches_beside`. `reaches_beyond` asks for many arms at
once whether they reach just beyond where they are: by these formulas if they apply, else by damped Newton from many
starts.

A planar arm of revolute joints with parallel axes reaches the distances from its first axis that its links, as vectors
of any direction, add up to: from |longest - all others| (or 0) to their sum. An RP arm reaches all distances from that
of the slide's line on. If joint 1 rotates a planar arm about an axis in its plane, or parallel to it, the arm reaches a
place if the planar arm does on either side of the axis.

A prismatic joint along the normal of the plane reaches every height, and changes nothing else. One that comes first in
the plane reaches everything at most as far from its line as the later links are long together. If an angle counts, too,
a last revolute joint sets it, and its axis remains to be placed; a last prismatic joint has the direction that the
angle determines, and the distance of its line remains.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from qdot.exercises.arm.axes import Sample
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.three_joints import NO, UNSURE, YES, reaches_places
from qdot.exercises.arm.vectors import cross
from qdot.exercises.common.stream import Stream

_EXACT = 1e-9
"""Sine, or part of the total length of all links, that counts as zero."""

_SURE = 1e-6
"""Places nearer to the limit of the reach than this part of the total length are left undecided."""


def reaches(arm: NumericChain, place: np.ndarray) -> bool | None:
    """Tell whether the point of a planar arm that joint 1 rotates can be at `place` (3, m); None if undecided."""
    known = _carried_arm(arm)
    if known is None:
        return None
    there = place - known.foot
    height = float(there @ known.axis)
    out = float(np.linalg.norm(there - height * known.axis))
    beside, size = known.beside, known.size + float(np.linalg.norm(there))  # a slide may be all that is long
    if abs(beside) > _EXACT * size and abs(out - abs(beside)) < _SURE * size:
        return None
    if abs(beside) > _EXACT * size and out < abs(beside):
        return False
    along = np.sqrt(max(out**2 - beside**2, 0.0))
    across, above = known.shoulder
    sides = [_is_inside(float(np.hypot(side * along - across, height - above)), known.distances) for side in (1, -1)]
    return True if True in sides else None if None in sides else False


@dataclass(frozen=True)
class _CarriedArm:
    """A planar arm, rotated about the line through `foot` along `axis`.

    `distances` are those that it reaches from its first axis. The plane is `beside` the line by that distance, its
    `shoulder` across from the foot and above it; `size` is that of the whole arm.
    """

    distances: np.ndarray
    axis: np.ndarray
    foot: np.ndarray
    shoulder: tuple[float, float]
    beside: float
    size: float


@lru_cache(maxsize=256)
def _carried_arm(arm: NumericChain) -> _CarriedArm | None:
    """Return an arm as a planar one that joint 1 rotates; None for other arms."""
    home, moving = _home_frames(arm), min(arm.point_frame, len(arm.kinds))
    if moving < 2 or arm.kinds[0] != "R":
        return None
    axes, origins, point = home[1:moving, :3, 2], home[1:moving, :3, 3], arm.point_of(home)
    normal, foot, axis = axes[0], home[0, :3, 3], home[0, :3, 2]
    distances = _distances(arm.kinds[1:moving], axes, origins, point)
    if distances is None or abs(axis @ normal) > _EXACT:
        return None
    way, beside = origins[0] - foot, float((point - foot) @ normal)
    size = float(np.sum(distances[np.isfinite(distances)])) + float(np.linalg.norm(way)) + abs(beside)
    shoulder = float(way @ np.cross(normal, axis)), float(way @ axis)
    return _CarriedArm(distances, axis, foot, shoulder, beside, size)


@lru_cache(maxsize=256)
def _home_frames(arm: NumericChain) -> np.ndarray:
    """Return the frames of an arm whose joints are all at zero; cached, as many places are tested."""
    return arm.frames(np.zeros(len(arm.kinds)))


def _distances(kinds: Sequence[str], axes: np.ndarray, origins: np.ndarray, point: np.ndarray) -> np.ndarray | None:
    """Return the least and the greatest distance of the point from the first axis; None for other arms."""
    if kinds[0] != "R":
        return None
    normal = axes[0]
    inside = np.eye(3) - np.outer(normal, normal)
    if all(kind == "R" for kind in kinds):
        if np.max(np.abs(axes @ inside)) > _EXACT:
            return None
        links = np.linalg.norm(np.diff([*origins, point], axis=0) @ inside, axis=1)
        return np.array([max(0.0, 2 * links.max() - links.sum()), links.sum()])
    if list(kinds) == ["R", "P"] and abs(axes[1] @ normal) < _EXACT:
        way = (point - origins[0]) @ inside
        return np.array([np.linalg.norm(way - (way @ axes[1]) * axes[1]), np.inf])
    return None


def _is_inside(distance: float, distances: np.ndarray) -> bool | None:
    least, greatest = distances
    near = _SURE * float(np.max(distances[np.isfinite(distances)]) + distance)
    if abs(distance - greatest) < near or (least > 0 and abs(distance - least) < near):
        return None
    return bool(least < distance < greatest)


# --- point and angle, and slides along the normal ---


def reaches_beside(arm: NumericChain, frames: np.ndarray, task: Sequence[int], shift: np.ndarray) -> bool | None:
    """Tell whether the arm reaches a place beside its pose, as far as `task` (rows) counts; None if undecided.

    `frames` is the pose as `NumericChain.frames` returns it, `shift` how far beside (m along an axis of the world, rad
    about one), in the order of the rows.
    """
    point = arm.point_of(frames)
    by = np.zeros(6)
    by[list(task)] = shift
    if list(task) == [0, 1, 2]:
        known = reaches(arm, point + by[:3])
        if known is not None:
            return known
    flat = _flat_arm(arm, tuple(task))
    if flat is None:
        return None
    if not flat.turns:
        return _reaches_flat(arm, flat, flat.joints, point + by[:3])
    turn = _rotation_about(by[3:])
    hand = flat.joints[-1]
    if arm.kinds[hand] == "R":
        axis = frames[hand, :3, 3]
        return _reaches_flat(arm, flat, flat.joints[:-1], point + by[:3] - turn @ (point - axis))
    if [arm.kinds[joint] for joint in flat.joints] != ["R", "R", "P"]:
        return None
    first, second = (frames[joint, :3, 3] for joint in flat.joints[:2])
    beside = cross(flat.normal, frames[hand, :3, 2])
    off = float((turn @ beside) @ (point + by[:3] - first) - beside @ (point - second))
    return _is_below(abs(off), float(np.linalg.norm(flat.inside @ (second - first))))


@dataclass(frozen=True)
class _FlatArm:
    """A planar arm with slides along its normal: the normal, joints that move in the plane, whether an angle counts.

    `inside` (3 x 3) projects a vector into the plane.
    """

    normal: np.ndarray
    inside: np.ndarray
    joints: tuple[int, ...]
    turns: bool


@lru_cache(maxsize=256)
def _flat_arm(arm: NumericChain, task: tuple[int, ...]) -> _FlatArm | None:
    """Return an arm as a planar one if the task counts its place in the plane, and its height if it can change."""
    home, turns = _home_frames(arm), [row - 3 for row in task if row >= 3]
    linear, moving = [row for row in task if row < 3], arm.point_frame
    axes, kinds = home[:moving, :3, 2], arm.kinds[:moving]
    if "R" not in kinds or (turns and moving != len(arm.kinds)):
        return None
    normal = axes[kinds.index("R")]
    share = np.abs(axes @ normal)
    along, square = share > 1 - _EXACT, share < _EXACT
    if not all(along[i] if kind == "R" else along[i] or square[i] for i, kind in enumerate(kinds)):
        return None
    if linear == [0, 1, 2]:
        if not any(kind == "P" and along[i] for i, kind in enumerate(kinds)):
            return None
    elif len(linear) != 2 or abs(normal[3 - sum(linear)]) < 1 - _EXACT:
        return None
    if turns and (len(turns) > 1 or abs(normal[turns[0]]) < 1 - _EXACT):
        return None
    joints = tuple(i for i, kind in enumerate(kinds) if kind == "R" or square[i])
    return _FlatArm(normal, np.eye(3) - np.outer(normal, normal), joints, bool(turns))


def _reaches_flat(arm: NumericChain, flat: _FlatArm, joints: tuple[int, ...], place: np.ndarray) -> bool | None:
    """Tell whether some joints of a planar arm bring the next joint's axis, or else the point, to a place (3).

    The height of the place does not matter.
    """
    home = _home_frames(arm)
    if not joints:
        return None
    behind = flat.joints[len(joints) :]
    tip = home[behind[0], :3, 3] if behind else arm.point_of(home)
    kinds, axes, origins = [arm.kinds[joint] for joint in joints], home[joints, :3, 2], home[joints, :3, 3]
    if kinds[0] == "R":
        distances = _distances(kinds, axes, origins, tip)
        return (
            None
            if distances is None
            else _is_inside(float(np.linalg.norm(flat.inside @ (place - origins[0]))), distances)
        )
    if len(kinds) == 1 or "P" in kinds[1:]:
        return None
    off = float(cross(flat.normal, axes[0]) @ (place - origins[1]))
    links = np.linalg.norm(np.diff([*origins[1:], tip], axis=0) @ flat.inside, axis=1)
    return _is_below(abs(off), float(links.sum()))


def _is_below(size: float, most: float) -> bool | None:
    return None if abs(size - most) < _SURE * (size + most) else size < most


def _rotation_about(turn: np.ndarray) -> np.ndarray:
    """Return the rotation by an angle about one axis of the world; entry i of `turn` (3) is the angle about axis i."""
    axis = int(np.argmax(np.abs(turn)))
    first, second = (axis + 1) % 3, (axis + 2) % 3
    rotation, angle = np.eye(3), float(turn[axis])
    rotation[first, first] = rotation[second, second] = np.cos(angle)
    rotation[second, first], rotation[first, second] = np.sin(angle), -np.sin(angle)
    return rotation


# --- just beyond where an arm is, for many arms at once ---

_STARTS, _STEPS = 80, 40
_EARLY, _KEPT = 8, 20
"""Searches for a configuration beyond a fold; after `_EARLY` steps only the `_KEPT` nearest continue."""

_BEYOND = 1e-4
"""How far beyond a fold to look, in parts of the reach: less than the hole that a folded arm leaves."""


def reaches_beyond(samples: Sequence[Sample], task: Sequence[int], directions: np.ndarray) -> np.ndarray:
    """Tell for each sample whether some configuration reaches just beyond it, in its direction of the task (k x m)."""
    arms = NumericChain.stack([sample.arm for sample in samples])
    reach = reach_lengths([sample.arm for sample in samples])
    linear = np.array([row < 3 for row in task])
    shifts = _BEYOND * reach[:, None] * directions * np.where(linear, 1.0, 1.0 / reach[:, None])
    frames = arms.frames(np.stack([sample.q for sample in samples])[:, None])[:, 0]
    answers = np.full(len(samples), UNSURE)
    if list(task) == [0, 1, 2] and len(arms.kinds) == arms.point_frame == 3:
        answers = reaches_places(arms, arms.point_of(frames[:, None])[:, 0] + shifts)
    for k in np.flatnonzero(answers == UNSURE).tolist():
        known = reaches_beside(samples[k].arm, frames[k], task, shifts[k])
        if known is not None:
            answers[k] = YES if known else NO
    left = np.flatnonzero(answers == UNSURE).tolist()
    if left:
        answers[left] = _search_beyond([samples[k].arm for k in left], frames[left], task, shifts[left], reach[left])
    return np.asarray(answers == YES)


def _search_beyond(
    all_arms: Sequence[NumericChain], frames: np.ndarray, task: Sequence[int], shifts: np.ndarray, reach: np.ndarray
) -> np.ndarray:
    """Search from many starts for configurations of the arms (k) that are `shifts` away from the poses of `frames`."""
    answers = np.full(len(all_arms), NO)
    left = np.arange(len(all_arms))
    arms = NumericChain.stack(all_arms)
    q = np.tile(_starts(len(arms.kinds)), (len(all_arms), 1, 1))
    for step in range(_STEPS):
        now = arms.frames(q)
        residual = _pose_difference(arms, frames[left], now)[..., task] + shifts[left, None]
        distance = np.linalg.norm(residual, axis=2)
        is_there = np.any(distance < 1e-6 * reach[left, None], axis=1)
        if is_there.any():
            answers[left[is_there]] = YES
            on = ~is_there
            left = left[on]
            if not len(left):
                break
            arms = NumericChain.stack([all_arms[k] for k in left])
            q, now, residual, distance = q[on], now[on], residual[on], distance[on]
        if step == _EARLY:
            kept = np.argsort(distance, axis=1, kind="stable")[:, :_KEPT]
            rows = np.arange(len(left))[:, None]
            q, residual, now = q[rows, kept], residual[rows, kept], now[rows, kept]
        jacobian = arms.jacobian_of(now)[..., task, :]
        across = jacobian.swapaxes(-1, -2)
        square = jacobian @ across + 1e-9 * np.eye(len(task))
        move = (across @ np.linalg.solve(square, residual[..., None]))[..., 0]
        q += move * np.minimum(1.0, 0.6 / np.maximum(np.abs(move).max(axis=2, keepdims=True), 1e-12))
    return answers


def _pose_difference(arms: NumericChain, frames: np.ndarray, now: np.ndarray) -> np.ndarray:
    """Return how far poses (k x m) of arms are from those of `frames` (k): place and small turn, k x m x 6."""
    target = arms.point_of(frames[:, None])
    between = frames[:, None, -1, :3, :3] @ now[..., -1, :3, :3].swapaxes(-1, -2)
    twice = between - between.swapaxes(-1, -2)
    turn = np.stack([twice[..., 2, 1], twice[..., 0, 2], twice[..., 1, 0]], axis=-1) / 2
    return np.concatenate([target - arms.point_of(now), turn], axis=-1)


@lru_cache(maxsize=64)
def _starts(n: int) -> np.ndarray:
    stream = Stream("starts")
    return np.array([[stream.uniform(-np.pi, np.pi) for _ in range(n)] for _ in range(_STARTS)])


def reach_lengths(arms: Sequence[NumericChain]) -> np.ndarray:
    """Return the median length of all links of each arm and its tool, to compare distances with.

    The tool may be the only length, as with two axes through one point.
    """
    distinct_arms = list({id(arm): arm for arm in arms}.values())
    starts = _starts(len(distinct_arms[0].kinds))
    origins = NumericChain.stack(distinct_arms).frames(np.broadcast_to(starts, (len(distinct_arms), *starts.shape)))[
        ..., :3, 3
    ]
    links = np.median(np.linalg.norm(np.diff(origins, axis=2), axis=3).sum(axis=2), axis=1)
    lengths = links + [float(np.linalg.norm(arm.offset[:3])) for arm in distinct_arms] + 1e-9
    length_of = {id(arm): length for arm, length in zip(distinct_arms, lengths, strict=True)}
    return np.array([length_of[id(arm)] for arm in arms])
