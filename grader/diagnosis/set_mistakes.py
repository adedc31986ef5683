"""Find the mistake behind a wrong set of singular configurations, or the pieces of the set that are wrong.

A piece is a list of conditions that hold simultaneously. Comparing configurations is slow, so fingerprints identify the
pieces. The fingerprint of a condition such as theta2 = pi consists of the joint and its value. If a condition relates
several joints, as in theta2 = theta3, its fingerprint consists of values of the expression that must be zero, up to a
common factor. Configurations are compared only if a piece has another form, or if no mistake gives the set.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, starmap

import numpy as np

from qdot.exercises.arm.chain import REVOLUTE
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.arithmetic import compile_expressions
from qdot.exercises.formula.conditions import ROUNDED_JOINT_VALUE, ConfigurationSpace, SetComparison, compare_sets
from qdot.exercises.formula.program import Program, compile_program, evaluate
from qdot.exercises.formula.set_parser import Piece, parse_typed_set, solve_for_angle
from qdot.exercises.formula.trees import (
    Node,
    ParseError,
    count_decimal_digits,
    find_names,
    format_tree,
    iterate_nodes,
)
from qdot.exercises.mistakes.base import Mistake, MistakenAnswer
from qdot.exercises.mistakes.catalogue import CATALOGUE, generate_mistaken_answers
from qdot.exercises.mistakes.configurations import sample_values
from qdot.exercises.mistakes.sets import advise_on_any_set, name_missed_component, write_zero_question
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.reference_answers import Answer, ConditionSet
from qdot.exercises.singularities.singular_set import Component
from qdot.grader.diagnosis.rounding import CONSTANT_TOLERANCE, EXACT_VALUES_ADVICE
from qdot.grader.judging.answer_parser import ParsedAnswer, assign_values_to_joint
from qdot.grader.judging.judge import judge_parsed
from qdot.grader.judging.verdict import Diagnosis, Outcome, locate_mistake

SAMPLE_COUNT = 3
"""Number of random values of each symbol from which fingerprints are computed."""
CHAPTER_REFERENCE = " See (6.8)."
"""The reference to the equation about singular configurations; feedback on other sets does not refer to the chapter."""
MAX_MISTAKES_NAMED = 3
"""Maximum number of mistakes that are named for one set."""
MIN_DEGREES = 15.0
"""A plain number of at least this size is an angle in degrees: in radians, it would be more than two turns."""
FINGERPRINT_DIGITS = 6
"""Number of decimals of the values in a fingerprint."""

ConditionFingerprint = tuple[str, tuple[complex, ...]]
"""The fingerprint of a condition: a joint and its values for some random lengths.

