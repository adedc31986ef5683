"""What was handed in: found in the folder of submissions, read, and told apart from what can't be graded."""

import contextlib
import csv
import datetime
import hashlib
import os
import stat
import zipfile
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from qdot.exercises.common.console import note
from qdot.exercises.common.errors import QdotError
from qdot.grader.submissions.archives import is_archive, listed, read_packed, unpacked
from qdot.grader.submissions.cells import LARGEST, SCRIPTS, TEXTS, Cell, OverLimit, Unreadable, plain, read_cells
from qdot.grader.submissions.layouts import Handed, handed_in, only_folder, surely
from qdot.grader.submissions.roster import Match, Roster

if TYPE_CHECKING:  # loaded where there is one: a student's `qdot check` has none
    from qdot.exercises.assignment.assignment import Assignment, Student

DEEPEST = 5
"""Folders in folders in which a class is looked for, where each is alone in the one around it."""
MOST_FILES, MOST_ATTEMPTS = 20_000, 50
"""Files that one student may hand in, and those of them that are read."""
NOT_FETCHED = ".not-fetched.csv"
"""A table in the folder of submissions, student and why, of those whose work could not be fetched into it.

They have no mark, and not the zero of who handed in nothing. No layout takes a hidden file for a submission.
"""


@dataclass(frozen=True)
class Submission:
    """A notebook as handed in: its cells, what its metadata claim, and what is to be said of how it was read.

    `received_from` is what tells the time: a platform, or "file". `late` is a platform's own mark, where it makes one.
    `modules` are the files of Python beside it, which its cells may import.
    """

    file: Path
    sha256: str
    received: datetime.datetime
    cells: tuple[Cell, ...]
    claims: Mapping[str, Any]
    notes: tuple[str, ...] = ()
    foreign: tuple[str, ...] = ()
    received_from: str = "file"
    late: bool | None = None
    modules: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Found:
    """The files of one student, the one to grade first; `obstacle` is why none of them can be graded.

    It may be that they are more than a limit allows. `failure` is what went wrong in qdot, or on the machine, while
    they were looked for.
    """

    files: tuple[Path, ...]
    notes: tuple[str, ...] = ()
    obstacle: str = ""
    platform: str = ""
    received: datetime.datetime | None = None
    late: bool | None = None
    failure: str = ""
    over_limit: bool = False


@dataclass(frozen=True)
class Looked:
    """What lies in the folder of submissions: by student, and what nobody on the roster has handed in for sure."""

    found: dict[str, Found]
    strangers: list[str] = field(default_factory=list)
    unsure: list[str] = field(default_factory=list)


def find_submissions(assignment: "Assignment", root: Path) -> Looked:
    """Return what each student handed in, what belongs to nobody on the roster, and what may be of several.

    The layouts are those of `layouts`. Of several files, the notebook with the assignment's file name goes first, else
    the one whose metadata name the assignment, else the first by name. Raises QdotError where `root` is no folder.
    """
    if not root.exists():
        raise QdotError(f"{root} does not exist; put what was handed in there, as STUDENT/*.ipynb or STUDENT.ipynb")
    if not root.is_dir():
        raise QdotError(f"{root} is not a folder of submissions; it holds STUDENT/*.ipynb or STUDENT.ipynb")
    gathered, looked = defaultdict[str, _Gathered](_Gathered), Looked({})
    root, owners = _owners(assignment.roster, root)
    for handed in handed_in(root):
        name = handed.path.name
        try:
            owner = owners(handed)
        except Exception as error:  # one folder's trouble is nobody else's
            looked.unsure.append(f"{plain(name)}: whose it is can't be found out ({error}); not graded")
            continue
        if len(owner.students) == 1 and not owner.why:
            gathered[owner.students[0]].add(handed.path, handed.platform, handed.received, handed.late)
        elif surely(handed.path.is_dir) or handed.platform or _kind(name) < _LAST_KIND:  # no list of grades, no README
            _doubt(handed.path, owner, gathered, looked)
    for student, own in gathered.items():
        files = own.found(assignment.key)
        if files is not None:
            looked.found[student] = files
    looked.found.update(_not_fetched(root / NOT_FETCHED))
    return looked


