"""Find the submissions in a folder, read them, and report those that can't be graded."""

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
from functools import partial
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, TypeVar

from qdot.exercises.common.console import note
from qdot.exercises.common.errors import QdotError, list_some
from qdot.grader.submissions.archives import ArchiveMember, is_archive, list_members, read_member, unpack_temporarily
from qdot.grader.submissions.cells import (
    MARKDOWN_ENDINGS,
    MAX_FILE_BYTES,
    NOTEBOOK_ADVICE,
    SCRIPT_ENDINGS,
    Cell,
    OverLimit,
    Unreadable,
    printable_name,
    read_cells,
)
from qdot.grader.submissions.layouts import SubmittedPath, find_submitted_paths, list_nested_folders, safe_check
from qdot.grader.submissions.roster import PossibleOwners, Roster

if TYPE_CHECKING:  # not imported at run time: a student's `qdot check` needs no assignment
    from qdot.exercises.assignment.assignment import Assignment, Student

MAX_FILES, MAX_NOTEBOOKS = 20_000, 50
"""Maximum number of files that a student may submit, and maximum number of notebooks of theirs that are graded."""
NOT_FETCHED_FILE = ".not-fetched.csv"
"""A table (columns student, why) in the folder of submissions: the students whose work could not be fetched.

They get no mark, rather than zero points for submitting nothing. Layouts ignore this file because it is hidden.
"""


@dataclass(frozen=True)
class Submission:
    """A submitted notebook: its file, when it was received, and its content.

    `qdot_metadata` is its metadata about the assignment. `notes` say what was unusual when it was parsed.
    `time_source` is the source of the time: a platform, or "file". `late` is whether the platform itself flagged it
    as late, None if the platform doesn't say. `modules` are the Python files beside it, which its cells may import.

    If it can't be read, `unreadable_reason` says why, and `over_limit` is whether reading it exceeds a limit.
    """

    file: Path
    received: datetime.datetime
    sha256: str | None = None
    cells: tuple[Cell, ...] = ()
    qdot_metadata: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    unknown_metadata: tuple[str, ...] = ()
    time_source: str = "file"
    late: bool | None = None
    modules: Mapping[str, str] = field(default_factory=dict)
    unreadable_reason: str = ""
    over_limit: bool = False

    def is_for(self, assignment: "Assignment") -> bool:
        """Return whether the name or the metadata of the file name the assignment."""
        return self.file.name == f"{assignment.key}.ipynb" or self.qdot_metadata.get("assignment") == assignment.key

    @property
    def fingerprint(self) -> str:
        """A short text that changes whenever the submission changes."""
        content = (self.sha256, self.unreadable_reason, self.notes, self.late, *sorted(self.modules.items()))
        return repr(content)


@dataclass(frozen=True)
class StudentFiles:
    """The files of a student, in the order in which they are candidates for grading.

    `ungraded_reason` is the reason why none of them can be graded; `over_limit` means that this reason is a limit.
    `failure` is an error of qdot or of the machine during the search.
    """

    files: tuple[Path, ...]
    notes: tuple[str, ...] = ()
    ungraded_reason: str = ""
    platform: str = ""
    received: datetime.datetime | None = None
    late: bool | None = None
    failure: str = ""
    over_limit: bool = False


@dataclass(frozen=True)
class SubmissionFolder:
    """The files in a folder of submissions, by the students to whom they belong.

    `not_on_roster` has the names of files that belong to no student on the roster. `uncertain_owners` has a message
    on each file whose owner is uncertain.
    """

    by_student: dict[str, StudentFiles]
    not_on_roster: list[str] = field(default_factory=list)
    uncertain_owners: list[str] = field(default_factory=list)


