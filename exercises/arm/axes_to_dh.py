"""Poses, and arms that are given by where their joint axes lie: the standard table of the same arm.

Numbers are worked with in 60 digits here, which is quicker than roots of roots, and told in the end as what they are:
an angle as a multiple of pi/12 or an arctangent, a length as a fraction or the root of one, else rounded.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import mpmath
import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Base, Joint, Point
from qdot.exercises.arm.vectors import rot_x, rot_z

NEAR = sp.Float("1e-9")
"""Below this a number is taken for zero, and an angle for a multiple of pi/12: descriptions are rounded."""
EXACT, _DUST, _PLACES = sp.Float("1e-45"), sp.Float("1e-50"), 60
"""How well a number has to be met that is told as such, what is left of one that is zero, and digits worked with."""
_DIGITS = 10
"""Decimals of a number that has no simple form."""
_SMALL, _SMALL_SQUARE = 10**8, 10**16
"""The greatest denominators of a fraction that is no decimal, and of one whose root a number is: lengths along an axis
(1, 2, 3) or (0, 3, 4) have large ones. Met to 45 digits, neither is a chance.
"""
_SUMS = 10**4
"""The greatest whole number in a sum of 1 and the roots of 2, 3 and 6, as turns by 30 and 45 degrees make them."""


@dataclass(frozen=True)
class Pose:
    """Where a frame stands in another: its rotation R (3 x 3) and its origin (3 x 1, m)."""

    rotation: sp.Matrix
    origin: sp.Matrix

    def __matmul__(self, inner: "Pose") -> "Pose":
        """Return a pose that is told in this frame, as the outer frame sees it."""
        origin = self.origin + self.rotation * inner.origin
        return Pose(_plain(self.rotation * inner.rotation), _plain(origin))


HOME = Pose(sp.eye(3), sp.zeros(3, 1))


def pose_of(position: Sequence[sp.Expr], rpy: Sequence[sp.Expr]) -> Pose:
    """Return the pose at a position (m), turned about outer axes: roll about x, pitch about y, yaw about z (rad)."""
    roll, pitch, yaw = rpy
    c, s = sp.cos(pitch), sp.sin(pitch)
    about_y = sp.Matrix([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return Pose(_plain(rot_z(yaw) * about_y * rot_x(roll)), sp.Matrix(position))


@dataclass(frozen=True)
class Axis:
    """A joint at home: its kind, the unit vector along its axis, and a point on it (m), in the world frame."""

    kind: str
    direction: sp.Matrix
    point: sp.Matrix


# --- a base anywhere ---


def stood_on(pose: Pose) -> tuple[Base, sp.Expr]:
    """Return the base that stands at a pose but for a last turn about its z axis, and that turn (rad).

    The pose's angles are numbers.
    """
    tilt, yaw, turn = min(_turns(pose.rotation), key=lambda turns: (turns[2] != 0, abs(turns[1]), -turns[0]))
    x, y, z = pose.origin.applyfunc(exactly)
    return Base((x, y, z), yaw, tilt), turn


def _turns(r: sp.Matrix) -> list[tuple[sp.Expr, sp.Expr, sp.Expr]]:
    """Return the two ways of turning a frame as Rz(yaw) Rx(tilt) Rz(turn): (tilt, yaw, turn); one if z_0 is upright."""
    if is_zero(r[0, 2]) and is_zero(r[1, 2]):
        return [(sp.S.Zero if r[2, 2] > 0 else sp.pi, angle_of(r[0, 0], r[1, 0]), sp.S.Zero)]
    size = sp.sqrt(neat(1 - r[2, 2] ** 2))
    return [
        (angle_of(r[2, 2], s), angle_of(-r[1, 2] / s, r[0, 2] / s), angle_of(r[2, 1] / s, r[2, 0] / s))
        for s in (size, -size)
    ]


# --- axes ---


def table_of_axes(axes: Sequence[Axis], point: sp.Matrix) -> tuple[Base, tuple[Joint, ...], Point | None]:
    """Return base, standard table and point of interest of an arm by its axes and that point at home (3 x 1, m).

    Frame i lies on axis i + 1, where the common normal from axis i meets it, and the last at the point, so that None is
    returned for that; where the angle to it would be none that one can read, the point is told in the frame before it.
    Home is where all joint variables are zero. An axis along which a joint slides may be moved aside: it goes through
    the origin before it.
    """
    stand = _Stand(_first(axes[0]))
    base, _ = stood_on(stand.frame)
    joints, tool = [], None
    for number, axis in enumerate(axes, 1):
        before, along = stand, stand.frame.rotation[:, 2]
        step, stand = _step(before, axes[number] if number < len(axes) else Axis("", along, point))
        if number == len(axes) and not (12 * step.theta / sp.pi).is_Integer:
            x, y, z = _plain(before.frame.rotation.T * (point - before.frame.origin))
            step, tool = Joint("P", -before.turn, 0, 0, 0), Point(number, (exactly(x), exactly(y), exactly(z)))
        if axis.kind == "R":
            joints.append(Joint("R", sp.Symbol(f"theta{number}") + step.theta, step.d, step.a, step.alpha))
        else:
            joints.append(Joint("P", step.theta, sp.Symbol(f"d{number}") + step.d, step.a, step.alpha))
    return base, tuple(joints), tool


def _first(axis: Axis) -> Pose:
    """Return frame O_0: on the first axis nearest to the world's origin, its x_0 level."""
    z, up = axis.direction, sp.Matrix([0, 0, 1])
    level = up.cross(z)
    if _is_none(level):
        x = sp.Matrix([1, 0, 0])
    else:
        x = level / level.norm()
        if sp.N(x[0]) < -NEAR or (is_zero(x[0]) and sp.N(x[1]) < 0):
            x = -x
    origin = sp.zeros(3, 1) if axis.kind == "P" else axis.point - axis.point.dot(z) * z
    return Pose(_plain(sp.Matrix.hstack(x, z.cross(x), z)), _plain(origin))


