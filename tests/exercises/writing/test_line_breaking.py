"""Formulas fit the pages they stand on: broken over lines, and smaller only where that is not enough."""

import re
from collections import Counter
from functools import cache

import pytest
from sympy.printing.pretty.pretty_symbology import line_width

from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.writing import line_breaking
from qdot.exercises.writing.markup import HTML_WIDTH, LATEX_WIDTH, TERMINAL_WIDTH, fit_latex, to_html, to_latex, to_text
from qdot.exercises.writing.problem_texts import write_prompt, write_solution
from qdot.exercises.writing.typst import to_typst
from tests.support.problems import get_problem, select_parts

SMALLEST = 0.8
"""The size of formulas that can't be broken enough."""
DISPLAY = re.compile(r"\$\$(.+?)\$\$", re.DOTALL)
SEPARATOR = r" \\ "
ROW = r"\begin{bmatrix} " + " & ".join(["-0.1"] * 4) + r" \end{bmatrix}"
WIDE = rf"J = {ROW}, \qquad J J^T = {ROW}"


@cache
def formulas(identity: ProblemId) -> set[str]:
    problem = get_problem(identity.family, identity.seed)
    texts = [write(problem, part) for part in select_parts(problem) for write in (write_prompt, write_solution)]
    return {" ".join(found.split()) for text in texts for found in DISPLAY.findall(text)}


def width(latex: str) -> float:
    return line_breaking.estimate_width(parse_latex(latex))


def symbols(latex: str) -> Counter[str]:
    return Counter(re.findall(r"[A-Za-z\\]+(?:'|\{\w\})*_\{?\w+\}?", latex))


@pytest.mark.parametrize("room", [HTML_WIDTH, LATEX_WIDTH])
def test_every_formula_fits(problem: Problem, room: float) -> None:
    for latex in formulas(problem.id):
        shown = fit_latex(latex, room)
        assert width(shown) <= room / SMALLEST, shown
        names = {name for name in symbols(shown) if re.fullmatch(r"m_\{\d+\}", name)}
        if names:  # of long entries of a matrix, of which two may be the same
            assert set(symbols(shown)) - names == set(symbols(latex)) and all(shown.count(f"{n} =") == 1 for n in names)
        else:
            assert symbols(shown) == symbols(latex)
        assert shown == latex or width(latex) > room


def _entry(k: int, terms: int = 40) -> str:
    inner = " + ".join(rf"0.{k}{j} s_{{{k}}} \sin \varphi_{{23}}" for j in range(1, terms))
    return rf"c_{{1}} \left(c_{{2}} ({inner}) + s_{{2}} ({inner})\right)"


PRODUCT = " + ".join(rf"0.3 \cos \varphi_{{{k}}} \cos \varphi_{{123}}" for k in range(1, 7))


@pytest.mark.parametrize(
    ("latex", "room", "least_lines"),
    [
        (WIDE, width(WIDE) * 0.7, 2),  # what is beside each other comes below each other
        (f"M = L_{{3}} ({PRODUCT})", 24.0, 3),  # a product, inside of its bracket
        (f"v = {_entry(3, 9)}", 24.0, 2),  # a sum deep in brackets
    ],
)
def test_what_is_too_wide_is_broken(latex: str, room: float, least_lines: int) -> None:
    shown = fit_latex(latex, room)
    assert width(shown) <= room / SMALLEST and symbols(shown) == symbols(latex)
    assert shown.count(r"\\") >= least_lines - 1 and shown.count("(") == shown.count(")") == latex.count("(")
    assert fit_latex(latex, width(latex)) == latex


def test_a_wide_fraction_becomes_a_factor() -> None:
    shown = fit_latex(r"x = -\frac{a_{1} c_{1} + a_{2} c_{2} - a_{3} c_{3}}{s_{2}}", 8.0)
    assert r"= -\frac{1}{s_{2}} (a_{1} c_{1}" in shown and shown.index("a_{3} c_{3})") > shown.index(r"\\")


def test_what_cannot_be_broken_is_smaller_down_to_the_width_of_a_line() -> None:
    long = "$$x = " + "".join(["abcdefgh"] * 12) + "$$"
    assert re.search(r'<math style="font-size: \d\d%"', to_html(long))
    assert r"\resizebox" in to_latex(long)
    assert "font-size" not in to_html("$$x = a$$") and "size" not in to_latex("$$x = a$$")
    shown = to_latex("$$x = " + r"\frac{" + "abcdefgh" * 30 + "}{2}$$")
    assert r"\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}{" in shown
    assert shown.count("{") == shown.count("}") and shown.count(r"\[") == shown.count(r"\]") == 1


