"""How learning platforms lay out what a class handed in: one function a platform, which knows its names.

A layout looks at what lies in the folder of submissions and says of each file or folder that it knows whose it is said
to be, and when it came in. Who that is on the roster is for `roster` to say. Sources: Moodle's
mod/assign/classes/downloader.php, Canvas's lib/content_zipper.rb, and programs that read the exports of Gradescope,
Brightspace and Blackboard.
"""

import datetime
import json
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Handed:
    """A file or folder: whose it is said to be, by identifiers or by name, when it came in, and what says so.

    `late` is a platform's own mark, where it makes one; `received` is None where only the file tells its time.
    """

    path: Path
    ids: tuple[str, ...] = ()
    name: str = ""
    platform: str = ""
    received: datetime.datetime | None = None
    late: bool | None = None


def surely(is_so: Callable[[], bool]) -> bool:
    """Return what a path says of itself; False where it can't, as of a link to a name that is too long."""
    try:
        return is_so()
    except OSError:
        return False


Layout = Callable[[Path, Sequence[Path]], list[Handed]]


def _by_student(_: Path, entries: Sequence[Path]) -> list[Handed]:
    """STUDENT/…, STUDENT.ipynb: qdot's own layout, and nbgrader's submitted/STUDENT/ASSIGNMENT/…"""
    names = [(path, path.name if surely(path.is_dir) else path.stem) for path in entries]
    return [Handed(path, (name.removesuffix(".tar"),), name) for path, name in names]


_MOODLE = re.compile(r"(?P<name>.+?)_(?P<number>\d+)_assignsubmission_(?:file|onlinetext|[a-z]+)(?:_.*)?", re.DOTALL)


def _moodle(_: Path, entries: Sequence[Path]) -> list[Handed]:
    """NAME_NUMBER_assignsubmission_file/…, with an underscore at the end before Moodle 4.1, or flat …_file_hw.ipynb.

    With names hidden, NAME is "Participant", and its NUMBER is in the grading worksheet's column Identifier.
    """
    matches = ((path, _MOODLE.fullmatch(path.name)) for path in entries)
    return [
        Handed(path, (said["number"], f"Participant {said['number']}"), said["name"], "Moodle")
        for path, said in matches
        if said
    ]


_CANVAS = re.compile(
    r"(?P<name>.+?)(?P<late>_LATE)?_(?P<user>\d+)_(?:\d+_.+|(?:text|link)\.html)", re.DOTALL
)  # fmt: skip


def _canvas(_: Path, entries: Sequence[Path]) -> list[Handed]:
    """lastfirst_USER_FILE_hw.ipynb, lastfirst_LATE_USER_FILE_hw-1.ipynb; the files' times are of the download."""
    matches = ((path, _CANVAS.fullmatch(path.name)) for path in entries if not surely(path.is_dir))
    return [
        Handed(path, (said["user"],), said["name"], "Canvas", None, said["late"] is not None)
        for path, said in matches
        if said
    ]


def _gradescope(root: Path, entries: Sequence[Path]) -> list[Handed]:
    """submission_NUMBER/…, with names, identifiers and times in submission_metadata.yml; a group has several names."""
    listing = root / "submission_metadata.yml"
    if listing.is_symlink() or not surely(listing.is_file):
        return []
    by_name = {path.name: path for path in entries}
    handed = [Handed(listing, platform="Gradescope")]
    for record in _records(listing):
        if record.folder in by_name:
            people = record.people or [{}]
            ids = [tuple(value for key in ("sid", "email") if (value := person.get(key))) for person in people]
            handed += [
                Handed(by_name[record.folder], own, person.get("name", ""), "Gradescope", record.created)
                for person, own in zip(people, ids, strict=True)
            ]
    return handed


_BRIGHTSPACE = re.compile(r"(?P<number>\d+)-\d+ - (?P<name>.+?) - .*\d.*", re.DOTALL)


def _brightspace(_: Path, entries: Sequence[Path]) -> list[Handed]:
    """NUMBER-SUBMISSION - NAME - DATE/hw.ipynb, and an index.html that is of nobody."""
    matches = [(path, said) for path in entries if (said := _BRIGHTSPACE.fullmatch(path.name))]
    listing = [Handed(path, platform="Brightspace") for path in entries if matches and path.name == "index.html"]
    return listing + [Handed(path, (said["number"],), said["name"], "Brightspace") for path, said in matches]


_BLACKBOARD = re.compile(
    r"(?P<named>.+_.+)_attempt_\d{4}(?:-\d\d){5}(?:_(?P<file>.+)|\.txt)", re.DOTALL
)  # fmt: skip


