"""The built wheel, installed in a fresh environment with its declared dependencies only.

In a checkout, a file missing from the wheel or an undeclared library goes unnoticed.
"""

import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
import venv
import zipfile
from collections.abc import Callable
from importlib.metadata import distribution, distributions
from pathlib import Path
from unittest.mock import Mock

import pytest
from packaging.requirements import Requirement

from tests.support import ROOT
from tests.support.suites import WHOLE

# All tests in this module share one pytest-xdist worker, which builds the wheel and the environment once.


def run(*command: str | Path, cwd: Path) -> str:
    """Run a command without this environment's Python settings; return its standard output, or fail with all output."""
    env = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    env["HATCH_BUILD_NO_HOOKS"] = "true"  # the site's scripts take a minute to build
    process = subprocess.run([str(word) for word in command], cwd=cwd, env=env, capture_output=True, encoding="utf-8")
    if process.returncode != 0:
        pytest.fail(
            f"{' '.join(map(str, command))}: exit code {process.returncode}\n{process.stdout}\n{process.stderr}"
        )
    return process.stdout


def link_or_copy(source: str, target: str) -> None:
    try:
        os.link(source, target)
    except OSError:
        shutil.copy2(source, target)


def install_requirements(requirements: list[str], site: Path) -> set[str]:
    """Copy the installed distributions of these requirements, and of their requirements, into `site`."""
    installed: set[str] = set()
    waiting = [(Requirement(line), "") for line in requirements]
    while waiting:
        requirement, extra = waiting.pop()
        if requirement.marker and not requirement.marker.evaluate({"extra": extra}):
            continue
        package = distribution(requirement.name)
        waiting += [
            (Requirement(line), requested_extra)
            for line in package.requires or ()
            for requested_extra in (requirement.extras or {""})
        ]
        if requirement.name in installed:
            continue
        installed.add(requirement.name)
        assert requirement.specifier.contains(package.version, prereleases=True), (
            f"{requirement}: {package.version} is installed"
        )
        for file in package.files or ():
            if file.parts[0] != ".." and not (site / file).exists():
                (site / file).parent.mkdir(parents=True, exist_ok=True)
                link_or_copy(str(file.locate()), str(site / file))
    return installed


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the wheel from this checkout. `make whole` builds it from the source distribution instead."""
    folder, form = tmp_path_factory.mktemp("dist"), [] if WHOLE else ["--wheel"]
    run(sys.executable, "-m", "build", "--no-isolation", *form, "--outdir", folder, ROOT, cwd=folder)
    (path,) = folder.glob("qdot_robotics-*.whl")
    return path


@pytest.fixture(scope="module")
def home(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    home = tmp_path_factory.mktemp("fresh")
    venv.create(home, with_pip=False, symlinks=True)
    python = home / "bin" / "python"
    pip = (sys.executable, "-m", "pip", "--python", python, "--disable-pip-version-check")
    run(*pip, "install", "--no-index", "--no-deps", "--no-compile", wheel, cwd=home)
    (site,) = home.glob("lib/python3.*/site-packages")
    (qdot,) = distributions(name="qdot-robotics", path=[str(site)])
    assert {"sympy", "typer"} <= install_requirements(qdot.requires or [], site)
    return home


def run_qdot(home: Path, *arguments: str | Path, cwd: Path) -> str:
    return run(home / "bin" / "qdot", *arguments, cwd=cwd)


def list_files(folder: str, pattern: str = "*") -> set[str]:
    files = (path for path in (ROOT / folder).rglob(pattern) if path.is_file() and "__pycache__" not in path.parts)
    return {path.relative_to(ROOT / folder).as_posix() for path in files}


def test_the_wheel_contains_all_modules_data_templates_docs_and_scripts_and_nothing_else(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    assert {"qdot"} == {name.split("/")[0] for name in names if ".dist-info/" not in name}
    assert [name for name in names if name.endswith("licenses/LICENSE")]
    modules = {f"qdot/{top}/{path}" for top in ("exercises", "grader") for path in list_files(top, "*.py")}
    assert {name for name in names if name.endswith(".py")} == modules | {"qdot/__init__.py", "qdot/__main__.py"}
    data = {path for kind in ("txt", "json", "po") for path in list_files("exercises", f"*.{kind}")}
    pages = {f"qdot/exercises/site_docs/{path.name}" for path in (ROOT / "docs").glob("*.md")}
    assert data and pages and {f"qdot/exercises/{path}" for path in data} | pages <= names
    for folder, packed in (("templates", "templates"), ("site/dist", "site_dist")):
        there = {f"qdot/exercises/{packed}/{path}" for path in list_files(folder)}
        assert there == {name for name in names if name.startswith(f"qdot/exercises/{packed}/")}
        assert there or folder == "site/dist"


PROGRAM = """
import sys
import sympy
from qdot import exercises, grader
from qdot.grader.cli.main import app
print(exercises.__file__, grader.__file__, sympy.__file__, sep="\\n")
for arguments in (["--version"], ["families", "--json"],
                  ["show", "planar-2r/7", "--questions", "position,jacobian", "--solution", "--format", "json"]):
    print("=====")
    try:
        app(arguments)
    except SystemExit as left:
        assert not left.code
