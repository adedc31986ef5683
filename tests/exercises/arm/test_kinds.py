"""Boundary or internal: what single configurations are."""

import numpy as np
import pytest
import sympy as sp

from exercises.arm.axes import Sample
from exercises.arm.chain import Chain, Joint
from exercises.arm.kinds import kind_at, kind_is_sure, kinds_at
from exercises.arm.kinematics import NumericChain

T1, T2 = sp.symbols("theta1 theta2")


def planar(*lengths: float) -> tuple[Chain, NumericChain]:
    angles = sp.symbols("theta1 theta2 theta3")
    joints = (Joint("R", q, 0, sp.Float(a), 0) for q, a in zip(angles, lengths, strict=False))
    chain = Chain("planar", tuple(joints), ("vx", "vy"))
    return chain, NumericChain(chain, {})


@pytest.mark.parametrize(
    ("lengths", "q", "kind"),
    [
        ((0.5, 0.3), (0.4, 0.0), "boundary"),
        ((0.5, 0.3), (0.4, np.pi), "boundary"),
        ((0.4, 0.4), (0.4, np.pi), "internal"),
        ((0.5, 0.3), (0.4, 1.0), "regular"),
        ((0.9, 0.3, 0.2), (0.4, np.pi, 0.0), "boundary"),
        ((0.9, 0.3, 0.2), (0.4, 0.0, np.pi), "internal"),
        ((0.5, 0.4, 0.3), (0.4, np.pi, np.pi), "internal"),
        ((0.5, 0.4, 0.3), (0.4, 0.0, 0.0), "boundary"),
    ],
)
def test_the_kind_of_a_planar_pose_is_that_of_its_reach(
    lengths: tuple[float, ...], q: tuple[float, ...], kind: str
) -> None:
    """A fold is an edge of the annulus between the longest link less the others and all of them, or inside it."""
    chain, arm = planar(*lengths)
    assert kind_at(chain, Sample(arm, np.array(q))) == kind


def test_planar_kinds_are_those_of_the_annulus() -> None:
    """For every way to fold three links, the distance from the base tells the kind."""
    for lengths in [(0.9, 0.3, 0.2), (0.2, 0.9, 0.35), (0.5, 0.45, 0.3), (0.31, 0.22, 0.8)]:
        chain, arm = planar(*lengths)
        edges = {sum(lengths), max(0.0, 2 * max(lengths) - sum(lengths))}
        for second in (0.0, np.pi):
            for third in (0.0, np.pi):
                q = np.array([0.3, second, third])
                reach = float(np.linalg.norm(arm.point(q)))
                on_edge = any(abs(reach - edge) < 1e-9 and edge > 0 for edge in edges)
                assert kind_at(chain, Sample(arm, q)) == ("boundary" if on_edge else "internal"), (lengths, q)


def test_a_narrow_hole_in_the_reach_is_a_boundary_still() -> None:
    for gap in (0.02, 0.005, 0.001):
        chain, arm = planar(0.5, 0.5 - gap)
        assert kind_at(chain, Sample(arm, np.array([0.4, np.pi]))) == "boundary"


def test_kinds_are_told_only_where_the_rows_are_rates_of_coordinates_with_a_reach() -> None:
    def sure(*rows: tuple[float, float, float], task: tuple[str, ...]) -> bool:
        angles = sp.symbols("theta1:5")
        joints = (Joint("R", q, d, a, alpha * sp.pi / 2) for q, (d, a, alpha) in zip(angles, rows, strict=False))
        return kind_is_sure(Chain("arm", tuple(joints), task))

    planar, turning = [(0, 1, 0)] * 3, [(0, 0, 1), (0, 1, 1), (0, 0, 0)]
    assert sure(*planar, task=("vx", "vy", "wz"))
    assert sure(*turning, task=("wx", "wy", "wz"))
    assert not sure(*turning, task=("wx", "wy"))  # no angles whose rates these are
    assert not sure(*turning, task=("vx", "vy", "wz"))
    assert not sure(*turning[:2], task=("vx", "vy", "vz"))  # the reach is a surface


@pytest.mark.parametrize("offset", [3.0, 1.0, 0.3, 0.1, 0.03, 0.01, 0.001])
def test_a_corner_of_the_reach_is_a_boundary_however_blunt(offset: float) -> None:
    """Seen from the side, the arm reaches a disc between two lines; where they meet, both directions are lost at once.

    The corner is the blunter, and the directions that lead out of it the fewer, the smaller the offset.
    """
    rows = (Joint("R", T1, 0, 0, sp.pi / 2), Joint("R", T2, sp.Symbol("d2"), sp.Symbol("a2"), 0))
    chain = Chain("RR from the side", rows, ("vy", "vz"))
    arm = NumericChain(chain, {"d2": offset, "a2": 1.0})
    corners = [Sample(arm, np.array(q)) for q in ((0.0, np.pi / 2), (np.pi, np.pi / 2), (np.pi, -np.pi / 2))]
    assert np.allclose(arm.jacobian(np.stack([corner.q for corner in corners]))[:, 1:3], 0)
    assert kinds_at(chain, corners) == ["boundary"] * 3
