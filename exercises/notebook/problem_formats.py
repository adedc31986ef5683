"""Write a problem in the formats of `qdot show`: text, LaTeX, HTML, JSON, notebook."""

import json
import re
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from qdot.exercises.common.errors import unknown_name
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
    answer_code,
    hints,
    prompt,
    statement,
    worked_solution,
    worked_solutions,
)
from qdot.exercises.writing.render import render

HINT_LEAD = "**Hint {}.** "
"""The beginning of a hint in formats in which hints can't be expanded."""


def show(
    problem: Problem,
    solution: bool = False,
    format: str = "text",
    certificate: Mapping[str, Any] | None = None,
    hinted: bool = False,
) -> str:
    """Return the problem as text, latex, html, json or ipynb, with reference answers and worked steps if `solution`.

    With `hinted`, three hints follow every prompt; JSON always has them. `certificate` is added to the JSON unchanged.
    Raises QdotError for another format.

    >>> from qdot import generate
    >>> print(show(generate("planar-2r/7", ["determinant"])).splitlines()[0])
    Planar 2R arm (planar-2r/7)
    """
    if format not in FORMATS:
        raise unknown_name("format", format, list(FORMATS))
    if format == "json":
        return json.dumps(problem_json(problem, solution, certificate), indent=2, ensure_ascii=False) + "\n"
    return FORMATS[format](problem, solution, hinted)


@dataclass(frozen=True)
class _PartView:
    """The texts of a part for a template, in the markup of the format."""

    name: str
    title: str
    points: str
    prompt: str
    hints: list[str]
    solution: str
    code: str
    figure: str
    solution_figure: str


def _part_views(
    problem: Problem,
    solution: bool,
    with_hints: bool,
    convert: Callable[[str], str],
    hint_lead: str = "",
    with_figures: bool = False,
) -> list[_PartView]:
    """Return the parts of a problem in the markup that `convert` writes; `hint_lead` is the beginning of each hint.

    Figures are included if `with_figures`.
    """
    solutions = worked_solutions(problem) if solution else {}
    return [
        _PartView(
            part.name,
            ASKED[part.kind].heading(problem.chain),
            points_text(part.points),
            convert(prompt(problem, part)),
            [convert(hint_lead.format(i) + hint) for i, hint in enumerate(hints(problem, part), 1)]
            if with_hints
            else [],
            convert(solutions[part.name]) if solution else "",
            answer_code(problem, part) if solution else "",
            part_svg(problem.chain, part, part.name) if with_figures else "",
            solution_figure(problem, part, f"{part.name}-solution") if with_figures and solution else "",
        )
        for part in problem.parts
    ]


def _footer(problem: Problem) -> str:
    return f"{problem.id}, engine {problem.id.engine}"


def _as_text(problem: Problem, solution: bool, with_hints: bool) -> str:
    return render(
        "notebook/problem.txt.j2",
        title=f"{problem.title} ({problem.id})",
        statement=to_text(statement(problem, "")),
        figure=textwrap.fill(f"Figure: {alt_text(problem.chain)}", 100),
        parts=_part_views(problem, solution, with_hints, lambda text: to_text(text).rstrip(), HINT_LEAD),
        footer=_footer(problem),
    )


def _as_latex(problem: Problem, solution: bool, with_hints: bool) -> str:
    return render(
        "notebook/problem.tex.j2",
        title=escape_latex(problem.title),
        statement=to_latex(statement(problem, "")),
        figure=escape_latex(alt_text(problem.chain)),
        parts=_part_views(problem, solution, with_hints, lambda text: to_latex(text).rstrip(), HINT_LEAD),
    )


def _as_html(problem: Problem, solution: bool, with_hints: bool) -> str:
    return render(
        "notebook/problem.html.j2",
        title=problem.title,
        statement=to_html(statement(problem, "")),
        figure=figure_svg(problem.chain),
        parts=_part_views(problem, solution, with_hints, to_html, with_figures=True),
        footer=_footer(problem),
    )


def _as_notebook(problem: Problem, solution: bool, with_hints: bool) -> str:
    make_notebook = solution_notebook if solution else student_notebook
    key = re.sub("[/@+]", "-", str(problem.id))
    return notebook_text(make_notebook(problem.title, key, "", [("p1", problem)], with_hints))


# --- JSON ---


def problem_json(problem: Problem, solution: bool, certificate: Mapping[str, Any] | None = None) -> Json:
    """Return the problem as plain data according to docs/schemas/show.json; each part includes its `hints`."""
    content: Json = {
        "id": str(problem.id),
        "family": problem.id.family,
        "seed": problem.id.seed,
        "variation": problem.id.variation,
        "engine": problem.id.engine,
        "title": problem.title,
        "robot": robot_json(problem.chain),
        "symbols": {name: symbol_json(info) for name, info in problem.symbols().items()},
        "statement": statement(problem, ""),
        "parts": [_part_json(problem, part, solution) for part in problem.parts],
    }
    if certificate is not None:
        content["certificate"] = dict(certificate)
    return content


def _part_json(problem: Problem, part: Part, solution: bool) -> Json:
    content: Json = {
        "name": part.name,
        "kind": part.kind,
        "type": part.type,
        "shape": None if part.shape is None else list(part.shape),
        "prompt": prompt(problem, part),
        "points": part.points,
        "needs": list(part.needs),
        "hints": list(hints(problem, part)),
    }
    content |= part.answer.options_json()
    content |= part.answer.tolerance_json()
    if solution:
        content["reference"] = part.answer.as_json()
        content["solution"] = worked_solution(problem, part)
    return content


FORMATS: dict[str, Callable[[Problem, bool, bool], str]] = {
    "text": _as_text,
    "latex": _as_latex,
    "html": _as_html,
    "json": lambda problem, solution, _: show(problem, solution, "json"),
    "ipynb": _as_notebook,
}
"""Every format in which a problem can be shown, with the function that writes it."""
