"""Evaluate trees of formulas at many points at once, with an estimate of the rounding error.

A program is a list of steps. Equal sub-expressions are one step, and equal terms of a sum are counted, so that a1 - a1
+ a1 - a1 ... is one step. Every value comes with its magnitude, the size of the terms that were added to obtain the
value. Rounding errors are of the order of 1e-16 times the magnitude, even if large terms cancel.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import mpmath
import numpy as np

from qdot.exercises.formula.trees import Node, find_names, make_scalar_expected_error, split_signed_terms

BRANCHING_FUNCTIONS = frozenset({"sqrt", "abs", "sign", "asin", "acos", "atan", "acot", "atan2", "log", "power"})
"""Functions with branches. Expressions with them may agree for some angles only, so they are compared at more
points."""

Step = tuple[str, tuple[int, ...], Any]
"""An operation, the indices of the steps that are its operands, and a constant.

The constant is the value of a number or name, an integer exponent, or how often each operand of a sum is added.
"""


@dataclass(frozen=True)
class Program:
    """The steps of a program, and the indices of the steps that compute the results."""

    steps: tuple[Step, ...]
    outputs: tuple[int, ...]

    @property
    def has_branches(self) -> bool:
        """Whether the program contains a function with branches."""
        return any(op in BRANCHING_FUNCTIONS for op, _, _ in self.steps)


def compile_program(nodes: Sequence[Node]) -> Program:
    """Return a program that computes several scalar trees. Raises ParseError for a list, set or equation in a tree."""
    steps: list[Step] = []
    step_indices: dict[Any, int] = {}

    def find_or_add(step: Step) -> int:
        """Return the index of a step; add the step unless there is an equal one."""
        op, _, value = step
        key = (op, value.numerator, value.denominator) if op == "number" else step  # hashing a fraction is slow
        index = step_indices.setdefault(key, len(steps))
        if index == len(steps):
            steps.append(step)
        return index

    outputs = []
    for node in nodes:
        indices: list[int] = []
        stack: list[tuple[Node, tuple[Node, ...], tuple[int, ...], bool]] = [(node, *_split_operands(node), False)]
        while stack:  # no recursion: a long sum is a deep tree
            current_node, args, signs, is_ready = stack.pop()
            if not args:  # a leaf, as most nodes are
                indices.append(find_or_add(_make_step(current_node, ())))
            elif is_ready:
                operands = tuple(indices[len(indices) - len(args) :])
                del indices[len(indices) - len(args) :]
                step = _make_sum_step(operands, signs) if signs else _make_step(current_node, operands)
                indices.append(find_or_add(step))
            else:
                stack.append((current_node, args, signs, True))
                stack.extend((arg, *_split_operands(arg), False) for arg in reversed(args))
        outputs.append(indices[0])
    return Program(tuple(steps), tuple(outputs))


def _split_operands(node: Node) -> tuple[tuple[Node, ...], tuple[int, ...]]:
    """Return the terms of a nested sum and their signs; for any other node, return its operands and ()."""
    if node.kind not in ("+", "-"):
        return node.args, ()
    terms, signs = zip(*split_signed_terms(node), strict=True)
    return terms, signs


def _make_sum_step(operands: tuple[int, ...], signs: tuple[int, ...]) -> Step:
    """Return the step for a sum, in which each operand occurs once, with the sum of its signs."""
    counts: dict[int, int] = {}
    for operand, sign in zip(operands, signs, strict=True):
        counts[operand] = counts.get(operand, 0) + sign
    return ("sum", tuple(counts), tuple(counts.values()))


def _make_step(node: Node, operands: tuple[int, ...]) -> Step:
    """Return the step for a node that is not a sum."""
    if node.kind in ("number", "decimal"):
        return ("number", (), node.value)
    if node.kind == "name":
        return ("name", (), node.value)
    if node.kind == "call":
        return (str(node.value), operands, None)
    if node.kind == "^":
        exponent = node.args[1]
        sign = -1 if exponent.kind == "neg" else 1
        exponent = exponent.args[0] if exponent.kind == "neg" else exponent
        if exponent.kind == "number" and exponent.value.denominator == 1 and exponent.value <= 1000:
            return ("integer power", operands[:1], sign * int(exponent.value))
        return ("power", operands, None)
    if node.kind in ("neg", "*", "/"):
        return (node.kind, operands, None)
    raise make_scalar_expected_error(node)


_CONSTANTS = {"pi": np.pi, "E": np.e, "I": 1j}

_NUMPY_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "exp": np.exp, "log": np.log, "sqrt": np.sqrt,
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh,
    "abs": np.abs, "cot": lambda x: 1 / np.tan(x), "sec": lambda x: 1 / np.cos(x), "csc": lambda x: 1 / np.sin(x),
    "acot": lambda x: np.arctan(1 / x), "sign": lambda x: np.where(x == 0, 0, x / np.abs(x)),
    "neg": np.negative, "*": np.multiply, "/": np.divide, "power": np.power,
    "atan2": lambda y, x: np.where((x.imag == 0) & (y.imag == 0), np.arctan2(y.real, x.real), np.nan),
}  # fmt: skip

_DERIVATIVE_SIZES: dict[str, Callable[..., Any]] = {
    "sin": np.cos, "cos": np.sin, "tan": lambda x: 1 / np.cos(x) ** 2, "exp": np.exp, "log": lambda x: 1 / x,
    "sqrt": lambda x: 0.5 / np.sqrt(x), "asin": lambda x: 1 / np.sqrt(1 - x * x),
    "acos": lambda x: 1 / np.sqrt(1 - x * x), "atan": lambda x: 1 / (1 + x * x), "sinh": np.cosh, "cosh": np.sinh,
    "tanh": lambda x: 1 / np.cosh(x) ** 2, "abs": np.ones_like, "cot": lambda x: 1 / np.sin(x) ** 2,
    "sec": lambda x: np.sin(x) / np.cos(x) ** 2, "csc": lambda x: np.cos(x) / np.sin(x) ** 2,
    "acot": lambda x: 1 / (1 + x * x), "sign": np.zeros_like,
}  # fmt: skip
"""Maps each function to its derivative, up to the sign, which is the factor by which an error of the argument grows."""

StepResult = tuple[np.ndarray, np.ndarray]
"""The values (points,) of a step, complex, and their magnitudes (points,)."""


class Evaluation(NamedTuple):
    """The values (complex) of a program's results and their magnitudes, each of shape (outputs, points)."""

    values: np.ndarray
    magnitudes: np.ndarray


