"""Elbow arms beside that of Example 6.3: plain, with lateral shoulder offset, and the orthogonal 3R."""

import sympy as sp

from exercises.arm.chain import Chain, Joint
from exercises.families.base import Family, centimetres, hung, sign, turned, with_point
from exercises.stream import Stream

T1, T2, T3 = sp.symbols("theta1 theta2 theta3")
RIGHT = sp.pi / 2
SPACE = ("vx", "vy", "vz")


def _elbow(rng: Stream, name: str, lateral: sp.Expr, title: str) -> Chain:
    links: list[sp.Expr] = list(sp.symbols("a2 a3"))
    links[rng.below(2)] = centimetres(rng, 30, 80)
    table = (
        Joint("R", T1 + turned(rng, 30), sp.Symbol("d1"), 0, sign(rng) * RIGHT),
        Joint("R", T2 + turned(rng, 90), lateral, links[0], 0),
        Joint("R", T3 + turned(rng, 15), 0, links[1], 0),
    )
    joints, point = with_point(rng, table)
    return Chain(name, joints, SPACE, hung(rng), point, title)


def sample_elbow(rng: Stream) -> Chain:
    """Draw a plain elbow arm: lengths, joint offsets, side of the shoulder axis, floor or ceiling."""
    return _elbow(rng, "elbow", sp.S.Zero, "elbow arm")


def sample_lateral(rng: Stream) -> Chain:
    """Draw an elbow arm that works beside its column: lateral offset, lengths, joint offsets, floor or ceiling."""
    return _elbow(rng, "elbow-lateral", centimetres(rng, 8, 25), "elbow arm with a lateral shoulder offset")


def sample_orthogonal(rng: Stream) -> Chain:
    """Draw three links with axes at right angles: a2 < a3, so that the third joint can bring P to the second axis."""
    side = sign(rng)
    table = (
        Joint("R", T1 + turned(rng, 30), sp.S.Zero, centimetres(rng, 5, 25), side * RIGHT),
        Joint("R", T2 + turned(rng, 90), sp.S.Zero, centimetres(rng, 30, 50), -side * RIGHT),
        Joint("R", T3 + turned(rng, 90), sp.S.Zero, centimetres(rng, 60, 90), 0),
    )
    joints, point = with_point(rng, table)
    return Chain("orthogonal-3r", joints, SPACE, hung(rng), point, "orthogonal 3R arm")


ELBOWS = (
    Family("elbow", "Elbow arm", "Example 6.3 with a1 = 0", sample_elbow),
    Family("elbow-lateral", "Elbow arm with lateral shoulder offset", "Example 6.3 with d2", sample_lateral),
    Family("orthogonal-3r", "Orthogonal 3R arm", "equations 6.1 to 6.3", sample_orthogonal),
)
