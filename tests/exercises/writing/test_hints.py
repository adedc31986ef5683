"""Hints: three for every question of every arm, readable, about this arm, and none that holds an answer."""

import json
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
import sympy as sp
from typer.testing import CliRunner

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.assignment.release import ReleaseContext, init_assignment, release_notebooks_of_student
from qdot.exercises.common.errors import QdotError
from qdot.exercises.notebook.problem_formats import show
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.reference_answers import Choice, ConditionSet, Direction, Expression, Matrix, Number
from qdot.exercises.singularities.singular_set import find_singular_set
from qdot.exercises.writing.angles import AngleNames
from qdot.exercises.writing.hint_context import Entry, HintContext
from qdot.exercises.writing.latex import tex, tex_angle
from qdot.exercises.writing.problem_texts import write_hints, write_prompt
from qdot.exercises.writing.solution_steps import SolutionSteps
from qdot.grader.cli.main import app
from qdot.grader.grading.certify import CERTIFIER
from tests.support.problems import ask_question, get_problem


def test_every_part_has_three_hints_that_read_well_and_keep_the_answers(problem: Problem) -> None:
    given = {part.name: write_hints(problem, part) for part in problem.parts}
    for part in problem.parts:
        assert len(set(given[part.name])) == 3, part.name
        for hint in given[part.name]:
            _reads_well(hint, part.name)
            for name in set(re.findall(r"\\varphi'*_\{\d+\}", hint)):
                assert re.search(rf"^Let .*\${re.escape(name)} = ", hint), part.name
        _keeps(problem, part, "\n".join(given[part.name]))
    texts = {name: "\n".join(three) for name, three in given.items()}
    for part in problem.parts:
        _is_nowhere_whole(problem.chain, part, texts[part.name], "\n".join(texts.values()))


def _reads_well(hint: str, name: str) -> None:
    assert 40 < len(hint.strip()) < 2200, f"{name}: {hint}"
    assert not re.search(r"\bNone\b|Undefined|\{\{|\{%|\[\]|\(\)|\n\n\n|\.\.|,,|\$\$\$", hint), f"{name}: {hint}"
    plain = re.sub(r"\$\$.+?\$\$|\$[^$]+\$", "F", hint, flags=re.DOTALL)
    assert not re.search(
        r"  | [.,;:]|(?<!other )(?<!revolute )(?<!prismatic )\bjoints (?:and|,)|\bjoint ,|^\W*$|[a-z]\. [a-z]", plain
    ), f"{name}: {plain}"
    assert all(line[0].isupper() or line[0] in "(" or formula_led for line, formula_led in _starts(plain)), plain
    assert hint.count("$$") % 2 == 0 and hint.replace("$$", "").count("$") % 2 == 0
    for formula in re.findall(r"\$\$(.+?)\$\$|\$([^$]+)\$", hint, re.DOTALL):
        latex = "".join(formula)
        assert latex.strip() and latex.count("{") == latex.count("}"), f"{name}: {latex}"
        assert latex.count(r"\begin{") == latex.count(r"\end{"), f"{name}: {latex}"
    outside = re.sub(r"\$[^$]+\$", "", hint.replace("$$", "$"))
    assert not re.search(r"[\\_^{}]", outside), f"{name}: {outside}"


def _starts(plain: str) -> list[tuple[str, bool]]:
    """Return the paragraphs of a hint; those after a formula may go on in small letters."""
    paragraphs = [text for text in plain.split("\n\n") if text.strip()]
    return [(text, i > 0 and paragraphs[i - 1] == "F") for i, text in enumerate(paragraphs)]


def _keeps(problem: Problem, part: Part, text: str) -> None:
    answer, where = part.answer, f"{problem.id} {part.name}: {text}"
    if isinstance(answer, Choice):
        assert not re.search(r"\*\*[A-H]\*\*|\boption [A-H]\b", text), where
        assert not any(option in text for option in answer.options), where
    if isinstance(answer, ConditionSet):
        _solves_nothing(problem.chain, answer, text)
    if isinstance(answer, (Number, Direction)) and not answer.reference.free_symbols:
        _has_no_digits(answer.reference, text, write_prompt(problem, part), where)
    if isinstance(answer, Direction) and answer.reference.free_symbols:
        assert tex(answer.reference, problem.chain, _angles(problem.chain)) not in text, where
    if isinstance(answer, Matrix):
        _shows_one_column_at_most(problem.chain, answer.reference, text, where)


def _solves_nothing(chain: Chain, answer: ConditionSet, text: str) -> None:
    for component in answer.components:
        for condition in component.conditions:
            assert f"{tex(condition, chain)} = 0" not in text and f"{tex(-condition, chain)} = 0" not in text
        for joint, values in component.solutions or ():
            for value in values:
                assert f"{tex(joint, chain)} = {tex(value, chain)}" not in text
                assert f"{tex(joint, chain)} = {tex_angle(value)}" not in text


