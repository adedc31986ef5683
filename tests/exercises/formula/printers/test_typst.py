"""Formulas as Typst's mathematics; what Typst makes of those of all families is looked at with the sheets."""

import pytest

from exercises.formula.latex import parsed
from exercises.formula.printers.typst import typst_math


@pytest.mark.parametrize(
    ("latex", "shown"),
    [
        ("(a)_{1}", r"\( a \)_(1)"),
        (r"90^\circ = J^T", "90 ° = J^(T)"),
        (r"-\dfrac{a}{2}\, \sqrt{b}", "− display(frac(a, 2)) #h(0.17em) sqrt(b)"),
        (r"\left\{ 0{,}5 \right.", 'lr({ "0,5" )'.replace("{", r"\{").replace(" )", " )")),
        (r"\begin{bmatrix} a & b \\ c & d \end{bmatrix}", 'mat(delim: "[", a, b; c, d)'),
        (r"\begin{aligned} a &= b \\ c &= d \end{aligned}", "a & = b \\ c & = d"),
        (r"\text{ or } \sin x", '" or " op("sin") x'),
    ],
)
def test_as_typst(latex: str, shown: str) -> None:
    assert " ".join(typst_math(parsed(latex)).split()) == " ".join(shown.split())
