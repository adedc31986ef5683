"""Grade notebooks on a Dask cluster. Its workers need no shared disk, and may join, leave or crash at any time.

A worker receives the assignment without students' names, and one notebook at a time. It refuses to grade if its code
differs from the code of this machine.
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
from qdot.exercises.assignment.store import code_digest
from qdot.exercises.common.console import note
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import need, qdot_version
from qdot.grader.grading.attempt import Attempt, Grader, grade_safely
from qdot.grader.grading.copied_answers import ClassAnswers
from qdot.grader.grading.result import Marked
from qdot.grader.sandbox import guarantees
from qdot.grader.sandbox.sandbox import Limits, Sandbox

if TYPE_CHECKING:
    from distributed import Client, Future

ADDRESS = r"(tcp|tls)://(\[[0-9A-Fa-f:.%]+\]|[^\s/:\[\]]+):[0-9]{1,5}"
CONNECTING, STARTING, RETURNING = 10.0, 10.0, 60.0
"""Seconds to wait for the scheduler, for its first worker, and for a worker to return after all have left."""
IDLE = 300.0
"""Seconds after which an idle worker drops the assignment."""
LOGGERS = ("distributed", "distributed.client", "tornado", "tornado.application")
"""Dask's loggers, which are silenced because they print a traceback for errors that qdot reports in one line."""
GO_ON = "what has been graded is stored: run the same command again to go on"
SAME = "install the same qdot, Python, SymPy and NumPy everywhere"


@dataclass(frozen=True)
class Brief:
    """The data that a worker needs to grade an assignment, without folder and students' names.

    `name` is a digest of the content, and `code` is a digest of qdot's code.
    """

    name: str
    code: str
    assignment: Assignment
    limits: Limits


@contextmanager
def connect(address: str, assignment: Assignment, limits: Limits) -> Iterator["Cluster"]:
    """Yield the cluster of a Dask scheduler, ready to grade notebooks. Raises QdotError if it can't be used."""
    if not re.fullmatch(ADDRESS, address):
        raise QdotError(f"--executor {address!r} is no address of a Dask scheduler; one is tcp://10.0.0.5:8786")
    try:
        from distributed import Client
        from distributed.versions import VersionMismatchWarning
    except ImportError:
        need("cluster", "--executor")
        raise  # distributed is installed, but broken
    with _quiet(), warnings.catch_warnings():
        warnings.simplefilter("ignore", VersionMismatchWarning)  # the workers compare the versions that matter
        try:
            client = Client(address, timeout=CONNECTING, set_as_default=False)
        except (OSError, ValueError, TypeError, ImportError) as error:
            raise QdotError(f"no Dask scheduler answers at {address} as it should: {_first_line(error)}") from None
        with client:
            yield Cluster(client, address, brief_of(assignment, limits))


def brief_of(assignment: Assignment, limits: Limits) -> Brief:
    """Return the data that workers need to grade an assignment."""
    roster = tuple(Student(student.id) for student in assignment.roster)
    redrawn = sorted((*place, redraw.draw) for place, redraw in assignment.redrawn.items())
    content = (
        assignment.edition, assignment.marking, assignment.secret, assignment.sandbox, limits, roster, redrawn
    )  # fmt: skip
    anonymous_assignment = replace(assignment, folder=Path(), roster=roster, notes=())
    return Brief(hashlib.sha256(repr(content).encode()).hexdigest(), code(), anonymous_assignment, limits)


