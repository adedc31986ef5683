"""Find the files that each student submitted, choose those that may be the notebook, and read a notebook.

Functions that read a student's file raise Unreadable with a reason for the student if the file can't be graded.
"""

import contextlib
import csv
import datetime
import hashlib
import os
import re
import stat
import zipfile
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from qdot.exercises.common.console import note
from qdot.exercises.common.errors import QdotError, write_first
from qdot.grader.submissions.archives import is_archive, list_members, read_member, unpack_temporarily
from qdot.grader.submissions.cells import (
    MARKDOWN_ENDINGS,
    MAX_FILE_BYTES,
    NOTEBOOK_ADVICE,
    SCRIPT_ENDINGS,
    Cell,
    OverLimit,
    Unreadable,
    make_printable,
    read_cells,
)
from qdot.grader.submissions.layouts import SubmittedPath, check_safely, find_submitted_paths, list_nested_folders
from qdot.grader.submissions.roster import SAME_NAME, PossibleOwners, Roster

if TYPE_CHECKING:  # not imported at run time: a student's `qdot check` needs no assignment
    from qdot.exercises.assignment.assignment import Assignment, Student

MAX_FILES, MAX_NOTEBOOKS = 20_000, 50
"""Maximum number of files that a student may submit, and maximum number of these files that are graded."""
NOT_FETCHED_FILE = ".not-fetched.csv"
"""A table (columns student, why) in the folder of submissions: the students whose submissions could not be downloaded.

These students get no mark instead of zero points. The file's name begins with a dot, so that
the table is not taken for a submission.
"""


@dataclass(frozen=True)
class Submission:
    """A submitted notebook: the file, the time when it was received, and the content.

    `qdot_metadata` is the notebook's metadata about the assignment. `notes` say what was unusual when the file was
    parsed. `time_source` is the source of the time: a platform's name, or "file". `flagged_late` is whether the
    platform itself flagged the submission as late; None if the platform doesn't report this. `unknown_metadata` lists
    the keys of cell metadata that qdot did not write. `modules` maps the names of the Python files beside the notebook,
    which cells may import, to their texts.

    If the file can't be read, `unreadable_reason` says why, and `over_limit` is whether a limit is the reason.
    """

    file: Path
    received: datetime.datetime
    sha256: str | None = None
    cells: tuple[Cell, ...] = ()
    qdot_metadata: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    unknown_metadata: Sequence[str] = ()
    time_source: str = "file"
    flagged_late: bool | None = None
    modules: Mapping[str, str] = field(default_factory=dict)
    unreadable_reason: str = ""
    over_limit: bool = False

    def is_for(self, assignment: "Assignment") -> bool:
        """Return whether the file's name is the assignment's, or the metadata name the assignment."""
        return self.file.name == f"{assignment.key}.ipynb" or self.qdot_metadata.get("assignment") == assignment.key

    @property
    def fingerprint(self) -> str:
        """A text that changes whenever the submission changes."""
        return repr((self.sha256, self.unreadable_reason, self.notes, self.flagged_late, *sorted(self.modules.items())))


@dataclass(frozen=True)
class StudentFiles:
    """The files of a student; the file that is most likely the notebook comes first.

    `platform`, `received` and `flagged_late` are what the platform reports about the submission. `ungraded_reason` is
    the reason why none of the files can be graded; `over_limit` is whether this reason is a limit. `failure` is the
    message on an error of qdot or of the machine, if the search for the files failed.
    """

    files: tuple[Path, ...]
    notes: tuple[str, ...] = ()
    ungraded_reason: str = ""
    platform: str = ""
    received: datetime.datetime | None = None
    flagged_late: bool | None = None
    failure: str = ""
    over_limit: bool = False


@dataclass(frozen=True)
class SubmissionFolder:
    """The files in a folder of submissions; `by_student` maps each student to the files that belong to this student.

    `not_on_roster` has the names of files that belong to no student on the roster. `uncertain_owners` has a message
    on each file whose owner is uncertain.
    """

    by_student: dict[str, StudentFiles]
    not_on_roster: list[str] = field(default_factory=list)
    uncertain_owners: list[str] = field(default_factory=list)


