"""Judge one text against another, in the same way as the grader judges an answer of each form."""

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
    answer, expected = read_formula(student, domain), parse_formula(reference, domain.roles)
    return answer.refusal or formulas.judge_expression(answer, expected, domain, seed, rounding)


def judge_matrix(
    student: str, reference: Sequence[Sequence[str]], domain: Domain, seed: str, labels: Sequence[str] = (),
    rounding: Rounding | None = None,
) -> Judgement:  # fmt: skip
    rows = [[parse_formula(entry, domain.roles) for entry in row] for row in reference]
    answer = read_matrix(student, (len(rows), len(rows[0])), domain, labels)
    return answer.refusal or formulas.judge_matrix(answer, rows, domain, seed, rounding)


def judge_numbers(
    student: str, reference: Sequence[float], units: Sequence[str], tolerance: float, floor: float,
    labels: Sequence[str] = (),
) -> Judgement:  # fmt: skip
    answer = read_numbers(student, len(reference), labels)
    return answer.refusal or formulas.judge_numbers(answer, reference, units, tolerance, len(reference) * [floor])


def judge_singular(
    student: str, reference: Sequence[str], joints: Sequence[str], domain: Domain, seed: str,
    rounding: Rounding | None = None,
) -> Judgement:  # fmt: skip
    trees = [parse_formula(text, domain.roles) for text in reference]
    expected = formulas.group_by_joints(trees, joints)
    answer = read_conditions(student, domain)
    return answer.refusal or formulas.judge_singular(answer, expected, joints, domain, seed, rounding)


def judge_angles(student: str, reference: str, domain: Domain, seed: str) -> Judgement:
    answer, expected = read_conditions(student, domain), parse_formula(reference, domain.roles)
    return answer.refusal or formulas.judge_angles(answer, expected, domain, seed)


def judge_direction(
    student: str, reference: Sequence[str], domain: Domain, seed: str, tolerance: float | None = None,
    labels: Sequence[str] = (),
) -> Judgement:  # fmt: skip
    answer = read_matrix(student, (len(reference), 1), domain, labels)
    expected = [parse_formula(entry, domain.roles) for entry in reference]
    return answer.refusal or formulas.judge_direction(answer, expected, domain, seed, tolerance)


def judge_choice(student: str, options: Sequence[str], correct_index: int) -> Judgement:
    answer = choices.read_choice(student, options)
    return answer.refusal or choices.judge_choice(answer, options, correct_index)


def judge_selection(student: str, options: int, correct_indices: Sequence[int]) -> Judgement:
    answer = choices.read_selection(student, options)
    return answer.refusal or choices.judge_selection(answer, options, correct_indices)


def judge_matching(student: str, items: Sequence[str], options: int, correct_indices: Sequence[int]) -> Judgement:
    answer = choices.read_matching(student, items, options)
    return answer.refusal or choices.judge_matching(answer, items, correct_indices)


def diagnose(problem: Problem, part: Part, text: str, seed: str, functions_seed: str = "") -> Diagnosis | None:
    return diagnosis.diagnose(problem, part, read_answer(problem, part, text, functions_seed), seed)


def judge_with_credit(problem: Problem, part: Part, text: str, seed: str) -> Judgement:
    answer = read_answer(problem, part, text)
    credit_answer = partial_credit.AnswerInContext(problem, part, answer, seed)
    return partial_credit.give_partial_credit(credit_answer, judge_parsed(problem, part, answer, seed))


def list_earlier_parts(part: Part) -> list[str]:
    question = QUESTIONS.get(part.kind)
    return [] if question is None else [name for sources in question.prerequisite_sets for name in sources]
