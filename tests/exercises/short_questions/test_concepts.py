"""Short questions on the concepts: distinct options, balanced letters, and what they ask of the arms of the books."""

from collections import Counter
from itertools import islice
from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.common.errors import QdotError
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate, list_questions_of_family
from qdot.exercises.problem.problem import Part, ProblemId
from qdot.exercises.questions.concepts import (
    INVERTIBILITY_ANSWERS,
    InvertibilityDetails,
    JointEffectDetails,
    VelocityLossDetails,
    parse_vector,
)
from qdot.exercises.questions.differentiation import TaskDetails
from qdot.exercises.reference_answers import Choice, Selection
from qdot.exercises.short_questions.options import ConfigurationOptions, Options
from tests.support.problems import ask_question
from tests.support.suites import SHAPES, on_families, select_for_suite

CHOICES = ("joint-effect", "invertibility", "unreachable-velocity", "lost-motion", "singularity-meaning")
SHORT_CHOICES = ("singular-configurations", "singular-drawing", "column-choice", "vector-choice", "axis-choice")


@pytest.mark.parametrize("name", CHOICES)
@on_families(select_for_suite(("planar-2r", "polar-rp"), ("planar-2r", "polar-rp", "elbow-3r", "planar-3r")))
def test_letters_are_balanced_and_options_distinct(family: str, name: str) -> None:
    draws = select_for_suite(12, 30) if name in list_questions_of_family(family) else 0
    answers = [generate(ProblemId(family, 1000 + seed, (name,))).parts[0].answer_as(Choice) for seed in range(draws)]
    assert all(len(set(answer.options)) == len(answer.options) >= 3 for answer in answers)
    letters = Counter(answer.letters for answer in answers)
    assert not draws or (len(letters) >= 3 and max(letters.values()) <= 0.7 * draws)


def test_the_task_differs_from_the_statements_and_moves() -> None:
    sizes = set()
    for seed in range(12):
        problem = generate(ProblemId("planar-2r", seed, ("jacobian-size",)))
        task = problem.parts[0].details_as(TaskDetails).task
        assert task != problem.chain.task
        assert set(task) <= {"vx", "vy", "wz"}
        sizes.add(len(task))
    assert sizes == {1, 2, 3}


def test_every_use_occurs_where_it_can(textbook_arms: dict[str, Any]) -> None:
    possible = {
        "planar_2R": set(INVERTIBILITY_ANSWERS),
        "cartesian_PPP": {"regular", "redundant"},
        "planar_3R_position": set(INVERTIBILITY_ANSWERS) - {"few"},
        "elbow_RRR": set(INVERTIBILITY_ANSWERS),
        "PUMA560": set(INVERTIBILITY_ANSWERS) - {"few"},
    }
    for name, uses in islice(possible.items(), select_for_suite(3, None)):
        problems = [ask_question("invertibility", textbook_arms[name].chain, seed) for seed in range(24)]
        found = Counter(problem.parts[0].details_as(InvertibilityDetails).answer_key for problem in problems)
        assert set(found) == uses, name
        assert max(found.values()) < 20


def test_velocities_at_the_stretched_arm(textbook_arms: dict[str, Any]) -> None:
    """Planar 2R in line: what has a component along the arm can't be produced, what is square to it can."""
    chain = textbook_arms["planar_2R"].chain
    for seed in range(10):
        (part,) = ask_question("unreachable-velocity", chain, seed).parts
        cost, answer = part.details_as(VelocityLossDetails), part.answer_as(Choice)
        turn = float(cost.configuration.joints[sp.Symbol("theta1")])
        along = np.array([np.cos(turn), np.sin(turn)])
        velocities = [np.array([float(x) for x in option.strip("()").split(",")]) for option in answer.options]
        lost = [abs(v @ along) / np.linalg.norm(v) > 0.3 for v in velocities]
        assert cost.is_possible  # all possible velocities are multiples of one vector, so three of them would stand out
        assert lost.count(True) == 3 and not lost[answer.correct]


def test_a_joint_that_does_not_move_the_point_is_not_asked_about(textbook_arms: dict[str, Any]) -> None:
    chain = textbook_arms["PUMA560"].chain
    joints = {
        ask_question("joint-effect", chain, seed).parts[0].details_as(JointEffectDetails).joint for seed in range(10)
    }
    assert joints <= {1, 2, 3}
    wrist = ask_question("joint-effect", textbook_arms["ZYZ_wrist"].chain, 0).parts[0]
    assert wrist.details_as(JointEffectDetails).rows == ("wx", "wy", "wz")


@on_families(select_for_suite([name for name in SHAPES.values() if name != SHAPES["seven joints"]], tuple(FAMILIES)))
@pytest.mark.parametrize("name", ["unreachable-velocity", *SHORT_CHOICES])
def test_no_feature_separates_right_options_from_wrong_ones(family: str, name: str) -> None:
    """Features that are visible without a calculation: shape, zeros, equal entries, formulas such as arctan(3/4)."""
    for seed in range(select_for_suite(1, 2)):
        try:
            (part,) = generate(ProblemId(family, seed, (name,))).parts
        except QdotError:  # not asked about this family
            return
        for feature in _list_features(part):
            right, wrong = (
                {value for i, value in enumerate(feature) if (i in _list_correct(part)) is is_right}
                for is_right in (True, False)
            )
            assert right & wrong, (family, seed, name, feature)


def _list_correct(part: Part) -> tuple[int, ...]:
    return (part.answer.correct,) if isinstance(part.answer, Choice) else part.answer_as(Selection).correct


def _list_features(part: Part) -> list[list[Any]]:
    """Return for each feature its values for the options."""
    details = part.details
    if isinstance(details, ConfigurationOptions):
        assert not details.rounded_joints
        return [[bool(configuration.formula_roots) for configuration in details.offered_configurations]]
    if isinstance(details, Options):
        return [[option.content.shape for option in details.offered_options]]
    if isinstance(details, VelocityLossDetails):
        assert not details.configuration.rounded_values
        vectors = np.array([parse_vector(option) for option in part.answer_as(Choice).options])
        units = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
        cosines = np.abs(units @ units.T) - np.eye(len(units))
        assert cosines.max() < 0.99  # no option is a multiple of another one
        return [[0 in vector for vector in vectors]]
    return []
