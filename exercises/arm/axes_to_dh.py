"""Compute poses, and the standard DH table of an arm that is described by its joint axes.

Numbers are computed with 60 digits, which is faster than nested roots. Then exact values are recognised: an angle as a
multiple of pi/12 or an arctangent, a length as a fraction or the root of one. Other numbers are rounded.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import mpmath
import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Base, Joint, Point
from qdot.exercises.arm.vectors import rot_x, rot_z

ZERO_TOLERANCE = sp.Float("1e-9")
"""Tolerance for zero and for multiples of pi/12, because the numbers that users write are rounded."""
EXACT_TOLERANCE, _ROUNDING_ERROR, _WORKING_DIGITS = sp.Float("1e-45"), sp.Float("1e-50"), 60
"""The tolerance for recognising an exact number, the size below which a number is a rounding error of zero, and the
number of digits of computations."""
_SHOWN_DECIMALS = 10
"""Number of decimals to which a number without a simple form is rounded."""
_MAX_DENOMINATOR, _MAX_SQUARE_DENOMINATOR = 10**8, 10**16
"""The largest denominators of a fraction that is not a decimal, and of a fraction under a root: lengths along an axis
(1, 2, 3) or (0, 3, 4) have large ones. With 45 matching digits, neither is a coincidence.
"""
_MAX_SUM_COEFFICIENT = 10**4
"""The largest whole-number coefficient in a combination of 1 and the roots of 2, 3 and 6.

