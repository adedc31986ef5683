"""A class to grade: an assignment of three parts, and correct notebooks written by hand."""

import atexit
import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from functools import cache
from pathlib import Path
from typing import Any
from unittest.mock import patch

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import Certifier, init_assignment, release_notebooks
from qdot.exercises.assignment.store import load_stored_problems
from qdot.exercises.notebook.notebook import make_notebook_metadata
from qdot.exercises.problem.problem import Part, Problem, name_answer_variable
from qdot.grader.cli.demo import fill_in_answers
from qdot.grader.grading.batch import grade_class
from qdot.grader.grading.result import Result
from qdot.grader.sandbox import guarantees
from qdot.grader.sandbox.sandbox import Limits, Sandbox
from qdot.grader.submissions.submission import SubmissionFolder, find_submissions, open_submissions

TOML = """title = "T"
key = "hw"
[[problem]]
family = "planar-2r"
questions = ["position", "jacobian", "determinant"]
points = [1, 2, 1]
"""
PARTS = ("p1.position", "p1.jacobian", "p1.determinant")
ONE_STUDENT = (Student("s1"),)
Cells = list[dict[str, Any]]


def make_class(folder: Path, students: Sequence[Student] = ONE_STUDENT, toml: str = TOML) -> Assignment:
    """Make an assignment folder without releasing it, because a release takes longer than the tests themselves."""
    init_assignment(folder, "T", "hw", students, secret="0123456789abcdef")
    (folder / "assignment.toml").write_text(toml)
    return load_assignment(folder)


def _certify_nothing(_: Problem) -> None:
    """Accept every problem."""


def _write_certificate(assignment: Assignment, student: str, *_: object) -> str:
    return json.dumps({"notebook_digest": assignment.notebook_digest_of(student)})


UNCERTIFIED = Certifier(_certify_nothing, _write_certificate)
"""Replaces certificates in tests that don't read them, because certifying problems takes most of the time."""


def release_class(folder: Path, students: Sequence[Student], toml: str) -> Assignment:
    return release_notebooks(make_class(folder, students, toml), UNCERTIFIED, 1, lambda _: None)


def answer_notebook(
    assignment: Assignment, student: str, change: Callable[[str, Part], str] = lambda code, _: code
) -> str:
    text = (assignment.folder / "released" / student / "hw.ipynb").read_text()
    return fill_in_answers(text, load_stored_problems(assignment, student).problems, change)


@contextmanager
def work_in_one_process() -> Iterator[None]:
    """Do all work in this process and in one open sandbox, because starting either takes longer than grading."""
    with (
        patch("qdot.exercises.common.parallel._run_pool", _run_in_process),
        patch("qdot.grader.grading.batch.Sandbox", open_shared_sandbox),
        patch("qdot.grader.grading.batch._GradingWorker.close", lambda _: None),
        patch.object(guarantees, "probe", _probe if guarantees.probe is _probe.__wrapped__ else guarantees.probe),
    ):  # fmt: skip
        yield


_probe = cache(guarantees.probe)


def _run_in_process(
    work: Callable[[Any, Any], Any], setup: Callable[..., Any], arguments: tuple[Any, ...], items: Sequence[Any],
    jobs: int,
) -> Iterator[Any]:  # fmt: skip
    state = setup(*arguments)
    yield from (work(state, item) for item in items)


@contextmanager
def keep_sandboxes_open() -> Iterator[None]:
    """Let `check_notebook` and `grade_notebook` use the open sandbox, too."""

    def lend(limits: Limits | None = None, strict: bool = False, **_: object) -> Any:
        return nullcontext(open_shared_sandbox(limits or Limits(), strict))

    with patch("qdot.grader.grading.check.Sandbox", lend), patch("qdot.grader.grading.attempt.Sandbox", lend):
        yield


@cache
def open_shared_sandbox(limits: Limits, strict: bool) -> Sandbox:
    sandbox = Sandbox(limits, strict=strict)
    atexit.register(sandbox.close)
    return sandbox


def code_cell(source: str, part: str | None = None) -> dict[str, Any]:
    metadata = {"qdot": {"part": part}} if part else {}
    return {"cell_type": "code", "metadata": metadata, "source": source, "outputs": [], "execution_count": None}


def text_cell(source: str) -> dict[str, Any]:
    return {"cell_type": "markdown", "metadata": {}, "source": source}


def make_correct_cells(assignment: Assignment, student: str) -> Cells:
    (slot, problem), *_ = assignment.generate_problems(student)
    names = list(problem.symbols)
    cells = [
        text_cell("# T"),
        code_cell(f"from sympy import *\n{', '.join(names)} = symbols({' '.join(names)!r})\nblank = Symbol('blank')"),
    ]
    cells += [
        code_cell(f"{name_answer_variable(slot, p.name)} = {p.answer.write_code()}", f"{slot}.{p.name}")
        for p in problem.parts[:3]
    ]
    return cells


def write_notebook(assignment: Assignment, student: str, cells: Cells, **others: Any) -> str:
    metadata = make_notebook_metadata("student", assignment.key, student, assignment.generate_problems(student))
    return json.dumps({"cells": cells, "metadata": {"qdot": metadata}, "nbformat": 4, "nbformat_minor": 5, **others})


def make_correct_notebook(
    assignment: Assignment, student: str, change: Callable[[Cells], Any] = lambda cells: None
) -> str:
    """Return a notebook in which every answer is correct; `change` may edit its cells in place."""
    cells = make_correct_cells(assignment, student)
    change(cells)
    return write_notebook(assignment, student, cells)


def submit(assignment: Assignment, name: str, content: str | bytes) -> Path:
    path = assignment.folder / "submitted" / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def answer_and_submit(assignment: Assignment, student: str, *change: Callable[[str, Part], str]) -> Path:
    """Submit a released notebook with answers, as `answer_notebook` returns it."""
    return submit(assignment, f"{student}/hw.ipynb", answer_notebook(assignment, student, *change))


def grade(
    assignment: Assignment, submissions: Path | None = None, seconds: float = 20
) -> tuple[dict[str, Result], SubmissionFolder]:
    """Grade all students; return their results, and the submissions that were found."""
    with open_submissions(submissions or assignment.folder / "submitted") as root, work_in_one_process():
        submissions_found = find_submissions(assignment, root)
        limits = Limits(seconds=seconds, cell_seconds=4)
        results = grade_class(assignment, submissions_found.by_student, 0, limits, lambda _: None)
    return {result.student: result for result in results}, submissions_found


def find_stored_marks(folder: Path) -> dict[Path, int]:
    """Return the stored marks of a graded class with the times at which they were written."""
    return {path: path.stat().st_mtime_ns for path in (folder / "graded" / ".cache").glob("[!.]*.json")}


def read_folder(folder: Path) -> dict[str, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def list_outcomes(result: Result) -> list[str]:
    return [part.outcome for part in result.parts.values()]


def list_reasons(result: Result) -> list[str]:
    return [part.reason for part in result.parts.values()]


ALL_CORRECT = ["correct"] * 3
