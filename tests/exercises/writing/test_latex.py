"""Formulas as the textbook prints them: its own lines first, then what must hold for every family's answers."""

import re

import pytest
import sympy as sp

from exercises import generate
from exercises.answers import Expression, Matrix
from exercises.arm.derivation import derive
from exercises.problem import Problem
from exercises.writing.angles import AngleNames, angle_names, link_angles
from exercises.writing.latex import LINE, lengths_of, symbol_latex, tex, tex_angle, tex_length, tex_lines
from exercises.writing.worked import Worked

T1, T2, T3, A1, A2, A3, D2 = sp.symbols("theta1 theta2 theta3 a1 a2 a3 d2")
QD1, QD2, VX, VY = sp.symbols("qd1 qd2 vx vy")
Q = sp.Rational
CHAPTER = ("planar-2r", "elbow-3r", "polar-rp", "planar-3r")
S, C = sp.sin, sp.cos


def plain(expression: sp.Expr) -> str:
    """Return LaTeX without the braces of indices."""
    return re.sub(r"_\{(\w+)\}", r"_\1", tex(expression))


BOOK = [
    (A1 * C(T1) + A2 * C(T1 + T2), "a_1 c_1 + a_2 c_12"),
    (-A1 * S(T1) - A2 * S(T1 + T2), "-a_1 s_1 - a_2 s_12"),
    (C(T1) * (A1 + A2 * C(T2) + A3 * C(T2 + T3)), "c_1 (a_1 + a_2 c_2 + a_3 c_23)"),
    (-A3 * S(T1) * S(T2 + T3), "-a_3 s_1 s_23"),
    (sp.Symbol("d1") - A2 * S(T2) - A3 * S(T2 + T3), "d_1 - a_2 s_2 - a_3 s_23"),
    (A2 * A3 * S(T3) * (A1 + A2 * C(T2)), "a_2 a_3 s_3 (a_1 + a_2 c_2)"),
    ((C(T1 + T2) * VX + S(T1 + T2) * VY) / (A1 * S(T2)), r"\frac{c_12 v_x + s_12 v_y}{a_1 s_2}"),
]
OURS = [
    (D2 + Q(33, 100), "d_2 + 0.33"),
    (C(T1 + T2 + sp.pi / 6), r"\cos(\theta_1 + \theta_2 + 30^\circ)"),
    (C(-T1 + T2 + sp.pi / 3), r"\cos(\theta_2 - \theta_1 + 60^\circ)"),
    (A1 / 2 + Q(1, 10), "0.5 a_1 + 0.1"),
    (Q(20, 7) / (A1 * S(T2)), r"\frac{1}{0.35 a_1 s_2}"),
    (sp.pi - sp.atan(4), r"\pi - \arctan(4)"),
    (-sp.atan(Q(2, 7)), r"-\arctan(\tfrac{2}{7})"),
    (-(-A1 - A2 * C(T2)) / S(T2), r"\frac{a_1 + a_2 c_2}{s_2}"),
    (A1 * C(T1) - Q(3, 5), "a_1 c_1 - 0.6"),
    (S(T1) ** 2, "s_1^{2}"),
    (sp.sqrt(3) * A1 / 2, r"\frac{\sqrt{3} a_1}{2}"),
    (Q(4866009467, 10**10) * sp.sqrt(2) + D2, r"d_2 + 0.4866009467 \sqrt{2}"),
    (-Q(591040413, 10**10) * S(Q(3, 10)), r"-0.0591040413 \sin(0.3)"),
    (sp.S.Zero, "0"),
    (Q(3, 50) * S(T2) - Q(7, 20) * C(T2), "0.06 s_2 - 0.35 c_2"),
    (-A1 * S(T1) + Q(2, 5) * S(T1 + T2), "-a_1 s_1 + 0.4 s_12"),
    ((A1 + A2) * S(T1), "(a_1 + a_2) s_1"),
    (T1 - T2 + T3, r"\theta_1 - \theta_2 + \theta_3"),
    (Q(1, 5) - A1, "0.2 - a_1"),
    (Q(5, 3), r"\tfrac{5}{3}"),
    (-(S(T1) * VX - C(T1) * VY) / (A1 + A2), r"\frac{-s_1 v_x + c_1 v_y}{a_1 + a_2}"),
    (C(T1) * sp.Symbol("fx") + S(T1) * sp.Symbol("fy") + sp.Symbol("mz"), "c_1 f_x + s_1 f_y + m_z"),
    ((D2 + 1) * C(T1), "c_1 (d_2 + 1)"),
    ((D2 + 1) * C(T1 + sp.pi / 3), r"(d_2 + 1) \cos(\theta_1 + 60^\circ)"),
]  # fmt: skip


