"""A map of where an arm is singular: two joints along the edges, and a curve for each condition on them.

A condition on one joint is a line, on two joints a curve; one on three is drawn for five values of the third.
Conditions that hold together are points. Matplotlib draws the map (the extra `report`), with the same bytes for the
same arm.
"""

import io
import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.robot_file import Limits, Robot
from qdot.exercises.arm.singularity import Component
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import need
from qdot.exercises.common.files import write_atomically
from qdot.exercises.figure.pose import example_values
from qdot.exercises.formula.expression import read
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.writing.latex import tex_zero
from qdot.exercises.writing.markup import to_text
from qdot.exercises.writing.solution_steps import SingularComponent

if TYPE_CHECKING:
    from matplotlib.axes import Axes

GRID = 363
"""Points along each edge, one beyond either end."""
SIDE, MARGIN, LINE, HEADING = 3.9, 0.9, 0.2, 0.45
"""Inches: the side of a picture, its margins, a line of a legend, the heading."""
ELSEWHERE = (-120, -60, 0, 60, 120)
"""Values of a third joint for which a condition is drawn: degrees, or hundredths of the arm's size."""
MOST = 6
"""Pictures side by side and below each other."""
LONG = 56
"""Characters of a condition in the legend."""
COLOURS = ("#0b6e99", "#b5451b", "#4d7c0f", "#7a3e9d", "#946200", "#b02a5b")
STROKES: tuple[Any, ...] = ("-", (0, (6, 3)), (0, (1, 1.6)), (0, (7, 2, 1, 2)), (0, (7, 2, 1, 2, 1, 2)), (0, (2, 4)))
"""Each condition has its own colour and stroke: colour alone is not enough."""

MARKERS = "osD^vP"

Pair = tuple[sp.Symbol, sp.Symbol]


@dataclass(frozen=True)
class Curve:
    """A condition to draw, in numbers, its joints and its number; `conditions` are all that hold together there."""

    condition: sp.Expr
    joints: tuple[sp.Symbol, ...]
    conditions: tuple[sp.Expr, ...]
    number: int


@dataclass(frozen=True)
class Points:
    """Conditions on one joint each, which hold together at points: the joint values (rad or m), and the number."""

    joints: tuple[sp.Symbol, ...]
    values: tuple[tuple[sp.Expr, ...], ...]
    conditions: tuple[sp.Expr, ...]
    number: int


Mark = Curve | Points


@dataclass(frozen=True)
class Map:
    """The picture (SVG), and notes on it: the lengths it is drawn for, and what it does not show."""

    svg: str
    notes: tuple[str, ...]


def check_map(file: Path) -> None:
    """Raise QdotError if no map can be drawn, or not into this file."""
    need("report", "--map", "matplotlib")
    if file.suffix.lower() != ".svg":
        raise QdotError(f"--map {file}: the map is an SVG; name a file that ends in .svg")
    if not file.parent.is_dir():
        raise QdotError(f"--map {file}: there is no folder {file.parent}")


def write_map(file: Path, robot: Robot, singular: Sequence[SingularComponent] | None) -> str:
    """Draw the map of an arm into a file; return notes on it. Raises QdotError."""
    if not singular:
        known = "no configuration is singular" if singular is not None else "no singular set was found"
        return f"no map was drawn, for {known}"
    drawn_map = singular_map(
        robot.chain, [Component(component.conditions, component.solutions) for component in singular], robot.limits
    )
    if drawn_map is None:
        return "no map was drawn, for no condition is in three joints or fewer"
    write_atomically(file, drawn_map.svg)
    return " ".join((f"the map is in {file}.", *drawn_map.notes))


