"""Judge a later part against what follows from the student's own wrong answer to an earlier part.

The parts of a problem build on one another (`Part.prerequisites`). A wrong earlier answer replaces the correct answer
in the derivation. The later answer is then judged against the result, in the same way as against the correct answer
(the reference). An unanswered part between the two parts is derived by the same method.

A wrong answer that would make the later part easier is not used. Such answers are:

- an answer that is undefined at some configurations
- an answer that changes if a revolute joint rotates by 360°
- an answer with more zeros than the reference
- a Jacobian that is singular at configurations that are regular
- a copy of another answer in the notebook, or of the correct answer to another student's problem

The result that follows must depend on as many joints as the reference. If the earlier answer is not a real attempt at
this arm, the later answer earns nothing, although the feedback says that it follows (see `marking`).
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, reduce
from itertools import product
from typing import NamedTuple

import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.arithmetic import NumericArithmetic, TreeArithmetic, determinant, list_rows
from qdot.exercises.derivation.graph import Change, StageResults, compute_numeric_stages, compute_tree_stages
from qdot.exercises.formula.algebra import Matrix as Rows
from qdot.exercises.formula.algebra import split_factors
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import ZERO, Node, ParseError, count_nodes, find_names
from qdot.exercises.mistakes.configurations import sample_configurations, sample_values
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions import QUESTIONS, find_question
from qdot.exercises.reference_answers import ConditionSet, Direction, Number
from qdot.exercises.short_questions import question_of
from qdot.grader.judging.answer_parser import ParsedAnswer
from qdot.grader.judging.formulas import (
    CONFIGURATION,
    SINGULAR_CONFIGURATION,
    judge_direction,
    judge_expression,
    judge_matrix,
    judge_numbers,
    judge_singular,
)
from qdot.grader.judging.verdict import Judgement

MAX_ROWS = 4
"""Maximum number of rows of a matrix whose determinant is derived as a formula."""
MAX_NODES = 3000
"""Maximum number of nodes in the trees of an earlier answer; the result that follows may have 20 times as many."""
SAMPLE_COUNT = 6
"""Number of random configurations at which answers are evaluated."""
ZERO_TOLERANCE = 1e-12
"""A formula is zero if its values are at most this share of its largest intermediate results."""


@dataclass(frozen=True)
class FollowThrough:
    """The judgement on an answer, compared with what follows from a wrong answer to the part `earlier_part`.

    `non_attempt_part` is an earlier part whose answer was used but is not a real attempt at this arm; None if there
    is none.
    """

    judgement: Judgement
    earlier_part: str
    non_attempt_part: str | None = None


RowsByPart = Mapping[str, Rows]
"""The formulas of each earlier part, in rows: the student's if the answer is wrong, otherwise the reference's."""


class Sources(NamedTuple):
    """Formulas of earlier parts from which a later answer may be derived, and the wrong answers among them."""

    rows_by_part: RowsByPart
    wrong_parts: list[str]


class SourceRows(NamedTuple):
    """The formulas of one earlier part, and the parts whose wrong answers lead to these formulas."""

    rows: Rows
    wrong_parts: list[str]


IsCopied = Callable[[Part, Rows], bool]
"""A function that returns whether a wrong answer to a part is correct for another student's problem."""


def never_copied(part: Part, rows: Rows) -> bool:
    """Return False: the answer is not copied from another student's problem."""
    return False


