"""Edited notebooks: every answer is found or reported, and self-checks are skipped."""

import random
import re
import time
from collections.abc import Callable, Iterable, Sequence
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nbformat import NotebookNode

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.generation import generate
from qdot.exercises.notebook.notebook import NotebookContent, make_solution_notebook, make_student_notebook
from qdot.exercises.notebook.notebook import write_notebook as write_released_notebook
from qdot.exercises.notebook.self_check import SELF_CHECK, Problems
from qdot.exercises.problem.problem import name_answer_variable
from qdot.grader.grading.check import check_notebook
from qdot.grader.grading.result import Result
from qdot.grader.sandbox.sandbox import Run, Sandbox
from qdot.grader.submissions.answer_locator import find_answers, guess_parts
from qdot.grader.submissions.cells import Cell, empty_self_checks, read_cells
from tests.support import read_cases
from tests.support.command import run
from tests.support.problems import get_problem, sample_parts
from tests.support.submitting import (
    ALL_CORRECT,
    PARTS,
    Cells,
    code_cell,
    grade,
    list_outcomes,
    list_reasons,
    make_class,
    make_correct_cells,
    make_correct_notebook,
    submit,
    text_cell,
    write_notebook,
)
from tests.support.suites import few_families, sample_for_suite, select_for_suite

SETUP, POSITION, JACOBIAN, DETERMINANT = 1, 2, 3, 4
"""Indices of cells, from 0; messages count from 1."""


def replace_source(cells: Cells, index: int, old: str, new: str) -> None:
    assert old in cells[index]["source"]
    cells[index]["source"] = cells[index]["source"].replace(old, new)


Change = Callable[[Cells], object]


def edit_cell(index: int, old: str, new: str) -> Change:
    return lambda cells: replace_source(cells, index, old, new)


def name_j(name: str) -> Change:
    return edit_cell(JACOBIAN, "p1_jacobian", name)


def rewrite(replace_source: str) -> Change:
    return lambda cells: cells[JACOBIAN].update(source=replace_source)


def add_cell(replace_source: str, part: str | None = None, index: int | None = None) -> Change:
    return lambda cells: cells.insert(len(cells) if index is None else index, code_cell(replace_source, part))


def combine(*changes: Change) -> Change:
    return lambda cells: [change(cells) for change in changes]


def tamper(part: Any, **entries: Any) -> Change:
    return lambda cells: cells[JACOBIAN]["metadata"].update(qdot={"part": part, **entries})


def wrap_in_prose(cells: Cells) -> None:
    cells[JACOBIAN] = text_cell(f"My answer:\n\n```python\n{cells[JACOBIAN]['source']}\n```\nI hope it's right!")


def build_step_by_step(cells: Cells) -> None:
    value = cells[JACOBIAN]["source"].split("=", 1)[1]
    cells[JACOBIAN]["source"] = "p1_jacobian = zeros(2, 2)"
    cells.append(code_cell(f"for i in range(4):\n    p1_jacobian[i] = ({value})[i]"))


def copy_name_in_brackets(cells: Cells) -> None:
    replace_source(cells, JACOBIAN, "p1_jacobian = ", "θ = 'ä'; p1_position = (\n\n")
    cells[JACOBIAN]["source"] += "\n).applyfunc(lambda entry: entry)\np1_position"


def leave_bracketed_expression(cells: Cells) -> None:
    replace_source(cells, JACOBIAN, "p1_jacobian = ", "# my answer\n(2*")
    cells[JACOBIAN]["source"] += "\n  / 2)"


def print_j(cells: Cells) -> None:
    replace_source(cells, JACOBIAN, "p1_jacobian = ", "A = 3; θ = 1; J = ")
    cells[JACOBIAN]["source"] += "\nprint(J)\nJ.shape"


def move_answer_to_new_cell(cells: Cells) -> None:
    cells.append(code_cell(cells[JACOBIAN]["source"]))
    cells[JACOBIAN]["source"] = "scratch = 5"


def define_helper_below(cells: Cells) -> None:
    value = cells[JACOBIAN]["source"].split("=", 1)[1]
    cells[JACOBIAN]["source"] = "p1_jacobian = helper()"
    cells.append(code_cell(f"def helper():\n    return {value}"))


