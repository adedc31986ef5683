"""Notebooks: valid, the same bytes each time, run from top to bottom, give nothing away, check their own answers."""

import contextlib
import copy
import io
import json
import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from itertools import product
from typing import Any

import nbformat
import numpy as np
import pytest
import sympy as sp
from markdown_it import MarkdownIt

from qdot.exercises.arm.chain import CONVENTIONS, TWIST_ORDERS, Chain, Joint, Point
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.generation import generate
from qdot.exercises.notebook.notebook import (
    NotebookContent,
    make_solution_notebook,
    make_student_notebook,
    write_notebook,
)
from qdot.exercises.notebook.self_check import RELATIONS, _list_checks, write_self_check_cell
from qdot.exercises.problem.problem import Part, Problem, name_answer_variable
from qdot.exercises.reference_answers import Expression, Matrix
from qdot.exercises.writing.problem_texts import write_answer_code, write_statement
from tests.support import read_cases
from tests.support.problems import get_problem, select_parts
from tests.support.suites import FEW, SHAPES, few_families, select_for_suite

pytestmark = few_families  # notebooks are built of any problem in the same way
TITLE = "Velocity kinematics"
Slotted = list[tuple[str, Problem]]


@cache
def _problems(family: str) -> Slotted:
    """Return the first problem of a family and another one, with their parts in turn and those that are checked."""
    beside = "cartesian" if family == "pan-tilt" else "pan-tilt"
    return [("p1", _in_turn(get_problem(family, 0))), ("p2", _in_turn(get_problem(beside, 0)))]


def _in_turn(problem: Problem) -> Problem:
    names = {"position", "jacobian", *(part.name for part in select_parts(problem))}
    return replace(problem, parts=tuple(part for part in problem.parts if part.name in names))


@pytest.fixture
def problems(family: str) -> Slotted:
    return _problems(family)


@cache
def _student(family: str) -> Any:
    return make_student_notebook(NotebookContent(TITLE, "hw1", "s001", _problems(family)))


@cache
def _staff(family: str) -> Any:
    return make_solution_notebook(NotebookContent(TITLE, "hw1", "s001", _problems(family)))


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


@pytest.mark.parametrize("make", [make_student_notebook, make_solution_notebook])
def test_same_problems_same_bytes(make: Any, family: str) -> None:
    before = (_student if make is make_student_notebook else _staff)(family)
    first = write_notebook(before)
    second = write_notebook(make(NotebookContent(TITLE, "hw1", "s001", _problems(family))))
    assert first == second and first.endswith("}\n")
    nbformat.validate(json.loads(first))
    assert json.loads(first)["nbformat_minor"] >= 5
    ids = [cell["id"] for cell in json.loads(first)["cells"]]
    assert len(set(ids)) == len(ids) and f"p1-{_problems(family)[0][1].parts[0].name}" in ids


def test_students_notebook_says_what_it_is_and_holds_no_answer_and_no_seed(student: Any, problems: Slotted) -> None:
    own, text = student.metadata["qdot"], write_notebook(student)
    assert own["kind"] == "student" and own["joints"] == {slot: [q.name for q in p.chain.q] for slot, p in problems}
    assert "seed" not in text and not any(str(problem.id) in text for _, problem in problems)
    sources = "\n".join(cell.source for cell in student.cells)
    given = dict(problems)
    for slot, part in _parts(problems):
        start = f"{name_answer_variable(slot, part.name)} = "
        answers = [write_answer_code(given[slot], part, indent) for indent in (0, len(start))]
        answers.append(part.answer.write_code())
        if min(map(len, answers)) > 8:  # a determinant of -1 is no telling text
            assert not any(answer in sources for answer in answers), start
        assert start + part.answer.write_placeholder(len(start)) in sources
    for slot, _ in problems:
        cell = next(cell for cell in student.cells if cell.id == f"{slot}-statement")
        assert re.search(r'<img alt="[^"]{80,}" src="data:image/svg\+xml;base64,', cell.source)