def find_follow_through(
    problem: Problem, part: Part, answers: Mapping[str, ParsedAnswer], wrong_parts: Sequence[str], seed: str,
    is_copied: IsCopied, attempt_parts: Collection[str],
) -> FollowThrough | None:  # fmt: skip
    """Return the best judgement on an answer, compared with what follows from earlier wrong answers.

    Return None if nothing in the answer follows. `answers` maps the name of each part to its answer. `wrong_parts`
    lists the earlier parts with wrong answers, and `attempt_parts` the parts whose answers are real attempts at this
    arm. `is_copied` returns whether an answer is correct for another student's problem.
    """
    answer = answers[part.name]
    if answer.refusal is not None or answer.table is not None or find_question(part) is None:
        return None
    context = _Context(problem, answers, wrong_parts, f"{seed}/follow", is_copied)
    results: list[FollowThrough] = []
    for sources in context.find_sources(part):
        derived_answer = context.derive(part, sources.rows_by_part)
        judgement = None if derived_answer is None else context.judge(part, derived_answer, answer)
        if judgement is not None and judgement.share > 0:
            non_attempt_part = next((name for name in sources.wrong_parts if name not in attempt_parts), None)
            results.append(FollowThrough(judgement, sources.wrong_parts[0], non_attempt_part))
    return max(results, key=lambda result: (result.non_attempt_part is None, result.judgement.share), default=None)


