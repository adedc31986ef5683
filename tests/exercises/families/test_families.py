"""Families: what every arm that a family draws must be, for a class in which nobody's arm is harder than another's."""

from collections import Counter
from functools import cache

import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.variation import VARIATION_STEPS, find_canonical_name
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import list_applicable_questions, list_questions_of_family, sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.singularities.difficulty import rate_difficulty, rate_difficulty_band
from qdot.exercises.singularities.singular_set import find_singular_set
from tests.support.suites import FEW, every_family, on_families, sample_for_suite, select_for_suite

ARMS = 80
DERIVED = select_for_suite(2, 20)
"""Arms of each family that are derived; what their tables say is looked at in all."""
FIXED = [name for name, family in FAMILIES.items() if not family.has_varied_structure]
few_fixed = pytest.mark.families(select_for_suite(FEW, tuple(FIXED)), every=True)
"""Families whose arms are all of one kind; what random-N may differ in is tested with them."""
MOST_TERMS, MOST_TERMS_OF_A_FACTOR = 15, 4
ALLOWED = {
    "orthogonal-3r": 19, "scorbot-wrist": 25, "scorbot-tip": 36, "stanford-6r": 34, "puma-560": 44,
    "anthropomorphic-6r": 34, "industrial-6r": 44, "ur-6r": 41, "lbr-7r": 83,
}  # fmt: skip
"""Terms of J that a family may have beyond what is done by hand: most are asked block by block, or in numbers."""


@cache
def arms(family: str, variation: str = "full") -> tuple[Chain, ...]:
    return tuple(sample_chain(ProblemId(family, seed, variation=variation)) for seed in range(ARMS))


@every_family
def test_the_chapters_arm_is_plain(family: str) -> None:
    """Lengths are symbols, the base is the world, P an origin; a zero is that of the table, and of slides none."""
    for arm in (sample_chain(ProblemId(family, seed, variation="chapter")) for seed in range(3)):
        assert arm.base.is_world and arm.point.is_origin
        lengths = [joint.a for joint in arm.joints] + [joint.d for joint in arm.joints]
        assert all(length == 0 or length.is_Symbol for length in lengths)
        assert not any(arm.offsets) or family == "wrist-rpy"
        assert family not in FIXED or arm == FAMILIES[family].textbook_arm
    assert FAMILIES[family].name == family and FAMILIES[family].title and FAMILIES[family].source


@on_families(FIXED)
def test_an_axis_changes_one_thing(family: str) -> None:
    """Along one axis alone, an arm differs from the plain one in what the axis is called after, and in nothing else."""
    plain = sample_chain(ProblemId(family, 0, variation="chapter"))
    for axis in FAMILIES[family].variation_names:
        varied = [sample_chain(ProblemId(family, seed, variation=find_canonical_name([axis]))) for seed in range(12)]
        changed = set().union(*(differences(plain, arm) for arm in varied))
        allowed = {
            "lengths": {"lengths"}, "zeros": {"zeros"}, "senses": {"twists"}, "base": {"base"},
            "tool": {"point", "lengths"}, "task": {"base", "task"},
        }[axis]  # fmt: skip
        assert changed <= allowed, axis
        assert changed or (axis, plain.joints[-1].kind) == ("tool", "P")  # P needs a length that it can have


def differences(one: Chain, other: Chain) -> set[str]:
    seen = [
        {
            "lengths": [(joint.a, joint.d if joint.is_revolute else 0) for joint in chain.joints],
            "zeros": chain.offsets, "twists": [joint.alpha for joint in chain.joints], "base": chain.base,
            "point": chain.point, "task": chain.task,
        }
        for chain in (one, other)
    ]  # fmt: skip
    return {what for what in seen[0] if seen[0][what] != seen[1][what]}


@on_families(FIXED)
def test_a_seed_draws_the_same_along_an_axis_whatever_else_varies(family: str) -> None:
    """Zeros at the step of zeros are those of the step behind it."""
    for seed in range(5):
        zeros, frames = (sample_chain(ProblemId(family, seed, variation=step)) for step in ("zeros", "frames"))
        assert zeros.offsets == frames.offsets
        assert [joint.a for joint in zeros.joints] == [joint.a for joint in frames.joints]


@few_fixed
def test_difficulty_follows_the_steps(family: str) -> None:
    least = [min(rate_difficulty(arm) for arm in arms(family, step)[:3]) for step in VARIATION_STEPS]
    assert least == sorted(least)


