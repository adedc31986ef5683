"""Runs on the wrong files stop before anything is written, and say what is probably wrong."""

import shutil
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import release_notebooks
from qdot.grader.grading.certify import CERTIFIER
from qdot.grader.grading.class_check import MAX_FILE_SIZE, read_sample
from qdot.grader.submissions.submission import find_submissions
from tests.support.command import run, run_and_fail
from tests.support.submitting import make_class, read_folder

IDS = ("0012", "0013", "0014")


@pytest.fixture(scope="module")
def graded_class(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    folder = tmp_path_factory.mktemp("check") / "hw"
    release_notebooks(
        make_class(folder, [Student(student, f"Name {student}") for student in IDS]), CERTIFIER, 1, lambda _: None
    )
    shutil.copytree(folder / "solutions", folder / "submitted", dirs_exist_ok=True)
    return load_assignment(folder)


@pytest.fixture
def folder(graded_class: Assignment, tmp_path: Path) -> Path:
    shutil.copytree(graded_class.folder, tmp_path / "hw")
    return tmp_path / "hw"


def write_roster(folder: Path, *ids: str) -> None:
    (folder / "roster.csv").write_text("student,name\n" + "".join(f"{student},Name {student}\n" for student in ids))


def run_stopped(folder: Path, *submissions: Path, command: str = "grade") -> str:
    before = read_folder(folder)
    message = run_and_fail(command, folder, *submissions)
    assert read_folder(folder) == before
    return message


def test_matching_submissions_are_graded(folder: Path) -> None:
    assert "3 graded; mean 100.0 %" in run("grade", folder)


def test_one_id_changed_by_a_spreadsheet_stops_the_run(folder: Path) -> None:
    write_roster(folder, "12", "0013", "0014")
    assert "12 → 0012" in run_stopped(folder)


def test_a_zip_with_an_enclosing_folder_is_checked(folder: Path, tmp_path: Path) -> None:
    write_roster(folder, "12", "13", "14")
    shutil.make_archive(str(tmp_path / "week"), "zip", folder, "submitted")
    message = run_stopped(folder, tmp_path / "week.zip")
    assert message.startswith(f"qdot: {tmp_path / 'week.zip'}: ") and "12 → 0012" in message


def test_submissions_for_another_assignment_are_recognised(folder: Path) -> None:
    """For example, last week's folder of the same class."""
    toml = folder / "assignment.toml"
    toml.write_text(toml.read_text().replace('key = "hw"', 'key = "week-7"'))
    assert "3 of 3 notebooks belong to another assignment ('hw')" in run_stopped(folder)


FULL_WIDTH = {ord("0"): "\uff10"}


@pytest.mark.parametrize("new_ids", [["12", "13", "14"], [student.translate(FULL_WIDTH) for student in IDS]])
def test_ids_changed_by_a_spreadsheet_are_matched_with_folders(folder: Path, new_ids: list[str]) -> None:
    write_roster(folder, *new_ids)
    message = run_stopped(folder)
    assert "no file or folder here belongs to a student" in message
    assert ", ".join(f"{new} → {old}" for new, old in zip(new_ids, IDS, strict=True)) in message


def test_folders_with_changed_ids_hold_notebooks_of_the_old_ids(folder: Path) -> None:
    for student in IDS:
        (folder / "submitted" / student).rename(folder / "submitted" / student.lstrip("0"))
    write_roster(folder, *(student.lstrip("0") for student in IDS))
    message = run_stopped(folder)
    assert "3 of 3 notebooks are in folders or under names of other students" in message and "12 → 0012" in message
    # After merging two rosters, every folder has a student again.
    write_roster(folder, "12", "13", "14", "0012", "0013", "0014")
    assert "names of other students" in run_stopped(folder)


def test_another_secret_stops_the_run(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "secret.txt").write_text("another one altogether")
    assert "3 of 3 notebooks were generated with a different secret from the one in " in run_stopped(folder)
    path = folder / "submitted" / IDS[0] / "hw.ipynb"
    message = run_and_fail("grade", folder, path, "--student", IDS[0])
    assert "the notebook was generated with a different secret" in message
    (folder / "secret.txt").unlink()
    monkeypatch.setenv("QDOT_SECRET", "mistyped mistyped")
    assert "from the one in $QDOT_SECRET" in run_stopped(folder)


def test_submissions_of_another_class_are_not_graded(folder: Path) -> None:
    for student in IDS:
        (folder / "submitted" / student).rename(folder / "submitted" / f"x{student}")
    message = run_stopped(folder)
    assert "'x0012', 'x0013', 'x0014'; the roster has '0012', '0013', '0014'" in message and "right class" in message


@pytest.mark.parametrize("command", ["generate", "verify", "export"])
def test_released_notebooks_are_not_replaced_by_other_problems(folder: Path, command: str) -> None:
    """The problems would differ if a spreadsheet removed zeros from the roster, or if the secret changed."""
    options = (Path("--to"), Path("html")) if command == "export" else ()
    write_roster(folder, "12", "0013", "0014", "0015")
    message = run_stopped(folder, *options, command=command)
    assert "roster.csv: 1 student would get different problems from those in " in message and "12 → 0012" in message
    write_roster(folder, *IDS, "0015")
    (folder / "secret.txt").write_text("another one altogether")
    message = run_stopped(folder, *options, command=command)
    assert "3 of 3 notebooks were generated with a different secret" in message and "or delete this folder" in message


def test_mixed_up_notebooks_are_recognised(folder: Path) -> None:
    submitted = folder / "submitted"
    submitted.rename(folder / "before")
    for student, new_owner in zip(IDS, (*IDS[1:], IDS[0]), strict=True):
        shutil.copytree(folder / "before" / student, submitted / new_owner)
    shutil.rmtree(folder / "before")
    message = run_stopped(folder)
    assert "3 of 3 notebooks are in folders or under names of other students" in message
    assert "0012 has the notebook of 0014, 0013 has the notebook of 0012" in message and "mixed up" in message


def test_an_archive_inside_a_zip_is_not_opened(folder: Path, tmp_path: Path) -> None:
    shutil.make_archive(str(tmp_path / "week" / "inner"), "zip", folder / "submitted")
    shutil.make_archive(str(tmp_path / "outer"), "zip", tmp_path / "week")
    message = run_stopped(folder, tmp_path / "outer.zip")
    assert "'inner.zip'" in message and "Unpack archives first" in message


def test_files_with_longer_names_must_be_renamed(folder: Path) -> None:
    submitted = folder / "submitted"
    for student in IDS:
        (submitted / student / "hw.ipynb").rename(submitted / f"{student}_hw-2.ipynb")
        shutil.rmtree(submitted / student)
    message = run_stopped(folder)
    assert "'0012_hw-2.ipynb'" in message
    assert "name each file or folder after its student, as in STUDENT.ipynb" in message


def test_one_copied_notebook_does_not_stop_the_run(folder: Path) -> None:
    shutil.copy2(folder / "submitted" / IDS[0] / "hw.ipynb", folder / "submitted" / IDS[1] / "hw.ipynb")
    assert "3 graded" in run("grade", folder)


def test_a_damaged_zip_and_an_excel_roster_are_recognised(folder: Path, tmp_path: Path) -> None:
    packed = Path(shutil.make_archive(str(tmp_path / "all"), "zip", folder / "submitted"))
    (tmp_path / "half.zip").write_bytes(packed.read_bytes()[:2000])
    assert "it is damaged" in run_stopped(folder, tmp_path / "half.zip")
    (folder / "roster.csv").write_bytes(packed.read_bytes())
    assert "roster.csv: this is an Excel workbook" in run_stopped(folder)


def test_only_notebooks_of_usual_size_are_sampled(graded_class: Assignment, folder: Path) -> None:
    (folder / "submitted" / IDS[0] / "hw.ipynb").write_bytes(b" " * (MAX_FILE_SIZE + 1))
    (folder / "submitted" / IDS[1] / "hw.ipynb").rename(folder / "submitted" / IDS[1] / "hw.py")
    submissions = find_submissions(graded_class, folder / "submitted").by_student
    assert [student for student, _ in read_sample(graded_class, submissions, IDS)] == [IDS[2]]
