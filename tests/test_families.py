"""Families: what every arm that a family draws must be, for a class in which nobody's arm is harder than another's."""

from functools import cache

import pytest
import sympy as sp

from exercises.arm.chain import Chain
from exercises.arm.derivation import derive
from exercises.arm.singularity import singular_set
from exercises.difficulty import difficulty, step
from exercises.families import FAMILIES
from exercises.families.base import centimetres, standing_in_plane, turned
from exercises.generate import applicable, sample_chain
from exercises.problem import ProblemId
from exercises.stream import Stream

ARMS = 200
MOST_TERMS, MOST_TERMS_OF_A_FACTOR = 20, 4


@cache
def arms(family: str) -> tuple[Chain, ...]:
    return tuple(sample_chain(ProblemId(family, seed)) for seed in range(ARMS))


@pytest.mark.parametrize("family", FAMILIES)
def test_a_family_is_registered_under_its_name(family: str) -> None:
    assert FAMILIES[family].name == family
    assert FAMILIES[family].title
    assert FAMILIES[family].source


@pytest.mark.parametrize("family", FAMILIES)
def test_two_arms_never_differ_in_difficulty_by_more_than_a_step(family: str) -> None:
    steps = [step(arm) for arm in arms(family)]
    assert max(steps) - min(steps) <= 1


def test_the_scale_of_difficulty() -> None:
    """Example 6.3: 15 terms of J, two factors, one of which ties several joints."""
    arm = sample_chain(ProblemId("elbow-3r", 0))
    assert (difficulty(arm), step(arm)) == (15 + 4 * 2 + 8, 3)


@pytest.mark.parametrize("family", FAMILIES)
def test_every_arm_can_be_done_by_hand(family: str) -> None:
    if sample_chain(ProblemId(family, 0)).n > 4:
        return  # such arms are asked block by block, and only what `too_long` lets pass
    for arm in arms(family)[:40]:
        entries = [sp.expand(entry) for entry in derive(arm).jacobian]
        assert sum(len(sp.Add.make_args(entry)) for entry in entries if entry != 0) <= MOST_TERMS
        for component in singular_set(arm) or ():
            for condition in component.conditions:
                assert len(sp.Add.make_args(sp.expand(condition))) <= MOST_TERMS_OF_A_FACTOR


@pytest.mark.parametrize("family", FAMILIES)
def test_every_arm_of_a_family_can_be_asked_the_same_questions(family: str) -> None:
    assert len({applicable(arm) for arm in arms(family)}) == 1


@pytest.mark.parametrize("family", FAMILIES)
def test_every_arm_has_the_same_symbols_up_to_numbers(family: str) -> None:
    """Which length is a number and which a symbol may change; the joints' kinds and their number may not."""
    assert len({tuple(joint.kind for joint in arm.joints) for arm in arms(family)}) == 1
    assert len({arm.task for arm in arms(family)}) == 1
    assert len({len(arm.parameters) for arm in arms(family)}) == 1


@pytest.mark.parametrize("family", FAMILIES)
def test_arms_differ(family: str) -> None:
    assert len(set(arms(family))) > 0.95 * ARMS


@pytest.mark.parametrize("family", FAMILIES)
def test_no_two_links_are_nearly_as_long(family: str) -> None:
    """Equal lengths add singular configurations that nobody asked for."""
    for arm in arms(family):
        lengths = [float(joint.a) for joint in arm.joints if joint.a.is_number and joint.a != 0]
        gaps = [abs(x - y) for i, x in enumerate(lengths) for y in lengths[:i]]
        assert all(gap > 0.045 for gap in gaps), arm


def test_draws_that_families_share() -> None:
    stream = Stream("shared")
    assert {centimetres(stream, 5, 7) for _ in range(60)} == {sp.Rational(k, 100) for k in (5, 6, 7)}
    angles = {turned(stream, 90) for _ in range(80)}
    assert angles == {0, sp.pi / 2, sp.pi, -sp.pi / 2}
    base = standing_in_plane(stream)
    assert base.position[0] != 0
    assert base.position[1] != 0
    assert base.position[2] == 0
