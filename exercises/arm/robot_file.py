"""Read a ROBOT.toml, which describes a user's own arm. Every error message names file, line, joint and key.

    name = "my arm"
    source = "its manual, p. 12"   # optional: the source of its numbers
    convention = "dh"              # optional: or "modified-dh", or "screws"
    angles = "radians"             # optional: or "degrees"
    task = ["vx", "vy"]            # optional: the rows that count
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

With convention = "screws", a [[joint]] has kind, axis = [0, 0, 1] and point = ["a1", 0, 0], a point on the axis. Both
are given in the base frame when all joint variables are zero, as is the key `point` at the top, the point of interest.
Twists are (omega, v), or (v, omega) with twist_order = "v-omega".

Without `task`, the rows are:

- all six, for six joints or more that can move in all of them;
- the rows in which the arm moves, for four joints that move in exactly four rows (SCARA);
- otherwise, the linear rows in which the point moves.
"""

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from itertools import compress, product
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np
import sympy as sp

from qdot.exercises.arm.axes_to_dh import IDENTITY_POSE, Axis, Pose, make_pose, recognize_exact
from qdot.exercises.arm.chain import CONVENTIONS, TASK_ROWS, TWIST_ORDERS, Base, Chain, Joint, Point
from qdot.exercises.arm.conventions import ALIASES, REGISTRY
from qdot.exercises.arm.conventions.base import FRAMES, FRAMES_OF_JOINTS, Convention
from qdot.exercises.arm.conventions.screws import Screws
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.entry import check_quantity, find_unit_warning, parse_entry
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.standard_table import (
    WrittenRow,
    axes_of_rows,
    dh_of_axes,
    dh_of_modified_rows,
    dh_of_standard_rows,
    is_rounded,
)
from qdot.exercises.arm.urdf import UrdfChain, read_urdf
from qdot.exercises.common.errors import QdotError, make_name_error
from qdot.exercises.common.input_file import KeyPath, TomlFile, read_toml, toml_text
from qdot.exercises.common.stream import Stream

ROW_KEYS = Convention.joint_keys
ANGLE_KEYS = ("theta", "alpha")
MAX_JOINTS = 10
"""Maximum number of joints: each further parallel joint doubles the time of proving that both routes agree."""
ANGLE_UNITS = ("radians", "degrees")
"""The units in which a file may give its angles; the first is the default."""
TOP_KEYS = ("name", "source", "convention", "twist_order", "angles", "task", "point", "base", "tool", "joint", "draw")
_RANGE_HINT = "lengths need a range in metres, as in a1 = [0.3, 0.8]"
_POSE_HINT = "expected {position = [x, y, z]}, with rpy = [roll, pitch, yaw] if it is rotated"
Limits = tuple[sp.Expr, sp.Expr]
Triple = tuple[sp.Expr, sp.Expr, sp.Expr]
LengthRanges = tuple[tuple[sp.Symbol, int, int], ...]
"""The random lengths of an arm: symbol, minimum and maximum in whole cm."""


@dataclass(frozen=True)
class WrittenArm:
    """The description of an arm in its file, if this is not a standard table.

    - `rows`: the rows as the user wrote them. A row of a table is theta, d, a, alpha. A row of axes is the direction
      and a point, which is None for a prismatic joint.
    - `base`: position and angles of the base as the user wrote them; None if the file has no base.
    """

    convention: type[Convention]
    rows: tuple[tuple[Any, ...], ...]
    base: tuple[Triple, Triple] | None = None


@dataclass(frozen=True)
class Robot:
    """The robot that a file describes.

    - `length_ranges`: the lengths that are random for each student.
    - `notes`: warnings about probable mistakes.
    - `limits`: the limits of each joint (rad or m), None for a joint without limits.
    - `written_arm`: the description in the file, None if that is the standard table.
    - `source`: the source of the numbers, or empty.
    - `is_table_rounded`: whether numbers of the standard table are rounded to ten decimals, because they have no short
      formula.
    """

    chain: Chain
    length_ranges: LengthRanges = ()
    notes: tuple[str, ...] = ()
    limits: tuple[Limits | None, ...] = ()
    written_arm: WrittenArm | None = None
    source: str = ""
    is_table_rounded: bool = False


