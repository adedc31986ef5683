"""Define the plain shapes of a figure (pixels, y down) and the lettering of symbols, lengths and angles."""

import re
from dataclasses import dataclass
from functools import lru_cache

import sympy as sp

Pair = tuple[float, float]
"""The x and y of a point, a direction or a size in pixels."""
Box = tuple[float, float, float, float]
"""Left, top, right, bottom."""
FONT = 15.0
"""Size of lettering in pixels."""
LOW = {"ω": 1.25}
"""Magnification of letters that name an axis and look too small in the fonts of PDFs."""
SUB = 0.72
"""Size of a subscript relative to its letter."""
GREEK = {
    "theta": "θ", "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "phi": "φ", "psi": "ψ",
    "lambda": "λ", "lamda": "λ", "rho": "ρ", "omega": "ω", "eta": "η", "mu": "μ",
}  # fmt: skip


@dataclass(frozen=True)
class Polyline:
    """A line through `points`, or a filled polygon if `closed`; `style` is a style of the template."""

    points: tuple[Pair, ...]
    style: str
    closed: bool = False


@dataclass(frozen=True)
class Circle:
    """A circle, radius in pixels."""

    center: Pair
    radius: float
    style: str


@dataclass(frozen=True)
class Glyph:
    """The drawing of joint `number`, of kind "R" or "P"."""

    number: int
    kind: str
    shapes: tuple[Polyline | Circle, ...]


@dataclass(frozen=True)
class Run:
    """A piece of lettering in one font; `dy` shifts its baseline from that of the previous piece, in pixels."""

    text: str
    italic: bool
    size: float
    dy: float


@dataclass(frozen=True)
class Text:
    """Lettering centred on `x` with its baseline at `y`.

    `box` is an upper estimate of the space that it takes. `at` is a point of the thing that it names.
    """

    x: float
    y: float
    runs: tuple[Run, ...]
    style: str
    box: Box
    at: Pair


Shape = Polyline | Circle | Glyph


def move_shape(shape: Shape, by: Pair) -> Shape:
    """Return the shape shifted by a vector."""
    if isinstance(shape, Glyph):
        return Glyph(shape.number, shape.kind, tuple(_move_outline(inner, by) for inner in shape.shapes))
    return _move_outline(shape, by)


def _move_outline(shape: Polyline | Circle, by: Pair) -> Polyline | Circle:
    if isinstance(shape, Circle):
        return Circle(shift_points((shape.center,), by)[0], shape.radius, shape.style)
    return Polyline(shift_points(shape.points, by), shape.style, shape.closed)


def shift_points(points: tuple[Pair, ...], by: Pair) -> tuple[Pair, ...]:
    """Return the points shifted by a vector."""
    dx, dy = by
    return tuple([(x + dx, y + dy) for x, y in points])


@dataclass(frozen=True)
class Figure:
    """Shapes from back to front, with the lettering on top, in a box of width x height pixels."""

    width: int
    height: int
    shapes: tuple[Shape, ...]
    texts: tuple[Text, ...]

    @property
    def inner(self) -> tuple[int, int]:
        """Width and height of the frame, half a pixel inside."""
        return self.width - 1, self.height - 1


TextRun = tuple[str, bool, bool]
"""Text, whether it is italic, whether it is a subscript."""


def roman(text: str) -> tuple[TextRun, ...]:
    """Return upright lettering."""
    return ((text, False, False),)


def symbol(letter: str, index: str = "") -> tuple[TextRun, ...]:
    """Return an italic letter with an upright subscript."""
    sub: tuple[TextRun, ...] = ((index, index.isalpha(), True),) if index else ()
    return ((letter, True, False), *sub)


def symbol_lettering(name: str) -> tuple[TextRun, ...]:
    """Return the lettering of a symbol with a name such as "a1", "theta2", "b_x" or "h"."""
    match = re.fullmatch(r"([A-Za-z]+?)_?(\d+|(?<=_)\w+)?", name)
    letter, index = (match[1], match[2] or "") if match else (name, "")
    return symbol(GREEK.get(letter, letter), index)


