"""Judge one parsed answer against a reference: expressions, matrices, numbers, directions, singular sets."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from qdot.exercises.formula.algebra import ZERO, Matrix
from qdot.exercises.formula.algebra import number as number_node
from qdot.exercises.formula.conditions import ROUNDED, SetComparison, Space, compare_sets
from qdot.exercises.formula.identity import (
    Certificate,
    Comparison,
    Domain,
    EntryDifference,
    Rounding,
    SetDifference,
    chance_of_missing,
    compare_entries,
    number,
    tell_apart,
)
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.set_parser import Atom, Piece, parse_claims, parse_pieces
from qdot.exercises.formula.trees import Node, ReadError, names
from qdot.exercises.formula.vocabulary import VOCABULARY
from qdot.exercises.problem.credit import count_false_conditions, count_spoiled_zeros, share_of_entries, share_of_set
from qdot.grader.judging.answer import OR, ParsedAnswer, combine_with_and, with_joint
from qdot.grader.judging.verdict import (
    Judgement,
    Outcome,
    at_words,
    correct,
    entry_name,
    missing,
    number_words,
    partial,
    pose_words,
    values_words,
    wrong,
)

IMAGINARY = 1e-12
"""An imaginary part below this fraction of a number is a rounding error."""


def judge_expression(
    parsed: ParsedAnswer, reference: Node, domain: Domain, seed: str, rounding: Rounding | None = None
) -> Judgement:
    """Judge a formula; `rounding` is the error that is allowed for decimals in it."""
    if parsed.refusal is not None:
        return parsed.refusal
    comparison = compare_entries(parsed.entries, [reference], domain, seed, rounding)
    if all(comparison.equal):
        return correct(comparison.certificate)
    return wrong(unknown_symbols(parsed, domain) or _difference(comparison, 1), comparison.certificate)


def judge_matrix(
    parsed: ParsedAnswer, reference: Matrix, domain: Domain, seed: str, rounding: Rounding | None = None
) -> Judgement:
    """Judge a matrix or vector entry by entry.

    The share is the number of correct nonzero entries, minus the number of wrong entries that should be zero, divided
    by the number of nonzero entries in the reference. So a matrix of zeros earns nothing.
    """
    if parsed.refusal is not None:
        return parsed.refusal
    expected = [entry for row in reference for entry in row]
    blanks = parsed.blanks
    filled_entries = [
        expected_entry if blank else entry
        for blank, entry, expected_entry in zip(blanks, parsed.entries, expected, strict=True)
    ]
    comparison = compare_entries(filled_entries, expected, domain, seed, rounding)
    return matrix_judgement(comparison, blanks, reference, unknown_symbols(parsed, domain))


def matrix_judgement(comparison: Comparison, blanks: Sequence[bool], reference: Matrix, unknown: str = "") -> Judgement:
    """Return the judgement on a matrix whose entries were compared; `unknown` is a message about unknown symbols."""
    columns = len(reference[0])
    is_correct = [same and not blank for same, blank in zip(comparison.equal, blanks, strict=True)]
    is_zero = [entry.kind == "number" and not entry.value for row in reference for entry in row]
    if all(is_correct):
        judgement = correct(comparison.certificate)
    else:
        reason = unknown or _difference(comparison, columns) or "the others were left blank"
        if not unknown or any(is_correct):
            reason = f"{_count(is_correct, blanks, is_zero)}; {reason}"
        judgement = partial(float(share_of_entries(is_correct, is_zero, blanks)), reason, comparison.certificate)
    marks = tuple(tuple(is_correct[i : i + columns]) for i in range(0, len(is_correct), columns))
    return replace(judgement, entries=marks)


def _count(equal: Sequence[bool], blanks: Sequence[bool], is_zero: Sequence[bool], what: str = "entries") -> str:
    """Return a phrase with the number of correct entries; entries that are zero in the reference don't count."""
    zeros = list(is_zero) if not all(is_zero) else [False] * len(is_zero)
    correct_count = sum(same and not zero for same, zero in zip(equal, zeros, strict=True))
    total = len(zeros) - sum(zeros)
    description = f"{total} {what} that are not zero" if any(zeros) else f"{total} {what}"
    spoiled_count = count_spoiled_zeros(equal, zeros, blanks)
    spoiled_words = (
        f", and {spoiled_count} that should be zero {'is' if spoiled_count == 1 else 'are'} not"
        if spoiled_count
        else ""
    )
    return (
        f"{correct_count} of {description} are right{spoiled_words}"
        if total > 1 or spoiled_count
        else "it is not right"
    )


