"""Notebooks as students edit them: every answer that is there is read, and what was ambiguous is said."""

import random
import re
import time
from collections.abc import Callable, Iterable
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.problem.problem import name_answer_variable
from qdot.grader.grading.check import check_notebook
from qdot.grader.grading.result import Result
from qdot.grader.sandbox.sandbox import Limits, Run, Sandbox
from qdot.grader.submissions.answer_locator import find_answers, guess_parts
from qdot.grader.submissions.cells import Cell, read_cells
from tests.support.command import run
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
from tests.support.suites import sample_for_suite, select_for_suite

SETUP, POSITION, JACOBIAN, DETERMINANT = 1, 2, 3, 4
"""Places of cells; people count from 1."""


def source(cells: Cells, place: int, old: str, new: str) -> None:
    assert old in cells[place]["source"]
    cells[place]["source"] = cells[place]["source"].replace(old, new)


Change = Callable[[Cells], object]


def edited(place: int, old: str, new: str) -> Change:
    return lambda cells: source(cells, place, old, new)


def named(name: str) -> Change:
    return edited(JACOBIAN, "p1_jacobian", name)


def written(code_of_cell: str) -> Change:
    return lambda cells: cells[JACOBIAN].update(source=code_of_cell)


def added(code_of_cell: str, part: str | None = None, place: int | None = None) -> Change:
    return lambda cells: cells.insert(len(cells) if place is None else place, code_cell(code_of_cell, part))


def all_of(*changes: Change) -> Change:
    return lambda cells: [change(cells) for change in changes]


def tampered(part: Any, **others: Any) -> Change:
    return lambda cells: cells[JACOBIAN]["metadata"].update(qdot={"part": part, **others})


def as_markdown_with_prose(cells: Cells) -> None:
    cells[JACOBIAN] = text_cell(f"My answer:\n\n```python\n{cells[JACOBIAN]['source']}\n```\nI hope it's right!")


def built_step_by_step(cells: Cells) -> None:
    value = cells[JACOBIAN]["source"].split("=", 1)[1]
    cells[JACOBIAN]["source"] = "p1_jacobian = zeros(2, 2)"
    cells.append(code_cell(f"for i in range(4):\n    p1_jacobian[i] = ({value})[i]"))


def copied_name_in_brackets(cells: Cells) -> None:
    source(cells, JACOBIAN, "p1_jacobian = ", "θ = 'ä'; p1_position = (\n\n")
    cells[JACOBIAN]["source"] += "\n).applyfunc(lambda entry: entry)\np1_position"


def expression_in_brackets(cells: Cells) -> None:
    source(cells, JACOBIAN, "p1_jacobian = ", "# my answer\n(2*")
    cells[JACOBIAN]["source"] += "\n  / 2)"


def named_j_and_shown(cells: Cells) -> None:
    source(cells, JACOBIAN, "p1_jacobian = ", "A = 3; θ = 1; J = ")
    cells[JACOBIAN]["source"] += "\nprint(J)\nJ.shape"


def answer_moved_to_a_new_cell(cells: Cells) -> None:
    cells.append(code_cell(cells[JACOBIAN]["source"]))
    cells[JACOBIAN]["source"] = "scratch = 5"


def helper_below(cells: Cells) -> None:
    value = cells[JACOBIAN]["source"].split("=", 1)[1]
    cells[JACOBIAN]["source"] = "p1_jacobian = helper()"
    cells.append(code_cell(f"def helper():\n    return {value}"))


def first_cell_stops(cells: Cells) -> None:
    cells[SETUP]["source"] = "import numpy as np\nundefined_thing()\n" + cells[SETUP]["source"]
    source(cells, JACOBIAN, "p1_jacobian = ", "zeros(2)\np1_jacobian = ")


def first_cell_lacks_a_library(cells: Cells) -> None:
    cells[SETUP]["source"] = "import nosuchlibrary as no\n" + cells[SETUP]["source"]
    source(cells, DETERMINANT, "p1_determinant = ", "no.det\np1_determinant = ")


def habits(cells: Cells) -> None:
    cells[SETUP]["source"] = "%matplotlib inline\nimport matplotlib.pyplot as plt\n" + cells[SETUP]["source"]
    cells[SETUP]["source"] = "from IPython.display import display, Math\n" + cells[SETUP]["source"]
    source(cells, POSITION, "p1_position", "files = !ls\nsin?\nplt.figure(); plt.show()\np1_position")
    name, value = cells[JACOBIAN]["source"].split(" = ", 1)
    cells[JACOBIAN]["source"] = f"{name} = _"
    source(cells, DETERMINANT, "p1_determinant = ", "%%time\nfrom helper import keep\np1_determinant = keep(")
    cells[DETERMINANT]["source"] += ")\ndisplay(p1_determinant)\ninput('done?')"
    cells.insert(JACOBIAN, code_cell(value))
    cells.insert(2, code_cell("%%writefile helper.py\ndef keep(x):\n    return x"))


