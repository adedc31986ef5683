"""Describe a robot arm, a serial chain, by its standard (distal) Denavit-Hartenberg table.

Frame i is fixed to link i: T_{i-1,i} = Rz(theta_i) Tz(d_i) Tx(a_i) Rx(alpha_i). The joint variable is `theta_i` for a
revolute joint (rad) and `d_i` for a prismatic joint (m). A constant, the joint offset, may be added to the variable.
Positions and directions are expressed in the world frame. `base` is the pose of frame O_0 in the world frame.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import sympy as sp

from qdot.exercises.arm.conventions import REGISTRY
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.conventions.screws import Screws
from qdot.exercises.arm.conventions.standard_dh import StandardDh
from qdot.exercises.common.errors import QdotError, make_name_error

REVOLUTE, PRISMATIC = "R", "P"
"""The two kinds of joints."""

ANGLE_PREFIXES = ("alpha", "fixed", "base_yaw", "base_tilt")
"""The prefixes of the names of constant angles in `Chain.map_entries`."""

CONVENTIONS = tuple(REGISTRY)
"""The names of the conventions in which an arm can be described."""

DEFAULT_CONVENTION = StandardDh.name
"""The convention if none is stated."""

TWIST_ORDERS = Screws.twist_orders
"""The possible orders of omega and v in a twist, for arms described by their axes."""

DEFAULT_TWIST_ORDER = TWIST_ORDERS[0]
"""The order of twists if none is stated: omega first."""

Triple = tuple[sp.Expr, sp.Expr, sp.Expr]
"""The coordinates x, y, z of a point (m), or the angles roll, pitch, yaw (rad)."""


def is_angle_symbol(symbol: sp.Symbol) -> bool:
    """Return whether a symbolic constant of an arm is an angle, such as alpha2 or beta, and not a length."""
    return symbol.name.startswith(("alpha", "beta"))


def is_joint_angle(joint: sp.Symbol) -> bool:
    """Return whether a joint variable is the angle of a revolute joint, such as theta2, and not a distance."""
    return joint.name.startswith("theta")


@dataclass(frozen=True)
class HasKind:
    """The base class of `Joint`, and of other classes that describe a joint, such as its axis at home.

    `kind` is "R" for a revolute joint, "P" for a prismatic one.
    """

    kind: str

    @property
    def is_revolute(self) -> bool:
        """Whether the joint is revolute: it rotates about its axis."""
        return self.kind == REVOLUTE

    @property
    def is_prismatic(self) -> bool:
        """Whether the joint is prismatic: it moves along its axis."""
        return self.kind == PRISMATIC

    @property
    def variable_key(self) -> str:
        """The name of the table's column that contains the joint variable."""
        return "theta" if self.is_revolute else "d"


@dataclass(frozen=True)
class Joint(HasKind):
    """One row of the table: the joint's kind, and theta (rad), d (m), a (m), alpha (rad).

    The entry theta of a revolute joint is its variable theta_i plus its offset. The entry d of a prismatic joint is its
    variable d_i plus its offset. Raises QdotError if the kind is neither "R" nor "P".

    >>> Joint("R", "theta1 + pi/2", 0, "a1", 0).theta
    theta1 + pi/2
    """

    theta: sp.Expr
    d: sp.Expr
    a: sp.Expr
    alpha: sp.Expr

    def __post_init__(self) -> None:
        if self.kind not in (REVOLUTE, PRISMATIC):
            raise QdotError(f"a joint's kind must be 'R' or 'P', not {self.kind!r}")
        for name in ("theta", "d", "a", "alpha"):
            object.__setattr__(self, name, sp.sympify(getattr(self, name)))

    @property
    def variable_entry(self) -> sp.Expr:
        """The entry that contains the joint variable: theta of a revolute joint, d of a prismatic joint."""
        return self.theta if self.is_revolute else self.d

    @property
    def fixed_entry(self) -> sp.Expr:
        """The entry theta or d that is constant: d of a revolute joint, theta of a prismatic joint."""
        return self.d if self.is_revolute else self.theta

    def with_variable_entry(self, value: sp.Expr) -> "Joint":
        """Return the joint with another value for the entry that contains the joint variable."""
        return replace(self, theta=value) if self.is_revolute else replace(self, d=value)


@dataclass(frozen=True)
class Base:
    """The pose of frame O_0 in the world: position (m), and rotation by `yaw` about z_w, then by `tilt` about x_0."""

    position: Triple = (sp.S.Zero, sp.S.Zero, sp.S.Zero)
    yaw: sp.Expr = sp.S.Zero
    tilt: sp.Expr = sp.S.Zero

    @property
    def is_world(self) -> bool:
        """Whether frame O_0 is the world frame itself."""
        return self == Base()


