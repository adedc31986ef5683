"""Judge one parsed answer against a reference: expressions, matrices, numbers, directions, singular sets."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from qdot.exercises.formula.algebra import ZERO, Matrix
from qdot.exercises.formula.algebra import number as number_node
from qdot.exercises.formula.conditions import ROUNDED_JOINT_VALUE, ConfigurationSpace, SetComparison, compare_sets
from qdot.exercises.formula.equality import (
    Certificate,
    Comparison,
    Domain,
    EntryDifference,
    Rounding,
    SetDifference,
    chance_of_missing,
    compare_entries,
    show_difference,
    to_json_number,
)
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.set_parser import Atom, Piece, parse_pieces, parse_typed_set
from qdot.exercises.formula.trees import Node, ParseError, find_names
from qdot.exercises.formula.vocabulary import VOCABULARY
from qdot.exercises.problem.credit import count_false_conditions, count_spoiled_zeros, share_of_entries, share_of_set
from qdot.grader.judging.answer import (
    OR_HINT,
    ParsedAnswer,
    assign_values_to_joint,
    combine_with_and,
    describe_parse_error,
    describe_symbols_in_numbers,
    name_unknown_symbols,
)
from qdot.grader.judging.verdict import (
    Judgement,
    Outcome,
    correct_judgement,
    describe_configuration,
    describe_number,
    describe_point,
    describe_values,
    missing_judgement,
    name_entry,
    partial_judgement,
    wrong_judgement,
)

IMAGINARY_TOLERANCE = 1e-12
"""An imaginary part below this fraction of a number is a rounding error."""


def judge_expression(
    parsed: ParsedAnswer, reference: Node, domain: Domain, seed: str, rounding: Rounding | None = None
) -> Judgement:
    """Judge a formula; `rounding` is the error that is allowed for decimals in it."""
    if parsed.refusal is not None:
        return parsed.refusal
    comparison = compare_entries(parsed.entries, [reference], domain, seed, rounding)
    if all(comparison.is_correct):
        return correct_judgement(comparison.certificate)
    return wrong_judgement(
        describe_unknown_symbols(parsed, domain) or _describe_difference(comparison, 1), comparison.certificate
    )


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
    entries_with_reference = zip(parsed.entries, expected, blanks, strict=True)
    filled_entries = [reference_entry if blank else entry for entry, reference_entry, blank in entries_with_reference]
    comparison = compare_entries(filled_entries, expected, domain, seed, rounding)
    return judge_compared_matrix(comparison, blanks, reference, describe_unknown_symbols(parsed, domain))


def judge_compared_matrix(
    comparison: Comparison, blanks: Sequence[bool], reference: Matrix, unknown_symbols_message: str = ""
) -> Judgement:
    """Return the judgement on a matrix whose entries were compared with those of the reference solution.

    `unknown_symbols_message` says which symbols of the answer are unknown; it is empty if there are none.
    """
    columns = len(reference[0])
    is_correct = [is_equal and not blank for is_equal, blank in zip(comparison.is_correct, blanks, strict=True)]
    is_zero = [entry.kind == "number" and not entry.value for row in reference for entry in row]
    if all(is_correct):
        judgement = correct_judgement(comparison.certificate)
    else:
        reason = unknown_symbols_message or _describe_difference(comparison, columns) or "you left the others blank"
        if not unknown_symbols_message or any(is_correct):
            reason = f"{_describe_count(is_correct, blanks, is_zero)}; {reason}"
        share = float(share_of_entries(is_correct, is_zero, blanks))
        judgement = partial_judgement(share, reason, comparison.certificate)
    marks = tuple(tuple(is_correct[i : i + columns]) for i in range(0, len(is_correct), columns))
    return replace(judgement, entries=marks)


def _describe_count(
    is_correct: Sequence[bool], blanks: Sequence[bool], is_zero: Sequence[bool], noun: str = "entries"
) -> str:
    """Return a phrase with the number of correct entries; entries that are zero in the reference don't count."""
    zeros = list(is_zero) if not all(is_zero) else [False] * len(is_zero)
    correct_count = sum(is_right and not zero for is_right, zero in zip(is_correct, zeros, strict=True))
    total = len(zeros) - sum(zeros)
    description = f"{total} nonzero {noun}" if any(zeros) else f"{total} {noun}"
    spoiled_count, verb = count_spoiled_zeros(is_correct, zeros, blanks), "is" if correct_count == 1 else "are"
    if total <= 1 and not spoiled_count:
        return "it is not right"
    spoiled_words = f", and {spoiled_count} that should be zero {'is' if spoiled_count == 1 else 'are'} not"
    return f"{correct_count} of {description} {verb} right{spoiled_words if spoiled_count else ''}"


