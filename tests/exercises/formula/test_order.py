"""Signs in printed products and sums: no double minus, and a sum has the same form in every fraction."""

import pytest
import sympy as sp

from qdot.exercises.formula.printers.python import print_python
from qdot.exercises.writing.latex import tex

T1, T2, A1, D2, VX, VY = sp.symbols("theta1 theta2 a1 d2 vx vy")
MIXED = D2 * sp.sin(T2) - A1 * sp.cos(T1)
"""A sum that SymPy prints with a leading minus."""


@pytest.mark.parametrize(
    ("expression", "shown"),
    [
        (sp.cos(T2) * MIXED, r"-c_{2} (a_{1} c_{1} - d_{2} s_{2})"),
        (-sp.cos(T2) * MIXED, r"c_{2} (a_{1} c_{1} - d_{2} s_{2})"),
        (MIXED / D2, r"-\frac{a_{1} c_{1} - d_{2} s_{2}}{d_{2}}"),
        (D2 / MIXED, r"-\frac{d_{2}}{a_{1} c_{1} - d_{2} s_{2}}"),
        (-D2 / MIXED, r"\frac{d_{2}}{a_{1} c_{1} - d_{2} s_{2}}"),
        ((-sp.sin(T1) * VX + sp.cos(T1) * VY) / A1, r"\frac{-s_{1} v_{x} + c_{1} v_{y}}{a_{1}}"),
        (
            -(VX * MIXED - VY * D2 * sp.cos(T2)) / A1,
            r"\frac{(a_{1} c_{1} - d_{2} s_{2}) v_{x} + d_{2} c_{2} v_{y}}{a_{1}}",
        ),
        (
            -(VX * (D2 * sp.sin(T1) - A1 * sp.sin(T2) * sp.cos(T1)) + VY * (-D2 * sp.cos(T1) - A1 * sp.sin(T1))) / D2,
            r"\frac{(a_{1} c_{1} s_{2} - d_{2} s_{1}) v_{x} + (d_{2} c_{1} + a_{1} s_{1}) v_{y}}{d_{2}}",
        ),
    ],
)
def test_no_bracket_starts_with_a_minus_sign(expression: sp.Expr, shown: str) -> None:
    assert tex(expression) == shown
    code = eval(
        print_python(expression), {"sin": sp.sin, "cos": sp.cos, **{s.name: s for s in expression.free_symbols}}
    )
    assert sp.expand(code * MIXED - expression * MIXED) == 0 or sp.simplify(code - expression) == 0
