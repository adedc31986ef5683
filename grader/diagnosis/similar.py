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

from qdot.exercises.formula.trees import Node, count_nodes, has_blank
from qdot.grader.judging.answer_parser import ParsedAnswer

MAX_LENGTH = 3000
"""Maximum length (characters) of an answer that is compared."""
MAX_NODES = 600
"""Maximum number of nodes of a tree that is compared."""
MIN_NODES = 9
"""Minimum number of nodes: smaller trees may be equal by chance (a1*sin(theta1) has 4)."""
MIN_SIMILARITY = 0.9
"""Minimum share of common subtrees of two answers that count as nearly the same."""
MAX_PAIRED_ANSWERS = 400
"""Maximum number of wrong answers to a part whose pairs are all compared. Otherwise, only equal answers count."""

_COMMUTATIVE_KINDS = {"+", "*", "set", "and", "or", "eq"}


@dataclass(frozen=True)
class CanonicalForm:
    """An answer as it is written: its text in a standard order, its size, and its subtrees with their counts."""

    text: str
    node_count: int
    subtree_counts: tuple[tuple[str, int], ...]


@dataclass(frozen=True)
class StudentAnswer:
    """A student's wrong answer to a part. `expected` is the text of the expected answer."""

    student: str
    answer: str
    canonical_form: CanonicalForm
    expected: str


@dataclass(frozen=True)
class SimilarPair:
    """Two students' answers that are nearly the same although the expected answers differ."""

    first: StudentAnswer
    second: StudentAnswer
    similarity: float


def make_canonical_form(parsed_answer: ParsedAnswer) -> CanonicalForm | None:
    """Return an answer in a standard order; None if it can't be parsed, has a blank, or is too long."""
    if parsed_answer.tree is None or len(parsed_answer.text) > MAX_LENGTH:
        return None
    return _make_cached_form(parsed_answer.tree)


@lru_cache(maxsize=4096)
def _make_cached_form(tree: Node) -> CanonicalForm | None:
    subtree_counts = Counter[str]()
    try:
        if has_blank(tree) or count_nodes(tree) > MAX_NODES:
            return None
        text = _write_sorted(_flatten(tree), subtree_counts)
        return CanonicalForm(text, count_nodes(tree), tuple(sorted(subtree_counts.items())))
    except RecursionError:  # nested too deeply to be a formula that a student wrote
        return None


def _flatten(node: Node) -> Node:
    """Flatten nested sums and products of a tree, and multiply its numeric factors together.

    a − b becomes a + (−1)·b, and a/2 becomes (1/2)·a, so the position of a sign or a fraction makes no difference.
    """
    args = tuple(map(_flatten, node.args))
    if node.kind == "neg":
        return _multiply((_MINUS_ONE, *args))
    if node.kind == "-" and len(args) == 2:
        args, node = (args[0], _multiply((_MINUS_ONE, args[1]))), Node("+")
    if node.kind == "/" and args[1].kind in _NUMBER_KINDS and args[1].value:
        return _multiply((args[0], Node("number", value=1 / args[1].value)))
    if node.kind == "*":
        return _multiply(args)
    if node.kind == "+":
        args = tuple(term for arg in args for term in (arg.args if arg.kind == "+" else (arg,)))
    if node.kind == "list" and len(args) == 1 and args[0].kind == "list":
        return args[0]
    return Node("number" if node.kind in _NUMBER_KINDS else node.kind, args, node.value)


_NUMBER_KINDS = ("number", "decimal")
_MINUS_ONE = Node("number", value=Fraction(-1))


def _multiply(args: tuple[Node, ...]) -> Node:
    """Return the product of flattened factors, with all numeric factors multiplied together and placed first."""
    factors = [factor for arg in args for factor in (arg.args if arg.kind == "*" else (arg,))]
    other_factors = [factor for factor in factors if factor.kind not in _NUMBER_KINDS]
    numeric_factor = math.prod((factor.value for factor in factors if factor.kind in _NUMBER_KINDS), start=Fraction(1))
    if numeric_factor != 1 or not other_factors:
        other_factors.insert(0, Node("number", value=numeric_factor))
    return other_factors[0] if len(other_factors) == 1 else Node("*", tuple(other_factors))


def _write_sorted(node: Node, subtree_counts: Counter[str]) -> str:
    """Return the text of a tree in a standard order, and count each of its subtrees in `subtree_counts`."""
    argument_texts = [_write_sorted(arg, subtree_counts) for arg in node.args]
    if node.kind in _COMMUTATIVE_KINDS:
        argument_texts.sort()
    head = str(node.value) if node.value is not None else node.kind
    text = f"{head}({' '.join(argument_texts)})" if argument_texts else head
    subtree_counts[text] += 1
    return text


def compute_similarity(first: CanonicalForm, second: CanonicalForm) -> float:
    """Return the share of common subtrees, from 0 to 1; 1 if only the order of terms and factors differs."""
    if first.text == second.text:
        return 1.0
    first_counts, second_counts = Counter(dict(first.subtree_counts)), Counter(dict(second.subtree_counts))
    return (first_counts & second_counts).total() / max(1, (first_counts | second_counts).total())


def find_similar_pairs(answers: Sequence[StudentAnswer], max_common_count: int) -> list[SimilarPair]:
    """Return pairs of nearly the same answers whose expected answers differ, the most similar pairs first.

    Short answers are ignored. An answer that more than `max_common_count` students wrote is a common mistake and is
    ignored, too.
    """
    long_answers = [answer for answer in answers if answer.canonical_form.node_count >= MIN_NODES]
    text_counts = Counter(answer.canonical_form.text for answer in long_answers)
    rare_answers = [answer for answer in long_answers if text_counts[answer.canonical_form.text] <= max_common_count]
    compares_all_pairs = len(rare_answers) <= MAX_PAIRED_ANSWERS
    pairs = [
        SimilarPair(first, second, compute_similarity(first.canonical_form, second.canonical_form))
        for first, second in combinations(rare_answers, 2)
        if first.expected != second.expected
        and (compares_all_pairs or first.canonical_form.text == second.canonical_form.text)
    ]
    return sorted((pair for pair in pairs if pair.similarity >= MIN_SIMILARITY), key=lambda pair: -pair.similarity)
