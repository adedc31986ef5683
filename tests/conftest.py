"""Settings of all tests: the choice of a suite (tests/support/suites.py), fixtures, and deterministic Hypothesis."""

import gc
import json
import os
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import sympy as sp
from hypothesis import HealthCheck, settings

from qdot.exercises.arm.chain import Chain, Joint, Point
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.families import FAMILIES
from qdot.exercises.problem.problem import Problem
from qdot.grader.sandbox.sandbox import Limits, Sandbox
from tests.support import DATA
from tests.support.problems import get_problem
from tests.support.submitting import keep_sandboxes_open
from tests.support.suites import (
    SUITE,
    WHOLE,
    describe_left_out,
    has_examples,
    is_example,
    make_family_params,
    select_families,
    select_for_suite,
)

CHAPTER = ("planar-2r", "elbow-3r", "polar-rp", "planar-3r")
"""The chapter's arms, from which more problems are tested than from others."""
SWEPT = [
    (family, seed) for family in FAMILIES for seed in range(select_for_suite(1, 2) if family in CHAPTER[:2] else 1)
]

# There is no deadline, because computer algebra may be slow without being wrong.
settings.register_profile(
    "qdot", deadline=None, derandomize=True, print_blob=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("qdot")


@dataclass(frozen=True)
class TextbookArm:
    """A record of ground_truth.json and its chain, with the point and the rows of its task."""

    record: dict[str, Any]
    chain: Chain


def _angle(text: str) -> sp.Expr:
    """Parse an angle in degrees and joint variables, such as theta1+90."""
    terms = text.split("+")
    return sp.Add(*(sp.pi * int(t) / 180 if t.lstrip("-").isdigit() else sp.Symbol(t) for t in terms))


def _textbook_arm(record: dict[str, Any]) -> TextbookArm:
    joints = [
        Joint(
            row["type"], _angle(row["theta_deg"]), sp.sympify(row["d"]), sp.sympify(row["a"]), _angle(row["alpha_deg"])
        )
        for row in record["dh"]
    ]
    frame = int(record["task_reference_point"].removeprefix("tip ").removeprefix("O"))
    task = [row for row in record["task_rows"] if row in VELOCITY_NAMES]
    return TextbookArm(record, Chain(record["name"], tuple(joints), tuple(task), tool=Point(frame)))


@pytest.fixture(scope="session")
def textbook_arms() -> dict[str, TextbookArm]:
    records = json.loads((DATA / "ground_truth.json").read_text(encoding="utf-8"))
    return {record["name"]: _textbook_arm(record) for record in records}


@pytest.fixture(scope="session")
def seeds() -> range:
    return range(6)


@pytest.fixture(scope="session")
def sandbox() -> Iterator[Sandbox]:
    """A sandbox with generous time limits. All tests of a process share it, but its runs are independent."""
    with Sandbox(Limits(seconds=60, cell_seconds=20)) as shared:
        yield shared


@pytest.fixture(scope="session", autouse=True)
def _keep_sandboxes_open() -> Iterator[None]:
    with keep_sandboxes_open():
        yield


@pytest.fixture
def problem(request: pytest.FixtureRequest) -> Problem:
    """The problems of a sweep, one of each family; in `make whole`, also a second one of some arms of the chapter."""
    return get_problem(*request.param)


LEFT_OUT: Counter[str] = Counter()
"""The numbers of tests and of families of sweeps that this process left out. Workers report theirs when they end."""


def pytest_xdist_auto_num_workers() -> int:
    """Return the number of cores plus one, because many tests wait for processes that they started."""
    return (os.cpu_count() or 1) + 1


def pytest_configure(config: pytest.Config) -> None:
    """Register the suites' markers, and collect garbage rarely, because most objects of a test process stay alive."""
    gc.set_threshold(100_000, 50, 1000)
    for marker in (
        "families(names, every=False): a sweep over these families, or over those of them that the suite takes",
        "whole: only in `make whole`, because it takes long and a shorter test checks the same",
        "integration: starts another program (a container, Moodle's Maxima, LaTeX, a wheel); only in `make whole`",
    ):
        config.addinivalue_line("markers", marker)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Give every sweep its families: those of the argument `family`, or the problems of `problem`."""
    marker = metafunc.definition.get_closest_marker("families")
    markers = metafunc.definition.iter_markers("parametrize")
    parametrized = {name.strip() for each in markers for name in _split_names(each.args[0])}
    swept = {"family", "problem"} & set(metafunc.fixturenames) - parametrized
    if not swept:
        return
    among = marker.args[0] if marker else tuple(FAMILIES)
    takes_every = marker and marker.kwargs.get("every") and SUITE != "check"
    chosen = list(among) if takes_every else select_families(among)
    LEFT_OUT["families"] += len(among) - len(chosen)
    if "family" in swept:
        metafunc.parametrize("family", make_family_params(chosen))
        return
    problems = [(family, seed) for family, seed in SWEPT if family in chosen]
    marks = [pytest.mark.xdist_group(family) for family, _ in problems]
    params = [
        pytest.param(problem, marks=mark, id="{}/{}".format(*problem))
        for problem, mark in zip(problems, marks, strict=True)
    ]
    metafunc.parametrize("problem", params, indirect=True)


@pytest.hookimpl(trylast=True)
def pytest_collection_finish() -> None:
    """Exclude the objects made so far from garbage collection, which otherwise takes a third of the tests' time."""
    gc.freeze()


def _split_names(names: str | Sequence[str]) -> Sequence[str]:
    return names.split(",") if isinstance(names, str) else names


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Ignore files in which `make check` runs no test, unless files are named on the command line."""
    is_named = config.invocation_params.args and any(str(name).endswith(".py") for name in config.args)
    if SUITE != "check" or is_named or collection_path.suffix != ".py" or collection_path.name == "conftest.py":
        return None
    return True if not has_examples(collection_path) else None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Deselect tests that don't belong to the suite, unless a test is named on the command line."""
    for item in items:
        _keep_together(item)
    if WHOLE or any("::" in name for name in config.args):
        return
    taken = [item for item in items if _is_in_suite(item)]
    LEFT_OUT["tests"] += len(items) - len(taken)
    config.hook.pytest_deselected(items=list(set(items) - set(taken)))
    items[:] = taken


def _keep_together(item: pytest.Item) -> None:
    """Run the tests of a file in one process, where fixtures are made and arms derived once; a sweep has its groups."""
    if not item.get_closest_marker("xdist_group"):
        item.add_marker(pytest.mark.xdist_group(item.path.stem))


def _is_in_suite(item: pytest.Item) -> bool:
    if item.get_closest_marker("whole") or item.get_closest_marker("integration"):
        return False
    return SUITE != "check" or is_example(item.nodeid)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Report what a worker left out to the process that started it."""
    output = getattr(session.config, "workeroutput", None)
    if output is not None:
        output["left_out"] = dict(LEFT_OUT)


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any) -> None:
    """Store what a worker left out, which is the same for all workers. A worker that died reports nothing."""
    left_out = getattr(node, "workeroutput", {}).get("left_out", {})
    LEFT_OUT.update({name: count - LEFT_OUT[name] for name, count in left_out.items()})


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Print what was left out, and which command runs it."""
    terminalreporter.write_line(describe_left_out(LEFT_OUT["tests"], LEFT_OUT["families"]))
