"""Arms whose structure is drawn: the table holds all clean structures, and every draw is one of them."""

import pickle
from collections import Counter

import pytest
import sympy as sp

from exercises.arm.chain import Chain
from exercises.arm.derivation import structure
from exercises.arm.singularity import singular_set
from exercises.difficulty import step
from exercises.docs.structures import regular_tables
from exercises.errors import QdotError
from exercises.families import FAMILIES
from exercises.families.structures import (
    TABLE,
    Row,
    chain_of,
    clean_structures,
    count_tables,
    find_clean,
    is_clean,
    normal,
    regular_forms,
    regular_tasks,
    tables,
)
from exercises.generate import generate, sample_chain
from exercises.problem import ProblemId
from exercises.questions import QUESTIONS
from grader.certify import failures_of

RANDOM = ("random-2", "random-3", "random-4")


def test_the_numbers_of_tables_are_those_that_were_counted_before() -> None:
    """Counts of the shared mathematics: tables, and those of three joints that are regular in some task."""
    assert (count_tables(2, False), count_tables(3, False), count_tables(3, True)) == (108, 1944, 4608)
    assert (regular_tables(False), regular_tables(True)) == (1024, 2504)


@pytest.mark.parametrize("n", [2, 3])
def test_the_table_holds_all_clean_structures(n: int) -> None:
    assert tuple(find_clean(n)) == clean_structures()[n]


def test_the_table_of_four_joints_holds_the_clean_ones_of_a_sample() -> None:
    known = {(structure.rows, structure.task) for structure in clean_structures()[4]}
    for index, (rows, tasks) in enumerate(regular_forms(4).items()):
        if index % 25 == 0:
            for task in tasks:
                assert ((rows, task) in known) == is_clean(chain_of(rows, task)), rows


@pytest.mark.parametrize("n", [2, 3])
def test_a_normal_form_is_regular_where_its_tables_are(n: int) -> None:
    seen: dict[tuple[Row, ...], set[int]] = {}
    for rows in tables(n, True):
        assert normal(normal(rows)) == normal(rows)
        seen.setdefault(normal(rows), set()).add(len(regular_tasks(rows)) > 0)
    assert all(len(found) == 1 for found in seen.values())


def test_every_clean_structure_is_reached() -> None:
    """Draws go evenly over the structures of two joints; of three joints, 400 draws meet very many."""
    seen = Counter(code_of(sample_chain(ProblemId("random-2", seed))) for seed in range(400))
    assert len(seen) == len({(s.rows, s.task) for s in clean_structures()[2]})
    assert len({code_of(sample_chain(ProblemId("random-3", seed))) for seed in range(150)}) > 80


def code_of(chain: Chain) -> tuple[object, ...]:
    rows = [(j.kind, j.a != 0, (j.d != 0) if j.kind == "R" else (j.theta != 0), j.alpha != 0) for j in chain.joints]
    return (*rows, chain.task)


@pytest.mark.parametrize("family", RANDOM)
def test_every_arm_is_clean_and_all_its_conditions_can_hold(family: str, seeds: range) -> None:
    for seed in seeds:
        chain = sample_chain(ProblemId(family, seed))
        assert is_clean(structure(chain).chain)
        for component in singular_set(chain) or ():
            for _, values in component.solutions or ():
                assert all(value.is_real is not False for value in values)
        lengths = [joint.a for joint in chain.joints if joint.a.is_number and joint.a != 0]
        assert all(abs(a - b) >= sp.Rational(5, 100) for i, a in enumerate(lengths) for b in lengths[:i])


@pytest.mark.parametrize("family", RANDOM)
def test_problems_pass_their_certificate(family: str, seeds: range) -> None:
    for seed in seeds[:4]:
        assert failures_of(generate(ProblemId(family, seed))) == []


@pytest.mark.parametrize("band", [(0, 0), (1, 2)])
def test_a_band_of_difficulty_is_kept(band: tuple[int, int]) -> None:
    for seed in range(6):
        assert band[0] <= step(sample_chain(ProblemId("random-3", seed, band=band))) <= band[1]


def test_only_arms_to_which_all_questions_apply_are_drawn() -> None:
    asked = ("determinant", "singular-angles", "inverse-velocity")
    for seed in range(5):
        problem = generate(ProblemId("random-3", seed, asked))
        assert [part.name for part in problem.parts] == list(asked)
        assert all(QUESTIONS[name].refusal(problem.chain) is None for name in asked)


def test_what_no_arm_can_be_asked_is_said() -> None:
    with pytest.raises(QdotError, match="random-2 has no arm of any difficulty that can be asked"):
        sample_chain(ProblemId("random-2", 1, ("block-determinants",)))
    with pytest.raises(QdotError, match="random-2 has no arm of difficulty 4 to 4"):
        sample_chain(ProblemId("random-2", 1, band=(4, 4)))


def test_families_travel_to_other_processes() -> None:
    for name in RANDOM:
        assert pickle.loads(pickle.dumps(FAMILIES[name])).name == name


def test_the_table_is_text_that_a_person_can_read() -> None:
    first, *lines = TABLE.read_text(encoding="utf-8").splitlines()
    assert first.startswith("#")
    assert all(line.count("|") == 2 for line in lines)
