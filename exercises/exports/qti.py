"""A test and its items as a QTI 2.1 package: mathematics as MathML, a section for each place, of its variants.

Of each place one variant is drawn, with all of its parts in their order. Where the assignment tells solutions, one is
told when an item has full marks, or has been tried as often as it may be.
"""

import re
from collections.abc import Generator

from qdot.exercises.answers import LETTERS
from qdot.exercises.exports.items import Choose, Field, Item, Match, Numeric, Picture, as_told
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
from qdot.exercises.exports.outlet import File, Order
from qdot.exercises.formula.printers.mathml import plain_mathml
from qdot.exercises.writing.render import render

MOST_FIELDS = 4
"""Fields of an item up to which a wrong number is told the mistake behind it; it is long otherwise."""

TRIES = 3
"""Attempts at an item, where the assignment does not limit them itself."""
NEARLY = 1e-6
"""What shares that are rounded may lack of full marks."""

_STYLE = re.compile(r' style="[^"]*"')


def qti_zip(order: Order) -> Generator[File, None, None]:
    """Yield one package of a test, its items and their figures."""
    assignment = order.assignment
    files: dict[str, str | bytes] = {}
    images: dict[str, str | bytes] = {}
    resources = []
    places: dict[str, dict[str, list[str]]] = {}
    titles: dict[str, str] = {}
    tries, total = assignment.attempts.best_of or TRIES, dict[str, float]()
    for one in as_told(order):
        files[f"items/{one.key}.xml"] = render("exports/qti-item.xml.j2", tries=tries, **_item(one))
        drawn = {file_name(p): svg_file(p) for p in (*pictures(one.body), *pictures(one.solution))}
        images |= {f"images/{name}": content for name, content in drawn.items()}
        resources.append({"ident": one.key, "images": sorted(drawn)})
        place, number, kind = one.key.split("-", 2)
        places.setdefault(place, {}).setdefault(f"{place}-{number}", []).append(one.key)
        titles[place] = one.category[1]
        total[f"{place}-{kind}"] = one.points
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
    """Return a text as QTI's own part of XHTML: blocks, and no style."""
    return _STYLE.sub("", body_html(body, _source, plain_mathml))


def _line(text: str) -> str:
    return _STYLE.sub("", line_html(text, plain_mathml))


def _item(one: Item) -> dict[str, object]:
    """Return an item as the template shows it."""
    form = one.form
    told: dict[str, object] = {
        "ident": one.key,
        "title": one.title,
        "points": decimal(one.points),
        "full": decimal(one.points * (1 - NEARLY)),
        "body": _html(one.body),
        "solution": _html(one.solution),
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
            for letter, text, option in zip(LETTERS, form.shown, form.options, strict=False)
        ]
        right = sum(option.right for option in form.options)
        told |= {
            "type": "choose",
            "options": options,
            "share": decimal(one.points / right),
            "feedback": [(f"wrong-{option['ident']}", option["feedback"]) for option in options if option["feedback"]],
        }
    elif isinstance(form, Match):
        told |= {
            "type": "match",
            "stems": [(f"S{k}", _line(stem)) for k, stem in enumerate(form.shown)],
            "targets": [(f"T{number}", option) for number, option in enumerate(form.options)],
            "pairs": [f"S{number} T{index}" for number, index in enumerate(form.correct)],
            "share": decimal(one.points / len(form.stems)),
        }
    else:
        told |= _numbers(form, one.points)
    return told


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
            "value": decimal(one.value),
            "tolerance": allowance(one.tolerance),
            "advice": one.advice,
        }
        for k, one in enumerate(entry.wrong if telling else (), 1)
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
