"""Settings of every test: what the suite takes and leaves out; and Hypothesis, which draws the same examples in CI.

The suites are those of tests/support/suites.py. A run says at its end what it left out.
"""

import gc
import json
import os
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import sympy as sp
from hypothesis import HealthCheck, settings

from exercises.arm.chain import TASK_ROWS, Chain, Joint, Point
from exercises.families import FAMILIES
from exercises.problem import Problem
from grader.sandbox import Limits, Sandbox
from tests.support import DATA
from tests.support.problems import drawn as drawn_once
from tests.support.suites import (
    SUITE,
    families_for,
    few_for,
    file_in_check,
    grouped,
    has_its_turn,
    in_check,
    several,
    told,
)

CHAPTER = ("planar-2r", "elbow-3r", "polar-rp", "planar-3r")
"""The arms of the chapter, of which more are tried than of the others."""
DRAWN = [(family, seed) for family in FAMILIES for seed in range(several(1, 2) if family in CHAPTER[:2] else 1)]

# Computer algebra takes the time it takes; a slow example is not a wrong one.
settings.register_profile("here", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("ci", settings.get_profile("here"), derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "here")


@dataclass(frozen=True)
class TextbookArm:
    """A record of ground_truth.json and its chain, with the point and the rows that its task speaks of."""

    record: dict[str, Any]
    chain: Chain


def _angle(text: str) -> sp.Expr:
    """Read degrees and joint variables, as in theta1+90."""
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
    task = [row for row in record["task_rows"] if row in TASK_ROWS]
    return TextbookArm(record, Chain(record["name"], tuple(joints), tuple(task), tool=Point(frame)))


@pytest.fixture(scope="session")
def textbook_arms() -> dict[str, TextbookArm]:
    """The arms of ground_truth.json by name."""
    records = json.loads((DATA / "ground_truth.json").read_text(encoding="utf-8"))
    return {record["name"]: _textbook_arm(record) for record in records}


@pytest.fixture(scope="session")
def seeds() -> range:
    """The seeds of the problems to draw from each family."""
    return range(6)


@pytest.fixture(scope="session")
def drawn() -> Callable[[str, int], Problem]:
    """Return the problem of a family and a seed with all its questions, generated once for all tests of a process."""
    return drawn_once


@pytest.fixture(scope="session")
def sandbox() -> Iterator[Sandbox]:
    """A sandbox with time for whatever a part needs, one for all tests of a process; each run in it is by itself."""
    with Sandbox(Limits(seconds=60, cell_seconds=20)) as made:
        yield made


@pytest.fixture
def problem(request: pytest.FixtureRequest) -> Problem:
    """The first problem of the families of a sweep, and in `make whole` the second of two of the chapter."""
    return drawn_once(*request.param)


LEFT_OUT: Counter[str] = Counter()
"""How many of what this process left out; those of the workers are added up by the process that started them."""
WHOLE_ONLY, FAMILIES_LEFT, IN_TURN = "left to make whole", "families left out of sweeps", "of another day"


def pytest_xdist_auto_num_workers() -> int:
    """Return one more than there are cores: many tests wait for processes that they started."""
    return (os.cpu_count() or 1) + 1


def pytest_configure(config: pytest.Config) -> None:
    """Register the marks that suites know, and look for garbage seldom: a process of tests holds much that stays."""
    gc.set_threshold(100_000, 50, 1000)
    config.addinivalue_line("markers", "families(names, every=False, most=N): a sweep over these families")
    config.addinivalue_line("markers", "whole: in `make whole` only, as it takes long and something shorter holds it")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Give every sweep over families those that the suite wants of it."""
    marker = metafunc.definition.get_closest_marker("families")
    given = {name.strip() for one in metafunc.definition.iter_markers("parametrize") for name in _names(one.args[0])}
    asked = {"family", "problem"} & set(metafunc.fixturenames) - given
    if not asked:
        return
    among = marker.args[0] if marker else tuple(FAMILIES)
    asks = marker.kwargs if marker else {}
    name = metafunc.definition.nodeid
    if asks.get("every"):
        chosen = list(among)
    else:
        chosen = few_for(name, among, asks["most"]) if "most" in asks else families_for(name, among)
    LEFT_OUT[FAMILIES_LEFT] += len(among) - len(chosen)
    if "family" in asked:
        metafunc.parametrize("family", grouped(chosen))
    else:
        drawn = [which for which in DRAWN if which[0] in chosen]
        groups = [pytest.mark.xdist_group(family) for family, _ in drawn]
        params = [
            pytest.param(which, marks=group, id="{}/{}".format(*which))
            for which, group in zip(drawn, groups, strict=True)
        ]
        metafunc.parametrize("problem", params, indirect=True)


@pytest.hookimpl(trylast=True)
def pytest_collection_finish() -> None:
    """Leave what collecting made out of every later search for garbage, which took a third of the tests' time."""
    gc.freeze()


def _names(names: str | Sequence[str]) -> Sequence[str]:
    return names.split(",") if isinstance(names, str) else names


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Don't even read the files of which `make check` runs nothing, unless they are asked for."""
    asked = config.invocation_params.args and any(str(name).endswith(".py") for name in config.args)
    if SUITE != "check" or asked or collection_path.suffix != ".py" or collection_path.name == "conftest.py":
        return None
    return True if not file_in_check(collection_path) else None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what the suite leaves out, unless a test is asked for by its name."""
    if SUITE == "whole" or any("::" in name for name in config.args):
        return
    inside = [item for item in items if _is_in_suite(item)]
    kept = [item for item in inside if SUITE != "test" or has_its_turn(item.path, item.nodeid, _group(item))]
    LEFT_OUT[WHOLE_ONLY] += len(items) - len(inside)
    LEFT_OUT[IN_TURN] += len(inside) - len(kept)
    config.hook.pytest_deselected(items=list(set(items) - set(kept)))
    items[:] = kept


def _group(item: pytest.Item) -> str:
    """Return the name of the group that runs in one process, empty where a test is in none."""
    marker = item.get_closest_marker("xdist_group")
    return str(marker.args[0]) if marker else ""


def _is_in_suite(item: pytest.Item) -> bool:
    if item.get_closest_marker("whole"):
        return False
    return SUITE != "check" or in_check(item.path, item.nodeid)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Hand what a worker left out to the process that started it."""
    output = getattr(session.config, "workeroutput", None)
    if output is not None:
        output["left_out"] = dict(LEFT_OUT)


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any) -> None:
    """Keep what a worker left out: all of them collect the same."""
    LEFT_OUT.update({name: count - LEFT_OUT[name] for name, count in node.workeroutput.get("left_out", {}).items()})


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Say what was left out, and which command runs it."""
    for line in told(LEFT_OUT[WHOLE_ONLY], LEFT_OUT[FAMILIES_LEFT], LEFT_OUT[IN_TURN]):
        terminalreporter.write_line(line)
