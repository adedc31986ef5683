"""Read a ROBOT.toml, a file that describes a user's own arm. Error messages name the file, line, joint and key.

    name = "my arm"
    source = "its manual, p. 12"   # optional: the source of the numbers
    convention = "dh"              # optional: or "modified-dh", or "screws"
    angles = "radians"             # optional: or "degrees"
    task = ["vx", "vy"]            # optional: the rows of the Jacobian that belong to the task
    point = "O2"                   # optional: origin of a frame, or [x, y, z] in the last frame
    base = {position = [0, 0, 0.4], rpy = [0, 0, "pi/2"]}    # optional: the pose of frame O_0 in the world
    [[joint]]
    kind = "R"
    theta = "theta1"               # or "-theta1 + pi/2", if the joint variable increases in the opposite sense
    d = 0
    a = "a1"
    alpha = "pi/2"
    limits = ["-pi", "pi"]         # optional

    [draw]                         # optional, for assignments: ranges of each student's random lengths, in metres
    a1 = [0.3, 0.8]

With convention = "screws", a [[joint]] has the keys kind, axis = [0, 0, 1] and point = ["a1", 0, 0], a point on the
axis. The key `point` at the top is the point of interest. `axis` and both points are given at home, where all joint
variables are zero, in the base frame. Twists are (omega, v), or (v, omega) with twist_order = "v-omega".

The default task consists of these rows of the Jacobian:

- all six rows, for an arm of six joints or more that moves in all of them;
- the four rows in which the arm moves, for an arm of four joints that moves in exactly four rows (SCARA);
- for other arms, the linear rows in which the point of interest moves.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from itertools import compress
from pathlib import Path
from typing import Any, NamedTuple, TypeGuard

import numpy as np
import sympy as sp

from qdot.exercises.arm.axes_to_dh import (
    IDENTITY_POSE,
    Axis,
    Pose,
    evaluate_entry,
    make_exact,
    make_pose,
    recognize_coordinates,
)
from qdot.exercises.arm.chain import (
    ANGLE_PREFIXES,
    CONVENTIONS,
    PRISMATIC,
    REVOLUTE,
    Chain,
    HasKind,
    Joint,
    Point,
    Triple,
)
from qdot.exercises.arm.conventions import ALIASES, REGISTRY
from qdot.exercises.arm.conventions.base import FRAMES, FRAMES_OF_JOINTS, VELOCITY_NAMES, Convention
from qdot.exercises.arm.conventions.screws import Screws
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.standard_table import (
    ArmTable,
    WrittenRow,
    compute_axes_of_rows,
    compute_home_geometry,
    convert_axes,
    convert_modified_rows,
    convert_standard_rows,
    is_table_rounded,
)
from qdot.exercises.common.errors import QdotError, make_name_error
from qdot.exercises.common.input_file import KeyPath, TomlFile, format_toml, read_toml
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.robots.entry import check_quantity, find_unit_warning, parse_entry
from qdot.exercises.robots.urdf import UrdfChain, format_offset, make_offset_note, read_urdf

ENTRY_KEYS = ("theta", "d", "a", "alpha")
ANGLE_KEYS = ("theta", "alpha")
MAX_JOINTS = 10
"""Maximum number of joints: each further parallel joint doubles the time of the proof that two derivations agree."""
ANGLE_UNITS = ("radians", "degrees")
"""The units in which a file may give its angles; the first is the default."""
TOP_KEYS = ("name", "source", "convention", "twist_order", "angles", "task", "point", "base", "tool", "joint", "draw")
"""The keys outside the [[joint]] tables."""

_PROVISIONAL_TASK = ("vx",)
"""A placeholder: a Chain needs a task, but the default task is chosen from the finished Chain."""
_RANGE_HINT = "lengths need a range in metres, as in a1 = [0.3, 0.8]"
_POSE_HINT = "expected {position = [x, y, z]}, with rpy = [roll, pitch, yaw] if the frame is rotated"
Limits = tuple[sp.Expr, sp.Expr]
"""The lower and the upper limit of a joint (rad or m)."""


class LengthRange(NamedTuple):
    """A length that is random for each student, with its minimum and maximum in whole centimetres."""

    symbol: sp.Symbol
    min_cm: int
    max_cm: int


@dataclass(frozen=True)
class WrittenArm:
    """An arm as its file describes it: by axes, by a modified table, or by a table with a variable of negative sign.

    - `rows`: the joints as the user wrote them: the rows of a table, or the axes in the base frame.
    - `base`: position and angles of the base as the user wrote them; None if the file has no base.
    """

    convention: type[Convention]
    rows: tuple[Joint, ...] | tuple[Axis, ...]
    base: tuple[Triple, Triple] | None = None


@dataclass(frozen=True)
class Robot:
    """The robot that a file describes.

    - `length_ranges`: the lengths that are random for each student.
    - `notes`: warnings about probable mistakes in the file.
    - `limits`: the limits of each joint (rad or m), None for a joint without limits.
    - `written_arm`: the description in the file; None if the file contains the table of `chain`.
    - `source`: the source of the numbers; empty if the file does not state the source.
    - `is_table_rounded`: whether some numbers of the standard table are rounded to ten decimals, because they have no
      short formula.
    """

    chain: Chain
    length_ranges: tuple[LengthRange, ...] = ()
    notes: tuple[str, ...] = ()
    limits: tuple[Limits | None, ...] = ()
    written_arm: WrittenArm | None = None
    source: str = ""
    is_table_rounded: bool = False


def read_robot(path: Path) -> Chain:
    """Return the arm that a file describes. Raises QdotError if the file is not valid.

    >>> read_robot(Path("exercises/robots/scorbot.toml"))
    Chain(SCORBOT-ER 4u: RRRRR, vx vy vz of frame 5)
    """
    return read_robot_file(path).chain


def read_robot_file(path: Path, tip: str = "", base: str = "") -> Robot:
    """Return the robot that a file describes: a URDF if the file's name ends in .urdf or .xml, else a ROBOT.toml.

    For a URDF, `tip` is the link at the end of the chain, and `base` is the link at its beginning. Raises QdotError,
    whose message says what to correct, and where.
    """
    if path.suffix.lower() in (".urdf", ".xml"):
        return _convert_urdf(path, read_urdf(path, tip, base))
    for option, link in (("--tip", tip), ("--base", base)):
        if link:
            raise QdotError(f"{path}: {option} applies only to a URDF, a file that ends in .urdf or .xml")
    return parse_robot(read_toml(path))


def _describe_excess_joints(joint_count: int) -> str:
    """Return the error message for an arm with too many joints."""
    return f"{joint_count} joints are too many; qdot can derive arms with at most {MAX_JOINTS}"


def _convert_urdf(path: Path, urdf_chain: UrdfChain) -> Robot:
    """Return the robot with the chain in a URDF; small offsets in its table are snapped to zero."""
    joint_count = len(urdf_chain.axes)
    if joint_count > MAX_JOINTS:
        raise QdotError(f"{path}: {_describe_excess_joints(joint_count)}")
    base, joints, point = convert_axes(urdf_chain.axes, urdf_chain.tip, joint_count)
    chain = Chain(urdf_chain.name, joints, _PROVISIONAL_TASK, base, tool=point, title=urdf_chain.name)
    is_rounded, axes = is_table_rounded(chain, urdf_chain.axes, urdf_chain.tip), urdf_chain.axes
    notes, tolerance = list(urdf_chain.notes), urdf_chain.offset_tolerance
    chain, snapped_offsets = _snap_table_offsets(chain, tolerance)
    if snapped_offsets:
        notes.append(make_offset_note(path, [f"{name} of the table" for name in snapped_offsets], tolerance))
        axes = tuple(map(_move_point_near, compute_home_geometry(chain).axes, axes))
    chain = chain.with_task(*choose_default_task(chain))
    return Robot(
        chain, notes=tuple(notes), limits=urdf_chain.limits, written_arm=_describe_axes(axes),
        is_table_rounded=is_rounded,
    )  # fmt: skip


def _snap_table_offsets(chain: Chain, tolerance: sp.Expr) -> tuple[Chain, list[str]]:
    """Remove offsets of at most `tolerance` (m) from an arm's table; return the arm, and the removed offsets as text.

    An offset in the table may be a sum of offsets in the file. So it can be small although no offset in the file is.
    """
    snapped_offsets: list[str] = []

    def snap(name: str, entry: sp.Expr) -> sp.Expr:
        offset = entry - sum(entry.free_symbols)
        is_length = name.startswith(("d", "a", "base_", "point_")) and not name.startswith(ANGLE_PREFIXES)
        if not is_length or offset == 0 or abs(offset.n()) > tolerance:
            return entry
        snapped_offsets.append(f"{name} ({format_offset(offset)})")
        return entry - offset

    return chain.map_entries(snap), snapped_offsets


def _move_point_near(axis: Axis, former_axis: Axis) -> Axis:
    """Return `axis`, described by that point on it which is nearest to the point of `former_axis`."""
    distance = (former_axis.point - axis.point).dot(axis.direction)
    return replace(axis, point=(axis.point + distance * axis.direction).applyfunc(evaluate_entry))


def parse_robot(file: TomlFile) -> Robot:
    """Return the robot that a parsed TOML file describes. Raises QdotError."""
    reader = _RobotReader(file)
    chain = reader.read_chain()
    ranges = _parse_length_ranges(file, chain)
    notes, is_rounded = _find_length_warning(file, chain, ranges), is_table_rounded(chain, *reader.exact_home_geometry)
    return Robot(
        chain, ranges, notes, limits=reader.read_limits(), written_arm=reader.written_arm, source=reader.source,
        is_table_rounded=is_rounded,
    )  # fmt: skip


class _RobotReader:
    """The reader of one ROBOT.toml; its methods raise QdotError, whose message says what to correct, and where."""

    def __init__(self, file: TomlFile) -> None:
        file.check_keys((), TOP_KEYS, ("name", "joint"))
        self.file, self.content = file, file.content
        self.title = self._read_text("name", "my arm")
        self.source = self._read_text("source", "its manual, p. 12") if "source" in self.content else ""
        self.convention = REGISTRY[self._read_choice("convention", CONVENTIONS)]
        self.has_dh_table = FRAMES in self.convention.features
        self.is_modified_table = FRAMES_OF_JOINTS in self.convention.features
        self.twist_order = self._read_choice("twist_order", Screws.twist_orders)
        if "twist_order" in self.content and not self.convention.twist_orders:
            with file.locate_errors("twist_order"):
                raise QdotError('the key applies only to arms described by screw axes, with convention = "screws"')
        self.uses_degrees = self._read_choice("angles", ANGLE_UNITS) == ANGLE_UNITS[1]
        joints = self.content["joint"]
        with file.locate_errors("joint"):
            if not isinstance(joints, list) or not joints or not all(isinstance(joint, dict) for joint in joints):
                raise QdotError("expected a [[joint]] table for each joint")
            if len(joints) > MAX_JOINTS:
                raise QdotError(_describe_excess_joints(len(joints)))
        self.joints: list[dict[str, Any]] = joints
        kinds = [self._read_kind(index, joint) for index, joint in enumerate(joints)]
        self.variables = [sp.Symbol(f"{HasKind(kind).variable_key}{i}") for i, kind in enumerate(kinds, 1)]
        self.written_arm: WrittenArm | None = None
        self.axis_points: tuple[Triple | None, ...] = ()
        self.exact_home_geometry: tuple[list[Axis], sp.Matrix | None] = ([], None)
        """The axes and the point of interest at home before the conversion to the standard table; no axes if nothing is
        converted."""

    def read_chain(self) -> Chain:
        """Return the arm with the task in the file, or with the default task if the file has none."""
        base, joints, point = self._read_table() if self.has_dh_table else self._read_axes()
        chain = Chain(
            self.title, joints, _PROVISIONAL_TASK, base, tool=point, title=self.title,
            convention=self.convention.name, axis_points=self.axis_points, twist_order=self.twist_order,
        )  # fmt: skip
        if "task" not in self.content:
            return chain.with_task(*choose_default_task(chain))
        with self.file.locate_errors("task"):
            return chain.with_task(*_parse_task(self.content["task"]))

    def _read_text(self, key: str, example: str) -> str:
        """Return the text under a key as a single line. Raises QdotError if the value is empty or not a text."""
        value = self.content[key]
        with self.file.locate_errors(key):
            if not isinstance(value, str) or not value.strip():
                raise QdotError(f'expected a text in quotes, as in {key} = "{example}"')
        return " ".join(value.split())

    def _read_choice(self, key: str, choices: tuple[str, ...]) -> str:
        """Return the value under a key, by default the first choice. Raises QdotError if the value is not a choice."""
        value = self.content.get(key, choices[0])
        with self.file.locate_errors(key):
            if value not in choices:
                alias = ALIASES.get(str(value).lower().replace("_", "-")) if key == "convention" else None
                hint = f"; did you mean {format_toml(alias)}?" if alias else ""
                raise QdotError(f"expected {' or '.join(map(format_toml, choices))}{hint}")
        return str(value)

    def _read_kind(self, index: int, joint: dict[str, Any]) -> str:
        """Return the kind of the joint with an index (from 0), after checking the joint's keys."""
        keys, path = self.convention.joint_keys, ("joint", index)
        self._reject_keys_of_other_conventions(index, joint)
        self.file.check_keys(path, (*keys, "limits"), ("kind",), TOP_KEYS)
        with self.file.locate_errors(*path, "kind"):  # the kind decides which other keys are needed
            if joint["kind"] not in (REVOLUTE, PRISMATIC):
                raise QdotError('expected "R" (revolute) or "P" (prismatic)')
        required_keys = [key for key in keys if key != "point" or joint["kind"] == REVOLUTE]
        self.file.check_keys(path, (*keys, "limits"), required_keys)
        return str(joint["kind"])

    def _reject_keys_of_other_conventions(self, index: int, joint: dict[str, Any]) -> None:
        """Raise QdotError if a joint has a key of a convention other than the file's."""
        key = next((key for key in joint if key in (("axis",) if self.has_dh_table else ENTRY_KEYS)), None)
        if key is None:
            return
        owner = "an arm described by screw axes" if self.has_dh_table else "a DH table"
        names = " or ".join(format_toml(name) for name, convention in REGISTRY.items() if key in convention.joint_keys)
        by_default = "" if "convention" in self.content else "by default "
        has_convention = f"has {by_default}convention = {format_toml(self.convention.name)}"
        message = f"the key {key!r} belongs to {owner}, but the file {has_convention}"
        hint = f"write convention = {names} at the top, or the keys {', '.join(self.convention.joint_keys)}"
        raise QdotError(f"{self.file.describe_key('joint', index, key)}: {message}; {hint}")

    # --- tables ---

    def _read_table(self) -> ArmTable:
        """Return base, standard table and point of an arm that is described by a table."""
        rows = [self._read_row(index) for index in range(len(self.joints))]
        if self.is_modified_table and rows[0].alpha.free_symbols:
            entry = self.file.describe_value("joint", 0, "alpha")
            raise QdotError(f"{entry}: the first alpha rotates the base, so the first alpha must be a number")
        base = self._read_pose("base")
        if base != IDENTITY_POSE or self.is_modified_table:
            self.exact_home_geometry = compute_axes_of_rows(rows, base, self.convention), None
        convert_rows = convert_modified_rows if self.is_modified_table else convert_standard_rows
        if self.is_modified_table or any(row.is_reversed for row in rows):
            written_rows = tuple(map(WrittenRow.with_variable, rows, self.variables))
            self.written_arm = WrittenArm(self.convention, written_rows, self._read_position_and_angles("base"))
        return convert_rows(rows, base, self._read_point_of_interest())

    def _read_row(self, index: int) -> WrittenRow:
        """Return the row of the table with an index (from 0), without its joint variable."""
        joint, variable = self.joints[index], self.variables[index]
        kind, variable_key = joint["kind"], HasKind(joint["kind"]).variable_key
        values: dict[str, sp.Expr] = {}
        is_reversed = False
        # the entry with the joint variable comes first, because most mistakes are there
        for key in sorted(ENTRY_KEYS, key=lambda key: key != variable_key):
            with self.file.locate_errors("joint", index, key):
                value = self._parse_value(joint[key], is_angle=key in ANGLE_KEYS)
                if key == variable_key:
                    value, is_reversed = _split_variable(value, variable, kind)
                values[key] = self._check_entry(value, is_angle=key in ANGLE_KEYS)
        return WrittenRow(kind, values["theta"], values["d"], values["a"], values["alpha"], is_reversed)

    def _read_point_of_interest(self) -> Point | None:
        """Return the point of interest in a frame of the file's convention; None if the file gives no point."""
        n = len(self.joints)
        if "tool" in self.content:
            if "point" in self.content:
                point = self.file.describe_value("point")
                raise QdotError(f"{point}: the point of interest is the tool's origin; give only `point` or `tool`")
            x, y, z = self._read_pose("tool").origin
            return Point(n, (x, y, z))
        if "point" not in self.content:
            return None
        raw = self.content["point"]
        message = f'expected the origin of a frame, "O0" … "O{n}", or [x, y, z] in the last frame'
        with self.file.locate_errors("point"):
            if isinstance(raw, str):
                match = re.fullmatch(r"O_?(\d{1,2})", raw)
                if match is None or int(match.group(1)) > n:
                    raise QdotError(message)
                return Point(int(match.group(1)))
            return self._read_point(raw, message)

    def _read_point(self, raw: object, message: str) -> Point:
        """Parse a point: [x, y, z] on the last link, or {frame = 2, offset = [x, y, z]}; `message` is for errors."""
        frame, raw_offset = len(self.joints), raw
        if isinstance(raw, dict):
            if {*raw} != {"frame", "offset"} or type(raw["frame"]) is not int or not 0 <= raw["frame"] <= frame:
                raise QdotError(f"{message}; for another frame, write {{frame = {frame - 1}, offset = [x, y, z]}}")
            frame, raw_offset = raw["frame"], raw["offset"]
        x, y, z = self._parse_triple(raw_offset, message)
        return Point(frame, (x, y, z))

    # --- axes ---

    def _read_axes(self) -> ArmTable:
        """Return base, standard table and point of an arm that is described by its axes."""
        if "tool" in self.content:
            tool = self.file.describe_value("tool")
            raise QdotError(f"{tool}: with screws, use `point`: [x, y, z] in the home configuration, in the base frame")
        self.file.check_keys((), TOP_KEYS, ("name", "joint", "point"))
        base = self._read_pose("base")
        with self.file.locate_errors("point"):
            message = "expected [x, y, z] in the base frame, the point of interest when all joint variables are zero"
            home_point = self._read_point(self.content["point"], message)

        def to_world(position: Sequence[sp.Expr]) -> sp.Matrix:
            return (base @ Pose(sp.eye(3), sp.Matrix(position))).origin

        axes = [self._read_axis(index) for index in range(len(self.joints))]
        self.written_arm = replace(_describe_axes(axes), base=self._read_position_and_angles("base"))
        directions = (base.rotation * axis.direction / axis.direction.norm() for axis in axes)
        world_axes = [Axis(axis.kind, z, to_world(axis.point)) for axis, z in zip(axes, directions, strict=True)]
        point = to_world(home_point.offset)
        self.exact_home_geometry = world_axes, point
        self.axis_points = tuple(recognize_coordinates(axis.point) if axis.is_revolute else None for axis in world_axes)
        return convert_axes(world_axes, point, home_point.frame)

    def _read_axis(self, index: int) -> Axis:
        """Return the axis of the joint with an index (from 0) as the user wrote it, in the base frame."""
        joint = self.joints[index]
        with self.file.locate_errors("joint", index, "axis"):
            message = "expected the direction of the axis in the home configuration: three numbers, not all zero, "
            message += "as in [0, 0, 1]"
            direction = sp.Matrix(self._parse_triple(joint["axis"], message))
            if direction.free_symbols or direction.norm() == 0:
                raise QdotError(message)
        axis_point = (sp.S.Zero,) * 3
        if "point" in joint:
            message = "expected a point on the axis in the home configuration, [x, y, z] in metres"
            with self.file.locate_errors("joint", index, "point"):
                axis_point = self._parse_triple(joint["point"], message)
        return Axis(joint["kind"], direction, sp.Matrix(axis_point))

    # --- entries ---

    def _read_pose(self, key: str) -> Pose:
        """Return the pose under a key of the file, by default the identity."""
        position_and_angles = self._read_position_and_angles(key)
        return make_pose(*position_and_angles) if position_and_angles else IDENTITY_POSE

    def _read_position_and_angles(self, key: str) -> tuple[Triple, Triple] | None:
        """Return the position (m), and the angles roll, pitch, yaw (rad), under a key; None if the key is missing."""
        if key not in self.content:
            return None
        raw = self.content[key]
        with self.file.locate_errors(key):
            if not isinstance(raw, dict) or not raw or not {*raw} <= {"position", "rpy"}:
                raise QdotError(_POSE_HINT)
            position = self._parse_triple(raw.get("position", [0, 0, 0]), _POSE_HINT)
            rpy = self._parse_triple(raw.get("rpy", [0, 0, 0]), _POSE_HINT, are_angles=True)
            if any(angle.free_symbols for angle in rpy):
                raise QdotError('the angles must be numbers, as in rpy = [0, 0, "pi/2"]')
            return position, rpy

    def _parse_triple(self, raw: object, message: str, are_angles: bool = False) -> Triple:
        """Parse three entries. Raises QdotError, with the `message` if there are not three."""
        if not isinstance(raw, list) or len(raw) != 3:
            raise QdotError(message)
        values = []
        for axis, entry in zip("xyz", raw, strict=True):
            try:
                values.append(self._check_entry(self._parse_value(entry, are_angles), are_angles))
            except QdotError as error:
                raise QdotError(f"{axis} = {format_toml(entry)}: {error}") from None
        return values[0], values[1], values[2]

    def _parse_value(self, raw: object, is_angle: bool) -> sp.Expr:
        """Parse one entry (rad or m); the names q1, q2, … are replaced by the joint variables."""
        if self.uses_degrees and isinstance(raw, str) and re.search(r"\b(a?(sin|cos|tan)|atan2)\s*\(", raw):
            hint = "write the value of a sine or an arctangent as a number, as in sqrt(3)/2"
            raise QdotError(f"with angles in degrees, {hint}")
        value = parse_entry(raw, is_angle, self.uses_degrees)
        variables_by_name = {sp.Symbol(f"q{number}"): variable for number, variable in enumerate(self.variables, 1)}
        return value.xreplace(variables_by_name)

    def _check_entry(self, value: sp.Expr, is_angle: bool) -> sp.Expr:
        """Return an entry unchanged. Raises QdotError if the entry has joint variables or mixes lengths and angles."""
        _check_symbols(value, self.variables)
        check_quantity(value, is_angle)
        return value

    def read_limits(self) -> tuple[Limits | None, ...]:
        """Return the limits of each joint (rad or m); None for a joint without limits."""
        return tuple(map(self._read_joint_limits, range(len(self.joints))))

    def _read_joint_limits(self, index: int) -> Limits | None:
        if "limits" not in self.joints[index]:
            return None
        limits, is_angle = self.joints[index]["limits"], self.joints[index]["kind"] == REVOLUTE
        example = '["-pi/2", "pi/2"]' if is_angle else "[0, 0.5]"
        with self.file.locate_errors("joint", index, "limits"):
            values = [parse_entry(limit, is_angle, self.uses_degrees) for limit in limits] if _is_pair(limits) else []
            if not values or any(value.free_symbols for value in values) or not values[0] < values[1]:
                raise QdotError(f"expected two numbers, the lower one first, as in {example}")
        return values[0], values[1]


