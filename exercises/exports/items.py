"""Make quiz items: questions in the form that the exports to learning platforms need.

An item has a text (Markdown and figures), the form of its answer, and the correct answer. Platforms can't compare
formulas, so items ask for the values of formulas at a configuration (see `numeric_part`). The staff get a message about
each question that can't be asked.
"""

import re
from collections.abc import Callable, Generator, Hashable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple, TypeVar

import numpy as np

from qdot.exercises.assignment.assignment import Slot
from qdot.exercises.assignment.certified_problems import Variant
from qdot.exercises.common.errors import QdotError, count_noun
from qdot.exercises.common.stream import Stream
from qdot.exercises.exports.bank import convert_bank
from qdot.exercises.exports.export_format import ExportRequest
from qdot.exercises.exports.known_wrong_answers import is_divided_by_zero
from qdot.exercises.exports.numeric_part import NumericPart, ask_in_numbers
from qdot.exercises.exports.platform_markup import (
    Picture,
    draw_arm,
    draw_prompt_figure,
    draw_solution_figure,
    find_pictures,
    make_svg_file,
    name_picture_file,
    write_line_html,
)
from qdot.exercises.mistakes.base import add_chapter_to_citation
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.reference_answers import LETTERS, TRUE_FALSE, ConditionSet, Matching, Number, Selection, Words
from qdot.exercises.short_questions import ALL_QUESTIONS, question_of
from qdot.exercises.short_questions.options import Options, list_blames, offer_choice
from qdot.exercises.short_questions.wrong_sets import make_four_sets
from qdot.exercises.writing import problem_texts
from qdot.exercises.writing.render import render
from qdot.exercises.writing.units import format_unit

Question = TypeVar("Question")

MAX_WRONG_VALUES = 6
"""Maximum number of wrong values to recognise for a number. With more values, answers would match them by chance."""
SINGULARITY_QUESTIONS = ("singular-angles-choice", "singular-configurations", "singular-drawing")
"""Short questions on singular configurations. Platforms can't mark the question that asks for all singular
configurations, so the first of these questions that applies replaces it."""


@dataclass(frozen=True)
class QuizOption:
    """An option: its text, whether students must choose it, and the feedback on choosing it wrongly."""

    text: str
    is_correct: bool
    feedback: str = ""


@dataclass(frozen=True)
class ChoiceForm:
    """A form in which a student chooses one option, or several if `allows_several`.

    If `has_fixed_order`, the options must not be shuffled, because a figure shows their letters.
    """

    kind: ClassVar = "options"
    options: tuple[QuizOption, ...]
    allows_several: bool = False
    has_fixed_order: bool = False

    @property
    def is_true_or_false(self) -> bool:
        """Whether the options are true and false."""
        return tuple(option.text for option in self.options) == TRUE_FALSE

    @property
    def correct_count(self) -> int:
        """The number of correct answers that share the points."""
        return sum(option.is_correct for option in self.options)

    @property
    def lettered_options(self) -> tuple[tuple[str, str, QuizOption], ...]:
        """Each option as (letter, text, option); the text begins with the letter, unless `has_fixed_order`."""
        return tuple(
            (letter, option.text if self.has_fixed_order else f"{letter}. {option.text}", option)
            for letter, option in zip(LETTERS, self.options, strict=False)
        )


@dataclass(frozen=True)
class MatchingForm:
    """A form in which a student matches stems (LaTeX) with options (plain text).

    `correct_indices` has the index (from 0) of the correct option for each stem. Some options may belong to no stem.
    """

    kind: ClassVar = "match"
    stems: tuple[str, ...]
    options: tuple[str, ...]
    correct_indices: tuple[int, ...]

    @property
    def correct_count(self) -> int:
        """The number of correct answers that share the points."""
        return len(self.stems)

    @property
    def lettered_stems(self) -> tuple[tuple[str, str, int], ...]:
        """Each stem as (letter, text with the letter, index of its option); solutions refer to the letters."""
        return tuple(
            (letter, f"{letter}. {stem}", index)
            for letter, stem, index in zip(LETTERS, self.stems, self.correct_indices, strict=False)
        )


