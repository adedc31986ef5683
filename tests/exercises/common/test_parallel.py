"""Work done on several processes: in order, done again where a process ends, and no process left behind."""

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
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
from tests.exercises.common.test_parallel import Place, pid_or_asleep
print(next(map_in_order(pid_or_asleep, [0, 60], 2, Place, (Path(sys.argv[1]),))), flush=True)
"""


class Place:
    """The state of a process: a folder, in which it says when it is closed."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def close(self) -> None:
        (self.folder / f"closed by {os.getpid()}").touch()


def squared(place: Place, item: int) -> int:
    """Return the square, but end the process over 1 when it comes for the first time, and always over 7."""
    mark = place.folder / "told to end"
    if item == 7 or (item == 1 and not mark.exists()):
        mark.touch()
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(20)
    return item * item


def pid_or_asleep(_: Place, seconds: int) -> int:
    time.sleep(seconds)
    return os.getpid()


def never(item: int) -> int:
    raise AssertionError(item)


@pytest.mark.parametrize("jobs", [1, 2])
def test_what_a_process_ended_over_is_done_again_and_nothing_stands_for_it(tmp_path: Path, jobs: int) -> None:
    assert list(map_in_order(squared, range(4), jobs, Place, (tmp_path,), never)) == [0, 1, 4, 9]
    assert (tmp_path / "told to end").exists()
    assert list(tmp_path.glob("closed by *"))


def test_what_a_process_has_set_up_is_closed_when_there_is_no_more_to_do(tmp_path: Path) -> None:
    pids = set(map_in_order(pid_or_asleep, [0, 0, 0], 2, Place, (tmp_path,)))
    closed = {path.name for path in tmp_path.iterdir()}
    assert {f"closed by {pid}" for pid in pids} <= closed and len(closed) == 2


def test_a_line_of_progress_says_how_far_it_is(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    with console.show_progress("verifying", 5) as counter:
        for _ in range(4):
            now[0] += 0.4 * console.PROGRESS_INTERVAL
            counter.step()
    assert capsys.readouterr().err.splitlines() == ["verifying: 3 of 5"]


def test_what_ends_two_processes_is_lost_and_the_others_are_not(tmp_path: Path) -> None:
    assert list(map_in_order(squared, [5, 6, 7, 8], 2, Place, (tmp_path,), lambda item: -item)) == [25, 36, -7, 64]


def test_a_process_that_ends_is_told_where_nothing_is_to_be_done_twice(tmp_path: Path) -> None:
    with pytest.raises(QdotError, match="a worker process died"):
        list(map_in_order(squared, [1, 2], 2, Place, (tmp_path,)))


def test_an_idle_process_ends_with_the_one_that_was_killed(tmp_path: Path) -> None:
    command = [sys.executable, "-c", PROGRAM, str(tmp_path)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as one:
        assert one.stdout is not None
        idle = int(one.stdout.readline())
        one.kill()
    deadline = time.monotonic() + 10
    with suppress(ProcessLookupError):
        while time.monotonic() < deadline:
            os.kill(idle, 0)
            time.sleep(0.05)
        pytest.fail("it is still there")
    assert (tmp_path / f"closed by {idle}").exists()


MARK = 0
"""What a process has in its memory, and one that is forked from it, too."""

MARKED = """
import sys, threading
from pathlib import Path
from qdot.exercises.common.parallel import map_in_order
from tests.exercises.common import test_parallel
test_parallel.MARK = 1
if sys.argv[2] == "beside a thread":
    threading.Thread(target=threading.Event().wait, daemon=True).start()
print(*map_in_order(test_parallel.mark, [0, 0], 2, test_parallel.Place, (Path(sys.argv[1]),)))
"""


def mark(_: Place, _item: int) -> int:
    return MARK


@pytest.mark.skipif(sys.platform != "linux", reason="processes are forked on Linux only")
@pytest.mark.parametrize(("how", "seen"), [("alone", "1 1"), ("beside a thread", "0 0")])
def test_processes_are_forked_with_what_is_loaded_unless_there_are_threads(tmp_path: Path, how: str, seen: str) -> None:
    command = [sys.executable, "-c", MARKED, str(tmp_path), how]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout.strip() == seen
