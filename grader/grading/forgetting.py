"""All that an assignment's folder has of one student: found, told, and removed for good (`qdot forget`).

What only the student has (notebooks, pages, results) is removed; of tables about the class, the student's lines are.
The roster's line goes last: what was stopped is there to be found again, and the same command ends it.
"""

import contextlib
import hashlib
import re
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from qdot.exercises.assignment.assignment import Student, read_roster, roster_table
from qdot.exercises.assignment.gradebook import identifier_of
from qdot.exercises.assignment.redrawn import REDRAWN
from qdot.exercises.assignment.store import FOLDER as STORE
from qdot.exercises.common.errors import QdotError, unknown
from qdot.exercises.common.files import IS_POSIX, write_atomically
from qdot.exercises.common.input_file import read_table, remove_rows
from qdot.exercises.common.json_form import from_json
from qdot.grader.grading.batch import alone, cache_in, kept_path
from qdot.grader.grading.overrides import OVERRIDES
from qdot.grader.sandbox.contained import folders
from qdot.grader.submissions.submission import NOT_FETCHED, find_paths_of_student

ROSTER = "roster.csv"
ASIDE = ".forgetting-"
"""How the folder begins in which everything is put before it is removed."""
WHAT = {
    "submitted": "what was handed in", "released": "the notebook that was handed out",
    "solutions": "the same with solutions", "certificates": "certificates of the problems",
    "graded/feedback": "feedback", "graded/history": "what earlier runs gave",
    "graded/.cache": "what was kept to grade no second time", "exports": "what was exported",
    "graded/report.html": "the class at a glance; 'qdot report' makes it anew",
    STORE: "problems that were worked out", ASIDE: "left by a run that was stopped",
}  # fmt: skip
"""What is in the files and folders that have something of a student, by how their names begin."""
HANDED_OUT = ("students", "handout")
"""The folders of an outlet that have one for each student."""
PACKED = (".zip", ".mbz", ".xlsx", ".tar", ".gz", ".tgz", ".pdf")
"""What is not looked into for a name."""
LARGEST = 200_000_000
"""Bytes of a file that is looked through."""


@dataclass(frozen=True)
class Plan:
    """What becomes of an assignment's folder: `removed` are files and folders, `shorter` tables and their new bytes.

    `left` is what may have something of the student and stays as it is, each with why.
    """

    folder: Path
    student: Student
    removed: tuple[Path, ...]
    shorter: Mapping[Path, bytes]
    left: tuple[tuple[str, str], ...]

    @property
    def is_empty(self) -> bool:
        """Whether the folder has nothing of the student."""
        return not (self.removed or self.shorter)


@dataclass(frozen=True)
class _ResultOfStudent:
    """Whose a line of results.jsonl is, whatever else any version of qdot has written there."""

    student: str


@dataclass(frozen=True)
class _Notebook:
    """A notebook, by its digest."""

    sha256: str


@dataclass(frozen=True)
class _ResultOfNotebook(_ResultOfStudent):
    """The same of a line that names a notebook."""

    submission: _Notebook


@dataclass(frozen=True)
class _KeptMark:
    """A file of graded/.cache, as far as it names a notebook."""

    marked: _Notebook


def assignments_in(folder: Path) -> list[Path]:
    """Return an assignment's folder, or those in a course's folder. Raises QdotError where there is none."""
    if (folder / "assignment.toml").is_file():
        return [folder]
    inside = sorted(path.parent for path in folder.glob("*/assignment.toml"))
    if not inside:
        raise QdotError(f"{folder} is no assignment's folder, and has none in it; 'qdot init' makes one")
    return inside


def plans(folder: Path, named: str) -> list[Plan]:
    """Return what is to be done in an assignment's folder, or in those of a course. Raises QdotError.

    A student is named by the identifier of the roster, or by the name or the email that one line of it has.
    """
    every = assignments_in(folder)
    rosters = {each: _roster(each) for each in every}
    student = _student([one for roster in rosters.values() for one in roster], named)
    found = [_plan(each, rosters[each], student) for each in every]
    if all(plan.is_empty for plan in found):
        known = sorted({one.id for roster in rosters.values() for one in roster})
        raise QdotError(f"{folder} has nothing of it: {unknown('student', named, known[:50])}")
    return [plan for plan in found if not plan.is_empty]


def _roster(folder: Path) -> Sequence[Student]:
    return read_roster(folder / ROSTER) if (folder / ROSTER).exists() and roster_table(folder / ROSTER) else ()


def _student(everybody: Sequence[Student], named: str) -> Student:
    """Return who is meant; of one who has left the roster, there is no more than the identifier. Raises QdotError."""
    wanted = identifier_of(named)
    for one in everybody:
        if one.id == wanted:
            return one
    by_name = {one.id: one for one in everybody if wanted.casefold() in (one.name.casefold(), one.email.casefold())}
    if len(by_name) > 1:
        raise QdotError(f"{named!r} may be {' or '.join(sorted(by_name))}; give the identifier")
    if by_name:
        return next(iter(by_name.values()))
    if not wanted or {"/", "\\", ".."} & {wanted, *wanted} or wanted.startswith("."):
        raise unknown("student", named, sorted(one.id for one in everybody)[:50])
    return Student(wanted)


