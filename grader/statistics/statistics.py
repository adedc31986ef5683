"""Compute statistics of a class from plain numbers: discrimination, reliability, chance.

If there are too few numbers for a statement, there is none: None. Notation: n students, k parts, r a correlation.
"""

import math
import statistics
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from qdot.exercises.common.stream import Stream

LEAST = 10
"""Fewer students than this say nothing about a correlation or a reliability."""
PERMUTATIONS = 4999
"""How often a test deals out the marks anew."""
_ALIKE = 1e-9

Numbers = Sequence[float]


@dataclass(frozen=True)
class Interval:
    """A value and the bounds between which it lies with 95 % confidence."""

    value: float
    low: float
    high: float


def correlation(first: Numbers, second: Numbers) -> float | None:
    """Return Pearson's correlation; None if either does not vary, but for rounding.

    >>> correlation([1, 2, 3], [2, 4, 6])
    1.0
    """
    left, right = (np.array(values) - statistics.fmean(values) for values in (first, second))
    scale = math.sqrt((left @ left) * (right @ right))
    return None if scale <= _ALIKE else max(-1.0, min(1.0, float(left @ right) / scale))


def discrimination(rows: Sequence[Numbers], part: int) -> Interval | None:
    """Return the corrected item-total correlation of a part: with the sum of the other parts.

    `rows` hold the points of a student each. None for fewer than `LEAST` students, one part, or if nothing varies.
    """
    if len(rows) < LEAST or len(rows[0]) < 2:
        return None
    r = correlation([row[part] for row in rows], [math.fsum(row) - row[part] for row in rows])
    return None if r is None else fisher(r, len(rows))


def fisher(r: float, n: int) -> Interval:
    """Return Fisher's interval of 95 % of a correlation, tanh(atanh r ± 1.96 / √(n − 3)).

    It is a rough one, because it assumes that marks are normally distributed.

    >>> [round(bound, 3) for bound in (fisher(0.5, 28).low, fisher(0.5, 28).high)]
    [0.156, 0.736]
    """
    middle, room = math.atanh(max(-0.999999, min(0.999999, r))), 1.959964 / math.sqrt(n - 3)
    return Interval(r, math.tanh(middle - room), math.tanh(middle + room))


def reliability(rows: Sequence[Numbers]) -> float | None:
    """Return Cronbach's alpha: k/(k − 1) · (1 − sum of the parts' variances / variance of the totals)."""
    if len(rows) < LEAST or len(rows[0]) < 2:
        return None
    k = len(rows[0])
    of_parts = math.fsum(statistics.variance(points) for points in zip(*rows, strict=True))
    of_totals = statistics.variance([math.fsum(row) for row in rows])
    return None if of_totals <= _ALIKE else k / (k - 1) * (1 - of_parts / of_totals)


# --- chance ---


def chance_of_groups(values: Numbers, groups: Sequence[Hashable], seed: str) -> float | None:
    """Return how often groups dealt out at random differ in their means as much as these do: a permutation test.

    The statistic is the variance between the groups' means, each counted by its size. Nothing is taken for normal. The
    observed grouping counts as one of `PERMUTATIONS` + 1, so that p is never 0. None for one group.
    """
    names = list(dict.fromkeys(groups))
    if len(names) < 2:
        return None
    numbers = np.asarray(values, dtype=float) - math.fsum(values) / len(values)
    member = np.array([[group == name for name in names] for group in groups], dtype=float)
    sizes = member.sum(axis=0)

    def between(dealt: np.ndarray) -> np.ndarray:
        return np.asarray(((dealt @ member) ** 2 / sizes).sum(axis=-1))

    observed = float(between(numbers))
    scale = max(float((numbers**2).sum()), _ALIKE)
    as_large = sum(
        int((between(numbers[order]) >= observed - _ALIKE * scale).sum()) for order in _permutations(len(numbers), seed)
    )
    return (1 + as_large) / (1 + PERMUTATIONS)


def _permutations(n: int, seed: str, at_once: int = 500) -> Iterator[np.ndarray]:
    """Yield permutations of n, some hundred at once: ranks of the bits of PCG64, which never change."""
    bits = np.random.PCG64(Stream(seed).below(1 << 62))
    for begun in range(0, PERMUTATIONS, at_once):
        size = min(at_once, PERMUTATIONS - begun)
        yield np.argsort(bits.random_raw((size, n)), axis=1, kind="stable")


def holm(chances: Numbers) -> list[float]:
    """Return p-values as Holm corrects them: what is the least of many tests is small by chance alone.

    >>> holm([0.01, 0.04, 0.03])
    [0.03, 0.06, 0.06]
    """
    order = sorted(range(len(chances)), key=lambda index: chances[index])
    corrected, so_far = [0.0] * len(chances), 0.0
    for rank, index in enumerate(order):
        so_far = max(so_far, min(1.0, (len(chances) - rank) * chances[index]))
        corrected[index] = so_far
    return corrected
