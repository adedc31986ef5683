"""Marks and mistakes in answers to instructors' own formulas: signs, sines for cosines, numbers, components, frames."""

import json
from typing import Any

import pytest

from qdot.exercises.common.stream import Stream
from qdot.exercises.generation import generate
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.questions.custom.definition import Definition, GivenValue, Texts
from qdot.grader.diagnosis.advice import advise
from qdot.grader.judging.expected_form import read_answer
from qdot.grader.judging.verdict import Verdict
from qdot.grader.marking.marking import mark
from tests.support import DATA, read_cases
from tests.support.suites import sample_for_suite, select_for_suite

MASSES = (("g", "m/s^2"), ("m", "kg"))
AT_POSE = (GivenValue("pose"), GivenValue("rates"))
ACCELERATION = "at(dot([0, 1, 0], ddt(v)), qdd1 = 0, qdd2 = 0)"
GRAVITY = "[diff(m*g*p.y, theta1), diff(m*g*p.y, theta2)]"


def ask(family: str, answer: str, *earlier_questions: str, **settings: Any) -> Problem:
    definition = Definition("mine", answer, (Texts("Mine", "x"),), **settings)
    problem_id = ProblemId(family, 1, (*earlier_questions, "mine"), variation="chapter")
    return generate(problem_id, definitions=[definition])


def mark_one(problem: Problem, answer: str) -> Verdict:
    (verdict,) = mark(problem, {"mine": answer}, secret="s")
    return verdict


def find_mistake(verdict: Verdict) -> str:
    return verdict.diagnosis.names if verdict.diagnosis else ""


CASES = [json.loads(line) for line in (DATA / "own_formulas.jsonl").read_text(encoding="utf-8").splitlines()]


@pytest.mark.parametrize(
    "case", sample_for_suite(CASES, 4), ids=lambda case: f"{case['about']}: {case['formula']} {case['mistake']}"
)
def test_the_nearest_mistake_is_named_and_earns_its_share(case: dict[str, Any]) -> None:
    verdict = mark_one(ask(case["family"], case["formula"], units=MASSES), case["answer"])
    assert (verdict.judgement.share, find_mistake(verdict)) == (case["share"], case["mistake"]), verdict.judgement


@pytest.mark.parametrize("is_rate_known", [False, True])
def test_a_number_without_its_square_has_a_cause(is_rate_known: bool) -> None:
    given = (*AT_POSE, GivenValue("m", low=2, high=2))
    problem = ask("planar-2r", "m*dot(v, v)/2" if is_rate_known else "m*norm(v)^2/2", units=MASSES, given=given)
    energy = float(problem.parts[0].answer.as_matrix()[0])
    assert find_mistake(mark_one(problem, f"{energy**0.5:.6g}")) == "square-missing"  # m v / 2, because m is 2 kg


def test_a_set_has_the_same_marks_and_messages_in_every_form() -> None:
    problem = ask("planar-2r", "zeros(sin(theta1)*cos(theta2))")
    forms = ("0 = s1*s2", "s1*s2 = 0", "theta1 = 0, theta1 = pi, theta2 = 0, theta2 = pi")
    verdicts = [mark_one(problem, form) for form in forms]
    assert [verdict.judgement.share for verdict in verdicts] == [0.25] * len(forms)
    for verdict in verdicts:
        assert verdict.diagnosis is not None and "6.8" not in verdict.diagnosis.feedback


@pytest.mark.whole
@pytest.mark.parametrize("formula", [ACCELERATION, GRAVITY.replace("theta2", "d2"), "m*det(J)"])
def test_a_message_about_the_jacobian_needs_a_question_about_it(formula: str) -> None:
    problem = ask("polar-rp", formula, units=MASSES)
    answers = ["[m*g*(a1*c1 + d2*s1), 0]", "d2*c1*qd1^2", "-a1*s1*qd1^2", "a1*m", "[0, -m*g*c1]"]
    messages = [verdict.diagnosis.feedback for answer in answers if (verdict := mark_one(problem, answer)).diagnosis]
    assert not any("your J" in message for message in messages)