def _difference(comparison: Comparison, columns: int) -> str:
    """Return a phrase on the first entry that differs, with both values; "" if no answered entry differs."""
    example = comparison.certificate.counterexample
    if not isinstance(example, EntryDifference):
        return ""
    where = entry_name(example.entry, columns) + " " if len(comparison.equal) > 1 else ""
    return f"{where}differs{at_words(example.at)}{values_words(example)}"


def unknown_symbols(parsed: ParsedAnswer, domain: Domain) -> str:
    """Return a message about symbols in the answer that the problem doesn't define; "" if there are none."""
    unknown = parsed.symbols - set(domain.roles)
    if not unknown:
        return ""
    if unknown <= set(VOCABULARY["units"]):
        return f"leave out the unit {min(unknown)}: lengths are in metres, angles in radians"
    unknown_names = ", ".join(repr(name) for name in sorted(unknown)[:5])
    known_names = ", ".join(sorted(domain.roles))
    return f"{unknown_names} {'is' if len(unknown) == 1 else 'are'} no symbol of this problem; known: {known_names}"


def judge_numbers(
    parsed: ParsedAnswer, reference: Sequence[float], units: Sequence[str], tolerance: float, floor: float
) -> Judgement:
    """Judge numbers, each correct within a relative tolerance (or the absolute floor, for values near zero).

    The share is computed as for a vector: numbers that are zero earn nothing.
    """
    if parsed.refusal is not None:
        return parsed.refusal
    blanks = parsed.blanks
    filled_entries = [
        Node("name", value="E") if blank else entry for blank, entry in zip(blanks, parsed.entries, strict=True)
    ]
    values = evaluate(compile_program(filled_entries), {}, 1)[0][:, 0]
    is_correct = [
        bool(np.isfinite(value) and abs(value - expected) <= max(tolerance * abs(expected), floor) and not blank)
        for value, expected, blank in zip(values, reference, blanks, strict=True)
    ]
    if all(is_correct):
        judgement = correct(Certificate("numeric", 1, 0.0), f"right to {100 * tolerance:g} %")
    else:
        first_wrong, zeros = is_correct.index(False), [abs(expected_value) <= floor for expected_value in reference]
        yours = "blank" if blanks[first_wrong] else number(complex(values[first_wrong]))
        example = EntryDifference(first_wrong, {}, yours, float(f"{reference[first_wrong]:.4g}"))
        difference = " was left blank" if blanks[first_wrong] else number_words(example, units[first_wrong])
        reason = f"{_count(is_correct, blanks, zeros, 'numbers')}; number {first_wrong + 1}{difference}"
        share = share_of_entries(is_correct, zeros, blanks)
        judgement = partial(float(share), reason, Certificate("numeric", 1, 0.0, example))
    return replace(judgement, entries=tuple((same,) for same in is_correct))


