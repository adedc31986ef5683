"""Formulas printed for Maxima, in words, for Typst, for a terminal, as SymPy prints them, and as MathML.

MathML agrees with latex2mathml 3.81.1 (stored in mathml.jsonl), with additions for browsers.
"""

import html
import json
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable

import pytest
import sympy as sp
from sympy.printing.str import StrPrinter

from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.formula.layout import Layout
from qdot.exercises.formula.printers.mathml import print_mathml, print_plain_mathml
from qdot.exercises.formula.printers.maxima import print_maxima
from qdot.exercises.formula.printers.python import print_python
from qdot.exercises.formula.printers.speech import print_speech
from qdot.exercises.formula.printers.typst import print_typst
from qdot.exercises.formula.printers.unicode import print_unicode
from qdot.exercises.formula.printing import FullPrinter, Printer
from qdot.exercises.problem.problem import Problem
from qdot.exercises.reference_answers import Matrix
from qdot.exercises.writing.latex import lay_out, tex
from tests.support import DATA, read_cases

A, B, C = sp.symbols("a b c", real=True)
PRINTED = read_cases("printed")
PRINTERS: dict[str, Callable[[Layout], str]] = {"speech": print_speech, "typst": print_typst, "unicode": print_unicode}
FOR_MAXIMA = [
    (sp.Pow(sp.Pow(A, B, evaluate=False), C, evaluate=False), "(a^(b))^(c)"), ((A + B) ** 2, "(a + b)^2"),
    (sp.Pow(-A, 2, evaluate=False), "(-a)^2"), (A**2, "a^2"), (sp.sqrt(A), "sqrt(a)"),
    (sp.Pow(A * B, C, evaluate=False), "(a*b)^(c)"),
]  # fmt: skip


@pytest.mark.parametrize(("formula", "text"), FOR_MAXIMA)
def test_base_of_power_is_parenthesized_for_maxima(formula: sp.Expr, text: str) -> None:
    assert print_maxima(formula) == text


@pytest.mark.parametrize(("printer", "latex", "text"), PRINTED["printed"])
def test_formula_is_printed_in_each_notation(printer: str, latex: str, text: str) -> None:
    printed = PRINTERS[printer](parse_latex(latex))
    assert (" ".join(printed.split()) if printer == "typst" else printed) == text


def test_stacked_matrices_are_separated() -> None:
    column = r"\begin{bmatrix} 1 \\ 2 \end{bmatrix}"
    stacked = parse_latex(rf"\begin{{aligned}} a &= {column} \\[6pt] b &= {column} \end{{aligned}}")
    assert [bool(line) for line in print_unicode(stacked).splitlines()] == [True, True, False, True, True]


def test_reference_matrices_are_printable_in_terminals(problem: Problem) -> None:
    for part in problem.parts:
        if isinstance(part.answer, Matrix):
            text = print_unicode(lay_out(part.answer.reference, problem.chain))
            assert "\\" not in text and "{" not in text
            assert len(text.splitlines()) == part.answer.reference.rows


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
    names = {"sin": sp.sin, "cos": sp.cos, **{symbol.name: symbol for symbol in expression.free_symbols}}
    code = eval(print_python(expression), names)
    assert sp.expand(code * MIXED - expression * MIXED) == 0 or sp.simplify(code - expression) == 0


def test_cached_text_is_that_of_sympy() -> None:
    angle = T1 + sp.pi / 3
    for expression in (
        A1 * sp.sin(angle) - sp.cos(angle),
        sp.Pow(A1 * sp.sin(angle), -2) / 3,
        sp.Matrix([[angle, A1]]),
    ):
        for _ in range(2):
            assert Printer().doprint(expression) == FullPrinter().doprint(expression) == str(expression)


def test_full_printer_prints_all_digits_of_doubles() -> None:
    trig = sp.sin(sp.Float(3**0.5 / 2) * T1 + A1)
    assert Printer().doprint(trig) == str(trig) == "sin(a1 + 0.866025403784439*theta1)"
    assert FullPrinter().doprint(trig) == "sin(a1 + 0.8660254037844386*theta1)"


