"""`qdot forget`: all that is of one student is found, told and removed, and nothing that is of another."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from unittest.mock import Mock, patch

import pytest

from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.assignment.release import release_notebooks
from qdot.exercises.assignment.replacements import REPLACEMENTS_FILE
from qdot.exercises.common.files import write_atomically
from qdot.grader.cli import forget_command
from qdot.grader.grading import forgetting
from qdot.grader.grading.batch import lock_folder
from qdot.grader.grading.certify import CERTIFIER
from tests.support import ROOT
from tests.support.command import run, run_and_fail
from tests.support.submitting import make_class, make_correct_notebook, read_folder, submit, work_in_one_process

STUDENTS = (
    Student("ada", "Ada King Lovelace", "ada@example.org"), Student("bo", "Bo Example", "bo@example.org"),
    Student("cy", "Cy Example", "cy@example.org"),
)  # fmt: skip
ADA = re.compile(rb"\b(?:ada|Lovelace|ada@example\.org)\b")


@pytest.fixture(scope="module")
def graded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A class of which everything is kept that can be: two runs, a table of each kind, a page, exports."""
    made = make_class(tmp_path_factory.mktemp("forget") / "hw", STUDENTS)
    made = release_notebooks(made, CERTIFIER, 1, lambda _: None)
    for student in ("ada", "bo"):
        submit(
            made,
            f"{student}/hw.ipynb",
            make_correct_notebook(made, student, lambda cells: cells[-1].update(source="x = 1")),
        )
    grade(made.folder)
    submit(made, "ada/hw.ipynb", make_correct_notebook(made, "ada"))
    (made.folder / "overrides.csv").write_text("student,part,points,comment\nada,p1.position,0.5,\nbo,,3,on paper\n")
    header = "student,problem,family,draw,why\n"
    (made.folder / REPLACEMENTS_FILE).write_text(f"{header}ada,p1,other-family,2,x\nbo,p1,other-family,2,x\n")
    grade(made.folder)
    run("export", made.folder, "--to", "html", "--to", "gradescope", "--jobs", "1")
    (made.folder / "graded" / "report.html").write_text("<p>Ada King Lovelace</p>")
    (made.folder / "notes.txt").write_text("ask ada about Friday\n")
    return made.folder


def grade(folder: Path, *options: str) -> str:
    with work_in_one_process():
        return run("grade", folder, "--jobs", "1", *options)


@pytest.fixture
def folder(graded: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(graded, tmp_path / "hw"))


def forget(folder: Path, student: str = "ada", *options: str) -> list[str]:
    return run("forget", student, folder, *(options or ("--yes",))).splitlines()


STAYS = {
    "exports/gradescope/autograder.zip", "exports/html/handout-all.html", "notes.txt",
}  # fmt: skip
"""What still names ada, and is listed."""
TABLES = {
    "graded/results.jsonl",
    "graded/grades.csv",
    "graded/costs.csv",
    "roster.csv",
    "overrides.csv",
    REPLACEMENTS_FILE,
}


def test_nothing_is_left_of_a_student(folder: Path) -> None:
    before = read_folder(folder)
    said = forget(folder)
    after = read_folder(folder)
    left = {name for name, data in after.items() if ADA.search(data) or "ada" in name or name.endswith(".zip")}
    assert left <= STAYS
    assert {line.split()[1].rstrip(":") for line in said if line.startswith("  stays")} == left
    gone = set(before) - set(after)
    for name in (
        "released/ada/hw.ipynb", "solutions/ada/hw.ipynb", "certificates/ada/hw.json", "submitted/ada/hw.ipynb",
        "graded/feedback/ada.html", "graded/history/ada.jsonl", "graded/report.html", "exports/html/handout/ada.html",
        "exports/gradescope/students/ada/hw.ipynb",
    ):  # fmt: skip
        assert name in gone
    assert sum(name.startswith(".qdot/") for name in gone) == 1
    assert sum(line.startswith("  shorten ") for line in said) == len(TABLES)


def test_nothing_is_lost_of_the_others(folder: Path) -> None:
    before = read_folder(folder)
    forget(folder)
    after = read_folder(folder)
    changed = {name for name in after if after[name] != before[name]}
    assert changed == TABLES
    for name in TABLES:
        lines = [line for line in before[name].splitlines(True) if not ADA.search(line)]
        assert after[name] == b"".join(lines)
    assert "no mark has changed since the last run" in grade(folder, "--diff")
    assert [student.id for student in load_assignment(folder).roster] == ["bo", "cy"]


def test_it_is_told_first_and_asked_about(folder: Path) -> None:
    before = read_folder(folder)
    said = forget(folder, "ada", "--dry-run")
    assert said[-1] == "nothing was removed: --dry-run"
    asked = run_and_fail("forget", "ada", folder)
    assert "--yes" in asked and "--dry-run" in asked
    terminal = Mock(stdin=Mock(isatty=lambda: True))
    with patch.object(forget_command, "sys", terminal), patch("typer.confirm", lambda *_, **__: False):
        assert run("forget", "ada", folder, code=1).splitlines()[-1] == "nothing was removed"
    assert read_folder(folder) == before
    with patch.object(forget_command, "sys", terminal), patch("typer.confirm", lambda *_, **__: True):
        assert run("forget", "ada", folder).splitlines()[:-1] == said[:-1]


@pytest.mark.parametrize("named", ["ada", " ada ", "Ada King Lovelace", "ADA@example.org"])
def test_a_student_is_known_by_identifier_name_or_email(folder: Path, named: str) -> None:
    assert forget(folder, named, "--dry-run")[0].endswith("hw: ada (Ada King Lovelace)")


