"""The README and the library page are correct: commands and examples run, and every public name is documented."""

import inspect
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

import qdot
from qdot.exercises.assignment.assignment import load_assignment
from qdot.grader.cli.main import app
from tests.support import ROOT
from tests.support.suites import WHOLE, select_for_suite

README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^( *)```toml\n(.*?)^ *```", README, re.MULTILINE | re.DOTALL)


def list_commands() -> list[list[str]]:
    lines = re.findall(r"^    (qdot [^#\n]*)", README, re.MULTILINE)
    return [line.split()[1:] for line in lines if line.split() != ["qdot", "demo"]]  # tested in test_overview.py


def shorten(command: list[str]) -> list[str]:
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


def test_the_example_assignment_is_accepted(tmp_path: Path) -> None:
    assert CliRunner().invoke(app, ["init", str(tmp_path / "hw")]).exit_code == 0
    text = next(re.sub(rf"(?m)^{indent}", "", block) for indent, block in BLOCKS if "[[problem]]" in block)
    (tmp_path / "hw" / "assignment.toml").write_text(text)
    assert load_assignment(tmp_path / "hw").slots[0].points == (1, 2, 1, 2, 2)


def test_the_readme_is_short_and_has_pictures() -> None:
    assert len(README.splitlines()) <= 85 and len(README) < 6_000
    pictures = re.findall(r"!\[[^\]]{40,}\]\(docs/pictures/([\w-]+)\.png\)", README)
    assert pictures == ["jupyterlab-statement", "qdot-feedback", "qdot-site"]


@pytest.mark.parametrize("name", qdot.__all__)
def test_every_public_name_exists_and_has_an_example(name: str) -> None:
    item = getattr(qdot, name)
    assert name in dir(qdot)
    if inspect.isroutine(item):
        docstring = inspect.getdoc(item) or ""
        assert ">>> " in docstring, f"{name} has no example"


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'nothing_like_it'"):
        getattr(qdot, "nothing_like_it")  # noqa: B009


def test_importing_qdot_loads_no_algebra() -> None:
    """The version and the sandbox's files are available without waiting for SymPy."""
    code = "import sys, qdot; sys.exit('sympy' in sys.modules or 'numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_no_public_name_is_a_module() -> None:
    """Otherwise `from qdot import NAME` would give the module once it is imported."""
    folder = Path(qdot.__file__).parent
    assert not {path.stem for path in folder.iterdir()} & set(qdot.__all__)


def test_the_reference_page_has_every_public_name_and_its_first_example_runs() -> None:
    page = (ROOT / "docs" / "library.md").read_text(encoding="utf-8")
    assert all(f"### `{name}`" in page for name in qdot.__all__)
    code = page.split("```python\n")[1].split("```")[0]
    namespace: dict[str, object] = {}
    exec(compile(code, "docs/library.md", "exec"), namespace)
    assert repr(namespace["problem"]) == "Problem(elbow-3r/4: jacobian, determinant)"


def test_reprs_are_short() -> None:
    problem = qdot.generate("elbow-3r/4")
    part = problem["jacobian"]
    items = [problem.chain, part, qdot.solve(problem.chain), qdot.certify(problem)]
    items += [*qdot.mark(problem, {"jacobian": "[[1, 2, 3]]*3"}), qdot.judge(problem, part, "a1")]
    assert all(len(repr(item)) < 200 for item in items), [repr(item) for item in items if len(repr(item)) >= 200]
    assert repr(part) == "Part(jacobian: matrix 3 x 3, 2 points)"
