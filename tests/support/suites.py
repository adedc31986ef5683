"""The three suites, `make check`, `make test` and `make whole`: which families and how many problems each looks at.

A sweep takes every family in `make whole`. In `make test` it takes one of every fourth shape (`SHAPES`) and a sixteenth
of the other families, in `make check` one. A test that takes long (`seconds.json`) has its turn in `make test` every
third or seventh day, or is left to `make whole`, unless it is among `DAILY` or tests what is not committed yet. So do
all tests of a group (`xdist_group`), which is one of what they share, where that takes long to make. What has its turn
changes from test to test and from day to day. QDOT_ROTATION, which a run prints, repeats a draw; QDOT_SUITE is the
suite.
"""

import json
import os
import shutil
import subprocess
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import TypeVar
from zlib import crc32

import pytest

from exercises.arm.chain import Chain
from exercises.families import FAMILIES
from exercises.figure.plane import is_flat
from tests.support import ROOT
from tests.support.imports import imports, name_of

Some = TypeVar("Some")

SUITES = ("check", "test", "whole")
SUITE = os.environ.get("QDOT_SUITE") or "test"
assert SUITE in SUITES, f"QDOT_SUITE={SUITE}: it is one of {', '.join(SUITES)}"
WHOLE = SUITE == "whole"
# Set for the workers of a run, too, lest it changes at midnight.
ROTATION = int(os.environ.setdefault("QDOT_ROTATION", str(datetime.now(UTC).toordinal())))
SHARE = 16
"""One in so many of the families that stand for no shape is taken by a sweep of `make test`."""
SHAPES_SHARE = 4
"""One in so many of those that stand for a shape is."""
TURNS = ((0.6, 1), (1.6, 3), (6.0, 7))
"""Tests that take fewer seconds have their turn every so many days; what takes more is left to `make whole`.

The days have no divisor in common with those of families: every test sees every family some day.
"""
SECONDS: dict[str, float] = json.loads((ROOT / "tests" / "support" / "seconds.json").read_text(encoding="utf-8"))
"""How long tests take: means over parameters, what is long with some, and what a group shares (`@group`).

By `python -m tests.tools.seconds`.
"""
DAILY = (
    "exercises/docs/test_docs.py::test_pages_are_up_to_date", "tools/test_site_corpus.py", "grader/contained/",
    "repository/test_structure.py", "repository/test_suites.py", "repository/test_readme.py",
    "repository/test_schemas.py", "repository/test_library.py", "repository/test_wheel.py::test_the_wheel",
    "repository/test_wheel.py::test_every_", "repository/test_windows.py::test_every_command", "grader/test_class.py",
    "grader/test_cli.py::test_generate_grade_and_check", "exercises/quizzes/test_quizzes.py::test_what_an_id_is_asked",
)  # fmt: skip
"""Beginnings of tests that have no turns: what is forgotten most often, and what must never break."""

SHAPES = {
    "planar, square": "planar-2r", "planar, not square": "planar-3r", "planar, with slides": "polar-rp",
    "spatial, square": "elbow-3r", "spatial, not square": "pan-tilt", "spatial, with slides": "scara",
    "wrist": "wrist-zyz", "six joints": "stanford-6r", "seven joints": "lbr-7r", "random": "random-3",
}  # fmt: skip
"""A family that stands for each shape."""


def shape_of(chain: Chain, is_random: bool) -> str:
    """Return the shape of a family's arm, in the words of SHAPES."""
    if is_random:
        return "random"
    if chain.n >= 6:
        return "six joints" if chain.n == 6 else "seven joints"
    if all(row.startswith("w") for row in chain.task):
        return "wrist"
    where = "planar" if is_flat(chain) else "spatial"
    if any(joint.kind == "P" for joint in chain.joints):
        return f"{where}, with slides"
    return f"{where}, square" if len(chain.task) == chain.n else f"{where}, not square"


def several(few: Some, all_of_them: Some) -> Some:
    """Return how many problems of a family a test draws, or which: `few`, or all in `make whole`."""
    return all_of_them if WHOLE else few


def in_turn(test: str, name: str, each: int) -> bool:
    """Whether it is a family's turn, which comes to every one of `each` days for a test."""
    return (crc32(f"{test} {name}".encode()) + ROTATION) % each == 0


