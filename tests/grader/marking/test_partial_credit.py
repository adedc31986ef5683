"""Partial credit: the share that a partly right answer earns, settings of an assignment, and texts, which are true."""

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.chapter import make_planar_2r, make_scorbot_arm
from qdot.exercises.common.errors import QdotError
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.generation import generate
from qdot.exercises.problem.credit import CREDIT_RULES, Credit, parse_credit_policy
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.reference_answers import ConditionSet, Expression
from qdot.grader.judging.verdict import Judgement, Outcome, Verdict
from qdot.grader.marking.marking import MarkingRules, mark
from qdot.grader.reports.feedback_levels import remove_numbers
from tests.support import ROOT, read_cases
from tests.support.judging import judge_with_credit
from tests.support.problems import ask_question, get_problem, replace_answer
from tests.support.submitting import make_class
from tests.support.suites import few_families, sample_for_suite

PLANAR, SCORBOT = make_planar_2r(), make_scorbot_arm()
DETERMINANT = "a2*a3*(a1 + a2*cos(theta2) + a3*cos(theta2 + theta3))*sin(theta3)"
RIGHT = (
    "[[-a1*sin(theta1) - a2*sin(theta1 + theta2), -a2*sin(theta1 + theta2)],"
    " [a1*cos(theta1) + a2*cos(theta1 + theta2), a2*cos(theta1 + theta2)]]"
)


ELBOW_QUESTIONS = ("position", "joint-axes", "position-vectors", "jacobian", "inverse-jacobian")


def judge_planar(question: str, answer: str, credit: Credit | None = None, chain: Chain = PLANAR) -> Judgement:
    problem = ask_question(question, chain)
    part = replace(problem.parts[0], credit=credit or Credit())
    return judge_with_credit(problem, part, answer, "credit")


@pytest.mark.parametrize(("answer", "share"), read_cases("answers")["determinants"])
def test_a_determinant_is_marked_by_its_factors(answer: str, share: float) -> None:
    """The usual mistakes are tested below, on every arm."""
    judgement = judge_planar("determinant", answer)
    assert judgement.share == share
    assert judgement.outcome is (Outcome.CORRECT if share == 1 else Outcome.PARTIAL if share else Outcome.WRONG)


@pytest.mark.parametrize("answer", ["-2", "1"])
def test_a_wrong_number_earns_nothing(answer: str) -> None:
    problem = replace_answer(ask_question("determinant", PLANAR), Expression(sp.Integer(2)))
    assert judge_with_credit(problem, problem.parts[0], answer, "credit").share == 0


def split_determinant(part: Part, problem: Problem) -> tuple[sp.Expr, list[sp.Expr]]:
    """Return the constant part of a determinant, and its factors with joint variables, repeated by their powers."""
    joints, constant, factors = set(problem.chain.q), sp.S.One, []
    for factor in sp.Mul.make_args(part.answer_as(Expression).reference):
        base, power = factor.as_base_exp()
        if factor.free_symbols & joints:
            factors += [base] * int(power)
        else:
            constant *= factor
    return constant, factors


def test_a_mistake_in_a_determinant_earns_the_same_on_every_arm(family: str) -> None:
    problem = get_problem(family, 0)
    for part in problem.parts:
        if part.kind not in ("determinant", "gram-determinant") or not isinstance(part.answer, Expression):
            continue
        constant, factors = split_determinant(part, problem)
        reference = part.answer.reference
        lengths = sorted(constant.free_symbols, key=str)
        wrong_answers = {
            "the sign": (-reference, 0.8),
            "another number": (3 * reference, 0.8),
            "sign and number": (-reference / 7, 0.6),
            **{f"without {length}": (reference / length, 0.8) for length in lengths},
            "a factor lost": (reference / factors[-1] if len(factors) > 1 else None, 0.5),
            "a factor lost, and the sign": (-reference / factors[-1] if len(factors) > 1 else None, 0.5),
            "two factors lost": (
                reference / factors[-1] / factors[0] if len(factors) > 2 else None,
                0.25 if len(factors) > 3 else 0.0,
            ),
            "a factor too many": (reference * (2 + sp.cos(sp.Symbol("theta1"))), 0.5),
            "no factor": (constant, 0.0),
            "zero": (sp.S.Zero, 0.0),
            "a number": (sp.Integer(7), 0.0),
        }
        if not factors:  # a determinant that is a number: right or not
            wrong_answers = dict.fromkeys(("the sign", "twice"), (-reference, 0.0))
        for mistake, (answer, share) in wrong_answers.items():
            if answer is None or (problem.chain.joints[0].is_prismatic and "too many" in mistake):
                continue
            judgement = judge_with_credit(problem, part, format_expression(answer), "f")
            assert judgement.share == share, (mistake, answer, judgement)


