"""Which places a point can reach, by the triangle inequality: for a plane arm, by itself or carried round by joint 1.

In one more dimension, a place may be a point and an angle: see `reaches_beside`.

A plane arm of turning joints about parallel axes reaches the distances from its first axis that its links, as vectors
of any direction, add up to: from |longest - all others| (or 0) to their sum. One that turns and then slides reaches
all distances from that of the slide's line on. What joint 1 carries round, about an axis that lies in the arm's plane
or parallel to it, reaches a place if the plane arm does on either side of the axis.

A slide along the normal of the plane reaches every height, and changes nothing else. One that comes first in the plane
reaches everything as near to its line as the links behind it are long together. Where an angle counts, too, a last
joint that turns brings it about, and what is left to be reached is the place of its axis; a last slide has its
direction told by the angle, and what is left is the distance of its line.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.vectors import cross

_EXACT = 1e-9
"""Sine, or part of the length of all links, below which axes are parallel or square, and a length is zero."""

_SURE = 1e-6
"""Nothing is said of a place nearer to the limit of what is reached than this part of the length of all links."""


def reaches(arm: NumericChain, task: Sequence[int], place: np.ndarray) -> bool | None:
    """Tell whether the point can be at `place` (3, m), as far as `task` (rows) counts; None where this can't say."""
    known = _carried(arm, tuple(task))
    if known is None:
        return None
    if known.axis is None:
        return _inside(_length(known.inside @ (place - known.start)), known.distances)
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
    sides = [_inside(float(np.hypot(side * along - across, height - above)), known.distances) for side in (1, -1)]
    return True if True in sides else None if None in sides else False


@dataclass(frozen=True)
class _Carried:
    """A plane arm, by itself, or carried round about the line through `foot` along `axis`.

    `start` is on its first axis, `distances` are those that it reaches from there, and `inside` takes from a vector
    what is along its normal. Its plane is `beside` the line, its `shoulder` across from the foot and above it; `size`
    is that of the whole arm.
    """

    start: np.ndarray
    inside: np.ndarray
    distances: np.ndarray
    axis: np.ndarray | None
    foot: np.ndarray
    shoulder: tuple[float, float] = (0.0, 0.0)
    beside: float = 0.0
    size: float = 0.0


@lru_cache(maxsize=256)
def _carried(arm: NumericChain, task: tuple[int, ...]) -> _Carried | None:
    """Return an arm as a plane one, by itself or carried round; None for others."""
    home = _home(arm)
    moving = min(arm.point_frame, len(arm.kinds))
    carried = len(task) == 3
    if moving <= carried or task not in ((0, 1), (0, 2), (1, 2), (0, 1, 2)) or arm.kinds[0] != "R":
        return None
    axes, origins, point = home[carried:moving, :3, 2], home[carried:moving, :3, 3], arm.point_of(home)
    normal, start, foot = axes[0], origins[0], home[0, :3, 3]
    distances = _distances(arm.kinds[carried:moving], axes, origins, point)
    if distances is None:
        return None
    inside = np.eye(3) - np.outer(normal, normal)
    if not carried:
        (left,) = {0, 1, 2} - set(task)
        return _Carried(start, inside, distances, None, foot) if 1 - abs(normal[left]) <= _EXACT else None
    axis = home[0, :3, 2]
    if abs(axis @ normal) > _EXACT:
        return None
    way, beside = start - foot, float((point - foot) @ normal)
    size = float(np.sum(distances[np.isfinite(distances)])) + float(np.linalg.norm(way)) + abs(beside)
    shoulder = float(way @ np.cross(normal, axis)), float(way @ axis)
    return _Carried(start, inside, distances, axis, foot, shoulder, beside, size)


@lru_cache(maxsize=256)
def _home(arm: NumericChain) -> np.ndarray:
    """Return the frames of an arm whose joints are all at zero; kept, as many places are asked about."""
    return arm.frames(np.zeros(len(arm.kinds)))


def _distances(kinds: Sequence[str], axes: np.ndarray, origins: np.ndarray, point: np.ndarray) -> np.ndarray | None:
    """Return the least and the greatest distance of the point from the first axis; None for other arms than these."""
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


