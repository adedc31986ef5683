"""Judge the answer to one part of a problem, whatever its type, against its reference."""

from exercises.answers import Choice, ConditionSet, Direction, Expression, Matching, Matrix, Number, Selection
from exercises.formula.identity import Domain
from exercises.formula.text import text_of
from exercises.problem import Part, Problem
from grader.choices import judge_choice, judge_matching, judge_selection
from grader.direction import judge_direction
from grader.functions import asked_of, constant_text, is_table, judge_function
from grader.judge import judge_expression, judge_matrix, judge_numbers, judge_singular
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
    reference = part.answer
    if isinstance(reference, Choice):
        return judge_choice(answer, reference.options, reference.correct)
    if isinstance(reference, Selection):
        return judge_selection(answer, len(reference.options), reference.correct)
    if isinstance(reference, Matching):
        return judge_matching(answer, reference.items, len(reference.options), reference.correct)
    if isinstance(reference, Number):
        values = [float(value) for value in reference.reference]
        rates = labels(problem, part)
        tolerance, floor = reference.tolerance, reference.floor
        if part.rounding is not None:
            # An allowance for values near zero belongs to the digits that are wanted.
            tolerance = part.rounding.relative
            floor = part.rounding.absolute + reference.floor * tolerance / reference.tolerance
        return judge_numbers(answer, values, reference.units, tolerance, floor, rates)
    domain = domain_of(problem)
    if isinstance(reference, Expression):
        return judge_expression(answer, text_of(reference.reference), domain, seed, part.rounding)
    if isinstance(reference, Matrix):
        rows = [[text_of(entry) for entry in row] for row in reference.reference.tolist()]
        return judge_matrix(answer, rows, domain, seed, labels(problem, part), part.rounding)
    if isinstance(reference, Direction):
        entries = [text_of(entry) for entry in reference.reference]
        apart = reference.tolerance
        if apart is not None and part.rounding is not None:
            apart = part.rounding.relative or part.rounding.absolute
        return judge_direction(answer, entries, domain, seed, apart, labels(problem, part))
    assert isinstance(reference, ConditionSet)
    return judge_singular(answer, reference.pieces(), [q.name for q in problem.chain.q], domain, seed, part.rounding)


def labels(problem: Problem, part: Part) -> tuple[str, ...]:
    """Return the names of a vector of joint rates, by which `solve` returns them; nothing for other answers."""
    rates = part.kind in ("inverse-velocity", "joint-rates", "least-norm-rates", "self-motion", "path-rates")
    return tuple(rate.name for rate in problem.chain.rates) if rates else ()
