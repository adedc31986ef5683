"""Questions on a welding robot: joint rates along a straight line at a given speed, and where a rate exceeds its limit.

A is the position of P in a given initial configuration. P moves on the line from A towards B (given in cm) at constant
speed v. At the distance s from A, the position of P is p(s) = A + s u with u = (B - A)/|B - A|. The joint rates are
qd = J^-1 u v (6.7), at the configuration with P at p(s).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, NamedTuple

import sympy as sp

from qdot.exercises.arm import mpmath_kinematics as precise
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.mpmath_kinematics import FLOAT_CONTEXT, PRECISE_CONTEXT, MpmathArm, Vector
from qdot.exercises.arm.path import PathSample, StraightPath
from qdot.exercises.common.errors import count_noun
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details, list_values_by_name, recorded_as
from qdot.exercises.questions import inversion
from qdot.exercises.questions.base import AnswerAndDetails, Question, find_determinant_objection, name_joint_rates
from qdot.exercises.questions.inversion import THREE_DIGIT_TOLERANCE, Configuration, JointValues, Lengths
from qdot.exercises.questions.redundancy import find_symbolic_angle_objection
from qdot.exercises.reference_answers import Number
from qdot.exercises.singularities.singular_set import find_singular_set

SAMPLE_SPACING = 0.02
"""Distance (m) between the points at which a line is examined."""

REGULAR_CONDITIONING, LESS_REGULAR_CONDITIONING, SINGULAR_CONDITIONING = 0.15, 0.05, 0.03
"""Minimum sigma_min/sigma_max along a line: for a regular line, a less regular line, and a line to a singularity.

An arm with links of very different lengths may have only less regular lines.
"""

START_MARGIN = 1.3
"""Factor by which sigma_min/sigma_max at the start of a line exceeds the minimum along the line."""

NONSINGULAR_CONDITIONING = 1e-3
"""Minimum sigma_min/sigma_max that only excludes singular configurations, on a line that was examined before."""

PREFERRED_TRIES = 1000
"""Number of lines to sample before a less regular one is accepted."""


@dataclass(frozen=True)
class WeldingLine(Configuration):
    """A welding line: the configuration at A, the coordinates of the target B (m) by axis, and the speed (m/s)."""

    target: dict[str, sp.Rational]
    speed: sp.Rational

    def make_path(self, chain: Chain, context: Any = FLOAT_CONTEXT) -> StraightPath:
        """Return the path of the arm along the line, in the arithmetic of an mpmath context (by default, floats)."""
        return StraightPath(chain, self.lengths, self.joints, tuple(self.target.values()), context)

    def compute_joint_values(self, chain: Chain, s: sp.Expr) -> Vector:
        """Return the joint values at the distance s from A, on the solution branch of the initial configuration."""
        distance = float(s)
        step_length = distance / max(1, round(distance / SAMPLE_SPACING)) if distance else 1.0
        *_, last_sample = self.make_path(chain).follow(step_length, NONSINGULAR_CONDITIONING, distance)
        path = self.make_path(chain, PRECISE_CONTEXT)
        q = path.find_joint_values(
            path.arm.evaluate_number(s), [PRECISE_CONTEXT.mpf(value) for value in last_sample.joint_values]
        )
        assert q is not None
        return q

    @cached_property
    def _results(self) -> "dict[tuple[Chain, sp.Expr], ResultsAtPoint]":
        return {}

    def compute_results(self, chain: Chain, s: sp.Expr) -> "ResultsAtPoint":
        """Return the intermediate results at the distance s from A, to four digits, with angles in degrees.

        They are kept, because hints, solution and translations show the same ones.
        """
        key = chain, sp.sympify(s)
        if key not in self._results:
            self._results[key] = self._compute_results(*key)
        return self._results[key]

    def _compute_results(self, chain: Chain, s: sp.Expr) -> "ResultsAtPoint":
        path = self.make_path(chain, PRECISE_CONTEXT)
        q = self.compute_joint_values(chain, s)
        distance = path.arm.evaluate_number(s)
        jacobian = path.arm.compute_task_jacobian(q)
        joints = [PRECISE_CONTEXT.degrees(v) if j.is_revolute else v for v, j in zip(q, chain.joints, strict=True)]
        sigma = PRECISE_CONTEXT.svd_r(PRECISE_CONTEXT.matrix(jacobian), compute_uv=False)
        return ResultsAtPoint(
            s=sp.Float(PRECISE_CONTEXT.nstr(distance, 5), 10),
            point=_round(path.compute_point(distance)),
            joints=_round(joints),
            jacobian=precise.round_matrix(jacobian),
            determinant=precise.round_to_four_digits(precise.determinant(jacobian)),
            rates=_round(self.compute_rates(path, q)),
            conditioning=precise.round_to_four_digits(min(sigma) / max(sigma)),
        )

    def compute_rates(self, path: StraightPath, q: Vector) -> Vector:
        """Return the joint rates on the path of this line at joint values q."""
        speed = path.arm.evaluate_number(self.speed)
        return [derivative * speed for derivative in path.compute_derivatives(q)]

    def describe_line(self, chain: Chain) -> "LineDescription":
        """Return the start, the length and the direction of the line."""
        path = self.make_path(chain, PRECISE_CONTEXT)
        length = precise.round_to_four_digits(path.length)
        return LineDescription(_round(path.start_point), length, _round(path.direction))

    def tabulate_results(self, chain: Chain, end: sp.Expr) -> "list[ResultsAtPoint]":
        """Return the intermediate results at five points from A to the distance `end`, which are denser near `end`."""
        distances = [sp.Rational(int(percent * end), 100) for percent in (0, 40, 70, 90)]
        return [self.compute_results(chain, s) for s in (*distances, end)]


class LineDescription(NamedTuple):
    """The point A, the distance from A to B (m), and the unit vector from A to B, to four digits."""

    start: sp.Matrix
    length: sp.Float
    direction: sp.Matrix


@dataclass(frozen=True)
class ResultsAtPoint:
    """The results at one point of a welding line, to four digits (s has five).

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

    welding_line: WeldingLine = field(metadata=recorded_as("seam"))

    def list_shown_values(self, chain: Chain) -> dict[str, float]:
        """Return the lengths, and the joint values at the start of the line, by name."""
        return {**list_values_by_name(self.welding_line.lengths), **(self.pose or {})}


