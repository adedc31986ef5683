"""Formulas as MathML agree with latex2mathml 3.81.1 (stored in mathml.jsonl), with additions for browsers."""

import html
import json
import re
import xml.etree.ElementTree as ET

import pytest

from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.formula.printers.mathml import print_mathml, print_plain_mathml
from tests.support import DATA

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


@pytest.mark.parametrize(
    ("latex", "shown"),
    [
        (r"2 \sin x", "2 sin x"), (r"2 \arcsin x", "2 arcsinx"), (r"a_{1} \cos \theta_{2}", "a1 cos θ2"),
        (r"\sin \cos x", "sin cos x"), (r"\sin (x)", "sin(x)"), (r"(x) \tan (y)", "(x) tan(y)"),
        (r"- \sin x", "−sin x"), (r"\sin 2", "sin2"), (r"(d_{2} + 0.5) \cos \varphi_{1}", "(d2+0.5) cos φ1"),
    ],
)  # fmt: skip
def test_function_name_is_spaced_from_factor_and_bare_argument(latex: str, shown: str) -> None:
    spaced = re.sub(r"<mspace[^>]*>", " ", print_mathml(parse_latex(latex)))
    assert html.unescape(re.sub(r"<[^>]*>", "", spaced)) == shown


def test_decimal_comma_belongs_to_its_number_and_semicolon_separates() -> None:
    shown = print_mathml(parse_latex(r"(0; -1{,}5^\circ; a_{1,2})\,\text{m}"))
    assert '<mn>0</mn><mo>;</mo><mo form="prefix">&#x02212;</mo><msup><mn>1,5</mn>' in shown
    assert "<mn>1</mn><mo>&#x0002C;</mo><mn>2</mn>" in shown  # two indices are not one number


def test_minus_is_a_prefix_only_at_the_start_of_a_term() -> None:
    assert print_mathml(parse_latex("(-a, -b)")).count('<mo form="prefix">') == 2
    assert print_mathml(parse_latex(r"\left(-a\right)")).count('<mo form="prefix">') == 1
    assert "prefix" not in print_mathml(parse_latex("a - b")) and "prefix" not in print_plain_mathml(
        parse_latex("(-a)")
    )


def test_dot_is_an_accent_close_to_its_letter_in_browsers() -> None:
    assert '<mover accent="true"><mrow><mi>&#x003B8;' in print_mathml(parse_latex(r"\dot{\theta}"))


def test_mathml_has_styles_for_brackets_columns_and_sizes() -> None:
    formula = parse_latex(r"\begin{aligned} a &= \begin{bmatrix} 1 \end{bmatrix} \\[6pt] b &= 2 \end{aligned}")
    shown = print_mathml(formula, True, 90)
    assert "&#x0005B;" not in shown and "columnalign" not in shown and "6pt" not in shown
    assert shown.count("text-align: right; padding: 1.1ex") == 2 and "font-size: 90%" in shown
    assert print_mathml(parse_latex(r"\begin{aligned} a &= 1 \end{aligned}")).count("0.5ex 0.3em 0.5ex 0") == 1


def test_text_is_escaped_in_mathml() -> None:
    assert "<mtext>a&lt;b&amp;c</mtext>" in print_mathml(parse_latex(r"\text{a<b&c}"))
