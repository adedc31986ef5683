"""Recognise the submissions of a class in the downloads of learning platforms, with one function for each layout.

A layout is the way in which a platform names files and folders. The function of a layout gets the entries of the folder
of submissions. For each entry with a name of this layout, the function returns who submitted it according to the
platform, and when. The module `roster` finds that student on the roster.

The names are those in Moodle's mod/assign/classes/downloader.php, in Canvas's lib/content_zipper.rb, and in programs
that parse the exports of Gradescope, Brightspace and Blackboard.
"""

import datetime
import json
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class SubmittedPath:
    """A submitted file or folder, with the owner's identifiers and name according to the platform.

    `received` is the time of the submission; None if the platform doesn't report it. `flagged_late` is whether the
    platform flagged the submission as late; None if it doesn't report this.
    """

    path: Path
    ids: tuple[str, ...] = ()
    name: str = ""
    platform: str = ""
    received: datetime.datetime | None = None
    flagged_late: bool | None = None


def check_safely(check: Callable[[], bool]) -> bool:
    """Return the result of a check of a path; False if it raises OSError, for example for a name that is too long."""
    try:
        return check()
    except OSError:
        return False


Layout = Callable[[Path, Sequence[Path]], list[SubmittedPath]]
"""A function that returns the submissions that it recognises among the entries of a folder."""


def _match_names(pattern: re.Pattern[str], paths: Sequence[Path]) -> list[tuple[Path, re.Match[str]]]:
    """Return the paths whose names match a pattern, each with its match."""
    return [(path, match) for path in paths if (match := pattern.fullmatch(path.name))]


def _recognise_student_names(_: Path, entries: Sequence[Path]) -> list[SubmittedPath]:
    """Return all entries as submissions: STUDENT/… or STUDENT.ipynb.

    This is qdot's own layout, and the layout of nbgrader's submitted/STUDENT/ASSIGNMENT/…
    """
    names = [(path, path.name if check_safely(path.is_dir) else path.stem) for path in entries]
    return [SubmittedPath(path, (name.removesuffix(".tar"),), name) for path, name in names]


_MOODLE = re.compile(r"(?P<name>.+?)_(?P<number>\d+)_assignsubmission_(?:file|onlinetext|[a-z]+)(?:_.*)?", re.DOTALL)
"""Matches the name of a file or folder in Moodle's download."""


def _recognise_moodle(_: Path, entries: Sequence[Path]) -> list[SubmittedPath]:
    """Return Moodle's submissions: NAME_NUMBER_assignsubmission_file/…, or files …_file_hw.ipynb without folders.

    Before Moodle 4.1, the folder's name ends with an underscore. If names are hidden, NAME is "Participant", and NUMBER
    is in the grading worksheet's column Identifier.
    """
    return [
        SubmittedPath(path, (match["number"], f"Participant {match['number']}"), match["name"], "Moodle")
        for path, match in _match_names(_MOODLE, entries)
    ]


_CANVAS = re.compile(r"(?P<name>.+?)(?P<late>_LATE)?_(?P<user>\d+)_(?:\d+_.+|(?:text|link)\.html)", re.DOTALL)
"""Matches the name of a file in Canvas's download."""


def _recognise_canvas(_: Path, entries: Sequence[Path]) -> list[SubmittedPath]:
    """Return Canvas's submissions: lastfirst_USER_FILE_hw.ipynb or lastfirst_LATE_USER_FILE_hw-1.ipynb.

    The files have the time of the download, which is not the time of the submission.
    """
    matches = _match_names(_CANVAS, [path for path in entries if not check_safely(path.is_dir)])
    return [
        SubmittedPath(path, (match["user"],), match["name"], "Canvas", flagged_late=match["late"] is not None)
        for path, match in matches
    ]


