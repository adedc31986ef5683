"""A sheet of paper as data: a student's problems in Markdown, with figures, and boxes to write in; no layout yet."""

import math
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from typing import Any

from exercises.answers import (
    TRUE_FALSE,
    Answer,
    Choice,
    ConditionSet,
    Direction,
    Expression,
    Forms,
    Matching,
    Matrix,
    Number,
    Selection,
)
from exercises.assignment import Assignment
from exercises.drawing import Failures, GivenUp, draws_of, recorded, vouching
from exercises.exports.bank import bank
from exercises.exports.outlet import Order
from exercises.figure import alt_text, figure_svg, part_alt, part_svg
from exercises.notebook import points_text, solution_figure
from exercises.parallel import ordered_map
from exercises.problem import Part, Problem
from exercises.quizzes import ASKED
from exercises.redrawn import Redraw
from exercises.writing.on_paper import on_paper
from exercises.writing.short_answer import short_answer
from exercises.writing.statement import hints, prompt, statement, worked_solutions

WORKING = {
    "expression": 45, "matrix": 45, "singular": 45, "number": 45, "direction": 40, "choice": 12, "selection": 15,
    "matching": 20,
}  # fmt: skip
"""Millimetres left for working, by the type of the answer, before the box for the answer itself."""
MOST_WORKING, PER_ROW = 80, 6
"""The most of them, and how many more a row of a matrix gets after the second."""
ROW, WIDE_ROW = 10, 13
"""Millimetres of height of a box's rows: where they are as wide as the page, and where several share it."""
FIGURE = 90
"""Millimetres of height of a figure, at most."""
VERSIONS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"


@dataclass(frozen=True)
class Figure:
    """A drawing as SVG, and what it shows in words."""

    svg: str
    alt: str


@dataclass(frozen=True)
class Box:
    """Where an answer is written: `working` mm of room, then rows of cells, or a box for each letter if `letters`.

    `height` is that of a row in mm; `units` are printed at the end of a row, where each has a number of its own.
    """

    working: int
    rows: int = 1
    columns: int = 1
    height: int = ROW
    letters: bool = False
    units: tuple[str, ...] = ()

    @property
    def room(self) -> int:
        """Millimetres of height of all of it, with its frame and a heading."""
        return self.working + self.rows * self.height + 35


@dataclass(frozen=True)
class SheetPart:
    """A part: Markdown and figures. Of `solution` and `answer` only what the sheet shows is filled in."""

    label: str
    title: str
    points: str
    worth: float
    prompt: str
    hints: tuple[str, ...]
    figure: Figure | None
    box: Box | None
    solution: str
    solution_figure: Figure | None
    answer: str

    @property
    def room(self) -> int:
        """About how many millimetres of height a part takes that has a box."""
        return (self.box.room if self.box else 0) + (FIGURE if self.figure else 0)


@dataclass(frozen=True)
class SheetProblem:
    """A problem: what is given, and the parts."""

    number: int
    title: str
    statement: str
    figure: Figure | None
    parts: tuple[SheetPart, ...]

    @property
    def points(self) -> str:
        """The points of all parts together, a number."""
        return f"{sum(part.worth for part in self.parts):g}"


@dataclass(frozen=True)
class Sheet:
    """A student's sheet, or a version's, whose `name` is empty; `file` is what its file is called."""

    file: str
    name: str
    student: str
    problems: tuple[SheetProblem, ...]

    @property
    def parts(self) -> list[SheetPart]:
        """All parts in order."""
        return [part for problem in self.problems for part in problem.parts]

    @property
    def points(self) -> str:
        """The points of all problems together, a number."""
        return f"{sum(part.worth for part in self.parts):g}"

    @property
    def has_hints(self) -> bool:
        """Whether there are hints to any part."""
        return any(part.hints for part in self.parts)


@dataclass(frozen=True)
class _Named:
    """Whose problems a sheet shows; `problems` are None where they are still to be drawn, from the roster."""

    file: str
    name: str
    student: str
    problems: tuple[Problem, ...] | None = None


@dataclass(frozen=True)
class _State:
    """What the processes that make sheets are told."""

    assignment: Assignment
    failures: Failures
    kind: str
    solutions: bool


@dataclass(frozen=True)
class _Made:
    """A sheet, None where a problem had to be given up; and the draws of it that are not on record yet."""

    sheet: Sheet | None
    redrawn: Mapping[str, Redraw] = field(default_factory=dict)
    given_up: tuple[GivenUp, ...] = ()


