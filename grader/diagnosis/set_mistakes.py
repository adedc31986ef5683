"""The mistake behind a wrong set of singular configurations, or what is wrong in it, piece by piece.

A piece that gives values of joints is told by these values, one that ties several joints by the values of what vanishes
up to a factor. Only what is written in another form, or what no mistake gives, is compared by its configurations, which
takes its time.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from qdot.exercises.answers import ConditionSet
from qdot.exercises.arm.arithmetic import program_of
from qdot.exercises.arm.singularity import Component
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import SetComparison, Space, compare_sets
from qdot.exercises.formula.identity import READABLE
from qdot.exercises.formula.program import Program, compile_program, evaluate
from qdot.exercises.formula.set_parser import Piece, parse_claims, parse_pieces
from qdot.exercises.formula.trees import Node, ReadError, digits_of_decimals, names, node_text
from qdot.exercises.mistakes.base import Mistake, MistakenAnswer
from qdot.exercises.mistakes.catalogue import (
    ALIKE,
    CATALOGUE,
    NO_WEIGHTS,
    MistakeWeights,
    mistake_frequency,
    mistaken_answers,
)
from qdot.exercises.mistakes.configurations import Values
from qdot.exercises.mistakes.sets import missed_mistake, zero_there
from qdot.exercises.problem.problem import Part, Problem
from qdot.grader.diagnosis.rounding import EXACTLY, NEAR
from qdot.grader.judging.answer import ParsedAnswer, with_joint
from qdot.grader.judging.judge import judge_given
from qdot.grader.judging.verdict import Diagnosis, Outcome, locate_mistake

POINTS = 3
MOST_SAID = 3
"""Things that are said of one set."""
DIGITS = 6

Mark = tuple[str, tuple[complex, ...]]
"""A joint and its values at some configurations, or no joint and what vanishes, up to a factor."""


@dataclass(frozen=True)
class Marks:
    """A set as it is written: the pieces that are values of joints, and the others."""

    values: frozenset[frozenset[Mark]]
    ties: frozenset[frozenset[Mark]]


def behind_set(
    problem: Problem, part: Part, given: ParsedAnswer, seed: str, mistake_weights: MistakeWeights = NO_WEIGHTS
) -> Diagnosis | None:
    """Return the mistake that makes the right set one that was given, or what is wrong in this."""
    if given.tree is None:
        return None
    joints = [q.name for q in problem.chain.q]
    try:
        pieces = parse_claims(with_joint(given.tree, joints), joints)
    except ReadError:
        return None
    look = _Look(problem, seed)
    if not all(map(look.is_plain, pieces)):
        return _as_configurations(problem, part, given, seed) or _piece_by_piece(problem, part, pieces, seed)
    mine = look.marks_of(pieces)
    if look.is_rounded(mine, MistakenAnswer(part.answer), digits_of_decimals(given.tree) > 0):
        return Diagnosis((), EXACTLY)
    made = [
        (mistake, slip)
        for mistake, slip in mistaken_answers(problem.chain, part)
        if isinstance(slip.answer, ConditionSet)
    ]
    for mistake, slip in made:
        if look.is_same(mine, slip) or (
            look.may_be_same(mine, slip) and _judged(problem, part, given, slip, seed) is Outcome.CORRECT
        ):
            return _told(problem, part, mistake, slip, look, mistake_weights)
    return _piece_by_piece(problem, part, pieces, seed)


def _piece_by_piece(problem: Problem, part: Part, claimed: Sequence[Piece], seed: str) -> Diagnosis | None:
    """Return which claims are not singular, and of which conditions some or all is missing, each seen by itself."""
    claims = _Claims(problem, part, claimed, seed)
    compared = claims.compared
    wrong = [piece for piece, is_sound in zip(claimed, compared.sound, strict=True) if is_sound is False]
    if compared.rounded or any(len(piece) > 1 or piece[0].joint is None for piece in wrong):
        return None
    said = [*claims.called_singular(wrong), *claims.missing(wrong)]
    if not 0 < len(said) <= MOST_SAID:
        return None
    says = dict.fromkeys(CATALOGUE[name].sentence(words) for name, words in said)
    names = tuple(dict.fromkeys(name for name, _ in said))
    return Diagnosis(names, " ".join(says), known_by=tuple(dict.fromkeys(locate_mistake(*each) for each in said)))


class _Claims:
    """A claimed set and the conditions that are due, a list of pieces each, compared by their configurations."""

    def __init__(self, problem: Problem, part: Part, claimed: Sequence[Piece], seed: str) -> None:
        assert isinstance(part.answer, ConditionSet)
        joints, roles = [q.name for q in problem.chain.q], problem.domain().roles
        trees = part.answer.by_condition([tree for (tree,) in part.answer.trees(roles)])
        self.chain, self.components, self.claimed, self.seed = problem.chain, part.answer.components, claimed, seed
        self.space = Space(joints, problem.domain(), part.rounding)
        self.due = [[piece for tree in group for piece in parse_pieces(tree, joints)] for group in trees]
        self.compared = self._compare(claimed, [piece for group in self.due for piece in group])

    def _compare(self, some: Sequence[Piece], others: Sequence[Piece]) -> SetComparison:
        return compare_sets(some, others, self.space, self.seed)

    def called_singular(self, wrong: Sequence[Piece]) -> Iterator[tuple[str, Mapping[str, object]]]:
        """Yield the mistake behind the wrong values of each joint, with its words."""
        due = {q.name for component in self.components for q, _ in component.solutions or ()}
        for joint in dict.fromkeys(str(piece[0].joint) for piece in wrong):
            own = [piece for piece in wrong if piece[0].joint == joint]
            values = ", ".join(_as_written(piece[0].zero) for piece in own)
            if any(self._within(own, group) for group in self.due):
                yield "condition-of-several-forgotten", {"joint": joint}
            else:
                name = "value-called-singular" if joint in due else "joint-called-singular"
                yield name, {"joint": joint, "values": values, "zero": zero_there(self.chain)}

    def missing(self, wrong: Sequence[Piece]) -> Iterator[tuple[str, Mapping[str, object]]]:
        """Yield the mistake behind each condition that is missing or given in part, with its words."""
        for k, (component, own) in enumerate(zip(self.components, self.due, strict=True)):
            within = self._within(wrong, own)
            if False not in self._compare(own, self.claimed).sound or len(within) == len(own):
                continue
            others = [piece for group in self.due[:k] + self.due[k + 1 :] for piece in group]
            rest = [piece for piece in self.claimed if piece not in wrong]
            in_part = within or [piece for piece in rest if self._compare([piece], others).sound == (False,)]
            yield ("one-root-only", {}) if in_part else missed_mistake(self.chain, component)

    def _within(self, claimed: Sequence[Piece], due: Sequence[Piece]) -> list[Piece]:
        """Return the pieces of a condition that lie in what is claimed."""
        held = self._compare(due, claimed).sound if claimed else ()
        return [piece for piece, is_held in zip(due, held, strict=False) if is_held]


def _as_written(value: Node) -> str:
    """Return a value as people write it, with no brackets around it.

    >>> from qdot.exercises.formula.expression import read
    >>> [_as_written(read(text, {})) for text in ("-pi/2", "1/3", "-acos(1/3)", "pi - 1")]
    ['-pi/2', '1/3', '-acos((1/3))', 'pi-1']
    """
    if value.kind == "neg" and value.args[0].kind not in ("+", "-"):
        return f"-{_as_written(value.args[0])}"
    text = node_text(value)
    return text[1:-1] if text.startswith("(") else text


def _likeliest(
    problem: Problem, part: Part, mistake: Mistake, slip: MistakenAnswer, look: "_Look", mistake_weights: MistakeWeights
) -> list[tuple[Mistake, MistakenAnswer]]:
    """Return a mistake and those as likely that give the same set; likelier ones in their place."""
    marks = look.of(slip)
    same = [(mistake, slip)]
    for name in ALIKE.get(mistake.name, ()):
        others = CATALOGUE[name].takes(problem.chain, part)
        same += [(CATALOGUE[name], other) for other in others if look.is_same(marks, other)][:1]
    most = max(mistake_frequency(one, mistake_weights) for one, _ in same)
    return [(one, taken_for) for one, taken_for in same if mistake_frequency(one, mistake_weights) == most]


def _told(
    problem: Problem, part: Part, mistake: Mistake, slip: MistakenAnswer, look: "_Look", mistake_weights: MistakeWeights
) -> Diagnosis:
    """Return what is said of a mistake, and of one as likely that gives the same set; of a likelier one alone."""
    told = _likeliest(problem, part, mistake, slip, look, mistake_weights)
    says = " Or, which gives the same answer: ".join(one.sentence(taken_for.words) for one, taken_for in told)
    made = tuple(locate_mistake(one.name, taken_for.words) for one, taken_for in told)
    return Diagnosis(tuple(one.name for one, _ in told), says, known_by=made, either=len(told) > 1)


def _as_configurations(problem: Problem, part: Part, given: ParsedAnswer, seed: str) -> Diagnosis | None:
    for mistake, slip in mistaken_answers(problem.chain, part):
        if _judged(problem, part, given, slip, seed) is Outcome.CORRECT:
            return Diagnosis(
                (mistake.name,), mistake.sentence(slip.words), known_by=(locate_mistake(mistake.name, slip.words),)
            )
    return None


def _judged(problem: Problem, part: Part, given: ParsedAnswer, slip: MistakenAnswer, seed: str) -> Outcome:
    try:
        return judge_given(problem, replace(part, answer=slip.answer), given, seed).outcome
    except ReadError:  # what the mistake gives is no set
        return Outcome.WRONG


class _Look:
    """Looks at sets at some values of all symbols."""

    def __init__(self, problem: Problem, seed: str) -> None:
        domain = problem.domain()
        drawn = domain.sample(set(domain.roles), READABLE + POINTS, Stream(f"{seed}/sets"))
        self.values: Values = {name: column[READABLE:] for name, column in drawn.items()}
        self.joints = {q.name: joint.kind for q, joint in zip(problem.chain.q, problem.chain.joints, strict=True)}

    def is_plain(self, piece: Piece) -> bool:
        """Tell whether a piece gives values of joints, or ties several."""
        for atom in piece:
            tied = len(names(atom.zero) & set(self.joints))
            if (tied > 0) if atom.joint is not None else (tied < 2):
                return False
        return True

    def marks_of(self, pieces: Sequence[Piece]) -> Marks:
        """Return a set that was typed."""
        return self._sorted(
            frozenset(self._mark(atom.joint, compile_program([atom.zero])) for atom in piece) for piece in pieces
        )

    def of(self, slip: MistakenAnswer) -> Marks:
        """Return a set that a mistake gives."""
        assert isinstance(slip.answer, ConditionSet)
        return self._sorted(piece for component in slip.answer.components for piece in self._of_component(component))

    def _of_component(self, component: Component) -> Iterator[frozenset[Mark]]:
        if component.solutions is None:
            yield frozenset(self._mark(None, program_of(condition)) for condition in component.conditions)
            return
        for combination in product(*(values for _, values in component.solutions)):
            joints = (q.name for q, _ in component.solutions)
            yield frozenset(
                self._mark(joint, program_of(value)) for joint, value in zip(joints, combination, strict=True)
            )

    def _sorted(self, pieces: Iterator[frozenset[Mark]]) -> Marks:
        listed = set(pieces)
        known = {
            piece for piece in listed if not any(other < piece for other in listed)
        }  # what holds more often counts
        values = frozenset(piece for piece in known if all(joint for joint, _ in piece))
        return Marks(values, frozenset(known) - values)

    def _mark(self, joint: str | None, program: Program) -> Mark:
        found = evaluate(program, self.values, POINTS)[0][0]
        with np.errstate(all="ignore"):
            if joint is None:
                found = found / found[0]
            elif self.joints[joint] == "R":
                turns = found.real / (2 * np.pi)
                found = np.round(turns - np.floor(turns + 10.0**-DIGITS), DIGITS) + 0.0
        return (joint or "", tuple(np.round(np.nan_to_num(found, nan=1e9), DIGITS).tolist()))

    def is_same(self, mine: Marks, slip: MistakenAnswer) -> bool:
        """Tell whether a set is the same, piece by piece."""
        return isinstance(slip.answer, ConditionSet) and self.of(slip) == mine

    def is_rounded(self, mine: Marks, due: MistakenAnswer, has_decimals: bool) -> bool:
        """Tell whether a set is the one that is due, or near to it where decimals stand for constants."""
        if not has_decimals:
            return self.is_same(mine, due)
        other = self.of(due)
        pairs = ((mine.values, other.values), (mine.ties, other.ties))
        return all(len(own) == len(right) and _are_near(own, right) and _are_near(right, own) for own, right in pairs)

    def may_be_same(self, mine: Marks, slip: MistakenAnswer) -> bool:
        """Tell whether a set may be the same with what ties joints in another form."""
        other = self.of(slip)
        return bool(mine.ties) and mine.values == other.values and len(mine.ties) == len(other.ties)


def _are_near(some: frozenset[frozenset[Mark]], others: frozenset[frozenset[Mark]]) -> bool:
    """Tell whether each of some pieces has one among others that decimals for its constants make of it."""
    return all(any(_is_near(piece, other) for other in others) for piece in some)


def _is_near(piece: frozenset[Mark], other: frozenset[Mark]) -> bool:
    if len(piece) != len(other):
        return False
    return all(any(joint == name and _by_rounding(own, due) for name, due in other) for joint, own in piece)


def _by_rounding(own: Sequence[complex], due: Sequence[complex]) -> bool:
    return all(
        abs(one - right) <= NEAR * max(1.0, abs(right)) / (2 * np.pi) for one, right in zip(own, due, strict=True)
    )