@dataclass(frozen=True)
class WrongValue:
    """A wrong value that a known mistake leads to, with its tolerance, and the feedback on the mistake."""

    value: float
    tolerance: float
    feedback: str


@dataclass(frozen=True)
class NumberField:
    """An input field for a number: LaTeX label, description in words, correct value, and values of known mistakes."""

    label: str
    description: str
    value: float
    tolerance: float
    unit: str
    wrong_values: tuple[WrongValue, ...]

    @property
    def is_zero(self) -> bool:
        """Whether the correct value is zero, which is often obvious."""
        return round(self.value, 9) == 0


@dataclass(frozen=True)
class NumberForm:
    """A form with rows of input fields for numbers; entries that are not fields are shown as fixed text."""

    kind: ClassVar = "numbers"
    rows: tuple[tuple[NumberField | str, ...], ...]

    @property
    def fields(self) -> tuple[NumberField, ...]:
        """All fields, row by row."""
        return tuple(entry for row in self.rows for entry in row if isinstance(entry, NumberField))

    @property
    def correct_count(self) -> int:
        """The number of correct answers that share the points."""
        return sum(map(self.earns_points, self.fields))

    def earns_points(self, field: NumberField) -> bool:
        """Return whether a correct number earns points: a zero does so only if all numbers are zero."""
        return not field.is_zero or all(other_field.is_zero for other_field in self.fields)


@dataclass(frozen=True)
class TextForm:
    """A form for an answer in words, which a person marks."""

    kind: ClassVar = "text"
    correct_count: ClassVar = 1


ItemForm = ChoiceForm | MatchingForm | NumberForm | TextForm


class ItemCategory(NamedTuple):
    """The category of an item in a platform's question bank: a question with its number in the problem, from 1."""

    assignment_title: str
    slot_title: str
    question_title: str
    question_number: int

    @property
    def path(self) -> tuple[str, str, str]:
        """The names of the categories from the assignment's to the question's."""
        return self.assignment_title, self.slot_title, f"{self.question_number}. {self.question_title}"


@dataclass(frozen=True)
class QuizItem:
    """A question for learning platforms. Its `key`, as in p1-007-jacobian, is unique and permanent.

    If the item asks for several numbers, `single_number_item` is an item that asks for only one of them, for platforms
    that accept only one number.
    """

    key: str
    title: str
    category: ItemCategory
    body: tuple[str | Picture, ...]
    form: ItemForm
    points: float
    solution: tuple[str | Picture, ...]
    hints: tuple[str, ...] = ()
    single_number_item: "QuizItem | None" = None


def make_items(request: ExportRequest) -> Generator[QuizItem, None, None]:
    """Yield the parts of all variants as items. Report once for each slot which parts can't be asked."""
    reported_messages: set[str] = set()
    for variant, variant_items in convert_bank(request, _make_problem_items):
        for part, item in zip(variant.problem.parts, variant_items, strict=True):
            if item is not None:
                yield _add_variant_key(item, variant)
                continue
            message = f"{variant.slot.name}: {part.name} is left out, because the platform can't compare formulas"
            if message not in reported_messages:
                reported_messages.add(message)
                request.report(message)


def _make_problem_items(request: ExportRequest, slot: Slot, problem: Problem) -> list[QuizItem | None]:
    """Return the parts of a problem as items; their keys and titles do not contain the variant's key yet."""
    return [_make_item(request, slot, problem, part) for part in problem.parts]


def _add_variant_key(item: QuizItem, variant: Variant) -> QuizItem:
    """Return an item with the variant's key in its key and title."""
    number_item = item.single_number_item and _add_variant_key(item.single_number_item, variant)
    key, title = f"{variant.key}-{item.key}", f"{item.title} ({variant.key})"
    return replace(item, key=key, title=title, single_number_item=number_item)


