"""planar-3r: three parallel revolute joints for a point in the plane: J is 2 x 3, so there is no determinant.

The arm is singular where all three links lie on one line: two conditions that hold together.
"""

import sympy as sp

from exercises.arm.chain import Chain, Joint
from exercises.families.base import Family, centimetres, standing_in_plane, turned, with_point
from exercises.stream import Stream


def sample(rng: Stream) -> Chain:
    """Draw an arm: lengths (all different), offsets of joints 2 and 3, sense of their axes, the point, base place."""
    variables = sp.symbols("theta1 theta2 theta3")
    first, second = centimetres(rng, 40, 70), centimetres(rng, 20, 35)
    lengths = rng.shuffled([first, second, None])
    offsets = (sp.S.Zero, turned(rng, 5), turned(rng, 5))
    twists = (rng.choice((sp.S.Zero, sp.pi)), rng.choice((sp.S.Zero, sp.pi)), sp.S.Zero)
    joints = tuple(
        Joint("R", q + offset, sp.S.Zero, sp.Symbol(f"a{i}") if length is None else length, twist)
        for i, (q, offset, length, twist) in enumerate(zip(variables, offsets, lengths, twists, strict=True), 1)
    )
    joints, point = with_point(rng, joints)
    return Chain("planar-3r", joints, ("vx", "vy"), standing_in_plane(rng), point, "planar 3R arm")


PLANAR_3R = Family("planar-3r", "Planar 3R arm (redundant for a point)", "equation 6.3 with m < n", sample)
