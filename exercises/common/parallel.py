"""Apply a function to many items on several processes, with the results in order; Ctrl-C ends all processes at once.

If a fork is safe (on Linux, with a single thread), the processes are forked from this process, with everything that it
has loaded. Otherwise they load everything again.
"""

import functools
import gc
import multiprocessing
import os
import signal
import sys
import threading
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
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
Result = TypeVar("Result")
Setup = Callable[..., State]

CORE_COUNT = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
"""The number of cores that this process may use."""
START_METHODS = multiprocessing.get_all_start_methods()
HAS_FORK_SERVER = "forkserver" in START_METHODS
"""Whether processes can be forked from a server that has loaded everything; on Windows, each loads everything
itself."""
CAN_FORK = sys.platform == "linux" and "fork" in START_METHODS
"""Whether this process may be forked, if it has no other threads; on macOS, system libraries fail after a fork.

A fork of a process with threads would copy their half-finished state, such as a progress bar's."""
GROUP_SIGNALS = {getattr(signal, name) for name in ("SIGINT", "SIGHUP") if hasattr(signal, name)}
"""Signals that a terminal sends to all processes at once: Ctrl-C, and the end of the terminal (not on Windows)."""
CAN_BLOCK_SIGNALS = hasattr(signal, "pthread_sigmask")
"""Whether a process can be started with signals blocked; on Windows, no signal reaches a new process that early."""
if HAS_FORK_SERVER:
    from multiprocessing import forkserver


def map_in_order(
    function: Callable[[State, Item], Result], items: Sequence[Item], jobs: int, setup: Setup[State],
    arguments: tuple[Any, ...], result_if_lost: Callable[[Item], Result] | None = None,
) -> Generator[Result, None, None]:  # fmt: skip
    """Yield `function(state, item)` for each item in order, on up to `jobs` processes.

    Each process creates its state once by `setup(*arguments)`. At the end, it calls the state's method `close`, if
    there is one. Close the generator (`contextlib.closing`) so that the processes end after Ctrl-C or an exception.

    If a process dies, QdotError is raised after the finished results are yielded. If there is a `result_if_lost`, the
    items that may have been in progress are repeated instead, each in a separate process. If an item kills two
    processes, its result is `result_if_lost(item)`. So `function` must be safe to repeat. With one job and without
    `result_if_lost`, everything runs in this process.
    """
    process_count = min(jobs, len(items))
    if process_count < 1 or (process_count == 1 and result_if_lost is None):
        state = setup(*arguments)
        try:
            for item in items:
                yield function(state, item)
        finally:
            _close_state(state)
        return
    run_pool = functools.partial(_run_pool, function, setup, arguments)
    finished_count = 0
    while finished_count < len(items):
        try:
            with closing(run_pool(items[finished_count:], process_count)) as results:
                for result in results:
                    finished_count += 1
                    yield result
        except BrokenProcessPool:
            if result_if_lost is None:
                advice = "if the machine ran out of memory, use a smaller --jobs"
                raise QdotError(f"a worker process died; run the same command again ({advice})") from None
            # A pool gives its processes one item more than they work on, so at most these items were in progress.
            for item in items[finished_count : finished_count + process_count + 1]:
                finished_count += 1
                yield _run_alone(run_pool, item, result_if_lost)


def open_pool(jobs: int, setup: Setup[State], arguments: tuple[Any, ...]) -> ProcessPoolExecutor:
    """Return a pool of processes for `submit_to_pool`; each creates its state by `setup(*arguments)` and keeps it."""
    context = multiprocessing.get_context("forkserver" if HAS_FORK_SERVER else "spawn")
    if HAS_FORK_SERVER:
        context.set_forkserver_preload([setup.__module__])
    return ProcessPoolExecutor(jobs, context, _start_worker, (setup, arguments))


def submit_to_pool(pool: ProcessPoolExecutor, function: Callable[[State, Item], Result], item: Item) -> Future[Result]:
    """Have a process of the pool compute `function(state, item)`. Raises BrokenProcessPool if one of them has died."""
    return pool.submit(_run_item, function, item)


def return_state(state: State) -> State:
    """Return the state unchanged. Use it as `setup` if each process gets the same state."""
    return state


def _run_alone(
    run_pool: Callable[..., Iterator[Result]], item: Item, result_if_lost: Callable[[Item], Result]
) -> Result:
    """Return `function(state, item)` from a separate process, or from a second one if the first dies."""
    for _ in range(2):
        try:
            (result,) = run_pool([item], jobs=1)
            return result
        except BrokenProcessPool:
            continue
    return result_if_lost(item)