def make_items_for_students(request: ExportRequest) -> Generator[QuizItem, None, None]:
    """Yield the items for a platform without levels of feedback; they have solutions only if students may see them."""
    for item in make_items(request):
        number_item = item.single_number_item and replace(item.single_number_item, solution=())
        shows_solutions = request.has_solutions or request.includes_feedback("solutions")
        yield item if shows_solutions else replace(item, solution=(), single_number_item=number_item)


def collect_image_files(quiz_items: Iterable[QuizItem]) -> dict[str, str | bytes]:
    """Map the path in a package of each figure of the items to the content of its file, sorted by path."""
    pictures = (picture for item in quiz_items for picture in find_pictures((*item.body, *item.solution)))
    return dict(sorted((f"images/{name_picture_file(picture)}", make_svg_file(picture)) for picture in pictures))


def list_option_ids(item_id: str, form: ItemForm) -> list[str]:
    """Return the identifier of each option; an empty list for a form without options to choose."""
    return [f"{item_id}-{letter}" for letter, *_ in form.lettered_options] if isinstance(form, ChoiceForm) else []


def make_category(request: ExportRequest, slot: Slot, problem: Problem, part: Part) -> ItemCategory:
    """Return the category of a part, which has the same names on every platform."""
    number = [problem_part.name for problem_part in problem.parts].index(part.name) + 1
    slot_title = f"{slot.name} {slot.family.name}"
    return ItemCategory(request.assignment.title, slot_title, question_of(part).title, number)


def group_by_category(
    questions: Iterable[Question],
    find_category: Callable[[Question], ItemCategory],
    find_content: Callable[[Question], Hashable],
    report: Callable[[str], None],
) -> dict[ItemCategory, list[Question]]:
    """Map each category, in order of appearance, to its questions without copies.

    Questions with equal content are copies: for an arm whose variants do not differ, all variants of some questions are
    equal. `report` gets a message for each category with copies.
    """
    groups: dict[ItemCategory, dict[Hashable, Question]] = {}
    counts: dict[ItemCategory, int] = {}
    for question in questions:
        category = find_category(question)
        groups.setdefault(category, {}).setdefault(find_content(question), question)
        counts[category] = counts.get(category, 0) + 1
    for category, group in groups.items():
        if len(group) < counts[category]:
            report(
                f"{category.slot_title}: the {counts[category]} variants of {category.question_title!r} contain only "
                f"{count_noun(len(group), 'different question')}; copies are left out"
            )
    return {category: list(group.values()) for category, group in groups.items()}


def group_items(items: Iterable[QuizItem], report: Callable[[str], None]) -> dict[ItemCategory, list[QuizItem]]:
    """Map each category, in order of appearance, to its different items."""
    return group_by_category(items, lambda item: item.category, lambda item: (item.body, item.form), report)


def append_boxes(body: str, form: ItemForm, boxes: Sequence[str]) -> str:
    """Return the HTML of a text followed by several boxes for numbers, in a column with names or as a matrix.

    `boxes` are in the platform's notation, one for each field. With a single box, return only the text.
    """
    if not isinstance(form, NumberForm) or len(boxes) < 2:
        return body
    remaining_boxes = iter(boxes)

    def describe(field: NumberField | str) -> str | dict[str, str]:
        if isinstance(field, str):
            return field
        return {"label": write_line_html(f"${field.label}$"), "unit": field.unit, "box": next(remaining_boxes)}

    rows = [list(map(describe, row)) for row in form.rows]
    fields = render("exports/number-fields.html.j2", rows=rows, column=len(form.rows[0]) == 1)
    return f"{body}\n{fields.strip()}"


def _make_item(request: ExportRequest, slot: Slot, problem: Problem, part: Part) -> QuizItem | None:
    """Return a part of a problem as an item without the variant's key; None if the part can't be asked."""
    category = make_category(request, slot, problem, part)
    if not (isinstance(part.answer, ConditionSet) and part.answer.is_singular_set):
        return _make_item_of_category(request, category, problem, part)
    short_problem = _ask_short_question(problem, part, request)
    if short_problem is None:
        return None
    return _make_item_of_category(request, category, short_problem, short_problem.parts[0])


