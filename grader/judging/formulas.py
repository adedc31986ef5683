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
"""An imaginary part below this share of a number is rounding."""


def judge_expression(
    parsed: ParsedAnswer, reference: Node, domain: Domain, seed: str, rounding: Rounding | None = None
) -> Judgement:
    """Judge a formula; `rounding` says how far off its decimals may be."""
    if parsed.refusal is not None:
        return parsed.refusal
    comparison = compare_entries(parsed.entries, [reference], domain, seed, rounding)
    if all(comparison.equal):
        return correct(comparison.certificate)
    return wrong(unknown_symbols(parsed, domain) or _difference(comparison, 1), comparison.certificate)


def judge_matrix(
    parsed: ParsedAnswer, reference: Matrix, domain: Domain, seed: str, rounding: Rounding | None = None
) -> Judgement:
    """Judge a matrix or vector by entry.

    The share is that of the right entries among those that are not zero in the reference, less the zeros that were
    answered with something else: a matrix of zeros earns nothing.
    """
    if parsed.refusal is not None:
        return parsed.refusal
    expected = [entry for row in reference for entry in row]
    blanks = parsed.blanks
    filled = [right if blank else entry for blank, entry, right in zip(blanks, parsed.entries, expected, strict=True)]
    comparison = compare_entries(filled, expected, domain, seed, rounding)
    return matrix_judgement(comparison, blanks, reference, unknown_symbols(parsed, domain))


def matrix_judgement(comparison: Comparison, blanks: Sequence[bool], reference: Matrix, unknown: str = "") -> Judgement:
    """Return the judgement on a matrix whose entries were compared; `unknown` tells of symbols that no one knows."""
    columns = len(reference[0])
    equal = [same and not blank for same, blank in zip(comparison.equal, blanks, strict=True)]
    is_zero = [entry.kind == "number" and not entry.value for row in reference for entry in row]
    if all(equal):
        judged = correct(comparison.certificate)
    else:
        reason = unknown or _difference(comparison, columns) or "the others were left blank"
        if not unknown or any(equal):
            reason = f"{_count(equal, blanks, is_zero)}; {reason}"
        judged = partial(float(share_of_entries(equal, is_zero, blanks)), reason, comparison.certificate)
    marks = tuple(tuple(equal[i : i + columns]) for i in range(0, len(equal), columns))
    return replace(judged, entries=marks)


def _count(equal: Sequence[bool], blanks: Sequence[bool], is_zero: Sequence[bool], what: str = "entries") -> str:
    """Say how many entries are right; entries that are zero in the reference don't count."""
    zeros = list(is_zero) if not all(is_zero) else [False] * len(is_zero)
    right = sum(same and not zero for same, zero in zip(equal, zeros, strict=True))
    total = len(zeros) - sum(zeros)
    which = f"{total} {what} that are not zero" if any(zeros) else f"{total} {what}"
    lost = count_spoiled_zeros(equal, zeros, blanks)
    also = f", and {lost} that should be zero {'is' if lost == 1 else 'are'} not" if lost else ""
    return f"{right} of {which} are right{also}" if total > 1 or lost else "it is not right"


def _difference(comparison: Comparison, columns: int) -> str:
    """Say where an entry differs, and by how much; "" if no answered entry does."""
    example = comparison.certificate.counterexample
    if not isinstance(example, EntryDifference):
        return ""
    where = entry_name(example.entry, columns) + " " if len(comparison.equal) > 1 else ""
    return f"{where}differs{at_words(example.at)}{values_words(example)}"


def unknown_symbols(parsed: ParsedAnswer, domain: Domain) -> str:
    """Return a sentence on symbols that the problem does not have; "" if there are none."""
    used = parsed.symbols - set(domain.roles)
    if not used:
        return ""
    if used <= set(VOCABULARY["units"]):
        return f"leave out the unit {min(used)}: lengths are in metres, angles in radians"
    listed = ", ".join(repr(name) for name in sorted(used)[:5])
    known = ", ".join(sorted(domain.roles))
    return f"{listed} {'is' if len(used) == 1 else 'are'} no symbol of this problem; known: {known}"


def judge_numbers(
    parsed: ParsedAnswer, reference: Sequence[float], units: Sequence[str], tolerance: float, floor: float
) -> Judgement:
    """Judge numbers, each right within a relative tolerance (or the absolute floor, for values near zero).

    The share is that of a vector: numbers that are zero earn nothing.
    """
    if parsed.refusal is not None:
        return parsed.refusal
    blanks = parsed.blanks
    filled = [Node("name", value="E") if blank else entry for blank, entry in zip(blanks, parsed.entries, strict=True)]
    values = evaluate(compile_program(filled), {}, 1)[0][:, 0]
    equal = [
        bool(np.isfinite(value) and abs(value - expected) <= max(tolerance * abs(expected), floor) and not blank)
        for value, expected, blank in zip(values, reference, blanks, strict=True)
    ]
    if all(equal):
        judged = correct(Certificate("numeric", 1, 0.0), f"right to {100 * tolerance:g} %")
    else:
        first, zeros = equal.index(False), [abs(right) <= floor for right in reference]
        yours = "blank" if blanks[first] else number(complex(values[first]))
        example = EntryDifference(first, {}, yours, float(f"{reference[first]:.4g}"))
        difference = " was left blank" if blanks[first] else number_words(example, units[first])
        reason = f"{_count(equal, blanks, zeros, 'numbers')}; number {first + 1}{difference}"
        share = share_of_entries(equal, zeros, blanks)
        judged = partial(float(share), reason, Certificate("numeric", 1, 0.0, example))
    return replace(judged, entries=tuple((same,) for same in equal))


