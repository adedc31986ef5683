"""One text judged against another, as an answer is that was read in the form that is due."""

from collections.abc import Sequence

from qdot.exercises.formula.equality import Domain, Rounding
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions import QUESTIONS
from qdot.grader.diagnosis import diagnosis
from qdot.grader.judging import choices, formulas
from qdot.grader.judging.answer_parser import read_conditions, read_formula, read_matrix, read_numbers
from qdot.grader.judging.expected_form import read_answer
from qdot.grader.judging.judge import judge_parsed
from qdot.grader.judging.verdict import Diagnosis, Judgement
from qdot.grader.marking import partial_credit


def judge_expression(
    student: str, reference: str, domain: Domain, seed: str, rounding: Rounding | None = None
) -> Judgement:
    given, due = read_formula(student, domain), parse_formula(reference, domain.roles)
    return given.refusal or formulas.judge_expression(given, due, domain, seed, rounding)


def judge_matrix(
    student: str, reference: Sequence[Sequence[str]], domain: Domain, seed: str, labels: Sequence[str] = (),
    rounding: Rounding | None = None,
) -> Judgement:  # fmt: skip
    rows = [[parse_formula(entry, domain.roles) for entry in row] for row in reference]
    given = read_matrix(student, (len(rows), len(rows[0])), domain, labels)
    return given.refusal or formulas.judge_matrix(given, rows, domain, seed, rounding)


def judge_numbers(
    student: str, reference: Sequence[float], units: Sequence[str], tolerance: float, floor: float,
    labels: Sequence[str] = (),
) -> Judgement:  # fmt: skip
    given = read_numbers(student, len(reference), labels)
    return given.refusal or formulas.judge_numbers(given, reference, units, tolerance, floor)


def judge_singular(
    student: str, reference: Sequence[str], joints: Sequence[str], domain: Domain, seed: str,
    rounding: Rounding | None = None,
) -> Judgement:  # fmt: skip
    pieces = [parse_formula(text, domain.roles) for text in reference]
    due = formulas.group_by_joints(pieces, joints)
    given = read_conditions(student, domain)
    return given.refusal or formulas.judge_singular(given, due, joints, domain, seed, rounding)


def judge_angles(student: str, reference: str, domain: Domain, seed: str) -> Judgement:
    given, due = read_conditions(student, domain), parse_formula(reference, domain.roles)
    return given.refusal or formulas.judge_angles(given, due, domain, seed)


def judge_direction(
    student: str, reference: Sequence[str], domain: Domain, seed: str, tolerance: float | None = None,
    labels: Sequence[str] = (),
) -> Judgement:  # fmt: skip
    given = read_matrix(student, (len(reference), 1), domain, labels)
    due = [parse_formula(entry, domain.roles) for entry in reference]
    return given.refusal or formulas.judge_direction(given, due, domain, seed, tolerance)


def judge_choice(student: str, options: Sequence[str], right: int) -> Judgement:
    given = choices.read_choice(student, options)
    return given.refusal or choices.judge_choice(given, options, right)


def judge_selection(student: str, options: int, right: Sequence[int]) -> Judgement:
    given = choices.read_selection(student, options)
    return given.refusal or choices.judge_selection(given, options, right)


def judge_matching(student: str, items: Sequence[str], options: int, right: Sequence[int]) -> Judgement:
    given = choices.read_matching(student, items, options)
    return given.refusal or choices.judge_matching(given, items, right)


def diagnose(problem: Problem, part: Part, text: str, seed: str, points_seed: str = "") -> Diagnosis | None:
    return diagnosis.diagnose(problem, part, read_answer(problem, part, text, points_seed), seed)


def earned(problem: Problem, part: Part, text: str, seed: str) -> Judgement:
    given = read_answer(problem, part, text)
    answer = partial_credit.AnswerToCredit(problem, part, given, seed)
    return partial_credit.give_partial_credit(answer, judge_parsed(problem, part, given, seed))


def list_earlier_parts(part: Part) -> list[str]:
    """Return the names of the parts on which a part may build."""
    question = QUESTIONS.get(part.kind)
    return [] if question is None else [name for sources in question.prerequisite_sets for name in sources]
