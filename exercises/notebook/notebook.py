"""Write problems as Jupyter notebooks (nbformat 4.5): with blanks for students, with answers and solutions for staff.

The same problems always give the same bytes: the ids of the cells are made from the names of the parts, and nothing
depends on the time. A notebook contains no seed, so that students can't regenerate the answers from their notebooks.
"""

import base64
import html
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.common.notebook_limits import CELL_SECONDS, MEMORY_GIGABYTES, NOTEBOOK_SECONDS
from qdot.exercises.figure.arm_figure import describe_part_figure, draw_figure_svg, draw_part_svg, draw_singular_svg
from qdot.exercises.figure.words import describe_figure
from qdot.exercises.notebook.self_check import Problems, write_self_check_cell
from qdot.exercises.notebook.setup_cell import write_setup_cell
from qdot.exercises.problem.problem import ENGINE, Part, Problem, name_answer_variable
from qdot.exercises.questions.differentiation import find_determinant_power_of_metres
from qdot.exercises.reference_answers import ConditionSet
from qdot.exercises.short_questions import question_of
from qdot.exercises.writing import problem_texts
from qdot.exercises.writing.render import render

if TYPE_CHECKING:  # importing nbformat takes as long as generating a problem, so only writing a notebook does it
    from nbformat import NotebookNode

CHECK_PAGE = "check.html"
_PAGE_NAME = re.compile(r"(?<=/)[^/]+\.html$")
"""Matches the name of a page at the end of an address."""
KERNEL = {"display_name": "Python 3", "language": "python", "name": "python3"}


def write_notebook(notebook: Mapping[str, Any]) -> str:
    """Return a notebook as the text of a file: sorted keys, an indent of one space as in Jupyter, a final newline."""
    return json.dumps(notebook, indent=1, sort_keys=True, ensure_ascii=False) + "\n"


def write_answer_cell(part: str, text: str) -> str:
    """Return the code that gives a typed answer to a part with a name such as "p1.jacobian"."""
    return f"{name_answer_variable(*part.split('.', 1))} = {text!r}"


def fill_in_answers(notebook: str, answers: Mapping[str, str]) -> str:
    """Return a notebook, as the text of a file, with typed `answers` (by part) filled in."""
    if not answers:
        return notebook
    content = json.loads(notebook)
    for cell in content["cells"]:
        part = cell["metadata"].get("qdot", {}).get("part")
        if part in answers:
            cell["source"] = write_answer_cell(part, answers[part])
    return write_notebook(content)


def _embed_image(svg: str, alt_text: str) -> str:
    """Return an HTML image that embeds the SVG as base64. Every notebook reader shows such an image in Markdown."""
    data = base64.b64encode(svg.encode()).decode()
    return f'<img alt="{html.escape(alt_text)}" src="data:image/svg+xml;base64,{data}" width="640">'


def draw_singular_configurations(problem: Problem, part: Part, name: str) -> str:
    """Return the SVG of the singular configurations for a worked solution, or "" if they are not the answer.

    `name` begins the ids in the SVG.
    """
    is_answer = isinstance(part.answer, ConditionSet) and part.answer.is_singular_set
    return draw_singular_svg(problem.chain, name) if is_answer else ""


FOLDED_CODE_METADATA: dict[str, object] = {"jupyter": {"source_hidden": True}, "cellView": "form"}
"""Metadata that folds a cell's code in JupyterLab, VS Code and Colab."""


SELF_CHECK_TITLE = """## Check your answers

Run the next cell. It compares your answers with each other, such as your determinant with your Jacobian."""
"""The text of the cell before the cell with the checks."""


def make_check_page_address(site: str) -> str:
    """Return the address of the page on which students check their notebooks; `site` may be any page of the site.

    The link in a notebook names assignment and student after a #, so that the page can report a file of another
    student. A browser never sends this part to the server.
    """
    return f"{_PAGE_NAME.sub('', site).rstrip('/')}/{CHECK_PAGE}"


def write_points(points: float) -> str:
    """Return points in words, such as "1 point" or "2.5 points"."""
    return f"{points:g} {'point' if points == 1 else 'points'}"


@dataclass(frozen=True)
class NotebookContent:
    """The content of a student's notebook.

    `key` and `student` identify the assignment and the student. `problems` are pairs (slot, problem) with slots p1, p2,
    … If `with_hints`, every prompt is followed by three hints that can be expanded. `site` is the address of a site on
    which students can check the notebook, if there is one.
    """

    title: str
    key: str
    student: str
    problems: Problems
    with_hints: bool = False
    site: str = ""


def _make_notebook(
    kind: str, content: NotebookContent, released_notebook: "NotebookNode | None" = None
) -> "NotebookNode":
    """Return a notebook of a kind, "student" or "solution".

    Statements and prompts with their figures are copied from the `released_notebook` if there is one.
    """
    import nbformat
    from nbformat.v4 import new_notebook

    problems = content.problems
    metadata = make_notebook_metadata(kind, content.key, content.student, problems)
    notebook = new_notebook(metadata={"kernelspec": KERNEL, "language_info": {"name": "python"}, "qdot": metadata})
    has_tables = any(convention_of(problem.chain).shows_table for _, problem in problems)
    opening = render(
        "notebook/title.md.j2", title=content.title, key=content.key, student=content.student, kind=kind,
        has_tables=has_tables, check_page=make_check_page_address(content.site) if content.site else "",
        notebook_seconds=NOTEBOOK_SECONDS, cell_seconds=CELL_SECONDS, gigabytes=MEMORY_GIGABYTES,
    )  # fmt: skip
    notebook.cells = [_make_cell("markdown", "title", opening), _make_cell("code", "setup", write_setup_cell(problems))]
    released_texts = {cell.id: cell.source for cell in released_notebook.cells} if released_notebook else {}
    for number, (slot, problem) in enumerate(problems, 1):
        notebook.cells.extend(_make_problem_cells(kind, number, slot, problem, content.with_hints, released_texts))
    if check_code := write_self_check_cell(problems):
        notebook.cells.append(_make_cell("markdown", "self-check-title", SELF_CHECK_TITLE))
        notebook.cells.append(_make_cell("code", "self-check", check_code, FOLDED_CODE_METADATA))
    nbformat.validate(notebook)
    return notebook


