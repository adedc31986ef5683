"""Export a quiz for Canvas as QTI 1.2. Canvas picks one variant of each question for each student."""

import itertools
from collections.abc import Generator, Sequence

from qdot.exercises.common.files import make_zip
from qdot.exercises.exports import items, platform_markup
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.writing.render import render

FILE_FOLDER = "%24IMS-CC-FILEBASE%24"
"""The folder in which Canvas stores the files of a package."""


def export_canvas(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield one package. From the package, Canvas imports a quiz and a question bank."""
    assignment = request.assignment
    quiz_items = list(items.make_items_for_students(request))
    if any(item.single_number_item for item in quiz_items):
        request.report("Canvas accepts one number per question, so questions on vectors and matrices ask for one entry")
    groups = items.group_items((item.single_number_item or item for item in quiz_items), request.report)
    images: dict[str, str | bytes] = {}
    for item in itertools.chain.from_iterable(groups.values()):
        images |= platform_markup.make_image_files((*item.body, *item.solution))
    ident = f"qdot-{assignment.key}"
    context = {
        "ident": ident, "key": assignment.key, "title": assignment.title, "groups": groups, "images": sorted(images),
        "points": platform_markup.format_decimal(sum(group[0].points for group in groups.values())),
        "shows_values": request.has_solutions or request.includes_feedback("values"),
        "name_type": _name_question_type, "list_shares": _list_shares, "write_html": _write_html,
        "write_line": platform_markup.write_line_html, "format_decimal": platform_markup.format_decimal,
        "format_limits": platform_markup.format_limits,
    }  # fmt: skip
    package: dict[str, str | bytes] = {
        "imsmanifest.xml": render("exports/canvas-manifest.xml.j2", **context),
        f"{ident}/{ident}.xml": render("exports/canvas-quiz.xml.j2", **context),
        f"{ident}/assessment_meta.xml": render("exports/canvas-meta.xml.j2", **context),
    }
    yield ExportedFile(f"{assignment.key}.zip", make_zip(package | dict(sorted(images.items()))), is_private=True)


def _write_html(body: Sequence[str | platform_markup.Picture]) -> str:
    return platform_markup.write_html_with_figures(
        body, lambda p: f"{FILE_FOLDER}/images/{platform_markup.name_picture_file(p)}"
    )


def _name_question_type(form: items.ItemForm) -> str:
    if isinstance(form, items.ChoiceForm):
        choice_type = "multiple_answers_question" if form.allows_several else "multiple_choice_question"
        return "true_false_question" if form.is_true_or_false else choice_type
    other_types = {"match": "matching_question", "numbers": "numerical_question", "text": "essay_question"}
    return other_types[form.kind]


def _list_shares(count: int) -> list[str]:
    """Return the percentage of the points for each of `count` stems to match, with two decimals; their sum is 100."""
    share = round(100 / count, 2)
    return [f"{share:.2f}"] * (count - 1) + [f"{100 - share * (count - 1):.2f}"]
