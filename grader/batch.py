"""Grade a class: every student's notebook run, read, compared and marked, on several processes, resumable.

Each student's result is kept in graded/.cache as soon as it is there, under a key made of the submission, the
assignment, and the versions of problems and grader; a rerun takes from there what has not changed.
"""

import contextlib
import datetime
import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

from exercises.assignment import Assignment
from exercises.errors import QdotError
from exercises.files import cannot_write, make_folder, remove_left_behind, write_atomically
from exercises.parallel import ordered_map
from exercises.problem import Problem, variable
from grader.copies import Copies
from grader.functions import asked_of
from grader.marking import mark, total
from grader.parts import domain_of
from grader.sandbox import Limits, Run, Sandbox
from grader.submission import (
    Found,
    Note,
    Submission,
    Unreadable,
    cell_of,
    oddities,
    read_submission,
    wrong_assignment,
)  # fmt: skip

GRADER = 1
"""Version of the grader: any change of what a submission earns raises it."""

Result = dict[str, Any]


@dataclass(frozen=True)
class Task:
    """One student to grade."""

    student: str
    found: Found | None


def grade_class(
    assignment: Assignment, submissions: dict[str, Found], jobs: int, limits: Limits, each: Callable[[Result], None]
) -> list[Result]:
    """Grade everybody on the roster and return the results in its order; `each` is told of every one as it comes.

    Raises QdotError where another grader is at work in the same folder.
    """
    tasks = [Task(student.id, submissions.get(student.id)) for student in assignment.roster]
    cache = assignment.folder / "graded" / ".cache"
    make_folder(cache)
    remove_left_behind(_kept(cache, task.student) for task in tasks)
    results = []
    with (
        _alone(cache / "lock"),
        contextlib.closing(ordered_map(_grade, tasks, jobs, _Desk, (assignment, limits, cache))) as every,
    ):
        for result in every:
            results.append(result)
            each(result)
    return results


@contextlib.contextmanager
def _alone(lock: Path) -> Any:
    """Hold a lock that the system lets go of when this process ends, however it ends."""
    import fcntl

    try:
        file = lock.open("w")
    except OSError as error:
        raise cannot_write(lock, error) from None
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise QdotError(
                f"{lock.parent.parent} is being graded by another 'qdot grade'; wait until it is done"
            ) from None
        yield


class _Desk:
    """What a process has on its desk while it grades: the assignment, a sandbox, the folder of what is graded."""

    def __init__(self, assignment: Assignment, limits: Limits, cache: Path) -> None:
        self.assignment, self.sandbox, self.cache = assignment, Sandbox(limits), cache
        self.copies = Copies(assignment)

    def close(self) -> None:
        self.sandbox.close()


def _grade(desk: _Desk, task: Task) -> Result:
    assignment, sandbox, cache = desk.assignment, desk.sandbox, desk.cache
    kept = _kept(cache, task.student)
    key = _cache_key(assignment, task)
    try:
        stored = json.loads(kept.read_text(encoding="utf-8"))
        if stored["key"] == key:
            result: Result = stored["result"]
            return result
    except (OSError, ValueError, KeyError, TypeError):
        pass  # nothing kept yet, or damaged: grade
    result = grade_student(assignment, task.student, task.found, sandbox, desk.copies)
    write_atomically(kept, json.dumps({"key": key, "result": result}))
    return result


def _kept(cache: Path, student: str) -> Path:
    """Return where the result of a student is kept."""
    return cache / f"{hashlib.sha256(student.encode()).hexdigest()[:24]}.json"


def _cache_key(assignment: Assignment, task: Task) -> str:
    content = hashlib.sha256(f"{assignment.edition}/{GRADER}/{assignment.marking}/{task.student}".encode())
    for path in task.found.files if task.found else ():
        with contextlib.suppress(OSError):
            content.update(f"{path.name}/{int(path.stat().st_mtime)}/".encode() + path.read_bytes())
    return content.hexdigest()


