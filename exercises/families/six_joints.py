"""Arms of six joints and one of seven; those with a spherical wrist are asked for their wrist centre.

At the wrist centre J is block triangular, det J = det J11 det J22, and does not depend on the tool. The wrist centre is
the origin of two frames; either may be named as what carries it. The point of the UR kind is O_5, which O_6 coincides
with; a tool beyond it would add terms to every entry. Where a3 is an offset of the elbow, it and d4 stay symbols, as
the arm is singular at tan(theta3) = -d4/a3.
"""

from qdot.exercises.arm.chain import TASK_ROWS, Chain, Point
from qdot.exercises.families.axes import (
    FOREARM,
    FREE,
    OR_NONE,
    SLIDE,
    Centimetres,
    Frames,
    Lengths,
    Zeros,
    both_ways,
    raise_base,
    senses,
)  # fmt: skip
from qdot.exercises.families.base import Axis, Family, dh

SHOULDER = {1: FREE, 2: OR_NONE, 3: OR_NONE}
LATERAL: Centimetres = (10, 15, 20, 25)
WRIST = ("R d4 0 90", "R 0 0 -90", "R d6 0 0")
"""Rows 4, 5 and 6 of a spherical wrist on a forearm d4, the axis of joint 4 running along the forearm."""


UPPER_ARM: Centimetres = (50, 60, 70, 75, 80, 90)
PROPAGATION = "equations 6.9 to 6.12"


def _long_arm(
    name: str, title: str, source: str, rows: tuple[str, ...], frames: tuple[int, int], phrase: str,
    axes: dict[str, Axis],
) -> Family:  # fmt: skip
    """Return a family asked for the origin of two frames and for all six rows, on the floor; the first is the usual."""
    point = None if frames[0] == len(rows) else Point(frames[0])
    plain = Chain(name, dh(*rows), TASK_ROWS, tool=point, title=phrase)
    return Family(name, title, source, plain, {**axes, "base": raise_base, "tool": Frames(frames)})


SIX_JOINTS = (
    _long_arm(
        "stanford-6r", "Stanford arm", PROPAGATION,
        ("R d1 0 -90", "R d2 0 90", "P 0 0 0", "R 0 0 -90", "R 0 0 90", "R d6 0 0"), (4, 5), "Stanford arm",
        {
            "lengths": Lengths({"d2": (10, 15, 20, 25, 30, 40)}),
            "zeros": Zeros({1: FREE, 2: FREE, 3: both_ways(SLIDE), 5: OR_NONE}),
            "senses": senses((1, 2), (4, 5)),
        },
    ),
    _long_arm(
        "puma-560", "PUMA 560", PROPAGATION, ("R d1 0 90", "R 0 a2 0", "R d3 a3 -90", *WRIST), (4, 5), "PUMA 560 arm",
        {
            "lengths": Lengths({"a2": UPPER_ARM, "d3": (15, 20, 25)}),
            "zeros": Zeros(SHOULDER),
            "senses": senses((4, 5)),
        },
    ),
    _long_arm(
        "anthropomorphic-6r", "Elbow arm with spherical wrist", "Example 6.3 with a wrist",
        ("R d1 0 90", "R 0 a2 0", "R 0 0 90", "R d4 0 -90", "R 0 0 90", "R d6 0 0"), (4, 5),
        "anthropomorphic arm with a spherical wrist",
        {
            "lengths": Lengths({"d4": FOREARM}),
            "zeros": Zeros(SHOULDER),
            "senses": senses((1, 3), (4, 5)),
        },
    ),
    _long_arm(
        "industrial-6r", "Industrial 6R arm with offsets", PROPAGATION,
        ("R d1 a1 -90", "R 0 a2 0", "R 0 a3 -90", *WRIST), (4, 5),
        "industrial arm with offsets",
        {
            "lengths": Lengths({"a1": (10, 15, 20, 25, 30), "a2": UPPER_ARM}),
            "zeros": Zeros(SHOULDER),
            "senses": senses((4, 5)),
        },
    ),
    _long_arm(
        "ur-6r", "Arm of the UR kind (6R)", PROPAGATION,
        ("R d1 0 90", "R 0 a2 0", "R 0 a3 0", "R d4 0 90", "R d5 0 -90", "R 0 0 0"), (6, 5), "arm of the UR kind",
        {
            "lengths": Lengths({"a2": (50, 60, 70, 75, 80), "d4": (15, 20, 25), "d5": (5, 10)}),
            "zeros": Zeros({**SHOULDER, 4: OR_NONE}),
            "senses": senses((4, 5)),
        },
    ),
    _long_arm(
        "lbr-7r", "Arm of the LBR kind (7R, redundant)", "equation 6.3 with m < n",
        ("R d1 0 -90", "R 0 0 90", "R d3 0 90", "R 0 0 -90", "R d5 0 -90", "R 0 0 90", "R d7 0 0"), (5, 6),
        "arm of the LBR kind with seven joints",
        {
            "lengths": Lengths({"d3": FOREARM, "d7": LATERAL}),
            "zeros": Zeros({1: FREE, 2: OR_NONE, 3: OR_NONE, 4: OR_NONE}),
            "senses": senses((1, 2, 5, 6), (3, 4)),
        },
    ),
)  # fmt: skip
