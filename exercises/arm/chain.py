"""The description of a serial chain by its standard (distal) Denavit-Hartenberg table.

Frame i is fixed to link i: T_{i-1,i} = Rz(theta_i) Tz(d_i) Tx(a_i) Rx(alpha_i). The joint variable is `theta_i` for a
revolute joint (rad) and `d_i` for a prismatic joint (m), each with an optional offset. Everything is expressed in the
world frame; `base` is the pose of frame O_0 in it.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import sympy as sp

from qdot.exercises.arm.conventions import REGISTRY
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.conventions.screws import Screws
from qdot.exercises.common.errors import QdotError, make_name_error

TASK_ROWS = VELOCITY_NAMES
"""The names of the rows of the 6 x n Jacobian, linear first (6.6)."""

ANGLE_PREFIXES = ("alpha", "fixed", "base_yaw", "base_tilt")
"""The prefixes of the names of constant angles in `Chain.map_entries`."""

CONVENTIONS = tuple(REGISTRY)
"""The names of the conventions in which an arm can be described."""

TWIST_ORDERS = Screws.twist_orders
"""The orders of a twist, for arms described by their axes."""


@dataclass(frozen=True)
class Joint:
    """One row of the table: the joint's kind "R" or "P", and theta (rad), d (m), a (m), alpha (rad).

    The entry theta (revolute) or d (prismatic) is the joint variable theta_i or d_i, plus a constant if needed. Raises
    QdotError for any other kind.

    >>> Joint("R", "theta1 + pi/2", 0, "a1", 0).theta
    theta1 + pi/2
    """

    kind: str
    theta: sp.Expr
    d: sp.Expr
    a: sp.Expr
    alpha: sp.Expr

    def __post_init__(self) -> None:
        if self.kind not in ("R", "P"):
            raise QdotError(f"a joint's kind must be 'R' or 'P', not {self.kind!r}")
        for name in ("theta", "d", "a", "alpha"):
            object.__setattr__(self, name, sp.sympify(getattr(self, name)))


@dataclass(frozen=True)
class Base:
    """The pose of frame O_0 in the world: position (m), rotated by `yaw` about z_w, then by `tilt` about the new x."""

    position: tuple[sp.Expr, sp.Expr, sp.Expr] = (sp.S.Zero, sp.S.Zero, sp.S.Zero)
    yaw: sp.Expr = sp.S.Zero
    tilt: sp.Expr = sp.S.Zero

    @property
    def is_world(self) -> bool:
        """Whether O_0 is the world frame itself."""
        return self == Base()


@dataclass(frozen=True)
class Point:
    """The point of interest, which is fixed in frame `frame` at the coordinates `offset` (m)."""

    frame: int
    offset: tuple[sp.Expr, sp.Expr, sp.Expr] = (sp.S.Zero, sp.S.Zero, sp.S.Zero)

    @property
    def is_origin(self) -> bool:
        """Whether the point is the origin of its frame."""
        return all(value == 0 for value in self.offset)


@dataclass(frozen=True)
class Chain:
    """A robot arm with its task: DH table, base, point of interest, and the rows of J that belong to the task.

    - `joints`: the rows of the standard (distal) table.
    - `task`: some of TASK_ROWS.
    - `tool`: the point of interest; if it is None, the point is the origin of the last frame.
    - `convention`: how the arm is presented to people, one of CONVENTIONS. It determines the frames of the links
      (`link_frames`), but not how the arm moves.
    - `axis_points`: for each joint, the point on its axis in the home configuration that the arm's file specifies
      (world frame, m; None for a prismatic joint). It is empty if the file specifies no points.
    - `twist_order`: the order of twists, one of TWIST_ORDERS, if the arm is described by its axes.

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
    convention: str = CONVENTIONS[0]
    axis_points: tuple[tuple[sp.Expr, sp.Expr, sp.Expr] | None, ...] = ()
    twist_order: str = TWIST_ORDERS[0]

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
        wrong = [row for row in self.task if row not in TASK_ROWS]
        if wrong or len(set(self.task)) != len(self.task) or not self.task:
            raise QdotError(
                f"{self.name}: task {list(self.task)}: expected some of {', '.join(TASK_ROWS)}, each at most once"
            )
        if not 0 <= self.point.frame <= self.n:
            raise QdotError(f"{self.name}: there is no frame O{self.point.frame}; the last frame is O{self.n}")
        for number, joint in enumerate(self.joints, 1):
            self._check_row(number, joint)

    def _check_row(self, number: int, joint: Joint) -> None:
        """Raise QdotError if joint variables occur anywhere but in their own entry."""
        variable, subject = self.q[number - 1], f"{self.name}: joint {number}"
        moving, fixed = ("theta", "d") if joint.kind == "R" else ("d", "theta")
        value = getattr(joint, moving)
        if (value - variable).free_symbols & set(self.q):
            raise QdotError(f"{subject} ({joint.kind}): {moving} is {value}, but must be {variable} plus a constant")
        for name in (fixed, "a", "alpha"):
            value = getattr(joint, name)
            clash = value.free_symbols & set(self.q)
            if clash:
                raise QdotError(f"{subject}: {name} = {value} contains {min(map(str, clash))}, the variable of a joint")

    @property
    def n(self) -> int:
        """The number of joints."""
        return len(self.joints)

    @property
    def point(self) -> Point:
        """The point of interest; the last frame's origin unless there is a tool."""
        return self.tool if self.tool is not None else Point(len(self.joints))

    @cached_property
    def task_rows(self) -> list[int]:
        """The indices (from 0) of the task's rows in the 6 x n Jacobian."""
        return [TASK_ROWS.index(row) for row in self.task]

    @cached_property
    def q(self) -> tuple[sp.Symbol, ...]:
        """The joint variables, theta_i or d_i."""
        names = (f"{'theta' if joint.kind == 'R' else 'd'}{i}" for i, joint in enumerate(self.joints, 1))
        return tuple(sp.Symbol(name) for name in names)

    @cached_property
    def rates(self) -> tuple[sp.Symbol, ...]:
        """The joint rates qd_1 ... qd_n (6.5)."""
        return tuple(sp.Symbol(f"qd{i}") for i in range(1, self.n + 1))

    @cached_property
    def offsets(self) -> tuple[sp.Expr, ...]:
        """The constants that are added to the joint variables in the table."""
        moving_values = (joint.theta if joint.kind == "R" else joint.d for joint in self.joints)
        return tuple(sp.expand(value - variable) for value, variable in zip(moving_values, self.q, strict=True))

    def joints_of_kind(self, kind: str) -> list[int]:
        """Return the indices of the revolute ("R") or prismatic ("P") joints, from 0."""
        return [i for i, joint in enumerate(self.joints) if joint.kind == kind]

    @property
    def linear_rows(self) -> tuple[str, ...]:
        """The components of the point's velocity that belong to the task: some of "x", "y", "z"."""
        return tuple(row[1] for row in self.task if row[0] == "v")

    @property
    def is_planar(self) -> bool:
        """Whether the arm stays in the world's xy plane in every configuration."""
        if self.base.tilt not in (0, sp.pi):
            return False
        if all(joint.alpha in (0, sp.pi) for joint in self.joints[:-1]):
            return all(joint.kind == "R" and joint.d == 0 for joint in self.joints) and self.point.offset[2] == 0
        if [joint.kind for joint in self.joints] != ["R", "P"] or self.joints[0].d != 0:
            return False
        is_in_plane = self.joints[0].alpha in (sp.pi / 2, -sp.pi / 2) and self.joints[1].theta in (0, sp.pi)
        return bool(is_in_plane and self.point.offset[1] == 0)

    @cached_property
    def parameters(self) -> tuple[sp.Symbol, ...]:
        """The symbolic lengths and angles in the table, base and point, sorted by name."""
        values = [v for joint in self.joints for v in (joint.theta, joint.d, joint.a, joint.alpha)]
        values += [*self.base.position, self.base.yaw, self.base.tilt, *self.point.offset]
        symbols = set().union(*(value.free_symbols for value in values)) - set(self.q)
        return tuple(sorted(symbols, key=lambda symbol: symbol.name))

    def map_entries(self, replace_entry: Callable[[str, sp.Expr], sp.Expr]) -> "Chain":
        """Return the arm with each entry of its table, base and point replaced by `change(name, entry)`.

        The names of entries are theta1, d1, a1, alpha1 and so on, base_x, base_yaw, base_tilt, and point_x. The
        constant theta of a prismatic joint is called fixed1.
        """
        joints = []
        for i, joint in enumerate(self.joints, 1):
            names = ("theta" if joint.kind == "R" else "fixed", "d", "a", "alpha")
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
