"""Grade notebooks on the workers of a Dask cluster, which need no shared disk and may join, leave or crash at any time.

Dask distributes calls of Python functions: this process sends them to a scheduler, which passes them to workers. A
worker receives the assignment without students' names, and one notebook at a time. A worker whose code differs from the
code of this machine refuses to grade.
"""

import hashlib
import logging
import platform
import re
import threading
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from multiprocessing.util import Finalize
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mpmath

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.store import compute_package_digest
from qdot.exercises.common.console import note
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import find_qdot_version, require_extra
from qdot.grader.grading.attempt import Grader, grade_safely
from qdot.grader.grading.copied_answers import ClassAnswers
from qdot.grader.grading.result import NotebookMarks
from qdot.grader.sandbox import guarantees
from qdot.grader.sandbox.sandbox import Limits, Sandbox
from qdot.grader.submissions.submission import Submission

if TYPE_CHECKING:
    from distributed import Client, Future

ADDRESS_PATTERN = r"(tcp|tls)://(\[[0-9A-Fa-f:.%]+\]|[^\s/:\[\]]+):[0-9]{1,5}"
SCHEDULER_TIMEOUT, FIRST_WORKER_TIMEOUT, WORKER_RETURN_TIMEOUT = 10.0, 10.0, 60.0
"""Seconds to wait for the scheduler, for its first worker, and for a worker to return after all have left."""
IDLE_TIMEOUT = 300.0
"""Seconds after which an idle worker drops the assignment."""
DASK_LOGGERS = ("distributed", "distributed.client", "tornado", "tornado.application")
"""Dask's loggers, which are silenced because they print a traceback for errors that qdot reports in one line."""
RESUME_HINT = "the results so far are stored; run the same command again to continue"
SAME_VERSIONS_HINT = "install the same qdot, Python, SymPy and NumPy everywhere"


@dataclass(frozen=True)
class WorkerBrief:
    """The data that a worker needs to grade an assignment, without the assignment's folder and the students' names.

    `content_digest` is a digest of the data, and `code_digest` is a digest of qdot's code.
    """

    content_digest: str
    code_digest: str
    assignment: Assignment
    limits: Limits


@contextmanager
def connect(address: str, assignment: Assignment, limits: Limits) -> Iterator["Cluster"]:
    """Yield the cluster of a Dask scheduler, ready to grade notebooks. Raises QdotError if it can't be used."""
    if not re.fullmatch(ADDRESS_PATTERN, address):
        raise QdotError(f"--executor {address!r}: expected the address of a Dask scheduler, as in tcp://10.0.0.5:8786")
    try:
        from distributed import Client
        from distributed.versions import VersionMismatchWarning
    except ImportError:
        require_extra("cluster", "--executor")
        raise  # distributed is installed, but broken
    for name in DASK_LOGGERS:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VersionMismatchWarning)  # the workers compare the versions that matter
        try:
            client = Client(address, timeout=SCHEDULER_TIMEOUT, set_as_default=False)
        except (OSError, ValueError, TypeError, ImportError) as error:
            raise QdotError(f"qdot can't connect to a Dask scheduler at {address}: {_get_first_line(error)}") from None
        with client:
            yield Cluster(client, address, make_brief(assignment, limits))


def make_brief(assignment: Assignment, limits: Limits) -> WorkerBrief:
    """Return the data that workers need to grade an assignment within the limits for each notebook."""
    roster = tuple(Student(student.id) for student in assignment.roster)
    replacements = assignment.replacements.items()
    seed_numbers = sorted((*student_and_slot, problem.seed_number) for student_and_slot, problem in replacements)
    settings = assignment.notebook_digest, assignment.marking_digest, assignment.secret, assignment.sandbox
    digest = hashlib.sha256(repr((*settings, limits, roster, seed_numbers)).encode()).hexdigest()
    anonymous_assignment = replace(assignment, folder=Path(), roster=roster, notes=(), class_list=None)
    return WorkerBrief(digest, compute_code_digest(), anonymous_assignment, limits)


