"""Recognise the submissions of a class in the downloads of learning platforms, with one function for each layout.

A layout looks at the files and folders in the folder of submissions. For each one that it recognises by its name, it
returns who submitted it according to the platform, and when. `roster` finds that student on the roster. Sources:
Moodle's mod/assign/classes/downloader.php, Canvas's lib/content_zipper.rb, and programs that parse the exports of
Gradescope, Brightspace and Blackboard.
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
    """A submitted file or folder: its owner's identifiers and name, the platform, and when it was received.

    `late` is whether the platform itself flagged it as late, None if the platform doesn't say. `received` is None if
    only the file has a time.
    """

    path: Path
    ids: tuple[str, ...] = ()
    name: str = ""
    platform: str = ""
    received: datetime.datetime | None = None
    late: bool | None = None


def safe_check(check: Callable[[], bool]) -> bool:
    """Return the result of a check of a path; False if it raises OSError, as for a link to a name that is too long."""
    try:
        return check()
    except OSError:
        return False


Layout = Callable[[Path, Sequence[Path]], list[SubmittedPath]]
"""A function that returns the submissions that it recognises among the entries of a folder."""


def _match_names(pattern: re.Pattern[str], paths: Sequence[Path]) -> list[tuple[Path, re.Match[str]]]:
    """Return the paths whose names match a pattern, each with its match."""
    return [(path, match) for path in paths if (match := pattern.fullmatch(path.name))]


def _students(_: Path, entries: Sequence[Path]) -> list[SubmittedPath]:
    """Return all entries as submissions: STUDENT/… or STUDENT.ipynb.

    This is qdot's layout, and that of nbgrader's submitted/STUDENT/ASSIGNMENT/…
    """
    names = [(path, path.name if safe_check(path.is_dir) else path.stem) for path in entries]
    return [SubmittedPath(path, (name.removesuffix(".tar"),), name) for path, name in names]


_MOODLE = re.compile(r"(?P<name>.+?)_(?P<number>\d+)_assignsubmission_(?:file|onlinetext|[a-z]+)(?:_.*)?", re.DOTALL)


def _moodle(_: Path, entries: Sequence[Path]) -> list[SubmittedPath]:
    """Return Moodle's submissions: NAME_NUMBER_assignsubmission_file/…, or …_file_hw.ipynb without folders.

    Before Moodle 4.1, the folder's name ends with an underscore. If names are hidden, NAME is "Participant", and NUMBER
    is in the grading worksheet's column Identifier.
    """
    numbers = [(path, match["number"], match["name"]) for path, match in _match_names(_MOODLE, entries)]
    return [SubmittedPath(path, (number, f"Participant {number}"), name, "Moodle") for path, number, name in numbers]


_CANVAS = re.compile(r"(?P<name>.+?)(?P<late>_LATE)?_(?P<user>\d+)_(?:\d+_.+|(?:text|link)\.html)", re.DOTALL)


def _canvas(_: Path, entries: Sequence[Path]) -> list[SubmittedPath]:
    """Return Canvas's submissions: lastfirst_USER_FILE_hw.ipynb or lastfirst_LATE_USER_FILE_hw-1.ipynb.

    Their files have the time of the download.
    """
    matches = _match_names(_CANVAS, [path for path in entries if not safe_check(path.is_dir)])
    return [SubmittedPath(path, (m["user"],), m["name"], "Canvas", late=m["late"] is not None) for path, m in matches]


def _gradescope(root: Path, entries: Sequence[Path]) -> list[SubmittedPath]:
    """Return Gradescope's submissions: submission_NUMBER/…

    Names, identifiers and times are in submission_metadata.yml. A group's submission has several names.
    """
    listing = root / "submission_metadata.yml"
    if listing.is_symlink() or not safe_check(listing.is_file):
        return []
    by_name = {path.name: path for path in entries}
    submitted_paths = [SubmittedPath(listing, platform="Gradescope")]
    for record in _read_gradescope_records(listing):
        for person in (record.people or [{}]) if record.folder in by_name else ():
            ids = tuple(value for key in ("sid", "email") if (value := person.get(key)))
            path, name = by_name[record.folder], person.get("name", "")
            submitted_paths.append(SubmittedPath(path, ids, name, "Gradescope", record.created_at))
    return submitted_paths


_BRIGHTSPACE = re.compile(r"(?P<number>\d+)-\d+ - (?P<name>.+?) - .*\d.*", re.DOTALL)


def _brightspace(_: Path, entries: Sequence[Path]) -> list[SubmittedPath]:
    """Return Brightspace's submissions, NUMBER-SUBMISSION - NAME - DATE/hw.ipynb, and index.html, without an owner."""
    matches = _match_names(_BRIGHTSPACE, entries)
    listing = [SubmittedPath(path, platform="Brightspace") for path in entries if matches and path.name == "index.html"]
    return listing + [SubmittedPath(path, (match["number"],), match["name"], "Brightspace") for path, match in matches]


_BLACKBOARD = re.compile(r"(?P<named>.+_.+)_attempt_\d{4}(?:-\d\d){5}(?:_(?P<file>.+)|\.txt)", re.DOTALL)


def _blackboard(_: Path, entries: Sequence[Path]) -> list[SubmittedPath]:
    """Return Blackboard's submissions: ASSIGNMENT_LOGIN_attempt_DATE_hw.ipynb.

    ASSIGNMENT_LOGIN_attempt_DATE.txt is also recognised, but has no owner. If a login has an underscore, only the
    roster can show where the assignment's name ends.
    """
    return [
        SubmittedPath(path, _list_suffixes(match["named"], "_") if match["file"] else (), platform="Blackboard")
        for path, match in _match_names(_BLACKBOARD, entries)
    ]


