"""otter-grader itself, `otter assign` and `otter run`, on a class written by `qdot export --to otter`.

It runs in a separate environment with qdot (`make .venvs/readers/.installed`); without it one test is skipped.
"""

import json
import os
import subprocess
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports.nbgrader import list_parts, make_grade_id
from qdot.exercises.exports.otter import PLUGIN_PATH
from qdot.exercises.problem.problem import name_answer_variable
from qdot.grader.integrations.otter_marks import grade_for_otter
from tests.support.command import run
from tests.support.programs import require_reader
from tests.support.submitting import TOML, make_class

Answers = dict[str, str]


@pytest.fixture(scope="module")
def assignment(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    folder = tmp_path_factory.mktemp("class") / "hw"
    make_class(folder, [Student("ada", "Ada Lovelace", "ada@example.org"), Student("hen")])
    (folder / "assignment.toml").write_text(TOML)
    run("export", folder, "--to", "otter", "--jobs", "1")
    return load_assignment(folder)


def get_export_folder(assignment: Assignment) -> Path:
    return assignment.folder / "exports" / "otter"


def write_submission(assignment: Assignment, folder: Path, change: Callable[[Answers], Any] | None) -> Path:
    """Write a notebook with correct answers edited by `change`, or, without it, the handed-out notebook."""
    notebook = json.loads((get_export_folder(assignment) / "students/ada/hw.ipynb").read_text())
    ((slot, problem),) = assignment.generate_problems("ada")
    answers = {f"{slot}.{part.name}": part.answer.write_code() for part in problem.parts}
    if change:
        change(answers)
        for cell in notebook["cells"]:
            part = cell["metadata"].get("qdot", {}).get("part")
            if part:
                cell["source"] = f"{name_answer_variable(*part.split('.'))} = {answers[part]}"
    path = folder / "hw.ipynb"
    path.write_text(json.dumps(notebook))
    return path


def answer_wrongly(answers: Answers) -> None:
    answers["p1.determinant"] = f"-({answers['p1.determinant']})"
    answers["p1.position"] = "Matrix([7, 7])"


def test_notebooks_have_every_part_and_no_answers(assignment: Assignment) -> None:
    notebook = json.loads((get_export_folder(assignment) / "students/ada/hw.ipynb").read_text())
    metadata = notebook["metadata"]["otter"]
    names = {name: points for _, name, points, _ in list_parts(assignment)}
    assert metadata["OK_FORMAT"] is True and metadata["assignment_name"] == "hw"
    assert {name: test["points"] for name, test in metadata["tests"].items()} == names
    tagged = [cell for cell in notebook["cells"] if "otter_answer_cell" in cell["metadata"].get("tags", ())]
    assert len(tagged) == len(names)
    ((_, problem),) = assignment.generate_problems("ada")
    for part in problem.parts:
        assert part.answer.as_typed() not in json.dumps(metadata)
    text = (get_export_folder(assignment) / "hw.ipynb").read_text()
    cells = ["".join(cell["source"]) for cell in json.loads(text)["cells"]]
    questions = [cell for cell in cells if cell.startswith("# BEGIN QUESTION")]
    assert questions == [f"# BEGIN QUESTION\nname: {name}\npoints: {points:g}" for name, points in names.items()]
    assert PLUGIN_PATH in cells[0] and "run_tests: false" in cells[0]
    assert assignment.secret not in text
    files = [path for path in get_export_folder(assignment).rglob("*") if path.is_file()]
    private = {path.name for path in files if path.stat().st_mode & 0o077 == 0}
    assert private == {"assignment.toml", "roster.csv", "secret.txt"}


def test_student_comes_from_gradescope_or_the_notebook(assignment: Assignment, tmp_path: Path) -> None:
    notebook = write_submission(assignment, tmp_path, None)
    users = {"users": [{"email": "ada@example.org", "name": "Ada"}], "created_at": "2027-01-01T00:00:00Z"}
    assert grade_for_otter(assignment.folder, notebook, users).extra_data.student == "ada"
    with pytest.raises(QdotError, match=r"eve@example\.org"):
        grade_for_otter(assignment.folder, notebook, {"users": [{"email": "eve@example.org"}]})
    content = json.loads(notebook.read_text())
    del content["metadata"]["qdot"]
    notebook.write_text(json.dumps(content))
    with pytest.raises(QdotError, match="does not name its student"):
        grade_for_otter(assignment.folder, notebook, {})


ENVIRONMENT = {**os.environ, "PYTHONWARNINGS": "ignore"}
Found = dict[str, tuple[float, str]]


@pytest.fixture(scope="module")
def autograder(assignment: Assignment) -> Path:
    otter, here = require_reader("otter", "otter"), get_export_folder(assignment)
    subprocess.run([otter, "assign", "hw.ipynb", "dist"], cwd=here, env=ENVIRONMENT, check=True, capture_output=True)
    (archive,) = (here / "dist/autograder").glob("*.zip")
    return archive


def run_otter(autograder: Path, folder: Path, submission: Path) -> Found:
    command = [require_reader("otter", "otter"), "run", "-a", str(autograder), "-o", str(folder), str(submission)]
    process = subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True)
    assert process.returncode == 0, process.stderr[-2000:]
    tests = json.loads((folder / "results.json").read_text())["tests"]
    return {test["name"]: (test["score"], test["output"]) for test in tests}


