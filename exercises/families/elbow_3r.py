"""elbow-3r: Example 6.3, the arm of a Scorbot with a shoulder offset, down to the wrist point P.

Two of the three link lengths are numbers such that the shoulder singularity exists (a1 < a2 + a3); the arm stands on
the floor, hangs from the ceiling or is fixed to a wall.
"""

import sympy as sp

from exercises.arm.chain import Base, Chain, Joint
from exercises.families.base import Family, centimetres, turned, with_point
from exercises.stream import Stream


def sample(rng: Stream) -> Chain:
    """Draw an arm: lengths, joint offsets, side of the shoulder axis, mounting."""
    theta1, theta2, theta3 = sp.symbols("theta1 theta2 theta3")
    links: list[sp.Expr] = list(sp.symbols("a2 a3"))
    links[rng.below(2)] = centimetres(rng, 30, 80)
    table = (
        Joint("R", theta1 + turned(rng, 30), sp.Symbol("d1"), centimetres(rng, 5, 25), rng.choice((1, -1)) * sp.pi / 2),
        Joint("R", theta2 + turned(rng, 90), sp.S.Zero, links[0], sp.S.Zero),
        Joint("R", theta3 + turned(rng, 90), sp.S.Zero, links[1], sp.S.Zero),
    )
    tilt = rng.choice((sp.S.Zero, sp.pi, sp.pi / 2, -sp.pi / 2))
    base = Base((sp.S.Zero, sp.S.Zero, centimetres(rng, 20, 90)), turned(rng, 90), tilt)
    joints, point = with_point(rng, table)
    return Chain("elbow-3r", joints, ("vx", "vy", "vz"), base, point, "elbow arm with a shoulder offset")


ELBOW_3R = Family("elbow-3r", "Elbow arm with shoulder offset (Scorbot)", "Example 6.3", sample)
