"""Gradebooks for Canvas and Moodle, checked against the rules in their importers' sources; xlsx by openpyxl."""

import csv
import io
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import openpyxl
import pytest

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.handout import make_file_name
from qdot.exercises.common.errors import QdotError
from qdot.grader.grading.result import Override, Result
from qdot.grader.reports.excel import make_workbook
from qdot.grader.reports.formats import write_requested_reports
from qdot.grader.reports.gradebooks import RESERVED_PHRASES, make_canvas_csv, make_moodle_csv
from qdot.grader.reports.grades_table import make_grades_csv
from tests.support import read_data
from tests.support.command import run, run_and_fail
from tests.support.results import make_result
from tests.support.submitting import TOML, make_class

IGNORED_TITLES = (
    "Current Score", "Current Points", "Current Grade", "Final Score", "Final Points", "Final Grade", "Override Score",
    "Override Grade", "Override Status",
)  # fmt: skip


CANVAS_EXPORT = read_data("downloads/canvas_gradebook.csv")

MOODLE_EXPORT = read_data("downloads/moodle_gradebook.csv")

Make = Callable[..., Assignment]


@pytest.fixture
def make(tmp_path: Path) -> Make:
    """Return a function that creates an assignment of four points with a given roster.csv."""

    def create(roster: str, title: str = "T") -> Assignment:
        folder = tmp_path / "hw"
        if not folder.exists():
            make_class(folder, [Student("ada")])
        (folder / "roster.csv").write_bytes(roster.encode())
        (folder / "assignment.toml").write_text(TOML.replace('title = "T"', f"title = {title!r}".replace("'", '"')))
        return load_assignment(folder)

    return create


def make_results(assignment: Assignment) -> list[Result]:
    """Return three results: right except for a third of a part, ungraded, and missing."""
    ada, paul, emmy = (student.id for student in assignment.roster)
    first = make_result(assignment, ada, ["correct", "partial", "correct"], score=2.6667)
    return [first, make_result(assignment, paul, ["correct", "ungraded", "wrong"]), make_result(assignment, emmy)]


@pytest.mark.parametrize(
    "export",
    [
        CANVAS_EXPORT,
        "\ufeff" + CANVAS_EXPORT,
        CANVAS_EXPORT.replace(",", ";").replace("; ", ", "),
        CANVAS_EXPORT.replace("\n", "\r\n"),
        CANVAS_EXPORT.replace("Student,ID", "LastName,FirstName,ID").replace("\n,,,,,M", "\n,,,,,,M")
        .replace("Possible,,,,,", "Possible,,,,,,").replace('"', "").replace(", ", ","),
        CANVAS_EXPORT.replace("Quiz 1 (7)", '"Quiz; 1, (7)"'),
    ],
    ids=["as it is", "bom", "semicolons", "crlf", "two names", "separators in a title"],
)  # fmt: skip
def test_a_canvas_export_in_any_format_is_a_roster(make: Make, export: str) -> None:
    assignment = make(export)
    assert [(student.id, student.name, student.email) for student in assignment.roster] == [
        ("101", "Ada Lovelace", ""), ("102", "Paul Erdős", "paul@example.org"), ("103", "Emmy Noether", ""),
    ]  # fmt: skip
    assert make_file_name(assignment.roster[0]) == "Lovelace, Ada (101)"
    other_cells = {"sis user id": "S-1", "sis login id": "ada", "section": "Monday"}
    assert dict(assignment.roster[0].other_cells) == other_cells
    header, *rows = csv.reader(io.StringIO(make_moodle_csv(assignment, make_results(assignment))))
    assert header[0] == "Name" and [row[0] for row in rows] == [student.name for student in assignment.roster]


def read_column(text: str, key: str, name: str) -> dict[str, str]:
    """Return a column of a gradebook as a dict by another column, without rows whose key is empty."""
    return {row[key]: row[name] for row in csv.DictReader(io.StringIO(text.removeprefix("\ufeff"))) if row[key]}


