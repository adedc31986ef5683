"""Replace tiny numbers by zero if floating-point arithmetic gave them instead of zero, as in cos(pi/2) = 6.123e-17."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isnan, nan, prod

from qdot.exercises.formula.trees import ZERO, Node, fold

MAX_NOISE = 1e-12
"""A term with a smaller coefficient counts as a rounding error, even if other terms are small."""

BOUNDED_FUNCTIONS = ("sin", "cos")
"""Functions whose values are of the order of 1 for every argument."""


@dataclass(frozen=True)
class _Term:
    """A tree, the absolute value of its numeric coefficient (nan if unknown), and its value if it is a number."""

    tree: Node
    coefficient_size: float
    value: float | None = None

    @property
    def without_noise(self) -> Node:
        return ZERO if 0 < self.coefficient_size < MAX_NOISE else self.tree


def remove_noise(tree: Node) -> Node:
    """Return a tree in which terms are replaced by zero if their coefficient is only a rounding error.

    If there are no such terms, the tree itself is returned.

    >>> from fractions import Fraction
    >>> x, tiny = Node("name", value="x"), Node("number", value=Fraction(612323399573677, 10**31))
    >>> remove_noise(Node("+", (x, Node("*", (tiny, x))))) == Node("+", (x, ZERO))
    True
    """
    return fold(tree, _combine_terms).without_noise


def _combine_terms(node: Node, args: Sequence[_Term]) -> _Term:
    """Return the term of a node, given the terms of its arguments.

    Noise is removed from arguments that are not factors.
    """
    if node.kind in ("number", "decimal"):
        value = _compute_or_nan(lambda: float(node.value))
        return _Term(node, abs(value), value)
    is_multiplicative = node.kind in ("neg", "*", "/", "^")
    tree = node.with_args([arg.tree if is_multiplicative else arg.without_noise for arg in args])
    values = [arg.value for arg in args if arg.value is not None]
    if len(values) == len(args) and node.kind in _OPERATIONS:
        value = _compute_or_nan(lambda: _OPERATIONS[node.kind](values))
        return _Term(tree, abs(value), value)
    return _Term(tree, _estimate_coefficient(node, args) if args else 1.0)


def _estimate_coefficient(node: Node, args: Sequence[_Term]) -> float:
    """Return the size of the coefficient of a tree that contains names."""
    sizes = [arg.coefficient_size for arg in args]
    if node.kind in ("*", "/"):
        return _compute_or_nan(lambda: _OPERATIONS[node.kind](sizes))
    if node.kind == "^" and (exponent := args[1].value) is not None:
        return _compute_or_nan(lambda: float(sizes[0] ** exponent))
    if node.kind in ("+", "-", "neg"):
        return nan if any(map(isnan, sizes)) else max(sizes)
    return 1.0 if node.kind == "call" and node.value in BOUNDED_FUNCTIONS else nan


_OPERATIONS: dict[str, Callable[[list[float]], float]] = {
    "neg": lambda values: -values[0], "+": sum, "-": lambda values: values[0] - sum(values[1:]), "*": prod,
    "/": lambda values: values[0] / values[1], "^": lambda values: float(values[0] ** values[1]),
}  # fmt: skip


def _compute_or_nan(compute: Callable[[], float]) -> float:
    """Return the result of a computation, or nan if it is undefined or too large."""
    try:
        return compute()
    except (OverflowError, ZeroDivisionError, TypeError):
        return nan
