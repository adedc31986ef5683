"""redrawn.csv: whose problem was drawn anew, as an earlier draw did not pass its certificate; a part of the assignment.

Its columns are student, problem (p1, p2, …), family, draw and why. A problem that is not in it is the first draw. `qdot
generate` and `qdot export` write it before they write any notebook, and whatever regenerates a class reads it.
"""

import csv
import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.input_file import read_table

REDRAWN = "redrawn.csv"
COLUMNS = ("student", "problem", "family", "draw", "why")

DRAWS = 10
"""Draws of a problem that are tried for a student: where half of all can't be certified, one in a thousand is left."""


@dataclass(frozen=True)
class Redraw:
    """Which draw of a family a student has in one place, counted from 1; and what was wrong with the first one."""

    family: str
    draw: int
    why: str = ""


Redraws = Mapping[tuple[str, str], Redraw]
"""By student and the name of the place in the assignment."""


def read_redrawn(folder: Path) -> dict[tuple[str, str], Redraw]:
    """Return what redrawn.csv of an assignment's folder says; nothing where there is no such file. Raises QdotError."""
    path = folder / REDRAWN
    if not path.exists():
        return {}
    redrawn: dict[tuple[str, str], Redraw] = {}
    for number, cells in read_table(path, COLUMNS[0], ",".join(COLUMNS)):
        student, place, family, draw, why = (cells.get(name, "").strip() for name in COLUMNS)
        if not (draw.isascii() and draw.isdecimal() and 2 <= int(draw[:9]) <= DRAWS):
            raise QdotError(
                f"{path}: line {number}: draw = {draw!r}: it is a whole number from 2 to {DRAWS}, as 'qdot generate' "
                "wrote it; restore the file from a backup"
            )
        redrawn[student, place] = Redraw(family, int(draw), why)
    return redrawn


def write_redrawn(folder: Path, redrawn: Redraws) -> None:
    """Write redrawn.csv; it is on the disk when this returns, before any notebook that depends on it. Raises QdotError.

    Lines are in the order of students and places, whatever order they were drawn in.
    """
    out = io.StringIO()
    lines = csv.writer(out, lineterminator="\n")
    lines.writerow(COLUMNS)
    for (student, place), redraw in sorted(redrawn.items(), key=lambda item: (item[0][0], len(item[0][1]), item[0][1])):
        lines.writerow((student, place, redraw.family, redraw.draw, " ".join(redraw.why.split())))
    write_atomically(folder / REDRAWN, out.getvalue())
