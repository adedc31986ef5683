"""Define the axes of variation (`family.Variation`): functions that change one property of an arm at random.

The numbers are easy to work with: lengths in steps of 5 cm, angles with well-known sines, base positions in decimetres.
To shift the zero of a joint means to add an offset to its variable.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import sympy as sp

from qdot.exercises.arm.chain import Base, Chain, Joint, Point
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.lengths import substitute_in_arm

Centimetres = Sequence[int]

ANGLES, RIGHT_ANGLES = (30, 45, 60, 90, -30, -45, -60, -90), (0, 90, 180, -90)
"""Angles of the base, and offsets of a revolute joint, in degrees."""

HAND_LENGTHS: Centimetres = (5, 10, 15, 20)
"""Distances of the point of interest from a frame."""
BASE_HEIGHTS: Centimetres = tuple(range(20, 95, 5))
PRISMATIC_LENGTHS: Centimetres = (10, 15, 20, 25, 30, 40, 45, 50, 60, 70, 75, 80, 90)
SIGNED_LENGTHS: Centimetres = (*PRISMATIC_LENGTHS, *(-length for length in PRISMATIC_LENGTHS))
"""Offsets of a prismatic joint."""
BASE_DECIMETRES = tuple(k for k in range(-9, 10) if k)
"""Coordinates of a displaced base, in decimetres."""

MIN_SEPARATION = 5
"""Minimum difference of two numeric lengths, in centimetres. Equal lengths would add unwanted singular
configurations."""


def to_metres(centimetres: int) -> sp.Rational:
    """Convert a length from centimetres to metres."""
    return sp.Rational(centimetres, 100)


def to_radians(angle: int) -> sp.Expr:
    """Convert an angle from degrees to radians."""
    return sp.pi * sp.Rational(angle, 180)


def choose_sign(rng: Stream) -> int:
    """Return 1 or -1 at random."""
    return rng.choice((1, -1))


def are_distinct(centimetres: Sequence[int]) -> bool:
    """Return whether no two lengths are nearly equal."""
    return all(abs(a - b) >= MIN_SEPARATION for a, b in combinations(centimetres, 2))


# --- lengths, joint offsets, directions of the axes ---


def set_lengths(chain: Chain, rng: Stream, ranges: Mapping[str, Centimetres], candidates: Sequence[str]) -> Chain:
    """Return the arm with random numbers for the lengths in `ranges`, except one of the `candidates` (if any)."""
    symbolic_length = rng.choice(candidates) if candidates else None
    names = [name for name in ranges if name != symbolic_length]
    lengths = [rng.choice(ranges[name]) for name in names]
    while not are_distinct(lengths):
        lengths = [rng.choice(ranges[name]) for name in names]
    return substitute_lengths_in_cm(chain, dict(zip(names, lengths, strict=True)))


def set_lengths_together(chain: Chain, rng: Stream, ranges: Mapping[str, Centimetres]) -> Chain:
    """Return the arm with a number for each length in `ranges`, at the same random index in all ranges.

    The ranges thus determine the ratios of the lengths, on which singular angles may depend.
    """
    index = rng.choice(range(min(map(len, ranges.values()))))
    return substitute_lengths_in_cm(chain, {name: lengths[index] for name, lengths in ranges.items()})


def substitute_lengths_in_cm(chain: Chain, lengths: Mapping[str, int]) -> Chain:
    """Return the arm with lengths (cm) substituted for the symbols with these names."""
    return substitute_in_arm(chain, {sp.Symbol(name): to_metres(length) for name, length in lengths.items()})


def shift_zeros(chain: Chain, rng: Stream, ranges: Mapping[int, Sequence[int]]) -> Chain:
    """Return the arm with random offsets of some joints; `ranges` maps joint numbers to degrees or centimetres."""
    joints = list(chain.joints)
    for number, choices in ranges.items():
        joints[number - 1] = shift_zero(joints[number - 1], rng.choice(choices))
    return replace(chain, joints=tuple(joints))


def shift_zero(joint: Joint, offset: int) -> Joint:
    """Return a joint with its offset increased by some degrees (revolute) or centimetres (prismatic)."""
    return joint.with_variable_entry(joint.variable_entry + (to_radians if joint.is_revolute else to_metres)(offset))


def reverse_axes(chain: Chain, rng: Stream, groups: Sequence[Sequence[int]]) -> Chain:
    """Return the arm with the twists of random groups of joints reversed: 90 becomes -90 degrees, and 0 becomes 180."""
    joints = list(chain.joints)
    for group in groups:
        if rng.integer_below(2):
            for number in group:
                alpha = joints[number - 1].alpha
                joints[number - 1] = replace(joints[number - 1], alpha=sp.pi - alpha if alpha in (0, sp.pi) else -alpha)
    return replace(chain, joints=tuple(joints))


# --- base ---


def displace_and_rotate_base(chain: Chain, rng: Stream) -> Chain:
    """Displace the base in the world's xy plane, along both axes, and rotate it there."""
    position = (sp.Rational(rng.choice(BASE_DECIMETRES), 10), sp.Rational(rng.choice(BASE_DECIMETRES), 10), sp.S.Zero)
    return replace(chain, base=Base(position, to_radians(rng.choice(ANGLES))))


