"""Downloads of learning platforms: whose each file is and when it was submitted, without guessing."""

import datetime
import io
import json
import os
import shutil
import stat
import zipfile
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.grader.reports.grades_table import find_work_status
from qdot.grader.submissions.layouts import SubmittedPath, find_submitted_paths
from qdot.grader.submissions.roster import Roster
from qdot.grader.submissions.submission import UNCERTAIN_OWNER, find_submissions, open_submissions
from tests.support import DATA, read_cases
from tests.support.results import get_received_time
from tests.support.submitting import ALL_CORRECT, grade, list_outcomes, make_class, make_correct_notebook, submit

pytestmark = pytest.mark.xdist_group("layouts")
DOWNLOADS = DATA / "downloads"
EXPORTS = json.loads((DOWNLOADS / "exports.json").read_text(encoding="utf-8"))
"""The files of students, and those of strangers, in the download of each platform."""
GRADESCOPE = (DOWNLOADS / "submission_metadata.yml").read_text(encoding="utf-8")


@pytest.fixture
def assignment(tmp_path: Path) -> Assignment:
    folder = tmp_path / "hw"
    make_class(folder, [Student("s")])
    shutil.copyfile(DOWNLOADS / "roster.csv", folder / "roster.csv")
    return load_assignment(folder)


def find_owners(assignment: Assignment, *paths: str) -> tuple[dict[str, list[str]], list[str], list[str]]:
    for path in paths:
        submit(assignment, path, "{}")
    submissions = find_submissions(assignment, assignment.folder / "submitted")
    root = assignment.folder / "submitted"
    files = {
        student: [str(path.relative_to(root)) for path in submission.files]
        for student, submission in submissions.by_student.items()
        if not submission.ungraded_reason
    }
    return files, submissions.not_on_roster, submissions.uncertain_owners


@pytest.mark.parametrize("parent", ["", "submitted/", "Week 6/submissions/", "a/b/c/d/"])
@pytest.mark.parametrize("name", EXPORTS)
def test_each_file_is_assigned_to_its_owner(assignment: Assignment, name: str, parent: str) -> None:
    """Roster ids take precedence and ignore case; files outside submissions are nobody's; outer folders are opened."""
    students, strangers_files = EXPORTS[name]["students"], EXPORTS[name]["strangers"]
    expected = {student: [f"{parent}{path}" for path in paths] for student, paths in students.items()}
    other_file = {"Brightspace": "index.html", "Blackboard": "Week 6_ada_attempt_2026-11-21-22-05-07.txt"}.get(name, "")
    others = [] if parent else [other_file] if other_file else [] if strangers_files else ["grades.csv", "README.txt"]
    paths = [path for files in expected.values() for path in files]
    owned, strangers, uncertain = find_owners(
        assignment, *paths, *(f"{parent}{path}" for path in strangers_files), *others
    )
    assert (owned, strangers, uncertain) == (expected, [path.split("/")[0] for path in strangers_files], [])
    submissions = find_submissions(assignment, assignment.folder / "submitted").by_student
    flagged = {student for student in expected if submissions[student].flagged_late}
    assert flagged == {student for student, (path, *_) in expected.items() if "LATE" in path}


def test_gradescope_metadata_has_owners_and_times(assignment: Assignment) -> None:
    paths = [f"assignment_7_export/submission_{n}/hw.ipynb" for n in (11, 12, 13, 14)]
    assert find_owners(assignment, *paths)[1] == ["assignment_7_export"]
    submit(assignment, "assignment_7_export/submission_metadata.yml", GRADESCOPE)
    owned, strangers, uncertain = find_owners(assignment)
    assert {student: files[0].split("/")[1] for student, files in owned.items()} == {
        "ada1": "submission_11", "hen": "submission_12", "jose": "submission_12",
    }  # fmt: skip
    assert strangers == ["submission_13", "submission_14"] and not uncertain
    submissions = find_submissions(assignment, assignment.folder / "submitted").by_student
    assert submissions["ada1"].received == datetime.datetime(2026, 11, 20, 10, 11, 12, tzinfo=datetime.UTC)
    assert submissions["hen"].received == datetime.datetime(2026, 11, 21, 7, 30, tzinfo=datetime.UTC)
    assert submissions["ada1"].platform == "Gradescope"


