"""Notebooks: valid, the same bytes each time, run from top to bottom, and hold nothing that gives answers away."""

import contextlib
import io
import json
import re
from typing import Any

import nbformat
import pytest
import sympy as sp

from exercises.families import FAMILIES
from exercises.generate import generate
from exercises.notebook import notebook_text, solution_notebook, student_notebook
from exercises.problem import Choice, ConditionSet, Expression, Matrix, Number, Part, Problem, ProblemId, variable
from exercises.writing.answer_code import answer_code, placeholder_code

PROBLEMS = [(f"p{i}", generate(ProblemId(family, 40 + i))) for i, family in enumerate(FAMILIES, 1)]
SLOTTED = [(slot, problem, part) for slot, problem in PROBLEMS for part in problem.parts]
ARGUMENTS = ("Velocity kinematics", "hw1", "s001", PROBLEMS)
STUDENT, STAFF = student_notebook(*ARGUMENTS), solution_notebook(*ARGUMENTS)


def _name(value: object) -> str:
    return value.name if isinstance(value, Part) else value if isinstance(value, str) else ""


def _run(notebook: Any, until: str | None = None) -> tuple[dict[str, Any], str]:
    space: dict[str, Any] = {}
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        for cell in notebook.cells:
            if cell.cell_type == "code":
                exec(cell.source, space)
    return space, printed.getvalue()


SPACE, PRINTED = _run(STAFF)


@pytest.mark.parametrize("make", [student_notebook, solution_notebook])
def test_same_problems_same_bytes(make: Any) -> None:
    first, second = (notebook_text(make(*ARGUMENTS)) for _ in range(2))
    assert first == second and first.endswith("}\n")
    nbformat.validate(json.loads(first))
    assert json.loads(first)["nbformat_minor"] >= 5
    ids = [cell["id"] for cell in json.loads(first)["cells"]]
    assert len(set(ids)) == len(ids) and "p1-jacobian" in ids


def test_metadata_says_what_it_is_and_no_seed() -> None:
    own = STUDENT.metadata["qdot"]
    assert own["kind"] == "student" and own["problems"] == {slot: p.id.family for slot, p in PROBLEMS}
    assert "seed" not in notebook_text(STUDENT) and not re.search(r"[a-z0-9]-\d?[rp]+/\d", notebook_text(STUDENT))


@pytest.mark.parametrize(("slot", "problem", "part"), SLOTTED, ids=_name)
def test_students_notebook_holds_no_answer(slot: str, problem: Problem, part: Part) -> None:
    sources = "\n".join(cell.source for cell in STUDENT.cells)
    start = f"{variable(slot, part.name)} = "
    if not isinstance(part.answer, Choice):
        assert answer_code(part) not in sources and answer_code(part, len(start)) not in sources
    assert start + placeholder_code(part, len(start)) in sources


def test_untouched_notebook_runs_and_self_check_waits() -> None:
    space, printed = _run(STUDENT)
    assert "Answer both" in printed
    for slot, _, part in SLOTTED:
        value = space[variable(slot, part.name)]
        if part.shape is not None:
            assert sp.Matrix(value).shape == part.shape


def test_every_answer_cell_is_marked() -> None:
    for notebook in (STUDENT, STAFF):
        marked = {c.metadata["qdot"]["part"]: c for c in notebook.cells if "qdot" in c.metadata}
        assert list(marked) == [f"{slot}.{part.name}" for slot, _, part in SLOTTED]
        assert all(cell.source.count(" = ") >= 1 for cell in marked.values())


@pytest.mark.parametrize(("slot", "problem", "part"), SLOTTED, ids=_name)
def test_staffs_answers_are_the_references(slot: str, problem: Problem, part: Part) -> None:
    value, answer = SPACE[variable(slot, part.name)], part.answer
    if isinstance(answer, (Expression, Matrix)):
        ours, theirs = sp.Matrix([value]), sp.Matrix([answer.reference])
        assert not any(entry.atoms(sp.Float) for entry in ours)
        at = {symbol: sp.Float(0.4 + 0.19 * i) for i, symbol in enumerate(sorted(theirs.free_symbols, key=str))}
        assert ours.shape == theirs.shape and max(map(abs, (ours - theirs).xreplace(at))) < 1e-9
    elif isinstance(answer, Number):
        assert all(abs(a - b) < 1e-9 for a, b in zip(value, answer.reference, strict=True))
    elif isinstance(answer, Choice):
        assert value == answer.letter
    else:
        assert isinstance(answer, ConditionSet)
        assert len(value) == len(answer.pieces())
        assert not any(sp.sympify(condition).atoms(sp.Float) for condition in value)
        assert not any(condition in (True, False) for condition in value)


