"""Budgets of processor time: what takes longer is broken off, wherever it is, and everything else goes on.

The clock is the processor's, which a busy machine does not shorten. It works in any thread, as in those of a cluster's
workers, where signals do not.
"""

import contextlib
import time
from collections.abc import Iterator
from dataclasses import dataclass, field

import mpmath

from qdot.exercises.common.time_limit import Watch, stop_alarm


class Overlong(BaseException):
    """There is no time left. Not an Exception, so that nothing on the way takes it for a fault and goes on."""


class Budget:
    """Seconds of processor time that several things take from, one after the other."""

    def __init__(self, seconds: float) -> None:
        self.seconds = self.left = seconds

    @contextlib.contextmanager
    def spent(self) -> Iterator[None]:
        """Take from it what the block takes. Raises Overlong, in the block, as soon as nothing is left."""
        if self.left <= 0:
            raise Overlong
        begun, digits = time.process_time(), mpmath.mp.prec
        watch = Watch(self.left, Overlong)
        try:
            yield
        finally:
            stop_alarm(watch, Overlong)
            self.left -= time.process_time() - begun
            mpmath.mp.prec = digits  # what was broken off may not have come to it


@dataclass
class Allowance:
    """What a notebook's answers may take in all: to be judged, and to be looked at for what is behind wrong ones."""

    judging: Budget = field(default_factory=lambda: Budget(30.0))
    looking: Budget = field(default_factory=lambda: Budget(15.0))
