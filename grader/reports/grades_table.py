"""Write results.jsonl, which has a line for each student, and grades.csv, a table for human readers."""

import io
import json
from collections.abc import Mapping, Sequence

from qdot.exercises.assignment.assignment import Student
from qdot.exercises.common.console import escape_controls
from qdot.exercises.common.input_file import format_csv
from qdot.exercises.common.json_form import to_jsonable
from qdot.grader.grading.overrides import flatten_answer
from qdot.grader.grading.result import Result
from qdot.grader.judging.verdict import AWAITS_PERSON
from qdot.grader.marking.marking import format_points, sum_points

SUMMARY_COLUMNS = ("score", "max_score", "percent", "status", "late_penalty", "override", "note")
"""The last columns of grades.csv."""
FORMULA_FIRST_CHARACTERS = tuple("=+-@\uff1d\uff0b\uff0d\uff20")
"""First characters of a cell that a spreadsheet may parse as a formula, including East Asian full-width signs."""


def make_results_jsonl(results: Sequence[Result]) -> bytes:
    """Return a line of JSON for each student, as UTF-8 bytes; for a large class, bytes need less memory than text."""
    content = io.BytesIO()
    for result in results:
        line = escape_controls(json.dumps(to_jsonable(result), ensure_ascii=False, allow_nan=False))
        content.write(f"{line}\n".encode("utf-8", "replace"))
    return content.getvalue()


Cell = str | float | None
"""A cell of a table: a text, a number, or None for an empty cell."""


def make_grades_csv(
    results: Sequence[Result], roster: Sequence[Student], file_by_student: Mapping[str, str] | None = None
) -> str:
    """Return grades.csv: columns that identify the student, a column for each part, and columns for the total.

    The score is the sum of the parts minus late_penalty, unless the column override shows that a person set the total.
    If a student has no mark, score and percent are empty. If students have files, their names are the fourth column.
    """
    header, rows = make_grades_table(results, roster)
    if file_by_student is not None:
        header.insert(3, "file")
        for result, row in zip(results, rows, strict=True):
            row.insert(3, file_by_student[result.student])
    texts = ([_format_cell(name, cell) for name, cell in zip(header, row, strict=True)] for row in rows)
    return format_csv([header, *texts])


def make_grades_table(results: Sequence[Result], roster: Sequence[Student]) -> tuple[list[str], list[list[Cell]]]:
    """Return the names of the columns, and a row of cells for every student."""
    by_id = {student.id: student for student in roster}
    columns = [name for name, _ in roster[0].other_cells]
    rows: list[list[Cell]] = []
    for result in results:
        student = by_id[result.student]
        cells = [student.id, student.name, student.email, *(value for _, value in student.other_cells)]
        points = [part.points if has_points(result) else None for part in result.parts.values()]
        score, percent = (result.score, result.percent) if is_marked(result) else (None, None)
        totals = [score, result.max_score, percent, find_work_status(result), _compute_late_penalty(result)]
        group_notes = [
            f"overrides.csv {'comments on' if override.points is None else 'sets'} the group {override.group}"
            for override in result.overrides.values()
            if override.group is not None
        ]
        notes = "; ".join((*list_staff_notes(result), *group_notes))
        rows.append([*cells, *points, *totals, "; ".join(describe_overrides(result)), notes])
    return ["student", "name", "email", *columns, *results[0].parts, *SUMMARY_COLUMNS], rows


def make_to_mark_csv(results: Sequence[Result]) -> str | None:
    """Return a table of the answers in words that have no points yet; None if there are none.

    Its columns are those of overrides.csv and the answer in one line.
    """
    rows = [
        [result.student, name, "", "", escape_formula(flatten_answer(part.answer or ""))]
        for result in results
        if result.override is None
        for name, part in result.parts.items()
        if part.points is None and part.reason == AWAITS_PERSON
    ]
    return format_csv([["student", "part", "points", "comment", "answer"], *rows]) if rows else None


