"""A class that pushes right, wrong and blank notebooks, and its marks; shared by the runs for GitHub and GitLab."""

import json
import shutil
import subprocess
import venv
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment
from tests.platforms.notebooks import BLANK, KEY, RIGHT, WRONG, export_into, fill_in_answers, make_class_assignment
from tests.platforms.records import Count
from tests.support.ci import git, push_to_new_repository
from tests.support.git_server import Server, serve_repositories

OWNER, PUSH_TIME = "course", "2027-01-15T22:00:00Z"


@dataclass(frozen=True)
class PushedClass:
    """A class whose students have pushed to a server's repositories; jobs use the environment `python`."""

    assignment: Assignment
    exported: Path
    server: Server
    python: Path

    def clone(self, repository: str, to: Path, address: str) -> Path:
        git("clone", "--quiet", self.server.bare(f"{OWNER}/{repository}"), to)
        git("remote", "set-url", "origin", f"{address}{OWNER}/{repository}.git", cwd=to)
        return to


@contextmanager
def serve_pushed_class(export_format: str, work: Path) -> Iterator[PushedClass]:
    """Yield a class with one student for each kind of submission, whose notebooks have been exported and pushed."""
    assignment = make_class_assignment(work / KEY, (RIGHT, WRONG, BLANK))
    folder = export_into(assignment, export_format, work / "exported")
    venv.create(work / "python", with_pip=True)
    with serve_repositories(work / "server") as server:
        for student in assignment.roster:
            repository = folder / "students" / student.id
            files = {
                path.relative_to(repository).as_posix(): path.read_bytes()
                for path in repository.rglob("*")
                if path.is_file()
            }
            notebook = f"{KEY}.ipynb"
            files[notebook] = fill_in_answers(assignment, student.id, files[notebook].decode()).encode()
            server.push(f"{OWNER}/{KEY}-{student.id}", files, PUSH_TIME)
        shutil.copytree(folder / "grading", work / "grading")
        push_to_new_repository(work / "grading", server.folder, f"{OWNER}/{KEY}-grading")
        yield PushedClass(assignment, folder, server, work / "python")


def count_marks(pushed_class: PushedClass, graded: Path, log: str) -> dict[str, Count]:
    """Return counts of the marks in results.jsonl and of the feedback in the students' repositories.

    If there are no marks, raise an error with the end of the job's log.
    """
    if not (graded / "results.jsonl").exists():
        raise RuntimeError(f"no marks: {log[-3000:]}")
    lines = (graded / "results.jsonl").read_text(encoding="utf-8").splitlines()
    results = {result["student"]: result for result in map(json.loads, lines)}
    parts = {
        student: [part for problem in result["problems"] for part in problem["parts"]]
        for student, result in results.items()
    }
    feedback = {
        name: git("-C", pushed_class.server.bare(f"{OWNER}/{KEY}-{name}"), "show", "feedback:README.md")
        for name in parts
    }
    shown = [
        f"**{results[name]['score']:g} of {results[name]['max_score']:g} points**" in text
        for name, text in feedback.items()
    ]
    full = [part["points"] == part["max_points"] for part in parts[RIGHT]]
    less = [part["points"] < part["max_points"] for part in parts[WRONG]]
    zero = [part["points"] == 0 for part in parts[BLANK]]
    return {
        "shown": Count(sum(shown), len(shown)), "right = full": Count(sum(full), len(full)),
        "wrong < full": Count(sum(less), len(less)), "blank = 0": Count(sum(zero), len(zero)),
    }  # fmt: skip


def run_job(command: list[str | Path], cwd: Path, environment: dict[str, str]) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, errors="replace")