@dataclass(frozen=True)
class _Stand:
    """Where a frame of the table stands: as `frame`, turned about its z by an angle in which lengths are open.

    Turns about parallel axes add up, so that roots of open lengths stand nowhere but in that angle and in a distance.
    """

    frame: Pose
    turn: sp.Expr = sp.S.Zero


def _step(stand: _Stand, following: Axis) -> tuple[Joint, _Stand]:
    """Return one row of the table, without its variable, and the frame behind it, whose z lies along an axis."""
    frame, ahead, turn = stand.frame, following.direction, sp.S.Zero
    x, z = frame.rotation[:, 0], frame.rotation[:, 2]
    gap, normal = _plain(following.point - frame.origin), _plain(z.cross(ahead))
    if following.kind == "P":
        gap = sp.zeros(3, 1)
    if _is_none(normal):
        aside = _plain(gap - gap.dot(z) * z)
        d = exactly(gap.dot(z)) if not following.kind else sp.S.Zero
        turned, a, turn = (x, sp.S.Zero, stand.turn) if _is_none(aside) else _split(aside, x, z.cross(x))
    else:
        turned = _plain(normal / normal.norm())
        a = neat(gap.dot(turned))
        d = exactly((gap - a * turned).cross(ahead).dot(normal) / normal.dot(normal))
        if _is_negative(a) or (is_zero(a) and sp.N(x.dot(turned)) < -NEAR):
            turned, a = -turned, -a
        a = exactly(a)
        aside = a * turned
    theta = angle_of(x.dot(turned), z.dot(x.cross(turned))) + turn - stand.turn
    alpha = angle_of(z.dot(ahead), turned.dot(z.cross(ahead)))
    origin = _plain(frame.origin + d * z + aside)
    behind = Pose(_plain(sp.Matrix.hstack(turned, ahead.cross(turned), ahead)), origin)
    return Joint("P", theta, d, a, alpha), _Stand(behind, turn if alpha == 0 else -turn)


def _split(vector: sp.Matrix, x: sp.Matrix, y: sp.Matrix) -> tuple[sp.Matrix, sp.Expr, sp.Expr]:
    """Return a vector square to z as a unit vector, its length, and by what angle it is turned from the unit vector.

    The length of one of numbers, with what is open in it, if it can be; else the angle is that from x, lengths being
    open in it, and the length the root that its cosine and sine are over.
    """
    first = next(entry for entry in vector if not is_zero(entry))
    ratios = _plain(vector / first)
    if ratios.free_symbols:
        along, across = (sp.expand(exactly(vector.dot(one))) for one in (x, y))
        return x, sp.sqrt(along**2 + across**2), sp.atan2(across, along)
    size = ratios.norm()
    length = neat(first * size)
    turned, length = (-ratios / size, -length) if _is_negative(length) else (ratios / size, length)
    return _plain(turned), exactly(length), sp.S.Zero


