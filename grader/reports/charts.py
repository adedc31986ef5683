"""Draw the charts of the class overview with matplotlib, as SVG that takes its colours from the page.

The same numbers give the same bytes. matplotlib draws in placeholder colours; variables of the page's style sheet then
replace these, so that a chart follows the light and the dark theme. Hatching and words repeat everything that the
colours say. No chart contains a student's text.
"""

import io
import re
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from qdot.exercises.common.errors import shorten
from qdot.exercises.common.extras import require_extra
from qdot.grader.judging.verdict import Outcome
from qdot.grader.statistics.class_statistics import Interval

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = {
    "ink": "#010203", "soft": "#020304", "line": "#030405", "good": "#040506", "half": "#050607", "bad": "#060708",
    "none": "#070809", "bar": "#08090a", "field": "#090a0b",
}  # fmt: skip
"""The placeholder colours, each by the name of the variable that replaces it."""

MAX_TITLE_LENGTH = 44
"""Maximum number of characters of a mistake's title in a chart."""

CHART_WIDTH = 4.7
"""Width of a chart in inches; a phone shows it without shrinking the letters."""
HISTOGRAM_HEIGHT, ROW_HEIGHT, GROUP_ROW_HEIGHT = 2.5, 0.27, 0.55
"""Heights in inches of the histogram, of the row for one part or mistake, and of the row for one group of arms."""
AXIS_HEIGHT, LEGEND_HEIGHT, MARGIN_HEIGHT = 0.75, 0.4, 0.3
"""Heights in inches of an axis with its label, of a legend, and of the margins of a chart without an axis."""
COUNT_ROOM_ABOVE, COUNT_ROOM_BESIDE = 1.18, 1.12
"""Lengths of an axis relative to its longest bar, with room for the count above or beside the bar."""
MEAN_LINE_HALF_HEIGHT, MAX_DOT_DISTANCE, MAX_STACK_HEIGHT = 0.42, 0.09, 0.7
"""Half the height of the line at a mean, and the sizes of a stack of dots; the unit is the height of a row."""


def check_library() -> None:
    """Raise QdotError if matplotlib is not installed."""
    require_extra("report", "the report", "matplotlib")


_STYLE: dict[str, Any] = {
    "svg.fonttype": "none", "font.family": "sans-serif", "font.size": 9.5, "text.parse_math": False,
    "axes.edgecolor": COLOURS["line"], "axes.labelcolor": COLOURS["soft"], "text.color": COLOURS["ink"],
    "xtick.color": COLOURS["line"], "ytick.color": COLOURS["line"], "xtick.labelcolor": COLOURS["soft"],
    "ytick.labelcolor": COLOURS["ink"], "axes.spines.top": False, "axes.spines.right": False,
    "axes.facecolor": "none", "figure.facecolor": "none", "savefig.facecolor": "none", "hatch.linewidth": 0.8,
    "axes.axisbelow": True, "grid.color": COLOURS["line"], "grid.linewidth": 0.6, "axes.linewidth": 0.8,
    "legend.frameon": False, "legend.fontsize": 9,
    "figure.constrained_layout.use": True, "lines.solid_capstyle": "butt",
}  # fmt: skip


