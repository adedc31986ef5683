"""Answers compared as they are written: trees in one order, how alike two are, and who wrote nearly the same wrong one.

Nothing here judges: that two students wrote the same is a hint for a person to look at, and no more.
"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import combinations

from qdot.exercises.formula.trees import Node, has_blank, size_of
from qdot.grader.judging.answer import ParsedAnswer

LONGEST = 3000
"""Characters of an answer that is compared."""
LARGEST = 600
"""Nodes of a tree that is compared."""
LEAST_SIZE = 9
"""A tree of fewer nodes is the same in two notebooks by chance: a1*sin(theta1) has 4."""
ALIKE = 0.9
"""The share of pieces that two answers have in common to be nearly the same."""
MOST_PAIRS = 400
"""So many different wrong answers to a part are compared with one another; of more, only those that are the same."""

_IN_ANY_ORDER = {"+", "*", "set", "and", "or", "eq"}


@dataclass(frozen=True)
class Written:
    """An answer as it is written: in one order, as text, and the pieces that it is made of with how often each is."""

    text: str
    size: int
    pieces: tuple[tuple[str, int], ...]


@dataclass(frozen=True)
class Wrong:
    """A student's wrong answer to a part, with what is due there: `due` is the same for the same problem."""

    student: str
    answer: str
    written: Written
    due: str


@dataclass(frozen=True)
class Pair:
    """Two students' answers that are nearly the same, though what is due differs."""

    first: Wrong
    second: Wrong
    alike: float


def written(parsed_answer: ParsedAnswer) -> Written | None:
    """Return an answer in the order in which all are compared; None where it can't be read, is blank, or too long."""
    return None if parsed_answer.tree is None or len(parsed_answer.text) > LONGEST else _written(parsed_answer.tree)


@lru_cache(maxsize=4096)
def _written(tree: Node) -> Written | None:
    pieces = Counter[str]()
    try:
        if has_blank(tree) or size_of(tree) > LARGEST:
            return None
        return Written(_ordered(_flat(tree), pieces), size_of(tree), tuple(sorted(pieces.items())))
    except RecursionError:  # too deep to be a formula that anybody wrote
        return None


def _flat(node: Node) -> Node:
    """Return the tree with one sum for sums of sums, one product for products of products, and its numbers as one.

    a − b is a + (−1)·b, and a/2 is (1/2)·a: where a sign or a fraction stands is no difference.
    """
    args = tuple(_flat(arg) for arg in node.args)
    if node.kind == "neg":
        return _product((_MINUS, *args))
    if node.kind == "-" and len(args) == 2:
        args, node = (args[0], _product((_MINUS, args[1]))), Node("+")
    if node.kind == "/" and args[1].kind in _NUMBERS and args[1].value:
        return _product((args[0], Node("number", value=1 / args[1].value)))
    if node.kind == "*":
        return _product(args)
    if node.kind == "+":
        args = tuple(inner for arg in args for inner in (arg.args if arg.kind == "+" else (arg,)))
    if node.kind == "list" and len(args) == 1 and args[0].kind == "list":
        return args[0]
    return Node("number" if node.kind in _NUMBERS else node.kind, args, node.value)


_NUMBERS = ("number", "decimal")
_MINUS = Node("number", value=Fraction(-1))


def _product(args: tuple[Node, ...]) -> Node:
    factors = [inner for arg in args for inner in (arg.args if arg.kind == "*" else (arg,))]
    others = [each for each in factors if each.kind not in _NUMBERS]
    number = math.prod((each.value for each in factors if each.kind in _NUMBERS), start=Fraction(1))
    if number != 1 or not others:
        others.insert(0, Node("number", value=number))
    return others[0] if len(others) == 1 else Node("*", tuple(others))


def _ordered(node: Node, pieces: Counter[str]) -> str:
    inner = [_ordered(arg, pieces) for arg in node.args]
    if node.kind in _IN_ANY_ORDER:
        inner.sort()
    head = str(node.value) if node.value is not None else node.kind
    text = f"{head}({' '.join(inner)})" if inner else head
    pieces[text] += 1
    return text


def alikeness(first: Written, second: Written) -> float:
    """Return the share of pieces in common, from 0 to 1 for the same in any order of terms and factors."""
    if first.text == second.text:
        return 1.0
    left, right = Counter(dict(first.pieces)), Counter(dict(second.pieces))
    return (left & right).total() / max(1, (left | right).total())


def nearly_the_same(answers: Sequence[Wrong], usual: int) -> list[Pair]:
    """Return pairs that are nearly the same where something else is due, the most alike first.

    What more than `usual` students wrote is a mistake that one makes, and no hint; nor is what is short.
    """
    long = [answer for answer in answers if answer.written.size >= LEAST_SIZE]
    count = Counter(answer.written.text for answer in long)
    rare = [answer for answer in long if count[answer.written.text] <= usual]
    pairs = [
        Pair(first, second, alikeness(first.written, second.written))
        for first, second in combinations(rare, 2)
        if first.due != second.due and (len(rare) <= MOST_PAIRS or first.written.text == second.written.text)
    ]
    return sorted((pair for pair in pairs if pair.alike >= ALIKE), key=lambda pair: -pair.alike)
