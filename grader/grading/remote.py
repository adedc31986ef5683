"""Notebooks graded by any executor, in processes that need share no disk with this one and may die at any moment.

What is sent is an `Order`: one notebook as it was read, and the student's problems as they were kept. The assignment is
sent to a worker that says it lacks it, once, and stays there. A worker with other code than here grades nothing.
"""

import hashlib
import platform
import threading
import zlib
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import BrokenExecutor, Executor, Future
from dataclasses import dataclass, replace
from functools import cache
from multiprocessing.util import Finalize
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TypeVar

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.store import code_digest as code_of_problems
from qdot.exercises.assignment.store import read_stored_text
from qdot.exercises.common.console import note
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import qdot_version
from qdot.grader.grading.attempt import Attempt, grade_safely
from qdot.grader.grading.copied_answers import Copies
from qdot.grader.grading.result import Marked
from qdot.grader.sandbox import guarantees
from qdot.grader.sandbox.sandbox import Limits, Sandbox

Key = TypeVar("Key")

MOST_CHARACTERS = 100_000_000
"""Characters of notebooks and problems that are out at a time, so that huge ones don't fill this machine's memory."""

IDLE = 300.0
"""Seconds after which a worker that was given nothing forgets what it was sent; it is sent it again."""

MOST_CONTEXTS = 3
"""Assignments that a worker keeps at hand, for as many graders that share it."""


@dataclass(frozen=True)
class Brief:
    """What a worker has to know of an assignment: no names, no folder, and the roster as compressed identifiers."""

    name: str
    assignment: Assignment
    roster: bytes
    limits: Limits


@dataclass(frozen=True)
class Order:
    """A notebook to grade (None: nothing was handed in), of which assignment, and by which code."""

    code: str
    assignment: str
    student: str
    attempt: Attempt | None
    problems: str
    brief: Brief | None = None

    @property
    def characters(self) -> int:
        """About how large it is."""
        submission = None if self.attempt is None else self.attempt.submission
        return len(self.problems) + sum(len(cell.source) for cell in (submission.cells if submission else ()))


@dataclass(frozen=True)
class Reply:
    """What a worker says: the marks, or that it lacks the assignment (neither), or why it grades nothing.

    `warning` says what its machine does not enforce while students' code runs.
    """

    marked: Marked | None = None
    refusal: str = ""
    warning: str = ""
    worker: str = ""


# --- where the results are wanted ---


def brief_of(assignment: Assignment, limits: Limits) -> Brief:
    """Return what workers have to know of an assignment."""
    identifiers = "\n".join(student.id for student in assignment.roster)
    sent = replace(assignment, folder=Path(), roster=(), notes=())
    drawn = sorted((*whose, redraw.draw) for whose, redraw in assignment.redrawn.items())
    about = (
        assignment.edition, assignment.marking, assignment.secret, assignment.sandbox, limits, identifiers, drawn
    )  # fmt: skip
    name = hashlib.sha256(repr(about).encode()).hexdigest()
    return Brief(name, sent, zlib.compress(identifiers.encode()), limits)


def order_of(assignment: Assignment, brief: Brief, student: str, attempt: Attempt | None) -> Order:
    """Return what is sent of a notebook."""
    if attempt is not None and attempt.submission is not None:
        # What a notebook claims may be nested deeper than anything can be sent; only texts are ever looked at.
        claims = {
            name: said if isinstance(said, str | None) else True for name, said in attempt.submission.claims.items()
        }
        attempt = replace(attempt, submission=replace(attempt.submission, claims=claims))
    return Order(code(), brief.name, student, attempt, read_stored_text(assignment, student))


def graded_by(
    executor: Executor,
    brief: Brief,
    wanted: Iterable[tuple[Key, Order]],
    room: Callable[[], int],
) -> Generator[tuple[Key, Marked | None], None, None]:
    """Yield the marks of every order as they come; None for a notebook that no worker outlives.

    `room` is asked again and again how many orders may be out at a time, and raises QdotError where nobody is at work.
    An order over which workers died is given once more, when nothing else is out. What a worker's machine does not
    enforce is told. Close the generator to cancel what is out. Raises QdotError where a worker refuses, the executor is
    broken, or it lets go of orders.
    """
    lost: list[tuple[Key, Order]] = []
    told: set[str] = set()

    def tell(reply: Reply) -> None:
        if reply.warning and reply.warning not in told:
            told.add(reply.warning)
            note(f"worker {reply.worker}: {reply.warning}")

    try:
        for key, order, marked in _round(executor, brief, wanted, room, tell):
            if marked is None:
                lost.append((key, order))
            else:
                yield key, marked
        for key, _, marked in _round(executor, brief, lost, lambda: min(1, room()), tell):
            yield key, marked
    finally:
        with _one_at_a_time:
            put_away()  # an executor of threads has worked here