# --- joint rates at a point of the line ---


@dataclass(frozen=True, kw_only=True)
class DistanceDetails(PathDetails):
    """Details of a question about the point of a welding line at a `distance` (m) from A."""

    distance: sp.Rational

    def list_given_values(self, chain: Chain) -> dict[str, float]:
        """Return the lengths, the joint values at the distance, and the task velocity, by name."""
        direction, speed = self.welding_line.make_path(chain, PRECISE_CONTEXT).direction, float(self.welding_line.speed)
        joints = self.welding_line.compute_joint_values(chain, self.distance)
        values = {q.name: float(value) for q, value in zip(chain.q, joints, strict=True)}
        velocity = {row: float(u) * speed for row, u in zip(chain.task, direction, strict=True)}
        return {**list_values_by_name(self.welding_line.lengths), **values, **velocity}


def _find_path_objection(chain: Chain) -> str | None:
    if len(chain.linear_axes) != len(chain.task):
        return f"its task is {', '.join(chain.task)}, but a path of the point gives only linear velocities"
    if not 2 <= chain.n <= 3:
        return f"it has {count_noun(chain.n, 'joint')}; a path needs two or three"
    if objection := find_determinant_objection(chain) or find_symbolic_angle_objection(chain):
        return objection
    if find_singular_set(chain) == () and not chain.revolute_joints:
        return "its Jacobian is constant, so the joint rates along a line are constant too"
    return None


