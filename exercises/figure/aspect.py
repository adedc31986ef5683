"""The view of an arm in a given pose: the one that separates joints and axes best.

The pose is fixed, unlike the pose of the arm's own figure, so the view is chosen instead. The views are rotations of
the usual view about the vertical axis, from a few heights, so that up stays up.
"""

import itertools

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.figure.plane import SPACE, axonometric
from qdot.exercises.figure.pose import ROOM, clearance, segments, skeletons

AZIMUTHS, ELEVATIONS = range(0, 360, 15), (24, 12, 40)
"""Angles from the usual view, and above the horizon, in degrees."""
NEAR, REACH = 44.0, 54.0
"""Distance in pixels below which two origins or ends of axes crowd each other, and length of an axis."""
SEEN = 0.45
"""The share of a z axis that should be visible."""
USUAL = 0.3
"""Bonus for the usual view, because the arm's own figure has it."""


def best_views(drawn: Chain, entries: np.ndarray, count: int) -> list[np.ndarray]:
    """Return the `count` best views (right, up, towards the reader; 3 x 3) of an arm with numbers, the best first.

    `entries` (n) are those of the table. Scores are rounded, so that ties are broken alike on every machine.
    """
    turns = itertools.product(ELEVATIONS, AZIMUTHS)
    views = np.array([axonometric(np.radians(36.0 + turn), np.radians(height)) for height, turn in turns])
    score = _scores(drawn, entries, views)
    score[0] += USUAL
    order = np.argsort(-np.round(score, 3), kind="stable")[:count]
    return [SPACE if k == 0 else views[k] for k in order]


def _scores(drawn: Chain, entries: np.ndarray, views: np.ndarray) -> np.ndarray:
    """Return how clearly views (k x 3 x 3) show the links, the origins and the z axes of an arm."""
    frames, corners, path = skeletons(drawn, entries[None])
    pieces = segments(frames, corners, path, drawn.point.frame)[0]
    flat = np.einsum("spx,kyx->kspy", pieces, views[:, :2])
    spread = np.ptp(flat.reshape(len(views), -1, 2), axis=1)
    scale = 1.0 / np.maximum(np.max(spread / ROOM, axis=1), 1e-9)
    origins, z = frames[0, :, :3, 3], frames[0, :, :3, 2]
    places = scale[:, None, None] * np.einsum("ix,kyx->kiy", origins, views[:, :2])
    ways = np.einsum("ix,kyx->kiy", z, views[:, :2])
    ends = np.stack([origins[-1], origins[-1] + 1e-6 * z[-1]])  # the last link's own direction is no link
    last = np.broadcast_to(np.einsum("px,kyx->kpy", ends, views[:, :2])[:, None], (len(views), 1, 2, 2))
    clear = np.clip(clearance(np.concatenate([flat, last], axis=1), 1) * scale / 50, 0, 1)
    short = np.minimum(np.linalg.norm(ways, axis=2) / SEEN, 1)
    behind = np.round(views[:, 2] @ z[0], 6) < 0  # the wall that carries the arm hides it
    return np.asarray(2.0 * clear + 0.6 * (short - 1).sum(axis=1) - _count_crowded(origins, z, places, ways) - behind)


def _count_crowded(origins: np.ndarray, z: np.ndarray, places: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """Return a weighted count of pairs of origins and ends of z axes that are drawn close together (k).

    The arguments are both in the world (n+1 x 3) and in the drawing (k x n+1 x 2). Coincident points don't count.
    """
    spots = np.concatenate([origins, origins + 0.37 * z])
    drawn, count = np.concatenate([places, places + REACH * ways], axis=1), len(origins)
    total = np.zeros(len(places))
    for i, j in itertools.combinations(range(len(spots)), 2):
        if np.linalg.norm(spots[i] - spots[j]) > 1e-6:
            gaps = np.linalg.norm(drawn[:, i] - drawn[:, j], axis=1)
            total += np.maximum(0.0, 1.0 - gaps / NEAR) * (4.0 if j < count else 1.0)
    return total
