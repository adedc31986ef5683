"""The downloads of learning platforms as they unpack: whose each file is, when it came in, and never a guess."""

import datetime
import os
import stat
import zipfile
from pathlib import Path

import pytest
from typer.testing import CliRunner

from exercises.assignment import Assignment, Student, load_assignment
from exercises.errors import QdotError
from grader.cli import app
from grader.layouts import Handed, handed_in
from grader.reports.tables import status
from grader.roster import Roster
from grader.submission import MAY_BE, find_submissions, opened
from tests.support.handing_in import RIGHT, a_class, grade, hand_in, outcomes, right

pytestmark = pytest.mark.xdist_group("layouts")
ROSTER = """student,name,email,moodle id,canvas_id,sid,section
ada1,Ada Lovelace,ada@example.org,1001,501,A-1,17
ada2,"Lovelace, Ada",lovelace@example.org,1002,502,A-2,17
hen,Henri Poincaré,hp@example.org,1003,503,A-3,17
jose,José Díaz,jd@example.org,,,A-4,18
eve,Anne-Marie van der Berg,eve@example.org,,,A-5,18
"""


@pytest.fixture
def assignment(tmp_path: Path) -> Assignment:
    folder = tmp_path / "hw"
    a_class(folder, [Student("s")])
    (folder / "roster.csv").write_text(ROSTER)
    return load_assignment(folder)


def owners(assignment: Assignment, *paths: str) -> tuple[dict[str, list[str]], list[str], list[str]]:
    """Return who is found to have handed in what, who is a stranger, and what is not sure."""
    for path in paths:
        hand_in(assignment, path, "{}")
    looked = find_submissions(assignment, assignment.folder / "submitted")
    root = assignment.folder / "submitted"
    found = {
        who: [str(file.relative_to(root)) for file in own.files]
        for who, own in looked.found.items()
        if not own.obstacle
    }
    return found, looked.strangers, looked.unsure


def test_moodle_in_folders(assignment: Assignment) -> None:
    found, strangers, unsure = owners(
        assignment,
        "Ada Lovelace_1001_assignsubmission_file_/my work.ipynb",
        "Ada Lovelace_1002_assignsubmission_file/hw.ipynb",
        "Group A-Henri Poincare\u0301_77_assignsubmission_file_/sub/hw.ipynb",
        "Henri Poincaré_77_assignsubmission_onlinetext_/onlinetext.html",
        "Participant_1003_assignsubmission_file_/hw2.ipynb",
        "Somebody Else_78_assignsubmission_file_/hw.ipynb",
    )
    assert found == {
        "ada1": ["Ada Lovelace_1001_assignsubmission_file_/my work.ipynb"],
        "ada2": ["Ada Lovelace_1002_assignsubmission_file/hw.ipynb"],
        "hen": [
            "Group A-Henri Poincare\u0301_77_assignsubmission_file_/sub/hw.ipynb",
            "Participant_1003_assignsubmission_file_/hw2.ipynb",
            "Henri Poincaré_77_assignsubmission_onlinetext_/onlinetext.html",
        ],
    }
    assert strangers == ["Somebody Else_78_assignsubmission_file_"] and not unsure


def test_moodle_flat(assignment: Assignment) -> None:
    found, strangers, _ = owners(
        assignment,
        "Jose Diaz_5_assignsubmission_file_hw_final_2.ipynb",
        "Anne-Marie van der Berg_6_assignsubmission_file_hw.zip",
        "Ada Lovelace_1002_assignsubmission_onlinetext_onlinetext.html",
    )
    assert list(found) == ["ada2", "eve", "jose"] and not strangers


