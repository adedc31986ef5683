"""Run a notebook's cells in a separate process with limits, and take its answers out as text.

A `Sandbox` keeps one process (`contained`), which forks for each notebook; it is started by path with `-I`, an empty
environment and nothing of qdot in it. Every notebook has pipes of its own to the grader: what it writes is read as its
own, and the process that forks is told nothing of it. If a notebook kills that process, it keeps what it had reported,
and the next one gets a new process.
"""

import contextlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, TypeGuard

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.json_form import as_json, from_json
from qdot.grader.sandbox.contained import confine
from qdot.grader.sandbox.own_folder import OwnFolder, own_folder

REFUSED = (
    "Windows can't contain students' code, and qdot runs none without: use the container "
    "(docs/container.md) or WSL, where the same command works; all else of qdot works here"
)


def check_system() -> None:
    """Raise QdotError where no notebook can be run."""
    if not hasattr(os, "fork"):
        raise QdotError(REFUSED)


CONTAINED = Path(__file__).with_name("contained")

LONGEST_REPORT = 4_100_000
"""Bytes that are read of a notebook's report; it stops itself a little earlier."""

MOST_LINES = 50_000
"""Lines that are read of it, beside one for each cell, which says that it is begun."""

BEGUN = 32
"""More bytes than such a line has."""


MOST_LINES_OF_A_CELL = 100_000_000
"""What is said to have happened on a line after that is taken for no report."""

LONGEST_ERROR = 500
"""Characters of what is told of an error."""

MOST_LOST = 20
"""Symbols of which is told that a number stood for them."""


@dataclass(frozen=True)
class Limits:
    """What a notebook may use: seconds of processor time, in all and per cell, and bytes of memory.

    On the clock it may take the same time to wait, and `BUSY` times its processor time: a machine may be so slow.
    """

    seconds: float = 180.0
    cell_seconds: float = 90.0
    memory: int = 3 << 30

    @property
    def in_words(self) -> str:
        """What a notebook may use."""
        return (
            f"{self.memory / 2**30:g} GB of memory, {self.seconds:g} s, {confine.DISK / 1e6:g} MB in at most "
            f"{confine.FILES} files, folders {confine.DEPTH} deep"
        )


@dataclass(frozen=True)
class Calls:
    """With what functions are called: the names of the joints and of all symbols, and the symbols' values (rad, m).

    There is a row of values for each call.
    """

    joints: tuple[str, ...]
    symbols: tuple[str, ...]
    points: tuple[tuple[float, ...], ...]


BUSY = 10
"""So many times as long as alone may a notebook take on a machine that has other work."""


@dataclass
class Run:
    """What came out of a notebook: answer texts, why an answer is none, errors by cell, and how it ended."""

    answers: dict[str, str] = field(default_factory=dict)
    failures: dict[str, str] = field(default_factory=dict)
    cell_errors: dict[int, str] = field(default_factory=dict)
    stopped_at: dict[int, int] = field(default_factory=dict)
    """The lines on which cells stopped, where that is known."""
    missed: dict[int, tuple[int, str]] = field(default_factory=dict)
    """By cell, the line of the first import that failed, and why; the cell went on behind it."""
    end: str = "done"
    limits: "Limits | None" = None
    begun: int | None = None
    """The last cell that was begun."""
    earlier: dict[str, list[str]] = field(default_factory=dict)
    """Every text that an answer had in the course of the notebook."""
    lost: dict[str, tuple[int, str]] = field(default_factory=dict)
    """Symbols for which a number stood where an answer was worked out: the cell that set it, and the number."""

    def note(self, cell: str = "it") -> str:
        """Return how the run ended, in words, in a `cell` of this name; nothing where it ended well."""
        where, limits = ("" if cell == "it" else f" in {cell}"), self.limits or Limits()
        said = {
            "overtime": f"the notebook used up its {limits.seconds:g} s{where}",
            "crashed": f"the notebook crashed Python{where}",
            "closed": f"the notebook ended its own process{where}",
            "killed": f"the notebook was stopped{where}: it took more than a notebook may ({limits.in_words})",
            "lost": f"the notebook killed the process that runs it{where}",
        }
        if self.end == "unbegun":
            return "the machine ended the process that was to run the notebook; nothing was run"
        return f"{said[self.end]}; cells after that one were not run" if self.end in said else ""


def _is_cell(number: object, cells: Sequence[str]) -> TypeGuard[int]:
    return isinstance(number, int) and not isinstance(number, bool) and 0 <= number < len(cells)


def _is_line(number: object) -> TypeGuard[int]:
    return isinstance(number, int) and not isinstance(number, bool) and 0 < number < MOST_LINES_OF_A_CELL


