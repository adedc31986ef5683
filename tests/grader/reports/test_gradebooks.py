"""Gradebooks as the importers of Canvas and Moodle read them, by their sources; xlsx as openpyxl does."""

import csv
import io
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import openpyxl
import pytest

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.grader.grading.result import Override, Result
from qdot.grader.reports.excel import make_workbook
from qdot.grader.reports.formats import write_requested_reports
from qdot.grader.reports.gradebooks import RESERVED_WORDS, make_canvas_csv, make_moodle_csv
from qdot.grader.reports.tables import make_grades_csv
from tests.support.command import run, run_and_fail
from tests.support.results import make_result
from tests.support.submitting import TOML, make_class

STRIPPED = (
    "Current Score", "Current Points", "Current Grade", "Final Score", "Final Points", "Final Grade", "Override Score",
    "Override Grade", "Override Status",
)  # fmt: skip


CANVAS_EXPORT = """Student,ID,SIS User ID,SIS Login ID,Section,Quiz 1 (7),T (12),Current Score,Final Score
,,,,,Manual Posting,,,
    Points Possible,,,,,5,4,(read only),(read only)
"Lovelace, Ada",101,S-1,ada,Monday,5,,100,100
"Erdős, Paul",102,S-2,paul@example.org,Monday and Friday,4,EX,80,80
"Noether, Emmy",103,,emmy,Friday,3,2.5,60,60
"Student, Test",900,,aa0f3bb3c1de0d3ad6a8f4a2a2a1c0ffee012345,Monday,,,,
"""

MOODLE_EXPORT = """First name,Last name,ID number,Email address,Sheet 1 (Real),Last downloaded from this course
Ada,Lovelace,0042,ada@example.org,5.00,1767225600
Paul,Erdős,0043,paul@example.org,-,1767225600
Emmy,Noether,0044,emmy@example.org,3.50,1767225600
"""

Make = Callable[..., Assignment]


@pytest.fixture
def make(tmp_path: Path) -> Make:
    """Return what makes an assignment of four points with this roster.csv."""

    def made(roster: str, title: str = "T") -> Assignment:
        folder = tmp_path / "hw"
        if not folder.exists():
            make_class(folder, [Student("ada")])
        (folder / "roster.csv").write_bytes(roster.encode())
        (folder / "assignment.toml").write_text(TOML.replace('title = "T"', f"title = {title!r}".replace("'", '"')))
        return load_assignment(folder)

    return made


def three(assignment: Assignment) -> list[Result]:
    """Return results: everything right but a third; qdot failed; nothing handed in."""
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
def test_canvas_export_is_a_roster_however_it_is_written(make: Make, export: str) -> None:
    assignment = make(export)
    assert [(one.id, one.name, one.email) for one in assignment.roster] == [
        ("101", "Ada Lovelace", ""), ("102", "Paul Erdős", "paul@example.org"), ("103", "Emmy Noether", ""),
    ]  # fmt: skip
    others = {"sis user id": "S-1", "sis login id": "ada", "section": "Monday"}
    assert dict(assignment.roster[0].other_columns) == others
    header, *rows = csv.reader(io.StringIO(make_moodle_csv(assignment, three(assignment))))
    assert header[0] == "Name" and [row[0] for row in rows] == [student.name for student in assignment.roster]


def column(text: str, key: str, name: str) -> dict[str, str]:
    """Return a column of a gradebook by another; rows without a key, as that of points, are left out."""
    return {row[key]: row[name] for row in csv.DictReader(io.StringIO(text.removeprefix("\ufeff"))) if row[key]}


def test_canvas_takes_its_own_columns_back(make: Make) -> None:
    assignment = make(CANVAS_EXPORT)
    text = make_canvas_csv(assignment, three(assignment))
    rows = list(csv.reader(io.StringIO(text)))
    assert rows[0] == ["Student", "ID", "SIS User ID", "SIS Login ID", "Section", "T (12)"]
    assert rows[1] == ["    Points Possible", "", "", "", "", "4"]
    assert [row[:5] for row in rows[2:]] == [row[:5] for row in list(csv.reader(io.StringIO(CANVAS_EXPORT)))[3:6]]
    # Who is excused stays so; what was not handed in or not graded is empty, and never 0.
    assert column(text, "ID", "T (12)") == {"101": "2.6667", "102": "EX", "103": ""}
    assignment = make(CANVAS_EXPORT.replace("T (12)", "Other (12)"))  # a new assignment
    assert column(make_canvas_csv(assignment, three(assignment)), "ID", "T") == {"101": "2.6667", "102": "", "103": ""}


