"""Write a problem in the formats of `qdot show`: text, LaTeX, HTML, JSON, notebook."""

import json
import re
import textwrap
from collections.abc import Callable, Mapping
from typing import Any

from qdot.exercises.common.errors import make_name_error
from qdot.exercises.figure.arm_figure import alt_text, figure_svg, part_svg
from qdot.exercises.notebook.notebook import (
    notebook_text,
    points_text,
    solution_figure,
    solution_notebook,
    student_notebook,
)
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.problem.record import Json, robot_json, symbol_json
from qdot.exercises.short_questions import ASKED
from qdot.exercises.writing.markup import escape_latex, to_html, to_latex, to_text
from qdot.exercises.writing.problem_texts import (
    write_answer_code,
    write_hints,
    write_prompt,
    write_solution,
    write_solutions,
    write_statement,
)
from qdot.exercises.writing.render import render

Converter = Callable[[str], str]
"""A function that writes Markdown in the markup of a format."""
HINT_LEAD = "**Hint {}.** "
"""The beginning of a hint in formats in which hints can't be expanded."""


Certificate = Mapping[str, Any]


def show(
    problem: Problem, solution: bool = False, format: str = "text", certificate: Certificate | None = None,
    hinted: bool = False,
) -> str:  # fmt: skip
    """Return the problem as text, latex, html, json or ipynb, with reference answers and worked steps if `solution`.

    With `hinted`, three hints follow every prompt; JSON always has them. `certificate` is added to the JSON unchanged.
    Raises QdotError for any other format.

    >>> from qdot import generate
    >>> print(show(generate("planar-2r/7", ["determinant"])).splitlines()[0])
    Planar 2R arm (planar-2r/7)
    """
    if format not in FORMATS:
        raise make_name_error("format", format, list(FORMATS))
    if format == "json":
        return json.dumps(problem_json(problem, solution, certificate), indent=2, ensure_ascii=False) + "\n"
    return FORMATS[format](problem, solution, hinted)


def _part_views(
    problem: Problem, solution: bool, hinted: bool, convert: Converter, hint_lead: str = "", with_figures: bool = False
) -> list[dict[str, object]]:
    """Return the texts of each part in the markup that `convert` writes; `hint_lead` is the beginning of each hint.

    Figures are included if `with_figures`.
    """
    solutions = write_solutions(problem) if solution else {}
    views: list[dict[str, object]] = []
    for part in problem.parts:
        shown_hints = enumerate(write_hints(problem, part) if hinted else (), 1)
        view: dict[str, object] = {"name": part.name, "title": ASKED[part.kind].heading(problem.chain)}
        view |= {"points": points_text(part.points), "prompt": convert(write_prompt(problem, part))}
        view["hints"] = [convert(hint_lead.format(index) + hint) for index, hint in shown_hints]
        view["solution"] = convert(solutions[part.name]) if solution else ""
        view["code"] = write_answer_code(problem, part) if solution else ""
        view["figure"] = part_svg(problem.chain, part, part.name) if with_figures else ""
        has_solution_figure = with_figures and solution
        view["solution_figure"] = solution_figure(problem, part, f"{part.name}-solution") if has_solution_figure else ""
        views.append(view)
    return views


def _footer(problem: Problem) -> str:
    return f"{problem.id}, engine {problem.id.engine}"


def _as_text(problem: Problem, solution: bool, with_hints: bool) -> str:
    parts = _part_views(problem, solution, with_hints, lambda text: to_text(text).rstrip(), HINT_LEAD)
    texts = {"title": f"{problem.title} ({problem.id})", "statement": to_text(write_statement(problem, ""))}
    figure = textwrap.fill(f"Figure: {alt_text(problem.chain)}", 100)
    return render("notebook/problem.txt.j2", **texts, figure=figure, parts=parts, footer=_footer(problem))


def _as_latex(problem: Problem, solution: bool, with_hints: bool) -> str:
    parts = _part_views(problem, solution, with_hints, lambda text: to_latex(text).rstrip(), HINT_LEAD)
    title, figure = escape_latex(problem.title), escape_latex(alt_text(problem.chain))
    latex_statement = to_latex(write_statement(problem, ""))
    return render("notebook/problem.tex.j2", title=title, statement=latex_statement, figure=figure, parts=parts)


def _as_html(problem: Problem, solution: bool, with_hints: bool) -> str:
    parts = _part_views(problem, solution, with_hints, to_html, with_figures=True)
    texts = {
        "title": problem.title,
        "statement": to_html(write_statement(problem, "")),
        "figure": figure_svg(problem.chain),
    }
    return render("notebook/problem.html.j2", **texts, parts=parts, footer=_footer(problem))


def _as_notebook(problem: Problem, solution: bool, with_hints: bool) -> str:
    make_notebook = solution_notebook if solution else student_notebook
    key = re.sub("[/@+]", "-", str(problem.id))
    return notebook_text(make_notebook(problem.title, key, "", [("p1", problem)], with_hints))


# --- JSON ---


def problem_json(problem: Problem, solution: bool, certificate: Mapping[str, Any] | None = None) -> Json:
    """Return the problem as plain data according to docs/schemas/show.json; each part includes its `write_hints`."""
    content: Json = {"id": str(problem.id), "family": problem.id.family, "seed": problem.id.seed}
    content |= {"variation": problem.id.variation, "engine": problem.id.engine, "title": problem.title}
    symbols = {name: symbol_json(info) for name, info in problem.symbols().items()}
    content |= {"robot": robot_json(problem.chain), "symbols": symbols, "statement": write_statement(problem, "")}
    content["parts"] = [_part_json(problem, part, solution) for part in problem.parts]
    if certificate is not None:
        content["certificate"] = dict(certificate)
    return content


def _part_json(problem: Problem, part: Part, solution: bool) -> Json:
    content: Json = {"name": part.name, "kind": part.kind, "type": part.type, "shape": part.shape and list(part.shape)}
    content |= {"prompt": write_prompt(problem, part), "points": part.points, "needs": list(part.needs)}
    content |= {"hints": list(write_hints(problem, part)), **part.answer.options_json(), **part.answer.tolerance_json()}
    if solution:
        content["reference"] = part.answer.as_json()
        content["solution"] = write_solution(problem, part)
    return content


FORMATS: dict[str, Callable[[Problem, bool, bool], str]] = {
    "text": _as_text,
    "latex": _as_latex,
    "html": _as_html,
    "json": lambda problem, solution, _: show(problem, solution, "json"),
    "ipynb": _as_notebook,
}
"""Every format in which a problem can be shown, with the function that writes it."""
