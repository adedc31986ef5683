"""Find and remove everything about one student in an assignment's folder (`qdot forget`).

The student's files and the student's lines in tables of the class are removed. The line in the roster is removed last,
so that running the same command again finishes an interrupted run.
"""

import contextlib
import json
import re
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.assignment.assignment import Student, read_roster, read_roster_table
from qdot.exercises.assignment.class_list import normalize_identifier
from qdot.exercises.assignment.handout import INDEX_FILE
from qdot.exercises.assignment.release import ONLINE_FOLDER
from qdot.exercises.assignment.replacements import REPLACEMENTS_FILE
from qdot.exercises.assignment.store import make_store_path
from qdot.exercises.common.errors import QdotError, count_noun, make_name_error
from qdot.exercises.common.files import IS_POSIX, write_atomically
from qdot.exercises.common.input_file import parse_csv_rows, read_table
from qdot.grader.grading.batch import lock_folder
from qdot.grader.grading.overrides import OVERRIDES_FILE
from qdot.grader.sandbox.notebook_process import folder_removal
from qdot.grader.submissions.submission import NOT_FETCHED_FILE, find_paths_of_student

ROSTER_FILE = "roster.csv"
UNSEARCHABLE_ENDINGS = (".zip", ".mbz", ".xlsx", ".tar", ".gz", ".tgz", ".pdf")
"""Endings of compressed files, which are not searched for a student's name."""
MAX_SEARCHED_SIZE = 200_000_000
"""Maximum size in bytes of a file that is searched for a student's name."""


@dataclass(frozen=True)
class ForgettingPlan:
    """The planned changes to an assignment's folder: the paths to remove, and the new contents of tables.

    `mentions` lists other files that name the student or can't be searched, each with advice.
    """

    folder: Path
    student: Student
    removed_paths: tuple[Path, ...]
    new_table_contents: Mapping[Path, bytes]
    mentions: tuple[tuple[str, str], ...]

    def describe(self) -> Iterator[str]:
        """Yield the lines of a description of the plan."""
        name = f" ({self.student.name})" if self.student.name else ""
        yield f"{self.folder}: {self.student.id}{name}"
        for path in self.removed_paths:
            yield f"  remove   {self._get_relative_path(path)}"
        for path, content in self.new_table_contents.items():
            lines = path.read_bytes().count(b"\n") - content.count(b"\n")
            yield f"  shorten  {self._get_relative_path(path)} by {count_noun(lines, 'line')}"
        for path_text, advice in self.mentions:
            yield f"  stays    {path_text}: {advice}"

    def carry_out(self) -> None:
        """Remove the files and shorten the tables. Raises QdotError; after an error, the command can be run again."""
        with lock_folder(self.folder) if (self.folder / "graded").is_dir() else contextlib.nullcontext():
            for path in self.removed_paths:
                try:
                    remove_path(path)
                except OSError as error:
                    name = error.filename or path
                    raise QdotError(f"{name} can't be removed: {error.strerror}; run the same command again") from None
            for path, content in self.new_table_contents.items():
                write_atomically(path, content, path.stat().st_mode & 0o777)

    def _get_relative_path(self, path: Path) -> str:
        """Return a path relative to the assignment's folder, as text."""
        return path.relative_to(self.folder).as_posix()


def plan_forgetting(folder: Path, name: str, is_optional: bool = False) -> list[ForgettingPlan]:
    """Return the plan for an assignment's folder, or one plan for each assignment of a course. Raises QdotError.

    `name` is an identifier in the roster, or a name or e-mail address that only one student has. Unless `is_optional`,
    it is an error if the folder has nothing of the student.
    """
    is_assignment = (folder / "assignment.toml").is_file()
    folders = [folder] if is_assignment else sorted(path.parent for path in folder.glob("*/assignment.toml"))
    if not folders:
        raise QdotError(f"{folder} contains no assignment; give the folder of an assignment or of a course")
    rosters = {assignment_folder: _read_roster_if_present(assignment_folder) for assignment_folder in folders}
    student = _find_student([student for roster in rosters.values() for student in roster], name)
    plans = [plan for path, roster in rosters.items() if (plan := _plan_for_assignment(path, roster, student))]
    if not plans and not is_optional:
        identifiers = sorted({student.id for roster in rosters.values() for student in roster})
        raise QdotError(f"{folder}: {make_name_error('student', name, identifiers[:50])}")
    return plans


