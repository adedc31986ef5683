"""Rank, lost direction and meaning of singular configurations: correct for every arm, wrong references detected."""

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import make_symbolic_arm
from qdot.exercises.generation import generate
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions.exact_configurations import (
    _find_zeros,
    evaluate_jacobian,
    match_branches,
    round_to_integer,
    sample_regular_configuration,
    sample_singular_configuration,
)
from qdot.exercises.questions.rank import RankDetails
from qdot.exercises.reference_answers import Choice, Direction, Number
from qdot.exercises.singularities.directions import find_clear_rank
from qdot.exercises.singularities.singular_set import find_singular_set
from qdot.exercises.verify.certificate import certify
from qdot.exercises.writing.problem_texts import write_solution
from tests.support.problems import ask_question, get_problem, replace_answer
from tests.support.suites import select_for_suite


def test_rank_varies_between_seeds(textbook_arms: dict[str, Any]) -> None:
    """Poses are regular, on one component, or where two meet: the stretched elbow with P above the shoulder.

    Components that meet only in poses without exact values, as a PUMA's, are not used.
    """
    for name, ranks, draws in (("planar_2R", {1, 2}, 20), ("elbow_RRR", {1, 2, 3}, 20), ("PUMA560", {5, 6}, 4)):
        problems = [
            ask_question("rank", textbook_arms[name].chain, seed) for seed in range(select_for_suite(draws, 30))
        ]
        counts = Counter(int(problem.parts[0].answer.as_matrix()[0]) for problem in problems)
        assert ranks <= set(counts), (name, counts)
        assert max(counts.values()) <= 0.8 * len(problems)


def test_arm_with_bent_tool_loses_the_direction_from_joint_1() -> None:
    """P is on the line O_0 O_1 at both singular angles of planar-2r, although they contain an arctangent."""
    for seed in range(4):
        (part,) = generate(ProblemId("planar-2r", seed, ("lost-direction",))).parts
        assert part.answer_as(Direction).tolerance is None
        assert {symbol.name for symbol in part.answer_as(Direction).reference.free_symbols} == {"theta1"}


def test_lost_direction_is_numeric_without_a_short_formula(textbook_arms: dict[str, Any]) -> None:
    problem = ask_question("lost-direction", textbook_arms["orthogonal_3R"].chain, 3)
    answer = problem.parts[0].answer_as(Direction)
    assert answer.tolerance == 0.005
    assert not answer.reference.free_symbols
    for wrong in (sp.Matrix([1, 2, 3]).normalized(), 2 * answer.reference):
        numbers = wrong.applyfunc(lambda value: sp.N(value, 10))
        assert not certify(replace_answer(problem, replace(answer, reference=numbers))).passed


def test_sampled_poses_are_regular_or_singular_as_requested(textbook_arms: dict[str, Any]) -> None:
    for name in ("elbow_RRR", "orthogonal_3R", "PUMA560", "spherical_RRP", "Scorbot_5R_full_6x5"):
        chain = textbook_arms[name].chain
        full = min(len(chain.task), chain.n)
        regular = sample_regular_configuration(chain, Stream(name))
        assert regular is not None
        assert find_clear_rank(evaluate_jacobian(chain, regular)) == full
        for component in find_singular_set(chain) or ():
            if len(component.conditions) == 1:
                pose = sample_singular_configuration(chain, (component,), Stream(name))
                assert pose is not None
                assert find_clear_rank(evaluate_jacobian(chain, pose)) in range(full)
                assert len(set(pose.lengths.values())) == len(pose.lengths)


def test_branches_of_arm_and_structure_match() -> None:
    """An offset of 180 degrees exchanges the stretched and the folded arm."""
    for seed in range(12):
        chain = generate(ProblemId("planar-2r", seed, ("rank",))).chain
        offset = chain.offsets[1]
        for branch in match_branches(chain):
            ((_, arm_value),) = branch.component.list_value_combinations()[0]
            ((_, structure_value),) = branch.structure_component.list_value_combinations()[0]
            numbers = dict(make_symbolic_arm(chain).values)
            turns = sp.N((arm_value + offset - structure_value.xreplace(numbers)) / (2 * sp.pi))
            assert abs(turns - round(turns)) < 1e-9


