"""Grading a class: every kind of submission gets its result, and no student's trouble affects another."""

import csv
import json
import os
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.grader.grading.batch import grade_class, lock_folder
from qdot.grader.grading.result import Result
from qdot.grader.judging import judge as judging
from qdot.grader.reports.feedback import make_feedback_page
from qdot.grader.reports.graded_folder import write_reports
from qdot.grader.reports.grades_table import find_work_status, make_grades_csv
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import OTHER_VERSION, find_submissions
from tests.support import read_data
from tests.support.results import index_by_student
from tests.support.submitting import answer_and_submit, answer_notebook, release_class, submit, work_in_one_process

TOML = read_data("assignments/batch.toml")
STUDENTS = [f"s{i:02d}" for i in range(1, 13)]
Text = Callable[[str], str]


@pytest.fixture(scope="module")
def released_class(tmp_path_factory: pytest.TempPathFactory) -> Path:
    students = [Student(name, f"=Name {name}") for name in STUDENTS]
    return release_class(tmp_path_factory.mktemp("class") / "hw", students, TOML).folder


@pytest.fixture
def assignment(released_class: Path, tmp_path: Path) -> Assignment:
    for name in ("assignment.toml", "roster.csv", "secret.txt"):
        (tmp_path / name).write_bytes((released_class / name).read_bytes())
    for name in ("released", ".qdot"):  # the notebooks, and the problems stored for grading
        (tmp_path / name).symlink_to(released_class / name)
    return load_assignment(tmp_path)


def grade(assignment: Assignment, jobs: int = 0) -> dict[str, Result]:
    (assignment.folder / "submitted").mkdir(exist_ok=True)
    submissions = find_submissions(assignment, assignment.folder / "submitted").by_student
    with nullcontext() if jobs else work_in_one_process():  # processes can't share one
        results = grade_class(assignment, submissions, jobs, Limits(seconds=20, cell_seconds=2), lambda _: None)
    assert [result.student for result in results] == STUDENTS
    return index_by_student(results)


def test_every_kind_of_submission_gets_its_result(assignment: Assignment) -> None:
    right_notebook = answer_notebook(assignment, "s01")
    submit(assignment, "s01/hw.ipynb", right_notebook)
    submit(assignment, "s02.ipynb", answer_notebook(assignment, "s02"))
    submit(assignment, "s03/my answers.ipynb", answer_notebook(assignment, "s03"))
    submit(assignment, "s04/hw.ipynb", right_notebook)  # copied from s01
    submit(assignment, "s05/hw.ipynb", right_notebook[:3000])
    submit(assignment, "s06/hw.ipynb", b"")
    submit(assignment, "s07/hw.ipynb", right_notebook.replace('"assignment": "hw"', '"assignment": "other"'))
    submit(assignment, "s08/hw.ipynb", (assignment.folder / "released" / "s08" / "hw.ipynb").read_text())
    answer_and_submit(assignment, "s09", lambda code, part: "1/0" if part.name == "position" else code)
    submit(assignment, "s10/hw.ipynb", b"\x93\xff\0{}")
    submit(assignment, "s11/notes.txt", "no notebook")
    submit(assignment, "stranger/hw.ipynb", right_notebook)
    strangers = find_submissions(assignment, assignment.folder / "submitted").not_on_roster
    assert strangers == ["stranger"]
    graded = grade(assignment, jobs=2)
    for student in ("s01", "s02", "s03"):
        assert graded[student].score == graded[student].max_score
    assert graded["s04"].score < 2
    assert all(part.followed_from is None for part in graded["s04"].parts.values())
    assert "released to 's01'" in graded["s04"].staff_notes[0]
    assert "another student" in graded["s04"].notes[0]
    assert "s01" not in make_feedback_page(assignment, assignment.roster[3], graded["s04"])
    for student, words in {"s05": "line", "s06": "empty", "s07": "'other'", "s10": "text", "s11": "notes.txt"}.items():
        assert words in (graded[student].obstacle or "") and find_work_status(graded[student]) == "unusable"
    assert {part.outcome for part in graded["s08"].parts.values()} == {"missing"}
    with (assignment.folder / "graded" / "costs.csv").open(newline="") as file:
        costs = {row["student"]: row for row in csv.DictReader(file)}
    assert list(costs) == STUDENTS and float(costs["s01"]["seconds"]) > 0 < float(costs["s01"]["megabytes"])
    assert "ZeroDivisionError: division by zero" in graded["s09"].parts["p1.position"].reason
    assert graded["s09"].score == graded["s09"].max_score - 1
    assert (find_work_status(graded["s12"]), graded["s12"].score) == ("missing", 0)


