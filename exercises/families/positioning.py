"""Arms that place a point in space by slides: Cartesian, cylindrical, spherical (without and with lateral offset)."""

from dataclasses import replace

import sympy as sp

from exercises.arm.chain import Chain, Joint, Point
from exercises.families.base import Family, centimetres, on_the_floor, sign, turned, with_point
from exercises.stream import Stream

T1, T2 = sp.symbols("theta1 theta2")
D1, D2, D3 = sp.symbols("d1 d2 d3")
RIGHT = sp.pi / 2
SPACE = ("vx", "vy", "vz")


def sample_cartesian(rng: Stream) -> Chain:
    """Draw three slides at right angles: their zeros and senses, a tool, the heading of the base."""
    joints = (
        Joint("P", 0, D1 + centimetres(rng, 5, 60), 0, sign(rng) * RIGHT),
        Joint("P", RIGHT, D2 + sign(rng) * centimetres(rng, 5, 60), 0, sign(rng) * RIGHT),
        Joint("P", rng.choice((sp.S.Zero, RIGHT)), D3 + sign(rng) * centimetres(rng, 5, 60), 0, 0),
    )
    aside = sign(rng) * centimetres(rng, 5, 30)
    x, y = rng.choice(((aside, sp.S.Zero), (sp.S.Zero, aside)))
    point = Point(3, (x, y, sp.Symbol("L3")))
    base = replace(on_the_floor(rng), yaw=turned(rng, 15))
    return Chain("cartesian", joints, SPACE, base, point, "Cartesian arm")


def sample_cylindrical(rng: Stream) -> Chain:
    """Draw a turning column with a lift and a horizontal slide: offsets, zeros of the slides, lateral offset."""
    table = (
        Joint("R", T1 + turned(rng, 30), sp.Symbol("L1"), 0, 0),
        Joint("P", 0, D2 + centimetres(rng, 5, 50), centimetres(rng, 5, 30), sign(rng) * RIGHT),
        Joint("P", 0, D3 + sign(rng) * centimetres(rng, 10, 95), 0, 0),
    )
    joints, point = with_point(rng, table)
    return Chain("cylindrical", joints, SPACE, on_the_floor(rng), point, "cylindrical arm")


def sample_spherical(rng: Stream) -> Chain:
    """Draw an arm that turns, tilts and slides from one centre: height, offsets, senses, zero of the slide."""
    return _spherical(rng, "spherical", False, "spherical arm")


def sample_spherical_offset(rng: Stream) -> Chain:
    """Draw a spherical arm whose slide runs beside the column: lateral offset, offsets, senses, zero of the slide."""
    return _spherical(rng, "spherical-offset", True, "spherical arm with a lateral offset")


def _spherical(rng: Stream, name: str, lateral: bool, title: str) -> Chain:
    side = sign(rng)
    table = (
        Joint("R", T1 + turned(rng, 30), sp.Symbol("L1"), 0, side * RIGHT),
        Joint("R", T2 + turned(rng, 15), centimetres(rng, 10, 40) if lateral else 0, 0, -side * RIGHT),
        Joint("P", 0, D3 + sign(rng) * centimetres(rng, 10, 95), 0, 0),
    )
    joints, point = with_point(rng, table)
    return Chain(name, joints, SPACE, on_the_floor(rng), point, title)


POSITIONING = (
    Family("cartesian", "Cartesian arm (three slides)", "equation 6.3", sample_cartesian),
    Family("cylindrical", "Cylindrical arm (RPP)", "equations 6.9 to 6.12", sample_cylindrical),
    Family("spherical", "Spherical arm (RRP)", "equations 6.9 to 6.12", sample_spherical),
    Family("spherical-offset", "Spherical arm with lateral offset", "equations 6.9 to 6.12", sample_spherical_offset),
)
