"""Judge a vector that counts up to a factor: a lost direction of motion, a self-motion."""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from qdot.exercises.formula.identity import Certificate, Domain, EntryDifference, compare_entries, number, told_apart
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node
from qdot.grader.judging.answer import Given
from qdot.grader.judging.counterexample import at_words, number_words
from qdot.grader.judging.formulas import unknown_symbols
from qdot.grader.judging.verdict import Judgement, correct, missing, wrong

ZERO = 1e-12
"""An imaginary part below this share of a number is rounding."""


def judge_direction(
    given: Given, reference: Sequence[Node], domain: Domain, seed: str, tolerance: float | None = None
) -> Judgement:
    """Judge a vector: right where it is the reference times any factor other than zero.

    Without `tolerance` both are formulas, equal up to the factor at every configuration; with it they are numbers, and
    the unit vectors may differ by that much in length of their difference.
    """
    if given.refusal is not None:
        return given.refusal
    if any(given.blanks):
        return missing("a part of the vector was left blank")
    return _numeric(given, reference, tolerance) if tolerance else _symbolic(given, reference, domain, seed)


def _symbolic(given: Given, due: Sequence[Node], domain: Domain, seed: str) -> Judgement:
    """Compare entry i times due_k with due_i times entry k, k being an entry of the reference that is not zero."""
    entries, zeros = given.entries, [Node("number", value=Fraction(0))] * len(due)
    nonzero = [not same for same in compare_entries(due, zeros, domain, f"{seed}/pivot").equal]
    pivot = nonzero.index(True)
    if all(compare_entries(entries, zeros, domain, f"{seed}/zero").equal):
        return wrong("the zero vector is no direction")
    left = [Node("*", (entry, due[pivot])) for entry in entries]
    right = [Node("*", (entry, entries[pivot])) for entry in due]
    comparison = compare_entries(left, right, domain, seed)
    if all(comparison.equal):
        return correct(comparison.certificate)
    certificate = _for_own_pivot(comparison.certificate, due[pivot], entries[pivot], pivot)
    example = certificate.counterexample
    entry, at = comparison.equal.index(False), ""
    if isinstance(example, EntryDifference):
        entry, at = example.entry, at_words(example.at)
    off = "should be 0" if entry == pivot else f"does not have the right ratio to entry {pivot + 1}"
    reason = f"not along the direction that is right: entry {entry + 1} {off}{at}"
    return wrong(unknown_symbols(given, domain) or reason, certificate)


def _for_own_pivot(certificate: Certificate, due: Node, own: Node, pivot: int) -> Certificate:
    """Return the certificate with the entry itself, and what it would have to be for the pivot as it was answered.

    Compared were both times the pivot that is `due`. Where that vanishes, the student's own does not, and should.
    """
    example = certificate.counterexample
    if not isinstance(example, EntryDifference):
        return certificate
    if not isinstance(example.yours, float) or not isinstance(example.expected, float):
        return certificate
    at = {name: np.array([value]) for name, value in example.at.items()}
    scale, answered = (complex(value) for value in evaluate(compile_program([due, own]), at, 1)[0][:, 0])
    if not scale:  # as -sin(theta1) is at 0, which is among the readable configurations
        of_pivot = EntryDifference(pivot, example.at, number(answered), 0.0)
        return replace(certificate, counterexample=of_pivot)
    yours, expected = told_apart(example.yours / scale, example.expected / scale)
    return replace(certificate, counterexample=replace(example, yours=yours, expected=expected, pivot=pivot))


def _numeric(given: Given, due: Sequence[Node], tolerance: float) -> Judgement:
    if given.symbols:
        return wrong(f"numbers are due, and {', '.join(sorted(given.symbols)[:5])} is left in the answer")
    typed, right = (evaluate(compile_program(list(nodes)), {}, 1)[0][:, 0] for nodes in (given.entries, due))
    if not np.all(np.isfinite(typed)) or np.any(np.abs(typed.imag) > ZERO * np.abs(typed)):
        return wrong("an entry of the vector is not a finite real number")
    size = float(np.linalg.norm(typed.real))
    if size == 0.0:
        return wrong("the zero vector is no direction")
    unit, target = typed.real / size, right.real / np.linalg.norm(right.real)
    target = target * (1.0 if float(unit @ target) >= 0 else -1.0)
    apart = float(np.linalg.norm(unit - target))
    if apart <= tolerance:
        return correct(Certificate("numeric", 1, 0.0))
    entry = int(np.abs(unit - target).argmax())
    example = EntryDifference(entry, {}, float(f"{unit[entry]:.6g}"), float(f"{target[entry]:.4g}"))
    reason = f"not along the direction that is right: scaled to length 1, entry {entry + 1}{number_words(example)}"
    return wrong(reason, Certificate("numeric", 1, 0.0, example))
