r"""Define the layout of a formula: a tree of pieces, from which the formula is printed in every notation.

A layout is made from a SymPy expression (`writing/latex`), a typed answer (`writing/typeset`) or LaTeX
(`formula/latex`). It describes positions, not meanings: s_{12} is a letter with a subscript.
"""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

Printed = TypeVar("Printed")

SYMBOLS: dict[str, Any] = json.loads(Path(__file__).with_name("symbols.json").read_text(encoding="utf-8"))
"""The letters, signs and words of formulas, with their LaTeX commands and their words for screen readers."""

SPACES: dict[str, float] = SYMBOLS["spaces"]
"""Maps each LaTeX space to its width in em."""


class Accent(NamedTuple):
    """An accent: its combining character, its sign above a letter, its name in Typst, and its name in words."""

    combining_character: str
    sign: str
    typst_name: str
    words: str


ACCENTS = {command: Accent(*texts) for command, texts in SYMBOLS["accents"].items()}
"""Maps the LaTeX command of each accent to the accent."""


class Layout(NamedTuple):
    r"""A piece of a formula, with a `kind`, a `text` and `inner` pieces. These are the kinds:

    letter, number, sign, function (a function's name), text (upright): `text` is shown. space: `text` is a key of
    SPACES. row: `inner` pieces side by side; a row inside a row is a group in braces. script: base, subscript and
    superscript, which are EMPTY if there is none. fraction: numerator and denominator; `text` is frac, tfrac (small) or
    dfrac (large). root: the radicand. accent: the piece below the accent; `text` is a key of ACCENTS. fenced: a piece
    between two brackets of the same height; `text` holds the brackets, "." for a missing bracket. matrix: `text` holds
    two brackets, "." for a missing one; `inner` holds the rows, each a row of cells, which are rows themselves. With a
    left brace alone, it distinguishes cases. aligned: equations below each other, in rows of cells like a matrix;
    `text` is "apart" if there is extra space.
    """

    kind: str
    text: str = ""
    inner: tuple["Layout", ...] = ()


Pieces = tuple[Layout, ...]
EMPTY = Layout("row")
"""A row without pieces, as in a script without superscript."""
DEGREE = Layout("sign", "∘")
MINUS, PLUS, EQUALS, COMMA, DOT = (Layout("sign", sign) for sign in "−+=,⋅")
THIN, QUAD, QQUAD = (Layout("space", name) for name in (",", "quad", "qquad"))
_PIECES_BEFORE_NUMBER_SIGN = frozenset(Layout("sign", sign) for sign in "([{=≠<>≤≥≈∈×⋅→/,;")
"""Pieces after which a plus or minus is the sign of a number."""


def make_row(*pieces: Layout) -> Layout:
    """Return pieces side by side."""
    return Layout("row", inner=pieces)


def make_script(base: Layout, subscript: Layout = EMPTY, superscript: Layout = EMPTY) -> Layout:
    """Return a piece with a subscript and a superscript."""
    return Layout("script", inner=(base, subscript, superscript))


def make_fraction(numerator: Sequence[Layout], denominator: Sequence[Layout], is_small: bool = False) -> Layout:
    """Return a fraction; if `is_small`, a small fraction, as in running text."""
    return Layout("fraction", "tfrac" if is_small else "frac", (make_row(*numerator), make_row(*denominator)))


def make_fence(brackets: str, content: Sequence[Layout]) -> Layout:
    """Return pieces between brackets of the same height."""
    return Layout("fenced", brackets, (make_row(*content),))


def make_matrix(rows: Sequence[Sequence[Sequence[Layout]]], brackets: str = "[]") -> Layout:
    """Return a matrix of entries in brackets."""
    return Layout("matrix", brackets, tuple(make_row(*(make_row(*entry) for entry in cells)) for cells in rows))


def make_digits(text: str) -> Pieces:
    """Return the digits of a number, after its minus if it has one."""
    return (MINUS, Layout("number", text[1:])) if text[0] == "-" else (Layout("number", text),)


def make_scientific_number(digits: str, power: int) -> Pieces:
    """Return a number with a power of ten."""
    power_of_ten = make_script(Layout("number", "10"), superscript=make_row(*make_digits(str(power))))
    return (*make_digits(digits), DOT, power_of_ten)


