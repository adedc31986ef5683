"""The axes of variation that families share: each is what one does to an arm (`base.Axis`).

Numbers are those of a careful author: lengths in steps of 5 cm, angles that have a sine one knows, places to a
decimetre.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import sympy as sp

from qdot.exercises.arm.chain import Base, Chain, Joint, Point
from qdot.exercises.common.stream import Stream

Centimetres = Sequence[int]

OFFSET: Centimetres = (5, 10, 15, 20, 25)
LINK: Centimetres = (30, 35, 40, 45, 50, 60, 70, 75, 80)
FOREARM: Centimetres = (35, 40, 45, 50, 60, 70)
HAND: Centimetres = (5, 10, 15, 20)
"""Lengths in centimetres, by what they are of."""

FREE = (30, 45, 60, 90, -30, -45, -60, -90)
OR_NONE = (0, 90, 180, -90)
"""Angles of a joint where its variable is zero, in degrees: any that one knows the sine of, or right ones and none."""

SLIDE: Centimetres = (10, 15, 20, 25, 30, 40, 45, 50, 60, 70, 75, 80, 90)
PLACES = tuple(k for k in range(-9, 10) if k)
HEIGHTS: Centimetres = tuple(range(20, 95, 5))

APART = 5
"""Centimetres between any two lengths that are given: equal ones add singular configurations that nobody asked for."""


def metres(centimetres: int) -> sp.Rational:
    """Return a length in metres."""
    return sp.Rational(centimetres, 100)


def degrees(angle: int) -> sp.Expr:
    """Return an angle in radians."""
    return sp.pi * sp.Rational(angle, 180)


def sign(rng: Stream) -> int:
    """Return 1 or -1."""
    return rng.choice((1, -1))


@dataclass(frozen=True)
class Lengths:
    """Numbers for lengths, each out of its list in centimetres; one of those that may stay open does."""

    of: Mapping[str, Centimetres]
    open: Sequence[str] = ()

    def __call__(self, chain: Chain, rng: Stream) -> Chain:
        """Return the arm with them."""
        kept = rng.choice(self.open) if self.open else None
        names = [name for name in self.of if name != kept]
        while True:
            drawn = [rng.choice(self.of[name]) for name in names]
            if all(abs(x - y) >= APART for x, y in combinations(drawn, 2)):
                break
        return with_values(chain, {sp.Symbol(name): metres(length) for name, length in zip(names, drawn, strict=True)})


@dataclass(frozen=True)
class LengthsTogether:
    """Numbers in centimetres for lengths, one of several rows: they go together where roots depend on their ratios."""

    names: Sequence[str]
    rows: Sequence[Sequence[int]]

    def __call__(self, chain: Chain, rng: Stream) -> Chain:
        """Return the arm with them."""
        row = rng.choice(self.rows)
        return with_values(
            chain, {sp.Symbol(name): metres(length) for name, length in zip(self.names, row, strict=True)}
        )


def with_values(chain: Chain, values: Mapping[sp.Symbol, sp.Expr]) -> Chain:
    """Return a chain with numbers for some of its symbols."""
    joints = tuple(
        replace(joint, **{key: getattr(joint, key).xreplace(values) for key in ("theta", "d", "a", "alpha")})
        for joint in chain.joints
    )
    x, y, z = (sp.sympify(value).xreplace(values) for value in chain.point.offset)
    tool = None if chain.tool is None else Point(chain.point.frame, (x, y, z))
    points = tuple(named and tuple(value.xreplace(values) for value in named) for named in chain.axis_points)
    return replace(chain, joints=joints, tool=tool, axis_points=points)


@dataclass(frozen=True)
class Zeros:
    """Other zeros of joints: of a revolute one by some angle in degrees, of a slide by some centimetres."""

    of: Mapping[int, Sequence[int]]

    def __call__(self, chain: Chain, rng: Stream) -> Chain:
        """Return the arm with them."""
        joints = list(chain.joints)
        for number, choices in self.of.items():
            joints[number - 1] = shift_zero(joints[number - 1], rng.choice(choices))
        return replace(chain, joints=tuple(joints))


def shift_zero(joint: Joint, by: int) -> Joint:
    """Return a joint whose zero is some degrees or centimetres on."""
    if joint.kind == "R":
        return replace(joint, theta=joint.theta + degrees(by))
    return replace(joint, d=joint.d + metres(by))


def both_ways(centimetres: Centimetres) -> Centimetres:
    """Return lengths forward and backward."""
    return (*centimetres, *(-length for length in centimetres))


@dataclass(frozen=True)
class Senses:
    """Axes that turn the other way, or not: the twists of a group of joints change between 90 and -90, 0 and 180."""

    groups: Sequence[Sequence[int]]

    def __call__(self, chain: Chain, rng: Stream) -> Chain:
        """Return the arm with them."""
        joints = list(chain.joints)
        for number in (number for group in self.groups if rng.below(2) for number in group):
            alpha = joints[number - 1].alpha
            joints[number - 1] = replace(joints[number - 1], alpha=sp.pi - alpha if alpha in (0, sp.pi) else -alpha)
        return replace(chain, joints=tuple(joints))


def senses(*groups: Sequence[int]) -> Senses:
    """Return the axis along which some groups of joints change their twists."""
    return Senses(groups)


# --- where the base stands ---


def place_in_plane(chain: Chain, rng: Stream) -> Chain:
    """Displace the base in the world's xy plane, along both axes, and turn it there."""
    position = (sp.Rational(rng.choice(PLACES), 10), sp.Rational(rng.choice(PLACES), 10), sp.S.Zero)
    return replace(chain, base=Base(position, degrees(rng.choice(FREE))))


