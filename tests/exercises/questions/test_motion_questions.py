"""Transforms, tool Jacobians, torques, welding paths and wrist blocks: prompts, and the steps of their solutions."""

import re
from dataclasses import replace
from typing import Any

import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint, Point
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.mpmath_kinematics import PRECISE_CONTEXT
from qdot.exercises.arm.path import StraightPath
from qdot.exercises.arm.transforms import count_last_pose_terms
from qdot.exercises.arm.trigonometry import are_identical
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive, make_symbolic_arm
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate, list_questions_of_family, sample_chain
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.path import PathDetails, WeldingLine
from qdot.exercises.questions.transforms import AngleSum, ToolJacobianDetails, TransformDetails
from qdot.exercises.questions.wrist import derive_blocks
from qdot.exercises.reference_answers import Matrix, Number
from qdot.exercises.writing.problem_texts import write_prompt, write_solution
from qdot.exercises.writing.solution_steps import format_number
from qdot.grader.grading.certify import find_failures
from tests.support.problems import ask_question, get_problem
from tests.support.suites import on_families, sample_for_suite

FIXED = [family for family in FAMILIES if not FAMILIES[family].has_varied_structure]
ARMS = [family for family in FIXED if "transform" in list_questions_of_family(family)]
TORQUE_ARMS = [family for family in FIXED if "joint-torques" in list_questions_of_family(family)]
TOOLS = [family for family in FIXED if "tool-jacobian" in list_questions_of_family(family)]


def evaluate_matrix(matrix: sp.Matrix) -> sp.Matrix:
    values = {symbol: sp.Float(0.3 + 0.37 * i) for i, symbol in enumerate(sorted(matrix.free_symbols, key=str))}
    return matrix.xreplace(values).evalf()


def compute_row_transform(chain: Chain, joint: Joint) -> sp.Matrix:
    convention = convention_of(chain)
    return (
        convention.make_rotation(joint).row_join(convention.make_link_vector(joint)).col_join(sp.Matrix([[0, 0, 0, 1]]))
    )


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


def test_transform_solution_multiplies_from_the_base_outwards() -> None:
    problem = get_problem("scara", 0)
    text = write_solution(problem, problem["transform"])
    places = [text.index(f"T_{{w,{i}}}") for i in range(5)]
    assert places == sorted(places)


@on_families(TOOLS)
def test_tool_jacobian_is_the_rotated_geometric_jacobian(family: str) -> None:
    problem = get_problem(family, 0)
    part = problem["tool-jacobian"]
    jacobian = part.answer_as(Matrix).reference
    derivation = derive(problem.chain)
    turn = sp.diag(derivation.rotations[-1].T, derivation.rotations[-1].T)
    differences = evaluate_matrix(sp.Matrix(turn * derivation.geometric_jacobian - jacobian))
    assert max(abs(entry) for entry in differences) < 1e-12
    assert problem.chain.q[0] not in jacobian.free_symbols
    assert not jacobian.free_symbols & set().union(*(v.free_symbols for v in problem.chain.base.position))
    for i, seen in enumerate(part.details_as(ToolJacobianDetails).columns):
        moved = seen.z.cross(seen.p_star) if seen.kind == "R" else seen.z
        assert max(abs(entry) for entry in evaluate_matrix(sp.Matrix(moved - jacobian[:3, i]))) < 1e-12


@pytest.mark.parametrize(("family", "terms"), [("planar-2r", 8), ("cartesian", 4)])
def test_zeros_and_ones_do_not_count_as_terms(family: str, terms: int) -> None:
    arm = sample_chain(ProblemId(family, 0, variation="chapter"))
    assert count_last_pose_terms(make_symbolic_arm(arm).chain) == terms


@on_families(TORQUE_ARMS)
def test_torque_prompt_names_every_unit_and_load(family: str) -> None:
    problem = get_problem(family, 0)
    part = problem["joint-torques"]
    text = write_prompt(problem, part)
    for i, joint in enumerate(problem.chain.joints, 1):
        assert f"$\\tau_{{{i}}}$ in {'N m' if joint.is_revolute else 'N'}" in text
    assert all(f"`{name}`" in text for name in part.symbols)
    units = {"f": "N", "m": "N m"}
    assert all(problem.symbols[name].unit == units[name[0]] for name in part.symbols)
    load, has = text.split("**")[0], {name[0] for name in part.symbols}
    assert (re.search(r"\bin N\b(?! m)", load) is not None, "in N m" in load) == ("f" in has, "m" in has)


@pytest.mark.parametrize(("family", "is_short"), [("scorbot-wrist", True), ("scara", False)])
def test_torque_solution_notes_loads_that_never_need_torque(family: str, is_short: bool) -> None:
    problem = generate(ProblemId(family, 1, ("joint-torques",)))
    assert ("in every configuration there are directions" in write_solution(problem, problem.parts[0])) == is_short


@pytest.mark.parametrize(("identity", "is_lost"), [("random-3/638@zeros", False), ("planar-2r/1@chapter", True)])
def test_torque_solution_mentions_a_lost_direction_only_if_there_is_one(identity: str, is_lost: bool) -> None:
    problem = generate(replace(ProblemId.parse(identity), questions=("joint-torques",)))
    text = write_solution(problem, problem.parts[0])
    assert ("the arm loses a direction" in text) == ("For a load $F = u$" in text) == is_lost