def _run_pool(
    function: Callable[[State, Item], Result], setup: Setup[State], arguments: tuple[Any, ...], items: Sequence[Item],
    jobs: int,
) -> Generator[Result, None, None]:  # fmt: skip
    """Yield `function(state, item)` for each item from `jobs` new processes. Raises BrokenProcessPool if one dies."""
    earlier_children = set(multiprocessing.active_children())
    is_forked = CAN_FORK and threading.active_count() == 1
    uses_fork_server = HAS_FORK_SERVER and not is_forked
    context: BaseContext = multiprocessing.get_context(
        "fork" if is_forked else "forkserver" if uses_fork_server else "spawn"
    )
    if uses_fork_server:
        context.set_forkserver_preload([function.__module__])
    with ProcessPoolExecutor(jobs, context, _start_worker, (setup, arguments)) as pool:
        try:
            if uses_fork_server:
                resource_tracker.ensure_running()  # if started later, it would unblock the signals
            with _defer_stop():  # processes started here ignore Ctrl-C and start completely
                if is_forked:
                    gc.freeze()  # garbage collection then doesn't copy shared memory pages
                elif uses_fork_server:
                    forkserver.ensure_running()  # unless it is already running
                with warnings.catch_warnings():  # Python 3.12 warns of library threads, which do no harm
                    warnings.simplefilter("ignore", DeprecationWarning)
                    futures = deque(submit_to_pool(pool, function, item) for item in items)
            while futures:
                yield futures.popleft().result()
        except BrokenProcessPool:
            raise
        except BaseException:
            # The pool's own thread must cancel the items: it can crash if another thread does, as with `pool.map`.
            pool.shutdown(wait=False, cancel_futures=True)
            _end_processes(set(multiprocessing.active_children()) - earlier_children)
            raise


@contextmanager
def _defer_stop() -> Iterator[None]:
    """Hold back termination signals until the block ends; processes started in it ignore a terminal's signals."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    received_signals: list[signal.Signals] = []
    previous_handlers = {  # blocking is not enough: another thread may receive the signal
        signal_number: signal.signal(signal_number, lambda number, _: received_signals.append(signal.Signals(number)))
        for signal_number in (*GROUP_SIGNALS, signal.SIGTERM)
    }
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, GROUP_SIGNALS) if CAN_BLOCK_SIGNALS else set()
    try:
        yield
    finally:
        if CAN_BLOCK_SIGNALS:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for signal_number, handler in previous_handlers.items():
            signal.signal(signal_number, handler)
        for signal_number in received_signals:  # replaces an error in the block, because the signal caused that error
            signal.raise_signal(signal_number)


def _end_processes(processes: set[BaseProcess]) -> None:
    """Terminate processes, and kill those that are still running when no process has ended for a second."""
    for process in processes:
        process.terminate()
    running_sentinels = {process.sentinel for process in processes}
    while running_sentinels:
        ended_sentinels = connection.wait(running_sentinels, timeout=1)
        if not ended_sentinels:
            break
        running_sentinels.difference_update(sentinel for sentinel in ended_sentinels if isinstance(sentinel, int))
    for process in processes:
        if process.sentinel in running_sentinels:
            process.kill()


# --- in the worker process ---

_state: Any = None
"""The state that `setup` created."""
_is_busy = False
"""Whether an item is in progress."""


def _start_worker(setup: Callable[..., object], arguments: tuple[Any, ...]) -> None:
    """Prepare a new process: handle signals, watch the parent process, and create the state."""
    global _state  # noqa: PLW0603 - set once when a process starts
    for number in GROUP_SIGNALS:  # the parent process handles them
        signal.signal(number, signal.SIG_IGN)
    if CAN_BLOCK_SIGNALS:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, GROUP_SIGNALS)
    signal.signal(signal.SIGTERM, _handle_termination)
    sys.unraisablehook = _repeat_ignored_termination
    threading.Thread(target=_exit_with_parent, daemon=True).start()
    _state = setup(*arguments)
    Finalize(None, _close_state, (_state,), exitpriority=10)  # at the normal end of the process


def _run_item(function: Callable[[Any, Item], Result], item: Item) -> Result:
    global _is_busy  # noqa: PLW0603 - says whether there is something to tidy up
    _is_busy = True
    try:
        return function(_state, item)
    except SystemExit:
        _exit_worker()
    finally:
        _is_busy = False


def _exit_with_parent() -> None:
    """Wait until the parent process has ended, for whatever reason, and then end this process."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os.kill(os.getpid(), signal.SIGTERM)


def _handle_termination(*_: object) -> None:
    if _is_busy:
        raise SystemExit(1)  # lets `finally` blocks remove half-written files
    _exit_worker()


def _repeat_ignored_termination(unraisable: Any) -> None:
    """End the process after all if SystemExit was raised where Python ignores it, as in the callback of an import."""
    if unraisable.exc_type is SystemExit:
        threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGTERM)).start()  # the callback has ended by then
    else:
        sys.__unraisablehook__(unraisable)


def _exit_worker() -> NoReturn:
    try:
        _close_state(_state)
    finally:
        os._exit(1)


def _close_state(state: object) -> None:
    close = getattr(state, "close", None)
    if close is not None:
        close()