def _describe_difference(comparison: Comparison, columns: int) -> str:
    """Return a phrase on the first entry that differs, with both values; "" if no answered entry differs."""
    example = comparison.certificate.counterexample
    if not isinstance(example, EntryDifference):
        return ""
    entry_name = name_entry(example.entry, columns) + " " if len(comparison.is_correct) > 1 else ""
    return f"{entry_name}differs{describe_point(example.at)}{describe_values(example)}"


def describe_unknown_symbols(parsed: ParsedAnswer, domain: Domain) -> str:
    """Return a message about symbols in the answer that the problem doesn't define; "" if there are none."""
    unknown = parsed.symbols - set(domain.roles)
    if not unknown:
        return ""
    if unknown <= set(VOCABULARY["units"]):
        return f"leave out the unit {min(unknown)}: lengths are in metres, angles in radians"
    return f"{name_unknown_symbols(unknown)}; its symbols are {', '.join(sorted(domain.roles))}"


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
        judgement = correct_judgement(Certificate("numeric", 1, 0.0), f"right to {100 * tolerance:g} %")
    else:
        first_wrong, zeros = is_correct.index(False), [abs(expected_value) <= floor for expected_value in reference]
        answer_value = "blank" if blanks[first_wrong] else to_json_number(complex(values[first_wrong]))
        example = EntryDifference(first_wrong, {}, answer_value, float(f"{reference[first_wrong]:.4g}"))
        difference = " was left blank" if blanks[first_wrong] else describe_number(example, units[first_wrong])
        reason = f"{_describe_count(is_correct, blanks, zeros, 'numbers')}; number {first_wrong + 1}{difference}"
        share = share_of_entries(is_correct, zeros, blanks)
        judgement = partial_judgement(float(share), reason, Certificate("numeric", 1, 0.0, example))
    return replace(judgement, entries=tuple((is_right,) for is_right in is_correct))


def judge_direction(
    parsed: ParsedAnswer, reference: Sequence[Node], domain: Domain, seed: str, tolerance: float | None = None
) -> Judgement:
    """Judge a vector, which is correct if it is the reference times any nonzero factor.

    Without `tolerance`, both vectors are formulas, which must be equal up to the factor at every configuration. With
    `tolerance`, both vectors are numeric, and `tolerance` is the largest allowed norm of the difference of the unit
    vectors.
    """
    if parsed.refusal is not None:
        return parsed.refusal
    if any(parsed.blanks):
        return missing_judgement("you left part of the vector blank")
    if tolerance:
        return _judge_numeric_direction(parsed, reference, tolerance)
    return _judge_symbolic_direction(parsed, reference, domain, seed)


_ZERO_VECTOR_REASON = "the zero vector has no direction"


def _judge_symbolic_direction(parsed: ParsedAnswer, reference: Sequence[Node], domain: Domain, seed: str) -> Judgement:
    """Judge a symbolic direction by comparing entry_i r_k with r_i entry_k, where reference entry r_k is not zero."""
    entries, zeros = parsed.entries, [ZERO] * len(reference)
    pivot = compare_entries(reference, zeros, domain, f"{seed}/pivot").is_correct.index(False)
    if all(compare_entries(entries, zeros, domain, f"{seed}/zero").is_correct):
        return wrong_judgement(_ZERO_VECTOR_REASON)
    student_products = [Node("*", (entry, reference[pivot])) for entry in entries]
    reference_products = [Node("*", (entry, entries[pivot])) for entry in reference]
    comparison = compare_entries(student_products, reference_products, domain, seed)
    if all(comparison.is_correct):
        return correct_judgement(comparison.certificate)
    certificate = _certificate_for_pivot(comparison.certificate, reference[pivot], entries[pivot], pivot)
    example = certificate.counterexample
    entry, at = comparison.is_correct.index(False), ""
    if isinstance(example, EntryDifference):
        entry, at = example.entry, describe_point(example.at)
    problem = "should be 0" if entry == pivot else f"does not have the right ratio to entry {pivot + 1}"
    reason = f"your vector does not have the right direction: entry {entry + 1} {problem}{at}"
    return wrong_judgement(describe_unknown_symbols(parsed, domain) or reason, certificate)


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
        return replace(certificate, counterexample=EntryDifference(pivot, example.at, to_json_number(value), 0.0))
    values = show_difference(example.yours / scale, example.expected / scale)
    return replace(certificate, counterexample=EntryDifference(example.entry, example.at, *values, pivot))


