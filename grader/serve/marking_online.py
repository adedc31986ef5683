"""Mark submissions: typed answers at once, in processes that are ready, and notebooks from a queue in the database.

An answer that takes long to judge goes into the queue, too, so that it doesn't keep the others waiting. If a process is
killed, the submission is marked again later, which gives the same marks.
"""

import logging
import re
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from datetime import timedelta
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeVar

from django.core.cache import caches
from django.db import close_old_connections, transaction
from django.utils import timezone
from django_tasks import task
from django_tasks_db.models import DBTaskResult

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.assignment.certified_problems import record_replacements
from qdot.exercises.assignment.store import compute_package_digest
from qdot.exercises.common.json_form import to_jsonable
from qdot.exercises.common.parallel import open_pool, submit_to_pool
from qdot.grader.grading.attempt import Grader, grade_safely, make_marking_versions, mark_ungraded, read_attempts
from qdot.grader.grading.batch import make_limits
from qdot.grader.grading.result import NotebookMarks, ProblemResult
from qdot.grader.sandbox.sandbox import Limits, Sandbox
from qdot.grader.serve.class_list import describe_class, load_class_assignment
from qdot.grader.serve.errors import Refused, report_failed
from qdot.grader.serve.judge_process import (
    Judge,
    MarkedAnswers,
    StudentOfClass,
    TypedAnswers,
    make_problem_records,
    mark_typed_answers,
    release_problems,
    show_marks,
    stay_busy,
)
from qdot.grader.serve.lti.outbox import update_scores
from qdot.grader.serve.models import Draft, Person, Submission
from qdot.grader.serve.scores import list_notebook_answers, load_marks, name_file
from qdot.grader.serve.settings import find_options
from qdot.grader.submissions.submission import StudentFiles
from qdot.grader.submissions.submission import Submission as Attempt

Item = TypeVar("Item")
Result = TypeVar("Result")
MarksAndPage = tuple[NotebookMarks, dict[str, Any]]
"""The marks of a submission, and what the student's page shows of them."""
logger = logging.getLogger("qdot.serve")

KILLED_REASON = "its process failed or was ended several times, perhaps because memory ran out"
"""Why a submission is ungraded if its grading failed, or killed its process, again and again."""
ANSWER_SECONDS = 25.0
"""Maximum number of seconds that a student's browser waits for a verdict; then the page asks again later."""
TURN_SECONDS = 3.0
"""Maximum number of seconds that an answer waits for an earlier one of the same student; then it is queued."""
UNMARKED_SECONDS = 60.0
"""Number of seconds after which `queue_unmarked` queues a submission again that is neither marked nor in the queue."""
MAX_FAILURES = 5
"""Maximum number of times that grading a submission may fail or kill its process."""
SLOW_PRIORITY = -5
"""The priority in the queue of typed answers that take long to judge; notebooks have 0, which is higher."""


class JudgePool:
    """The processes that judge. If one of them dies, all are started again, and the work is repeated once."""

    def __init__(self, folders: tuple[Path, ...], jobs: int) -> None:
        self._open = partial(open_pool, setup=Judge, arguments=(folders,))
        self._jobs, self._lock = jobs, threading.Lock()
        self._pool = self._open(jobs)

    def run(self, work: Callable[[Judge, Item], Result], item: Item) -> Result:
        """Return `work(judge, item)`. Raises TimeoutError, or BrokenProcessPool if the work kills two processes."""
        pool = self._pool
        try:
            return _wait(submit_to_pool(pool, work, item))
        except BrokenProcessPool:
            with self._lock:
                if pool is self._pool:
                    self._pool = self._open(self._jobs)
        with self._open(1) as own_pool:  # in a separate pool, the work can't end other work
            return _wait(submit_to_pool(own_pool, work, item))

    def warm_up(self) -> None:
        """Start all processes, and wait until they are ready."""
        futures = [submit_to_pool(self._pool, stay_busy, 0.5) for _ in range(self._jobs)]
        for future in futures:
            future.result()

    def close(self) -> None:
        """End the processes."""
        self._pool.shutdown(wait=False, cancel_futures=True)


