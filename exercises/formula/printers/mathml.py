"""Print formulas as MathML, for browsers and other programs.

Chromium stretches brackets only if a mathematical font is installed, and doesn't align columns. For browsers,
therefore, the border of a table shows the brackets of a matrix, and a style aligns columns.
"""

from collections.abc import Callable, Sequence
from functools import cache, lru_cache
from html import escape
from itertools import cycle

from qdot.exercises.formula.layout import ACCENTS, COMMA, EMPTY, EQUALS, MINUS, PLUS, SPACES, SYMBOLS, Layout, Pieces

_CORNER = "linear-gradient(currentColor, currentColor) {} {} / 5px 1.5px"
_CORNERS = ", ".join(_CORNER.format(x, y) for x in ("0", "100%") for y in ("0", "100%"))
_BORDER = "border: solid currentColor; border-width: 0 1.5px; margin: 0 0.1em; padding: 0.15em 0.2em"
_BRACKET_STYLES = {
    "[]": f"{_BORDER}; background: {_CORNERS}; background-repeat: no-repeat",
    "()": f"{_BORDER}; border-radius: 0.8em",
    "||": _BORDER,
    "‖‖": "border: double currentColor; border-width: 0 5px; padding: 0.15em 0.2em",
}
_NAMESPACE = 'xmlns="http://www.w3.org/1998/Math/MathML"'
_SMALL_STYLE, _LARGE_STYLE = (f'<mstyle displaystyle="{size}" scriptlevel="0">' for size in ("false", "true"))
_BRACKET_TAG = '<mo stretchy="false">'
_THIN_SPACE = '<mspace width="0.17em" />'
_FENCE_TAG = '<mo stretchy="true" fence="true" form="{}fix"'
_NO_BREAK_SPACE = "&#x000A0;"
_TEXT_SPACE = f"<mtext>{_NO_BREAK_SPACE}</mtext>"
_FIXED_SIZE_BRACKETS = frozenset("(){}[]|‖⟨⟩⌊⌋⌈⌉")
"""Brackets whose size doesn't depend on what they enclose."""
_REPLACEMENTS = {"⋅": "·", "□": "◻"}
"""Characters of a layout that MathML replaces by other characters."""
_FUNCTIONS_WITH_BARE_ARGUMENT = tuple(Layout("function", name) for name in ("sin", "cos", "tan"))
_INVERSE_FUNCTIONS = tuple(Layout("function", name) for name in ("arcsin", "arccos", "arctan"))
_SPACED_FUNCTIONS = _FUNCTIONS_WITH_BARE_ARGUMENT + _INVERSE_FUNCTIONS
_FACTOR_ENDS, _BARE_ARGUMENT_STARTS = ("</mn>", "</mi>", "</msub>", "&#x00029;</mo>"), ("<mi>", "<msub>")
"""The last MathML of a factor before a function, and the first MathML of an argument without brackets after a function.
A space separates them from the name of the function.
"""
_PIECES_BEFORE_TERM = frozenset((Layout("sign", "("), COMMA, EQUALS, Layout("sign", ";")))
"""Pieces before a term; a plus or minus after one of them is the sign of a number."""


def print_mathml(formula: Layout, is_displayed: bool = False, percent: int = 100) -> str:
    r"""Return a formula as a MathML element for a browser; if `is_displayed`, the formula has a line of its own.

    `percent` is the size of the formula; a formula that is too wide for a page needs a smaller size.

    >>> from qdot.exercises.formula.latex import parse_latex
    >>> print_mathml(parse_latex("a_{1}"))
    '<math xmlns="http://www.w3.org/1998/Math/MathML" display="inline"><mrow><msub>...</msub></mrow></math>'
    """
    style = f' style="font-size: {percent}%"' if percent < 100 else ""
    return _get_printer(True, is_displayed).print_element(formula, style)


def print_plain_mathml(formula: Layout, is_displayed: bool = False) -> str:
    """Return a formula as MathML without the workarounds for browsers."""
    return _get_printer(False, is_displayed).print_element(formula)


def _escape_char(char: str) -> str:
    """Return a character in MathML."""
    shown_char = _REPLACEMENTS.get(char, char)
    needs_no_escape = shown_char.isascii() and (shown_char.isalnum() or shown_char in "[];")
    return shown_char if needs_no_escape else f"&#x{ord(shown_char):05X};"


