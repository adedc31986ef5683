"""Values sampled for numeric questions: lengths as in the statement, positive and distinct."""

from qdot.exercises.common.stream import Stream
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions.inversion import sample_lengths


def test_sampled_lengths_are_positive_and_distinct(family: str) -> None:
    """With equal links, a folded arm would be inside its workspace, not at the boundary."""
    for step in ("chapter", "lengths", "full"):
        chain = sample_chain(ProblemId(family, 0, variation=step))
        fixed_lengths = [
            length for joint in chain.joints for length in (joint.a, joint.d) if length.is_number and length != 0
        ]
        for number in range(20):
            lengths = sample_lengths(chain, Stream(f"lengths {number}"))
            assert set(lengths) == set(chain.parameters)
            assert len(set(lengths.values())) == len(lengths) and not set(lengths.values()) & set(fixed_lengths)
            assert all(0.3 <= length <= 0.8 for length in lengths.values())
