"""Draw the charts of the class overview: matplotlib makes SVG, which takes its colours from the page.

Every chart is the same bytes for the same numbers. It is drawn in placeholder colours, which become variables of the
page's style sheet, so that it follows light and dark; what colours tell is told by hatching and by words, too. No text
of a student's is in a chart.
"""

import io
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from qdot.exercises.common.extras import need
from qdot.grader.judging.verdict import Outcome
from qdot.grader.statistics.statistics import Interval

if TYPE_CHECKING:
    from collections.abc import Iterator

    from matplotlib.axes import Axes

COLOURS = {
    "ink": "#010203", "soft": "#020304", "line": "#030405", "good": "#040506", "half": "#050607", "bad": "#060708",
    "none": "#070809", "bar": "#08090a", "field": "#090a0b",
}  # fmt: skip
"""Placeholders by the name of the variable that stands for them on the page."""

LONGEST = 44
"""Characters of a mistake's title in a chart."""

WIDE = 4.7
"""Inches: as wide as a phone shows it without making its letters small."""


def check_library() -> None:
    """Raise QdotError if nothing can be drawn."""
    need("report", "the report", "matplotlib")


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


@contextmanager
def _style(name: str) -> "Iterator[None]":
    """Draw by matplotlib's own defaults and ours, whatever the user's matplotlibrc says."""
    import matplotlib as mpl

    settings: Any = {key: value for key, value in mpl.rcParamsDefault.items() if key != "backend"}
    settings |= _STYLE | {"svg.hashsalt": name}
    with mpl.rc_context(settings):
        yield


def _chart(name: str, height: float, draw: "Callable[[Axes], None]") -> str:
    """Return what `draw` draws, as SVG to be embedded in a page."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    with _style(name):
        figure = Figure(figsize=(WIDE, height))
        FigureCanvasSVG(figure)
        draw(figure.add_subplot())
        out = io.BytesIO()
        figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    return _inline(out.getvalue().decode(), name)


def _inline(text: str, name: str) -> str:
    """Return an SVG without its preamble; colours by name, the page's letters, and ids of its own."""
    text = re.sub(r"<metadata>.*?</metadata>\s*", "", text[text.index("<svg") :], flags=re.DOTALL)
    for colour, placeholder in COLOURS.items():
        text = text.replace(placeholder, f"var(--{colour})")
    text = re.sub(r"(font(?:-family)?:)[^;\"]*?([\d.]+px)[^;\"]*", r"font-size: \2", text)
    text = re.sub(r" *font-family:[^;\"]*;?", "", text)
    text = re.sub(r'\b(id="|href="#|url\(#)', rf"\g<1>{name}-", text)
    text = re.sub(r"<style.*?</style>\s*", "", text, flags=re.DOTALL)  # it would be the whole page's
    opening, end, rest = text.partition(">")
    opening = re.sub(r' (width|height|version|xmlns:xlink)="[^"]*"', "", opening)
    return f'{opening} aria-hidden="true" focusable="false"{end}{rest.replace("xlink:href", "href")}'


# --- charts ---

OUTCOMES: Mapping[Outcome, tuple[str, str, str]] = {
    Outcome.CORRECT: ("right", "good", ""),
    Outcome.PARTIAL: ("partly right", "half", "///"),
    Outcome.WRONG: ("wrong", "bad", "xxx"),
    Outcome.MISSING: ("blank", "none", "..."),
    Outcome.UNGRADED: ("ungraded", "line", "|||"),
}
"""What an outcome is called, its colour, and its hatching."""


