"""The whole Scorbot of Example 6.3, five revolute joints: for its wrist point P and for its tip Q, all six rows."""

from qdot.exercises.arm.chain import TASK_ROWS, Chain, Point
from qdot.exercises.families.axes import (
    FREE,
    LINK,
    OR_NONE,
    Frames,
    Lengths,
    Zeros,
    place_point,
    raise_base,
    senses,
)  # fmt: skip
from qdot.exercises.families.base import Axis, Family, dh

TABLE = dh("R d1 a1 -90", "R 0 a2 0", "R 0 a3 0", "R 0 0 -90", "R d5 0 0")


def _axes(tool: Axis) -> dict[str, Axis]:
    return {
        # a1 < a2 + a3, so that the shoulder's singularity exists
        "lengths": Lengths({"a1": (5, 10), "a2": LINK, "a3": LINK, "d5": (15, 20, 25)}, ("a2", "a3")),
        "zeros": Zeros({1: FREE, 2: OR_NONE, 3: OR_NONE, 4: OR_NONE}),
        "senses": senses((1,), (4,)),
        "base": raise_base,
        "tool": tool,
    }


SCORBOT = (
    Family(
        "scorbot-wrist", "Scorbot 5R at the wrist point", "Example 6.3",
        Chain("scorbot-wrist", TABLE, TASK_ROWS, tool=Point(4), title="Scorbot arm up to its wrist"),
        _axes(Frames((3, 4))),
    ),
    Family(
        "scorbot-tip", "Scorbot 5R at the tip", "Example 6.3",
        Chain("scorbot-tip", TABLE, TASK_ROWS, title="Scorbot arm up to its tip"),
        _axes(place_point),
    ),
)  # fmt: skip
