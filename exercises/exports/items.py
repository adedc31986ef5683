"""Quiz items, the common form of questions for all learning platforms: text, form of answer, and right answer.

Texts are Markdown with LaTeX, figures stand between them. Platforms can't compare formulas, so items ask for their
values at a configuration (`exports.numbers`). `order.note` reports questions that can't be asked at all.
"""

import re
from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from qdot.exercises.answers import LETTERS, TRUE_FALSE, AnswerVisitor, Choice, Letters, Matching, Number, Selection
from qdot.exercises.assignment.assignment import Slot
from qdot.exercises.assignment.draws import Variant
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.exports.bank import process_bank
from qdot.exercises.exports.export_format import Order
from qdot.exercises.exports.numbers import NumericPart, ask_in_numbers
from qdot.exercises.figure import alt_text, figure_svg, part_alt, part_svg
from qdot.exercises.notebook.notebook import solution_figure
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.quizzes import ASKED
from qdot.exercises.quizzes.options import list_blames
from qdot.exercises.writing.latex import tex
from qdot.exercises.writing.render import render
from qdot.exercises.writing.statement import hints, option_text, prompt, statement, worked_solution

MOST_WRONG = 6
"""Most wrong values that are recognised for one number; more would be met by chance."""
SHORT_QUESTIONS = ("singular-angles-choice", "singular-configurations", "singular-drawing")
"""Questions asked instead of one for the set of singular configurations: the first that the arm allows."""


@dataclass(frozen=True)
class Picture:
    """A figure in a text: its name within the item, its SVG, and a description in words."""

    name: str
    svg: str
    alt: str


@dataclass(frozen=True)
class Option:
    """An option: its text, whether it is right, and the feedback for choosing it."""

    text: str
    right: bool
    feedback: str = ""


@dataclass(frozen=True)
class Choose:
    """Options to choose one from, or `several`. They keep their order (`fixed`) if a figure shows their letters."""

    options: tuple[Option, ...]
    several: bool = False
    fixed: bool = False

    @property
    def is_true_or_false(self) -> bool:
        """Whether the options are true and false."""
        return tuple(option.text for option in self.options) == TRUE_FALSE

    @property
    def lettered_texts(self) -> tuple[str, ...]:
        """The texts with the letters that solutions refer to; options of a figure have theirs, true and false none."""
        texts = tuple(option.text for option in self.options)
        return texts if self.fixed else _add_letters(texts)


@dataclass(frozen=True)
class Match:
    """Stems (LaTeX) to match with options (plain text): `correct` has the option's index for each stem, from 0.

    Some options may belong to no stem.
    """

    stems: tuple[str, ...]
    options: tuple[str, ...]
    correct: tuple[int, ...]

    @property
    def lettered_stems(self) -> tuple[str, ...]:
        """The stems with the letters that solutions refer to."""
        return _add_letters(self.stems)


def _add_letters(texts: Sequence[str]) -> tuple[str, ...]:
    return tuple(f"{letter}. {text}" for letter, text in zip(LETTERS, texts, strict=False))


@dataclass(frozen=True)
class WrongValue:
    """A value that a mistake leads to, the mistake's title, and the feedback for it."""

    value: float
    tolerance: float
    title: str
    advice: str


@dataclass(frozen=True)
class Field:
    """A number to be typed: its name in LaTeX and in words, value, tolerance, unit, and known wrong values."""

    label: str
    words: str
    value: float
    tolerance: float
    unit: str
    wrong: tuple[WrongValue, ...]


@dataclass(frozen=True)
class Numeric:
    """Numbers to be typed, in rows; entries that are not fields are shown as fixed text."""

    rows: tuple[tuple[Field | str, ...], ...]

    @property
    def fields(self) -> tuple[Field, ...]:
        """All fields, row by row."""
        return tuple(entry for row in self.rows for entry in row if isinstance(entry, Field))


