"""Judge formulas, matrices, numbers, directions and sets of configurations by comparing them with the correct answer.

The correct answer is called the reference. The parsed answer must not have been refused. A seed determines the random
configurations at which answers are compared. A certificate records how a comparison was made. If the answer is wrong,
the certificate has a counterexample: values at which the answer differs from the reference.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from qdot.exercises.formula.algebra import Matrix
from qdot.exercises.formula.conditions import ROUNDED_JOINT_VALUE, ConfigurationSpace, SetComparison, compare_sets
from qdot.exercises.formula.equality import (
    MAX_DIGITS,
    Certificate,
    Comparison,
    Domain,
    EntryDifference,
    Rounding,
    SetDifference,
    compare_entries,
    compute_chance_of_missing,
    format_difference,
    to_json_number,
)
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.set_parser import Atom, Piece, parse_pieces, parse_typed_set
from qdot.exercises.formula.trees import ZERO, Node, ParseError, find_names, make_number
from qdot.exercises.formula.vocabulary import VOCABULARY
from qdot.exercises.problem.credit import (
    compute_share_of_entries,
    compute_share_of_set,
    count_false_conditions,
    count_spoiled_zeros,
)
from qdot.grader.judging.answer_parser import (
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
    make_correct_judgement,
    make_missing_judgement,
    make_partial_judgement,
    make_wrong_judgement,
    name_entry,
)

SHOWN_DIGITS = 4
"""The number of significant digits of an expected number, if the required precision needs no more."""
IMAGINARY_TOLERANCE = 1e-12
"""An imaginary part below this fraction of the absolute value is taken for a rounding error."""


def judge_expression(
    parsed: ParsedAnswer, reference: Node, domain: Domain, seed: str, rounding: Rounding | None = None
) -> Judgement:
    """Judge a formula; `rounding` is the error that is allowed for decimals in it."""
    comparison = compare_entries(parsed.entries, [reference], domain, seed, rounding)
    if all(comparison.is_correct):
        return make_correct_judgement(comparison.certificate)
    reason = describe_unknown_symbols(parsed, domain) or _describe_difference(comparison, 1)
    return make_wrong_judgement(reason, comparison.certificate)


def judge_matrix(
    parsed: ParsedAnswer, reference: Matrix, domain: Domain, seed: str, rounding: Rounding | None = None
) -> Judgement:
    """Judge a matrix or vector entry by entry.

    The share is a quotient. Its numerator is the number of correct nonzero entries, minus the number of wrong entries
    that should be zero. Its denominator is the number of nonzero entries in the reference. So a matrix of zeros earns
    nothing.
    """
    expected = [entry for row in reference for entry in row]
    # A blank entry is replaced by the correct entry, so that it is never the counterexample.
    triples = zip(parsed.entries, expected, parsed.is_blank, strict=True)
    filled_entries = [correct_entry if is_blank else entry for entry, correct_entry, is_blank in triples]
    comparison = compare_entries(filled_entries, expected, domain, seed, rounding)
    return judge_compared_matrix(comparison, parsed.is_blank, reference, describe_unknown_symbols(parsed, domain))


def judge_compared_matrix(
    comparison: Comparison, is_blank: Sequence[bool], reference: Matrix, unknown_symbols_message: str = ""
) -> Judgement:
    """Return the judgement on a matrix whose entries were compared with the entries of the reference.

    `is_blank` is whether each entry contains a blank. `unknown_symbols_message` names the symbols that the problem
    doesn't define; "" means that there are none.
    """
    columns = len(reference[0])
    is_correct = [is_equal and not blank for is_equal, blank in zip(comparison.is_correct, is_blank, strict=True)]
    is_zero = [entry.kind == "number" and not entry.value for row in reference for entry in row]
    if all(is_correct):
        judgement = make_correct_judgement(comparison.certificate)
    else:
        clauses = [unknown_symbols_message or _describe_difference(comparison, columns)]
        if not unknown_symbols_message or any(is_correct):
            clauses = [_describe_correct_count(is_correct, is_blank, is_zero), _describe_blanks(is_blank), *clauses]
        reason = "; ".join(filter(None, clauses))
        share = float(compute_share_of_entries(is_correct, is_zero, is_blank))
        judgement = make_partial_judgement(share, reason, comparison.certificate)
    entry_flags = tuple(tuple(is_correct[i : i + columns]) for i in range(0, len(is_correct), columns))
    return replace(judgement, entries=entry_flags)


def _describe_correct_count(
    is_correct: Sequence[bool], is_blank: Sequence[bool], is_zero: Sequence[bool], noun: str = "entries"
) -> str:
    """Return a clause with the number of correct entries; "" if there is only one entry.

    Entries that are zero in the reference don't count; the clause has the number of wrong answers to them. `is_zero` is
    whether each entry of the reference is zero. If all of them are zero, all entries count.
    """
    if len(is_zero) == 1:
        return ""
    is_ignored = list(is_zero) if not all(is_zero) else [False] * len(is_zero)
    correct_count = sum(is_right and not ignored for is_right, ignored in zip(is_correct, is_ignored, strict=True))
    total = is_ignored.count(False)
    spoiled_count = count_spoiled_zeros(is_correct, is_ignored, is_blank)
    adjective = "nonzero " if any(is_ignored) else ""
    if total == 1:
        count_words = f"the only nonzero entry is {'right' if correct_count else 'not right'}"
    elif correct_count == 0:
        count_words = f"{'neither of the two' if total == 2 else f'none of the {total}'} {adjective}{noun} is right"
    elif correct_count == total:
        count_words = f"{'both' if total == 2 else f'all {total}'} {adjective}{noun} are right"
    else:
        count_words = f"{correct_count} of {total} {adjective}{noun} {'is' if correct_count == 1 else 'are'} right"
    conjunction = "but" if correct_count else "and"
    spoiled_noun = "entry that should be zero is" if spoiled_count == 1 else "entries that should be zero are"
    spoiled_words = f", {conjunction} {spoiled_count} {spoiled_noun} not" if spoiled_count else ""
    return count_words + spoiled_words


def _describe_blanks(is_blank: Sequence[bool], singular: str = "entry", plural: str = "entries") -> str:
    """Return a clause with the number of entries that contain a blank; "" if there are none."""
    count = sum(is_blank)
    words = f"{singular} still contains" if count == 1 else f"{plural} still contain"
    return f"{count} {words} a blank" if count else ""


def _describe_difference(comparison: Comparison, columns: int) -> str:
    """Return a clause on the first entry that differs, with both values; "" if no answered entry differs.

    `columns` is the number of columns of the answer.
    """
    example = comparison.certificate.counterexample
    if not isinstance(example, EntryDifference):
        return ""
    subject = name_entry(example.entry, columns) if len(comparison.is_correct) > 1 else "your answer"
    values = f"yours {format_value(example.yours)}, expected {format_value(example.expected)}"
    return f"{subject} differs{_describe_point(example.at)}: {values}"


def describe_unknown_symbols(parsed: ParsedAnswer, domain: Domain) -> str:
    """Return a clause about symbols in an answer that the problem doesn't define; "" if there are none."""
    unknown = parsed.symbols - set(domain.roles)
    if not unknown:
        return ""
    if unknown <= set(VOCABULARY["units"]):
        return f"leave out the unit {min(unknown)}: lengths are in metres, angles in radians"
    listed_names = ", ".join(sorted(domain.roles.keys() - domain.unlisted_names))
    return f"{name_unknown_symbols(unknown)}; its symbols are {listed_names}"


