"""Moodle's question bank as Moodle XML: a category for every place and question, a question for every variant."""

import base64
import html
import math
from collections.abc import Generator, Sequence

from exercises.exports.items import Choose, Field, Item, Match, Numeric, Picture, items
from exercises.exports.markup import (
    allowance,
    body_html,
    by_category,
    decimal,
    line_html,
    pictures,
    svg_file,
    text_html,
)
from exercises.exports.outlet import File, Order
from exercises.render import render

FRACTIONS = {1: "100", 2: "50", 3: "33.33333", 4: "25", 5: "20", 6: "16.66667", 7: "14.28571", 8: "12.5"}
"""The share of each of so many right options, as Moodle's list of grades has it."""

WEIGHTS = {True: 1, False: 2}
"""The weight of a field whose value is zero, and of any other: zeros are often seen at once."""

DIGITS = 14
"""Significant digits that Moodle keeps of a number."""

WIDTH = 12
"""How many characters the widest number is long that a box is to be made for, unless one of its question is longer."""

NAMES = str.maketrans("<>", "‹›")
"""What stands for the signs that Moodle takes for a tag in a name, and cuts."""


def moodle_xml(order: Order) -> Generator[File, None, None]:
    """Yield one file, which Moodle imports into its question bank."""
    assignment = order.assignment
    categories = [
        {"path": _path(category), "questions": [_question(one, assignment.key) for one in group]}
        for category, group in by_category(list(items(order))).items()
    ]
    page = render("exports/moodle.xml.j2", categories=categories, title=assignment.title)
    yield File(f"{assignment.key}.xml", page, private=True)


def _path(names: Sequence[str]) -> str:
    """Return a category's place in Moodle's tree; a slash in a name is doubled."""
    return "/".join(["$course$", "top", *(name.translate(NAMES).replace("/", "//") for name in names)])


def _question(one: Item, key: str) -> dict[str, object]:
    form, body = one.form, _html(one.body)
    made: dict[str, object] = {
        "name": one.title,
        "type": _type(form),
        "body": body,
        "files": [(f"{p.name}.svg", _base64(svg_file(p))) for p in pictures(one.body)],
        "solution": _html(one.solution),
        "solution_files": [(f"{p.name}.svg", _base64(svg_file(p))) for p in pictures(one.solution)],
        "points": decimal(one.points),
        "idnumber": f"{key}-{one.key}"[-100:],
        "tags": ["qdot", one.category[1], one.category[2]],
        "hints": [text_html(hint) for hint in one.hints],
        "form": form,
    }
    if isinstance(form, Choose):
        made["answers"] = _options(form)
    elif isinstance(form, Match):
        pairs = [(line_html(stem), form.options[index]) for stem, index in zip(form.stems, form.correct, strict=True)]
        left = [option for index, option in enumerate(form.options) if index not in form.correct]
        made["pairs"] = [*pairs, *(("", option) for option in left)]
    elif len(form.fields) == 1:
        made["field"] = _field(form.fields[0])
    else:
        made["body"] = body + "\n" + _cloze(form)
    return made


def _type(form: Choose | Match | Numeric) -> str:
    if isinstance(form, Choose):
        return "truefalse" if form.is_true_or_false else "multichoice"
    if isinstance(form, Match):
        return "matching"
    return "numerical" if len(form.fields) == 1 else "cloze"


def _options(form: Choose) -> list[dict[str, object]]:
    right = sum(option.right for option in form.options)
    share = FRACTIONS[right]
    wrong = f"-{share}" if form.several else "0"
    return [
        {
            "text": option.text if form.is_true_or_false else line_html(option.text),
            "fraction": share if option.right else wrong,
            "feedback": option.feedback,
        }
        for option in form.options
    ]


def _html(body: Sequence[str | Picture]) -> str:
    return body_html(body, lambda picture: f"@@PLUGINFILE@@/{picture.name}.svg")


def _field(field: Field) -> dict[str, object]:
    return {
        "value": _number(field.value, field.tolerance),
        "tolerance": allowance(field.tolerance),
        "wrong": [(_number(w.value, w.tolerance), allowance(w.tolerance), w.advice) for w in field.wrong],
    }


def _number(value: float, tolerance: float) -> str:
    """Return a number to a thousandth of what it may be off, as Moodle shows it after the attempt.

    >>> _number(-0.70710678118, 0.0035), _number(2.0, 0.0), _number(0.70710678118, 5e-12)
    ('-0.707107', '2', '0.70710678118')
    """
    rounded = round(value, 3 - math.floor(math.log10(tolerance))) if tolerance else value
    return decimal(rounded, DIGITS)


def _cloze(form: Numeric) -> str:
    """Return the fields as a column of names, or as a matrix, in the notation of embedded answers.

    Moodle makes a box as wide as the longest number that it knows for it, so every box is told of one as long.
    """
    rows = [[entry if isinstance(entry, str) else _box(entry) for entry in row] for row in form.rows]
    right = [_number(field.value, field.tolerance) for field in form.fields]
    wrong = [_number(one.value, one.tolerance) for field in form.fields for one in field.wrong]
    nobodys = _of_length(max(WIDTH, *map(len, right + wrong)))
    return render("exports/moodle-fields.html.j2", rows=rows, column=len(form.rows[0]) == 1, nobodys=nobodys).strip()


def _box(entry: Field) -> dict[str, object]:
    return {
        "label": line_html(f"${entry.label}$"),
        "unit": entry.unit,
        "weight": WEIGHTS[round(entry.value, 9) == 0],
        "value": _number(entry.value, entry.tolerance),
        "tolerance": allowance(entry.tolerance),
        "wrong": [(_number(w.value, w.tolerance), allowance(w.tolerance), _escaped(w.advice)) for w in entry.wrong],
    }


def _of_length(characters: int) -> str:
    """Return a number of so many characters, as Moodle stores it, that is nobody's answer.

    >>> _of_length(12)
    '-1.23456E+99'
    """
    return f"-1.{'23456789' * 3}"[: characters - 4] + "E+99"


def _escaped(text: str) -> str:
    r"""Return plain text as it may stand behind an embedded answer, which `}`, `#` and `~` would end.

    Moodle takes the backslash away before the first two only.

    >>> _escaped("R_{1} ~ 2 & 3")
    'R_{1\\} ∼ 2 &amp; 3'
    """
    shown = html.escape(text, quote=False).replace("~", "∼")
    return shown.replace("}", r"\}").replace("#", r"\#")


def _base64(content: bytes) -> str:
    return base64.b64encode(content).decode()
