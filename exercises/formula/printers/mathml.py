"""Formulas as MathML, which browsers show without a script, and other programs read.

Chromium stretches brackets only where a mathematical font is installed, and aligns no columns; so for browsers brackets
around a matrix are drawn as its border, and alignment is written as a style.
"""

from collections.abc import Sequence
from functools import cache, lru_cache
from html import escape
from itertools import cycle

from qdot.exercises.formula.layout import COMMA, EMPTY, EQUALS, MINUS, PLUS, SPACES, Layout, Pieces

_CORNERS = ", ".join(
    f"linear-gradient(currentColor, currentColor) {x} {y} / 5px 1.5px" for x in ("0", "100%") for y in ("0", "100%")
)
_BRACKETS = (
    f"border: solid currentColor; border-width: 0 1.5px; padding: 0.15em 0.2em; background: {_CORNERS}; "
    "background-repeat: no-repeat"
)
_NAMESPACE = 'xmlns="http://www.w3.org/1998/Math/MathML"'
_SMALL, _LARGE = (f'<mstyle displaystyle="{size}" scriptlevel="0">' for size in ("false", "true"))
_BRACKET = '<mo stretchy="false">'
_THIN = '<mspace width="0.17em" />'
_FENCE = '<mo stretchy="true" fence="true" form="{}fix"'
_FIXED = frozenset("(){}[]|")
"""Brackets that do not grow with what is between them."""
_CHARS = {"⋅": "·", "□": "◻"}
_BARE = tuple(Layout("word", name) for name in ("sin", "cos", "tan"))
_SET_APART = (*_BARE, *(Layout("word", f"arc{one.text}") for one in _BARE))
_BEFORE, _BEHIND = ("</mn>", "</mi>", "</msub>", "&#x00029;</mo>"), ("<mi>", "<msub>")
"""What a function's name stands apart from: a factor before it, and its argument where that is in no brackets."""
_BEGINS_A_TERM = frozenset((Layout("sign", "("), COMMA, EQUALS, Layout("sign", ";")))
"""A sign behind these belongs to the number behind it."""


def mathml(formula: Layout, block: bool = False, percent: int = 100) -> str:
    r"""Return a formula as a MathML element for a browser; `block` is for one that stands on lines of its own.

    `percent` is its size, for one that is too wide for a page.

    >>> from qdot.exercises.formula.latex import parsed
    >>> mathml(parsed("a_{1}"))
    '<math xmlns="http://www.w3.org/1998/Math/MathML" display="inline"><mrow><msub>...</msub></mrow></math>'
    """
    style = f' style="font-size: {percent}%"' if percent < 100 else ""
    return _writer(True, block).element(formula, style)


def plain_mathml(formula: Layout, block: bool = False) -> str:
    """Return a formula as MathML without regard to what browsers make of it."""
    return _writer(False, block).element(formula)


def _char(char: str) -> str:
    char = _CHARS.get(char, char)
    return char if char.isascii() and (char.isalnum() or char in "[];") else f"&#x{ord(char):05X};"


