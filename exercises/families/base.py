"""What a family is, and the draws that families share."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import sympy as sp

from exercises.arm.chain import Base, Chain, Joint, Point
from exercises.stream import Stream

Joints = tuple[Joint, ...]


@dataclass(frozen=True)
class Family:
    """A kind of arm: its name, a title for people, the chapter's example it follows, and how one is drawn.

    A `varied` family draws the structure, too: its arms differ in difficulty and in what they can be asked, so that
    `sample` takes, beside the stream, `band` (least and greatest step of difficulty) and `accepts` (a test of a chain).
    """

    name: str
    title: str
    source: str
    sample: Callable[..., Chain]
    varied: bool = False


def centimetres(rng: Stream, low: int, high: int) -> sp.Rational:
    """Return a length in metres with two decimals, from `low` to `high` centimetres."""
    return sp.Rational(rng.integer(low, high), 100)


def millimetres(rng: Stream, low: int, high: int) -> sp.Rational:
    """Return a length in metres with three decimals, from `low` to `high` millimetres."""
    return sp.Rational(rng.integer(low, high), 1000)


def turned(rng: Stream, step: int) -> sp.Expr:
    """Return an angle in (-pi, pi] that is a multiple of `step` degrees."""
    count = 360 // step
    degrees = step * rng.below(count)
    return sp.pi * sp.Rational(degrees if degrees <= 180 else degrees - 360, 180)


def standing_in_plane(rng: Stream) -> Base:
    """Return a base displaced in the world's xy plane, by other than zero along both axes."""

    def coordinate() -> sp.Rational:
        return sp.Rational(rng.choice([k for k in range(-9, 10) if k]), 10)

    return Base((coordinate(), coordinate(), sp.S.Zero))


def sign(rng: Stream) -> int:
    """Return 1 or -1."""
    return rng.choice((1, -1))


def on_the_floor(rng: Stream) -> Base:
    """Return a base that stands upright at a height above the world's origin."""
    return Base((sp.S.Zero, sp.S.Zero, centimetres(rng, 10, 90)))


def hung(rng: Stream) -> Base:
    """Return a base on the floor or under the ceiling."""
    return Base((sp.S.Zero, sp.S.Zero, centimetres(rng, 20, 90)), sp.S.Zero, rng.choice((sp.S.Zero, sp.pi)))


def with_point(rng: Stream, joints: Joints, bend: sp.Expr = sp.S.Zero) -> tuple[Joints, Point]:
    """Return the joints and the point of interest, which the table or a place in the last frame puts where it is.

    In half of all draws P is O_n, or stands beside it by `bend` along y_n. In the others a length of the table is zero
    and P has it instead, in the coordinates of frame n. The Jacobian has as many terms in all of them, so that nobody's
    arm is harder than another's.
    """
    if rng.below(2):
        return joints, Point(len(joints), (sp.S.Zero, bend, sp.S.Zero))
    return _on_slide(rng, joints) if joints[-1].kind == "P" else _on_link(rng, joints, bend)


def _on_link(rng: Stream, joints: Joints, bend: sp.Expr) -> tuple[Joints, Point]:
    """Give a_n to P, along x_n or y_n, either way; without one, d_n along z_n."""
    n, last = len(joints), joints[-1]
    if last.a == 0:
        return (*joints[:-1], replace(last, d=sp.S.Zero)), Point(n, (sp.S.Zero, sp.S.Zero, _of_point(last.d, n)))
    x, y = _of_point(last.a, n), bend
    for _ in range(rng.below(4)):
        x, y = -y, x
    return (*joints[:-1], replace(last, a=sp.S.Zero)), Point(n, (x, y, sp.S.Zero))


def _on_slide(rng: Stream, joints: Joints) -> tuple[Joints, Point]:
    """Give P a part of the slide's zero, along z_n, or a_(n-1), which runs along x_n where the slide's angle is 0."""
    n, (before, last) = len(joints), joints[-2:]
    zero = last.d - sp.Symbol(f"d{n}")
    along = [axis for axis, there in (("x", before.a != 0 and last.theta == 0), ("z", zero != 0)) if there]
    if not along:
        return joints, Point(n)
    if rng.choice(along) == "x":
        aside = Point(n, (_of_point(before.a, n), sp.S.Zero, sp.S.Zero))
        return (*joints[:-2], replace(before, a=sp.S.Zero), last), aside
    beyond = centimetres(rng, 5, 20)
    return (*joints[:-1], replace(last, d=last.d - beyond)), Point(n, (sp.S.Zero, sp.S.Zero, beyond))


def _of_point(length: sp.Expr, n: int) -> sp.Expr:
    """Return a length of the table as one of P: a symbol is L_n then, as a_n and d_n are names of the table."""
    return length if length.is_number else sp.Symbol(f"L{n}")


def senses(rng: Stream, count: int) -> tuple[sp.Expr, ...]:
    """Return twists 0 or pi of `count` parallel axes of which the last points against the base's, in all orders."""
    turns = [rng.below(2) for _ in range(count - 1)]
    return tuple(sp.pi * turn for turn in (*turns, 1 - sum(turns) % 2))