def _recognise_gradescope(root: Path, entries: Sequence[Path]) -> list[SubmittedPath]:
    """Return Gradescope's submissions: submission_NUMBER/…

    Names, identifiers and times are in the file submission_metadata.yml, which is returned without an owner. A group's
    submission has several owners.
    """
    listing = root / "submission_metadata.yml"
    if listing.is_symlink() or not check_safely(listing.is_file):
        return []
    by_name = {path.name: path for path in entries}
    submitted_paths = [SubmittedPath(listing, platform="Gradescope")]
    records = {folder: record for folder, record in _read_gradescope_records(listing).items() if folder in by_name}
    for folder, record in records.items():
        for person in record.people or [{}]:  # without people, the submission has no owner
            ids = tuple(value for key in ("sid", "email") if (value := person.get(key)))
            name, received = person.get("name", ""), record.created_at
            submitted_paths.append(SubmittedPath(by_name[folder], ids, name, "Gradescope", received))
    return submitted_paths


_BRIGHTSPACE = re.compile(r"(?P<number>\d+)-\d+ - (?P<name>.+?) - .*\d.*", re.DOTALL)
"""Matches the name of a folder in Brightspace's download."""


def _recognise_brightspace(_: Path, entries: Sequence[Path]) -> list[SubmittedPath]:
    """Return Brightspace's submissions, NUMBER-SUBMISSION - NAME - DATE/hw.ipynb.

    The list index.html is also returned, without an owner.
    """
    matches = _match_names(_BRIGHTSPACE, entries)
    listing = [SubmittedPath(path, platform="Brightspace") for path in entries if matches and path.name == "index.html"]
    return listing + [SubmittedPath(path, (match["number"],), match["name"], "Brightspace") for path, match in matches]


_BLACKBOARD = re.compile(r"(?P<assignment_and_login>.+_.+)_attempt_\d{4}(?:-\d\d){5}(?:_(?P<file>.+)|\.txt)", re.DOTALL)
"""Matches the name of a file in Blackboard's download. Underscores may be in the assignment's name and in the login."""


def _recognise_blackboard(_: Path, entries: Sequence[Path]) -> list[SubmittedPath]:
    """Return Blackboard's submissions: ASSIGNMENT_LOGIN_attempt_DATE_hw.ipynb.

    ASSIGNMENT_LOGIN_attempt_DATE.txt is also recognised, but has no owner. If a login has an underscore, only the
    roster can show where the assignment's name ends.
    """
    matches = _match_names(_BLACKBOARD, entries)
    names = [(path, match["assignment_and_login"] if match["file"] else "") for path, match in matches]
    return [SubmittedPath(path, _list_suffixes(name, "_"), platform="Blackboard") for path, name in names]


_ILIAS = re.compile(r"(?P<name>[^_]+_[^_]+)_(?P<login>.+)_(?P<number>\d+)", re.DOTALL)
"""Matches the name of a folder in ILIAS's download."""


def _recognise_ilias(_: Path, entries: Sequence[Path]) -> list[SubmittedPath]:
    """Return the submissions of ILIAS: LAST_FIRST_LOGIN_NUMBER/…"""
    matches = _match_names(_ILIAS, [path for path in entries if check_safely(path.is_dir)])
    owners = [(path, (match["login"], match["number"]), match["name"].replace("_", " ")) for path, match in matches]
    return [SubmittedPath(path, ids, name, "ILIAS") for path, ids, name in owners]


def _recognise_github(_: Path, entries: Sequence[Path]) -> list[SubmittedPath]:
    """Return the submissions in the folders into which GitHub Classroom clones a class: ASSIGNMENT-LOGIN/…

    Folders are recognised if they all share a prefix; a Git repository is always recognised.
    """
    folders = [path for path in entries if check_safely(path.is_dir)]
    if len(folders) < 2 or len({path.name.partition("-")[0] for path in folders}) > 1:
        folders = [path for path in folders if check_safely((path / ".git").exists)]
    suffixes = [(path, _list_suffixes(path.name, "-")) for path in folders]
    return [SubmittedPath(path, ids, platform="GitHub") for path, ids in suffixes if ids]


def _list_suffixes(text: str, separator: str) -> tuple[str, ...]:
    """Return the suffixes of a text that follow a separator, the longest first."""
    return tuple(text.split(separator, n)[-1] for n in range(1, text.count(separator) + 1))


