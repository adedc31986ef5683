"""overrides.csv: points that a person sets in the place of the grader's, which every later run of the grader keeps.

Its columns are student, part (`p1.jacobian`; empty for the student's total), points and comment.
"""

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from exercises.assignment import Assignment
from exercises.errors import QdotError, unknown
from exercises.input_file import read_table
from grader.marking import total

OVERRIDES = "overrides.csv"
COLUMNS = ("student", "part", "points", "comment")
HEADER = ",".join(COLUMNS)
TOTAL = ""
"""The part that stands for a student's total."""


@dataclass(frozen=True)
class Override:
    """What a person gives for a part, or in all, and what is said of it to the student."""

    points: float
    comment: str = ""

    def as_json(self, was: float | None) -> dict[str, Any]:
        """Return the form of results.jsonl; `was` is what the grader gave, None where it failed."""
        return {"points": self.points, "comment": self.comment, "was": was}


Overrides = Mapping[str, Mapping[str, Override]]
"""By student and part."""


def read_overrides(assignment: Assignment) -> Overrides:
    """Return what overrides.csv of an assignment's folder says; nothing where there is no such file. Raises QdotError.

    Every line is checked against the roster and the assignment, so that none is without effect.
    """
    path = assignment.folder / OVERRIDES
    if not path.exists():
        return {}
    parts = {
        f"{slot.name}.{name}": points
        for slot in assignment.slots
        for name, points in zip(slot.questions, slot.max_points, strict=True)
    }
    parts[TOTAL] = total(parts.values())
    students = tuple(student.id for student in assignment.roster)
    overrides: dict[str, dict[str, Override]] = {}
    lines: dict[tuple[str, str], int] = {}
    for number, cells in _table(path):
        where = f"{path}: line {number}"
        student, part, points, comment = (unicodedata.normalize("NFC", cells.get(name, "").strip()) for name in COLUMNS)
        if student not in students:
            raise QdotError(f"{where}: no student {student!r} is in roster.csv")
        if part not in parts:
            known = tuple(name for name in parts if name != TOTAL)
            raise QdotError(f"{where}: {unknown('part', part, known)}; or empty, for the student's total")
        if (student, part) in lines:
            raise QdotError(f"{where}: {_named(part)} of {student!r} is set on line {lines[student, part]} already")
        lines[student, part] = number
        overrides.setdefault(student, {})[part] = Override(_points(where, part, points, parts[part]), comment)
    return overrides


def _table(path: Path) -> list[tuple[int, dict[str, str]]]:
    table = read_table(path, COLUMNS[0], HEADER)
    for number, cells in table:
        if not {"part", "points"} <= set(cells):
            raise QdotError(f"{path}: line {number}: it has no cell for part or points; the columns are {HEADER}")
    return table


def _points(where: str, part: str, said: str, most: float) -> float:
    number = said.replace(",", ".")  # as a spreadsheet may write it that separates by semicolons
    if not re.fullmatch(r"\d+(\.\d{1,4})?", number):
        raise QdotError(
            f"{where}: points = {said!r}: it is a number from 0 to {most:g}, with at most four decimals, as in 1.5"
        )
    if float(number) > most:
        raise QdotError(f"{where}: points = {said}: {_named(part)} has {most:g} points at most")
    return float(number)


def _named(part: str) -> str:
    return part or "the total"
