"""elbow-3r: Example 6.3, the arm of a Scorbot with a shoulder offset, down to the wrist point P.

Lengths that are given let the shoulder singularity exist (a1 < a2 + a3).
"""

from qdot.exercises.arm.chain import Chain
from qdot.exercises.families.axes import FREE, LINK, OFFSET, OR_NONE, Lengths, Zeros, mount_base, place_point, senses
from qdot.exercises.families.base import Family, dh

ELBOW_3R = Family(
    "elbow-3r", "Elbow arm with shoulder offset (Scorbot)", "Example 6.3",
    Chain(
        "elbow-3r", dh("R d1 a1 -90", "R 0 a2 0", "R 0 a3 0"), ("vx", "vy", "vz"),
        title="elbow arm with a shoulder offset",
    ),
    {
        "lengths": Lengths({"a1": OFFSET, "a2": LINK, "a3": LINK}, ("a2", "a3")),
        "zeros": Zeros({1: FREE, 2: OR_NONE, 3: OR_NONE}),
        "senses": senses((1,)),
        "base": mount_base,
        "tool": place_point,
    },
)  # fmt: skip
