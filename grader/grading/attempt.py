"""One notebook graded: read, run, and every part of it marked, whenever it came and whatever else was handed in."""

import datetime
import hashlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.assignment.store import load_stored_problems
from qdot.exercises.common.errors import QdotError, of_machine
from qdot.exercises.notebook.setup_cell import setup_cell
from qdot.exercises.problem.problem import ENGINE, Problem
from qdot.grader.diagnosis.groups import group_key
from qdot.grader.grading.copied_answers import Copies
from qdot.grader.grading.marking import mark
from qdot.grader.grading.result import Cost, MadeFrom, Marked, PartResult, ProblemResult
from qdot.grader.judging.functions import calls_of
from qdot.grader.judging.verdict import Outcome, Verdict
from qdot.grader.sandbox.clock import Allowance
from qdot.grader.sandbox.sandbox import Calls, Run, Sandbox
from qdot.grader.submissions.answer_locator import Answers, find_answers
from qdot.grader.submissions.cells import OverLimit, Unreadable, printable_name, without_self_checks
from qdot.grader.submissions.submission import (
    Note,
    StudentFiles,
    Submission,
    explain_wrong_assignment,
    find_oddities,
    modification_time,
    read_submission,
    select_likely_notebooks,
)

GRADER = 14
"""Version of the grader: any change of what a submission earns, or of what is kept of it, raises it."""


@dataclass(frozen=True)
class Attempt:
    """A notebook that a student handed in, and when; where it can't be read, `unreadable` says why.

    It may be that it takes more to read than a limit allows. `notes` tell what else was handed in that can't be read.
    """

    file: Path
    received: datetime.datetime
    submission: Submission | None = None
    unreadable: str = ""
    notes: tuple[str, ...] = ()
    over_limit: bool = False

    def is_of(self, assignment: Assignment) -> bool:
        """Tell whether its file's name or its metadata name the assignment."""
        claims = {} if self.submission is None else self.submission.claims
        return self.file.name == f"{assignment.key}.ipynb" or claims.get("assignment") == assignment.key

    @property
    def fingerprint(self) -> str:
        """A short text that changes whenever what was handed in does."""
        if self.submission is None:
            return self.unreadable
        read = self.submission
        return repr((read.sha256, read.notes, read.late, self.notes, *sorted(read.modules.items())))


class NotFoundOut(Exception):
    """Why it is not known what a student handed in, in words for them; nobody else is concerned."""


def read_attempts(found: StudentFiles, key: str) -> list[Attempt]:
    """Read what a student handed in, best first. What can't be read is no attempt where something else can.

    Raises NotFoundOut where looking for it has failed.
    """
    if found.failure:
        raise NotFoundOut(found.failure)
    if found.obstacle:
        return [replace(_unreadable(found.files[0], found.obstacle), over_limit=found.over_limit)]
    likely, note = select_likely_notebooks(found.files)
    found = replace(found, notes=(*found.notes, note)) if note else found
    attempts = [_read(found, path, key) for path in likely]
    if not any(attempt.submission for attempt in attempts):
        unlikely = (_read(found, path, key) for path in found.files[:MOST_TRIED] if path not in likely)
        attempts += [attempt for attempt in unlikely if attempt.submission][:1]
    readable = [attempt for attempt in attempts if attempt.submission]
    failed = [attempt.unreadable for attempt in attempts if not attempt.submission]
    if not readable:
        return attempts[:1]
    return [
        replace(
            attempt, notes=tuple(f"{why}; {printable_name(attempt.file.name)} was graded instead" for why in failed)
        )
        for attempt in readable
    ]


MOST_TRIED = 10
"""Files that are tried where none that looks like a notebook can be read."""


def _read(found: StudentFiles, path: Path, key: str) -> Attempt:
    try:
        read = read_submission(path, key, found.files)
    except Unreadable as error:
        return replace(_unreadable(path, str(error)), over_limit=isinstance(error, OverLimit))
    submission = replace(read, notes=(*found.notes, *read.notes), late=found.late)
    if found.received is not None:
        submission = replace(submission, received=found.received, received_from=found.platform)
    return Attempt(path, submission.received, submission)