def find_submissions(assignment: "Assignment", root: Path) -> SubmissionFolder:
    """Return the files of each student in a folder of submissions, and the files without a certain owner.

    Of a student's files, the notebook with the assignment's file name comes first, else the notebook whose metadata
    name the assignment, else the first notebook by name. Raises QdotError if `root` is not a folder.
    """
    if not root.exists():
        raise QdotError(f"{root} does not exist; put the submissions there, as STUDENT/*.ipynb or STUDENT.ipynb")
    if not root.is_dir():
        raise QdotError(f"{root} is neither a folder with STUDENT/*.ipynb or STUDENT.ipynb nor a platform's zip")
    folder = SubmissionFolder({})
    certain_paths, doubtful_paths = defaultdict[str, list[SubmittedPath]](list), defaultdict[str, list[Path]](list)
    roster = _make_roster(assignment.roster, assignment.folder)
    inner_root = _find_root(roster, root)
    for submitted_path, owner in _find_owners(roster, inner_root, assignment.key):
        name = make_printable(submitted_path.path.name)
        if owner.reason and not owner.students:
            folder.uncertain_owners.append(f"{name}: {owner.reason}; not graded")
            continue
        may_be_notebook = _rank_by_ending(submitted_path.path.name) < _DOCUMENT_RANK
        if owner.is_certain:
            certain_paths[owner.students[0]].append(submitted_path)
        elif submitted_path.platform or may_be_notebook or check_safely(submitted_path.path.is_dir):
            # Other files, such as a README, are ignored.
            for student in owner.students:
                doubtful_paths[student].append(submitted_path.path)
            if owner.students:
                folder.uncertain_owners.append(_describe_doubtful_owner(name, submitted_path, owner))
            else:
                folder.not_on_roster.append(name)
    for student in dict.fromkeys((*certain_paths, *doubtful_paths)):
        if files := _select_files(certain_paths[student], assignment.key, doubtful_paths[student]):
            folder.by_student[student] = files
    folder.by_student.update(_read_not_fetched(inner_root / NOT_FETCHED_FILE))
    return folder


def _describe_doubtful_owner(name: str, submitted_path: SubmittedPath, owner: PossibleOwners) -> str:
    """Return a message on a submission, called `name`, that may belong to several students."""
    advice = ""
    if submitted_path.platform and submitted_path.ids:
        column = f"{submitted_path.platform.lower()} id"
        advice = f"; enter {submitted_path.ids[0]} in the column {column!r} of the owner in roster.csv"
        if submitted_path.platform == "Moodle":
            advice += " (the grading worksheet has the numbers)"
    return f"{name} may belong to {' or '.join(owner.students)}: {owner.reason}; not graded{advice}"


def _make_roster(students: "Sequence[Student]", folder: Path) -> Roster:
    """Return the roster of the students, with the Moodle numbers under which `qdot release` packed their notebooks."""
    from qdot.exercises.assignment.handout import read_moodle_numbers

    return Roster(students, read_moodle_numbers(folder))


def _find_root(roster: Roster, root: Path) -> Path:
    """Return the folder with the submissions.

    This is `root` if anything in it has an owner. Otherwise, if its only entry is a folder, that folder is tried, and
    so on.
    """
    for folder in list_nested_folders(root):
        if any(roster.find_owner(submitted_path).students for submitted_path in find_submitted_paths(folder)):
            return folder
    return root