def test_a_formula_in_a_line_that_can_not_be_broken_stands_alone_with_the_point_behind_it() -> None:
    """det J of oblique axes is such a formula. In a table, no formula can stand alone, so the table shrinks."""
    wide = r"\frac{" + " + ".join(f"a_{{{k}}} c_{{12}}" for k in range(12)) + "}{2}"
    shown = to_latex(f"With $k = {wide}$, and $a$, more.")
    assert shown.index(r"\[") < shown.index(r"\frac") < shown.index(r"\]") and ", and $a$, more." not in shown
    assert re.search(r",\s*\}?\s*\\\]", shown) and shown.rstrip().endswith("and $a$, more.")
    assert r"$b + c$, and" in to_latex("With $b + c$, and")
    printed = to_typst(f"With $k = {wide}$, and")
    assert "#formulas(" in printed and '" $, ' in printed and r"\," not in printed.split("#formulas")[1]
    row = f"| a | b |\n|---|---|\n| ${wide}$ | ${wide}$ |\n"
    assert r"\[" not in to_latex(row) and r"\resizebox" in to_latex(row)


def test_rows_of_a_table_with_fractions_have_room() -> None:
    row = "| a |\n|---|\n| $x$ |\n"
    high = row.replace("$x$", r"$(\frac{\sqrt{3} a_{1}}{2}, 0, 0)$")
    assert (r"\arraystretch" in to_latex(high), r"\arraystretch" in to_latex(row)) == (True, False)
    assert ("inset" in to_typst(high), "inset" in to_typst(row)) == (True, False)
    assert "inset" in to_typst(f"{row}\n\n{high}") and to_typst(f"{row}\n\n{high}").index("inset") > 30


def test_long_entries_of_a_matrix_have_names_and_lines_of_their_own() -> None:
    matrix = rf"J = \begin{{bmatrix}} {_entry(1)} & a_{{1}}{SEPARATOR}{_entry(2)} & {_entry(1)} \end{{bmatrix}}"
    shown = fit_latex(matrix, LATEX_WIDTH)
    assert r"\begin{bmatrix} m_{1} & a_{1} \\ m_{2} & m_{1} \end{bmatrix}" in shown
    assert width(shown) <= LATEX_WIDTH / SMALLEST
    assert [shown.count(f"m_{{{k}}} =") for k in (1, 2, 3)] == [1, 1, 0]
    told = symbols(shown) - Counter({"m_{1}": 3, "m_{2}": 2})
    assert told == symbols(_entry(1)) + symbols(_entry(2)) + symbols("a_{1}")
    assert to_latex(f"$${matrix}$$").count(r"\begin{align*}") == 1


def test_different_entries_of_the_matrices_in_a_formula_have_different_names() -> None:
    wide, wider = (" + ".join(f"{letter}_{{{k}}} c_{{{k}}}" for k in range(9)) for letter in "ab")
    first, second = (rf"\begin{{bmatrix}} {entry} \\ {wide} \end{{bmatrix}}" for entry in (wide, wider))
    broken = fit_latex(rf"x = {first} \times {second}", 20.0)
    assert re.findall(r"(m_\{\d\}) = (\w)", broken) == [("m_{1}", "a"), ("m_{2}", "b")]
    assert r"m_{1} \\ m_{1} \end{bmatrix}" in broken and r"m_{2} \\ m_{1} \end{bmatrix}" in broken


def test_formulas_are_broken_to_fit_a_terminal() -> None:
    """Also a sum in which a wide matrix is followed by another term; a continued line begins with its sign."""
    terms = " + ".join(f"0.{k}25 c_{{{k}}} s_{{{k}}} c_{{{k}5}}" for k in range(1, 10))
    matrix = rf"\begin{{bmatrix}} {terms} \\ {terms.replace('+', '-')} \end{{bmatrix}}"
    for formula in (f"x = {terms}", f"J = {matrix}", f"p = {matrix} + p_{{2}}"):
        lines = to_text(f"$$\n{formula}\n$$\n").splitlines()
        assert max(map(line_width, lines)) <= TERMINAL_WIDTH
        assert any(line.strip().startswith("+ 0.") for line in lines)
    assert "m₁" in to_text(f"$$\np = {matrix} + p_{{2}}\n$$\n")


def test_a_formula_of_many_lines_may_go_on_on_the_next_page() -> None:
    assert r"\begin{align*}" not in to_latex(f"$$v = {_entry(3, 5)}$$")
    shown = to_latex(f"$$v = {_entry(3, 60)}$$")
    assert r"\allowdisplaybreaks" in shown and r"\resizebox" not in shown
    assert shown.count(r"\begin{align*}") == shown.count(r"\end{align*}") == 1 and "aligned" not in shown