def test_the_canvas_gradebook_has_the_columns_of_the_export(make: Make) -> None:
    assignment = make(CANVAS_EXPORT)
    text = make_canvas_csv(assignment, make_results(assignment))
    rows = list(csv.reader(io.StringIO(text)))
    assert rows[0] == ["Student", "ID", "SIS User ID", "SIS Login ID", "Section", "T (12)"]
    assert rows[1] == ["    Points Possible", "", "", "", "", "4"]
    assert [row[:5] for row in rows[2:]] == [row[:5] for row in list(csv.reader(io.StringIO(CANVAS_EXPORT)))[3:6]]
    # Excused students stay excused; missing and ungraded work is empty, never 0.
    assert read_column(text, "ID", "T (12)") == {"101": "2.6667", "102": "EX", "103": ""}
    assignment = make(CANVAS_EXPORT.replace("T (12)", "Other (12)"))  # a new assignment
    text = make_canvas_csv(assignment, make_results(assignment))
    assert read_column(text, "ID", "T") == {"101": "2.6667", "102": "", "103": ""}


def test_a_canvas_gradebook_from_any_roster(make: Make) -> None:
    assignment = make("student,name,email,sis user id,section\na,Ada Lovelace,,S-1,Mon\nb,=cmd|x,,S-2,\nc,Emmy,,,\n")
    text = make_canvas_csv(assignment, make_results(assignment))
    marks = {"    Points Possible": "4", "Ada Lovelace": "2.6667", "'=cmd|x": "", "Emmy": ""}
    assert read_column(text, "Student", "T") == marks
    assert read_column(text, "SIS User ID", "T") == {"S-1": "2.6667", "S-2": ""}
    excused = make("student;T\nada;ex\npaul@example.org;\nemmy;\n")
    marks = {"ada": "EX", "paul@example.org": "", "emmy": ""}
    assert read_column(make_canvas_csv(excused, make_results(excused)), "SIS Login ID", "T") == marks


@pytest.mark.parametrize(
    ("old", "new", "title", "message"),
    [
        *(("", "", f"The {word} of all", f"ignores columns whose title contains '{word}'") for word in IGNORED_TITLES),
        (",5,4,", ",5,20,", "T", r"'T \(12\)' has 20 points in Canvas, but 4 in qdot"),
        ("Quiz 1 (7)", "T (7)", "T", "2 assignments called 'T'"),
    ],
)
def test_titles_that_canvas_would_misread_are_refused(make: Make, old: str, new: str, title: str, message: str) -> None:
    assignment = make(CANVAS_EXPORT.replace(old, new) if old else CANVAS_EXPORT, title)
    with pytest.raises(QdotError, match=message):
        make_canvas_csv(assignment, make_results(assignment))
    decimals = make(CANVAS_EXPORT.replace(",5,4,", ',5,"4,00",'))
    assert "T (12)" in make_canvas_csv(decimals, make_results(decimals))
    assert set(RESERVED_PHRASES) == set(IGNORED_TITLES)


def test_no_name_hides_a_row_or_becomes_a_formula(make: Make) -> None:
    """Canvas ignores every row whose first cell contains "Points Possible"."""
    export = CANVAS_EXPORT.replace("Lovelace, Ada", "Points Possible, Ada").replace("Erdős, Paul", "=1+1")
    assignment = make(export.replace("S-2", "+49 170 1"))
    text = make_canvas_csv(assignment, make_results(assignment))
    first = [row[0] for row in csv.reader(io.StringIO(text))]
    assert sum("Points Possible" in cell for cell in first) == 1 and first[3] == "'=1+1" and len(first) == 5
    assert "+49 170 1,paul" in text  # a number is unchanged


def test_titles_with_semicolons_or_line_breaks_are_safe(make: Make) -> None:
    """Canvas assumes semicolons as separators only if the first three lines have equally many."""
    assignment = make(CANVAS_EXPORT.replace("T (12)", "A; b; c (12)"), "A; b; c")
    text = make_canvas_csv(assignment, make_results(assignment))
    assert read_column(text, "ID", "A; b; c (12)")["101"] == "2.6667"
    assert len({len(next(csv.reader([line], delimiter=";"))) for line in text.splitlines()[:3]}) > 1
    broken = replace(assignment, title="A\nB", class_list=None)
    assert "A B" in make_canvas_csv(broken, make_results(broken)).splitlines()[0]


