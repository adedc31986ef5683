"""Families: what varies along each axis, and arms whose structure is drawn from the table of clean ones."""

import pickle
from collections import Counter
from functools import cache
from itertools import islice

import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.vectors import rot_x, rot_z
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.common.variation import VARIATION_AXES, VARIATION_STEPS, find_canonical_name
from qdot.exercises.derivation.derivation import derive, make_symbolic_arm
from qdot.exercises.families import FAMILIES
from qdot.exercises.families.random_structures import _order_structures as order
from qdot.exercises.families.random_structures import _sample_arm as arm_of
from qdot.exercises.families.structures import (
    Structure,
    StructureRow,
    build_arm,
    group_clean_structures,
    is_clean,
    parse_rows,
    read_clean_structures,
)
from qdot.exercises.generation import generate, list_applicable_questions, list_questions_of_family, sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.singularities.difficulty import HARDEST_LEVEL, rate_difficulty, rate_difficulty_level
from qdot.exercises.singularities.singular_set import find_singular_set
from qdot.grader.grading.certify import find_failures
from tests.support.problems import fold_tool_into_table
from tests.support.problems import get_problem as drawn_once
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
        assert family not in FIXED or arm == FAMILIES[family].chapter_arm
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


@pytest.mark.parametrize("variation", select_for_suite([*VARIATION_STEPS][-1:], [*VARIATION_STEPS][::2]))
@few_fixed
def test_arms_of_a_family_are_asked_the_same_and_differ_in_difficulty_by_a_step_at_most(
    family: str, variation: str
) -> None:
    some = arms(family, variation)[:DERIVED]
    assert {list_applicable_questions(arm) for arm in some} == {list_questions_of_family(family)}
    steps = [rate_difficulty_level(arm) for arm in some]
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
    assert (rate_difficulty(arm), rate_difficulty_level(arm)) == expected


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


@pytest.mark.parametrize(("n", "each"), select_for_suite([(2, 2), (3, 12), (4, 60)], [(2, 1), (3, 1), (4, 4)]))
def test_structures_of_the_table_are_clean_and_as_difficult_as_it_says(n: int, each: int) -> None:
    for structure in islice(read_clean_structures()[n], 0, None, each):
        chain = build_arm(structure.rows, structure.task)
        assert is_clean(chain) and rate_difficulty_level(chain) == structure.level, structure


@pytest.mark.parametrize("code", ["Rdx Rax Ra", "Rax Rx Rax Ra"])
def test_an_arm_with_a_long_jacobian_is_not_clean(code: str) -> None:
    assert not is_clean(build_arm(parse_rows(code), ("vx", "vy", "vz")))


@pytest.mark.parametrize("n", [2, 3])
def test_the_same_joints_are_in_the_conditions_of_all_clean_structures_of_a_class(n: int) -> None:
    for alike in islice(group_clean_structures(n), 0, None, select_for_suite(4, 1)):
        assert len({conditions_of(structure) for structure in alike}) == 1, alike


def conditions_of(structure: Structure) -> tuple[tuple[str, ...], ...]:
    chain = build_arm(structure.rows, structure.task)
    kinds = [row.kind for row in structure.rows]
    place = {q: sum(kinds[:i].count(k) for k in "R") if kinds[i] == "P" else -i for i, q in enumerate(chain.q)}
    found = [c for component in find_singular_set(chain) or () for c in component.conditions]
    return tuple(sorted(tuple(sorted(str(place[q]) for q in chain.q if c.has(q))) for c in found))


def drawn(chain: Chain) -> tuple[tuple[StructureRow, ...], tuple[str, ...]]:
    """The structure of an arm, and its task in the axes of the base; lengths that P has are put back into the table."""
    rows = tuple(
        StructureRow(j.kind, j.a != 0, bool((j.d if j.is_revolute else j.theta) != 0), j.alpha != 0)
        for j in fold_tool_into_table(chain).joints
    )
    rotation = rot_z(chain.base.yaw) * rot_x(chain.base.tilt)
    names = {"xyz"[next(i for i in range(3) if rotation[i, k] != 0)]: "xyz"[k] for k in range(3)}
    counted = {row[0] + names[row[1]] for row in chain.task}
    return rows, tuple(row for row in VELOCITY_NAMES if row in counted)


def arm(family: str, seed: str) -> Chain:
    structures = FAMILIES[family].sample_structure
    assert structures is not None
    return structures(Stream(seed), VARIATION_AXES)