def _writable(text: str) -> str:
    """Return the text without what no file can hold (lone surrogates), each replaced by a question mark."""
    return text.encode("utf-8", "replace").decode("utf-8")


def _shown(said: object) -> str:
    """Return what a notebook says of an error as a line that can be shown: what controls a terminal is replaced."""
    line = (" " if ch.isspace() else ch for ch in str(said)[:LONGEST_ERROR])
    return "".join(ch if ch.isprintable() else "\N{REPLACEMENT CHARACTER}" for ch in line)


NEEDED, ONE_OF = {"seccomp", "limits", "privileges"}, {"namespaces", "landlock"}
"""Measures without which a strict sandbox runs nothing; `guarantees` tries what all of them are worth."""


@dataclass(frozen=True)
class _Message:
    """What the process that forks says: that it is ready, why it is not, what is used, or how a notebook ended.

    `lacking` says which measures can't be taken, and why. A notebook is ended by a `signal`, 0 for none; its `seconds`
    are of processor time, as those `used` so far, and its `memory` is in bytes.
    """

    ready: bool = False
    lacking: Mapping[str, str] = field(default_factory=dict)
    failed: str = ""
    used: float = 0.0
    signal: int = 0
    seconds: float = 0.0
    memory: float = 0.0


class _Lost(Exception):
    """The process that forks is gone."""


class _Unbegun(_Lost):
    """A notebook's own process was gone, or did not answer, before it had read anything of the notebook.

    The text is the reason, where it is known.
    """