def _wait(future: Future[Result]) -> Result:
    """Return the result of work. Raises TimeoutError if it takes too long; work that has not begun is cancelled."""
    try:
        return future.result(ANSWER_SECONDS)
    except TimeoutError:
        future.cancel()
        raise


@cache
def get_judge_pool() -> JudgePool:
    """Return the judges of this service; the first call starts their processes."""
    return JudgePool(find_options().folders, find_options().jobs)


# --- typed answers ---


def mark_answers(submission: Submission) -> None:
    """Mark typed answers at once, or queue them if marking takes long or kills its process."""
    try:
        with _wait_for_turn(submission.person.pk):
            marks_and_page = _mark_typed(submission, get_judge_pool().run, is_quick=True)
    except (TimeoutError, BrokenProcessPool):
        marks_and_page = None
    if marks_and_page is None:
        grade_submission.using(priority=SLOW_PRIORITY).enqueue(submission.pk)
    else:
        _store_marks(submission, *marks_and_page)


def mark_practice(person: Person, typed_answers: TypedAnswers) -> MarkedAnswers:
    """Return the marks of answers for practice, without storing them. Raises Refused if marking takes long."""
    marked_answers: MarkedAnswers | None = None
    with suppress(TimeoutError, BrokenProcessPool), _wait_for_turn(person.pk):
        marked_answers = get_judge_pool().run(mark_typed_answers, typed_answers)
    if marked_answers is None:
        raise Refused(409, "It takes too long to judge this answer. Try a shorter one.")
    return marked_answers


_turns, _people_in_turn = threading.Condition(), set[int]()
"""A condition, and the ids that it guards: those of people whose answers are being judged."""


@contextmanager
def _wait_for_turn(person_id: int) -> Iterator[None]:
    """Wait until no other answer of a person is being judged. Raises TimeoutError if this takes too long."""
    with _turns:
        if not _turns.wait_for(lambda: person_id not in _people_in_turn, TURN_SECONDS):
            raise TimeoutError
        _people_in_turn.add(person_id)
    try:
        yield
    finally:
        with _turns:
            _people_in_turn.remove(person_id)
            _turns.notify_all()


def _mark_typed(submission: Submission, run: Callable[..., Any], *, is_quick: bool) -> MarksAndPage | None:
    """Return the marks of typed answers, and what is shown of them. Unchanged problems keep their earlier marks.

    The result is None if `is_quick` and judging takes long.
    """
    assignment = load_class_assignment(submission.person.classroom, submission.assignment)
    answers, student = submission.answers or {}, submission.person.student_id
    finished_problems, shown = _find_unchanged(submission, assignment)
    typed_answers = TypedAnswers(describe_class(assignment), student, answers, finished_problems, is_quick)
    marked_answers: MarkedAnswers | None = run(mark_typed_answers, typed_answers)
    return None if marked_answers is None else (marked_answers.marks, shown | to_jsonable(marked_answers.shown))


def _find_unchanged(submission: Submission, assignment: Assignment) -> tuple[dict[str, ProblemResult], dict[str, Any]]:
    """Return the marks, by slot, of problems unchanged since the previous submission, and what is shown of them."""
    earlier_submissions = Submission.objects.filter(person=submission.person, assignment=submission.assignment)
    earlier_submissions = earlier_submissions.filter(answers__isnull=False, marks__isnull=False, pk__lt=submission.pk)
    previous = earlier_submissions.order_by("-pk").first()
    if previous is None:
        return {}, {}
    marks = load_marks([previous.pk])[previous.pk]
    if marks.made_from != make_marking_versions(assignment, submission.person.student_id):
        return {}, {}
    old_answers, new_answers, shown = previous.answers or {}, submission.answers or {}, previous.shown or {}
    changed = {part for part in {*old_answers, *new_answers} if old_answers.get(part) != new_answers.get(part)}
    changed_slots = {part.partition(".")[0] for part in changed}
    problems = {problem.slot: problem for problem in marks.problems if problem.slot not in changed_slots}
    return problems, {name: shown_part for name, shown_part in shown.items() if name.partition(".")[0] in problems}


