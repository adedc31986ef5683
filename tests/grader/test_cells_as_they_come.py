"""Notebooks as students edit them: every answer that is there is read, and what was ambiguous is said."""

import random
import re
import time
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exercises.assignment import Assignment, Student
from exercises.problem import variable
from grader.cells import Cell, read_cells
from grader.check import check_notebook
from grader.finding import asked_in, find_answers
from grader.sandbox import Limits, Run, Sandbox
from grader.settle import Result
from tests.support.handing_in import (
    PARTS,
    RIGHT,
    Cells,
    a_class,
    code,
    grade,
    hand_in,
    notebook,
    outcomes,
    reasons,
    right,
    right_cells,
    text,
)

pytestmark = pytest.mark.xdist_group("cells-as-they-come")
SETUP, POSITION, JACOBIAN, DETERMINANT = 1, 2, 3, 4
"""Places of cells; people count from 1."""


def source(cells: Cells, place: int, old: str, new: str) -> None:
    assert old in cells[place]["source"]
    cells[place]["source"] = cells[place]["source"].replace(old, new)


def duplicated_last_wrong(cells: Cells) -> None:
    cells.append(code("p1_jacobian = Matrix([[0, 0], [0, 0]])", "p1.jacobian"))


def duplicated_last_right(cells: Cells) -> None:
    cells.insert(JACOBIAN, code("p1_jacobian = Matrix([[0, 0], [0, 0]])", "p1.jacobian"))


def duplicated_blank(cells: Cells) -> None:
    cells.append(code("p1_jacobian = Matrix([[blank, blank], [blank, blank]])", "p1.jacobian"))


def duplicated_unreadable(cells: Cells) -> None:
    cells.append(code("p1_jacobian = lambda: p1_jacobian\np1_jacobian = object()", "p1.jacobian"))


def duplicated_stops(cells: Cells) -> None:
    cells.append(code("p1_jacobian = undefined_name", "p1.jacobian"))


def duplicated_same(cells: Cells) -> None:
    cells.append(deepcopy(cells[JACOBIAN]))


def answered_in_another_cell(cells: Cells) -> None:
    del cells[JACOBIAN]["metadata"]["qdot"]
    cells.insert(2, text("some text"))


def built_step_by_step(cells: Cells) -> None:
    value = cells[JACOBIAN]["source"].split("=", 1)[1]
    cells[JACOBIAN]["source"] = "p1_jacobian = zeros(2, 2)"
    cells.append(code(f"for i in range(4):\n    p1_jacobian[i] = ({value})[i]"))


def misspelt(cells: Cells) -> None:
    source(cells, JACOBIAN, "p1_jacobian", "p1_jacobain")


def misspelt_without_metadata(cells: Cells) -> None:
    misspelt(cells)
    del cells[JACOBIAN]["metadata"]["qdot"]


def named_j(cells: Cells) -> None:
    source(cells, JACOBIAN, "p1_jacobian", "J")
    cells.append(code("J = 5"))


def named_j_and_shown(cells: Cells) -> None:
    source(cells, JACOBIAN, "p1_jacobian = ", "A = 3; θ = 1; J = ")
    cells[JACOBIAN]["source"] += "\nprint(J)\nJ.shape"


def expression_only(cells: Cells) -> None:
    source(cells, JACOBIAN, "p1_jacobian = ", "")


def copied_name(cells: Cells) -> None:
    source(cells, JACOBIAN, "p1_jacobian", "p1_position")


def copied_name_in_brackets(cells: Cells) -> None:
    copied_name(cells)
    source(cells, JACOBIAN, "p1_position = ", "θ = 'ä'; p1_position = (\n\n")
    cells[JACOBIAN]["source"] += "\n).applyfunc(lambda entry: entry)\np1_position"


def expression_in_brackets(cells: Cells) -> None:
    source(cells, JACOBIAN, "p1_jacobian = ", "# my answer\n(2*")
    cells[JACOBIAN]["source"] += "\n  / 2)"


def several_answer_cells(cells: Cells) -> None:
    named_j(cells)
    cells.insert(JACOBIAN, code("J = 3", "p1.jacobian"))
    cells.append(code("J.det()", "p1.jacobian"))


