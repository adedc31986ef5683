"""Formatting Python, SymPy and NumPy values as text that a student could have typed."""

from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.grader.sandbox.notebook_process.answer_formatting import format_value

X, Y = sp.symbols("x y")
VALUES = [
    (sp.Poly(X**2 + Y, X), "x**2 + y"), (sp.sinc(X), "sin(x)/x"), (sp.Point(1, X), "[1, x]"),
    (sp.Derivative(X**2, X), "2*x"), (sp.Determinant(sp.Matrix([[X, 1], [Y, 2]])), "2*x - y"),
    (sp.Eq(sp.Matrix([X, Y]), sp.Matrix([1, 2])), "[Eq(x, 1), Eq(y, 2)]"),
    (np.array([[1.5, 0], [0, 2]]), "[[1.5, 0.0], [0.0, 2.0]]"),
    (sp.ImmutableDenseNDimArray([X, 1]), "[x, 1]"), ("a1*s1", "a1*s1"),
]  # fmt: skip


@pytest.mark.parametrize(("value", "text"), VALUES)
def test_values_are_formatted_as_typed_text(value: Any, text: str) -> None:
    assert format_value(value) == text


def test_a_matrix_symbol_is_rejected() -> None:
    with pytest.raises(TypeError, match="a MatrixSymbol has no entries"):
        format_value(sp.MatrixSymbol("J", 2, 2))
