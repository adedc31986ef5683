"""Compute the point of interest and the Jacobian of an arm: with 30 digits for the numbers in a problem, or in floats.

An mpmath *context* carries out the arithmetic: PRECISE_CONTEXT with 30 digits, FLOAT_CONTEXT in floats. The entries of
the arm's Denavit-Hartenberg table are evaluated once, with exact sines and cosines of constant angles. Then each frame
is computed from the previous one, as three axes and an origin in the world frame. The rows of the Jacobian are vx, vy,
vz, wx, wy and wz, as in (6.6) of the chapter.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import mpmath
import sympy as sp

from qdot.exercises.arm.chain import Chain

DIGITS = 30
"""The number of digits of PRECISE_CONTEXT."""
FLOAT_CONTEXT: Any = mpmath.fp
"""The context of floats, which is fast. It is used for searches, and for decisions that tolerate rounding errors."""
PRECISE_CONTEXT: Any = mpmath.MPContext()
"""The context of 30 digits. Its results, when rounded to ten digits, are the same on every machine."""
PRECISE_CONTEXT.dps = DIGITS

Vector = list[Any]
"""A list of numbers of a context."""


class MpmathArm:
    """An arm in the numbers of a context; `values` maps each symbolic length and angle to its value."""

    def __init__(self, chain: Chain, values: Mapping[sp.Symbol, sp.Expr], context: Any = PRECISE_CONTEXT) -> None:
        self.context, self.task_rows = context, chain.task_rows

        def to_number(expression: sp.Expr) -> Any:
            return evaluate_in_context(sp.sympify(expression).xreplace(dict(values)), context)

        def compute_cos_sin(angle: sp.Expr) -> tuple[Any, Any]:
            return to_number(sp.cos(angle)), to_number(sp.sin(angle))

        self.evaluate_number = to_number
        self.is_revolute = [joint.is_revolute for joint in chain.joints]
        self._joint_offsets = [to_number(value) for value in chain.offsets]
        self._link_entries = [(to_number(joint.a), *compute_cos_sin(joint.alpha)) for joint in chain.joints]
        # d of a revolute joint; (cos theta, sin theta) of a prismatic joint
        self._fixed_entries: list[Any] = [
            to_number(joint.d) if joint.is_revolute else compute_cos_sin(joint.theta) for joint in chain.joints
        ]
        self._base_angles = (*compute_cos_sin(chain.base.yaw), *compute_cos_sin(chain.base.tilt))
        self._base_position = [to_number(value) for value in chain.base.position]
        self._point_frame, self._point_offset = chain.point.frame, [to_number(value) for value in chain.point.offset]

    def compute_point_and_jacobian(self, q: Sequence[Any]) -> tuple[Vector, list[Vector]]:
        """Return the point of interest (a 3-vector in m), and the 6 x n Jacobian as rows, at joint values q."""
        one, zero = self.context.one, self.context.zero
        cos_yaw, sin_yaw, cos_tilt, sin_tilt = self._base_angles
        x, y = _rotate([one, zero, zero], [zero, one, zero], cos_yaw, sin_yaw)
        y, z = _rotate(y, [zero, zero, one], cos_tilt, sin_tilt)
        point = origin = self._base_position
        axes: list[Vector] = []
        origins: list[Vector] = []
        for i in range(len(q) + 1):
            if i == self._point_frame:
                point = origin
                for direction, distance in zip((x, y, z), self._point_offset, strict=True):
                    point = _translate(point, direction, distance)
            if i < len(q):
                axes.append(z)
                origins.append(origin)
                variable_entry = q[i] + self._joint_offsets[i]
                if self.is_revolute[i]:
                    cos, sin = self.context.cos(variable_entry), self.context.sin(variable_entry)
                    d = self._fixed_entries[i]
                else:
                    (cos, sin), d = self._fixed_entries[i], variable_entry
                a, cos_alpha, sin_alpha = self._link_entries[i]
                x, y = _rotate(x, y, cos, sin)
                origin = _translate(_translate(origin, z, d), x, a)
                y, z = _rotate(y, z, cos_alpha, sin_alpha)
        pairs = enumerate(zip(axes, origins, strict=True))
        columns = [self._compute_jacobian_column(i, z, point, origin) for i, (z, origin) in pairs]
        return point, [list(row) for row in zip(*columns, strict=True)]

    def compute_task_jacobian(self, q: Sequence[Any]) -> list[Vector]:
        """Return the m x n task Jacobian, as rows, at joint values q."""
        _, jacobian = self.compute_point_and_jacobian(q)
        return [jacobian[row] for row in self.task_rows]

    def _compute_jacobian_column(self, i: int, z: Vector, point: Vector, origin: Vector) -> Vector:
        """Return column i (from 0) of the Jacobian; the joint's axis has the direction z and contains `origin`."""
        zero_vector = [self.context.zero] * 3
        # Joints after the point's frame don't move the point, but rotate the last frame, whose angular velocity counts.
        if not self.is_revolute[i]:
            return [*(z if i < self._point_frame else zero_vector), *zero_vector]
        r = [p - o for p, o in zip(point, origin, strict=True)]
        cross = [z[1] * r[2] - z[2] * r[1], z[2] * r[0] - z[0] * r[2], z[0] * r[1] - z[1] * r[0]]
        return [*(cross if i < self._point_frame else zero_vector), *z]


