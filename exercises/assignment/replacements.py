"""Read and write redrawn.csv, the list of replaced problems: those whose first version failed its certificate.

A student's problem in a slot is generated with the first seed whose problem passes its certificate. The seeds are
numbered from 1, and at most `MAX_SEEDS` are tried. The file lists the problems with a later seed than the first. Its
columns are student, problem (p1, p2, …), family, draw (the number of the seed) and why. `qdot generate` and
`qdot export` write the file before any notebook, and every command that regenerates a class reads it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.input_file import format_csv, read_table

REPLACEMENTS_FILE = "redrawn.csv"
COLUMNS = ("student", "problem", "family", "draw", "why")

MAX_SEEDS = 10
"""Maximum number of seeds for a problem: if half of all seeds fail, only one problem in a thousand fails with all."""


@dataclass(frozen=True)
class Replacement:
    """A replaced problem: its family, the number of its seed (from 2), and why the problem with seed 1 failed."""

    family: str
    seed_number: int
    first_failure: str = ""


Replacements = Mapping[tuple[str, str], Replacement]
"""Maps pairs (student, name of the slot) to the replaced problems."""


def read_replacements(folder: Path) -> dict[tuple[str, str], Replacement]:
    """Return the content of redrawn.csv in an assignment's folder; empty if there is no file. Raises QdotError."""
    path = folder / REPLACEMENTS_FILE
    replacements: dict[tuple[str, str], Replacement] = {}
    for number, cells in read_table(path, "student", ",".join(COLUMNS)) if path.exists() else ():
        student, slot, family, draw, why = (cells.get(name, "").strip() for name in COLUMNS)
        if not (draw.isascii() and draw.isdecimal() and 2 <= int(draw[:9]) <= MAX_SEEDS):  # int refuses long texts
            raise QdotError(
                f"{path}: line {number}: draw = {draw!r}: expected a whole number from 2 to {MAX_SEEDS}, as written "
                "by 'qdot generate'; restore the file from a backup"
            )
        replacements[student, slot] = Replacement(family, int(draw), why)
    return replacements


def write_replacements(folder: Path, replacements: Replacements) -> None:
    """Write redrawn.csv and sync it to disk, before any notebook that depends on it. Raises QdotError.

    Lines are sorted by student and slot.
    """
    rows = [COLUMNS]
    for student, _, slot in sorted((student, len(slot), slot) for student, slot in replacements):  # p2 before p10
        replacement = replacements[student, slot]
        failure = " ".join(replacement.first_failure.split())
        rows.append((student, slot, replacement.family, str(replacement.seed_number), failure))
    write_atomically(folder / REPLACEMENTS_FILE, format_csv(rows))
