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

import numpy as np

from qdot.exercises.answers import Direction, Number
from qdot.exercises.arm.arithmetic import Trees, determinant
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation_graph import Change, Working, numbers, trees
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.algebra import ZERO, factors
from qdot.exercises.formula.algebra import Matrix as Rows
from qdot.exercises.formula.identity import READABLE
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node, ReadError, names, size_of
from qdot.exercises.mistakes.configurations import sample_configurations
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


Own = Mapping[str, Rows]
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
    context = _Context(problem, answers, wrong, seed, is_copied)
    followed: list[Followed] = []
    for own, before in context.ways(part):
        result = context.worked_out(part, own)
        judgement = None if result is None else context.judged(part, result, answer)
        if judgement is not None and judgement.share > 0:
            idle = next((name for name in before if attempts is not None and name not in attempts), None)
            followed.append(Followed(judgement, before[0], idle))
    return max(followed, key=lambda one: (one.idle is None, one.judgement.share), default=None)


class _Context:
    """A problem with a student's answers, and values for its symbols."""

    def __init__(
        self,
        problem: Problem,
        answers: Mapping[str, ParsedAnswer],
        wrong: Sequence[str],
        seed: str,
        is_copied: IsCopied,
    ) -> None:
        self.problem, self.answers, self.wrong = problem, answers, wrong
        self.seed, self.is_copied = f"{seed}/follow", is_copied
        self.domain = problem.domain()
        self.parts = {part.name: part for part in problem.parts}
        several = self.domain.sample(set(self.domain.roles), READABLE + POINTS, Stream(self.seed))
        self.values = {name: value[READABLE:] for name, value in several.items()}

    @property
    def chain(self) -> Chain:
        """The arm."""
        return self.problem.chain

    def ways(self, part: Part) -> Iterator[tuple[Own, list[str]]]:
        """Yield the rows from which an answer may be worked out, with the wrong answers that they come from."""
        for sources in QUESTIONS[part.kind].follows:
            rows = {name: self.rows(name) for name in sources}
            before = [each for found in rows.values() if found for each in found[1]]
            if before and None not in rows.values():
                yield {name: found[0] for name, found in rows.items() if found}, list(dict.fromkeys(before))

    def rows(self, name: str) -> tuple[Rows, list[str]] | None:
        """Return the rows of a part, with the wrong answers that they come from; None where they are of no use.

        They are the student's where these are wrong, what follows from earlier ones where there is no answer, else the
        reference's.
        """
        part, given = self.part(name), self.answers.get(name)
        due = None if part is None else self.due(part)
        if part is None or due is None:
            return None
        if given is None or given.refusal is not None:
            for own, before in self.ways(part):
                result = self.worked_out(part, own)
                if result is not None and not isinstance(result, np.ndarray) and self.as_hard(result, due):
                    return result, before
        elif name in self.wrong:
            rows = self.usable(name, given, due)
            return None if rows is None else (rows, [name])
        return due, []

    def part(self, name: str) -> Part | None:
        """Return a part, whether or not it is asked in this problem; None where it can't be asked of this arm."""
        if name not in self.parts:
            question = QUESTIONS[name]
            if question.refusal(self.chain) is not None:
                return None
            answer, details = question.ask(self.chain, Stream(f"{self.seed}/{name}"))
            self.parts[name] = Part(name, name, answer, question.points, question.needs, details)
        return self.parts[name]

    def due(self, part: Part) -> Rows | None:
        """Return the rows of a part's reference, None where it has none in formulas."""
        is_in_formulas = part.answer.entries() and not part.answer.is_in_numbers
        return part.answer.trees(self.domain.roles) if is_in_formulas else None

    def usable(self, name: str, given: ParsedAnswer, due: Rows) -> Rows | None:
        """Return the rows of a wrong answer from which something may follow."""
        rows = given.rows
        if rows is None or (len(rows), len(rows[0])) != (len(due), len(due[0])):
            return None
        if sum(map(size_of, given.entries)) > LONGEST:
            return None
        if any(given.blanks) or given.symbols - set(self.domain.roles):
            return None
        if self.is_copy(name, rows) or self.is_copied(self.parts[name], rows):
            return None
        mine, ours = self.traits(rows), self.traits(due)
        is_regular = name != "jacobian" or self.as_regular(rows, due)
        return rows if mine.is_as_full(ours) and is_regular else None

    def is_copy(self, name: str, rows: Rows) -> bool:
        """Tell whether rows are, at random configurations, the answer to another part as well."""
        mine = self._values(rows)
        return any(
            other is not None and other.shape == mine.shape and np.allclose(other, mine, rtol=1e-9, atol=0)
            for other in (self._in_numbers(given) for part, given in self.answers.items() if part != name)
        )

    def _in_numbers(self, given: ParsedAnswer) -> np.ndarray | None:
        """Return another answer in numbers, None where it has none."""
        if given.rows is None or given.symbols - set(self.domain.roles) or len(given.text) > 10 * LONGEST:
            return None
        try:
            return self._values(given.rows)
        except ReadError:  # statements or blanks are among its entries
            return None

    def _values(self, rows: Rows) -> np.ndarray:
        return evaluate(compile_program([entry for row in rows for entry in row]), self.values, POINTS)[0]

    def as_hard(self, rows: Rows, due: Rows) -> bool:
        """Tell whether rows depend on as many joints as those that are due, and have not clearly more zeros."""
        mine, ours = self.traits(rows), self.traits(due)
        return mine.is_as_full(ours) and mine.joints >= ours.joints

    def as_regular(self, rows: Rows, due: Rows) -> bool:
        """Tell whether a Jacobian, if it is square, has a determinant as hard as that of the one that is due."""
        if not 1 < len(due) == len(due[0]) <= MOST_ROWS:
            return True
        return self.as_hard(_determinant(rows), _determinant(due))

    def traits(self, rows: Rows) -> "Traits":
        """Return what an answer is like, at random configurations."""
        entries = [entry for row in rows for entry in row]
        program, roles = compile_program(entries), self.domain.roles
        at_points = evaluate(program, self.values, POINTS)[0]
        size = max(float(np.nanmax(np.abs(at_points), initial=0.0)), 1e-300)

        def differs(values: Mapping[str, np.ndarray], room: float) -> bool:
            with np.errstate(all="ignore"):
                return not np.all(np.abs(evaluate(program, values, POINTS)[0] - at_points) <= room * size)

        joints = {q.name for q in self.chain.q}
        used = {name for name in set().union(*map(names, entries)) if isinstance(roles[name], str)}
        depends = [name for name in used if differs({**self.values, name: 0.83 * self.values[name] + 0.11}, 1e-9)]
        turn = {name: 2 * np.pi if role == "angle" else 0.0 for name, role in roles.items()}
        return Traits(
            bool(np.isfinite(at_points).all()),
            not differs({name: value + turn[name] for name, value in self.values.items()}, 1e-6),
            sum(name in joints for name in depends),
            sum(name not in joints for name in depends),
            int(np.count_nonzero(np.abs(at_points).max(axis=1) > 1e-9 * size)),
        )

    def worked_out(self, part: Part, own: Own) -> "Rows | np.ndarray | None":
        """Return the answer that follows from earlier ones; None where that is too long, or there is none."""
        question = QUESTIONS[part.kind]
        derived = question.vanishes or question.formula
        if derived is None or (question.is_long and any(len(rows) > MOST_ROWS for rows in own.values())):
            return None
        try:
            if part.answer.is_in_numbers:
                values = sample_configurations(self.chain, part, self.domain, 1, Stream(self.seed))
                given = {name: _at(rows, values) for name, rows in own.items()}
                return derived(_with(numbers(self.chain, values), given), part.details)[..., 0].ravel().astype(float)
            given = {name: Trees.matrix(rows) for name, rows in own.items()}
            rows = Trees.rows(derived(_with(trees(self.chain), given), part.details))
            return rows if sum(size_of(entry) for row in rows for entry in row) <= 20 * LONGEST else None
        except ReadError:
            return None

    def judged(self, part: Part, result: "Rows | np.ndarray", answer: ParsedAnswer) -> Judgement | None:
        """Judge an answer against what follows; None where that is easier than what is due, or of no use."""
        if isinstance(result, np.ndarray):
            return self._judged_numbers(part, result, answer)
        due = self._determinant_due() if part.answer.is_a_set else self.due(part)
        if due is None or not self.as_hard(result, due):
            return None
        if part.answer.is_a_set:
            joints = [q.name for q in self.chain.q]
            varying = [factor for factor in factors(result[0][0]) if names(factor) & set(joints)]
            vanishes = [[Node("eq", (factor, ZERO))] for factor in varying]
            return judge_singular(answer, vanishes, joints, self.domain, self.seed, part.rounding)
        if part.shape is None:
            return judge_expression(answer, result[0][0], self.domain, self.seed, part.rounding)
        if part.answer.counts_up_to_a_factor:
            return judge_direction(answer, [row[0] for row in result], self.domain, self.seed)
        return judge_matrix(answer, result, self.domain, self.seed, part.rounding)

    def _determinant_due(self) -> Rows | None:
        jacobian = self.part("jacobian") if len(self.chain.task) == self.chain.n <= MOST_ROWS else None
        rows = None if jacobian is None else self.due(jacobian)
        return None if rows is None else _determinant(rows)

    def _judged_numbers(self, part: Part, values: np.ndarray, answer: ParsedAnswer) -> Judgement | None:
        largest = float(np.abs(values).max(initial=0.0))
        if not np.isfinite(values).all() or np.count_nonzero(np.abs(values) > 1e-6 * largest) < len(values):
            return None
        if part.answer.counts_up_to_a_factor:
            entries = [Node("decimal", value=Fraction(repr(float(value)))) for value in values]
            tolerance = part.of(Direction).tolerance_with(part.rounding)
            return judge_direction(answer, entries, self.domain, self.seed, tolerance)
        due = part.of(Number)
        tolerance = part.rounding.relative or due.tolerance if part.rounding else due.tolerance
        floor = 0.001 * largest
        return judge_numbers(answer, values.tolist(), due.units, tolerance, floor)


def _with(w: Working, given: Mapping[str, np.ndarray]) -> Working:
    """Return a working in which the answers to some questions are given, (rows, columns, …)."""
    changes: dict[str, Change] = {}
    for name, rows in given.items():
        substitutes = QUESTIONS[name].substitutes
        assert substitutes is not None, name
        changes.update(substitutes(rows))
    return w.with_mistakes(changes)


def _at(rows: Rows, values: Mapping[str, np.ndarray]) -> np.ndarray:
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

    def is_as_full(self, due: "Traits") -> bool:
        """Tell whether it is defined, made of sines and cosines, and not half of what is due is zero instead."""
        is_full = not due.entries or 2 * self.entries > due.entries
        return self.finite and self.periodic and self.others >= due.others - 1 and is_full


def earlier(part: Part) -> Iterator[str]:
    """Yield the parts on which a part may build."""
    if part.kind in QUESTIONS:
        for sources in QUESTIONS[part.kind].follows:
            yield from sources