def two_answers_as_text(cells: Cells) -> None:
    merged(cells)
    cells[POSITION]["cell_type"] = "raw"


def answer_moved_to_a_new_cell(cells: Cells) -> None:
    cells.append(code(cells[JACOBIAN]["source"]))
    cells[JACOBIAN]["source"] = "scratch = 5"


def as_markdown(cells: Cells) -> None:
    cells[JACOBIAN]["cell_type"] = "markdown"


def as_raw_without_metadata(cells: Cells) -> None:
    cells[JACOBIAN] = text(cells[JACOBIAN]["source"], "raw")


def as_markdown_with_prose(cells: Cells) -> None:
    cells[JACOBIAN] = text(f"My answer:\n\n```python\n{cells[JACOBIAN]['source']}\n```\nI hope it's right!")


def as_markdown_renamed(cells: Cells) -> None:
    as_markdown(cells)
    source(cells, JACOBIAN, "p1_jacobian", "J")


def as_prose(cells: Cells) -> None:
    as_markdown(cells)
    cells[JACOBIAN]["source"] = r"The Jacobian is $J = \begin{bmatrix} 1 \end{bmatrix}$, isn't it?"


def stripped(cells: Cells) -> None:
    for cell in cells:
        cell["metadata"] = {}


def helper_below(cells: Cells) -> None:
    value = cells[JACOBIAN]["source"].split("=", 1)[1]
    cells[JACOBIAN]["source"] = "p1_jacobian = helper()"
    cells.append(code(f"def helper():\n    return {value}"))


def deleted(cells: Cells) -> None:
    del cells[JACOBIAN]


def emptied(cells: Cells) -> None:
    cells[JACOBIAN]["source"] = "\n"


def first_cell_stops(cells: Cells) -> None:
    cells[SETUP]["source"] = "import numpy as np\nundefined_thing()\n" + cells[SETUP]["source"]
    source(cells, JACOBIAN, "p1_jacobian = ", "zeros(2)\np1_jacobian = ")


def first_cell_lacks_a_library(cells: Cells) -> None:
    cells[SETUP]["source"] = "import nosuchlibrary as no\n" + cells[SETUP]["source"]
    source(cells, DETERMINANT, "p1_determinant = ", "no.det\np1_determinant = ")


def library_in_an_answer(cells: Cells) -> None:
    source(cells, JACOBIAN, "p1_jacobian", "from nosuchlibrary import linalg\np1_jacobian")


def habits(cells: Cells) -> None:
    cells[SETUP]["source"] = "%matplotlib inline\nimport matplotlib.pyplot as plt\n" + cells[SETUP]["source"]
    cells[SETUP]["source"] = "from IPython.display import display, Math\n" + cells[SETUP]["source"]
    source(cells, POSITION, "p1_position", "files = !ls\nsin?\nplt.figure(); plt.show()\np1_position")
    name, value = cells[JACOBIAN]["source"].split(" = ", 1)
    cells[JACOBIAN]["source"] = f"{name} = _"
    source(cells, DETERMINANT, "p1_determinant = ", "%%time\nfrom helper import keep\np1_determinant = keep(")
    cells[DETERMINANT]["source"] += ")\ndisplay(p1_determinant)\ninput('done?')"
    cells.insert(JACOBIAN, code(value))
    cells.insert(2, code("%%writefile helper.py\ndef keep(x):\n    return x"))


def only_magic_left(cells: Cells) -> None:
    cells[JACOBIAN]["source"] = "%who"


def only_help_below_j(cells: Cells) -> None:
    source(cells, JACOBIAN, "p1_jacobian", "J")
    cells[JACOBIAN]["source"] += "\n!ls\nJ?"


def magic_named_j(cells: Cells) -> None:
    source(cells, JACOBIAN, "p1_jacobian", "%%time\nx = !ls\nJ")


def setup_deleted(cells: Cells) -> None:
    del cells[SETUP]


def merged(cells: Cells) -> None:
    source(cells, POSITION, "p1_position", cells.pop(JACOBIAN)["source"] + "\np1_position")