def displace_base(chain: Chain, rng: Stream) -> Chain:
    """Displace the base in the world's xy plane, along both axes."""
    return replace(chain, base=replace(displace_and_rotate_base(chain, rng).base, yaw=sp.S.Zero))


def raise_base(chain: Chain, rng: Stream) -> Chain:
    """Put the base at a height above the world's origin."""
    return replace(chain, base=Base((sp.S.Zero, sp.S.Zero, to_metres(rng.choice(BASE_HEIGHTS)))))


def raise_and_rotate_base(chain: Chain, rng: Stream) -> Chain:
    """Put the base at a height above the world's origin, and rotate it."""
    return replace(chain, base=replace(raise_base(chain, rng).base, yaw=to_radians(rng.choice(ANGLES))))


def raise_and_tilt_base(chain: Chain, rng: Stream) -> Chain:
    """Put the base at a height above the world's origin, tilted by a multiple of 90 degrees."""
    tilt = to_radians(rng.choice(RIGHT_ANGLES))
    return replace(chain, base=replace(raise_base(chain, rng).base, tilt=tilt))


def hang_base(chain: Chain, rng: Stream) -> Chain:
    """Put the base at a height above the world's origin, upright or upside down."""
    return replace(chain, base=replace(raise_base(chain, rng).base, tilt=rng.choice((sp.S.Zero, sp.pi))))


def mount_base(chain: Chain, rng: Stream) -> Chain:
    """Put the base on the floor, under the ceiling or on a wall, rotated by right angles."""
    tilt = rng.choice((sp.S.Zero, sp.pi, sp.pi / 2, -sp.pi / 2))
    base = raise_base(chain, rng).base
    return replace(chain, base=replace(base, yaw=to_radians(rng.choice(RIGHT_ANGLES)), tilt=tilt))


# --- point of interest ---


def place_point(chain: Chain, rng: Stream, lateral_offset: sp.Expr = sp.S.Zero) -> Chain:
    """Place the point of interest P at O_n, or at a distance from O_n that is a length of the table.

    In half of all samples, P is O_n, displaced by `lateral_offset` along y_n. In the other samples, a length of the
    table becomes a coordinate of P in frame n. In both cases the Jacobian has the same number of terms, so that all
    arms are equally hard.
    """
    n = chain.n
    if rng.integer_below(2):
        return replace(chain, tool=Point(n, (sp.S.Zero, lateral_offset, sp.S.Zero)) if lateral_offset != 0 else None)
    if chain.joints[-1].is_prismatic:
        joints, point = _place_on_prismatic_joint(rng, chain.joints)
    else:
        joints, point = _place_on_link(rng, chain.joints, lateral_offset)
    return replace(chain, joints=joints, tool=point)


