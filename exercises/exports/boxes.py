"""The layout of answer boxes on paper: boxes to tick, lines with units, cells for entries, and working space."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import sympy as sp

from qdot.exercises.answers import LETTERS, TRUE_FALSE, Choice, ConditionSet, Matching, Number, Selection
from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.quizzes import ASKED
from qdot.exercises.quizzes.options import Options
from qdot.exercises.writing.fit import width
from qdot.exercises.writing.latex import tex
from qdot.exercises.writing.problem_texts import option_text
from qdot.exercises.writing.short_answer import unit_text

ROW, LINE = 8, 4
"""Height of a row of a box, and of each further line of an entry, in mm."""
PAGE = 165
"""Approximate width of a box in mm."""
WRITTEN = 4.8
"""Width in mm of a handwritten formula for each em of its printed width."""
LEAST, PER_LETTER, MOST = 8, 0.014, 40
"""Working space in mm: the minimum, the increase per character of the worked solution, and the maximum."""
LEAST_SHARE, PACKED_SHARE = 0.65, 0.25
"""Minimum share of the working space that remains on a long sheet, and on a sheet that fills up its pages."""
STEP = 5
"""Working space is rounded to this many mm, so that it does not reveal how long the solution is."""
EM, PROSE = 39.0, 0.46
"""Width of a line of options, and of a character of prose, in em."""
TICK = 2.2
"""Width of an option's tick box, its letter and the space around them, in em."""


@dataclass(frozen=True)
class Box:
    """A box for an answer: `working` mm of space, then rows of cells, or one cell per letter if `letters`.

    If pages are filled up, the space is `packed` mm plus a share of the rest of the page, in proportion to `working`.
    `height` is the height of a row in mm. `labels` (LaTeX) are before numbers or above letters, `units` after numbers.
    """

    working: int
    rows: int = 1
    columns: int = 1
    height: int = ROW
    letters: bool = False
    labels: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    packed: int = 0

    @property
    def is_numbers(self) -> bool:
        """Whether each row is a number with its unit; several of these short lines fit side by side."""
        return bool(self.units)

    @property
    def cells_per_row(self) -> int:
        """The number of cells side by side."""
        return (2 if self.rows == 4 else min(self.rows, 3)) if self.is_numbers else self.columns

    @property
    def is_narrow(self) -> bool:
        """Whether it fits beside a figure."""
        return self.letters or (self.is_numbers and self.rows == 1)

    @property
    def room(self) -> int:
        """Total height in mm, with frame and heading."""
        rows = math.ceil(self.rows / self.cells_per_row) if self.is_numbers else self.rows
        return self.working + rows * self.height + 5


@dataclass(frozen=True)
class PaperOption:
    """An option in Markdown and the letter before it; the letter is empty for true and false."""

    letter: str
    text: str


@dataclass(frozen=True)
class PaperOptions:
    """Options in `columns`; each has a box to tick, unless letters are written into cells (`ticked` is False)."""

    offered: tuple[PaperOption, ...]
    columns: int = 1
    ticked: bool = True


# --- options ---


def options_of(problem: Problem, part: Part, share: float = 1.0) -> PaperOptions | None:
    """Return the options of a part, arranged to fit a share of the page's width; None if the part offers no options."""
    answer = part.answer
    if not answer.offered:
        return None
    if answer.offered == TRUE_FALSE:
        return PaperOptions(tuple(PaperOption("", word) for word in TRUE_FALSE), 4)
    texts = [option_text(problem, part, index) for index in range(len(answer.offered))]
    if isinstance(part.details, Options):
        texts = [
            re.sub(r"^\$\\begin\{bmatrix\} ([^&\\]*(?:\\(?!\\)[^&\\]*)*) \\end\{bmatrix\}\$$", r"$\1$", text)
            for text in texts
        ]
    max_width = max(map(_width, texts)) + TICK
    columns = max((count for count in (1, 2, 4) if count * max_width <= share * EM and count <= len(texts)), default=1)
    has_tall_option = isinstance(part.details, Options) and any(option.is_tall for option in part.details.offered)
    if (has_tall_option or max_width > share * EM) and all(re.fullmatch(r"\$[^$]*\$", text) for text in texts):
        texts = [f"${text}$" for text in texts]  # a block formula can be made smaller or broken into lines
    offered = tuple(PaperOption(letter, text) for letter, text in zip(LETTERS, texts, strict=False))
    return PaperOptions(offered, columns, ticked=not answer.matched)


def _width(text: str) -> float:
    formulas = re.findall(r"\$([^$]+)\$", text)
    return sum(width(parse_latex(latex)) for latex in formulas) + PROSE * len(re.sub(r"\$[^$]+\$", "", text))


# --- boxes ---


def share_that_fits(boxes: Sequence[Box], fixed: int, page: int) -> float:
    """Return the share of their working space that lets these boxes fit on a page, at least `LEAST_SHARE`.

    `fixed` is the height that can't shrink, in mm like all heights here.
    """
    working_space = sum(box.working for box in boxes)
    return 1.0 if not working_space else min(1.0, max(LEAST_SHARE, (page - fixed) / working_space))


def scale_working_room(box: Box, share: float) -> Box:
    """Return a box with a share of its working space. With share 1, it keeps all of it even if pages are filled up."""
    packed_space = box.working if share == 1 else round(PACKED_SHARE * box.working)
    return replace(box, working=round(share * box.working), packed=packed_space)


def working_room(solution: str) -> int:
    """Return the working space in mm for a question with this worked solution."""
    return min(MOST, STEP * round((LEAST + PER_LETTER * len(solution)) / STEP))


def box_of(problem: Problem, part: Part, solution: str = "") -> Box | None:
    """Return a box that fits the answer, with working space for its solution; None if students tick an option."""
    answer, working = part.answer, working_room(solution)
    match answer:
        case Choice() | Selection():
            return None
        case Matching():
            labels = tuple(rf"\text{{{item}}}" for item in answer.items)
            return Box(0, 1, len(answer.items), letters=True, labels=labels)
        case ConditionSet():
            return Box(working, max(2, math.ceil(len(answer.components) / 2) * 2))
        case Number():
            return _lines_of_numbers(problem, part, answer, working)
    rows, columns = answer.shape or (1, 1)
    entries = [] if answer.is_in_numbers else list(answer.as_matrix())
    max_width = max((width(parse_latex(tex(entry, problem.chain))) for entry in entries), default=0.0)
    line_count = max(1, min(3, math.ceil(WRITTEN * max_width * columns / PAGE)))
    return Box(working, rows, columns, ROW + LINE * (line_count - 1))  # all cells are as high as the longest entry


def _lines_of_numbers(problem: Problem, part: Part, answer: Number, working: int) -> Box:
    chain, question = problem.chain, ASKED[part.kind]
    typed_labels = (tex(sp.Symbol(name), chain) for name in question.labels(chain))
    labels = tuple(question.entry_names(chain, part) or typed_labels)
    units = tuple(map(unit_text, answer.units))
    rows, columns = answer.shape or (1, 1)
    return Box(working, rows * columns, 1, labels=labels if len(labels) == len(units) else (), units=units)