def stop_first_cell(cells: Cells) -> None:
    cells[SETUP]["source"] = "import numpy as np\nundefined_thing()\n" + cells[SETUP]["source"]
    replace_source(cells, JACOBIAN, "p1_jacobian = ", "zeros(2)\np1_jacobian = ")


def import_missing_library(cells: Cells) -> None:
    cells[SETUP]["source"] = "import nosuchlibrary as no\n" + cells[SETUP]["source"]
    replace_source(cells, DETERMINANT, "p1_determinant = ", "no.det\np1_determinant = ")


def use_jupyter_habits(cells: Cells) -> None:
    cells[SETUP]["source"] = "%matplotlib inline\nimport matplotlib.pyplot as plt\n" + cells[SETUP]["source"]
    cells[SETUP]["source"] = "from IPython.display import display, Math\n" + cells[SETUP]["source"]
    replace_source(cells, POSITION, "p1_position", "files = !ls\nsin?\nplt.figure(); plt.show()\np1_position")
    name, value = cells[JACOBIAN]["source"].split(" = ", 1)
    cells[JACOBIAN]["source"] = f"{name} = _"
    replace_source(cells, DETERMINANT, "p1_determinant = ", "%%time\nfrom helper import keep\np1_determinant = keep(")
    cells[DETERMINANT]["source"] += ")\ndisplay(p1_determinant)\ninput('done?')"
    cells.insert(JACOBIAN, code_cell(value))
    cells.insert(2, code_cell("%%writefile helper.py\ndef keep(x):\n    return x"))


def add_help_below_j(cells: Cells) -> None:
    replace_source(cells, JACOBIAN, "p1_jacobian", "J")
    cells[JACOBIAN]["source"] += "\n!ls\nJ?"


def merge_cells(cells: Cells) -> None:
    replace_source(cells, POSITION, "p1_position", cells.pop(JACOBIAN)["source"] + "\np1_position")


def copy_metadata_of_another_part(cells: Cells) -> None:
    cells[POSITION]["metadata"]["qdot"]["part"] = "p1.jacobian"
    del cells[JACOBIAN]


