"""SCARA arms for position and turn about the vertical, with the slide first, last, or before the turning hand."""

import sympy as sp

from exercises.arm.chain import Chain, Joint
from exercises.families.base import Family, centimetres, on_the_floor, senses, sign, turned, with_point
from exercises.stream import Stream

T1, T2, T3, T4 = sp.symbols("theta1 theta2 theta3 theta4")
D1, D3, D4 = sp.symbols("d1 d3 d4")
TASK = ("vx", "vy", "vz", "wz")


def _upper_arm(rng: Stream, twists: tuple[sp.Expr, ...]) -> tuple[Joint, Joint]:
    lengths: list[sp.Expr] = [sp.Symbol("a1"), sp.Symbol("a2")]
    known = rng.below(2)
    lengths[known] = centimetres(rng, 30, 80)
    return (
        Joint("R", T1 + turned(rng, 30), sp.Symbol("d1"), lengths[0], twists[0]),
        Joint("R", T2 + turned(rng, 15), 0, lengths[1], twists[1]),
    )


def sample_rrpr(rng: Stream) -> Chain:
    """Draw two links, a slide that points down, a turning hand: lengths, offsets, zero of the slide."""
    table = (
        *_upper_arm(rng, senses(rng, 2)),
        Joint("P", 0, D3 + sign(rng) * centimetres(rng, 5, 50), 0, 0),
        Joint("R", T4 + turned(rng, 30), centimetres(rng, 5, 20), 0, 0),
    )
    joints, point = with_point(rng, table)
    return Chain("scara", joints, TASK, on_the_floor(rng), point, "SCARA arm")


def sample_rrrp(rng: Stream) -> Chain:
    """Draw two links, a turning hand with a slide that points down: lengths, offsets, zero of the slide."""
    twists = senses(rng, 3)
    table = (
        *_upper_arm(rng, twists),
        Joint("R", T3 + turned(rng, 30), 0, 0, twists[2]),
        Joint("P", 0, D4 + sign(rng) * centimetres(rng, 5, 50), 0, 0),
    )
    joints, point = with_point(rng, table)
    return Chain("scara-rrrp", joints, TASK, on_the_floor(rng), point, "SCARA arm, slide last")


def sample_prrr(rng: Stream) -> Chain:
    """Draw a lift that carries two links and a turning hand: offset from the lift, lengths, offsets, its zero."""
    links: list[sp.Expr] = [sp.Symbol("a2"), sp.Symbol("a3")]
    links[rng.below(2)] = centimetres(rng, 30, 80)
    twists = senses(rng, 3)
    table = (
        Joint("P", 0, D1 + centimetres(rng, 20, 90), centimetres(rng, 5, 25), twists[0]),
        Joint("R", T2 + turned(rng, 30), 0, links[0], twists[1]),
        Joint("R", T3 + turned(rng, 15), 0, links[1], twists[2]),
        Joint("R", T4 + turned(rng, 30), sp.Symbol("d4"), 0, 0),
    )
    joints, point = with_point(rng, table)
    return Chain("scara-prrr", joints, TASK, on_the_floor(rng), point, "SCARA arm, lift first")


SCARA = (
    Family("scara", "SCARA arm (RRPR)", "equations 6.9 to 6.12", sample_rrpr),
    Family("scara-rrrp", "SCARA arm with the slide last (RRRP)", "equations 6.9 to 6.12", sample_rrrp),
    Family("scara-prrr", "SCARA arm with the lift first (PRRR)", "equations 6.9 to 6.12", sample_prrr),
)
