"""Write gradebooks for Canvas, Moodle and Brightspace, in the form that their importers require.

The platform's columns identify the students if roster.csv is the platform's export or has such columns; otherwise, the
roster's identifiers do. A cell contains only a mark that qdot or a person gave. The cell is empty if the work is
missing, unreadable or ungraded. Sources: Canvas's lib/gradebook_importer.rb, Moodle's
grade/import/csv/classes/load_data.php, Brightspace's "Importing grades".
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.class_list import (
    CANVAS,
    MOODLE,
    MOODLE_COLUMNS,
    MOODLE_KEYS,
    POINTS_ROW_MARKER,
    PlatformClassList,
    find_column,
)
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.input_file import format_csv
from qdot.grader.grading.result import Result
from qdot.grader.marking.marking import format_points
from qdot.grader.reports.grades_table import escape_formula, find_work_status, is_marked

RESERVED_PHRASES = (
    "Current Score", "Current Points", "Current Grade", "Final Score", "Final Points", "Final Grade", "Override Score",
    "Override Grade", "Override Status",
)  # fmt: skip
"""Canvas silently ignores a column whose title contains one of these phrases."""
EXCUSED = "EX"
"""Canvas's word for a student who need not submit."""
NO_GRADE = "-"
"""The text that means no grade in Moodle; in a new grade item, an empty cell would mean 0."""
MAX_GRADE = 100
"""The maximum grade: Moodle refuses a file with a higher grade unless the site allows such grades."""

_PLAIN_NUMBER = re.compile(r"[+-]?[\d .]*")


def describe_unmarked_students(_: Assignment, results: Sequence[Result]) -> list[str]:
    """Return a note on the students without a mark, with the reasons, in a list; an empty list if all have a mark."""
    reasons = [f"{result.student} ({find_work_status(result)})" for result in results if not is_marked(result)]
    return [f"no mark for {', '.join(reasons)}"] if reasons else []


# --- Canvas ---

CANVAS_COLUMNS = {
    "ID": ("canvas id", "canvas user id"),
    "SIS User ID": ("sis user id", "sis id"),
    "SIS Login ID": ("sis login id", "login id"),
    "Section": ("section",),
}
"""Canvas's columns, with their names in an instructor's own roster; the name `id` would be ambiguous there."""


