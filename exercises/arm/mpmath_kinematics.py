"""Compute the point of interest and the Jacobian of an arm, in floats or with 30 digits for numbers in a problem.

The entries of the table are evaluated once, with exact sines and cosines of constant angles. Then each frame is
computed from the previous one, as three axes and an origin in the world frame. The rows of the Jacobian are those of
(6.6).
"""

from collections.abc import Mapping, Sequence
from typing import Any

import mpmath
import sympy as sp

from qdot.exercises.arm.chain import Chain

DIGITS = 30
FLOAT_CONTEXT: Any = mpmath.fp
"""The context of floats, which is fast; for searches, and for decisions with a margin."""
PRECISE_CONTEXT: Any = mpmath.MPContext()
"""The context of 30 digits, whose results are the same on every machine when rounded to ten digits."""
PRECISE_CONTEXT.dps = DIGITS

Vector = list[Any]


class PreciseArm:
    """A numeric arm in the arithmetic of an mpmath context; `values` has all symbolic lengths and angles."""

    def __init__(self, chain: Chain, values: Mapping[sp.Symbol, sp.Expr], context: Any = PRECISE_CONTEXT) -> None:
        self.context, self.task_rows = context, chain.task_rows

        def number(expression: sp.Expr) -> Any:
            return evaluate_in_context(sp.sympify(expression).xreplace(dict(values)), context)

        def cos_sin(angle: sp.Expr) -> tuple[Any, Any]:
            return number(sp.cos(angle)), number(sp.sin(angle))

        self.evaluate_number, self.is_revolute = number, [joint.kind == "R" for joint in chain.joints]
        self._offsets = [number(value) for value in chain.offsets]
        self._links = [(number(joint.a), *cos_sin(joint.alpha)) for joint in chain.joints]
        self._fixed = [number(joint.d) if joint.kind == "R" else cos_sin(joint.theta) for joint in chain.joints]
        self._base = (*cos_sin(chain.base.yaw), *cos_sin(chain.base.tilt))
        self._origin = [number(value) for value in chain.base.position]
        self._frame, self._offset = chain.point.frame, [number(value) for value in chain.point.offset]

    def point_and_jacobian(self, q: Sequence[Any]) -> tuple[Vector, list[Vector]]:
        """Return the point of interest (3, m), and the 6 x n Jacobian as rows, at joint values q."""
        one, zero = self.context.one, self.context.zero
        cos_yaw, sin_yaw, cos_tilt, sin_tilt = self._base
        x, y = _rotate([one, zero, zero], [zero, one, zero], cos_yaw, sin_yaw)
        y, z = _rotate(y, [zero, zero, one], cos_tilt, sin_tilt)
        point = origin = self._origin
        axes: list[Vector] = []
        origins: list[Vector] = []
        for i in range(len(q) + 1):
            if i == self._frame:
                point = origin
                for direction, distance in zip((x, y, z), self._offset, strict=True):
                    point = _translate(point, direction, distance)
            if i < len(q):
                axes.append(z)
                origins.append(origin)
                cos, sin, d = self._theta_and_d(i, q[i] + self._offsets[i])
                a, cos_twist, sin_twist = self._links[i]
                x, y = _rotate(x, y, cos, sin)
                origin = _translate(_translate(origin, z, d), x, a)
                y, z = _rotate(y, z, cos_twist, sin_twist)
        columns = [self._jacobian_column(i, z, point, o) for i, (z, o) in enumerate(zip(axes, origins, strict=True))]
        return point, [list(row) for row in zip(*columns, strict=True)]

    def task_jacobian(self, q: Sequence[Any]) -> list[Vector]:
        """Return the m x n Jacobian of the task, as rows."""
        rows = self.point_and_jacobian(q)[1]
        return [rows[row] for row in self.task_rows]

    def _theta_and_d(self, i: int, value: Any) -> tuple[Any, Any, Any]:
        """Return cosine and sine of theta, and d, in the table row of joint i (from 0)."""
        if self.is_revolute[i]:
            return self.context.cos(value), self.context.sin(value), self._fixed[i]
        return (*self._fixed[i], value)

    def _jacobian_column(self, i: int, z: Vector, point: Vector, origin: Vector) -> Vector:
        """Return the column of the Jacobian for joint i (from 0), whose axis has direction z and contains `origin`."""
        zero_vector = [self.context.zero] * 3
        if not self.is_revolute[i]:
            return [*(z if i < self._frame else zero_vector), *zero_vector]
        r = [p - o for p, o in zip(point, origin, strict=True)]
        cross = [z[1] * r[2] - z[2] * r[1], z[2] * r[0] - z[0] * r[2], z[0] * r[1] - z[1] * r[0]]
        return [*(cross if i < self._frame else zero_vector), *z]


