"""Compute statistics of a class from plain numbers: discrimination, reliability, p-values of permutation tests.

Discrimination and reliability are None if there are too few students. Notation: n is the number of students, k the
number of parts, and r a correlation.
"""

import math
import statistics
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from qdot.exercises.common.stream import Stream

MIN_STUDENTS = 10
"""Minimum number of students for a correlation or a reliability."""
PERMUTATION_COUNT = 4999
"""Number of random permutations of the marks in a test."""
BATCH_SIZE = 500
"""Number of permutations that are in memory at the same time."""
_TOLERANCE = 1e-9
"""Differences below this are taken for rounding errors."""

Numbers = Sequence[float]


@dataclass(frozen=True)
class Interval:
    """A value with the bounds of its 95 % confidence interval."""

    value: float
    low: float
    high: float


def compute_correlation(numbers: Numbers, other_numbers: Numbers) -> float | None:
    """Return Pearson's correlation; None if either sequence is constant, apart from rounding errors.

    >>> compute_correlation([1, 2, 3], [2, 4, 6])
    1.0
    """
    x, y = (np.array(values) - statistics.fmean(values) for values in (numbers, other_numbers))
    scale = math.sqrt((x @ x) * (y @ y))
    return None if scale <= _TOLERANCE else max(-1.0, min(1.0, float(x @ y) / scale))


def compute_discrimination(rows: Sequence[Numbers], part: int) -> Interval | None:
    """Return the corrected item-total correlation of a part: its correlation with the sum of the other parts.

    Each of the `rows` has the points of one student; `part` is an index. Return None if there are fewer than
    `MIN_STUDENTS` students or only one part, or if the points don't vary.
    """
    if len(rows) < MIN_STUDENTS or len(rows[0]) < 2:
        return None
    r = compute_correlation([row[part] for row in rows], [math.fsum(row) - row[part] for row in rows])
    return None if r is None else compute_fisher_interval(r, len(rows))


def compute_fisher_interval(r: float, n: int) -> Interval:
    """Return Fisher's 95 % confidence interval of a correlation, tanh(atanh r ± 1.96 / √(n − 3)).

    The interval is approximate, because it assumes that marks are normally distributed.

    >>> [round(bound, 3) for bound in (compute_fisher_interval(0.5, 28).low, compute_fisher_interval(0.5, 28).high)]
    [0.156, 0.736]
    """
    center = math.atanh(max(-0.999999, min(0.999999, r)))  # for r = 1, atanh would be infinite
    half_width = 1.959964 / math.sqrt(n - 3)
    return Interval(r, math.tanh(center - half_width), math.tanh(center + half_width))


def compute_reliability(rows: Sequence[Numbers]) -> float | None:
    """Return Cronbach's alpha: k/(k − 1) · (1 − sum of the parts' variances / variance of the totals).

    Each of the `rows` has the points of one student. Return None if there are too few students, only one part,
    or no variation in the totals.
    """
    if len(rows) < MIN_STUDENTS or len(rows[0]) < 2:
        return None
    k = len(rows[0])
    part_variances = math.fsum(statistics.variance(points) for points in zip(*rows, strict=True))
    total_variance = statistics.variance([math.fsum(row) for row in rows])
    return None if total_variance <= _TOLERANCE else k / (k - 1) * (1 - part_variances / total_variance)


# --- chance ---


def compute_permutation_p_value(values: Numbers, groups: Sequence[Hashable], seed: str) -> float:
    """Return the p-value of a permutation test: how often random groups differ at least as much as these.

    `groups` has the group of each of the values. The statistic is the variance between the groups' means, weighted by
    group size. No normal distribution is assumed. The observed grouping counts as one of `PERMUTATION_COUNT` + 1, so
    that p is never 0.
    """
    names = list(dict.fromkeys(groups))
    deviations = np.asarray(values, dtype=float) - math.fsum(values) / len(values)
    membership = np.array([[group == name for name in names] for group in groups], dtype=float)
    sizes = membership.sum(axis=0)

    def compute_group_variance(deviation_rows: np.ndarray) -> np.ndarray:
        """Return the variance between the groups' means for each row of deviations, up to a constant factor."""
        return np.asarray(((deviation_rows @ membership) ** 2 / sizes).sum(axis=-1))

    observed_variance = float(compute_group_variance(deviations))
    scale = max(float((deviations**2).sum()), _TOLERANCE)
    threshold = observed_variance - _TOLERANCE * scale
    batches = _generate_permutations(len(deviations), seed)
    count = sum(int((compute_group_variance(deviations[orders]) >= threshold).sum()) for orders in batches)
    return (1 + count) / (1 + PERMUTATION_COUNT)


def _generate_permutations(n: int, seed: str) -> Iterator[np.ndarray]:
    """Yield arrays of up to `BATCH_SIZE` permutations of the numbers 0 to n − 1, one permutation in each row.

    The permutations are the ranks of raw PCG64 output, because this output is the same in all versions of NumPy.
    """
    generator = np.random.PCG64(Stream(seed).integer_below(1 << 62))
    for start in range(0, PERMUTATION_COUNT, BATCH_SIZE):
        size = min(BATCH_SIZE, PERMUTATION_COUNT - start)
        yield np.argsort(generator.random_raw((size, n)), axis=1, kind="stable")


def correct_by_holm(p_values: Numbers) -> list[float]:
    """Return p-values corrected by Holm's method, because the smallest of many p-values may be small by chance.

    >>> correct_by_holm([0.01, 0.04, 0.03])
    [0.03, 0.06, 0.06]
    """
    values = np.array(p_values, dtype=float)
    order = np.argsort(values, kind="stable")
    scaled_values = np.minimum(1, np.arange(len(values), 0, -1) * values[order])
    values[order] = np.maximum.accumulate(scaled_values)
    return [float(value) for value in values]
