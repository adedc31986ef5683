"""Compute the standard DH table of an arm that is described by its joint axes at home.

Numbers are computed with 60 digits, because exact nested roots would be slow. Then exact values are recognised. An
angle may be a multiple of pi/12 or an arctangent. A length may be a fraction, the root of a fraction, or a sum of
roots. Other numbers are rounded.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import mpmath
import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Base, HasKind, Joint, Point, Triple
from qdot.exercises.arm.vectors import rot_x, rot_z

ZERO_TOLERANCE = sp.Float("1e-9")
"""Tolerance for zero and for multiples of pi/12. It is large because users round the numbers that they write."""
_DIGITS = 60
"""The number of digits of computations."""
EXACT_TOLERANCE = sp.Float("1e-45")
"""The tolerance for recognising an exact number."""
_ROUNDING_ERROR = sp.Float("1e-50")
"""A number whose absolute value is below this is a rounding error of zero."""
_ROUNDED_DECIMALS = 10
"""Number of decimals to which a number without a simple form is rounded."""
_MAX_DENOMINATOR = 10**8
"""The largest denominator of a fraction that is not a decimal; under a root, the square of this number is allowed.

Lengths along an axis with the direction (1, 2, 3) or (0, 3, 4) have large denominators. A fraction that matches 45
digits is not a coincidence.
"""
_MAX_SUM_COEFFICIENT = 10**4
"""The largest whole-number coefficient in a sum of multiples of 1 and of the roots of 2, 3 and 6.

