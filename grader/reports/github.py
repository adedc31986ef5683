"""Results for GitHub Actions: a job summary in Markdown, and annotations as workflow commands for standard output.

GitHub shows ten annotations of a kind for each step and drops the others, and takes no summary above 1 MiB; both are
kept to. Texts in which students' words may be are written so that they are neither commands nor markup.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.writing.render import render
from qdot.grader.grading.check import Checked
from qdot.grader.grading.marking import number
from qdot.grader.grading.result import Result
from qdot.grader.reports.answer_positions import line_of_answer
from qdot.grader.reports.answers import visible
from qdot.grader.reports.rows import Row, lateness, rows_of
from qdot.grader.reports.tables import NO_MARK, staff_notes, status

MOST_ANNOTATIONS = 10
"""Of each kind, for a step."""
LARGEST_SUMMARY = 1_000_000
"""Bytes; GitHub's limit is 1024 KiB."""
LONGEST_TEXT = 500
"""Characters that are shown of what is said of a part."""

_MARKUP = re.compile(r"([\\`*_{}\[\]()<>#+|~$&!@:])")


@dataclass(frozen=True)
class StudentLine:
    """A student in the table of the class, in Markdown."""

    id: str
    score: str
    max_score: str
    status: str
    note: str


@dataclass(frozen=True)
class Section:
    """The parts of a student, in Markdown; it is `opened` where nobody else is on the page."""

    student: str
    opened: bool
    rows: list[Row]
    notes: list[str]
    score: str
    max_score: str


def summary(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return the job summary: a table of the class, and each student's parts; of one student, the parts alone.

    Where all parts would be too much, those of the first students are shown, and how many are left out.
    """
    if len(results) == 1:
        return _page(assignment, results, [_section(results[0], assignment.feedback, opened=True)], 0)
    sections = list[Section]()
    size = len(_page(assignment, results, [], len(results)).encode())
    if size > LARGEST_SUMMARY:
        return render("reports/github-short.md.j2", title=_markdown(assignment.title), count=len(results))
    for result in results:
        section = _section(result, assignment.feedback, opened=False)
        size += len(_page(assignment, [], [section], 0).encode())
        if size > LARGEST_SUMMARY:
            break
        sections.append(section)
    return _page(assignment, results, sections, len(results) - len(sections))


def _page(assignment: Assignment, results: Sequence[Result], sections: list[Section], left_out: int) -> str:
    students = [
        StudentLine(
            _markdown(result.student), number(result.score), number(result.max_score), status(result),
            _markdown("; ".join(staff_notes(result))),
        )
        for result in results
    ] if len(results) > 1 else []  # fmt: skip
    title = _markdown(assignment.title)
    return render("reports/github.md.j2", title=title, students=students, sections=sections, left_out=left_out)


def _section(result: Result, feedback: str, opened: bool) -> Section:
    rows = [replace(row, message=_markdown(row.message)) for row in rows_of(result, feedback)]
    notes = [_markdown(text) for text in (*result.notes, lateness(result)) if text]
    if result.override is not None:
        notes.append(_markdown(f"the total was set by your instructor: {result.override.comment}".rstrip(": ")))
    return Section(
        _markdown(result.student), opened, rows, notes, number(result.score), number(result.max_score)
    )  # fmt: skip


def _markdown(text: str) -> str:
    """Return a text for a table's cell, in which nothing is markup: neither a link, nor a formula, nor HTML."""
    line = " ".join(visible(text).split())
    return _MARKUP.sub(r"\\\1", line if len(line) <= LONGEST_TEXT else f"{line[:LONGEST_TEXT]} …")


def annotations(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return workflow commands, a line each: errors for what earned nothing, warnings for what is right in part.

    Of a class there is one for every student who has no marks or whose notebook could not be used.
    """
    notes = list(_of_parts(results[0], assignment.feedback) if len(results) == 1 else _of_class(results))
    lines = []
    for kind in ("error", "warning"):
        of_kind = [(title, message) for each, title, message in notes if each == kind]
        if len(of_kind) > MOST_ANNOTATIONS:
            rest = f"and {len(of_kind) - MOST_ANNOTATIONS + 1} more; the job summary has all"
            of_kind = [*of_kind[: MOST_ANNOTATIONS - 1], (assignment.key, rest)]
        lines += [f"::{kind} title={_property(title)}::{_message(message)}" for title, message in of_kind]
    return "".join(f"{line}\n" for line in lines)


def _of_parts(result: Result, feedback: str) -> Iterator[tuple[str, str, str]]:
    for row in rows_of(result, feedback):
        if not row.passed:
            yield "warning" if row.points else "error", f"{row.part}: {row.earned}", _shown(row)


def _shown(row: Row) -> str:
    return row.message if len(row.message) <= LONGEST_TEXT else f"{row.message[:LONGEST_TEXT]} …"


def _of_class(results: Sequence[Result]) -> Iterator[tuple[str, str, str]]:
    for result in results:
        state = status(result)
        if state in ("unusable", *NO_MARK):
            yield "error" if state == "ungraded" else "warning", result.student, "; ".join(staff_notes(result))


# --- what a student can know before handing in: `qdot check` ---


def check_summary(checked: Checked) -> str:
    """Return the job summary of what will be read of a notebook."""
    rows = [{"part": row.part, "readable": row.readable, "said": _markdown(row.said)} for row in checked.rows]
    return render("reports/github-check.md.j2", rows=rows, notes=[_markdown(said) for said in checked.notes])


def check_annotations(path: Path, checked: Checked) -> str:
    """Return a warning for every answer that can't be read, at its line in the file, where GitHub shows it."""
    unreadable, file = [row for row in checked.rows if not row.readable], _property(path.as_posix())
    commands = [
        f"::warning file={file},line={line_of_answer(path, row.part)},title={_property(row.part)}::{_message(row.said)}"
        for row in unreadable[: MOST_ANNOTATIONS if len(unreadable) <= MOST_ANNOTATIONS else MOST_ANNOTATIONS - 1]
    ]
    if len(commands) < len(unreadable):
        commands.append(f"::warning title=qdot::and {len(unreadable) - len(commands)} more; the job summary has all")
    return "".join(f"{line}\n" for line in commands)


def _message(text: str) -> str:
    return visible(text).replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _message(text).replace(":", "%3A").replace(",", "%2C")
