"""Grade one notebook: parse the file, run the notebook, and mark the answer to every part.

An attempt is one of the notebooks that a student submitted. Each attempt is graded independently of the others.
"""

import hashlib
import secrets
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.assignment.store import load_stored_problems
from qdot.exercises.common.errors import QdotError, make_open_files_error
from qdot.exercises.notebook.setup_cell import write_setup_cell
from qdot.exercises.problem.problem import ENGINE, Problem
from qdot.exercises.reference_answers import Words
from qdot.grader.diagnosis.groups import format_group_key
from qdot.grader.grading.copied_answers import ClassAnswers
from qdot.grader.grading.result import MarkingVersions, NotebookMarks, PartResult, ProblemResult
from qdot.grader.judging.functions import sample_function_arguments
from qdot.grader.judging.verdict import Outcome, Verdict
from qdot.grader.marking.marking import MarkingRules, mark
from qdot.grader.sandbox.sandbox import Limits, Run, Sandbox
from qdot.grader.sandbox.time_budgets import TimeBudgets
from qdot.grader.submissions.answer_locator import Answers, find_answers
from qdot.grader.submissions.cells import OverLimit, Unreadable, empty_self_checks, make_printable
from qdot.grader.submissions.submission import (
    StudentFiles,
    Submission,
    SubmissionNote,
    describe_unusual_metadata,
    explain_wrong_assignment,
    find_modification_time,
    find_python_files,
    read_submission,
    select_likely_notebooks,
)

MAX_ERROR_LENGTH = 300
"""Maximum number of characters that are recorded of an error's message."""
GRADER_VERSION = 25
"""Version of the grader; increase it if a submission may earn different points or if stored results change."""


def read_attempts(student_files: StudentFiles, assignment_key: str) -> list[Submission]:
    """Return the attempts in a student's files, the most likely notebook first.

    If at least one file can be parsed, the files that can't be parsed are omitted, and a note says why.
    """
    files, reason = student_files.files, student_files.ungraded_reason
    if reason:
        return [_make_unreadable_attempt(files[0], reason, student_files.over_limit)]
    likely_paths, note = select_likely_notebooks(files)
    files_with_note = replace(student_files, notes=(*student_files.notes, note)) if note else student_files
    read_file = partial(_read_attempt, files_with_note, assignment_key)
    attempts = [read_file(path) for path in likely_paths]
    if all(attempt.unreadable_reason for attempt in attempts):  # then one readable file among the others suffices
        other_paths = [path for path in files[:MAX_FILES_TRIED] if path not in likely_paths]
        attempts += [attempt for attempt in map(read_file, other_paths) if not attempt.unreadable_reason][:1]
    unreadable_reasons = [attempt.unreadable_reason for attempt in attempts if attempt.unreadable_reason]
    readable_attempts = list[Submission]()
    for attempt in attempts:
        if not attempt.unreadable_reason:
            name = make_printable(attempt.file.name)
            notes = [f"{unreadable_reason}; {name} was graded instead" for unreadable_reason in unreadable_reasons]
            readable_attempts.append(replace(attempt, notes=(*notes, *attempt.notes)))
    return readable_attempts or attempts[:1]


MAX_FILES_TRIED = 10
"""Maximum number of a student's files that are tried if no likely notebook can be parsed."""


def _read_attempt(student_files: StudentFiles, assignment_key: str, path: Path) -> Submission:
    """Return the attempt in a file; if the file can't be parsed, the attempt contains the reason."""
    try:
        submission = read_submission(path, assignment_key, student_files.files)
    except Unreadable as error:
        return _make_unreadable_attempt(path, str(error), isinstance(error, OverLimit))
    notes = (*student_files.notes, *submission.notes)
    submission = replace(submission, notes=notes, flagged_late=student_files.flagged_late)
    if student_files.received is None:
        return submission
    return replace(submission, received=student_files.received, time_source=student_files.platform)


def _make_unreadable_attempt(path: Path, reason: str, over_limit: bool) -> Submission:
    """Return an attempt without content; `over_limit` is whether a limit is the reason why it was not parsed."""
    return Submission(path, find_modification_time(path), unreadable_reason=reason, over_limit=over_limit)


def make_marking_versions(assignment: Assignment, student: str) -> MarkingVersions:
    """Return the versions of qdot's parts, and a digest of the settings that decide this student's points."""
    content = f"{assignment.notebook_digest_of(student)}/{assignment.marking_digest}"
    return MarkingVersions(ENGINE, GRADER_VERSION, hashlib.sha256(content.encode()).hexdigest()[:16])


@dataclass(frozen=True)
class Grader:
    """What a process needs to grade notebooks: the assignment, the sandbox that runs notebooks, and correct answers.

    `class_answers` contains the correct answers to all students' problems, to detect copied answers.
    """

    assignment: Assignment
    sandbox: Sandbox
    class_answers: ClassAnswers