Rotations by 30 and 45 degrees produce such sums.
"""


@dataclass(frozen=True)
class Pose:
    """The pose of a frame in an outer frame: its rotation R (3 x 3) and its origin (3 x 1, m)."""

    rotation: sp.Matrix
    origin: sp.Matrix

    def __matmul__(self, inner: "Pose") -> "Pose":
        """Convert a pose in this frame to the outer frame."""
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
class Axis(HasKind):
    """A joint's axis at home: the joint's kind, the unit vector along the axis, and a point on the axis (m).

    Direction and point are 3 x 1, in the world frame unless stated otherwise.
    """

    direction: sp.Matrix
    point: sp.Matrix


# --- the base ---


def split_base_pose(pose: Pose) -> tuple[Base, sp.Expr]:
    """Split a pose with numeric angles into a base and a rotation about the z axis of the base.

    A base alone has only yaw and tilt. Return the base, and the angle of the rotation (rad).
    """
    solutions = _find_base_angles(pose.rotation)
    yaw, tilt, z_angle = min(solutions, key=lambda angles: (angles.z_angle != 0, abs(angles.yaw), -angles.tilt))
    return Base(recognize_coordinates(pose.origin), yaw, tilt), z_angle


class _BaseAngles(NamedTuple):
    """The angles (rad) of a rotation Rz(yaw) Rx(tilt) Rz(z_angle)."""

    yaw: sp.Expr
    tilt: sp.Expr
    z_angle: sp.Expr


def _find_base_angles(r: sp.Matrix) -> list[_BaseAngles]:
    """Return the angles of a rotation matrix: two solutions, or one if z_0 is vertical."""
    if is_zero(r[0, 2]) and is_zero(r[1, 2]):
        return [_BaseAngles(compute_angle(r[0, 0], r[1, 0]), sp.S.Zero if r[2, 2] > 0 else sp.pi, sp.S.Zero)]
    sine = sp.sqrt(evaluate_entry(1 - r[2, 2] ** 2))
    return [
        _BaseAngles(
            yaw=compute_angle(-r[1, 2] / s, r[0, 2] / s),
            tilt=compute_angle(r[2, 2], s),
            z_angle=compute_angle(r[2, 1] / s, r[2, 0] / s),
        )
        for s in (sine, -sine)
    ]


# --- axes ---


def compute_table_of_axes(axes: Sequence[Axis], point: sp.Matrix) -> tuple[Base, tuple[Joint, ...], Point | None]:
    """Return base, standard table and point of interest of an arm, given its axes and the point (3 x 1, m) at home.

    The origin of frame i is the point of axis i + 1 on the common normal of the axes i and i + 1. The axis of a
    prismatic joint is first moved to the preceding origin. The last frame is usually at the point of interest; then
    None is returned for the point. If theta of the last row would not be a multiple of pi/12, the last row contains
    only the joint. Then the point is returned in the coordinates of the last frame.
    """
    table_frame = _TableFrame(_choose_base_frame(axes[0]))
    base, _ = split_base_pose(table_frame.frame)
    joints, tool = [], None
    for number, axis in enumerate(axes, 1):
        previous_frame, frame = table_frame, table_frame.frame
        # the last row leads to the point of interest, given as a point on an axis without a kind
        next_axis = axes[number] if number < len(axes) else Axis("", frame.rotation[:, 2], point)
        row, table_frame = _compute_next_row(previous_frame, next_axis)
        if number == len(axes) and not (12 * row.theta / sp.pi).is_Integer:
            row = Joint("P", -previous_frame.z_rotation, 0, 0, 0)
            tool = Point(number, recognize_coordinates(frame.rotation.T * (point - frame.origin)))
        joint = replace(row, kind=axis.kind)
        variable = sp.Symbol(f"{axis.variable_key}{number}")
        joints.append(joint.with_variable_entry(variable + joint.variable_entry))
    return base, tuple(joints), tool


def _choose_base_frame(axis: Axis) -> Pose:
    """Return frame 0, with its z axis along the first axis and a horizontal x axis.

    Its origin is the point of the first axis nearest to the world's origin, or this origin if the joint is prismatic.
    """
    z, up = axis.direction, sp.Matrix([0, 0, 1])
    horizontal = up.cross(z)
    if _is_zero_vector(horizontal):
        x = sp.Matrix([1, 0, 0])
    else:
        x = horizontal / horizontal.norm()
        if sp.N(x[0]) < -ZERO_TOLERANCE or (is_zero(x[0]) and sp.N(x[1]) < 0):
            x = -x
    origin = sp.zeros(3, 1) if axis.is_prismatic else axis.point - axis.point.dot(z) * z
    return Pose(_evaluate_matrix(sp.Matrix.hstack(x, z.cross(x), z)), _evaluate_matrix(origin))


@dataclass(frozen=True)
class _TableFrame:
    """A frame of the table: `frame`, rotated about its z axis by the angle `z_rotation`.

    If the angle depends on symbolic lengths, its rotation matrix would contain roots. Therefore it is stored
    separately. The angles of parallel axes are added, so that such roots occur only in the angle and in a distance.
    """

    frame: Pose
    z_rotation: sp.Expr = sp.S.Zero


def _compute_next_row(table_frame: _TableFrame, next_axis: Axis) -> tuple[Joint, _TableFrame]:
    """Return one row of the table, and the frame after the row; its z axis lies along `next_axis`.

    The caller adds the joint variable and sets the kind of the joint.
    """
    frame, next_direction, next_rotation = table_frame.frame, next_axis.direction, sp.S.Zero
    x, z = frame.rotation[:, 0], frame.rotation[:, 2]
    to_next_point, normal = _evaluate_matrix(next_axis.point - frame.origin), _evaluate_matrix(z.cross(next_direction))
    if next_axis.is_prismatic:
        to_next_point = sp.zeros(3, 1)
    if _is_zero_vector(normal):
        offset = _evaluate_matrix(to_next_point - to_next_point.dot(z) * z)
        # between parallel axes d is free, so it is zero; only the step to the point of interest has a given d
        d = recognize_exact(to_next_point.dot(z)) if not next_axis.kind else sp.S.Zero
        next_x, a, next_rotation = x, sp.S.Zero, table_frame.z_rotation
        if not _is_zero_vector(offset):
            next_x, a, next_rotation = _describe_vector(offset, x, z.cross(x))
    else:
        next_x = _evaluate_matrix(normal / normal.norm())
        a = evaluate_entry(to_next_point.dot(next_x))
        d = recognize_exact((to_next_point - a * next_x).cross(next_direction).dot(normal) / normal.dot(normal))
        if _is_negative(a) or (is_zero(a) and sp.N(x.dot(next_x)) < -ZERO_TOLERANCE):
            next_x, a = -next_x, -a
        a = recognize_exact(a)
        offset = a * next_x
    theta = compute_angle(x.dot(next_x), z.dot(x.cross(next_x))) + next_rotation - table_frame.z_rotation
    alpha = compute_angle(z.dot(next_direction), next_x.dot(z.cross(next_direction)))
    origin = _evaluate_matrix(frame.origin + d * z + offset)
    next_pose = Pose(_evaluate_matrix(sp.Matrix.hstack(next_x, next_direction.cross(next_x), next_direction)), origin)
    return Joint("P", theta, d, a, alpha), _TableFrame(next_pose, next_rotation if alpha == 0 else -next_rotation)


def _describe_vector(vector: sp.Matrix, x: sp.Matrix, y: sp.Matrix) -> tuple[sp.Matrix, sp.Expr, sp.Expr]:
    """Describe a vector perpendicular to z by a unit vector, the vector's length, and the angle between the two.

    If the ratios of the vector's entries are numbers, the unit vector has the direction of the vector, and the angle is
    zero. Otherwise the unit vector is x, and length and angle depend on symbolic lengths.
    """
    first_entry = next(entry for entry in vector if not is_zero(entry))
    ratios = _evaluate_matrix(vector / first_entry)
    if ratios.free_symbols:
        x_component, y_component = (sp.expand(recognize_exact(vector.dot(direction))) for direction in (x, y))
        return x, sp.sqrt(x_component**2 + y_component**2), sp.atan2(y_component, x_component)
    ratio_norm = ratios.norm()
    length = evaluate_entry(first_entry * ratio_norm)
    direction, length = (-ratios / ratio_norm, -length) if _is_negative(length) else (ratios / ratio_norm, length)
    return _evaluate_matrix(direction), recognize_exact(length), sp.S.Zero


# --- numbers ---


def is_zero(value: sp.Expr) -> bool:
    """Return whether a value is zero; a number counts as zero if its absolute value is below ZERO_TOLERANCE."""
    evaluated = evaluate_entry(value)
    return bool(evaluated == 0 if evaluated.free_symbols else abs(evaluated) < ZERO_TOLERANCE)


def evaluate_entry(value: sp.Expr) -> sp.Expr:
    """Return a value expanded, its numbers evaluated to 60 digits; rounding errors of zero are removed."""
    evaluated = sp.expand(sp.N(value, _DIGITS))
    rounding_errors = (number for number in evaluated.atoms(sp.Float) if abs(number) < _ROUNDING_ERROR)
    return evaluated.xreplace(dict.fromkeys(rounding_errors, sp.S.Zero))


def recognize_exact(value: sp.Expr) -> sp.Expr:
    """Return a value with each number replaced by an exact fraction or root if it is recognised, else rounded."""
    evaluated = evaluate_entry(value)
    return evaluated.xreplace({number: _recognize_number(number) for number in evaluated.atoms(sp.Float)})


def make_exact(matrix: sp.Matrix) -> sp.Matrix:
    """Return a matrix with exact numbers where they are recognised; other numbers are rounded."""
    return matrix.applyfunc(recognize_exact)


def recognize_coordinates(point: sp.Matrix) -> Triple:
    """Return the coordinates of a point (3 x 1), with exact numbers where these are recognised."""
    x, y, z = make_exact(point)
    return x, y, z


def _recognize_number(number: sp.Float) -> sp.Expr:
    """Return the fraction, root of a fraction or sum of roots that equals a number; if there is none, round it."""
    exact = _recognize_fraction(number)
    if exact is None:
        square = _recognize_fraction(number**2, _MAX_DENOMINATOR**2)
        exact = _recognize_sum_of_roots(number) if square is None else sp.sign(number) * sp.sqrt(square)
    return sp.Rational(str(round(number, _ROUNDED_DECIMALS))) if exact is None else exact


def _recognize_fraction(number: sp.Float, max_denominator: int = _MAX_DENOMINATOR) -> sp.Rational | None:
    """Return the decimal or the fraction that equals a number up to EXACT_TOLERANCE; None if there is none."""
    decimal, fraction = sp.Rational(str(round(number, _ROUNDED_DECIMALS))), sp.Rational(number)
    candidates = decimal, fraction.limit_denominator(max_denominator)
    return next((value for value in candidates if abs(number - value.n(_DIGITS)) < EXACT_TOLERANCE), None)


def _recognize_sum_of_roots(number: sp.Float) -> sp.Expr | None:
    """Return the sum of rational multiples of 1 and of the roots of 2, 3 and 6 that equals a number, or None."""
    roots = [sp.S.One, sp.sqrt(2), sp.sqrt(3), sp.sqrt(6)]
    with mpmath.workdps(_DIGITS):
        values = [mpmath.mpf(value.n(_DIGITS)) for value in (number, *roots)]
        # five coefficients of at most four digits would hardly match 30 digits by chance
        relation = mpmath.pslq(values, tol=mpmath.mpf(10) ** -30, maxcoeff=_MAX_SUM_COEFFICIENT, maxsteps=10**4)
    if not relation or relation[0] == 0:
        return None
    number_factor, *root_factors = relation  # number_factor * number + sum of root_factor * root = 0
    return sp.Add(*(sp.Rational(-k, number_factor) * root for k, root in zip(root_factors, roots, strict=True)))


def compute_angle(cosine: sp.Expr, sine: sp.Expr) -> sp.Expr:
    """Return the angle in (-pi, pi] with this numeric cosine and sine, rounded if no exact form is found."""
    numeric_cosine, numeric_sine = evaluate_entry(cosine), evaluate_entry(sine)
    value = sp.atan2(numeric_sine, numeric_cosine).n(_DIGITS)
    multiple = sp.pi * sp.Integer(sp.floor(value * 12 / sp.pi + sp.Rational(1, 2))) / 12
    if abs(multiple.n(_DIGITS) - value) < ZERO_TOLERANCE:
        return sp.pi if multiple == -sp.pi else multiple
    exact_cosine, exact_sine = _recognize_number(numeric_cosine), _recognize_number(numeric_sine)
    is_exact = sp.expand(exact_cosine**2 + exact_sine**2) == 1
    return sp.atan2(exact_sine, exact_cosine) if is_exact else sp.Rational(str(round(value, _ROUNDED_DECIMALS)))


def _evaluate_matrix(matrix: sp.Matrix) -> sp.Matrix:
    return matrix.applyfunc(evaluate_entry)


def _is_zero_vector(vector: sp.Matrix) -> bool:
    return all(is_zero(entry) for entry in vector)


def _is_negative(value: sp.Expr) -> bool:
    """Return whether a value is negative for all positive values of the symbolic lengths."""
    positive_symbols = {symbol: sp.Dummy(positive=True) for symbol in value.free_symbols}
    return bool(sp.expand(value.xreplace(positive_symbols)).is_negative)


# --- a check without a table ---


def move_point_along_axes(
    axes: Sequence[Axis], point: sp.Matrix, q: np.ndarray, lengths: dict[sp.Symbol, float]
) -> np.ndarray:
    """Return the position (3, m), at joint values q (n), of a point that moves with the last joint.

    `point` is the position at home.

    The point is rotated about (Rodrigues' formula) or moved along each axis, the last axis first. No table is used, so
    that the result can check a table. `lengths` maps symbolic lengths to their values.
    """

    def to_floats(vector: sp.Matrix) -> np.ndarray:
        return np.array([float(sp.N(entry.xreplace(lengths))) for entry in vector])

    position = to_floats(point)
    for axis, value in reversed(list(zip(axes, q, strict=True))):
        u, o = to_floats(axis.direction), to_floats(axis.point)
        if axis.is_prismatic:
            position = position + value * u
            continue
        r = position - o
        position = o + r * np.cos(value) + np.cross(u, r) * np.sin(value) + u * (u @ r) * (1 - np.cos(value))
    return position