def judge_direction(
    parsed: ParsedAnswer, reference: Sequence[Node], domain: Domain, seed: str, tolerance: float | None = None
) -> Judgement:
    """Judge a vector, which is correct if it is the reference times any nonzero factor.

    Without `tolerance`, both vectors are formulas, which must be equal up to the factor at every configuration. With
    it, both are numeric, and `tolerance` is the largest allowed norm of the difference of the unit vectors.
    """
    if parsed.refusal is not None:
        return parsed.refusal
    if any(parsed.blanks):
        return missing("a part of the vector was left blank")
    if tolerance:
        return _judge_numeric_direction(parsed, reference, tolerance)
    return _judge_symbolic_direction(parsed, reference, domain, seed)


def _judge_symbolic_direction(parsed: ParsedAnswer, reference: Sequence[Node], domain: Domain, seed: str) -> Judgement:
    """Judge a symbolic direction by comparing entry_i r_k with r_i entry_k, where reference entry r_k is not zero."""
    entries, zeros = parsed.entries, [ZERO] * len(reference)
    pivot = compare_entries(reference, zeros, domain, f"{seed}/pivot").equal.index(False)
    if all(compare_entries(entries, zeros, domain, f"{seed}/zero").equal):
        return wrong("the zero vector is no direction")
    student_products = [Node("*", (entry, reference[pivot])) for entry in entries]
    reference_products = [Node("*", (entry, entries[pivot])) for entry in reference]
    comparison = compare_entries(student_products, reference_products, domain, seed)
    if all(comparison.equal):
        return correct(comparison.certificate)
    certificate = _certificate_for_pivot(comparison.certificate, reference[pivot], entries[pivot], pivot)
    example = certificate.counterexample
    entry, at = comparison.equal.index(False), ""
    if isinstance(example, EntryDifference):
        entry, at = example.entry, at_words(example.at)
    problem = "should be 0" if entry == pivot else f"does not have the right ratio to entry {pivot + 1}"
    reason = f"not along the direction that is right: entry {entry + 1} {problem}{at}"
    return wrong(unknown_symbols(parsed, domain) or reason, certificate)


def _certificate_for_pivot(certificate: Certificate, expected: Node, answered: Node, pivot: int) -> Certificate:
    """Return the certificate with the student's entry, and with the value that fits the student's pivot.

    The comparison multiplied both values by the `expected` pivot. If this pivot is zero at the counterexample, the
    student's pivot is not, so the counterexample shows the pivot instead.
    """
    example = certificate.counterexample
    if not isinstance(example, EntryDifference):
        return certificate
    if not isinstance(example.yours, float) or not isinstance(example.expected, float):
        return certificate
    at = {name: np.array([value]) for name, value in example.at.items()}
    scale, value = (complex(pivots[0]) for pivots in evaluate(compile_program([expected, answered]), at, 1)[0])
    if not scale:  # e.g. -sin(theta1) at theta1 = 0; readable sample values may be 0
        return replace(certificate, counterexample=EntryDifference(pivot, example.at, number(value), 0.0))
    values = tell_apart(example.yours / scale, example.expected / scale)
    return replace(certificate, counterexample=EntryDifference(example.entry, example.at, *values, pivot))


def _judge_numeric_direction(parsed: ParsedAnswer, reference: Sequence[Node], tolerance: float) -> Judgement:
    if parsed.symbols:
        return wrong(f"numbers are due, and {', '.join(sorted(parsed.symbols)[:5])} is left in the answer")
    given, expected = (evaluate(compile_program(list(nodes)), {}, 1)[0][:, 0] for nodes in (parsed.entries, reference))
    if not np.all(np.isfinite(given)) or np.any(np.abs(given.imag) > IMAGINARY * np.abs(given)):
        return wrong("an entry of the vector is not a finite real number")
    norm = float(np.linalg.norm(given.real))
    if norm == 0.0:
        return wrong("the zero vector is no direction")
    unit_vector, target = given.real / norm, expected.real / np.linalg.norm(expected.real)
    target = target * (1.0 if float(unit_vector @ target) >= 0 else -1.0)
    distance = float(np.linalg.norm(unit_vector - target))
    if distance <= tolerance:
        return correct(Certificate("numeric", 1, 0.0))
    entry = int(np.abs(unit_vector - target).argmax())
    example = EntryDifference(entry, {}, float(f"{unit_vector[entry]:.6g}"), float(f"{target[entry]:.4g}"))
    reason = f"not along the direction that is right: scaled to length 1, entry {entry + 1}{number_words(example)}"
    return wrong(reason, Certificate("numeric", 1, 0.0, example))


