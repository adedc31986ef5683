"""A test and its items as a QTI 2.1 package: formulas as MathML, and a section with the variants of each slot.

From each slot one variant is picked at random, with all of its parts in order. If the assignment shows solutions, a
student sees the solution of an item after full marks or after the last attempt.
"""

import re
from collections.abc import Generator

from qdot.exercises.answers import LETTERS
from qdot.exercises.exports.export_format import File, Order
from qdot.exercises.exports.items import Choose, Field, Item, Match, Numeric, Picture, items_without_hidden_solutions
from qdot.exercises.exports.markup import (
    allowance,
    archive,
    body_html,
    decimal,
    file_name,
    line_html,
    pictures,
    svg_file,
)
from qdot.exercises.formula.printers.mathml import plain_mathml
from qdot.exercises.writing.render import render

MOST_FIELDS = 4
"""Items with more fields name no mistakes behind wrong numbers, as they would become too long."""

TRIES = 3
"""Attempts at an item, unless the assignment limits them."""
NEARLY = 1e-6
"""Rounded shares may fall short of full marks by this share."""

_STYLE = re.compile(r' style="[^"]*"')


def qti_zip(order: Order) -> Generator[File, None, None]:
    """Yield a package with the test, its items and their figures."""
    assignment = order.assignment
    files: dict[str, str | bytes] = {}
    images: dict[str, str | bytes] = {}
    resources = []
    places: dict[str, dict[str, list[str]]] = {}
    titles: dict[str, str] = {}
    tries, total = assignment.attempts.best_of or TRIES, dict[str, float]()
    for item in items_without_hidden_solutions(order):
        files[f"items/{item.key}.xml"] = render("exports/qti-item.xml.j2", tries=tries, **_item(item))
        drawn = {file_name(p): svg_file(p) for p in (*pictures(item.body), *pictures(item.solution))}
        images |= {f"images/{name}": content for name, content in drawn.items()}
        resources.append({"ident": item.key, "images": sorted(drawn)})
        place, number, kind = item.key.split("-", 2)
        places.setdefault(place, {}).setdefault(f"{place}-{number}", []).append(item.key)
        titles[place] = item.category[1]
        total[f"{place}-{kind}"] = item.points
    sections = [
        {"ident": place, "title": titles[place], "variants": list(variants.items())}
        for place, variants in places.items()
    ]
    ident = f"qdot-{assignment.key}"
    points = decimal(sum(total.values()))
    about = {"ident": ident, "title": assignment.title, "sections": sections, "tries": tries, "points": points}
    test = render("exports/qti-test.xml.j2", **about)
    manifest = render("exports/qti-manifest.xml.j2", ident=ident, resources=resources)
    package = {"imsmanifest.xml": manifest, "test.xml": test} | files | dict(sorted(images.items()))
    yield File(f"{assignment.key}.zip", archive(package), private=True)


def _source(picture: Picture) -> str:
    return f"../images/{file_name(picture)}"


def _html(body: tuple[str | Picture, ...]) -> str:
    """Return a text in QTI's subset of XHTML: blocks, and no style."""
    return _STYLE.sub("", body_html(body, _source, plain_mathml))


def _line(text: str) -> str:
    return _STYLE.sub("", line_html(text, plain_mathml))


def _item(item: Item) -> dict[str, object]:
    """Return the template context of an item."""
    form = item.form
    context: dict[str, object] = {
        "ident": item.key,
        "title": item.title,
        "points": decimal(item.points),
        "full": decimal(item.points * (1 - NEARLY)),
        "body": _html(item.body),
        "solution": _html(item.solution),
        "feedback": [],
        "type": "",
        "form": form,
    }
    if isinstance(form, Choose):
        options = [
            {
                "ident": letter,
                "text": _line(text),
                "right": option.right,
                "feedback": option.feedback,
            }
            for letter, text, option in zip(LETTERS, form.lettered_texts, form.options, strict=False)
        ]
        right = sum(option.right for option in form.options)
        context |= {
            "type": "choose",
            "options": options,
            "share": decimal(item.points / right),
            "feedback": [(f"wrong-{option['ident']}", option["feedback"]) for option in options if option["feedback"]],
        }
    elif isinstance(form, Match):
        context |= {
            "type": "match",
            "stems": [(f"S{k}", _line(stem)) for k, stem in enumerate(form.lettered_stems)],
            "targets": [(f"T{number}", option) for number, option in enumerate(form.options)],
            "pairs": [f"S{number} T{index}" for number, index in enumerate(form.correct)],
            "share": decimal(item.points / len(form.stems)),
        }
    else:
        context |= _numbers(form, item.points)
    return context


def _numbers(form: Numeric, points: float) -> dict[str, object]:
    count = len(form.fields)
    numbers = {id(field): number for number, field in enumerate(form.fields, 1)}
    telling = count <= MOST_FIELDS
    made = [[_field(entry, numbers.get(id(entry), 0), telling) for entry in row] for row in form.rows]
    fields = [field for row in made for field in row if field["ident"]]
    return {
        "type": "numbers",
        "rows": made,
        "column": len(form.rows[0]) == 1,
        "fields": fields,
        "share": decimal(points / count),
        "feedback": [(wrong["ident"], wrong["advice"]) for field in fields for wrong in field["wrong"]],  # type: ignore[attr-defined]
    }


def _field(entry: Field | str, number: int, telling: bool) -> dict[str, object]:
    if isinstance(entry, str):
        return {"ident": "", "text": entry}
    wrong = [
        {
            "ident": f"wrong-{number}-{k}",
            "value": decimal(wrong_value.value),
            "tolerance": allowance(wrong_value.tolerance),
            "advice": wrong_value.advice,
        }
        for k, wrong_value in enumerate(entry.wrong if telling else (), 1)
    ]
    return {
        "ident": f"R{number}",
        "text": "",
        "label": _line(f"${entry.label}$"),
        "unit": entry.unit,
        "value": decimal(entry.value),
        "tolerance": allowance(entry.tolerance),
        "wrong": wrong,
    }