def find_submissions(assignment: "Assignment", root: Path) -> SubmissionFolder:
    """Return the files of each student, those of nobody on the roster, and those that fit several students.

    Of a student's files, the notebook with the assignment's file name comes first, else the one whose metadata name the
    assignment, else the first by name. Raises QdotError if `root` is not a folder.
    """
    if not root.exists():
        raise QdotError(f"{root} does not exist; put the submissions there, as STUDENT/*.ipynb or STUDENT.ipynb")
    if not root.is_dir():
        raise QdotError(f"{root} is not a folder; expected a folder with STUDENT/*.ipynb or STUDENT.ipynb")
    folder = SubmissionFolder({})
    certain_paths, doubtful_paths = defaultdict[str, list[SubmittedPath]](list), defaultdict[str, list[Path]](list)
    root, find_owner = _find_root(assignment.roster, root)
    for submitted_path in find_submitted_paths(root):
        name = printable_name(submitted_path.path.name)
        try:
            owner = find_owner(submitted_path)
        except Exception as error:  # a problem with one submission must not affect the others
            folder.uncertain_owners.append(f"{name}: qdot failed to find the owner ({error}); not graded")
            continue
        is_likely = submitted_path.platform or _rank_by_ending(submitted_path.path.name) < _DOCUMENT_RANK
        if owner.is_certain:
            certain_paths[owner.students[0]].append(submitted_path)
        elif is_likely or safe_check(submitted_path.path.is_dir):  # other files, such as a README, are ignored
            for student in owner.students:
                doubtful_paths[student].append(submitted_path.path)
            if owner.students:
                message = f"{name} may belong to {' or '.join(owner.students)}: {owner.reason}; not graded"
                folder.uncertain_owners.append(message)
            else:
                folder.not_on_roster.append(name)
    for student in dict.fromkeys((*certain_paths, *doubtful_paths)):
        if files := _select_files(certain_paths[student], assignment.key, doubtful_paths[student]):
            folder.by_student[student] = files
    folder.by_student.update(_read_not_fetched(root / NOT_FETCHED_FILE))
    return folder


def _find_root(students: "Sequence[Student]", root: Path) -> tuple[Path, Callable[[SubmittedPath], PossibleOwners]]:
    """Return the folder with the submissions and a function that finds owners.

    The folder is `root` or, if nothing in it has an owner, a folder that is the only entry of its parent.
    """
    roster = Roster(students)

    def find_owner(submitted: SubmittedPath) -> PossibleOwners:
        path = submitted.path
        name = path.name if safe_check(path.is_dir) else path.stem
        return roster.find_by_identifier(name) or roster.find_owner(replace(submitted, ids=(*submitted.ids, name)))

    for folder in list_nested_folders(root):
        if any(find_owner(submitted).students for submitted in find_submitted_paths(folder)):
            return folder, find_owner
    return root, find_owner


def find_paths_of_student(students: "Sequence[Student]", root: Path, student: str) -> tuple[list[Path], list[Path]]:
    """Return the files and folders of a student, and those that may or may not be the student's."""
    inner_root, find_owner = _find_root(students, root)
    certain_paths, doubtful_paths = list[Path](), list[Path]()
    for submitted_path in find_submitted_paths(inner_root):
        with contextlib.suppress(Exception):  # as in find_submissions, the submission then has no owner
            owner = find_owner(submitted_path)
            if student in owner.students:
                (certain_paths if owner.is_certain else doubtful_paths).append(submitted_path.path)
    return certain_paths, doubtful_paths


def _read_not_fetched(table: Path) -> dict[str, StudentFiles]:
    """Return the students whose work could not be fetched, from the fetching program's table. Raises QdotError."""
    if not table.exists():
        return {}
    try:
        rows = list(csv.DictReader(table.read_text(encoding="utf-8").splitlines()))
        return {
            row["student"]: StudentFiles((), failure=f"it could not be fetched: {row['why'] or 'unknown reason'}")
            for row in rows
        }
    except (OSError, ValueError, KeyError, csv.Error):
        raise QdotError(f"{table}: expected a table with the columns student and why; fix or remove it") from None


