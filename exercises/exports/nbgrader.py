"""Export an nbgrader course: a source notebook with the cells and their points, and a notebook for each student.

nbgrader releases the same notebook to everybody, but qdot's students have different problems with the same questions.
Therefore the source notebook contains no problem, and students get their notebooks separately. The cells have the same
names in the source notebook and in students' notebooks.
"""

import hashlib
import json
from collections.abc import Generator, Sequence
from collections.abc import Set as AbstractSet
from typing import Any, NamedTuple

from nbformat.v4 import new_code_cell, new_markdown_cell

from qdot.exercises.assignment.assignment import SECRET_FILE, Assignment, Slot, Student
from qdot.exercises.common.input_file import format_csv
from qdot.exercises.exports.assignment_files import read_assignment_files
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.exports.handouts import collect_handouts
from qdot.exercises.exports.wheel import make_wheel
from qdot.exercises.notebook.notebook import KERNEL, write_notebook, write_points
from qdot.exercises.problem.problem import name_answer_variable
from qdot.exercises.writing.render import escape_heading, render

Cell = dict[str, Any]
SCHEMA_VERSION = 3
"""The version of nbgrader's metadata in the notebooks."""
ANSWER_SUFFIX = "-answer"
"""The suffix of the name of a cell with an answer.

The cell with the marks has the name without this suffix; the gradebook shows that name.
"""
MARKS_COMMENT = "# Marked by qdot"
"""The first line of a cell with marks; no other cell begins with it."""