@few_families
def test_zeros_constants_and_guesses_earn_nothing(family: str) -> None:
    problem = get_problem(family, 0)
    zeros = ", ".join(f"{q.name} = {value}" for q in problem.chain.q for value in ("0", "pi", "pi/2", "-pi/2"))
    for part in problem.parts:
        if part.answer.is_set:
            assert judge_with_credit(problem, part, f"[{zeros}]", "g").share == 0.0, part
        elif part.answer.is_symbolic:
            rows, columns = part.shape or (1, 1)
            varies = {symbol.name for symbol in part.answer.as_matrix().free_symbols} - problem.constants
            for guess in ("0", "1", "7") if varies else ("0",):
                answer = str([[guess] * columns] * rows).replace("'", "") if part.shape else guess
                assert judge_with_credit(problem, part, answer, "g").share == 0.0, (part, guess)


def test_a_matrix_is_marked_by_entries_columns_or_as_a_whole() -> None:
    one_wrong = RIGHT.replace(", a2*cos(theta1 + theta2)]]", ", a2*sin(theta2)]]")
    assert judge_planar("jacobian", one_wrong).share == 0.75
    by_columns = judge_planar("jacobian", one_wrong, Credit("columns"))
    assert by_columns.share == 0.5 and "1 of 2 columns" in by_columns.reason
    assert judge_planar("jacobian", one_wrong, Credit("whole")).outcome is Outcome.WRONG
    assert judge_planar("jacobian", one_wrong, Credit("", Fraction(1, 2))).share == 0.375
    constants = judge_planar("joint-axes", "[[0, 0], [0, 0], [1, 2]]")  # no entry of the reference varies
    assert constants.share == 0.5 and "depend on the configuration" not in constants.reason


def test_an_answer_to_another_students_problem_earns_no_credit_for_a_mistake() -> None:
    signs = "[a1*cos(theta1) - a2*cos(theta1 + theta2), a1*sin(theta1) - a2*sin(theta1 + theta2)]"
    swapped = "[a1*sin(theta1) + a2*sin(theta1 + theta2), a1*cos(theta1) + a2*cos(theta1 + theta2)]"
    problem, copied = ask_question("position", PLANAR), MarkingRules(is_copied=lambda part, rows: True)
    for answer, points in ((signs, 0.8), (swapped, 0.5)):
        marked = [mark(problem, {"position": answer}, secret="s", rules=rules)[0] for rules in (MarkingRules(), copied)]
        assert [verdict.points for verdict in marked] == [points, 0.0]


def test_no_credit_rule_gives_wrong_answers_full_marks_or_right_ones_less() -> None:
    for rule in CREDIT_RULES:
        for factor in ("-1", "a1", "3"):
            scaled = str((sp.Matrix(sp.sympify(RIGHT)) * sp.sympify(factor)).tolist())
            assert judge_planar("jacobian", scaled, Credit(rule)).share == (0.0 if rule == "whole" else 0.8), scaled
        assert judge_planar("jacobian", RIGHT, Credit(rule)).share == 1.0
        assert judge_planar("jacobian", RIGHT.replace("a2*cos", "a1*cos"), Credit(rule)).share < 1.0
        share = 0.0 if rule == "whole" else 2 / 3
        assert judge_planar("singular-angles", "theta2 = 0", Credit(rule)).share == pytest.approx(share)


ELBOW = get_problem("elbow-3r", 1, variation="chapter")
POSITION, AXES, ARMS, J, INVERSE = (ELBOW[name].answer.as_matrix() for name in ELBOW_QUESTIONS)
SIGNS = sp.diag(1, -1, -1)
DET = sp.sympify(DETERMINANT)
GEOMETRIC = sp.Matrix.vstack(J, AXES)
FULL = "theta3 = 0, theta3 = pi, a1 + a2*cos(theta2) + a3*cos(theta2 + theta3) = 0"
INVENTED = "a1*a2*a3*sin(theta1)*sin(theta2)*sin(theta3)"


def swap_waves(matrix: sp.Matrix) -> sp.Matrix:
    return matrix.replace(sp.sin, sp.Function("S")).replace(sp.cos, sp.sin).replace(sp.Function("S"), sp.cos)


