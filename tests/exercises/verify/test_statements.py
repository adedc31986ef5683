"""True or false, as certificates work it out, where J is not square, too."""

import pytest

from qdot.exercises.generation import generate
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions.singular import KindDetails
from qdot.exercises.reference_answers import Choice
from qdot.exercises.short_questions.single_configuration import ConfigurationStatement
from qdot.exercises.verify.certificate import certify
from qdot.exercises.writing.problem_texts import write_solution


@pytest.mark.parametrize("family", ["planar-3r", "elbow-3r"])
def test_that_a_pose_is_singular_is_true_or_false_as_its_rank_says(family: str) -> None:
    answers = set()
    for seed in range(40):
        problem = generate(ProblemId(family, seed, ("true-or-false",)))
        (part,) = problem.parts
        if part.details_as(ConfigurationStatement).statement_kind == "singular":
            assert isinstance(part.answer, Choice)
            assert certify(problem).passed
            answers.add(part.answer.options[part.answer.correct])
        if answers == {"true", "false"}:
            return
    pytest.fail(f"of 40 statements, {answers} only")


ONE_SIDE = "to one side of this point only"


@pytest.mark.parametrize(
    ("problem", "conditions", "one_side"),
    [("orthogonal-3r/219@lengths", 2, False), ("orthogonal-3r/4@full", 1, False), ("planar-2r/3@lengths", 1, True)],
)
def test_one_side_of_a_boundary_is_named_only_if_the_lost_direction_has_one(
    problem: str, conditions: int, one_side: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """P on the axis of joint 2 is on the boundary, but reaches both sides of the lost direction there."""
    asked = generate(problem, ["singularity-type"])
    (part,) = asked.parts
    solution = write_solution(asked, part)
    assert part.details_as(KindDetails).singularity_kind == "boundary"
    assert (ONE_SIDE in solution) == one_side and certify(asked).passed
    assert solution.partition("the Jacobian loses rank")[0].count("= 0") == conditions
    monkeypatch.setattr("qdot.exercises.verify.singularity_statements.is_one_sided", lambda *_: True)
    assert certify(asked).passed == one_side
