"""Convert a problem to plain data, and compute digests (SHA-256 hashes) of its arm, its parts and the whole problem.

Certificates contain the digests, by which the grader recognises the problem. The data contains everything that
determines the problem: table, task, reference answers, given quantities. It contains no sentences and no figures, so
digests don't change if the wording is improved.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import sympy as sp

from qdot.exercises.arm.chain import DEFAULT_CONVENTION, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.problem.problem import RECORDED_NAME, Details, Part, Problem, SymbolInfo

Json = dict[str, Any]


def make_arm_json(chain: Chain) -> Json:
    """Return an arm as plain data: standard DH rows, base, tool point and task, with expressions as text.

    The data has a `convention` only if it is not a standard DH table, and a `twist_order` only if it is not the
    default.
    """
    base, point = chain.base, chain.point
    description = {} if chain.convention == DEFAULT_CONVENTION else {"convention": chain.convention}
    if chain.twist_order in convention_of(chain).twist_orders[1:]:
        description["twist_order"] = chain.twist_order
    row_keys = ("theta", "d", "a", "alpha")
    return {
        "name": chain.name,
        "title": chain.title,
        "joints": [
            {"kind": joint.kind, **{key: format_expression(getattr(joint, key)) for key in row_keys}}
            for joint in chain.joints
        ],
        "base": {"position": [str(value) for value in base.position], "yaw": str(base.yaw), "tilt": str(base.tilt)},
        "point": {"frame": point.frame, "offset": [str(value) for value in point.offset]},
        "task": list(chain.task),
        **description,
    }


def make_symbol_json(info: SymbolInfo) -> Json:
    """Return the meaning of a symbol as plain data; only lengths and angles have a `value`."""
    content: Json = {"role": info.role, "unit": info.unit}
    if info.role in ("length", "angle"):
        content["value"] = None if info.value is None else str(info.value)
    return content


def to_plain_data(value: object) -> Any:
    """Return the details of a part, or a value in them, as plain data; SymPy expressions become text.

    Fields of `Details` that have their default value are left out. A field has its own name in the data unless
    `recorded_as` gives it another one: "name", or "group.name" in a nested object. So a field can be renamed without
    changing the digests.
    """
    if is_dataclass(value) and not isinstance(value, type):
        content: Json = {}
        for field in fields(value):
            detail = getattr(value, field.name)
            if not (isinstance(value, Details) and detail is field.default):
                *groups, name = field.metadata.get(RECORDED_NAME, field.name).split(".")
                group = content.setdefault(groups[0], {}) if groups else content
                group[name] = to_plain_data(detail)
        return content
    if isinstance(value, Mapping):
        return {str(key): to_plain_data(item) for key, item in sorted(value.items(), key=lambda pair: str(pair[0]))}
    if isinstance(value, (tuple, list)):
        return [to_plain_data(item) for item in value]
    if isinstance(value, sp.Expr):
        return format_expression(value)
    return value if value is None or isinstance(value, (str, int, float)) else str(value)


@dataclass(frozen=True)
class Digests:
    """The hexadecimal digests of the whole problem (`sha256`), of its arm, and of each part by name."""

    sha256: str
    arm: str
    parts: Mapping[str, str]


def compute_digests(problem: Problem) -> Digests:
    """Return the digests of a problem. They don't depend on the points, which instructors may change later."""
    arm = _compute_digest(make_arm_json(problem.chain))
    parts = {part.name: _compute_digest(_make_part_json(part)) for part in problem.parts}
    return Digests(_compute_digest([problem.id.engine, arm, parts]), arm, parts)


def _make_part_json(part: Part) -> Json:
    """Return the question and the answer, without the words about wrong options, which may be improved later."""
    details = to_plain_data(part.details)
    details.pop("blames", None)
    content = {"kind": part.kind, "reference": part.answer.as_json(), "details": details}
    return {"options": None, **content, **part.answer.to_options_json()}


def _compute_digest(content: Any) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True, ensure_ascii=False).encode()).hexdigest()