def evaluate(program: Program, values: Mapping[str, np.ndarray], point_count: int) -> Evaluation:
    """Return the values and magnitudes of a program's results, in double precision.

    `values` maps every name to its values at the points; a missing name raises KeyError. Undefined values are nan.
    """
    return select_outputs(program, evaluate_steps(program, values, point_count))


def evaluate_trees(nodes: Sequence[Node], values: Mapping[str, np.ndarray], point_count: int) -> np.ndarray:
    """Return the values (trees, points) of trees that share subtrees, without magnitudes.

    Subtrees that are the same object are evaluated once. This is faster than a program if many trees differ in a single
    node.
    """
    values_by_id: dict[int, np.ndarray] = {}

    def evaluate_node(node: Node) -> np.ndarray:
        value = values_by_id.get(id(node))
        if value is None:
            args = [evaluate_node(arg) for arg in node.args]
            if node.kind in ("+", "-"):
                step = _make_sum_step((0, 1), (1, 1 if node.kind == "+" else -1))
            else:
                step = _make_step(node, ())
            value = values_by_id[id(node)] = _evaluate_step(step, args, values, point_count)
        return value

    with np.errstate(all="ignore"):
        return np.array([evaluate_node(node) for node in nodes])


def evaluate_steps(program: Program, values: Mapping[str, np.ndarray], point_count: int) -> list[StepResult]:
    """Return the values and magnitudes of every step of a program; see `evaluate`."""
    results: list[StepResult] = []
    with np.errstate(all="ignore"):
        for step in program.steps:
            _, operands, _ = step
            args = [results[i] for i in operands]
            value = _evaluate_step(step, [arg for arg, _ in args], values, point_count)
            results.append((value, _compute_magnitude(step, value, args)))
    return results


