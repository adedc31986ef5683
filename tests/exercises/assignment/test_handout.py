"""`qdot release`: every student gets their own notebook, by an address that nobody else can guess, or in Moodle."""

import codecs
import csv
import io
import re
import shutil
import zipfile
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.assignment.handout import make_file_name, write_links
from qdot.exercises.common.errors import QdotError
from tests.support import read_data
from tests.support.command import run, run_and_fail
from tests.support.submitting import make_class

STUDENTS = (
    Student("501", "Ada Lovelace", "ada@example.org"), Student("502", "Wei Li", "wei@example.org"),
    Student("503", "Wei Li", "li@example.org"), Student("504", "Zoë Núñez_O'Brien", "zoe@example.org"),
)  # fmt: skip
WORKSHEET = read_data("downloads/moodle_worksheet.csv")


@pytest.fixture(scope="module")
def generated_class(tmp_path_factory: pytest.TempPathFactory) -> Path:
    assignment = make_class(tmp_path_factory.mktemp("handout") / "hw", STUDENTS)
    run("generate", assignment.folder, "--jobs", "1")
    return assignment.folder


@pytest.fixture
def folder(generated_class: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(generated_class, tmp_path / "hw"))


def read_table(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(path.read_text(encoding="utf-8-sig"))))


def read_notebook(folder: Path, student: str) -> bytes:
    return (folder / "released" / student / "hw.ipynb").read_bytes()


def test_released_has_a_table_of_contents(folder: Path) -> None:
    rows = read_table(folder / "released" / "index.csv")
    assert [tuple(row.values()) for row in rows] == [(s.id, s.name, s.email, f"{s.id}/hw.ipynb") for s in STUDENTS]
    assert all((folder / "released" / row["file"]).exists() for row in rows)


def test_links_lead_each_student_to_their_notebook(folder: Path) -> None:
    run("release", folder, "--links", "--url", "https://files.example.edu/rob/")
    rows = read_table(folder / "handout" / "links" / "mail-merge.csv")
    upload = folder / "handout" / "links" / "upload"
    assert [(row["student"], row["name"], row["email"]) for row in rows] == [(s.id, s.name, s.email) for s in STUDENTS]
    tokens = [re.fullmatch("https://files.example.edu/rob/([a-z2-7]{26})/", row["link"]) for row in rows]
    pages = {row["student"]: upload / token[1] for row, token in zip(rows, tokens, strict=True) if token}
    assert len(set(pages.values())) == len(STUDENTS)
    for student in STUDENTS:
        assert (pages[student.id] / "hw.ipynb").read_bytes() == read_notebook(folder, student.id)
        page = (pages[student.id] / "index.html").read_text(encoding="utf-8")
        assert student.name.split()[0] in page and 'href="hw.ipynb"' in page and "noindex" in page
    public = "".join(path.name + path.read_text(encoding="utf-8") for path in upload.glob("*") if path.is_file())
    assert not [token for token in tokens if token and token[1] in public], "the folder's own page lists nobody"
    assert (folder / "handout" / "links" / "mail-merge.csv").stat().st_mode & 0o777 == 0o600
    table = (folder / "handout" / "links" / "mail-merge.csv").read_bytes()
    assert table.startswith(codecs.BOM_UTF8), "Word and Excel read accented names"


def test_links_stay_the_same_and_those_of_former_students_end(folder: Path) -> None:
    run("release", folder, "--links")
    table = folder / "handout" / "links" / "mail-merge.csv"
    first_links = {row["student"]: row["link"] for row in read_table(table)}
    lines = (folder / "roster.csv").read_text().splitlines(keepends=True)
    (folder / "roster.csv").write_text("".join(line for line in lines if not line.startswith("502")))
    (folder / "handout" / "links" / "upload" / "notes").mkdir()
    run("release", folder, "--links")
    links = {row["student"]: row["link"] for row in read_table(table)}
    assert links == {student: link for student, link in first_links.items() if student != "502"}
    names = {path.name for path in (folder / "handout" / "links" / "upload").iterdir()}
    assert names == {"index.html", "notes", *(link.strip("/") for link in links.values())}
    (folder / "secret.txt").write_text("0123456789abcdef" * 4)
    for name in ("released", "solutions", "certificates"):
        shutil.rmtree(folder / name)
    run("generate", folder, "--jobs", "1")
    run("release", folder, "--links")
    assert not {row["link"] for row in read_table(table)} & set(links.values())


