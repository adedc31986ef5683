"""Lay out answer boxes on paper: boxes to tick, lines with units, cells for entries, and working space."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from qdot.exercises import reference_answers
from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.reference_answers import LETTERS, TRUE_FALSE, Number
from qdot.exercises.short_questions.options import Options
from qdot.exercises.writing.latex import tex
from qdot.exercises.writing.line_breaking import estimate_width
from qdot.exercises.writing.problem_texts import name_entries, write_option
from qdot.exercises.writing.units import format_unit

ROW_HEIGHT, LINE_HEIGHT = 8, 4
"""Height of a row of a box, and of each further line of an entry, in mm."""
TEXT_HEIGHT, FRAME_HEIGHT = 45, 5
"""Height of a box for an answer in words, and of a box's frame and heading, in mm."""
BOX_WIDTH = 165
"""Approximate width of a box in mm."""
HANDWRITING_WIDTH = 4.8
"""Width in mm of a handwritten formula for each em of its printed width."""
MIN_WORKING_SPACE, WORKING_SPACE_PER_CHARACTER, MAX_WORKING_SPACE = 8, 0.014, 40
"""Working space in mm: its minimum, its increase for each character of the worked solution, and its maximum."""
MIN_SHARE, PACKED_SHARE = 0.65, 0.25
"""Minimum share of the working space that a box keeps on a long sheet.

The second one is for layouts in which the boxes on a page also divide the page's free space among them.
"""
WORKING_SPACE_STEP = 5
"""Working space is a multiple of this many mm, so that students can't infer the length of the solution."""
LINE_WIDTH, CHARACTER_WIDTH = 39.0, 0.46
"""Width of a line of options, and of a character of prose, in em."""
TICK_WIDTH = 2.2
"""Width of an option's tick box and its letter with the space around both, in em."""

_SINGLE_ENTRY_MATRIX = re.compile(r"^\$\\begin\{bmatrix\} ([^&\\]*(?:\\(?!\\)[^&\\]*)*) \\end\{bmatrix\}\$$")
"""Matches a matrix with a single entry, which is printed as a formula without brackets."""


@dataclass(frozen=True)
class AnswerBox:
    """A box for an answer: blank space for working, then rows of cells.

    The space is `working_space` mm high. In a layout in which the boxes on a page divide its free space, the space is
    `min_working_space` mm plus a part of the free space in proportion to `working_space`. If `holds_letters`, there is
    one cell for each letter instead of rows. `row_height` is the height of a row in mm. `labels` (LaTeX) are printed
    before numbers or above letters, and `units` are printed after numbers.
    """

    working_space: int
    rows: int = 1
    columns: int = 1
    row_height: int = ROW_HEIGHT
    holds_letters: bool = False
    labels: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    min_working_space: int = 0

    @property
    def holds_numbers(self) -> bool:
        """Whether each row is a number with its unit. Several such rows are printed side by side."""
        return bool(self.units)

    @property
    def cells_per_row(self) -> int:
        """The number of cells side by side."""
        if not self.holds_numbers:
            return self.columns
        return 2 if self.rows == 4 else min(self.rows, 3)  # four numbers are in two rows of two

    @property
    def is_narrow(self) -> bool:
        """Whether the box fits beside a figure."""
        return self.holds_letters or (self.holds_numbers and self.rows == 1)

    @property
    def total_height(self) -> int:
        """Total height of the box in mm, including its frame and heading."""
        rows = math.ceil(self.rows / self.cells_per_row) if self.holds_numbers else self.rows
        return self.working_space + rows * self.row_height + FRAME_HEIGHT


@dataclass(frozen=True)
class PaperOption:
    """An option in Markdown, and the letter before the option; the letter is "" for true and false."""

    letter: str
    text: str


@dataclass(frozen=True)
class PaperOptions:
    """The options of a question on paper, laid out in a number of `columns`.

    If `has_tick_boxes`, each option has a box to tick; otherwise, students write letters into cells.
    """

    options: tuple[PaperOption, ...]
    columns: int = 1
    has_tick_boxes: bool = True


# --- options ---


