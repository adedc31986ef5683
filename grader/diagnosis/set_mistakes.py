"""Find the mistake behind a wrong set of singular configurations, or the pieces of the set that are wrong.

A piece is a list of conditions that hold simultaneously. If it gives values of joints, it is identified by these. If it
ties several joints, it is identified by the values of the expression that vanishes, up to a factor. Only pieces in
another form, or that no mistake gives, are compared by their configurations, which is slow.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, islice, product, starmap

import numpy as np

from qdot.exercises.answer_types import Answer, ConditionSet
from qdot.exercises.arm.arithmetic import compile_expression
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import ConfigurationSpace, SetComparison, compare_sets
from qdot.exercises.formula.program import Program, compile_program, evaluate
from qdot.exercises.formula.set_parser import Piece, parse_pieces, parse_typed_set
from qdot.exercises.formula.trees import Node, ParseError, count_decimal_digits, find_names, node_text
from qdot.exercises.mistakes.base import Mistake, MistakenAnswer
from qdot.exercises.mistakes.catalogue import (
    CATALOGUE,
    generate_mistaken_answers,
)
from qdot.exercises.mistakes.configurations import sample_values
from qdot.exercises.mistakes.sets import name_missed_component, zero_question
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.singularities.singularity import Component
from qdot.grader.diagnosis.rounding import CONSTANT_TOLERANCE, EXACT_VALUES_ADVICE
from qdot.grader.judging.answer import ParsedAnswer, assign_values_to_joint
from qdot.grader.judging.judge import judge_parsed
from qdot.grader.judging.verdict import Diagnosis, Outcome, locate_mistake

SAMPLE_COUNT = 3
MAX_MISTAKES_NAMED = 3
"""Maximum number of mistakes that are named for one set."""
FINGERPRINT_DIGITS = 6

ConditionFingerprint = tuple[str, tuple[complex, ...]]
"""One condition: a joint and its values for some random lengths.

If it ties several joints, the name is empty, and the values are those of the expression that vanishes, up to a
factor."""


@dataclass(frozen=True)
class SetFingerprint:
    """A set as it is written: the pieces that give values of joints, and the pieces that tie several joints."""

    valued_pieces: frozenset[frozenset[ConditionFingerprint]]
    tied_pieces: frozenset[frozenset[ConditionFingerprint]]


def explain_set(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> Diagnosis | None:
    """Return the diagnosis of a wrong set: the mistake that gives it, or otherwise its wrong pieces."""
    if parsed_answer.tree is None:
        return None
    joints = [q.name for q in problem.chain.q]
    try:
        pieces = parse_typed_set(assign_values_to_joint(parsed_answer.tree, joints), joints)
    except ParseError:
        return None
    marker = _Fingerprinter(problem, seed)
    if not all(map(marker.is_plain, pieces)):
        return find_mistaken_answer(problem, part, parsed_answer, seed) or _explain_pieces(problem, part, pieces, seed)
    marks, has_decimals = marker.fingerprint_pieces(pieces), count_decimal_digits(parsed_answer.tree) > 0
    if _is_correct_but_rounded(marks, marker.fingerprint_answer(part.answer), has_decimals):
        return Diagnosis((), EXACT_VALUES_ADVICE)
    for mistake, variant in generate_mistaken_answers(problem.chain, part):
        if isinstance(variant.answer, ConditionSet):
            predicted = marker.fingerprint_answer(variant.answer)
            has_equal_values = marks.tied_pieces and marks.valued_pieces == predicted.valued_pieces
            may_be_equal = has_equal_values and len(marks.tied_pieces) == len(predicted.tied_pieces)
            if predicted == marks or (may_be_equal and _is_judged_correct(problem, part, parsed_answer, variant, seed)):
                return _name_likeliest(problem, part, mistake, variant, marker)
    return _explain_pieces(problem, part, pieces, seed)


def find_mistaken_answer(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> Diagnosis | None:
    """Return the mistake whose answer is judged equal to the given one, for parts that aren't derived step by step."""
    for mistake, variant in generate_mistaken_answers(problem.chain, part):
        if _is_judged_correct(problem, part, parsed_answer, variant, seed):
            return name_alternatives([(mistake, variant.words, mistake.sentence(variant.words))])
    return None


def name_alternatives(rivals: Sequence[tuple[Mistake, Mapping[str, object], str]]) -> Diagnosis:
    """Return the diagnosis that names several mistakes that give the same answer, with their words and messages."""
    names = tuple(dict.fromkeys(mistake.name for mistake, _, _ in rivals))
    message = " Or, which gives the same answer: ".join(dict.fromkeys(sentence for _, _, sentence in rivals))
    signatures = tuple(locate_mistake(mistake.name, words) for mistake, words, _ in rivals)
    return Diagnosis(names, message, signature=signatures, are_alternatives=len(names) > 1)