def find_files_of_student(
    path: Path, key: str, platform: str, received: datetime.datetime | None
) -> StudentFiles | None:
    """Return a student's files: the file `path`, or all files in the folder `path`; None if there are none."""
    return _select_files([SubmittedPath(path, platform=platform, received=received)], key)


@contextlib.contextmanager
def open_submissions(submissions: Path) -> Iterator[Path]:
    """Yield the folder of submissions; unpack a platform's zip into a temporary folder. Raises QdotError."""
    if not submissions.is_file() or not zipfile.is_zipfile(submissions):
        if submissions.is_file() and submissions.suffix.lower() == ".zip":
            raise QdotError(f"{submissions} can't be unpacked: it is damaged, or not a zip file; download it again")
        yield submissions
        return
    try:
        with unpack_temporarily(submissions) as (folder, left_out):
            for message in left_out:
                note(message)
            yield folder
    except Unreadable as error:
        raise QdotError(str(error)) from None


UNCERTAIN_OWNER = (
    "a submission that may be yours has a name that also fits another student, so it was not graded. Tell your "
    "instructor which submission is yours"
)


def _select_files(submitted: Sequence[SubmittedPath], key: str, doubtful: Sequence[Path] = ()) -> StudentFiles | None:
    """Return a student's files, beginning with the one to grade; None if there are none.

    If there are several times, the last one is the time of submission. `doubtful` files may be another student's.
    """
    late_flags = [entry.late for entry in submitted if entry.late is not None]
    is_late, received_times = (
        any(late_flags) if late_flags else None,
        [entry.received for entry in submitted if entry.received],
    )
    platform = next((entry.platform for entry in reversed(submitted) if entry.platform), "")
    select = partial(StudentFiles, platform=platform, received=max(received_times, default=None), late=is_late)
    try:
        refusals = {path: _refusal_reason(path) for entry in submitted for path in _list_files(entry.path)}
        files = [path for path, refusal in refusals.items() if not refusal]
        if len(files) > MAX_FILES:
            message = f"you submitted more than {MAX_FILES:,} files; submit only the notebook"
            return select(tuple(files[:1]), (), message, over_limit=True)
        files = sort_candidates(files, lambda path: path.name, _read_small, key)
    except Exception as error:  # the other students have to be graded nonetheless
        paths = tuple(entry.path for entry in submitted)
        return StudentFiles(paths, failure=f"qdot failed to find the notebook: {type(error).__name__}: {error}")
    refused = [path for path, refusal in refusals.items() if refusal]
    reasons = " and ".join(dict.fromkeys(refusals[path] for path in refused[:3]))
    message = f"{', '.join(printable_name(path.name) for path in refused[:3])}: {reasons}; submit the file itself"
    if files:
        return select(tuple(files), (message,) if refused else ())
    if refused:
        return select(tuple(refused), (), message)
    return StudentFiles(tuple(doubtful), (), UNCERTAIN_OWNER) if doubtful else None


def _refusal_reason(path: Path) -> str:
    """Return a phrase that says why a path is not opened; empty for a regular file."""
    try:
        mode = path.lstat().st_mode
    except OSError as error:
        return f"qdot can't open it ({error.strerror})"
    if stat.S_ISLNK(mode):
        return "qdot does not follow symbolic links"
    if stat.S_ISDIR(mode):
        return "qdot can't open this folder"
    return "" if stat.S_ISREG(mode) else "qdot does not read pipes, sockets or devices"


def _list_files(path: Path) -> Iterator[Path]:
    """Yield the path itself if it is a file, or all files below it if it is a folder.

    Links are yielded but not followed. A folder that can't be read is yielded itself.
    """
    if path.is_symlink() or not safe_check(path.is_dir):
        yield path
        return
    count = 0
    unreadable_paths, unvisited_paths = list[Path](), [path]
    while unvisited_paths:  # os.walk is recursive, but folders may be nested very deeply
        folder = unvisited_paths.pop()
        try:
            with os.scandir(folder) as entries:
                contents = sorted((entry.name, entry.is_dir(follow_symlinks=False)) for entry in entries)
        except OSError:
            unreadable_paths.append(folder)
            continue
        contents = [(name, is_folder) for name, is_folder in contents if not _is_hidden(name)]
        for name in (name for name, is_folder in contents if not is_folder):
            yield folder / name
            count += 1
            if count > MAX_FILES:
                return
        unvisited_paths += [folder / name for name, is_folder in reversed(contents) if is_folder]
    yield from unreadable_paths


