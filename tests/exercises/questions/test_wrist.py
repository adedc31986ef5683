"""Wrist-partitioned arms: blocks, their determinants and zeros, for textbook arms and positions of P."""

from dataclasses import replace
from typing import Any

import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint, Point
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.trigonometry import are_identical
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.wrist import derive_blocks
from qdot.exercises.reference_answers import Matrix
from qdot.exercises.writing.problem_texts import write_solution
from qdot.grader.grading.certify import find_failures
from tests.support.problems import get_problem
from tests.support.suites import sample_for_suite

NAMES = ("arm-block", "wrist-block", "block-determinants")
PARTITIONED = ("stanford-6r", "puma-560", "anthropomorphic-6r", "industrial-6r")
TEXTBOOK = ("PUMA560", "industrial_6R_a1_a3_d4")
RIGHT = sp.pi / 2


def make_stanford_arm(tip: sp.Expr, point: Point, twists: tuple[sp.Expr, sp.Expr] = (-RIGHT, RIGHT)) -> Chain:
    theta = sp.symbols("theta1:7")
    d1, d2, d3 = sp.symbols("d1 d2 d3")
    joints = (
        Joint("R", theta[0], d1, 0, -RIGHT), Joint("R", theta[1], d2, 0, RIGHT), Joint("P", 0, d3, 0, 0),
        Joint("R", theta[3], 0, 0, twists[0]), Joint("R", theta[4], 0, 0, twists[1]), Joint("R", theta[5], tip, 0, 0),
    )  # fmt: skip
    return Chain("stanford", joints, VELOCITY_NAMES, tool=point)


def make_wrist_problem(chain: Chain) -> Problem:
    parts = []
    for name in NAMES:
        answer, details = QUESTIONS[name].ask(chain, Stream("test"))
        parts.append(Part(name, name, answer, 1, (), details))
    return Problem(ProblemId("stanford-6r", 1, NAMES), chain, tuple(parts))


def derive_block_determinants(chain: Chain) -> sp.Matrix:
    answer, _ = QUESTIONS["block-determinants"].ask(chain, Stream("test"))
    return answer.as_matrix()


@pytest.mark.parametrize("name", sample_for_suite(TEXTBOOK, 1))
@pytest.mark.parametrize("frame", [4, 5])
def test_textbook_arms_are_partitioned_at_the_wrist_centre(
    textbook_arms: dict[str, Any], name: str, frame: int
) -> None:
    """The records name O5, which coincides with O4."""
    chain = replace(textbook_arms[name].chain, tool=Point(frame))
    assert [QUESTIONS[question].find_obstacle(chain) for question in NAMES] == [None] * 3
    arm, wrist = derive_block_determinants(chain)
    expected = sp.sympify(textbook_arms[name].record["det"])
    assert are_identical(sp.expand(arm * wrist), sp.expand(expected))
    assert are_identical(wrist, sp.sin(sp.Symbol("theta5"))) or are_identical(wrist, -sp.sin(sp.Symbol("theta5")))
    problem = make_wrist_problem(chain)
    assert find_failures(problem) == []
    assert all(write_solution(problem, part) for part in problem.parts)


def test_stanford_arm_has_known_block_determinants() -> None:
    """P is the wrist centre, which may be the tip."""
    theta2, theta5, d3 = sp.symbols("theta2 theta5 d3")
    for chain in (make_stanford_arm(sp.Symbol("d6"), Point(4)), make_stanford_arm(sp.S.Zero, Point(6))):
        arm, wrist = derive_block_determinants(chain)
        assert are_identical(sp.expand(arm), sp.expand(-(d3**2) * sp.sin(theta2)))
        assert are_identical(wrist, -sp.sin(theta5))
        assert find_failures(make_wrist_problem(chain)) == []


@pytest.mark.parametrize(
    "chain",
    [
        make_stanford_arm(sp.Symbol("d6"), Point(6)),  # the tip
        make_stanford_arm(sp.Symbol("d6"), Point(3, (sp.S.Zero, sp.S.Zero, sp.Symbol("h")))),
        make_stanford_arm(sp.Symbol("d6"), Point(4, (sp.S.Zero, sp.Symbol("h"), sp.S.Zero))),  # on the axis of joint 4
        make_stanford_arm(sp.Symbol("d6"), Point(4)).with_task("vx", "vy", "vz"),
        make_stanford_arm(sp.Symbol("d6"), Point(4), (sp.S.Zero, RIGHT)),  # axes 4 and 5 coincide
    ],
)
def test_arms_without_wrist_partition_are_refused(chain: Chain) -> None:
    for name in NAMES:
        assert QUESTIONS[name].find_obstacle(chain) is not None


@pytest.mark.parametrize("family", sample_for_suite(PARTITIONED, 2))
def test_solution_names_the_singularities_of_each_block(family: str) -> None:
    problem = get_problem(family, 0)
    part = problem["block-determinants"]
    split = derive_blocks(problem.chain)
    arm, wrist = part.answer_as(Matrix).reference
    theta5 = problem.chain.q[4]
    assert len(set(split.wrist_zeros)) == len(split.arm_factors) == 2 and split.has_collinear_axes
    for value in split.wrist_zeros:
        assert wrist.xreplace({theta5: value}) == 0
        axes = split.wrist_block.xreplace({theta5: value, problem.chain.q[3]: sp.Rational(3, 10)})
        assert max(abs(sp.N(entry)) for entry in axes[:, 0].cross(axes[:, 2])) < 1e-12  # axes 4 and 6 in line
    values = {s: sp.Float(0.3 + 0.37 * i) for i, s in enumerate(sorted(arm.free_symbols, key=str))}
    assert float(split.arm_block_in_frame_1.xreplace(values).det()) == pytest.approx(
        float(arm.xreplace(values)), abs=1e-12
    )
    assert "the axes of joints 4 and 6 then coincide" in write_solution(problem, part)


def test_wrist_with_odd_twists_is_singular_with_coplanar_axes() -> None:
    chain = make_stanford_arm(sp.Symbol("d6"), Point(4), (sp.pi / 3, -RIGHT))
    blocks = derive_blocks(chain)
    assert not blocks.has_collinear_axes
    problem = make_wrist_problem(chain)
    assert find_failures(problem) == []
    assert "axes of joints 4, 5 and 6 then lie in one plane" in write_solution(problem, problem.parts[2])