@pytest.mark.integration
def test_files_submitted_with_a_notebook_are_neither_imported_nor_read(
    autograder: Path, assignment: Assignment, tmp_path: Path
) -> None:
    """Otter works in the submission's folder: a module there named like one of qdot, Otter or Python would run with
    access to the secret and the marks, and an Otter log would be unpickled.
    """
    ran, folder = tmp_path / "ran", tmp_path / "submitted"
    code = (
        f"import os, pathlib, sys\nwith open({str(ran)!r}, 'a') as out:\n"
        "    print(__name__, os.getcwd(), sys.argv, list(pathlib.Path('..').rglob('secret.txt')), file=out)\n"
        "def grade_for_otter(*_): pass\n"
    )
    folder.mkdir()
    write_submission(assignment, folder, answer_wrongly)
    packages = [f"{package}/__init__.py" for package in ("grader", "exercises", "otter", "tests", "qdot", "ipykernel")]
    modules = ("json", "socket", "pickle", "sitecustomize", "usercustomize", "sympy", "numpy", "multiprocessing")
    with zipfile.ZipFile(tmp_path / "hw.zip", "w") as packed:
        packed.write(folder / "hw.ipynb", "hw.ipynb")
        packed.writestr(".OTTER_LOG", b"cos\nsystem\n(S'touch %s'\ntR." % str(ran).encode())
        for path in (*packages, "grader/integrations/otter_marks.py", "tests/extra.py", *map("{}.py".format, modules)):
            packed.writestr(path, code)
    scores = run_otter(autograder, tmp_path, tmp_path / "hw.zip")
    assert not ran.exists(), ran.read_text()
    points = {name: points for _, name, points, _ in list_parts(assignment)}
    assert scores.keys() == points.keys()
    assert (scores["p1-position"][0], scores["p1-jacobian"][0]) == (0, points["p1-jacobian"])
    assert 0 < scores["p1-determinant"][0] < points["p1-determinant"]
    tests = {test.number: test for test in grade_for_otter(assignment.folder, folder / "hw.ipynb", {}).tests}
    assert "sign" in tests["p1.determinant"].output
    for part, test in tests.items():  # the feedback, without Otter's report of an exception and our source
        name, is_full = make_grade_id(part), test.status == "passed"
        kind = "All test cases passed!\n{} - 1 message: " if is_full else "\n    {} - 1 result:\n        "
        lead = f"{name} results:{' ' if is_full else ''}{kind.format(name)}"
        assert scores[name][1] == lead + test.output
    ((_, problem),) = assignment.generate_problems("ada")
    output = json.dumps(scores)
    assert not [part for part in problem.parts if part.answer.as_typed() in output]


CHECK = """import otter
blank, notebook = "blank", otter.Notebook("hw.ipynb")
for environment in ({}, {"p1_jacobian": blank}, {"p1_jacobian": [[1, 2], [3, 4]]}):
    print(notebook.check("p1-jacobian", global_env=environment))
"""


@pytest.mark.integration
def test_students_check_shows_a_sentence_and_no_code(assignment: Assignment, tmp_path: Path) -> None:
    write_submission(assignment, tmp_path, None)
    command = [require_reader("python", "otter"), "-c", CHECK]
    process = subprocess.run(command, cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True)
    assert process.returncode == 0, process.stderr[-2000:]
    name, absent = "p1-jacobian", "There is no answer yet. Write it in the cell of this question, and run the cell."
    failed = [
        f"{name} results:", f"    {name} - 1 message: {absent}", "",
        f"    {name} - 1 result:", "        \u274c Test case failed",
    ]  # fmt: skip
    given = "You have given an answer; it will be graded after you submit."
    passed = [f"{name} results: All test cases passed!", f"{name} - 1 message: {given}"]
    assert process.stdout.splitlines() == [*failed, *failed, *passed]