def read_robot(path: Path) -> Chain:
    r"""Return the chain that a file describes, with symbolic lengths. Raises QdotError if the file is not valid.

    >>> import tempfile
    >>> row = 'kind = "R"\ntheta = "theta1"\nd = 0\na = "a1"\nalpha = 0'
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "arm.toml"
    ...     _ = path.write_text(f'name = "mine"\ntask = ["vx"]\n[[joint]]\n{row}')
    ...     read_robot(path)
    Chain(mine: R, vx of frame 1)
    """
    return read_robot_file(path).chain


def read_robot_file(path: Path, tip: str = "") -> Robot:
    """Return the robot that a file describes: a URDF if its name ends in .urdf or .xml, else a ROBOT.toml.

    For a URDF, `tip` is the link at the end of the chain. Raises QdotError with file, line, key and a correction.
    """
    if path.suffix.lower() in (".urdf", ".xml"):
        return _robot_from_urdf(path, read_urdf(path, tip))
    if tip:
        raise QdotError(f"{path}: a tip applies only to a URDF, a file that ends in .urdf or .xml")
    return parse_robot(read_toml(path))


def _too_many_joints(count: int) -> str:
    """Return the error message for an arm with too many joints."""
    return f"{count} joints are too many; qdot can derive arms with at most {MAX_JOINTS}"


def _robot_from_urdf(path: Path, urdf_chain: UrdfChain) -> Robot:
    count = len(urdf_chain.axes)
    if count > MAX_JOINTS:
        raise QdotError(f"{path}: {_too_many_joints(count)}")
    base, joints, point = dh_of_axes(urdf_chain.axes, urdf_chain.tip, count)
    chain = Chain(urdf_chain.name, joints, ("vx",), base, point, urdf_chain.name)
    chain = chain.with_task(*default_task(chain))
    written, rounded = _written_axes(urdf_chain.axes), is_rounded(chain, urdf_chain.axes, urdf_chain.tip)
    return Robot(chain, (), urdf_chain.notes, urdf_chain.limits, written, is_table_rounded=rounded)


def parse_robot(file: TomlFile) -> Robot:
    """Return the robot that a parsed TOML file describes. Raises QdotError."""
    reader = _Reader(file)
    chain = reader.chain()
    ranges, rounded = _length_ranges(file, chain), is_rounded(chain, *reader.home_axes)
    notes = _length_warnings(file, chain, ranges)
    return Robot(chain, ranges, notes, reader.limits(), reader.written_arm, reader.source, rounded)


