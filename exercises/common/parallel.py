"""Many like things done on several processes, their results in order; a stop ends the processes at once.

Processes are forked from this one, with all that it has loaded, where that is safe: on Linux, while it has one thread.
Else they come from a process that loads it once more.
"""

import functools
import gc
import multiprocessing
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from multiprocessing import connection, resource_tracker
from multiprocessing.context import BaseContext
from multiprocessing.process import BaseProcess
from multiprocessing.util import Finalize
from typing import Any, NoReturn, TypeVar

from qdot.exercises.common.errors import QdotError

State = TypeVar("State")
Item = TypeVar("Item")
Made = TypeVar("Made")

METHODS = multiprocessing.get_all_start_methods()
HAS_SERVER = "forkserver" in METHODS
"""Whether processes can be forked from one that has loaded what they need; on Windows, each loads it for itself."""
CAN_FORK = sys.platform == "linux" and "fork" in METHODS
"""Whether a process may be forked: on macOS, libraries of the system fail after it. A fork of a process with threads
would copy whatever they were doing in whatever state it is, as the drawing of a progress bar."""
OF_GROUP = {getattr(signal, name) for name in ("SIGINT", "SIGHUP") if hasattr(signal, name)}
"""Signals that a terminal sends to all processes at once: Ctrl-C, and its own end, of which Windows has none."""
MASKS = hasattr(signal, "pthread_sigmask")
"""Whether a process can be born deaf to a signal; Windows has none that could reach it before it listens."""
if HAS_SERVER:
    from multiprocessing import forkserver

MANY = 500
"""From so many items on they are sent to the processes in chunks."""