def _owners(students: "Sequence[Student]", root: Path) -> tuple[Path, Callable[[Handed], Match]]:
    """Return the folder in which submissions are, `root` or one that is alone in it, and what says whose one is."""
    roster = Roster(students)

    def owner_of(handed: Handed) -> Match:
        path = handed.path
        name = path.name if surely(path.is_dir) else path.stem
        return roster.of_identifier(name) or roster.owner(replace(handed, ids=(*handed.ids, name)))

    inner, depth = root, 0
    while not any(owner_of(handed).students for handed in handed_in(inner)):  # else it is a student's folder
        alone = only_folder(inner)
        if alone is None or depth >= DEEPEST:
            return root, owner_of
        inner, depth = alone, depth + 1
    return inner, owner_of


def handed_in_by(students: "Sequence[Student]", root: Path, student: str) -> tuple[list[Path], list[Path]]:
    """Return the files and folders that one of these students has handed in, and those that may be theirs or not."""
    inner, owners = _owners(students, root)
    sure, unsure = list[Path](), list[Path]()
    for handed in handed_in(inner):
        with contextlib.suppress(Exception):  # as where a class is looked for: it is of nobody
            owner = owners(handed)
            if student in owner.students:
                (sure if len(owner.students) == 1 and not owner.why else unsure).append(handed.path)
    return sure, unsure


def _doubt(path: Path, owner: Match, gathered: dict[str, "_Gathered"], looked: Looked) -> None:
    """Tell of what may be of several students, or is of none."""
    if not owner.students:
        looked.strangers.append(plain(path.name))
        return
    looked.unsure.append(f"{plain(path.name)} may be of {' or '.join(owner.students)}: {owner.why}; not graded")
    for student in owner.students:
        gathered[student].doubtful.append(path)


def _not_fetched(table: Path) -> dict[str, Found]:
    """Return who could not be reached, as whoever has fetched the others says. Raises QdotError."""
    if not table.exists():
        return {}
    try:
        rows = list(csv.DictReader(table.read_text(encoding="utf-8").splitlines()))
        return {
            row["student"]: Found((), failure=f"it could not be fetched: {row['why'] or 'why is not said'}")
            for row in rows
        }
    except (OSError, ValueError, KeyError, csv.Error):
        raise QdotError(
            f"{table} is to be a table with the columns student and why; remove it if none is meant"
        ) from None


def files_of_one(path: Path, key: str, platform: str, received: datetime.datetime | None) -> Found | None:
    """Return what is in a folder, or a file, that is known to be of one student; None where there is nothing."""
    gathered = _Gathered()
    gathered.add(path, platform, received, None)
    return gathered.found(key)


@contextlib.contextmanager
def opened(submissions: Path) -> Iterator[Path]:
    """Yield the folder of submissions; a platform's zip is unpacked while the block lasts. Raises QdotError."""
    if submissions.is_file() and not zipfile.is_zipfile(submissions) and submissions.suffix.lower() == ".zip":
        raise QdotError(f"{submissions} can't be unpacked: it is damaged, or no zip; download it once more")
    if not submissions.is_file() or not zipfile.is_zipfile(submissions):
        yield submissions
        return
    try:
        with unpacked(submissions) as (folder, left_out):
            for said in left_out:
                note(said)
            yield folder
    except Unreadable as error:
        raise QdotError(str(error)) from None


MAY_BE = (
    "what may be yours was handed in under a name that fits another student, too; it was not graded: "
    "tell your instructor which is yours"
)


