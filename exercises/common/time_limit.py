"""Limit the processor time of work that can't be interrupted otherwise, such as SymPy's.

Only this process's processor time (user and system) counts, not the time in which it waits.
"""

import ctypes
import re
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from sympy.core.cache import clear_cache

from qdot.exercises.common.errors import QdotError

DEFAULT, LEAST, MOST = 60.0, 0.1, 1e8
"""Seconds of processor time for a derivation: the default, the minimum and the maximum."""

AGAIN = 0.2
"""Seconds after which the exception is raised again, because it may get lost, for example in a destructor."""


class OutOfTime(BaseException):
    """Raised if the time is over; not an `Exception`, so that code that catches every `Exception` lets it pass."""


def seconds_of(text: str) -> float:
    """Return the number of seconds in the text of `--time`. Raises QdotError.

    >>> seconds_of("300")
    300.0
    """
    number = re.fullmatch(r"\s*\+?(\d+\.?\d*|\.\d+)(e[+-]?\d{1,3})?\s*", text, re.ASCII | re.IGNORECASE)
    if number and LEAST <= float(text) <= MOST:
        return float(text)
    raise QdotError(f"--time {text!r} is not from {LEAST:g} to {MOST:.0f} seconds; write a number, as in --time 300")


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise OutOfTime inside the block as soon as it has used `seconds` of processor time.

    Caches of functions stay valid, because they store only finished results. SymPy's cache is cleared, because SymPy
    stores assumptions in the expressions themselves.
    """
    watch = Watch(seconds, OutOfTime)
    try:
        yield
    except (OutOfTime, KeyboardInterrupt):
        stop_watch(watch, OutOfTime)
        clear_cache()
        raise
    finally:
        stop_watch(watch, OutOfTime)


def stop_watch(watch: "Watch", kind: type[BaseException]) -> None:
    """End the watch, even if its exception is raised meanwhile."""
    while True:
        try:
            watch.end()
            return
        except kind:
            continue


class Watch:
    """A thread that watches the clock and, after `seconds`, raises `kind` in the thread that created the watch.

    The exception is raised between two Python instructions, and again every `AGAIN` seconds until `end` is called.
    """

    def __init__(self, seconds: float, kind: type[BaseException]) -> None:
        self._due, self._kind = time.process_time() + seconds, kind
        self._ended, self._lock = threading.Event(), threading.Lock()
        self._thread = threading.get_ident()
        threading.Thread(target=self._look, daemon=True).start()

    def _look(self) -> None:
        while not self._ended.wait(self._left() or AGAIN):
            with self._lock:
                if not self._left() and not self._ended.is_set():
                    self._raise(ctypes.py_object(self._kind))

    def _left(self) -> float:
        return max(0.0, self._due - time.process_time())

    def _raise(self, what: "ctypes.py_object[type[BaseException]] | None") -> None:
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(self._thread), what)

    def end(self) -> None:
        """Stop watching, and cancel an exception that is pending."""
        with self._lock:
            if not self._ended.is_set():
                self._ended.set()
                self._raise(None)
