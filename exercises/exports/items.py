"""Quiz items, the common form of questions for all learning platforms: text, form of answer, correct answer.

Texts are Markdown with LaTeX, with figures between them. Platforms can't compare formulas, so items ask for their
values at a configuration (`exports.numbers`). `order.note` reports questions that can't be asked at all.
"""

import re
from collections.abc import Generator, Iterable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import sympy as sp

from qdot.exercises.answers import LETTERS, TRUE_FALSE, Matching, Number, Selection
from qdot.exercises.assignment.assignment import Slot
from qdot.exercises.assignment.draws import Variant
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.exports.bank import process_bank
from qdot.exercises.exports.export_format import Order
from qdot.exercises.exports.markup import Picture, arm_picture, part_picture, solution_picture
from qdot.exercises.exports.numbers import NumericPart, ask_in_numbers
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.quizzes import ASKED
from qdot.exercises.quizzes.options import list_blames
from qdot.exercises.writing.latex import tex
from qdot.exercises.writing.problem_texts import hints, option_text, prompt, statement, worked_solution
from qdot.exercises.writing.render import render

MOST_WRONG = 6
"""Maximum number of wrong values to recognise for one number. With more, some would match by chance."""
SHORT_QUESTIONS = ("singular-angles-choice", "singular-configurations", "singular-drawing")
"""Short questions that replace the question for the set of singular configurations: the first that applies is asked."""


@dataclass(frozen=True)
class Option:
    """An option: its text, whether it is correct (`right`), and the feedback for choosing it."""

    text: str
    right: bool
    feedback: str = ""


@dataclass(frozen=True)
class Choose:
    """A choice of one option, or of `several` options. The order is `fixed` if a figure shows the letters."""

    kind: ClassVar = "options"
    options: tuple[Option, ...]
    several: bool = False
    fixed: bool = False

    @property
    def is_true_or_false(self) -> bool:
        """Whether the options are true and false."""
        return tuple(option.text for option in self.options) == TRUE_FALSE

    @property
    def count_of_right(self) -> int:
        """The number of correct answers that share the points."""
        return sum(option.right for option in self.options)

    @property
    def choices(self) -> tuple[tuple[str, str, Option], ...]:
        """Each option as (letter, text, option). The text begins with the letter, unless the order is `fixed`."""
        return tuple(
            (letter, option.text if self.fixed else f"{letter}. {option.text}", option)
            for letter, option in zip(LETTERS, self.options, strict=False)
        )


@dataclass(frozen=True)
class Match:
    """A form in which a student matches stems (LaTeX) with options (plain text).

    `correct` is the index of each stem's option, from 0. An option may belong to no stem.
    """

    kind: ClassVar = "match"
    stems: tuple[str, ...]
    options: tuple[str, ...]
    correct: tuple[int, ...]

    @property
    def count_of_right(self) -> int:
        """The number of correct answers that share the points."""
        return len(self.stems)

    @property
    def pairs(self) -> tuple[tuple[str, str, int], ...]:
        """Each stem as (letter, text after the letter, index of its option); solutions refer to the letters."""
        return tuple(
            (letter, f"{letter}. {stem}", index)
            for letter, stem, index in zip(LETTERS, self.stems, self.correct, strict=False)
        )


@dataclass(frozen=True)
class WrongValue:
    """A wrong value, with the title of the mistake that leads to it, and the feedback."""

    value: float
    tolerance: float
    title: str
    advice: str


@dataclass(frozen=True)
class Field:
    """An input field for a number: its name in LaTeX and in words, value, tolerance, unit, and known wrong values."""

    label: str
    words: str
    value: float
    tolerance: float
    unit: str
    wrong: tuple[WrongValue, ...]


@dataclass(frozen=True)
class Numeric:
    """Input fields for numbers, in rows; entries that are not fields are shown as fixed text."""

    kind: ClassVar = "numbers"
    rows: tuple[tuple[Field | str, ...], ...]

    @property
    def fields(self) -> tuple[Field, ...]:
        """All fields, row by row."""
        return tuple(entry for row in self.rows for entry in row if isinstance(entry, Field))

    @property
    def count_of_right(self) -> int:
        """The number of correct answers that share the points."""
        return len(self.fields)