def _make_chart(name: str, height: float, draw: "Callable[[Axes], None]") -> str:
    """Return a chart as SVG to be embedded in a page; `draw` draws into its axes, `height` is in inches."""
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    # Use matplotlib's defaults and qdot's settings, whatever the user's matplotlibrc sets.
    settings: Any = {key: value for key, value in mpl.rcParamsDefault.items() if key != "backend"}
    with mpl.rc_context(settings | _STYLE | {"svg.hashsalt": name}):
        figure = Figure(figsize=(CHART_WIDTH, height))
        FigureCanvasSVG(figure)
        draw(figure.add_subplot())
        svg = io.BytesIO()
        figure.savefig(svg, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    return _adapt_to_page(svg.getvalue().decode(), name)


def _adapt_to_page(text: str, name: str) -> str:
    """Return an SVG without its preamble, with the page's colours and font, and with ids that begin with `name`."""
    text = re.sub(r"<metadata>.*?</metadata>\s*", "", text[text.index("<svg") :], flags=re.DOTALL)
    for colour, placeholder in COLOURS.items():
        text = text.replace(placeholder, f"var(--{colour})")
    text = re.sub(r"(font(?:-family)?:)[^;\"]*?([\d.]+px)[^;\"]*", r"font-size: \2", text)
    text = re.sub(r" *font-family:[^;\"]*;?", "", text)
    text = re.sub(r'\b(id="|href="#|url\(#)', rf"\g<1>{name}-", text)
    text = re.sub(r"<style.*?</style>\s*", "", text, flags=re.DOTALL)  # a style would apply to the whole page
    opening, bracket, body = text.partition(">")
    opening = re.sub(r' (width|height|version|xmlns:xlink)="[^"]*"', "", opening)
    return f'{opening} aria-hidden="true" focusable="false"{bracket}{body.replace("xlink:href", "href")}'


# --- charts ---


class OutcomeStyle(NamedTuple):
    """How a chart shows an outcome: its name in words, a key of `COLOURS`, and matplotlib's code for the hatching."""

    label: str
    colour: str
    hatch: str


OUTCOME_STYLES = {
    Outcome.CORRECT: OutcomeStyle("right", "good", ""),
    Outcome.PARTIAL: OutcomeStyle("partly right", "half", "///"),
    Outcome.WRONG: OutcomeStyle("wrong", "bad", "xxx"),
    Outcome.MISSING: OutcomeStyle("blank", "none", "..."),
    Outcome.UNGRADED: OutcomeStyle("ungraded", "line", "|||"),
}


def draw_histogram(tenth_counts: Sequence[int], mean: float, median: float) -> str:
    """Draw a histogram of the scores; `tenth_counts` has the number of students in each tenth of the score range."""

    def draw(axes: "Axes") -> None:
        bars = axes.bar([10 * i + 5 for i in range(10)], tenth_counts, width=9, color=COLOURS["bar"], linewidth=0)
        axes.bar_label(bars, [str(count or "") for count in tenth_counts], padding=2, color=COLOURS["ink"])
        axes.axvline(mean, color=COLOURS["ink"], linewidth=1.4, label=f"mean {mean:.3g} %")
        axes.axvline(median, color=COLOURS["ink"], linewidth=1.4, linestyle=(0, (2, 2)), label=f"median {median:.3g} %")
        axes.set(xlim=(0, 100), ylim=(0, COUNT_ROOM_ABOVE * max(tenth_counts)), xticks=range(0, 101, 20), yticks=[])
        axes.set_xlabel("score, % of the points")
        axes.spines["left"].set_visible(False)
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)

    return _make_chart("scores", HISTOGRAM_HEIGHT, draw)


def draw_outcomes(parts: Sequence[str], counts: Sequence[Mapping[Outcome, int]]) -> str:
    """Draw the outcomes of each part, from left to right: correct, partly correct, wrong, blank, ungraded."""

    def draw(axes: "Axes") -> None:
        rows = range(len(parts))
        bar_starts = [0.0] * len(parts)
        for outcome, (label, colour, hatch) in OUTCOME_STYLES.items():
            totals = [max(1, sum(count.values())) for count in counts]
            widths = [100 * count[outcome] / total for count, total in zip(counts, totals, strict=True)]
            if any(widths):
                style: Any = {"color": COLOURS[colour], "hatch": hatch, "edgecolor": COLOURS["field"], "linewidth": 0.8}
                axes.barh(rows, widths, left=bar_starts, height=0.68, label=label, **style)
            bar_starts = [start + width for start, width in zip(bar_starts, widths, strict=True)]
        _label_rows(axes, parts)
        axes.set(xlim=(0, 100), xticks=range(0, 101, 25))
        axes.set_xlabel("% of the students who submitted")
        spacing = {"columnspacing": 0.9, "handlelength": 1.3, "handletextpad": 0.5}
        axes.legend(loc="lower center", bbox_to_anchor=(0.36, 1.0), ncols=5, **spacing)

    return _make_chart("outcomes", AXIS_HEIGHT + LEGEND_HEIGHT + ROW_HEIGHT * len(parts), draw)


