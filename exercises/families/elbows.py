"""Elbow arms beside that of Example 6.3: plain, with lateral shoulder offset, and the orthogonal 3R."""

from qdot.exercises.arm.chain import Chain
from qdot.exercises.families.axes import (
    FREE,
    LINK,
    OR_NONE,
    Centimetres,
    Lengths,
    LengthsTogether,
    Zeros,
    hang_base,
    place_point,
    senses,
)  # fmt: skip
from qdot.exercises.families.base import Axis, Family, dh

SPACE = ("vx", "vy", "vz")
SHOULDER: Centimetres = (10, 15, 20, 25)


def _axes(lengths: Axis, elbow: tuple[int, ...], *twists: tuple[int, ...]) -> dict[str, Axis]:
    return {
        "lengths": lengths,
        "zeros": Zeros({1: FREE, 2: OR_NONE, 3: elbow}),
        "senses": senses(*twists),
        "base": hang_base,
        "tool": place_point,
    }


ELBOWS = (
    Family(
        "elbow", "Elbow arm", "Example 6.3 with a1 = 0",
        Chain("elbow", dh("R d1 0 90", "R 0 a2 0", "R 0 a3 0"), SPACE, title="elbow arm"),
        _axes(Lengths({"a2": LINK, "a3": LINK}, ("a2", "a3")), FREE, (1,)),
    ),
    Family(
        "elbow-lateral", "Elbow arm with lateral shoulder offset", "Example 6.3 with d2",
        Chain(
            "elbow-lateral", dh("R d1 0 90", "R d2 a2 0", "R 0 a3 0"), SPACE,
            title="elbow arm with a lateral shoulder offset",
        ),
        _axes(Lengths({"d2": SHOULDER, "a2": LINK, "a3": LINK}, ("a2", "a3")), FREE, (1,)),
    ),
    Family(
        "orthogonal-3r", "Orthogonal 3R arm", "equations 6.1 to 6.3",
        Chain("orthogonal-3r", dh("R 0 a1 90", "R 0 a2 -90", "R 0 a3 0"), SPACE, title="orthogonal 3R arm"),
        # singular where cos(theta3) = -a2/a3, among others: a1 : a2 : a3 = 1 : 2 : 4 makes that 120 degrees
        _axes(LengthsTogether(("a1", "a2", "a3"), [(k, 2 * k, 4 * k) for k in (10, 15, 20, 25)]), OR_NONE, (1, 2)),
    ),
)  # fmt: skip
