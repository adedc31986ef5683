"""Write a problem in the formats of `qdot show`: text, LaTeX, HTML, JSON, notebook."""

import json
import re
import textwrap
from collections.abc import Callable, Mapping
from typing import Any

from qdot.exercises.common.errors import make_name_error
from qdot.exercises.figure.arm_figure import draw_figure_svg, draw_part_svg
from qdot.exercises.figure.words import describe_figure
from qdot.exercises.notebook import notebook
from qdot.exercises.notebook.self_check import Problems
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.problem.record import Json, make_arm_json, make_symbol_json
from qdot.exercises.short_questions import question_of
from qdot.exercises.writing import problem_texts
from qdot.exercises.writing.markup import escape_latex, to_html, to_latex, to_text
from qdot.exercises.writing.render import render

Converter = Callable[[str], str]
"""A function that converts Markdown to the markup of a format."""
HINT_LEAD = "**Hint {}.** "
"""The beginning of a hint in formats without hints that open on a click."""


def show(
    problem: Problem, solution: bool = False, format: str = "text", certificate: Mapping[str, Any] | None = None,
    hinted: bool = False,
) -> str:  # fmt: skip
    """Return the problem as text, latex, html, json or ipynb.

    `solution` adds reference answers and worked solutions, and `hinted` adds three hints to every prompt (JSON always
    has hints). A `certificate` is added to the JSON unchanged. Raises QdotError for any other format.

    >>> from qdot import generate
    >>> print(show(generate("planar-2r/7", ["determinant"])).splitlines()[0])
    Planar 2R arm (planar-2r/7)
    """
    if format == "json":
        return json.dumps(make_problem_json(problem, solution, certificate), indent=2, ensure_ascii=False) + "\n"
    return _write_document(format, problem.title, [("p1", problem)], solution, hinted)


def _describe_parts(
    problem: Problem, with_solutions: bool, with_hints: bool, convert: Converter, hint_lead: str = "",
    with_figures: bool = False,
) -> list[dict[str, object]]:  # fmt: skip
    """Return the texts and figures of each part for a template, in the markup that `convert` writes.

    `hint_lead` is the beginning of each hint, with {} for the hint's number.
    """
    solutions = problem_texts.write_solutions(problem) if with_solutions else {}

    def draw_solution(part: Part) -> str:
        is_shown = with_figures and with_solutions
        return notebook.draw_singular_configurations(problem, part, f"{part.name}-solution") if is_shown else ""

    return [
        {
            "name": part.name,
            "title": question_of(part).make_title(problem.chain),
            "points": notebook.write_points(part.points),
            "prompt": convert(problem_texts.write_prompt(problem, part)),
            "hints": [
                convert(hint_lead.format(number) + hint)
                for number, hint in enumerate(problem_texts.write_hints(problem, part) if with_hints else (), 1)
            ],
            "solution": convert(solutions[part.name]) if with_solutions else "",
            "code": problem_texts.write_answer_code(problem, part) if with_solutions and part.type != "text" else "",
            "figure": draw_part_svg(problem.chain, part, part.name) if with_figures else "",
            "solution_figure": draw_solution(part),
        }
        for part in problem.parts
    ]


def show_assignment(
    title: str, problems: Problems, solution: bool = False, format: str = "text",
    hinted: bool = False, site: str = "",
) -> str:  # fmt: skip
    """Return a student's problems, with the names of their slots, in one document; see `show` for the formats.

    A notebook links to the page of the `site` on which students check it, if there is a site.
    """
    if format == "json":
        slots = [{"slot": slot, **make_problem_json(problem, solution)} for slot, problem in problems]
        return json.dumps({"title": title, "problems": slots}, indent=2, ensure_ascii=False) + "\n"
    if format == "ipynb":
        return _write_ipynb(title, problems, solution, hinted, site)
    return _write_document(format, title, problems, solution, hinted)


def _write_document(format: str, title: str, problems: Problems, with_solutions: bool, with_hints: bool) -> str:
    if format not in FORMATS:
        raise make_name_error("format", format, ["text", "latex", "html", "json", "ipynb"])
    return FORMATS[format](title, problems, with_solutions, with_hints)


