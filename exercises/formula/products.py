"""What was written of matrices and not worked out: 1/a1 * [[a, b], [c, d]] * [vx; vy], and [qd1; qd2] = [a; b]."""

from collections.abc import Callable, Sequence
from fractions import Fraction

from qdot.exercises.formula.trees import Node, ReadError
from qdot.exercises.formula.vocabulary import LIMITS, VOCABULARY

Rows = list[list[Node]]

_OPERATIONS = ("+", "-", "*", "/", "neg", "^")
_MOST = LIMITS["worked_out"]
"""Nodes of what is made: entries of a product of products grow with each factor."""
_LARGEST = 3
"""Rows of a matrix that is inverted."""


def carried_out(node: Node) -> Node:
    """Return a tree in which matrices are no operands: what was to be done with them is done. Raises ReadError.

    >>> from qdot.exercises.formula.trees import node_text
    >>> two, x = Node("number", value=Fraction(2)), Node("name", value="x")
    >>> column = carried_out(Node("*", (two, Node("list", (x, two)))))
    >>> [node_text(entry) for row in column.args for entry in row.args]
    ['(2*x)', '(2*2)']
    """
    if not _has_matrices(node):
        return node
    done: list[Node] = []
    made = 0
    stack = [(node, False)]
    while stack:  # no recursion: a long sum is a deep tree
        top, ready = stack.pop()
        if not top.args:
            done.append(top)
        elif ready:
            args = tuple(done[len(done) - len(top.args) :])
            done[len(done) - len(top.args) :] = [_operation(top, args)]
            if top.kind in _OPERATIONS and done[-1].kind == "list":
                made += _size(done[-1], _MOST - made)
                if made >= _MOST:
                    raise _too_long()
        else:
            stack.append((top, True))
            stack.extend((arg, False) for arg in reversed(top.args))
    return done[0]


def _too_long() -> ReadError:
    return ReadError("the products of matrices are too long; write their entries")


def _has_matrices(node: Node) -> bool:
    stack = [node]
    while stack:
        top = stack.pop()
        if top.kind in (*_OPERATIONS, "eq") and any(arg.kind == "list" for arg in top.args):
            return True
        stack.extend(top.args)
    return False


def _size(node: Node, most: int) -> int:
    """Return how many nodes a tree has, counted no further than `most`."""
    count, stack = 0, [node]
    while stack and count < most:
        count += 1
        stack.extend(stack.pop().args)
    return count


def _operation(top: Node, args: tuple[Node, ...]) -> Node:
    if top.kind == "eq" and all(arg.kind == "list" for arg in args):
        return _equation(args)
    if top.kind not in _OPERATIONS or all(arg.kind != "list" for arg in args):
        return Node(top.kind, args, top.value)
    args = tuple(arg.args[0] if _is_bracket(arg) else arg for arg in args)  # [a + b] c: brackets, and no list
    lists = [arg.kind == "list" for arg in args]
    if not any(lists):
        return Node(top.kind, args, top.value)
    if top.kind == "^":
        return _power(_rows(args[0]), args[1]) if lists == [True, False] else _impossible(top.kind, args)
    if top.kind == "neg":
        return _each(_rows(args[0]), lambda entry: Node("neg", (entry,)))
    one, other = args
    if top.kind in "+-" and all(lists):
        return _sum(top.kind, _rows(one), _rows(other), args)
    if top.kind == "*" and all(lists):
        return _product(_rows(one), _rows(other), args)
    if top.kind == "*" and lists[1]:
        return _each(_rows(other), lambda entry: Node("*", (one, entry)))
    if top.kind in "*/" and lists == [True, False]:
        return _each(_rows(one), lambda entry: Node(top.kind, (entry, other)))
    return _impossible(top.kind, args)


def _is_bracket(node: Node) -> bool:
    return node.kind == "list" and len(node.args) == 1 and node.args[0].kind != "list"


def _rows(node: Node) -> Rows:
    """Return the rows of a list; of a list of entries a column."""
    rows = [list(item.args) if item.kind == "list" else [item] for item in node.args]
    if not rows or len({len(row) for row in rows}) != 1 or any(entry.kind == "list" for row in rows for entry in row):
        raise ReadError("a list that is no matrix stands in a product or a sum; write its rows, as in [[a, b], [c, d]]")
    return rows


