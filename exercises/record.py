"""A problem as plain data, and the digests by which it is known again: of the arm, of each part, of the whole.

What decides the problem is in it (table, task, references, given quantities); wording and figures are not, so that a
sentence may be mended without making another problem of it.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache
from typing import Any

import sympy as sp

from exercises.arm.chain import Chain
from exercises.formula.printing import Printer
from exercises.problem import (
    Choice,
    ConditionSet,
    Direction,
    Expression,
    Matching,
    Matrix,
    Number,
    Part,
    Problem,
    Selection,
    SymbolInfo,
)

Json = dict[str, Any]


def robot_json(chain: Chain) -> Json:
    """Return a chain as plain data: DH rows, base, point, task; expressions as text."""
    base, point = chain.base, chain.point
    return {
        "name": chain.name,
        "title": chain.title,
        "joints": [
            {"kind": joint.kind, **{name: str(getattr(joint, name)) for name in ("theta", "d", "a", "alpha")}}
            for joint in chain.joints
        ],
        "base": {"position": [str(value) for value in base.position], "yaw": str(base.yaw), "tilt": str(base.tilt)},
        "point": {"frame": point.frame, "offset": [str(value) for value in point.offset]},
        "task": list(chain.task),
    }


def symbol_json(info: SymbolInfo) -> Json:
    """Return what a symbol stands for as plain data; `value` for lengths and angles only."""
    found: Json = {"role": info.role, "unit": info.unit}
    if info.role in ("length", "angle"):
        found["value"] = None if info.value is None else str(info.value)
    return found


@lru_cache(maxsize=1024, typed=True)
def text_of(expression: sp.Expr) -> str:
    """Return an expression as text; kept, for each is wanted by the record, its digest, the tests and the grader."""
    return _known.get((type(expression), expression)) or Printer().doprint(expression)


_known: dict[tuple[type[sp.Expr], sp.Expr], str] = {}
_MOST_KNOWN = 8192


def know_texts(texts: Iterable[tuple[sp.Expr, str]]) -> None:
    """Take the texts of expressions that were kept: SymPy takes half as long to print references as marking does."""
    if len(_known) > _MOST_KNOWN:
        _known.clear()
    _known.update(((type(expression), expression), text) for expression, text in texts)


def entries_of(part: Part) -> list[sp.Expr]:
    """Return the expressions of a reference that are compared as text."""
    answer = part.answer
    if isinstance(answer, Expression):
        return [answer.reference]
    return list(answer.reference) if isinstance(answer, (Matrix, Direction)) else []


class ByText:
    """The end of a key for sorting: an expression's text, the same on every machine, made only where it decides."""

    __slots__ = ("expression",)

    def __init__(self, expression: sp.Expr) -> None:
        self.expression = expression

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ByText) and bool(self.expression == other.expression)

    def __hash__(self) -> int:
        return hash(self.expression)

    def __lt__(self, other: "ByText") -> bool:
        return text_of(self.expression) < text_of(other.expression)


def reference_json(part: Part) -> str | list[Any]:
    """Return a reference: a string, a list for a vector or a set of conditions, a list of rows for a matrix."""
    answer = part.answer
    if isinstance(answer, Expression):
        return text_of(answer.reference)
    if isinstance(answer, ConditionSet):
        return answer.pieces()
    if isinstance(answer, Choice):
        return answer.letter
    if isinstance(answer, (Selection, Matching)):
        return list(answer.letters)
    if isinstance(answer, Number):
        return [f"{float(value):.10g}" if value.is_number else str(value) for value in answer.reference]
    assert isinstance(answer, (Matrix, Direction))
    return matrix_json(answer.reference)


def options_json(part: Part) -> Json:
    """Return the options of a part that has some, and the items that they are matched to."""
    found: Json = {}
    if isinstance(part.answer, (Choice, Selection, Matching)):
        found["options"] = list(part.answer.options)
    if isinstance(part.answer, Matching):
        found["items"] = list(part.answer.items)
    return found


def matrix_json(matrix: sp.Matrix) -> list[Any]:
    """Return a matrix as a list of rows of text, a column as a plain list."""
    if matrix.cols == 1:
        return [text_of(entry) for entry in matrix]
    return [[text_of(entry) for entry in row] for row in matrix.tolist()]


def plain(value: object) -> Any:
    """Return what JSON can hold of the details of a part; SymPy as text."""
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in sorted(value.items(), key=lambda pair: str(pair[0]))}
    if isinstance(value, (tuple, list)):
        return [plain(item) for item in value]
    if isinstance(value, sp.Expr):
        return text_of(value)
    return value if value is None or isinstance(value, (str, int, float)) else str(value)


def digests(problem: Problem) -> Json:
    """Return the SHA-256 of the arm ("arm"), of each part ("parts"), and of all of it together ("sha256").

    Points are left out: they may be changed after handing out.
    """
    arm = _digest(robot_json(problem.chain))
    parts = {part.name: _digest(_part(part)) for part in problem.parts}
    return {"sha256": _digest([problem.id.engine, arm, parts]), "arm": arm, "parts": parts}


def _part(part: Part) -> Json:
    given = {"kind": part.kind, "reference": reference_json(part), "options": None, "details": plain(part.details)}
    return given | options_json(part)


def _digest(content: Any) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True, ensure_ascii=False).encode()).hexdigest()
