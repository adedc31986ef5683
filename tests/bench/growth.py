"""How time, memory and disk grow with the class: `python -m tests.bench.growth 30 100`, for docs/many-submissions.md.

The assignment is five problems of five questions each, of mixed families (`older.MIXED`). `qdot generate` is killed
with all its processes (SIGKILL) when half of the notebooks are there, and run again: its time is that of both runs.
Of the smallest class, what is there then is compared, byte by byte, with what one process writes that nobody kills.
Time is processor time for each student, of all processes together, which load changes little, beside a floor measured
in the same run: for generating, writing the bytes of a student's files once more; for grading, the cells of the
notebooks (tests/bench/floor). Memory is that of the largest process. All of it should stay the same, whatever the
size. Times and memory of the processes below the command are read from /proc.
"""

import contextlib
import datetime
import json
import os
import platform
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from exercises.assignment import Assignment, Student, load_assignment
from exercises.release import certificate_path, init_assignment, notebook_path
from exercises.store import kept, store_path
from grader.demo import answered
from tests.support import ROOT

from .grading import floor, processor_time
from .older import MIXED, SLOT

SIZES = (30, 100, 300)
MEASURED = 40
"""Notebooks whose cells are run for the floor."""
SECRET = "a secret, long enough"
RECORD = Path(__file__).with_suffix(".json")
DOCUMENT = ROOT / "docs" / "many-submissions.md"
BEGIN, END = "<!-- from tests/bench/growth.json, by `python -m tests.bench.growth` -->", "<!-- end -->"


@dataclass(frozen=True)
class Row:
    """What one command took of a class: seconds of processor time and on the clock for each student, megabytes."""

    students: int
    verb: str
    processor: float
    clock: float
    floor: float
    memory: float
    disk: float

    @property
    def cells(self) -> tuple[str, ...]:
        """What stands in a row of the table."""
        times = f"{1000 * self.processor:.0f} ms", f"{1000 * self.floor:.1f} ms", f"{self.processor / self.floor:.1f}"
        return f"{self.students:,}", f"`qdot {self.verb}`", *times, f"{self.memory:.0f} MB", f"{self.disk:.2f} MB"


HEAD = (
    "students", "", "a core, each", "beside: its files written, or its cells run", "ratio", "largest process",
    "on disk, each",
)  # fmt: skip


def table(measured: dict[str, Any]) -> str:
    """Return the table as Markdown, with when and where it was measured."""
    rows = [HEAD, ("---",) * len(HEAD), *(Row(**row).cells for row in measured["rows"])]
    body = "\n".join(f"| {' | '.join(cells)} |" for cells in rows)
    return f"Measured {measured['when']} on {measured['where']}.\n\n{body}"