@dataclass(frozen=True)
class Item:
    """A question for learning platforms. `key` is unique and permanent; `category` is assignment, slot, question.

    `number` is the same question for platforms that accept only one number: it asks for one of the item's numbers. It
    is None if the item asks for at most one number.
    """

    key: str
    title: str
    category: tuple[str, str, str]
    body: tuple[str | Picture, ...]
    form: Choose | Match | Numeric
    points: float
    solution: tuple[str | Picture, ...]
    hints: tuple[str, ...] = ()
    number: "Item | None" = None


def items(order: Order) -> Generator[Item, None, None]:
    """Yield the parts of every variant as items, by slot and variant. Report once per slot what can't be asked."""
    reported_notes: set[str] = set()
    for variant, variant_items in process_bank(order, _items_of):
        for part, item in zip(variant.problem.parts, variant_items, strict=True):
            if item is not None:
                yield _add_variant_key(item, variant)
                continue
            note = f"{variant.slot.name}: {part.name} can't be asked on a platform that compares no formulas"
            if note not in reported_notes:
                reported_notes.add(note)
                order.note(note)


def _items_of(order: Order, slot: Slot, problem: Problem) -> list[Item | None]:
    """Return the parts of a problem as items, whose keys and titles do not name the variant yet."""
    return [_item(order, slot, problem, part) for part in problem.parts]


def _add_variant_key(item: Item, variant: Variant) -> Item:
    """Return an item with the variant's key in its key and title."""
    number_item = item.number and _add_variant_key(item.number, variant)
    return replace(item, key=f"{variant.key}-{item.key}", title=f"{item.title} ({variant.key})", number=number_item)


def items_without_hidden_solutions(order: Order) -> Generator[Item, None, None]:
    """Yield the items for a platform without levels of feedback, with solutions only if students may see them."""
    for item in items(order):
        number_item = item.number and replace(item.number, solution=())
        yield item if order.solutions or order.tells("solutions") else replace(item, solution=(), number=number_item)


def group_by_category(items: Iterable[Item]) -> dict[tuple[str, str, str], list[Item]]:
    """Return the items of each category, with the categories in order of appearance."""
    groups: dict[tuple[str, str, str], list[Item]] = {}
    for item in items:
        groups.setdefault(item.category, []).append(item)
    return groups


def _item(order: Order, slot: Slot, problem: Problem, part: Part) -> Item | None:
    """Return a part of a problem as an item whose key does not name the variant yet; None if it can't be asked."""
    if part.answer.is_a_set:
        short_problem = _ask_short_question(problem, part, order)
        if short_problem is None:
            return None
        problem, (part,) = short_problem, short_problem.parts
    tells_mistakes, numeric_part = order.tells("mistake"), None
    form: Choose | Match | Numeric
    if part.answer.offered:
        form = _options(problem, part, tells_mistakes)
        question = question_alone(problem, part)
    else:
        numeric_part = ask_in_numbers(problem, part)
        if numeric_part is None:
            return None
        form = _numeric(problem, part, numeric_part, tells_mistakes)
        question = _numeric_question(problem, part, numeric_part, form.fields, len(form.fields))
    title, figure = ASKED[part.kind].title, part_picture(problem, part, part.name)
    item = Item(
        key=part.name,
        title=title,
        category=(order.assignment.title, f"{slot.name} {slot.family.name}", title),
        body=(arm_picture(problem), statement(problem, "", typed=False), *filter(None, [figure]), question),
        form=form,
        points=part.points,
        solution=_solution(problem, part, numeric_part),
        hints=hints(problem, part) if order.assignment.hints else (),
    )
    if numeric_part is None or not isinstance(form, Numeric) or len(form.fields) == 1:
        return item
    field = _most_telling_field(problem, part, form.fields)
    question = _numeric_question(problem, part, numeric_part, (field,), len(form.fields))
    return replace(item, number=replace(item, body=(*item.body[:-1], question), form=Numeric(((field,),))))


