"""Short questions on the concepts: distinct options, balanced letters, and what they ask of the arms of the books."""

from collections import Counter
from collections.abc import Iterator
from itertools import count, islice
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
    parse_vector,
)
from qdot.exercises.questions.differentiation import TaskDetails
from qdot.exercises.questions.rank import MeaningDetails
from qdot.exercises.reference_answers import Choice, Selection
from qdot.exercises.short_questions import ALL_QUESTIONS, SHORT_QUESTIONS
from qdot.exercises.short_questions.options import ConfigurationOptions, Options
from tests.support.problems import LONG_ARMS, ask_question, choose_convention
from tests.support.suites import SHAPES, on_families, select_for_suite

BALANCED_CHOICES = ("joint-effect", "invertibility", "singularity-meaning")
CHOICES = (*BALANCED_CHOICES, "singularity-type")
SHORT_CHOICES = tuple(
    question.name for question in SHORT_QUESTIONS.values() if question.form in ("choice", "selection", "true or false")
)
SAME_OPTIONS = ("invertibility", "singularity-type", "true-or-false", "dependence")
"""Questions whose options are the same for every arm (four statements about (6.7), the types of singularities, true and
false) or for every arm of a family (its joints); each student has another arm and configuration to judge by them."""


@pytest.mark.parametrize("name", BALANCED_CHOICES)
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


def test_a_joint_that_does_not_move_the_point_is_not_asked_about(textbook_arms: dict[str, Any]) -> None:
    chain = textbook_arms["PUMA560"].chain
    joints = {
        ask_question("joint-effect", chain, seed).parts[0].details_as(JointEffectDetails).joint for seed in range(10)
    }
    assert joints <= {1, 2, 3}
    wrist = ask_question("joint-effect", textbook_arms["ZYZ_wrist"].chain, 0).parts[0]
    assert wrist.details_as(JointEffectDetails).rows == ("wx", "wy", "wz")


LONG_ARM = SHAPES["six joints"]
OFFERED_OPTIONS = [name for name in FAMILIES if name == LONG_ARM or name not in LONG_ARMS]


@on_families(select_for_suite(("planar-2r", "polar-rp", "pan-tilt", "wrist-zyz"), OFFERED_OPTIONS))
@pytest.mark.parametrize("name", [*CHOICES, *SHORT_CHOICES])
def test_options_do_not_give_the_right_one_away(family: str, name: str) -> None:
    """No feature that is visible without a calculation shows it, and it can't be learnt from another student.

    Features are shape, zeros, multiples, an introduction or a formula in a number.
    """
    parts = _iterate_parts(family, name)
    sets_of_options = set[frozenset[str]]()
    for part in islice(parts, 2):
        sets_of_options.add(frozenset(part.answer.offered_options))
        for feature, values in _list_features(part).items():
            right, wrong = (
                {value for i, value in enumerate(values) if (i in _list_correct(part)) is is_right}
                for is_right in (True, False)
            )
            assert right & wrong, (family, part.details, feature, values)
    has_one_false_statement = name == "singularity-meaning" and family in ("polar-rp", "planar-pr")
    if name in SAME_OPTIONS or has_one_false_statement or not sets_of_options:
        return
    for part in islice(parts, 18):
        if len(sets_of_options) > 1:
            break
        sets_of_options.add(frozenset(part.answer.offered_options))
    assert len(sets_of_options) > 1


@pytest.mark.parametrize("family", ["planar-2r", "elbow-3r"])
def test_every_question_with_options_is_in_these_lists(family: str) -> None:
    parts = generate(ProblemId(family, 0)).parts
    names = {part.kind for part in parts if isinstance(part.answer, Choice | Selection)}
    assert names and names <= {*CHOICES, *SHORT_CHOICES}


def _iterate_parts(family: str, name: str) -> Iterator[Part]:
    """Yield the part of problems with one question; none if the question doesn't apply to the family."""
    for seed in count():
        try:
            yield generate(ProblemId(family, seed, (name,), convention=choose_convention(ALL_QUESTIONS[name]))).parts[0]
        except QdotError:
            return


def _list_correct(part: Part) -> tuple[int, ...]:
    return (part.answer.correct,) if isinstance(part.answer, Choice) else part.answer_as(Selection).correct


def _list_features(part: Part) -> dict[str, list[Any]]:
    """Return for each feature its values for the options."""
    details, texts = part.details, part.answer.offered_options
    if isinstance(details, ConfigurationOptions):
        assert not details.rounded_joints
        return {"root": [bool(configuration.formula_roots) for configuration in details.offered_configurations]}
    if isinstance(details, Options):
        contents = [option.content for option in details.offered_options]
        if details.offered_options[0].is_set:
            return {"pieces": [text.count(" or ") for text in texts]}
        matrices = [content if isinstance(content, sp.MatrixBase) else sp.Matrix([content]) for content in contents]
        return {
            "shape": [matrix.shape for matrix in matrices],
            "zeros": [sum(entry == 0 for entry in matrix) for matrix in matrices],
        }
    if isinstance(details, JointEffectDetails):
        assert not details.configuration.rounded_values
        vectors = np.array([parse_vector(option) for option in texts])
        units = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
        parallel_counts = (np.abs(units @ units.T) > 0.99).sum(axis=1).tolist()
        assert set(parallel_counts) == {2}
        return {"zero": [0 in vector for vector in vectors]}
    if isinstance(details, MeaningDetails):
        words = [option.meaning.words for option in details.options]
        return {
            "remark": [bool(option.meaning.remark) for option in details.options],
            "repeated": [words.count(each) for each in words],
        }
    assert part.kind in SAME_OPTIONS
    return {}
