"""Print formulas as text for a terminal: Greek letters, subscripts, matrices over several lines.

A formula is laid out in boxes of characters. A fraction stays on one line, as (a + b)/c.
"""

import re
import unicodedata
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

from qdot.exercises.formula.latex import PRIMES
from qdot.exercises.formula.layout import Layout, print_layout

_SUBSCRIPT_TABLE = str.maketrans("0123456789+-−()aehijklmnoprstuv", "₀₁₂₃₄₅₆₇₈₉₊₋₋₍₎ₐₑₕᵢⱼₖₗₘₙₒₚᵣₛₜᵤᵥ")
_SUPERSCRIPT_TABLE = str.maketrans("0123456789+-()*Tinjk−", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻⁽⁾*ᵀⁱⁿʲᵏ⁻")
_SPACED_SIGNS = {"+", "-", "−", "=", "≠", "≤", "≥", "≈", "∈", "×", "⋅", "→", "±"}
_BEFORE_SIGN_OF_NUMBER = {"", "(", "[", "=", "+", "-", "−", ",", "×", "⋅", "≠", "≤", "≥", "≈"}
_TALL_BRACKETS = {"[": "⎡⎢⎣", "]": "⎤⎥⎦", "(": "⎛⎜⎝", ")": "⎞⎟⎠"}


@dataclass(frozen=True)
class _Box:
    """Lines of equal width; `middle` is the index of the line that is aligned with neighbouring boxes."""

    lines: tuple[str, ...]
    middle: int = 0

    @property
    def width(self) -> int:
        return terminal_width(self.lines[0])

    @property
    def is_flat(self) -> bool:
        return len(self.lines) == 1


def terminal_width(text: str) -> int:
    """Return the number of columns of a text in a terminal; combining marks such as a dot over a letter have none."""
    return sum(not unicodedata.combining(ch) for ch in text)


def _one_line_box(text: str) -> _Box:
    return _Box((text,))


def _join_boxes(boxes: Sequence[_Box]) -> _Box:
    boxes = [box for box in boxes if box.lines[0]]
    if not boxes:
        return _one_line_box("")
    lines_above = max(box.middle for box in boxes)
    lines_below = max(len(box.lines) - box.middle for box in boxes)
    rows = []
    for row in range(-lines_above, lines_below):
        box_lines = (box.lines[box.middle + row] if 0 <= box.middle + row < len(box.lines) else None for box in boxes)
        rows.append("".join(" " * box.width if t is None else t for t, box in zip(box_lines, boxes, strict=True)))
    return _Box(tuple(rows), lines_above)


def _grid_box(rows: Sequence[Sequence[_Box]], is_aligned: bool) -> _Box:
    """Return the box of a matrix or, if `is_aligned`, of a column of equations, whose sides join without a gap."""
    columns = max(len(row) for row in rows)
    widths = [max((row[c].width for row in rows if c < len(row)), default=0) for c in range(columns)]
    lines: list[str] = []
    before_is_flat = True
    for row in rows:
        padded = []
        for c, box in enumerate(row):
            is_left_side = is_aligned and c % 2 == 0
            padding = _one_line_box(" " * (widths[c] - box.width))
            padded += [padding, box] if is_left_side else [box, padding]
            if c < columns - 1 and not is_left_side:
                padded.append(_one_line_box("  "))
        row_box = _join_boxes(padded)
        if is_aligned and lines and not (row_box.is_flat and before_is_flat):
            lines.append("")
        lines += row_box.lines
        before_is_flat = row_box.is_flat
    width = max(map(terminal_width, lines))
    return _Box(tuple(line + " " * (width - terminal_width(line)) for line in lines), (len(lines) - 1) // 2)


def _bracket_box(bracket: str, height: int) -> _Box:
    if height == 1 or bracket not in _TALL_BRACKETS:
        return _one_line_box(bracket)
    top, side, bottom = tuple(_TALL_BRACKETS[bracket])
    return _Box((top, *[side] * (height - 2), bottom), (height - 1) // 2)


def _print_script(piece: Layout, base: _Box, below: _Box, above: _Box) -> _Box:
    joined_box = base
    scripts = (below, _SUBSCRIPT_TABLE, "_"), (above, _SUPERSCRIPT_TABLE, "^")
    is_star = piece.inner[2].text == "*"  # the star of p* comes first
    for box, table, mark in scripts[::-1] if is_star else scripts:
        text = box.lines[0].replace(" ", "")
        if text == "∘":
            text = "°"
        elif not text or text[0] not in PRIMES:
            bracketed = text if len(text) == 1 else f"({text})"
            text = text.translate(table) if all(ord(char) in table for char in text) else mark + bracketed
        joined_box = _join_boxes([joined_box, _one_line_box(text)])
    return joined_box


def _print_fraction(_: Layout, above: _Box, below: _Box) -> _Box:
    texts = [box.lines[0].strip() for box in (above, below)]
    is_sum = [re.search(r" [-+−] |^[-−]", text) is not None for text in texts]
    is_sum[1] |= " " in texts[1]
    sides = (f"({text})" if brackets else text for text, brackets in zip(texts, is_sum, strict=True))
    return _one_line_box("/".join(sides))


def _print_root(_: Layout, inside: _Box) -> _Box:
    is_number = inside.is_flat and inside.lines[0].isdigit()
    return _join_boxes([_one_line_box("√"), inside] if is_number else [_one_line_box("√("), inside, _one_line_box(")")])


def _print_fenced(piece: Layout, inside: _Box) -> _Box:
    opening, closing = (Layout("sign", sign.strip(".")) for sign in piece.text)
    boxes = [_one_line_box(opening.text), inside, _one_line_box(closing.text)]
    return _print_row(Layout("row", inner=(opening, *piece.inner, closing)), *boxes)


def _print_table(piece: Layout, *_: _Box) -> _Box:
    cells = [[print_layout(cell, _PRINTERS) for cell in row.inner] for row in piece.inner]
    grid = _grid_box(cells, piece.kind == "aligned")
    if piece.kind == "aligned":
        return grid
    opening, closing = (_bracket_box(bracket, len(grid.lines)) for bracket in "[]")
    return _join_boxes([opening, grid, closing])


def _print_row(row: Layout, *parts: _Box) -> _Box:
    """Join the parts of a row, with spaces around signs and between factors, and with brackets of full height."""
    boxes: list[_Box] = []
    previous, is_function = "", False
    pieces = row.inner
    for index, (piece, box) in enumerate(zip(pieces, parts, strict=True)):
        text = box.lines[0]
        is_sign = piece.kind == "sign"
        may_need_space = piece.kind != "matrix" and (not is_sign or (text == "(" and not is_function))
        if boxes and may_need_space and _needs_space(previous, text):
            boxes.append(_one_line_box(" "))
        if index == 1 and pieces[0].kind == "space" and text in "+−":  # a sum that continues on a new line
            boxes.append(_one_line_box(f"{text} "))
        else:
            boxes.append(_sign_box(parts, index, previous) if is_sign else box)
        is_function = re.fullmatch(r"[a-z]{3,}2?|[A-Z]_.|[A-Z][ₐ-ₜ]", text) is not None
        index_before = piece.kind == "script" and not piece.inner[0].inner and not piece.inner[0].text  # as in ³J
        previous = "]" if len(box.lines) > 1 and not is_sign else "" if index_before else text.strip()[-1:]
    return _join_boxes(boxes)


def _sign_box(parts: Sequence[_Box], index: int, previous: str) -> _Box:
    """Return the box of a sign or bracket in a row, with its spaces or its height."""
    text = parts[index].lines[0]
    if text in _TALL_BRACKETS:
        inside = index + 1 if text in "([" else index - 1
        return _bracket_box(text, len(parts[inside].lines) if 0 <= inside < len(parts) else 1)
    if text in _SPACED_SIGNS and not (text in "-−+" and previous in _BEFORE_SIGN_OF_NUMBER):
        return _one_line_box(f" {text} ")
    return _one_line_box(", ") if text == "," and index < len(parts) - 1 else parts[index]


def _needs_space(previous: str, text: str) -> bool:
    return previous not in _BEFORE_SIGN_OF_NUMBER | set(" √-|∂/") and not text.startswith(tuple(" )],'/:"))


@lru_cache(maxsize=4096)
def unicode_text(formula: Layout) -> str:
    r"""Return a formula as text, on several lines if it contains a matrix.

    >>> from qdot.exercises.formula.latex import parse_latex
    >>> unicode_text(parse_latex(r"a_{1} c_{12} - \dot{\theta}_{2}"))
    'a₁ c₁₂ − θ̇₂'
    """
    return "\n".join(line.rstrip() for line in print_layout(formula, _PRINTERS).lines)


_PRINTERS: dict[str, Callable[..., _Box]] = {
    **dict.fromkeys(("letter", "number", "sign", "word", "text"), lambda piece: _one_line_box(piece.text)),
    "space": lambda _: _one_line_box(" "),
    "row": _print_row,
    "script": _print_script,
    "fraction": _print_fraction,
    "root": _print_root,
    "dotted": lambda _, inside: _join_boxes([inside, _one_line_box("\u0307")]),
    "fenced": _print_fenced,
    **dict.fromkeys(("matrix", "aligned"), _print_table),
}
