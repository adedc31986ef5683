"""Short questions on the concepts: right for every arm, distinct options, balanced letters, wrong references found."""

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from exercises.answers import Choice, Number
from exercises.generation import generate
from exercises.problem import ProblemId
from exercises.questions import QUESTIONS
from exercises.questions.concepts import USES, ForUse, OfCost, OfJoint
from exercises.questions.differentiation import ForTask
from exercises.verify import certify
from tests.support.problems import asked, with_answer
from tests.support.suites import of_families, several

DRAWS = several(12, 30)
"""Problems whose letters are counted."""
NAMES = ("jacobian-size", "joint-effect", "invertibility", "unreachable-velocity")
CHOICES = NAMES[1:]
OLD = ("planar-2r", "elbow-3r", "planar-3r", "polar-rp")
COUNTED = several(OLD[:1] + OLD[3:], OLD)
"""Families whose letters are counted."""


@pytest.mark.parametrize("name", CHOICES)
@of_families(COUNTED)
def test_letters_are_balanced_and_options_distinct(family: str, name: str) -> None:
    answers = [generate(ProblemId(family, 1000 + seed, (name,))).parts[0].answer for seed in range(DRAWS)]
    letters: Counter[str] = Counter()
    for answer in answers:
        assert isinstance(answer, Choice)
        assert len(set(answer.options)) == len(answer.options) == 4
        letters[answer.letter] += 1
    assert max(letters.values()) <= 0.7 * DRAWS
    assert len(letters) >= 3


@pytest.mark.parametrize("name", CHOICES)
@of_families(OLD)
def test_another_letter_fails_the_certificate(family: str, name: str) -> None:
    problem = generate(ProblemId(family, 4, (name,)))
    answer = problem.parts[0].answer
    assert isinstance(answer, Choice)
    for letter in range(4):
        assert certify(with_answer(problem, Choice(answer.options, letter))).passed == (letter == answer.correct)


def test_a_wrong_size_is_found() -> None:
    problem = generate(ProblemId("planar-3r", 4, ("jacobian-size",)))
    answer = problem.parts[0].answer
    assert isinstance(answer, Number)
    rows, columns = answer.reference
    assert columns == 3
    for wrong in ([rows + 1, columns], [rows, columns + 1], [rows]):
        assert not certify(with_answer(problem, replace(answer, reference=sp.Matrix(wrong)))).passed


def test_the_task_differs_from_the_statements_and_moves() -> None:
    sizes = set()
    for seed in range(12):
        problem = generate(ProblemId("planar-2r", seed, ("jacobian-size",)))
        task = problem.parts[0].about(ForTask).task
        assert task != problem.chain.task
        assert set(task) <= {"vx", "vy", "wz"}
        sizes.add(len(task))
    assert sizes == {1, 2, 3}


def test_every_use_occurs_where_it_can(textbook_arms: dict[str, Any]) -> None:
    possible = {
        "planar_2R": set(USES), "elbow_RRR": set(USES), "planar_3R_position": set(USES) - {"few"},
        "PUMA560": set(USES) - {"few"}, "cartesian_PPP": {"regular", "redundant"},
    }  # fmt: skip
    for name, uses in possible.items():
        problems = [asked("invertibility", textbook_arms[name].chain, seed) for seed in range(24)]
        found = Counter(problem.parts[0].about(ForUse).use for problem in problems)
        assert set(found) == uses, name
        assert max(found.values()) < 20


def test_velocities_at_the_stretched_arm(textbook_arms: dict[str, Any]) -> None:
    """Planar 2R in line: what has a component along the arm can't be produced, what is square to it can."""
    chain = textbook_arms["planar_2R"].chain
    seen = set()
    for seed in range(10):
        (part,) = asked("unreachable-velocity", chain, seed).parts
        cost, answer = part.about(OfCost).cost, part.answer
        assert isinstance(answer, Choice)
        turn = float(cost.place.joints[sp.Symbol("theta1")])
        along = np.array([np.cos(turn), np.sin(turn)])
        velocities = [np.array([float(x) for x in option.strip("()").split(",")]) for option in answer.options]
        lost = [abs(v @ along) / np.linalg.norm(v) > 0.3 for v in velocities]
        assert lost.count(True) == (3 if cost.possible else 1)
        assert lost[answer.correct] == (not cost.possible)
        seen.add(cost.possible)
    assert seen == {True, False}


def test_a_joint_that_does_not_move_the_point_is_not_asked_about(textbook_arms: dict[str, Any]) -> None:
    chain = textbook_arms["PUMA560"].chain
    joints = {asked("joint-effect", chain, seed).parts[0].about(OfJoint).effect.joint for seed in range(10)}
    assert joints <= {1, 2, 3}
    wrist = asked("joint-effect", textbook_arms["ZYZ_wrist"].chain, 0).parts[0]
    assert wrist.about(OfJoint).effect.rows == ("wx", "wy", "wz")


def test_objections(textbook_arms: dict[str, Any]) -> None:
    objection = QUESTIONS["unreachable-velocity"].objection
    assert objection(textbook_arms["cartesian_PPP"].chain) == "it has no singular configuration"
    assert objection(textbook_arms["PUMA560"].chain) == "its task counts 6 components of velocity"
    assert objection(textbook_arms["planar_2R"].chain) is None
