"""The table of figures in tests/README.md is that of the last `make bench`, and says of each figure what it is."""

import json
import subprocess
import sys

import pytest

from tests.bench.figures import BEGIN, DOCUMENT, END, RECORD, Figure, table


def test_the_table_is_that_of_the_last_run() -> None:
    text = DOCUMENT.read_text(encoding="utf-8").split(BEGIN)[1].split(END)[0].strip()
    assert text == table(json.loads(RECORD.read_text(encoding="utf-8")))


@pytest.mark.parametrize(
    ("figure", "is_met", "ratio"),
    [
        (Figure("a", 0.9, "b", 0.3, 1, of_seconds=True), True, 3),
        (Figure("a", 1.1, "b", 0.3, 1, of_seconds=True), False, 1.1 / 0.3),
        (Figure("a", 0.3, "b", 0.2, 1.5), True, 1.5),
        (Figure("a", 0.4, "b", 0.2, 1.5), False, 2),
        (Figure("a", 0.1, "b", 6, 50, is_least=True), True, 60),
        (Figure("a", 0.1, "b", 4, 50, is_least=True), False, 40),
    ],
)
def test_a_goal_is_of_seconds_or_of_a_ratio_at_most_or_at_least(figure: Figure, is_met: bool, ratio: float) -> None:
    assert figure.is_met is is_met
    assert figure.ratio == pytest.approx(ratio)
    assert figure.cells[-1] == ("yes" if is_met else "**no**")


def test_what_was_not_measured_says_why_and_meets_nothing() -> None:
    cells = Figure("a", 0.1, "b", 1, 50, is_least=True, why="it is not installed").cells
    assert cells[1] == cells[3] == "–" and cells[-1] == "it is not installed"


BUSY = "import time\nwhile time.process_time() < {}: pass\n"


@pytest.mark.skipif(sys.platform != "linux", reason="told on Linux only")
def test_the_time_of_processes_is_counted_that_outlive_their_parent() -> None:
    """In a process of its own: the one that measures adopts whatever is orphaned."""
    parent = f"import subprocess, sys; subprocess.Popen([sys.executable, '-c', {BUSY.format(0.3)!r}])"
    measured = f"processor_time([sys.executable, '-c', {parent!r}])"
    script = f"import sys; from tests.bench.clock import processor_time; print({measured})"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert 0.3 <= float(done.stdout) < 5