def _name_likeliest(
    problem: Problem, part: Part, mistake: Mistake, variant: MistakenAnswer, fingerprinter: "_Fingerprinter"
) -> Diagnosis:
    """Return the diagnosis that names the likeliest of the mistakes that give the same set as `mistake`.

    Equally likely mistakes are all named.
    """
    fingerprint, equal_variants = fingerprinter.fingerprint_answer(variant.answer), [(mistake, variant)]
    for rival in map(CATALOGUE.__getitem__, mistake.equivalent_mistakes):
        variants = rival.answers(problem.chain, part)
        equal = (each for each in variants if fingerprinter.fingerprint_answer(each.answer) == fingerprint)
        equal_variants += [(rival, each) for each in islice(equal, 1)]
    highest_frequency = max(rival.frequency for rival, _ in equal_variants)
    likeliest_mistakes = [
        (rival, set_variant.words) for rival, set_variant in equal_variants if rival.frequency == highest_frequency
    ]
    return name_alternatives([(rival, words, rival.sentence(words)) for rival, words in likeliest_mistakes])


def _is_judged_correct(
    problem: Problem, part: Part, parsed_answer: ParsedAnswer, variant: MistakenAnswer, seed: str
) -> bool:
    """Return whether an answer would be correct if a mistaken one were the reference."""
    try:
        outcome = judge_parsed(problem, replace(part, answer=variant.answer), parsed_answer, seed).outcome
    except ParseError:  # the mistaken answer can't be parsed as a set
        return False
    return outcome is Outcome.CORRECT


# --- piece by piece ---


def _explain_pieces(problem: Problem, part: Part, claimed: Sequence[Piece], seed: str) -> Diagnosis | None:
    """Return the diagnosis that lists false claims, and conditions that are partly or completely missing."""
    claims = _SetExplanation(problem, part, claimed, seed)
    soundness = zip(claimed, claims.comparison.is_sound, strict=True)
    wrong_pieces = [piece for piece, is_sound in soundness if is_sound is False]
    if claims.comparison.is_only_rounded or any(len(piece) > 1 or piece[0].joint is None for piece in wrong_pieces):
        return None
    mistakes = [*claims.explain_wrong_values(wrong_pieces), *claims.explain_missing_conditions(wrong_pieces)]
    if not 0 < len(mistakes) <= MAX_MISTAKES_NAMED:
        return None
    sentences = dict.fromkeys(CATALOGUE[name].sentence(words) for name, words in mistakes)
    names = tuple(dict.fromkeys(name for name, _ in mistakes))
    signature = tuple(dict.fromkeys(locate_mistake(*named) for named in mistakes))
    return Diagnosis(names, " ".join(sentences), signature=signature)


class _SetExplanation:
    """Compares a claimed set with the expected conditions by the configurations that they contain.

    Each condition is a list of pieces.
    """

    def __init__(self, problem: Problem, part: Part, claimed: Sequence[Piece], seed: str) -> None:
        assert isinstance(part.answer, ConditionSet)
        joints, roles = [q.name for q in problem.chain.q], problem.domain.roles
        trees = part.answer.group_by_condition([tree for (tree,) in part.answer.parse_trees(roles)])
        self.chain, self.components, self.claimed, self.seed = problem.chain, part.answer.components, claimed, seed
        self.space = ConfigurationSpace(joints, problem.domain, part.rounding)
        self.expected = [[piece for tree in group for piece in parse_pieces(tree, joints)] for group in trees]
        self.comparison = self._compare(claimed, [piece for group in self.expected for piece in group])

    def _compare(self, pieces: Sequence[Piece], other_pieces: Sequence[Piece]) -> SetComparison:
        return compare_sets(pieces, other_pieces, self.space, self.seed)

    def explain_wrong_values(self, wrong_pieces: Sequence[Piece]) -> Iterator[tuple[str, Mapping[str, object]]]:
        """Yield for each joint with wrong values the name of the mistake behind them, and its words."""
        singular_joints = {q.name for component in self.components for q, _ in component.solutions or ()}
        for joint in dict.fromkeys(str(piece[0].joint) for piece in wrong_pieces):
            joint_pieces = [piece for piece in wrong_pieces if piece[0].joint == joint]
            values = ", ".join(_value_text(piece[0].expression) for piece in joint_pieces)
            if any(self._contained_pieces(joint_pieces, group) for group in self.expected):
                yield "condition-of-several-forgotten", {"joint": joint}
            else:
                name = "value-called-singular" if joint in singular_joints else "joint-called-singular"
                yield name, {"joint": joint, "values": values, "zero": zero_question(self.chain)}

    def explain_missing_conditions(self, wrong_pieces: Sequence[Piece]) -> Iterator[tuple[str, Mapping[str, object]]]:
        """Yield for each condition that is missing or incomplete the name of the mistake behind it, and its words."""
        for k, (component, condition) in enumerate(zip(self.components, self.expected, strict=True)):
            contained_pieces = self._contained_pieces(wrong_pieces, condition)
            if False not in self._compare(condition, self.claimed).is_sound or len(contained_pieces) == len(condition):
                continue
            other_pieces = [piece for group in self.expected[:k] + self.expected[k + 1 :] for piece in group]
            correct_pieces = [piece for piece in self.claimed if piece not in wrong_pieces]
            given_pieces = contained_pieces or [
                piece for piece in correct_pieces if self._compare([piece], other_pieces).is_sound == (False,)
            ]
            yield ("one-root-only", {}) if given_pieces else name_missed_component(self.chain, component)

    def _contained_pieces(self, claimed: Sequence[Piece], condition: Sequence[Piece]) -> list[Piece]:
        """Return the pieces of a condition that the claimed pieces contain."""
        are_contained = self._compare(condition, claimed).is_sound if claimed else ()
        return [piece for piece, is_contained in zip(condition, are_contained, strict=False) if is_contained]


