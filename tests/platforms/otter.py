"""Otter-Grader itself: `otter assign` makes the autograder of our source, `otter run` marks a class by it.

`software` is an environment of Python with otter-grader, into which the exported qdot is installed.
"""

import json
import os
import subprocess
import zipfile
from pathlib import Path
from typing import Any

from qdot.exercises.exports.nbgrader import list_parts, make_grade_id
from qdot.grader.reports.part_rows import make_part_rows
from tests.platforms.notebooks import (
    BLANK,
    KEY,
    MISTAKEN,
    RIGHT,
    WRONG,
    Ours,
    a_class,
    answered,
    exported,
    hold,
    install,
)
from tests.platforms.records import Counts, Record, today


def run(software: Path, work: Path) -> Record:
    """Have the autograder made, and every student's notebook marked by it."""
    assignment, counts = a_class(work / KEY, RIGHT, WRONG, MISTAKEN, BLANK), Counts()
    folder = exported(assignment, "otter", work / "exported")
    (wheel,) = folder.glob("*.whl")
    install(software, wheel)
    call(software, folder, "assign", f"{KEY}.ipynb", "dist")
    (autograder,) = (folder / "dist" / "autograder").glob("*.zip")
    made = _tests_of(autograder)
    for _, name, _, _ in list_parts(assignment):
        counts.add("imported", name in made, name)
    for student in (one.id for one in assignment.roster):
        notebook, out = work / student / f"{KEY}.ipynb", work / student / "out"
        out.mkdir(parents=True)
        handed_out = folder / "students" / student / f"{KEY}.ipynb"
        notebook.write_text(answered(assignment, student, handed_out.read_text(encoding="utf-8")), encoding="utf-8")
        call(software, work / student, "run", "-a", autograder, "-o", out, notebook)
        results = json.loads((out / "results.json").read_text(encoding="utf-8"))
        _hold(Ours(assignment, student, notebook), results, counts)
    version = subprocess.run([software / "bin" / "otter", "--version"], capture_output=True, text=True).stdout
    return Record("otter", _named(version), today(), counts.told())


def call(software: Path, cwd: Path, *words: str | Path) -> None:
    """Give a command of Otter's in a folder."""
    environment = {**os.environ, "PATH": f"{software / 'bin'}{os.pathsep}{os.environ['PATH']}"}
    command = [software / "bin" / "otter", *words]
    done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"otter {words[0]}: {done.stdout[-2000:]}{done.stderr[-2000:]}")


def _named(version: str) -> str:
    """Return the line about Otter among those that `otter --version` prints."""
    return next(line for line in version.splitlines() if "otter" in line.casefold()).strip()


def _tests_of(autograder: Path) -> set[str]:
    with zipfile.ZipFile(autograder) as archive:
        return {Path(name).stem for name in archive.namelist() if Path(name).match("tests/*.py")}


def _hold(ours: Ours, results: Any, counts: Counts) -> None:
    """Hold a student's results.json: what is shown of every test, and what it earns."""
    tests = {test["name"]: test for test in results["tests"]}
    assignment = ours.assignment
    said = {row.part: row.message for row in make_part_rows(ours.result, assignment.feedback)}
    for part, name, points, _ in list_parts(assignment):
        test = tests.get(name, {})
        is_full = ours.result.parts[part].points == points
        shown = test.get("max_score") == points and (is_full or said[part] in test.get("output", ""))
        counts.add("shown", shown, f"{ours.student} {name}: {test}")
    grade_ids = {part: make_grade_id(part) for part in ours.result.parts}
    hold(counts, ours, {part: tests[grade_id]["score"] for part, grade_id in grade_ids.items() if grade_id in tests})
