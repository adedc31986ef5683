"""The figures of `make bench` and their table. Each figure is a ratio to a baseline, with a goal."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tests.support import ROOT

RECORD = Path(__file__).with_suffix(".json")
DOCUMENT = ROOT / "tests" / "README.md"
BEGIN, END = "<!-- from tests/bench/figures.json, by `make bench` -->", "<!-- end -->"


@dataclass(frozen=True)
class Figure:
    """What was measured, and beside what, in seconds of processor time; `goal` is of the ratio, or of the seconds.

    A goal is at least so much where `is_least`, else at most. A figure that was not measured has `why`.
    """

    what: str
    seconds: float
    beside: str
    other: float
    goal: float
    is_least: bool = False
    of_seconds: bool = False
    why: str = ""

    @property
    def ratio(self) -> float:
        """The ratio to the baseline, or its inverse if the goal is "at least"."""
        return self.other / self.seconds if self.is_least else self.seconds / self.other

    @property
    def is_met(self) -> bool:
        measured = self.seconds if self.of_seconds else self.ratio
        return measured >= self.goal if self.is_least else measured <= self.goal

    @property
    def cells(self) -> tuple[str, ...]:
        aim = f"{'≥' if self.is_least else '≤'} {_shown(self.goal)}{' s' if self.of_seconds else ''}"
        if self.why:
            return self.what, "–", self.beside, "–", aim, self.why
        told = f"{self.beside}: {_seconds(self.other)}"
        return self.what, _seconds(self.seconds), told, _shown(self.ratio), aim, "yes" if self.is_met else "**no**"


def _shown(number: float) -> str:
    return f"{number:.0f}" if number >= 20 else f"{number:.2g}"


def _seconds(number: float) -> str:
    return f"{1000 * number:.0f} ms" if number < 1 else f"{number:.1f} s" if number < 20 else f"{number:.0f} s"


HEAD = ("what", "processor time", "reference", "ratio", "goal", "met")


def table(measured: dict[str, Any]) -> str:
    """Return the table as Markdown, with when and where it was measured."""
    rows = [HEAD, ("---",) * len(HEAD), *(Figure(**figure).cells for figure in measured["figures"])]
    body = "\n".join(f"| {' | '.join(cells)} |" for cells in rows)
    about = f"Measured {measured['when']} by `make bench`, in {measured['minutes']} minutes, on"
    return f"{about}\n{measured['where']}.\n\n{body}"


def write(figures: Sequence[Figure], about: dict[str, Any]) -> None:
    """Store the figures, and write their table into tests/README.md."""
    measured = {**about, "figures": [asdict(figure) for figure in figures]}
    RECORD.write_text(json.dumps(measured, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    before, rest = DOCUMENT.read_text(encoding="utf-8").split(BEGIN)
    DOCUMENT.write_text(f"{before}{BEGIN}\n\n{table(measured)}\n\n{END}{rest.split(END, 1)[1]}", encoding="utf-8")
