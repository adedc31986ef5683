"""An assignment folder: assignment.toml, roster.csv and the secret, read, checked, and explained where wrong."""

import csv
import datetime
import difflib
import hashlib
import io
import os
import re
import tomllib
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import pydantic

from exercises import ENGINE
from exercises.difficulty import HARDEST
from exercises.errors import QdotError
from exercises.families import Family
from exercises.families.own import own_family
from exercises.generate import check_questions, family_named, generate, questions_of, student_problem_id
from exercises.problem import Problem, ProblemId

SECRET_FILE = "secret.txt"  # noqa: S105 - a file's name
SECRET_VARIABLE = "QDOT_SECRET"  # noqa: S105 - a variable's name


class ProblemEntry(pydantic.BaseModel):
    """One [[problem]] of assignment.toml."""

    model_config = pydantic.ConfigDict(extra="forbid", strict=True)
    family: str | None = None
    robot: str | None = None
    questions: list[str] = pydantic.Field(default_factory=list)
    points: list[float] | None = None
    difficulty: int | list[int] | None = None


class AssignmentFile(pydantic.BaseModel):
    """assignment.toml as it stands."""

    model_config = pydantic.ConfigDict(extra="forbid", strict=True)
    title: str = pydantic.Field(min_length=1)
    key: str = pydantic.Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$")
    due: datetime.datetime | None = None
    feedback: Literal["verdicts", "solutions"] = "verdicts"
    problem: list[ProblemEntry] = pydantic.Field(min_length=1)


@dataclass(frozen=True)
class Student:
    """A line of the roster; `others` are its further columns as they stand."""

    id: str
    name: str = ""
    email: str = ""
    others: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Slot:
    """A place in the assignment: every student has a problem of this family with these questions here.

    `band` bounds the difficulty; `robot` is a digest of the file of an instructor's own robot, empty for a family.
    """

    name: str
    family: Family
    questions: tuple[str, ...]
    points: tuple[float, ...] | None
    band: tuple[int, int] | None = None
    robot: str = ""

    def identity(self, secret: str, student: str) -> ProblemId:
        """Return the identity of a student's problem in this place."""
        return student_problem_id(secret, student, self.name, self.family.name, self.questions, self.band)

    def problem(self, secret: str, student: str) -> Problem:
        """Return a student's problem in this place."""
        return generate(self.identity(secret, student), self.points, self.family)


@dataclass(frozen=True)
class Assignment:
    """An assignment, its roster and its secret."""

    folder: Path
    title: str
    key: str
    slots: tuple[Slot, ...]
    roster: tuple[Student, ...]
    secret: str
    due: datetime.datetime | None = None
    feedback: str = "verdicts"

    def problems(self, student: str) -> list[tuple[str, Problem]]:
        """Return the student's problems, each with the name of its slot; the same at every call, on every machine."""
        return [(slot.name, slot.problem(self.secret, student)) for slot in self.slots]

    @property
    def digest(self) -> str:
        """A short text that changes whenever the problems do (engine, secret, key, families, questions)."""
        slots = [(slot.name, slot.family.name, slot.questions, slot.band, slot.robot) for slot in self.slots]
        return _short_hash(repr((ENGINE, self.secret, self.key, slots)))

    @property
    def edition(self) -> str:
        """A short text that changes whenever the notebooks do: with the digest, the title or the points."""
        return _short_hash(repr((self.digest, self.title, [slot.points for slot in self.slots])))


def _short_hash(content: str) -> str:
    return hashlib.sha256(content.encode()).hexdigest()[:16]


def load_assignment(folder: Path) -> Assignment:
    """Read and check an assignment folder. Raises QdotError with the file and the line or key."""
    if not folder.is_dir():
        raise QdotError(f"{folder} is not a folder; 'qdot init {folder}' makes one")
    path = folder / "assignment.toml"
    content = _assignment_file(path)
    slots = tuple(_slot(path, number, entry) for number, entry in enumerate(content.problem, 1))
    return Assignment(
        folder, content.title, content.key, slots, read_roster(folder / "roster.csv"), read_secret(folder),
        content.due, content.feedback,
    )  # fmt: skip