class _Gathered:
    """What was found of one student so far."""

    def __init__(self) -> None:
        self.paths: list[Path] = []
        self.files: list[Path] = []
        self.refused: list[Path] = []
        self.doubtful: list[Path] = []
        self.platform = ""
        self.received: datetime.datetime | None = None
        self.late: bool | None = None
        self.failure = ""

    def add(self, path: Path, platform: str, received: datetime.datetime | None, late: bool | None) -> None:
        """Take what lies in a folder, or a file. Of several times of a platform the last counts."""
        self.paths.append(path)
        try:
            for inside in _files_in(path):
                (self.refused if _refusal(inside) else self.files).append(inside)
        except Exception as error:  # it is this student's, and the others are graded
            self.failure = f"looking into {plain(path.name)}: {type(error).__name__}: {error}"
        self.platform = platform or self.platform
        self.received = max((time for time in (self.received, received) if time), default=None)
        self.late = late if self.late is None else self.late or bool(late)

    def found(self, key: str) -> Found | None:
        """Return it with the file to grade first; None where there is nothing."""
        try:
            found = self._found(key)
        except Exception as error:  # as above
            self.failure = self.failure or f"{type(error).__name__}: {error}"
        if self.failure:
            return Found(tuple(self.paths), failure=self.failure)
        if len(self.files) > MOST_FILES:
            said = f"more than {MOST_FILES:,} files were handed in; hand in the notebook alone"
            return Found(tuple(self.files[:1]), (), said, self.platform, self.received, self.late, over_limit=True)
        return found

    def _found(self, key: str) -> Found | None:
        if len(self.files) > MOST_FILES:
            return None
        files = tuple(best_first([_Candidate(path.name, path, _Reader(path)) for path in self.files], key))
        first = self.refused[:3]
        reasons = " and ".join(dict.fromkeys(map(_refusal, first)))
        said = f"{', '.join(plain(path.name) for path in first)}: {reasons}; hand in the file itself" if first else ""
        if files:
            return Found(files, (said,) if said else (), "", self.platform, self.received, self.late)
        if self.refused:
            return Found(tuple(self.refused), (), said, self.platform, self.received, self.late)
        return Found(tuple(self.doubtful), (), MAY_BE) if self.doubtful else None


def _refusal(path: Path) -> str:
    """Return why what lies among submissions is not opened; empty for a file."""
    try:
        kind = path.lstat().st_mode
    except OSError as error:
        return f"it can't be looked at ({error.strerror})"
    if stat.S_ISLNK(kind):
        return "a symbolic link is not followed"
    if stat.S_ISDIR(kind):
        return "a folder that can't be looked into"
    return "" if stat.S_ISREG(kind) else "a pipe, a socket or a device is not read"


def _files_in(path: Path) -> Iterator[Path]:
    """Yield a file, or what is in a folder and its folders; links are yielded, and never followed.

    A folder that can't be looked into is yielded itself.
    """
    if path.is_symlink() or not surely(path.is_dir):
        yield path
        return
    count = 0
    closed, places = list[Path](), [path]
    while places:  # os.walk calls itself for every folder in a folder
        place = places.pop()
        try:
            with os.scandir(place) as entries:
                inside = sorted((one.name, one.is_dir(follow_symlinks=False)) for one in entries)
        except OSError:
            closed.append(place)
            continue
        inside = [(name, is_folder) for name, is_folder in inside if not _is_hidden(name)]
        for name in (name for name, is_folder in inside if not is_folder):
            yield place / name
            count += 1
            if count > MOST_FILES:
                return
        places += [place / name for name, is_folder in reversed(inside) if is_folder]
    yield from closed


def _is_hidden(name: str) -> bool:
    """Tell whether a name is one that systems make beside files: .ipynb_checkpoints, __MACOSX, ._name, Thumbs.db."""
    return (name.startswith(".") and name != "..") or name in ("__MACOSX", "Thumbs.db", "desktop.ini", "__pycache__")


# --- which of several files ---


@dataclass(frozen=True)
class _Candidate:
    """A file that may be the one to grade: its name, what stands for it, and its text, if it comes to that."""

    name: str
    what: Any
    read: Callable[[], bytes]


@dataclass(frozen=True)
class _Reader:
    """Reads a file of a reasonable size."""

    path: Path

    def __call__(self) -> bytes:
        try:
            return self.path.read_bytes() if self.path.stat().st_size <= LARGEST // 4 else b""
        except OSError:
            return b""


_KINDS = ((".ipynb",), (".ipynb.txt", ".ipynb.json", ".json"), (".zip", ".tgz", ".tar.gz", ".tar"), (*SCRIPTS, *TEXTS))
_LAST_KIND = len(_KINDS)


def _kind(name: str) -> int:
    """Return how likely a file is the notebook, by its name; smaller is likelier."""
    lower = name.lower()
    known = next((kind for kind, endings in enumerate(_KINDS) if lower.endswith(endings)), None)
    if known is not None:
        return known
    return (
        _LAST_KIND
        if lower.endswith((".txt", ".html", ".htm", ".pdf", ".docx", ".doc", ".odt", ".rtf"))
        else _LAST_KIND + 1
    )