def test_canvas(assignment: Assignment) -> None:
    found, strangers, unsure = owners(
        assignment,
        "lovelaceada_501_9001_hw.ipynb",
        "lovelaceada_LATE_502_9002_hw-1.ipynb",
        "vanderbergannemarie_777_9003_hw-2.ipynb",
        "díazjosé_LATE_778_9004_my_work_1.ipynb",
        "poincaréhenri_503_text.html",
        "nobody_999_9005_hw.ipynb",
    )
    assert found == {
        "ada1": ["lovelaceada_501_9001_hw.ipynb"],
        "ada2": ["lovelaceada_LATE_502_9002_hw-1.ipynb"],
        "eve": ["vanderbergannemarie_777_9003_hw-2.ipynb"],
        "jose": ["díazjosé_LATE_778_9004_my_work_1.ipynb"],
        "hen": ["poincaréhenri_503_text.html"],
    }
    assert strangers == ["nobody_999_9005_hw.ipynb"] and not unsure
    looked = find_submissions(assignment, assignment.folder / "submitted").found
    assert {who: looked[who].late for who in found} == {
        "ada1": False,
        "ada2": True,
        "eve": False,
        "jose": True,
        "hen": False,
    }


GRADESCOPE = """---
submission_11:
  :submitters:
  - :name: Ada Lovelace
    :sid: 'A-1'
    :email: ada@example.org
  :created_at: 2026-11-20 10:11:12.131415000 Z
  :score: 3.0
  :status: processed
  :history:
  - :id: 1
    :created_at: 2020-01-01 00:00:00 Z
submission_12:
  :submitters:
  - :name: "Jos\\u00e9 D\\u00edaz"
    :sid: ''
    :email:
  - :name: Henri Poincaré
    :sid: A-3
    :email: hp@example.org
  :created_at: '2026-11-20T23:30:00.000-08:00'
submission_13:
  :submitters:
  - :name: O'Hara
    :sid: 'it''s'
    :email: nobody@example.org
../../hw/secret.txt:
  :submitters:
  - :name: Anne-Marie van der Berg
"""


def test_gradescope(assignment: Assignment) -> None:
    found, strangers, unsure = owners(
        assignment, *(f"assignment_7_export/submission_{n}/hw.ipynb" for n in (11, 12, 13, 14))
    )
    assert strangers == ["assignment_7_export"]
    hand_in(assignment, "assignment_7_export/submission_metadata.yml", GRADESCOPE)
    found, strangers, unsure = owners(assignment)
    assert {who: files[0].split("/")[1] for who, files in found.items()} == {
        "ada1": "submission_11", "hen": "submission_12", "jose": "submission_12",
    }  # fmt: skip
    assert strangers == ["submission_13", "submission_14"] and not unsure
    looked = find_submissions(assignment, assignment.folder / "submitted").found
    assert looked["ada1"].received == datetime.datetime(2026, 11, 20, 10, 11, 12, tzinfo=datetime.UTC)
    assert looked["hen"].received == datetime.datetime(2026, 11, 21, 7, 30, tzinfo=datetime.UTC)
    assert looked["ada1"].platform == "Gradescope"


def test_a_metadata_file_that_is_damaged_or_a_link_says_nothing(assignment: Assignment, tmp_path: Path) -> None:
    for content in (b"\xff\xfe\0", b"- [", b'submission_1:\n  :submitters:\n  - :name: "\\', b":" * 10**6):
        hand_in(assignment, "submission_metadata.yml", content)
        assert owners(assignment, "ada1/hw.ipynb")[0] == {"ada1": ["ada1/hw.ipynb"]}
    (tmp_path / "other.yml").write_text(GRADESCOPE)
    (assignment.folder / "submitted" / "submission_metadata.yml").unlink()
    (assignment.folder / "submitted" / "submission_metadata.yml").symlink_to(tmp_path / "other.yml")
    assert owners(assignment, "submission_11/hw.ipynb")[1] == ["submission_11"]


def test_own_identifiers_come_first_and_in_any_case(assignment: Assignment) -> None:
    found, strangers, _ = owners(
        assignment,
        "ADA1/hw.ipynb",
        "ada2.zip",
        "hen.tar.gz",
        "Jose\u0301 Di\u0301az/hw.ipynb",
        "grades.csv",
        "README.txt",
    )
    assert sorted(found) == ["ada1", "ada2", "hen", "jose"]
    assert not strangers


