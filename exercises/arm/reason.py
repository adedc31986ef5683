"""Decide whether a statement about singular configurations is their reason: it holds at no regular configuration.

Searches from many starts, on arms of several lengths, find configurations at which the statement holds. Each of them
must be singular. A statement that also holds at regular configurations is incidental, not a reason.
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
"""A configuration is certainly regular if its smallest singular value over the largest is above this."""


def is_reason(chain: Chain, samples: Sequence[Sample], off: Off, holds: Holds) -> bool:
    """Return whether J loses rank at every configuration at which `off` is zero and `holds` is true.

    `samples` are configurations at which the statement holds; `chain` has the task. If the search finds only singular
    configurations, the statement counts as the reason.
    """
    rows = chain.task_rows
    all_arms = list({id(sample.arm): sample.arm for sample in samples}.values())
    chosen_arms = all_arms[:: max(1, len(all_arms) // _ARMS)][:_ARMS]
    arms = NumericChain.stack(chosen_arms)
    q = _descend(arms, off, len(chosen_arms))
    has_converged = off(arms, q) < _CLOSE
    singular_values = np.linalg.svd(arms.jacobian(q)[..., rows, :], compute_uv=False)
    is_regular = singular_values[..., -1] > _REGULAR * np.maximum(singular_values[..., 0], _REGULAR)
    regular_indices = np.argwhere(has_converged & is_regular).tolist()
    return not any(holds(Sample(chosen_arms[arm], q[arm, start])) for arm, start in regular_indices)


def _descend(arms: NumericChain, off: Off, count: int) -> np.ndarray:
    """Return the configurations (arms x starts x n) that Newton steps along a measure's steepest descent reach.

    A measure has a kink at zero, but its square has none, so the gradient is that of the square.
    """
    starts = _starts(arms.kinds)
    n = starts.shape[1]
    q = np.tile(starts, (count, 1, 1))
    differences = _STEP * np.concatenate([np.eye(n), -np.eye(n)])
    for _ in range(_STEPS):
        values = off(arms, q)
        active = values > _CLOSE
        if not active.any():
            break
        neighbours = (q[:, :, None] + differences).reshape(count, -1, n)
        squares = (off(arms, neighbours) ** 2).reshape(*values.shape, 2, n)
        gradient = (squares[..., 0, :] - squares[..., 1, :]) / (2 * _STEP)
        step = (2 * values**2 / np.maximum(np.sum(gradient**2, axis=-1), 1e-30))[..., None] * gradient
        step *= np.minimum(1.0, _FARTHEST / np.maximum(np.abs(step).max(axis=-1, keepdims=True), 1e-12))
        q -= np.where(active[..., None], step, 0.0)
    return q


@lru_cache(maxsize=64)
def _starts(kinds: tuple[str, ...]) -> np.ndarray:
    rng = Stream("reason")
    return np.array(
        [[rng.uniform(-np.pi, np.pi) if kind == "R" else rng.uniform(0.2, 0.8) for kind in kinds]
         for _ in range(_STARTS)]
    )  # fmt: skip