def _depth(name: str) -> int:
    """Return how many folders a name in an archive leads into; one that leads out of it is deepest."""
    parts = PurePosixPath(name.replace("\\", "/")).parts
    return 1000 if ".." in parts else len(parts)


def best_first(candidates: Sequence[_Candidate], key: str) -> list[Any]:
    """Return what stands for the candidates, the one to grade first."""
    mark = f'"assignment": "{key}"'.encode()
    is_one = len(candidates) == 1

    def rank(one: _Candidate) -> tuple[int, bool, bool, int, str]:
        named = is_one or _kind(one.name) > 1 or mark in one.read()
        return _kind(one.name), PurePosixPath(one.name).name != f"{key}.ipynb", not named, _depth(one.name), one.name

    return [one.what for one in sorted(candidates, key=rank)]


def rivals(files: Sequence[Path]) -> tuple[tuple[Path, ...], str]:
    """Return the files that may be notebooks to grade, of those of a student, which come best first; and a note.

    Of more than MOST_ATTEMPTS, these are the first and the newest, which the note says.
    """
    kinds = [_kind(path.name) for path in files]
    likely = [path for path, kind in zip(files, kinds, strict=True) if kind <= max(2, kinds[0]) and kind < _LAST_KIND]
    if len(likely) > MOST_ATTEMPTS:
        newest = {*likely[:1], *sorted(likely[1:], key=_changed, reverse=True)[: MOST_ATTEMPTS - 1]}
        note = (
            f"{len(likely)} notebooks were handed in, and at most {MOST_ATTEMPTS} are read: {likely[0].name} and the "
            f"{MOST_ATTEMPTS - 1} newest of the others"
        )
        return tuple(path for path in likely if path in newest), note
    return tuple(likely) or tuple(files[:1]), ""


def _changed(path: Path) -> int:
    """Return the second in which a file was changed, as far as that is known."""
    try:
        return int(path.lstat().st_mtime)
    except OSError:
        return 0


# --- reading ---


def beside(path: Path) -> tuple[Path, ...]:
    """Return the files of Python in a notebook's folder, where all that is there is of the same student; no links."""
    try:
        return tuple(sorted(each for each in path.parent.glob("*.py") if not _refusal(each)))
    except OSError:
        return ()


def read_submission(path: Path, key: str = "", beside: Sequence[Path] = ()) -> Submission:
    """Read a notebook, or what stands for one, with the files `beside` it that it may import, in its folder or archive.

    Raises Unreadable with a reason for whatever can't be graded.
    """
    said = plain(path.name)
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise Unreadable(f"{said} is no file")
        data = path.read_bytes() if status.st_size <= LARGEST else None
    except OSError as error:
        raise Unreadable(f"{said} can't be read: {error.strerror}") from None
    if data is None:
        raise OverLimit(f"{said} is larger than {LARGEST // 1_000_000} MB; clear its outputs and hand it in again")
    notes, digest = [], hashlib.sha256(data).hexdigest()
    name = path.name
    near: list[_Near] = [(one.name, _Reader(one)) for one in beside if one.parent == path.parent and one != path]
    if is_archive(data[:512]):
        name, data, note, near = _out_of_archive(path, key)
        notes.append(note)
    content = read_cells(name, data)
    if content.note:
        notes.append(f"{plain(name)} is no .ipynb file: {content.note}")
    return Submission(
        path, digest, time_of(status), content.cells, content.claims, tuple(notes), content.foreign,
        modules=_modules(near),
    )  # fmt: skip


MOST_MODULES, LARGEST_MODULE = 20, 200_000
"""Files of Python that a notebook may have beside it, and bytes of each."""


_Near = tuple[str, Callable[[], bytes]]
"""A file beside a notebook: its name, and what reads it."""


def _modules(files: Sequence[_Near]) -> dict[str, str]:
    """Return those files that can be imported, by name, each with its text."""
    named = [(name, read) for name, read in files if name.endswith(".py") and name[:-3].isidentifier()]
    read_in = [(name, read()) for name, read in named[:MOST_MODULES]]
    return {name: data.decode("utf-8-sig", "replace") for name, data in read_in if len(data) <= LARGEST_MODULE}


LAST_TIME = 253_370_764_800
"""The year 9999 in seconds; a file may say a later one."""


def time_of(status: os.stat_result) -> datetime.datetime:
    """Return a file's time, or the one next to it that has a date."""
    return datetime.datetime.fromtimestamp(min(max(int(status.st_mtime), 0), LAST_TIME), datetime.UTC)


