"""What is drawn for questions in numbers: lengths as the statement gives them, positive and no two equal."""

from qdot.exercises.common.stream import Stream
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions.inversion import sample_lengths


def test_no_two_lengths_are_equal(family: str) -> None:
    """With equal links, a folded arm is inside of what it can reach, and not at its boundary."""
    for step in ("chapter", "lengths", "full"):
        chain = sample_chain(ProblemId(family, 0, variation=step))
        given = [length for joint in chain.joints for length in (joint.a, joint.d) if length.is_number and length != 0]
        for number in range(20):
            lengths = sample_lengths(chain, Stream(f"lengths {number}"))
            assert set(lengths) == set(chain.parameters)
            assert len(set(lengths.values())) == len(lengths) and not set(lengths.values()) & set(given)
            assert all(0.3 <= length <= 0.8 for length in lengths.values())
