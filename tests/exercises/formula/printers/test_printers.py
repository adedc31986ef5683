"""Formulas printed for Maxima, in words, for Typst, and for a terminal."""

from collections.abc import Callable

import pytest
import sympy as sp
from sympy.printing.pretty.pretty_symbology import line_width

from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.formula.layout import Layout
from qdot.exercises.formula.printers.maxima import print_maxima
from qdot.exercises.formula.printers.speech import print_speech
from qdot.exercises.formula.printers.typst import print_typst
from qdot.exercises.formula.printers.unicode import print_unicode
from qdot.exercises.problem.problem import Problem
from qdot.exercises.reference_answers import Matrix
from qdot.exercises.writing.latex import lay_out

A, B, C = sp.symbols("a b c", real=True)
FOR_MAXIMA = [
    (sp.Pow(sp.Pow(A, B, evaluate=False), C, evaluate=False), "(a^(b))^(c)"), ((A + B) ** 2, "(a + b)^2"),
    (sp.Pow(-A, 2, evaluate=False), "(-a)^2"), (A**2, "a^2"), (sp.sqrt(A), "sqrt(a)"),
    (sp.Pow(A * B, C, evaluate=False), "(a*b)^(c)"),
]  # fmt: skip
PRINTED = [
    (print_speech, r"J^{-1} = \frac{1}{\det J}", "J inverse equals 1 over (determinant of J)"),
    (print_speech, r"\begin{bmatrix} s_{12} & 0 \\ 1 & -a_{2}^{2} \end{bmatrix}",
     "matrix of 2 rows and 2 columns, row 1: s 12, 0; row 2: 1, minus a 2 squared; end of matrix"),
    (print_speech, r"\begin{bmatrix} 1 \\ 2 \end{bmatrix}", "column with entries 1; 2; end of column"),
    (print_speech, r"90^\circ \leq \theta'_{1}", "90 degrees is at most theta 1 prime"),
    (print_speech, r"p^* + x^{n} \qquad 0{,}5", "p star plus x to the power n, 0,5"),
    (print_typst, "(a)_{1}", r"\( a \)_(1)"), (print_typst, r"90^\circ = J^T", "90 ° = J^(T)"),
    (print_typst, r"-\dfrac{a}{2}\, \sqrt{b}", "− display(frac(a, 2)) #h(0.17em) sqrt(b)"),
    (print_typst, r"\left\{ 0{,}5 \right.", r'lr(\{ "0,5" )'),
    (print_typst, r"\begin{bmatrix} a & b \\ c & d \end{bmatrix}", 'mat(delim: "[", a, b; c, d)'),
    (print_typst, r"\begin{aligned} a &= b \\ c &= d \end{aligned}", "a & = b \\ c & = d"),
    (print_typst, "{}^1v_x", '""^(1) v_(x)'),
    (print_typst, r"\text{ or } \sin x", '" or " op("sin") x'),
    (print_unicode, r"(d_{2} + 0.5) \cos \varphi_{1}\, \dot{d}_{2}", "(d₂ + 0.5) cos φ₁ d\u0307₂"),
    (print_unicode, r"-\frac{a_{1} + 1}{2 s_{2}} = -90^\circ", "−(a₁ + 1)/(2 s₂) = −90°"),
    (print_speech, r"\vec{v} = \mathbf{J} \ddot{q}_{1}, \int_{0}^{1} A^\top",
     "v vector equals bold J q double dot 1, integral from 0 to 1 of A transposed"),
    (print_speech, r"\begin{cases} a & b \\ c & d \end{cases}", "cases: a b; c d; end of cases"),
    (print_typst, r"\vec{v} \mathbf{J} \ddot{q} \|", "arrow(v) 𝐉 dot.double(q) class(\"normal\", ‖)"),
    (print_typst, r"\begin{pmatrix} a & b \end{pmatrix} \max_i", 'mat(delim: "(", a, b) op("max", limits: #true)_(i)'),
    (print_typst, r"\hat\langle \left\lfloor a\right. √", r"hat(\⟨) lr(\⌊ a ) \√"),
    (print_typst, r"\begin{cases} a & b \\ c & d \end{cases}", "cases(a & b, c & d)"),
    (print_unicode, r"\vec{v} = \mathbf{J} \ddot{q} \in \mathbb{R}^n", "v⃗ = 𝐉 q̈ ∈ ℝⁿ"),
    (print_unicode, r"\|v\| \ne \overline{AB} \perp a \rightarrow b", "‖v‖ ≠ A̅ B̅ ⊥ a → b"),
    (print_unicode, r"\begin{pmatrix} 1 \\ 2 \end{pmatrix} \left\{\begin{matrix} 1 \\ 2 \end{matrix}\right.",
     "⎛1⎞ ⎧1\n⎝2⎠ ⎩2"),
    (print_unicode, r"\begin{cases} a & \text{if } b \\ c \\ d \end{cases}", "⎧a  if b\n⎨c\n⎩d"),
    (print_unicode, r"p^*_{1} J^T \sqrt{2}", "p*₁ Jᵀ √2"),
    (print_unicode, r"\omega_{1}' \times q_i' = v''", "ω₁′ × qᵢ′ = v″"),
    (print_unicode, r"1.2 \cdot 10^{-6}", "1.2 ⋅ 10⁻⁶"), (print_unicode, r"x^{a b} + \left(y\right)", "x^(ab) + (y)"),
    (print_unicode, r"\begin{aligned} a &= 1 \\ b &= 2 \end{aligned}", "a = 1\nb = 2"),
    (print_unicode, r"J = \begin{bmatrix} 1 & 2 \\ 3 & 4 \end{bmatrix}", "J = ⎡1  2⎤\n    ⎣3  4⎦"),
]  # fmt: skip


@pytest.mark.parametrize(("formula", "text"), FOR_MAXIMA)
def test_base_of_power_is_parenthesized_for_maxima(formula: sp.Expr, text: str) -> None:
    assert print_maxima(formula) == text


@pytest.mark.parametrize(("printer", "latex", "text"), PRINTED)
def test_formula_is_printed_in_each_notation(printer: Callable[[Layout], str], latex: str, text: str) -> None:
    printed = printer(parse_latex(latex))
    assert (" ".join(printed.split()) if printer is print_typst else printed) == text


def test_stacked_matrices_are_separated() -> None:
    column = r"\begin{bmatrix} 1 \\ 2 \end{bmatrix}"
    stacked = parse_latex(rf"\begin{{aligned}} a &= {column} \\[6pt] b &= {column} \end{{aligned}}")
    assert [bool(line) for line in print_unicode(stacked).splitlines()] == [True, True, False, True, True]


def test_combining_dot_has_no_width() -> None:
    assert line_width("d\u0307₂") == 2


def test_reference_matrices_are_printable_in_terminals(problem: Problem) -> None:
    for part in problem.parts:
        if isinstance(part.answer, Matrix):
            text = print_unicode(lay_out(part.answer.reference, problem.chain))
            assert "\\" not in text and "{" not in text
            assert len(text.splitlines()) == part.answer.reference.rows