def _is_pair(value: object) -> TypeGuard[list[Any]]:
    return isinstance(value, list) and len(value) == 2


def _describe_axes(axes: Sequence[Axis]) -> WrittenArm:
    """Return the description of an arm by its axes; coordinates are exact if qdot recognises them."""
    return WrittenArm(Screws, tuple(Axis(a.kind, make_exact(a.direction), make_exact(a.point)) for a in axes))


def _split_variable(value: sp.Expr, variable: sp.Symbol, kind: str) -> tuple[sp.Expr, bool]:
    """Return the constant added to a joint's variable, and whether the variable has a minus sign. Raises QdotError."""
    for sign in (1, -1):
        constant = sp.expand(value - sign * variable)
        if variable not in constant.free_symbols:
            return constant, sign < 0
    key, offset = ("theta", "pi/2") if kind == REVOLUTE else ("d", "0.2")
    raise QdotError(
        f'a joint of kind "{kind}" needs its own variable here: {key} = "{variable}", with a constant offset if '
        f'necessary, as in "{variable} + {offset}", or "-{variable}" for the opposite direction'
    )


def _check_symbols(value: sp.Expr, variables: Sequence[sp.Symbol]) -> None:
    """Raise QdotError if an entry contains the variable of a joint, whether or not the arm has that joint."""
    for symbol in sorted(value.free_symbols, key=str):
        if symbol in variables:
            number = list(variables).index(symbol) + 1
            raise QdotError(f"{symbol} is the variable of joint {number}; use it only in the row of that joint")
        match = re.fullmatch(r"theta(\d+)", symbol.name)
        if match and not 0 < int(match.group(1)) <= len(variables):
            raise QdotError(f"there is no joint with the variable {symbol}; the last joint is joint {len(variables)}")


