"""Compute a student's result from the graded notebooks: choose the attempt, apply overrides and the late penalty.

No answer is judged again here, so a changed override or late rule takes effect without running notebooks. The score is
the sum of the parts' points minus the late penalty. A person can override the points of a part or the total.
"""

import datetime
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.late_rule import add_time_zone
from qdot.exercises.common.errors import write_first
from qdot.grader.grading.attempt import describe_error, mark_ungraded
from qdot.grader.grading.overrides import NO_OVERRIDES, TOTAL_PART, Overrides
from qdot.grader.grading.result import (
    CountingSubmission,
    Lateness,
    NotebookMarks,
    PartResult,
    Result,
    SubmittedNotebook,
)
from qdot.grader.judging.verdict import AWAITS_PERSON, MARKED_BY_PERSON, Outcome
from qdot.grader.marking.marking import sum_points

MAX_FILES_LISTED = 5
"""Maximum number of file names listed in a note."""


@dataclass(frozen=True)
class GradedNotebook:
    """A student's notebook and its marks; `marks` is None if the notebook was not graded.

    `file` is the file's name, or empty if nothing was submitted. `time_source` is the source of the time `received`: a
    platform's name, or "file". `flagged_late` is whether the platform itself flagged the work as late; None if the
    platform doesn't report this.
    """

    file: str = ""
    received: datetime.datetime | None = None
    marks: NotebookMarks | None = None
    time_source: str = "file"
    flagged_late: bool | None = None


def compute_final_result(
    assignment: Assignment, student: Student, notebooks: Sequence[GradedNotebook], overrides: Overrides = NO_OVERRIDES
) -> Result:
    """Return a student's result. `notebooks` contains all attempts in the order in which they were received.

    The graded notebook with the most points counts. If several notebooks have the most points, the first of them
    counts. For this choice, a part that qdot failed to grade counts as full marks, so that another attempt doesn't hide
    the failure.
    """
    make_result = partial(_make_result, assignment, student, overrides)
    results = {i: make_result(notebook, notebook.marks) for i, notebook in enumerate(notebooks) if notebook.marks}
    chosen_index = max(results, key=lambda i: _sum_possible_points(results[i]))
    result = results[chosen_index]
    if len(notebooks) == 1:
        return result
    other_files = [notebook.file for i, notebook in enumerate(notebooks) if i != chosen_index]
    choice_words = f", the {assignment.attempt_policy} one," if len(results) > 1 else ""
    tie_remark = ""
    if not assignment.attempt_policy.best_of:
        tied_count = sum(notebook.received == notebooks[chosen_index].received for notebook in notebooks)
        if tied_count == 1:
            choice_words = ", the last one,"
        else:
            tie_remark = (
                f". The last {tied_count} were received at the same time; qdot chose the one with the likeliest name"
            )
    listing = write_first(other_files, MAX_FILES_LISTED)
    note = f"{len(notebooks)} notebooks were submitted; {notebooks[chosen_index].file}{choice_words} counts, "
    note += f"and {listing} {'does' if len(other_files) == 1 else 'do'} not{tie_remark}"
    if assignment.attempt_policy.best_of is not None and len(results) < len(notebooks):
        note += f"; {assignment.attempt_policy.rule}"
    scores = [results[i].score if i in results else None for i in range(len(notebooks))]
    times = [_format_time(notebook.received) for notebook in notebooks]
    attempts = map(SubmittedNotebook, [notebook.file for notebook in notebooks], times, scores)
    notes, staff_notes = (note, *result.notes), (note, *result.staff_notes)
    return replace(result, attempts=tuple(attempts), notes=notes, staff_notes=staff_notes)


def make_ungraded_result(assignment: Assignment, student: Student, file: str, error: Exception) -> Result:
    """Return a result without marks, to replace a result that qdot itself failed to compute or report."""
    marks = mark_ungraded(assignment, student.id, None, describe_error(error))
    return compute_final_result(assignment, student, [GradedNotebook(file, marks=marks)])


