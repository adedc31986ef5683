"""Formulas set by ourselves are what latex2mathml makes of them, to the letter, and as wide."""

import xml.etree.ElementTree as ET
from collections.abc import Iterator

import pytest
from latex2mathml.converter import convert

from exercises.formula.expression import read
from exercises.generation import generate
from exercises.problem import ProblemId
from exercises.writing.direct import direct, element_width
from exercises.writing.mathml import known
from exercises.writing.statement import worked_solution
from exercises.writing.typeset import typeset

TYPED = (
    "-a1*sin(theta1 + theta2)/2 + x_long^2",
    "[[1, 2.5], [sqrt(2)/3, -pi/2]]",
    "{theta2: [0, pi]}",
    "theta1 = theta2",
    "sin(theta1 - pi/6)^2*cos(q1/2)^3",
    "abs(a1/a2) + exp(-x)/(1 + 1/(1 + x))",
    "[]",
    "qd1^(1/2)",
    "1e-12*theta1",
    "blank",
    "[sin(theta2) = 0, theta1 = pi and theta2 = 0]",
    "atan2(a1, 2)*log(3)*a1_2",
    "(((a1 + 1)^2 + 1)^2 + 1)^(-2)",
)
ODD = (
    "{}",
    "{} + 1",
    "x",
    "x^2",
    "x^{2}_{1}",
    "x_1^2",
    "x_{1}_{2}",
    "_{1}",
    r"\frac12",
    r"\frac{1}2",
    r"\sqrt[3]{x}",
    r"\left( x",
    r"\left. x \right|",
    "x'",
    "1 % 2",
    "2 in",
    r"\text{2 cm}",
    r"\text{}",
    r"\begin{bmatrix} {c} \end{bmatrix}",
    r"\begin{bmatrix} 1 & \\ 2 & \end{bmatrix}",
    r"\begin{bmatrix} 1 & 2 \\ \end{bmatrix}^{T}",
    r"\mathrm{d} x",
    r"a < b",
    r"\left\{ x \right\}_{1}",
    r"\begin{align*} a &= b \\ & + c && d \end{align*}",
    r"\dot x",
    r"\dot{d}_{2}",
    "θ",
    r"\{1\}",
    r"\begin{matrix} 1 \end{matrix}",
    r"\sum_{i} x",
    r"\begin{bmatrix} \end{bmatrix}",
    r"a & b",
    r"a \\ b",
    "}",
    "{",
    "1.5.",
)


def checked(latex: str) -> bool:
    """Compare one formula; return whether it is set by ourselves."""
    found = direct(latex)
    if found is None:
        return False
    shown = f'<math xmlns="http://www.w3.org/1998/Math/MathML" display="block">{found.shown}</math>'
    assert shown == convert(latex, display="block")
    assert found.full == element_width(ET.fromstring(shown))
    return True


@pytest.mark.parametrize("text", TYPED)
def test_what_students_type_is_set_by_ourselves(text: str) -> None:
    latex = typeset(read(text, frozenset()), alternatives=True)
    assert checked(known(latex))


@pytest.mark.parametrize("latex", ODD)
def test_what_latex2mathml_takes_in_a_way_of_its_own_is_left_to_it(latex: str) -> None:
    checked(latex)


QUESTIONS = ("position", "jacobian", "determinant")


def formulas() -> Iterator[str]:
    """Yield the formulas of worked solutions."""
    for family in ("planar-2r", "polar-rp"):
        problem = generate(ProblemId(family, 3, QUESTIONS))
        for part in problem.parts:
            pieces = worked_solution(problem, part).replace("$$", "$").split("$")
            yield from (" ".join(piece.split()) for piece in pieces[1::2])


def test_formulas_of_worked_solutions_are_the_same() -> None:
    every = [checked(known(latex)) for latex in formulas()]
    assert sum(every) > 0.8 * len(every)
