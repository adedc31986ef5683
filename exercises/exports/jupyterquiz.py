"""Quizzes for notebooks and Jupyter Book as jupyterquiz reads them: a JSON file a question, and a notebook of all.

Whoever is shown such a quiz has the answers in the page: it is for practice. Mathematics is MathML, which browsers
show by themselves: whether there is a MathJax to be called depends on where a notebook is opened.
"""

import base64
import json
from collections.abc import Generator
from html import escape

import nbformat
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

from qdot.exercises.exports.items import Choose, Field, Item, Match, Picture, items
from qdot.exercises.exports.markup import body_html, by_category, decimal, limits, line_html, svg_file
from qdot.exercises.exports.outlet import File, Order
from qdot.exercises.formula.printers.mathml import mathml
from qdot.exercises.notebook.notebook import KERNEL, notebook_text
from qdot.exercises.writing.render import plain, render

QuizQuestion = dict[str, object]
_NUDGE = 1e-9
"""Ranges hold their beginning and not their end: so much of the value is added to it."""


def jupyterquiz_files(order: Order) -> Generator[File, None, None]:
    """Yield a list of questions for every place and question, and the notebook that shows one of each."""
    made = by_category(list(items(order)))
    reduced = False
    shown = []
    for group in made.values():
        first = group[0]
        place, _, kind = first.key.split("-", 2)
        name = f"{place}-{kind}.json"
        questions = [_question(one.number or one) for one in group]
        reduced = reduced or any(one.number is not None or isinstance(one.form, Match) for one in group)
        yield File(name, json.dumps(questions, indent=1, ensure_ascii=True) + "\n", private=True)
        fixed = isinstance(first.form, Choose) and first.form.fixed
        shown.append(
            {"title": f"{first.category[1]}: {first.category[2]}", "file": name, "fixed": fixed, "key": name[:-5]}
        )
    if reduced:
        order.note(
            "jupyterquiz takes one number or one choice a question: of vectors, matrices and matches one is asked"
        )
    yield File("quizzes.ipynb", _notebook(order.assignment.title, shown), private=False)


def _notebook(title: str, shown: list[dict[str, object]]) -> str:
    cells = [new_markdown_cell(f"# {plain(title)}", id="title")]
    for one in shown:
        cells.append(new_markdown_cell(f"## {one['title']}", id=f"{one['key']}-title"))
        cells.append(new_code_cell(render("exports/jupyterquiz-cell.py.j2", **one).strip(), id=f"{one['key']}-quiz"))
    notebook = new_notebook(metadata={"kernelspec": KERNEL, "language_info": {"name": "python"}}, cells=cells)
    nbformat.validate(notebook)
    return notebook_text(notebook)


def _source(picture: Picture) -> str:
    return f"data:image/svg+xml;base64,{base64.b64encode(svg_file(picture)).decode()}"


def _safe(shown: str) -> str:
    """Return HTML in which jupyterquiz finds no link of Markdown: brackets that meet are set apart."""
    return shown.replace("](", "] (")


def _as_large(shown: str) -> str:
    """Return HTML whose tables are as large as its text: JupyterLab makes tables smaller, jupyterquiz text larger."""
    return shown.replace("<table>", '<table style="font-size: inherit">')


def _question(one: Item) -> QuizQuestion:
    form, asked = one.form, _safe(_as_large(body_html(one.body, _source, mathml)))
    if isinstance(form, Choose):
        answers = [
            {
                "answer": _safe(line_html(option.text, mathml)),
                "correct": option.right,
                "feedback": "Right." if option.right else escape(option.feedback, quote=False) or "Not this one.",
            }
            for option in form.options
        ]
        return {"question": asked, "type": "many_choice" if form.several else "multiple_choice", "answers": answers}
    if isinstance(form, Match):
        return _one_of(form, asked)
    (field,) = form.fields
    return {"question": asked, "type": "numeric", "answers": _values(field)}


def _one_of(form: Match, asked: str) -> QuizQuestion:
    """Return a choice of the stem that belongs to one option, the first that has one."""
    wanted = min(form.correct)
    answers = [
        {
            "answer": _safe(line_html(stem, mathml)),
            "correct": index == wanted,
            "feedback": "Right." if index == wanted else "Not this one.",
        }
        for stem, index in zip(form.stems, form.correct, strict=True)
    ]
    text = render("exports/jupyterquiz-match.html.j2", asked=asked, option=form.options[wanted]).strip()
    return {"question": text, "type": "multiple_choice", "answers": answers}


def _values(field: Field) -> list[QuizQuestion]:
    answers: list[QuizQuestion] = [_value(field.value, field.tolerance, True, "Right.")]
    answers += [_value(one.value, one.tolerance, False, escape(one.advice, quote=False)) for one in field.wrong]
    return [*answers, {"type": "default", "feedback": "Not this number."}]


def _value(value: float, tolerance: float, correct: bool, feedback: str) -> QuizQuestion:
    if tolerance == 0:
        return {"type": "value", "value": float(decimal(value)), "correct": correct, "feedback": feedback}
    low, high = map(float, limits(value, tolerance))
    return {"type": "range", "range": [low, high + _NUDGE * abs(high)], "correct": correct, "feedback": feedback}