def _read_text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise QdotError(f"{path} is missing; 'qdot init' makes a folder that has one") from None
    except UnicodeDecodeError as error:
        raise QdotError(f"{path}: byte {error.start} is not UTF-8 text; save the file as UTF-8") from None
    except OSError as error:
        raise QdotError(f"{path} can't be read: {error.strerror}") from None


def _assignment_file(path: Path) -> AssignmentFile:
    text = _read_text(path)
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        hint = "; put text in quotes" if "invalid value" in str(error).lower() else ""
        raise QdotError(f"{path}: {error}{hint}") from None
    try:
        return AssignmentFile.model_validate(content)
    except pydantic.ValidationError as error:
        raise QdotError(f"{path}: {_first_problem(error, text)}") from None


def _first_problem(error: pydantic.ValidationError, text: str) -> str:
    """Return one thing that is wrong as a sentence with its line and key; a misspelt key before those that it lacks."""
    first = min(error.errors(), key=lambda found: found["type"] != "extra_forbidden")
    location, kind = first["loc"], first["type"]
    key = ".".join(str(part + 1) if isinstance(part, int) else str(part) for part in location)
    where = _line_of(text, location)
    if kind == "extra_forbidden":
        model = ProblemEntry if location[0] == "problem" else AssignmentFile
        known = list(model.model_fields)
        close = difflib.get_close_matches(str(location[-1]), known, n=1)
        hint = f" (did you mean {close[0]!r}?)" if close else ""
        return f"{where}unknown key {key!r}{hint}; known: {', '.join(known)}"
    if kind == "missing":
        return f"{where}the key {key!r} is missing"
    if key == "key":
        return (
            f"{where}key = {first['input']!r}: the file name of the notebooks, letters, digits, '.', '_' and '-' only"
        )
    return f"{where}{key} = {first['input']!r}: {first['msg'].lower()}"


def _line_of(text: str, location: Sequence[int | str]) -> str:
    """Return "line N: " for a key, found by counting [[problem]] headers; nothing where the key isn't in the text."""
    lines = text.splitlines()
    start = 0
    if location and location[0] == "problem" and len(location) > 1 and isinstance(location[1], int):
        headers = [i for i, line in enumerate(lines) if re.match(r"\s*\[\[\s*problem\s*\]\]", line)]
        if location[1] < len(headers):
            start = headers[location[1]]
    names = [str(part) for part in location if isinstance(part, str)]
    for number in range(start, len(lines)):
        if names and re.match(rf"""\s*["']?{re.escape(names[-1])}["']?\s*=""", lines[number]):
            return f"line {number + 1}: "
    return f"line {start + 1}: " if start else ""


def _slot(path: Path, number: int, entry: ProblemEntry) -> Slot:
    where = f"{path}: problem {number}"
    try:
        family, robot = _family(path.parent, entry)
        band = _band(entry.difficulty)
        if family.varied and not entry.questions:
            raise QdotError(f"{family.name} draws arms of many kinds; name the questions that all are asked")
        questions = tuple(entry.questions) or questions_of(family)
        check_questions(family, questions, band)
    except QdotError as error:
        raise QdotError(f"{where}: {error}") from None
    if not questions:
        raise QdotError(f"{where}: no question can be asked of {family.name}")
    if entry.points is not None and len(entry.points) != len(questions):
        raise QdotError(f"{where}: points has {len(entry.points)} numbers for {len(questions)} questions")
    if entry.points is not None and any(not 0 < points < 1e6 for points in entry.points):
        raise QdotError(f"{where}: points = {entry.points}; each must be positive")
    points = None if entry.points is None else tuple(entry.points)
    return Slot(f"p{number}", family, questions, points, band, robot)


