"""Gradebooks that Canvas and Moodle import, as their importers really read them.

Whose line is whose is said by the platform's own columns, where roster.csv is its export or has such columns; else by
the roster's identifiers. A cell holds a mark that qdot or a person gave, and nothing else: what was not handed in, not
readable or not graded has none. Sources: Canvas's lib/gradebook_importer.rb, Moodle's
grade/import/csv/classes/load_data.php.
"""

import csv
import io
import re
from collections.abc import Iterator, Sequence

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.gradebook import CANVAS, MOODLE, MOODLE_COLUMNS, MOODLE_KEYS, POINTS, Gradebook
from qdot.exercises.common.errors import QdotError
from qdot.grader.grading.marking import number
from qdot.grader.grading.result import Result
from qdot.grader.reports.tables import is_marked, no_formula, status

RESERVED = tuple(
    f"{when} {what}"
    for when, kinds in (
        ("Current", ("Score", "Points", "Grade")), ("Final", ("Score", "Points", "Grade")),
        ("Override", ("Score", "Grade", "Status")),
    )
    for what in kinds
)  # fmt: skip
"""A column of Canvas whose title holds one of these is passed over, without a word."""
EXCUSED = "EX"
"""Canvas's word for a student who need not hand in."""
NO_GRADE = "-"
"""Moodle's word for no grade; an empty cell is 0 where a new grade item is made."""
MOST = 100
"""Moodle refuses higher grades, and with them the whole file, unless the site allows them."""

_SIMPLE = re.compile(r"[+-]?[\d .]*")


def unmarked(_: Assignment, results: Sequence[Result]) -> list[str]:
    """Return a note on those whose cell holds no mark, and why."""
    without = [f"{result.student} ({status(result)})" for result in results if not is_marked(result)]
    return [f"no mark for {', '.join(without)}"] if without else []


# --- Canvas ---

CANVAS_COLUMNS = {
    "ID": ("canvas id", "canvas user id"),
    "SIS User ID": ("sis user id", "sis id"),
    "SIS Login ID": ("sis login id", "login id"),
    "Section": ("section",),
}
"""Columns of a roster of one's own that Canvas knows; `id` alone may be anybody's number."""


