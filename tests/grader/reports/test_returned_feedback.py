"""`qdot return`: each page goes to its own student, by the rules of the platforms' importers."""

import csv
import io
import re
import shutil
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.assignment.release import release_notebooks
from qdot.grader.cli.main import app
from qdot.grader.grading.certify import CERTIFIER
from tests.support.command import run, run_and_fail, runner
from tests.support.submitting import make_class, make_correct_notebook, work_in_one_process

STUDENTS = (
    Student("501", "Ada Lovelace", "ada@example.org"), Student("502", "Wei Li", "wei@example.org"),
    Student("503", "Wei Li", "li@example.org"), Student("504", "Zoë Núñez O'Brien", "zoe@example.org"),
)  # fmt: skip
NUMBERS = {"501": 11, "502": 12, "503": 13, "504": 14}
"""The platforms' numbers of the students who submit; the roster has them, because two names are equal."""

Names = Callable[[Student, int], str]
NAMES: dict[str, Names] = {
    "moodle": lambda student, number: f"{student.name}_{number}_assignsubmission_file/hw.ipynb",
    "moodle 4.0": lambda student, number: f"{student.name}_{number}_assignsubmission_file_/hw.ipynb",
    "moodle without folders": lambda student, number: f"{student.name}_{number}_assignsubmission_file_hw.ipynb",
    "canvas": lambda student, number: f"{''.join(reversed(student.name.lower().split()))}_{number}_9{number}_hw.ipynb",
    "canvas late": lambda student, number: f"lila_LATE_{number}_9{number}_hw_2-1.ipynb",
    "brightspace": lambda student, number: f"{number}-777 - {student.name} - Jan 15, 2027 1159 PM/hw.ipynb",
}


@pytest.fixture(scope="module")
def released_class(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a class whose roster has the platforms' numbers in a column."""
    assignment = make_class(tmp_path_factory.mktemp("return") / "hw", STUDENTS)
    lines = (f"{s.id},{s.name},{s.email},{NUMBERS[s.id]}" for s in STUDENTS)
    (assignment.folder / "roster.csv").write_text("\n".join(("student,name,email,user id", *lines)) + "\n")
    release_notebooks(load_assignment(assignment.folder), CERTIFIER, 1, lambda _: None)
    return assignment.folder


@pytest.fixture
def folder(released_class: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(released_class, tmp_path / "hw"))


def grade_download(folder: Path, layout: str, notebooks_of: Mapping[str, str] = {}) -> Path:
    """Grade a platform's download in which all but the last student submit; return the zip.

    `notebooks_of` has the owner of the notebook of each student who submits another student's.
    """
    assignment = load_assignment(folder)
    download = folder.parent / "download.zip"
    with zipfile.ZipFile(download, "w") as archive:
        for student in STUDENTS[:-1]:
            name = NAMES[layout](student, NUMBERS[student.id])
            archive.writestr(name, make_correct_notebook(assignment, notebooks_of.get(student.id, student.id)))
    with work_in_one_process():
        run("grade", folder, download, "--jobs", "1")
    return download


def read_zip(path: Path) -> dict[str, str]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name).decode() for name in archive.namelist()}


def find_moodle_number(name: str) -> int:
    """Return the participant's number that Moodle finds in a path, by the rules of its importer."""
    parts = name.split("/")
    while parts:
        info = parts.pop(0).split("_", 4)
        if len(info) >= 4 and info[1].isdigit() and info[2:4] == ["assignsubmission", "file"]:
            return int(info[1])
    raise AssertionError(name)


def find_canvas_number(name: str) -> int:
    """Return the user's number that Canvas finds in a name, if the number after it is that of the user's file."""
    words = [word for word in Path(name).name.split("_") if word != "LATE"]
    user, attachment = [word for word in words if re.fullmatch(r"\d+", word)][:2]
    assert attachment == f"9{user}" and not words[-1].startswith("link")
    return int(user)


def find_brightspace_number(name: str) -> int:
    return int(name.partition("-")[0])


FINDERS = {"moodle": find_moodle_number, "canvas": find_canvas_number, "brightspace": find_brightspace_number}


@pytest.mark.parametrize("layout", NAMES)
def test_each_page_reaches_its_student(layout: str, folder: Path) -> None:
    download, platform = grade_download(folder, layout), layout.partition(" ")[0]
    completed = runner.invoke(app, ["return", str(folder), str(download), "--to", platform])
    assert completed.exit_code == 0 and "1 student without a submission gets no page: 504" in completed.stderr
    pages = read_zip(folder / "returned" / platform / f"{platform}-feedback.zip")
    students = {number: student for student, number in NUMBERS.items()}
    found_pages = {students[FINDERS[platform](name)]: page for name, page in pages.items()}
    feedback = folder / "graded" / "feedback"
    assert found_pages == {student.id: (feedback / f"{student.id}.html").read_text() for student in STUDENTS[:-1]}
    assert all(name.endswith("hw-feedback.html") for name in pages)
    assert (folder / "returned" / platform / f"{platform}-grades.csv").stat().st_mode & 0o777 == 0o600