def _is_hidden(name: str) -> bool:
    """Return whether operating systems or Jupyter make files of this name: .ipynb_checkpoints, __MACOSX, Thumbs.db."""
    return (name.startswith(".") and name != "..") or name in ("__MACOSX", "Thumbs.db", "desktop.ini", "__pycache__")


# --- choosing among several files ---


_ENDINGS_BY_RANK = (
    (".ipynb",),
    (".ipynb.txt", ".ipynb.json", ".json"),
    (".zip", ".tgz", ".tar.gz", ".tar"),
    (*SCRIPT_ENDINGS, *MARKDOWN_ENDINGS),
    (".txt", ".html", ".htm", ".pdf", ".docx", ".doc", ".odt", ".rtf"),
)
_DOCUMENT_RANK = 4
"""The index in `_ENDINGS_BY_RANK` of documents that are not notebooks; files with unknown endings come after it."""


def _rank_by_ending(name: str) -> int:
    """Return how unlikely a file with this name is to be the notebook.

    This is an index in `_ENDINGS_BY_RANK`, 0 for the most likely, or its length if the ending is not in it.
    """
    ranks = (rank for rank, endings in enumerate(_ENDINGS_BY_RANK) if name.lower().endswith(endings))
    return next(ranks, len(_ENDINGS_BY_RANK))


def _archive_depth(name: str) -> int:
    """Return the depth of a path in an archive; a path that leads out of the archive counts as the deepest."""
    parts = PurePosixPath(name.replace("\\", "/")).parts
    return 1000 if ".." in parts else len(parts)


T = TypeVar("T")


def sort_candidates(files: Sequence[T], name_of: Callable[[T], str], read: Callable[[T], bytes], key: str) -> list[T]:
    """Return the files sorted by how likely they are to be the notebook of the assignment `key`, most likely first."""
    marker = f'"assignment": "{key}"'.encode()

    def rank(file: T) -> tuple[int, bool, bool, int, str]:
        name, ending_rank = name_of(file), _rank_by_ending(name_of(file))
        is_unmarked = len(files) > 1 and ending_rank <= 1 and marker not in read(file)
        return ending_rank, PurePosixPath(name).name != f"{key}.ipynb", is_unmarked, _archive_depth(name), name

    return sorted(files, key=rank)


def _read_small(path: Path) -> bytes:
    """Return the content of a file; empty if it is very large or unreadable."""
    try:
        return path.read_bytes() if path.stat().st_size <= MAX_FILE_BYTES // 4 else b""
    except OSError:
        return b""


def _read_small_member(archive: Path, member: ArchiveMember) -> bytes:
    """Return the content of a file in an archive; empty if it is very large or unreadable."""
    try:
        return read_member(archive, member.name) if member.size <= MAX_FILE_BYTES // 4 else b""
    except Unreadable:
        return b""  # the error is reported later if this is the file to grade


def select_likely_notebooks(files: Sequence[Path]) -> tuple[tuple[Path, ...], str]:
    """Return those of a student's sorted files that are likely notebooks, and a note.

    If there are more than `MAX_NOTEBOOKS`, return the first one and the newest of the others; the note says so.
    """
    highest_rank = min(max(2, _rank_by_ending(files[0].name)), _DOCUMENT_RANK - 1)
    likely = [path for path in files if _rank_by_ending(path.name) <= highest_rank]
    if len(likely) <= MAX_NOTEBOOKS:
        return tuple(likely) or tuple(files[:1]), ""
    newest_files = {*likely[:1], *sorted(likely[1:], key=_modification_time, reverse=True)[: MAX_NOTEBOOKS - 1]}
    note = (
        f"{len(likely)} notebooks were submitted, but qdot reads at most {MAX_NOTEBOOKS}: {likely[0].name} and the "
        f"{MAX_NOTEBOOKS - 1} newest of the others"
    )
    return tuple(path for path in likely if path in newest_files), note


