"""`qdot forget` lists and removes everything about one student, and nothing about the others."""

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
def graded_class(tmp_path_factory: pytest.TempPathFactory) -> Path:
    assignment = make_class(tmp_path_factory.mktemp("forget") / "hw", STUDENTS)
    assignment = release_notebooks(assignment, CERTIFIER, 1, lambda _: None)
    for student in ("ada", "bo"):
        notebook = make_correct_notebook(assignment, student, lambda cells: cells[-1].update(source="x = 1"))
        submit(assignment, f"{student}/hw.ipynb", notebook)
    grade(assignment.folder)
    submit(assignment, "ada/hw.ipynb", make_correct_notebook(assignment, "ada"))
    overrides = "student,part,points,comment\nada,p1.position,0.5,\nbo,,3,on paper\n"
    (assignment.folder / "overrides.csv").write_text(overrides)
    header = "student,problem,family,draw,why\n"
    (assignment.folder / REPLACEMENTS_FILE).write_text(f"{header}ada,p1,other-family,2,x\nbo,p1,other-family,2,x\n")
    grade(assignment.folder)
    run("export", assignment.folder, "--to", "html", "--to", "gradescope", "--jobs", "1")
    to_mark = "student,part,points,comment,answer\nada,p1.why,,,mine\nbo,p1.why,,,mine\n"
    (assignment.folder / "graded" / "to-mark.csv").write_text(to_mark)
    (assignment.folder / "graded" / "report.html").write_text("<p>Ada King Lovelace</p>")
    (assignment.folder / "notes.txt").write_text("ask ada about Friday\n")
    return assignment.folder


def grade(folder: Path, *options: str) -> str:
    with work_in_one_process():
        return run("grade", folder, "--jobs", "1", *options)


@pytest.fixture
def folder(graded_class: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(graded_class, tmp_path / "hw"))


def forget(folder: Path, student: str = "ada", *options: str) -> list[str]:
    return run("forget", student, folder, *(options or ("--yes",))).splitlines()


REMAINING_FILES = {"exports/gradescope/autograder.zip", "exports/html/handout-all.html", "notes.txt"}
"""Files that still name ada; the command lists them."""
TABLES = {
    *(f"graded/{name}" for name in ("results.jsonl", "grades.csv", "to-mark.csv", "costs.csv")),
    "roster.csv", "overrides.csv", REPLACEMENTS_FILE,
}  # fmt: skip


def test_everything_about_a_student_is_removed(folder: Path) -> None:
    before = read_folder(folder)
    output = forget(folder)
    after = read_folder(folder)
    remaining = {name for name, data in after.items() if ADA.search(data) or "ada" in name or name.endswith(".zip")}
    assert remaining <= REMAINING_FILES
    assert {line.split()[1].rstrip(":") for line in output if line.startswith("  stays")} == remaining
    removed = set(before) - set(after)
    for name in (
        "released/ada/hw.ipynb", "solutions/ada/hw.ipynb", "certificates/ada/hw.json", "submitted/ada/hw.ipynb",
        "graded/feedback/ada.html", "graded/history/ada.jsonl", "graded/report.html", "exports/html/handout/ada.html",
        "exports/gradescope/students/ada/hw.ipynb",
    ):  # fmt: skip
        assert name in removed
    assert sum(name.startswith(".qdot/") for name in removed) == 1
    assert sum(line.startswith("  shorten ") for line in output) == len(TABLES)


def test_nothing_about_other_students_is_removed(folder: Path) -> None:
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


def test_files_are_listed_and_confirmed_before_removal(folder: Path) -> None:
    before = read_folder(folder)
    output = forget(folder, "ada", "--dry-run")
    assert output[-1] == "nothing was removed: --dry-run"
    message = run_and_fail("forget", "ada", folder)
    assert "--yes" in message and "--dry-run" in message
    terminal = Mock(stdin=Mock(isatty=lambda: True))
    with patch.object(forget_command, "sys", terminal), patch("typer.confirm", lambda *_, **__: False):
        assert run("forget", "ada", folder, code=1).splitlines()[-1] == "nothing was removed"
    assert read_folder(folder) == before
    with patch.object(forget_command, "sys", terminal), patch("typer.confirm", lambda *_, **__: True):
        assert run("forget", "ada", folder).splitlines()[:-1] == output[:-1]


@pytest.mark.parametrize("query", ["ada", " ada ", "Ada King Lovelace", "ADA@example.org"])
def test_a_student_is_found_by_id_name_or_email(folder: Path, query: str) -> None:
    assert forget(folder, query, "--dry-run")[0].endswith("hw: ada (Ada King Lovelace)")


