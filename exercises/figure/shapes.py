"""Define the plain shapes of a figure (pixels, y down) and the lettering of symbols, lengths and angles."""

import re
from dataclasses import dataclass
from functools import lru_cache

import sympy as sp

Vector2D = tuple[float, float]
"""The x and y of a point, a direction or a size in pixels."""
Box = tuple[float, float, float, float]
"""Left, top, right, bottom."""
FONT_SIZE = 15.0
"""Size of lettering in pixels."""
SMALL_LETTER_SCALE = {"ω": 1.25}
"""Magnification of letters that name an axis and look too small in the fonts of PDFs."""
SUBSCRIPT_SCALE = 0.72
"""Size of a subscript relative to its letter."""
GREEK_LETTERS = {
    "theta": "θ", "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "phi": "φ", "psi": "ψ",
    "lambda": "λ", "lamda": "λ", "rho": "ρ", "omega": "ω", "eta": "η", "mu": "μ",
}  # fmt: skip


@dataclass(frozen=True)
class Polyline:
    """A line through `points`, or a filled polygon if `closed`; `style` is a style of the template."""

    points: tuple[Vector2D, ...]
    style: str
    closed: bool = False


@dataclass(frozen=True)
class Circle:
    """A circle, radius in pixels."""

    center: Vector2D
    radius: float
    style: str


@dataclass(frozen=True)
class Glyph:
    """The drawing of joint `number`, of kind "R" or "P"."""

    number: int
    kind: str
    shapes: tuple[Polyline | Circle, ...]


@dataclass(frozen=True)
class FontRun:
    """A piece of lettering in one font; `dy` shifts its baseline from that of the previous piece, in pixels."""

    text: str
    italic: bool
    size: float
    dy: float


@dataclass(frozen=True)
class Text:
    """Lettering centred on `x` with its baseline at `y`.

    `box` is an upper estimate of the space that it takes. `named_point` is a point of the thing that it names.
    """

    x: float
    y: float
    runs: tuple[FontRun, ...]
    style: str
    box: Box
    named_point: Vector2D


Shape = Polyline | Circle | Glyph


def shift_shape(shape: Shape, vector: Vector2D) -> Shape:
    """Return the shape shifted by a vector."""
    if isinstance(shape, Glyph):
        return Glyph(shape.number, shape.kind, tuple(_shift_outline(inner, vector) for inner in shape.shapes))
    return _shift_outline(shape, vector)


def _shift_outline(shape: Polyline | Circle, vector: Vector2D) -> Polyline | Circle:
    if isinstance(shape, Circle):
        return Circle(shift_points((shape.center,), vector)[0], shape.radius, shape.style)
    return Polyline(shift_points(shape.points, vector), shape.style, shape.closed)


def shift_points(points: tuple[Vector2D, ...], vector: Vector2D) -> tuple[Vector2D, ...]:
    """Return the points shifted by a vector."""
    dx, dy = vector
    return tuple([(x + dx, y + dy) for x, y in points])


@dataclass(frozen=True)
class Figure:
    """Shapes from back to front, with the lettering on top, in a box of width x height pixels."""

    width: int
    height: int
    shapes: tuple[Shape, ...]
    texts: tuple[Text, ...]

    @property
    def frame_size(self) -> tuple[int, int]:
        """Width and height of the frame, half a pixel inside."""
        return self.width - 1, self.height - 1


TextRun = tuple[str, bool, bool]
"""Text, whether it is italic, whether it is a subscript."""


def upright_lettering(text: str) -> tuple[TextRun, ...]:
    """Return upright lettering."""
    return ((text, False, False),)


def indexed_lettering(letter: str, index: str = "") -> tuple[TextRun, ...]:
    """Return an italic letter with an upright subscript."""
    sub: tuple[TextRun, ...] = ((index, index.isalpha(), True),) if index else ()
    return ((letter, True, False), *sub)


def symbol_lettering(name: str) -> tuple[TextRun, ...]:
    """Return the lettering of a symbol with a name such as "a1", "theta2", "b_x" or "h"."""
    match = re.fullmatch(r"([A-Za-z]+?)_?(\d+|(?<=_)\w+)?", name)
    letter, index = (match[1], match[2] or "") if match else (name, "")
    return indexed_lettering(GREEK_LETTERS.get(letter, letter), index)