ZEROS, ANSWER = "p1_jacobian = Matrix([[0, 0], [0, 0]])", "p1.jacobian"
BLANK = "p1_jacobian = Matrix([[blank, blank], [blank, blank]])"
PROSE = r"The Jacobian is $J = \begin{bmatrix} 1 \end{bmatrix}$, isn't it?"
drop_metadata: Change = lambda cells: cells[JACOBIAN]["metadata"].pop("qdot")  # noqa: E731
make_markdown: Change = lambda cells: cells[JACOBIAN].update(cell_type="markdown")  # noqa: E731
reuse_j = combine(name_j("J"), add_cell("J = 5"))
duplicate_answer_cells = combine(reuse_j, add_cell("J = 3", ANSWER, JACOBIAN), add_cell("J.det()", ANSWER))
J_WRONG, J_MISSING = ["correct", "wrong", "correct"], ["correct", "missing", "correct"]
CASES: dict[str, tuple[Change, list[str], str, str]] = {
    "duplicated, the last wrong": (add_cell(ZEROS, ANSWER), J_WRONG, "p1_jacobian cells 4 and 6", "(1, 1)"),
    "duplicated, the last right": (add_cell(ZEROS, ANSWER, JACOBIAN), ALL_CORRECT, "p1_jacobian cells 4 and 5", ""),
    "duplicated, the last blank": (add_cell(BLANK, ANSWER), ALL_CORRECT, "p1_jacobian blank", ""),
    "duplicated, the last unreadable": (
        add_cell("p1_jacobian = lambda: p1_jacobian\np1_jacobian = object()", ANSWER),
        ALL_CORRECT,
        "p1_jacobian TypeError:", "",
    ),
    "duplicated, the last stops": (
        add_cell("p1_jacobian = undefined_name", ANSWER), ALL_CORRECT, "cells 4 and 6 NameError: 'undefined_name'", "",
    ),
    "duplicated, the same": (lambda cells: cells.append(deepcopy(cells[JACOBIAN])), ALL_CORRECT, "", ""),
    "answered in another cell": (
        combine(drop_metadata, lambda cells: cells.insert(2, text_cell("some text"))), ALL_CORRECT, "", "",
    ),
    "built step by step": (build_step_by_step, ALL_CORRECT, "", ""),
    "misspelt": (name_j("p1_jacobain"), ALL_CORRECT, "cell 4 p1_jacobian p1_jacobain", ""),
    "misspelt, without metadata": (
        combine(name_j("p1_jacobain"), drop_metadata), ALL_CORRECT, "cell 4 p1_jacobian p1_jacobain", "",
    ),
    "a similar name, without metadata": (
        combine(name_j("p1_jac_trans"), drop_metadata), J_MISSING, "", "p1_jacobian",
    ),
    "another name": (
        reuse_j,
        ALL_CORRECT, "cell 4 is the answer cell of p1_jacobian and sets J, not p1_jacobian; qdot used its value", "",
    ),
    "another name, and shown": (print_j, ALL_CORRECT, "p1_jacobian J,", ""),
    "an expression only": (edit_cell(JACOBIAN, "p1_jacobian = ", ""), ALL_CORRECT, "cell 4 p1_jacobian", ""),
    "another part's name": (name_j("p1_position"), ALL_CORRECT, "cell 4 p1_jacobian p1_position", ""),
    "another part's name, in brackets": (copy_name_in_brackets, ALL_CORRECT, "p1_jacobian p1_position", ""),
    "an expression in brackets": (leave_bracketed_expression, ALL_CORRECT, "cell 4 p1_jacobian", ""),
    "several answer cells under another name": (duplicate_answer_cells, ALL_CORRECT, "4, 5 8 p1_jacobian J,", ""),
    "two answers in a text cell": (
        combine(merge_cells, lambda cells: cells[POSITION].update(cell_type="raw")), ALL_CORRECT, "cell 3", "",
    ),
    "the answer in a new cell": (move_answer_to_new_cell, ALL_CORRECT, "p1_jacobian cell 6 cell 4", ""),
    "retyped to Markdown": (make_markdown, ALL_CORRECT, "cell 4 p1_jacobian", ""),
    "retyped to Markdown, metadata lost": (combine(make_markdown, drop_metadata), ALL_CORRECT, "cell 4 text", ""),
    "fenced among prose": (wrap_in_prose, ALL_CORRECT, "cell 4 text", ""),
    "retyped and renamed": (combine(make_markdown, name_j("J")), ALL_CORRECT, "cell 4 text J,", ""),
    "prose": (combine(make_markdown, rewrite(PROSE)), J_MISSING, "", "cell 4 text"),
    "metadata stripped": (lambda cells: [cell.update(metadata={}) for cell in cells], ALL_CORRECT, "", ""),
    "a helper below": (define_helper_below, ALL_CORRECT, "cell 4 NameError: 'helper'", ""),
    "deleted": (lambda cells: cells.pop(JACOBIAN), J_MISSING, "", "p1_jacobian"),
    "emptied": (rewrite("\n"), J_MISSING, "", "p1_jacobian"),
    "the set-up deleted": (lambda cells: cells.pop(SETUP), ALL_CORRECT, "", ""),
    "the set-up stops": (
        stop_first_cell, J_MISSING, "cell 2 line 2 (NameError: undefined_thing()",
        "'zeros' The name zeros cell 2 line 2 (NameError: The line is “",
    ),
    "the set-up lacks a library": (
        import_missing_library, ["correct", "correct", "missing"],
        "cell 2 line 1 (ModuleNotFoundError: import nosuchlibrary as no", "'no' cell 2 line 1 nosuchlibrary",
    ),
    "answers from the last to the first": (
        lambda cells: cells.extend(cells.pop(k) for k in (4, 3, 2)), ALL_CORRECT, "", "",
    ),
    "forged, and wrong": (
        combine(rewrite("p1_jacobian = 0"), tamper(ANSWER, points=1000, reference="0")), J_WRONG, "metadata points", "",
    ),
    "a library in an answer": (
        edit_cell(JACOBIAN, "p1_jacobian", "from nosuchlibrary import linalg\np1_jacobian"), ALL_CORRECT, "", "",
    ),
    "habits of Jupyter": (use_jupyter_habits, ALL_CORRECT, "", ""),
    "only a magic left": (rewrite("%who"), J_MISSING, "", "p1_jacobian"),
    "another name above magics": (add_help_below_j, ALL_CORRECT, "p1_jacobian J,", ""),
    "another name below a magic": (name_j("%%time\nx = !ls\nJ"), ALL_CORRECT, "p1_jacobian J,", ""),
    "another name below two magics": (name_j("%%time\n!ls\nJ"), ALL_CORRECT, "p1_jacobian J,", ""),
    "the process ended": (add_cell("import os; os._exit(0)"), ALL_CORRECT, "cell 6", ""),
    "cells merged": (merge_cells, ALL_CORRECT, "", ""),
    "a part that isn't asked": (tamper("p9.jacobian"), ALL_CORRECT, "marked p9.jacobian", ""),
    "a part that is a path": (tamper("../x\n"), ALL_CORRECT, "marked ../x\N{REPLACEMENT CHARACTER}", ""),
    "a part that is a dictionary": (tamper({"a": [1]}), ALL_CORRECT, "metadata part", ""),
    "points": (tamper("p1.jacobian", points=1000), ALL_CORRECT, "metadata points", ""),
    "the metadata of another part": (copy_metadata_of_another_part, J_MISSING, "", "p1_jacobian"),
}  # fmt: skip
"""A change, the outcomes of the three parts, and words that one note and one reason must have."""
STUDENTS = [Student(f"s{number:02d}") for number in range(len(CASES) + 1)]


