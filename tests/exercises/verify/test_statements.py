"""True or false, as certificates work it out, where J is not square, too."""

import pytest

from exercises.answers import Choice
from exercises.generation import generate
from exercises.problem import ProblemId
from exercises.quizzes.drawn import Said
from exercises.verify import certify


@pytest.mark.parametrize("family", ["planar-3r", "elbow-3r"])
def test_that_a_pose_is_singular_is_true_or_false_as_its_rank_says(family: str) -> None:
    answers = set()
    for seed in range(40):
        problem = generate(ProblemId(family, seed, ("true-or-false",)))
        (part,) = problem.parts
        if part.about(Said).said == "singular":
            assert isinstance(part.answer, Choice)
            assert certify(problem).passed
            answers.add(part.answer.options[part.answer.correct])
        if answers == {"true", "false"}:
            return
    pytest.fail(f"of 40 statements, {answers} only")
