"""Restore the cells that nbgrader needs in a student's notebook, and write qdot's marks into these cells.

This module doesn't need nbgrader; `nbgrader_plugin` passes on the contents of nbgrader's database.
"""

import textwrap
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from typing import Any

from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports import nbgrader
from qdot.exercises.exports.nbgrader import ANSWER_SUFFIX, Cell, make_grade_id
from qdot.exercises.notebook.notebook import SELF_CHECK_TITLE
from qdot.exercises.notebook.self_check import Problems, write_self_check_cell
from qdot.grader.judging.verdict import Outcome
from qdot.grader.marking.marking import format_points
from qdot.grader.reports.answer_display import make_visible
from qdot.grader.reports.part_rows import PartRow


def restore_cells(
    cells: Sequence[Cell], points: Mapping[str, float], text_parts: AbstractSet[str] = frozenset()
) -> list[Cell]:
    """Return a student's cells with a new cell for marks after each answer; `points` maps parts to their points.

    A person marks the answers to `text_parts`, so these answers have no separate cell for marks.

    nbgrader's metadata are recreated, so that students' changes to them neither affect the marks nor stop the grading.
    If several cells have the name of an answer, the first cell keeps the name. A cell for marks that a student has
    changed remains as an ordinary cell.
    """
    parts = {make_grade_id(part): part for part in points}
    marked_parts = {name: part for name, part in parts.items() if part not in text_parts}
    marks_cells = {name: nbgrader.make_marks_cell(part, points[part]) for name, part in marked_parts.items()}
    unplaced_text_parts = set(text_parts)
    unplaced_cells, restored_cells = dict(marks_cells), list[Cell]()
    marks_cell_ids = {cell["id"] for cell in marks_cells.values()}
    for index, cell in enumerate(cells):
        name = _read_metadata_text(cell["metadata"].pop("nbgrader", None), "grade_id")
        part = _read_metadata_text(cell["metadata"].get("qdot"), "part")
        answer_name = make_grade_id(part) if part in points else name.removesuffix(ANSWER_SUFFIX)
        if name in marks_cells and cell["source"].strip() == marks_cells[name]["source"]:
            continue
        if cell.get("id") in marks_cell_ids:
            cell["id"] = f"changed-{index}"
        restored_cells.append(cell)
        is_answer = cell["cell_type"] == "code" and (part in points or name.endswith(ANSWER_SUFFIX))
        answered_part = parts.get(answer_name, "")
        if is_answer and answered_part in unplaced_text_parts:
            unplaced_text_parts.remove(answered_part)
            cell["metadata"].update(nbgrader.make_text_metadata(answered_part, points[answered_part]))
        elif is_answer and answer_name in unplaced_cells:
            cell["metadata"].update(nbgrader.make_answer_metadata(parts[answer_name]))
            restored_cells.append(unplaced_cells.pop(answer_name))
    return [*restored_cells, *unplaced_cells.values()]


def _read_metadata_text(metadata: object, name: str) -> str:
    return str(metadata.get(name, "")) if isinstance(metadata, dict) else ""


def remove_self_checks(cells: Sequence[Cell], problems: Problems) -> list[Cell]:
    """Return the cells without the notebook's own checks; changed checks remain.

    The staff read each student's notebook on nbgrader's pages, which can't fold cells, and the code of the checks is
    longer than all the answers.
    """
    removed_sources = {write_self_check_cell(problems), SELF_CHECK_TITLE} - {""}
    return [cell for cell in cells if cell["source"].strip() not in removed_sources]


def fill_in_marks(cells: Sequence[Cell], rows: Sequence[PartRow]) -> None:
    """Write the outcome of each part into the cell for its marks; remove all other outputs. Raises QdotError.

    The checksum of an unanswered cell is recomputed, so that nbgrader takes the cell for unchanged.
    """
    row_by_name = {make_grade_id(row.part): row for row in rows}
    unplaced_rows = dict(row_by_name)
    for cell in cells:
        if cell["cell_type"] != "code":
            continue
        cell["outputs"], cell["execution_count"] = [], None
        metadata = cell["metadata"].get("nbgrader") or {}
        if metadata.get("grade") and metadata.get("solution"):
            unplaced_rows.pop(metadata["grade_id"], None)  # a person marks this answer on nbgrader's pages
        elif metadata.get("grade"):
            row = unplaced_rows.pop(metadata["grade_id"], None)
            if row is None or row.points is None or float(metadata["points"]) != row.max_points:
                reason = f"the assignment does not have this part, or it has other points; {EXPORT_AGAIN}"
                if row is not None and row.points is None:
                    reason = f"there is no mark, because qdot failed: {row.message}"
                raise QdotError(f"{metadata['grade_id']}: {reason}")
            cell["outputs"] = make_outputs(row)
        elif metadata.get("solution"):
            row = row_by_name.get(metadata["grade_id"].removesuffix(ANSWER_SUFFIX))
            if row is not None and row.outcome == Outcome.MISSING and "blank" in cell["source"]:
                metadata["checksum"] = nbgrader.compute_checksum(cell)
    if unplaced_rows:
        raise QdotError(f"{', '.join(unplaced_rows)}: nbgrader's database has no such cells; {EXPORT_AGAIN}")


MAX_LINE_LENGTH = 76
"""Maximum length of a line that nbgrader's pages show without scrolling, even in a window 860 pixels wide."""
EXPORT_AGAIN = "export the assignment again and run nbgrader generate_assignment again"


def make_outputs(row: PartRow) -> list[dict[str, Any]]:
    """Return the outputs of a cell for marks, from which nbgrader takes a part's points, with the reason.

    nbgrader gives 0 points for an error; otherwise the value of the cell is the points. The reason is on standard
    output, because nbgrader gives 0 points if there is any text on standard error.
    """
    assert row.points is not None
    text = make_visible(": ".join(filter(None, (row.outcome, row.message))))
    message = textwrap.fill(text, MAX_LINE_LENGTH, break_long_words=False, break_on_hyphens=False)
    if row.points <= 0:
        title = f"{row.title}: {format_points(0)} of {format_points(row.max_points)} points"
        error = {"ename": row.outcome, "evalue": make_visible(row.message), "traceback": [title, message]}
        return [{"output_type": "error", **error}]
    earned = float(min(row.points, row.max_points))  # nbgrader refuses to grade if this is more than the maximum
    value = {"data": {"text/plain": repr(earned)}, "execution_count": None, "metadata": {}}
    stream = {"output_type": "stream", "name": "stdout", "text": f"{message}\n"}
    return [stream, {"output_type": "execute_result", **value}]
