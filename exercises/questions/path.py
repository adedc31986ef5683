"""Joint rates along a straight path at a prescribed speed, and where a rate exceeds its limit (the welding robot).

The arm starts in a given configuration, from which A follows; P moves on the line from A towards B (given in cm) at
constant speed v: p(s) = A + s u, u = (B - A)/|B - A|, and qd = J^-1 u v (6.7) with the joints that put P at p(s).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from qdot.exercises.answers import Number
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.mpmath_kinematics import (
    DOUBLE,
    PRECISE,
    PreciseArm,
    Vector,
    determinant,
    four_digits,
    round_matrix,
    ten_digits,
)
from qdot.exercises.arm.path import Line, Station
from qdot.exercises.arm.singularity import singular_set
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details, by_name
from qdot.exercises.questions.base import Asked, Question, joint_rates, objection_unless_square
from qdot.exercises.questions.inversion import (
    OF_RATES,
    THREE_DIGITS,
    Configuration,
    conditioning,
    sample_lengths,
    sample_pose,
)
from qdot.exercises.questions.redundancy import objection_to_open_angles

STEP = 0.02
"""Distance of the places at which a line is looked at (m)."""

REGULAR, LESS_REGULAR, CLOSE = 0.15, 0.05, 0.03
"""Least sigma_min/sigma_max along a line that is to be regular; of an arm whose links differ so much that it has no
such line; and along a line that leads to a singularity."""

TRIES = 1000
"""Lines that are sampled before a less regular one is good enough."""


@dataclass(frozen=True)
class Seam(Configuration):
    """A welding line: the configuration at A, the target B by axis (m), and the speed (m/s)."""

    target: dict[str, sp.Rational]
    speed: sp.Rational

    def line(self, chain: Chain, context: Any = DOUBLE) -> Line:
        """Return the line in numbers of an arithmetic."""
        return Line(chain, self.lengths, self.joints, tuple(self.target.values()), context)

    def joints_on(self, chain: Chain, s: sp.Expr) -> Vector:
        """Return the joint values at the distance s from A, on the branch on which the arm starts."""
        end, line = float(s), self.line(chain, PRECISE)
        *_, last = self.line(chain).follow(end / max(1, round(end / STEP)) if end else 1.0, 1e-3, end)
        q = line.joints_at(line.arm.number(s), [PRECISE.mpf(value) for value in last.joints])
        assert q is not None
        return q

    def at(self, chain: Chain, s: sp.Expr) -> "Place":
        """Return the worked numbers at the distance s from A, four digits; angles in degrees, as in the prompt."""
        line, q = self.line(chain, PRECISE), self.joints_on(chain, sp.sympify(s))
        distance, jacobian = line.arm.number(sp.sympify(s)), line.arm.task_jacobian(q)
        sigma = PRECISE.svd_r(PRECISE.matrix(jacobian), compute_uv=False)
        return Place(
            sp.Float(PRECISE.nstr(distance, 5), 10),
            _round(line.point(distance)),
            _round([PRECISE.degrees(v) if joint.kind == "R" else v for v, joint in zip(q, chain.joints, strict=True)]),
            round_matrix(jacobian),
            four_digits(determinant(jacobian)),
            _round([slope * line.arm.number(self.speed) for slope in line.slopes(q)]),
            four_digits(min(sigma) / max(sigma)),
        )

    def start(self, chain: Chain) -> sp.Matrix:
        """Return A, four digits."""
        return _round(self.line(chain, PRECISE).start)

    def unit(self, chain: Chain) -> sp.Matrix:
        """Return the unit vector from A to B, four digits."""
        return _round(self.line(chain, PRECISE).unit)

    def length(self, chain: Chain) -> sp.Float:
        """Return the distance from A to B, four digits."""
        return four_digits(self.line(chain, PRECISE).length)

    def table(self, chain: Chain, end: sp.Expr) -> "list[Place]":
        """Return the worked numbers at five places from A to the distance `end`, closer together towards it."""
        places = [sp.Rational(int(share * end), 100) for share in (0, 40, 70, 90)]
        return [self.at(chain, s) for s in (*places, end)]


@dataclass(frozen=True)
class Place:
    """A place on a seam in numbers of four digits (s has five); `conditioning` is sigma_min/sigma_max of J."""

    s: sp.Float
    point: sp.Matrix
    joints: sp.Matrix
    jacobian: sp.Matrix
    determinant: sp.Float
    rates: sp.Matrix
    conditioning: sp.Float


def _round(values: Vector) -> sp.Matrix:
    return round_matrix([[value] for value in values])


@dataclass(frozen=True, kw_only=True)
class OnPath(Details):
    """Asked on a welding line."""

    seam: Seam

    def shown_values(self, chain: Chain) -> dict[str, float]:
        """Return the lengths, and the joint values at the beginning of the line."""
        return {**by_name(self.seam.lengths), **(self.pose or {})}


# --- joint rates at a place ---


@dataclass(frozen=True, kw_only=True)
class AtDistance(OnPath):
    """Asked on a welding line, at a distance from A (m)."""

    distance: sp.Rational

    def given_values(self, chain: Chain) -> dict[str, float]:
        """Return the lengths, the joint values at the distance, and the velocity along the line."""
        seam, line = self.seam, self.seam.line(chain, PRECISE)
        joints = seam.joints_on(chain, self.distance)
        values = {symbol.name: float(value) for symbol, value in seam.lengths.items()}
        values |= {q.name: float(value) for q, value in zip(chain.q, joints, strict=True)}
        return values | {row: float(u) * float(seam.speed) for row, u in zip(chain.task, line.unit, strict=True)}


def _object_to_path(chain: Chain) -> str | None:
    if len(chain.linear_rows) != len(chain.task):
        return f"its task counts {', '.join(chain.task)}, and a path of the point tells linear velocities only"
    if not 2 <= chain.n <= 3:
        return f"it has {chain.n} joints; a path is asked of two or three"
    if refused := objection_unless_square(chain) or objection_to_open_angles(chain):
        return refused
    if singular_set(chain) == () and all(joint.kind == "P" for joint in chain.joints):
        return "its Jacobian is the same everywhere, and so are the rates on a line"
    return None


def _ask_path_rates(chain: Chain, rng: Stream) -> Asked | None:
    for attempt in range(2 * TRIES):
        regular, least, most = (REGULAR, 25, 60) if attempt < TRIES else (LESS_REGULAR, 15, 40)
        seam = _sample_seam(chain, rng, least, most, 1.3 * regular)
        if seam is None:
            continue
        line = seam.line(chain)
        stations = list(line.follow(STEP, regular))
        if stations[-1:] and stations[-1].s > float(line.length) - STEP:
            last = int(20 * float(line.length)) - 1  # in steps of 5 cm
            return _ask_rates_at(chain, seam, sp.Rational(5 * rng.integer(min(3, last), last), 100))
    return None


def _ask_rates_at(chain: Chain, seam: Seam, s: sp.Rational) -> Asked:
    line = seam.line(chain, PRECISE)
    rates = [slope * line.arm.number(seam.speed) for slope in line.slopes(seam.joints_on(chain, s))]
    units = tuple("rad/s" if joint.kind == "R" else "m/s" for joint in chain.joints)
    floor = 0.001 * float(max(map(abs, rates)))
    details = AtDistance(seam=seam, distance=s, pose=seam.figure)
    return Number(sp.Matrix(list(map(ten_digits, rates))), units, THREE_DIGITS, floor), details


def _sample_seam(chain: Chain, rng: Stream, least: int, most: int, regular: float) -> Seam | None:
    """Sample a line whose ends are `least` to `most` cm apart from a configuration as regular as that, or None."""
    lengths, joints = sample_lengths(chain, rng), sample_pose(chain, rng)
    way = [rng.integer(-most, most) for _ in chain.task]
    speed = sp.Rational(rng.integer(2, 8), 40)
    if not least**2 <= sum(k * k for k in way) <= most**2 or conditioning(chain, lengths, joints) < regular:
        return None
    return Seam(lengths, joints, _place_target(chain, lengths, joints, way), speed)


def _place_target(
    chain: Chain, lengths: dict[sp.Symbol, sp.Rational], joints: dict[sp.Symbol, sp.Expr], way: Sequence[int]
) -> dict[str, sp.Rational]:
    """Return a point in whole centimetres that is `way` (cm) from where P is, as nearly as can be."""
    arm = PreciseArm(chain, lengths)
    point = arm.place([arm.number(joints[q]) for q in chain.q])[0]
    start = [sp.Float(PRECISE.nstr(point[row], 28), 28) for row in arm.task]
    axes = zip(chain.linear_rows, start, way, strict=True)
    return {axis: sp.Rational(_round_half_up(100 * value) + k, 100) for axis, value, k in axes}


def _round_half_up(value: sp.Expr) -> int:
    """Return the nearest whole number, the upper one of two that are as near."""
    return int(sp.floor(value + sp.Rational(500_000_001, 10**9)))


# --- where a rate exceeds its limit ---


@dataclass(frozen=True, kw_only=True)
class ToLimit(OnPath):
    """About the distance on a welding line at which the speed of a joint (from 1) exceeds its limit."""

    joint: int
    limit: sp.Rational


@dataclass(frozen=True)
class Crossing:
    """A joint (its index), its limit, and the stations between which its speed exceeds it for the first time."""

    joint: int
    limit: sp.Rational
    before: Station
    after: Station


def _object_to_limit(chain: Chain) -> str | None:
    refused = _object_to_path(chain)
    return refused if refused else None if singular_set(chain) else "it has no singular configuration to come near to"


def _ask_path_limit(chain: Chain, rng: Stream) -> Asked | None:
    for attempt in range(2 * TRIES):
        seam = _sample_seam_to_singularity(chain, rng, REGULAR if attempt < TRIES else LESS_REGULAR)
        if seam is None:
            continue
        stations = list(seam.line(chain).follow(STEP, CLOSE))
        crossings = list(_find_crossings(stations, float(seam.speed)))
        if crossings:
            crossing = rng.choice(crossings)
            s = ten_digits(_locate_crossing(chain, seam, crossing))
            pose = seam.figure
            details = ToLimit(seam=seam, joint=crossing.joint + 1, limit=crossing.limit, pose=pose)
            return Number(sp.Matrix([s]), ("m",), THREE_DIGITS, 1e-6), details
    return None


def _sample_seam_to_singularity(chain: Chain, rng: Stream, regular: float) -> Seam | None:
    """Sample a line that may come near a singular configuration: past the place of one, or far out of reach."""
    solved = [component for component in singular_set(chain) or () if component.solutions is not None]
    if not solved or rng.below(4) == 0:
        return _sample_seam(chain, rng, 40, 120, 1.3 * regular)
    lengths, joints = sample_lengths(chain, rng), sample_pose(chain, rng)
    singular, solutions = dict(joints), rng.choice(solved).solutions or ()
    for q, values in solutions:
        singular[q] = rng.choice(values).xreplace(lengths)
    if not all(value.is_real for value in singular.values()):
        return None
    for q in (q for q, joint in zip(chain.q, chain.joints, strict=True) if joint.kind == "R"):
        least = 7 if q in dict(solutions) else 0
        turn = rng.choice((-1, 1)) * rng.integer(least, least + 10)
        steps = _round_half_up(sp.N(singular[q] * 36 / sp.pi, 30)) + turn
        joints[q] = sp.pi * sp.Rational((5 * steps + 179) % 360 - 179, 180)
    if conditioning(chain, lengths, joints) < regular:
        return None
    past = [rng.choice((-1, 1)) * rng.integer(1, 6) for _ in chain.task]
    target = _place_target(chain, lengths, singular, past)
    return Seam(lengths, joints, target, sp.Rational(rng.integer(2, 8), 40))


def _find_crossings(stations: Sequence[Station], speed: float) -> list[Crossing]:
    """Return where a joint's speed clearly exceeds a round limit for the first time, growing towards a singularity."""
    crossings = []
    for joint in range(len(stations[0].slopes) if stations else 0):
        speeds = [abs(station.slopes[joint]) * speed for station in stations]
        for tenths in range(3, 31):
            k = next((i for i, value in enumerate(speeds) if value > tenths / 10), len(speeds))
            if _is_clear(stations, speeds, k, tenths / 10):
                crossings.append(Crossing(joint, sp.Rational(tenths, 10), stations[k - 1], stations[k]))
    return crossings