def make_canvas_csv(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return the CSV that Canvas imports. Raises QdotError if the importer would ignore the marks.

    If Canvas already has the assignment, the column has the title from Canvas's export. Excused students stay excused.
    """
    title = _write_column_title(assignment)
    phrase = next((phrase for phrase in RESERVED_PHRASES if phrase in title), None)
    if phrase is not None:
        rule = f"Canvas ignores columns whose title contains {phrase!r}"
        raise QdotError(f"canvas: {rule}; change the assignment's title")
    points = format_points(results[0].max_score)
    class_list = assignment.class_list
    if class_list is not None and class_list.platform == CANVAS:
        header, students = _identify_by_export(class_list, title, points)
    else:
        header, students = _identify_by_roster(assignment.roster, title)
    rows = [header, [f"    {POINTS_ROW_MARKER}", *[""] * (len(header) - 2), points]]  # four spaces, as Canvas writes
    for result in results:
        student = students[result.student]
        is_excused = student.previous_mark.strip().upper() == EXCUSED
        mark = format_points(result.score) if is_marked(result) else ""
        rows.append([*_escape_cells(student.identity_cells), EXCUSED if is_excused else mark])
    return format_csv(rows)


class CanvasStudent(NamedTuple):
    """The cells by which Canvas identifies a student, and the previous mark for the assignment ("" for none)."""

    identity_cells: Sequence[str]
    previous_mark: str


def _identify_by_export(
    class_list: PlatformClassList, title: str, points: str
) -> tuple[list[str], dict[str, CanvasStudent]]:
    """Return the header of the table, and the cells that identify its students, from Canvas's export."""
    column, count = _find_column(class_list, title), class_list.identity_column_count
    marks = {name: "" if column is None else row[column] for name, row in class_list.rows_by_student.items()}
    students = {name: CanvasStudent(class_list.rows_by_student[name][:count], mark) for name, mark in marks.items()}
    if column is None:
        return [*class_list.header[:count], title], students
    canvas_column = class_list.header[column]
    canvas_points = class_list.points_row[column] if class_list.points_row else ""
    if _parse_number(canvas_points) not in (None, _parse_number(points)):
        raise QdotError(
            f"canvas: {canvas_column!r} has {canvas_points} points in Canvas, but {points} in qdot; change one "
            "of them (`points` in assignment.toml sets qdot's)"
        )
    return [*class_list.header[:count], canvas_column], students


def _identify_by_roster(roster: Sequence[Student], title: str) -> tuple[list[str], dict[str, CanvasStudent]]:
    """Return the header of the table, and the cells that identify its students, from the roster's columns."""
    columns = _find_roster_columns(roster, CANVAS_COLUMNS)
    has_canvas_ids = any(columns[canvas_name] for canvas_name in ("ID", "SIS User ID", "SIS Login ID"))
    students = {}
    for student in roster:
        row = dict(student.other_cells)
        identity = {canvas_name: row.get(name, "") for canvas_name, name in columns.items()}
        if not has_canvas_ids:
            identity["SIS Login ID"] = student.id
        cells = [student.name or student.id, *identity.values()]
        students[student.id] = CanvasStudent(cells, row.get(title.lower(), ""))
    return ["Student", *CANVAS_COLUMNS, title], students


def _find_column(class_list: PlatformClassList, title: str) -> int | None:
    """Return the index of this assignment's column in Canvas's export; None if there is none. Raises QdotError.

    The name of the column is the assignment's title, followed by a number in parentheses.
    """
    pattern = re.compile(rf"{re.escape(title)}( \(\d+\))?", re.IGNORECASE)
    candidates = range(class_list.identity_column_count, len(class_list.header))
    columns = [index for index in candidates if pattern.fullmatch(class_list.header[index])]
    if len(columns) > 1:
        raise QdotError(f"canvas: Canvas has {len(columns)} assignments called {title!r}; choose a unique title")
    return columns[0] if columns else None


def _parse_number(text: str) -> float | None:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return None


# --- Moodle ---


def make_moodle_csv(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return the CSV that Moodle imports: columns that identify students, the points, and the percentage.

    An identifying column is included only if every student has a different, non-empty text in it. If a cell is empty,
    Moodle gives the mark to the student in the line above.
    """
    title = _write_column_title(assignment)
    columns = _list_identifying_columns(assignment)
    mark_titles = ([title] if results[0].max_score <= MAX_GRADE else []) + [f"{title} (percent)"]
    rows = [[*(name for name, _ in columns), *mark_titles]]
    for index, result in enumerate(results):
        marks = [NO_GRADE, NO_GRADE]
        if is_marked(result):
            marks = [format_points(result.score), format_points(result.percent)]
        # Without a column for the points, only the percentage is written.
        rows.append([*_escape_cells([cells[index] for _, cells in columns]), *marks[-len(mark_titles) :]])
    return format_csv(rows)


def _list_identifying_columns(assignment: Assignment) -> list[tuple[str, list[str]]]:
    """Return the titles and cells of the columns that identify students for Moodle; names for people come first."""
    roster, class_list = assignment.roster, assignment.class_list
    if class_list is not None and class_list.platform == MOODLE:
        column_indices = [find_column(class_list.header, names) for names in MOODLE_COLUMNS.values()]
        indices = [index for index in column_indices if index is not None]
        rows = [class_list.rows_by_student[student.id] for student in roster]
        columns = [(class_list.header[index], [row[index] for row in rows]) for index in indices]
        names, keys = columns[:2], columns[2:]  # MOODLE_COLUMNS begins with the first name and the last name
    else:
        names, keys = [("Name", [student.name for student in roster])], list(_list_keys_of_roster(roster))
    identifying_columns = [(header, cells) for header, cells in keys if _identifies_everybody(cells)]
    return [*names, *(identifying_columns or [("student", [student.id for student in roster])])]


def _list_keys_of_roster(roster: Sequence[Student]) -> Iterator[tuple[str, list[str]]]:
    """Yield the titles and cells of the roster's columns by which Moodle may identify students."""
    header_by_key = dict(zip(MOODLE_KEYS, ("ID number", "Username", "Email address"), strict=True))
    for key in MOODLE_KEYS[:-1]:  # all but the email address
        for name in MOODLE_COLUMNS[key]:
            if any(name == column for column, _ in roster[0].other_cells):
                yield header_by_key[key], [dict(student.other_cells).get(name, "") for student in roster]
    yield header_by_key["email"], [student.email for student in roster]


def _identifies_everybody(values: Sequence[str]) -> bool:
    """Return whether Moodle can identify every student by these values; "0" is empty in PHP."""
    texts = [value.strip() for value in values]
    distinct_texts = {text.lower() for text in texts}
    return not distinct_texts & {"", "0"} and len(distinct_texts) == len(texts)


# --- Brightspace ---

BRIGHTSPACE_COLUMNS = {"OrgDefinedId": ("orgdefinedid", "org defined id"), "Username": ("username", "user name")}
"""Brightspace's columns that identify students, with their names in a roster."""


def make_brightspace_csv(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return the CSV that Brightspace imports, with only the students who have a mark.

    Brightspace identifies students by its columns, if the roster has one of them, else by the roster's identifiers as
    user names.
    """
    cells_by_student = {student.id: dict(student.other_cells) for student in assignment.roster}
    all_columns = _find_roster_columns(assignment.roster, BRIGHTSPACE_COLUMNS)
    columns = {title: name for title, name in all_columns.items() if name}
    rows = [[*(columns or ["Username"]), f"{_write_column_title(assignment)} Points Grade", "End-of-Line Indicator"]]
    for result in filter(is_marked, results):
        identity = [cells_by_student[result.student].get(name, "") for name in columns.values()] or [result.student]
        rows.append([*_escape_cells(identity), format_points(result.score), "#"])
    return format_csv(rows)


# --- all ---


def _find_roster_columns(roster: Sequence[Student], names_by_title: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """Return the name of the roster's column for each title of a platform; "" if no student has such a cell."""
    known_names = {name for student in roster for name, cell in student.other_cells if cell.strip()}
    return {title: next((name for name in names if name in known_names), "") for title, names in names_by_title.items()}


def _write_column_title(assignment: Assignment) -> str:
    return escape_formula(" ".join(assignment.title.split()))


def _escape_cells(cells: Sequence[str]) -> list[str]:
    """Return cells escaped for spreadsheets and for Canvas.

    A spreadsheet must not parse a cell as a formula, and Canvas must not take a row for its row of points. Cells such
    as +49 170, which can only be numbers, don't change.
    """
    texts = [" ".join(cell.split()).replace(POINTS_ROW_MARKER, POINTS_ROW_MARKER.lower()) for cell in cells]
    return [text if _PLAIN_NUMBER.fullmatch(text) else escape_formula(text) for text in texts]
