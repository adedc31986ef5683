"""The suites select the same tests every day; a family represents each shape; the table of figures is up to date."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from tests.bench.figures import BEGIN, DOCUMENT, END, RECORD, table
from tests.support import ROOT, suites
from tests.support.suites import SHAPES, classify_shape, sample_for_suite, select_families


def test_every_shape_of_arm_is_represented_by_a_family() -> None:
    shapes = {
        name: classify_shape(sample_chain(ProblemId(name, 0)), FAMILIES[name].has_varied_structure) for name in FAMILIES
    }
    assert set(shapes.values()) == set(SHAPES)
    assert all(shapes[name] == shape for shape, name in SHAPES.items())


def test_each_suite_selects_its_families(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suites, "WHOLE", False)
    monkeypatch.setattr(suites, "SUITE", "test")
    assert select_families() == list(SHAPES.values())
    assert select_families(["ur-6r", "scara", "elbow"]) == ["scara"]
    assert select_families(["ur-6r", "elbow"]) == ["ur-6r"]
    assert sample_for_suite(range(10), 3) == [0, 4, 8]
    monkeypatch.setattr(suites, "SUITE", "check")
    assert select_families() == ["planar-2r"]
    monkeypatch.setattr(suites, "WHOLE", True)
    assert select_families() == list(FAMILIES)
    assert sample_for_suite(range(10), 3) == list(range(10))


def test_the_examples_of_make_check_exist() -> None:
    for name in suites.EXAMPLES:
        path, _, beginning = name.partition("::")
        text = (ROOT / "tests" / path).read_text(encoding="utf-8")
        assert f"\ndef {beginning.partition('[')[0] or 'test_'}" in text, name


def test_the_suites_are_make_targets_and_the_whole_runs_nightly() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert all(f"\n{suite}:" in makefile for suite in suites.SUITES)
    workflow = Path(ROOT / ".github" / "workflows" / "whole.yml").read_text(encoding="utf-8")
    assert "cron:" in workflow and "run: make whole" in workflow


def test_the_table_is_from_the_last_run() -> None:
    text = DOCUMENT.read_text(encoding="utf-8").split(BEGIN)[1].split(END)[0].strip()
    assert text == table(json.loads(RECORD.read_text(encoding="utf-8")))


BUSY_PROGRAM = "import time\nwhile time.process_time() < {}: pass\n"


@pytest.mark.skipif(sys.platform != "linux", reason="measured on Linux only")
def test_the_time_of_orphaned_processes_is_counted() -> None:
    """Measure in a separate process, because the measuring process adopts all orphans."""
    parent = f"import subprocess, sys; subprocess.Popen([sys.executable, '-c', {BUSY_PROGRAM.format(0.3)!r}])"
    measured = f"processor_time([sys.executable, '-c', {parent!r}])"
    script = f"import sys; from tests.bench.clock import processor_time; print({measured})"
    process = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert 0.3 <= float(process.stdout) < 5
