"""Arms that place a point in space by slides: Cartesian, cylindrical, spherical (without and with lateral offset)."""

import sympy as sp

from qdot.exercises.arm.chain import Chain, Point
from qdot.exercises.common.stream import Stream
from qdot.exercises.families.axes import (
    FREE,
    HAND,
    HEIGHTS,
    OFFSET,
    SLIDE,
    Centimetres,
    Lengths,
    Zeros,
    both_ways,
    metres,
    place_point,
    raise_and_rotate_base,
    raise_base,
    senses,
    sign,
)  # fmt: skip
from qdot.exercises.families.base import Axis, Family, dh

SPACE = ("vx", "vy", "vz")
BOTH_WAYS = both_ways(SLIDE)
SHOULDER: Centimetres = (10, 15, 20, 25, 30, 40)


def _place_hand(chain: Chain, rng: Stream) -> Chain:
    """Put P beyond the last slide and beside it, along x or y."""
    aside = sign(rng) * metres(rng.choice(HAND))
    x, y = rng.choice(((aside, sp.S.Zero), (sp.S.Zero, aside)))
    return Chain(chain.name, chain.joints, chain.task, chain.base, Point(3, (x, y, sp.Symbol("L3"))), chain.title)


def _spherical_axes(lengths: Axis) -> dict[str, Axis]:
    return {
        "lengths": lengths,
        "zeros": Zeros({1: FREE, 2: FREE, 3: BOTH_WAYS}),
        "senses": senses((1, 2)),
        "base": raise_base,
        "tool": place_point,
    }


POSITIONING = (
    Family(
        "cartesian", "Cartesian arm (three slides)", "equation 6.3",
        Chain("cartesian", dh("P 0 0 -90", "P 90 0 90", "P 0 0 0"), SPACE, title="Cartesian arm"),
        {
            "zeros": Zeros({1: SLIDE, 2: BOTH_WAYS, 3: BOTH_WAYS}),
            "senses": senses((1,), (2,)),
            "base": raise_and_rotate_base,
            "tool": _place_hand,
        },
    ),
    Family(
        "cylindrical", "Cylindrical arm (RPP)", "equations 6.9 to 6.12",
        Chain("cylindrical", dh("R d1 0 0", "P 0 a2 -90", "P 0 0 0"), SPACE, title="cylindrical arm"),
        {
            "lengths": Lengths({"d1": HEIGHTS, "a2": OFFSET}, ("d1",)),
            "zeros": Zeros({1: FREE, 2: SLIDE, 3: BOTH_WAYS}),
            "senses": senses((2,)),
            "base": raise_base,
            "tool": place_point,
        },
    ),
    Family(
        "spherical", "Spherical arm (RRP)", "equations 6.9 to 6.12",
        Chain("spherical", dh("R d1 0 -90", "R 0 0 90", "P 0 0 0"), SPACE, title="spherical arm"),
        _spherical_axes(Lengths({"d1": HEIGHTS})),
    ),
    Family(
        "spherical-offset", "Spherical arm with lateral offset", "equations 6.9 to 6.12",
        Chain(
            "spherical-offset", dh("R d1 0 -90", "R d2 0 90", "P 0 0 0"), SPACE,
            title="spherical arm with a lateral offset",
        ),
        _spherical_axes(Lengths({"d1": HEIGHTS, "d2": SHOULDER}, ("d1",))),
    ),
)  # fmt: skip
