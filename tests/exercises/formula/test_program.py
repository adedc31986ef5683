"""Compiled expressions: values of every operation, magnitudes that bound rounding, and precise evaluation."""

from fractions import Fraction
from itertools import product
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import assign_regions, compile_program, evaluate, evaluate_precisely, evaluate_steps
from qdot.exercises.formula.trees import Node, ParseError
from tests.support import read_cases

ONE_ARGUMENT = [
    "sin", "cos", "tan", "cot", "sec", "csc", "asin", "acos", "atan", "acot", "sinh", "cosh", "tanh", "exp", "log",
    "sqrt", "abs", "sign",
]  # fmt: skip


@pytest.mark.parametrize("name", ONE_ARGUMENT)
@pytest.mark.parametrize("x", [0.37, -0.62])
def test_double_and_precise_evaluation_agree(name: str, x: float) -> None:
    program = compile_program([parse_formula(f"{name}(x)*2 - 1")])
    coarse = evaluate(program, {"x": np.array([x])}, 1).values[0, 0]
    fine = evaluate_precisely(program, {"x": x}, 40)[0]
    assert complex(coarse) == pytest.approx(complex(fine), rel=1e-13)


def test_atan2_keeps_the_quadrant() -> None:
    program = compile_program([parse_formula("atan2(y, x)")])
    for y, x in ((0.5, 0.2), (0.5, -0.2), (-0.5, -0.2), (0.0, -1.0)):
        coarse = evaluate(program, {"x": np.array([x]), "y": np.array([y])}, 1).values[0, 0]
        fine = float(evaluate_precisely(program, {"x": x, "y": y}, 30)[0])
        assert coarse == pytest.approx(np.arctan2(y, x)) and fine == pytest.approx(np.arctan2(y, x))


def test_equal_subexpressions_are_compiled_once() -> None:
    assert len(compile_program([parse_formula("sin(x)*cos(x) + sin(x)*cos(x)"), parse_formula("sin(x)")]).steps) == 5
    assert len(compile_program([parse_formula("x + y" + " + x - x" * 1000)]).steps) == 3
    program = compile_program([parse_formula("x - (y - x) - -(x + y)")])
    assert evaluate(program, {"x": np.ones(1), "y": np.ones(1)}, 1).values == 3


def test_magnitude_includes_cancelling_terms() -> None:
    program = compile_program([parse_formula("(x + 10**8) - y")])
    value, magnitude = evaluate(program, {"x": np.array([1.0]), "y": np.array([1e8])}, 1)
    assert value[0, 0] == 1
    assert magnitude[0, 0] >= 2e8


@given(st.floats(-3, 3), st.floats(0.1, 2), st.floats(-3, 3))
def test_magnitude_bounds_the_rounding_error(theta: float, a: float, phi: float) -> None:
    text = "(a*cos(t + p) - a*cos(t)*cos(p) + a*sin(t)*sin(p))*10**6 + sqrt(a)*sqrt(a) - a + tan(p/2)**2"
    program = compile_program([parse_formula(text)])
    values = {"a": a, "t": theta, "p": phi}
    coarse, magnitude = evaluate(program, {name: np.array([x]) for name, x in values.items()}, 1)
    fine = evaluate_precisely(program, values, 60)[0]
    assert abs(complex(coarse[0, 0]) - complex(fine)) <= 64 * np.finfo(float).eps * magnitude[0, 0]


@pytest.mark.parametrize("text", ["1/0", "log(0)/log(0)", "0**-1", "1/(x - x)", "1/0 - 1/0", "0*(1/0)"])
def test_undefined_values_are_not_finite(text: str) -> None:
    program = compile_program([parse_formula(text)])
    assert not np.isfinite(evaluate(program, {"x": np.ones(3)}, 3).values).any()
    assert not mpmath.isfinite(evaluate_precisely(program, {"x": 1.0}, 50)[0])


@pytest.mark.parametrize(
    "text",
    ["9**9**9**9", "1/(9**9**9**9)", "x**9**9**9", "exp(exp(exp(exp(9))))", "sinh(sinh(sinh(9999999)))", "sin(10**300)",
     "tan(I*1e300)", "cosh(cosh(1e5))", "2**(1/3)**-9999999", "sqrt(exp(99999))**99", "(x**1000)**1000**1000"],
)  # fmt: skip
def test_precise_evaluation_of_huge_powers_ends(text: str) -> None:
    (value,) = evaluate_precisely(compile_program([parse_formula(text)]), {"x": 1.7}, 200)
    assert mpmath.isfinite(value) or mpmath.isnan(value) or mpmath.isinf(value)


@pytest.mark.parametrize("text", ["[x]", "{x}", "x = 1", "{x: 1}", "...", "x in {1}", "2*[x, x]", "x and x"])
def test_non_scalar_expression_is_refused(text: str) -> None:
    with pytest.raises(ParseError, match="expected a single expression"):
        compile_program([parse_formula(text)])


