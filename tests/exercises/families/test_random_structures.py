"""Arms whose structure is drawn: how many there are, and that each draw is one of the table's clean ones."""

import pickle
from collections import Counter
from itertools import islice

import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.vectors import rot_x, rot_z
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.common.variation import VARIATION_AXES
from qdot.exercises.derivation.derivation import make_symbolic_arm
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
from qdot.exercises.generation import generate, sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.singularities.difficulty import HARDEST_BAND, rate_difficulty_band
from qdot.exercises.singularities.singular_set import find_singular_set
from qdot.grader.grading.certify import find_failures
from tests.support.problems import fold_tool_into_table
from tests.support.problems import get_problem as drawn_once
from tests.support.suites import sample_for_suite, select_for_suite


@pytest.mark.parametrize(("n", "each"), select_for_suite([(2, 2), (3, 12), (4, 60)], [(2, 1), (3, 1), (4, 4)]))
def test_structures_of_the_table_are_clean_and_as_difficult_as_it_says(n: int, each: int) -> None:
    for structure in islice(read_clean_structures()[n], 0, None, each):
        chain = build_arm(structure.rows, structure.task)
        assert is_clean(chain) and rate_difficulty_band(chain) == structure.band, structure


@pytest.mark.parametrize("code", ["Rdx Rax Ra", "Rax Rx Rax Ra"])
def test_an_arm_with_long_conditions_is_not_clean(code: str) -> None:
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
        assert band[0] <= rate_difficulty_band(sample_chain(ProblemId("random-3", seed, band=band))) <= band[1]


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
"""The numbers of clean structures by number of joints and band of difficulty."""


@pytest.mark.parametrize(("n", "classes"), [(2, 16), (3, 63), (4, 46)])
def test_structures_and_classes_are_counted(n: int, classes: int) -> None:
    bands = Counter(structure.band for structure in read_clean_structures()[n])
    assert [bands[band] for band in range(HARDEST_BAND + 1)] == COUNTS[n]
    assert len(group_clean_structures(n)) == classes
