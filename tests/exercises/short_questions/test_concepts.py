"""Short questions on the concepts: distinct options, balanced letters, and the mistake behind each wrong option."""

from collections import Counter
from collections.abc import Iterator
from itertools import count, islice
from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot import read_answer
from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate, list_questions_of_family, sample_chain
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions.concepts import (
    INVERTIBILITY_ANSWERS,
    InvertibilityDetails,
    JointEffectDetails,
    parse_vector,
)
from qdot.exercises.questions.differentiation import TaskDetails
from qdot.exercises.questions.rank import MeaningDetails
from qdot.exercises.reference_answers import LETTERS, Choice, Letters, Selection
from qdot.exercises.short_questions import ALL_QUESTIONS, SHORT_QUESTIONS, wrong_sets
from qdot.exercises.short_questions.configurations import make_regular_configuration
from qdot.exercises.short_questions.option_mistakes import EFFECT_MISTAKES, explain_options
from qdot.exercises.short_questions.options import ConfigurationOptions, OfferedOption, Options
from qdot.exercises.short_questions.wrong_sets import make_four_sets
from qdot.exercises.singularities.singular_set import find_singular_set
from qdot.grader.diagnosis.diagnosis import diagnose
from tests.exercises.short_questions.test_quizzes import of_small, small
from tests.support.problems import LONG_ARMS, ask_question, choose_convention, get_problem
from tests.support.suites import SHAPES, on_families, sample_for_suite, select_for_suite

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
OFFERED_QUESTIONS = [
    pytest.param(family, name, marks=pytest.mark.xdist_group(family))
    for number, family in enumerate(select_for_suite(["planar-2r", "polar-rp"], OFFERED_OPTIONS))
    for name in [*CHOICES, *SHORT_CHOICES][number % 5 :: 5]
]
"""A fifth of the questions with options for each family; other families get the others."""


@pytest.mark.parametrize(("family", "name"), OFFERED_QUESTIONS)
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
                {value for i, value in enumerate(values) if (i in part.answer.correct_indices) is is_right}
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
    for seed in count():
        try:
            yield generate(ProblemId(family, seed, (name,), convention=choose_convention(ALL_QUESTIONS[name]))).parts[0]
        except QdotError:
            return


def _list_features(part: Part) -> dict[str, list[Any]]:
    details, texts = part.details, part.answer.offered_options
    if isinstance(details, ConfigurationOptions):
        assert not details.rounded_joints
        return {"root": [bool(configuration.formula_roots) for configuration in details.offered_configurations]}
    if isinstance(details, Options):
        contents = [option.content for option in details.offered_options]
        if details.offered_options[0].is_set:
            return {"pieces": [text.count(" or ") for text in texts]}
        matrices = [content if isinstance(content, sp.MatrixBase) else sp.Matrix([content]) for content in contents]
        zeros = [sum(entry == 0 for entry in matrix) for matrix in matrices]
        return {"shape": [matrix.shape for matrix in matrices], "zeros": zeros}
    if isinstance(details, JointEffectDetails):
        assert not details.configuration.rounded_values
        vectors = np.array([parse_vector(option) for option in texts])
        units = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
        parallel_counts = (np.abs(units @ units.T) > 0.99).sum(axis=1).tolist()
        assert set(parallel_counts) == {2}
        return {"zero": [0 in vector for vector in vectors]}
    if isinstance(details, MeaningDetails):
        words = [option.meaning.words for option in details.options]
        remarks = [bool(option.meaning.remark) for option in details.options]
        return {"remark": remarks, "repeated": [words.count(each) for each in words]}
    assert part.kind in SAME_OPTIONS
    return {}


WITH_LETTERS = [name for name, quiz in SHORT_QUESTIONS.items() if quiz.form != "number"]
WITH_OPPOSITES = {"joint-effect"}
"""Questions whose options are vectors with both signs: the opposite of a wrong vector needs no explanation."""
BY_OPTIONS_ALONE = {"motion-reversed", "joint-without-effect", "column-of-other-joint"}


def named(problem: Problem) -> set[str]:
    """Return the names of what is behind the options of a problem, which is checked."""
    found = set()
    for part in problem.parts:
        if isinstance(part.answer, Letters):
            for index, blames in enumerate(explain_options(problem, part, Stream("behind"))):
                is_silent = index in part.answer.correct_indices and not part.answer.matched_items
                if is_silent or part.name not in WITH_OPPOSITES:
                    assert bool(blames) != is_silent, (problem.id, part.name, index)
                assert all(blame.sentence and blame.mistake in CATALOGUE for blame in blames)
                found |= {blame.mistake for blame in blames}
    return found