def _unreadable(path: Path, why: str) -> Attempt:
    try:
        received = modification_time(path.lstat())
    except OSError:
        received = datetime.datetime.fromtimestamp(0, datetime.UTC)
    return Attempt(path, received, None, why)


def made_from(assignment: Assignment, student: str) -> MadeFrom:
    """Return what else than the submission decides the points: the versions of qdot's parts, and the assignment."""
    content = f"{assignment.edition_of(student)}/{assignment.marking}"
    return MadeFrom(ENGINE, GRADER, hashlib.sha256(content.encode()).hexdigest()[:16])


def grade_safely(
    assignment: Assignment, student: str, attempt: Attempt | None, sandbox: Sandbox, copies: Copies,
    kept_text: str | None = None,
) -> Marked:  # fmt: skip
    """Grade one notebook, as `grade_attempt` does; whatever fails in it, in whatever way, leaves this one UNGRADED.

    What it cost is added: seconds of processor time, and the most bytes that its process had. Raises QdotError where
    the machine runs no notebook at all: that is nobody's submission, and is told once.
    """
    started = time.process_time()
    sandbox.cost()
    marked = _grade_or_mark_ungraded(assignment, student, attempt, sandbox, copies, kept_text)
    seconds, memory = sandbox.cost()
    return replace(marked, cost=Cost(round(time.process_time() - started + seconds, 3), int(memory)))


def _grade_or_mark_ungraded(
    assignment: Assignment, student: str, attempt: Attempt | None, sandbox: Sandbox, copies: Copies,
    kept_text: str | None,
) -> Marked:  # fmt: skip
    try:
        return grade_attempt(assignment, student, attempt, sandbox, copies, kept_text)
    except OverLimit as error:
        return mark_ungraded(assignment, student, attempt, str(error), over_limit=True)
    except Exception as error:  # our own failure must neither become a mark nor stop the class
        if isinstance(error, QdotError):
            sandbox.run((), ())
        if (cause := of_machine(error)) is not None:
            raise cause from None
        return mark_ungraded(assignment, student, attempt, describe_error(error))


def describe_error(error: Exception) -> str:
    """Return an exception in words, on one line of no great length."""
    message = str(error) if isinstance(error, (QdotError, NotFoundOut)) else f"{type(error).__name__}: {error}"
    return " ".join(message.split())[:300]


def grade_attempt(
    assignment: Assignment, student: str, attempt: Attempt | None, sandbox: Sandbox, copies: Copies,
    kept_text: str | None = None,
) -> Marked:  # fmt: skip
    """Grade one notebook: regenerate the problems from the assignment, run the cells, mark every part.

    With `kept_text`, which `store` has made, nothing is read from the assignment's folder. Raises OverLimit.
    """
    problems = load_stored_problems(assignment, student, kept_text).problems
    if attempt is None:
        return _mark(assignment, copies, student, problems, None, Answers(Run()), "nothing was handed in", [])
    submission, notes = attempt.submission, [Note(note, note) for note in attempt.notes]
    nothing = Answers(Run())
    if attempt.over_limit:
        raise OverLimit(attempt.unreadable)
    if submission is None:
        return _mark(assignment, copies, student, problems, None, nothing, attempt.unreadable, notes)
    notes += [Note(note, note) for note in submission.notes if note]
    obstacle = explain_wrong_assignment(submission, assignment)
    if obstacle is not None:
        return _mark(assignment, copies, student, problems, submission, nothing, obstacle, notes)
    parts = [f"{slot}.{part.name}" for slot, problem in problems for part in problem.parts]
    seed = _points_seed(assignment, submission)
    calls = {slot: calls_of(problem, problem.domain(), seed) for slot, problem in problems}
    cells = without_self_checks(submission.cells, problems)
    setup = setup_cell(problems)
    modules = submission.modules
    answers = find_answers(cells, parts, lambda cells, names: _run(sandbox, cells, names, calls, setup, modules))
    notes += find_oddities(submission, assignment, student)
    notes += [Note(note, note) for note in answers.notes if note]
    notes += [Note(f"refused: {stop}") for stop in answers.refused if stop not in answers.notes]
    return _mark(assignment, copies, student, problems, submission, answers, None, notes)


