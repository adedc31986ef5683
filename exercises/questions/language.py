"""Parse the formulas of custom questions, such as "ddt((o1 + o2)/2)", and compute their values.

A formula has the syntax of a Python expression, with ^ for powers. It is parsed into Python's syntax tree and never
executed: `compute` evaluates a fixed list of operations on the named quantities of an arm (`quantities`). Values are
arrays as in `derivation.graph`: up to two axes for rows and columns, and then one axis of the arithmetic, such as one
entry for each of several configurations.
"""

import ast
import operator
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache, reduce
from typing import Protocol

import numpy as np
import sympy as sp

from qdot.exercises.common.errors import QdotError, make_name_error
from qdot.exercises.derivation import arithmetic
from qdot.exercises.formula.names import normalize_name

MAX_CHARACTERS = 500
"""Maximum number of characters of a formula."""

MAX_DEPTH = 50
"""Maximum depth of the syntax tree of a formula."""

MAX_NUMBER = 1e12
"""The largest number in a formula."""

MAX_POWER = 8
"""Maximum absolute value of an exponent."""

SCALAR_FUNCTIONS = ("sin", "cos", "tan", "asin", "acos", "atan", "sqrt", "exp", "log", "abs")
"""Functions that are applied to each entry."""

_OPERATORS: dict[type[ast.operator], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.MatMult: "*", ast.Div: "/", ast.Pow: "^",
}  # fmt: skip
AXES = {"x": 0, "y": 1, "z": 2}
"""The components of a vector, and their indices."""

_SHAPE_WORDS = {0: "a number", 1: "a vector", 2: "a matrix"}
"""Maps a number of axes to the words for a value with so many axes."""


class FormulaError(QdotError):
    """Raised if a formula can't be parsed, has an unknown name, or makes no sense for an arm.

    `key` is the key in the question's table that must be changed; "" stands for the key with the formula.
    """

    def __init__(self, message: str, key: str = "") -> None:
        super().__init__(message)
        self.key = key


class UnknownName(FormulaError):
    """Raised if a formula contains a name that qdot doesn't know; `known_names` are those that it knows."""

    def __init__(self, kind: str, name: str, known_names: Sequence[str]) -> None:
        message = str(make_name_error(kind, name, known_names))
        if kind != "function" and "did you mean" not in message and not _resembles_known_name(name, known_names):
            message += f'; for a quantity that the arm does not have, such as a mass, write units = {{{name} = "kg"}}'
        super().__init__(message)
        self.name, self.known_names = name, known_names


def _resembles_known_name(name: str, known_names: Sequence[str]) -> bool:
    """Return whether a name is like that of a quantity, apart from its number, such as a7 or d3."""
    letters = name.rstrip("0123456789")
    known_letters = {known_name.rstrip("0123456789") for known_name in known_names}
    return letters != name and letters in known_letters | {"a", "d", "theta", "alpha", "qd", "qdd"}


