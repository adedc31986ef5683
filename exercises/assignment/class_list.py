"""Read a class list that a learning platform has exported: Canvas's gradebook, or Moodle's participants or grades.

An instructor may save such a file as roster.csv. qdot preserves the columns by which the platform identifies students.
So the platform can import the grades that `qdot grade --report canvas=…` or `--report moodle=…` writes. Sources:
Canvas's lib/gradebook_exporter.rb and lib/gradebook_importer.rb, Moodle's grade/import/csv and its language packs.
"""

import csv
import re
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.input_file import parse_csv_rows, read_table_text

CANVAS, MOODLE = "Canvas", "Moodle"
POINTS_ROW_MARKER = "Points Possible"
"""Text in the first cell of Canvas's row of points, which comes before the students."""

_TEST_STUDENT_NAMES = ("Student, Test", "Test Student")
_TEST_LOGIN = re.compile("[0-9a-f]{40}")
"""The login of Canvas's test student. The test student's name depends on the language, so the name is not enough."""
_CANVAS_NAME_COLUMNS = ("Student", "LastName", "FirstName", "ID")

MOODLE_COLUMNS: dict[str, tuple[str, ...]] = {
    "first name": ("first name", "firstname", "vorname", "prénom", "nombre", "nome", "voornaam"),
    "last name": (
        "last name", "lastname", "surname", "nachname", "nom", "nom de famille", "apellido(s)", "cognome", "achternaam",
    ),
    "id number": (
        "id number", "idnumber", "id-nummer", "numéro d'identification", "número de id", "codice identificativo",
    ),
    "username": ("username", "anmeldename", "nom d'utilisateur", "nombre de usuario", "gebruikersnaam"),
    "email": (
        "email address", "email", "e-mail", "mail", "e-mail-adresse", "adresse de courriel", "dirección de correo",
        "indirizzo email", "e-mailadres",
    ),
}  # fmt: skip
"""Moodle's column names in lower case: English, German, French, Spanish, Italian, Dutch."""
MOODLE_KEYS = ("id number", "username", "email")
"""Columns that identify a Moodle user; the first one that is filled in becomes the student's identifier."""

_ADDED_COLUMN = re.compile(r"due|login|[a-z][a-z ]* id|(student|candidate|matriculation) number|matrikelnummer")
"""Matches the names, in lower case, of columns that an instructor adds to an export, such as "moodle id"."""

LAST_NAME_KEY = "last name of the export"
"""The key of the last name in a RosterLine made from an export; a name that no column of an instructor has."""

NumberedRows = Sequence[tuple[int, tuple[str, ...]]]
"""The rows of a table, each as the number of its line in the file, and its cells."""
RosterLine = dict[str, str]
"""A student as a line of a roster: cells by column, with at least the columns student, name and email."""


class ExportedStudent(NamedTuple):
    """A student in an export: the number of the line in the file, its unchanged cells, and the line of a roster."""

    line_number: int
    cells: tuple[str, ...]
    roster_line: RosterLine


@dataclass(frozen=True)
class PlatformClassList:
    """A platform's export: its columns, Canvas's row of points (empty for Moodle), and the students.

    `rows_by_student` has the unchanged cells of each student, by identifier. `roster_lines` has the same students as
    lines of a roster, each with the number of its line in the file.
    """

    platform: str
    header: tuple[str, ...]
    points_row: tuple[str, ...]
    rows_by_student: Mapping[str, tuple[str, ...]]
    roster_lines: list[tuple[int, RosterLine]]

    @property
    def identity_column_count(self) -> int:
        """The number of columns that identify the student in Canvas: the first ones, up to "Section"."""
        return self.header.index("Section") + 1


def read_class_list(path: Path) -> PlatformClassList | None:
    """Return a platform's export; None if the file is not an export. Raises QdotError."""
    rows = _parse_rows(read_table_text(path)) if path.is_file() else []
    if not rows:
        return None
    _, header_cells = rows[0]
    header = tuple(name.strip() for name in header_cells)
    points_row: tuple[str, ...] = ()
    columns = {key: find_column(header, names) for key, names in MOODLE_COLUMNS.items()}
    if _is_canvas(header, rows):
        platform, students = CANVAS, list(_iterate_canvas_students(path, header, rows))
        points_row = next((tuple(map(str.strip, cells)) for _, cells in rows[1:] if _is_points_row(header, cells)), ())
    elif None not in (columns["first name"], columns["last name"]) and header[0].lower() != "student":
        platform, students = MOODLE, list(_iterate_moodle_students(path, header, rows, columns))
    else:
        return None
    for index, column in enumerate(header):
        if _ADDED_COLUMN.fullmatch(column.lower()):
            for student in students:
                student.roster_line.setdefault(column.lower(), student.cells[index].strip())
    rows_by_student = {normalize_identifier(student.roster_line["student"]): student.cells for student in students}
    roster_lines = [(student.line_number, student.roster_line) for student in students]
    return PlatformClassList(platform, header, points_row, rows_by_student, roster_lines)


def normalize_identifier(text: str) -> str:
    """Normalise an identifier (Unicode NFC, no surrounding spaces), so that identifiers can be compared."""
    return unicodedata.normalize("NFC", text.strip())


