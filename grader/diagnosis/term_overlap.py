"""What of a solution stands in a wrong answer, by terms: whether it is an attempt at this arm.

Both are multiplied out, as they are written and with the sines and cosines of sums taken apart; a term is there that is
a term of the solution at random configurations, with either sign. Of an answer with more terms than the solution, the
share is that of its own terms: one that has everything in it is no attempt. Terms without joints or velocities count
nothing: constants stand in any text.
"""

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from fractions import Fraction

import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.algebra import ONE, Matrix, addends, call, minus, negative, over, plus, terms_of, times
from qdot.exercises.formula.identity import READABLE
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node, names, size_of
from qdot.exercises.problem.problem import Part, Problem
from qdot.grader.judging.answer import ParsedAnswer

LEAST = Fraction(1, 2)
"""The share of the solution's terms that an attempt has, if nothing else speaks for it."""
LONGEST = 3000
"""Nodes of an answer that is multiplied out."""
MOST = 300
"""Terms of an entry."""
POINTS = 6
SAME = 1e-9


def has_terms(problem: Problem, part: Part, given: ParsedAnswer, seed: str) -> bool:
    """Tell whether enough of the solution's terms stand in an answer for it to be an attempt at this arm."""
    return share_of_terms(problem, part, given, seed) >= LEAST


def share_of_terms(problem: Problem, part: Part, given: ParsedAnswer, seed: str) -> Fraction:
    """Return the share of the solution's terms that stand in an answer, each in the entry where it belongs.

    Where the answer has more terms, it is the share of these that are the solution's.
    """
    domain, rows = problem.domain(), given.rows
    if not part.answer.is_formulas or given.refusal is not None or rows is None:
        return Fraction(0)
    due = part.answer.trees(domain.roles)
    if [len(row) for row in rows] != [len(row) for row in due] or sum(map(size_of, given.entries)) > LONGEST:
        return Fraction(0)
    if any(given.blanks) or given.symbols - set(domain.roles):
        return Fraction(0)
    sampled = domain.sample(set(domain.roles), READABLE + POINTS, Stream(f"{seed}/terms"))
    values = {name: column[READABLE:] for name, column in sampled.items()}
    varying = set(domain.roles) - problem.constants
    taken_apart = [[[_apart(entry) for entry in row] for row in matrix] for matrix in (rows, due)]
    return max(_share(own, right, varying, values) for own, right in ((rows, due), taken_apart))


def _share(rows: Matrix, due: Matrix, varying: AbstractSet[str], values: dict[str, np.ndarray]) -> Fraction:
    there = total = mine = 0
    for own, right in zip((e for row in rows for e in row), (e for row in due for e in row), strict=True):
        wanted = [term for term in terms_of(right, MOST) or [right] if names(term) & varying]
        given = terms_of(own, MOST) or [own]
        total += len(wanted)
        mine += sum(bool(names(term) & varying) for term in given)
        there += _found(given, wanted, values)
    return Fraction(there, max(total, mine)) if total else Fraction(0)


def _found(own: Sequence[Node], wanted: Sequence[Node], values: dict[str, np.ndarray]) -> int:
    """Return how many terms are there, each of the student's being one of them only."""
    if not wanted:
        return 0
    at_points = evaluate(compile_program([*own, *wanted]), values, POINTS)[0]
    mine, ours = list(at_points[: len(own)]), at_points[len(own) :]
    there = 0
    for term in ours:
        room = SAME * float(np.abs(term).max())
        for k, each in enumerate(mine):
            if any(np.all(np.abs(each - sign * term) <= room) for sign in (1, -1)):
                there += 1
                del mine[k]
                break
    return there


def _apart(node: Node) -> Node:
    """Return a tree with the sines and cosines of sums taken apart, and quotients as products."""
    if node.kind == "call" and node.value in ("sin", "cos"):
        return _wave(str(node.value), addends(node.args[0]))
    args = tuple(map(_apart, node.args))
    if node.kind == "/":
        return times(args[0], over(ONE, args[1]))
    return Node(node.kind, args, node.value)


def _wave(function: str, angles: Sequence[Node]) -> Node:
    """Return the sine or cosine of a sum as a sum of products."""
    first, *rest = angles
    back = first.kind == "neg"
    angle = first.args[0] if back else first
    sine, cosine = (negative(call("sin", angle)) if back else call("sin", angle)), call("cos", angle)
    if not rest:
        return sine if function == "sin" else cosine
    inner_sine, inner_cosine = _wave("sin", rest), _wave("cos", rest)
    if function == "sin":
        return plus(times(sine, inner_cosine), times(cosine, inner_sine))
    return minus(times(cosine, inner_cosine), times(sine, inner_sine))
