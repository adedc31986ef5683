"""Grade a class on several processes, or one student alone: run and mark every notebook.

The marks of a notebook are stored in graded/.cache as soon as they are computed, together with a key. The key is a
digest of the submission, the assignment, and the versions of problems and grader. A later run uses the stored marks of
each notebook whose key has not changed. An attempt is one of the notebooks that a student submitted.
"""

import contextlib
import datetime
import hashlib
import json
import os
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.late_rule import add_time_zone
from qdot.exercises.common.errors import QdotError, make_open_files_error
from qdot.exercises.common.files import (
    clean_up_after,
    lock,
    make_folder,
    make_write_error,
    sync_disks_after,
    write_atomically,
)
from qdot.exercises.common.input_file import format_csv
from qdot.exercises.common.json_form import parse_dataclass, to_jsonable
from qdot.exercises.common.parallel import map_in_order
from qdot.grader.grading.attempt import (
    MAX_ERROR_LENGTH,
    Grader,
    describe_error,
    grade_safely,
    make_marking_versions,
    mark_ungraded,
    read_attempts,
)
from qdot.grader.grading.cluster import Cluster, connect
from qdot.grader.grading.copied_answers import ClassAnswers
from qdot.grader.grading.final_result import GradedNotebook, compute_final_result, make_ungraded_result
from qdot.grader.grading.overrides import read_overrides
from qdot.grader.grading.result import NotebookMarks, Result
from qdot.grader.sandbox.sandbox import Limits, Sandbox
from qdot.grader.submissions.cells import make_printable
from qdot.grader.submissions.submission import StudentFiles, Submission

CRASH_REASON = "the system ended its process twice, probably because memory ran out"
"""Why a student is ungraded if the process that grades the student's notebook was ended twice."""


GradingTask = tuple[str, StudentFiles | None]
"""The identifier of a student to grade, and the files that the student submitted; None if there are none."""


def grade_class(
    assignment: Assignment, submissions: Mapping[str, StudentFiles], jobs: int, limits: Limits,
    on_result: Callable[[Result], None] = lambda _: None, students: Sequence[Student] | None = None, executor: str = "",
) -> list[Result]:  # fmt: skip
    """Grade all students on the roster, or only these `students`, and return the results in the order of the students.

    `on_result` is called with every result. `jobs` is the number of processes. If `jobs` is 0, this process grades all
    notebooks, and a notebook that kills this process ends the grading. Otherwise a notebook that kills its process
    twice leaves its student UNGRADED until the next run. If `executor` is the address of a Dask scheduler, the workers
    of that scheduler grade. Raises QdotError, also for a mistake in overrides.csv.
    """
    overrides = read_overrides(assignment)
    chosen_students = assignment.roster if students is None else students
    tasks = [(student.id, submissions.get(student.id)) for student in chosen_students]
    cache = assignment.folder / "graded" / ".cache"
    make_folder(cache)
    results: list[Result] = []
    costs = [("student", "seconds", "megabytes")]
    files_by_student = {student: files.files if files else (None,) for student, files in tasks}
    paths = [marks_path(cache, student, file) for student, files in files_by_student.items() for file in files]
    make_failed_notebooks = partial(_make_failed_notebooks, assignment) if jobs else None
    with clean_up_after(paths), sync_disks_after():
        if executor:
            graded_notebooks = _grade_on_cluster(executor, tasks, assignment, limits, cache)
        else:
            setup = (assignment, limits, cache)
            graded_notebooks = map_in_order(
                _grade_student_safely, tasks, jobs, setup=_GradingWorker, arguments=setup,
                result_if_lost=make_failed_notebooks,
            )  # fmt: skip
        with contextlib.closing(graded_notebooks):
            for student, notebooks in zip(chosen_students, graded_notebooks, strict=True):
                try:
                    result = compute_final_result(assignment, student, notebooks, overrides)
                except Exception as error:  # an error for one student must not stop the class
                    result = make_ungraded_result(assignment, student, notebooks[0].file, error)
                results.append(result)
                costs.append((student.id, *_format_cost(notebooks)))
                on_result(result)
    if students is None:
        write_atomically(assignment.folder / "graded" / "costs.csv", format_csv(costs), 0o600)
    return results


def _format_cost(notebooks: Sequence[GradedNotebook]) -> tuple[str, str]:
    """Return the processor time for grading a student's notebooks in seconds, and the peak memory in megabytes."""
    all_marks = [notebook.marks for notebook in notebooks if notebook.marks is not None]
    seconds = sum(marks.seconds for marks in all_marks)
    megabytes = max((marks.megabytes for marks in all_marks), default=0.0)
    return f"{seconds:.2f}", f"{megabytes:.0f}"


