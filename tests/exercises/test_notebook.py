"""Notebooks: valid, the same bytes each time, run from top to bottom, and hold nothing that gives answers away."""

import contextlib
import copy
import io
import json
import re
from dataclasses import replace
from functools import cache
from typing import Any

import nbformat
import pytest
import sympy as sp
from markdown_it import MarkdownIt

from exercises.answers import Choice, ConditionSet, Direction, Expression, Matrix, Number
from exercises.arm.chain import CONVENTIONS
from exercises.generation import generate
from exercises.notebook import notebook_text, solution_notebook, student_notebook
from exercises.problem import Part, Problem, variable
from exercises.self_check import check_cell
from exercises.writing.statement import answer_code, statement
from tests.support.problems import drawn, parts_in_turn

TITLE = "Velocity kinematics"
Slotted = list[tuple[str, Problem]]


@cache
def _problems(family: str) -> Slotted:
    """Return the first problem of a family and another one, with their parts in turn and those that are checked."""
    beside = "cartesian" if family == "pan-tilt" else "pan-tilt"
    return [("p1", _in_turn(drawn(family, 0))), ("p2", _in_turn(drawn(beside, 0)))]


def _in_turn(problem: Problem) -> Problem:
    names = {"position", "jacobian", *(part.name for part in parts_in_turn(problem))}
    return replace(problem, parts=tuple(part for part in problem.parts if part.name in names))


@pytest.fixture
def problems(family: str) -> Slotted:
    """The first problem of a family and another one, in one notebook."""
    return _problems(family)


@cache
def _student(family: str) -> Any:
    return student_notebook(TITLE, "hw1", "s001", _problems(family))


@cache
def _staff(family: str) -> Any:
    return solution_notebook(TITLE, "hw1", "s001", _problems(family))


@pytest.fixture
def student(family: str) -> Any:
    return copy.deepcopy(_student(family))


@pytest.fixture
def staff(family: str) -> Any:
    return copy.deepcopy(_staff(family))


def _parts(problems: Slotted) -> list[tuple[str, Part]]:
    return [(slot, part) for slot, problem in problems for part in problem.parts]


def _run(notebook: Any) -> tuple[dict[str, Any], str]:
    space: dict[str, Any] = {}
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        for cell in notebook.cells:
            if cell.cell_type == "code":
                exec(cell.source, space)
    return space, printed.getvalue()


@cache
def _staffs_run(family: str) -> tuple[dict[str, Any], str]:
    return _run(_staff(family))


@pytest.fixture
def staffs_run(family: str) -> tuple[dict[str, Any], str]:
    return _staffs_run(family)


@pytest.mark.parametrize("make", [student_notebook, solution_notebook])
def test_same_problems_same_bytes(make: Any, family: str) -> None:
    before = (_student if make is student_notebook else _staff)(family)
    first, second = notebook_text(before), notebook_text(make(TITLE, "hw1", "s001", _problems(family)))
    assert first == second and first.endswith("}\n")
    nbformat.validate(json.loads(first))
    assert json.loads(first)["nbformat_minor"] >= 5
    ids = [cell["id"] for cell in json.loads(first)["cells"]]
    assert len(set(ids)) == len(ids) and f"p1-{_problems(family)[0][1].parts[0].name}" in ids


def test_students_notebook_says_what_it_is_and_holds_no_answer_and_no_seed(student: Any, problems: Slotted) -> None:
    own, text = student.metadata["qdot"], notebook_text(student)
    assert own["kind"] == "student" and own["joints"] == {slot: [q.name for q in p.chain.q] for slot, p in problems}
    assert "seed" not in text and not any(str(problem.id) in text for _, problem in problems)
    sources = "\n".join(cell.source for cell in student.cells)
    given = dict(problems)
    for slot, part in _parts(problems):
        start = f"{variable(slot, part.name)} = "
        answers = (part.answer.code(), answer_code(given[slot], part), answer_code(given[slot], part, len(start)))
        if min(map(len, answers)) > 8:  # a determinant of -1 is no telling text
            assert not any(answer in sources for answer in answers), start
        assert start + part.answer.placeholder(len(start)) in sources
    for slot, _ in problems:
        cell = next(cell for cell in student.cells if cell.id == f"{slot}-statement")
        assert re.search(r'<img alt="[^"]{80,}" src="data:image/svg\+xml;base64,', cell.source)


def test_untouched_notebook_runs_and_self_check_waits(student: Any, problems: Slotted) -> None:
    space, printed = _run(student)
    assert set(re.findall(r"\? (.+)", printed)) == {"Not yet: an answer is still blank."}
    for slot, part in _parts(problems):
        value = space[variable(slot, part.name)]
        if part.shape is not None:
            assert sp.Matrix([value]).shape == part.shape


def test_staffs_answers_are_the_references_and_pass_the_notebooks_own_checks(
    staffs_run: tuple[dict[str, Any], str], problems: Slotted
) -> None:
    for slot, part in _parts(problems):
        name = variable(slot, part.name)
        assert _is_the_reference(staffs_run[0][name], part), name
    checks = "".join(check_cell(slot, problem, part.name) for slot, problem in problems for part in problem.parts)
    assert staffs_run[1].count("? Yes;") == checks.count("?") == len(staffs_run[1].splitlines()) > 0


