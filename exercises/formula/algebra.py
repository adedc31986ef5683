"""Split parsed formulas into terms and factors, and differentiate them, without SymPy."""

from collections.abc import Callable, Sequence

from qdot.exercises.formula.trees import ONE, ZERO, Node, ParseError, make_number, split_signed_terms

Matrix = Sequence[Sequence[Node]]
"""The rows of a matrix of trees."""


def apply_function(function: str, argument: Node) -> Node:
    """Return the node for a call of a function, such as sin(x)."""
    return Node("call", (argument,), function)


def split_terms(sum_node: Node) -> list[Node]:
    """Return the terms of a sum with their signs; products are not expanded."""
    return [-term if sign < 0 else term for term, sign in split_signed_terms(sum_node)]


def expand_terms(node: Node, max_count: int) -> list[Node] | None:
    """Return the terms of a tree in which products of sums are expanded, or None if there are more than `max_count`."""
    if node.kind not in ("+", "-", "*", "neg"):
        return [node]
    arg_terms = [expand_terms(arg, max_count) for arg in node.args]
    known_terms = [terms for terms in arg_terms if terms is not None]
    if len(known_terms) < len(arg_terms):
        return None
    if node.kind == "*":
        terms = [factor * other_factor for factor in known_terms[0] for other_factor in known_terms[1]]
    elif node.kind == "neg":
        terms = [-term for term in known_terms[0]]
    else:
        terms = known_terms[0] + (known_terms[1] if node.kind == "+" else [-term for term in known_terms[1]])
    return terms if len(terms) <= max_count else None


def split_factors(node: Node) -> list[Node]:
    """Return the factors of a product; sums are not factored.

    A denominator b becomes the factor 1/b. A power becomes its base, repeated.

    >>> x, y = Node("name", value="x"), Node("name", value="y")
    >>> split_factors(-(x**2 * y)) == [x, x, y, make_number(-1)]
    True
    """
    if node.kind == "*":
        return [factor for arg in node.args for factor in split_factors(arg)]
    if node.kind == "neg":
        return [*split_factors(node.args[0]), make_number(-1)]
    if node.kind == "/":
        return [*split_factors(node.args[0]), *(ONE / factor for factor in split_factors(node.args[1]))]
    if node.kind == "^" and node.args[1].kind == "number" and node.args[1].value in range(1, MAX_SPLIT_POWER + 1):
        return split_factors(node.args[0]) * int(node.args[1].value)
    return [node]


MAX_SPLIT_POWER = 6
"""The highest exponent of a power that is split into repeated factors."""

# --- derivatives ---

_DERIVATIVES: dict[str, Callable[[Node], Node]] = {
    "sin": lambda x: apply_function("cos", x),
    "cos": lambda x: -apply_function("sin", x),
    "tan": lambda x: ONE / apply_function("cos", x) ** 2,
    "cot": lambda x: -(ONE / apply_function("sin", x) ** 2),
    "sec": lambda x: apply_function("sin", x) / apply_function("cos", x) ** 2,
    "csc": lambda x: -(apply_function("cos", x) / apply_function("sin", x) ** 2),
    "exp": lambda x: apply_function("exp", x),
    "log": lambda x: ONE / x,
    "sqrt": lambda x: ONE / (make_number(2) * apply_function("sqrt", x)),
    "asin": lambda x: ONE / apply_function("sqrt", ONE - x**2),
    "acos": lambda x: -(ONE / apply_function("sqrt", ONE - x**2)),
    "atan": lambda x: ONE / (ONE + x**2),
    "sinh": lambda x: apply_function("cosh", x),
    "cosh": lambda x: apply_function("sinh", x),
    "tanh": lambda x: ONE / apply_function("cosh", x) ** 2,
    "abs": lambda x: apply_function("sign", x),
    "sign": lambda _: ZERO,
}


def differentiate(node: Node, name: str) -> Node:
    """Return the derivative with respect to a name. Raises ParseError for atan2 and sets.

    >>> from qdot.exercises.formula.parser import parse_formula
    >>> from qdot.exercises.formula.trees import format_tree
    >>> format_tree(differentiate(parse_formula("a1*cos(theta1) + 2*theta1^2"), "theta1"))
    '((a1*(-sin(theta1)))+(2*(2*theta1)))'
    """
    if node.kind == "name":
        return ONE if node.value == name else ZERO
    arg_derivatives = [differentiate(arg, name) for arg in node.args]
    if all(derivative == ZERO for derivative in arg_derivatives):  # also for a number, which has no arguments
        return ZERO
    return _differentiate_node(node, arg_derivatives)


def _differentiate_node(node: Node, arg_derivatives: Sequence[Node]) -> Node:
    """Return the derivative of a node, given the derivatives of its arguments."""
    a, da = node.args[0], arg_derivatives[0]
    if node.kind == "neg":
        return -da
    if node.kind == "call" and node.value in _DERIVATIVES:
        return _DERIVATIVES[node.value](a) * da
    if node.kind not in ("+", "-", "*", "/", "^"):
        raise ParseError("the formula has no derivative")
    b, db = node.args[1], arg_derivatives[1]
    if node.kind in ("+", "-"):
        return da + db if node.kind == "+" else da - db
    if node.kind == "*":
        return da * b + a * db
    if node.kind == "/":
        return da / b if db == ZERO else (da * b - a * db) / b**2
    if db == ZERO:
        reduced_exponent = make_number(b.value - 1) if b.kind == "number" else b - ONE
        return b * a**reduced_exponent * da
    return node * (db * apply_function("log", a) + b * da / a)  # a^b = exp(b log a)