def test_who_is_nobody(folder: Path) -> None:
    assert "'adam' (did you mean 'ada'?)" in run_and_fail("forget", "adam", folder)
    for named in ("../hw", "..", "", "ada/..", ".qdot"):
        assert "unknown student" in run_and_fail("forget", named, folder)
    (folder / "roster.csv").write_text("student,name\nada,Ada\nbo,Ada\n")
    assert "'Ada' fits ada and bo" in run_and_fail("forget", "Ada", folder)
    assert "not an assignment's folder" in run_and_fail("forget", "ada", folder / "submitted" / "ada")


def test_who_has_left_the_roster_is_found_by_what_is_there(folder: Path) -> None:
    (folder / "roster.csv").write_text("student,name,email\nbo,Bo Example,\n")
    assert forget(folder)[0].endswith("hw: ada")
    left = {name for name, data in read_folder(folder).items() if re.search(rb"\bada\b", data) or "ada" in name}
    assert left <= STAYS


def test_what_was_stopped_is_ended_by_the_same_command(folder: Path) -> None:
    def stopped(path: Path, *rest: object) -> None:
        if path.name == "roster.csv":
            raise KeyboardInterrupt
        write_atomically(path, *rest)  # type: ignore[arg-type]

    with patch.object(forgetting, "write_atomically", stopped):
        run("forget", "ada", folder, "--yes", code=130)
    assert b"ada" in read_folder(folder)["roster.csv"] and not (folder / "submitted" / "ada").exists()
    forget(folder)
    assert b"ada," not in read_folder(folder)["roster.csv"]


def test_what_cannot_be_removed_is_told(folder: Path) -> None:
    with patch.object(forgetting, "remove_path", side_effect=OSError(5, "Input/output error", "x")):
        assert "x can't be removed: Input/output error" in run_and_fail("forget", "ada", folder, "--yes")


def test_not_while_a_class_is_being_graded(folder: Path) -> None:
    with lock_folder(folder):
        assert "is grading" in run_and_fail("forget", "ada", folder, "--yes")
    assert (folder / "submitted" / "ada").is_dir()


def test_all_assignments_of_a_course(folder: Path) -> None:
    shutil.copytree(folder, folder.parent / "hw2")
    said = forget(folder.parent)
    assert [line for line in said if line.endswith("ada (Ada King Lovelace)")] == [
        f"{folder.parent / name}: ada (Ada King Lovelace)" for name in ("hw", "hw2")
    ]
    assert not list(folder.parent.glob("*/submitted/ada"))


CANVAS = (
    '"Student",ID,SIS Login ID,Section,Homework (1)\n"    Points Possible",,,,10\n'
    '"Lovelace, Ada",ada,l1,One,\n"Example, Bo",bo,l2,One,\n'
)


@pytest.mark.parametrize(
    ("text", "encode"),
    [
        (CANVAS, str.encode),
        ("student;name\r\nbo;Bö\r\n\r\nada;Ädä\r\n", lambda text: text.encode("cp1252")),
        ("student\tname\r\nada\tÄdä\r\nbo\tBö\r\n", lambda text: text.encode("utf-16")),
        ("\ufeffstudent,name\nada,Ädä", str.encode),
    ],
    ids=["canvas", "windows", "utf-16", "utf-8 with its mark"],
)
def test_rosters_of_any_kind_lose_one_line_and_no_byte_more(
    tmp_path: Path, text: str, encode: Callable[[str], bytes]
) -> None:
    made = make_class(tmp_path / "hw", STUDENTS)
    (made.folder / "roster.csv").write_bytes(encode(text))
    forget(made.folder)
    lines = [line for line in text.splitlines(True) if "ada" not in line]
    assert (made.folder / "roster.csv").read_bytes() == encode("".join(lines))


def test_what_a_platform_calls_by_names_and_numbers(tmp_path: Path) -> None:
    made = make_class(tmp_path / "hw", STUDENTS)
    for name in ("Ada King Lovelace_31_assignsubmission_file_", "Bo Example_32_assignsubmission_file_"):
        submit(made, f"{name}/hw.ipynb", "{}")
    (tmp_path / ".git").mkdir()
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "kept").write_text("x")
    theirs = made.folder / "submitted" / "Ada King Lovelace_31_assignsubmission_file_"
    (theirs / "link").symlink_to(outside)
    (theirs / "closed").mkdir()
    (theirs / "closed" / "deep").write_text("x")
    (theirs / "closed").chmod(0)
    told = forget(made.folder)
    assert any(line.split()[:2] == ["stays", ".git:"] for line in told)
    assert [path.name for path in (made.folder / "submitted").iterdir()] == ["Bo Example_32_assignsubmission_file_"]
    assert (outside / "kept").exists(), "a link is removed, and not what it leads to"


def test_the_page_on_data_protection_names_every_kind_of_file(folder: Path) -> None:
    page = (ROOT / "docs" / "privacy.md").read_text(encoding="utf-8")
    kinds = {
        re.sub(r"^(exports|submitted|released|solutions|certificates|\.qdot)/.*", r"\1", name)
        for name in read_folder(folder)
    }
    kinds = {
        re.sub(r"/\.cache/.*", "/.cache", name).replace("/bo.", "/STUDENT.").replace("/ada.", "/STUDENT.")
        for name in kinds
    }
    of_nobody = {"assignment.toml", "README.md", ".gitignore", "notes.txt", "graded/feedback/cy.html"}
    assert len(kinds) > 12 and {name for name in kinds - of_nobody if name.split("/")[-1] not in page} == set()