def judge_singular(
    parsed: ParsedAnswer,
    reference: Sequence[Sequence[Node]],
    joints: Sequence[str],
    domain: Domain,
    seed: str,
    rounding: Rounding | None = None,
) -> Judgement:
    """Judge a set of singular configurations by the configurations that it contains.

    For each condition, the reference contains a list of its values, or the condition itself. The share depends on how
    many conditions are found completely or in part, and on how many claimed conditions are not singular
    (`share_of_set`).
    """
    if parsed.refusal is not None or parsed.tree is None:
        return parsed.refusal or missing()
    reference_pieces = [
        [piece for tree in condition for piece in parse_pieces(tree, joints)] for condition in reference
    ]
    space = Space(joints, domain, rounding)
    try:
        judgement = _judge_set(parse_claims(with_joint(parsed.tree, joints), joints), reference_pieces, space, seed)
    except ReadError as error:
        return wrong(f"this can't be read as conditions: {error}")
    if judgement.outcome is Outcome.CORRECT or (joined_tree := combine_with_and(parsed.tree, joints)) is None:
        return judgement
    try:
        is_better = _judge_set(parse_claims(joined_tree, joints), reference_pieces, space, seed).share > judgement.share
    except ReadError:  # the combined conditions have too many cases
        return judgement
    return replace(judgement, reason=f"{OR}; {judgement.reason}") if is_better else judgement


def judge_angles(parsed: ParsedAnswer, reference: Node, domain: Domain, seed: str) -> Judgement:
    """Judge a set of angles, modulo 2 pi."""
    if parsed.refusal is not None or parsed.tree is None:
        return parsed.refusal or missing()
    joint, angle_domain = Node("name", value="angle"), Domain({**domain.roles, "angle": "angle"})
    reference_pieces = [parse_pieces(Node("in", (joint, reference)), ["angle"])]
    try:
        claimed_pieces = parse_claims(Node("in", (joint, parsed.tree)), ["angle"])
        return _judge_set(claimed_pieces, reference_pieces, Space(["angle"], angle_domain), seed, "angle")
    except ReadError as error:
        return wrong(f"this can't be read as a set of angles: {error}")


def _judge_set(
    claimed: Sequence[Piece],
    conditions: Sequence[Sequence[Piece]],
    space: Space,
    seed: str,
    what: str = "singular configuration",
) -> Judgement:
    reference_pieces = [piece for condition in conditions for piece in condition]
    comparison = compare_sets(claimed, reference_pieces, space, seed)
    if comparison.equal and claimed:
        return correct(_set_certificate(comparison))
    tolerant_space = Space(space.joints, space.domain, ROUNDED) if comparison.rounded else space
    tolerant_comparison = (
        compare_sets(claimed, reference_pieces, tolerant_space, seed) if comparison.rounded else comparison
    )
    # A piece that is not singular everywhere may cover part of the reference; only sound pieces count for the share.
    sound = [piece for piece, held in zip(claimed, tolerant_comparison.sound, strict=True) if held]
    matches = _count_matched(compare_sets(sound, reference_pieces, tolerant_space, seed).covered, conditions)
    claims = [(_joints_of(piece, space), held) for piece, held in zip(claimed, tolerant_comparison.sound, strict=True)]
    true_joints = {joints for joints, held in claims if held}
    unsound = count_false_conditions([joints for joints, held in claims if held is False], true_joints)
    share = share_of_set(matches, unsound, is_rounded=comparison.rounded)
    reason = _set_reason(tolerant_comparison, space.joints, what)
    if comparison.rounded:
        rounded_pieces = [
            piece for piece, held in zip(claimed, comparison.sound, strict=True) if not held and piece in sound
        ]
        at = compare_sets(rounded_pieces, reference_pieces, space, seed).surplus or {}
        reason = f"right but for rounding{pose_words(at, space.joints)}; write {_EXACTLY}" + (reason and f"; {reason}")
    if tolerant_comparison.surplus is not None and _are_degrees(claimed, reference_pieces, space, seed):
        reason = f"these values are in degrees, and radians are due; {reason}"
    words = f"{_matched_words(matches, unsound)}; " if share else ""
    return partial(float(share), words + (reason or "no configuration is claimed"), _set_certificate(comparison))