def _blackboard(_: Path, entries: Sequence[Path]) -> list[Handed]:
    """ASSIGNMENT_LOGIN_attempt_DATE_hw.ipynb, and a text without a file's name, which says when, and is of nobody.

    Where the assignment's name ends and a login with an underscore begins, only the roster can say.
    """
    matches = [(path, said) for path in entries if (said := _BLACKBOARD.fullmatch(path.name))]
    return [
        Handed(path, _ends(said["named"], "_") if said["file"] else (), platform="Blackboard") for path, said in matches
    ]


_ILIAS = re.compile(r"(?P<name>[^_]+_[^_]+)_(?P<login>.+)_(?P<number>\d+)", re.DOTALL)


def _ilias(_: Path, entries: Sequence[Path]) -> list[Handed]:
    """LAST_FIRST_LOGIN_NUMBER/…"""
    matches = ((path, _ILIAS.fullmatch(path.name)) for path in entries if surely(path.is_dir))
    return [
        Handed(path, (said["login"], said["number"]), said["name"].replace("_", " "), "ILIAS")
        for path, said in matches
        if said
    ]


def _github(_: Path, entries: Sequence[Path]) -> list[Handed]:
    """ASSIGNMENT-LOGIN/…, as GitHub Classroom clones a class: all folders begin alike, or are repositories of Git."""
    folders = [path for path in entries if surely(path.is_dir)]
    alike = len(folders) > 1 and len({path.name.partition("-")[0] for path in folders}) == 1
    ends = [(path, _ends(path.name, "-")) for path in folders if alike or surely((path / ".git").exists)]
    return [Handed(path, ids, platform="GitHub") for path, ids in ends if ids]


def _ends(text: str, sign: str) -> tuple[str, ...]:
    """Return what stands behind each sign, the longest first."""
    return tuple(text.split(sign, n)[-1] for n in range(1, text.count(sign) + 1))


LAYOUTS: dict[str, Layout] = {
    "gradescope": _gradescope, "moodle": _moodle, "brightspace": _brightspace, "blackboard": _blackboard,
    "canvas": _canvas, "ilias": _ilias, "github": _github, "students": _by_student,
}  # fmt: skip
"""Asked in this order: whoever knows a file or folder first says whose it is."""


def only_folder(root: Path) -> Path | None:
    """Return the folder that is alone in a folder, as where an export was unpacked as it came."""
    inside = _entries(root)
    return inside[0] if len(inside) == 1 and not inside[0].is_symlink() and surely(inside[0].is_dir) else None


def handed_in(root: Path) -> list[Handed]:
    """Return what each file or folder in the folder of submissions is said to be."""
    left, submissions = _entries(root), list[Handed]()
    for layout in LAYOUTS.values():
        known = layout(root, left)
        submissions += known
        left = [path for path in left if path not in {handed.path for handed in known}]
    return [handed for handed in submissions if handed.ids or handed.name]


def _entries(root: Path) -> list[Path]:
    return sorted(path for path in root.iterdir() if not path.name.startswith((".", "__MACOSX")))


# --- Gradescope's list ---


@dataclass
class _Record:
    """A submission: its folder, when it was made, and by whom."""

    folder: str
    created: datetime.datetime | None = None
    people: list[dict[str, str]] = field(default_factory=list)


def _records(path: Path) -> Iterator[_Record]:
    """Yield what submission_metadata.yml says: the few lines of YAML that count, as Ruby writes them."""
    record, section = _Record(""), ""
    with path.open(encoding="utf-8", errors="replace") as file:
        for line in map(str.rstrip, file):
            if match := re.match(r"""(["']?)([^\s:"'-][^:"']*)\1:$""", line):
                if record.folder:
                    yield record
                record, section = _Record(match.group(2)), ""
            elif match := re.match(r"  :(\w+):\s*(.*)", line):
                section = match.group(1)
                if section == "created_at":
                    record.created = _time(_scalar(match.group(2)))
            elif section == "submitters" and (match := re.match(r"\s+(- )?:(\w+):\s*(.*)", line)):
                if match.group(1) or not record.people:
                    record.people.append({})
                record.people[-1][match.group(2)] = _scalar(match.group(3))
    if record.folder:
        yield record


def _scalar(text: str) -> str:
    """Return a YAML scalar as text."""
    if text[:1] == '"':
        try:
            return str(json.loads(text))
        except ValueError:
            return text.strip('"')
    return text[1:-1].replace("''", "'") if text[:1] == "'" and text[-1:] == "'" else text


def _time(text: str) -> datetime.datetime | None:
    """Return a time as Ruby or ISO 8601 writes it, as in 2026-11-21 22:05:07.123456789 Z; None where it is none."""
    match = re.match(r"(\d{4}-\d\d-\d\d)[T ](\d\d:\d\d:\d\d)(?:\.\d+)?\s*(Z|UTC|[+-]\d\d:?\d\d)?$", text)
    if not match:
        return None
    zone = match.group(3) or "Z"
    try:
        return datetime.datetime.fromisoformat(f"{match.group(1)}T{match.group(2)}{'Z' if zone == 'UTC' else zone}")
    except ValueError:
        return None