def _is_the_reference(value: Any, part: Part) -> bool:
    answer = part.answer
    if isinstance(answer, (Expression, Matrix, Direction)):
        ours, theirs = sp.Matrix([value]), sp.Matrix([answer.reference])
        at = {symbol: sp.Float(0.4 + 0.19 * i) for i, symbol in enumerate(sorted(theirs.free_symbols, key=str))}
        there, due = ours.xreplace(at), theirs.xreplace(at)
        near = all(abs(a - b) < 1e-9 * max(1, abs(b)) for a, b in zip(there, due, strict=True))
        return ours.shape == theirs.shape and near
    if isinstance(answer, Number):
        numbers = zip(sp.Matrix([value]), answer.reference, strict=True)
        return all(abs(a - b) < 1e-9 for a, b in numbers)
    if isinstance(answer, Choice):
        return bool(value == answer.letter)
    assert isinstance(answer, ConditionSet)
    conditions = [sp.sympify(condition) for condition in value]
    return len(conditions) == len(answer.pieces()) and not any(condition in (True, False) for condition in conditions)


def test_answer_cells_are_marked_and_code_fits_the_cells(student: Any, staff: Any, problems: Slotted) -> None:
    for notebook in (student, staff):
        marked = {c.metadata["qdot"]["part"]: c for c in notebook.cells if "qdot" in c.metadata}
        assert list(marked) == [f"{slot}.{part.name}" for slot, part in _parts(problems)]
        assert all(" = " in cell.source for cell in marked.values())
        assert max(len(line) for c in notebook.cells if c.cell_type == "code" for line in c.source.splitlines()) <= 88
    cells = [cell.id for cell in staff.cells]  # a solution is read before it is typed
    for solution in (name for name in cells if name.endswith("-solution")):
        assert cells[cells.index(solution) + 1] == solution.removesuffix("-solution")


def test_long_answers_are_broken_before_signs() -> None:
    a1, angle = sp.Symbol("a1"), sp.Add(*sp.symbols("theta1:4"), sp.pi / 6)
    entry = a1 * sp.cos(angle) + sp.Rational(47, 100) * sp.sin(angle) + sp.Rational(3, 500)
    column = Matrix(sp.Matrix([entry, 0]))
    lines = column.code(20).split("\n")
    assert len(lines) == 5 and lines[2].lstrip().startswith("+ ") and max(map(len, lines)) <= 88
    assert column.placeholder() == "Matrix([blank, blank])"
    square = Matrix(sp.Matrix([[a1, 0], [1, 2]]))
    assert square.code() == "Matrix([[a1, 0], [1, 2]])"
    assert square.placeholder() == "Matrix([[blank, blank], [blank, blank]])"


def test_one_problem_twice_has_its_own_names() -> None:
    (_, problem), _ = _problems("planar-2r")
    problem = replace(problem, parts=(problem["position"], problem["jacobian"]))
    notebook = student_notebook("t", "k", "s", [("p1", problem), ("p2", problem)])
    assert {"p1_jacobian", "p2_jacobian"} <= set(_run(notebook)[0])


@pytest.mark.integration
def test_notebook_runs_in_jupyter() -> None:
    nbclient = pytest.importorskip("nbclient")
    one = solution_notebook("t", "k", "s", _problems("planar-2r")[:1])
    done = nbclient.NotebookClient(one, timeout=100, kernel_name="python3").execute()
    outputs = [out.get("text", "") for cell in done.cells if cell.cell_type == "code" for out in cell.outputs]
    assert any("Is your Jacobian the derivative of your position? Yes" in text for text in outputs)


def test_an_arm_told_by_its_axes_has_no_names_of_a_table() -> None:
    """Neither in the words, nor among what an answer may hold: a2 of the table that is worked with is told nowhere."""
    told = {name: generate(f"planar-2r/1@{name}", ["position"]) for name in CONVENTIONS}
    assert [name for name, problem in told.items() if "a2" in problem.symbols()] == ["dh", "modified-dh"]
    for names in (("screws",), ("screws", "dh"), ("dh", "modified-dh")):
        slotted = [(f"p{number}", told[name]) for number, name in enumerate(names, 1)]
        opening = student_notebook("T", "hw", "s1", slotted).cells[0].source
        assert ("usual name (`a1`, `d1`, …)" in opening) == (names != ("screws",))
    assert "the table" not in statement(told["screws"], "").partition("**Joint variables:**")[2]


def test_staff_reads_what_students_read_whether_it_is_written_anew_or_not() -> None:
    ((_, problem), _), of = _problems("planar-2r"), (TITLE, "hw1", "s001")
    short = [("p1", replace(problem, parts=(problem["position"], problem["jacobian"])))]
    handed_out = student_notebook(*of, short, True)
    assert notebook_text(solution_notebook(*of, short, True, handed_out=handed_out)) == notebook_text(
        solution_notebook(*of, short, True)
    )
    asked = next(cell for cell in handed_out.cells if cell.id.endswith("-question"))
    asked.source = "written once"
    assert "written once" in [cell.source for cell in solution_notebook(*of, short, True, handed_out=handed_out).cells]


@pytest.mark.parametrize("title", ["Arms & <signs>", "a_1 * [b] $c$ `d` \\e &amp; _f_ *g* 6.1"])
def test_a_title_is_shown_as_it_is(title: str) -> None:
    cell = student_notebook(title, "hw1", "s001", _problems("planar-2r")).cells[0]
    heading = MarkdownIt().parse(cell.source)[1]
    assert "".join(token.content for token in heading.children or ()) == title
    assert {token.type for token in heading.children or ()} <= {"text", "text_special"}
