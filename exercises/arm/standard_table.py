"""Convert a table in any convention, or joint axes, to the standard (distal) DH table, and the table back to axes.

In the standard table, `alpha` and `a` of the first row of a modified table belong to the base.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import sympy as sp

from qdot.exercises.arm.axes_to_dh import (
    EXACT_TOLERANCE,
    IDENTITY_POSE,
    ZERO_TOLERANCE,
    Axis,
    Pose,
    compute_table_of_axes,
    evaluate_entry,
    move_point_along_axes,
    recognize_coordinates,
    recognize_exact,
    split_base_pose,
)
from qdot.exercises.arm.chain import Base, Chain, Joint, Point
from qdot.exercises.arm.conventions.base import Convention
from qdot.exercises.arm.conventions.standard_dh import StandardDh
from qdot.exercises.arm.kinematics import NumericChain, compute_frames_and_point
from qdot.exercises.arm.trigonometry import remove_arctangents, wrap_multiple_of_pi
from qdot.exercises.arm.vectors import rot_x, rot_z
from qdot.exercises.common.stream import Stream


@dataclass(frozen=True)
class WrittenRow(Joint):
    """A row of a DH table as the user wrote it, but without its joint variable.

    The entry `theta` of a revolute joint, or `d` of a prismatic joint, is the constant that is added to the variable.
    `is_reversed` says whether the variable has a minus sign; then the joint is called reversed.
    """

    is_reversed: bool = False

    def with_variable(self, variable: sp.Symbol) -> Joint:
        """Return the row as the user wrote it, with the joint variable."""
        joint = Joint(self.kind, self.theta, self.d, self.a, self.alpha)
        return joint.with_variable_entry(self.variable_entry + (-variable if self.is_reversed else variable))


REVERSAL = Pose(rot_x(sp.pi), sp.zeros(3, 1))
"""The rotation by pi about x that is applied to the frame of a reversed joint."""
MAX_SHOWN_OPERATIONS = 40
"""Maximum number of operations in a coordinate that is shown unchanged."""

ArmTable = tuple[Base, tuple[Joint, ...], Point | None]
"""Base, standard table and point of interest of an arm; the point is None if it is the origin of the last frame."""


def convert_standard_rows(rows: Sequence[WrittenRow], base: Pose, point: Point | None) -> ArmTable:
    """Return base, standard table and point of an arm, given the rows of a standard table with reversed joints.

    The frame of a reversed joint is rotated by pi about x, because Rz(-q) = Rx(pi) Rz(q) Rx(-pi). A rotation of the
    base about its z axis is added to theta or to the variable of joint 1. The point is converted to the new frames.
    """
    new_rows, new_base, new_point = list(rows), base, point
    for i, row in enumerate(rows):
        if row.is_reversed:
            # the rotation by pi about x is added to alpha of the preceding row, and undone by alpha of this row
            new_rows[i] = WrittenRow(row.kind, -row.theta, -row.d, row.a, wrap_multiple_of_pi(row.alpha - sp.pi))
            if i:
                new_rows[i - 1] = replace(new_rows[i - 1], alpha=wrap_multiple_of_pi(new_rows[i - 1].alpha + sp.pi))
            else:
                new_base = base @ REVERSAL
            new_point = _convert_point(new_point, i, REVERSAL)
    table_base, base_rotation = (Base(), sp.S.Zero) if new_base == IDENTITY_POSE else split_base_pose(new_base)
    new_rows[0] = replace(new_rows[0], theta=new_rows[0].theta + base_rotation)
    joints = (row.with_variable(sp.Symbol(f"{row.variable_key}{number}")) for number, row in enumerate(new_rows, 1))
    return table_base, tuple(joints), _convert_point(new_point, 0, Pose(rot_z(-base_rotation), sp.zeros(3, 1)))


def convert_modified_rows(rows: Sequence[WrittenRow], base: Pose, point: Point | None) -> ArmTable:
    """Return base, standard table and point of an arm, given the rows of a modified table with reversed joints."""
    following_links = [(row.a, row.alpha) for row in rows[1:]] + [(sp.S.Zero, sp.S.Zero)]
    standard_rows = [replace(row, a=a, alpha=alpha) for row, (a, alpha) in zip(rows, following_links, strict=True)]
    motions = [Pose(rot_x(row.alpha), sp.Matrix([row.a, 0, 0])) for row in rows]  # from modified to standard frames
    standard_point = point
    for i, motion in enumerate(motions):
        standard_point = _convert_point(standard_point, i, motion)
    standard_base = base if motions[0] == IDENTITY_POSE else base @ motions[0]
    return convert_standard_rows(standard_rows, standard_base, standard_point)


def _convert_point(point: Point | None, frame: int, motion: Pose) -> Point | None:
    """Return a point's new coordinates after its frame was moved by a pose; unchanged if another frame was moved."""
    if point is None or point.frame != frame:
        return point
    x, y, z = motion.rotation.T * (sp.Matrix(point.offset) - motion.origin)
    return Point(frame, (x, y, z))


