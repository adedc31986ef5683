"""Evaluate operations on matrices, as in 1/a1 * [[a, b], [c, d]] * [vx; vy] and [qd1; qd2] = [a; b]."""

from collections.abc import Callable, Sequence

from qdot.exercises.formula import trees
from qdot.exercises.formula.trees import ONE, Node, ParseError, combine_from_left, fold, make_rows
from qdot.exercises.formula.vocabulary import LIMITS, VOCABULARY

Rows = list[list[Node]]
"""The rows of a matrix."""

_OPERATIONS = {"+": "sum", "-": "difference", "*": "product", "/": "quotient", "^": "power", "neg": "negative"}
"""Maps each operation on matrices to its name in messages."""
_MAX_NODES = LIMITS["nodes_of_results"]
"""Maximum number of nodes of all results together, because the entries of a product grow with each factor."""
_MAX_INVERTED_ROWS = 3
"""Maximum number of rows of a matrix that is inverted."""
_TOO_LONG_MESSAGE = "the matrix products are too long; write out their entries"


def evaluate_matrices(tree: Node) -> Node:
    """Return a tree in which operations on matrices are replaced by their results. Raises ParseError.

    >>> two, x = Node("number", value=2), Node("name", value="x")
    >>> column = evaluate_matrices(Node("*", (two, Node("list", (x, two)))))
    >>> [entry.kind for row in column.args for entry in row.args]
    ['*', '*']
    """
    operations = (node for node in trees.iterate_nodes(tree) if node.kind in _OPERATIONS or node.kind == "eq")
    if not any(arg.kind == "list" for node in operations for arg in node.args):
        return tree
    node_count = 0

    def carry_out(node: Node, args: Sequence[Node]) -> Node:
        nonlocal node_count
        is_equation = node.kind == "eq" and all(arg.kind == "list" for arg in args)
        result = _equate_entries(args) if is_equation else _carry_out_operation(node, args)
        if node.kind in _OPERATIONS and result.kind == "list":
            node_count += trees.count_nodes(result, _MAX_NODES - node_count)
            if node_count >= _MAX_NODES:
                raise ParseError(_TOO_LONG_MESSAGE)
        return result

    return fold(tree, carry_out)


def _carry_out_operation(node: Node, args: Sequence[Node]) -> Node:
    """Return the result of an operation on matrices; return any other node with its new arguments."""
    if node.kind not in _OPERATIONS:
        return node.with_args(args)
    # in [a + b] c, square brackets group a formula
    operands = [arg.args[0] if trees.is_list_of_one(arg) else arg for arg in args]
    are_matrices = [operand.kind == "list" for operand in operands]
    if not any(are_matrices):
        return node.with_args(operands)
    matrices = [_list_rows(operand) for operand in operands if operand.kind == "list"]
    if node.kind == "neg":
        return _map_entries(matrices[0], lambda entry: Node("neg", (entry,)))
    if node.kind == "^" and are_matrices == [True, False]:
        return _raise_matrix(matrices[0], operands[1])
    if node.kind in "+-" and all(are_matrices) and _find_shape(matrices[0]) == _find_shape(matrices[1]):
        pairs = (zip(*rows, strict=True) for rows in zip(*matrices, strict=True))
        return make_rows([[Node(node.kind, pair) for pair in row] for row in pairs])
    if node.kind == "*" and all(are_matrices) and len(matrices[0][0]) == len(matrices[1]):
        return _multiply(*matrices)
    if node.kind == "*" and are_matrices == [False, True]:
        return _map_entries(matrices[0], lambda entry: Node("*", (operands[0], entry)))
    if node.kind in "*/" and are_matrices == [True, False]:
        return _map_entries(matrices[0], lambda entry: Node(node.kind, (entry, operands[1])))
    raise _make_operation_error(_OPERATIONS[node.kind], matrices, len(operands))


def _list_rows(node: Node) -> Rows:
    """Return the rows of a list; a list of entries is a column."""
    rows = [list(item.args) if item.kind == "list" else [item] for item in node.args]
    if not rows or len({len(row) for row in rows}) != 1 or any(entry.kind == "list" for row in rows for entry in row):
        raise ParseError(
            "a product or sum contains a list that is not a matrix; write its rows, as in [[a, b], [c, d]]"
        )
    return rows


