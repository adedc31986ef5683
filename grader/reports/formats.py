"""Write the results of a class in the formats of `qdot grade DIR --report FORMAT=PATH`, which other programs read."""

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.console import note, one_of, say
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import need
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.json_form import as_json
from qdot.grader.grading.result import Result
from qdot.grader.reports import charts, github, gradescope, junit
from qdot.grader.reports.class_page import make_class_page
from qdot.grader.reports.excel import make_workbook
from qdot.grader.reports.gradebooks import make_canvas_csv, make_moodle_csv, note_unmarked
from qdot.grader.reports.tables import grades_csv


@dataclass(frozen=True)
class Format:
    """A report format: `read_by` names the programs that read it, `checked` what reads it in qdot's tests.

    - `make`: returns the content of the file, from the assignment and the results in the roster's order
    - `of_one_student`: whether the report has the result of only one student
    - `printed`: returns a text that is also written to standard output
    - `notes`: returns notes for the staff
    - `private`: whether the report is for the staff, so that only the owner may read the file
    - `check`: raises QdotError if a library is missing; it is called before grading
    """

    name: str
    title: str
    read_by: str
    checked: str
    make: Callable[[Assignment, Sequence[Result]], str | bytes]
    of_one_student: bool = False
    printed: Callable[[Assignment, Sequence[Result]], str] = lambda *_: ""
    notes: Callable[[Assignment, Sequence[Result]], list[str]] = lambda *_: []
    private: bool = False
    check: Callable[[], None] = lambda: None


def _grades_csv(assignment: Assignment, results: Sequence[Result]) -> str:
    return grades_csv(results, assignment.roster)


def _results_json(_: Assignment, results: Sequence[Result]) -> str:
    return json.dumps([as_json(result) for result in results], ensure_ascii=False, indent=1) + "\n"


IMPORTER = "its importer's rules, written anew"

FORMATS = {
    made.name: made
    for made in (
        Format("csv", "A row a student, a column a part", "spreadsheets", "Python's csv", _grades_csv),
        Format("json", "All there is, as one list", "programs", "our JSON Schema", _results_json),
        Format("junit", "A test for every part of every student, in XML", "GitLab, Jenkins, Artemis", "junitparser",
               junit.junit_xml),
        Format("github", "A job summary; annotations go to standard output", "GitHub Actions",
               "markdown-it, by the rules for workflow commands", github.make_summary, printed=github.make_annotations),
        Format("gradescope", "results.json of one student (`--student`)", "Gradescope",
               "a harness with Gradescope's folders", gradescope.make_results_json, of_one_student=True),
        Format("canvas", "Canvas's gradebook, to be imported", "Canvas", IMPORTER, make_canvas_csv,
               notes=note_unmarked),
        Format("moodle", "Moodle's gradebook, to be imported", "Moodle", IMPORTER, make_moodle_csv,
               notes=note_unmarked),
        Format("xlsx", "A workbook: grades, and what became of each part", "Excel, LibreOffice", "openpyxl",
               make_workbook, check=lambda: need("report", "--report xlsx", "xlsxwriter")),
        Format("html", "The class at a glance, a page for the staff", "any browser", "Chromium",
               make_class_page, private=True, check=charts.check_library),
    )
}  # fmt: skip
"""The export formats by name."""

STDOUT = "-"
"""The path that means standard output."""


def read_reports(asked: Sequence[str], of_one: bool) -> list[tuple[str, str]]:
    """Return the values of the options `--report FORMAT=PATH` as pairs (format, path). Raises QdotError.

    `of_one` is True if only one student is graded.
    """
    reports = []
    for text in asked:
        name, equals, path = text.partition("=")
        if not equals or not path:
            raise QdotError(f"--report {text}: write FORMAT=PATH, as in csv=grades.csv; {STDOUT} is standard output")
        one_of(name, tuple(FORMATS), "--report")
        if FORMATS[name].of_one_student and not of_one:
            raise QdotError(f"--report {name} is of one student: name them with --student ID")
        FORMATS[name].check()
        reports.append((name, path))
    return reports


def write_asked(assignment: Assignment, results: Sequence[Result], asked: Sequence[tuple[str, str]]) -> None:
    """Write the requested reports, given as pairs (format, path). Raises QdotError if a file can't be written."""
    for name, path in asked:
        form = FORMATS[name]
        content = form.make(assignment, results)
        for message in form.notes(assignment, results):
            note(f"{name}: {message}")
        write_out(path, content, 0o600 if form.private else 0o644)
        if printed := form.printed(assignment, results):
            say(printed)


def write_out(path: str, content: str | bytes, mode: int = 0o644) -> None:
    """Write content to a path, or to standard output if the path is "-". Raises QdotError if writing fails."""
    if path != STDOUT:
        write_atomically(Path(path), content, mode)
    elif isinstance(content, bytes):
        sys.stdout.flush()
        sys.stdout.buffer.write(content)
    else:
        say(content)