def _has_no_digits(reference: sp.Matrix, text: str, given: str, where: str) -> None:
    if all(value.is_Integer for value in reference):  # a rank or a size is a number that stands everywhere
        sizes = set(re.findall(r"\d × \d", text)) - set(re.findall(r"\d × \d", given))
        assert not sizes and not re.search(r"rank (?:is )?\W*\d", text), where
        return
    shown = {_rounded(number) for number in re.findall(r"\d+\.\d+", text)}
    known = {_rounded(number) for number in re.findall(r"\d+\.?\d*", given)}
    assert not {_rounded(value) for value in reference} & (shown - known - {"0", "1"}), where


def _rounded(number: object) -> str:
    return f"{abs(float(number)):.3g}"  # type: ignore[arg-type]


def _cells(text: str) -> set[str]:
    """Return what is shown by itself: entries of displayed matrices, sides of equations, entries told."""
    formulas = re.findall(r"\$\$(.+?)\$\$| (?:is|becomes) \$([^$]+)\$[;.]", text, re.DOTALL)
    cells = re.split(r"&|\\\\|\\begin\{bmatrix\}|\\end\{bmatrix\}|=|\n", "\n".join("".join(f) for f in formulas))
    return {cell.strip() for cell in cells}


@cache
def _angles(chain: Chain) -> AngleNames:
    return SolutionSteps(chain).angles


@cache
def _printed(chain: Chain, entry: sp.Expr) -> set[str]:
    return {tex(sign * entry, chain, _angles(chain)) for sign in (1, -1)}


def _shown(chain: Chain, entry: sp.Expr, cells: set[str]) -> bool:
    return bool(cells) and not cells.isdisjoint(_printed(chain, entry))


def _shows_one_column_at_most(chain: Chain, matrix: sp.Matrix, text: str, where: str) -> None:
    cells = _cells(text)
    columns = [{_unsigned(entry) for entry in matrix.col(j) if entry.free_symbols} for j in range(matrix.cols)]
    every = set().union(*columns)
    seen = {entry for entry in every if _shown(chain, entry, cells)}
    if matrix.cols == 1:
        assert len(seen) < 2 or len(seen) < len(every) - 1, f"{where}\n{seen}"
    else:
        assert not seen or any(seen <= column for column in columns) or len(every - seen) > 1, f"{where}\n{seen}"
    assert not every or seen != every, f"{where}\n{seen}"


def _unsigned(entry: sp.Expr) -> sp.Expr:
    return -entry if entry.could_extract_minus_sign() else entry


def _is_nowhere_whole(chain: Chain, part: Part, own: str, everything: str) -> None:
    """Hold an answer against its own hints and against those of all parts: they are handed out together."""
    if isinstance(part.answer, Matrix):
        assert tex(part.answer.reference, chain, _angles(chain)) not in everything, part.name
    elif isinstance(part.answer, Expression) and part.answer.reference.free_symbols:
        assert not _shown(chain, part.answer.reference, _cells(own)), part.name
        assert rf"\det J = {tex(part.answer.reference, chain, _angles(chain))}" not in everything, part.name


ONE_JOINT = (
    Chain("crank", (Joint("R", "theta1", 0, "a1", 0),), ("vx",)),
    Chain("swing", (Joint("R", "theta1", 0, "a1", 0),), ("vx", "vy")),
    Chain("slide", (Joint("P", 0, "d1", 0, 0),), ("vz",)),
)


@pytest.mark.parametrize("chain", ONE_JOINT, ids=lambda chain: chain.name)
def test_arms_of_one_joint_are_given_a_method_where_a_step_would_be_the_answer(chain: Chain) -> None:
    names = [name for name, question in QUESTIONS.items() if question.find_obstacle(chain) is None]
    assert len(names) > 5
    for name in names:
        problem = ask_question(name, chain)
        three, (part,) = write_hints(problem, problem.parts[0]), problem.parts
        for hint in three:
            _reads_well(hint, name)
        _keeps(problem, part, "\n".join(three))
        _is_nowhere_whole(chain, part, "\n".join(three), "\n".join(three))