def grade_safely(grader: Grader, student: str, submission: Submission | None) -> NotebookMarks:
    """Grade one notebook like `grade_attempt`; if qdot fails, only this notebook is UNGRADED.

    Raises QdotError if the machine can't run any notebook at all. The caller can then report the error once instead of
    once for each student.
    """
    start_time = time.process_time()
    try:
        marks = grade_attempt(grader, student, submission)
        seconds, memory = grader.sandbox.collect_cost()
        seconds += time.process_time() - start_time
        return replace(marks, seconds=round(seconds, 3), megabytes=round(memory / 1e6, 1))
    except OverLimit as error:
        return mark_ungraded(grader.assignment, student, submission, str(error), over_limit=True)
    except Exception as error:  # an error in qdot must neither become a mark nor stop the grading of the class
        if isinstance(error, QdotError):
            grader.sandbox.run((), ())  # raises QdotError if the machine can't even run an empty notebook
        if (cause := make_open_files_error(error)) is not None:
            raise cause from None
        return mark_ungraded(grader.assignment, student, submission, describe_error(error))


def describe_error(error: Exception) -> str:
    """Return an exception's message on one line, shortened to `MAX_ERROR_LENGTH`."""
    message = str(error) if isinstance(error, QdotError) else f"{type(error).__name__}: {error}"
    return " ".join(message.split())[:MAX_ERROR_LENGTH]


def grade_attempt(grader: Grader, student: str, submission: Submission | None) -> NotebookMarks:
    """Return the marks of a notebook, after loading the student's problems and running the cells.

    `submission` is None if the student submitted nothing. Raises OverLimit if the notebook exceeds a limit.
    """
    assignment = grader.assignment
    problems = load_stored_problems(assignment, student).problems
    sha256 = None if submission is None else submission.sha256
    seed = f"{assignment.secret}/{sha256 or ''}"
    ungraded_reason: str | None = "nothing was submitted"
    answers, notes = Answers(Run()), list[SubmissionNote]()
    if submission is not None:
        if submission.over_limit:
            raise OverLimit(submission.unreadable_reason)
        notes += [SubmissionNote(note, note) for note in submission.notes]
        ungraded_reason = submission.unreadable_reason or explain_wrong_assignment(submission, assignment)
        if ungraded_reason is None:
            answers = run_notebook(grader.sandbox, submission, problems, seed)
            notes += describe_unusual_metadata(submission, assignment, student)
            notes += [SubmissionNote(note, note) for note in answers.notes]
            forbidden_stops = [stop for stop in answers.forbidden_stops if stop not in answers.notes]
            notes += [SubmissionNote(f"refused: {stop}") for stop in forbidden_stops]
    # What follows from a wrong answer to another student's problem earns no points.
    belongs_to_another = submission is not None and submission.qdot_metadata.get("student") not in (None, student)
    follow_through_share = Fraction(0) if belongs_to_another else assignment.follow_through
    mark_problem = partial(mark, secret=assignment.secret, functions_seed=seed, budgets=TimeBudgets())
    results = list[ProblemResult]()
    for slot, problem in problems:
        reasons = {part.name: ungraded_reason or answers.explain_missing(slot, part.name) for part in problem.parts}
        rules = MarkingRules(follow_through_share, partial(grader.class_answers.is_correct_for_another, problem, slot))
        verdicts = mark_problem(problem, answers.map_texts(slot, problem), reasons, rules=rules)
        parts = tuple(make_part_result(slot, verdict) for verdict in verdicts)
        results.append(ProblemResult(str(problem.id), slot, parts))
    return NotebookMarks(
        sha256=sha256, obstacle=ungraded_reason, made_from=make_marking_versions(assignment, student),
        notes=tuple(note.for_student for note in notes if note.for_student),
        staff_notes=tuple(note.for_staff for note in notes if note.for_staff), problems=tuple(results),
    )  # fmt: skip


def run_notebook(
    sandbox: Sandbox, submission: Submission, problems: Sequence[tuple[str, Problem]], seed: str
) -> Answers:
    """Run a notebook in the sandbox and return its answers.

    `problems` are pairs of a slot's name, such as "p1", and the student's problem in it. `seed` selects the
    configurations at which a student's Python functions are called. Raises OverLimit.
    """
    parts = {f"{slot}.{part.name}": part for slot, problem in problems for part in problem.parts}
    parts_in_words = {name for name, part in parts.items() if isinstance(part.answer, Words)}
    arguments = {slot: sample_function_arguments(problem, problem.domain, seed) for slot, problem in problems}
    setup = write_setup_cell(problems)

    def run(cells: Sequence[str | None], names: Sequence[str]) -> Run:
        return _run_with_retries(sandbox, partial(sandbox.run, cells, names, arguments, setup, submission.modules))

    return find_answers(empty_self_checks(submission.cells, problems), list(parts), run, parts_in_words)


