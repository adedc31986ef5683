"""Formulas as the textbook prints them: its own lines, every family's answers, and what students typed."""

import re
import xml.etree.ElementTree as ET
from fractions import Fraction
from functools import cache

import pytest
import sympy as sp

from qdot import generate
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.printers.latex import print_latex
from qdot.exercises.formula.printers.mathml import print_mathml
from qdot.exercises.formula.trees import Node
from qdot.exercises.problem.problem import Problem
from qdot.exercises.reference_answers import ConditionSet, Expression, Matrix
from qdot.exercises.writing.angles import AngleNames, list_link_angles, name_angles
from qdot.exercises.writing.latex import (
    MAX_LINE_WIDTH,
    list_numeric_lengths,
    tex,
    tex_angle,
    tex_length,
    tex_lines,
    write_symbol,
)
from qdot.exercises.writing.line_breaking import estimate_width
from qdot.exercises.writing.problem_texts import write_solution, write_solutions
from qdot.exercises.writing.solution_steps import SolutionSteps
from qdot.exercises.writing.typeset import TooDeep, typeset
from qdot.grader.judging.judge import judge
from qdot.grader.judging.verdict import Outcome
from tests.support import read_cases

T1, T2, T3, A1, A2, A3, D2 = sp.symbols("theta1 theta2 theta3 a1 a2 a3 d2")
QD1, QD2, VX, VY = sp.symbols("qd1 qd2 vx vy")
Q = sp.Rational
CHAPTER = ("planar-2r", "elbow-3r", "polar-rp", "planar-3r")
S, C = sp.sin, sp.cos


def printed(formula: str) -> str:
    return re.sub(r"_\{(\w+)\}", r"_\1", formula)


OURS = [
    (D2 + Q(33, 100), "d_2 + 0.33"), (C(T1 + T2 + sp.pi / 6), r"\cos(\theta_1 + \theta_2 + 30^\circ)"),
    (C(-T1 + T2 + sp.pi / 3), r"\cos(\theta_2 - \theta_1 + 60^\circ)"), (A1 / 2 + Q(1, 10), "0.5 a_1 + 0.1"),
    (Q(20, 7) / (A1 * S(T2)), r"\frac{1}{0.35 a_1 s_2}"), (sp.pi - sp.atan(4), r"\pi - \arctan(4)"),
    (-sp.atan(Q(2, 7)), r"-\arctan(\tfrac{2}{7})"), (-(-A1 - A2 * C(T2)) / S(T2), r"\frac{a_1 + a_2 c_2}{s_2}"),
    (A1 * C(T1) - Q(3, 5), "a_1 c_1 - 0.6"), (S(T1) ** 2, "s_1^{2}"),
    (sp.sqrt(3) * A1 / 2, r"\frac{\sqrt{3} a_1}{2}"),
    (Q(4866009467, 10**10) * sp.sqrt(2) + D2, r"d_2 + 0.4866009467 \sqrt{2}"),
    (-Q(591040413, 10**10) * S(Q(3, 10)), r"-0.0591040413 \sin(0.3)"), (sp.S.Zero, "0"),
    (Q(3, 50) * S(T2) - Q(7, 20) * C(T2), "0.06 s_2 - 0.35 c_2"),
    (-A1 * S(T1) + Q(2, 5) * S(T1 + T2), "-a_1 s_1 + 0.4 s_12"), ((A1 + A2) * S(T1), "(a_1 + a_2) s_1"),
    (T1 - T2 + T3, r"\theta_1 - \theta_2 + \theta_3"), (Q(1, 5) - A1, "0.2 - a_1"), (Q(5, 3), r"\tfrac{5}{3}"),
    (-(S(T1) * VX - C(T1) * VY) / (A1 + A2), r"\frac{-s_1 v_x + c_1 v_y}{a_1 + a_2}"),
    (C(T1) * sp.Symbol("fx") + S(T1) * sp.Symbol("fy") + sp.Symbol("mz"), "c_1 f_x + s_1 f_y + m_z"),
    ((D2 + 1) * C(T1), "c_1 (d_2 + 1)"),
    (A1 * S(T1) * QD1 + (A1 + A2 * C(T2)) * QD2, r"a_1 s_1 \dot{\theta}_1 + (a_1 + a_2 c_2) \dot{\theta}_2"),
    ((D2 + 1) * C(T1 + sp.pi / 3), r"(d_2 + 1) \cos(\theta_1 + 60^\circ)"),
]  # fmt: skip


@pytest.mark.parametrize(("expression", "expected"), OURS)
def test_as_printed(expression: sp.Expr, expected: str) -> None:
    assert printed(tex(expression)) == expected


