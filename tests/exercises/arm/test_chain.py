"""Chains: what a table may say, and what is refused with a reason."""

import pytest
import sympy as sp

from exercises.arm.chain import Base, Chain, Joint, Point
from exercises.errors import QdotError

T1, T2, A1, A2 = sp.symbols("theta1 theta2 a1 a2")
FIRST, SECOND = Joint("R", T1, 0, A1, 0), Joint("R", T2, 0, A2, 0)


def planar(*joints: Joint, task: tuple[str, ...] = ("vx", "vy"), tool: Point | None = None) -> Chain:
    return Chain("arm", joints, task, tool=tool)


def test_joint_variables_rates_and_offsets() -> None:
    arm = planar(FIRST, Joint("R", T2 + sp.pi / 2, 0, A2, 0), Joint("P", 0, sp.Symbol("d3") + sp.Rational(1, 5), 0, 0))
    assert [q.name for q in arm.q] == ["theta1", "theta2", "d3"]
    assert [rate.name for rate in arm.rates] == ["qd1", "qd2", "qd3"]
    assert arm.offsets == (0, sp.pi / 2, sp.Rational(1, 5))
    assert [symbol.name for symbol in arm.parameters] == ["a1", "a2"]
    assert arm.point == Point(3)


@pytest.mark.parametrize(
    ("joints", "said"),
    [
        ((), "at least one joint"),
        ((Joint("R", T2, 0, A1, 0),), "theta is theta2, but must be theta1 plus a constant"),
        ((FIRST, Joint("R", 2 * T2, 0, A2, 0)), "must be theta2 plus a constant"),
        ((FIRST, Joint("R", T2, 0, T1, 0)), "holds theta1, which is the variable of a joint"),
        ((FIRST, Joint("P", 0, sp.Symbol("d2"), sp.Symbol("d2"), 0)), "holds d2"),
        ((Joint("R", T1, sp.Symbol("d2"), A1, 0), Joint("P", 0, sp.Symbol("d2"), 0, 0)), "holds d2"),
    ],
)
def test_a_table_that_makes_no_sense_is_refused(joints: tuple[Joint, ...], said: str) -> None:
    with pytest.raises(QdotError, match=said):
        planar(*joints)


def test_a_joint_is_revolute_or_prismatic() -> None:
    with pytest.raises(QdotError, match="'R' or 'P', not 'X'"):
        Joint("X", T1, 0, A1, 0)


@pytest.mark.parametrize("task", [(), ("vx", "vx"), ("x",)])
def test_a_task_names_rows_once(task: tuple[str, ...]) -> None:
    with pytest.raises(QdotError, match="task"):
        planar(FIRST, task=task)


def test_the_point_moves_with_a_frame_that_exists() -> None:
    with pytest.raises(QdotError, match="no frame O2; the last one is O1"):
        planar(FIRST, tool=Point(2))


def test_an_arm_in_the_plane_is_told_from_one_in_space() -> None:
    assert planar(FIRST, SECOND).is_planar
    assert planar(Joint("R", T1, 0, A1, sp.pi), SECOND).is_planar
    assert planar(Joint("R", T1, 0, A1, sp.pi / 2), Joint("P", 0, sp.Symbol("d2"), 0, 0)).is_planar
    assert not planar(Joint("R", T1, 0, A1, sp.pi / 2), SECOND).is_planar
    assert not Chain("arm", (FIRST, SECOND), ("vx", "vy"), Base(tilt=sp.pi / 2)).is_planar


def test_another_task_leaves_the_arm_as_it_is() -> None:
    arm = planar(FIRST, SECOND).with_task("vx", "wz")
    assert arm.task == ("vx", "wz")
    assert arm.joints == (FIRST, SECOND)
    assert arm.linear_rows == ("x",)