def test_names_of_folders_are_shown_in_one_line(assignment: Assignment) -> None:
    names = ("a\nqdot: all is well\x1b[2J", "x\\..\\..", "🦾 José", "y" * 200, "%s{0}\u202e")
    _, strangers, unsure = owners(assignment, *(f"{name}/hw.ipynb" for name in names), "José\n Díaz_5_x.ipynb")
    assert len(strangers) == 6 and not unsure
    assert all(name.isprintable() or "\N{REPLACEMENT CHARACTER}" in name for name in strangers)
    assert not any(ch in name for name in strangers for ch in "\n\x1b\u202e") and max(map(len, strangers)) <= 120


def test_what_may_be_of_two_is_never_guessed(assignment: Assignment) -> None:
    hand_in(assignment, "Ada Lovelace_44_assignsubmission_file_/hw.ipynb", right(assignment, "ada1"))
    hand_in(assignment, "Henri Poincaré_9_assignsubmission_file_/hw.ipynb", right(assignment, "hen"))
    hand_in(assignment, "José Díaz_1003_assignsubmission_file_/hw.ipynb", right(assignment, "jose"))
    results, looked = grade(assignment)
    several, contradicts = looked.unsure
    folder = "_assignsubmission_file_"
    assert several == f"Ada Lovelace_44{folder} may be of ada1 or ada2: several students have this name; not graded"
    why = "its name and its number are of different students; not graded"
    assert contradicts == f"José Díaz_1003{folder} may be of hen or jose: {why}"
    for student in ("ada1", "ada2", "jose"):
        assert results[student]["obstacle"] == MAY_BE and status(results[student]) == "unusable"
    assert outcomes(results["hen"]) == RIGHT
    assert status(results["eve"]) == "missing"


def test_a_section_is_no_identifier() -> None:
    student = Student("a", "", "", (("section", "17"), ("seat number", "17"), ("Student ID".lower(), "18"), ("id", "")))
    roster = Roster([student])
    assert roster.owner(Handed(Path("x"), ("17",), "Participant")).students == ()
    assert roster.owner(Handed(Path("x"), ("18",), "Participant")).students == ("a",)
    assert roster.owner(Handed(Path("x"), ("",), "")).students == ()


def test_times_are_of_the_best_source(assignment: Assignment) -> None:
    toml = assignment.folder / "assignment.toml"
    toml.write_text(toml.read_text().replace('key = "hw"', 'key = "hw"\ndue = 2026-11-20T12:00:00Z'))
    assignment = load_assignment(assignment.folder)
    hand_in(assignment, "submission_metadata.yml", GRADESCOPE)
    hand_in(assignment, "submission_11/hw.ipynb", right(assignment, "ada1"))
    hand_in(assignment, "lovelaceada_502_9002_hw.ipynb", right(assignment, "ada2"))
    hand_in(assignment, "poincaréhenri_LATE_503_9003_hw.ipynb", right(assignment, "hen"))
    path = hand_in(assignment, "jose/hw.ipynb", right(assignment, "jose"))
    after = 1_800_000_000
    for file in (path, *(assignment.folder / "submitted").glob("*_hw.ipynb")):
        os.utime(file, (after, after))
    results, _ = grade(assignment)
    told = {
        who: (r["submission"]["received_from"], r["late"] is not None) for who, r in results.items() if r["submission"]
    }
    assert told == {
        "ada1": ("Gradescope", False), "ada2": ("file", False), "hen": ("file", True), "jose": ("file", True),
    }  # fmt: skip
    assert results["ada1"]["submission"]["received"] == "2026-11-20T10:11:12+00:00"
    assert "the platform has marked it as late" in results["hen"]["staff_notes"]


# --- the zip itself ---


def zip_of(path: Path, assignment: Assignment, *, evil: bool = False) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        for name, student in (("Henri Poincare\u0301", "hen"), ("José Díaz", "jose")):
            info = zipfile.ZipInfo(f"{name}_9_assignsubmission_file_/hw.ipynb", (2026, 11, 20, 10, 0, 0))
            archive.writestr(info, right(assignment, student))
        if evil:
            archive.writestr("../../evil.ipynb", "{}")
            archive.writestr("/etc/evil.ipynb", "{}")
            archive.writestr("a\\..\\..\\evil.ipynb", "{}")
            link = zipfile.ZipInfo("ada1/hw.ipynb")
            link.external_attr = (stat.S_IFLNK | 0o777) << 16
            archive.writestr(link, str(assignment.folder / "secret.txt"))
            archive.writestr("ada2/" + "long" * 100 + ".ipynb", "{}")
            archive.writestr("ada2/hw.zip", zip_bytes(path.with_name("inner.zip")))
    return path