def judge_numbers(
    parsed: ParsedAnswer, reference: Sequence[float], units: Sequence[str], tolerance: float, floors: Sequence[float]
) -> Judgement:
    """Judge numbers. Each is correct within the relative `tolerance`, or within its absolute tolerance in `floors`.

    The share is computed as for a vector: numbers that are zero in the reference earn nothing.
    """
    is_blank, expected = parsed.is_blank, np.array(reference)
    entries = [ZERO if blank else entry for blank, entry in zip(is_blank, parsed.entries, strict=True)]
    values = _evaluate_numbers(entries)
    with np.errstate(all="ignore"):
        is_close = np.isfinite(values) & (np.abs(values - expected) <= np.maximum(tolerance * np.abs(expected), floors))
    is_correct = [bool(flag) for flag in is_close & ~np.array(is_blank)]
    if all(is_correct):
        floor_texts = dict.fromkeys(f"{floor:g} {unit}".strip() for floor, unit in zip(floors, units, strict=True))
        max_error = f"{100 * tolerance:g} %" if tolerance else ", ".join(floor_texts)
        judgement = make_correct_judgement(Certificate("numeric", points=1, bound=0.0), f"right to {max_error}")
    else:
        wrong_index = is_correct.index(False)
        is_zero = [abs(value) <= floor for value, floor in zip(reference, floors, strict=True)]
        answer_value = "blank" if is_blank[wrong_index] else to_json_number(complex(values[wrong_index]))
        digits = max(SHOWN_DIGITS, Rounding(tolerance, floors[wrong_index]).count_digits(reference[wrong_index]))
        example = EntryDifference(wrong_index, {}, answer_value, float(f"{reference[wrong_index]:.{digits}g}"))
        count_words = _describe_correct_count(is_correct, is_blank, is_zero, "numbers")
        if is_blank[wrong_index]:
            blank_numbers = [str(index + 1) for index, blank in enumerate(is_blank) if blank]
            differences = [
                f"number {blank_numbers[0]} was left blank" if len(blank_numbers) == 1
                else f"numbers {', '.join(blank_numbers[:-1])} and {blank_numbers[-1]} were left blank"
            ]  # fmt: skip
        else:
            subject = "your number" if len(reference) == 1 else f"number {wrong_index + 1}"
            difference = f"{subject}{_describe_both_values(example, units[wrong_index])}"
            differences = [_describe_blanks(is_blank, "number", "numbers"), difference]
        reason = "; ".join(filter(None, [count_words, *differences]))
        share = compute_share_of_entries(is_correct, is_zero, is_blank)
        certificate = Certificate("numeric", points=1, bound=0.0, counterexample=example)
        judgement = make_partial_judgement(float(share), reason, certificate)
    return replace(judgement, entries=tuple((is_right,) for is_right in is_correct))


