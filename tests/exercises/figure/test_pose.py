"""The pose in which an arm is drawn: which poses are tried."""

from exercises.figure.pose import DEFAULT_LENGTH, candidates
from exercises.generation import sample_chain
from exercises.problem import ProblemId


def test_a_slide_in_the_plane_is_drawn_longer_than_any_link_and_one_in_space_is_not() -> None:
    """In the plane its sleeve and its rod are seen from the side, and take room."""
    for family, at_least, at_most in (("polar-rp", 1.5, 2.0), ("scara", 0.5, 1.0)):
        chain = sample_chain(ProblemId(family, 0))
        slide = next(i for i, joint in enumerate(chain.joints) if joint.kind == "P")
        lengths = [abs(float(v)) for joint in chain.joints for v in (joint.a, joint.d) if v.is_number]
        extensions = candidates(chain, chain)[:, slide] / (max([*lengths, 0.0]) or DEFAULT_LENGTH)
        assert at_least <= extensions.min() and extensions.max() <= at_most, family
