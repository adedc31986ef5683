"""Quizzes for jupyterquiz in notebooks and Jupyter Book: a JSON file per question, and a notebook with all of them.

The page of such a quiz contains the answers, so it is for practice only. Formulas are MathML, which browsers render
themselves; MathJax is not available everywhere that a notebook may be opened.
"""

import base64
import json
from collections.abc import Generator
from html import escape

import nbformat
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

from qdot.exercises.exports.export_format import File, Order
from qdot.exercises.exports.items import Choose, Field, Item, Match, Picture, items
from qdot.exercises.exports.markup import body_html, decimal, group_by_category, limits, line_html, svg_file
from qdot.exercises.formula.printers.mathml import mathml
from qdot.exercises.notebook.notebook import KERNEL, notebook_text
from qdot.exercises.writing.render import plain, render

QuizQuestion = dict[str, object]
_NUDGE = 1e-9
"""Ranges exclude their upper end, so it is raised by this share of the value."""


def jupyterquiz_files(order: Order) -> Generator[File, None, None]:
    """Yield a list of variants for every slot and question, and the notebook that shows one of each."""
    groups = group_by_category(list(items(order)))
    reduced = False
    sections = []
    for group in groups.values():
        first = group[0]
        place, _, kind = first.key.split("-", 2)
        name = f"{place}-{kind}.json"
        questions = [_question(item.number or item) for item in group]
        reduced = reduced or any(item.number is not None or isinstance(item.form, Match) for item in group)
        yield File(name, json.dumps(questions, indent=1, ensure_ascii=True) + "\n", private=True)
        fixed = isinstance(first.form, Choose) and first.form.fixed
        sections.append(
            {"title": f"{first.category[1]}: {first.category[2]}", "file": name, "fixed": fixed, "key": name[:-5]}
        )
    if reduced:
        order.note(
            "jupyterquiz takes one number or one choice a question: of vectors, matrices and matches one is asked"
        )
    yield File("quizzes.ipynb", _notebook(order.assignment.title, sections), private=False)


def _notebook(title: str, sections: list[dict[str, object]]) -> str:
    cells = [new_markdown_cell(f"# {plain(title)}", id="title")]
    for section in sections:
        cells.append(new_markdown_cell(f"## {section['title']}", id=f"{section['key']}-title"))
        cells.append(
            new_code_cell(render("exports/jupyterquiz-cell.py.j2", **section).strip(), id=f"{section['key']}-quiz")
        )
    notebook = new_notebook(metadata={"kernelspec": KERNEL, "language_info": {"name": "python"}}, cells=cells)
    nbformat.validate(notebook)
    return notebook_text(notebook)


def _source(picture: Picture) -> str:
    return f"data:image/svg+xml;base64,{base64.b64encode(svg_file(picture)).decode()}"


def _separate_brackets(shown: str) -> str:
    """Return HTML with a space between adjacent brackets, which jupyterquiz would take for a Markdown link."""
    return shown.replace("](", "] (")


def _keep_table_size(shown: str) -> str:
    """Return HTML whose tables have the font size of the text: JupyterLab shrinks tables, jupyterquiz enlarges text."""
    return shown.replace("<table>", '<table style="font-size: inherit">')


def _question(item: Item) -> QuizQuestion:
    form, asked = item.form, _separate_brackets(_keep_table_size(body_html(item.body, _source, mathml)))
    if isinstance(form, Choose):
        answers = [
            {
                "answer": _separate_brackets(line_html(option.text, mathml)),
                "correct": option.right,
                "feedback": "Right." if option.right else escape(option.feedback, quote=False) or "Not this one.",
            }
            for option in form.options
        ]
        return {"question": asked, "type": "many_choice" if form.several else "multiple_choice", "answers": answers}
    if isinstance(form, Match):
        return _choice_of_stem(form, asked)
    (field,) = form.fields
    return {"question": asked, "type": "numeric", "answers": _values(field)}


def _choice_of_stem(form: Match, asked: str) -> QuizQuestion:
    """Return a question for the stem that belongs to the first option that has a stem."""
    wanted = min(form.correct)
    answers = [
        {
            "answer": _separate_brackets(line_html(stem, mathml)),
            "correct": index == wanted,
            "feedback": "Right." if index == wanted else "Not this one.",
        }
        for stem, index in zip(form.stems, form.correct, strict=True)
    ]
    text = render("exports/jupyterquiz-match.html.j2", asked=asked, option=form.options[wanted]).strip()
    return {"question": text, "type": "multiple_choice", "answers": answers}


def _values(field: Field) -> list[QuizQuestion]:
    answers: list[QuizQuestion] = [_value(field.value, field.tolerance, True, "Right.")]
    answers += [_value(wrong.value, wrong.tolerance, False, escape(wrong.advice, quote=False)) for wrong in field.wrong]
    return [*answers, {"type": "default", "feedback": "Not this number."}]


def _value(value: float, tolerance: float, correct: bool, feedback: str) -> QuizQuestion:
    if tolerance == 0:
        return {"type": "value", "value": float(decimal(value)), "correct": correct, "feedback": feedback}
    low, high = map(float, limits(value, tolerance))
    return {"type": "range", "range": [low, high + _NUDGE * abs(high)], "correct": correct, "feedback": feedback}