def _is_clear(stations: Sequence[Station], speeds: Sequence[float], k: int, limit: float) -> bool:
    """Tell whether the limit is exceeded between stations k - 1 and k as it should be.

    The speed has grown from less than half of it, keeps growing, was well below it long before, and grows so fast that
    three digits of the rate give three digits of s; J has come nearer to losing rank.
    """
    if not 5 <= k < len(speeds) - 1 or limit < 2.5 * speeds[0]:
        return False
    s = stations[k].s
    growing = speeds[k - 2] < speeds[k - 1] < speeds[k] < speeds[k + 1]
    steep = s * (speeds[k] - speeds[k - 1]) > 2.0 * STEP * limit
    long_before = max(value for station, value in zip(stations, speeds, strict=True) if station.s <= 0.9 * s)
    return (
        growing and steep and long_before < 0.95 * limit and stations[k].conditioning < 0.5 * stations[0].conditioning
    )


def _locate_crossing(chain: Chain, seam: Seam, crossing: Crossing) -> Any:
    """Return the distance at which the joint's speed is its limit, to 30 digits: first by floats, then from there."""
    before = crossing.before
    rough, near = _solve(seam, seam.line(chain), crossing, (before.s, crossing.after.s), before.joints)
    s, _ = _solve(seam, seam.line(chain, PRECISE), crossing, (rough - 1e-9, rough + 1e-9), near)
    return s


