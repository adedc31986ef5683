"""Represent parsed formulas as trees of nodes, which do not depend on the notation in which they were typed."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from itertools import islice
from math import log
from operator import is_
from typing import Any, TypeVar

from qdot.exercises.formula.names import CONSTANTS

Result = TypeVar("Result")


class ParseError(ValueError):
    """Raised for a text that can't be parsed; the message says what was found, where, and what to write instead."""


class UndefinedValue(ParseError):
    """Raised for a name such as nan or oo, which is not a value; the message is a whole sentence."""


@dataclass(frozen=True, slots=True)
class Node:
    """A node of a tree: its `kind`, its arguments, and as `value` a number (Fraction) or a name.

    The kinds are number, decimal (a number typed with a point or an exponent), name, blank (an unanswered entry), call
    (of the function `value`), neg, + - * / ^, list, set, dict, pair (an item of a dict), eq, in, and, or.

    The operators + - * / ** combine nodes and integers, and omit operands 0 and 1 that change nothing:

    >>> x, y = Node("name", value="x"), Node("name", value="y")
    >>> format_tree(0 + x * y**2), format_tree(-(x / ONE))
    ('(x*(y^2))', '(-x)')
    """

    kind: str
    args: tuple["Node", ...] = ()
    value: Any = None

    def with_args(self, args: Sequence["Node"]) -> "Node":
        """Return the node with new arguments, or the node itself if the arguments are the same objects."""
        has_same_args = len(args) == len(self.args) and all(map(is_, args, self.args))
        return self if has_same_args else Node(self.kind, tuple(args), self.value)

    def __add__(self, addend: "Node | int") -> "Node":
        addend = _to_node(addend)
        if self == ZERO:
            return addend
        return self if addend == ZERO else Node("+", (self, addend))

    __radd__ = __add__

    def __sub__(self, subtrahend: "Node | int") -> "Node":
        subtrahend = _to_node(subtrahend)
        if subtrahend == ZERO:
            return self
        return -subtrahend if self == ZERO else Node("-", (self, subtrahend))

    def __neg__(self) -> "Node":
        if self == ZERO:
            return self
        return self.args[0] if self.kind == "neg" else Node("neg", (self,))

    def __mul__(self, factor: "Node | int") -> "Node":
        if factor == -1:
            return -self
        factor = _to_node(factor)
        if ZERO in (self, factor):
            return ZERO
        if self == ONE:
            return factor
        return self if factor == ONE else Node("*", (self, factor))

    __rmul__ = __mul__

    def __truediv__(self, divisor: "Node | int") -> "Node":
        divisor = _to_node(divisor)
        if self == ZERO:
            return ZERO
        return self if divisor == ONE else Node("/", (self, divisor))

    def __pow__(self, exponent: "Node | int") -> "Node":
        exponent = _to_node(exponent)
        if exponent == ZERO:
            return ONE
        return self if exponent == ONE else Node("^", (self, exponent))


def make_number(value: int | Fraction) -> Node:
    """Return a node for a number."""
    return Node("number", value=Fraction(value))


def _to_node(value: Node | int) -> Node:
    return value if isinstance(value, Node) else make_number(value)


ZERO, ONE = make_number(0), make_number(1)
Nodes = Sequence[Node]

EQUATION_CHAIN = "="
"""The value of an "and" node that was typed as a chain of equations, A = B = C."""


def list_equation_sides(node: Node) -> list[Node]:
    """Return the sides of A = B or A = B = C; [] for any other node."""
    if node.kind == "eq":
        return list(node.args)
    if node.kind != "and" or node.value != EQUATION_CHAIN or any(arg.kind != "eq" for arg in node.args):
        return []
    return [node.args[0].args[0], *(arg.args[1] for arg in node.args)]


def iterate_nodes(tree: Node) -> Iterator[Node]:
    """Yield every node of a tree, each before its arguments."""
    stack = [tree]
    while stack:
        node = stack.pop()
        yield node
        stack.extend(node.args)


def fold(tree: Node, combine: Callable[[Node, list[Result]], Result]) -> Result:
    """Return the result of `combine` for the root of a tree.

    `combine` is called for each node, with the node and its arguments' results. There is no recursion, because a long
    sum is a deep tree.
    """
    results: list[Result] = []
    stack = [(tree, False)]
    while stack:
        node, is_ready = stack.pop()
        if is_ready or not node.args:
            first_arg = len(results) - len(node.args)
            results[first_arg:] = [combine(node, results[first_arg:])]
        else:
            stack.append((node, True))
            stack.extend((arg, False) for arg in reversed(node.args))
    return results[0]