def singular_map(chain: Chain, components: Sequence[Component], limits: Sequence[Limits | None] = ()) -> Map | None:
    """Return the map of an arm over pairs of its joints, shaded beyond the `limits` of a joint.

    Return None if every condition is on more than three joints.
    """
    values = example_values(chain)
    marks = [mark for k, component in enumerate(components) if (mark := _mark(component, k, chain, values)) is not None]
    pairs = _pairs(chain, marks)
    if not pairs:
        return None
    return Map(_draw_svg(chain, marks, pairs, values, limits), tuple(_notes(values, len(components) - len(marks))))


def _mark(
    component: Component, number: int, chain: Chain, values: Mapping[sp.Symbol, sp.Expr]
) -> Curve | Points | None:
    """Return how to draw a component; None if it has too many joints."""
    conditions = component.conditions
    if len(conditions) == 2 and component.solutions is not None:
        joints, roots = zip(
            *sorted(component.solutions, key=lambda condition: chain.q.index(condition[0])), strict=True
        )
        return Points(joints, tuple(tuple(v.xreplace(values) for v in each) for each in roots), conditions, number)
    rest = [condition for condition in conditions if len(_joints([condition], chain)) > 1] or list(conditions)
    joints = _joints(rest, chain)
    beside = tuple(condition for condition in conditions if condition not in rest)
    if len(rest) != 1 or not 0 < len(joints) <= 3 or set(_joints(beside, chain)) & set(joints):
        return None
    return Curve(rest[0].xreplace(values), joints, (*beside, *rest), number)


def _joints(conditions: Sequence[sp.Expr], chain: Chain) -> tuple[sp.Symbol, ...]:
    symbols = set().union(*(condition.free_symbols for condition in conditions))
    return tuple(q for q in chain.q if q in symbols)


def _pairs(chain: Chain, marks: Sequence[Mark]) -> list[Pair]:
    """Return the pairs of joints to draw: those that conditions tie together, then the rest, two by two."""
    pairs = list(dict.fromkeys((mark.joints[0], mark.joints[1]) for mark in marks if len(mark.joints) > 1))
    shown = {joint for pair in pairs for joint in pair}
    single = [q for q in chain.q if any(mark.joints == (q,) for mark in marks) and q not in shown]
    for first, second in itertools.zip_longest(single[::2], single[1::2]):
        pairs.append(_order_pair(chain, first, second or next(q for q in reversed(chain.q) if q != first)))
    return pairs[:MOST] if chain.n > 1 else []


def _order_pair(chain: Chain, joint: sp.Symbol, other_joint: sp.Symbol) -> Pair:
    first, second = (q for q in chain.q if q in (joint, other_joint))
    return first, second


def _notes(values: Mapping[sp.Symbol, sp.Expr], left_out: int) -> Iterator[str]:
    if values:
        lengths = ", ".join(f"{symbol} = {float(value):.3g}" for symbol, value in values.items())
        yield f"The map is drawn for {lengths}; for other lengths curves are elsewhere."
    if left_out:
        yield f"Not in the map: {left_out} of the cases, in which conditions tie more joints together."


# --- drawing ---


def _draw_svg(
    chain: Chain, marks: Sequence[Mark], pairs: Sequence[Pair], values: Mapping[sp.Symbol, sp.Expr],
    limits: Sequence[Limits | None],
) -> str:  # fmt: skip
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    limited = dict(zip(chain.q, limits, strict=False))
    panels = [_Panel(chain, pair, values, limited, [m for m in marks if _is_in(m, pair)]) for pair in pairs]
    rows = [panels[k : k + 2] for k in range(0, len(panels), 2)]
    heights = [SIDE + MARGIN + LINE * max(panel.lines for panel in row) for row in rows]
    wide, high = (SIDE + MARGIN) * len(rows[0]), sum(heights) + HEADING
    settings: Any = {key: value for key, value in mpl.rcParamsDefault.items() if key != "backend"}
    settings |= {"svg.fonttype": "none", "svg.hashsalt": chain.name, "font.size": 10, "text.parse_math": False}
    with mpl.rc_context(settings):
        figure = Figure(figsize=(wide, high))
        FigureCanvasSVG(figure)
        figure.text(0.15 / wide, 1 - 0.1 / high, _heading(chain, limits), fontsize=11, verticalalignment="top")
        for k, row in enumerate(rows):
            bottom = high - HEADING - sum(heights[: k + 1]) + 0.6
            for column, panel in enumerate(row):
                left = 0.75 + column * (SIDE + MARGIN)
                panel.draw(figure.add_axes((left / wide, bottom / high, SIDE / wide, SIDE / high)))
        out = io.BytesIO()
        figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None, "Title": _heading(chain, ())})
    return out.getvalue().decode()