@pytest.mark.parametrize(
    ("question", "answer", "share"),
    [
        # a convention or a common factor: one mistake, whatever it touches
        ("joint-axes", AXES * SIGNS, 0.8), ("joint-axes", -AXES, 0.8), ("joint-axes", AXES * sp.diag(1, -1, 1), 0.8),
        ("position-vectors", -ARMS, 0.8), ("geometric-jacobian", sp.Matrix.vstack(-J, AXES), 0.8),
        ("geometric-jacobian", GEOMETRIC * SIGNS, 0.8), ("jacobian", 3 * J * SIGNS, 0.6),
        ("inverse-jacobian", INVERSE * DET, 0.8), ("inverse-jacobian", INVERSE * sp.Symbol("a2"), 0.8),
        ("inverse-jacobian", -INVERSE * DET, 0.6), ("determinant", "sin(theta3)*a2", 0.5),
        ("inverse-jacobian", INVERSE * sp.cos(sp.Symbol("theta1")), 0.0), ("jacobian", J * DET, 0.0),
        # one known mistake
        ("position", POSITION.subs("d1", 0), 2 / 3), ("position", swap_waves(POSITION), 0.5), ("jacobian", J.T, 0.5),
        ("position", POSITION.subs(sp.sympify("theta2 + theta3"), sp.Symbol("theta3")), 0.5),
        ("joint-axes", "[[0, 0, 0], [0, 1, 1], [1, 0, 0]]", 0.0), ("jacobian", J.subs("theta1", 0), 0.5),
        ("jacobian", J.subs({"theta1": 0, "theta2": 0, "theta3": 1}), 0.0),
        # nothing of this arm
        ("determinant", INVENTED, 0.0), ("position", "[a1*cos(theta1), a2*cos(theta2), a3*cos(theta3)]", 0.0),
        ("position", "[blank, blank, -a2*sin(theta3)]", 0.0), ("position", [POSITION[0], 0, 0], 1 / 3),
        ("position", POSITION.subs({"a1": 7, "a2": 3, "a3": 5}), 0.0),
        # conditions of a set, not values
        ("singular-angles", f"[{FULL}, theta1 = 0, theta1 = pi]", 0.5),
        ("singular-angles", f"[{FULL}, theta1 = 1]", 0.5), ("singular-angles", "[theta3 = 0, theta3 = pi]", 0.5),
        ("singular-angles", f"[{FULL}, theta1 = 0, theta2 = 0]", 0.25), ("singular-angles", "theta3 = k*pi/2", 0.0),
        ("singular-angles", "[theta3 = 0, theta3 = pi, theta2 = 0, theta2 = pi]", 0.25),
        ("singular-angles", "[theta1 = 0, theta1 = pi, theta2 = 0, theta2 = pi, theta3 = 0, theta3 = pi]", 0.0),
    ],
)  # fmt: skip
def test_a_mistake_costs_the_same_however_many_entries_it_changes(question: str, answer: object, share: float) -> None:
    """Try answers for the chapter's elbow arm."""
    text = str(list(answer) if answer.cols == 1 else answer.tolist()) if isinstance(answer, sp.MatrixBase) else answer
    judgement = judge_with_credit(ELBOW, ELBOW[question], str(text), "m")
    assert judgement.share == pytest.approx(share, abs=1e-3), judgement


@pytest.mark.parametrize(
    ("question", "right", "wrong"),
    [
        ("jacobian", J, 2 * J * SIGNS), ("inverse-jacobian", INVERSE, INVERSE * DET), ("jacobian", J, J.T),
        ("position", POSITION, swap_waves(POSITION)), ("position-vectors", ARMS, -ARMS), ("joint-axes", AXES, 2 * AXES),
    ],
)  # fmt: skip
def test_one_more_right_entry_never_earns_less(question: str, right: sp.Matrix, wrong: sp.Matrix) -> None:
    shares, answer = [], wrong.as_mutable()
    for k in range(len(right)):
        shares.append(judge_with_credit(ELBOW, ELBOW[question], str(answer.tolist()), "m").share)
        answer[k] = right[k]
    assert shares == sorted(shares) and shares[0] < 1.0


TOML = """title = "T"
key = "t"
follow_through = 1
[[problem]]
family = "planar-2r"
questions = ["jacobian", "determinant"]
"""


