"""Export to Moodle: a question bank as Moodle XML, and a complete quiz, which picks a variant of every question.

For each question of each slot of the assignment, the bank has a category with all variants. `moodle_quiz` makes the
quiz.
"""

import base64
import html
import math
from collections.abc import Generator, Sequence

from qdot.exercises.exports import items, platform_markup
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.exports.moodle_quiz import Category, InputBox, MoodleAnswer, MoodleQuestion, make_quiz_backup
from qdot.exercises.writing.render import render

CREDIT_PERCENTAGES = {1: "100", 2: "50", 3: "33.33333", 4: "25", 5: "20", 6: "16.66667", 7: "14.28571", 8: "12.5"}
"""Maps the number of correct options to the percentage for each of them, which is from the list that Moodle accepts."""

ZERO_WEIGHT, NONZERO_WEIGHT = 1, 2
"""The weights of fields with the value zero and with other values. Zeros weigh less, because they are often obvious."""

DIGITS = 14
"""Significant digits of a number in Moodle."""

DECIMALS_NOTE = (
    "<p>Type only the number, as a decimal with a point and the minus sign of the keyboard, for example -0.25 or "
    "-2.5e-1. If Moodle shows the marks of this question with a decimal comma (1,00), type a comma instead of the "
    "point (-0,25). A fraction (1/4) or a name before the number (v = 0.25) counts as wrong.</p>"
)
"""Instructions for students on boxes for numbers.

Moodle reads 1/4 as the number 1 with a unit and 0,25 as 25 in English. It can't read −0.25 with U+2212, or v = 0.25. In
languages with a decimal comma, it reads 0.25 as 0.25, but calls the answer incomplete, because a point may separate
thousands. No question type avoids this: questions for numbers accept no other forms, except units after a number in a
single box, and questions that compare texts have no tolerance.
"""

MIN_BOX_WIDTH = 12
"""Minimum width of a box in characters. If a number in the question is longer, the box is wider."""

MAX_NAME_LENGTH, MAX_ID_LENGTH = 255, 100
"""Maximum length of a name and of an id in Moodle, in characters."""


