"""Read and compare certificates/STUDENT/KEY.json, which records a student's problems as they were released.

It contains one record per problem: its identity, the engine and version that generated it, digests of its arm and
parts, its difficulty, and the names of the checks that it passed. Rounding errors differ between machines and are not
recorded.

It also contains a digest of each cell of the released notebook. A later version of qdot may word a problem differently,
so only the digests show whether a notebook was altered. They don't cover answers and outputs.
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


class FailureKind(StrEnum):
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
    """The failure of a problem. `message` names the student; `slot` is empty if all the student's problems fail."""

    kind: FailureKind
    message: str
    slot: str = ""


class ProblemRecord(pydantic.BaseModel):
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


class StudentCertificate(pydantic.BaseModel):
    """The certificate file of one student: a record for each slot, and a digest for each cell of the notebook."""

    model_config = pydantic.ConfigDict(strict=True, frozen=True)
    assignment: str
    student: str
    edition: str
    notebook: dict[str, str]
    problems: dict[str, ProblemRecord]

    @property
    def text(self) -> str:
        """The content of the file."""
        return self.model_dump_json(indent=1) + "\n"


def read_certificate(path: Path, assignment: str, student: str) -> StudentCertificate | None:
    """Return a student's certificate; None if there is no file. Raises QdotError if the file is not valid.

    The message never recommends only 'qdot generate', which would certify problems that may have changed.
    """
    try:
        certificate = StudentCertificate.model_validate_json(path.read_text(encoding="utf-8-sig"))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except pydantic.ValidationError as error:
        first_error = error.errors()[0]
        words = filter(None, (".".join(map(str, first_error["loc"])), first_error["msg"]))
        raise _unreadable_certificate(path, ": ".join(words)) from None
    except (OSError, UnicodeDecodeError) as error:
        raise _unreadable_certificate(path, getattr(error, "strerror", None) or "it is not UTF-8 text") from None
    if (certificate.assignment, certificate.student) != (assignment, student):
        raise _unreadable_certificate(path, f"it belongs to {certificate.student} and {certificate.assignment!r}")
    return certificate


def _unreadable_certificate(path: Path, reason: str) -> QdotError:
    return QdotError(
        f"{path} is not a valid certificate of this student ({reason}), so qdot does not know what was released. "
        "Restore it from a backup. If there is none, delete it, run 'qdot generate' and release the notebook again"
    )


def describe_missing(path: Path, notebook: Path) -> str:
    """Return the message on a missing certificate, which depends on whether the notebook exists."""
    if not notebook.is_file():
        return (
            f"{path} and {notebook} are missing. If nothing was released yet, run 'qdot generate' to write both. "
            "Otherwise restore both from a backup"
        )
    return (
        f"{path} is missing, so qdot does not know what was released. Restore it from a backup. 'qdot generate' would "
        "write a new notebook and certificate from the current problems, which you would have to release again"
    )


# --- the released notebook ---


def cell_digests(notebook: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the name and the SHA-256 of each piece that qdot wrote in a notebook: its metadata, then its cells.

    The digest of an answer cell covers the name of its part, but not the answer. Outputs, empty cells and ids are not
    covered, so a program that runs cells or drops their ids changes no digest. Certificates of earlier versions are
    compared with these digests, so this function must not change.
    """
    metadata = _as_mapping(notebook.get("metadata")).get("qdot")
    digests = [("metadata", _digest(metadata))]
    for number, cell in enumerate(map(_as_mapping, notebook["cells"]), 1):
        source = cell.get("source", "")
        text = "".join(map(str, source)) if isinstance(source, list) else str(source)
        part = _as_mapping(_as_mapping(cell.get("metadata")).get("qdot")).get("part")
        if part is not None or text.strip():
            name = str(cell.get("id") or f"cell {number}")
            digests.append((name, _digest([cell.get("cell_type"), part, text if part is None else None])))
    return digests


def _as_mapping(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, Mapping) else {}


def _digest(content: Any) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def find_notebook_failures(path: Path, certificate: StudentCertificate) -> list[Failure]:
    """Return one failure for each problem whose cells in a notebook of released/ differ from the certificate."""
    student = certificate.student
    try:
        notebook = json.loads(path.read_text(encoding="utf-8-sig"))
        if not isinstance(_as_mapping(notebook).get("cells"), list):
            raise ValueError("it has no cells")
    except (FileNotFoundError, NotADirectoryError):
        message = f"{path} is missing, so it can't be compared with its certificate; restore it from a backup"
        return [Failure(FailureKind.NO_NOTEBOOK, f"{student}: {message}")]
    except (OSError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or error
        message = f"{path} is not a valid notebook ({reason}); restore it from a backup"
        return [Failure(FailureKind.ALTERED, f"{student}: {message}")]
    alterations_by_slot: dict[str, list[str]] = {}
    for cell, difference in find_alterations(certificate.notebook, cell_digests(notebook)):
        slot = cell.partition("-")[0]
        alterations_by_slot.setdefault(slot if slot in certificate.problems else "", []).append(f"{cell} {difference}")
    message = f"{student}: {path} has changed since its release, restore it from a backup: "
    return [
        Failure(FailureKind.ALTERED, message + ", ".join(cells), slot) for slot, cells in alterations_by_slot.items()
    ]


def find_alterations(
    recorded_digests: Mapping[str, str], present_digests: Sequence[tuple[str, str]]
) -> list[tuple[str, str]]:
    """Return the names of the cells that differ from the recorded digests, each with a word for the difference."""
    present_cells = dict(present_digests)
    digests = {digest for _, digest in present_digests}
    changed_names = [name for name, digest in recorded_digests.items() if digest not in digests]
    differences = {name: "changed" if name in present_cells else "missing" for name in changed_names}
    unmatched_counts = Counter(recorded_digests.values())
    for name, digest in present_digests:
        unmatched_counts[digest] -= 1
        if unmatched_counts[digest] < 0:
            differences.setdefault(name, "added")
    if not differences and [digest for _, digest in present_digests] != list(recorded_digests.values()):
        return [("cells", "in another order")]
    return list(differences.items())
