"""A student's result as rows, a part each, as reports for other programs need them."""

from collections.abc import Sequence
from dataclasses import dataclass

from qdot.exercises.assignment.assignment import FEEDBACK
from qdot.exercises.common.errors import QdotError
from qdot.exercises.quizzes import ASKED
from qdot.grader.grading.marking import number
from qdot.grader.grading.result import PartResult, Result
from qdot.grader.reports.feedback_levels import hold_back
from qdot.grader.reports.tables import NO_MARK, status

LONGEST = 4000
"""Characters of what is said of a part."""


@dataclass(frozen=True)
class Row:
    """A part: its name as in "p1.jacobian", its title, what came of it, and what is said of that in one paragraph.

    `points` are None where qdot itself failed: that is never a mark.
    """

    part: str
    title: str
    outcome: str
    points: float | None
    max_points: float
    message: str

    @property
    def passed(self) -> bool:
        """Whether all points were earned, or set by a person."""
        return self.points is not None and self.points >= self.max_points

    @property
    def earned(self) -> str:
        """The points in words, as in "1.5 of 2"."""
        return f"{'no mark' if self.points is None else number(self.points)} of {number(self.max_points)}"


def rows_of(result: Result, feedback: str = FEEDBACK[-1]) -> list[Row]:
    """Return a row for every part, in the order of the assignment; for students, with what `feedback` tells them."""
    return [
        Row(
            name, ASKED[part.name].title, part.outcome, part.points, part.max_points,
            _message(hold_back(part, feedback)),
        )
        for name, part in result.parts.items()
    ]  # fmt: skip


def _message(part: PartResult) -> str:
    override = part.override
    by_hand = ""
    if override is not None:
        what = "your instructor says" if override.points is None else "points set by your instructor"
        by_hand = f"{what}{': ' if override.comment else ''}{override.comment}"
    sentences = [text.rstrip(".") for text in (part.reason, part.advice, by_hand) if text]
    whole = " ".join(". ".join(sentences).split())
    return whole if len(whole) <= LONGEST else f"{whole[:LONGEST]} …"


def the_only(results: Sequence[Result], form: str) -> Result:
    """Return the result of the one student whom a report is of. Raises QdotError; also where a part has no mark."""
    if len(results) != 1:
        raise QdotError(f"--report {form} is of one student: name them with --student ID")
    if (state := status(results[0])) in NO_MARK:
        what = (
            "qdot failed on an answer" if state == "ungraded" else "a limit was exceeded by an answer or the notebook"
        )
        raise QdotError(f"{what} of {results[0].student}, so there is no mark for {form}")
    return results[0]


def lateness(result: Result) -> str:
    """Return what is taken off for lateness, in words; empty where nothing is late."""
    late = result.late
    if late is None:
        return ""
    if not late.penalty:
        return f"late (due {late.due}), which costs nothing"
    return f"late (due {late.due}): {100 * late.penalty:g} % of {number(late.points_before)} points taken off"