def export_moodle(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield two files for Moodle: a question bank to import, and the backup of a quiz to restore."""
    assignment = request.assignment
    groups = items.group_items(items.make_items(request), request.report)
    categories = [
        Category(make_category_names(item_category), tuple(_make_question(item, assignment.key) for item in group))
        for item_category, group in groups.items()
    ]
    records = [{"path": make_category_path(category.names), "questions": category.questions} for category in categories]
    xml = render("exports/moodle.xml.j2", categories=records, title=assignment.title)
    yield ExportedFile(f"{assignment.key}.xml", xml, is_private=True)
    yield ExportedFile(f"{assignment.key}.mbz", make_quiz_backup(request, assignment.key, categories), is_private=True)


def make_moodle_name(text: str) -> str:
    """Return a name that Moodle stores unchanged: without tags, and short enough for its database column."""
    plain_name = platform_markup.replace_angle_brackets(text)
    return plain_name if len(plain_name) <= MAX_NAME_LENGTH else f"{plain_name[: MAX_NAME_LENGTH - 1].rstrip()}…"


def make_category_names(category: items.ItemCategory) -> tuple[str, ...]:
    """Return the names of a category and of its parent categories, the outermost first."""
    return tuple(map(make_moodle_name, category.path))


def make_category_path(names: Sequence[str]) -> str:
    """Return a category's path in Moodle's tree; a slash in a name is doubled."""
    return "/".join(["$course$", "top", *(name.replace("/", "//") for name in names)])


def _make_question(item: items.QuizItem, assignment_key: str) -> MoodleQuestion:
    form, body = item.form, _write_body(item)
    boxes = _make_boxes(form) if isinstance(form, items.NumberForm) else ()
    numbered_boxes = [f"{{#{number}}}" for number in range(1, len(boxes) + 1)]
    return MoodleQuestion(
        make_moodle_name(item.title), _name_question_type(form), item.points,
        body=items.append_boxes(body, form, [box.notation for box in boxes]),
        body_with_numbered_boxes=items.append_boxes(body, form, numbered_boxes), files=_encode_pictures(item.body),
        solution=_write_html(item.solution), solution_files=_encode_pictures(item.solution),
        id_number=f"{assignment_key}-{item.key}"[-MAX_ID_LENGTH:],
        tags=("qdot", item.category.slot_title, item.category.question_title),
        hints=tuple(map(platform_markup.write_html, item.hints)), boxes=boxes,
        answers=_make_option_answers(form) if isinstance(form, items.ChoiceForm) else (),
        allows_several=isinstance(form, items.ChoiceForm) and form.allows_several,
        pairs=_make_pairs(form) if isinstance(form, items.MatchingForm) else (),
        penalty=1.0 if isinstance(form, items.ChoiceForm) and form.is_true_or_false else 1 / 3,
    )  # fmt: skip


def _name_question_type(form: items.ItemForm) -> str:
    if isinstance(form, items.ChoiceForm):
        return "truefalse" if form.is_true_or_false else "multichoice"
    if isinstance(form, items.MatchingForm):
        return "matching"
    if isinstance(form, items.TextForm):
        return "essay"
    return "numerical" if len(form.fields) == 1 else "cloze"


def _write_body(item: items.QuizItem) -> str:
    has_decimals = isinstance(item.form, items.NumberForm) and any(field.tolerance for field in item.form.fields)
    return f"{_write_html(item.body)}\n{DECIMALS_NOTE}" if has_decimals else _write_html(item.body)


def _write_html(body: Sequence[str | platform_markup.Picture]) -> str:
    return platform_markup.write_html_with_figures(body, lambda picture: f"@@PLUGINFILE@@/{picture.name}.svg")


def _encode_pictures(body: Sequence[str | platform_markup.Picture]) -> tuple[tuple[str, str], ...]:
    return tuple(
        (f"{picture.name}.svg", base64.b64encode(platform_markup.make_svg_file(picture)).decode())
        for picture in platform_markup.find_pictures(body)
    )


def _make_option_answers(form: items.ChoiceForm) -> tuple[MoodleAnswer, ...]:
    percentage = CREDIT_PERCENTAGES[form.correct_count]
    wrong_percentage = f"-{percentage}" if form.allows_several else "0"
    write_text = str if form.is_true_or_false else platform_markup.write_line_html
    return tuple(
        MoodleAnswer(
            write_text(text), percentage if option.is_correct else wrong_percentage, html.escape(option.feedback)
        )
        for _, text, option in form.lettered_options
    )


def _make_pairs(form: items.MatchingForm) -> tuple[tuple[str, str], ...]:
    pairs = [(platform_markup.write_line_html(stem), form.options[index]) for _, stem, index in form.lettered_stems]
    distractors = [option for index, option in enumerate(form.options) if index not in form.correct_indices]
    return (*pairs, *(("", option) for option in distractors))


# --- numbers ---


def _make_boxes(form: items.NumberForm) -> tuple[InputBox, ...]:
    """Return a box for every field.

    Moodle makes each of several boxes as wide as the longest number among its answers. So that all boxes are equally
    wide, each box gets one more answer, a filler.
    """
    answers_by_field = [_make_number_answers(field) for field in form.fields]
    max_length = max(MIN_BOX_WIDTH, *(len(answer.text) for answers in answers_by_field for answer in answers))
    filler = MoodleAnswer(_make_filler_number(max_length), "0", "", "0")
    boxes = []
    for field, answers in zip(form.fields, answers_by_field, strict=True):
        all_answers = (*answers, filler) if len(answers_by_field) > 1 else answers
        cloze_answers = [(answer, _escape_feedback(answer.feedback)) for answer in all_answers]
        weight = ZERO_WEIGHT if field.is_zero else NONZERO_WEIGHT
        notation = render("exports/moodle-box.txt.j2", weight=weight, answers=cloze_answers).strip()
        boxes.append(InputBox(all_answers, weight, notation))
    return tuple(boxes)


def _make_number_answers(field: items.NumberField) -> tuple[MoodleAnswer, ...]:
    def make_answer(value: float, tolerance: float, percentage: str, feedback: str) -> MoodleAnswer:
        number, feedback_html = _format_number(value, tolerance), html.escape(feedback, quote=False)
        return MoodleAnswer(number, percentage, feedback_html, platform_markup.format_tolerance(tolerance))

    wrong_answers = (
        make_answer(wrong_value.value, wrong_value.tolerance, "0", wrong_value.feedback)
        for wrong_value in field.wrong_values
    )
    return (make_answer(field.value, field.tolerance, "100", ""), *wrong_answers)


def _format_number(value: float, tolerance: float) -> str:
    """Return a number rounded to a thousandth of its tolerance, as Moodle shows it after the attempt.

    >>> _format_number(-0.70710678118, 0.0035), _format_number(2.0, 0.0), _format_number(0.70710678118, 5e-12)
    ('-0.707107', '2', '0.70710678118')
    """
    rounded_value = round(value, 3 - math.floor(math.log10(tolerance))) if tolerance else value
    return platform_markup.format_decimal(rounded_value, DIGITS)


def _make_filler_number(length: int) -> str:
    """Return a number of a given length in Moodle's notation that no student would answer.

    >>> _make_filler_number(12)
    '-1.23456E+99'
    """
    return f"-1.{'23456789' * 3}"[: length - 4] + "E+99"


def _escape_feedback(feedback: str) -> str:
    r"""Escape HTML as feedback in a Cloze answer; an unescaped `}`, `#` or `~` would end the feedback.

    `}` and `#` get a backslash. Moodle would keep a backslash before `~`, so `~` is replaced. Moodle resolves entities
    once more, so they are escaped.

    >>> _escape_feedback("R_{1} ~ 2 &lt; 3")
    'R_{1\\} ∼ 2 &amp;lt; 3'
    """
    escaped_feedback = html.escape(feedback, quote=False).replace("~", "∼")
    return escaped_feedback.replace("}", r"\}").replace("#", r"\#")