class Quantities(Protocol):
    """The named quantities of an arm, in one arithmetic, from which the values of formulas are computed."""

    @property
    def names(self) -> tuple[str, ...]:
        """All names that a formula may contain, except those of functions."""

    @property
    def numbers(self) -> Mapping[str, sp.Expr]:
        """The lengths in the arm's table that are numbers, by name."""

    def look_up(self, name: str) -> np.ndarray | None:
        """Return the value of a name, or of a formula such as "det(J)" that is a quantity; None if there is none."""

    def make_constant(self, value: Fraction) -> np.ndarray:
        """Return a number as a value of the arithmetic."""

    def apply(self, function: str, value: np.ndarray) -> np.ndarray:
        """Apply one of SCALAR_FUNCTIONS to each entry."""

    def differentiate(self, formula: ast.expr, rates: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the rate of change of a formula if the symbols change at the given rates."""

    @property
    def time_rates(self) -> Mapping[str, np.ndarray]:
        """The rate of each symbol that changes with time."""

    def substitute_values(self, formula: ast.expr, values: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the value of a formula with other values of some symbols."""


@lru_cache(maxsize=1024)
def parse(text: str) -> ast.expr:
    """Return the syntax tree of a formula. Raises FormulaError.

    >>> ast.unparse(parse("ddt((o_1 + o_2)/2)"))
    'ddt((o1 + o2) / 2)'
    """
    if len(text) > MAX_CHARACTERS:
        raise FormulaError(f"the formula has {len(text)} characters; the limit is {MAX_CHARACTERS}")
    try:
        tree = ast.parse(_convert_to_python(text).strip(), mode="eval").body
    except (SyntaxError, ValueError, MemoryError, RecursionError) as error:
        offset = error.offset if isinstance(error, SyntaxError) and error.offset else 0
        raise FormulaError(f"{text!r} is not a formula{_explain_syntax_error(text, offset)}") from None
    nodes_at_depth: list[ast.AST] = [tree]
    for _ in range(MAX_DEPTH):
        nodes_at_depth = [child for node in nodes_at_depth for child in ast.iter_child_nodes(node)]
    if nodes_at_depth:
        raise FormulaError(f"the formula is nested more than {MAX_DEPTH} deep")
    for node in ast.walk(tree):
        _check_node(node, text)
        if isinstance(node, ast.Name):
            node.id = normalize_name(node.id)
    return tree


def _convert_to_python(text: str) -> str:
    return unicodedata.normalize("NFKC", text).replace("^", "**").replace("·", "*").replace("−", "-").replace("\n", " ")


_CLOSING_BRACKETS = {"(": ")", "[": "]", "{": "}"}


def _explain_syntax_error(text: str, offset: int) -> str:
    """Return why a text can't be parsed, as a clause.

    `offset` is the position of Python's error, from 1; 0 if it is unknown.
    """
    open_brackets: list[tuple[int, str]] = []
    for position, sign in enumerate(text, 1):
        if sign in _CLOSING_BRACKETS:
            open_brackets.append((position, sign))
        elif sign in _CLOSING_BRACKETS.values():
            if not open_brackets or _CLOSING_BRACKETS[open_brackets[-1][1]] != sign:
                return f": the bracket {sign} at character {position} does not close a bracket"
            open_brackets.pop()
    if open_brackets:
        position, sign = open_brackets[-1]
        return f": the bracket {sign} at character {position} is not closed"
    if "\\" in text:
        return ": write it without LaTeX, as in ddt((o1 + o2)/2)"
    if "=" in text and "at(" not in text:
        return ": leave out = and what is before it"
    start = len(text) - len(text.lstrip())  # `offset` counts the characters of the converted text from here
    ends = (k for k in range(start, len(text)) if len(_convert_to_python(text[start : k + 1])) >= offset)
    location = f" at character {next(ends, len(text) - 1) + 1}" if offset else ""
    return f"{location}; write products with * and arguments in brackets, as in 2*sin(theta1) or ddt((o1 + o2)/2)"


def _check_node(node: ast.AST, text: str) -> None:
    """Raise FormulaError if a node of the syntax tree of `text` has no meaning in a formula."""
    if isinstance(node, ast.Constant):
        is_allowed = type(node.value) in (int, float)
        if is_allowed and abs(float(str(node.value))) > MAX_NUMBER:
            raise FormulaError(f"{text!r} contains a number above {MAX_NUMBER:g}")
    elif isinstance(node, ast.Call):
        is_allowed = isinstance(node.func, ast.Name)
    elif isinstance(node, ast.operator):
        is_allowed = type(node) in _OPERATORS
    else:
        is_allowed = isinstance(node, (
            ast.Name, ast.BinOp, ast.UnaryOp, ast.List, ast.Attribute, ast.Subscript, ast.Tuple, ast.keyword,
            ast.UAdd, ast.USub, ast.expr_context,
        ))  # fmt: skip
    if not is_allowed:
        part = ast.unparse(node) if isinstance(node, ast.expr) else type(node).__name__
        raise FormulaError(f"{part!r} in {text!r} is not part of the formula language")


def find_names(formula: ast.expr) -> set[str]:
    """Return the names in a formula, without those of functions."""
    functions = {id(node.func) for node in ast.walk(formula) if isinstance(node, ast.Call)}
    return {node.id for node in ast.walk(formula) if isinstance(node, ast.Name) and id(node) not in functions}


def find_calls(formula: ast.expr) -> set[str]:
    """Return the names of the functions that a formula calls."""
    calls = (node for node in ast.walk(formula) if isinstance(node, ast.Call))
    return {call.func.id for call in calls if isinstance(call.func, ast.Name)}


def compute(formula: ast.expr, quantities: Quantities) -> np.ndarray:
    """Return the value of a formula: an array with up to two axes for rows and columns before the last axis.

    Raises FormulaError for unknown names, and for operations that have no meaning for the shapes of their operands.
    """
    if (value := quantities.look_up(ast.unparse(formula))) is not None:
        return value
    if isinstance(formula, ast.Constant):
        return quantities.make_constant(Fraction(str(formula.value)))
    if isinstance(formula, ast.Name):
        if formula.id in (*SCALAR_FUNCTIONS, *MATRIX_FUNCTIONS, *SPECIAL_FUNCTIONS):
            raise FormulaError(f"{formula.id!r} is a function; write its arguments in brackets, as in {formula.id}(…)")
        raise UnknownName("name", formula.id, quantities.names)
    if isinstance(formula, ast.UnaryOp):
        operand = compute(formula.operand, quantities)
        return -operand if isinstance(formula.op, ast.USub) else operand
    if isinstance(formula, ast.BinOp):
        return _compute_operation(formula, quantities)
    if isinstance(formula, ast.List):
        return _stack([compute(entry, quantities) for entry in formula.elts], formula)
    if isinstance(formula, ast.Attribute):
        return _take_component(formula, compute(formula.value, quantities))
    if isinstance(formula, ast.Subscript):
        return _take_entry(formula, compute(formula.value, quantities))
    if isinstance(formula, ast.Call):
        return _compute_call(formula, quantities)
    raise FormulaError(f"{ast.unparse(formula)!r} can't stand alone in a formula")


def count_axes(value: np.ndarray) -> int:
    """Return the number of axes of a value: 0 for a number, 1 for a vector, 2 for a matrix."""
    return value.ndim - 1  # the last axis is that of the arithmetic


def describe_shape(value: np.ndarray) -> str:
    """Return what a value is, in words.

    >>> describe_shape(np.zeros((2, 3, 1)))
    'a 2 x 3 matrix'
    """
    sizes = " x ".join(map(str, value.shape[:-1]))
    return ("a number", f"a vector of {sizes}", f"a {sizes} matrix")[count_axes(value)]


def _make_shape_error(formula: ast.expr, *values: np.ndarray) -> FormulaError:
    operands = " and ".join(map(describe_shape, values))
    return FormulaError(f"{ast.unparse(formula)!r} has no meaning for {operands}")


def _compute_operation(formula: ast.BinOp, quantities: Quantities) -> np.ndarray:
    """Return a sum, difference, product, quotient or power. Raises FormulaError if the shapes don't fit."""
    symbol = _OPERATORS[type(formula.op)]
    left = compute(formula.left, quantities)
    if symbol == "^":
        return _compute_power(formula, left, quantities)
    right = compute(formula.right, quantities)
    left_axes, right_axes = count_axes(left), count_axes(right)
    if symbol in "+-":
        if left.shape[:-1] != right.shape[:-1]:
            raise _make_shape_error(formula, left, right)
        return left + right if symbol == "+" else left - right
    if symbol == "/":
        if right_axes:
            raise _make_shape_error(formula, left, right)
        return left / right
    if 0 in (left_axes, right_axes):
        return left * right
    if left_axes == 2 and left.shape[1] == right.shape[0]:
        return arithmetic.apply_matrix(left, right) if right_axes == 1 else arithmetic.matrix_product(left, right)
    advice = "; write dot(a, b) or cross(a, b)" if left_axes == right_axes == 1 else ""
    raise FormulaError(f"{_make_shape_error(formula, left, right)}{advice}")


def _compute_power(formula: ast.BinOp, base: np.ndarray, quantities: Quantities) -> np.ndarray:
    """Return a power of a number or of a square matrix. Raises FormulaError for other bases and other exponents."""
    try:
        exponent = Fraction(str(ast.literal_eval(formula.right)))
    except ValueError:
        raise FormulaError(f"the exponent in {ast.unparse(formula)!r} must be a number") from None
    if exponent == Fraction(1, 2) and not count_axes(base):
        return quantities.apply("sqrt", base)
    if exponent.denominator != 1 or abs(exponent) > MAX_POWER or count_axes(base) == 1:
        raise FormulaError(
            f"the exponent in {ast.unparse(formula)!r} must be a whole number from -{MAX_POWER} to {MAX_POWER}, and "
            "its base a number or a square matrix"
        )
    is_number = count_axes(base) == 0
    if exponent == 0 and not is_number:
        raise FormulaError(f"{ast.unparse(formula)!r} is a matrix to the power 0")
    factor = base
    if exponent < 0:
        factor = 1 / base if is_number else _invert(base, formula)
    factors = [factor] * abs(int(exponent))
    return reduce(operator.mul, factors, factor * 0 + 1) if is_number else reduce(arithmetic.matrix_product, factors)


def _stack(entries: list[np.ndarray], formula: ast.expr) -> np.ndarray:
    """Return a vector of numbers, or a matrix of rows."""
    if not entries or len({entry.shape[:-1] for entry in entries}) > 1 or count_axes(entries[0]) > 1:
        raise FormulaError(f"{ast.unparse(formula)!r} is neither a vector [a, b] nor a matrix [[a, b], [c, d]]")
    return np.stack(np.broadcast_arrays(*entries))


def _take_component(formula: ast.Attribute, value: np.ndarray) -> np.ndarray:
    """Return the x, y or z component of a vector of three."""
    if formula.attr not in AXES:
        raise FormulaError(f"{ast.unparse(formula)!r}: the components of a vector are .x, .y and .z")
    if value.shape[:-1] != (3,):
        raise FormulaError(
            f"{ast.unparse(formula)!r}: only a vector of 3 has .x, .y and .z, but this is {describe_shape(value)}"
        )
    return np.asarray(value[AXES[formula.attr]])


def _take_entry(formula: ast.Subscript, value: np.ndarray) -> np.ndarray:
    """Return an entry of a vector or matrix; formulas number rows and columns from 1."""
    indices = formula.slice.elts if isinstance(formula.slice, ast.Tuple) else [formula.slice]
    numbers = [index.value for index in indices if isinstance(index, ast.Constant) and isinstance(index.value, int)]
    sizes = value.shape[:-1]
    if (
        len(numbers) < len(indices)
        or len(numbers) != len(sizes)
        or not all(1 <= number <= size for number, size in zip(numbers, sizes, strict=True))
    ):
        form = "J[1, 2] is the entry in row 1 and column 2; p[1] is the first entry of a vector"
        raise FormulaError(f"{ast.unparse(formula)!r} is not an entry of {describe_shape(value)}; {form}")
    return np.asarray(value[tuple(number - 1 for number in numbers)])


# --- functions ---


def _compute_call(formula: ast.Call, quantities: Quantities) -> np.ndarray:
    """Return the value of a function. Raises FormulaError for unknown functions and unsuitable arguments."""
    assert isinstance(formula.func, ast.Name)
    name = formula.func.id
    if formula.keywords and name != "at":
        raise FormulaError(f"{ast.unparse(formula)!r}: only at(…) has arguments with names, as in at(p, theta1 = 0)")
    if name in SPECIAL_FUNCTIONS:
        return SPECIAL_FUNCTIONS[name](formula, quantities)
    arguments = [compute(argument, quantities) for argument in formula.args]
    if name in SCALAR_FUNCTIONS:
        (argument,) = _check_arguments(formula, arguments, (0,))
        return quantities.apply(name, argument)
    if name not in MATRIX_FUNCTIONS:
        raise UnknownName("function", name, [*SCALAR_FUNCTIONS, *MATRIX_FUNCTIONS, *SPECIAL_FUNCTIONS])
    axis_counts, function = MATRIX_FUNCTIONS[name]
    return function(formula, *_check_arguments(formula, arguments, axis_counts))


def _check_arguments(formula: ast.Call, arguments: list[np.ndarray], axis_counts: tuple[int, ...]) -> list[np.ndarray]:
    """Return the arguments of a function unchanged.

    Raises FormulaError if their numbers of axes are not `axis_counts`.
    """
    if [count_axes(argument) for argument in arguments] != list(axis_counts):
        expected = " and ".join(_SHAPE_WORDS[count] for count in axis_counts)
        actual = " and ".join(map(describe_shape, arguments)) or "nothing"
        raise FormulaError(f"{ast.unparse(formula)!r} needs {expected}, but has {actual}")
    return arguments


def _require_square(formula: ast.expr, matrix: np.ndarray) -> np.ndarray:
    if matrix.shape[0] != matrix.shape[1]:
        raise FormulaError(f"{ast.unparse(formula)!r} needs a square matrix, but this is {describe_shape(matrix)}")
    return matrix


def _invert(matrix: np.ndarray, formula: ast.expr) -> np.ndarray:
    _require_square(formula, matrix)
    cofactors = arithmetic.cofactor_signs(len(matrix))[..., None] * arithmetic.minors(matrix)
    with np.errstate(all="ignore"):
        return np.asarray(cofactors.swapaxes(0, 1) / arithmetic.determinant(matrix))


def _compute_cross_product(formula: ast.expr, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    if len(a) != 3 or len(b) != 3:
        raise _make_shape_error(formula, a, b)
    return arithmetic.cross(a, b)


def _compute_dot_product(formula: ast.expr, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    if len(a) != len(b):
        raise _make_shape_error(formula, a, b)
    return np.asarray((a * b).sum(axis=0))


def _compute_least_norm_vector(formula: ast.expr, matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Return M^T (M M^T)^-1 v, the shortest vector that the matrix M maps to the vector v."""
    if len(matrix) != len(vector) or len(matrix) > matrix.shape[1]:
        raise _make_shape_error(formula, matrix, vector)
    transposed = matrix.swapaxes(0, 1)
    return arithmetic.apply_matrix(
        transposed, arithmetic.apply_matrix(_invert(arithmetic.matrix_product(matrix, transposed), formula), vector)
    )


MATRIX_FUNCTIONS: dict[str, tuple[tuple[int, ...], Callable[..., np.ndarray]]] = {
    "det": ((2,), lambda formula, a: arithmetic.determinant(_require_square(formula, a))),
    "inv": ((2,), lambda formula, a: _invert(a, formula)),
    "transpose": ((2,), lambda formula, a: np.asarray(a.swapaxes(0, 1))),
    "cross": ((1, 1), _compute_cross_product),
    "dot": ((1, 1), _compute_dot_product),
    "least_norm": ((2, 1), _compute_least_norm_vector),
}
"""Maps each function of vectors and matrices to the numbers of axes of its arguments, and to a function that computes
it."""


def _compute_norm(formula: ast.Call, quantities: Quantities) -> np.ndarray:
    (vector,) = _check_arguments(formula, [compute(argument, quantities) for argument in formula.args], (1,))
    return quantities.apply("sqrt", np.asarray((vector * vector).sum(axis=0)))


def _differentiate(formula: ast.Call, quantities: Quantities) -> np.ndarray:
    """Return diff(f, symbol): the derivative of f with respect to a symbol."""
    match formula.args:
        case [operand, ast.Name(id=name)]:
            _require_symbol(name, quantities)
            return quantities.differentiate(operand, {name: quantities.make_constant(Fraction(1))})
    raise FormulaError(f"{ast.unparse(formula)!r}: write diff(f, theta1), with a formula and a symbol")


def _differentiate_by_time(formula: ast.Call, quantities: Quantities) -> np.ndarray:
    """Return ddt(f): the derivative of f with respect to time."""
    if len(formula.args) != 1:
        raise FormulaError(f"{ast.unparse(formula)!r}: ddt needs one formula, as in ddt(p)")
    return quantities.differentiate(formula.args[0], quantities.time_rates)


def _substitute(formula: ast.Call, quantities: Quantities) -> np.ndarray:
    """Return at(f, theta1 = 0, …): the value of f at given values of some symbols."""
    if len(formula.args) != 1 or not formula.keywords:
        raise FormulaError(f"{ast.unparse(formula)!r}: write at(f, theta1 = 0), with a formula and values of symbols")
    values = {}
    for keyword in formula.keywords:
        name = normalize_name(str(keyword.arg))
        _require_symbol(name, quantities)
        values[name] = compute(keyword.value, quantities)
        if count_axes(values[name]):
            raise FormulaError(f"{ast.unparse(formula)!r}: the value of {name} must be a number")
    return quantities.substitute_values(formula.args[0], values)


def _require_symbol(name: str, quantities: Quantities) -> None:
    value = quantities.look_up(name)
    if value is None:
        raise UnknownName("symbol", name, quantities.names)
    is_number = name == "pi" or name in quantities.numbers
    if count_axes(value) or is_number:
        meaning = "a number of this arm" if is_number else describe_shape(value)
        raise FormulaError(f"{name!r} is {meaning}, but a symbol is needed, such as a joint variable")


SPECIAL_FUNCTIONS: dict[str, Callable[[ast.Call, Quantities], np.ndarray]] = {
    "norm": _compute_norm, "diff": _differentiate, "ddt": _differentiate_by_time, "at": _substitute,
}  # fmt: skip
"""The functions that need the formulas of their arguments, or the quantities, and not only the arguments' values."""
