"""A run that lacks a program reports at once what is missing and why it is needed."""

import hashlib
import json
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.platforms import jupyterlite
from tests.platforms.gradescope import _certificates
from tests.platforms.notebooks import KEY, RIGHT, a_class
from tests.platforms.prairielearn import _need
from tests.platforms.pyodide import LOCK, missing, needed, take
from tests.platforms.repositories import Class, counts
from tests.support.git_server import serve_repositories


@pytest.mark.whole
def test_prairielearns_python_has_to_import_what_its_questions_call() -> None:
    _need(Path(sys.executable), "qdot.grader.marking.marking")
    with pytest.raises(subprocess.CalledProcessError):
        _need(Path(sys.executable), "qdot.grader.marking.marking", "prairielearn.that.is.not.here")


def test_a_job_that_left_no_marks_tells_why(tmp_path: Path) -> None:
    assignment = a_class(tmp_path / KEY, RIGHT)
    with serve_repositories(tmp_path / "server") as server:
        own = Class(assignment, tmp_path, server, tmp_path)
        with pytest.raises(RuntimeError, match="rsync: command not found"):
            counts(own, tmp_path / "graded", "bash: rsync: command not found")


def test_gradescopes_container_trusts_the_registry_that_the_machine_trusts(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("PIP_CERT", raising=False)
    assert _certificates(tmp_path) == {}
    (tmp_path / "etc").mkdir()
    (tmp_path / "own.pem").write_text("of a proxy")
    monkeypatch.setenv("PIP_CERT", str(tmp_path / "own.pem"))
    (inside,) = _certificates(tmp_path).values()
    assert (tmp_path / inside.lstrip("/")).read_text() == "of a proxy"


PACKAGES = {
    name: {"file_name": f"{name}.whl", "sha256": hashlib.sha256(name.encode()).hexdigest(), "depends": depends}
    for name, depends in {"sympy": ["mpmath"], "mpmath": [], "ipython": ["prompt_toolkit"], "scipy": ["numpy"]}.items()
} | {"prompt-toolkit": {"file_name": "prompt.whl", "sha256": hashlib.sha256(b"prompt").hexdigest(), "depends": []}}


def test_jupyterlite_is_not_opened_with_a_pyodide_that_is_short_of_a_package(tmp_path: Path) -> None:
    assert sorted(needed(PACKAGES)) == ["ipython", "mpmath", "prompt-toolkit", "sympy"]
    folder = tmp_path / "pyodide"
    folder.mkdir()
    (folder / LOCK).write_text(json.dumps({"packages": PACKAGES}))
    for name in ("sympy", "mpmath", "ipython"):
        (folder / f"{name}.whl").write_text(name)
    assert missing(folder) == ["prompt.whl"]
    with pytest.raises(RuntimeError, match=r"prompt\.whl"):
        jupyterlite.run(tmp_path, tmp_path / "work")


def test_a_carried_wheel_is_taken_only_if_it_is_the_one_of_the_lock_file(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "carrier.whl", "w") as carrier:
        carrier.writestr("any/where/sympy.whl", "sympy")
        carrier.writestr("any/where/mpmath.whl", "another mpmath")
    take(tmp_path / "carrier.whl", tmp_path, needed(PACKAGES))
    assert (tmp_path / "sympy.whl").read_text() == "sympy"
    assert not (tmp_path / "mpmath.whl").exists()
