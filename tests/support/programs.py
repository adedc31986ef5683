"""Programs that only some tests need: where one is missing, each says in one line what to install, and is skipped."""

import os
import shutil
from pathlib import Path

import pytest

from tests.support import ROOT

READERS = ROOT / ".venvs" / "readers"
"""An environment of its own for programs that read exports."""
READER = "make .venvs/readers/.installed"
MAXIMA = "apt-get install maxima maxima-share, or brew install maxima"
GIT = "apt-get install git, or brew install git"
GH = "apt-get install gh, or brew install gh"
POPPLER = "apt-get install poppler-utils, or brew install poppler"
LATEX = "apt-get install texlive-pictures texlive-latex-extra"
ACTIONLINT = f"{READER}, go install github.com/rhysd/actionlint/cmd/actionlint@latest, or brew install actionlint"


def needs(program: str, how: str, in_ci: bool = True) -> str:
    """Return the path of a program, of the machine's or else of the readers'.

    Where it is missing the test is skipped, or fails in a CI that is to have it.
    """
    found = shutil.which(program) or shutil.which(program, path=str(READERS / "bin"))
    return found if found is not None else _missing(program, how, in_ci)


def reader(program: str, library: str | None = None) -> str:
    """Return the path of a program in the environment of readers, or of its Python that has a library."""
    path = READERS / "bin" / program
    if not path.exists() or (library and not list(READERS.glob(f"lib/python3*/site-packages/{library}"))):
        return _missing(library or Path(program).name, READER, True)
    return str(path)


def _missing(program: str, how: str, in_ci: bool) -> str:
    said = f"{program} is not installed: {how}"
    if in_ci and os.environ.get("CI"):
        pytest.fail(f"{said} (in CI its tests run)")
    pytest.skip(said)