def test_canvas_by_a_roster_of_ones_own(make: Make) -> None:
    assignment = make("student,name,email,sis user id,section\na,Ada Lovelace,,S-1,Mon\nb,=cmd|x,,S-2,\nc,Emmy,,,\n")
    text = make_canvas_csv(assignment, three(assignment))
    assert column(text, "Student", "T") == {
        "    Points Possible": "4",
        "Ada Lovelace": "2.6667",
        "'=cmd|x": "",
        "Emmy": "",
    }
    assert column(text, "SIS User ID", "T") == {"S-1": "2.6667", "S-2": ""}
    bare = make("student\nada\npaul@example.org\nemmy\n")
    assert set(column(make_canvas_csv(bare, three(bare)), "SIS Login ID", "T")) == {"ada", "paul@example.org", "emmy"}
    excused = make("student;T\nada;ex\npaul@example.org;\nemmy;\n")
    marks = {"ada": "EX", "paul@example.org": "", "emmy": ""}
    assert column(make_canvas_csv(excused, three(excused)), "SIS Login ID", "T") == marks


@pytest.mark.parametrize(
    ("old", "new", "title", "why"),
    [
        *(("", "", f"The {word} of all", f"ignores columns whose title contains '{word}'") for word in STRIPPED),
        (",5,4,", ",5,20,", "T", r"'T \(12\)' has 20 points in Canvas, but 4 in qdot"),
        ("Quiz 1 (7)", "T (7)", "T", "2 assignments called 'T'"),
    ],
)
def test_what_canvas_would_take_for_something_else_is_refused(
    make: Make, old: str, new: str, title: str, why: str
) -> None:
    assignment = make(CANVAS_EXPORT.replace(old, new) if old else CANVAS_EXPORT, title)
    with pytest.raises(QdotError, match=why):
        make_canvas_csv(assignment, three(assignment))
    decimals = make(CANVAS_EXPORT.replace(",5,4,", ',5,"4,00",'))
    assert "T (12)" in make_canvas_csv(decimals, three(decimals)) and set(RESERVED_WORDS) == set(STRIPPED)


def test_no_name_hides_a_line_from_canvas_or_steers_a_spreadsheet(make: Make) -> None:
    """Canvas passes over every line whose first cell holds "Points Possible"."""
    export = CANVAS_EXPORT.replace("Lovelace, Ada", "Points Possible, Ada").replace("Erdős, Paul", "=1+1")
    assignment = make(export.replace("S-2", "+49 170 1"))
    text = make_canvas_csv(assignment, three(assignment))
    first = [row[0] for row in csv.reader(io.StringIO(text))]
    assert sum("Points Possible" in cell for cell in first) == 1 and first[3] == "'=1+1" and len(first) == 5
    assert "+49 170 1,paul" in text  # a number as it stands


def test_a_title_with_a_semicolon_or_a_line_break(make: Make) -> None:
    """Canvas takes semicolons for what separates only where all of three lines have as many."""
    assignment = make(CANVAS_EXPORT.replace("T (12)", "A; b; c (12)"), "A; b; c")
    text = make_canvas_csv(assignment, three(assignment))
    assert column(text, "ID", "A; b; c (12)")["101"] == "2.6667"
    assert len({len(next(csv.reader([line], delimiter=";"))) for line in text.splitlines()[:3]}) > 1
    broken = replace(assignment, title="A\nB", gradebook=None)
    assert "A B" in make_canvas_csv(broken, three(broken)).splitlines()[0]


def test_a_line_without_canvas_number_is_told(make: Make) -> None:
    with pytest.raises(QdotError, match=r"roster.csv: line 5: the column ID is empty.*'Erdős, Paul'"):
        make(CANVAS_EXPORT.replace(",102,", ",,"))
    # Without the row of points it is nobody's export.
    assert [one.id for one in make("Student,ID,Section\nada,17,Mon\n").roster] == ["ada"]


def test_moodle_export_is_a_roster(make: Make) -> None:
    students = make(MOODLE_EXPORT).roster
    assert [(one.id, one.name, one.email) for one in students][1] == ("0043", "Paul Erdős", "paul@example.org")
    german = "Vorname;Nachname;E-Mail-Adresse;Gruppen\nPaul;Erdős;paul@example.org;\n"
    assert [(one.id, one.name) for one in make(german).roster] == [("paul@example.org", "Paul Erdős")]
    with pytest.raises(QdotError, match="Moodle"):
        make("First name,Last name,Groups\nPaul,Erdős,A\n")
    with pytest.raises(QdotError, match=r"line 3: .*'ID number'"):
        make(MOODLE_EXPORT.replace("0043", ""))
    assert make(re.sub(r"004\d", "", MOODLE_EXPORT)).roster[0].id == "ada@example.org"  # nobody has a number


