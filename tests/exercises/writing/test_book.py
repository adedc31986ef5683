"""Arms as the chapter draws them: results print as Examples 6.1 to 6.4, symbol by symbol."""

import re
from collections.abc import Callable
from functools import cache

import pytest

from exercises import generate
from exercises.problem import Problem
from exercises.writing.latex import tex
from exercises.writing.statement import answer_code, worked_solution, worked_solutions

Answers = dict[str, list[list[str]]]

REACH = "(a_1 + a_2 c_2 + a_3 c_23)"
"""How far the wrist of Example 6.3 reaches out."""
RATE_1, RATE_2, RATE_3 = (rf"\dot{{\theta}}_{i}" for i in (1, 2, 3))

PLANAR: Answers = {
    "velocity": [
        [f"-a_1 s_1 {RATE_1} - a_2 s_12 ({RATE_1} + {RATE_2})"],
        [f"a_1 c_1 {RATE_1} + a_2 c_12 ({RATE_1} + {RATE_2})"],
    ],
    "position": [["a_1 c_1 + a_2 c_12"], ["a_1 s_1 + a_2 s_12"]],
    "jacobian": [["-a_1 s_1 - a_2 s_12", "-a_2 s_12"], ["a_1 c_1 + a_2 c_12", "a_2 c_12"]],
    "determinant": [["a_1 a_2 s_2"]],
    "inverse-jacobian": [
        [r"\frac{c_12}{a_1 s_2}", r"\frac{s_12}{a_1 s_2}"],
        [r"-\frac{a_1 c_1 + a_2 c_12}{a_1 a_2 s_2}", r"-\frac{a_1 s_1 + a_2 s_12}{a_1 a_2 s_2}"],
    ],
    "inverse-velocity": [
        [r"\frac{c_12 v_x + s_12 v_y}{a_1 s_2}"],
        [r"-\frac{(a_1 c_1 + a_2 c_12) v_x + (a_1 s_1 + a_2 s_12) v_y}{a_1 a_2 s_2}"],
    ],
    "joint-axes": [["0", "0"], ["0", "0"], ["1", "1"]],
    "position-vectors": [["a_1 c_1 + a_2 c_12", "a_2 c_12"], ["a_1 s_1 + a_2 s_12", "a_2 s_12"], ["0", "0"]],
    "geometric-jacobian": [
        ["-a_1 s_1 - a_2 s_12", "-a_2 s_12"], ["a_1 c_1 + a_2 c_12", "a_2 c_12"],
        ["0", "0"], ["0", "0"], ["0", "0"], ["1", "1"],
    ],
    "link-velocity": [[f"-a_1 s_1 {RATE_1}"], [f"a_1 c_1 {RATE_1}"], ["0"], ["0"], ["0"], [RATE_1]],
}  # fmt: skip
ELBOW: Answers = {
    "position": [[f"c_1 {REACH}"], [f"s_1 {REACH}"], ["d_1 - a_2 s_2 - a_3 s_23"]],
    "jacobian": [
        [f"-s_1 {REACH}", "-c_1 (a_2 s_2 + a_3 s_23)", "-a_3 c_1 s_23"],
        [f"c_1 {REACH}", "-s_1 (a_2 s_2 + a_3 s_23)", "-a_3 s_1 s_23"],
        ["0", "-a_2 c_2 - a_3 c_23", "-a_3 c_23"],
    ],
    "determinant": [[f"a_2 a_3 s_3 {REACH}"]],
    "velocity": [
        [f"-s_1 {REACH} {RATE_1} - c_1 (a_2 s_2 + a_3 s_23) {RATE_2} - a_3 c_1 s_23 {RATE_3}"],
        [f"c_1 {REACH} {RATE_1} - s_1 (a_2 s_2 + a_3 s_23) {RATE_2} - a_3 s_1 s_23 {RATE_3}"],
        [f"-(a_2 c_2 + a_3 c_23) {RATE_2} - a_3 c_23 {RATE_3}"],
    ],
}


@cache
def planar() -> Problem:
    return generate("planar-2r/1@chapter")


@cache
def elbow() -> Problem:
    return generate("elbow-3r/1@chapter")


def printed(formula: str) -> str:
    """Return LaTeX without the braces of indices."""
    return re.sub(r"_\{(\w+)\}", r"_\1", formula)


def entries(problem: Problem, name: str) -> list[list[str]]:
    """Return the LaTeX of an answer, entry by entry."""
    return [[printed(tex(entry, problem.chain)) for entry in row] for row in problem[name].answer.as_matrix().tolist()]


@pytest.mark.parametrize("name", PLANAR)
def test_examples_1_2_and_4(name: str) -> None:
    assert entries(planar(), name) == PLANAR[name]


@pytest.mark.parametrize("name", ELBOW)
def test_example_3(name: str) -> None:
    assert entries(elbow(), name) == ELBOW[name]


@pytest.mark.parametrize(("arm", "names"), [(planar, PLANAR), (elbow, ELBOW)])
def test_the_solutions_hold_these_lines_and_name_no_angle(
    arm: Callable[[], Problem], names: dict[str, list[list[str]]]
) -> None:
    problem = arm()
    for name, rows in names.items():
        text = printed(worked_solution(problem, problem[name]))
        for entry in {entry for row in rows for entry in row}:
            assert name == "inverse-jacobian" or entry in text, (name, entry)
    assert not any(r"\varphi" in text for text in worked_solutions(problem).values())


def test_the_inverse_is_the_books_matrix_over_the_determinant() -> None:
    matrix = r"\begin{bmatrix} a_2 c_12 & a_2 s_12 \\ -a_1 c_1 - a_2 c_12 & -a_1 s_1 - a_2 s_12 \end{bmatrix}"
    assert rf"\frac{{1}}{{a_1 a_2 s_2}} {matrix}" in printed(worked_solution(planar(), planar()["inverse-jacobian"]))


def test_code_reads_as_the_formula_does() -> None:
    assert answer_code(planar(), planar()["position"]) == (
        "Matrix([\n    a1*cos(theta1) + a2*cos(theta1 + theta2),\n    a1*sin(theta1) + a2*sin(theta1 + theta2),\n])"
    )
    assert answer_code(elbow(), elbow()["determinant"]) == (
        "a2*a3*sin(theta3)*(a1 + a2*cos(theta2) + a3*cos(theta2 + theta3))"
    )