def _make_item_of_category(
    request: ExportRequest, category: ItemCategory, problem: Problem, part: Part
) -> QuizItem | None:
    """Return a part of a problem as an item of a category; None if the part can't be asked."""
    explains_mistakes = request.includes_feedback("mistake")
    numeric_part: NumericPart | None = None
    form: ItemForm
    if isinstance(part.answer, ConditionSet):
        part_with_options = _offer_sets(problem, part, part.answer)
        if part_with_options is None:
            return None
        form = _make_option_form(problem, part_with_options, explains_mistakes=False)
        question_text = write_question_alone(problem, part)
    elif part.answer.offered_options:
        form = _make_option_form(problem, part, explains_mistakes)
        question_text = write_question_alone(problem, part)
    elif isinstance(part.answer, Words):
        form, question_text = TextForm(), write_question_alone(problem, part)
    else:
        numeric_part = ask_in_numbers(problem, part)
        if numeric_part is None:
            return None
        form = _make_number_form(problem, part, numeric_part, explains_mistakes)
        question_text = _write_numeric_question(problem, part, numeric_part, form.fields, len(form.fields))
    title = question_of(part).title
    figure = draw_prompt_figure(problem, part, part.name)
    figures = () if figure is None else (figure,)
    statement = problem_texts.write_statement(problem, "", explains_typing=False)
    body = (draw_arm(problem), statement, *figures, question_text)
    solution = _write_solution(problem, part, numeric_part)
    item_hints = problem_texts.write_hints(problem, part) if request.assignment.hints else ()
    item = QuizItem(part.name, title, category, body, form, part.points, solution, item_hints)
    if numeric_part is None or not isinstance(form, NumberForm) or len(form.fields) == 1:
        return item
    field = _choose_most_distinguishing_field(problem, part, form.fields)
    question_text = _write_numeric_question(problem, part, numeric_part, (field,), len(form.fields))
    number_item = replace(item, body=(*item.body[:-1], question_text), form=NumberForm(((field,),)))
    return replace(item, single_number_item=number_item)


def _offer_sets(problem: Problem, part: Part, answer: ConditionSet) -> Part | None:
    """Return a part that offers its set and three wrong sets; None if known mistakes lead to fewer wrong sets."""
    stream = Stream(f"qdot/{problem.id.stream_name}/{part.name}")
    offered_options = make_four_sets(problem.chain, answer.components, stream)
    if offered_options is None:
        return None
    choice, shuffled_options = offer_choice(offered_options, stream)
    return replace(part, answer=choice, details=Options(offered_options=shuffled_options))


def _ask_short_question(problem: Problem, part: Part, request: ExportRequest) -> Problem | None:
    """Return the problem with one short question on singular configurations, or None if no such question applies."""
    for name in SINGULARITY_QUESTIONS:
        question = ALL_QUESTIONS[name]
        if question.find_obstacle(problem.chain) is not None:
            continue
        try:
            stream = Stream(f"qdot/{problem.id.stream_name}/{name}")
            answer, details = question.ask(problem.chain, stream)
        except RuntimeError:  # the question found no suitable options for this arm
            continue
        short_problem = replace(problem, parts=(Part(name, name, answer, part.points, details=details),))
        failures = request.find_failures(short_problem)
        if failures:
            raise QdotError(f"{problem.id}: {name} failed its certificate: {failures[0]}; please report it")
        return short_problem
    return None


