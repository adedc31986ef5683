"""What students typed, set as formulas: every kind of tree, in its own order, and it still reads as the same."""

import xml.etree.ElementTree as ET

import pytest

from exercises.answers import ConditionSet, Expression, Matrix
from exercises.formula.expression import read
from exercises.formula.printers.latex import latex
from exercises.formula.printers.mathml import mathml
from exercises.formula.trees import Node
from exercises.problem import Problem
from exercises.writing.typeset import TooDeep, typeset
from grader.parts import judge
from grader.verdict import Outcome

KNOWN = frozenset({"theta1", "theta2", "theta3", "a1", "a2", "d2", "qd1", "qd2", "vx"})
SET = [
    ("-a1*sin(theta1) - a2*s12", "-a_{1} s_{1} - a_{2} s_{12}"),
    ("a1 - (a2 - d2) + (a1 + a2)", "a_{1} - (a_{2} - d_{2}) + (a_{1} + a_{2})"),
    ("a1-(-a2)", "a_{1} - (-a_{2})"),
    ("-(a1 + a2)*-a1", "-(a_{1} + a_{2}) (-a_{1})"),
    ("2*3*a1*2", r"2 \cdot 3 a_{1} \cdot 2"),
    ("4*sin(theta1)/25", r"\tfrac{4}{25}\, s_{1}"),
    ("a1/a2/d2", r"\frac{a_{1}}{a_{2} d_{2}}"),
    ("(1/a1)*a2", r"\frac{a_{2}}{a_{1}}"),
    ("a1/(a1 + a2)", r"\frac{a_{1}}{a_{1} + a_{2}}"),
    ("pi/6 + 1/2", r"\tfrac{\pi}{6} + \tfrac{1}{2}"),
    ("2*(1/3)", r"\tfrac{2}{3}"),
    ("sin(theta1)^2*cos(theta1 - theta2)**2", r"s_{1}^{2} \cos^{2}(\theta_{1} - \theta_{2})"),
    ("cos(theta1 + pi/6)", r"\cos\left(\theta_{1} + \tfrac{\pi}{6}\right)"),
    ("sin(2*theta1) + sin(theta1 + theta1)", r"\sin(2 \theta_{1}) + \sin(\theta_{1} + \theta_{1})"),
    ("30 deg + 22.5°", r"30^{\circ} + 22.5^{\circ}"),
    ("-180*pi/180 + a1*pi/180", r"-180^{\circ} + \tfrac{1}{180}\, a_{1} \pi"),
    ("c321", "c_{123}"),
    ("(-a1)^2 - a1^2 + (a1*a2)^(1/2)", "(-a_{1})^{2} - a_{1}^{2} + (a_{1} a_{2})^{1/2}"),
    ("sqrt(a1)^3", r"\left(\sqrt{a_{1}}\right)^{3}"),
    ("abs(a1) + sign(a1) + atan2(a1, a2)", r"\left|a_{1}\right| + \text{sign}(a_{1}) + \text{atan2}(a_{1}, a_{2})"),
    ("asin(a1) + acot(a1) + log(a1) + exp(a1)", r"\arcsin(a_{1}) + \text{arccot}(a_{1}) + \ln(a_{1}) + \exp(a_{1})"),
    ("cot(a1) + sec(a1) + sinh(a1) + tan(a1)", r"\cot(a_{1}) + \sec(a_{1}) + \sinh(a_{1}) + \tan(a_{1})"),
    ("E^a1 + I", "e^{a_{1}} + i"),
    ("qd1 + qd2 + vx", r"\dot{\theta}_{1} + \dot{d}_{2} + v_{x}"),
    ("foo_bar*a1", r"\text{foo_bar}\, a_{1}"),
    ("9**9**9", "9^{9^{9}}"),
    ("0.350 + 0.30000000000000004", "0.35 + 0.30000000000000004"),
    ("1.5e-12*a1 + 2e300", r"(1.5 \cdot 10^{-12}) a_{1} + 2 \cdot 10^{300}"),
    ("blank", r"\square"),
    ("[[a1, 0], [0, blank]]", r"\begin{bmatrix} a_{1} & 0 \\ 0 & \square \end{bmatrix}"),
    ("[1, 2]", r"\begin{bmatrix} 1 \\ 2 \end{bmatrix}"),
    ("[[1, 2]]", r"\begin{bmatrix} 1 & 2 \end{bmatrix}"),
    ("{{1, 2}, {3, 4}}", r"\begin{bmatrix} 1 & 2 \\ 3 & 4 \end{bmatrix}"),
    ("{0, pi}", r"\left\{0, \pi\right\}"),
    ("[]", r"\left[\right]"),
    ("{theta2: [0, pi], theta1: 0}", r"\theta_{2} \in \left\{0, \pi\right\} \text{ and } \theta_{1} = 0"),
    ("theta2 in {0, pi}", r"\theta_{2} \in \left\{0, \pi\right\}"),
    ("[Eq(theta2, 0), Eq(theta2, pi)]", r"\theta_{2} = 0, \qquad \theta_{2} = \pi"),
    ("theta2 = 0 or theta1 = k*pi & d2 = 0",
     r"\theta_{2} = 0 \text{ or } \qquad \theta_{1} = k \pi \text{ and } d_{2} = 0"),
    ("det = a1", r"\text{det} = a_{1}"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "printed"), SET)