def test_untouched_notebook_runs_and_self_check_waits(student: Any, problems: Slotted) -> None:
    space, printed = _run(student)
    assert set(re.findall(r"\? (.+)", printed)) == {"Not yet: an answer is still blank."}
    checked_numbers = set(re.findall(r"^(\d+\.\d+) ", printed, re.MULTILINE))
    unchecked_numbers = set(re.findall(r"\d+\.\d+", printed.partition("Without a check, but graded:")[2]))
    numbers = {f"{n}.{i}" for n, (_, p) in enumerate(problems, 1) for i in range(1, len(p.parts) + 1)}
    assert checked_numbers <= numbers and unchecked_numbers <= numbers - checked_numbers
    for slot, part in _parts(problems):
        value = space[name_answer_variable(slot, part.name)]
        if part.shape is not None:
            assert sp.Matrix([value]).shape == part.shape


def test_staffs_answers_are_the_references(staff: Any, family: str, problems: Slotted) -> None:
    """test_code_means_the_reference shows that this code means the reference, and full marks that the grader agrees."""
    sources, (_, printed), given = [cell.source for cell in staff.cells], _run(staff), dict(problems)
    for slot, part in _parts(problems):
        start = f"{name_answer_variable(slot, part.name)} = "
        assert start + write_answer_code(given[slot], part, len(start)) in sources
    count = len(list_checks(write_self_check_cell(problems)))
    assert printed.count("? Yes.\n") == count > 0
    assert printed.splitlines()[count] == "Yes means that answers agree. Both could still share an error."


def list_checks(source: str) -> list[str]:
    return re.findall(r"^self_check(?:_singular)?\($.*?^\)$", source, re.MULTILINE | re.DOTALL)


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
    lines = column.write_code(20).split("\n")
    assert len(lines) == 5 and lines[2].lstrip().startswith("+ ") and max(map(len, lines)) <= 88
    assert column.write_placeholder() == "Matrix([blank, blank])"
    square = Matrix(sp.Matrix([[a1, 0], [1, 2]]))
    assert square.write_code() == "Matrix([[a1, 0], [1, 2]])"
    assert square.write_placeholder() == "Matrix([[blank, blank], [blank, blank]])"


@pytest.mark.integration
def test_notebook_runs_in_jupyter() -> None:
    nbclient = pytest.importorskip("nbclient")
    one = make_solution_notebook(NotebookContent("t", "k", "s", _problems("planar-2r")[:1]))
    done = nbclient.NotebookClient(one, timeout=100, kernel_name="python3").execute()
    outputs = [out.get("text", "") for cell in done.cells if cell.cell_type == "code" for out in cell.outputs]
    assert any("Is your Jacobian the derivative of your position? Yes" in text for text in outputs)


def test_an_arm_told_by_its_axes_has_no_names_of_a_table() -> None:
    """The length a2 of the solution's table appears neither in the text nor among the names for answers."""
    told = {name: generate(f"planar-2r/1@{name}", ["position"]) for name in CONVENTIONS}
    assert [name for name, problem in told.items() if "a2" in problem.symbols] == ["dh", "modified-dh"]
    for names in (("screws",), ("screws", "dh"), ("dh", "modified-dh")):
        slotted = [(f"p{number}", told[name]) for number, name in enumerate(names, 1)]
        opening = make_student_notebook(NotebookContent("T", "hw", "s1", slotted)).cells[0].source
        assert ("usual name (`a1`, `d1`, …)" in opening) == (names != ("screws",))
    assert "the table" not in write_statement(told["screws"], "").partition("**Joint variables:**")[2]


def test_staff_reads_what_students_read_whether_it_is_written_anew_or_not() -> None:
    (_, problem), _ = _problems("planar-2r")
    short = [("p1", replace(problem, parts=(problem["position"], problem["jacobian"])))]
    content = NotebookContent(TITLE, "hw1", "s001", short, with_hints=True)
    released = make_student_notebook(content)
    assert write_notebook(make_solution_notebook(content, released)) == write_notebook(make_solution_notebook(content))
    prompt = next(cell for cell in released.cells if cell.id.endswith("-question"))
    prompt.source = "written once"
    assert "written once" in [cell.source for cell in make_solution_notebook(content, released).cells]


@pytest.mark.parametrize(
    "site", ["https://example.edu/arms", "https://example.edu/arms/", "https://example.edu/arms/check.html"]
)
def test_a_student_can_check_the_notebook_on_the_site_of_the_assignment(site: str) -> None:
    content = NotebookContent(TITLE, "hw1", "Ada L#1", _problems("planar-2r")[:1], site=site)
    assert "(https://example.edu/arms/check.html#hw1/Ada%20L%231)" in make_student_notebook(content).cells[0].source
    assert "check.html" not in make_solution_notebook(content).cells[0].source
    assert "check.html" not in _student("planar-2r").cells[0].source


