"""Every report of a graded class, written into graded/, each file at once or not at all."""

from collections.abc import Sequence

from exercises.assignment import Assignment
from exercises.files import write_atomically
from grader.batch import Result
from grader.reports.feedback import feedback_page
from grader.reports.tables import grades_csv, results_jsonl


def write_reports(assignment: Assignment, results: Sequence[Result]) -> None:
    """Write feedback pages, results.jsonl and grades.csv."""
    folder = assignment.folder / "graded"
    by_id = {student.id: student for student in assignment.roster}
    for result in results:
        student = by_id[result["student"]]
        write_atomically(folder / "feedback" / f"{student.id}.html", feedback_page(assignment, student, result))
    write_atomically(folder / "results.jsonl", results_jsonl(results))
    write_atomically(folder / "grades.csv", grades_csv(results, assignment.roster))