make_student_notebook = partial(_make_notebook, "student")
"""Return the notebook that a student fills in."""
make_solution_notebook = partial(_make_notebook, "solution")
"""Return the notebook with the reference answers filled in and a worked solution for each part."""


def make_notebook_metadata(kind: str, key: str, student: str, problems: Problems) -> dict[str, object]:
    """Return the notebook's metadata about its problems, for `qdot check`, which has no assignment.

    For each problem, the metadata has the symbols, the joint variables and the expected form of each answer. The grader
    does not trust this metadata, because students can change it.
    """
    return {
        "assignment": key, "student": student, "engine": ENGINE, "kind": kind,
        "symbols": {slot: sorted(problem.symbols) for slot, problem in problems},
        "joints": {slot: [q.name for q in problem.chain.q] for slot, problem in problems},
        "answers": {slot: {p.name: _describe_form(problem, p) for p in problem.parts} for slot, problem in problems},
    }  # fmt: skip


def _describe_form(problem: Problem, part: Part) -> dict[str, object]:
    """Return the type, shape, units, labels and options of an answer; empty ones are omitted.

    `metres` is k if the unit of a determinant is m^k. The options are as in the prompt; they don't show which ones are
    correct. The texts of drawn options are empty, because they would reveal the configurations in the drawings.
    """
    question = question_of(part)
    form: dict[str, object] = {
        "type": part.type, "shape": list(part.shape or ()), "units": list(part.answer.expected_units),
        "labels": list(question.list_names_to_type(problem.chain, part)),
        "columns": list(question.name_columns(problem.chain)),
        "metres": find_determinant_power_of_metres(problem.chain, part),
        "options": ["" if part.details.has_drawn_options else option for option in part.answer.offered_options],
        "items": list(part.answer.matched_items),
    }  # fmt: skip
    return {key: value for key, value in form.items() if value not in ([], None)}


def _make_problem_cells(
    kind: str, number: int, slot: str, problem: Problem, with_hints: bool, released_texts: Mapping[str, str]
) -> "Iterator[NotebookNode]":
    """Yield the cells of a problem; `released_texts` has the texts of a released notebook by the ids of their cells."""
    statement_id = f"{slot}-statement"
    statement = released_texts.get(statement_id)
    if not statement:
        figure = _embed_image(draw_figure_svg(problem.chain, slot), describe_figure(problem.chain))
        statement = problem_texts.write_statement(problem, f"{number} {problem.title}", figure)
    yield _make_cell("markdown", statement_id, statement)
    solutions = problem_texts.write_solutions(problem) if kind == "solution" else {}
    for index, part in enumerate(problem.parts, 1):
        part_number, name = f"{number}.{index}", f"{slot}-{part.name}"
        prompt = released_texts.get(f"{name}-question") or _write_prompt(part_number, name, problem, part, with_hints)
        yield _make_cell("markdown", f"{name}-question", prompt)
        if part.name in solutions:  # the worked solution comes before the cell with the answer
            svg = draw_singular_configurations(problem, part, name)
            figure = _embed_image(svg, "The arm in a regular and in its singular configurations") if svg else ""
            text = render("notebook/solution.md.j2", number=part_number, solution=solutions[part.name], figure=figure)
            yield _make_cell("markdown", f"{name}-solution", text)
        left_side = f"{name_answer_variable(slot, part.name)} = "
        if kind == "student":
            right_side = part.answer.write_placeholder(len(left_side))
        else:
            right_side = problem_texts.write_answer_code(problem, part, len(left_side))
        yield _make_cell("code", name, left_side + right_side, {"qdot": {"part": f"{slot}.{part.name}"}})


def _write_prompt(part_number: str, name: str, problem: Problem, part: Part, with_hints: bool) -> str:
    """Return the prompt of a part as Markdown; `name` begins the ids in its figure."""
    svg = draw_part_svg(problem.chain, part, name)
    figure = _embed_image(svg, describe_part_figure(problem.chain, part)) if svg else ""
    hints = problem_texts.write_hints(problem, part) if with_hints else ()
    texts = {"prompt": problem_texts.write_prompt(problem, part), "figure": figure, "hints": hints}
    title = question_of(part).make_title(problem.chain)
    return render("notebook/prompt.md.j2", number=part_number, title=title, points=write_points(part.points), **texts)


def _make_cell(kind: str, name: str, text: str, metadata: Mapping[str, object] = {}) -> "NotebookNode":
    """Return a "markdown" or "code" cell without validating it; `_make_notebook` validates the whole notebook."""
    from nbformat import NotebookNode

    code_fields: dict[str, object] = {"execution_count": None, "outputs": []} if kind == "code" else {}
    return NotebookNode(id=name, cell_type=kind, source=text.strip(), metadata=NotebookNode(metadata), **code_fields)
