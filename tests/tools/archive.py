"""Archive a class that this version generates and grades, and all names that later versions must keep.

    python -m tests.tools.archive                   rewrite tests/data/archives/unreleased
    python -m tests.tools.archive 1.0.0             write the archive of a release, which never changes again
    python -m tests.tools.archive --check v1.0.0    check that this version writes the archive of a tag
    python -m tests.tools.archive --check           check that an archive can be written

`tests/repository/test_compatibility.py` checks every later version against all archives. Instead of the released
notebooks, an archive has certificates with a digest of every problem and cell; submissions contain code cells only.
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
from qdot.exercises.assignment.assignment import AssignmentFile, ProblemEntry, load_assignment
from qdot.exercises.assignment.release import make_notebook_path, release_notebooks
from qdot.exercises.assignment.sets import SETS
from qdot.exercises.common.console import print_result
from qdot.exercises.common.variation import VARIATION_AXES, VARIATION_STEPS
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.families import FAMILIES
from qdot.exercises.problem.problem import ENGINE
from qdot.exercises.robots.library import list_robots
from qdot.exercises.robots.robot_file import TOP_KEYS
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
"""The archive that is rewritten whenever ENGINE or GRADER_VERSION increases before a release."""
CLASS_FILES = ("assignment.toml", "roster.csv", "secret.txt", "arm.toml", OVERRIDES_FILE)
"""The files that an instructor writes. Every new archive gets those of the unreleased one."""
RECEIVED = 1_700_000_000
WRONG = {
    "p1.jacobian": "p1_jacobian = Matrix([[-a1*sin(theta1), 0], [a1*cos(theta1), 0]])",
    "p1.determinant": "p1_determinant = blank",
    "p2.determinant": "raise ValueError('no idea')",
}
"""The second student's wrong answers; all other answers of both students are right."""


def list_public_names() -> dict[str, Any]:
    """Return all names that people or their programs use, by kind; no name may be removed or change its meaning."""
    import typer

    from qdot.grader.cli.main import make_program

    command = typer.main.get_command(make_program())
    joint_keys = {f"[[joint]] of {name}": sorted(convention.joint_keys) for name, convention in REGISTRY.items()}
    return {
        "commands": dict(_list_options(command, "qdot")),
        "assignment.toml": sorted(AssignmentFile.model_fields),
        "[[problem]]": sorted(ProblemEntry.model_fields),
        "ROBOT.toml": {"": sorted(TOP_KEYS), **joint_keys},
        "library": sorted(qdot.__all__),
        "conventions": sorted(CONVENTIONS), "variation": sorted((*VARIATION_STEPS, *VARIATION_AXES)),
        "sets": sorted(SETS), "families": sorted(FAMILIES), "questions": sorted(ALL_QUESTIONS),
        "robots": sorted(list_robots()),
        "export_formats": sorted(EXPORT_FORMATS), "reports": sorted(FORMATS),
    }  # fmt: skip


def _list_options(command: Any, name: str) -> list[tuple[str, list[str]]]:
    if hasattr(command, "commands"):
        return [
            pair
            for short_name, subcommand in command.commands.items()
            for pair in _list_options(subcommand, f"{name} {short_name}")
        ]
    return [(name, sorted(option for param in command.params for option in param.opts))]


def write_archive(archive: Path) -> None:
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        _generate_and_grade_class(folder)
        shutil.rmtree(archive, ignore_errors=True)
        archive.mkdir(parents=True)
        for name in ("certificates", "submitted"):
            shutil.copytree(folder / name, archive / name)
        for name in (*CLASS_FILES, "redrawn.csv"):
            if (folder / name).exists():
                shutil.copyfile(folder / name, archive / name)
        (archive / "graded").mkdir()
        shutil.copyfile(folder / "graded" / "results.jsonl", archive / "graded" / "results.jsonl")
    shutil.copytree(SCHEMAS, archive / "schemas")
    versions = {"qdot": read_version(ROOT), "engine": ENGINE, "grader": GRADER_VERSION}
    for file, content in (("about.json", versions), ("interface.json", list_public_names())):
        (archive / file).write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def _generate_and_grade_class(folder: Path) -> None:
    for name in CLASS_FILES:
        shutil.copyfile(ARCHIVES / UNRELEASED / name, folder / name)
    assignment = release_notebooks(load_assignment(folder), CERTIFIER, 1, lambda _: None)
    for student in assignment.roster:
        solved = json.loads(make_notebook_path(assignment, student.id, "solutions").read_text(encoding="utf-8"))
        submitted = folder / "submitted" / student.id / f"{assignment.key}.ipynb"
        submitted.parent.mkdir(parents=True)
        solved["metadata"]["qdot"]["kind"] = "student"
        cells = [cell for cell in solved["cells"] if _is_answered(cell)]
        content = {**solved, "cells": [_make_submitted_cell(cell, student.id) for cell in cells]}
        submitted.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        os.utime(submitted, (RECEIVED, RECEIVED))
    submissions = find_submissions(assignment, folder / "submitted")
    results = grade_class(assignment, submissions.by_student, 0, Limits(), lambda _: None)
    results_path(assignment).write_bytes(make_results_jsonl(results))


def _is_answered(cell: dict[str, Any]) -> bool:
    return cell["cell_type"] == "code" and ("qdot" in cell["metadata"] or cell.get("id") == "setup")


def _make_submitted_cell(cell: dict[str, Any], student: str) -> dict[str, Any]:
    part = cell["metadata"].get("qdot", {}).get("part")
    return {**cell, "outputs": [], **({"source": WRONG[part]} if student == "bo" and part in WRONG else {})}


def list_differences(archive: Path) -> list[str]:
    """Return the files of an archive that differ from those that this version writes."""
    with tempfile.TemporaryDirectory() as temporary:
        write_archive(rewritten := Path(temporary) / "archive")
        archived, current = _read_files(archive), _read_files(rewritten)
    return sorted(str(path) for path in archived.keys() | current.keys() if archived.get(path) != current.get(path))


def _read_files(folder: Path) -> dict[Path, bytes]:
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("release", nargs="?", default="")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    number = options.release.removeprefix("v")
    archive = ARCHIVES / (number or UNRELEASED)
    if options.check:
        differences = list_differences(archive)
        if number and differences:
            sys.exit(f"{archive.relative_to(ROOT)} differs from what this version writes: {', '.join(differences)}")
        print_result(f"{archive.name} is archived" if number else "a class of this version can be archived")
    elif number and archive.exists():
        sys.exit(f"{archive.relative_to(ROOT)} exists already; the archive of a release never changes")
    elif number and number != read_version(ROOT):
        sys.exit(f"this is version {read_version(ROOT)}; only it can be archived")
    else:
        write_archive(archive)
        print_result(f"wrote {archive.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
