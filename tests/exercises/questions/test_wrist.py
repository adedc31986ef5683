"""The wrist-partitioned problem: blocks, their determinants and zeros, for textbook arms and where P may be."""

from dataclasses import replace
from typing import Any

import pytest
import sympy as sp

from exercises.answers import Matrix
from exercises.arm.chain import TASK_ROWS, Chain, Joint, Point
from exercises.arm.derivation import derive
from exercises.arm.trigonometry import same
from exercises.generation import generate, sample_chain
from exercises.problem import Part, Problem, ProblemId
from exercises.questions import QUESTIONS
from exercises.questions.wrist import blocks, not_partitioned
from exercises.stream import Stream
from exercises.verify import certify
from exercises.writing.statement import worked_solution
from grader.certify import failures_of

NAMES = ("arm-block", "wrist-block", "block-determinants")
PARTITIONED = ("stanford-6r", "puma-560", "anthropomorphic-6r", "industrial-6r")
TEXTBOOK = ("PUMA560", "industrial_6R_a1_a3_d4")
RIGHT = sp.pi / 2


def stanford(tip: sp.Expr, point: Point, twists: tuple[sp.Expr, sp.Expr] = (-RIGHT, RIGHT)) -> Chain:
    theta = sp.symbols("theta1:7")
    d1, d2, d3 = sp.symbols("d1 d2 d3")
    joints = (
        Joint("R", theta[0], d1, 0, -RIGHT), Joint("R", theta[1], d2, 0, RIGHT), Joint("P", 0, d3, 0, 0),
        Joint("R", theta[3], 0, 0, twists[0]), Joint("R", theta[4], 0, 0, twists[1]), Joint("R", theta[5], tip, 0, 0),
    )  # fmt: skip
    return Chain("stanford", joints, TASK_ROWS, tool=point)


def problem_of(chain: Chain) -> Problem:
    parts = []
    for name in NAMES:
        answer, details = QUESTIONS[name].ask(chain, Stream("test"))
        parts.append(Part(name, name, answer, 1, (), details))
    return Problem(ProblemId("stanford-6r", 1, NAMES), chain, tuple(parts))


def determinants(chain: Chain) -> sp.Matrix:
    answer, _ = QUESTIONS["block-determinants"].ask(chain, Stream("test"))
    assert isinstance(answer, Matrix)
    return answer.reference


@pytest.mark.parametrize("name", TEXTBOOK)
@pytest.mark.parametrize("frame", [4, 5])
def test_textbook_arms_fall_into_blocks_wherever_the_wrist_centre_is_named(
    textbook_arms: dict[str, Any], name: str, frame: int
) -> None:
    """The records speak of O5, which is where O4 is."""
    chain = replace(textbook_arms[name].chain, tool=Point(frame))
    assert [QUESTIONS[question].refusal(chain) for question in NAMES] == [None] * 3
    arm, wrist = determinants(chain)
    expected = sp.sympify(textbook_arms[name].record["det"])
    assert same(sp.expand(arm * wrist), sp.expand(expected))
    assert same(wrist, sp.sin(sp.Symbol("theta5"))) or same(wrist, -sp.sin(sp.Symbol("theta5")))
    problem = problem_of(chain)
    assert failures_of(problem) == []
    assert all(worked_solution(problem, part) for part in problem.parts)


def test_a_stanford_arm_of_our_own() -> None:
    chain = stanford(sp.Symbol("d6"), Point(4))
    arm, wrist = determinants(chain)
    theta2, theta5, d3 = sp.symbols("theta2 theta5 d3")
    assert same(sp.expand(arm), sp.expand(-(d3**2) * sp.sin(theta2)))
    assert same(wrist, -sp.sin(theta5))
    assert failures_of(problem_of(chain)) == []


@pytest.mark.parametrize("family", PARTITIONED)
def test_the_factors_of_the_blocks_are_those_of_the_whole(family: str) -> None:
    """Up to sign and order, and with offsets in the joints."""
    for seed in range(2):
        problem = generate(ProblemId(family, seed, ("block-determinants",)))
        (part,) = problem.parts
        assert isinstance(part.answer, Matrix)
        ours = [factor for entry in part.answer.reference for factor in joint_factors(entry, problem.chain)]
        whole = joint_factors(derive(problem.chain).determinant, problem.chain)
        assert len(ours) == len(whole) == 3
        for factor, power in ours:
            assert any(
                power == other_power and (same(factor, other) or same(factor, -other)) for other, other_power in whole
            ), factor


