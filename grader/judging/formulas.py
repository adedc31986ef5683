"""Judge one answer, as it was read, against a reference: expressions, matrices, singular sets, numbers."""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from qdot.exercises.formula.algebra import Matrix
from qdot.exercises.formula.conditions import ROUNDED, SetComparison, Space, compare_sets
from qdot.exercises.formula.identity import (
    Certificate,
    Comparison,
    Domain,
    EntryDifference,
    Rounding,
    SetDifference,
    compare_entries,
    missed,
    number,
)
from qdot.exercises.formula.pieces import Atom, Piece, pieces
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.set_parser import claimed_pieces
from qdot.exercises.formula.trees import Node, ReadError, names
from qdot.exercises.formula.vocabulary import VOCABULARY
from qdot.exercises.problem.credit import count_false_conditions, count_spoiled_zeros, share_of_entries, share_of_set
from qdot.grader.judging.answer import OR, Given, at_once, with_joint
from qdot.grader.judging.counterexample import at_words, entry_name, number_words, pose_words, values_words
from qdot.grader.judging.verdict import Judgement, Outcome, correct, graded, missing, wrong


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
        reason = said if unknown and not any(equal) else f"{_count(equal, blanks, is_zero)}; {said}"
        judged = graded(float(share_of_entries(equal, is_zero, blanks)), reason, comparison.certificate)
    marks = tuple(tuple(equal[i : i + columns]) for i in range(0, len(equal), columns))
    return replace(judged, entries=marks)


def _count(equal: Sequence[bool], blanks: Sequence[bool], is_zero: Sequence[bool], what: str = "entries") -> str:
    """Say how many entries are right as they are counted: those that are zero in the reference earn nothing."""
    zeros = list(is_zero) if not all(is_zero) else [False] * len(is_zero)
    right = sum(same and not zero for same, zero in zip(equal, zeros, strict=True))
    total = len(zeros) - sum(zeros)
    which = f"{total} {what} that are not zero" if any(zeros) else f"{total} {what}"
    lost = count_spoiled_zeros(equal, zeros, blanks)
    also = f", and {lost} that should be zero {'is' if lost == 1 else 'are'} not" if lost else ""
    return f"{right} of {which} are right{also}" if total > 1 or lost else "it is not right"


def _difference(comparison: Comparison, columns: int) -> str:
    """Say where an entry differs, and by how much; nothing where none that was answered does."""
    example = comparison.certificate.counterexample
    if not isinstance(example, EntryDifference):
        return ""
    where = entry_name(example.entry, columns) + " " if len(comparison.equal) > 1 else ""
    return f"{where}differs{at_words(example.at)}{values_words(example)}"


def unknown_symbols(given: Given, domain: Domain) -> str:
    """Return a sentence on symbols that the problem does not have; nothing where there are none."""
    used = given.symbols - set(domain.roles)
    if not used:
        return ""
    if used <= set(VOCABULARY["units"]):
        return f"leave out the unit {min(used)}: lengths are in metres, angles in radians"
    listed = ", ".join(repr(name) for name in sorted(used)[:5])
    known = ", ".join(sorted(domain.roles))
    return f"{listed} {'is' if len(used) == 1 else 'are'} no symbol of this problem; known: {known}"


def judge_numbers(
    given: Given, reference: Sequence[float], units: Sequence[str], tolerance: float, floor: float
) -> Judgement:
    """Judge numbers, each right within a relative tolerance (or the absolute floor, for values near zero).

    The share is that of a vector: numbers that are zero earn nothing.
    """
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
    example = EntryDifference(first, {}, yours, float(f"{due:.4g}"))
    said = " was left blank" if blanks[first] else number_words(example, unit)
    zeros = [abs(right) <= floor for right in reference]
    reason = f"{_count(equal, blanks, zeros, 'numbers')}; number {first + 1}{said}"
    share = share_of_entries(equal, zeros, blanks)
    judged = graded(float(share), reason, Certificate("numeric", 1, 0.0, example))
    return replace(judged, entries=marks)


def judge_singular(
    given: Given,
    reference: Sequence[Sequence[Node]],
    joints: Sequence[str],
    domain: Domain,
    seed: str,
    rounding: Rounding | None = None,
) -> Judgement:
    """Judge a set of singular configurations by what it contains.

    The reference holds what is due for each condition: its values, or the condition itself. The share is by conditions
    that are found, in part or not, and by conditions that are claimed and not singular (`share_of_set`).
    """
    if given.refusal is not None or given.tree is None:
        return given.refusal or missing()
    truth = [[piece for tree in condition for piece in pieces(tree, joints)] for condition in reference]
    space = Space(joints, domain, rounding)
    try:
        judged = _judge_set(claimed_pieces(with_joint(given.tree, joints), joints), truth, space, seed)
    except ReadError as error:
        return wrong(f"this can't be read as conditions: {error}")
    if judged.outcome is Outcome.CORRECT or (other := at_once(given.tree, joints)) is None:
        return judged
    try:
        is_better = _judge_set(claimed_pieces(other, joints), truth, space, seed).share > judged.share
    except ReadError:  # too many cases
        return judged
    return replace(judged, reason=f"{OR}; {judged.reason}") if is_better else judged


