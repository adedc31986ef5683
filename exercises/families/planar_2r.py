"""planar-2r: the arm of Examples 6.1, 6.2 and 6.4, its tool bent off the last link.

The bend (a point P beside the last frame's origin) makes every answer the arm's own: det J = a1 (a2 s2 + h c2), so
that even the singular angles differ from arm to arm. a1 stays a symbol, a2 and h are numbers.
"""

from dataclasses import replace

import sympy as sp

from exercises.arm.chain import Chain, Joint
from exercises.families.base import Family, centimetres, standing_in_plane, turned, with_point
from exercises.stream import Stream


def sample(rng: Stream) -> Chain:
    """Draw an arm: lengths, the point, offset of joint 2, sense of its axis, base place and heading."""
    theta1, theta2 = sp.symbols("theta1 theta2")
    lengths = (sp.Symbol("a1"), centimetres(rng, 20, 80))  # a2 is the number, as the singular angles depend on it
    bend = centimetres(rng, 5, 30) * rng.choice((1, -1))
    table = (
        Joint("R", theta1, sp.S.Zero, lengths[0], rng.choice((sp.S.Zero, sp.pi))),
        Joint("R", theta2 + turned(rng, 90), sp.S.Zero, lengths[1], sp.S.Zero),
    )
    base = replace(standing_in_plane(rng), yaw=turned(rng, 15))
    joints, point = with_point(rng, table, bend)
    return Chain("planar-2r", joints, ("vx", "vy"), base, point, "planar 2R arm with a bent tool")


PLANAR_2R = Family("planar-2r", "Planar 2R arm", "Examples 6.1, 6.2 and 6.4", sample)