def test_a_damaged_or_linked_metadata_file_is_ignored(assignment: Assignment, tmp_path: Path) -> None:
    for content in (b"\xff\xfe\0", b"- [", b'submission_1:\n  :submitters:\n  - :name: "\\', b":" * 10**6):
        submit(assignment, "submission_metadata.yml", content)
        assert find_owners(assignment, "ada1/hw.ipynb")[0] == {"ada1": ["ada1/hw.ipynb"]}
    (tmp_path / "other.yml").write_text(GRADESCOPE)
    (assignment.folder / "submitted" / "submission_metadata.yml").unlink()
    (assignment.folder / "submitted" / "submission_metadata.yml").symlink_to(tmp_path / "other.yml")
    assert find_owners(assignment, "submission_11/hw.ipynb")[1] == ["submission_11"]


def test_folder_names_are_shown_on_one_line(assignment: Assignment) -> None:
    names = ("a\nqdot: all is well\x1b[2J", "x\\..\\..", "🦾 José", "y" * 200, "%s{0}\u202e")
    _, strangers, uncertain = find_owners(assignment, *(f"{name}/hw.ipynb" for name in names), "José\n Díaz_5_x.ipynb")
    assert len(strangers) == 6 and not uncertain
    assert all(name.isprintable() or "\N{REPLACEMENT CHARACTER}" in name for name in strangers)
    assert not set("\n\x1b\u202e") & set("".join(strangers)) and max(map(len, strangers)) <= 120


def test_an_ambiguous_owner_is_never_guessed(assignment: Assignment) -> None:
    submit(assignment, "Ada Lovelace_44_assignsubmission_file_/hw.ipynb", make_correct_notebook(assignment, "ada1"))
    submit(assignment, "Henri Poincaré_9_assignsubmission_file_/hw.ipynb", make_correct_notebook(assignment, "hen"))
    submit(assignment, "José Díaz_1003_assignsubmission_file_/hw.ipynb", make_correct_notebook(assignment, "jose"))
    results, submissions = grade(assignment)
    same_name, contradiction = submissions.uncertain_owners
    assert same_name.startswith("Ada Lovelace_44_assignsubmission_file_ may belong to ada1 or ada2: ")
    assert same_name.endswith(" of the owner in roster.csv (the grading worksheet has the numbers)")
    assert contradiction.startswith("José Díaz_1003_assignsubmission_file_ may belong to hen or jose: ")
    for student in ("ada1", "ada2", "jose"):
        assert results[student].obstacle == UNCERTAIN_OWNER and find_work_status(results[student]) == "unusable"
    assert list_outcomes(results["hen"]) == ALL_CORRECT
    assert find_work_status(results["eve"]) == "missing"


@pytest.mark.parametrize(("ids", "name", "students"), read_cases("answers")["owners"])
def test_identifiers_come_before_names(ids: list[str], name: str, students: str) -> None:
    twins = [Student("ada", "Ada Lovelace", "twins@x.org"), Student("bo", "Bo Lovelace", "twins@x.org")]
    path = SubmittedPath(Path("hw.ipynb"), tuple(ids), name)
    match = Roster([*twins, Student("cy", "Cy Ada", "cy@x.org")]).find_owner(path)
    assert " ".join(match.students) == students
    assert bool(match.reason) == (len(match.students) > 1)


