"""Judge one answer, as it was read, against a reference: expressions, matrices, singular sets, numbers."""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from exercises.formula.algebra import Matrix
from exercises.formula.claims import claimed_pieces
from exercises.formula.conditions import SetComparison, Space, compare_sets
from exercises.formula.identity import Certificate, Comparison, Domain, Rounding, compare_entries, missed, number
from exercises.formula.pieces import Atom, Piece, pieces
from exercises.formula.program import compile_program, evaluate
from exercises.formula.trees import Node, ReadError
from grader.answer import Given, with_joint
from grader.counterexample import at_words, entry_name, number_words, pose_words, values_words
from grader.verdict import Judgement, correct, graded, missing, wrong


def judge_expression(
    given: Given, reference: Node, domain: Domain, seed: str, rounding: Rounding | None = None
) -> Judgement:
    """Judge a formula; `rounding` is what its decimals may be off."""
    if given.refusal is not None:
        return given.refusal
    comparison = compare_entries(given.entries, [reference], domain, seed, rounding)
    if all(comparison.equal):
        return correct(comparison.certificate)
    return wrong(unknown_symbols(given, domain) or _difference(comparison, 1), comparison.certificate)


def judge_matrix(
    given: Given, reference: Matrix, domain: Domain, seed: str, rounding: Rounding | None = None
) -> Judgement:
    """Judge a matrix or vector by entry.

    The share is that of the right entries among those that are not zero in the reference, less the zeros that were
    answered with something else: a matrix of zeros earns nothing.
    """
    if given.refusal is not None:
        return given.refusal
    due = [entry for row in reference for entry in row]
    blanks = given.blanks
    filled = [right if blank else own for blank, own, right in zip(blanks, given.entries, due, strict=True)]
    comparison = compare_entries(filled, due, domain, seed, rounding)
    return matrix_judgement(comparison, blanks, reference, unknown_symbols(given, domain))


def matrix_judgement(comparison: Comparison, blanks: Sequence[bool], reference: Matrix, unknown: str = "") -> Judgement:
    """Return the judgement on a matrix whose entries were compared; `unknown` tells of symbols that no one knows."""
    columns = len(reference[0])
    equal = [same and not blank for same, blank in zip(comparison.equal, blanks, strict=True)]
    is_zero = [entry.kind == "number" and not entry.value for row in reference for entry in row]
    if all(equal):
        judged = correct(comparison.certificate)
    else:
        said = unknown or _difference(comparison, columns) or "the others were left blank"
        reason = f"{_count(equal, blanks, is_zero)}; {said}"
        judged = graded(_share(equal, blanks, is_zero), reason, comparison.certificate)
    marks = tuple(tuple(equal[i : i + columns]) for i in range(0, len(equal), columns))
    return replace(judged, entries=marks)


def _share(equal: Sequence[bool], blanks: Sequence[bool], is_zero: Sequence[bool]) -> float:
    zeros = list(is_zero) if not all(is_zero) else [False] * len(is_zero)
    counted = [same for same, zero in zip(equal, zeros, strict=True) if not zero]
    return min(max(0, sum(counted) - _spoiled(equal, blanks, zeros)) / len(counted), 0.99)


def _spoiled(equal: Sequence[bool], blanks: Sequence[bool], zeros: Sequence[bool]) -> int:
    return sum(zero and not same and not blank for same, blank, zero in zip(equal, blanks, zeros, strict=True))


def _count(equal: Sequence[bool], blanks: Sequence[bool], is_zero: Sequence[bool]) -> str:
    """Say how many entries are right as they are counted: those that are zero in the reference earn nothing."""
    zeros = list(is_zero) if not all(is_zero) else [False] * len(is_zero)
    right = sum(same and not zero for same, zero in zip(equal, zeros, strict=True))
    total = len(zeros) - sum(zeros)
    which = f"{total} entries that are not zero" if any(zeros) else f"{total} entries"
    spoiled = _spoiled(equal, blanks, zeros)
    also = f", and {spoiled} that should be zero {'is' if spoiled == 1 else 'are'} not" if spoiled else ""
    return f"{right} of {which} are right{also}" if total > 1 or spoiled else "it is not right"


def _difference(comparison: Comparison, columns: int) -> str:
    """Say where an entry differs, and by how much; nothing where none that was answered does."""
    example = comparison.certificate.counterexample
    if example is None:
        return ""
    total = len(comparison.equal)
    where = entry_name(int(example["entry"]), columns) + " " if total > 1 else ""
    return f"{where}differs{at_words(example['at'])}{values_words(example)}"


def unknown_symbols(given: Given, domain: Domain) -> str:
    """Return a sentence on symbols that the problem does not have; nothing where there are none."""
    used = given.symbols - set(domain.roles)
    if not used:
        return ""
    listed = ", ".join(repr(name) for name in sorted(used)[:5])
    known = ", ".join(sorted(domain.roles))
    return f"{listed} {'is' if len(used) == 1 else 'are'} no symbol of this problem; known: {known}"