def test_a_row_without_a_canvas_id_is_an_error(make: Make) -> None:
    with pytest.raises(QdotError, match=r"roster.csv: line 5: the cell in the column ID is empty.*'Erdős, Paul'"):
        make(CANVAS_EXPORT.replace(",102,", ",,"))
    # Without the row of points it is not a Canvas export.
    assert [student.id for student in make("Student,ID,Section\nada,17,Mon\n").roster] == ["ada"]


def test_a_moodle_export_is_a_roster(make: Make) -> None:
    students = make(MOODLE_EXPORT).roster
    assert [(student.id, student.name, student.email) for student in students][1] == (
        "0043", "Paul Erdős", "paul@example.org",
    )  # fmt: skip
    german = "Vorname;Nachname;E-Mail-Adresse;Gruppen\nPaul;Erdős;paul@example.org;\n"
    assert [(student.id, student.name) for student in make(german).roster] == [("paul@example.org", "Paul Erdős")]
    with pytest.raises(QdotError, match="Moodle"):
        make("First name,Last name,Groups\nPaul,Erdős,A\n")
    with pytest.raises(QdotError, match=r"line 3: .*'ID number'.*delete the line, if it is a teacher's"):
        make(MOODLE_EXPORT.replace("0043", ""))
    added = "First name,Last name,Email address,Moodle ID,Assignment: Screw grid (Real)\nWei,Li,li@example.org,59,80\n"
    assert make(added).roster[0].other_cells == (("moodle id", "59"),)
    # Without any ID numbers, email addresses are the ids.
    assert make(re.sub(r"004\d", "", MOODLE_EXPORT)).roster[0].id == "ada@example.org"


@pytest.mark.parametrize(
    "header",
    [
        "student,Last name,First name,E-mail", "username,lastname,firstname,email",
        "Student number,Surname,First name,E-mail", "Matrikelnummer,Nachname,Vorname,Mail",
    ],
)  # fmt: skip
def test_a_table_of_an_instructor_may_have_two_columns_of_names(make: Make, header: str) -> None:
    student = make(f"{header}\n0041,García Márquez,Gabriel,gabriel@example.org\n").roster[0]
    assert (student.name, student.email) == ("Gabriel García Márquez", "gabriel@example.org")
    assert "0041" in (student.id, *dict(student.other_cells).values())
    assert make_file_name(student) == f"García Márquez, Gabriel ({student.id})"
    with pytest.raises(QdotError, match="a first column 'student'"):
        make("Number,Last name,First name\n0041,García Márquez,Gabriel\n")


def test_the_moodle_gradebook_has_a_dash_for_no_mark(make: Make) -> None:
    """Moodle's newer importer reads an empty cell as 0."""
    assignment = make(MOODLE_EXPORT)
    text = make_moodle_csv(assignment, make_results(assignment))
    for item, mark in (("T", "2.6667"), ("T (percent)", "66.6675")):
        assert read_column(text, "ID number", item) == {"0042": mark, "0043": "-", "0044": "-"}
        emails = {f"{name}@example.org": "-" for name in ("ada", "paul", "emmy")}
        assert read_column(text, "Email address", item) == {**emails, "ada@example.org": mark}


def test_moodle_columns_with_empty_or_repeated_keys_are_left_out(make: Make) -> None:
    assignment = make(MOODLE_EXPORT.replace("paul@example.org", ""))
    header = make_moodle_csv(assignment, make_results(assignment)).splitlines()[0]
    assert header == "First name,Last name,ID number,T,T (percent)"
    any_roster = make("student,name,email,username\na,Ada,ada@x.org,0\nb,Paul,ADA@x.org,paul\nc,Emmy,e@x.org,emmy\n")
    lines = make_moodle_csv(any_roster, make_results(any_roster)).splitlines()
    # PHP reads "0" as empty, and ada@ occurs twice.
    assert lines[:2] == ["Name,student,T,T (percent)", "Ada,a,2.6667,66.6675"]
    full = make("student,name,email,idnumber\na,Ada,ada@x.org,1\nb,Paul,p@x.org,2\nc,Emmy,e@x.org,3\n")
    assert make_moodle_csv(full, make_results(full)).splitlines()[1] == "Ada,1,ada@x.org,2.6667,66.6675"


