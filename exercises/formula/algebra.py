"""Form sums, products and derivatives of parsed formulas without SymPy."""

from collections.abc import Callable, Sequence
from fractions import Fraction

from qdot.exercises.formula.trees import Node, split_signed_terms

Matrix = Sequence[Sequence[Node]]


def number(value: int | Fraction) -> Node:
    """Return a node for a number."""
    return Node("number", value=Fraction(value))


ZERO, ONE, TWO = number(0), number(1), number(2)


def add_nodes(a: Node, b: Node) -> Node:
    """Return a + b, simplified if one of them is 0.

    >>> add_nodes(ZERO, ONE) == ONE
    True
    """
    return b if a == ZERO else a if b == ZERO else Node("+", (a, b))


def negate(a: Node) -> Node:
    """Return -a, simplified if a is 0 or is itself negated."""
    return a if a == ZERO else a.args[0] if a.kind == "neg" else Node("neg", (a,))


def subtract_nodes(a: Node, b: Node) -> Node:
    """Return a - b, simplified if one of them is 0."""
    return a if b == ZERO else negate(b) if a == ZERO else Node("-", (a, b))


def multiply_nodes(a: Node, b: Node) -> Node:
    """Return the product a b, simplified if a factor is 0 or 1."""
    if ZERO in (a, b):
        return ZERO
    return b if a == ONE else a if b == ONE else Node("*", (a, b))


def divide_nodes(a: Node, b: Node) -> Node:
    """Return a / b, simplified if a is 0 or b is 1."""
    return ZERO if a == ZERO else a if b == ONE else Node("/", (a, b))


def raise_to_power(a: Node, b: Node) -> Node:
    """Return a ^ b, simplified if b is 0 or 1."""
    return ONE if b == ZERO else a if b == ONE else Node("^", (a, b))


def apply_function(function: str, a: Node) -> Node:
    """Return the node for a function applied to a, as in sin(a)."""
    return Node("call", (a,), function)


def split_terms(sum_node: Node) -> list[Node]:
    """Return the terms of a sum without expanding products."""
    return [negate(term) if sign < 0 else term for term, sign in split_signed_terms(sum_node)]


def expand_terms(node: Node, max_count: int) -> list[Node] | None:
    """Return the terms after expanding sums and products, or None if there are more than `max_count`."""
    if node.kind not in ("+", "-", "*", "neg"):
        return [node]
    arg_terms = [expand_terms(arg, max_count) for arg in node.args]
    known_terms = [terms for terms in arg_terms if terms is not None]
    if len(known_terms) < len(arg_terms):
        return None
    if node.kind == "*":
        terms = [multiply_nodes(first, second) for first in known_terms[0] for second in known_terms[1]]
    elif node.kind == "neg":
        terms = [negate(term) for term in known_terms[0]]
    else:
        terms = known_terms[0] + (known_terms[1] if node.kind == "+" else [negate(term) for term in known_terms[1]])
    return terms if len(terms) <= max_count else None


def split_factors(node: Node) -> list[Node]:
    """Return the factors of a product; sums are not factored.

    A denominator b becomes the factor 1/b. A power becomes its base, repeated.

    >>> x, y = Node("name", value="x"), Node("name", value="y")
    >>> split_factors(negate(multiply_nodes(raise_to_power(x, TWO), y))) == [x, x, y, number(-1)]
    True
    """
    if node.kind == "*":
        return [factor for arg in node.args for factor in split_factors(arg)]
    if node.kind == "neg":
        return [*split_factors(node.args[0]), number(-1)]
    if node.kind == "/":
        return [*split_factors(node.args[0]), *(divide_nodes(ONE, factor) for factor in split_factors(node.args[1]))]
    if node.kind == "^" and node.args[1].kind == "number" and node.args[1].value in range(1, MAX_SPLIT_POWER + 1):
        return split_factors(node.args[0]) * int(node.args[1].value)
    return [node]


MAX_SPLIT_POWER = 6
"""The highest exponent of a power that is split into repeated factors."""

