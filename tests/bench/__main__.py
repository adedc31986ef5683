"""`make bench`: every figure that has a goal, as a ratio with what it is measured beside, in under ten minutes.

Everything is processor time of all processes together, which other work on the machine changes by a quarter, and
ratios of one run less. The table in tests/README.md is written from it.
"""

import datetime
import os
import platform
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment
from tests.support import ROOT

from . import peers
from .clock import processor_time
from .exporting import exporting
from .figures import Figure, write
from .generating import MIXED, compare_own_questions, first_problems, generating, records
from .grading import MIX, a_class, floor, hand_in
from .starting import LOADED, QDOT, loading, starting

STUDENTS, ALIKE = 25, 2
"""The number of students in the class, and how many in a row submit the same kind of work."""
PYTHON_OF_NBGRADER = ROOT / ".venvs" / "readers" / "bin" / "python"
"""The folder in which nbgrader may be installed."""


def main() -> int:
    begun = time.monotonic()
    figures = []
    with tempfile.TemporaryDirectory() as name:
        for figure in measured(Path(name)):
            figures.append(figure)
            sys.stdout.write(f"{' | '.join(figure.cells)}\n")
            sys.stdout.flush()
    where = f"{os.cpu_count()} cores of {_processor()}, {platform.system()} {platform.release()}"
    write(
        figures,
        {
            "when": datetime.datetime.now(datetime.UTC).strftime("%-d %B %Y"),
            "minutes": round((time.monotonic() - begun) / 60, 1),
            "where": f"{where}, Python {platform.python_version()}, with {os.getloadavg()[2]:.0f} processes at work",
        },
    )
    return 0


def _processor() -> str:
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    return next((line.partition(": ")[2] for line in lines if line.startswith("model name")), platform.machine())


def measured(folder: Path) -> Iterator[Figure]:
    single, assignment = a_class(folder / "single", 1), a_class(folder / "class", STUDENTS)
    hand_in(single, folder / "one", ("right",))
    hand_in(assignment, folder / "many", [kind for kind in MIX for _ in range(ALIKE)])
    yield from starting(folder / "one" / "s00000.ipynb", folder)
    yield from grading(single, assignment, folder)
    yield from generation(folder)
    yield from exporting(folder)


# --- grading ---


def graded(assignment: Assignment, submissions: Path, *more: str, anew: bool = True) -> float:
    """Return the seconds of `qdot grade`, of everything or of what has changed."""
    cache = assignment.folder / "graded"
    if anew and cache.exists():
        cache.rename(assignment.folder / f"graded before {time.monotonic_ns()}")
    command = [*QDOT, "grade", str(assignment.folder), str(submissions), "--jobs", "1", *more]
    return processor_time(command, assignment.folder)


def grading(single: Assignment, assignment: Assignment, folder: Path) -> Iterator[Figure]:
    """Yield what grading a class takes: start-up, each additional notebook, and a notebook that changed."""
    one, many = folder / "one", folder / "many"
    graded(single, one)
    start = min(graded(single, one) for _ in range(2))
    yield Figure("`qdot grade`, a class of one", start, LOADED, loading(), 1.5, of_seconds=True)
    floors = floor(assignment, many)
    whole = graded(assignment, many)
    each = (whole - start) / (STUDENTS - 1)
    cells = sum(processor for _, processor in floors) / len(floors)
    yield Figure(
        "each additional notebook, mixed answers", each, "running its cells in a fork of a warm process", cells, 1.5
    )
    run = sum(processor for _, processor in floor(assignment, many, checked=False)) / len(floors)
    yield Figure("the same", each, "running its cells without the self-checks", run, 1.5)
    hand_in(replace(assignment, roster=assignment.roster[:1]), folder / "changed", ("wrong sign throughout",))
    (many / "s00000.ipynb").write_bytes((folder / "changed" / "s00000.ipynb").read_bytes())
    again = graded(assignment, many, anew=False)
    yield Figure(f"{STUDENTS} notebooks graded again after one changed", again, "a class of one", start, 1.3)
    hand_in(assignment, folder / "right", ("right",))
    yield from beside_nbgrader((graded(assignment, folder / "right") - start) / (STUDENTS - 1), folder)


def beside_nbgrader(each: float, folder: Path) -> Iterator[Figure]:
    """Yield how often qdot grades a notebook while nbgrader grades one."""
    what, beside, goal = "each additional notebook, right answers", "nbgrader, each additional notebook", 50
    if not PYTHON_OF_NBGRADER.exists():
        why = "nbgrader is not installed: `make .venvs/readers/.installed`"
        yield Figure(what, each, beside, 1, goal, is_least=True, why=why)
        return
    taken = []
    for size in (1, 4):
        assignment = a_class(folder / f"peer{size}", size)
        place = folder / f"nbgrader{size}"
        taken.append(peers.nbgrader(assignment, place, PYTHON_OF_NBGRADER))
    yield Figure(what, each, beside, (taken[1] - taken[0]) / 3, goal, is_least=True)


# --- generating ---


def generation(folder: Path) -> Iterator[Figure]:
    each = generating(folder / "classes", 8)
    problem = "a problem with five questions, mixed families"
    yield Figure(problem, each / len(MIXED), LOADED, loading(), 0.05, of_seconds=True)
    custom, built_in = compare_own_questions(folder / "own", 8)
    yield Figure("five questions of an instructor's own", custom, "five built-in ones", built_in, 1)
    slowest, seconds = first_problems()
    yield Figure(f"first problem of a new family ({slowest})", seconds, LOADED, loading(), 1, of_seconds=True)
    record = records(1)
    yield Figure("a site of 1,000 arms, on two cores", record * 1000 / 2, "one record", record, 600, of_seconds=True)


if __name__ == "__main__":
    sys.exit(main())
