"""Evaluate expression trees at many points at once, with a bound on what rounding can have done.

A program is a list of steps in which equal sub-expressions occur once, and equal terms of a sum are counted, so that
a1 - a1 + a1 - a1 ... is one step. Every value comes with its *magnitude*, the size of the terms that were added to
make it: rounding errors are of the order of 1e-16 times the magnitude, so that a difference can be judged against
what cancels and not against what is left.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np

from qdot.exercises.formula.trees import Node, names, no_scalar

BRANCHING = frozenset({"sqrt", "abs", "sign", "asin", "acos", "atan", "acot", "atan2", "log", "power"})
"""Functions that may agree with another on a part of the circle only; expressions with them need more points."""

Step = tuple[str, tuple[int, ...], Any]


@dataclass(frozen=True)
class Program:
    """Steps (operation, indices of its operands, value) and the indices of the results."""

    steps: tuple[Step, ...]
    outputs: tuple[int, ...]

    @property
    def branches(self) -> bool:
        """Whether a function with branches occurs."""
        return any(op in BRANCHING for op, _, _ in self.steps)


def compile_program(nodes: Sequence[Node]) -> Program:
    """Return one program for several scalar trees. Raises ReadError if a tree contains a list, set or equation."""
    steps: list[Step] = []
    known: dict[Any, int] = {}

    def add(step: Step) -> int:
        op, _, value = step
        key = (op, value.numerator, value.denominator) if op == "number" else step  # a fraction is slow to be hashed
        at = known.get(key)
        if at is None:
            at = known[key] = len(steps)
            steps.append(step)
        return at

    outputs = []
    for node in nodes:
        done: list[int] = []
        stack: list[tuple[Node, tuple[Node, ...], tuple[int, ...], bool]] = [(node, *_parts(node), False)]
        while stack:  # no recursion: a long sum is a deep tree
            top, args, signs, ready = stack.pop()
            if not args:  # a leaf, and most nodes are
                done.append(add(_step(top, ())))
            elif ready:
                taken = tuple(done[len(done) - len(args) :])
                del done[len(done) - len(args) :]
                done.append(add(_total(taken, signs) if signs else _step(top, taken)))
            else:
                stack.append((top, args, signs, True))
                stack.extend((arg, *_parts(arg), False) for arg in reversed(args))
        outputs.append(done[0])
    return Program(tuple(steps), tuple(outputs))


def _parts(node: Node) -> tuple[tuple[Node, ...], tuple[int, ...]]:
    """Return the terms of a whole sum and their signs, or the operands of anything else and no signs."""
    if node.kind not in ("+", "-"):
        return node.args, ()
    terms, signs, stack = [], [], [(node, 1)]
    while stack:
        top, sign = stack.pop()
        if top.kind == "neg":
            stack.append((top.args[0], -sign))
        elif top.kind in ("+", "-"):
            stack += [(top.args[1], sign if top.kind == "+" else -sign), (top.args[0], sign)]
        else:
            terms.append(top)
            signs.append(sign)
    return tuple(terms), tuple(signs)


def _total(operands: tuple[int, ...], signs: tuple[int, ...]) -> Step:
    counts: dict[int, int] = {}
    for operand, sign in zip(operands, signs, strict=True):
        counts[operand] = counts.get(operand, 0) + sign
    return ("sum", tuple(counts), tuple(counts.values()))


def _step(node: Node, operands: tuple[int, ...]) -> Step:
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
    raise no_scalar(node)


_CONSTANTS = {"pi": np.pi, "E": np.e, "I": 1j}

_NUMPY: dict[str, Callable[..., Any]] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "exp": np.exp, "log": np.log, "sqrt": np.sqrt,
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh,
    "abs": np.abs, "cot": lambda x: 1 / np.tan(x), "sec": lambda x: 1 / np.cos(x), "csc": lambda x: 1 / np.sin(x),
    "acot": lambda x: np.arctan(1 / x), "sign": lambda x: np.where(x == 0, 0, x / np.abs(x)),
    "neg": np.negative, "*": np.multiply, "/": np.divide, "power": np.power,
    "atan2": lambda y, x: np.where((x.imag == 0) & (y.imag == 0), np.arctan2(y.real, x.real), np.nan),
}  # fmt: skip

_SLOPES: dict[str, Callable[..., Any]] = {
    "sin": np.cos, "cos": np.sin, "tan": lambda x: 1 / np.cos(x) ** 2, "exp": np.exp, "log": lambda x: 1 / x,
    "sqrt": lambda x: 0.5 / np.sqrt(x), "asin": lambda x: 1 / np.sqrt(1 - x * x),
    "acos": lambda x: 1 / np.sqrt(1 - x * x), "atan": lambda x: 1 / (1 + x * x), "sinh": np.cosh, "cosh": np.sinh,
    "tanh": lambda x: 1 / np.cosh(x) ** 2, "abs": np.ones_like, "cot": lambda x: 1 / np.sin(x) ** 2,
    "sec": lambda x: np.sin(x) / np.cos(x) ** 2, "csc": lambda x: np.cos(x) / np.sin(x) ** 2,
    "acot": lambda x: 1 / (1 + x * x), "sign": np.zeros_like,
}  # fmt: skip


ValueAndSize = tuple[np.ndarray, np.ndarray]


def evaluate(program: Program, values: Mapping[str, np.ndarray], points: int) -> tuple[np.ndarray, np.ndarray]:
    """Return values (complex) and magnitudes, each of shape (outputs, points), in double precision.

    `values` gives every name at every point; a missing one is a KeyError. What overflows or is undefined is nan.
    """
    return select_outputs(program, evaluate_steps(program, values, points))


def evaluate_each(nodes: Sequence[Node], values: Mapping[str, np.ndarray], points: int) -> np.ndarray:
    """Return the values of trees that share branches (the same objects), (trees, points), without magnitudes.

    It is faster than a program if each of many trees is the same one with a single change.
    """
    known: dict[int, np.ndarray] = {}

    def value_of(node: Node) -> np.ndarray:
        value = known.get(id(node))
        if value is None:
            step = _total((0, 1), (1, 1 if node.kind == "+" else -1)) if node.kind in ("+", "-") else _step(node, ())
            value = known[id(node)] = _value(step, [value_of(arg) for arg in node.args], values, points)
        return value

    with np.errstate(all="ignore"):
        return np.array([value_of(node) for node in nodes])


def evaluate_steps(program: Program, values: Mapping[str, np.ndarray], points: int) -> list[ValueAndSize]:
    """Return value and magnitude of every step of a program, as `evaluate` does of the results."""
    results: list[ValueAndSize] = []
    with np.errstate(all="ignore"):
        for step in program.steps:
            args = [results[i] for i in step[1]]
            value = _value(step, [arg for arg, _ in args], values, points)
            results.append((value, _magnitude(step, value, args)))
    return results


def select_outputs(program: Program, steps: list[ValueAndSize]) -> tuple[np.ndarray, np.ndarray]:
    """Return values and magnitudes of the results among the steps."""
    return np.array([steps[i][0] for i in program.outputs]), np.array([steps[i][1] for i in program.outputs])


def number_regions(evaluated: Sequence[tuple[Program, list[ValueAndSize]]], points: int) -> np.ndarray:
    """Return a number for each point, equal where the operands of all branching functions have equal signs."""
    number = np.zeros(points, dtype=np.int64)
    for program, steps in evaluated:
        branching = (operands for op, operands, _ in program.steps if op in BRANCHING)
        for value in (steps[i][0] for operands in branching for i in operands):
            with np.errstate(invalid="ignore"):
                across = np.where(np.abs(value.imag) > 1e-9 * np.abs(value), np.sign(value.imag), 0)
                signs = 3 * np.nan_to_num(np.sign(value.real)) + np.nan_to_num(across) + 4
            number = np.unique(9 * number + signs.astype(np.int64), return_inverse=True)[1]
    return number


def _value(step: Step, args: Sequence[Any], values: Mapping[str, np.ndarray], points: int) -> np.ndarray:
    """Return the value of a step from those of its operands."""
    op, _, constant = step
    if op in ("number", "name"):
        number = _as_float(constant) if op == "number" else _CONSTANTS.get(constant)
        return np.asarray(values[constant], complex) if number is None else np.full(points, number, complex)
    if op == "sum":
        terms = (count * arg for count, arg in zip(constant, args, strict=True))
        return sum(terms, np.zeros(points, dtype=complex))
    if op in BRANCHING:  # -1 as -1 - 0j lies below the cut, and its root would be -i
        args = [arg + 0.0 for arg in args]
    if op == "integer power":
        return np.asarray(args[0] ** constant if constant > 0 else 1 / args[0] ** -constant)
    return np.asarray(_NUMPY[op](*args), dtype=complex)


def _magnitude(step: Step, value: np.ndarray, args: Sequence[ValueAndSize]) -> np.ndarray:
    """Return the size of the terms that were added to make the value of a step."""
    op, _, constant = step
    if not args:
        return np.abs(value)
    if op == "sum":
        return np.asarray(sum(abs(count) * size for count, (_, size) in zip(constant, args, strict=True)))
    x, mx = args[0]
    if op == "neg":
        return mx
    if op == "integer power":
        if constant > 0:  # defined at x = 0, where the ratio below is not
            return np.asarray(np.abs(x) ** (constant - 1) * (np.abs(x) + constant * mx))
        return np.asarray(np.abs(value) * (1 + abs(constant) * _ratio(mx, x)))
    if len(args) == 1:
        return np.asarray(np.abs(value) + np.abs(_SLOPES[op](x)) * mx)
    y, my = args[1]
    if op == "*":
        return mx * my
    if op == "/":
        return np.asarray(mx * my / np.abs(y) ** 2)
    if op == "power":
        return np.asarray(np.abs(value) * (1 + np.abs(y) * _ratio(mx, x) + np.abs(np.log(x)) * my))
    assert op == "atan2"
    return np.asarray(1 + (mx * np.abs(y) + my * np.abs(x)) / (np.abs(x) ** 2 + np.abs(y) ** 2))


def _ratio(magnitude: np.ndarray, value: np.ndarray) -> np.ndarray:
    return np.where(magnitude == 0, 1.0, magnitude / np.abs(value))


def _as_float(number: Any) -> float:
    try:
        return float(number)
    except OverflowError:
        return float("inf")


_LARGEST_EXPONENT = 1e5
"""Beyond exp(1e5) a precise number costs memory without end (9**9**9**9); no answer of this field is that large."""

_LARGEST_ANGLE = 1e60
"""Beyond that, reducing an angle to one turn takes more digits than are carried."""


def _limit_argument(function: Callable[[Any], Any], largest: float) -> Callable[[Any], Any]:
    return lambda x: function(x) if abs(x) < largest else mpmath.nan


def _trigonometric(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    inside = _limit_argument(function, _LARGEST_ANGLE)
    return lambda x: inside(x) if abs(mpmath.im(x)) < _LARGEST_EXPONENT else mpmath.nan


def _power(x: Any, y: Any) -> Any:
    if x == 0 or not mpmath.isfinite(x) or not mpmath.isfinite(y):
        return x**y if mpmath.isfinite(x) and mpmath.isfinite(y) else mpmath.nan
    return x**y if abs(y) * (1 + abs(mpmath.log(abs(x)))) < _LARGEST_EXPONENT else mpmath.nan


_MP: dict[str, Callable[..., Any]] = {
    **{name: _trigonometric(getattr(mpmath, name)) for name in ("sin", "cos", "tan", "cot", "sec", "csc")},
    **{name: _limit_argument(getattr(mpmath, name), _LARGEST_EXPONENT) for name in ("exp", "sinh", "cosh", "tanh")},
    **{name: getattr(mpmath, name) for name in ("log", "sqrt", "asin", "acos", "atan", "sign")},
    "abs": abs, "acot": lambda x: mpmath.atan(1 / x), "atan2": lambda y, x: mpmath.atan2(mpmath.re(y), mpmath.re(x)),
    "*": lambda x, y: x * y, "/": lambda x, y: x / y, "neg": lambda x: -x, "power": _power,
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
                    results.append(_power(args[0], constant))
                elif op == "sum":
                    results.append(sum((count * arg for arg, count in zip(args, constant, strict=True)), mpmath.mpf(0)))
                else:
                    results.append(_MP[op](*args))
            except (ZeroDivisionError, ValueError, OverflowError):
                results.append(mpmath.nan)
        return [results[i] for i in program.outputs]


DIGITS = 50
SAME = 1e-40
"""With that many digits, values are the same if they differ by less, relative to the size of the terms."""


def value_of(node: Node) -> Any:
    """Return the real value of a tree as an mpmath number; None if it has symbols or no real value."""
    if names(node):
        return None
    value = evaluate_precisely(compile_program([node]), {}, DIGITS)[0]
    return mpmath.re(value) if mpmath.isfinite(value) and abs(mpmath.im(value)) < SAME else None
