"""An assignment's folder made new, and its notebooks written, one for the student and one for the staff."""

import os
import secrets
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from exercises.assignment import SECRET_FILE, Assignment, Student
from exercises.errors import QdotError
from exercises.files import write_atomically
from exercises.notebook import notebook_text, solution_notebook, student_notebook
from exercises.parallel import ordered_map
from exercises.render import render

EXAMPLE_STUDENTS = (Student("s001", "Ada Example", "ada@example.org"), Student("s002", "Bo Example", "bo@example.org"))


def init_assignment(
    folder: Path, title: str, key: str, students: Sequence[Student] = EXAMPLE_STUDENTS, secret: str | None = None
) -> None:
    """Make a new assignment folder. Raises QdotError where one is there already: nothing is overwritten."""
    names = ("assignment.toml", "roster.csv", ".gitignore", SECRET_FILE, "README.md")
    there = [name for name in names if (folder / name).exists()]
    if there:
        raise QdotError(f"{folder} has {', '.join(there)} already; name a new folder")
    context = {"title": title, "key": key, "students": students, "secret_file": SECRET_FILE}
    try:
        write_atomically(folder / SECRET_FILE, (secret or secrets.token_hex(32)) + "\n", mode=0o600)
        write_atomically(folder / "roster.csv", render("init/roster.csv.j2", **context))
        write_atomically(folder / ".gitignore", render("init/gitignore.j2", **context))
        write_atomically(folder / "README.md", render("init/README.md.j2", **context))
        write_atomically(folder / "assignment.toml", render("init/assignment.toml.j2", **context))
    except OSError as error:
        raise QdotError(f"{folder} can't be written: {error.strerror}") from None


@dataclass(frozen=True)
class Released:
    """What became of one student's notebooks: "written", "kept" (up to date already) or "rewritten"."""

    student: str
    outcome: str


def _paths(assignment: Assignment, student: str) -> tuple[Path, Path]:
    name = f"{assignment.key}.ipynb"
    return assignment.folder / "released" / student / name, assignment.folder / "solutions" / student / name


def release_one(assignment: Assignment, student: str) -> Released:
    """Write both notebooks of one student, unless they are there and made from this very assignment."""
    paths = _paths(assignment, student)
    if all(_made_from(path, assignment.digest) for path in paths):
        return Released(student, "kept")
    outcome = "rewritten" if any(path.exists() for path in paths) else "written"
    problems = assignment.problems(student)
    for path, make in zip(paths, (student_notebook, solution_notebook), strict=True):
        notebook = make(assignment.title, assignment.key, student, problems)
        notebook.metadata["qdot"]["digest"] = assignment.digest
        write_atomically(path, notebook_text(notebook))
    return Released(student, outcome)


def _made_from(path: Path, digest: str) -> bool:
    try:
        return f'"digest": "{digest}"' in path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return False


def release(assignment: Assignment, jobs: int, each: Callable[[Released], None]) -> None:
    """Write the notebooks of the whole class on `jobs` processes; `each` is told of every student's in roster order.

    A rerun after a stop goes on where it was: what is up to date is kept.
    """
    students = [student.id for student in assignment.roster]
    for released in ordered_map(_release_here, students, jobs, _start_worker, (assignment,)):
        each(released)


_assignment: Assignment | None = None


def _start_worker(assignment: Assignment) -> None:
    global _assignment  # noqa: PLW0603 - set once when a worker process starts
    _assignment = assignment


def _release_here(student: str) -> Released:
    assert _assignment is not None
    return release_one(_assignment, student)


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


CORES = _cores()
"""The number of cores that this process may use."""
