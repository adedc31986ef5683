"""Grade a class: every student's notebook run, read, compared and marked, on several processes, resumable.

What the grader gives for a notebook is kept in graded/.cache as soon as it is there, under a key made of the
submission, the assignment, and the versions of problems and grader; a rerun takes from there what has not changed.
"""

import contextlib
import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from exercises.assignment import Assignment, Student
from exercises.errors import QdotError
from exercises.files import cannot_write, make_folder, remove_left_behind, write_atomically
from exercises.parallel import ordered_map
from grader.attempt import Attempt, Marked, grade_attempt, is_graded, made_from, read_attempts, ungraded
from grader.copies import Copies
from grader.overrides import read_overrides
from grader.sandbox import Limits, Sandbox
from grader.settle import Graded, Result, settle
from grader.submission import Found

DIED = "its process was ended twice by the system, probably for want of memory"


@dataclass(frozen=True)
class Task:
    """One student to grade."""

    student: str
    found: Found | None


def grade_class(
    assignment: Assignment,
    submissions: dict[str, Found],
    jobs: int,
    limits: Limits,
    each: Callable[[Result], None],
    students: Sequence[Student] | None = None,
) -> list[Result]:
    """Grade everybody on the roster, or these `students`, and return the results in that order, telling `each` of them.

    Without jobs, everything is done in this process, and whatever ends it ends the grading. Else it costs one student
    a mark until the next run, who is UNGRADED. Raises QdotError, also for a mistake in overrides.csv.
    """
    overrides = read_overrides(assignment)
    students = assignment.roster if students is None else students
    tasks = [Task(student.id, submissions.get(student.id)) for student in students]
    cache = cache_of(assignment)
    make_folder(cache)
    remove_left_behind(path for task in tasks for path in _all_kept(cache, task))
    lost = partial(_lost, assignment) if jobs else None
    results = []
    with contextlib.closing(ordered_map(_grade, tasks, jobs, _Desk, (assignment, limits, cache), lost)) as every:
        for student, handed_in in zip(students, every, strict=True):
            results.append(settle(assignment, student, handed_in, overrides.get(student.id, {})))
            each(results[-1])
    return results


def cache_of(assignment: Assignment) -> Path:
    """Return the folder in which is kept what has been graded."""
    return assignment.folder / "graded" / ".cache"


@contextlib.contextmanager
def alone(assignment: Assignment) -> Iterator[None]:
    """Be the only one who grades in the assignment's folder. Raises QdotError where another grader is at work there.

    The lock is one that the system lets go of when this process ends, however it ends.
    """
    import fcntl

    lock = cache_of(assignment) / "lock"
    make_folder(lock.parent)
    try:
        file = lock.open("a")
    except OSError as error:
        raise cannot_write(lock, error) from None
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise QdotError(
                f"{lock.parent.parent} is being graded by another 'qdot grade'; wait until it is done"
            ) from None
        except OSError:
            pass  # a disk that knows no locks: files are written whole all the same
        yield


class _Desk:
    """What a process has on its desk while it grades: the assignment, a sandbox, the folder of what is graded."""

    def __init__(self, assignment: Assignment, limits: Limits, cache: Path) -> None:
        self.assignment, self.sandbox, self.cache = (
            assignment,
            Sandbox(limits, strict=assignment.sandbox == "strict"),
            cache,
        )
        self.copies = Copies(assignment)

    def close(self) -> None:
        self.sandbox.close()


def _grade(desk: _Desk, task: Task) -> list[Graded]:
    """Return everything that a student handed in, in the order in which it was received; what counts is marked."""
    if task.found is None:
        return [Graded(marked=_marked(desk, task.student, None))]
    attempts = read_attempts(task.found, desk.assignment.key)
    counting = _counting(desk.assignment, attempts)
    return [
        Graded(
            one.file.name,
            one.received,
            _marked(desk, task.student, one) if one in counting else None,
            *(("file", None) if one.submission is None else (one.submission.received_from, one.submission.late)),
        )
        for one in sorted(attempts, key=lambda one: one.received)
    ]


def _counting(assignment: Assignment, attempts: list[Attempt]) -> list[Attempt]:
    """Return the notebooks to grade; `attempts` come as `find_submissions` orders them.

    Where any has the assignment's name, or names it in its metadata, the others are no attempts. The last is the one
    received last; of those received in the same second, the first in that order.
    """
    own = [one for one in attempts if one.is_of(assignment)] or attempts
    return own if assignment.attempts == "best" else [max(own, key=lambda one: one.received)]


def _marked(desk: _Desk, student: str, attempt: Attempt | None) -> Marked:
    """Return what the grader gives for a notebook, from what is kept where that is still right.

    What qdot failed on is not kept: the next run tries again.
    """
    kept = _kept(desk.cache, student, None if attempt is None else attempt.file)
    key = _key(desk, student, attempt)
    try:
        stored = json.loads(kept.read_text(encoding="utf-8"))
        if stored["key"] == key:
            marked: Marked = stored["marked"]
            return marked
    except (OSError, ValueError, KeyError, TypeError):
        pass  # nothing kept yet, or damaged: grade
    try:
        marked = grade_attempt(desk.assignment, student, attempt, desk.sandbox, desk.copies)
    except QdotError:
        raise
    except Exception as error:  # our own failure, whatever it is, must neither become a mark nor stop the class
        return ungraded(desk.assignment, student, attempt, f"{type(error).__name__}: {str(error)[:300]}")
    if is_graded(marked):
        write_atomically(kept, json.dumps({"key": key, "marked": marked}))
    return marked


def _lost(assignment: Assignment, task: Task) -> list[Graded]:
    """Return what stands for a student whose notebook ended every process that was to grade it."""
    file = "" if task.found is None else task.found.files[0].name
    return [Graded(file, marked=ungraded(assignment, task.student, None, DIED))]


def _kept(cache: Path, student: str, file: Path | None) -> Path:
    """Return where the result of a student's notebook is kept."""
    named = "" if file is None else f"{file.name}/{file.parent.name == student}"
    return cache / f"{hashlib.sha256(f'{student}/{named}'.encode()).hexdigest()[:24]}.json"


def _all_kept(cache: Path, task: Task) -> list[Path]:
    return [_kept(cache, task.student, file) for file in (task.found.files if task.found else (None,))]


def _key(desk: _Desk, student: str, attempt: Attempt | None) -> str:
    """Return a text that changes whenever what a notebook earns may change; also when it may take longer."""
    handed_in = "" if attempt is None else f"{attempt.file.name}/{attempt.fingerprint}/{desk.sandbox.limits}"
    content = f"{json.dumps(made_from(desk.assignment))}/{student}/{handed_in}"
    return hashlib.sha256(content.encode("utf-8", "replace")).hexdigest()
