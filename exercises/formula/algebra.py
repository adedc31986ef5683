"""Form sums, products and derivatives of parsed formulas without SymPy."""

from collections.abc import Callable, Sequence
from fractions import Fraction

from qdot.exercises.formula.trees import Node

Matrix = Sequence[Sequence[Node]]


def number(value: int | Fraction) -> Node:
    """Return a node for a number."""
    return Node("number", value=Fraction(value))


ZERO, ONE, TWO = number(0), number(1), number(2)


def plus(a: Node, b: Node) -> Node:
    """Return a + b, simplified if one of them is 0.

    >>> plus(ZERO, ONE) == ONE
    True
    """
    return b if a == ZERO else a if b == ZERO else Node("+", (a, b))


def negative(a: Node) -> Node:
    """Return -a, simplified if a is 0 or is itself negated."""
    return a if a == ZERO else a.args[0] if a.kind == "neg" else Node("neg", (a,))


def minus(a: Node, b: Node) -> Node:
    """Return a - b, simplified if one of them is 0."""
    return a if b == ZERO else negative(b) if a == ZERO else Node("-", (a, b))


def times(a: Node, b: Node) -> Node:
    """Return the product a b, simplified if a factor is 0 or 1."""
    if ZERO in (a, b):
        return ZERO
    return b if a == ONE else a if b == ONE else Node("*", (a, b))


def over(a: Node, b: Node) -> Node:
    """Return a / b, simplified if a is 0 or b is 1."""
    return ZERO if a == ZERO else a if b == ONE else Node("/", (a, b))


def power(a: Node, b: Node) -> Node:
    """Return a ^ b, simplified if b is 0 or 1."""
    return ONE if b == ZERO else a if b == ONE else Node("^", (a, b))


def call(function: str, a: Node) -> Node:
    """Return the node for a function applied to a, as in sin(a)."""
    return Node("call", (a,), function)


def addends(total: Node) -> list[Node]:
    """Return the terms of a sum without expanding products."""
    if total.kind == "+":
        return addends(total.args[0]) + addends(total.args[1])
    if total.kind == "-":
        return addends(total.args[0]) + [negative(term) for term in addends(total.args[1])]
    if total.kind == "neg":
        return [negative(term) for term in addends(total.args[0])]
    return [total]


def terms_of(node: Node, most: int) -> list[Node] | None:
    """Return the terms after expanding sums and products, or None if there are more than `most`."""
    if node.kind not in ("+", "-", "*", "neg"):
        return [node]
    arg_terms = [terms_of(arg, most) for arg in node.args]
    known_terms = [terms for terms in arg_terms if terms is not None]
    if len(known_terms) < len(arg_terms):
        return None
    if node.kind == "*":
        terms = [times(first, second) for first in known_terms[0] for second in known_terms[1]]
    elif node.kind == "neg":
        terms = [negative(term) for term in known_terms[0]]
    else:
        terms = known_terms[0] + (known_terms[1] if node.kind == "+" else [negative(term) for term in known_terms[1]])
    return terms if len(terms) <= most else None


def factors(node: Node) -> list[Node]:
    """Return the factors of a product; sums are not factored.

    A denominator b becomes the factor 1/b. A power becomes its base, repeated.

    >>> x, y = Node("name", value="x"), Node("name", value="y")
    >>> factors(negative(times(power(x, TWO), y))) == [x, x, y, number(-1)]
    True
    """
    if node.kind == "*":
        return [factor for arg in node.args for factor in factors(arg)]
    if node.kind == "neg":
        return [*factors(node.args[0]), number(-1)]
    if node.kind == "/":
        return [*factors(node.args[0]), *(over(ONE, factor) for factor in factors(node.args[1]))]
    if node.kind == "^" and node.args[1].kind == "number" and node.args[1].value in range(1, MOST_POWER + 1):
        return factors(node.args[0]) * int(node.args[1].value)
    return [node]


MOST_POWER = 6
"""The highest exponent of a power that is split into repeated factors."""

# --- derivatives ---

_SLOPES: dict[str, Callable[[Node], Node]] = {
    "sin": lambda x: call("cos", x),
    "cos": lambda x: negative(call("sin", x)),
    "tan": lambda x: over(ONE, power(call("cos", x), TWO)),
    "cot": lambda x: negative(over(ONE, power(call("sin", x), TWO))),
    "sec": lambda x: over(call("sin", x), power(call("cos", x), TWO)),
    "csc": lambda x: negative(over(call("cos", x), power(call("sin", x), TWO))),
    "exp": lambda x: call("exp", x),
    "log": lambda x: over(ONE, x),
    "sqrt": lambda x: over(ONE, times(TWO, call("sqrt", x))),
    "asin": lambda x: over(ONE, call("sqrt", minus(ONE, power(x, TWO)))),
    "acos": lambda x: negative(over(ONE, call("sqrt", minus(ONE, power(x, TWO))))),
    "atan": lambda x: over(ONE, plus(ONE, power(x, TWO))),
    "sinh": lambda x: call("cosh", x),
    "cosh": lambda x: call("sinh", x),
    "tanh": lambda x: over(ONE, power(call("cosh", x), TWO)),
}


def derivative(node: Node, name: str) -> Node | None:
    """Return the derivative with respect to a name, or None for abs, sign, atan2 and sets.

    >>> from qdot.exercises.formula.parser import read
    >>> from qdot.exercises.formula.trees import node_text
    >>> node_text(derivative(read("a1*cos(theta1) + 2*theta1^2"), "theta1"))
    '((a1*(-sin(theta1)))+(2*(2*theta1)))'
    """
    if node.kind in ("number", "decimal"):
        return ZERO
    if node.kind == "name":
        return ONE if node.value == name else ZERO
    arg_derivatives = [derivative(arg, name) for arg in node.args]
    known_derivatives = [term for term in arg_derivatives if term is not None]
    if len(known_derivatives) < len(arg_derivatives):
        return None
    if all(term == ZERO for term in known_derivatives):
        return ZERO
    return _differentiate_node(node, known_derivatives)


def _differentiate_node(node: Node, slopes: Sequence[Node]) -> Node | None:
    if node.kind == "neg":
        return negative(slopes[0])
    if node.kind == "call":
        return times(_SLOPES[node.value](node.args[0]), slopes[0]) if node.value in _SLOPES else None
    if len(slopes) != 2:
        return None
    (a, b), (da, db) = node.args, slopes
    if node.kind in ("+", "-"):
        return plus(da, db) if node.kind == "+" else minus(da, db)
    if node.kind == "*":
        return plus(times(da, b), times(a, db))
    if node.kind == "/":
        return over(minus(times(da, b), times(a, db)), power(b, TWO)) if db != ZERO else over(da, b)
    if node.kind == "^" and db == ZERO:
        reduced_exponent = number(b.value - 1) if b.kind == "number" else minus(b, ONE)
        return times(times(b, power(a, reduced_exponent)), da)
    if node.kind == "^":  # a^b = exp(b log a)
        return times(node, plus(times(db, call("log", a)), over(times(b, da), a)))
    return None
