"""What grading a notebook costs, all of it, beside the floor (tests/bench/floor) measured in the same run.

All of it: read, run in the sandbox, compared, diagnosed, settled, kept, its page and its lines in the tables written,
with one job. `the command` is `qdot grade --jobs 1` on the whole class less the same on a class of one, for each
notebook more; start-up is the class of one. The assignment is Examples 6.1 and 6.2.
"""

import contextlib
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from exercises.assignment import Assignment, Student, load_assignment
from exercises.release import init_assignment, release
from exercises.store import kept
from grader.batch import grade_class
from grader.certify import CERTIFIER
from grader.demo import EDITS, answered
from grader.reports.write import write_reports
from grader.sandbox import Limits
from grader.submission import find_submissions, read_submission
from grader.uncounted import without_self_checks

SLOT = """
[[problem]]
family = "planar-2r"
questions = ["position", "jacobian", "determinant", "inverse-velocity", "singular-angles"]
"""
MIX = (
    "right", "right, in another form", "right", "a sign wrong throughout", "right", "relative for absolute angles",
    "right, in another form", "matrices transposed", "joint 2 forgotten", "first singular condition only",
    "half of it", "blank",
)  # fmt: skip
"""What notebooks of a class are like; an endless loop and the like are none of it, for they cost what they may."""
STUDENTS = 24


def bench_grading(folder: Path, size: int = STUDENTS) -> None:
    """Print the floor, then what grading costs of right notebooks and of a mixture, and the ratios."""
    single, assignment = a_class(folder / "single", 1), a_class(folder / "class", size)
    for kind, edits in (("right", ("right",)), ("mixed", MIX)):
        hand_in(single, folder / "single" / kind, edits)
        hand_in(assignment, folder / "class" / kind, edits)
        floors = floor(assignment, folder / "class" / kind)
        stages, processor = measured(assignment, folder / "class" / kind)
        start, whole = command(single, folder / "single" / kind), command(assignment, folder / "class" / kind)
        floors += floor(assignment, folder / "class" / kind)
        wall, cpu = (1000 * statistics.median(each[k] for each in floors) for k in (0, 1))
        sys.stdout.write(f"--- {size} notebooks, {kind}\n")
        row("floor: their own cells, on the clock", wall, wall)
        for name, times in stages.items():
            row(name, 1000 * statistics.median(times), wall)
        row("grade: the medians together", 1000 * sum(map(statistics.median, stages.values())), wall)
        row("grade: the command, for each notebook", 1000 * (whole - start) / (size - 1), wall)
        row("floor: processor time", cpu, cpu)
        row("grade: processor time, sandbox included", 1000 * processor, cpu)
        sys.stdout.write(f"{'start-up: the command on a class of one':<46} {1000 * start:9.1f} ms\n")


def row(name: str, milliseconds: float, floor: float) -> None:
    """Print one line."""
    sys.stdout.write(f"{name:<46} {milliseconds:9.1f} ms {milliseconds / floor:8.1f} x floor\n")


def a_class(folder: Path, size: int) -> Assignment:
    """Make a class with its notebooks."""
    init_assignment(folder, "Bench", "bench", [Student(f"s{n:05d}") for n in range(size)], "a secret, long enough")
    file = folder / "assignment.toml"
    file.write_text(file.read_text("utf-8").split("\n[[problem]]")[0] + SLOT, encoding="utf-8")
    assignment = load_assignment(folder)
    release(assignment, CERTIFIER, 2, lambda _: None)
    return assignment


def hand_in(assignment: Assignment, target: Path, kinds: Sequence[str]) -> None:
    """Write a submission for every student, of one kind after the other."""
    edits = dict(EDITS)
    target.mkdir()
    for number, student in enumerate(assignment.roster):
        text = (assignment.folder / "released" / student.id / f"{assignment.key}.ipynb").read_text("utf-8")
        kind = kinds[number % len(kinds)]
        if kind in edits:
            text = answered(text, kept(assignment, student.id).problems, edits[kind])
        (target / f"{student.id}.ipynb").write_text(text, encoding="utf-8")


def floor(assignment: Assignment, submissions: Path, checked: bool = True) -> list[tuple[float, float]]:
    """Return wall and processor time of the bare cells of every notebook, its checks of itself among them or not.

    Grading leaves these out.
    """
    notebooks = []
    for name, found in find_submissions(assignment, submissions).found.items():
        cells = read_submission(found.files[0]).cells
        kept_cells = cells if checked else without_self_checks(cells, kept(assignment, name).problems)
        notebooks.append([cell.source for cell in kept_cells if cell.is_code])
    command = [sys.executable, "-m", "tests.bench.floor"]
    done = subprocess.run(command, input=json.dumps(notebooks), capture_output=True, text=True, check=True)
    times: list[tuple[float, float]] = json.loads(done.stdout)
    return times


def command(assignment: Assignment, submissions: Path) -> float:
    """Return the wall time of the command in seconds."""
    shutil.rmtree(assignment.folder / "graded", ignore_errors=True)
    line = [sys.executable, "-m", "grader.cli", "grade", str(assignment.folder), str(submissions), "--jobs", "1"]
    start = time.perf_counter()
    subprocess.run(line, capture_output=True, check=True)
    return time.perf_counter() - start


def measured(assignment: Assignment, submissions: Path) -> tuple[dict[str, list[float]], float]:
    """Grade in this process; return wall times for each notebook by stage, and the mean of the processor time.

    The first notebook, which waits for the sandbox to start, is left out of both.
    """
    shutil.rmtree(assignment.folder / "graded", ignore_errors=True)
    graded, written = [], [0.0]
    used: list[float] = []

    def each(_: object) -> None:
        graded.append(time.perf_counter())
        used.append(time.process_time() + processor_time_below(os.getpid()))

    results = grade_class(assignment, find_submissions(assignment, submissions).found, 0, Limits(), each)
    begun, written[0] = time.process_time(), time.perf_counter()
    write_reports(assignment, results, 1, lambda: written.append(time.perf_counter()))
    pages = time.process_time() - begun
    tables = time.perf_counter() - written[-1]
    stages = {
        "  read, run, compare, diagnose, settle, keep": steps(graded),
        "  feedback page": steps(written)[1:],
        "  tables": [tables / len(results)],
    }
    return stages, (used[-1] - used[0]) / (len(used) - 1) + pages / len(results)


def steps(moments: Sequence[float]) -> list[float]:
    """Return how long it was from one to the next."""
    return [after - before for before, after in pairwise(moments)]


def processor_time_below(process: int) -> float:
    """Return the seconds of processor time of all processes below one, and of what has ended there."""
    with contextlib.suppress(OSError):
        children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
        return sum(processor_time(int(child)) for child in children)
    return 0.0


def processor_time(process: int) -> float:
    """Return the seconds of processor time of a process, of what has ended below it, and of all below it."""
    with contextlib.suppress(OSError):
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK") + processor_time_below(process)
    return 0.0


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as made:
        bench_grading(Path(made))
