"""The content of a paper sheet before its layout: a student's problems in Markdown, figures, and answer boxes."""

import math
import re
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial

from qdot.exercises.assignment.draws import FailedSlot, certify_with, generate_student_problems, record_redraws
from qdot.exercises.assignment.redrawn import Redraw
from qdot.exercises.common.parallel import keep_state, map_in_order
from qdot.exercises.exports.bank import iterate_bank
from qdot.exercises.exports.boxes import (
    AnswerBox,
    PaperOptions,
    arrange_options,
    compute_share_that_fits,
    make_box,
    scale_working_space,
)
from qdot.exercises.exports.export_format import ExportRequest
from qdot.exercises.exports.marking import MarkingInstructions, explain_marking
from qdot.exercises.exports.markup import Picture, draw_arm, draw_prompt_figure, draw_solution_figure
from qdot.exercises.notebook.notebook import write_points
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.exercises.writing.on_paper import remove_options, remove_typing_remarks
from qdot.exercises.writing.problem_texts import hints, prompt, statement, worked_solutions
from qdot.exercises.writing.short_answer import short_answer

FIGURE_HEIGHT = 50
"""Maximum height of a figure in mm."""
STATEMENT_HEIGHT, MAX_PART_HEIGHT = 78, 92
"""Height of a statement, and maximum height of a part with its share of the statement, in mm."""
WIDTH_BESIDE_FIGURE = 0.58
"""The share of the page's width that a prompt gets if its figure is beside it."""
PROBLEM_SHEETS = ("handout", "exam")
"""Sheets that show the problems, not only the answers."""
VERSION_LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"


@dataclass(frozen=True)
class SheetPart:
    """A part: Markdown and figures. `solution` and `answer` are empty unless the sheet shows them.

    The `figure` is beside the prompt, or above it if `has_wide_figure`. If `has_score_space`, the part has space for
    its points.
    """

    label: str
    title: str
    points: str
    max_points: float
    prompt: str
    hints: tuple[str, ...]
    figure: Picture | None
    options: PaperOptions | None
    box: AnswerBox | None
    solution: str
    solution_figure: Picture | None
    answer: str
    has_score_space: bool = False
    has_wide_figure: bool = False
    marking: MarkingInstructions | None = None

    @property
    def height(self) -> int:
        """Approximate height in mm of a part that is scored on the sheet."""
        options = 8 * math.ceil(len(self.options.options) / self.options.columns) if self.options else 0
        box = self.box.total_height if self.box else 0
        if self.figure is None or self.has_wide_figure or self.box is None or not self.box.is_narrow:
            return 25 + max(options, FIGURE_HEIGHT if self.figure else 0) + box
        return 15 + max(FIGURE_HEIGHT, 15 + options + box)


@dataclass(frozen=True)
class SheetProblem:
    """A problem: its statement and parts. The table is beside the figure, and other facts are below both."""

    number: int
    title: str
    intro: str
    table: str
    facts: str
    figure: Picture | None
    parts: tuple[SheetPart, ...]

    @property
    def points(self) -> str:
        """The points of all parts together, a number."""
        return f"{sum(part.max_points for part in self.parts):g}"


@dataclass(frozen=True)
class Sheet:
    """The sheet of a student or of a version; a version has no `student`. `file_stem` is the stem of its file name."""

    file_stem: str
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
        return f"{sum(part.max_points for part in self.parts):g}"

    @property
    def has_hints(self) -> bool:
        """Whether any part has hints."""
        return any(part.hints for part in self.parts)


@dataclass(frozen=True)
class _SheetRequest:
    """A request for the sheet of a student or version. If `problems` is None, the student's problems are generated."""

    file_stem: str
    name: str
    student: str
    problems: tuple[Problem, ...] | None = None


_SheetResult = tuple[Sheet | None, Mapping[str, Redraw], tuple[FailedSlot, ...]]
"""A sheet (None if a slot failed), the regenerated problems that are not recorded yet, and the slots that failed."""


def make_sheets(order: ExportRequest) -> Generator[Sheet, None, None]:
    """Yield a sheet for each student on the roster, or `order.version_count` versions; make the sheets in parallel."""
    if order.version_count:
        requests = _request_versions(order)
    else:
        requests = [_SheetRequest(s.id, s.name, s.id) for s in order.assignment.roster]
    assignment = order.assignment
    with closing(map_in_order(_make_sheet, requests, order.jobs, keep_state, (order.without_callbacks,))) as results:
        for request, (sheet, redraws, failed_slots) in zip(requests, results, strict=True):
            order.on_step()
            for failure in failed_slots:
                order.on_left_out(failure)
            if redraws:  # recorded before anybody gets the sheet
                assignment = record_redraws(assignment, request.student, redraws)
            if sheet is not None:
                yield sheet


