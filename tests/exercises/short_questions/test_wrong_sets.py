"""Wrong sets of singular configurations: which are compared, as comparing them is what costs."""

import pytest

from qdot.exercises.common.stream import Stream
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.short_questions import wrong_sets
from qdot.exercises.short_questions.options import OfferedOption
from qdot.exercises.short_questions.wrong_sets import make_four_sets
from qdot.exercises.singularities.singular_set import find_singular_set

FAMILY, SEED = "elbow-3r", "sets"


@pytest.mark.parametrize("they_differ", [True, False])
def test_what_goes_together_best_is_compared_first_and_nothing_after_it(
    monkeypatch: pytest.MonkeyPatch, they_differ: bool
) -> None:
    wanted, scores = Stream(SEED).integer_below(4), []

    def all_differ(_: object, options: list[OfferedOption]) -> bool:
        score = wrong_sets._find_length_mismatch(options, wanted)
        assert score is not None
        scores.append((not score.is_best, 0 if score.is_best else score))
        return they_differ

    monkeypatch.setattr(wrong_sets, "are_different_sets", all_differ)
    chain = sample_chain(ProblemId(FAMILY, 0))
    found = make_four_sets(chain, find_singular_set(chain) or (), Stream(SEED))
    assert scores == sorted(scores) and (found is not None) == they_differ
    assert len(scores) == 1 if they_differ else len(scores) > 3
