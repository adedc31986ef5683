"""A sheet of paper as data: a student's problems in Markdown, with figures, and boxes to write in; no layout yet."""

import math
import re
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.assignment.draws import Failures, GivenUp, draws_of, recorded, vouching
from qdot.exercises.assignment.redrawn import Redraw
from qdot.exercises.common.parallel import ordered_map
from qdot.exercises.exports.bank import bank
from qdot.exercises.exports.boxes import Box, PaperOptions, box_of, options_of, shrunk, with_share
from qdot.exercises.exports.marking import Marking, marking
from qdot.exercises.exports.outlet import Earns, Order
from qdot.exercises.figure import alt_text, figure_svg, part_alt, part_svg
from qdot.exercises.notebook.notebook import points_text, solution_figure
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.quizzes import ASKED
from qdot.exercises.writing.on_paper import on_paper, without_options
from qdot.exercises.writing.short_answer import short_answer
from qdot.exercises.writing.statement import hints, prompt, statement, worked_solutions

FIGURE = 50
"""Millimetres of height of a figure, at most."""
STATEMENT, PART = 78, 92
"""Millimetres of height that a statement takes, and that a part may take with its share of the statement."""
BESIDE = 0.58
"""The share of a page's width that is left for a prompt beside its figure."""
PROBLEMS = ("handout", "exam")
"""Sheets on which the problems stand, and not their answers alone."""
VERSIONS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"


@dataclass(frozen=True)
class Figure:
    """A drawing as SVG, and what it shows in words."""

    svg: str
    alt: str


@dataclass(frozen=True)
class SheetPart:
    """A part: Markdown and figures. Of `solution` and `answer` only what the sheet shows is filled in.

    Its `figure` stands beside the prompt, unless it is as wide as the page. What is `scored` has room for its points.
    """

    label: str
    title: str
    points: str
    worth: float
    prompt: str
    hints: tuple[str, ...]
    figure: Figure | None
    options: PaperOptions | None
    box: Box | None
    solution: str
    solution_figure: Figure | None
    answer: str
    scored: bool = False
    wide: bool = False
    marking: Marking | None = None

    @property
    def room(self) -> int:
        """About how many millimetres of height a part takes that is scored on the sheet."""
        options = 8 * math.ceil(len(self.options.offered) / self.options.columns) if self.options else 0
        box = self.box.room if self.box else 0
        if self.figure is None or self.wide or self.box is None or not self.box.is_narrow:
            return 25 + max(options, FIGURE if self.figure else 0) + box
        return 15 + max(FIGURE, 15 + options + box)


@dataclass(frozen=True)
class SheetProblem:
    """A problem: what is given, and the parts. The table stands beside the figure, other facts below both."""

    number: int
    title: str
    intro: str
    table: str
    facts: str
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
    earns: Earns | None = None


@dataclass(frozen=True)
class _Made:
    """A sheet, None where a problem had to be given up; and the draws of it that are not on record yet."""

    sheet: Sheet | None
    redrawn: Mapping[str, Redraw] = field(default_factory=dict)
    given_up: tuple[GivenUp, ...] = ()


def sheets(order: Order) -> Generator[Sheet, None, None]:
    """Yield a sheet for everybody on the roster, or for each of `order.versions`; several are made at a time."""
    wanted = _versions(order) if order.versions else [_Named(s.id, s.name, s.id) for s in order.assignment.roster]
    state = _State(order.assignment, order.failures, order.sheet, order.solutions, order.earns)
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
    given = tuple(_given(state, n, p) for n, p in enumerate(problems, 1))
    return Sheet(named.file, named.name, named.student, _shrunk(given))


def _shrunk(problems: tuple[SheetProblem, ...]) -> tuple[SheetProblem, ...]:
    """Return an exam with less room for working, where it would take more than two pages for some five parts."""
    parts = [part for problem in problems for part in problem.parts]
    boxes = [part.box for part in parts if part.box is not None]
    fixed = STATEMENT * len(problems) + sum(part.room for part in parts) - sum(box.working for box in boxes)
    share = shrunk(boxes, fixed, PART * len(parts))

    def smaller(part: SheetPart) -> SheetPart:
        return part if part.box is None else replace(part, box=with_share(part.box, share))

    return tuple(replace(problem, parts=tuple(map(smaller, problem.parts))) for problem in problems)


def _given(state: _State, number: int, problem: Problem) -> SheetProblem:
    intro, table, facts = _pieces(on_paper(statement(problem, ""), problem))
    drawn = state.kind in PROBLEMS
    needed = state.solutions or state.kind == "exam"  # an exam has as much room as a solution takes
    solved = worked_solutions(problem) if needed else {}
    return SheetProblem(
        number,
        problem.title,
        intro,
        table,
        facts,
        Figure(figure_svg(problem.chain, f"p{number}"), alt_text(problem.chain)) if drawn else None,
        tuple(
            _asked(state, f"{number}.{index}", problem, part, solved.get(part.name, ""))
            for index, part in enumerate(problem.parts, 1)
        ),
    )


def _pieces(text: str) -> tuple[str, str, str]:
    """Return what stands before the DH table of a statement, the table, and what stands behind it."""
    found = re.search(r"^(?:\|.*\n)+", text, re.MULTILINE)
    if found is None:
        return text, "", ""
    return text[: found.start()], found[0], text[found.end() :]


def _asked(state: _State, label: str, problem: Problem, part: Part, solution: str) -> SheetPart:
    kind, solutions = state.kind, state.solutions
    text = on_paper(prompt(problem, part), problem)
    name = f"p{label.replace('.', '-')}"
    svg = part_svg(problem.chain, part, name) if kind in PROBLEMS else ""
    solved = solution_figure(problem, part, f"{name}-solution") if solutions else ""
    wide = part.has_drawn_options
    options = options_of(problem, part, BESIDE if svg and not wide else 1.0) if kind in PROBLEMS else None
    hinted = hints(problem, part) if kind == "handout" and not solutions and state.assignment.hints else ()
    return SheetPart(
        label=label,
        title=ASKED[part.kind].heading(problem.chain),
        points=points_text(part.points),
        worth=part.points,
        prompt=text if options is None else without_options(text),
        hints=tuple(on_paper(hint, problem) for hint in hinted),
        figure=Figure(svg, part_alt(problem.chain, part)) if svg else None,
        options=options,
        box=box_of(problem, part, solution) if kind == "exam" and not solutions else None,
        solution=on_paper(solution, problem) if solutions else "",
        solution_figure=Figure(solved, "The arm in a regular and in its singular configurations") if solved else None,
        answer=short_answer(problem, part) if kind == "key" else "",
        scored=kind == "exam" and not solutions,
        wide=wide,
        marking=marking(problem, part, state.earns) if kind == "marking" and state.earns else None,
    )