def _find_owners(roster: Roster, root: Path, key: str = "") -> list[tuple[SubmittedPath, PossibleOwners]]:
    """Return the submitted files and folders with their possible owners.

    Students with the same name are distinguished by the names in their notebooks if each of them has submitted one. So
    a student who changes the name in a notebook can't become another student.
    """
    owners_by_path = {path: _find_possible_owners(roster, path) for path in find_submitted_paths(root)}
    for owners in {owners for owners in owners_by_path.values() if owners.reason == SAME_NAME}:
        paths = [path for path, possible_owners in owners_by_path.items() if possible_owners == owners]
        named_students = [_read_named_student(path, key) for path in paths]
        if sorted(named_students) == sorted(owners.students):
            owners_by_path |= {
                path: PossibleOwners((student,)) for path, student in zip(paths, named_students, strict=True)
            }
    return list(owners_by_path.items())


def _find_possible_owners(roster: Roster, submitted_path: SubmittedPath) -> PossibleOwners:
    try:
        return roster.find_owner(submitted_path)
    except Exception as error:  # a problem with one submission must not affect the others
        return PossibleOwners((), f"qdot failed to find the owner ({error})")


def _read_named_student(submitted_path: SubmittedPath, key: str) -> str:
    """Return the student whom a submitted notebook names; "" if it can't be read or names nobody."""
    files = _select_files([submitted_path], key)
    if files is None or files.failure or files.ungraded_reason:
        return ""
    try:
        return str(read_submission(files.files[0], key).qdot_metadata.get("student", ""))
    except Unreadable:
        return ""


def find_certain_paths(assignment: "Assignment", root: Path) -> dict[str, list[SubmittedPath]]:
    """Return the submitted files and folders that certainly belong to each student."""
    roster = _make_roster(assignment.roster, assignment.folder)
    paths = defaultdict[str, list[SubmittedPath]](list)
    for submitted_path, owner in _find_owners(roster, _find_root(roster, root), assignment.key):
        if owner.is_certain:
            paths[owner.students[0]].append(submitted_path)
    return paths


def find_paths_of_student(students: "Sequence[Student]", folder: Path, student: str) -> tuple[list[Path], list[Path]]:
    """Return the paths in submitted/ that certainly belong to a student, and those that may belong to this student."""
    root = folder / "submitted"
    if not root.is_dir():
        return [], []
    roster = _make_roster(students, folder)
    certain_paths, doubtful_paths = list[Path](), list[Path]()
    for submitted_path, owner in _find_owners(roster, _find_root(roster, root)):
        if student in owner.students:
            (certain_paths if owner.is_certain else doubtful_paths).append(submitted_path.path)
    return certain_paths, doubtful_paths


def _read_not_fetched(table: Path) -> dict[str, StudentFiles]:
    """Return the students whose submissions could not be downloaded, according to a table. Raises QdotError."""
    if not table.exists():
        return {}
    try:
        rows = list(csv.DictReader(table.read_text(encoding="utf-8").splitlines()))
        reasons = {row["student"]: f"it could not be fetched: {row['why'] or 'unknown reason'}" for row in rows}
        return {student: StudentFiles((), failure=reason) for student, reason in reasons.items()}
    except (OSError, ValueError, KeyError, csv.Error):
        raise QdotError(f"{table}: expected a table with the columns student and why; fix or remove it") from None


def find_student_files(
    assignment: "Assignment", path: Path, received: datetime.datetime | None = None, time_source: str = "option"
) -> StudentFiles | None:
    """Return a student's files: the file `path`, or all files in the folder `path`; None if there are none.

    `time_source` is the source of the time `received`. Raises QdotError if the path does not exist.
    """
    if not path.exists():
        raise QdotError(f"{path} does not exist; expected the student's notebook, or a folder that contains it")
    submitted_path = SubmittedPath(path, platform=time_source if received else "", received=received)
    return _select_files([submitted_path], assignment.key)


@contextlib.contextmanager
def open_submissions(submissions: Path) -> Iterator[Path]:
    """Yield the folder of submissions. A platform's zip is unpacked into a temporary folder. Raises QdotError."""
    if not submissions.is_file() or not zipfile.is_zipfile(submissions):
        if submissions.is_file() and submissions.suffix.lower() == ".zip":
            raise QdotError(f"{submissions} can't be unpacked: it is damaged, or not a zip file; download it again")
        yield submissions
        return
    try:
        with unpack_temporarily(submissions) as (folder, messages):
            for message in messages:
                note(message)
            yield folder
    except Unreadable as error:
        raise QdotError(str(error)) from None


