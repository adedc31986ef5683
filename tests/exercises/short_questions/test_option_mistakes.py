"""Each wrong option has an explanation of the mistake behind it, and right options have none."""

import pytest

from qdot import generate, read_answer
from qdot.exercises.common.stream import Stream
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.problem.problem import Problem
from qdot.exercises.questions.concepts import parse_vector
from qdot.exercises.reference_answers import LETTERS, Letters
from qdot.exercises.short_questions import SHORT_QUESTIONS
from qdot.exercises.short_questions.option_mistakes import EFFECT_MISTAKES, explain_options
from qdot.grader.diagnosis.diagnosis import diagnose
from tests.exercises.short_questions.test_quizzes import of_small, small
from tests.support.problems import get_problem
from tests.support.suites import sample_for_suite

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