def _ask_short_question(problem: Problem, part: Part, order: Order) -> Problem | None:
    """Return the problem with one short question on singular configurations, or None if no such question applies."""
    for name in SHORT_QUESTIONS:
        question = ASKED[name]
        if question.refusal(problem.chain) is not None:
            continue
        try:
            stream = Stream(f"qdot/{problem.id.engine}/{problem.id}/{name}")
            answer, details = question.ask(problem.chain, stream)
        except RuntimeError:
            continue
        short_problem = replace(problem, parts=(Part(name, name, answer, part.points, details=details),))
        failures = order.failures(short_problem)
        if failures:
            raise QdotError(f"{problem.id}: {name} does not pass its certificate: {failures[0]}; please report it")
        return short_problem
    return None


_ANSWER = re.compile(r"^\*\*Answer:\*\* (.*?)(?:\n\n|\Z)", re.MULTILINE | re.DOTALL)
_OPTION = re.compile(r"^- \*\*[A-H]\.\*\* .*\n?|^\$\$\n\\text\{[A-H]\.\} \\quad .*?\n\$\$\n?", re.MULTILINE | re.DOTALL)
_TYPED = (
    (re.compile(r"; the joint rates are typed [^.]*\."), "."),
    (re.compile(r" The components are typed [^;]*; "), " "),
    (re.compile(r", in terms of the joint variables and `[^.]*`"), ""),
    (re.compile(r" with the last row `\[0, 0, 0, 1\]`"), " with the last row 0, 0, 0, 1"),
)  # fmt: skip
"""Phrases in prompts that explain how to type formulas, each with its replacement."""


def question_alone(problem: Problem, part: Part) -> str:
    """Return the prompt without its options and without instructions on how to type the answer."""
    return _ANSWER.sub("", _OPTION.sub("", prompt(problem, part))).strip()


def entry_labels(problem: Problem, part: Part, shape: tuple[int, ...]) -> tuple[str, ...]:
    """Return the LaTeX names of the entries of an answer, row by row."""
    chain, question, count = problem.chain, ASKED[part.kind], int(np.prod(shape))
    entry_names = question.entry_names(chain, part) or [tex(sp.Symbol(name), chain) for name in question.labels(chain)]
    if len(entry_names) == count:
        return tuple(entry_names)
    return tuple(f"({index // shape[1] + 1}, {index % shape[1] + 1})" for index in range(count))


def _options(problem: Problem, part: Part, tells_mistakes: bool) -> Choose | Match:
    """Return the options of an answer as a choice, or as stems and options to match."""
    answer, texts = part.answer, [option_text(problem, part, index) for index in range(len(part.answer.offered))]
    if isinstance(answer, Matching):
        correct = [len(answer.items)] * len(texts)
        for number, index in enumerate(answer.correct):
            correct[index] = number
        return Match(tuple(texts), (*answer.items, "no joint"), tuple(correct))
    options = []
    for index, text in enumerate(texts):
        is_right = index in answer.right
        blames = list_blames(part, index) if tells_mistakes and not is_right else ()
        feedback = " ".join(dict.fromkeys(blame.sentence for blame in blames))
        options.append(Option(f"{LETTERS[index]}: {text}" if part.has_drawn_options else text, is_right, feedback))
    fixed = part.has_drawn_options or answer.offered == TRUE_FALSE
    return Choose(tuple(options), isinstance(answer, Selection), fixed)


def _solution(problem: Problem, part: Part, numeric_part: NumericPart | None) -> tuple[str | Picture, ...]:
    text = worked_solution(problem, part)
    if numeric_part is not None and (numeric_part.given_values is not None or numeric_part.unit is not None):
        rows = [[f"{value:.4g}" for value in row] for row in numeric_part.values]
        text += "\n" + render("exports/solution.md.j2", rows=rows)
    return (text, *filter(None, [solution_picture(problem, part, "solution")]))