def _read_roster_if_present(folder: Path) -> Sequence[Student]:
    """Return the students on the roster of an assignment; () if there is no roster or it has no lines."""
    if (folder / ROSTER_FILE).exists() and read_roster_table(folder / ROSTER_FILE):
        return read_roster(folder / ROSTER_FILE)
    return ()


def _find_student(roster: Sequence[Student], name: str) -> Student:
    """Return the student with an identifier, name or e-mail address. Raises QdotError.

    Students who are no longer on the roster can be found only by their identifiers.
    """
    identifier = normalize_identifier(name)
    matching_students = {student.id: student for student in roster if student.id == identifier}
    if not matching_students:
        names = ((student, {student.name.casefold(), student.email.casefold()}) for student in roster)
        matching_students = {student.id: student for student, aliases in names if identifier.casefold() in aliases}
    if len(matching_students) > 1:
        raise QdotError(f"{name!r} fits {' and '.join(sorted(matching_students))}; enter the identifier")
    if matching_students:
        return next(iter(matching_students.values()))
    if not identifier or {"/", "\\"} & set(identifier) or identifier.startswith("."):
        raise make_name_error("student", name, sorted(student.id for student in roster)[:50])
    return Student(identifier)


def _plan_for_assignment(folder: Path, roster: Sequence[Student], student: Student) -> ForgettingPlan | None:
    """Return the plan for one assignment; None if its folder has nothing of the student."""
    is_on_roster = student.id in {listed_student.id for listed_student in roster}
    students = roster if is_on_roster else [*roster, student]
    certain_paths, doubtful_paths = find_paths_of_student(students, folder, student.id)
    removed_paths = [*certain_paths, *_find_files_named_after(folder, student.id)]
    new_contents = dict(_shorten_tables(folder, student.id))
    if not removed_paths and not new_contents:
        return None
    # These are about the whole class, or don't say about whom (the cache); qdot can make them again.
    names = ("graded/.cache", "graded/report.html", "handout", "returned")
    removed_paths += [path for name in names if (path := folder / name).exists()]
    contained_paths = {path for parent in removed_paths if parent.is_dir() for path in parent.rglob("*")}
    advice = "it may belong to this student or to another one"
    mentions = [(path.relative_to(folder).as_posix(), advice) for path in doubtful_paths]
    mentions += _find_mentions(folder, student, {*removed_paths, *contained_paths, *new_contents})
    return ForgettingPlan(folder, student, tuple(dict.fromkeys(removed_paths)), new_contents, tuple(mentions))


def _find_files_named_after(folder: Path, student: str) -> list[Path]:
    """Return the files and folders that are named after a student, with unfinished copies of them."""
    paths = [folder / name / student for name in ("released", "solutions", "certificates")]
    paths += [folder / "graded" / "feedback" / f"{student}.html", folder / "graded" / "history" / f"{student}.jsonl"]
    paths.append(make_store_path(folder, student))
    paths += [path for path in sorted((folder / "exports").glob("*/*/*")) if student in (path.name, path.stem)]
    paths += [unfinished_copy for path in paths for unfinished_copy in path.parent.glob(f".{path.name[:40]}.*.tmp")]
    return [path for path in paths if path.exists() or path.is_symlink()]