def test_equal_expressions_and_a_changed_matrix_have_their_own_texts() -> None:
    half, longer = sp.Float("0.5", 15) * T1 + 1, sp.Float("0.5", 30) * T1 + 1
    texts = [FullPrinter().doprint(expression) for expression in (half, longer, half)]
    assert texts[0] == texts[2]
    assert texts[0] != texts[1]

    matrix = sp.Matrix([A1, T1])
    before = FullPrinter().doprint(matrix)
    matrix[0] = T1
    assert FullPrinter().doprint(matrix) == StrPrinter().doprint(matrix) != before


LINES = [json.loads(line) for line in (DATA / "mathml.jsonl").read_text(encoding="utf-8").splitlines()]
STORED = {line["latex"]: line["mathml"] for line in LINES}
ARITY = {"msub": 2, "msup": 2, "mfrac": 2, "mover": 2, "msubsup": 3}


def test_mathml_agrees_with_latex2mathml() -> None:
    for latex, expected in STORED.items():
        formula = parse_latex(latex)
        assert print_plain_mathml(formula) == expected
        in_block = print_plain_mathml(formula, is_displayed=True)
        assert in_block.replace("munder", "msub") == expected.replace('"inline"', '"block"', 1)
        assert ("<munder>" in in_block) == (r"\sum_" in latex), latex


def test_mathml_elements_have_the_right_number_of_children() -> None:
    for latex in (*STORED, r"\begin{bmatrix} 1 & \\ 2 & 3 \end{bmatrix}^{T}"):
        for shown in (print_plain_mathml(parse_latex(latex)), print_mathml(parse_latex(latex), True, 90)):
            for element in ET.fromstring(shown).iter():
                tag = element.tag.split("}")[1]
                assert len(element) == ARITY.get(tag, len(element)), (tag, shown)


@pytest.mark.parametrize(("latex", "shown"), PRINTED["spaced"])
def test_function_name_is_spaced_from_factor_and_bare_argument(latex: str, shown: str) -> None:
    spaced = re.sub(r"<mspace[^>]*>", " ", print_mathml(parse_latex(latex)))
    assert html.unescape(re.sub(r"<[^>]*>", "", spaced)) == shown


def test_decimal_comma_belongs_to_its_number_and_semicolon_separates() -> None:
    shown = print_mathml(parse_latex(r"(0; -1{,}5^\circ; a_{1,2})\,\text{m}"))
    assert '<mn>0</mn><mo>;</mo><mo form="prefix">&#x02212;</mo><msup><mn>1,5</mn>' in shown
    assert "<mn>1</mn><mo>&#x0002C;</mo><mn>2</mn>" in shown  # two indices are not one number


def test_minus_signs_dots_and_texts_are_marked_up_for_browsers() -> None:
    """A minus is a prefix only at the start of a term, and a dot an accent close to its letter."""
    assert print_mathml(parse_latex("(-a, -b)")).count('<mo form="prefix">') == 2
    assert print_mathml(parse_latex(r"\left(-a\right)")).count('<mo form="prefix">') == 1
    assert "prefix" not in print_mathml(parse_latex("a - b"))
    assert "prefix" not in print_plain_mathml(parse_latex("(-a)"))

    assert '<mover accent="true"><mrow><mi>&#x003B8;' in print_mathml(parse_latex(r"\dot{\theta}"))


def test_mathml_has_styles_for_brackets_columns_and_sizes() -> None:
    formula = parse_latex(r"\begin{aligned} a &= \begin{bmatrix} 1 \end{bmatrix} \\[6pt] b &= 2 \end{aligned}")
    shown = print_mathml(formula, True, 90)
    assert "&#x0005B;" not in shown and "columnalign" not in shown and "6pt" not in shown
    assert shown.count("text-align: right; padding: 1.1ex") == 2 and "font-size: 90%" in shown
    assert print_mathml(parse_latex(r"\begin{aligned} a &= 1 \end{aligned}")).count("0.5ex 0.3em 0.5ex 0") == 1


def test_text_is_escaped_in_mathml() -> None:
    assert "<mtext>a&lt;b&amp;c</mtext>" in print_mathml(parse_latex(r"\text{a<b&c}"))
