"""Grade a class: every notebook run, read, compared and marked, on several processes or machines, resumable.

What the grader gives for a notebook is kept in graded/.cache as soon as it is there, under a key made of the
submission, the assignment, and the versions of problems and grader; a rerun takes from there what has not changed.
"""

import contextlib
import csv
import hashlib
import io
import json
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.common.errors import QdotError, of_machine
from qdot.exercises.common.files import (
    cannot_write,
    clean_up_after,
    flush_disk_after,
    lock,
    make_folder,
    write_atomically,
)
from qdot.exercises.common.json_form import as_json, from_json
from qdot.exercises.common.parallel import ordered_map
from qdot.grader.grading.attempt import (
    Attempt,
    describe_error,
    grade_safely,
    made_from,
    mark_ungraded,
    read_attempts,
)
from qdot.grader.grading.copied_answers import Copies
from qdot.grader.grading.final_result import Graded, settle
from qdot.grader.grading.overrides import Overrides, read_overrides
from qdot.grader.grading.remote import Order, brief_of, graded_by, order_of
from qdot.grader.grading.result import Marked, Result
from qdot.grader.sandbox.sandbox import Limits, Sandbox
from qdot.grader.submissions.cells import printable_name
from qdot.grader.submissions.submission import StudentFiles

DIED = "its process was ended twice by the system, probably for want of memory"

WritePage = Callable[[Assignment, Student, Result], None]

ROOM = 64
"""Notebooks that are out at a time with an executor of which nothing else is known."""


@dataclass(frozen=True)
class Task:
    """One student to grade."""

    student: str
    found: StudentFiles | None


def grade_class(
    assignment: Assignment,
    submissions: dict[str, StudentFiles],
    jobs: int,
    limits: Limits,
    each: Callable[[Result], None],
    students: Sequence[Student] | None = None,
    executor: Executor | None = None,
    room: Callable[[], int] = lambda: ROOM,
    write_page: WritePage | None = None,
) -> list[Result]:
    """Grade everybody on the roster, or these `students`, and return the results in that order, telling `each` of them.

    Without jobs, everything is done in this process, and whatever ends it ends the grading. Else it costs one student
    a mark until the next run, who is UNGRADED. An `executor` runs the notebooks in the place of jobs, at most `room()`
    of them being out at a time, while this process reads them and keeps what they earn. With `students`, only these of
    the roster are graded. The process that has marked a notebook writes its page by `write_page`, for it has all of it
    at hand; of what others marked (the executor, an earlier run), and where it fails, the page is left to the caller.
    Raises QdotError, also for a mistake in overrides.csv.
    """
    overrides = read_overrides(assignment)
    chosen = assignment.roster if students is None else students
    tasks = [Task(student.id, submissions.get(student.id)) for student in chosen]
    shelf = _Shelf(assignment, limits, cache_of(assignment))
    make_folder(shelf.folder)
    results: dict[int, Result] = {}
    costs: list[tuple[str, str, str]] = [("student", "seconds", "megabytes")]

    def settled(place: int, handed_in: list[Graded]) -> None:
        student = chosen[place]
        results[place] = _settle(assignment, student, handed_in, overrides)
        costs.append(_cost(student, handed_in))
        now_and_then()
        each(results[place])

    kept = (path for task in tasks for path in _kept_paths(shelf.folder, task))
    with clean_up_after(kept), flush_disk_after(shelf.folder) as now_and_then:
        if executor is not None:
            _grade_elsewhere(shelf, tasks, executor, room, settled)
        else:
            lost = partial(_mark_failed, assignment) if jobs else None
            context = (shelf, overrides, write_page)
            with contextlib.closing(ordered_map(_grade, tasks, jobs, _Context, context, lost)) as every:
                for place, handed_in in enumerate(every):
                    settled(place, handed_in)
    if chosen == assignment.roster:
        table = io.StringIO()
        csv.writer(table, lineterminator="\n").writerows(costs)
        write_atomically(assignment.folder / "graded" / "costs.csv", table.getvalue(), 0o600)
    return [results[place] for place in range(len(tasks))]


def _cost(student: Student, handed_in: Sequence[Graded]) -> tuple[str, str, str]:
    """Return what it took to grade a student in this run: seconds of processor time, and megabytes."""
    costs = [graded.marked.cost for graded in handed_in if graded.marked and graded.marked.cost]
    seconds, most = sum(cost.seconds for cost in costs), max((cost.bytes for cost in costs), default=0)
    return student.id, f"{seconds:.2f}", f"{most / 1e6:.0f}"


def cache_of(assignment: Assignment) -> Path:
    """Return the folder in which is kept what has been graded."""
    return cache_in(assignment.folder)


def cache_in(folder: Path) -> Path:
    """Return the same of an assignment's folder."""
    return folder / "graded" / ".cache"


