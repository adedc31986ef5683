"""Lengths left open and put in again, and what is said of singularities of all arms that differ in them alone."""

from collections.abc import Sequence

import numpy as np
import pytest
import sympy as sp

from exercises.arm import classification
from exercises.arm.appearance import meaning
from exercises.arm.axes import Sample
from exercises.arm.bare import bare, bare_pieces
from exercises.arm.chain import Chain, Joint
from exercises.arm.classification import classify, classify_pieces, in_general
from exercises.arm.kinematics import NumericChain
from exercises.arm.lengths import are_unrelated, with_lengths, with_open_lengths
from exercises.arm.singularity import Component, singular_set
from exercises.generation import sample_chain
from exercises.problem import Problem, ProblemId
from exercises.verify.appearance import holds, places_on

TENTH = sp.Rational(1, 10)


def two_links(first: int, second: int) -> Chain:
    rows = (Joint("R", f"theta{i}", 0, a * TENTH, 0) for i, a in ((1, first), (2, second)))
    return Chain("two", tuple(rows), ("vx", "vy"))


def test_an_arm_with_its_lengths_put_in_again_moves_as_before(problem: Problem) -> None:
    general, lengths = with_open_lengths(problem.chain)
    again = with_lengths(general, lengths)
    assert again.parameters == problem.chain.parameters
    values = {symbol.name: 0.3 + 0.1 * k for k, symbol in enumerate(again.parameters)}
    q = np.array([0.4 - 0.3 * k for k in range(again.n)])
    offsets = np.array([float(offset) for offset in problem.chain.offsets])
    one, other = NumericChain(problem.chain, values), NumericChain(again, values)
    np.testing.assert_allclose(other.jacobian(q + offsets), one.jacobian(q), atol=1e-12)
    np.testing.assert_allclose(other.point(q + offsets), one.point(q), atol=1e-12)


def test_what_is_told_of_a_structure_holds_for_the_arm(problem: Problem) -> None:
    for component in singular_set(problem.chain) or ():
        pieces, (_, known) = bare_pieces(problem.chain, component), in_general(problem.chain)
        if all(piece in known for piece in pieces):
            kind, own = classify(problem.chain, component), classify_pieces(bare(problem.chain), pieces)
            assert all(holds(problem.chain, kind.meaning, sample) for sample in places_on(problem.chain, component))
            assert not (kind.uniform and own.uniform) or kind.kind == own.kind


@pytest.mark.parametrize("family", ["planar-2r", "elbow-3r", "scara"])
def test_looks_are_found_once_for_all_arms_of_a_structure(family: str, monkeypatch: pytest.MonkeyPatch) -> None:
    looked_at: list[Chain] = []

    def look(chain: Chain, samples: Sequence[Sample]) -> str:
        looked_at.append(chain)
        return meaning(chain, samples)

    monkeypatch.setattr(classification, "meaning", look)
    classification._classified.cache_clear()
    classification._whatever_the_lengths.cache_clear()
    counts = []
    for seed in range(1, 5):
        chain = sample_chain(ProblemId.parse(f"{family}/{seed}@lengths"))
        for component in singular_set(chain) or ():
            classify(chain, component)
        counts.append(len(looked_at))
    assert 0 < counts[0] == counts[-1]


def test_arms_with_special_lengths_are_looked_at_by_themselves() -> None:
    """Folded back, the point is on the axis of joint 1 where links are as long as each other: inside the reach."""
    kinds = {}
    for second in (4, 5):
        chain = two_links(5, second)
        (component,) = singular_set(chain) or ()
        kinds[second] = [kind for _, part in values_of(chain) for kind in [classify(chain, part).kind]]
        assert bool(in_general(chain)[1]) is (second == 4), component
    assert kinds == {4: ["boundary", "boundary"], 5: ["boundary", "internal"]}


def values_of(chain: Chain) -> list[tuple[classification.Values, Component]]:
    (component,) = singular_set(chain) or ()
    return classification.by_value(component, classify(chain, component))


@pytest.mark.parametrize(
    ("lengths", "apart"),
    [((3, 4, 5), True), ((3, 4, 7), False), ((3, 3), False), ((1, 2, 4, 9), True), ((1, 2, 4, 7), False)],
)
def test_lengths_that_are_sums_of_others_are_related(lengths: tuple[int, ...], apart: bool) -> None:
    assert are_unrelated([sp.Rational(length, 20) for length in lengths]) is apart


def test_open_and_many_lengths_are_not_said_to_be_unrelated() -> None:
    assert not are_unrelated([sp.S(1), sp.Symbol("a2")])
    assert not are_unrelated([sp.Integer(3) ** k for k in range(9)])
    assert are_unrelated([sp.Integer(3) ** k for k in range(8)])
