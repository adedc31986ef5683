"""Paper: sheets as HTML, PDF and LaTeX, checked with real readers; every family's formulas in Typst and in words."""

import re
import subprocess
from collections.abc import Generator
from dataclasses import replace
from html import escape
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import make_install_command
from qdot.exercises.exports import boxes, marking
from qdot.exercises.exports.boxes import (
    AnswerBox,
    arrange_options,
    compute_share_that_fits,
    compute_working_space,
    make_box,
    scale_working_space,
)
from qdot.exercises.exports.export_format import SHEET_KINDS, ExportedFile, ExportRequest
from qdot.exercises.exports.marking import TOO_LONG, explain_marking
from qdot.exercises.exports.paper import compile_pdf
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.exports.sheet import Sheet, make_sheets
from qdot.exercises.figure.arm_figure import draw_figure_svg, draw_part_svg
from qdot.exercises.figure.tikz import convert_to_tikz
from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.formula.printers.speech import print_speech
from qdot.exercises.formula.printers.typst import quote_for_typst
from qdot.exercises.generation import generate
from qdot.exercises.notebook.notebook import draw_singular_configurations
from qdot.exercises.problem.credit import Credit
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.writing.markup import parse_markdown, to_latex
from qdot.exercises.writing.paper_texts import remove_typing_remarks
from qdot.exercises.writing.problem_texts import write_hints, write_prompt, write_solution, write_statement
from qdot.exercises.writing.short_answer import write_short_answer
from qdot.exercises.writing.typst import TYPST_WIDTH, escape_typst, to_typst
from qdot.grader.grading.certify import find_failures
from qdot.grader.marking.marking import compute_earned_share
from tests.grader.reports.test_feedback import Page
from tests.support import read_cases, read_data
from tests.support.command import run_and_fail
from tests.support.programs import CHROMIUM, LATEX, POPPLER, require_program
from tests.support.submitting import make_class
from tests.support.suites import few_families, few_or_all_families, select_for_suite

TOML = """title = 'Rates & "poses" #1'
key = "hw"
hints = true
[[problem]]
family = "planar-2r"
questions = ["position", "jacobian", "joint-rates", "singular-angles", "singularity-type"]
points = [1, 2, 1, 2.5, 1]
"""
CLASS = [Student("ada", "Ada Lovelace <b>"), Student("zoë", "Zoë_Ångström $5")]
DOCUMENT = """#set document(title: "All", date: none)
#set text(font: "New Computer Modern", size: 10.5pt, lang: "en")
#let formula(words, it) = math.equation(alt: words, it.body)
#let formulas(words, it, size) = context {
  let shown = text(size: 1em * size, math.equation(alt: words, block: true, it.body))
  assert(measure(shown).width <= 15.9cm, message: "too wide: " + words)
  shown
}
"""
"""A Typst document in which a formula wider than the text of a solution is an error."""


@pytest.fixture(scope="module")
def export_request(tmp_path_factory: pytest.TempPathFactory) -> ExportRequest:
    folder = tmp_path_factory.mktemp("paper") / "hw"
    make_class(folder, CLASS)
    (folder / "assignment.toml").write_text(TOML, encoding="utf-8")
    return ExportRequest(load_assignment(folder), find_failures)


def export_files(export_request: ExportRequest, export_format: str) -> dict[str, ExportedFile]:
    return {file.path: file for file in EXPORT_FORMATS[export_format].export(export_request)}


def read_pdf_text(content: str | bytes, folder: Path) -> str:
    require_program("pdftotext", POPPLER)
    assert isinstance(content, bytes)
    (folder / "it.pdf").write_bytes(content)
    return run_poppler("pdftotext", folder, "-layout", "-")


def run_poppler(program: str, folder: Path, *options: str) -> str:
    *before, last = options or ("it.pdf",)
    named = [*before, "it.pdf", last] if options else [last]
    return subprocess.run([program, *named], cwd=folder, capture_output=True, text=True).stdout


_SEEN: set[str] = set()