def test_more_than_a_hundred_points_go_to_moodle_as_percent_only(make: Make) -> None:
    assignment = make(MOODLE_EXPORT)
    results = [replace(result, max_score=120.0, score=115.0) for result in make_results(assignment)]
    text = make_moodle_csv(assignment, results)
    assert text.splitlines()[0].endswith("Email address,T (percent)")
    assert read_column(text, "ID number", "T (percent)")["0042"] == "95.8333"


def test_an_override_is_a_mark_and_unreadable_work_is_not(make: Make) -> None:
    assignment = make(MOODLE_EXPORT)
    override = Override(0.0, "not submitted, no excuse", 0.0)
    first, second, third = make_results(assignment)
    results = [
        replace(first, obstacle="this is no notebook", score=0.0), replace(second, override=override, score=0.0),
        replace(third, override=override),
    ]  # fmt: skip
    marks = read_column(make_moodle_csv(assignment, results), "ID number", "T")
    assert marks == {"0042": "-", "0043": "0", "0044": "0"}


def test_students_without_a_mark_are_reported(make: Make, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assignment = make(CANVAS_EXPORT)
    write_requested_reports(assignment, make_results(assignment), [("canvas", str(tmp_path / "c.csv"))])
    assert capsys.readouterr().err == "canvas: no mark for 102 (ungraded), 103 (missing)\n"
    data = (tmp_path / "c.csv").read_bytes()
    assert data.startswith(b"Student,")  # no byte order mark: it would be a part of the first cell
    assert "Erdős".encode() in data


def test_the_workbook_is_valid_for_openpyxl(make: Make) -> None:
    assignment = make("student,name,email\na,=HYPERLINK(1),\nb,https://example.org,\nc,Emmy\u202e,\n")
    results = make_results(assignment)
    data = make_workbook(assignment, results)
    assert data == make_workbook(assignment, results)
    book = openpyxl.load_workbook(io.BytesIO(data))
    rows = [[cell.value for cell in row] for row in book["Grades"].iter_rows()]
    table = make_grades_csv(results, assignment.roster)
    assert "Emmy\\u202e" in table
    header = next(csv.reader(io.StringIO(table)))
    assert rows[0] == header
    ada, paul, emmy = ({**dict(zip(header, row, strict=True))} for row in rows[1:])
    assert (ada["name"], ada["score"], ada["p1.jacobian"]) == ("=HYPERLINK(1)", 2.6667, 1)
    assert (paul["score"], paul["p1.jacobian"], paul["p1.position"], paul["status"]) == (None, None, 1, "ungraded")
    assert (emmy["score"], emmy["p1.jacobian"], emmy["status"]) == (None, None, "missing")
    assert {cell.data_type for cell in book["Grades"]["B"]} == {"s"}  # text, not a formula
    assert not any(cell.hyperlink for cell in book["Grades"]["B"])
    assert emmy["name"] == "Emmy\\u202e"
    parts = [[cell.value for cell in row] for row in book["Parts"].iter_rows()]
    assert parts[2] == ["p1.jacobian", 2, 1, 0, 1, 0, 0, 1]


def test_init_accepts_an_export_as_roster(tmp_path: Path) -> None:
    export = tmp_path / "2026-11-22 Grades.csv"
    export.write_text(CANVAS_EXPORT)
    run("init", tmp_path / "hw", "--roster", export)
    assert (tmp_path / "hw" / "roster.csv").read_bytes() == export.read_bytes()
    assert "none.csv" in run_and_fail("init", tmp_path / "other", "--roster", tmp_path / "none.csv")
    assert not (tmp_path / "other").exists()
