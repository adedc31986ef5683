"""Write the reports of a graded class into graded/; every file is written atomically, results.jsonl last."""

import contextlib
import os
from collections.abc import Callable, Sequence
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import clean_up_after, sync_disks_after, write_atomically
from qdot.exercises.common.parallel import map_in_order, return_state
from qdot.grader.grading.final_result import make_ungraded_result
from qdot.grader.grading.history import results_path, store_previous_results
from qdot.grader.grading.result import Result
from qdot.grader.reports.feedback import compute_page_fingerprint, make_feedback_page
from qdot.grader.reports.grades_table import TO_MARK_FILE, make_grades_csv, make_results_jsonl, make_to_mark_csv

FINGERPRINT_WINDOW = 1000
"""Number of characters at the beginning of a page that contain its fingerprint."""

PAGE_END = b"</html>\n"
"""The end of every complete page; a page lacks this end if a power failure interrupted writing."""


def write_reports(
    assignment: Assignment, results: Sequence[Result], jobs: int = 1, report_progress: Callable[[], None] = lambda: None
) -> list[Result]:
    """Write the feedback pages that are not up to date, grades.csv, to-mark.csv and results.jsonl.

    Return the results as written: if a student's page or line can't be made, the result says that qdot failed.
    `report_progress` is called for every page. The results of the previous run are added to the history before new ones
    replace them. Raises QdotError if a file can't be written.
    """
    folder = assignment.folder / "graded"
    by_id = {student.id: student for student in assignment.roster}
    pairs = [(by_id[result.student], result) for result in results]
    pairs = [(student, _replace_if_unwritable(assignment, student, result)) for student, result in pairs]
    result_by_student = {student.id: result for student, result in pairs}
    # Drawing the figures takes most of the time, so only outdated pages are written, on several processes.
    outdated_pairs = [pair for pair in pairs if not _is_up_to_date(assignment, *pair)]
    unwritten_students = []
    # The result is None if every attempt to write a page crashes its process.
    result_if_lost = (lambda _: None) if jobs > 1 else None
    grades_path, lines_path, to_mark_path = folder / "grades.csv", results_path(assignment), folder / TO_MARK_FILE
    paths = [*(_find_page_path(folder, student) for student, _ in pairs), lines_path, grades_path, to_mark_path]
    page_results = map_in_order(
        _write_or_mark_ungraded, outdated_pairs, jobs, setup=return_state, arguments=(assignment,),
        result_if_lost=result_if_lost,
    )  # fmt: skip
    with clean_up_after(paths):
        with contextlib.closing(page_results), sync_disks_after():
            for (student, _), result in zip(outdated_pairs, page_results, strict=True):
                if result is None:
                    unwritten_students.append(student.id)
                else:
                    result_by_student[student.id] = result
                report_progress()
        for _ in range(len(pairs) - len(outdated_pairs)):
            report_progress()
        final_results = list(result_by_student.values())
        store_previous_results(assignment, final_results)
        write_atomically(grades_path, make_grades_csv(final_results, assignment.roster), 0o600)
        if (to_mark := make_to_mark_csv(final_results)) is not None:
            write_atomically(to_mark_path, to_mark, 0o600)
        else:
            to_mark_path.unlink(missing_ok=True)
        write_atomically(lines_path, make_results_jsonl(final_results), 0o600)
    if unwritten_students:
        raise QdotError(
            f"no feedback page for {', '.join(unwritten_students)}: the system ended the process that wrote it, "
            "probably because memory ran out. The grades are complete. Run the same command again to write the page"
        )
    return final_results


def _replace_if_unwritable(assignment: Assignment, student: Student, result: Result) -> Result:
    """Return the result if it can be written as a line of each table; otherwise, a result that says why qdot failed."""
    try:
        make_results_jsonl([result])
        make_grades_csv([result], assignment.roster)
        make_to_mark_csv([result])
        return result
    except Exception as error:  # an error in one student's result must not stop the others
        return make_ungraded_result(assignment, student, result.file, error)


def write_page(assignment: Assignment, student: Student, result: Result) -> None:
    """Write a student's feedback page. Raises QdotError if it can't be written."""
    page = _find_page_path(assignment.folder / "graded", student)
    write_atomically(page, make_feedback_page(assignment, student, result), is_synced=False)


def _write_or_mark_ungraded(assignment: Assignment, student_and_result: tuple[Student, Result]) -> Result:
    """Write a student's page and return the result on it; if it can't be made, the result says that qdot failed."""
    student, result = student_and_result
    try:
        write_page(assignment, student, result)
    except QdotError:
        raise
    except Exception as error:  # an error in one page must not stop the others
        result = make_ungraded_result(assignment, student, result.file, error)
        with contextlib.suppress(Exception):
            write_page(assignment, student, result)
    return result


def read_current_page(assignment: Assignment, student: Student, result: Result) -> bytes:
    """Return a student's feedback page. Raises QdotError if the page is missing or was made from another result."""
    path = _find_page_path(assignment.folder / "graded", student)
    if not _is_up_to_date(assignment, student, result):
        state = "is older than the results" if path.exists() else "does not exist"
        raise QdotError(f"{path} {state}; run: qdot grade {assignment.folder}")
    return path.read_bytes()


def _find_page_path(folder: Path, student: Student) -> Path:
    return folder / "feedback" / f"{student.id}.html"


def _is_up_to_date(assignment: Assignment, student: Student, result: Result) -> bool:
    """Return whether there is a complete page that was made from the same result."""
    try:
        with _find_page_path(assignment.folder / "graded", student).open("rb") as page:
            fingerprint = f'content="{compute_page_fingerprint(assignment, student, result)}"'
            is_current = fingerprint.encode() in page.read(FINGERPRINT_WINDOW)
            page.seek(-len(PAGE_END), os.SEEK_END)
            return is_current and page.read() == PAGE_END
    except OSError:
        return False
