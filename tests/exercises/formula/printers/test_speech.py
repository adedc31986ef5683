"""Formulas in words."""

import pytest

from exercises.formula.latex import parsed
from exercises.formula.printers.speech import spoken


@pytest.mark.parametrize(
    ("latex", "words"),
    [
        (r"J^{-1} = \frac{1}{\det J}", "J inverse equals 1 over (determinant of J)"),
        (
            r"\begin{bmatrix} s_{12} & 0 \\ 1 & -a_{2}^{2} \end{bmatrix}",
            "matrix of 2 rows and 2 columns, row 1: s 12, 0; row 2: 1, minus a 2 squared; end of matrix",
        ),
        (r"\begin{bmatrix} 1 \\ 2 \end{bmatrix}", "column with entries 1; 2; end of column"),
        (r"90^\circ \leq \theta'_{1}", "90 degrees is at most theta 1 prime"),
        (r"p^* + x^{n} \qquad 0{,}5", "p star plus x to the power n, 0,5"),
    ],
)
def test_what_is_heard(latex: str, words: str) -> None:
    assert spoken(parsed(latex)) == words
