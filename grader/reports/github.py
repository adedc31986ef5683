"""Results for GitHub Actions: a job summary in Markdown, and annotations as workflow commands for standard output.

GitHub shows ten annotations of a kind for each step and drops the others, and takes no summary above 1 MiB; both are
kept to. Texts in which students' words may be are written so that they are neither commands nor markup.
"""

import re
from collections.abc import Iterator, Sequence
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


def summary(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return the job summary: a table of the class, and each student's parts; of one student, the parts alone.

    Where all parts would be too much, those of the first students are shown, and how many are left out.
    """
    if len(results) == 1:
        return _page(assignment, results, [_section(results[0], assignment.feedback, opened=True)], 0)
    sections: list[dict[str, object]] = []
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


def _page(assignment: Assignment, results: Sequence[Result], sections: list[dict[str, object]], left_out: int) -> str:
    students = [
        {
            "id": _markdown(result.student), "score": number(result.score),
            "max_score": number(result.max_score), "status": status(result),
            "note": _markdown("; ".join(staff_notes(result))),
        }
        for result in results
    ] if len(results) > 1 else []  # fmt: skip
    title = _markdown(assignment.title)
    return render("reports/github.md.j2", title=title, students=students, sections=sections, left_out=left_out)


def _section(result: Result, feedback: str, opened: bool) -> dict[str, object]:
    rows = [
        {
            "part": row.part,
            "title": row.title,
            "outcome": row.outcome,
            "earned": row.earned,
            "said": _markdown(row.said),
        }
        for row in rows_of(result, feedback)
    ]  # fmt: skip
    notes = [_markdown(said) for said in (*result.notes, lateness(result)) if said]
    if result.override is not None:
        notes.append(_markdown(f"the total was set by your instructor: {result.override.comment}".rstrip(": ")))
    return {
        "student": _markdown(result.student), "opened": opened, "rows": rows, "notes": notes,
        "score": number(result.score), "max_score": number(result.max_score),
    }  # fmt: skip


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
        own = [(title, said) for each, title, said in notes if each == kind]
        if len(own) > MOST_ANNOTATIONS:
            rest = f"and {len(own) - MOST_ANNOTATIONS + 1} more; the job summary has all"
            own = [*own[: MOST_ANNOTATIONS - 1], (assignment.key, rest)]
        lines += [f"::{kind} title={_property(title)}::{_message(said)}" for title, said in own]
    return "".join(f"{line}\n" for line in lines)


def _of_parts(result: Result, feedback: str) -> Iterator[tuple[str, str, str]]:
    for row in rows_of(result, feedback):
        if not row.passed:
            yield "warning" if row.points else "error", f"{row.part}: {row.earned}", _shown(row)


def _shown(row: Row) -> str:
    return row.said if len(row.said) <= LONGEST_TEXT else f"{row.said[:LONGEST_TEXT]} …"


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
    own, file = [row for row in checked.rows if not row.readable], _property(path.as_posix())
    told = [
        f"::warning file={file},line={line_of_answer(path, row.part)},title={_property(row.part)}::{_message(row.said)}"
        for row in own[: MOST_ANNOTATIONS if len(own) <= MOST_ANNOTATIONS else MOST_ANNOTATIONS - 1]
    ]
    if len(told) < len(own):
        told.append(f"::warning title=qdot::and {len(own) - len(told)} more; the job summary has all")
    return "".join(f"{line}\n" for line in told)


def _message(text: str) -> str:
    return visible(text).replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _message(text).replace(":", "%3A").replace(",", "%2C")