_ANSWER_PATTERN = re.compile(r"^\*\*Answer:\*\* (.*?)(?:\n\n|\Z)", re.MULTILINE | re.DOTALL)
_OPTION_PATTERN = re.compile(
    r"^- \*\*[A-H]\.\*\* [^\n]*\n?|^\$\$\n\\text\{[A-H]\.\} \\quad .*?\n\$\$\n?", re.MULTILINE | re.DOTALL
)
_TYPING_PHRASES = (
    (re.compile(r"; the joint rates are typed [^.]*\."), "."),
    (re.compile(r" The components of the load are typed [^;]*; "), " "),
    (re.compile(r", in terms of the joint variables and `[^.]*`"), ""),
    (re.compile(r" The answer may contain [^.]*\."), ""),
    (re.compile(r" with the last row `\[0, 0, 0, 1\]`"), " with the last row 0, 0, 0, 1"),
)  # fmt: skip
"""Phrases in prompts that explain how to type formulas, each with its replacement for platforms."""


def write_question_alone(problem: Problem, part: Part) -> str:
    """Return a prompt without its options and without the line that says how to type the answer."""
    return _ANSWER_PATTERN.sub("", _OPTION_PATTERN.sub("", problem_texts.write_prompt(problem, part))).strip()


def list_entry_labels(problem: Problem, part: Part, shape: tuple[int, ...]) -> tuple[str, ...]:
    """Return the LaTeX labels of the entries of an answer with a given shape, row by row."""
    entry_names, count = problem_texts.name_entries(problem, part), int(np.prod(shape))
    if len(entry_names) == count:
        return entry_names
    return tuple(f"({index // shape[1] + 1}, {index % shape[1] + 1})" for index in range(count))


def _make_option_form(problem: Problem, part: Part, explains_mistakes: bool) -> ChoiceForm | MatchingForm:
    """Return the options of an answer as a choice, or as stems and options to match."""
    answer = part.answer
    texts = [problem_texts.write_option(problem, part, index) for index in range(len(answer.offered_options))]
    if isinstance(answer, Matching):
        correct_indices = [len(answer.items)] * len(texts)  # the option "no joint", unless an item belongs to the text
        for item_index, text_index in enumerate(answer.correct):
            correct_indices[text_index] = item_index
        return MatchingForm(tuple(texts), (*answer.items, "no joint"), tuple(correct_indices))
    options = []
    for index, text in enumerate(texts):
        is_correct = index in answer.correct_indices
        blames = list_blames(part, index) if explains_mistakes and not is_correct else ()
        feedback = add_chapter_to_citation(" ".join(dict.fromkeys(blame.sentence for blame in blames)))
        shown_text = f"{LETTERS[index]}: {text}" if part.details.has_drawn_options else text
        options.append(QuizOption(shown_text, is_correct, feedback))
    has_fixed_order = part.details.has_drawn_options or answer.offered_options == TRUE_FALSE
    return ChoiceForm(tuple(options), isinstance(answer, Selection), has_fixed_order)


def _write_solution(problem: Problem, part: Part, numeric_part: NumericPart | None) -> tuple[str | Picture, ...]:
    text = problem_texts.write_solution(problem, part)
    if numeric_part is not None and (numeric_part.given_values is not None or numeric_part.unit_entry is not None):
        rows = [[f"{value:.{part.count_digits(value, at_least=4)}g}" for value in row] for row in numeric_part.values]
        text += "\n" + render("exports/solution.md.j2", rows=rows)
    return (text, *filter(None, [draw_solution_figure(problem, part, "solution")]))


# --- numbers ---


def _make_number_form(problem: Problem, part: Part, numeric_part: NumericPart, explains_mistakes: bool) -> NumberForm:
    columns = numeric_part.values.shape[1]
    fields = [
        "1" if numeric_part.unit_entry == index else _make_field(part, numeric_part, index, label, explains_mistakes)
        for index, label in enumerate(list_entry_labels(problem, part, numeric_part.values.shape))
    ]
    rows = [tuple(fields[k : k + columns]) for k in range(0, len(fields), columns)]
    if last_row := question_of(part).constant_last_row:
        rows[-1] = tuple(last_row)
    return NumberForm(tuple(rows))


