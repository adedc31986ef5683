"""Convert answers to text: values of Python, SymPy and NumPy, as a student could have typed them.

Unevaluated operations (Derivative, Integral, Determinant) are evaluated first.
"""

import sys
import types
from decimal import Decimal
from fractions import Fraction
from importlib.machinery import SourceFileLoader
from pathlib import Path
from typing import Any

import mpmath
import numpy
import sympy
from sympy.matrices.expressions.matexpr import MatrixExpr

_PRINTING_FILE = Path(__file__).parents[3] / "exercises" / "formula" / "printing.py"
_printing = types.ModuleType("notebook_process.sympy_text")
SourceFileLoader(_printing.__name__, str(_PRINTING_FILE)).exec_module(_printing)
"""The module that prints formulas for `exercises`, loaded from its file, because qdot is not available here."""

UNEVALUATED_CLASSES = (
    sympy.Derivative, sympy.Integral, sympy.Limit, sympy.Sum, sympy.Product, sympy.Subs, sympy.Determinant,
    sympy.Trace, MatrixExpr,
)  # fmt: skip
"""SymPy's unevaluated operations, which `doit` evaluates."""

REFUSED_CLASSES = {
    sympy.Piecewise: "a Piecewise has a formula for each condition; write one formula, with abs or sign if needed",
    sympy.Indexed: "qdot doesn't accept IndexedBase; use the problem's symbols, as in theta1 instead of theta[1]",
}
"""SymPy's classes that are not accepted as answers, each with advice on what to write instead."""

MAX_LIST_DEPTH = 6
"""Maximum nesting depth of lists; a list that contains itself would have no end."""


def format_value(value: Any, depth: int = 0) -> str:
    """Return a value as the text of an expression; `depth` is the number of lists around the value.

    Raises TypeError if the value is not an expression.
    """
    if depth > MAX_LIST_DEPTH:
        raise TypeError("lists are nested too deeply")
    if _has_type(value, str):
        return str.__str__(value)  # the actual characters, even for a subclass
    if _has_type(value, sympy.MatrixBase, numpy.ndarray, sympy.NDimArray):
        return _format_array(value, depth + 1)
    if _has_type(value, sympy.Basic):
        return _format_sympy(value, depth)
    if _has_type(value, mpmath.matrix):
        return format_value(value.tolist(), depth + 1)
    if _has_type(value, mpmath.mpf, mpmath.mpc):
        return format_value(complex(value) if value.imag else float(value.real))
    if _has_type(value, numpy.generic):
        return format_value(value.item(), depth + 1)
    if value is Ellipsis:  # the placeholder in a released notebook
        return "blank"
    if _has_type(value, Fraction, Decimal):
        return format_value(float(value) if _has_type(value, Decimal) else sympy.Rational(*value.as_integer_ratio()))
    if value is None or _has_type(value, bool, int, float):
        return repr(value)
    if _has_type(value, complex):
        return f"({value.real!r} + I*({value.imag!r}))"
    return _format_container(value, depth + 1)


def _has_type(value: Any, *types: type) -> bool:
    """Return whether a value has one of these types; `isinstance` would believe a value that sets `__class__`."""
    return issubclass(type(value), types)


def _format_array(value: Any, depth: int) -> str:
    if len(value.shape) > 2:
        shape = tuple(map(int, value.shape))
        advice = "for the Jacobian of a column P of formulas, write P.jacobian([theta1, theta2, ...])"
        raise TypeError(f"an array of shape {shape} is not a matrix; {advice}")
    return format_value(value.tolist(), depth)


def _format_sympy(value: Any, depth: int) -> str:
    if isinstance(value, MatrixExpr) and value.has(sympy.MatrixSymbol):
        raise TypeError("a MatrixSymbol has no entries; write the entries, as in Matrix([[a, b], [c, d]])")
    if value.has(*REFUSED_CLASSES):
        raise TypeError(next(advice for cls, advice in REFUSED_CLASSES.items() if value.has(cls)))
    units = sys.modules.get("sympy.physics.units")  # SymPy's units are loaded only if the notebook uses them
    if units is not None and value.has(units.Quantity):
        raise TypeError("qdot doesn't accept units of sympy.physics; write only the number, in m, rad, m/s or rad/s")
    evaluated_value = _evaluate(value)
    if evaluated_value is not value:
        return format_value(evaluated_value, depth + 1)
    if value.has(sympy.sinc):
        return format_value(value.replace(sympy.sinc, lambda x: sympy.sin(x) / x), depth + 1)
    if isinstance(value, sympy.Poly):
        return format_value(value.as_expr(), depth + 1)
    if isinstance(value, sympy.Point):
        return format_value(list(value), depth + 1)
    if isinstance(value, sympy.Eq) and all(isinstance(side, sympy.MatrixBase) for side in value.args):
        lhs, rhs = value.args
        if lhs.shape == rhs.shape:
            return format_value([sympy.Eq(a, b, evaluate=False) for a, b in zip(lhs, rhs, strict=True)], depth + 1)
    return str(_printing.FullPrinter().doprint(value))


def _evaluate(value: Any) -> Any:
    """Return a formula with its unevaluated operations evaluated; the formula itself if it has none or SymPy fails."""
    if not value.has(*UNEVALUATED_CLASSES):
        return value
    try:
        evaluated_value = value.doit()
        evaluated_value = evaluated_value.as_explicit() if isinstance(evaluated_value, MatrixExpr) else evaluated_value
    except Exception:  # SymPy may raise anything
        return value
    return value if evaluated_value == value else evaluated_value


def _format_container(value: Any, depth: int) -> str:
    """Return bytes, a list, set or dictionary as text. Raises TypeError for anything else."""
    if _has_type(value, bytes):
        return bytes.decode(value, errors="replace")
    if _has_type(value, dict):
        return "{" + ", ".join(f"{format_value(k, depth)}: {format_value(v, depth)}" for k, v in value.items()) + "}"
    if _has_type(value, list, tuple):
        return "[" + ", ".join(format_value(item, depth) for item in value) + "]"
    if _has_type(value, set, frozenset):
        return "{" + ", ".join(sorted(format_value(item, depth) for item in value)) + "}"
    if _has_type(value, type) and issubclass(value, sympy.Basic):
        raise TypeError(f"{value.__name__} has no argument; write {value.__name__}(theta1), for example")
    name = type(value).__name__
    raise TypeError(f"a {name} is not an expression{ADVICE_BY_TYPE.get(name, '')}")


_LIST_ADVICE = "; write the list of its entries, as in list(…)"
ADVICE_BY_TYPE = {
    **dict.fromkeys(("generator", "zip", "map", "filter", "range"), _LIST_ADVICE),
    **dict.fromkeys(("dict_values", "dict_items", "dict_keys"), _LIST_ADVICE),
    "DomainMatrix": "; write it as a Matrix, as in M.to_Matrix()",
    "DataFrame": "; write its rows, as in D.values.tolist()",
    "Vector": "; write its components, as in [v.dot(N.x), v.dot(N.y)]",
    "StandIn": "; it replaces a plot or widget, because nothing is displayed when a notebook is graded",
    "module": "; write a formula, as in sin(theta1)",
    "builtin_function_or_method": "; call it with its argument in brackets",
}
"""Maps the name of a type to advice on what to write instead. The types themselves may not be installed (pandas)."""