def draw_histogram(percents: Sequence[float], mean: float, median: float) -> str:
    """Draw how many students have which score, in tenths; 100 % is in the last."""
    counts = [0] * 10
    for percent in percents:
        counts[min(9, int(percent // 10))] += 1

    def draw(axes: "Axes") -> None:
        bars = axes.bar([10 * i + 5 for i in range(10)], counts, width=9, color=COLOURS["bar"], linewidth=0)
        axes.bar_label(bars, [str(count) if count else "" for count in counts], padding=2, color=COLOURS["ink"])
        axes.axvline(mean, color=COLOURS["ink"], linewidth=1.4, label=f"mean {mean:.3g} %")
        axes.axvline(median, color=COLOURS["ink"], linewidth=1.4, linestyle=(0, (2, 2)), label=f"median {median:.3g} %")
        axes.set(xlim=(0, 100), ylim=(0, 1.18 * max(counts)), xticks=range(0, 101, 20), yticks=[])
        axes.set_xlabel("score, % of the points")
        axes.spines["left"].set_visible(False)
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)

    return _chart("scores", 2.5, draw)


def draw_outcomes(parts: Sequence[str], counts: Sequence[Mapping[Outcome, int]]) -> str:
    """Draw the outcomes of each part, from the left: right, partly right, wrong, blank, ungraded."""

    def draw(axes: "Axes") -> None:
        rows = range(len(parts))
        left = [0.0] * len(parts)
        for outcome, (word, colour, hatch) in OUTCOMES.items():
            sums = [max(1, sum(count.values())) for count in counts]
            wide = [100 * count[outcome] / whole for count, whole in zip(counts, sums, strict=True)]
            if any(wide):
                axes.barh(
                    rows, wide, left=left, height=0.68, label=word, color=COLOURS[colour], hatch=hatch,
                    edgecolor=COLOURS["field"], linewidth=0.8,
                )  # fmt: skip
            left = [begin + width for begin, width in zip(left, wide, strict=True)]
        _by_row(axes, parts)
        axes.set(xlim=(0, 100), xticks=range(0, 101, 25))
        axes.set_xlabel("% of those who handed in")
        axes.legend(
            loc="lower center", bbox_to_anchor=(0.36, 1.0), ncols=5, columnspacing=0.9, handlelength=1.3,
            handletextpad=0.5,
        )  # fmt: skip

    return _chart("outcomes", 1.15 + 0.27 * len(parts), draw)


def draw_intervals(parts: Sequence[str], of_parts: Sequence[Interval | None]) -> str:
    """Draw a point for each part, with its interval of 95 %; return "" if no part has one."""
    if not any(of_parts):
        return ""

    def draw(axes: "Axes") -> None:
        axes.axvline(0, color=COLOURS["soft"], linewidth=1)
        for row, each in enumerate(of_parts):
            if each is not None:
                axes.plot([each.low, each.high], [row, row], color=COLOURS["bar"], linewidth=2.2)
                axes.plot(each.value, row, "o", color=COLOURS["bar"], markersize=6.5)
        _by_row(axes, parts)
        axes.grid(axis="x")
        axes.set(xlim=(-1, 1), xticks=[-1, -0.5, 0, 0.5, 1])
        axes.set_xlabel("correlation with the rest of the points")

    return _chart("discrimination", 0.75 + 0.27 * len(parts), draw)


def draw_mistakes(count_by_title: Mapping[str, int]) -> str:
    """Draw how many students made each mistake, by its title; return "" if there is none."""
    if not count_by_title:
        return ""
    counts = list(count_by_title.values())
    names = [title if len(title) <= LONGEST else f"{title[: LONGEST - 1].rstrip()}…" for title in count_by_title]

    def draw(axes: "Axes") -> None:
        bars = axes.barh(range(len(names)), counts, height=0.62, color=COLOURS["bar"], linewidth=0)
        axes.bar_label(bars, [str(count) for count in counts], padding=3, color=COLOURS["ink"])
        _by_row(axes, names)
        axes.set(xlim=(0, 1.12 * max(counts)), xticks=[])
        axes.spines["bottom"].set_visible(False)

    return _chart("mistakes", 0.3 + 0.27 * len(names), draw)


def draw_groups(number: int, names: Sequence[str], shares: Sequence[Sequence[float]]) -> str:
    """Draw a dot for each student in the row of the group, and each group's mean as a line."""

    def draw(axes: "Axes") -> None:
        for row, values in enumerate(shares):
            stacked: dict[float, int] = {}
            for value in sorted(values):
                level = stacked[value] = stacked.get(value, -1) + 1
                offset = (-1) ** level * ((level + 1) // 2) * min(0.09, 0.7 / max(1, values.count(value)))
                axes.plot(value, row + offset, "o", color=COLOURS["bar"], markersize=3.4, markeredgewidth=0)
            middle = sum(values) / len(values)
            axes.plot([middle, middle], [row - 0.42, row + 0.42], color=COLOURS["ink"], linewidth=2.2)
        _by_row(axes, names)
        axes.grid(axis="x")
        axes.set(xlim=(-3, 103), xticks=range(0, 101, 25))
        axes.set_xlabel("% of the points; a line at the mean")

    return _chart(f"variants-{number}", 0.75 + 0.55 * len(names), draw)


def _by_row(axes: "Axes", names: Sequence[str]) -> None:
    """Put a name at every row, the first on top."""
    axes.set_yticks(range(len(names)), list(names))
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
