"""Mark a later part by what follows from the student's own earlier answer, where that was wrong.

The parts of a problem build on one another (`Part.needs`). An earlier answer that is wrong is put in the place of the
reference, and the later one is judged against what follows from it: by trees, exactly as against a reference. A part
between them that was not answered is worked out in the same way. Nothing follows from an answer that makes the later
part easier than it is: one that is undefined, not made of sines and cosines of the joints, has more zeros, is singular
where it should not be, or is a copy of another of the answers or of the right answer to somebody else's problem; what
follows depends on as many joints as what is due. What follows from an answer that is no attempt at this arm is told,
and earns nothing (`term_overlap`, `marking`).
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from qdot.exercises.answers import Direction, Number
from qdot.exercises.arm.arithmetic import Trees, determinant
from qdot.exercises.arm.derivation_graph import Change, Working, numbers, trees
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.algebra import ZERO, factors
from qdot.exercises.formula.algebra import Matrix as Rows
from qdot.exercises.formula.identity import Domain
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node, ReadError, names, size_of
from qdot.exercises.mistakes.configurations import sample_configurations, sample_values
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions import QUESTIONS
from qdot.grader.judging.answer import ParsedAnswer
from qdot.grader.judging.formulas import judge_direction, judge_expression, judge_matrix, judge_numbers, judge_singular
from qdot.grader.judging.verdict import Judgement

MOST_ROWS = 4
"""Rows of the largest matrix of which the determinant is written out."""
LONGEST = 3000
"""Nodes of an answer from which something may follow, and 20 times that of what follows."""
POINTS = 6


@dataclass(frozen=True)
class Followed:
    """The judgement on an answer against what follows from an earlier one, and that part's name.

    It earns nothing where one of those that it follows from, `idle`, is no attempt at this arm.
    """

    judgement: Judgement
    earlier: str
    idle: str | None = None


RowsOfParts = Mapping[str, Rows]
"""The rows of each earlier part: the student's where these are wrong, else the reference's."""


IsCopied = Callable[[Part, Rows], bool]
"""Whether a wrong answer to a part is the right one to somebody else's problem."""


def nothing_copied(part: Part, rows: Rows) -> bool:
    """Tell that an answer is nobody else's."""
    return False


def follow(
    problem: Problem,
    part: Part,
    answers: Mapping[str, ParsedAnswer],
    wrong: Sequence[str],
    seed: str,
    is_copied: IsCopied = nothing_copied,
    attempts: Collection[str] | None = None,
) -> Followed | None:
    """Return the best judgement on an answer against what follows from an earlier wrong one; None where none does.

    `answers` are those to all parts, by part, `wrong` the earlier parts that were answered wrongly, `attempts` those of
    them that are attempts at this arm, None for all.
    """
    answer = answers[part.name]
    if answer.table is not None or part.kind not in QUESTIONS:
        return None
    context = _Context(problem, answers, wrong, f"{seed}/follow", is_copied)
    followed: list[Followed] = []
    for rows_of_parts, before in context.ways(part):
        derived = context.derive(part, rows_of_parts)
        judgement = None if derived is None else context.judge(part, derived, answer)
        if judgement is not None and judgement.share > 0:
            idle = next((name for name in before if attempts is not None and name not in attempts), None)
            followed.append(Followed(judgement, before[0], idle))
    return max(followed, key=lambda each: (each.idle is None, each.judgement.share), default=None)


