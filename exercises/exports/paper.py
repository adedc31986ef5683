"""Export of handouts, exams, answer keys and marking sheets as HTML, PDF or LaTeX."""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import explain_missing, need
from qdot.exercises.exports.export_format import File, Order
from qdot.exercises.exports.sheet import Sheet, sheets
from qdot.exercises.figure.tikz import tikz
from qdot.exercises.formula.printers.typst import typst_string
from qdot.exercises.writing.markup import latex_escaped, to_html, to_latex
from qdot.exercises.writing.render import render
from qdot.exercises.writing.typst import to_typst, typst_escaped

STAFF = {"key": "a key", "marking": "a marking sheet"}
"""Kinds of sheets that show answers, each with its name in messages."""
VERSION_TICKS = 8
"""Number of columns to tick on the marking sheet of a version: one for each student. A student's own sheet has one."""
NARROW = 0.8
"""The share of a page's width that a formula may take beside a name."""
LAST = 60
"""Weight of the end of a sheet when free space on its last page is shared out. A part's weight is its working space."""


@dataclass(frozen=True)
class PaperQuestion:
    """A part of an assignment with the answers of all students, for marking question by question."""

    label: str
    title: str
    points: str
    answers: tuple[tuple[str, str], ...]


def export_html(order: Order) -> Generator[File, None, None]:
    """Yield an HTML page for every student or version and, for a key, one page for the class."""
    return _files(order, "html", _html, whole=False)


def export_latex(order: Order) -> Generator[File, None, None]:
    """Yield self-contained LaTeX source for every student or version and, for a key, one file for the class."""
    return _files(order, "tex", _latex, whole=False)


def export_pdf(order: Order) -> Generator[File, None, None]:
    """Yield a PDF for every student or version, and one of all to print. Raises QdotError if typst is missing."""
    need("pdf", "PDF")
    return _files(order, "pdf", lambda *arguments: compile_pdf(typst_source(*arguments)), whole=True)


def missing_for_pdf() -> str:
    """Return how to install the PDF library if it is missing, else ""."""
    return explain_missing("pdf", "PDF")


def check_sheet(order: Order) -> None:
    """Raise QdotError if the order is impossible for this kind of sheet."""
    if order.sheet == "marking" and order.earns is None:
        raise QdotError("a marking sheet needs the grader: qdot export DIR --sheet marking")
    if order.sheet in STAFF and order.solutions:
        raise QdotError(
            f"{STAFF[order.sheet]} has no worked solutions; these are on --sheet handout or exam, with --solutions"
        )


Write = Callable[[Order, Sequence[Sheet], Sequence[PaperQuestion]], str | bytes]


def _files(order: Order, ending: str, write: Write, whole: bool) -> Generator[File, None, None]:
    """Yield a file for each sheet, and then one for the class.

    For a key, the last file has the answers by question. Otherwise it has all sheets, and only if `whole`.
    """
    is_key = order.sheet == "key"
    check_sheet(order)
    private = order.sheet in STAFF or order.solutions
    stem = f"{order.sheet}{'-versions' if order.versions else ''}{'-solutions' if order.solutions else ''}"
    written_sheets: list[Sheet] = []
    for sheet in sheets(order):
        yield File(f"{stem}/{sheet.file}.{ending}", write(order, [sheet], ()), private)
        written_sheets.append(sheet)
    if not written_sheets:  # everybody was left out
        return
    if is_key:
        yield File(f"{stem}-all.{ending}", write(order, (), questions(written_sheets)), private)
    elif whole:
        yield File(f"{stem}-all.{ending}", write(order, written_sheets, ()), private)


def questions(sheets_done: Sequence[Sheet]) -> tuple[PaperQuestion, ...]:
    """Return every part with its answers from all sheets."""
    return tuple(
        PaperQuestion(part.label, part.title, part.points, tuple(
            (sheet.student or sheet.name, sheet_part.answer)
            for sheet in sheets_done for sheet_part in sheet.parts if sheet_part.label == part.label
        ))
        for part in sheets_done[0].parts
    )  # fmt: skip


def _template_context(order: Order, made: Sequence[Sheet], asked: Sequence[PaperQuestion]) -> dict[str, object]:
    return {
        "title": order.assignment.title, "kind": order.sheet, "solutions": order.solutions, "page": order.page,
        "sheets": made, "questions": asked, "last": LAST,
        "ticks": VERSION_TICKS if order.versions else 1,
    }  # fmt: skip


# --- PDF ---


def typst_source(order: Order, made: Sequence[Sheet], asked: Sequence[PaperQuestion]) -> str:
    """Return the Typst document with these sheets."""
    return render(
        "exports/paper.typ.j2", **_template_context(order, made, asked), markup=to_typst, plain=typst_escaped,
        string=typst_string, narrow=NARROW,
    )  # fmt: skip


def compile_pdf(source: str) -> bytes:
    """Return a Typst document as PDF/UA-1. It needs the library typst (`missing_for_pdf`).

    The bytes are the same on every machine, because only the library's fonts are used and no date is written.
    """
    import typst

    return bytes(typst.compile(source.encode(), ignore_system_fonts=True, pdf_standards=["ua-1"], timestamp=0))


# --- LaTeX and HTML ---


def _latex(order: Order, made: Sequence[Sheet], asked: Sequence[PaperQuestion]) -> str:
    return render(
        "exports/paper.tex.j2", **_template_context(order, made, asked), markup=to_latex, plain=latex_escaped,
        draw=tikz, narrow=NARROW,
    )  # fmt: skip


def _html(order: Order, made: Sequence[Sheet], asked: Sequence[PaperQuestion]) -> str:
    def markup(text: str, share: float = 1.0) -> str:
        return to_html(text, share=share)

    return render("exports/paper.html.j2", **_template_context(order, made, asked), markup=markup, narrow=NARROW)
