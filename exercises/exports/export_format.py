"""The definition of an export format, and the `Order` that it receives: an assignment and how to export it."""

import io
import tomllib
import zipfile
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import PurePath
from typing import Literal

from qdot.exercises.assignment.assignment import FEEDBACK, Assignment
from qdot.exercises.assignment.draws import FailedSlot, Failures
from qdot.exercises.common.errors import QdotError
from qdot.exercises.problem.problem import Part, Problem

SHEETS = ("handout", "exam", "key", "marking")
"""Kinds of sheets: problems; problems with writing space; short answers; points of wrong answers (both for staff)."""
PAGES = ("a4", "letter")
"""Sizes of paper."""

Earns = Callable[[Problem, Part, str], Fraction]
"""A function that returns the share of a part's points that a typed answer earns."""


def _refuse(failure: FailedSlot) -> None:
    raise QdotError(str(failure))


def _ignore(*_: object) -> None:
    """Ignore a report. This is a module-level function, because other processes must be able to unpickle it."""


@dataclass(frozen=True)
class Order:
    """A request for an export. If a platform picks problems from a bank, it gets `variants` of each problem.

    For paper: `sheet` is the kind of sheet (one of SHEETS), `solutions` adds worked solutions, and `page` is the paper
    size (one of PAGES). Sheets are for everybody on the roster, or in several `versions` without names.
    `failures` certifies a problem; a problem that fails is never exported. `each` is called after every variant or
    student, `note` with messages to the staff, and `left_out` for each student without a problem. `earns` is the
    grader's share of points for an answer, for marking sheets. `passing` is the share of the points needed to pass, if
    there is one.
    """

    assignment: Assignment
    failures: Failures
    variants: int = 20
    solutions: bool = False
    sheet: str = "handout"
    versions: int = 0
    page: str = "a4"
    jobs: int = 1
    each: Callable[[], None] = _ignore
    note: Callable[[str], None] = _ignore
    left_out: Callable[[FailedSlot], None] = _refuse
    earns: Earns | None = None
    passing: Fraction | None = None

    def tells(self, what: str) -> bool:
        """Return whether the assignment's feedback includes this level of FEEDBACK."""
        return FEEDBACK.index(what) <= FEEDBACK.index(self.assignment.feedback)

    @property
    def without_callbacks(self) -> "Order":
        """The same order without its callbacks: other processes could not call them."""
        return replace(self, each=_ignore, note=_ignore, left_out=_refuse)


@dataclass(frozen=True)
class File:
    """A file of an export: its path in the output folder, with `/`, and its content.

    A `private` file contains answers, and only its owner may read it.
    """

    path: str
    content: str | bytes
    private: bool = False


def archive(files: Mapping[str, str | bytes], modes: Mapping[str, int] = {}) -> bytes:
    """Return a zip archive whose bytes depend only on the files. `modes` has the permissions that are not 0o644."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as zip_file:
        for path, content in files.items():
            info = zipfile.ZipInfo(path, date_time=(1980, 1, 1, 0, 0, 0))
            info.compress_type, info.create_system = zipfile.ZIP_DEFLATED, 3
            info.external_attr = modes.get(path, 0o644) << 16
            zip_file.writestr(info, content.encode() if isinstance(content, str) else content)
    return out.getvalue()


def robots(order: Order) -> list[str]:
    """Return the names of the robot files in an assignment's folder. Robots of the library come with qdot.

    Raises QdotError for a file outside of the folder.
    """
    assignment = order.assignment
    content = tomllib.loads((assignment.folder / "assignment.toml").read_text(encoding="utf-8"))
    names = list(dict.fromkeys(entry["robot"] for entry in content["problem"] if "robot" in entry))
    for name in names:
        if PurePath(name).is_absolute() or ".." in PurePath(name).parts:
            raise QdotError(
                f"robot = {name!r} lies outside of {assignment.folder}; put it there, so that it can be exported"
            )
    return [PurePath(name).as_posix() for name in names if (assignment.folder / name).is_file()]


@dataclass(frozen=True)
class ExportFormat:
    """An export format, selected by `--to NAME`.

    `title` describes the files, `read_by` names the program that reads them, and `checked` the program that reads them
    in our tests. `per` says how often the work is done: for every "variant", for every "student", or "once".
    `drawn_there` means that the platform regenerates the problems from assignment.toml.

    Before anything is written, `check` raises QdotError if the order can't be carried out on any machine. `missing`
    returns what this machine lacks and how to install it, or "".
    """

    name: str
    title: str
    read_by: str
    checked: str
    per: Literal["variant", "student", "once"]
    files: Callable[[Order], Generator[File, None, None]]
    drawn_there: bool = False
    check: Callable[[Order], object] = lambda _: None
    missing: Callable[[], str] = lambda: ""

    @property
    def holds_a_bank(self) -> bool:
        """Whether its files contain the variants of a bank."""
        return self.per == "variant" and not self.drawn_there

    def steps(self, order: Order) -> int:
        """Return how many times `order.each` will be called."""
        assignment = order.assignment
        return {
            "variant": len(assignment.slots) * order.variants, "once": 1,
            "student": order.versions or len(assignment.roster),
        }[self.per]  # fmt: skip
