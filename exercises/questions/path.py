"""The question on a welding robot: joint rates along a straight line at a given speed.

A is the position of P at a given initial configuration. P moves on the line from A towards B at constant speed v. At
the distance s from A, the position of P is p(s) = A + s u with u = (B - A)/|B - A|. The joint rates are qd = J^-1 u v
(6.7), at the configuration with P at p(s).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import sympy as sp

from qdot.exercises.arm import mpmath_kinematics as precise
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.mpmath_kinematics import FLOAT_CONTEXT, PRECISE_CONTEXT, MpmathArm, Vector
from qdot.exercises.arm.path import StraightPath
from qdot.exercises.common.errors import count_noun
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details, list_values_by_name, recorded_as
from qdot.exercises.questions import inversion
from qdot.exercises.questions.base import AnswerAndDetails, Question, find_determinant_objection, name_joint_rates
from qdot.exercises.questions.inversion import Configuration, JointValues, Lengths
from qdot.exercises.questions.redundancy import find_symbolic_angle_objection
from qdot.exercises.singularities.singular_set import find_singular_set

SAMPLE_SPACING = 0.02
"""Distance (m) between the points at which a line is examined."""

REGULAR_CONDITIONING, LESS_REGULAR_CONDITIONING = 0.15, 0.05
"""Minimum sigma_min/sigma_max along a line: the preferred limit, and a lower limit for arms on which no line reaches
it. Such an arm may have links of very different lengths.
"""

START_MARGIN = 1.3
"""Factor by which sigma_min/sigma_max at the start of a line must exceed the limit along the line."""

NONSINGULAR_CONDITIONING = 1e-3
"""Minimum sigma_min/sigma_max on a line that was examined before; it excludes only singular configurations."""

PREFERRED_TRIES = 1000
"""Number of lines that are sampled before the lower limit is used."""


def choose_step_length(distance: float) -> float:
    """Return the length (m) of equal steps of about SAMPLE_SPACING that lead to a distance (m)."""
    step_count = max(1, round(distance / SAMPLE_SPACING))
    return distance / step_count if distance else SAMPLE_SPACING  # at A, no step is made


@dataclass(frozen=True)
class WeldingLine(Configuration):
    """A welding line: the configuration at A, the coordinates of the target B (m) by axis, and the speed (m/s)."""

    target: dict[str, sp.Rational]
    speed: sp.Rational

    def make_path(self, chain: Chain, context: Any = FLOAT_CONTEXT) -> StraightPath:
        """Return the arm's path along the line, in the arithmetic of an mpmath context (by default, with floats)."""
        return StraightPath(chain, self.lengths, self.joints, tuple(self.target.values()), context)

    def compute_joint_values(self, chain: Chain, s: sp.Expr) -> Vector:
        """Return the joint values at the distance s from A, on the solution branch of the initial configuration."""
        distance = float(s)
        step_length = choose_step_length(distance)
        *_, last_sample = self.make_path(chain).follow(step_length, NONSINGULAR_CONDITIONING, distance)
        path = self.make_path(chain, PRECISE_CONTEXT)
        q = path.find_joint_values(
            path.arm.evaluate_number(s), [PRECISE_CONTEXT.mpf(value) for value in last_sample.joint_values]
        )
        assert q is not None
        return q

    @cached_property
    def _results(self) -> "dict[tuple[Chain, sp.Expr], ResultsAtPoint]":
        """The cache of `compute_results`."""
        return {}

    def compute_results(self, chain: Chain, s: sp.Expr) -> "ResultsAtPoint":
        """Return the intermediate results at the distance s from A, to four digits, with angles in degrees.

        The results are cached, because hints, solutions and translations show the same ones.
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
        joints = [
            PRECISE_CONTEXT.degrees(value) if joint.is_revolute else value
            for value, joint in zip(q, chain.joints, strict=True)
        ]
        return ResultsAtPoint(
            s=sp.Float(PRECISE_CONTEXT.nstr(distance, 5), 10),
            point=_round(path.compute_point(distance)),
            joints=_round(joints),
            jacobian=precise.round_matrix(jacobian),
            determinant=precise.round_to_four_digits(precise.compute_determinant(jacobian)),
            rates=_round(self.compute_rates(path, q)),
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
        """Return the intermediate results at five points from A to the distance `end`, with more points near `end`."""
        distances = [sp.Rational(int(percent * end), 100) for percent in (0, 40, 70, 90)]  # rounded down to cm
        return [self.compute_results(chain, s) for s in (*distances, end)]


class LineDescription(NamedTuple):
    """The point A, the distance from A to B (m), and the unit vector from A to B, to four digits."""

    start: sp.Matrix
    length: sp.Float
    direction: sp.Matrix


@dataclass(frozen=True)
class ResultsAtPoint:
    """The results at one point of a welding line, to four digits (s has five)."""

    s: sp.Float
    point: sp.Matrix
    joints: sp.Matrix
    jacobian: sp.Matrix
    determinant: sp.Float
    rates: sp.Matrix


def _round(values: Vector) -> sp.Matrix:
    return precise.round_matrix([[value] for value in values])


@dataclass(frozen=True, kw_only=True)
class PathDetails(Details):
    """Details of a question about the point of a welding line at a `distance` (m) from A."""

    welding_line: WeldingLine = field(metadata=recorded_as("seam"))
    distance: sp.Rational

    def list_shown_values(self, chain: Chain) -> dict[str, float]:
        """Return the lengths, and the joint values at the start of the line, by name."""
        return {**list_values_by_name(self.welding_line.lengths), **(self.pose or {})}

    def list_given_values(self, chain: Chain) -> dict[str, float]:
        """Return the lengths, the joint values at the distance, and the task velocity, by name."""
        direction, speed = self.welding_line.make_path(chain, PRECISE_CONTEXT).direction, float(self.welding_line.speed)
        joints = self.welding_line.compute_joint_values(chain, self.distance)
        values = {q.name: float(value) for q, value in zip(chain.q, joints, strict=True)}
        velocity = {row: float(u) * speed for row, u in zip(chain.task, direction, strict=True)}
        return {**list_values_by_name(self.welding_line.lengths), **values, **velocity}


def _find_path_objection(chain: Chain) -> str | None:
    """Return why the question on joint rates along a line can't be asked about an arm, or None."""
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
    """Sample a line that the arm can follow to its end, and ask for the joint rates at a random point of the line."""
    for attempt in range(2 * PREFERRED_TRIES):
        is_preferred = attempt < PREFERRED_TRIES
        min_conditioning = REGULAR_CONDITIONING if is_preferred else LESS_REGULAR_CONDITIONING
        min_length, max_length = (25, 60) if is_preferred else (15, 40)  # in cm
        welding_line = _sample_line(chain, rng, min_length, max_length, START_MARGIN * min_conditioning)
        if welding_line is None:
            continue
        path = welding_line.make_path(chain)
        samples = list(path.follow(SAMPLE_SPACING, min_conditioning))
        if samples and samples[-1].s > float(path.length) - SAMPLE_SPACING:  # the arm can follow the whole line
            last_step = int(20 * float(path.length)) - 1  # in steps of 5 cm
            s = sp.Rational(rng.integer(min(3, last_step), last_step), 20)
            joints = welding_line.compute_joint_values(chain, s)
            rates = welding_line.compute_rates(welding_line.make_path(chain, PRECISE_CONTEXT), joints)
            answer = inversion.make_rates_answer(chain, rates, max(map(abs, rates)))
            return answer, PathDetails(welding_line=welding_line, distance=s, pose=welding_line.figure_values)
    return None


