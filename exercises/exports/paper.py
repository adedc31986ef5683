"""Export handouts, exams, answer keys and marking sheets as HTML, PDF or LaTeX."""

import tempfile
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.assignment.front_page import FrontPage
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import require_extra
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.exports.sheet import Sheet, make_sheet, make_sheets
from qdot.exercises.figure.tikz import convert_to_tikz
from qdot.exercises.formula.printers.typst import quote_for_typst
from qdot.exercises.problem.problem import Problem
from qdot.exercises.writing.markup import escape_latex, to_html, to_latex
from qdot.exercises.writing.render import render
from qdot.exercises.writing.typst import escape_typst, to_typst

STAFF_SHEETS = {"key": "a key", "marking": "a marking sheet"}
"""Kinds of sheets that show answers, each with its name in messages."""
VERSION_TICKS = 8
"""Number of columns to tick on the marking sheet of a version: room for eight students.

The marking sheet of a single student has one column.
"""
FORMULA_WIDTH_SHARE = 0.8
"""The share of a page's width that a formula may take beside a student's name."""
END_WEIGHT = 60
"""The weight of the blank space at the end of a sheet's last page; the weight of a box is its working space in mm."""


@dataclass(frozen=True)
class PaperQuestion:
    """A part of an assignment with all students' answers, each with its student, for marking question by question."""

    label: str
    title: str
    points: str
    answers: tuple[tuple[str, str], ...]


def check_sheet(request: ExportRequest) -> None:
    """Raise QdotError if the requested kind of sheet is impossible with the other settings of the request."""
    if request.sheet in STAFF_SHEETS and request.has_solutions:
        raise QdotError(
            f"{STAFF_SHEETS[request.sheet]} has no worked solutions; use --solutions with --sheet handout or exam"
        )


_TEMPLATES: dict[str, tuple[str, dict[str, Callable[..., str]]]] = {
    "html": ("paper.html.j2", {"write_markup": lambda text, share=1.0: to_html(text, width_share=share)}),
    "tex": ("paper.tex.j2", {"write_markup": to_latex, "escape_text": escape_latex, "draw_figure": convert_to_tikz}),
    "pdf": ("paper.typ.j2", {"write_markup": to_typst, "escape_text": escape_typst, "quote": quote_for_typst}),
}
"""Maps each file type to its template and the functions that the template calls."""


def export_paper(request: ExportRequest, file_type: str) -> Generator[ExportedFile, None, None]:
    """Yield a file for each student or version, and then a file for the class. `file_type` is a key of `_TEMPLATES`.

    For a key, the class's file has all answers by question. For other kinds of sheets, only a PDF for the class is
    written; it contains all sheets. Raises QdotError if typst, which PDF needs, is missing.
    """
    check_sheet(request)
    if file_type == "pdf":
        require_extra("pdf", "PDF")
    is_private, is_key = request.sheet in STAFF_SHEETS or request.has_solutions, request.sheet == "key"
    stem = request.sheet + "-versions" * bool(request.version_count) + "-solutions" * request.has_solutions
    images = _list_images(request)

    def write_file(name: str, sheets: Sequence[Sheet], questions: Sequence[PaperQuestion] = ()) -> ExportedFile:
        text = _render_sheets(request, file_type, sheets, questions)
        return ExportedFile(
            f"{name}.{file_type}", compile_pdf(text, images) if file_type == "pdf" else text, is_private
        )

    for file_name, content in images.items() if file_type == "tex" else ():
        if file_name.endswith(".svg"):
            raise QdotError("LaTeX can't show an SVG logo; give `logo` in assignment.toml a PNG or JPEG file")
        yield ExportedFile(f"{stem}/{file_name}", content)
    sheets: list[Sheet] = []
    for sheet in make_sheets(request):
        yield write_file(f"{stem}/{sheet.file_stem}", [sheet])
        sheets.append(sheet)
    if sheets and is_key:
        yield write_file(f"{stem}-all", (), _list_answers_by_question(sheets))
    elif sheets and file_type == "pdf":
        yield write_file(f"{stem}-all", sheets)


def make_pdf_preview(assignment: Assignment, name: str, problems: Sequence[Problem], has_solutions: bool) -> bytes:
    """Return a PDF with some problems of an assignment, which are not certified. Raises QdotError.

    The PDF is an exam if the assignment has a front page, and otherwise a handout.
    """
    require_extra("pdf", "PDF")
    sheet_kind = "handout" if assignment.front_page == FrontPage() else "exam"
    request = ExportRequest(assignment, lambda _: [], has_solutions=has_solutions, sheet=sheet_kind)
    sheet = make_sheet(request, "preview", name, "", problems)
    return compile_pdf(_render_sheets(request, "pdf", [sheet]), _list_images(request))


def _list_images(request: ExportRequest) -> dict[str, bytes]:
    """Map the file name of each image on the first page of an exam to its content."""
    logo = request.assignment.front_page.logo if request.sheet == "exam" and not request.has_solutions else None
    return {} if logo is None else {logo.file_name: logo.content}


def _render_sheets(
    request: ExportRequest, file_type: str, sheets: Sequence[Sheet], questions: Sequence[PaperQuestion] = ()
) -> str:  # fmt: skip
    template, functions = _TEMPLATES[file_type]
    return render(
        f"exports/{template}", title=request.assignment.title, kind=request.sheet, solutions=request.has_solutions,
        page=request.paper_size, sheets=sheets, questions=questions, end_weight=END_WEIGHT,
        formula_width_share=FORMULA_WIDTH_SHARE, ticks=VERSION_TICKS if request.version_count else 1,
        front=request.assignment.front_page, **functions,
    )  # fmt: skip


def _list_answers_by_question(sheets: Sequence[Sheet]) -> tuple[PaperQuestion, ...]:
    """Return every part with its answers from all sheets."""
    return tuple(
        PaperQuestion(part.label, part.title, part.points, tuple(
            (sheet.student or sheet.name, sheet_part.answer)
            for sheet in sheets for sheet_part in sheet.parts if sheet_part.label == part.label
        ))
        for part in sheets[0].parts
    )  # fmt: skip


def compile_pdf(source: str, images: Mapping[str, bytes] = MappingProxyType({})) -> bytes:
    """Return a Typst document as PDF/UA-1; needs the library typst (see `require_extra`).

    `images` maps the names of image files to their content. The bytes are the same on every machine, because only fonts
    of the library are used and no date is written.
    """
    import typst

    with tempfile.TemporaryDirectory() as folder:
        for name, content in images.items():
            (Path(folder) / name).write_bytes(content)
        pdf = typst.compile(  # type: ignore[type-var]  # the hints ask for one type of document and folder
            source.encode(), root=Path(folder), ignore_system_fonts=True, pdf_standards=["ua-1"], timestamp=0
        )
    return bytes(pdf)