def only_help_below_j(cells: Cells) -> None:
    source(cells, JACOBIAN, "p1_jacobian", "J")
    cells[JACOBIAN]["source"] += "\n!ls\nJ?"


def merged(cells: Cells) -> None:
    source(cells, POSITION, "p1_position", cells.pop(JACOBIAN)["source"] + "\np1_position")


def another_parts_name(cells: Cells) -> None:
    cells[POSITION]["metadata"]["qdot"]["part"] = "p1.jacobian"
    del cells[JACOBIAN]


ZEROS, ANSWER = "p1_jacobian = Matrix([[0, 0], [0, 0]])", "p1.jacobian"
BLANK = "p1_jacobian = Matrix([[blank, blank], [blank, blank]])"
PROSE = r"The Jacobian is $J = \begin{bmatrix} 1 \end{bmatrix}$, isn't it?"
unmarked: Change = lambda cells: cells[JACOBIAN]["metadata"].pop("qdot")  # noqa: E731
as_markdown: Change = lambda cells: cells[JACOBIAN].update(cell_type="markdown")  # noqa: E731
named_j = all_of(named("J"), added("J = 5"))
several_answer_cells = all_of(named_j, added("J = 3", ANSWER, JACOBIAN), added("J.det()", ANSWER))
WRONG, MISSING = ["correct", "wrong", "correct"], ["correct", "missing", "correct"]
CASES: dict[str, tuple[Change, list[str], str, str]] = {
    "duplicated, the last wrong": (added(ZEROS, ANSWER), WRONG, "p1_jacobian cells 4 and 6", "(1, 1)"),
    "duplicated, the last right": (added(ZEROS, ANSWER, JACOBIAN), ALL_CORRECT, "p1_jacobian cells 4 and 5", ""),
    "duplicated, the last blank": (added(BLANK, ANSWER), ALL_CORRECT, "p1_jacobian blank", ""),
    "duplicated, the last unreadable": (
        added("p1_jacobian = lambda: p1_jacobian\np1_jacobian = object()", ANSWER),
        ALL_CORRECT, "p1_jacobian TypeError:", "",
    ),
    "duplicated, the last stops": (
        added("p1_jacobian = undefined_name", ANSWER), ALL_CORRECT, "cells 4 and 6 NameError: 'undefined_name'", "",
    ),
    "duplicated, the same": (lambda cells: cells.append(deepcopy(cells[JACOBIAN])), ALL_CORRECT, "", ""),
    "answered in another cell": (
        all_of(unmarked, lambda cells: cells.insert(2, text_cell("some text"))), ALL_CORRECT, "", "",
    ),
    "built step by step": (built_step_by_step, ALL_CORRECT, "", ""),
    "misspelt": (named("p1_jacobain"), ALL_CORRECT, "cell 4 p1_jacobian p1_jacobain", ""),
    "misspelt, without metadata": (
        all_of(named("p1_jacobain"), unmarked), ALL_CORRECT, "cell 4 p1_jacobian p1_jacobain", "",
    ),
    "another name": (
        named_j,
        ALL_CORRECT, "cell 4 is the answer cell of p1_jacobian and sets J, not p1_jacobian; qdot used its value", "",
    ),
    "another name, and shown": (named_j_and_shown, ALL_CORRECT, "p1_jacobian J,", ""),
    "an expression only": (edited(JACOBIAN, "p1_jacobian = ", ""), ALL_CORRECT, "cell 4 p1_jacobian", ""),
    "another part's name": (named("p1_position"), ALL_CORRECT, "cell 4 p1_jacobian p1_position", ""),
    "another part's name, in brackets": (copied_name_in_brackets, ALL_CORRECT, "p1_jacobian p1_position", ""),
    "an expression in brackets": (expression_in_brackets, ALL_CORRECT, "cell 4 p1_jacobian", ""),
    "several answer cells under another name": (several_answer_cells, ALL_CORRECT, "4, 5 8 p1_jacobian J,", ""),
    "two answers in a text cell": (
        all_of(merged, lambda cells: cells[POSITION].update(cell_type="raw")), ALL_CORRECT, "cell 3", "",
    ),
    "the answer in a new cell": (answer_moved_to_a_new_cell, ALL_CORRECT, "p1_jacobian cell 6 cell 4", ""),
    "retyped to Markdown": (as_markdown, ALL_CORRECT, "cell 4 p1_jacobian", ""),
    "retyped to Markdown, metadata lost": (all_of(as_markdown, unmarked), ALL_CORRECT, "cell 4 text", ""),
    "fenced among prose": (as_markdown_with_prose, ALL_CORRECT, "cell 4 text", ""),
    "retyped and renamed": (all_of(as_markdown, named("J")), ALL_CORRECT, "cell 4 text J,", ""),
    "prose": (all_of(as_markdown, written(PROSE)), MISSING, "", "cell 4 text"),
    "metadata stripped": (lambda cells: [cell.update(metadata={}) for cell in cells], ALL_CORRECT, "", ""),
    "a helper below": (helper_below, ALL_CORRECT, "cell 4 NameError: 'helper'", ""),
    "deleted": (lambda cells: cells.pop(JACOBIAN), MISSING, "", "p1_jacobian"),
    "emptied": (written("\n"), MISSING, "", "p1_jacobian"),
    "the set-up deleted": (lambda cells: cells.pop(SETUP), ALL_CORRECT, "", ""),
    "the set-up stops": (
        first_cell_stops, MISSING, "cell 2 line 2, undefined_thing() (NameError:", "'zeros' cell 2 undefined_thing() (",
    ),
    "the set-up lacks a library": (
        first_cell_lacks_a_library, ["correct", "correct", "missing"],
        "cell 2 line 1, import nosuchlibrary as no (ModuleNotFoundError:", "'no' cell 2 line 1, nosuchlibrary",
    ),
    "answers from the last to the first": (
        lambda cells: cells.extend(cells.pop(k) for k in (4, 3, 2)), ALL_CORRECT, "", "",
    ),
    "forged, and wrong": (
        all_of(written("p1_jacobian = 0"), tampered(ANSWER, points=1000, reference="0")), WRONG, "metadata points", "",
    ),
    "a library in an answer": (
        edited(JACOBIAN, "p1_jacobian", "from nosuchlibrary import linalg\np1_jacobian"), ALL_CORRECT, "", "",
    ),
    "habits of Jupyter": (habits, ALL_CORRECT, "", ""),
    "only a magic left": (written("%who"), MISSING, "", "p1_jacobian"),
    "another name above magics": (only_help_below_j, ALL_CORRECT, "p1_jacobian J,", ""),
    "another name below a magic": (named("%%time\nx = !ls\nJ"), ALL_CORRECT, "p1_jacobian J,", ""),
    "another name below two magics": (named("%%time\n!ls\nJ"), ALL_CORRECT, "p1_jacobian J,", ""),
    "the process ended": (added("import os; os._exit(0)"), ALL_CORRECT, "cell 6", ""),
    "cells merged": (merged, ALL_CORRECT, "", ""),
    "a part that isn't asked": (tampered("p9.jacobian"), ALL_CORRECT, "marked p9.jacobian", ""),
    "a part that is a path": (tampered("../x\n"), ALL_CORRECT, "marked ../x\N{REPLACEMENT CHARACTER}", ""),
    "a part that is a dictionary": (tampered({"a": [1]}), ALL_CORRECT, "metadata part", ""),
    "points": (tampered("p1.jacobian", points=1000), ALL_CORRECT, "metadata points", ""),
    "the metadata of another part": (another_parts_name, MISSING, "", "p1_jacobian"),
}  # fmt: skip
"""What is changed, what the three parts get, and the words that one note and one reason have to have."""
STUDENTS = [Student(f"s{number:02d}") for number in range(len(CASES) + 1)]


