"""Define the base class of all conventions. Its methods are for the standard table; other conventions override them.

All results are derived from the standard (distal) Denavit-Hartenberg table. A convention determines how an arm is
presented, not how it moves.
"""

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar, TypeVar

import numpy as np
import sympy as sp

from qdot.exercises.arm.vectors import rot_x, rot_z

if TYPE_CHECKING:
    from qdot.exercises.arm.chain import Base, Chain, Joint, Point
    from qdot.exercises.writing.languages import Catalogue

FRAMES, FRAMES_OF_JOINTS, SCREWS = "frames", "frames of joints", "screws"
"""The features that a convention may have. A question or a mistake may apply only to conventions with a feature.

- FRAMES: every link has a frame.
- FRAMES_OF_JOINTS: the z axis of a link's frame is the axis of the joint that moves the link.
- SCREWS: an arm is described by its joint axes at home and their screws.
"""

VELOCITY_NAMES = ("vx", "vy", "vz", "wx", "wy", "wz")
"""The components of a six-dimensional velocity, linear first (6.6)."""

NO_SIMPLE_MEANING = "these configurations have no simple geometric meaning"
"""The statement about singular configurations that have no simple description."""

Entry = TypeVar("Entry")
_ORIGIN_IN_WORDS = re.compile(r"the origin O(\d+)")


