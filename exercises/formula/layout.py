r"""The layout of a formula: a tree from which every notation is printed.

It is made from SymPy expressions (`writing/latex`), from typed answers (`writing/typeset`) and from the LaTeX of
qdot's templates (`formula/latex`). It describes positions, not meanings: s_{12} is a letter with an index here.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple, TypeVar

Printed = TypeVar("Printed")

WORDS = (
    "sin", "cos", "tan", "cot", "sec", "csc", "arcsin", "arccos", "arctan", "sinh", "cosh", "tanh", "ln", "log", "exp",
    "det",
)  # fmt: skip
"""Names of functions that are set upright."""

SPACES = {",": 0.167, ":": 0.222, ";": 0.278, " ": 0.33, "quad": 1.0, "qquad": 2.0}
"""The width of each LaTeX space, in em."""


class Layout(NamedTuple):
    r"""A piece of a formula: it has a `kind`, and a `text` or `inner` pieces. The kinds:

    letter, number, sign, word (a function's name), text: `text` is shown.
    space: `text` is a key of SPACES.
    row: `inner` pieces side by side; a row inside a row is a group in braces.
    script: base, subscript and superscript, which are EMPTY if there is none.
    fraction: numerator and denominator; `text` is frac, tfrac (small) or dfrac (large).
    root: the radicand. dotted: the piece below the dot.
    fenced: the piece between brackets that grow with it; `text` holds the two brackets, "." for none.
    matrix: `text` holds two brackets, `inner` the rows, each a row of cells that are rows.
    aligned: like a matrix, without brackets; `text` is "apart" if the lines have extra space between them.
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
    """Return a piece with a subscript and a superscript."""
    return Layout("script", inner=(base, below, above))


def fraction(above: Sequence[Layout], below: Sequence[Layout], small: bool = False) -> Layout:
    """Return a fraction; if `small`, it has the size of the surrounding text."""
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
    """Return the pieces with a power added to the last one."""
    last = pieces[-1]
    base_piece, below, power = last.inner if last.kind == "script" else (last, EMPTY, EMPTY)
    return (*pieces[:-1], script(base_piece, below, row(*parts(power), *parts(above))))


def parts(piece: Layout) -> Pieces:
    """Return the pieces of a row, or any other piece as the only one."""
    return piece.inner if piece.kind == "row" else (piece,)


def join(between: Sequence[Layout], listed: Iterable[Sequence[Layout]]) -> Pieces:
    """Return several sequences of pieces as one, with `between` between each two of them."""
    joined = [piece for item in listed for piece in (*between, *item)]
    return tuple(joined[len(between) :])


def bracket(inside: Sequence[Layout], tall: frozenset[str]) -> Pieces:
    """Return pieces in brackets; the brackets grow if they contain a piece whose kind or text is in `tall`."""
    if _has(inside, tall):
        return (fence("()", inside),)
    return (Layout("sign", "("), *inside, Layout("sign", ")"))


def _has(pieces: Sequence[Layout], tall: frozenset[str]) -> bool:
    return any(piece.kind in tall or piece.text in tall or _has(piece.inner, tall) for piece in pieces)


def print_layout(piece: Layout, table: Mapping[str, Callable[..., Printed]]) -> Printed:
    """Print a formula; `table` has a function for each kind, called with the piece and its printed inner pieces."""
    return table[piece.kind](piece, *(print_layout(part, table) for part in piece.inner))


def base(piece: Layout) -> Layout:
    """Return the base of a script, or any other piece unchanged."""
    return piece.inner[0] if piece.kind == "script" else piece


def is_binary(before: Layout | None) -> bool:
    """Return whether a plus or minus after a piece joins two terms; if not, it is the sign of the next number."""
    return before is not None and before not in _OPENING


def terms(pieces: Sequence[Layout], deepest: int = 0) -> list[Pieces]:
    """Return the terms of a sum, each with its sign; sums in brackets are split, too, up to the depth `deepest`."""
    starts, depth = [0], 0
    for index, piece in enumerate(pieces):
        depth += _deeper(piece)
        if index and depth <= deepest and piece in (PLUS, MINUS) and is_binary(pieces[index - 1]):
            starts.append(index)
    return [tuple(pieces[start:end]) for start, end in zip(starts, [*starts[1:], len(pieces)], strict=True)]


def split(pieces: Sequence[Layout], mark: Layout) -> list[Pieces]:
    """Return the pieces between the marks that are outside all brackets."""
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
    """Return the change of the bracket depth after a piece; a closing bracket may have a power."""
    bracket = base(piece)
    return {"(": 1, ")": -1}.get(bracket.text, 0) if bracket.kind == "sign" else 0
