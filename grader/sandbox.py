"""Run a notebook's cells in a separate process with limits, and take its answers out as text.

A `Sandbox` keeps one `grader.runner` process, which forks for each notebook; it is started by path with `-I`, an empty
environment and nothing of qdot in it. If a notebook kills it, that notebook keeps what it had reported, and the next
one gets a new process.
"""

import json
import os
import select
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any

RUNNER = Path(__file__).with_name("runner.py")


@dataclass(frozen=True)
class Limits:
    """What a notebook may use: seconds on the clock in all, seconds of processor time per cell, bytes of memory."""

    seconds: float = 120.0
    cell_seconds: float = 20.0
    memory: int = 3 << 30


@dataclass
class Run:
    """What came out of a notebook: answer texts, why an answer is none, errors by cell, and how it ended."""

    answers: dict[str, str] = field(default_factory=dict)
    failures: dict[str, str] = field(default_factory=dict)
    cell_errors: dict[int, str] = field(default_factory=dict)
    end: str = "done"
    earlier: dict[str, list[str]] = field(default_factory=dict)
    """Every text that an answer had in the course of the notebook."""

    @property
    def note(self) -> str:
        """How the run ended, in words; empty where it ended well."""
        said = {
            "overtime": "the notebook ran out of time; cells after that were not run",
            "crashed": "the notebook crashed Python; cells after that were not run",
            "closed": "the notebook ended its own process; cells after that were not run",
            "lost": "the notebook killed the process that runs it; cells after that were not run",
        }
        return said.get(self.end, "")


def _writable(text: str) -> str:
    """Return the text without what no file can hold (lone surrogates), each replaced by a question mark."""
    return text.encode("utf-8", "replace").decode("utf-8")


class Sandbox:
    """A place to run notebooks, one after the other; close it, or use it in a `with` statement."""

    def __init__(self, limits: Limits | None = None) -> None:
        self.limits = limits or Limits()
        self._process: subprocess.Popen[bytes] | None = None
        self._buffer = b""

    def __enter__(self) -> "Sandbox":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the runner."""
        if self._process is not None:
            self._process.kill()
            for stream in (self._process.stdin, self._process.stdout):
                if stream is not None:
                    stream.close()
            self._process.wait()
            self._process = None
        self._buffer = b""

    def run(
        self, cells: Sequence[str], names: Sequence[str], asked: Mapping[str, Mapping[str, Any]] | None = None
    ) -> Run:
        """Run the cells in order and return the values of `names` as text.

        A value that is a function is called with symbols or at points: `asked` holds them, by what a name begins with
        (see `callables`).
        """
        limits = self.limits
        request = {
            "cells": list(cells), "names": list(names), "seconds": limits.seconds,
            "cell_seconds": limits.cell_seconds, "memory": limits.memory, "asked": asked or {},
        }  # fmt: skip
        run = Run()
        try:
            process = self._started()
            assert process.stdin is not None
            process.stdin.write((json.dumps(request) + "\n").encode())
            process.stdin.flush()
            self._collect(run, names, time.monotonic() + limits.seconds + 10)
        except (BrokenPipeError, EOFError, TimeoutError):
            run.end = "lost"
            self.close()
        return run

    def _collect(self, run: Run, names: Sequence[str], deadline: float) -> None:
        while True:
            line = self._line(deadline)
            if "end" in line:
                run.end = str(line["end"])
                return
            name, cell = line.get("name"), line.get("cell")
            if name in names and isinstance(line.get("text"), str):
                run.answers[str(name)] = _writable(line["text"])
                run.failures.pop(str(name), None)
                run.earlier.setdefault(str(name), []).append(run.answers[str(name)])
            elif name in names:
                run.failures[str(name)] = _writable(str(line.get("error"))[:300])
                run.answers.pop(str(name), None)
            elif isinstance(cell, int) and not isinstance(cell, bool):
                run.cell_errors[cell] = _writable(str(line.get("error"))[:300])

    def _started(self) -> "subprocess.Popen[bytes]":
        if self._process is not None and self._process.poll() is None:
            return self._process
        self.close()
        keep = {name: os.environ[name] for name in ("PATH", "SYSTEMROOT", "LD_LIBRARY_PATH") if name in os.environ}
        environment = {
            **keep, "HOME": tempfile.gettempdir(), "LANG": "C.UTF-8", "MPLBACKEND": "Agg", "PYTHONHASHSEED": "0",
            "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1",
        }  # fmt: skip
        self._process = subprocess.Popen(
            [sys.executable, "-I", str(RUNNER)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL, env=environment, cwd=tempfile.gettempdir(), start_new_session=True,
        )  # fmt: skip
        if self._line(time.monotonic() + 60) != {"ready": True}:
            raise EOFError
        return self._process

    def _line(self, deadline: float) -> dict[str, Any]:
        assert self._process is not None
        assert self._process.stdout is not None
        descriptor = self._process.stdout.fileno()
        while b"\n" not in self._buffer:
            left = deadline - time.monotonic()
            if left <= 0 or not select.select([descriptor], [], [], left)[0]:
                raise TimeoutError
            data = os.read(descriptor, 1 << 16)
            if not data:
                raise EOFError
            self._buffer += data
        line, self._buffer = self._buffer.split(b"\n", 1)
        try:
            content = json.loads(line)
        except ValueError:
            raise EOFError from None
        return content if isinstance(content, dict) else {}
