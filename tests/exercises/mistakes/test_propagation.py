"""Mistakes of propagation, against what they are said to do."""

import numpy as np
import pytest

from exercises.arm.stages import numbers
from exercises.mistakes.catalogue import CATALOGUE, made
from exercises.mistakes.given import configurations
from exercises.stream import Stream
from tests.support.problems import drawn


@pytest.mark.parametrize(("mistake", "stage"), [("next-arm", "arms"), ("next-axis", "axes")])
def test_the_next_one_is_taken_and_at_the_last_joint_its_own(mistake: str, stage: str) -> None:
    """Three joints, so that it is told apart from taking the second one twice, or the first."""
    problem = drawn("elbow-3r", 0)
    part = next(part for part in problem.parts if part.kind == "geometric-jacobian")
    values = configurations(problem.chain, part, problem.domain(), 3, Stream("propagation"))
    right = numbers(problem.chain, values)
    count, columns = right.n, []
    for i in range(count):
        k = min(i + 1, len(right[stage]) - 1)
        axis, arm = right["axes"][k if stage == "axes" else i], right["arms"][k if stage == "arms" else i]
        columns.append(np.cross(axis, arm, axis=0))
    expected = np.stack(columns, axis=1)
    answers = [wrong.answer[:3] for wrong in made(CATALOGUE[mistake], right, part)]
    assert any(np.allclose(answer, expected) for answer in answers)