class _Reader:
    """The reader of one ROBOT.toml; its methods raise QdotError with the place of the mistake and a correction."""

    def __init__(self, file: TomlFile) -> None:
        file.check_keys((), TOP_KEYS, ("name", "joint"))
        self.file, self.table = file, file.content
        self.title = self._text("name", "my arm")
        self.source = self._text("source", "its manual, p. 12") if "source" in self.table else ""
        self.convention = REGISTRY[self._read_choice("convention", CONVENTIONS)]
        self.has_table, self.has_links_first = (what in self.convention.features for what in (FRAMES, FRAMES_OF_JOINTS))
        self.twist_order = self._read_choice("twist_order", TWIST_ORDERS)
        if "twist_order" in self.table and not self.convention.twist_orders:
            with file.locate_errors("twist_order"):
                raise QdotError('it applies only to arms described by screw axes, with convention = "screws"')
        self.in_degrees = self._read_choice("angles", ANGLE_UNITS) == ANGLE_UNITS[1]
        rows = self.table["joint"]
        with file.locate_errors("joint"):
            if not isinstance(rows, list) or not rows or not all(isinstance(row, dict) for row in rows):
                raise QdotError("expected a [[joint]] table for each joint")
            if len(rows) > MAX_JOINTS:
                raise QdotError(_too_many_joints(len(rows)))
        self.rows: list[dict[str, Any]] = rows
        kinds = [self._kind(index, row) for index, row in enumerate(rows)]
        self.variables = [sp.Symbol(f"{'theta' if kind == 'R' else 'd'}{i}") for i, kind in enumerate(kinds, 1)]
        self.written_arm: WrittenArm | None = None
        self.axis_points: tuple[Triple | None, ...] = ()
        self.home_axes: tuple[list[Axis], sp.Matrix | None] = ([], None)
        """The axes and the point of interest at home, as the file gives them; used to check the table's rounding."""

    def chain(self) -> Chain:
        """Return the arm with the task in the file, or with the default task if the file has none."""
        base, joints, point = self._read_table() if self.has_table else self._read_axes()
        name, order = self.convention.name, self.twist_order
        chain = Chain(self.title, joints, ("vx",), base, point, self.title, name, self.axis_points, order)
        if "task" not in self.table:
            return chain.with_task(*default_task(chain))
        with self.file.locate_errors("task"):
            return chain.with_task(*_task(self.table["task"]))

    def _text(self, key: str, example: str) -> str:
        """Return the text under a key as a single line. Raises QdotError if it is empty or not a text."""
        value = self.table[key]
        with self.file.locate_errors(key):
            if not isinstance(value, str) or not value.strip():
                raise QdotError(f'expected a text in quotes, as in {key} = "{example}"')
        return " ".join(value.split())

    def _read_choice(self, key: str, choices: tuple[str, ...]) -> str:
        """Return the value under a key, by default the first known value. Raises QdotError if it is not known."""
        value = self.table.get(key, choices[0])
        with self.file.locate_errors(key):
            if value not in choices:
                alias = ALIASES.get(str(value).lower().replace("_", "-")) if key == "convention" else None
                hint = f"; did you mean {toml_text(alias)}?" if alias else ""
                raise QdotError(f"expected {' or '.join(map(toml_text, choices))}{hint}")
        return str(value)

    def _kind(self, index: int, row: dict[str, Any]) -> str:
        """Return the kind of a joint after checking the joint's keys."""
        keys, path = self.convention.joint_keys, ("joint", index)
        self._check_convention(index, row)
        self.file.check_keys(path, (*keys, "limits"), ("kind",), TOP_KEYS)
        with self.file.locate_errors(*path, "kind"):  # the kind decides which other keys are needed
            if row["kind"] not in ("R", "P"):
                raise QdotError('expected "R" (revolute) or "P" (prismatic)')
        needs_no_point = not self.has_table and row["kind"] == "P"
        self.file.check_keys(path, (*keys, "limits"), keys[:2] if needs_no_point else keys)
        return str(row["kind"])

    def _check_convention(self, index: int, row: dict[str, Any]) -> None:
        """Raise QdotError if a joint has keys of another convention than the file's, or than the default."""
        key = next((key for key in row if key in (("axis",) if self.has_table else ROW_KEYS[1:])), None)
        if key is None:
            return
        name, keys = toml_text(self.convention.name), ", ".join(self.convention.joint_keys)
        stated_convention = f"has convention = {name}" if "convention" in self.table else "has no convention"
        if not self.has_table:
            hint = f"belongs to a DH table, but the file {stated_convention}, which needs {keys} for each joint; "
            hint += 'for a table, write convention = "dh" or "modified-dh"'
        else:
            hint = f"belongs to an arm described by screw axes, but the file {stated_convention}; "
            hint += f'write convention = "screws" at the top, or give a table, with {keys} for each joint'
        raise QdotError(f"{self.file.describe_key('joint', index, key)}: the key {key!r} {hint}")

    # --- tables ---

    def _read_table(self) -> tuple[Base, tuple[Joint, ...], Point | None]:
        """Return base, standard table and point of an arm that is described by a table."""
        rows = [self._row(index) for index in range(len(self.rows))]
        if self.has_links_first and rows[0].alpha.free_symbols:
            entry = self.file.describe_value("joint", 0, "alpha")
            raise QdotError(f"{entry}: the first alpha rotates the base, so it must be a number")
        base = self._pose("base")
        if base != IDENTITY_POSE or self.has_links_first:
            self.home_axes = axes_of_rows(rows, base, self.convention), None
        table = dh_of_modified_rows if self.has_links_first else dh_of_standard_rows
        if self.has_links_first or any(row.is_reversed for row in rows):
            written_rows = tuple(map(WrittenRow.entries, rows, self.variables))
            self.written_arm = WrittenArm(self.convention, written_rows, self._written_base())
        return table(rows, base, self._point())

    def _written_base(self) -> tuple[Triple, Triple] | None:
        """Return the position and the angles of the base as written; None if the file has no base."""
        if "base" not in self.table:
            return None
        table = self.table["base"]
        position, rpy = table.get("position", [0, 0, 0]), table.get("rpy", [0, 0, 0])
        return self._triple(position, _POSE_HINT), self._triple(rpy, _POSE_HINT, are_angles=True)

    def _row(self, index: int) -> WrittenRow:
        """Return one row of the table, with its joint variable split off."""
        row, variable = self.rows[index], self.variables[index]
        kind, variable_key = row["kind"], "theta" if row["kind"] == "R" else "d"
        values: dict[str, sp.Expr] = {}
        is_reversed = False
        # most mistakes are in the entry with the joint variable
        for key in (variable_key, *(key for key in ROW_KEYS[1:] if key != variable_key)):
            with self.file.locate_errors("joint", index, key):
                value = self._value(row[key], key in ANGLE_KEYS)
                if key == variable_key:
                    value, is_reversed = _split_variable(value, variable, kind)
                values[key] = self._check_entry(value, key in ANGLE_KEYS)
        return WrittenRow(kind, values["theta"], values["d"], values["a"], values["alpha"], is_reversed)

    def _point(self) -> Point | None:
        """Return the point of interest in a frame of the file's convention; None if the file gives no point."""
        n = len(self.rows)
        if "tool" in self.table:
            if "point" in self.table:
                point = self.file.describe_value("point")
                raise QdotError(f"{point}: the point of interest is the tool's origin; give only `point` or `tool`")
            x, y, z = self._pose("tool").origin
            return Point(n, (x, y, z))
        if "point" not in self.table:
            return None
        raw = self.table["point"]
        correction = f'expected the origin of a frame, "O0" … "O{n}", or [x, y, z] in the last frame'
        with self.file.locate_errors("point"):
            if isinstance(raw, str):
                match = re.fullmatch(r"O_?(\d{1,2})", raw)
                if match is None or int(match.group(1)) > n:
                    raise QdotError(correction)
                return Point(int(match.group(1)))
            return self._read_point(raw, correction)

    def _read_point(self, raw: object, correction: str) -> Point:
        """Parse a point: [x, y, z] on the last link, or {frame = 2, offset = [x, y, z]}."""
        frame = len(self.rows)
        if isinstance(raw, dict):
            if {*raw} != {"frame", "offset"} or type(raw["frame"]) is not int or not 0 <= raw["frame"] <= frame:
                raise QdotError(f"{correction}; for another frame, write {{frame = {frame - 1}, offset = [x, y, z]}}")
            frame, raw = raw["frame"], raw["offset"]
        x, y, z = self._triple(raw, correction)
        return Point(frame, (x, y, z))

    # --- axes ---

    def _read_axes(self) -> tuple[Base, tuple[Joint, ...], Point | None]:
        """Return base, standard table and point of an arm that is described by its axes."""
        if "tool" in self.table:
            tool = self.file.describe_value("tool")
            raise QdotError(f"{tool}: with screws, use `point`: [x, y, z] in the home configuration, in the base frame")
        self.file.check_keys((), TOP_KEYS, ("name", "joint", "point"))
        base = self._pose("base")
        with self.file.locate_errors("point"):
            hint = "expected [x, y, z] in the base frame, the point of interest when all joint variables are zero"
            home_point = self._read_point(self.table["point"], hint)

        def in_world(position: Sequence[sp.Expr]) -> sp.Matrix:
            return (base @ Pose(sp.eye(3), sp.Matrix(position))).origin

        axes, point = [self._axis(index) for index in range(len(self.rows))], in_world(home_point.offset)
        self.written_arm = replace(_written_axes(axes), base=self._written_base())
        directions = (base.rotation * axis.direction / axis.direction.norm() for axis in axes)
        world_axes = [Axis(axis.kind, z, in_world(axis.point)) for axis, z in zip(axes, directions, strict=True)]
        self.home_axes = world_axes, point
        self.axis_points = tuple(_coordinates(axis.point) if axis.kind == "R" else None for axis in world_axes)
        return dh_of_axes(world_axes, point, home_point.frame)

    def _axis(self, index: int) -> Axis:
        """Return a joint's axis as the user wrote it, in the base frame."""
        row = self.rows[index]
        with self.file.locate_errors("joint", index, "axis"):
            message = "expected the direction of the axis in the home configuration: three numbers, not all zero, "
            message += "as in [0, 0, 1]"
            direction = sp.Matrix(self._triple(row["axis"], message))
            if direction.free_symbols or direction.norm() == 0:
                raise QdotError(message)
        axis_point = (sp.S.Zero,) * 3
        if "point" in row:
            message = "expected a point on the axis in the home configuration, [x, y, z] in metres"
            with self.file.locate_errors("joint", index, "point"):
                axis_point = self._triple(row["point"], message)
        return Axis(row["kind"], direction, sp.Matrix(axis_point))

    # --- entries ---

    def _pose(self, key: str) -> Pose:
        """Return the pose under a key, by default the identity."""
        if key not in self.table:
            return IDENTITY_POSE
        raw = self.table[key]
        with self.file.locate_errors(key):
            if not isinstance(raw, dict) or not raw or not {*raw} <= {"position", "rpy"}:
                raise QdotError(_POSE_HINT)
            position = self._triple(raw.get("position", [0, 0, 0]), _POSE_HINT)
            rpy = self._triple(raw.get("rpy", [0, 0, 0]), _POSE_HINT, are_angles=True)
            if any(angle.free_symbols for angle in rpy):
                raise QdotError('the angles must be numbers, as in rpy = [0, 0, "pi/2"]')
            return make_pose(position, rpy)

    def _triple(self, raw: object, correction: str, are_angles: bool = False) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """Parse three entries. `correction` is the error message for anything else."""
        if not isinstance(raw, list) or len(raw) != 3:
            raise QdotError(correction)
        values = []
        for axis, entry in zip("xyz", raw, strict=True):
            try:
                values.append(self._check_entry(self._value(entry, are_angles), are_angles))
            except QdotError as error:
                raise QdotError(f"{axis} = {toml_text(entry)}: {error}") from None
        return values[0], values[1], values[2]

    def _value(self, raw: object, is_angle: bool) -> sp.Expr:
        """Parse one entry; the names q1, q2, … are replaced by the joint variables."""
        if self.in_degrees and isinstance(raw, str) and re.search(r"\b(a?(sin|cos|tan)|atan2)\s*\(", raw):
            hint = "write the value of a sine or an arctangent as a number, as in sqrt(3)/2"
            raise QdotError(f"with angles in degrees, {hint}")
        value = parse_entry(raw, is_angle, self.in_degrees)
        variables_by_name = {sp.Symbol(f"q{number}"): variable for number, variable in enumerate(self.variables, 1)}
        return value.xreplace(variables_by_name)

    def _check_entry(self, value: sp.Expr, is_angle: bool) -> sp.Expr:
        """Return an entry unchanged. Raises QdotError if it has joint variables or mixes lengths and angles."""
        _check_symbols(value, self.variables)
        check_quantity(value, is_angle)
        return value

    def limits(self) -> tuple[Limits | None, ...]:
        """Return the limits of each joint; None for a joint without limits."""
        return tuple(self._limits(index) if "limits" in row else None for index, row in enumerate(self.rows))

    def _limits(self, index: int) -> Limits:
        ends, is_angle = self.rows[index]["limits"], self.rows[index]["kind"] == "R"
        example = '["-pi/2", "pi/2"]' if is_angle else "[0, 0.5]"
        with self.file.locate_errors("joint", index, "limits"):
            values = [parse_entry(end, is_angle, self.in_degrees) for end in ends] if _is_pair(ends) else []
            if not values or any(value.free_symbols for value in values) or not values[0] < values[1]:
                raise QdotError(f"expected two numbers, the lower one first, as in {example}")
        return values[0], values[1]