@pytest.mark.parametrize("title", ["Arms & <signs>", "a_1 * [b] $c$ `d` \\e &amp; _f_ *g* 6.1"])
def test_a_title_is_shown_as_it_is(title: str) -> None:
    cell = make_student_notebook(NotebookContent(title, "hw1", "s001", _problems("planar-2r"))).cells[0]
    heading = MarkdownIt().parse(cell.source)[1]
    assert "".join(token.content for token in heading.children or ()) == title
    assert {token.type for token in heading.children or ()} <= {"text", "text_special"}


T1, T2, A1, A2 = sp.symbols("theta1 theta2 a1 a2")
POSITION = sp.Matrix([A1 * sp.cos(T1) + A2 * sp.cos(T1 + T2), A1 * sp.sin(T1) + A2 * sp.sin(T1 + T2)])
JACOBIAN = POSITION.jacobian([T1, T2])
ANSWERS = {"position": POSITION, "jacobian": JACOBIAN, "determinant": A1 * A2 * sp.sin(T2)}
DERIVATIVE = "Is your Jacobian the derivative of your position?"
SINGULAR = "Are these the singular configurations of your Jacobian?"


@cache
def _plain() -> Problem:
    return get_problem("planar-2r", 0, "chapter")


def _space(problem: Problem) -> dict[str, Any]:
    space: dict[str, Any] = {}
    notebook = make_student_notebook(NotebookContent("t", "k", "s", [("p1", problem)]))
    for cell in notebook.cells:
        if cell.id == "setup":
            exec(cell.source, space)
        elif cell.id == "self-check":
            exec(cell.source.partition(list_checks(cell.source)[0])[0], space)
    return space


def _told(
    problem: Problem, answers: dict[str, Any], about: str = "", space: dict[str, Any] | None = None
) -> dict[str, str]:
    """Return what is said of each question: the references with other answers for some parts.

    Of one question alone it is what the cells say that ask it; what a notebook has set may be given, to be used again.
    """
    space = _space(problem) if space is None else space
    for part in problem.parts:
        space[name_answer_variable("p1", part.name)] = answers.get(part.name, getattr(part.answer, "reference", None))
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        for check in list_checks(write_self_check_cell([("p1", problem)])):
            if about in check:
                exec(check, space)
    told: dict[str, str] = {}
    for line in printed.getvalue().splitlines():
        question, sign, said = line.partition("? ")
        if sign:
            told[question.partition(" ")[2] + "?"] = said
        else:
            last = "look again" if line.startswith("Check again") else next(reversed(told))
            told[last] = told.get(last, "") + line
    return told


def test_every_relation_is_checked_for_some_family() -> None:
    asked = [get_problem(name, 0, step) for name in ("planar-2r", "planar-3r") for step in ("chapter", "full")]
    asked += [get_problem("planar-2r", 0, "chapter", convention="screws")]
    cells = "".join(write_self_check_cell([("p1", problem)]) for problem in asked)
    assert [relation.printed_question for relation in RELATIONS if relation.printed_question not in cells] == []


def _sabotaged(problem: Problem) -> Iterator[tuple[str, str, Any]]:
    """Yield each relation's question with one of its answers gone wrong in one entry."""
    cells = write_self_check_cell([("p1", problem)])
    for relation in RELATIONS:
        if relation.printed_question not in cells or relation.is_singular_set:
            continue
        name = relation.questions[-1]
        answer = next(part.answer for part in problem.parts if part.name == name)
        assert isinstance(answer, (Expression, Matrix))
        wrong = sp.Matrix([answer.reference])
        compared = [
            at for at in np.ndindex(*wrong.shape) if at[1] == 0 or "first column of" not in relation.printed_question
        ]
        if "linear rows" in relation.printed_question and not convention_of(problem.chain).frame_numbers:
            compared = [at for at in compared if at[0] > 2]
        row, column = next(at for at in compared if wrong[at] != 0)
        if "angular" in relation.printed_question:
            wrong[0 if convention_of(problem.chain).is_omega_first else 3, 0] += sp.Rational(1, 10)
        else:
            wrong[row, column] *= sp.Rational(-9, 10)
        yield relation.printed_question, name, wrong