If the condition relates several joints, the name is empty, and the values are those of the expression that must be
zero, up to a common factor."""

PieceFingerprint = frozenset[ConditionFingerprint]


@dataclass(frozen=True)
class SetFingerprint:
    """The fingerprint of a set: `valued_pieces` give only values of joints; `tied_pieces` also relate joints."""

    valued_pieces: frozenset[PieceFingerprint]
    tied_pieces: frozenset[PieceFingerprint]


def explain_set(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> Diagnosis | None:
    """Return the diagnosis of a wrong set: the mistake that gives it, or otherwise its wrong pieces."""
    diagnosis = _explain_any_set(problem, part, parsed_answer, seed)
    if diagnosis is None or (isinstance(part.answer, ConditionSet) and part.answer.is_singular_set):
        return diagnosis
    return replace(diagnosis, feedback=diagnosis.feedback.removesuffix(CHAPTER_REFERENCE))


def _explain_any_set(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> Diagnosis | None:
    """Return the diagnosis of a wrong set; the message refers to the equation about singular configurations."""
    if parsed_answer.tree is None or parsed_answer.refusal is not None:  # the reason for the refusal says enough
        return None
    joints = [q.name for q in problem.chain.q]
    try:
        pieces = parse_typed_set(assign_values_to_joint(parsed_answer.tree, joints), joints)
    except ParseError:
        return None
    fingerprinter = _Fingerprinter(problem, seed)
    if not all(map(fingerprinter.is_plain, pieces)):
        includes_samples = _make_inclusion_test(problem, part, pieces, seed)
        mistaken_answers = generate_mistaken_answers(problem.chain, part)
        possible_answers = (pair for pair in mistaken_answers if includes_samples(pair[1].answer))
        diagnosis = find_mistake_by_judging(problem, part, parsed_answer, seed, possible_answers)
        return diagnosis or _explain_pieces(problem, part, pieces, seed)
    typed_set = fingerprinter.fingerprint_pieces(pieces)
    has_decimals = count_decimal_digits(parsed_answer.tree) > 0
    if _is_correct_but_rounded(typed_set, fingerprinter.fingerprint_answer(part.answer), has_decimals):
        return Diagnosis((), EXACT_VALUES_ADVICE)
    for mistake, variant in generate_mistaken_answers(problem.chain, part):
        if isinstance(variant.answer, ConditionSet):
            predicted_set = fingerprinter.fingerprint_answer(variant.answer)
            has_same_values = typed_set.tied_pieces and typed_set.valued_pieces == predicted_set.valued_pieces
            may_be_equal = has_same_values and len(typed_set.tied_pieces) == len(predicted_set.tied_pieces)
            is_equal = predicted_set == typed_set
            if not is_equal and may_be_equal:  # equal conditions on several joints may have different fingerprints
                is_equal = _is_judged_correct(problem, part, parsed_answer, variant, seed)
            if is_equal:
                return _name_likeliest(problem, part, mistake, variant, fingerprinter)
    return _explain_pieces(problem, part, pieces, seed)


def find_mistake_by_judging(
    problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str,
    mistaken_answers: Iterable[tuple[Mistake, MistakenAnswer]],
) -> Diagnosis | None:  # fmt: skip
    """Return the mistake whose answer, taken as the reference, makes the student's answer correct; None if none does.

    This is slow, and is meant for answers that are not derived step by step.
    """
    for mistake, variant in mistaken_answers:
        if _is_judged_correct(problem, part, parsed_answer, variant, seed):
            return name_alternatives([(mistake, variant.words, mistake.format_message(variant.words))])
    return None


def _make_inclusion_test(problem: Problem, part: Part, pieces: Sequence[Piece], seed: str) -> Callable[[Answer], bool]:
    """Return a test whether an answer contains all of a set's configurations, as far as some random ones show.

    The configurations are sampled only once, because the search for those of simultaneous conditions is slow.
    """
    space = ConfigurationSpace([q.name for q in problem.chain.q], problem.domain, part.rounding)
    tolerance = max(ROUNDED_JOINT_VALUE.absolute, space.typed_tolerance)
    names = space.collect_names([pieces]) | set(problem.domain.roles)
    with np.errstate(all="ignore"):  # a search that overflows finds no zero
        samples = [space.sample_piece(piece, names, Stream(f"{seed}/typed/{k}")) for k, piece in enumerate(pieces)]
    counts = [len(next(iter(sample.values()))) for sample in samples]

    def includes_samples(answer: Answer) -> bool:
        if not isinstance(answer, ConditionSet):
            return False
        try:
            pieces_of_answer = space.parse_reference(tree for (tree,) in answer.parse_trees(problem.domain.roles))
        except ParseError:
            return False
        union = [tuple(solve_for_angle(atom, space.angles) for atom in piece) for piece in pieces_of_answer]
        pairs = zip(samples, counts, strict=True)
        with np.errstate(all="ignore"):
            return all(space.contains(union, values, count, tolerance).all() for values, count in pairs)

    return includes_samples


def name_alternatives(alternatives: Sequence[tuple[Mistake, Mapping[str, object], str]]) -> Diagnosis:
    """Return the diagnosis that one of the mistakes was made.

    Each comes with the values in its message (its words) and with the complete message.
    """
    names = tuple(dict.fromkeys(mistake.name for mistake, _, _ in alternatives))
    message = " Another mistake gives the same answer: ".join(dict.fromkeys(message for _, _, message in alternatives))
    signatures = tuple(locate_mistake(mistake.name, words) for mistake, words, _ in alternatives)
    return Diagnosis(names, message, signature=signatures, are_alternatives=len(names) > 1)


def _name_likeliest(
    problem: Problem, part: Part, mistake: Mistake, variant: MistakenAnswer, fingerprinter: "_Fingerprinter"
) -> Diagnosis:
    """Return the diagnosis that names the likeliest of the mistakes that give the same set as `mistake`.

    If several mistakes are equally likely, all of them are named.
    """
    fingerprint, words_by_mistake = fingerprinter.fingerprint_answer(variant.answer), {mistake: variant.words}
    for rival in map(CATALOGUE.__getitem__, mistake.equivalent_mistakes):
        for answer in rival.generate_answers(problem.chain, part):
            if fingerprinter.fingerprint_answer(answer.answer) == fingerprint:
                words_by_mistake[rival] = answer.words
                break
    highest_frequency = max(rival.frequency for rival in words_by_mistake)
    likeliest_pairs = [pair for pair in words_by_mistake.items() if pair[0].frequency == highest_frequency]
    return name_alternatives([(rival, words, rival.format_message(words)) for rival, words in likeliest_pairs])


def _is_judged_correct(
    problem: Problem, part: Part, parsed_answer: ParsedAnswer, variant: MistakenAnswer, seed: str
) -> bool:
    """Return whether a student's answer would be correct if the mistaken answer were the reference."""
    try:
        outcome = judge_parsed(problem, replace(part, answer=variant.answer), parsed_answer, seed).outcome
    except ParseError:  # the mistaken answer can't be parsed as a set
        return False
    return outcome is Outcome.CORRECT