@few_families
def test_every_formula_compiles_fits_and_has_alternative_text(problem: Problem) -> None:
    """Formulas that differ only in numbers are compiled once per process."""
    texts = [write_statement(problem, "")]
    for part in problem.parts:
        texts += [write_prompt(problem, part), *write_hints(problem, part), write_solution(problem, part)]
        texts.append(write_short_answer(problem, part))
    new: list[str] = []
    for text in texts:
        for latex, block in parse_markdown(text)[1]:
            spoken = print_speech(parse_latex(latex))
            assert spoken and "\\" not in spoken and "  " not in spoken
            shape = f"{block}{re.sub(r'[0-9]', '1', latex)}"
            if shape not in _SEEN:
                _SEEN.add(shape)
                new.append(to_typst(f"$${latex}$$" if block else f"${latex}$"))
    whole = [to_typst(text) for text in (texts[0], texts[-1])]
    assert compile_pdf(DOCUMENT + "\n\n".join(new + whole)).startswith(b"%PDF")


@few_or_all_families
def test_paper_has_no_typing_remarks_and_every_answer_has_a_box_and_short_form(problem: Problem) -> None:
    for text in (write_statement(problem, ""), *(write_prompt(problem, part) for part in problem.parts)):
        shown = remove_typing_remarks(text, problem)
        assert not re.search(r"`|\btyped\b|\bin quotes\b|as in *[.,]|  |\( ?\)| [,.;]", shown), shown
        assert set(re.findall(r"\$[^$]+\$", text)) <= set(re.findall(r"\$[^$]+\$", shown))
    for part in problem.parts:
        box, short = make_box(problem, part, "x" * 3000), write_short_answer(problem, part)
        assert short.strip() and "None" not in short
        options = arrange_options(problem, part)
        assert (options is None) == (not part.answer.offered_options)
        if options is not None:
            assert len(options.options) == len(part.answer.offered_options) and options.has_tick_boxes == (box is None)
        if box is not None:
            assert part.shape in (None, (box.rows, box.columns))
            assert box.total_height < 220  # millimetres: it fits on a page
            assert len(box.units) in (0, box.rows) and len(box.labels) in (0, box.rows, box.columns)


@few_families
def test_tikz_figures_have_the_shapes_of_the_svg(problem: Problem) -> None:
    figures = [draw_figure_svg(problem.chain)]
    for part in problem.parts[-select_for_suite(3, 6) :]:
        figures += [draw_part_svg(problem.chain, part, "p"), draw_singular_configurations(problem, part, "s")]
    for svg in filter(None, figures):
        picture = convert_to_tikz(svg)
        strokes = len(re.findall(r"<(?:rect|polyline|polygon|circle)\b", svg))
        assert (picture.count(r"\path["), picture.count(r"\node[")) == (strokes, svg.count("<text"))
        assert picture.count("{") == picture.count("}")
        assert picture.replace("\\useasboundingbox", "").isascii()


def test_text_is_never_interpreted_as_markup(tmp_path: Path) -> None:
    plain = "a_*b* #eval $x$ <l> @r = - + / [d] \\ ~ 1. // /* & % {f}"
    hostile = f'{plain} `c` "e" #eval("1") \' */'
    assert escape_typst("*a*") == r"\*a\*"
    source = DOCUMENT + escape_typst(hostile) + f"\n#raw({quote_for_typst(hostile)})\n" + to_typst("# A\n\n" + hostile)
    assert compile_pdf(source)
    assert plain in read_pdf_text(compile_pdf(DOCUMENT + escape_typst(plain)), tmp_path)


def test_wide_formula_is_shrunk_or_broken() -> None:
    assert re.search(r", \d\d%\)", to_typst("$$" + "x" * 80 + "$$"))
    assert to_typst("$$y = " + " + ".join(f"a_{{{k}}} s_{{12}}" for k in range(30)) + "$$").count(" \\ ") == 2
    assert TYPST_WIDTH * 10.5 / 72 * 2.54 < 15.9
    wide = "$$x = " + " + ".join(f"a_{{{k}}} s_{{12}}" for k in range(12)) + "$$"
    assert to_latex(wide).count(r"\\") < to_latex(wide, 0.5).count(r"\\")