def _run_with_retries(sandbox: Sandbox, run: Callable[[], Run]) -> Run:
    """Call `run`, and call it again if the notebook's process dies. Raises RuntimeError if the machine is the cause.

    A process that dies once may be the machine's fault, so only a notebook whose process dies twice is blamed.
    """
    result, crash_count = Run(end="not-started"), 0
    for _ in range(MAX_STARTS):
        result = run()
        if result.end not in ("lost", "not-started"):
            return result
        crash_count += result.end == "lost"
        if crash_count == 2:
            break
    if crash_count < 2 or sandbox.run((), ()).end != "done":  # not the notebook's fault: out of memory or disk space
        reason = sandbox.not_started_reason or "check the free memory and the free space on the disk"
        raise RuntimeError(f"the process that runs notebooks ends by itself: {reason}")
    return result


MAX_STARTS = 5
"""Maximum number of times that a notebook is started if the system ends its process before the notebook runs."""


def make_part_result(slot: str, verdict: Verdict) -> PartResult:
    """Return a verdict on a part of the problem in `slot`, in the form in which results are stored."""
    judgement, diagnosis = verdict.judgement, verdict.diagnosis
    return PartResult(
        name=verdict.part, outcome=judgement.outcome, over_limit=judgement.over_limit, points=verdict.points,
        max_points=verdict.max_points, reason=judgement.reason, certificate=judgement.certificate,
        mistake=None if diagnosis is None else diagnosis.names or None,
        advice=None if diagnosis is None else diagnosis.feedback, followed_from=verdict.followed_from,
        follows=verdict.follows, attempt=verdict.attempt, answer=verdict.answer, entries=judgement.entries,
        group=None if verdict.group is None else format_group_key(f"{slot}.{verdict.part}", verdict.group),
    )  # fmt: skip


def mark_ungraded(
    assignment: Assignment, student: str, submission: Submission | None, cause: str, over_limit: bool = False
) -> NotebookMarks:  # fmt: skip
    """Return marks without points for a notebook that exceeded a limit or that qdot failed to grade."""
    staff_reason = (cause if over_limit else f"qdot could not grade this ({cause})") + "; it has no mark yet"
    reason = f"{staff_reason}. Please tell your instructor"
    ungraded_part = partial(PartResult, outcome=Outcome.UNGRADED, over_limit=over_limit, points=None, reason=reason)
    problems = []
    for slot in assignment.slots:
        questions = zip(slot.questions, slot.max_points, strict=True)
        parts = tuple(ungraded_part(name=name, max_points=points) for name, points in questions)
        problems.append(ProblemResult(str(assignment.make_problem_id(slot, student)), slot.name, parts))
    return NotebookMarks(
        sha256=None if submission is None else submission.sha256, obstacle=reason, staff_notes=(staff_reason,),
        made_from=make_marking_versions(assignment, student), problems=tuple(problems),
    )  # fmt: skip


# --- a notebook without a class ---


def grade_notebook(
    path: Path | str, problems: Mapping[str, Problem], *, secret: str | None = None, limits: Limits | None = None,
    strict: bool = False,
) -> dict[str, list[Verdict]]:  # fmt: skip
    r"""Run a notebook in the sandbox; map each slot ("p1", "p2", …) to the verdicts on its answers.

    `secret` and the notebook determine the configurations at which answers are compared, as in `mark`. `limits` sets
    the time and memory limits. The notebook file is not changed. For late work, several attempts or feedback pages, use
    an assignment and `qdot grade`. Raises QdotError if the file is not a notebook, or if `strict` is set and the
    machine can't fully sandbox a notebook.

    >>> import tempfile
    >>> from qdot import generate
    >>> problem = generate("polar-rp/1", ["determinant"])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "mine.md"
    ...     _ = path.write_text("```python\np1_determinant = '-d2 - 0.7'\n```")
    ...     grade_notebook(path, {"p1": problem})
    {'p1': [Verdict(determinant: correct, 1 of 1)]}
    """
    try:
        submission = read_submission(Path(path), siblings=find_python_files(Path(path)))
    except Unreadable as error:
        raise QdotError(str(error)) from None
    chosen_secret = secrets.token_hex(16) if secret is None else secret
    seed = f"{chosen_secret}/{submission.sha256}"
    with Sandbox(limits, strict=strict) as sandbox:
        try:
            answers = run_notebook(sandbox, submission, list(problems.items()), seed)
        except OverLimit as error:
            raise QdotError(f"{path}: {error}") from None
    verdicts = {}
    for slot, problem in problems.items():
        reasons = {part.name: answers.explain_missing(slot, part.name) for part in problem.parts}
        texts = answers.map_texts(slot, problem)
        verdicts[slot] = mark(problem, texts, reasons, secret=chosen_secret, functions_seed=seed)
    return verdicts