def _evaluate_numbers(entries: Sequence[Node]) -> np.ndarray:
    """Return the values of entries without symbols."""
    values, _ = evaluate(compile_program(entries), {}, 1)
    return values[:, 0]


def judge_direction(
    parsed: ParsedAnswer, reference: Sequence[Node], domain: Domain, seed: str, tolerance: float | None = None
) -> Judgement:
    """Judge a vector, which is correct if it is the reference times any nonzero factor.

    Without `tolerance`, both vectors are formulas, which must be equal up to the factor at every configuration. With
    `tolerance`, both vectors are numeric. The difference of their unit vectors must then have at most this norm.
    """
    if any(parsed.is_blank):
        return make_missing_judgement("you left part of the vector blank")
    if tolerance:
        return _judge_numeric_direction(parsed, reference, tolerance)
    return _judge_symbolic_direction(parsed, reference, domain, seed)


_ZERO_VECTOR_REASON = "the zero vector has no direction"


def _judge_symbolic_direction(parsed: ParsedAnswer, reference: Sequence[Node], domain: Domain, seed: str) -> Judgement:
    """Judge a direction given by formulas.

    For a vector a and a reference r, a_i r_k is compared with r_i a_k for each i. The first entry r_k of the reference
    that is not zero is called the pivot.
    """
    entries, zeros = parsed.entries, [ZERO] * len(reference)
    pivot = compare_entries(reference, zeros, domain, f"{seed}/pivot").is_correct.index(False)
    if all(compare_entries(entries, zeros, domain, f"{seed}/zero").is_correct):
        return make_wrong_judgement(_ZERO_VECTOR_REASON)
    student_products = [Node("*", (entry, reference[pivot])) for entry in entries]
    reference_products = [Node("*", (entry, entries[pivot])) for entry in reference]
    comparison = compare_entries(student_products, reference_products, domain, seed)
    if all(comparison.is_correct):
        return make_correct_judgement(comparison.certificate)
    certificate = _make_pivot_certificate(comparison.certificate, reference[pivot], entries[pivot], pivot)
    example = certificate.counterexample
    entry = comparison.is_correct.index(False)
    point_words = ""
    if isinstance(example, EntryDifference):
        entry, point_words = example.entry, _describe_point(example.at)
    error = f"the ratio of entry {entry + 1} to entry {pivot + 1} is wrong"
    if entry == pivot:
        error = f"entry {entry + 1} should be 0"
    reason = f"your vector does not have the right direction: {error}{point_words}"
    return make_wrong_judgement(describe_unknown_symbols(parsed, domain) or reason, certificate)