def judge_angles(given: Given, reference: Node, domain: Domain, seed: str) -> Judgement:
    """Judge a set of angles against another, modulo whole turns."""
    if given.refusal is not None or given.tree is None:
        return given.refusal or missing()
    joint, inner = Node("name", value="angle"), Domain({**domain.roles, "angle": "angle"})
    truth = [pieces(Node("in", (joint, reference)), ["angle"])]
    try:
        claimed = claimed_pieces(Node("in", (joint, given.tree)), ["angle"])
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
    found = _found(compare_sets(sound, truth, near, seed).covered, conditions)
    claims = [(_joints_of(piece, space), held) for piece, held in zip(claimed, counted.sound, strict=True)]
    true = {joints for joints, held in claims if held}
    unsound = count_false_conditions([joints for joints, held in claims if held is False], true)
    share = share_of_set(found, unsound, is_rounded=comparison.rounded)
    reason = _set_reason(counted, space.joints, what)
    if comparison.rounded:
        rounded = [piece for piece, held in zip(claimed, comparison.sound, strict=True) if not held and piece in sound]
        at = compare_sets(rounded, truth, space, seed).surplus or {}
        reason = f"right but for rounding{pose_words(at, space.joints)}; write {_EXACTLY}" + (reason and f"; {reason}")
    if counted.surplus is not None and _are_degrees(claimed, truth, space, seed):
        reason = f"these values are in degrees, and radians are due; {reason}"
    words = f"{_found_words(found, unsound)}; " if share else ""
    return graded(float(share), words + (reason or "no configuration is claimed"), _set_certificate(comparison))


_EXACTLY = "the exact value, as in pi/3 or acos(1/3)"


def _joints_of(piece: Piece, space: Space) -> frozenset[str]:
    """Return the joints of which a piece says something."""
    joints = set(space.joints)
    return frozenset().union(*(names(atom.zero) & joints | ({atom.joint} if atom.joint else set()) for atom in piece))


def _found(covered: Sequence[bool | None], conditions: Sequence[Sequence[Piece]]) -> list[tuple[int, int]]:
    """Return of each condition how many of its pieces are covered, of how many there are anywhere."""
    left, found = list(covered), []
    for condition in conditions:
        held, left = [one for one in left[: len(condition)] if one is not None], left[len(condition) :]
        found += [(sum(held), len(held))] if held else []
    return found


def _found_words(found: Sequence[tuple[int, int]], unsound: int) -> str:
    """Say of how many conditions all is found, of how many some, and how many conditions don't hold."""
    whole, in_part = sum(some == due for some, due in found), sum(0 < some < due for some, due in found)
    conditions = f"{len(found)} conditions {'is' if whole == 1 else 'are'}" if len(found) > 1 else "1 condition is"
    parts = f", {in_part} in part" if in_part else ""
    verb = "does" if unsound == 1 else "do"
    false = f", {unsound} of the claimed conditions {verb} not hold" if unsound else ""
    return f"{whole} of {conditions} found{parts}{false}"


def by_joints(reference: Sequence[Node], joints: Sequence[str]) -> list[list[Node]]:
    """Return conditions in groups that name the same joints, where it is not known what belongs together."""
    groups: dict[frozenset[str], list[Node]] = {}
    for tree in reference:
        groups.setdefault(frozenset(names(tree) & set(joints)), []).append(tree)
    return list(groups.values())


def _are_degrees(claimed: Sequence[Piece], truth: Sequence[Piece], space: Space, seed: str) -> bool:
    """Tell whether the values of all joints would be right if they were turned from degrees into radians."""
    if any(atom.joint is None for piece in claimed for atom in piece):
        return False
    degree = Node("/", (Node("name", value="pi"), Node("number", value=Fraction(180))))
    turned = [tuple(Atom(Node("*", (atom.zero, degree)), atom.joint) for atom in piece) for piece in claimed]
    return False not in compare_sets(turned, truth, space, seed).sound


def _set_certificate(comparison: SetComparison) -> Certificate:
    example = None if comparison.equal else SetDifference(comparison.missing, comparison.surplus)
    return Certificate("numeric", comparison.least, missed(comparison.least), example)


def _set_reason(comparison: SetComparison, joints: Sequence[str], what: str) -> str:
    said = []
    if comparison.missing is not None:
        article = "an" if what[0] in "aeiou" else "a"
        said.append(f"{article} {what} is missing{pose_words(comparison.missing, joints)}")
    if comparison.surplus is not None:
        said.append(f"claimed, but no {what}{pose_words(comparison.surplus, joints)}")
    return "; ".join(said)
