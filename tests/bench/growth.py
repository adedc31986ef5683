"""How time and memory grow with the class: `python -m tests.bench.growth 100 1000 10000` (an hour; 30 and 100 without).

The assignment is Examples 6.1 and 6.2. Time is processor time for each student, on all cores together, which load
changes little, beside a floor measured in the same run: for generating, writing the bytes of a student's files once
more; for grading, the cells of the notebooks (tests/bench/floor). Memory is that of the largest process. All of it
should stay the same, whatever the size. Times and memory of the processes below the command are read from /proc.
"""

import contextlib
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

from exercises.assignment import Assignment, Student, load_assignment
from exercises.release import certificate_path, init_assignment, notebook_path
from exercises.store import kept, store_path
from grader.demo import answered

from .grading import floor, processor_time

SIZES = (30, 100)
MEASURED = 40
"""Notebooks whose cells are run for the floor."""
SLOT = """
[[problem]]
family = "planar-2r"
questions = ["position", "jacobian", "determinant", "inverse-velocity", "singular-angles"]
"""


def main() -> int:
    """Print a line for each size."""
    sizes = [int(size) for size in sys.argv[1:]] or list(SIZES)
    for size in sizes:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "class"
            init_assignment(
                folder, "Growth", "bench", [Student(f"s{n:05d}") for n in range(size)], "a secret, long enough"
            )
            file = folder / "assignment.toml"
            file.write_text(file.read_text("utf-8").split("\n[[problem]]")[0] + SLOT, encoding="utf-8")
            made = measured("generate", folder)
            row(size, "generate", made, writing(load_assignment(folder)))
            hand_in(folder)
            graded = measured("grade", folder)
            row(size, "grade", graded, cells(load_assignment(folder)))
    return 0


def row(size: int, verb: str, found: tuple[float, float, float], floor: float) -> None:
    """Print one line."""
    seconds, processor, memory = found
    times = f"{1000 * processor / size:7.0f} ms of a core each, {1000 * seconds / size:6.0f} ms on the clock"
    ratio = f"{processor / size / floor:7.1f} x floor ({1000 * floor:.1f} ms)"
    sys.stdout.write(f"{size:>6} students: {verb:<8} {times}, {ratio}, {memory:4.0f} MB\n")
    sys.stdout.flush()


def measured(verb: str, folder: Path) -> tuple[float, float, float]:
    """Return seconds on the clock and of processor time, and the megabytes of the largest process, of a command."""
    command = [sys.executable, "-m", "grader.cli", verb, str(folder)]
    start, processor, largest = time.perf_counter(), 0.0, 0.0
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while not os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT):
        processor = max(processor, processor_time(process.pid))
        largest = max(largest, largest_below(process.pid))
        time.sleep(0.1)
    _, status, usage = os.wait4(process.pid, 0)
    if os.waitstatus_to_exitcode(status):
        raise SystemExit(f"qdot {verb} failed")
    scale = 1 << 20 if sys.platform == "darwin" else 1 << 10
    processor = max(processor, usage.ru_utime + usage.ru_stime)
    return time.perf_counter() - start, processor, max(largest, usage.ru_maxrss / scale)


def largest_below(process: int) -> float:
    """Return the most megabytes that a process below one has had."""
    found = 0.0
    with contextlib.suppress(OSError):
        for child in Path(f"/proc/{process}/task/{process}/children").read_text().split():
            with contextlib.suppress(OSError):
                held = re.search(r"VmHWM:\s*(\d+) kB", Path(f"/proc/{child}/status").read_text())
                found = max(found, int(held[1]) / 1024 if held else 0.0, largest_below(int(child)))
    return found


def writing(assignment: Assignment) -> float:
    """Return the seconds of processor time in which a student's files are written once more, their bytes at hand."""
    ids = [student.id for student in assignment.roster]
    files = [notebook_path(assignment, one, kind) for one in ids for kind in ("released", "solutions")]
    files += [path(assignment, one) for one in ids for path in (certificate_path, store_path)]
    contents = [path.read_bytes() for path in files[:4000]]
    with tempfile.TemporaryDirectory() as name:
        start = time.process_time()
        for number, content in enumerate(contents):
            (Path(name) / str(number)).write_bytes(content)
        return 4 * (time.process_time() - start) / len(contents)


def cells(assignment: Assignment) -> float:
    """Return the median of the seconds of processor time of notebooks' own cells."""
    few = replace(assignment, roster=assignment.roster[:MEASURED])
    return statistics.median(processor for _, processor in floor(few, assignment.folder / "submitted"))


def hand_in(folder: Path) -> None:
    """Hand the solutions in."""
    assignment = load_assignment(folder)
    for student in assignment.roster:
        target = folder / "submitted" / f"{student.id}.ipynb"
        text = (folder / "released" / student.id / "bench.ipynb").read_text("utf-8")
        problems = kept(assignment, student.id).problems
        target.write_text(answered(text, problems, lambda code, _: code), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
