"""Expressions as trees of plain nodes, and what can be asked of a tree without knowing how it was written."""

from dataclasses import dataclass
from fractions import Fraction
from math import log
from typing import Any

from qdot.exercises.formula.names import CONSTANTS


class ReadError(ValueError):
    """Text that is no answer: what was found, where, and what would be understood."""


@dataclass(frozen=True, slots=True)
class Node:
    """A piece of an expression: `kind` and `args`; `value` holds a number (Fraction) or a name.

    Kinds: number, decimal, name, blank, call, neg, + - * / ^, list, set, dict, pair, eq, in, and (`CHAIN`), or.
    """

    kind: str
    args: tuple["Node", ...] = ()
    value: Any = None


CHAIN = "="
"""The value of an "and" of equations that were written in one, A = B = C."""


def chain_of(node: Node) -> list[Node]:
    """Return the sides of A = B = C; nothing of what is no equation."""
    if node.kind == "eq":
        return list(node.args)
    if node.kind != "and" or node.value != CHAIN or any(arg.kind != "eq" for arg in node.args):
        return []
    return [node.args[0].args[0], *(arg.args[1] for arg in node.args)]


def replaced(node: Node, name: str, new: Node) -> Node:
    """Return the tree with another tree put for a name."""
    done: list[Node] = []
    stack = [(node, False)]
    while stack:  # no recursion: a long sum is a deep tree
        top, ready = stack.pop()
        if top.kind == "name":
            done.append(new if top.value == name else top)
        elif not top.args:
            done.append(top)
        elif ready:
            args = tuple(done[len(done) - len(top.args) :])
            done[len(done) - len(top.args) :] = [Node(top.kind, args, top.value)]
        else:
            stack.append((top, True))
            stack.extend((arg, False) for arg in reversed(top.args))
    return done[0]


def names(node: Node) -> set[str]:
    """Return the names in a tree that are not constants."""
    used, stack = set(), [node]
    while stack:
        top = stack.pop()
        if top.kind == "name" and top.value not in CONSTANTS:
            used.add(top.value)
        stack.extend(top.args)
    return used


