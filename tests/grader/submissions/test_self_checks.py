"""Grading skips a notebook's self-checks only if that can't change an answer."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest
from nbformat import NotebookNode

from qdot.exercises.generation import generate
from qdot.exercises.notebook.notebook import (
    NotebookContent,
    make_solution_notebook,
    make_student_notebook,
    write_notebook,
)
from qdot.exercises.notebook.self_check import SELF_CHECK, Problems
from qdot.grader.sandbox.sandbox import Sandbox
from qdot.grader.submissions.cells import Cell, empty_self_checks, read_cells
from tests.support.problems import get_problem, sample_parts
from tests.support.suites import few_families


def make_problems(family: str) -> Problems:
    """Return a problem of the family, and one whose notebook certainly has a self-check, and `self` in an answer."""
    problem = get_problem(family, 0)
    shortened = replace(problem, parts=tuple(sample_parts(problem)[:6]))
    return [("p1", shortened), ("p2", generate("planar-3r/0", ["position", "jacobian", "self-motion"]))]


def make_cells(problems: Problems, make_notebook: Callable[..., NotebookNode] = make_solution_notebook) -> list[Cell]:
    text = write_notebook(make_notebook(NotebookContent("Title", "hw", "s1", problems)))
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
