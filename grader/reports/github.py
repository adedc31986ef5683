"""Report results to GitHub Actions: a job summary in Markdown, and annotations as workflow commands.

GitHub shows only ten annotations of a kind for each step of a job, and accepts no summary larger than 1 MiB; qdot stays
within both limits. Texts that may contain students' words are escaped, so that GitHub takes no text for a command or
for markup.
"""

import re
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.errors import shorten
from qdot.exercises.writing.render import render
from qdot.grader.grading.check import CheckedNotebook
from qdot.grader.grading.result import Result
from qdot.grader.marking.marking import format_points
from qdot.grader.reports.answer_display import make_visible
from qdot.grader.reports.grades_table import UNMARKED_STATUSES, find_work_status, has_points, list_staff_notes
from qdot.grader.reports.part_rows import list_notes, make_part_rows

MAX_ANNOTATIONS = 10
"""Maximum number of annotations of each kind, errors and warnings."""
MAX_SUMMARY_BYTES = 1_000_000
"""Maximum size of a summary in bytes; GitHub's limit is 1024 KiB."""
MAX_TEXT_LENGTH = 500
"""Maximum number of characters shown of the message on a part."""

_MARKUP = re.compile(r"([\\`*_{}\[\]()<>#+|~$&!@:])")


def make_summary(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return the job summary: a table of the class, and the parts of each student; for one student, only the parts.

    If the summary would be too large, it shows the parts of the first students, and the number of the other students.
    """
    table_rows = [(result, find_work_status(result), "; ".join(list_staff_notes(result))) for result in results]
    texts: dict[str, Any] = {"title": assignment.title, "students": table_rows if len(results) > 1 else []}

    @cache
    def make_section(index: int) -> tuple[Any, ...]:
        result = results[index]
        return result, make_part_rows(result, assignment, assignment.feedback), list_notes(result)

    def render_summary(count: int) -> str:
        """Return the summary with the parts of the first `count` students."""
        texts.update(sections=map(make_section, range(count)), omitted_count=len(results) - count)
        return render("reports/github.md.j2", **texts, escape_markdown=_escape_markdown, write_score=_write_score)

    def measure_summary(count: int) -> int:
        return len(render_summary(count).encode())

    if measure_summary(0) > MAX_SUMMARY_BYTES:
        return render("reports/github-short.md.j2", title=_escape_markdown(assignment.title), count=len(results))
    largest_count = bisect_right(range(len(results) + 1), MAX_SUMMARY_BYTES, key=measure_summary) - 1
    return render_summary(largest_count)


def _write_score(result: Result) -> str:
    return format_points(result.score) if has_points(result) else "no mark"


def _escape_markdown(text: str) -> str:
    """Return a text for a table cell, shortened, and escaped so that it contains no links, formulas or HTML."""
    return _MARKUP.sub(r"\\\1", shorten(" ".join(make_visible(text).split()), MAX_TEXT_LENGTH))


@dataclass(frozen=True)
class Annotation:
    """A message that GitHub shows next to a job, or next to a file; `kind` is "error" or "warning"."""

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
    """Return workflow commands with annotations, one per line.

    For one student, there is an error for each part without points, and a warning for each partly correct part. For a
    class, there is an annotation for each student who has no mark or whose notebook could not be used.
    """
    if len(results) == 1:
        rows = [row for row in make_part_rows(results[0], assignment, assignment.feedback) if not row.has_full_points]
        kinds = ["warning" if row.points else "error" for row in rows]
        titles = [f"{row.part}: {row.points_text}" for row in rows]
        messages = [shorten(row.message, MAX_TEXT_LENGTH) for row in rows]
    else:
        listed_results = [result for result in results if find_work_status(result) in ("unusable", *UNMARKED_STATUSES)]
        kinds = ["error" if find_work_status(result) == "ungraded" else "warning" for result in listed_results]
        titles = [result.student for result in listed_results]
        messages = ["; ".join(list_staff_notes(result)) for result in listed_results]
    annotations = list(map(Annotation, kinds, titles, messages))
    return "".join(_write_commands(kind, annotations, assignment.key) for kind in ("error", "warning"))


def _write_commands(kind: str, annotations: Sequence[Annotation], title: str) -> str:
    """Return the commands for annotations of a kind; if GitHub would not show all, the last one says how many more."""
    shown_annotations = [annotation for annotation in annotations if annotation.kind == kind]
    if len(shown_annotations) > MAX_ANNOTATIONS:
        omitted_count = len(shown_annotations) - MAX_ANNOTATIONS + 1
        last_annotation = Annotation(kind, title, f"and {omitted_count} more; see the job summary")
        shown_annotations = [*shown_annotations[: MAX_ANNOTATIONS - 1], last_annotation]
    return "".join(annotation.command for annotation in shown_annotations)


def make_check_summary(notebook: CheckedNotebook) -> str:
    """Return the job summary of `qdot check`: the answers that qdot finds in a notebook."""
    return render("reports/github-check.md.j2", notebook=notebook, escape_markdown=_escape_markdown)


def make_check_annotations(path: Path, notebook: CheckedNotebook) -> str:
    """Return a warning for every answer of a notebook that can't be parsed."""
    rows = [row for row in notebook.rows if not row.is_readable]
    annotations = [Annotation("warning", row.part, row.message, path.as_posix()) for row in rows]
    return _write_commands("warning", annotations, "qdot")


def _escape_message(text: str) -> str:
    return make_visible(text).replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _escape_property(text: str) -> str:
    return _escape_message(text).replace(":", "%3A").replace(",", "%2C")
