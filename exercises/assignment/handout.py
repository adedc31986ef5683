"""Pack the notebooks of a class to hand them out (`qdot release`): by links, in Moodle, or in folders.

All files can be made again from released/. In the folder of links, each address is a keyed hash of a student's
identifier. So it stays the same, and nobody can compute it without the secret.
"""

import base64
import hashlib
import hmac
import re
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.release import is_released, make_notebook_path
from qdot.exercises.common.errors import QdotError, write_first
from qdot.exercises.common.files import make_zip, write_atomically
from qdot.exercises.common.input_file import BYTE_ORDER_MARK, format_csv, parse_csv_rows, read_table_text
from qdot.exercises.writing.render import render

INDEX_FILE = "index.csv"
"""The table beside the notebooks that says which notebook belongs to which student."""
TOKEN_LENGTH = 26
"""The number of letters and digits in an address: 130 bits."""
MAX_STUDENTS_LISTED = 10
"""Maximum number of students named in a message."""

_TOKEN = re.compile(f"[a-z2-7]{{{TOKEN_LENGTH}}}")
_UNSAFE_CHARACTERS = re.compile(r'[<>:"/\\|?*\x00-\x1f\x7f]')
"""Matches characters that some systems don't allow in file names."""
_PARTICIPANT_NUMBER = re.compile(r"\D+(\d+)\D*")
"""Matches the identifier in Moodle's grading worksheet, as in "Participant 12"."""
_NUMBER_COLUMN = "moodle id"
"""The column with Moodle's numbers in the table of released notebooks."""


@dataclass(frozen=True)
class Handout:
    """The output of `qdot release`: the paths of the files to distribute and of the table for the staff."""

    path: Path
    table_path: Path


def make_index_csv(assignment: Assignment) -> str:
    """Return the table of the released notebooks: student, name, e-mail address and file."""
    recipients = [student for student in assignment.roster if make_notebook_path(assignment, student.id).exists()]
    rows = [[s.id, s.name, s.email, f"{s.id}/{assignment.key}.ipynb"] for s in recipients]
    return format_csv([["student", "name", "email", "file"], *rows])


def make_file_name(student: Student) -> str:
    """Return a name for a student's file that people can find: Lovelace, Ada (501).

    >>> make_file_name(Student("501", "Ada Lovelace")), make_file_name(Student("502"))
    ('Lovelace, Ada (501)', '502')
    """
    name = student.name.strip()
    last_name = student.last_name or ("" if "," in name else name.rpartition(" ")[2])
    first_name = name.removesuffix(last_name).strip()
    if last_name and first_name not in ("", name):
        name = f"{last_name}, {first_name}"
    return _UNSAFE_CHARACTERS.sub("-", f"{name} ({student.id})" if name else student.id)


def read_notebooks(assignment: Assignment) -> dict[str, bytes]:
    """Map each student to the released notebook. Raises QdotError if one is missing or out of date."""
    outdated = [student.id for student in assignment.roster if not is_released(assignment, student.id)]
    if outdated:
        names = write_first(outdated, MAX_STUDENTS_LISTED)
        raise QdotError(f"no current notebook in released/ for {names}; run: qdot generate {assignment.folder}")
    return {student.id: make_notebook_path(assignment, student.id).read_bytes() for student in assignment.roster}


def write_folders(assignment: Assignment, out: Path) -> Handout:
    """Write a folder with each student's notebook, named after the student, and a table beside the folders."""
    notebooks = read_notebooks(assignment)
    names = {student.id: f"{make_file_name(student)}/{assignment.key}.ipynb" for student in assignment.roster}
    for student, notebook in notebooks.items():
        write_atomically(out / names[student], notebook, is_synced=False)
    rows = [[s.id, s.name, s.email, names[s.id]] for s in assignment.roster]
    table_path = out / INDEX_FILE
    write_atomically(table_path, format_csv([["student", "name", "email", "file"], *rows]))
    return Handout(out, table_path)


# --- links ---


def write_links(assignment: Assignment, out: Path, address: str) -> Handout:
    """Write a folder to upload to any file server, with a page and the notebook at one address for each student.

    `address` is the address of the uploaded folder; if it is "", the table for a mail merge has only paths. Addresses
    of students who are no longer on the roster are removed.
    """
    notebooks = read_notebooks(assignment)
    upload_folder = out / "upload"
    tokens = {student.id: _compute_token(assignment, student.id) for student in assignment.roster}
    for folder in upload_folder.iterdir() if upload_folder.is_dir() else ():
        if _TOKEN.fullmatch(folder.name) and folder.name not in tokens.values():
            shutil.rmtree(folder)
    write_atomically(upload_folder / "index.html", render("handout/links.html.j2", title=assignment.title))
    for student in assignment.roster:
        folder = upload_folder / tokens[student.id]
        page = render("handout/student.html.j2", assignment=assignment, student=student,
                      due_date=assignment.due_date_of(student))  # fmt: skip
        write_atomically(folder / f"{assignment.key}.ipynb", notebooks[student.id], is_synced=False)
        write_atomically(folder / "index.html", page, is_synced=False)
    site_address = f"{address.rstrip('/')}/" if address else ""
    rows = [[s.name, s.email, s.id, f"{site_address}{tokens[s.id]}/"] for s in assignment.roster]
    table_path = out / "mail-merge.csv"
    table = format_csv([["name", "email", "student", "link"], *rows])
    write_atomically(table_path, BYTE_ORDER_MARK + table, 0o600)
    return Handout(upload_folder, table_path)