def canvas(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return the CSV that Canvas imports. Raises QdotError where its importer would pass the marks over.

    An assignment that Canvas has is called as in the export, with its number; what it says of who is excused stays.
    """
    title = _title(assignment)
    word = next((word for word in RESERVED if word in title), None)
    if word is not None:
        raise QdotError(
            f"canvas: Canvas passes over a column whose title holds {word!r}; give the assignment another title"
        )
    book = assignment.gradebook
    if book is None or book.platform != CANVAS:
        return _canvas_of_roster(assignment, results, title)
    at = _column_of(book, title)
    points = number(results[0].max_score)
    if at is not None and book.points and _number(book.points[at]) not in (None, _number(points)):
        raise QdotError(
            f"canvas: {book.header[at]!r} has {book.points[at]} points in Canvas and {points} here; set one like the "
            "other (`points` in assignment.toml), so that marks mean the same"
        )
    whose = book.header[: book.identity]
    rows = [[*whose, title if at is None else book.header[at]], _points_row(len(whose), points)]
    for result in results:
        line = book.lines[result.student]
        before = "" if at is None else line[at].strip()
        cell = EXCUSED if before.upper() == EXCUSED else _mark(result)
        rows.append([*_safe(line[: len(whose)]), cell])
    return _text(rows)


def _canvas_of_roster(assignment: Assignment, results: Sequence[Result], title: str) -> str:
    others = {student.id: dict(student.others) for student in assignment.roster}
    columns = {
        head: next((name for name in names if any(own.get(name, "").strip() for own in others.values())), "")
        for head, names in CANVAS_COLUMNS.items()
    }
    known = any(columns[head] for head in ("ID", "SIS User ID", "SIS Login ID"))
    by_id = {student.id: student for student in assignment.roster}
    rows = [["Student", *CANVAS_COLUMNS, title], _points_row(5, number(results[0].max_score))]
    for result in results:
        student = by_id[result.student]
        cells = {head: others[student.id].get(name, "") for head, name in columns.items()}
        if not known:
            cells["SIS Login ID"] = student.id
        excused = next((value for name, value in student.others if name == title.lower()), "")
        mark = EXCUSED if excused.strip().upper() == EXCUSED else _mark(result)
        rows.append([*_safe([student.name or student.id, *cells.values()]), mark])
    return _text(rows)


def _points_row(whose: int, points: str) -> list[str]:
    return [f"    {POINTS}", *[""] * (whose - 1), points]


def _column_of(book: Gradebook, title: str) -> int | None:
    """Return which column of Canvas's is this assignment's: its title, a number in parentheses behind it."""
    pattern = re.compile(rf"{re.escape(title)}( \(\d+\))?", re.IGNORECASE)
    columns = [index for index in range(book.identity, len(book.header)) if pattern.fullmatch(book.header[index])]
    if len(columns) > 1:
        raise QdotError(
            f"canvas: Canvas has {len(columns)} assignments that are called {title!r}; give this one a title of its own"
        )
    return columns[0] if columns else None


def _number(text: str) -> float | None:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return None


# --- Moodle ---


def moodle(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return the CSV that Moodle imports: who, the points, and per cent of them.

    A column that says who is left out unless it is filled in, and with another text, for everybody: with an empty cell
    Moodle gives the mark to the student of the line above.
    """
    title = _title(assignment)
    highest = results[0].max_score
    columns = _moodle_columns(assignment)
    marks = ([title] if highest <= MOST else []) + [f"{title} (percent)"]
    rows = [[*(name for name, _ in columns), *marks]]
    for index, result in enumerate(results):
        cells = [NO_GRADE, NO_GRADE]
        if is_marked(result):
            cells = [number(result.score), number(result.percent)]
        rows.append([*_safe([values[index] for _, values in columns]), *cells[-len(marks) :]])
    return _text(rows)


def _moodle_columns(assignment: Assignment) -> list[tuple[str, list[str]]]:
    """Return the columns that say who, by what they are called; the students' names among them are for people."""
    roster, book = assignment.roster, assignment.gradebook
    if book is not None and book.platform == MOODLE:
        heads = {key: [name for name in book.header if name.lower() in MOODLE_COLUMNS[key]] for key in MOODLE_COLUMNS}
        columns = [
            (name, [book.lines[student.id][book.header.index(name)] for student in roster])
            for key in MOODLE_COLUMNS
            for name in heads[key][:1]
        ]
        names, keys = columns[:2], columns[2:]
    else:
        names = [("Name", [student.name for student in roster])]
        keys = list(_keys_of_roster(roster))
    return [*names, *([each for each in keys if _tells_apart(each[1])] or [("student", [one.id for one in roster])])]


def _keys_of_roster(roster: Sequence[Student]) -> Iterator[tuple[str, list[str]]]:
    heads = dict(zip(MOODLE_KEYS, ("ID number", "Username", "Email address"), strict=True))
    for key in MOODLE_KEYS[:-1]:
        for name in MOODLE_COLUMNS[key]:
            if any(name == column for column, _ in roster[0].others):
                yield heads[key], [dict(student.others).get(name, "") for student in roster]
    yield heads["email"], [student.email for student in roster]


def _tells_apart(values: Sequence[str]) -> bool:
    """Tell whether Moodle finds everybody by these; "0" is as good as nothing in PHP."""
    said = [value.strip() for value in values]
    return all(value not in ("", "0") for value in said) and len({value.lower() for value in said}) == len(said)


# --- both ---


def _title(assignment: Assignment) -> str:
    return no_formula(" ".join(assignment.title.split()))


def _mark(result: Result) -> str:
    return number(result.score) if is_marked(result) else ""


def _safe(cells: Sequence[str]) -> list[str]:
    """Return cells that no spreadsheet takes for a formula, nor Canvas for its row of points; +49 170 is a number."""
    texts = [" ".join(cell.split()).replace(POINTS, POINTS.lower()) for cell in cells]
    return [text if _SIMPLE.fullmatch(text) else no_formula(text) for text in texts]


def _text(rows: Sequence[Sequence[str]]) -> str:
    """Return CSV: commas, decimal points, no byte order mark, each cell in one line."""
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()
