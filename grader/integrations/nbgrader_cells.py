"""Restore the cells of nbgrader's notebooks after students changed them, and fill in qdot's marks.

Nothing here needs nbgrader; `nbgrader_plugin` passes on the contents of nbgrader's database.
"""

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports.nbgrader import ANSWER, Cell, answer_metadata, checksum, grade_id, marks_cell
from qdot.exercises.notebook.self_check import Problems, cells_of
from qdot.grader.grading.marking import format_points
from qdot.grader.judging.verdict import Outcome
from qdot.grader.reports.answers import make_visible
from qdot.grader.reports.rows import Row


def restore_cells(cells: Sequence[Cell], points: Mapping[str, float]) -> list[Cell]:
    """Return a student's cells with one cell for each part's marks, behind its answer; `points` are by part.

    nbgrader's metadata are made anew: what students changed in them decides nothing, and stops nobody's grading. Of
    several cells with the name of an answer the first keeps it. What was written into a cell for marks is kept.
    """
    parts = {grade_id(part): part for part in points}
    marks = {name: marks_cell(part, points[part]) for name, part in parts.items()}
    left, whole = dict(marks), list[Cell]()
    ids = {cell["id"] for cell in marks.values()}
    for place, cell in enumerate(cells):
        name = _metadata_text(cell["metadata"].pop("nbgrader", None), "grade_id")
        part = _metadata_text(cell["metadata"].get("qdot"), "part")
        answered = grade_id(part) if part in points else name.removesuffix(ANSWER)
        if name in marks and cell["source"].strip() == marks[name]["source"]:
            continue
        if cell.get("id") in ids:
            cell["id"] = f"changed-{place}"
        whole.append(cell)
        if (part in points or name.endswith(ANSWER)) and answered in left and cell["cell_type"] == "code":
            cell["metadata"].update(answer_metadata(parts[answered]))
            whole.append(left.pop(answered))
    return [*whole, *left.values()]


def _metadata_text(metadata: object, name: str) -> str:
    return str(metadata.get(name, "")) if isinstance(metadata, dict) else ""


def without_self_checks(cells: Sequence[Cell], problems: Problems) -> list[Cell]:
    """Return the cells without the notebook's own checks, unless somebody changed them.

    The staff read each student's notebook, and nbgrader's pages fold nothing: what checks is longer than all answers.
    """
    function, checks = cells_of(problems)
    ours = {function, *checks} - {""}
    return [cell for cell in cells if cell["source"].strip() not in ours]


def fill_in(cells: Sequence[Cell], rows: Sequence[Row]) -> None:
    """Write the outcome of each part into the cell for its marks; remove all other outputs. Raises QdotError.

    Where a part is not answered, and its cell still says so, nbgrader is told that the cell is as it was handed out.
    """
    by_name = {grade_id(row.part): row for row in rows}
    waiting = dict(by_name)
    for cell in cells:
        if cell["cell_type"] != "code":
            continue
        cell["outputs"], cell["execution_count"] = [], None
        about = cell["metadata"].get("nbgrader") or {}
        if about.get("grade"):
            row = waiting.pop(about["grade_id"], None)
            if row is None or row.points is None or float(about["points"]) != row.max_points:
                raise QdotError(f"{about['grade_id']}: {_describe_mismatch(row)}")
            cell["outputs"] = make_outputs(row)
        elif about.get("solution"):
            row = by_name.get(about["grade_id"].removesuffix(ANSWER))
            if row is not None and row.outcome == Outcome.MISSING and "blank" in cell["source"]:
                about["checksum"] = checksum(cell)
    if waiting:
        raise QdotError(f"{', '.join(waiting)}: nbgrader knows no such cells; {GENERATE}")


WIDTH = 76
"""Characters of a line that nbgrader's pages show without scrolling, on a window of 860 pixels, too."""
GENERATE = "export the assignment again and run nbgrader generate_assignment again"


def _describe_mismatch(row: Row | None) -> str:
    if row is not None and row.points is None:
        return f"qdot failed on it, so there is no mark: {row.message}"
    return f"the assignment does not ask this, or for other points; {GENERATE}"


def make_outputs(row: Row) -> list[dict[str, Any]]:
    """Return outputs that nbgrader scores with a part's points, and that give the reason.

    An error is 0 points; else the value is the points. The words come in a stream before it, never on standard error,
    which would be 0 points.
    """
    assert row.points is not None
    message = textwrap.fill(
        make_visible(f"{row.outcome}: {row.message}" if row.message else row.outcome), WIDTH,
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip
    if row.points <= 0:
        title = f"{row.title}: {format_points(0)} of {format_points(row.max_points)} points"
        error = {"ename": row.outcome, "evalue": make_visible(row.message), "traceback": [title, message]}
        return [{"output_type": "error", **error}]
    earned = float(min(row.points, row.max_points))  # nbgrader refuses to grade where there is more
    value = {"data": {"text/plain": repr(earned)}, "execution_count": None, "metadata": {}}
    stream = {"output_type": "stream", "name": "stdout", "text": f"{message}\n"}
    return [stream, {"output_type": "execute_result", **value}]
