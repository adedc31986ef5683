"""Trigonometric polynomials: the Fourier form decides equality, the factored form keeps the function."""

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from qdot.exercises.arm.trigonometry import _factor_polynomial as polynomial_factors
from qdot.exercises.arm.trigonometry import (
    are_identical,
    compute_fourier_form,
    factor_trig,
    to_textbook_form,
    write_in_textbook_form,
)
from tests.support import read_cases
from tests.support.suites import select_for_suite

T1, T2, T3, A1, A2, A3 = sp.symbols("theta1 theta2 theta3 a1 a2 a3")
ANGLES = [T1, T2, T1 + T2, T1 - T2, T1 + T2 + T3, 2 * T1, T3]
terms = st.builds(
    lambda number, length, trigs: sp.Mul(number, length, *trigs),
    st.integers(-3, 3),
    st.sampled_from([sp.S.One, A1, A2, A1 * A2, A3**2]),
    st.lists(st.sampled_from([f(angle) for f in (sp.sin, sp.cos) for angle in ANGLES]), max_size=3),
)
polynomials = st.lists(terms, min_size=1, max_size=4).map(lambda items: sp.Add(*items))


def evaluate_at_point(expression: sp.Expr) -> float:
    values = {T1: 0.7, T2: -1.9, T3: 2.3, A1: 0.31, A2: 1.7, A3: 0.83}
    return float(expression.xreplace({k: sp.Float(v, 30) for k, v in values.items()}).evalf(25))


@given(polynomials)
def test_fourier_form_keeps_the_function(expression: sp.Expr) -> None:
    value = evaluate_at_point(compute_fourier_form(expression).to_expression())
    assert value == pytest.approx(evaluate_at_point(expression), abs=1e-9)


@settings(max_examples=60)
@given(polynomials)
def test_factored_form_keeps_the_function(expression: sp.Expr) -> None:
    assert are_identical(factor_trig(expression).to_expression(), expression)
    assert are_identical(to_textbook_form(expression), expression)


@settings(max_examples=select_for_suite(4, 40))
@given(polynomials, polynomials)
def test_textbook_form_keeps_roots_quotients_and_other_functions(a: sp.Expr, b: sp.Expr) -> None:
    for expression in (a * sp.sqrt(b**2 + 1), a / (b**2 + 2) + b, sp.exp(a) * sp.cos(T1 / 2) / sp.sqrt(a**2 + 1) - b):
        expected = pytest.approx(evaluate_at_point(expression), rel=1e-9, abs=1e-9)
        assert evaluate_at_point(write_in_textbook_form(expression)) == expected
    product = b * sp.sqrt(A1**2 + 1) ** 3
    value = evaluate_at_point(factor_trig(product).to_expression())
    assert value == pytest.approx(evaluate_at_point(product), abs=1e-9)


@given(polynomials)
def test_expanded_form_is_identical_and_changed_form_is_not(expression: sp.Expr) -> None:
    assert are_identical(sp.expand(sp.expand_trig(expression)), expression)
    assert not are_identical(expression + A1 * sp.sin(T2), expression)


@pytest.mark.parametrize(
    ("expression", "printed"),
    [
        (sp.cos(T2) * sp.sin(T2 + T3) - sp.sin(T2) * sp.cos(T2 + T3), "sin(theta3)"),
        (A1 * sp.cos(T1) ** 2 + A1 * sp.sin(T1) ** 2, "a1"),
        (A1 * sp.sin(T1) * sp.cos(T2) + A1 * sp.cos(T1) * sp.sin(T2), "a1*sin(theta1 + theta2)"),
        (A1 * sp.cos(T1) + A2 * sp.cos(T1) * sp.cos(T2), "(a1 + a2*cos(theta2))*cos(theta1)"),
        (sp.cos(T1) - sp.cos(T1), "0"),
        (
            A1 * sp.cos(T1) + (A2 + A3) * sp.sin(T1) * sp.sin(T2) * (sp.cos(T3) ** 2 + sp.sin(T3) ** 2),
            "a1*cos(theta1) + (a2 + a3)*sin(theta1)*sin(theta2)",  # and not with cos(theta1 - theta2)
        ),
    ],
)
def test_result_is_printed_as_in_a_textbook(expression: sp.Expr, printed: str) -> None:
    assert str(to_textbook_form(expression)) == printed


