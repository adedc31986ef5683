"""The LaTeX of robotics texts is parsed to a layout and printed unchanged; other LaTeX is refused."""

import json

import pytest

from qdot.exercises.formula.latex import COMMAND_NAMES, UnknownLatex, parse_latex
from qdot.exercises.formula.layout import (
    ACCENTS,
    EMPTY,
    MINUS,
    PLUS,
    SPACES,
    Layout,
    number,
    row,
    script,
    split_at,
    split_terms,
)
from qdot.exercises.formula.printers.latex import print_latex
from qdot.exercises.formula.printers.speech import print_speech
from qdot.exercises.formula.styles import STYLES
from tests.support import DATA

WRITTEN = [json.loads(line)["latex"] for line in (DATA / "mathml.jsonl").read_text(encoding="utf-8").splitlines()]


def test_latex_is_parsed_to_a_layout() -> None:
    a, index = Layout("letter", "a"), row(*number("1"))
    assert parse_latex("a_{1}") == row(script(a, index))
    assert parse_latex("a_1^{2}") == row(script(a, index.inner[0], row(*number("2"))))
    assert parse_latex("-a") == row(MINUS, a) and parse_latex("{}") == row(EMPTY)
    assert parse_latex(r"\frac12").inner == (Layout("fraction", "frac", (*number("1"), *number("2"))),)
    assert parse_latex("0{,}5") == row(*number("0,5"))


@pytest.mark.parametrize("text", WRITTEN)
def test_printed_latex_parses_to_the_same(text: str) -> None:
    shown = print_latex(parse_latex(text))
    assert print_latex(parse_latex(shown)) == shown


@pytest.mark.parametrize(
    "text",
    [
        r"-a_{1} s_{12} + 0.35 c_{1} (a_{2} - 1)", r"\tfrac{1}{2}\, a_{1}", r"\cos^{2} \varphi'_{1}\, \dot{\theta}_{2}",
        r"\left(\theta_{1} + \frac{\pi}{6}\right)^{2}", r"\text{atan2}(a_{1}, -2)", r"90^\circ", "0{,}5",
        r"\theta_{2} \in \left\{0, \pi\right\}", r"\begin{bmatrix} a & -b \\ \sqrt{2} & 0 \end{bmatrix} = J^T",
        r"{}^{2}z_{i-1} \times p^*_{i,j}",
        r"\vec{v} = \mathbf{J} \ddot{\boldsymbol{q}}", r"A^\top \in \mathbb{R}^{3}",
        r"\operatorname{rank} J \neq \max_{i} n",
        r"\left\|\frac{a}{b}\right\|", r"\begin{pmatrix} a \\ b \end{pmatrix}", r"\left\langle a, b\right\rangle",
        r"f = \begin{cases} x & \text{if } x \ge 0 \\ -x & \text{else} \end{cases}", r"\int_{0}^\infty f\, \nabla g",
        r"1.2 \cdot 10^{-6}\,\text{rad/s}", r"\begin{aligned} a & = {} - b \\[6pt] c & = d \end{aligned}",
    ],
)  # fmt: skip
def test_latex_is_printed_unchanged(text: str) -> None:
    assert print_latex(parse_latex(text)) == text


@pytest.mark.parametrize(
    "text",
    [
        r"\foo{a}", r"\begin{array} a \end{array}", r"\text{a \b}", r"\left\foo a\right)", "a_1_2", "a^b^c",
            "a_{1", "a}", r"\left( a", r"x \end{bmatrix}", r"\sqrt[3]{x}",
        "a & b", r"a \\ b", "%", "$", r"\begin{bmatrix} a", "x''''", "a_", r"\left( a }",
    ],
)  # fmt: skip
def test_unknown_latex_is_refused_by_name(text: str) -> None:
    with pytest.raises(UnknownLatex, match=r" in ['\"]"):
        parse_latex(text)


@pytest.mark.parametrize(("text", "printed"), [
    (r"a \ne b \ldots", r"a \neq b \dots"), (r"\bigl( \lVert v\rVert \bigr)", r"(\| v \|)"),
    (r"\mathrm{d}t", r"\text{d} t"),
    (r"\mathrm{a_1}", "a_1"), (r"\begin{bmatrix} 1 \\ 2 \\ \end{bmatrix}", r"\begin{bmatrix} 1 \\ 2 \end{bmatrix}"),
])  # fmt: skip
def test_other_names_of_a_sign_are_parsed(text: str, printed: str) -> None:
    assert print_latex(parse_latex(text)) == printed


def test_every_symbol_has_a_printed_form() -> None:
    """Each name becomes the same sign when it is printed and parsed again, and screen readers have a word for it."""
    for name in COMMAND_NAMES:
        argument = r"{a}{b}" if name in ("frac", "tfrac", "dfrac", "sqrt", *ACCENTS, *STYLES) else ""
        if name in ("text", "textrm", "operatorname", "left", "right", "begin", "end"):
            continue
        formula = parse_latex(f"\\{name}{argument}")
        assert print_latex(parse_latex(print_latex(formula))) == print_latex(formula)
        assert print_speech(formula).isascii() or name in SPACES, name


def test_terms_are_split_at_signs_outside_brackets() -> None:
    shown = [
        print_latex(row(EMPTY, *term)) for term in split_terms(parse_latex("-a + b (c - d) - (e + f)^{2} = -g").inner)
    ]
    assert shown == ["{} - a", "{} + b (c - d)", "{} - (e + f)^{2} = -g"]
    assert [print_latex(row(*part)) for part in split_at(parse_latex("a + (b + c)").inner, PLUS)] == ["a", "(b + c)"]