def evaluate_in_context(value: sp.Expr, context: Any = PRECISE_CONTEXT) -> Any:
    """Evaluate an exact number in the arithmetic of a context."""
    return context.mpf(str(sp.N(value, DIGITS + 6)))


def round_to_ten_digits(value: Any) -> sp.Float:
    """Round a precise number to ten digits, as it is stored in a problem: the same on every machine.

    >>> round_to_ten_digits(PRECISE_CONTEXT.mpf(1) / 3)
    0.3333333333
    """
    if abs(value) < 1e-20:
        return sp.Float(0, 10)
    return sp.Float(PRECISE_CONTEXT.nstr(value, DIGITS - 5), 10)


def round_to_four_digits(value: Any) -> sp.Float:
    """Round a number to four digits, as worked solutions show it.

    >>> round_to_four_digits(PRECISE_CONTEXT.mpf(2) / 3)
    0.6667000000
    """
    return sp.Float(0, 10) if abs(value) < 1e-12 else sp.Float(PRECISE_CONTEXT.nstr(value, 4), 10)


def round_matrix(rows: Sequence[Vector]) -> sp.Matrix:
    """Round the entries of a matrix to four digits, as worked solutions show it."""
    return sp.Matrix([[round_to_four_digits(value) for value in row] for row in rows])


def solve_linear(matrix: Sequence[Vector], right_side: Sequence[Any]) -> Vector:
    """Solve matrix x = right for a square matrix, by elimination with row pivots.

    Raises ZeroDivisionError if the matrix is singular.
    """
    n = len(matrix)
    rows, _ = _triangularize([[*row, value] for row, value in zip(matrix, right_side, strict=True)])
    solution: Vector = [None] * n
    for k in reversed(range(n)):
        known_sum = sum(rows[k][j] * solution[j] for j in range(k + 1, n))
        solution[k] = (rows[k][n] - known_sum) / rows[k][k]
    return solution


def inverse(matrix: Sequence[Vector]) -> list[Vector]:
    """Return the inverse of a square matrix as rows. Raises ZeroDivisionError if the matrix is singular."""
    n = len(matrix)
    columns = [solve_linear(matrix, [int(i == k) for i in range(n)]) for k in range(n)]
    return [list(row) for row in zip(*columns, strict=True)]


def determinant(matrix: Sequence[Vector]) -> Any:
    """Return the determinant of a square matrix, by elimination with row pivots."""
    rows, product = _triangularize([list(row) for row in matrix])
    for k, row in enumerate(rows):
        product = product * row[k]
    return product


def _triangularize(rows: list[Vector]) -> tuple[list[Vector], int]:
    """Eliminate the entries below the diagonal; return the rows, and the sign of the row swaps.

    The pivot is the largest entry of its column.
    """
    n, sign = len(rows), 1
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(rows[i][k]))
        if pivot != k:
            rows[k], rows[pivot], sign = rows[pivot], rows[k], -sign
        for i in range(k + 1, n):
            factor = rows[i][k] / rows[k][k] if rows[i][k] != 0 else 0
            rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k], strict=True)]
    return rows, sign


def gram_matrix(matrix: Sequence[Vector]) -> list[Vector]:
    """Return the matrix times its transpose."""
    return [[sum(a * b for a, b in zip(first, second, strict=True)) for second in matrix] for first in matrix]


def _rotate(x: Vector, y: Vector, cos: Any, sin: Any) -> tuple[Vector, Vector]:
    """Rotate two perpendicular unit vectors in their plane."""
    pairs = list(zip(x, y, strict=True))
    return [cos * a + sin * b for a, b in pairs], [cos * b - sin * a for a, b in pairs]


def _translate(start: Vector, direction: Vector, distance: Any) -> Vector:
    """Return the point at distance `distance` from `start` in the direction `direction`."""
    return [a + distance * b for a, b in zip(start, direction, strict=True)]