class _Printer:
    """Prints layouts, with workarounds for browsers if `is_for_browser`; caches printed pieces.

    If `is_displayed`, a formula has a line of its own.
    """

    def __init__(self, is_for_browser: bool, is_displayed: bool) -> None:
        self.is_for_browser, self.is_displayed = is_for_browser, is_displayed
        self.print_piece = lru_cache(2048)(self.print_uncached)

    def print_element(self, formula: Layout, style: str = "") -> str:
        display = "block" if self.is_displayed else "inline"
        return f'<math{style} {_NAMESPACE} display="{display}">{self.print_group(formula)}</math>'

    def print_row(self, pieces: Pieces, opening: Layout = EMPTY) -> str:
        """Return pieces side by side; `opening` is the bracket before them."""
        printed_pieces = [self.print_piece(piece) for piece in pieces]
        if self.is_for_browser and any(piece.kind == "function" or piece in (PLUS, MINUS) for piece in pieces):
            printed_pieces = _add_spaces_and_signs((opening, *pieces, EMPTY), ["", *printed_pieces, ""])
        return "".join(printed_pieces)

    def print_group(self, piece: Layout) -> str:
        """Return a piece as a single element; only rows and matrices need an element around them."""
        if piece.kind not in ("row", "matrix"):
            return self.print_piece(piece)
        content = self.print_row(piece.inner) if piece.kind == "row" else self.print_matrix(piece)
        return f"<mrow>{content}</mrow>" if content else "<mrow />"

    def print_uncached(self, piece: Layout) -> str:
        kind, text, inner = piece
        if kind in _LEAVES:
            return _LEAVES[kind](text)
        if kind in ("fraction", "root", "accent"):
            templates = _TEMPLATES | _BROWSER_TEMPLATES if self.is_for_browser else _TEMPLATES
            return templates[text].format(*map(self.print_group, inner))
        if kind == "script":
            return self.print_script(*inner)
        if kind == "fenced":
            return self.print_fence(text, inner[0])
        if kind == "matrix":
            return self.print_matrix(piece)
        return self.print_aligned(piece) if kind == "aligned" else self.print_group(piece)

    def print_script(self, base: Layout, *scripts: Layout) -> str:
        subscript, superscript = ("" if part == EMPTY else self.print_group(part) for part in scripts)
        names = ("under", "over") if self.is_displayed and base.text in _SIGNS_WITH_LIMITS else ("sub", "sup")
        tag = f"m{names[0] if subscript else ''}{names[1] if superscript else ''}"
        return f"<{tag}>{self.print_group(base)}{subscript}{superscript}</{tag}>"

    def print_fence(self, brackets: str, inside: Layout) -> str:
        contents = (f">{_escape_char(sign)}</mo>" if sign != "." else " />" for sign in brackets)
        sides = zip(("pre", "post"), contents, strict=True)
        opening, closing = (_FENCE_TAG.format(side) + content for side, content in sides)
        return f"<mrow>{opening}{self.print_row(inside.inner, Layout('sign', brackets[0]))}{closing}</mrow>"

    def print_matrix(self, matrix: Layout) -> str:
        is_left_aligned = matrix.text == "{."
        cell_style = ' style="text-align: left; padding-right: 1em"' * (is_left_aligned and self.is_for_browser)
        cells = "".join(
            f"<mtr>{''.join(_make_cell(self.print_row(cell.inner), cell_style) for cell in row.inner)}</mtr>"
            for row in matrix.inner
        )
        if self.is_for_browser and matrix.text in _BRACKET_STYLES:
            return f'<mtable style="{_BRACKET_STYLES[matrix.text]}">{cells}</mtable>'
        opening, closing = (f"<mo>&#x{ord(sign):05X};</mo>" if sign != "." else "" for sign in matrix.text)
        alignment = ' columnalign="left"' * (is_left_aligned and not self.is_for_browser)
        return f"{opening}<mtable{alignment}>{cells}</mtable>{closing}"

    def print_aligned(self, table: Layout) -> str:
        padding = "1.1ex" if table.text else "0.5ex"
        style = ' style="text-align: {}; padding: {} {} {} 0"' if self.is_for_browser else ' columnalign="{}"'
        styles = [style.format(side, padding, gap, padding) for side, gap in (("right", "0.3em"), ("left", "1.5em"))]
        spaces = " ".join(("0em", "2em") * (max(len(cells.inner) for cells in table.inner) // 2))
        rows = ""
        for line in table.inner:
            cells = ("<mi />" * (k % 2) + self.print_row(cell.inner) for k, cell in enumerate(line.inner))
            rows += f"<mtr>{''.join(map(_make_cell, cells, cycle(styles)))}</mtr>"
        return f'<mtable displaystyle="true" rowspacing="3pt" columnspacing="{spaces}">{rows}</mtable>'


def _print_letters(text: str) -> str:
    if text == "det" or text in SYMBOLS["functions_with_limits"]:
        return f'<mo movablelimits="true">{text}</mo>'
    return f"<mi>{''.join(map(_escape_char, text))}</mi>"


_LEAVES: dict[str, Callable[[str], str]] = {
    **dict.fromkeys(("letter", "function"), _print_letters),
    "number": lambda text: f"<mn>{text}</mn>",
    "sign": lambda text: f"{_BRACKET_TAG if text in _FIXED_SIZE_BRACKETS else '<mo>'}{_escape_char(text)}</mo>",
    "text": lambda text: f"<mtext>{escape(text, quote=False).replace(' ', _NO_BREAK_SPACE)}</mtext>",
    "space": lambda text: f'<mspace width="{SPACES[text]:g}em" />' if text != " " else _TEXT_SPACE,
}
_TEMPLATES = {
    "frac": "<mfrac>{}{}</mfrac>", "tfrac": f"{_SMALL_STYLE}<mfrac>{{}}{{}}</mfrac></mstyle>",
    "dfrac": f"{_LARGE_STYLE}<mfrac>{{}}{{}}</mfrac></mstyle>", "sqrt": "<msqrt>{}</msqrt>",
    **{name: f"<mover>{{}}<mo>{_escape_char(accent.sign)}</mo></mover>" for name, accent in ACCENTS.items()},
    "underline": "<munder>{}<mo>_</mo></munder>",
}  # fmt: skip
"""Maps the LaTeX command of each fraction, root and accent to its MathML."""
_BROWSER_TEMPLATES = {
    **{name: _TEMPLATES[name].replace("<mover>", '<mover accent="true">') for name in ACCENTS},
    **{
        name: f'<mrow style="border-{side}: 1px solid; padding-{side}: 0.1em">{{}}</mrow>'
        for name, side in (("overline", "top"), ("underline", "bottom"))
    },
}
"""For browsers: accents close to their letters, and borders instead of lines above and below letters."""
_SIGNS_WITH_LIMITS = frozenset(("∑", "∏", *SYMBOLS["functions_with_limits"]))
"""Signs and functions whose scripts stand below and above them in a displayed formula."""


def _add_spaces_and_signs(pieces: Pieces, printed_pieces: Sequence[str]) -> list[str]:
    """Return the printed pieces with spaces around functions, and without a space after the sign of a number."""
    texts = list(printed_pieces)
    for k, piece in enumerate(pieces):
        if piece in (PLUS, MINUS) and pieces[k - 1] in _PIECES_BEFORE_TERM:
            texts[k] = printed_pieces[k].replace("<mo>", '<mo form="prefix">')
        elif piece in _SPACED_FUNCTIONS:
            may_have_bare_argument = piece in _FUNCTIONS_WITH_BARE_ARGUMENT and pieces[k + 1] not in _SPACED_FUNCTIONS
            has_bare_argument = may_have_bare_argument and printed_pieces[k + 1].startswith(_BARE_ARGUMENT_STARTS)
            space_before = _THIN_SPACE * printed_pieces[k - 1].endswith(_FACTOR_ENDS)
            texts[k] = space_before + printed_pieces[k] + _THIN_SPACE * has_bare_argument
    return texts


def _make_cell(content: str, style: str = "") -> str:
    return f"<mtd{style}>{content}</mtd>" if content else f"<mtd{style} />"


_get_printer = cache(_Printer)