UNCERTAIN_OWNER = (
    "a submission that may be yours has a name that also fits another student, so it was not graded. Tell your "
    "instructor which submission is yours"
)


def _select_files(
    submitted_paths: Sequence[SubmittedPath], key: str, doubtful_paths: Sequence[Path] = ()
) -> StudentFiles | None:
    """Return a student's files, the most likely notebook first; None if there are none.

    If there are several times, the last one is the time of submission. The files in `doubtful_paths` may be another
    student's.
    """
    late_flags = [entry.flagged_late for entry in submitted_paths if entry.flagged_late is not None]
    flagged_late = any(late_flags) if late_flags else None
    received = max((entry.received for entry in submitted_paths if entry.received), default=None)
    platform = next((entry.platform for entry in reversed(submitted_paths) if entry.platform), "")
    make_student_files = partial(StudentFiles, platform=platform, received=received, flagged_late=flagged_late)
    try:
        refusals = {path: _explain_refusal(path) for entry in submitted_paths for path in _list_files(entry.path)}
        files = [path for path, refusal in refusals.items() if not refusal]
        if len(files) > MAX_FILES:
            message = f"you submitted more than {MAX_FILES:,} files; submit only the notebook"
            return make_student_files(tuple(files[:1]), (), message, over_limit=True)
        files = sort_candidates(files, lambda path: path.name, _read_small, key)
    except Exception as error:  # the other students have to be graded nonetheless
        paths = tuple(entry.path for entry in submitted_paths)
        return StudentFiles(paths, failure=f"qdot failed to find the notebook: {type(error).__name__}: {error}")
    refused_paths = [path for path, refusal in refusals.items() if refusal]
    names = ", ".join(make_printable(path.name) for path in refused_paths[:3])
    reasons = " and ".join(dict.fromkeys(refusals[path] for path in refused_paths[:3]))
    refusal_note = f"{names}: {reasons}; submit the file itself"
    if files:
        return make_student_files(tuple(files), (refusal_note,) if refused_paths else ())
    if refused_paths:
        return make_student_files(tuple(refused_paths), (), refusal_note)
    return StudentFiles(tuple(doubtful_paths), (), UNCERTAIN_OWNER) if doubtful_paths else None


def _explain_refusal(path: Path) -> str:
    """Return a phrase that says why qdot does not open a path; empty for a regular file, which is opened."""
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
    if path.is_symlink() or not check_safely(path.is_dir):
        yield path
        return
    count, unreadable_paths, unvisited_paths = 0, list[Path](), [path]
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
    """Return whether a name is hidden or typical of files that programs make: .ipynb_checkpoints, Thumbs.db."""
    return (name.startswith(".") and name != "..") or name in ("__MACOSX", "Thumbs.db", "desktop.ini", "__pycache__")


# --- choosing among several files ---


_ENDINGS_BY_RANK = (
    (".ipynb",),
    (".ipynb.txt", ".ipynb.json", ".json"),
    (".zip", ".tgz", ".tar.gz", ".tar"),
    (*SCRIPT_ENDINGS, *MARKDOWN_ENDINGS),
    (".txt", ".html", ".htm", ".pdf", ".docx", ".doc", ".odt", ".rtf"),
)
"""Endings of file names, the most likely for a notebook first."""
_ARCHIVE_RANK, _DOCUMENT_RANK = 2, 4
"""The indices in `_ENDINGS_BY_RANK` of archives and of documents; files with unknown endings come after documents."""


def _rank_by_ending(name: str) -> int:
    """Return the index of the ending of a file's name in `_ENDINGS_BY_RANK`, or its length for an unknown ending.

    A file with a lower rank is more likely the notebook.
    """
    ranks = (rank for rank, endings in enumerate(_ENDINGS_BY_RANK) if name.lower().endswith(endings))
    return next(ranks, len(_ENDINGS_BY_RANK))