def _round(
    executor: Executor,
    brief: Brief,
    wanted: Iterable[tuple[Key, Order]],
    room: Callable[[], int],
    tell: Callable[[Reply], None],
) -> Generator[tuple[Key, Order, Marked | None], None, None]:
    """Yield the marks of every order as they come; None for what fails by the workers' end."""
    out: dict[Future[Reply], tuple[Key, Order]] = {}
    done: SimpleQueue[Future[Reply]] = SimpleQueue()
    waiting, characters = iter(wanted), 0

    def give(key: Key, order: Order) -> None:
        try:
            future = executor.submit(grade_order, order)
        except RuntimeError as error:  # it is shut down or broken
            raise _broken(error) from None
        out[future] = key, order
        future.add_done_callback(done.put)

    try:
        while True:
            while len(out) < room() and characters < MOST_CHARACTERS and (item := next(waiting, None)):
                characters += item[1].characters
                give(*item)
            if not out:
                return
            try:
                future = done.get(timeout=1)
            except Empty:
                continue  # are there workers?
            key, order = out.pop(future)
            reply = _reply(future)
            if reply is not None and reply.marked is None:
                give(key, replace(order, brief=brief))
                continue
            characters -= order.characters
            if reply is not None:
                tell(reply)
            yield key, order, None if reply is None else reply.marked
    finally:
        for future in out:
            future.cancel()


def _reply(future: "Future[Reply]") -> Reply | None:
    """Return what a worker said, None where it came to say nothing. Raises QdotError where it can't be had."""
    if future.cancelled():
        raise QdotError(f"the connection to the workers is gone; {GO_ON}")
    error = future.exception()
    if error is None:
        reply = future.result()
        if reply.refusal:
            raise QdotError(f"worker {reply.worker}: {reply.refusal}")
        return reply
    if isinstance(error, BrokenExecutor):
        raise _broken(error)
    if type(error).__name__ == "KilledWorker":  # Dask's, which need not be installed
        return None
    raise QdotError(f"the workers can't do what they are asked ({type(error).__name__}: {str(error)[:300]}); {SAME}")


GO_ON = "what has been graded is kept: run the same command again to go on"
SAME = "install the same qdot, Python, SymPy and NumPy everywhere"


def _broken(error: BaseException) -> QdotError:
    return QdotError(f"the workers are gone ({str(error)[:200]}); {GO_ON}")


# --- in the process that does the work ---


class _Context:
    """What a worker keeps of an assignment, and a sandbox."""

    def __init__(self, brief: Brief) -> None:
        """Set up. Raises QdotError where the assignment demands more than this machine enforces."""
        roster = tuple(Student(each) for each in zlib.decompress(brief.roster).decode().split("\n"))
        self.assignment, strict = replace(brief.assignment, roster=roster), brief.assignment.sandbox == "strict"
        findings = guarantees.probe(quick=not strict)
        if strict and not findings.is_strict:
            raise QdotError(guarantees.explain_refusal(findings))
        self.warning = guarantees.describe_weakness(findings)
        self.sandbox, self.copies = Sandbox(brief.limits, strict=strict), Copies(self.assignment)


_contexts: dict[str, _Context] = {}
_timers: list[threading.Timer] = []
_one_at_a_time = threading.Lock()
"""A worker may have several threads, and mpmath has one precision for all of them."""


def grade_order(order: Order) -> Reply:
    """Grade a notebook in this process, with what lies on its context."""
    worker = platform.node()
    if order.code != code():
        has = f"it has qdot {qdot_version()} on Python {platform.python_version()}"
        return Reply(refusal=f"its code or its libraries are not those of this machine ({has}); {SAME}", worker=worker)
    with _one_at_a_time:
        try:
            context = _context(order)
            _put_away_when_idle()
            if context is None:
                return Reply()
            about = (order.student, order.attempt, context.sandbox, context.copies, order.problems)
            return Reply(grade_safely(context.assignment, *about), warning=context.warning, worker=worker)
        except QdotError as error:
            return Reply(refusal=str(error), worker=worker)


def _context(order: Order) -> _Context | None:
    """Return the context for an order's assignment, None where this process knows nothing of it. Raises QdotError."""
    if order.assignment not in _contexts and order.brief is not None:
        _put_away_at_the_end()
        while len(_contexts) >= MOST_CONTEXTS:
            _contexts.pop(next(iter(_contexts))).sandbox.close()
        _contexts[order.assignment] = _Context(order.brief)
    return _contexts.get(order.assignment)


def _put_away_when_idle() -> None:
    """See to it that no secret and no sandbox stays in a process that has nothing to grade any more."""
    for timer in _timers:
        timer.cancel()
    _timers[:] = [threading.Timer(IDLE, _put_away_unless_busy)]
    _timers[0].daemon = True
    _timers[0].start()


def _put_away_unless_busy() -> None:
    if _one_at_a_time.acquire(blocking=False):  # else another order has come, and with it another timer
        try:
            put_away()
        finally:
            _one_at_a_time.release()


@cache
def _put_away_at_the_end() -> None:
    Finalize(None, put_away, exitpriority=10)  # unlike atexit, it is called in multiprocessing's processes, too


def put_away() -> None:
    """End what this process keeps for grading."""
    for timer in _timers:
        timer.cancel()
    while _contexts:
        _contexts.popitem()[1].sandbox.close()


@cache
def code() -> str:
    """Return a digest of everything that decides what a notebook earns: all code, and the versions of libraries."""
    import mpmath

    digest = hashlib.sha256(f"{code_of_problems()}/{qdot_version()}/{mpmath.__version__}".encode())
    for path in sorted(Path(__file__).parents[1].rglob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()
