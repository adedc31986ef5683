"""Work in several processes: results in order, work of dead processes repeated, no process left behind."""

import os
import signal
import subprocess
import sys
import threading
import time
import weakref
from concurrent.futures import Future
from contextlib import closing, suppress
from pathlib import Path

import pytest

from qdot.exercises.common import console
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.parallel import map_in_order
from tests.support import ROOT

PROGRAM = """
import sys
from pathlib import Path
from qdot.exercises.common.parallel import map_in_order
from tests.exercises.common.test_parallel import WorkerState, sleep_and_get_pid
print(next(map_in_order(sleep_and_get_pid, [0, 60], 2, WorkerState, (Path(sys.argv[1]),))), flush=True)
"""


class WorkerState:
    """The state of a worker: a folder, in which it records when it is closed."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def close(self) -> None:
        (self.folder / f"closed by {os.getpid()}").touch()


def square_or_die(place: WorkerState, item: int) -> int:
    """Return the square, but kill the process at the first attempt of 1 and at every attempt of 7."""
    mark = place.folder / "told to end"
    if item == 7 or (item == 1 and not mark.exists()):
        mark.touch()
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(20)
    return item * item


def sleep_and_get_pid(_: WorkerState, seconds: int) -> int:
    time.sleep(seconds)
    return os.getpid()


def fail_on_repeat(item: int) -> int:
    raise AssertionError(item)


@pytest.mark.parametrize("jobs", [1, 2])
def test_item_is_repeated_after_its_worker_died(tmp_path: Path, jobs: int) -> None:
    assert list(map_in_order(square_or_die, range(4), jobs, WorkerState, (tmp_path,), fail_on_repeat)) == [0, 1, 4, 9]
    assert (tmp_path / "told to end").exists()
    assert list(tmp_path.glob("closed by *"))


def test_workers_close_their_state_at_the_end(tmp_path: Path) -> None:
    pids = set(map_in_order(sleep_and_get_pid, [0, 0, 0], 2, WorkerState, (tmp_path,)))
    closed = {path.name for path in tmp_path.iterdir()}
    assert {f"closed by {pid}" for pid in pids} <= closed and len(closed) == 2


def test_only_the_thread_of_the_pool_cancels_items(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """If another thread does, the pool's thread crashes when a signal ends the processes at the same time."""
    cancel = Future.cancel
    threads = []

    def cancel_and_note_thread(item: Future[int]) -> bool:
        threads.append(threading.current_thread())
        return cancel(item)

    monkeypatch.setattr(Future, "cancel", cancel_and_note_thread)
    results = map_in_order(sleep_and_get_pid, [0, 60, 60, 60, 60], 2, WorkerState, (tmp_path,))
    with pytest.raises(KeyboardInterrupt), closing(results):
        next(results)
        raise KeyboardInterrupt
    assert threading.main_thread() not in threads


def test_progress_line_shows_count_and_total(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    with console.show_progress("verifying", 5) as counter:
        for _ in range(4):
            now[0] += 0.4 * console.PROGRESS_INTERVAL
            counter.step()
    assert capsys.readouterr().err.splitlines() == ["verifying: 3 of 5"]


def test_item_that_kills_two_workers_is_replaced_and_others_are_kept(tmp_path: Path) -> None:
    results = map_in_order(square_or_die, [5, 6, 7, 8], 2, WorkerState, (tmp_path,), lambda item: -item)
    assert list(results) == [25, 36, -7, 64]


def die_in_callback(place: WorkerState, item: int) -> int:
    """Return the square; at the first attempt of 1, be terminated in a callback, where Python ignores exceptions."""
    mark = place.folder / "told to end"
    if item == 1 and not mark.exists():
        mark.touch()
        watched = WorkerState(place.folder)
        callback = weakref.ref(watched, lambda _: signal.raise_signal(signal.SIGTERM))
        del watched
        time.sleep(20)
        (place.folder / "survived").write_text(str(callback()))
    return item * item


def test_worker_ends_if_it_is_terminated_in_a_callback(tmp_path: Path) -> None:
    results = map_in_order(die_in_callback, [1, 2], 2, WorkerState, (tmp_path,), lambda item: -item)
    assert list(results) == [1, 4]
    assert not (tmp_path / "survived").exists()


def test_dead_worker_is_reported_if_items_must_not_repeat(tmp_path: Path) -> None:
    with pytest.raises(QdotError, match="a worker process died"):
        list(map_in_order(square_or_die, [1, 2], 2, WorkerState, (tmp_path,)))


def test_idle_worker_ends_after_its_parent_is_killed(tmp_path: Path) -> None:
    command = [sys.executable, "-c", PROGRAM, str(tmp_path)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as parent:
        assert parent.stdout is not None
        idle = int(parent.stdout.readline())
        parent.kill()
    deadline = time.monotonic() + 10
    with suppress(ProcessLookupError):
        while time.monotonic() < deadline:
            os.kill(idle, 0)
            time.sleep(0.05)
        pytest.fail("the idle worker is still running")
    assert (tmp_path / f"closed by {idle}").exists()


MARK = 0
"""A value in a process's memory that forked processes inherit."""
MARKED = """
import sys, threading
from pathlib import Path
from qdot.exercises.common.parallel import map_in_order
from tests.exercises.common import test_parallel
test_parallel.MARK = 1
if sys.argv[2] == "beside a thread":
    threading.Thread(target=threading.Event().wait, daemon=True).start()
print(*map_in_order(test_parallel.read_mark, [0, 0], 2, test_parallel.WorkerState, (Path(sys.argv[1]),)))
"""


def read_mark(_: WorkerState, _item: int) -> int:
    return MARK


@pytest.mark.skipif(sys.platform != "linux", reason="processes are forked on Linux only")
@pytest.mark.parametrize(("how", "seen"), [("alone", "1 1"), ("beside a thread", "0 0")])
def test_workers_are_forked_unless_there_are_threads(tmp_path: Path, how: str, seen: str) -> None:
    command = [sys.executable, "-c", MARKED, str(tmp_path), how]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout.strip() == seen
