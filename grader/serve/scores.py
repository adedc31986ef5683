"""Compute a student's result from what is submitted, with the functions that `qdot grade` uses."""

import json
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import PurePath

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.common.json_form import parse_dataclass
from qdot.grader.grading.attempt import mark_ungraded
from qdot.grader.grading.final_result import GradedNotebook, compute_final_result
from qdot.grader.grading.overrides import Overrides, flatten_answer
from qdot.grader.grading.result import NotebookMarks, Override, Result
from qdot.grader.judging.functions import FUNCTION_TEXT
from qdot.grader.judging.verdict import Outcome
from qdot.grader.serve.models import Classroom, Person, PointsOverride, Submission

LARGE_FIELDS = ("content", "answers", "marks", "shown", "remarked")
"""The fields of a submission that are loaded only when they are needed."""
NOTHING_SUBMITTED = "nothing was submitted"


def list_submissions(person: Person, key: str) -> list[Submission]:
    """Return a student's submissions, the newest first, without `LARGE_FIELDS`."""
    submissions = Submission.objects.filter(person=person, assignment=key).defer(*LARGE_FIELDS)
    return list(submissions.order_by("-received", "-id"))


def select_attempts(assignment: Assignment, submissions: Sequence[Submission]) -> tuple[list[Submission], set[int]]:
    """Return the submissions that determine the attempts, in the order received, and the ids of those that count.

    `submissions` begin with the newest. An attempt is determined by its first submission, at which its time begins, and
    by its last.
    """
    if not submissions:
        return [], set()
    times, policy = [submission.received for submission in submissions], assignment.attempt_policy
    counting_indices = policy.select_counting_indices(times)
    counting_times = {times[i] for i in counting_indices}
    attempts = policy.group_attempts(times) if policy.best_of is not None else []
    first_indices = {attempt[0] for attempt in attempts if times[attempt[0]] not in counting_times}
    indices = sorted({*first_indices, *counting_indices}, reverse=True)
    return [submissions[i] for i in indices], {submissions[i].pk for i in counting_indices}


def select_marked(assignment: Assignment, submissions: Sequence[Submission]) -> tuple[list[Submission], set[int]]:
    """Return what `select_attempts` returns for those submissions that are marked."""
    return select_attempts(assignment, [row for row in submissions if row.state == Submission.State.MARKED])


def load_marks(submission_ids: Iterable[int], uses_new_marks: bool = False) -> dict[int, NotebookMarks]:
    """Map the ids of marked submissions to the marks, or, if `uses_new_marks`, to the marks of a second marking."""
    rows = Submission.objects.filter(pk__in=list(submission_ids)).values_list("pk", "marks", "remarked")
    all_marks = {pk: new_marks["marks"] if uses_new_marks and new_marks else marks for pk, marks, new_marks in rows}
    return {pk: parse_dataclass(NotebookMarks, json.dumps(marks)) for pk, marks in all_marks.items() if marks}


def name_file(assignment: Assignment, submission: Submission) -> str:
    """Return the name of the file to which a submission is exported."""
    suffix = PurePath(submission.file_name).suffix if submission.file_name else ".ipynb"
    return f"{assignment.key}{suffix}"


def list_notebook_answers(submission: Submission) -> dict[str, str]:
    """Map each part to its answer in a notebook that is marked, except for Python functions, which nobody can type."""
    return {
        f"{problem['slot']}.{part['name']}": part["answer"]
        for problem in (submission.marks or {"problems": []})["problems"]
        for part in problem["parts"]
        if part["answer"] not in (None, FUNCTION_TEXT) and part["outcome"] != Outcome.MISSING
    }


def compute_result(
    assignment: Assignment, student: Student, submissions: Sequence[Submission], overrides: Overrides
) -> Result:
    """Return a student's result; `submissions` begin with the newest. Those that are not marked yet are left out."""
    (result,) = _compute_results(assignment, [student], {student.id: submissions}, overrides)
    return result


def _compute_results(
    assignment: Assignment, students: Iterable[Student], submissions: Mapping[str, Sequence[Submission]],
    overrides: Overrides, uses_new_marks: bool = False,
) -> list[Result]:  # fmt: skip
    """Return the results of students, given the submissions of each."""
    selections = {student: select_marked(assignment, submissions.get(student.id, ())) for student in students}
    all_marks = load_marks({pk for _, counting_ids in selections.values() for pk in counting_ids}, uses_new_marks)
    results = list[Result]()
    for student, (attempts, _) in selections.items():
        notebooks = [
            GradedNotebook(name_file(assignment, attempt), attempt.received, all_marks.get(attempt.pk))
            for attempt in attempts
        ]
        notebooks = notebooks or [GradedNotebook(marks=make_empty_marks(assignment, student.id))]
        results.append(compute_final_result(assignment, student, notebooks, overrides))
    return results


def make_empty_marks(assignment: Assignment, student: str) -> NotebookMarks:
    """Return the marks of a student who has submitted nothing."""
    marks = mark_ungraded(assignment, student, None, NOTHING_SUBMITTED)
    make_missing = partial(replace, outcome=Outcome.MISSING, points=0.0, reason=NOTHING_SUBMITTED)
    problems = tuple(replace(problem, parts=tuple(map(make_missing, problem.parts))) for problem in marks.problems)
    return replace(marks, obstacle=NOTHING_SUBMITTED, staff_notes=(), problems=problems)


def load_overrides(classroom: Classroom, key: str) -> Overrides:
    """Return the points and comments that people have set for a class."""
    by_part: dict[tuple[str, str, str], Override] = {}
    by_group: dict[str, Override] = {}
    for row in PointsOverride.objects.filter(classroom=classroom, assignment=key).select_related("person"):
        if row.person is None:
            by_group[row.group] = Override(row.points, row.comment, None, row.group)
        else:
            target = (row.person.student_id, row.part, flatten_answer(row.answer))
            by_part[target] = Override(row.points, row.comment, None)
    return Overrides(by_part, by_group)


def load_submissions(assignment: Assignment, classroom: Classroom) -> dict[str, list[Submission]]:
    """Return the submissions of each student of a class, the newest first."""
    by_student: dict[str, list[Submission]] = defaultdict(list)
    rows = Submission.objects.filter(person__classroom=classroom, assignment=assignment.key)
    for submission in rows.defer(*LARGE_FIELDS).select_related("person").order_by("-received", "-id"):
        by_student[submission.person.student_id].append(submission)
    return by_student


def compute_results(assignment: Assignment, classroom: Classroom, uses_new_marks: bool = False) -> list[Result]:
    """Return the results of a class in the order of the roster."""
    submissions, overrides = load_submissions(assignment, classroom), load_overrides(classroom, assignment.key)
    return _compute_results(assignment, assignment.roster, submissions, overrides, uses_new_marks)


def load_result(person: Person, assignment: Assignment, student: Student) -> Result:
    """Return the result of one student."""
    overrides = load_overrides(person.classroom, assignment.key)
    return compute_result(assignment, student, list_submissions(person, assignment.key), overrides)