LAYOUTS: dict[str, Layout] = {
    "gradescope": _recognise_gradescope, "moodle": _recognise_moodle, "brightspace": _recognise_brightspace,
    "blackboard": _recognise_blackboard, "canvas": _recognise_canvas, "ilias": _recognise_ilias,
    "github": _recognise_github, "students": _recognise_student_names,
}  # fmt: skip
"""The layouts, in order: the first layout that recognises a file or folder determines the owner."""


MAX_DEPTH = 5
"""Maximum number of nested folders with a single entry that are opened to find submissions."""


def list_nested_folders(root: Path) -> Iterator[Path]:
    """Yield a folder, then the folder that is its only entry, and so on, as in an unpacked export."""
    folder = root
    yield folder
    for _ in range(MAX_DEPTH):
        entries = _list_entries(folder)
        if len(entries) != 1 or entries[0].is_symlink() or not check_safely(entries[0].is_dir):
            return
        (folder,) = entries
        yield folder


def find_submitted_paths(root: Path) -> list[SubmittedPath]:
    """Return the submitted files and folders in a folder of submissions, with the owners that their names suggest.

    Recognised files without an owner, such as a platform's list of submissions, are left out.
    """
    remaining_paths, submissions = _list_entries(root), list[SubmittedPath]()
    for recognise in LAYOUTS.values():
        submissions += recognise(root, remaining_paths)
        recognised_paths = {submission.path for submission in submissions}
        remaining_paths = [path for path in remaining_paths if path not in recognised_paths]
    return [submission for submission in submissions if submission.ids or submission.name]


def _list_entries(root: Path) -> list[Path]:
    """Return the files and folders in a folder, without those that operating systems add."""
    return sorted(path for path in root.iterdir() if not path.name.startswith((".", "__MACOSX")))


# --- Gradescope's list ---


@dataclass
class _GradescopeRecord:
    """A submission in Gradescope's list: the time of submission, and the people who submitted it."""

    created_at: datetime.datetime | None = None
    people: list[dict[str, str]] = field(default_factory=list)


def _read_gradescope_records(path: Path) -> dict[str, _GradescopeRecord]:
    """Return the records of submission_metadata.yml by folder. Only the needed lines of this YAML file are parsed."""
    records, record, section = dict[str, _GradescopeRecord](), _GradescopeRecord(), ""
    with path.open(encoding="utf-8", errors="replace") as file:
        for line in map(str.rstrip, file):
            if match := re.match(r"""(["']?)([^\s:"'-][^:"']*)\1:$""", line):  # submission_123:
                record, section = records.setdefault(match.group(2), _GradescopeRecord()), ""
            elif match := re.match(r"  :(\w+):\s*(.*)", line):  # "  :created_at: …" or "  :submitters:"
                section = match.group(1)
                if section == "created_at":
                    record.created_at = _parse_time(_parse_scalar(match.group(2)))
            elif section == "submitters" and (match := re.match(r"\s+(- )?:(\w+):\s*(.*)", line)):  # "  - :name: …"
                if match.group(1) or not record.people:
                    record.people.append({})
                record.people[-1][match.group(2)] = _parse_scalar(match.group(3))
    return records


def _parse_scalar(text: str) -> str:
    """Return the value of a YAML scalar, which may be in quotes, as text."""
    if text[:1] == '"':
        with suppress(ValueError):
            return str(json.loads(text))
        return text.strip('"')
    return text[1:-1].replace("''", "'") if text[:1] == "'" and text[-1:] == "'" else text


def _parse_time(text: str) -> datetime.datetime | None:
    """Return a time in Ruby's format or ISO 8601, such as 2026-11-21 22:05:07.123456789 Z; None if it is invalid.

    The default zone is UTC, and fractions of a second are omitted.
    """
    with suppress(ValueError):
        text_with_offset = re.sub(r"\s+([+-][\d:]+)$", r"\1", text)
        moment = datetime.datetime.fromisoformat(re.sub(r"\s*(Z|UTC)$", "Z", text_with_offset))
        return moment.replace(microsecond=0, tzinfo=moment.tzinfo or datetime.UTC)
    return None
