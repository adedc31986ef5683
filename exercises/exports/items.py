"""Quiz items, the middle between problems and learning platforms: what is asked, in which form, and what is right.

Texts are our Markdown with LaTeX; figures stand where they are shown. Platforms that compare no formulas ask for their
values at a configuration (`exports.numbers`); what can't be asked at all is told by `order.note`.
"""

import re
from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from qdot.exercises.answers import LETTERS, TRUE_FALSE, Choice, Forms, Letters, Matching, Number, Selection
from qdot.exercises.assignment.assignment import Slot
from qdot.exercises.assignment.draws import Variant
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.exports.bank import worked_out
from qdot.exercises.exports.numbers import InNumbers, in_numbers
from qdot.exercises.exports.outlet import Order
from qdot.exercises.figure import alt_text, figure_svg, part_alt, part_svg
from qdot.exercises.notebook.notebook import solution_figure
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.quizzes import ASKED
from qdot.exercises.quizzes.options import blames_of
from qdot.exercises.writing.latex import tex
from qdot.exercises.writing.render import render
from qdot.exercises.writing.statement import hints, option_text, prompt, statement, worked_solution

MOST_WRONG = 6
"""Mistakes that are told of one number: more would be met by chance."""
SHORT_QUESTIONS = ("singular-angles-choice", "singular-configurations", "singular-drawing")
"""What is asked in place of a set of singular configurations, the first that the arm allows."""


@dataclass(frozen=True)
class Picture:
    """A drawing where it stands in a text: its name in the item, SVG, and what it shows in words."""

    name: str
    svg: str
    alt: str


@dataclass(frozen=True)
class Option:
    """An option: its text, whether it is right, and what is said to who takes it."""

    text: str
    right: bool
    feedback: str = ""


@dataclass(frozen=True)
class Choose:
    """One option of several, or all that are right. Those that a drawing shows by their letters keep their order."""

    options: tuple[Option, ...]
    several: bool = False
    fixed: bool = False

    @property
    def is_true_or_false(self) -> bool:
        """Whether a statement is judged."""
        return tuple(option.text for option in self.options) == TRUE_FALSE

    @property
    def shown(self) -> tuple[str, ...]:
        """The texts with the letters by which solutions call them; those of a drawing have it, true and false none."""
        texts = tuple(option.text for option in self.options)
        return texts if self.fixed else _lettered(texts)


@dataclass(frozen=True)
class Match:
    """To each of `stems` (LaTeX) its option (plain text), by its number from 0; options may be left over."""

    stems: tuple[str, ...]
    options: tuple[str, ...]
    correct: tuple[int, ...]

    @property
    def shown(self) -> tuple[str, ...]:
        """The stems with the letters by which solutions call them."""
        return _lettered(self.stems)


def _lettered(texts: Sequence[str]) -> tuple[str, ...]:
    return tuple(f"{letter}. {text}" for letter, text in zip(LETTERS, texts, strict=False))


@dataclass(frozen=True)
class Wrong:
    """A value that a mistake gives: its title, and what is said to who made it."""

    value: float
    tolerance: float
    title: str
    advice: str


@dataclass(frozen=True)
class Field:
    """A number to be typed: LaTeX and words for it, its value, what it may be off, its unit, wrong values."""

    label: str
    words: str
    value: float
    tolerance: float
    unit: str
    wrong: tuple[Wrong, ...]


@dataclass(frozen=True)
class Numeric:
    """Numbers to be typed, by rows; nothing is typed where there is no field, but the text that stands there."""

    rows: tuple[tuple[Field | str, ...], ...]

    @property
    def fields(self) -> tuple[Field, ...]:
        """All fields, row by row."""
        return tuple(entry for row in self.rows for entry in row if isinstance(entry, Field))


