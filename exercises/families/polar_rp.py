"""polar-rp: a revolute joint that turns a prismatic one, with a lateral offset of the slide.

det J = -(d2 + e): singular where the slide is drawn in until P is beside joint 1; with a1 = 0 that would be the axis.
The zero e of the slide is given to the millimetre, as it alone decides the determinant and the singular position.
"""

import sympy as sp

from exercises.arm.chain import Chain, Joint
from exercises.families.base import Family, centimetres, millimetres, standing_in_plane, turned, with_point
from exercises.stream import Stream


def sample(rng: Stream) -> Chain:
    """Draw an arm: lateral offset, zero of the slide, offset of joint 1, side to which the slide points, base place."""
    theta1, d2 = sp.symbols("theta1 d2")
    side = rng.choice((1, -1))
    table = (
        Joint("R", theta1 + turned(rng, 30), sp.S.Zero, centimetres(rng, 5, 40), side * sp.pi / 2),
        Joint("P", sp.S.Zero, d2 + rng.choice((1, -1)) * millimetres(rng, 105, 895), sp.S.Zero, sp.S.Zero),
    )
    joints, point = with_point(rng, table)
    return Chain("polar-rp", joints, ("vx", "vy"), standing_in_plane(rng), point, "planar polar (RP) arm")


POLAR_RP = Family(
    "polar-rp", "Planar polar arm (revolute, prismatic)", "equations 6.9 to 6.12 with a prismatic joint", sample
)
