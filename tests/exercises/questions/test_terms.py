"""How many terms a result has, by which a question is refused that would be too long by hand."""

import pytest

from exercises.arm.derivation import structure
from exercises.arm.transforms import terms_of_last_pose
from exercises.generation import sample_chain
from exercises.problem import ProblemId


@pytest.mark.parametrize(("family", "terms"), [("planar-2r", 8), ("cartesian", 4)])
def test_zeros_and_ones_are_no_terms_of_a_transform(family: str, terms: int) -> None:
    assert terms_of_last_pose(structure(sample_chain(ProblemId(family, 0, variation="chapter"))).chain) == terms
