"""Wording: every prompt and worked solution of every family and question, in every markup."""

import re
import subprocess
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import pytest

from qdot.exercises.generation import generate
from qdot.exercises.notebook.problem_formats import make_problem_json, show
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.questions import QUESTIONS, screws
from qdot.exercises.reference_answers import Choice, ConditionSet, Expression, Matrix, Number
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.exercises.writing.latex import tex
from qdot.exercises.writing.markup import to_html, to_html_for_mathjax, to_latex, to_text
from qdot.exercises.writing.problem_texts import (
    write_answer_code,
    write_prompt,
    write_solution,
    write_solutions,
    write_statement,
)
from qdot.exercises.writing.render import find_template_folder
from qdot.exercises.writing.short_answer import write_short_answer
from qdot.exercises.writing.solution_steps import SolutionSteps
from tests.grader.reports.test_feedback import Page
from tests.support.problems import LONG_ARMS, get_problem, select_parts
from tests.support.programs import LATEX, require_program
from tests.support.suites import SHAPES, few_families


def test_every_question_has_its_templates() -> None:
    there = {path.name.removesuffix(".md.j2") for path in (find_template_folder() / "questions").iterdir()}
    assert there == {question.template or name for name, question in ALL_QUESTIONS.items()} | {"options", "custom"}


def test_every_question_has_its_turn_in_sweeps_that_look_at_some() -> None:
    looked_at = {part.name for family in SHAPES.values() for part in select_parts(get_problem(family, 0))}
    of_conventions = {"own-frame-velocity", *(question.name for question in screws.QUESTIONS)}
    assert looked_at == set(QUESTIONS) - of_conventions


def test_prompts_ask_and_give_nothing_away(problem: Problem) -> None:
    for part in problem.parts:
        text, code = write_prompt(problem, part), part.answer.write_code()
        _is_clean(text)
        assert "**Answer:**" in text, part.name
        if part.shape is not None and isinstance(part.answer, Matrix):
            assert f"{part.shape[0]} × {part.shape[1]}" in text, part.name
        assert len(code) < 6 or code not in text or isinstance(part.answer, Choice), part.name
        if isinstance(part.answer, Number):
            assert all(unit.removesuffix("^2").removesuffix("^3") in text for unit in part.answer.units), part.name
            assert part.answer.tolerance < 1e-6 or "three significant digits" in text, part.name


@pytest.mark.parametrize("family", ("planar-2r", "elbow-3r", "polar-rp", "planar-3r"))
def test_the_words_do_not_tell_how_many_conditions_there_are(family: str) -> None:
    problems = [generate(ProblemId(family, seed, ("singular-angles",), variation="frames")) for seed in range(3)]
    (text,) = {write_prompt(problem, problem.parts[0]) for problem in problems}
    assert not re.search(r"\bone condition|two conditions", text)


def test_worked_solutions_end_in_the_reference(problem: Problem) -> None:
    for part in select_parts(problem) if problem.id.family in LONG_ARMS else problem.parts:
        text = write_solution(problem, part)
        _is_clean(text)
        if isinstance(part.answer, Choice):
            assert f"**{part.answer.letters}**" in text, part.name
        if isinstance(part.answer, ConditionSet):
            for component in part.answer.components:
                assert component.solutions is not None or "several joints together" in text, part.name
        if isinstance(part.answer, (Expression, Matrix)) and part.kind != "link-velocity":
            assert re.search(r"\(6\.\d+\)|6\.\d+\)|appendix|det J|Cauchy|O_|\$z_|z_\{", text), part.name


def _is_clean(text: str) -> None:
    assert not re.search(r"\bNone\b|Undefined|<exercises|\{\{|\{%|\n\n\n", text)
    assert text.count("$$") % 2 == 0 and text.replace("$$", "").count("$") % 2 == 0
    for formula in re.findall(r"\$\$(.+?)\$\$|\$([^$]+)\$", text, re.DOTALL):
        latex = "".join(formula)
        assert latex.count("{") == latex.count("}"), latex
        assert latex.count(r"\left") == latex.count(r"\right"), latex
        assert latex.count(r"\begin{") == latex.count(r"\end{"), latex