# --- piece by piece ---


def _explain_pieces(problem: Problem, part: Part, claimed_pieces: Sequence[Piece], seed: str) -> Diagnosis | None:
    """Return the diagnosis that lists wrong values, and conditions that are partly or completely missing.

    Before the comparison, angles in degrees are converted, and alternatives that were joined with "and" are separated;
    both are named as mistakes.
    """
    pieces_in_radians = _convert_degrees(problem, claimed_pieces)
    mistakes: list[tuple[str, Mapping[str, object]]] = []
    if pieces_in_radians != list(claimed_pieces):
        mistakes.append(("angles-in-degrees", {}))
    explanation = _SetExplanation(problem, part, pieces_in_radians, seed)
    if explanation.joins_alternatives:
        separate_pieces = [(atom,) for atom in chain.from_iterable(pieces_in_radians)]
        separate_explanation = _SetExplanation(problem, part, separate_pieces, seed)
        if not separate_explanation.wrong_pieces:
            mistakes.append(("and-for-or", {}))
            explanation = separate_explanation
    comparison, wrong_pieces = explanation.comparison, explanation.wrong_pieces
    if comparison.is_only_rounded or any(len(piece) > 1 or piece[0].joint is None for piece in wrong_pieces):
        return None
    mistakes += [*explanation.explain_wrong_values(), *explanation.explain_missing_conditions()]
    if not explanation.is_singular_set:
        if any("zero" in words for _, words in mistakes):  # these messages apply to singular configurations only
            return None
        mistakes = [(name, advise_on_any_set(words)) for name, words in mistakes]
    if not 0 < len(mistakes) <= MAX_MISTAKES_NAMED:
        return None
    sentences = list(dict.fromkeys(CATALOGUE[name].format_message(words) for name, words in mistakes))
    if not claimed_pieces:
        sentences = [f"Your answer contains no condition. {mistakes[0][1]['every']}. See (6.8)."]
    names = tuple(dict.fromkeys(name for name, _ in mistakes))
    signature = tuple(dict.fromkeys(locate_mistake(*mistake) for mistake in mistakes))
    return Diagnosis(names, _join_messages(sentences), signature=signature)


def _join_messages(messages: Sequence[str]) -> str:
    """Join messages into one text. A reference to the chapter that all messages share appears only once, at the end.

    >>> _join_messages(["Check the sign. See (6.8).", "Use radians. See (6.8)."])
    'Check the sign. Use radians. See (6.8).'
    """
    _, separator, chapter_reference = messages[-1].rpartition(" See ")
    *other_messages, last_message = messages
    return " ".join([*(text.removesuffix(separator + chapter_reference) for text in other_messages), last_message])


def _convert_degrees(problem: Problem, pieces: Sequence[Piece]) -> list[Piece]:
    """Return pieces in radians: if a plain number is too large for an angle in radians, all of them are in degrees."""
    revolute_joints = {problem.chain.q[i].name for i in problem.chain.revolute_joints}
    angles = [
        atom
        for atom in chain.from_iterable(pieces)
        if atom.joint in revolute_joints and all(node.kind != "name" for node in iterate_nodes(atom.expression))
    ]
    if not angles:
        return list(pieces)
    with np.errstate(all="ignore"):
        values = evaluate(compile_program([atom.expression for atom in angles]), {}, 1).values
    if not (np.abs(values) >= MIN_DEGREES).any():
        return list(pieces)
    convert = {atom: replace(atom, expression=atom.expression * Node("name", value="pi") / 180) for atom in angles}
    return [tuple(convert.get(atom, atom) for atom in piece) for piece in pieces]