def test_moodle_takes_it_back(make: Make) -> None:
    """An empty cell would be 0 to Moodle's newer importer: what is no mark is a dash."""
    assignment = make(MOODLE_EXPORT)
    text = make_moodle_csv(assignment, three(assignment))
    for item, mark in (("T", "2.6667"), ("T (percent)", "66.6675")):
        assert column(text, "ID number", item) == {"0042": mark, "0043": "-", "0044": "-"}
        emails = {f"{name}@example.org": "-" for name in ("ada", "paul", "emmy")}
        assert column(text, "Email address", item) == {**emails, "ada@example.org": mark}


def test_a_column_that_would_give_a_mark_to_the_line_above_is_left_out(make: Make) -> None:
    assignment = make(MOODLE_EXPORT.replace("paul@example.org", ""))
    assert (
        make_moodle_csv(assignment, three(assignment)).splitlines()[0] == "First name,Last name,ID number,T,T (percent)"
    )
    own = make("student,name,email,username\na,Ada,ada@x.org,0\nb,Paul,ADA@x.org,paul\nc,Emmy,e@x.org,emmy\n")
    lines = make_moodle_csv(own, three(own)).splitlines()
    assert lines[:2] == ["Name,student,T,T (percent)", "Ada,a,2.6667,66.6675"]  # "0" is nothing to PHP; ada@ twice
    full = make("student,name,email,idnumber\na,Ada,ada@x.org,1\nb,Paul,p@x.org,2\nc,Emmy,e@x.org,3\n")
    assert make_moodle_csv(full, three(full)).splitlines()[1] == "Ada,1,ada@x.org,2.6667,66.6675"


def test_more_than_a_hundred_points_go_to_moodle_as_per_cent_alone(make: Make) -> None:
    assignment = make(MOODLE_EXPORT)
    results = [replace(each, max_score=120.0, score=115.0) for each in three(assignment)]
    text = make_moodle_csv(assignment, results)
    assert text.splitlines()[0].endswith("Email address,T (percent)")
    assert column(text, "ID number", "T (percent)")["0042"] == "95.8333"


def test_what_a_person_set_is_a_mark_and_what_could_not_be_read_is_none(make: Make) -> None:
    assignment = make(MOODLE_EXPORT)
    override = Override(0.0, "not handed in, no excuse", 0.0)
    first, second, third = three(assignment)
    results = [
        replace(first, obstacle="this is no notebook", score=0.0),
        replace(second, override=override, score=0.0),
        replace(third, override=override),
    ]
    assert column(make_moodle_csv(assignment, results), "ID number", "T") == {"0042": "-", "0043": "0", "0044": "0"}


def test_who_has_no_mark_is_told(make: Make, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assignment = make(CANVAS_EXPORT)
    write_requested_reports(assignment, three(assignment), [("canvas", str(tmp_path / "c.csv"))])
    assert capsys.readouterr().err == "canvas: no mark for 102 (ungraded), 103 (missing)\n"
    data = (tmp_path / "c.csv").read_bytes()
    assert data.startswith(b"Student,")  # no byte order mark: it would be a part of the first cell
    assert "Erdős".encode() in data


def test_workbook_as_openpyxl_reads_it(make: Make) -> None:
    assignment = make("student,name,email\na,=HYPERLINK(1),\nb,https://example.org,\nc,Emmy\u202e,\n")
    results = three(assignment)
    data = make_workbook(assignment, results)
    assert data == make_workbook(assignment, results)
    book = openpyxl.load_workbook(io.BytesIO(data))
    rows = [[cell.value for cell in row] for row in book["Grades"].iter_rows()]
    header = next(csv.reader(io.StringIO(make_grades_csv(results, assignment.roster))))
    assert rows[0] == header
    ada, paul, emmy = ({**dict(zip(header, row, strict=True))} for row in rows[1:])
    assert (ada["name"], ada["score"], ada["p1.jacobian"]) == ("=HYPERLINK(1)", 2.6667, 1)
    assert (paul["score"], paul["p1.jacobian"], paul["p1.position"], paul["status"]) == (None, None, 1, "ungraded")
    assert (emmy["score"], emmy["status"]) == (0, "missing")
    assert {cell.data_type for cell in book["Grades"]["B"]} == {"s"}  # a text, no formula
    assert not any(cell.hyperlink for cell in book["Grades"]["B"])
    assert emmy["name"] == "Emmy\\u202e"
    parts = [[cell.value for cell in row] for row in book["Parts"].iter_rows()]
    assert parts[2] == ["p1.jacobian", 2, 1, 0, 1, 0, 0, 1]


def test_init_with_an_export_as_roster(tmp_path: Path) -> None:
    export = tmp_path / "2026-11-22 Grades.csv"
    export.write_text(CANVAS_EXPORT)
    run("init", tmp_path / "hw", "--roster", export)
    assert (tmp_path / "hw" / "roster.csv").read_bytes() == export.read_bytes()
    assert "none.csv" in run_and_fail("init", tmp_path / "other", "--roster", tmp_path / "none.csv")
    assert not (tmp_path / "other").exists()
