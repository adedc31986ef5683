"""Export to Moodle: a question bank as Moodle XML, and a complete quiz, which picks a variant of every question.

The bank has a category for every slot and question, and a question for every variant. moodle_quiz makes the quiz.
"""

import base64
import html
import math
from collections.abc import Generator, Sequence

from qdot.exercises.exports.export_format import File, Order
from qdot.exercises.exports.items import Choose, Field, Item, Match, Numeric, group_by_category, items
from qdot.exercises.exports.markup import (
    Picture,
    allowance,
    body_html,
    decimal,
    line_html,
    pictures,
    svg_file,
    text_html,
)
from qdot.exercises.exports.moodle_quiz import Answer, Box, Category, Question, quiz_backup
from qdot.exercises.writing.render import render

FRACTIONS = {1: "100", 2: "50", 3: "33.33333", 4: "25", 5: "20", 6: "16.66667", 7: "14.28571", 8: "12.5"}
"""The credit for each correct option, by the number of correct options, as in Moodle's list of grades."""

WEIGHTS = {True: 1, False: 2}
"""The weight of a field if its value is zero (True), and otherwise (False): zeros are often obvious."""

DIGITS = 14
"""Significant digits of a number in Moodle."""

WIDTH = 12
"""Minimum width of a box, in characters; a longer number in the question makes it wider."""

NAMES = str.maketrans("<>", "‹›")
"""Replacements for the characters that Moodle would take for a tag in a name, and remove."""

LONGEST, LONGEST_ID = 255, 100
"""Maximum length of a name and of an id in Moodle, in characters."""


def export_moodle(order: Order) -> Generator[File, None, None]:
    """Yield two files for Moodle: a question bank to import, and the backup of a quiz to restore."""
    assignment = order.assignment
    categories = [
        Category(tuple(moodle_name(name) for name in names), tuple(_question(item, assignment.key) for item in group))
        for names, group in group_by_category(items(order)).items()
    ]
    groups = [{"path": category_path(category.names), "questions": category.questions} for category in categories]
    xml = render("exports/moodle.xml.j2", categories=groups, title=assignment.title)
    yield File(f"{assignment.key}.xml", xml, private=True)
    yield File(f"{assignment.key}.mbz", quiz_backup(order, categories), private=True)


def moodle_name(text: str) -> str:
    """Return a name that Moodle stores unchanged: without tags, and short enough for its database column."""
    plain_name = text.translate(NAMES)
    return plain_name if len(plain_name) <= LONGEST else f"{plain_name[: LONGEST - 1].rstrip()}…"


def category_path(names: Sequence[str]) -> str:
    """Return a category's path in Moodle's tree; a slash in a name is doubled."""
    return "/".join(["$course$", "top", *(name.replace("/", "//") for name in names)])


def _question(item: Item, key: str) -> Question:
    form, body = item.form, _html(item.body)
    boxes = _boxes(form) if isinstance(form, Numeric) else ()
    return Question(
        name=moodle_name(item.title),
        type=_type(form),
        body=_insert_boxes(body, form, [box.notation for box in boxes]),
        numbered=_insert_boxes(body, form, [f"{{#{number}}}" for number in range(1, len(boxes) + 1)]),
        files=_files(item.body),
        solution=_html(item.solution),
        solution_files=_files(item.solution),
        points=item.points,
        idnumber=f"{key}-{item.key}"[-LONGEST_ID:],
        tags=("qdot", item.category[1], item.category[2]),
        hints=tuple(text_html(hint) for hint in item.hints),
        answers=_options(form) if isinstance(form, Choose) else (),
        several=isinstance(form, Choose) and form.several,
        pairs=_pairs(form) if isinstance(form, Match) else (),
        boxes=boxes,
    )


def _type(form: Choose | Match | Numeric) -> str:
    if isinstance(form, Choose):
        return "truefalse" if form.is_true_or_false else "multichoice"
    if isinstance(form, Match):
        return "matching"
    return "numerical" if len(form.fields) == 1 else "cloze"


def _html(body: Sequence[str | Picture]) -> str:
    return body_html(body, lambda picture: f"@@PLUGINFILE@@/{picture.name}.svg")


