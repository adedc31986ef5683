"""Run a notebook's cells in a separate process with limits, and return the notebook's answers as text.

A `Sandbox` has one forking process (`notebook_process.forking_process`), which forks for each notebook; the cells are
executed in `notebook_process.session`. The forking process starts with an almost empty environment and without any
module of qdot. Every notebook has two pipes to the grader: one for its report, and one for the request and for receipts
of reported lines. The forking process does not see what is in the pipes. If a notebook kills the forking process, the
notebook's report so far remains valid, and the next notebook gets a new forking process.
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
from typing import Any, NamedTuple

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.json_form import to_jsonable
from qdot.exercises.common.notebook_limits import CELL_SECONDS, MEMORY_GIGABYTES, NOTEBOOK_SECONDS
from qdot.grader.sandbox.notebook_process import isolation
from qdot.grader.sandbox.temporary_folder import TemporaryFolder, make_temporary_folder

WINDOWS_MESSAGE = (
    "qdot can't sandbox student code on Windows, so it does not run any. Use the container (docs/container.md) or WSL, "
    "where the same command works. Everything else in qdot works on Windows"
)


def check_system() -> None:
    """Raise QdotError if this system can't run notebooks."""
    if not hasattr(os, "fork"):
        raise QdotError(WINDOWS_MESSAGE)


MAX_READ_BYTES = isolation.MAX_REPORT_BYTES + 100_000
"""Maximum number of bytes that are read from a notebook's report, with room for the line that exceeds the limit."""

MAX_REPORT_LINES = 50_000
"""Maximum number of lines that are read from a report, in addition to one line for the beginning of each cell."""

CELL_START_BYTES = 32
"""Upper bound for the number of bytes of the line that reports the beginning of a cell."""

MAX_LINE_NUMBER = 100_000_000
"""Reports about larger line numbers are ignored."""

MAX_ERROR_LENGTH = 500
"""Maximum length of an error message in characters."""

FORKING_PROCESS_TIMEOUT = 60.0
"""Maximum number of seconds that the forking process may take to load the libraries, or to answer."""


@dataclass(frozen=True)
class Limits:
    """The limits of a notebook: seconds of processor time, in total and per cell, and bytes of memory.

    In real time, a notebook may take these seconds plus `MAX_SLOWDOWN` times the processor time that it has used.
    """

    seconds: float = NOTEBOOK_SECONDS
    cell_seconds: float = CELL_SECONDS
    memory: int = MEMORY_GIGABYTES << 30


@dataclass(frozen=True)
class FunctionArguments:
    """The arguments for answers that are functions: the names of the joint variables, and those of all symbols.

    `points` has one row for each call: a value for each of the `symbols`, in rad and m.
    """

    joints: tuple[str, ...]
    symbols: tuple[str, ...]
    points: tuple[tuple[float, ...], ...]


class FailedImport(NamedTuple):
    """An import that failed: its line in the cell, and the error message."""

    line: int
    error: str


class Replacement(NamedTuple):
    """The number, as text, that replaced a symbol as the value of a variable, and the cell that set it."""

    cell_index: int
    number: str


@dataclass
class Run:
    """The result of running a notebook; `end` is how the run ended, as in `Sandbox.exchange`.

    Dicts about answers have the names of variables as keys; dicts about cells have the cells' indices in the notebook.
    """

    answers: dict[str, str] = field(default_factory=dict)
    """The text of each answer."""
    unreadable_reasons: dict[str, str] = field(default_factory=dict)
    """For each answer without a text, the reason."""
    cell_errors: dict[int, str] = field(default_factory=dict)
    """For each cell that stopped, the error."""
    stop_lines: dict[int, int] = field(default_factory=dict)
    """The lines on which cells stopped, if known."""
    failed_imports: dict[int, FailedImport] = field(default_factory=dict)
    """For each cell, the first import that failed; the cell continued after that import."""
    end: str = "done"
    limits: Limits = Limits()
    last_begun_cell: int | None = None
    """The last cell that began."""
    earlier_values: dict[str, list[str]] = field(default_factory=dict)
    """All texts that an answer had during the run, in order."""
    replaced_symbols: dict[str, Replacement] = field(default_factory=dict)
    """For each variable whose symbol a number replaced, the replacement, if an answer then lacks the symbol."""

    def describe_end(self, cell_name: str = "") -> str:
        """Return a sentence on how the run ended, with the name of the last cell; empty if the run ended normally."""
        location = f" in {cell_name}" if cell_name else ""
        limits_text = (
            f"{self.limits.memory / 2**30:g} GB of memory, {self.limits.seconds:g} s, "
            f"{isolation.MAX_DISK_BYTES / 1e6:g} MB in at most {isolation.MAX_FILES} files, "
            f"folders nested {isolation.MAX_DEPTH} deep"
        )
        descriptions = {
            "overtime": f"the notebook used up its {self.limits.seconds:g} s{location}",
            "crashed": f"the notebook crashed Python{location}",
            "closed": f"the notebook ended its own process{location}",
            "killed": f"the notebook was stopped{location} because it exceeded a limit ({limits_text})",
            "lost": f"the notebook killed the process that runs it{location}",
        }
        if self.end == "not-started":
            return "this machine ended the process for the notebook before any cell was run"
        return f"{descriptions[self.end]}; later cells were not run" if self.end in descriptions else ""


