"""Export handouts, exams, answer keys and marking sheets as HTML, PDF or LaTeX."""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import require_extra
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.exports.sheet import Sheet, make_sheets
from qdot.exercises.figure.tikz import convert_to_tikz
from qdot.exercises.formula.printers.typst import typst_string
from qdot.exercises.writing.markup import escape_latex, to_html, to_latex
from qdot.exercises.writing.render import render
from qdot.exercises.writing.typst import escape_typst, to_typst

STAFF_SHEETS = {"key": "a key", "marking": "a marking sheet"}
"""Kinds of sheets that show answers, each with its name in messages."""
VERSION_TICKS = 8
"""Number of columns to tick on the marking sheet of a version, for as many students.

The marking sheet of a single student has one column.
"""
FORMULA_WIDTH_SHARE = 0.8
"""The share of a page's width that a formula may take if a name is beside it."""
END_WEIGHT = 60
"""The share of the free space on a sheet's last page that stays at its end, relative to the parts' working spaces."""


@dataclass(frozen=True)
class PaperQuestion:
    """A part of an assignment with all students' answers, each after its student; for marking question by question."""

    label: str
    title: str
    points: str
    answers: tuple[tuple[str, str], ...]


def export_html(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield an HTML page for every student or version. For a key, also yield a page with all answers by question."""
    return _write_files(request, "html", _write_html, has_class_file=False)


def export_latex(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield LaTeX source for every student or version. For a key, also yield a file with all answers by question."""
    return _write_files(request, "tex", _write_latex, has_class_file=False)


def export_pdf(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield a PDF for every student or version, and a PDF for the class. Raises QdotError if typst is missing."""
    require_extra("pdf", "PDF")
    return _write_files(request, "pdf", lambda *arguments: compile_pdf(write_typst(*arguments)), has_class_file=True)


def check_sheet(request: ExportRequest) -> None:
    """Raise QdotError if the requested kind of sheet is impossible with the other settings of the request."""
    if request.sheet == "marking" and request.earned_share is None:
        raise QdotError("marking sheets are written by the command line: qdot export DIR --sheet marking")
    if request.sheet in STAFF_SHEETS and request.has_solutions:
        raise QdotError(
            f"{STAFF_SHEETS[request.sheet]} has no worked solutions; use --solutions with --sheet handout or exam"
        )


SheetWriter = Callable[[ExportRequest, Sequence[Sheet], Sequence[PaperQuestion]], str | bytes]


def _write_files(
    request: ExportRequest, file_type: str, write: SheetWriter, has_class_file: bool
) -> Generator[ExportedFile, None, None]:
    """Yield a file for each sheet, and then a file for the class.

    For a key, the class's file has all answers by question. For other kinds of sheets, it has all sheets, and it is
    only written if `has_class_file`.
    """
    check_sheet(request)
    is_private = request.sheet in STAFF_SHEETS or request.has_solutions
    stem = request.sheet + "-versions" * bool(request.version_count) + "-solutions" * request.has_solutions
    sheets: list[Sheet] = []
    for sheet in make_sheets(request):
        yield ExportedFile(f"{stem}/{sheet.file_stem}.{file_type}", write(request, [sheet], ()), is_private)
        sheets.append(sheet)
    is_key = request.sheet == "key"
    if sheets and (is_key or has_class_file):
        content = write(request, (), _list_answers_by_question(sheets)) if is_key else write(request, sheets, ())
        yield ExportedFile(f"{stem}-all.{file_type}", content, is_private)


def _list_answers_by_question(sheets: Sequence[Sheet]) -> tuple[PaperQuestion, ...]:
    """Return every part with its answers from all sheets."""
    return tuple(
        PaperQuestion(part.label, part.title, part.points, tuple(
            (sheet.student or sheet.name, sheet_part.answer)
            for sheet in sheets for sheet_part in sheet.parts if sheet_part.label == part.label
        ))
        for part in sheets[0].parts
    )  # fmt: skip


def _make_template_context(
    request: ExportRequest, sheets: Sequence[Sheet], questions: Sequence[PaperQuestion]
) -> dict[str, object]:
    return {
        "title": request.assignment.title, "kind": request.sheet, "solutions": request.has_solutions,
        "page": request.paper_size, "sheets": sheets, "questions": questions, "last": END_WEIGHT,
        "ticks": VERSION_TICKS if request.version_count else 1, "narrow": FORMULA_WIDTH_SHARE,
    }  # fmt: skip


# --- PDF ---


def write_typst(request: ExportRequest, sheets: Sequence[Sheet], questions: Sequence[PaperQuestion]) -> str:
    """Return the Typst document with these sheets."""
    return render(
        "exports/paper.typ.j2", **_make_template_context(request, sheets, questions), markup=to_typst,
        plain=escape_typst, string=typst_string,
    )  # fmt: skip


def compile_pdf(source: str) -> bytes:
    """Return a Typst document as PDF/UA-1; needs the library typst (see `require_extra`).

    The bytes are the same on every machine, because only fonts of the library are used and no date is written.
    """
    import typst

    return bytes(typst.compile(source.encode(), ignore_system_fonts=True, pdf_standards=["ua-1"], timestamp=0))


# --- LaTeX and HTML ---


def _write_latex(request: ExportRequest, sheets: Sequence[Sheet], questions: Sequence[PaperQuestion]) -> str:
    return render(
        "exports/paper.tex.j2", **_make_template_context(request, sheets, questions), markup=to_latex,
        plain=escape_latex, draw=convert_to_tikz,
    )  # fmt: skip


def _write_html(request: ExportRequest, sheets: Sequence[Sheet], questions: Sequence[PaperQuestion]) -> str:
    return render(
        "exports/paper.html.j2", **_make_template_context(request, sheets, questions),
        markup=lambda text, share=1.0: to_html(text, width_share=share),
    )  # fmt: skip
