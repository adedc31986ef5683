"""Which places a point can reach, by the triangle inequality: for a plane arm, by itself or carried round by joint 1.

A plane arm of turning joints about parallel axes reaches the distances from its first axis that its links, as vectors
of any direction, add up to: from |longest - all others| (or 0) to their sum. One that turns and then slides reaches
all distances from that of the slide's line on. What joint 1 carries round, about an axis that lies in the arm's plane
or parallel to it, reaches a place if the plane arm does on either side of the axis.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from exercises.arm.kinematics import NumericChain

_EXACT = 1e-9
"""Sine, or part of the length of all links, below which axes are parallel or square, and a length is zero."""

_SURE = 1e-6
"""Nothing is said of a place nearer to the limit of what is reached than this part of the length of all links."""


def reaches(arm: NumericChain, task: Sequence[int], place: np.ndarray) -> bool | None:
    """Tell whether the point can be at `place` (3, m), as far as `task` (rows) counts; None where this can't say."""
    home = _home(arm)
    moving = min(arm.point_frame, len(arm.kinds))
    carried = len(task) == 3
    if moving <= carried or list(task) not in ([0, 1], [0, 2], [1, 2], [0, 1, 2]) or arm.kinds[0] != "R":
        return None
    axes, origins, point = home[carried:moving, :3, 2], home[carried:moving, :3, 3], arm.point_of(home)
    normal, start = axes[0], origins[0]
    distances = _distances(arm.kinds[carried:moving], axes, origins, point)
    if distances is None:
        return None
    if not carried:
        (left,) = {0, 1, 2} - set(task)
        if 1 - abs(normal[left]) > _EXACT:
            return None
        flat = place - start
        return _inside(float(np.linalg.norm(np.delete(flat, left))), distances)
    axis = home[0, :3, 2]
    if abs(axis @ normal) > _EXACT:
        return None
    across, foot, beside = np.cross(normal, axis), start - home[0, :3, 3], float((point - home[0, :3, 3]) @ normal)
    there = place - home[0, :3, 3]
    height = float(there @ axis)
    out = float(np.linalg.norm(there - height * axis))
    size = float(np.sum(distances[np.isfinite(distances)])) + float(np.linalg.norm(foot)) + abs(beside)
    if abs(beside) > _EXACT * size and abs(out - abs(beside)) < _SURE * size:
        return None
    if abs(beside) > _EXACT * size and out < abs(beside):
        return False
    along = np.sqrt(max(out**2 - beside**2, 0.0))
    sides = [
        _inside(float(np.hypot(side * along - foot @ across, height - foot @ axis)), distances) for side in (1, -1)
    ]
    return True if True in sides else None if None in sides else False


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
