"""Check the joint rates while the tool point moves along a straight line.

The line is followed numerically with products of 4 x 4 matrices. Finite differences of the joint values along it give
the joint rates by a second method.
"""

import numpy as np

from qdot.exercises.answer_types import Number
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.path import LESS_REGULAR_CONDITIONING, DistanceDetails, RateLimitDetails, WeldingLine
from qdot.exercises.verify.formulas import PartCheck, check_agreement
from qdot.exercises.verify.numbers import (
    MIN_CONDITIONING_SHARE,
    NUMBER_TOLERANCE,
    check_three_digits,
    reference_numbers,
)
from qdot.exercises.verify.numeric_reference import Check, Checks, NumericReference, conditioning_ratios

STATION_COUNT = 60
"""Number of points along a line at which the joint values are computed."""

MIN_CONDITIONING, STEP = 0.02, 1e-4
"""Minimum sigma_min/sigma_max of J on a line that approaches a singularity, and step of the finite differences (m)."""


class LineFollower:
    """Follows a straight line in floating point; Newton's method starts from the joint values at the previous point.

    `initial_joints` are the joint values at the start, and `direction` is the direction of the line in the task's rows.
    """

    def __init__(self, numeric: NumericReference, seam: WeldingLine) -> None:
        self.arm = NumericChain(numeric.chain, {symbol.name: float(value) for symbol, value in seam.lengths.items()})
        self.task, self.speed = numeric.task, float(seam.speed)
        self.initial_joints = np.array([float(seam.joints[q]) for q in numeric.chain.q])
        self.origin = self.arm.point(self.initial_joints)[self.task]
        displacement = np.array([float(value) for value in seam.target.values()]) - self.origin
        self.length = float(np.linalg.norm(displacement))
        self.direction = displacement / self.length

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Return the task Jacobian at q."""
        return np.asarray(self.arm.jacobian(q)[self.task])

    def joints_at(self, q: np.ndarray, s: float) -> np.ndarray:
        """Return the joint values at the distance s, found by Newton's method from the joint values q."""
        return self._joints_and_jacobian_at(q, s)[0]

    def _joints_and_jacobian_at(self, q: np.ndarray, s: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the joint values at the distance s, found by Newton's method from q, and the task Jacobian there."""
        frames = self.arm.frames(q)
        for _ in range(20):
            error = self.origin + s * self.direction - self.arm.point_of(frames)[self.task]
            if np.abs(error).max() < 1e-14:
                break
            q = q + np.linalg.solve(self.arm.jacobian_of(frames)[self.task], error)
            frames = self.arm.frames(q)
        return q, np.asarray(self.arm.jacobian_of(frames)[self.task])

    def follow(self, distances: np.ndarray) -> np.ndarray:
        """Return the joint values at increasing distances along the line, of which the first is near the start."""
        q, configurations, previous_s = self.initial_joints, [], 0.0
        jacobian = self.jacobian(q)
        for s in distances:
            start = q + (s - previous_s) * np.linalg.solve(jacobian, self.direction)
            (q, jacobian), previous_s = self._joints_and_jacobian_at(start, s), s
            configurations.append(q)
        return np.array(configurations)

    def rates(self, q: np.ndarray) -> np.ndarray:
        """Return the joint rates at the joint values q, found by a linear solve."""
        return np.asarray(np.linalg.solve(self.jacobian(q), self.direction) * self.speed)

    def rates_by_differences(self, q: np.ndarray, s: float) -> np.ndarray:
        """Return the joint rates at the distance s, found by central differences of the joint values along the line."""
        ahead, behind = (self.joints_at(q, s + side * STEP) for side in (1, -1))
        return (ahead - behind) / (2 * STEP) * self.speed

    def min_conditioning(self, joints: np.ndarray) -> float:
        """Return the minimum sigma_min/sigma_max of J over configurations (k x n)."""
        return float(conditioning_ratios(self.arm.jacobian(joints)[:, self.task]).min())


def _check_path_rates(numeric: NumericReference, part: Part) -> Checks:
    """Check the joint rates at the distance in the question, by following the line to it."""
    details = part.details_as(DistanceDetails)
    line, s = LineFollower(numeric, details.welding_line), float(details.distance)
    joints = line.follow(np.linspace(0, s, STATION_COUNT))
    expected = line.rates(joints[-1])
    yield check_agreement("linear solve", reference_numbers(part), expected[None, :, None], NUMBER_TOLERANCE)
    differenced = line.rates_by_differences(joints[-1], s)
    yield check_agreement("differences along the line", reference_numbers(part), differenced[None, :, None], 1e-5)
    yield Check("on the line", s < line.length, f"{s:g} m of {line.length:.3f} m")
    yield _check_one_branch(line, joints, s, MIN_CONDITIONING_SHARE * LESS_REGULAR_CONDITIONING)
    yield check_three_digits(part)


def _check_one_branch(line: LineFollower, joints: np.ndarray, s: float, min_ratio: float) -> Check:
    """Check that the joint values stay on one branch of the inverse kinematics.

    If the line is followed in steps a quarter as long, the joint values must change in small steps. The last ones must
    be the same.
    """
    finer = line.follow(np.linspace(0, s, 4 * STATION_COUNT))
    gap, jump = float(np.abs(finer[-1] - joints[-1]).max()), float(np.abs(np.diff(finer, axis=0)).max())
    ratio = line.min_conditioning(finer)
    detail = f"sigma_min/sigma_max at least {ratio:.3f}, steps of the joints at most {jump:.3f}, ends {gap:.1e} apart"
    return Check("on one branch", ratio > min_ratio and jump < 0.2 and gap < 1e-6, detail)


def _check_path_limit(numeric: NumericReference, part: Part) -> Checks:
    """Check that the joint speed equals the limit at the claimed distance, is lower before it, and higher after it."""
    answer, details = part.answer_as(Number), part.details_as(RateLimitDetails)
    line, claimed = LineFollower(numeric, details.welding_line), reference_numbers(part)
    if claimed.shape != (1, 1, 1) or not 0 < float(claimed[0, 0, 0]) < line.length:
        yield Check("on the line", False, f"{claimed.ravel()} is no distance on {line.length:.3f} m")
        return
    s, joint, limit = float(claimed[0, 0, 0]), details.joint - 1, float(details.limit)
    joints = line.follow(np.linspace(0, s, STATION_COUNT))
    rate, differenced = line.rates(joints[-1])[joint], line.rates_by_differences(joints[-1], s)[joint]
    for name, value, tolerance in (("limit", rate, 1e-7), ("differences along the line", differenced, 1e-3)):
        yield check_agreement(name, np.full((1, 1, 1), abs(value)), np.full((1, 1, 1), limit), tolerance)
    speeds = np.array([abs(line.rates(q)[joint]) for q in joints[:-1]])
    yield Check("first time", bool(speeds.max() < limit), f"at most {speeds.max():.3f} before it, limit {limit:g}")
    slack = answer.tolerance * s
    behind, ahead = (abs(line.rates(line.joints_at(joints[-1], s + side * slack))[joint]) for side in (-1, 1))
    detail = f"{behind:.4f} and {ahead:.4f} at the ends of what is accepted"
    yield Check("clear crossing", bool(behind < 0.995 * limit and 1.005 * limit < ahead), detail)
    yield _check_one_branch(line, joints, s, MIN_CONDITIONING)
    yield check_three_digits(part)


CHECKS: dict[str, PartCheck] = {
    "path-rates": _check_path_rates,
    "path-limit": _check_path_limit,
}
