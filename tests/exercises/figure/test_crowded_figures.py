"""Figures in told poses, which may be crowded: names keep apart there, and the arm is seen from a side that tells."""

from functools import cache
from itertools import combinations

import numpy as np
import pytest

from exercises.figure import arm_figure
from exercises.figure.plane import is_flat
from exercises.figure.shapes import Figure
from exercises.generation import sample_chain
from exercises.problem import ProblemId
from tests.support.figures import faults
from tests.support.problems import LONG_ARMS, drawn
from tests.support.suites import families_for, several

APART = 8.0
"""Pixels between origins that differ, of an arm with six or seven joints, whose hand may come back to its elbow."""


@cache
def posed(identity: ProblemId) -> list[tuple[str, Figure]]:
    """The figures that stand under the questions of a problem, with the questions' names."""
    problem = drawn(identity.family, identity.seed)
    return [(part.kind, arm_figure(problem.chain, part.pose)) for part in problem.parts if part.pose is not None]


def words(figure: Figure) -> set[str]:
    return {"".join(run.text for run in text.runs) for text in figure.texts}


def of_problems(*identities: ProblemId) -> pytest.MarkDecorator:
    """Ask a test of problems; those of a family in one process, so that figures are drawn once."""
    groups = [pytest.mark.xdist_group(identity.family) for identity in identities]
    params = [pytest.param(one, marks=group, id=str(one)) for one, group in zip(identities, groups, strict=True)]
    return pytest.mark.parametrize("identity", params)


every_problem = of_problems(*(ProblemId(name, 0) for name in families_for()))
long_arms = of_problems(*(ProblemId(name, seed) for name in LONG_ARMS for seed in several((0,), (0, 3))))


@every_problem
def test_a_told_pose_can_be_read(identity: ProblemId) -> None:
    found = {question: faults(figure) for question, figure in posed(identity)}
    assert not {question: told for question, told in found.items() if told}


@long_arms
def test_origins_of_six_and_seven_joints_are_seen_apart_in_a_told_pose(identity: ProblemId) -> None:
    for _, figure in posed(identity):
        assert not faults(figure)
        spots = [text.at for text in figure.texts if "O" in "".join(run.text for run in text.runs)]
        assert min(float(np.hypot(*np.subtract(a, b))) for a, b in combinations(spots, 2)) >= APART


@every_problem
def test_all_joints_axes_and_the_point_are_named_in_a_told_pose(identity: ProblemId) -> None:
    chain = sample_chain(identity)
    for _, figure in posed(identity):
        names = {name for word in words(figure) for name in word.replace(" = ", ", ").split(", ")}
        assert {"P", *(f"O{i}" for i in range(chain.n + 1))} <= names
        assert is_flat(chain) or {"x0", f"x{chain.n}", *(f"z{i}" for i in range(chain.n + 1))} <= names
