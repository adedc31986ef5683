"""ROBOT.toml: a user's own arm, read with every mistake told by file, line, joint and key.

    name = "my arm"
    task = ["vx", "vy"]            # optional: the rows that count
    point = "O2"                   # optional: origin of a frame, or [x, y, z] in the last frame
    [[joint]]
    kind = "R"
    theta = "theta1"
    d = 0
    a = "a1"
    alpha = "pi/2"

    [draw]                         # optional, for assignments: lengths drawn for each student, in metres
    a1 = [0.3, 0.8]

Without `task`, the rows are: all six for six joints or more that can move in all of them; for four joints those of the
four rows in which the arm moves, if they are four (SCARA); else the linear rows in which the point moves.
"""

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from pathlib import Path
from typing import Any

import sympy as sp

from exercises.arm.chain import TASK_ROWS, Chain, Joint, Point
from exercises.arm.derivation import derive
from exercises.arm.entry import check_role, doubt, value_of
from exercises.errors import QdotError
from exercises.input_file import Place, TomlFile, read_toml, shown

ROW_KEYS = ("kind", "theta", "d", "a", "alpha")
ANGLES = ("theta", "alpha")
MOST_JOINTS = 10
"""The proof that both routes give the same Jacobian takes twice as long for each parallel joint more."""
TOP_KEYS = ("name", "task", "point", "joint", "draw")
_RANGE = "a length has a range in metres, as in a1 = [0.3, 0.8]"


@dataclass(frozen=True)
class Robot:
    """What a file describes: a chain, and the lengths to be drawn as (symbol, least, greatest) in whole centimetres.

    `notes` are messages about what may be right, but is probably a mistake.
    """

    chain: Chain
    draws: tuple[tuple[sp.Symbol, int, int], ...] = ()
    notes: tuple[str, ...] = ()


def read_robot(path: Path) -> Chain:
    r"""Return the chain that a file describes, its lengths open. Raises QdotError as `read_robot_file` does.

    >>> import tempfile
    >>> row = 'kind = "R"\ntheta = "theta1"\nd = 0\na = "a1"\nalpha = 0'
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "arm.toml"
    ...     _ = path.write_text(f'name = "mine"\ntask = ["vx"]\n[[joint]]\n{row}')
    ...     read_robot(path)
    Chain(mine: R, vx of frame 1)
    """
    return read_robot_file(path).chain


def read_robot_file(path: Path) -> Robot:
    """Return the robot that a file describes. Raises QdotError with the file, line, place and what is right."""
    file = read_toml(path)
    chain = _chain(file)
    draws = _draws(file, chain)
    return Robot(chain, draws, _notes(file, chain, draws))


def _chain(file: TomlFile) -> Chain:
    table = file.content
    file.check_keys((), TOP_KEYS, ("name", "joint"))
    with file.at("name"):
        if not isinstance(table["name"], str) or not table["name"].strip():
            raise QdotError('it is a text, as in name = "my arm"')
    rows = table["joint"]
    with file.at("joint"):
        if not isinstance(rows, list) or not rows or not all(isinstance(row, dict) for row in rows):
            raise QdotError("joints are given as [[joint]] tables, one for each row of the DH table")
        if len(rows) > MOST_JOINTS:
            raise QdotError(f"{len(rows)} joints are too many to be worked out; an arm has up to {MOST_JOINTS}")
    kinds = [_kind(file, index, row) for index, row in enumerate(rows)]
    variables = [sp.Symbol(f"{'theta' if kind == 'R' else 'd'}{i}") for i, kind in enumerate(kinds, 1)]
    joints = tuple(_joint(file, index, variables) for index in range(len(rows)))
    point = None
    if "point" in table:
        with file.at("point"):
            point = _point(table["point"], variables)
    plain = " ".join(table["name"].split())
    chain = Chain(plain, joints, ("vx",), tool=point, title=plain)
    if "task" not in table:
        return chain.with_task(*default_task(chain))
    with file.at("task"):
        return chain.with_task(*_task(table["task"]))


def _kind(file: TomlFile, index: int, row: dict[str, Any]) -> str:
    file.check_keys(("joint", index), ROW_KEYS, ROW_KEYS, TOP_KEYS)
    with file.at("joint", index, "kind"):
        if row["kind"] not in ("R", "P"):
            raise QdotError('it is "R" (revolute) or "P" (prismatic)')
    return str(row["kind"])


def _joint(file: TomlFile, index: int, variables: Sequence[sp.Symbol]) -> Joint:
    row, own = file.content["joint"][index], variables[index]
    kind, moving = row["kind"], "theta" if row["kind"] == "R" else "d"
    values = {}
    for key in (moving, *(key for key in ROW_KEYS[1:] if key != moving)):  # what moves is what is mostly wrong
        with file.at("joint", index, key):
            values[key] = value_of(row[key], key in ANGLES)
            rest = _rest(values[key], own, kind) if key == moving else values[key]
            _check_symbols(rest, variables)
            check_role(rest, key in ANGLES)
    return Joint(kind, **values)


def _rest(value: sp.Expr, own: sp.Symbol, kind: str) -> sp.Expr:
    """Return what is added to a joint's own variable. Raises QdotError."""
    rest = sp.expand(value - own)
    if own in rest.free_symbols:
        key, offset = ("theta", "pi/2") if kind == "R" else ("d", "0.2")
        raise QdotError(
            f'a joint of kind "{kind}" moves by its own variable there: {key} = "{own}", with a constant added if '
            f'wanted, as in "{own} + {offset}"'
        )
    return rest