@dataclass(frozen=True)
class Item:
    """A question as platforms ask it. `key` is no other's and stays; `category` is assignment, place, question.

    `number` asks for a single number of several, for platforms that take one; None where there is but one, or none.
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
    """Yield every variant's parts as items, by place and variant. What can't be asked is noted once for a place."""
    told: set[str] = set()
    for variant, made in worked_out(order, _items_of):
        for part, one in zip(variant.problem.parts, made, strict=True):
            if one is not None:
                yield _numbered(one, variant)
                continue
            said = f"{variant.slot.name}: {part.name} can't be asked on a platform that compares no formulas"
            if said not in told:
                told.add(said)
                order.note(said)


def _items_of(order: Order, slot: Slot, problem: Problem) -> list[Item | None]:
    """Return the parts of a problem as items whose keys and titles lack the variant's."""
    return [_item(order, slot, problem, part) for part in problem.parts]


def _numbered(one: Item, variant: Variant) -> Item:
    """Return an item with the key and the title by which its variant is told from others."""
    number = one.number and _numbered(one.number, variant)
    return replace(one, key=f"{variant.key}-{one.key}", title=f"{one.title} ({variant.key})", number=number)


def as_told(order: Order) -> Generator[Item, None, None]:
    """Yield the items for a platform without levels of feedback: solutions only where students may have them."""
    for one in items(order):
        number = one.number and replace(one.number, solution=())
        yield one if order.solutions or order.tells("solutions") else replace(one, solution=(), number=number)


def _item(order: Order, slot: Slot, problem: Problem, part: Part) -> Item | None:
    """Return a part of a problem as an item without its variant's number, None where it can't be asked."""
    if part.answer.is_a_set:
        short = _in_short(problem, part, order)
        if short is None:
            return None
        problem, (part,) = short, short.parts
    told = order.tells("mistake")
    return _Maker(slot, problem, part, order.assignment.title, order.assignment.hints, told).item()


