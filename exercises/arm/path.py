"""Compute the joint values while an arm moves its point of interest along a straight line p(s) = A + s u.

s is the distance from the start A (m), and u is the unit vector from A to the target. Newton's method finds the joint
values at p(s). It starts from the joint values at the previous point, so the arm stays on one branch of solutions. The
joint rates at the speed v are qd = J^-1 u v, equation (6.7) of the chapter. The task must have linear rows only, as
many as the arm has joints.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.mpmath_kinematics import FLOAT_CONTEXT, MpmathArm, Vector, solve_linear

Values = Mapping[sp.Symbol, sp.Expr]
"""Maps symbolic lengths or joint variables to their values."""
MAX_ITERATIONS = 12
"""Maximum number of Newton steps."""
MAX_JUMP = 0.3
"""Maximum difference of a joint value (rad or m) from its prediction; a larger one means a jump to another branch."""


@dataclass(frozen=True)
class PathSample:
    """The arm with its point of interest at p(s).

    - `s`: the distance from the start of the line (m).
    - `joint_values`: the joint values q (rad, m).
    - `derivatives`: the derivatives dq/ds.
    """

    s: float
    joint_values: tuple[float, ...]
    derivatives: tuple[float, ...]


class StraightPath:
    """A straight line from the position of the point of interest at the joint values `start` to `target`.

    `target` has one coordinate (m) for each row of the task. `lengths` maps symbolic lengths to their values.
    """

    def __init__(
        self, chain: Chain, lengths: Values, start: Values, target: Sequence[sp.Expr], context: Any = FLOAT_CONTEXT
    ) -> None:
        self.arm, self.context = MpmathArm(chain, lengths, context), context
        self.start_joint_values = [self.arm.evaluate_number(start[q]) for q in chain.q]
        start_position, _ = self.arm.compute_point_and_jacobian(self.start_joint_values)
        self.start_point = [start_position[row] for row in self.arm.task_rows]
        displacement = [self.arm.evaluate_number(b) - a for a, b in zip(self.start_point, target, strict=True)]
        self.length = context.sqrt(sum(value * value for value in displacement))
        self.direction = [value / self.length for value in displacement]

    def compute_point(self, s: Any) -> Vector:
        """Return the point p(s) = A + s u of the line."""
        return [a + s * u for a, u in zip(self.start_point, self.direction, strict=True)]

    def find_joint_values(self, s: Any, initial_values: Sequence[Any]) -> Vector | None:
        """Return the joint values at p(s), by Newton's method from `initial_values`; None if it fails."""
        target_point, q = self.compute_point(s), list(initial_values)
        for _ in range(MAX_ITERATIONS):
            point, jacobian = self.arm.compute_point_and_jacobian(q)
            error = [a - point[row] for a, row in zip(target_point, self.arm.task_rows, strict=True)]
            if max(map(abs, error)) < 64 * self.context.eps:  # zero except for rounding errors
                return q
            try:
                step = solve_linear([jacobian[row] for row in self.arm.task_rows], error, self.context)
                q = [a + b for a, b in zip(q, step, strict=True)]
            except ZeroDivisionError:
                return None
        return None

    def compute_derivatives(self, q: Sequence[Any]) -> Vector:
        """Return dq/ds = J^-1 u, the joint rates at unit speed, at joint values q."""
        return solve_linear(self.arm.compute_task_jacobian(q), self.direction, self.context)

    def follow(
        self, step_length: float, min_conditioning: float, end_distance: float | None = None
    ) -> Iterator[PathSample]:
        """Yield samples, in floats, at s = 0, `step_length`, 2 `step_length` and so on up to `end_distance`.

        `end_distance` is by default the length of the line. The samples end early if sigma_min/sigma_max of J falls
        below `min_conditioning`, or if the arm would jump to another branch of solutions.
        """
        last_distance = float(self.length) if end_distance is None else end_distance
        q, s, step_count = self.start_joint_values, 0.0, 0
        while s <= last_distance + 1e-12:  # s may exceed the distance by a rounding error
            jacobian = self.arm.compute_task_jacobian(q)
            sigma = np.linalg.svd(np.array(jacobian, dtype=float), compute_uv=False)
            if float(sigma[-1] / sigma[0]) < min_conditioning:
                return
            derivatives = solve_linear(jacobian, self.direction, self.context)
            yield PathSample(s, tuple(q), tuple(derivatives))
            step_count += 1
            predicted_q = [a + step_length * b for a, b in zip(q, derivatives, strict=True)]
            s = step_length * step_count
            new_q = self.find_joint_values(s, predicted_q)
            if new_q is None or max(abs(a - b) for a, b in zip(new_q, predicted_q, strict=True)) > MAX_JUMP:
                return
            q = new_q