def _parse_task(raw: object) -> tuple[str, ...]:
    """Parse the task, a list of rows; return the rows in the order of VELOCITY_NAMES. Raises QdotError."""
    if not isinstance(raw, list) or not raw or not all(isinstance(row, str) for row in raw):
        raise QdotError('expected a list of the rows of the task, as in ["vx", "vy"]')
    for row in raw:
        if row not in VELOCITY_NAMES:
            raise make_name_error("row", row, VELOCITY_NAMES)
        if raw.count(row) > 1:
            raise QdotError(f"the row {row!r} is listed twice")
    return tuple(sorted(raw, key=VELOCITY_NAMES.index))


# --- random lengths ---


def _parse_length_ranges(file: TomlFile, chain: Chain) -> tuple[LengthRange, ...]:
    """Parse the table [draw] with the ranges of random lengths. Raises QdotError."""
    range_table = file.content.get("draw", {})
    with file.locate_errors("draw"):
        if not isinstance(range_table, dict):
            raise QdotError("expected a table, [draw], in which " + _RANGE_HINT)
    angles = set[sp.Basic]().union(*(value.free_symbols for j in chain.joints for value in (j.theta, j.alpha)))
    ranges = []
    for name, range_ends in range_table.items():
        symbol = sp.Symbol(name)
        with file.locate_errors("draw", name):
            if symbol not in chain.parameters:
                symbolic_lengths = ", ".join(s.name for s in chain.parameters if s not in angles) or "none"
                raise QdotError(f"{name!r} is not a symbolic length of the table; symbolic lengths: {symbolic_lengths}")
            if symbol in angles:
                raise QdotError(f"{name!r} is an angle; {_RANGE_HINT}")
            ranges.append(LengthRange(symbol, *_parse_range(range_ends)))
    return tuple(ranges)


