"""Answers in numbers at some configurations, as mistakes are compared with them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

PRECISE = 1e-4
"""What numbers may be off, as a share of their size, to tell all mistakes apart."""
ENDLESS = 1e6
"""Terms so many times as large as what they are compared with may be off by anything, and are to be close to it."""
SAME = 1e-9
"""Share of the size of the terms by which equal values may differ."""


@dataclass(frozen=True)
class InNumbers:
    """An answer in numbers, (rows, columns, N), with the size of its terms; nan where it was left blank.

    `room` is what it may be off: a share of the size, and an amount. A direction counts up to a factor.
    """

    values: np.ndarray
    size: np.ndarray
    room: tuple[float, float]
    is_direction: bool = False

    def like(self, wanted: np.ndarray) -> np.ndarray:
        """Tell of each entry whether wanted values are the same, (rows, columns)."""
        with np.errstate(all="ignore"):
            if self.is_direction:
                direction, wanted_direction = unit(self.values), unit(wanted)
                way = np.where((direction * wanted_direction).sum(axis=0) < 0, -1.0, 1.0)  # the same for all entries
                near = np.abs(direction - way * wanted_direction) <= self.room[0]
            else:
                most = ENDLESS * np.maximum(np.abs(wanted).max(), 1.0)
                close = np.where(self.size < most, np.inf, SAME * most)
                near = np.abs(self.values - wanted) <= np.minimum(self._allowed, close)  # nan and inf are not
        return np.asarray(near.all(axis=-1))

    def is_all(self, wanted: np.ndarray) -> bool:
        """Tell whether wanted values have the same shape and are the same."""
        if self.values.shape != wanted.shape:
            return False
        if not self.is_direction:  # most differ at the first configuration already
            with np.errstate(all="ignore"):
                if not (np.abs(self.values[..., 0] - wanted[..., 0]) <= self._allowed[..., 0]).all():
                    return False
        return bool(self.like(wanted).all())

    def entry(self, row: int, column: int) -> "InNumbers":
        """Return one entry by itself, which may be off as much as among the others."""
        place = (slice(row, row + 1), slice(column, column + 1))
        return InNumbers(self.values[place], np.broadcast_to(self._largest, self.values[place].shape), self.room)

    @property
    def is_precise(self) -> bool:
        """Whether numbers were given to so many digits that hardly another mistake gives the same by chance."""
        return self.room[0] <= PRECISE and self.room[1] == 0.0

    @cached_property
    def _largest(self) -> np.ndarray:
        return np.asarray(np.fmax.reduce(self.size, axis=(0, 1)))

    @cached_property
    def _allowed(self) -> np.ndarray:
        with np.errstate(all="ignore"):
            # What is zero comes out as 1e-17 of what is not.
            return np.asarray(self.room[0] * np.maximum(self.size, self._largest) + self.room[1])


def unit(vector: np.ndarray) -> np.ndarray:
    """Return unit vectors, nan for those of no length."""
    length = np.sqrt(np.sum(np.abs(vector) ** 2, axis=0))
    return np.asarray(vector / np.where(length > SAME, length, np.nan))


def says_something(answer: np.ndarray) -> bool:
    """Tell whether entries are too particular to be hit by chance: not zero, and no few constants."""
    largest = np.abs(answer).max(axis=-1)
    varies = answer.shape[-1] == 1 or (np.ptp(answer, axis=-1) > SAME * largest).any()
    return bool((largest > SAME).any() and (varies or largest.size > 3))
