"""Budgets of processor time: work that exceeds its budget is interrupted, and everything else continues.

Processor time does not depend on how busy the machine is. Budgets use no signals, so they also work outside the main
thread, as in Dask workers.
"""

import contextlib
import time
from collections.abc import Iterator
from dataclasses import dataclass, field

import mpmath

from qdot.exercises.common.time_limit import OutOfTime, time_limit


class Budget:
    """A number of seconds of processor time that several tasks share, one after the other."""

    def __init__(self, seconds: float) -> None:
        self.seconds = self.remaining_seconds = seconds

    @contextlib.contextmanager
    def spend(self) -> Iterator[None]:
        """Subtract the processor time of the block from the budget. Raises OutOfTime in the block if it is used up."""
        if self.remaining_seconds <= 0:
            raise OutOfTime
        start_time, mpmath_precision = time.process_time(), mpmath.mp.prec
        try:
            with time_limit(self.remaining_seconds):
                yield
        finally:
            self.remaining_seconds -= time.process_time() - start_time
            mpmath.mp.prec = mpmath_precision  # interrupted code may not have restored it


@dataclass
class TimeBudgets:
    """The budgets for a notebook's answers: one for judging all of them, and one for diagnosing the wrong ones."""

    judging: Budget = field(default_factory=lambda: Budget(30.0))
    diagnosing: Budget = field(default_factory=lambda: Budget(15.0))