def _coordinates(point: sp.Matrix) -> Triple:
    x, y, z = point.applyfunc(recognize_exact)
    return x, y, z


def _is_pair(value: object) -> TypeGuard[list[Any]]:
    return isinstance(value, list) and len(value) == 2


def _written_axes(axes: Sequence[Axis]) -> WrittenArm:
    points = (_coordinates(axis.point) if axis.kind == "R" else None for axis in axes)
    directions = (_coordinates(axis.direction) for axis in axes)
    return WrittenArm(Screws, tuple(zip(directions, points, strict=True)))


def _split_variable(value: sp.Expr, variable: sp.Symbol, kind: str) -> tuple[sp.Expr, bool]:
    """Return the offset added to a joint's variable, and whether the variable has a minus sign. Raises QdotError."""
    for sign in (1, -1):
        constant = sp.expand(value - sign * variable)
        if variable not in constant.free_symbols:
            return constant, sign < 0
    key, offset = ("theta", "pi/2") if kind == "R" else ("d", "0.2")
    raise QdotError(
        f'a joint of kind "{kind}" needs its own variable here: {key} = "{variable}", with a constant offset if '
        f'necessary, as in "{variable} + {offset}", or "-{variable}" for the opposite direction'
    )


def _check_symbols(value: sp.Expr, variables: Sequence[sp.Symbol]) -> None:
    """Raise QdotError if an entry contains joint variables, including those of joints that don't exist."""
    for symbol in sorted(value.free_symbols, key=str):
        if symbol in variables:
            number = list(variables).index(symbol) + 1
            raise QdotError(f"{symbol} is the variable of joint {number}; use it only in the row of that joint")
        match = re.fullmatch(r"theta(\d+)", symbol.name)
        if match and not 0 < int(match.group(1)) <= len(variables):
            raise QdotError(f"there is no joint with the variable {symbol}; the last joint is joint {len(variables)}")


