"""Formulas as Maxima reads them: what stands in parentheses."""

import pytest
import sympy as sp

from exercises.formula.printers.maxima import maxima_text

A, B, C = sp.symbols("a b c", real=True)


@pytest.mark.parametrize(
    ("formula", "text"),
    [
        (sp.Pow(sp.Pow(A, B, evaluate=False), C, evaluate=False), "(a^(b))^(c)"),
        ((A + B) ** 2, "(a + b)^2"), (sp.Pow(-A, 2, evaluate=False), "(-a)^2"), (A**2, "a^2"), (sp.sqrt(A), "sqrt(a)"),
        (sp.Pow(A * B, C, evaluate=False), "(a*b)^(c)"),
    ],
)  # fmt: skip
def test_a_power_has_its_base_in_parentheses_where_maxima_would_read_another(formula: sp.Expr, text: str) -> None:
    assert maxima_text(formula) == text