_ILIAS = re.compile(r"(?P<name>[^_]+_[^_]+)_(?P<login>.+)_(?P<number>\d+)", re.DOTALL)


def _ilias(_: Path, entries: Sequence[Path]) -> list[SubmittedPath]:
    """Return the submissions of ILIAS: LAST_FIRST_LOGIN_NUMBER/…"""
    folders = [path for path in entries if safe_check(path.is_dir)]
    return [
        SubmittedPath(path, (match["login"], match["number"]), match["name"].replace("_", " "), "ILIAS")
        for path, match in _match_names(_ILIAS, folders)
    ]


def _github(_: Path, entries: Sequence[Path]) -> list[SubmittedPath]:
    """Return the submissions in the folders into which GitHub Classroom clones a class: ASSIGNMENT-LOGIN/…

    Folders are recognised if they all share a prefix; a Git repository is always recognised.
    """
    folders = [path for path in entries if safe_check(path.is_dir)]
    if len(folders) < 2 or len({path.name.partition("-")[0] for path in folders}) > 1:
        folders = [path for path in folders if safe_check((path / ".git").exists)]
    suffixes = [(path, _list_suffixes(path.name, "-")) for path in folders]
    return [SubmittedPath(path, ids, platform="GitHub") for path, ids in suffixes if ids]


def _list_suffixes(text: str, separator: str) -> tuple[str, ...]:
    """Return the text after each separator `separator`, the longest first."""
    return tuple(text.split(separator, n)[-1] for n in range(1, text.count(separator) + 1))


LAYOUTS: dict[str, Layout] = {
    "gradescope": _gradescope, "moodle": _moodle, "brightspace": _brightspace, "blackboard": _blackboard,
    "canvas": _canvas, "ilias": _ilias, "github": _github, "students": _students,
}  # fmt: skip
"""The layouts in order: the first one that recognises a file or folder determines its owner."""


MAX_DEPTH = 5
"""Maximum number of nested folders, each the only entry of its parent, that are opened in search of submissions."""


def list_nested_folders(root: Path) -> Iterator[Path]:
    """Yield a folder, then the folder that is its only entry, and so on, as in an unpacked export."""
    yield root
    for _ in range(MAX_DEPTH):
        entries = _list_entries(root)
        if len(entries) != 1 or entries[0].is_symlink() or not safe_check(entries[0].is_dir):
            return
        (root,) = entries
        yield root


def find_submitted_paths(root: Path) -> list[SubmittedPath]:
    """Return the submitted files and folders in a folder of submissions, with what their names say about the owner."""
    unrecognised, submissions = _list_entries(root), list[SubmittedPath]()
    for layout in LAYOUTS.values():
        recognised_paths = layout(root, unrecognised)
        submissions += recognised_paths
        unrecognised = [
            path for path in unrecognised if path not in {submitted_path.path for submitted_path in recognised_paths}
        ]
    return [submitted_path for submitted_path in submissions if submitted_path.ids or submitted_path.name]


def _list_entries(root: Path) -> list[Path]:
    return sorted(path for path in root.iterdir() if not path.name.startswith((".", "__MACOSX")))


# --- Gradescope's list ---


@dataclass
class _GradescopeRecord:
    """A submission in Gradescope's list: its folder, the time of submission, and the people who submitted it."""

    folder: str
    created_at: datetime.datetime | None = None
    people: list[dict[str, str]] = field(default_factory=list)


def _read_gradescope_records(path: Path) -> Iterator[_GradescopeRecord]:
    """Yield the records of submission_metadata.yml; only the needed lines are parsed, in the YAML that Ruby writes."""
    record, section = _GradescopeRecord(""), ""
    with path.open(encoding="utf-8", errors="replace") as file:
        for line in map(str.rstrip, file):
            if match := re.match(r"""(["']?)([^\s:"'-][^:"']*)\1:$""", line):
                if record.folder:
                    yield record
                record, section = _GradescopeRecord(match.group(2)), ""
            elif match := re.match(r"  :(\w+):\s*(.*)", line):
                section = match.group(1)
                if section == "created_at":
                    record.created_at = _parse_time(_parse_scalar(match.group(2)))
            elif section == "submitters" and (match := re.match(r"\s+(- )?:(\w+):\s*(.*)", line)):
                if match.group(1) or not record.people:
                    record.people.append({})
                record.people[-1][match.group(2)] = _parse_scalar(match.group(3))
    if record.folder:
        yield record


def _parse_scalar(text: str) -> str:
    """Return the value of a YAML scalar as text."""
    if text[:1] == '"':
        with suppress(ValueError):
            return str(json.loads(text))
        return text.strip('"')
    return text[1:-1].replace("''", "'") if text[:1] == "'" and text[-1:] == "'" else text


def _parse_time(text: str) -> datetime.datetime | None:
    """Return a time parsed from Ruby's format or ISO 8601, such as 2026-11-21 22:05:07.123456789 Z; None if invalid."""
    match = re.match(r"(\d{4}-\d\d-\d\d)[T ](\d\d:\d\d:\d\d)(?:\.\d+)?\s*(Z|UTC|[+-]\d\d:?\d\d)?$", text)
    if not match:
        return None
    zone = (match.group(3) or "Z").replace("UTC", "Z")
    with suppress(ValueError):
        return datetime.datetime.fromisoformat(f"{match.group(1)}T{match.group(2)}{zone}")
    return None