def zip_bytes(path: Path) -> bytes:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("x/readme.txt", "no notebook")
    return path.read_bytes()


def test_the_zip_itself_is_graded(assignment: Assignment, tmp_path: Path) -> None:
    said = CliRunner().invoke(
        app, ["grade", str(assignment.folder), str(zip_of(tmp_path / "moodle.zip", assignment)), "-j", "1"]
    )
    assert said.exit_code == 0 and "2 graded" in said.output
    results, _ = grade(assignment, tmp_path / "moodle.zip")
    assert outcomes(results["hen"]) == outcomes(results["jose"]) == RIGHT
    local = datetime.datetime(2026, 11, 20, 10).astimezone().astimezone(datetime.UTC)
    assert results["hen"]["submission"]["received"] == local.isoformat()


def test_a_hostile_zip_writes_nothing_elsewhere(
    assignment: Assignment, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = set(tmp_path.rglob("*"))
    path = zip_of(tmp_path / "evil.zip", assignment, evil=True)
    with opened(path) as root:
        unpacked = {str(file.relative_to(root)) for file in root.rglob("*") if not file.is_dir()}
        assert not any(file.is_symlink() for file in root.rglob("*"))
        results, _ = grade(assignment, root)
    assert not root.exists()
    assert len(unpacked) == 4 and not [name for name in unpacked if "evil" in name]
    said = capsys.readouterr().err.splitlines()
    assert said == [
        "../../evil.ipynb: its name leads out of the folder; not unpacked",
        "/etc/evil.ipynb: its name leads out of the folder; not unpacked",
        "a/../../evil.ipynb: its name leads out of the folder; not unpacked",
        "ada1/hw.ipynb: it is a symbolic link; not unpacked",
    ] or said[2].startswith("a\\..\\..\\evil.ipynb")
    assert set(tmp_path.rglob("*.ipynb")) <= before
    assert outcomes(results["hen"]) == RIGHT and status(results["ada1"]) == "missing"


def test_what_is_no_zip_and_no_folder_is_told(assignment: Assignment, tmp_path: Path) -> None:
    path = tmp_path / "grades.csv"
    path.write_text("a")
    with pytest.raises(QdotError, match="is not a folder of submissions"), opened(path) as root:
        find_submissions(assignment, root)
    zip_of(tmp_path / "m.zip", assignment)
    data = (tmp_path / "m.zip").read_bytes()
    (tmp_path / "m.zip").write_bytes(data[:200] + b"\xff" * 400 + data[600:])
    with opened(tmp_path / "m.zip") as root:
        assert len(list(root.rglob("*.ipynb"))) <= 2


@pytest.mark.parametrize("folder", ["jose", "Jose Diaz_5_assignsubmission_file_", "José Díaz"])
def test_a_students_own_folder_is_no_export_whatever_lies_in_it(assignment: Assignment, folder: str) -> None:
    """The only one who has handed in yet lays a list beside the notebook, by which it is of others, too."""
    hand_in(assignment, f"{folder}/submission_metadata.yml", GRADESCOPE)
    found, strangers, unsure = owners(assignment, f"{folder}/submission_11/hw.ipynb", f"{folder}/hw.ipynb")
    assert found["jose"][0] == f"{folder}/hw.ipynb"
    assert list(found) == ["jose"] and not strangers and not unsure


def test_a_layout_knows_its_own_files_only(tmp_path: Path) -> None:
    for name in ("ada_lovelace", "hw_1_2", "x_assignsubmission_file_", "_1_2_x.ipynb", "submission_1"):
        (tmp_path / name).mkdir()
    handed = handed_in(tmp_path)
    assert [one.platform for one in handed] == [""] * 5