def _judge_numeric_direction(parsed: ParsedAnswer, reference: Sequence[Node], tolerance: float) -> Judgement:
    if parsed.symbols:
        return wrong_judgement(describe_symbols_in_numbers(parsed.symbols))
    answer_vector, reference_vector = (
        evaluate(compile_program(list(nodes)), {}, 1)[0][:, 0] for nodes in (parsed.entries, reference)
    )
    if not np.all(np.isfinite(answer_vector)) or np.any(
        np.abs(answer_vector.imag) > IMAGINARY_TOLERANCE * np.abs(answer_vector)
    ):
        return wrong_judgement("an entry of the vector is not a finite real number")
    norm = float(np.linalg.norm(answer_vector.real))
    if norm == 0.0:
        return wrong_judgement(_ZERO_VECTOR_REASON)
    unit_vector, expected_unit_vector = (
        answer_vector.real / norm,
        reference_vector.real / np.linalg.norm(reference_vector.real),
    )
    expected_unit_vector = expected_unit_vector * (1.0 if float(unit_vector @ expected_unit_vector) >= 0 else -1.0)
    distance = float(np.linalg.norm(unit_vector - expected_unit_vector))
    if distance <= tolerance:
        return correct_judgement(Certificate("numeric", 1, 0.0))
    entry = int(np.abs(unit_vector - expected_unit_vector).argmax())
    example = EntryDifference(
        entry, {}, float(f"{unit_vector[entry]:.6g}"), float(f"{expected_unit_vector[entry]:.4g}")
    )
    reason = f"scaled to length 1, entry {entry + 1}{describe_number(example)}"
    return wrong_judgement(
        f"your vector does not have the right direction: {reason}", Certificate("numeric", 1, 0.0, example)
    )


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
        return parsed.refusal or missing_judgement()
    reference_pieces = [[piece for tree in group for piece in parse_pieces(tree, joints)] for group in reference]
    space = ConfigurationSpace(joints, domain, rounding)
    try:
        claimed_pieces = parse_typed_set(assign_values_to_joint(parsed.tree, joints), joints)
        judgement = _judge_set(claimed_pieces, reference_pieces, space, seed)
    except ParseError as error:
        return wrong_judgement(describe_parse_error(error, "conditions"))
    if judgement.outcome is Outcome.CORRECT or (joined_tree := combine_with_and(parsed.tree, joints)) is None:
        return judgement
    try:
        is_better = (
            _judge_set(parse_typed_set(joined_tree, joints), reference_pieces, space, seed).share > judgement.share
        )
    except ParseError:  # the combined conditions have too many cases
        return judgement
    return replace(judgement, reason=f"{OR_HINT}; {judgement.reason}") if is_better else judgement


def judge_angles(parsed: ParsedAnswer, reference: Node, domain: Domain, seed: str) -> Judgement:
    """Judge a set of angles, modulo 2 pi."""
    if parsed.refusal is not None or parsed.tree is None:
        return parsed.refusal or missing_judgement()
    joint, angle_domain = Node("name", value="angle"), Domain({**domain.roles, "angle": "angle"})
    reference_pieces = [parse_pieces(Node("in", (joint, reference)), ["angle"])]
    try:
        claimed_pieces = parse_typed_set(Node("in", (joint, parsed.tree)), ["angle"])
        return _judge_set(claimed_pieces, reference_pieces, ConfigurationSpace(["angle"], angle_domain), seed, "angle")
    except ParseError as error:
        return wrong_judgement(describe_parse_error(error, "a set of angles"))


def _judge_set(
    claimed: Sequence[Piece],
    conditions: Sequence[Sequence[Piece]],
    space: ConfigurationSpace,
    seed: str,
    noun: str = "singular configuration",
) -> Judgement:
    reference_pieces = [piece for condition in conditions for piece in condition]
    comparison = compare_sets(claimed, reference_pieces, space, seed)
    if comparison.are_equal and claimed:
        return correct_judgement(_make_set_certificate(comparison))
    tolerant_space, tolerant_comparison = space, comparison
    if comparison.is_only_rounded:
        tolerant_space = ConfigurationSpace(space.joints, space.domain, ROUNDED_JOINT_VALUE)
        tolerant_comparison = compare_sets(claimed, reference_pieces, tolerant_space, seed)
    # A piece that is not singular everywhere may cover part of the reference; only sound pieces count for the share.
    sound_pieces = [piece for piece, is_sound in zip(claimed, tolerant_comparison.is_sound, strict=True) if is_sound]
    matches = _count_matched(compare_sets(sound_pieces, reference_pieces, tolerant_space, seed).is_covered, conditions)
    claims = [
        (_restricted_joints(piece, space), is_sound)
        for piece, is_sound in zip(claimed, tolerant_comparison.is_sound, strict=True)
    ]
    true_joints = {joints for joints, is_sound in claims if is_sound}
    false_count = count_false_conditions([joints for joints, is_sound in claims if is_sound is False], true_joints)
    share = share_of_set(matches, false_count, is_rounded=comparison.is_only_rounded)
    reason = _describe_set_difference(tolerant_comparison, space.joints, noun)
    if comparison.is_only_rounded:
        soundness = zip(claimed, comparison.is_sound, strict=True)
        rounded_pieces = [piece for piece, is_sound in soundness if not is_sound and piece in sound_pieces]
        at = compare_sets(rounded_pieces, reference_pieces, space, seed).surplus or {}
        rounding = f"correct except for rounding{describe_configuration(at, space.joints)}"
        reason = f"{rounding}; write {_EXACT_VALUE_HINT}{reason and f'; {reason}'}"
    if tolerant_comparison.surplus is not None and _are_degrees(claimed, reference_pieces, space, seed):
        reason = f"these values are in degrees, but the question asks for radians; {reason}"
    words = f"{_describe_matches(matches, false_count)}; " if share else ""
    reason = words + (reason or "your answer contains no configuration")
    return partial_judgement(float(share), reason, _make_set_certificate(comparison))


