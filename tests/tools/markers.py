"""A pytest plugin for `tests.tools.planted`: which test comes to which place, how long each takes, which hangs.

A marked place calls `mark(number)`. It may be in another process than the test, which is then told by the environment
(PYTEST_CURRENT_TEST); where nothing can be written, as in the sandbox of students' code, the mark is lost.
"""

import os
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import Any

FILE = "QDOT_MARKS"
"""The environment variable that names the file to which lines are added: number or "took", tab, test, tab, seconds."""
LIMITS = "QDOT_LIMIT"
"""Seconds of one test, after which it counts as hanging, and ends the process with the code HUNG."""
HUNG = 99

_seen: set[int] = set()
_recorded: list[set[int]] = []
_test = os.environ.get("PYTEST_CURRENT_TEST", "").rsplit(" (", 1)[0]


def mark(number: int) -> None:
    """Note that the test at hand comes to a place."""
    if number in _seen:
        return
    _seen.add(number)
    for one in _recorded:
        one.add(number)
    _write(str(number), _test)


def _write(*fields: str) -> None:
    with suppress(OSError, KeyError), open(os.environ[FILE], "a", encoding="utf-8") as file:  # noqa: PTH123
        file.write("\t".join(fields) + "\n")


def replayed(made: Callable[..., Any]) -> Callable[..., Any]:
    """Cache a function, whose marks count for every test that asks for its result, not for the first one only."""
    kept: dict[object, tuple[Any, set[int]]] = {}

    def asked(*arguments: object, **named: object) -> Any:
        key = (arguments, *sorted(named.items()))
        if key not in kept:
            marks: set[int] = set()
            before = set(_seen)
            _seen.clear()
            _recorded.append(marks)
            try:
                kept[key] = made(*arguments, **named), marks
            finally:
                _recorded.remove(marks)
                _seen.update(before)
        result, marks = kept[key]
        for number in marks:
            mark(number)
        return result

    return asked


def pytest_configure(config: Any) -> None:
    """Have the problems that tests share marked for each of them, not for the first one only."""
    if FILE in os.environ:
        from tests.support import problems

        problems.drawn = replayed(problems.drawn.__wrapped__)  # type: ignore[assignment]
        for plugin in config.pluginmanager.get_plugins():
            if hasattr(plugin, "drawn_once"):
                plugin.drawn_once = problems.drawn


def _hung(number: int, frame: object) -> None:
    sys.__stderr__ and sys.__stderr__.write(f"hung: {_test}\n")
    os._exit(HUNG)


def pytest_runtest_logstart(nodeid: str) -> None:
    """Begin anew for a test."""
    global _test  # noqa: PLW0603
    _test = nodeid
    _seen.clear()
    if LIMITS in os.environ:
        signal.signal(signal.SIGALRM, _hung)
        signal.alarm(int(os.environ[LIMITS]))


def pytest_runtest_logreport(report: Any) -> None:
    """Note what a test took, in the process that reports, not in its workers."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        _write("took", report.nodeid, f"{report.duration:.3f}")
