"""Check the joint rates while the tool point moves along a straight line.

The line is followed numerically, with products of 4 x 4 matrices. A second method computes the joint rates by finite
differences of the joint values along the line.
"""

import numpy as np

from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.path import LESS_REGULAR_CONDITIONING, PathDetails, WeldingLine
from qdot.exercises.verify.formulas import PartCheck, check_agreement
from qdot.exercises.verify.numbers import (
    MIN_CONDITIONING_FACTOR,
    NUMBER_TOLERANCE,
    check_three_digits,
    list_reference_numbers,
)
from qdot.exercises.verify.numeric_model import Check, Checks, NumericModel, compute_conditioning_ratios

STEP, DIFFERENCE_TOLERANCE = 1e-4, 1e-5
"""Step (m) of the finite differences, and the relative error allowed for rates computed from them."""

STATION_COUNT = 60
"""Number of points along a line at which the joint values are computed."""

MAX_JUMP, MAX_GAP = 0.2, 1e-6
"""Maximum change of a joint value (rad or m) in one step along a line, and maximum difference of the final joint values
if the line is followed in other steps."""


class LineFollower:
    """Follows a straight line in floating point with Newton's method.

    `q` are joint values, and `s` is a distance (m) from the start of the line. `initial_joints` are the joint values at
    the start. `direction` is the unit vector along the line, with one component for each row of the task.
    """

    def __init__(self, model: NumericModel, line: WeldingLine) -> None:
        self.arm = NumericChain(model.chain, {symbol.name: float(value) for symbol, value in line.lengths.items()})
        self.task_rows, self.speed = model.task_rows, float(line.speed)
        self.initial_joints = np.array([float(line.joints[q]) for q in model.chain.q])
        self.origin = self.arm.compute_point(self.initial_joints)[self.task_rows]
        displacement = np.array([float(value) for value in line.target.values()]) - self.origin
        self.length = float(np.linalg.norm(displacement))
        self.direction = displacement / self.length

    def solve_at(self, initial_q: np.ndarray, s: float) -> np.ndarray:
        """Return the joint values at the distance s, found by Newton's method from `initial_q`."""
        q, frames = initial_q, self.arm.compute_frames(initial_q)
        for _ in range(20):
            error = self.origin + s * self.direction - self.arm.compute_point_of(frames)[self.task_rows]
            if np.abs(error).max() < 1e-14:
                break
            q = q + np.linalg.solve(self.arm.compute_jacobian_of(frames)[self.task_rows], error)
            frames = self.arm.compute_frames(q)
        return q

    def follow(self, distances: np.ndarray) -> np.ndarray:
        """Return the joint values (k x n) at increasing distances (k), the first of which is near zero.

        Each search starts from the joint values that the previous Jacobian predicts.
        """
        q, previous_s = self.initial_joints, 0.0
        configurations = []
        for s in distances:
            slopes = np.linalg.solve(self.arm.compute_jacobian(q)[self.task_rows], self.direction)
            q, previous_s = self.solve_at(q + (s - previous_s) * slopes, s), s
            configurations.append(q)
        return np.array(configurations)

    def compute_rates(self, q: np.ndarray) -> np.ndarray:
        """Return the joint rates at the joint values q, by solving a linear system."""
        return np.asarray(np.linalg.solve(self.arm.compute_jacobian(q)[self.task_rows], self.direction) * self.speed)

    def compute_rates_by_differences(self, q: np.ndarray, s: float) -> np.ndarray:
        """Return the joint rates at the distance s, found by central differences of the joint values along the line."""
        return (self.solve_at(q, s + STEP) - self.solve_at(q, s - STEP)) / (2 * STEP) * self.speed


def _check_path_rates(model: NumericModel, part: Part) -> Checks:
    """Check the joint rates at the question's distance from the start of the line, by following the line."""
    details = part.details_as(PathDetails)
    line, s = LineFollower(model, details.welding_line), float(details.distance)
    configurations = line.follow(np.linspace(0, s, STATION_COUNT))
    for name, expected, tolerance in (
        ("linear solve", line.compute_rates(configurations[-1]), NUMBER_TOLERANCE),
        ("differences along the line", line.compute_rates_by_differences(configurations[-1], s), DIFFERENCE_TOLERANCE),
    ):
        yield check_agreement(name, list_reference_numbers(part), expected[None, :, None], tolerance)
    yield Check("on the line", s < line.length, f"{s:g} m of {line.length:.3f} m")
    yield _check_one_branch(line, configurations, s, MIN_CONDITIONING_FACTOR * LESS_REGULAR_CONDITIONING)
    yield check_three_digits(part)


def _check_one_branch(line: LineFollower, configurations: np.ndarray, s: float, min_ratio: float) -> Check:
    """Check that the joint values (k x n) up to the distance s stay on one branch of the inverse kinematics.

    The line is followed again in steps a quarter as long. The joint values must change in small steps and must end at
    the same values. `min_ratio` is the minimum sigma_min/sigma_max of J.
    """
    closer_configurations = line.follow(np.linspace(0, s, 4 * STATION_COUNT))
    gap = float(np.abs(closer_configurations[-1] - configurations[-1]).max())
    jump = float(np.abs(np.diff(closer_configurations, axis=0)).max())
    ratio = float(
        compute_conditioning_ratios(line.arm.compute_jacobian(closer_configurations)[:, line.task_rows]).min()
    )
    detail = f"sigma_min/sigma_max at least {ratio:.3f}, steps of the joints at most {jump:.3f}, ends {gap:.1e} apart"
    return Check("on one branch", ratio > min_ratio and jump < MAX_JUMP and gap < MAX_GAP, detail)


CHECKS: dict[str, PartCheck] = {"path-rates": _check_path_rates}