def _store_marks(submission: Submission, marks: NotebookMarks, shown: dict[str, Any]) -> None:
    """Store the marks of a submission, and the scores that platforms have to show."""
    with transaction.atomic():
        submission.set_marks(to_jsonable(marks), shown)
        update_scores(submission.person, submission.assignment)


def queue_unmarked() -> None:
    """Queue submissions again that are still unmarked, because a process was killed or the database failed.

    A submission whose grading has failed several times stays ungraded.
    """
    cutoff = timezone.now() - timedelta(seconds=UNMARKED_SECONDS)
    unmarked = Submission.objects.filter(state=Submission.State.WAITING, received__lt=cutoff)
    if waiting_ids := set(unmarked.values_list("pk", flat=True)):
        tasks = DBTaskResult.objects.filter(task_path=grade_submission.module_path)
        failures = Counter(row.args_kwargs["args"][0] for row in tasks.failed())
        queued_ids = {row.args_kwargs["args"][0] for row in tasks.exclude(status__in=("FAILED", "SUCCESSFUL"))}
        for submission_id in sorted(waiting_ids - queued_ids):
            if failures[submission_id] < MAX_FAILURES:
                grade_submission.enqueue(submission_id)
            else:
                give_up(grade_submission.module_path, submission_id)


# --- what pages show ---


def load_problem_records(owner: object, assignment: Assignment, student_id: str, language: str) -> list[dict[str, Any]]:
    """Return the problems of a student as the page shows them. They are generated for a student who has none yet.

    `owner` is unique to the person, or to the practice set.
    """
    digest, page_cache = assignment.notebook_digest_of(student_id), caches["pages"]
    key = f"{compute_package_digest()[:16]}-{digest}-{assignment.hints}-{language}-{owner}"
    if (records := page_cache.get(key)) is None:
        release_if_needed(assignment, student_id)
        student = StudentOfClass(describe_class(assignment), student_id, language)
        records = get_judge_pool().run(make_problem_records, student)
        page_cache.set(key, records, None)
    return records


_release_lock = threading.Lock()
"""Held while the problems of a student are released, because replaced problems are recorded in one file."""


def release_if_needed(assignment: Assignment, student: str) -> None:
    """Generate, certify and store a student's problems, unless they are up to date. Raises Refused."""
    with _release_lock:
        for _ in range(2):  # a second time if problems were replaced, because nothing is stored the first time
            result = get_judge_pool().run(release_problems, StudentOfClass(describe_class(assignment), student))
            if result.outcome != "to replace":
                break
            record_replacements(assignment, student, result.replacements)
    if result.failed_slots:
        logger.error("%s", "; ".join(map(str, result.failed_slots)))
        raise Refused(503, "qdot found no valid problem for you. Tell your instructor.")


# --- in the process for the queue ---


@cache
def _open_sandbox(strict: bool) -> Sandbox:
    return Sandbox(make_limits(Limits.seconds), strict=strict)


@cache
def _get_own_judge() -> Judge:
    """Return the judge of this process; the first call loads the assignments."""
    return Judge(find_options().folders)


def _read_file(assignment: Assignment, name: str, content: bytes) -> Attempt:
    """Return the notebook in a file of a student."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(content)
        (attempt,) = read_attempts(StudentFiles((path,)), assignment.key)
    return attempt


def read_upload(person: Person, assignment: Assignment, name: str, content: bytes) -> Attempt:
    """Return the notebook in a file that a person submits; a person's files are read in turn. Raises TimeoutError."""
    with _wait_for_turn(person.pk):
        safe_name = re.sub(r"[^\w. ()-]", "_", name)[-60:]  # short enough for every file system
        return _read_file(assignment, safe_name, content)