def _family(folder: Path, entry: ProblemEntry) -> tuple[Family, str]:
    """Return the family of an entry, and the digest of the file that it comes from (empty for a registered one)."""
    if (entry.family is None) == (entry.robot is None):
        raise QdotError('each [[problem]] has either family = "planar-2r" or robot = "my-arm.toml"')
    if entry.family is not None:
        return family_named(entry.family), ""
    path = folder / str(entry.robot)
    if not path.is_file():
        raise QdotError(f"robot = {entry.robot!r}: there is no file {path}")
    return own_family(path), _short_hash(path.read_text(encoding="utf-8", errors="replace"))


def _band(difficulty: int | list[int] | None) -> tuple[int, int] | None:
    """Return the least and greatest step of difficulty."""
    if difficulty is None:
        return None
    ends = [difficulty, difficulty] if isinstance(difficulty, int) else difficulty
    if len(ends) != 2 or not 0 <= ends[0] <= ends[1] <= HARDEST:
        raise QdotError(f"difficulty = {difficulty}; it is a step from 0 to {HARDEST}, or a range, as in [1, 2]")
    return ends[0], ends[1]


def read_roster(path: Path) -> tuple[Student, ...]:
    """Read roster.csv: the first column is `student`; others may follow. Commas or semicolons separate."""
    text = _read_text(path)
    header_line = text.partition("\n")[0]
    separator = ";" if ";" in header_line and "," not in header_line else ","  # as many a spreadsheet saves it
    rows = list(csv.reader(io.StringIO(text), delimiter=separator))
    if not rows:
        raise QdotError(f"{path} is empty; its first line is 'student,name,email', then a line a student")
    if not rows[0] or rows[0][0].strip().lower() != "student":
        found = rows[0][0] if rows[0] else ""
        raise QdotError(f"{path}: line 1: the first column is {found!r}, and must be 'student' (then name, email, …)")
    header = [name.strip().lower() for name in rows[0]]
    students: list[Student] = []
    lines: dict[str, int] = {}
    for number, row in enumerate(rows[1:], 2):
        if not any(cell.strip() for cell in row):
            continue
        identifier = unicodedata.normalize("NFC", row[0].strip())
        _check_identifier(path, number, identifier)
        folded = identifier.casefold()  # two folders that differ in case only are one on many disks
        if folded in lines:
            raise QdotError(f"{path}: line {number}: student {identifier!r} is already on line {lines[folded]}")
        lines[folded] = number
        cells = dict(zip(header, row, strict=False))
        others = tuple((k, v) for k, v in cells.items() if k not in ("student", "name", "email"))
        students.append(Student(identifier, cells.get("name", "").strip(), cells.get("email", "").strip(), others))
    if not students:
        raise QdotError(f"{path}: no student is listed; write one a line below the header")
    return tuple(students)


def _check_identifier(path: Path, line: int, identifier: str) -> None:
    bad = [ch for ch in identifier if ch in '/\\:*?"<>|' or unicodedata.category(ch)[0] == "C"]
    if not identifier or bad or identifier.startswith((".", "-")) or len(identifier) > 100:
        raise QdotError(
            f"{path}: line {line}: {identifier!r} can't be a student's identifier; it names folders, so it is not "
            "empty, does not start with '.' or '-', and has no / \\ : * ? \" < > |"
        )


def read_secret(folder: Path) -> str:
    """Return the assignment's secret, from its file or from the environment."""
    path = folder / SECRET_FILE
    given = os.environ.get(SECRET_VARIABLE, "").strip()
    if not path.exists() and given:
        secret, source = given, f"${SECRET_VARIABLE}"
    elif path.exists():
        secret, source = _read_text(path).strip(), str(path)
    else:
        raise QdotError(
            f"{path} is missing: without the secret the students' problems can't be regenerated. Put back the file "
            f"that 'qdot init' made (keep a copy of it), or set {SECRET_VARIABLE}"
        )
    if len(secret) < 16:
        raise QdotError(f"{source} holds {len(secret)} characters; a secret has at least 16")
    return secret