def _make_result(
    assignment: Assignment, student: Student, overrides: Overrides, notebook: GradedNotebook, marks: NotebookMarks
) -> Result:
    """Return the result that the student would have if this notebook counted."""
    staff_notes = list(marks.staff_notes)

    def apply_override(slot: str, part: PartResult) -> PartResult:
        """Return a part with its override, which also records qdot's points.

        If qdot has no verdict, the outcome follows from the points; otherwise, outcome and reason stay unchanged.
        """
        name = f"{slot}.{part.name}"
        override = overrides.find(student.id, name, part.answer or "") or overrides.by_group.get(part.group or "")
        if override is None:
            if overrides.has_marked_answer(student.id, name):
                staff_notes.append(f"the answer to {name} has changed since a person marked it")
            return part
        points = part.points if override.points is None else override.points
        outcome = part.outcome
        if outcome is Outcome.UNGRADED and points is not None:
            outcome = Outcome.PARTIAL if points < part.max_points else Outcome.CORRECT
            outcome = Outcome.WRONG if points == 0 else outcome
        reason = MARKED_BY_PERSON if part.reason == AWAITS_PERSON and points is not None else part.reason
        override = replace(override, previous_points=part.points)
        return replace(part, outcome=outcome, points=points, override=override, reason=reason)

    part_lists = [tuple(apply_override(problem.slot, part) for part in problem.parts) for problem in marks.problems]
    problems = tuple(replace(problem, parts=parts) for problem, parts in zip(marks.problems, part_lists, strict=True))
    parts = [part for parts in part_lists for part in parts]
    points = sum_points(part.points for part in parts)
    late = None if notebook.flagged_late is False else _find_lateness(assignment, student, notebook.received, points)
    score = points if late is None else _subtract_share(points, Fraction(str(late.penalty)))
    total_override = overrides.find(student.id, TOTAL_PART)
    submission = CountingSubmission(notebook.file, marks.sha256, _format_time(notebook.received), notebook.time_source)
    return Result(
        student=student.id, assignment=assignment.key, submission=submission if notebook.file else None,
        score=score if total_override is None or total_override.points is None else total_override.points,
        max_score=sum_points(part.max_points for part in parts), late=late,
        override=total_override and replace(total_override, previous_points=score), obstacle=marks.obstacle,
        notes=marks.notes, staff_notes=tuple(staff_notes), made_from=marks.made_from, problems=problems,
    )  # fmt: skip


def _find_lateness(
    assignment: Assignment, student: Student, received: datetime.datetime | None, points: float
) -> Lateness | None:
    """Return the notebook's delay in seconds and the share deducted for it, or None if it is on time."""
    deadline = assignment.due_date_of(student)
    if deadline is None or received is None:
        return None
    rule = assignment.late_rule
    seconds = (received - deadline).total_seconds()
    if seconds <= (0 if rule is None else rule.grace):
        return None
    # The time by which this student's deadline is later than that of the class.
    extension = datetime.timedelta(0) if assignment.due_date is None else deadline - add_time_zone(assignment.due_date)
    penalty = Fraction(0) if rule is None else rule.compute_penalty(deadline, received, extension)
    return Lateness(deadline.isoformat(), received.isoformat(), int(seconds), float(penalty), points)


def _subtract_share(points: float, share: Fraction) -> float:
    """Return the points minus the given share of them; the deduction is rounded to four decimals.

    >>> _subtract_share(0.7, Fraction(1, 10))
    0.63
    """
    exact_points = Fraction(str(points))
    return float(exact_points - round(exact_points * share, 4))


def _sum_possible_points(result: Result) -> Fraction:
    """Return the score of a result plus full marks for each part that qdot failed to grade."""
    ungraded_max_points = [part.max_points for part in result.parts.values() if part.points is None]
    return Fraction(str(result.score)) + sum(Fraction(str(points)) for points in ungraded_max_points)


def _format_time(moment: datetime.datetime | None) -> str | None:
    """Return a time as text in ISO 8601; None stays None."""
    return None if moment is None else moment.isoformat()
