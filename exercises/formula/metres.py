"""The unit m in a formula, 0.3 m*sin(theta1), distinguished from a whole number, as in theta2 = (2m + 1) pi/2."""

from qdot.exercises.formula.trees import Node
from qdot.exercises.formula.vocabulary import VOCABULARY, pattern

METRE = "m"
_ANGLE = pattern("angle")
_SQUARE = 2
_NUMBERS = ("number", "decimal")
_WHOLE: list[str] = VOCABULARY["whole_numbers"]
_INVERSES = (*VOCABULARY["inverses"].values(), "atan2")


def remove_metres(tree: Node) -> Node:
    """Return a tree without the unit m behind a number or a list, and at the end of a product.

    Where it multiplies pi or an angle, m is a whole number, and stays.

    >>> from qdot.exercises.formula.parser import read
    >>> from qdot.exercises.formula.trees import node_text
    >>> [node_text(read(text).args[1]) for text in ("d3 = 0.2 m + a1", "theta2 = (2 m + 1) pi/2", "d3 = m*a1")]
    ['(0.2+a1)', '(((2*m)+1)*pi/2)', '(m*a1)']
    """
    done: list[Node] = []
    stack = [(tree, False, False, True)]
    while stack:  # no recursion: a long sum is a deep tree
        top, is_ready, counts, is_last = stack.pop()
        if is_ready or not top.args:
            args = done[len(done) - len(top.args) :]
            is_unit = top.kind == "*" and not counts and _is_metre(args[1]) and _has_unit(args[0], is_last)
            done[len(done) - len(args) :] = [args[0] if is_unit else top.with_args(args)]
        else:
            is_product = top.kind in ("*", "/", "^")
            counts = top.kind != "call" and (counts or (is_product and is_last and _turns(top)))
            stack.append((top, True, counts, is_last))
            stack += [(arg, False, counts, not is_product) for arg in reversed(top.args)]
    return done[0]


def _is_metre(node: Node) -> bool:
    is_power = node.kind == "^" and node.args[1].kind == "number" and node.args[1].value == _SQUARE
    return (node.args[0] if is_power else node).value == METRE


def _has_unit(node: Node, is_last: bool) -> bool:
    """Tell whether what stands before m has it as its unit: a number, fraction or list; before the last m, most do."""
    last = node.args[1] if node.kind == "*" else node
    if is_last:
        return last.value not in _WHOLE
    is_fraction = last.kind == "/" and all(arg.kind in _NUMBERS for arg in last.args)
    return is_fraction or last.kind in (*_NUMBERS, "list")


def _turns(product: Node) -> bool:
    """Tell whether pi or an angle is in a product, other than in a function that is no angle itself."""
    stack = [product]
    while stack:
        top = stack.pop()
        if top.value == "pi" or top.value in _INVERSES or (top.kind == "name" and _ANGLE.fullmatch(top.value)):
            return True
        if top.kind != "call":
            stack.extend(top.args)
    return False