def _solve(
    seam: Seam, line: Line, crossing: Crossing, ends: tuple[float, float], near: Sequence[float]
) -> tuple[Any, Vector]:
    """Return s near `ends` at which |rate| = limit, and the joint values there, by the secant rule."""
    context = line.context
    speed, limit = line.arm.number(seam.speed), line.arm.number(crossing.limit)
    q: Vector = [context.mpf(value) for value in near]

    def excess(s: Any) -> Any:
        nonlocal q
        joints = line.joints_at(s, q)
        assert joints is not None
        q = joints
        return abs(line.slopes(q)[crossing.joint]) * speed - limit

    return context.findroot(excess, [context.mpf(end) for end in ends]), q


QUESTIONS = (
    Question(
        "path-rates", "Joint rates along a path", "6.7 on a welding path", points=2.0, needs=("inverse-velocity",),
        stage="rates", sample=_ask_path_rates, labels=joint_rates, objection=_object_to_path,
        is_made_of_jacobian=True, follows_from=OF_RATES,
    ),
    Question(
        "path-limit", "Where a joint rate exceeds its limit", "6.7 near a singularity", points=2.0,
        needs=("path-rates",), sample=_ask_path_limit, entry_names=lambda chain, _: ["s"], objection=_object_to_limit,
        follows_from=(),
    ),
)  # fmt: skip