def test_an_unknown_or_ambiguous_student_is_an_error(folder: Path) -> None:
    assert "'adam' (did you mean 'ada'?)" in run_and_fail("forget", "adam", folder)
    for query in ("../hw", "..", "", "ada/..", ".qdot"):
        assert "unknown student" in run_and_fail("forget", query, folder)
    (folder / "roster.csv").write_text("student,name\nada,Ada\nbo,Ada\n")
    assert "'Ada' fits ada and bo" in run_and_fail("forget", "Ada", folder)
    assert "contains no assignment" in run_and_fail("forget", "ada", folder / "submitted" / "ada")


def test_a_student_no_longer_on_the_roster_is_forgotten(folder: Path) -> None:
    (folder / "roster.csv").write_text("student,name,email\nbo,Bo Example,\n")
    assert forget(folder)[0].endswith("hw: ada")
    remaining = {name for name, data in read_folder(folder).items() if re.search(rb"\bada\b", data) or "ada" in name}
    assert remaining <= REMAINING_FILES


def test_an_interrupted_run_is_finished_by_the_same_command(folder: Path) -> None:
    def write_until_roster(path: Path, *arguments: object) -> None:
        if path.name == "roster.csv":
            raise KeyboardInterrupt
        write_atomically(path, *arguments)  # type: ignore[arg-type]

    with patch.object(forgetting, "write_atomically", write_until_roster):
        run("forget", "ada", folder, "--yes", code=130)
    assert b"ada" in read_folder(folder)["roster.csv"] and not (folder / "submitted" / "ada").exists()
    forget(folder)
    assert b"ada," not in read_folder(folder)["roster.csv"]


def test_a_file_that_cannot_be_removed_is_an_error(folder: Path) -> None:
    with patch.object(forgetting, "remove_path", side_effect=OSError(5, "Input/output error", "x")):
        assert "x can't be removed: Input/output error" in run_and_fail("forget", "ada", folder, "--yes")


def test_nothing_is_removed_during_grading(folder: Path) -> None:
    with lock_folder(folder):
        assert "is grading" in run_and_fail("forget", "ada", folder, "--yes")
    assert (folder / "submitted" / "ada").is_dir()


def test_a_student_is_forgotten_in_all_assignments_of_a_course(folder: Path) -> None:
    shutil.copytree(folder, folder.parent / "hw2")
    output = forget(folder.parent)
    assert [line for line in output if line.endswith("ada (Ada King Lovelace)")] == [
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
def test_a_roster_in_any_format_loses_exactly_one_line(
    tmp_path: Path, text: str, encode: Callable[[str], bytes]
) -> None:
    assignment = make_class(tmp_path / "hw", STUDENTS)
    (assignment.folder / "roster.csv").write_bytes(encode(text))
    forget(assignment.folder)
    lines = [line for line in text.splitlines(True) if "ada" not in line]
    assert (assignment.folder / "roster.csv").read_bytes() == encode("".join(lines))


def test_platform_folders_are_removed_without_following_links(tmp_path: Path) -> None:
    assignment = make_class(tmp_path / "hw", STUDENTS)
    for name in ("Ada King Lovelace_31_assignsubmission_file_", "Bo Example_32_assignsubmission_file_"):
        submit(assignment, f"{name}/hw.ipynb", "{}")
    (tmp_path / ".git").mkdir()
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "kept").write_text("x")
    student_folder = assignment.folder / "submitted" / "Ada King Lovelace_31_assignsubmission_file_"
    (student_folder / "link").symlink_to(outside)
    (student_folder / "closed").mkdir()
    (student_folder / "closed" / "deep").write_text("x")
    (student_folder / "closed").chmod(0)
    output = forget(assignment.folder)
    assert any(line.split()[:2] == ["stays", ".git:"] for line in output)
    left = [path.name for path in (assignment.folder / "submitted").iterdir()]
    assert left == ["Bo Example_32_assignsubmission_file_"]
    assert (outside / "kept").exists(), "a link is removed, and not what it leads to"


def test_the_privacy_page_names_every_kind_of_file(folder: Path) -> None:
    page = (ROOT / "docs" / "privacy.md").read_text(encoding="utf-8")
    kinds = {
        re.sub(r"^(exports|submitted|released|solutions|certificates|\.qdot)/.*", r"\1", name)
        for name in read_folder(folder)
    }
    kinds = {
        re.sub(r"/\.cache/.*", "/.cache", name).replace("/bo.", "/STUDENT.").replace("/ada.", "/STUDENT.")
        for name in kinds
    }
    impersonal = {"assignment.toml", "README.md", ".gitignore", "notes.txt", "graded/feedback/cy.html"}
    assert len(kinds) > 12 and {name for name in kinds - impersonal if name.split("/")[-1] not in page} == set()