def _task(raw: object) -> tuple[str, ...]:
    """Parse the task: a list of rows, which is returned in the order of TASK_ROWS."""
    if not isinstance(raw, list) or not raw or not all(isinstance(row, str) for row in raw):
        raise QdotError('expected a list of the rows of the task, as in ["vx", "vy"]')
    for row in raw:
        if row not in TASK_ROWS:
            guess = f"v{row.lower()}" if row.lower() in ("x", "y", "z") else row.lower()
            matches = difflib.get_close_matches(guess, TASK_ROWS, n=1, cutoff=0.5)
            raise make_name_error("row", row, TASK_ROWS, "".join(matches))
        if raw.count(row) > 1:
            raise QdotError(f"the row {row!r} is listed twice")
    return tuple(sorted(raw, key=TASK_ROWS.index))


# --- random lengths ---


def _length_ranges(file: TomlFile, chain: Chain) -> LengthRanges:
    """Parse the table [draw]."""
    range_table = file.content.get("draw", {})
    with file.locate_errors("draw"):
        if not isinstance(range_table, dict):
            raise QdotError("expected a table, [draw], in which " + _RANGE_HINT)
    angles = set[sp.Basic]().union(*(value.free_symbols for j in chain.joints for value in (j.theta, j.alpha)))
    ranges = []
    for name, ends in range_table.items():
        symbol = sp.Symbol(name)
        with file.locate_errors("draw", name):
            if symbol not in chain.parameters:
                open_lengths = ", ".join(s.name for s in chain.parameters if s not in angles) or "none"
                raise QdotError(f"{name!r} is not a symbolic length of the table; symbolic lengths: {open_lengths}")
            if symbol in angles:
                raise QdotError(f"{name!r} is an angle; {_RANGE_HINT}")
            ranges.append((symbol, *_range(name, ends)))
    return tuple(ranges)