Rotations by 30 and 45 degrees produce such combinations.
"""


@dataclass(frozen=True)
class Pose:
    """The pose of a frame in another one: its rotation R (3 x 3) and its origin (3 x 1, m)."""

    rotation: sp.Matrix
    origin: sp.Matrix

    def __matmul__(self, inner: "Pose") -> "Pose":
        """Convert a pose from this frame to the outer frame."""
        origin = self.origin + self.rotation * inner.origin
        return Pose(_evaluate_matrix(self.rotation * inner.rotation), _evaluate_matrix(origin))


IDENTITY_POSE = Pose(sp.eye(3), sp.zeros(3, 1))


def make_pose(position: Sequence[sp.Expr], rpy: Sequence[sp.Expr]) -> Pose:
    """Return the pose at a position (m), rotated about fixed axes: roll about x, pitch about y, yaw about z (rad)."""
    roll, pitch, yaw = rpy
    c, s = sp.cos(pitch), sp.sin(pitch)
    about_y = sp.Matrix([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return Pose(_evaluate_matrix(rot_z(yaw) * about_y * rot_x(roll)), sp.Matrix(position))


@dataclass(frozen=True)
class Axis:
    """A joint at home: its kind, the unit vector along its axis, and a point on it (m), in the world frame."""

    kind: str
    direction: sp.Matrix
    point: sp.Matrix


# --- a base anywhere ---


def split_base_pose(pose: Pose) -> tuple[Base, sp.Expr]:
    """Split a pose with numeric angles into a base and a final rotation about its z axis (rad); return both."""
    candidates = _base_angles(pose.rotation)
    tilt, yaw, final_rotation = min(candidates, key=lambda angles: (angles[2] != 0, abs(angles[1]), -angles[0]))
    x, y, z = pose.origin.applyfunc(recognize_exact)
    return Base((x, y, z), yaw, tilt), final_rotation


def _base_angles(r: sp.Matrix) -> list[tuple[sp.Expr, sp.Expr, sp.Expr]]:
    """Return all (tilt, yaw, angle) of a rotation Rz(yaw) Rx(tilt) Rz(angle): two, or one if z_0 is vertical."""
    if is_zero(r[0, 2]) and is_zero(r[1, 2]):
        return [(sp.S.Zero if r[2, 2] > 0 else sp.pi, angle_of(r[0, 0], r[1, 0]), sp.S.Zero)]
    sine = sp.sqrt(evaluate_entry(1 - r[2, 2] ** 2))

    def angles(s: sp.Expr) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        return angle_of(r[2, 2], s), angle_of(-r[1, 2] / s, r[0, 2] / s), angle_of(r[2, 1] / s, r[2, 0] / s)

    return [angles(sine), angles(-sine)]


# --- axes ---


def table_of_axes(axes: Sequence[Axis], point: sp.Matrix) -> tuple[Base, tuple[Joint, ...], Point | None]:
    """Return base, standard table and point of interest of an arm, given its axes and that point at home (3 x 1, m).

    Frame i lies on axis i + 1, at its intersection with the common normal from axis i. The last frame is at the point,
    so None is returned for the point. If the angle of that frame is no multiple of pi/12, the point is given in the
    frame before it instead. At home, all joint variables are zero. The axis of a prismatic joint is moved to the
    preceding origin.
    """
    table_frame = _TableFrame(_base_frame(axes[0]))
    base, _ = split_base_pose(table_frame.frame)
    joints, tool = [], None
    for number, axis in enumerate(axes, 1):
        previous_frame, frame = table_frame, table_frame.frame
        next_axis = axes[number] if number < len(axes) else Axis("", frame.rotation[:, 2], point)
        step, table_frame = _next_row(previous_frame, next_axis)
        if number == len(axes) and not (12 * step.theta / sp.pi).is_Integer:
            x, y, z = _evaluate_matrix(frame.rotation.T * (point - frame.origin)).applyfunc(recognize_exact)
            step, tool = Joint("P", -previous_frame.z_rotation, 0, 0, 0), Point(number, (x, y, z))
        if axis.kind == "R":
            joints.append(Joint("R", sp.Symbol(f"theta{number}") + step.theta, step.d, step.a, step.alpha))
        else:
            joints.append(Joint("P", step.theta, sp.Symbol(f"d{number}") + step.d, step.a, step.alpha))
    return base, tuple(joints), tool


def _base_frame(axis: Axis) -> Pose:
    """Return frame 0: its origin is the first axis's point nearest to the world's origin, and x_0 is horizontal."""
    z, up = axis.direction, sp.Matrix([0, 0, 1])
    horizontal = up.cross(z)
    if _is_zero_vector(horizontal):
        x = sp.Matrix([1, 0, 0])
    else:
        x = horizontal / horizontal.norm()
        if sp.N(x[0]) < -ZERO_TOLERANCE or (is_zero(x[0]) and sp.N(x[1]) < 0):
            x = -x
    origin = sp.zeros(3, 1) if axis.kind == "P" else axis.point - axis.point.dot(z) * z
    return Pose(_evaluate_matrix(sp.Matrix.hstack(x, z.cross(x), z)), _evaluate_matrix(origin))


@dataclass(frozen=True)
class _TableFrame:
    """A frame of the table: `frame`, rotated about its z axis by an angle that depends on symbolic lengths.

    Rotations about parallel axes are added, so that roots of symbolic lengths occur only in that angle and in a
    distance.
    """

    frame: Pose
    z_rotation: sp.Expr = sp.S.Zero


def _next_row(table_frame: _TableFrame, next_axis: Axis) -> tuple[Joint, _TableFrame]:
    """Return one row of the table, without its variable, and the frame after it, whose z lies along `next_axis`."""
    frame, next_direction, next_rotation = table_frame.frame, next_axis.direction, sp.S.Zero
    x, z = frame.rotation[:, 0], frame.rotation[:, 2]
    to_next_point, normal = _evaluate_matrix(next_axis.point - frame.origin), _evaluate_matrix(z.cross(next_direction))
    if next_axis.kind == "P":
        to_next_point = sp.zeros(3, 1)
    if _is_zero_vector(normal):
        offset = _evaluate_matrix(to_next_point - to_next_point.dot(z) * z)
        d = recognize_exact(to_next_point.dot(z)) if not next_axis.kind else sp.S.Zero
        next_x, a, next_rotation = x, sp.S.Zero, table_frame.z_rotation
        if not _is_zero_vector(offset):
            next_x, a, next_rotation = _direction_and_length(offset, x, z.cross(x))
    else:
        next_x = _evaluate_matrix(normal / normal.norm())
        a = evaluate_entry(to_next_point.dot(next_x))
        d = recognize_exact((to_next_point - a * next_x).cross(next_direction).dot(normal) / normal.dot(normal))
        if _is_negative(a) or (is_zero(a) and sp.N(x.dot(next_x)) < -ZERO_TOLERANCE):
            next_x, a = -next_x, -a
        a = recognize_exact(a)
        offset = a * next_x
    theta = angle_of(x.dot(next_x), z.dot(x.cross(next_x))) + next_rotation - table_frame.z_rotation
    alpha = angle_of(z.dot(next_direction), next_x.dot(z.cross(next_direction)))
    origin = _evaluate_matrix(frame.origin + d * z + offset)
    next_pose = Pose(_evaluate_matrix(sp.Matrix.hstack(next_x, next_direction.cross(next_x), next_direction)), origin)
    return Joint("P", theta, d, a, alpha), _TableFrame(next_pose, next_rotation if alpha == 0 else -next_rotation)


def _direction_and_length(vector: sp.Matrix, x: sp.Matrix, y: sp.Matrix) -> tuple[sp.Matrix, sp.Expr, sp.Expr]:
    """Return a unit vector, a length and an angle that describe a vector perpendicular to z.

    The angle leads from the unit vector to the vector. If the ratios of the entries are numbers, the unit vector is the
    direction of the vector, and the angle is zero. Otherwise the unit vector is x, and length and angle depend on
    symbolic lengths.
    """
    first = next(entry for entry in vector if not is_zero(entry))
    ratios = _evaluate_matrix(vector / first)
    if ratios.free_symbols:
        x_component, y_component = (sp.expand(recognize_exact(vector.dot(direction))) for direction in (x, y))
        return x, sp.sqrt(x_component**2 + y_component**2), sp.atan2(y_component, x_component)
    ratio_norm = ratios.norm()
    length = evaluate_entry(first * ratio_norm)
    direction, length = (-ratios / ratio_norm, -length) if _is_negative(length) else (ratios / ratio_norm, length)
    return _evaluate_matrix(direction), recognize_exact(length), sp.S.Zero


# --- numbers ---


def is_zero(value: sp.Expr) -> bool:
    """Return whether a value is zero; a number counts as zero if it is below ZERO_TOLERANCE."""
    evaluated = evaluate_entry(value)
    return bool(evaluated == 0 if evaluated.free_symbols else abs(evaluated) < ZERO_TOLERANCE)


def evaluate_entry(value: sp.Expr) -> sp.Expr:
    """Return a value expanded, with numbers of 60 digits, and with rounding errors of zero removed."""
    value = sp.expand(sp.N(value, _WORKING_DIGITS))
    return value.xreplace({number: sp.S.Zero for number in value.atoms(sp.Float) if abs(number) < _ROUNDING_ERROR})


def recognize_exact(value: sp.Expr) -> sp.Expr:
    """Return a value with its numbers as exact fractions or roots if they can be recognised, else rounded."""
    evaluated = evaluate_entry(value)
    return evaluated.xreplace({number: _exact_number(number) for number in evaluated.atoms(sp.Float)})


def _exact_number(number: sp.Float) -> sp.Expr:
    """Return a number as a fraction, a root of a fraction or a sum of roots if it equals one, else rounded."""
    exact = _fraction(number)
    if exact is None:
        square = _fraction(number**2, _MAX_SQUARE_DENOMINATOR)
        exact = _sum_of_roots(number) if square is None else sp.sign(number) * sp.sqrt(square)
    return sp.Rational(str(round(number, _SHOWN_DECIMALS))) if exact is None else exact


def _fraction(number: sp.Float, largest: int = _MAX_DENOMINATOR) -> sp.Rational | None:
    candidates = sp.Rational(str(round(number, _SHOWN_DECIMALS))), sp.Rational(number).limit_denominator(largest)
    return next((f for f in candidates if abs(number - f.n(_WORKING_DIGITS)) < EXACT_TOLERANCE), None)


def _sum_of_roots(number: sp.Float) -> sp.Expr | None:
    roots = [sp.S.One, sp.sqrt(2), sp.sqrt(3), sp.sqrt(6)]
    with mpmath.workdps(_WORKING_DIGITS):
        values = [mpmath.mpf(value.n(_WORKING_DIGITS)) for value in (number, *roots)]
        relation = mpmath.pslq(values, tol=mpmath.mpf(10) ** -30, maxcoeff=_MAX_SUM_COEFFICIENT, maxsteps=10**4)
    if not relation or relation[0] == 0:
        return None
    return sp.Add(*(sp.Rational(-factor, relation[0]) * root for factor, root in zip(relation[1:], roots, strict=True)))


def angle_of(cosine: sp.Expr, sine: sp.Expr) -> sp.Expr:
    """Return the angle in (-pi, pi] with this numeric cosine and sine."""
    cosine, sine = evaluate_entry(cosine), evaluate_entry(sine)
    value = sp.atan2(sine, cosine).n(_WORKING_DIGITS)
    exact = sp.pi * sp.Integer(sp.floor(value * 12 / sp.pi + sp.Rational(1, 2))) / 12
    if abs(exact.n(_WORKING_DIGITS) - value) < ZERO_TOLERANCE:
        return sp.pi if exact == -sp.pi else exact
    cosine, sine = _exact_number(cosine), _exact_number(sine)
    is_exact = sp.expand(cosine**2 + sine**2) == 1
    return sp.atan2(sine, cosine) if is_exact else sp.Rational(str(round(value, _SHOWN_DECIMALS)))


def _evaluate_matrix(matrix: sp.Matrix) -> sp.Matrix:
    return matrix.applyfunc(evaluate_entry)


def _is_zero_vector(vector: sp.Matrix) -> bool:
    return all(is_zero(entry) for entry in vector)


def _is_negative(value: sp.Expr) -> bool:
    """Return whether a value is negative for all positive values of the symbolic lengths."""
    positive = {symbol: sp.Dummy(positive=True) for symbol in value.free_symbols}
    return bool(sp.expand(value.xreplace(positive)).is_negative)


# --- the same arm, numerically ---


def point_by_rotations(
    axes: Sequence[Axis], point: sp.Matrix, q: np.ndarray, lengths: dict[sp.Symbol, float]
) -> np.ndarray:
    """Return the point of interest (3, m) at q (n), by rotating it about or moving it along each axis, last axis first.

    This uses no table, so it can check one.
    """

    def numbers(vector: sp.Matrix) -> np.ndarray:
        return np.array([float(sp.N(entry.xreplace(lengths))) for entry in vector])

    position = numbers(point)
    for axis, value in reversed(list(zip(axes, q, strict=True))):
        u, o = numbers(axis.direction), numbers(axis.point)
        if axis.kind == "P":
            position = position + value * u
            continue
        arm = position - o
        rotated = arm * np.cos(value) + np.cross(u, arm) * np.sin(value) + u * (u @ arm) * (1 - np.cos(value))
        position = o + rotated
    return position
