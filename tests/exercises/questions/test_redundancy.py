"""Redundant arms: det(J J^T), least-norm rates and self-motions agree with closed forms."""

from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.mpmath_kinematics import FLOAT_CONTEXT, MpmathArm, evaluate_in_context
from qdot.exercises.arm.trigonometry import are_identical
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.formula.equality import Domain
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.inversion import VelocityDetails
from qdot.exercises.questions.redundancy import MinorDetails, compute_null_vector, write_self_motion
from qdot.exercises.reference_answers import Direction, Expression, Number
from tests.support.judging import judge_direction
from tests.support.problems import ask_question

T1, T2, T3, T4 = sp.symbols("theta1:5")
A1, A2, A3, A4 = sp.symbols("a1:5")
NAMES = ("gram-determinant", "least-norm-rates", "self-motion")


def make_joints(*rows: tuple[sp.Expr, sp.Expr, sp.Expr]) -> tuple[Joint, ...]:
    """Return revolute joints with the given d, a, alpha."""
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


@pytest.fixture
def planar(textbook_arms: dict[str, Any]) -> Chain:
    return textbook_arms["planar_3R_position"].chain


def test_precise_and_float_arm_agree(textbook_arms: dict[str, Any]) -> None:
    for chain in (LBR, RPR, *(arm.chain for arm in textbook_arms.values())):
        values = {symbol: sp.Rational(3 + i, 7) for i, symbol in enumerate(chain.parameters)}
        q = [0.4 + 0.3 * i for i in range(chain.n)]
        arm = NumericChain(chain, {symbol.name: float(value) for symbol, value in values.items()})
        point, jacobian = MpmathArm(chain, values, FLOAT_CONTEXT).compute_point_and_jacobian(q)
        assert np.allclose(np.array(point, dtype=float), arm.compute_point(np.array(q)), atol=1e-12)
        assert np.allclose(np.array(jacobian, dtype=float), arm.compute_jacobian(np.array(q)), atol=1e-12)


def test_gram_determinant_of_planar_arm_is_that_of_the_jacobian(planar: Chain) -> None:
    (part,) = ask_question("gram-determinant", planar).parts
    jacobian = derive(planar).jacobian
    assert are_identical(
        part.answer_as(Expression).reference, sp.expand((jacobian * jacobian.T).det(method="berkowitz"))
    )
    assert len(sp.Add.make_args(part.answer_as(Expression).reference)) == 3


def test_common_factor_of_all_minors_is_factored_out() -> None:
    (part,) = ask_question("gram-determinant", ARM_4R).parts
    reach = A2 * sp.cos(T2) + A3 * sp.cos(T2 + T3) + A4 * sp.cos(T2 + T3 + T4)
    assert part.details_as(MinorDetails).shared_factors == reach
    assert part.answer_as(Expression).reference.is_Mul
    assert reach**2 in part.answer_as(Expression).reference.args


def test_self_motion_of_planar_arm_has_closed_form(planar: Chain) -> None:
    motion = write_self_motion(planar)
    assert all(are_identical(entry, sp.S.Zero) for entry in derive(planar).jacobian * motion)
    (part,) = ask_question("self-motion", planar).parts
    assert part.answer == Direction(motion)
    expected = [
        A2 * A3 * sp.sin(T3),
        -A3 * (A1 * sp.sin(T2 + T3) + A2 * sp.sin(T3)),
        A1 * (A2 * sp.sin(T2) + A3 * sp.sin(T2 + T3)),
    ]
    assert list(motion) == expected


def test_long_self_motion_is_asked_numerically() -> None:
    (part,) = ask_question("self-motion", LBR).parts
    configuration = part.details_as(VelocityDetails).configuration
    assert part.answer_as(Direction).tolerance == 0.005
    arm = MpmathArm(LBR, configuration.lengths)
    rates = [evaluate_in_context(value) for value in part.answer_as(Direction).reference]
    jacobian = arm.compute_task_jacobian([arm.evaluate_number(configuration.joints[q]) for q in LBR.q])
    assert max(abs(sum(a * b for a, b in zip(row, rates, strict=True))) for row in jacobian) < 1e-9


def test_least_norm_rates_are_those_of_the_pseudoinverse(planar: Chain) -> None:
    (part,) = ask_question("least-norm-rates", planar).parts
    configuration = part.details_as(VelocityDetails).configuration
    jacobian = np.array(derive(planar).jacobian.xreplace(configuration.values).evalf().tolist(), dtype=float)
    velocity = np.array([float(v) for v in configuration.velocity.values()])
    rates = np.array([float(v) for v in part.answer_as(Number).reference])
    assert np.allclose(rates, np.linalg.pinv(jacobian) @ velocity, atol=1e-9)
    still = np.array([float(v) for v in compute_null_vector(jacobian.tolist())])
    assert np.allclose(jacobian @ (rates + 0.1 * still), velocity)
    assert np.linalg.norm(rates + 0.1 * still) > np.linalg.norm(rates)


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


def test_self_motion_is_accepted_up_to_a_factor(planar: Chain) -> None:
    motion = [str(entry) for entry in write_self_motion(planar)]
    domain = Domain({f"{name}{i}": role for name, role in (("theta", "angle"), ("a", "length")) for i in (1, 2, 3)})
    longer = [f"({entry})*(2 + cos(theta1))" for entry in motion]
    for typed, share in ((longer, 1), ([motion[1], motion[0], motion[2]], 0)):
        assert judge_direction(f"[{', '.join(typed)}]", motion, domain, "seed").share == share
