"""The conditions that an answer claims, and whether it would take too long to look at all of them."""

from collections.abc import Sequence

from qdot.exercises.formula.noise import without_noise
from qdot.exercises.formula.pieces import WHOLE, WHOLE_NUMBERS, Piece, is_tied, pieces
from qdot.exercises.formula.program import compile_program
from qdot.exercises.formula.trees import Node, ReadError, names, size_of

_MOST_CASES, _MOST_WORK = 100_000, 6000
"""Nodes of the cases of all whole numbers together, and steps in which zeros are searched for: some seconds of each."""
_PIECE = 10
"""What a case takes beside its nodes, and a piece beside its steps."""


def claimed_pieces(node: Node, joints: Sequence[str]) -> list[Piece]:
    """Return the pieces of an answer. Raises ReadError also where it would take too long to look at all of them."""
    node = without_noise(node)
    if _nodes_of_cases(node) > _MOST_CASES:
        raise ReadError("the conditions are too long, or there are too many whole numbers in them")
    claimed, work = pieces(node, joints), 0
    for piece in claimed:
        took = _PIECE + sum(len(compile_program([atom.zero]).steps) for atom in piece)
        searched = any(atom.joint is None or is_tied(atom, piece, joints) for atom in piece)
        work += took if searched else took // 10  # a value needs no search
        if work > _MOST_WORK:
            raise ReadError(f"the conditions are too long, with their {len(claimed)} cases")
    return claimed


def _nodes_of_cases(node: Node) -> int:
    """Return how many nodes there are in all conditions, each as often as it has cases."""
    count, stack = 0, [node]
    while stack:
        top = stack.pop()
        inner = ("list", "set", "or")
        if top.kind in (*inner, "and", "dict", "pair", "in") or any(arg.kind in inner for arg in top.args):
            stack.extend(top.args)
        else:
            count += (_PIECE + size_of(top)) * len(WHOLE) ** len(names(top) & set(WHOLE_NUMBERS))
    return count
