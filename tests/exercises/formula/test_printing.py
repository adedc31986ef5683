"""The printed answer is exactly SymPy's, although the texts of subexpressions are cached."""

import sympy as sp
from sympy.printing.str import StrPrinter

from qdot.exercises.formula.printing import FullPrinter, Printer

THETA, A = sp.symbols("theta1 a1")


def test_cached_text_is_that_of_sympy() -> None:
    angle = THETA + sp.pi / 3
    for expression in (A * sp.sin(angle) - sp.cos(angle), sp.Pow(A * sp.sin(angle), -2) / 3, sp.Matrix([[angle, A]])):
        for _ in range(2):
            assert Printer().doprint(expression) == FullPrinter().doprint(expression) == str(expression)


def test_full_printer_prints_all_digits_of_doubles() -> None:
    trig = sp.sin(sp.Float(3**0.5 / 2) * THETA + A)
    assert Printer().doprint(trig) == str(trig) == "sin(a1 + 0.866025403784439*theta1)"
    assert FullPrinter().doprint(trig) == "sin(a1 + 0.8660254037844386*theta1)"


def test_equal_expressions_keep_their_different_texts() -> None:
    half, longer = sp.Float("0.5", 15) * THETA + 1, sp.Float("0.5", 30) * THETA + 1
    texts = [FullPrinter().doprint(expression) for expression in (half, longer, half)]
    assert texts[0] == texts[2]
    assert texts[0] != texts[1]


def test_changed_matrix_is_printed_anew() -> None:
    matrix = sp.Matrix([A, THETA])
    before = FullPrinter().doprint(matrix)
    matrix[0] = THETA
    assert FullPrinter().doprint(matrix) == StrPrinter().doprint(matrix) != before