def _describe_problems(
    title: str, problems: Problems, describe: Callable[[str, Problem], dict[str, object]]
) -> dict[str, object]:
    """Return the values for a template: the title, the problems and a footer. Several problems are numbered.

    `describe` returns the values for a problem with its slot.
    """
    _, first_problem = problems[0]
    has_headings = len(problems) > 1 or title != first_problem.title
    problem_values = [
        {"heading": f"Problem {number}: {problem.title}" if has_headings else "", **describe(slot, problem)}
        for number, (slot, problem) in enumerate(problems, 1)
    ]
    footer = "; ".join(f"{problem.id}, engine {problem.id.engine}" for _, problem in problems)
    return {"title": title, "problems": problem_values, "footer": footer}


def _write_text(title: str, problems: Problems, with_solutions: bool, with_hints: bool) -> str:
    def describe(_: str, problem: Problem) -> dict[str, object]:
        figure = textwrap.fill(f"Figure: {describe_figure(problem.chain)}", 100)
        parts = _describe_parts(problem, with_solutions, with_hints, lambda text: to_text(text).rstrip(), HINT_LEAD)
        return {"statement": to_text(problem_texts.write_statement(problem, "")), "figure": figure, "parts": parts}

    values = _describe_problems(title, problems, describe)
    _, first_problem = problems[0]
    if len(problems) == 1 and title == first_problem.title:
        values["title"] = f"{title} ({first_problem.id})"
    return render("notebook/problem.txt.j2", **values)


def _write_latex(title: str, problems: Problems, with_solutions: bool, with_hints: bool) -> str:
    def describe(_: str, problem: Problem) -> dict[str, object]:
        statement = to_latex(problem_texts.write_statement(problem, ""))
        figure = escape_latex(describe_figure(problem.chain))
        parts = _describe_parts(problem, with_solutions, with_hints, lambda text: to_latex(text).rstrip(), HINT_LEAD)
        return {"statement": statement, "figure": figure, "parts": parts}

    return render("notebook/problem.tex.j2", **_describe_problems(title, problems, describe))


def _write_html(title: str, problems: Problems, with_solutions: bool, with_hints: bool) -> str:
    def describe(slot: str, problem: Problem) -> dict[str, object]:
        statement = to_html(problem_texts.write_statement(problem, ""))
        figure = draw_figure_svg(problem.chain, slot)
        parts = _describe_parts(problem, with_solutions, with_hints, to_html, with_figures=True)
        return {"statement": statement, "figure": figure, "parts": parts, "slot": slot}

    return render("notebook/problem.html.j2", **_describe_problems(title, problems, describe))


def _write_ipynb(title: str, problems: Problems, with_solutions: bool, with_hints: bool, site: str = "") -> str:
    make_notebook = notebook.make_solution_notebook if with_solutions else notebook.make_student_notebook
    _, first_problem = problems[0]
    key = re.sub("[^A-Za-z0-9._-]", "-", str(first_problem.id) if len(problems) == 1 else title)
    content = notebook.NotebookContent(title, key, "", problems, with_hints, site)
    return notebook.write_notebook(make_notebook(content))


FORMATS: dict[str, Callable[[str, Problems, bool, bool], str]] = {
    "text": _write_text, "latex": _write_latex, "html": _write_html, "ipynb": _write_ipynb,
}  # fmt: skip
"""Maps each format except JSON to the function that writes problems in it."""


# --- JSON ---


def make_problem_json(problem: Problem, with_solutions: bool, certificate: Mapping[str, Any] | None = None) -> Json:
    """Return the problem as plain data according to docs/schemas/show.json; each part includes its `hints`."""
    return {
        "id": str(problem.id), "family": problem.id.family, "seed": problem.id.seed,
        "variation": problem.id.variation, "engine": problem.id.engine, "title": problem.title,
        "robot": make_arm_json(problem.chain),
        "symbols": {name: make_symbol_json(info) for name, info in problem.symbols.items()},
        "statement": problem_texts.write_statement(problem, ""),
        "parts": [_make_part_json(problem, part, with_solutions) for part in problem.parts],
        **({} if certificate is None else {"certificate": dict(certificate)}),
    }  # fmt: skip


def _make_part_json(problem: Problem, part: Part, with_solutions: bool) -> Json:
    content: Json = {"name": part.name, "kind": part.kind, "type": part.type, "shape": part.shape and list(part.shape)}
    content |= {
        "prompt": problem_texts.write_prompt(problem, part), "points": part.points, "needs": list(part.prerequisites),
        "hints": list(problem_texts.write_hints(problem, part)),
        **part.answer.to_options_json(), **part.answer.to_tolerance_json(),
    }  # fmt: skip
    if with_solutions:
        content |= {"reference": part.answer.as_json(), "solution": problem_texts.write_solution(problem, part)}
    return content