@pytest.mark.parametrize(("expression", "expected"), BOOK + OURS)
def test_as_printed(expression: sp.Expr, expected: str) -> None:
    assert plain(expression) == expected


def test_rates_stand_behind_their_coefficients() -> None:
    assert (
        plain(A1 * S(T1) * QD1 + (A1 + A2 * C(T2)) * QD2) == r"a_1 s_1 \dot{\theta}_1 + (a_1 + a_2 c_2) \dot{\theta}_2"
    )


def test_prismatic_rates_are_rates_of_d() -> None:
    assert symbol_latex("qd2", ("2",)) == r"\dot{d}_{2}"


def test_table_entries() -> None:
    assert tex_angle(T2 - sp.pi / 2) == r"\theta_{2} - 90^\circ"
    assert tex_angle(sp.S.Zero) == "0"
    assert tex_length(Q(7, 20)) == r"0.35\,\text{m}"
    assert tex_length(A1) == "a_{1}" and tex_length(sp.S.Zero) == "0"
    assert tex_length(D2 - Q(33, 100)) == r"d_{2} - 0.33\,\text{m}"


# --- named angles ---


def named(expression: sp.Expr, *links: sp.Expr) -> tuple[str, AngleNames]:
    names = angle_names(links, sp.Matrix([expression]))
    return re.sub(r"_\{(\w+)\}", r"_\1", tex(expression, None, names)), names


def test_angles_are_named_as_those_of_links() -> None:
    link = T1 - 2 * sp.pi / 3  # SymPy folds its cosine to -cos(theta1 + pi/3)
    shown, names = named(A1 * C(link) - A2 * S(link), link)
    assert shown == r"a_1 \cos \varphi_1 - a_2 \sin \varphi_1"
    assert list(names.meanings.values()) == [link]
    back = T1 - T2 - sp.pi / 6
    shown, names = named(A2 * S(-back), T1, back)
    assert shown == r"-a_2 \sin \varphi_12" and list(names.meanings.values()) == [back]
    assert named(A1 * C(T1 + sp.pi), T1 + sp.pi)[0] == "-a_1 c_1"


def test_no_product_reads_as_the_argument_of_a_cosine() -> None:
    link = T1 + sp.pi / 3
    assert named((D2 + Q(1, 2)) * C(link), link)[0] == r"(d_2 + 0.5) \cos \varphi_1"
    assert named(QD2 * C(link), link)[0] == r"\cos \varphi_1\, \dot{\theta}_2"


def test_different_angles_have_different_names() -> None:
    names = angle_names([], sp.Matrix([C(T1 + sp.pi / 3), C(T1 + sp.pi / 4)])).meanings
    assert len(names) == 2 and sorted(map(str, names)) == [r"\varphi'_{1}", r"\varphi_{1}"]


# --- read back: what is printed means what was meant ---


def _entries(problem: Problem) -> list[sp.Expr]:
    found: list[sp.Expr] = []
    for part in problem.parts:
        if isinstance(part.answer, Expression):
            found.append(part.answer.reference)
        elif isinstance(part.answer, Matrix):
            found += list(part.answer.reference)
    return found


def _long_trig(match: re.Match[str]) -> str:
    angles = "+".join(f"theta{digit}" for digit in match.group(2))
    return f"{'cos' if match.group(1) == 'c' else 'sin'}({angles})"