def main() -> int:
    """Print a line for each size, and write the table."""
    sizes = [int(size) for size in sys.argv[1:]] or list(SIZES)
    rows: list[Row] = []
    for size in sizes:
        with tempfile.TemporaryDirectory() as name:
            folder = a_class(Path(name) / "class", size)
            found = stopped(folder, size // 2), measured("generate", folder)
            seconds, processor = (sum(each[k] for each in found) for k in (0, 1))
            made = seconds, processor, max(each[2] for each in found)
            if size == min(sizes):
                compared(folder, a_class(Path(name) / "again", size))
            rows.append(row(size, "generate", made, writing(load_assignment(folder)), folder))
            write(rows)  # whoever stops it at grading has what there is
            hand_in(folder)
            rows.append(row(size, "grade", measured("grade", folder), cells(load_assignment(folder)), folder))
        write(rows)
    return 0


def write(rows: Sequence[Row]) -> None:
    """Keep what was measured, and put its table into the page."""
    where = (
        f"{os.cpu_count()} cores, Python {platform.python_version()}, with {os.getloadavg()[2]:.0f} processes at work"
    )
    when = datetime.datetime.now(datetime.UTC).strftime("%-d %B %Y")
    measured = {"when": when, "where": where, "rows": [asdict(one) for one in rows]}
    RECORD.write_text(json.dumps(measured, indent=1) + "\n", encoding="utf-8")
    before, rest = DOCUMENT.read_text(encoding="utf-8").split(BEGIN)
    DOCUMENT.write_text(f"{before}{BEGIN}\n\n{table(measured)}\n\n{END}{rest.split(END, 1)[1]}", encoding="utf-8")


def a_class(folder: Path, size: int) -> Path:
    """Make the folder of a class of which nothing is written yet."""
    init_assignment(folder, "Growth", "bench", [Student(f"s{n:05d}") for n in range(size)], SECRET)
    file = folder / "assignment.toml"
    head = file.read_text("utf-8").split("\n[[problem]]")[0]
    file.write_text(head + "".join(map(SLOT.format, MIXED)), encoding="utf-8")
    return folder


def stopped(folder: Path, enough: int) -> tuple[float, float, float]:
    """Return what `measured` does of generating, killed with all its processes when so many notebooks are there."""

    def is_enough() -> bool:
        return sum(1 for _ in folder.glob("solutions/*/bench.ipynb")) >= enough

    found = measured("generate", folder, is_enough)
    there = sum(1 for _ in folder.glob("solutions/*/bench.ipynb"))
    sys.stdout.write(f"killed when {there} of {len(load_assignment(folder).roster)} notebooks were there\n")
    return found


def compared(folder: Path, other: Path) -> None:
    """Say that what a class was given after the kill is what one process writes; end with an error where it is not."""
    (other / "secret.txt").write_bytes((folder / "secret.txt").read_bytes())
    command = [sys.executable, "-m", "grader.cli", "generate", str(other), "--jobs", "1"]
    subprocess.run(command, check=True, capture_output=True)
    for kind in ("released", "solutions", "certificates"):
        names = [{path.relative_to(one) for path in (one / kind).rglob("*.*")} for one in (folder, other)]
        if names[0] != names[1]:
            raise SystemExit(f"{kind}: other files than one process writes")
        differing = [name for name in names[0] if (folder / name).read_bytes() != (other / name).read_bytes()]
        if differing:
            raise SystemExit(f"{differing[0]} is another than one process writes")
    sys.stdout.write("after the kill, every file is the same, byte by byte, as one process writes it\n")


def row(size: int, verb: str, found: tuple[float, float, float], floor: float, folder: Path) -> Row:
    """Return what a command took of a class, and print it."""
    seconds, processor, memory = found
    disk = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) / size / 1e6
    made = Row(size, verb, processor / size, seconds / size, floor, memory, disk)
    sys.stdout.write(f"{' | '.join(made.cells)} | {1000 * made.clock:.0f} ms on the clock\n")
    sys.stdout.flush()
    return made


def measured(verb: str, folder: Path, is_enough: Callable[[], bool] | None = None) -> tuple[float, float, float]:
    """Return seconds on the clock and of processor time, and the megabytes of the largest process, of a command.

    It is killed, with all its processes, as soon as there `is_enough`; then its times are those of a moment before.
    """
    command = [sys.executable, "-m", "grader.cli", verb, str(folder)]
    start, processor, largest = time.perf_counter(), 0.0, 0.0
    null = subprocess.DEVNULL
    process = subprocess.Popen(command, start_new_session=True, stdin=null, stdout=null, stderr=null)
    while not os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT):
        processor = max(processor, processor_time(process.pid))
        largest = max(largest, largest_of(process.pid))
        if is_enough is not None and is_enough():
            os.killpg(process.pid, signal.SIGKILL)
        time.sleep(0.1)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != (0 if is_enough is None else -signal.SIGKILL):
        raise SystemExit(f"qdot {verb} ended with {process.returncode}")
    processor = max(processor, usage.ru_utime + usage.ru_stime)
    return time.perf_counter() - start, processor, largest


def largest_of(process: int) -> float:
    """Return the most megabytes that a process, or one below it, has had.

    What the system says of a process that has ended (`ru_maxrss`) is no less than what the one had that started it.
    """
    found = 0.0
    with contextlib.suppress(OSError):
        held = re.search(r"VmHWM:\s*(\d+) kB", Path(f"/proc/{process}/status").read_text())
        found = int(held[1]) / 1024 if held else 0.0
        for child in Path(f"/proc/{process}/task/{process}/children").read_text().split():
            found = max(found, largest_of(int(child)))
    return found


def writing(assignment: Assignment) -> float:
    """Return the seconds of processor time in which a student's files are written once more, their bytes at hand."""
    ids = [student.id for student in assignment.roster]
    files = [notebook_path(assignment, one, kind) for one in ids for kind in ("released", "solutions")]
    files += [path(assignment, one) for one in ids for path in (certificate_path, store_path)]
    # Of who was at work when it was killed, nothing was kept for grading.
    contents = [path.read_bytes() for path in files[:4000] if path.exists()]
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
