"""What a family is, and the draws that families share."""

from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from exercises.arm.chain import Base, Chain
from exercises.stream import Stream


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