def _make_pivot_certificate(
    certificate: Certificate, expected_entry: Node, student_entry: Node, pivot: int
) -> Certificate:
    """Return a certificate that shows the student's entry, and the value that would fit the student's pivot.

    `expected_entry` and `student_entry` are the pivots of the reference and of the answer, at the index `pivot`; see
    `_judge_symbolic_direction`. The comparison multiplied both values by the expected pivot. If the expected pivot is
    zero at the counterexample, the student's pivot is not zero, so the counterexample shows the pivot instead.
    """
    example = certificate.counterexample
    if not isinstance(example, EntryDifference):
        return certificate
    if not isinstance(example.yours, float) or not isinstance(example.expected, float):
        return certificate
    point = {name: np.array([value]) for name, value in example.at.items()}
    values, _ = evaluate(compile_program([expected_entry, student_entry]), point, 1)
    expected_pivot, answered_pivot = map(complex, values[:, 0])
    if not expected_pivot:  # e.g. -sin(theta1) at theta1 = 0; readable sample values may be 0
        pivot_difference = EntryDifference(pivot, example.at, to_json_number(answered_pivot), 0.0)
        return replace(certificate, counterexample=pivot_difference)
    shown_values = format_difference(example.yours / expected_pivot, example.expected / expected_pivot)
    return replace(certificate, counterexample=EntryDifference(example.entry, example.at, *shown_values, pivot))


def _judge_numeric_direction(parsed: ParsedAnswer, reference: Sequence[Node], tolerance: float) -> Judgement:
    """Judge a direction given by numbers."""
    if parsed.symbols:
        return make_wrong_judgement(describe_symbols_in_numbers(parsed.symbols))
    values = _evaluate_numbers([*parsed.entries, *reference])
    answer, expected = values[: len(reference)], values[len(reference) :].real
    if not np.all(np.isfinite(answer)) or np.any(np.abs(answer.imag) > IMAGINARY_TOLERANCE * np.abs(answer)):
        return make_wrong_judgement("an entry of the vector is not a finite real number")
    norm = float(np.linalg.norm(answer.real))
    if norm == 0.0:
        return make_wrong_judgement(_ZERO_VECTOR_REASON)
    unit_vector, expected_unit_vector = answer.real / norm, expected / np.linalg.norm(expected)
    expected_unit_vector = expected_unit_vector * (1.0 if float(unit_vector @ expected_unit_vector) >= 0 else -1.0)
    differences = np.abs(unit_vector - expected_unit_vector)
    if float(np.linalg.norm(differences)) <= tolerance:
        return make_correct_judgement(Certificate("numeric", points=1, bound=0.0))
    entry = int(differences.argmax())
    values_of_both = float(f"{unit_vector[entry]:.6g}"), float(f"{expected_unit_vector[entry]:.{SHOWN_DIGITS}g}")
    example = EntryDifference(entry, {}, *values_of_both)
    difference = f"scaled to length 1, entry {entry + 1}{_describe_both_values(example)}"
    reason = f"your vector does not have the right direction: {difference}"
    return make_wrong_judgement(reason, Certificate("numeric", points=1, bound=0.0, counterexample=example))