def _find_archive_depth(name: str) -> int:
    """Return the depth of a path in an archive; a path that leads out of the archive counts as the deepest."""
    parts = PurePosixPath(name.replace("\\", "/")).parts
    return 1000 if ".." in parts else len(parts)


AnyFile = TypeVar("AnyFile")


def sort_candidates(
    files: Sequence[AnyFile], get_name: Callable[[AnyFile], str], read: Callable[[AnyFile], bytes], key: str
) -> list[AnyFile]:
    """Return the files sorted by how likely they are to be the notebook of the assignment `key`, most likely first.

    `get_name` returns the name of a file, and `read` its content.
    """
    key_metadata = f'"assignment": "{key}"'.encode()

    def rank(file: AnyFile) -> tuple[int, bool, bool, int, str]:
        name = get_name(file)
        ending_rank = _rank_by_ending(name)
        lacks_key = len(files) > 1 and ending_rank < _ARCHIVE_RANK and key_metadata not in read(file)
        return ending_rank, PurePosixPath(name).name != f"{key}.ipynb", lacks_key, _find_archive_depth(name), name

    return sorted(files, key=rank)


MAX_SMALL_FILE_BYTES = MAX_FILE_BYTES // 4
"""Maximum size in bytes of a file that is read before qdot knows whether it is the notebook."""


def _read_small(path: Path) -> bytes:
    """Return the content of a file; empty if the file is very large or unreadable."""
    with contextlib.suppress(OSError):
        return path.read_bytes() if path.stat().st_size <= MAX_SMALL_FILE_BYTES else b""
    return b""


def _read_small_member(archive: Path, sizes: Mapping[str, int], name: str) -> bytes:
    """Return the content of a file in an archive; empty if the file is very large or unreadable."""
    with contextlib.suppress(Unreadable):  # the error is reported later if this is the file to grade
        return read_member(archive, name) if sizes[name] <= MAX_SMALL_FILE_BYTES else b""
    return b""


def select_likely_notebooks(files: Sequence[Path]) -> tuple[tuple[Path, ...], str]:
    """Return the likely notebooks among a student's sorted files, and a note, which is usually empty.

    If there are more than `MAX_NOTEBOOKS`, the first notebook and the newest of the others are returned. The note says
    so.
    """
    # Notebooks and archives are likely; scripts are likely only if there is nothing better; documents never are.
    highest_rank = min(max(_ARCHIVE_RANK, _rank_by_ending(files[0].name)), _DOCUMENT_RANK - 1)
    likely_paths = [path for path in files if _rank_by_ending(path.name) <= highest_rank]
    if len(likely_paths) <= MAX_NOTEBOOKS:
        return tuple(likely_paths) or tuple(files[:1]), ""
    first_path, *other_paths = likely_paths
    chosen_paths = {first_path, *sorted(other_paths, key=find_modification_time, reverse=True)[: MAX_NOTEBOOKS - 1]}
    choice = f"{first_path.name} and the {MAX_NOTEBOOKS - 1} newest of the others"
    message = f"{len(likely_paths)} notebooks were submitted, but qdot reads at most {MAX_NOTEBOOKS}: {choice}"
    return tuple(path for path in likely_paths if path in chosen_paths), message


MAX_TIME = 253_370_764_800
"""The beginning of the year 9999, in seconds since 1970; a file's time may be later than Python's datetime allows."""


def find_modification_time(path: Path) -> datetime.datetime:
    """Return the time at which a file was last changed, from 1970 to 9999; the beginning of 1970 if it is unknown."""
    seconds = 0
    with contextlib.suppress(OSError):
        seconds = min(max(int(path.lstat().st_mtime), 0), MAX_TIME)
    return datetime.datetime.fromtimestamp(seconds, datetime.UTC)


# --- reading ---