def _plan(folder: Path, roster: Sequence[Student], student: Student) -> Plan:
    others = [one.id for one in roster if one.id != student.id]
    sure, unsure = _handed_in(folder, roster, student)
    removed = [*folder.glob(f"{ASIDE}*"), *sure, *_own_files(folder, student.id)]
    shorter = dict(_shorter(folder, student.id))
    if sure or shorter or len(removed) > len(sure) or any(one.id == student.id for one in roster):
        removed += _cache_files(folder, student.id, others)
        removed += [path for path in [folder / "graded" / "report.html"] if path.exists()]
    kept = {path for top in removed for path in (top, *(top.rglob("*") if top.is_dir() else ()))} | set(shorter)
    left = [(_shown(path, folder), "it may be of this student or of another") for path in unsure]
    left += _mentions(folder, student, kept)
    return Plan(folder, student, tuple(dict.fromkeys(removed)), shorter, tuple(left))


def _handed_in(folder: Path, roster: Sequence[Student], student: Student) -> tuple[list[Path], list[Path]]:
    root = folder / "submitted"
    known = [*roster] if any(one.id == student.id for one in roster) else [*roster, student]
    return find_paths_of_student(known, root, student.id) if root.is_dir() else ([], [])


def _own_files(folder: Path, student: str) -> list[Path]:
    """Return the files and folders that are called by a student, and nobody else's."""
    named = [folder / kind / student for kind in ("released", "solutions", "certificates")]
    named += [folder / "graded" / "feedback" / f"{student}.html", folder / "graded" / "history" / f"{student}.jsonl"]
    named.append(folder / STORE / "problems" / hashlib.sha256(student.encode()).hexdigest()[:24])
    begun = [path for one in named for path in one.parent.glob(".*.tmp") if path.name.startswith(f".{one.name[:40]}.")]
    exported = [
        folder / "exports" / outlet / kind / student for outlet in _names(folder / "exports") for kind in HANDED_OUT
    ]
    sheets = [path for path in sorted((folder / "exports").glob("*/*/*")) if path.stem == student and path.is_file()]
    return [path for path in (*named, *begun, *exported, *sheets) if path.exists() or path.is_symlink()]


def _names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir()) if folder.is_dir() else []


def _cache_files(folder: Path, student: str, others: Sequence[str]) -> list[Path]:
    """Return what was kept of notebooks that were graded, but for those that are known to be others'.

    Its files have no names in them. One is another's if its notebook is in that one's result.
    """
    cache, digests = cache_in(folder), dict(_digests(folder))
    digests_of_student = {digest for digest, who in digests.items() if student in who}
    digests_of_others = {digest for digest, who in digests.items() if who & set(others)} - digests_of_student
    nothing = {kept_path(cache, other, None) for other in others}
    return [
        path
        for path in sorted(cache.glob("*.json"))
        if path not in nothing and _digest_in(path) not in digests_of_others
    ]


def _digests(folder: Path) -> Iterator[tuple[str, set[str]]]:
    """Yield the digest of every notebook that has a result, with the students who handed it in."""
    students: dict[str, set[str]] = {}
    for _, line in _lines(folder / "graded" / "results.jsonl"):
        with contextlib.suppress(ValueError):
            result = from_json(_ResultOfNotebook, line)
            students.setdefault(result.submission.sha256, set()).add(result.student)
    yield from students.items()


def _digest_in(path: Path) -> str:
    try:
        return from_json(_KeptMark, path.read_bytes()).marked.sha256
    except (OSError, ValueError):
        return ""


# --- tables ---


def _shorter(folder: Path, student: str) -> Iterator[tuple[Path, bytes]]:
    """Yield every table that has lines of a student, and its bytes without them; the roster last."""
    results = folder / "graded" / "results.jsonl"
    lines = list(_lines(results))
    kept = [line for line in lines if _owner(line[1]) != student]
    if len(kept) < len(lines):
        yield results, b"".join(raw for raw, _ in kept)
    tables: list[tuple[Path, Callable[[Path], list[tuple[int, dict[str, str]]]]]] = [
        (folder / "graded" / "grades.csv", _table), (folder / "graded" / "costs.csv", _table),
        (folder / OVERRIDES, _table), (folder / REDRAWN, _table),
        (folder / "submitted" / NOT_FETCHED, _table), (folder / ROSTER, roster_table),
    ]  # fmt: skip
    for path, read in tables:
        if path.is_file():
            gone = {number for number, cells in read(path) if identifier_of(cells.get("student", "")) == student}
            if gone:
                yield path, remove_rows(path.read_bytes(), gone)


def _table(path: Path) -> list[tuple[int, dict[str, str]]]:
    return read_table(path, "student", "student")


