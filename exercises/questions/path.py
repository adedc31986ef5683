"""Questions on a welding robot: joint rates along a straight line at a given speed, and where a rate exceeds its limit.

A is the position of P in a given initial configuration. P moves on the line from A towards B (given in cm) at constant
speed v. Its position is p(s) = A + s u with u = (B - A)/|B - A|. The joint rates are qd = J^-1 u v (6.7), at the
configuration with P at p(s).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import sympy as sp

from qdot.exercises.answer_types import Number
from qdot.exercises.arm import mpmath_kinematics as precise
from qdot.exercises.arm.chain import REVOLUTE, Chain
from qdot.exercises.arm.mpmath_kinematics import FLOAT_CONTEXT, PRECISE_CONTEXT, PreciseArm, Vector
from qdot.exercises.arm.path import PathSample, StraightPath
from qdot.exercises.common.errors import count_noun
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details, values_by_name
from qdot.exercises.questions import inversion
from qdot.exercises.questions.base import AnswerAndDetails, Question, name_joint_rates, object_unless_square
from qdot.exercises.questions.inversion import RATE_SOURCES, THREE_DIGIT_TOLERANCE, Configuration
from qdot.exercises.questions.redundancy import object_to_symbolic_angles
from qdot.exercises.singularities.singularity import singular_set

SAMPLE_SPACING = 0.02
"""Distance between the points at which a line is examined (m)."""

REGULAR_CONDITIONING, LESS_REGULAR_CONDITIONING, SINGULAR_CONDITIONING = 0.15, 0.05, 0.03
"""Minimum sigma_min/sigma_max along a line: a regular line, a less regular line, and a line to a singularity.

