"""Read a learning platform's export that is used as roster.csv: Canvas's gradebook, or Moodle's participants or grades.

Each line names a student. The columns are preserved, so that the platform can import the file that `qdot grade
--report canvas=…` or `moodle=…` writes. Sources: Canvas's lib/gradebook_exporter.rb and lib/gradebook_importer.rb,
Moodle's grade/import/csv and its language packs.
"""

import csv
import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.input_file import parse_csv_rows, read_table_text

CANVAS, MOODLE = "Canvas", "Moodle"
POINTS_ROW_MARKER = "Points Possible"

_TEST_STUDENT = ("Student, Test", "Test Student")
_TEST_LOGIN = re.compile("[0-9a-f]{40}")
"""The login of Canvas's test student, whose name depends on the language."""

MOODLE_COLUMNS: dict[str, tuple[str, ...]] = {
    "first": ("first name", "vorname", "prénom", "nombre", "nome", "voornaam"),
    "last": ("last name", "surname", "nachname", "nom", "nom de famille", "apellido(s)", "cognome", "achternaam"),
    "id number": (
        "id number", "idnumber", "id-nummer", "numéro d'identification", "número de id", "codice identificativo",
    ),
    "username": ("username", "anmeldename", "nom d'utilisateur", "nombre de usuario", "gebruikersnaam"),
    "email": (
        "email address", "email", "e-mail-adresse", "adresse de courriel", "dirección de correo", "indirizzo email",
        "e-mailadres",
    ),
}  # fmt: skip
"""Moodle's column names in lower case: English, German, French, Spanish, Italian, Dutch."""
MOODLE_KEYS = ("id number", "username", "email")
"""Columns that identify a Moodle user; the first one that is filled in becomes the student's identifier."""


@dataclass(frozen=True)
class Gradebook:
    """An unchanged export: its columns, Canvas's row of points (empty for Moodle), and each student's cells."""

    platform: str
    header: tuple[str, ...]
    points_row: tuple[str, ...]
    rows_by_student: Mapping[str, tuple[str, ...]]

    @property
    def identity_column_count(self) -> int:
        """The number of columns that identify the student in Canvas: the first ones, up to "Section"."""
        return next((index + 1 for index, name in enumerate(self.header) if "Section" in name), 3)


@dataclass(frozen=True)
class Export:
    """An export, and its students as lines of a roster: the number of each line, and its cells by column."""

    gradebook: Gradebook
    table: list[tuple[int, dict[str, str]]]


NumberedRows = Sequence[tuple[int, tuple[str, ...]]]


def read_export(path: Path) -> Export | None:
    """Return a platform's export; None if the file is not an export. Raises QdotError."""
    if not path.is_file():
        return None
    rows = _parse_rows(read_table_text(path))
    if not rows:
        return None
    header = [name.strip() for name in rows[0][1]]
    if _is_canvas(header, rows):
        return _read_canvas(path, header, rows)
    columns = {key: find_column(header, names) for key, names in MOODLE_COLUMNS.items()}
    if columns["first"] is not None and columns["last"] is not None and header[0].lower() != "student":
        return _read_moodle(path, header, rows, columns)
    return None


def normalize_identifier(text: str) -> str:
    """Normalise an identifier (Unicode NFC, no surrounding spaces), so that identifiers can be compared."""
    return unicodedata.normalize("NFC", text.strip())


def _parse_rows(text: str) -> NumberedRows:
    """Return the lines that are not empty, each with as many cells as the first."""
    try:
        rows = list(parse_csv_rows(text))
    except csv.Error:
        return []  # read_table reports the error
    width = len(rows[0][1]) if rows else 0
    return [(number, tuple((row + [""] * width)[:width])) for number, row in rows]


def _due_cell(header: list[str], cells: tuple[str, ...]) -> dict[str, str]:
    return {"due": cells[header.index("due")]} if "due" in header else {}


def find_column(header: Sequence[str], names: Sequence[str]) -> int | None:
    """Return the index of the column that has one of these names, which are in lower case; None if there is none."""
    return next((index for index, name in enumerate(header) if name.lower() in names), None)


# --- Canvas ---


