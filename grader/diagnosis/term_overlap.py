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
from qdot.exercises.formula.algebra import ONE, addends, call, minus, negative, over, plus, terms_of, times
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node, names, size_of
from qdot.exercises.mistakes.configurations import Values, sample_values
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


def has_terms(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> bool:
    """Tell whether enough of the solution's terms stand in an answer for it to be an attempt at this arm."""
    return share_of_terms(problem, part, parsed_answer, seed) >= LEAST


def share_of_terms(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> Fraction:
    """Return the share of the solution's terms that stand in an answer, each in the entry where it belongs.

    Where the answer has more terms, it is the share of these that are the solution's.
    """
    domain, rows = problem.domain(), parsed_answer.rows
    if not part.answer.is_formulas or parsed_answer.refusal is not None or rows is None:
        return Fraction(0)
    reference = part.answer.trees(domain.roles)
    if list(map(len, rows)) != list(map(len, reference)) or sum(map(size_of, parsed_answer.entries)) > LONGEST:
        return Fraction(0)
    if any(parsed_answer.blanks) or parsed_answer.symbols - set(domain.roles):
        return Fraction(0)
    pairs = [pair for both in zip(rows, reference, strict=True) for pair in zip(*both, strict=True)]
    apart = [(_take_apart(entry), _take_apart(right)) for entry, right in pairs]
    values = sample_values(domain, POINTS, Stream(f"{seed}/terms"))
    return max(_share(each, set(domain.roles) - problem.constants, values) for each in (pairs, apart))


def _share(pairs: Sequence[tuple[Node, Node]], varying: AbstractSet[str], values: Values) -> Fraction:
    """Return the share of terms in common in entries and those of the reference."""
    common = expected = typed = 0
    for entry, right in pairs:
        wanted = [term for term in terms_of(right, MOST) or [right] if names(term) & varying]
        terms = terms_of(entry, MOST) or [entry]
        expected += len(wanted)
        typed += sum(bool(names(term) & varying) for term in terms)
        common += _count_common(terms, wanted, values)
    return Fraction(common, max(expected, typed)) if expected else Fraction(0)


def _count_common(terms: Sequence[Node], wanted: Sequence[Node], values: Values) -> int:
    """Return how many terms are wanted, with either sign, each being one of these only."""
    if not wanted:
        return 0
    at_points = evaluate(compile_program([*terms, *wanted]), values, POINTS)[0]
    left, count = list(at_points[: len(terms)]), 0
    for term in at_points[len(terms) :]:
        room = SAME * float(np.abs(term).max())
        same = (k for k, each in enumerate(left) for sign in (1, -1) if np.all(np.abs(each - sign * term) <= room))
        if (k := next(same, None)) is not None:
            count += 1
            del left[k]
    return count


def _take_apart(node: Node) -> Node:
    """Return a tree with the sines and cosines of sums taken apart, and quotients as products."""
    if node.kind == "call" and node.value in ("sin", "cos"):
        return _expand_wave(str(node.value), addends(node.args[0]))
    args = tuple(map(_take_apart, node.args))
    if node.kind == "/":
        return times(args[0], over(ONE, args[1]))
    return Node(node.kind, args, node.value)


def _expand_wave(function: str, angles: Sequence[Node]) -> Node:
    """Return the sine or cosine of a sum as a sum of products."""
    first, *rest = angles
    back = first.kind == "neg"
    angle = first.args[0] if back else first
    sine, cosine = (negative(call("sin", angle)) if back else call("sin", angle)), call("cos", angle)
    if not rest:
        return sine if function == "sin" else cosine
    inner_sine, inner_cosine = _expand_wave("sin", rest), _expand_wave("cos", rest)
    if function == "sin":
        return plus(times(sine, inner_cosine), times(cosine, inner_sine))
    return minus(times(cosine, inner_cosine), times(sine, inner_sine))
