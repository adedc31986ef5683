"""The standard (distal) table of an arm that is written in any convention; the axes of an arm at home.

What the first row of a modified table has of `alpha` and `a` is the base's in the standard table.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from qdot.exercises.arm.axes_to_dh import EXACT, HOME, NEAR, Axis, Pose, exactly, neat, reached, stood_on, table_of_axes
from qdot.exercises.arm.chain import Base, Chain, Joint, Point
from qdot.exercises.arm.conventions import REGISTRY
from qdot.exercises.arm.conventions.base import FRAMES, Convention
from qdot.exercises.arm.kinematics import NumericChain, frames_and_point
from qdot.exercises.arm.trigonometry import without_arctangents
from qdot.exercises.arm.vectors import rot_x, rot_z
from qdot.exercises.common.stream import Stream

TABLES = tuple(name for name, convention in REGISTRY.items() if FRAMES in convention.has)
"""The conventions that are tables."""


@dataclass(frozen=True)
class Row:
    """A row as it is written: what turns and slides about z, along z and x and about x; is the variable `reversed`?

    Of theta of a revolute joint, and d of a prismatic one, it is what is added to the variable.
    """

    kind: str
    theta: sp.Expr
    d: sp.Expr
    a: sp.Expr
    alpha: sp.Expr
    reversed: bool = False

    def written(self, own: sp.Symbol) -> tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr]:
        """Return theta, d, a and alpha as they are written, with the joint's own variable."""
        moving = -own if self.reversed else own
        theta, d = (self.theta + moving, self.d) if self.kind == "R" else (self.theta, self.d + moving)
        return theta, d, self.a, self.alpha


UPSIDE_DOWN = Pose(rot_x(sp.pi), sp.zeros(3, 1))
"""How the frame of a joint that counts the other way is moved."""
SHORT = 40
"""Operations that a coordinate of an axis may have to be told as it is."""

Placed = tuple[Base, tuple[Joint, ...], Point | None]


def standard(rows: Sequence[Row], base: Pose = HOME, point: Point | None = None) -> Placed:
    """Return base, table and point of an arm by rows of the standard table, some of whose variables may be reversed.

    Rz(-q) is Rx(pi) Rz(q) Rx(-pi): what turns the other way turns about an axis the other way up. A base has no turn
    about its own z axis: that is joint 1's. The point is told in its frame as that stands in the end.
    """
    rows = list(rows)
    for i, row in enumerate(rows):
        if row.reversed:
            rows[i] = replace(row, theta=-row.theta, d=-row.d, alpha=in_one_turn(row.alpha - sp.pi))
            if i:
                rows[i - 1] = replace(rows[i - 1], alpha=in_one_turn(rows[i - 1].alpha + sp.pi))
            else:
                base = base @ UPSIDE_DOWN
            point = _with_frame_moved(point, i, UPSIDE_DOWN)
    placed, turned = (Base(), sp.S.Zero) if base == HOME else stood_on(base)
    rows[0] = replace(rows[0], theta=rows[0].theta + turned)
    joints = []
    for number, row in enumerate(rows, 1):
        turn, slide = (1, 0) if row.kind == "R" else (0, 1)
        theta, d = row.theta + turn * sp.Symbol(f"theta{number}"), row.d + slide * sp.Symbol(f"d{number}")
        joints.append(Joint(row.kind, theta, d, row.a, row.alpha))
    return placed, tuple(joints), _with_frame_moved(point, 0, Pose(rot_z(-turned), sp.zeros(3, 1)))


def modified(rows: Sequence[Row], base: Pose = HOME, point: Point | None = None) -> Placed:
    """Return base, table and point of an arm by rows of the modified table, whose alpha and a stand before their joint.

    So do its frames; those of the standard table stand behind them.
    """
    links = [Pose(rot_x(row.alpha), sp.Matrix([row.a, 0, 0])) for row in rows]
    behind = [(row.a, row.alpha) for row in rows[1:]] + [(sp.S.Zero, sp.S.Zero)]
    shifted = [replace(row, a=a, alpha=alpha) for row, (a, alpha) in zip(rows, behind, strict=True)]
    for i, link in enumerate(links):
        point = _with_frame_moved(point, i, link)
    return standard(shifted, base if links[0] == HOME else base @ links[0], point)


def _with_frame_moved(point: Point | None, frame: int, moved: Pose) -> Point | None:
    """Return a point as its frame tells it once that is moved by a pose; as it is where another frame is moved."""
    if point is None or point.frame != frame:
        return point
    x, y, z = moved.rotation.T * (sp.Matrix(point.offset) - moved.origin)
    return Point(frame, (x, y, z))


def by_axes(axes: Sequence[Axis], point: sp.Matrix, link: int) -> tuple[Base, tuple[Joint, ...], Point | None]:
    """Return base, standard table and point of interest, which is on the link behind so many joints.

    Raises RuntimeError unless the table leads where the axes do.
    """
    base, joints, tool = table_of_axes(axes, point)
    if link < len(axes):
        whole = Chain("axes", joints, ("vx",), base)
        frame, home = frames_and_point(whole)[0][link], dict.fromkeys(whole.q, sp.S.Zero)
        offset = frame.rotation.xreplace(home).T * (point - frame.origin.xreplace(home))
        x, y, z = offset.applyfunc(exactly)
        tool = Point(link, (x, y, z))
    _check(Chain("axes", joints, ("vx",), base, tool), axes, point, link)
    return base, joints, tool


