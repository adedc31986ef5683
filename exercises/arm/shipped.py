"""Precomputed results for the structures of the registered families, in a file beside this one.

A line of the file is a structure's key and, as JSON, its results by the names of the functions that compute them.
Formulas are nodes, each a symbol, a whole number, or an operation on earlier nodes; reading them evaluates nothing, so
that terms keep the order in which SymPy had put them.

The first line has a digest of the code that computed the rest, and the version of SymPy. With any other code or
version, the file is ignored and everything is computed. `python -m qdot.exercises.docs.shipped` writes it.
"""

import hashlib
import json
from collections.abc import Callable, Mapping
from functools import cache, lru_cache, wraps
from pathlib import Path
from typing import Any, TypeVar

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.trigonometry import Factored
from qdot.exercises.formula.text import text_of

Result = TypeVar("Result")

FILE = Path(__file__).with_name("shipped.txt")
MADE_BY = (
    "chain", "conventions/__init__", "conventions/base", "conventions/modified_dh", "conventions/screws",
    "conventions/standard_dh", "vectors", "kinematics", "trigonometry", "shipped", "transforms", "derivation",
)  # fmt: skip
"""The modules on which results depend."""

KINDS: dict[type[sp.Expr], str] = {sp.Add: "+", sp.Mul: "*", sp.Pow: "^", sp.sin: "sin", sp.cos: "cos"}
OPERATIONS = {name: kind for kind, name in KINDS.items()}
PI = "pi"
"""How the number is written: the only operation without operands."""


def once_per_structure(work: Callable[[Chain], Result]) -> Callable[[Chain], Result]:
    """Cache the result of a function for each structure; take it from the shipped file if it is there."""

    @lru_cache(maxsize=4096)
    @wraps(work)
    def look_up(structure: Chain) -> Result:
        known = shipped_results(structure)
        return known[work.__name__] if work.__name__ in known else work(structure)

    return look_up


@lru_cache(maxsize=64)
def shipped_results(structure: Chain) -> Mapping[str, Any]:
    """Return the shipped results of a structure, by the functions' names; none for an unknown structure."""
    start = b"\n" + structure_key(structure) + b" "
    lines = _lines()
    at = lines.find(start)
    return {} if at < 0 else results_from_text(lines[at + len(start) : lines.index(b"\n", at + 1)])


def structure_key(structure: Chain) -> bytes:
    """Return the key of a structure: a digest of everything on which its results depend."""
    base, point = structure.base, structure.point
    rows = [(joint.theta, joint.d, joint.a, joint.alpha) for joint in structure.joints]
    values = [value for row in rows for value in row] + [*base.position, base.yaw, base.tilt, *point.offset]
    kinds = "".join(joint.kind for joint in structure.joints)
    identity = (
        kinds,
        point.frame,
        structure.task,
        structure.convention,
        structure.twist_order,
        [*map(text_of, values)],
    )
    return hashlib.sha256(repr(identity).encode()).hexdigest()[:32].encode()


@cache
def _lines() -> bytes:
    """Return the shipped lines, each after a line break; nothing if other code made them or the file is missing.

    A copy of the code without its sources, as some packaging tools make it, can't tell, and gets nothing.
    """
    try:
        made_by, *rest = FILE.read_bytes().split(b"\n", 1)
        return b"\n" + rest[0] if rest and made_by.strip().decode() == code_digest() else b""
    except (OSError, ValueError):
        return b""


def code_digest() -> str:
    """Return what results depend on: a digest of the code, and the version of SymPy."""
    digest = hashlib.sha256()
    for name in MADE_BY:
        digest.update((FILE.parent / f"{name}.py").read_text(encoding="utf-8").encode() + b"\0")
    return f"{digest.hexdigest()} SymPy {sp.__version__}"


# --- results as text ---


def results_to_text(results: Mapping[str, Any]) -> str:
    """Return results as text. Raises TypeError if something in them has no representation."""
    nodes: list[Any] = []
    places: dict[sp.Expr, int] = {}

    def place(expression: sp.Expr) -> int:
        if expression not in places:
            node = _node(expression, place)
            places[expression] = len(nodes)
            nodes.append(node)
        return places[expression]

    content = {name: _form(result, place) for name, result in sorted(results.items())}
    return json.dumps([nodes, content], separators=(",", ":"))


def _node(expression: sp.Expr, place: Callable[[sp.Expr], int]) -> Any:
    if expression.is_Integer:
        return int(expression)
    if expression.is_Rational:
        return ["/", int(expression.p), int(expression.q)]
    if expression == sp.pi:
        return [PI]
    if expression == sp.Symbol(str(expression)):
        return str(expression)
    if type(expression) in KINDS:
        return [KINDS[type(expression)], *map(place, expression.args)]
    raise TypeError(f"{expression} has no form in {FILE.name}")


def _form(result: object, place: Callable[[sp.Expr], int]) -> Any:
    if isinstance(result, int):
        return {"count": result}
    if isinstance(result, sp.Expr):
        return place(result)
    if isinstance(result, tuple):
        return [_form(part, place) for part in result]
    if isinstance(result, sp.MatrixBase):
        return {"columns": result.cols, "entries": [place(entry) for entry in result]}
    if isinstance(result, Factored):
        factors = [[place(factor), int(power)] for factor, power in result.factors]
        return {"coefficient": place(result.coefficient), "factors": factors}
    raise TypeError(f"{type(result).__name__} has no form in {FILE.name}")


def results_from_text(text: str | bytes) -> dict[str, Any]:
    """Return the results that this text represents. Raises ValueError for any other text."""
    nodes, content = json.loads(text)
    made: list[sp.Expr] = []
    for node in nodes:
        made.append(_expression(node, made))
    return {name: _result(form, made) for name, form in content.items()}


def _expression(node: Any, made: list[sp.Expr]) -> sp.Expr:
    if isinstance(node, str):
        return sp.Symbol(node)
    if isinstance(node, int):
        return sp.Integer(node)
    operation, *operands = node
    if operation in OPERATIONS:
        return OPERATIONS[operation](*(_node_at(made, operand) for operand in operands), evaluate=False)
    if operation == "/":
        return sp.Rational(*operands)
    if operation == PI:
        return sp.pi
    raise ValueError(f"{operation!r} is no operation")


def _node_at(made: list[sp.Expr], number: int) -> sp.Expr:
    if not 0 <= number < len(made):
        raise ValueError(f"there is no node {number} among {len(made)}")
    return made[number]


def _result(form: Any, made: list[sp.Expr]) -> Any:
    if isinstance(form, int):
        return _node_at(made, form)
    if isinstance(form, list):
        return tuple(_result(part, made) for part in form)
    if "count" in form:
        return int(form["count"])
    if "entries" in form:
        entries = [_node_at(made, entry) for entry in form["entries"]]
        return sp.Matrix(len(entries) // form["columns"], form["columns"], entries)
    factors = tuple((_node_at(made, factor), power) for factor, power in form["factors"])
    return Factored(_node_at(made, form["coefficient"]), factors)
