"""Questions on a welding robot: joint rates along a straight line at a given speed, and where a rate exceeds its limit.

A is the position of P in a given initial configuration. P moves on the line from A towards B (given in cm) at constant
speed v. Its position is p(s) = A + s u with u = (B - A)/|B - A|. The joint rates are qd = J^-1 u v (6.7), at the
configuration with P at p(s).
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
"""Distance between the points at which a line is examined (m)."""

REGULAR, LESS_REGULAR, CLOSE = 0.15, 0.05, 0.03
"""Minimum sigma_min/sigma_max: along a regular line, along one of an arm with very different links, which has no better
lines, and along a line to a singularity."""

TRIES = 1000
"""Number of lines to sample before a less regular one is accepted."""


@dataclass(frozen=True)
class Seam(Configuration):
    """A welding line: the configuration at A, the coordinates of the target B (m) by axis, and the speed (m/s)."""

    target: dict[str, sp.Rational]
    speed: sp.Rational

    def line(self, chain: Chain, context: Any = DOUBLE) -> Line:
        """Return the numeric line in an arithmetic, by default in floating point."""
        return Line(chain, self.lengths, self.joints, tuple(self.target.values()), context)

    def joints_on(self, chain: Chain, s: sp.Expr) -> Vector:
        """Return the joint values at the distance s from A, on the solution branch of the initial configuration."""
        end, line = float(s), self.line(chain, PRECISE)
        *_, last_station = self.line(chain).follow(end / max(1, round(end / STEP)) if end else 1.0, 1e-3, end)
        q = line.joints_at(line.arm.number(s), [PRECISE.mpf(value) for value in last_station.joints])
        assert q is not None
        return q

    def at(self, chain: Chain, s: sp.Expr) -> "Place":
        """Return the intermediate results at the distance s from A, to four digits, with angles in degrees."""
        line, q = self.line(chain, PRECISE), self.joints_on(chain, sp.sympify(s))
        distance, jacobian = line.arm.number(sp.sympify(s)), line.arm.task_jacobian(q)
        sigma = PRECISE.svd_r(PRECISE.matrix(jacobian), compute_uv=False)
        return Place(
            sp.Float(PRECISE.nstr(distance, 5), 10),
            _round(line.point(distance)),
            _round([PRECISE.degrees(v) if joint.kind == "R" else v for v, joint in zip(q, chain.joints, strict=True)]),
            round_matrix(jacobian),
            four_digits(determinant(jacobian)),
            _round([rate_per_speed * line.arm.number(self.speed) for rate_per_speed in line.slopes(q)]),
            four_digits(min(sigma) / max(sigma)),
        )

    def start(self, chain: Chain) -> sp.Matrix:
        """Return A, to four digits."""
        return _round(self.line(chain, PRECISE).start)

    def unit(self, chain: Chain) -> sp.Matrix:
        """Return the unit vector from A to B, to four digits."""
        return _round(self.line(chain, PRECISE).unit)

    def length(self, chain: Chain) -> sp.Float:
        """Return the distance from A to B, to four digits."""
        return four_digits(self.line(chain, PRECISE).length)

    def table(self, chain: Chain, end: sp.Expr) -> "list[Place]":
        """Return the intermediate results at five points between A and the distance `end`, denser towards the end."""
        distances = [sp.Rational(int(share * end), 100) for share in (0, 40, 70, 90)]
        return [self.at(chain, s) for s in (*distances, end)]


@dataclass(frozen=True)
class Place:
    """The results at one point of a seam, to four digits (s has five); `conditioning` is sigma_min/sigma_max of J."""

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
    """Details of a question about a welding line."""

    seam: Seam

    def shown_values(self, chain: Chain) -> dict[str, float]:
        """Return the lengths, and the joint values at the start of the line."""
        return {**by_name(self.seam.lengths), **(self.pose or {})}


# --- joint rates at a point of the line ---


@dataclass(frozen=True, kw_only=True)
class AtDistance(OnPath):
    """Details of a question about a point of a welding line, at a distance from A (m)."""

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
    if objection := objection_unless_square(chain) or objection_to_open_angles(chain):
        return objection
    if singular_set(chain) == () and all(joint.kind == "P" for joint in chain.joints):
        return "its Jacobian is the same everywhere, and so are the rates on a line"
    return None


def _ask_path_rates(chain: Chain, rng: Stream) -> Asked | None:
    for attempt in range(2 * TRIES):
        min_conditioning, min_length, max_length = (REGULAR, 25, 60) if attempt < TRIES else (LESS_REGULAR, 15, 40)
        seam = _sample_seam(chain, rng, min_length, max_length, 1.3 * min_conditioning)
        if seam is None:
            continue
        line = seam.line(chain)
        stations = list(line.follow(STEP, min_conditioning))
        if stations[-1:] and stations[-1].s > float(line.length) - STEP:
            last_step = int(20 * float(line.length)) - 1  # in steps of 5 cm
            return _ask_rates_at(chain, seam, sp.Rational(5 * rng.integer(min(3, last_step), last_step), 100))
    return None


def _ask_rates_at(chain: Chain, seam: Seam, s: sp.Rational) -> Asked:
    line = seam.line(chain, PRECISE)
    rates = [rate_per_speed * line.arm.number(seam.speed) for rate_per_speed in line.slopes(seam.joints_on(chain, s))]
    units = tuple("rad/s" if joint.kind == "R" else "m/s" for joint in chain.joints)
    floor = 0.001 * float(max(map(abs, rates)))
    details = AtDistance(seam=seam, distance=s, pose=seam.figure)
    return Number(sp.Matrix(list(map(ten_digits, rates))), units, THREE_DIGITS, floor), details


def _sample_seam(chain: Chain, rng: Stream, least: int, most: int, regular: float) -> Seam | None:
    """Return a random line of `least` to `most` cm, or None if the sample is unsuitable.

    `regular` is the minimum sigma_min/sigma_max of the initial configuration.
    """
    lengths, joints = sample_lengths(chain, rng), sample_pose(chain, rng)
    displacement = [rng.integer(-most, most) for _ in chain.task]
    speed = sp.Rational(rng.integer(2, 8), 40)
    if not least**2 <= sum(k * k for k in displacement) <= most**2 or conditioning(chain, lengths, joints) < regular:
        return None
    return Seam(lengths, joints, _place_target(chain, lengths, joints, displacement), speed)


def _place_target(
    chain: Chain, lengths: dict[sp.Symbol, sp.Rational], joints: dict[sp.Symbol, sp.Expr], way: Sequence[int]
) -> dict[str, sp.Rational]:
    """Return the point that is displaced from P by `way` (cm), rounded to whole centimetres."""
    arm = PreciseArm(chain, lengths)
    point = arm.place([arm.number(joints[q]) for q in chain.q])[0]
    start = [sp.Float(PRECISE.nstr(point[row], 28), 28) for row in arm.task]
    axes = zip(chain.linear_rows, start, way, strict=True)
    return {axis: sp.Rational(_round_half_up(100 * value) + k, 100) for axis, value, k in axes}


def _round_half_up(value: sp.Expr) -> int:
    """Return the nearest integer; halves are rounded up."""
    return int(sp.floor(value + sp.Rational(500_000_001, 10**9)))


# --- where a rate exceeds its limit ---


@dataclass(frozen=True, kw_only=True)
class ToLimit(OnPath):
    """Details about the distance on a welding line at which the rate of a joint (from 1) exceeds its limit."""

    joint: int
    limit: sp.Rational


@dataclass(frozen=True)
class Crossing:
    """The index of a joint, its rate limit, and the stations between which its rate first exceeds the limit."""

    joint: int
    limit: sp.Rational
    before: Station
    after: Station


def _object_to_limit(chain: Chain) -> str | None:
    objection = _object_to_path(chain)
    return (
        objection if objection else None if singular_set(chain) else "it has no singular configuration to come near to"
    )


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
            figure_values = seam.figure
            details = ToLimit(seam=seam, joint=crossing.joint + 1, limit=crossing.limit, pose=figure_values)
            return Number(sp.Matrix([s]), ("m",), THREE_DIGITS, 1e-6), details
    return None


def _sample_seam_to_singularity(chain: Chain, rng: Stream, regular: float) -> Seam | None:
    """Return a random line that may come near a singular configuration, or None if the sample is unsuitable.

    The line passes close to the position of P at a singular configuration, or it leads far out of reach.
    """
    solved_components = [component for component in singular_set(chain) or () if component.solutions is not None]
    if not solved_components or rng.below(4) == 0:
        return _sample_seam(chain, rng, 40, 120, 1.3 * regular)
    lengths, joints = sample_lengths(chain, rng), sample_pose(chain, rng)
    singular_joints, solutions = dict(joints), rng.choice(solved_components).solutions or ()
    for q, values in solutions:
        singular_joints[q] = rng.choice(values).xreplace(lengths)
    if not all(value.is_real for value in singular_joints.values()):
        return None
    for q in (q for q, joint in zip(chain.q, chain.joints, strict=True) if joint.kind == "R"):
        min_steps = 7 if q in dict(solutions) else 0
        step_offset = rng.choice((-1, 1)) * rng.integer(min_steps, min_steps + 10)
        steps = _round_half_up(sp.N(singular_joints[q] * 36 / sp.pi, 30)) + step_offset
        joints[q] = sp.pi * sp.Rational((5 * steps + 179) % 360 - 179, 180)
    if conditioning(chain, lengths, joints) < regular:
        return None
    displacement = [rng.choice((-1, 1)) * rng.integer(1, 6) for _ in chain.task]
    target = _place_target(chain, lengths, singular_joints, displacement)
    return Seam(lengths, joints, target, sp.Rational(rng.integer(2, 8), 40))


def _find_crossings(stations: Sequence[Station], speed: float) -> list[Crossing]:
    """Return the places at which a joint rate that grows towards a singularity first exceeds a round limit clearly."""
    crossings = []
    for joint in range(len(stations[0].slopes) if stations else 0):
        speeds = [abs(station.slopes[joint]) * speed for station in stations]
        for tenths in range(3, 31):
            k = next((i for i, value in enumerate(speeds) if value > tenths / 10), len(speeds))
            if _is_clear(stations, speeds, k, tenths / 10):
                crossings.append(Crossing(joint, sp.Rational(tenths, 10), stations[k - 1], stations[k]))
    return crossings


def _is_clear(stations: Sequence[Station], speeds: Sequence[float], k: int, limit: float) -> bool:
    """Return whether the limit is clearly exceeded between stations k - 1 and k.

    The rate starts below half of the limit, keeps growing, and stays well below the limit until shortly before station
    k. It grows so fast that three digits of the rate give three digits of s. J is closer to losing rank than at A.
    """
    if not 5 <= k < len(speeds) - 1 or limit < 2.5 * speeds[0]:
        return False
    s = stations[k].s
    is_growing = speeds[k - 2] < speeds[k - 1] < speeds[k] < speeds[k + 1]
    is_steep = s * (speeds[k] - speeds[k - 1]) > 2.0 * STEP * limit
    max_speed_before = max(value for station, value in zip(stations, speeds, strict=True) if station.s <= 0.9 * s)
    return (
        is_growing
        and is_steep
        and max_speed_before < 0.95 * limit
        and stations[k].conditioning < 0.5 * stations[0].conditioning
    )


def _locate_crossing(chain: Chain, seam: Seam, crossing: Crossing) -> Any:
    """Return the distance at which the joint rate equals its limit, to 30 digits.

    First it is solved in floating point, then refined.
    """
    station_before = crossing.before
    approximate_s, approximate_joints = _solve(
        seam, seam.line(chain), crossing, (station_before.s, crossing.after.s), station_before.joints
    )
    s, _ = _solve(
        seam, seam.line(chain, PRECISE), crossing, (approximate_s - 1e-9, approximate_s + 1e-9), approximate_joints
    )
    return s


def _solve(
    seam: Seam, line: Line, crossing: Crossing, ends: tuple[float, float], near: Sequence[float]
) -> tuple[Any, Vector]:
    """Return the distance s with |rate| = limit and the joint values there, by the secant method from `ends`."""
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
