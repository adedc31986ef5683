"""The full transform and the Jacobian in the tool frame: steps of their solutions, limits, textbook arms."""

from dataclasses import replace
from typing import Any

import pytest
import sympy as sp

from exercises.answers import Matrix
from exercises.arm.chain import Chain, Joint
from exercises.arm.derivation import derive
from exercises.arm.kinematics import joint_rotation, link_vector
from exercises.families import FAMILIES
from exercises.generation import generate, questions_of, sample_chain
from exercises.problem import Part, Problem, ProblemId
from exercises.questions import QUESTIONS
from exercises.questions.transforms import AngleSum, ByTransforms, InToolFrame
from exercises.stream import Stream
from exercises.verify import certify
from exercises.writing.statement import worked_solution

FIXED = [family for family in FAMILIES if not FAMILIES[family].varied]
ARMS = [family for family in FIXED if "transform" in questions_of(family)]
TOOLS = [family for family in FIXED if "tool-jacobian" in questions_of(family)]


def asked(family: str, seed: int, question: str) -> tuple[Problem, Part]:
    problem = generate(ProblemId(family, seed, (question,), variation="full"))
    return problem, problem.parts[0]


def of_textbook(arm: Any, question: str) -> Problem:
    answer, details = QUESTIONS[question].ask(arm.chain, Stream("textbook"))
    return Problem(
        ProblemId("planar-2r", 1, (question,)), arm.chain, (Part(question, question, answer, 1, (), details),)
    )


def numbers(matrix: sp.Matrix) -> sp.Matrix:
    values = {symbol: sp.Float(0.3 + 0.37 * i) for i, symbol in enumerate(sorted(matrix.free_symbols, key=str))}
    return matrix.xreplace(values).evalf()


def row_of_table(joint: Joint) -> sp.Matrix:
    return joint_rotation(joint).row_join(link_vector(joint)).col_join(sp.Matrix([[0, 0, 0, 1]]))


@pytest.mark.parametrize("family", ARMS)
def test_each_partial_product_is_the_one_before_times_a_row_of_the_table(family: str) -> None:
    problem, part = asked(family, 2, "transform")
    poses = part.about(ByTransforms).poses
    assert isinstance(part.answer, Matrix)
    assert len(poses) == problem.chain.n + 1
    assert poses[-1] == part.answer.reference
    for before, joint, after in zip(poses, problem.chain.joints, poses[1:], strict=False):
        difference = numbers(sp.Matrix(before * row_of_table(joint) - after))
        assert max(abs(entry) for entry in difference) < 1e-12


@pytest.mark.parametrize("family", ["planar-2r", "planar-3r", "elbow-3r", "scara", "scorbot-wrist"])
def test_the_sum_of_angles_that_is_shown_is_an_identity_and_shorter(family: str) -> None:
    for seed in range(3):
        _, part = asked(family, seed, "transform")
        found = part.about(ByTransforms).sum
        assert isinstance(found, AngleSum)
        assert abs(numbers(sp.Matrix([found.product - found.result]))[0]) < 1e-12
        assert found.product.is_Add and not found.result.is_Add


@pytest.mark.parametrize("family", ["wrist-zyz", "pan-tilt", "cartesian"])
def test_no_sum_of_angles_is_claimed_where_no_axes_are_parallel(family: str) -> None:
    problem, part = asked(family, 1, "transform")
    assert part.about(ByTransforms).sum is None
    assert "angles add up" not in worked_solution(problem, part)


def test_the_solution_multiplies_row_by_row_from_the_base_on() -> None:
    problem, part = asked("scara", 1, "transform")
    text = worked_solution(problem, part)
    places = [text.index(f"T_{{w,{i}}}") for i in range(5)]
    assert places == sorted(places)
    assert not any(line.startswith(" ") for line in text.splitlines())


def test_example_6_1() -> None:
    """The printed entry (2, 1) is a cosine; it is s12."""
    t1, t2, a1, a2 = sp.symbols("theta1 theta2 a1 a2")
    arm = Chain("2R", (Joint("R", t1, 0, a1, 0), Joint("R", t2, 0, a2, 0)), ("vx", "vy"))
    answer, _ = QUESTIONS["transform"].ask(arm, Stream("x"))
    assert isinstance(answer, Matrix)
    c, s = sp.cos(t1 + t2), sp.sin(t1 + t2)
    x, y = a1 * sp.cos(t1) + a2 * c, a1 * sp.sin(t1) + a2 * s
    assert answer.reference == sp.Matrix([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, 0], [0, 0, 0, 1]])


@pytest.mark.parametrize("family", TOOLS)
def test_the_tool_jacobian_is_the_other_one_turned(family: str) -> None:
    problem, part = asked(family, 3, "tool-jacobian")
    assert isinstance(part.answer, Matrix)
    found = derive(problem.chain)
    turn = sp.diag(found.rotations[-1].T, found.rotations[-1].T)
    assert max(abs(entry) for entry in numbers(sp.Matrix(turn * found.geometric - part.answer.reference))) < 1e-12
    assert problem.chain.q[0] not in part.answer.reference.free_symbols
    assert not part.answer.reference.free_symbols & set().union(*(v.free_symbols for v in problem.chain.base.position))
    for i, seen in enumerate(part.about(InToolFrame).columns):
        moved = seen.z.cross(seen.p_star) if seen.kind == "R" else seen.z
        assert max(abs(entry) for entry in numbers(sp.Matrix(moved - part.answer.reference[:3, i]))) < 1e-12


@pytest.mark.parametrize("question", ["transform", "tool-jacobian"])
def test_the_wrong_side_of_the_rotation_is_found(question: str) -> None:
    """R_n in the place of R_n^T, and a rotation transposed."""
    problem, part = asked("elbow-3r", 4, question)
    assert isinstance(part.answer, Matrix)
    right = derive(problem.chain)
    if question == "transform":
        wrong = sp.Matrix(part.answer.reference)
        wrong[:3, :3] = wrong[:3, :3].T
    else:
        wrong = sp.diag(right.rotations[-1], right.rotations[-1]) * right.geometric
    assert certify(problem).passed
    assert not certify(replace(problem, parts=(replace(part, answer=Matrix(wrong)),))).passed


@pytest.mark.parametrize(
    ("family", "question", "why"),
    [
        ("puma-560", "transform", "the product of the transforms of 6 joints is too long"),
        ("ur-6r", "tool-jacobian", "the Jacobian of 6 joints in the tool frame is too long"),
        ("scorbot-tip", "tool-jacobian", "terms, too many"),
        ("scorbot-wrist", "tool-jacobian", "its point moves with frame 4, not the last"),
    ],
)
def test_what_is_too_long_or_not_fixed_in_the_tool_is_refused(family: str, question: str, why: str) -> None:
    arms = [sample_chain(ProblemId(family, seed)) for seed in range(6)]
    assert any(why in (QUESTIONS[question].refusal(arm) or "") for arm in arms)
    assert all(QUESTIONS[question].refusal(arm) for arm in arms)