def test_a_grade_does_not_depend_on_other_students_or_processes(assignment: Assignment) -> None:
    for student in ("s01", "s02"):
        answer_and_submit(assignment, student, lambda code, part: code if "r" in part.name else "a1")
    alone = grade(assignment)
    for path in (assignment.folder / "graded" / ".cache").glob("*.json"):
        path.unlink()
    answer_and_submit(assignment, "s03")
    with_others = grade(assignment, jobs=2)
    assert alone["s01"] == with_others["s01"]
    assert alone["s02"] == with_others["s02"]


def test_a_rerun_grades_only_changed_submissions(assignment: Assignment, monkeypatch: pytest.MonkeyPatch) -> None:
    answer_and_submit(assignment, "s01")
    first = grade(assignment)
    marked: list[str] = []
    monkeypatch.setattr("qdot.grader.grading.attempt.mark", lambda *args: marked.append(args[1]))
    assert grade(assignment) == first
    assert marked == []
    monkeypatch.undo()
    submit(assignment, "s01/hw.ipynb", answer_notebook(assignment, "s02"))
    assert grade(assignment)["s01"].score < first["s01"].score
    damaged = next((assignment.folder / "graded" / ".cache").glob("*.json"))
    damaged.write_text('{"key": ')
    assert grade(assignment)["s02"] == first["s02"]


def test_temporary_files_of_dead_processes_are_removed(assignment: Assignment) -> None:
    results = list(grade(assignment).values())
    graded = assignment.folder / "graded"
    marked = next((graded / ".cache").glob("*.json"))
    page, grades = graded / "feedback" / "s01.html", graded / "grades.csv"

    def leave_temporary_files(*paths: Path) -> None:
        for path in paths:
            path.parent.mkdir(exist_ok=True)
            path.with_name(f".{path.name}.1ra2d1o5.tmp").write_text("{")

    leave_temporary_files(marked, page, grades)
    write_reports(assignment, list(grade(assignment).values()))
    assert not list(graded.rglob("*.tmp"))
    grade_class(assignment, {}, 0, Limits(), lambda _: leave_temporary_files(marked))
    assert not list(graded.rglob("*.tmp"))
    write_reports(assignment, results, report_progress=lambda: leave_temporary_files(page, grades))
    assert not list(graded.rglob("*.tmp"))


def test_no_credit_follows_from_another_students_answers(assignment: Assignment) -> None:
    """s02 copies the answers of s01; s03 makes one mistake and continues from it."""
    problems = [problem for _, problem in assignment.generate_problems("s01")]
    copied = {part.name: part.answer.write_code() for problem in problems for part in problem.parts}
    answer_and_submit(assignment, "s02", lambda _, part: copied[part.name])
    wrong_answers = {
        "position": "{} + 0.3*Matrix([cos(theta1), sin(theta1)])",
        "jacobian": "{} + 0.3*Matrix([[-sin(theta1), 0], [cos(theta1), 0]])", "determinant": "p1_jacobian.det()",
    }  # fmt: skip
    answer_and_submit(assignment, "s03", lambda code, part: wrong_answers.get(part.name, "{}").format(code))
    graded = grade(assignment)
    assert [part.followed_from for part in graded["s02"].parts.values()] == [None] * 5
    assert graded["s02"].score < 1
    followed = graded["s03"].parts
    assert followed["p1.jacobian"].followed_from == "position" and followed["p1.determinant"].points == 0.8