def _parse_range(range_ends: object) -> tuple[int, int]:
    """Return the two ends of a range in whole centimetres. Raises QdotError if the range is not valid."""
    if not _is_pair(range_ends) or not all(map(_is_number, range_ends)):
        raise QdotError(_RANGE_HINT)
    low, high = range_ends
    if not 0 < low < high < 1000:
        raise QdotError(f"the smaller end must come first, and both must lie between 0 and 1000 m; {_RANGE_HINT}")
    if (100 * low) % 1 or (100 * high) % 1:
        raise QdotError(f"lengths are chosen in whole centimetres; {_RANGE_HINT}")
    return int(100 * low), int(100 * high)


def _find_length_warning(file: TomlFile, chain: Chain, length_ranges: Iterable[LengthRange]) -> tuple[str, ...]:
    """Return a warning about the first length that is probably not in metres; an empty tuple if there is none."""
    entries: list[tuple[KeyPath, sp.Expr]] = [
        (("joint", i, key), getattr(joint, key)) for i, joint in enumerate(chain.joints) for key in ("d", "a")
    ]
    entries += [(("point",), value) for value in chain.point.offset]
    entries += [(("draw", length.symbol.name), sp.Rational(length.max_cm, 100)) for length in length_ranges]
    warnings = [(path, warning) for path, value in entries if (warning := find_unit_warning(value)) is not None]
    if not warnings:
        return ()
    (path, warning), *other_warnings = warnings
    remark = f" ({len(other_warnings)} more like this)" if other_warnings else ""
    return (f"{file.describe_value(*path)}: {warning}{remark}",)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, Decimal)) and not isinstance(value, bool) and Decimal(value).is_finite()


