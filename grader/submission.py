"""What was handed in: found in the folder of submissions, read, and told apart from what can't be graded."""

import datetime
import hashlib
import json
import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import nbformat

from exercises.assignment import Assignment
from exercises.errors import QdotError
from exercises.problem import variable

LARGEST = 50_000_000


class Unreadable(Exception):
    """A submission that can't be graded at all; the text says why, to the student."""


@dataclass(frozen=True)
class Submission:
    """A notebook as handed in: code cells, the part that each was made for, and what its metadata claims."""

    file: Path
    sha256: str
    received: datetime.datetime
    cells: tuple[str, ...]
    parts: tuple[str | None, ...]
    claims: Mapping[str, Any]


@dataclass(frozen=True)
class Found:
    """The notebooks of one student, the one to grade first."""

    files: tuple[Path, ...]


def find_submissions(assignment: Assignment, root: Path) -> tuple[dict[str, Found], list[str]]:
    """Return what each student handed in, and the names in the folder that belong to nobody on the roster.

    `root/STUDENT/*.ipynb` or `root/STUDENT.ipynb`. Of several, the one with the assignment's file name goes first, else
    the one whose metadata name the assignment, else the first by name. Raises QdotError where `root` is no folder.
    """
    if not root.exists():
        raise QdotError(f"{root} does not exist; put what was handed in there, as STUDENT/*.ipynb or STUDENT.ipynb")
    if not root.is_dir():
        raise QdotError(f"{root} is not a folder of submissions; it holds STUDENT/*.ipynb or STUDENT.ipynb")
    by_id = {student.id: student.id for student in assignment.roster}
    found: dict[str, list[Path]] = {}
    strangers = []
    for path in sorted(root.iterdir()):
        if path.name.startswith("."):
            continue
        name = path.name if path.is_dir() else path.stem
        if not path.is_dir() and path.suffix != ".ipynb":
            continue
        if name not in by_id:
            strangers.append(path.name)
            continue
        notebooks = sorted(path.glob("*.ipynb")) if path.is_dir() else [path]
        found.setdefault(name, []).extend(p for p in notebooks if p.is_file() and not p.name.startswith("."))
    return {name: Found(tuple(_best_first(files, assignment))) for name, files in found.items() if files}, strangers


def _best_first(files: Sequence[Path], assignment: Assignment) -> list[Path]:
    if len(files) == 1:
        return list(files)
    mark = f'"assignment": "{assignment.key}"'

    def rank(path: Path) -> tuple[bool, bool, str]:
        try:
            named = mark in path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError):
            named = False
        return (path.name != f"{assignment.key}.ipynb", not named, path.name)

    return sorted(files, key=rank)


def read_submission(path: Path) -> Submission:
    """Read a notebook. Raises Unreadable with a reason for whatever is none."""
    try:
        data = path.read_bytes() if path.stat().st_size <= LARGEST else None
        received = datetime.datetime.fromtimestamp(int(path.stat().st_mtime), datetime.UTC)
    except OSError as error:
        raise Unreadable(f"{path.name} can't be read: {error.strerror}") from None
    if data is None:
        raise Unreadable(
            f"{path.name} is larger than {LARGEST // 1_000_000} MB; clear its outputs and hand it in again"
        )
    notebook = _notebook(path.name, data)
    claims = _plain(notebook.get("metadata", {})).get("qdot", {})
    code = [cell for cell in notebook.cells if cell.get("cell_type") == "code"]
    return Submission(
        path, hashlib.sha256(data).hexdigest(), received,
        tuple(_source(cell) for cell in code), tuple(_part(cell) for cell in code),
        claims if isinstance(claims, dict) else {},
    )  # fmt: skip


def _notebook(name: str, data: bytes) -> Any:
    """Return the notebook. What is wrong is told in our own words: the libraries' quote the file's innards."""
    if not data.strip():
        raise Unreadable(f"{name} is empty")
    try:
        text = data.decode("utf-8-sig")
        json.loads(text)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            notebook = nbformat.reads(text, as_version=4)
        if isinstance(notebook.get("cells"), list):
            return notebook
    except UnicodeDecodeError:
        raise Unreadable(f"{name} is not a Jupyter notebook: it is not text") from None
    except json.JSONDecodeError as error:
        raise Unreadable(f"{name} is not a Jupyter notebook, or was cut off (line {error.lineno})") from None
    except RecursionError:
        raise Unreadable(f"{name} is not a Jupyter notebook: it nests too deeply") from None
    except Exception:  # noqa: S110 - nbformat raises many kinds, all of them about the file
        pass
    raise Unreadable(f"{name} is not a Jupyter notebook: it is JSON, but has no cells that can be read")


def _plain(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _source(cell: Any) -> str:
    source = cell.get("source", "")
    return "".join(map(str, source)) if isinstance(source, list) else str(source)


def _part(cell: Any) -> str | None:
    part = _plain(_plain(cell.get("metadata")).get("qdot")).get("part")
    return part if isinstance(part, str) else None


def wrong_assignment(submission: Submission, assignment: Assignment) -> str | None:
    """Return the reason why a notebook is not of this assignment, if its metadata say so."""
    claimed = submission.claims.get("assignment")
    if isinstance(claimed, str) and claimed != assignment.key:
        return f"this notebook belongs to the assignment {claimed[:80]!r}, and {assignment.key!r} is graded here"
    return None


OTHER_EDITION = "made from another assignment.toml or secret than what is graded with"


@dataclass(frozen=True)
class Note:
    """Something odd about a submission, in words for the staff and in words for the student (who may see none)."""

    staff: str
    student: str = ""


def oddities(submission: Submission, assignment: Assignment, student: str) -> list[Note]:
    """Return what the metadata make odd; they decide nothing: the problems graded are this student's all the same."""
    claims, notes = submission.claims, []
    claimed = claims.get("student")
    if isinstance(claimed, str) and claimed != student:
        said = "this notebook was handed out to somebody else; it was graded against your own problems"
        notes.append(Note(f"the notebook was handed out to {claimed[:80]!r}", said))
    if claims.get("kind") == "solution":
        notes.append(Note("the notebook is the staff's, with the solutions"))
    digest = claims.get("digest")
    if isinstance(digest, str) and digest != assignment.digest:
        said = "this notebook was made from another version of the assignment; ask your instructor for the right one"
        notes.append(Note(OTHER_EDITION, said))
    return notes


def cell_of(submission: Submission, slot: str, part: str) -> int | None:
    """Return the index of the code cell that answers a part: by its metadata, failing that by its assignment."""
    if f"{slot}.{part}" in submission.parts:
        return submission.parts.index(f"{slot}.{part}")
    pattern = re.compile(rf"(?m)^\s*{re.escape(variable(slot, part))}\s*=(?!=)")
    return next((i for i, source in enumerate(submission.cells) if pattern.search(source)), None)