def select_outputs(program: Program, step_results: list[StepResult]) -> Evaluation:
    """Return the values and magnitudes of a program's results from those of all its steps."""
    values, magnitudes = zip(*(step_results[i] for i in program.outputs), strict=True)
    return Evaluation(np.array(values), np.array(magnitudes))


def assign_regions(evaluated_programs: Sequence[tuple[Program, list[StepResult]]], point_count: int) -> np.ndarray:
    """Return the number of each point's region, (points,).

    At all points of a region, the operands of functions with branches have the same signs.
    """
    region_numbers = np.zeros(point_count, dtype=np.int64)
    for program, step_results in evaluated_programs:
        branching_operands = [operands for op, operands, _ in program.steps if op in BRANCHING_FUNCTIONS]
        for value, _ in (step_results[i] for operands in branching_operands for i in operands):
            with np.errstate(invalid="ignore"):
                imaginary_signs = np.where(np.abs(value.imag) > 1e-9 * np.abs(value), np.sign(value.imag), 0)
                # from 0 to 8, for three signs of the real part times three of the imaginary part
                sign_numbers = 3 * np.nan_to_num(np.sign(value.real)) + np.nan_to_num(imaginary_signs) + 4
            _, region_numbers = np.unique(9 * region_numbers + sign_numbers.astype(np.int64), return_inverse=True)
    return region_numbers


def _evaluate_step(step: Step, args: Sequence[Any], values: Mapping[str, np.ndarray], point_count: int) -> np.ndarray:
    """Return the values (points,) of a step, given the values of its operands."""
    op, _, constant = step
    if op in ("number", "name"):
        number = _to_float(constant) if op == "number" else _CONSTANTS.get(constant)
        return np.asarray(values[constant], complex) if number is None else np.full(point_count, number, complex)
    if op == "sum":
        terms = (count * arg for count, arg in zip(constant, args, strict=True))
        return sum(terms, np.zeros(point_count, dtype=complex))
    if op == "integer power":
        return np.asarray(args[0] ** constant if constant > 0 else 1 / args[0] ** -constant)
    # adding 0.0 turns -1 - 0j, whose root would be -i, into -1 + 0j
    operands = [arg + 0.0 for arg in args] if op in BRANCHING_FUNCTIONS else args
    return np.asarray(_NUMPY_FUNCTIONS[op](*operands), dtype=complex)


def _compute_magnitude(step: Step, value: np.ndarray, args: Sequence[StepResult]) -> np.ndarray:
    """Return the magnitude of a step's value, given the values x, y and magnitudes mx, my of its operands."""
    op, _, constant = step
    if not args:
        return np.abs(value)
    if op == "sum":
        return np.asarray(sum(abs(count) * mx for count, (_, mx) in zip(constant, args, strict=True)))
    x, mx = args[0]
    if op == "neg":
        return mx
    if op == "integer power":
        if constant > 0:  # this form is also defined at x = 0
            return np.asarray(np.abs(x) ** (constant - 1) * (np.abs(x) + constant * mx))
        return np.asarray(np.abs(value) * (1 + abs(constant) * _compute_relative_magnitude(mx, x)))
    if len(args) == 1:
        return np.asarray(np.abs(value) + np.abs(_DERIVATIVE_SIZES[op](x)) * mx)
    y, my = args[1]
    if op == "*":
        return mx * my
    if op == "/":
        return np.asarray(mx * my / np.abs(y) ** 2)
    if op == "power":
        return np.asarray(np.abs(value) * (1 + np.abs(y) * _compute_relative_magnitude(mx, x) + np.abs(np.log(x)) * my))
    assert op == "atan2"
    return np.asarray(1 + (mx * np.abs(y) + my * np.abs(x)) / (np.abs(x) ** 2 + np.abs(y) ** 2))


def _compute_relative_magnitude(magnitude: np.ndarray, value: np.ndarray) -> np.ndarray:
    return np.where(magnitude == 0, 1.0, magnitude / np.abs(value))