@pytest.fixture(scope="module")
def assignment(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    return make_class(tmp_path_factory.mktemp("cells") / "hw", STUDENTS)


@pytest.fixture(scope="module")
def graded(assignment: Assignment) -> dict[str, Result]:
    """Everybody's result: one student a case, and an honest one."""
    for student, (change, *_) in zip(STUDENTS, CASES.values(), strict=False):
        submit(assignment, f"{student.id}.ipynb", make_correct_notebook(assignment, student.id, change))
    submit(assignment, f"{STUDENTS[-1].id}.ipynb", make_correct_notebook(assignment, STUDENTS[-1].id))
    results, _ = grade(assignment)
    return {**dict(zip(CASES, results.values(), strict=False)), "honest": results[STUDENTS[-1].id]}


@pytest.mark.parametrize("case", CASES)
def test_every_answer_that_is_there_is_read(graded: dict[str, Result], case: str) -> None:
    _, due, note, reason = CASES[case]
    result, honest = graded[case], graded["honest"]
    assert list_outcomes(honest) == ALL_CORRECT and not honest.staff_notes  # a fellow student is graded as ever
    assert list_outcomes(result) == due, list_reasons(result)
    assert (result.score, result.max_score) == (sum((1, 2, 1)[k] for k in range(3) if due[k] == "correct"), 4)
    staff = result.staff_notes if "metadata" in note or "marked" in note else ()
    assert has_words((*result.notes, *staff), note) if note else not result.staff_notes, result.staff_notes
    assert has_words(list_reasons(result), reason), list_reasons(result)


def has_words(texts: Iterable[str], words: str) -> bool:
    """Return whether all these words are in one of some texts."""
    return any(all(word in each for word in words.split()) for each in texts)


# --- random edits ---


def rename(cells: Cells, rng: random.Random) -> None:
    cell = rng.choice(cells)
    cell["source"] = re.sub(r"^p1_\w+ =", rng.choice(["J =", "p1_answer =", "P1_Jacobian ="]), cell["source"])


EDITS: list[Callable[[Cells, random.Random], object]] = [
    lambda cells, rng: cells.insert(rng.randrange(len(cells) + 1), deepcopy(rng.choice(cells))),
    lambda cells, rng: cells.pop(rng.randrange(len(cells))),
    lambda cells, rng: cells.insert(rng.randrange(len(cells)), cells.pop(rng.randrange(len(cells)))),
    lambda cells, rng: rng.choice(cells).update(metadata={}),
    lambda cells, rng: rng.choice(cells).update(cell_type=rng.choice(["code", "markdown", "raw"])),
    rename,
]


@pytest.fixture(scope="module")
def sandbox() -> Any:
    with Sandbox(Limits(seconds=20, cell_seconds=4)) as made:
        yield made


@settings(max_examples=select_for_suite(20, 200))
@given(seed=st.integers(0, 10**9))
def test_no_edit_loses_an_answer_silently(assignment: Assignment, sandbox: Sandbox, seed: int) -> None:
    rng = random.Random(seed)
    cells = make_correct_cells(assignment, "s00")
    due = {part: cells[place]["source"] for part, place in zip(PARTS, (POSITION, JACOBIAN, DETERMINANT), strict=True)}
    untouched = find_answers(
        [Cell(cell["source"], is_code=cell["cell_type"] == "code") for cell in cells], PARTS, sandbox.run
    )
    for _ in range(rng.randrange(1, 5)):
        if cells:
            rng.choice(EDITS)(cells, rng)
    edited = write_notebook(assignment, "s00", cells)
    found = find_answers(read_cells("hw.ipynb", edited.encode()).cells, PARTS, sandbox.run)
    for part in due:
        name = name_answer_variable(*part.split("."))
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
    assert len(found.notes) == 1 and has_words(found.notes, "cell 2 NameError: 'late' p1_b")


def test_the_cell_that_was_to_make_a_name_is_told(sandbox: Sandbox) -> None:
    cells = [
        Cell("1/0\nlost = 1"),
        Cell("x = 1\nimport nosuchlibrary as no"),
        Cell("p1_a = no.det", "p1.a"),
        Cell("p1_b = lost", "p1.b"),
        Cell("import scipy_not_here.linalg as la\np1_c = la.norm([1, 2])", "p1.c"),
        Cell("p1_d = 0.5^2", "p1.d"),
        Cell("p1_e = 90\u00b0", "p1.e"),
        Cell("p1_f = never_set", "p1.f"),
        Cell("p1_g = Cos(0)", "p1.g"),
        Cell("p1_h = p1_loss", "p1.h"),
        Cell("p1_i = [x = 0]", "p1.i"),
        Cell("p1_j = [x x]", "p1.j"),
    ]
    reasons = find_answers(cells, [f"p1.{letter}" for letter in "abcdefghij"], sandbox.run).reasons
    for name, words in {
        "p1_a": "'no' cell 2 line 2, nosuchlibrary as no (ModuleNotFoundError:",
        "p1_b": "'lost' cell 1 line 1, 1/0 (ZeroDivisionError:",
        "p1_c": "NameError: 'la' cell 5 line 1, import scipy_not_here.linalg as la (ModuleNotFoundError:",
        "p1_d": "a1**2; quotes",
        "p1_e": "quotes",
        "p1_f": "no cell above sets never_set; restart the kernel",
        "p1_g": "write cos",
        "p1_h": "no cell above sets p1_loss",
        "p1_i": "write an equation as Eq(theta2, 0)",
        "p1_j": "comma or a multiplication sign (*)",
    }.items():
        assert has_words([reasons[name]], words), reasons[name]
        assert ("cell 1" in reasons[name]) == (name == "p1_b"), "a cell that does not set the name is no cause"
        assert "':='" not in reasons[name] and "?" not in reasons[name]


def test_every_cell_that_was_refused_something_is_told_to_the_staff(sandbox: Sandbox) -> None:
    cells = [
        Cell("p1_a = 1", "p1.a"),
        Cell("secret = open('/etc/passwd').read()"),
        Cell("x = 1/0"),
        Cell("import os\nos.system('ls')"),
    ]
    found = find_answers(cells, ["p1.a"], sandbox.run)
    assert [told.split(" (")[0] for told in found.forbidden_stops] == [
        "cell 2 stopped at line 1, secret = open('/etc/passwd').read()",
        "cell 4 stopped at line 2, os.system('ls')",
    ]
    assert find_answers([Cell("p1_a = 1", "p1.a"), Cell("x = 1/0")], ["p1.a"], sandbox.run).forbidden_stops == []


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
    assert guess_parts(blank, ["a", "c"]) == ["p1.a", "p1.b", "p1.c"]
    assert time.process_time() - begun < 20
    assert "the cell with this answer stopped" in found.reasons["p1_a"]


@pytest.mark.parametrize("change", sample_for_suite([first_cell_stops, first_cell_lacks_a_library, habits], 2))
def test_a_student_is_told_beforehand_what_the_first_cell_lacks(
    assignment: Assignment, tmp_path: Path, change: Change
) -> None:
    """`qdot check` knows the symbols of the problem by what the notebook says of them."""
    (tmp_path / "hw.ipynb").write_text(make_correct_notebook(assignment, "s00", change))
    checked = check_notebook(tmp_path / "hw.ipynb")
    missing = [row.message for row in checked.rows if not row.is_readable]
    assert len(missing) == len(checked.notes) == (change is not habits)
    for note, said in zip(checked.notes, missing, strict=True):
        assert note.startswith("cell 2 ") and said.endswith(note) and "NameError" in said


def test_what_a_notebook_claims_of_its_symbols_is_no_code(assignment: Assignment, tmp_path: Path) -> None:
    cells = make_correct_cells(assignment, "s00")
    del cells[SETUP]
    claims = {"p1": ["x; open('/etc/passwd')", "if", 5, "theta1\n"], "p2": "a1", "p3": ["theta2", "x" * 10**6]}
    book = write_notebook(assignment, "s00", cells, metadata={"qdot": {"symbols": claims}})
    (tmp_path / "hw.ipynb").write_text(book)
    rows = check_notebook(tmp_path / "hw.ipynb").rows
    cause = r"\(NameError: name 'a1' is not defined\); no cell above sets a1"
    beginning = rf"the cell with this answer stopped at line \d+, .* {cause}"
    assert all(re.match(beginning, row.message, re.DOTALL) for row in rows), rows


def test_the_program_says_the_same_to_a_student(assignment: Assignment, tmp_path: Path) -> None:
    (tmp_path / "hw (1).ipynb").write_text(make_correct_notebook(assignment, "s00", named_j))
    printed = run("check", tmp_path / "hw (1).ipynb")
    assert has_words(printed.splitlines(), "note: cell 4 p1_jacobian J,")
    assert "ok  p1.jacobian: 2 × 2 matrix" in printed
    (tmp_path / "hw.py").write_text("\n\n".join(cell["source"] for cell in make_correct_cells(assignment, "s00")[1:]))
    printed = run("check", tmp_path / "hw.py")
    assert "note: hw.py" in printed and "3 of 3 answers can be read" in printed


# --- symbols that became numbers ---

ABOUT_SYMBOLS = "replaces the symbol by a number"
BEFORE = "from sympy import *\ntheta1, theta2, a1, a2 = symbols('theta1 theta2 a1 a2')"
RIGHT_ONE = "p1_determinant = a1*a2*sin(theta2)"


@pytest.mark.parametrize(
    ("written", "told"),
    [
        (["theta2 = 0.5", RIGHT_ONE], "theta2 = 0.5 in cell 2"),
        (["theta2 = pi/2", RIGHT_ONE], "theta2 = pi/2 in cell 2"),
        (["for theta2 in [0, pi]: pass", "p1_determinant = {theta2: [0, pi]}"], "theta2 = pi in cell 2"),
        (["p1_determinant = []\nfor theta2 in [0, pi]: p1_determinant.append(Eq(theta2, 0))"], "theta2 = pi in cell 2"),
        (["print([theta2 for theta2 in [0, pi]])", RIGHT_ONE], ""),
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