def _grade_on_cluster(
    address: str, tasks: Sequence[GradingTask], assignment: Assignment, limits: Limits, cache_path: Path
) -> Generator[list[GradedNotebook], None, None]:
    """Yield the graded notebooks of each student.

    The cluster's workers grade, and a pool of threads in this process waits for them.
    """
    with connect(address, assignment, limits) as cluster:
        worker = _GradingWorker(assignment, limits, cache_path, cluster)
        pool = ThreadPoolExecutor(cluster.threads)
        try:
            yield from pool.map(partial(_grade_student_safely, worker), tasks)
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


@contextlib.contextmanager
def lock_folder(folder: Path) -> Iterator[None]:
    """Lock an assignment's folder for grading. Raises QdotError if another process is grading it.

    The operating system releases the lock when this process ends, even if it crashes.
    """
    path = folder / "graded" / ".cache" / "lock"
    make_folder(path.parent)
    try:
        file = path.open("a+")  # NFS gives no shared lock on a file that isn't opened for reading
    except OSError as error:
        raise make_write_error(path, error) from None
    with file:
        _lock_descriptors.add(file.fileno())
        try:
            with contextlib.suppress(OSError):  # the disk has no locks; files are still written atomically
                try:
                    lock(file.fileno(), wait=False)
                except BlockingIOError:
                    message = f"another 'qdot grade' is grading {path.parent.parent}; wait until it is done"
                    raise QdotError(message) from None
            yield
        finally:
            _lock_descriptors.discard(file.fileno())


_lock_descriptors: set[int] = set()
"""File descriptors of open lock files. A forked process closes its copies, because they would keep the lock alive."""


def _close_lock_descriptors() -> None:
    """Close this process's copies of open lock files."""
    while _lock_descriptors:
        os.close(_lock_descriptors.pop())


if hasattr(os, "register_at_fork"):  # other systems don't fork
    os.register_at_fork(after_in_child=_close_lock_descriptors)


# --- in the process that grades ---


@dataclass(frozen=True)
class _StoredMarks:
    """The content of a file in graded/.cache: a notebook's marks, and a digest of everything that decides them."""

    key: str
    marked: NotebookMarks


class _GradingWorker:
    """Grades students' notebooks in a local sandbox or on a cluster, and stores the marks in the cache folder."""

    def __init__(self, assignment: Assignment, limits: Limits, cache: Path, cluster: Cluster | None = None) -> None:
        self.assignment, self._limits, self._cache_path, self._cluster = assignment, limits, cache, cluster
        if cluster is None:
            sandbox = Sandbox(limits, strict=assignment.sandbox == "strict")
            self._grader = Grader(assignment, sandbox, ClassAnswers(assignment))

    def close(self) -> None:
        """End the processes of the sandbox; a worker on a cluster closes its own sandbox."""
        self._grader.sandbox.close()

    def grade(self, task: GradingTask) -> list[GradedNotebook]:
        """Return a student's notebooks in the order received; only the attempts that may count are marked."""
        student, files = task
        if files is None:
            return [GradedNotebook(marks=self._mark(student, None))]
        if files.failure:
            return _make_failed_notebooks(self.assignment, task, files.failure[:MAX_ERROR_LENGTH])
        attempts = read_attempts(files, self.assignment.key)
        counting_attempts = _select_counting_attempts(self.assignment, attempts)
        notebooks = []
        for attempt in sorted(attempts, key=lambda attempt: attempt.received):
            marks = self._mark(student, attempt) if attempt in counting_attempts else None
            name = make_printable(attempt.file.name)
            notebooks.append(GradedNotebook(name, attempt.received, marks, attempt.time_source, attempt.flagged_late))
        return notebooks

    def _mark(self, student: str, attempt: Submission | None) -> NotebookMarks:
        """Return the marks of a notebook. They are loaded from the cache if nothing that decides them has changed."""
        if (stored_marks := self.load_marks(student, attempt)) is not None:
            return stored_marks
        if self._cluster is None:
            marks = grade_safely(self._grader, student, attempt)
        else:
            marks_from_cluster = self._cluster.mark(student, attempt)
            marks = marks_from_cluster or mark_ungraded(self.assignment, student, attempt, CRASH_REASON)
        self.store_marks(student, attempt, marks)
        return marks

    def load_marks(self, student: str, attempt: Submission | None) -> NotebookMarks | None:
        """Return the stored marks of a notebook; None if there are none or they may be out of date."""
        try:
            stored_marks = parse_dataclass(_StoredMarks, self._find_path(student, attempt).read_bytes())
        except (OSError, ValueError):
            return None  # nothing stored yet, or damaged
        return stored_marks.marked if stored_marks.key == self._compute_key(student, attempt) else None

    def store_marks(self, student: str, attempt: Submission | None, marks: NotebookMarks) -> None:
        """Store the marks of a notebook, unless qdot failed to grade it, so that the next run tries again."""
        if marks.is_graded:
            stored_marks = _StoredMarks(self._compute_key(student, attempt), replace(marks, seconds=0.0, megabytes=0.0))
            write_atomically(self._find_path(student, attempt), json.dumps(to_jsonable(stored_marks)), is_synced=False)

    def _find_path(self, student: str, attempt: Submission | None) -> Path:
        """Return the path of the file that stores the marks of a notebook."""
        return marks_path(self._cache_path, student, None if attempt is None else attempt.file)

    def _compute_key(self, student: str, attempt: Submission | None) -> str:
        """Return a digest that changes whenever the notebook's points may change or the limits change."""
        submission_key = "" if attempt is None else f"{attempt.file.name}/{attempt.fingerprint}/{self._limits}"
        versions = json.dumps(to_jsonable(make_marking_versions(self.assignment, student)))
        content = f"{versions}/{student}/{submission_key}"
        return hashlib.sha256(content.encode("utf-8", "replace")).hexdigest()


