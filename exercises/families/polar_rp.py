"""polar-rp: a revolute joint that turns a prismatic one, with a lateral offset of the slide.

det J = -(d2 + e): singular where the slide is drawn in until P is beside joint 1; with a1 = 0 that would be the axis.
"""

from qdot.exercises.arm.chain import Chain
from qdot.exercises.families.axes import (
    FREE,
    OFFSET,
    SLIDE,
    Lengths,
    Zeros,
    both_ways,
    displace_base,
    place_point,
    senses,
    stand_upright,
)  # fmt: skip
from qdot.exercises.families.base import Family, dh

POLAR_RP = Family(
    "polar-rp", "Planar polar arm (revolute, prismatic)", "equations 6.9 to 6.12 with a prismatic joint",
    Chain("polar-rp", dh("R 0 a1 90", "P 0 0 0"), ("vx", "vy"), title="planar polar (RP) arm"),
    {
        "lengths": Lengths({"a1": OFFSET}),
        "zeros": Zeros({1: FREE, 2: both_ways(SLIDE)}),
        "senses": senses((1,)),
        "base": displace_base,
        "tool": place_point,
        "task": stand_upright,
    },
)  # fmt: skip