def judge_direction(
    parsed: ParsedAnswer, reference: Sequence[Node], domain: Domain, seed: str, tolerance: float | None = None
) -> Judgement:
    """Judge a vector, which is right if it is the reference times any factor other than zero.

    Without `tolerance` both are formulas, equal up to the factor at every configuration; with it they are numbers, and
    the unit vectors may differ by that much in length of their difference.
    """
    if parsed.refusal is not None:
        return parsed.refusal
    if any(parsed.blanks):
        return missing("a part of the vector was left blank")
    if tolerance:
        return _judge_numeric_direction(parsed, reference, tolerance)
    return _judge_symbolic_direction(parsed, reference, domain, seed)


def _judge_symbolic_direction(parsed: ParsedAnswer, reference: Sequence[Node], domain: Domain, seed: str) -> Judgement:
    """Compare entry i times r_k with r_i times entry k, r_k being an entry of the reference that is not zero."""
    entries, zeros = parsed.entries, [ZERO] * len(reference)
    pivot = compare_entries(reference, zeros, domain, f"{seed}/pivot").equal.index(False)
    if all(compare_entries(entries, zeros, domain, f"{seed}/zero").equal):
        return wrong("the zero vector is no direction")
    left = [Node("*", (entry, reference[pivot])) for entry in entries]
    right = [Node("*", (entry, entries[pivot])) for entry in reference]
    comparison = compare_entries(left, right, domain, seed)
    if all(comparison.equal):
        return correct(comparison.certificate)
    certificate = _certificate_for_pivot(comparison.certificate, reference[pivot], entries[pivot], pivot)
    example = certificate.counterexample
    entry, at = comparison.equal.index(False), ""
    if isinstance(example, EntryDifference):
        entry, at = example.entry, at_words(example.at)
    off = "should be 0" if entry == pivot else f"does not have the right ratio to entry {pivot + 1}"
    reason = f"not along the direction that is right: entry {entry + 1} {off}{at}"
    return wrong(unknown_symbols(parsed, domain) or reason, certificate)


def _certificate_for_pivot(certificate: Certificate, expected: Node, answered: Node, pivot: int) -> Certificate:
    """Return the certificate with the entry itself, and what it would have to be for the pivot as it was answered.

    Compared were both times the `expected` pivot. Where that vanishes, the student's own does not, and should.
    """
    example = certificate.counterexample
    if not isinstance(example, EntryDifference):
        return certificate
    if not isinstance(example.yours, float) or not isinstance(example.expected, float):
        return certificate
    at = {name: np.array([value]) for name, value in example.at.items()}
    scale, value = (complex(pivots[0]) for pivots in evaluate(compile_program([expected, answered]), at, 1)[0])
    if not scale:  # as -sin(theta1) is at 0, which is among the readable configurations
        return replace(certificate, counterexample=EntryDifference(pivot, example.at, number(value), 0.0))
    values = tell_apart(example.yours / scale, example.expected / scale)
    return replace(certificate, counterexample=EntryDifference(example.entry, example.at, *values, pivot))


def _judge_numeric_direction(parsed: ParsedAnswer, reference: Sequence[Node], tolerance: float) -> Judgement:
    if parsed.symbols:
        return wrong(f"numbers are due, and {', '.join(sorted(parsed.symbols)[:5])} is left in the answer")
    typed, right = (evaluate(compile_program(list(nodes)), {}, 1)[0][:, 0] for nodes in (parsed.entries, reference))
    if not np.all(np.isfinite(typed)) or np.any(np.abs(typed.imag) > IMAGINARY * np.abs(typed)):
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


def judge_singular(
    parsed: ParsedAnswer,
    reference: Sequence[Sequence[Node]],
    joints: Sequence[str],
    domain: Domain,
    seed: str,
    rounding: Rounding | None = None,
) -> Judgement:
    """Judge a set of singular configurations by what it contains.

    The reference holds each condition: its values, or the condition itself. The share depends on how many conditions
    are found completely or in part, and on how many claimed conditions are not singular (`share_of_set`).
    """
    if parsed.refusal is not None or parsed.tree is None:
        return parsed.refusal or missing()
    truth = [[piece for tree in condition for piece in parse_pieces(tree, joints)] for condition in reference]
    space = Space(joints, domain, rounding)
    try:
        judged = _judge_set(parse_claims(with_joint(parsed.tree, joints), joints), truth, space, seed)
    except ReadError as error:
        return wrong(f"this can't be read as conditions: {error}")
    if judged.outcome is Outcome.CORRECT or (together := combine_with_and(parsed.tree, joints)) is None:
        return judged
    try:
        is_better = _judge_set(parse_claims(together, joints), truth, space, seed).share > judged.share
    except ReadError:  # too many cases
        return judged
    return replace(judged, reason=f"{OR}; {judged.reason}") if is_better else judged


