"""Every report of a graded class, written into graded/, each file at once or not at all."""

from collections.abc import Sequence

from exercises.assignment import Assignment
from exercises.files import remove_left_behind, write_atomically
from grader.batch import Result
from grader.reports.feedback import feedback_page
from grader.reports.tables import grades_csv, results_jsonl


def write_reports(assignment: Assignment, results: Sequence[Result]) -> None:
    """Write feedback pages, results.jsonl and grades.csv."""
    folder = assignment.folder / "graded"
    pages = {result["student"]: folder / "feedback" / f"{result['student']}.html" for result in results}
    remove_left_behind((*pages.values(), folder / "results.jsonl", folder / "grades.csv"))
    by_id = {student.id: student for student in assignment.roster}
    for result in results:
        student = by_id[result["student"]]
        write_atomically(pages[student.id], feedback_page(assignment, student, result))
    write_atomically(folder / "results.jsonl", results_jsonl(results))
    write_atomically(folder / "grades.csv", grades_csv(results, assignment.roster))