def test_moodle_gets_each_notebook_at_the_number_of_its_student(folder: Path) -> None:
    (folder / "sheet.csv").write_text(WORKSHEET, encoding="utf-8")
    run("release", folder, folder / "sheet.csv", "--to", "moodle")
    with zipfile.ZipFile(folder / "handout" / "moodle" / "moodle-notebooks.zip") as archive:
        found = {name.split("_")[1]: archive.read(name) for name in archive.namelist()}
        assert all(name.split("/")[0].split("_")[2:] == ["assignfeedback", "file"] for name in archive.namelist())
    assert found == {str(number): read_notebook(folder, s.id) for number, s in enumerate(STUDENTS, 11)}
    rows = read_table(folder / "handout" / "moodle" / "index.csv")
    assert [(row["student"], row["moodle id"]) for row in rows] == [(s.id, str(n)) for n, s in enumerate(STUDENTS, 11)]


def test_a_folder_is_named_after_each_student(folder: Path) -> None:
    run("release", folder, "--to", "folder")
    rows = read_table(folder / "handout" / "folder" / "index.csv")
    assert [row["file"].split("/")[0] for row in rows] == [
        "Lovelace, Ada (501)", "Li, Wei (502)", "Li, Wei (503)", "Núñez_O'Brien, Zoë (504)",
    ]  # fmt: skip
    for row in rows:
        path = folder / "handout" / "folder" / row["file"]
        assert path.read_bytes() == read_notebook(folder, row["student"])


@pytest.mark.parametrize(
    ("student", "name"),
    [
        (Student("7", "Lovelace, Ada"), "Lovelace, Ada (7)"), (Student("7", "Plato"), "Plato (7)"),
        (Student("7"), "7"), (Student("7", 'A/B "x"'), "-x-, A-B (7)"),
        (Student("7", "Ada King Lovelace", last_name="King Lovelace"), "King Lovelace, Ada (7)"),
        (Student("7", "Lovelace Ada King", last_name="Lovelace"), "Lovelace Ada King (7)"),
    ],
)  # fmt: skip
def test_file_names_begin_with_the_last_name(student: Student, name: str) -> None:
    assert make_file_name(student) == name


def test_nothing_is_written_that_cannot_be_right(folder: Path) -> None:
    (folder / "sheet.csv").write_text(WORKSHEET.replace("zoe@example.org", "").replace("Zoë", "Zoe"), encoding="utf-8")
    (folder / "other.csv").write_text("student,name\n501,Ada\n")
    for arguments, message in (
        ((), "choose one way: --links, or --to folder or --to moodle"), (("--links", "--to", "folder"), "choose one"),
        (("--to", "moodle"), "give the grading worksheet"), (("--to", "canvas"), "unknown --to 'canvas'"),
        ((folder / "sheet.csv", "--to", "moodle"), "it is not certain which line belongs to 504"),
        ((folder / "sheet.csv", "--to", "moodle"), "delete the lines of teachers in roster.csv"),
        ((folder / "other.csv", "--to", "moodle"), "is not a grading worksheet of Moodle"),
        ((folder / "none.csv", "--to", "moodle"), "none.csv"), (("--links", "--url", "files.example.edu"), "https://"),
    ):  # fmt: skip
        assert message in run_and_fail("release", folder, *arguments)
    (folder / "released" / "503" / "hw.ipynb").unlink()
    with pytest.raises(QdotError, match=r"no current notebook in released/ for 503; run: qdot generate"):
        write_links(load_assignment(folder), folder / "handout", "")
    assert not (folder / "handout").exists()


def test_missing_notebooks_are_generated_before_they_are_packed(folder: Path) -> None:
    notebook = read_notebook(folder, "503")
    (folder / "released" / "503" / "hw.ipynb").unlink()
    assert "4 students: 1 completed, 3 kept" in run("release", folder, "--to", "folder", "--jobs", "1")
    assert (folder / "handout" / "folder" / "Li, Wei (503)" / "hw.ipynb").read_bytes() == notebook


def test_a_student_who_is_forgotten_leaves_no_address(folder: Path) -> None:
    run("release", folder, "--links")
    run("forget", "501", folder, "--yes")
    assert not (folder / "handout").exists()
    assert [row["student"] for row in read_table(folder / "released" / "index.csv")] == ["502", "503", "504"]
    assert len(load_assignment(folder).roster) == 3
