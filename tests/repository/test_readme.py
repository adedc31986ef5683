"""The README is correct: its qdot commands run, its example files are accepted, its make targets and links exist."""

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


def list_commands() -> list[list[str]]:
    lines = re.findall(r"^    (qdot [^#\n]*)", README, re.MULTILINE)
    return [line.split()[1:] for line in lines if line.split() != ["qdot", "demo"]]  # tested in test_demo.py


def list_toml_blocks() -> list[str]:
    return [re.sub(rf"(?m)^{indent}", "", text) for indent, text in BLOCKS]


def shorten(command: list[str]) -> list[str]:
    """Return a faster variant of a command: one process, and one problem instead of five."""
    words = ["1" if before == "--count" else word for before, word in zip(["", *command], command, strict=False)]
    return [*words, "--jobs", "1"] if command[0] in ("generate", "grade", "verify", "export") else words


ASSIGNMENT_COMMANDS = [command for command in list_commands() if "homework" in command or command[0] == "check"]
OTHER_COMMANDS = [command for command in list_commands() if command not in ASSIGNMENT_COMMANDS]
QUICK_COMMANDS = [command for command in OTHER_COMMANDS if command[0] != "solve"]


def run_command(command: list[str]) -> None:
    result = CliRunner().invoke(app, command if WHOLE else shorten(command))
    assert result.exit_code == 0, f"{command}: {result.output}"


def test_every_command_on_an_assignment_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for command in ASSIGNMENT_COMMANDS:
        if command[0] == "grade":
            shutil.copytree("homework/solutions", "homework/submitted", dirs_exist_ok=True)
        if command[0] == "check":
            shutil.copy("homework/solutions/s001/velocity.ipynb", "velocity.ipynb")
        run_command(command)
        if command[0] == "init" and not WHOLE:  # test_wheel.py grades all problems
            assert len(load_assignment(Path("homework")).slots) == 4
            toml = Path("homework/assignment.toml")
            toml.write_text("\n[[problem]]".join(toml.read_text().split("\n[[problem]]")[:2]))
    assert "2 students: 2 graded; mean 100.0 %" in CliRunner().invoke(app, ["grade", "homework"]).output
    assert {command[0] for command in ASSIGNMENT_COMMANDS} == {
        "init", "generate", "grade", "verify", "check", "report", "export",
    }  # fmt: skip


@pytest.mark.parametrize("command", select_for_suite(QUICK_COMMANDS, OTHER_COMMANDS), ids=" ".join)
def test_every_other_command_runs(command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    run_command(command)


def test_the_other_commands_are_show_and_solve() -> None:
    assert {command[0] for command in OTHER_COMMANDS} == {"show", "solve"}


def test_the_example_assignment_is_accepted(tmp_path: Path) -> None:
    assert CliRunner().invoke(app, ["init", str(tmp_path / "hw")]).exit_code == 0
    (tmp_path / "hw" / "assignment.toml").write_text(
        next(block for block in list_toml_blocks() if "[[problem]]" in block)
    )
    assert load_assignment(tmp_path / "hw").slots[0].points == (1, 2, 1, 2, 2)


def test_make_targets_and_links_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"^    make (\S+)", README, re.MULTILINE):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE)
    for link in re.findall(r"\]\(([^)#]+)\)", README):
        assert (ROOT / link).exists(), link


def test_the_readme_is_short_and_has_pictures() -> None:
    assert len(README.splitlines()) <= 85 and len(README) < 6_000
    pictures = re.findall(r"!\[[^\]]{40,}\]\(docs/pictures/([\w-]+)\.png\)", README)
    assert pictures == ["jupyterlab-statement", "qdot-feedback", "qdot-site"]


def test_the_readme_links_the_pages_for_newcomers() -> None:
    for page in ("docs/compatibility.md", "docs/privacy.md", "docs/install.md", "docs/container.md", "SECURITY.md"):
        assert f"]({page})" in README