def _out_of_archive(path: Path, key: str) -> tuple[str, bytes, str, list["_Near"]]:
    """Return the name and the text of the notebook in an archive, what is to be said of it, and what lies beside it.

    Raises Unreadable.
    """
    files = [packed for packed in listed(path) if not any(map(_is_hidden, PurePosixPath(packed.name).parts))]
    said = plain(path.name)
    fit = [packed for packed in files if _kind(packed.name) in (0, 1, 3)]
    if not fit:
        nested = any(_kind(packed.name) == 2 for packed in files)
        why = "only another archive, which is not opened" if nested else "no notebook"
        raise Unreadable(f"{said} has {why} in it; hand in the notebook itself, the file that ends in .ipynb")

    def reader(name: str, size: int) -> Callable[[], bytes]:
        def read() -> bytes:
            try:
                return read_packed(path, name) if size <= LARGEST // 4 else b""
            except Unreadable:
                return b""  # said when it is the one to grade

        return read

    shallow = sorted(fit, key=lambda packed: (_kind(packed.name), _depth(packed.name), packed.name))[:20]
    ordered = best_first([_Candidate(one.name, one, reader(one.name, one.size)) for one in shallow], key)
    if ordered[0].size > LARGEST:
        raise OverLimit(
            f"{plain(ordered[0].name)} in {said} is larger than {LARGEST // 1_000_000} MB; clear its outputs"
        )
    note = f"{said} is an archive; {plain(ordered[0].name)} in it was read"
    others = [plain(one.name) for one in ordered[1:] if _kind(one.name) <= _kind(ordered[0].name)]
    note += f", not {', '.join(others[:5])}" if others else ""
    chosen = PurePosixPath(ordered[0].name)
    near = [
        (PurePosixPath(one.name).name, reader(one.name, one.size))
        for one in files
        if PurePosixPath(one.name).parent == chosen.parent and one != ordered[0]
    ]
    return chosen.name, read_packed(path, ordered[0].name), note, near


# --- what its metadata say ---


def wrong_assignment(submission: Submission, assignment: "Assignment") -> str | None:
    """Return the reason why a notebook is not of this assignment, if its metadata say so."""
    claimed = submission.claims.get("assignment")
    if isinstance(claimed, str) and claimed != assignment.key:
        return f"this notebook belongs to the assignment {claimed[:80]!r}, and {assignment.key!r} is graded here"
    return None


OTHER_EDITION = "made from another assignment.toml, redrawn.csv or secret than what is graded with"


@dataclass(frozen=True)
class Note:
    """Something odd about a submission, in words for the staff and in words for the student (who may see none)."""

    staff: str
    student: str = ""


def oddities(submission: Submission, assignment: "Assignment", student: str) -> list[Note]:
    """Return what the metadata make odd; they decide nothing: the problems graded are this student's all the same."""
    claims, notes = submission.claims, []
    claimed = claims.get("student")
    if isinstance(claimed, str) and claimed != student:
        said = (
            "this notebook was handed out to somebody else; it was graded against your own problems, and no answer in "
            "it earns points for following from a wrong one"
        )
        notes.append(Note(f"the notebook was handed out to {claimed[:80]!r}", said))
    if claims.get("kind") == "solution":
        notes.append(Note("the notebook is the staff's, with the solutions"))
    digest = claims.get("digest")
    if isinstance(digest, str) and digest not in (assignment.digest_of(student), assignment.digest_of(str(claimed))):
        said = "this notebook was made from another version of the assignment; ask your instructor for the right one"
        notes.append(Note(OTHER_EDITION, said))
    asked = {f"{slot.name}.{question}" for slot in assignment.slots for question in slot.questions}
    unknown = sorted({cell.part for cell in submission.cells if cell.part is not None} - asked)
    if unknown:
        named = ", ".join(plain(part) for part in unknown[:3]) + (", …" if len(unknown) > 3 else "")
        notes.append(Note(f"cells are marked as answers to what is not asked: {named}"))
    if submission.foreign:
        notes.append(
            Note(f"its cells' metadata were changed, which decides nothing: {', '.join(submission.foreign[:5])}")
        )
    if submission.late:
        notes.append(Note("the platform has marked it as late"))
    return notes