def families_for(test: str, among: Iterable[str] = tuple(FAMILIES)) -> list[str]:
    """Return those of some families that a test by this name looks at, at least one."""
    names = list(among)
    if WHOLE or not names:
        return names
    if SUITE == "check":
        return [names[(crc32(test.encode()) + ROTATION) % len(names)]]
    shapes = SHAPES.values()
    taken = [name for name in names if in_turn(test, name, SHAPES_SHARE if name in shapes else SHARE)]
    return taken or [names[(crc32(test.encode()) + ROTATION) % len(names)]]


def has_its_turn(path: Path, nodeid: str, group: str) -> bool:
    """Whether `make test` runs a test today: one that takes seconds, or a group that does, is run every few days."""
    nodeid = nodeid.removesuffix(f"@{group}")
    test, _, parameters = nodeid.partition("[")
    if test.removeprefix("tests/").startswith(DAILY) or path in tests_of(uncommitted()):
        return True
    shared, own = SECONDS.get(f"@{group}", 0.0), SECONDS.get(nodeid, SECONDS.get(test, 0.0))
    days = next((days for most, days in TURNS if max(shared, own) < most), None)
    if shared > own:
        test, parameters = group, ""
    return days is not None and in_turn(test, parameters, days)


def few_for(test: str, among: Iterable[str], most: int) -> list[str]:
    """Return so many of some families, the next ones of them each day; in `make whole` all, in `make check` one."""
    names = sorted(among, key=lambda name: crc32(name.encode()))
    count, first = 1 if SUITE == "check" else most, crc32(test.encode()) + ROTATION * most
    return names if WHOLE else [names[(first + k) % len(names)] for k in range(min(count, len(names)))]


def of_families(names: Sequence[str]) -> pytest.MarkDecorator:
    """Have a test, whose argument is `family`, look at these families, as many of them as the suite allows."""
    return pytest.mark.families(tuple(names))


every_family = pytest.mark.families(tuple(FAMILIES), every=True)
"""Have a test look at every family in `make test`, too: what is quick, or holds everything."""


def told(left: int, families: int, in_turn: int = 0) -> list[str]:
    """Return the lines at the end of a run: what it left out, and which command runs it."""
    if SUITE == "whole":
        return ["make whole: nothing is left out but what is skipped above"]
    repeats = f"QDOT_ROTATION={ROTATION} make {SUITE} repeats this draw"
    lines = [
        f"make {SUITE} left out {left} tests, {in_turn} that take seconds and have their turn on another day, and of",
        f"sweeps over families {families} families ({repeats});",
        "`make whole` runs them all, with more problems of each family",
    ]
    return [*lines, "`make test` runs every test that takes seconds"] if SUITE == "check" else lines


few_families = pytest.mark.families(tuple(FAMILIES), most=5)
"""Have a test look at five families in `make test`, others each day: what takes long, and is the same for all arms."""


def grouped(names: Iterable[str]) -> list[object]:
    """Return families as parameters; the tests of one run in one process, which works its structures out once."""
    return [pytest.param(name, marks=pytest.mark.xdist_group(name)) for name in names]


# --- make check ---

ALWAYS = (
    "exercises/arm/test_derivation.py", "exercises/formula/test_identity.py", "exercises/mistakes/test_catalogue.py",
    "exercises/questions/test_questions.py::test_what_an_id_regenerates_has_not_changed",
    "exercises/questions/test_questions.py::test_answers_are_well_formed",
    "exercises/quizzes/test_quizzes.py::test_what_an_id_is_asked_has_not_changed",
    "exercises/verify/test_verify.py::test_every_reference_passes", "exercises/writing/test_statement.py",
    "exercises/test_languages.py", "exercises/exports/test_exports.py::test_every_outlet_writes_the_same_files_twice",
    "grader/test_formulas.py", "grader/test_reasons.py", "grader/test_loop.py",
    "grader/reports/test_reports.py::test_junit",
    "grader/reports/test_reports.py::test_classroom50", "grader/contained/test_sandbox.py::test_values_leave_as_text",
    "grader/test_cli.py::test_help", "grader/test_cli.py::test_show_in_every_format",
    "grader/test_cli.py::test_solve_prints_example_63", "grader/test_cli.py::test_generate_grade_and_check",
    "repository/test_structure.py", "repository/test_suites.py",
)  # fmt: skip
"""What `make check` always runs, files or beginnings of tests: an example of every family, question, mistake, outlet,
language and format, and of grading."""

