"""Each wrong option has an explanation of the mistake behind it, and right options have none."""

import pytest

from qdot.exercises.common.stream import Stream
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.problem.problem import Problem
from qdot.exercises.reference_answers import Letters
from qdot.exercises.short_questions import SHORT_QUESTIONS
from qdot.exercises.short_questions.option_mistakes import explain_options
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
def test_mistakes_that_only_options_tell_are_told() -> None:
    """A statement about a motion is drawn by some seeds only."""
    found = set().union(*(named(of_small(name)) for name in ("dependence", "match-columns")))
    assert found >= BY_OPTIONS_ALONE - {"motion-reversed"}
    problems = (of_small("true-or-false", seed) for seed in range(1, 9))
    assert any("motion-reversed" in named(problem) for problem in problems)
