"""`make bench-peers`: the same notebooks graded by qdot, nbgrader and otter-grader, seconds of wall time each.

The assignment is Examples 6.1 and 6.2, five answers on a planar arm of two joints. The peers grade one problem, as they
know no problem of one's own; their tests compare the answers at random points with NumPy, which is less than what qdot
does. qdot and nbgrader are given 20 notebooks, and otter, which takes one after another, four. They run in an
environment of their own, whose Python is the only argument.

qdot's start-up, some seconds whatever the size, is most of what 20 notebooks take it: so it is given 200, too, on one
process, which is what the peers use, and on all cores, as it does by itself. The peers take as long for every notebook.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import nbformat
from nbformat.v4 import new_code_cell

from qdot.exercises.answers import Expression, Matrix
from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import init_assignment, release
from qdot.exercises.assignment.store import load_stored_problems
from qdot.exercises.problem.problem import variable
from qdot.grader.cli.demo import answered
from qdot.grader.grading.certify import CERTIFIER

FEW, MANY = 20, 200
SLOT = """
[[problem]]
family = "planar-2r"
questions = ["position", "jacobian", "determinant", "inverse-velocity", "singular-angles"]
"""
LONGEST = 600
"""Seconds after which one command is ended."""
OF_OTTER = 4
"""Notebooks that otter is given."""
COMPARE = """
import random as _random
def same(mine, right):
    mine, right = (value if hasattr(value, "shape") else Matrix([value]) for value in (mine, right))
    symbols = sorted(right.free_symbols, key=str)
    f, g = lambdify(symbols, mine), lambdify(symbols, right)
    points = [[_random.uniform(0.3, 1.5) for _ in symbols] for _ in range(5)]
    return all(np.allclose(np.array(f(*p), float), np.array(g(*p), float)) for p in points)