def joint_factors(product: sp.Expr, chain: Chain) -> list[tuple[sp.Expr, int]]:
    """Return the factors in which joints occur, and their powers; joints without offsets, as proofs need."""
    shifts = {q: q - offset for q, offset in zip(chain.q, chain.offsets, strict=True)}
    powers = (factor.as_base_exp() for factor in sp.Mul.make_args(product))
    return [
        (sp.expand(base.xreplace(shifts)), int(power)) for base, power in powers if base.free_symbols & set(chain.q)
    ]


@pytest.mark.parametrize(
    "chain",
    [
        stanford(sp.Symbol("d6"), Point(6)),  # the tip
        stanford(sp.Symbol("d6"), Point(3, (sp.S.Zero, sp.S.Zero, sp.Symbol("h")))),
        stanford(sp.Symbol("d6"), Point(4, (sp.S.Zero, sp.Symbol("h"), sp.S.Zero))),  # on the axis of joint 4
        stanford(sp.Symbol("d6"), Point(4)).with_task("vx", "vy", "vz"),
        stanford(sp.Symbol("d6"), Point(4), (sp.S.Zero, RIGHT)),  # axes 4 and 5 coincide
    ],
)
def test_other_arms_and_points_are_refused(chain: Chain) -> None:
    for name in NAMES:
        assert QUESTIONS[name].refusal(chain) is not None


@pytest.mark.parametrize("family", ["planar-2r", "ur-6r", "lbr-7r", "wrist-zyz", "scorbot-tip"])
def test_families_without_a_spherical_wrist_are_refused(family: str) -> None:
    chain = sample_chain(ProblemId(family, 1))
    assert all(QUESTIONS[name].refusal(chain) is not None for name in NAMES)


def test_a_tip_in_the_wrist_centre_is_taken() -> None:
    chain = stanford(sp.S.Zero, Point(6))
    assert not_partitioned(chain) is None
    assert failures_of(problem_of(chain)) == []


@pytest.mark.parametrize("family", PARTITIONED)
def test_the_solution_names_the_places_where_each_block_is_singular(family: str) -> None:
    for seed in range(3):
        problem = generate(ProblemId(family, seed, ("block-determinants",)))
        (part,) = problem.parts
        assert isinstance(part.answer, Matrix)
        found = blocks(problem.chain)
        arm, wrist = part.answer.reference
        theta5 = problem.chain.q[4]
        assert len(set(found.straight)) == 2
        for value in found.straight:
            assert wrist.xreplace({theta5: value}) == 0
            axes = found.wrist.xreplace({theta5: value, problem.chain.q[3]: sp.Rational(3, 10)})
            assert max(abs(sp.N(entry)) for entry in axes[:, 0].cross(axes[:, 2])) < 1e-12  # axes 4 and 6 in line
        assert found.in_line
        assert len(found.arm_zeros) == 2
        values = {s: sp.Float(0.3 + 0.37 * i) for i, s in enumerate(sorted(arm.free_symbols, key=str))}
        assert float(found.arm_seen.xreplace(values).det()) == pytest.approx(float(arm.xreplace(values)), abs=1e-12)
        assert "in which the axes of joints 4 and 6 lie on one line" in worked_solution(problem, part)


def test_a_wrist_with_odd_twists_is_singular_where_its_axes_are_in_one_plane() -> None:
    chain = stanford(sp.Symbol("d6"), Point(4), (sp.pi / 3, -RIGHT))
    found = blocks(chain)
    assert not found.in_line
    problem = problem_of(chain)
    assert failures_of(problem) == []
    assert "axes of joints 4, 5 and 6 lie in one plane" in worked_solution(problem, problem.parts[2])


@pytest.mark.parametrize("name", NAMES)
def test_wrong_blocks_are_found(name: str) -> None:
    problem = generate(ProblemId("puma-560", 2, (name,)))
    (part,) = problem.parts
    assert certify(problem).passed
    assert isinstance(part.answer, Matrix)
    right = part.answer.reference
    if name == "wrist-block":  # the axes in the world frame
        wrong = derive(problem.chain).geometric[3:, 3:]
    elif name == "arm-block":  # the angular rows
        wrong = derive(problem.chain).geometric[3:, :3]
    else:  # both signs: the product is still det J
        wrong = -right
    assert not certify(replace(problem, parts=(replace(part, answer=Matrix(wrong)),))).passed
