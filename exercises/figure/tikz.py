"""Convert a figure's SVG to TikZ, so that LaTeX can draw it; only the elements in our figures are supported."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from qdot.exercises.formula.latex import LETTERS
from qdot.exercises.writing.markup import latex_escaped
from qdot.exercises.writing.render import render

POINTS = 0.565
"""Points (1/72.27 inch) per pixel."""
_GREEK = {char: name for name, char in LETTERS.items() if name != "square"}
_LOW = "₀₁₂₃₄₅₆₇₈₉"
_DIGITS = str.maketrans(_LOW, "0123456789")
_JOINS = {"stroke-linejoin": "line join", "stroke-linecap": "line cap"}


@dataclass(frozen=True)
class Stroke:
    """A line, a polygon, a circle or a rounded box with its TikZ options; in pixels, y down."""

    options: tuple[str, ...]
    points: tuple[tuple[float, float], ...]
    closed: bool = False
    radius: float = 0.0


@dataclass(frozen=True)
class Run:
    """Lettering in LaTeX, its size in points, and the points by which it is raised."""

    latex: str
    size: float
    raised: float


@dataclass(frozen=True)
class Lettering:
    """Runs on a line, centred, with the baseline at `point`."""

    point: tuple[float, float]
    colour: str
    runs: tuple[Run, ...]


@dataclass(frozen=True)
class _Frame:
    """The origin and scale of a group's coordinates."""

    x: float = 0.0
    y: float = 0.0
    scale: float = 1.0

    def at(self, x: str | float, y: str | float) -> tuple[float, float]:
        """Return a point of the group in the coordinates of the figure."""
        return self.x + self.scale * float(x), self.y + self.scale * float(y)


def tikz(svg: str) -> str:
    """Return a tikzpicture of one of our figures; needs tikz. Raises ValueError for SVG that our figures don't have."""
    root = ET.fromstring(svg)  # noqa: S314 - our own figure
    elements = list(_draw_elements(root, _Frame(), {}))
    return render("figure/arm.tex.j2", drawn=elements, unit=POINTS, end=(root.get("width"), root.get("height")))


def _draw_elements(parent: ET.Element, frame: _Frame, inherited: Mapping[str, str]) -> Iterator[Stroke | Lettering]:
    for element in parent:
        tag, attributes = element.tag.split("}")[-1], {**inherited, **element.attrib}
        if tag == "g":
            yield from _draw_elements(element, _transform_frame(frame, element.get("transform", "")), attributes)
        elif tag in ("polyline", "polygon"):
            pairs = (pair.split(",") for pair in attributes["points"].split())
            yield Stroke(_options(attributes, frame), tuple(frame.at(*pair) for pair in pairs), tag == "polygon")
        elif tag == "circle":
            centre = frame.at(attributes["cx"], attributes["cy"])
            yield Stroke(_options(attributes, frame), (centre,), True, frame.scale * float(attributes["r"]))
        elif tag == "rect":
            x, y, width, height = (float(attributes[name]) for name in ("x", "y", "width", "height"))
            corners = ((x, y), (x + width, y), (x + width, y + height), (x, y + height))
            rounded = f"rounded corners={POINTS * float(attributes.get('rx', 0)):.1f}pt"
            yield Stroke((*_options(attributes, frame), rounded), tuple(frame.at(*corner) for corner in corners), True)
        elif tag == "text":
            yield _lettering(element, attributes, frame)
        elif tag not in ("title", "desc"):
            raise ValueError(f"a figure with <{tag}>")


def _transform_frame(frame: _Frame, transform: str) -> _Frame:
    match = re.fullmatch(r"translate\(([-\d.]+) ([-\d.]+)\) scale\(([\d.]+)\)", transform)
    if match is None:
        if transform:
            raise ValueError(f"a figure with {transform!r}")
        return frame
    x, y = frame.at(match[1], match[2])
    return replace(frame, x=x, y=y, scale=frame.scale * float(match[3]))


def _options(attributes: Mapping[str, str], frame: _Frame) -> tuple[str, ...]:
    scale = POINTS * frame.scale
    options = [f"{name}={_colour(attributes[attribute])}" for attribute, name in (("fill", "fill"), ("stroke", "draw"))
               if attributes.get(attribute, "none") != "none"]  # fmt: skip
    options.append(f"line width={scale * float(attributes.get('stroke-width', 1)):.2f}pt")
    options += [f"{name}={attributes[attribute]}" for attribute, name in _JOINS.items() if attribute in attributes]
    if "stroke-dasharray" in attributes:
        lengths = [f"{scale * float(length):.2f}pt" for length in attributes["stroke-dasharray"].split()]
        marks = (f"{'off' if k % 2 else 'on'} {length}" for k, length in enumerate(lengths))
        options.append(f"dash pattern={' '.join(marks)}")
    return tuple(options)


def _colour(code: str) -> str:
    """Return a colour for xcolor.

    >>> _colour("#00694c")
    '{rgb,255:red,0;green,105;blue,76}'
    """
    red, green, blue = (int(code[k : k + 2], 16) for k in (1, 3, 5))
    return f"{{rgb,255:red,{red};green,{green};blue,{blue}}}"


def _lettering(element: ET.Element, attributes: Mapping[str, str], frame: _Frame) -> Lettering:
    runs: list[Run] = []
    lowered_by = 0.0
    for run in element if len(element) else (element,):
        lowered_by += float(run.get("dy", 0))
        size = POINTS * frame.scale * float(run.get("font-size", attributes.get("font-size", 15)))
        runs.append(
            Run(_to_latex(run.text or "", run.get("font-style") == "italic"), size, -POINTS * frame.scale * lowered_by)
        )
    return Lettering(frame.at(attributes["x"], attributes["y"]), _colour(attributes["fill"]), tuple(runs))


def _to_latex(text: str, italic: bool) -> str:
    r"""Return lettering in LaTeX.

    >>> _to_latex("θ", True), _to_latex("a", True), _to_latex("− 30°", False)
    ('$\\theta$', '\\textit{a}', '$-$ 30$^\\circ$')
    """
    pieces = re.split(f"([{''.join(_GREEK)}])", text)
    latex = "".join(rf"$\{_GREEK[piece]}$" if piece in _GREEK else latex_escaped(piece) for piece in pieces)
    latex = re.sub(f"[{_LOW}]+", lambda match: f"$_{{{match[0].translate(_DIGITS)}}}$", latex.replace("°", r"$^\circ$"))
    return rf"\textit{{{latex}}}" if italic and not any(piece in _GREEK for piece in pieces) else latex
