"""Many like things done on several processes, their results in order; what was begun is not waited for after a stop."""

import multiprocessing
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Any, TypeVar

from exercises.errors import QdotError

Item = TypeVar("Item")
Made = TypeVar("Made")


def ordered_map(
    work: Callable[[Item], Made],
    items: Sequence[Item],
    jobs: int,
    setup: Callable[..., None],
    arguments: tuple[Any, ...],
) -> Iterator[Made]:
    """Yield `work(item)` for each item in order, on up to `jobs` processes, each prepared by `setup(*arguments)` once.

    With one job everything is done here. Raises QdotError where a process dies: what was finished has been yielded.
    """
    jobs = min(jobs, len(items))
    if jobs <= 1:
        setup(*arguments)
        yield from map(work, items)
        return
    # A fork of this process would copy the thread that draws the progress bar in whatever state it is.
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["exercises.generate"])
    with ProcessPoolExecutor(jobs, context, _begin, (setup, arguments)) as pool:
        try:
            yield from pool.map(work, items, chunksize=max(1, min(16, len(items) // (8 * jobs))))
        except BrokenProcessPool:
            raise QdotError("a worker process died (out of memory?); run the same command again to go on") from None
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _begin(setup: Callable[..., None], arguments: tuple[Any, ...]) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that shows progress
    setup(*arguments)