# --- numbers ---


def is_zero(value: sp.Expr) -> bool:
    """Tell whether a value is zero, a number as far as descriptions are exact."""
    found = neat(value)
    return bool(found == 0 if found.free_symbols else abs(found) < NEAR)


def neat(value: sp.Expr) -> sp.Expr:
    """Return a value multiplied out, its numbers in 60 digits, without what is left of those that are zero."""
    value = sp.expand(sp.N(value, _PLACES))
    return value.xreplace({number: sp.S.Zero for number in value.atoms(sp.Float) if abs(number) < _DUST})


def exactly(value: sp.Expr) -> sp.Expr:
    """Return a value with its numbers as what they are, else rounded."""
    found = neat(value)
    return found.xreplace({number: _told(number) for number in found.atoms(sp.Float)})


def _told(number: sp.Float) -> sp.Expr:
    """Return a number as the fraction or the root of a fraction that it is, else rounded."""
    found = _fraction(number)
    if found is None:
        square = _fraction(number**2, _SMALL_SQUARE)
        found = _sum_of_roots(number) if square is None else sp.sign(number) * sp.sqrt(square)
    return sp.Rational(str(round(number, _DIGITS))) if found is None else found


def _fraction(number: sp.Float, largest: int = _SMALL) -> sp.Rational | None:
    exact = sp.Rational(number)
    for found in (sp.Rational(str(round(number, _DIGITS))), exact.limit_denominator(largest)):
        if abs(number - found.n(_PLACES)) < EXACT:
            return found
    return None


def _sum_of_roots(number: sp.Float) -> sp.Expr | None:
    roots = [sp.S.One, sp.sqrt(2), sp.sqrt(3), sp.sqrt(6)]
    with mpmath.workdps(_PLACES):
        values = [mpmath.mpf(value.n(_PLACES)) for value in (number, *roots)]
        found = mpmath.pslq(values, tol=mpmath.mpf(10) ** -30, maxcoeff=_SUMS, maxsteps=10**4)
    if not found or found[0] == 0:
        return None
    return sp.Add(*(sp.Rational(-factor, found[0]) * root for factor, root in zip(found[1:], roots, strict=True)))


def angle_of(cosine: sp.Expr, sine: sp.Expr) -> sp.Expr:
    """Return the angle in (-pi, pi] by its cosine and sine, which are numbers."""
    cosine, sine = neat(cosine), neat(sine)
    value = sp.atan2(sine, cosine).n(_PLACES)
    exact = sp.pi * sp.Integer(sp.floor(value * 12 / sp.pi + sp.Rational(1, 2))) / 12
    if abs(exact.n(_PLACES) - value) < NEAR:
        return sp.pi if exact == -sp.pi else exact
    cosine, sine = _told(cosine), _told(sine)
    return sp.atan2(sine, cosine) if sp.expand(cosine**2 + sine**2) == 1 else sp.Rational(str(round(value, _DIGITS)))


def _plain(matrix: sp.Matrix) -> sp.Matrix:
    return matrix.applyfunc(neat)


def _is_none(vector: sp.Matrix) -> bool:
    return all(is_zero(entry) for entry in vector)


def _is_negative(value: sp.Expr) -> bool:
    """Tell whether a value is below zero, lengths that are open being positive."""
    positive = {symbol: sp.Dummy(positive=True) for symbol in value.free_symbols}
    return bool(sp.expand(value.xreplace(positive)).is_negative)


# --- the same arm, in numbers ---


def reached(axes: Sequence[Axis], point: sp.Matrix, q: np.ndarray, lengths: dict[sp.Symbol, float]) -> np.ndarray:
    """Return where the point of interest is (3, m) at q (n), by turning and sliding it along each axis, the last first.

    It is a way that knows no table, by which one that was made is checked.
    """

    def numbers(vector: sp.Matrix) -> np.ndarray:
        return np.array([float(sp.N(entry.xreplace(lengths))) for entry in vector])

    place = numbers(point)
    for axis, value in reversed(list(zip(axes, q, strict=True))):
        u, o = numbers(axis.direction), numbers(axis.point)
        if axis.kind == "P":
            place = place + value * u
            continue
        arm = place - o
        turned = arm * np.cos(value) + np.cross(u, arm) * np.sin(value) + u * (u @ arm) * (1 - np.cos(value))
        place = o + turned
    return place
