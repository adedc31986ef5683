"""What an outlet is, and what it is given: an assignment, and how many variants of each problem are wanted."""

import tomllib
from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import PurePath
from typing import Literal

from qdot.exercises.assignment.assignment import FEEDBACK, Assignment
from qdot.exercises.assignment.draws import Failures, GivenUp
from qdot.exercises.common.errors import QdotError
from qdot.exercises.problem.problem import Part, Problem

SHEETS = ("handout", "exam", "key", "marking")
"""Problems to work on; with room to write in; for the staff, the answers in short, and what wrong ones earn, too."""
PAGES = ("a4", "letter")
"""Sizes of paper."""


Earns = Callable[[Problem, Part, str], Fraction]
"""What share of a part's points an answer earns, given as it is typed."""


def _refuse(given: GivenUp) -> None:
    raise QdotError(str(given))


def _nothing(*_: object) -> None:
    """Stand for whoever is told something: a function of a module, so that another process can be handed it."""


@dataclass(frozen=True)
class Order:
    """What is to be exported: `variants` of each problem where a platform draws from a bank.

    On paper: which `sheet` (of SHEETS), with worked `solutions` or not, for everybody on the roster or, without names,
    so many `versions`; the size of a `page` (of PAGES).
    `failures` certifies a problem; none leaves without that. `each` is told of every variant or student that is done,
    `note` of what the staff should know, `left_out` of who gets nothing, as no problem could be drawn. A marking sheet
    asks the grader what an answer `earns`. A package that reports scores is passed from the share `passing` on, where
    one is given.
    """

    assignment: Assignment
    failures: Failures
    variants: int = 20
    solutions: bool = False
    sheet: str = "handout"
    versions: int = 0
    page: str = "a4"
    jobs: int = 1
    each: Callable[[], None] = _nothing
    note: Callable[[str], None] = _nothing
    left_out: Callable[[GivenUp], None] = _refuse
    earns: Earns | None = None
    passing: Fraction | None = None

    def tells(self, what: str) -> bool:
        """Whether students may be told so much of their answers, of the levels FEEDBACK."""
        return FEEDBACK.index(what) <= FEEDBACK.index(self.assignment.feedback)

    @property
    def untold(self) -> "Order":
        """The same order, of which nobody is told anything: other processes can't tell those who are at this one."""
        return replace(self, each=_nothing, note=_nothing, left_out=_refuse, earns=None)


@dataclass(frozen=True)
class File:
    """A file of an export: its path in the output folder, with `/`, and what is in it.

    What is `private` holds answers, and only its owner may read it.
    """

    path: str
    content: str | bytes
    private: bool = False


def robots(order: Order) -> list[str]:
    """Return the files of an assignment's own robots, below its folder; those of the library come with qdot.

    Raises QdotError for a file elsewhere.
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
class Outlet:
    """A form in which an assignment is handed out: `--to NAME`.

    `title` says what comes out, `read_by` which program reads it, and `checked` what in our tests reads it as that
    would. It does its work once for every "variant", every "student", or "once". Problems that are drawn from
    assignment.toml again, where they are read, are `drawn_there`.

    Before anything is written, `check` raises QdotError for an order that can't be carried out anywhere, and `missing`
    returns what it needs that is not on this machine, and how to get it, "" where all is there.
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
        """Whether the variants of a bank are in its files, as they are."""
        return self.per == "variant" and not self.drawn_there

    def steps(self, order: Order) -> int:
        """Return how many times `order.each` is going to be told."""
        assignment = order.assignment
        return {
            "variant": len(assignment.slots) * order.variants, "once": 1,
            "student": order.versions or len(assignment.roster),
        }[self.per]  # fmt: skip