def test_a_failure_of_qdot_leaves_the_part_ungraded(assignment: Assignment, monkeypatch: pytest.MonkeyPatch) -> None:
    answer_and_submit(assignment, "s01")
    monkeypatch.setattr(judging, "judge_matrix", lambda *_: 1 / 0)
    graded = grade(assignment)["s01"]
    part = graded.parts["p1.jacobian"]
    assert (part.outcome, part.points) == ("ungraded", None)
    assert "tell your instructor" in part.reason
    assert graded.parts["p1.determinant"].outcome == "correct" and find_work_status(graded) == "ungraded"


def test_staff_are_told_of_odd_notebooks(assignment: Assignment) -> None:
    submit(assignment, "s01/hw.ipynb", (assignment.folder / "released" / "s02" / "hw.ipynb").read_text())
    right_notebook = answer_notebook(assignment, "s02")
    submit(assignment, "s02/hw.ipynb", right_notebook)
    submit(assignment, "s02/old.ipynb", right_notebook)
    submit(assignment, "s03/hw.ipynb", right_notebook.replace('"kind": "student"', '"kind": "solution"'))
    outdated = right_notebook.replace(assignment.problems_digest, "0" * 16).replace('"s02"', '"s04"')
    submit(assignment, "s04/hw.ipynb", outdated)
    results = list(grade(assignment).values())
    table = list(csv.DictReader(make_grades_csv(results, assignment.roster).splitlines()))
    for row, words in zip(table, ("'s02'", "2 notebooks", "solutions", OTHER_VERSION), strict=False):
        assert words in row["note"]
    assert table[4]["note"] == ""
    assert "another version" in results[3].notes[0]


def test_a_changed_secret_is_reported_and_a_changed_title_is_not(assignment: Assignment) -> None:
    answer_and_submit(assignment, "s01")
    path = assignment.folder / "assignment.toml"
    path.write_text(path.read_text().replace('"T"', '"U"'))
    retitled = grade(load_assignment(assignment.folder))
    assert not any(result.staff_notes for result in retitled.values())
    (assignment.folder / "secret.txt").write_text("another secret of a good length")
    changed = grade(load_assignment(assignment.folder))
    assert OTHER_VERSION in changed["s01"].staff_notes


def test_an_unwritable_folder_is_an_error(assignment: Assignment) -> None:
    (assignment.folder / "graded").write_text("a file")
    with pytest.raises(QdotError, match=r"graded.*can't be written: "):
        grade(assignment)


def test_unencodable_text_costs_only_its_part(assignment: Assignment) -> None:
    text = answer_notebook(assignment, "s01", lambda code, part: '"a1 \\ud800"' if part.name == "determinant" else code)
    notebook = json.loads(text)
    notebook["metadata"]["qdot"]["student"] = "\ud800"
    submit(assignment, "s01/hw.ipynb", json.dumps(notebook))
    answer_and_submit(assignment, "s02")
    graded = grade(assignment)
    write_reports(assignment, list(graded.values()))
    assert graded["s01"].score == graded["s01"].max_score - 1
    assert graded["s01"].parts["p1.determinant"].outcome == "wrong"
    assert graded["s02"].score == graded["s02"].max_score
    assert len((assignment.folder / "graded" / "results.jsonl").read_text().splitlines()) == len(STUDENTS)


def test_a_forked_process_does_not_hold_the_lock(tmp_path: Path) -> None:
    """Otherwise a process left by a killed run would block the next run."""
    with lock_folder(tmp_path):
        pid = os.fork()
        if pid == 0:
            opened = [os.path.realpath(link) for link in Path("/proc/self/fd").iterdir()]
            os._exit(any(path.endswith("/graded/.cache/lock") for path in opened))
        assert os.waitpid(pid, 0)[1] == 0