def _whole(decimal: Fraction) -> tuple[int, int]:
    """Return the digits of a positive decimal as a whole number, and how many of them stand behind the point."""
    twos = (decimal.denominator & -decimal.denominator).bit_length() - 1
    fives = round(log(decimal.denominator >> twos, 5))  # at most 1,400, so that this is exact
    places = max(twos, fives)
    return decimal.numerator * (10**places // decimal.denominator), places


def digits_of(decimal: Fraction) -> int:
    """Return how many significant digits a decimal has."""
    return len(str(_whole(abs(decimal))[0]).rstrip("0"))


def digits_of_decimals(node: Node) -> int:
    """Return how many significant digits the longest decimal in a tree has; 0 without one.

    >>> digits_of_decimals(Node("neg", (Node("decimal", value=Fraction("3.14159")),)))
    6
    """
    most, stack = 0, [node]
    while stack:
        top = stack.pop()
        if top.kind == "decimal":
            most = max(most, digits_of(top.value))
        stack.extend(top.args)
    return most


def size_of(node: Node) -> int:
    """Return how many nodes a tree has."""
    count, stack = 0, [node]
    while stack:
        count += 1
        stack.extend(stack.pop().args)
    return count


def has_blank(node: Node) -> bool:
    """Tell whether a placeholder is still there somewhere in the tree."""
    stack = [node]
    while stack:
        top = stack.pop()
        if top.kind == "blank":
            return True
        stack.extend(top.args)
    return False


_SCALARS = {"number", "decimal", "name", "call", "neg", "+", "-", "*", "/", "^"}
_SAID = {
    "list": "a list", "set": "a set", "dict": "a dictionary", "pair": "a name with a colon", "eq": "an equation",
    "blank": "a blank", "or": "an alternative", "and": "a condition", "in": "a condition",
}  # fmt: skip


def statement_in(node: Node) -> Node | None:
    """Return a list, a condition or a blank in a tree, which is no single expression then; None in one that is."""
    stack = [node]
    while stack:
        top = stack.pop()
        if top.kind not in _SCALARS:
            return top
        stack.extend(top.args)
    return None


def refuse_statements(node: Node) -> None:
    """Raise ReadError where a tree is no single expression."""
    if (statement := statement_in(node)) is not None:
        raise no_scalar(statement)


def no_scalar(node: Node) -> ReadError:
    """Return the error that a node is no part of a single expression."""
    instead = "; write what is asked alone" if node.kind in ("eq", "and", "or", "in") else ""
    return ReadError(f"{_SAID.get(node.kind, node.kind)} stands where a single expression is due{instead}")


def _is_column(node: Node) -> bool:
    """Tell whether a node is [[a], [b], …], a column vector as SymPy writes it."""
    one_each = all(item.kind == "list" and len(item.args) == 1 and item.args[0].kind != "list" for item in node.args)
    return node.kind == "list" and len(node.args) > 1 and one_each


def _is_row_matrix(node: Node) -> bool:
    return node.kind == "list" and len(node.args) == 1 and node.args[0].kind == "list" and len(node.args[0].args) > 1


def _is_rows(node: Node) -> bool:
    return node.kind == "list" and bool(node.args) and all(item.kind == "list" for item in node.args)


def as_matrix(node: Node) -> list[list[Node]]:
    """Return rows of scalars: a list of rows, a list of scalars (a column), or a scalar (1 x 1).

    Raises ReadError where rows differ in length or lists nest deeper.
    """
    while node.kind == "list" and len(node.args) == 1 and _is_rows(node.args[0]):
        node = node.args[0]
    if node.kind == "list" and node.args and all(_is_row_matrix(item) for item in node.args):  # [[[a, b]], [[c, d]]]
        node = Node("list", tuple(item.args[0] for item in node.args))
    if node.kind == "set" and node.args and all(item.kind == "set" for item in node.args):  # {{a, b}, {c, d}}
        node = Node("list", tuple(Node("list", item.args) for item in node.args))
    if node.kind != "list":
        return [[node]]
    if node.args and all(_is_column(item) for item in node.args):  # a list of column vectors, side by side
        columns = [[entry.args[0] for entry in item.args] for item in node.args]
        if len({len(column) for column in columns}) == 1:
            return [list(row) for row in zip(*columns, strict=True)]
    rows = [list(item.args) if item.kind == "list" else [item] for item in node.args]
    if not rows:
        raise ReadError("the list is empty")
    if len({len(row) for row in rows}) != 1:
        raise ReadError(f"the rows of the matrix have different lengths: {', '.join(str(len(row)) for row in rows)}")
    if any(entry.kind in ("list", "set", "dict") for row in rows for entry in row):
        raise ReadError("an entry of the matrix is itself a list")
    return rows


def node_text(node: Node) -> str:
    """Return a text that reads as the same tree; a long sum or product has no more brackets than a short one."""
    done: list[str] = []
    stack = [(node, False)]
    while stack:  # no recursion: a long sum is a deep tree
        top, ready = stack.pop()
        if ready:
            first = len(done) - len(top.args)
            done[first:] = [_text(top, done[first:])]
        else:
            stack.append((top, True))
            stack.extend((arg, False) for arg in reversed(top.args))
    return done[0]


_FROM_THE_LEFT = {"+": ("+", "-"), "-": ("+", "-"), "*": ("*", "/"), "/": ("*", "/")}
"""What a first operand may be that needs no brackets."""


def _text(node: Node, inner: list[str]) -> str:
    if node.kind == "decimal":
        digits, places = _whole(node.value)
        text = str(digits).rjust(places + 1, "0")
        return f"{text[: len(text) - places]}.{text[len(text) - places :] or '0'}"
    if node.kind == "number":
        value = node.value
        return str(value.numerator) if value.denominator == 1 else f"({value.numerator}/{value.denominator})"
    if node.kind == "name":
        return str(node.value)
    if node.kind == "call":
        return f"{node.value}({', '.join(inner)})"
    if node.kind == "neg":
        return f"(-{inner[0]})"
    first = inner[0][1:-1] if node.args[0].kind in _FROM_THE_LEFT.get(node.kind, ()) else inner[0]
    return f"({first}{node.kind}{inner[1]})"