def _modification_time(path: Path) -> int:
    """Return the time at which a file was last changed, in seconds since 1970; 0 if it is unknown."""
    try:
        return int(path.lstat().st_mtime)
    except OSError:
        return 0


# --- reading ---


def find_python_files(path: Path) -> tuple[Path, ...]:
    """Return the Python files in a notebook's folder, without links. All of them must be the same student's."""
    try:
        return tuple(sorted(file for file in path.parent.glob("*.py") if not _refusal_reason(file)))
    except OSError:
        return ()


def read_submission(path: Path, key: str = "", siblings: Sequence[Path] = ()) -> Submission:
    """Return a submission from a notebook, script, Markdown file or archive, with the Python files that it may import.

    `siblings` are files that may be in the same folder. Raises Unreadable, with the reason, if it can't be graded.
    """
    label = printable_name(path.name)
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise Unreadable(f"{label} is not a file")
        data = path.read_bytes() if status.st_size <= MAX_FILE_BYTES else None
    except OSError as error:
        raise Unreadable(f"{label} can't be read: {error.strerror}") from None
    if data is None:
        advice = "clear its outputs and submit it again"
        raise OverLimit(f"{label} is larger than {MAX_FILE_BYTES // 1_000_000} MB; {advice}")
    name, notes, digest = path.name, list[str](), hashlib.sha256(data).hexdigest()
    same_folder = [sibling for sibling in siblings if sibling.parent == path.parent and sibling != path]
    neighbours: list[_Neighbour] = [(sibling.name, partial(_read_small, sibling)) for sibling in same_folder]
    if is_archive(data[:512]):
        name, data, note, neighbours = _read_from_archive(path, key)
        notes.append(note)
    content = read_cells(name, data)
    if content.note:
        notes.append(f"{printable_name(name)} is not an .ipynb file: {content.note}")
    described = (content.cells, content.qdot_metadata, tuple(notes), content.unknown_metadata)
    return Submission(path, modification_time(status), digest, *described, modules=_read_modules(neighbours))


MAX_MODULES, MAX_MODULE_BYTES = 20, 200_000
"""Maximum number of Python files that a notebook may import, and maximum size in bytes of each of them."""


_Neighbour = tuple[str, Callable[[], bytes]]
"""A file in the same folder as a notebook: its name, and a function that returns its content."""


def _read_modules(neighbours: Sequence[_Neighbour]) -> dict[str, str]:
    """Return the texts of the files that Python can import, by file name."""
    importable = [
        neighbour for neighbour in neighbours if neighbour[0].endswith(".py") and neighbour[0][:-3].isidentifier()
    ]
    contents = [(name, read_content()) for name, read_content in importable[:MAX_MODULES]]
    return {name: data.decode("utf-8-sig", "replace") for name, data in contents if len(data) <= MAX_MODULE_BYTES}


MAX_TIME = 253_370_764_800
"""The beginning of the year 9999 in seconds since 1970; a file's time may be later than Python's datetime allows."""


def modification_time(status: os.stat_result) -> datetime.datetime:
    """Return the time at which a file was last changed, or the nearest time that datetime can represent."""
    return datetime.datetime.fromtimestamp(min(max(int(status.st_mtime), 0), MAX_TIME), datetime.UTC)