def _parse_rows(text: str) -> NumberedRows:
    """Return the lines that are not empty, each with as many cells as the first."""
    try:
        rows = list(parse_csv_rows(text))
    except csv.Error:
        return []  # `read_table`, which reads files that are not exports, reports the error
    width = len(rows[0][1]) if rows else 0
    return [(number, tuple((row + [""] * width)[:width])) for number, row in rows]


def find_column(header: Sequence[str], names: Sequence[str]) -> int | None:
    """Return the index of the column that has one of these names, which are in lower case; None if there is none."""
    return next((index for index, name in enumerate(header) if name.lower() in names), None)


def get_cell_under_any_name(cells: Mapping[str, str], column: str) -> str:
    """Return the cell in a column of `MOODLE_COLUMNS` under any of the column's names; "" if there is none."""
    return next((cells[name].strip() for name in MOODLE_COLUMNS[column] if cells.get(name, "").strip()), "")


# --- Canvas ---


def _is_canvas(header: tuple[str, ...], rows: NumberedRows) -> bool:
    """Return whether the header satisfies Canvas's importer and one of the next rows is the row of points."""
    has_required_columns = header[:2] == ("Student", "ID") or header[:3] == ("LastName", "FirstName", "ID")
    return has_required_columns and "Section" in header and any(POINTS_ROW_MARKER in row[0] for _, row in rows[1:4])


def _is_points_row(header: tuple[str, ...], cells: tuple[str, ...]) -> bool:
    """Return whether a row is Canvas's row of points. It has no ID, unlike a student with the marker as a name."""
    return POINTS_ROW_MARKER in cells[0] and not cells[header.index("ID")].strip()


def _iterate_canvas_students(path: Path, header: tuple[str, ...], rows: NumberedRows) -> Iterator[ExportedStudent]:
    """Yield the students in Canvas's export, without its test student."""
    identity_columns = header[: header.index("Section") + 1]
    for number, cells in rows[1:]:
        identity = {name: cell.strip() for name, cell in zip(identity_columns, cells, strict=False)}
        identifier, login = identity["ID"], identity.get("SIS Login ID", "")
        names = (identity.get("LastName", ""), identity.get("FirstName", ""))
        name = identity.get("Student") or ", ".join(names).strip(", ")
        is_test_student = name in _TEST_STUDENT_NAMES or _TEST_LOGIN.fullmatch(login) is not None
        if _is_points_row(header, cells) or is_test_student or not any(identity.values()):
            continue
        if not identifier:
            raise QdotError(
                f"{path}: line {number}: the cell in the column ID is empty; Canvas needs it to identify {name!r}"
            )
        name, last_name = _put_first_name_first(name)
        line = {
            "student": identifier, "name": name, LAST_NAME_KEY: last_name, "email": login if "@" in login else "",
        }  # fmt: skip
        other_cells = {key.lower(): cell for key, cell in identity.items() if key not in _CANVAS_NAME_COLUMNS}
        yield ExportedStudent(number, cells, line | other_cells)


def _put_first_name_first(name: str) -> tuple[str, str]:
    """Return a name such as "Lovelace, Ada" with the first name first, and the last name alone.

    Canvas writes the name =Ada as ="=Ada".

    >>> _put_first_name_first("García Márquez, Gabriel"), _put_first_name_first("Aristotle")
    (('Gabriel García Márquez', 'García Márquez'), ('Aristotle', ''))
    """
    last_name, comma, first_name = name.removeprefix('="').removesuffix('"').partition(", ")
    return (f"{first_name} {last_name}", last_name) if comma and ", " not in first_name else (name, "")


# --- Moodle ---


def _iterate_moodle_students(
    path: Path, header: tuple[str, ...], rows: NumberedRows, columns: Mapping[str, int | None]
) -> Iterator[ExportedStudent]:
    """Yield the students in Moodle's export; `columns` has the indices of the columns in MOODLE_COLUMNS.

    The first of `MOODLE_KEYS` whose column is filled in identifies the students.
    """
    column_by_key = {key: index for key, index in columns.items() if index is not None}
    filled_keys = [
        key
        for key in MOODLE_KEYS
        if key in column_by_key and any(cells[column_by_key[key]].strip() for _, cells in rows[1:])
    ]
    if not filled_keys:
        raise QdotError(
            f"{path}: line 1: no column identifies the students; export the file from Moodle with the ID number, the "
            "username or the email address; in a table of your own, put the identifiers into a first column 'student'"
        )
    identity_key = filled_keys[0]
    for number, cells in rows[1:]:
        cell_by_key = {key: cells[index].strip() for key, index in column_by_key.items()}
        if not cell_by_key[identity_key]:
            column = header[column_by_key[identity_key]]
            raise QdotError(
                f"{path}: line {number}: the cell in the column {column!r} is empty, but the column identifies the "
                "students; fill the cell in; delete the line, if it is a teacher's; or delete the column, so that qdot "
                "uses the next of ID number, username and email address"
            )
        last_name = cell_by_key["last name"]
        name = f"{cell_by_key['first name']} {last_name}".strip()
        line = {
            "student": normalize_identifier(cell_by_key[identity_key]), "name": name, LAST_NAME_KEY: last_name,
            "email": cell_by_key.get("email", ""),
        }  # fmt: skip
        other_cells = {key: cell_by_key[key] for key in filled_keys if key != "email"}
        yield ExportedStudent(number, cells, line | other_cells)