# --- numbers ---


def _numeric(problem: Problem, part: Part, numeric_part: NumericPart, tells_mistakes: bool) -> Numeric:
    columns = numeric_part.values.shape[1]
    fields = [
        "1" if numeric_part.unit == index else _field(part, numeric_part, index, label, tells_mistakes)
        for index, label in enumerate(entry_labels(problem, part, numeric_part.values.shape))
    ]
    rows = [tuple(fields[k : k + columns]) for k in range(0, len(fields), columns)]
    if last_row := ASKED[part.kind].last_row:
        rows[-1] = tuple(last_row)
    return Numeric(tuple(rows))


def _field(part: Part, numeric_part: NumericPart, index: int, label: str, tells_mistakes: bool) -> Field:
    answer = numeric_part.part.of(Number)
    (rows, columns), is_count = numeric_part.values.shape, answer.tolerance < 1e-6

    def tolerance_of(value: float) -> float:
        if is_count:
            return 0.0
        if part.rounding is not None:
            return max(part.rounding.relative * abs(value), part.rounding.absolute, 1e-9 * abs(value))
        return max(answer.tolerance * abs(value), answer.floor)

    value = float(numeric_part.values.ravel()[index])
    tolerance = tolerance_of(value)
    values_with_tolerance, wrong_values = [(value, tolerance)], list[WrongValue]()
    for title, advice, values in numeric_part.wrong if tells_mistakes else ():
        wrong_value = float(values.ravel()[index]) if values.shape == numeric_part.values.shape else np.nan
        wrong_tolerance = tolerance_of(wrong_value)
        is_zero = abs(wrong_value) <= 1e-9 and not is_count  # many mistakes lead to zero
        is_new = all(
            abs(wrong_value - earlier) > wrong_tolerance + earlier_tolerance
            for earlier, earlier_tolerance in values_with_tolerance
        )
        if is_new and np.isfinite(wrong_value) and not is_zero:
            values_with_tolerance.append((wrong_value, wrong_tolerance))
            wrong_values.append(WrongValue(wrong_value, wrong_tolerance, title, advice))
    row, column = divmod(index, columns)
    position = f"row {row + 1}, column {column + 1}" if columns > 1 else f"entry {row + 1}" if rows > 1 else ""
    description = (
        f"that in {position} of the matrix" if columns > 1 else f"${label}$ ({position})" if position else f"${label}$"
    )
    return Field(label, description, value, tolerance, answer.units[index], tuple(wrong_values[:MOST_WRONG]))


def _most_telling_field(problem: Problem, part: Part, fields: tuple[Field, ...]) -> Field:
    """Return the field whose value distinguishes the most mistakes. If several do, choose one of them at random."""
    nontrivial_fields = [field for field in fields if round(abs(field.value), 9) not in (0, 1)] or list(fields)
    max_mistakes = max(len(field.wrong) for field in nontrivial_fields)
    best_fields = [field for field in nontrivial_fields if len(field.wrong) == max_mistakes]
    return Stream(f"{problem.id}/{part.name}/one number").choice(best_fields)


def _numeric_question(
    problem: Problem, part: Part, numeric_part: NumericPart, fields: tuple[Field, ...], entries: int
) -> str:
    """Return the question that asks for these fields of an answer with `entries` entries."""
    text = prompt(problem, part)
    answer_line = _ANSWER.search(text)
    convention = "" if answer_line is None or part.type in ("expression", "direction") else answer_line[1].strip()
    for pattern, replacement in _TYPED:
        convention = pattern.sub(replacement, convention)
    labels = entry_labels(problem, part, numeric_part.values.shape)
    return render(
        "exports/question.md.j2",
        asked=_ANSWER.sub("", text).strip(),
        given=numeric_part.given_values,
        unit="" if numeric_part.unit is None else f"its entry ${labels[numeric_part.unit]}$",
        convention=convention,
        fields=fields,
        entries=entries,
        precision="exactly" if fields[0].tolerance == 0 else part.precision,
    ).strip()
