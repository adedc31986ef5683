"""What a run says where a program that it needs is not there: at once, and why."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.platforms.gradescope import _certificates
from tests.platforms.notebooks import KEY, RIGHT, a_class
from tests.platforms.prairielearn import _need
from tests.platforms.repositories import Class, counts
from tests.support.hosting import serving


def test_prairielearns_python_has_to_import_what_its_questions_call() -> None:
    _need(Path(sys.executable), "grader.marking")
    with pytest.raises(subprocess.CalledProcessError):
        _need(Path(sys.executable), "grader.marking", "prairielearn.that.is.not.here")


def test_a_job_that_left_no_marks_tells_why(tmp_path: Path) -> None:
    assignment = a_class(tmp_path / KEY, RIGHT)
    with serving(tmp_path / "server") as server:
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
