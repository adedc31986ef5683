"""A class as this version hands it out and grades it, and all names that this version promises, kept for later ones.

    python -m tests.tools.archive               writes tests/data/archives/unreleased anew
    python -m tests.tools.archive 1.0.0         writes that of a release, which never changes again
    python -m tests.tools.archive --check v1.0.0
                                                sees whether a tag has one, as this version writes it; without a tag,
                                                whether one can be written

`tests/repository/test_compatibility.py` holds every later version against all archives. Of what is handed out there are
certificates, which have a digest of every problem and cell, and not the notebooks; what is handed in has code alone.
"""

import argparse
import json
import os
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

import qdot
from qdot.exercises.arm.chain import CONVENTIONS
from qdot.exercises.arm.conventions import REGISTRY
from qdot.exercises.arm.library import robots
from qdot.exercises.arm.robot_file import TOP_KEYS
from qdot.exercises.assignment.assignment import AssignmentFile, ProblemEntry, Student, load_assignment
from qdot.exercises.assignment.release import init_assignment, notebook_path, release_notebooks
from qdot.exercises.assignment.sets import SETS
from qdot.exercises.common.console import say
from qdot.exercises.common.variation import VARIATION_AXES, VARIATION_STEPS
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.families import FAMILIES
from qdot.exercises.problem.problem import ENGINE
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.grader.grading.attempt import GRADER_VERSION
from qdot.grader.grading.batch import grade_class
from qdot.grader.grading.certify import CERTIFIER
from qdot.grader.grading.history import results_path
from qdot.grader.grading.overrides import OVERRIDES_FILE
from qdot.grader.reports.formats import FORMATS
from qdot.grader.reports.grades_table import make_results_jsonl
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import find_submissions
from tests.support import DATA, ROOT
from tests.tools.release import read_version

ARCHIVES = DATA / "archives"
SCHEMAS = ROOT / "docs" / "schemas"
UNRELEASED = "unreleased"
"""The archive that is written anew whenever a number of version goes up before a release."""
STUDENTS = (Student("ada", "Ada Example"), Student("bo", "Bo Example"))
KEY, RECEIVED = "archived", 1_700_000_000
TOML = f"""title = "Archived"
key = "{KEY}"
attempts = "best"

[[problem]]
family = "planar-2r"
questions = ["position", "jacobian", "determinant", "inverse-velocity", "singular-angles"]
points = [1, 2, 1, 2, 2]

[[problem]]
robot = "arm.toml"
questions = ["jacobian", "determinant"]

[[problem]]
family = "scara"
variation = "full"
convention = "modified-dh"
questions = ["joint-axes", "geometric-jacobian"]

[[problem]]
family = "random-3"
questions = ["jacobian", "determinant"]
difficulty = [1, 2]
decimals = 3

[[problem]]
family = "wrist-zyz"
convention = "screws"
questions = ["space-jacobian"]

[[problem]]
family = "elbow-3r"
questions = "quiz"
"""
ARM = """name = "archived arm"
task = ["vx", "vy"]

[[joint]]
kind = "R"
theta = "theta1"
d = 0
a = "a1"
alpha = "pi/2"

[[joint]]
kind = "P"
theta = 0
d = "d2"
a = 0
alpha = 0

[draw]
a1 = [0.3, 0.8]
"""
WRONG = {
    "p1.jacobian": "p1_jacobian = Matrix([[-a1*sin(theta1), 0], [a1*cos(theta1), 0]])",
    "p1.determinant": "p1_determinant = blank",
    "p2.determinant": "raise ValueError('no idea')",
}
"""The second student's wrong answers; all other answers of both students are right."""


def interface() -> dict[str, Any]:
    """Return every name that people write, or that their programs use: none of them goes or changes its meaning."""
    import typer

    from qdot.grader.cli.main import make_program

    whole = typer.main.get_command(make_program())
    of_joints = {f"[[joint]] of {name}": sorted(convention.joint_keys) for name, convention in REGISTRY.items()}
    return {
        "commands": dict(_options(whole, "qdot")),
        "assignment.toml": sorted(AssignmentFile.model_fields),
        "[[problem]]": sorted(ProblemEntry.model_fields),
        "ROBOT.toml": {"": sorted(TOP_KEYS), **of_joints},
        "library": sorted(qdot.__all__),
        "conventions": sorted(CONVENTIONS), "variation": sorted((*VARIATION_STEPS, *VARIATION_AXES)),
        "sets": sorted(SETS), "families": sorted(FAMILIES), "questions": sorted(ALL_QUESTIONS),
        "robots": sorted(robots()),
        "export_formats": sorted(EXPORT_FORMATS), "reports": sorted(FORMATS),
    }  # fmt: skip