def test_a_link_to_an_earlier_mistake_needs_more_than_one_sign_in_common() -> None:
    problem = ask("polar-rp", "m*det(J)", "jacobian", units=MASSES)
    jacobian = "[[d2*c1 - a1*s1, s1], [a1*c1 + d2*s1, c1]]"  # the sign of one entry
    verdict = mark(problem, {"jacobian": jacobian, "mine": "m*d2"}, secret="s")[1]
    assert verdict.diagnosis is not None and verdict.diagnosis.inherited is None
    assert verdict.judgement.share == 0.8


@pytest.mark.parametrize(
    ("answer", "mistake"),
    [("{theta2: [0, pi]}", "component-missed"), ("[Eq(d3, 0)]", "component-missed"), ("[]", "component-missed")],
)
def test_a_missed_condition_of_an_own_set_is_named(answer: str, mistake: str) -> None:
    verdict = mark_one(ask("spherical", "zeros(p.x, p.y)"), answer)  # d3 = 0 or sin(theta2) = 0
    assert find_mistake(verdict) == mistake and verdict.diagnosis is not None
    assert "Find all ways in which the condition can hold" in verdict.diagnosis.feedback
    assert "J" not in verdict.diagnosis.feedback and "6.8" not in verdict.diagnosis.feedback


@pytest.mark.parametrize(("answer", "is_right"), read_cases("own_questions")["named_entries"])
def test_entries_named_by_their_number_are_read_in_this_order(answer: str, is_right: bool) -> None:
    verdict = mark_one(ask("spherical", "transpose(Jv)*[0, 0, m*g]", units=MASSES), answer)
    assert (verdict.judgement.share == 1) is is_right


@pytest.mark.parametrize(("product", "listed"), read_cases("own_questions")["products"])
def test_a_product_earns_what_its_factors_earn_as_a_list(product: str, listed: str) -> None:
    problem = ask("spherical", "zeros(p.x, p.y)")
    verdicts = [mark_one(problem, text) for text in (product, listed)]
    assert verdicts[0].judgement.share == verdicts[1].judgement.share > 0
    assert find_mistake(verdicts[0]) == find_mistake(verdicts[1])


@pytest.mark.parametrize("text", ["2.261 Nmm", "2.261 N mm", "2.261 kN m"])
def test_a_wrong_prefix_of_a_unit_is_no_mistake_in_lengths(text: str) -> None:
    given = (*AT_POSE, GivenValue("m", low=2, high=5))
    problem = ask("planar-2r", "m*norm(v)", units=MASSES, given=given, unit="N m")
    (value,) = map(float, problem["mine"].answer.as_matrix())
    for number, is_unit in ((value, True), (value / 1000, False)):
        verdict = mark_one(problem, f"{number:.5g}{text.removeprefix('2.261') if is_unit else ' N m'}")
        assert verdict.judgement.share == 0 and verdict.diagnosis is not None
        assert ("Check the unit that you typed" in verdict.diagnosis.feedback) is is_unit


def test_the_reason_for_exchanged_entries_does_not_speak_of_sines() -> None:
    verdict = mark_one(ask("cylindrical", "m*p", units=MASSES), "[m*(a2*s1 + d3*c1), m*(a2*c1 - d3*s1), m*(d1 + d2)]")
    assert find_mistake(verdict) == "rows-exchanged"
    assert verdict.judgement.reason.startswith("a single mistake explains all your errors")


def test_a_direction_that_nothing_loses_gets_no_such_message() -> None:
    verdict = mark_one(ask("planar-2r", "o2 - o1", rows=("x", "y"), is_up_to_factor=True), "[-s12, c12]")
    assert find_mistake(verdict) != "direction-that-moves"


@pytest.mark.parametrize(("formula", "wrong_formula", "mistake"), read_cases("own_questions")["numbers"])
def test_simple_mistakes_in_a_number_are_named(formula: str, wrong_formula: str, mistake: str) -> None:
    given = (*AT_POSE, GivenValue("m", low=2, high=5), GivenValue("g", low=9.81, high=9.81))
    problem, other_problem = (ask("planar-2r", text, units=MASSES, given=given) for text in (formula, wrong_formula))
    answer = [f"{float(number):.5g}" for number in other_problem["mine"].answer.as_matrix()]
    verdict = mark_one(problem, f"[{', '.join(answer)}]")
    assert find_mistake(verdict) == mistake, verdict.diagnosis