def test_a_folder_has_pages_that_a_person_recognises(folder: Path) -> None:
    grade_download(folder, "moodle")
    run("return", folder, "--to", "folder", "--out", folder / "pages")
    assert sorted(path.name for path in (folder / "pages").iterdir()) == [
        "Li, Wei (502).html", "Li, Wei (503).html", "Lovelace, Ada (501).html", "O'Brien, Zoë Núñez (504).html",
        "grades.csv",
    ]  # fmt: skip
    rows = list(csv.DictReader(io.StringIO((folder / "pages" / "grades.csv").read_text(encoding="utf-8-sig"))))
    assert {row["student"]: row["file"] for row in rows}["502"] == "Li, Wei (502).html"
    assert all((folder / "pages" / row["file"]).exists() for row in rows) and len(rows) == 4


def test_nothing_is_written_for_a_page_without_a_place(folder: Path) -> None:
    download = grade_download(folder, "moodle")
    for arguments, message in (
        ((download, "--to", "canvas"), "no submission of 501, 502, 503 has a name from Canvas"),
        (("--to", "moodle"), "501, 502, 503 has a name from Moodle"), ((download,), "--to moodle"),
        ((download, "--to", "moodel"), "did you mean 'moodle'"),
    ):  # fmt: skip
        assert message in run_and_fail("return", folder, *arguments)
    (folder / "graded" / "feedback" / "502.html").unlink()
    assert "502.html does not exist; run: qdot grade" in run_and_fail("return", folder, download, "--to", "moodle")
    assert not (folder / "returned").exists()


@pytest.mark.parametrize("notebooks_of", [{}, {"502": "503", "503": "502"}])
def test_notebooks_tell_equal_names_apart(folder: Path, notebooks_of: Mapping[str, str]) -> None:
    """Each notebook is graded as the work of the student whom it names, if all students with that name submit one."""
    remove_numbers(folder)
    download = grade_download(folder, "moodle", notebooks_of)
    assert {row["score"] for row in read_grades(folder)[:3]} == {"4"}
    run("return", folder, download, "--to", "moodle")
    pages = read_zip(folder / "returned" / "moodle" / "moodle-feedback.zip")
    for student in STUDENTS[:-1]:
        page = (folder / "graded" / "feedback" / f"{notebooks_of.get(student.id, student.id)}.html").read_text()
        assert pages[f"{student.name}_{NUMBERS[student.id]}_assignsubmission_file/hw-feedback.html"] == page


def remove_numbers(folder: Path) -> None:
    lines = [f"{student.id},{student.name},{student.email}" for student in STUDENTS]
    (folder / "roster.csv").write_text("\n".join(("student,name,email", *lines)) + "\n")


def read_grades(folder: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO((folder / "graded" / "grades.csv").read_text())))


def test_the_worksheet_of_the_handout_tells_equal_names_apart(folder: Path) -> None:
    remove_numbers(folder)
    download = grade_download(folder, "moodle", {"503": "502"})
    message = run_and_fail("return", folder, download, "--to", "moodle")
    assert "a submission may belong to 502, 503, but not certainly; do what `qdot grade" in message
    rows = (f"Participant {NUMBERS[student.id]},{student.name},{student.email}" for student in STUDENTS)
    (folder / "sheet.csv").write_text("\n".join(("Identifier,Full name,Email address", *rows)) + "\n")
    run("release", folder, folder / "sheet.csv", "--to", "moodle")
    grade_download(folder, "moodle", {"503": "502"})
    run("return", folder, download, "--to", "moodle")
    pages = read_zip(folder / "returned" / "moodle" / "moodle-feedback.zip")
    for student in STUDENTS[:-1]:
        page = (folder / "graded" / "feedback" / f"{student.id}.html").read_text()
        assert pages[f"{student.name}_{NUMBERS[student.id]}_assignsubmission_file/hw-feedback.html"] == page


def test_canvas_places_no_page_beside_a_submitted_text(folder: Path) -> None:
    download = grade_download(folder, "canvas")
    with zipfile.ZipFile(folder.parent / "texts.zip", "w") as archive:
        archive.writestr("lovelaceada_11_text.html", "x")
        archive.writestr("liwei_12_912_hw.ipynb", zipfile.ZipFile(download).read("liwei_12_912_hw.ipynb"))
        archive.writestr("liwei_13_913_hw.ipynb", zipfile.ZipFile(download).read("liwei_13_913_hw.ipynb"))
    message = run_and_fail("return", folder, folder.parent / "texts.zip", "--to", "canvas")
    assert "no submission of 501 has a name from Canvas" in message


def test_brightspace_imports_the_marks_of_those_who_have_one(folder: Path) -> None:
    download = grade_download(folder, "brightspace")
    run("return", folder, download, "--to", "brightspace")
    table = (folder / "returned" / "brightspace" / "brightspace-grades.csv").read_text()
    header, *rows = csv.reader(io.StringIO(table))
    assert header == ["Username", "T Points Grade", "End-of-Line Indicator"]
    assert rows == [[student.id, "4", "#"] for student in STUDENTS[:-1]]
    roster = (folder / "roster.csv").read_text()
    (folder / "roster.csv").write_text(roster.replace("user id", "OrgDefinedId"))
    table = run("report", folder, "--report", "brightspace=-")
    assert table.splitlines()[:2] == ["OrgDefinedId,T Points Grade,End-of-Line Indicator", "11,4,#"]


def test_a_student_who_is_forgotten_leaves_no_returned_page(folder: Path) -> None:
    grade_download(folder, "moodle")
    run("return", folder, "--to", "folder")
    run("forget", "501", folder, "--yes")
    assert not (folder / "returned").exists()