def test_sheet_contains_answers_only_if_requested(export_request: ExportRequest) -> None:
    for kind in ("handout", "exam"):
        for sheet in make_sheets(replace(export_request, sheet=kind)):
            assert not any(part.solution or part.answer or part.solution_figure for part in sheet.parts)
            assert all(part.has_score_space == (kind == "exam") for part in sheet.parts)
            assert all((part.box is not None) == (kind == "exam" and not part.options) for part in sheet.parts)
            assert sheet.has_hints == (kind == "handout")
    (key, _) = make_sheets(replace(export_request, sheet="key"))
    assert all(part.answer and not part.solution for part in key.parts)
    (solved, _) = make_sheets(replace(export_request, has_solutions=True))
    assert all(part.solution for part in solved.parts)
    assert not solved.has_hints


@pytest.mark.parametrize("export_format", ["html", "latex", "pdf"])
@pytest.mark.parametrize("kind", ["handout", "exam"])
def test_student_sheets_contain_no_answer_and_no_seed(
    export_request: ExportRequest, export_format: str, kind: str, tmp_path: Path
) -> None:
    exported = export_files(replace(export_request, sheet=kind), export_format)
    assert not any(file.is_private for file in exported.values())
    for student in CLASS:
        ((_, problem),) = export_request.assignment.generate_problems(student.id)
        ending = {"latex": "tex"}.get(export_format, export_format)
        content = exported[f"{kind}/{student.id}.{ending}"].content
        shown = content if isinstance(content, str) else read_pdf_text(content, tmp_path)
        assert str(problem.id.seed) not in shown and export_request.assignment.secret not in shown
        rates = next(part for part in problem.parts if part.name == "joint-rates")
        numbers = re.findall(r"\d+\.\d+", write_short_answer(problem, rates))
        assert len(numbers) == 2 and not any(number in shown for number in numbers)


def test_html_sheets_are_accessible_and_self_contained(export_request: ExportRequest) -> None:
    for request in (
        export_request,
        replace(export_request, sheet="exam"),
        replace(export_request, has_solutions=True),
        replace(export_request, sheet="key"),
    ):
        for file in export_files(request, "html").values():
            assert isinstance(file.content, str)
            page = Page(file.content.removeprefix("<!DOCTYPE html>\n"))
            assert not re.search(r"""(?:src|href)=|url\(|@import|<script""", file.content)
            (document,) = page.all("html")
            assert document[0] == {"lang": "en"}
            levels = [int(tag[1]) for tag, _, _ in page.elements if re.fullmatch(r"h[1-6]", tag)]
            assert levels[0] == 1 and levels.count(1) == 1
            assert all(after <= before + 1 for before, after in pairwise(levels))
            ids = [about["id"] for _, about, _ in page.elements if "id" in about]
            assert len(ids) == len(set(ids))
            assert all(about.get("role") == "img" and about["aria-labelledby"] for about, _ in page.all("svg"))
            assert all(about.get("scope") in ("col", "row") for about, _ in page.all("th"))
            assert "Ada Lovelace &lt;b&gt;" in file.content or "zoë" in file.content


PHONE_PAGE = """<!DOCTYPE html><title></title><iframe width="{width}" height="800" srcdoc="{sheet}"></iframe>
<script>
onload = () => {{
  const sheet = frames[0].document.documentElement;
  document.title = sheet.scrollWidth - sheet.clientWidth;
}};
</script>
"""
"""A page that shows a sheet on a phone, so many pixels wide. Its title is by how many pixels the sheet is too wide."""


@pytest.mark.integration
@pytest.mark.parametrize("sheet", SHEET_KINDS)
def test_html_sheets_fit_a_phone(export_request: ExportRequest, sheet: str, tmp_path: Path) -> None:
    """Wide tables and formulas scroll by themselves; the page does not."""
    chromium = require_program("chromium", CHROMIUM, in_ci=False)
    request = replace(export_request, sheet=sheet, compute_earned_share=compute_earned_share)
    file = next(iter(export_files(request, "html").values()))
    for width in (320, 390):
        page = tmp_path / f"{width}.html"
        page.write_text(PHONE_PAGE.format(width=width, sheet=escape(str(file.content))), encoding="utf-8")
        command = [
            chromium, "--headless", "--no-sandbox", "--dump-dom", f"--user-data-dir={tmp_path}/profile", str(page),
        ]  # fmt: skip
        shown = subprocess.run(command, capture_output=True, text=True).stdout
        assert "<title>0</title>" in shown, (width, re.findall("<title>.*?</title>", shown)[:1])