def _range(name: str, range_ends: object) -> tuple[int, int]:
    """Return the two ends of a range in whole centimetres. Raises QdotError if it is no valid range."""
    if not _is_pair(range_ends) or not all(map(_is_number, range_ends)):
        raise QdotError(_RANGE_HINT)
    low, high = range_ends
    if low <= 0:
        raise QdotError(f"{toml_text(low)} is not positive; {_RANGE_HINT}")
    if high >= 1000:
        raise QdotError(f"{toml_text(high)} is too long; {_RANGE_HINT}")
    if low == high:
        raise QdotError(f"both ends of the range are the same; {_RANGE_HINT}")
    if low > high:
        raise QdotError(f"the smaller end must come first; write {name} = {toml_text([high, low])}")
    first = max(1, int((100 * Decimal(low)).to_integral_value(ROUND_FLOOR)))
    last = int((100 * Decimal(high)).to_integral_value(ROUND_CEILING))
    if first != 100 * low or last != 100 * high:
        suggestion = f"{name} = [{first / 100:.2f}, {max(last, first + 1) / 100:.2f}]"
        raise QdotError(f"lengths are chosen in whole centimetres; write {suggestion}")
    return first, last


def _length_warnings(file: TomlFile, chain: Chain, length_ranges: LengthRanges) -> tuple[str, ...]:
    """Return a warning about the first length that is probably not in metres; empty if there is none."""
    rows = product(enumerate(chain.joints), ("d", "a"))
    entries: list[tuple[KeyPath, sp.Expr]]
    entries = [(("joint", i, key), getattr(joint, key)) for (i, joint), key in rows]
    entries += [(("point",), value) for value in chain.point.offset]
    entries += [(("draw", symbol.name), sp.Rational(high, 100)) for symbol, _, high in length_ranges]
    doubts = [(path, reason) for path, value in entries if (reason := find_unit_warning(value)) is not None]
    if not doubts:
        return ()
    (path, reason), other_count = doubts[0], len(doubts) - 1
    others = f" ({other_count} more like this)" if other_count else ""
    return (f"{file.describe_value(*path)}: {reason}{others}",)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, Decimal)) and not isinstance(value, bool) and Decimal(value).is_finite()


