"""What is left of zero where a formula was worked out with floating-point numbers: cos(pi/2) = 6.123e-17."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import isnan, nan, prod
from operator import is_

from qdot.exercises.formula.trees import Node

NOISE = 1e-12
"""A term with a smaller coefficient is rounding, however many digits of it are written, and whatever is beside it."""

ZERO = Node("number", value=Fraction(0))
BOUNDED = ("sin", "cos")
"""Functions whose values are of the order of 1, whatever is in them."""


@dataclass(frozen=True)
class _Term:
    """A tree, the size of its coefficient (nan where it is not known), and its value where it is a number."""

    tree: Node
    size: float
    value: float | None = None

    @property
    def kept(self) -> Node:
        return ZERO if 0 < self.size < NOISE else self.tree


def without_noise(node: Node) -> Node:
    """Return a tree without terms whose coefficient is only rounding; one that is nothing else is zero.

    It is the same object where there are none.

    >>> x, tiny = Node("name", value="x"), Node("number", value=Fraction(612323399573677, 10**31))
    >>> without_noise(Node("+", (x, Node("*", (tiny, x))))) == Node("+", (x, ZERO))
    True
    """
    done: list[_Term] = []
    stack = [(node, False)]
    while stack:  # no recursion: a long sum is a deep tree
        top, ready = stack.pop()
        if not top.args:
            done.append(_leaf(top))
        elif ready:
            args = done[len(done) - len(top.args) :]
            done[len(done) - len(top.args) :] = [_put_together(top, args)]
        else:
            stack.append((top, True))
            stack.extend((arg, False) for arg in reversed(top.args))
    return done[0].kept


def _leaf(node: Node) -> _Term:
    if node.kind not in ("number", "decimal"):
        return _Term(node, 1.0)
    value = _number(lambda: float(node.value))
    return _Term(node, abs(value), value)


def _put_together(node: Node, args: Sequence[_Term]) -> _Term:
    """Return a node with what is left of its arguments."""
    factors = node.kind in ("neg", "*", "/", "^")
    trees = tuple(arg.tree if factors else arg.kept for arg in args)
    tree = node if all(map(is_, trees, node.args)) else Node(node.kind, trees, node.value)
    values = [arg.value for arg in args if arg.value is not None]
    if len(values) == len(args) and node.kind in _WORKED_OUT:
        value = _number(lambda: _WORKED_OUT[node.kind](values))
        return _Term(tree, abs(value), value)
    return _Term(tree, _size(node, args))


def _size(node: Node, args: Sequence[_Term]) -> float:
    """Return the size of the coefficient of what has names in it."""
    sizes = [arg.size for arg in args]
    if node.kind == "*":
        return _number(lambda: prod(sizes))
    if node.kind == "/":
        return _number(lambda: sizes[0] / sizes[1])
    if node.kind == "^" and (exponent := args[1].value) is not None:
        return _number(lambda: float(sizes[0] ** exponent))
    if node.kind in ("+", "-", "neg"):
        return nan if any(map(isnan, sizes)) else max(sizes)
    return 1.0 if node.kind == "call" and node.value in BOUNDED else nan


_WORKED_OUT: dict[str, Callable[[list[float]], float]] = {
    "neg": lambda values: -values[0], "+": sum, "-": lambda values: values[0] - sum(values[1:]), "*": prod,
    "/": lambda values: values[0] / values[1], "^": lambda values: float(values[0] ** values[1]),
}  # fmt: skip


def _number(value: Callable[[], float]) -> float:
    """Return a number, not one where it has none or is too large."""
    try:
        return value()
    except (OverflowError, ZeroDivisionError, TypeError):
        return nan
