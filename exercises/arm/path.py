"""A straight line p(s) = A + s u along which the arm moves its point, with the joint values on the line.

s is the distance from A in m, and u the unit vector from A to the target. Newton's method starts from the joint values
of the previous point, so that the arm stays on its branch. The joint rates are qd = J^-1 u speed (6.7). The task must
be square and have linear rows only.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.mpmath_kinematics import DOUBLE, PreciseArm, Vector, solve_linear

ITERATIONS = 12
"""Maximum number of Newton steps."""


@dataclass(frozen=True)
class Station:
    """The arm at one point of a line.

    - `s`: distance from the start of the line (m).
    - `joints`: the joint values q.
    - `slopes`: dq/ds.
    - `conditioning`: sigma_min / sigma_max of J.
    """

    s: float
    joints: tuple[float, ...]
    slopes: tuple[float, ...]
    conditioning: float


class Line:
    """A straight line from the point of interest at the configuration `joints` to `target`.

    `target` has one coordinate for each row of the task.
    """

    def __init__(
        self,
        chain: Chain,
        lengths: Mapping[sp.Symbol, sp.Expr],
        joints: Mapping[sp.Symbol, sp.Expr],
        target: Sequence[sp.Expr],
        context: Any = DOUBLE,
    ) -> None:
        self.arm, self.context = PreciseArm(chain, lengths, context), context
        self.q = [self.arm.number(joints[q]) for q in chain.q]
        self.start = [self.arm.place(self.q)[0][row] for row in self.arm.task]
        displacement = [self.arm.number(b) - a for a, b in zip(self.start, target, strict=True)]
        self.length = context.sqrt(sum(value * value for value in displacement))
        self.unit = [value / self.length for value in displacement]

    def point(self, s: Any) -> Vector:
        """Return p(s) = A + s u."""
        return [a + s * u for a, u in zip(self.start, self.unit, strict=True)]

    def joints_at(self, s: Any, near: Sequence[Any]) -> Vector | None:
        """Return the joint values at s that Newton's method finds from the values `near`; None if it fails."""
        target_point, q = self.point(s), list(near)
        for _ in range(ITERATIONS):
            point, jacobian = self.arm.place(q)
            error = [a - point[row] for a, row in zip(target_point, self.arm.task, strict=True)]
            if max(map(abs, error)) < 64 * self.context.eps:
                return q
            try:
                step = solve_linear([jacobian[row] for row in self.arm.task], error)
                q = [a + b for a, b in zip(q, step, strict=True)]
            except ZeroDivisionError:
                return None
        return None

    def slopes(self, q: Sequence[Any]) -> Vector:
        """Return dq/ds = J^-1 u, the joint rates at unit speed."""
        return solve_linear(self.arm.task_jacobian(q), self.unit)

    def station(self, s: float, q: Sequence[float]) -> Station:
        """Return the station at s with these joint values, in floats."""
        jacobian = self.arm.task_jacobian(q)
        sigma = np.linalg.svd(np.array(jacobian, dtype=float), compute_uv=False)
        return Station(s, tuple(q), tuple(solve_linear(jacobian, self.unit)), float(sigma[-1] / sigma[0]))

    def follow(self, step: float, floor: float, end: float | None = None) -> Iterator[Station]:
        """Yield stations in floats, at s = 0, `step`, 2 `step` and so on, up to `end` (by default the target).

        Stop early if the conditioning falls below `floor`, or if the arm would jump to another branch.
        """
        last_distance = float(self.length) if end is None else end
        q, s, step_count = self.q, 0.0, 0
        while s <= last_distance + 1e-12:
            station = self.station(s, q)
            if station.conditioning < floor:
                return
            yield station
            step_count += 1
            predicted_joints = [a + step * b for a, b in zip(q, station.slopes, strict=True)]
            s = step * step_count
            joints = self.joints_at(s, predicted_joints)
            if joints is None or max(abs(a - b) for a, b in zip(joints, predicted_joints, strict=True)) > 0.3:
                return
            q = joints
