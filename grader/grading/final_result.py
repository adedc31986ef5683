"""Turn what the grader gave for notebooks into a student's result: overrides, lateness, and which attempt counts.

Nothing is marked here, so that a changed override or late rule takes effect at once. The score is the sum of the
parts' points, as the grader gave them or a person set them, less the late penalty; or a total that a person set.
"""

import datetime
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.lateness import with_zone
from qdot.grader.grading.attempt import mark_ungraded
from qdot.grader.grading.marking import sum_points
from qdot.grader.grading.overrides import NO_OVERRIDES, TOTAL, Overrides
from qdot.grader.grading.result import CountingSubmission, Lateness, Marked, PartResult, ReadNotebook, Result

MOST_NAMED = 5
"""Files that are named in a sentence."""


@dataclass(frozen=True)
class Graded:
    """What the grader gave for a notebook of a student; `marked` is None if the notebook doesn't count.

    `file` is empty if nothing was handed in. `received_from` is the source of the time: a platform, or "file". `late`
    is a platform's own mark, if it makes one.
    """

    file: str = ""
    received: datetime.datetime | None = None
    marked: Marked | None = None
    received_from: str = "file"
    late: bool | None = None


def settle(
    assignment: Assignment, student: Student, handed_in: Sequence[Graded], overrides: Overrides = NO_OVERRIDES
) -> Result:
    """Return a student's result from everything that was handed in, in the order in which it was received.

    Of several graded notebooks, the one that earns most counts; of equal ones, the first. A part on which qdot failed
    counts in full here, so that the failure is reported and not passed over.
    """
    results = {
        i: _result_if_counting(assignment, student, graded, graded.marked, overrides)
        for i, graded in enumerate(handed_in)
        if graded.marked
    }
    counts = max(results, key=lambda i: _greatest_worth(results[i]))
    result = results[counts]
    if len(handed_in) == 1:
        return result
    not_counting = [graded.file for i, graded in enumerate(handed_in) if i != counts]
    more = f" and {len(not_counting) - MOST_NAMED} more" if len(not_counting) > MOST_NAMED else ""
    rank = f", the {assignment.attempts}" if len(results) > 1 else ""
    if not assignment.attempts.best_of:
        last = sum(graded.received == handed_in[counts].received for graded in handed_in)
        rank = ", the last" if last == 1 else f", of the last {last}, received at the same time, the likeliest by name"
    note = (
        f"{len(handed_in)} notebooks were read; {handed_in[counts].file} counts{rank}, "
        f"not {', '.join(not_counting[:MOST_NAMED])}{more}"
    )
    if assignment.attempts.best_of is not None and len(results) < len(handed_in):
        note += f"; {assignment.attempts.rule}"
    attempts = tuple(
        ReadNotebook(graded.file, _iso_time(graded.received), results[i].score if i in results else None)
        for i, graded in enumerate(handed_in)
    )
    notes, staff_notes = (note, *result.notes), (note, *result.staff_notes)
    return replace(result, attempts=attempts, notes=notes, staff_notes=staff_notes)


def ungraded_result(assignment: Assignment, result: Result, why: str) -> Result:
    """Return a result without a mark in place of one on which qdot itself failed."""
    student = next(student for student in assignment.roster if student.id == result.student)
    file = "" if result.submission is None else result.submission.file
    return settle(assignment, student, [Graded(file, marked=mark_ungraded(assignment, student.id, None, why))])


def _result_if_counting(
    assignment: Assignment, student: Student, graded: Graded, marked: Marked, overrides: Overrides
) -> Result:
    """Return the student's result if this notebook is the one that counts."""
    of_student = overrides.of_students.get(student.id, {})

    def apply_override(slot: str, part: PartResult) -> PartResult:
        """Return a part with the points that a person set and the grader's own; its outcome and reason stay."""
        override = of_student.get(f"{slot}.{part.name}") or overrides.of_groups.get(part.group or "")
        if override is None:
            return part
        points = part.points if override.points is None else override.points
        return replace(part, points=points, override=override.applied_to(part.points))

    problems = tuple(
        replace(problem, parts=tuple(apply_override(problem.slot, part) for part in problem.parts))
        for problem in marked.problems
    )
    parts = [part for problem in problems for part in problem.parts]
    before = sum_points(part.points for part in parts)
    late = None if graded.late is False else _lateness(assignment, student, graded.received, before)
    score = before if late is None else _subtract_share(before, Fraction(str(late.penalty)))
    of_total = of_student.get(TOTAL)
    submission = CountingSubmission(graded.file, marked.sha256, _iso_time(graded.received), graded.received_from)
    return Result(
        student=student.id,
        assignment=assignment.key,
        submission=submission if graded.file else None,
        score=score if of_total is None or of_total.points is None else of_total.points,
        max_score=sum_points(part.max_points for part in parts),
        late=late,
        override=None if of_total is None else of_total.applied_to(score),
        obstacle=marked.obstacle,
        notes=marked.notes,
        staff_notes=marked.staff_notes,
        made_from=marked.made_from,
        problems=problems,
    )


def _lateness(
    assignment: Assignment, student: Student, received: datetime.datetime | None, points: float
) -> Lateness | None:
    """Return by how much work is late and the share of its points that this costs; None if it is on time."""
    deadline = assignment.due_of(student)
    if deadline is None or received is None:
        return None
    rule = assignment.late
    seconds = (received - deadline).total_seconds()
    if seconds <= (0 if rule is None else rule.grace):
        return None
    extension = datetime.timedelta(0) if assignment.due_date is None else deadline - with_zone(assignment.due_date)
    penalty = Fraction(0) if rule is None else rule.penalty(deadline, received, extension)
    return Lateness(deadline.isoformat(), received.isoformat(), int(seconds), float(penalty), points)


def _subtract_share(points: float, share: Fraction) -> float:
    """Return points less a share of them, which is rounded to four decimals.

    >>> _subtract_share(0.7, Fraction(1, 10))
    0.63
    """
    exact = Fraction(str(points))
    return float(exact - round(exact * share, 4))


def _greatest_worth(result: Result) -> Fraction:
    """Return a result's points, with full marks for what qdot failed on."""
    without_points = [part.max_points for part in result.parts.values() if part.points is None]
    return Fraction(str(result.score)) + sum(Fraction(str(points)) for points in without_points)


def _iso_time(moment: datetime.datetime | None) -> str | None:
    return None if moment is None else moment.isoformat()
