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
from qdot.exercises.exports.assignment_files import read_assignment_files
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.exports.handouts import collect_handouts
from qdot.exercises.exports.nbgrader import PlatformPart, list_parts
from qdot.exercises.exports.wheel import make_wheel
from qdot.exercises.notebook.notebook import KERNEL, write_notebook, write_points
from qdot.exercises.problem.problem import name_answer_variable
from qdot.exercises.writing.render import escape_heading, escape_markdown, render

ASSIGNMENT_FOLDER = "qdot"
"""The folder in the autograder that holds the assignment."""
PLUGIN_PATH = "qdot.grader.integrations.otter_plugin.Marks"
"""The plugin that Otter calls before and after it runs a notebook."""


def export_otter(request: ExportRequest) -> Generator[ExportedFile, None, None]:
    """Yield the source for `otter assign`, the files of the autograder, and every student's notebook."""
    handouts = collect_handouts(request)
    assignment, wheel = handouts.assignment, make_wheel()
    private_files = read_assignment_files(assignment) | {SECRET_FILE: f"{assignment.secret}\n".encode()}
    paths = [wheel.file_name, *(f"{ASSIGNMENT_FOLDER}/{path}" for path in private_files)]
    context = handouts.context | {"plugin": PLUGIN_PATH, "files": paths}
    yield ExportedFile("README.md", render("exports/otter/readme.md.j2", **context))
    config = render("exports/otter/config.yaml.j2", **context)
    yield ExportedFile(f"{assignment.key}.ipynb", _make_source_notebook(assignment, config))
    yield ExportedFile(*wheel)
    for path, data in private_files.items():
        yield ExportedFile(f"{ASSIGNMENT_FOLDER}/{path}", data, is_private=True)
    for student, text in handouts.iterate_notebooks():
        yield ExportedFile(f"students/{student.id}/{assignment.key}.ipynb", _add_tests(assignment, text))


# --- the source for `otter assign` ---


def _make_source_notebook(assignment: Assignment, config: str) -> str:
    title_cell = new_markdown_cell(f"# {escape_markdown(assignment.title)}", id="title")
    cells = [new_raw_cell(config.strip(), id="config"), title_cell]
    for part, grade_id, points, title in list_parts(assignment):
        answer = f"{name_answer_variable(*part.split('.', 1))} = ..."
        test = render("exports/otter/test.py.j2", function=grade_id.replace("-", "_")).strip()
        cells += [
            new_raw_cell(f"# BEGIN QUESTION\nname: {grade_id}\npoints: {points:g}", id=f"{grade_id}-begin"),
            new_markdown_cell(f"### {escape_heading(title)} ({write_points(points)})", id=f"{grade_id}-question"),
            new_raw_cell("# BEGIN SOLUTION", id=f"{grade_id}-solution"),
            new_code_cell(f"{answer} # SOLUTION", id=f"{grade_id}-answer"),
            new_raw_cell("# END SOLUTION", id=f"{grade_id}-solved"),
            new_raw_cell("# BEGIN TESTS", id=f"{grade_id}-tests"),
            new_code_cell(test, id=f"{grade_id}-test"),
            new_raw_cell("# END TESTS", id=f"{grade_id}-tested"),
            new_raw_cell("# END QUESTION", id=f"{grade_id}-end"),
        ]
    notebook = new_notebook(metadata={"kernelspec": KERNEL, "language_info": {"name": "python"}}, cells=cells)
    nbformat.validate(notebook)
    return write_notebook(notebook)


# --- students' notebooks ---


def _add_tests(assignment: Assignment, text: str) -> str:
    """Return a student's notebook with tests in its metadata and tagged answer cells, as Otter needs it."""
    notebook = json.loads(text)
    tests = {part.grade_id: _make_presence_test(part) for part in list_parts(assignment)}
    notebook["metadata"]["otter"] = {"OK_FORMAT": True, "assignment_name": assignment.key, "tests": tests}
    for cell in notebook["cells"]:
        if "qdot" in cell["metadata"]:
            cell["metadata"]["tags"] = ["otter_answer_cell"]
    return write_notebook(notebook)


def _make_presence_test(part: PlatformPart) -> dict[str, Any]:
    """Return a test that only checks whether an answer is given, for the `grader.check` that students call.

    If a test fails, Otter shows the report of the doctest below the message. The report would show students our code.
    Therefore the test's second line, which never fails, removes the report.
    """
    case = {
        "code": render("exports/otter/presence-test.txt.j2", variable=name_answer_variable(*part.name.split(".", 1))),
        "hidden": False, "locked": False,
        "success_message": "You have given an answer; it will be graded after you submit.",
        "failure_message": "There is no answer yet. Write it in the cell of this question, and run the cell.",
    }  # fmt: skip
    suite = {"cases": [case], "scored": True, "setup": "", "teardown": "", "type": "doctest"}
    return {"name": part.grade_id, "points": part.points, "suites": [suite]}