def test_branches_are_detected() -> None:
    assert compile_program([parse_formula("sqrt(x)")]).has_branches
    assert compile_program([parse_formula("x**(1/2)")]).has_branches
    assert not compile_program([parse_formula("sin(x)**2/cos(x) + exp(x)")]).has_branches


@pytest.mark.parametrize(
    ("text", "op", "exponent"),
    [
        ("x**7", "integer power", 7), ("x**-7", "integer power", -7), ("x**1000", "integer power", 1000),
        ("x**1000000", "power", None), ("x**" + "9" * 400, "power", None), ("x**(1/2)", "power", None),
        ("x**y", "power", None), ("x**(-y)", "power", None), ("x**0.5", "power", None),
    ],
)  # fmt: skip
def test_integer_powers_have_no_branches(text: str, op: str, exponent: int | None) -> None:
    program = compile_program([parse_formula(text)])
    assert (program.steps[-1][0], program.steps[-1][2]) == (op, exponent)
    assert program.has_branches is (op == "power")
    with np.errstate(all="ignore"):
        evaluate(program, {"x": np.array([1.5]), "y": np.array([0.5])}, 1)  # the values don't matter


def test_fractional_exponent_is_not_an_integer_power() -> None:
    program = compile_program([Node("^", (Node("name", value="x"), Node("number", value=Fraction(1, 2))))])
    assert program.steps[-1][0] == "power"
    assert evaluate(program, {"x": np.array([4.0])}, 1).values == 2


def compute_magnitude(text: str, **values: float) -> float:
    columns = {name: np.array([value]) for name, value in values.items()}
    return float(evaluate(compile_program([parse_formula(text)]), columns, 1).magnitudes[0, 0])


def compute_slope(text: str, name: str, **values: float) -> float:
    program, step = compile_program([parse_formula(text)]), mpmath.mpf("1e-20")
    with mpmath.workdps(60):
        ends = [evaluate_precisely(program, {**values, name: values[name] + h}, 60)[0] for h in (step, -step)]
        return float(abs(ends[0] - ends[1]) / (2 * step))


def compute_size(text: str, **values: float) -> float:
    return float(abs(evaluate_precisely(compile_program([parse_formula(text)]), values, 30)[0]))


@pytest.mark.parametrize("text", [f"{name}(u)" for name in ONE_ARGUMENT] + ["u**1", "u**3", "u**-1", "u**-3", "u**0"])
@pytest.mark.parametrize("u", [0.375, -0.625])
def test_magnitude_of_function_propagates_that_of_its_operand(text: str, u: float) -> None:
    """The operand u = (5 + u) - 5 has magnitude 10 + u."""
    magnitudes = compute_magnitude(text.replace("u", "(x - y)"), x=5.0 + u, y=5.0)
    assert magnitudes == pytest.approx(compute_size(text, u=u) + compute_slope(text, "u", u=u) * (10.0 + u), rel=1e-12)


@pytest.mark.parametrize(("u", "v"), [(0.375, 0.5), (-0.625, -1.25)])
def test_magnitude_of_binary_function_propagates_those_of_its_operands(u: float, v: float) -> None:
    at = {"w": 3.0 + u, "x": 3.0, "y": 5.0 + v, "z": 5.0}
    mu, mv = 6.0 + u, 10.0 + v
    assert compute_magnitude("(w - x)*(y - z)", **at) == pytest.approx(mu * mv, rel=1e-12)
    assert compute_magnitude("(w - x)/(y - z)", **at) == pytest.approx(mu * mv / v**2, rel=1e-12)
    for text in ("u**v", "atan2(u, v)"):
        expected = compute_slope(text, "u", u=u, v=v) * mu + compute_slope(text, "v", u=u, v=v) * mv
        expected += compute_size(text, u=u, v=v) if text == "u**v" else 1.0
        magnitudes = compute_magnitude(text.replace("u", "(w - x)").replace("v", "(y - z)"), **at)
        assert magnitudes == pytest.approx(expected, rel=1e-12), text


def test_powers_of_zero_have_values_and_magnitudes() -> None:
    program = compile_program([parse_formula(text) for text in ("x**0", "x**1", "x**2")])
    value, magnitudes = evaluate(program, {"x": np.zeros(1)}, 1)
    assert value[:, 0].tolist() == [1, 0, 0]
    assert magnitudes[:, 0].tolist() == [1, 0, 0]
    assert compute_magnitude("(x - x)**0", x=2.0) == 1
    program = compile_program([parse_formula("(x - y)**y")])
    assert evaluate(program, {"x": np.full(1, 2.0), "y": np.full(1, 2.0)}, 1).values[0, 0] == 0


def test_sign_function_has_three_values() -> None:
    program = compile_program([parse_formula("sign(x)")])
    values = np.array([-3.0, -1.0, 0.0, 1.0, 2.5])
    assert evaluate(program, {"x": values}, 5).values[0].tolist() == [-1, -1, 0, 1, 1]
    assert [evaluate_precisely(program, {"x": x}, 30)[0] for x in values] == [-1, -1, 0, 1, 1]


