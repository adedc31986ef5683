"""Statistics of a class, as plain functions of plain numbers: difficulty, discrimination, reliability, chance.

Where there are too few numbers for a statement, there is none: None. Notation: n students, k parts, r a correlation.
"""

import math
from collections.abc import Hashable, Sequence
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


def mean(values: Numbers) -> float | None:
    """Return the mean, without rounding on the way."""
    return math.fsum(values) / len(values) if values else None


def median(values: Numbers) -> float | None:
    """Return the value in the middle, or halfway between the two.

    >>> median([3, 1, 2]), median([4, 1, 2, 3])
    (2, 2.5)
    """
    ordered = sorted(values)
    half = len(ordered) // 2
    if not ordered:
        return None
    return ordered[half] if len(ordered) % 2 else (ordered[half - 1] + ordered[half]) / 2


def variance(values: Numbers) -> float | None:
    """Return the sample's variance, with n − 1 below; None for fewer than two values."""
    middle = mean(values)
    if middle is None or len(values) < 2:
        return None
    return math.fsum((value - middle) ** 2 for value in values) / (len(values) - 1)


def deviation(values: Numbers) -> float | None:
    """Return the sample's standard deviation.

    >>> deviation([2, 4, 4, 4, 5, 5, 7, 9])
    2.138...
    """
    square = variance(values)
    return None if square is None else math.sqrt(square)


def correlation(one: Numbers, other: Numbers) -> float | None:
    """Return Pearson's correlation; None where either does not vary.

    >>> correlation([1, 2, 3], [2, 4, 6])
    1.0
    """
    first, second = mean(one), mean(other)
    if first is None or second is None:
        return None
    left, right = [value - first for value in one], [value - second for value in other]
    below = math.sqrt(math.fsum(x * x for x in left) * math.fsum(y * y for y in right))
    if below <= _ALIKE:
        return None
    return max(-1.0, min(1.0, math.fsum(x * y for x, y in zip(left, right, strict=True)) / below))


def discrimination(rows: Sequence[Numbers], part: int) -> Interval | None:
    """Return the corrected item-total correlation of a part: with the sum of the others, as it would else be in both.

    `rows` hold the points of a student each. The interval is Fisher's, r = tanh(atanh r ± 1.96 / √(n − 3)), which takes
    the marks for normal: it is a rough one. None for fewer than `LEAST` students, one part, or where nothing varies.
    """
    if len(rows) < LEAST or len(rows[0]) < 2:
        return None
    r = correlation([row[part] for row in rows], [math.fsum(row) - row[part] for row in rows])
    return None if r is None else fisher(r, len(rows))


def fisher(r: float, n: int) -> Interval:
    """Return the interval of 95 % of a correlation.

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
    parts = [variance([row[part] for row in rows]) or 0.0 for part in range(k)]
    whole = variance([math.fsum(row) for row in rows])
    return None if not whole or whole <= _ALIKE else k / (k - 1) * (1 - math.fsum(parts) / whole)


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
    as_large = 0
    for dealt in _dealt(len(numbers), seed):
        as_large += int((between(numbers[dealt]) >= observed - _ALIKE * scale).sum())
    return (1 + as_large) / (1 + PERMUTATIONS)


def _dealt(n: int, seed: str, at_once: int = 500) -> "list[np.ndarray]":
    """Return permutations of n, some hundred at once: ranks of the bits of PCG64, which stay the same for good."""
    bits = np.random.PCG64(Stream(seed).below(1 << 62))
    sizes = [at_once] * (PERMUTATIONS // at_once) + [PERMUTATIONS % at_once]
    return [np.argsort(bits.random_raw((size, n)), axis=1, kind="stable") for size in sizes if size]


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