sys.modules["babel"] = None  # not a dependency: only `make messages` needs it
from qdot.exercises.writing.languages import load_catalogue
print("=====")
print(load_catalogue("de").gettext("the world frame"))
"""


@pytest.fixture(scope="module")
def outputs(home: Path, tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Return what one process with the wheel prints: the origins of modules, then the output of some commands."""
    return run(home / "bin" / "python", "-c", PROGRAM, cwd=tmp_path_factory.mktemp("elsewhere")).split("=====\n")


@pytest.mark.integration
def test_commands_run_from_the_wheel_alone(outputs: list[str], home: Path, wheel: Path) -> None:
    places = outputs[0].splitlines()
    assert len(places) == 3 and all(Path(place).is_relative_to(home) for place in places)
    assert wheel.name.split("-")[1] in outputs[1]
    assert "planar-2r" in json.dumps(json.loads(outputs[2]))
    shown = json.loads(outputs[3])
    assert shown["id"] == "planar-2r/7" and len(shown["parts"]) == 2
    assert all(part["reference"] for part in shown["parts"])
    assert outputs[-1] == "Weltkoordinatensystem\n", "German is in the wheel, and loaded without Babel"


@pytest.mark.integration
def test_an_assignment_runs_from_init_to_full_marks(home: Path, tmp_path: Path) -> None:
    """A solution notebook submitted by a student gets every point."""
    course = tmp_path / "course"
    run_qdot(home, "init", course, cwd=tmp_path)
    toml = (course / "assignment.toml").read_text(encoding="utf-8")
    key = tomllib.loads(toml)["key"]
    (course / "roster.csv").write_text("student,name,email\nada,Ada Lovelace,ada@example.org\n", encoding="utf-8")

    run_qdot(home, "generate", course, cwd=tmp_path)
    notebook = f"{Path(key).stem}.ipynb"
    assert (course / "released" / "ada" / notebook).is_file()

    (course / "submitted" / "ada").mkdir(parents=True)
    shutil.copy(course / "solutions" / "ada" / notebook, course / "submitted" / "ada" / notebook)
    run_qdot(home, "grade", course, cwd=tmp_path)
    (line,) = (course / "graded" / "results.jsonl").read_text(encoding="utf-8").splitlines()
    result = json.loads(line)
    assert result["student"] == "ada"
    assert result["score"] == result["max_score"] > 0


COURSE_TEST = """
from exercises import OWNER as of_exercises
from grader import OWNER as of_grader
from tests import OWNER as of_tests

from qdot import Chain, Joint, certify, generate, grade_notebook, judge, mark, solve

def test_packages_of_the_course_are_its_own():
    assert of_exercises == of_grader == of_tests == "the course"
    assert generate("planar-2r/1", ["determinant"])
"""


