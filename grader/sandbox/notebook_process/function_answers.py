"""Evaluate answers that are Python functions, in the process in which a notebook runs.

A function is first called with symbols, and the grader compares the resulting formula exactly. During this call, the
functions of `math` and NumPy accept symbols. Some functions need numbers, because they fill an array, invert a matrix
or test a sign. Such a function is called with numbers instead, at points that the grader chooses again for every
submission, and the function's values are reported.
"""

import contextlib
import functools
import inspect
import json
import math
import re
import types
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy
import sympy

PYTHON_FUNCTIONS = types.FunctionType, types.MethodType, functools.partial
"""The types of functions that are written in Python; `FUNCTION_TYPES` are all types of functions."""
FUNCTION_TYPES = (*PYTHON_FUNCTIONS, numpy.vectorize, numpy.ufunc, sympy.Lambda)

TABLE_PREFIX = "function: "
"""The prefix of an answer that is a table of values, not a formula: JSON with the shape and a row for each point."""

# Accepted parameter names for the vector of joint variables or of joint rates, and for a single variable or rate.
_JOINT_VECTOR_NAME = re.compile(r"q|th|theta|thetas|joints|angles|qs|config|configuration|pose")
_RATE_VECTOR_NAME = re.compile(r"qd|dq|qp|q_?dot|d?theta_?dot|dtheta|rates|thetad")
_JOINT_NAME = re.compile(r"(?:theta|th|q|t|d|θ)_?(\d)")
_RATE_NAME = re.compile(
    r"(?:qd|dq|qp|q_?dot|theta_?dot|dtheta|dth|thetad|thd|d_?dot)_?(\d)|(?:theta|th|q|d)_?(\d)_?(?:dot|d)"
)

_ELEMENTWISE: dict[str, Any] = {
    "sin": sympy.sin, "cos": sympy.cos, "tan": sympy.tan, "exp": sympy.exp, "log": sympy.log, "sqrt": sympy.sqrt,
    "sinh": sympy.sinh, "cosh": sympy.cosh, "tanh": sympy.tanh, "arcsin": sympy.asin, "arccos": sympy.acos,
    "arctan": sympy.atan, "arctan2": sympy.atan2, "hypot": lambda x, y: sympy.sqrt(x**2 + y**2),
    "deg2rad": lambda x: x * sympy.pi / 180, "radians": lambda x: x * sympy.pi / 180,
    "rad2deg": lambda x: x * 180 / sympy.pi, "degrees": lambda x: x * 180 / sympy.pi, "fabs": sympy.Abs,
}  # fmt: skip
"""SymPy's functions by the names in NumPy or `math`."""
_NUMPY_NAMES = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2"}
"""The names in NumPy of functions that have other names in `math`."""
MAX_ENTRIES = 100
"""Maximum number of entries of a function's value; no expected answer has so many."""


def evaluate_function(function: Any, arguments: Mapping[str, Any]) -> Any:
    """Return the result of a function called with symbols, or a table of values as text if it is not a formula.

    `arguments` has the fields of `qdot.grader.sandbox.sandbox.FunctionArguments`. Raises whatever the function raises,
    and TypeError if the function can't be called with symbols or at points.
    """
    try:
        with allow_symbols(function):
            result = function(*_match_arguments(function, arguments, sympy.Symbol))
        if _is_formula(result):
            return result
    except Exception:
        if not arguments.get("points"):
            raise
    if not arguments.get("points"):
        raise TypeError(f"the function returns a {type(result).__name__}, not a formula")
    return TABLE_PREFIX + json.dumps(_tabulate_values(function, arguments))


def _is_formula(result: Any) -> bool:
    if isinstance(result, (list, tuple)):
        return all(map(_is_formula, result))
    formula_types = (sympy.Basic, sympy.MatrixBase, numpy.ndarray, numpy.generic, int, float, complex, dict)
    return isinstance(result, formula_types) and not isinstance(result, bool)