def test_pdf_is_tagged_has_its_texts_and_embeds_fonts(export_request: ExportRequest, tmp_path: Path) -> None:
    exam = replace(export_request, sheet="exam")
    exported = export_files(exam, "pdf")
    assert list(exported) == ["exam/ada.pdf", "exam/zoë.pdf", "exam-all.pdf"]
    shown = read_pdf_text(exported["exam/zoë.pdf"].content, tmp_path)
    for wanted in ("Rates & “poses” #1", "Zoë_Ångström $5", "zoë", "page 1 of", "1.4 Singular", "2.5 points", "rad/s"):
        assert wanted.replace("“", '"').replace("”", '"') in shown.replace("“", '"').replace("”", '"'), wanted
    about = run_poppler("pdfinfo", tmp_path)
    assert re.search(r"Tagged: +yes", about) and re.search(r"Title: +Rates", about) and "A4" in about
    fonts = run_poppler("pdffonts", tmp_path).splitlines()[2:]
    assert fonts and all(re.search(r" yes yes yes ", line) for line in fonts)  # embedded, in part, with Unicode
    subprocess.run(["pdftoppm", "-r", "20", "-gray", "it.pdf", "page"], cwd=tmp_path, capture_output=True, check=True)
    pages = sorted(tmp_path.glob("page-*.pgm"))
    assert len(pages) >= 2 and all(min(page.read_bytes()[20:]) < 100 for page in pages)


def test_each_sheet_starts_on_an_odd_page(export_request: ExportRequest, tmp_path: Path) -> None:
    exported = export_files(replace(export_request, sheet="exam", paper_size="letter"), "pdf")
    pages = read_pdf_text(exported["exam-all.pdf"].content, tmp_path).split("\f")
    first = [number for number, page in enumerate(pages, 1) if "page 1 of" in page]
    assert len(first) == len(CLASS) and all(number % 2 for number in first)
    assert re.search(r"Page size: +612 x 792", run_poppler("pdfinfo", tmp_path))
    last = [int(total) for total in re.findall(r"page \d+ of (\d+)", pages[0])]
    assert f"page {last[0]} of {last[0]}" in pages[last[0] - 1]


def test_key_lists_every_student_by_question(export_request: ExportRequest, tmp_path: Path) -> None:
    exported = export_files(replace(export_request, sheet="key"), "pdf")
    assert list(exported) == ["key/ada.pdf", "key/zoë.pdf", "key-all.pdf"]
    assert all(file.is_private for file in exported.values())
    shown = read_pdf_text(exported["key-all.pdf"].content, tmp_path)
    assert shown.count("ada") == shown.count("zoë") == 5
    for student in CLASS:
        ((_, problem),) = export_request.assignment.generate_problems(student.id)
        rates = next(part for part in problem.parts if part.name == "joint-rates")
        for number in re.findall(r"\d+\.\d+", write_short_answer(problem, rates)):
            assert number in shown


def make_exam_request(folder: Path, name: str) -> ExportRequest:
    make_class(folder, CLASS)
    (folder / "assignment.toml").write_text(read_data(f"assignments/{name}.toml"), encoding="utf-8")
    return ExportRequest(
        load_assignment(folder), lambda _: [], sheet="exam", version_count=1, compute_earned_share=compute_earned_share
    )


@pytest.fixture(scope="module")
def six(tmp_path_factory: pytest.TempPathFactory) -> ExportRequest:
    return make_exam_request(tmp_path_factory.mktemp("six") / "exam", "exam")


def read_exam_pages(export_request: ExportRequest, folder: Path) -> list[str]:
    """Return the pages of an exam with six problems: at most eight, with each figure beside its table and facts."""
    shown = read_pdf_text(export_files(export_request, "pdf")["exam-versions/A.pdf"].content, folder)
    assert shown.count("\f") <= 8
    pages = shown.split("\f")
    for page in pages:
        assert page.count("The figure (not to scale)") == page.count("Joint 𝑖") == page.count("Task:")
    return pages


