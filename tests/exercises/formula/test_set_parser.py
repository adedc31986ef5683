"""Claimed conditions: typed values are evaluated to 50 digits, and claims that take too long are refused."""

from fractions import Fraction

import mpmath
import pytest

from qdot.exercises.formula.angles import find_multiple_of_pi
from qdot.exercises.formula.conditions import agree_to_double_precision, vanishes_at
from qdot.exercises.formula.equality import DOUBLE_TOLERANCE
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import evaluate_constant
from qdot.exercises.formula.set_parser import parse_typed_set
from qdot.exercises.formula.trees import ParseError

JOINTS = ("theta1", "theta2", "theta3")


@pytest.mark.parametrize(
    ("text", "value"), [("pi/3", mpmath.pi / 3), ("acos(1/3)", mpmath.acos(mpmath.mpf(1) / 3)), ("sqrt(-4)*I", -2)]
)
def test_constant_is_evaluated_to_fifty_digits(text: str, value: mpmath.mpf) -> None:
    with mpmath.workdps(50):
        assert abs(evaluate_constant(parse_formula(text)) - mpmath.mpf(value)) < 1e-15
        assert mpmath.nstr(evaluate_constant(parse_formula("pi")), 49) == mpmath.nstr(+mpmath.pi, 49)


@pytest.mark.parametrize("text", ["acos(2)", "1/0", "log(0)", "a1", "theta1", "I", "-I", "1 + I/1000", "1 - I/1000"])
def test_non_real_constant_has_no_value(text: str) -> None:
    assert evaluate_constant(parse_formula(text)) is None


@pytest.mark.parametrize("off", [1e-3, -1e-3, 1.2e-12, -1.2e-12])
def test_different_values_do_not_agree(off: float) -> None:
    with mpmath.workdps(50):
        for value in (mpmath.mpf(0), mpmath.mpf(1), -mpmath.pi / 3):
            assert agree_to_double_precision(value, value, True)
            assert not any(
                agree_to_double_precision(value + mpmath.mpf(off), value, is_angle) for is_angle in (True, False)
            )


def test_angles_agree_modulo_full_turns_and_lengths_do_not() -> None:
    with mpmath.workdps(50):
        turn = 2 * mpmath.pi
        for turns in (-3, -1, 1, 2):
            assert agree_to_double_precision(mpmath.mpf(1) + turns * turn, mpmath.mpf(1), True)
            assert not agree_to_double_precision(mpmath.mpf(1) + turns * turn, mpmath.mpf(1), False)
        assert not agree_to_double_precision(mpmath.mpf(1) + mpmath.pi, mpmath.mpf(1), True)


def test_tolerance_is_relative_for_large_and_absolute_for_small_values() -> None:
    for size in (-40, -0.01, 0.01, 40):
        allowed = DOUBLE_TOLERANCE * max(1, abs(size))
        for sign in (1, -1):
            assert agree_to_double_precision(mpmath.mpf(size + sign * 0.9 * allowed), mpmath.mpf(size), False)
            assert not agree_to_double_precision(mpmath.mpf(size + sign * 1.1 * allowed), mpmath.mpf(size), False)


def test_condition_vanishes_only_at_its_zeros() -> None:
    zero = parse_formula("a1 + a2*cos(theta2)")
    with mpmath.workdps(50):
        symbols = {"a1": mpmath.mpf(1) / 4, "a2": mpmath.mpf(1) / 2}
        exact = 2 * mpmath.pi / 3
        tiny = {"a1": mpmath.mpf("0.25e-30"), "a2": mpmath.mpf("0.5e-30")}
        for off, holds in ((0, True), (1e-13, True), (-1e-13, True), (1e-11, False), (-1e-11, False)):
            for lengths in (symbols, tiny):
                assert vanishes_at(zero, {"theta2": exact + off}, lengths) is holds
                assert (
                    vanishes_at(parse_formula("1000*(a1 + a2*cos(theta2))"), {"theta2": exact + off}, lengths) is holds
                )
        assert not vanishes_at(parse_formula("1/(a1 - a1)"), {}, symbols)


@pytest.mark.parametrize(
    ("texts", "turns"),
    [
        (["0", "pi - pi"], 0), (["pi", "5*pi", "2*pi/3 + pi/3"], 1), (["-pi/2"], Fraction(3, 2)),
        (["1", "pi + 1", "theta1", "pi/2 + theta1", "acos(1/3)", "pi*a1", "pi + asin(1/3)", "I*pi"], None),
    ],
)  # fmt: skip
def test_rational_multiples_of_pi_are_recognized(texts: list[str], turns: Fraction | None) -> None:
    assert [find_multiple_of_pi(parse_formula(text)) for text in texts] == [turns] * len(texts)


@pytest.mark.parametrize(
    ("piece", "taken", "refused"),
    [
        ("cos(theta1 + {}*theta2) = 0", 200, 500),  # no joint is isolated, so zeros must be searched
        ("theta1 = theta2 + {} and theta2 = theta1/2", 200, 600),  # coupled values must be searched, too
        ("theta1 = theta2 + {} and theta3 = theta2", 600, None), ("theta2 = {}/1000", 2000, None),
    ],
)  # fmt: skip
def test_number_of_cases_is_limited(piece: str, taken: int, refused: int | None) -> None:
    def claim(count: int) -> str:
        return "{" + ", ".join(piece.format(k) for k in range(1, count + 1)) + "}"

    assert len(parse_typed_set(parse_formula(claim(taken)), JOINTS)) == taken
    if refused:
        with pytest.raises(ParseError, match=f"with their {refused} cases, are too long"):
            parse_typed_set(parse_formula(claim(refused)), JOINTS)


def test_each_integer_variable_multiplies_the_cases() -> None:
    terms = " + ".join(f"sin({k}*theta1)" for k in range(1, 20))
    assert len(parse_typed_set(parse_formula("theta1 = k*pi"), JOINTS)) == 2
    for tied in (f"{terms} = k + n + m", f"theta3 = 0 and {terms} = k + n + m", f"[{{{terms} - k*n*m}}]"):
        with pytest.raises(ParseError, match="too many integers"):
            parse_typed_set(parse_formula(tied), JOINTS)
        with pytest.raises(ParseError, match="with their"):  # fewer cases, refused later because of their steps
            parse_typed_set(parse_formula(tied.replace("m", "1").replace("*1", "")), JOINTS)


@pytest.mark.parametrize(
    "text",
    [
        "{theta1 = k*pi, theta2 = n*pi, LONG = m}", "[theta1 = k*pi, theta2 = n*pi, LONG = m]",
        "{theta1: k*pi, theta2: n*pi, theta3: {m*pi, LONG2}}", "theta1 = k*pi or theta2 = n*pi or LONG = m",
        "theta1 = k*pi and theta2 = n*pi and theta3 = LONG2", "theta1 in {k*pi, LONG2}",
        "theta1 = {k*pi, n*pi/2, LONG2 + m*pi}",
    ],
)  # fmt: skip
def test_integers_of_different_conditions_do_not_multiply(text: str) -> None:
    """Each condition has 13 cases of some hundred nodes; multiplied they would be 2,197."""
    long = " + ".join(f"sin({k}*theta1)" for k in range(1, 20))
    claimed = parse_typed_set(parse_formula(text.replace("LONG2", "pi" + " + pi" * 40).replace("LONG", long)), JOINTS)
    assert claimed