def _sample_line(
    chain: Chain, rng: Stream, min_length: int, max_length: int, min_conditioning: float
) -> WeldingLine | None:
    """Return a random line with a length of `min_length` to `max_length` cm, or None if the sample is unsuitable.

    `min_conditioning` is the minimum sigma_min/sigma_max of the initial configuration.
    """
    lengths, joints = inversion.sample_lengths(chain, rng), inversion.sample_joint_values(chain, rng)
    displacement = [rng.integer(-max_length, max_length) for _ in chain.task]
    speed = sp.Rational(rng.integer(2, 8), 40)  # 0.05 m/s to 0.2 m/s
    is_suitable = min_length**2 <= sum(k * k for k in displacement) <= max_length**2
    if not is_suitable or inversion.compute_conditioning(chain, lengths, joints) < min_conditioning:
        return None
    return WeldingLine(lengths, joints, _choose_target(chain, lengths, joints, displacement), speed)


def _choose_target(
    chain: Chain, lengths: Lengths, joints: JointValues, displacement: Sequence[int]
) -> dict[str, sp.Rational]:
    """Return the coordinates of B (m), rounded to centimetres, by axis; B is P plus a displacement in cm."""
    arm = MpmathArm(chain, lengths)
    point, _ = arm.compute_point_and_jacobian([arm.evaluate_number(joints[q]) for q in chain.q])
    start = [sp.Float(PRECISE_CONTEXT.nstr(point[row], 28), 28) for row in arm.task_rows]
    axes = zip(chain.linear_axes, start, displacement, strict=True)
    return {axis: sp.Rational(_round_half_up(100 * value) + k, 100) for axis, value, k in axes}


def _round_half_up(value: sp.Expr) -> int:
    """Return the nearest integer; halves are rounded up, even if a rounding error makes them slightly too small."""
    return int(sp.floor(value + sp.Rational(500_000_001, 10**9)))


QUESTIONS = (
    Question(
        "path-rates", "Joint rates along a path", "6.7, applied to a welding path", points=2.0,
        prerequisites=("inverse-velocity",), formula="inv(J)*xd", sample=_ask_path_rates, list_labels=name_joint_rates,
        find_arm_objection=_find_path_objection, is_made_of_jacobian=True,
        alternative_prerequisites=inversion.RATE_PREREQUISITES,
    ),
)  # fmt: skip
