"""The table of figures in tests/README.md is up to date, and shows whether each goal is met."""

import json
import subprocess
import sys

import pytest

from tests.bench.figures import BEGIN, DOCUMENT, END, RECORD, Figure, table


def test_the_table_is_from_the_last_run() -> None:
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
def test_a_goal_is_a_limit_on_seconds_or_on_a_ratio(figure: Figure, is_met: bool, ratio: float) -> None:
    assert figure.is_met is is_met
    assert figure.ratio == pytest.approx(ratio)
    assert figure.cells[-1] == ("yes" if is_met else "**no**")


def test_a_figure_that_was_not_measured_gives_the_reason() -> None:
    cells = Figure("a", 0.1, "b", 1, 50, is_least=True, why="it is not installed").cells
    assert cells[1] == cells[3] == "–" and cells[-1] == "it is not installed"


BUSY_PROGRAM = "import time\nwhile time.process_time() < {}: pass\n"


@pytest.mark.skipif(sys.platform != "linux", reason="measured on Linux only")
def test_the_time_of_orphaned_processes_is_counted() -> None:
    """Measure in a separate process, because the measuring process adopts all orphans."""
    parent = f"import subprocess, sys; subprocess.Popen([sys.executable, '-c', {BUSY_PROGRAM.format(0.3)!r}])"
    measured = f"processor_time([sys.executable, '-c', {parent!r}])"
    script = f"import sys; from tests.bench.clock import processor_time; print({measured})"
    process = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert 0.3 <= float(process.stdout) < 5
