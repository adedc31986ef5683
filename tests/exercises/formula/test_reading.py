"""Typed answers: correct answers are accepted in any notation, and unclear ones are refused quickly."""

import pytest

from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.names import split_name
from qdot.exercises.formula.notation import to_plain_text
from qdot.exercises.formula.parser import parse_formula
from qdot.grader.judging.verdict import Outcome
from tests.support import read_cases
from tests.support.judging import judge_expression, judge_matrix, judge_singular
from tests.support.suites import sample_for_suite, select_for_suite

ANGLES = dict.fromkeys(("theta1", "theta2", "theta3", "alpha1"), "angle")
LENGTHS = dict.fromkeys(("a1", "a2", "a3"), "length")
DOMAIN = Domain({**ANGLES, **LENGTHS, **dict.fromkeys(("d3", "qd1", "qd2", "vx", "vy", "wz"), "signed")})
POSITION = "a1*cos(theta1) + a2*cos(theta1 + theta2)"
NOTATIONS = read_cases("notations")


def test_joint_rates_are_parsed_without_known_symbols() -> None:
    for text in NOTATIONS["writings"]["qd1"]:
        assert parse_formula(text).value == "qd1", text


@pytest.mark.parametrize("reference", [POSITION, *NOTATIONS["writings"]])
def test_formula_is_accepted_in_any_notation(reference: str) -> None:
    for text in NOTATIONS["writings"].get(reference, NOTATIONS["positions"]):
        judged = judge_expression(text, reference, DOMAIN, "s")
        assert judged.outcome is Outcome.CORRECT, (text, judged.reason)


def test_matrix_is_accepted_in_any_notation() -> None:
    for text in NOTATIONS["matrices"]:
        judged = judge_matrix(text, [["a1", "0"], ["0", "cos(theta1+theta2)"]], DOMAIN, "s")
        assert judged.outcome is Outcome.CORRECT, (text, judged.reason)


@pytest.mark.parametrize(("text", "message"), NOTATIONS["refused"])
def test_ambiguous_or_meaningless_formula_is_refused(text: str, message: str) -> None:
    judged = judge_expression(text, "sin(theta1/2)", DOMAIN, "s")
    assert judged.outcome is Outcome.WRONG
    assert message in judged.reason