def _tabulate_values(function: Any, arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return the shape of a function's values, and its values at the grader's points, as pairs (real, imag)."""
    shape, rows = None, []
    for values in arguments["points"]:
        symbol_values = dict(zip(arguments["symbols"], values, strict=True))
        returned_values = numpy.asarray(function(*_match_arguments(function, arguments, symbol_values.__getitem__)))
        if returned_values.dtype.kind not in "biufcO":
            raise TypeError(f"the function returns a {type(returned_values.flat[0]).__name__}, not a number")
        if shape not in (None, returned_values.shape) or returned_values.ndim > 2 or returned_values.size > MAX_ENTRIES:
            raise TypeError("the function must return a number, a vector or a matrix, always of the same size")
        shape = returned_values.shape
        entries = (complex(entry) for entry in returned_values.flat)  # also converts SymPy's numbers
        rows.append([[entry.real, entry.imag] for entry in entries])
    return {"shape": list(shape or ()), "values": rows}


def _match_arguments(function: Any, arguments: Mapping[str, Any], get_value: Callable[[str], Any]) -> list[Any]:
    """Return the arguments for a function in the order of its parameters, matched by the parameters' names.

    `get_value` returns the symbol with a name, or a number for it.
    """
    if isinstance(function, sympy.Lambda):
        names: list[str] = [str(symbol) for symbol in function.variables]
        takes_any_number = False
    else:
        python_function = function.pyfunc if isinstance(function, numpy.vectorize) else function
        parameters = inspect.signature(python_function).parameters.values()
        positional_kinds = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
        names = [p.name for p in parameters if p.kind in positional_kinds and p.default is inspect.Parameter.empty]
        takes_any_number = any(p.kind is inspect.Parameter.VAR_POSITIONAL for p in parameters)
    joints: list[str] = list(arguments["joints"])
    if takes_any_number and not names:
        return [get_value(joint) for joint in joints]
    targets = [_match_parameter(name, joints, arguments["symbols"]) for name in names]
    if all(target is None for target in targets) and len(names) == len(joints):
        targets = list(joints)  # one parameter for each joint, in order, under names that the student chose
    values = []
    for name, target in zip(names, targets, strict=True):
        if target is None:
            names_text = ", ".join(arguments["symbols"])
            raise TypeError(f"the parameter {name!r} is not a symbol of the problem; known: {names_text}")
        values.append(get_value(target) if isinstance(target, str) else numpy.array([*map(get_value, target)]))
    return values


def _match_parameter(name: str, joints: Sequence[str], symbols: Sequence[str]) -> str | list[str] | None:
    """Return the name of the symbol that a parameter stands for; for a vector, a list of names; None if unknown."""
    plain_name = re.sub(r"_(?=\d)", "", name)
    rates = [f"qd{i}" for i in range(1, len(joints) + 1)]
    if plain_name in symbols:
        return plain_name
    if _JOINT_VECTOR_NAME.fullmatch(name):
        return list(joints)
    if _RATE_VECTOR_NAME.fullmatch(name) and set(rates) <= set(symbols):
        return rates
    for pattern, candidates in ((_RATE_NAME, rates), (_JOINT_NAME, joints)):
        match = pattern.fullmatch(name)
        if match is not None:
            number = int(next(filter(None, match.groups())))
            if 1 <= number <= len(candidates) and candidates[number - 1] in symbols:
                return candidates[number - 1]
    return None


@contextlib.contextmanager
def allow_symbols(function: Any) -> Iterator[None]:
    """Make functions of `math` and NumPy accept symbols during the block, even if a notebook imported them by name.

    `function` is the notebook's function that is called in the block.
    """
    names = [name for name in (*_ELEMENTWISE, *_NUMPY_NAMES) if hasattr(math, name)]
    replacements = {getattr(math, name): _make_function_for_symbols(name) for name in names}
    namespaces: list[dict[str, Any]] = [vars(math), getattr(function, "__globals__", {})]
    originals = [
        (namespace, name, value)
        for namespace in namespaces
        for name, value in namespace.items()
        if isinstance(value, types.BuiltinFunctionType) and value in replacements
    ]
    methods = [name for name in _ELEMENTWISE if not hasattr(sympy.Expr, name)]  # numpy.cos(x) calls x.cos()
    try:
        for namespace, name, value in originals:
            namespace[name] = replacements[value]
        for name in methods:
            setattr(sympy.Expr, name, lambda *arguments, function=_ELEMENTWISE[name]: function(*arguments))
        yield
    finally:
        for namespace, name, value in originals:
            namespace[name] = value
        for name in methods:
            delattr(sympy.Expr, name)


def _make_function_for_symbols(name: str) -> Any:
    """Return a function that calls SymPy's function for symbols, and that of `math` for numbers."""
    numeric_function, symbolic_function = getattr(math, name), _ELEMENTWISE[_NUMPY_NAMES.get(name, name)]

    def call(*arguments: Any) -> Any:
        has_symbols = any(isinstance(argument, sympy.Basic) for argument in arguments)
        return (symbolic_function if has_symbols else numeric_function)(*arguments)

    return call
