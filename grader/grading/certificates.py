"""Read certificates/STUDENT/KEY.json, the record of a student's released problems, and compare notebooks with it.

The certificate contains a record of each problem:

- the problem's id, and the version of qdot and of its generator (the engine)
- digests (SHA-256) of the arm and of each part
- the difficulty, and the names of the checks that the problem passed; rounding errors differ between machines and are
  not recorded

The certificate also contains a digest of each cell of the released notebook. A later version of qdot may word a problem
differently, so only these digests show whether a notebook was altered. They don't cover answers and outputs.
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
from qdot.grader.submissions.cells import dict_or_empty, find_qdot_metadata


class FailureKind(StrEnum):
    """The reason why a problem fails, as the summary of `qdot verify` words it: "3 failed: 1 changed, 2 without …"."""

    CHANGED = "changed"
    UNSOUND = "not passing the checks"
    OTHER_ENGINE = "of another version"
    UNCERTIFIED = "without a certificate"
    DAMAGED = "with a damaged certificate"
    ALTERED = "in an altered notebook"
    NO_NOTEBOOK = "without a notebook"


@dataclass(frozen=True)
class Failure:
    """The failure of a problem. `message` names the student. `slot` is empty if all problems of the student fail."""

    kind: FailureKind
    message: str
    slot: str = ""


class ProblemRecord(pydantic.BaseModel):
    """The record of one problem in a certificate; fields that a later version adds are ignored.

    `sha256`, `arm` and `parts` are digests of the whole problem, of its arm, and of each part. `band` is the range of
    difficulties from which the problem was generated.
    """

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
    """The certificate of one student: a record for each slot, and a digest for each cell of the released notebook.

    `notebook_digest` identifies the settings of the assignment from which the notebook was made.
    """

    model_config = pydantic.ConfigDict(strict=True, frozen=True)
    assignment: str
    student: str
    notebook_digest: str
    notebook: dict[str, str]
    problems: dict[str, ProblemRecord]


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
        reason = ": ".join(filter(None, (".".join(map(str, first_error["loc"])), first_error["msg"])))
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
    else:
        if (certificate.assignment, certificate.student) == (assignment, student):
            return certificate
        reason = f"it belongs to {certificate.student} and {certificate.assignment!r}"
    raise QdotError(
        f"{path} is not a valid certificate of this student ({reason}), so qdot does not know what was released. "
        "Restore it from a backup. If there is none, delete it, run 'qdot generate' and release the notebook again"
    )


# --- the released notebook ---


def compute_cell_digests(notebook: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return pairs of a name and a digest for a notebook's metadata and for each cell, in the notebook's order.

    The digest of an answer cell covers the name of the part, but not the answer. Outputs, empty cells and ids are not
    covered, so a program that runs cells or drops their ids changes no digest. Certificates of earlier versions are
    compared with these digests, so this function must not change.
    """
    digests = [("metadata", _compute_digest(dict_or_empty(notebook.get("metadata")).get("qdot")))]
    for number, cell in enumerate(map(dict_or_empty, notebook["cells"]), 1):
        source = cell.get("source", "")
        text = "".join(map(str, source)) if isinstance(source, list) else str(source)
        part = find_qdot_metadata(cell).get("part")
        if part is not None or text.strip():
            name = str(cell.get("id") or f"cell {number}")
            digests.append((name, _compute_digest([cell.get("cell_type"), part, text if part is None else None])))
    return digests


def _compute_digest(content: Any) -> str:
    """Return the SHA-256 of data, written as JSON."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def find_notebook_failures(path: Path, certificate: StudentCertificate) -> list[Failure]:
    """Return one failure for each problem whose cells in a released notebook differ from the certificate.

    `path` is the path of the notebook. Cells that belong to no problem share one failure.
    """
    student = certificate.student
    try:
        notebook = json.loads(path.read_text(encoding="utf-8-sig"))
        if not isinstance(dict_or_empty(notebook).get("cells"), list):
            raise ValueError("it has no cells")
    except (FileNotFoundError, NotADirectoryError):
        message = f"{path} is missing, so it can't be compared with its certificate; restore it from a backup"
        return [Failure(FailureKind.NO_NOTEBOOK, f"{student}: {message}")]
    except (OSError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or error
        message = f"{path} is not a valid notebook ({reason}); restore it from a backup"
        return [Failure(FailureKind.ALTERED, f"{student}: {message}")]
    alterations_by_slot: dict[str, list[str]] = {}
    for cell, difference in _find_alterations(certificate.notebook, compute_cell_digests(notebook)):
        slot = cell.partition("-")[0]
        alterations_by_slot.setdefault(slot if slot in certificate.problems else "", []).append(f"{cell} {difference}")
    message = f"{student}: {path} has changed since its release. Restore it from a backup. Changes: "
    listings = {slot: ", ".join(cells) for slot, cells in alterations_by_slot.items()}
    return [Failure(FailureKind.ALTERED, message + listing, slot) for slot, listing in listings.items()]


def _find_alterations(
    recorded_digests: Mapping[str, str], present_digests: Sequence[tuple[str, str]]
) -> list[tuple[str, str]]:
    """Return pairs of a cell's name and a word for how the cell differs from the record, such as ("p1-1", "changed").

    `present_digests` are pairs of a cell's name and its digest, in the order of the notebook.
    """
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
