"""Print the output of commands: results on standard output, notes and progress on standard error."""

import re
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any

import typer

from qdot.exercises.common.completion import complete_names
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.variation import DEFAULT_VARIATION, VARIATION_AXES, VARIATION_STEPS

if TYPE_CHECKING:  # loaded at run time only if there is a terminal
    from rich.progress import Progress


def _make_variation_option(default: str) -> Any:
    steps, names = ", ".join(VARIATION_STEPS), complete_names(VARIATION_STEPS, VARIATION_AXES, separator="+")
    text = f"How much arms differ from the chapter's: {steps}, or axes as in lengths+base; default: {default}."
    return typer.Option("--variation", help=text, autocompletion=names)


VariationOption = Annotated[str, _make_variation_option(f"that of the problem's id, else {DEFAULT_VARIATION}")]
BankVariationOption = Annotated[str, _make_variation_option("that of assignment.toml")]
SiteVariationOption = Annotated[str, _make_variation_option("all steps in turn, or that of assignment.toml")]

_CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")


def escape_controls(text: str) -> str:
    r"""Return the text with escapes for terminal controls, marks of writing direction, and lone surrogates.

    >>> print(escape_controls("name\x1b[2J"))
    name\u001b[2J
    """
    return _CONTROLS.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def say(text: str) -> None:
    """Write a result to standard output, followed by a line break if it doesn't end with one."""
    text = escape_controls(text)
    sys.stdout.write(text if text.endswith("\n") else text + "\n")
    sys.stdout.flush()


def note(text: str) -> None:
    """Write a note for the user to standard error, apart from the results."""
    sys.stderr.write(escape_controls(text) + "\n")


PROGRESS_INTERVAL = 60.0
"""Number of seconds between two lines of progress if standard error is not a terminal."""


@contextmanager
def show_progress(title: str, total: int) -> Iterator["ProgressCounter"]:
    """Show on standard error how many of `total` items the block has done.

    A terminal shows a bar with the rate and the remaining time. Any other output, such as a CI log, gets one line a
    minute.
    """
    if not sys.stderr.isatty():
        yield ProgressCounter(title, total)
        return
    from rich import progress as bars
    from rich.console import Console

    count, rate = bars.MofNCompleteColumn(), bars.TextColumn("{task.fields[rate]}")
    times = bars.TimeElapsedColumn(), bars.TextColumn("left"), bars.TimeRemainingColumn()
    columns = (bars.TextColumn("{task.description}"), bars.BarColumn(), count, rate, *times)
    with bars.Progress(*columns, console=Console(stderr=True), auto_refresh=False) as bar:
        yield ProgressBarCounter(bar, title, total)


@contextmanager
def show_status(title: str) -> Iterator[None]:
    """Show a title on a terminal while the block runs, and erase it afterwards."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True).status(title):
        yield


class ProgressCounter:
    """Counts finished items, and writes a line of progress every `PROGRESS_INTERVAL` seconds."""

    def __init__(self, title: str, total: int) -> None:
        self._title, self._total, self._done = title, total, 0
        self._next_note = time.monotonic() + PROGRESS_INTERVAL

    def step(self) -> None:
        """Count one more item."""
        self._done += 1
        if time.monotonic() >= self._next_note:
            note(f"{self._title}: {self._done} of {self._total}")
            self._next_note += PROGRESS_INTERVAL


class ProgressBarCounter(ProgressCounter):
    """Shows finished items on a progress bar, without a thread, because a process with threads is never forked."""

    def __init__(self, bar: "Progress", title: str, total: int) -> None:
        super().__init__(title, total)
        self._bar, self._task = bar, bar.add_task(title, total=total, rate="")
        self._next_refresh = 0.0
        bar.refresh()

    def step(self) -> None:
        """Count one more item, and redraw the bar at most ten times a second."""
        task, now = self._bar.tasks[0], time.monotonic()
        speed = task.finished_speed or task.speed
        self._bar.update(self._task, advance=1, rate=f"{speed:.1f}/s" if speed else "")
        if now >= self._next_refresh:
            self._bar.refresh()
            self._next_refresh = now + 0.1


def check_choice(value: str, allowed: tuple[str, ...], option: str) -> str:
    """Return `value` if it is allowed. Raises QdotError."""
    if value not in allowed:
        raise QdotError(f"unknown {option} {value!r}; known: {', '.join(allowed)}")
    return value