_EXACT_VALUE_HINT = "the exact value, such as pi/3 or acos(1/3)"


def _restricted_joints(piece: Piece, space: ConfigurationSpace) -> frozenset[str]:
    """Return the joints that a piece restricts."""
    return frozenset(space.joints) & {name for atom in piece for name in (*find_names(atom.expression), atom.joint)}


def _count_matched(covered: Sequence[bool | None], conditions: Sequence[Sequence[Piece]]) -> list[tuple[int, int]]:
    """Return for each condition the number of pieces that are covered, and the number of nonempty pieces."""
    remaining = iter(covered)
    groups = (
        [is_covered for is_covered in islice(remaining, len(condition)) if is_covered is not None]
        for condition in conditions
    )
    return [(sum(group), len(group)) for group in groups if group]


def _describe_matches(match_counts: Sequence[tuple[int, int]], false_count: int) -> str:
    """Return a phrase that counts the conditions found completely, those found in part, and the false ones."""
    complete_count = sum(found_count == expected_count for found_count, expected_count in match_counts)
    partial_count = sum(0 < found_count < expected_count for found_count, expected_count in match_counts)
    if len(match_counts) == 1:
        found = "you found the condition" if complete_count or partial_count else "you did not find the condition"
        partial_words = " only in part" if partial_count else ""
    else:
        found = f"you found {complete_count} of {len(match_counts)} conditions"
        partial_words = f", and {partial_count} only in part" if partial_count else ""
    verb = "is" if false_count == 1 else "are"
    false_words = f"; {false_count} of your conditions {verb} false" if false_count else ""
    return f"{found}{partial_words}{false_words}"


def group_by_joints(reference: Sequence[Node], joints: Sequence[str]) -> list[list[Node]]:
    """Return conditions grouped by the joints that they contain, because the correct grouping is unknown."""
    groups: dict[frozenset[str], list[Node]] = {}
    for tree in reference:
        groups.setdefault(frozenset(find_names(tree) & set(joints)), []).append(tree)
    return list(groups.values())


def _are_degrees(
    claimed: Sequence[Piece], reference_pieces: Sequence[Piece], space: ConfigurationSpace, seed: str
) -> bool:
    """Return whether all joint values would be correct after conversion from degrees to radians."""
    if any(atom.joint is None for piece in claimed for atom in piece):
        return False
    degree = Node("/", (Node("name", value="pi"), number_node(180)))
    converted = [tuple(Atom(Node("*", (atom.expression, degree)), atom.joint) for atom in piece) for piece in claimed]
    return False not in compare_sets(converted, reference_pieces, space, seed).is_sound


def _make_set_certificate(comparison: SetComparison) -> Certificate:
    example = None if comparison.are_equal else SetDifference(comparison.missing, comparison.surplus)
    count = comparison.fewest_configurations
    return Certificate("numeric", count, chance_of_missing(count), example)


def _describe_set_difference(comparison: SetComparison, joints: Sequence[str], noun: str) -> str:
    reasons = []
    if comparison.missing is not None:
        article = "an" if noun[0] in "aeiou" else "a"
        reasons.append(f"{article} {noun} is missing{describe_configuration(comparison.missing, joints)}")
    if comparison.surplus is not None:
        subject = "this angle is wrong" if noun == "angle" else "this configuration is not singular"
        reasons.append(f"{subject}{describe_configuration(comparison.surplus, joints)}")
    return "; ".join(reasons)
