"""Export a test as a QTI 2.1 package, with formulas as MathML. Each slot is a section that contains its variants.

The platform picks one variant of each slot at random, with all of its parts in order. If the assignment shows
solutions, a student sees the solution of an item after full marks or after the last attempt.
"""

import re
from collections.abc import Generator

from qdot.exercises.common.files import make_zip
from qdot.exercises.exports import platform_markup
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.exports.items import NumberForm, QuizItem, collect_image_files, make_items_for_students
from qdot.exercises.formula.printers.mathml import print_plain_mathml
from qdot.exercises.writing.render import render

MAX_EXPLAINED_FIELDS = 4
"""Maximum number of fields of an item that explains wrong numbers; with more fields, the item would be too long."""

ROUNDING_SHARE = 1e-6
"""The share of full marks that may be missing, because shares are rounded."""

_STYLE = re.compile(r' style="[^"]*"')


def export_qti(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield a package with the test, its items and their figures."""
    assignment = request.assignment
    files: dict[str, str | bytes] = {}
    resources = []
    variants_by_slot: dict[str, dict[str, list[str]]] = {}
    titles: dict[str, str] = {}
    points_by_question: dict[str, float] = {}
    quiz_items = list(make_items_for_students(request))
    for item in quiz_items:
        files[f"items/{item.key}.xml"] = _render_item(item, request.attempt_count)
        resources.append({"ident": item.key, "images": list(collect_image_files([item]))})
        slot_name, variant_number, kind = item.key.split("-", 2)
        variants_by_slot.setdefault(slot_name, {}).setdefault(f"{slot_name}-{variant_number}", []).append(item.key)
        titles[slot_name] = item.category.slot_title
        points_by_question[f"{slot_name}-{kind}"] = item.points
    sections = [
        {"ident": slot_name, "title": titles[slot_name], "variants": list(variants.items())}
        for slot_name, variants in variants_by_slot.items()
    ]
    ident = f"qdot-{assignment.key}"
    test = render(
        "exports/qti-test.xml.j2", ident=ident, title=assignment.title, sections=sections, tries=request.attempt_count,
        points=platform_markup.format_decimal(sum(points_by_question.values())),
    )  # fmt: skip
    manifest = render("exports/qti-manifest.xml.j2", ident=ident, resources=resources)
    package = {"imsmanifest.xml": manifest, "test.xml": test} | files | collect_image_files(quiz_items)
    yield ExportedFile(f"{assignment.key}.zip", make_zip(package), is_private=True)


def _write_html(body: tuple[str | platform_markup.Picture, ...]) -> str:
    """Return Markdown with figures in QTI's subset of XHTML: block elements without styles."""
    html = platform_markup.write_html_with_figures(
        body, lambda picture: f"../images/{platform_markup.name_picture_file(picture)}", print_plain_mathml
    )
    return _STYLE.sub("", html)


def _write_line_html(text: str) -> str:
    return _STYLE.sub("", platform_markup.write_line_html(text, print_plain_mathml))


def _render_item(item: QuizItem, attempt_count: int) -> str:
    return render(
        "exports/qti-item.xml.j2", item=item, form=item.form, tries=attempt_count,
        points=platform_markup.format_decimal(item.points),
        full=platform_markup.format_decimal(item.points * (1 - ROUNDING_SHARE)),
        share=platform_markup.format_decimal(item.points / item.form.correct_count),
        body=_write_html(item.body), solution=_write_html(item.solution), write_line=_write_line_html,
        format_decimal=platform_markup.format_decimal, format_tolerance=platform_markup.format_tolerance,
        names_mistakes=isinstance(item.form, NumberForm) and len(item.form.fields) <= MAX_EXPLAINED_FIELDS,
    )  # fmt: skip
