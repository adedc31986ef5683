"""Arms of six joints and one of seven; those with a spherical wrist are asked for their wrist centre.

At the wrist centre J is block triangular, det J = det J11 det J22, and does not depend on the tool.
"""

from dataclasses import replace

import sympy as sp

from exercises.arm.chain import TASK_ROWS, Chain, Joint, Point
from exercises.families.base import Family, centimetres, on_the_floor, sign, turned
from exercises.stream import Stream

RIGHT = sp.pi / 2
LinkLengths = tuple[sp.Expr, sp.Expr, sp.Expr]


def _arm(name: str, rng: Stream, rows: tuple[LinkLengths, ...], offsets: dict[int, sp.Expr], title: str) -> Chain:
    """Return an arm of revolute joints with rows (d, a, alpha) and offsets of some joints."""
    theta = sp.symbols(f"theta1:{len(rows) + 1}")
    joints = tuple(
        Joint("R", q + offsets.get(i, sp.S.Zero), d, a, alpha)
        for i, (q, (d, a, alpha)) in enumerate(zip(theta, rows, strict=True), 1)
    )
    return Chain(name, joints, TASK_ROWS, on_the_floor(rng), _wrist_centre(rng, joints), title)


def _wrist_centre(rng: Stream, joints: tuple[Joint, ...]) -> Point:
    """Return the point where the last three axes meet, as the origin of either frame that stands there."""
    return Point(len(joints) - rng.choice((1, 2)))


def _spherical_wrist(rng: Stream, side: int) -> tuple[LinkLengths, LinkLengths, LinkLengths]:
    """Return rows 4, 5 and 6 of a wrist on a forearm d4, the axis of joint 4 running along the forearm."""
    return (
        (centimetres(rng, 35, 70), sp.S.Zero, side * RIGHT),
        (sp.S.Zero, sp.S.Zero, -side * RIGHT),
        (sp.Symbol("d6"), sp.S.Zero, sp.S.Zero),
    )


def _shoulder_offsets(rng: Stream) -> dict[int, sp.Expr]:
    return {1: turned(rng, 30), 2: turned(rng, 90), 3: turned(rng, 90)}


def sample_stanford(rng: Stream) -> Chain:
    """Draw a Stanford arm: lateral offset, zero of the slide, joint offsets, senses of the axes."""
    side, bent = sign(rng), sign(rng)
    theta, d3 = sp.symbols("theta1:7"), sp.Symbol("d3")
    joints = (
        Joint("R", theta[0] + turned(rng, 30), sp.Symbol("d1"), 0, -side * RIGHT),
        Joint("R", theta[1] + turned(rng, 15), centimetres(rng, 10, 40), 0, side * RIGHT),
        Joint("P", 0, d3 + sign(rng) * centimetres(rng, 10, 95), 0, 0),
        Joint("R", theta[3], 0, 0, -bent * RIGHT),
        Joint("R", theta[4] + turned(rng, 90), 0, 0, bent * RIGHT),
        Joint("R", theta[5], sp.Symbol("d6"), 0, 0),
    )
    return Chain("stanford-6r", joints, TASK_ROWS, on_the_floor(rng), _wrist_centre(rng, joints), "Stanford arm")


def sample_puma(rng: Stream) -> Chain:
    """Draw a PUMA 560: lengths, lateral offset d3, joint offsets, sense of the wrist."""
    side = sign(rng)
    rows = (
        (sp.Symbol("d1"), sp.S.Zero, RIGHT),
        (sp.S.Zero, sp.Symbol("a2"), sp.S.Zero),
        (centimetres(rng, 13, 25), centimetres(rng, 2, 8), -RIGHT),
        *_spherical_wrist(rng, side),
    )
    return _arm("puma-560", rng, rows, _shoulder_offsets(rng), "PUMA 560 arm")