@pytest.mark.parametrize(
    ("family", "convention"),
    select_for_suite([*zip(FEW, ("screws", "dh"), strict=True)], [*product(SHAPES.values(), ("dh", "screws"))]),
)
def test_an_entry_gone_wrong_does_not_fit(family: str, convention: str) -> None:
    problem = get_problem(family, 0, convention=convention)
    space = _space(problem)
    for question, name, wrong in _sabotaged(problem):
        assert _told(problem, {name: wrong}, question, space)[question].startswith("No."), question


@pytest.mark.parametrize(
    ("family", "twist_order"),
    select_for_suite([*zip(FEW, TWIST_ORDERS, strict=False)], [*product(SHAPES.values(), TWIST_ORDERS)]),
)
def test_right_answers_of_an_arm_told_by_axes_fit(family: str, twist_order: str) -> None:
    told = _told(get_problem(family, 1, convention="screws", twist_order=twist_order), {})
    assert {said for question, said in told.items() if question != SINGULAR} <= {"Yes."}


def test_where_it_does_not_fit_is_told() -> None:
    wrong = JACOBIAN.copy()
    wrong[1, 0] = -wrong[1, 0]
    said = _told(_plain(), {**ANSWERS, "jacobian": wrong})[DERIVATIVE]
    assert said.startswith("No. At theta1 = ") and "row 2, column 1: " in said and "row 1" not in said
    assert "2 x 1 and 2 x 2" in _told(_plain(), {**ANSWERS, "jacobian": JACOBIAN[:, 0]})[DERIVATIVE]


FORMS = [
    ["a1*cos(theta1) + a2*cos(theta1 + theta2)", "a1*s1 + a2*s12"], "[a1 c1 + a2 c12, a1 s1 + a2 s12]",
    "[a1*cos(\u03b81) + a2*c12, a1*s1 + a2*s12]", [POSITION[0], POSITION[1]], tuple(POSITION),
    [[POSITION[0]], [POSITION[1]]], {"x": POSITION[0], "y": POSITION[1]}, np.array([POSITION[0], POSITION[1]]),
    sp.ImmutableMatrix(POSITION),
    POSITION.subs({T1: sp.Symbol("theta1", real=True), A1: sp.Symbol("a1", positive=True)}),
    lambda theta1, theta2: list(POSITION.subs({T1: theta1, T2: theta2})),
    sp.Matrix([sp.Integral(-A1 * sp.sin(T1), T1) + A2 * sp.cos(T1 + T2), POSITION[1]]), sp.Tuple(*POSITION),
    POSITION.T, [sp.Matrix([POSITION[0]]), sp.Matrix([POSITION[1]])],
]  # fmt: skip


def test_a_check_has_the_number_of_the_last_question_that_it_compares() -> None:
    problem = generate("planar-2r/0", ["position", "determinant", "jacobian"])
    assert [check.number for check in _list_checks(1, "p1", problem)] == ["1.3", "1.3"]


def test_forms_that_the_grader_takes_fit() -> None:
    columns = [JACOBIAN[:, 0], JACOBIAN[:, 1]]
    for changed in (*({"position": form} for form in FORMS), {"jacobian": columns}):
        assert _told(_plain(), {**ANSWERS, **changed}, DERIVATIVE)[DERIVATIVE].startswith("Yes"), changed


OTHER_FORMS: list[tuple[Any, str]] = [
    ("a1 cos 30\u00b0", "Not checked"),
    (sp.Matrix([sp.nan, POSITION[1]]), "No."),  # what is nowhere a number does not fit
    ([sp.Symbol("l1") * sp.cos(T1), A1], "this problem has no symbol l1"),
    (["a1*s14", "a2"], "s14 has an unknown angle"), (lambda t, u: [t, u], "this problem has no symbol t, u"),
    (sp.Matrix([sp.Symbol("blank"), A1]), "Not yet"), (None, "Not checked"), (object(), "Not checked"),
    (sp.Eq(T1, 0) & sp.Eq(T2, 0), "Not checked"), (sp.Array([[[A1, A2]], [[A1, A2]]]), "Not checked"),
    ([[A1, A2], [A1]], "Not checked"), (sp.Matrix([A1, A2, T1, T2]), "2 x 2 and 4 x 2"),
]  # fmt: skip


