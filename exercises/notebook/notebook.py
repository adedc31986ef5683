"""Write problems as Jupyter notebooks (nbformat 4.5): with blanks for students, with answers and solutions for staff.

The same problems always give the same bytes: cell ids are made from the names of the parts, and nothing depends on the
time. A notebook contains no seed, so that a student can't regenerate the answers from it.
"""

import base64
import html
import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.figure.arm_figure import alt_text, figure_svg, part_alt, part_svg, singular_svg
from qdot.exercises.notebook.self_check import Problems, check_cell, function_cell
from qdot.exercises.notebook.setup_cell import setup_cell
from qdot.exercises.problem.problem import ENGINE, Part, Problem, answer_variable
from qdot.exercises.questions.differentiation import find_power_of_metres
from qdot.exercises.short_questions import ASKED
from qdot.exercises.writing.problem_texts import (
    write_answer_code,
    write_hints,
    write_prompt,
    write_solutions,
    write_statement,
)
from qdot.exercises.writing.render import render

if TYPE_CHECKING:  # importing it takes as long as generating a problem, and only writing a notebook needs it
    from nbformat import NotebookNode

KERNEL = {"display_name": "Python 3", "language": "python", "name": "python3"}


def student_notebook(
    title: str, key: str, student: str, problems: Problems, with_hints: bool = False
) -> "NotebookNode":
    """Return the notebook that a student fills in; `problems` are pairs (slot, problem) with slots p1, p2, …

    With `with_hints`, three hints that can be expanded follow every prompt.
    """
    return _notebook("student", title, key, student, problems, with_hints)


def solution_notebook(
    title: str,
    key: str,
    student: str,
    problems: Problems,
    with_hints: bool = False,
    released: "NotebookNode | None" = None,
) -> "NotebookNode":
    """Return the same notebook with the reference answers filled in and a worked solution for each part.

    If the `released` notebook is given, statements and prompts with their figures are copied from it.
    """
    texts = {cell.id: cell.source for cell in released.cells} if released is not None else {}
    return _notebook("solution", title, key, student, problems, with_hints, texts)


def notebook_text(notebook: Mapping[str, Any]) -> str:
    """Return the file's text: sorted keys, an indent of one space as in Jupyter's files, a newline at the end."""
    return json.dumps(notebook, indent=1, sort_keys=True, ensure_ascii=False) + "\n"


def figure_image(problem: Problem, name: str) -> str:
    """Return the arm's figure as an HTML image with its SVG inside, for Markdown; it shows in every notebook reader."""
    return _image(figure_svg(problem.chain, name), alt_text(problem.chain))


def _image(svg: str, alt: str) -> str:
    data = base64.b64encode(svg.encode()).decode()
    return f'<img alt="{html.escape(alt)}" src="data:image/svg+xml;base64,{data}" width="640">'


def solution_figure(problem: Problem, part: Part, name: str) -> str:
    """Return the SVG of the singular configurations for a worked solution, or "" if the answer is not a set."""
    return singular_svg(problem.chain, name) if part.answer.is_set else ""


FOLDED_CODE_METADATA: dict[str, object] = {"jupyter": {"source_hidden": True}, "cellView": "form"}
"""Metadata that folds a cell's code in JupyterLab, VS Code and Colab."""


def points_text(points: float) -> str:
    """Return points as in "1 point" or "2.5 points"."""
    return f"{points:g} {'point' if points == 1 else 'points'}"


def _notebook(
    kind: str, title: str, key: str, student: str, problems: Problems, with_hints: bool, texts: Mapping[str, str] = {}
) -> "NotebookNode":
    import nbformat
    from nbformat.v4 import new_notebook

    own_claims = notebook_claims(kind, key, student, problems)
    notebook = new_notebook(metadata={"kernelspec": KERNEL, "language_info": {"name": "python"}, "qdot": own_claims})
    has_tables = any(convention_of(problem.chain).shows_table for _, problem in problems)
    opening = render("notebook/title.md.j2", title=title, key=key, student=student, kind=kind, has_tables=has_tables)
    notebook.cells = [_markdown("title", opening), _code("setup", setup_cell(problems))]
    if checks := function_cell(problems):
        notebook.cells.append(_code("self-check", checks, FOLDED_CODE_METADATA))
    for number, (slot, problem) in enumerate(problems, 1):
        notebook.cells.extend(_problem_cells(kind, number, slot, problem, with_hints, texts))
    nbformat.validate(notebook)
    return notebook


