"""Problems that are generated once for all runs: kept on disk under a digest of the code that made them.

In `.kept` at the top of the checkout, which may be removed at any time. A change of any module that
`exercises.generation` imports, of Python or of SymPy has them generated anew. QDOT_KEPT=0 keeps nothing.
"""

import hashlib
import os
import pickle
import shutil
import sys
from functools import cache
from pathlib import Path

import mpmath
import numpy as np
import sympy as sp

from exercises.files import write_atomically
from exercises.generation import generate
from exercises.problem import Problem, ProblemId
from tests.support import ROOT
from tests.support.imports import reached

KEPT = ROOT / ".kept"
MOST = 3
"""Digests of which problems are kept: those of the latest runs."""


@cache
def folder() -> Path | None:
    """Return where problems made by this code are kept; None where nothing is to be kept."""
    if os.environ.get("QDOT_KEPT") == "0":
        return None
    digest = hashlib.sha256(repr((sys.version, sp.__version__, np.__version__, mpmath.__version__)).encode())
    data = [path for kind in ("txt", "json") for path in (ROOT / "exercises").rglob(f"*.{kind}")]
    for path in sorted({*reached(["exercises.generation"]), *data}):
        digest.update(path.read_bytes())
    made = KEPT / digest.hexdigest()[:20]
    made.mkdir(parents=True, exist_ok=True)
    os.utime(made)
    for old in sorted(KEPT.iterdir(), key=lambda path: path.stat().st_mtime)[:-MOST]:
        shutil.rmtree(old, ignore_errors=True)
    return made


def kept(identity: ProblemId) -> Problem:
    """Return a problem with all its questions, as it was kept, else generated and kept."""
    here = folder()
    if here is None:
        return generate(identity)
    path = here / f"{identity.family}-{identity.seed}-{identity.variation}.pickle"
    if path.exists():
        problem: Problem = pickle.loads(path.read_bytes())
        return problem
    problem = generate(identity)
    write_atomically(path, pickle.dumps(problem))
    return problem
