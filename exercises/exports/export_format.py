"""Define export formats, and the request for an export: an assignment, and how to export it."""

from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Literal

from qdot.exercises.assignment.assignment import FEEDBACK_LEVELS, Assignment
from qdot.exercises.assignment.certified_problems import FailedSlot, FailureFinder
from qdot.exercises.common.errors import QdotError
from qdot.exercises.problem.problem import Part, Problem

SHEET_KINDS = ("handout", "exam", "key", "marking")
"""Kinds of sheets: problems; problems with writing space; correct answers; the points for wrong answers.

The last two kinds are for staff.
"""
PAPER_SIZES = ("a4", "letter")
DEFAULT_ATTEMPTS = 3
"""Number of attempts at a question on platforms that limit attempts, unless the assignment sets another number."""

ShareOfTypedAnswer = Callable[[Problem, Part, str], Fraction]
"""A function that returns the share of a part's points that a typed answer earns."""


def _raise_failure(failure: FailedSlot) -> None:
    raise QdotError(str(failure))


def _refuse_share(*_: object) -> Fraction:
    raise QdotError("points for wrong answers need the grader; run qdot export DIR")


def _ignore(*_: object) -> None:
    """Do nothing. This is not a lambda, because other processes must be able to unpickle it."""


@dataclass(frozen=True)
class ExportRequest:
    """A request for an export. A bank has `variant_count` variants of each problem.

    - `sheet` (one of `SHEET_KINDS`) and `paper_size` (one of `PAPER_SIZES`) are for exports to paper.
    - `version_count` is how many versions of a sheet to make; versions carry no student names. If it is 0, each student
      gets a sheet.
    - `has_solutions` adds worked solutions.
    - `find_failures` returns the failed checks of a problem; a problem with failed checks is never exported.
    - `on_step` is called after every variant or student, and `on_left_out` for each student without a problem.
    - `report` is called with messages to the staff.
    - `compute_earned_share` returns the share of the points that the grader gives for an answer. Marking sheets and
      STACK need it.
    - `passing_share` is the share of the points that a student needs to pass; None if there is no such limit.
    """

    assignment: Assignment
    find_failures: FailureFinder
    variant_count: int = 20
    has_solutions: bool = False
    sheet: str = "handout"
    version_count: int = 0
    paper_size: str = "a4"
    jobs: int = 1
    on_step: Callable[[], None] = _ignore
    report: Callable[[str], None] = _ignore
    on_left_out: Callable[[FailedSlot], None] = _raise_failure
    compute_earned_share: ShareOfTypedAnswer = _refuse_share
    passing_share: Fraction | None = None

    @property
    def attempt_count(self) -> int:
        """The number of attempts at a question on platforms that limit attempts."""
        return self.assignment.attempt_policy.best_of or DEFAULT_ATTEMPTS

    def includes_feedback(self, level: str) -> bool:
        """Return whether the assignment's feedback includes this level of FEEDBACK_LEVELS."""
        return FEEDBACK_LEVELS.index(level) <= FEEDBACK_LEVELS.index(self.assignment.feedback)

    def without_text_questions(self, title: str) -> "ExportRequest":
        """Return the request without questions that a person must mark. Report these, with the export's title."""
        assignment, names = self.assignment.without_text_questions()
        if names:
            self.report(f"{title} leaves out {', '.join(names)}, because a person must mark these answers")
        return replace(self, assignment=assignment)

    @property
    def without_callbacks(self) -> "ExportRequest":
        """The same request without its callbacks, because other processes could not call them."""
        return replace(self, on_step=_ignore, report=_ignore, on_left_out=_raise_failure)


@dataclass(frozen=True)
class ExportedFile:
    """A file of an export: its path in the output folder, with `/`, and its content.

    If `is_private`, the file contains answers, and only its owner may read it.
    """

    path: str
    content: str | bytes
    is_private: bool = False


@dataclass(frozen=True)
class ExportFormat:
    """An export format, selected by `--to NAME`.

    `title` describes the exported files, and `read_by` names the program that reads them. Progress is counted in
    `progress_unit`, a "variant" or a "student". `regenerates_problems` means that the platform regenerates the problems
    from assignment.toml.

    Before anything is written, `check` raises QdotError if the request is impossible. `explain_missing` returns
    which program this machine lacks and how to install it, or "".
    """

    name: str
    title: str
    read_by: str
    progress_unit: Literal["variant", "student"]
    export: Callable[[ExportRequest], Generator[ExportedFile, None, None]]
    regenerates_problems: bool = False
    check: Callable[[ExportRequest], object] = lambda _: None
    explain_missing: Callable[[], str] = lambda: ""

    @property
    def contains_bank(self) -> bool:
        """Whether the exported files contain the variants of a bank."""
        return self.progress_unit == "variant" and not self.regenerates_problems

    def count_steps(self, request: ExportRequest) -> int:
        """Return how many times `request.on_step` will be called."""
        assignment = request.assignment
        if self.progress_unit == "student":
            return request.version_count or len(assignment.roster)
        return len(assignment.slots) * request.variant_count