def _request_versions(order: ExportRequest) -> list[_SheetRequest]:
    """Return versions A, B, … made from the bank's variants, which are repeated if a slot has too few."""
    versions: dict[str, list[Problem]] = {}
    for variant in iterate_bank(replace(order, variant_count=order.version_count, on_step=lambda: None)):
        versions.setdefault(variant.slot.name, []).append(variant.problem)
    requests = []
    for number, letter in enumerate(VERSION_LETTERS[: order.version_count]):
        problems = tuple(slot_problems[number % len(slot_problems)] for slot_problems in versions.values())
        requests.append(_SheetRequest(letter, f"Version {letter}", "", problems))
    return requests


def _make_sheet(order: ExportRequest, request: _SheetRequest) -> _SheetResult:
    if request.problems is not None:
        return _make_sheet_of_problems(order, request, request.problems), {}, ()
    student_problems = generate_student_problems(
        order.assignment, request.student, partial(certify_with, order.find_failures)
    )
    if student_problems.failed_slots:
        return None, {}, student_problems.failed_slots
    problems = [certified.problem for certified in student_problems.certified.values()]
    return _make_sheet_of_problems(order, request, problems), student_problems.new_redraws(order.assignment), ()


def _make_sheet_of_problems(order: ExportRequest, request: _SheetRequest, problems: Sequence[Problem]) -> Sheet:
    sheet_problems = tuple(_make_sheet_problem(order, n, p) for n, p in enumerate(problems, 1))
    return Sheet(request.file_stem, request.name, request.student, _shrink_boxes(sheet_problems))


def _shrink_boxes(problems: tuple[SheetProblem, ...]) -> tuple[SheetProblem, ...]:
    """Return problems with less working space if they would take more than about two pages for five parts."""
    parts = [part for problem in problems for part in problem.parts]
    boxes = [part.box for part in parts if part.box is not None]
    fixed_height = STATEMENT_HEIGHT * len(problems) + sum(part.height for part in parts)
    fixed_height -= sum(box.working_space for box in boxes)
    share = compute_share_that_fits(boxes, fixed_height, MAX_PART_HEIGHT * len(parts))

    def shrink_box(part: SheetPart) -> SheetPart:
        return part if part.box is None else replace(part, box=scale_working_space(part.box, share))

    return tuple(replace(problem, parts=tuple(map(shrink_box, problem.parts))) for problem in problems)


def _make_sheet_problem(order: ExportRequest, number: int, problem: Problem) -> SheetProblem:
    intro, table, facts = _split_statement(remove_typing_remarks(statement(problem, ""), problem))
    is_printed = order.sheet in PROBLEM_SHEETS
    # the working space in an exam depends on the solution's length
    solutions_by_part = worked_solutions(problem) if order.has_solutions or order.sheet == "exam" else {}
    figure = draw_arm(problem, f"p{number}") if is_printed else None
    parts = (
        _make_sheet_part(order, f"{number}.{index}", problem, part, solutions_by_part.get(part.name, ""))
        for index, part in enumerate(problem.parts, 1)
    )
    return SheetProblem(number, problem.title, intro, table, facts, figure, tuple(parts))


def _split_statement(text: str) -> tuple[str, str, str]:
    """Return the text before the table of a statement, the table, and the text after it."""
    table = re.search(r"^(?:\|.*\n)+", text, re.MULTILINE)
    if table is None:
        return text, "", ""
    return text[: table.start()], table[0], text[table.end() :]


def _make_sheet_part(order: ExportRequest, label: str, problem: Problem, part: Part, solution: str) -> SheetPart:
    solutions, is_printed = order.has_solutions, order.sheet in PROBLEM_SHEETS
    is_exam, name = order.sheet == "exam" and not solutions, f"p{label.replace('.', '-')}"
    text = remove_typing_remarks(prompt(problem, part), problem)
    figure = draw_prompt_figure(problem, part, name) if is_printed else None
    width_share = WIDTH_BESIDE_FIGURE if figure and not part.details.has_drawn_options else 1.0
    options = arrange_options(problem, part, width_share) if is_printed else None
    shown_hints = hints(problem, part) if order.sheet == "handout" and not solutions and order.assignment.hints else ()
    earned_share = order.earned_share if order.sheet == "marking" else None
    return SheetPart(
        label, ALL_QUESTIONS[part.kind].make_title(problem.chain), write_points(part.points), part.points,
        prompt=text if options is None else remove_options(text),
        hints=tuple(remove_typing_remarks(hint, problem) for hint in shown_hints), figure=figure, options=options,
        box=make_box(problem, part, solution) if is_exam else None,
        solution=remove_typing_remarks(solution, problem) if solutions else "",
        solution_figure=draw_solution_figure(problem, part, f"{name}-solution") if solutions else None,
        answer=short_answer(problem, part) if order.sheet == "key" else "", has_score_space=is_exam,
        has_wide_figure=part.details.has_drawn_options,
        marking=explain_marking(problem, part, earned_share) if earned_share else None,
    )  # fmt: skip