# --- derivatives ---

_DERIVATIVES: dict[str, Callable[[Node], Node]] = {
    "sin": lambda x: apply_function("cos", x),
    "cos": lambda x: negate(apply_function("sin", x)),
    "tan": lambda x: divide_nodes(ONE, raise_to_power(apply_function("cos", x), TWO)),
    "cot": lambda x: negate(divide_nodes(ONE, raise_to_power(apply_function("sin", x), TWO))),
    "sec": lambda x: divide_nodes(apply_function("sin", x), raise_to_power(apply_function("cos", x), TWO)),
    "csc": lambda x: negate(divide_nodes(apply_function("cos", x), raise_to_power(apply_function("sin", x), TWO))),
    "exp": lambda x: apply_function("exp", x),
    "log": lambda x: divide_nodes(ONE, x),
    "sqrt": lambda x: divide_nodes(ONE, multiply_nodes(TWO, apply_function("sqrt", x))),
    "asin": lambda x: divide_nodes(ONE, apply_function("sqrt", subtract_nodes(ONE, raise_to_power(x, TWO)))),
    "acos": lambda x: negate(divide_nodes(ONE, apply_function("sqrt", subtract_nodes(ONE, raise_to_power(x, TWO))))),
    "atan": lambda x: divide_nodes(ONE, add_nodes(ONE, raise_to_power(x, TWO))),
    "sinh": lambda x: apply_function("cosh", x),
    "cosh": lambda x: apply_function("sinh", x),
    "tanh": lambda x: divide_nodes(ONE, raise_to_power(apply_function("cosh", x), TWO)),
}


def differentiate(node: Node, name: str) -> Node | None:
    """Return the derivative with respect to a name, or None for abs, sign, atan2 and sets.

    >>> from qdot.exercises.formula.parser import parse_formula
    >>> from qdot.exercises.formula.trees import node_text
    >>> node_text(differentiate(parse_formula("a1*cos(theta1) + 2*theta1^2"), "theta1"))
    '((a1*(-sin(theta1)))+(2*(2*theta1)))'
    """
    if node.kind in ("number", "decimal"):
        return ZERO
    if node.kind == "name":
        return ONE if node.value == name else ZERO
    arg_derivatives = [differentiate(arg, name) for arg in node.args]
    known_derivatives = [term for term in arg_derivatives if term is not None]
    if len(known_derivatives) < len(arg_derivatives):
        return None
    if all(term == ZERO for term in known_derivatives):
        return ZERO
    return _differentiate_node(node, known_derivatives)


def _differentiate_node(node: Node, arg_derivatives: Sequence[Node]) -> Node | None:
    a, da = node.args[0], arg_derivatives[0]
    if node.kind == "neg":
        return negate(da)
    if node.kind == "call":
        return multiply_nodes(_DERIVATIVES[node.value](a), da) if node.value in _DERIVATIVES else None
    if len(arg_derivatives) != 2:
        return None
    b, db = node.args[1], arg_derivatives[1]
    if node.kind in ("+", "-"):
        return add_nodes(da, db) if node.kind == "+" else subtract_nodes(da, db)
    if node.kind == "*":
        return add_nodes(multiply_nodes(da, b), multiply_nodes(a, db))
    if node.kind == "/":
        numerator = subtract_nodes(multiply_nodes(da, b), multiply_nodes(a, db))
        return divide_nodes(da, b) if db == ZERO else divide_nodes(numerator, raise_to_power(b, TWO))
    if node.kind == "^" and db == ZERO:
        reduced_exponent = number(b.value - 1) if b.kind == "number" else subtract_nodes(b, ONE)
        return multiply_nodes(multiply_nodes(b, raise_to_power(a, reduced_exponent)), da)
    if node.kind == "^":  # a^b = exp(b log a)
        logarithm_term = multiply_nodes(db, apply_function("log", a))
        return multiply_nodes(node, add_nodes(logarithm_term, divide_nodes(multiply_nodes(b, da), a)))
    return None
