"""A test and its items as a QTI 2.1 package: formulas as MathML, and a section with the variants of each slot.

From each slot one variant is picked at random, with all of its parts in order. If the assignment shows solutions, a
student sees the solution of an item after full marks or after the last attempt.
"""

import re
from collections.abc import Generator

from qdot.exercises.exports.export_format import File, Order, archive
from qdot.exercises.exports.items import Item, Numeric, items_without_hidden_solutions
from qdot.exercises.exports.markup import (
    Picture,
    allowance,
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


def export_qti(order: Order) -> Generator[File, None, None]:
    """Yield a package with the test, its items and their figures."""
    assignment = order.assignment
    files: dict[str, str | bytes] = {}
    images: dict[str, str | bytes] = {}
    resources = []
    places: dict[str, dict[str, list[str]]] = {}
    titles: dict[str, str] = {}
    tries, total = assignment.attempts.best_of or TRIES, dict[str, float]()
    for item in items_without_hidden_solutions(order):
        files[f"items/{item.key}.xml"] = _item(item, tries)
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


def _item(item: Item, tries: int) -> str:
    return render(
        "exports/qti-item.xml.j2", item=item, form=item.form, tries=tries, points=decimal(item.points),
        full=decimal(item.points * (1 - NEARLY)), share=decimal(item.points / item.form.count_of_right),
        body=_html(item.body), solution=_html(item.solution), line=_line, decimal=decimal, allowance=allowance,
        names_mistakes=isinstance(item.form, Numeric) and len(item.form.fields) <= MOST_FIELDS,
    )  # fmt: skip