@dataclass(frozen=True)
class Point:
    """The point of interest, which is fixed in frame `frame` at the coordinates `offset` (m)."""

    frame: int
    offset: Triple = (sp.S.Zero, sp.S.Zero, sp.S.Zero)

    @property
    def is_origin(self) -> bool:
        """Whether the point is the origin of its frame."""
        return all(value == 0 for value in self.offset)


@dataclass(frozen=True)
class Chain:
    """A robot arm with its task.

    - `name`: the name in messages and problem ids.
    - `title`: the name that people see in headings, if it is different.
    - `joints`: the rows of the standard (distal) table.
    - `task`: the rows of the Jacobian that the task needs, some of VELOCITY_NAMES.
    - `tool`: the point of interest P; if `tool` is None, P is the origin of the last frame.
    - `convention`: how the arm is presented to people, one of CONVENTIONS. The convention determines the frames of the
      links (`compute_link_frames`), but not how the arm moves.
    - `axis_points`: for each revolute joint, a point on its axis at home, as stated in the arm's file (world frame, m);
      None for each prismatic joint. The tuple is empty if the file states no points.
    - `twist_order`: the order of omega and v in twists, one of TWIST_ORDERS, for an arm that is described by its axes.

    Home is the configuration in which all joint variables are zero.

    Raises QdotError for an invalid table or task.

    >>> Chain("mine", (Joint("R", "theta1", 0, "a1", 0), Joint("P", 0, "d2", 0, 0)), ("vx", "vy"))
    Chain(mine: RP, vx vy of frame 2)
    """

    name: str
    joints: tuple[Joint, ...]
    task: tuple[str, ...]
    base: Base = field(default_factory=Base)
    tool: Point | None = None
    title: str = ""
    convention: str = DEFAULT_CONVENTION
    axis_points: tuple[Triple | None, ...] = ()
    twist_order: str = DEFAULT_TWIST_ORDER

    def __repr__(self) -> str:
        kinds = "".join(joint.kind for joint in self.joints)
        return f"Chain({self.name}: {kinds}, {' '.join(self.task)} of frame {self.point.frame})"

    def __post_init__(self) -> None:
        if not self.joints:
            raise QdotError(f"{self.name}: an arm needs at least one joint")
        if self.convention not in CONVENTIONS:
            raise make_name_error("convention", self.convention, CONVENTIONS)
        if self.twist_order not in TWIST_ORDERS:
            raise make_name_error("order of a twist", self.twist_order, TWIST_ORDERS)
        unknown_rows = [row for row in self.task if row not in VELOCITY_NAMES]
        if unknown_rows or len(set(self.task)) != len(self.task) or not self.task:
            raise QdotError(
                f"{self.name}: task {list(self.task)}: expected some of {', '.join(VELOCITY_NAMES)}, each at most once"
            )
        if not 0 <= self.point.frame <= self.n:
            raise QdotError(f"{self.name}: there is no frame O{self.point.frame}; the last frame is O{self.n}")
        for number, joint in enumerate(self.joints, 1):
            self._check_row(number, joint)

    def _check_row(self, number: int, joint: Joint) -> None:
        """Raise QdotError if a joint variable occurs in an entry of the row that must be constant."""
        variable, subject = self.q[number - 1], f"{self.name}: joint {number}"
        for name in ("theta", "d", "a", "alpha"):
            value = getattr(joint, name)
            if name != joint.variable_key:
                if variables := value.free_symbols & set(self.q):
                    message = f"{name} = {value} contains {min(map(str, variables))}, the variable of a joint"
                    raise QdotError(f"{subject}: {message}")
            elif (value - variable).free_symbols & set(self.q):
                raise QdotError(f"{subject} ({joint.kind}): {name} is {value}, but must be {variable} plus a constant")

    @property
    def n(self) -> int:
        """The number of joints."""
        return len(self.joints)

    @property
    def point(self) -> Point:
        """The point of interest P; the origin of the last frame unless the arm has a tool."""
        return self.tool if self.tool is not None else Point(len(self.joints))

    @property
    def has_square_jacobian(self) -> bool:
        """Whether the task has as many rows as the arm has joints, so that the task Jacobian has a determinant."""
        return len(self.task) == self.n

    @cached_property
    def task_rows(self) -> list[int]:
        """The indices (from 0) of the task's rows among the rows of the 6 x n Jacobian."""
        return [VELOCITY_NAMES.index(row) for row in self.task]

    @cached_property
    def q(self) -> tuple[sp.Symbol, ...]:
        """The joint variables, theta_i or d_i."""
        return tuple(sp.Symbol(f"{joint.variable_key}{i}") for i, joint in enumerate(self.joints, 1))

    def list_joints_of_kind(self, kind: str) -> list[int]:
        """Return the indices (from 0) of the joints of a kind, "R" or "P"."""
        return [i for i, joint in enumerate(self.joints) if joint.kind == kind]

    @cached_property
    def revolute_joints(self) -> list[int]:
        """The indices (from 0) of the revolute joints."""
        return self.list_joints_of_kind(REVOLUTE)

    @cached_property
    def prismatic_joints(self) -> list[int]:
        """The indices (from 0) of the prismatic joints."""
        return self.list_joints_of_kind(PRISMATIC)

    @cached_property
    def rates(self) -> tuple[sp.Symbol, ...]:
        """The symbols qd1 ... qdn of the joint rates."""
        return tuple(sp.Symbol(f"qd{i}") for i in range(1, self.n + 1))

    @cached_property
    def offsets(self) -> tuple[sp.Expr, ...]:
        """The joint offsets: the constants that are added to the joint variables in the table."""
        return tuple(sp.expand(joint.variable_entry - q) for joint, q in zip(self.joints, self.q, strict=True))

    @property
    def linear_axes(self) -> tuple[str, ...]:
        """The axes along which the task needs the velocity of P: some of "x", "y", "z"."""
        return tuple(row[1] for row in self.task if row[0] == "v")

    @property
    def is_planar(self) -> bool:
        """Whether the arm is known to stay in one plane, parallel to the world's xy plane, in every configuration.

        Two kinds of planar arms are recognised. Either all joints are revolute, or joint 1 of two joints rotates in the
        plane and joint 2 moves along a line in the plane. For other planar arms, such as R-P-R, this is False.
        """
        if self.base.tilt not in (0, sp.pi):
            return False
        # the offset of P, rotated back by alpha about x, so that its z coordinate is along the joint's axis
        alpha = self.joints[self.point.frame - 1].alpha if self.point.frame else sp.S.Zero
        _, y, z = self.point.offset
        offset_y, offset_z = sp.cos(alpha) * y - sp.sin(alpha) * z, sp.sin(alpha) * y + sp.cos(alpha) * z
        if all(joint.alpha in (0, sp.pi) for joint in self.joints[:-1]):
            return all(joint.is_revolute and joint.d == 0 for joint in self.joints) and bool(offset_z == 0)
        if [joint.kind for joint in self.joints] != [REVOLUTE, PRISMATIC] or self.joints[0].d != 0:
            return False
        is_in_plane = self.joints[0].alpha in (sp.pi / 2, -sp.pi / 2) and self.joints[1].theta in (0, sp.pi)
        return bool(is_in_plane and offset_y == 0)

    @cached_property
    def parameters(self) -> tuple[sp.Symbol, ...]:
        """The symbolic lengths and angles in the table, base and point, sorted by name."""
        values = [v for joint in self.joints for v in (joint.theta, joint.d, joint.a, joint.alpha)]
        values += [*self.base.position, self.base.yaw, self.base.tilt, *self.point.offset]
        symbols = set().union(*(value.free_symbols for value in values)) - set(self.q)
        return tuple(sorted(symbols, key=lambda symbol: symbol.name))

    def map_entries(self, replace_entry: Callable[[str, sp.Expr], sp.Expr]) -> "Chain":
        """Return the arm with each entry of its table, base and point replaced by `replace_entry(name, entry)`.

        The names of the entries of joint 1 are theta1, d1, a1 and alpha1; the constant theta of a prismatic joint is
        called fixed1. The other names are base_x, base_y, base_z, base_yaw, base_tilt, point_x, point_y and point_z.
        """
        joints = []
        for i, joint in enumerate(self.joints, 1):
            names = ("theta" if joint.is_revolute else "fixed", "d", "a", "alpha")
            entries = zip(names, (joint.theta, joint.d, joint.a, joint.alpha), strict=True)
            joints.append(Joint(joint.kind, *(replace_entry(f"{name}{i}", entry) for name, entry in entries)))
        base, point = self.base, self.point
        x, y, z = (replace_entry(f"base_{axis}", value) for axis, value in zip("xyz", base.position, strict=True))
        base = Base((x, y, z), replace_entry("base_yaw", base.yaw), replace_entry("base_tilt", base.tilt))
        x, y, z = (replace_entry(f"point_{axis}", value) for axis, value in zip("xyz", point.offset, strict=True))
        return replace(self, joints=tuple(joints), base=base, tool=self.tool and Point(point.frame, (x, y, z)))

    def with_task(self, *rows: str) -> "Chain":
        """Return the same arm with another task."""
        return replace(self, task=tuple(rows))