def get_welding_line(problem: Problem) -> WeldingLine:
    return problem.parts[0].details_as(PathDetails).welding_line


def test_precise_and_float_paths_agree(textbook_arms: dict[str, Any]) -> None:
    chain = textbook_arms["elbow_RRR"].chain
    seam = get_welding_line(ask_question("path-rates", chain))
    rough, exact = seam.make_path(chain), seam.make_path(chain, PRECISE_CONTEXT)
    stations = list(rough.follow(0.02, 0.15))
    assert len(stations) > 10
    for station in stations:
        near = [PRECISE_CONTEXT.mpf(value) for value in station.joint_values]
        q = exact.find_joint_values(PRECISE_CONTEXT.mpf(station.s), near)
        assert q is not None
        assert [float(value) for value in q] == pytest.approx(list(station.joint_values), abs=1e-11)
        derivatives = [float(value) for value in exact.compute_derivatives(q)]
        assert derivatives == pytest.approx(list(station.derivatives), abs=1e-9)


def test_path_ends_at_the_limit_of_reach(textbook_arms: dict[str, Any]) -> None:
    chain = textbook_arms["planar_2R"].chain
    half = {symbol: sp.Rational(1, 2) for symbol in chain.parameters}
    joints = dict(zip(chain.q, (sp.S.Zero, sp.pi / 2), strict=True))  # P at (0.5, 0.5), reach 1
    line = StraightPath(chain, half, joints, (sp.Rational(1, 2), sp.S(2)))
    last = list(line.follow(0.02, 0.05))[-1]
    assert 0.3 < last.s < 3**0.5 / 2 - 0.5
    assert line.find_joint_values(0.6, line.start_joint_values) is None


def test_path_questions_use_simple_numbers_and_hide_the_result(family: str) -> None:
    problem = get_problem(family, 0)
    for part in (part for part in problem.parts if part.name == "path-rates"):
        seam, number = part.details_as(PathDetails).welding_line, part.answer_as(Number).reference[0]
        assert all((100 * value).is_Integer for value in seam.target.values())
        assert all((20 * value).is_Integer for value in seam.lengths.values())
        for q, value in seam.joints.items():
            assert (36 * value / sp.pi if q.name.startswith("theta") else 20 * value).is_Integer
            assert -sp.pi < value <= sp.pi or not q.name.startswith("theta")
        assert format_number(sp.Float(number)) in write_solution(problem, part)
        assert f"{float(number):.4g}" not in write_prompt(problem, part)


def test_path_solutions_give_angles_in_degrees() -> None:
    problem = generate("planar-2r/1", ["path-rates"])
    (part,) = problem.parts
    seam = part.details_as(PathDetails).welding_line
    joint_angles = seam.compute_results(problem.chain, sp.S.Zero).joints
    assert seam.compute_results(problem.chain, sp.S.Zero).joints is joint_angles, "computed only once"
    for q, angle in zip(problem.chain.q, joint_angles, strict=True):
        assert abs(angle - seam.joints[q] * 180 / sp.pi) < 1e-2
    assert "rad," not in write_solution(problem, part).replace("rad/s", "")


WRIST_QUESTIONS = ("arm-block", "wrist-block", "block-determinants")
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
    for name in WRIST_QUESTIONS:
        answer, details = QUESTIONS[name].ask(chain, Stream("test"))
        parts.append(Part(name, name, answer, 1, (), details))
    return Problem(ProblemId("stanford-6r", 1, WRIST_QUESTIONS), chain, tuple(parts))


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
    assert [QUESTIONS[question].find_obstacle(chain) for question in WRIST_QUESTIONS] == [None] * 3
    arm, wrist = derive_block_determinants(chain)
    expected = sp.sympify(textbook_arms[name].record["det"])
    assert are_identical(sp.expand(arm * wrist), sp.expand(expected))
    assert are_identical(wrist, sp.sin(sp.Symbol("theta5"))) or are_identical(wrist, -sp.sin(sp.Symbol("theta5")))
    problem = make_wrist_problem(chain)
    assert find_failures(problem) == []
    assert all(write_solution(problem, part) for part in problem.parts)


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
    for name in WRIST_QUESTIONS:
        assert QUESTIONS[name].find_obstacle(chain) is not None


@pytest.mark.parametrize("family", sample_for_suite(PARTITIONED, 2))
def test_block_solution_names_the_singularities_of_each_block(family: str) -> None:
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
    determinant = float(split.arm_block_in_frame_1.xreplace(values).det())
    assert determinant == pytest.approx(float(arm.xreplace(values)), abs=1e-12)
    assert "the axes of joints 4 and 6 then coincide" in write_solution(problem, part)


def test_wrist_with_odd_twists_is_singular_with_coplanar_axes() -> None:
    chain = make_stanford_arm(sp.Symbol("d6"), Point(4), (sp.pi / 3, -RIGHT))
    blocks = derive_blocks(chain)
    assert not blocks.has_collinear_axes
    problem = make_wrist_problem(chain)
    assert find_failures(problem) == []
    assert "axes of joints 4, 5 and 6 then lie in one plane" in write_solution(problem, problem.parts[2])
