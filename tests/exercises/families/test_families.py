"""Families: what every arm that a family draws must be, for a class in which nobody's arm is harder than another's."""

from collections import Counter
from functools import cache

import pytest
import sympy as sp

from exercises.arm.chain import Chain
from exercises.arm.derivation import derive
from exercises.arm.singularity import singular_set
from exercises.difficulty import difficulty, step
from exercises.families import FAMILIES
from exercises.families.base import centimetres, standing_in_plane, turned
from exercises.generation import applicable, questions_of, sample_chain
from exercises.problem import ProblemId
from exercises.stream import Stream
from tests.support.problems import LONG_ARMS
from tests.support.suites import of_families, several

ARMS = 80
DERIVED = several(3, ARMS)
"""Arms of each family that are derived; what their tables say is looked at in all."""
FIXED = [name for name, family in FAMILIES.items() if not family.varied]
"""Families whose arms are all of one kind; what random-N may differ in is tested with them."""
MOST_TERMS, MOST_TERMS_OF_A_FACTOR = 15, 4
ALLOWED = {
    "orthogonal-3r": (19, "with a1 = 0 or a2 = 0 it would have fewer terms, and not its singular set"),
    "scorbot-wrist": (25, "J is 6 x 5: the 15 terms of Example 6.3 and the joints' axes"),
    "scorbot-tip": (36, "J is 6 x 5: d5 adds a term to each entry of Example 6.3"),
    "stanford-6r": (34, "asked block by block: 15 terms in J11, 16 in J22"),
    "puma-560": (44, "asked block by block: 23 terms in J11, a term d4 or a3 in each entry; 16 in J22"),
    "anthropomorphic-6r": (34, "asked block by block: 13 terms in J11, 16 in J22"),
    "industrial-6r": (44, "asked block by block: 23 terms in J11, a term d4 or a3 in each entry; 16 in J22"),
    "ur-6r": (41, "its last three axes do not meet; asked for its axes, poses in numbers and singular set"),
    "lbr-7r": (83, "J is 6 x 7; asked for its axes, poses in numbers and singular set"),
}
"""Terms of J that a family may have beyond what is done by hand, and why."""


@cache
def arms(family: str) -> tuple[Chain, ...]:
    return tuple(sample_chain(ProblemId(family, seed)) for seed in range(ARMS))


@of_families(FIXED)
def test_a_family_is_registered_under_its_name(family: str) -> None:
    assert FAMILIES[family].name == family
    assert FAMILIES[family].title
    assert FAMILIES[family].source


@of_families(FIXED)
def test_two_arms_never_differ_in_difficulty_by_more_than_a_step(family: str) -> None:
    steps = [step(arm) for arm in arms(family)[:DERIVED]]
    assert max(steps) - min(steps) <= 1


def test_the_scale_of_difficulty() -> None:
    """Example 6.3: 15 terms of J, two factors, one of which ties several joints."""
    arm = sample_chain(ProblemId("elbow-3r", 0))
    assert (difficulty(arm), step(arm)) == (15 + 4 * 2 + 8, 3)


@of_families(FIXED)
def test_every_arm_can_be_done_by_hand(family: str) -> None:
    most, _ = ALLOWED.get(family, (MOST_TERMS, ""))
    for arm in arms(family)[:DERIVED]:
        entries = [sp.expand(entry) for entry in derive(arm).jacobian]
        assert sum(len(sp.Add.make_args(entry)) for entry in entries if entry != 0) <= most
        for component in singular_set(arm) or ():
            for condition in component.conditions:
                assert len(sp.Add.make_args(sp.expand(condition))) <= MOST_TERMS_OF_A_FACTOR


@of_families(FIXED)
def test_every_arm_of_a_family_can_be_asked_the_same_questions(family: str) -> None:
    assert {applicable(arm) for arm in arms(family)[:DERIVED]} == {questions_of(family)}


@of_families(FIXED)
def test_every_arm_has_the_same_symbols_up_to_numbers(family: str) -> None:
    """Which length is a number and which a symbol may change; the joints' kinds and their number may not."""
    assert len({tuple(joint.kind for joint in arm.joints) for arm in arms(family)}) == 1
    assert len({arm.task for arm in arms(family)}) == 1
    assert len({len(arm.parameters) for arm in arms(family)}) == 1


@of_families(FIXED)
def test_arms_differ(family: str) -> None:
    assert len(set(arms(family))) > 0.95 * ARMS


@of_families(FIXED)
def test_the_point_of_interest_and_the_axes_differ(family: str) -> None:
    """Neither where P is fixed nor how the axes run is that of more than three quarters of the class."""
    places = Counter(
        (arm.point.frame, tuple(map(bool, arm.point.offset)), arm.joints[-1].a == 0) for arm in arms(family)
    )
    axes = Counter(tuple(joint.alpha for joint in arm.joints) for arm in arms(family))
    assert max(places.values()) <= 0.75 * ARMS
    assert max(axes.values()) <= 0.75 * ARMS


@pytest.mark.parametrize("family", [name for name in FAMILIES if name not in FIXED])
def test_the_point_of_interest_differs_with_the_structure(family: str) -> None:
    """A structure without a last length has no other place for P than the last origin."""
    draws = several(16, 40)
    held = [not sample_chain(ProblemId(family, seed)).point.is_origin for seed in range(draws)]
    assert draws // 10 <= sum(held) <= draws - draws // 10


@of_families(several([name for name in FIXED if name not in LONG_ARMS], FIXED))
def test_answers_differ(family: str) -> None:
    """No Jacobian is that of more than a tenth of the class."""
    looked_at = several(20, 60)
    jacobians = Counter(tuple(derive(arm).jacobian) for arm in arms(family)[:looked_at])
    assert max(jacobians.values()) <= looked_at // 10


@of_families(FIXED)
def test_no_two_links_are_nearly_as_long(family: str) -> None:
    """Equal lengths add singular configurations that nobody asked for."""
    for arm in arms(family):
        given = [joint.a for joint in arm.joints] + [joint.d for joint in arm.joints if joint.kind == "R"]
        lengths = [float(length) for length in given if length.is_number and length != 0]
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
