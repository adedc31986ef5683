"""overrides.csv: what a person sets in the place of the grader's points, or adds to them, which every later run keeps.

Its columns are student, part (`p1.jacobian`; empty for the student's total), points and comment; and, if wanted, group:
a line that names a group of equal wrong answers (`grader.groups`) in the place of a student is for all who give them.
"""

import difflib
import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.errors import QdotError, unknown
from qdot.exercises.common.input_file import read_table
from qdot.grader.diagnosis.groups import LENGTH, LETTERS, group_key
from qdot.grader.grading.marking import points_of, total
from qdot.grader.grading.result import AppliedOverride

OVERRIDES = "overrides.csv"
COLUMNS = ("student", "part", "points", "comment")
HEADER = ",".join(COLUMNS)
GROUP = "group"
"""The column that may follow."""
TOTAL = ""
"""The part that stands for a student's total."""


@dataclass(frozen=True)
class Override:
    """What a person gives for a part, or in all, and what is said of it to the student.

    `points` are None where the grader's stay, and something is said. `group` is the key of the group of answers that it
    is for, None where it is for one student.
    """

    points: float | None
    comment: str = ""
    group: str | None = None

    def applied_to(self, points: float | None) -> AppliedOverride:
        """Return the override as results have it; `points` are what the grader gave, None where it failed."""
        return AppliedOverride(self.points, self.comment, points, self.group)


@dataclass(frozen=True)
class Overrides:
    """What overrides.csv says: by student and part, and by the key of a group; and on which line that stands."""

    of_students: Mapping[str, Mapping[str, Override]] = field(default_factory=dict)
    of_groups: Mapping[str, Override] = field(default_factory=dict)
    lines: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class _Line:
    """The cells of a line, as they are written."""

    student: str
    part: str
    points: str
    comment: str
    group: str


def read_overrides(assignment: Assignment) -> Overrides:
    """Return what overrides.csv of an assignment's folder says; nothing where there is no such file. Raises QdotError.

    Every line is checked against the roster and the assignment, so that none is without effect; who is in a group is
    known when all are graded (`without_answers`).
    """
    path = assignment.folder / OVERRIDES
    if not path.exists():
        return Overrides()
    most = {
        f"{slot.name}.{name}": points
        for slot in assignment.slots
        for name, points in zip(slot.questions, slot.max_points, strict=True)
    }
    most[TOTAL] = total(most.values())
    students = tuple(student.id for student in assignment.roster)
    of_students: dict[str, dict[str, Override]] = {}
    of_groups: dict[str, Override] = {}
    lines: dict[tuple[str, str], int] = {}
    for number, cells in _table(path):
        where = f"{path}: line {number}"
        line = _Line(*(unicodedata.normalize("NFC", cells.get(name, "").strip()) for name in (*COLUMNS, GROUP)))
        student, part, group = line.student, line.part, line.group
        if group and student:
            raise QdotError(
                f"{where}: it names the student {student!r} and the group {group!r}; a line is for one or the other, "
                "so leave one of the two cells empty"
            )
        if group:
            part, group = _group(where, part, group, tuple(most))
        elif student not in students:
            raise QdotError(f"{where}: no student {student!r} is in roster.csv")
        if part not in most:
            raise _unknown_part(where, part, tuple(most))
        whose = f"the group {group!r}" if group else f"{_named(part)} of {student!r}"
        if (known := lines.setdefault((student, group or part), number)) != number:
            raise QdotError(f"{where}: {whose} is set on line {known} already")
        if group:
            of_groups[group] = _of_group(where, group, part, line, most[part])
        else:
            points = _points(where, part, line.points, most[part])
            of_students.setdefault(student, {})[part] = Override(points, line.comment)
    of_lines = {group: number for (student, group), number in lines.items() if not student}
    return Overrides(of_students, of_groups, of_lines)


def without_answers(assignment: Assignment, overrides: Overrides, groups: Sequence[str]) -> list[str]:
    """Return what is told of lines for groups in which nobody's answer is; `groups` are those of the class."""
    notes = []
    for group in overrides.of_groups:
        if group not in groups:
            part, letters = group.split("/")
            of_part = [each for each in groups if each.split("/")[0] == part]
            close = difflib.get_close_matches(letters, [each.split("/")[1] for each in of_part], n=1, cutoff=0.7)
            hint = f" (did you mean {group_key(part, close[0])!r}?)" if close else ""
            known = f"groups of {part}: {_listed(of_part)}" if of_part else f"no answer to {part} is in a group"
            notes.append(
                f"{assignment.folder / OVERRIDES}: line {overrides.lines[group]}: no answer of this class is in the "
                f"group {group!r}{hint}, so the line does nothing yet; {known}"
            )
    return notes


MOST_LISTED = 8


def _listed(groups: Sequence[str]) -> str:
    more = len(groups) - MOST_LISTED
    return ", ".join(groups[:MOST_LISTED]) + (f" and {more} more, which `qdot report` shows" if more > 0 else "")


def _table(path: Path) -> list[tuple[int, dict[str, str]]]:
    table = read_table(path, COLUMNS[0], HEADER)
    for number, cells in table:
        if not {"part", "points"} <= set(cells):
            raise QdotError(f"{path}: line {number}: it has no cell for part or points; the columns are {HEADER}")
    return table


def _group(where: str, part: str, said: str, known: Sequence[str]) -> tuple[str, str]:
    """Return the part that a group is of, and its key; the cell may hold the letters alone where the part is named."""
    of, _, letters = said.rpartition("/")
    if not re.fullmatch(f"[{LETTERS}]{{{LENGTH}}}", letters.lower()) or not (of or part):
        raise QdotError(
            f"{where}: group = {said!r}: it is a key as `qdot report` shows it, a part and {LENGTH} letters, as in "
            f"{group_key(known[0], 'kqvxwz')}"
        )
    if of and of not in known:
        raise _unknown_part(where, of, known)
    if of and part and of != part:
        raise QdotError(f"{where}: the group {said!r} is of the part {of}, and the line names {part}; leave it empty")
    return of or part, group_key(of or part, letters.lower())


def _of_group(where: str, group: str, part: str, line: _Line, most: float) -> Override:
    if not line.points and not line.comment:
        raise QdotError(f"{where}: neither points nor a comment is given for the group {group!r}; give one, or both")
    points = _points(where, part, line.points, most) if line.points else None
    return Override(points, line.comment, group)


def _unknown_part(where: str, part: str, known: Sequence[str]) -> QdotError:
    named = tuple(name for name in known if name != TOTAL)
    return QdotError(f"{where}: {unknown('part', part, named)}; or empty, for the student's total")


def _points(where: str, part: str, text: str, most: float) -> float:
    number = text.replace(",", ".")  # as a spreadsheet may write it that separates by semicolons
    share = re.fullmatch(r"(\d+(?:\.\d{1,4})?) ?%", number)
    if share and Fraction(share[1]) <= 100:
        return points_of(most, 1.0, Fraction(share[1]) / 100)
    if not re.fullmatch(r"\d+(\.\d{1,4})?", number):
        raise QdotError(
            f"{where}: points = {text!r}: it is a number from 0 to {most:g}, with at most four decimals, as in 1.5, or "
            "a share of them, as in 50 %"
        )
    if float(number) > most:
        raise QdotError(f"{where}: points = {text}: {_named(part)} has {most:g} points at most")
    return float(number)


def _named(part: str) -> str:
    return part or "the total"