def notebook_claims(kind: str, key: str, student: str, problems: Problems) -> dict[str, object]:
    """Return what the notebook's metadata says about its problems, for `qdot check`, which has no assignment.

    It has for each problem its symbols, its joint variables and the expected form of each answer. The grader does not
    trust this metadata.
    """
    content: dict[str, object] = {"assignment": key, "student": student, "engine": ENGINE, "kind": kind}
    content["symbols"] = {slot: sorted(problem.symbols()) for slot, problem in problems}
    content["joints"] = {slot: [q.name for q in problem.chain.q] for slot, problem in problems}
    content["answers"] = {slot: _answer_forms(problem) for slot, problem in problems}
    return content


def _answer_forms(problem: Problem) -> dict[str, dict[str, object]]:
    return {
        part.name: {key: value for key, value in _answer_form(problem, part).items() if value not in ([], None)}
        for part in problem.parts
    }


def _answer_form(problem: Problem, part: Part) -> dict[str, object]:
    question = ASKED[part.kind]
    labels, columns = question.list_typed_names(problem.chain, part), question.column_names(problem.chain)
    form = {"type": part.type, "shape": list(part.shape or ()), "units": list(part.answer.expected_units)}
    return form | {"labels": list(labels), "columns": list(columns), "metres": find_power_of_metres(part)}


def _problem_cells(
    kind: str, number: int, slot: str, problem: Problem, with_hints: bool, existing_texts: Mapping[str, str]
) -> "Iterator[NotebookNode]":
    """Yield the cells of a problem; `existing_texts` has the texts of a released notebook by the ids of their cells."""
    statement_id = f"{slot}-statement"
    opening = existing_texts.get(statement_id)
    if not opening:
        opening = write_statement(problem, f"{number} {problem.title}", figure_image(problem, slot))
    yield _markdown(statement_id, opening)
    solutions = write_solutions(problem) if kind == "solution" else {}
    for index, part in enumerate(problem.parts, 1):
        label = f"{number}.{index}"
        question_id = f"{slot}-{part.name}-question"
        yield _markdown(question_id, existing_texts.get(question_id) or _prompt(label, slot, problem, part, with_hints))
        code_start = f"{answer_variable(slot, part.name)} = "
        start_length = len(code_start)
        placeholder = part.answer.placeholder(start_length)
        source = placeholder if kind == "student" else write_answer_code(problem, part, start_length)
        code = _code(f"{slot}-{part.name}", code_start + source, {"qdot": {"part": f"{slot}.{part.name}"}})
        if part.name in solutions:  # the typeset answer comes before its code
            svg = solution_figure(problem, part, f"{slot}-{part.name}")
            figure = _image(svg, "The arm in a regular and in its singular configurations") if svg else ""
            text = render("notebook/solution.md.j2", number=label, solution=solutions[part.name], figure=figure)
            yield _markdown(f"{slot}-{part.name}-solution", text)
        yield code
        if checks := check_cell(slot, problem, part.name):
            yield _code(f"{slot}-{part.name}-check", checks)


def _prompt(label: str, slot: str, problem: Problem, part: Part, with_hints: bool) -> str:
    svg = part_svg(problem.chain, part, f"{slot}-{part.name}")
    figure = _image(svg, part_alt(problem.chain, part)) if svg else ""
    texts = {
        "prompt": write_prompt(problem, part),
        "figure": figure,
        "hints": write_hints(problem, part) if with_hints else (),
    }
    title, points = ASKED[part.kind].heading(problem.chain), points_text(part.points)
    return render("notebook/prompt.md.j2", number=label, title=title, points=points, **texts)


# --- cells ---


def _markdown(name: str, text: str) -> "NotebookNode":
    return _cell("markdown", name, text, {})


def _code(name: str, text: str, metadata: dict[str, object] | None = None) -> "NotebookNode":
    return _cell("code", name, text, metadata or {}, execution_count=None, outputs=[])


def _cell(kind: str, name: str, text: str, metadata: dict[str, object], **others: object) -> "NotebookNode":
    """Return a cell without validating it; `_notebook` validates the whole notebook."""
    from nbformat import NotebookNode

    return NotebookNode(id=name, cell_type=kind, source=text.strip(), metadata=NotebookNode(metadata), **others)