class _SetExplanation:
    """Compares a student's set with the expected conditions, by their configurations.

    `claimed_pieces` are the pieces of the student's set. `conditions` has a list of pieces for each condition.
    `wrong_pieces` are the claimed pieces that contain configurations outside the expected set.
    """

    def __init__(self, problem: Problem, part: Part, claimed_pieces: Sequence[Piece], seed: str) -> None:
        assert isinstance(part.answer, ConditionSet)
        joints, roles = [q.name for q in problem.chain.q], problem.domain.roles
        trees = part.answer.group_by_component([tree for (tree,) in part.answer.parse_trees(roles)])
        self.chain, self.components, self.seed = problem.chain, part.answer.components, seed
        self.is_singular_set = part.answer.is_singular_set
        self.claimed_pieces = claimed_pieces
        self.space = ConfigurationSpace(joints, problem.domain, part.rounding)
        self.conditions = [self.space.parse_reference(group) for group in trees]
        self.comparison = self._compare(claimed_pieces, list(chain.from_iterable(self.conditions)))
        pairs = zip(claimed_pieces, self.comparison.is_sound, strict=True)
        self.wrong_pieces = [piece for piece, is_sound in pairs if is_sound is False]

    @property
    def joins_alternatives(self) -> bool:
        """Whether some of the claimed conditions have to hold simultaneously, but none of the expected ones do."""
        has_simultaneous_conditions = max(map(len, self.claimed_pieces), default=0) > 1
        return has_simultaneous_conditions and max(len(c.conditions) for c in self.components) == 1

    def _compare(self, pieces: Sequence[Piece], other_pieces: Sequence[Piece]) -> SetComparison:
        return compare_sets(pieces, other_pieces, self.space, self.seed)

    def explain_wrong_values(self) -> Iterator[tuple[str, Mapping[str, object]]]:
        """Yield, for each joint with wrong values, the name of the mistake and the words for its message."""
        singular_joints = {q.name for component in self.components for q, _ in component.solutions or ()}
        for joint in dict.fromkeys(str(piece[0].joint) for piece in self.wrong_pieces):
            joint_pieces = [piece for piece in self.wrong_pieces if piece[0].joint == joint]
            values = ", ".join(_format_value(piece[0].expression) for piece in joint_pieces)
            if any(self._list_contained_pieces(joint_pieces, group) for group in self.conditions):
                yield "condition-of-several-forgotten", {"joint": joint}
            else:
                name = "value-called-singular" if joint in singular_joints else "joint-called-singular"
                yield name, {"joint": joint, "values": values, "zero": write_zero_question(self.chain)}

    def explain_missing_conditions(self) -> Iterator[tuple[str, Mapping[str, object]]]:
        """Yield, for each condition that is missing or incomplete, the name of the mistake and the words."""
        for k, (component, condition) in enumerate(zip(self.components, self.conditions, strict=True)):
            contained_pieces = self._list_contained_pieces(self.wrong_pieces, condition)
            is_found = False not in self._compare(condition, self.claimed_pieces).is_sound
            if is_found or len(contained_pieces) == len(condition):
                continue
            other_pieces = list(chain.from_iterable(self.conditions[:k] + self.conditions[k + 1 :]))
            size = min(map(len, condition))  # a piece with more conditions is not a root of the condition
            correct_pieces = [
                piece for piece in self.claimed_pieces if piece not in self.wrong_pieces and len(piece) <= size
            ]
            found_pieces = contained_pieces or [
                piece for piece in correct_pieces if self._compare([piece], other_pieces).is_sound == (False,)
            ]
            yield ("one-root-only", {}) if found_pieces else name_missed_component(self.chain, component)

    def _list_contained_pieces(self, claimed_pieces: Sequence[Piece], condition: Sequence[Piece]) -> list[Piece]:
        """Return the pieces of a condition that the claimed pieces contain."""
        if not claimed_pieces:
            return []
        pairs = zip(condition, self._compare(condition, claimed_pieces).is_sound, strict=True)
        return [piece for piece, is_contained in pairs if is_contained]


def _format_value(value: Node) -> str:
    """Return a value in ordinary notation, without brackets around it.

    >>> from qdot.exercises.formula.parser import parse_formula
    >>> [_format_value(parse_formula(text, {})) for text in ("-pi/2", "1/3", "-acos(1/3)", "pi - 1")]
    ['-pi/2', '1/3', '-acos((1/3))', 'pi-1']
    """
    if value.kind == "neg" and value.args[0].kind not in ("+", "-"):
        return f"-{_format_value(value.args[0])}"
    text = format_tree(value)
    return text[1:-1] if text.startswith("(") else text


# --- fingerprints of sets ---


