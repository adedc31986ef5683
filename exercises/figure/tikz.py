"""Convert the SVG of a figure to TikZ, so that LaTeX can draw it; only the elements of qdot's figures are supported."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from qdot.exercises.formula.latex import LETTERS
from qdot.exercises.writing.markup import escape_latex
from qdot.exercises.writing.render import render

POINTS_PER_PIXEL = 0.565
"""Points (1/72.27 inch) per pixel; the drawing of an arm, 520 pixels wide, becomes 294 points or 10.3 cm wide."""
_GREEK = {char: name for name, char in LETTERS.items() if name != "square"}  # the square stands for a blank
_SUBSCRIPT_DIGITS = "₀₁₂₃₄₅₆₇₈₉"
_DIGIT_OF_SUBSCRIPT = str.maketrans(_SUBSCRIPT_DIGITS, "0123456789")
_LINE_ENDS = {"stroke-linejoin": "line join", "stroke-linecap": "line cap"}


@dataclass(frozen=True)
class Stroke:
    """A line, a polygon or a circle with its TikZ options; in pixels, y down. A circle has one point, its centre."""

    options: tuple[str, ...]
    points: tuple[tuple[float, float], ...]
    is_closed: bool = False
    radius: float = 0.0


@dataclass(frozen=True)
class LatexRun:
    """A text in LaTeX, its font size, and the height (`raised_by`) by which it is raised, both in points."""

    latex: str
    size: float
    raised_by: float


@dataclass(frozen=True)
class LatexLine:
    """Runs of text on one line, centred on `point`, through which the baseline passes."""

    point: tuple[float, float]
    colour: str
    runs: tuple[LatexRun, ...]


@dataclass(frozen=True)
class _GroupFrame:
    """The origin of a group's coordinates, and their scale."""

    x: float = 0.0
    y: float = 0.0
    scale: float = 1.0

    def transform(self, x: str | float, y: str | float) -> tuple[float, float]:
        """Return a point of the group in the coordinates of the figure."""
        return self.x + self.scale * float(x), self.y + self.scale * float(y)


def convert_to_tikz(svg: str) -> str:
    """Return a tikzpicture of one of qdot's figures; LaTeX needs tikz. Raises ValueError for unsupported elements."""
    root = ET.fromstring(svg)  # noqa: S314 - our own figure
    elements, size = list(_convert_elements(root, _GroupFrame(), {})), (root.get("width"), root.get("height"))
    return render("figure/arm.tex.j2", elements=elements, unit=POINTS_PER_PIXEL, size=size)


def _convert_elements(parent: ET.Element, frame: _GroupFrame, outer_attributes: Mapping[str, str]) -> Iterator[Any]:
    """Yield the strokes and lines of text in an element; `outer_attributes` come from the elements around it."""
    for element in parent:
        tag, attributes = element.tag.split("}")[-1], {**outer_attributes, **element.attrib}
        if tag == "g":
            yield from _convert_elements(element, _transform_frame(frame, element.get("transform", "")), attributes)
        elif tag in ("polyline", "polygon"):
            points = tuple(frame.transform(*pair.split(",")) for pair in attributes["points"].split())
            yield Stroke(_list_tikz_options(attributes, frame), points, is_closed=tag == "polygon")
        elif tag == "circle":
            centre = frame.transform(attributes["cx"], attributes["cy"])
            options, radius = _list_tikz_options(attributes, frame), frame.scale * float(attributes["r"])
            yield Stroke(options, (centre,), is_closed=True, radius=radius)
        elif tag == "rect":
            x, y, width, height = (float(attributes[name]) for name in ("x", "y", "width", "height"))
            corners = ((x, y), (x + width, y), (x + width, y + height), (x, y + height))
            corner_radius = POINTS_PER_PIXEL * frame.scale * float(attributes.get("rx", 0))
            rounding = f"rounded corners={corner_radius:.1f}pt"
            points = tuple(frame.transform(*corner) for corner in corners)
            yield Stroke((*_list_tikz_options(attributes, frame), rounding), points, is_closed=True)
        elif tag == "text":
            yield _convert_text(element, attributes, frame)
        elif tag not in ("title", "desc"):
            raise ValueError(f"a figure with <{tag}>")


