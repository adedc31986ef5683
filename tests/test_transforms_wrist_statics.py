"""Transforms, the tool's frame, wrist-partitioned arms and static torques, against other ways to find them."""

import numpy as np
import pytest
import sympy as sp

from exercises.arm.chain import TASK_ROWS
from exercises.arm.derivation import derive
from exercises.families import FAMILIES
from exercises.generate import generate, questions_of, sample_chain
from exercises.problem import Matrix, ProblemId
from exercises.questions import QUESTIONS
from exercises.stream import Stream
from exercises.writing.statement import worked_solution

PARTITIONED = ("stanford-6r", "puma-560", "anthropomorphic-6r", "industrial-6r")


def answer(family: str, seed: int, question: str) -> sp.Matrix:
    reference = generate(ProblemId(family, seed, (question,))).parts[0].answer
    assert isinstance(reference, Matrix)
    return reference.reference


def test_the_transform_of_example_6_1_has_a_sine_where_the_book_prints_a_cosine() -> None:
    """The printed rotation is not orthonormal; ours is, for every arm."""
    for family in FAMILIES:
        if FAMILIES[family].varied or "transform" not in questions_of(family):
            continue
        pose = answer(family, 3, "transform")
        values = {symbol: 0.4 + 0.3 * i for i, symbol in enumerate(sorted(pose.free_symbols, key=str))}
        rotation = np.array(pose[:3, :3].xreplace(values).evalf(), dtype=float)
        assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-12), family
        assert list(pose[3, :]) == [0, 0, 0, 1]


@pytest.mark.parametrize("family", ["elbow", "planar-2r", "scara", "wrist-zyz", "spherical-offset"])
def test_seen_from_the_tool_the_whole_arm_may_be_turned(family: str) -> None:
    found = answer(family, 2, "tool-jacobian")
    assert sp.Symbol("theta1") not in found.free_symbols
    assert found.shape == (6, sample_chain(ProblemId(family, 2)).n)


@pytest.mark.parametrize("family", PARTITIONED)
def test_the_determinants_of_the_blocks_multiply_to_that_of_the_whole(family: str) -> None:
    for seed in range(3):
        arm, wrist = answer(family, seed, "block-determinants")
        whole = derive(sample_chain(ProblemId(family, seed))).determinant
        values = {symbol: 0.4 + 0.31 * i for i, symbol in enumerate(sorted(whole.free_symbols, key=str))}
        assert float((arm * wrist).xreplace(values)) == pytest.approx(float(whole.xreplace(values)), rel=1e-12)
        assert {str(symbol) for symbol in wrist.free_symbols} == {"theta5"}
        assert answer(family, seed, "wrist-block")[:, 0] == sp.Matrix([0, 0, 1])


@pytest.mark.parametrize("family", ["planar-2r", "ur-6r", "lbr-7r", "wrist-zyz", "scorbot-tip"])
def test_arms_that_do_not_fall_into_blocks_are_not_asked_for_them(family: str) -> None:
    chain = sample_chain(ProblemId(family, 1))
    for name in ("arm-block", "wrist-block", "block-determinants"):
        assert QUESTIONS[name].refusal(chain) is not None


def test_torques_of_the_planar_arm() -> None:
    chain = sample_chain(ProblemId("planar-3r", 4))
    reference, details = QUESTIONS["joint-torques"].ask(chain, Stream("x"))
    assert isinstance(reference, Matrix)
    fx, fy = sp.symbols("fx fy")
    assert list(details["force"]) == [fx, fy]  # type: ignore[call-overload]
    # the last joint carries the moment of the force about its own axis
    frames = derive(chain)
    arm = frames.p_star[:, 2]
    moment = frames.z[:, 2].dot(arm.cross(sp.Matrix([fx, fy, 0])))
    values = {symbol: 0.4 + 0.3 * i for i, symbol in enumerate(sorted(moment.free_symbols, key=str))}
    assert float((moment - reference.reference[2]).xreplace(values)) == pytest.approx(0, abs=1e-12)


def test_a_load_has_forces_for_linear_rows_and_moments_for_turns() -> None:
    problem = generate(ProblemId("scara", 1, ("joint-torques",)))
    assert list(problem.parts[0].symbols) == ["fx", "fy", "fz", "mz"]
    assert problem.symbols()["mz"].unit == "N m"
    assert problem.parts[0].details["units"] == ("N m", "N m", "N", "N m")
    assert len(TASK_ROWS) == 6


@pytest.mark.parametrize("family", PARTITIONED)
def test_a_worked_solution_says_why_the_block_is_zero(family: str) -> None:
    problem = generate(ProblemId(family, 1, ("block-determinants",)))
    text = worked_solution(problem, problem.parts[0])
    assert "these joints do not move it, and the upper right block is zero" in text
    assert r"\det J_{22} = " in text