class _Fingerprinter:
    """Identifies the pieces of sets by numeric values, computed for random values of all symbols."""

    def __init__(self, problem: Problem, seed: str) -> None:
        self.values = sample_values(problem.domain, SAMPLE_COUNT, Stream(f"{seed}/sets"))
        self.joints = {q.name: joint.kind for q, joint in zip(problem.chain.q, problem.chain.joints, strict=True)}

    def is_plain(self, piece: Piece) -> bool:
        """Return whether each condition of a piece gives a constant value of a joint, or relates several joints."""
        joint_counts = [(atom.joint, len(find_names(atom.expression) & set(self.joints))) for atom in piece]
        return all(count > 1 if joint is None else count == 0 for joint, count in joint_counts)

    def fingerprint_pieces(self, pieces: Sequence[Piece]) -> SetFingerprint:
        """Return the fingerprints of the pieces of a typed set."""
        programs = ([(atom.joint, compile_program([atom.expression])) for atom in piece] for piece in pieces)
        return self._collect(frozenset(starmap(self._fingerprint, piece)) for piece in programs)

    def fingerprint_answer(self, answer: Answer) -> SetFingerprint:
        """Return the fingerprints of the pieces of a correct answer, or of a mistaken answer."""
        assert isinstance(answer, ConditionSet)
        return self._collect(chain.from_iterable(map(self._fingerprint_component, answer.components)))

    def _fingerprint_component(self, component: Component) -> Iterator[PieceFingerprint]:
        if component.solutions is None:
            yield frozenset(self._fingerprint(None, compile_expressions(zero)) for zero in component.conditions)
        for values in component.list_value_combinations():
            yield frozenset(self._fingerprint(q.name, compile_expressions(value)) for q, value in values)

    def _collect(self, pieces: Iterable[PieceFingerprint]) -> SetFingerprint:
        """Return the fingerprint of a set, without the pieces that have all conditions of another piece and more."""
        distinct_pieces = frozenset(pieces)
        surplus_pieces = {piece for piece in distinct_pieces if any(subset < piece for subset in distinct_pieces)}
        outer_pieces = distinct_pieces - surplus_pieces
        valued_pieces = frozenset(piece for piece in outer_pieces if all(joint for joint, _ in piece))
        return SetFingerprint(valued_pieces, outer_pieces - valued_pieces)

    def _fingerprint(self, joint: str | None, program: Program) -> ConditionFingerprint:
        """Return the fingerprint of a condition: a joint has the value of a program, or the program's value is zero."""
        values = evaluate(program, self.values, SAMPLE_COUNT).values[0]
        with np.errstate(all="ignore"):
            if joint is None:
                values = values / values[0]
            elif self.joints[joint] == REVOLUTE:
                turns = values.real / (2 * np.pi)  # whole turns don't count; a rounding error below 0 counts as 0
                values = np.round(turns - np.floor(turns + 10.0**-FINGERPRINT_DIGITS), FINGERPRINT_DIGITS) + 0.0
        return (joint or "", tuple(np.round(np.nan_to_num(values, nan=1e9), FINGERPRINT_DIGITS).tolist()))


def _is_correct_but_rounded(
    fingerprint: SetFingerprint, correct_fingerprint: SetFingerprint, has_decimals: bool
) -> bool:
    """Return whether a set is correct, or would be if its decimals were the exact constants."""
    if not has_decimals:
        return fingerprint == correct_fingerprint
    pairs = (
        (fingerprint.valued_pieces, correct_fingerprint.valued_pieces),
        (fingerprint.tied_pieces, correct_fingerprint.tied_pieces),
    )
    return all(len(a) == len(b) and _are_nearly_equal(a, b) and _are_nearly_equal(b, a) for a, b in pairs)


def _are_nearly_equal(pieces: frozenset[PieceFingerprint], other_pieces: frozenset[PieceFingerprint]) -> bool:
    """Return whether each piece equals one of the other pieces except for rounded constants."""
    return all(any(_is_nearly_equal(piece, other_piece) for other_piece in other_pieces) for piece in pieces)


def _is_nearly_equal(piece: PieceFingerprint, other_piece: PieceFingerprint) -> bool:
    return len(piece) == len(other_piece) and all(_contains_nearly(other_piece, condition) for condition in piece)


def _contains_nearly(piece: PieceFingerprint, condition: ConditionFingerprint) -> bool:
    """Return whether a piece contains a condition that equals the given condition except for rounded constants."""
    joint, values = condition
    for exact_joint, exact_values in piece:
        tolerance = CONSTANT_TOLERANCE * np.maximum(1.0, np.abs(exact_values)) / (2 * np.pi)  # angles are in turns
        if exact_joint == joint and (np.abs(np.subtract(values, exact_values)) <= tolerance).all():
            return True
    return False