def displace_base(chain: Chain, rng: Stream) -> Chain:
    """Displace the base in the world's xy plane, along both axes."""
    return replace(chain, base=replace(place_in_plane(chain, rng).base, yaw=sp.S.Zero))


def raise_base(chain: Chain, rng: Stream) -> Chain:
    """Put the base at a height above the world's origin."""
    return replace(chain, base=Base((sp.S.Zero, sp.S.Zero, metres(rng.choice(HEIGHTS)))))


def raise_and_rotate_base(chain: Chain, rng: Stream) -> Chain:
    """Put the base at a height above the world's origin, and turn it."""
    return replace(chain, base=replace(raise_base(chain, rng).base, yaw=degrees(rng.choice(FREE))))


def hang_base(chain: Chain, rng: Stream) -> Chain:
    """Put the base at a height above the world's origin, upright or upside down."""
    return replace(chain, base=replace(raise_base(chain, rng).base, tilt=rng.choice((sp.S.Zero, sp.pi))))


def mount_base(chain: Chain, rng: Stream) -> Chain:
    """Put the base on the floor, under the ceiling or on a wall, turned by right angles."""
    tilt = rng.choice((sp.S.Zero, sp.pi, sp.pi / 2, -sp.pi / 2))
    return replace(chain, base=replace(raise_base(chain, rng).base, yaw=degrees(rng.choice(OR_NONE)), tilt=tilt))


# --- where the point of interest is ---


def place_point(chain: Chain, rng: Stream, bend: sp.Expr = sp.S.Zero) -> Chain:
    """Have the table or a place in the last frame put the point of interest where it is.

    In half of all draws P is O_n, or stands beside it by `bend` along y_n. In the others a length of the table is zero
    and P has it instead, in the coordinates of frame n. The Jacobian has as many terms in all of them, so that nobody's
    arm is harder than another's.
    """
    n = chain.n
    if rng.below(2):
        return replace(chain, tool=Point(n, (sp.S.Zero, bend, sp.S.Zero)) if bend != 0 else None)
    joints, point = (
        _point_on_slide(rng, chain.joints) if chain.joints[-1].kind == "P" else _point_on_link(rng, chain.joints, bend)
    )
    return replace(chain, joints=joints, tool=point)


@dataclass(frozen=True)
class Beside:
    """The point of interest where `place_point` puts it, and beside a last link whose length is given.

    Beside one whose length is not, singular angles would be arctan(h/a_n).
    """

    by: Centimetres

    def __call__(self, chain: Chain, rng: Stream) -> Chain:
        """Return the arm with them."""
        bend = sign(rng) * metres(rng.choice(self.by))
        return place_point(chain, rng, bend if chain.joints[-1].a.is_number else sp.S.Zero)


def _point_on_link(rng: Stream, joints: tuple[Joint, ...], bend: sp.Expr) -> tuple[tuple[Joint, ...], Point]:
    """Give a_n to P, along x_n or y_n, either way; without one, d_n along z_n."""
    n, last = len(joints), joints[-1]
    if last.a == 0:
        return (*joints[:-1], replace(last, d=sp.S.Zero)), Point(n, (sp.S.Zero, sp.S.Zero, _point_length(last.d, n)))
    x, y = _point_length(last.a, n), bend
    for _ in range(rng.below(4)):
        x, y = -y, x
    return (*joints[:-1], replace(last, a=sp.S.Zero)), Point(n, (x, y, sp.S.Zero))


def _point_on_slide(rng: Stream, joints: tuple[Joint, ...]) -> tuple[tuple[Joint, ...], Point]:
    """Give P a part of the slide's zero, along z_n, or a_(n-1), which runs along x_n where the slide's angle is 0.

    Without either, P stays O_n: beyond it, each entry of J would have a term more.
    """
    n, (before, last) = len(joints), joints[-2:]
    zero = last.d - sp.Symbol(f"d{n}")
    if before.a != 0 and last.theta == 0 and (zero == 0 or rng.below(2)):
        aside = Point(n, (_point_length(before.a, n), sp.S.Zero, sp.S.Zero))
        return (*joints[:-2], replace(before, a=sp.S.Zero), last), aside
    if zero == 0:
        return joints, Point(n)
    beyond = metres(rng.choice(HAND))
    return (*joints[:-1], replace(last, d=last.d - beyond)), Point(n, (sp.S.Zero, sp.S.Zero, beyond))


def _point_length(length: sp.Expr, n: int) -> sp.Expr:
    """Return a length of the table as one of P: a symbol is L_n then, as a_n and d_n are names of the table."""
    return length if length.is_number else sp.Symbol(f"L{n}")


@dataclass(frozen=True)
class Frames:
    """One of several frames, whose origins are one place, carries the point of interest."""

    numbers: Sequence[int]

    def __call__(self, chain: Chain, rng: Stream) -> Chain:
        """Return the arm with them."""
        frame = rng.choice(self.numbers)
        return replace(chain, tool=None if frame == chain.n else Point(frame))


# --- the rows of the task ---


def stand_upright(chain: Chain, rng: Stream) -> Chain:
    """Stand an arm that works in the world's xy plane upright in half of all draws: its rows are those of xz then."""
    if rng.below(2):
        return chain
    x, y, _ = chain.base.position
    names = {"vx": "vx", "vy": "vz", "wz": "wy"}
    base = Base((x, sp.S.Zero, abs(y)), sp.S.Zero, sp.pi / 2)
    return replace(chain, base=base, task=tuple(names[row] for row in chain.task))
