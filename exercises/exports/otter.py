"""Export a source notebook for `otter assign`, whose autograder marks with qdot, and every student's notebook.

Otter releases the same notebook to everybody, but qdot's students have different problems with the same questions.
Therefore the source notebook contains no problem. From the source notebook, `otter assign` makes the autograder with a
test for each part. Students get their notebooks separately. Students' notebooks contain tests with the same names,
which only report whether an answer is given.
"""

import json
from collections.abc import Generator
from typing import Any

import nbformat
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook, new_raw_cell

from qdot.exercises.assignment.assignment import SECRET_FILE, Assignment
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.exports.handouts import collect_handouts
from qdot.exercises.exports.nbgrader import make_grade_id
from qdot.exercises.exports.repositories import read_assignment_files
from qdot.exercises.exports.wheel import make_wheel
from qdot.exercises.notebook.notebook import KERNEL, write_notebook, write_points
from qdot.exercises.problem.problem import name_answer_variable
from qdot.exercises.writing.render import escape_markdown, render

ASSIGNMENT_FOLDER = "qdot"
"""The folder in the autograder that holds the assignment."""
PLUGIN_PATH = "qdot.grader.integrations.otter_plugin.Marks"
"""The plugin that Otter calls before and after it runs a notebook."""
OtterPart = tuple[str, str, float, str]
"""A part of an assignment: its name, its name in Otter, its points and its title."""


def export_otter(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield the source for `otter assign`, the files of the autograder, and every student's notebook."""
    handouts = collect_handouts(request)
    assignment, (wheel_name, wheel) = handouts.assignment, make_wheel()
    private_files = [*read_assignment_files(request), (SECRET_FILE, f"{assignment.secret}\n".encode())]
    paths = [wheel_name, *(f"{ASSIGNMENT_FOLDER}/{path}" for path, _ in private_files)]
    context = handouts.context | {"plugin": PLUGIN_PATH, "files": paths}
    yield ExportedFile("README.md", render("exports/otter/readme.md.j2", **context))
    config = render("exports/otter/config.yaml.j2", **context)
    yield ExportedFile(f"{assignment.key}.ipynb", _make_source_notebook(assignment, config))
    yield ExportedFile(wheel_name, wheel)
    for path, data in private_files:
        yield ExportedFile(f"{ASSIGNMENT_FOLDER}/{path}", data, is_private=True)
    for student, text in handouts.iterate_notebooks():
        yield ExportedFile(f"students/{student.id}/{assignment.key}.ipynb", _add_tests(assignment, text))


def list_parts(assignment: Assignment) -> list[OtterPart]:
    """Return all parts of an assignment, in order."""
    return [
        (f"{slot.name}.{kind}", make_grade_id(f"{slot.name}.{kind}"), points, slot.find_question(kind).title)
        for slot in assignment.slots
        for kind, points in slot.points_by_question.items()
    ]


# --- the source for `otter assign` ---


def _make_source_notebook(assignment: Assignment, config: str) -> str:
    title_cell = new_markdown_cell(f"# {escape_markdown(assignment.title)}", id="title")
    cells = [new_raw_cell(config.strip(), id="config"), title_cell]
    for part, name, points, title in list_parts(assignment):
        answer = f"{name_answer_variable(*part.split('.', 1))} = ..."
        test = render("exports/otter/test.py.j2", part=part, function=name.replace("-", "_")).strip()
        cells += [
            new_raw_cell(f"# BEGIN QUESTION\nname: {name}\npoints: {points:g}", id=f"{name}-begin"),
            new_markdown_cell(f"### {title} ({write_points(points)})", id=f"{name}-question"),
            new_raw_cell("# BEGIN SOLUTION", id=f"{name}-solution"),
            new_code_cell(f"{answer} # SOLUTION", id=f"{name}-answer"),
            new_raw_cell("# END SOLUTION", id=f"{name}-solved"),
            new_raw_cell("# BEGIN TESTS", id=f"{name}-tests"),
            new_code_cell(test, id=f"{name}-test"),
            new_raw_cell("# END TESTS", id=f"{name}-tested"),
            new_raw_cell("# END QUESTION", id=f"{name}-end"),
        ]
    notebook = new_notebook(metadata={"kernelspec": KERNEL, "language_info": {"name": "python"}}, cells=cells)
    nbformat.validate(notebook)
    return write_notebook(notebook)


# --- students' notebooks ---


def _add_tests(assignment: Assignment, text: str) -> str:
    """Return a student's notebook with tests in its metadata and tagged answer cells, as Otter needs it."""
    notebook = json.loads(text)
    tests = {name: _make_presence_test(part, name, points) for part, name, points, _ in list_parts(assignment)}
    notebook["metadata"]["otter"] = {"OK_FORMAT": True, "assignment_name": assignment.key, "tests": tests}
    for cell in notebook["cells"]:
        if "qdot" in cell["metadata"]:
            cell["metadata"]["tags"] = ["otter_answer_cell"]
    return write_notebook(notebook)


def _make_presence_test(part: str, name: str, points: float) -> dict[str, Any]:
    """Return a test that only checks whether an answer is given, for the `grader.check` that students call."""
    case = {
        "code": f">>> 'blank' in str({name_answer_variable(*part.split('.', 1))})\nFalse",
        "hidden": False, "locked": False,
        "success_message": "You have given an answer; it will be graded after you submit.",
        "failure_message": "You have not given an answer yet.",
    }  # fmt: skip
    suite = {"cases": [case], "scored": True, "setup": "", "teardown": "", "type": "doctest"}
    return {"name": name, "points": points, "suites": [suite]}
