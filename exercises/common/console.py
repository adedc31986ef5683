"""Print the output of commands: results on standard output, notes and progress on standard error."""

import re
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from qdot.exercises.common.errors import make_name_error

if TYPE_CHECKING:  # loaded at run time only if there is a terminal
    from rich.progress import Progress


_CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")


def escape_controls(text: str) -> str:
    r"""Return a text in which terminal controls, marks of writing direction and lone surrogates are escaped.

    >>> print(escape_controls("name\x1b[2J"))
    name\u001b[2J
    """
    return _CONTROLS.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def print_result(text: str) -> None:
    """Write a result to standard output, followed by a line break if it doesn't end with one."""
    escaped_text = escape_controls(text)
    sys.stdout.write(escaped_text if escaped_text.endswith("\n") else escaped_text + "\n")
    sys.stdout.flush()


def note(text: str) -> None:
    """Write a note for the user to standard error, so that standard output has only the results."""
    sys.stderr.write(escape_controls(text) + "\n")


PROGRESS_INTERVAL = 60.0
"""Number of seconds between two lines of progress if standard error is not a terminal."""


@contextmanager
def show_progress(title: str, total: int) -> Iterator["ProgressCounter"]:
    """Show on standard error how many of `total` items are finished; the block calls `step` after each item.

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
        self._title, self._total, self._finished_count = title, total, 0
        self._next_note_time = time.monotonic() + PROGRESS_INTERVAL

    def step(self) -> None:
        """Count one more item."""
        self._finished_count += 1
        if time.monotonic() >= self._next_note_time:
            note(f"{self._title}: {self._finished_count} of {self._total}")
            self._next_note_time += PROGRESS_INTERVAL


class ProgressBarCounter(ProgressCounter):
    """Shows finished items on a progress bar. The bar has no thread, because a process with threads is never forked."""

    def __init__(self, bar: "Progress", title: str, total: int) -> None:
        super().__init__(title, total)
        self._bar, self._task_id = bar, bar.add_task(title, total=total, rate="")
        self._next_refresh_time = 0.0
        bar.refresh()

    def step(self) -> None:
        """Count one more item, and redraw the bar at most ten times a second."""
        task, now = self._bar.tasks[0], time.monotonic()
        speed = task.finished_speed or task.speed
        self._bar.update(self._task_id, advance=1, rate=f"{speed:.1f}/s" if speed else "")
        if now >= self._next_refresh_time:
            self._bar.refresh()
            self._next_refresh_time = now + 0.1


def check_choice(value: str, choices: tuple[str, ...], option: str) -> None:
    """Raise QdotError if the value of an option is not one of the choices."""
    if value not in choices:
        raise make_name_error(option, value, choices)
