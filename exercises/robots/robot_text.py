"""Write an arm as a ROBOT.toml in any convention; reading that file gives the same arm."""

from collections.abc import Iterable, Sequence
from decimal import Decimal

import sympy as sp

from qdot.exercises.arm.chain import DEFAULT_CONVENTION, DEFAULT_TWIST_ORDER, Chain, Point
from qdot.exercises.arm.conventions import REGISTRY
from qdot.exercises.arm.conventions.base import Convention
from qdot.exercises.arm.standard_table import compute_home_geometry
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.input_file import format_toml
from qdot.exercises.robots.robot_file import Robot

TomlEntries = Sequence[tuple[str, str]]
"""Keys, each with its value as TOML text."""


def write_robot_text(robot: Robot, convention: str) -> str:
    """Return the text of a ROBOT.toml that describes an arm in a convention, with its limits and ranges of lengths.

    Raises QdotError if the convention can't describe the arm.
    """
    chain = robot.chain
    presentation = REGISTRY[convention](chain)
    is_table = presentation.shows_table
    point_and_base, joints = _make_table_entries(presentation) if is_table else _make_screw_entries(chain)
    top_entries = [("name", format_toml(chain.title or chain.name))]
    top_entries += [("source", format_toml(robot.source))] if robot.source else []
    top_entries += [("convention", format_toml(convention))] if convention != DEFAULT_CONVENTION else []
    if presentation.twist_orders and chain.twist_order != DEFAULT_TWIST_ORDER:
        top_entries.append(("twist_order", format_toml(chain.twist_order)))
    top_entries += [("task", format_toml(list(chain.task))), *point_and_base]
    limits = [*robot.limits, *[None] * (chain.n - len(robot.limits))]
    sections = [_format_lines(top_entries)]
    for joint, joint_limits in zip(joints, limits, strict=True):
        limit_entry = [("limits", _format_list(joint_limits))] if joint_limits else []
        sections.append(f"[[joint]]\n{_format_lines([*joint, *limit_entry])}")
    # the ranges are in whole cm, but the file's lengths are in m
    ranges = [
        (length.symbol.name, f"[{length.min_cm / 100:g}, {length.max_cm / 100:g}]") for length in robot.length_ranges
    ]
    sections += [f"[draw]\n{_format_lines(ranges)}"] if ranges else []
    return "\n".join(sections)


def _format_lines(entries: TomlEntries) -> str:
    return "".join(f"{key} = {value}\n" for key, value in entries)


def _make_table_entries(convention: Convention) -> tuple[TomlEntries, list[TomlEntries]]:
    """Return the top-level entries, and the entries of each joint, for an arm that is described by a table."""
    chain, base, point = convention.chain, convention.base, convention.point
    top_entries: list[tuple[str, str]] = []
    if chain.tool is not None or convention.find_step_to_standard_frame(chain.n) != (0, 0):
        top_entries.append(("point", _format_point(point, point.frame == chain.n)))
    if not base.is_world:
        top_entries.append(("base", _format_pose(base.position, (base.tilt, sp.S.Zero, base.yaw))))
    joints: list[TomlEntries] = []
    for row in convention.rows:
        entries = ((key, _format_entry(getattr(row, key))) for key in convention.joint_keys[1:])
        joints.append([("kind", format_toml(row.kind)), *entries])
    return top_entries, joints


def _make_screw_entries(chain: Chain) -> tuple[TomlEntries, list[TomlEntries]]:
    """Return the top-level entries, and the entries of each joint, for an arm that is described by its axes.

    Raises QdotError if the direction of an axis contains symbols.
    """
    axes, (x, y, z) = compute_home_geometry(chain)
    home_point = Point(chain.point.frame, (x, y, z))
    joints: list[TomlEntries] = []
    for number, axis in enumerate(axes, 1):
        if axis.direction.free_symbols:
            raise QdotError(f"axis {number} of {chain.name} is rotated by a symbolic angle; axes must be numeric")
        point_entry = [("point", _format_list(axis.point))] if axis.is_revolute else []
        joints.append([("kind", format_toml(axis.kind)), ("axis", _format_list(axis.direction)), *point_entry])
    return [("point", _format_point(home_point, chain.point.frame == chain.n, is_at_home=True))], joints


def _format_point(point: Point, is_in_last_frame: bool, is_at_home: bool = False) -> str:
    """Return the point of interest as TOML text; the text names the frame unless the frame is the last."""
    if point.is_origin and not is_at_home:
        return format_toml(f"O{point.frame}")
    offset = _format_list(point.offset)
    return offset if is_in_last_frame else f"{{frame = {point.frame}, offset = {offset}}}"


def _format_pose(position: Sequence[sp.Expr], rpy: Sequence[sp.Expr]) -> str:
    rotation = f", rpy = {_format_list(rpy)}" if any(rpy) else ""
    return f"{{position = {_format_list(position)}{rotation}}}"


def _format_list(values: Iterable[sp.Expr]) -> str:
    return f"[{', '.join(_format_entry(sp.sympify(value)) for value in values)}]"


def _format_entry(value: sp.Expr) -> str:
    """Return an entry as TOML text: a number if a decimal is exact, else a formula in quotes."""
    if value.is_Rational and value.q < 10**9 and 10**30 % value.q == 0:  # the denominator has only factors 2 and 5
        return str(value.p) if value.q == 1 else format((Decimal(value.p) / Decimal(value.q)).normalize(), "f")
    return format_toml(sp.sstr(value))