@small
@pytest.mark.parametrize("name", sample_for_suite(WITH_LETTERS, 5))
def test_something_is_told_of_each_wrong_option_of_a_short_question(name: str) -> None:
    assert named(of_small(name))


@small
@pytest.mark.parametrize("family", ["planar-2r", "planar-3r", "elbow-3r", "scara", "spherical-offset", "wrist-zyz"])
def test_something_is_told_of_each_wrong_option_of_the_chapters_questions(family: str) -> None:
    assert named(get_problem(family, 0))


@small
@pytest.mark.parametrize("family", ["planar-2r", "polar-rp", "scara"])
def test_cause_of_a_wrong_velocity_of_a_joint_is_visible_in_its_numbers(family: str) -> None:
    """At a single configuration, many mistakes of the catalogue give the same few numbers by chance."""
    for seed in range(4):
        problem = generate(f"{family}/{seed}", ["joint-effect"])
        (part,) = problem.parts
        correct = parse_vector(part.answer.offered_options[part.answer.correct_indices[0]])
        for option, blames in zip(
            part.answer.offered_options, explain_options(problem, part, Stream("behind")), strict=True
        ):
            names = {blame.mistake for blame in blames}
            if parse_vector(option) == [-value for value in correct]:
                assert names <= {"sign", "column-of-other-joint"} and names
            assert names <= {*EFFECT_MISTAKES, "column-of-other-joint"}


@small
@pytest.mark.parametrize("name", ["singular-drawing", "match-columns", "true-or-false"])
def test_grader_names_what_the_chosen_option_shows(name: str) -> None:
    problem = of_small(name)
    part = problem.parts[0]
    if part.answer.matched_items:
        order = [*part.answer.correct_indices]
        answer = "".join(LETTERS[index] for index in [order[1], order[0], *order[2:]])
    else:
        answer = LETTERS[next(k for k in range(9) if k not in part.answer.correct_indices)]
        answer = part.answer.offered_options[LETTERS.index(answer)] if name == "true-or-false" else answer
    diagnosis = diagnose(problem, part, read_answer(problem, part, answer))
    assert diagnosis is not None
    assert set(diagnosis.mistakes) <= BY_OPTIONS_ALONE | {"regular-taken-for-singular", "singular-taken-for-regular"}


@small
def test_mistakes_that_only_options_tell_are_told() -> None:
    """A statement about a motion is drawn by some seeds only."""
    found = set().union(*(named(of_small(name)) for name in ("dependence", "match-columns")))
    assert found >= BY_OPTIONS_ALONE - {"motion-reversed"}
    problems = (of_small("true-or-false", seed) for seed in range(1, 9))
    assert any("motion-reversed" in named(problem) for problem in problems)


LONG = Chain("3R", tuple(Joint("R", sp.Symbol(f"theta{i}"), 0, 1, 0) for i in (1, 2, 3)), ("vx", "vy"))
SQUARE = Chain("2R", LONG.joints[:2], ("vx", "vy"))
HIGH = Chain("2R", LONG.joints[:2], ("vx", "vy", "wz"))


@pytest.mark.parametrize("chain", [LONG, SQUARE, HIGH], ids=["more joints", "square", "more rows"])
def test_a_bent_arm_is_regular_and_a_stretched_one_is_not(chain: Chain) -> None:
    bent = dict.fromkeys(chain.q, sp.pi / 3)
    assert make_regular_configuration(chain, bent) is not None
    stretched = {q: sp.Integer(0) for q in chain.q}
    by_angular_velocity = chain is HIGH
    assert (make_regular_configuration(chain, stretched) is None) != by_angular_velocity
    assert make_regular_configuration(chain, {**bent, chain.q[0]: sp.Symbol("x")}) is None


FAMILY, SEED = "elbow-3r", "sets"


@pytest.mark.parametrize("they_differ", [True, False])
def test_what_goes_together_best_is_compared_first_and_nothing_after_it(
    monkeypatch: pytest.MonkeyPatch, they_differ: bool
) -> None:
    wanted, scores = Stream(SEED).integer_below(4), []

    def all_differ(_: object, options: list[OfferedOption]) -> bool:
        score = wrong_sets._find_length_mismatch(options, wanted)
        assert score is not None
        scores.append((not score.is_best, 0 if score.is_best else score))
        return they_differ

    monkeypatch.setattr(wrong_sets, "are_different_sets", all_differ)
    chain = sample_chain(ProblemId(FAMILY, 0))
    found = make_four_sets(chain, find_singular_set(chain) or (), Stream(SEED))
    assert scores == sorted(scores) and (found is not None) == they_differ
    assert len(scores) == 1 if they_differ else len(scores) > 3