def sign_and_lettering(expression: sp.Expr, is_angle: bool) -> tuple[str, tuple[TextRun, ...]]:
    """Return the sign ("+" or "−") and the lettering of the rest of a length (m) or an angle (rad)."""
    sign, size = ("−", -expression) if expression.could_extract_minus_sign() else ("+", expression)
    if size.is_number:
        return sign, upright_lettering(
            f"{format_decimal(size * 180 / sp.pi)}°" if is_angle else f"{format_decimal(size)} m"
        )
    if isinstance(size, sp.Symbol):
        return sign, symbol_lettering(size.name)
    factor, rest = size.as_coeff_Mul()
    if isinstance(rest, sp.Symbol):
        return sign, (*upright_lettering(f"{format_decimal(factor)} "), *symbol_lettering(rest.name))
    if isinstance(size, sp.Add):
        pieces: tuple[TextRun, ...] = ()
        for number, term in enumerate(size.as_ordered_terms()):
            inner, letters = sign_and_lettering(term, is_angle)
            pieces += (
                *(upright_lettering(f" {inner} ") if number else upright_lettering("−") if inner == "−" else ()),
                *letters,
            )
        return sign, pieces
    return sign, upright_lettering(str(size))


def format_decimal(number: sp.Expr) -> str:
    """Return a number with at most three decimals and no needless zeros."""
    text = f"{float(number):.3f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


@lru_cache(maxsize=4096)
def length_lettering(expression: sp.Expr) -> tuple[TextRun, ...]:
    """Return the lettering of a length beside a drawn line, without its sign."""
    return sign_and_lettering(expression, is_angle=False)[1]


@lru_cache(maxsize=4096)
def joint_lettering(variable: sp.Symbol, offset: sp.Expr, is_angle: bool) -> tuple[TextRun, ...]:
    """Return the lettering of a joint variable plus its offset, as in θ1 + 30°."""
    if offset == 0:
        return symbol_lettering(variable.name)
    sign, rest = sign_and_lettering(offset, is_angle)
    return (*symbol_lettering(variable.name), *upright_lettering(f" {sign} "), *rest)


@lru_cache(maxsize=4096)
def make_font_runs(pieces: tuple[TextRun, ...], font: float = FONT_SIZE) -> tuple[FontRun, ...]:
    """Return the runs of some lettering, with lowered and smaller subscripts."""
    font_runs, baseline_shift = [], 0.0
    for text, italic, sub in pieces:
        level = 0.24 * font if sub else 0.0
        font_runs.append(
            FontRun(
                text,
                italic,
                font * SUBSCRIPT_SCALE if sub else font * SMALL_LETTER_SCALE.get(text, 1.0),
                level - baseline_shift,
            )
        )
        baseline_shift = level
    return tuple(font_runs)


@lru_cache(maxsize=4096)
def lettering_size(pieces: tuple[TextRun, ...], font: float = FONT_SIZE) -> Vector2D:
    """Return an upper estimate of width and height (pixels) of some lettering in any serif font."""
    narrow_letters, wide_letters = set(" .,1iljt°"), set("mwMWOθ=+−ωφψ")
    width = 0.0
    for text, _, sub in pieces:
        for letter in text:
            share = 0.34 if letter in narrow_letters else 0.74 if letter in wide_letters else 0.56
            width += share * font * (SUBSCRIPT_SCALE if sub else SMALL_LETTER_SCALE.get(text, 1.0))
    return width + 2.0, font * 1.16


def one_decimal(value: float) -> str:
    """Return a number with one decimal, the same on every machine.

    >>> one_decimal(-0.04), one_decimal(12.25)
    ('0.0', '12.3')
    """
    text = f"{value + 1.37e-4:.1f}"  # the shift avoids exact ties, which machines might round differently
    return "0.0" if text == "-0.0" else text


def format_svg_points(points: tuple[Vector2D, ...]) -> str:
    """Return points in SVG notation.

    >>> format_svg_points(((1.0, 2.04), (-3.5, 0.0)))
    '1.0,2.0 -3.5,0.0'
    """
    return " ".join([f"{one_decimal(x)},{one_decimal(y)}" for x, y in points])
