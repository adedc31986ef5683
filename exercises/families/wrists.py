"""Wrists of three revolute joints, for the angular velocity of the hand: ZYZ and roll-pitch-yaw.

Both are singular where sin(theta2 + offset) = 0, the outer axes in line: near the zero of joint 2 in a ZYZ wrist, far
from it in a roll-pitch-yaw wrist. The zero itself is up to 30 degrees off, so that the angles differ from arm to arm.
"""

import sympy as sp

from exercises.arm.chain import Base, Chain, Joint
from exercises.families.base import Family, centimetres, sign, turned, with_point
from exercises.stream import Stream

T1, T2, T3 = sp.symbols("theta1 theta2 theta3")
RIGHT = sp.pi / 2
TURNS = ("wx", "wy", "wz")


NEAR = (0, 15, 30, 150, 165, 180, -165, -150, -30, -15)
FAR = (60, 75, 90, 105, 120, -120, -105, -90, -75, -60)
"""Offsets of joint 2 in degrees: within 30 of outer axes in line, and within 30 of axes at right angles."""


def _wrist(rng: Stream, name: str, zeros: tuple[int, ...], title: str) -> Chain:
    middle = sp.pi * sp.Rational(rng.choice(zeros), 180)
    table = (
        Joint("R", T1 + turned(rng, 30), 0, 0, sign(rng) * RIGHT),
        Joint("R", T2 + middle, 0, 0, sign(rng) * RIGHT),
        Joint("R", T3 + turned(rng, 30), centimetres(rng, 5, 30), 0, 0),
    )
    base = Base(
        (sp.S.Zero, sp.S.Zero, centimetres(rng, 20, 90)), sp.S.Zero, rng.choice((sp.S.Zero, sp.pi, RIGHT, -RIGHT))
    )
    joints, point = with_point(rng, table)
    return Chain(name, joints, TURNS, base, point, title)


def sample_zyz(rng: Stream) -> Chain:
    """Draw a wrist whose first and last axes are nearly in line at zero: offsets, senses, mounting, tool length."""
    return _wrist(rng, "wrist-zyz", NEAR, "ZYZ wrist")


def sample_rpy(rng: Stream) -> Chain:
    """Draw a wrist whose axes are nearly at right angles at zero: offsets, senses, mounting, tool length."""
    return _wrist(rng, "wrist-rpy", FAR, "roll-pitch-yaw wrist")


WRISTS = (
    Family("wrist-zyz", "Wrist with Euler angles ZYZ", "equation 6.10", sample_zyz),
    Family("wrist-rpy", "Roll-pitch-yaw wrist", "equation 6.10", sample_rpy),
)