def _to_float(number: Any) -> float:
    """Return a number as a float, inf if it is too large."""
    try:
        return float(number)
    except OverflowError:
        return float("inf")


_LARGEST_EXPONENT = 1e5
"""Largest exponent in a precise evaluation, because a number such as 9**9**9**9 would use up all memory."""

_LARGEST_ANGLE = 1e60
"""Largest angle; more digits than are computed would be needed to reduce a larger angle to one revolution."""


def _limit_argument(function: Callable[[Any], Any], limit: float) -> Callable[[Any], Any]:
    """Return a function that is undefined (nan) for large arguments."""
    return lambda x: function(x) if abs(x) < limit and abs(mpmath.im(x)) < _LARGEST_EXPONENT else mpmath.nan


def _compute_limited_power(x: Any, y: Any) -> Any:
    """Return x^y, nan if it is undefined or too large."""
    if not (mpmath.isfinite(x) and mpmath.isfinite(y)):
        return mpmath.nan
    is_representable = x == 0 or abs(y) * (1 + abs(mpmath.log(abs(x)))) < _LARGEST_EXPONENT
    return x**y if is_representable else mpmath.nan


_TRIGONOMETRIC_FUNCTIONS = ("sin", "cos", "tan", "cot", "sec", "csc")
_MPMATH_FUNCTIONS: dict[str, Callable[..., Any]] = {
    **{name: _limit_argument(getattr(mpmath, name), _LARGEST_ANGLE) for name in _TRIGONOMETRIC_FUNCTIONS},
    **{name: _limit_argument(getattr(mpmath, name), _LARGEST_EXPONENT) for name in ("exp", "sinh", "cosh", "tanh")},
    **{name: getattr(mpmath, name) for name in ("log", "sqrt", "asin", "acos", "atan", "sign")},
    "abs": abs, "acot": lambda x: mpmath.atan(1 / x), "atan2": lambda y, x: mpmath.atan2(mpmath.re(y), mpmath.re(x)),
    "*": lambda x, y: x * y, "/": lambda x, y: x / y, "neg": lambda x: -x, "power": _compute_limited_power,
}  # fmt: skip


def _to_mpmath(value: Any) -> Any:
    return mpmath.mpf(value.numerator) / value.denominator if isinstance(value, Fraction) else mpmath.mpf(value)


def evaluate_precisely(program: Program, values: Mapping[str, Any], digits: int) -> list[Any]:
    """Return the results at one point with `digits` decimal digits, as mpmath numbers; nan where undefined.

    Values are floats, mpmath numbers or fractions.
    """
    constants = {"pi": mpmath.pi, "E": mpmath.e, "I": mpmath.mpc(0, 1)}
    with mpmath.workdps(digits):
        results: list[Any] = []
        for op, operands, constant in program.steps:
            args = [results[i] for i in operands]
            try:
                if op == "number":
                    results.append(_to_mpmath(constant))
                elif op == "name":
                    results.append(+constants[constant] if constant in constants else _to_mpmath(values[constant]))
                elif op == "integer power":
                    results.append(_compute_limited_power(args[0], constant))
                elif op == "sum":
                    results.append(sum((count * arg for arg, count in zip(args, constant, strict=True)), mpmath.mpf(0)))
                else:
                    results.append(_MPMATH_FUNCTIONS[op](*args))
            except (ZeroDivisionError, ValueError, OverflowError):
                results.append(mpmath.nan)
        return [results[i] for i in program.outputs]


PRECISE_DIGITS = 50
"""The number of digits of a precise evaluation."""
PRECISE_TOLERANCE = 1e-40
"""Values with PRECISE_DIGITS digits count as equal if their difference, relative to the size of the terms, is
smaller."""


def evaluate_constant(node: Node) -> Any:
    """Return the real value of a tree as an mpmath number; None if it has symbols or no real value."""
    if find_names(node):
        return None
    (value,) = evaluate_precisely(compile_program([node]), {}, PRECISE_DIGITS)
    return mpmath.re(value) if mpmath.isfinite(value) and abs(mpmath.im(value)) < PRECISE_TOLERANCE else None
