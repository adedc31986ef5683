"""Bare arms and open lengths: what is established holds for all arms that differ in lengths, zeros and base alone."""

from collections.abc import Sequence

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Base, Chain, Joint
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.derivation.lengths import are_unrelated, replace_lengths_by_symbols, substitute_arm_lengths
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.singularities.classification import (
    classify,
    classify_conditions,
    generalize_conditions,
    sample_condition,
    split_by_value,
)
from qdot.exercises.singularities.normalized_arm import first_joint_moves_all, normalize_arm, normalize_conditions
from qdot.exercises.singularities.singular_set import Component, ValueCombination, find_singular_set
from qdot.exercises.singularities.singularity_kinds import classify_samples
from qdot.exercises.verify.singularity_statements import sample_component, statement_holds
from tests.support.suites import few_or_all_families, select_for_suite

A1, A2 = sp.symbols("a1 a2")


def two_links(*offsets: sp.Expr, base: Base = Base(), lengths: Sequence[sp.Expr] = (A1, A2)) -> Chain:  # noqa: B008
    q = sp.symbols("theta1 theta2")
    rows = (Joint("R", angle + offset, 0, a, 0) for angle, offset, a in zip(q, offsets, lengths, strict=True))
    return Chain("two", tuple(rows), ("vx", "vy"), base, title="two links")


def test_zeros_of_joints_and_the_place_of_the_base_are_left_out() -> None:
    moved = two_links(sp.pi / 6, -sp.pi / 2, base=Base((sp.Rational(1, 2), sp.Symbol("b_y"), sp.S.Zero), sp.pi / 3))
    assert normalize_arm(moved) == normalize_arm(two_links(sp.S.Zero, sp.S.Zero, base=Base(yaw=sp.pi / 3)))
    assert normalize_arm(moved).parameters == (A1, A2)
    assert normalize_arm(moved) != normalize_arm(two_links(sp.S.Zero, sp.S.Zero))


def test_the_same_configurations_are_the_same_pieces() -> None:
    chains = [two_links(sp.S.Zero, offset) for offset in (sp.S.Zero, sp.pi / 6, -sp.pi / 2, sp.pi)]
    pieces = {
        tuple(normalize_conditions(chain, component))
        for chain in chains
        for component in find_singular_set(chain) or ()
    }
    assert pieces == {("theta2 = 0", "theta2 = pi")}


def test_a_slide_is_counted_from_its_own_zero() -> None:
    rows = (Joint("R", "theta1", 0, 0, sp.pi / 2), Joint("P", 0, sp.Symbol("d2") + 4, 0, 0))
    chain = Chain("far", rows, ("vx", "vy"))
    (component,) = find_singular_set(chain) or ()
    assert component.list_pieces() == ["d2 = -4"]
    assert normalize_conditions(chain, component) == ["d2 = 0"]


@pytest.mark.parametrize(
    "name", ["planar-2r/3", "elbow-3r/8@full", "polar-rp/5", "planar-3r/2", "random-3/4", "scara/2@full"]
)
def test_a_kind_is_that_of_the_arm_by_itself(name: str) -> None:
    chain = sample_chain(ProblemId.parse(name))
    components = find_singular_set(chain) or ()
    assert components
    for component in components:
        assert classify(chain, component) == classify_conditions(chain, tuple(component.list_pieces()))


@pytest.mark.parametrize("name", ["planar-3r/2", "wrist-zyz/1", *select_for_suite((), ("spherical/3", "puma-560/1"))])
def test_kinds_are_the_same_one_by_one_and_at_once(name: str) -> None:
    chain = sample_chain(ProblemId.parse(name))
    pieces = [piece for component in find_singular_set(chain) or () for piece in component.list_pieces()]
    samples = [
        sample
        for piece in pieces
        for sample in sample_condition(chain, piece, "at once", arm_count=2, samples_per_arm=2)
    ]
    assert classify_samples(chain, samples) == [classify_samples(chain, [sample])[0] for sample in samples]
    assert len(samples) > 3
    assert classify_samples(chain, []) == []