@dataclass(frozen=True)
class _Context:
    """What a later answer is derived from: a problem, the student's answers, and random values of all symbols."""

    problem: Problem
    answers: Mapping[str, ParsedAnswer]
    wrong_parts: Sequence[str]
    seed: str
    is_copied: IsCopied

    @cached_property
    def domain(self) -> Domain:
        """The domain of the problem's symbols."""
        return self.problem.domain

    @cached_property
    def parts(self) -> dict[str, Part]:
        """Maps names to parts: those of the problem, and other parts of the derivation once they are needed."""
        return {part.name: part for part in self.problem.parts}

    @cached_property
    def values(self) -> dict[str, np.ndarray]:
        """Random values of all symbols, an array of `SAMPLE_COUNT` values each."""
        return sample_values(self.domain, SAMPLE_COUNT, Stream(self.seed))

    def find_sources(self, part: Part) -> Iterator[Sources]:
        """Yield each set of answers from which the answer to a part may be derived, if one of them is wrong."""
        for prerequisites in question_of(part).prerequisite_sets:
            sources = {name: source for name in prerequisites if (source := self.find_source_rows(name))}
            wrong_parts = list(dict.fromkeys(name for source in sources.values() for name in source.wrong_parts))
            if wrong_parts and len(sources) == len({*prerequisites}):  # every prerequisite is usable
                yield Sources({name: source.rows for name, source in sources.items()}, wrong_parts)

    def find_source_rows(self, name: str) -> SourceRows | None:
        """Return the formulas of a part; None if a later answer must not be derived from them.

        If the student's answer is wrong, the rows of that answer are returned. If there is no answer, the rows are
        derived from earlier answers. Otherwise the rows of the reference are returned.
        """
        part, parsed_answer = self.find_part(name), self.answers.get(name)
        reference = None if part is None else self.find_reference_rows(part)
        if part is None or reference is None:
            return None
        if parsed_answer is None or parsed_answer.refusal is not None:
            for sources in self.find_sources(part):
                rows = self.derive(part, sources.rows_by_part)
                if isinstance(rows, list) and self.is_as_hard(rows, reference):
                    return SourceRows(rows, sources.wrong_parts)
        elif name in self.wrong_parts:
            if parsed_answer.rows and self.is_usable(part, parsed_answer, reference):
                return SourceRows(parsed_answer.rows, [name])
            return None
        return SourceRows(reference, [])

    def find_part(self, name: str) -> Part | None:
        """Return a part, even if this problem doesn't contain it; None if the question doesn't apply to this arm."""
        if name not in self.parts:
            question = QUESTIONS[name]
            if question.find_obstacle(self.problem.chain) is not None:
                return None
            answer, details = question.ask(self.problem.chain, Stream(f"{self.seed}/{name}"))
            self.parts[name] = Part(name, name, answer, question.points, question.prerequisites, details)
        return self.parts[name]

    def find_reference_rows(self, part: Part) -> Rows | None:
        """Return the rows of the correct answer to a part; None if this answer is not made of formulas."""
        is_in_formulas = part.answer.list_entries() and not part.answer.is_numeric
        return part.answer.parse_trees(self.domain.roles) if is_in_formulas else None

    # --- wrong answers that are not used ---

    def is_usable(self, part: Part, parsed_answer: ParsedAnswer, reference: Rows) -> bool:
        """Return whether a later answer may be derived from a wrong answer; `reference` is the correct answer."""
        rows = parsed_answer.rows
        if rows is None or (len(rows), len(rows[0])) != (len(reference), len(reference[0])):
            return False
        is_long = sum(map(count_nodes, parsed_answer.entries)) > MAX_NODES
        if is_long or any(parsed_answer.is_blank) or not self._has_known_symbols(parsed_answer):
            return False
        if self._is_copy(part, rows) or self.is_copied(part, rows):
            return False
        is_square_jacobian = part.name == "jacobian" and 1 < len(reference) == len(reference[0]) <= MAX_ROWS
        if is_square_jacobian and not self.is_as_hard(_compute_determinant(rows), _compute_determinant(reference)):
            return False
        return self._compute_traits(rows).is_as_full(self._compute_traits(reference))

    def _has_known_symbols(self, parsed_answer: ParsedAnswer) -> bool:
        """Return whether the problem defines all symbols in an answer."""
        return not parsed_answer.symbols - set(self.domain.roles)

    def _is_copy(self, part: Part, rows: Rows) -> bool:
        """Return whether rows equal the answer to another part at random configurations."""
        values = self._evaluate(rows)
        for name, other_answer in self.answers.items():
            is_comparable = bool(other_answer.rows) and len(other_answer.text) <= 10 * MAX_NODES  # not too long
            if name == part.name or not is_comparable or not self._has_known_symbols(other_answer):
                continue
            with suppress(ParseError):  # raised if entries of the other answer contain statements or blanks
                other_values = self._evaluate(other_answer.rows or ())
                if other_values.shape == values.shape and np.allclose(other_values, values, rtol=1e-9, atol=0):
                    return True
        return False

    def _evaluate(self, rows: Rows) -> np.ndarray:
        """Return the values of rows at the random configurations, (entries, `SAMPLE_COUNT`)."""
        return evaluate(compile_program([entry for row in rows for entry in row]), self.values, SAMPLE_COUNT).values

    def is_as_hard(self, rows: Rows, reference: Rows) -> bool:
        """Return whether rows depend on as many joints as a reference, and don't have clearly more zeros."""
        traits, expected_traits = self._compute_traits(rows), self._compute_traits(reference)
        return traits.is_as_full(expected_traits) and traits.joint_count >= expected_traits.joint_count

    def _compute_traits(self, rows: Rows) -> "Traits":
        """Return the traits of an answer, found by evaluating it at random configurations.

        To find out whether the answer depends on a symbol, all values of the symbol are changed arbitrarily.
        """
        entries = [entry for row in rows for entry in row]
        program, roles = compile_program(entries), self.domain.roles
        values_at_samples = evaluate(program, self.values, SAMPLE_COUNT).values
        largest_value = float(np.nanmax(np.abs(values_at_samples), initial=0.0))

        def changes_at(values: Mapping[str, np.ndarray], tolerance: float) -> bool:
            """Return whether the answer has other values at these values of the symbols."""
            with np.errstate(all="ignore"):
                changes = np.abs(evaluate(program, values, SAMPLE_COUNT).values - values_at_samples)
                return not np.all(changes <= tolerance * largest_value)

        joints = {q.name for q in self.problem.chain.q}
        typed_symbols = {name for name in set().union(*map(find_names, entries)) if isinstance(roles[name], str)}
        changed_values = {name: {**self.values, name: 0.83 * self.values[name] + 0.11} for name in typed_symbols}
        influential_symbols = {name for name, values in changed_values.items() if changes_at(values, 1e-9)}
        rotated_values = {name: value + 2 * np.pi * (roles[name] == "angle") for name, value in self.values.items()}
        is_finite = bool(np.isfinite(values_at_samples).all())
        is_periodic = not changes_at(rotated_values, 1e-6)
        nonzero_count = int(np.count_nonzero(np.abs(values_at_samples).max(axis=1) > 1e-9 * largest_value))
        counts = len(influential_symbols & joints), len(influential_symbols - joints), nonzero_count
        return Traits(is_finite, is_periodic, *counts)

    # --- the result that follows ---

    def derive(self, part: Part, rows_by_part: RowsByPart) -> "Rows | np.ndarray | None":
        """Return the answer that follows from the rows of earlier parts; None if there is none or it is too long.

        The answer consists of rows of formulas, or is an array of numbers if the question asks for numbers.
        """
        question = question_of(part)
        compute_rows = question.compute_zero or question.compute
        is_long = question.is_long_in_formulas and any(len(rows) > MAX_ROWS for rows in rows_by_part.values())
        if compute_rows is None or is_long:
            return None
        try:
            if part.answer.is_numeric:
                values = sample_configurations(self.problem.chain, part, self.domain, 1, Stream(self.seed))
                stages = compute_numeric_stages(self.problem.chain, values)
                numeric_rows = {name: _evaluate_rows(stages, name, rows) for name, rows in rows_by_part.items()}
                stages = _substitute(stages, numeric_rows)
                return compute_rows(stages, part.details)[..., 0].ravel().astype(float)
            tree_rows = {name: TreeArithmetic.stack_rows(rows) for name, rows in rows_by_part.items()}
            stages = _substitute(compute_tree_stages(self.problem.chain), tree_rows)
            rows = list_rows(compute_rows(stages, part.details))
            is_short = sum(count_nodes(entry) for row in rows for entry in row) <= 20 * MAX_NODES
            return self._write_zeros(rows) if is_short else None
        except ParseError:
            return None

    def _write_zeros(self, rows: Rows) -> Rows:
        """Return rows with 0 instead of formulas whose terms cancel, because an entry of 0 earns no points."""
        entries = [entry for row in rows for entry in row]
        values, magnitudes = evaluate(compile_program(entries), self.values, SAMPLE_COUNT)
        is_zero = iter((np.abs(values) <= ZERO_TOLERANCE * magnitudes).all(axis=1))
        return [[ZERO if next(is_zero) else entry for entry in row] for row in rows]

    def judge(self, part: Part, derived_answer: "Rows | np.ndarray", answer: ParsedAnswer) -> Judgement | None:
        """Return the judgement on an answer, compared with the answer that follows from a wrong answer.

        Return None if `derived_answer` is unusable or easier than the correct answer.
        """
        if isinstance(derived_answer, np.ndarray):
            return self._judge_numbers(part, derived_answer, answer)
        reference = self.derive(part, {}) if part.answer.is_set else self.find_reference_rows(part)
        if not isinstance(reference, list) or not self.is_as_hard(derived_answer, reference):
            return None
        if part.answer.is_set:
            return self._judge_set(part, derived_answer, answer)
        if part.shape is None:
            return judge_expression(answer, derived_answer[0][0], self.domain, self.seed, part.rounding)
        if part.answer.is_direction:
            return judge_direction(answer, [row[0] for row in derived_answer], self.domain, self.seed)
        return judge_matrix(answer, derived_answer, self.domain, self.seed, part.rounding)

    def _judge_set(self, part: Part, formulas: Rows, answer: ParsedAnswer) -> Judgement:
        """Return the judgement on a set, compared with the configurations at which all formulas, (k, 1), are zero."""
        joints = [q.name for q in self.problem.chain.q]
        factors = [
            [factor for factor in split_factors(formula) if find_names(factor) & set(joints)] for (formula,) in formulas
        ]
        conditions = []
        for combination in product(*factors):  # all formulas are zero if one factor of each is zero
            equations = [Node("eq", (factor, ZERO)) for factor in combination]
            conditions.append([reduce(lambda a, b: Node("and", (a, b)), equations)])
        noun = SINGULAR_CONFIGURATION if part.answer_as(ConditionSet).is_singular_set else CONFIGURATION
        return judge_singular(answer, conditions, joints, self.domain, self.seed, part.rounding, noun)

    def _judge_numbers(self, part: Part, values: np.ndarray, answer: ParsedAnswer) -> Judgement | None:
        """Return the judgement on numbers, compared with derived `values`; None if one of these is infinite or zero."""
        largest_value = float(np.abs(values).max(initial=0.0))
        if not np.isfinite(values).all() or np.count_nonzero(np.abs(values) > 1e-6 * largest_value) < len(values):
            return None
        if part.answer.is_direction:
            entries = [Node("decimal", value=Fraction(repr(float(value)))) for value in values]
            tolerance = part.answer_as(Direction).find_tolerance(part.rounding)
            return judge_direction(answer, entries, self.domain, self.seed, tolerance)
        number = part.answer_as(Number)
        tolerance = number.find_allowed_errors(part.rounding).relative
        floors = len(values) * [0.001 * largest_value]  # a thousandth of the largest number
        return judge_numbers(answer, values.tolist(), number.units, tolerance or number.tolerance, floors)