def _matrix(rows: Sequence[Sequence[Node]]) -> Node:
    return Node("list", tuple(Node("list", tuple(row)) for row in rows))


def _each(rows: Rows, made: Callable[[Node], Node]) -> Node:
    return _matrix([[made(entry) for entry in row] for row in rows])


def _sum(sign: str, one: Rows, other: Rows, args: tuple[Node, ...]) -> Node:
    if (len(one), len(one[0])) != (len(other), len(other[0])):
        return _impossible(sign, args)
    pairs = (zip(mine, theirs, strict=True) for mine, theirs in zip(one, other, strict=True))
    return _matrix([[Node(sign, pair) for pair in row] for row in pairs])


def _equation(args: tuple[Node, ...]) -> Node:
    """Return an equation of two vectors or matrices as one for each entry, a name before what it is."""
    if _is_bracket(args[0]):  # [theta2] = [0, pi]
        return Node("eq", (args[0].args[0], args[1]))
    sides = [_rows(arg) for arg in args]
    shapes = [(len(rows), len(rows[0])) for rows in sides]
    is_vector = all(1 in shape for shape in shapes)
    if (is_vector and max(shapes[0]) != max(shapes[1])) or (not is_vector and shapes[0] != shapes[1]):
        return _impossible("=", args)
    pairs = zip(*([entry for row in rows for entry in row] for rows in sides), strict=True)
    return Node("and", tuple(Node("eq", (b, a) if b.kind == "name" != a.kind else (a, b)) for a, b in pairs))


def _product(one: Rows, other: Rows, args: tuple[Node, ...]) -> Node:
    if len(one[0]) != len(other):
        return _impossible("*", args)
    if len(one) * len(other) * len(other[0]) >= _MOST:
        raise _too_long()
    columns = list(zip(*other, strict=True))
    return _matrix([[_dot(row, column) for column in columns] for row in one])


def _dot(row: Sequence[Node], column: Sequence[Node]) -> Node:
    terms = [Node("*", pair) for pair in zip(row, column, strict=True)]
    total = terms[0]
    for term in terms[1:]:
        total = Node("+", (total, term))
    return total


def _power(rows: Rows, exponent: Node) -> Node:
    """Return the transpose, or the inverse by cofactors, of a matrix."""
    if exponent.kind == "name" and exponent.value in VOCABULARY["transposed"]:
        return _matrix(list(zip(*rows, strict=True)))
    is_inverse = exponent.kind == "neg" and exponent.args[0].kind == "number" and exponent.args[0].value == 1
    if not is_inverse or len(rows) != len(rows[0]) or len(rows) > _LARGEST:
        raise ReadError(
            f"a power of a matrix is worked out where it is the inverse of one with up to {_LARGEST} rows; write the "
            "entries"
        )
    cofactors = [[_signed(i + j, _minor(rows, j, i)) for j in range(len(rows))] for i in range(len(rows))]
    whole = _determinant(rows)
    return _each(cofactors, lambda entry: Node("/", (entry, whole)))


def _minor(rows: Rows, i: int, j: int) -> Node:
    return _determinant([[entry for c, entry in enumerate(row) if c != j] for r, row in enumerate(rows) if r != i])


def _determinant(rows: Rows) -> Node:
    if not rows:
        return Node("number", value=Fraction(1))
    total: Node | None = None
    for j, entry in enumerate(rows[0]):
        term = entry if len(rows) == 1 else _signed(j, Node("*", (entry, _minor(rows, 0, j))))
        total = term if total is None else Node("+", (total, term))
    assert total is not None
    return total


def _signed(index: int, node: Node) -> Node:
    return Node("neg", (node,)) if index % 2 else node


def _impossible(sign: str, args: Sequence[Node]) -> Node:
    shapes = [f"a {len(rows)} x {len(rows[0])}" for rows in (_rows(arg) for arg in args if arg.kind == "list")]
    what = " and ".join(shapes) + (" matrix" if len(shapes) == 1 else "")
    said = {"+": "a sum", "-": "a difference", "*": "a product", "/": "a quotient", "^": "a power", "=": "equation"}[
        sign
    ]
    also = "" if len(shapes) == len(args) else " and a number"
    raise ReadError(f"there is no {said.removeprefix('a ')} of {what}{also}; write its entries, as in [[a, b], [c, d]]")
