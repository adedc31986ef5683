"""Compare answers as they are written, and find students who wrote nearly the same wrong answer.

Nothing is judged here: two similar answers are only a hint for a person.
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
"""Maximum length (characters) of an answer that is compared."""
LARGEST = 600
"""Maximum number of nodes of a tree that is compared."""
LEAST_SIZE = 9
"""Minimum number of nodes: smaller trees may be equal by chance (a1*sin(theta1) has 4)."""
ALIKE = 0.9
"""Minimum share of common subtrees of two answers that count as nearly the same."""
MOST_PAIRS = 400
"""Maximum number of wrong answers to a part that are compared in pairs; if there are more, only equal pairs count."""

_IN_ANY_ORDER = {"+", "*", "set", "and", "or", "eq"}


@dataclass(frozen=True)
class Written:
    """An answer as it is written: its text in a standard order, its size, and its subtrees with their counts."""

    text: str
    size: int
    pieces: tuple[tuple[str, int], ...]


@dataclass(frozen=True)
class Wrong:
    """A student's wrong answer to a part. `due` is the expected answer; equal problems have equal ones."""

    student: str
    answer: str
    written: Written
    due: str


@dataclass(frozen=True)
class Pair:
    """Two students' answers that are nearly the same although the expected answers differ."""

    first: Wrong
    second: Wrong
    alike: float


def written(parsed_answer: ParsedAnswer) -> Written | None:
    """Return an answer in a standard order; None if it can't be parsed, has a blank, or is too long."""
    return None if parsed_answer.tree is None or len(parsed_answer.text) > LONGEST else _written(parsed_answer.tree)


@lru_cache(maxsize=4096)
def _written(tree: Node) -> Written | None:
    pieces = Counter[str]()
    try:
        if has_blank(tree) or size_of(tree) > LARGEST:
            return None
        return Written(_ordered(_flat(tree), pieces), size_of(tree), tuple(sorted(pieces.items())))
    except RecursionError:  # nested too deeply to be a formula that a student wrote
        return None


def _flat(node: Node) -> Node:
    """Flatten nested sums and products of a tree, and multiply its numeric factors together.

    a − b becomes a + (−1)·b, and a/2 becomes (1/2)·a, so the position of a sign or a fraction makes no difference.
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
    other_factors = [factor for factor in factors if factor.kind not in _NUMBERS]
    numeric_factor = math.prod((factor.value for factor in factors if factor.kind in _NUMBERS), start=Fraction(1))
    if numeric_factor != 1 or not other_factors:
        other_factors.insert(0, Node("number", value=numeric_factor))
    return other_factors[0] if len(other_factors) == 1 else Node("*", tuple(other_factors))


def _ordered(node: Node, pieces: Counter[str]) -> str:
    argument_texts = [_ordered(arg, pieces) for arg in node.args]
    if node.kind in _IN_ANY_ORDER:
        argument_texts.sort()
    head = str(node.value) if node.value is not None else node.kind
    text = f"{head}({' '.join(argument_texts)})" if argument_texts else head
    pieces[text] += 1
    return text


def alikeness(first: Written, second: Written) -> float:
    """Return the share of common subtrees, from 0 to 1; it is 1 if only the order of terms and factors differs."""
    if first.text == second.text:
        return 1.0
    first_pieces, second_pieces = Counter(dict(first.pieces)), Counter(dict(second.pieces))
    return (first_pieces & second_pieces).total() / max(1, (first_pieces | second_pieces).total())


def nearly_the_same(answers: Sequence[Wrong], usual: int) -> list[Pair]:
    """Return pairs of nearly the same answers whose expected answers differ, the most similar first.

    Answers that more than `usual` students wrote are common mistakes and are ignored, and so are short answers.
    """
    long_answers = [answer for answer in answers if answer.written.size >= LEAST_SIZE]
    text_counts = Counter(answer.written.text for answer in long_answers)
    rare_answers = [answer for answer in long_answers if text_counts[answer.written.text] <= usual]
    pairs = [
        Pair(first, second, alikeness(first.written, second.written))
        for first, second in combinations(rare_answers, 2)
        if first.due != second.due and (len(rare_answers) <= MOST_PAIRS or first.written.text == second.written.text)
    ]
    return sorted((pair for pair in pairs if pair.alike >= ALIKE), key=lambda pair: -pair.alike)
