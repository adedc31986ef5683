"""Print formulas as text for a terminal: Greek letters, subscripts, matrices over several lines.

A printed piece is a box of characters (SymPy's `stringPict`). All lines of a box have the same width. The baseline is
the index of the line that is aligned with neighbouring boxes. A fraction is printed on one line, as (a + b)/c.
"""

import re
from collections.abc import Callable, Sequence
from functools import lru_cache

from sympy.printing.pretty.pretty_symbology import line_width
from sympy.printing.pretty.stringpict import stringPict

from qdot.exercises.formula.latex import PRIMES
from qdot.exercises.formula.layout import ACCENTS, Layout, print_layout

_SUBSCRIPT_TABLE = str.maketrans("0123456789+-−()aehijklmnoprstuv", "₀₁₂₃₄₅₆₇₈₉₊₋₋₍₎ₐₑₕᵢⱼₖₗₘₙₒₚᵣₛₜᵤᵥ")
_SUPERSCRIPT_TABLE = str.maketrans("0123456789+-()*T⊤injk−", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻⁽⁾*ᵀᵀⁱⁿʲᵏ⁻")
_SPACED_SIGNS = {"-", *"+−=≠≤≥<>≪≫≈≡∼≃≅∝∈∉∋⊂⊆⊃⊇×⋅÷±∓⊕⊗⊙∧∨∪∩∖→⟶←↔⇒⟹⇐⇔⟺↦⊥∥∣"}
_SIGNS_BEFORE_NUMBER_SIGN = {"", "(", "[", "=", "+", "-", "−", ",", "×", "⋅", "≠", "≤", "≥", "≈"}
"""Signs after which a plus or minus is the sign of a number; "" is the start of a row."""
_NO_SPACE_AFTER, _NO_SPACE_BEFORE = _SIGNS_BEFORE_NUMBER_SIGN | _SPACED_SIGNS | set(" √|‖⟨⌊⌈∂∇∠¬/"), tuple(" )],'/:")
_TALL_BRACKETS = {
    "[": "⎡⎢⎣⎢", "]": "⎤⎥⎦⎥", "(": "⎛⎜⎝⎜", ")": "⎞⎟⎠⎟", "{": "⎧⎪⎩⎨", "}": "⎫⎪⎭⎬", "|": "││││", "‖": "‖‖‖‖",
}  # fmt: skip
"""For each bracket, the characters for its top, its side, its bottom and its middle."""

_LINES = ("overline", "underline")
"""Accents that extend over all characters below or above them."""


def _join(*boxes: stringPict | str) -> stringPict:
    """Return boxes or texts side by side, with aligned baselines."""
    return stringPict(*stringPict.next("", *boxes))


def _make_grid(rows: Sequence[Sequence[stringPict]], is_aligned: bool) -> stringPict:
    """Return the box of a matrix or, if `is_aligned`, of equations, with no gap between their sides."""
    column_count = max(map(len, rows))
    widths = [max(row[column].width() for row in rows if column < len(row)) for column in range(column_count)]
    lines: list[str] = []
    is_previous_flat = True
    for row in rows:
        padded_boxes: list[stringPict | str] = []
        for column, box in enumerate(row):
            is_left_side = is_aligned and column % 2 == 0
            padding = " " * (widths[column] - box.width())
            padded_boxes += [padding, box] if is_left_side else [box, padding]
            if column < column_count - 1 and not is_left_side:
                padded_boxes.append("  ")
        row_box = _join(*padded_boxes)
        is_flat = row_box.height() == 1
        if is_aligned and lines and not (is_flat and is_previous_flat):  # an empty line around tall equations
            lines.append("")
        lines += row_box.picture
        is_previous_flat = is_flat
    width = max(map(line_width, lines))
    padded_lines = (line + " " * (width - line_width(line)) for line in lines)
    return stringPict("\n".join(padded_lines), (len(lines) - 1) // 2)


def _make_bracket(bracket: str, height: int) -> stringPict:
    """Return the box of a bracket of a certain height."""
    if height == 1 or bracket not in _TALL_BRACKETS:
        return stringPict(bracket)
    top, side, bottom, middle = tuple(_TALL_BRACKETS[bracket])
    lines = [top, *[side] * (height - 2), bottom]
    if height > 2:
        lines[(height - 1) // 2] = middle
    return stringPict("\n".join(lines), (height - 1) // 2)


def _print_script(piece: Layout, base: stringPict, subscript: stringPict, superscript: stringPict) -> stringPict:
    """Return a base with scripts in small characters; a script without small characters comes after _ or ^."""
    texts = []
    for box, table, mark in (subscript, _SUBSCRIPT_TABLE, "_"), (superscript, _SUPERSCRIPT_TABLE, "^"):
        text = box.picture[0].replace(" ", "")
        if text == "∘":
            text = "°"
        elif text[:1] not in PRIMES:
            bracketed_text = text if len(text) == 1 else f"({text})"
            text = text.translate(table) if all(ord(char) in table for char in text) else mark + bracketed_text
        texts.append(text)
    return _join(base, *(reversed(texts) if piece.inner[2].text == "*" else texts))  # the star of p* comes first


def _print_fraction(_: Layout, numerator: stringPict, denominator: stringPict) -> stringPict:
    texts = [box.picture[0].strip() for box in (numerator, denominator)]
    needs_brackets = [re.search(r" [-+−] |^[-−]", text) is not None for text in texts]
    needs_brackets[1] |= " " in texts[1]
    sides = (f"({text})" if is_bracketed else text for text, is_bracketed in zip(texts, needs_brackets, strict=True))
    return stringPict("/".join(sides))


def _print_root(_: Layout, inside: stringPict) -> stringPict:
    is_number = inside.height() == 1 and inside.picture[0].isdigit()
    return _join("√", inside) if is_number else _join("√(", inside, ")")


def _print_accent(piece: Layout, inside: stringPict) -> stringPict:
    accent, text = ACCENTS[piece.text], inside.picture[0]
    if inside.height() > 1:
        return _join(f"{accent.words}(", inside, ")")
    mark = accent.combining_character
    return stringPict(re.sub(r"(\S)", rf"\1{mark}", text) if piece.text in _LINES else text + mark)


def _print_fenced(piece: Layout, inside: stringPict) -> stringPict:
    if inside.height() > 1:
        opening_box, closing_box = (_make_bracket(sign.strip("."), inside.height()) for sign in piece.text)
        return _join(opening_box, inside, closing_box)
    opening, closing = (Layout("sign", sign.strip(".")) for sign in piece.text)
    boxes = stringPict(opening.text), inside, stringPict(closing.text)
    return _print_row(Layout("row", inner=(opening, *piece.inner, closing)), *boxes)


def _print_table(piece: Layout, *rows: list[stringPict]) -> stringPict:
    grid = _make_grid(rows, piece.kind == "aligned")
    if piece.kind == "aligned":
        return grid
    opening, closing = (_make_bracket(sign.strip("."), grid.height()) for sign in piece.text)
    return _join(opening, grid, closing)


def _print_row(row: Layout, *parts: stringPict) -> stringPict:
    """Join the parts of a row, with spaces around signs and between factors, and with brackets of full height."""
    boxes: list[stringPict | str] = []
    char_before, is_function = "", False
    for index, (piece, box) in enumerate(zip(row.inner, parts, strict=True)):
        text = box.picture[0]
        is_sign = piece.kind == "sign"
        may_need_space = piece.kind != "matrix" and (not is_sign or (text == "(" and not is_function))
        if boxes and may_need_space and char_before not in _NO_SPACE_AFTER and not text.startswith(_NO_SPACE_BEFORE):
            boxes.append(" ")
        if index == 1 and row.inner[0].kind == "space" and text in "+−":  # a sum that continues on a new line
            boxes.append(f"{text} ")
        else:
            boxes.append(_print_sign(parts, index, char_before) if is_sign else box)
        # sin, atan2, R_z or Rₓ: the bracket that follows has no space before it
        is_function = re.fullmatch(r"[a-z]{3,}2?|[A-Z]_.|[A-Z][ₐ-ₜ]", text) is not None
        is_index_before = piece.kind == "script" and not piece.inner[0].inner and not piece.inner[0].text  # as in ³J
        if piece.kind == "text" and text.endswith(" "):
            char_before = " "
        elif box.height() > 1 and not is_sign:
            char_before = "]"  # a tall box is spaced like a matrix
        else:
            char_before = "" if is_index_before else text.strip()[-1:]
    return _join(*boxes)


def _print_sign(parts: Sequence[stringPict], index: int, char_before: str) -> stringPict | str:
    """Return a sign with the spaces around it, or a bracket as high as its content.

    `index` is the index of the sign among the parts of a row, and `char_before` is the last character before the sign.
    """
    text = parts[index].picture[0]
    if text in "()[]":
        inside = index + 1 if text in "([" else index - 1
        return _make_bracket(text, parts[inside].height() if 0 <= inside < len(parts) else 1)
    is_continued = index > 0 and parts[index - 1].picture == [""]  # as in {} + x, at the start of a continued line
    if is_continued and text in _SPACED_SIGNS:
        return f"{text} "
    if text in _SPACED_SIGNS and not (text in "-−+" and char_before in _SIGNS_BEFORE_NUMBER_SIGN):
        return f" {text} "
    return ", " if text == "," and index < len(parts) - 1 else text


@lru_cache(maxsize=4096)
def print_unicode(formula: Layout) -> str:
    r"""Return a formula as text, on several lines if it contains a matrix.

    >>> from qdot.exercises.formula.latex import parse_latex
    >>> print_unicode(parse_latex(r"a_{1} c_{12} - \dot{\theta}_{2}"))
    'a₁ c₁₂ − θ̇₂'
    """
    return "\n".join(line.rstrip() for line in print_layout(formula, _PRINTERS).picture)


_PRINTERS: dict[str, Callable[..., stringPict]] = {
    **dict.fromkeys(("letter", "number", "sign", "function", "text"), lambda piece: stringPict(piece.text)),
    "space": lambda piece: stringPict({"!": "", "quad": 4 * " "}.get(piece.text, " ")),
    "row": _print_row,
    "script": _print_script,
    "fraction": _print_fraction,
    "root": _print_root,
    "accent": _print_accent,
    "fenced": _print_fenced,
    **dict.fromkeys(("matrix", "aligned"), _print_table),
}
