"""From which side an arm in a told pose is looked at: where its joints and axes are drawn apart.

A pose that is told can't be chosen, as that of the arm's own figure is; what can be chosen is where the reader stands.
The sides are turns of the usual view about the upright axis, from a few heights, so that up stays up.
"""

import itertools

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.figure.plane import SPACE, axonometric
from qdot.exercises.figure.pose import ROOM, clearance, segments, skeletons

AZIMUTHS, ELEVATIONS = range(0, 360, 15), (24, 12, 40)
"""Degrees from the usual view, and above the horizon."""
NEAR, REACH = 44.0, 54.0
"""Pixels below which two origins or ends of axes crowd each other, and the length of an axis."""
SEEN = 0.45
"""The part of a z axis that should be seen."""
USUAL = 0.3
"""What the usual view is liked better, as the arm's own figure is drawn in it."""


def sides(drawn: Chain, entries: np.ndarray, count: int) -> list[np.ndarray]:
    """Return the `count` best views (right, up, towards the reader; 3 x 3) of an arm with numbers, the best first.

    `entries` (n) are those of the table. Scores are rounded: a tie goes to the same view on every machine.
    """
    turns = itertools.product(ELEVATIONS, AZIMUTHS)
    views = np.array([axonometric(np.radians(36.0 + turn), np.radians(height)) for height, turn in turns])
    score = _scores(drawn, entries, views)
    score[0] += USUAL
    order = np.argsort(-np.round(score, 3), kind="stable")[:count]
    return [SPACE if k == 0 else views[k] for k in order]


def _scores(drawn: Chain, entries: np.ndarray, views: np.ndarray) -> np.ndarray:
    """Return how well an arm is seen in views (k x 3 x 3): its links, its origins, its z axes."""
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
    return np.asarray(2.0 * clear + 0.6 * (short - 1).sum(axis=1) - _crowd(origins, z, places, ways) - behind)


def _crowd(origins: np.ndarray, z: np.ndarray, places: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """Return how many pairs of origins and ends of z axes are drawn at nearly one place (k); more for two origins.

    Given are both in the world (n+1 x 3), and how they are drawn (k x n+1 x 2). What is at one place is left out.
    """
    spots = np.concatenate([origins, origins + 0.37 * z])
    drawn, count = np.concatenate([places, places + REACH * ways], axis=1), len(origins)
    total = np.zeros(len(places))
    for i, j in itertools.combinations(range(len(spots)), 2):
        if np.linalg.norm(spots[i] - spots[j]) > 1e-6:
            gaps = np.linalg.norm(drawn[:, i] - drawn[:, j], axis=1)
            total += np.maximum(0.0, 1.0 - gaps / NEAR) * (4.0 if j < count else 1.0)
    return total