"""


def main() -> int:
    """Print the times, and the ratios of the peers' to qdot's."""
    python = Path(sys.argv[1])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        assignment = a_class(folder / "qdot", FEW)
        a_class(folder / "many", MANY)
        own = qdot(folder)
        peers: dict[str, float] = {}
        for peer, work in (("nbgrader autograde", nbgrader), ("otter run, one after another", otter)):
            try:
                peers[peer] = work(assignment, folder / peer.split()[0], python.absolute()) / FEW
            except (subprocess.SubprocessError, OSError, ValueError) as error:
                said = str(getattr(error, "stderr", "") or error).strip()
                sys.stdout.write(f"{peer}: not measured: {said[-500:]}\n")
        for peer, seconds in peers.items():
            sys.stdout.write(f"{peer:<44} {seconds:8.3f} s a notebook\n")
        for mine, seconds in own.items():
            ratios = ", ".join(f"{peer.split()[0]} {found / seconds:.0f} x" for peer, found in peers.items())
            sys.stdout.write(f"{mine:<44} {seconds:8.3f} s a notebook: {ratios}\n")
    return 0


def qdot(folder: Path) -> dict[str, float]:
    """Return seconds for each notebook of a class, start-up included."""
    found = {}
    for said, options in (("one process", ["--jobs", "1"]), (f"{os.cpu_count()} cores", [])):
        for name, size in (("qdot", FEW), ("many", MANY)):
            shutil.rmtree(folder / name / "graded", ignore_errors=True)
            command = [sys.executable, "-m", "qdot", "grade", str(folder / name), *options]
            found[f"qdot grade, {size} notebooks, {said}"] = timed(command, folder) / size
    return found


def timed(command: list[str], folder: Path) -> float:
    """Run a command, with the programs beside its Python at hand, and return its wall time in seconds."""
    there = {**os.environ, "PATH": f"{Path(command[0]).parent}{os.pathsep}{os.environ['PATH']}"}
    start = time.perf_counter()
    subprocess.run(
        command,
        cwd=folder,
        check=True,
        capture_output=True,
        text=True,
        env=there,
        timeout=LONGEST,
        stdin=subprocess.DEVNULL,
    )
    return time.perf_counter() - start


def a_class(folder: Path, size: int) -> Assignment:
    """Make a class, and hand in the solutions."""
    students = [Student(f"s{number:02d}") for number in range(size)]
    init_assignment(folder, "Bench", "bench", students, "a secret that is long enough")
    file = folder / "assignment.toml"
    file.write_text(file.read_text("utf-8").split("\n[[problem]]")[0] + SLOT, encoding="utf-8")
    assignment = load_assignment(folder)
    release(assignment, CERTIFIER, 2, lambda _: None)
    for student in students:
        target = folder / "submitted" / student.id / "bench.ipynb"
        target.parent.mkdir(parents=True)
        text = (folder / "released" / student.id / "bench.ipynb").read_text("utf-8")
        target.write_text(
            answered(text, load_stored_problems(assignment, student.id).problems, lambda code, _: code),
            encoding="utf-8",
        )
    return assignment


def checks(assignment: Assignment) -> dict[str, str]:
    """Return a line of code for each answer that fails where it is wrong."""
    ((slot, problem),) = assignment.problems("s00")
    found = {}
    for part in problem.parts:
        name = variable(slot, part.name)
        if isinstance(part.answer, (Expression, Matrix)):
            found[part.name] = " ".join(f"assert same({name}, {part.answer.reference!r})".split())
        else:
            found[part.name] = f"assert {name}"
    return found


def one_notebook(assignment: Assignment, kind: str) -> Any:
    return nbformat.read(assignment.folder / kind / "s00" / "bench.ipynb", as_version=4)


# --- nbgrader ---


def nbgrader(
    assignment: Assignment, folder: Path, python: Path, clock: Callable[[list[str], Path], float] | None = None
) -> float:
    """Make a course with one assignment, and return the time of `nbgrader autograde` on the class, by a clock."""
    source = one_notebook(assignment, "released")
    tests = checks(assignment)
    cells = []
    for cell in source.cells:
        cells.append(cell)
        part = cell.metadata.pop("qdot", {}).get("part", "").removeprefix("p1.")
        if part in tests:
            cell.metadata["nbgrader"] = mark(f"answer-{part}", 0, solution=True)
            code = COMPARE + tests[part]
            cells.append(new_code_cell(code, metadata={"nbgrader": mark(f"test-{part}", 1, grade=True)}))
    source.cells = cells
    target = folder / "source" / "bench" / "bench.ipynb"
    target.parent.mkdir(parents=True)
    nbformat.write(source, target)
    (folder / "nbgrader_config.py").write_text(f"c = get_config()\nc.CourseDirectory.root = {str(folder)!r}\n")
    run = [str(python), "-m", "nbgrader"]
    timed([*run, "generate_assignment", "bench"], folder)
    handed_out = nbformat.read(folder / "release" / "bench" / "bench.ipynb", as_version=4)
    solved = {cell.id: cell.source for cell in one_notebook(assignment, "solutions").cells}
    for cell in handed_out.cells:
        if cell.metadata.get("nbgrader", {}).get("solution"):
            cell.source = solved[cell.id]
    for student in assignment.roster:
        path = folder / "submitted" / student.id / "bench" / "bench.ipynb"
        path.parent.mkdir(parents=True)
        nbformat.write(handed_out, path)
    return (clock or timed)([*run, "autograde", "bench"], folder)


def mark(name: str, points: int, solution: bool = False, grade: bool = False) -> dict[str, Any]:
    """Return nbgrader's metadata of a cell."""
    found = {
        "grade_id": name,
        "solution": solution,
        "grade": grade,
        "locked": grade,
        "schema_version": 3,
        "task": False,
    }
    return {**found, "points": points} if grade else found


# --- otter ---


def otter(assignment: Assignment, folder: Path, python: Path) -> float:
    """Make an autograder of one test for each answer; return the time of `otter run`, as it would be for everybody."""
    tests = folder / "tests"
    tests.mkdir(parents=True)
    for part, check in checks(assignment).items():
        lines = [*COMPARE.strip().splitlines(), check]
        code = "".join(f"{'...' if line.startswith(' ') else '>>>'} {line}\n" for line in lines)
        case = {"code": code, "hidden": False, "locked": False}
        suite = {"cases": [case], "scored": True, "setup": "", "teardown": "", "type": "doctest"}
        content = {"name": part, "points": 1, "suites": [suite]}
        (tests / f"{part.replace('-', '_')}.py").write_text(f"OK_FORMAT = True\ntest = {content!r}\n")
    timed([str(python), "-m", "otter", "generate", "-t", str(tests), "-o", str(folder / "grader.zip")], folder)
    notebook = folder / "bench.ipynb"
    solved = one_notebook(assignment, "solutions")
    nbformat.write(solved, notebook)
    archive = folder / "grader.zip"
    total = 0.0
    for number in range(OF_OTTER):
        place = folder / f"run{number}"
        place.mkdir()
        shutil.copy(notebook, place)
        total += timed([str(python), "-m", "otter", "run", "bench.ipynb", "-a", str(archive)], place)
        scores = json.loads((place / "results.json").read_text("utf-8"))["tests"]
        if any(each["score"] < each["max_score"] for each in scores if "max_score" in each):
            raise ValueError("right answers did not get full marks")
    return total * FEW / OF_OTTER


if __name__ == "__main__":
    sys.exit(main())