def _files(body: Sequence[str | Picture]) -> tuple[tuple[str, str], ...]:
    return tuple((f"{picture.name}.svg", base64.b64encode(svg_file(picture)).decode()) for picture in pictures(body))


def _options(form: Choose) -> tuple[Answer, ...]:
    credit = FRACTIONS[form.count_of_right]
    wrong_credit = f"-{credit}" if form.several else "0"
    return tuple(
        Answer(
            text if form.is_true_or_false else line_html(text),
            credit if option.right else wrong_credit,
            html.escape(option.feedback),
        )
        for _, text, option in form.choices
    )


def _pairs(form: Match) -> tuple[tuple[str, str], ...]:
    pairs = [(line_html(stem), form.options[index]) for _, stem, index in form.pairs]
    distractors = [option for index, option in enumerate(form.options) if index not in form.correct]
    return (*pairs, *(("", option) for option in distractors))


# --- numbers ---


def _boxes(form: Numeric) -> tuple[Box, ...]:
    """Return a box for every field.

    If there are several boxes, Moodle makes each as wide as the longest number among its answers. A filler answer in
    each box makes all boxes equally wide.
    """
    answers_by_field = [_numbers(field) for field in form.fields]
    max_length = max(WIDTH, *(len(answer.text) for answers in answers_by_field for answer in answers))
    filler = Answer(_filler_number(max_length), "0", "", "0")
    return tuple(
        _box(field, (*answers, filler) if len(answers_by_field) > 1 else answers)
        for field, answers in zip(form.fields, answers_by_field, strict=True)
    )


def _box(field: Field, answers: tuple[Answer, ...]) -> Box:
    weight = WEIGHTS[round(field.value, 9) == 0]
    quoted_answers = [(answer, _escape_feedback(answer.feedback)) for answer in answers]
    return Box(answers, weight, render("exports/moodle-box.txt.j2", weight=weight, answers=quoted_answers).strip())


def _numbers(field: Field) -> tuple[Answer, ...]:
    def answer(value: float, tolerance: float, fraction: str, feedback: str) -> Answer:
        return Answer(_number(value, tolerance), fraction, html.escape(feedback, quote=False), allowance(tolerance))

    wrong = (answer(wrong.value, wrong.tolerance, "0", wrong.advice) for wrong in field.wrong)
    return (answer(field.value, field.tolerance, "100", ""), *wrong)


def _number(value: float, tolerance: float) -> str:
    """Return a number rounded to a thousandth of its tolerance, as Moodle shows it after the attempt.

    >>> _number(-0.70710678118, 0.0035), _number(2.0, 0.0), _number(0.70710678118, 5e-12)
    ('-0.707107', '2', '0.70710678118')
    """
    rounded = round(value, 3 - math.floor(math.log10(tolerance))) if tolerance else value
    return decimal(rounded, DIGITS)


def _filler_number(characters: int) -> str:
    """Return a number with this many characters, in Moodle's notation, that no student would answer.

    >>> _filler_number(12)
    '-1.23456E+99'
    """
    return f"-1.{'23456789' * 3}"[: characters - 4] + "E+99"


def _insert_boxes(body: str, form: Choose | Match | Numeric, shown: Sequence[str]) -> str:
    """Return a text followed by its boxes, in a column with names or as a matrix. With one box, return it unchanged."""
    if not isinstance(form, Numeric) or len(shown) < 2:
        return body
    boxes = iter(shown)
    rows = [
        [
            entry
            if isinstance(entry, str)
            else {"label": line_html(f"${entry.label}$"), "unit": entry.unit, "box": next(boxes)}
            for entry in row
        ]
        for row in form.rows
    ]
    fields = render("exports/moodle-fields.html.j2", rows=rows, column=len(form.rows[0]) == 1)
    return f"{body}\n{fields.strip()}"


def _escape_feedback(feedback: str) -> str:
    r"""Return HTML escaped for the feedback of an embedded answer, which `}`, `#` and `~` would end.

    Moodle resolves entities, and removes the backslash only before the first two of these characters.

    >>> _escape_feedback("R_{1} ~ 2 &lt; 3")
    'R_{1\\} ∼ 2 &amp;lt; 3'
    """
    escaped_feedback = html.escape(feedback, quote=False).replace("~", "∼")
    return escaped_feedback.replace("}", r"\}").replace("#", r"\#")
