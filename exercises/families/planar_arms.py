"""Planar arms with slides, the planar 3R for its pose, and the pan-tilt head; PR and PRR work in a vertical plane."""

from qdot.exercises.arm.chain import Chain
from qdot.exercises.families.axes import (
    FREE,
    HEIGHTS,
    LINK,
    OFFSET,
    SLIDE,
    Beside,
    Lengths,
    Zeros,
    both_ways,
    displace_base,
    hang_base,
    place_point,
    raise_base,
    senses,
    stand_upright,
)  # fmt: skip
from qdot.exercises.families.base import Family, dh

LYING, STANDING = ("vx", "vy", "wz"), ("vx", "vz", "wy")
BOTH_WAYS = both_ways(SLIDE)

PLANAR_ARMS = (
    Family(
        "planar-pr", "Planar PR arm (slide, link)", "equations 6.1 to 6.3",
        Chain(
            "planar-pr", dh("P 0 a1 90", "R 0 a2 0"), ("vx", "vz"), title="planar PR arm in a vertical plane"
        ),
        {
            "lengths": Lengths({"a1": OFFSET, "a2": LINK}, ("a1", "a2")),
            "zeros": Zeros({1: BOTH_WAYS, 2: FREE}),
            "senses": senses((1,)),
            "base": raise_base,
            "tool": Beside((10, 15, 20, 25, 30)),
        },
    ),
    Family(
        "planar-rpr", "Planar RPR arm for its pose", "equations 6.9 to 6.12",
        Chain("planar-rpr", dh("R 0 a1 90", "P 0 0 -90", "R 0 a3 0"), LYING, title="planar RPR arm"),
        {
            "lengths": Lengths({"a1": OFFSET, "a3": LINK}, ("a3",)),
            "zeros": Zeros({1: FREE, 2: BOTH_WAYS, 3: FREE}),
            "senses": senses((2,)),
            "base": displace_base,
            "tool": place_point,
            "task": stand_upright,
        },
    ),
    Family(
        "planar-rrp", "Planar RRP arm for its pose", "equations 6.9 to 6.12",
        Chain("planar-rrp", dh("R 0 a1 0", "R 0 a2 90", "P 0 0 0"), LYING, title="planar RRP arm"),
        {
            "lengths": Lengths({"a1": LINK, "a2": LINK}, ("a2",)),
            "zeros": Zeros({1: FREE, 2: FREE}),
            "senses": senses((1,), (2,)),
            "base": displace_base,
            "tool": place_point,
            "task": stand_upright,
        },
    ),
    Family(
        "planar-prr", "Planar PRR arm for its pose", "equations 6.1 to 6.3",
        Chain(
            "planar-prr", dh("P 0 a1 90", "R 0 a2 0", "R 0 a3 0"), STANDING, title="planar PRR arm in a vertical plane"
        ),
        {
            "lengths": Lengths({"a1": OFFSET, "a2": LINK, "a3": LINK}, ("a2", "a3")),
            "zeros": Zeros({1: BOTH_WAYS, 2: FREE, 3: FREE}),
            "senses": senses((1,)),
            "base": raise_base,
            "tool": place_point,
        },
    ),
    Family(
        "planar-3r-pose", "Planar 3R arm for its pose", "equations 6.1 to 6.3",
        Chain("planar-3r-pose", dh("R 0 a1 0", "R 0 a2 0", "R 0 a3 0"), LYING, title="planar 3R arm"),
        {
            "lengths": Lengths({"a1": LINK, "a2": LINK, "a3": LINK}, ("a1", "a2", "a3")),
            "zeros": Zeros({1: FREE, 2: FREE, 3: FREE}),
            "senses": senses((1,), (2,)),
            "base": displace_base,
            "tool": place_point,
            "task": stand_upright,
        },
    ),
    Family(
        "pan-tilt", "Pan-tilt head", "equation 6.3 with m > n",
        Chain("pan-tilt", dh("R d1 0 90", "R 0 a2 0"), ("vx", "vy", "vz"), title="pan-tilt head"),
        {
            "lengths": Lengths({"d1": HEIGHTS, "a2": LINK}, ("d1",)),
            "zeros": Zeros({1: FREE, 2: FREE}),
            "senses": senses((1,)),
            "base": hang_base,
            "tool": place_point,
        },
    ),
)  # fmt: skip