def _compute_token(assignment: Assignment, student: str) -> str:
    """Return the part of a student's address that nobody can guess."""
    message = f"link\0{assignment.key}\0{student}".encode()
    digest = hmac.new(assignment.secret.encode(), message, hashlib.sha256).digest()
    return base64.b32encode(digest).decode().lower()[:TOKEN_LENGTH]


# --- Moodle ---


def write_moodle_zip(assignment: Assignment, out: Path, worksheet: Path) -> Handout:
    """Write the zip that gives each student the notebook as a feedback file of an assignment in Moodle.

    `worksheet` is the assignment's grading worksheet, which has the number of each participant. Raises QdotError if it
    is not certain which line belongs to a student.
    """
    notebooks = read_notebooks(assignment)
    numbers = _find_participant_numbers(assignment.roster, worksheet)
    names = {s.id: _UNSAFE_CHARACTERS.sub("-", s.name.replace("_", " ")) or s.id for s in assignment.roster}
    folders = {student: f"{names[student]}_{number}_assignfeedback_file" for student, number in numbers.items()}
    files = {f"{folder}/{assignment.key}.ipynb": notebooks[student] for student, folder in folders.items()}
    zip_path, table_path = out / "moodle-notebooks.zip", out / INDEX_FILE
    rows = [[s.id, s.name, s.email, numbers[s.id], folders[s.id]] for s in assignment.roster]
    write_atomically(zip_path, make_zip(files))
    write_atomically(table_path, format_csv([["student", "name", "email", _NUMBER_COLUMN, "folder"], *rows]), 0o600)
    return Handout(zip_path, table_path)


def read_moodle_numbers(folder: Path) -> Mapping[str, str]:
    """Map each Moodle number to its student, as in the table that `write_moodle_zip` wrote; empty without the table."""
    table_path = folder / "handout" / "moodle" / INDEX_FILE
    if not table_path.is_file():
        return {}
    header, *rows = [cells for _, cells in parse_csv_rows(read_table_text(table_path))] or [[]]
    if not {"student", _NUMBER_COLUMN} <= set(header):
        return {}
    student_index, number_index = header.index("student"), header.index(_NUMBER_COLUMN)
    return {cells[number_index]: cells[student_index] for cells in rows if len(cells) == len(header)}


def _find_participant_numbers(roster: Sequence[Student], worksheet: Path) -> Mapping[str, str]:
    """Map each student to the participant's number in a grading worksheet. Raises QdotError."""
    rows = list(_read_worksheet(worksheet))
    numbers = {}
    unplaced_students = []
    for student in roster:
        texts = filter(None, (student.email, student.id, student.name))  # the most reliable one first
        keys = (" ".join(text.split()).casefold() for text in texts)
        # the lines that contain the first of these texts that occurs at all
        matches = next(filter(None, ([number for number, cells in rows if key in cells] for key in keys)), [])
        if len(matches) == 1:
            numbers[student.id] = matches[0]
        else:
            unplaced_students.append(student.id)
    if len(set(numbers.values())) < len(numbers) or unplaced_students:
        names = write_first(unplaced_students or sorted(numbers), MAX_STUDENTS_LISTED)
        raise QdotError(
            f"{worksheet}: it is not certain which line belongs to {names}; the worksheet needs the e-mail address or "
            "the identifier that roster.csv has. If students joined later, download the worksheet again; delete the "
            "lines of teachers in roster.csv"
        )
    return numbers


def _read_worksheet(path: Path) -> Iterator[tuple[str, frozenset[str]]]:
    """Yield the participant's number and the other cells of each line of a grading worksheet. Raises QdotError."""
    rows = list(parse_csv_rows(read_table_text(path, "download it in Moodle")))
    matches = [(_PARTICIPANT_NUMBER.fullmatch(cells[0].strip()), cells) for _, cells in rows[1:] if cells]
    if not matches or not all(match for match, _ in matches):
        raise QdotError(
            f'{path} is not a grading worksheet of Moodle: the first column must be the identifier, as in "Participant '
            f'12"; in the assignment, allow "Offline grading worksheet" as a feedback type, and download it'
        )
    for match, cells in matches:
        assert match is not None
        yield match[1], frozenset(" ".join(cell.split()).casefold() for cell in cells[1:])
