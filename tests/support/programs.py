"""Programs that only some tests need. If one is missing, the test is skipped and says what to install."""

import os
import shutil
from pathlib import Path

import pytest

from tests.support import ROOT

READERS = ROOT / ".venvs" / "readers"
"""A separate environment for programs that read exports."""
READER = "make .venvs/readers/.installed"
MAXIMA = "apt-get install maxima maxima-share, or brew install maxima"
GIT = "apt-get install git, or brew install git"
GH = "apt-get install gh, or brew install gh"
POPPLER = "apt-get install poppler-utils, or brew install poppler"
CHROMIUM = "apt-get install chromium"
LATEX = "apt-get install texlive-pictures texlive-latex-extra"
ACTIONLINT = f"{READER}, go install github.com/rhysd/actionlint/cmd/actionlint@latest, or brew install actionlint"


def require_program(program: str, how: str, in_ci: bool = True) -> str:
    """Return the path of a program on PATH or in the readers' environment.

    If it is missing, skip the test; in CI, fail the test if `in_ci`.
    """
    path = shutil.which(program) or shutil.which(program, path=str(READERS / "bin"))
    return path if path is not None else _missing(program, how, in_ci)


def require_reader(program: str, library: str | None = None) -> str:
    """Return the path of a program in the readers' environment, which must also have `library` if it is not None."""
    path = READERS / "bin" / program
    if not path.exists() or (library and not list(READERS.glob(f"lib/python3*/site-packages/{library}"))):
        return _missing(library or Path(program).name, READER, True)
    return str(path)


def _missing(program: str, how: str, in_ci: bool) -> str:
    message = f"{program} is not installed: {how}"
    if in_ci and os.environ.get("CI"):
        pytest.fail(f"{message} (in CI its tests run)")
    pytest.skip(message)
