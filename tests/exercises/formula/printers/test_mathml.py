"""Formulas as MathML: as latex2mathml 3.81.1 made them, which mathml.jsonl keeps, and what browsers need beside."""

import html
import json
import re
import xml.etree.ElementTree as ET

import pytest

from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.formula.printers.mathml import mathml_text, plain_mathml
from tests.support import DATA

LINES = [json.loads(line) for line in (DATA / "mathml.jsonl").read_text(encoding="utf-8").splitlines()]
KEPT = {line["latex"]: line["mathml"] for line in LINES}
ARITY = {"msub": 2, "msup": 2, "mfrac": 2, "mover": 2, "msubsup": 3}


def test_it_is_as_latex2mathml_made_it() -> None:
    for latex, due in KEPT.items():
        formula = parse_latex(latex)
        assert plain_mathml(formula) == due
        in_block = plain_mathml(formula, is_displayed=True)
        assert in_block.replace("munder", "msub") == due.replace('"inline"', '"block"', 1)
        assert ("<munder>" in in_block) == (r"\sum_" in latex), latex


def test_elements_have_as_many_children_as_they_must() -> None:
    for latex in (*KEPT, r"\begin{bmatrix} 1 & \\ 2 & 3 \end{bmatrix}^{T}"):
        for shown in (plain_mathml(parse_latex(latex)), mathml_text(parse_latex(latex), True, 90)):
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
def test_a_function_stands_apart_from_a_factor_before_it_and_from_a_bare_name_behind_it(latex: str, shown: str) -> None:
    spaced = re.sub(r"<mspace[^>]*>", " ", mathml_text(parse_latex(latex)))
    assert html.unescape(re.sub(r"<[^>]*>", "", spaced)) == shown


def test_a_decimal_comma_is_in_its_number_and_a_semicolon_parts_numbers() -> None:
    shown = mathml_text(parse_latex(r"(0; -1{,}5^\circ; a_{1,2})\,\text{m}"))
    assert '<mn>0</mn><mo>;</mo><mo form="prefix">&#x02212;</mo><msup><mn>1,5</mn>' in shown
    assert "<mn>1</mn><mo>&#x0002C;</mo><mn>2</mn>" in shown  # two indices are not one number


def test_a_sign_belongs_to_what_is_behind_it_only_where_a_term_begins() -> None:
    assert mathml_text(parse_latex("(-a, -b)")).count('<mo form="prefix">') == 2
    assert mathml_text(parse_latex(r"\left(-a\right)")).count('<mo form="prefix">') == 1
    assert "prefix" not in mathml_text(parse_latex("a - b")) and "prefix" not in plain_mathml(parse_latex("(-a)"))


def test_browsers_are_told_of_brackets_columns_and_sizes() -> None:
    formula = parse_latex(r"\begin{aligned} a &= \begin{bmatrix} 1 \end{bmatrix} \\[6pt] b &= 2 \end{aligned}")
    shown = mathml_text(formula, True, 90)
    assert "&#x0005B;" not in shown and "columnalign" not in shown and "6pt" not in shown
    assert shown.count("text-align: right; padding: 1.1ex") == 2 and "font-size: 90%" in shown
    assert mathml_text(parse_latex(r"\begin{aligned} a &= 1 \end{aligned}")).count("0.5ex 0.3em 0.5ex 0") == 1


def test_text_is_no_markup() -> None:
    assert "<mtext>a&lt;b&amp;c</mtext>" in mathml_text(parse_latex(r"\text{a<b&c}"))