def test_as_it_was_typed(text: str, printed: str) -> None:
    shown = typeset(read(text, KNOWN), ("2",))
    assert latex(shown) == printed
    ET.fromstring(mathml(shown, True))


def test_conditions_in_a_list_are_alternatives_of_a_singular_set() -> None:
    assert r"\text{ or }" in latex(typeset(read("[Eq(theta2, 0), Eq(theta2, pi)]", KNOWN), (), alternatives=True))


def test_numbers_have_their_units() -> None:
    node = read("[0.5, 2]", KNOWN)
    assert latex(typeset(node, (), units=("rad/s", ""))) == r"\begin{bmatrix} 0.5\,\text{rad/s} \\ 2 \end{bmatrix}"
    assert latex(typeset(read("0.5"), (), units=("m",))) == r"0.5\,\text{m}"
    assert r"\text" not in latex(typeset(node, (), units=("m", "m", "m")))


def test_a_fraction_that_no_text_makes() -> None:
    from fractions import Fraction

    assert latex(typeset(Node("number", value=Fraction(2, 3)))) == r"\tfrac{2}{3}"


def test_a_sum_may_be_long_and_not_deep() -> None:
    assert latex(typeset(read("+".join(["a1"] * 5000)))).count("a_{1}") == 5000
    assert latex(typeset(read("/".join(["a1"] * 500)))).count(r"\frac") == 1
    for deep in (
        "(-" * 40 + "1" + ")" * 40,
        "2^" * 50 + "2",
        "sin(-" * 25 + "1" + ")" * 25,
    ):
        with pytest.raises(TooDeep):
            typeset(read(deep))


def test_a_name_is_nothing_but_a_name() -> None:
    """Letters may stand for signs: the bracketed one is "(1)" in another form."""
    assert latex(typeset(read("x⑴y"))) == r"\text{x?1?y}"


def test_what_is_set_reads_as_the_same(problem: Problem) -> None:
    """The grader reads LaTeX too: the reference of every part, set and read again, is right."""
    for part in problem.parts:
        if isinstance(part.answer, (Expression, Matrix)):
            text = str(part.answer.as_json()).replace("'", "")
            prismatic = tuple(q.name[1:] for q in problem.chain.q if q.name.startswith("d"))
            shown = typeset(read(text, problem.symbols()), prismatic)
            ET.fromstring(mathml(shown, True))
            if len(printed := latex(shown)) < 15_000:  # longer LaTeX is not read
                assert judge(problem, part, printed, "s").outcome is Outcome.CORRECT, (part.name, printed)
        elif isinstance(part.answer, ConditionSet):
            text = f"[{', '.join(part.answer.pieces())}]"
            ET.fromstring(mathml(typeset(read(text, problem.symbols()), (), alternatives=True), True))