def _transform_frame(frame: _GroupFrame, transform: str) -> _GroupFrame:
    """Return the coordinates of a group inside `frame`, given the group's SVG attribute `transform`."""
    if not transform:
        return frame
    match = re.fullmatch(r"translate\(([-\d.]+) ([-\d.]+)\) scale\(([\d.]+)\)", transform)
    if match is None:
        raise ValueError(f"a figure with {transform!r}")
    x, y = frame.transform(match[1], match[2])
    return replace(frame, x=x, y=y, scale=frame.scale * float(match[3]))


def _list_tikz_options(attributes: Mapping[str, str], frame: _GroupFrame) -> tuple[str, ...]:
    """Return the TikZ options that stand for the SVG attributes of a shape in a group."""
    scale = POINTS_PER_PIXEL * frame.scale
    colours = {"fill": attributes.get("fill", "none"), "draw": attributes.get("stroke", "none")}
    options = [f"{name}={_write_color(colour)}" for name, colour in colours.items() if colour != "none"]
    options.append(f"line width={scale * float(attributes.get('stroke-width', 1)):.2f}pt")
    options += [f"{name}={attributes[attribute]}" for attribute, name in _LINE_ENDS.items() if attribute in attributes]
    if "stroke-dasharray" in attributes:
        lengths = [f"{scale * float(length):.2f}pt" for length in attributes["stroke-dasharray"].split()]
        dashes_and_gaps = (f"{'off' if k % 2 else 'on'} {length}" for k, length in enumerate(lengths))
        options.append(f"dash pattern={' '.join(dashes_and_gaps)}")
    return tuple(options)


def _write_color(code: str) -> str:
    """Return a colour for xcolor.

    >>> _write_color("#00694c")
    '{rgb,255:red,0;green,105;blue,76}'
    """
    red, green, blue = (int(code[k : k + 2], 16) for k in (1, 3, 5))
    return f"{{rgb,255:red,{red};green,{green};blue,{blue}}}"


def _convert_text(element: ET.Element, attributes: Mapping[str, str], frame: _GroupFrame) -> LatexLine:
    """Return a text element as a line of runs; the SVG attribute `dy` lowers a run and all runs after it."""
    runs: list[LatexRun] = []
    lowered_by, scale = 0.0, POINTS_PER_PIXEL * frame.scale
    for run in element if len(element) else (element,):  # its tspan elements, or its only text
        lowered_by += float(run.get("dy", 0))
        size = scale * float(run.get("font-size", attributes.get("font-size", 15)))
        latex = _to_latex(run.text or "", run.get("font-style") == "italic")
        runs.append(LatexRun(latex, size, -scale * lowered_by))
    return LatexLine(frame.transform(attributes["x"], attributes["y"]), _write_color(attributes["fill"]), tuple(runs))


def _to_latex(text: str, is_italic: bool) -> str:
    r"""Return a text in LaTeX.

    >>> _to_latex("θ", True), _to_latex("a", True), _to_latex("− 30°", False)
    ('$\\theta$', '\\textit{a}', '$-$ 30$^\\circ$')
    """
    pieces = re.split(f"([{''.join(_GREEK)}])", text)
    latex = "".join(rf"$\{_GREEK[piece]}$" if piece in _GREEK else escape_latex(piece) for piece in pieces)
    latex = latex.replace("°", r"$^\circ$")
    digits = re.compile(f"[{_SUBSCRIPT_DIGITS}]+")
    latex = digits.sub(lambda match: f"$_{{{match[0].translate(_DIGIT_OF_SUBSCRIPT)}}}$", latex)
    return rf"\textit{{{latex}}}" if is_italic and not any(piece in _GREEK for piece in pieces) else latex