def test_statement_gives_table_point_task_and_symbols(problem: Problem) -> None:
    text, chain = write_statement(problem, "A title"), problem.chain
    _is_clean(text)
    assert len(re.findall(r"^\| \d", text, re.MULTILINE)) == chain.n
    for name in [*chain.q, *chain.rates, *chain.parameters]:
        assert f"`{name}`" in text
    assert "not to scale" in text
    assert "to scale" not in write_statement(problem, "", is_movable=True)  # the site draws the arm to scale
    turns = any(joint.is_revolute for joint in chain.joints)
    assert ("degrees" in text and "radians" in text) or not turns
    assert "$P$" in text and "$T_{i-1,i}" in text
    assert ("world frame" in text) == (not chain.base.is_world) or "is the world frame" in text


@few_families
@pytest.mark.parametrize("solution", [False, True])
def test_pages_texts_and_documents(problem: Problem, solution: bool) -> None:
    problem = replace(problem, parts=tuple(select_parts(problem)))
    page = show(problem, solution, "html")
    Page(page)  # its elements nest
    assert "<math" in page and "<svg" in page and "$" not in page
    for formula in re.findall(r"<math.*?</math>", page, re.DOTALL):
        ET.fromstring(formula)
    assert not re.search(r"""(?:src|href)=["']?https?:""", page)  # self-contained
    text = show(problem, solution, "text")
    assert "$" not in text and "\\" not in text and not re.search(r"\*\*(?!\d)", text)
    latex = show(problem, solution, "latex")
    assert latex.count(r"\begin{") == latex.count(r"\end{") and latex.count("{") == latex.count("}")
    for answer in [write_answer_code(problem, p) for p in problem.parts if p.kind in ("jacobian", "determinant")]:
        assert (max(answer.splitlines(), key=len) in text) == solution or answer in ("1", "-1")