def _find_shape(rows: Rows) -> tuple[int, int]:
    return len(rows), len(rows[0])


def _map_entries(rows: Rows, function: Callable[[Node], Node]) -> Node:
    return make_rows([[function(entry) for entry in row] for row in rows])


def _equate_entries(args: Sequence[Node]) -> Node:
    """Return an equation of two vectors or matrices as an equation for each entry.

    The sides of an entry's equation are swapped if only the right side is a name.
    """
    if trees.is_list_of_one(args[0]):  # [theta2] = [0, pi]
        return Node("eq", (args[0].args[0], args[1]))
    sides = [_list_rows(arg) for arg in args]
    shapes = [_find_shape(rows) for rows in sides]
    is_vector = all(1 in shape for shape in shapes)
    if (is_vector and max(shapes[0]) != max(shapes[1])) or (not is_vector and shapes[0] != shapes[1]):
        raise _make_operation_error("equation", sides, len(args))
    pairs = zip(*([entry for row in rows for entry in row] for rows in sides), strict=True)
    sorted_pairs = ((b, a) if b.kind == "name" and a.kind != "name" else (a, b) for a, b in pairs)
    return Node("and", tuple(Node("eq", pair) for pair in sorted_pairs))


def _multiply(left: Rows, right: Rows) -> Node:
    """Return the product of two matrices."""
    if len(left) * len(right) * len(right[0]) >= _MAX_NODES:
        raise ParseError(_TOO_LONG_MESSAGE)
    columns = list(zip(*right, strict=True))
    return make_rows(
        [combine_from_left("+", [Node("*", pair) for pair in zip(row, column, strict=True)]) for column in columns]
        for row in left
    )


def _raise_matrix(rows: Rows, exponent: Node) -> Node:
    """Return the transpose of a matrix for the exponent T, and the inverse (by cofactors) for the exponent -1."""
    if exponent.kind == "name" and exponent.value in VOCABULARY["transposed"]:
        return make_rows(zip(*rows, strict=True))
    is_inverse = exponent.kind == "neg" and exponent.args[0].kind == "number" and exponent.args[0].value == 1
    if not is_inverse or len(rows) != len(rows[0]) or len(rows) > _MAX_INVERTED_ROWS:
        limits = f"qdot inverts matrices of at most {_MAX_INVERTED_ROWS} rows, and computes no other power"
        raise ParseError(f"{limits}; write out the entries")
    indices = range(len(rows))
    cofactors = [[_apply_cofactor_sign(i + j, _compute_minor(rows, j, i)) for j in indices] for i in indices]
    determinant = _compute_determinant(rows)
    return _map_entries(cofactors, lambda entry: Node("/", (entry, determinant)))


def _compute_minor(rows: Rows, i: int, j: int) -> Node:
    """Return the determinant without row i and column j."""
    other_rows = rows[:i] + rows[i + 1 :]
    return _compute_determinant([row[:j] + row[j + 1 :] for row in other_rows])


def _compute_determinant(rows: Rows) -> Node:
    if len(rows) < 2:
        return rows[0][0] if rows else ONE
    products = (Node("*", (entry, _compute_minor(rows, 0, j))) for j, entry in enumerate(rows[0]))
    return combine_from_left("+", [_apply_cofactor_sign(j, product) for j, product in enumerate(products)])


def _apply_cofactor_sign(index: int, node: Node) -> Node:
    return Node("neg", (node,)) if index % 2 else node


def _make_operation_error(operation: str, matrices: Sequence[Rows], operand_count: int) -> ParseError:
    shapes = " and ".join(f"a {rows} × {columns}" for rows, columns in map(_find_shape, matrices))
    shapes += " matrix" if len(matrices) == 1 else ""
    shapes += " and a number" if len(matrices) < operand_count else ""
    return ParseError(f"there is no {operation} of {shapes}; write out the entries, as in [[a, b], [c, d]]")