def sample_anthropomorphic(rng: Stream) -> Chain:
    """Draw an elbow arm with a spherical wrist: lengths, joint offsets, senses of the axes."""
    side, bent = sign(rng), sign(rng)
    rows = (
        (sp.Symbol("d1"), sp.S.Zero, side * RIGHT),
        (sp.S.Zero, sp.Symbol("a2"), sp.S.Zero),
        (sp.S.Zero, sp.S.Zero, side * RIGHT),
        *_spherical_wrist(rng, bent),
    )
    return _arm("anthropomorphic-6r", rng, rows, _shoulder_offsets(rng), "anthropomorphic arm with a spherical wrist")


def sample_industrial(rng: Stream) -> Chain:
    """Draw an industrial arm: shoulder offset a1 < a2, upper arm, elbow offset a3, forearm, joint offsets."""
    side = sign(rng)
    rows = (
        (sp.Symbol("d1"), centimetres(rng, 5, 30), -RIGHT),
        (sp.S.Zero, centimetres(rng, 75, 95), sp.S.Zero),
        (sp.S.Zero, sp.Symbol("a3"), -RIGHT),
        *_spherical_wrist(rng, side),
    )
    return _arm("industrial-6r", rng, rows, _shoulder_offsets(rng), "industrial arm with offsets")


def sample_ur(rng: Stream) -> Chain:
    """Draw an arm of the UR kind, whose last three axes do not meet: lengths, joint offsets, senses, the point."""
    side = sign(rng)
    rows = (
        (sp.Symbol("d1"), sp.S.Zero, RIGHT),
        (sp.S.Zero, centimetres(rng, 50, 80), sp.S.Zero),
        (sp.S.Zero, sp.Symbol("a3"), sp.S.Zero),
        (centimetres(rng, 15, 25), sp.S.Zero, side * RIGHT),
        (centimetres(rng, 5, 10), sp.S.Zero, -side * RIGHT),
        (sp.S.Zero, sp.S.Zero, sp.S.Zero),
    )
    offsets = {**_shoulder_offsets(rng), 4: turned(rng, 90)}
    last = Point(6 - rng.below(2))  # O_5 and O_6 are one place; a tool beyond it would add terms to every entry
    return replace(_arm("ur-6r", rng, rows, offsets, "arm of the UR kind"), tool=last)


def sample_lbr(rng: Stream) -> Chain:
    """Draw an arm of the LBR kind, redundant by one joint: lengths, joint offsets, senses of the axes."""
    zero = sp.S.Zero
    shoulder, elbow = sign(rng) * RIGHT, sign(rng) * RIGHT
    rows = (
        (sp.Symbol("d1"), zero, shoulder),
        (zero, zero, -shoulder),
        (centimetres(rng, 35, 50), zero, elbow),
        (zero, zero, -elbow),
        (sp.Symbol("d5"), zero, shoulder),
        (zero, zero, -shoulder),
        (centimetres(rng, 8, 25), zero, zero),
    )
    offsets = {1: turned(rng, 30), 2: turned(rng, 90), 3: turned(rng, 90), 4: turned(rng, 90)}
    return _arm("lbr-7r", rng, rows, offsets, "arm of the LBR kind with seven joints")


SIX_JOINTS = (
    Family("stanford-6r", "Stanford arm", "equations 6.9 to 6.12", sample_stanford),
    Family("puma-560", "PUMA 560", "equations 6.9 to 6.12", sample_puma),
    Family("anthropomorphic-6r", "Elbow arm with spherical wrist", "Example 6.3 with a wrist", sample_anthropomorphic),
    Family("industrial-6r", "Industrial 6R arm with offsets", "equations 6.9 to 6.12", sample_industrial),
    Family("ur-6r", "Arm of the UR kind (6R)", "equations 6.9 to 6.12", sample_ur),
    Family("lbr-7r", "Arm of the LBR kind (7R, redundant)", "equation 6.3 with m < n", sample_lbr),
)