def _ask_path_rates(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    for attempt in range(2 * PREFERRED_TRIES):
        is_preferred = attempt < PREFERRED_TRIES
        min_conditioning = REGULAR_CONDITIONING if is_preferred else LESS_REGULAR_CONDITIONING
        min_length, max_length = (25, 60) if is_preferred else (15, 40)
        welding_line = _sample_line(chain, rng, min_length, max_length, START_MARGIN * min_conditioning)
        if welding_line is None:
            continue
        path = welding_line.make_path(chain)
        samples = list(path.follow(SAMPLE_SPACING, min_conditioning))
        if samples and samples[-1].s > float(path.length) - SAMPLE_SPACING:  # P reaches the target
            last_step = int(20 * float(path.length)) - 1  # in steps of 5 cm
            s = sp.Rational(rng.integer(min(3, last_step), last_step), 20)
            joints = welding_line.compute_joint_values(chain, s)
            rates = welding_line.compute_rates(welding_line.make_path(chain, PRECISE_CONTEXT), joints)
            answer = inversion.make_joint_rates(chain, rates, max(map(abs, rates)))
            return answer, DistanceDetails(welding_line=welding_line, distance=s, pose=welding_line.figure_values)
    return None


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
    return WeldingLine(lengths, joints, _choose_target(chain, lengths, joints, displacement), speed)


def _choose_target(
    chain: Chain, lengths: Lengths, joints: JointValues, displacement: Sequence[int]
) -> dict[str, sp.Rational]:
    """Return the point B at P plus a displacement in cm: its coordinates in m, rounded to centimetres, by axis."""
    arm = MpmathArm(chain, lengths)
    point, _ = arm.compute_point_and_jacobian([arm.evaluate_number(joints[q]) for q in chain.q])
    start = [sp.Float(PRECISE_CONTEXT.nstr(point[row], 28), 28) for row in arm.task_rows]
    axes = zip(chain.linear_axes, start, displacement, strict=True)
    return {axis: sp.Rational(_round_half_up(100 * value) + k, 100) for axis, value, k in axes}


def _round_half_up(value: sp.Expr) -> int:
    """Return the nearest integer; halves are rounded up, even if a rounding error makes them slightly too small."""
    return int(sp.floor(value + sp.Rational(500_000_001, 10**9)))


# --- where a rate exceeds its limit ---


@dataclass(frozen=True, kw_only=True)
class RateLimitDetails(PathDetails):
    """Details of a question about the distance from A at which the rate of a joint (a number) exceeds its limit."""

    joint: int
    limit: sp.Rational


@dataclass(frozen=True)
class LimitCrossing:
    """The index of a joint (from 0), its rate limit, and the samples just before and after the rate exceeds it."""

    joint: int
    limit: sp.Rational
    before: PathSample
    after: PathSample


def _find_limit_objection(chain: Chain) -> str | None:
    if objection := _find_path_objection(chain):
        return objection
    return None if find_singular_set(chain) else "it has no singular configuration for a path to approach"


def _ask_path_limit(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    for attempt in range(2 * PREFERRED_TRIES):
        min_conditioning = REGULAR_CONDITIONING if attempt < PREFERRED_TRIES else LESS_REGULAR_CONDITIONING
        welding_line = _sample_line_to_singularity(chain, rng, min_conditioning)
        if welding_line is None:
            continue
        samples = list(welding_line.make_path(chain).follow(SAMPLE_SPACING, SINGULAR_CONDITIONING))
        if crossings := _find_crossings(samples, float(welding_line.speed)):
            crossing = rng.choice(crossings)
            s = precise.round_to_ten_digits(_locate_crossing(chain, welding_line, crossing))
            details = RateLimitDetails(
                welding_line=welding_line,
                joint=crossing.joint + 1,
                limit=crossing.limit,
                pose=welding_line.figure_values,
            )
            return Number(sp.Matrix([s]), ("m",), THREE_DIGIT_TOLERANCE, 1e-6), details
    return None


def _sample_line_to_singularity(chain: Chain, rng: Stream, min_conditioning: float) -> WeldingLine | None:
    """Return a random line that may come near a singular configuration, or None if the sample is unsuitable.

    The target is close to the position of P at a singular configuration, or it may be out of reach (40 to 120 cm away).
    """
    solved_components = [component for component in find_singular_set(chain) or () if component.solutions is not None]
    if not solved_components or rng.integer_below(4) == 0:
        return _sample_line(chain, rng, 40, 120, START_MARGIN * min_conditioning)
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
        joints[q] = sp.pi * sp.Rational((5 * steps + 179) % 360 - 179, 180)  # steps of 5 degrees, in (-180, 180]
    if inversion.compute_conditioning(chain, lengths, joints) < min_conditioning:
        return None
    displacement = [rng.choice((-1, 1)) * rng.integer(1, 6) for _ in chain.task]
    target = _choose_target(chain, lengths, singular_joints, displacement)
    return WeldingLine(lengths, joints, target, sp.Rational(rng.integer(2, 8), 40))


def _find_crossings(samples: Sequence[PathSample], speed: float) -> list[LimitCrossing]:
    """Return where joint rates that grow towards a singularity clearly exceed limits of 0.3 to 3.0 rad/s or m/s."""
    crossings = []
    for joint in range(len(samples[0].derivatives) if samples else 0):
        abs_rates = [abs(sample.derivatives[joint]) * speed for sample in samples]
        for tenths in range(3, 31):
            index = next((i for i, value in enumerate(abs_rates) if value > tenths / 10), len(abs_rates))
            if _is_clear_crossing(samples, abs_rates, index, tenths / 10):
                crossings.append(LimitCrossing(joint, sp.Rational(tenths, 10), samples[index - 1], samples[index]))
    return crossings


def _is_clear_crossing(samples: Sequence[PathSample], abs_rates: Sequence[float], index: int, limit: float) -> bool:
    """Return whether a joint rate clearly exceeds its limit between the sample before `index` and that at `index`.

    The rate starts below half of the limit, grows at the limit, and stays well below the limit until shortly before.
    It grows so fast that three digits of the rate give three digits of s. J is closer to losing rank than at A.
    """
    if not 5 <= index < len(abs_rates) - 1 or limit < 2.5 * abs_rates[0]:
        return False
    s = samples[index].s
    is_growing = abs_rates[index - 2] < abs_rates[index - 1] < abs_rates[index] < abs_rates[index + 1]
    is_steep = s * (abs_rates[index] - abs_rates[index - 1]) > 2.0 * SAMPLE_SPACING * limit
    max_rate_before = max(value for sample, value in zip(samples, abs_rates, strict=True) if sample.s <= 0.9 * s)
    is_nearer_to_singularity = samples[index].conditioning < 0.5 * samples[0].conditioning
    return is_growing and is_steep and max_rate_before < 0.95 * limit and is_nearer_to_singularity


def _locate_crossing(chain: Chain, welding_line: WeldingLine, crossing: LimitCrossing) -> Any:
    """Return the distance at which the joint rate equals its limit, to 30 digits.

    The secant method finds the distance in floating point first, and then with 30 digits.
    """
    q: Vector = list(crossing.before.joint_values)
    start_values: tuple[Any, Any] = (crossing.before.s, crossing.after.s)

    def compute_excess(path: StraightPath, s: Any) -> Any:
        """Return the rate at s minus its limit, and update the joint values q."""
        joints = path.find_joint_values(s, q)
        assert joints is not None
        q[:] = joints
        return abs(welding_line.compute_rates(path, q)[crossing.joint]) - path.arm.evaluate_number(crossing.limit)

    for context in (FLOAT_CONTEXT, PRECISE_CONTEXT):
        q[:] = map(context.mpf, q)
        excess = partial(compute_excess, welding_line.make_path(chain, context))
        s = context.findroot(excess, list(map(context.mpf, start_values)))
        start_values = (s - 1e-9, s + 1e-9)
    return s


QUESTIONS = (
    Question(
        "path-rates", "Joint rates along a path", "6.7 on a welding path", points=2.0,
        prerequisites=("inverse-velocity",), formula="inv(J)*xd", sample=_ask_path_rates, list_labels=name_joint_rates,
        find_arm_objection=_find_path_objection, is_made_of_jacobian=True,
        alternative_prerequisites=inversion.RATE_PREREQUISITES,
    ),
    Question(
        "path-limit", "Where a joint rate exceeds its limit", "6.7 near a singularity", points=2.0,
        prerequisites=("path-rates",), sample=_ask_path_limit, name_entries=lambda chain, _: ["s"],
        find_arm_objection=_find_limit_objection, alternative_prerequisites=(),
    ),
)  # fmt: skip
