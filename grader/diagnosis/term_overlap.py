"""Decide whether a wrong answer is an attempt at this arm, by the share of the solution's terms in the answer.

Answer and solution are expanded into terms, both as written and after angle-sum identities are applied. A term of the
solution is found if it equals a term of the answer, up to its sign, at random configurations. If the answer has more
terms than the solution, the share is relative to the answer's terms, so a list of all possible terms is no attempt.
Terms without joints or velocities don't count, because any text may contain constants.
"""

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from fractions import Fraction

import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula import algebra
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import ONE, Node, count_nodes, find_names
from qdot.exercises.mistakes.configurations import SymbolValues, sample_values
from qdot.exercises.problem.problem import Part, Problem
from qdot.grader.diagnosis.numbers import RELATIVE_TOLERANCE
from qdot.grader.judging.answer_parser import ParsedAnswer

MIN_SHARE = Fraction(1, 2)
"""Minimum share of the solution's terms that an answer must contain to be an attempt."""
MAX_NODES = 3000
"""Maximum number of nodes of an answer that is expanded."""
MAX_TERMS = 300
"""Maximum number of terms into which an entry is expanded; a longer entry counts as one term."""
SAMPLE_COUNT = 6
"""Number of random configurations at which terms are compared."""


def has_enough_terms(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> bool:
    """Return whether an answer contains enough of the solution's terms to be an attempt at this arm.

    Each term has to be in the correct entry.
    """
    domain, rows = problem.domain, parsed_answer.rows
    if not part.answer.is_symbolic or parsed_answer.refusal is not None or rows is None:
        return False
    reference = part.answer.parse_trees(domain.roles)
    has_expected_shape = list(map(len, rows)) == list(map(len, reference))
    if not has_expected_shape or sum(map(count_nodes, parsed_answer.entries)) > MAX_NODES:
        return False
    if any(parsed_answer.is_blank) or parsed_answer.symbols - set(domain.roles):
        return False
    row_pairs = zip(rows, reference, strict=True)
    pairs = [pair for row, expected_row in row_pairs for pair in zip(row, expected_row, strict=True)]
    expanded_pairs = [(_expand(entry), _expand(expected_entry)) for entry, expected_entry in pairs]
    values = sample_values(domain, SAMPLE_COUNT, Stream(f"{seed}/terms"))
    varying_names = set(domain.roles) - problem.constants
    shares = (_compute_share(entry_pairs, varying_names, values) for entry_pairs in (pairs, expanded_pairs))
    return any(share >= MIN_SHARE for share in shares)


def _compute_share(
    pairs: Sequence[tuple[Node, Node]], varying_names: AbstractSet[str], values: SymbolValues
) -> Fraction:
    """Return the share of terms that entries have in common with their references.

    `pairs` are pairs of an entry and its reference. Only terms with a name in `varying_names` count.
    """
    common_count = expected_count = typed_count = 0
    for entry, reference in pairs:
        reference_terms = algebra.expand_terms(reference, MAX_TERMS) or [reference]
        expected_terms = [term for term in reference_terms if find_names(term) & varying_names]
        terms = algebra.expand_terms(entry, MAX_TERMS) or [entry]
        expected_count += len(expected_terms)
        typed_count += sum(bool(find_names(term) & varying_names) for term in terms)
        common_count += _count_common_terms(terms, expected_terms, values)
    return Fraction(common_count, max(expected_count, typed_count)) if expected_count else Fraction(0)


def _count_common_terms(terms: Sequence[Node], expected_terms: Sequence[Node], values: SymbolValues) -> int:
    """Return how many expected terms equal one of the terms up to the sign; each term can be found only once."""
    if not expected_terms:
        return 0
    values_of_terms = evaluate(compile_program([*terms, *expected_terms]), values, SAMPLE_COUNT).values
    remaining_values, count = list(values_of_terms[: len(terms)]), 0
    for expected_values in values_of_terms[len(terms) :]:
        tolerance = RELATIVE_TOLERANCE * float(np.abs(expected_values).max())
        for k, term_values in enumerate(remaining_values):
            if any(np.all(np.abs(term_values - sign * expected_values) <= tolerance) for sign in (1, -1)):
                count += 1
                del remaining_values[k]
                break
    return count


def _expand(node: Node) -> Node:
    """Apply angle-sum identities to a tree, and write its quotients as products."""
    if node.kind == "call" and node.value in ("sin", "cos"):
        return _expand_trig(str(node.value), algebra.split_terms(node.args[0]))
    args = tuple(map(_expand, node.args))
    if node.kind == "/":
        return args[0] * (ONE / args[1])
    return Node(node.kind, args, node.value)


def _expand_trig(function: str, angles: Sequence[Node]) -> Node:
    """Return the sine or cosine of a sum of angles, expanded by the angle-sum identities."""
    first_angle, *other_angles = angles
    is_negative = first_angle.kind == "neg"
    angle = first_angle.args[0] if is_negative else first_angle
    sine, cosine = algebra.apply_function("sin", angle), algebra.apply_function("cos", angle)
    sine = -sine if is_negative else sine
    if not other_angles:
        return sine if function == "sin" else cosine
    inner_sine, inner_cosine = _expand_trig("sin", other_angles), _expand_trig("cos", other_angles)
    if function == "sin":
        return sine * inner_cosine + cosine * inner_sine
    return cosine * inner_cosine - sine * inner_sine