def test_of_other_forms_it_is_said_that_they_are_not_judged() -> None:
    for position, why in OTHER_FORMS:
        assert why in _told(_plain(), {**ANSWERS, "position": position}, DERIVATIVE)[DERIVATIVE], position


def test_degrees_in_a_sine_are_seen_though_both_answers_fit() -> None:
    position = sp.Matrix([A1 * sp.cos(T1 + 30), A1 * sp.sin(T1 + 30)])
    told = _told(_plain(), {"position": position, "jacobian": position.jacobian([T1, T2])})
    assert told[DERIVATIVE].startswith("Yes") and "30 in sin or cos: angles are in radians" in told["look again"]
    assert "look again" not in _told(_plain(), ANSWERS)


CONDITIONS: list[tuple[Any, str]] = [
    ([sp.Eq(sp.sin(T2), 0)], "Yes"), ([sp.Eq(T2, 0), sp.Eq(T2, sp.pi)], "Yes"),
    ([sp.Eq(T2, 0), sp.Eq(T2, -sp.pi)], "Yes"), ([{T2: [0, sp.pi]}], "Yes"), ({T2: [0, sp.pi]}, "Yes"),
    (sp.Or(sp.Eq(T2, 0), sp.Eq(T2, sp.pi)), "Yes"), ([sp.sin(T2)], "sin(theta2) is not a condition"),
    ([sp.Eq(sp.cos(T2), 1), sp.Eq(sp.cos(T2), -1)], "Yes"), ([sp.Eq(2 * T2, 0), sp.Eq(T2, sp.pi)], "Yes"),
    ([sp.Eq(sp.cos(T2), 2)], "no configuration has cos(theta2) = 2"),
    ([sp.Eq(T2, 0)], "Some are missing. Your Jacobian also loses rank here"),
    ([sp.Eq(T2, sp.pi / 2)], "No. With theta2 = pi/2, your Jacobian has full rank"),
    ([sp.And(sp.Eq(T2, 0), sp.Eq(T1, 0)), sp.Eq(T2, sp.pi)], "Some are missing."), ([sp.Eq(T1, sp.pi / 2)], "No. "),
    ([0, sp.pi], "numbers without a joint"), ([False], "numbers without a joint"),
    ([sp.Symbol("blank")], "Not yet"), ([sp.Eq(T2, sp.pi * sp.Symbol("k"))], "this problem has no symbol k"),
]  # fmt: skip


def test_singular_configurations_are_put_into_the_own_jacobian() -> None:
    for conditions, said in (*CONDITIONS, *read_cases("answers")["self_checked_sets"]):
        told = _told(_plain(), {**ANSWERS, "singular-angles": conditions}, SINGULAR)[SINGULAR]
        assert said in told, (conditions, told)
        assert not said.startswith("Not checked") or told.endswith("Your answers are still graded.")


def test_a_notebook_answered_in_text_is_checked_like_any_other() -> None:
    for name, text in read_cases("answers")["typed"]:
        told = _told(_plain(), {**ANSWERS, name: text})
        assert {said for question, said in told.items() if question != SINGULAR} == {"Yes."}, (text, told)


def test_a_problem_of_short_questions_has_no_function_for_checks() -> None:
    problem = get_problem("planar-2r", 0)
    quiz = Problem(problem.id, problem.chain, tuple(p for p in problem.parts if p.name == "rank"))
    assert write_self_check_cell([("p1", quiz)]) == ""
    cells = make_student_notebook(NotebookContent("t", "k", "s", [("p1", quiz)])).cells
    assert "self-check" not in {cell.id for cell in cells}


def test_the_transform_is_held_against_the_position_where_the_point_is_the_last_origin() -> None:
    """For P in the origin of a frame before the last one, only its rotation is looked at."""
    held = "Is your position the last column of your transform?"

    def asked(frame: int) -> set[str]:
        joints = tuple(Joint("R", sp.Symbol(f"theta{i}"), 0, sp.Symbol(f"a{i}"), 0) for i in (1, 2, 3))
        chain = Chain("planar", joints, ("vx", "vy"), tool=Point(frame))
        return {one.printed_question for one in RELATIONS if one.printed_question == held and one.applies_to(chain, {})}

    assert held in asked(3) and held not in asked(2)
