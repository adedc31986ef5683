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

DEFAULT_SECONDS, MIN_SECONDS, MAX_SECONDS = 60.0, 0.1, 1e8
"""Seconds of processor time for a derivation: the default, the minimum and the maximum."""

RESEND_INTERVAL = 0.2
"""Seconds after which the exception is raised again, because it may get lost, for example in a destructor."""


class OutOfTime(BaseException):
    """Raised if the time is over. OutOfTime is no `Exception`, so code that catches every `Exception` lets it pass."""


def parse_seconds(text: str) -> float:
    """Return the number of seconds in the text of `--time`. Raises QdotError.

    >>> parse_seconds("300")
    300.0
    """
    number = re.fullmatch(r"\s*\+?(\d+\.?\d*|\.\d+)(e[+-]?\d{1,3})?\s*", text, re.ASCII | re.IGNORECASE)
    if number and MIN_SECONDS <= float(text) <= MAX_SECONDS:
        return float(text)
    expected_form = f"a number of seconds from {MIN_SECONDS:g} to {MAX_SECONDS:.0f}, as in --time 300"
    raise QdotError(f"--time {text!r}: expected {expected_form}")


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise OutOfTime inside the block as soon as the block has used `seconds` of processor time.

    Caches of functions stay valid, because they store only finished results. SymPy's cache is cleared, because SymPy
    stores assumptions in the expressions themselves.
    """
    watchdog = Watchdog(seconds)
    try:
        yield
    except (OutOfTime, KeyboardInterrupt):
        end_watchdog(watchdog)
        clear_cache()
        raise
    finally:
        end_watchdog(watchdog)


def end_watchdog(watchdog: "Watchdog") -> None:
    """End the watch, even if its exception is raised meanwhile."""
    while True:
        try:
            watchdog.end()
            return
        except OutOfTime:
            continue


class Watchdog:
    """A thread that watches the clock and, after `seconds`, raises OutOfTime in the thread that created the watch.

    The exception is raised between two Python instructions, and again every `RESEND_INTERVAL` seconds until `end` is
    called.
    """

    def __init__(self, seconds: float) -> None:
        self._deadline = time.process_time() + seconds
        self._ended, self._lock = threading.Event(), threading.Lock()
        self._thread = threading.get_ident()
        threading.Thread(target=self._watch, daemon=True).start()

    def _watch(self) -> None:
        while not self._ended.wait(self._remaining_seconds() or RESEND_INTERVAL):
            with self._lock:
                if not self._remaining_seconds() and not self._ended.is_set():
                    self._raise(ctypes.py_object(OutOfTime))

    def _remaining_seconds(self) -> float:
        return max(0.0, self._deadline - time.process_time())

    def _raise(self, exception_type: "ctypes.py_object[type[OutOfTime]] | None") -> None:
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(self._thread), exception_type)

    def end(self) -> None:
        """Stop watching, and cancel an exception that is pending."""
        with self._lock:
            if not self._ended.is_set():
                self._ended.set()
                self._raise(None)