def evaluate_in_context(value: sp.Expr, context: Any = PRECISE_CONTEXT) -> Any:
    """Evaluate an exact number in the arithmetic of a context."""
    return context.mpf(str(sp.N(value, DIGITS + 6)))  # six more digits, so that the rounding is correct


def round_to_ten_digits(value: Any) -> sp.Float:
    """Round a number of 30 digits to the ten digits that are stored in a problem.

    Dropping the last five of the 30 digits first makes the result the same on every machine.

    >>> round_to_ten_digits(PRECISE_CONTEXT.mpf(1) / 3)
    0.3333333333
    """
    if abs(value) < 1e-20:  # a rounding error of zero
        return sp.Float(0, 10)
    return sp.Float(PRECISE_CONTEXT.nstr(value, DIGITS - 5), 10)


def round_to_four_digits(value: Any) -> sp.Float:
    """Round a number to the four digits that worked solutions show.

    >>> round_to_four_digits(PRECISE_CONTEXT.mpf(2) / 3)
    0.6667000000
    """
    return sp.Float(0, 10) if abs(value) < 1e-12 else sp.Float(PRECISE_CONTEXT.nstr(value, 4), 10)


def round_matrix(rows: Sequence[Vector]) -> sp.Matrix:
    """Round the entries of a matrix to the four digits that worked solutions show."""
    return sp.Matrix([[round_to_four_digits(value) for value in row] for row in rows])


def solve_linear(matrix: Sequence[Vector], right_side: Sequence[Any], context: Any = PRECISE_CONTEXT) -> Vector:
    """Return the solution x of matrix x = right_side for a square matrix, given as rows.

    Raises ZeroDivisionError if the matrix is singular up to rounding.
    """
    return list(context.lu_solve(matrix, right_side))


def compute_inverse(matrix: Sequence[Vector]) -> list[Vector]:
    """Return the inverse of a square matrix as rows. Raises ZeroDivisionError if the matrix is singular."""
    rows: list[Vector] = PRECISE_CONTEXT.inverse(matrix).tolist()
    return rows


def compute_determinant(matrix: Sequence[Vector]) -> Any:
    """Return the determinant of a square matrix, given as rows; 0 if the matrix is singular up to rounding.

    >>> compute_determinant([[0, 1], [0, 2]])
    mpf('0.0')
    """
    try:
        return PRECISE_CONTEXT.det(matrix)
    except TypeError:  # mpmath finds no pivot if a column has only zeros from the diagonal down
        return PRECISE_CONTEXT.zero


def compute_gram_matrix(matrix: Sequence[Vector]) -> list[Vector]:
    """Return the product of a matrix, given as rows, and its transpose."""
    return [[sum(a * b for a, b in zip(row, other_row, strict=True)) for other_row in matrix] for row in matrix]


def _rotate(x: Vector, y: Vector, cos: Any, sin: Any) -> tuple[Vector, Vector]:
    """Return two perpendicular unit vectors rotated in their plane by an angle with this cosine and sine."""
    pairs = list(zip(x, y, strict=True))
    return [cos * a + sin * b for a, b in pairs], [cos * b - sin * a for a, b in pairs]


def _translate(start: Vector, direction: Vector, distance: Any) -> Vector:
    """Return the point at distance `distance` from `start` in the direction `direction`."""
    return [a + distance * b for a, b in zip(start, direction, strict=True)]
