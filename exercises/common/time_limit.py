"""A limit of processor time for work that can't be asked to stop in between, as SymPy's.

What is counted is what this process takes of the processor (user and system) inside of the block; time in which others
have the processor, or in which nothing is done, is not.
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
"""Seconds of processor time after which a derivation ends if nothing else is said; and between what they are said."""

AGAIN = 0.2
"""Seconds after which a stop comes again that was lost, as one that came inside of a destructor is."""


class OutOfTime(BaseException):
    """The time is over. No error: whoever catches every `Exception` on the way must not keep it."""


def seconds_of(text: str) -> float:
    """Return the seconds that `--time` names. Raises QdotError.

    >>> seconds_of("300")
    300.0
    """
    number = re.fullmatch(r"\s*\+?(\d+\.?\d*|\.\d+)(e[+-]?\d{1,3})?\s*", text, re.ASCII | re.IGNORECASE)
    if number and LEAST <= float(text) <= MOST:
        return float(text)
    raise QdotError(f"--time {text!r} is not from {LEAST:g} to {MOST:.0f} seconds; write a number, as in --time 300")


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise OutOfTime inside of the block once it has taken `seconds` of processor time.

    What functions keep is kept whole: they keep results, which a stop leaves none of. SymPy, which notes in an
    expression what it has asked of it, forgets the expressions that it knows.
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
    """Let no stop of this kind come any more, though one may come on the way to that."""
    while True:
        try:
            watch.end()
            return
        except kind:
            continue


class Watch:
    """A stop by a thread that looks at the clock, from now on: it raises `kind` in the thread that made it.

    It comes between two steps of Python, and again until its end has come.
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
        """Let no stop come any more, not one either that is on its way."""
        with self._lock:
            if not self._ended.is_set():
                self._ended.set()
                self._raise(None)
