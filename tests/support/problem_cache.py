"""Generate problems once for all runs, and cache them on disk under a digest of the code in exercises/.

The cache is the folder `.kept` at the top of the checkout; you may remove it at any time. All problems are regenerated
after a change of Python, of SymPy, or of any module in exercises/. QDOT_KEPT=0 turns the cache off.

`python -m tests.support.problem_cache` uses all cores to generate what every run needs: for each family, a problem in
which everything varies. Then no test has to wait for it.
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

CACHE = ROOT / ".kept"
MAX_DIGESTS = 3
"""The number of digests that stay in the cache, from the latest runs."""


@cache
def get_cache_folder() -> Path | None:
    if os.environ.get("QDOT_KEPT") == "0":
        return None
    digest = hashlib.sha256(repr((sys.version, sp.__version__, np.__version__, mpmath.__version__)).encode())
    for path in sorted(path for suffix in ("py", "txt", "json") for path in (ROOT / "exercises").rglob(f"*.{suffix}")):
        digest.update(path.read_bytes())
    folder = CACHE / digest.hexdigest()[:20]
    folder.mkdir(parents=True, exist_ok=True)
    os.utime(folder)
    for old_folder in sorted(CACHE.iterdir(), key=lambda path: path.stat().st_mtime)[:-MAX_DIGESTS]:
        shutil.rmtree(old_folder, ignore_errors=True)
    return folder


def _get_cache_path(identity: ProblemId) -> Path | None:
    folder = get_cache_folder()
    name = f"{identity.family}-{identity.seed}-{identity.variation}{identity.convention}{identity.twist_order}.pickle"
    return None if folder is None else folder / name


def load_problem(identity: ProblemId) -> Problem:
    """Return a problem with all its questions from the cache; generate and cache it if it is not there."""
    path = _get_cache_path(identity)
    if path is None:
        return generate(identity)
    if path.exists():
        problem: Problem = pickle.loads(path.read_bytes())
        return problem
    problem = generate(identity)
    write_atomically(path, pickle.dumps(problem))
    return problem


def cache_problems(identities: Sequence[ProblemId]) -> int:
    paths = {identity: _get_cache_path(identity) for identity in identities}
    missing = [identity for identity, path in paths.items() if path is not None and not path.exists()]
    if missing:
        with Pool() as pool:
            for _ in pool.imap_unordered(load_problem, missing):
                pass
    return len(missing)


if __name__ == "__main__":
    # In reverse, because arms with six and seven joints take longest and are registered last.
    count = cache_problems([ProblemId(family, 0, variation="full") for family in reversed(FAMILIES)])
    print(f"{count} problems were generated for the tests, and {len(FAMILIES) - count} were cached")