@contextlib.contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Be the only one who grades in an assignment's folder. Raises QdotError where another grader is at work there.

    The lock is one that the system lets go of when this process ends, however it ends.
    """
    path = cache_in(folder) / "lock"
    make_folder(path.parent)
    try:
        file = path.open("a+")  # NFS gives no lock for several to who does not read
    except OSError as error:
        raise cannot_write(path, error) from None
    with file, _of_this_process(file.fileno()):
        try:
            lock(file.fileno(), wait=False)
        except BlockingIOError:
            raise QdotError(
                f"{path.parent.parent} is being graded by another 'qdot grade'; wait until it is done"
            ) from None
        except OSError:
            pass  # a disk that knows no locks: files are written whole all the same
        yield


_own: set[int] = set()
"""Open files that no process forked from this one is to have: its lock would outlive it there."""


@contextlib.contextmanager
def _of_this_process(descriptor: int) -> Iterator[None]:
    _own.add(descriptor)
    try:
        yield
    finally:
        _own.discard(descriptor)


def _let_go() -> None:
    while _own:
        os.close(_own.pop())


if hasattr(os, "register_at_fork"):  # elsewhere nothing is forked
    os.register_at_fork(after_in_child=_let_go)


@dataclass(frozen=True)
class _Kept:
    """A file of graded/.cache: what a notebook was given, and the key of all that this depends on."""

    key: str
    marked: Marked


@dataclass(frozen=True)
class _Shelf:
    """What the grader gave for notebooks, kept in a folder."""

    assignment: Assignment
    limits: Limits
    folder: Path

    def take(self, student: str, attempt: Attempt | None) -> Marked | None:
        """Return what is kept for a notebook, None where it is not there or may not be right any more."""
        try:
            kept = from_json(_Kept, self._path(student, attempt).read_bytes())
        except (OSError, ValueError):
            return None  # nothing kept yet, or damaged
        return kept.marked if kept.key == self._key(student, attempt) else None

    def put(self, student: str, attempt: Attempt | None, marked: Marked) -> None:
        """Keep what the grader gives for a notebook. What qdot failed on is not kept: the next run tries again."""
        if marked.is_graded:
            kept = _Kept(self._key(student, attempt), replace(marked, cost=None))  # the same in every run
            write_atomically(self._path(student, attempt), json.dumps(as_json(kept)), lasting=False)

    def _path(self, student: str, attempt: Attempt | None) -> Path:
        return kept_path(self.folder, student, None if attempt is None else attempt.file)

    def _key(self, student: str, attempt: Attempt | None) -> str:
        """Return a text that changes whenever what a notebook earns may change; also when it may take longer."""
        handed_in = "" if attempt is None else f"{attempt.file.name}/{attempt.fingerprint}/{self.limits}"
        content = f"{json.dumps(as_json(made_from(self.assignment, student)))}/{student}/{handed_in}"
        return hashlib.sha256(content.encode("utf-8", "replace")).hexdigest()


class _Context:
    """What a process has on its context while it grades: the assignment, a sandbox, the folder of what is graded."""

    def __init__(self, shelf: _Shelf, overrides: Overrides, write_page: WritePage | None) -> None:
        self.shelf, self.assignment = shelf, shelf.assignment
        self._overrides, self._write_page = overrides, write_page
        self._roster = {student.id: student for student in self.assignment.roster}
        self.sandbox = Sandbox(shelf.limits, strict=self.assignment.sandbox == "strict")
        self.copies = Copies(self.assignment)

    def write_page(self, name: str, handed_in: Sequence[Graded]) -> None:
        """Write a student's page, if that is wanted and can be done."""
        if self._write_page is not None:
            student = self._roster[name]
            with contextlib.suppress(Exception):  # it is told where the page is written at last
                result = _settle(self.assignment, student, handed_in, self._overrides)
                self._write_page(self.assignment, student, result)

    def close(self) -> None:
        self.sandbox.close()


def _settle(assignment: Assignment, student: Student, handed_in: Sequence[Graded], overrides: Overrides) -> Result:
    of_student = overrides.of_students.get(student.id, {})
    try:
        return settle(assignment, student, handed_in, of_student, overrides.of_groups)
    except Exception as error:  # the boundary around a student, again
        marked = mark_ungraded(assignment, student.id, None, describe_error(error))
        return settle(assignment, student, [Graded(handed_in[0].file, marked=marked)], {})


Entry = tuple[Attempt | None, bool]
"""A notebook of a student, None where nothing was handed in, and whether it may count."""


def _grade(context: _Context, task: Task) -> list[Graded]:
    """Return everything that a student handed in, in the order in which it was received; what counts is marked.

    This is the boundary around a student: what fails in here fails for this one. Only what concerns the whole class, as
    a disk that is full, is a QdotError.
    """
    try:
        return _grade_all(context, task)
    except QdotError:
        raise
    except Exception as error:
        if (cause := of_machine(error)) is not None:
            raise cause from None
        return _mark_failed(context.assignment, task, describe_error(error))