class Sandbox:
    """A place to run notebooks, one after the other; close it, or use it in a `with` statement.

    `lacking` says which measures this machine does not allow, and why; a strict one refuses to run without those that
    it takes for the system to contain a notebook. Those named in `without` are not taken, for tests. A probe needs no
    libraries `loaded`, and little processor time in all; for one notebook they need not be `warm`. `unbegun` says why a
    notebook was not run, if that is known.
    """

    def __init__(
        self, limits: Limits | None = None, without: Iterable[str] = (), loaded: bool = True,
        processor_seconds: int | None = None, strict: bool = False, warm: bool = True,
    ) -> None:  # fmt: skip
        self.limits = limits or Limits()
        self.lacking: dict[str, str] = {}
        self.unbegun = ""
        self._left_running = False
        self._strict = strict
        self._config = {
            "memory": self.limits.memory, "seconds": processor_seconds or int(self.limits.seconds) + 1,
            "without": sorted(without), "loaded": loaded, "warm": warm,
        }  # fmt: skip
        self._process: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None
        self._folder: OwnFolder | None = None
        self._last: _Lines | None = None
        self._unheard = b""
        self._cost = (0.0, 0.0)

    def __enter__(self) -> "Sandbox":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the process and all that is in it."""
        self._unheard = b""
        self._forget_last()
        if self._control is not None:
            self._control.close()  # upon which it ends what runs, and itself
            self._control = None
        if self._process is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(1)
            self._process.kill()
            self._process.wait()
            self._process = None
        if self._folder is not None:
            self._folder.remove()
            self._folder = None

    def run(
        self, cells: Sequence[str], names: Sequence[str], calls: Mapping[str, Calls] | None = None,
        setup: str = "", modules: Mapping[str, str] | None = None,
    ) -> Run:  # fmt: skip
        """Run the cells in order and return the values of `names` as text; before them, `setup`, which is qdot's own.

        Cells may import `modules`, files of Python by name, which are in the notebook's folder. A value that is a
        function is called with symbols or at points: `calls` holds them, by what a name begins with (see `callables`).
        Raises QdotError where the notebook can't be contained as it should be.
        """
        request = {
            "cells": list(cells), "names": list(names), "cell_seconds": self.limits.cell_seconds,
            "asked": as_json(calls or {}),
            "setup": setup, "modules": dict(modules or {}),
        }  # fmt: skip
        run = Run(limits=self.limits)

        def take(line: dict[str, Any]) -> None:
            name, cell, missed, lost, at = (line.get(key) for key in ("name", "cell", "missed", "lost", "set"))
            if _is_cell(line.get("begun"), cells):
                run.begun = line["begun"]
            if isinstance(name, str) and name in names and isinstance(line.get("text"), str):
                run.answers[name] = _writable(line["text"])
                run.failures.pop(name, None)
                run.earlier.setdefault(name, []).append(run.answers[name])
            elif isinstance(name, str) and name in names:
                run.failures[name] = _shown(line.get("error"))
                run.answers.pop(name, None)
            elif _is_cell(cell, cells):
                run.cell_errors[cell] = _shown(line.get("error"))
                if _is_line(line.get("line")):
                    run.stopped_at[cell] = line["line"]
            elif _is_cell(missed, cells) and _is_line(line.get("line")):
                run.missed.setdefault(missed, (line["line"], _shown(line.get("error"))))
            elif isinstance(lost, str) and _is_cell(at, cells) and len(run.lost) < MOST_LOST:
                run.lost[_shown(lost)[:40]] = at, _shown(line.get("value"))[:40]

        run.end = self.exchange(request, take)
        return run

    def exchange(self, request: dict[str, Any], take: Callable[[dict[str, Any]], None]) -> str:
        """Have a child do what is requested, pass each line of its report to `take`, and return how it ended.

        "lost": the process that forks was ended, as a notebook could do it; "unbegun": nothing was run, which is no
        notebook's doing.
        """
        self._tidied_up()
        self._start()
        assert self._control is not None
        try:
            receipts, report = self._pipes()
            lines = self._last = _Lines(
                report, self.limits.seconds, self._processor_time, len(request.get("cells", ()))
            )
            try:
                end = _converse(request, lines, receipts, take)
            finally:
                os.close(receipts)
            self._control.sendall(b"c" if end == "closed" else b"s")
            if end == "done":  # what it leaves is tidied up while its answers are marked
                return end
            died_of = self._end_of_last()
        except (_Lost, OSError) as error:
            self.close()
            self.unbegun = str(error) if isinstance(error, _Unbegun) else ""
            return "unbegun" if isinstance(error, _Unbegun) else "lost"
        except BaseException:
            self.close()
            raise
        if died_of and end in ("closed", "overtime"):  # others of its processes may hold the pipe open
            end = "killed" if died_of == signal.SIGKILL else "crashed"
        return end

    def cost(self) -> tuple[float, float]:
        """Return seconds of processor time of all notebooks since this was asked last, and the most bytes of one."""
        self._tidied_up()
        cost, self._cost = self._cost, (0.0, 0.0)
        return cost

    @property
    def left_running(self) -> bool:
        """Whether anything of the last notebook went on after its end."""
        self._tidied_up()
        return self._left_running

    @property
    def left_behind(self) -> bool:
        """Whether anything of the notebooks before lies in the sandbox's folder; the next one's folder may."""
        self._tidied_up()
        return self._folder is not None and len(list(Path(self._folder.path).iterdir())) > 1

    def _tidied_up(self) -> None:
        """Wait until nothing is left of the last notebook; a process that is lost over it is started anew."""
        if self._last is not None:
            try:
                self._end_of_last()
            except (_Lost, OSError):
                self.close()

    def _end_of_last(self) -> int:
        """Return the signal that ended the last notebook before it was to end, 0 for none. Raises _Lost."""
        assert self._last is not None
        heard = self._heard()
        self._cost = self._cost[0] + heard.seconds, max(self._cost[1], heard.memory)
        self._left_running = not self._last.are_at_an_end(within=1.0)
        self._forget_last()
        return heard.signal

    def _forget_last(self) -> None:
        last, self._last = self._last, None
        if last is not None:
            last.close()

    def _pipes(self) -> list[int]:
        """Return the two pipes of the child that is ready: into it, and out of it. Raises _Unbegun."""
        assert self._control is not None
        try:
            self._control.sendall(b"r")
            _, pipes, *_ = socket.recv_fds(self._control, 1, 2)
        except OSError:  # also where it takes too long
            raise _Unbegun from None
        for descriptor in pipes:
            os.set_inheritable(descriptor, False)
        if len(pipes) != 2:
            for descriptor in pipes:
                os.close(descriptor)
            raise _Unbegun
        return pipes

    def _processor_time(self) -> float:
        """Return the seconds of processor time that the notebook which runs has used. Raises _Lost."""
        assert self._control is not None
        self._control.sendall(b"t")
        return self._heard().used

    def _heard(self) -> _Message:
        """Return what the process that forks says next; it is none of a notebook's words. Raises _Lost.

        It may have said more by then: that it failed to make the process for the next notebook.
        """
        assert self._control is not None
        while b"\n" not in self._unheard:
            more = self._control.recv(1 << 16)  # times out with OSError
            if not more:
                raise _Lost
            self._unheard += more
        line, _, self._unheard = self._unheard.partition(b"\n")
        return from_json(_Message, line)

    def _start(self) -> None:
        """Start the process, if there is none. Raises QdotError where it can't be."""
        if self._process is not None and self._process.poll() is None:
            return
        self.close()
        check_system()
        self._folder = own_folder("qdot-sandbox-")
        keep = {name: os.environ[name] for name in ("PATH", "SYSTEMROOT", "LD_LIBRARY_PATH") if name in os.environ}
        environment = {
            **keep, "HOME": tempfile.gettempdir(), "LANG": "C.UTF-8", "MPLBACKEND": "Agg", "PYTHONHASHSEED": "0",
            "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1",
        }  # fmt: skip
        config = {**self._config, "folder": self._folder.path}
        self._control, other = socket.socketpair()
        with other:
            self._process = subprocess.Popen(
                [sys.executable, "-I", str(CONTAINED), json.dumps(config)], stdin=other.fileno(),
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment, cwd=tempfile.gettempdir(),
                start_new_session=True,
            )  # fmt: skip
        self._control.settimeout(60)
        try:
            heard = self._heard()
        except (_Lost, OSError):
            heard = _Message()
        if not heard.ready:
            self.close()
            raise QdotError(
                "the process in which notebooks run does not start"
                + (f": {heard.failed}" if heard.failed else "; is there enough memory?")
            )
        self.lacking = dict(heard.lacking)
        if self._strict and (self.lacking.keys() & NEEDED or self.lacking.keys() >= ONE_OF):
            self.close()
            raise QdotError(f"the process in which notebooks run is not contained: {self.lacking}; see `qdot doctor`")


