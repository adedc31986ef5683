"""`qdot doctor` and the level "strict": what is told of this machine, and that strict runs nothing unprotected."""

import json
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.grader.cli.main import app
from qdot.grader.sandbox import guarantees
from qdot.grader.sandbox.sandbox import Sandbox
from tests.support.command import run, run_and_fail, runner

WEAK = ("namespaces", "landlock", "seccomp")
TOML = 'title = "T"\nkey = "hw"\n{}[[problem]]\nfamily = "polar-rp"\nquestions = ["position"]\n'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    made = tmp_path / "hw"
    run("init", made, "--key", "hw")
    (made / "assignment.toml").write_text(TOML.format(""))
    run("generate", made, "--jobs", "1")
    return made


@pytest.fixture
def weak(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine that has neither namespaces nor Landlock nor seccomp."""
    weaker = guarantees.probe(WEAK, quick=True)
    monkeypatch.setattr(guarantees, "probe", lambda **_: weaker)


def test_doctor_tells_every_guarantee_and_leaves_with_0() -> None:
    result = runner.invoke(app, ["doctor"])
    assert result.exit_code == 0
    for name in guarantees.GUARANTEES:
        assert f"\n{name} " in result.stdout
    found = json.loads(runner.invoke(app, ["doctor", "--json"]).stdout)
    assert {"python", "sympy", "numpy", "qdot", "cores", "strict", "guarantees", "lacking"} <= found.keys()
    assert [each["name"] for each in found["guarantees"]] == list(guarantees.GUARANTEES)
    assert found["strict"] == all(each["by"] == guarantees.ENFORCED_BY_KERNEL for each in found["guarantees"])
    assert f'this machine {"can" if found["strict"] else "can" + chr(39) + "t"} use sandbox = "strict"' in result.stdout


def test_doctor_says_what_is_missing_and_what_to_do(weak: None) -> None:
    result = runner.invoke(app, ["doctor"])
    assert result.exit_code == 0
    for words in (
        "watched in Python only", "namespaces: not available", "Allow user namespaces", "this machine can't use",
    ):  # fmt: skip
        assert words in result.stdout


def test_strict_refuses_to_run_what_the_machine_does_not_contain(folder: Path, weak: None) -> None:
    (folder / "assignment.toml").write_text(TOML.format('sandbox = "strict"\n'))
    result = runner.invoke(app, ["grade", str(folder), str(folder / "solutions"), "--jobs", "1"])
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert 'requires sandbox = "strict"' in line and "files: watched in Python only" in line
    assert "Allow user namespaces" in line and line.endswith("nothing was run")
    assert not (folder / "graded").exists()


def test_best_tells_in_one_line_what_is_not_enforced_and_goes_on(folder: Path, weak: None) -> None:
    result = runner.invoke(app, ["grade", str(folder), str(folder / "solutions"), "--jobs", "1"])
    assert result.exit_code == 0
    lines = [line for line in result.stderr.splitlines() if "sandbox" in line]
    assert len(lines) == 1 and "network: watched in Python only" in lines[0]


@pytest.mark.whole
def test_strict_grades_where_it_can_be_had(folder: Path) -> None:
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


def test_a_wrong_level_is_told_with_its_line(folder: Path) -> None:
    (folder / "assignment.toml").write_text(TOML.format('sandbox = "Strict"\n'))
    assert 'assignment.toml: line 3: sandbox = "Strict": ' in run_and_fail("grade", folder)


@pytest.mark.parametrize("without", [{"seccomp"}, {"limits"}, {"privileges"}, {"namespaces", "landlock"}])
def test_a_strict_sandbox_that_starts_weaker_than_the_probe_runs_nothing(without: set[str]) -> None:
    with (
        Sandbox(disabled_measures=without, load_libraries=False, strict=True) as sandbox,
        pytest.raises(QdotError, match="isolated strictly"),
    ):
        sandbox.run(["a = 1"], ["a"])