SINGULAR_CONFIGURATION, CONFIGURATION, ANGLE = "a singular configuration", "a configuration", "an angle"
"""What an element of a set is called in messages, depending on the question."""
SURPLUS_WORDS = {
    SINGULAR_CONFIGURATION: "this configuration is not singular",
    CONFIGURATION: "this configuration does not satisfy the condition", ANGLE: "this angle is wrong",
}  # fmt: skip
"""The clause about an element that is not in the reference."""


def judge_singular(
    parsed: ParsedAnswer, reference: Sequence[Sequence[Node]], joints: Sequence[str], domain: Domain, seed: str,
    rounding: Rounding | None = None, noun: str = SINGULAR_CONFIGURATION,
) -> Judgement:  # fmt: skip
    """Judge a set of configurations by the configurations that it contains. `noun` is a key of `SURPLUS_WORDS`.

    For each condition, the reference contains a list of joint values, or the condition itself. The share depends on how
    many conditions the student found completely or in part, and on how many of the student's conditions are wrong
    (`compute_share_of_set`).
    """
    assert parsed.tree is not None
    space = ConfigurationSpace(joints, domain, rounding)
    reference_pieces = [space.parse_reference(group) for group in reference]
    try:
        claimed_pieces = parse_typed_set(assign_values_to_joint(parsed.tree, joints), joints)
        judgement = _judge_set(claimed_pieces, reference_pieces, space, seed, noun)
    except ParseError as error:
        return make_wrong_judgement(describe_parse_error(error, "conditions"))
    if judgement.outcome is Outcome.CORRECT or (joined_tree := combine_with_and(parsed.tree, joints)) is None:
        return judgement
    try:
        joined_judgement = _judge_set(parse_typed_set(joined_tree, joints), reference_pieces, space, seed, noun)
    except ParseError:  # the combined conditions have too many cases
        return judgement
    is_better = joined_judgement.share > judgement.share
    return replace(judgement, reason=f"{OR_HINT}; {judgement.reason}") if is_better else judgement


def judge_angles(parsed: ParsedAnswer, reference: Node, domain: Domain, seed: str) -> Judgement:
    """Judge a set of angles, modulo 2 pi."""
    assert parsed.tree is not None
    joint, angle_domain = Node("name", value="angle"), Domain({**domain.roles, "angle": "angle"})
    reference_pieces = [parse_pieces(Node("in", (joint, reference)), ["angle"])]
    space = ConfigurationSpace(["angle"], angle_domain)
    try:
        claimed_pieces = parse_typed_set(Node("in", (joint, parsed.tree)), ["angle"])
        return _judge_set(claimed_pieces, reference_pieces, space, seed, ANGLE)
    except ParseError as error:
        return make_wrong_judgement(describe_parse_error(error, "a set of angles"))


