"""Make the content of paper sheets, which `paper` lays out: problems in Markdown, figures, and answer boxes."""

import math
import re
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial

from qdot.exercises.assignment import certified_problems
from qdot.exercises.assignment.replacements import Replacement
from qdot.exercises.common.parallel import map_in_order, return_state
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
from qdot.exercises.exports.platform_markup import Picture, draw_arm, draw_prompt_figure, draw_solution_figure
from qdot.exercises.notebook.notebook import write_points
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.short_questions import question_of
from qdot.exercises.writing.paper_texts import remove_options, remove_typing_remarks
from qdot.exercises.writing.problem_texts import write_hints, write_prompt, write_solutions, write_statement
from qdot.exercises.writing.short_answer import write_short_answer

FIGURE_HEIGHT = 50
"""Maximum height of a figure in mm."""
STATEMENT_HEIGHT, AVERAGE_PART_HEIGHT = 78, 92
"""Height of a statement and average height of a part in mm. If the parts of a sheet are higher, their working space
shrinks."""
OPTION_HEIGHT, PROMPT_HEIGHT, SHORT_PROMPT_HEIGHT = 8, 25, 15
"""Approximate heights in mm: of a row of options, of a prompt with its heading, and of a short prompt or a heading."""
WIDTH_BESIDE_FIGURE = 0.58
"""The share of the page's width that a prompt gets if its figure is beside it."""
PROBLEM_SHEETS = ("handout", "exam")
"""Sheets that show the problems, not only the answers."""
VERSION_LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
_TABLE = re.compile(r"^((?:\|.*\n)+)", re.MULTILINE)
"""Matches a table in Markdown."""


@dataclass(frozen=True)
class SheetPart:
    """A part: its texts in Markdown and its figures. `solution` and `answer` are empty unless the sheet shows them.

    `points` is `max_points` in words. The `figure` is beside the prompt, or above the prompt if `has_wide_figure`. If
    `has_score_space`, the sheet has space to write down the earned points.
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
        """Approximate height in mm of a part in an exam."""
        row_count = math.ceil(len(self.options.options) / self.options.columns) if self.options else 0
        options_height, box_height = OPTION_HEIGHT * row_count, self.box.total_height if self.box else 0
        if self.figure is None or self.has_wide_figure or self.box is None or not self.box.is_narrow:
            return PROMPT_HEIGHT + max(options_height, FIGURE_HEIGHT if self.figure else 0) + box_height
        return SHORT_PROMPT_HEIGHT + max(FIGURE_HEIGHT, SHORT_PROMPT_HEIGHT + options_height + box_height)


@dataclass(frozen=True)
class SheetProblem:
    """A problem: its statement and parts.

    The statement is `intro`, then `table` beside the figure, then `facts`. All three are Markdown.
    """

    number: int
    title: str
    intro: str
    table: str
    facts: str
    figure: Picture | None
    parts: tuple[SheetPart, ...]

    @property
    def points(self) -> str:
        """The points of all parts together, in digits."""
        return f"{sum(part.max_points for part in self.parts):g}"


@dataclass(frozen=True)
class Sheet:
    """The sheet of a student or of a version. `student` is the student's identifier, "" for a version.

    `file_stem` is the file name without its ending.
    """

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
        """The points of all problems together, in digits."""
        return f"{sum(part.max_points for part in self.parts):g}"

    @property
    def has_hints(self) -> bool:
        """Whether any part has hints."""
        return any(part.hints for part in self.parts)


@dataclass(frozen=True)
class _SheetTask:
    """A sheet to make. If `problems` is None, the student's problems are generated; other fields are as in `Sheet`."""

    file_stem: str
    name: str
    student: str
    problems: tuple[Problem, ...] | None = None


_SheetResult = tuple[Sheet | None, Mapping[str, Replacement], tuple[certified_problems.FailedSlot, ...]]
"""A sheet (None if a slot failed), the replaced problems that are not recorded yet, and the failed slots."""


def make_sheets(request: ExportRequest) -> Generator[Sheet, None, None]:
    """Yield a sheet for each student on the roster, or for each version; `jobs` processes make the sheets."""
    assignment = request.assignment
    student_tasks = [_SheetTask(student.id, student.name, student.id) for student in assignment.roster]
    tasks = _list_versions(request) if request.version_count else student_tasks
    with closing(
        map_in_order(
            _make_sheet_for_task, tasks, request.jobs, setup=return_state, arguments=(request.without_callbacks,)
        )
    ) as results:
        for task, (sheet, replacements, failed_slots) in zip(tasks, results, strict=True):
            request.on_step()
            for failure in failed_slots:
                request.on_left_out(failure)
            if replacements:  # must be recorded before anybody gets the sheet
                assignment = certified_problems.record_replacements(assignment, task.student, replacements)
            if sheet is not None:
                yield sheet


