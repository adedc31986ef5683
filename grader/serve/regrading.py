"""Mark a class again after a change of the assignment or of qdot. The staff must accept the changed marks."""

import hashlib
import json
from collections.abc import Sequence
from contextlib import suppress
from typing import Any, NamedTuple

from django.db import transaction

from qdot.exercises.assignment.assignment import Assignment
from qdot.grader.grading.attempt import make_marking_versions
from qdot.grader.grading.history import find_mark_changes
from qdot.grader.grading.result import Result
from qdot.grader.judging.verdict import AWAITS_PERSON
from qdot.grader.serve.errors import Refused
from qdot.grader.serve.lti.outbox import update_scores
from qdot.grader.serve.marking_online import mark_again
from qdot.grader.serve.models import Classroom, Person, Submission
from qdot.grader.serve.scores import compute_results, load_marks, load_submissions, select_marked

PRIORITY = -10
"""The priority in the queue; notebooks that students have just submitted have 0, which is higher."""


class Regrading(NamedTuple):
    """How many submissions are still to be marked again, or else the changed marks, which the token identifies."""

    waiting: int
    changes: list[dict[str, Any]]
    token: str


def find_outdated(assignment: Assignment, classroom: Classroom) -> list[int]:
    """Return the ids of submissions that count but were marked incompletely, or with other settings or versions."""
    outdated_ids = list[int]()
    for student, submissions in load_submissions(assignment, classroom).items():
        _, counting_ids = select_marked(assignment, submissions)
        versions = make_marking_versions(assignment, student)
        for submission_id, marks in load_marks(counting_ids).items():
            parts = [part for problem in marks.problems for part in problem.parts]
            has_failed = any(part.points is None and part.reason != AWAITS_PERSON for part in parts)
            if marks.made_from != versions or has_failed:
                outdated_ids.append(submission_id)
    return outdated_ids


def count_outdated(assignment: Assignment, results: Sequence[Result]) -> int:
    """Return the number of students whose submission was marked with other settings or another version of qdot."""
    return sum(
        result.submission is not None and result.made_from != make_marking_versions(assignment, result.student)
        for result in results
    )


def continue_regrading(assignment: Assignment, classroom: Classroom) -> Regrading:
    """Begin to mark the outdated submissions again. In later calls, return the progress, then the changed marks."""
    rows = Submission.objects.filter(person__classroom=classroom, assignment=assignment.key, remarked__isnull=False)
    if not rows.exists():
        with transaction.atomic():
            for submission_id in find_outdated(assignment, classroom):
                Submission.objects.filter(pk=submission_id).update(remarked={})
                mark_again.using(priority=PRIORITY).enqueue(submission_id)
    waiting = rows.filter(remarked={}).count()
    if waiting:
        return Regrading(waiting, [], "")
    people = {person.student_id: person for person in classroom.people.all()}
    old_results = {result.student: result for result in compute_results(assignment, classroom)}
    changes = [
        {
            "student": people[change.student].pk, "name": people[change.student].name or change.student,
            "part": change.part, "before": _read_points(change.old_points), "after": _read_points(change.new_points),
        }
        for change in find_mark_changes(old_results, compute_results(assignment, classroom, uses_new_marks=True))
        if change.old_points != change.new_points
    ]  # fmt: skip
    content = json.dumps([changes, sorted(rows.values_list("pk", flat=True))])
    return Regrading(0, changes, hashlib.sha256(content.encode()).hexdigest()[:16])


def _read_points(text: str) -> float | None:
    """Return points as a number; None for a part that has no mark, or that only one of two results has."""
    with suppress(ValueError):
        return float(text)
    return None


def accept_regrading(assignment: Assignment, classroom: Classroom, token: str) -> int:
    """Make the new marks count; return the number of submissions. Raises Refused if they aren't those of the token."""
    with transaction.atomic():
        regrading = continue_regrading(assignment, classroom)
        if regrading.waiting or regrading.token != token:
            raise Refused(409, "The marks have changed in the meantime. Look at the changes again.")
        rows = Submission.objects.filter(person__classroom=classroom, assignment=assignment.key)
        rows = rows.filter(remarked__isnull=False).select_related("person__classroom")
        people = dict[int, Person]()
        for row in rows:
            new_marks = row.remarked or {}
            row.set_marks(new_marks["marks"], new_marks["shown"])
            people[row.person.pk] = row.person
        for person in people.values():
            update_scores(person, assignment.key)
    return len(rows)
