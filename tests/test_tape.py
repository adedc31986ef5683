"""Tapes: values of every operation, magnitudes that bound rounding, and many digits without end."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from exercises.formula.expression import read
from exercises.formula.tape import compile_tape, evaluate, evaluate_precisely
from exercises.formula.trees import ReadError

ONE_ARGUMENT = [
    "sin", "cos", "tan", "cot", "sec", "csc", "asin", "acos", "atan", "acot", "sinh", "cosh", "tanh", "exp", "log",
    "sqrt", "abs", "sign",
]  # fmt: skip


@pytest.mark.parametrize("name", ONE_ARGUMENT)
@pytest.mark.parametrize("x", [0.37, -0.62])
def test_double_and_many_digits_agree(name: str, x: float) -> None:
    tape = compile_tape([read(f"{name}(x)*2 - 1")])
    coarse = evaluate(tape, {"x": np.array([x])}, 1)[0][0, 0]
    fine = evaluate_precisely(tape, {"x": x}, 40)[0]
    assert complex(coarse) == pytest.approx(complex(fine), rel=1e-13)


@pytest.mark.parametrize(("y", "x"), [(0.5, 0.2), (0.5, -0.2), (-0.5, -0.2), (0.0, -1.0)])
def test_the_quadrant_is_kept(y: float, x: float) -> None:
    tape = compile_tape([read("atan2(y, x)")])
    found = evaluate(tape, {"x": np.array([x]), "y": np.array([y])}, 1)[0][0, 0]
    assert found == pytest.approx(np.arctan2(y, x))
    assert float(evaluate_precisely(tape, {"x": x, "y": y}, 30)[0]) == pytest.approx(np.arctan2(y, x))


def test_equal_parts_occur_once_and_equal_terms_are_counted() -> None:
    assert len(compile_tape([read("sin(x)*cos(x) + sin(x)*cos(x)"), read("sin(x)")]).steps) == 5
    assert len(compile_tape([read("x + y" + " + x - x" * 1000)]).steps) == 3
    assert evaluate(compile_tape([read("x - (y - x) - -(x + y)")]), {"x": np.ones(1), "y": np.ones(1)}, 1)[0] == 3


def test_what_cancels_shows_in_the_magnitude() -> None:
    tape = compile_tape([read("(x + 10**8) - y")])
    value, magnitude = evaluate(tape, {"x": np.array([1.0]), "y": np.array([1e8])}, 1)
    assert value[0, 0] == 1
    assert magnitude[0, 0] >= 2e8


@given(st.floats(-3, 3), st.floats(0.1, 2), st.floats(-3, 3))
def test_the_magnitude_bounds_the_error(theta: float, a: float, phi: float) -> None:
    text = "(a*cos(t + p) - a*cos(t)*cos(p) + a*sin(t)*sin(p))*10**6 + sqrt(a)*sqrt(a) - a + tan(p/2)**2"
    tape = compile_tape([read(text)])
    values = {"a": a, "t": theta, "p": phi}
    coarse, magnitude = evaluate(tape, {name: np.array([x]) for name, x in values.items()}, 1)
    fine = evaluate_precisely(tape, values, 60)[0]
    assert abs(complex(coarse[0, 0]) - complex(fine)) <= 64 * np.finfo(float).eps * magnitude[0, 0]


@pytest.mark.parametrize("text", ["1/0", "log(0)/log(0)", "0**-1", "1/(x - x)", "1/0 - 1/0", "0*(1/0)"])
def test_what_is_undefined_is_not_a_number(text: str) -> None:
    tape = compile_tape([read(text)])
    assert not np.isfinite(evaluate(tape, {"x": np.ones(3)}, 3)[0]).any()
    assert not mpmath.isfinite(evaluate_precisely(tape, {"x": 1.0}, 50)[0])


@pytest.mark.parametrize(
    "text",
    ["9**9**9**9", "1/(9**9**9**9)", "x**9**9**9", "exp(exp(exp(exp(9))))", "sinh(sinh(sinh(9999999)))", "sin(10**300)",
     "tan(I*1e300)", "cosh(cosh(1e5))", "2**(1/3)**-9999999", "sqrt(exp(99999))**99", "(x**1000)**1000**1000"],
)  # fmt: skip
def test_many_digits_do_not_run_away(text: str) -> None:
    (value,) = evaluate_precisely(compile_tape([read(text)]), {"x": 1.7}, 200)
    assert mpmath.isfinite(value) or mpmath.isnan(value) or mpmath.isinf(value)


@pytest.mark.parametrize("text", ["[x]", "{x}", "x = 1", "{x: 1}", "...", "x in {1}", "2*[x]", "x and x"])
def test_what_is_no_scalar_is_refused(text: str) -> None:
    with pytest.raises(ReadError, match="where a single expression is due"):
        compile_tape([read(text)])


def test_a_power_of_zero_has_a_magnitude() -> None:
    value, magnitude = evaluate(compile_tape([read("(1 - x)**2"), read("x**0")]), {"x": np.array([1.0])}, 1)
    assert value[:, 0].tolist() == [0, 1]
    assert np.isfinite(magnitude).all()


def test_branches_are_known() -> None:
    assert compile_tape([read("sqrt(x)")]).branches
    assert compile_tape([read("x**(1/2)")]).branches
    assert not compile_tape([read("sin(x)**2/cos(x) + exp(x)")]).branches