def _run(
    sandbox: Sandbox, cells: Sequence[str | None], names: Sequence[str], calls: Mapping[str, Calls], setup: str,
    modules: Mapping[str, str],
) -> Run:  # fmt: skip
    """Run a notebook. Where the process that runs it is lost, the notebook must have done it twice to answer for it."""
    run, lost = Run(end="unbegun"), 0
    for _ in range(TRIES):
        run = sandbox.run(cells, names, calls, setup, modules)
        if run.end not in ("lost", "unbegun"):
            return run
        lost += run.end == "lost"
        if lost == 2:
            break
    if lost < 2 or sandbox.run((), ()).end != "done":  # no memory, no disk: no notebook's doing
        why = f" ({sandbox.unbegun})" if sandbox.unbegun else "; is there memory, and room on the disk?"
        raise RuntimeError(f"the process that runs notebooks ends by itself{why}")
    return run


TRIES = 5
"""How often a notebook is begun on a machine that ends its process before it has."""


def _mark(
    assignment: Assignment, copies: Copies, student: str, problems: Sequence[tuple[str, Problem]],
    submission: Submission | None, answers: Answers, obstacle: str | None, notes: Sequence[Note],
) -> Marked:  # fmt: skip
    results = list[ProblemResult]()
    of_another = submission is not None and submission.claims.get("student") not in (None, student)
    credit, allowance = Fraction(0) if of_another else assignment.follow_through, Allowance()
    for slot, problem in problems:
        reasons = {part.name: obstacle or answers.reason(slot, part.name) for part in problem.parts}
        verdicts = mark(
            problem, answers.of(slot, problem), reasons, secret=assignment.secret,
            points_seed=_points_seed(assignment, submission), credit=credit,
            is_copied=partial(copies.is_right_for_another, problem, slot), allowance=allowance,
        )  # fmt: skip
        results.append(ProblemResult(str(problem.id), slot, tuple(part_result(slot, each) for each in verdicts)))
    return Marked(
        sha256=None if submission is None else submission.sha256,
        obstacle=obstacle,
        notes=tuple(note.student for note in notes if note.student),
        staff_notes=tuple(note.staff for note in notes),
        made_from=made_from(assignment, student),
        problems=tuple(results),
    )


def part_result(slot: str, verdict: Verdict) -> PartResult:
    """Return what a verdict gives a part in its place of the assignment, which the key of its group names, too."""
    judgement, diagnosis = verdict.judgement, verdict.diagnosis
    return PartResult(
        name=verdict.part,
        outcome=judgement.outcome,
        over_limit=judgement.over_limit,
        points=verdict.points,
        max_points=verdict.max_points,
        reason=judgement.reason,
        mistake=None if diagnosis is None else diagnosis.names or None,
        advice=None if diagnosis is None else diagnosis.says,
        followed_from=verdict.followed_from,
        follows=verdict.follows,
        attempt=verdict.attempt,
        group=None if verdict.group is None else group_key(f"{slot}.{verdict.part}", verdict.group),
        certificate=judgement.certificate,
        answer=verdict.answer,
        entries=judgement.entries,
    )


def mark_ungraded(
    assignment: Assignment, student: str, attempt: Attempt | None, why: str, over_limit: bool = False
) -> Marked:  # fmt: skip
    """Return what stands for a notebook that exceeded a limit, or on which qdot itself failed: no mark.

    It is made without doing anything.
    """
    for_staff = (why if over_limit else f"qdot could not grade this ({why})") + "; it has no mark yet"
    reason = f"{for_staff}, tell your instructor"

    def part(name: str, max_points: float) -> PartResult:
        outcome = Outcome.UNGRADED
        return PartResult(
            name=name, outcome=outcome, over_limit=over_limit, points=None, max_points=max_points, reason=reason
        )

    return Marked(
        sha256=None if attempt is None or attempt.submission is None else attempt.submission.sha256,
        obstacle=reason,
        staff_notes=(for_staff,),
        made_from=made_from(assignment, student),
        problems=tuple(
            ProblemResult(
                str(assignment.identity(slot, student)),
                slot.name,
                tuple(map(part, slot.questions, slot.max_points)),
            )
            for slot in assignment.slots
        ),
    )


def _points_seed(assignment: Assignment, submission: Submission | None) -> str:
    """Return what draws the points at which functions are called: others for every submission that differs."""
    return f"{assignment.secret}/{submission.sha256 if submission is not None else ''}"
