"""Runs that can't be right: they stop before anything is written, and say what is probably wrong."""

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
def handed_out(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    """A class whose notebooks are handed out, and come back right."""
    folder = tmp_path_factory.mktemp("check") / "hw"
    release_notebooks(
        make_class(folder, [Student(student, f"Name {student}") for student in IDS]), CERTIFIER, 1, lambda _: None
    )
    shutil.copytree(folder / "solutions", folder / "submitted", dirs_exist_ok=True)
    return load_assignment(folder)


@pytest.fixture
def folder(handed_out: Assignment, tmp_path: Path) -> Path:
    shutil.copytree(handed_out.folder, tmp_path / "hw")
    return tmp_path / "hw"


def roster(folder: Path, *ids: str) -> None:
    (folder / "roster.csv").write_text("student,name\n" + "".join(f"{one},Name {one}\n" for one in ids))


def stops(folder: Path, *submissions: Path, command: str = "grade") -> str:
    """Return what is said of a run that stops, and has written nothing."""
    before = read_folder(folder)
    said = run_and_fail(command, folder, *submissions)
    assert read_folder(folder) == before
    return said


def test_what_came_back_is_graded(folder: Path) -> None:
    assert "3 graded; mean 100.0 %" in run("grade", folder)


def test_a_single_identifier_that_a_spreadsheet_changed_is_enough(folder: Path) -> None:
    roster(folder, "12", "0013", "0014")
    assert "12 → 0012" in stops(folder)


def test_a_zip_with_a_folder_around_it_is_named_and_looked_into(folder: Path, tmp_path: Path) -> None:
    roster(folder, "12", "13", "14")
    shutil.make_archive(str(tmp_path / "week"), "zip", folder, "submitted")
    said = stops(folder, tmp_path / "week.zip")
    assert said.startswith(f"qdot: {tmp_path / 'week.zip'}: ") and "12 → 0012" in said


def test_what_was_handed_in_for_another_assignment_is_told(folder: Path) -> None:
    """As last week's folder, of the same class."""
    toml = folder / "assignment.toml"
    toml.write_text(toml.read_text().replace('key = "hw"', 'key = "week-7"'))
    assert "3 of 3 notebooks belong to another assignment ('hw')" in stops(folder)


FULL_WIDTH = {ord("0"): "\uff10"}


@pytest.mark.parametrize("now", [["12", "13", "14"], [student.translate(FULL_WIDTH) for student in IDS]])
def test_identifiers_that_a_spreadsheet_changed_are_put_beside_those_of_the_folders(
    folder: Path, now: list[str]
) -> None:
    roster(folder, *now)
    said = stops(folder)
    assert "no file or folder here belongs to a student" in said
    assert ", ".join(f"{new} → {old}" for new, old in zip(now, IDS, strict=True)) in said


def test_folders_that_have_the_new_identifiers_have_notebooks_of_the_old_ones(folder: Path) -> None:
    for student in IDS:
        (folder / "submitted" / student).rename(folder / "submitted" / student.lstrip("0"))
    roster(folder, *(student.lstrip("0") for student in IDS))
    said = stops(folder)
    assert "3 of 3 notebooks are in folders or under names of other students" in said and "12 → 0012" in said
    roster(folder, "12", "13", "14", "0012", "0013", "0014")  # as after a merge: every folder has its own student again
    assert "names of other students" in stops(folder)


def test_another_secret_is_no_zero_for_everybody(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "secret.txt").write_text("another one altogether")
    assert "3 of 3 notebooks were generated with another secret than that in " in stops(folder)
    one = folder / "submitted" / IDS[0] / "hw.ipynb"
    assert "the notebook was generated with another secret" in run_and_fail("grade", folder, one, "--student", IDS[0])
    (folder / "secret.txt").unlink()
    monkeypatch.setenv("QDOT_SECRET", "mistyped mistyped")
    assert "than that in $QDOT_SECRET" in stops(folder)


def test_the_submissions_of_another_class_are_not_graded(folder: Path) -> None:
    for student in IDS:
        (folder / "submitted" / student).rename(folder / "submitted" / f"x{student}")
    said = stops(folder)
    assert "'x0012', 'x0013', 'x0014'; the roster has '0012', '0013', '0014'" in said and "right class" in said


@pytest.mark.parametrize("command", ["generate", "verify", "export"])
def test_notebooks_that_were_handed_out_are_not_replaced_by_other_problems(folder: Path, command: str) -> None:
    """Where a spreadsheet took zeros from the roster, or the secret is another."""
    more = (Path("--to"), Path("html")) if command == "export" else ()
    roster(folder, "12", "0013", "0014", "0015")
    said = stops(folder, *more, command=command)
    assert "roster.csv: 1 student would get other problems than those in " in said and "12 → 0012" in said
    roster(folder, *IDS, "0015")
    (folder / "secret.txt").write_text("another one altogether")
    said = stops(folder, *more, command=command)
    assert "3 of 3 notebooks were generated with another secret" in said and "or delete this folder" in said


def test_notebooks_in_the_folders_of_other_students_are_told_as_that(folder: Path) -> None:
    submitted = folder / "submitted"
    submitted.rename(folder / "before")
    for student, other in zip(IDS, (*IDS[1:], IDS[0]), strict=True):
        shutil.copytree(folder / "before" / student, submitted / other)
    shutil.rmtree(folder / "before")
    said = stops(folder)
    assert "3 of 3 notebooks are in folders or under names of other students" in said
    assert "0012 has the notebook of 0014, 0013 has the notebook of 0012" in said and "mixed up" in said


def test_an_archive_in_a_zip_stays_closed_unless_it_is_a_student_s(folder: Path, tmp_path: Path) -> None:
    shutil.make_archive(str(tmp_path / "week" / "inner"), "zip", folder / "submitted")
    shutil.make_archive(str(tmp_path / "outer"), "zip", tmp_path / "week")
    said = stops(folder, tmp_path / "outer.zip")
    assert "'inner.zip'" in said and "Unpack archives first" in said


def test_files_with_more_than_the_identifier_in_their_names_are_to_be_renamed(folder: Path) -> None:
    submitted = folder / "submitted"
    for student in IDS:
        (submitted / student / "hw.ipynb").rename(submitted / f"{student}_hw-2.ipynb")
        shutil.rmtree(submitted / student)
    said = stops(folder)
    assert "'0012_hw-2.ipynb'" in said and "name each file or folder after its student, as in STUDENT.ipynb" in said


def test_one_notebook_of_somebody_else_stops_nobody(folder: Path) -> None:
    shutil.copy2(folder / "submitted" / IDS[0] / "hw.ipynb", folder / "submitted" / IDS[1] / "hw.ipynb")
    assert "3 graded" in run("grade", folder)


def test_a_damaged_zip_and_a_workbook_are_called_what_they_are(folder: Path, tmp_path: Path) -> None:
    packed = Path(shutil.make_archive(str(tmp_path / "all"), "zip", folder / "submitted"))
    (tmp_path / "half.zip").write_bytes(packed.read_bytes()[:2000])
    assert "it is damaged" in stops(folder, tmp_path / "half.zip")
    (folder / "roster.csv").write_bytes(packed.read_bytes())
    assert "roster.csv: this is an Excel workbook" in stops(folder)


def test_only_notebooks_of_usual_size_are_opened_before_grading(handed_out: Assignment, folder: Path) -> None:
    (folder / "submitted" / IDS[0] / "hw.ipynb").write_bytes(b" " * (MAX_FILE_SIZE + 1))
    (folder / "submitted" / IDS[1] / "hw.ipynb").rename(folder / "submitted" / IDS[1] / "hw.py")
    found = find_submissions(handed_out, folder / "submitted").by_student
    assert [student for student, _ in read_sample(handed_out, found, IDS)] == [IDS[2]]
