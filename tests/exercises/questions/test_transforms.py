"""The pose of the last frame and the Jacobian in the tool frame: steps of their solutions, and Example 6.1."""

import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.transforms import count_last_pose_terms
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive, make_symbolic_arm
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import list_questions_of_family, sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.transforms import AngleSum, ToolJacobianDetails, TransformDetails
from qdot.exercises.reference_answers import Matrix
from qdot.exercises.writing.problem_texts import write_solution
from tests.support.problems import get_problem
from tests.support.suites import on_families

FIXED = [family for family in FAMILIES if not FAMILIES[family].has_varied_structure]
ARMS = [family for family in FIXED if "transform" in list_questions_of_family(family)]
TOOLS = [family for family in FIXED if "tool-jacobian" in list_questions_of_family(family)]


def evaluate_matrix(matrix: sp.Matrix) -> sp.Matrix:
    values = {symbol: sp.Float(0.3 + 0.37 * i) for i, symbol in enumerate(sorted(matrix.free_symbols, key=str))}
    return matrix.xreplace(values).evalf()


def compute_row_transform(chain: Chain, joint: Joint) -> sp.Matrix:
    convention = convention_of(chain)
    return convention.rotation(joint).row_join(convention.link_vector(joint)).col_join(sp.Matrix([[0, 0, 0, 1]]))


@on_families(ARMS)
def test_each_partial_product_multiplies_by_one_row(family: str) -> None:
    problem = get_problem(family, 0)
    part = problem["transform"]
    poses = part.details_as(TransformDetails).poses
    assert len(poses) == problem.chain.n + 1
    assert poses[-1] == part.answer_as(Matrix).reference
    for before, joint, after in zip(poses, problem.chain.joints, poses[1:], strict=False):
        difference = evaluate_matrix(sp.Matrix(before * compute_row_transform(problem.chain, joint) - after))
        assert max(abs(entry) for entry in difference) < 1e-12


@pytest.mark.parametrize("family", ["planar-2r", "planar-3r", "elbow-3r", "scara", "scorbot-wrist"])
def test_displayed_angle_sum_is_a_simplifying_identity(family: str) -> None:
    angle_sum = get_problem(family, 0)["transform"].details_as(TransformDetails).angle_sum
    assert isinstance(angle_sum, AngleSum)
    assert abs(evaluate_matrix(sp.Matrix([angle_sum.product - angle_sum.result]))[0]) < 1e-12
    assert angle_sum.product.is_Add and not angle_sum.result.is_Add


@pytest.mark.parametrize("family", ["wrist-zyz", "pan-tilt", "cartesian"])
def test_angle_sum_needs_parallel_axes(family: str) -> None:
    assert get_problem(family, 0)["transform"].details_as(TransformDetails).angle_sum is None


def test_solution_multiplies_from_the_base_outwards() -> None:
    problem = get_problem("scara", 0)
    text = write_solution(problem, problem["transform"])
    places = [text.index(f"T_{{w,{i}}}") for i in range(5)]
    assert places == sorted(places)


def test_transform_of_example_6_1() -> None:
    """The printed entry (2, 1) is a cosine; it is s12."""
    t1, t2, a1, a2 = sp.symbols("theta1 theta2 a1 a2")
    arm = Chain("2R", (Joint("R", t1, 0, a1, 0), Joint("R", t2, 0, a2, 0)), ("vx", "vy"))
    answer, _ = QUESTIONS["transform"].ask(arm, Stream("x"))
    c, s = sp.cos(t1 + t2), sp.sin(t1 + t2)
    x, y = a1 * sp.cos(t1) + a2 * c, a1 * sp.sin(t1) + a2 * s
    assert answer.as_matrix() == sp.Matrix([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, 0], [0, 0, 0, 1]])


@on_families(TOOLS)
def test_tool_jacobian_is_the_rotated_geometric_jacobian(family: str) -> None:
    problem = get_problem(family, 0)
    part = problem["tool-jacobian"]
    jacobian = part.answer_as(Matrix).reference
    derivation = derive(problem.chain)
    turn = sp.diag(derivation.rotations[-1].T, derivation.rotations[-1].T)
    assert (
        max(abs(entry) for entry in evaluate_matrix(sp.Matrix(turn * derivation.geometric_jacobian - jacobian))) < 1e-12
    )
    assert problem.chain.q[0] not in jacobian.free_symbols
    assert not jacobian.free_symbols & set().union(*(v.free_symbols for v in problem.chain.base.position))
    for i, seen in enumerate(part.details_as(ToolJacobianDetails).columns):
        moved = seen.z.cross(seen.p_star) if seen.kind == "R" else seen.z
        assert max(abs(entry) for entry in evaluate_matrix(sp.Matrix(moved - jacobian[:3, i]))) < 1e-12


@pytest.mark.parametrize(("family", "terms"), [("planar-2r", 8), ("cartesian", 4)])
def test_zeros_and_ones_do_not_count_as_terms(family: str, terms: int) -> None:
    assert (
        count_last_pose_terms(make_symbolic_arm(sample_chain(ProblemId(family, 0, variation="chapter"))).chain) == terms
    )