def _check_symbols(value: sp.Expr, variables: Sequence[sp.Symbol]) -> None:
    """Refuse the variables of joints, and of joints that there aren't."""
    for symbol in sorted(value.free_symbols, key=str):
        if symbol in variables:
            number = list(variables).index(symbol) + 1
            raise QdotError(f"{symbol} is the variable of joint {number}, and stands nowhere but in its own row")
        match = re.fullmatch(r"theta(\d+)", symbol.name)
        if match and not 0 < int(match.group(1)) <= len(variables):
            raise QdotError(f"{symbol} belongs to no joint; the last one is joint {len(variables)}")


def _point(raw: object, variables: Sequence[sp.Symbol]) -> Point:
    n = len(variables)
    right = f'it is the origin of a frame, "O0" … "O{n}", or [x, y, z] in the last frame'
    if isinstance(raw, str):
        match = re.fullmatch(r"O_?(\d{1,2})", raw)
        if match is None or int(match.group(1)) > n:
            raise QdotError(right)
        return Point(int(match.group(1)))
    if not isinstance(raw, list) or len(raw) != 3:
        raise QdotError(right)
    x, y, z = (_coordinate(axis, value, variables) for axis, value in zip("xyz", raw, strict=True))
    return Point(n, (x, y, z))


def _coordinate(axis: str, raw: object, variables: Sequence[sp.Symbol]) -> sp.Expr:
    try:
        value = value_of(raw, False)
        _check_symbols(value, variables)
        check_role(value, False)
    except QdotError as error:
        raise QdotError(f"{axis} = {shown(raw)}: {error}") from None
    return value


def _task(raw: object) -> tuple[str, ...]:
    if not isinstance(raw, list) or not raw or not all(isinstance(row, str) for row in raw):
        raise QdotError('it is a list of the rows that count, as in ["vx", "vy"]')
    for row in raw:
        if row not in TASK_ROWS:
            meant = f"v{row.lower()}" if row.lower() in ("x", "y", "z") else row.lower()
            close = difflib.get_close_matches(meant, TASK_ROWS, n=1, cutoff=0.5)
            hint = f" (did you mean {close[0]!r}?)" if close else ""
            raise QdotError(f"unknown row {row!r}{hint}; known: {', '.join(TASK_ROWS)}")
        if raw.count(row) > 1:
            raise QdotError(f"the row {row!r} is named twice")
    return tuple(sorted(raw, key=TASK_ROWS.index))


# --- lengths that are drawn ---


def _draws(file: TomlFile, chain: Chain) -> tuple[tuple[sp.Symbol, int, int], ...]:
    raw = file.content.get("draw", {})
    with file.at("draw"):
        if not isinstance(raw, dict):
            raise QdotError("it is a table, [draw], in which " + _RANGE)
    angles = set[sp.Basic]().union(*(value.free_symbols for j in chain.joints for value in (j.theta, j.alpha)))
    ranges = []
    for name, ends in raw.items():
        symbol = sp.Symbol(name)
        with file.at("draw", name):
            if symbol not in chain.parameters:
                open_lengths = ", ".join(s.name for s in chain.parameters if s not in angles) or "none"
                raise QdotError(f"{name!r} is no open length of the table; open are: {open_lengths}")
            if symbol in angles:
                raise QdotError(f"{name!r} is an angle; {_RANGE}")
            ranges.append((symbol, *_range(name, ends)))
    return tuple(ranges)


def _range(name: str, ends: object) -> tuple[int, int]:
    """Return the ends of a range in centimetres."""
    if not isinstance(ends, list) or len(ends) != 2 or not all(map(_is_number, ends)):
        raise QdotError(_RANGE)
    low, high = ends
    if low <= 0:
        raise QdotError(f"{shown(low)} is not positive; {_RANGE}")
    if high >= 1000:
        raise QdotError(f"{shown(high)} is too long; {_RANGE}")
    if low == high:
        raise QdotError(f"both ends are the same, so that nothing is drawn; {_RANGE}")
    if low > high:
        raise QdotError(f"the smaller end stands first; write {name} = {shown([high, low])}")
    first = max(1, int((100 * Decimal(low)).to_integral_value(ROUND_FLOOR)))
    last = int((100 * Decimal(high)).to_integral_value(ROUND_CEILING))
    if first != 100 * low or last != 100 * high:
        wide = max(last, first + 1)
        near = f"{name} = [{first / 100:.2f}, {wide / 100:.2f}]"
        raise QdotError(f"lengths are drawn in whole centimetres; write {near}")
    return first, last


def _notes(file: TomlFile, chain: Chain, draws: Sequence[tuple[sp.Symbol, int, int]]) -> tuple[str, ...]:
    """Return a note for the first length that is probably not in metres."""
    joints = enumerate(chain.joints)
    entries: list[tuple[Place, sp.Expr]]
    entries = [(("joint", i, key), getattr(joint, key)) for i, joint in joints for key in ("d", "a")]
    entries += [(("point",), value) for value in chain.point.offset]
    entries += [(("draw", symbol.name), sp.Rational(high, 100)) for symbol, _, high in draws]
    doubts = [(place, why) for place, value in entries if (why := doubt(value)) is not None]
    if not doubts:
        return ()
    (place, why), more = doubts[0], len(doubts) - 1
    others = f" ({more} more like this)" if more else ""
    return (f"{file.place(*place)}: {why}{others}",)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, Decimal)) and not isinstance(value, bool) and Decimal(value).is_finite()


def default_task(chain: Chain) -> tuple[str, ...]:
    """Return the rows that count where the file names none; see above."""
    geometric = derive(chain).geometric
    moving = tuple(row for i, row in enumerate(TASK_ROWS) if any(entry != 0 for entry in geometric.row(i)))
    if chain.n >= 6 and len(moving) == len(TASK_ROWS):
        return TASK_ROWS
    if chain.n == 4 and len(moving) == 4:
        return moving
    return tuple(row for row in moving if row[0] == "v") or moving
