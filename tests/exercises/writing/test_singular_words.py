"""What solutions say of singular configurations: the names of a convention, values that differ, numbers that fit."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from exercises.arm.chain import CONVENTIONS
from exercises.arm.directions import task_rows
from exercises.arm.kinematics import NumericChain
from exercises.arm.told import told_words
from exercises.families import FAMILIES
from exercises.generation import generate, sample_chain
from exercises.problem import Problem, ProblemId
from exercises.questions import QUESTIONS
from exercises.questions.inversion import InSituation
from exercises.questions.rank import OfMotion
from exercises.writing.statement import next_solution, worked_solution, worked_steps
from tests.support.suites import of_families

NAMES = {"dh": "The origin $O_{2}$ lies", "modified-dh": "The origin $O_{3}$ lies", "screws": "$q_{3}'$ lies"}
LEAST = "It holds somewhere only if"


def solution(identity: str, question: str, convention: str = "dh") -> str:
    problem = generate(replace(ProblemId.parse(identity), questions=(question,)).told(convention))
    (part,) = problem.parts
    return worked_solution(problem, part)


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_an_origin_has_the_name_that_the_arms_convention_has_for_it(convention: str) -> None:
    """O_2 of the standard table is on the axis of joint 3: the origin of frame 3 of a modified one."""
    assert NAMES[convention] in solution("orthogonal-3r/776@frames", "singular-angles", convention)


def test_where_an_arm_has_no_name_for_an_origin_what_is_true_of_all_is_said() -> None:
    chain = sample_chain(ProblemId.parse("cylindrical/1@chapter").told("screws"))  # joints 2 and 3 are slides
    assert told_words(chain, "the origin O2 lies on the axis of joint 1") == "the columns of J are linearly dependent"


def test_values_that_are_of_different_kinds_are_told_apart_and_equal_ones_together() -> None:
    text = solution("planar-3r/550@chapter", "singular-angles")
    assert r"At $\theta_{2} = 0$ and $\theta_{3} = 0$: the arm is stretched out, a boundary singularity." in text
    one = r"At $\theta_{2} = 0$ and $\theta_{3} = 180^\circ$"
    others = r"$\theta_{2} = 180^\circ$ and $\theta_{3} = 0$, or $\theta_{2} = 180^\circ$ and $\theta_{3} = 180^\circ$"
    assert f"{one}, or {others}: the arm is folded back. This is a boundary singularity for some lengths" in text


def test_what_lengths_have_to_satisfy_is_told_where_a_condition_may_not_hold() -> None:
    assert rf"{LEAST} $a_{{1}} \le a_{{2}} + \sqrt{{" in solution("industrial-6r/305@chapter", "singular-angles")
    assert LEAST not in solution("elbow/1@chapter", "singular-angles")  # a2 c2 + a3 c23 = 0 holds somewhere for all


@of_families(tuple(FAMILIES))
def test_a_direction_that_is_lost_is_perpendicular_to_all_columns_that_are_shown(family: str) -> None:
    for step in ("chapter", "full"):
        problem = _asking(family, step, "lost-motion")
        if problem is None:
            return
        chain, (part,) = problem.chain, problem.parts
        example = worked_steps(chain).lost_example(part.about(OfMotion).asked.where)
        assert example is not None
        jacobian, lost = (np.array(matrix.tolist(), dtype=float) for matrix in (example.jacobian, example.lost))
        assert np.abs(jacobian.T @ lost).max() < 2e-3 * np.abs(jacobian).max()
        if not example.about:
            arm = NumericChain(chain, {symbol.name: float(value) for symbol, value in example.lengths.items()})
            own = arm.jacobian(np.array([float(sp.N(example.joints[q])) for q in chain.q]))[task_rows(chain)]
            assert np.allclose(own, jacobian, rtol=1e-3, atol=1e-4)
        is_long = worked_steps(chain).lost_where(part.about(OfMotion).asked.where) is None
        assert is_long == ("In numbers, " in worked_solution(problem, part))


def _asking(family: str, step: str, question: str) -> Problem | None:
    identity = ProblemId(family, 3).varied(step)
    if QUESTIONS[question].objects(sample_chain(identity)) is not None:
        return None
    return generate(replace(identity, questions=(question,)))


@pytest.mark.parametrize("family", ["stanford-6r", "puma-560", "anthropomorphic-6r"])
def test_rates_by_blocks_are_the_reference(family: str) -> None:
    problem = generate(ProblemId(family, 4, ("joint-rates",)).varied("zeros"))
    (part,) = problem.parts
    blocks = worked_steps(problem.chain).rates_by_blocks(part.about(InSituation).situation)
    assert blocks is not None
    shown = np.array([*blocks.first, *blocks.last], dtype=float)
    assert np.allclose(shown, np.array(part.answer.as_matrix(), dtype=float).ravel(), rtol=1e-3, atol=1e-6)
    for inverse, right, rates in ((blocks.arm, blocks.linear, blocks.first), (blocks.wrist, blocks.left, blocks.last)):
        assert np.allclose(np.array(inverse * right - rates, dtype=float), 0, atol=5e-3)


def test_determinants_of_blocks_are_not_worked_out_twice() -> None:
    problem = generate(ProblemId("stanford-6r", 4, ("block-determinants", "determinant")).varied("zeros"))
    explained: set[str] = set()
    texts = [next_solution(Problem(problem.id, problem.chain, problem.parts[: k + 1]), explained) for k in range(2)]
    assert "found above" in texts[1] and "The wrist" not in texts[1]


def test_where_conditions_meet_it_may_be_of_the_other_kind_only_where_there_is_one() -> None:
    """The boundary of what is reached is closed: where all conditions are at it, so are their common configurations."""
    other = "it may be of the other kind"
    assert other not in solution("elbow-lateral/607@zeros", "singular-angles")
    assert other in solution("industrial-6r/305@chapter", "singular-angles")