def test_table_entries() -> None:
    assert [tex_angle(angle) for angle in (T2 - sp.pi / 2, sp.S.Zero)] == [r"\theta_{2} - 90^\circ", "0"]
    for length, shown in ((Q(7, 20), r"0.35\,\text{m}"), (A1, "a_{1}"), (sp.S.Zero, "0")):
        assert tex_length(length) == shown
    assert tex_length(D2 - Q(33, 100)) == r"d_{2} - 0.33\,\text{m}"
    assert write_symbol("qd2", ("2",)) == r"\dot{d}_{2}"


def named(expression: sp.Expr, *links: sp.Expr) -> tuple[str, AngleNames]:
    names = name_angles(links, sp.Matrix([expression]))
    return printed(tex(expression, None, names)), names


def test_angles_are_named_as_those_of_links() -> None:
    link = T1 - 2 * sp.pi / 3  # SymPy folds its cosine to -cos(theta1 + pi/3)
    shown, names = named(A1 * C(link) - A2 * S(link), link)
    assert shown == r"a_1 \cos \varphi_1 - a_2 \sin \varphi_1"
    assert list(names.angle_by_name.values()) == [link]
    back = T1 - T2 - sp.pi / 6
    shown, names = named(A2 * S(-back), T1, back)
    assert shown == r"-a_2 \sin \varphi_12" and list(names.angle_by_name.values()) == [back]
    assert named(A1 * C(T1 + sp.pi), T1 + sp.pi)[0] == "-a_1 c_1"


def test_no_product_reads_as_the_argument_of_a_cosine() -> None:
    link = T1 + sp.pi / 3
    assert named((D2 + Q(1, 2)) * C(link), link)[0] == r"(d_2 + 0.5) \cos \varphi_1"
    assert named(QD2 * C(link), link)[0] == r"\cos \varphi_1\, \dot{\theta}_2"


def _entries(problem: Problem) -> list[sp.Expr]:
    found: list[sp.Expr] = []
    for part in problem.parts:
        if isinstance(part.answer, Expression):
            found.append(part.answer.reference)
        elif isinstance(part.answer, Matrix):
            found += list(part.answer.reference)
    return found


def test_printed_formulas_break_between_their_terms(problem: Problem) -> None:
    """A line leaves 1 em for the indentation of the next one."""
    for entry in set(_entries(problem)):
        shown, lines = tex(entry, problem.chain), tex_lines(entry, problem.chain).split(r" \\ & \quad ")
        assert " ".join(lines) == shown
        assert len(lines) == 1 or estimate_width(parse_latex(shown)) > MAX_LINE_WIDTH - 1.0
        assert all(line.startswith(("+ ", "- ")) and line.count("{") == line.count("}") for line in lines[1:])


def test_named_angles_are_the_links_own(problem: Problem) -> None:
    links, names = list_link_angles(problem.chain), SolutionSteps(problem.chain).angles
    if problem.id.family in CHAPTER:  # where a slide lies between parallel axes, their angles add up beside the links'
        derivation = derive(problem.chain)
        shown = names.use_names(derivation.position.row_join(derivation.linear_rows))
        used = shown.free_symbols & set(names.angle_by_name)
        assert all(any(sp.expand(names.angle_by_name[name] - link) == 0 for link in links) for name in used)
    for entry in set(_entries(problem)):
        values = {s: sp.Float(0.3 + 0.17 * i) for i, s in enumerate(sorted(entry.free_symbols, key=str))}
        back = names.use_names(entry).subs(names.angle_by_name)
        assert abs(float((back - entry).xreplace(values))) < 1e-9


def test_quotients_of_lengths_are_of_decimals_and_others_stay_fractions() -> None:
    for problem_id, there, not_there in (
        ("planar-3r-pose/819@lengths", r"\frac{0.35 s_{3}}{0.45 s_{2}}", r"\frac{7"),
        ("random-3/318@lengths", r"{0.2 d_{2} c_{3}}", "5 "),
    ):
        chain = generate(problem_id, ["inverse-jacobian"]).chain
        inverse = tex(derive(chain).inverse, chain)
        assert there in inverse and not_there not in inverse
    chain = generate("planar-3r-pose/819@lengths", ["jacobian"]).chain
    assert list_numeric_lengths(chain) == (Q(9, 20), Q(7, 20))
    assert tex(11 * S(T1) / (13 * S(T2)), chain) == r"\frac{11 s_{1}}{13 s_{2}}"
    assert tex(5 * S(T1) / S(T2), chain) == r"\frac{5 s_{1}}{s_{2}}"


Answers = dict[str, list[list[str]]]
REACH = "(a_1 + a_2 c_2 + a_3 c_23)"
"""The radial distance of the wrist of Example 6.3."""
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
def asked(family: str) -> Problem:
    return generate(f"{family}/1@chapter", list(PLANAR if family == "planar-2r" else ELBOW))