def grade_student(
    assignment: Assignment, student: str, found: Found | None, sandbox: Sandbox, copies: Copies
) -> Result:
    """Grade one student: regenerate the problems from the assignment, run the notebook, mark every part."""
    problems = assignment.problems(student)
    if found is None:
        return _result(assignment, copies, student, problems, None, Run(), "nothing was handed in", [])
    notes = [Note(found.note, found.note)] if found.note else []
    try:
        submission = read_submission(found.files[0])
    except Unreadable as error:
        return _result(assignment, copies, student, problems, None, Run(), str(error), notes, found.files[0])
    obstacle = wrong_assignment(submission, assignment)
    if obstacle is not None:
        return _result(assignment, copies, student, problems, submission, Run(), obstacle, notes)
    names = [variable(slot, part.name) for slot, problem in problems for part in problem.parts]
    seed = _points_seed(assignment, submission)
    asked = {slot: asked_of(problem, domain_of(problem), seed) for slot, problem in problems}
    run = sandbox.run(submission.cells, names, asked)
    notes += oddities(submission, assignment, student)
    if run.note:
        notes.append(Note(run.note, run.note))
    return _result(assignment, copies, student, problems, submission, run, None, notes)


def _result(
    assignment: Assignment, copies: Copies, student: str, problems: Sequence[tuple[str, Problem]],
    submission: Submission | None,
    run: Run, obstacle: str | None, notes: Sequence[Note], file: Path | None = None,
) -> Result:  # fmt: skip
    marked: list[dict[str, Any]] = []
    of_another = submission is not None and submission.claims.get("student") not in (None, student)
    credit = Fraction(0) if of_another else assignment.follow_through
    for slot, problem in problems:
        reasons = {}
        for part in problem.parts:
            name = variable(slot, part.name)
            reasons[name] = obstacle or _why_missing(submission, run, slot, part.name)
        seed = _points_seed(assignment, submission)
        is_copied = partial(copies.is_right_for_another, problem, slot)
        verdicts = mark(problem, slot, run.answers, reasons, assignment.secret, seed, credit, is_copied)
        marked.append({"id": str(problem.id), "slot": slot, "parts": [verdict.as_json() for verdict in verdicts]})
    parts = [part for problem in marked for part in problem["parts"]]
    return {
        "student": student,
        "assignment": assignment.key,
        "submission": _submission_json(submission, file),
        "score": total(part["points"] for part in parts),
        "max_score": total(part["max_points"] for part in parts),
        "late": _late(assignment, submission),
        "obstacle": obstacle,
        "notes": [note.student for note in notes if note.student],
        "staff_notes": [note.staff for note in notes],
        "problems": marked,
    }


def _points_seed(assignment: Assignment, submission: Submission | None) -> str:
    """Return what draws the points at which functions are called: others for every submission that differs."""
    return f"{assignment.secret}/{submission.sha256 if submission is not None else ''}"


def _why_missing(submission: Submission | None, run: Run, slot: str, part: str) -> str:
    name = variable(slot, part)
    if name in run.failures:
        return f"{name} has no value that can be read: {run.failures[name]}"
    cell = cell_of(submission, slot, part) if submission is not None else None
    if cell is not None and cell in run.cell_errors:
        return f"its cell stopped: {run.cell_errors[cell]}"
    if run.note:
        return run.note
    return f"{name} is not set anywhere in the notebook" if cell is None else f"its cell does not set {name}"


def _submission_json(submission: Submission | None, file: Path | None) -> dict[str, Any] | None:
    if submission is None:
        return None if file is None else {"file": file.name, "sha256": None, "received": None}
    return {"file": submission.file.name, "sha256": submission.sha256, "received": submission.received.isoformat()}


def _late(assignment: Assignment, submission: Submission | None) -> dict[str, Any] | None:
    """Return by how much a submission is late, by the time of its file; no points are taken off."""
    if assignment.due is None or submission is None:
        return None
    due = assignment.due if assignment.due.tzinfo else assignment.due.astimezone()
    late = submission.received - due
    if late <= datetime.timedelta(0):
        return None
    return {"due": due.isoformat(), "received": submission.received.isoformat(), "seconds": int(late.total_seconds())}