def magics(cells: Cells) -> None:
    cells[JACOBIAN]["source"] = "%%time\n!ls\n" + cells[JACOBIAN]["source"].replace("p1_jacobian", "J")


def tampered(part: Any, **others: Any) -> Callable[[Cells], None]:
    def change(cells: Cells) -> None:
        cells[JACOBIAN]["metadata"]["qdot"] = {"part": part, **others}

    return change


def another_parts_name(cells: Cells) -> None:
    cells[POSITION]["metadata"]["qdot"]["part"] = "p1.jacobian"
    del cells[JACOBIAN]


NO_NOTE = ""
CASES: dict[str, tuple[Callable[[Cells], None], list[str], str, str]] = {
    "duplicated, the last wrong": (
        duplicated_last_wrong,
        ["correct", "wrong", "correct"],
        "p1_jacobian is set in cells 4 and 6; its value at the end of the notebook was read",
        "differs",
    ),
    "duplicated, the last right": (
        duplicated_last_right,
        RIGHT,
        "p1_jacobian is set in cells 4 and 5; its value at the end of the notebook was",
        "",
    ),
    "duplicated, the last blank": (
        duplicated_blank,
        RIGHT,
        "p1_jacobian is left blank at the end of the notebook; its value before that was read",
        "",
    ),
    "duplicated, the last unreadable": (
        duplicated_unreadable,
        RIGHT,
        "p1_jacobian is no value that can be read (TypeError: a object is not an expr",
        "",
    ),
    "duplicated, the last stops": (
        duplicated_stops,
        RIGHT,
        "set in cells 4 and 6, and cell 6 stopped (NameError: name 'undefined_name' is not",
        "",
    ),
    "duplicated, the same": (duplicated_same, RIGHT, NO_NOTE, ""),
    "answered in another cell": (answered_in_another_cell, RIGHT, NO_NOTE, ""),
    "built step by step": (built_step_by_step, RIGHT, NO_NOTE, ""),
    "misspelt": (
        misspelt,
        RIGHT,
        "cell 4 is the answer cell of p1_jacobian and sets p1_jacobain, which was read for it",
        "",
    ),
    "misspelt, without metadata": (
        misspelt_without_metadata,
        RIGHT,
        "p1_jacobian is not set anywhere; p1_jacobain in cell 4 was read for it",
        "",
    ),
    "another name": (named_j, RIGHT, "cell 4 is the answer cell of p1_jacobian and sets J, which was read for it", ""),
    "another name, and shown": (named_j_and_shown, RIGHT, "sets J, which was read for it", ""),
    "an expression only": (
        expression_only,
        RIGHT,
        "cell 4 is the answer cell of p1_jacobian and is no assignment: its value was read for it",
        "",
    ),
    "another part's name": (
        copied_name,
        RIGHT,
        "cell 4 is the answer cell of p1_jacobian and sets p1_position, which was read for it",
        "",
    ),
    "another part's name, in brackets": (copied_name_in_brackets, RIGHT, "sets p1_position, which was read for it", ""),
    "an expression in brackets": (expression_in_brackets, RIGHT, "is no assignment: its value was read for it", ""),
    "several answer cells under another name": (
        several_answer_cells,
        RIGHT,
        "cell 5, the last of cells 4, 5 and 8, is the answer cell of p1_jacobian and sets J, which was read for it",
        "",
    ),
    "two answers in a text cell": (two_answers_as_text, RIGHT, "cell 3 is a text cell, not code; what it says was", ""),
    "the answer in a new cell": (
        answer_moved_to_a_new_cell,
        RIGHT,
        "p1_jacobian is set in cell 6, and was read there; the answer cell, cell 4, does not set it",
        "",
    ),
    "retyped to Markdown": (
        as_markdown,
        RIGHT,
        "cell 4 is a text cell, not code; what it says was read for p1_jacobian as if it were code",
        "",
    ),
    "retyped to raw, metadata lost": (as_raw_without_metadata, RIGHT, "cell 4 is a text cell, not code", ""),
    "fenced among prose": (as_markdown_with_prose, RIGHT, "cell 4 is a text cell, not code", ""),
    "retyped and renamed": (
        as_markdown_renamed,
        RIGHT,
        "cell 4 is a text cell, not code, and sets J, which was read",
        "",
    ),
    "prose": (
        as_prose,
        ["correct", "missing", "correct"],
        NO_NOTE,
        "its cell (cell 4) is text and not code, and no Python in it can be read",
    ),
    "metadata stripped": (stripped, RIGHT, NO_NOTE, ""),
    "a helper below": (
        helper_below,
        RIGHT,
        "cell 4 stopped (NameError: name 'helper' is not defined), and was run again after all other",
        "",
    ),
    "deleted": (deleted, ["correct", "missing", "correct"], NO_NOTE, "p1_jacobian is not set anywhere in the notebook"),
    "emptied": (emptied, ["correct", "missing", "correct"], NO_NOTE, "its cell does not set p1_jacobian"),
    "the set-up deleted": (setup_deleted, RIGHT, NO_NOTE, ""),
    "the set-up stops": (
        first_cell_stops,
        ["correct", "missing", "correct"],
        "cell 2 stopped at line 2, undefined_thing() (NameError: name 'undefined_thing' is not defined)",
        "its cell stopped: NameError: name 'zeros' is not defined; cell 2 stopped at line 2, undefined_thing() (",
    ),
    "the set-up lacks a library": (
        first_cell_lacks_a_library,
        ["correct", "correct", "missing"],
        "cell 2 went on without line 1, import nosuchlibrary as no (ModuleNotFoundError: No",
        "its cell stopped: NameError: name 'no' is not defined; cell 2 went on without line 1, import nosuch",
    ),
    "a library in an answer": (library_in_an_answer, RIGHT, NO_NOTE, ""),
    "habits of Jupyter": (habits, RIGHT, NO_NOTE, ""),
    "only a magic left": (only_magic_left, ["correct", "missing", "correct"], NO_NOTE, "does not set p1_jacobian"),
    "another name above magics": (only_help_below_j, RIGHT, "sets J, which was read for it", ""),
    "another name below a magic": (magic_named_j, RIGHT, "sets J, which was read for it", ""),
    "cells merged": (merged, RIGHT, NO_NOTE, ""),
    "magics, and another name": (magics, RIGHT, "sets J, which was read for it", ""),
    "a part that isn't asked": (
        tampered("p9.jacobian"),
        RIGHT,
        "cells are marked as answers to what is not asked: p9.jacobian",
        "",
    ),
    "a part that is a path": (
        tampered("../x\n"),
        RIGHT,
        "marked as answers to what is not asked: ../x\N{REPLACEMENT CHARACTER}",
        "",
    ),
    "a part that is a dictionary": (
        tampered({"a": [1]}),
        RIGHT,
        "its cells' metadata were changed, which decides nothing: part",
        "",
    ),
    "points": (tampered("p1.jacobian", points=1000), RIGHT, "metadata were changed, which decides nothing: points", ""),
    "the metadata of another part": (
        another_parts_name,
        ["correct", "missing", "correct"],
        NO_NOTE,
        "does not set p1_jacobian",
    ),
}
STUDENTS = [Student(f"s{number:02d}") for number in range(len(CASES) + 1)]


