"""Planar arms with slides, the planar 3R for its pose, and the pan-tilt head; PR and PRR work in a vertical plane."""

from dataclasses import replace

import sympy as sp

from exercises.arm.chain import Base, Chain, Joint
from exercises.families.base import Family, centimetres, on_the_floor, sign, standing_in_plane, turned, with_point
from exercises.stream import Stream

T1, T2, T3 = sp.symbols("theta1 theta2 theta3")
D1, D2, D3 = sp.symbols("d1 d2 d3")
UP, RIGHT = sp.S.Zero, sp.pi / 2


def sample_pr(rng: Stream) -> Chain:
    """Draw a vertical slide that carries a link: its zero, lateral offset, length, offset and sense of the joint."""
    table = (
        Joint("P", 0, D1 + sign(rng) * centimetres(rng, 10, 60), centimetres(rng, 5, 40), sign(rng) * RIGHT),
        Joint("R", T2 + turned(rng, 15), 0, sp.Symbol("a2"), 0),
    )
    joints, point = with_point(rng, table, sign(rng) * centimetres(rng, 5, 30))
    return Chain("planar-pr", joints, ("vx", "vz"), on_the_floor(rng), point, "planar PR arm in a vertical plane")


def sample_prr(rng: Stream) -> Chain:
    """Draw a vertical slide that carries two links: zero, offset, lengths, offsets and sense of the joints."""
    table = (
        Joint("P", 0, D1 + sign(rng) * centimetres(rng, 10, 60), centimetres(rng, 5, 25), sign(rng) * RIGHT),
        Joint("R", T2 + turned(rng, 15), 0, centimetres(rng, 30, 80), 0),
        Joint("R", T3 + turned(rng, 15), 0, sp.Symbol("a3"), 0),
    )
    joints, point = with_point(rng, table)
    return Chain(
        "planar-prr", joints, ("vx", "vz", "wy"), on_the_floor(rng), point, "planar PRR arm in a vertical plane"
    )


def sample_rpr(rng: Stream) -> Chain:
    """Draw a turning slide with a link at its end: lateral offset, zero of the slide, length, offsets, senses."""
    table = (
        Joint("R", T1 + turned(rng, 30), 0, centimetres(rng, 5, 40), RIGHT),
        Joint("P", 0, D2 + sign(rng) * centimetres(rng, 10, 90), 0, sign(rng) * RIGHT),
        Joint("R", T3 + turned(rng, 30), 0, sp.Symbol("a3"), 0),
    )
    joints, point = with_point(rng, table)
    return Chain("planar-rpr", joints, ("vx", "vy", "wz"), standing_in_plane(rng), point, "planar RPR arm")


def sample_rrp(rng: Stream) -> Chain:
    """Draw two links, the second of which slides: lengths, offsets and senses of the joints."""
    table = (
        Joint("R", T1 + turned(rng, 30), 0, centimetres(rng, 30, 80), rng.choice((sp.S.Zero, sp.pi))),
        Joint("R", T2 + turned(rng, 15), 0, sp.Symbol("a2"), sign(rng) * RIGHT),
        Joint("P", 0, D3, 0, 0),
    )
    joints, point = with_point(rng, table)
    return Chain("planar-rrp", joints, ("vx", "vy", "wz"), standing_in_plane(rng), point, "planar RRP arm")


def sample_3r_pose(rng: Stream) -> Chain:
    """Draw three links: lengths (all different), offsets of joints 2 and 3, sense of joint 2, base place."""
    lengths: list[sp.Expr] = [centimetres(rng, 40, 70), centimetres(rng, 20, 35)]
    lengths.insert(rng.below(3), sp.S.Zero)
    offsets = (sp.S.Zero, turned(rng, 15), turned(rng, 15))
    twists = (rng.choice((sp.S.Zero, sp.pi)), sp.S.Zero, sp.S.Zero)
    table = tuple(
        Joint("R", q + offset, 0, length or sp.Symbol(f"a{i}"), twist)
        for i, (q, offset, length, twist) in enumerate(zip((T1, T2, T3), offsets, lengths, twists, strict=True), 1)
    )
    joints, point = with_point(rng, table)
    return Chain("planar-3r-pose", joints, ("vx", "vy", "wz"), standing_in_plane(rng), point, "planar 3R arm")


def sample_pan_tilt(rng: Stream) -> Chain:
    """Draw a pan-tilt head: height, offsets and sense of the tilt axis, the place of what it carries."""
    table = (
        Joint("R", T1 + turned(rng, 30), sp.Symbol("d1"), 0, sign(rng) * RIGHT),
        Joint("R", T2 + turned(rng, 15), 0, centimetres(rng, 20, 70), 0),
    )
    base: Base = replace(on_the_floor(rng), tilt=rng.choice((UP, sp.pi)))
    joints, point = with_point(rng, table)
    return Chain("pan-tilt", joints, ("vx", "vy", "vz"), base, point, "pan-tilt head")


PLANAR_ARMS = (
    Family("planar-pr", "Planar PR arm (slide, link)", "equations 6.1 to 6.3", sample_pr),
    Family("planar-rpr", "Planar RPR arm for its pose", "equations 6.9 to 6.12", sample_rpr),
    Family("planar-rrp", "Planar RRP arm for its pose", "equations 6.9 to 6.12", sample_rrp),
    Family("planar-prr", "Planar PRR arm for its pose", "equations 6.1 to 6.3", sample_prr),
    Family("planar-3r-pose", "Planar 3R arm for its pose", "equations 6.1 to 6.3", sample_3r_pose),
    Family("pan-tilt", "Pan-tilt head", "equation 6.3 with m > n", sample_pan_tilt),
)
