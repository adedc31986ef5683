"""What every command shares: where results and progress go, and how errors end."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from exercises.errors import QdotError


def say(text: str) -> None:
    """Write a result to standard output, ending in one line break."""
    sys.stdout.write(text if text.endswith("\n") else text + "\n")


def note(text: str) -> None:
    """Tell the user something beside the results, on standard error."""
    sys.stderr.write(text + "\n")


@contextmanager
def progress(title: str, total: int) -> Iterator["Counter"]:
    """Show a bar with rate and time left on standard error while the block works through `total` items.

    Nothing is shown where standard error is no terminal.
    """
    if not sys.stderr.isatty():
        yield Counter(None, title, total)
        return
    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[rate]}"),
        TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=Console(stderr=True)) as bar:
        yield Counter(bar, title, total)


class Counter:
    """Counts what is done, on a progress bar where there is one."""

    def __init__(self, bar: Progress | None, title: str, total: int) -> None:
        self._bar = bar
        self._task = bar.add_task(title, total=total, rate="") if bar is not None else None

    def step(self) -> None:
        """Count one more."""
        if self._bar is None or self._task is None:
            return
        task = self._bar.tasks[0]
        rate = "" if not task.finished_speed and not task.speed else f"{task.finished_speed or task.speed:.1f}/s"
        self._bar.update(self._task, advance=1, rate=rate)


def one_of(value: str, allowed: tuple[str, ...], option: str) -> str:
    """Return `value` if it is allowed. Raises QdotError."""
    if value not in allowed:
        raise QdotError(f"{option} {value!r} is none of {', '.join(allowed)}")
    return value
