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
    """Raise QdotError if this system can't run notebooks."""
    if not hasattr(os, "fork"):
        raise QdotError(REFUSED)


CONTAINED = Path(__file__).with_name("contained")

LONGEST_REPORT = 4_100_000
"""Maximum number of bytes that are read from a notebook's report; the notebook stops itself a little earlier."""

MOST_LINES = 50_000
"""Maximum number of lines that are read from it, in addition to one for each cell that begins."""

BEGUN = 32
"""Upper bound of the bytes of a line for a cell that begins."""


MOST_LINES_OF_A_CELL = 100_000_000
"""Reports about larger line numbers are ignored."""

LONGEST_ERROR = 500
"""Maximum length of an error message in characters."""

MOST_LOST = 20
"""Maximum number of symbols that are reported as replaced by numbers."""


@dataclass(frozen=True)
class Limits:
    """What a notebook may use: seconds of processor time, in total and per cell, and bytes of memory.

    In real time, it may wait for the same number of seconds in addition to `BUSY` times its processor time.
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
"""How many times slower a notebook may run on a busy machine."""


@dataclass
class Run:
    """The result of running a notebook: answers, why answers are unreadable, errors by cell, and how it ended."""

    answers: dict[str, str] = field(default_factory=dict)
    failures: dict[str, str] = field(default_factory=dict)
    cell_errors: dict[int, str] = field(default_factory=dict)
    stopped_at: dict[int, int] = field(default_factory=dict)
    """The lines on which cells stopped, if known."""
    missed: dict[int, tuple[int, str]] = field(default_factory=dict)
    """By cell, the line of the first import that failed, and why; the cell continued after it."""
    end: str = "done"
    limits: "Limits | None" = None
    begun: int | None = None
    """The last cell that began."""
    earlier: dict[str, list[str]] = field(default_factory=dict)
    """Every text that an answer had during the run."""
    lost: dict[str, tuple[int, str]] = field(default_factory=dict)
    """Symbols that numbers replaced in an answer: the cell that set the number, and the number."""

    def note(self, cell: str = "it") -> str:
        """Return in words how the run ended, in a `cell` of this name; "" if it ended well."""
        where, limits = ("" if cell == "it" else f" in {cell}"), self.limits or Limits()
        descriptions = {
            "overtime": f"the notebook used up its {limits.seconds:g} s{where}",
            "crashed": f"the notebook crashed Python{where}",
            "closed": f"the notebook ended its own process{where}",
            "killed": f"the notebook was stopped{where}: it took more than a notebook may ({limits.in_words})",
            "lost": f"the notebook killed the process that runs it{where}",
        }
        if self.end == "unbegun":
            return "the machine ended the process that was to run the notebook; nothing was run"
        return f"{descriptions[self.end]}; cells after that one were not run" if self.end in descriptions else ""


def _is_cell(number: object, cells: Sequence[str | None]) -> TypeGuard[int]:
    return type(number) is int and 0 <= number < len(cells)


def _is_line(number: object) -> TypeGuard[int]:
    return type(number) is int and 0 < number < MOST_LINES_OF_A_CELL


def _replace_surrogates(text: str) -> str:
    """Return the text with lone surrogates, which can't be written to a file, replaced by question marks."""
    return text.encode("utf-8", "replace").decode("utf-8")


def _printable_error(message: object) -> str:
    """Return a notebook's error message as one printable line, without control characters."""
    line = (" " if ch.isspace() else ch for ch in str(message)[:LONGEST_ERROR])
    return "".join(ch if ch.isprintable() else "\N{REPLACEMENT CHARACTER}" for ch in line)


NEEDED, ONE_OF = {"seccomp", "limits", "privileges"}, {"namespaces", "landlock"}
"""Measures without which a strict sandbox runs nothing; `guarantees` tests all measures."""


