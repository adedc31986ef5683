"""Define the convention of Craig's modified (proximal) Denavit-Hartenberg tables: joint i moves frame i about z_i.

A row is Rx(alpha_{i-1}) Tx(a_{i-1}) Rz(theta_i) Tz(d_i). Rx and Tx commute, so they can be moved to the end of the
preceding row. Therefore the standard and the modified table of an arm contain the same numbers: `alpha` and `a` are in
row i of the standard table and in row i + 1 of the modified table. For the last standard row, there is no row i + 1.
Its `alpha` and `a` become part of P's coordinates in the last modified frame.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp

from qdot.exercises.arm.conventions.base import FRAMES, FRAMES_OF_JOINTS, Convention, Entry
from qdot.exercises.arm.vectors import cross

if TYPE_CHECKING:
    from qdot.exercises.arm.chain import Base, Chain, Joint, Point


class ModifiedDh(Convention):
    """A modified table, in which `a` and `alpha` of a row come before its joint."""

    name, title = "modified-dh", "modified"
    aliases = ("craig", "mdh", "proximal")
    features = frozenset({FRAMES, FRAMES_OF_JOINTS})  # each link has a frame, whose z axis is the axis of its joint
    specific_mistakes = frozenset({"standard-dh", "length-and-twist-of-link-i", "previous-frame"})
    columns = (r"\alpha_{i-1}", "a_{i-1}", "d_i", r"\theta_i")
    row_transform = r"R_x(\alpha_{i-1})\, T_x(a_{i-1})\, R_z(\theta_i)\, T_z(d_i)"
    row_vector = r"[a_{i-1}, -d_i \sin\alpha_{i-1}, d_i \cos\alpha_{i-1}]^T"
    frame_index = "i"
    twist_axis = "x_{i-1}"

    def _make_base_and_rows(self) -> "tuple[Base, list[Joint]]":
        """Return the base and the rows of the modified table.

        The tilt of the standard base about x belongs to the first row of the modified table. The shift of the base
        along x also belongs to that row, if the base has neither yaw nor another shift.
        """
        base, joints = self.chain.base, self.chain.joints
        remaining_base, first_a = replace(base, tilt=sp.S.Zero), sp.S.Zero
        if base.yaw == 0 and not any(base.position[1:]):
            remaining_base, first_a = replace(remaining_base, position=(sp.S.Zero,) * 3), base.position[0]
        links = [(base.tilt, first_a), *((joint.alpha, joint.a) for joint in joints[:-1])]
        rows = [replace(joint, alpha=alpha, a=a) for joint, (alpha, a) in zip(joints, links, strict=True)]
        return remaining_base, rows

    @property
    def base(self) -> "Base":
        """The pose of frame O_0 in the world; this frame is never tilted."""
        base, _ = self._make_base_and_rows()
        return base

    @property
    def rows(self) -> "list[Joint]":
        """The rows of the table, whose `a` and `alpha` come before their joint."""
        _, rows = self._make_base_and_rows()
        return rows

    @property
    def point(self) -> "Point":
        """The point of interest, in coordinates of the modified frame on its link."""
        point, (alpha, a) = self.chain.point, self.find_step_to_standard_frame(self.chain.point.frame)
        c, s, (x, y, z) = sp.cos(alpha), sp.sin(alpha), point.offset
        return replace(point, offset=(a + x, c * y - s * z, s * y + c * z))

    @staticmethod
    def order_entries(theta: Entry, d: Entry, a: Entry, alpha: Entry) -> list[Entry]:
        """Return the entries of a row in the order of the table's columns."""
        return [alpha, a, d, theta]

    @staticmethod
    def split_row(row: "Joint") -> "Iterator[tuple[str, sp.Expr, sp.Expr]]":
        """Yield the two screw motions of a row: about and along x, then about and along the joint's z axis."""
        yield "x", row.alpha, row.a
        yield "z", row.theta, row.d

    def make_link_vector(self, row: "Joint") -> sp.Matrix:
        """Return r_i, from O_{i-1} to O_i in frame i-1 (3 x 1, m)."""
        return sp.Matrix([row.a, -row.d * sp.sin(row.alpha), row.d * sp.cos(row.alpha)])

    def find_distance_along_axis(self, row: "Joint") -> sp.Expr:
        """Return d, the distance (m) along z_i from the standard origin O_{i-1} to the modified origin O_i."""
        return row.d

    def find_frame_on_axis(self, joint: int) -> int:
        """Return the number of the frame whose z axis is the axis of a joint: the joint's own number."""
        return joint

    def find_step_to_standard_frame(self, frame: int) -> tuple[sp.Expr, sp.Expr]:
        """Return alpha (rad) and a (m) of the step Rx(alpha) Tx(a) from a link's modified to its standard frame.

        For the base, frame 0, these are the entries of the first modified row, which tilt and shift the base.
        """
        link = self.chain.joints[frame - 1] if frame else self.rows[0]
        return link.alpha, link.a

    def convert_standard_frames(self, frames: np.ndarray, corners: np.ndarray, base_origin: np.ndarray) -> np.ndarray:
        """Convert numeric poses of the standard frames to those of the modified frames, (…, n + 1, 4, 4).

        Frame i has the x axis of standard frame i, and its z axis is the axis of joint i. Its origin is the point at
        which link i bends from this axis into x_i (`corners`, see the base class). Frame 0 is upright, at
        `base_origin`: rotations about x_0 and shifts along x_0 before joint 1 belong to the first row.
        """
        poses = np.array(frames)
        poses[..., 1:, :3, 2] = frames[..., :-1, :3, 2]
        poses[..., 0, :3, 2] = (0.0, 0.0, 1.0)
        poses[..., 1:, :3, 3], poses[..., 0, :3, 3] = corners, base_origin
        poses[..., :3, 1] = cross(poses[..., :3, 2], poses[..., :3, 0])
        return poses

    def keep_first_joints(self, joint_count: int) -> "Chain":
        """Return the arm of the first `joint_count` joints; its last row has neither `a` nor `alpha`."""
        shortened_arm = super().keep_first_joints(joint_count)
        *first_rows, last_row = shortened_arm.joints
        return replace(shortened_arm, joints=(*first_rows, replace(last_row, a=sp.S.Zero, alpha=sp.S.Zero)))

    def name_origin(self, frame: int) -> str | None:
        """Return the name of the modified origin, or of P, that always coincides with a standard origin; else None."""
        chain = self.chain
        if frame < chain.n and chain.joints[frame].is_revolute and chain.joints[frame].d == 0:
            return f"O_{frame + 1}"
        if frame == chain.point.frame and chain.point.is_origin:
            return "P"
        _, shift = self.find_step_to_standard_frame(frame)
        return f"O_{frame}" if shift == 0 else None