@pytest.mark.whole
def test_an_arm_is_of_the_structure_that_is_drawn_first_and_all_classes_are_reached_as_often() -> None:
    firsts = [order(list(group_clean_structures(2)), Stream(f"reached/{seed}"))[0] for seed in range(900)]
    for seed in range(select_for_suite(30, 900)):
        assert drawn(arm("random-2", f"reached/{seed}")) == (firsts[seed].rows, firsts[seed].task)
    assert {(first.rows, first.task) for first in firsts} == {(s.rows, s.task) for s in read_clean_structures()[2]}
    often = Counter(first.class_number for first in firsts)
    assert len(often) == len(group_clean_structures(2))
    assert max(often.values()) < 2 * min(often.values())


@pytest.mark.parametrize("n", select_for_suite([3], [3, 4]))
def test_numbers_are_found_for_every_class(n: int) -> None:
    for alike in islice(group_clean_structures(n), 0, None, select_for_suite({3: 3, 4: 8}[n], 1)):
        chain = arm_of(alike[0], Stream("numbers"), VARIATION_AXES)
        assert chain is not None and is_clean(chain), alike[0]
        assert drawn(chain) == (alike[0].rows, alike[0].task)


@pytest.mark.whole
def test_mirror_images_and_mountings_are_drawn() -> None:
    chains = [arm("random-3", f"mirrored/{seed}") for seed in range(select_for_suite(24, 40))]
    assert {joint.alpha for chain in chains for joint in chain.joints} == {0, sp.pi / 2, -sp.pi / 2}
    assert {chain.base.tilt for chain in chains} == {0, sp.pi, sp.pi / 2, -sp.pi / 2}
    assert all(chain.base.position[2] == 0 for chain in chains if chain.is_planar)


@pytest.mark.parametrize("family", sample_for_suite(("random-2", "random-3", "random-4"), 1))
def test_every_arm_is_clean_and_all_its_conditions_can_hold(family: str, seeds: range) -> None:
    for seed in seeds:
        chain = sample_chain(ProblemId(family, seed, variation="full"))
        assert is_clean(make_symbolic_arm(chain).chain)
        for component in find_singular_set(chain) or ():
            for _, values in component.solutions or ():
                assert all(value.is_real is not False for value in values)
        lengths = [joint.a for joint in chain.joints if joint.a.is_number and joint.a != 0]
        assert all(abs(a - b) >= sp.Rational(5, 100) for i, a in enumerate(lengths) for b in lengths[:i])
    for seed in seeds[: select_for_suite(1, 4)]:
        assert find_failures(drawn_once(family, seed)) == []
    assert pickle.loads(pickle.dumps(FAMILIES[family])).name == family


@pytest.mark.parametrize("band", [(0, 0), (1, 2)])
def test_a_band_of_difficulty_is_kept(band: tuple[int, int]) -> None:
    for seed in range(6):
        assert band[0] <= rate_difficulty_level(sample_chain(ProblemId("random-3", seed, band=band))) <= band[1]


def test_only_arms_to_which_all_questions_apply_are_drawn() -> None:
    asked = ("determinant", "singular-angles", "inverse-velocity")
    for seed in range(5):
        problem = generate(ProblemId("random-3", seed, asked))
        assert [part.name for part in problem.parts] == list(asked)
        assert all(QUESTIONS[name].find_obstacle(problem.chain) is None for name in asked)


@pytest.mark.parametrize(
    ("identity", "said"),
    [
        (ProblemId("random-2", 1, ("block-determinants",)), "random-2 has no arm of any difficulty"),
        (ProblemId("random-2", 1, band=(4, 4)), "random-2 has no arm of difficulty 4; .* 0 to 2"),
    ],
)
def test_what_no_arm_can_be_asked_is_said(identity: ProblemId, said: str) -> None:
    with pytest.raises(QdotError, match=said):
        sample_chain(identity)


COUNTS = {2: [23, 11, 7, 0, 0], 3: [51, 110, 65, 33, 0], 4: [80, 445, 142, 0, 0]}
"""The numbers of clean structures by number of joints and level of difficulty."""


@pytest.mark.parametrize(("n", "classes"), [(2, 16), (3, 63), (4, 46)])
def test_structures_and_classes_are_counted(n: int, classes: int) -> None:
    levels = Counter(structure.level for structure in read_clean_structures()[n])
    assert [levels[level] for level in range(HARDEST_LEVEL + 1)] == COUNTS[n]
    assert len(group_clean_structures(n)) == classes
