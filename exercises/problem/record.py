"""Convert a problem to plain data, and compute the digests that identify the arm, each part and the whole problem.

The data contains everything that determines the problem (table, task, references, given quantities), but no wording and
no figures, so that a corrected sentence does not make it a different problem.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import sympy as sp

from qdot.exercises.arm.chain import CONVENTIONS, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.formula.sympy_text import expression_text
from qdot.exercises.problem.problem import Details, Part, Problem, SymbolInfo

Json = dict[str, Any]


def robot_json(chain: Chain) -> Json:
    """Return a chain as plain data: standard DH rows, base, tool point and task, with expressions as text.

    It has a `convention` only if the arm is not described by this table, and a `twist_order` only if the order of its
    twists is not the default.
    """
    base, point = chain.base, chain.point
    description = {} if chain.convention == CONVENTIONS[0] else {"convention": chain.convention}
    if chain.twist_order in convention_of(chain).twist_orders[1:]:
        description["twist_order"] = chain.twist_order
    row_keys = ("theta", "d", "a", "alpha")
    return {
        "name": chain.name,
        "title": chain.title,
        "joints": [
            {"kind": joint.kind, **{key: expression_text(getattr(joint, key)) for key in row_keys}}
            for joint in chain.joints
        ],
        "base": {"position": [str(value) for value in base.position], "yaw": str(base.yaw), "tilt": str(base.tilt)},
        "point": {"frame": point.frame, "offset": [str(value) for value in point.offset]},
        "task": list(chain.task),
        **description,
    }


def symbol_json(info: SymbolInfo) -> Json:
    """Return the meaning of a symbol as plain data, with a `value` for lengths and angles only."""
    content: Json = {"role": info.role, "unit": info.unit}
    if info.role in ("length", "angle"):
        content["value"] = None if info.value is None else str(info.value)
    return content


def to_plain_data(value: object) -> Any:
    """Return the details of a part as data for JSON, with SymPy expressions as text."""
    if isinstance(value, Details):
        entries = ((field.name, getattr(value, field.name), field.default) for field in fields(value))
        return to_plain_data({name: detail for name, detail, default in entries if detail is not default})
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: to_plain_data(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): to_plain_data(item) for key, item in sorted(value.items(), key=lambda pair: str(pair[0]))}
    if isinstance(value, (tuple, list)):
        return [to_plain_data(item) for item in value]
    if isinstance(value, sp.Expr):
        return expression_text(value)
    return value if value is None or isinstance(value, (str, int, float)) else str(value)


@dataclass(frozen=True)
class Digests:
    """The hexadecimal SHA-256 digests of the whole problem, of its arm, and of each part by name."""

    sha256: str
    arm: str
    parts: Mapping[str, str]


def digests(problem: Problem) -> Digests:
    """Return the digests of a problem. They don't depend on the points, which may change later."""
    arm = _digest(robot_json(problem.chain))
    parts = {part.name: _digest(_part_json(part)) for part in problem.parts}
    return Digests(_digest([problem.id.engine, arm, parts]), arm, parts)


def _part_json(part: Part) -> Json:
    content = {"kind": part.kind, "reference": part.answer.as_json(), "details": to_plain_data(part.details)}
    return {"options": None, **content, **part.answer.options_json()}


def _digest(content: Any) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True, ensure_ascii=False).encode()).hexdigest()