class Cluster:
    """A Dask cluster that grades an assignment's notebooks; several threads may use it."""

    def __init__(self, client: "Client", address: str, brief: Brief) -> None:
        """Wait for the first worker, and send it the brief. Raises QdotError if there is no worker."""
        self._client, self._address = client, address
        self._seen, self._asked, self._had_workers = time.monotonic(), -1.0, False
        self._lock, self._alone, self._reported = threading.Lock(), threading.Lock(), set[str]()
        while not self._had_workers:
            self._look_for_workers()
            time.sleep(0.1)
        self.threads = max(32, 2 * sum(client.nthreads().values()))
        self._brief = client.submit(_pass_on, brief, pure=False)  # the scheduler recreates it if its worker dies

    def mark(self, student: str, attempt: Attempt | None) -> Marked | None:
        """Return the marks of a notebook; None if it crashes its workers twice. Raises QdotError without workers."""
        if attempt is not None and attempt.submission is not None:
            # A notebook's claims may be nested too deeply to be sent; only claims that are texts are ever used.
            claims = {
                name: claim if isinstance(claim, str | None) else True
                for name, claim in attempt.submission.claims.items()
            }
            attempt = replace(attempt, submission=replace(attempt.submission, claims=claims))
        marked = self._try_to_mark(student, attempt)
        if marked is None:
            with self._alone:
                marked = self._try_to_mark(student, attempt)
        return marked

    def _try_to_mark(self, student: str, attempt: Attempt | None) -> Marked | None:
        try:
            future = self._client.submit(mark_on_worker, self._brief, student, attempt, pure=False)
            marked, worker, warning = self._wait_for(future)
        except QdotError:
            raise
        except Exception as error:
            if type(error).__name__ == "KilledWorker":
                return None
            if type(error).__name__ in ("CancelledError", "FutureCancelledError"):
                raise QdotError(f"the connection to the workers is gone; {GO_ON}") from None
            reason = f"{type(error).__name__}: {_first_line(error)}"
            raise QdotError(f"the workers can't do what they are asked ({reason}); {SAME}") from None
        if warning and warning not in self._reported:
            self._reported.add(warning)
            note(f"worker {worker}: {warning}")
        return marked

    def _wait_for(self, future: "Future") -> tuple[Marked, str, str]:
        while True:
            try:
                reply: tuple[Marked, str, str] = future.result(timeout=1)
                return reply
            except TimeoutError:
                self._look_for_workers()

    def _look_for_workers(self) -> None:
        """Raise QdotError if there has been no worker for a while; ask the scheduler at most once a second."""
        with self._lock:
            now = time.monotonic()
            if now < self._asked + 1:
                return
            try:
                workers, self._asked = self._client.nthreads(), now
            except (OSError, RuntimeError) as error:
                message = f"the Dask scheduler at {self._address} is gone ({_first_line(error)}); {GO_ON}"
                raise QdotError(message) from None
            if workers:
                self._seen, self._had_workers = now, True
            elif now > self._seen + (RETURNING if self._had_workers else STARTING):
                raise QdotError(
                    f"all workers of {self._address} are gone; {GO_ON}"
                    if self._had_workers
                    else f"the Dask scheduler at {self._address} has no workers; start some: "
                    f"dask worker {self._address} --nthreads 1 --nworkers auto"
                )


@contextmanager
def _quiet() -> Iterator[None]:
    levels = {name: logging.getLogger(name).level for name in LOGGERS}
    try:
        for name in LOGGERS:
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
        yield
    finally:
        for name, level in levels.items():
            logging.getLogger(name).setLevel(level)


def _first_line(error: BaseException) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:200]


# --- on a worker ---


def _pass_on(brief: Brief) -> Brief:
    return brief


_state: dict[str, Any] = {}
"""The digest of the assignment that this process grades, its Grader, a warning, and the timer that drops it."""
_one_at_a_time = threading.Lock()
"""Lock that lets only one thread grade at a time, because all threads of a process share mpmath's precision."""


def mark_on_worker(brief: Brief, student: str, attempt: Attempt | None) -> tuple[Marked, str, str]:
    """Grade a notebook in this process; return its marks, the machine's name, and a warning about the sandbox.

    Raises QdotError, which names the machine, if the machine can't grade or its code differs.
    """
    machine = platform.node()
    if brief.code != code():
        versions = f"it has qdot {qdot_version()} on Python {platform.python_version()}"
        raise QdotError(
            f"worker {machine}: its code or its libraries are not those of the grading machine ({versions}); {SAME}"
        )
    with _one_at_a_time:
        try:
            if _state.get("name") != brief.name:
                forget()
                _prepare(brief)
            _state["timer"].cancel()
            _start_timer()
            return grade_safely(_state["grader"], student, attempt), machine, _state["warning"]
        except QdotError as error:
            raise QdotError(f"worker {machine}: {error}") from None


def _prepare(brief: Brief) -> None:
    """Prepare this process to grade an assignment.

    Raises QdotError if the assignment requires a stricter sandbox than this machine can enforce.
    """
    _forget_at_exit()
    strict = brief.assignment.sandbox == "strict"
    findings = guarantees.probe(quick=not strict)
    if strict and not findings.is_strict:
        raise QdotError(guarantees.explain_refusal(findings))
    grader = Grader(brief.assignment, Sandbox(brief.limits, strict=strict), ClassAnswers(brief.assignment))
    _state.update(name=brief.name, grader=grader, warning=guarantees.describe_weakness(findings))
    _start_timer()


def _start_timer() -> None:
    timer = threading.Timer(IDLE, _forget_unless_busy)
    timer.daemon = True
    timer.start()
    _state["timer"] = timer


def _forget_unless_busy() -> None:
    if _one_at_a_time.acquire(blocking=False):  # otherwise a notebook is being graded, which started another timer
        try:
            forget()
        finally:
            _one_at_a_time.release()


@cache
def _forget_at_exit() -> None:
    Finalize(None, forget, exitpriority=10)  # unlike atexit, Finalize also works in multiprocessing's processes


def forget() -> None:
    """Close the sandbox of this process, and drop the assignment with its secret."""
    if "timer" in _state:
        _state["timer"].cancel()
    if "grader" in _state:
        _state["grader"].sandbox.close()
    _state.clear()


@cache
def code() -> str:
    """Return a digest of everything on a machine that decides the points: all code, and the libraries' versions."""
    digest = hashlib.sha256(f"{code_digest()}/{qdot_version()}/{mpmath.__version__}".encode())
    for path in sorted(Path(__file__).parents[1].rglob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()