def make_numeric_fraction(numerator: int, denominator: int) -> Layout:
    """Return a small fraction of two whole numbers."""
    return make_fraction(make_digits(str(numerator)), make_digits(str(denominator)), is_small=True)


def raise_pieces_to(pieces: Pieces, exponent: Layout) -> Pieces:
    """Return the pieces with a power added to the last one."""
    last_piece = pieces[-1]
    base_piece, subscript, power = last_piece.inner if last_piece.kind == "script" else (last_piece, EMPTY, EMPTY)
    new_power = make_row(*list_row_pieces(power), *list_row_pieces(exponent))
    return (*pieces[:-1], make_script(base_piece, subscript, new_power))


def list_row_pieces(piece: Layout) -> Pieces:
    """Return the pieces of a row, or a tuple with any other piece."""
    return piece.inner if piece.kind == "row" else (piece,)


def join_pieces(separator: Sequence[Layout], sequences: Iterable[Sequence[Layout]]) -> Pieces:
    """Join sequences of pieces, with `separator` between neighbouring ones."""
    pieces = [piece for sequence in sequences for piece in (*separator, *sequence)]
    return tuple(pieces[len(separator) :])


def bracket(content: Sequence[Layout], tall_kinds: frozenset[str]) -> Pieces:
    """Return pieces in brackets. The brackets are high if a piece inside has a kind or a text in `tall_kinds`."""
    if _contains_kind(content, tall_kinds):
        return (make_fence("()", content),)
    return (Layout("sign", "("), *content, Layout("sign", ")"))


def _contains_kind(pieces: Sequence[Layout], tall_kinds: frozenset[str]) -> bool:
    return any({piece.kind, piece.text} & tall_kinds or _contains_kind(piece.inner, tall_kinds) for piece in pieces)


def print_layout(piece: Layout, printers: Mapping[str, Callable[..., Printed]]) -> Printed:
    """Return a printed formula.

    `printers` has a function for each kind of piece. Its arguments are the piece and its printed inner pieces. For a
    matrix or aligned equations, they are the piece and a list of printed cells for each row.
    """
    if piece.kind in ("matrix", "aligned"):
        rows = ([print_layout(cell, printers) for cell in cells.inner] for cells in piece.inner)
        return printers[piece.kind](piece, *rows)
    return printers[piece.kind](piece, *(print_layout(part, printers) for part in piece.inner))


def get_script_base(piece: Layout) -> Layout:
    """Return the base of a script, or any other piece unchanged."""
    return piece.inner[0] if piece.kind == "script" else piece


def can_end_term(piece: Layout | None) -> bool:
    """Return whether a piece can end a term, so that a plus or minus after it is an operator, not a number's sign."""
    return piece is not None and piece not in _PIECES_BEFORE_NUMBER_SIGN


def split_terms(pieces: Sequence[Layout], max_depth: int = 0) -> list[Pieces]:
    """Return the terms of a sum, each with its sign; sums in at most `max_depth` nested brackets are split, too."""
    starts, depth = [0], 0
    for index, piece in enumerate(pieces):
        depth += _find_depth_change(piece)
        if index and depth <= max_depth and piece in (PLUS, MINUS) and can_end_term(pieces[index - 1]):
            starts.append(index)
    return [tuple(pieces[start:end]) for start, end in zip(starts, [*starts[1:], len(pieces)], strict=True)]


def split_at(pieces: Sequence[Layout], separator: Layout) -> list[Pieces]:
    """Split a sequence of pieces at each `separator` that is outside all brackets."""
    parts: list[list[Layout]] = [[]]
    depth = 0
    for piece in pieces:
        depth += _find_depth_change(piece)
        if piece == separator and not depth:
            parts.append([])
        else:
            parts[-1].append(piece)
    return list(map(tuple, parts))


def _find_depth_change(piece: Layout) -> int:
    """Return 1 for an opening bracket, -1 for a closing bracket (perhaps with a power), 0 for any other piece."""
    base = get_script_base(piece)
    return {"(": 1, ")": -1}.get(base.text, 0) if base.kind == "sign" else 0
