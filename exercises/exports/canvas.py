"""Export a quiz for Canvas as QTI 1.2. Canvas picks one variant of each question for each student.

Canvas has two kinds of quizzes, and each imports its own package. The kinds differ in questions with several numbers:
classic quizzes compare a blank with a list of accepted texts, New Quizzes with a pattern.
"""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass

from qdot.exercises.common.files import make_zip
from qdot.exercises.exports import items, platform_markup
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.exports.typed_numbers import DECIMALS_NOTE, list_accepted_texts, make_number_pattern
from qdot.exercises.writing.render import render

FILE_FOLDER = "%24IMS-CC-FILEBASE%24"
"""Canvas's placeholder $IMS-CC-FILEBASE$ for the folder of a package's files, percent-encoded."""


@dataclass(frozen=True)
class CanvasQuizKind:
    """A kind of quiz: its title, the end of its package's name, and the texts or patterns that it accepts for a number.

    `list_texts` returns these texts or, if `uses_patterns`, a single pattern.
    """

    title: str
    file_suffix: str
    list_texts: Callable[[items.NumberField], tuple[str, ...]]
    uses_patterns: bool = False


QUIZ_KINDS = (
    CanvasQuizKind("classic quizzes", "", lambda field: list_accepted_texts(field.value, field.tolerance)),
    CanvasQuizKind(
        "New Quizzes", "-new-quizzes", lambda field: (make_number_pattern(field.value, field.tolerance),), True
    ),
)


@dataclass(frozen=True)
class Blank:
    """A blank in the text of a question: its name, and the texts that are accepted in it."""

    name: str
    texts: tuple[str, ...]


def export_canvas(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield a package for each kind of quiz. From the package, Canvas imports a quiz and question banks."""
    assignment = request.assignment
    quiz_items = list(items.make_items_for_students(request))
    groups = items.group_items(quiz_items, request.report)
    images = items.collect_image_files(quiz_items)
    ident = f"qdot-{assignment.key}"
    for kind in QUIZ_KINDS:
        context = {
            "ident": ident, "key": assignment.key, "title": assignment.title, "groups": groups,
            "images": list(images), "kind": kind,
            "points": platform_markup.format_decimal(sum(group[0].points for group in groups.values())),
            "shows_values": request.has_solutions or request.includes_feedback("values"),
            "name_type": _name_question_type, "list_shares": _list_shares, "write_html": _write_html,
            "list_blanks": _list_blanks, "write_body": _write_body, "list_option_ids": items.list_option_ids,
            "write_line": platform_markup.write_line_html, "format_decimal": platform_markup.format_decimal,
            "format_limits": platform_markup.format_limits,
        }  # fmt: skip
        package: dict[str, str | bytes] = {
            "imsmanifest.xml": render("exports/canvas-manifest.xml.j2", **context),
            f"{ident}/{ident}.xml": render("exports/canvas-quiz.xml.j2", **context),
            f"{ident}/assessment_meta.xml": render("exports/canvas-meta.xml.j2", **context),
        }
        file_name = f"{assignment.key}{kind.file_suffix}.zip"
        request.report(f"{file_name} is for {kind.title}")
        yield ExportedFile(file_name, make_zip(package | images), is_private=True)


def _write_body(item: items.QuizItem, blanks: Sequence[Blank]) -> str:
    """Return the HTML of a question with its blanks; Canvas replaces a name in brackets with an input field."""
    body = items.append_boxes(_write_html(item.body), item.form, [f"[{blank.name}]" for blank in blanks])
    return f"{body}\n{DECIMALS_NOTE}" if blanks else body


def _write_html(body: Sequence[str | platform_markup.Picture]) -> str:
    return platform_markup.write_html_with_figures(
        body, lambda picture: f"{FILE_FOLDER}/images/{platform_markup.name_picture_file(picture)}"
    )


def _name_question_type(form: items.ItemForm) -> str:
    if isinstance(form, items.ChoiceForm):
        choice_type = "multiple_answers_question" if form.allows_several else "multiple_choice_question"
        return "true_false_question" if form.is_true_or_false else choice_type
    if isinstance(form, items.NumberForm):
        return "numerical_question" if len(form.fields) == 1 else "fill_in_multiple_blanks_question"
    return {"match": "matching_question", "text": "essay_question"}[form.kind]


def _list_blanks(form: items.ItemForm, kind: CanvasQuizKind) -> list[Blank]:
    """Return a blank for each of several numbers; an empty list for any other form."""
    if not isinstance(form, items.NumberForm) or len(form.fields) == 1:
        return []
    return [Blank(f"n{number}", kind.list_texts(field)) for number, field in enumerate(form.fields, 1)]


def _list_shares(count: int) -> list[str]:
    """Return the percentage of the points for each of `count` answers, with two decimals; their sum is 100."""
    share = round(100 / count, 2)
    return [f"{share:.2f}"] * (count - 1) + [f"{100 - share * (count - 1):.2f}"]
