r"""How a formula is laid out: one tree, whatever it was made from, and every notation is printed from it.

It is made from SymPy's expressions (`writing/latex`), from answers that students typed (`writing/typeset`) and from the
LaTeX of our templates (`formula/latex`). It says what stands where, and not what it means: s_{12} is a letter with an
index here.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple, TypeVar

Printed = TypeVar("Printed")

WORDS = (
    "sin", "cos", "tan", "cot", "sec", "csc", "arcsin", "arccos", "arctan", "sinh", "cosh", "tanh", "ln", "log", "exp",
    "det",
)  # fmt: skip
"""Names of functions that stand upright."""

SPACES = {",": 0.167, ":": 0.222, ";": 0.278, " ": 0.33, "quad": 1.0, "qquad": 2.0}
"""Room between pieces, by its LaTeX, in em."""


class Layout(NamedTuple):
    r"""A piece of a formula: of a `kind`, with `text` or made of `inner` pieces.

    letter, number, sign, word (a function's name), text: `text` is shown. space: `text` is a key of SPACES. row: pieces
    side by side; inside of a row, what stands in braces. script: base, what is below, what is above, these being EMPTY
    where there is nothing. fraction: above and below the line; `text` is frac, tfrac (small) or dfrac (large). root:
    what is below. dotted: what is below the dot. fenced: what is between brackets that grow with it;
    `text` holds the two, "." for none. matrix: `text` holds two brackets, `inner` rows of cells, all of them rows.
    aligned: the same without brackets; `text` is "apart" where the lines stand further apart.
    """

    kind: str
    text: str = ""
    inner: tuple["Layout", ...] = ()


Pieces = tuple[Layout, ...]
EMPTY = Layout("row")
DEGREE = Layout("sign", "∘")
MINUS, PLUS, EQUALS, COMMA, DOT = (Layout("sign", sign) for sign in "−+=,⋅")
THIN, QUAD, QQUAD = (Layout("space", name) for name in (",", "quad", "qquad"))
_OPENING = frozenset(Layout("sign", sign) for sign in "([{=≠<>≤≥≈∈×⋅→/,;")


def row(*pieces: Layout) -> Layout:
    """Return pieces side by side."""
    return Layout("row", inner=pieces)


def script(base: Layout, below: Layout = EMPTY, above: Layout = EMPTY) -> Layout:
    """Return a piece with an index and a power."""
    return Layout("script", inner=(base, below, above))


def fraction(above: Sequence[Layout], below: Sequence[Layout], small: bool = False) -> Layout:
    """Return a fraction, of the size of the text around it if `small`."""
    return Layout("fraction", "tfrac" if small else "frac", (row(*above), row(*below)))


def fence(brackets: str, inside: Sequence[Layout]) -> Layout:
    """Return pieces between brackets that grow with them."""
    return Layout("fenced", brackets, (row(*inside),))


def matrix(rows: Sequence[Sequence[Sequence[Layout]]]) -> Layout:
    """Return a matrix of entries in square brackets."""
    return Layout("matrix", "[]", tuple(row(*(row(*entry) for entry in cells)) for cells in rows))


def number(text: str) -> Pieces:
    """Return a number with its sign."""
    return (MINUS, Layout("number", text[1:])) if text[0] == "-" else (Layout("number", text),)


def scientific(digits: str, power: int) -> Pieces:
    """Return a number with a power of ten."""
    return (*number(digits), DOT, script(Layout("number", "10"), above=row(*number(str(power)))))


def raise_to(pieces: Pieces, above: Layout) -> Pieces:
    """Return pieces with a power at the last of them."""
    last = pieces[-1]
    foot, below, before = last.inner if last.kind == "script" else (last, EMPTY, EMPTY)
    return (*pieces[:-1], script(foot, below, row(*parts(before), *parts(above))))


def parts(piece: Layout) -> Pieces:
    """Return the pieces of a row; of anything else, that alone."""
    return piece.inner if piece.kind == "row" else (piece,)


def join(between: Sequence[Layout], listed: Iterable[Sequence[Layout]]) -> Pieces:
    """Return what is listed with the same pieces between any two."""
    parts = [piece for item in listed for piece in (*between, *item)]
    return tuple(parts[len(between) :])


def bracket(inside: Sequence[Layout], tall: frozenset[str]) -> Pieces:
    """Return pieces in brackets, which grow only if they contain a piece whose kind or text is in `tall`."""
    if _has(inside, tall):
        return (fence("()", inside),)
    return (Layout("sign", "("), *inside, Layout("sign", ")"))


def _has(pieces: Sequence[Layout], tall: frozenset[str]) -> bool:
    return any(piece.kind in tall or piece.text in tall or _has(piece.inner, tall) for piece in pieces)


def print_layout(piece: Layout, table: Mapping[str, Callable[..., Printed]]) -> Printed:
    """Print a formula: `table` has a function for each kind, of the piece and of its inner pieces as printed."""
    return table[piece.kind](piece, *(print_layout(part, table) for part in piece.inner))


def base(piece: Layout) -> Layout:
    """Return what an index or a power stands at; any other piece as it is."""
    return piece.inner[0] if piece.kind == "script" else piece


def is_binary(before: Layout | None) -> bool:
    """Return whether a plus or minus behind a piece joins two terms; if not, it belongs to the number behind it."""
    return before is not None and before not in _OPENING


def terms(pieces: Sequence[Layout], deepest: int = 0) -> list[Pieces]:
    """Return the terms of a sum, each but the first with the sign before it; those in brackets, too, to a depth."""
    starts, depth = [0], 0
    for index, piece in enumerate(pieces):
        depth += _deeper(piece)
        if index and depth <= deepest and piece in (PLUS, MINUS) and is_binary(pieces[index - 1]):
            starts.append(index)
    return [tuple(pieces[start:end]) for start, end in zip(starts, [*starts[1:], len(pieces)], strict=True)]


def split(pieces: Sequence[Layout], mark: Layout) -> list[Pieces]:
    """Return what stands between marks outside of all brackets."""
    rows: list[list[Layout]] = [[]]
    depth = 0
    for piece in pieces:
        depth += _deeper(piece)
        if piece == mark and not depth:
            rows.append([])
        else:
            rows[-1].append(piece)
    return [tuple(part) for part in rows]


def _deeper(piece: Layout) -> int:
    """Return by how much what follows a piece is deeper inside of brackets; the last one may have a power."""
    bracket = base(piece)
    return {"(": 1, ")": -1}.get(bracket.text, 0) if bracket.kind == "sign" else 0