def _inside(distance: float, distances: np.ndarray) -> bool | None:
    least, greatest = distances
    near = _SURE * float(np.max(distances[np.isfinite(distances)]) + distance)
    if abs(distance - greatest) < near or (least > 0 and abs(distance - least) < near):
        return None
    return bool(least < distance < greatest)


# --- point and angle, and slides along the normal ---


def reaches_beside(arm: NumericChain, frames: np.ndarray, task: Sequence[int], shift: np.ndarray) -> bool | None:
    """Tell whether the arm can be beside where it is in a pose, as far as `task` (rows) counts; None: this can't say.

    `frames` is the pose as `NumericChain.frames` returns it, `shift` how far beside (m along an axis of the world, rad
    about one), in the order of the rows.
    """
    point = arm.point_of(frames)
    by = np.zeros(6)
    by[list(task)] = shift
    if max(task) < 3:
        known = reaches(arm, task, point + by[:3])
        if known is not None:
            return known
    flat = _flat(arm, tuple(task))
    if flat is None:
        return None
    if not flat.turns:
        return _reaches_flat(arm, flat, flat.joints, point + by[:3])
    turn = _about(by[3:])
    hand = flat.joints[-1]
    if arm.kinds[hand] == "R":
        axis = frames[hand, :3, 3]
        return _reaches_flat(arm, flat, flat.joints[:-1], point + by[:3] - turn @ (point - axis))
    if [arm.kinds[joint] for joint in flat.joints] != ["R", "R", "P"]:
        return None
    first, second = (frames[joint, :3, 3] for joint in flat.joints[:2])
    beside = cross(flat.normal, frames[hand, :3, 2])
    off = float((turn @ beside) @ (point + by[:3] - first) - beside @ (point - second))
    return _below(abs(off), float(np.linalg.norm(flat.inside @ (second - first))))


@dataclass(frozen=True)
class _Flat:
    """A plane arm with slides along its normal: the normal, the joints that move in the plane, whether an angle counts.

    `inside` (3 x 3) takes from a vector what is along the normal.
    """

    normal: np.ndarray
    inside: np.ndarray
    joints: tuple[int, ...]
    turns: bool


@lru_cache(maxsize=256)
def _flat(arm: NumericChain, task: tuple[int, ...]) -> _Flat | None:
    """Return an arm as a plane one whose place in the plane, and height if it can be had, are what the task counts."""
    home, turns = _home(arm), [row - 3 for row in task if row >= 3]
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
    return _Flat(normal, np.eye(3) - np.outer(normal, normal), joints, bool(turns))


def _reaches_flat(arm: NumericChain, flat: _Flat, joints: tuple[int, ...], place: np.ndarray) -> bool | None:
    """Tell whether some joints of a plane arm bring what they carry to a place (3), whatever its height.

    That is the axis of the joint behind them in the plane, or the point where none is left.
    """
    home = _home(arm)
    if not joints:
        return None
    behind = flat.joints[len(joints) :]
    tip = home[behind[0], :3, 3] if behind else arm.point_of(home)
    kinds, axes, origins = [arm.kinds[joint] for joint in joints], home[joints, :3, 2], home[joints, :3, 3]
    if kinds[0] == "R":
        distances = _distances(kinds, axes, origins, tip)
        return None if distances is None else _inside(_length(flat.inside @ (place - origins[0])), distances)
    if len(kinds) == 1 or "P" in kinds[1:]:
        return None
    off = float(cross(flat.normal, axes[0]) @ (place - origins[1]))
    links = np.linalg.norm(np.diff([*origins[1:], tip], axis=0) @ flat.inside, axis=1)
    return _below(abs(off), float(links.sum()))


def _below(size: float, most: float) -> bool | None:
    return None if abs(size - most) < _SURE * (size + most) else size < most


def _length(vector: np.ndarray) -> float:
    return float(np.linalg.norm(vector))


def _about(turn: np.ndarray) -> np.ndarray:
    """Return the rotation by an angle about one axis of the world; `turn` (3) has the angle at that axis."""
    axis = int(np.argmax(np.abs(turn)))
    first, second = (axis + 1) % 3, (axis + 2) % 3
    rotation, angle = np.eye(3), float(turn[axis])
    rotation[first, first] = rotation[second, second] = np.cos(angle)
    rotation[second, first], rotation[first, second] = np.sin(angle), -np.sin(angle)
    return rotation