def test_code_fits_the_cells() -> None:
    for notebook in (STUDENT, STAFF):
        lines = [line for c in notebook.cells if c.cell_type == "code" for line in c.source.splitlines()]
        assert max(map(len, lines)) <= 88


def test_long_answers_are_broken_before_signs() -> None:
    a1, angle = sp.Symbol("a1"), sp.Symbol("theta1") + sp.Symbol("theta2") + sp.pi / 6
    entry = a1 * sp.cos(angle) + sp.Rational(47, 100) * sp.sin(angle) + sp.Rational(3, 500)
    column = Part("x", "position", Matrix(sp.Matrix([entry, 0])))
    assert answer_code(column, 20) == (
        "Matrix([\n    a1*cos(theta1 + theta2 + pi/6) + 47*sin(theta1 + theta2 + pi/6)/100\n"
        "        + Rational(3, 500),\n    0,\n])"
    )
    assert placeholder_code(column) == "Matrix([blank, blank])"
    square = Part("x", "jacobian", Matrix(sp.Matrix([[a1, 0], [1, 2]])))
    assert answer_code(square) == "Matrix([[a1, 0], [1, 2]])"
    assert placeholder_code(square) == "Matrix([[blank, blank], [blank, blank]])"


def test_self_check_of_the_reference_agrees() -> None:
    assert PRINTED.count("is the derivative of your position") == len(PROBLEMS)


def test_self_check_finds_what_is_wrong() -> None:
    space, _ = _run(STUDENT)
    theta1, theta2, a1 = (sp.Symbol(name) for name in ("theta1", "theta2", "a1"))
    position = sp.Matrix([a1 * sp.cos(theta1 + theta2), a1 * sp.sin(theta1)])
    right = position.jacobian([theta1, theta2])
    assert "is the derivative" in _said(space, position, right, [theta1, theta2])
    wrong = right.copy()
    wrong[1, 0] = -wrong[1, 0]
    assert "[(2, 1)]" in _said(space, position, wrong, [theta1, theta2])
    assert "should be 2 x 2, and is 2 x 1" in _said(space, position, right[:, 0], [theta1, theta2])
    assert "Not the derivative" in _said(space, position.subs(a1, 0.5), right, [theta1, theta2])
    assert "is the derivative" in _said(space, position.subs(a1, 0.5), right, [theta1, theta2], {a1: 0.5})


def _said(space: dict[str, Any], *arguments: Any) -> str:
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        space["self_check"](*arguments)
    return printed.getvalue()


def test_figures_are_inside_with_words_for_those_who_do_not_see_them() -> None:
    for slot, _ in PROBLEMS:
        cell = next(c for c in STUDENT.cells if c.id == f"{slot}-statement")
        assert re.search(r'<img alt="[^"]{80,}" src="data:image/svg\+xml;base64,', cell.source)


def test_one_problem_twice_has_its_own_names() -> None:
    slot, problem = PROBLEMS[0]
    notebook = student_notebook("t", "k", "s", [(slot, problem), ("p2", problem)])
    assert "p2_jacobian" in _run(notebook)[0]


def test_notebook_runs_in_jupyter() -> None:
    nbclient = pytest.importorskip("nbclient")
    one = solution_notebook("t", "k", "s", PROBLEMS[:1])
    done = nbclient.NotebookClient(one, timeout=100, kernel_name="python3").execute()
    outputs = [out.get("text", "") for cell in done.cells if cell.cell_type == "code" for out in cell.outputs]
    assert any("is the derivative of your position" in text for text in outputs)
