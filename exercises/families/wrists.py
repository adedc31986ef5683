"""Wrists of three revolute joints, for the angular velocity of the hand: ZYZ and roll-pitch-yaw."""

import sympy as sp

from exercises.arm.chain import Base, Chain, Joint
from exercises.families.base import Family, centimetres, sign, turned
from exercises.stream import Stream

T1, T2, T3 = sp.symbols("theta1 theta2 theta3")
RIGHT = sp.pi / 2
TURNS = ("wx", "wy", "wz")


def _wrist(rng: Stream, name: str, middle: sp.Expr, title: str) -> Chain:
    joints = (
        Joint("R", T1 + turned(rng, 30), 0, 0, sign(rng) * RIGHT),
        Joint("R", T2 + middle, 0, 0, sign(rng) * RIGHT),
        Joint("R", T3 + turned(rng, 30), centimetres(rng, 5, 30), 0, 0),
    )
    base = Base(
        (sp.S.Zero, sp.S.Zero, centimetres(rng, 20, 90)), sp.S.Zero, rng.choice((sp.S.Zero, sp.pi, RIGHT, -RIGHT))
    )
    return Chain(name, joints, TURNS, base, None, title)


def sample_zyz(rng: Stream) -> Chain:
    """Draw a wrist whose first and last axes are in line at zero: offsets, senses, mounting, tool length."""
    return _wrist(rng, "wrist-zyz", rng.choice((sp.S.Zero, sp.pi)), "ZYZ wrist")


def sample_rpy(rng: Stream) -> Chain:
    """Draw a wrist whose axes are at right angles at zero: offsets, senses, mounting, tool length."""
    return _wrist(rng, "wrist-rpy", sign(rng) * RIGHT, "roll-pitch-yaw wrist")


WRISTS = (
    Family("wrist-zyz", "Wrist with Euler angles ZYZ", "equation 6.10", sample_zyz),
    Family("wrist-rpy", "Roll-pitch-yaw wrist", "equation 6.10", sample_rpy),
)