def entries(problem: Problem, name: str) -> list[list[str]]:
    return [[printed(tex(entry, problem.chain)) for entry in row] for row in problem[name].answer.as_matrix().tolist()]


@pytest.mark.parametrize(
    ("identity", "name"), [*(("planar-2r", name) for name in PLANAR), *(("elbow-3r", name) for name in ELBOW)]
)
def test_examples(identity: str, name: str) -> None:
    """Examples 1, 2 and 4 are about the planar arm, example 3 is about the elbow."""
    assert entries(asked(identity), name) == (PLANAR if identity == "planar-2r" else ELBOW)[name]


@pytest.mark.parametrize(("identity", "names"), [("planar-2r", PLANAR), ("elbow-3r", ELBOW)])
def test_the_solutions_hold_these_lines_and_name_no_angle(identity: str, names: Answers) -> None:
    problem = asked(identity)
    for name, rows in names.items():
        text = printed(write_solution(problem, problem[name]))
        for entry in {entry for row in rows for entry in row}:
            assert name == "inverse-jacobian" or entry in text, (name, entry)
    assert not any(r"\varphi" in text for text in write_solutions(problem).values())


def test_the_inverse_is_the_books_matrix_over_the_determinant() -> None:
    matrix = r"\begin{bmatrix} a_2 c_12 & a_2 s_12 \\ -a_1 c_1 - a_2 c_12 & -a_1 s_1 - a_2 s_12 \end{bmatrix}"
    text = write_solution(asked("planar-2r"), asked("planar-2r")["inverse-jacobian"])
    assert rf"\frac{{1}}{{a_1 a_2 s_2}} {matrix}" in printed(text)


KNOWN = frozenset({"theta1", "theta2", "theta3", "a1", "a2", "d2", "qd1", "qd2", "vx"})


@pytest.mark.parametrize(("text", "printed"), read_cases("printed")["typed"])
def test_as_it_was_typed(text: str, printed: str) -> None:
    shown = typeset(parse_formula(text, KNOWN), ("2",))
    assert print_latex(shown) == printed
    ET.fromstring(print_mathml(shown, True))


def test_what_a_text_alone_does_not_tell() -> None:
    """Alternatives of a singular set, units, a fraction that no text makes, and a name that looks like "x(1)y"."""
    conditions = parse_formula("[Eq(theta2, 0), Eq(theta2, pi)]", KNOWN)
    assert r"\text{ or }" in print_latex(typeset(conditions, (), are_alternatives=True))
    node = parse_formula("[0.5, 2]", KNOWN)
    with_unit = print_latex(typeset(node, (), units=("rad/s", "")))
    assert with_unit == r"\begin{bmatrix} 0.5\,\text{rad/s} \\ 2 \end{bmatrix}"
    assert print_latex(typeset(parse_formula("0.5"), (), units=("m",))) == r"0.5\,\text{m}"
    assert r"\text" not in print_latex(typeset(node, (), units=("m", "m", "m")))
    assert print_latex(typeset(Node("number", value=Fraction(2, 3)))) == r"\tfrac{2}{3}"
    assert print_latex(typeset(parse_formula("x⑴y"))) == r"\text{x?1?y}"


def test_a_sum_may_be_long_and_not_deep() -> None:
    assert print_latex(typeset(parse_formula("+".join(["a1"] * 5000)))).count("a_{1}") == 5000
    assert print_latex(typeset(parse_formula("/".join(["a1"] * 500)))).count(r"\frac") == 1
    for deep in ("(-" * 40 + "1" + ")" * 40, "2^" * 50 + "2", "sin(-" * 25 + "1" + ")" * 25):
        with pytest.raises(TooDeep):
            typeset(parse_formula(deep))


def test_what_is_set_reads_as_the_same(problem: Problem) -> None:
    """The grader reads LaTeX too: the reference of every part, set and read again, is right."""
    for part in problem.parts:
        if isinstance(part.answer, (Expression, Matrix)):
            text = str(part.answer.as_json()).replace("'", "")
            prismatic = tuple(q.name[1:] for q in problem.chain.q if q.name.startswith("d"))
            shown = typeset(parse_formula(text, problem.symbols), prismatic)
            ET.fromstring(print_mathml(shown, True))
            reference = part.answer.reference if isinstance(part.answer, Expression) else part.answer.as_matrix()
            for printed in (print_latex(shown), tex(reference, problem.chain)):
                if len(printed) < 15_000:  # longer LaTeX is not read
                    assert judge(problem, part, printed, "s").outcome is Outcome.CORRECT, (part.name, printed)
        elif isinstance(part.answer, ConditionSet):
            text = f"[{', '.join(part.answer.list_pieces())}]"
            ET.fromstring(print_mathml(typeset(parse_formula(text, problem.symbols), (), are_alternatives=True), True))
