"""A learning platform's own export as roster.csv: Canvas's gradebook, Moodle's participants or grades.

Its lines name the students; its columns stay as they are for the way back, so that what `qdot grade --report canvas=…`
or `moodle=…` writes is known again there. Sources: Canvas's lib/gradebook_exporter.rb and lib/gradebook_importer.rb,
Moodle's grade/import/csv and its language packs.
"""

import csv
import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.input_file import csv_rows, read_table_text

CANVAS, MOODLE = "Canvas", "Moodle"
POINTS = "Points Possible"

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
"""What Moodle calls its columns, in small letters: English, German, French, Spanish, Italian, Dutch."""
MOODLE_KEYS = ("id number", "username", "email")
"""By which Moodle knows a user; the first that is filled in names the student here."""


@dataclass(frozen=True)
class Gradebook:
    """An export as it stands: its columns, Canvas's row of points (else empty), and each student's cells."""

    platform: str
    header: tuple[str, ...]
    points: tuple[str, ...]
    lines: Mapping[str, tuple[str, ...]]

    @property
    def identity(self) -> int:
        """How many of Canvas's first columns say whose line it is: as far as "Section"."""
        return next((index + 1 for index, name in enumerate(self.header) if "Section" in name), 3)


@dataclass(frozen=True)
class Export:
    """An export, and its students as lines of a roster: the number of each line, and its cells by column."""

    gradebook: Gradebook
    table: list[tuple[int, dict[str, str]]]


Rows = Sequence[tuple[int, list[str]]]


def read_export(path: Path) -> Export | None:
    """Return what a platform exported; None where the file is no such export. Raises QdotError."""
    if not path.is_file():
        return None
    rows = _rows(read_table_text(path))
    if not rows:
        return None
    header = [name.strip() for name in rows[0][1]]
    if _is_canvas(header, rows):
        return _canvas(path, header, rows)
    columns = {key: _column(header, names) for key, names in MOODLE_COLUMNS.items()}
    if columns["first"] is not None and columns["last"] is not None and header[0].lower() != "student":
        return _moodle(path, header, rows, columns)
    return None


def identifier_of(text: str) -> str:
    """Return an identifier in the one form in which it is compared."""
    return unicodedata.normalize("NFC", text.strip())


def _rows(text: str) -> Rows:
    """Return the lines with anything in them."""
    try:
        return list(csv_rows(text))
    except csv.Error:
        return []  # a roster's own reader says what is wrong


def _column(header: Sequence[str], names: Sequence[str]) -> int | None:
    return next((index for index, name in enumerate(header) if name.lower() in names), None)


# --- Canvas ---


def _is_canvas(header: Sequence[str], rows: Rows) -> bool:
    """Tell by what Canvas's importer asks of the first row, and by the row of points that every export has."""
    whole = header[:2] == ["Student", "ID"] or header[:3] == ["LastName", "FirstName", "ID"]
    return whole and "Section" in header and any(POINTS in row[0] for _, row in rows[1:4])


def _canvas(path: Path, header: list[str], rows: Rows) -> Export:
    place = {name: header.index(name) for name in header}
    identity = header[: place["Section"] + 1]
    table, lines = list[tuple[int, dict[str, str]]](), dict[str, tuple[str, ...]]()
    points: tuple[str, ...] = ()
    for number, row in rows[1:]:
        cells = tuple((row + [""] * len(header))[: len(header)])
        own = {name: cells[place[name]].strip() for name in identity}
        name = own.get("Student") or f"{own.get('LastName', '')}, {own.get('FirstName', '')}".strip(", ")
        if POINTS in cells[0] and not own["ID"]:  # somebody may be called so
            points = tuple(cell.strip() for cell in cells)
        elif any(own.values()) and not _is_test_student(name, own.get("SIS Login ID", "")):
            if not own["ID"]:
                raise QdotError(f"{path}: line {number}: the column ID is empty, by which Canvas knows {name!r}")
            lines[identifier_of(own["ID"])] = cells
            login = own.get("SIS Login ID", "")
            others = {each.lower(): own[each] for each in identity if each not in _CANVAS_NAMES}
            table.append((number, {"student": own["ID"], "name": _turned(name), "email": _mail(login), **others}))
            if "due" in place:
                table[-1][1]["due"] = cells[place["due"]]
    return Export(Gradebook(CANVAS, tuple(header), points, lines), table)


_CANVAS_NAMES = ("Student", "LastName", "FirstName", "ID")


def _is_test_student(name: str, login: str) -> bool:
    return name in _TEST_STUDENT or _TEST_LOGIN.fullmatch(login) is not None


def _turned(name: str) -> str:
    """Return "Lovelace, Ada" as it is said; Canvas writes a name that begins with = as ="=…".

    >>> _turned("Lovelace, Ada"), _turned("Aristotle")
    ('Ada Lovelace', 'Aristotle')
    """
    last, comma, first = name.removeprefix('="').removesuffix('"').partition(", ")
    return f"{first} {last}" if comma and ", " not in first else name


def _mail(login: str) -> str:
    return login if "@" in login else ""


# --- Moodle ---


def _moodle(path: Path, header: list[str], rows: Rows, columns: Mapping[str, int | None]) -> Export:
    """Return Moodle's list, whose students are called by the first of its keys in which anything is written."""
    filled = [
        key
        for key in MOODLE_KEYS
        if (at := columns[key]) is not None and any(at < len(row) and row[at].strip() for _, row in rows[1:])
    ]
    if not filled:
        raise QdotError(
            f"{path}: line 1: names, and nothing by which Moodle knows a user: export it with the ID number, the "
            "username or the email address"
        )
    table, lines = list[tuple[int, dict[str, str]]](), dict[str, tuple[str, ...]]()
    for number, row in rows[1:]:
        cells = tuple((row + [""] * len(header))[: len(header)])
        own = {key: cells[at].strip() for key, at in columns.items() if at is not None}
        if not own[filled[0]]:
            said = header[columns[filled[0]] or 0]
            raise QdotError(
                f"{path}: line {number}: the column {said!r} is empty, which names the students here; fill it in, or "
                "delete it for everybody, and the next of ID number, username and email address names them"
            )
        identifier = identifier_of(own[filled[0]])
        lines[identifier] = cells
        name = f"{own['first']} {own['last']}".strip()
        others: dict[str, str] = {key: own[key] for key in filled if key != "email"}
        table.append((number, {"student": identifier, "name": name, "email": own.get("email", ""), **others}))
        if "due" in header:
            table[-1][1]["due"] = cells[header.index("due")]
    return Export(Gradebook(MOODLE, tuple(header), (), lines), table)
