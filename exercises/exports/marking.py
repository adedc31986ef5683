"""How to mark a part on paper: the right answer, what known mistakes earn, and the rule for partial credit.

The grader decides what an answer earns, so paper and notebooks are marked alike.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

import sympy as sp

from qdot.exercises.answers import (
    LETTERS,
    Answer,
    AnswerVisitor,
    Choice,
    ConditionSet,
    Direction,
    Expression,
    Matching,
    Matrix,
    Number,
    Selection,
)
from qdot.exercises.exports.export_format import Earns
from qdot.exercises.exports.known_wrong import KnownWrongAnswer, known_wrong
from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.problem.credit import AMISS, HALF, OWN
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.results import is_product
from qdot.exercises.quizzes.options import list_blames
from qdot.exercises.writing.fit import fit_formula, width
from qdot.exercises.writing.short_answer import short_answer

MOST = 4
"""Maximum number of known mistakes that a sheet lists for a part."""
LONGEST = 400
"""Maximum length of a wrong answer that is shown, in characters; for longer ones only the mistake is named."""
TOO_LONG = "too long to be shown"
ROOM, LEGIBLE = 22.0, 1.25
"""Width of a formula on a sheet, in em of the text, and the multiple of it beyond which it would shrink too much."""


@dataclass(frozen=True)
class Mark:
    """A line of a marking sheet: why an answer is given, the answer (Markdown, "" if not shown), and what it earns."""

    says: str
    answer: str
    earns: str


@dataclass(frozen=True)
class Marking:
    """The lines of a part, the right answer first, and the rule for all other answers."""

    marks: tuple[Mark, ...]
    rule: str


def marking(problem: Problem, part: Part, earns: Earns) -> Marking:
    """Return how a part is marked; `earns` returns the share of the points for a typed answer."""
    right = Mark("Right", _drop_illegible(short_answer(problem, part)) or "see the key", _points(part, Fraction(1)))
    meanings = right.answer.partition("$$")[0]  # of names of angles, which need not be said again
    wrong = _options(part) if part.answer.offered else _mistakes(problem, part, earns)
    marks = (replace(mark, answer=mark.answer.removeprefix(meanings)) for mark in wrong)
    return Marking((right, *marks), part.answer.accept(_Rules(part)))


def _drop_illegible(answer: str) -> str:
    """Return an answer, or "" if its formulas would become too small to read on the sheet."""
    formulas = (parse_latex(latex) for latex in re.findall(r"\$\$(.*?)\$\$", answer, re.DOTALL))
    return answer if all(width(fit_formula(each, ROOM)) <= LEGIBLE * ROOM for each in formulas) else ""


def _points(part: Part, share: Fraction) -> str:
    return f"{float(share) * part.points:.3g}"


def _options(part: Part) -> Iterator[Mark]:
    """Yield the wrong options that known mistakes lead to, if exactly one option is right."""
    if not isinstance(part.answer, Choice):
        return
    for index, letter in zip(range(len(part.answer.options)), LETTERS, strict=False):
        blames = dict.fromkeys(blame.title for blame in list_blames(part, index))
        if blames and index != part.answer.correct:
            yield Mark(f"{letter}: {', and '.join(blames)}", "", _points(part, Fraction(0)))


def _mistakes(problem: Problem, part: Part, earns: Earns) -> Iterator[Mark]:
    """Yield the answers that known mistakes lead to, with what they earn."""
    for known in known_wrong(problem, part, MOST):
        wrong = replace(part, answer=part.answer.accept(_Wrong(known)))
        typed = wrong.answer.as_typed()
        shown = _drop_illegible(short_answer(problem, wrong)) if len(typed) <= LONGEST else ""
        yield Mark(known.title, shown or TOO_LONG, _points(part, earns(problem, part, typed)))


@dataclass(frozen=True)
class _Wrong(AnswerVisitor[Answer]):
    """A wrong answer in the form of the right one."""

    known: KnownWrongAnswer

    def formula(self, answer: Expression) -> Answer:
        assert isinstance(self.known.answer, sp.MatrixBase)
        return replace(answer, reference=self.known.answer[0])

    def matrix(self, answer: Matrix) -> Answer:
        return replace(answer, reference=self.known.answer)

    def direction(self, answer: Direction) -> Answer:
        return replace(answer, reference=self.known.answer)

    def numbers(self, answer: Number) -> Answer:
        return replace(answer, reference=self.known.answer)

    def conditions(self, answer: ConditionSet) -> Answer:
        return replace(answer, components=self.known.answer)


@dataclass(frozen=True)
class _Rules(AnswerVisitor[str]):
    """States the rule for partial credit in a sentence, as in docs/partial-credit.md."""

    part: Part

    def formula(self, answer: Expression) -> str:
        factors = (
            " A factor with joints that is lost, wrong or too many halves it, twice at most; nothing if more are wrong "
            "than right."
        )
        both = self._worth(1 - 2 * AMISS)
        return self._apply_policy(
            f"Only the sign or a constant factor wrong: {self._worth(1 - AMISS)}; both: {both}; one other mistake: "
            f"{self._worth(HALF)}.{factors * is_product(self.part)}"
        )

    def matrix(self, answer: Matrix) -> str:
        columns = [k for k in range(answer.reference.cols) if any(answer.reference.col(k))]
        if (self.part.credit or OWN).by == "columns" and answer.reference.cols > 1:
            return self._apply_policy(f"Each column that is right: {self._worth(Fraction(1, len(columns)))}.")
        return self._apply_policy(self._entries(answer.reference))

    def numbers(self, answer: Number) -> str:
        if len(answer.reference) == 1:
            return self.default(answer)
        return self._apply_policy(self._entries(answer.reference))

    def _entries(self, reference: sp.Matrix) -> str:
        count = sum(entry != 0 for entry in reference) or len(reference)
        each = self._worth(Fraction(1, count))
        spoiled = " One that is zero, and answered with something else, takes off as much." if 0 in reference else ""
        whole = (
            f" Only signs wrong, or only a common factor: {self._worth(1 - AMISS)}. One other mistake throughout: "
            f"{self._worth(HALF)}."
        )
        counted = "are not zero" if 0 in reference else "are due"
        return f"Each of the {count} entries that {counted}: {each}.{spoiled}{whole}"

    def conditions(self, answer: ConditionSet) -> str:
        return self._apply_policy(
            "A condition that is forgotten halves it, and so does each that is not singular (all values of a joint are "
            "one); values of a condition that are forgotten leave two thirds. Nothing if more are wrong than right."
        )

    def some_of(self, answer: Selection) -> str:
        each = self._worth(Fraction(1, len(answer.correct)))
        left = len(answer.options) - len(answer.correct)
        off = f"; each wrong one takes off {self._worth(Fraction(1, left))}" if left else ""
        return self._apply_policy(f"Each right letter: {each}{off}.")

    def matching(self, answer: Matching) -> str:
        return self._apply_policy(
            f"Each right letter: {self._worth(Fraction(1, len(answer.items)))}; one given twice is none."
        )

    def default(self, answer: Answer) -> str:
        return "Everything or nothing."

    def _worth(self, share: Fraction) -> str:
        return _points(self.part, share * (self.part.credit or OWN).worth)

    def _apply_policy(self, rule: str) -> str:
        policy = self.part.credit or OWN
        return "Everything or nothing." if policy.by == "whole" or not policy.worth else rule