MANY = select_for_suite(8_000, 40_000)
HOSTILE = [
    " " * 200_000 + "x", "a1" + " " * 200_000 + "! ", "\n" * 100_000 + "$a1", "\\frac" * 3000, "\\frac{" * 3000,
    "{" * 20000, "\\sqrt[" * 3000, "\\begin{matrix}" * 2000, "_" * 5000, "^" * 5000, "_{" * 5000, "\\dot" * 5000,
    "a1c12" * 4000, "s1" * 20000, "cos" * 5000, "½" * 9000, "²" * 9000, "°" * 9000, "θ̇" * 9000, "[;" * 9000,
    "[" + ";" * 20000 + "]", "\ud800", "\x00", "a1" + "\u0307" * 500, "$" * 9000, "sin^" * 4000, "sin " * 4000,
    "Matrix(9**9,9**9,[1])", "Matrix(0,0,[])", "atan2a1", "diag(" + "a1," * 3000 + ")",
    "Lambda(x, " + "1+" * 5000 + "x)", "1e-400+" * MANY + "1", "sin(9e399" + "*9e399" * MANY + ")",
    "sqrt(" + "+".join(f"1/{10**12 + k}" for k in range(MANY // 2)) + ")", "t1" * 30, "theta1.diff(" * 3000,
]  # fmt: skip


@pytest.mark.parametrize("text", sample_for_suite(HOSTILE, 6), ids=lambda text: ascii(text[:12]))
def test_hostile_formula_ends_in_a_verdict(text: str) -> None:
    assert judge_expression(text, "a1", DOMAIN, "s").outcome in (Outcome.WRONG, Outcome.MISSING)
    assert judge_matrix(text, [["a1", "0"]], DOMAIN, "s").outcome in (Outcome.WRONG, Outcome.MISSING)


_SUM = "+".join(f"sin({k}*theta1 + theta2^2)" for k in range(1, 330))
_MANY = " or ".join("+".join(f"sin({k}*theta1+{i}*theta2)" for k in range(2, 9)) for i in range(2, 22))
LONG = [
    "theta2 = " + "a1+" * 3000 + "a1", "theta2 = k*pi" + "+a1" * 3000, "a1+" * 3000 + "cos(theta1) = 0",
    "{theta2: [" + "pi*(k+n)," * MANY + "0]}", "{" + "k+n+m," * MANY + "0}", "k*theta1 + n = m", f"{_SUM} = k",
    f"({_MANY}) and ({_MANY.replace('sin', 'cos')})", "theta1 = 0 or " * MANY + "theta1 = 0",
    "+".join(f"{k}*theta1^{k}" for k in range(1, 500, 9)) + " = 1",
    "cos(theta1) + log(theta2/0) = 1",
]  # fmt: skip


@pytest.mark.parametrize("text", sample_for_suite(LONG, 4), ids=lambda text: text[:12])
def test_hostile_condition_ends_in_a_verdict(text: str) -> None:
    judged = judge_singular(text, ["sin(theta2) = 0"], ["theta1", "theta2"], DOMAIN, "s")
    assert judged.outcome is Outcome.WRONG


WHOLE_TURNS = [
    "theta2 = pi*m", "theta2 = m*pi", "theta2 = pi m", "theta2 in {pi*m}", "{theta2: pi*m}",  # not metres
    "theta2 = k*n*m*pi", "theta2 in {" + ",".join(f"{k}*k*pi" for k in range(300)) + "}",
]  # fmt: skip


@pytest.mark.parametrize("text", WHOLE_TURNS, ids=lambda text: text[:20])
def test_integer_multiples_are_accepted_in_any_notation(text: str) -> None:
    judged = judge_singular(text, ["sin(theta2) = 0"], ["theta1", "theta2"], DOMAIN, "s")
    assert judged.outcome is Outcome.CORRECT, judged.reason


def test_symbols_of_the_problem_take_precedence_over_habits() -> None:
    known = frozenset({"c1", "q1", "e", "m", "theta12", "theta1", "theta2"})
    assert all(split_name(name, known)[0].names == (name,) for name in known)
    assert to_plain_text("c1*2 m", known) == "c1*2 m" and to_plain_text("pi*m", set()) == "pi*m"
    assert parse_formula("e*m", known).args[0].value == "e"


def test_names_are_split_only_at_dots_without_a_problem() -> None:
    assert parse_formula("a1a2").value == "a1a2"
    assert parse_formula("a1.a2.sin(theta2)") == parse_formula("a1*a2*sin(theta2)")
    assert parse_formula("a1.foo").value == "a1.foo"


@pytest.mark.parametrize(("text", "same"), NOTATIONS["alike"] + NOTATIONS["alike_in_unicode"])
def test_equivalent_notations_parse_alike(text: str, same: str) -> None:
    assert parse_formula(text, DOMAIN.roles) == parse_formula(same, DOMAIN.roles)


def test_name_after_number_is_a_factor_inside_a_product() -> None:
    """A unit at the end of a product can elsewhere be a symbol of the problem or an integer variable."""
    assert parse_formula("a1 m*a2", DOMAIN.roles) == parse_formula("a1*m*a2", DOMAIN.roles)
    assert parse_formula("pi m", DOMAIN.roles) == parse_formula("pi*m", DOMAIN.roles)
    assert parse_formula("[2 m]", {"m"}) == parse_formula("[2*m]", {"m"})


def test_equal_symbols_of_long_sums_are_collected() -> None:
    long = POSITION + " + a1 - a1" * 300 + " - a2*2" + " - a2" * 200 + " + a2*202 + theta3 - theta3"
    assert judge_expression(long, POSITION, DOMAIN, "s").outcome is Outcome.CORRECT
    assert judge_expression(long + " + a1", POSITION, DOMAIN, "s").outcome is Outcome.WRONG
    assert "'k' is not a symbol" in judge_expression(long + " + k", POSITION, DOMAIN, "s").reason
    assert parse_formula("[" + "a1 + " * 150 + "a1, 0]", {"a1"}).args[1] == parse_formula("0")