@on_families(FIXED)
@pytest.mark.parametrize("variation", VARIATION_STEPS)
def test_numbers_are_those_of_a_careful_author(family: str, variation: str) -> None:
    """Lengths and places in steps of 5 cm, angles that are multiples of 15 degrees.

    No two links are nearly as long: equal lengths add singular configurations that nobody asked for.
    """
    for arm in arms(family, variation):
        lengths = [length for joint in arm.joints for length in (joint.a, joint.d)]
        values = [*lengths, *arm.base.position, *arm.point.offset, *arm.offsets]
        angles = [value for value in (*arm.offsets, arm.base.yaw, arm.base.tilt) if value.has(sp.pi)]
        assert all((20 * value).is_Integer for value in values if value.is_Rational), arm
        assert all((12 * angle / sp.pi).is_Integer for angle in angles), arm
        links = [joint.a for joint in arm.joints] + [joint.d for joint in arm.joints if joint.is_revolute]
        given = [float(length) for length in links if length.is_number and length != 0]
        assert all(abs(x - y) > 0.045 for i, x in enumerate(given) for y in given[:i]), arm


@pytest.mark.parametrize("variation", select_for_suite([*VARIATION_STEPS][-1:], [*VARIATION_STEPS]))
@few_fixed
def test_arms_of_a_family_are_asked_the_same_and_differ_in_difficulty_by_a_step_at_most(
    family: str, variation: str
) -> None:
    some = arms(family, variation)[:DERIVED]
    assert {list_applicable_questions(arm) for arm in some} == {list_questions_of_family(family)}
    steps = [rate_difficulty_band(arm) for arm in some]
    assert max(steps) - min(steps) <= 1


@pytest.mark.parametrize(
    ("identity", "expected"),
    [
        ("elbow-3r/0@chapter", (15 + 4 * 2 + 8, 3)),  # 15 terms of J, two factors, one of which ties several joints
        ("planar-2r/0@chapter", (6 + 4, 1)), ("planar-2r/0@zeros", (6 + 4 + 2, 1)),
        ("planar-2r/0@base", (6 + 4 + 2, 1)),
    ],
)  # fmt: skip
def test_the_scale_of_difficulty(identity: str, expected: tuple[int, int]) -> None:
    arm = sample_chain(ProblemId.parse(identity))
    assert (rate_difficulty(arm), rate_difficulty_band(arm)) == expected


@on_families(FIXED)
def test_every_arm_can_be_done_by_hand(family: str) -> None:
    most = ALLOWED.get(family, MOST_TERMS)
    for arm in arms(family)[:DERIVED]:
        entries = [sp.expand(entry) for entry in derive(arm).jacobian]
        assert sum(len(sp.Add.make_args(entry)) for entry in entries if entry != 0) <= most
        conditions = [condition for component in find_singular_set(arm) or () for condition in component.conditions]
        assert all(len(sp.Add.make_args(sp.expand(one))) <= MOST_TERMS_OF_A_FACTOR for one in conditions)


@on_families(FIXED)
def test_arms_differ_and_not_in_joints_task_and_number_of_symbols(family: str) -> None:
    """At most three quarters of the class share the place of P, and at most as many the directions of the axes."""
    assert len({tuple(joint.kind for joint in arm.joints) for arm in arms(family)}) == 1
    assert len({arm.task for arm in arms(family, "frames")}) == 1
    assert len({len(arm.parameters) for arm in arms(family)}) == 1
    assert len(set(arms(family))) > 0.95 * ARMS
    places = Counter(
        (arm.point.frame, tuple(map(bool, arm.point.offset)), arm.joints[-1].a == 0) for arm in arms(family)
    )
    axes = Counter(tuple(joint.alpha for joint in arm.joints) for arm in arms(family))
    assert max(*places.values(), *axes.values()) <= 0.75 * ARMS


@pytest.mark.parametrize("family", sample_for_suite([name for name in FAMILIES if name not in FIXED], 1))
def test_the_point_of_interest_differs_with_the_structure(family: str) -> None:
    """A structure without a last length has no place for P except the last origin."""
    draws = select_for_suite(10, 40)
    held = [not sample_chain(ProblemId(family, seed, variation="full")).point.is_origin for seed in range(draws)]
    assert draws // 10 <= sum(held) <= draws - draws // 10


@few_fixed
def test_answers_differ(family: str) -> None:
    """At most an eighth of the class share a Jacobian, except for Cartesian arms, whose entries are ones."""
    looked_at = select_for_suite(20, 60)
    jacobians = Counter(tuple(derive(arm).jacobian) for arm in arms(family)[:looked_at])
    assert max(jacobians.values()) <= looked_at // 8