def convert_axes(axes: Sequence[Axis], point: sp.Matrix, link_number: int) -> ArmTable:
    """Return base, standard table and point of an arm, given its axes and the point of interest at home (3 x 1, m).

    The point is fixed to the link with the number `link_number`. Raises RuntimeError if table and axes move that link
    differently, which would be a bug.
    """
    base, joints, tool = compute_table_of_axes(axes, point)
    if link_number < len(axes):
        chain = Chain("axes", joints, ("vx",), base)  # the task doesn't matter
        home = dict.fromkeys(chain.q, sp.S.Zero)
        frame = compute_frames_and_point(chain).frames[link_number]
        offset = frame.rotation.xreplace(home).T * (point - frame.origin.xreplace(home))
        tool = Point(link_number, recognize_coordinates(offset))
    _check_table(Chain("axes", joints, ("vx",), base, tool), axes, point, link_number)
    return base, joints, tool


def _check_table(chain: Chain, axes: Sequence[Axis], point: sp.Matrix, link_number: int) -> None:
    """Raise RuntimeError unless the chain's table and its axes move the points of a link in the same way."""
    stream = Stream("axes")
    symbols = sorted(set(point.free_symbols).union(*(axis.point.free_symbols for axis in axes)), key=str)
    for _ in range(3):  # three random configurations
        q = np.array([stream.uniform(-2, 2) for _ in axes])
        lengths = {symbol: sp.Float(stream.uniform(0.3, 2)) for symbol in symbols}
        arm = NumericChain(chain, {symbol.name: float(value) for symbol, value in lengths.items()})
        frames, home = arm.compute_frames(q), arm.compute_frames(np.zeros_like(q))
        link_rotation = frames[link_number, :3, :3] @ home[link_number, :3, :3].T
        for displacement in np.vstack([np.zeros(3), np.eye(3)]):
            moved_point = point + sp.Matrix(displacement)
            expected_point = move_point_along_axes(axes[:link_number], moved_point, q[:link_number], lengths)
            if not np.allclose(arm.compute_point_of(frames) + link_rotation @ displacement, expected_point, atol=1e-7):
                raise RuntimeError(f"the table of {chain} does not lead where its axes do; please report this")


class HomeGeometry(NamedTuple):
    """The axes of an arm and its point of interest (3 x 1, m) at home, in the world frame."""

    axes: list[Axis]
    point: sp.Matrix


def compute_home_geometry(chain: Chain) -> HomeGeometry:
    """Return the axes and the point of interest of an arm at home.

    The point on the axis of a revolute joint is the point that the arm's file states, or the standard origin there.
    """
    home = dict.fromkeys(chain.q, sp.S.Zero)
    frames, point = compute_frames_and_point(chain)

    def evaluate_at_home(vector: sp.Matrix) -> sp.Matrix:
        return vector.xreplace(home).applyfunc(remove_arctangents).applyfunc(_simplify_coordinate)

    axes = [
        Axis(joint.kind, evaluate_at_home(frame.rotation[:, 2]), evaluate_at_home(frame.origin))
        for joint, frame in zip(chain.joints, frames, strict=False)
    ]
    for i, axis_point in enumerate(chain.axis_points):
        if axis_point is not None and _lies_on(axes[i], sp.Matrix(axis_point)):
            axes[i] = replace(axes[i], point=sp.Matrix(axis_point))
    return HomeGeometry(axes, evaluate_at_home(point))


