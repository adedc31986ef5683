"""Limit the processor time of computations that can't be interrupted otherwise, such as those of SymPy.

Only the processor time of this process (user and system) counts, not the time that the process spends waiting.
"""

import ctypes
import os
import re
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from sympy.core.cache import clear_cache

from qdot.exercises.common.errors import QdotError

DEFAULT_SECONDS, MIN_SECONDS, MAX_SECONDS = 60.0, 0.1, 1e8
"""Seconds of processor time for a derivation: the default, the minimum and the maximum."""

CHECK_INTERVAL = 0.05
"""Seconds between two checks of the limits.

If a limit is exceeded, every check raises the exception again, because Python drops exceptions raised in a
destructor."""


class OutOfTime(BaseException):
    """Raised when the time is over. It derives from BaseException, so that `except Exception` doesn't catch it."""


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

    Caches of functions stay valid, because they store only finished results. SymPy's cache is cleared: it may hold
    expressions with half-computed assumptions.
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
    """End a watchdog, even if it raises its exception at the same time."""
    while True:
        try:
            watchdog.end()
            return
        except OutOfTime:
            continue


class Watchdog:
    """Raises OutOfTime in the thread that created it, repeatedly from the time limit until `end` is called.

    The exception is raised between two Python instructions. One thread serves all watchdogs of the process, because
    starting a thread takes longer than most tasks.
    """

    def __init__(self, seconds: float) -> None:
        self._deadline = time.process_time() + seconds
        self._thread = threading.get_ident()
        with _state.lock:
            if not _state.is_checking:
                threading.Thread(target=_check_watchdogs, args=(_state,), daemon=True).start()
                _state.is_checking = True
            _state.watchdogs.add(self)

    def raise_if_late(self) -> None:
        """Raise OutOfTime in the thread of the watchdog if the time is over."""
        if time.process_time() >= self._deadline:
            self._raise(ctypes.py_object(OutOfTime))

    def _raise(self, exception_type: "ctypes.py_object[type[OutOfTime]] | None") -> None:
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(self._thread), exception_type)

    def end(self) -> None:
        """Stop watching, and cancel an exception that is pending."""
        with _state.lock:
            if self in _state.watchdogs:
                _state.watchdogs.remove(self)
                self._raise(None)


class _State:
    """The active watchdogs of this process, and whether a thread checks them."""

    def __init__(self) -> None:
        self.lock, self.watchdogs, self.is_checking = threading.Lock(), set[Watchdog](), False


_state = _State()


def _check_watchdogs(state: _State) -> None:
    """Check the watchdogs regularly; return when none is left."""
    while True:
        time.sleep(CHECK_INTERVAL)
        with state.lock:
            for watchdog in state.watchdogs:
                watchdog.raise_if_late()
            if not state.watchdogs:
                state.is_checking = False
                return


if hasattr(os, "register_at_fork"):  # a forked process has no other threads
    os.register_at_fork(after_in_child=_state.__init__)  # type: ignore[misc]