@pytest.mark.whole
def test_exam_of_six_problems_fits_on_eight_pages(six: ExportRequest, tmp_path: Path) -> None:
    shown = "".join(read_exam_pages(six, tmp_path))
    assert "•A." not in shown.replace(" ", "") and "typed" not in shown


@pytest.mark.whole  # a shorter test exports an exam of simpler arms
def test_exam_of_six_long_arms_fits_and_keeps_boxes_with_questions(tmp_path: Path) -> None:
    export_request = make_exam_request(tmp_path / "exam", "exam_of_long_arms")
    pages = read_exam_pages(export_request, tmp_path)
    assert sum(page.count("Answer:") for page in pages) == 15
    assert all(page.count("Answer:") == len(re.findall(r"Answer(?!:)", page)) for page in pages)
    source = str(export_files(export_request, "latex")["exam-versions/A.tex"].content)
    assert source.count("fill\\nopagebreak") == 15  # working space fills the rest of a page


def test_figure_stands_beside_the_table_and_options_have_tick_boxes(six: ExportRequest) -> None:
    page = str(export_files(six, "html")["exam-versions/A.html"].content)
    source = str(export_files(six, "latex")["exam-versions/A.tex"].content)
    assert page.count('<div class="beside">') == 6 and source.count(r"\shrunk{\drawn}") >= 6
    assert page.count('<span class="tick">') == 5 + 4 + 4 + 2 == source.count(r"\option{\tick")
    assert "**A.**" not in page and r"\item \textbf{A.}" not in source


@pytest.mark.whole
def test_marking_sheet_lists_points_of_known_mistakes(six: ExportRequest, tmp_path: Path) -> None:
    export_request = replace(six, sheet="marking", assignment=replace(six.assignment, slots=six.assignment.slots[4:]))
    exported = export_files(export_request, "pdf")
    assert list(exported) == ["marking-versions/A.pdf", "marking-versions-all.pdf"]
    assert all(file.is_private for file in exported.values())
    shown = read_pdf_text(exported["marking-versions/A.pdf"].content, tmp_path)
    assert "Determinant" in shown
    page = str(export_files(export_request, "html")["marking-versions/A.html"].content)
    source = str(export_files(export_request, "latex")["marking-versions/A.tex"].content)
    assert page.count('class="marking"') == source.count(r"\begin{tabular}") == 6
    (sheet,) = make_sheets(export_request)
    for part in sheet.parts:
        assert part.marking is not None and part.marking.rule and not part.solution
        right, *wrong = part.marking.lines
        assert right.points == f"{part.max_points:.3g}" and right.answer
        assert all(float(mark.points) < part.max_points for mark in wrong)
    determinant = next(part for part in sheet.parts if part.label == "1.2").marking
    assert determinant is not None
    assert ("Determinant with the wrong sign", "0.8") in [(mark.title, mark.points) for mark in determinant.lines]


@pytest.mark.whole
def test_answer_too_wide_for_marking_sheet_refers_to_the_key(monkeypatch: pytest.MonkeyPatch) -> None:
    wide = generate(ProblemId("planar-rpr", 5, ("inverse-velocity", "determinant")))
    long, short = (explain_marking(wide, part, compute_earned_share).lines for part in wide.parts)
    assert TOO_LONG in {mark.answer for mark in long} and all(mark.answer for mark in long)  # no cell is empty
    assert TOO_LONG not in {mark.answer for mark in short}
    monkeypatch.setattr(marking, "MAX_WIDTH_RATIO", 0.1)
    assert explain_marking(wide, wide.parts[0], compute_earned_share).lines[0].answer == "see the key"


def test_marking_sheet_states_the_credit_rule_of_the_assignment() -> None:
    (part,) = (problem := generate(ProblemId("planar-2r", 1, ("jacobian",)))).parts
    credited = {by: replace(part, credit=Credit(by)) for by in ("", "entries", "columns", "whole")}
    rules = {by: explain_marking(problem, asked, compute_earned_share).rule for by, asked in credited.items()}
    assert "Each of the 4 entries: 0.5." in rules[""]
    assert "one other mistake explains everything that is wrong: 1." in rules[""]
    assert rules["entries"] and rules[""].startswith(rules["entries"]) and "one other mistake" not in rules["entries"]
    assert rules["columns"].startswith("Each right column: 1.") and rules["whole"] == "0 points."