@task()
def grade_submission(submission_id: int) -> None:
    """Grade a submission as `qdot grade` does."""
    submission = Submission.objects.select_related("person__classroom").filter(pk=submission_id).first()
    if submission is None or submission.state == Submission.State.MARKED:
        return  # the student was removed in the meantime, or the submission was in the queue twice
    if submission.answers is None:
        marks, shown = _grade_file(submission)
        _store_marks(submission, marks, shown)
        answered = list_notebook_answers(submission)
        drafts = Draft.objects.filter(person=submission.person, assignment=submission.assignment, part__in=answered)
        drafts.filter(saved__lt=submission.received).delete()  # so that the page shows the notebook's newer answers
    elif marks_and_page := _mark_typed(submission, lambda work, item: work(_get_own_judge(), item), is_quick=False):
        _store_marks(submission, *marks_and_page)


def _grade_file(submission: Submission) -> MarksAndPage:
    """Return the marks of a submitted file, and what is shown of them."""
    assignment, judge = load_class_assignment(submission.person.classroom, submission.assignment), _get_own_judge()
    student = submission.person.student_id
    grader = Grader(assignment, _open_sandbox(assignment.sandbox == "strict"), judge.find_class_answers(assignment))
    attempt = _read_file(assignment, name_file(assignment, submission), bytes(submission.content or b""))
    marks = grade_safely(grader, student, attempt)
    if marks.obstacle is not None:
        return marks, {}
    return marks, to_jsonable(show_marks(assignment, judge.load_problems(assignment, student), marks, set()))


@task()
def mark_again(submission_id: int) -> None:
    """Mark a submission again, for the staff to compare (see `regrading`)."""
    submission = Submission.objects.select_related("person__classroom").filter(pk=submission_id).first()
    if submission is None:
        return
    if submission.answers is None:
        marks, shown = _grade_file(submission)
    else:
        assignment = load_class_assignment(submission.person.classroom, submission.assignment)
        typed_answers = TypedAnswers(describe_class(assignment), submission.person.student_id, submission.answers, {})
        if (marked_answers := mark_typed_answers(_get_own_judge(), typed_answers)) is None:
            return
        marks, shown = marked_answers.marks, to_jsonable(marked_answers.shown)
    Submission.objects.filter(pk=submission_id).update(remarked={"marks": to_jsonable(marks), "shown": shown})


def give_up(task_path: str, submission_id: int) -> None:
    """Leave a submission ungraded, because a task killed its process several times.

    The task is `grade_submission`, which gives the first marks, or `mark_again`.
    """
    submission = Submission.objects.select_related("person__classroom").filter(pk=submission_id).first()
    if submission is None:
        return
    assignment = load_class_assignment(submission.person.classroom, submission.assignment)
    marks = mark_ungraded(assignment, submission.person.student_id, None, KILLED_REASON)
    if task_path == grade_submission.module_path:
        _store_marks(submission, marks, {})
    else:
        Submission.objects.filter(pk=submission_id).update(remarked={"marks": to_jsonable(marks), "shown": {}})


def run_periodically(work: Callable[[], None], seconds: float) -> threading.Thread:
    """Call `work` every few seconds in a new thread. Errors are logged and don't end the thread."""

    def loop() -> None:
        while True:
            time.sleep(seconds)
            try:
                close_old_connections()
                work()
            except Exception as error:
                report_failed(name, error)

    name = getattr(work, "__name__", "claiming the database")  # only that work, a partial, has no name
    thread = threading.Thread(target=loop, daemon=True, name=name)
    thread.start()
    return thread


def count_waiting_before(submission: Submission) -> int | None:
    """Return how many notebooks are waiting before this one; None if it isn't waiting."""
    if submission.state != Submission.State.WAITING:
        return None
    notebooks = Submission.objects.filter(state=Submission.State.WAITING, answers__isnull=True)
    return notebooks.filter(pk__lt=submission.pk).count()
