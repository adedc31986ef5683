"""Read and compare certificates/STUDENT/KEY.json, which records a student's problems as they were released.

It has one record for each problem: its identity, the engine and version that generated it, digests of arm and parts,
difficulty, and the names of the checks it passed. Rounding errors differ between machines and are not recorded.

It also has a digest of each cell of the released notebook. The digests are necessary because a later version of qdot
may word a problem differently, so regenerating it doesn't show whether a notebook was altered. Answers and outputs are
not in the digests.
"""

import hashlib
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

import pydantic

from qdot.exercises.common.errors import QdotError


class Kind(StrEnum):
    """The reason why a problem fails, as the summary words it: "3 failed: 1 changed, 2 without …"."""

    CHANGED = "changed"
    UNSOUND = "not passing the checks"
    OTHER_ENGINE = "of another engine"
    UNCERTIFIED = "without a certificate"
    DAMAGED = "with a damaged certificate"
    ALTERED = "in an altered notebook"
    NO_NOTEBOOK = "without a notebook"


@dataclass(frozen=True)
class Failure:
    """A failure; `message` names the student, and `slot` is the slot of the problem, empty if it concerns all."""

    kind: Kind
    message: str
    slot: str = ""


class Record(pydantic.BaseModel):
    """The record of one problem; fields added by a later version are ignored."""

    model_config = pydantic.ConfigDict(strict=True, frozen=True)
    problem: str = pydantic.Field(pattern=r"^[a-z0-9-]+/[0-9]{1,19}(@[a-z+-]+){0,2}$")
    questions: tuple[str, ...]
    band: tuple[int, int] | None
    engine: int
    qdot: str
    difficulty: int
    sha256: str
    arm: str
    parts: dict[str, str]
    checks: tuple[str, ...]


class Certificate(pydantic.BaseModel):
    """The file of one student; `problems` has a record for each slot, `notebook` a digest for each cell by its name."""

    model_config = pydantic.ConfigDict(strict=True, frozen=True)
    assignment: str
    student: str
    edition: str
    notebook: dict[str, str]
    problems: dict[str, Record]

    @property
    def text(self) -> str:
        """The content of the file."""
        return self.model_dump_json(indent=1) + "\n"


def read_certificate(path: Path, assignment: str, student: str) -> Certificate | None:
    """Return a student's certificate; None if there is no file. Raises QdotError, which says what is wrong.

    The error never recommends only 'qdot generate', which would certify problems that may have changed.
    """
    try:
        certificate = Certificate.model_validate_json(path.read_text(encoding="utf-8-sig"))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except pydantic.ValidationError as error:
        first = error.errors()[0]
        location = ".".join(map(str, first["loc"]))
        raise _unreadable_certificate(path, f"{location}: {first['msg']}" if location else first["msg"]) from None
    except (OSError, UnicodeDecodeError) as error:
        raise _unreadable_certificate(path, getattr(error, "strerror", None) or "it is not UTF-8 text") from None
    if (certificate.assignment, certificate.student) != (assignment, student):
        raise _unreadable_certificate(path, f"it is that of {certificate.student} for {certificate.assignment!r}")
    return certificate


def _unreadable_certificate(path: Path, why: str) -> QdotError:
    return QdotError(
        f"{path} can't be read as this student's certificate ({why}): nothing says what was handed out. Restore it "
        "from a backup; failing that, delete it, run 'qdot generate' and hand its notebook out anew"
    )


def describe_missing(path: Path, notebook: Path) -> str:
    """Return the message on a missing certificate, depending on whether the notebook exists."""
    if not notebook.is_file():
        return (
            f"neither {path} nor {notebook} is there. If nothing was handed out yet, 'qdot generate' writes both; if "
            "it was, restore both from a backup"
        )
    return (
        f"{path} is missing: nothing says what was handed out. Restore it from a backup; 'qdot generate' writes "
        "notebook and certificate from what the problems are now, to be handed out anew"
    )


# --- the released notebook ---


def cell_digests(notebook: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return name and SHA-256 of everything that qdot wrote in a notebook: its metadata, then every cell in order.

    An answer cell's digest covers its part and not its content. Outputs, empty cells and ids are not covered, so a
    program that drops the ids of cells, or runs them, changes no digest. Certificates of earlier versions are compared
    with these digests, so this function must not change.
    """
    metadata = _dict(notebook.get("metadata")).get("qdot")
    digests = [("metadata", _digest(metadata))]
    for number, cell in enumerate(map(_dict, notebook["cells"]), 1):
        source = cell.get("source", "")
        text = "".join(map(str, source)) if isinstance(source, list) else str(source)
        part = _dict(_dict(cell.get("metadata")).get("qdot")).get("part")
        if part is not None or text.strip():
            name = str(cell.get("id") or f"cell {number}")
            digests.append((name, _digest([cell.get("cell_type"), part, text if part is None else None])))
    return digests


def _dict(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, Mapping) else {}


def _digest(content: Any) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def find_notebook_failures(path: Path, certificate: Certificate) -> list[Failure]:
    """Return how a notebook in released/ differs from its certificate, one failure for each problem concerned."""
    student = certificate.student
    try:
        notebook = json.loads(path.read_text(encoding="utf-8-sig"))
        if not isinstance(_dict(notebook).get("cells"), list):
            raise ValueError("it has no cells")
    except (FileNotFoundError, NotADirectoryError):
        message = f"{path} is missing, and can't be compared with what was handed out; restore it from a backup"
        return [Failure(Kind.NO_NOTEBOOK, f"{student}: {message}")]
    except (OSError, ValueError, RecursionError) as error:
        why = getattr(error, "strerror", None) or error
        message = f"{path} can't be read as a notebook ({why}); restore it from a backup"
        return [Failure(Kind.ALTERED, f"{student}: {message}")]
    concerned: dict[str, list[str]] = {}
    for cell, difference in find_alterations(certificate.notebook, cell_digests(notebook)):
        slot = cell.partition("-")[0]
        concerned.setdefault(slot if slot in certificate.problems else "", []).append(f"{cell} {difference}")
    message = f"{student}: {path} is not as it was handed out, restore it from a backup: "
    return [Failure(Kind.ALTERED, message + ", ".join(altered), slot) for slot, altered in concerned.items()]


def find_alterations(recorded: Mapping[str, str], present: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return the cells that differ from the recorded digests, each with how it differs."""
    present_cells = dict(present)
    digests = Counter(digest for _, digest in present)
    changed = {
        name: "changed" if name in present_cells else "gone" for name, digest in recorded.items() if not digests[digest]
    }
    unmatched = Counter(recorded.values())
    for name, digest in present:
        unmatched[digest] -= 1
        if unmatched[digest] < 0:
            changed.setdefault(name, "added")
    if not changed and [digest for _, digest in present] != list(recorded.values()):
        return [("cells", "in another order")]
    return list(changed.items())
