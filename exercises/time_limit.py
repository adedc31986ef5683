"""A limit of processor time for work that can't be asked to stop in between, as SymPy's.

What is counted is what this process takes of the processor (user and system) inside of the block; time in which others
have the processor, or in which nothing is done, is not.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from sympy.core.cache import clear_cache

AGAIN = 0.2
"""Seconds after which a stop comes again that was lost, as one that came inside of a destructor is."""


class OutOfTime(BaseException):
    """The time is over. No error: whoever catches every `Exception` on the way must not keep it."""


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise OutOfTime inside of the block once it has taken `seconds` of processor time.

    What functions keep is kept whole: they keep results, which a stop leaves none of. SymPy, which notes in an
    expression what it has asked of it, forgets the expressions that it knows. Signals reach the main thread only: in
    another one, nothing is limited.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(_: int, __: FrameType | None) -> None:
        raise OutOfTime

    usual = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds, AGAIN)
    try:
        yield
    except (OutOfTime, KeyboardInterrupt):
        signal.setitimer(signal.ITIMER_PROF, 0)
        clear_cache()
        raise
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, usual)
