"""Convert a student's result to rows, one for each part, for the reports that other programs read."""

from collections.abc import Sequence
from dataclasses import dataclass

from qdot.exercises.assignment.assignment import FEEDBACK_LEVELS, Assignment
from qdot.exercises.assignment.late_rule import describe_duration
from qdot.exercises.common.errors import QdotError, shorten
from qdot.exercises.mistakes.base import add_chapter_to_citation
from qdot.grader.grading.result import Override, Result
from qdot.grader.marking.marking import format_points
from qdot.grader.reports.feedback_levels import capitalize, limit_feedback
from qdot.grader.reports.grades_table import REASONS_WITHOUT_MARK, UNMARKED_STATUSES, find_work_status

MAX_MESSAGE_LENGTH = 4000
"""Maximum number of characters of the message on a part."""


@dataclass(frozen=True)
class PartRow:
    """The result for a part.

    `part` is the name of the part, such as "p1.jacobian". `points` is None if qdot failed to grade the part. `message`
    is the feedback in one paragraph.
    """

    part: str
    title: str
    outcome: str
    points: float | None
    max_points: float
    message: str

    @property
    def has_full_points(self) -> bool:
        """Whether the part has all its points, earned or set by a person."""
        return self.points is not None and self.points >= self.max_points

    @property
    def description(self) -> str:
        """The outcome with the message, unless the message only repeats it."""
        return self.outcome if self.message == "right" else f"{self.outcome}: {self.message}"

    @property
    def points_text(self) -> str:
        """The points as text, for example "1.5 of 2"."""
        return f"{'no mark' if self.points is None else format_points(self.points)} of {format_points(self.max_points)}"


def make_part_rows(result: Result, assignment: Assignment, feedback: str = FEEDBACK_LEVELS[-1]) -> list[PartRow]:
    """Return a row for every part, in the order of the assignment, with what a level of feedback shows."""
    rows, titles = [], assignment.titles_by_part
    for name, part in result.parts.items():
        shown_part = limit_feedback(part, feedback)
        override_text = "" if part.override is None else describe_override(part.override)
        texts = list(filter(None, (shown_part.advice, shown_part.reason, override_text)))
        sentences = [f"{capitalize(text)}{'' if text.endswith(('.', '?')) else '.'}" for text in texts]
        paragraph = " ".join(" ".join(sentences if len(texts) > 1 else texts).split())
        message = shorten(add_chapter_to_citation(paragraph.removesuffix(".")), MAX_MESSAGE_LENGTH)
        rows.append(PartRow(name, titles.get(name, name), part.outcome, part.points, part.max_points, message))
    return rows


def get_only_result(results: Sequence[Result]) -> Result:
    """Return the only student's result. Raises QdotError if there are several students, or if a part has no mark."""
    if len(results) != 1:
        raise QdotError("--report gradescope contains only one student; add --student ID")
    if (status := find_work_status(results[0])) in UNMARKED_STATUSES:
        raise QdotError(f"{results[0].student} has no mark for gradescope: {REASONS_WITHOUT_MARK[status]}")
    return results[0]


def list_notes(result: Result) -> list[str]:
    """Return the notes for a student on the whole result, including the late penalty and an override of the total."""
    return [*filter(None, result.notes), *describe_decisions(result)]


def describe_decisions(result: Result) -> list[str]:
    """Return notes for a student on the late penalty and on an override of the total."""
    notes, late = list[str](), result.late
    if late is not None:
        penalty = f"{100 * late.penalty:.4g} % of your {_format_points_with_unit(late.points_before)}"
        deduction = f": you lose {penalty}" if late.penalty and late.points_before else ""
        notes.append(f"Submitted {describe_duration(late.seconds)} after the due date{deduction}")
    return notes if result.override is None else [*notes, describe_override(result.override, " in total")]


def describe_override(override: Override, purpose: str = "") -> str:
    """Return a note for a student on an override; `purpose` says what the points are for, as in " in total"."""
    if override.points is None:
        return f"Your instructor says: {override.comment}"
    points = _format_points_with_unit(override.points)
    ending = f": {override.comment}" if override.comment else "."
    return f"Your instructor gave {points}{purpose}{ending}"


def _format_points_with_unit(points: float) -> str:
    return f"{round(points, 2):g} {'point' if points == 1 else 'points'}"
