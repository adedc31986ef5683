"""Write the results as an Excel workbook with two sheets: the grades, and the outcomes of every part.

XlsxWriter writes the same bytes for the same results. It writes every text as a string, so that Excel parses no text as
a formula or a link.
"""

import datetime
import io
from collections.abc import Sequence
from typing import Any

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.console import escape_controls
from qdot.grader.grading.result import Result
from qdot.grader.reports.class_summary import OUTCOME_WORDS, summarize_parts
from qdot.grader.reports.grades_table import Cell, make_grades_table

CREATION_TIME = datetime.datetime(2000, 1, 1)  # noqa: DTZ001 - a workbook's times have no zone
"""The creation time recorded in every workbook; the time is constant so that the same results give the same bytes."""
MAX_CELL_LENGTH = 32_000
"""Maximum number of characters written to a cell; Excel allows 32,767."""
MIN_COLUMN_WIDTH, MAX_COLUMN_WIDTH, MAX_HEADING_LENGTH = 8, 60, 14
"""Minimum and maximum width of a column, and length at which a heading is wrapped, in characters."""


def make_workbook(assignment: Assignment, results: Sequence[Result]) -> bytes:
    """Return the content of the workbook's file. The scores of work without a mark are empty cells, never 0."""
    import xlsxwriter

    content = io.BytesIO()
    with xlsxwriter.Workbook(content, {"in_memory": True, "default_date_format": "yyyy-mm-dd"}) as book:
        book.set_properties({"title": assignment.title, "author": "qdot", "created": CREATION_TIME})
        formats = {"head": book.add_format({"bold": True, "text_wrap": True, "valign": "top", "bottom": 1})}
        formats["points"] = book.add_format({"num_format": "0.####"})
        formats["percent"] = book.add_format({"num_format": "0.0"})
        header, rows = make_grades_table(results, assignment.roster)
        _fill_sheet(book.add_worksheet("Grades"), formats, header, rows, frozen_column_count=2)
        _fill_sheet(book.add_worksheet("Parts"), formats, *_make_part_table(assignment, results), frozen_column_count=1)
    return content.getvalue()


def _make_part_table(assignment: Assignment, results: Sequence[Result]) -> tuple[list[str], list[list[Cell]]]:
    """Return a header, and a row for each part: maximum and mean points, and the count of each outcome."""
    header = ["part", "points", "mean", *OUTCOME_WORDS.values()]
    rows: list[list[Cell]] = []
    for part in summarize_parts(assignment, results):
        mean = None if part.mean_share is None else round(part.mean_share * part.max_points, 4)
        counts = [float(part.outcome_counts[outcome]) for outcome in OUTCOME_WORDS]
        rows.append([part.name, part.max_points, mean, *counts])
    return header, rows


def _fill_sheet(
    sheet: Any, formats: dict[str, Any], header: Sequence[str], rows: Sequence[Sequence[Cell]], frozen_column_count: int
) -> None:
    """Write a table into a sheet; when one scrolls, the header and the frozen columns on the left stay visible."""
    for column, name in enumerate(header):
        cells = [row[column] for row in rows]
        heading_length = min(len(name), MAX_HEADING_LENGTH)
        length = max([heading_length, *(len(cell) for cell in cells if isinstance(cell, str))])
        sheet.set_column(column, column, min(MAX_COLUMN_WIDTH, max(MIN_COLUMN_WIDTH, length + 2)))
        sheet.write_string(0, column, escape_controls(name), formats["head"])
        number_format = formats["percent" if name == "percent" else "points"]
        for row_number, cell in enumerate(cells, 1):
            if isinstance(cell, str) and cell:
                sheet.write_string(row_number, column, escape_controls(cell)[:MAX_CELL_LENGTH])
            elif isinstance(cell, float):
                sheet.write_number(row_number, column, cell, number_format)
    sheet.freeze_panes(1, frozen_column_count)
    sheet.autofilter(0, 0, len(rows), len(header) - 1)
