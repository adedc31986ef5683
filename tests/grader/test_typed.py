"""Answers in forms that were once refused, or that we failed on: found by asking Python and the site the same."""

import pytest

from exercises.formula.identity import Domain
from grader.verdict import Outcome
from tests.support.judging import judge_direction, judge_expression, judge_numbers, judge_singular


@pytest.mark.parametrize("text", ["0.5", "0,5", "０,５", "v = 0.5", "v = 0,5", "50 cm", "50,0 cm", "[0.5]", "1/2 m"])
def test_one_number_may_be_written_as_a_formula_may(text: str) -> None:
    assert judge_numbers(text, [0.5], ["m"], 0.005, 1e-6).outcome is Outcome.CORRECT


def test_a_factor_that_no_double_holds_is_no_failure_of_ours() -> None:
    judged = judge_expression("cos(9e399*theta1)", "cos(theta1)", Domain({"theta1": "angle"}), "s")
    assert judged.outcome is Outcome.WRONG


@pytest.mark.parametrize("text", ["a1*blank", "x = blank", "lambda theta1: ... m "])
def test_a_formula_with_a_blank_in_it_is_wrong(text: str) -> None:
    assert judge_expression(text, "a1", Domain({"a1": "length"}), "s").outcome is Outcome.WRONG


@pytest.mark.parametrize(
    "text", ["sin(theta2)^4 = 0", "-(a1*sin(theta2)^2)^2", "sqrt(sin(theta2)**6) = 0", "sin(theta2)^0.5"]
)
def test_zeros_of_a_power_are_those_of_its_base(text: str) -> None:
    domain = Domain({"theta1": "angle", "theta2": "angle", "a1": "length"})
    due, joints = ["theta2 = 0", "theta2 = pi"], ["theta1", "theta2"]
    assert judge_singular(text, due, joints, domain, "s").outcome is Outcome.CORRECT
    for other in (text.replace("sin", "cos"), "sin(theta2)^0", "sin(theta2)^-2"):
        assert judge_singular(other, due, joints, domain, "s").outcome is not Outcome.CORRECT


def test_a_direction_is_judged_where_an_entry_vanishes() -> None:
    """Configurations have two decimals, so that 0 comes up in one of some hundred answers."""
    domain, vanishing = Domain({"theta1": "angle"}), 0
    for k in range(1000):
        judged = judge_direction("[-cos(theta1), cos(theta1)]", ["-sin(theta1)", "cos(theta1)"], domain, f"{k}")
        assert judged.outcome is Outcome.WRONG
        example = judged.certificate.counterexample if judged.certificate else None
        assert example is not None and example["yours"] != example["expected"]
        vanishing += example.get("pivot") is None
        assert ("should be 0" in judged.reason) == (example.get("pivot") is None)
    assert vanishing