@pytest.mark.integration
def test_a_course_may_have_packages_named_like_our_folders(home: Path, tmp_path: Path) -> None:
    (site,) = home.glob("lib/python3.*/site-packages")
    install_requirements(["pytest"], site)
    for name in ("exercises", "grader", "tests"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text('OWNER = "the course"\n')
    (tmp_path / "tests" / "test_course.py").write_text(COURSE_TEST)
    assert "1 passed" in run(home / "bin" / "python", "-m", "pytest", "-q", cwd=tmp_path)


@pytest.mark.integration
@pytest.mark.skipif(not (ROOT / "site" / "dist").is_dir(), reason="the site's scripts are not built here: make site")
def test_an_instructor_builds_the_site_without_node(home: Path, tmp_path: Path) -> None:
    site = tmp_path / "site"
    environment = {"PATH": str(home / "bin"), "HOME": str(tmp_path)}  # no Node, no npm
    command = [home / "bin" / "qdot", "site", "build", "--families", "polar-rp", "--variants", "1", "--out", site]
    process = subprocess.run([*map(str, command)], env=environment, cwd=tmp_path, capture_output=True, encoding="utf-8")
    assert process.returncode == 0, process.stderr
    for name in ("index.html", "practice.html", "examples/6-3.html", "arms.html", "docs/instructors.html"):
        page = (site / name).read_text(encoding="utf-8")
        for address in re.findall(r'<(?:script|link)[^>]* (?:src|href)="([^"]+)"', page):
            assert ((site / name).parent / address).is_file(), (name, address)


FAKE_NPM = """#!/bin/sh
echo "$*" >> "$NPM_CALLS"
test -z "$NPM_FAILS" || { echo "no registry" >&2; exit 1; }
test "$1" = ci || { mkdir -p dist/.vite && echo '{}' > dist/.vite/manifest.json; }
"""


@pytest.fixture
def build_scripts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., tuple[list[str], list[str]]]:
    """Return a function that runs the build hook in a small checkout; it returns npm's commands and the warnings."""
    loaded = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    assert loaded is not None and loaded.loader is not None
    module = importlib.util.module_from_spec(loaded)
    loaded.loader.exec_module(module)
    programs = tmp_path / "programs"
    programs.mkdir()
    (programs / "npm").write_text(FAKE_NPM)
    (programs / "npm").chmod(0o755)
    (tmp_path / "site" / "src").mkdir(parents=True)
    for name in ("package.json", "src/main.ts"):
        (tmp_path / "site" / name).write_text("{}")
    monkeypatch.setenv("NPM_CALLS", str(tmp_path / "calls"))

    def build(version: str = "standard", path: str = f"{programs}:/usr/bin:/bin") -> tuple[list[str], list[str]]:
        monkeypatch.setenv("PATH", path)
        (tmp_path / "calls").write_text("")
        app = Mock()
        module.SiteScriptsHook(str(tmp_path), {}, None, None, "", "wheel", app).initialize(version, {})
        return (tmp_path / "calls").read_text().splitlines(), [call.args[0] for call in app.display_warning.mock_calls]

    return build


def test_building_a_wheel_builds_the_sites_scripts_unless_they_are_current(
    build_scripts: Callable[..., tuple[list[str], list[str]]], tmp_path: Path
) -> None:
    assert build_scripts("editable") == ([], [])
    commands = ["ci --no-audit --no-fund", "run --silent bundle"]
    assert build_scripts() == (commands, [])
    assert build_scripts() == ([], [])
    os.utime(tmp_path / "site" / "src" / "main.ts", (2**32, 2**32))  # a source is newer than the scripts
    assert build_scripts() == (commands, [])


def test_a_wheel_without_the_sites_scripts_is_built_with_a_warning(
    build_scripts: Callable[..., tuple[list[str], list[str]]], monkeypatch: pytest.MonkeyPatch
) -> None:
    calls, (warning,) = build_scripts(path="/nowhere")
    assert not calls and "Node and npm are not installed" in warning
    monkeypatch.setenv("NPM_FAILS", "1")
    calls, (warning,) = build_scripts()
    assert len(calls) == 1 and "npm ci" in warning and "no registry" in warning