def sheets(order: Order) -> Generator[Sheet, None, None]:
    """Yield a sheet for everybody on the roster, or for each of `order.versions`; several are made at a time."""
    wanted = _versions(order) if order.versions else [_Named(s.id, s.name, s.id) for s in order.assignment.roster]
    state = _State(order.assignment, order.failures, order.sheet, order.solutions)
    assignment = order.assignment
    with closing(ordered_map(_sheet, wanted, order.jobs, _same, (state,))) as every:
        for named, made in zip(wanted, every, strict=True):
            order.each()
            for given in made.given_up:
                order.left_out(given)
            if made.redrawn:  # on record before anybody has the sheet
                assignment = recorded(assignment, named.student, made.redrawn)
            if made.sheet is not None:
                yield made.sheet


def _versions(order: Order) -> list[_Named]:
    """Return versions A, B, … made of the bank's variants; a place with few of them repeats these."""
    versions: dict[str, list[Problem]] = {}
    for variant in bank(replace(order, variants=order.versions, each=lambda: None)):
        versions.setdefault(variant.slot.name, []).append(variant.problem)
    return [
        _Named(letter, f"Version {letter}", "", tuple(drawn[number % len(drawn)] for drawn in versions.values()))
        for number, letter in enumerate(VERSIONS[: order.versions])
    ]


def _same(state: _State) -> _State:
    return state


def _sheet(state: _State, named: _Named) -> _Made:
    if named.problems is not None:
        return _Made(_of_problems(state, named, named.problems))
    draws = draws_of(state.assignment, named.student, vouching(state.failures))
    if draws.given_up:
        return _Made(None, given_up=draws.given_up)
    problems = [drawn.problem for drawn in draws.drawn.values()]
    return _Made(_of_problems(state, named, problems), draws.redrawn(state.assignment))


def _of_problems(state: _State, named: _Named, problems: Sequence[Problem]) -> Sheet:
    return Sheet(named.file, named.name, named.student, tuple(_given(state, n, p) for n, p in enumerate(problems, 1)))


def _given(state: _State, number: int, problem: Problem) -> SheetProblem:
    text = statement(problem, "")
    drawn = state.kind != "key"  # nobody looks at it there
    solved = worked_solutions(problem) if state.solutions else {}
    return SheetProblem(
        number,
        problem.title,
        on_paper(text, problem) if state.kind == "exam" else text,
        Figure(figure_svg(problem.chain, f"p{number}"), alt_text(problem.chain)) if drawn else None,
        tuple(
            _asked(state, f"{number}.{index}", problem, part, solved.get(part.name, ""))
            for index, part in enumerate(problem.parts, 1)
        ),
    )


def _asked(state: _State, label: str, problem: Problem, part: Part, solution: str) -> SheetPart:
    kind, solutions = state.kind, state.solutions
    text = prompt(problem, part)
    name = f"p{label.replace('.', '-')}"
    svg = part_svg(problem.chain, part, name) if kind != "key" else ""
    solved = solution_figure(problem, part, f"{name}-solution") if solutions else ""
    return SheetPart(
        label,
        ASKED[part.kind].title,
        points_text(part.points),
        part.points,
        on_paper(text, problem) if kind == "exam" else text,
        hints(problem, part) if kind == "handout" and not solutions and state.assignment.hints else (),
        Figure(svg, part_alt(problem.chain, part)) if svg else None,
        box_of(part) if kind == "exam" and not solutions else None,
        solution,
        Figure(solved, "The arm in a regular and in its singular configurations") if solved else None,
        short_answer(problem, part) if kind == "key" else "",
    )


def box_of(part: Part) -> Box:
    """Return a box that the answer's form fits into: a cell an entry, a line for a formula, a box a letter."""
    return part.answer.told_to(_Boxes())


class _Boxes(Forms[Box]):
    """The box of each form of answer."""

    def formula(self, answer: Expression) -> Box:
        return self._lines(answer)

    def matrix(self, answer: Matrix) -> Box:
        return self._cells(answer, height=WIDE_ROW if answer.shape[1] > 1 else ROW)

    def direction(self, answer: Direction) -> Box:
        return self._cells(answer)

    def numbers(self, answer: Number) -> Box:
        return self._cells(answer, units=tuple(unit.replace("^2", "²").replace("^3", "³") for unit in answer.units))

    def conditions(self, answer: ConditionSet) -> Box:
        return replace(self._lines(answer), rows=max(3, math.ceil(len(answer.components) / 3) * 3))

    def one_of(self, answer: Choice) -> Box:
        return replace(self._lines(answer), letters=answer.options != TRUE_FALSE)

    def some_of(self, answer: Selection) -> Box:
        return self._lines(answer)

    def matching(self, answer: Matching) -> Box:
        return replace(self._lines(answer), columns=len(answer.items), letters=True)

    def _lines(self, answer: Answer) -> Box:
        return Box(WORKING[answer.type])

    def _cells(self, answer: Answer, **given: Any) -> Box:
        rows, columns = answer.shape or (1, 1)
        return Box(min(MOST_WORKING, WORKING[answer.type] + PER_ROW * max(0, rows - 2)), rows, columns, **given)