def _make_field(part: Part, numeric_part: NumericPart, index: int, label: str, explains_mistakes: bool) -> NumberField:
    """Return the field for entry `index` (from 0, row by row), with wrong values if `explains_mistakes`."""
    answer = numeric_part.part.answer_as(Number)
    (rows, columns), is_count = numeric_part.values.shape, answer.is_count
    if is_count:
        relative_tolerance, absolute_tolerance = 0.0, 0.0
    elif part.rounding is not None:
        errors = part.rounding.errors_of_entries
        relative_tolerance = max(part.rounding.relative, 1e-9)
        absolute_tolerance = errors[index] if errors else part.rounding.absolute
    else:
        relative_tolerance, absolute_tolerance = answer.tolerance, answer.floor
    value = float(numeric_part.values.ravel()[index])
    tolerance = max(relative_tolerance * abs(value), absolute_tolerance)
    values_with_tolerance, wrong_values = [(value, tolerance)], list[WrongValue]()
    for feedback, values in numeric_part.wrong_answers if explains_mistakes else ():
        if values.shape != numeric_part.values.shape or is_divided_by_zero(values, numeric_part.values):
            continue
        wrong_value = float(values.ravel()[index])
        wrong_tolerance = relative_tolerance * abs(wrong_value)
        if absolute_tolerance < abs(wrong_value) / 2:  # the range of a wrong value never contains zero
            wrong_tolerance = max(wrong_tolerance, absolute_tolerance)
        is_zero = abs(wrong_value) <= 1e-9 and not is_count  # zero is left out, because many mistakes lead to it
        is_new = all(
            abs(wrong_value - earlier_value) > wrong_tolerance + earlier_tolerance
            for earlier_value, earlier_tolerance in values_with_tolerance
        )
        if is_new and not is_zero:
            values_with_tolerance.append((wrong_value, wrong_tolerance))
            wrong_values.append(WrongValue(wrong_value, wrong_tolerance, feedback))
    row, column = divmod(index, columns)
    if columns > 1:
        description = f"the entry in row {row + 1}, column {column + 1} of the matrix"
    else:
        description = f"${label}$ (entry {row + 1})" if rows > 1 else f"${label}$"
    known_values = tuple(wrong_values[:MAX_WRONG_VALUES])
    return NumberField(label, description, value, tolerance, format_unit(answer.units[index]), known_values)


def _choose_most_distinguishing_field(problem: Problem, part: Part, fields: tuple[NumberField, ...]) -> NumberField:
    """Return the field whose value distinguishes the most mistakes; if several do, one of them at random."""
    nontrivial_fields = [field for field in fields if round(abs(field.value), 9) not in (0, 1)] or list(fields)
    max_mistakes = max(len(field.wrong_values) for field in nontrivial_fields)
    best_fields = [field for field in nontrivial_fields if len(field.wrong_values) == max_mistakes]
    return Stream(f"{problem.id}/{part.name}/one number").choice(best_fields)


def _write_numeric_question(
    problem: Problem, part: Part, numeric_part: NumericPart, fields: tuple[NumberField, ...], entry_count: int
) -> str:
    """Return the question that asks for some fields of an answer with `entry_count` entries."""
    prompt = problem_texts.write_prompt(problem, part)
    answer_line = _ANSWER_PATTERN.search(prompt)
    instructions = "" if answer_line is None or part.type in ("expression", "direction") else answer_line[1].strip()
    for pattern, replacement in _TYPING_PHRASES:
        instructions = pattern.sub(replacement, instructions)
    labels = list_entry_labels(problem, part, numeric_part.values.shape)
    unit_entry = "" if numeric_part.unit_entry is None else f"its entry ${labels[numeric_part.unit_entry]}$"
    return render(
        "exports/question.md.j2", prompt=_ANSWER_PATTERN.sub("", prompt).strip(), unit_entry=unit_entry,
        given_values=numeric_part.given_values, instructions=instructions, fields=fields, entries=entry_count,
        precision="exactly" if fields[0].tolerance == 0 else part.precision,
    ).strip()  # fmt: skip
