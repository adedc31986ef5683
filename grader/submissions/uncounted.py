"""What of a notebook need not be run to mark it: qdot's own self-checks, where nobody has touched them.

They only print, and take half of the time of all cells together.
"""

from collections.abc import Sequence
from dataclasses import replace

from qdot.exercises.notebook.self_check import SELF_CHECK, Problems, cells_of
from qdot.grader.submissions.cells import Cell


def without_self_checks(cells: Sequence[Cell], problems: Problems) -> Sequence[Cell]:
    """Return the cells with those of the self-checks empty: all as they are where code of another cell speaks of it."""
    function, checks = cells_of(problems)
    ours = {function, *checks} - {""}
    if any(SELF_CHECK in cell.source for cell in cells if cell.is_code and cell.source.strip() not in ours):
        return cells
    return [replace(cell, source="") if cell.is_code and cell.source.strip() in ours else cell for cell in cells]
