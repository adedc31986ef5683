"""The file certificates/STUDENT/KEY.json: what is kept of a student's problems, and what can be wrong with it.

One record for each problem: its identity, the engine and version that made it, digests of arm and parts, difficulty,
and the names of the checks it passed. Figures such as rounding errors differ between machines and are not kept.
"""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import pydantic

from exercises.errors import QdotError


class Kind(StrEnum):
    """Why a problem can't be vouched for, in the words of the summary: "3 failed: 1 changed, 2 without …"."""

    CHANGED = "changed"
    UNSOUND = "not passing the checks"
    OTHER_ENGINE = "of another engine"
    UNCERTIFIED = "without a certificate"
    DAMAGED = "with a damaged certificate"


@dataclass(frozen=True)
class Failure:
    """What is wrong, as a line that says whose it is; `slot` is the problem concerned, empty for all of them."""

    kind: Kind
    said: str
    slot: str = ""


class Record(pydantic.BaseModel):
    """What is kept of one problem; what a later version adds is passed over."""

    model_config = pydantic.ConfigDict(strict=True, frozen=True)
    problem: str = pydantic.Field(pattern=r"^[a-z0-9-]+/[0-9]{1,19}$")
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
    """The file of one student; `problems` has a record for each slot."""

    model_config = pydantic.ConfigDict(strict=True, frozen=True)
    assignment: str
    student: str
    edition: str
    problems: dict[str, Record]

    @property
    def text(self) -> str:
        """The file's text."""
        return self.model_dump_json(indent=1) + "\n"


def read_certificate(path: Path, assignment: str, student: str) -> Certificate | None:
    """Return a student's certificate, None where there is no file. Raises QdotError: what is wrong, and what to do.

    It never sends the reader to 'qdot generate' alone, which would vouch for whatever the problems have become.
    """
    try:
        certificate = Certificate.model_validate_json(path.read_text(encoding="utf-8-sig"))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except pydantic.ValidationError as error:
        found = error.errors()[0]
        where = ".".join(map(str, found["loc"]))
        raise _unreadable(path, f"{where}: {found['msg']}" if where else found["msg"]) from None
    except (OSError, UnicodeDecodeError) as error:
        raise _unreadable(path, getattr(error, "strerror", None) or "it is not UTF-8 text") from None
    if (certificate.assignment, certificate.student) != (assignment, student):
        raise _unreadable(path, f"it is that of {certificate.student} for {certificate.assignment!r}")
    return certificate


def _unreadable(path: Path, why: str) -> QdotError:
    return QdotError(
        f"{path} can't be read as this student's certificate ({why}): nothing says what was handed out. Restore it "
        "from a backup; failing that, delete it, run 'qdot generate' and hand its notebook out anew"
    )


def missing(path: Path) -> str:
    """Return what is said of a certificate that isn't there."""
    return (
        f"{path} is missing: nothing says what was handed out. Restore it from a backup; 'qdot generate' writes "
        "notebook and certificate from what the problems are now, to be handed out anew"
    )
