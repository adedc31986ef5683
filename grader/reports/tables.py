"""Write results.jsonl, with a line for each student, and grades.csv, a table for people."""

import csv
import io
import json
from collections.abc import Sequence

from qdot.exercises.assignment.assignment import Student
from qdot.exercises.common.console import printable
from qdot.exercises.common.json_form import as_json
from qdot.grader.grading.marking import format_points, sum_points
from qdot.grader.grading.result import AppliedOverride, Result

SUMS = ("score", "max_score", "percent", "status", "late_penalty", "override", "note")
"""The last columns of grades.csv."""
FORMULA_BEGINS = tuple("=+-@\uff1d\uff0b\uff0d\uff20")
"""With what a cell begins that a spreadsheet may take for a formula, the wide signs of East Asia among them."""


def results_jsonl(results: Sequence[Result]) -> bytes:
    """Return a JSON object for each student, one a line, in UTF-8, which needs the least memory for a large class."""
    out = io.BytesIO()
    for result in results:
        line = printable(json.dumps(as_json(result), ensure_ascii=False, allow_nan=False))
        out.write(f"{line}\n".encode("utf-8", "replace"))
    return out.getvalue()


Cell = str | float | None
"""A text, a number, or nothing."""


def grades_csv(results: Sequence[Result], roster: Sequence[Student]) -> str:
    """Return the table: who, a column for each part, score, max_score, percent, status, late_penalty, override, note.

    The parts less late_penalty are the score, unless the column override says that a person set the total. Without a
    mark, score and percent are empty.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    header, rows = grades_table(results, roster)
    writer.writerow(header)
    writer.writerows([_cell_text(name, cell) for name, cell in zip(header, row, strict=True)] for row in rows)
    return out.getvalue()


def grades_table(results: Sequence[Result], roster: Sequence[Student]) -> tuple[list[str], list[list[Cell]]]:
    """Return the names of the columns, and the cells of every student."""
    by_id = {student.id: student for student in roster}
    columns = [name for name, _ in roster[0].others]
    rows: list[list[Cell]] = []
    for result in results:
        student = by_id[result.student]
        cells = [student.id, student.name, student.email, *(value for _, value in student.others)]
        points = [part.points for part in result.parts.values()]
        score, percent = (None, None) if status(result) in NO_MARK else (result.score, result.percent)
        sums = [score, result.max_score, percent, status(result), _late_penalty(result)]
        notes = "; ".join((*list_staff_notes(result), *list_group_notes(result)))
        rows.append([*cells, *points, *sums, "; ".join(describe_overrides(result)), notes])
    return ["student", "name", "email", *columns, *results[0].parts, *SUMS], rows


def _cell_text(column: str, cell: Cell) -> str:
    if isinstance(cell, str):
        return escape_formula(cell)
    if cell is None:
        return ""
    return f"{cell:.1f}" if column == "percent" else format_points(cell)


def is_marked(result: Result, *, zero: bool = False) -> bool:
    """Tell whether a student has a mark for a gradebook: from qdot for work that it could grade, or from a person.

    With `zero`, the 0 of what is missing or unusable is a mark, too; what qdot could not grade never has one.
    """
    by_hand = count_overridden(result) > 0
    return (graded := status(result)) in ("graded", "late") or (graded not in NO_MARK and (zero or by_hand))


NO_MARK = ("ungraded", "over limit")
"""States of work that has no mark before a person has set one."""


def status(result: Result) -> str:
    """Return the state of a student's work in a word.

    "missing": nothing handed in; "unusable": no notebook of this assignment; "over limit": it takes more to be graded
    than a limit allows; "ungraded": qdot failed; "late"; "graded".
    """
    without = [part for part in result.parts.values() if part.points is None]
    if without and result.override is None:
        return "over limit" if all(part.over_limit for part in without) else "ungraded"
    if result.submission is None:
        return "missing"
    if result.obstacle is not None:
        return "unusable"
    return "late" if result.late else "graded"


def describe_overrides(result: Result) -> list[str]:
    """Return the points that a person set, in words for the staff."""
    return [_describe_override(name, override) for name, override in result.overrides.items()]


def count_overridden(result: Result) -> int:
    """Return how many marks a person set, of parts and in total."""
    return sum(override.points is not None for override in result.overrides.values())


def _describe_override(name: str, override: AppliedOverride) -> str:
    if override.points is None:
        return f"{name}: {override.comment}"
    was = "ungraded" if override.was is None else format_points(override.was)
    comment = f", {override.comment}" if override.comment else ""
    return f"{name}: {format_points(override.points)} (was {was}){comment}"


def list_group_notes(result: Result) -> list[str]:
    """Return the groups of answers for which overrides.csv sets or explains parts, in words for the staff."""
    return [
        f"overrides.csv {'explains' if override.points is None else 'sets'} the group {override.group}"
        for override in result.overrides.values()
        if override.group is not None
    ]


def _late_penalty(result: Result) -> float | None:
    """Return the points taken off for lateness; None if none are."""
    late = result.late
    if late is None or not late.penalty:
        return None
    score = result.score if result.override is None else result.override.was
    assert score is not None
    return sum_points((late.points_before, -score))


def list_staff_notes(result: Result) -> list[str]:
    """Return what the staff should know of a submission: why it is unusable, whose notebook it is, …"""
    unusable = [result.obstacle] if result.obstacle is not None and status(result) == "unusable" else []
    return [*unusable, *result.staff_notes]


def escape_formula(text: str) -> str:
    """Escape a text so that no spreadsheet takes it for a formula, and no terminal for a command."""
    text = printable(text)
    return f"'{text}" if text.lstrip()[:1] in FORMULA_BEGINS else text
