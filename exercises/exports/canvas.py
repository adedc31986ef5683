"""A quiz for Canvas as QTI 1.2: a group for every slot and question, from which each student gets one variant."""

from collections.abc import Generator, Sequence
from typing import Any

from qdot.exercises.answers import LETTERS
from qdot.exercises.exports.export_format import File, Order
from qdot.exercises.exports.items import Choose, Item, Match, Numeric, items_without_hidden_solutions
from qdot.exercises.exports.markup import (
    archive,
    body_html,
    decimal,
    file_name,
    group_by_category,
    limits,
    line_html,
    pictures,
    svg_file,
)
from qdot.exercises.writing.render import render

IMAGES = "%24IMS-CC-FILEBASE%24"
"""Where Canvas puts the files of a package."""


def canvas_zip(order: Order) -> Generator[File, None, None]:
    """Yield one package, which Canvas imports as a quiz and a question bank."""
    assignment = order.assignment
    files: dict[str, str | bytes] = {}
    groups: list[dict[str, Any]] = []
    for number, (category, group) in enumerate(
        group_by_category(list(items_without_hidden_solutions(order))).items(), 1
    ):
        questions = [_question(item, assignment.key, files) for item in group]
        title = f"{category[1]}: {category[2]}"
        groups.append(
            {"ident": f"g{number}", "title": title, "points": decimal(group[0].points), "questions": questions}
        )
    if any(question["reduced"] for group in groups for question in group["questions"]):
        order.note("Canvas takes one number a question: of vectors and matrices one entry is asked for")
    ident = f"qdot-{assignment.key}"
    context = {
        "ident": ident, "title": assignment.title, "groups": groups, "images": sorted(files),
        "points": decimal(sum(float(str(group["points"])) for group in groups)),
        "tells_values": order.solutions or order.tells("values"),
    }  # fmt: skip
    package: dict[str, str | bytes] = {
        "imsmanifest.xml": render("exports/canvas-manifest.xml.j2", **context),
        f"{ident}/{ident}.xml": render("exports/canvas-quiz.xml.j2", **context),
        f"{ident}/assessment_meta.xml": render("exports/canvas-meta.xml.j2", **context),
    }
    yield File(f"{assignment.key}.zip", archive(package | dict(sorted(files.items()))), private=True)


def _question(whole: Item, key: str, files: dict[str, str | bytes]) -> dict[str, object]:
    """Return the template context of a question, and add its figures to `files`."""
    item = whole.number or whole
    for picture in (*pictures(item.body), *pictures(item.solution)):
        files[f"images/{file_name(picture)}"] = svg_file(picture)
    form = item.form
    question: dict[str, object] = {
        "ident": f"{key}-{item.key}",
        "title": item.title,
        "points": decimal(item.points),
        "body": body_html(item.body, lambda picture: f"{IMAGES}/images/{file_name(picture)}"),
        "solution": body_html(item.solution, lambda picture: f"{IMAGES}/images/{file_name(picture)}"),
        "type": _type(form),
        "reduced": whole.number is not None,
        "options": (),
        "stems": (),
    }
    if isinstance(form, Choose):
        question["options"] = [
            {"ident": f"{key}-{item.key}-{letter}", "text": line_html(text), "option": option}
            for letter, text, option in zip(LETTERS, form.lettered_texts, form.options, strict=False)
        ]
    elif isinstance(form, Match):
        question |= _match_fields(form, f"{key}-{item.key}")
    else:
        (field,) = form.fields
        low, high = limits(field.value, field.tolerance)
        question |= {"value": decimal(field.value), "low": low, "high": high}
    return question


def _type(form: Choose | Match | Numeric) -> str:
    if isinstance(form, Choose):
        several = "multiple_answers_question" if form.several else "multiple_choice_question"
        return "true_false_question" if form.is_true_or_false else several
    return "matching_question" if isinstance(form, Match) else "numerical_question"


def _match_fields(form: Match, key: str) -> dict[str, object]:
    rights = [{"ident": f"{key}-o{index}", "text": option} for index, option in enumerate(form.options)]
    stems = [
        {
            "ident": f"response_{key}-{LETTERS[number]}",
            "text": line_html(stem),
            "right": rights[index]["ident"],
        }
        for number, (stem, index) in enumerate(zip(form.lettered_stems, form.correct, strict=True))
    ]
    return {"stems": stems, "rights": rights, "shares": _shares(stems)}


def _shares(stems: Sequence[object]) -> list[str]:
    """Return the percentage that each stem is worth, to two decimals; they add up to 100."""
    share = round(100 / len(stems), 2)
    return [f"{share:.2f}"] * (len(stems) - 1) + [f"{100 - share * (len(stems) - 1):.2f}"]