_EXACTLY = "the exact value, as in pi/3 or acos(1/3)"


def _joints_of(piece: Piece, space: Space) -> frozenset[str]:
    """Return the joints that a piece restricts."""
    return frozenset(space.joints) & {name for atom in piece for name in (*names(atom.zero), atom.joint)}


def _count_matched(covered: Sequence[bool | None], conditions: Sequence[Sequence[Piece]]) -> list[tuple[int, int]]:
    """Return for each condition the number of pieces that are covered, and the number of nonempty pieces."""
    remaining = iter(covered)
    groups = ([held for held in islice(remaining, len(condition)) if held is not None] for condition in conditions)
    return [(sum(group), len(group)) for group in groups if group]


def _matched_words(matched: Sequence[tuple[int, int]], unsound: int) -> str:
    """Return a phrase that counts the conditions found completely, those found in part, and the false ones."""
    complete_count, partial_count = (
        sum(found_count == expected_count for found_count, expected_count in matched),
        sum(0 < found_count < expected_count for found_count, expected_count in matched),
    )
    conditions = (
        f"{len(matched)} conditions {'is' if complete_count == 1 else 'are'}" if len(matched) > 1 else "1 condition is"
    )
    partial_words = f", {partial_count} in part" if partial_count else ""
    does_words = "does" if unsound == 1 else "do"
    false_words = f", {unsound} of the claimed conditions {does_words} not hold" if unsound else ""
    return f"{complete_count} of {conditions} found{partial_words}{false_words}"


def by_joints(reference: Sequence[Node], joints: Sequence[str]) -> list[list[Node]]:
    """Return conditions grouped by the joints that they contain, because the correct grouping is unknown."""
    groups: dict[frozenset[str], list[Node]] = {}
    for tree in reference:
        groups.setdefault(frozenset(names(tree) & set(joints)), []).append(tree)
    return list(groups.values())


def _are_degrees(claimed: Sequence[Piece], truth: Sequence[Piece], space: Space, seed: str) -> bool:
    """Return whether all joint values would be correct after conversion from degrees to radians."""
    if any(atom.joint is None for piece in claimed for atom in piece):
        return False
    degree = Node("/", (Node("name", value="pi"), number_node(180)))
    converted = [tuple(Atom(Node("*", (atom.zero, degree)), atom.joint) for atom in piece) for piece in claimed]
    return False not in compare_sets(converted, truth, space, seed).sound


def _set_certificate(comparison: SetComparison) -> Certificate:
    example = None if comparison.equal else SetDifference(comparison.missing, comparison.surplus)
    return Certificate("numeric", comparison.least, chance_of_missing(comparison.least), example)


def _set_reason(comparison: SetComparison, joints: Sequence[str], what: str) -> str:
    reasons = []
    if comparison.missing is not None:
        article = "an" if what[0] in "aeiou" else "a"
        reasons.append(f"{article} {what} is missing{pose_words(comparison.missing, joints)}")
    if comparison.surplus is not None:
        reasons.append(f"claimed, but no {what}{pose_words(comparison.surplus, joints)}")
    return "; ".join(reasons)
