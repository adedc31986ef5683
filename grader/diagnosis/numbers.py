"""Compare the values of an answer at some configurations with the values that mistakes give."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

PRECISE_TOLERANCE = 1e-4
"""Maximum relative tolerance of numbers that are precise enough to distinguish all mistakes."""
LARGE_TERM_RATIO = 1e6
"""If the terms are larger than the values by this factor, the size of the terms gives no useful tolerance."""
RELATIVE_TOLERANCE = 1e-9
"""Two values count as equal if they differ by at most this fraction of the size of their terms."""


class Tolerances(NamedTuple):
    """The tolerance relative to the size of the terms, and the absolute tolerance. Their sum is the allowed error."""

    relative: float
    absolute: float


@dataclass(frozen=True)
class NumericAnswer:
    """The values of an answer at N configurations and the size of its terms, (rows, columns, N); nan for blanks.

    Directions are compared up to a factor.
    """

    values: np.ndarray
    term_size: np.ndarray
    tolerances: Tolerances
    is_direction: bool = False

    def match_entries(self, expected: np.ndarray) -> np.ndarray:
        """Return for each entry whether its values equal the expected values, (rows, columns)."""
        with np.errstate(all="ignore"):
            if self.is_direction:
                direction, expected_direction = normalize(self.values), normalize(expected)
                sign = np.where((direction * expected_direction).sum(axis=0) < 0, -1.0, 1.0)  # the same for all entries
                is_near = np.abs(direction - sign * expected_direction) <= self.tolerances.relative
            else:
                # Terms of this size or more, which cancel, allow only a limited error.
                large_size = LARGE_TERM_RATIO * np.maximum(np.abs(expected).max(), 1.0)
                cap = np.where(self.term_size < large_size, np.inf, RELATIVE_TOLERANCE * large_size)
                is_near = np.abs(self.values - expected) <= np.minimum(self._allowed_error, cap)  # nan and inf are not
        return np.asarray(is_near.all(axis=-1))

    def equals(self, expected: np.ndarray) -> bool:
        """Return whether all values equal the expected values; False if these have another shape."""
        return self.values.shape == expected.shape and bool(self.match_entries(expected).all())

    def select_entry(self, row: int, column: int) -> "NumericAnswer":
        """Return one entry alone, with the same tolerance as in the whole answer."""
        values = self.values[row : row + 1, column : column + 1]
        return NumericAnswer(values, np.broadcast_to(self._largest_size, values.shape), self.tolerances)

    @property
    def is_precise(self) -> bool:
        """Whether the numbers have so many digits that mistakes hardly ever give the same numbers by chance."""
        return self.tolerances.relative <= PRECISE_TOLERANCE and self.tolerances.absolute == 0.0

    @cached_property
    def _largest_size(self) -> np.ndarray:
        """The largest finite size of the terms of any entry, (N,)."""
        finite_size = np.where(np.isfinite(self.term_size), self.term_size, np.nan)  # an infinite size allows any error
        return np.asarray(np.fmax.reduce(finite_size, axis=(0, 1)))

    @cached_property
    def _allowed_error(self) -> np.ndarray:
        """The error that is allowed for each value, (rows, columns, N)."""
        with np.errstate(all="ignore"):
            # Rounding can turn an entry that is zero into 1e-17 times the other entries.
            size = np.maximum(self.term_size, self._largest_size)
            return np.asarray(self.tolerances.relative * size + self.tolerances.absolute)


def normalize(vector: np.ndarray) -> np.ndarray:
    """Return the unit vectors along vectors (n, …), with nan for zero vectors."""
    length = np.sqrt(np.sum(np.abs(vector) ** 2, axis=0))
    return np.asarray(vector / np.where(length > RELATIVE_TOLERANCE, length, np.nan))


def is_distinctive(answer: np.ndarray) -> bool:
    """Return whether an answer is too specific to match by chance: it is neither zero nor only a few constants."""
    largest_values = np.abs(answer).max(axis=-1)
    varies = answer.shape[-1] == 1 or (np.ptp(answer, axis=-1) > RELATIVE_TOLERANCE * largest_values).any()
    return bool((largest_values > RELATIVE_TOLERANCE).any() and (varies or largest_values.size > 3))
