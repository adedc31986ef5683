"""Classes whose notebooks are graded by `make bench`, and the floor of grading them (tests/bench/floor)."""

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import init_assignment, release_notebooks
from qdot.exercises.assignment.store import load_stored_problems
from qdot.grader.cli.demo import EDITS, fill_in_answers
from qdot.grader.grading.certify import CERTIFIER
from qdot.grader.submissions.cells import empty_self_checks
from qdot.grader.submissions.submission import find_submissions, read_submission

SLOT = """
[[problem]]
family = "planar-2r"
questions = ["position", "jacobian", "determinant", "inverse-velocity", "singular-angles"]
"""
MIX = (
    "right", "right, in another form", "right", "wrong sign throughout", "right", "relative for absolute angles",
    "right, in another form", "matrices transposed", "joint 2 forgotten", "only the first condition",
    "half of it", "blank",
)  # fmt: skip
"""The kinds of notebooks in a class. Endless loops are excluded, because they always use the whole limit."""


def a_class(folder: Path, size: int) -> Assignment:
    init_assignment(folder, "Bench", "bench", [Student(f"s{n:05d}") for n in range(size)], "a secret, long enough")
    file = folder / "assignment.toml"
    file.write_text(file.read_text("utf-8").split("\n[[problem]]")[0] + SLOT, encoding="utf-8")
    assignment = load_assignment(folder)
    release_notebooks(assignment, CERTIFIER, 2, lambda _: None)
    return assignment


def hand_in(assignment: Assignment, target: Path, kinds: Sequence[str]) -> None:
    target.mkdir()
    for number, student in enumerate(assignment.roster):
        text = (assignment.folder / "released" / student.id / f"{assignment.key}.ipynb").read_text("utf-8")
        kind = kinds[number % len(kinds)]
        if kind in EDITS:
            text = fill_in_answers(text, load_stored_problems(assignment, student.id).problems, EDITS[kind])
        (target / f"{student.id}.ipynb").write_text(text, encoding="utf-8")


def floor(assignment: Assignment, submissions: Path, checked: bool = True) -> list[tuple[float, float]]:
    """Return wall and processor time of the bare cells of every notebook, its checks of itself among them or not.

    Grading leaves these out.
    """
    notebooks = []
    for name, found in find_submissions(assignment, submissions).by_student.items():
        cells = read_submission(found.files[0]).cells
        kept_cells = cells if checked else empty_self_checks(cells, load_stored_problems(assignment, name).problems)
        notebooks.append([cell.source for cell in kept_cells if cell.is_code])
    command = [sys.executable, "-m", "tests.bench.floor"]
    done = subprocess.run(command, input=json.dumps(notebooks), capture_output=True, text=True, check=True)
    times: list[tuple[float, float]] = json.loads(done.stdout)
    return times
