"""Decide whether a wrong answer is an attempt at this arm, by the share of the solution's terms that it contains.

Answer and solution are expanded into terms, both as written and after angle-sum identities are applied. A term is found
if it equals a term of the solution at random configurations, with either sign. If the answer has more terms than the
solution, the share is relative to the answer's terms, so that a list of all possible terms is no attempt. Terms without
joints or velocities don't count, because any text may contain constants.
"""

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from fractions import Fraction

import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.algebra import (
    ONE,
    add_nodes,
    apply_function,
    divide_nodes,
    expand_terms,
    multiply_nodes,
    negate,
    split_terms,
    subtract_nodes,
)
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node, count_nodes, find_names
from qdot.exercises.mistakes.configurations import SymbolValues, sample_values
from qdot.exercises.problem.problem import Part, Problem
from qdot.grader.judging.answer import ParsedAnswer

MIN_SHARE = Fraction(1, 2)
"""Minimum share of the solution's terms that an answer must contain to be an attempt."""
MAX_NODES = 3000
"""Maximum number of nodes of an answer that is expanded."""
MAX_TERMS = 300
"""Maximum number of terms of an entry."""
SAMPLE_COUNT = 6
RELATIVE_TOLERANCE = 1e-9


def has_enough_terms(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> bool:
    """Return whether an answer contains enough of the solution's terms to be an attempt at this arm."""
    return compute_term_share(problem, part, parsed_answer, seed) >= MIN_SHARE


def compute_term_share(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> Fraction:
    """Return the share of the solution's terms that an answer contains, each in the correct entry.

    If the answer has more terms than the solution, return the share of the answer's terms that are in the solution.
    """
    domain, rows = problem.domain, parsed_answer.rows
    if not part.answer.is_symbolic or parsed_answer.refusal is not None or rows is None:
        return Fraction(0)
    reference = part.answer.parse_trees(domain.roles)
    if list(map(len, rows)) != list(map(len, reference)) or sum(map(count_nodes, parsed_answer.entries)) > MAX_NODES:
        return Fraction(0)
    if any(parsed_answer.blanks) or parsed_answer.symbols - set(domain.roles):
        return Fraction(0)
    pairs = [pair for row_pair in zip(rows, reference, strict=True) for pair in zip(*row_pair, strict=True)]
    expanded_pairs = [(_expand(entry), _expand(expected_entry)) for entry, expected_entry in pairs]
    values = sample_values(domain, SAMPLE_COUNT, Stream(f"{seed}/terms"))
    return max(_share_of_pairs(form, set(domain.roles) - problem.constants, values) for form in (pairs, expanded_pairs))


def _share_of_pairs(pairs: Sequence[tuple[Node, Node]], varying: AbstractSet[str], values: SymbolValues) -> Fraction:
    """Return the share of terms that entries have in common with their references; `pairs` contains both."""
    common_count = expected_count = typed_count = 0
    for entry, reference in pairs:
        all_expected = expand_terms(reference, MAX_TERMS) or [reference]
        expected_terms = [term for term in all_expected if find_names(term) & varying]
        terms = expand_terms(entry, MAX_TERMS) or [entry]
        expected_count += len(expected_terms)
        typed_count += sum(bool(find_names(term) & varying) for term in terms)
        common_count += _count_common_terms(terms, expected_terms, values)
    return Fraction(common_count, max(expected_count, typed_count)) if expected_count else Fraction(0)


def _count_common_terms(terms: Sequence[Node], expected_terms: Sequence[Node], values: SymbolValues) -> int:
    """Return how many of the expected terms are found among the terms, with either sign; each is used only once."""
    if not expected_terms:
        return 0
    values_of_terms = evaluate(compile_program([*terms, *expected_terms]), values, SAMPLE_COUNT)[0]
    remaining_values, count = list(values_of_terms[: len(terms)]), 0
    for term in values_of_terms[len(terms) :]:
        tolerance = RELATIVE_TOLERANCE * float(np.abs(term).max())
        for k, candidate in enumerate(remaining_values):
            if any(np.all(np.abs(candidate - sign * term) <= tolerance) for sign in (1, -1)):
                count += 1
                del remaining_values[k]
                break
    return count


def _expand(node: Node) -> Node:
    """Apply angle-sum identities to a tree, and write its quotients as products."""
    if node.kind == "call" and node.value in ("sin", "cos"):
        return _expand_trig(str(node.value), split_terms(node.args[0]))
    args = tuple(map(_expand, node.args))
    if node.kind == "/":
        return multiply_nodes(args[0], divide_nodes(ONE, args[1]))
    return Node(node.kind, args, node.value)


def _expand_trig(function: str, angles: Sequence[Node]) -> Node:
    """Return the sine or cosine of a sum, expanded by the angle-sum identities."""
    first_angle, *other_angles = angles
    is_negative = first_angle.kind == "neg"
    angle = first_angle.args[0] if is_negative else first_angle
    sine = negate(apply_function("sin", angle)) if is_negative else apply_function("sin", angle)
    cosine = apply_function("cos", angle)
    if not other_angles:
        return sine if function == "sin" else cosine
    inner_sine, inner_cosine = _expand_trig("sin", other_angles), _expand_trig("cos", other_angles)
    if function == "sin":
        return add_nodes(multiply_nodes(sine, inner_cosine), multiply_nodes(cosine, inner_sine))
    return subtract_nodes(multiply_nodes(cosine, inner_cosine), multiply_nodes(sine, inner_sine))
