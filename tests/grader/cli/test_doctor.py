"""`qdot doctor` describes the machine's sandbox, and the level "strict" runs nothing without full protection."""

import json
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.grader.cli.main import app
from qdot.grader.sandbox import guarantees
from qdot.grader.sandbox.sandbox import Sandbox
from tests.support.command import run, run_and_fail, runner

MISSING_MEASURES = ("namespaces", "landlock", "seccomp")
TOML = 'title = "T"\nkey = "hw"\n{}[[problem]]\nfamily = "polar-rp"\nquestions = ["position"]\n'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    folder = tmp_path / "hw"
    run("init", folder, "--key", "hw")
    (folder / "assignment.toml").write_text(TOML.format(""))
    run("generate", folder, "--jobs", "1")
    return folder


@pytest.fixture
def weak_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pretend that the machine has neither namespaces nor Landlock nor seccomp."""
    findings = guarantees.probe(MISSING_MEASURES, quick=True)
    monkeypatch.setattr(guarantees, "probe", lambda **_: findings)


def test_doctor_lists_every_guarantee() -> None:
    result = runner.invoke(app, ["doctor"])
    assert result.exit_code == 0
    for name in guarantees.PROMISES:
        assert f"\n{name} " in result.stdout
    report = json.loads(runner.invoke(app, ["doctor", "--json"]).stdout)
    assert {"python", "sympy", "numpy", "qdot", "cores", "strict", "guarantees", "lacking"} <= report.keys()
    assert [guarantee["name"] for guarantee in report["guarantees"]] == list(guarantees.PROMISES)
    assert report["strict"] == ({each["by"] for each in report["guarantees"]} == {guarantees.ENFORCED_BY_KERNEL})
    can = "can" if report["strict"] else "can't"
    assert f'this machine {can} use sandbox = "strict"' in result.stdout


def test_doctor_says_what_is_missing_and_how_to_get_it(weak_machine: None) -> None:
    result = runner.invoke(app, ["doctor"])
    assert result.exit_code == 0
    for words in (
        "watched in Python only", "namespaces: not available", "Allow user namespaces", "this machine can't use",
    ):  # fmt: skip
        assert words in result.stdout


def test_strict_runs_nothing_on_a_weak_machine(folder: Path, weak_machine: None) -> None:
    (folder / "assignment.toml").write_text(TOML.format('sandbox = "strict"\n'))
    result = runner.invoke(app, ["grade", str(folder), str(folder / "solutions"), "--jobs", "1"])
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert 'requires sandbox = "strict"' in line and "files: watched in Python only" in line
    assert "Allow user namespaces" in line and line.endswith("nothing was run")
    assert not (folder / "graded").exists()


def test_best_warns_in_one_line_and_grades(folder: Path, weak_machine: None) -> None:
    result = runner.invoke(app, ["grade", str(folder), str(folder / "solutions"), "--jobs", "1"])
    assert result.exit_code == 0
    lines = [line for line in result.stderr.splitlines() if "sandbox" in line]
    assert len(lines) == 1 and "network: watched in Python only" in lines[0]


@pytest.mark.whole
def test_strict_grades_if_the_machine_can_enforce_it(folder: Path) -> None:
    before = load_assignment(folder)
    (folder / "assignment.toml").write_text(TOML.format('sandbox = "strict"\n'))
    after = load_assignment(folder)
    assert (after.sandbox, before.sandbox) == ("strict", "best")
    assert (after.problems_digest, after.notebook_digest, after.marking_digest) == (
        before.problems_digest,
        before.notebook_digest,
        before.marking_digest,
    )
    result = runner.invoke(app, ["grade", str(folder), str(folder / "solutions"), "--jobs", "1"])
    if guarantees.probe().is_strict:
        assert result.exit_code == 0 and "2 graded; mean 100.0 %" in result.stdout
    else:
        assert result.exit_code == 2


def test_an_unknown_level_is_an_error_with_its_line(folder: Path) -> None:
    (folder / "assignment.toml").write_text(TOML.format('sandbox = "Strict"\n'))
    assert 'assignment.toml: line 3: sandbox = "Strict": ' in run_and_fail("grade", folder)


@pytest.mark.parametrize("without", [{"seccomp"}, {"limits"}, {"privileges"}, {"namespaces", "landlock"}])
def test_a_strict_sandbox_that_starts_with_less_runs_nothing(without: set[str]) -> None:
    with (
        Sandbox(disabled_measures=without, load_libraries=False, strict=True) as sandbox,
        pytest.raises(QdotError, match="isolated strictly"),
    ):
        sandbox.run(["a = 1"], ["a"])
