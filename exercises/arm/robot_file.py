"""ROBOT.toml: a user's own arm, read with every mistake told by file, joint and key.

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

Without `task`, the rows are: all six for six joints or more; for four joints those of the four rows in which the arm
moves, if they are four (SCARA); else the linear rows in which the point moves.
"""

import difflib
import operator
import re
import tomllib
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import sympy as sp

from exercises.arm.chain import TASK_ROWS, Chain, Joint, Point
from exercises.arm.derivation import derive
from exercises.errors import QdotError
from exercises.formula.expression import Node, ReadError, read

ROW_KEYS = ("kind", "theta", "d", "a", "alpha")
TOP_KEYS = ("name", "task", "point", "joint", "draw")
_LENGTH, _EXPONENT, _BASE = 200, 20, 10**6
_OPERATIONS = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv}
_FUNCTIONS = {name: getattr(sp, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt")}


@dataclass(frozen=True)
class Robot:
    """What a file describes: a chain, and the lengths to be drawn as (symbol, least, greatest) in whole centimetres."""

    chain: Chain
    draws: tuple[tuple[sp.Symbol, int, int], ...] = ()


def read_robot(path: Path) -> Chain:
    """Return the chain that a file describes, its lengths open. Raises QdotError as `read_robot_file` does."""
    return read_robot_file(path).chain


def read_robot_file(path: Path) -> Robot:
    """Return the robot that a file describes. Raises QdotError with the file, the joint and key, and what is right."""
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"), parse_float=Decimal)
    except OSError as error:
        raise QdotError(f"{path} can't be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise QdotError(f"{path} is not text in UTF-8") from None
    except tomllib.TOMLDecodeError as error:
        raise QdotError(f"{path} is not valid TOML: {error}") from None
    try:
        chain = chain_of(table)
        return Robot(chain, _draws(table.get("draw", {}), chain))
    except QdotError as error:
        raise QdotError(f"{path}: {error}") from None


def chain_of(table: dict[str, Any]) -> Chain:
    """Return the chain of a table as TOML gives it. Raises QdotError."""
    _check_keys(table, TOP_KEYS, ("name", "joint"), "the file")
    name, rows = table["name"], table["joint"]
    if not isinstance(name, str) or not name.strip():
        raise QdotError(f'name = {name!r}; it is a text, as in name = "my arm"')
    if not isinstance(rows, list) or not rows or not all(isinstance(row, dict) for row in rows):
        raise QdotError("joints are given as [[joint]] tables, one for each row of the DH table")
    joints = tuple(_joint(number, row) for number, row in enumerate(rows, 1))
    point = _point(table["point"], len(joints)) if "point" in table else None
    plain = " ".join(name.split())
    chain = Chain(plain, joints, ("vx",), tool=point, title=plain)
    return chain.with_task(*(_task(table["task"]) if "task" in table else default_task(chain)))


def _draws(raw: object, chain: Chain) -> tuple[tuple[sp.Symbol, int, int], ...]:
    right = "[draw] gives lengths of the table a range in metres, as in a1 = [0.3, 0.8]"
    if not isinstance(raw, dict):
        raise QdotError(f"draw = {raw!r}; {right}")
    angles = set[sp.Basic]().union(*(value.free_symbols for j in chain.joints for value in (j.theta, j.alpha)))
    found = []
    for name, ends in raw.items():
        symbol = sp.Symbol(name)
        if symbol not in chain.parameters:
            open_lengths = ", ".join(s.name for s in chain.parameters if s not in angles) or "none"
            raise QdotError(f"draw: {name!r} is no open length of the table; open are: {open_lengths}")
        if symbol in angles:
            raise QdotError(f"draw: {name!r} is an angle; {right}")
        numbers = isinstance(ends, list) and len(ends) == 2 and all(_is_length(end) for end in ends)
        if not numbers or not 0 < ends[0] < ends[1]:
            raise QdotError(f"draw: {name} = {shown(ends)}; {right}")
        low, high = (round(100 * end) for end in ends)
        if low < 1 or low >= high:
            raise QdotError(f"draw: {name} = {shown(ends)}; lengths are drawn in whole centimetres, from 0.01")
        found.append((symbol, low, high))
    return tuple(found)


def _is_length(value: object) -> bool:
    return isinstance(value, (int, Decimal)) and not isinstance(value, bool) and 0 < value < 1000


def _check_keys(table: dict[str, Any], known: tuple[str, ...], needed: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in known:
            close = difflib.get_close_matches(key, known, n=1)
            hint = f" (did you mean {close[0]!r}?)" if close else ""
            raise QdotError(f"{where}: unknown key {key!r}{hint}; known: {', '.join(known)}")
    for key in needed:
        if key not in table:
            raise QdotError(f"{where}: {key!r} is missing; needed: {', '.join(needed)}")


def _joint(number: int, row: dict[str, Any]) -> Joint:
    where = f"joint {number}"
    _check_keys(row, ROW_KEYS, ROW_KEYS, where)
    kind = row["kind"]
    if kind not in ("R", "P"):
        raise QdotError(f'{where}: kind = {kind!r}; it is "R" (revolute) or "P" (prismatic)')
    values = {key: value_of(row[key], f"{where}: {key}", key in ("theta", "alpha")) for key in ROW_KEYS[1:]}
    key, variable = ("theta", sp.Symbol(f"theta{number}")) if kind == "R" else ("d", sp.Symbol(f"d{number}"))
    if variable not in values[key].free_symbols:
        example = f"{variable} + {'pi/2' if kind == 'R' else '0.2'}"
        raise QdotError(
            f'{where}: {key} = {shown(row[key])}; a joint of kind "{kind}" moves by its own variable there: '
            f'{key} = "{variable}", with a constant added if wanted, as in "{example}"'
        )
    return Joint(kind, **values)


def value_of(raw: object, where: str, is_angle: bool) -> sp.Expr:
    """Return a table entry as an exact SymPy expression; decimals become fractions. Raises QdotError."""
    if isinstance(raw, bool) or not isinstance(raw, (int, Decimal, str)):
        raise QdotError(f"{where} = {shown(raw)}; it is a number or an expression in quotes")
    if isinstance(raw, str):
        if len(raw) > _LENGTH:
            raise QdotError(f"{where} is {len(raw)} characters long; at most {_LENGTH} are read")
        try:
            value = to_sympy(read(raw))
        except ReadError as error:
            raise QdotError(f"{where} = {raw!r}: {error}") from None
    elif isinstance(raw, Decimal) and not raw.is_finite():
        raise QdotError(f"{where} = {raw}; it is a finite number")
    else:
        fraction = Fraction(raw)
        value = sp.Rational(fraction.numerator, fraction.denominator)
    if is_angle:
        _check_angle(value, where)
    return value


def shown(raw: object) -> str:
    """Return a value as the file has it."""
    return str(raw) if isinstance(raw, Decimal) else repr(raw)


def _check_angle(value: sp.Expr, where: str) -> None:
    """Refuse a decimal that stands for a multiple of pi/12, and degrees: both would spoil every formula."""
    constant = sp.Add(*(term for term in sp.Add.make_args(sp.expand(value)) if term.is_number))
    if not constant.is_Rational or constant == 0:
        return
    twelfths = float(constant) / (float(sp.pi) / 12)
    nearest = round(twelfths)
    if nearest and abs(twelfths - nearest) < 0.005:
        raise QdotError(
            f'{where}: {float(constant):g} looks like an angle rounded; write it exactly, "{sp.pi * nearest / 12}"'
        )
    if abs(constant) > 7:
        exact = sp.pi * constant / 180
        raise QdotError(f'{where}: angles are in radians; {float(constant):g} degrees would be "{exact}"')


def to_sympy(node: Node) -> sp.Expr:
    """Return the SymPy expression of a tree of plain arithmetic. Raises ReadError for anything else."""
    if node.kind in ("number", "decimal"):
        return sp.Rational(node.value.numerator, node.value.denominator)
    if node.kind == "name":
        return _symbol(str(node.value))
    if node.kind == "call" and node.value in _FUNCTIONS:
        return _finite(_FUNCTIONS[node.value](*(to_sympy(arg) for arg in node.args)), f"{node.value}(…)")
    if node.kind == "neg":
        return -to_sympy(node.args[0])
    if node.kind == "^":
        return _power(*(to_sympy(arg) for arg in node.args))
    if node.kind in ("+", "-", "*", "/"):
        left, right = (to_sympy(arg) for arg in node.args)
        if node.kind == "/" and right == 0:
            raise ReadError("a division by zero")
        return _OPERATIONS[node.kind](left, right)
    what = f"the function {node.value!r}" if node.kind == "call" else f"a {node.kind}"
    raise ReadError(f"{what} can't stand in a DH table")


def _symbol(name: str) -> sp.Expr:
    if name == "pi":
        return sp.pi
    if not re.fullmatch(r"[A-Za-z][A-Za-z]*\d*", name) or name in ("E", "I"):
        raise ReadError(
            f"{name!r} is no name for a length or angle; use letters with a number behind, as in a1 or alpha2"
        )
    if re.fullmatch(r"qd\d*|[vw][xyz]|blank", name):
        raise ReadError(f"the name {name!r} means something else: qd1 … are joint rates, vx … wz velocities")
    return sp.Symbol(name)


def _power(base: sp.Expr, exponent: sp.Expr) -> sp.Expr:
    if not exponent.is_Rational or abs(exponent) > _EXPONENT:
        raise ReadError(f"an exponent is a number of at most {_EXPONENT}")
    if base.is_number and abs(base) > _BASE:
        raise ReadError("a power is too large for a length or an angle")
    return _finite(base**exponent, "a power")


def _finite(value: sp.Expr, what: str) -> sp.Expr:
    if value.has(sp.zoo, sp.oo, sp.nan) or value.is_real is False:
        raise ReadError(f"{what} that is no real number")
    return value


def _point(raw: object, n: int) -> Point:
    right = f'point is the origin of a frame, "O0" … "O{n}", or [x, y, z] in the last frame'
    if isinstance(raw, str):
        match = re.fullmatch(r"O_?(\d{1,2})", raw)
        if match is None or int(match.group(1)) > n:
            raise QdotError(f"point = {raw!r}; {right}")
        return Point(int(match.group(1)))
    if not isinstance(raw, list) or len(raw) != 3:
        raise QdotError(f"point = {raw!r}; {right}")
    x, y, z = (value_of(value, f"point, {axis}", False) for value, axis in zip(raw, "xyz", strict=True))
    return Point(n, (x, y, z))


def _task(raw: object) -> tuple[str, ...]:
    if not isinstance(raw, list) or not raw or not all(isinstance(row, str) for row in raw):
        raise QdotError(f'task = {raw!r}; it is a list of rows that count, as in ["vx", "vy"]')
    for row in raw:
        if row not in TASK_ROWS:
            close = difflib.get_close_matches(row.lower(), TASK_ROWS, n=1, cutoff=0.5)
            hint = f" (did you mean {close[0]!r}?)" if close else ""
            raise QdotError(f"task: unknown row {row!r}{hint}; known: {', '.join(TASK_ROWS)}")
        if raw.count(row) > 1:
            raise QdotError(f"task: the row {row!r} is named twice")
    return tuple(sorted(raw, key=TASK_ROWS.index))


def default_task(chain: Chain) -> tuple[str, ...]:
    """Return the rows that count where the file names none; see above."""
    geometric = derive(chain).geometric
    moving = tuple(row for i, row in enumerate(TASK_ROWS) if any(entry != 0 for entry in geometric.row(i)))
    if chain.n >= 6:
        return TASK_ROWS
    if chain.n == 4 and len(moving) == 4:
        return moving
    return tuple(row for row in moving if row[0] == "v") or moving
