"""Choose the tests, families and problems of the three suites: `make check`, `make test` and `make whole`.

Only QDOT_SUITE, the name of the suite, chooses tests: a suite runs the same tests every day and on every machine. `make
whole` runs all tests, and runs those that depend on the arm on every family. `make test` leaves out tests marked
`whole` or `integration`, and uses the ten families of SHAPES. `make check` runs the tests of EXAMPLES, each on one
family.
"""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TypeVar

import pytest

from qdot.exercises.arm.chain import Chain
from qdot.exercises.families import FAMILIES
from qdot.exercises.figure.plane import is_drawn_flat
from tests.support import ROOT

Value = TypeVar("Value")

SUITES = ("check", "test", "whole")
SUITE = os.environ.get("QDOT_SUITE") or "test"
assert SUITE in SUITES, f"QDOT_SUITE={SUITE}: expected one of {', '.join(SUITES)}"
WHOLE = SUITE == "whole"

SHAPES = {
    "planar, square": "planar-2r", "planar, not square": "planar-3r", "planar, with prismatic joints": "polar-rp",
    "spatial, square": "elbow-3r", "spatial, not square": "pan-tilt", "spatial, with prismatic joints": "scara",
    "wrist": "wrist-zyz", "six joints": "stanford-6r", "seven joints": "lbr-7r", "random": "random-3",
}  # fmt: skip
"""The family that represents each shape of arm."""


def classify_shape(chain: Chain, is_random: bool) -> str:
    """Return the shape of a family's arm: a key of SHAPES."""
    if is_random:
        return "random"
    if chain.n >= 6:
        return "six joints" if chain.n == 6 else "seven joints"
    if all(row.startswith("w") for row in chain.task):
        return "wrist"
    space = "planar" if is_drawn_flat(chain) else "spatial"
    if bool(chain.prismatic_joints):
        return f"{space}, with prismatic joints"
    return f"{space}, square" if len(chain.task) == chain.n else f"{space}, not square"


def select_for_suite(value: Value, value_in_whole: Value) -> Value:
    """Return `value`, or in `make whole` `value_in_whole`."""
    return value_in_whole if WHOLE else value


def select_families(among: Iterable[str] = tuple(FAMILIES)) -> list[str]:
    """Return the families of `among` that the suite runs: all, or those in SHAPES, or only one, but at least one."""
    names = list(among)
    if WHOLE:
        return names
    shapes = [name for name in SHAPES.values() if name in names] or names[:1]
    return shapes[:1] if SUITE == "check" else shapes


def on_families(names: Sequence[str]) -> pytest.MarkDecorator:
    """Run a test with the argument `family` on each of these families that the suite runs."""
    return pytest.mark.families(tuple(names))


every_family = pytest.mark.families(tuple(FAMILIES), every=True)
"""Run a test on every family in `make test`, too: use it for quick tests only."""

FEW = ("polar-rp", "wrist-zyz")
few_families = pytest.mark.families(select_for_suite(FEW, tuple(SHAPES.values())), every=True)
"""Run a test on the families FEW, in `make whole` on SHAPES. Use it for slow tests that don't depend on the arm."""
few_or_all_families = pytest.mark.families(select_for_suite(FEW, tuple(FAMILIES)), every=True)
"""Run a test on the families FEW, in `make whole` on all. Use it for slow tests of texts or questions about an arm."""


def sample_for_suite(values: Iterable[Value], max_count: int) -> list[Value]:
    """Return at most `max_count` values, spread evenly; in `make whole` return all."""
    all_values = list(values)
    return all_values if WHOLE else all_values[:: -(-len(all_values) // max_count)]


def make_family_params(names: Iterable[str]) -> list[object]:
    """Return families as parameters. All tests of a family run in one process, so its structures are derived once."""
    return [pytest.param(name, marks=pytest.mark.xdist_group(name)) for name in names]


EXAMPLES = (
    "exercises/arm/test_kinematics.py", "exercises/formula/test_equality.py",
    "exercises/mistakes/test_catalogue.py::test_every_mistake_is_wrong_and_named[elbow-3r]",
    "exercises/questions/test_questions.py::test_id_regenerates_the_stored_problem",
    "exercises/questions/test_questions.py::test_answers_are_well_formed",
    "exercises/short_questions/test_quizzes.py::test_what_an_id_is_asked_has_not_changed",
    "exercises/verify/test_verify.py::test_every_reference_passes", "exercises/writing/test_problem_texts.py",
    "exercises/writing/test_languages.py",
    "exercises/exports/test_items.py::test_every_export_format_writes_the_same_files_twice",
    "grader/judging/test_formulas.py", "grader/grading/test_full_marks.py",
    "grader/reports/test_reports.py::test_junit",
    "grader/sandbox/test_sandbox.py::test_values_come_out_as_text",
    "grader/cli/test_cli.py::test_help", "grader/cli/test_cli.py::test_show_prints_the_same_twice",
    "grader/cli/test_cli.py::test_generate_grade_and_check",
    "repository/test_structure.py", "repository/test_suites.py",
)  # fmt: skip
"""The tests that `make check` runs: files, or prefixes of test ids."""


def is_example(nodeid: str) -> bool:
    return nodeid.removeprefix("tests/").startswith(EXAMPLES)


def has_examples(path: Path) -> bool:
    return any(ROOT / "tests" / name.partition("::")[0] == path for name in EXAMPLES)


def describe_left_out(tests: int, families: int) -> str:
    """Return the last line of a run: what it left out, and which command runs it."""
    if WHOLE:
        return "make whole: nothing is left out except the tests skipped above"
    return f"make {SUITE} left out {tests} tests and {families} families of sweeps; `make whole` runs them"
