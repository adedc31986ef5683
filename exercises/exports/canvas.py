"""Export of a quiz for Canvas as QTI 1.2. Each student gets one variant from a group for each slot and question."""

from collections.abc import Generator, Sequence

from qdot.exercises.exports.export_format import File, Order, archive
from qdot.exercises.exports.items import Choose, Match, Numeric, group_by_category, items_without_hidden_solutions
from qdot.exercises.exports.markup import (
    Picture,
    body_html,
    decimal,
    file_name,
    limits,
    line_html,
    pictures,
    svg_file,
)
from qdot.exercises.writing.render import render

IMAGES = "%24IMS-CC-FILEBASE%24"
"""The folder in which Canvas stores the files of a package."""


def export_canvas(order: Order) -> Generator[File, None, None]:
    """Yield one package, which Canvas imports as a quiz and a question bank."""
    assignment = order.assignment
    items = list(items_without_hidden_solutions(order))
    if any(item.number for item in items):
        order.note("Canvas takes one number a question: of vectors and matrices one entry is asked for")
    groups = group_by_category(item.number or item for item in items)
    images = {
        f"images/{file_name(picture)}": svg_file(picture)
        for group in groups.values() for item in group for picture in pictures((*item.body, *item.solution))
    }  # fmt: skip
    ident = f"qdot-{assignment.key}"
    context = {
        "ident": ident, "key": assignment.key, "title": assignment.title, "groups": groups, "images": sorted(images),
        "points": decimal(sum(group[0].points for group in groups.values())),
        "tells_values": order.solutions or order.tells("values"),
        "type_of": _type, "shares_of": _shares, "html": _html, "line": line_html, "decimal": decimal, "limits": limits,
    }  # fmt: skip
    package: dict[str, str | bytes] = {
        "imsmanifest.xml": render("exports/canvas-manifest.xml.j2", **context),
        f"{ident}/{ident}.xml": render("exports/canvas-quiz.xml.j2", **context),
        f"{ident}/assessment_meta.xml": render("exports/canvas-meta.xml.j2", **context),
    }
    yield File(f"{assignment.key}.zip", archive(package | dict(sorted(images.items()))), private=True)


def _html(body: Sequence[str | Picture]) -> str:
    return body_html(body, lambda picture: f"{IMAGES}/images/{file_name(picture)}")


def _type(form: Choose | Match | Numeric) -> str:
    if isinstance(form, Choose):
        choice_type = "multiple_answers_question" if form.several else "multiple_choice_question"
        return "true_false_question" if form.is_true_or_false else choice_type
    return "matching_question" if isinstance(form, Match) else "numerical_question"


def _shares(count: int) -> list[str]:
    """Return the percentages of the points for `count` stems, to two decimals; they add up to 100."""
    share = round(100 / count, 2)
    return [f"{share:.2f}"] * (count - 1) + [f"{100 - share * (count - 1):.2f}"]
