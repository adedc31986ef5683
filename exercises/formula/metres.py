"""Distinguish the unit m, as in 0.3 m*sin(theta1), from a whole number m, as in theta2 = (2m + 1) pi/2."""

from qdot.exercises.formula.trees import Node, make_number
from qdot.exercises.formula.vocabulary import PATTERNS, VOCABULARY

METRE = "m"
_NUMBER_KINDS = ("number", "decimal")
_WHOLE_NUMBER_NAMES: list[str] = VOCABULARY["whole_numbers"]
_INVERSES = (*VOCABULARY["inverses"].values(), "atan2")
"""Inverse trigonometric functions, whose values are angles."""


def remove_metres(tree: Node) -> Node:
    """Return a tree without the unit m, which comes after a number or a list, or at the end of a product.

    An m that multiplies pi or an angle stands for a whole number and is not removed.

    >>> from qdot.exercises.formula.parser import parse_formula
    >>> from qdot.exercises.formula.trees import format_tree
    >>> texts = "d3 = 0.2 m + a1", "theta2 = (2 m + 1) pi/2", "d3 = m*a1"
    >>> [format_tree(parse_formula(text).args[1]) for text in texts]
    ['(0.2+a1)', '(((2*m)+1)*pi/2)', '(m*a1)']
    """
    results: list[Node] = []
    stack = [(tree, False, False, True)]
    while stack:  # no recursion: a long sum is a deep tree
        # `has_angle` says whether the node is in a product with an angle, `ends_product` whether it ends a product.
        current_node, has_results_of_args, has_angle, ends_product = stack.pop()
        if has_results_of_args or not current_node.args:
            args = results[len(results) - len(current_node.args) :]
            may_have_unit = current_node.kind == "*" and not has_angle and _is_metre(args[1])
            is_unit = may_have_unit and _is_unit_of(args[0], ends_product)
            results[len(results) - len(args) :] = [args[0] if is_unit else current_node.with_args(args)]
        else:
            is_product = current_node.kind in ("*", "/", "^")
            has_angle = current_node.kind != "call" and (
                has_angle or (is_product and ends_product and _contains_angle(current_node))
            )
            stack.append((current_node, True, has_angle, ends_product))
            stack += [(arg, False, has_angle, not is_product) for arg in reversed(current_node.args)]
    return results[0]


def _is_metre(node: Node) -> bool:
    """Return whether a factor is m or m^2."""
    is_square = node.kind == "^" and node.args[1] == make_number(2)
    return (node.args[0] if is_square else node).value == METRE


def _is_unit_of(factors: Node, ends_product: bool) -> bool:
    """Return whether an m after a product of factors is a unit.

    The m is a unit if the last factor is a number, a fraction or a list. If the m ends the product (`ends_product`), it
    is a unit unless the last factor is a name of a whole number.
    """
    last_factor = factors.args[1] if factors.kind == "*" else factors
    if ends_product:
        return last_factor.value not in _WHOLE_NUMBER_NAMES
    is_fraction = last_factor.kind == "/" and all(arg.kind in _NUMBER_KINDS for arg in last_factor.args)
    return is_fraction or last_factor.kind in (*_NUMBER_KINDS, "list")


def _contains_angle(product: Node) -> bool:
    """Return whether a product contains pi or an angle, except in the argument of a function.

    Inverse trigonometric functions count as angles.
    """
    stack = [product]
    while stack:
        current_node = stack.pop()
        is_angle = current_node.kind == "name" and PATTERNS["angle"].fullmatch(current_node.value)
        if is_angle or current_node.value in ("pi", *_INVERSES):
            return True
        if current_node.kind != "call":
            stack.extend(current_node.args)
    return False
