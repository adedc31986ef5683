"""The same notebooks graded by nbgrader: Examples 6.1 and 6.2, five answers on a planar arm of two joints.

nbgrader grades one problem, as it knows no problem of one's own; its tests compare the answers at random points with
NumPy, which is less than what qdot does. It runs in an environment of its own.
"""

from pathlib import Path
from typing import Any

import nbformat
from nbformat.v4 import new_code_cell

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.problem.problem import name_answer_variable
from qdot.exercises.reference_answers import Expression, Matrix

from .clock import processor_time

COMPARE = """
import random as _random
def same(mine, right):
    mine, right = (value if hasattr(value, "shape") else Matrix([value]) for value in (mine, right))
    symbols = sorted(right.free_symbols, key=str)
    f, g = lambdify(symbols, mine), lambdify(symbols, right)
    points = [[_random.uniform(0.3, 1.5) for _ in symbols] for _ in range(5)]
    return all(np.allclose(np.array(f(*p), float), np.array(g(*p), float)) for p in points)
"""


def checks(assignment: Assignment) -> dict[str, str]:
    """Return a line of code for each answer that fails where it is wrong."""
    ((slot, problem),) = assignment.generate_problems(assignment.roster[0].id)
    found = {}
    for part in problem.parts:
        name = name_answer_variable(slot, part.name)
        if isinstance(part.answer, (Expression, Matrix)):
            found[part.name] = " ".join(f"assert same({name}, {part.answer.reference!r})".split())
        else:
            found[part.name] = f"assert {name}"
    return found


def one_notebook(assignment: Assignment, kind: str) -> Any:
    return nbformat.read(assignment.folder / kind / assignment.roster[0].id / "bench.ipynb", as_version=4)


# --- nbgrader ---


def nbgrader(assignment: Assignment, folder: Path, python: Path) -> float:
    """Make a course with one assignment, and return the processor time of `nbgrader autograde`."""
    source = one_notebook(assignment, "released")
    tests = checks(assignment)
    cells = []
    for cell in source.cells:
        cells.append(cell)
        part = cell.metadata.pop("qdot", {}).get("part", "").removeprefix("p1.")
        if part in tests:
            cell.metadata["nbgrader"] = mark(f"answer-{part}", 0, solution=True)
            code = COMPARE + tests[part]
            cells.append(new_code_cell(code, metadata={"nbgrader": mark(f"test-{part}", 1, grade=True)}))
    source.cells = cells
    target = folder / "source" / "bench" / "bench.ipynb"
    target.parent.mkdir(parents=True)
    nbformat.write(source, target)
    (folder / "nbgrader_config.py").write_text(f"c = get_config()\nc.CourseDirectory.root = {str(folder)!r}\n")
    program = [str(python), "-m", "nbgrader"]
    processor_time([*program, "generate_assignment", "bench"], folder)
    handed_out = nbformat.read(folder / "release" / "bench" / "bench.ipynb", as_version=4)
    solved = {cell.id: cell.source for cell in one_notebook(assignment, "solutions").cells}
    for cell in handed_out.cells:
        if cell.metadata.get("nbgrader", {}).get("solution"):
            cell.source = solved[cell.id]
    for student in assignment.roster:
        path = folder / "submitted" / student.id / "bench" / "bench.ipynb"
        path.parent.mkdir(parents=True)
        nbformat.write(handed_out, path)
    return processor_time([*program, "autograde", "bench"], folder)


def mark(name: str, points: int, solution: bool = False, grade: bool = False) -> dict[str, Any]:
    metadata = {"grade_id": name, "solution": solution, "grade": grade, "locked": grade}
    return {**metadata, "schema_version": 3, "task": False, **({"points": points} if grade else {})}