def _is_canvas(header: Sequence[str], rows: NumberedRows) -> bool:
    """Return whether the header satisfies Canvas's importer and one of the next rows is the row of points."""
    has_required_columns = header[:2] == ["Student", "ID"] or header[:3] == ["LastName", "FirstName", "ID"]
    return has_required_columns and "Section" in header and any(POINTS_ROW_MARKER in row[0] for _, row in rows[1:4])


def _read_canvas(path: Path, header: list[str], rows: NumberedRows) -> Export:
    column_index = {name: header.index(name) for name in header}
    identity = header[: column_index["Section"] + 1]
    table, lines = list[tuple[int, dict[str, str]]](), dict[str, tuple[str, ...]]()
    points: tuple[str, ...] = ()
    for number, cells in rows[1:]:
        identity_cells = {name: cells[column_index[name]].strip() for name in identity}
        identifier, login = identity_cells["ID"], identity_cells.get("SIS Login ID", "")
        names = (identity_cells.get("LastName", ""), identity_cells.get("FirstName", ""))
        name = identity_cells.get("Student") or ", ".join(names).strip(", ")
        if POINTS_ROW_MARKER in cells[0] and not identifier:  # a student may have this name
            points = tuple(cell.strip() for cell in cells)
        elif any(identity_cells.values()) and not _is_test_student(name, login):
            if not identifier:
                raise QdotError(f"{path}: line {number}: the column ID is empty; Canvas needs it to identify {name!r}")
            lines[normalize_identifier(identifier)] = cells
            line = {"student": identifier, "name": _first_name_first(name), "email": login if "@" in login else ""}
            line |= {
                column.lower(): identity_cells[column] for column in identity if column not in _CANVAS_NAME_COLUMNS
            }
            table.append((number, line | _due_cell(header, cells)))
    return Export(Gradebook(CANVAS, tuple(header), points, lines), table)


_CANVAS_NAME_COLUMNS = ("Student", "LastName", "FirstName", "ID")


def _is_test_student(name: str, login: str) -> bool:
    return name in _TEST_STUDENT or _TEST_LOGIN.fullmatch(login) is not None


def _first_name_first(name: str) -> str:
    """Return "Lovelace, Ada" with the first name first; Canvas writes a name that begins with = as ="=…".

    >>> _first_name_first("Lovelace, Ada"), _first_name_first("Aristotle")
    ('Ada Lovelace', 'Aristotle')
    """
    last_name, comma, first_name = name.removeprefix('="').removesuffix('"').partition(", ")
    return f"{first_name} {last_name}" if comma and ", " not in first_name else name


# --- Moodle ---


def _read_moodle(path: Path, header: list[str], rows: NumberedRows, columns: Mapping[str, int | None]) -> Export:
    """Return Moodle's export; the first key column that is filled in identifies the students."""
    filled_keys = [
        key
        for key in MOODLE_KEYS
        if (index := columns[key]) is not None and any(row[index].strip() for _, row in rows[1:])
    ]
    if not filled_keys:
        raise QdotError(
            f"{path}: line 1: no column identifies the users in Moodle; export it with the ID number, the username "
            "or the email address"
        )
    table, lines = list[tuple[int, dict[str, str]]](), dict[str, tuple[str, ...]]()
    for number, cells in rows[1:]:
        key_cells = {key: cells[index].strip() for key, index in columns.items() if index is not None}
        if not key_cells[filled_keys[0]]:
            column = header[columns[filled_keys[0]] or 0]
            raise QdotError(
                f"{path}: line {number}: the column {column!r} is empty, but it identifies the students; fill it in, "
                "or delete the column, so that qdot uses the next of ID number, username and email address"
            )
        identifier = normalize_identifier(key_cells[filled_keys[0]])
        lines[identifier] = cells
        name = f"{key_cells['first']} {key_cells['last']}".strip()
        other_keys: dict[str, str] = {key: key_cells[key] for key in filled_keys if key != "email"}
        line = {"student": identifier, "name": name, "email": key_cells.get("email", ""), **other_keys}
        table.append((number, line | _due_cell(header, cells)))
    return Export(Gradebook(MOODLE, tuple(header), (), lines), table)
