"""Commands that run no student code work without POSIX, as on Windows; the others say so in one sentence.

A stand-in (`tests/support/windows`) removes what Windows lacks. CI runs the same tests on Windows itself.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import Student
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.grader.cli.main import COMMANDS
from tests.support import ROOT
from tests.support.command import run as run_here
from tests.support.submitting import make_class, make_correct_notebook, read_folder, submit

STAND_IN = ROOT / "tests" / "support" / "windows"
ON_WINDOWS = sys.platform == "win32"
NEEDS_SCRIPTS = pytest.mark.skipif(
    not (ROOT / "site" / "dist").is_dir(), reason="the site's scripts are not built: make site"
)


def run(*arguments: str | Path, code: int = 0, encoding: str = "") -> tuple[str, str]:
    """Run a command without POSIX; opening a file in the system's encoding is an error."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONWARNDEFAULTENCODING": "1"}
    if not ON_WINDOWS:
        environment["PYTHONPATH"] = f"{STAND_IN}{os.pathsep}{ROOT}"
    if encoding:
        environment["PYTHONIOENCODING"] = encoding
    warnings = ("-W", "error::EncodingWarning:exercises", "-W", "error::EncodingWarning:grader")
    command = [sys.executable, *warnings, "-m", "qdot", *map(str, arguments)]
    process = subprocess.run(command, env=environment, capture_output=True, cwd=ROOT, timeout=600)
    output, errors = process.stdout.decode("utf-8"), process.stderr.decode("utf-8", "replace")
    assert process.returncode == code, f"{arguments}: {output}{errors}"
    assert "Traceback" not in errors
    return output, errors


@pytest.mark.skipif(ON_WINDOWS, reason="Windows needs no stand-in")
def test_the_stand_in_has_no_posix(tmp_path: Path) -> None:
    program = """
import importlib, multiprocessing, os, signal, sys
for name in ("fcntl", "resource", "pwd", "termios"):
    try:
        importlib.import_module(name)
    except ImportError:
        continue
    sys.exit(f"{name} is there")
assert not any(hasattr(os, name) for name in ("fork", "geteuid", "getuid")) and not hasattr(signal, "setitimer")
assert multiprocessing.get_all_start_methods() == ["spawn"]
for refused in (lambda: os.open(".", os.O_RDONLY), lambda: open("a:b", "w"), lambda: os.replace(kept.name, "x")):
    kept = open("kept", "w")
    try:
        refused()
    except OSError:
        continue
    sys.exit("a name, a folder or an open file is not refused")
"""
    environment = {**os.environ, "PYTHONPATH": str(STAND_IN)}
    subprocess.run([sys.executable, "-c", program], env=environment, cwd=tmp_path, check=True)


PROCESS_MODULES = (
    "qdot.exercises.assignment.release",
    *(f"qdot.grader.{name}" for name in ("grading.certify", "grading.batch", "reports.graded_folder")),
)
"""The modules that a command's processes load."""


def test_every_command_and_its_processes_can_be_loaded() -> None:
    """A module that needs POSIX at import would end every command that loads it."""
    names = sorted({*COMMANDS.values(), "qdot.grader.cli.site_commands", *PROCESS_MODULES})
    program = f"import importlib; [importlib.import_module(name) for name in {names}]"
    environment = {**os.environ, "PYTHONPATH": str(ROOT) if ON_WINDOWS else f"{STAND_IN}{os.pathsep}{ROOT}"}
    process = subprocess.run([sys.executable, "-c", program], env=environment, cwd=ROOT, capture_output=True, text=True)
    assert process.returncode == 0, process.stderr