@pytest.mark.parametrize(("platform", "name", "students"), read_cases("answers")["numbers_of_moodle"])
def test_a_number_from_the_handout_identifies_a_student_in_moodle(platform: str, name: str, students: str) -> None:
    twins = (Student("a", "Ada Lovelace"), Student("b", "Ada Lovelace"), Student("bo", "Bo Boole"))
    roster = Roster(twins, {"17": "a", "18": "left the course"})
    match = roster.find_owner(SubmittedPath(Path("hw.ipynb"), ("17",), name, platform))
    assert " ".join(match.students) == students


def test_the_names_of_folders_that_were_handed_out_identify_students() -> None:
    roster = Roster([Student("1", "Wei Li"), Student("2", "Wei Li")])
    owners = [roster.find_owner(SubmittedPath(Path(name), (), name)) for name in ("Li, Wei (2)", "velocity (1)")]
    assert [owner.students for owner in owners] == [("2",), ()]


def test_a_section_does_not_identify_a_student() -> None:
    student = Student("a", "", "", (("section", "17"), ("seat number", "17"), ("Student ID".lower(), "18"), ("id", "")))
    roster = Roster([student])
    assert roster.find_owner(SubmittedPath(Path("x"), ("17",), "Participant")).students == ()
    assert roster.find_owner(SubmittedPath(Path("x"), ("18",), "Participant")).students == ("a",)
    assert roster.find_owner(SubmittedPath(Path("x"), ("",), "")).students == ()


def test_submission_times_come_from_the_best_source(assignment: Assignment) -> None:
    toml = assignment.folder / "assignment.toml"
    toml.write_text(toml.read_text().replace('key = "hw"', 'key = "hw"\ndue = 2026-11-20T12:00:00Z'))
    assignment = load_assignment(assignment.folder)
    submit(assignment, "submission_metadata.yml", GRADESCOPE)
    submit(assignment, "submission_11/hw.ipynb", make_correct_notebook(assignment, "ada1"))
    submit(assignment, "lovelaceada_502_9002_hw.ipynb", make_correct_notebook(assignment, "ada2"))
    submit(assignment, "poincaréhenri_LATE_503_9003_hw.ipynb", make_correct_notebook(assignment, "hen"))
    late_path = submit(assignment, "jose/hw.ipynb", make_correct_notebook(assignment, "jose"))
    for path in (late_path, *(assignment.folder / "submitted").glob("*_hw.ipynb")):
        os.utime(path, (1_800_000_000, 1_800_000_000))
    results, _ = grade(assignment)
    work = {student: result.submission for student, result in results.items() if result.submission}
    from_file = dict.fromkeys(("ada2", "hen", "jose"), "file")
    sources = {student: submission.received_from for student, submission in work.items()}
    assert sources == {"ada1": "Gradescope", **from_file}
    assert {student for student in work if results[student].late} == {"hen", "jose"}
    assert get_received_time(results["ada1"]) == "2026-11-20T10:11:12+00:00"
    assert "the platform marked it as late" in results["hen"].staff_notes


def write_zip(path: Path, assignment: Assignment, *, hostile: bool = False) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        for name, student in (("Henri Poincare\u0301", "hen"), ("José Díaz", "jose")):
            info = zipfile.ZipInfo(f"{name}_9_assignsubmission_file_/hw.ipynb", (2026, 11, 20, 10, 0, 0))
            archive.writestr(info, make_correct_notebook(assignment, student))
        if hostile:
            archive.writestr("../../evil.ipynb", "{}")
            archive.writestr("/etc/evil.ipynb", "{}")
            archive.writestr("a\\..\\..\\evil.ipynb", "{}")
            link = zipfile.ZipInfo("ada1/hw.ipynb")
            link.external_attr = (stat.S_IFLNK | 0o777) << 16
            archive.writestr(link, str(assignment.folder / "secret.txt"))
            archive.writestr("ada2/" + "long" * 100 + ".ipynb", "{}")
            with zipfile.ZipFile(buffer := io.BytesIO(), "w") as inner_archive:
                inner_archive.writestr("x/readme.txt", "no notebook")
            archive.writestr("ada2/hw.zip", buffer.getvalue())
    return path