def test_product_is_split_into_its_factors() -> None:
    shoulder = A1 + A2 * sp.cos(T2) + A3 * sp.cos(T2 + T3)
    factored = factor_trig(sp.expand(A2 * A3 * sp.sin(T3) * shoulder))
    assert {(str(f), power) for f, power in factored.factors} == {
        ("a2", 1), ("a3", 1), ("sin(theta3)", 1), ("a1 + a2*cos(theta2) + a3*cos(theta2 + theta3)", 1),
    }  # fmt: skip
    assert factored.divide_by(factor_trig(A2 * sp.sin(T3))).to_expression() == A3 * shoulder
    assert factor_trig(sp.S.Zero).is_zero


def test_common_factors_of_long_sum_are_extracted() -> None:
    total = sp.expand(6 * A1 * sp.sin(T1) ** 2 * (A2 * sp.cos(T2) + A3 * sp.cos(T2 + T3)) * (A1 + sp.sin(T3)))
    factored = factor_trig(total, max_terms=3)
    assert {str(f): p for f, p in factored.factors if not f.is_Add} == {"a1": 1, "sin(theta1)": 2}
    assert factored.coefficient == 6 and len([f for f, _ in factored.factors if f.is_Add]) == 1
    assert are_identical(factored.to_expression(), total)


@pytest.mark.parametrize("wrong", [sp.sqrt(A1), sp.sin(T1 / 2), 1 / sp.cos(T1), sp.tan(T1)])
def test_expression_that_is_not_a_trigonometric_polynomial_is_refused(wrong: sp.Expr) -> None:
    for read_form in (compute_fourier_form, lambda expression: are_identical(expression, A1)):
        with pytest.raises(ValueError, match=r"is not a|expected an expression convertible to a polynomial"):
            read_form(wrong)


def test_equal_lengths_are_factored_out_of_sums() -> None:
    a, a2, a3, t2, t3 = sp.symbols("a a2 a3 theta2 theta3")
    product = factor_trig(sp.expand(a2 * a3 * sp.sin(t3) * (a2 * sp.cos(t2) + a3 * sp.cos(t2 + t3))))
    assert product.substitute({a2: a, a3: a}) == a**3 * sp.sin(t3) * (sp.cos(t2) + sp.cos(t2 + t3))


@pytest.mark.parametrize("product", read_cases("equal")["products"])
def test_factors_agree_with_sympy(product: str) -> None:
    """A factor that is linear in some symbol is found without general factorization."""
    whole = sp.expand(sp.sympify(product))
    coefficient, factors = polynomial_factors(whole, 200)
    content, expected = sp.factor_list(whole)
    assert sp.expand(coefficient * sp.Mul(*(factor**power for factor, power in factors)) - whole) == 0
    assert {(factor if sp.Poly(factor).LC() > 0 else -factor, power) for factor, power in factors} == set(expected)
    assert abs(coefficient) == abs(content)


@pytest.mark.parametrize("root", [sp.sqrt(3) / 4, -sp.sqrt(2), (sp.sqrt(6) + sp.sqrt(2)) / 4])
def test_roots_of_numbers_are_refused(root: sp.Expr) -> None:
    """They are refused in products as in sums."""
    t1, t3, a1 = sp.symbols("theta1 theta3 a1")
    for terms in (a1 * sp.sin(t3), a1 * sp.sin(t3) * sp.cos(t1), a1 * sp.sin(t3) + a1 * sp.cos(t1)):
        with pytest.raises(ValueError, match="roots of numbers"):
            factor_trig(root * terms)
        with pytest.raises(ValueError, match="roots of numbers"):
            to_textbook_form(sp.expand(root * terms))