def list_regions(text: str, points: int, **values: list[Any]) -> list[int]:
    program = compile_program([parse_formula(text)])
    steps = evaluate_steps(program, {name: np.array(column) for name, column in values.items()}, points)
    return list(assign_regions([(program, steps)], points))


def test_regions_are_separated_by_signs_of_operands() -> None:
    """Real and imaginary parts of both operands give 81 regions, each with two points here."""
    signs = list(product((-1, 0, 1), repeat=4))
    columns = [[factor * sign[k] for factor in (1.0, 2.5) for sign in signs] for k in range(4)]
    values = dict(zip("wxyz", columns, strict=True))
    for text in ("sqrt(w + I*x) + abs(y + I*z)", "(w + I*x)**(y + I*z)"):
        regions = list_regions(text, 162, **values)
        assert len(set(regions)) == 81
        assert regions[:81] == regions[81:]
    assert set(list_regions("sin(w)/(1 + x*x) + exp(y)", 162, **values)) == {0}
    assert len(set(list_regions("sqrt(w) + sin(x)*abs(w)", 162, **values))) == 3


def test_regions_combine_both_programs() -> None:
    programs = [compile_program([parse_formula(text)]) for text in ("abs(x)", "abs(y)")]
    at = {"x": np.array([1.0, 1.0, -1.0, -1.0, 2.0]), "y": np.array([1.0, -1.0, 1.0, -1.0, 3.0])}
    regions = list(assign_regions([(program, evaluate_steps(program, at, 5)) for program in programs], 5))
    assert len(set(regions[:4])) == 4
    assert regions[4] == regions[0]


def test_imaginary_rounding_noise_has_no_sign() -> None:
    parts = [0.0, 7e-10, -7e-10, 1.5e-9, -1.5e-9, 1.0]
    for real in (1.0, -1.0):
        regions = list_regions("sqrt(x + I*y)", 6, x=[real] * 6, y=parts)
        assert regions[0] == regions[1] == regions[2]
        assert regions[3] == regions[5]
        assert len(set(regions)) == 3


def evaluate_text_precisely(text: str, digits: int = 30, **values: Any) -> Any:
    return evaluate_precisely(compile_program([parse_formula(text)]), values, digits)[0]


@pytest.mark.parametrize(("text", "inside", "beyond"), read_cases("equal")["limits"])
def test_precise_functions_are_undefined_beyond_a_limit(text: str, inside: float, beyond: float) -> None:
    assert mpmath.isfinite(evaluate_text_precisely(text, x=inside))
    assert mpmath.isnan(evaluate_text_precisely(text, x=beyond))


def test_powers_with_undefined_operands_are_undefined() -> None:
    assert evaluate_text_precisely("0**x", x=2.5) == 0
    assert evaluate_text_precisely("0**x", x=1e9) == 0
    assert evaluate_text_precisely("1**x", x=0.99e5) == 1
    for text in ("(1/0)**x", "x**(1/0)", "0**(1/0)", "log(0)**x", "x**log(0)"):
        assert mpmath.isnan(evaluate_text_precisely(text, x=2.5)), text


def test_precise_values_may_be_fractions_floats_and_mpmath_numbers() -> None:
    with mpmath.workdps(60):
        third, pi = mpmath.mpf(1) / 3, +mpmath.pi
        assert abs(evaluate_text_precisely("3*x - 1", 50, x=Fraction(1, 3))) < 1e-49
        assert abs(evaluate_text_precisely("x - y", 50, x=Fraction(1, 3), y=third)) < 1e-49
        assert abs(evaluate_text_precisely("x - pi", 50, x=pi)) < 1e-49
        assert evaluate_text_precisely("x", 50, x=0.1) == mpmath.mpf(0.1)
        assert abs(evaluate_text_precisely("E - exp(1)", 50)) < 1e-49
        assert evaluate_text_precisely("I*I", 50) == -1
        assert abs(evaluate_text_precisely("0.1*x", 50, x=10.0) - 1) < 1e-49


def test_atan2_is_defined_for_real_arguments_only() -> None:
    program = compile_program([parse_formula("atan2(y, x + I*z)")])
    at = {"x": np.full(2, 0.5), "y": np.full(2, 0.25), "z": np.array([0.0, 1.0])}
    assert np.isfinite(evaluate(program, at, 2).values[0]).tolist() == [True, False]
    program = compile_program([parse_formula("atan2(y + I*z, x)")])
    assert np.isfinite(evaluate(program, at, 2).values[0]).tolist() == [True, False]


def test_number_too_large_for_a_double_is_infinite() -> None:
    text = "1" + "0" * 400
    value, reciprocal = evaluate(compile_program([parse_formula(text), parse_formula(f"1/{text}")]), {}, 1).values[:, 0]
    assert not np.isfinite(value)
    assert reciprocal == 0
    assert evaluate_text_precisely(f"{text}/10**399") == 10