def _value_text(value: Node) -> str:
    """Return a value in ordinary notation, without brackets around it.

    >>> from qdot.exercises.formula.parser import parse_formula
    >>> [_value_text(parse_formula(text, {})) for text in ("-pi/2", "1/3", "-acos(1/3)", "pi - 1")]
    ['-pi/2', '1/3', '-acos((1/3))', 'pi-1']
    """
    if value.kind == "neg" and value.args[0].kind not in ("+", "-"):
        return f"-{_value_text(value.args[0])}"
    text = node_text(value)
    return text[1:-1] if text.startswith("(") else text


# --- comparison of sets as written ---


class _Fingerprinter:
    """Identifies the pieces of sets by numeric values, computed for random values of all symbols."""

    def __init__(self, problem: Problem, seed: str) -> None:
        self.values = sample_values(problem.domain, SAMPLE_COUNT, Stream(f"{seed}/sets"))
        self.joints = {q.name: joint.kind for q, joint in zip(problem.chain.q, problem.chain.joints, strict=True)}

    def is_plain(self, piece: Piece) -> bool:
        """Return whether each condition of a piece gives a value of a joint or ties several joints."""
        joint_counts = [(atom.joint, len(find_names(atom.expression) & set(self.joints))) for atom in piece]
        return all(count > 1 if joint is None else count == 0 for joint, count in joint_counts)

    def fingerprint_pieces(self, pieces: Sequence[Piece]) -> SetFingerprint:
        """Return the fingerprints of the pieces of a typed set."""
        programs = ([(atom.joint, compile_program([atom.expression])) for atom in piece] for piece in pieces)
        return self._collect(frozenset(starmap(self._fingerprint, piece)) for piece in programs)

    def fingerprint_answer(self, answer: Answer) -> SetFingerprint:
        """Return the fingerprints of the pieces of a reference, or of a mistaken answer."""
        assert isinstance(answer, ConditionSet)
        return self._collect(chain.from_iterable(map(self._fingerprint_component, answer.components)))

    def _fingerprint_component(self, component: Component) -> Iterator[frozenset[ConditionFingerprint]]:
        if component.solutions is None:
            yield frozenset(
                self._fingerprint(None, compile_expression(condition)) for condition in component.conditions
            )
            return
        joints = [q.name for q, _ in component.solutions]
        for combination in product(*(values for _, values in component.solutions)):
            pairs = zip(joints, combination, strict=True)
            yield frozenset(self._fingerprint(joint, compile_expression(value)) for joint, value in pairs)

    def _collect(self, pieces: Iterator[frozenset[ConditionFingerprint]]) -> SetFingerprint:
        distinct_pieces = set(pieces)
        # Drop pieces that a wider piece contains.
        widest_pieces = {
            piece for piece in distinct_pieces if not any(wider_piece < piece for wider_piece in distinct_pieces)
        }
        values = frozenset(piece for piece in widest_pieces if all(joint for joint, _ in piece))
        return SetFingerprint(values, frozenset(widest_pieces) - values)

    def _fingerprint(self, joint: str | None, program: Program) -> ConditionFingerprint:
        values = evaluate(program, self.values, SAMPLE_COUNT)[0][0]
        with np.errstate(all="ignore"):
            if joint is None:
                values = values / values[0]
            elif self.joints[joint] == "R":
                turns = values.real / (2 * np.pi)
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
    return all(len(a) == len(b) and _are_near(a, b) and _are_near(b, a) for a, b in pairs)


def _are_near(
    pieces: frozenset[frozenset[ConditionFingerprint]], other_pieces: frozenset[frozenset[ConditionFingerprint]]
) -> bool:
    """Return whether each piece equals one of the others except for rounded constants."""
    return all(
        any(len(piece) == len(other_piece) and _is_near(piece, other_piece) for other_piece in other_pieces)
        for piece in pieces
    )


def _is_near(piece: frozenset[ConditionFingerprint], other: frozenset[ConditionFingerprint]) -> bool:
    return all(any(joint == name and _differ_by_rounding(a, b) for name, b in other) for joint, a in piece)


def _differ_by_rounding(values: Sequence[complex], exact_values: Sequence[complex]) -> bool:
    a, b = np.array(values), np.array(exact_values)
    return bool((np.abs(a - b) <= CONSTANT_TOLERANCE * np.maximum(1.0, np.abs(b)) / (2 * np.pi)).all())
