r"""Vectors and matrices without commas: in lines, in columns with tabs or wide gaps, Matlab's [a b; c d], 0,5; 1,25.

What separates entries there may mean something else elsewhere (a sum goes on in the next line, a blank is a product):
this is looked at only where a text is of another shape than is due, and every row has the entries that are due.
"""

import re

from exercises.formula.notation import without_units
from exercises.formula.vocabulary import SPACES, VOCABULARY, pattern

_FRAME, _GAP, _BLANK = pattern("frame_of_table"), pattern("gap_of_table"), pattern("gap_of_matlab")
_GOES_ON, _MATLAB, _BETWEEN = pattern("line_goes_on"), pattern("rows_of_matlab"), pattern("between_numbers")
_NUMBER = pattern("decimal_with_comma")
_FACTORS = sorted({factor for factor in VOCABULARY["units"].values() if factor})
MOST = 4000
"""Characters of a table that is read."""


def table_text(text: str, shape: tuple[int, int]) -> str | None:
    r"""Return a table as the text of a list of rows; None for what is none of this shape.

    >>> table_text("a1\ta2\n0\t1", (2, 2)), table_text("[a1 -a2; 0 1]", (2, 2))
    ('[[a1, a2], [0, 1]]', '[[a1, -a2], [0, 1]]')
    >>> table_text("a1\n+ a2", (2, 1))
    """
    if len(text) > MOST:
        return None
    rows, columns = shape
    lines = [line for line in (_FRAME.sub("", line) for line in text.split("\n")) if line.strip(SPACES)]
    if len(lines) == rows > 1 and not any(_GOES_ON.match(line) for line in lines[1:]):
        cells = [_GAP.split(line.strip(SPACES)) for line in lines] if columns > 1 else [[line] for line in lines]
        if all(len(row) == columns and all(map(_is_whole, row)) for row in cells):
            return _listed(cells)
    matlab = _MATLAB.fullmatch(text.strip(SPACES))
    if matlab is not None:
        cells = [_BLANK.split(row.strip(SPACES)) for row in matlab.group(1).split(";") if row.strip(SPACES)]
        if columns == 1 and len(cells) == 1:
            cells = [[cell] for cell in cells[0]]
        if len(cells) == rows and all(len(row) == columns and all(map(_is_whole, row)) for row in cells):
            return _listed(cells)
    return None


def numbers_text(text: str, count: int) -> str | None:
    """Return numbers that are separated by more than a comma as the text of a list; None for what is none.

    >>> numbers_text("0,5; -1,25", 2), numbers_text("0,5, -1,25", 2), numbers_text("0,5,-1,25", 2)
    ('[0.5, -1.25]', '[0.5, -1.25]', None)
    """
    if count < 2 or len(text) > MOST:
        return None
    inner = without_units(text, frozenset()).strip(SPACES)
    if inner[:1] + inner[-1:] in ("()", "[]") or (inner[:1] + inner[-1:] == "{}" and ";" in inner):
        inner = inner[1:-1]
    entries = [entry.strip(SPACES) for entry in _BETWEEN.split(inner)]
    if len(entries) == count and all(map(_is_number, entries)):
        return f"[{', '.join(entry.replace(',', '.') for entry in entries)}]"
    return table_text(text, (count, 1))


def _is_number(entry: str) -> bool:
    """Tell whether a number stands there, alone or times what its unit is worth."""
    factors = (factor for factor in ("", *_FACTORS) if entry.endswith(factor))
    return any(_NUMBER.fullmatch(entry.removesuffix(factor)) for factor in factors)


def _listed(cells: list[list[str]]) -> str:
    rows = [", ".join(cell.strip(SPACES) for cell in row) for row in cells]
    return "[" + ", ".join(rows if len(cells[0]) == 1 else [f"[{row}]" for row in rows]) + "]"


def _is_whole(cell: str) -> bool:
    """Tell whether an entry holds no comma or semicolon, and as many brackets closed as open."""
    return not re.search("[,;=]", cell) and all(
        cell.count(one) == cell.count(other) for one, other in ("()", "[]", "{}")
    )