def _lies_on(axis: Axis, point: sp.Matrix) -> bool:
    """Return whether a point lies on an axis, up to rounding, for all values of the symbolic lengths."""
    deviation = axis.direction.cross(point - axis.point)
    terms = (term for entry in deviation for term in sp.Add.make_args(evaluate_entry(entry)))
    return all(abs(term.as_coeff_Mul()[0]) < ZERO_TOLERANCE for term in terms)


def _simplify_coordinate(entry: sp.Expr) -> sp.Expr:
    """Return a coordinate expanded if it is short, such as 17 sqrt(2)/40 - 1/20, else with its numbers evaluated.

    A sum with the sine of a number counts as long: 0.52 - 0.49 sin(0.3) becomes 0.3751998993.
    """
    expanded = sp.expand(entry)
    has_numeric_trigs = expanded.is_Add and any(trig.is_number for trig in expanded.atoms(sp.sin, sp.cos))
    is_short = sp.count_ops(expanded) <= MAX_SHOWN_OPERATIONS and not has_numeric_trigs
    return expanded if is_short else recognize_exact(entry)


# --- rounding ---


def _iterate_poses_at_home(rows: Iterable[Joint], base: Pose, convention: type[Convention]) -> Iterator[Pose]:
    """Yield for each row of a table the pose before its rotation about z, and finally the pose after the last row."""
    pose = base
    for row in rows:
        for axis, angle, length in convention.split_row(row):
            if axis == "x":
                pose = pose @ Pose(rot_x(angle), sp.Matrix([length, 0, 0]))
            else:
                yield pose
                pose = pose @ Pose(rot_z(angle), sp.Matrix([0, 0, length]))
    yield pose


def compute_axes_of_rows(rows: Sequence[WrittenRow], base: Pose, convention: type[Convention]) -> list[Axis]:
    """Return the axes of an arm at home in the world frame, given the rows of a table and the pose of frame 0."""
    poses = _iterate_poses_at_home(rows, base, convention)
    return [Axis(row.kind, pose.rotation[:, 2], pose.origin) for row, pose in zip(rows, poses, strict=False)]


def is_table_rounded(chain: Chain, axes: Sequence[Axis], point: sp.Matrix | None = None) -> bool:
    """Return whether the numbers of an arm's table were rounded, given the exact axes and point at home.

    The numbers were rounded if the axes and the point that follow from the table are only nearly the exact ones. This
    is tested for one random choice of the symbolic lengths.
    """
    rng = Stream("rounded")
    # lengths from 0.3 m to 1.2 m, with a prime denominator, so that no fraction in the table cancels them
    values = {symbol: sp.Rational(3000 + rng.integer_below(9000), 10007) for symbol in chain.parameters}
    values |= dict.fromkeys(chain.q, sp.S.Zero)
    base, position = chain.base, sp.Matrix(chain.base.position).xreplace(values)
    rows = [Joint(j.kind, *(entry.xreplace(values) for entry in (j.theta, j.d, j.a, j.alpha))) for j in chain.joints]
    base_pose = Pose(rot_z(base.yaw) * rot_x(base.tilt), position) @ IDENTITY_POSE  # `@` evaluates the numbers
    poses = list(_iterate_poses_at_home(rows, base_pose, StandardDh))
    deviations: list[sp.Expr] = []
    for axis, pose in zip(axes, poses, strict=False):
        z, axis_point = pose.rotation[:, 2], axis.point.xreplace(values)
        deviations += z.cross(axis.direction.xreplace(values))
        deviations += z.cross(pose.origin - axis_point) if axis.is_revolute else ()
    if point is not None:
        point_pose = Pose(sp.eye(3), sp.Matrix(chain.point.offset).xreplace(values))
        deviations += list((poses[chain.point.frame] @ point_pose).origin - point.xreplace(values))
    return any(abs(evaluate_entry(entry)) > EXACT_TOLERANCE for entry in deviations)
