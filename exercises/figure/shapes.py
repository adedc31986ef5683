"""Define the plain shapes of a figure, in pixels, y down."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from qdot.exercises.figure.lettering import FontRun

Vector2D = tuple[float, float]
"""The x and y of a point, a direction or a size in pixels."""
Box = tuple[float, float, float, float]
"""Left, top, right, bottom."""


@dataclass(frozen=True)
class Polyline:
    """A line through `points`, or a filled polygon if `is_closed`; `style` is the name of a style in the template."""

    points: tuple[Vector2D, ...]
    style: str
    is_closed: bool = False


@dataclass(frozen=True)
class Circle:
    """A circle; its centre and radius are in pixels."""

    center: Vector2D
    radius: float
    style: str


@dataclass(frozen=True)
class Glyph:
    """The symbol of joint `number`, which is of kind "R" or "P"."""

    number: int
    kind: str
    shapes: tuple[Polyline | Circle, ...]


@dataclass(frozen=True)
class Text:
    """Lettering centred on `x` with its baseline at `y`.

    `box` is an upper estimate of the space that the text takes. `named_point` is a point of the object that the text
    names.
    """

    x: float
    y: float
    runs: tuple[FontRun, ...]
    style: str
    box: Box
    named_point: Vector2D


Shape = Polyline | Circle | Glyph


def list_outlines(shapes: Iterable[Shape]) -> Iterator[Polyline | Circle]:
    """Yield the lines and circles that make up shapes."""
    for shape in shapes:
        yield from shape.shapes if isinstance(shape, Glyph) else (shape,)


def make_cross(center: Vector2D, half_size: float, style: str) -> tuple[Polyline, Polyline]:
    """Return the two strokes of a diagonal cross."""
    (x, y), d = center, half_size
    strokes = ((x - d, y - d), (x + d, y + d)), ((x - d, y + d), (x + d, y - d))
    return Polyline(strokes[0], style), Polyline(strokes[1], style)


@dataclass(frozen=True)
class Figure:
    """Shapes from back to front, with the lettering on top, in a box of width x height pixels."""

    width: int
    height: int
    shapes: tuple[Shape, ...]
    texts: tuple[Text, ...]


def format_one_decimal(value: float) -> str:
    """Return a number with one decimal, the same on every machine.

    >>> format_one_decimal(-0.04), format_one_decimal(12.25)
    ('0.0', '12.3')
    """
    text = f"{value + 1.37e-4:.1f}"  # the shift avoids exact ties, which machines might round differently
    return "0.0" if text == "-0.0" else text


def format_svg_points(points: tuple[Vector2D, ...]) -> str:
    """Return points in SVG notation.

    >>> format_svg_points(((1.0, 2.04), (-3.5, 0.0)))
    '1.0,2.0 -3.5,0.0'
    """
    return " ".join([f"{format_one_decimal(x)},{format_one_decimal(y)}" for x, y in points])
