"""Measure the processor time of a command and its child processes on Linux. It depends little on the load."""

import ctypes
import os
import resource
import statistics
import subprocess
import sys
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

_ADOPT = 36
"""PR_SET_CHILD_SUBREAPER: processes that outlive their parent become our children, so that their time counts."""


@cache
def _adopting() -> None:
    if sys.platform != "linux" or ctypes.CDLL(None).prctl(_ADOPT, 1, 0, 0, 0) != 0:
        raise SystemExit("processor time of all processes is told on Linux only")


def processor_time(command: Sequence[str], folder: Path | None = None, paths: str = "") -> float:
    """Return the seconds of a command that has to succeed; `paths` is PYTHONPATH, and bytecode is kept as usual."""
    _adopting()
    there = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    there["PATH"] = f"{Path(command[0]).parent}{os.pathsep}{there['PATH']}"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with_paths = {**there, "PYTHONPATH": paths} if paths else there
    done = subprocess.run(command, cwd=folder, env=with_paths, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    if done.returncode:
        raise SystemExit(f"{' '.join(command)}: {done.stderr[-2000:]}")
    while True:
        try:
            os.wait()
        except ChildProcessError:
            break
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def middle(measure: Callable[[], float], times: int = 3) -> float:
    """Return the median of several measurements, after one that counts nothing: it fills what is kept on disk."""
    measure()
    return statistics.median(measure() for _ in range(times))
