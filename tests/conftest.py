"""Settings of every test: Hypothesis draws the same examples in CI, and new ones on a developer's machine.

QDOT_SEEDS (default 6) is the number of problems that the tests draw from each family.
"""

import json
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
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
from tests.support.problems import several

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
    return range(int(os.environ.get("QDOT_SEEDS", "6")))


@pytest.fixture(scope="session")
def drawn() -> Callable[[str, int], Problem]:
    """Return the problem of a family and a seed with all its questions, generated once for all tests of a process."""
    return drawn_once


@pytest.fixture(scope="session")
def sandbox() -> Iterator[Sandbox]:
    """A sandbox with time for whatever a part needs, one for all tests of a process; each run in it is by itself."""
    with Sandbox(Limits(seconds=60, cell_seconds=20)) as made:
        yield made


# The tests of a family run in one process, so that its problems are generated once.
@pytest.fixture(params=[pytest.param(name, marks=pytest.mark.xdist_group(name)) for name in FAMILIES])
def family(request: pytest.FixtureRequest) -> str:
    """Every family in turn."""
    return str(request.param)


@pytest.fixture(
    params=[pytest.param(which, marks=pytest.mark.xdist_group(which[0]), id="{}/{}".format(*which)) for which in DRAWN]
)
def problem(request: pytest.FixtureRequest) -> Problem:
    """The first problem of every family, and in `make whole` the second of two of the chapter."""
    return drawn_once(*request.param)
