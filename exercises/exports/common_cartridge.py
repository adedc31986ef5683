"""Export Common Cartridges (version 1.1), which Blackboard, Brightspace, Canvas, Moodle and other platforms import.

A cartridge has no random selection and at most one question bank. So one cartridge contains a quiz for each version,
with another variant of every question. Further cartridges contain the bank of one question each, for platforms that can
select a question from a bank at random. Cartridges have no type of question for numbers: a question asks for one number
and lists the texts that are accepted. Matching questions are left out, because cartridges can't contain them.
"""

import re
from collections.abc import Generator, Sequence
from dataclasses import dataclass

from qdot.exercises.common.files import make_zip
from qdot.exercises.exports import items, platform_markup
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.exports.typed_numbers import DECIMALS_NOTE, list_accepted_texts
from qdot.exercises.formula.printers.mathml import print_plain_mathml
from qdot.exercises.reference_answers import TRUE_FALSE
from qdot.exercises.writing.render import render

ROOT_FOLDER = "$IMS-CC-FILEBASE$.."
"""The root of a cartridge, as seen from a file in one of its folders. Platforms replace the name in dollar signs."""
MAX_ATTEMPTS = 5
"""The largest number of attempts that a cartridge can state."""


@dataclass(frozen=True)
class CartridgePart:
    """A quiz or a question bank of a cartridge: its identifier, title and items."""

    ident: str
    title: str
    items: Sequence[items.QuizItem]


def export_common_cartridge(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield a cartridge with a quiz for each version, then a cartridge for the bank of each question."""
    assignment = request.assignment
    title = platform_markup.replace_angle_brackets(assignment.title)
    all_items = list(items.make_items_for_students(request))
    omitted_categories = {item.category: None for item in all_items if isinstance(item.form, items.MatchingForm)}
    for category in omitted_categories:
        request.report(
            f"{category.slot_title}: {category.question_title} is left out, because a Common Cartridge has no matching "
            "questions"
        )
    reduced_categories = {item.category: None for item in all_items if item.single_number_item}
    if reduced_categories:
        names = ", ".join(f"{category.slot_title} ({category.question_title})" for category in reduced_categories)
        request.report(f"a question of a Common Cartridge has one number, so these ask for one entry only: {names}")
    single_items = [item.single_number_item or item for item in all_items if item.category not in omitted_categories]
    variants: dict[items.ItemCategory, list[items.QuizItem]] = {}
    for item in single_items:
        variants.setdefault(item.category, []).append(item)
    quizzes = [
        CartridgePart(f"version-{number}", f"{title}, version {number}", version_items)
        for number, version_items in enumerate(_choose_versions(list(variants.values())), 1)
    ]
    yield _make_cartridge(request, f"{assignment.key}.imscc", title, quizzes, is_bank=False)
    for category, bank_items in items.group_items(single_items, request.report).items():
        name = f"{category.slot_title.split()[0]}-{bank_items[0].key.split('-', 2)[2]}"  # as in p1-jacobian
        bank = CartridgePart("bank", f"{category.slot_title}: {category.question_title}", bank_items)
        yield _make_cartridge(request, f"banks/{name}.imscc", bank.title, [bank], is_bank=True)


def _choose_versions(groups: Sequence[Sequence[items.QuizItem]]) -> list[list[items.QuizItem]]:
    """Return the items of each version. A question with fewer variants repeats them."""
    version_count = max((len(group) for group in groups), default=0)
    return [[group[number % len(group)] for group in groups] for number in range(version_count)]


def _make_cartridge(
    request: ExportRequest, path: str, title: str, parts: Sequence[CartridgePart], is_bank: bool
) -> ExportedFile:
    images = items.collect_image_files(item for part in parts for item in part.items)
    image_ids = {image_path: f"image-{number}" for number, image_path in enumerate(images, 1)}
    context = {
        "ident": f"qdot-{re.sub(r'[^A-Za-z0-9.-]', '-', path)}", "key": request.assignment.key, "title": title,
        "parts": parts, "is_bank": is_bank, "image_ids": image_ids,
        "list_images": lambda part: items.collect_image_files(part.items),
        "attempts": min(request.assignment.attempt_policy.best_of or 1, MAX_ATTEMPTS), "name_profile": _name_profile,
        "list_option_ids": _list_option_ids, "write_body": _write_body, "write_html": _write_html,
        "write_line": _write_line, "list_texts": lambda field: list_accepted_texts(field.value, field.tolerance),
        "format_decimal": platform_markup.format_decimal,
    }  # fmt: skip
    files: dict[str, str | bytes] = {"imsmanifest.xml": render("exports/cartridge-manifest.xml.j2", **context)}
    for part in parts:
        files[f"{part.ident}/assessment.xml"] = render("exports/cartridge-part.xml.j2", part=part, **context)
    return ExportedFile(path, make_zip(files | images), is_private=True)


def _name_profile(form: items.ItemForm) -> str:
    """Return the name of a question type in the profile of QTI for Common Cartridges."""
    if isinstance(form, items.ChoiceForm):
        choice_type = "multiple_response" if form.allows_several else "multiple_choice"
        return "true_false" if form.is_true_or_false else choice_type
    return {"numbers": "fib", "text": "essay"}[form.kind]


def _list_option_ids(item_id: str, form: items.ItemForm) -> list[str]:
    """Return the identifier of each option. Platforms need the words true and false as identifiers of these options."""
    is_true_or_false = isinstance(form, items.ChoiceForm) and form.is_true_or_false
    return list(TRUE_FALSE) if is_true_or_false else items.list_option_ids(item_id, form)


def _write_body(item: items.QuizItem) -> str:
    body = _write_html(item.body)
    return f"{body}\n{DECIMALS_NOTE}" if isinstance(item.form, items.NumberForm) else body


def _write_html(body: Sequence[str | platform_markup.Picture]) -> str:
    return platform_markup.write_html_with_figures(
        body, lambda picture: f"{ROOT_FOLDER}/images/{platform_markup.name_picture_file(picture)}", print_plain_mathml
    )


def _write_line(text: str) -> str:
    return platform_markup.write_line_html(text, print_plain_mathml)
