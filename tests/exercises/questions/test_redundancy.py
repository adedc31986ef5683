"""Redundant arms: det(J J^T), least-norm rates and self-motions, against closed forms and planted errors."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from exercises.answers import Direction, Expression, Number
from exercises.arm.chain import TASK_ROWS, Chain, Joint
from exercises.arm.derivation import derive
from exercises.arm.kinematics import NumericChain
from exercises.arm.precise import DOUBLE, PreciseArm, numeric, solved
from exercises.arm.trigonometry import same
from exercises.formula.identity import Domain
from exercises.questions import QUESTIONS
from exercises.questions.inversion import Situation
from exercises.questions.redundancy import null_vector, self_motion
from exercises.verify import certify
from exercises.writing.statement import prompt, worked_solution
from grader.certify import failures_of
from tests.support.judging import judge_direction
from tests.support.problems import asked

T1, T2, T3, T4 = sp.symbols("theta1:5")
A1, A2, A3, A4 = sp.symbols("a1:5")
NAMES = ("gram-determinant", "least-norm-rates", "self-motion")


def revolute(*rows: tuple[sp.Expr, sp.Expr, sp.Expr]) -> tuple[Joint, ...]:
    """Return revolute joints with the given d, a, alpha."""
    return tuple(Joint("R", sp.Symbol(f"theta{i}"), *row) for i, row in enumerate(rows, 1))


H = sp.pi / 2
ARM_4R = Chain("elbow with a fourth link", revolute((0, 0, H), (0, A2, 0), (0, A3, 0), (0, A4, 0)), ("vx", "vy", "vz"))
LBR = Chain(
    "seven joints",
    revolute(*((d, 0, twist) for d, twist in zip((0.34, 0, 0.4, 0, 0.4, 0, 0), (-H, H, H, -H, -H, H, 0), strict=True))),
    TASK_ROWS,
)
RPR = Chain(
    "RPR",
    (Joint("R", T1, 0, 0, H), Joint("P", 0, sp.Symbol("d2"), 0, -H), Joint("R", T3, 0, A3, 0)),
    ("vx", "vy"),
)


@pytest.fixture
def planar(textbook_arms: dict[str, Any]) -> Chain:
    return textbook_arms["planar_3R_position"].chain


def refusals(name: str, chain: Chain) -> str:
    return QUESTIONS[name].refusal(chain) or ""


def test_the_arm_in_any_precision_is_the_arm_in_numbers(textbook_arms: dict[str, Any]) -> None:
    for chain in (LBR, RPR, *(arm.chain for arm in textbook_arms.values())):
        values = {symbol: sp.Rational(3 + i, 7) for i, symbol in enumerate(chain.parameters)}
        q = [0.4 + 0.3 * i for i in range(chain.n)]
        arm = NumericChain(chain, {symbol.name: float(value) for symbol, value in values.items()})
        point, jacobian = PreciseArm(chain, values, DOUBLE).place(q)
        assert np.allclose(np.array(point, dtype=float), arm.point(np.array(q)), atol=1e-12)
        assert np.allclose(np.array(jacobian, dtype=float), arm.jacobian(np.array(q)), atol=1e-12)


def test_elimination_takes_the_row_that_it_can_divide_by() -> None:
    assert solved([[0.0, 2.0], [4.0, 1.0]], [2.0, 9.0]) == [2.0, 1.0]
    with pytest.raises(ZeroDivisionError):
        solved([[1.0, 2.0], [2.0, 4.0]], [1.0, 1.0])


def test_gram_determinant_of_the_planar_arm(planar: Chain) -> None:
    (part,) = asked("gram-determinant", planar).parts
    assert isinstance(part.answer, Expression)
    jacobian = derive(planar).jacobian
    assert same(part.answer.reference, sp.expand((jacobian * jacobian.T).det(method="berkowitz")))
    assert len(sp.Add.make_args(part.answer.reference)) == 3


def test_what_all_minors_share_stands_before_the_sum() -> None:
    (part,) = asked("gram-determinant", ARM_4R).parts
    reach = A2 * sp.cos(T2) + A3 * sp.cos(T2 + T3) + A4 * sp.cos(T2 + T3 + T4)
    assert part.details["shared"] == reach
    assert isinstance(part.answer, Expression)
    assert part.answer.reference.is_Mul
    assert reach**2 in part.answer.reference.args


def test_self_motion_of_the_planar_arm(planar: Chain) -> None:
    motion = self_motion(planar)
    assert all(same(entry, sp.S.Zero) for entry in derive(planar).jacobian * motion)
    (part,) = asked("self-motion", planar).parts
    assert part.answer == Direction(motion)
    expected = [
        A2 * A3 * sp.sin(T3),
        -A3 * (A1 * sp.sin(T2 + T3) + A2 * sp.sin(T3)),
        A1 * (A2 * sp.sin(T2) + A3 * sp.sin(T2 + T3)),
    ]
    assert list(motion) == expected


def test_null_vector() -> None:
    assert np.allclose([float(v) for v in null_vector([[1.0, 0.0, -1.0], [0.0, 2.0, 0.0]])], [0.5**0.5, 0, 0.5**0.5])


def test_a_long_self_motion_is_asked_in_numbers() -> None:
    (part,) = asked("self-motion", LBR).parts
    situation = part.details["situation"]
    assert isinstance(situation, Situation)
    assert isinstance(part.answer, Direction)
    assert part.answer.tolerance == 0.005
    arm = PreciseArm(LBR, situation.lengths)
    rates = [numeric(value) for value in part.answer.reference]
    jacobian = arm.task_jacobian([arm.number(situation.joints[q]) for q in LBR.q])
    assert max(abs(sum(a * b for a, b in zip(row, rates, strict=True))) for row in jacobian) < 1e-9


def test_least_norm_is_that_of_the_pseudo_inverse_and_no_other_rates_are_shorter(planar: Chain) -> None:
    (part,) = asked("least-norm-rates", planar).parts
    situation = part.details["situation"]
    assert isinstance(situation, Situation)
    assert isinstance(part.answer, Number)
    jacobian = np.array(derive(planar).jacobian.xreplace(situation.values).evalf().tolist(), dtype=float)
    velocity = np.array([float(v) for v in situation.velocity.values()])
    rates = np.array([float(v) for v in part.answer.reference])
    assert np.allclose(rates, np.linalg.pinv(jacobian) @ velocity, atol=1e-9)
    still = np.array([float(v) for v in null_vector(jacobian.tolist())])
    assert np.allclose(jacobian @ (rates + 0.1 * still), velocity)
    assert np.linalg.norm(rates + 0.1 * still) > np.linalg.norm(rates)


@pytest.mark.parametrize("name", NAMES)
def test_refusals(name: str, textbook_arms: dict[str, Any]) -> None:
    assert "more joints than rows" in refusals(name, textbook_arms["planar_2R"].chain)
    assert "more joints than rows" in refusals(name, textbook_arms["pan_tilt_2R"].chain)
    assert "does not move" in refusals(name, textbook_arms["Scorbot_5R_task_xyz_pitch_roll_at_P"].chain)
    flat = Chain("flat", revolute(*[(0, A1, 0)] * 4), ("vx", "vy", "vz"))
    assert "full rank" in refusals(name, flat)


def test_refusals_of_single_questions() -> None:
    assert "common unit" in refusals("gram-determinant", RPR)
    assert "common unit" in refusals("least-norm-rates", RPR)
    assert not refusals("self-motion", RPR)
    assert "too long" in refusals("gram-determinant", LBR)
    planar_4r = Chain("planar 4R", revolute((0, A1, 0), (0, A2, 0), (0, A3, 0), (0, A4, 0)), ("vx", "vy"))
    assert "2 dimensions" in refusals("self-motion", planar_4r)
    idle = Chain("idle", revolute((0, A1, H), (0, A2, 0), (0, A3, H)), ("wy", "wz"))
    assert "angle alpha2" in refusals("self-motion", replace(idle, joints=revolute((0, A1, sp.Symbol("alpha2")), *[
        (sp.S.Zero, A2, H)
    ] * 2)))  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_references_pass_everything_and_broken_ones_do_not(name: str, planar: Chain, seeds: range) -> None:
    for chain in (planar, ARM_4R, RPR, LBR):
        if refusals(name, chain):
            continue
        for seed in seeds[:3]:
            problem = asked(name, chain, seed)
            assert certify(problem).passed, certify(problem).failures
            assert not failures_of(problem)
            (part,) = problem.parts
            answer = part.answer
            assert isinstance(answer, (Expression, Number, Direction))
            if isinstance(answer, Expression):
                wrong: Expression | Number | Direction = replace(
                    answer, reference=answer.reference + sp.sin(T2) / 10**6
                )
            else:
                entries = list(answer.reference)
                place = max(i for i, entry in enumerate(entries) if entry != 0)
                entries[place] = -entries[place]
                wrong = replace(answer, reference=sp.Matrix(entries))
            assert not certify(replace(problem, parts=(replace(part, answer=wrong),))).passed


def test_a_self_motion_counts_up_to_a_factor(planar: Chain) -> None:
    motion = [str(entry) for entry in self_motion(planar)]
    angle, length = "angle", "length"
    domain = Domain({"theta1": angle, "theta2": angle, "theta3": angle, "a1": length, "a2": length, "a3": length})
    stretched = str([f"({entry})*(2 + cos(theta1))" for entry in motion]).replace("'", "")
    assert judge_direction(stretched, motion, domain, "seed").share == 1
    turned = str([motion[1], motion[0], motion[2]]).replace("'", "")
    assert judge_direction(turned, motion, domain, "seed").share == 0


@pytest.mark.parametrize("name", NAMES)
def test_words(name: str, planar: Chain) -> None:
    for chain in (planar, ARM_4R, LBR):
        if not refusals(name, chain):
            problem = asked(name, chain)
            text = prompt(problem, problem.parts[0]) + worked_solution(problem, problem.parts[0])
            assert "**Answer:**" in text
            assert "None" not in text