An arm with links of very different lengths may have only less regular lines."""

PREFERRED_TRIES = 1000
"""Number of lines to sample before a less regular one is accepted."""


@dataclass(frozen=True)
class WeldingLine(Configuration):
    """A welding line: the configuration at A, the coordinates of the target B (m) by axis, and the speed (m/s)."""

    target: dict[str, sp.Rational]
    speed: sp.Rational

    def make_line(self, chain: Chain, context: Any = FLOAT_CONTEXT) -> StraightPath:
        """Return the numeric line in an arithmetic, by default in floating point."""
        return StraightPath(chain, self.lengths, self.joints, tuple(self.target.values()), context)

    def compute_joint_values(self, chain: Chain, s: sp.Expr) -> Vector:
        """Return the joint values at the distance s from A, on the solution branch of the initial configuration."""
        end, line = float(s), self.make_line(chain, PRECISE_CONTEXT)
        step_length = end / max(1, round(end / SAMPLE_SPACING)) if end else 1.0
        *_, last_sample = self.make_line(chain).follow(step_length, 1e-3, end)
        q = line.joints_at(line.arm.evaluate_number(s), [PRECISE_CONTEXT.mpf(value) for value in last_sample.joints])
        assert q is not None
        return q

    def compute_results(self, chain: Chain, s: sp.Expr) -> "ResultsAtPoint":
        """Return the intermediate results at the distance s from A, to four digits, with angles in degrees."""
        line, q = self.make_line(chain, PRECISE_CONTEXT), self.compute_joint_values(chain, sp.sympify(s))
        distance, jacobian = line.arm.evaluate_number(sp.sympify(s)), line.arm.task_jacobian(q)
        kinds = [joint.kind for joint in chain.joints]
        joints = [PRECISE_CONTEXT.degrees(v) if kind == REVOLUTE else v for v, kind in zip(q, kinds, strict=True)]
        sigma = PRECISE_CONTEXT.svd_r(PRECISE_CONTEXT.matrix(jacobian), compute_uv=False)
        return ResultsAtPoint(
            s=sp.Float(PRECISE_CONTEXT.nstr(distance, 5), 10),
            point=_round(line.point(distance)),
            joints=_round(joints),
            jacobian=precise.round_matrix(jacobian),
            determinant=precise.round_to_four_digits(precise.determinant(jacobian)),
            rates=_round(self.compute_rates(line, q)),
            conditioning=precise.round_to_four_digits(min(sigma) / max(sigma)),
        )

    def compute_rates(self, line: StraightPath, q: Vector) -> Vector:
        """Return the joint rates on the line at joint values q."""
        speed = line.arm.evaluate_number(self.speed)
        return [derivative * speed for derivative in line.joint_derivatives(q)]

    def compute_start(self, chain: Chain) -> sp.Matrix:
        """Return A, to four digits."""
        return _round(self.make_line(chain, PRECISE_CONTEXT).start_point)

    def compute_direction(self, chain: Chain) -> sp.Matrix:
        """Return the unit vector from A to B, to four digits."""
        return _round(self.make_line(chain, PRECISE_CONTEXT).direction)

    def compute_length(self, chain: Chain) -> sp.Float:
        """Return the distance from A to B, to four digits."""
        return precise.round_to_four_digits(self.make_line(chain, PRECISE_CONTEXT).length)

    def tabulate_results(self, chain: Chain, end: sp.Expr) -> "list[ResultsAtPoint]":
        """Return the intermediate results at five points between A and the distance `end`, denser towards the end."""
        distances = [sp.Rational(int(share * end), 100) for share in (0, 40, 70, 90)]
        return [self.compute_results(chain, s) for s in (*distances, end)]


@dataclass(frozen=True)
class ResultsAtPoint:
    """The results at one point of a seam, to four digits (s has five).

    `conditioning` is sigma_min/sigma_max of J.
    """

    s: sp.Float
    point: sp.Matrix
    joints: sp.Matrix
    jacobian: sp.Matrix
    determinant: sp.Float
    rates: sp.Matrix
    conditioning: sp.Float


def _round(values: Vector) -> sp.Matrix:
    return precise.round_matrix([[value] for value in values])


@dataclass(frozen=True, kw_only=True)
class PathDetails(Details):
    """Details of a question about a welding line."""

    seam: WeldingLine

    def shown_values(self, chain: Chain) -> dict[str, float]:
        """Return the lengths, and the joint values at the start of the line."""
        return {**values_by_name(self.seam.lengths), **(self.pose or {})}


# --- joint rates at a point of the line ---


@dataclass(frozen=True, kw_only=True)
class DistanceDetails(PathDetails):
    """Details of a question about a point of a welding line, at a distance from A (m)."""

    distance: sp.Rational

    def given_values(self, chain: Chain) -> dict[str, float]:
        """Return the lengths, the joint values at the distance, and the velocity along the line."""
        seam, line = self.seam, self.seam.make_line(chain, PRECISE_CONTEXT)
        joints = seam.compute_joint_values(chain, self.distance)
        values = {symbol.name: float(value) for symbol, value in seam.lengths.items()}
        values |= {q.name: float(value) for q, value in zip(chain.q, joints, strict=True)}
        return values | {row: float(u) * float(seam.speed) for row, u in zip(chain.task, line.direction, strict=True)}


def _object_to_path(chain: Chain) -> str | None:
    if len(chain.linear_axes) != len(chain.task):
        return f"its task is {', '.join(chain.task)}, but a path of the point gives only linear velocities"
    if not 2 <= chain.n <= 3:
        return f"it has {count_noun(chain.n, 'joint')}; a path needs two or three"
    if objection := object_unless_square(chain) or object_to_symbolic_angles(chain):
        return objection
    if singular_set(chain) == () and not chain.revolute_joints:
        return "its Jacobian is constant, so the joint rates along a line are constant too"
    return None


def _ask_path_rates(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    for attempt in range(2 * PREFERRED_TRIES):
        is_preferred = attempt < PREFERRED_TRIES
        min_conditioning = REGULAR_CONDITIONING if is_preferred else LESS_REGULAR_CONDITIONING
        min_length, max_length = (25, 60) if is_preferred else (15, 40)
        seam = _sample_line(chain, rng, min_length, max_length, 1.3 * min_conditioning)
        if seam is None:
            continue
        line = seam.make_line(chain)
        samples = list(line.follow(SAMPLE_SPACING, min_conditioning))
        if samples[-1:] and samples[-1].s > float(line.length) - SAMPLE_SPACING:
            last_step = int(20 * float(line.length)) - 1  # in steps of 5 cm
            return _ask_rates_at(chain, seam, sp.Rational(5 * rng.integer(min(3, last_step), last_step), 100))
    return None


def _ask_rates_at(chain: Chain, seam: WeldingLine, s: sp.Rational) -> AnswerAndDetails:
    rates = seam.compute_rates(seam.make_line(chain, PRECISE_CONTEXT), seam.compute_joint_values(chain, s))
    answer = inversion.make_joint_rates(chain, rates, max(map(abs, rates)))
    return answer, DistanceDetails(seam=seam, distance=s, pose=seam.figure_values)


def _sample_line(
    chain: Chain, rng: Stream, min_length: int, max_length: int, min_conditioning: float
) -> WeldingLine | None:
    """Return a random line of `min_length` to `max_length` cm, or None if the sample is unsuitable.

    `min_conditioning` is the minimum sigma_min/sigma_max of the initial configuration.
    """
    lengths, joints = inversion.sample_lengths(chain, rng), inversion.sample_joint_values(chain, rng)
    displacement = [rng.integer(-max_length, max_length) for _ in chain.task]
    speed = sp.Rational(rng.integer(2, 8), 40)
    is_suitable = min_length**2 <= sum(k * k for k in displacement) <= max_length**2
    if not is_suitable or inversion.compute_conditioning(chain, lengths, joints) < min_conditioning:
        return None
    return WeldingLine(lengths, joints, _place_target(chain, lengths, joints, displacement), speed)


def _place_target(
    chain: Chain, lengths: dict[sp.Symbol, sp.Rational], joints: dict[sp.Symbol, sp.Expr], displacement: Sequence[int]
) -> dict[str, sp.Rational]:
    """Return the point that is displaced from P by `displacement` (cm), rounded to whole centimetres."""
    arm = PreciseArm(chain, lengths)
    point = arm.point_and_jacobian([arm.evaluate_number(joints[q]) for q in chain.q])[0]
    start = [sp.Float(PRECISE_CONTEXT.nstr(point[row], 28), 28) for row in arm.task_rows]
    axes = zip(chain.linear_axes, start, displacement, strict=True)
    return {axis: sp.Rational(_round_half_up(100 * value) + k, 100) for axis, value, k in axes}


def _round_half_up(value: sp.Expr) -> int:
    """Return the nearest integer; halves are rounded up."""
    return int(sp.floor(value + sp.Rational(500_000_001, 10**9)))


# --- where a rate exceeds its limit ---


@dataclass(frozen=True, kw_only=True)
class RateLimitDetails(PathDetails):
    """Details about the distance on a welding line at which the rate of a joint (from 1) exceeds its limit."""

    joint: int
    limit: sp.Rational


@dataclass(frozen=True)
class LimitCrossing:
    """The index of a joint, its rate limit, and the samples between which its rate first exceeds the limit."""

    joint: int
    limit: sp.Rational
    before: PathSample
    after: PathSample


def _object_to_limit(chain: Chain) -> str | None:
    if objection := _object_to_path(chain):
        return objection
    return None if singular_set(chain) else "it has no singular configuration for a path to approach"


def _ask_path_limit(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    for attempt in range(2 * PREFERRED_TRIES):
        min_conditioning = REGULAR_CONDITIONING if attempt < PREFERRED_TRIES else LESS_REGULAR_CONDITIONING
        seam = _sample_line_to_singularity(chain, rng, min_conditioning)
        if seam is None:
            continue
        samples = list(seam.make_line(chain).follow(SAMPLE_SPACING, SINGULAR_CONDITIONING))
        crossings = list(_find_crossings(samples, float(seam.speed)))
        if crossings:
            crossing = rng.choice(crossings)
            s = precise.round_to_ten_digits(_locate_crossing(chain, seam, crossing))
            joint, pose = crossing.joint + 1, seam.figure_values
            details = RateLimitDetails(seam=seam, joint=joint, limit=crossing.limit, pose=pose)
            return Number(sp.Matrix([s]), ("m",), THREE_DIGIT_TOLERANCE, 1e-6), details
    return None


def _sample_line_to_singularity(chain: Chain, rng: Stream, min_conditioning: float) -> WeldingLine | None:
    """Return a random line that may come near a singular configuration, or None if the sample is unsuitable.

    The line passes close to the position of P at a singular configuration, or it leads far out of reach.
    """
    solved_components = [component for component in singular_set(chain) or () if component.solutions is not None]
    if not solved_components or rng.integer_below(4) == 0:
        return _sample_line(chain, rng, 40, 120, 1.3 * min_conditioning)
    lengths, joints = inversion.sample_lengths(chain, rng), inversion.sample_joint_values(chain, rng)
    singular_joints, solutions = dict(joints), rng.choice(solved_components).solutions or ()
    for q, values in solutions:
        singular_joints[q] = rng.choice(values).xreplace(lengths)
    if not all(value.is_real for value in singular_joints.values()):
        return None
    for q in (q for q, joint in zip(chain.q, chain.joints, strict=True) if joint.is_revolute):
        min_steps = 7 if q in dict(solutions) else 0
        step_offset = rng.choice((-1, 1)) * rng.integer(min_steps, min_steps + 10)
        steps = _round_half_up(sp.N(singular_joints[q] * 36 / sp.pi, 30)) + step_offset
        joints[q] = sp.pi * sp.Rational((5 * steps + 179) % 360 - 179, 180)
    if inversion.compute_conditioning(chain, lengths, joints) < min_conditioning:
        return None
    displacement = [rng.choice((-1, 1)) * rng.integer(1, 6) for _ in chain.task]
    target = _place_target(chain, lengths, singular_joints, displacement)
    return WeldingLine(lengths, joints, target, sp.Rational(rng.integer(2, 8), 40))


def _find_crossings(samples: Sequence[PathSample], speed: float) -> list[LimitCrossing]:
    """Return the places at which a joint rate that grows towards a singularity first exceeds a round limit clearly."""
    crossings = []
    for joint in range(len(samples[0].slopes) if samples else 0):
        speeds = [abs(sample.slopes[joint]) * speed for sample in samples]
        for tenths in range(3, 31):
            k = next((i for i, value in enumerate(speeds) if value > tenths / 10), len(speeds))
            if _is_clear_crossing(samples, speeds, k, tenths / 10):
                crossings.append(LimitCrossing(joint, sp.Rational(tenths, 10), samples[k - 1], samples[k]))
    return crossings


def _is_clear_crossing(samples: Sequence[PathSample], speeds: Sequence[float], index: int, limit: float) -> bool:
    """Return whether the limit is clearly exceeded between samples k - 1 and k.

    The rate starts below half of the limit, keeps growing, and stays well below the limit until shortly before sample
    k. It grows so fast that three digits of the rate give three digits of s. J is closer to losing rank than at A.
    """
    if not 5 <= index < len(speeds) - 1 or limit < 2.5 * speeds[0]:
        return False
    s = samples[index].s
    is_growing = speeds[index - 2] < speeds[index - 1] < speeds[index] < speeds[index + 1]
    is_steep = s * (speeds[index] - speeds[index - 1]) > 2.0 * SAMPLE_SPACING * limit
    max_speed_before = max(value for sample, value in zip(samples, speeds, strict=True) if sample.s <= 0.9 * s)
    is_nearer_to_singularity = samples[index].conditioning < 0.5 * samples[0].conditioning
    return is_growing and is_steep and max_speed_before < 0.95 * limit and is_nearer_to_singularity


def _locate_crossing(chain: Chain, seam: WeldingLine, crossing: LimitCrossing) -> Any:
    """Return the distance at which the joint rate equals its limit, to 30 digits.

    First it is solved in floating point, then refined. Both use the secant method.
    """
    q: Vector = list(crossing.before.joints)
    start_values: tuple[Any, Any] = (crossing.before.s, crossing.after.s)

    def exceed_limit(line: StraightPath, s: Any) -> Any:
        """Return by how much the rate at s exceeds its limit, and update the joint values."""
        joints = line.joints_at(s, q)
        assert joints is not None
        q[:] = joints
        return abs(seam.compute_rates(line, q)[crossing.joint]) - line.arm.evaluate_number(crossing.limit)

    for context in (FLOAT_CONTEXT, PRECISE_CONTEXT):
        q[:] = map(context.mpf, q)
        excess = partial(exceed_limit, seam.make_line(chain, context))
        s = context.findroot(excess, list(map(context.mpf, start_values)))
        start_values = (s - 1e-9, s + 1e-9)
    return s


QUESTIONS = (
    Question(
        "path-rates", "Joint rates along a path", "6.7 on a welding path", points=2.0, needs=("inverse-velocity",),
        stage="rates", sample=_ask_path_rates, typed_names=name_joint_rates, objection=_object_to_path,
        is_made_of_jacobian=True, source_questions=RATE_SOURCES,
    ),
    Question(
        "path-limit", "Where a joint rate exceeds its limit", "6.7 near a singularity", points=2.0,
        needs=("path-rates",), sample=_ask_path_limit, entry_names=lambda chain, _: ["s"], objection=_object_to_limit,
        source_questions=(),
    ),
)  # fmt: skip