@dataclass(frozen=True)
class Item:
    """A question as platforms ask it. `key` is unique and permanent; `category` is assignment, slot, question.

    `number` is the same question for platforms that take one number only: it asks for one of several numbers. It is
    None if the item asks for at most one.
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
    """Yield the parts of every variant as items, by slot and variant. Note once per slot what can't be asked."""
    noted: set[str] = set()
    for variant, made in process_bank(order, _items_of):
        for part, item in zip(variant.problem.parts, made, strict=True):
            if item is not None:
                yield _add_variant_key(item, variant)
                continue
            note = f"{variant.slot.name}: {part.name} can't be asked on a platform that compares no formulas"
            if note not in noted:
                noted.add(note)
                order.note(note)


def _items_of(order: Order, slot: Slot, problem: Problem) -> list[Item | None]:
    """Return the parts of a problem as items; their keys and titles do not name the variant yet."""
    return [_item(order, slot, problem, part) for part in problem.parts]


def _add_variant_key(item: Item, variant: Variant) -> Item:
    """Return an item with the variant's key in its key and title."""
    number = item.number and _add_variant_key(item.number, variant)
    return replace(item, key=f"{variant.key}-{item.key}", title=f"{item.title} ({variant.key})", number=number)


def items_without_hidden_solutions(order: Order) -> Generator[Item, None, None]:
    """Yield the items for a platform without levels of feedback, with solutions only if students may see them."""
    for item in items(order):
        number = item.number and replace(item.number, solution=())
        yield item if order.solutions or order.tells("solutions") else replace(item, solution=(), number=number)


def _item(order: Order, slot: Slot, problem: Problem, part: Part) -> Item | None:
    """Return a part of a problem as an item without its variant's number; None if it can't be asked."""
    if part.answer.is_a_set:
        short = _ask_short_question(problem, part, order)
        if short is None:
            return None
        problem, (part,) = short, short.parts
    tells_mistakes = order.tells("mistake")
    return _Maker(slot, problem, part, order.assignment.title, order.assignment.hints, tells_mistakes).item()


def _ask_short_question(problem: Problem, part: Part, order: Order) -> Problem | None:
    """Return a problem with a short question on singular configurations instead of one that asks for all of them."""
    for name in SHORT_QUESTIONS:
        question = ASKED[name]
        if question.refusal(problem.chain) is not None:
            continue
        try:
            stream = Stream(f"qdot/{problem.id.engine}/{problem.id}/{name}")
            answer, details = question.ask(problem.chain, stream)
        except RuntimeError:
            continue
        short = replace(problem, parts=(Part(name, name, answer, part.points, details=details),))
        failed = order.failures(short)
        if failed:
            raise QdotError(f"{problem.id}: {name} does not pass its certificate: {failed[0]}; please report it")
        return short
    return None


_ANSWER = re.compile(r"^\*\*Answer:\*\* (.*?)(?:\n\n|\Z)", re.MULTILINE | re.DOTALL)
_OPTION = re.compile(r"^- \*\*[A-H]\.\*\* .*\n?|^\$\$\n\\text\{[A-H]\.\} \\quad .*?\n\$\$\n?", re.MULTILINE | re.DOTALL)
_TYPED = (
    (re.compile(r"; the joint rates are typed [^.]*\."), "."),
    (re.compile(r" The components are typed [^;]*; "), " "),
    (re.compile(r", in the joint variables and `[^.]*`"), ""),
    (re.compile(r", its last row `\[0, 0, 0, 1\]`"), ", its last row 0, 0, 0, 1"),
)  # fmt: skip
"""Phrases of prompts on how to type formulas, which are removed."""


def question_alone(problem: Problem, part: Part) -> str:
    """Return the prompt without options, and without how the answer is typed."""
    return _ANSWER.sub("", _OPTION.sub("", prompt(problem, part))).strip()


def entry_labels(problem: Problem, part: Part, shape: tuple[int, ...]) -> tuple[str, ...]:
    """Return LaTeX names of the entries of an answer, row by row."""
    chain, question, count = problem.chain, ASKED[part.kind], int(np.prod(shape))
    named = question.entry_names(chain, part) or [tex(sp.Symbol(name), chain) for name in question.labels(chain)]
    if len(named) == count:
        return tuple(named)
    return tuple(f"({index // shape[1] + 1}, {index % shape[1] + 1})" for index in range(count))


