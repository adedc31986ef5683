"""Judge an answer of any type to one part of a problem, by comparing it with the correct answer (the reference)."""

import secrets
from dataclasses import dataclass

from qdot.exercises import reference_answers
from qdot.exercises.formula.equality import Domain
from qdot.exercises.problem.problem import Part, Problem
from qdot.grader.judging.answer_parser import ParsedAnswer
from qdot.grader.judging.choices import judge_choice, judge_matching, judge_selection
from qdot.grader.judging.expected_form import read_answer
from qdot.grader.judging.formulas import (
    CONFIGURATION,
    SINGULAR_CONFIGURATION,
    judge_direction,
    judge_expression,
    judge_matrix,
    judge_numbers,
    judge_singular,
)
from qdot.grader.judging.functions import judge_function
from qdot.grader.judging.verdict import AWAITS_PERSON, Judgement, Outcome


def judge(problem: Problem, part: Part, answer: str, seed: str | None = None) -> Judgement:
    """Judge the text of an answer to a part.

    `seed` determines the configurations at which the answer is compared. If it is None, they differ in every call.

    >>> from qdot import generate
    >>> problem = generate("polar-rp/1", ["determinant"])
    >>> judge(problem, problem["determinant"], "-0.7 - d2")
    Judgement(correct, 1: right)
    """
    parsed = read_answer(problem, part, answer)
    return judge_parsed(problem, part, parsed, secrets.token_hex(16) if seed is None else seed)


def judge_parsed(problem: Problem, part: Part, parsed: ParsedAnswer, seed: str) -> Judgement:
    """Judge a parsed answer to a part; `seed` determines the configurations at which it is compared."""
    if parsed.refusal is not None:
        return parsed.refusal
    if parsed.table is not None:
        return judge_function(part, parsed.table, [q.name for q in problem.chain.q], problem.domain.roles)
    return _AnswerJudge(problem, part, parsed, problem.select_domain(part), seed).visit(part.answer)


@dataclass(frozen=True)
class _AnswerJudge(reference_answers.AnswerVisitor[Judgement]):
    """Judges a parsed answer; each method is for one type of answer."""

    problem: Problem
    part: Part
    parsed: ParsedAnswer
    domain: Domain
    seed: str

    def visit_expression(self, answer: reference_answers.Expression) -> Judgement:
        """Compare a formula."""
        ((expected,),) = answer.parse_trees(self.domain.roles)
        return judge_expression(self.parsed, expected, self.domain, self.seed, self.part.rounding)

    def visit_matrix(self, answer: reference_answers.Matrix) -> Judgement:
        """Compare a matrix entry by entry."""
        expected = answer.parse_trees(self.domain.roles)
        return judge_matrix(self.parsed, expected, self.domain, self.seed, self.part.rounding)

    def visit_direction(self, answer: reference_answers.Direction) -> Judgement:
        """Compare a vector up to a factor."""
        expected = [entry for row in answer.parse_trees(self.domain.roles) for entry in row]
        return judge_direction(self.parsed, expected, self.domain, self.seed, answer.find_tolerance(self.part.rounding))

    def visit_number(self, answer: reference_answers.Number) -> Judgement:
        """Compare numbers within their tolerances."""
        expected = [float(value) for value in answer.reference]
        return judge_numbers(self.parsed, expected, answer.units, *answer.find_allowed_errors(self.part.rounding))

    def visit_singular(self, answer: reference_answers.ConditionSet) -> Judgement:
        """Compare sets of configurations."""
        joints = [q.name for q in self.problem.chain.q]
        expected = answer.group_by_component([piece for (piece,) in answer.parse_trees(self.domain.roles)])
        noun = SINGULAR_CONFIGURATION if answer.is_singular_set else CONFIGURATION
        return judge_singular(self.parsed, expected, joints, self.domain, self.seed, self.part.rounding, noun)

    def visit_text(self, answer: reference_answers.Words) -> Judgement:
        """Leave the points to a person."""
        return self.parsed.refusal or Judgement(Outcome.UNGRADED, 0.0, AWAITS_PERSON)

    def visit_choice(self, answer: reference_answers.Choice) -> Judgement:
        """Judge the choice of one option."""
        return judge_choice(self.parsed, answer.options, answer.correct)

    def visit_selection(self, answer: reference_answers.Selection) -> Judgement:
        """Judge the choice of several options."""
        return judge_selection(self.parsed, len(answer.options), answer.correct)

    def visit_matching(self, answer: reference_answers.Matching) -> Judgement:
        """Judge the letters chosen for items."""
        return judge_matching(self.parsed, answer.items, answer.correct)