def test_a_zip_file_is_graded_without_unpacking(assignment: Assignment, tmp_path: Path) -> None:
    results, _ = grade(assignment, write_zip(tmp_path / "moodle.zip", assignment))
    assert list_outcomes(results["hen"]) == list_outcomes(results["jose"]) == ALL_CORRECT
    local = datetime.datetime(2026, 11, 20, 10).astimezone().astimezone(datetime.UTC)
    assert get_received_time(results["hen"]) == local.isoformat()


def test_a_hostile_zip_writes_nothing_outside(
    assignment: Assignment, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = set(tmp_path.rglob("*"))
    path = write_zip(tmp_path / "evil.zip", assignment, hostile=True)
    with open_submissions(path) as root:
        unpacked = {str(member.relative_to(root)) for member in root.rglob("*") if not member.is_dir()}
        assert not any(member.is_symlink() for member in root.rglob("*"))
        results, _ = grade(assignment, root)
    assert not root.exists()
    assert len(unpacked) == 4 and not [name for name in unpacked if "evil" in name]
    warnings = [line.split(":")[0].replace("\\", "/") for line in capsys.readouterr().err.splitlines()]
    assert warnings == ["../../evil.ipynb", "/etc/evil.ipynb", "a/../../evil.ipynb", "ada1/hw.ipynb"]
    assert set(tmp_path.rglob("*.ipynb")) <= before
    assert list_outcomes(results["hen"]) == ALL_CORRECT and find_work_status(results["ada1"]) == "missing"


def test_a_file_that_is_no_zip_is_an_error(assignment: Assignment, tmp_path: Path) -> None:
    path = tmp_path / "grades.csv"
    path.write_text("a")
    with pytest.raises(QdotError, match="is neither a folder with"), open_submissions(path) as root:
        find_submissions(assignment, root)
    write_zip(tmp_path / "m.zip", assignment)
    data = (tmp_path / "m.zip").read_bytes()
    (tmp_path / "m.zip").write_bytes(data[:200] + b"\xff" * 400 + data[600:])
    with open_submissions(tmp_path / "m.zip") as root:
        assert len(list(root.rglob("*.ipynb"))) <= 2


@pytest.mark.parametrize("folder", ["jose", "Jose Diaz_5_assignsubmission_file_", "José Díaz"])
def test_metadata_in_a_students_folder_is_ignored(assignment: Assignment, folder: str) -> None:
    """Jose, the first to submit, adds a metadata file that assigns the work to others."""
    submit(assignment, f"{folder}/submission_metadata.yml", GRADESCOPE)
    owned, strangers, uncertain = find_owners(assignment, f"{folder}/submission_11/hw.ipynb", f"{folder}/hw.ipynb")
    assert owned["jose"][0] == f"{folder}/hw.ipynb"
    assert list(owned) == ["jose"] and not strangers and not uncertain


def test_similar_names_match_no_platform(tmp_path: Path) -> None:
    for name in ("ada_lovelace", "hw_1_2", "x_assignsubmission_file_", "_1_2_x.ipynb", "submission_1"):
        (tmp_path / name).mkdir()
    paths = find_submitted_paths(tmp_path)
    assert [path.platform for path in paths] == [""] * 5


def test_folders_inside_a_students_folder_are_no_students(assignment: Assignment) -> None:
    assert find_owners(assignment, "ada1/ada2/hw.ipynb")[0] == {"ada1": ["ada1/ada2/hw.ipynb"]}


def test_a_zip_with_backslashes_has_folders(assignment: Assignment, tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "all.zip", "w") as archive:
        archive.writestr(zipfile.ZipInfo("sub\\ada1\\hw.ipynb"), "{}")
        archive.writestr(zipfile.ZipInfo("sub\\hen\\hw.ipynb"), "{}")
    with open_submissions(tmp_path / "all.zip") as root:
        assert [*find_submissions(assignment, root).by_student] == ["ada1", "hen"]