@dataclass(frozen=True)
class _Options(AnswerVisitor[Choose | Match]):
    """Converts an answer with options to the form that platforms use."""

    problem: Problem
    part: Part
    tells_mistakes: bool

    def matching(self, answer: Matching) -> Match:
        stems = tuple(option_text(self.problem, self.part, index) for index in range(len(answer.options)))
        correct = [len(answer.items)] * len(stems)
        for number, index in enumerate(answer.correct):
            correct[index] = number
        return Match(stems, (*answer.items, "no joint"), tuple(correct))

    def some_of(self, answer: Selection) -> Choose:
        return self._choose(answer, several=True)

    def one_of(self, answer: Choice) -> Choose:
        return self._choose(answer, several=False)

    def _choose(self, answer: Letters, several: bool) -> Choose:
        fixed = self.part.has_drawn_options or answer.options == TRUE_FALSE
        options = []
        for index in range(len(answer.options)):
            text = option_text(self.problem, self.part, index)
            if self.part.has_drawn_options:
                text = f"{LETTERS[index]}: {text}"
            is_right = index in answer.right
            blames = list_blames(self.part, index) if self.tells_mistakes and not is_right else ()
            options.append(Option(text, is_right, " ".join(dict.fromkeys(blame.sentence for blame in blames))))
        return Choose(tuple(options), several, fixed)