def _judge_set(
    claimed_pieces: Sequence[Piece], conditions: Sequence[Sequence[Piece]], space: ConfigurationSpace, seed: str,
    noun: str,
) -> Judgement:  # fmt: skip
    """Judge the union of the student's `claimed_pieces` by comparing it with the union of the `conditions`.

    A piece is a set of configurations given by equations that all hold; a condition is the union of its pieces. A piece
    is sound if all its configurations belong to the reference.
    """
    reference_pieces = [piece for condition in conditions for piece in condition]
    comparison = compare_sets(claimed_pieces, reference_pieces, space, seed)
    if comparison.are_equal and claimed_pieces:
        return make_correct_judgement(_make_set_certificate(comparison))
    tolerant_space, tolerant_comparison = space, comparison
    if comparison.is_only_rounded:  # rounded joint values earn part of the points
        tolerant_space = ConfigurationSpace(space.joints, space.domain, ROUNDED_JOINT_VALUE)
        tolerant_comparison = compare_sets(claimed_pieces, reference_pieces, tolerant_space, seed)
    # A piece that is not sound may also cover part of the reference; only sound pieces count for the share.
    pieces_and_soundness = list(zip(claimed_pieces, tolerant_comparison.is_sound, strict=True))
    sound_pieces = [piece for piece, is_sound in pieces_and_soundness if is_sound]
    is_covered: Sequence[bool | None] = tolerant_comparison.is_covered
    if not sound_pieces:
        is_covered = [None if flag is None else False for flag in is_covered]  # None for an empty piece
    elif len(sound_pieces) < len(claimed_pieces):
        is_covered = compare_sets(sound_pieces, reference_pieces, tolerant_space, seed).is_covered
    match_counts = _count_covered_pieces(
        is_covered, conditions, lambda piece: _is_found_in_part(piece, sound_pieces, tolerant_space, seed)
    )
    # A wrong value of a joint counts differently if the student also found a right value of this joint.
    true_joints = {_find_restricted_joints(piece, space) for piece in sound_pieces}
    false_pieces = [piece for piece, is_sound in pieces_and_soundness if is_sound is False]
    false_joints = [_find_restricted_joints(piece, space) for piece in false_pieces]
    false_count = count_false_conditions(false_joints, true_joints)
    share = compute_share_of_set(match_counts, false_count, is_rounded=comparison.is_only_rounded)
    reason = _describe_set_difference(tolerant_comparison, space.joints, noun)
    if comparison.is_only_rounded:
        pairs = zip(claimed_pieces, comparison.is_sound, strict=True)
        rounded_pieces = [piece for piece, is_exact in pairs if not is_exact and piece in sound_pieces]
        rounded_values = compare_sets(rounded_pieces, reference_pieces, space, seed).surplus or {}
        rounding_words = f"correct except for rounding{_describe_configuration(rounded_values, space.joints)}"
        reason = f"{rounding_words}; write {_EXACT_VALUE_HINT}{reason and f'; {reason}'}"
    if tolerant_comparison.surplus is not None and _are_degrees(claimed_pieces, reference_pieces, space, seed):
        # This reason explains all wrong conditions, so the message doesn't count them.
        reason, false_count = "your values are in degrees, but the question asks for radians", 0
    match_words = f"{_describe_matches(match_counts, false_count)}; " if share else ""
    reason = match_words + (reason or "your answer contains no configuration")
    return make_partial_judgement(float(share), reason, _make_set_certificate(comparison))


_EXACT_VALUE_HINT = "the exact value, such as pi/3 or acos(1/3)"


def _find_restricted_joints(piece: Piece, space: ConfigurationSpace) -> frozenset[str]:
    return frozenset(space.joints) & {name for atom in piece for name in (*find_names(atom.expression), atom.joint)}


def _count_covered_pieces(
    is_covered: Sequence[bool | None], conditions: Sequence[Sequence[Piece]], is_found_in_part: Callable[[Piece], bool]
) -> list[tuple[int, int]]:
    """Return for each condition the number of its pieces that are covered, and the number of its nonempty pieces.

    `is_covered` is whether each piece of all conditions is covered; None for an empty piece. Empty conditions are
    omitted. A single piece that was found in part counts as one covered piece of two.
    """
    remaining_flags = iter(is_covered)
    groups = [(list(islice(remaining_flags, len(condition))), condition) for condition in conditions]
    counts = [(group.count(True), len(group) - group.count(None)) for group, _ in groups]
    for k, (group, condition) in enumerate(groups):
        if group == [False] and is_found_in_part(condition[0]):
            counts[k] = (1, 2)
    return [(covered_count, total) for covered_count, total in counts if total]


def _is_found_in_part(piece: Piece, sound_pieces: Sequence[Piece], space: ConfigurationSpace, seed: str) -> bool:
    """Return whether a sound piece is a branch of `piece`, as theta2 = atan(a1/a2) is of a1 = a2*tan(theta2).

    A branch gives values of joints, and has no more conditions than `piece`.
    """
    branches = (
        branch
        for branch in sound_pieces
        if len(branch) <= len(piece) and all(atom.joint is not None for atom in branch)
    )
    return any(compare_sets([branch], [piece], space, seed).is_sound == (True,) for branch in branches)


