"""planar-3r: three parallel revolute joints for a point in the plane: J is 2 x 3, so there is no determinant.

The arm is singular where all three links lie on one line: two conditions that hold together.
"""

from qdot.exercises.arm.chain import Chain
from qdot.exercises.families.axes import FREE, LINK, Lengths, Zeros, displace_base, place_point, senses, stand_upright
from qdot.exercises.families.base import Family, dh

PLANAR_3R = Family(
    "planar-3r", "Planar 3R arm (redundant for a point)", "equation 6.3 with m < n",
    Chain("planar-3r", dh("R 0 a1 0", "R 0 a2 0", "R 0 a3 0"), ("vx", "vy"), title="planar 3R arm"),
    {
        "lengths": Lengths({"a1": LINK, "a2": LINK, "a3": LINK}, ("a1", "a2", "a3")),
        "zeros": Zeros({1: FREE, 2: FREE, 3: FREE}),
        "senses": senses((1,), (2,)),
        "base": displace_base,
        "tool": place_point,
        "task": stand_upright,
    },
)  # fmt: skip