class Convention:
    """The presentation of one arm in a convention.

    The names of axes, vectors and points that its methods return are LaTeX without dollar signs.
    """

    name: ClassVar[str]
    """The name of the convention in files and in problem ids."""
    title: ClassVar[str]
    """The name of the convention in lists."""
    aliases: ClassVar[tuple[str, ...]] = ()
    """Other common names of the convention."""
    features: ClassVar[frozenset[str]] = frozenset({FRAMES})
    """The features of the convention."""
    twist_orders: ClassVar[tuple[str, ...]] = ()
    """The possible orders of omega and v in a twist, the default first; empty if the convention has one order only."""
    joint_keys: ClassVar[tuple[str, ...]] = ("kind", "theta", "d", "a", "alpha")
    """The keys of a joint in a ROBOT.toml."""
    shows_table: ClassVar[bool] = True
    """Whether students see the table from which everything is derived."""
    is_drawn_at_home: ClassVar[bool] = False
    """Whether the figure shows the arm, with its joint axes, in the configuration in which all joint variables are
    zero."""
    fixed_frame: ClassVar[str] = "w"
    """The letter of the fixed frame, in which positions and directions are expressed."""
    specific_mistakes: ClassVar[frozenset[str]] = frozenset()
    """The names of mistakes that can only happen in this convention."""
    caption: ClassVar[str] = "Denavit–Hartenberg parameters"
    """The caption of the table that describes an arm."""
    columns: ClassVar[tuple[str, ...]] = (r"\theta_i", "d_i", "a_i", r"\alpha_i")
    """The column headings of the table."""
    row_transform: ClassVar[str] = r"R_z(\theta_i)\, T_z(d_i)\, T_x(a_i)\, R_x(\alpha_i)"
    """The transform T_{i-1,i} of a row of the table."""
    row_vector: ClassVar[str] = r"[a_i \cos\theta_i, a_i \sin\theta_i, d_i]^T"
    """The vector r_i from O_{i-1} to O_i in frame i-1, in terms of the entries of a row."""
    frame_index: ClassVar[str] = "i-1"
    """The index of the frame on the axis of joint i."""
    twist_axis: ClassVar[str] = "x_i"
    """The axis about which alpha rotates z_{i-1} into z_i."""

    def __init__(self, chain: "Chain") -> None:
        self.chain = chain

    @property
    def frame_numbers(self) -> range:
        """The numbers of the frames on the base and the links."""
        return range(self.chain.n + 1)

    @property
    def is_omega_first(self) -> bool:
        """Whether the angular velocity comes first in twists."""
        return False

    @property
    def is_proximal(self) -> bool:
        """Whether the z axis of frame i is the axis of joint i; in the standard table, it is that of joint i + 1."""
        return FRAMES_OF_JOINTS in self.features

    @property
    def has_standard_frames(self) -> bool:
        """Whether the links have frames, and these are the frames of the standard table."""
        return bool(self.frame_numbers) and not self.is_proximal

    # --- table and frames ---

    @property
    def base(self) -> "Base":
        """The pose of frame O_0 in the world."""
        return self.chain.base

    @property
    def rows(self) -> "list[Joint]":
        """The rows of the table."""
        return list(self.chain.joints)

    @property
    def point(self) -> "Point":
        """The point of interest, in coordinates of the convention's frame on its link."""
        return self.chain.point

    @staticmethod
    def order_entries(theta: Entry, d: Entry, a: Entry, alpha: Entry) -> list[Entry]:
        """Return the entries of a row in the order of the table's columns."""
        return [theta, d, a, alpha]

    @staticmethod
    def split_row(row: "Joint") -> "Iterator[tuple[str, sp.Expr, sp.Expr]]":
        """Yield the axis, the angle (rad) and the length (m) of both screw motions of a row."""
        yield "z", row.theta, row.d
        yield "x", row.alpha, row.a

    def make_rotation(self, row: "Joint") -> sp.Matrix:
        """Return the rotation from frame i to frame i-1 (3 x 3)."""
        rotations = [rot_z(angle) if axis == "z" else rot_x(angle) for axis, angle, _ in self.split_row(row)]
        return rotations[0] * rotations[1]

    def make_link_vector(self, row: "Joint") -> sp.Matrix:
        """Return r_i, from O_{i-1} to O_i in frame i-1 (below 6.13; 3 x 1, m)."""
        return sp.Matrix([row.a * sp.cos(row.theta), row.a * sp.sin(row.theta), row.d])

    def find_distance_along_axis(self, row: "Joint") -> sp.Expr:
        """Return the distance (m) along a joint's axis from the standard origin to the convention's origin."""
        return sp.S.Zero

    def find_frame_on_axis(self, joint: int) -> int:
        """Return the number of the frame whose z axis is the axis of a joint (counted from 1)."""
        return joint - 1

    def find_step_to_standard_frame(self, frame: int) -> tuple[sp.Expr, sp.Expr]:
        """Return alpha (rad) and a (m) of the step Rx(alpha) Tx(a) from the convention's to the standard frame."""
        return sp.S.Zero, sp.S.Zero

    def convert_standard_frames(self, frames: np.ndarray, corners: np.ndarray, base_origin: np.ndarray) -> np.ndarray:
        """Convert numeric poses of the standard frames to the poses of the convention's frames, (…, n + 1, 4, 4).

        - `frames`: the standard frames 0 to n, (…, n + 1, 4, 4).
        - `corners`: for each link i, the point at which the link bends from the axis of joint i into x_i, (…, n, 3).
        - `base_origin`: the position of O_0, (3).
        """
        return frames

    def keep_first_joints(self, joint_count: int) -> "Chain":
        """Return the arm of the first `joint_count` joints; its point of interest is the origin of its last frame."""
        return replace(self.chain, joints=self.chain.joints[:joint_count], tool=None)

    # --- names ---

    def name_axis(self, joint: int | None = None, is_at_home: bool = False) -> str:
        """Return the name of a joint's axis; without a `joint`, the name of the axis of a revolute joint i."""
        return f"z_{{{self._format_axis_index(joint)}}}"

    @property
    def prismatic_axis_name(self) -> str:
        """The name of the axis of a prismatic joint i."""
        return self.name_axis()

    def name_vector(self, joint: int | None = None) -> str:
        """Return the name of the vector from a joint's axis to the point of interest; without a `joint`, of joint i."""
        return f"p^*_{{{self._format_axis_index(joint)}}}"

    def name_typed_axis(self, joint: int) -> str:
        """Return the name of a joint's axis for answers, as students type it."""
        return f"z{self.find_frame_on_axis(joint)}"

    @property
    def axis_in_words(self) -> str:
        """The name of the axis of joint i for sentences without formulas."""
        return f"z_({self.frame_index})" if len(self.frame_index) > 1 else f"z_{self.frame_index}"

    def _format_axis_index(self, joint: int | None) -> str:
        return self.frame_index if joint is None else str(self.find_frame_on_axis(joint))

    def name_vector_start(self, joint: int, catalogue: "Catalogue") -> str:
        """Return the name of the point on a joint's axis at which the vector to the point of interest starts."""
        return f"$O_{{{self.find_frame_on_axis(joint)}}}$"

    def name_reference_frame(self, catalogue: "Catalogue") -> str:
        """Return the name of the frame in which positions and directions are expressed."""
        return catalogue.gettext("the base frame $O_0$") if self.base.is_world else catalogue.gettext("the world frame")

    def name_origin(self, frame: int) -> str | None:
        """Return the convention's name for the origin of a standard frame, such as "O_2" or "P", or None."""
        return f"O_{frame}"

    def describe_origin(self, frame: int) -> str | None:
        """Return the origin of a standard frame in words; None if the convention has no name for the origin."""
        name = self.name_origin(frame)
        return "the point" if name == "P" else name and f"the origin {name.replace('_', '')}"

    def rename_origins(self, statement: str) -> str:
        """Replace the origins of standard frames in a statement by the convention's names for these points.

        If the convention has no name for one of them, return NO_SIMPLE_MEANING.

        >>> from qdot.exercises.arm.chain import Chain, Joint
        >>> from qdot.exercises.arm.conventions import REGISTRY
        >>> joints = (Joint("R", f"theta{i}", 0, f"a{i}", 0) for i in (1, 2))
        >>> arm, statement = Chain("arm", tuple(joints), ("vx",)), "the origin O1 lies on the axis of joint 2"
        >>> [convention(arm).rename_origins(statement)[:15] for convention in REGISTRY.values()]
        ['the origin O1 l', 'the origin O2 l', "q2' lies on the"]
        """
        names = {match[0]: self.describe_origin(int(match[1])) for match in _ORIGIN_IN_WORDS.finditer(statement)}
        if None in names.values():
            return NO_SIMPLE_MEANING
        return _ORIGIN_IN_WORDS.sub(lambda match: str(names[match[0]]), statement)

    # --- twists ---

    @property
    def velocity_names(self) -> tuple[str, ...]:
        """The components of a velocity in the order of the arm's twists."""
        return (*VELOCITY_NAMES[3:], *VELOCITY_NAMES[:3]) if self.is_omega_first else VELOCITY_NAMES

    def reorder_velocity_rows(self, rows: sp.Matrix) -> sp.Matrix:
        """Reorder six rows from linear first into the order of the arm's twists, or back."""
        return rows[3:, :].col_join(rows[:3, :]) if self.is_omega_first else rows

    @property
    def twist_row_order(self) -> list[int]:
        """The indices that reorder a derived twist (omega, v) into the order of the arm's twists, or back."""
        return [0, 1, 2, 3, 4, 5] if self.is_omega_first else [3, 4, 5, 0, 1, 2]

    def reorder_twists(self, twists: sp.Matrix) -> sp.Matrix:
        """Reorder twists (omega, v), 6 x n, into the order of the arm's twists."""
        return twists.extract(self.twist_row_order, list(range(twists.cols)))
