"""nbgrader itself, from generate_assignment to feedback, in a course written by `qdot export --to nbgrader`.

It runs in a separate environment with qdot (`make .venvs/readers/.installed`), and grades a class once in one process.
"""

import copy
import json
import os
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

import nbformat
import pytest

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports.export_format import ExportRequest
from qdot.exercises.exports.nbgrader import MARKS_COMMENT, compute_checksum, export_nbgrader
from qdot.exercises.problem.problem import name_answer_variable
from qdot.grader.integrations.nbgrader_cells import MAX_LINE_LENGTH, fill_in_marks, make_outputs, restore_cells
from qdot.grader.reports.part_rows import PartRow
from tests.support.command import run
from tests.support.programs import require_reader
from tests.support.submitting import TOML, grade, make_class

NAMES = ("p1-position", "p1-jacobian", "p1-determinant")
POINTS = dict(zip(("p1.position", "p1.jacobian", "p1.determinant"), (1.0, 2.0, 1.0), strict=True))
Cells = dict[str, dict[str, Any]]
STEPS = """
import json
import sys
from nbgrader.apps import NbGrader, NbGraderAPI
app = NbGrader()
app.initialize([])
api = NbGraderAPI(app.coursedir, parent=app)  # what the formgrader does; one process is enough for all of it
steps = app.config.Autograde
print(json.dumps([step.__name__ for step in steps.sanitize_preprocessors + steps.autograde_preprocessors]), flush=True)
for line in sys.stdin:
    step, *given = json.loads(line)
    done = getattr(api, step)("hw", *given)
    marks = []
    with api.gradebook as book:
        for one in book.assignment_submissions("hw") if done["success"] else []:
            found = {grade.name: grade.score for notebook in one.notebooks for grade in notebook.grades}
            found |= {note.name: note.auto_comment for notebook in one.notebooks for note in notebook.comments}
            marks.append([one.student_id, one.score - one.late_submission_penalty, one.max_score, found])
    print(json.dumps([done, marks]), flush=True)
"""
SCORES = {"late": 2.34, "wrong": 2.6, "meddles": 3, "blank": 0}


@pytest.fixture(scope="module")
def assignment(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    folder = tmp_path_factory.mktemp("course") / "hw"
    make_class(folder, [Student(name) for name in SCORES])
    late = "due = 2027-01-10T00:00:00Z\nlate = {per_day = 0.1}\n[[problem]]"
    (folder / "assignment.toml").write_text(TOML.replace("[[problem]]", late))
    run("export", folder, "--to", "nbgrader", "--jobs", "1")
    return load_assignment(folder)


def get_course(assignment: Assignment) -> Path:
    return assignment.folder / "exports" / "nbgrader"


def read_handout(assignment: Assignment, student: str) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((get_course(assignment) / "handout" / student / "hw" / "hw.ipynb").read_text())
    return content


def write_answers(assignment: Assignment, student: str, change: Callable[[list[Any], Cells], Any] | None = None) -> str:
    notebook = read_handout(assignment, student)
    cells = {cell["id"]: cell for cell in notebook["cells"]}
    ((slot, problem),) = assignment.generate_problems(student)
    for part in problem.parts:
        cells[f"{slot}-{part.name}"]["source"] = f"{name_answer_variable(slot, part.name)} = {part.answer.write_code()}"
    if change:
        change(notebook["cells"], cells)
    return json.dumps(notebook)


def answer_wrongly(_: list[Any], cells: Cells) -> None:
    cells["p1-jacobian"]["source"] += "\np1_jacobian[1, 0] = -p1_jacobian[1, 0]"
    cells["p1-determinant"]["source"] = "p1_determinant = a1"


def tamper(cells: list[Any], by_id: Cells) -> None:
    """Make every change for which nbgrader refuses a notebook or a class, or gives undeserved points."""
    cells.remove(by_id["p1-position-marks"])
    by_id["p1-jacobian-marks"]["metadata"]["nbgrader"].update(points=99, schema_version=1, grade="yes")
    by_id["p1-determinant-marks"]["source"] = "1.0"
    by_id["p1-determinant"]["source"] = "p1_determinant = a1"
    by_id["p1-determinant"]["metadata"]["nbgrader"] = 5
    cells += [{**copy.deepcopy(by_id[name]), "id": f"copy-{name}"} for name in ("p1-jacobian", "p1-jacobian-marks")]
    cells.insert(1, copy.deepcopy(by_id["p1-determinant-marks"]) | {"id": "early"})


def leave_one_blank(cells: list[Any], by_id: Cells) -> None:
    answer_wrongly(cells, by_id)
    by_id["p1-determinant"]["source"] = "p1_determinant = blank"


CHANGES = {"late": leave_one_blank, "wrong": answer_wrongly, "meddles": tamper}


class NbGrader:
    """A process of nbgrader in a course that runs the same steps as the formgrader."""

    def __init__(self, python: str, place: Path, errors: IO[str]) -> None:
        variables = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "QDOT"))}
        variables["PATH"] = f"{Path(python).parent}{os.pathsep}{variables['PATH']}"  # nbgrader calls alembic by name
        self.errors = errors
        self.process = subprocess.Popen(
            [python, "-c", STEPS], cwd=place, env=variables, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=errors, text=True,
        )  # fmt: skip
        self.configured: list[str] = self._line()

    def step(self, name: str, *arguments: str) -> list[Any]:
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps([name, *arguments]) + "\n")
        self.process.stdin.flush()
        done, marks = self._line()
        assert done["success"], done
        return list(marks)

    def _line(self) -> Any:
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert line, Path(self.errors.name).read_text()[-3000:]
        return json.loads(line)