_NONZERO_THRESHOLD = 1e-6
"""An entry of J above this is not a rounding error; entries have the order of magnitude of an arm's length."""


def _moves_somewhere(chain: Chain) -> tuple[bool, ...]:
    """Return for each of the six rows of J whether it is clearly nonzero at one of three random configurations.

    For arms with many joints, this avoids deriving formulas, which takes minutes if axes are skew.
    """
    rng = Stream("rows of J")
    values = {symbol.name: rng.uniform(0.4, 1.4) for symbol in chain.parameters}
    q = np.array([[rng.uniform(-3, 3) for _ in chain.q] for _ in range(3)])
    try:
        largest = np.abs(NumericChain(chain, values).jacobian(q)).max(axis=(0, 2))
    except TypeError:  # a constant is not real for these lengths, e.g. sqrt(a1**2 - d1**2)
        return (False,) * len(TASK_ROWS)
    return tuple(bool(size > _NONZERO_THRESHOLD) for size in largest)


def default_task(chain: Chain) -> tuple[str, ...]:
    """Return the default task of an arm, for a file without `task`; the module's docstring gives the rules."""
    moves = (is_clear or any(derive(chain).geometric.row(i)) for i, is_clear in enumerate(_moves_somewhere(chain)))
    moving_rows = tuple(compress(TASK_ROWS, moves))
    if chain.n >= 6 and len(moving_rows) == len(TASK_ROWS):
        return TASK_ROWS
    if chain.n == 4 and len(moving_rows) == 4:
        return moving_rows
    return tuple(row for row in moving_rows if row[0] == "v") or moving_rows
