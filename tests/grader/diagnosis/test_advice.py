"""Advice on a wrong answer without a known mistake: it is true, and reveals nothing of the right answer."""

import pytest

from qdot import generate
from qdot.exercises.chapter import make_planar_2r
from qdot.grader.diagnosis.advice import advise
from qdot.grader.judging.expected_form import read_answer
from qdot.grader.marking.marking import mark
from tests.support import read_cases
from tests.support.problems import ask_question, get_problem

TWO_R = (
    "[[a1*cos(theta1 + {pi}/3) - 0.35*sin(theta1 + theta2 + {pi}/3)],"
    " [a1*sin(theta1 + {pi}/3) {sign} 0.35*cos(theta1 + theta2 + {pi}/3)]]"
)


@pytest.mark.parametrize(("question", "answer", "beginning"), read_cases("answers")["advice"])
def test_advice_names_the_simplest_thing_that_is_wrong(question: str, answer: str, beginning: str) -> None:
    problem = ask_question(question, make_planar_2r())
    advice = advise(problem, problem.parts[0], read_answer(problem, problem.parts[0], answer), "advice")
    assert advice is not None and advice.mistakes == ()
    assert advice.feedback.startswith(beginning)


def test_advice_without_joint_angles_names_no_place() -> None:
    problem = get_problem("cartesian", 0)
    part = problem["determinant"]
    advice = advise(problem, part, read_answer(problem, part, "7"), "advice")
    assert advice is not None and advice.feedback.startswith("Draw the arm and calculate the result by hand.")


@pytest.mark.parametrize(("question", "answer"), [("jacobian-size", "12"), ("rank", "[1, 2]"), ("joint-rates", "0.5")])
def test_no_number_is_to_be_checked_in_an_answer_of_the_wrong_shape(question: str, answer: str) -> None:
    problem = ask_question(question, make_planar_2r())
    (part,) = problem.parts
    assert advise(problem, part, read_answer(problem, part, answer), "advice") is None


@pytest.mark.parametrize(
    ("arm", "question", "answer"),
    [
        ("planar-2r/3", "joint-rates", "-0.247, 0.580"), ("planar-2r/3", "manipulability", "0.35 m^2"),
        ("elbow-3r/2", "rank", "1"),
    ],
)  # fmt: skip
def test_numbers_and_counts_get_no_advice_on_factors(arm: str, question: str, answer: str) -> None:
    problem = generate(f"{arm}@chapter", [question])
    advice = advise(problem, problem.parts[0], read_answer(problem, problem.parts[0], answer), "advice")
    assert advice is not None and advice.feedback.startswith("Calculate ")


AXES = "[[0, {sign}s1, {cos}*s1*(1 - c2) + s2*c1], [0, c1, s1*s2 + {cos}*(c1*c2 - c1)], [1, {cos}, c2 + 0.00001*{cos}]]"


@pytest.mark.parametrize(
    ("arm", "question", "answer", "is_rounding"),
    [  # expected: 1.391223934 and 0.3918262811
        ("polar-rp/3@zeros", "joint-rates", "[1.4, 0.39]", True),
        ("polar-rp/3@zeros", "joint-rates", "[1.3, 0.39]", True),  # truncated
        ("polar-rp/3@zeros", "joint-rates", "[1.39, 0.4]", True),
        ("polar-rp/3@zeros", "joint-rates", "[1, 0.4]", False),
        ("polar-rp/3@zeros", "joint-rates", "[1.4, 0.38]", False),
        ("polar-rp/3@zeros", "joint-rates", "[-1.4, 0.39]", False),
        ("planar-2r/3@zeros", "position", TWO_R.format(pi="3.1416", sign="+"), True),
        ("planar-2r/3@zeros", "position", TWO_R.format(pi="3.14", sign="+"), True),
        ("planar-2r/3@zeros", "position", TWO_R.format(pi="3.1416", sign="-"), False),
        ("planar-2r/3@zeros", "position", TWO_R.format(pi="3.2", sign="+"), False),
        ("wrist-zyz/1@chapter", "joint-axes", AXES.format(cos="3.673e-6", sign="-"), True),  # of 1.5708, multiplied out
        ("wrist-zyz/1@chapter", "joint-axes", AXES.format(cos="7.963e-4", sign="-"), True),  # of 1.57
        ("wrist-zyz/1@chapter", "joint-axes", AXES.format(cos="3.673e-6", sign="+"), False),
    ],
)
def test_answers_right_except_for_rounding_are_recognised(
    arm: str, question: str, answer: str, is_rounding: bool
) -> None:
    problem = generate(arm, [question])
    (verdict,) = mark(problem, {question: answer}, secret="s")
    assert verdict.judgement.share < 1 and verdict.diagnosis is not None
    assert verdict.diagnosis.feedback.startswith("Your answer is correct except for rounding.") is is_rounding
    assert not (is_rounding and verdict.diagnosis.mistakes)
    assert "j" not in verdict.judgement.reason.split(": yours")[-1]


@pytest.mark.parametrize(("answer", "words"), read_cases("answers")["advice_on_sets"])
def test_advice_on_joined_conditions_is_true(answer: str, words: str) -> None:
    problem = get_problem("planar-3r", 0, variation="lengths")
    part = problem["singular-angles"]
    advice = advise(problem, part, read_answer(problem, part, answer), "advice")
    assert advice is not None and words in advice.feedback
    assert "whatever the other joints are" not in advice.feedback


def test_marking_gives_advice_if_no_mistake_is_named() -> None:
    problem = get_problem("elbow-3r", 0)
    verdicts = mark(problem, {"determinant": "theta1**2 + 3*theta3"}, secret="s")
    verdict = next(verdict for verdict in verdicts if verdict.part == "determinant")
    assert verdict.diagnosis is not None and verdict.diagnosis.feedback and not verdict.diagnosis.names