def test_an_assignment_sets_the_credit_of_its_parts(tmp_path: Path) -> None:
    assignment = make_class(tmp_path, toml=TOML + 'credit = {jacobian = "columns", determinant = 0.5}\n')
    parts = {part.name: part for part in assignment.slots[0].generate_problem(assignment.secret, "s").parts}
    assert parts["jacobian"].credit == Credit("columns") and parts["determinant"].credit == Credit("", Fraction(1, 2))
    assert assignment.follow_through == 1
    markings = {assignment.marking_digest}
    for text in (TOML, f"{TOML}credit = 0\n"):
        markings.add(make_class(tmp_path / str(len(markings)), toml=text).marking_digest)
    assert len(markings) == 3


@pytest.mark.parametrize(
    ("text", "message"),
    [
        *(
            (f"{TOML}credit = {wrong}\n", "line 7.*credit")
            for wrong in ('"rows"', "2", "true", '{rank = "whole"}', "[1]")
        ),
        *(
            (TOML.replace("follow_through = 1", f"follow_through = {wrong}"), "line 3.*from 0 to 1")
            for wrong in ("1.5", '"80%"', "true")
        ),
    ],
)
def test_an_invalid_credit_setting_is_an_error(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(QdotError, match=f"assignment.toml: {message}"):
        make_class(tmp_path / "hw", toml=text)


def test_a_mistake_in_a_set_earns_the_same_on_every_arm(family: str) -> None:
    problem = get_problem(family, 0)
    for part in problem.parts:
        if not isinstance(part.answer, ConditionSet):
            continue
        groups = part.answer.group_by_component(part.answer.list_pieces())
        k = next((k for k, group in enumerate(groups) if len(group) > 1), None)
        if k is not None:
            one_root_less = [piece for j, group in enumerate(groups) for piece in group[j == k :]]
            judgement = judge_with_credit(problem, part, f"[{', '.join(map(write_condition, one_root_less))}]", "s")
            assert judgement.share == pytest.approx(2 / 3), judgement
        if len(groups) > 1:
            one_less = [piece for group in groups[1:] for piece in group]
            judgement = judge_with_credit(problem, part, f"[{', '.join(map(write_condition, one_less))}]", "s")
            assert judgement.share in (0.5, 1.0), judgement  # the other conditions may imply it


def write_condition(piece: str) -> str:
    conditions = [condition.replace(" = ", ", ") for condition in piece.split(" and ")]
    equations = [f"Eq({condition})" for condition in conditions]
    return equations[0] if len(equations) == 1 else f"And({', '.join(equations)})"


SHOULDER = "a1 + a2*cos(theta2) + a3*cos(theta2 + theta3)"
SETS = {
    "θ3 = 0, without π": f"theta3 = 0, {SHOULDER} = 0",
    "θ3 = 0, π, without the shoulder's condition": "theta3 = 0, theta3 = pi",
    "θ3 = 0, π and θ2 = 0, π": "theta3 = 0, theta3 = pi, theta2 = 0, theta2 = pi",
    "everything, and also θ1 = 0, π": f"theta3 = 0, theta3 = pi, {SHOULDER} = 0, theta1 = 0, theta1 = pi",
    "every joint at 0 or π": ", ".join(f"theta{k} = {value}" for k in (1, 2, 3) for value in ("0", "pi")),
}
"""Wrong sets of singular configurations of the elbow arm."""


def list_wrong_answers(problem: Problem) -> Iterator[tuple[str, str, str]]:
    """Yield a question, a mistake in the words of docs/partial-credit.md, and its answer."""
    names = ("position", "jacobian", "determinant")
    position, jacobian, (det,) = (problem[name].answer.as_matrix() for name in names)
    first = jacobian.as_mutable()
    first[0, 0] = 0
    for name, mistake, answer in (
        ("jacobian", "the sign and a factor 2 wrong", -2 * jacobian),
        ("jacobian", "one entry zero", first),
        ("position", "d1 left out", position.subs("d1", 0)),
        ("position", "θ3 instead of θ2 + θ3", position.subs(sp.Add(*problem.chain.q[1:]), problem.chain.q[2])),
    ):
        yield name, mistake, str(list(answer) if answer.cols == 1 else answer.tolist())
    yield "determinant", "without sin θ3", f"({det})/sin(theta3)"
    yield "determinant", "cos θ3 instead of sin θ3", f"{det}".replace("*sin(theta3)", "*cos(theta3)")
    yield "determinant", "a made-up product with sin θ3", "a1*a2*a3*sin(theta1)*sin(theta2)*sin(theta3)"
    for mistake, conditions in SETS.items():
        yield "singular-angles", mistake, f"[{conditions}]"


@pytest.mark.whole
def test_the_examples_in_the_docs_earn_the_stated_shares() -> None:
    page = (ROOT / "docs" / "partial-credit.md").read_text(encoding="utf-8")
    for name, mistake, answer in list_wrong_answers(ELBOW):
        share = Fraction(judge_with_credit(ELBOW, ELBOW[name], answer, "credit").share).limit_denominator(100)
        assert f"| {name} | {mistake} | {share} |" in page


def test_numbers_are_marked_as_a_vector() -> None:
    problem = ask_question("joint-rates", PLANAR)
    part = problem.parts[0]
    values = [float(value) for value in part.answer.as_matrix()]
    negated = [-value for value in values]
    one_negated = [-values[0], values[1]]
    for answer, share in ((negated, 0.8), (one_negated, 0.8), ([values[0], 99], 0.5), ([0, 0], 0.0), (values, 1.0)):
        judgement = judge_with_credit(problem, part, str(answer), "n")
        assert judgement.share == share, answer
        assert ("one sign is" in judgement.reason, "signs are" in judgement.reason) == (
            answer is one_negated, answer is negated
        )  # fmt: skip


def test_without_settings_each_question_has_its_credit_rule() -> None:
    assert parse_credit_policy(None, ["jacobian"]) == ()
    assert parse_credit_policy("whole", ["jacobian"]) == (("jacobian", Credit("whole")),)


NUMBERS = (("planar-2r", "joint-rates"), ("planar-3r", "least-norm-rates"), ("scara", "joint-rates"))


@pytest.mark.parametrize(("family", "name"), sample_for_suite(NUMBERS, 2))
@pytest.mark.parametrize("infinite", sample_for_suite(["1/0", "1e400", "-1/0", "0/0"], 1))
def test_an_infinite_number_makes_no_other_number_right(family: str, name: str, infinite: str) -> None:
    problem = generate(ProblemId(family, 3, (name,)))
    numbers = [f"{1.7 * float(number) + 0.3:.4g}" for number in problem.parts[0].answer.as_matrix()]
    (verdict,) = mark(problem, {name: f"[{', '.join([infinite, *numbers[1:]])}]"}, secret="s")
    assert (verdict.judgement.outcome, verdict.points) == (Outcome.WRONG, 0), verdict.judgement.reason


QUESTIONS = ("position", "jacobian", "determinant")
RELATIVE_POSITION = "[a1*cos(theta1) + a2*cos(theta2), a1*sin(theta1) + a2*sin(theta2)]"
RELATIVE_JACOBIAN = "[[-a1*sin(theta1), -a2*sin(theta2)], [a1*cos(theta1), a2*cos(theta2)]]"


def mark_answers(**answers: str) -> dict[str, Verdict]:
    problem = generate(ProblemId("planar-2r", 1, QUESTIONS, variation="chapter"))
    return {verdict.part: verdict for verdict in mark(problem, answers, secret="s")}


def test_a_part_that_follows_states_one_share_of_the_points() -> None:
    verdicts = mark_answers(position=RELATIVE_POSITION, jacobian=RELATIVE_JACOBIAN)
    assert "so you earn half of the points" in verdicts["position"].judgement.reason
    reason = verdicts["jacobian"].judgement.reason
    assert "it earns 80 % of the points" in reason and "you earn" not in reason


def test_a_blank_from_an_earlier_part_is_named() -> None:
    verdicts = mark_answers(jacobian="[[blank, a1], [a2, blank]]", determinant="a1*a2*blank + a2")
    assert "Fill in 'jacobian' first" in verdicts["determinant"].judgement.reason
    assert "2 entries still contain a blank" in verdicts["jacobian"].judgement.reason


def test_a_mistake_that_can_be_made_anywhere_refers_to_the_question() -> None:
    position = "[a1*cos(theta1) + a2*cos(theta1 + theta2), -a1*sin(theta1) + a2*sin(theta1 + theta2)]"
    diagnosis = mark_answers(position=position)["position"].diagnosis
    assert diagnosis is not None and diagnosis.feedback.endswith("See (6.1).")


def test_a_capital_letter_does_not_reveal_a_missing_configuration() -> None:
    assert remove_numbers("Compared with the solution: a singular configuration is missing: theta2 = 0.5") == (
        "Compared with the solution: a singular configuration is missing"
    )