def place_point_beside(chain: Chain, rng: Stream, distances: Centimetres) -> Chain:
    """Place P at one of the distances beside the last link, or on the link if its length is symbolic.

    At a distance h beside a link of symbolic length a_n, singular angles would contain arctan(h/a_n).
    """
    lateral_offset = choose_sign(rng) * to_metres(rng.choice(distances))
    return place_point(chain, rng, lateral_offset if chain.joints[-1].a.is_number else sp.S.Zero)


def place_point_beyond_joint(chain: Chain, rng: Stream) -> Chain:
    """Put P at the distance L_3 beyond the last of three prismatic joints, and beside its axis along x or y."""
    lateral_offset = choose_sign(rng) * to_metres(rng.choice(HAND_LENGTHS))
    x, y = rng.choice(((lateral_offset, sp.S.Zero), (sp.S.Zero, lateral_offset)))
    return replace(chain, tool=Point(3, (x, y, sp.Symbol("L3"))))


def choose_point_frame(chain: Chain, rng: Stream, frames: Sequence[int]) -> Chain:
    """Fix P in one of the frames with the numbers `frames`, whose origins coincide."""
    frame = rng.choice(frames)
    return replace(chain, tool=None if frame == chain.n else Point(frame))


def _place_on_link(rng: Stream, joints: tuple[Joint, ...], lateral_offset: sp.Expr) -> tuple[tuple[Joint, ...], Point]:
    """Move a_n from the table to P, along x_n or y_n with either sign; if a_n is zero, move d_n along z_n instead."""
    n, last_joint = len(joints), joints[-1]
    if last_joint.a == 0:
        point_above = Point(n, (sp.S.Zero, sp.S.Zero, _rename_length(last_joint.d, n)))
        return (*joints[:-1], replace(last_joint, d=sp.S.Zero)), point_above
    x, y = _rename_length(last_joint.a, n), lateral_offset
    for _ in range(rng.integer_below(4)):
        x, y = -y, x
    return (*joints[:-1], replace(last_joint, a=sp.S.Zero)), Point(n, (x, y, sp.S.Zero))


def _place_on_prismatic_joint(rng: Stream, joints: tuple[Joint, ...]) -> tuple[tuple[Joint, ...], Point]:
    """Move a part of the last joint's offset from the table to P, along z_n, or the length a_(n-1), along x_n.

    The length can be moved only if theta_n is 0. If both are zero, P stays at O_n, because otherwise entries of J would
    have one more term.
    """
    n, (previous_joint, last_joint) = len(joints), joints[-2:]
    joint_offset = last_joint.d - sp.Symbol(f"d{n}")
    if previous_joint.a != 0 and last_joint.theta == 0 and (joint_offset == 0 or rng.integer_below(2)):
        point_beside = Point(n, (_rename_length(previous_joint.a, n), sp.S.Zero, sp.S.Zero))
        return (*joints[:-2], replace(previous_joint, a=sp.S.Zero), last_joint), point_beside
    if joint_offset == 0:
        return joints, Point(n)
    distance_beyond = to_metres(rng.choice(HAND_LENGTHS))
    point_beyond = Point(n, (sp.S.Zero, sp.S.Zero, distance_beyond))
    return (*joints[:-1], replace(last_joint, d=last_joint.d - distance_beyond)), point_beyond


def _rename_length(length: sp.Expr, n: int) -> sp.Expr:
    """Return a length of the table as a coordinate of P.

    A symbol becomes L_n, because a_n and d_n belong to the table.
    """
    return length if length.is_number else sp.Symbol(f"L{n}")


# --- the rows of the task ---


def stand_upright(chain: Chain, rng: Stream) -> Chain:
    """Move an arm from the world's xy plane to its xz plane, with the rows of its task, in half of all samples."""
    if rng.integer_below(2):
        return chain
    x, y, _ = chain.base.position
    upright_rows = {"vx": "vx", "vy": "vz", "wz": "wy"}
    base = Base((x, sp.S.Zero, abs(y)), sp.S.Zero, sp.pi / 2)
    return replace(chain, base=base, task=tuple(upright_rows[row] for row in chain.task))
