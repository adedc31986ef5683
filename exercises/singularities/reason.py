"""Decide whether a statement about singular configurations is the reason why they are singular.

A statement is the reason if it holds at no regular configuration. Searches from many starts, for arms with different
lengths, find configurations at which the statement holds. All of these must be singular.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from qdot.exercises.arm.chain import REVOLUTE, Chain
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.stream import Stream
from qdot.exercises.singularities.axes import Measure, Sample, shorten_steps

Predicate = Callable[[Sample], bool | None]
"""A function that returns whether a statement is true at a sample; None if that is not clear."""

_MAX_ARMS, _START_COUNT, _MAX_STEPS = 3, 16, 60
"""Maximum number of arms that are searched, number of starts for each arm, and maximum number of steps."""
_CONVERGENCE_TOLERANCE = 1e-9
"""A measure counts as zero below this limit."""
_DIFFERENCE_STEP, _MAX_STEP_SIZE = 1e-6, 0.6
"""The step of finite differences, and the maximum step of the search (rad or m)."""
_REGULAR_RATIO, _SINGULAR_VALUE_FLOOR = 1e-4, 1e-4
"""Minimum ratio of the smallest to the largest singular value of J at a configuration that is certainly regular. In the
ratio, the largest singular value counts as at least the second number."""


def is_reason(chain: Chain, samples: Sequence[Sample], measure: Measure, predicate: Predicate) -> bool:
    """Return whether the task Jacobian loses rank at every configuration at which a statement holds.

    The statement holds if `measure` is zero and `predicate` returns True. The search uses the arms of `samples`. If the
    search finds only singular configurations, or none, the statement counts as the reason.
    """
    rows = chain.task_rows
    all_arms = list({id(sample.arm): sample.arm for sample in samples}.values())
    chosen_arms = all_arms[:: max(1, len(all_arms) // _MAX_ARMS)][:_MAX_ARMS]
    arms = NumericChain.stack(chosen_arms)
    q = _descend(arms, measure, len(chosen_arms))
    has_converged = measure(arms, q) < _CONVERGENCE_TOLERANCE
    singular_values = np.linalg.svd(arms.compute_jacobian(q)[..., rows, :], compute_uv=False)
    is_regular = singular_values[..., -1] > _REGULAR_RATIO * np.maximum(singular_values[..., 0], _SINGULAR_VALUE_FLOOR)
    regular_indices = np.argwhere(has_converged & is_regular).tolist()
    return not any(predicate(Sample(chosen_arms[i], q[i, start])) for i, start in regular_indices)


def _descend(arms: NumericChain, measure: Measure, arm_count: int) -> np.ndarray:
    """Return the configurations (arms x starts x n) at which the descent of a measure to zero ends.

    Newton steps use the gradient of the squared measure, which is smooth even where the measure is zero.
    """
    starts = _sample_starts(arms.kinds)
    n = starts.shape[1]
    q = np.tile(starts, (arm_count, 1, 1))
    steps_to_neighbours = _DIFFERENCE_STEP * np.concatenate([np.eye(n), -np.eye(n)])
    for _ in range(_MAX_STEPS):
        values = measure(arms, q)
        is_active = values > _CONVERGENCE_TOLERANCE
        if not is_active.any():
            break
        neighbours = (q[:, :, None] + steps_to_neighbours).reshape(arm_count, -1, n)
        squares = (measure(arms, neighbours) ** 2).reshape(*values.shape, 2, n)
        gradient = (squares[..., 0, :] - squares[..., 1, :]) / (2 * _DIFFERENCE_STEP)
        step = (2 * values**2 / np.maximum(np.sum(gradient**2, axis=-1), 1e-30))[..., None] * gradient
        q -= np.where(is_active[..., None], shorten_steps(step, _MAX_STEP_SIZE), 0.0)
    return q


@lru_cache(maxsize=64)
def _sample_starts(kinds: tuple[str, ...]) -> np.ndarray:
    """Return the random configurations (starts x n) at which searches for an arm with these joints start.

    Prismatic joints are extended by 0.2 to 0.8 m, so that they do not start at a retracted, special position.
    """
    rng, ranges = Stream("reason"), [(-np.pi, np.pi) if kind == REVOLUTE else (0.2, 0.8) for kind in kinds]
    return np.array([[rng.uniform(*limits) for limits in ranges] for _ in range(_START_COUNT)])