def find_python_files(path: Path) -> tuple[Path, ...]:
    """Return the Python files in a notebook's folder, without links. The folder must be that of one student."""
    try:
        return tuple(sorted(file for file in path.parent.glob("*.py") if not _explain_refusal(file)))
    except OSError:
        return ()


def read_submission(path: Path, key: str = "", siblings: Sequence[Path] = ()) -> Submission:
    """Return the submission in a notebook, script, Markdown file or archive, with the Python files that it may import.

    `key` is the key of the assignment. `siblings` are files that may be in the same folder. Raises Unreadable.
    """
    label = make_printable(path.name)
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise Unreadable(f"{label} is not a file")
        if status.st_size > MAX_FILE_BYTES:
            limit = f"{MAX_FILE_BYTES // 1_000_000} MB"
            raise OverLimit(f"{label} is larger than {limit}; clear its outputs and submit it again")
        data = path.read_bytes()
    except OSError as error:
        raise Unreadable(f"{label} can't be read: {error.strerror}") from None
    digest = hashlib.sha256(data).hexdigest()
    name, notes = path.name, list[str]()
    files_in_folder = [sibling for sibling in siblings if sibling.parent == path.parent and sibling != path]
    neighbours: list[_Neighbour] = [(sibling.name, partial(_read_small, sibling)) for sibling in files_in_folder]
    if is_archive(data[:512]):
        name, data, message, neighbours = _read_from_archive(path, key)
        notes.append(message)
    content = read_cells(name, data)
    if content.note:
        notes.append(f"{make_printable(name)} is not an .ipynb file: {content.note}")
    return Submission(
        path, find_modification_time(path), digest, content.cells, content.qdot_metadata, tuple(notes),
        content.unknown_metadata, modules=_read_modules(neighbours),
    )  # fmt: skip


MAX_MODULES, MAX_MODULE_BYTES = 20, 200_000
"""Maximum number of Python files that a notebook may import, and maximum size in bytes of each of them."""


_Neighbour = tuple[str, Callable[[], bytes]]
"""A file in the same folder as a notebook: its name, and a function that returns its content."""


def _read_modules(neighbours: Sequence[_Neighbour]) -> dict[str, str]:
    """Map the name of each file that Python can import to its text."""
    modules = [(name, read) for name, read in neighbours if name.endswith(".py") and name[:-3].isidentifier()]
    contents = [(name, read()) for name, read in modules[:MAX_MODULES]]
    return {name: data.decode("utf-8-sig", "replace") for name, data in contents if len(data) <= MAX_MODULE_BYTES}


def _read_from_archive(path: Path, key: str) -> tuple[str, bytes, str, list[_Neighbour]]:
    """Return the name and content of the notebook in an archive, a note, and the files in the notebook's folder.

    Raises Unreadable if the archive contains no notebook or can't be unpacked.
    """
    sizes, label = list_members(path), make_printable(path.name)
    names = [name for name in sizes if not any(map(_is_hidden, PurePosixPath(name).parts))]
    ranks = {name: _rank_by_ending(name) for name in names}
    candidates = [name for name, rank in ranks.items() if rank != _ARCHIVE_RANK and rank < _DOCUMENT_RANK]
    if not candidates:
        has_archive = _ARCHIVE_RANK in ranks.values()
        content = "contains only another archive, which qdot does not open" if has_archive else "contains no notebook"
        raise Unreadable(f"{label} {content}; {NOTEBOOK_ADVICE}")
    candidates.sort(key=lambda name: (ranks[name], _find_archive_depth(name), name))
    read = partial(_read_small_member, path, sizes)
    best_name, *other_names = sort_candidates(candidates[:20], str, read, key)  # reading more files would take too long
    if sizes[best_name] > MAX_FILE_BYTES:
        limit = f"{MAX_FILE_BYTES // 1_000_000} MB"
        raise OverLimit(f"{make_printable(best_name)} in {label} is larger than {limit}; clear its outputs")
    message = f"{label} is an archive; qdot graded {make_printable(best_name)} in it"
    likely_names = [make_printable(name) for name in other_names if ranks[name] <= ranks[best_name]]
    if likely_names:
        message += f", not {', '.join(likely_names[:5])}"
    folder = PurePosixPath(best_name).parent
    names_in_folder = [name for name in names if name != best_name and PurePosixPath(name).parent == folder]
    neighbours: list[_Neighbour] = [(PurePosixPath(name).name, partial(read, name)) for name in names_in_folder]
    return PurePosixPath(best_name).name, read_member(path, best_name), message, neighbours