def judge_numbers(
    given: Given, reference: Sequence[float], units: Sequence[str], tolerance: float, floor: float
) -> Judgement:
    """Judge numbers, each right within a relative tolerance (or the absolute floor, for values near zero)."""
    if given.refusal is not None:
        return given.refusal
    blanks = given.blanks
    filled = [Node("name", value="E") if blank else own for blank, own in zip(blanks, given.entries, strict=True)]
    values = evaluate(compile_program(filled), {}, 1)[0][:, 0]
    allowed = [max(tolerance * abs(due), floor) for due in reference]
    equal = [
        bool(np.isfinite(value) and abs(value - due) <= room and not blank)
        for value, due, room, blank in zip(values, reference, allowed, blanks, strict=True)
    ]
    marks = tuple((same,) for same in equal)
    if all(equal):
        return replace(correct(Certificate("numeric", 1, 0.0), f"right to {100 * tolerance:g} %"), entries=marks)
    first = equal.index(False)
    due, unit = reference[first], units[first]
    yours = "blank" if blanks[first] else number(complex(values[first]))
    example = {"entry": first, "at": {}, "yours": yours, "expected": float(f"{due:.4g}")}
    said = " was left blank" if blanks[first] else number_words(example, unit)
    reason = f"{sum(equal)} of {len(equal)} numbers are right; number {first + 1}{said}"
    judged = graded(sum(equal) / len(equal), reason, Certificate("numeric", 1, 0.0, example))
    return replace(judged, entries=marks)


def judge_singular(
    given: Given,
    reference: Sequence[Node],
    joints: Sequence[str],
    domain: Domain,
    seed: str,
    rounding: Rounding | None = None,
) -> Judgement:
    """Judge a set of singular configurations by what it contains.

    The share is that of the reference's pieces that are claimed, less one for each claimed piece that is not singular.
    """
    if given.refusal is not None or given.tree is None:
        return given.refusal or missing()
    truth = [piece for tree in reference for piece in pieces(tree, joints)]
    try:
        claimed = claimed_pieces(with_joint(given.tree, joints), joints)
        return _judge_set(claimed, truth, Space(joints, domain, rounding), seed)
    except ReadError as error:
        return wrong(f"this can't be read as conditions: {error}")


def judge_angles(given: Given, reference: Node, domain: Domain, seed: str) -> Judgement:
    """Judge a set of angles against another, modulo whole turns."""
    if given.refusal is not None or given.tree is None:
        return given.refusal or missing()
    joint, inner = Node("name", value="angle"), Domain({**domain.roles, "angle": "angle"})
    truth = pieces(Node("in", (joint, reference)), ["angle"])
    try:
        claimed = claimed_pieces(Node("in", (joint, given.tree)), ["angle"])
        return _judge_set(claimed, truth, Space(["angle"], inner), seed, "angle")
    except ReadError as error:
        return wrong(f"this can't be read as a set of angles: {error}")


def _judge_set(
    claimed: Sequence[Piece], truth: Sequence[Piece], space: Space, seed: str, what: str = "singular configuration"
) -> Judgement:
    comparison = compare_sets(claimed, truth, space, seed)
    if comparison.equal and claimed:
        return correct(_set_certificate(comparison))
    # What is claimed beyond the truth must not earn what it happens to cover: only sound pieces count for the share.
    sound = [piece for piece, held in zip(claimed, comparison.sound, strict=True) if held]
    covered = [held for held in compare_sets(sound, truth, space, seed).covered if held is not None]
    surplus = sum(held is False for held in comparison.sound)
    share = max(0, sum(covered) - surplus) / len(covered) if covered else 0.0
    reason = _set_reason(comparison, space.joints, what)
    if comparison.surplus is not None and _are_degrees(claimed, truth, space, seed):
        reason = f"these values are in degrees, and radians are due; {reason}"
    return graded(min(share, 0.99), reason, _set_certificate(comparison))


def _are_degrees(claimed: Sequence[Piece], truth: Sequence[Piece], space: Space, seed: str) -> bool:
    """Tell whether the values of all joints would be right if they were turned from degrees into radians."""
    if any(atom.joint is None for piece in claimed for atom in piece):
        return False
    degree = Node("/", (Node("name", value="pi"), Node("number", value=Fraction(180))))
    turned = [tuple(Atom(Node("*", (atom.zero, degree)), atom.joint) for atom in piece) for piece in claimed]
    return False not in compare_sets(turned, truth, space, seed).sound


def _set_certificate(comparison: SetComparison) -> Certificate:
    example = None if comparison.equal else {"missing": comparison.missing, "surplus": comparison.surplus}
    return Certificate("numeric", comparison.least, missed(comparison.least), example)


def _set_reason(comparison: SetComparison, joints: Sequence[str], what: str) -> str:
    said = []
    if comparison.missing is not None:
        article = "an" if what[0] in "aeiou" else "a"
        said.append(f"{article} {what} is missing{pose_words(comparison.missing, joints)}")
    if comparison.rounded and comparison.surplus is not None:
        pose = pose_words(comparison.surplus, joints)
        said.append(f"right but for rounding{pose}; write the exact value, as in pi/3 or acos(1/3)")
    elif comparison.surplus is not None:
        said.append(f"claimed, but no {what}{pose_words(comparison.surplus, joints)}")
    return "; ".join(said) or "no configuration is claimed"
