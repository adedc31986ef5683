"""planar-2r: the arm of Examples 6.1, 6.2 and 6.4. In full variation its tool is bent off the last link.

A bend h beside a link a2 whose length is given makes even the singular angles the arm's own: det J = a1 (a2 s2 + h c2).
"""

from qdot.exercises.arm.chain import Chain
from qdot.exercises.families.axes import FREE, LINK, Beside, Lengths, Zeros, place_in_plane, senses, stand_upright
from qdot.exercises.families.base import Family, dh

PLANAR_2R = Family(
    "planar-2r", "Planar 2R arm", "Examples 6.1, 6.2 and 6.4",
    Chain("planar-2r", dh("R 0 a1 0", "R 0 a2 0"), ("vx", "vy"), title="planar 2R arm"),
    {
        "lengths": Lengths({"a1": LINK, "a2": LINK}, ("a1", "a2")),
        "zeros": Zeros({1: FREE, 2: FREE}),
        "senses": senses((1,)),
        "base": place_in_plane,
        "tool": Beside((10, 15, 20, 25, 30)),
        "task": stand_upright,
    },
)  # fmt: skip