def _describe_matches(match_counts: Sequence[tuple[int, int]], false_count: int) -> str:
    """Return a clause with the numbers of conditions that were found completely, found in part, and false."""
    complete_count = sum(found_count == expected_count for found_count, expected_count in match_counts)
    partial_count = sum(0 < found_count < expected_count for found_count, expected_count in match_counts)
    total = len(match_counts)
    if partial_count and not complete_count:
        of_conditions = f" of {'one' if partial_count == 1 else partial_count} of the {total} conditions"
        found_words = f"you found only some of the configurations{'' if total == 1 else of_conditions}"
    elif total == 1:
        found_words = "you found the condition" if complete_count else "you did not find the condition"
    elif not complete_count:
        found_words = f"you found none of the {total} conditions"
    else:
        others = "another" if partial_count == 1 else f"{partial_count} others"
        also_words = f", and some configurations of {others}" if partial_count else ""
        found_words = f"you found {complete_count} of the {total} conditions{also_words}"
    verb = "is" if false_count == 1 else "are"
    false_words = f"; {false_count} of your conditions {verb} wrong" if false_count else ""
    return f"{found_words}{false_words}"


def group_by_joints(reference: Sequence[Node], joints: Sequence[str]) -> list[list[Node]]:
    """Return conditions grouped by the joints that they contain, because the correct grouping is unknown."""
    groups: dict[frozenset[str], list[Node]] = {}
    for tree in reference:
        groups.setdefault(frozenset(find_names(tree) & set(joints)), []).append(tree)
    return list(groups.values())


def _are_degrees(
    claimed_pieces: Sequence[Piece], reference_pieces: Sequence[Piece], space: ConfigurationSpace, seed: str
) -> bool:
    """Return whether all joint values of the student would be correct after conversion from degrees to radians."""
    if any(atom.joint is None for piece in claimed_pieces for atom in piece):
        return False
    degree = Node("name", value="pi") / make_number(180)
    converted_pieces = [
        tuple(Atom(Node("*", (atom.expression, degree)), atom.joint) for atom in piece) for piece in claimed_pieces
    ]
    return False not in compare_sets(converted_pieces, reference_pieces, space, seed).is_sound


def _make_set_certificate(comparison: SetComparison) -> Certificate:
    example = None if comparison.are_equal else SetDifference(comparison.missing, comparison.surplus)
    count = comparison.fewest_configurations
    return Certificate("numeric", count, compute_chance_of_missing(count), example)


def _describe_set_difference(comparison: SetComparison, joints: Sequence[str], noun: str) -> str:
    """Return clauses about a missing and a surplus configuration; "" if there are none."""
    reasons = []
    if comparison.missing is not None:
        reasons.append(f"{noun} is missing{_describe_configuration(comparison.missing, joints)}")
    if comparison.surplus is not None:
        reasons.append(f"{SURPLUS_WORDS[noun]}{_describe_configuration(comparison.surplus, joints)}")
    return "; ".join(reasons)


# --- phrases that describe a counterexample within a reason; `feedback_levels` can remove these phrases ---


def _describe_point(point: Mapping[str, float]) -> str:
    """Return the configuration at which an entry differs in words, as in " at theta1 = 0.61"; "" without symbols."""
    assignments = ", ".join(f"{name} = {value:g}" for name, value in point.items())
    return f" at {assignments}" if assignments else ""


def _describe_both_values(example: EntryDifference, unit: str = "") -> str:
    """Return a clause with the student's value and the expected one, as in " is 0.41, and 0.77 rad/s is right"."""
    expected_words = f"{example.expected:.{MAX_DIGITS}g} {unit}".rstrip() if isinstance(example.expected, float) else ""
    return f" is {format_value(example.yours)}, and {expected_words} is right"


def _describe_configuration(values: Mapping[str, float], joints: Sequence[str]) -> str:
    """Return a configuration in words, as in ": theta1 = 0.61, theta2 = -1.32"; the joints come first."""
    names = [name for name in dict.fromkeys((*joints, *values)) if name in values]
    return f": {', '.join(f'{name} = {values[name]:.4g}' for name in names) or '(any)'}"


def format_value(value: float | str | None) -> str:
    """Return a value in the form that is used in a reason."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)