@dataclass(frozen=True)
class _Message:
    """A message of the forking process: that it is ready, or why not, what a notebook has used, or how it ended.

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
    """The forking process has ended."""


class _Unbegun(_Lost):
    """A notebook's process ended, or did not answer, before it had read anything of the notebook.

    The text is the reason, if known.
    """


class Sandbox:
    """Runs notebooks one after the other in isolation; close it, or use it in a `with` statement.

    `lacking` lists the measures that this machine does not allow, and why; a `strict` sandbox refuses to run without
    the measures by which the system itself isolates a notebook. Tests switch off the measures in `without`. A probe
    needs no `loaded` libraries and little processor time; for a single notebook, libraries need not be `warm`.
    `unbegun` is the reason why a notebook was not run, if known.
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

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the process and everything in it."""
        self._unheard = b""
        self._forget_last()
        if self._control is not None:
            self._control.close()  # the process then ends what runs, and itself
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
        self, cells: Sequence[str | None], names: Sequence[str], calls: Mapping[str, Calls] | None = None,
        setup: str = "", modules: Mapping[str, str] | None = None,
    ) -> Run:  # fmt: skip
        """Run qdot's own `setup`, then the cells that are not None in order; return the values of `names` as text.

        Cells may import `modules`, Python files by name, which are in the notebook's folder. A value that is a
        function is called with symbols or at points: `calls` holds them by prefix of the name (see `callables`).
        Raises QdotError if the notebook can't be isolated as it should be.
        """
        request = {
            "cells": list(cells), "names": list(names), "cell_seconds": self.limits.cell_seconds,
            "calls": as_json(calls or {}), "setup": setup, "modules": dict(modules or {}),
        }  # fmt: skip
        run = Run(limits=self.limits)

        def take(line: dict[str, Any]) -> None:
            match line:
                case {"begun": index} if _is_cell(index, cells):
                    run.begun = index
                case {"name": str(name), "text": str(text)} if name in names:
                    run.answers[name] = _replace_surrogates(text)
                    run.failures.pop(name, None)
                    run.earlier.setdefault(name, []).append(run.answers[name])
                case {"name": str(name)} if name in names:
                    run.failures[name] = _printable_error(line.get("error"))
                    run.answers.pop(name, None)
                case {"cell": index} if _is_cell(index, cells):
                    run.cell_errors[index] = _printable_error(line.get("error"))
                    if _is_line(line.get("line")):
                        run.stopped_at[index] = line["line"]
                case {"missed": index, "line": number} if _is_cell(index, cells) and _is_line(number):
                    run.missed.setdefault(index, (number, _printable_error(line.get("error"))))
                case {"lost": str(symbol), "set": index} if _is_cell(index, cells) and len(run.lost) < MOST_LOST:
                    run.lost[_printable_error(symbol)[:40]] = index, _printable_error(line.get("value"))[:40]

        run.end = self.exchange(request, take)
        return run

    def exchange(self, request: dict[str, Any], take: Callable[[dict[str, Any]], None]) -> str:
        """Have a child process a request, pass each line of its report to `take`, and return how it ended.

        "lost" means that the forking process was ended, possibly by the notebook; "unbegun" that nothing was run, for
        reasons outside of the notebook.
        """
        self._tidy_up()
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
            if end == "done":  # the process cleans up while the answers are marked
                return end
            died_of = self._end_of_last()
        except (_Lost, OSError) as error:
            self.close()
            self.unbegun = str(error) if isinstance(error, _Unbegun) else ""
            return "unbegun" if isinstance(error, _Unbegun) else "lost"
        except BaseException:
            self.close()
            raise
        if died_of and end in ("closed", "overtime"):  # its other processes may hold the pipe open
            end = "killed" if died_of == signal.SIGKILL else "crashed"
        return end

    def cost(self) -> tuple[float, float]:
        """Return the processor time of all notebooks since the last call, and the largest memory of one in bytes."""
        self._tidy_up()
        cost, self._cost = self._cost, (0.0, 0.0)
        return cost

    @property
    def left_running(self) -> bool:
        """Whether any process of the last notebook continued after its end."""
        self._tidy_up()
        return self._left_running

    @property
    def left_behind(self) -> bool:
        """Whether earlier notebooks left files in the sandbox's folder, apart from the next notebook's folder."""
        self._tidy_up()
        return self._folder is not None and len(list(Path(self._folder.path).iterdir())) > 1

    def _tidy_up(self) -> None:
        """Wait until nothing is left of the last notebook; if the forking process is lost, it is restarted later."""
        if self._last is not None:
            try:
                self._end_of_last()
            except (_Lost, OSError):
                self.close()

    def _end_of_last(self) -> int:
        """Return the signal that ended the last notebook prematurely, 0 for none. Raises _Lost."""
        assert self._last is not None
        message = self._receive()
        self._cost = self._cost[0] + message.seconds, max(self._cost[1], message.memory)
        self._left_running = not self._last.are_at_an_end(within=1.0)
        self._forget_last()
        return message.signal

    def _forget_last(self) -> None:
        last, self._last = self._last, None
        if last is not None:
            last.close()

    def _pipes(self) -> list[int]:
        """Return the two pipes of the waiting child: into it, and out of it. Raises _Unbegun."""
        assert self._control is not None
        try:
            self._control.sendall(b"r")
            _, pipes, *_ = socket.recv_fds(self._control, 1, 2)
        except OSError:  # also if it takes too long
            raise _Unbegun from None
        for descriptor in pipes:
            os.set_inheritable(descriptor, False)
        if len(pipes) != 2:
            for descriptor in pipes:
                os.close(descriptor)
            raise _Unbegun
        return pipes

    def _processor_time(self) -> float:
        """Return the processor time of the running notebook in seconds. Raises _Lost."""
        assert self._control is not None
        self._control.sendall(b"t")
        return self._receive().used

    def _receive(self) -> _Message:
        """Return the next message of the forking process, which no notebook can write. Raises _Lost.

        There may be more messages: that it failed to make the process for the next notebook.
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
        """Start the process if there is none. Raises QdotError if it does not start."""
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
        self._control, child_end = socket.socketpair()
        with child_end:
            self._process = subprocess.Popen(
                [sys.executable, "-I", str(CONTAINED), json.dumps(config)], stdin=child_end.fileno(),
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment, cwd=tempfile.gettempdir(),
                start_new_session=True,
            )  # fmt: skip
        self._control.settimeout(60)
        try:
            greeting = self._receive()
        except (_Lost, OSError):
            greeting = _Message()
        if not greeting.ready:
            self.close()
            raise QdotError(
                "the process in which notebooks run does not start"
                + (f": {greeting.failed}" if greeting.failed else "; is there enough memory?")
            )
        self.lacking = dict(greeting.lacking)
        if self._strict and (self.lacking.keys() & NEEDED or self.lacking.keys() >= ONE_OF):
            self.close()
            raise QdotError(f"the process in which notebooks run is not contained: {self.lacking}; see `qdot doctor`")


