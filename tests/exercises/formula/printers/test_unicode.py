"""Formulas as text for a terminal."""

import pytest

from exercises.answers import Matrix
from exercises.formula.latex import parsed
from exercises.formula.printers.unicode import shown_width, unicode_math
from exercises.problem import Problem
from exercises.writing.latex import laid_out


@pytest.mark.parametrize(
    ("latex", "shown"),
    [
        (r"(d_{2} + 0.5) \cos \varphi_{1}\, \dot{d}_{2}", "(d₂ + 0.5) cos φ₁ d\u0307₂"),
        (r"-\frac{a_{1} + 1}{2 s_{2}} = -90^\circ", "−(a₁ + 1)/(2 s₂) = −90°"),
        (r"p^*_{1} J^T \sqrt{2}", "p*₁ Jᵀ √2"),
        (r"\omega_{1}' \times q_i' = v''", "ω₁′ × qᵢ′ = v″"),
        (r"1.2 \cdot 10^{-6}", "1.2 ⋅ 10⁻⁶"),
        (r"x^{a b} + \left(y\right)", "x^(ab) + (y)"),
        (r"\begin{aligned} a &= 1 \\ b &= 2 \end{aligned}", "a = 1\nb = 2"),
        (r"J = \begin{bmatrix} 1 & 2 \\ 3 & 4 \end{bmatrix}", "J = ⎡1  2⎤\n    ⎣3  4⎦"),
    ],
)
def test_as_text(latex: str, shown: str) -> None:
    assert unicode_math(parsed(latex)) == shown


def test_stacked_matrices_keep_apart() -> None:
    column = r"\begin{bmatrix} 1 \\ 2 \end{bmatrix}"
    stacked = parsed(rf"\begin{{aligned}} a &= {column} \\[6pt] b &= {column} \end{{aligned}}")
    assert [bool(line) for line in unicode_math(stacked).splitlines()] == [True, True, False, True, True]


def test_a_dot_over_a_letter_takes_no_column() -> None:
    assert shown_width("d\u0307₂") == 2


def test_formulas_have_a_form_for_terminals(problem: Problem) -> None:
    for part in problem.parts:
        if isinstance(part.answer, Matrix):
            text = unicode_math(laid_out(part.answer.reference, problem.chain))
            assert "\\" not in text and "{" not in text
            assert len(text.splitlines()) == part.answer.reference.rows
