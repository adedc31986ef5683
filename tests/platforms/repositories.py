"""Shared by the runs of GitHub's and GitLab's jobs: a class that pushes notebooks, and its marks."""

import json
import shutil
import subprocess
import venv
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment
from tests.platforms.notebooks import BLANK, KEY, RIGHT, WRONG, a_class, answered, exported
from tests.platforms.records import Count
from tests.support.ci import git, push_to_new_repository
from tests.support.git_server import Server, serve_repositories

OWNER, PUSHED = "course", "2027-01-15T22:00:00Z"


@dataclass(frozen=True)
class Class:
    """A class whose students have pushed to a server's repositories; `python` is the Python that jobs use."""

    assignment: Assignment
    exported: Path
    server: Server
    python: Path

    def clone(self, repository: str, to: Path, address: str) -> Path:
        """Clone a repository under its address on the platform."""
        git("clone", "--quiet", self.server.bare(f"{OWNER}/{repository}"), to)
        git("remote", "set-url", "origin", f"{address}{OWNER}/{repository}.git", cwd=to)
        return to


@contextmanager
def pushed(export_format: str, work: Path) -> Iterator[Class]:
    """Yield a class with one student for each kind of answer, exported and pushed."""
    assignment = a_class(work / KEY, RIGHT, WRONG, BLANK)
    made = exported(assignment, export_format, work / "exported")
    venv.create(work / "python", with_pip=True)
    with serve_repositories(work / "server") as server:
        for student in assignment.roster:
            own = made / "students" / student.id
            files = {path.relative_to(own).as_posix(): path.read_bytes() for path in own.rglob("*") if path.is_file()}
            notebook = f"{KEY}.ipynb"
            files[notebook] = answered(assignment, student.id, files[notebook].decode()).encode()
            server.push(f"{OWNER}/{KEY}-{student.id}", files, PUSHED)
        shutil.copytree(made / "grading", work / "grading")
        push_to_new_repository(work / "grading", server.folder, f"{OWNER}/{KEY}-grading")
        yield Class(assignment, made, server, work / "python")


def counts(own: Class, graded: Path, said: str) -> dict[str, Count]:
    """Return what the class was given: the marks in results.jsonl, and each student's own feedback.

    A job that left no marks tells why in what it `said`.
    """
    if not (graded / "results.jsonl").exists():
        raise RuntimeError(f"no marks: {said[-3000:]}")
    lines = (graded / "results.jsonl").read_text(encoding="utf-8").splitlines()
    results = {result["student"]: result for result in map(json.loads, lines)}
    parts = {
        student: [part for problem in result["problems"] for part in problem["parts"]]
        for student, result in results.items()
    }
    told = {name: git("-C", own.server.bare(f"{OWNER}/{KEY}-{name}"), "show", "feedback:README.md") for name in parts}
    shown = [
        f"**{results[name]['score']:g} of {results[name]['max_score']:g} points**" in text
        for name, text in told.items()
    ]
    full = [part["points"] == part["max_points"] for part in parts[RIGHT]]
    less = [part["points"] < part["max_points"] for part in parts[WRONG]]
    nothing = [part["points"] == 0 for part in parts[BLANK]]
    return {
        "shown": Count(sum(shown), len(shown)), "right = full": Count(sum(full), len(full)),
        "wrong < full": Count(sum(less), len(less)), "blank = 0": Count(sum(nothing), len(nothing)),
    }  # fmt: skip


def ran(command: list[str | Path], cwd: Path, environment: dict[str, str]) -> subprocess.CompletedProcess[str]:
    """Run a job by its runner."""
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, errors="replace")