@pytest.fixture(scope="module")
def assignment(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    return a_class(tmp_path_factory.mktemp("cells") / "hw", STUDENTS)


@pytest.fixture(scope="module")
def graded(assignment: Assignment) -> dict[str, Result]:
    """Everybody's result: one student a case, and an honest one."""
    for student, (change, *_) in zip(STUDENTS, CASES.values(), strict=False):
        hand_in(assignment, f"{student.id}.ipynb", right(assignment, student.id, change))
    hand_in(assignment, f"{STUDENTS[-1].id}.ipynb", right(assignment, STUDENTS[-1].id))
    results, _ = grade(assignment)
    return {**dict(zip(CASES, results.values(), strict=False)), "honest": results[STUDENTS[-1].id]}


@pytest.mark.parametrize("case", CASES)
def test_every_answer_that_is_there_is_read(graded: dict[str, Result], case: str) -> None:
    _, due, said, reason = CASES[case]
    result = graded[case]
    assert outcomes(result) == due, reasons(result)
    assert (result["score"], result["max_score"]) == (sum((1, 2, 1)[k] for k in range(3) if due[k] == "correct"), 4)
    told = [*result["notes"], *(result["staff_notes"] if "metadata" in said or "marked" in said else ())]
    assert any(said in note for note in told) if said else not result["staff_notes"], result["staff_notes"]
    assert any(reason in one for one in reasons(result)), reasons(result)


def test_a_fellow_student_is_graded_as_ever(graded: dict[str, Result]) -> None:
    assert outcomes(graded["honest"]) == RIGHT and not graded["honest"]["staff_notes"]


# --- random edits ---


def duplicate(cells: Cells, rng: random.Random) -> None:
    cells.insert(rng.randrange(len(cells) + 1), deepcopy(rng.choice(cells)))


def delete(cells: Cells, rng: random.Random) -> None:
    del cells[rng.randrange(len(cells))]


def reorder(cells: Cells, rng: random.Random) -> None:
    cells.insert(rng.randrange(len(cells)), cells.pop(rng.randrange(len(cells))))


def strip(cells: Cells, rng: random.Random) -> None:
    rng.choice(cells)["metadata"] = {}


def retype(cells: Cells, rng: random.Random) -> None:
    rng.choice(cells)["cell_type"] = rng.choice(["code", "markdown", "raw"])


def rename(cells: Cells, rng: random.Random) -> None:
    cell = rng.choice(cells)
    cell["source"] = re.sub(r"^p1_\w+ =", rng.choice(["J =", "p1_answer =", "P1_Jacobian ="]), cell["source"])


def downgrade(text_of_notebook: dict[str, Any], rng: random.Random) -> dict[str, Any]:
    """Return a notebook as versions 3 and 4.0 have it."""
    if rng.random() < 0.5:
        return {**text_of_notebook, "nbformat_minor": 0}
    cells = [
        {**cell, "input": cell["source"]} if cell["cell_type"] == "code" else cell for cell in text_of_notebook["cells"]
    ]
    for cell in cells:
        if cell["cell_type"] == "code":
            cell.pop("source")
    return {"metadata": {}, "nbformat": 3, "nbformat_minor": 0, "worksheets": [{"cells": cells, "metadata": {}}]}


@pytest.fixture(scope="module")
def sandbox() -> Any:
    with Sandbox(Limits(seconds=20, cell_seconds=4)) as made:
        yield made


@settings(max_examples=40)
@given(seed=st.integers(0, 10**9))
def test_no_edit_loses_an_answer_silently(assignment: Assignment, sandbox: Sandbox, seed: int) -> None:
    import json

    rng = random.Random(seed)
    cells = right_cells(assignment, "s00")
    due = {part: cells[place]["source"] for part, place in zip(PARTS, (POSITION, JACOBIAN, DETERMINANT), strict=True)}
    untouched = find_answers(
        [Cell(cell["source"], is_code=cell["cell_type"] == "code") for cell in cells], PARTS, sandbox.run
    )
    for _ in range(rng.randrange(1, 5)):
        if cells:
            rng.choice([duplicate, delete, reorder, strip, retype, rename])(cells, rng)
    edited = downgrade(json.loads(notebook(assignment, "s00", cells)), rng)
    found = find_answers(read_cells("hw.ipynb", json.dumps(edited).encode()).cells, PARTS, sandbox.run)
    for part in due:
        name = variable(*part.split("."))
        told = any(name in note for note in found.notes) or found.reasons.get(name)
        assert found.run.answers.get(name) == untouched.run.answers[name] or told, (cells, found.notes)


def test_a_cell_that_is_run_again_changes_nothing_that_was_read(sandbox: Sandbox) -> None:
    cells = [
        Cell("p1_a = [1]; later.append(p1_a)", "p1.a"),
        Cell("p1_b = late"),
        Cell("later = []; late = 5; p1_a.append(2)"),
    ]
    found = find_answers(cells, ["p1.a", "p1.b"], sandbox.run)
    assert found.run.answers == {"p1_a": "[1, 2]", "p1_b": "5"}
    assert "; ".join(found.notes) == (
        "cell 2 stopped (NameError: name 'late' is not defined), and was run again after all other cells, "
        "which gave p1_b"
    )


def test_the_cell_that_was_to_make_a_name_is_told(sandbox: Sandbox) -> None:
    cells = [
        Cell("1/0"),
        Cell("x = 1\nimport nosuchlibrary as no"),
        Cell("p1_a = no.det", "p1.a"),
        Cell("p1_b = lost", "p1.b"),
        Cell("import scipy_not_here.linalg as la\np1_c = la.norm([1, 2])", "p1.c"),
        Cell("p1_d = 0.5^2", "p1.d"),
        Cell("p1_e = 90\u00b0", "p1.e"),
    ]
    reasons = find_answers(cells, ["p1.a", "p1.b", "p1.c", "p1.d", "p1.e"], sandbox.run).reasons
    assert reasons["p1_d"].endswith(
        "; in Python, a power is written **, as in a1**2; or put the answer into quotes, as text"
    )
    assert reasons["p1_e"].endswith("; put an answer with such a character into quotes, as text")
    assert reasons["p1_c"].startswith("its cell stopped: NameError: name 'la' is not defined; cell 5 went on without ")
    assert "line 1, import scipy_not_here.linalg as la (ModuleNotFoundError: No module named" in reasons["p1_c"]
    assert "; cell 2 went on without line 2, import nosuchlibrary as no (Module" in reasons["p1_a"]
    assert reasons["p1_b"].endswith("; cell 1 stopped at line 1, 1/0 (ZeroDivisionError: division by zero)")


def test_every_cell_that_was_refused_something_is_told_to_the_staff(sandbox: Sandbox) -> None:
    cells = [
        Cell("p1_a = 1", "p1.a"),
        Cell("secret = open('/etc/passwd').read()"),
        Cell("x = 1/0"),
        Cell("import os\nos.system('ls')"),
    ]
    found = find_answers(cells, ["p1.a"], sandbox.run)
    assert [told.split(" (")[0] for told in found.refused] == [
        "cell 2 stopped at line 1, secret = open('/etc/passwd').read()",
        "cell 4 stopped at line 2, os.system('ls')",
    ]
    assert find_answers([Cell("p1_a = 1", "p1.a"), Cell("x = 1/0")], ["p1.a"], sandbox.run).refused == []


def test_what_is_deep_or_long_is_run_though_it_is_not_looked_into(sandbox: Sandbox) -> None:
    deep = "p1_a = " + "(" * 5000 + "1" + ")" * 5000
    long = "p1_b = " + " + ".join(["x"] * 20_000) + "\n"
    cells = [
        Cell("from sympy import *; x = Symbol('x')"),
        Cell(deep, "p1.a"),
        Cell(long),
        Cell("# " + "x" * 10**6 + "\np1_c = 3", "p1.c"),
    ]
    found = find_answers(cells, ["p1.a", "p1.b", "p1.c"], sandbox.run)
    assert found.run.answers.get("p1_c") == "3"
    blank = [Cell("\n" * 10**6 + "x", "p1.a"), Cell(" " * 10**6 + "p1_b", "p1.b", is_code=False)]
    blank += [Cell("\n" * 29_000 + "(", "p1.a"), Cell("p1_c" + " " * 29_000 + "(", "p1.c")]
    blank += [Cell("=".join(f"p1_a{n}" for n in range(3000)) + "=1") for _ in range(50)]
    blank += [Cell("p1_b = (\n" * 100, is_code=False)] * 10_000
    begun = time.process_time()
    find_answers(blank, ["p1.a", "p1.b", "p1.c"], lambda cells, names: Run())
    assert asked_in(blank, ["a", "c"]) == ["p1.a", "p1.b", "p1.c"]
    assert time.process_time() - begun < 20
    assert "its cell stopped" in found.reasons["p1_a"]


@pytest.mark.parametrize("change", [first_cell_stops, first_cell_lacks_a_library, habits])
def test_a_student_is_told_beforehand_what_the_first_cell_lacks(
    assignment: Assignment, tmp_path: Path, change: Callable[[Cells], None]
) -> None:
    """`qdot check` knows the symbols of the problem by what the notebook says of them."""
    path = tmp_path / "hw.ipynb"
    path.write_text(right(assignment, "s00", change))
    checked = check_notebook(path)
    missing = [row.said for row in checked.rows if not row.readable]
    if change is habits:
        assert (missing, checked.notes) == ([], ())
    else:
        (note,), (said,) = checked.notes, missing
        assert note.startswith("cell 2 ") and said.endswith(note) and "NameError" in said


def test_what_a_notebook_claims_of_its_symbols_is_no_code(assignment: Assignment, tmp_path: Path) -> None:
    cells = right_cells(assignment, "s00")
    del cells[SETUP]
    claims = {"p1": ["x; open('/etc/passwd')", "if", 5, "theta1\n"], "p2": "a1", "p3": ["theta2", "x" * 10**6]}
    book = notebook(assignment, "s00", cells, metadata={"qdot": {"symbols": claims}})
    (tmp_path / "hw.ipynb").write_text(book)
    rows = check_notebook(tmp_path / "hw.ipynb").rows
    assert all(row.said.startswith("its cell stopped: NameError: name 'a1' is not defined") for row in rows)


def test_the_program_says_the_same_to_a_student(assignment: Assignment, tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from grader.cli import app

    path = tmp_path / "hw (1).ipynb"
    path.write_text(right(assignment, "s00", named_j))
    said = CliRunner().invoke(app, ["check", str(path)])
    assert said.exit_code == 0
    assert "note: cell 4 is the answer cell of p1_jacobian and sets J, which was read for it" in said.output
    assert "ok  p1.jacobian: 2 x 2 matrix" in said.output
    script = tmp_path / "hw.py"
    script.write_text("\n\n".join(cell["source"] for cell in right_cells(assignment, "s00")[1:]))
    said = CliRunner().invoke(app, ["check", str(script)])
    assert "note: hw.py is no .ipynb file: it is a Python script, which was read as a notebook" in said.output
    assert "3 of 3 answers can be read" in said.output


# --- symbols that became numbers ---

ABOUT_SYMBOLS = "puts a number in the place of the symbol"
BEFORE = "from sympy import *\ntheta1, theta2, a1, a2 = symbols('theta1 theta2 a1 a2')"
RIGHT_ONE = "p1_determinant = a1*a2*sin(theta2)"


@pytest.mark.parametrize(
    ("written", "told"),
    [
        (["theta2 = 0.5", RIGHT_ONE], "theta2 = 0.5 in cell 2"),
        (["theta2 = pi/2", RIGHT_ONE], ""),  # no number that one forgets: the answer shows it
        ([f"theta2 = 1\n{RIGHT_ONE}"], "theta2 = 1 in cell 2"),
        (["t2 = theta2", "t2 = Rational(1, 3)", "p1_determinant = a1*a2*sin(t2)"], "t2 = 1/3 in cell 3"),
        ([RIGHT_ONE, "theta2 = 0.5"], ""),
        ([f"{RIGHT_ONE}\ntheta2 = 0.5\np1_determinant.subs('theta2', theta2)"], ""),
        (["theta2 = 0.5", f"theta2 = symbols('theta2')\n{RIGHT_ONE}"], ""),
        (["for theta2 in (0.1, 0.2): pass", "p1_determinant = 'a1*a2*s2'"], ""),
    ],
)
def test_a_symbol_that_became_a_number_is_told(sandbox: Sandbox, written: list[str], told: str) -> None:
    cells = [Cell(source, is_code=True) for source in (BEFORE, *written)]
    notes = find_answers(cells, ["p1.determinant"], sandbox.run).notes
    assert [note for note in notes if ABOUT_SYMBOLS in note] == [note for note in notes if told and told in note]
    assert bool(notes) == bool(told), notes