def _is_cell_index(number: Any, cells: Sequence[str | None]) -> bool:
    return type(number) is int and 0 <= number < len(cells)


def _is_line_number(number: Any) -> bool:
    return type(number) is int and 0 < number < MAX_LINE_NUMBER


def _make_printable(message: object) -> str:
    """Return the beginning of a notebook's error message as one line without control characters."""
    line = (" " if character.isspace() else character for character in str(message)[:MAX_ERROR_LENGTH])
    return "".join(character if character.isprintable() else "\N{REPLACEMENT CHARACTER}" for character in line)


STRICT_REQUIRED_MEASURES, STRICT_ALTERNATIVE_MEASURES = {"seccomp", "limits", "privileges"}, {"namespaces", "landlock"}
"""A strict sandbox runs nothing unless all required measures and one of the alternatives are available."""


class Cost(NamedTuple):
    """The processor time of notebooks in seconds, and their peak memory in bytes."""

    seconds: float
    memory: float


class _ForkingProcessEnded(Exception):
    """Raised if the forking process has ended; the text is the reason, if known."""


class _NotebookNotStarted(_ForkingProcessEnded):
    """Raised, with the reason if known, if a notebook's process ended or hung before it had read the notebook."""


class Sandbox:
    """Runs notebooks one after the other in isolation; close the sandbox, or use it in a `with` statement.

    A `strict` sandbox refuses to run without the measures by which the kernel isolates a notebook. Tests can leave out
    `disabled_measures`. `processor_seconds` is the limit that the kernel enforces, by default a second more than that
    of `limits`. With `load_libraries`, SymPy and NumPy are loaded before the fork; a probe does not need them. With
    `warm_up`, typical operations fill SymPy's caches before the fork; this is of no use for a single notebook.

    `unavailable_measures` maps each measure that this machine does not allow to the reason. `not_started_reason` says
    why the last notebook was not run, if known.
    """

    def __init__(
        self, limits: Limits | None = None, disabled_measures: Iterable[str] = (), load_libraries: bool = True,
        processor_seconds: int | None = None, strict: bool = False, warm_up: bool = True,
    ) -> None:  # fmt: skip
        self.limits = limits or Limits()
        self.unavailable_measures: dict[str, str] = {}
        self.not_started_reason = ""
        self._has_left_processes = False
        self._strict = strict
        self._config = {
            "memory": self.limits.memory, "seconds": processor_seconds or int(self.limits.seconds) + 1,
            "disabled_measures": sorted(disabled_measures), "load_libraries": load_libraries, "warm_up": warm_up,
        }  # fmt: skip
        self._process: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None
        self._folder: TemporaryFolder | None = None
        self._last_report: _ReportLines | None = None
        self._unread_messages = b""
        self._cost = Cost(seconds=0.0, memory=0.0)

    def __enter__(self) -> "Sandbox":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the forking process and everything that it started."""
        self._unread_messages = b""
        self._close_last_report()
        if self._control is not None:
            self._control.close()  # the forking process then ends everything that is running, and itself
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
        self, cells: Sequence[str | None], names: Sequence[str],
        arguments: Mapping[str, FunctionArguments] | None = None, setup: str = "",
        modules: Mapping[str, str] | None = None,
    ) -> Run:  # fmt: skip
        """Run qdot's own code `setup`, then the cells that are not None; return the values of `names` as text.

        `modules` maps the names of Python files, which cells may import, to their texts. An answer that is a function
        is called with the `arguments` for the slot with which the variable's name begins, as in `p1_position`.
        Raises QdotError if the notebook can't be isolated as it should be.
        """
        request = {
            "cells": list(cells), "names": list(names), "cell_seconds": self.limits.cell_seconds,
            "arguments": to_jsonable(arguments or {}), "setup": setup, "modules": dict(modules or {}),
        }  # fmt: skip
        run = Run(limits=self.limits)

        def record_line(line: dict[str, Any]) -> None:
            match line:
                case {"begun": index} if _is_cell_index(index, cells):
                    run.last_begun_cell = index
                case {"name": str(name), "text": str(text)} if name in names:
                    # Lone surrogates can't be written to a file, so question marks replace them.
                    run.answers[name] = text.encode("utf-8", "replace").decode("utf-8")
                    run.unreadable_reasons.pop(name, None)
                    run.earlier_values.setdefault(name, []).append(run.answers[name])
                case {"name": str(name)} if name in names:
                    run.unreadable_reasons[name] = _make_printable(line.get("error"))
                    run.answers.pop(name, None)
                case {"cell": index} if _is_cell_index(index, cells):
                    run.cell_errors[index] = _make_printable(line.get("error"))
                    if _is_line_number(line.get("line")):
                        run.stop_lines[index] = line["line"]
                case {"import": index, "line": number} if _is_cell_index(index, cells) and _is_line_number(number):
                    run.failed_imports.setdefault(index, FailedImport(number, _make_printable(line.get("error"))))
                case {"replaced": str(symbol), "set": index} if _is_cell_index(index, cells):
                    # More than 40 characters would make a note unreadable.
                    name, number = (_make_printable(text)[:40] for text in (symbol, line.get("value")))
                    if len(run.replaced_symbols) < isolation.MAX_REPLACED_SYMBOLS:
                        run.replaced_symbols[name] = Replacement(index, number)

        run.end = self.exchange(request, record_line)
        return run

    def exchange(self, request: dict[str, Any], handle_line: Callable[[dict[str, Any]], None]) -> str:
        """Send a request to a child process, call `handle_line` with each line of its report, and return how it ended.

        - "done": the child has done everything
        - "closed": the child closed its pipe or reported too much
        - "overtime": the time was up
        - "killed": the kernel killed the child because it exceeded a limit
        - "crashed": another signal ended the child
        - "lost": the forking process has ended, possibly because the notebook killed it
        - "not-started": nothing was run, and the notebook is not the cause
        """
        self._finish_last_notebook()
        self._start_if_needed()
        assert self._control is not None
        try:
            request_writer, report_reader = self._receive_pipes()
            cell_count = len(request.get("cells", ()))
            lines = _ReportLines(report_reader, self.limits.seconds, self._query_processor_time, cell_count)
            self._last_report = lines
            try:
                end = _exchange_with_child(request, lines, request_writer, handle_line)
            finally:
                os.close(request_writer)
            self._control.sendall(b"c" if end == "closed" else b"s")  # the requests are listed in `forking_process`
            if end == "done":  # the forking process cleans up while the grader marks the answers
                return end
            ending_signal = self._await_notebook_end()
        except (_ForkingProcessEnded, OSError) as error:
            self.close()
            self.not_started_reason = str(error) if isinstance(error, _NotebookNotStarted) else ""
            return "not-started" if isinstance(error, _NotebookNotStarted) else "lost"
        except BaseException:
            self.close()
            raise
        # A signal says more than the pipe, which the child's own children may have kept open.
        if ending_signal and end in ("closed", "overtime"):
            end = "killed" if ending_signal == signal.SIGKILL else "crashed"
        return end

    def collect_cost(self) -> Cost:
        """Return the processor time of all notebooks since the last call, and the largest memory of any."""
        self._finish_last_notebook()
        cost, self._cost = self._cost, Cost(seconds=0.0, memory=0.0)
        return cost

    @property
    def has_left_processes(self) -> bool:
        """Whether any process of the last notebook continued to run after the notebook's end."""
        self._finish_last_notebook()
        return self._has_left_processes

    @property
    def has_left_files(self) -> bool:
        """Whether earlier notebooks left files in the sandbox's folder, apart from the next notebook's folder."""
        self._finish_last_notebook()
        return self._folder is not None and len(list(Path(self._folder.path).iterdir())) > 1

    def _finish_last_notebook(self) -> None:
        """Wait for the end of the last notebook. If the forking process has ended, close the sandbox, to restart it."""
        if self._last_report is not None:
            try:
                self._await_notebook_end()
            except (_ForkingProcessEnded, OSError):
                self.close()

    def _await_notebook_end(self) -> int:
        """Return the signal that ended the last notebook prematurely; 0 if none did. Raises _ForkingProcessEnded."""
        assert self._last_report is not None
        message = self._receive_message()
        self._cost = Cost(self._cost.seconds + message["seconds"], max(self._cost.memory, message["memory"]))
        self._has_left_processes = not self._last_report.ends_within(seconds=1.0)
        self._close_last_report()
        return int(message["signal"])

    def _close_last_report(self) -> None:
        lines, self._last_report = self._last_report, None
        if lines is not None:
            lines.close()

    def _receive_pipes(self) -> list[int]:
        """Return the descriptors of the pipes into the waiting child and out of it. Raises _NotebookNotStarted."""
        assert self._control is not None
        try:
            self._control.sendall(b"r")
            _, pipes, *_ = socket.recv_fds(self._control, 1, 2)
        except OSError:  # also raised if the answer takes too long
            raise _NotebookNotStarted from None
        for descriptor in pipes:
            os.set_inheritable(descriptor, False)
        if len(pipes) != 2:
            for descriptor in pipes:
                os.close(descriptor)
            raise _NotebookNotStarted
        return pipes

    def _query_processor_time(self) -> float:
        """Return the processor time of the running notebook in seconds. Raises _ForkingProcessEnded."""
        assert self._control is not None
        self._control.sendall(b"t")
        return float(self._receive_message()["used"])

    def _receive_message(self) -> dict[str, Any]:
        """Return the next message of the forking process, as `forking_process` describes it; no notebook can write one.

        Raises _ForkingProcessEnded.
        """
        assert self._control is not None
        while b"\n" not in self._unread_messages:
            data = self._control.recv(1 << 16)  # times out with OSError
            if not data:
                raise _ForkingProcessEnded
            self._unread_messages += data
        line, _, self._unread_messages = self._unread_messages.partition(b"\n")
        message: dict[str, Any] = json.loads(line)
        if "failed" in message:
            raise _ForkingProcessEnded(message["failed"])
        return message

    def _start_if_needed(self) -> None:
        """Start the forking process if none is running. Raises QdotError if it does not start."""
        if self._process is not None and self._process.poll() is None:
            return
        self.close()
        check_system()
        self._folder = make_temporary_folder("qdot-sandbox-")
        inherited_names = os.environ.keys() & {"PATH", "SYSTEMROOT", "LD_LIBRARY_PATH"}
        environment = {
            **{name: os.environ[name] for name in inherited_names}, "HOME": tempfile.gettempdir(),
            "LANG": "C.UTF-8", "MPLBACKEND": "Agg", "PYTHONHASHSEED": "0", "OPENBLAS_NUM_THREADS": "1",
            "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1",
        }  # fmt: skip
        config = json.dumps({**self._config, "folder": self._folder.path})
        program_folder = str(Path(isolation.__file__).parent)
        self._control, child_end = socket.socketpair()
        with child_end:
            self._process = subprocess.Popen(
                [sys.executable, "-I", program_folder, config], stdin=child_end.fileno(), stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL, env=environment, cwd=tempfile.gettempdir(), start_new_session=True,
            )  # fmt: skip
        self._control.settimeout(FORKING_PROCESS_TIMEOUT)
        try:
            self.unavailable_measures = self._receive_message()["unavailable"]
        except (_ForkingProcessEnded, OSError) as error:
            self.close()
            failure = str(error) if isinstance(error, _ForkingProcessEnded) else ""
            reason = f": {failure}" if failure else "; check whether there is enough free memory"
            raise QdotError(f"the sandbox process did not start{reason}") from None
        missing_measures = self.unavailable_measures.keys()
        is_weak = missing_measures & STRICT_REQUIRED_MEASURES or missing_measures >= STRICT_ALTERNATIVE_MEASURES
        if self._strict and is_weak:
            self.close()
            raise QdotError(f"notebooks can't be isolated strictly: {self.unavailable_measures}; see `qdot doctor`")