_NONZERO_THRESHOLD = 1e-6
"""An entry of J above this is not a rounding error. Typical entries are 1 rad/rad, or an arm's length in m."""


def _find_nonzero_rows(chain: Chain) -> tuple[bool, ...]:
    """Return for each of the six rows of J whether the row is clearly nonzero at one of three random configurations.

    This is much faster than deriving formulas, which may take minutes.
    """
    rng = Stream("rows of J")  # chooses lengths in m, and joint values in rad or m
    values = {symbol.name: rng.uniform(0.4, 1.4) for symbol in chain.parameters}
    q = np.array([[rng.uniform(-3, 3) for _ in chain.q] for _ in range(3)])  # three configurations, (3, n)
    try:
        largest_entries = np.abs(NumericChain(chain, values).compute_jacobian(q)).max(axis=(0, 2))
    except TypeError:  # a constant is not real for these lengths, e.g. sqrt(a1**2 - d1**2)
        return (False,) * len(VELOCITY_NAMES)
    return tuple(bool(size > _NONZERO_THRESHOLD) for size in largest_entries)


def choose_default_task(chain: Chain) -> tuple[str, ...]:
    """Return the default task of an arm, for a file without `task`; the module's docstring gives the rules."""
    rows = enumerate(_find_nonzero_rows(chain))
    is_nonzero = (is_clearly_nonzero or any(derive(chain).geometric_jacobian.row(i)) for i, is_clearly_nonzero in rows)
    moving_rows = tuple(compress(VELOCITY_NAMES, is_nonzero))
    if chain.n >= 6 and len(moving_rows) == len(VELOCITY_NAMES):
        return VELOCITY_NAMES
    if chain.n == 4 and len(moving_rows) == 4:
        return moving_rows
    return tuple(row for row in moving_rows if row[0] == "v") or moving_rows
