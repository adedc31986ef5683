"""Export of a test as a QTI 2.1 package, with formulas as MathML and a section with the variants of each slot.

The platform picks one variant of each slot at random, with all of its parts in order. If the assignment shows
solutions, a student sees the solution of an item after full marks or after the last attempt.
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
"""Maximum number of fields of an item that explains wrong numbers; with more fields, the item would be too long."""

TRIES = 3
"""Number of attempts at an item, unless the assignment limits them."""
NEARLY = 1e-6
"""The share of full marks that may be missing, because shares are rounded."""

_STYLE = re.compile(r' style="[^"]*"')


def export_qti(order: Order) -> Generator[File, None, None]:
    """Yield a package with the test, its items and their figures."""
    assignment = order.assignment
    files: dict[str, str | bytes] = {}
    images: dict[str, str | bytes] = {}
    resources = []
    variants_by_slot: dict[str, dict[str, list[str]]] = {}
    titles: dict[str, str] = {}
    tries, points_by_question = assignment.attempts.best_of or TRIES, dict[str, float]()
    for item in items_without_hidden_solutions(order):
        files[f"items/{item.key}.xml"] = _item(item, tries)
        item_images = {file_name(p): svg_file(p) for p in (*pictures(item.body), *pictures(item.solution))}
        images |= {f"images/{name}": content for name, content in item_images.items()}
        resources.append({"ident": item.key, "images": sorted(item_images)})
        slot_name, number, kind = item.key.split("-", 2)
        variants_by_slot.setdefault(slot_name, {}).setdefault(f"{slot_name}-{number}", []).append(item.key)
        titles[slot_name] = item.category[1]
        points_by_question[f"{slot_name}-{kind}"] = item.points
    sections = [
        {"ident": slot_name, "title": titles[slot_name], "variants": list(variants.items())}
        for slot_name, variants in variants_by_slot.items()
    ]
    ident = f"qdot-{assignment.key}"
    points = decimal(sum(points_by_question.values()))
    test_context = {"ident": ident, "title": assignment.title, "sections": sections, "tries": tries, "points": points}
    test = render("exports/qti-test.xml.j2", **test_context)
    manifest = render("exports/qti-manifest.xml.j2", ident=ident, resources=resources)
    package = {"imsmanifest.xml": manifest, "test.xml": test} | files | dict(sorted(images.items()))
    yield File(f"{assignment.key}.zip", archive(package), private=True)


def _source(picture: Picture) -> str:
    return f"../images/{file_name(picture)}"


def _html(body: tuple[str | Picture, ...]) -> str:
    """Return a text in QTI's subset of XHTML: block elements without styles."""
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