def draw_intervals(parts: Sequence[str], intervals: Sequence[Interval | None]) -> str:
    """Draw a point with its 95 % confidence interval for each part; return "" if no part has one."""
    if not any(intervals):
        return ""

    def draw(axes: "Axes") -> None:
        axes.axvline(0, color=COLOURS["soft"], linewidth=1)
        for row, interval in enumerate(intervals):
            if interval is not None:
                axes.plot([interval.low, interval.high], [row, row], color=COLOURS["bar"], linewidth=2.2)
                axes.plot(interval.value, row, "o", color=COLOURS["bar"], markersize=6.5)
        _label_rows(axes, parts)
        axes.grid(axis="x")
        axes.set(xlim=(-1, 1), xticks=[-1, -0.5, 0, 0.5, 1])
        axes.set_xlabel("correlation with the points of the other parts")

    return _make_chart("discrimination", AXIS_HEIGHT + ROW_HEIGHT * len(parts), draw)


def draw_mistakes(count_by_title: Mapping[str, int]) -> str:
    """Draw the number of students who made each mistake, by its title; return "" if there are no mistakes."""
    if not count_by_title:
        return ""
    counts = list(count_by_title.values())
    names = [shorten(title, MAX_TITLE_LENGTH) for title in count_by_title]

    def draw(axes: "Axes") -> None:
        bars = axes.barh(range(len(names)), counts, height=0.62, color=COLOURS["bar"], linewidth=0)
        axes.bar_label(bars, [str(count) for count in counts], padding=3, color=COLOURS["ink"])
        _label_rows(axes, names)
        axes.set(xlim=(0, COUNT_ROOM_BESIDE * max(counts)), xticks=[])
        axes.spines["bottom"].set_visible(False)

    return _make_chart("mistakes", MARGIN_HEIGHT + ROW_HEIGHT * len(names), draw)


def draw_groups(number: int, shares_by_group: Mapping[str, Sequence[float]]) -> str:
    """Draw a row for each group of arms: a dot for each student's share of the points, and a line at the mean.

    The shares are in %. `number` distinguishes this chart from the other charts of groups on the page.
    """

    def draw(axes: "Axes") -> None:
        for row, values in enumerate(shares_by_group.values()):
            # Dots of equal shares are stacked around the row's centre, at the offsets 0, -1, 1, -2, 2 …
            levels: dict[float, int] = {}
            for value in sorted(values):
                level = levels[value] = levels.get(value, -1) + 1
                distance = min(MAX_DOT_DISTANCE, MAX_STACK_HEIGHT / values.count(value))
                offset = (-1) ** level * ((level + 1) // 2) * distance
                axes.plot(value, row + offset, "o", color=COLOURS["bar"], markersize=3.4, markeredgewidth=0)
            mean = sum(values) / len(values)
            line_ends = [row - MEAN_LINE_HALF_HEIGHT, row + MEAN_LINE_HALF_HEIGHT]
            axes.plot([mean, mean], line_ends, color=COLOURS["ink"], linewidth=2.2)
        _label_rows(axes, list(shares_by_group))
        axes.grid(axis="x")
        axes.set(xlim=(-3, 103), xticks=range(0, 101, 25))
        axes.set_xlabel("% of the points; a line at the mean")

    return _make_chart(f"variants-{number}", AXIS_HEIGHT + GROUP_ROW_HEIGHT * len(shares_by_group), draw)


def _label_rows(axes: "Axes", names: Sequence[str]) -> None:
    """Label every row with its name; the first row is at the top."""
    axes.set_yticks(range(len(names)), list(names))
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
