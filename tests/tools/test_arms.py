"""What `qdot solve` prints of random arms is true, and a false statement would be noticed."""

from dataclasses import replace

import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.arm.robot_file import Robot
from qdot.exercises.singularities.singular_set import Component
from tests.support.suites import select_for_suite
from tests.tools import arms as tool
from tests.tools.arms import arm, arms, outcome

SECONDS = 6.0


@pytest.mark.parametrize("number", select_for_suite((9, 51), range(0, 300, 6)))
def test_solutions_of_random_arms_hold(number: int) -> None:
    robot = arm(number, "a")
    assert outcome(robot, SECONDS).false == (), robot


TWO_R = Chain("two", (Joint("R", "theta1", 0, "a1", 0), Joint("R", "theta2", 0, sp.Rational(3, 10), 0)), ("vx", "vy"))


def test_an_arm_without_falsehoods() -> None:
    result = outcome(Robot(TWO_R), SECONDS)
    assert result.false == () and result.missing == () and result.seconds < SECONDS


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ((), "of 90 searches ended elsewhere"),
        ((Component((sp.cos(sp.Symbol("theta2")),), None),), "J keeps its rank where cos(theta2) = 0"),
        (
            (Component((sp.sin(sp.Symbol("theta2")),), ((sp.Symbol("theta2"), (sp.S.Zero, sp.pi / 2)),)),),
            "is told of sin(theta2) = 0, and is no solution",
        ),
    ],
)
def test_a_falsehood_is_found(monkeypatch: pytest.MonkeyPatch, told: tuple[Component, ...], said: str) -> None:
    """A singular set that is wrong, for an arm that nothing is kept of."""
    monkeypatch.setattr("qdot.exercises.solve.solver.singular_set", lambda _: told)
    monkeypatch.setattr("qdot.exercises.writing.solution_steps.singular_set", lambda _: told)
    monkeypatch.setattr("qdot.exercises.solve.solver._describe_doubts", lambda *_: "")  # it would be told
    chain = replace(TWO_R, name=f"two {said[:9]}", title=said[:9])
    assert any(said in one for one in outcome(Robot(chain), SECONDS).false)


def test_a_wrong_formula_is_found() -> None:
    values = {"theta1": 0.3, "theta2": 0.4, "a1": 0.5}
    right = [0.5 * 0.9553364891, 0.0]
    assert list(tool._differs("p", ["a1*cos(theta1)", "0"], right, values)) == []
    assert len(list(tool._differs("p", ["a1*sin(theta1)", "0"], right, values))) == 1


def test_arms_are_the_same_for_a_seed() -> None:
    first, again = ([robot.chain for robot in arms(20, "b")] for _ in range(2))
    assert first == again and len({chain.n for chain in first}) > 3
    assert any(joint.is_prismatic for chain in first for joint in chain.joints)
