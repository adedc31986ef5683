"""The whole Scorbot of Example 6.3, five revolute joints: for its wrist point P and for its tip Q, all six rows."""

import sympy as sp

from exercises.arm.chain import TASK_ROWS, Chain, Joint, Point
from exercises.families.base import Family, centimetres, on_the_floor, sign, turned, with_point
from exercises.stream import Stream

RIGHT = sp.pi / 2


def _scorbot(rng: Stream, name: str, tip: bool, title: str) -> Chain:
    theta = sp.symbols("theta1:6")
    links: list[sp.Expr] = list(sp.symbols("a2 a3"))
    links[rng.below(2)] = centimetres(rng, 35, 80)
    side, bent = sign(rng), sign(rng)
    table = (
        Joint("R", theta[0] + turned(rng, 30), sp.Symbol("d1"), centimetres(rng, 5, 12), side * RIGHT),
        Joint("R", theta[1] + turned(rng, 90), 0, links[0], 0),
        Joint("R", theta[2] + turned(rng, 90), 0, links[1], 0),
        Joint("R", theta[3] + turned(rng, 90), 0, 0, bent * RIGHT),
        Joint("R", theta[4], centimetres(rng, 17, 28), 0, 0),
    )
    joints, point = with_point(rng, table) if tip else (table, Point(rng.choice((3, 4))))
    return Chain(name, joints, TASK_ROWS, on_the_floor(rng), point, title)


def sample_wrist(rng: Stream) -> Chain:
    """Draw a Scorbot for its wrist point: lengths, with a1 < a2 + a3, joint offsets, base height."""
    return _scorbot(rng, "scorbot-wrist", False, "Scorbot arm, wrist point")


def sample_tip(rng: Stream) -> Chain:
    """Draw a Scorbot for its tip: lengths, with a1 < a2 + a3, joint offsets, base height."""
    return _scorbot(rng, "scorbot-tip", True, "Scorbot arm, tip")


SCORBOT = (
    Family("scorbot-wrist", "Scorbot 5R at the wrist point", "Example 6.3", sample_wrist),
    Family("scorbot-tip", "Scorbot 5R at the tip", "Example 6.3", sample_tip),
)