def _options(command: Any, name: str) -> list[tuple[str, list[str]]]:
    """Return each command by its whole name with its arguments and options."""
    if hasattr(command, "commands"):
        return [pair for each, inner in command.commands.items() for pair in _options(inner, f"{name} {each}")]
    return [(name, sorted(written for one in command.params for written in one.opts))]


def write(archive: Path) -> None:
    """Write an archive."""
    shutil.rmtree(archive, ignore_errors=True)
    archive.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "class"
        _handed_out_and_graded(folder)
        for kept in ("certificates", "submitted"):
            shutil.copytree(folder / kept, archive / kept)
        for kept in ("assignment.toml", "roster.csv", "secret.txt", "arm.toml", OVERRIDES_FILE, "redrawn.csv"):
            if (folder / kept).exists():
                shutil.copyfile(folder / kept, archive / kept)
        (archive / "graded").mkdir()
        shutil.copyfile(folder / "graded" / "results.jsonl", archive / "graded" / "results.jsonl")
    shutil.copytree(SCHEMAS, archive / "schemas")
    about = {"qdot": read_version(ROOT), "engine": ENGINE, "grader": GRADER_VERSION}
    for file, content in (("about.json", about), ("interface.json", interface())):
        (archive / file).write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def _handed_out_and_graded(folder: Path) -> None:
    init_assignment(folder, "Archived", KEY, STUDENTS, secret="an archive's secret")
    (folder / "arm.toml").write_text(ARM, encoding="utf-8")
    (folder / "assignment.toml").write_text(TOML, encoding="utf-8")
    (folder / OVERRIDES_FILE).write_text(
        "student,part,points,comment\nbo,p3.joint-axes,0.5,on paper\n", encoding="utf-8"
    )
    assignment = release_notebooks(load_assignment(folder), CERTIFIER, 1, lambda _: None)
    for student in STUDENTS:
        solved = json.loads(notebook_path(assignment, student.id, "solutions").read_text(encoding="utf-8"))
        handed_in = folder / "submitted" / student.id / f"{KEY}.ipynb"
        handed_in.parent.mkdir(parents=True)
        solved["metadata"]["qdot"]["kind"] = "student"
        content = {**solved, "cells": [_cell(cell, student.id) for cell in solved["cells"] if _is_answered(cell)]}
        handed_in.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        os.utime(handed_in, (RECEIVED, RECEIVED))
    looked = find_submissions(assignment, folder / "submitted")
    results = grade_class(assignment, looked.by_student, 0, Limits(), lambda _: None)
    results_path(assignment).write_bytes(make_results_jsonl(results))


def _is_answered(cell: dict[str, Any]) -> bool:
    return cell["cell_type"] == "code" and ("qdot" in cell["metadata"] or cell.get("id") == "setup")


def _cell(cell: dict[str, Any], student: str) -> dict[str, Any]:
    part = cell["metadata"].get("qdot", {}).get("part")
    return {**cell, "outputs": [], **({"source": WRONG[part]} if student == "bo" and part in WRONG else {})}


def differing(archive: Path) -> list[str]:
    """Return the files of an archive that are not as this version writes them."""
    with tempfile.TemporaryDirectory() as name:
        write(fresh := Path(name) / "archive")
        there, here = _contents(archive), _contents(fresh)
    return sorted(str(path) for path in there.keys() | here.keys() if there.get(path) != here.get(path))


def _contents(folder: Path) -> dict[Path, bytes]:
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("release", nargs="?", default="")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    number = given.release.removeprefix("v")
    archive = ARCHIVES / (number or UNRELEASED)
    if given.check:
        differ = differing(archive)
        if number and differ:
            sys.exit(f"{archive.relative_to(ROOT)} is not as this version writes it: {', '.join(differ)}")
        say(f"{archive.name} is archived" if number else "a class of this version can be archived")
    elif number and archive.exists():
        sys.exit(f"{archive.relative_to(ROOT)} is there: what a release archived is what later ones are held to")
    elif number and number != read_version(ROOT):
        sys.exit(f"this is version {read_version(ROOT)}, and no other can be archived")
    else:
        write(archive)
        say(f"wrote {archive.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
