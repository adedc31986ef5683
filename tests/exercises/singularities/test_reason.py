"""The stated reason for a singularity is true: it does not hold at any regular configuration."""

import re

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import make_symbolic_arm
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.singularities import reason
from qdot.exercises.singularities.appearance import ZERO_TOLERANCE, Statement, describe_appearance, find_reason
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.classification import sample_condition
from qdot.exercises.singularities.meanings import list_candidate_meanings
from qdot.exercises.singularities.singular_set import find_singular_set
from tests.exercises.arm.sets import compute_rank_ratios, list_task_rows
from tests.support.suites import few_or_all_families, on_families


def arm(family: str, seed: int = 1) -> Chain:
    return make_symbolic_arm(sample_chain(ProblemId(family, seed, variation="chapter"))).chain


def samples_of(chain: Chain, condition: str) -> tuple[Sample, ...]:
    """Return configurations at which a condition holds, on arms with different lengths from those examined."""
    return sample_condition(chain, condition, "another draw", arm_count=4)


@on_families(("stanford-6r", "ur-6r", "scara", "scorbot-wrist", "puma-560", "industrial-6r"))
def test_parallel_axes_are_a_reason_only_where_their_own_columns_depend_on_each_other(family: str) -> None:
    """At s2 = 0 of a Stanford arm axes 1 and 4 are parallel, which costs no rank by itself."""
    chain = arm(family)
    rows = list_task_rows(chain)
    for component in find_singular_set(chain) or ():
        samples = [sample for piece in component.list_pieces() for sample in samples_of(chain, piece)]
        said = find_reason(chain, samples)
        if said is not None and (joints := re.search(r"axes of joints ([\d, and]+) are parallel", said.words)):
            columns = [int(number) - 1 for number in re.findall(r"\d", joints[1])]
            for sample in samples:
                assert np.linalg.matrix_rank(sample.arm.compute_jacobian(sample.q)[np.ix_(rows, columns)], 1e-6) < len(
                    columns
                )


@few_or_all_families
def test_the_reason_that_is_told_holds_at_no_regular_configuration(
    family: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The search begins at other points, on arms with different lengths from those of the derivation."""
    chain = arm(family)
    for component in find_singular_set(chain) or ():
        read_from = [
            sample
            for piece in component.list_pieces()
            for sample in sample_condition(chain, piece, "classify", arm_count=3)
        ]
        said = find_reason(chain, read_from)
        others = [sample for piece in component.list_pieces() for sample in samples_of(chain, piece)]
        if said is None:
            continue
        assert all(sample.evaluate(said.measure) < ZERO_TOLERANCE for sample in others), said.words
        assert sum(map(said.predicate, others)) >= 0.9 * len(others), said.words  # here and there it can't be told
        with monkeypatch.context() as changed:
            changed.setattr(reason, "_sample_starts", starts)
            found = {id(sample.arm): zeros(sample.arm, said) for sample in others}
        for sample in others:
            for q in found[id(sample.arm)]:
                assert not said.predicate(Sample(sample.arm, q)) or compute_rank_ratios(sample.arm, chain, q) < 1e-4, (
                    said.words
                )


def zeros(arm: NumericChain, said: Statement) -> np.ndarray:
    """Return configurations at which it is so, of those to which the search leads."""
    (q,) = reason._descend(arm, said.measure, 1)
    return np.asarray(q[said.measure(arm, q) < reason._CONVERGENCE_TOLERANCE])


def starts(kinds: tuple[str, ...]) -> np.ndarray:
    """Starts other than those of qdot, and more of them."""
    stream = Stream("other starts")
    return np.array(
        [[stream.uniform(-3, 3) if kind == "R" else stream.uniform(0, 1) for kind in kinds] for _ in range(40)]
    )


@pytest.mark.parametrize(("length", "is_told"), [(sp.Symbol("a1"), True), (0, False)])
def test_how_a_slide_runs_past_a_link_is_a_reason_where_the_link_has_a_length(
    length: sp.Expr | int, is_told: bool
) -> None:
    theta1, theta2, d3 = sp.symbols("theta1 theta2 d3")
    joints = (Joint("R", theta1, 0, length, 0), Joint("R", theta2, 0, 0, sp.pi / 2), Joint("P", 0, d3, 0, 0))
    chain = Chain("RRP", joints, ("vx", "vy", "wz"))
    told = {one.kind for one in list_candidate_meanings(chain, samples_of(chain, "sin(theta2)"))}
    assert ({"along", "across"} <= told) == is_told


def test_a_point_on_two_axes_that_meet_is_told_of_both() -> None:
    theta1, theta2, d3 = sp.symbols("theta1 theta2 d3")
    joints = (Joint("R", theta1, 0, 0, -sp.pi / 2), Joint("R", theta2, 0, 0, sp.pi / 2), Joint("P", 0, d3, 0, 0))
    chain = Chain("spherical", joints, ("vx", "vy", "vz"))
    told = "the point lies on the axes of joints 1 and 2, which then do not move it"
    assert describe_appearance(chain, samples_of(chain, "d3 = 0")) == told
    told = "the point lies on the axis of joint 1, which then does not move it"
    assert describe_appearance(chain, samples_of(chain, "sin(theta2)")) == told
