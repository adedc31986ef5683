"""The notebook's own self-checks are left out at grading where that can't change an answer, and only there."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest
from nbformat import NotebookNode

from qdot.exercises.generation import generate
from qdot.exercises.notebook.notebook import make_solution_notebook, make_student_notebook, write_notebook
from qdot.exercises.notebook.self_check import SELF_CHECK, Problems
from qdot.grader.sandbox.sandbox import Sandbox
from qdot.grader.submissions.cells import Cell, empty_self_checks, read_cells
from tests.support.problems import get_problem, select_parts
from tests.support.suites import few_families, sample_for_suite


def slotted(family: str) -> Problems:
    """A problem of the family, and one whose notebook has a self-check in any case."""
    problem = get_problem(family, 0)
    own = replace(problem, parts=tuple(sample_for_suite(select_parts(problem), 10)))
    return [("p1", own), ("p2", generate("planar-2r/0", ["position", "jacobian", "determinant"]))]


def cells_of(problems: Problems, made: Callable[..., NotebookNode] = make_solution_notebook) -> list[Cell]:
    text = write_notebook(made("Title", "hw", "s1", problems))
    return list(read_cells("hw.ipynb", text.encode()).cells)


def code(cells: Sequence[Cell]) -> list[str]:
    return [cell.source for cell in cells if cell.is_code]


@few_families
@pytest.mark.parametrize("made", [make_student_notebook, make_solution_notebook])
def test_only_checks_are_left_out(family: str, made: Callable[..., NotebookNode]) -> None:
    """Of the students' notebook, whose text explains them, too."""
    problems = slotted(family)
    cells = cells_of(problems, made)
    left = empty_self_checks(cells, problems)
    changed = [before for before, after in zip(cells, left, strict=True) if before != after]
    assert len(changed) > 1 and all(SELF_CHECK in cell.source for cell in changed)
    assert not any(SELF_CHECK in source for source in code(left))
    assert len(left) == len(cells) and [each for each in left if each.source] == [c for c in cells if c not in changed]


def test_answers_are_what_they_are_with_all_cells(sandbox: Sandbox) -> None:
    problems = slotted("planar-2r")[:1]
    cells = cells_of(problems)
    names = [f"{slot}_{part.name.replace('-', '_')}" for slot, problem in problems for part in problem.parts]
    whole, left = (sandbox.run(code(each), names) for each in (cells, empty_self_checks(cells, problems)))
    assert whole.answers == left.answers and set(left.answers) == set(names)
    assert not left.cell_errors and not left.unreadable_reasons


@pytest.mark.parametrize(
    "added",
    [
        "self_check = print", "def self_check(*given):\n    global p1_jacobian", "from my_tools import self_check",
        "self_check('p1', '', lambda at: at(p1_position), lambda at: at.slope(p1_jacobian))", "%run self_check.py",
    ],
)  # fmt: skip
def test_where_anything_else_speaks_of_it_all_is_run(added: str) -> None:
    problems = slotted("planar-2r")
    cells = [*cells_of(problems), Cell(added)]
    assert empty_self_checks(cells, problems) == cells


def test_a_function_or_a_call_that_was_changed_is_run() -> None:
    problems = slotted("planar-2r")
    cells = cells_of(problems)
    place = next(n for n, cell in enumerate(cells) if "def self_check" in cell.source)
    for old, new in (("random", "chance"), ("1e-5", "1e-6"), ("def self_check(", "def own_self_check(")):
        changed = [*cells]
        changed[place] = Cell(cells[place].source.replace(old, new))
        assert empty_self_checks(changed, problems) == changed
    last = max(n for n, cell in enumerate(cells) if SELF_CHECK in cell.source)
    changed = [*cells]
    changed[last] = Cell(cells[last].source + "\np2_jacobian = p2_jacobian.T")
    assert empty_self_checks(changed, problems) == changed
    quoted = [Cell(cell.source, is_code=False) for cell in cells]
    assert empty_self_checks(quoted, problems) == quoted, "text that quotes a check stays text"
