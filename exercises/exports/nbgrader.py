"""Export of an nbgrader course: a source notebook with the cells and their points, and a notebook for each student.

nbgrader releases the same notebook to everybody, but qdot's students have different problems with the same parts.
Therefore the source notebook contains no problem, and students get their own notebooks separately. The cells of both
have the same names.
"""

import csv
import hashlib
import io
import json
from collections.abc import Generator, Sequence
from typing import Any

from qdot.exercises.assignment.assignment import SECRET_FILE, Slot, Student
from qdot.exercises.exports.export_format import File, Order
from qdot.exercises.exports.handouts import handouts
from qdot.exercises.exports.repositories import assignment_files
from qdot.exercises.exports.wheel import wheel
from qdot.exercises.notebook.notebook import KERNEL, notebook_text, points_text
from qdot.exercises.problem.problem import variable
from qdot.exercises.quizzes import ASKED
from qdot.exercises.writing.render import render

Cell = dict[str, Any]
SCHEMA = 3
"""The version of nbgrader's metadata in the notebooks."""
ANSWER = "-answer"
"""The suffix of an answer cell's name. The cell with the marks has the name without it, which the gradebook shows."""
SIGN = "# Marked by qdot"
"""The first line of a cell with marks; no other cell begins with it."""


def export_nbgrader(order: Order) -> Generator[File, None, None]:
    """Yield the course: configuration, source notebook, the assignment with its secret, and students' notebooks."""
    notebooks = handouts(order)
    assignment = notebooks.assignment
    key = assignment.key
    name, content = wheel()
    context = {"title": assignment.title, "key": key, "wheel": name}
    yield File("nbgrader_config.py", render("exports/nbgrader/config.py.j2"))
    yield File("README.md", render("exports/nbgrader/readme.md.j2", **context))
    yield File(".gitignore", render("exports/nbgrader/gitignore.j2"))
    yield File(name, content)
    yield File("students.csv", _names(assignment.roster))
    yield File(f"source/{key}/{key}.ipynb", _text(_pattern(assignment.title, key, assignment.slots)))
    for path, data in assignment_files(order):
        yield File(f"qdot/{key}/{path}", data)
    yield File(f"qdot/{key}/{SECRET_FILE}", f"{assignment.secret}\n", private=True)
    points = {f"{slot.name}.{part}": worth for slot in assignment.slots for part, worth in _parts(slot)}
    for student, text in notebooks.all():
        if "+" in student.id:
            order.note(f"{student.id}: nbgrader takes no student whose identifier has a +")
        notebook = json.loads(text)
        notebook["cells"] = [new_cell for cell in notebook["cells"] for new_cell in _with_marks(cell, points)]
        yield File(f"handout/{student.id}/{key}/{key}.ipynb", _text(notebook))


def _names(roster: Sequence[Student]) -> str:
    """Return the roster for `nbgrader db student import`; the last word of a name is the last name."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["id", "first_name", "last_name", "email"])
    for student in roster:
        first_name, _, last_name = student.name.rpartition(" ")
        writer.writerow([student.id, first_name, last_name, student.email])
    return stream.getvalue()


def grade_id(part: str) -> str:
    """Return nbgrader's name for a part.

    >>> grade_id("p1.rank-at")
    'p1-rank-at'
    """
    return part.replace(".", "-")


def checksum(cell: Cell) -> str:
    """Return the checksum that tells nbgrader whether a cell was changed."""
    metadata = cell["metadata"]["nbgrader"]
    flags = (metadata["grade"], metadata["solution"], metadata["locked"])
    points_text = str(float(metadata["points"])) if metadata["grade"] else ""
    content = "".join((cell["source"], cell["cell_type"], *map(str, flags), metadata["grade_id"], points_text))
    return hashlib.md5(content.encode(), usedforsecurity=False).hexdigest()


def answer_metadata(part: str) -> dict[str, Any]:
    """Return nbgrader's metadata of the answer cell of a part."""
    return _metadata(f"{grade_id(part)}{ANSWER}", solution=True)


def marks_cell(part: str, points: float) -> Cell:
    """Return the cell that holds the marks of a part.

    It evaluates to 0 points until qdot has marked the part. It raises no error, so that students can run all cells.
    """
    metadata = _metadata(grade_id(part), grade=True, locked=True)
    metadata["nbgrader"]["points"] = points
    source = render("exports/nbgrader/marks.py.j2", sign=SIGN, part=part, points=points_text(points)).strip()
    cell = _code(f"{grade_id(part)}-marks", source, {**metadata, "deletable": False, "editable": False})
    metadata["nbgrader"]["checksum"] = checksum(cell)
    return cell


def _metadata(name: str, **flags: bool) -> Cell:
    defaults: Cell = {"grade": False, "grade_id": name, "locked": False, "schema_version": SCHEMA, "solution": False}
    return {"deletable": False, "nbgrader": {**defaults, "task": False, **flags}}


def _with_marks(cell: Cell, points: dict[str, float]) -> list[Cell]:
    """Return a cell of a student's notebook, followed by the cell with its marks if it is an answer cell."""
    part = cell["metadata"].get("qdot", {}).get("part")
    if part is None:
        return [cell]
    cell["metadata"].update(answer_metadata(part))
    cell["metadata"]["nbgrader"]["checksum"] = checksum(cell)
    return [cell, marks_cell(part, points[part])]


def _pattern(title: str, key: str, slots: tuple[Slot, ...]) -> dict[str, Any]:
    cells = [_markdown("title", render("exports/nbgrader/pattern.md.j2", title=title, key=key))]
    for number, slot in enumerate(slots, 1):
        for index, (part, worth) in enumerate(_parts(slot), 1):
            name = f"{slot.name}.{part}"
            heading = f"### {number}.{index} {ASKED[part].title} ({points_text(worth)})"
            cells.append(_markdown(f"{grade_id(name)}-question", heading))
            cells.append(_code(grade_id(name), f"{variable(slot.name, part)} = blank", answer_metadata(name)))
            cells.append(marks_cell(name, worth))
    metadata = {"kernelspec": KERNEL, "language_info": {"name": "python"}}
    return {"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}


def _parts(slot: Slot) -> list[tuple[str, float]]:
    return list(zip(slot.questions, slot.max_points, strict=True))


def _text(notebook: dict[str, Any]) -> str:
    return notebook_text(notebook)  # type: ignore[arg-type]


def _markdown(name: str, source: str) -> Cell:
    return {"cell_type": "markdown", "id": name, "metadata": {}, "source": source.strip()}


def _code(name: str, source: str, metadata: dict[str, Any]) -> Cell:
    cell: Cell = {"cell_type": "code", "execution_count": None, "id": name, "outputs": []}
    return {**cell, "metadata": metadata, "source": source}