def split_signed_terms(node: Node) -> list[tuple[Node, int]]:
    """Return the terms of a nested sum, each with its sign, 1 or -1; products are not expanded."""
    terms, stack = [], [(node, 1)]
    while stack:
        current_node, sign = stack.pop()
        if current_node.kind == "neg":
            stack.append((current_node.args[0], -sign))
        elif current_node.kind in ("+", "-"):
            stack += [(current_node.args[1], sign if current_node.kind == "+" else -sign), (current_node.args[0], sign)]
        else:
            terms.append((current_node, sign))
    return terms


def replace_names(tree: Node, values: Mapping[str, Node]) -> Node:
    """Return the tree with names replaced by the trees in `values`."""
    return fold(tree, lambda node, args: values.get(node.value, node) if node.kind == "name" else node.with_args(args))


def combine_from_left(kind: str, nodes: Iterable[Node]) -> Node:
    """Return a sum or product of several trees, ((a + b) + c) + d."""
    return reduce(lambda left, right: Node(kind, (left, right)), nodes)


def make_rows(rows: Iterable[Sequence[Node]]) -> Node:
    """Return a matrix: a list node with a list node for each row of entries."""
    return Node("list", tuple(Node("list", tuple(row)) for row in rows))


def find_names(tree: Node) -> set[str]:
    """Return the names in a tree that are not constants."""
    return {node.value for node in iterate_nodes(tree) if node.kind == "name" and node.value not in CONSTANTS}