class Cluster:
    """A Dask cluster that grades an assignment's notebooks; several threads may call `mark` at the same time."""

    def __init__(self, client: "Client", address: str, brief: WorkerBrief) -> None:
        """Wait for the first worker, and send it the brief. Raises QdotError if there is no worker."""
        self._client, self._address = client, address
        self._last_worker_time, self._last_query_time, self._had_workers = time.monotonic(), -1.0, False
        self._lock, self._retry_lock, self._reported_warnings = threading.Lock(), threading.Lock(), set[str]()
        while not self._had_workers:
            self._look_for_workers()
            time.sleep(0.1)
        self.threads = max(32, 2 * sum(client.nthreads().values()))  # they only wait; more workers may join
        self._brief = client.submit(_return_brief, brief, pure=False)  # the scheduler recreates it if its worker dies

    def mark(self, student: str, submission: Submission | None) -> NotebookMarks | None:
        """Return the marks of a notebook; None if it crashes its workers twice. Raises QdotError without workers."""
        sent_submission = submission
        if submission is not None:
            # A notebook's metadata may be nested too deeply to be sent, but the grader only uses texts in it.
            items = submission.qdot_metadata.items()
            metadata = {name: value if isinstance(value, str | None) else True for name, value in items}
            sent_submission = replace(submission, qdot_metadata=metadata)
        marks = self._try_to_mark(student, sent_submission)
        if marks is not None:
            return marks
        with self._retry_lock:  # only one notebook at a time that may crash its worker
            return self._try_to_mark(student, sent_submission)

    def _try_to_mark(self, student: str, submission: Submission | None) -> NotebookMarks | None:
        """Return the marks of a notebook from a worker; None if the worker crashed. Raises QdotError."""
        try:
            future = self._client.submit(mark_on_worker, self._brief, student, submission, pure=False)
            marks, worker, warning = self._wait_for(future)
        except QdotError:
            raise
        except Exception as error:
            if type(error).__name__ == "KilledWorker":
                return None
            if type(error).__name__ in ("CancelledError", "FutureCancelledError"):
                raise QdotError(f"the connection to the workers was lost; {RESUME_HINT}") from None
            reason = f"{type(error).__name__}: {_get_first_line(error)}"
            raise QdotError(f"the workers can't grade ({reason}); {SAME_VERSIONS_HINT}") from None
        if warning and warning not in self._reported_warnings:
            self._reported_warnings.add(warning)
            note(f"worker {worker}: {warning}")
        return marks

    def _wait_for(self, future: "Future") -> "WorkerReply":
        """Return a worker's reply. Raises QdotError if there has been no worker for a while."""
        while True:
            try:
                reply: WorkerReply = future.result(timeout=1)
                return reply
            except (TimeoutError, UnboundLocalError):  # the latter if the wait of `distributed.utils.sync` is cancelled
                self._look_for_workers()

    def _look_for_workers(self) -> None:
        """Raise QdotError if there has been no worker for a while; ask the scheduler at most once a second."""
        with self._lock:
            now = time.monotonic()
            if now < self._last_query_time + 1:
                return
            try:
                workers, self._last_query_time = self._client.nthreads(), now
            except (OSError, RuntimeError) as error:
                reason = _get_first_line(error)
                message = f"the Dask scheduler at {self._address} no longer answers ({reason}); {RESUME_HINT}"
                raise QdotError(message) from None
            if workers:
                self._last_worker_time, self._had_workers = now, True
            elif self._had_workers and now > self._last_worker_time + WORKER_RETURN_TIMEOUT:
                raise QdotError(f"all workers of {self._address} have left; {RESUME_HINT}")
            elif not self._had_workers and now > self._last_worker_time + FIRST_WORKER_TIMEOUT:
                command = f"dask worker {self._address} --nthreads 1 --nworkers auto"
                raise QdotError(f"the Dask scheduler at {self._address} has no workers; start some: {command}")