@pytest.mark.integration
def test_problems_are_shown_solved_verified_and_compared() -> None:
    output, _ = run("show", "polar-rp/1", "--solution")
    assert "θ" in output, "a pipe is UTF-8, whatever the system's encoding is"
    assert "?" in run("show", "polar-rp/1", encoding="ascii")[0]
    assert json.loads(run("show", "polar-rp/1", "--format", "json")[0])["id"] == "polar-rp/1"
    assert "determinant" in run("solve", ROOT / "tests/data/archives/unreleased/arm.toml")[0].lower()
    assert "1 problem verified, 0 failed" in run("verify", "polar-rp/1")[0]
    assert json.loads(run("compare", "a1*a2*s2", "a1*a2*sin(theta2)")[0])["outcome"] == "correct"


@pytest.mark.integration
def test_a_time_limit_ends_a_derivation() -> None:
    """Windows has no system timer for it."""
    output, _ = run("solve", "panda", "--time", "0.1", "--format", "json")
    assert json.loads(output)["missing"]


REFUSED = "qdot can't sandbox student code on Windows, so it does not run any. Use the container"


@pytest.mark.integration
def test_commands_that_run_student_code_are_refused(tmp_path: Path) -> None:
    assignment = make_class(tmp_path / "hw", [Student("ada")])
    notebook = submit(assignment, "ada/hw.ipynb", make_correct_notebook(assignment, "ada"))
    for command, path in (("grade", assignment.folder), ("check", notebook), ("demo", tmp_path / "demo")):
        output, errors = run(command, path, code=2)
        assert errors.startswith(f"qdot: {REFUSED}") and len(errors.splitlines()) == 1 and not output
    assert not (tmp_path / "demo").exists() and not (assignment.folder / "graded" / "results.jsonl").exists()
    report = json.loads(run("doctor", "--json")[0])
    assert not report["strict"] and {guarantee["by"] for guarantee in report["guarantees"]} == {"missing"}
    assert REFUSED in run("doctor")[0]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a class that is generated here and was graded elsewhere."""
    assignment = make_class(tmp_path_factory.mktemp("windows") / "hw", [Student("ada", "Ädä"), Student("bo")])
    elsewhere = shutil.copytree(assignment.folder, assignment.folder.parent / "elsewhere")
    run("generate", assignment.folder, "--jobs", "2")
    if not ON_WINDOWS:
        submit(assignment, "ada/hw.ipynb", make_correct_notebook(assignment, "ada"))
        run_here("grade", assignment.folder, "--jobs", "1")
        run_here("generate", elsewhere, "--jobs", "1")
    return assignment.folder


@pytest.mark.integration
class TestClass:
    @pytest.mark.skipif(ON_WINDOWS, reason="there is nothing to compare with")
    def test_generate_writes_the_same_notebooks(self, folder: Path) -> None:
        for kind in ("released", "solutions", "certificates"):
            assert read_folder(folder / kind) == read_folder(folder.parent / "elsewhere" / kind)

    def test_verify_passes_and_generate_keeps_notebooks(self, folder: Path) -> None:
        assert "2 problems verified, 0 failed" in run("verify", folder, "--jobs", "1")[0]
        assert "2 kept" in run("generate", folder)[0]

    @pytest.mark.parametrize(
        "export_format",
        [pytest.param(name, marks=NEEDS_SCRIPTS if name == "scorm" else ()) for name in sorted(EXPORT_FORMATS)],
    )
    def test_every_export_format_is_written(self, folder: Path, export_format: str) -> None:
        options = ("--variants", "1", "--jobs", "1", "--out", folder.parent / export_format)
        run("export", folder, "--to", export_format, *options)
        assert list((folder.parent / export_format).iterdir())

    @pytest.mark.skipif(ON_WINDOWS, reason="nothing is graded here")
    def test_reports_are_written(self, folder: Path) -> None:
        run("report", folder)
        run("report", folder, "--report", f"xlsx={folder / 'grades.xlsx'}")
        assert (folder / "grades.xlsx").stat().st_size > 1000

    @NEEDS_SCRIPTS
    def test_the_site_is_built(self, tmp_path: Path) -> None:
        run("site", "build", "--families", "polar-rp", "--variants", "1", "--jobs", "2", "--out", tmp_path / "site")
        assert (tmp_path / "site" / "practice.html").exists()
