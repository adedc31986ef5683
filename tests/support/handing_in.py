"""A class that hands in: an assignment of three parts, right notebooks made by hand, and everybody graded."""

import atexit
import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any
from unittest.mock import patch

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import Certifier, init_assignment
from qdot.exercises.notebook.notebook import make_notebook_metadata
from qdot.exercises.problem.problem import Problem, name_answer_variable
from qdot.grader.grading.batch import grade_class
from qdot.grader.grading.result import Result
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
Cells = list[dict[str, Any]]


def a_class(folder: Path, students: Sequence[Student]) -> Assignment:
    """Make an assignment folder without releasing it: that takes longer than all that is tested here."""
    init_assignment(folder, "T", "hw", students, secret="0123456789abcdef")
    (folder / "assignment.toml").write_text(TOML)
    return load_assignment(folder)


def _record(_: Problem) -> None:
    """Vouch for everything."""


def _text(assignment: Assignment, student: str, *_: object) -> str:
    return json.dumps({"edition": assignment.notebook_digest_of(student)})


UNCERTIFIED = Certifier(_record, _text)
"""Stands for certificates where nobody reads them: to prove the problems takes ten times as long as all else."""


@contextmanager
def one_process() -> Iterator[None]:
    """Do all work in this process and in one sandbox, kept open: to start either takes longer than a notebook."""
    with (
        patch("qdot.exercises.common.parallel._run_pool", _done_here),
        patch("qdot.grader.grading.batch.Sandbox", _sandbox),
        patch("qdot.grader.grading.batch._GradingWorker.close", lambda _: None),
    ):  # fmt: skip
        yield


def _done_here(
    work: Callable[[Any, Any], Any], setup: Callable[..., Any], arguments: tuple[Any, ...], items: Sequence[Any],
    jobs: int, chunk: int,
) -> Iterator[Any]:  # fmt: skip
    state = setup(*arguments)
    yield from (work(state, item) for item in items)


@cache
def _sandbox(limits: Limits, strict: bool) -> Sandbox:
    made = Sandbox(limits, strict=strict)
    atexit.register(made.close)
    return made


def code(source: str, part: str | None = None) -> dict[str, Any]:
    metadata = {"qdot": {"part": part}} if part else {}
    return {"cell_type": "code", "metadata": metadata, "source": source, "outputs": [], "execution_count": None}


def text(source: str, kind: str = "markdown") -> dict[str, Any]:
    return {"cell_type": kind, "metadata": {}, "source": source}


def right_cells(assignment: Assignment, student: str) -> Cells:
    """Return cells 1 to 5: a heading, the set-up, and the three answers."""
    ((slot, problem),) = assignment.generate_problems(student)
    names = list(problem.symbols)
    cells = [
        text("# T"),
        code(f"from sympy import *\n{', '.join(names)} = symbols({' '.join(names)!r})\nblank = Symbol('blank')"),
    ]
    cells += [
        code(f"{name_answer_variable(slot, p.name)} = {p.answer.write_code()}", f"{slot}.{p.name}")
        for p in problem.parts
    ]
    return cells


def notebook(assignment: Assignment, student: str, cells: Cells, **others: Any) -> str:
    """Return a notebook's text, with the metadata that qdot writes."""
    said = make_notebook_metadata("student", assignment.key, student, assignment.generate_problems(student))
    return json.dumps({"cells": cells, "metadata": {"qdot": said}, "nbformat": 4, "nbformat_minor": 5, **others})


def right(assignment: Assignment, student: str, change: Callable[[Cells], Any] = lambda cells: None) -> str:
    """Return a right notebook, its cells changed in place."""
    cells = right_cells(assignment, student)
    change(cells)
    return notebook(assignment, student, cells)


def hand_in(assignment: Assignment, name: str, content: str | bytes) -> Path:
    path = assignment.folder / "submitted" / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def grade(
    assignment: Assignment, submissions: Path | None = None, seconds: float = 20
) -> tuple[dict[str, Result], SubmissionFolder]:
    """Return everybody's result, and what was found."""
    with open_submissions(submissions or assignment.folder / "submitted") as root, one_process():
        looked = find_submissions(assignment, root)
        results = grade_class(assignment, looked.by_student, 0, Limits(seconds=seconds, cell_seconds=4), lambda _: None)
    return {result.student: result for result in results}, looked


def contents(folder: Path) -> dict[str, bytes]:
    """Return what is in a folder, by the names of its files."""
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def outcomes(result: Result) -> list[str]:
    return [part.outcome for part in result.parts.values()]


def reasons(result: Result) -> list[str]:
    return [part.reason for part in result.parts.values()]


RIGHT = ["correct"] * 3
