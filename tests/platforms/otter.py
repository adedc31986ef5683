"""Otter-Grader itself: `otter assign` makes the autograder from our source, and `otter run` marks a class with it.

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
    KEY,
    QdotGrading,
    compare_marks,
    export_into,
    fill_in_answers,
    install,
    make_class_assignment,
)
from tests.platforms.records import Counts, Record, today


def run(software: Path, work: Path) -> Record:
    """Make the autograder, and mark every student's notebook with it."""
    assignment, counts = make_class_assignment(work / KEY), Counts()
    folder = export_into(assignment, "otter", work / "exported")
    (wheel,) = folder.glob("*.whl")
    install(software, wheel)
    _run_otter(software, folder, "assign", f"{KEY}.ipynb", "dist")
    (autograder,) = (folder / "dist" / "autograder").glob("*.zip")
    test_names = _list_tests(autograder)
    for _, name, _, _ in list_parts(assignment):
        counts.add("imported", name in test_names, name)
    for student in (student.id for student in assignment.roster):
        notebook, out = work / student / f"{KEY}.ipynb", work / student / "out"
        out.mkdir(parents=True)
        released = folder / "students" / student / f"{KEY}.ipynb"
        notebook.write_text(
            fill_in_answers(assignment, student, released.read_text(encoding="utf-8")), encoding="utf-8"
        )
        _run_otter(software, work / student, "run", "-a", autograder, "-o", out, notebook)
        results = json.loads((out / "results.json").read_text(encoding="utf-8"))
        _check_student(QdotGrading(assignment, student, notebook), results, counts)
    version = subprocess.run([software / "bin" / "otter", "--version"], capture_output=True, text=True).stdout
    return Record("otter", _find_version(version), today(), counts.freeze())


def _run_otter(software: Path, cwd: Path, *words: str | Path) -> None:
    environment = {**os.environ, "PATH": f"{software / 'bin'}{os.pathsep}{os.environ['PATH']}"}
    command = [software / "bin" / "otter", *words]
    done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"otter {words[0]}: {done.stdout[-2000:]}{done.stderr[-2000:]}")


def _find_version(version: str) -> str:
    line = next(line for line in version.splitlines() if "otter" in line.casefold())
    return line.replace("version: ", "").strip()


def _list_tests(autograder: Path) -> set[str]:
    with zipfile.ZipFile(autograder) as archive:
        return {Path(name).stem for name in archive.namelist() if Path(name).match("tests/*.py")}


def _check_student(grading: QdotGrading, results: Any, counts: Counts) -> None:
    """Check a student's results.json: the output of every test, and its points."""
    tests = {test["name"]: test for test in results["tests"]}
    assignment = grading.assignment
    messages = {row.part: row.message for row in make_part_rows(grading.result, assignment, assignment.feedback)}
    for part, name, points, _ in list_parts(assignment):
        test = tests.get(name, {})
        is_full = grading.result.parts[part].points == points
        shown = test.get("max_score") == points and (is_full or messages[part] in test.get("output", ""))
        counts.add("shown", shown, f"{grading.student} {name}: {test}")
    grade_ids = {part: make_grade_id(part) for part in grading.result.parts}
    compare_marks(
        counts, grading, {part: tests[grade_id]["score"] for part, grade_id in grade_ids.items() if grade_id in tests}
    )
