"""Judge the answer to one part of a problem, whatever its type, against its reference."""

from dataclasses import dataclass

from exercises.answers import Choice, ConditionSet, Direction, Expression, Forms, Matching, Matrix, Number, Selection
from exercises.formula.identity import Domain
from exercises.formula.text import rows_of_text
from exercises.problem import Part, Problem
from exercises.quizzes import ASKED
from grader.choices import judge_choice, judge_matching, judge_selection
from grader.direction import judge_direction
from grader.formulas import judge_expression, judge_matrix, judge_numbers, judge_singular
from grader.functions import asked_of, constant_text, is_table, judge_function
from grader.verdict import Judgement


def domain_of(problem: Problem) -> Domain:
    """Return what each symbol of the problem may be; a length that is given has its value."""
    return problem.domain()


def judge(problem: Problem, part: Part, answer: str, seed: str, points_seed: str = "") -> Judgement:
    """Judge the text of an answer to a part; `seed` draws the points at which it is compared.

    Those at which a function was called, before its values were an answer, come from `points_seed`.
    """
    if is_table(answer):
        same = constant_text(answer)
        if same is not None:
            return judge(problem, part, same, seed)
        domain = domain_of(problem)
        return judge_function(part, answer, asked_of(problem, domain, points_seed), domain, part.rounding)
    return part.answer.told_to(Judging(problem, part, answer, seed))


@dataclass(frozen=True)
class Judging(Forms[Judgement]):
    """Judges a text by the form of the answer that is due."""

    problem: Problem
    part: Part
    text: str
    seed: str

    def formula(self, answer: Expression) -> Judgement:
        """Compare a formula."""
        return judge_expression(self.text, answer.as_typed(), domain_of(self.problem), self.seed, self.part.rounding)

    def matrix(self, answer: Matrix) -> Judgement:
        """Compare entry by entry."""
        rows, names = rows_of_text(answer.reference), labels(self.problem, self.part)
        return judge_matrix(self.text, rows, domain_of(self.problem), self.seed, names, self.part.rounding)

    def direction(self, answer: Direction) -> Judgement:
        """Compare up to a factor."""
        apart = answer.apart(self.part.rounding)
        names = labels(self.problem, self.part)
        return judge_direction(self.text, answer.formulas(), domain_of(self.problem), self.seed, apart, names)

    def numbers(self, answer: Number) -> Judgement:
        """Compare numbers, each within what it may be off."""
        right = [float(value) for value in answer.reference]
        allowed = answer.allowed(self.part.rounding)
        return judge_numbers(self.text, right, answer.units, *allowed, labels(self.problem, self.part))

    def conditions(self, answer: ConditionSet) -> Judgement:
        """Compare sets of configurations."""
        joints = [q.name for q in self.problem.chain.q]
        domain, rounding = domain_of(self.problem), self.part.rounding
        return judge_singular(self.text, answer.pieces(), joints, domain, self.seed, rounding)

    def one_of(self, answer: Choice) -> Judgement:
        """Look whether it is the right option."""
        return judge_choice(self.text, answer.options, answer.correct)

    def some_of(self, answer: Selection) -> Judgement:
        """Count the right options."""
        return judge_selection(self.text, len(answer.options), answer.correct)

    def matching(self, answer: Matching) -> Judgement:
        """Count the right pairs."""
        return judge_matching(self.text, answer.items, len(answer.options), answer.correct)


def labels(problem: Problem, part: Part) -> tuple[str, ...]:
    """Return the names of a vector of joint rates, by which `solve` returns them; nothing for other answers."""
    return ASKED[part.kind].labels(problem.chain)
