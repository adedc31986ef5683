"""Write the results of a class in the formats of `qdot grade DIR --report FORMAT=PATH`, for other programs."""

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.console import check_choice, note, print_result
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import require_extra
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.json_form import to_jsonable
from qdot.grader.grading.result import Result
from qdot.grader.reports import github, gradescope, junit
from qdot.grader.reports.class_page import make_class_page
from qdot.grader.reports.excel import make_workbook
from qdot.grader.reports.gradebooks import (
    describe_unmarked_students,
    make_brightspace_csv,
    make_canvas_csv,
    make_moodle_csv,
)
from qdot.grader.reports.grades_table import make_grades_csv


@dataclass(frozen=True)
class ReportFormat:
    """A report format.

    - `read_by`: the programs that read the report
    - `make`: returns the content of the file, from the assignment and the results in the roster's order
    - `is_for_one_student`: whether the report has the result of only one student
    - `make_printed_text`: returns a text that is also written to standard output
    - `make_notes`: returns notes for the staff
    - `is_private`: whether the report is for the staff, so that only the owner may read the file
    - `check_library`: raises QdotError if a library is missing; called before grading
    """

    name: str
    title: str
    read_by: str
    make: Callable[[Assignment, Sequence[Result]], str | bytes]
    is_for_one_student: bool = False
    make_printed_text: Callable[[Assignment, Sequence[Result]], str] = lambda *_: ""
    make_notes: Callable[[Assignment, Sequence[Result]], list[str]] = lambda *_: []
    is_private: bool = False
    check_library: Callable[[], None] = lambda: None


FORMATS = {
    report_format.name: report_format
    for report_format in (
        ReportFormat("csv", "A row for each student, a column for each part", "spreadsheets",
                     lambda assignment, results: make_grades_csv(results, assignment.roster)),
        ReportFormat("json", "All results, as one list", "programs",
                     lambda _, results: json.dumps(to_jsonable(results), ensure_ascii=False, indent=1) + "\n"),
        ReportFormat("junit", "A test for each student and part, in XML", "GitLab, Jenkins, Artemis",
                     junit.write_junit_xml),
        ReportFormat("github", "A job summary; annotations are printed to standard output", "GitHub Actions",
                     github.make_summary, make_printed_text=github.make_annotations),
        ReportFormat("gradescope", "results.json for one student (`--student`)", "Gradescope",
                     gradescope.make_results_json, is_for_one_student=True),
        ReportFormat("canvas", "A file to import into Canvas's gradebook", "Canvas", make_canvas_csv,
                     make_notes=describe_unmarked_students),
        ReportFormat("moodle", "A file to import into Moodle's gradebook", "Moodle", make_moodle_csv,
                     make_notes=describe_unmarked_students),
        ReportFormat("brightspace", "A file to import into Brightspace's grades", "Brightspace", make_brightspace_csv,
                     make_notes=describe_unmarked_students),
        ReportFormat("xlsx", "A workbook: grades, and the outcomes of each part", "Excel, LibreOffice", make_workbook,
                     check_library=lambda: require_extra("report", "--report xlsx")),
        ReportFormat("html", "The class overview, a page for the staff", "any browser", make_class_page,
                     is_private=True),
    )
}  # fmt: skip
"""Maps the name of each report format to the format."""

STDOUT = "-"
"""The path that means standard output."""


def parse_report_options(options: Sequence[str], has_one_student: bool) -> list[tuple[str, str]]:
    """Return the values of the options `--report FORMAT=PATH` as pairs (format, path).

    `has_one_student` says whether only one student is graded. Raises QdotError for an unknown format, and if a format
    is not possible here.
    """
    reports = []
    for text in options:
        name, equals, path = text.partition("=")
        if not equals or not path:
            raise QdotError(f"--report {text}: write FORMAT=PATH, as in csv=grades.csv; {STDOUT} is standard output")
        check_choice(name, tuple(FORMATS), "--report")
        if FORMATS[name].is_for_one_student and not has_one_student:
            raise QdotError(f"--report {name} is for one student: add --student ID")
        FORMATS[name].check_library()
        reports.append((name, path))
    return reports


def write_requested_reports(
    assignment: Assignment, results: Sequence[Result], reports: Sequence[tuple[str, str]]
) -> None:
    """Write the requested reports, given as pairs (format, path). Raises QdotError if a file can't be written."""
    for name, path in reports:
        report_format = FORMATS[name]
        content = report_format.make(assignment, results)
        for message in report_format.make_notes(assignment, results):
            note(f"{name}: {message}")
        write_to_path(path, content, 0o600 if report_format.is_private else 0o644)
        if text := report_format.make_printed_text(assignment, results):
            print_result(text)


def write_to_path(path: str, content: str | bytes, mode: int = 0o644) -> None:
    """Write content to a path, or to standard output if the path is "-". Raises QdotError if writing fails."""
    if path != STDOUT:
        write_atomically(Path(path), content, mode)
    elif isinstance(content, bytes):
        sys.stdout.flush()
        sys.stdout.buffer.write(content)
    else:
        print_result(content)