def sign_and_lettering(expression: sp.Expr, angle: bool) -> tuple[str, tuple[TextRun, ...]]:
    """Return the sign ("+" or "−") and the lettering of the rest of a length (m) or an angle (rad)."""
    sign, size = ("−", -expression) if expression.could_extract_minus_sign() else ("+", expression)
    if size.is_number:
        return sign, roman(f"{decimal(size * 180 / sp.pi)}°" if angle else f"{decimal(size)} m")
    if isinstance(size, sp.Symbol):
        return sign, symbol_lettering(size.name)
    factor, rest = size.as_coeff_Mul()
    if isinstance(rest, sp.Symbol):
        return sign, (*roman(f"{decimal(factor)} "), *symbol_lettering(rest.name))
    if isinstance(size, sp.Add):
        pieces: tuple[TextRun, ...] = ()
        for number, term in enumerate(size.as_ordered_terms()):
            inner, letters = sign_and_lettering(term, angle)
            pieces += (*(roman(f" {inner} ") if number else roman("−") if inner == "−" else ()), *letters)
        return sign, pieces
    return sign, roman(str(size))


def decimal(number: sp.Expr) -> str:
    """Return a number with at most three decimals and no needless zeros."""
    text = f"{float(number):.3f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


@lru_cache(maxsize=4096)
def magnitude(expression: sp.Expr) -> tuple[TextRun, ...]:
    """Return the lettering of a length beside a drawn line, without its sign."""
    return sign_and_lettering(expression, angle=False)[1]


@lru_cache(maxsize=4096)
def with_offset(variable: sp.Symbol, offset: sp.Expr, angle: bool) -> tuple[TextRun, ...]:
    """Return the lettering of a joint variable plus its offset, as in θ1 + 30°."""
    if offset == 0:
        return symbol_lettering(variable.name)
    sign, rest = sign_and_lettering(offset, angle)
    return (*symbol_lettering(variable.name), *roman(f" {sign} "), *rest)


@lru_cache(maxsize=4096)
def runs(pieces: tuple[TextRun, ...], font: float = FONT) -> tuple[Run, ...]:
    """Return the runs of some lettering, with lowered and smaller subscripts."""
    font_runs, baseline_shift = [], 0.0
    for text, italic, sub in pieces:
        level = 0.24 * font if sub else 0.0
        font_runs.append(Run(text, italic, font * SUB if sub else font * LOW.get(text, 1.0), level - baseline_shift))
        baseline_shift = level
    return tuple(font_runs)


@lru_cache(maxsize=4096)
def extent(pieces: tuple[TextRun, ...], font: float = FONT) -> Pair:
    """Return an upper estimate of width and height (pixels) of some lettering in any serif font."""
    narrow_letters, wide_letters = set(" .,1iljt°"), set("mwMWOθ=+−ωφψ")
    width = 0.0
    for text, _, sub in pieces:
        for letter in text:
            share = 0.34 if letter in narrow_letters else 0.74 if letter in wide_letters else 0.56
            width += share * font * (SUB if sub else LOW.get(text, 1.0))
    return width + 2.0, font * 1.16


def one_decimal(value: float) -> str:
    """Return a number with one decimal, the same on every machine.

    >>> one_decimal(-0.04), one_decimal(12.25)
    ('0.0', '12.3')
    """
    text = f"{value + 1.37e-4:.1f}"  # the shift avoids exact ties, which machines might round differently
    return "0.0" if text == "-0.0" else text


def path(points: tuple[Pair, ...]) -> str:
    """Return points in SVG notation.

    >>> path(((1.0, 2.04), (-3.5, 0.0)))
    '1.0,2.0 -3.5,0.0'
    """
    return " ".join([f"{one_decimal(x)},{one_decimal(y)}" for x, y in points])