@pytest.mark.integration
def test_latex_compiles(tmp_path: Path) -> None:
    require_program("pdflatex", LATEX, in_ci=False)
    (tmp_path / "x.tex").write_text(show(get_problem("planar-2r", 0), True, "latex"), encoding="utf-8")
    done = subprocess.run(["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "x.tex"], cwd=tmp_path)
    assert done.returncode == 0


@few_families
def test_json_is_the_contract(problem: Problem) -> None:
    problem = replace(problem, parts=tuple(select_parts(problem)))
    plain, full = make_problem_json(problem, False), make_problem_json(problem, True, {"method": "exact"})
    assert {"id", "family", "seed", "engine", "robot", "symbols", "parts"} <= set(plain)
    assert "certificate" not in plain and full["certificate"] == {"method": "exact"}
    assert not any("reference" in part or "solution" in part for part in plain["parts"])
    for part, given in zip(problem.parts, full["parts"], strict=True):
        assert {"name", "kind", "type", "shape", "prompt", "points", "needs", "reference"} <= set(given)
        if isinstance(part.answer, (Expression, Choice)):
            assert isinstance(given["reference"], str)
        elif part.shape is not None and part.shape[1] > 1:
            assert [len(row) for row in given["reference"]] == [part.shape[1]] * part.shape[0]
        else:
            assert all(isinstance(text, str) for text in given["reference"])


def test_markdown_subset() -> None:
    text = "## A $x_{1}$\n\nSome **bold** `code_1` and $a < b$.\n\n- one\n- two\n\n1. first\n\n"
    text += "| a | b |\n|:-:|:-:|\n| $1$ | 2 |\n"
    assert "<strong>bold</strong>" in to_html(text) and "<th" in to_html(text)
    assert r"\subsection" not in to_latex(text) and r"\section*{A $x_{1}$}" in to_latex(text)
    assert r"\texttt{code\_1}" in to_latex(text) and r"$1$ & 2 \\" in to_latex(text)
    assert "• one\n  • two" in to_text(text) and "A x₁" in to_text(text)


def test_a_dollar_in_code_begins_no_formula() -> None:
    shown = to_html("`$a` and $b$\n\n```yaml\nenv: ${{ one }}, ${{ two }}\n```\n\n$c$")
    assert shown.count("<math ") == 2 and "<code>$a</code>" in shown and "env: ${{ one }}, ${{ two }}" in shown


def test_conditions_are_listed_with_the_signs_that_they_have_in_the_determinant(family: str) -> None:
    chain = get_problem(family, 0).chain
    steps = SolutionSteps(chain)
    if steps.derivation.is_square:
        determinant = tex(steps.derivation.determinant, chain, steps.angles)
        sums = [condition for found in steps.singular_components for condition in found.conditions if condition.is_Add]
        assert not [each for each in sums if f"({tex(-each, chain, steps.angles)})" in determinant]


def test_what_an_earlier_part_has_found_is_not_derived_again() -> None:
    """A solution by itself shows the Jacobian and its determinant; behind the parts that ask for them it uses them."""
    asked = ("position", "jacobian", "determinant", "inverse-velocity", "singular-angles", "joint-torques")
    problem = generate(ProblemId("planar-2r", 1, asked, variation="chapter"))
    together = write_solutions(problem)
    for name in ("jacobian", "singular-angles", "joint-torques"):
        alone = write_solution(problem, problem[name])
        assert "found above" in together[name] and "found above" not in alone
        assert len(alone) > len(together[name])
    assert "J = " in write_solution(problem, problem["inverse-velocity"])
    assert "J = " not in together["inverse-velocity"]


def test_lines_break_between_equations_and_a_wide_table_moves() -> None:
    found = to_html(r"at $\theta_1 = -145^\circ, \theta_2 = 135^\circ, \theta_3 = 170^\circ$, in $(a, b, c)$")
    assert found.count("<math") == 4 and found.count("</math>, <math") == 2
    assert to_html(r"$d_1 = 0{,}55\,\text{m}; d_3 = 0{,}6\,\text{m}; a_2 = 1$").count("</math>; <math") == 2
    assert to_html("$x = 1, y = 2$").count("</math>, <math") == 1
    page = to_html_for_mathjax(r"With $a_1 = 1,\; a_2 = 2,\; P = (0, 1)$, $x = 1, y = 2$ and $a < b$.")
    assert r"\(a_1 = 1\), \(a_2 = 2\), \(P = (0, 1)\), \(x = 1\), \(y = 2\) and \(a &lt; b\)." in page
    page = to_html_for_mathjax("| a | b |\n|---|---|\n| 1 | 2 |\n")
    assert re.fullmatch(r'<div style="overflow-x: auto;[^>]*><table class=.*</table></div>\s*', page, re.DOTALL)


def test_no_line_ends_between_a_formula_and_the_signs_that_belong_to_it() -> None:
    page = to_html("Of $O_0$. And ($a$), $b$ too; $x = 1, y = 2, z = 3$.")
    held = re.findall(r'<span class="whole">(.*?)</span>', page)
    assert [re.sub(r"<.*?>", "", each) for each in held] == ["O0.", "(a),"]
    assert to_html("Of $O_0$.", lambda latex, _: latex) == "<p>Of O_0.</p>\n"


def test_an_option_that_says_itself_is_named_by_its_letter_alone() -> None:
    problem = generate(ProblemId("planar-2r", 1, ("true-or-false",)))
    (part,) = problem.parts
    assert isinstance(part.answer, Choice)
    assert write_short_answer(problem, part).strip() == f"**{part.answer.typed_text}**"