def _format_cell(column: str, cell: Cell) -> str:
    if isinstance(cell, str):
        return escape_formula(cell)
    if cell is None:
        return ""
    return f"{cell:.1f}" if column == "percent" else format_points(cell)


def is_marked(result: Result) -> bool:
    """Return whether a student has a mark, from qdot or from a person.

    Missing or unusable work has a mark only if a person set one. Work that qdot failed to grade never has a mark.
    """
    status = find_work_status(result)
    return status in ("graded", "late") or (status not in UNMARKED_STATUSES and count_overridden(result) > 0)


def has_points(result: Result) -> bool:
    """Return whether qdot could read the student's work, or a person set points; otherwise no report shows points."""
    return result.obstacle is None or count_overridden(result) > 0


UNMARKED_STATUSES = ("ungraded", "over limit", "to mark")
"""The statuses of work that has no mark until a person sets one."""
REASONS_WITHOUT_MARK = {
    "ungraded": "qdot failed on a part",
    "over limit": "judging a part took too long",
    "to mark": "an answer in words has no points yet",
}
"""For each of `UNMARKED_STATUSES`, the reason for the staff."""
TO_MARK_FILE = "to-mark.csv"
"""The table of the answers that a person has to mark."""


def find_work_status(result: Result) -> str:
    """Return the status of a student's work.

    - "missing": nothing was submitted
    - "unusable": the submission has no notebook of this assignment
    - "ungraded": qdot failed to grade a part
    - "over limit": a part exceeded a limit of grading, and qdot failed on no part
    - "to mark": only answers in words have no points yet; a person has to mark them
    - "late": the work was graded and submitted late
    - "graded": the work was graded and submitted in time
    """
    ungraded_parts = [part for part in result.parts.values() if part.points is None]
    if ungraded_parts and result.override is None:
        if all(part.reason == AWAITS_PERSON for part in ungraded_parts):
            return "to mark"
        has_no_failure = all(part.over_limit or part.reason == AWAITS_PERSON for part in ungraded_parts)
        return "over limit" if has_no_failure else "ungraded"
    if result.submission is None:
        return "missing"
    if result.obstacle is not None:
        return "unusable"
    return "late" if result.late else "graded"


def describe_overrides(result: Result) -> list[str]:
    """Return a description for the staff of each override of a result, for example "p1.jacobian: 2 (was 1.5)"."""
    descriptions = []
    for name, override in result.overrides.items():
        comment = override.comment
        if override.points is not None:
            previous_points = override.previous_points
            previous_mark = "ungraded" if previous_points is None else format_points(previous_points)
            comment = f"{format_points(override.points)} (was {previous_mark}){f', {comment}' if comment else ''}"
        descriptions.append(f"{name}: {comment}")
    return descriptions


def count_overridden(result: Result) -> int:
    """Return the number of marks that a person set, for parts or for the total."""
    return sum(override.points is not None for override in result.overrides.values())


def _compute_late_penalty(result: Result) -> float | None:
    """Return the points deducted for late work; None if no points are deducted."""
    late = result.late
    if late is None or not late.penalty:
        return None
    score = result.score if result.override is None else result.override.previous_points
    assert score is not None
    return sum_points((late.points_before, -score))


def list_staff_notes(result: Result) -> list[str]:
    """Return the notes on a submission for the staff, for example why the notebook is unusable."""
    obstacles = [result.obstacle] if result.obstacle is not None and find_work_status(result) == "unusable" else []
    return [*obstacles, *result.staff_notes]


def escape_formula(text: str) -> str:
    """Return a text escaped so that no spreadsheet parses it as a formula, and no terminal as a command."""
    visible_text = escape_controls(text)
    return f"'{visible_text}" if visible_text.lstrip()[:1] in FORMULA_FIRST_CHARACTERS else visible_text