def test_what_a_hint_shows_is_true(problem: Problem) -> None:
    chain, steps = problem.chain, SolutionSteps(problem.chain)
    values = {symbol: sp.Float(0.37 + 0.21 * i, 30) for i, symbol in enumerate((*chain.q, *chain.parameters))}
    shown = []  # pairs that are equal
    if len(chain.task) == chain.n and (short := steps.jacobian_at_joint_1) is not None:
        shown.append((short, steps.derivation.jacobian.xreplace({chain.q[0]: steps.joint_1_value})))
        shown.append((sp.Matrix([short.xreplace(values).det()]), sp.Matrix([steps.derivation.determinant])))
    if last := steps.last_moving_vector:
        shown.append((steps.origins[last[0]] + last[1], steps.derivation.position))
    for component in find_singular_set(chain) or ():
        if component.solutions and chain.n <= 3:
            place = [(joint, found[0]) for joint, found in component.solutions]
            if (lost := steps.find_lost_direction(tuple(place))) is not None:
                shown.append((lost[0].jacobian, steps.derivation.jacobian.xreplace(dict(place))))
    for matrix, other in shown:
        assert all(abs(entry) < 1e-12 for entry in (matrix - other).xreplace(values).evalf(20))


def test_of_a_result_one_column_or_entry_is_shown_if_others_are_left() -> None:
    x, y = sp.symbols("x y")
    assert HintContext.find_column(sp.Matrix([[x, y], [1, 0]])) == 2
    assert HintContext.find_column(sp.Matrix([[x, 1], [y, 0]])) is None  # nothing but constants would be left
    assert HintContext.find_column(sp.Matrix([[x, -x]])) is None
    assert HintContext.find_entry(sp.Matrix([1, -y, x])) == Entry(2, 1, -y)
    assert HintContext.find_entry(sp.Matrix([x, -x, 3])) is None
    minors = [("columns 1, 2", sp.S.Zero), ("columns 1, 3", x), ("columns 2, 3", y)]
    assert HintContext.find_minor(minors) == ("columns 1, 3", x)
    assert HintContext.find_minor([("columns 1, 2", x), ("columns 1, 3", -x)]) is None
    assert HintContext.reveals_entry(sp.Matrix([x, 0.5012]), sp.Float(-0.5))
    assert HintContext.reveals_entry(sp.Matrix([[y, -x]]), x)
    assert not HintContext.reveals_entry(sp.Matrix([x, 1, 0.51]), sp.Matrix([0.5, 1, y]))


@pytest.mark.xdist_group("planar-2r")
@pytest.mark.parametrize("format", ["text", "latex", "html", "ipynb", "json"])
def test_show_has_hints_when_they_are_asked_for(format: str) -> None:
    problem = get_problem("planar-2r", 0)
    problem = replace(problem, parts=problem.parts[:6])
    without, shown = show(problem, True, format), show(problem, True, format, hinted=True)
    if format == "json":  # always has them
        for part, *given in zip(problem.parts, *(json.loads(text)["parts"] for text in (without, shown)), strict=True):
            assert [one["hints"] for one in given] == [list(write_hints(problem, part))] * 2
        return
    assert "Hint 1" not in without and [shown.count(f"Hint {i}") for i in (1, 2, 3)] == [6] * 3
    assert shown.count("<details") - without.count("<details") == (18 if format in ("html", "ipynb") else 0)


def test_the_program_shows_hints() -> None:
    asked_for = ["show", "planar-2r/7", "--questions", "jacobian", "--hints"]
    result = CliRunner().invoke(app, asked_for)
    assert result.exit_code == 0
    assert re.search(r"Hint 1\. .*Hint 2\. .*Hint 3\. ", result.output, re.DOTALL)


TOML = 'title = "T"\nkey = "hw"\n\n[[problem]]\nfamily = "planar-2r"\nquestions = ["position"]\n'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    init_assignment(tmp_path / "hw", "T", "hw")
    path = tmp_path / "hw" / "assignment.toml"
    assert "\n# hints = true " in path.read_text(), "a new assignment says how to have hints"
    path.write_text(TOML)
    return tmp_path / "hw"


def test_hints_make_another_edition_of_the_same_problems(folder: Path) -> None:
    plain = load_assignment(folder)
    assert not plain.hints
    assert release_notebooks_of_student(ReleaseContext(plain, CERTIFIER), "s001").outcome == "written"
    (folder / "assignment.toml").write_text("hints = false\n" + TOML)
    assert load_assignment(folder).notebook_digest == plain.notebook_digest
    (folder / "assignment.toml").write_text("hints = true\n" + TOML)
    hinted = load_assignment(folder)
    assert hinted.problems_digest == plain.problems_digest and hinted.notebook_digest != plain.notebook_digest
    for outcome in ("rewritten", "kept"):
        assert release_notebooks_of_student(ReleaseContext(hinted, CERTIFIER), "s001").outcome == outcome
    for kind in ("released", "solutions"):
        assert (folder / kind / "s001" / "hw.ipynb").read_text().count("<summary>Hint") == 3
    for wrong, place in (('hints = "yes"\n' + TOML, 'line 1: hints = "yes"'), (TOML + "hints = true\n", "line 7: ")):
        (folder / "assignment.toml").write_text(wrong)
        with pytest.raises(QdotError, match=place):
            load_assignment(folder)