def _heading(chain: Chain, limits: Sequence[Limits | None]) -> str:
    shaded = "\nshaded: beyond the limits of a joint" if any(limits) else ""
    return f"{chain.title or chain.name}: where J loses rank{shaded}"


def _is_in(mark: Mark, pair: Pair) -> bool:
    """Tell whether a mark is drawn over a pair of joints: the pair has all of its joints, or the first two of three."""
    return mark.joints[:2] == pair if len(mark.joints) > 1 else mark.joints[0] in pair


@dataclass(frozen=True)
class _Panel:
    """One picture over a pair of joints."""

    chain: Chain
    pair: Pair
    values: Mapping[sp.Symbol, sp.Expr]
    limits: Mapping[sp.Symbol, Limits | None]
    marks: Sequence[Mark]

    @property
    def lines(self) -> int:
        """The number of lines of its legend."""
        more = (len(ELSEWHERE) if len(mark.joints) > 2 else 0 for mark in self.marks)
        return sum(1 + self._legend_text(mark).count("\n") for mark in self.marks) + sum(more)

    def draw(self, axes: "Axes") -> None:
        """Draw curves, points, limits and the legend."""
        for mark in self.marks:
            if isinstance(mark, Points):
                self._draw_points(axes, mark)
            elif len(mark.joints) < 3:
                self._draw_curve(
                    axes, mark.condition, mark, STROKES[mark.number % len(STROKES)], self._legend_text(mark)
                )
            else:
                self._draw_slices(axes, mark)
        for joint, name in zip(self.pair, "xy", strict=True):
            low, high = self._range(joint)
            axes.set(**{f"{name}lim": (low, high), f"{name}label": _label(joint)})
            if joint.name.startswith("theta"):
                axes.set(**{f"{name}ticks": range(-180, 181, 60)})
            for begin, end in self._ranges_beyond_limits(joint, low, high):
                shade = axes.axvspan if name == "x" else axes.axhspan
                shade(begin, end, color="#000000", alpha=0.08, linewidth=0)
        axes.grid(linewidth=0.4, color="#cccccc")
        axes.legend(
            loc="lower left", bbox_to_anchor=(-0.04, 1), fontsize=9, frameon=False, handlelength=3, borderpad=0.2
        )

    def _draw_curve(self, axes: "Axes", condition: sp.Expr, curve: Curve, stroke: Any, words: str) -> None:
        """Draw where a condition is zero, also one step beyond the edges, to show the zero of a sine at 180 degrees."""
        edges = []
        for joint in self.pair:
            low, high = self._range(joint)
            step = (high - low) / (GRID - 3)
            edges.append(np.linspace(low - step, high + step, GRID))
        at = np.meshgrid(*(_from_axis_units(joint, edge) for joint, edge in zip(self.pair, edges, strict=True)))
        named = {joint.name: values.ravel() for joint, values in zip(self.pair, at, strict=True)}
        zero = evaluate(compile_program([read(str(condition))]), named, GRID**2)[0].real.reshape(GRID, GRID)
        style: Any = {"linewidths": 1.6, "linestyles": [stroke], "colors": [COLOURS[curve.number % len(COLOURS)]]}
        axes.contour(*edges, zero, levels=[0.0], **style)
        axes.plot([], [], color=style["colors"][0], linestyle=stroke, linewidth=1.6, label=words)

    def _draw_slices(self, axes: "Axes", curve: Curve) -> None:
        """Draw a condition in three joints for some values of the third."""
        third = curve.joints[2]
        turns = third.name.startswith("theta")
        axes.plot([], [], linestyle="none", label=self._legend_text(curve))
        for stroke, value in zip(STROKES, ELSEWHERE, strict=False):
            here = value if turns else value / 100 * self._size()
            condition = curve.condition.xreplace(
                {third: sp.Float(float(_from_axis_units(third, np.array(float(here)))))}
            )
            words = f"    {_joint_text(third)} = {here:.3g}{'°' if turns else ' m'}".replace("-", "−")
            self._draw_curve(axes, condition, curve, stroke, words)

    def _draw_points(self, axes: "Axes", points: Points) -> None:
        """Mark where conditions on both joints hold together."""
        if points.joints != self.pair:
            return
        style: Any = {"color": COLOURS[points.number % len(COLOURS)], "markersize": 6, "linestyle": "none"}
        style |= {"marker": MARKERS[points.number % len(MARKERS)], "clip_on": False}
        inside = [self._range(joint) for joint in self.pair]
        for combination in itertools.product(*points.values):
            there = [_to_axis_units(joint, float(value)) for joint, value in zip(self.pair, combination, strict=True)]
            for turns in itertools.product((-360, 0, 360), repeat=2):  # 180 degrees are at both edges
                place = [value + turn for value, turn in zip(there, turns, strict=True)]
                if all(low <= value <= high for value, (low, high) in zip(place, inside, strict=True)):
                    axes.plot(*place, **style)
        axes.plot([], [], label=self._legend_text(points), **style)

    def _legend_text(self, mark: Mark) -> str:
        """Return conditions for the legend, cut if they are long."""
        return " and\n".join(_shorten(condition, self.chain) for condition in mark.conditions)

    def _range(self, joint: sp.Symbol) -> tuple[float, float]:
        return (-180, 180) if joint.name.startswith("theta") else (-1.5 * self._size(), 1.5 * self._size())

    def _size(self) -> float:
        lengths = [abs(value.xreplace(self.values)) for joint in self.chain.joints for value in (joint.a, joint.d)]
        return max((float(value) for value in lengths if value.is_number), default=1.0) or 1.0

    def _ranges_beyond_limits(self, joint: sp.Symbol, low: float, high: float) -> Iterator[tuple[float, float]]:
        """Yield the parts of the range outside the limits of a joint."""
        ends = self.limits.get(joint)
        if ends is None:
            return
        factor = 180 / np.pi if joint.name.startswith("theta") else 1.0
        begin, end = (factor * float(value) for value in ends)
        if begin > low:
            yield low, begin
        if end < high:
            yield end, high


def _from_axis_units(joint: sp.Symbol, values: np.ndarray) -> np.ndarray:
    """Return values on an axis of the picture in radians or metres."""
    return np.asarray(np.radians(values) if joint.name.startswith("theta") else values)


def _joint_text(joint: sp.Symbol) -> str:
    return to_text(f"${tex_zero(joint)}$").strip()


def _label(joint: sp.Symbol) -> str:
    return f"{_joint_text(joint)} ({'°' if joint.name.startswith('theta') else 'm'})"


def _to_axis_units(joint: sp.Symbol, value: float) -> float:
    """Return radians or metres as on an axis of the picture: degrees from -180 to 180, or metres."""
    return float((np.degrees(value) + 180) % 360 - 180) if joint.name.startswith("theta") else value


def _shorten(condition: sp.Expr, chain: Chain) -> str:
    text = " ".join(to_text(f"${tex_zero(condition, chain)} = 0$").split())
    return text if len(text) <= LONG else text[:LONG].rsplit(" ", 1)[0] + " … = 0"