def _split_decimal(decimal: Fraction) -> tuple[int, int]:
    """Return the digits of a positive decimal as a whole number, and the number of decimal places.

    >>> _split_decimal(Fraction("12.25"))
    (1225, 2)
    """
    twos = (decimal.denominator & -decimal.denominator).bit_length() - 1  # the denominator is 2^twos 5^fives
    # A number has at most 1,000 characters and an exponent of at most 400. So `fives` is at most 1,400, and the rounded
    # logarithm is exact.
    fives = round(log(decimal.denominator >> twos, 5))
    places = max(twos, fives)
    return decimal.numerator * (10**places // decimal.denominator), places


def count_digits(decimal: Fraction) -> int:
    """Return the number of significant digits of a decimal."""
    digits, _ = _split_decimal(abs(decimal))
    return len(str(digits).rstrip("0"))


def count_decimal_digits(node: Node) -> int:
    """Return the number of significant digits of the longest decimal in a tree; 0 if there is none.

    >>> count_decimal_digits(Node("neg", (Node("decimal", value=Fraction("3.14159")),)))
    6
    """
    return max((count_digits(decimal.value) for decimal in iterate_nodes(node) if decimal.kind == "decimal"), default=0)


def count_nodes(tree: Node, max_count: int | None = None) -> int:
    """Return the number of nodes in a tree, or `max_count` if there are more."""
    return sum(1 for _ in islice(iterate_nodes(tree), max_count))


def has_blank(tree: Node) -> bool:
    """Return whether the tree contains a blank."""
    return any(node.kind == "blank" for node in iterate_nodes(tree))


_SCALAR_KINDS = {"number", "decimal", "name", "call", "neg", "+", "-", "*", "/", "^"}
_KIND_DESCRIPTIONS = {
    "list": "a list", "set": "a set", "dict": "a dictionary", "pair": "a name with a colon", "eq": "an equation",
    "blank": "a blank", "or": "an alternative", "and": "a condition", "in": "a condition",
}  # fmt: skip


def find_nonscalar(node: Node) -> Node | None:
    """Return a list, a condition or a blank that is in a tree; None if the tree is a single expression."""
    return next((inner for inner in iterate_nodes(node) if inner.kind not in _SCALAR_KINDS), None)


def refuse_nonscalars(node: Node) -> None:
    """Raise ParseError if a tree is not a single expression."""
    if (nonscalar := find_nonscalar(node)) is not None:
        raise make_scalar_expected_error(nonscalar)


def make_scalar_expected_error(node: Node) -> ParseError:
    """Return the error for a list, a condition or a blank that is found in a single expression."""
    advice = "; write the expression alone" if node.kind in ("eq", "and", "or", "in") else ""
    return ParseError(f"expected a single expression, found {_KIND_DESCRIPTIONS.get(node.kind, node.kind)}{advice}")


def is_list_of_one(node: Node) -> bool:
    """Return whether a node is a list of one entry that is not itself a list, as in [a]."""
    return node.kind == "list" and len(node.args) == 1 and node.args[0].kind != "list"


def _is_column(node: Node) -> bool:
    """Return whether a node is [[a], [b], …], a column vector in SymPy's notation."""
    return node.kind == "list" and len(node.args) > 1 and all(map(is_list_of_one, node.args))


def _is_row_matrix(node: Node) -> bool:
    """Return whether a node is [[a, b, …]], a matrix with one row."""
    return node.kind == "list" and len(node.args) == 1 and node.args[0].kind == "list" and len(node.args[0].args) > 1


def _has_rows(node: Node) -> bool:
    """Return whether a node is a list of lists."""
    return node.kind == "list" and bool(node.args) and all(item.kind == "list" for item in node.args)


def as_matrix(node: Node) -> list[list[Node]]:
    """Return the rows of a matrix.

    A list of scalars is a column, and a scalar is a matrix of one entry. The comments below show other accepted
    notations. Raises ParseError if rows have different lengths, or if an entry is a list.
    """
    while node.kind == "list" and len(node.args) == 1 and _has_rows(node.args[0]):  # [[[a, b], [c, d]]]
        node = node.args[0]
    if node.kind == "list" and node.args and all(_is_row_matrix(item) for item in node.args):  # [[[a, b]], [[c, d]]]
        node = Node("list", tuple(item.args[0] for item in node.args))
    if node.kind == "set" and node.args and all(item.kind == "set" for item in node.args):  # {{a, b}, {c, d}}
        node = Node("list", tuple(Node("list", item.args) for item in node.args))
    if node.kind != "list":
        return [[node]]
    if node.args and all(_is_column(item) for item in node.args):  # [[[a], [c]], [[b], [d]]]: columns
        columns = [[entry.args[0] for entry in item.args] for item in node.args]
        if len({len(column) for column in columns}) == 1:
            return [list(row) for row in zip(*columns, strict=True)]
    rows = [list(item.args) if item.kind == "list" else [item] for item in node.args]
    if not rows:
        raise ParseError("the list is empty")
    if len({len(row) for row in rows}) != 1:
        raise ParseError(f"the rows of the matrix have different lengths: {', '.join(str(len(row)) for row in rows)}")
    if any(entry.kind in ("list", "set", "dict") for row in rows for entry in row):
        raise ParseError("an entry of the matrix is itself a list")
    return rows


def format_tree(node: Node) -> str:
    """Return the text of a single expression, from which the parser makes an expression with the same value.

    Long sums and products have no nested brackets. The tree has no lists, conditions and blanks (see `find_nonscalar`).
    """
    return fold(node, _combine_texts)


_FIRST_OPERANDS_WITHOUT_BRACKETS = {"+": ("+", "-"), "-": ("+", "-"), "*": ("*", "/"), "/": ("*", "/")}
"""Maps each operator to the kinds of first operands that need no brackets."""


def _combine_texts(node: Node, arg_texts: list[str]) -> str:
    """Return the text of a node, given the texts of its arguments."""
    if node.kind == "decimal":
        digits, places = _split_decimal(node.value)
        text = str(digits).rjust(places + 1, "0")
        return f"{text[: len(text) - places]}.{text[len(text) - places :] or '0'}"
    if node.kind == "number":
        value = node.value
        return str(value.numerator) if value.denominator == 1 else f"({value.numerator}/{value.denominator})"
    if node.kind == "name":
        return str(node.value)
    if node.kind == "call":
        return f"{node.value}({', '.join(arg_texts)})"
    if node.kind == "neg":
        return f"(-{arg_texts[0]})"
    needs_no_brackets = node.args[0].kind in _FIRST_OPERANDS_WITHOUT_BRACKETS.get(node.kind, ())
    return f"({arg_texts[0][1:-1] if needs_no_brackets else arg_texts[0]}{node.kind}{arg_texts[1]})"