def _check(chain: Chain, axes: Sequence[Axis], point: sp.Matrix, link: int) -> None:
    """Raise RuntimeError unless a chain leads its point, and points beside it on the same link, where its axes do."""
    stream = Stream("axes")
    letters = sorted(set(point.free_symbols).union(*(axis.point.free_symbols for axis in axes)), key=str)
    for _ in range(3):
        q = np.array([stream.uniform(-2, 2) for _ in axes])
        lengths = {symbol: sp.Float(stream.uniform(0.3, 2)) for symbol in letters}
        arm = NumericChain(chain, {symbol.name: float(value) for symbol, value in lengths.items()})
        frames, home = arm.frames(q), arm.frames(0 * q)
        turned = frames[link, :3, :3] @ home[link, :3, :3].T
        for beside in np.vstack([np.zeros(3), np.eye(3)]):
            there = reached(axes[:link], point + sp.Matrix(beside), q[:link], lengths)
            if not np.allclose(arm.point_of(frames) + turned @ beside, there, atol=1e-7):
                raise RuntimeError(f"the table of {chain} does not lead where its axes do; please report this")


def axes_of(chain: Chain) -> tuple[list[Axis], sp.Matrix]:
    """Return the axes of an arm at home, and where its point of interest is then (3 x 1, m); world frame.

    A revolute joint's axis is told by the point that the arm's file names on it, else by the origin of its frame.
    """
    home = dict.fromkeys(chain.q, sp.S.Zero)
    frames, point = frames_and_point(chain)

    def at_home(vector: sp.Matrix) -> sp.Matrix:
        return vector.xreplace(home).applyfunc(without_arctangents).applyfunc(_short)

    axes = [
        Axis(joint.kind, at_home(frame.rotation[:, 2]), at_home(frame.origin))
        for joint, frame in zip(chain.joints, frames, strict=False)
    ]
    for i, named in enumerate(chain.axis_points):
        if named is not None and _is_on(axes[i], sp.Matrix(named)):
            axes[i] = replace(axes[i], point=sp.Matrix(named))
    return axes, at_home(point)


def _is_on(axis: Axis, point: sp.Matrix) -> bool:
    """Whether a point lies on an axis, whatever its open lengths are, as far as descriptions are exact."""
    aside = [neat(entry) for entry in axis.direction.cross(point - axis.point)]
    return all(abs(number) < NEAR for entry in aside for number in _numbers(entry))


def _numbers(total: sp.Expr) -> list[sp.Expr]:
    """Return the numbers before the terms of a sum."""
    return [term.as_coeff_Mul()[0] for term in sp.Add.make_args(total)]


def _short(entry: sp.Expr) -> sp.Expr:
    """Return an entry as it is where it is short, as 17 sqrt(2)/40 - 1/20, else its numbers as what they are nearly.

    A sum with the sine of a number is not short: 0.52 - 0.49 sin(0.3) is 0.3751998993.
    """
    plain = sp.expand(entry)
    is_short = sp.count_ops(plain) <= SHORT and not (plain.is_Add and any(_constant(plain)))
    return plain if is_short else exactly(entry)


def _constant(entry: sp.Expr) -> list[sp.Expr]:
    return [wave for wave in entry.atoms(sp.sin, sp.cos) if not wave.free_symbols]


# --- what is rounded ---


def axes_of_rows(rows: Sequence[Row], base: Pose, convention: type[Convention]) -> list[Axis]:
    """Return the axes of an arm at home as the rows of a table lead to them, world frame."""
    axes, pose = [], base
    for row in rows:
        for axis, angle, length in convention.steps(row):
            if axis == "x":
                pose = pose @ Pose(rot_x(angle), sp.Matrix([length, 0, 0]))
            else:
                axes.append(Axis(row.kind, pose.rotation[:, 2], pose.origin))
                pose = pose @ Pose(rot_z(angle), sp.Matrix([0, 0, length]))
    return axes


def is_rounded(chain: Chain, told: Sequence[Axis], point: sp.Matrix | None = None) -> bool:
    """Whether an arm has its axes, and its point, at home only nearly where they are told: numbers are rounded.

    Lengths that are open have some values there.
    """
    draws = Stream("rounded")
    values = {symbol: sp.Rational(3000 + draws.below(9000), 10007) for symbol in chain.parameters}
    values |= dict.fromkeys(chain.q, sp.S.Zero)
    base, offset = chain.base, chain.point.offset
    pose = Pose(rot_z(base.yaw) * rot_x(base.tilt), sp.Matrix(base.position).xreplace(values)) @ HOME
    frames = [pose]
    for joint in chain.joints:
        theta, d, a, alpha = (value.xreplace(values) for value in (joint.theta, joint.d, joint.a, joint.alpha))
        pose = pose @ Pose(rot_z(theta), sp.Matrix([0, 0, d])) @ Pose(rot_x(alpha), sp.Matrix([a, 0, 0]))
        frames.append(pose)
    off: list[sp.Expr] = []
    for axis, frame in zip(told, frames, strict=False):
        z, through = frame.rotation[:, 2], axis.point.xreplace(values)
        off += [
            *z.cross(axis.direction.xreplace(values)),
            *(z.cross(frame.origin - through) if axis.kind == "R" else ()),
        ]
    if point is not None:
        there = frames[chain.point.frame] @ Pose(sp.eye(3), sp.Matrix(offset).xreplace(values))
        off += list(there.origin - point.xreplace(values))
    return any(abs(neat(entry)) > EXACT for entry in off)


def in_one_turn(angle: sp.Expr) -> sp.Expr:
    """Return an angle in (-pi, pi] where it is a number, by adding whole turns."""
    angle = sp.expand(angle)
    turns = angle / (2 * sp.pi)
    if not turns.is_Rational:
        return angle
    rest = turns - sp.floor(turns)
    return 2 * sp.pi * (rest if rest <= sp.Rational(1, 2) else rest - 1)
