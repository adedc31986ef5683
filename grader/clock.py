"""Budgets of processor time: what takes longer is broken off, wherever it is, and everything else goes on.

The clock is the processor's, which a busy machine does not shorten. It works in any thread, as in those of a cluster's
workers, where signals do not.
"""

import contextlib
import ctypes
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field

import mpmath


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
        watch = _Watch(begun + self.left)
        watch.start()
        try:
            yield
        finally:
            watch.end()
            self.left -= time.process_time() - begun
            mpmath.mp.prec = digits  # what was broken off may not have come to it


@dataclass
class Allowance:
    """What a notebook's answers may take in all: to be judged, and to be looked at for what is behind wrong ones."""

    judging: Budget = field(default_factory=lambda: Budget(30.0))
    looking: Budget = field(default_factory=lambda: Budget(15.0))


class _Watch(threading.Thread):
    """Raises Overlong in the thread that made it when the process has taken so much processor time."""

    def __init__(self, until: float) -> None:
        super().__init__(daemon=True)
        self._until, self._watched = until, threading.get_ident()
        self._ended, self._lock = threading.Event(), threading.Lock()

    def run(self) -> None:
        """Wait, and raise it unless the end has come before."""
        while (left := self._until - time.process_time()) > 0:
            if self._ended.wait(left):
                return
        with self._lock:
            if not self._ended.is_set():
                _raise_in(self._watched, Overlong)

    def end(self) -> None:
        """See to it that nothing is raised from now on; what was, and has not arrived, is taken back."""
        with self._lock:
            self._ended.set()
            _raise_in(self._watched, None)


def _raise_in(thread: int, kind: type[BaseException] | None) -> None:
    raised = None if kind is None else ctypes.py_object(kind)
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), raised)