@pytest.fixture(scope="module")
def assignment(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    return make_class(tmp_path_factory.mktemp("cells") / "hw", STUDENTS)


@pytest.fixture(scope="module")
def results(assignment: Assignment) -> dict[str, Result]:
    for student, (change, *_) in zip(STUDENTS, CASES.values(), strict=False):
        submit(assignment, f"{student.id}.ipynb", make_correct_notebook(assignment, student.id, change))
    submit(assignment, f"{STUDENTS[-1].id}.ipynb", make_correct_notebook(assignment, STUDENTS[-1].id))
    by_student, _ = grade(assignment)
    return {**dict(zip(CASES, by_student.values(), strict=False)), "honest": by_student[STUDENTS[-1].id]}


@pytest.mark.parametrize("case", CASES)
def test_every_answer_is_found(results: dict[str, Result], case: str) -> None:
    _, expected, note, reason = CASES[case]
    result, honest = results[case], results["honest"]
    assert list_outcomes(honest) == ALL_CORRECT and not honest.staff_notes  # the other students are graded as usual
    assert list_outcomes(result) == expected, list_reasons(result)
    points = sum(points for points, outcome in zip((1, 2, 1), expected, strict=True) if outcome == "correct")
    assert (result.score, result.max_score) == (points, 4)
    staff_notes = result.staff_notes if "metadata" in note or "marked" in note else ()
    assert has_words((*result.notes, *staff_notes), note) if note else not result.staff_notes, result.staff_notes
    assert has_words(list_reasons(result), reason), list_reasons(result)


def has_words(texts: Iterable[str], words: str) -> bool:
    return any(all(word in text for word in words.split()) for text in texts)


# --- random edits ---


def rename_answer(cells: Cells, rng: random.Random) -> None:
    cell = rng.choice(cells)
    cell["source"] = re.sub(r"^p1_\w+ =", rng.choice(["J =", "p1_answer =", "P1_Jacobian ="]), cell["source"])


EDITS: list[Callable[[Cells, random.Random], object]] = [
    lambda cells, rng: cells.insert(rng.randrange(len(cells) + 1), deepcopy(rng.choice(cells))),
    lambda cells, rng: cells.pop(rng.randrange(len(cells))),
    lambda cells, rng: cells.insert(rng.randrange(len(cells)), cells.pop(rng.randrange(len(cells)))),
    lambda cells, rng: rng.choice(cells).update(metadata={}),
    lambda cells, rng: rng.choice(cells).update(cell_type=rng.choice(["code", "markdown", "raw"])),
    rename_answer,
]


@settings(max_examples=select_for_suite(20, 200))
@given(seed=st.integers(0, 10**9))
def test_no_edit_loses_an_answer_silently(assignment: Assignment, sandbox: Sandbox, seed: int) -> None:
    rng = random.Random(seed)
    cells = make_correct_cells(assignment, "s00")
    untouched = find_answers(
        [Cell(cell["source"], is_code=cell["cell_type"] == "code") for cell in cells], PARTS, sandbox.run
    )
    for _ in range(rng.randrange(1, 5)):
        if cells:
            rng.choice(EDITS)(cells, rng)
    edited_notebook = write_notebook(assignment, "s00", cells)
    result = find_answers(read_cells("hw.ipynb", edited_notebook.encode()).cells, PARTS, sandbox.run)
    for part in PARTS:
        name = name_answer_variable(*part.split("."))
        is_reported = any(name in note for note in result.notes) or result.missing_reasons.get(name)
        assert result.run.answers.get(name) == untouched.run.answers[name] or is_reported, (cells, result.notes)


def test_rerunning_a_cell_changes_no_answer_already_found(sandbox: Sandbox) -> None:
    cells = [Cell("p1_a = [1]; later.append(p1_a)", "p1.a"), Cell("p1_b = late")]
    cells.append(Cell("later = []; late = 5; p1_a.append(2)"))
    result = find_answers(cells, ["p1.a", "p1.b"], sandbox.run)
    assert result.run.answers == {"p1_a": "[1, 2]", "p1_b": "5"}
    assert len(result.notes) == 1 and has_words(result.notes, "cell 2 NameError: 'late' p1_b")


def test_the_reason_names_the_cell_that_should_have_defined_a_name(sandbox: Sandbox) -> None:
    failing, parts = read_cases("answers")["failing"], [f"p1.{letter}" for letter in "abcdefghijk"]
    cells = [Cell("1/0\nlost = 1"), Cell("x = 1\nimport nosuchlibrary as no")]
    cells += [Cell(source, part) for (source, _), part in zip(failing, parts, strict=True)]
    reasons = find_answers(cells, parts, sandbox.run).missing_reasons
    for part, (_, words) in zip(parts, failing, strict=True):
        reason = reasons[part.replace(".", "_")]
        assert has_words([reason], words), reason
        assert ("cell 1" in reason) == (part == "p1.b"), "a cell that does not set the name is no cause"
        assert "':='" not in reason and "?" not in reason


def test_staff_see_every_cell_that_tried_something_forbidden(sandbox: Sandbox) -> None:
    sources = ("secret = open('/etc/passwd').read()", "x = 1/0", "import os\nos.system('ls')")
    result = find_answers([Cell("p1_a = 1", "p1.a"), *map(Cell, sources)], ["p1.a"], sandbox.run)
    stops = [stop.split(" (")[0] for stop in result.forbidden_stops]
    assert stops == ["cell 2 stopped at line 1", "cell 4 stopped at line 2"]
    assert find_answers([Cell("p1_a = 1", "p1.a"), Cell("x = 1/0")], ["p1.a"], sandbox.run).forbidden_stops == []


def test_deep_and_long_cells_are_run_but_not_searched(sandbox: Sandbox) -> None:
    deep = Cell("p1_a = " + "(" * 5000 + "1" + ")" * 5000, "p1.a")
    long = Cell("p1_b = " + " + ".join(["x"] * 20_000) + "\n")
    cells = [Cell("from sympy import *; x = Symbol('x')"), deep, long, Cell(f"# {'x' * 10**6}\np1_c = 3", "p1.c")]
    result = find_answers(cells, ["p1.a", "p1.b", "p1.c"], sandbox.run)
    assert result.run.answers.get("p1_c") == "3"
    padded_cells = [Cell("\n" * 10**6 + "x", "p1.a"), Cell(" " * 10**6 + "p1_b", "p1.b", is_code=False)]
    padded_cells += [Cell("\n" * 29_000 + "(", "p1.a"), Cell("p1_c" + " " * 29_000 + "(", "p1.c")]
    padded_cells += [Cell("=".join(f"p1_a{n}" for n in range(3000)) + "=1") for _ in range(50)]
    padded_cells += [Cell("p1_b = (\n" * 100, is_code=False)] * 10_000
    start = time.process_time()
    find_answers(padded_cells, ["p1.a", "p1.b", "p1.c"], lambda cells, names: Run())
    assert guess_parts(padded_cells, lambda: ["a", "c"]) == ["p1.a", "p1.b", "p1.c"]
    assert time.process_time() - start < 20
    assert "the cell with this answer stopped" in result.missing_reasons["p1_a"]


@pytest.mark.parametrize("change", sample_for_suite([stop_first_cell, import_missing_library, use_jupyter_habits], 2))
def test_check_reports_what_the_first_cell_lacks(assignment: Assignment, tmp_path: Path, change: Change) -> None:
    """`qdot check` takes the symbols of a problem from the notebook's metadata."""
    (tmp_path / "hw.ipynb").write_text(make_correct_notebook(assignment, "s00", change))
    checked = check_notebook(tmp_path / "hw.ipynb")
    messages = [row.message for row in checked.rows if not row.is_readable]
    assert len(messages) == len(checked.notes) == (change is not use_jupyter_habits)
    for note, message in zip(checked.notes, messages, strict=True):
        assert note.startswith("cell 2 ") and note.rpartition(": ")[0] in message and "NameError" in message


def test_symbols_in_metadata_are_not_run_as_code(assignment: Assignment, tmp_path: Path) -> None:
    cells = make_correct_cells(assignment, "s00")
    del cells[SETUP]
    claims = {"p1": ["x; open('/etc/passwd')", "if", 5, "theta1\n"], "p2": "a1", "p3": ["theta2", "x" * 10**6]}
    text_of_notebook = write_notebook(assignment, "s00", cells, metadata={"qdot": {"symbols": claims}})
    (tmp_path / "hw.ipynb").write_text(text_of_notebook)
    rows = check_notebook(tmp_path / "hw.ipynb").rows
    cause = r"\(NameError: name 'a1' is not defined\)\. No cell above sets a1"
    beginning = rf"the cell with this answer stopped at line \d+ {cause}"
    assert all(re.match(beginning, row.message, re.DOTALL) for row in rows), rows


def test_check_prints_notes_to_the_student(assignment: Assignment, tmp_path: Path) -> None:
    (tmp_path / "hw (1).ipynb").write_text(make_correct_notebook(assignment, "s00", reuse_j))
    output = run("check", tmp_path / "hw (1).ipynb")
    assert has_words(output.splitlines(), "note: cell 4 p1_jacobian J,")
    assert "ok  p1.jacobian: 2 × 2 matrix" in output
    (tmp_path / "hw.py").write_text("\n\n".join(cell["source"] for cell in make_correct_cells(assignment, "s00")[1:]))
    output = run("check", tmp_path / "hw.py")
    assert "note: hw.py" in output and "3 of 3 answers can be read" in output


# --- symbols that became numbers ---

SYMBOL_NOTE = "replaces the symbol by a number"
SYMBOLS = "from sympy import *\ntheta1, theta2, a1, a2 = symbols('theta1 theta2 a1 a2')"
RIGHT_DETERMINANT = "p1_determinant = a1*a2*sin(theta2)"


@pytest.mark.parametrize(
    ("sources", "expected"),
    [
        (["theta2 = 0.5", RIGHT_DETERMINANT], "theta2 = 0.5 in cell 2"),
        (["theta2 = pi/2", RIGHT_DETERMINANT], "theta2 = pi/2 in cell 2"),
        (["for theta2 in [0, pi]: pass", "p1_determinant = {theta2: [0, pi]}"], "theta2 = pi in cell 2"),
        (["p1_determinant = []\nfor theta2 in [0, pi]: p1_determinant.append(Eq(theta2, 0))"], "theta2 = pi in cell 2"),
        (["print([theta2 for theta2 in [0, pi]])", RIGHT_DETERMINANT], ""),
        ([f"theta2 = 1\n{RIGHT_DETERMINANT}"], "theta2 = 1 in cell 2"),
        (["t2 = theta2", "t2 = Rational(1, 3)", "p1_determinant = a1*a2*sin(t2)"], "t2 = 1/3 in cell 3"),
        ([RIGHT_DETERMINANT, "theta2 = 0.5"], ""),
        ([f"{RIGHT_DETERMINANT}\ntheta2 = 0.5\np1_determinant.subs('theta2', theta2)"], ""),
        (["theta2 = 0.5", f"theta2 = symbols('theta2')\n{RIGHT_DETERMINANT}"], ""),
        (["for theta2 in (0.1, 0.2): pass", "p1_determinant = 'a1*a2*s2'"], ""),
    ],
)
def test_a_symbol_overwritten_by_a_number_is_reported(sandbox: Sandbox, sources: list[str], expected: str) -> None:
    cells = [Cell(replace_source, is_code=True) for replace_source in (SYMBOLS, *sources)]
    notes = find_answers(cells, ["p1.determinant"], sandbox.run).notes
    assert [note for note in notes if SYMBOL_NOTE in note] == [note for note in notes if expected and expected in note]
    assert bool(notes) == bool(expected), notes


def make_problems(family: str) -> Problems:
    """Return a problem of the family, and one whose notebook certainly has a self-check, and `self` in an answer."""
    problem = get_problem(family, 0)
    shortened = replace(problem, parts=tuple(sample_parts(problem)[:6]))
    return [("p1", shortened), ("p2", generate("planar-3r/0", ["position", "jacobian", "self-motion"]))]


def make_cells(problems: Problems, make_notebook: Callable[..., NotebookNode] = make_solution_notebook) -> list[Cell]:
    text = write_released_notebook(make_notebook(NotebookContent("Title", "hw", "s1", problems)))
    return list(read_cells("hw.ipynb", text.encode()).cells)


def code(cells: Sequence[Cell]) -> list[str]:
    return [cell.source for cell in cells if cell.is_code]


@few_families
@pytest.mark.parametrize("make_notebook", [make_student_notebook, make_solution_notebook])
def test_only_self_checks_are_skipped(family: str, make_notebook: Callable[..., NotebookNode]) -> None:
    """A student notebook's text that explains the checks stays."""
    problems = make_problems(family)
    cells = make_cells(problems, make_notebook)
    kept = empty_self_checks(cells, problems)
    changed = [before for before, after in zip(cells, kept, strict=True) if before != after]
    assert len(changed) == 1 and SELF_CHECK in changed[0].source
    assert not any(SELF_CHECK in source for source in code(kept))
    assert len(kept) == len(cells)
    assert [cell for cell in kept if cell.source] == [cell for cell in cells if cell not in changed]


def test_skipping_self_checks_changes_no_answer(sandbox: Sandbox) -> None:
    problems = make_problems("planar-2r")[:1]
    cells = make_cells(problems)
    names = [f"{slot}_{part.name.replace('-', '_')}" for slot, problem in problems for part in problem.parts]
    full_run = sandbox.run(code(cells), names)
    short_run = sandbox.run(code(empty_self_checks(cells, problems)), names)
    assert full_run.answers == short_run.answers and set(short_run.answers) == set(names)
    assert not short_run.cell_errors and not short_run.unreadable_reasons


@pytest.mark.parametrize(
    "source",
    [
        "self_check = print", "def self_check(*given):\n    global p1_jacobian", "from my_tools import self_check",
        "self_check('p1', '', lambda at: at(p1_position), lambda at: at.slope(p1_jacobian))", "%run self_check.py",
    ],
)  # fmt: skip
def test_all_cells_run_if_another_cell_mentions_the_check(source: str) -> None:
    problems = make_problems("planar-2r")
    cells = [*make_cells(problems), Cell(source)]
    assert empty_self_checks(cells, problems) == cells


def test_a_modified_check_is_run() -> None:
    problems = make_problems("planar-2r")
    cells = make_cells(problems)
    index = next(n for n, cell in enumerate(cells) if "def self_check" in cell.source)
    for old, new in (("random", "chance"), ("1e-5", "1e-6"), ("def self_check(", "def own_self_check(")):
        changed = [*cells]
        changed[index] = Cell(cells[index].source.replace(old, new))
        assert empty_self_checks(changed, problems) == changed
    last = max(n for n, cell in enumerate(cells) if SELF_CHECK in cell.source)
    changed = [*cells]
    changed[last] = Cell(cells[last].source + "\np2_jacobian = p2_jacobian.T")
    assert empty_self_checks(changed, problems) == changed
    quoted = [Cell(cell.source, is_code=False) for cell in cells]
    assert empty_self_checks(quoted, problems) == quoted, "text that quotes a check stays text"
