"""Questions in numbers and about redundant arms: whom they are refused, with the deciding reason, and what they use."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.mpmath_kinematics import FLOAT_CONTEXT, MpmathArm
from qdot.exercises.common.stream import Stream
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.inversion import sample_lengths
from qdot.exercises.questions.redundancy import MinorDetails
from qdot.exercises.reference_answers import Expression, Number
from qdot.exercises.verify.certificate import certify
from tests.support.problems import ask_question

RANK = ("rank", "lost-direction", "singularity-meaning")
PATH = ("path-rates",)
PERFORMANCE = ("manipulability", "condition-number")
REDUNDANT = ("gram-determinant", "least-norm-rates", "self-motion")
BLOCKS = ("arm-block", "wrist-block", "block-determinants")
TEXTBOOK_CASES = [
    (RANK, "elbow_RRR", ""), (RANK, "cartesian_PPP", "no singular configuration"),
    (RANK[1:2], "pan_tilt_2R", "its 2 joints can never"), (RANK[1:2], "PUMA560", "6 rows"),
    (PATH, "planar_3R_pose", "only linear velocities"), (PATH, "SCARA_RRRP", "only linear velocities"),
    (PATH, "planar_3R_position", "not square"), (PATH, "pan_tilt_2R", "not square"),
    (PATH, "cartesian_PPP", "its Jacobian is constant"),
    (PERFORMANCE, "planar_3R_pose", "different units"), (PERFORMANCE, "PUMA560", "different units"),
    (PERFORMANCE, "pan_tilt_2R", "singular everywhere"), (PERFORMANCE, "cartesian_PPP", "the same in every"),
    (PERFORMANCE[:1], "planar_RP", ""), (PERFORMANCE[1:], "planar_RP", "different units"),
    (REDUNDANT, "planar_2R", "more joints than rows"), (REDUNDANT, "pan_tilt_2R", "more joints than rows"),
    (REDUNDANT, "Scorbot_5R_task_xyz_pitch_roll_at_P", "does not move"),
]  # fmt: skip
FAMILY_CASES = [
    (("joint-torques",), "puma-560", "too many"), (("joint-torques",), "lbr-7r", "too many"),
    (("joint-torques",), "ur-6r", "too many"), (("transform",), "puma-560", "6 joints"),
    (("tool-jacobian",), "ur-6r", "6 joints"), (("tool-jacobian",), "scorbot-tip", "terms"),
    (("tool-jacobian",), "scorbot-wrist", "frame 4"), (BLOCKS, "planar-2r", ""), (BLOCKS, "ur-6r", ""),
    (BLOCKS, "lbr-7r", ""), (BLOCKS, "wrist-zyz", ""), (BLOCKS, "scorbot-tip", ""),
]  # fmt: skip


@pytest.mark.parametrize(("names", "arm", "why"), TEXTBOOK_CASES)
def test_textbook_arm_is_refused_with_a_reason(
    names: tuple[str, ...], arm: str, why: str, textbook_arms: dict[str, Any]
) -> None:
    for name in names:
        refusal = QUESTIONS[name].find_obstacle(textbook_arms[arm].chain)
        assert (refusal is not None and why in refusal) if why else refusal is None, (name, refusal)


@pytest.mark.parametrize(("names", "family", "why"), FAMILY_CASES)
def test_every_arm_of_the_family_is_refused(names: tuple[str, ...], family: str, why: str) -> None:
    for name in names:
        refusals = [QUESTIONS[name].find_obstacle(sample_chain(ProblemId(family, seed))) for seed in range(3)]
        assert all(refusals) and any(why in str(refusal) for refusal in refusals), (name, refusals)


def test_sampled_lengths_are_positive_and_distinct(family: str) -> None:
    """With equal links, a folded arm would be inside its workspace, not at the boundary."""
    for step in ("chapter", "lengths", "full"):
        chain = sample_chain(ProblemId(family, 0, variation=step))
        fixed_lengths = [
            length for joint in chain.joints for length in (joint.a, joint.d) if length.is_number and length != 0
        ]
        for number in range(20):
            lengths = sample_lengths(chain, Stream(f"lengths {number}"))
            assert set(lengths) == set(chain.parameters)
            assert len(set(lengths.values())) == len(lengths) and not set(lengths.values()) & set(fixed_lengths)
            assert all(0.3 <= length <= 0.8 for length in lengths.values())


def test_unit_of_manipulability_follows_from_the_joints(textbook_arms: dict[str, Any]) -> None:
    for name, unit in (("planar_RP", "m"), ("spherical_RRP", "m^2"), ("ZYZ_wrist", ""), ("planar_3R_position", "m^2")):
        (part,) = ask_question("manipulability", textbook_arms[name].chain).parts
        assert part.answer_as(Number).units == (unit,), name


def test_certificate_detects_wrong_unit(textbook_arms: dict[str, Any]) -> None:
    problem = ask_question("manipulability", textbook_arms["spherical_RRP"].chain)
    (part,) = problem.parts
    broken = replace(part, answer=replace(part.answer_as(Number), units=("m^3",)))
    assert not certify(replace(problem, parts=(broken,))).passed


T1, T2, T3, T4 = sp.symbols("theta1:5")
A1, A2, A3, A4 = sp.symbols("a1:5")
NAMES = ("gram-determinant", "least-norm-rates", "self-motion")


def make_joints(*rows: tuple[sp.Expr, sp.Expr, sp.Expr]) -> tuple[Joint, ...]:
    return tuple(Joint("R", sp.Symbol(f"theta{i}"), *row) for i, row in enumerate(rows, 1))


H, ALPHA2 = sp.pi / 2, sp.Symbol("alpha2")
ARM_4R = Chain(
    "elbow with a fourth link", make_joints((0, 0, H), (0, A2, 0), (0, A3, 0), (0, A4, 0)), ("vx", "vy", "vz")
)
LBR = Chain(
    "seven joints",
    make_joints(
        *((d, 0, twist) for d, twist in zip((0.34, 0, 0.4, 0, 0.4, 0, 0), (-H, H, H, -H, -H, H, 0), strict=True))
    ),
    VELOCITY_NAMES,
)
RPR = Chain(
    "RPR", (Joint("R", T1, 0, 0, H), Joint("P", 0, sp.Symbol("d2"), 0, -H), Joint("R", T3, 0, A3, 0)), ("vx", "vy")
)


def test_precise_and_float_arm_agree(textbook_arms: dict[str, Any]) -> None:
    for chain in (LBR, RPR, *(arm.chain for arm in textbook_arms.values())):
        values = {symbol: sp.Rational(3 + i, 7) for i, symbol in enumerate(chain.parameters)}
        q = [0.4 + 0.3 * i for i in range(chain.n)]
        arm = NumericChain(chain, {symbol.name: float(value) for symbol, value in values.items()})
        point, jacobian = MpmathArm(chain, values, FLOAT_CONTEXT).compute_point_and_jacobian(q)
        assert np.allclose(np.array(point, dtype=float), arm.compute_point(np.array(q)), atol=1e-12)
        assert np.allclose(np.array(jacobian, dtype=float), arm.compute_jacobian(np.array(q)), atol=1e-12)


def test_common_factor_of_all_minors_is_factored_out() -> None:
    (part,) = ask_question("gram-determinant", ARM_4R).parts
    reach = A2 * sp.cos(T2) + A3 * sp.cos(T2 + T3) + A4 * sp.cos(T2 + T3 + T4)
    assert part.details_as(MinorDetails).shared_factors == reach
    assert part.answer_as(Expression).reference.is_Mul
    assert reach**2 in part.answer_as(Expression).reference.args


@pytest.mark.parametrize(
    ("name", "chain", "why"),
    [
        *((name, Chain("flat", make_joints(*[(0, A1, 0)] * 4), ("vx", "vy", "vz")), "full rank") for name in NAMES),
        ("gram-determinant", RPR, "different units"), ("least-norm-rates", RPR, "different units"),
        ("self-motion", RPR, ""),
        ("gram-determinant", LBR, "too long"),
        ("self-motion", Chain("4R", make_joints(*((0, a, 0) for a in (A1, A2, A3, A4))), ("vx", "vy")), "2 dimensions"),
        ("self-motion", Chain("idle", make_joints((0, A1, ALPHA2), (0, A2, H), (0, A2, H)), ("wy", "wz")), "alpha2"),
    ],
)  # fmt: skip
def test_unsuitable_redundant_arm_is_refused_with_a_reason(name: str, chain: Chain, why: str) -> None:
    refusal = QUESTIONS[name].find_obstacle(chain) or ""
    assert why in refusal and bool(why) == bool(refusal)
