"""One student graded by themselves: a notebook or folder that is known to be theirs, received when it is said to be."""

import datetime
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.lateness import with_zone
from qdot.exercises.common.errors import QdotError, unknown
from qdot.grader.grading.batch import grade_class
from qdot.grader.grading.result import Result
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import StudentFiles, find_files_of_student


def limits_of(seconds: float) -> Limits:
    """Return the limits of a notebook that may take so long, and what each of its cells may take of that."""
    return Limits(seconds=seconds, cell_seconds=max(1.0, seconds / 2))


def student_named(assignment: Assignment, identifier: str) -> Student:
    """Return a student of the roster. Raises QdotError."""
    for student in assignment.roster:
        if student.id == identifier:
            return student
    raise unknown("student", identifier, [student.id for student in assignment.roster][:50])


def read_time(text: str) -> datetime.datetime:
    """Return a time as ISO 8601 writes it; without a zone, it is the machine's. Raises QdotError."""
    try:
        return with_zone(datetime.datetime.fromisoformat(text))
    except ValueError:
        raise QdotError(f"{text!r} is no time; write it as in 2027-01-15T23:59:00+01:00") from None


def found_of_one(
    assignment: Assignment, path: Path, received: datetime.datetime | None = None, told_by: str = "option"
) -> StudentFiles | None:
    """Return what a student handed in: a notebook, or a folder with it. Raises QdotError where there is neither."""
    if not path.exists():
        raise QdotError(f"{path} does not exist; with one student, it is their notebook, or a folder with it")
    return find_files_of_student(path, assignment.key, told_by if received else "", received)


def grade_one(assignment: Assignment, student: Student, found: StudentFiles | None, limits: Limits) -> Result:
    """Return a student's result.

    Nothing is written but graded/.cache, from which it is taken the next time; its files are written whole, so that
    several may do this at once.
    """
    submissions = {} if found is None else {student.id: found}
    return grade_class(assignment, submissions, 1, limits, lambda _: None, [student])[0]