class _Writer:
    """Writes layouts, on lines of their own if in a `block`, for browsers if it `mends`; pieces are kept."""

    def __init__(self, mends: bool, block: bool) -> None:
        self.mends, self.block = mends, block
        self.piece = lru_cache(2048)(self.made)

    def element(self, formula: Layout, style: str = "") -> str:
        display = "block" if self.block else "inline"
        return f'<math{style} {_NAMESPACE} display="{display}">{self.grouped(formula)}</math>'

    def row(self, pieces: Pieces, opening: Layout = EMPTY) -> str:
        """Return pieces side by side, behind an `opening` bracket."""
        shown = [self.piece(one) for one in pieces]
        if self.mends and any(one.kind == "word" or one in (PLUS, MINUS) for one in pieces):
            shown = _mended((opening, *pieces, EMPTY), ["", *shown, ""])
        return "".join(shown)

    def grouped(self, one: Layout) -> str:
        """Return a row as one thing, anything else as it is."""
        if one.kind not in ("row", "matrix"):
            return self.piece(one)
        shown = self.row(one.inner) if one.kind == "row" else self.matrix(one.inner)
        return f"<mrow>{shown}</mrow>" if shown else "<mrow />"

    def made(self, one: Layout) -> str:
        kind, text, inner = one
        if kind in ("letter", "word"):
            return '<mo movablelimits="true">det</mo>' if text == "det" else f"<mi>{''.join(map(_char, text))}</mi>"
        if kind == "number":
            return f"<mn>{text}</mn>"
        if kind == "sign":
            return f"{_BRACKET if text in _FIXED else '<mo>'}{_char(text)}</mo>"
        if kind == "text":
            return f"<mtext>{escape(text, quote=False).replace(' ', '&#x000A0;')}</mtext>"
        if kind == "space":
            return f'<mspace width="{SPACES[text]:g}em" />' if text != " " else "<mtext>&#x000A0;</mtext>"
        if kind == "script":
            return self.script(*inner)
        if kind == "fraction":
            shown = f"<mfrac>{''.join(map(self.grouped, inner))}</mfrac>"
            return shown if text == "frac" else f"{_SMALL if text == 'tfrac' else _LARGE}{shown}</mstyle>"
        if kind == "root":
            return f"<msqrt>{self.grouped(inner[0])}</msqrt>"
        if kind == "dotted":
            return f"<mover>{self.grouped(inner[0])}<mo>&#x002D9;</mo></mover>"
        if kind == "fenced":
            return self.fenced(text, inner[0])
        if kind == "matrix":
            return self.matrix(inner)
        return self.aligned(one) if kind == "aligned" else self.grouped(one)

    def script(self, base: Layout, *scripts: Layout) -> str:
        below, above = ("" if one == EMPTY else self.grouped(one) for one in scripts)
        names = ("under", "over") if self.block and base.text == "∑" else ("sub", "sup")
        tag = f"m{names[0] if below else ''}{names[1] if above else ''}"
        return f"<{tag}>{self.grouped(base)}{below}{above}</{tag}>"

    def fenced(self, brackets: str, inside: Layout) -> str:
        left, right = (
            f"{_FENCE.format(side)}{'>' + _char(sign) + '</mo>' if sign != '.' else ' />'}"
            for side, sign in zip(("pre", "post"), brackets, strict=True)
        )
        return f"<mrow>{left}{self.row(inside.inner, Layout('sign', brackets[0]))}{right}</mrow>"

    def matrix(self, rows: Pieces) -> str:
        cells = "".join(f"<mtr>{''.join(_cell('', self.row(cell.inner)) for cell in one.inner)}</mtr>" for one in rows)
        if self.mends:
            return f'<mtable style="{_BRACKETS}">{cells}</mtable>'
        return f"<mo>&#x0005B;</mo><mtable>{cells}</mtable><mo>&#x0005D;</mo>"

    def aligned(self, one: Layout) -> str:
        over = "1.1ex" if one.text else "0.5ex"
        style = ' style="text-align: {}; padding: {} {} {} 0"' if self.mends else ' columnalign="{}"'
        styles = [style.format(side, over, gap, over) for side, gap in (("right", "0.3em"), ("left", "1.5em"))]
        spaces = " ".join(("0em", "2em") * (max(len(cells.inner) for cells in one.inner) // 2))
        shown = ""
        for line in one.inner:
            cells = ("<mi />" * (k % 2) + self.row(cell.inner) for k, cell in enumerate(line.inner))
            shown += f"<mtr>{''.join(map(_cell, cycle(styles), cells))}</mtr>"
        return f'<mtable displaystyle="true" rowspacing="3pt" columnspacing="{spaces}">{shown}</mtable>'


def _mended(pieces: Pieces, shown: Sequence[str]) -> list[str]:
    """Return a row in which functions stand apart, and signs belong to what is behind them where a term begins."""
    mended = list(shown)
    for k, piece in enumerate(pieces):
        if piece in (PLUS, MINUS) and pieces[k - 1] in _BEGINS_A_TERM:
            mended[k] = shown[k].replace("<mo>", '<mo form="prefix">')
        elif piece in _SET_APART:
            is_bare = piece in _BARE and shown[k + 1].startswith(_BEHIND) and pieces[k + 1] not in _SET_APART
            mended[k] = f"{_THIN * shown[k - 1].endswith(_BEFORE)}{shown[k]}{_THIN * is_bare}"
    return mended


def _cell(style: str, shown: str) -> str:
    return f"<mtd{style}>{shown}</mtd>" if shown else f"<mtd{style} />"


_writer = cache(_Writer)
