"""Installing qdot and first use: install commands, extras, dependencies, examples in help, completion."""

import os
import re
import shlex
import subprocess
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path
from typing import Any

import pytest
import typer
from packaging.requirements import Requirement

from qdot.exercises.assignment.assignment import Student
from qdot.exercises.common import extras
from qdot.exercises.common.extras import EXTRAS, explain_missing, make_install_command, require_extra
from qdot.grader.cli.main import COMMANDS, SITE_COMMANDS, find_needed_part, make_program
from tests.support import ROOT
from tests.support.command import run, run_and_fail
from tests.support.submitting import make_class

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


# --- words ---


INSTALL = re.compile(r"""pip install (['"]?)(?:qdot|qdot-robotics|\.)(?:\[([a-z,]+)\])?\1(?![\w=./\[-])""")
"""Install commands for qdot itself, with or without extras."""


@pytest.mark.parametrize(
    "page", [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))], ids=lambda page: page.name
)
def test_install_commands_are_the_same_everywhere(page: Path) -> None:
    """README and docs use the command of the messages; CI steps may differ."""
    text = re.sub(r"(?m)^.*- run:.*$", "", page.read_text(encoding="utf-8"))
    assert all(match[0] == make_install_command(match[2] or "") for match in INSTALL.finditer(text))


def test_install_commands_name_the_package_once_it_is_released(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extras, "IS_RELEASED", True)
    assert make_install_command() == "pip install qdot-robotics"
    monkeypatch.setitem(sys.modules, "typst", None)
    assert (
        explain_missing("pdf", "PDF")
        == "PDF needs typst, which is not installed; install it with: pip install 'qdot-robotics[pdf]'"
    )


# --- extras ---


def test_extras_agree_with_pyproject() -> None:
    declared = PROJECT["optional-dependencies"]
    assert set(declared) == {*EXTRAS, "all"}
    packages = packages_distributions()
    for name, modules in EXTRAS.items():
        assert [{Requirement(line).name} for line in declared[name]] == [
            {packages[module][0].lower()} for module in modules
        ]
    (everything,) = (Requirement(line) for line in declared["all"])
    assert everything.extras == set(EXTRAS)


@pytest.mark.parametrize(
    ("module", "command"),
    [
        ("typst", ["export", "{hw}", "--to", "pdf"]),
        ("xlsxwriter", ["grade", "{hw}", "--report", "xlsx=x.xlsx"]),
        ("distributed", ["grade", "{hw}", "--executor", "tcp://127.0.0.1:1"]),
    ],
    ids=["pdf", "xlsx", "executor"],
)  # fmt: skip
def test_a_missing_library_is_an_error_before_work_starts(
    module: str, command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assignment = make_class(tmp_path / "hw", [Student("ada")])
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, module, None)
    message = run_and_fail(*(word.format(hw=assignment.folder) for word in command)).splitlines()[-1]
    assert f"needs {module}, which is not installed; install it with: pip install '.[" in message
    assert not (assignment.folder / "graded" / "results.jsonl").exists() and not list(tmp_path.glob("x.*"))


def test_installed_extras_are_not_requested() -> None:
    for extra in EXTRAS:
        assert explain_missing(extra, "it") == "", "the development environment has all extras"
        require_extra(extra, "it")


# --- libraries ---


def test_every_dependency_is_explained_in_the_docs() -> None:
    lines = [*PROJECT["dependencies"], *(line for name in EXTRAS for line in PROJECT["optional-dependencies"][name])]
    page = (ROOT / "docs" / "dependencies.md").read_text(encoding="utf-8")
    rows = re.findall(r"(?m)^\| ([\w-]+) \| [^|]+ \|.*\| 20\d\d-\d\d-\d\d \|$", page)
    assert sorted(rows) == sorted(Requirement(line).name for line in lines)
    assert all(f"## `{name}`: " in page and f"\n\n    {make_install_command(name)}\n" in page for name in EXTRAS)


def test_libraries_of_extras_are_not_loaded_by_the_program() -> None:
    code = "import sys; sys.modules.update(dict.fromkeys(('typst', 'xlsxwriter', 'distributed', 'dask')))"
    code += "; from qdot.grader.cli.main import make_program; make_program()"
    subprocess.run([sys.executable, "-c", code], check=True)


# --- help and completion ---

PROGRAM: Any = typer.main.get_command(make_program())
NAMES = [*COMMANDS, *(f"site {name}" for name in SITE_COMMANDS)]


def find_command(name: str) -> Any:
    """Return a command by its full name, such as "site build"."""
    command = PROGRAM
    for word in name.split():
        command = command.commands[word]
    return command


EXAMPLES = {name: re.findall(r"(?m)^  (qdot .*)$", find_command(name).epilog) for name in NAMES}


def test_every_command_has_examples() -> None:
    assert all(EXAMPLES.values())
    assert "Examples:\n    qdot show planar-2r/7\n        a problem as students see it" in run("show", "--help")


@pytest.mark.parametrize("example", [example for examples in EXAMPLES.values() for example in examples])
def test_every_example_is_accepted(example: str) -> None:
    name = next(name for name in sorted(EXAMPLES, key=len, reverse=True) if f"{example} ".startswith(f"qdot {name} "))
    assert example in EXAMPLES[name]
    words = shlex.split(example.split(" > ", maxsplit=1)[0])[1 + len(name.split()) :]
    find_command(name).make_context(name, words).close()


@pytest.mark.parametrize(
    ("line", "names"),
    [
        ("qdot gen", ["generate"]),
        ("qdot ", [*COMMANDS, "serve", "site"]),
        ("qdot grade --di", ["--diff"]),
        ("qdot site ", ["build", "serve"]),
        ("qdot show scara", ["scara/1", "scara-rrrp/1", "scara-prrr/1"]),
        (
            "qdot show scara/1 --questions position,dete",
            ["position,determinant", "position,determinant-choice", "position,determinant-value"],
        ),
        ("qdot show scara/1 --variation full+to", ["full+tool"]),
        ("qdot solve pan", ["panda"]),
        ("qdot init homework --set sing", ["singularities"]),
        ("qdot export homework --to sc", ["scorm"]),
        ("qdot site build --families scara,elbow-l", ["scara,elbow-lateral"]),
        ("qdot solve ./ar", []),  # the shell completes files
    ],
)
def test_tab_completes_commands_options_and_names(
    line: str, names: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    environment = {"_QDOT_COMPLETE": "complete_bash", "COMP_WORDS": line, "_TYPER_COMPLETE_ARGS": line}
    environment["COMP_CWORD"] = str(len(f"{line}x".split()) - 1)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    with pytest.raises(SystemExit):
        make_program(find_needed_part([], os.environ))(prog_name="qdot")
    assert sorted(capsys.readouterr().out.split()) == sorted(names)


def test_the_completion_script_is_printed() -> None:
    environment = {**os.environ, "_QDOT_COMPLETE": "source_bash"}
    code = "import sys; sys.argv = ['qdot']; from qdot.grader.cli.main import main; main()"
    process = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, encoding="utf-8")
    assert "_QDOT_COMPLETE=complete_bash" in process.stdout