def _list_versions(request: ExportRequest) -> list[_SheetTask]:
    """Return versions A, B, … with the variants of a bank. If a slot has too few variants, they are repeated."""
    variants_by_slot: dict[str, list[Problem]] = {}
    for variant in iterate_bank(replace(request, variant_count=request.version_count, on_step=lambda: None)):
        variants_by_slot.setdefault(variant.slot.name, []).append(variant.problem)
    tasks = []
    for index, letter in enumerate(VERSION_LETTERS[: request.version_count]):
        problems = tuple(variants[index % len(variants)] for variants in variants_by_slot.values())
        tasks.append(_SheetTask(letter, f"Version {letter}", "", problems))
    return tasks


def _make_sheet_for_task(request: ExportRequest, task: _SheetTask) -> _SheetResult:
    problems, replacements = task.problems, dict[str, Replacement]()
    if problems is None:
        certify = partial(certified_problems.certify_with, request.find_failures)
        student_problems = certified_problems.generate_student_problems(request.assignment, task.student, certify)
        if student_problems.failed_slots:
            return None, {}, student_problems.failed_slots
        problems = tuple(problem.problem for problem in student_problems.certified_problems.values())
        replacements = student_problems.find_new_replacements(request.assignment)
    return make_sheet(request, task.file_stem, task.name, task.student, problems), replacements, ()


def make_sheet(
    request: ExportRequest, file_stem: str, name: str, student: str, problems: Sequence[Problem]
) -> Sheet:  # fmt: skip
    """Return the sheet with some problems; the other parameters are fields of `Sheet`."""
    sheet_problems = tuple(_make_sheet_problem(request, number, problem) for number, problem in enumerate(problems, 1))
    return Sheet(file_stem, name, student, _shrink_boxes(sheet_problems))


def _shrink_boxes(problems: tuple[SheetProblem, ...]) -> tuple[SheetProblem, ...]:
    """Return problems with less working space if a sheet is long, that is, if its parts are higher than average."""
    parts = [part for problem in problems for part in problem.parts]
    boxes = [part.box for part in parts if part.box is not None]
    working_space = sum(box.working_space for box in boxes)
    fixed_height = STATEMENT_HEIGHT * len(problems) + sum(part.height for part in parts) - working_space
    share = compute_share_that_fits(boxes, fixed_height, AVERAGE_PART_HEIGHT * len(parts))

    def shrink_box(part: SheetPart) -> SheetPart:
        return part if part.box is None else replace(part, box=scale_working_space(part.box, share))

    return tuple(replace(problem, parts=tuple(map(shrink_box, problem.parts))) for problem in problems)


def _make_sheet_problem(request: ExportRequest, number: int, problem: Problem) -> SheetProblem:
    statement_text = remove_typing_remarks(write_statement(problem, ""), problem)
    # Without a table, `intro` is the whole text.
    intro, table, facts = (*_TABLE.split(statement_text, maxsplit=1), "", "")[:3]
    shows_problem = request.sheet in PROBLEM_SHEETS
    # In an exam, the working space depends on the length of the solution.
    solutions_by_part = write_solutions(problem) if request.has_solutions or request.sheet == "exam" else {}
    figure = draw_arm(problem, f"p{number}") if shows_problem else None
    parts = (
        _make_sheet_part(request, f"{number}.{index}", problem, part, solutions_by_part.get(part.name, ""))
        for index, part in enumerate(problem.parts, 1)
    )
    return SheetProblem(number, problem.title, intro, table, facts, figure, tuple(parts))


def _make_sheet_part(request: ExportRequest, label: str, problem: Problem, part: Part, solution: str) -> SheetPart:
    shows_problem, shows_solutions = request.sheet in PROBLEM_SHEETS, request.has_solutions
    is_exam = request.sheet == "exam" and not shows_solutions
    gives_hints = request.sheet == "handout" and not shows_solutions and request.assignment.hints
    text = remove_typing_remarks(write_prompt(problem, part), problem)
    figure_name = f"p{label.replace('.', '-')}"
    figure = draw_prompt_figure(problem, part, figure_name) if shows_problem else None
    width_share = WIDTH_BESIDE_FIGURE if figure and not part.details.has_drawn_options else 1.0
    options = arrange_options(problem, part, width_share) if shows_problem else None
    hints = write_hints(problem, part) if gives_hints else ()
    return SheetPart(
        label, question_of(part).make_title(problem.chain), write_points(part.points), part.points,
        prompt=text if options is None else remove_options(text),
        hints=tuple(remove_typing_remarks(hint, problem) for hint in hints), figure=figure, options=options,
        box=make_box(problem, part, solution) if is_exam else None,
        solution=remove_typing_remarks(solution, problem) if shows_solutions else "",
        solution_figure=draw_solution_figure(problem, part, f"{figure_name}-solution") if shows_solutions else None,
        answer=write_short_answer(problem, part) if request.sheet == "key" else "", has_score_space=is_exam,
        has_wide_figure=part.details.has_drawn_options,
        marking=explain_marking(problem, part, request.compute_earned_share) if request.sheet == "marking" else None,
    )  # fmt: skip
