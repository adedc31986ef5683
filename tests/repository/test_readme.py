"""README is true: every qdot command in it runs, its example files are accepted, its targets exist."""

import re
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from qdot.exercises.assignment.assignment import load_assignment
from qdot.grader.cli.main import app
from tests.support import ROOT
from tests.support.suites import WHOLE, select_for_suite

README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^( *)```toml\n(.*?)^ *```", README, re.MULTILINE | re.DOTALL)


def commands() -> list[list[str]]:
    lines = re.findall(r"^    (qdot [^#\n]*)", README, re.MULTILINE)
    return [line.split()[1:] for line in lines if line.split() != ["qdot", "demo"]]  # test_demo.py has the class of 30


def toml_blocks() -> list[str]:
    return [re.sub(rf"(?m)^{indent}", "", text) for indent, text in BLOCKS]


def shorter(command: list[str]) -> list[str]:
    """Return a command that does the same in less time: without processes beside this one, with one problem of five."""
    given = ["1" if before == "--count" else word for before, word in zip(["", *command], command, strict=False)]
    return [*given, "--jobs", "1"] if command[0] in ("generate", "grade", "verify", "export") else given


ON_AN_ASSIGNMENT = [command for command in commands() if "homework" in command or command[0] == "check"]
BY_THEMSELVES = [command for command in commands() if command not in ON_AN_ASSIGNMENT]
QUICK = [command for command in BY_THEMSELVES if command[0] != "solve"]


def ran(command: list[str]) -> None:
    result = CliRunner().invoke(app, command if WHOLE else shorter(command))
    assert result.exit_code == 0, f"{command}: {result.output}"


def test_every_command_on_an_assignment_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for command in ON_AN_ASSIGNMENT:
        if command[0] == "grade":
            shutil.copytree("homework/solutions", "homework/submitted", dirs_exist_ok=True)
        if command[0] == "check":
            shutil.copy("homework/solutions/s001/velocity.ipynb", "velocity.ipynb")
        ran(command)
        if command[0] == "init" and not WHOLE:  # the last ones of its problems are graded in test_wheel.py
            assert len(load_assignment(Path("homework")).slots) == 4
            toml = Path("homework/assignment.toml")
            toml.write_text("\n[[problem]]".join(toml.read_text().split("\n[[problem]]")[:2]))
    assert "2 students: 2 graded; mean 100.0 %" in CliRunner().invoke(app, ["grade", "homework"]).output
    assert {command[0] for command in ON_AN_ASSIGNMENT} == {
        "init", "generate", "grade", "verify", "check", "report", "export",
    }  # fmt: skip


@pytest.mark.parametrize("command", select_for_suite(QUICK, BY_THEMSELVES), ids=" ".join)
def test_every_command_by_itself_runs(command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    ran(command)


def test_those_are_all_kinds_of_commands() -> None:
    assert {command[0] for command in BY_THEMSELVES} == {"show", "solve"}


def test_the_assignment_in_it_is_accepted(tmp_path: Path) -> None:
    assert CliRunner().invoke(app, ["init", str(tmp_path / "hw")]).exit_code == 0
    (tmp_path / "hw" / "assignment.toml").write_text(next(block for block in toml_blocks() if "[[problem]]" in block))
    assert load_assignment(tmp_path / "hw").slots[0].points == (1, 2, 1, 2, 2)


def test_make_targets_and_links_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"^    make (\S+)", README, re.MULTILINE):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE)
    for link in re.findall(r"\]\(([^)#]+)\)", README):
        assert (ROOT / link).exists(), link


def test_it_fits_on_two_screens_and_shows_what_comes_out() -> None:
    assert len(README.splitlines()) <= 85 and len(README) < 6_000
    pictures = re.findall(r"!\[[^\]]{40,}\]\(docs/pictures/([\w-]+)\.png\)", README)
    assert pictures == ["jupyterlab-statement", "qdot-feedback", "qdot-site"]


def test_what_a_stranger_wants_to_know_is_linked() -> None:
    for page in ("docs/compatibility.md", "docs/privacy.md", "docs/install.md", "docs/container.md", "SECURITY.md"):
        assert f"]({page})" in README