def _get_first_line(error: BaseException) -> str:
    """Return the first line of an exception's message, or the name of its class if there is no message."""
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:200]


# --- on a worker ---


def _return_brief(brief: WorkerBrief) -> WorkerBrief:
    """Return the brief, which makes Dask store it on a worker and pass it on to other workers."""
    return brief


_worker_state: dict[str, Any] = {}
"""The state of this process as a worker; empty if it has no assignment.

The keys are "content_digest" (of the brief), "grader" (a Grader), "warning" (about the sandbox) and "timer" (a timer
that drops the assignment).
"""
_grading_lock = threading.Lock()
"""Lock that lets only one thread grade at a time, because all threads of a process share mpmath's precision."""
WorkerReply = tuple[NotebookMarks, str, str]
"""The marks of a notebook, the name of the machine that graded it, and a warning about the sandbox or ""."""


def mark_on_worker(brief: WorkerBrief, student: str, submission: Submission | None) -> WorkerReply:
    """Return the marks of a notebook, graded in this process, with the machine's name and a warning.

    Raises QdotError, which names the machine, if the machine can't grade or its code differs.
    """
    machine = platform.node()
    if brief.code_digest != compute_code_digest():
        versions = f"qdot {find_qdot_version()} and Python {platform.python_version()}"
        difference = f"its code or libraries ({versions}) differ from those of the grading machine"
        raise QdotError(f"worker {machine}: {difference}; {SAME_VERSIONS_HINT}")
    with _grading_lock:
        try:
            if _worker_state.get("content_digest") != brief.content_digest:
                drop_assignment()
                _prepare(brief)
            _worker_state["timer"].cancel()
            _start_timer()
            return grade_safely(_worker_state["grader"], student, submission), machine, _worker_state["warning"]
        except QdotError as error:
            raise QdotError(f"worker {machine}: {error}") from None


def _prepare(brief: WorkerBrief) -> None:
    """Prepare this process to grade an assignment: fill `_worker_state`.

    Raises QdotError if the assignment requires a stricter sandbox than this machine can enforce.
    """
    _drop_at_exit()
    must_be_strict = brief.assignment.sandbox == "strict"
    warning = guarantees.check_sandbox(must_be_strict)
    grader = Grader(brief.assignment, Sandbox(brief.limits, strict=must_be_strict), ClassAnswers(brief.assignment))
    _worker_state.update(content_digest=brief.content_digest, grader=grader, warning=warning)
    _start_timer()


def _start_timer() -> None:
    """Start a timer that drops the assignment when this worker has been idle for `IDLE_TIMEOUT` seconds."""
    timer = threading.Timer(IDLE_TIMEOUT, _drop_unless_busy)
    timer.daemon = True
    timer.start()
    _worker_state["timer"] = timer


def _drop_unless_busy() -> None:
    """Drop the assignment unless a notebook is being graded."""
    if _grading_lock.acquire(blocking=False):  # otherwise a notebook is being graded, which started another timer
        try:
            drop_assignment()
        finally:
            _grading_lock.release()


@cache
def _drop_at_exit() -> None:
    """Make sure that the assignment is dropped when this process ends; further calls have no effect."""
    Finalize(None, drop_assignment, exitpriority=10)  # atexit doesn't work in multiprocessing's processes


def drop_assignment() -> None:
    """Close the sandbox of this process, and drop the assignment with its secret."""
    if "timer" in _worker_state:
        _worker_state["timer"].cancel()
    if "grader" in _worker_state:
        _worker_state["grader"].sandbox.close()
    _worker_state.clear()


@cache
def compute_code_digest() -> str:
    """Return a digest of everything on a machine that decides the points: all code, and the libraries' versions."""
    digest = hashlib.sha256(f"{compute_package_digest()}/{find_qdot_version()}/{mpmath.__version__}".encode())
    for path in sorted(Path(__file__).parents[1].rglob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()
