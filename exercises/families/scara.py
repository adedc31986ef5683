"""SCARA arms for position and turn about the vertical, with the slide first, last, or before the turning hand."""

from qdot.exercises.arm.chain import Chain
from qdot.exercises.families.axes import (
    FREE,
    HAND,
    LINK,
    OFFSET,
    SLIDE,
    Lengths,
    Zeros,
    both_ways,
    place_point,
    raise_base,
    senses,
)  # fmt: skip
from qdot.exercises.families.base import Family, dh

TASK = ("vx", "vy", "vz", "wz")
SHORT_SLIDE = tuple(length for length in SLIDE if length <= 50)

SCARA = (
    Family(
        "scara", "SCARA arm (RRPR)", "equations 6.9 to 6.12",
        Chain("scara", dh("R d1 a1 0", "R 0 a2 180", "P 0 0 0", "R d4 0 0"), TASK, title="SCARA arm"),
        {
            "lengths": Lengths({"a1": LINK, "a2": LINK, "d4": HAND}, ("a1", "a2")),
            "zeros": Zeros({1: FREE, 2: FREE, 3: both_ways(SHORT_SLIDE), 4: FREE}),
            "senses": senses((1, 2)),
            "base": raise_base,
            "tool": place_point,
        },
    ),
    Family(
        "scara-rrrp", "SCARA arm with the slide last (RRRP)", "equations 6.9 to 6.12",
        Chain(
            "scara-rrrp",
            dh("R d1 a1 0", "R 0 a2 0", "R 0 0 180", "P 0 0 0"),
            TASK,
            title="SCARA arm with its slide last",
        ),
        {
            "lengths": Lengths({"a1": LINK, "a2": LINK}, ("a1", "a2")),
            "zeros": Zeros({1: FREE, 2: FREE, 3: FREE, 4: both_ways(SHORT_SLIDE)}),
            "senses": senses((1, 3), (2, 3)),
            "base": raise_base,
            "tool": place_point,
        },
    ),
    Family(
        "scara-prrr", "SCARA arm with the lift first (PRRR)", "equations 6.9 to 6.12",
        Chain(
            "scara-prrr",
            dh("P 0 a1 0", "R 0 a2 0", "R 0 a3 180", "R d4 0 0"),
            TASK,
            title="SCARA arm with its lift first",
        ),
        {
            "lengths": Lengths({"a1": OFFSET, "a2": LINK, "a3": LINK}, ("a2", "a3")),
            "zeros": Zeros({1: SLIDE, 2: FREE, 3: FREE, 4: FREE}),
            "senses": senses((1, 3), (2, 3)),
            "base": raise_base,
            "tool": place_point,
        },
    ),
)  # fmt: skip