def _grade_student_safely(worker: _GradingWorker, task: GradingTask) -> list[GradedNotebook]:
    """Grade a student's notebooks like `_GradingWorker.grade`; an error leaves only this student UNGRADED.

    Raises QdotError for a problem that concerns the whole class, such as a full disk.
    """
    try:
        return worker.grade(task)
    except QdotError:
        raise
    except Exception as error:
        if (cause := make_open_files_error(error)) is not None:
            raise cause from None
        return _make_failed_notebooks(worker.assignment, task, describe_error(error))


def _select_counting_attempts(assignment: Assignment, attempts: list[Submission]) -> list[Submission]:
    """Return the attempts that may count and must be graded; `attempts` begin with the most likely notebook.

    If the names or the metadata of some notebooks name the assignment, the other notebooks are ignored.
    """
    matching_attempts = [attempt for attempt in attempts if attempt.is_for(assignment)] or attempts
    times = [attempt.received for attempt in matching_attempts]
    return [matching_attempts[i] for i in assignment.attempt_policy.select_counting_indices(times)]


def _make_failed_notebooks(
    assignment: Assignment, task: GradingTask, reason: str = CRASH_REASON
) -> list[GradedNotebook]:
    """Return an UNGRADED notebook for a student whom qdot failed to grade, for the given reason."""
    student, files = task
    file = make_printable(files.files[0].name) if files and files.files else ""
    return [GradedNotebook(file, marks=mark_ungraded(assignment, student, None, reason))]


def marks_path(cache_path: Path, student: str, file: Path | None) -> Path:
    """Return the path of the file that stores the marks of a student's notebook."""
    # A student may submit NAME both as a single file and in the folder STUDENT.
    name = f"{student}/{'' if file is None else f'{file.name}/{file.parent.name == student}'}"
    return cache_path / f"{hashlib.sha256(name.encode('utf-8', 'surrogateescape')).hexdigest()[:24]}.json"


# --- one student ---


def make_limits(seconds: float) -> Limits:
    """Return the limits for a notebook that may run for `seconds`; each of its cells may run for half of that."""
    return Limits(seconds=seconds, cell_seconds=max(1.0, seconds / 2))


def parse_time(text: str) -> datetime.datetime:
    """Return the time that a text gives in ISO 8601; the default zone is the machine's. Raises QdotError."""
    try:
        return add_time_zone(datetime.datetime.fromisoformat(text))
    except ValueError:
        raise QdotError(f"{text!r} is not a time; expected a time as in 2027-01-15T23:59:00+01:00") from None


def grade_one(assignment: Assignment, student: Student, files: StudentFiles | None, limits: Limits) -> Result:
    """Return the result of one student. Stored marks are used if nothing that decides them has changed.

    Only files in graded/.cache are written. They are written atomically, so several processes may grade at once.
    """
    submissions = {} if files is None else {student.id: files}
    (result,) = grade_class(assignment, submissions, 1, limits, students=[student])
    return result
