"""Every report of a graded class, written into graded/, each file at once or not at all; results.jsonl is the last."""

import contextlib
import os
from collections.abc import Callable, Sequence
from pathlib import Path

from exercises.assignment import Assignment, Student
from exercises.errors import QdotError
from exercises.files import made_lasting, tidied, write_atomically
from exercises.parallel import ordered_map
from grader.history import keep_earlier, results_path
from grader.reports.feedback import feedback_page, made_from
from grader.reports.tables import grades_csv, results_jsonl
from grader.settle import Result

BEGINNING = 1000
"""Characters at the beginning of a page among which it says what it was made from."""

ENDING = b"</html>\n"
"""What a page ends with, unless a loss of power tore it."""


def write_reports(
    assignment: Assignment, results: Sequence[Result], jobs: int = 1, each: Callable[[], None] = lambda: None
) -> None:
    """Write the feedback pages that are not up to date, grades.csv and results.jsonl; `each` is told of every page.

    What the run before gave goes into the history first. Raises QdotError where a file can't be written.
    """
    folder = assignment.folder / "graded"
    by_id = {student.id: student for student in assignment.roster}
    pages = [(by_id[result["student"]], result) for result in results]
    keep_earlier(assignment, results)
    # Its figures take longer than all the rest of a page: they are drawn on several processes, and only once.
    old = [(student, result) for student, result in pages if not _is_up_to_date(assignment, student, result)]
    for _ in range(len(pages) - len(old)):
        each()
    unwritten = []
    lost = _lost if jobs > 1 else None
    ours = [*(_page(folder, student) for student, _ in pages), results_path(assignment), folder / "grades.csv"]
    every = ordered_map(_write, old, jobs, _same, (assignment,), lost)
    with tidied(ours):
        with contextlib.closing(every), made_lasting(folder) as now_and_then:
            for student in every:
                unwritten += [student] if student else []
                now_and_then()
                each()
        write_atomically(folder / "grades.csv", grades_csv(results, assignment.roster))
        write_atomically(results_path(assignment), results_jsonl(results))
    if unwritten:
        raise QdotError(
            f"no feedback page for {', '.join(unwritten)}: what wrote it was ended by the system, probably for want of "
            "memory; the grades are complete, and the same command tries again"
        )


def _same(assignment: Assignment) -> Assignment:
    return assignment


def write_page(assignment: Assignment, student: Student, result: Result) -> None:
    """Write a student's feedback page. Raises QdotError where it can't be written."""
    page = _page(assignment.folder / "graded", student)
    write_atomically(page, feedback_page(assignment, student, result), lasting=False)


def _write(assignment: Assignment, about: tuple[Student, Result]) -> str:
    write_page(assignment, *about)
    return ""


def _lost(about: tuple[Student, Result]) -> str:
    """Return whose page ended every process that was to write it."""
    return about[0].id


def _page(folder: Path, student: Student) -> Path:
    return folder / "feedback" / f"{student.id}.html"


def _is_up_to_date(assignment: Assignment, student: Student, result: Result) -> bool:
    """Tell whether a page is there that says that it was made from the same, and is whole."""
    try:
        with _page(assignment.folder / "graded", student).open("rb") as page:
            begins = f'content="{made_from(assignment, student, result)}"'.encode() in page.read(BEGINNING)
            page.seek(-len(ENDING), os.SEEK_END)
            return begins and page.read() == ENDING
    except OSError:
        return False
