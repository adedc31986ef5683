"""Whether a statement about singular configurations is their reason: it holds at no regular configuration.

Configurations at which it holds are searched for from many starts, on arms of several lengths; each of them has to be
singular. A statement that also holds at regular configurations is incidental, not a reason.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from qdot.exercises.arm.axes import Off, Sample
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.stream import Stream

Holds = Callable[[Sample], bool | None]

_ARMS, _STARTS, _STEPS = 3, 16, 60
_CLOSE, _STEP, _FARTHEST = 1e-9, 1e-6, 0.6
_REGULAR = 1e-4
"""Smallest singular value over the largest, above which a configuration is certainly regular."""


def is_reason(chain: Chain, samples: Sequence[Sample], off: Off, holds: Holds) -> bool:
    """Tell whether rank is lost wherever `off` is zero and `holds` is true.

    `samples` are configurations at which it holds; `chain` has the task. If the search finds only these, which are
    singular, the statement counts as the reason.
    """
    rows = chain.task_rows
    all_arms = list({id(sample.arm): sample.arm for sample in samples}.values())
    chosen_arms = all_arms[:: max(1, len(all_arms) // _ARMS)][:_ARMS]
    arms = NumericChain.stack(chosen_arms)
    q = _descend(arms, off, len(chosen_arms))
    is_there = off(arms, q) < _CLOSE
    sigma = np.linalg.svd(arms.jacobian(q)[..., rows, :], compute_uv=False)
    regular = sigma[..., -1] > _REGULAR * np.maximum(sigma[..., 0], _REGULAR)
    regular_places = np.argwhere(is_there & regular).tolist()
    return not any(holds(Sample(chosen_arms[arm], q[arm, start])) for arm, start in regular_places)


def _descend(arms: NumericChain, off: Off, count: int) -> np.ndarray:
    """Return configurations (arms x starts x n) that Newton steps along the steepest descent of a measure lead to.

    A measure has a kink at zero, and its square has none, so slopes are those of the square.
    """
    starts = _starts(arms.kinds)
    n = starts.shape[1]
    q = np.tile(starts, (count, 1, 1))
    to_sides = _STEP * np.concatenate([np.eye(n), -np.eye(n)])
    for _ in range(_STEPS):
        left = off(arms, q)
        going = left > _CLOSE
        if not going.any():
            break
        places = (q[:, :, None] + to_sides).reshape(count, -1, n)
        squares = (off(arms, places) ** 2).reshape(*left.shape, 2, n)
        slopes = (squares[..., 0, :] - squares[..., 1, :]) / (2 * _STEP)
        move = (2 * left**2 / np.maximum(np.sum(slopes**2, axis=-1), 1e-30))[..., None] * slopes
        move *= np.minimum(1.0, _FARTHEST / np.maximum(np.abs(move).max(axis=-1, keepdims=True), 1e-12))
        q -= np.where(going[..., None], move, 0.0)
    return q


@lru_cache(maxsize=64)
def _starts(kinds: tuple[str, ...]) -> np.ndarray:
    stream = Stream("reason")
    return np.array(
        [[stream.uniform(-np.pi, np.pi) if kind == "R" else stream.uniform(0.2, 0.8) for kind in kinds]
         for _ in range(_STARTS)]
    )  # fmt: skip
