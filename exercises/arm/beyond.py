"""Whether an arm reaches places just beyond where it is, for many arms of one structure at once.

A formula says it for simple arms and for those of three joints, at once and for sure; for others, damped Newton from
many starts.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from qdot.exercises.arm.axes import Sample
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.reach import reaches_beside
from qdot.exercises.arm.three_joints import NO, UNSURE, YES, reaches_places
from qdot.exercises.common.stream import Stream

_STARTS, _STEPS = 80, 40
_EARLY, _KEPT = 8, 20
"""Searches for a configuration beyond a fold; after `_EARLY` steps only the `_KEPT` nearest go on."""

_BEYOND = 1e-4
"""How far beyond a fold that is, of the reach: less than the hole that a folded arm leaves."""


def reached_beyond(samples: Sequence[Sample], task: Sequence[int], directions: np.ndarray) -> np.ndarray:
    """Tell of each sample whether some configuration reaches just beyond it, in its direction of the task (k x m)."""
    arms = NumericChain.several([sample.arm for sample in samples])
    reach = reaches_of([sample.arm for sample in samples])
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
        answers[left] = _found([samples[k].arm for k in left], frames[left], task, shifts[left], reach[left])
    return np.asarray(answers == YES)


def _found(
    every: Sequence[NumericChain], frames: np.ndarray, task: Sequence[int], shifts: np.ndarray, reach: np.ndarray
) -> np.ndarray:
    """Look from many starts for configurations where the arms (k) are `shifts` beside the poses of `frames`."""
    found = np.full(len(every), NO)
    left = np.arange(len(every))
    arms = NumericChain.several(every)
    q = np.tile(_starts(len(arms.kinds)), (len(every), 1, 1))
    for step in range(_STEPS):
        now = arms.frames(q)
        residual = _off(arms, frames[left], now)[..., task] + shifts[left, None]
        distance = np.linalg.norm(residual, axis=2)
        is_there = np.any(distance < 1e-6 * reach[left, None], axis=1)
        if is_there.any():
            found[left[is_there]] = YES
            on = ~is_there
            left = left[on]
            if not len(left):
                break
            arms = NumericChain.several([every[k] for k in left])
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
    return found


def _off(arms: NumericChain, frames: np.ndarray, now: np.ndarray) -> np.ndarray:
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


def reaches_of(arms: Sequence[NumericChain]) -> np.ndarray:
    """Return the usual length of all links of each arm and of its tool, against which distances are judged.

    The tool may be the only length that there is, as of two axes through one point.
    """
    own = list({id(arm): arm for arm in arms}.values())
    starts = _starts(len(own[0].kinds))
    origins = NumericChain.several(own).frames(np.broadcast_to(starts, (len(own), *starts.shape)))[..., :3, 3]
    links = np.median(np.linalg.norm(np.diff(origins, axis=2), axis=3).sum(axis=2), axis=1)
    lengths = links + [float(np.linalg.norm(arm.offset[:3])) for arm in own] + 1e-9
    of = {id(arm): length for arm, length in zip(own, lengths, strict=True)}
    return np.array([of[id(arm)] for arm in arms])
