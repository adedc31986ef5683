"""Read and write redrawn.csv, which lists the problems that were generated again because a draw failed its certificate.

A draw is an attempt to generate a student's problem; each draw has a different seed. The columns are student, problem
(p1, p2, …), family, draw and why. All problems that are not listed are first draws. `qdot generate` and `qdot export`
write the file before any notebook, and every command that regenerates a class reads it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.input_file import csv_text, read_table

REDRAWN_FILE = "redrawn.csv"
COLUMNS = ("student", "problem", "family", "draw", "why")

MAX_DRAWS = 10
"""Maximum number of draws for a problem: if half of all draws fail, only one problem in a thousand fails."""


@dataclass(frozen=True)
class Redraw:
    """The number of the draw (from 1) that a student has in a slot, its family, and why draw 1 failed."""

    family: str
    draw: int
    first_failure: str = ""


Redraws = Mapping[tuple[str, str], Redraw]
"""Regenerated problems by (student, name of the slot)."""


def read_redrawn(folder: Path) -> dict[tuple[str, str], Redraw]:
    """Return the content of redrawn.csv in an assignment's folder; empty if there is no file. Raises QdotError."""
    path = folder / REDRAWN_FILE
    if not path.exists():
        return {}
    redrawn: dict[tuple[str, str], Redraw] = {}
    for number, cells in read_table(path, COLUMNS[0], ",".join(COLUMNS)):
        student, slot, family, draw, why = (cells.get(name, "").strip() for name in COLUMNS)
        if not (draw.isascii() and draw.isdecimal() and 2 <= int(draw[:9]) <= MAX_DRAWS):
            raise QdotError(
                f"{path}: line {number}: draw = {draw!r}: expected a whole number from 2 to {MAX_DRAWS}, as written "
                "by 'qdot generate'; restore the file from a backup"
            )
        redrawn[student, slot] = Redraw(family, int(draw), why)
    return redrawn


def write_redrawn(folder: Path, redraws: Redraws) -> None:
    """Write redrawn.csv and sync it to disk, before any notebook that depends on it. Raises QdotError.

    Lines are sorted by student and slot.
    """
    ordered = sorted(redraws.items(), key=lambda item: (item[0][0], len(item[0][1]), item[0][1]))
    rows = (
        (student, slot, redraw.family, redraw.draw, " ".join(redraw.first_failure.split()))
        for (student, slot), redraw in ordered
    )
    write_atomically(folder / REDRAWN_FILE, csv_text([COLUMNS, *rows]))