# --- metadata ---


def explain_wrong_assignment(submission: Submission, assignment: "Assignment") -> str | None:
    """Return a message if the metadata of a notebook name another assignment; None otherwise."""
    claimed_key = submission.qdot_metadata.get("assignment")
    if isinstance(claimed_key, str) and claimed_key != assignment.key:
        return f"this notebook belongs to the assignment {claimed_key[:80]!r}, not to {assignment.key!r}"
    return None


def explain_refused_upload(submission: Submission, assignment: "Assignment", student: str) -> str:
    """Return the reason for refusing an uploaded notebook; "" if it may answer a question of the assignment.

    A notebook without answers would only remove the student's earlier answers.
    """
    if reason := submission.unreadable_reason or explain_wrong_assignment(submission, assignment):
        return reason
    if submission.qdot_metadata.get("student") not in (None, student):
        return "it was released to another student; download your own notebook, and answer in it"
    slots = "|".join(re.escape(slot.name) for slot in assignment.slots)
    if not any(cell.part or re.search(rf"\b(?:{slots})_?\w", cell.source, re.IGNORECASE) for cell in submission.cells):
        return "it answers no question of this assignment; download your notebook, and answer in it"
    return ""


OTHER_VERSION = "the notebook was made from another assignment.toml, redrawn.csv or secret"
"""The note for the staff on a notebook that was made from another version of the assignment."""


class SubmissionNote(NamedTuple):
    """A note on a submission, in words for the staff and in words for the student ("" for none)."""

    for_staff: str
    for_student: str = ""


def describe_unusual_metadata(submission: Submission, assignment: "Assignment", student: str) -> list[SubmissionNote]:
    """Return notes on unusual metadata, which don't affect marks: the student's own problems are graded in any case."""
    claims, notes = submission.qdot_metadata, list[SubmissionNote]()
    claimed_student, digest = claims.get("student"), claims.get("problems_digest")
    if isinstance(claimed_student, str) and claimed_student != student:
        rule = "no answer in it earns points for following from a wrong one"
        message = f"this notebook was released to another student. It was graded against your own problems, and {rule}"
        notes.append(SubmissionNote(f"the notebook was released to {claimed_student[:80]!r}", message))
    if claims.get("kind") == "solution":
        notes.append(SubmissionNote("this is the staff's notebook with the solutions"))
    names_of_student = (student, str(claimed_student)) if isinstance(claimed_student, str) else (student,)
    known_digests = [assignment.problems_digest_of(name) for name in names_of_student]
    if isinstance(digest, str) and digest not in known_digests:
        message = "this notebook was made from another version of the assignment. Ask your instructor for the right one"
        notes.append(SubmissionNote(OTHER_VERSION, message))
    parts = {f"{slot.name}.{question}" for slot in assignment.slots for question in slot.questions}
    if unknown_parts := sorted({cell.part for cell in submission.cells if cell.part is not None} - parts):
        names = write_first(list(map(make_printable, unknown_parts)), 3)
        notes.append(SubmissionNote(f"cells are marked as answers to parts that the assignment does not have: {names}"))
    if submission.unknown_metadata:
        keys = write_first(submission.unknown_metadata, 5)
        notes.append(SubmissionNote(f"the metadata of its cells were changed, which does not affect the marks: {keys}"))
    if submission.flagged_late:
        notes.append(SubmissionNote("the platform marked it as late"))
    return notes
