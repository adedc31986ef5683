"""Problems that are generated once for all runs: kept on disk under a digest of the code that made them.

In `.kept` at the top of the checkout, which may be removed at any time. A change of any module that
`qdot.exercises.generation` imports, of Python or of SymPy has them generated anew. QDOT_KEPT=0 keeps nothing.

`python -m tests.support.kept` generates what every run asks for, a problem of each family in which everything varies,
on all cores: no test has to wait for it then.
"""

import hashlib
import os
import pickle
import shutil
import sys
from collections.abc import Sequence
from functools import cache
from multiprocessing import Pool
from pathlib import Path

import mpmath
import numpy as np
import sympy as sp

from qdot.exercises.common.files import write_atomically
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate
from qdot.exercises.problem.problem import Problem, ProblemId
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
    for path in sorted({*reached(["qdot.exercises.generation"]), *data}):
        digest.update(path.read_bytes())
    made = KEPT / digest.hexdigest()[:20]
    made.mkdir(parents=True, exist_ok=True)
    os.utime(made)
    for old in sorted(KEPT.iterdir(), key=lambda path: path.stat().st_mtime)[:-MOST]:
        shutil.rmtree(old, ignore_errors=True)
    return made


def _path(identity: ProblemId) -> Path | None:
    here = folder()
    return (
        None
        if here is None
        else here
        / f"{identity.family}-{identity.seed}-{identity.variation}{identity.convention}{identity.twist_order}.pickle"
    )


def kept(identity: ProblemId) -> Problem:
    """Return a problem with all its questions, as it was kept, else generated and kept."""
    path = _path(identity)
    if path is None:
        return generate(identity)
    if path.exists():
        problem: Problem = pickle.loads(path.read_bytes())
        return problem
    problem = generate(identity)
    write_atomically(path, pickle.dumps(problem))
    return problem


def keep(identities: Sequence[ProblemId]) -> int:
    """Generate and keep those problems that are not kept yet, on all cores, and return how many that were."""
    missing = [one for one in identities if (path := _path(one)) is not None and not path.exists()]
    if missing:
        with Pool() as pool:
            for _ in pool.imap_unordered(kept, missing):
                pass
    return len(missing)


if __name__ == "__main__":
    # From the last: six and seven joints take longest, and are registered behind the others.
    made = keep([ProblemId(family, 0, variation="full") for family in reversed(FAMILIES)])
    print(f"{made} problems were generated for the tests, and {len(FAMILIES) - made} were there")