BESIDE = {
    "exercises/locale/": ("exercises/test_languages.py",),
    "site/src/text/": ("exercises/test_languages.py",),
    "templates/": ("exercises/writing/test_statement.py", "exercises/test_languages.py"),
    "templates/exports/": ("exercises/exports",),
    "templates/questions/": ("exercises/questions/test_questions.py", "exercises/writing/test_hints.py"),
    "templates/feedback": ("grader/reports/test_feedback.py",),
    "templates/site": ("exercises/site",),
    "exercises/formula/vocabulary.json": ("exercises/formula", "tools/test_readers.py", "tools/test_site_corpus.py"),
    "site/src/read/": ("tools/test_readers.py",), "site/src/grade/": ("tools/test_readers.py",),
    "docs/": ("exercises/docs", "repository/test_schemas.py"),
    "README.md": ("repository/test_readme.py",),
    "pyproject.toml": ("repository/test_wheel.py",),
    "action.yml": ("repository/test_action.py",), "templates/grade.yml": ("repository/test_action.py",),
    "templates/check.yml": ("repository/test_action.py",), "docs/examples/": ("repository/test_action.py",),
    "docs/ci.md": ("repository/test_action.py",),
    ".github/workflows/release.yml": ("repository/test_release.py",),
    "Containerfile": ("repository/test_container.py",),
    ".dockerignore": ("repository/test_container.py",),
    "docs/container.md": ("repository/test_container.py",),
}  # fmt: skip
"""The tests of what is no module of Python, by how its path begins."""
MOST_IMPORTERS = 6
"""A module that more files of tests import is tested by those called like it only."""


def in_check(path: Path, nodeid: str) -> bool:
    """Whether `make check` runs a test of a file."""
    return path in changed_tests() or nodeid.removeprefix("tests/").startswith(ALWAYS)


def file_in_check(path: Path) -> bool:
    """Whether `make check` runs anything in a file."""
    return path in changed_tests() or any(ROOT / "tests" / name.partition("::")[0] == path for name in ALWAYS)


@cache
def changed_tests() -> frozenset[Path]:
    """Return the files of tests for what was changed: since QDOT_SINCE, else since the last commit, else in it."""
    return tests_of(uncommitted() or tuple(_git("diff", "--name-only", "HEAD~1")))


@cache
def uncommitted() -> tuple[str, ...]:
    """Return the files that were changed and not committed, or since QDOT_SINCE."""
    since = os.environ.get("QDOT_SINCE", "HEAD")
    return (*_git("diff", "--name-only", since), *_git("ls-files", "--others", "--exclude-standard"))


@cache
def tests_of(changed: tuple[str, ...]) -> frozenset[Path]:
    """Return the files of tests for some files of the checkout."""
    return frozenset(path for name in changed for path in covering(name))


def _git(*arguments: str) -> list[str]:
    if shutil.which("git") is None:
        return []
    done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True)
    return done.stdout.splitlines()


@cache
def _test_files() -> list[Path]:
    return sorted((ROOT / "tests").rglob("test_*.py"))


def covering(name: str) -> set[Path]:
    """Return the files of tests for a file of the checkout: those called like it, and those that import it.

    Where there are none, as for a helper of other modules, all in the folder that mirrors its own.
    """
    path, tests = ROOT / name, ROOT / "tests"
    if path in _test_files():
        return {path}
    if path.suffix == ".py" and path.is_file():
        folder = tests / Path(name).parent
        stems = {path.stem, path.parent.name} if path.stem == "__init__" else {path.stem}
        like = {test for test in _test_files() if test.parent == folder and test.stem.removeprefix("test_") in stems}
        by = {test for test in _test_files() if name_of(path) in imports(test)}
        doctests = {path} if ">>>" in path.read_text(encoding="utf-8") else set()
        found = like | (by if len(by) <= MOST_IMPORTERS else set())
        return doctests | (found or {test for test in _test_files() if test.parent == folder})
    beside = [tests / other for begin, others in BESIDE.items() if name.startswith(begin) for other in others]
    return {test for test in _test_files() if any(test == other or other in test.parents for other in beside)}
