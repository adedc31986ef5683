"""Compute a student's result from what is submitted, with the functions that `qdot grade` uses."""

import json
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from pathlib import PurePath

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.common.json_form import parse_dataclass
from qdot.grader.grading.attempt import mark_ungraded
from qdot.grader.grading.final_result import GradedNotebook, compute_final_result
from qdot.grader.grading.overrides import Overrides, flatten_answer
from qdot.grader.grading.result import NotebookMarks, Override, Result
from qdot.grader.judging.verdict import Outcome
from qdot.grader.serve.models import Classroom, Person, PointsOverride, Submission

NOTHING_SUBMITTED = "nothing was submitted"


def list_submissions(person: Person, key: str) -> list[Submission]:
    """Return what a student has submitted, the newest first, without the contents of files."""
    submissions = Submission.objects.filter(person=person, assignment=key).defer("content", "shown")
    return list(submissions.order_by("-received", "-id"))


def select_attempts(assignment: Assignment, submissions: Sequence[Submission]) -> tuple[list[Submission], set[int]]:
    """Return the submissions by which the attempts are decided, in the order received, and the ids of those that count.

    `submissions` begin with the newest. Of each attempt, these are the first, from which its time runs, and the last.
    """
    if not submissions:
        return [], set()
    times, policy = [submission.received for submission in submissions], assignment.attempt_policy
    counting = policy.select_counting_indices(times)
    first = [attempt[0] for attempt in policy.group_attempts(times)] if policy.best_of is not None else []
    first = [i for i in first if times[i] not in {times[k] for k in counting}]
    return [submissions[i] for i in sorted({*first, *counting}, reverse=True)], {submissions[i].pk for i in counting}


def read_marks(submission: Submission, uses_new_marks: bool = False) -> NotebookMarks | None:
    """Return the marks of a submission; None if it isn't marked yet."""
    marks = submission.remarked["marks"] if uses_new_marks and submission.remarked else submission.marks
    return None if marks is None else parse_dataclass(NotebookMarks, json.dumps(marks))


def name_file(assignment: Assignment, submission: Submission) -> str:
    """Return the name of the file as which a submission is exported."""
    suffix = PurePath(submission.file_name).suffix if submission.file_name else ".ipynb"
    return f"{assignment.key}{suffix}"


def compute_result(
    assignment: Assignment,
    student: Student,
    submissions: Sequence[Submission],
    overrides: Overrides,
    uses_new_marks: bool = False,
) -> Result:
    """Return a student's result. Submissions that are not marked yet are left out.

    If `uses_new_marks`, marks of a second marking count instead of the first ones.
    """
    marked = [submission for submission in submissions if submission.marks is not None]
    attempts, counting = select_attempts(assignment, marked)
    notebooks = [
        GradedNotebook(
            name_file(assignment, submission), submission.received,
            read_marks(submission, uses_new_marks) if submission.pk in counting else None,
        )
        for submission in attempts
    ]  # fmt: skip
    notebooks = notebooks or [GradedNotebook(marks=make_empty_marks(assignment, student.id))]
    return compute_final_result(assignment, student, notebooks, overrides)


def make_empty_marks(assignment: Assignment, student: str) -> NotebookMarks:
    """Return the marks of a student who has submitted nothing."""
    marks = mark_ungraded(assignment, student, None, NOTHING_SUBMITTED)
    problems = [
        replace(
            problem,
            parts=tuple(
                replace(part, outcome=Outcome.MISSING, points=0.0, reason=NOTHING_SUBMITTED) for part in problem.parts
            ),
        )
        for problem in marks.problems
    ]
    return replace(marks, obstacle=NOTHING_SUBMITTED, staff_notes=(), problems=tuple(problems))


def load_overrides(classroom: Classroom, key: str) -> Overrides:
    """Return the points and comments that people have set for a class."""
    by_part: dict[tuple[str, str, str], Override] = {}
    by_group: dict[str, Override] = {}
    for row in PointsOverride.objects.filter(classroom=classroom, assignment=key).select_related("person"):
        if row.person is None:
            by_group[row.group] = Override(row.points, row.comment, was=None, group=row.group)
        else:
            target = (row.person.student_id, row.part, flatten_answer(row.answer))
            by_part[target] = Override(row.points, row.comment, was=None)
    return Overrides(by_part, by_group)


def load_submissions(assignment: Assignment, classroom: Classroom) -> dict[str, list[Submission]]:
    """Return what each student of a class has submitted, the newest first."""
    by_student: dict[str, list[Submission]] = defaultdict(list)
    rows = Submission.objects.filter(person__classroom=classroom, assignment=assignment.key)
    for submission in rows.defer("content", "shown").select_related("person").order_by("-received", "-id"):
        by_student[submission.person.student_id].append(submission)
    return by_student


def compute_results(assignment: Assignment, classroom: Classroom, uses_new_marks: bool = False) -> list[Result]:
    """Return the results of a class in the order of the roster."""
    by_student, overrides = load_submissions(assignment, classroom), load_overrides(classroom, assignment.key)
    return [
        compute_result(assignment, student, by_student.get(student.id, []), overrides, uses_new_marks)
        for student in assignment.roster
    ]


def load_result(person: Person, assignment: Assignment, student: Student) -> Result:
    """Return the result of one student."""
    overrides = load_overrides(person.classroom, assignment.key)
    return compute_result(assignment, student, list_submissions(person, assignment.key), overrides)
