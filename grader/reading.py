"""The door: a text as the answer to one part of a problem, read in the form that is due there."""

import re
from dataclasses import dataclass, replace

from exercises.answers import Choice, ConditionSet, Direction, Expression, Forms, Matching, Matrix, Number, Selection
from exercises.arm.told import frame_on_axis
from exercises.formula.identity import Domain
from exercises.problem import Part, Problem
from exercises.questions.differentiation import ForTask
from exercises.quizzes import ASKED
from grader.answer import Given, read_conditions, read_formula, read_matrix, read_numbers
from grader.choices import read_choice, read_matching, read_selection
from grader.function_values import constant_text, is_table, read_table


def read_answer(
    problem: Problem,
    part: Part,
    text: str,
    points_seed: str = "",
    domain: Domain | None = None,
    labels: tuple[str, ...] | None = None,
) -> Given:
    """Return what a text is as the answer to a part; `points_seed` drew the points at which a function was called.

    `domain` has the symbols, and `labels` the names of the entries, where they are not those of the problem, which is
    then any of the same family.

    >>> from exercises import generate
    >>> problem = generate("planar-2r/7", ["position"])
    >>> read_answer(problem, problem["position"], "[a1, a2, a3]").refusal
    Judgement(wrong, 0: the answer is 3 x 1, and 2 x 1 is due; write it as in [a, b])
    """
    domain = domain or problem.domain()
    if is_table(text):
        same = constant_text(text)
        if same is None:
            return Given(text, table=read_table(text, domain, points_seed))
        return replace(read_answer(problem, part, same, domain=domain, labels=labels), text=text)
    if _CUBIC.search(text) and part.kind == "determinant" and (power := _lengths_in_determinant(part)) != CUBED:
        return Given(text).refused(f"m^3 can't be right here, for m^{power} is due; write the formula alone")
    joints = tuple(q.name for q in problem.chain.q)
    labels = ASKED[part.kind].typed_labels(problem.chain, part) if labels is None else labels
    on_axes = (frame_on_axis(problem.chain, joint) for joint in range(1, problem.chain.n + 1))
    columns = tuple(f"z{frame}" for frame in on_axes) if part.kind == "joint-axes" else ()
    return part.answer.told_to(_Reading(text, domain, labels, joints, columns))


_CUBIC = re.compile(r"(?<![\w])(?:m|\\mathrm\{m\}|\\text\{m\})(?:\^\(?3\)?|\^\{3\}|³|\*\*3)\]?[ .$]{0,9}$")
"""Cubic metres at the end of an answer."""
CUBED = 3


def _lengths_in_determinant(part: Part) -> int:
    """Return the power of metres that a determinant is in: one for each row of linear velocity."""
    return sum(row.startswith("v") for row in part.about(ForTask).task)


@dataclass(frozen=True)
class _Reading(Forms[Given]):
    """Reads a text by the form of the answer that is due.

    The entries of a vector may be named by `labels`, those of a matrix stand below the names of its `columns`.
    """

    text: str
    domain: Domain
    labels: tuple[str, ...]
    joints: tuple[str, ...]
    columns: tuple[str, ...]

    def formula(self, answer: Expression) -> Given:
        """Read a formula."""
        return read_formula(self.text, self.domain, self.labels)

    def matrix(self, answer: Matrix) -> Given:
        """Read rows of formulas."""
        return read_matrix(self.text, answer.shape, self.domain, self.labels, self.columns)

    def direction(self, answer: Direction) -> Given:
        """Read a vector."""
        return read_matrix(self.text, answer.shape, self.domain, self.labels)

    def numbers(self, answer: Number) -> Given:
        """Read numbers."""
        return read_numbers(self.text, len(answer.reference), self.labels, answer.units)

    def conditions(self, answer: ConditionSet) -> Given:
        """Read conditions."""
        return read_conditions(self.text, self.domain, self.joints)

    def one_of(self, answer: Choice) -> Given:
        """Read an option."""
        return read_choice(self.text, answer.options)

    def some_of(self, answer: Selection) -> Given:
        """Read letters."""
        return read_selection(self.text, len(answer.options))

    def matching(self, answer: Matching) -> Given:
        """Read a letter for each item."""
        return read_matching(self.text, answer.items, len(answer.options))