@dataclass(frozen=True)
class _Maker:
    """Makes the item of one part."""

    slot: Slot
    problem: Problem
    part: Part
    title: str
    hinted: bool
    tells_mistakes: bool

    def item(self) -> Item | None:
        answer = self.part.answer
        if answer.offered:
            form = answer.accept(_Options(self.problem, self.part, self.tells_mistakes))
            return self._build_item(question_alone(self.problem, self.part), form)
        numeric_part = ask_in_numbers(self.problem, self.part)
        if numeric_part is None:
            return None
        numeric = self._numeric(numeric_part)
        whole = self._build_item(
            self._question_text(numeric_part, numeric.fields, len(numeric.fields)), numeric, numeric_part
        )
        if len(numeric.fields) == 1:
            return whole
        field = self._most_telling_field(numeric.fields)
        single = self._build_item(
            self._question_text(numeric_part, (field,), len(numeric.fields)), Numeric(((field,),)), numeric_part
        )
        return replace(whole, number=single)

    def _build_item(
        self, question: str, form: Choose | Match | Numeric, numeric_part: NumericPart | None = None
    ) -> Item:
        problem, part, slot = self.problem, self.part, self.slot
        arm = Picture("arm", figure_svg(problem.chain), alt_text(problem.chain))
        svg = part_svg(problem.chain, part, part.name)
        part_figure = (Picture(part.name, svg, part_alt(problem.chain, part)),) if svg else ()
        title = ASKED[part.kind].title
        return Item(
            key=part.name,
            title=title,
            category=(self.title, f"{slot.name} {slot.family.name}", title),
            body=(arm, statement(problem, "", typed=False), *part_figure, question),
            form=form,
            points=part.points,
            solution=self._solution(numeric_part),
            hints=hints(problem, part) if self.hinted else (),
        )

    def _solution(self, numeric_part: NumericPart | None) -> tuple[str | Picture, ...]:
        text = worked_solution(self.problem, self.part)
        if numeric_part is not None and (numeric_part.given_values is not None or numeric_part.unit is not None):
            rows = [[f"{value:.4g}" for value in row] for row in numeric_part.values]
            text += "\n" + render("exports/solution.md.j2", rows=rows)
        svg = solution_figure(self.problem, self.part, "solution")
        drawn = Picture("solution", svg, "The arm in a regular and in its singular configurations") if svg else None
        return (text,) if drawn is None else (text, drawn)

    # --- numbers ---

    def _numeric(self, numeric_part: NumericPart) -> Numeric:
        rows, columns = numeric_part.values.shape
        labels = entry_labels(self.problem, self.part, numeric_part.values.shape)
        made = [
            [
                "1"
                if numeric_part.unit == r * columns + c
                else self._field(numeric_part, r, c, labels[r * columns + c])
                for c in range(columns)
            ]
            for r in range(rows)
        ]
        if last_row := ASKED[self.part.kind].last_row:
            made[-1] = list(last_row)
        return Numeric(tuple(tuple(row) for row in made))

    def _field(self, numeric_part: NumericPart, row: int, column: int, label: str) -> Field:
        answer = numeric_part.part.of(Number)
        rows, columns = numeric_part.values.shape
        value = float(numeric_part.values[row, column])
        tolerance = self._tolerance(answer, value)
        wrong_values: list[WrongValue] = []
        for title, advice, values in numeric_part.wrong if self.tells_mistakes else ():
            if values.shape != numeric_part.values.shape or not np.isfinite(values[row, column]):
                continue
            wrong_value = float(values[row, column])
            candidate = WrongValue(wrong_value, self._tolerance(answer, wrong_value), title, advice)
            if self._is_distinctive(candidate, value, tolerance, wrong_values, answer.tolerance < 1e-6):
                wrong_values.append(candidate)
        place = f"row {row + 1}, column {column + 1}" if columns > 1 else f"entry {row + 1}" if rows > 1 else ""
        words = f"that in {place} of the matrix" if columns > 1 else f"${label}$ ({place})" if place else f"${label}$"
        unit = answer.units[row * columns + column]
        return Field(label, words, value, tolerance, unit, tuple(wrong_values[:MOST_WRONG]))

    def _tolerance(self, answer: Number, value: float) -> float:
        """Return the tolerance of a number, in the number's unit."""
        allowed = self.part.rounding
        if answer.tolerance < 1e-6:  # a count
            return 0.0
        if allowed is not None:
            return max(allowed.relative * abs(value), allowed.absolute, 1e-9 * abs(value))
        return max(answer.tolerance * abs(value), answer.floor)

    @staticmethod
    def _is_distinctive(
        candidate: WrongValue, value: float, tolerance: float, wrong_values: Iterable[WrongValue], count: bool
    ) -> bool:
        """Whether a wrong value differs from the right one, from those of earlier mistakes, and from 0.

        Many mistakes lead to 0.
        """
        if abs(candidate.value - value) <= tolerance + candidate.tolerance or (
            abs(candidate.value) <= 1e-9 and not count
        ):
            return False
        return all(
            abs(candidate.value - earlier.value) > candidate.tolerance + earlier.tolerance for earlier in wrong_values
        )

    def _most_telling_field(self, fields: tuple[Field, ...]) -> Field:
        """Return the field that distinguishes most mistakes; choose at random among several."""
        asking = [field for field in fields if round(abs(field.value), 9) not in (0, 1)] or list(fields)
        most = max(len(field.wrong) for field in asking)
        best = [field for field in asking if len(field.wrong) == most]
        return Stream(f"{self.problem.id}/{self.part.name}/one number").choice(best)

    def _question_text(self, numeric_part: NumericPart, fields: tuple[Field, ...], entries: int) -> str:
        text = prompt(self.problem, self.part)
        answer_line = _ANSWER.search(text)
        convention = (
            "" if answer_line is None or self.part.type in ("expression", "direction") else answer_line[1].strip()
        )
        for pattern, instead in _TYPED:
            convention = pattern.sub(instead, convention)
        labels = entry_labels(self.problem, self.part, numeric_part.values.shape)
        return render(
            "exports/question.md.j2",
            asked=_ANSWER.sub("", text).strip(),
            given=numeric_part.given_values,
            unit="" if numeric_part.unit is None else f"its entry ${labels[numeric_part.unit]}$",
            convention=convention,
            fields=fields,
            entries=entries,
            precision="exactly" if fields[0].tolerance == 0 else self.part.precision,
        ).strip()