@pytest.mark.whole
def test_kind_that_varies_is_left_out_of_the_meaning(textbook_arms: dict[str, Any]) -> None:
    """With a shoulder offset the stretched arm is on the boundary in front, but inside behind the column."""
    chain = textbook_arms["elbow_RRR_shoulder_offset_(Scorbot_point_P)"].chain
    texts = [
        ask_question("singularity-meaning", chain, seed).parts[0].answer for seed in range(select_for_suite(6, 10))
    ]
    meaning = "as far from the axis of joint 2 as joint 3 can bring it"
    stretched = [a for a in texts if isinstance(a, Choice) and meaning in a.options[a.correct]]
    assert stretched
    assert not any("singularity" in option for answer in stretched for option in answer.options)


def test_meaning_that_fails_in_some_configurations_is_not_correct() -> None:
    problem = generate(ProblemId("random-3", 10085, ("singularity-meaning",)).with_variation("full"))
    answer = problem.parts[0].answer_as(Choice)
    assert "folded" not in answer.options[answer.correct]
    assert certify(problem).passed


@pytest.mark.parametrize("family", ["elbow-3r", "elbow-lateral", "planar-3r", "scorbot-wrist"])
def test_rank_is_asked_at_an_exact_pose(family: str) -> None:
    """The stated pose gives the rank of the reference; a rounded one would give full rank."""
    chain, ranks = get_problem(family, 0).chain, set()
    for seed in range(9):
        (part,) = ask_question("rank", chain, seed).parts
        place, rank = part.details_as(RankDetails).configuration, int(part.answer_as(Number).reference[0])
        assert not place.rounded_values
        exact_joints = {q: sp.N(value, 14) for q, value in place.joints.items()}
        assert np.linalg.matrix_rank(evaluate_jacobian(chain, replace(place, joints=exact_joints)), 1e-10) == rank
        ranks.add(rank)
    assert len(ranks) > 1


@pytest.mark.parametrize("digits", [15, 20, 30, 40])
def test_rounding_to_integers_agrees_with_sympy(digits: int) -> None:
    """It rounds decimal digits, and halves to even: test near halves, at halves, and elsewhere."""
    stream = Stream(f"rounding/{digits}")
    near = [sp.Float(10, digits) ** -stream.integer_below(36) * side for side in (1, -1) for _ in range(60)]
    halves = [sp.Float(f"{stream.integer_below(8001) - 4000}.5", digits) + off for off in (*near, sp.S.Zero)]
    others = [
        sp.Float(str(stream.integer_below(10**9) - 5 * 10**8), digits) / 7 ** stream.integer_below(9) for _ in range(60)
    ]
    for value in (*halves, *others, sp.S.Zero, sp.Integer(-3), sp.Rational(-7, 2), sp.pi):
        assert round_to_integer(value) == round(value)


def test_factor_keeps_its_sign_throughout_a_solution() -> None:
    questions = ("determinant", "singularity-type")
    problem = generate(replace(ProblemId.parse("elbow-lateral/607@zeros"), questions=questions))
    for part in problem.parts:
        assert r"0.45 c_{2} - a_{3} \cos \varphi_{23}" in write_solution(problem, part)


@pytest.mark.parametrize("turn", range(8))
def test_zeros_of_condition_on_one_angle_lie_within_one_turn(turn: int) -> None:
    """They do even if the middle angle and the half width add up to more than 180 degrees."""
    q, middle = sp.Symbol("theta1"), turn * sp.pi / 4 - sp.pi
    for value in (sp.Rational(-9, 10), sp.Rational(1, 3), sp.Rational(4, 5)):
        zeros = _find_zeros(sp.cos(q - middle) + value, q, is_revolute=True)
        assert len(zeros) == 2
        assert all(abs(sp.cos(zero - sp.N(middle, 40)) + value) < 1e-15 for zero in zeros)
        assert all(abs(zero) <= 3.1416 for zero in zeros)
