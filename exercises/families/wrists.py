"""Wrists of three revolute joints, for the angular velocity of the hand: ZYZ and roll-pitch-yaw.

Both are singular where the outer axes are in line: at the zero of joint 2 in a ZYZ wrist, a right angle from it in a
roll-pitch-yaw wrist. Where zeros vary, that of joint 2 is up to 30 degrees off.
"""

from dataclasses import replace

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.families.axes import FREE, OR_NONE, Lengths, Zeros, place_point, raise_base, senses
from qdot.exercises.families.base import Axis, Family, dh

TURNS = ("wx", "wy", "wz")
NEAR = (30, 150, 180, -150, -30)
"""Degrees by which the zero of joint 2 moves: within 30 of outer axes in line (ZYZ) or at right angles."""


def _mount_base(chain: Chain, rng: Stream) -> Chain:
    tilt = rng.choice(OR_NONE)
    return replace(chain, base=replace(raise_base(chain, rng).base, tilt=sp.pi * sp.Rational(tilt, 180)))


AXES: dict[str, Axis] = {
    "lengths": Lengths({"d3": (5, 10, 15, 20, 25, 30)}),
    "zeros": Zeros({1: FREE, 2: NEAR, 3: FREE}),
    "senses": senses((1,), (2,)),
    "base": _mount_base,
    "tool": place_point,
}

_ZYZ = dh("R 0 0 -90", "R 0 0 90", "R d3 0 0")
_SQUARE = dh("R 0 0 90", "R 0 0 90", "R d3 0 0")
_RPY = (_SQUARE[0], replace(_SQUARE[1], theta=_SQUARE[1].theta + sp.pi / 2), _SQUARE[2])

WRISTS = (
    Family(
        "wrist-zyz", "Wrist with Euler angles ZYZ", "equation 6.10",
        Chain("wrist-zyz", _ZYZ, TURNS, title="ZYZ wrist"), AXES,
    ),
    Family(
        "wrist-rpy", "Roll-pitch-yaw wrist", "equation 6.10",
        Chain("wrist-rpy", _RPY, TURNS, title="roll-pitch-yaw wrist"), AXES,
    ),
)  # fmt: skip