def _read_from_archive(path: Path, key: str) -> tuple[str, bytes, str, list[_Neighbour]]:
    """Return the name and content of the notebook in an archive, a note, and the files in the notebook's folder.

    Raises Unreadable if there is no notebook or it can't be unpacked.
    """
    files = [member for member in list_members(path) if not any(map(_is_hidden, PurePosixPath(member.name).parts))]
    label = printable_name(path.name)
    candidates = [member for member in files if _rank_by_ending(member.name) in (0, 1, 3)]
    if not candidates:
        has_archive = any(_rank_by_ending(member.name) == 2 for member in files)
        content = "contains only another archive, which qdot does not open" if has_archive else "contains no notebook"
        raise Unreadable(f"{label} {content}; {NOTEBOOK_ADVICE}")
    candidates.sort(key=lambda member: (_rank_by_ending(member.name), _archive_depth(member.name), member.name))
    read = partial(_read_small_member, path)
    best_member, *other_members = sort_candidates(candidates[:20], lambda member: member.name, read, key)
    best_name, best_rank, best_path = (
        printable_name(best_member.name),
        _rank_by_ending(best_member.name),
        PurePosixPath(best_member.name),
    )
    if best_member.size > MAX_FILE_BYTES:
        raise OverLimit(f"{best_name} in {label} is larger than {MAX_FILE_BYTES // 1_000_000} MB; clear its outputs")
    note = f"{label} is an archive; qdot graded {best_name} in it"
    names = [printable_name(member.name) for member in other_members if _rank_by_ending(member.name) <= best_rank]
    note += f", not {', '.join(names[:5])}" if names else ""
    member_paths = [(PurePosixPath(member.name), member) for member in files if member != best_member]
    same_folder = [(path.name, member) for path, member in member_paths if path.parent == best_path.parent]
    neighbours: list[_Neighbour] = [(name, partial(read, member)) for name, member in same_folder]
    return best_path.name, read_member(path, best_member.name), note, neighbours


# --- metadata ---


def explain_wrong_assignment(submission: Submission, assignment: "Assignment") -> str | None:
    """Return a message if, according to its metadata, a notebook belongs to another assignment; else None."""
    claimed_key = submission.qdot_metadata.get("assignment")
    if isinstance(claimed_key, str) and claimed_key != assignment.key:
        return f"this notebook belongs to the assignment {claimed_key[:80]!r}, but this is {assignment.key!r}"
    return None


OTHER_VERSION = "the notebook was made from another assignment.toml, redrawn.csv or secret"
"""The staff's note on a notebook of another version of the assignment."""

Notes = list[tuple[str, str]]
"""Notes on a submission: pairs of a text for the staff and a text for the student, which may be empty."""


def find_oddities(submission: Submission, assignment: "Assignment", student: str) -> Notes:
    """Return notes on peculiar metadata. They don't affect marks: the student's own problems are graded in any case."""
    claims, notes = submission.qdot_metadata, Notes()
    claimed_student, digest = claims.get("student"), claims.get("digest")
    if isinstance(claimed_student, str) and claimed_student != student:
        message = (
            "this notebook was released to another student. It was graded against your own problems, and no answer in "
            "it earns points for following from a wrong one"
        )
        notes.append((f"the notebook was released to {claimed_student[:80]!r}", message))
    if claims.get("kind") == "solution":
        notes.append(("this is the staff's notebook with the solutions", ""))
    if isinstance(digest, str) and digest not in (
        assignment.problems_digest_of(student),
        assignment.problems_digest_of(str(claimed_student)),
    ):
        message = "this notebook was made from another version of the assignment. Ask your instructor for the right one"
        notes.append((OTHER_VERSION, message))
    parts = {f"{slot.name}.{question}" for slot in assignment.slots for question in slot.questions}
    if unknown := sorted({cell.part for cell in submission.cells if cell.part is not None} - parts):
        listing = list_some(list(map(printable_name, unknown)), 3)
        notes.append((f"cells are marked as answers to parts that the assignment does not have: {listing}", ""))
    if submission.unknown_metadata:
        listing = list_some(submission.unknown_metadata, 5)
        notes.append((f"the metadata of its cells were changed, which does not affect the marks: {listing}", ""))
    if submission.late:
        notes.append(("the platform marked it as late", ""))
    return notes