def _read_back(text: str) -> sp.Expr:
    """Return the expression of a printed formula, by Python's own rules for what is left after rewriting."""
    text = re.sub(r"([\d.]+)\^\\circ", r"(\1*pi/180)", text.replace(r"\,", " ").replace("{}", ""))
    while True:
        changed = re.sub(r"\\t?frac\{((?:[^{}]|\{[^{}]*\})*)\}\{((?:[^{}]|\{[^{}]*\})*)\}", r"((\1)/(\2))", text)
        if changed == text:
            break
        text = changed
    text = re.sub(r"\\dot\{(?:\\theta|d)\}_\{(\d)\}", r"qd\1", text)
    text = re.sub(r"\\?\b(theta|[avwdLhfm])_\{(\w)\}", r"\1\2", text)
    text = re.sub(r"\\sqrt\{(\d+)\}", r" sqrt(\1)", text)
    text = re.sub(r"\b(sin|cos)\^\{2\}(\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\))", r"\1\2^{2}", text)
    text = re.sub(r"\\omega_\{(\w)\}", r"w\1", text)
    text = re.sub(r"\b([cs])_\{(\d+)\}", _long_trig, text)
    text = text.replace(r"\left", "").replace(r"\right", "").replace("\\", "").replace("^{2}", "**2")
    text = re.sub(r"(?<=[\w)]) (?=[\w(])", "*", text)
    names = {name: sp.Symbol(name) for name in re.findall(r"[a-zL]+\d|[vwfm][xyz]", text)}
    return sp.sympify(re.sub(r"\d*\.\d+", lambda m: f"Rational('{m.group()}')", text), locals=names)


def test_printed_formulas_mean_the_same(problem: Problem) -> None:
    for entry in set(_entries(problem)):
        shown = tex(entry, problem.chain)
        back = _read_back(shown)
        values = {s: sp.Float(0.3 + 0.17 * i) for i, s in enumerate(sorted(entry.free_symbols, key=str))}
        assert abs(float((back - entry).xreplace(values))) < 1e-9, shown


def test_long_sums_are_broken_between_their_terms_and_nowhere_else(problem: Problem) -> None:
    for entry in set(_entries(problem)):
        whole, lines = tex(entry, problem.chain), tex_lines(entry, problem.chain).split(r" \\ & \quad ")
        assert " ".join(lines) == whole
        assert all(line.startswith(("+ ", "- ")) and line.count("{") == line.count("}") for line in lines[1:])
        assert len(lines) == 1 or len(whole) > LINE


def test_named_angles_are_the_links_own(problem: Problem) -> None:
    links, names = link_angles(problem.chain), Worked(problem.chain).angles
    if problem.id.family in CHAPTER:  # where a slide lies between parallel axes, their angles add up beside the links'
        derivation = derive(problem.chain)
        used = (names.put_into(derivation.position.row_join(derivation.linear))).free_symbols & set(names.meanings)
        assert all(any(sp.expand(names.meanings[name] - link) == 0 for link in links) for name in used)
    for entry in set(_entries(problem)):
        values = {s: sp.Float(0.3 + 0.17 * i) for i, s in enumerate(sorted(entry.free_symbols, key=str))}
        back = names.put_into(entry).subs(names.meanings)
        assert abs(float((back - entry).xreplace(values))) < 1e-9


@pytest.mark.parametrize(
    ("problem_id", "shown", "not_shown"),
    [
        ("planar-3r-pose/819@lengths", r"\frac{0.35 s_{3}}{0.45 s_{2}}", r"\frac{7"),
        ("random-3/318@lengths", r"{0.2 d_{2} c_{3}}", "5 "),
    ],
)
def test_quotients_of_lengths_are_of_decimals(problem_id: str, shown: str, not_shown: str) -> None:
    chain = generate(problem_id, ["inverse-jacobian"]).chain
    inverse = tex(derive(chain).inverse, chain)
    assert shown in inverse and not_shown not in inverse


def test_what_is_no_quotient_of_an_arms_lengths_stays_a_fraction() -> None:
    chain = generate("planar-3r-pose/819@lengths", ["jacobian"]).chain
    assert lengths_of(chain) == (Q(9, 20), Q(7, 20))
    assert tex(11 * S(T1) / (13 * S(T2)), chain) == r"\frac{11 s_{1}}{13 s_{2}}"
    assert tex(5 * S(T1) / S(T2), chain) == r"\frac{5 s_{1}}{s_{2}}"