class _ReportLines:
    """Reads lines of JSON from an untrusted pipe, with limits of time and size.

    `get_processor_time` returns the notebook's processor time so far, in seconds. The time is up if the processor time
    exceeds `seconds`, or if the real time exceeds `seconds` plus `MAX_SLOWDOWN` times the processor time. The limit on
    the size grows with the number of cells.
    """

    def __init__(
        self, descriptor: int, seconds: float, get_processor_time: Callable[[], float], cell_count: int
    ) -> None:
        self._descriptor, self._seconds, self._get_processor_time = descriptor, seconds, get_processor_time
        self._max_lines = MAX_REPORT_LINES + cell_count
        self._max_bytes = MAX_READ_BYTES + CELL_START_BYTES * cell_count
        self._start_time = time.monotonic()
        self._deadline = self._start_time + seconds
        self._lines: deque[bytes] = deque()
        self._buffer, self._byte_count, self._line_count = b"", 0, 0

    def close(self) -> None:
        os.close(self._descriptor)

    def read_next(self) -> dict[str, Any] | str:
        """Return the content of the next line, {} if it is invalid; "overtime" or "closed" if there is no next line."""
        while not self._lines:
            timeout = max(0.0, self._deadline - time.monotonic())
            if not select.select([self._descriptor], [], [], timeout)[0]:
                if self._is_time_up():
                    return "overtime"
                continue
            data = os.read(self._descriptor, 1 << 16)
            *lines, self._buffer = (self._buffer + data).split(b"\n")
            self._lines.extend(lines)
            self._byte_count, self._line_count = self._byte_count + len(data), self._line_count + len(lines)
            if not data or self._byte_count > self._max_bytes or self._line_count > self._max_lines:
                return "closed"
        try:
            content = json.loads(self._lines.popleft())
        except (ValueError, RecursionError):
            content = {}
        return content if isinstance(content, dict) else {}

    def _is_time_up(self) -> bool:
        """Return whether the time is up; if not, set the deadline to the next moment at which it may be up."""
        used_seconds, now = self._get_processor_time(), time.monotonic()
        end_time = self._start_time + self._seconds + isolation.MAX_SLOWDOWN * used_seconds
        remaining = min(self._seconds - used_seconds, end_time - now)
        self._deadline = now + max(remaining, 0.02)  # the forking process is asked at most 50 times a second
        return remaining <= 0

    def ends_within(self, seconds: float) -> bool:
        """Return whether all processes that write into the pipe have ended, or end within `seconds`."""
        deadline = time.monotonic() + seconds
        while select.select([self._descriptor], [], [], max(0.0, deadline - time.monotonic()))[0]:
            if not os.read(self._descriptor, 1 << 16):
                return True
            if time.monotonic() >= deadline:
                break
        return False