class _Lines:
    """Lines of JSON from a pipe into which anybody may have written anything, up to a moment and a size.

    The moment comes when so many `seconds` of processor time are `used`, or were waited beside the time that the
    processor time may have taken on a busy machine. The size is larger for more cells.
    """

    def __init__(self, descriptor: int, seconds: float, used: Callable[[], float], cells: int) -> None:
        self._descriptor, self._seconds, self._used = descriptor, seconds, used
        self._most_lines, self._most_bytes = MOST_LINES + cells, LONGEST_REPORT + BEGUN * cells
        self._began = time.monotonic()
        self._deadline = self._began + seconds
        self._lines: deque[bytes] = deque()
        self._buffer, self._bytes, self._count = b"", 0, 0

    def close(self) -> None:
        os.close(self._descriptor)

    def next(self) -> dict[str, Any] | str:
        """Return the next line, empty where it is none of ours; "overtime" or "closed" where there is no more."""
        while not self._lines:
            left = max(0.0, self._deadline - time.monotonic())
            if not select.select([self._descriptor], [], [], left)[0]:
                if self._is_over():
                    return "overtime"
                continue
            data = os.read(self._descriptor, 1 << 16)
            *lines, self._buffer = (self._buffer + data).split(b"\n")
            self._lines.extend(lines)
            self._bytes, self._count = self._bytes + len(data), self._count + len(lines)
            if not data or self._bytes > self._most_bytes or self._count > self._most_lines:
                return "closed"
        try:
            content = json.loads(self._lines.popleft())
        except (ValueError, RecursionError):
            content = {}
        return content if isinstance(content, dict) else {}

    def _is_over(self) -> bool:
        """Tell whether the moment has come; if not, it is looked again as soon as it can have."""
        used, now = self._used(), time.monotonic()
        left = min(self._seconds - used, self._began + self._seconds + BUSY * used - now)
        self._deadline = now + max(left, 0.02)
        return left <= 0

    def are_at_an_end(self, within: float) -> bool:
        """Tell whether everybody who could write into the pipe is gone, or goes within so many seconds."""
        deadline = time.monotonic() + within
        while select.select([self._descriptor], [], [], max(0.0, deadline - time.monotonic()))[0]:
            if not os.read(self._descriptor, 1 << 16):
                return True
            if time.monotonic() >= deadline:
                break
        return False


def _converse(request: dict[str, Any], lines: _Lines, receipts: int, take: Callable[[dict[str, Any]], None]) -> str:
    """Give a child its request once it is contained, and take its report; return how that ended.

    Raises _Unbegun where the child dies before it has read it, which is no notebook's doing, and QdotError where it is
    not contained as it was when the process started; it has been told nothing then.
    """
    first = lines.next()
    if isinstance(first, str):
        raise _Unbegun
    if "failed" in first:
        raise _Unbegun(str(first["failed"])[:300])
    if not first.get("confined"):
        raise QdotError(f"a notebook could not be contained, and was not run: {first.get('unprotected')}")
    _write_all(receipts, (json.dumps(request) + "\n").encode())
    if isinstance(lines.next(), str):  # it says that it begins
        raise _Unbegun
    os.set_blocking(receipts, False)
    while not isinstance(line := lines.next(), str):
        if line.get("done") is True:
            return "done"
        take(line)
        with contextlib.suppress(OSError):  # it may have gone, or take no more receipts
            os.write(receipts, b".")
    return line


def _write_all(descriptor: int, data: bytes) -> None:
    with contextlib.suppress(BrokenPipeError):  # it has died; that is seen where it would report
        while data:
            data = data[os.write(descriptor, data) :]