def arrange_options(problem: Problem, part: Part, width_share: float = 1.0) -> PaperOptions | None:
    """Return the options of a part in as many columns as fit a share of the page's width; None without options."""
    answer = part.answer
    if not answer.offered_options:
        return None
    if answer.offered_options == TRUE_FALSE:
        return PaperOptions(tuple(PaperOption("", word) for word in TRUE_FALSE), columns=4)  # narrow: single words
    texts = [write_option(problem, part, index) for index in range(len(answer.offered_options))]
    if isinstance(part.details, Options):
        texts = [_SINGLE_ENTRY_MATRIX.sub(r"$\1$", text) for text in texts]
    max_width = max(map(_measure_width, texts)) + TICK_WIDTH
    width = width_share * LINE_WIDTH
    columns = max((count for count in (1, 2, 4) if count * max_width <= width and count <= len(texts)), default=1)
    options = part.details.offered_options if isinstance(part.details, Options) else ()
    has_tall_option = any(option.is_tall for option in options) or any(text.startswith(r"$\begin{") for text in texts)
    are_formulas = [re.fullmatch(r"\$[^$]*\$", text) is not None for text in texts]
    if has_tall_option or (max_width > width and all(are_formulas)):
        # a displayed formula can be made smaller or broken into lines
        texts = [f"${text}$" if is_formula else text for text, is_formula in zip(texts, are_formulas, strict=True)]
    paper_options = tuple(PaperOption(letter, text) for letter, text in zip(LETTERS, texts, strict=False))
    return PaperOptions(paper_options, columns, has_tick_boxes=not answer.matched_items)


def _measure_width(text: str) -> float:
    formula_widths = (estimate_width(parse_latex(latex)) for latex in re.findall(r"\$([^$]+)\$", text))
    return sum(formula_widths) + CHARACTER_WIDTH * len(re.sub(r"\$[^$]+\$", "", text))


# --- boxes ---


def compute_share_that_fits(boxes: Sequence[AnswerBox], fixed_height: int, page_height: int) -> float:
    """Return the share of these boxes' working space that fits on a sheet, but at least `MIN_SHARE`.

    `page_height` is the height of the sheet, and `fixed_height` is the height of everything that can't shrink, both in
    mm.
    """
    working_space = sum(box.working_space for box in boxes)
    return 1.0 if not working_space else min(1.0, max(MIN_SHARE, (page_height - fixed_height) / working_space))


def scale_working_space(box: AnswerBox, share: float) -> AnswerBox:
    """Return a box with a share of its working space; with share 1, `min_working_space` is all of the space."""
    min_working_space = box.working_space if share == 1 else round(PACKED_SHARE * box.working_space)
    return replace(box, working_space=round(share * box.working_space), min_working_space=min_working_space)


def compute_working_space(solution: str) -> int:
    """Return the working space in mm for a question with this worked solution."""
    space = MIN_WORKING_SPACE + WORKING_SPACE_PER_CHARACTER * len(solution)
    return min(MAX_WORKING_SPACE, WORKING_SPACE_STEP * round(space / WORKING_SPACE_STEP))


def make_box(problem: Problem, part: Part, solution: str = "") -> AnswerBox | None:
    """Return a box that fits the answer, with working space for its solution; None if students tick an option."""
    answer, working_space = part.answer, compute_working_space(solution)
    match answer:
        case reference_answers.Choice() | reference_answers.Selection():
            return None
        case reference_answers.Matching():
            labels = tuple(rf"\text{{{item}}}" for item in answer.items)
            return AnswerBox(0, columns=len(answer.items), holds_letters=True, labels=labels)
        case reference_answers.ConditionSet():
            # an even number, which does not reveal the number of components
            row_count = 2 * max(1, math.ceil(len(answer.components) / 2))
            return AnswerBox(working_space, row_count)
        case reference_answers.Words():
            return AnswerBox(MIN_WORKING_SPACE, row_height=TEXT_HEIGHT)
        case Number():
            labels, units = name_entries(problem, part), tuple(map(format_unit, answer.units))
            shown_labels = labels if len(labels) == len(units) else ()
            return AnswerBox(working_space, len(answer.reference), labels=shown_labels, units=units)
    rows, columns = answer.shape or (1, 1)
    entries = [] if answer.is_numeric else list(answer.as_matrix())
    max_width = max((estimate_width(parse_latex(tex(entry, problem.chain))) for entry in entries), default=0.0)
    line_count = max(1, min(3, math.ceil(HANDWRITING_WIDTH * max_width * columns / BOX_WIDTH)))
    # All cells are as high as the cell of the longest entry.
    return AnswerBox(working_space, rows, columns, ROW_HEIGHT + LINE_HEIGHT * (line_count - 1))
