"""What `qdot solve` prints of random arms is true, and a false statement would be noticed."""

from dataclasses import replace

import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.robots.robot_file import Robot
from qdot.exercises.singularities.singular_set import Component
from tests.support.suites import select_for_suite
from tests.tools import arms as tool
from tests.tools.arms import arm, arms, check_arm

SECONDS = 6.0


@pytest.mark.parametrize("number", select_for_suite((9, 51), range(0, 300, 15)))
def test_solutions_of_random_arms_hold(number: int) -> None:
    robot = arm(number, "a")
    assert check_arm(robot, SECONDS).false == (), robot


TWO_R = Chain("two", (Joint("R", "theta1", 0, "a1", 0), Joint("R", "theta2", 0, sp.Rational(3, 10), 0)), ("vx", "vy"))


@pytest.mark.parametrize(
    ("components", "message"),
    [
        ((), "of 90 searches ended elsewhere"),
        ((Component((sp.cos(sp.Symbol("theta2")),), None),), "J keeps its rank where cos(theta2) = 0"),
        (
            (Component((sp.sin(sp.Symbol("theta2")),), ((sp.Symbol("theta2"), (sp.S.Zero, sp.pi / 2)),)),),
            "is given for sin(theta2) = 0, but is no solution",
        ),
    ],
)
def test_a_wrong_singular_set_is_found(
    monkeypatch: pytest.MonkeyPatch, components: tuple[Component, ...], message: str
) -> None:
    """Replace the singular set of an arm without stored results."""
    monkeypatch.setattr("qdot.exercises.solve.solver.find_singular_set", lambda _: components)
    monkeypatch.setattr("qdot.exercises.writing.solution_steps.find_singular_set", lambda _: components)
    monkeypatch.setattr("qdot.exercises.solve.solver._describe_doubts", lambda *_: "")  # the solver would notice
    chain = replace(TWO_R, name=f"two {message[:9]}", title=message[:9])
    assert any(message in statement for statement in check_arm(Robot(chain), SECONDS).false)


def test_a_wrong_formula_is_found() -> None:
    values = {"theta1": 0.3, "theta2": 0.4, "a1": 0.5}
    right = [0.5 * 0.9553364891, 0.0]
    assert list(tool._compare("p", ["a1*cos(theta1)", "0"], right, values)) == []
    assert len(list(tool._compare("p", ["a1*sin(theta1)", "0"], right, values))) == 1