def _lines(path: Path) -> Iterator[tuple[bytes, str]]:
    """Yield the lines of a file, as they stand and as text; none where there is no file."""
    if path.is_file():
        for raw in path.read_bytes().split(b"\n"):
            if raw:
                yield raw + b"\n", raw.decode("utf-8", "replace")


def _owner(line: str) -> str:
    try:
        return from_json(_ResultOfStudent, line).student
    except ValueError:
        return ""


# --- what stays ---


def _mentions(folder: Path, student: Student, kept: set[Path]) -> list[tuple[str, str]]:
    """Return the other files that name a student, or can't be looked into, and what to do about them."""
    names = [student.email, student.name, *([student.id] if not re.fullmatch(r"\d{0,4}|..?", student.id) else [])]
    asked = [re.escape(name.encode()) for name in names if name.strip()]
    pattern = re.compile(rb"(?<![A-Za-z0-9_])(?:" + b"|".join(asked) + rb")(?![A-Za-z0-9_])", re.I) if asked else None
    found, packed = [], []
    for path in sorted(folder.rglob("*")):
        if path in kept or not path.is_file() or ".git" in path.relative_to(folder).parts:
            continue
        if path.name.lower().endswith(PACKED):
            packed.append(path)
        elif pattern is not None and _has(path, pattern):
            found.append((_shown(path, folder), _advice(path.relative_to(folder))))
    found += [(name, "it can't be looked into; remove it, or make it anew") for name in _by_folder(packed, folder)]
    if any((top / ".git").exists() for top in (folder.resolve(), *folder.resolve().parents)):
        found.append((".git", "git keeps whatever was committed"))
    return found


def _by_folder(paths: Iterable[Path], top: Path) -> Iterator[str]:
    """Yield the names of files, of which there may be one for each student, a folder with several of them as one."""
    for folder, inside in groupby(sorted(paths), key=lambda path: path.parent):
        first, *others = inside
        yield f"{_shown(folder, top)}/ ({len(others) + 1} files, as {first.name})" if others else _shown(first, top)


def _has(path: Path, pattern: re.Pattern[bytes]) -> bool:
    with contextlib.suppress(OSError):
        return path.stat().st_size <= LARGEST and pattern.search(path.read_bytes()) is not None
    return False


def _advice(path: Path) -> str:
    first = path.parts[0]
    if first == "exports":
        return "it names this student; 'qdot export' makes it anew"
    if first == "submitted":
        return "another student handed it in, and it names this one"
    if path.as_posix() in ("graded/results.jsonl", "graded/grades.csv") or "history" in path.parts:
        return "a result of another student names this one"
    return "it names this student"


def _shown(path: Path, folder: Path) -> str:
    return path.relative_to(folder).as_posix()


def told(plan: Plan) -> Iterator[str]:
    """Yield what is to be done in an assignment's folder, and what can't be, a line each."""
    who = plan.student.id + (f" ({plan.student.name})" if plan.student.name else "")
    yield f"{plan.folder}: {who}"
    for path in plan.removed:
        shown = _shown(path, plan.folder)
        yield f"  remove   {shown:<44} {_said_of(shown)}".rstrip()
    for path, data in plan.shorter.items():
        count = path.read_bytes().count(b"\n") - data.count(b"\n")
        yield f"  shorten  {_shown(path, plan.folder):<44} {count} {'line' if count == 1 else 'lines'} less"
    for shown, why in plan.left:
        yield f"  stays    {shown:<44} {why}"


def _said_of(shown: str) -> str:
    return next((what for begins, what in WHAT.items() if shown.startswith(begins)), "")


ELSEWHERE = (
    "not in this folder, and not removed: what learning platforms, repositories and mail hold, backups, and copies of "
    "files that were made elsewhere"
)
"""What `qdot forget` can't reach."""


# --- done ---


def carry_out(plan: Plan) -> None:
    """Remove what a plan names: tables are written, everything is put aside, the roster is written, and all is gone.

    Raises QdotError, where grading is going on, or something can't be written or removed; the same command goes on.
    """
    with alone(plan.folder) if (plan.folder / "graded").is_dir() else contextlib.nullcontext():
        for path, data in plan.shorter.items():
            if path.name != ROSTER:
                _write(path, data)
        aside = Path(tempfile.mkdtemp(prefix=ASIDE, dir=plan.folder))
        try:
            for number, path in enumerate(plan.removed):
                path.replace(aside / str(number))
            if (roster := plan.folder / ROSTER) in plan.shorter:
                _write(roster, plan.shorter[roster])
            remove(aside)
        except OSError as error:
            named = error.filename or aside
            raise QdotError(f"{named} can't be removed: {error.strerror}; run the same command again") from None


def _write(path: Path, data: bytes) -> None:
    write_atomically(path, data, path.stat().st_mode & 0o777)


def remove(folder: Path) -> None:
    """Remove a folder with all that students have put into it, also where the system lets nobody in. Raises OSError."""
    if IS_POSIX:
        folders.remove(str(folder))
    else:
        shutil.rmtree(folder)
