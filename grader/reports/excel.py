"""Write the results as an Excel workbook with two sheets: the grades, and the outcomes of every part.

XlsxWriter is better maintained than the alternative, and writes the same bytes for the same results. Every text is
written as a string, so that Excel parses none as a formula or a link.
"""

import datetime
import io
from collections import Counter
from collections.abc import Sequence
from typing import Any

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.console import escape_controls
from qdot.grader.grading.result import Result
from qdot.grader.reports.charts import OUTCOMES
from qdot.grader.reports.class_view import select_graded
from qdot.grader.reports.tables import Cell, grades_table, is_marked

CREATION_TIME = datetime.datetime(2000, 1, 1)  # noqa: DTZ001 - a workbook's times have no zone
"""The creation time recorded in every workbook; the time is constant so that the same results give the same bytes."""
MAX_CELL_LENGTH = 32_000
"""Maximum number of characters written to a cell; Excel allows 32,767."""


def make_workbook(assignment: Assignment, results: Sequence[Result]) -> bytes:
    """Return the workbook. The cells of ungraded work are empty, never 0."""
    import xlsxwriter

    content = io.BytesIO()
    with xlsxwriter.Workbook(content, {"in_memory": True, "default_date_format": "yyyy-mm-dd"}) as book:
        book.set_properties({"title": assignment.title, "author": "qdot", "created": CREATION_TIME})
        formats = {"head": book.add_format({"bold": True, "text_wrap": True, "valign": "top", "bottom": 1})}
        formats["points"] = book.add_format({"num_format": "0.####"})
        formats["percent"] = book.add_format({"num_format": "0.0"})
        header, rows = grades_table(results, assignment.roster)
        mark_columns = [column for column, name in enumerate(header) if name in ("score", "percent")]
        for row, result in zip(rows, results, strict=True):
            for column in () if is_marked(result, count_zero=True) else mark_columns:
                row[column] = None
        _fill_sheet(book.add_worksheet("Grades"), formats, header, rows, 2)
        _fill_sheet(book.add_worksheet("Parts"), formats, *_table_of_parts(results), 1)
    return content.getvalue()


def _table_of_parts(results: Sequence[Result]) -> tuple[list[str], list[list[Cell]]]:
    """Return a header, and a row for each part: maximum and mean points, and the count of each outcome."""
    header = ["part", "points", "mean", *(word for word, *_ in OUTCOMES.values())]
    parts_of_students = [result.parts for result in select_graded(results)]
    rows: list[list[Cell]] = []
    for name, part in results[0].parts.items():
        answers = [parts[name] for parts in parts_of_students]
        points = [answer.points for answer in answers if answer.points is not None]
        count = Counter(answer.outcome for answer in answers)
        mean = round(sum(points) / len(points), 4) if points else None
        rows.append([name, part.max_points, mean, *(float(count[outcome]) for outcome in OUTCOMES)])
    return header, rows


def _fill_sheet(
    sheet: Any, formats: dict[str, Any], header: Sequence[str], rows: Sequence[Sequence[Cell]], frozen_columns: int
) -> None:
    for column, name in enumerate(header):
        cells = [row[column] for row in rows]
        widths = [len(cell) for cell in cells if isinstance(cell, str)]
        sheet.set_column(column, column, min(60, max([8, min(len(name), 14) + 2, *(length + 2 for length in widths)])))
        sheet.write_string(0, column, escape_controls(name), formats["head"])
        form = formats["percent" if name == "percent" else "points"]
        for line, cell in enumerate(cells, 1):
            if isinstance(cell, str) and cell:
                sheet.write_string(line, column, escape_controls(cell)[:MAX_CELL_LENGTH])
            elif isinstance(cell, float):
                sheet.write_number(line, column, cell, form)
    sheet.freeze_panes(1, frozen_columns)
    sheet.autofilter(0, 0, len(rows), len(header) - 1)
