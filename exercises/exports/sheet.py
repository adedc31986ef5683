"""A sheet of paper as data: a student's problems in Markdown, figures, and boxes to write in, but no layout."""

import math
import re
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.assignment.draws import FailedSlot, Failures, certify_by, generate_student_problems, record_redraws
from qdot.exercises.assignment.redrawn import Redraw
from qdot.exercises.common.parallel import ordered_map
from qdot.exercises.exports.bank import bank
from qdot.exercises.exports.boxes import Box, PaperOptions, box_of, options_of, scale_working_room, share_that_fits
from qdot.exercises.exports.export_format import Earns, Order
from qdot.exercises.exports.marking import Marking, marking
from qdot.exercises.figure import alt_text, figure_svg, part_alt, part_svg
from qdot.exercises.notebook.notebook import points_text, solution_figure
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.quizzes import ASKED
from qdot.exercises.writing.on_paper import on_paper, without_options
from qdot.exercises.writing.short_answer import short_answer
from qdot.exercises.writing.statement import hints, prompt, statement, worked_solutions

FIGURE = 50
"""Maximum height of a figure in mm."""
STATEMENT, PART = 78, 92
"""Height of a statement, and maximum height of a part with its share of the statement, in mm."""
BESIDE = 0.58
"""The share of the page's width for a prompt beside its figure."""
PROBLEMS = ("handout", "exam")
"""Sheets that show the problems, not only the answers."""
VERSIONS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"


@dataclass(frozen=True)
class Figure:
    """A figure as SVG, and its description in words."""

    svg: str
    alt: str


@dataclass(frozen=True)
class SheetPart:
    """A part: Markdown and figures. `solution` and `answer` are empty unless the sheet shows them.

    Its `figure` stands beside the prompt, unless it is `wide`. A `scored` part has room for its points.
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
        """Approximate height in mm of a part that is scored on the sheet."""
        options = 8 * math.ceil(len(self.options.offered) / self.options.columns) if self.options else 0
        box = self.box.room if self.box else 0
        if self.figure is None or self.wide or self.box is None or not self.box.is_narrow:
            return 25 + max(options, FIGURE if self.figure else 0) + box
        return 15 + max(FIGURE, 15 + options + box)


@dataclass(frozen=True)
class SheetProblem:
    """A problem: its statement and parts. The table stands beside the figure, other facts below both."""

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
    """The sheet of a student or of a version, which has no `student`; `file` is the stem of its file name."""

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
        """Whether any part has hints."""
        return any(part.hints for part in self.parts)


@dataclass(frozen=True)
class _SheetRequest:
    """The student or version of a sheet; `problems` are None if they still have to be generated for the student."""

    file: str
    name: str
    student: str
    problems: tuple[Problem, ...] | None = None


@dataclass(frozen=True)
class _State:
    """What a process needs to make sheets."""

    assignment: Assignment
    failures: Failures
    kind: str
    solutions: bool
    earns: Earns | None = None


@dataclass(frozen=True)
class _SheetResult:
    """A sheet, None if no problem was possible for some slot, and its replaced problems that are not recorded yet."""

    sheet: Sheet | None
    redrawn: Mapping[str, Redraw] = field(default_factory=dict)
    given_up: tuple[FailedSlot, ...] = ()


def sheets(order: Order) -> Generator[Sheet, None, None]:
    """Yield a sheet for everybody on the roster, or for each of `order.versions`, made in parallel."""
    wanted = (
        _versions(order) if order.versions else [_SheetRequest(s.id, s.name, s.id) for s in order.assignment.roster]
    )
    state = _State(order.assignment, order.failures, order.sheet, order.solutions, order.earns)
    assignment = order.assignment
    with closing(ordered_map(_make_sheet, wanted, order.jobs, _keep_state, (state,))) as every:
        for request, result in zip(wanted, every, strict=True):
            order.each()
            for failure in result.given_up:
                order.left_out(failure)
            if result.redrawn:  # on record before anybody has the sheet
                assignment = record_redraws(assignment, request.student, result.redrawn)
            if result.sheet is not None:
                yield result.sheet


def _versions(order: Order) -> list[_SheetRequest]:
    """Return versions A, B, … made from the bank's variants, which are repeated if a slot has too few."""
    versions: dict[str, list[Problem]] = {}
    for variant in bank(replace(order, variants=order.versions, each=lambda: None)):
        versions.setdefault(variant.slot.name, []).append(variant.problem)
    return [
        _SheetRequest(letter, f"Version {letter}", "", tuple(drawn[number % len(drawn)] for drawn in versions.values()))
        for number, letter in enumerate(VERSIONS[: order.versions])
    ]


def _keep_state(state: _State) -> _State:
    return state


def _make_sheet(state: _State, request: _SheetRequest) -> _SheetResult:
    if request.problems is not None:
        return _SheetResult(_sheet_of_problems(state, request, request.problems))
    draws = generate_student_problems(state.assignment, request.student, certify_by(state.failures))
    if draws.given_up:
        return _SheetResult(None, given_up=draws.given_up)
    problems = [drawn.problem for drawn in draws.certified.values()]
    return _SheetResult(_sheet_of_problems(state, request, problems), draws.new_redraws(state.assignment))


def _sheet_of_problems(state: _State, request: _SheetRequest, problems: Sequence[Problem]) -> Sheet:
    numbered = tuple(_sheet_problem(state, n, p) for n, p in enumerate(problems, 1))
    return Sheet(request.file, request.name, request.student, _shrink_boxes(numbered))


def _shrink_boxes(problems: tuple[SheetProblem, ...]) -> tuple[SheetProblem, ...]:
    """Return problems with less working space if they would take more than about two pages for five parts."""
    parts = [part for problem in problems for part in problem.parts]
    boxes = [part.box for part in parts if part.box is not None]
    fixed = STATEMENT * len(problems) + sum(part.room for part in parts) - sum(box.working for box in boxes)
    share = share_that_fits(boxes, fixed, PART * len(parts))

    def smaller(part: SheetPart) -> SheetPart:
        return part if part.box is None else replace(part, box=scale_working_room(part.box, share))

    return tuple(replace(problem, parts=tuple(map(smaller, problem.parts))) for problem in problems)


def _sheet_problem(state: _State, number: int, problem: Problem) -> SheetProblem:
    intro, table, facts = _split_statement(on_paper(statement(problem, ""), problem))
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
            _sheet_part(state, f"{number}.{index}", problem, part, solved.get(part.name, ""))
            for index, part in enumerate(problem.parts, 1)
        ),
    )


def _split_statement(text: str) -> tuple[str, str, str]:
    """Return the text before the table of a statement, the table, and the text after it."""
    table = re.search(r"^(?:\|.*\n)+", text, re.MULTILINE)
    if table is None:
        return text, "", ""
    return text[: table.start()], table[0], text[table.end() :]


def _sheet_part(state: _State, label: str, problem: Problem, part: Part, solution: str) -> SheetPart:
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
