"""On which line of its file an answer stands: editors and code hosts show what is said of it there."""

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from qdot.exercises.problem.problem import variable
from qdot.grader.submissions.cells import Cell, Unreadable
from qdot.grader.submissions.submission import read_submission


def line_of_answer(path: Path, part: str) -> int:
    """Return the line of the statement that answers a part, in its own cell; of that cell, where none does.

    Prompts and checks speak of the answer, too, and mostly before it. The first line, where the file has no such cell.
    """
    try:
        cells, text = read_submission(path).cells, path.read_text(encoding="utf-8-sig")
    except (Unreadable, OSError, UnicodeDecodeError):
        return 1
    sets = re.compile(rf"(?m)^[ \t]*{re.escape(variable(*part.split('.', 1)))}\b[^\n=!<>]*=(?!=)")
    if text.lstrip()[:1] != "{":  # a script, or Markdown
        return max((_line_at(text, found) for found in sets.finditer(text)), default=1)
    own, placed = _own_cell(cells, part, sets), list(_placed_cells(text))
    if own is None or own >= len(placed):
        return 1
    within = [_line_at(cells[own].source, found) for found in sets.finditer(cells[own].source)]
    lines = placed[own].lines()
    return lines[within[-1] - 1] if within and within[-1] <= len(lines) else (lines or [placed[own].begins])[0]


def _line_at(text: str, found: re.Match[str]) -> int:
    return text.count("\n", 0, found.start()) + 1


def _own_cell(cells: Sequence[Cell], part: str, sets: re.Pattern[str]) -> int | None:
    """Return the cell that answers a part: of those that set its variable the one marked as its own, or the last."""
    marked = [index for index, cell in enumerate(cells) if cell.part == part]
    setting = [index for index, cell in enumerate(cells) if cell.is_code and sets.search(cell.source)]
    likely = [index for index in marked if index in setting] or setting or marked
    return likely[-1] if likely else None


# --- where a notebook's file has its cells: the JSON reader of Python tells no places ---


@dataclass(frozen=True)
class _Placed:
    """A cell that begins on this line of its file; the strings that its text is made of, each with its own line."""

    begins: int
    strings: list[tuple[str, int]] = field(default_factory=list)

    def lines(self) -> list[int]:
        """Return on which line of the file each line of the cell's text begins."""
        found, is_begun = list[int](), False
        for text, number in self.strings:
            for piece in re.findall(r"[^\n]*\n|[^\n]+", text):
                found += [] if is_begun else [number]
                is_begun = not piece.endswith("\n")
        return found


_LEXEME = re.compile(r'"[^"\\]*(?:\\.[^"\\]*)*"|[{}\[\],\n]')


def _placed_cells(text: str) -> Iterator[_Placed]:
    """Yield a notebook's cells in their order; `text` is known to be JSON.

    `path` is where in the notebook the scanner is: of each object the key, None before it is read; of each list the
    place in it.
    """
    path, number, cell = list[str | int | None](), 1, _Placed(1)
    for lexeme in map(re.Match.group, _LEXEME.finditer(text)):
        if lexeme == "\n":
            number += 1
        elif lexeme in "{[":
            if lexeme == "{" and _is_cell(path):
                cell = _Placed(number)
                yield cell
            path.append(None if lexeme == "{" else 0)
        elif lexeme in "}]":
            path.pop()
        elif lexeme == ",":
            path[-1] = path[-1] + 1 if isinstance(path[-1], int) else None
        elif path and path[-1] is None:
            path[-1] = json.loads(lexeme, strict=False)
        elif any(_is_cell(path[:end]) and path[end] in ("source", "input") for end in (2, 4) if len(path) > end):
            cell.strings.append((json.loads(lexeme, strict=False), number))


def _is_cell(path: Sequence[str | int | None]) -> bool:
    """Tell whether a cell is there: up to version 3 of the format, cells are on worksheets."""
    return path[-2:-1] == ["cells"] and (len(path) == 2 or (len(path) == 4 and path[0] == "worksheets"))