@pytest.mark.parametrize(
    ("task", "tilt", "turns"),
    [
        (("vx", "vy"), 0, True), (("vx", "vy", "wz"), 0, True), (("vx", "vy", "vz"), sp.pi / 2, True),
        (VELOCITY_NAMES, sp.pi / 2, True), (("vx", "vz"), 0, False), (("vx", "vy"), sp.pi / 2, False),
        (("vx", "vy", "wx"), 0, False),
    ],
)  # fmt: skip
def test_a_turn_about_the_first_axis_changes_nothing_where_the_rows_turn_into_each_other(
    task: tuple[str, ...], tilt: sp.Expr, turns: bool
) -> None:
    rows = tuple(Joint("R", f"theta{i}", 0, 1, sp.pi / 2) for i in range(1, 4))
    assert first_joint_moves_all(Chain("turned", rows, task, Base(tilt=sp.S(tilt)))) is turns


def test_an_arm_with_its_lengths_put_in_again_moves_as_before(problem: Problem) -> None:
    general, lengths = replace_lengths_by_symbols(problem.chain)
    again = substitute_arm_lengths(general, lengths)
    assert again.parameters == problem.chain.parameters
    values = {symbol.name: 0.3 + 0.1 * k for k, symbol in enumerate(again.parameters)}
    q = np.array([0.4 - 0.3 * k for k in range(again.n)])
    offsets = np.array([float(offset) for offset in problem.chain.offsets])
    one, other = NumericChain(problem.chain, values), NumericChain(again, values)
    np.testing.assert_allclose(other.compute_jacobian(q + offsets), one.compute_jacobian(q), atol=1e-12)
    np.testing.assert_allclose(other.compute_point(q + offsets), one.compute_point(q), atol=1e-12)


@few_or_all_families
def test_what_is_told_of_a_structure_holds_for_the_arm(problem: Problem) -> None:
    for component in find_singular_set(problem.chain) or ():
        pieces, (_, known) = normalize_conditions(problem.chain, component), generalize_conditions(problem.chain)
        if all(piece in known for piece in pieces):
            kind, own = (
                classify(problem.chain, component),
                classify_conditions(normalize_arm(problem.chain), tuple(pieces)),
            )
            assert all(
                statement_holds(problem.chain, kind.meaning, sample)
                for sample in sample_component(problem.chain, component)
            )
            assert not (kind.is_uniform and own.is_uniform) or kind.kind == own.kind


def test_arms_with_special_lengths_are_looked_at_by_themselves() -> None:
    """Folded back, the point is on the axis of joint 1 where links are as long as each other: inside the reach."""
    kinds = {}
    for second in (4, 5):
        chain = two_links(sp.S.Zero, sp.S.Zero, lengths=(sp.Rational(1, 2), sp.Rational(second, 10)))
        (component,) = find_singular_set(chain) or ()
        kinds[second] = [kind for _, part in values_of(chain) for kind in [classify(chain, part).kind]]
        assert bool(generalize_conditions(chain)[1]) is (second == 4), component
    assert kinds == {4: ["boundary", "boundary"], 5: ["boundary", "internal"]}


def values_of(chain: Chain) -> list[tuple[ValueCombination, Component]]:
    (component,) = find_singular_set(chain) or ()
    return split_by_value(component, classify(chain, component))


@pytest.mark.parametrize(
    ("lengths", "apart"),
    [
        ((3, 4, 5), True), ((3, 4, 7), False), ((3, 3), False), ((1, 2, 4, 9), True), ((1, 2, 4, 7), False),
        ([3**k for k in range(8)], True), ([3**k for k in range(9)], False), ((1, sp.Symbol("a2")), False),
    ],
)  # fmt: skip
def test_lengths_that_are_sums_of_others_are_related_and_many_or_open_ones_may_be(
    lengths: Sequence[int], apart: bool
) -> None:
    assert are_unrelated([sp.S(length) / 20 for length in lengths]) is apart