def test_exam_versions_have_no_names_and_differ_from_student_problems(export_request: ExportRequest) -> None:
    exported = export_files(replace(export_request, sheet="exam", version_count=2), "html")
    assert list(exported) == ["exam-versions/A.html", "exam-versions/B.html"]
    sheets: list[Sheet] = list(make_sheets(replace(export_request, version_count=2)))
    assert [sheet.name for sheet in sheets] == ["Version A", "Version B"]
    student_tables = {sheet.problems[0].table for sheet in make_sheets(export_request)}
    assert len(student_tables | {sheet.problems[0].table for sheet in sheets}) == 4
    assert not any(student.id in str(file.content) for student in CLASS for file in exported.values())
    assert EXPORT_FORMATS["html"].count_steps(replace(export_request, version_count=2)) == 2
    with pytest.raises(QdotError, match="need the grader"):
        export_files(replace(export_request, sheet="marking"), "html")


def test_failing_export_format_does_not_stop_the_others(
    export_request: ExportRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A format may lack its library, or fail after its first file."""

    def failing(_: ExportRequest) -> Generator[ExportedFile, None, None]:
        yield ExportedFile("a", "")
        raise QdotError("nothing can be asked")

    monkeypatch.setitem(__import__("sys").modules, "typst", None)
    monkeypatch.setitem(EXPORT_FORMATS, "stack", replace(EXPORT_FORMATS["stack"], export=failing))
    command: list[str | Path] = ["export", export_request.assignment.folder, "--jobs", "1", "--out", tmp_path]
    message = run_and_fail(*command, "--to", "html", "--to", "pdf", "--to", "stack", "--to", "latex")
    assert make_install_command("pdf") in message and "stack: nothing can be asked" in message
    assert (tmp_path / "html" / "handout" / "ada.html").exists() and not (tmp_path / "pdf").exists()
    assert (tmp_path / "latex" / "handout" / "ada.tex").exists()


def test_options_are_checked_before_anything_is_written(export_request: ExportRequest, tmp_path: Path) -> None:
    command: list[str | Path] = [
        "export", export_request.assignment.folder, "--jobs", "1", "--out", tmp_path, "--to", "html",
    ]  # fmt: skip
    for options, message in (
        (["--to", "pfd"], "'pfd'"), (["--to", "canvas", "--sheet", "key", "--solutions"], "a key has no worked"),
        (["--sheet", "exams"], "'exams' (did you mean 'exam'?)"), (["--page", "a5"], "'a5'"),
    ):  # fmt: skip
        assert message in run_and_fail(*command, *options)
    assert not list(tmp_path.iterdir())


def test_latex_sheets_are_balanced_and_self_contained(export_request: ExportRequest) -> None:
    for request in (
        replace(export_request, sheet="exam"),
        replace(export_request, has_solutions=True),
        replace(export_request, sheet="key"),
    ):
        for file in export_files(request, "latex").values():
            source = str(file.content)
            begun, ended = (re.findall(rf"\\{word}\{{(\w+)\}}", source) for word in ("begin", "end"))
            assert sorted(begun) == sorted(ended) and begun.count("document") == 1
            assert not re.search(r"\\includegraphics|\\input\b|\\write18", source)
            assert r"Rates \& " in source


def compile_latex(source: str | bytes, folder: Path) -> str:
    program = require_program("pdflatex", LATEX, in_ci=False)
    (folder / "sheet.tex").write_text(str(source), encoding="utf-8")
    done = subprocess.run([program, "-interaction=nonstopmode", "sheet"], cwd=folder, capture_output=True)
    assert done.returncode == 0, done.stdout[-3000:]
    return (folder / "sheet.log").read_text(encoding="utf-8", errors="replace")


@pytest.mark.integration
@pytest.mark.parametrize("options", [{"has_solutions": True}, {"sheet": "key"}])
def test_latex_sheets_compile(export_request: ExportRequest, options: dict[str, Any], tmp_path: Path) -> None:
    """One handout with solutions, which has everything that other sheets have, and a key."""
    compile_latex(next(iter(export_files(replace(export_request, **options), "latex").values())).content, tmp_path)


@pytest.mark.integration
@pytest.mark.parametrize("convention", ["screws", "dh"])
def test_wide_table_of_oblique_axes_stays_within_the_page(convention: str, tmp_path: Path) -> None:
    """The table of axes is too wide to stand beside the figure; a DH table isn't."""
    export_request = ExportRequest(make_class(tmp_path / "hw", [Student("ada")]), find_failures)
    toml = '[[problem]]\nfamily = "planar-3r"\nvariation = "full"\nquestions = ["position"]\n'
    text = f'title = "T"\nkey = "hw"\n{toml}convention = "{convention}"\n'
    (export_request.assignment.folder / "assignment.toml").write_text(text)
    request = replace(export_request, assignment=load_assignment(export_request.assignment.folder))
    (file,) = export_files(request, "latex").values()
    assert "Overfull \\hbox" not in compile_latex(file.content, tmp_path)


def test_answer_box_has_room_for_working_and_shrinks_in_long_exams() -> None:
    assert AnswerBox(40).total_height > 40 + boxes.ROW_HEIGHT
    assert AnswerBox(40, rows=3).total_height == AnswerBox(40).total_height + 2 * boxes.ROW_HEIGHT
    assert AnswerBox(50, rows=2, row_height=9).total_height == AnswerBox(0, rows=2, row_height=9).total_height + 50
    assert AnswerBox(0, rows=3, units=("m", "m", "m")).total_height == AnswerBox(0).total_height  # side by side
    none, some, most = (compute_working_space("x" * length) for length in (0, 1000, 10_000))
    assert none < some < most == boxes.MAX_WORKING_SPACE
    two = [AnswerBox(20), AnswerBox(30)]
    assert compute_share_that_fits(two, fixed_height=100, page_height=500) == 1
    assert compute_share_that_fits(two, fixed_height=100, page_height=140) == 0.8
    assert compute_share_that_fits(two, fixed_height=500, page_height=100) == boxes.MIN_SHARE
    assert compute_share_that_fits([], fixed_height=500, page_height=100) == 1
    assert scale_working_space(AnswerBox(20), 1.0) == AnswerBox(20, min_working_space=20)
    # Closer on full pages.
    assert scale_working_space(AnswerBox(20), 0.65) == AnswerBox(13, min_working_space=round(20 * boxes.PACKED_SHARE))


PNG = bytes.fromhex(
    "89504e470d0a1a0a0000000d4948445200000001000000010802000000907753de0000000c49444154789c63f8cfc0000003010100c9fe92ef"
    "0000000049454e44ae426082"
)
FRONT_PAGE = read_data("assignments/front_page.toml")


@pytest.mark.parametrize("file_type", ["html", "pdf", "latex"])
def test_exam_has_a_front_page(file_type: str, tmp_path: Path) -> None:
    folder = make_class(tmp_path / "hw", CLASS[:1]).folder
    (folder / "assignment.toml").write_text(FRONT_PAGE)
    (folder / "logo.png").write_bytes(PNG)
    request = ExportRequest(load_assignment(folder), find_failures, sheet="exam")
    files: dict[str, Any] = {file.path: file.content for file in EXPORT_FORMATS[file_type].export(request)}
    if file_type == "pdf":
        heading = read_pdf_text(files["exam/ada.pdf"], tmp_path).split("90 minutes & 5 %")[0]
        assert heading.count("11 February 2027") == 1
        return
    page = str(files["exam/ada.html" if file_type == "html" else "exam/ada.tex"])
    assert "11 February 2027" in page and "into the boxes" in page
    assert ("data:image/png;base64," in page) if file_type == "html" else files["exam/logo.png"] == PNG


@pytest.mark.parametrize(("old", "new", "reason"), read_cases("refused")["front_pages"])
def test_error_in_front_page_names_its_line(old: str, new: str, reason: str, tmp_path: Path) -> None:
    folder = make_class(tmp_path / "hw", CLASS[:1]).folder
    (folder / "assignment.toml").write_text(FRONT_PAGE.replace(old, new))
    (folder / "logo.png").write_bytes(PNG)
    (folder / "roster.svg").write_text("id,name")
    with pytest.raises(QdotError) as caught:
        load_assignment(folder)
    assert re.search(".*".join(map(re.escape, reason.split(" … "))), str(caught.value))
