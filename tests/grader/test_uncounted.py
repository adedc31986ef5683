"""The notebook's own self-checks are left out at grading where that can't change an answer, and only there."""

import ast
from collections.abc import Sequence

import pytest

from exercises.notebook import SELF_CHECK, Problems, notebook_text, solution_notebook
from grader.cells import Cell, read_cells
from grader.sandbox import Limits, Sandbox
from grader.uncounted import without_self_checks
from tests.support.problems import drawn
from tests.support.suites import few_families


def slotted(family: str) -> Problems:
    """A problem of the family, and one whose notebook has a self-check in any case."""
    return [("p1", drawn(family, 0)), ("p2", drawn("planar-2r", 0))]


def cells_of(problems: Problems) -> list[Cell]:
    text = notebook_text(solution_notebook("Title", "hw", "s1", problems))
    return list(read_cells("hw.ipynb", text.encode()).cells)


def code(cells: Sequence[Cell]) -> list[str]:
    return [cell.source for cell in cells if cell.is_code]


@few_families
def test_only_calls_are_left_out(family: str) -> None:
    problems = slotted(family)
    cells = cells_of(problems)
    left = without_self_checks(cells, problems)
    assert len(left) == len(cells)
    for before, after in zip(cells, left, strict=True):
        call = before.source.partition("\n" + SELF_CHECK)[1:]
        is_check = before.is_code and call[0] and "def " not in before.source
        assert after == (Cell(before.source.removesuffix("".join(call))) if is_check else before) or is_check
        assert (SELF_CHECK in after.source) == (SELF_CHECK in before.source and not is_check)
    assert sum(SELF_CHECK in source for source in code(cells)) > sum(SELF_CHECK in source for source in code(left)) == 1


def test_answers_are_what_they_are_with_all_cells() -> None:
    problems = slotted("planar-2r")
    cells = cells_of(problems)
    names = [f"{slot}_{part.name.replace('-', '_')}" for slot, problem in problems for part in problem.parts]
    with Sandbox(Limits(seconds=60)) as sandbox:
        whole, left = (sandbox.run(code(each), names) for each in (cells, without_self_checks(cells, problems)))
    assert whole.answers == left.answers and set(left.answers) == set(names)
    assert not left.cell_errors and not left.failures


def test_what_else_is_in_the_cell_is_run() -> None:
    problems = [("p1", drawn("planar-2r", 1, "zeros"))]  # a2 is a symbol with a value there
    cells = cells_of(problems)
    check = next(cell for cell in cells if SELF_CHECK in cell.source and "def " not in cell.source)
    values = "given = {"
    assert values in check.source
    left = without_self_checks(cells, problems)[cells.index(check)].source
    assert values in left and len(ast.parse(left).body) == 1


@pytest.mark.parametrize(
    "added",
    [
        "self_check = print",
        "def self_check(*given):\n    global p1_jacobian",
        "from my_tools import self_check",
        "self_check(p1_position, p1_jacobian, [theta1, theta2])",
        "%run self_check.py",
    ],
)
def test_where_anything_else_speaks_of_it_all_is_run(added: str) -> None:
    problems = slotted("planar-2r")
    cells = [*cells_of(problems), Cell(added)]
    assert without_self_checks(cells, problems) == cells


def test_a_function_or_a_call_that_was_changed_is_run() -> None:
    problems = slotted("planar-2r")
    cells = cells_of(problems)
    place = next(n for n, cell in enumerate(cells) if "def self_check" in cell.source)
    for old, new in (("random", "chance"), ("1e-5", "1e-6"), ("def self_check", "def own_check")):
        changed = [*cells]
        changed[place] = Cell(cells[place].source.replace(old, new))
        assert without_self_checks(changed, problems) == changed
    last = max(n for n, cell in enumerate(cells) if SELF_CHECK in cell.source)
    changed = [*cells]
    changed[last] = Cell(cells[last].source + "\np2_jacobian = p2_jacobian.T")
    assert without_self_checks(changed, problems) == changed


def test_text_that_quotes_a_check_stays_text() -> None:
    problems = slotted("planar-2r")
    cells = [Cell(cell.source, is_code=False) for cell in cells_of(problems)]
    assert without_self_checks(cells, problems) == cells