class _Lines:
    """Lines of JSON from an untrusted pipe, with limits of time and size.

    Time is up when `seconds` of processor time are `used`, or were spent waiting in addition to the time that the
    processor time may take on a busy machine. The size limit grows with the number of cells.
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
        """Return the next line, empty if it is invalid; "overtime" or "closed" if there are no more."""
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
        """Whether time is up; if not, set the next time at which it may be."""
        used, now = self._used(), time.monotonic()
        left = min(self._seconds - used, self._began + self._seconds + BUSY * used - now)
        self._deadline = now + max(left, 0.02)
        return left <= 0

    def are_at_an_end(self, within: float) -> bool:
        """Whether all writers of the pipe have ended, or end within this number of seconds."""
        deadline = time.monotonic() + within
        while select.select([self._descriptor], [], [], max(0.0, deadline - time.monotonic()))[0]:
            if not os.read(self._descriptor, 1 << 16):
                return True
            if time.monotonic() >= deadline:
                break
        return False


def _converse(request: dict[str, Any], lines: _Lines, receipts: int, take: Callable[[dict[str, Any]], None]) -> str:
    """Send a child its request once it is isolated, and read its report; return how that ended.

    Raises _Unbegun if the child dies before reading the request, which no notebook can cause, and QdotError if it is
    not isolated as it was when the process started; then it gets no request.
    """
    first = lines.next()
    if isinstance(first, str):
        raise _Unbegun
    if "failed" in first:
        raise _Unbegun(str(first["failed"])[:300])
    if not first.get("confined"):
        raise QdotError(f"a notebook could not be contained, and was not run: {first.get('unprotected')}")
    _write_all(receipts, (json.dumps(request) + "\n").encode())
    if isinstance(lines.next(), str):  # the message that it begins
        raise _Unbegun
    os.set_blocking(receipts, False)
    while not isinstance(line := lines.next(), str):
        if line.get("done") is True:
            return "done"
        take(line)
        with contextlib.suppress(OSError):  # it may have ended, or accept no more receipts
            os.write(receipts, b".")
    return line


def _write_all(descriptor: int, data: bytes) -> None:
    with contextlib.suppress(BrokenPipeError):  # if it has died, reading its report shows it
        while data:
            data = data[os.write(descriptor, data) :]
