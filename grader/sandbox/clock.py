"""Budgets of processor time: work that takes longer is interrupted, and everything else continues.

Processor time does not depend on how busy the machine is. Budgets work in any thread, such as in those of a cluster's
workers, in which signals do not work.
"""

import contextlib
import time
from collections.abc import Iterator
from dataclasses import dataclass, field

import mpmath

from qdot.exercises.common.time_limit import Watch, stop_watch


class Overlong(BaseException):
    """No time is left. It is not an Exception, so that no code catches it as an error and continues."""


class Budget:
    """Seconds of processor time that several tasks use up, one after the other."""

    def __init__(self, seconds: float) -> None:
        self.seconds = self.left = seconds

    @contextlib.contextmanager
    def spend(self) -> Iterator[None]:
        """Subtract the time of the block. Raises Overlong inside the block as soon as no time is left."""
        if self.left <= 0:
            raise Overlong
        begun, digits = time.process_time(), mpmath.mp.prec
        watch = Watch(self.left, Overlong)
        try:
            yield
        finally:
            stop_watch(watch, Overlong)
            self.left -= time.process_time() - begun
            mpmath.mp.prec = digits  # interrupted code may not have restored it


@dataclass
class Allowance:
    """The processor time for a notebook's answers: for judging them, and for diagnosing wrong ones."""

    judging: Budget = field(default_factory=lambda: Budget(30.0))
    looking: Budget = field(default_factory=lambda: Budget(15.0))