def _substitute(stages: StageResults, rows_by_part: Mapping[str, np.ndarray]) -> StageResults:
    """Return a derivation that uses these answers to earlier parts, arrays of shape (rows, columns, …)."""
    changes: dict[str, Change] = {}
    for name, rows in rows_by_part.items():
        substitution = QUESTIONS[name].substitution
        assert substitution is not None, name
        changes.update(substitution(rows))
    return stages.with_mistakes(changes)


def _evaluate_rows(stages: StageResults, part_name: str, rows: Rows) -> np.ndarray:
    """Return the values of an answer's rows at one configuration, of shape (rows, columns, 1).

    If the derivation differentiates the answer, the values include derivatives (`NumericArithmetic.evaluate_stepped`).
    """
    arithmetic = stages.arithmetic
    assert isinstance(arithmetic, NumericArithmetic)
    entries = [entry for row in rows for entry in row]
    names = set().union(*map(find_names, entries)) & set(arithmetic.values)
    entry_values = arithmetic.evaluate_stepped(compile_program(entries), names)
    values = entry_values.reshape(len(rows), -1, *entry_values.shape[1:])
    return values if QUESTIONS[part_name].differentiates_substitute else arithmetic.drop_derivatives(values)


def _compute_determinant(rows: Rows) -> Rows:
    """Return the determinant of a small matrix as a matrix with one entry."""
    return list_rows(determinant(TreeArithmetic.stack_rows(rows)))


@dataclass(frozen=True)
class Traits:
    """The traits of an answer at random configurations.

    `is_finite` is whether the answer is defined. `is_periodic` is whether the answer stays the same if revolute joints
    rotate by 360°. `joint_count` and `other_symbol_count` are the numbers of joints and other symbols on which the
    answer depends. `nonzero_entry_count` is the number of nonzero entries.
    """

    is_finite: bool
    is_periodic: bool
    joint_count: int
    other_symbol_count: int
    nonzero_entry_count: int

    def is_as_full(self, reference: "Traits") -> bool:
        """Return whether the answer is defined and periodic, and has more than half of the reference's nonzero entries.

        Not counting joint variables, the answer may depend on one symbol fewer than the reference.
        """
        is_full = not reference.nonzero_entry_count or 2 * self.nonzero_entry_count > reference.nonzero_entry_count
        has_symbols = self.other_symbol_count >= reference.other_symbol_count - 1
        return self.is_finite and self.is_periodic and has_symbols and is_full
