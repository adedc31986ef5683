"""Answers that are numbers already, as platforms ask them: worked out a second time, with what mistakes give."""

import numpy as np
import pytest

from exercises.answers import Number
from exercises.exports.numbers import in_numbers
from exercises.questions.results import is_derived
from tests.support.problems import drawn


@pytest.mark.parametrize("family", ["planar-2r", "elbow-3r", "planar-3r"])
def test_numbers_are_asked_for_as_they_are_and_mistakes_give_others(family: str) -> None:
    problem = drawn(family, 0)
    parts = [part for part in problem.parts if isinstance(part.answer, Number)]
    assert len(parts) >= 3
    for part in parts:
        found = in_numbers(problem, part)
        assert found is not None and isinstance(part.answer, Number), part.name
        right = np.array(part.answer.reference.tolist(), dtype=float)
        assert np.array_equal(found.values, right), part.name
        assert found.wrong or not is_derived(part), part.name
        for title, _, values in found.wrong:
            assert values.shape != right.shape or not np.array_equal(values, right), title