def _shorten_tables(folder: Path, student: str) -> Iterator[tuple[Path, bytes]]:
    """Yield pairs of a table that contains lines of a student, and its content without them. The roster comes last."""
    results = folder / "graded" / "results.jsonl"
    if results.is_file():
        lines = results.read_bytes().splitlines(keepends=True)
        other_lines = [line for line in lines if _read_student(line) != student]
        if len(other_lines) < len(lines):
            yield results, b"".join(other_lines)
    names = (
        "graded/grades.csv", f"released/{INDEX_FILE}", "graded/to-mark.csv", "graded/costs.csv", OVERRIDES_FILE,
        REPLACEMENTS_FILE, f"submitted/{NOT_FETCHED_FILE}", ROSTER_FILE,
    )  # fmt: skip
    for path in (folder / name for name in names if (folder / name).is_file()):
        rows = read_roster_table(path) if path.name == ROSTER_FILE else read_table(path, "student", "student")
        matches = (number for number, cells in rows if normalize_identifier(cells.get("student", "")) == student)
        if line_numbers := set(matches):
            yield path, remove_table_rows(path.read_bytes(), line_numbers)


def _read_student(line: bytes) -> str:
    """Return the student whose result a line of results.jsonl contains; "" if the line is damaged."""
    try:
        return str(json.loads(line)["student"])
    except (ValueError, KeyError, TypeError):
        return ""


def remove_table_rows(content: bytes, line_numbers: set[int]) -> bytes:
    r"""Return a table without the rows that begin on the lines `line_numbers`.

    The other bytes don't change. Raises csv.Error.

    >>> remove_table_rows(b'student;name\r\n7;"Ada\r\nA"\r\n8;Bo\r\n', {2})
    b'student;name\r\n8;Bo\r\n'
    """
    encodings = {b"\xff\xfe": "utf-16-le", b"\xfe\xff": "utf-16-be"}
    encoding = encodings.get(content[:2], "latin-1")  # keeps all bytes; in UTF-8, newline bytes occur only in newlines
    lines = re.findall(r"[^\r\n]*(?:\r\n|\r|\n)|[^\r\n]+$", content.decode(encoding))
    row_starts: list[int] = []
    for _ in parse_csv_rows("\n".join(line.rstrip("\r\n") for line in lines), row_starts):
        pass
    row_start, kept_text = 0, ""
    for number, line in enumerate(lines, 1):
        row_start = number if number in row_starts else row_start
        kept_text += "" if row_start in line_numbers else line
    return kept_text.encode(encoding)


def _find_mentions(folder: Path, student: Student, handled_paths: set[Path]) -> Iterator[tuple[str, str]]:
    """Yield each other file that names a student or can't be searched, with advice on what to do with it."""
    names = [student.email, student.name]
    if not re.fullmatch(r"\d{0,4}|..?", student.id):  # a short identifier occurs in many files by chance
        names.append(student.id)
    words = b"|".join(re.escape(name.encode()) for name in names if name.strip())
    pattern = re.compile(rb"(?<![A-Za-z0-9_])(?:" + words + rb")(?![A-Za-z0-9_])", re.IGNORECASE) if words else None
    for path in sorted(folder.rglob("*")):
        parts = path.relative_to(folder).parts
        # The folder of `qdot serve` has a database, from which students are removed separately.
        if path in handled_paths or not path.is_file() or ".git" in parts or parts[0] == ONLINE_FOLDER:
            continue
        path_text = path.relative_to(folder).as_posix()
        if path.name.lower().endswith(UNSEARCHABLE_ENDINGS):
            yield path_text, "qdot can't search it; remove it or make it again"
        elif pattern is not None and _file_contains(path, pattern):
            remedy = "; 'qdot export' makes it again" if path_text.startswith("exports/") else ""
            yield path_text, f"it names this student{remedy}"
    if any((parent / ".git").exists() for parent in (folder.resolve(), *folder.resolve().parents)):
        yield ".git", "Git stores everything that was ever committed"


def _file_contains(path: Path, pattern: re.Pattern[bytes]) -> bool:
    """Return whether a file contains text that matches a pattern; False if the file is very large or unreadable."""
    with contextlib.suppress(OSError):
        return path.stat().st_size <= MAX_SEARCHED_SIZE and pattern.search(path.read_bytes()) is not None
    return False


def remove_path(path: Path) -> None:
    """Remove a file or folder, even if a student has restricted the folder's permissions. Raises OSError."""
    if path.is_symlink() or not path.is_dir():
        path.unlink(missing_ok=True)
    elif IS_POSIX:
        folder_removal.remove_folder(str(path))
    else:
        shutil.rmtree(path)