@pytest.mark.parametrize(("formula", "wrong_formula", "mistake"), read_cases("own_questions")["vectors"])
def test_mistakes_in_given_vectors_are_named_in_formulas_and_in_numbers(
    formula: str, wrong_formula: str, mistake: str
) -> None:
    group = "force" if "f" in formula else "velocity"
    for digits in (3, 5):
        settings = {"given": (GivenValue("pose"), GivenValue(group))}
        problem, other_problem = (ask("planar-2r", text, **settings) for text in (formula, wrong_formula))
        answer = [f"{float(number):.{digits}g}" for number in other_problem["mine"].answer.as_matrix()]
        assert find_mistake(mark_one(problem, f"[{', '.join(answer)}]")) == mistake
    problem, other_problem = (ask("planar-2r", text) for text in (formula, wrong_formula))
    assert find_mistake(mark_one(problem, other_problem["mine"].answer.as_typed())) == mistake


def test_few_random_numbers_have_a_cause() -> None:
    given = (*AT_POSE, GivenValue("m", low=2, high=5))
    problem, random = ask("planar-2r", "m*dot(v, v)/2", units=MASSES, given=given), Stream("random numbers")
    energy = float(problem["mine"].answer.as_matrix()[0])
    counts = {3: 0, 5: 0}
    for digits in counts:
        for _ in range(select_for_suite(7, 20)):
            typed_number = f"{energy * random.uniform(0.3, 3):.{digits}g}"
            counts[digits] += bool(find_mistake(mark_one(problem, typed_number)))
    assert counts[3] <= 3 and counts[5] == 0, counts


def test_a_symbol_that_cancels_is_named() -> None:
    """The component of the velocity along the second link doesn't depend on the second rate."""
    problem = ask("planar-2r", "m*dot(x2, v)", units=MASSES)
    verdict = mark_one(problem, "m*a1*s2*(qd1 + qd2*(1 + c2))")
    assert find_mistake(verdict) == "term-surplus" and "contains qd2" in str(verdict.diagnosis)
    remark = advise(problem, problem["mine"], read_answer(problem, problem["mine"], "m*a1*c2*(qd1 + 3*qd2)"))
    assert remark is not None and "contains qd2, but the requested result does not depend on it" in remark.feedback


@pytest.mark.parametrize(
    ("digits", "sentence"), [(1, "has too few digits"), (2, "is correct except for rounding"), (7, "")]
)
def test_too_few_digits_are_named(digits: int, sentence: str) -> None:
    problem = ask("planar-2r", "2*m", units=MASSES, given=(GivenValue("m", low=0.65885, high=0.65885),))
    verdict = mark_one(problem, f"{1.3177 * (1.02 if digits == 7 else 1):.{digits}g}")
    feedback = verdict.diagnosis.feedback if verdict.diagnosis else ""
    assert sentence in feedback and ("digits" in feedback) is bool(sentence)


@pytest.mark.parametrize(
    ("answer", "share", "mistake"),
    [
        ("theta2 = atan((a2 + a3*c3)/(a3*s3))", 2 / 3, "one-root-only"),
        ("[And(Eq(cos(theta2), 0), Eq(cos(theta2 + theta3), 0))]", 0.0, "terms-set-to-zero"),
        ("a2*c2 + a3*c23", 0.0, ""), ("det J = 0", 0.0, ""),
    ],
)  # fmt: skip
def test_a_condition_on_several_joints_is_found_in_part(answer: str, share: float, mistake: str) -> None:
    verdict = mark_one(ask("planar-prr", "zeros(J[2, 2])"), answer)
    assert verdict.judgement.share == pytest.approx(share, abs=1e-3)
    assert find_mistake(verdict) == mistake and (mistake or verdict.diagnosis is None)


@pytest.mark.parametrize(("formula", "answer", "reason"), read_cases("own_questions")["no_answers"])
def test_the_reason_names_what_is_no_answer(formula: str, answer: str, reason: str) -> None:
    given = AT_POSE if formula == "norm(v)" else ()
    problem = ask(
        "planar-2r", formula, units=MASSES if formula == "m*J" else (), given=given, unit="m/s" if given else ""
    )
    assert mark_one(problem, answer).judgement.reason.startswith(reason)
