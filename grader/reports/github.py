"""Report results to GitHub Actions: a job summary in Markdown, and annotations as workflow commands.

GitHub shows only ten annotations of a kind for each step, and accepts no summary larger than 1 MiB; qdot stays within
both limits. Texts that may contain students' words are escaped, so that they act neither as commands nor as markup.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.errors import shorten
from qdot.exercises.writing.render import render
from qdot.grader.grading.check import CheckedNotebook
from qdot.grader.grading.marking import format_points
from qdot.grader.grading.result import Result
from qdot.grader.reports.answers import make_visible
from qdot.grader.reports.rows import list_notes, make_rows
from qdot.grader.reports.tables import UNMARKED_STATES, list_staff_notes, work_status

MAX_ANNOTATIONS = 10
"""Maximum number of annotations of each kind for a step."""
MAX_SUMMARY_BYTES = 1_000_000
"""Maximum size of a summary in bytes; GitHub's limit is 1024 KiB."""
MAX_TEXT_LENGTH = 500
"""Maximum number of characters shown of the message on a part."""

_MARKUP = re.compile(r"([\\`*_{}\[\]()<>#+|~$&!@:])")


def make_summary(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return the job summary: a table of the class, and the parts of each student; for one student, only the parts.

    If the summary would be too large, it shows the parts of the first students, and the number of the other students.
    """
    students = results if len(results) > 1 else []
    shown_results = list[Result]()
    size = _size(assignment, students, [], len(results))
    if size > MAX_SUMMARY_BYTES:
        return render("reports/github-short.md.j2", title=_escape_markdown(assignment.title), count=len(results))
    for result in results:
        size += _size(assignment, [result], [result]) - _size(assignment, [result], [])
        if size > MAX_SUMMARY_BYTES:
            break
        shown_results.append(result)
    return _render_page(assignment, students, shown_results, len(results) - len(shown_results))


def _size(assignment: Assignment, students: Sequence[Result], shown: Sequence[Result], left_out: int = 0) -> int:
    return len(_render_page(assignment, students, shown, left_out).encode())


def _render_page(assignment: Assignment, students: Sequence[Result], shown: Sequence[Result], left_out: int) -> str:
    """Return the page with a table of `students` (which may be empty) and the parts of the students in `shown`."""
    rows = [(result, work_status(result), "; ".join(list_staff_notes(result))) for result in students]
    sections = [(result, make_rows(result, assignment.feedback), list_notes(result)) for result in shown]
    texts = {"title": assignment.title, "students": rows, "sections": sections, "left_out": left_out}
    return render("reports/github.md.j2", **texts, markdown=_escape_markdown, number=format_points)


def _escape_markdown(text: str) -> str:
    """Return a text for a table cell, escaped so that it contains no links, formulas or HTML."""
    return _MARKUP.sub(r"\\\1", shorten(" ".join(make_visible(text).split()), MAX_TEXT_LENGTH))


@dataclass(frozen=True)
class Annotation:
    """A message that GitHub shows next to a job or a file; its kind is "error" or "warning"."""

    kind: str
    title: str
    message: str
    file: str = ""

    @property
    def command(self) -> str:
        """The workflow command, as a line for standard output."""
        file = f"file={_escape_property(self.file)}," if self.file else ""
        return f"::{self.kind} {file}title={_escape_property(self.title)}::{_escape_message(self.message)}\n"


def make_annotations(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return workflow commands, one a line.

    For one student, they are errors for parts without points and warnings for partly correct parts. For a class, there
    is one for each student who has no mark or whose notebook could not be used.
    """
    if len(results) == 1:
        rows = [row for row in make_rows(results[0], assignment.feedback) if not row.passed]
        kinds = ["warning" if row.points else "error" for row in rows]
        titles = [f"{row.part}: {row.points_text}" for row in rows]
        messages = [shorten(row.message, MAX_TEXT_LENGTH) for row in rows]
    else:
        results = [result for result in results if work_status(result) in ("unusable", *UNMARKED_STATES)]
        kinds = ["error" if work_status(result) == "ungraded" else "warning" for result in results]
        titles = [result.student for result in results]
        messages = ["; ".join(list_staff_notes(result)) for result in results]
    notes = list(map(Annotation, kinds, titles, messages))
    return "".join(_commands(kind, notes, assignment.key) for kind in ("error", "warning"))


def _commands(kind: str, notes: Sequence[Annotation], title: str) -> str:
    """Return the commands of a kind, as many as GitHub shows; the last one, with `title`, counts the others."""
    selected_notes = [note for note in notes if note.kind == kind]
    if len(selected_notes) > MAX_ANNOTATIONS:
        left_out = len(selected_notes) - MAX_ANNOTATIONS + 1
        last_annotation = Annotation(kind, title, f"and {left_out} more; see the job summary")
        selected_notes = [*selected_notes[: MAX_ANNOTATIONS - 1], last_annotation]
    return "".join(note.command for note in selected_notes)


def make_check_summary(checked: CheckedNotebook) -> str:
    """Return the job summary of `qdot check`: the answers that qdot finds in a notebook."""
    return render("reports/github-check.md.j2", checked=checked, markdown=_escape_markdown)


def make_check_annotations(path: Path, checked: CheckedNotebook) -> str:
    """Return a warning for every answer of a notebook that can't be parsed."""
    unreadable = [row for row in checked.rows if not row.is_readable]
    notes = [Annotation("warning", row.part, row.message, path.as_posix()) for row in unreadable]
    return _commands("warning", notes, "qdot")


def _escape_message(text: str) -> str:
    return make_visible(text).replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _escape_property(text: str) -> str:
    return _escape_message(text).replace(":", "%3A").replace(",", "%2C")
