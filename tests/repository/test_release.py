"""A release and its installation: versions, reproducible builds, permissions, extras, examples in help, completion."""

import os
import re
import shlex
import shutil
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
from tests.support.ci import read_yaml
from tests.support.command import run, run_and_fail
from tests.support.programs import GIT, require_program
from tests.support.submitting import make_class
from tests.tools import release

WORKFLOW = ROOT / ".github" / "workflows" / "release.yml"
JOBS = read_yaml(WORKFLOW)["jobs"]


def copy_checkout(folder: Path) -> Path:
    require_program("git", GIT)
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\0")
    for name in filter(None, names):
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    return folder


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    for name in (*release.VERSION_PATTERNS, "CHANGELOG.md"):
        shutil.copy(ROOT / name, tmp_path / name)
    return tmp_path


def test_the_version_is_in_one_place_and_in_the_citation(checkout: Path) -> None:
    version = release.read_version(ROOT)
    assert release.find_objections(ROOT, "") == []
    for name in ("site/package.json", "README.md", "exercises/__init__.py"):
        assert version not in (ROOT / name).read_text(), name


def test_a_release_is_prepared_by_one_command(checkout: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = (checkout / "CHANGELOG.md").read_text(encoding="utf-8")
    assert release.main(["prepare", "7.0.0", "--on", "2026-12-01"], checkout) == 0
    assert release.read_version(checkout) == "7.0.0"
    assert "then: python -m tests.tools.archive 7.0.0;" in capsys.readouterr().out
    assert release.main(["check", "v7.0.0"], checkout) == 2
    assert capsys.readouterr().err == "tests/data/archives/7.0.0 is missing: python -m tests.tools.archive 7.0.0\n"
    (checkout / "tests" / "data" / "archives" / "7.0.0").mkdir(parents=True)
    assert release.main(["check", "v7.0.0"], checkout) == 0
    assert release.main(["notes"], checkout) == 0
    assert capsys.readouterr().out.strip() == release.find_section(before, "Unreleased")
    changelog = (checkout / "CHANGELOG.md").read_text(encoding="utf-8")
    assert "## Unreleased\n\n## 7.0.0 - 2026-12-01\n\n###" in changelog
    assert release.main(["prepare", "7.0.0"], checkout) == 2
    assert release.main(["prepare", "7.1.0"], checkout) == 2
    errors = capsys.readouterr().err.splitlines()
    assert errors == [
        "CHANGELOG.md already has a section for 7.0.0",
        "CHANGELOG.md: the section '## Unreleased' is empty",
    ]


@pytest.mark.parametrize("version", ["1", "v1.0.0", "1.0", "1.0.0.post1", "01.0.0", "1.0.0\n"])
def test_an_invalid_version_is_refused(version: str, checkout: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert release.main(["prepare", version], checkout) == 2
    assert "write one like 1.0.0" in capsys.readouterr().err


def test_a_tag_must_match_version_archive_and_changelog(checkout: Path, capsys: pytest.CaptureFixture[str]) -> None:
    version = release.read_version(checkout)
    assert release.main(["check", "v9.9.9"], checkout) == 2
    assert capsys.readouterr().err.splitlines() == [
        f"the tag is v9.9.9, but pyproject.toml has version {version}",
        f"tests/data/archives/{version} is missing: python -m tests.tools.archive {version}",
        f"CHANGELOG.md: there is no text under a heading '## {version} - YYYY-MM-DD'",
    ]
    release.main(["prepare", "7.0.0"], checkout)
    (checkout / "tests" / "data" / "archives" / "7.0.0").mkdir(parents=True)
    citation = checkout / "CITATION.cff"
    citation.write_text(citation.read_text().replace("version: 7.0.0", "version: 6.0.0"))
    changelog = (checkout / "CHANGELOG.md").read_text()
    (checkout / "CHANGELOG.md").write_text(changelog.replace("## Unreleased\n", "## Unreleased\n\n- Late.\n", 1))
    capsys.readouterr()
    assert release.main(["check", "v7.0.0"], checkout) == 2
    assert capsys.readouterr().err.splitlines() == [
        "CITATION.cff: the version is 6.0.0, and 7.0.0 in pyproject.toml",
        "CHANGELOG.md: '## Unreleased' is not empty, although its changes are part of this release",
    ]


def build(source: Path, folder: Path, **environment: str) -> dict[str, bytes]:
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder), str(source)]
    given = {**os.environ, "SOURCE_DATE_EPOCH": "1700000000", "HATCH_BUILD_NO_HOOKS": "true", **environment}
    done = subprocess.run(command, env=given, umask=int(environment["UMASK"], 8), capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.integration
def test_the_same_source_gives_the_same_bytes(tmp_path: Path) -> None:
    """Build twice; the folder, time stamps, time zone, umask, locale and hash seed differ."""
    one, other = copy_checkout(tmp_path / "one"), copy_checkout(tmp_path / "far" / "away" / "two")
    for number, path in enumerate(sorted(other.rglob("*"), reverse=True)):
        os.utime(path, (1_000_000_000 + number, 1_000_000_000 + number))
        path.chmod(0o700 if path.is_dir() else 0o600)
    first = build(one, tmp_path / "first", UMASK="022", TZ="UTC", LC_ALL="C.UTF-8", PYTHONHASHSEED="1")
    again = build(other, tmp_path / "again", UMASK="077", TZ="Asia/Tokyo", LC_ALL="C", PYTHONHASHSEED="2")
    assert len(first) == 2
    assert first.keys() == again.keys()
    assert {name for name in first if first[name] != again[name]} == set()


def test_only_publishing_jobs_have_write_permissions() -> None:
    workflow = read_yaml(WORKFLOW)
    assert workflow["permissions"] == {}
    permissions = {
        name: {scope for scope, access in job["permissions"].items() if access == "write"} for name, job in JOBS.items()
    }
    assert {name: granted for name, granted in permissions.items() if granted} == {
        "publish": {"id-token"}, "pages": {"pages", "id-token"}, "release": {"contents", "id-token", "attestations"},
    }  # fmt: skip
    text = WORKFLOW.read_text(encoding="utf-8")
    assert "secrets." not in text and "cache: pip" not in text
    assert JOBS["publish"]["if"] == "github.event_name == 'push'" and JOBS["publish"]["needs"] == ["test", "site"]
    assert all(JOBS[name]["needs"] == "publish" for name in ("release", "pages"))


def test_releases_are_tested_on_every_declared_python() -> None:
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    named = re.findall(r'"Programming Language :: Python :: (3\.\d+)"', project)
    assert JOBS["test"]["strategy"]["matrix"] == {"python": named, "form": ["whl", "tar.gz"]}


PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
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
    message = "PDF needs typst, which is not installed; install it with: pip install 'qdot-robotics[pdf]'"
    assert explain_missing("pdf", "PDF") == message


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


PROGRAM: Any = typer.main.get_command(make_program())
NAMES = [*COMMANDS, *(f"site {name}" for name in SITE_COMMANDS)]


def find_command(name: str) -> Any:
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
        ("qdot gen", ["generate"]), ("qdot ", [*COMMANDS, "serve", "site"]), ("qdot grade --di", ["--diff"]),
        ("qdot site ", ["build", "serve"]), ("qdot show scara", ["scara/1", "scara-rrrp/1", "scara-prrr/1"]),
        (
            "qdot show scara/1 --questions position,dete",
            ["position,determinant", "position,determinant-choice", "position,determinant-value"],
        ),
        ("qdot show scara/1 --variation full+to", ["full+tool"]), ("qdot solve pan", ["panda"]),
        ("qdot init homework --set sing", ["singularities"]), ("qdot export homework --to sc", ["scorm"]),
        ("qdot site build --families scara,elbow-l", ["scara,elbow-lateral"]),
        ("qdot solve ./ar", []),  # the shell completes files
    ],
)  # fmt: skip
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