def judge_angles(parsed: ParsedAnswer, reference: Node, domain: Domain, seed: str) -> Judgement:
    """Judge a set of angles against another, modulo whole turns."""
    if parsed.refusal is not None or parsed.tree is None:
        return parsed.refusal or missing()
    joint, inner = Node("name", value="angle"), Domain({**domain.roles, "angle": "angle"})
    truth = [parse_pieces(Node("in", (joint, reference)), ["angle"])]
    try:
        claimed = parse_claims(Node("in", (joint, parsed.tree)), ["angle"])
        return _judge_set(claimed, truth, Space(["angle"], inner), seed, "angle")
    except ReadError as error:
        return wrong(f"this can't be read as a set of angles: {error}")


def _judge_set(
    claimed: Sequence[Piece],
    conditions: Sequence[Sequence[Piece]],
    space: Space,
    seed: str,
    what: str = "singular configuration",
) -> Judgement:
    truth = [piece for condition in conditions for piece in condition]
    comparison = compare_sets(claimed, truth, space, seed)
    if comparison.equal and claimed:
        return correct(_set_certificate(comparison))
    near = Space(space.joints, space.domain, ROUNDED) if comparison.rounded else space
    counted = compare_sets(claimed, truth, near, seed) if comparison.rounded else comparison
    # What is claimed beyond the truth must not earn what it happens to cover: only sound pieces count for the share.
    sound = [piece for piece, held in zip(claimed, counted.sound, strict=True) if held]
    matched = _count_matched(compare_sets(sound, truth, near, seed).covered, conditions)
    claims = [(_joints_of(piece, space), held) for piece, held in zip(claimed, counted.sound, strict=True)]
    true = {joints for joints, held in claims if held}
    unsound = count_false_conditions([joints for joints, held in claims if held is False], true)
    share = share_of_set(matched, unsound, is_rounded=comparison.rounded)
    reason = _set_reason(counted, space.joints, what)
    if comparison.rounded:
        rounded = [piece for piece, held in zip(claimed, comparison.sound, strict=True) if not held and piece in sound]
        at = compare_sets(rounded, truth, space, seed).surplus or {}
        reason = f"right but for rounding{pose_words(at, space.joints)}; write {_EXACTLY}" + (reason and f"; {reason}")
    if counted.surplus is not None and _are_degrees(claimed, truth, space, seed):
        reason = f"these values are in degrees, and radians are due; {reason}"
    words = f"{_matched_words(matched, unsound)}; " if share else ""
    return partial(float(share), words + (reason or "no configuration is claimed"), _set_certificate(comparison))


_EXACTLY = "the exact value, as in pi/3 or acos(1/3)"


def _joints_of(piece: Piece, space: Space) -> frozenset[str]:
    """Return the joints that a piece restricts."""
    return frozenset(space.joints) & {name for atom in piece for name in (*names(atom.zero), atom.joint)}


def _count_matched(covered: Sequence[bool | None], conditions: Sequence[Sequence[Piece]]) -> list[tuple[int, int]]:
    """Return of each condition how many of its pieces are covered, of how many there are anywhere."""
    remaining = iter(covered)
    groups = ([held for held in islice(remaining, len(condition)) if held is not None] for condition in conditions)
    return [(sum(group), len(group)) for group in groups if group]


def _matched_words(matched: Sequence[tuple[int, int]], unsound: int) -> str:
    """Say of how many conditions everything is found, of how many some, and how many conditions don't hold."""
    whole, in_part = sum(some == all_ for some, all_ in matched), sum(0 < some < all_ for some, all_ in matched)
    conditions = f"{len(matched)} conditions {'is' if whole == 1 else 'are'}" if len(matched) > 1 else "1 condition is"
    parts = f", {in_part} in part" if in_part else ""
    verb = "does" if unsound == 1 else "do"
    false = f", {unsound} of the claimed conditions {verb} not hold" if unsound else ""
    return f"{whole} of {conditions} found{parts}{false}"


def by_joints(reference: Sequence[Node], joints: Sequence[str]) -> list[list[Node]]:
    """Return conditions in groups that name the same joints, because it is not known which ones belong together."""
    groups: dict[frozenset[str], list[Node]] = {}
    for tree in reference:
        groups.setdefault(frozenset(names(tree) & set(joints)), []).append(tree)
    return list(groups.values())


def _are_degrees(claimed: Sequence[Piece], truth: Sequence[Piece], space: Space, seed: str) -> bool:
    """Tell whether the values of all joints would be right if they were turned from degrees into radians."""
    if any(atom.joint is None for piece in claimed for atom in piece):
        return False
    degree = Node("/", (Node("name", value="pi"), number_node(180)))
    turned = [tuple(Atom(Node("*", (atom.zero, degree)), atom.joint) for atom in piece) for piece in claimed]
    return False not in compare_sets(turned, truth, space, seed).sound


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