@pytest.fixture(scope="module")
def nbgrader(assignment: Assignment, tmp_path_factory: pytest.TempPathFactory) -> Iterator[NbGrader]:
    with (tmp_path_factory.mktemp("nbgrader") / "errors.txt").open("w+") as errors:
        process = NbGrader(require_reader("python", "nbgrader"), get_course(assignment), errors)
        yield process
        process.process.communicate(timeout=60)
        assert process.process.returncode == 0


@pytest.fixture(scope="module")
def generated(assignment: Assignment, nbgrader: NbGrader) -> Path:
    nbgrader.step("generate_assignment")
    return get_course(assignment)


@pytest.fixture(scope="module")
def marked(assignment: Assignment, generated: Path, nbgrader: NbGrader) -> list[Any]:
    """The marks that nbgrader gives the class, whose notebooks are also submitted to qdot."""
    for student in (entry.id for entry in assignment.roster):
        blank = json.dumps(read_handout(assignment, student))
        text = write_answers(assignment, student, CHANGES[student]) if student in CHANGES else blank
        for target in (generated / "submitted" / student / "hw", assignment.folder / "submitted" / student):
            target.mkdir(parents=True)
            (target / "hw.ipynb").write_text(text)
            seconds = 1799625600  # 2027-01-11
            if student == "late":
                os.utime(target / "hw.ipynb", (seconds, seconds))
        if student == "late":
            (generated / "submitted" / student / "hw" / "timestamp.txt").write_text("2027-01-11 00:00:00 UTC")
    return nbgrader.step("autograde", "*")


@pytest.mark.integration
def test_source_cells_agree_with_those_that_nbgrader_writes(
    assignment: Assignment, generated: Path, nbgrader: NbGrader
) -> None:
    """Its checksums of locked cells agree, and its configuration contains qdot's steps."""
    assert nbgrader.configured[0] == "RestoreCells" and {"Mark", "ApplyLateRule"} <= set(nbgrader.configured)
    assert not {"Execute", "AssignLatePenalties"} & set(nbgrader.configured)
    released = nbformat.read(generated / "release" / "hw" / "hw.ipynb", as_version=4)
    about = {cell.metadata.nbgrader.grade_id: cell.metadata for cell in released.cells if "nbgrader" in cell.metadata}
    ours = {cell["id"]: cell["metadata"] for cell in read_handout(assignment, "late")["cells"]}
    for name in NAMES:
        theirs = json.loads(json.dumps(about[name]))
        theirs["nbgrader"].pop("cell_type", None)
        assert ours[f"{name}-marks"] == theirs


@pytest.mark.integration
def test_nbgrader_gives_the_points_of_qdot(assignment: Assignment, marked: list[Any]) -> None:
    results, _ = grade(assignment)
    assert {line[0] for line in marked} == set(results)
    for student, score, worth, scores in marked:
        parts = {f"p1-{part.name}": part.points for part in results[student].problems[0].parts}
        assert (score, worth) == (pytest.approx(results[student].score), 4), student
        assert {name: scores[name] for name in NAMES} == parts, student
        answers = {scores[f"{name}-answer"] for name in NAMES if f"{name}-answer" in scores}
        unanswered = {"blank": {"No response."}, "late": {"No response.", None}}
        assert answers == unanswered.get(student, {None}), student
    assert {line[0]: line[1] for line in marked} == pytest.approx(SCORES)


@pytest.mark.integration
def test_nbgraders_feedback_gives_the_reason(
    assignment: Assignment, generated: Path, marked: list[Any], nbgrader: NbGrader
) -> None:
    assert [line[0] for line in nbgrader.step("generate_feedback", "late")] == [line[0] for line in marked]
    results, _ = grade(assignment)
    page = (generated / "feedback" / "late" / "hw" / "hw.html").read_text()
    reason = next(part.reason for part in results["late"].problems[0].parts if part.name == "jacobian")
    assert reason.split(";")[0].split("(")[0].strip()[1:] in " ".join(page.split())  # it begins a sentence there
    assert assignment.secret not in page
    assert "self_check" not in page  # the checking code is not shown