@dataclass(frozen=True)
class _Context:
    """A problem with a student's answers, and values for its symbols."""

    problem: Problem
    answers: Mapping[str, ParsedAnswer]
    wrong: Sequence[str]
    seed: str
    is_copied: IsCopied

    @cached_property
    def domain(self) -> Domain:
        """The domain of the problem's symbols."""
        return self.problem.domain()

    @cached_property
    def parts(self) -> dict[str, Part]:
        """The parts by name, those that are asked and those between them that are not."""
        return {part.name: part for part in self.problem.parts}

    @cached_property
    def values(self) -> dict[str, np.ndarray]:
        """Random values of all symbols."""
        return sample_values(self.domain, POINTS, Stream(self.seed))

    def ways(self, part: Part) -> Iterator[tuple[RowsOfParts, list[str]]]:
        """Yield the rows from which an answer may be worked out, with the wrong answers that they come from."""
        for sources in QUESTIONS[part.kind].follows:
            usable = {name: rows for name in sources if (rows := self.rows(name)) is not None}
            before = list(dict.fromkeys(name for _, names_before in usable.values() for name in names_before))
            if before and len(usable) == len({*sources}):
                yield {name: rows for name, (rows, _) in usable.items()}, before

    def rows(self, name: str) -> tuple[Rows, list[str]] | None:
        """Return the rows of a part, with the wrong answers that they come from; None where they are of no use.

        They are the student's where these are wrong, what follows from earlier ones where there is no answer, else the
        reference's.
        """
        part, parsed_answer = self.part(name), self.answers.get(name)
        reference = None if part is None else self.reference(part)
        if part is None or reference is None:
            return None
        if parsed_answer is None or parsed_answer.refusal is not None:
            for rows_of_parts, before in self.ways(part):
                derived = self.derive(part, rows_of_parts)
                if derived is not None and not isinstance(derived, np.ndarray) and self.is_as_hard(derived, reference):
                    return derived, before
        elif name in self.wrong:
            return (
                (parsed_answer.rows, [name])
                if parsed_answer.rows and self.is_usable(part, parsed_answer, reference)
                else None
            )
        return reference, []

    def part(self, name: str) -> Part | None:
        """Return a part, whether or not it is asked in this problem; None where it can't be asked of this arm."""
        if name not in self.parts:
            question = QUESTIONS[name]
            if question.refusal(self.problem.chain) is not None:
                return None
            answer, details = question.ask(self.problem.chain, Stream(f"{self.seed}/{name}"))
            self.parts[name] = Part(name, name, answer, question.points, question.needs, details)
        return self.parts[name]

    def reference(self, part: Part) -> Rows | None:
        """Return the rows of a part's reference, None where it has none in formulas."""
        is_in_formulas = part.answer.entries() and not part.answer.is_in_numbers
        return part.answer.trees(self.domain.roles) if is_in_formulas else None

    # --- what is no attempt ---

    def is_usable(self, part: Part, parsed_answer: ParsedAnswer, reference: Rows) -> bool:
        """Tell whether something may follow from a wrong answer."""
        rows = parsed_answer.rows
        if rows is None or (len(rows), len(rows[0])) != (len(reference), len(reference[0])):
            return False
        if (
            any(parsed_answer.blanks)
            or not self._is_known(parsed_answer)
            or sum(map(size_of, parsed_answer.entries)) > LONGEST
        ):
            return False
        if self._is_copy(part, rows) or self.is_copied(part, rows):
            return False
        is_square = part.name == "jacobian" and 1 < len(reference) == len(reference[0]) <= MOST_ROWS
        if is_square and not self.is_as_hard(_determinant(rows), _determinant(reference)):
            return False
        return self._traits(rows).is_as_full(self._traits(reference))

    def _is_known(self, parsed_answer: ParsedAnswer) -> bool:
        return not parsed_answer.symbols - set(self.domain.roles)

    def _is_copy(self, part: Part, rows: Rows) -> bool:
        """Tell whether rows are, at random configurations, the answer to another part as well."""
        values = self._evaluate(rows)
        for name, parsed_answer in self.answers.items():
            if (
                name == part.name
                or not parsed_answer.rows
                or not self._is_known(parsed_answer)
                or len(parsed_answer.text) > 10 * LONGEST
            ):
                continue
            try:
                others = self._evaluate(parsed_answer.rows)
            except ReadError:  # statements or blanks are among its entries
                continue
            if others.shape == values.shape and np.allclose(others, values, rtol=1e-9, atol=0):
                return True
        return False

    def _evaluate(self, rows: Rows) -> np.ndarray:
        return evaluate(compile_program([entry for row in rows for entry in row]), self.values, POINTS)[0]

    def is_as_hard(self, rows: Rows, reference: Rows) -> bool:
        """Tell whether rows depend on as many joints as those of a reference, and have not clearly more zeros."""
        traits, expected = self._traits(rows), self._traits(reference)
        return traits.is_as_full(expected) and traits.joints >= expected.joints

    def _traits(self, rows: Rows) -> "Traits":
        """Return what an answer is like, at random configurations."""
        entries = [entry for row in rows for entry in row]
        program, roles = compile_program(entries), self.domain.roles
        at_points = evaluate(program, self.values, POINTS)[0]
        size = max(float(np.nanmax(np.abs(at_points), initial=0.0)), 1e-300)

        def differs(values: Mapping[str, np.ndarray], room: float) -> bool:
            with np.errstate(all="ignore"):
                return not np.all(np.abs(evaluate(program, values, POINTS)[0] - at_points) <= room * size)

        joints = {q.name for q in self.problem.chain.q}
        used = {name for name in set().union(*map(names, entries)) if isinstance(roles[name], str)}
        depends = {name for name in used if differs({**self.values, name: 0.83 * self.values[name] + 0.11}, 1e-9)}
        turned = {name: value + 2 * np.pi * (roles[name] == "angle") for name, value in self.values.items()}
        return Traits(
            bool(np.isfinite(at_points).all()),
            not differs(turned, 1e-6),
            len(depends & joints),
            len(depends - joints),
            int(np.count_nonzero(np.abs(at_points).max(axis=1) > 1e-9 * size)),
        )

    # --- what follows ---

    def derive(self, part: Part, rows_of_parts: RowsOfParts) -> "Rows | np.ndarray | None":
        """Return the answer that follows from earlier ones; None where that is too long, or there is none."""
        question = QUESTIONS[part.kind]
        derived = question.vanishes or question.formula
        if derived is None or (question.is_long and any(len(rows) > MOST_ROWS for rows in rows_of_parts.values())):
            return None
        try:
            if part.answer.is_in_numbers:
                values = sample_configurations(self.problem.chain, part, self.domain, 1, Stream(self.seed))
                in_numbers = {name: _evaluate_at(rows, values) for name, rows in rows_of_parts.items()}
                working = _substitute(numbers(self.problem.chain, values), in_numbers)
                return derived(working, part.details)[..., 0].ravel().astype(float)
            in_trees = {name: Trees.matrix(rows) for name, rows in rows_of_parts.items()}
            rows = Trees.rows(derived(_substitute(trees(self.problem.chain), in_trees), part.details))
            return rows if sum(size_of(entry) for row in rows for entry in row) <= 20 * LONGEST else None
        except ReadError:
            return None

    def judge(self, part: Part, derived: "Rows | np.ndarray", answer: ParsedAnswer) -> Judgement | None:
        """Judge an answer against what follows; None where that is easier than the reference, or of no use."""
        if isinstance(derived, np.ndarray):
            return self._judge_numbers(part, derived, answer)
        reference = self._expected_determinant() if part.answer.is_a_set else self.reference(part)
        if reference is None or not self.is_as_hard(derived, reference):
            return None
        if part.answer.is_a_set:
            joints = [q.name for q in self.problem.chain.q]
            varying = [factor for factor in factors(derived[0][0]) if names(factor) & set(joints)]
            vanishes = [[Node("eq", (factor, ZERO))] for factor in varying]
            return judge_singular(answer, vanishes, joints, self.domain, self.seed, part.rounding)
        if part.shape is None:
            return judge_expression(answer, derived[0][0], self.domain, self.seed, part.rounding)
        if part.answer.counts_up_to_a_factor:
            return judge_direction(answer, [row[0] for row in derived], self.domain, self.seed)
        return judge_matrix(answer, derived, self.domain, self.seed, part.rounding)

    def _expected_determinant(self) -> Rows | None:
        chain = self.problem.chain
        jacobian = self.part("jacobian") if len(chain.task) == chain.n <= MOST_ROWS else None
        rows = None if jacobian is None else self.reference(jacobian)
        return None if rows is None else _determinant(rows)

    def _judge_numbers(self, part: Part, values: np.ndarray, answer: ParsedAnswer) -> Judgement | None:
        largest = float(np.abs(values).max(initial=0.0))
        if not np.isfinite(values).all() or np.count_nonzero(np.abs(values) > 1e-6 * largest) < len(values):
            return None
        if part.answer.counts_up_to_a_factor:
            entries = [Node("decimal", value=Fraction(repr(float(value)))) for value in values]
            tolerance = part.of(Direction).tolerance_with(part.rounding)
            return judge_direction(answer, entries, self.domain, self.seed, tolerance)
        number = part.of(Number)
        tolerance = part.rounding.relative or number.tolerance if part.rounding else number.tolerance
        return judge_numbers(answer, values.tolist(), number.units, tolerance, 0.001 * largest)