def _in_short(problem: Problem, part: Part, order: Order) -> Problem | None:
    """Return a problem with a short question on singular configurations in place of one that asks for all of them."""
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
"""What prompts say of how formulas are typed."""


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
class _Options(Forms[Choose | Match]):
    """How a platform is told of options."""

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
            blames = blames_of(self.part, index) if self.tells_mistakes and not is_right else ()
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
            form = answer.told_to(_Options(self.problem, self.part, self.tells_mistakes))
            return self._made(question_alone(self.problem, self.part), form)
        in_figures = in_numbers(self.problem, self.part)
        if in_figures is None:
            return None
        numeric = self._numeric(in_figures)
        whole = self._made(self._in_words(in_figures, numeric.fields, len(numeric.fields)), numeric, in_figures)
        if len(numeric.fields) == 1:
            return whole
        one = self._telling(numeric.fields)
        single = self._made(self._in_words(in_figures, (one,), len(numeric.fields)), Numeric(((one,),)), in_figures)
        return replace(whole, number=single)

    def _made(self, asked: str, form: Choose | Match | Numeric, found: InNumbers | None = None) -> Item:
        problem, part, slot = self.problem, self.part, self.slot
        arm = Picture("arm", figure_svg(problem.chain), alt_text(problem.chain))
        svg = part_svg(problem.chain, part, part.name)
        own = (Picture(part.name, svg, part_alt(problem.chain, part)),) if svg else ()
        title = ASKED[part.kind].title
        return Item(
            key=part.name,
            title=title,
            category=(self.title, f"{slot.name} {slot.family.name}", title),
            body=(arm, statement(problem, "", typed=False), *own, asked),
            form=form,
            points=part.points,
            solution=self._solution(found),
            hints=hints(problem, part) if self.hinted else (),
        )

    def _solution(self, found: InNumbers | None) -> tuple[str | Picture, ...]:
        text = worked_solution(self.problem, self.part)
        if found is not None and (found.given is not None or found.unit is not None):
            rows = [[f"{value:.4g}" for value in row] for row in found.values]
            text += "\n" + render("exports/solution.md.j2", rows=rows)
        svg = solution_figure(self.problem, self.part, "solution")
        drawn = Picture("solution", svg, "The arm in a regular and in its singular configurations") if svg else None
        return (text,) if drawn is None else (text, drawn)

    # --- numbers ---

    def _numeric(self, found: InNumbers) -> Numeric:
        rows, columns = found.values.shape
        labels = entry_labels(self.problem, self.part, found.values.shape)
        made = [
            [
                "1" if found.unit == r * columns + c else self._field(found, r, c, labels[r * columns + c])
                for c in range(columns)
            ]
            for r in range(rows)
        ]
        if last_row := ASKED[self.part.kind].last_row:
            made[-1] = list(last_row)
        return Numeric(tuple(tuple(row) for row in made))

    def _field(self, found: InNumbers, row: int, column: int, label: str) -> Field:
        answer = found.part.of(Number)
        rows, columns = found.values.shape
        value = float(found.values[row, column])
        tolerance = self._tolerance(answer, value)
        kept: list[Wrong] = []
        for title, advice, values in found.wrong if self.tells_mistakes else ():
            if values.shape != found.values.shape or not np.isfinite(values[row, column]):
                continue
            other = float(values[row, column])
            one = Wrong(other, self._tolerance(answer, other), title, advice)
            if self._tells(one, value, tolerance, kept, answer.tolerance < 1e-6):
                kept.append(one)
        place = f"row {row + 1}, column {column + 1}" if columns > 1 else f"entry {row + 1}" if rows > 1 else ""
        words = f"that in {place} of the matrix" if columns > 1 else f"${label}$ ({place})" if place else f"${label}$"
        unit = answer.units[row * columns + column]
        return Field(label, words, value, tolerance, unit, tuple(kept[:MOST_WRONG]))

    def _tolerance(self, answer: Number, value: float) -> float:
        """Return what a number may be off, for a platform that is told so in its own unit."""
        allowed = self.part.rounding
        if answer.tolerance < 1e-6:  # a count
            return 0.0
        if allowed is not None:
            return max(allowed.relative * abs(value), allowed.absolute, 1e-9 * abs(value))
        return max(answer.tolerance * abs(value), answer.floor)

    @staticmethod
    def _tells(one: Wrong, value: float, tolerance: float, kept: Iterable[Wrong], count: bool) -> bool:
        """Whether a wrong value is none that is right, or that an earlier mistake gives, or 0, which many get to."""
        if abs(one.value - value) <= tolerance + one.tolerance or (abs(one.value) <= 1e-9 and not count):
            return False
        return all(abs(one.value - other.value) > one.tolerance + other.tolerance for other in kept)

    def _telling(self, fields: tuple[Field, ...]) -> Field:
        """Return the field that tells most mistakes apart; where several do, one of them is drawn."""
        asking = [field for field in fields if round(abs(field.value), 9) not in (0, 1)] or list(fields)
        most = max(len(field.wrong) for field in asking)
        best = [field for field in asking if len(field.wrong) == most]
        return Stream(f"{self.problem.id}/{self.part.name}/one number").choice(best)

    def _in_words(self, found: InNumbers, fields: tuple[Field, ...], entries: int) -> str:
        text = prompt(self.problem, self.part)
        said = _ANSWER.search(text)
        convention = "" if said is None or self.part.type in ("expression", "direction") else said[1].strip()
        for pattern, instead in _TYPED:
            convention = pattern.sub(instead, convention)
        labels = entry_labels(self.problem, self.part, found.values.shape)
        return render(
            "exports/question.md.j2",
            asked=_ANSWER.sub("", text).strip(),
            given=found.given,
            unit="" if found.unit is None else f"its entry ${labels[found.unit]}$",
            convention=convention,
            fields=fields,
            entries=entries,
            precision="exactly" if fields[0].tolerance == 0 else self.part.precision,
        ).strip()