def test_student_notebooks_are_valid_and_contain_no_secret(assignment: Assignment) -> None:
    place = get_course(assignment)
    secret = place / "qdot" / "hw" / "secret.txt"
    assert (secret.read_text().strip(), secret.stat().st_mode & 0o777) == (assignment.secret, 0o600)
    for path in (*place.glob("handout/*/hw/hw.ipynb"), place / "source" / "hw" / "hw.ipynb"):
        nbformat.validate(nbformat.read(path, as_version=4))
        assert assignment.secret not in path.read_text()
        cells = [cell for cell in json.loads(path.read_text())["cells"] if "nbgrader" in cell["metadata"]]
        names = [cell["metadata"]["nbgrader"]["grade_id"] for cell in cells]
        assert names == [made for name in NAMES for made in (f"{name}-answer", name)]
        marks = [cell for cell in cells if cell["metadata"]["nbgrader"]["grade"]]
        assert [cell["metadata"]["nbgrader"]["points"] for cell in marks] == [1, 2, 1]
        assert {cell["source"].splitlines()[-1] for cell in marks} == {"0.0"}  # no points unless qdot grades it
        assert all(cell["source"].startswith(MARKS_COMMENT) for cell in marks)


def test_tampered_notebook_is_restored(assignment: Assignment) -> None:
    untouched = restore_cells(read_handout(assignment, "late")["cells"], POINTS)
    assert [cell["id"] for cell in untouched] == [cell["id"] for cell in read_handout(assignment, "late")["cells"]]
    cells = restore_cells(json.loads(write_answers(assignment, "meddles", tamper))["cells"], POINTS)
    named = [cell["metadata"]["nbgrader"] for cell in cells if "nbgrader" in cell["metadata"]]
    assert sorted(entry["grade_id"] for entry in named if entry["grade"]) == sorted(NAMES)
    points = {entry["grade_id"]: entry["points"] for entry in named if entry["grade"]}
    assert points == dict(zip(NAMES, (1, 2, 1), strict=True))
    assert len({cell["id"] for cell in cells}) == len(cells)
    assert [cell["source"] for cell in cells].count("1.0") == 2  # the student's text stays readable
    assert sum(entry["solution"] for entry in named) == 3
    assert len(restore_cells([], POINTS)) == 3


def make_row(part: str, points: float | None, outcome: str = "partial") -> PartRow:
    return PartRow(part, "Title", outcome, points, POINTS[part], "a reason")


def test_outputs_contain_the_points_that_nbgrader_reads() -> None:
    stream, value = make_outputs(make_row("p1.jacobian", 1.5))
    assert (stream["name"], stream["text"]) == ("stdout", "partial: a reason\n")
    assert value["data"] == {"text/plain": "1.5"}
    assert make_outputs(make_row("p1.jacobian", 5))[1]["data"] == {"text/plain": "2.0"}
    long = PartRow("p1.jacobian", "Title", "partial", 1.5, 2.0, "a reason " * 30)
    assert max(map(len, make_outputs(long)[0]["text"].splitlines())) <= MAX_LINE_LENGTH
    (error,) = make_outputs(make_row("p1.jacobian", 0, "wrong"))
    assert (error["output_type"], error["ename"], error["evalue"]) == ("error", "wrong", "a reason")
    assert all(word in " ".join(error["traceback"]) for word in ("Title", "0 of 2", "wrong", "a reason"))


def test_missing_or_ungraded_mark_is_refused() -> None:
    rows = [make_row(part, 1.0) for part in POINTS]
    cells = restore_cells([], POINTS)
    fill_in_marks(cells, rows)
    assert all(cell["outputs"] for cell in cells)
    for points, marked, message in (
        (POINTS, [*rows[:2], make_row("p1.determinant", None)], "p1-determinant: there is no mark, because qdot"),
        (POINTS, rows[:2], "p1-determinant: "),
        ({**POINTS, "p1.position": 7.0}, rows, "p1-position: .* other points"),
        ({"p1.jacobian": 2.0, "p1.determinant": 1.0}, rows, "p1-position: "),
    ):
        with pytest.raises(QdotError, match=message):
            fill_in_marks(restore_cells([], points), marked)


def test_blank_answer_counts_as_unchanged() -> None:
    notebook = [
        {"cell_type": "code", "id": name, "metadata": {"qdot": {"part": f"p1.{name}"}}, "source": source}
        for name, source in (("position", "p1_position = blank"), ("jacobian", "p1_jacobian = ("))
    ]
    cells = restore_cells(notebook, POINTS)
    missing = [make_row(part, 0, "missing") for part in ("p1.position", "p1.jacobian")]
    fill_in_marks(cells, [*missing, make_row("p1.determinant", 1)])
    by_id = {cell["id"]: cell["metadata"]["nbgrader"] for cell in cells}
    assert by_id["position"]["checksum"] == compute_checksum(cells[0])
    assert "checksum" not in by_id["jacobian"]


def test_student_list_is_importable_and_names_invalid_ids(tmp_path: Path) -> None:
    students = [Student("ada", "Ada King Lovelace", "ada@example.org"), Student("hen"), Student("ada+x")]
    notes: list[str] = []
    export_request = ExportRequest(make_class(tmp_path / "hw", students), lambda _: (), report=notes.append)
    (names,) = (str(file.content) for file in export_nbgrader(export_request) if file.path == "students.csv")
    assert names.splitlines()[:3] == [
        "id,first_name,last_name,email", "ada,Ada King,Lovelace,ada@example.org", "hen,,,"
    ]  # fmt: skip
    assert len(notes) == 1 and notes[0].startswith("ada+x: ")