def _substitute(w: Working, rows_of_parts: Mapping[str, np.ndarray]) -> Working:
    """Return a working in which the answers to some questions are given, (rows, columns, …)."""
    changes: dict[str, Change] = {}
    for name, rows in rows_of_parts.items():
        substitutes = QUESTIONS[name].substitutes
        assert substitutes is not None, name
        changes.update(substitutes(rows))
    return w.with_mistakes(changes)


def _evaluate_at(rows: Rows, values: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return rows of trees at a configuration, (rows, columns, 1)."""
    evaluated = evaluate(compile_program([entry for row in rows for entry in row]), values, 1)[0]
    return np.asarray(evaluated.real.reshape(len(rows), -1, 1))


def _determinant(rows: Rows) -> Rows:
    """Return the determinant of a small matrix as the only entry."""
    return Trees.rows(determinant(Trees.matrix(rows)))


@dataclass(frozen=True)
class Traits:
    """What an answer is like at random configurations: whether it is defined, and the same after whole turns.

    `joints` and `others` are the numbers of joints and other symbols on which it depends, `entries` those not zero.
    """

    finite: bool
    periodic: bool
    joints: int
    others: int
    entries: int

    def is_as_full(self, reference: "Traits") -> bool:
        """Tell whether it is defined, made of sines and cosines, and not half of the reference is zero instead."""
        is_full = not reference.entries or 2 * self.entries > reference.entries
        return self.finite and self.periodic and self.others >= reference.others - 1 and is_full


def earlier(part: Part) -> Iterator[str]:
    """Yield the parts on which a part may build."""
    if part.kind in QUESTIONS:
        for sources in QUESTIONS[part.kind].follows:
            yield from sources