def export_nbgrader(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield the course: configuration, source notebook, the assignment with its secret, and students' notebooks."""
    handouts = collect_handouts(request)
    assignment, context, key = handouts.assignment, handouts.context, handouts.assignment.key
    yield ExportedFile("nbgrader_config.py", render("exports/nbgrader/config.py.j2"))
    yield ExportedFile("README.md", render("exports/nbgrader/readme.md.j2", **context))
    yield ExportedFile(".gitignore", render("exports/nbgrader/gitignore.j2"))
    yield ExportedFile(*make_wheel())
    yield ExportedFile("students.csv", _write_roster(assignment.roster))
    source = _make_source_notebook(assignment.title, key, assignment.slots)
    yield ExportedFile(f"source/{key}/{key}.ipynb", write_notebook(source))
    for path, data in read_assignment_files(assignment).items():
        yield ExportedFile(f"qdot/{key}/{path}", data)
    yield ExportedFile(f"qdot/{key}/{SECRET_FILE}", f"{assignment.secret}\n", is_private=True)
    points_by_part = {part.name: part.points for part in list_parts(assignment)}
    text_parts = find_text_parts(assignment)
    for student, text in handouts.iterate_notebooks():
        if "+" in student.id:
            request.report(f"{student.id}: nbgrader does not accept identifiers with +")
        notebook = json.loads(text)
        notebook["cells"] = [
            new_cell for cell in notebook["cells"] for new_cell in _add_marks_cell(cell, points_by_part, text_parts)
        ]
        yield ExportedFile(f"handout/{student.id}/{key}/{key}.ipynb", write_notebook(notebook))


def _write_roster(roster: Sequence[Student]) -> str:
    """Return the roster for `nbgrader db student import`; the last word of a name is the last name."""
    names = ((student, *student.name.rpartition(" ")) for student in roster)
    rows = ((student.id, first_name, last_name, student.email) for student, first_name, _, last_name in names)
    return format_csv([("id", "first_name", "last_name", "email"), *rows])


def make_grade_id(part: str) -> str:
    """Return nbgrader's name for a part.

    >>> make_grade_id("p1.rank-at")
    'p1-rank-at'
    """
    return part.replace(".", "-")


class PlatformPart(NamedTuple):
    """A part of an assignment: its name, its name on the platform, its points and its title."""

    name: str
    grade_id: str
    points: float
    title: str


def list_parts(assignment: Assignment) -> list[PlatformPart]:
    """Return all parts of an assignment, in order."""
    parts = []
    for slot in assignment.slots:
        for kind, points in slot.points_by_question.items():
            name = f"{slot.name}.{kind}"
            parts.append(PlatformPart(name, make_grade_id(name), points, slot.find_question(kind).title))
    return parts


def find_text_parts(assignment: Assignment) -> frozenset[str]:
    """Return the names of the parts that a person marks."""
    return frozenset(f"{slot.name}.{name}" for slot in assignment.slots for name in slot.text_questions)


def compute_checksum(cell: Cell) -> str:
    """Return the checksum that nbgrader uses to recognise changes of a cell."""
    metadata = cell["metadata"]["nbgrader"]
    flags = (metadata["grade"], metadata["solution"], metadata["locked"])
    points = str(float(metadata["points"])) if metadata["grade"] else ""
    content = "".join((cell["source"], cell["cell_type"], *map(str, flags), metadata["grade_id"], points))
    return hashlib.md5(content.encode(), usedforsecurity=False).hexdigest()


def make_answer_metadata(part: str) -> dict[str, Any]:
    """Return nbgrader's metadata of the answer cell of a part."""
    return _make_metadata(f"{make_grade_id(part)}{ANSWER_SUFFIX}", solution=True)


def make_text_metadata(part: str, points: float) -> dict[str, Any]:
    """Return nbgrader's metadata of a cell with a text answer, which a person marks on nbgrader's pages."""
    metadata = _make_metadata(make_grade_id(part), grade=True, solution=True)
    metadata["nbgrader"]["points"] = points
    return metadata


def make_marks_cell(part: str, points: float) -> Cell:
    """Return the cell that holds the marks of a part.

    The cell evaluates to 0 points until qdot has marked the part. The cell raises no error, so students can run it.
    """
    metadata = _make_metadata(make_grade_id(part), grade=True, locked=True)
    metadata["nbgrader"]["points"] = points
    source = render(
        "exports/nbgrader/marks.py.j2", comment=MARKS_COMMENT, part=part, points=write_points(points)
    ).strip()
    cell = new_code_cell(source, id=f"{make_grade_id(part)}-marks", metadata={**metadata, "editable": False})
    cell["metadata"]["nbgrader"]["checksum"] = compute_checksum(cell)
    return cell


def _make_metadata(name: str, **flags: bool) -> Cell:
    all_flags = {"grade": False, "locked": False, "solution": False, "task": False, **flags}
    return {"deletable": False, "nbgrader": {"grade_id": name, "schema_version": SCHEMA_VERSION, **all_flags}}


def _add_marks_cell(cell: Cell, points_by_part: dict[str, float], text_parts: AbstractSet[str]) -> list[Cell]:
    """Return a cell of a student's notebook, followed by the cell with its marks if qdot marks the answer in it."""
    part = cell["metadata"].get("qdot", {}).get("part")
    if part is None:
        return [cell]
    is_text = part in text_parts
    cell["metadata"].update(make_text_metadata(part, points_by_part[part]) if is_text else make_answer_metadata(part))
    cell["metadata"]["nbgrader"]["checksum"] = compute_checksum(cell)
    return [cell] if is_text else [cell, make_marks_cell(part, points_by_part[part])]


def _make_source_notebook(title: str, key: str, slots: tuple[Slot, ...]) -> dict[str, Any]:
    cells = [new_markdown_cell(render("exports/nbgrader/pattern.md.j2", title=title, key=key).strip(), id="title")]
    for number, slot in enumerate(slots, 1):
        for index, (kind, points) in enumerate(slot.points_by_question.items(), 1):
            part, question_title = f"{slot.name}.{kind}", escape_heading(slot.find_question(kind).title)
            heading = f"### {number}.{index} {question_title} ({write_points(points)})"
            cells.append(new_markdown_cell(heading, id=f"{make_grade_id(part)}-question"))
            answer = f"{name_answer_variable(slot.name, kind)} = blank"
            cell = new_code_cell(answer, id=make_grade_id(part), metadata={"qdot": {"part": part}})
            cells += _add_marks_cell(cell, {part: points}, {part} if kind in slot.text_questions else frozenset())
    metadata = {"kernelspec": KERNEL, "language_info": {"name": "python"}}
    return {"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}