def _grade_all(context: _Context, task: Task) -> list[Graded]:
    handed_in, is_new = [], False
    for attempt, counts in _entries(context.assignment, task):
        marked = context.shelf.take(task.student, attempt) if counts else None
        if counts and marked is None:
            marked, is_new = _mark(context, task.student, attempt), True
        handed_in.append(_as_graded(attempt, marked))
    if is_new:  # a mark that was kept may be that of a process which its page has ended
        context.write_page(task.student, handed_in)
    return handed_in


def _grade_elsewhere(
    shelf: _Shelf, tasks: Sequence[Task], executor: Executor, room: Callable[[], int],
    settled: Callable[[int, list[Graded]], None],
) -> None:  # fmt: skip
    """Tell `settled` what every student handed in, as soon as all of it is marked by the executor."""
    brief = brief_of(shelf.assignment, shelf.limits)
    begun: dict[int, tuple[list[Entry], dict[int, Marked | None]]] = {}

    def wanted() -> Iterator[tuple[tuple[int, int], Order]]:
        for place, task in enumerate(tasks):
            try:
                entries = _entries(shelf.assignment, task)
                marks = {i: shelf.take(task.student, attempt) for i, (attempt, counts) in enumerate(entries) if counts}
                lacking = [i for i, marked in marks.items() if marked is None]
                orders = [order_of(shelf.assignment, brief, task.student, entries[i][0]) for i in lacking]
            except Exception as error:  # as in `_grade`
                settled(place, _mark_failed(shelf.assignment, task, describe_error(error)))
                continue
            begun[place] = entries, marks
            yield from (((place, i), order) for i, order in zip(lacking, orders, strict=True))
            if not lacking:
                finish(place)

    def finish(place: int) -> None:
        entries, marks = begun.pop(place)
        settled(place, [_as_graded(attempt, marks.get(i)) for i, (attempt, _) in enumerate(entries)])

    with contextlib.closing(graded_by(executor, brief, wanted(), room)) as every:
        for (place, i), marked in every:
            student, (entries, marks) = tasks[place].student, begun[place]
            attempt = entries[i][0]
            if marked is not None:
                shelf.put(student, attempt, marked)
            marks[i] = marked or mark_ungraded(shelf.assignment, student, attempt, DIED)
            if all(marks.values()):
                finish(place)


def _entries(assignment: Assignment, task: Task) -> list[Entry]:
    """Read what a student handed in, in the order in which it was received."""
    if task.found is None:
        return [(None, True)]
    attempts = read_attempts(task.found, assignment.key)
    counting = _counting(assignment, attempts)
    in_order = sorted(attempts, key=lambda attempt: attempt.received)
    return [(attempt, attempt in counting) for attempt in in_order]


def _as_graded(attempt: Attempt | None, marked: Marked | None) -> Graded:
    if attempt is None:
        return Graded(marked=marked)
    submission = attempt.submission
    told_by = ("file", None) if submission is None else (submission.received_from, submission.late)
    return Graded(printable_name(attempt.file.name), attempt.received, marked, *told_by)


def _counting(assignment: Assignment, attempts: list[Attempt]) -> list[Attempt]:
    """Return the notebooks to grade; `attempts` come as `find_submissions` orders them.

    Where any has the assignment's name, or names it in its metadata, the others are no attempts.
    """
    of_assignment = [attempt for attempt in attempts if attempt.is_of(assignment)] or attempts
    counting = assignment.attempts.select_counting([attempt.received for attempt in of_assignment])
    return [of_assignment[i] for i in counting]


def _mark(context: _Context, student: str, attempt: Attempt | None) -> Marked:
    """Return what the grader gives for a notebook, and keep it."""
    marked = grade_safely(context.assignment, student, attempt, context.sandbox, context.copies)
    context.shelf.put(student, attempt, marked)
    return marked


def _mark_failed(assignment: Assignment, task: Task, why: str = DIED) -> list[Graded]:
    """Return what stands for a student on whom qdot failed, as where every process ended that was to grade them."""
    file = "" if task.found is None or not task.found.files else printable_name(task.found.files[0].name)
    return [Graded(file, marked=mark_ungraded(assignment, task.student, None, why))]


def kept_path(cache: Path, student: str, file: Path | None) -> Path:
    """Return where the result of a student's notebook is kept."""
    name = f"{student}/{'' if file is None else f'{file.name}/{file.parent.name == student}'}"
    return cache / f"{hashlib.sha256(name.encode('utf-8', 'surrogateescape')).hexdigest()[:24]}.json"


def _kept_paths(cache: Path, task: Task) -> list[Path]:
    return [kept_path(cache, task.student, file) for file in (task.found.files if task.found else (None,))]