def ordered_map(
    work: Callable[[State, Item], Made],
    items: Sequence[Item],
    jobs: int,
    setup: Callable[..., State],
    arguments: tuple[Any, ...],
    lost: Callable[[Item], Made] | None = None,
) -> Generator[Made, None, None]:
    """Yield `work(state, item)` for each item in order, on up to `jobs` processes.

    Each process makes its state once, by `setup(*arguments)`; a state's `close` is called in the end, if it has one.
    Close the generator (`contextlib.closing`) so that a stop ends the processes.

    Where a process dies, what was finished has been yielded, and QdotError is raised; with `lost`, what may have been
    at work then is done again, each item in a process of its own, and `lost(item)` stands for one that ends two of
    them. So `work` must be such that it may be done twice. With one job and without `lost`, everything is done here.
    """
    jobs = min(jobs, len(items))
    if jobs < 1 or (jobs == 1 and lost is None):
        state = setup(*arguments)
        try:
            for item in items:
                yield work(state, item)
        finally:
            _close(state)
        return
    chunk = max(1, min(16, len(items) // (8 * jobs))) if len(items) >= MANY and lost is None else 1
    done = 0
    while done < len(items):
        try:
            with closing(_run_pool(work, items[done:], jobs, chunk, setup, arguments)) as every:
                for made in every:
                    done += 1
                    yield made
        except BrokenProcessPool:
            if lost is None:
                raise QdotError(
                    "a worker process died (out of memory?); run the same command again, with a smaller --jobs"
                ) from None
            for item in items[done : done + jobs + 1]:  # a pool has no more out at a time, and takes them in order
                done += 1
                yield _run_alone(work, item, setup, arguments, lost)


def keep_state(state: State) -> State:
    """Return a state unchanged: the setup of processes that need nothing of their own."""
    return state


def _run_alone(
    work: Callable[[State, Item], Made],
    item: Item,
    setup: Callable[..., State],
    arguments: tuple[Any, ...],
    lost: Callable[[Item], Made],
) -> Made:
    """Return `work(state, item)` from a process that does nothing else, or from a second one if that dies."""
    for _ in range(2):
        try:
            (made,) = _run_pool(work, [item], 1, 1, setup, arguments)
            return made
        except BrokenProcessPool:
            continue
    return lost(item)


def _run_pool(
    work: Callable[[State, Item], Made],
    items: Sequence[Item],
    jobs: int,
    chunk: int,
    setup: Callable[..., State],
    arguments: tuple[Any, ...],
) -> Generator[Made, None, None]:
    """Yield `work(state, item)` for each item from `jobs` new processes. Raises BrokenProcessPool where one dies."""
    before = set(multiprocessing.active_children())
    is_forked = CAN_FORK and threading.active_count() == 1
    is_served = HAS_SERVER and not is_forked
    context: BaseContext = multiprocessing.get_context("fork" if is_forked else "forkserver" if is_served else "spawn")
    if is_served:
        context.set_forkserver_preload([work.__module__])
    with ProcessPoolExecutor(jobs, context, _begin, (setup, arguments)) as pool:
        try:
            if is_served:
                resource_tracker.ensure_running()  # it would undo what comes next
            with _defer_stop():  # whatever starts in here never sees a Ctrl-C, and starts whole
                if is_forked:
                    gc.freeze()  # no collection in a process writes to what it shares with this one
                elif is_served:
                    forkserver.ensure_running()  # it may be there already
                with warnings.catch_warnings():  # Python 3.12 counts the threads of libraries, which are of no harm
                    warnings.simplefilter("ignore", DeprecationWarning)
                    made = pool.map(functools.partial(_work_here, work), items, chunksize=chunk)
            yield from made
        except BrokenProcessPool:
            raise
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            _end(set(multiprocessing.active_children()) - before)
            raise


@contextmanager
def _defer_stop() -> Iterator[None]:
    """Let a stop take effect after the block only; what starts in it is born deaf to what a whole group is sent."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[signal.Signals] = []
    previous = {  # another thread may be given the signal
        each: signal.signal(each, lambda number, _: came.append(signal.Signals(number)))
        for each in (*OF_GROUP, signal.SIGTERM)
    }
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, OF_GROUP) if MASKS else set()
    try:
        yield
    finally:
        if MASKS:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for each, handler in previous.items():
            signal.signal(each, handler)
        for each in came:  # whatever failed in the block failed as everything was being ended
            signal.raise_signal(each)


def _end(processes: set[BaseProcess]) -> None:
    for process in processes:
        process.terminate()
    left = {process.sentinel for process in processes}
    while left:
        ended = connection.wait(left, timeout=1)
        if not ended:
            break
        left.difference_update(sentinel for sentinel in ended if isinstance(sentinel, int))
    for process in processes:
        if process.sentinel in left:
            process.kill()


# --- in the process that does the work ---

_state: Any = None
_busy = False


def _begin(setup: Callable[..., object], arguments: tuple[Any, ...]) -> None:
    global _state  # noqa: PLW0603 - set once when a process starts
    for number in OF_GROUP:  # they are for the process that shows progress
        signal.signal(number, signal.SIG_IGN)
    if MASKS:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, OF_GROUP)
    signal.signal(signal.SIGTERM, _handle_termination)
    threading.Thread(target=_follow_parent, daemon=True).start()
    _state = setup(*arguments)
    Finalize(None, _close, (_state,), exitpriority=10)  # when there is no more to do


def _work_here(work: Callable[[Any, Item], Made], item: Item) -> Made:
    global _busy  # noqa: PLW0603 - says whether there is something to tidy up
    _busy = True
    try:
        return work(_state, item)
    except SystemExit:
        _leave()
    finally:
        _busy = False


def _follow_parent() -> None:
    """Leave when the process that wants the results is gone, however it ended."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os.kill(os.getpid(), signal.SIGTERM)


def _handle_termination(*_: object) -> None:
    if _busy:
        raise SystemExit(1)  # half-written files are taken away on the way out
    _leave()


def _leave() -> NoReturn:
    try:
        _close(_state)
    finally:
        os._exit(1)


def _close(state: object) -> None:
    close = getattr(state, "close", None)
    if close is not None:
        close()