def _exchange_with_child(
    request: dict[str, Any], lines: _ReportLines, request_writer: int, handle_line: Callable[[dict[str, Any]], None]
) -> str:
    """Send a child its request as soon as the child is isolated, and return how its report ended.

    `lines` has the child's report, and `request_writer` is the descriptor of the pipe into the child, which also takes
    a receipt for each line. Raises _NotebookNotStarted if the child dies before it reads the request; no notebook can
    cause that. Raises QdotError, and sends no request, if a measure fails that worked when the forking process started.
    """
    greeting = lines.read_next()
    if isinstance(greeting, str):
        raise _NotebookNotStarted
    if "failed" in greeting:
        raise _NotebookNotStarted(str(greeting["failed"])[:300])
    if not greeting.get("isolated"):
        raise QdotError(f"a notebook was not run because it could not be isolated: {greeting.get('unprotected')}")
    # If the child has died, the end of its report shows that.
    with contextlib.suppress(BrokenPipeError), open(request_writer, "wb", closefd=False) as pipe:
        pipe.write((json.dumps(request) + "\n").encode())
    if isinstance(lines.read_next(), str):  # the next line reports that the notebook begins
        raise _NotebookNotStarted
    os.set_blocking(request_writer, False)
    while not isinstance(line := lines.read_next(), str):
        if line.get("done") is True:
            return "done"
        handle_line(line)
        with contextlib.suppress(OSError):  # the child may have ended, or may no longer read receipts
            os.write(request_writer, b".")
    return line
