"""An assignment's folder: what is wrong in it is told with file, line or key, and what would be right."""

import os
import re
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from exercises import files
from exercises.arm.chain import CONVENTIONS, Chain, Joint
from exercises.arm.robot_file import Robot
from exercises.arm.robot_text import robot_text
from exercises.assignment import load_assignment
from exercises.errors import QdotError
from exercises.release import Released, init_assignment, notebook_path, release
from exercises.store import store_path
from grader.certify import CERTIFIER
from tests.support.command import fails

PROBLEM = '[[problem]]\nfamily = "planar-2r"\nquestions = ["position"]\n'
TOML = f'title = "T"\nkey = "hw"\n\n{PROBLEM}'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    init_assignment(tmp_path / "hw", "A title", "hw")
    return tmp_path / "hw"


def test_a_class_whose_file_is_missing_is_told_what_to_name(tmp_path: Path) -> None:
    said = fails("init", tmp_path / "hw", "--roster", tmp_path / "class.csv")
    assert f"{tmp_path / 'class.csv'}: there is no such file; name the file that has your class" in said


def test_a_new_folder_is_an_assignment(folder: Path) -> None:
    assignment = load_assignment(folder)
    assert assignment.title == "A title"
    assert [slot.name for slot in assignment.slots] == ["p1", "p2", "p3", "p4"]
    assert (folder / "secret.txt").stat().st_mode & 0o777 == 0o600
    assert (folder / "submitted").is_dir()
    assert "secret.txt" in (folder / ".gitignore").read_text()


def test_init_overwrites_nothing(folder: Path) -> None:
    before = (folder / "secret.txt").read_text()
    with pytest.raises(QdotError, match="already"):
        init_assignment(folder, "other", "other")
    assert (folder / "secret.txt").read_text() == before


@pytest.mark.parametrize(
    ("toml", "said"),
    [
        (TOML + "question = []\n", "line 7: problem 1: unknown key 'question' (did you mean 'questions'?); known: fam"),
        ('titel = "T"\n' + TOML, "line 1: unknown key 'titel' (did you mean 'title'?)"),
        (
            TOML + "hint = true\n",
            "line 7: problem 1: unknown key 'hint'; the key 'hints' is meant, probably, and stands at the top of",
        ),
        ("hint = true\n" + TOML, "line 1: unknown key 'hint' (did you mean 'hints'?); known: title, key"),
        (
            TOML.replace("planar-2r", "planer-2r"),
            "line 5: problem 1: family = \"planer-2r\": unknown family 'planer-2r' ",
        ),
        (
            TOML.replace("position", "positon"),
            "line 6: problem 1: questions = [\"positon\"]: unknown question 'positon' ",
        ),
        (TOML.replace('["position"]', '["position", "position"]'), "asked twice"),
        (
            TOML.replace('["position"]', "[]"),
            "line 6: problem 1: questions = []: it names no question; leave the key out to ask all that apply",
        ),
        (
            TOML.replace('"position"', '"quiz", "rank"'),
            'a quiz stands alone and without brackets, as in questions = "quiz"',
        ),
        (
            TOML.replace('["position"]', "[]").replace("planar-2r", "random-3"),
            "line 6: problem 1: questions = []: its arms are of many kinds; name the questions that all are asked",
        ),
        (TOML.replace("planar-2r", "planar-3r").replace('"position"', '"determinant"'), "not square"),
        (
            TOML.replace('["position"]', '"position"'),
            'questions = "position": it is a list of names, as in questions = [',
        ),
        (
            TOML + "points = [1, 2]\n",
            "line 7: problem 1: points = [1, 2]: 2 numbers for 1 question; it is a list of pos",
        ),
        (
            TOML.replace('"]\n', '", "jacobian"]\npoints = [1]\n'),
            ": 1 number for 2 questions; it is a list of positive numbers, one for each, as in points = [1, 1]",
        ),
        (TOML + "points = [-1]\n", "points = [-1]: it is a list of positive numbers, one for each question"),
        (TOML + "points = [nan]\n", "points = [nan]: it is a list of positive numbers"),
        (TOML + 'points = ["one"]\n', 'line 7: problem 1: points = ["one"]: it is a list of positive numbers'),
        (TOML + "points = 3\n", "line 7: problem 1: points = 3: it is a list of positive numbers"),
        (TOML + 'difficulty = "easy"\n', 'difficulty = "easy": it is a step from 0 to 4, or a range, as in diff'),
        (TOML + "difficulty = [1.5, 2]\n", "difficulty = [1.5, 2]: it is a step from 0 to 4"),
        (
            TOML.replace("planar-2r", "cartesian") + "difficulty = [3, 4]\n",
            "line 7: problem 1: difficulty = [3, 4]: cartesian has no arm of difficulty 3 to 4",
        ),
        (
            TOML.replace("planar-2r", "random-2") + "difficulty = 4\n",
            "no arm of difficulty 4; its arms are of difficulty 0 ",
        ),
        (
            TOML.replace("planar-2r", "random-2").replace("position", "arm-block"),
            "'arm-block' can be asked of no arm of",
        ),
        (
            TOML.replace('"planar-2r"\nquestions = ["position"]', '"random-3"'),
            "name the questions that all are asked, as in",
        ),
        (
            TOML.replace('family = "planar-2r"', "family = 2"),
            'family = 2: it is the name of a family, as in family = "',
        ),
        (TOML.replace('family = "planar-2r"\n', ""), "line 4: problem 1: each [[problem]] has either family"),
        (
            TOML.replace('family = "planar-2r"', 'robot = "arm.toml"'),
            'line 5: problem 1: robot = "arm.toml": there is no file',
        ),
        (
            TOML.replace('key = "hw"', 'key = "../hw"'),
            'line 2: key = "../hw": it names the notebooks\' files: at most 100',
        ),
        (TOML.replace('key = "hw"', 'key = "hw.ipynb"'), 'line 2: key = "hw.ipynb": it is written without .ipynb'),
        (
            TOML.replace('"hw"', '"CON"'),
            'line 2: key = "CON": it names the notebooks\' files, and on Windows none may end',
        ),
        (
            TOML.replace('"hw"', '"a."'),
            'line 2: key = "a.": it names the notebooks\' files, and on Windows none may end',
        ),
        (TOML.replace('"T"', '" "'), 'line 1: title = " ": it is a text, as in title = "'),
        (
            "due = 2027-01-15\n" + TOML,
            "line 1: due = 2027-01-15: it is a day with a time, without quotes, as in due = 20",
        ),
        ('feedback = "all"\n' + TOML, 'line 1: feedback = "all": it is "outcome", "mistake", "counterexample",'),
        (TOML.replace('title = "T"\n', ""), "assignment.toml: the key 'title' is missing; needed: title, key, problem"),
        ('title = "T"\nkey = "hw"\n', "the key 'problem' is missing"),
        (
            TOML.replace("[[problem]]", "[problem]"),
            "line 4: problem: problems are given as [[problem]] tables, one for each",
        ),
        (TOML.replace("[[problem]]", "[[problems]]"), "line 4: unknown key 'problems' (did you mean 'problem'?)"),
        ('title = "T\n', "line 1"),
        ('titel = "T"\n' + TOML.replace('title = "T"\n', ""), "unknown key 'titel' (did you mean 'title'?)"),
        (TOML.replace('"hw"', "hw"), "line 2: not valid TOML: invalid value; put text and formulas in quotes"),
        (
            TOML + 'feedback = "outcome"\n',
            "line 7: problem 1: the key 'feedback' stands at the top of the file, above every",
        ),
        (
            TOML.replace('["position"]', '["position" "jacobian"]'),
            "line 6: not valid TOML: unclosed array; names stand in",
        ),
        (
            TOML + "[problem]\n",
            "line 7: not valid TOML: cannot declare 'problem' twice; what there may be several of has",
        ),
        ("due = 2027-02-30T10:00:00\n" + TOML, "invalid date or datetime; a day with a time is written 2027-01-15T"),
        ("", "is missing"),
    ],
)
def test_what_is_wrong_in_assignment_toml_is_told(folder: Path, toml: str, said: str) -> None:
    (folder / "assignment.toml").write_text(toml)
    with pytest.raises(QdotError) as caught:
        load_assignment(folder)
    assert "assignment.toml" in str(caught.value)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("roster", "said"),
    [
        ("student,name\ns1,A\ns2,B\ns1,C\n", "line 4: student 's1' is already on line 2"),
        ("student\nAda\nada\n", "line 3: student 'ada' is already on line 2"),
        ("name,student\nA,s1\n", "the first column is 'name'"),
        ("", "is empty"),
        ("student\n", "no student is listed"),
        ("student\n../s1\n", "can't be a student's identifier"),
        ("student,name\n,Ada\n", "line 2: the first cell, the student's identifier, is empty"),
        ("student\n.\n", "can't be a student's identifier"),
        ("student\na/b\n", "can't be a student's identifier"),
        ('student\n"a\nb"\n', "line 2: a cell goes on over the end of the line; is a double quote not closed?"),
        (
            'student,name\ns1,"Ada\ns2,Bo\n',
            "line 2: this can't be read (unexpected end of data); is a double quote not",
        ),
        ("student,name\ns1,Lovelace, Ada\n", "line 2: 3 cells, and the header has 2; a text with a comma or semicolon"),
        ('student,name\n\ns1,"A"\ns1,B\n', "line 4: student 's1' is already on line 3"),
        ("student,name,name\ns1,A,B\n", "line 1: two columns are called 'name'"),
        ("name\tstudent\nA\ts1\n", "line 1: the first column is 'name', and must be 'student' (then name, email, …)"),
        ("sep=;\nname;student\n", "line 2: the first column is 'name', and must be 'student'"),
        ("student,name\ns1,A\0\n", "line 2: this is no text in UTF-8, UTF-16 or Windows-1252; save the file as "),
    ],
)
def test_what_is_wrong_in_the_roster_is_told(folder: Path, roster: str, said: str) -> None:
    (folder / "roster.csv").write_text(roster)
    with pytest.raises(QdotError) as caught:
        load_assignment(folder)
    assert "roster.csv" in str(caught.value)
    assert said in str(caught.value)


RESERVED = ("CON", "con.txt", "aux .b", "NUL", "Prn", "com1", "COM²", "lpt9.csv", "CONIN$", "ada.")


@pytest.mark.parametrize("name", RESERVED)
def test_what_windows_would_call_otherwise_is_no_student(folder: Path, name: str) -> None:
    (folder / "roster.csv").write_text(f"student\ns1\n{name}\n", encoding="utf-8")
    said = (
        f"line 3: '{re.escape(name)}' can't be a student's identifier; it names folders, and on Windows none may end in"
    )
    with pytest.raises(QdotError, match=said):
        load_assignment(folder)


def test_names_of_people_are_students(folder: Path) -> None:
    names = ("anna müller", "connie", "aux1", "com", "com10", "lpt", "nul-1", "Prnjak", "o'con", "a.b", "1", "=1", "~x")
    (folder / "roster.csv").write_text("\n".join(("student", *names, "")), encoding="utf-8")
    assert tuple(student.id for student in load_assignment(folder).roster) == names


def test_a_folder_or_file_in_an_assignment_is_told_from_it(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "submitted").mkdir(exist_ok=True)
    for inside in (folder / "submitted", folder / "assignment.toml"):
        with pytest.raises(
            QdotError, match=f"is in an assignment's folder; name that folder, {re.escape(str(folder))}$"
        ):
            load_assignment(inside)
    monkeypatch.chdir(folder / "submitted")
    with pytest.raises(QdotError, match=r"^\. is in an assignment's folder; name that folder, \.\.$"):
        load_assignment(Path())
    with pytest.raises(QdotError, match="is not a folder; 'qdot init"):
        load_assignment(folder / "none")


def test_roster_keeps_names_and_further_columns(folder: Path) -> None:
    (folder / "roster.csv").write_bytes("\ufeffStudent,Name,Email,Group\r\nzoë,Zoë É,z@x.org,B\r\n\r\n".encode())
    (student,) = load_assignment(folder).roster
    assert (student.id, student.name, student.email, student.others) == ("zoë", "Zoë É", "z@x.org", (("group", "B"),))


def test_a_roster_with_semicolons_is_read(folder: Path) -> None:
    (folder / "roster.csv").write_text('student;name;email\ns1;"Lovelace, Ada";a@x.org\n')
    (student,) = load_assignment(folder).roster
    assert (student.id, student.name, student.email) == ("s1", "Lovelace, Ada", "a@x.org")


EXCEL = {
    "UTF-8 with its mark": "utf-8-sig", "Unicode text": "utf-16", "UTF-16, the other way": "utf-16-be",
    "plain CSV": "cp1252", "UTF-8": "utf-8",
}  # fmt: skip
"""The encodings in which Excel writes a table, by what it calls them."""


@pytest.mark.parametrize("encoding", EXCEL.values(), ids=EXCEL)
@pytest.mark.parametrize("separator", [",", ";", "\t"], ids=["commas", "semicolons", "tabs"])
@pytest.mark.parametrize("end", ["\r\n", "\n", "\r"], ids=["CRLF", "LF", "CR"])
def test_a_roster_as_excel_writes_it_is_read(folder: Path, encoding: str, separator: str, end: str) -> None:
    rows = [("student", "name", "email"), ("s1", '"Strauß, Zoë – „Zo“"', "z@x.org"), ("s2", "Bo; €", ""), ("", "", "")]
    rows[2] = ("s2", '"Bo; €"', "")
    text = "".join(separator.join(row) + end for row in rows)
    mark = "\ufeff" if encoding == "utf-16-be" else ""
    (folder / "roster.csv").write_bytes((mark + text).encode(encoding))
    roster = load_assignment(folder).roster
    assert [(s.id, s.name, s.email) for s in roster] == [("s1", "Strauß, Zoë – „Zo“", "z@x.org"), ("s2", "Bo; €", "")]


def test_a_first_line_that_names_the_separator_is_read_as_excel_reads_it(folder: Path) -> None:
    (folder / "roster.csv").write_text("sep=;\nstudent;name, or what stands for it\ns1;Ada\n")
    (student,) = load_assignment(folder).roster
    assert (student.id, student.others) == ("s1", (("name, or what stands for it", "Ada"),))


@pytest.mark.parametrize(
    "content", [b"student\n\x81\n", "student\nZo\xeb\n".encode() + b"\xeb\n", b"\xff\xfes\0t\0\n\0\0\xd8"]
)
def test_bytes_that_are_no_text_are_told(folder: Path, content: bytes) -> None:
    """What is in no encoding of Excel's, or in two at once: a name read wrongly would be nobody's."""
    (folder / "roster.csv").write_bytes(content)
    with pytest.raises(QdotError, match=r"roster\.csv: line [23]: this is no text in UTF-8, UTF-16 or Windows-1252"):
        load_assignment(folder)


@pytest.mark.parametrize("own", CONVENTIONS)
def test_a_robot_is_told_as_the_nearest_key_says_else_as_its_file_does(folder: Path, own: str) -> None:
    arm = Chain("m", tuple(Joint("R", f"theta{i}", 0, f"a{i}", 0) for i in (1, 2)), ("vx", "vy"))
    (folder / "arm.toml").write_text(robot_text(Robot(arm), own))
    robot = PROBLEM.replace('family = "planar-2r"', 'robot = "arm.toml"')

    def told(top: str, problem: str) -> list[str]:
        (folder / "assignment.toml").write_text(f'title = "T"\nkey = "hw"\n{top}{robot}{problem}{PROBLEM}{problem}')
        return [problem.chain.convention for _, problem in load_assignment(folder).problems("ada")]

    assert told("", "") == [own, "dh"]
    for one in CONVENTIONS:
        assert told(f'convention = "{one}"\n', "") == [one, one]
        for other in CONVENTIONS:
            assert told(f'convention = "{one}"\n', f'convention = "{other}"\n') == [other, other]


def test_a_mistake_in_a_robot_is_told_with_both_files_and_a_doubt_is_noted(folder: Path) -> None:
    rows = (("theta1", "90 deg"), ("theta2", 0))
    robot = 'name = "x"\n' + "".join(
        f'[[joint]]\nkind = "R"\ntheta = "{theta}"\nd = 0\na = 400\nalpha = "{alpha}"\n' for theta, alpha in rows
    )
    (folder / "arm.toml").write_text(robot)
    (folder / "assignment.toml").write_text(TOML.replace('family = "planar-2r"', 'robot = "arm.toml"'))
    with pytest.raises(QdotError) as caught:
        load_assignment(folder)
    place = (
        f'{folder / "assignment.toml"}: line 5: problem 1: robot = "arm.toml": {folder / "arm.toml"}: line 7: joint 1'
    )
    assert str(caught.value) == f'{place}: alpha = "90 deg": angles are in radians; write "pi/2"'
    (folder / "arm.toml").write_text(robot.replace("90 deg", "0"))
    (said,) = load_assignment(folder).notes
    assert "arm.toml: line 6: joint 1: a = 400: lengths are in metres; is this in millimetres?" in said
    assert said.endswith("(1 more like this)")


def test_the_secret_is_needed(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    secret = (folder / "secret.txt").read_text().strip()
    with_file = load_assignment(folder)
    (folder / "secret.txt").unlink()
    monkeypatch.delenv("QDOT_SECRET", raising=False)
    with pytest.raises(QdotError, match=r"secret\.txt: there is no such file; without the secret"):
        load_assignment(folder)
    monkeypatch.setenv("QDOT_SECRET", secret)
    assert load_assignment(folder).digest == with_file.digest
    (folder / "secret.txt").write_text("short\n")
    with pytest.raises(QdotError, match="at least 16"):
        load_assignment(folder)


def test_the_digest_follows_what_decides_the_problems(folder: Path) -> None:
    before = load_assignment(folder).digest
    assert load_assignment(folder).digest == before
    path = folder / "assignment.toml"
    path.write_text(path.read_text().replace('"polar-rp"', '"elbow-3r"'))
    assert load_assignment(folder).digest != before


def test_the_digest_is_about_problems_and_the_edition_about_notebooks(folder: Path) -> None:
    (folder / "assignment.toml").write_text(TOML)
    before = load_assignment(folder)
    for changed, other_problems in (
        (TOML.replace('"T"', '"U"'), False),
        (TOML + "points = [3]\n", False),
        (TOML.replace("position", "jacobian"), True),
        (TOML + PROBLEM, True),
    ):
        (folder / "assignment.toml").write_text(changed)
        after = load_assignment(folder)
        assert (after.digest != before.digest) == other_problems
        assert after.edition != before.edition


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(QdotError, match=r"file.*can't be written: "):
        init_assignment(tmp_path / "file" / "hw", "T", "hw")


def outcomes(folder: Path) -> dict[str, str]:
    found: dict[str, str] = {}

    def each(released: Released) -> None:
        found[released.student] = released.outcome

    release(load_assignment(folder), CERTIFIER, 1, each)
    return found


def test_release_keeps_what_is_there_and_goes_on(folder: Path) -> None:
    (folder / "assignment.toml").write_text(TOML)
    assert outcomes(folder) == {"s001": "written", "s002": "written"}
    first = folder / "released" / "s001" / "hw.ipynb"
    before = first.read_bytes()
    with (folder / "roster.csv").open("a") as roster:
        roster.write("s003,Third,\n")
    (folder / "solutions" / "s002" / "hw.ipynb").unlink()
    assert outcomes(folder) == {"s001": "kept", "s002": "completed", "s003": "written"}
    assert first.read_bytes() == before
    (folder / "assignment.toml").write_text(TOML + "points = [3]\n")
    assert set(outcomes(folder).values()) == {"rewritten"}
    (folder / "assignment.toml").write_text(TOML.replace("position", "jacobian"))
    assert set(outcomes(folder).values()) == {"rewritten"}
    assert first.read_bytes() != before
    assert not list(folder.rglob("*.tmp"))


@pytest.mark.parametrize("gone", ["released", "solutions", "certificates"])
def test_what_a_killed_run_did_not_come_to_is_completed(folder: Path, gone: str) -> None:
    (folder / "assignment.toml").write_text(TOML)
    outcomes(folder)
    (path,) = (folder / gone / "s002").iterdir()
    released = folder / "released" / "s002" / "hw.ipynb"
    written, before = released.stat().st_mtime_ns, released.read_bytes()
    path.unlink()
    assert outcomes(folder) == {"s001": "kept", "s002": "completed"}
    assert path.exists()
    assert released.read_bytes() == before
    assert gone == "released" or released.stat().st_mtime_ns == written
    assert set(outcomes(folder).values()) == {"kept"}


def test_a_change_that_a_killed_run_did_not_tell_of_is_told_by_the_next(
    folder: Path,
) -> None:
    (folder / "assignment.toml").write_text(TOML)
    outcomes(folder)
    (folder / "assignment.toml").write_text(TOML + "points = [3]\n")
    solution = folder / "solutions" / "s001" / "hw.ipynb"
    of_before = solution.read_bytes()
    outcomes(folder)
    solution.write_bytes(of_before)
    assert outcomes(folder) == {"s001": "rewritten", "s002": "kept"}


def test_what_a_killed_run_had_begun_is_removed_and_what_another_writes_is_not(folder: Path) -> None:
    (folder / "assignment.toml").write_text(TOML)
    outcomes(folder)
    begun = [
        folder / "solutions" / "s001" / ".hw.ipynb.1ra2d1o5.tmp",
        folder / "released" / "s002" / ".hw.ipynb.abcd_f_8.tmp",
        folder / "certificates" / "s002" / ".hw.json.00000000.tmp",
        _begun_beside(store_path(load_assignment(folder), "s001")),
    ]
    strange = [
        folder / "solutions" / "s001" / ".other.ipynb.1ra2d1o5.tmp",
        folder / "solutions" / "s001" / "hw.ipynb.1ra2d1o5.tmp",
        folder / "solutions" / "s001" / ".hw.ipynb.swp.tmp",
        folder / "submitted" / ".hw.ipynb.1ra2d1o5.tmp",
    ]
    for path in (*begun, *strange):
        path.write_text("{")
    program = "import os, sys; from exercises.files import _begun; from pathlib import Path; "
    program += "print(_begun(Path(sys.argv[1]))[1], flush=True); sys.stdin.read()"
    with subprocess.Popen(
        [sys.executable, "-c", program, str(folder / "released" / "s001" / "hw.ipynb")],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as writer:  # fmt: skip
        assert writer.stdin is not None
        assert writer.stdout is not None
        writing = Path(writer.stdout.readline().strip())
        assert set(outcomes(folder).values()) == {"kept"}
        assert not [path for path in begun if path.exists()]
        assert [path for path in (*strange, writing) if path.exists()] == [*strange, writing]
        writer.kill()
    outcomes(folder)
    assert not writing.exists()


def test_what_a_dead_worker_had_begun_is_gone_when_the_run_is_over(folder: Path) -> None:
    (folder / "assignment.toml").write_text(TOML)
    assignment = load_assignment(folder)
    paths = [notebook_path(assignment, "s002", "solutions"), store_path(assignment, "s001")]

    def a_worker_dies(told: Released) -> None:
        for path in paths:
            path.parent.mkdir(parents=True, exist_ok=True)
            _begun_beside(path).write_text("{")

    release(assignment, CERTIFIER, 0, a_worker_dies)
    assert not list(folder.rglob("*.tmp"))
    with pytest.raises(ZeroDivisionError), files.tidied(paths):
        a_worker_dies(Released("s001", "written"))
        raise ZeroDivisionError
    assert not list(folder.rglob("*.tmp"))


def _begun_beside(path: Path) -> Path:
    return path.with_name(f".{path.name}.1ra2d1o5.tmp")


def test_a_file_that_was_tidied_away_before_it_was_locked_is_begun_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[Path] = []
    lock = files.lock

    def late(handle: int, **how: bool) -> None:
        begun.append(max(tmp_path.glob(".a.txt.*.tmp"), key=lambda path: path.stat().st_ctime_ns))
        if len(begun) == 1:
            begun[0].unlink()
        lock(handle, **how)

    monkeypatch.setattr(files, "lock", late)
    files.write_atomically(tmp_path / "a.txt", "whole")
    assert len(begun) == 2
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]
    assert (tmp_path / "a.txt").read_text() == "whole"


def test_many_files_are_made_lasting_now_and_then_and_in_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    now, asked = 0.0, []

    def flush(folder: Path) -> None:
        nonlocal now
        asked.append((now, folder))
        now += 0.2

    monkeypatch.setattr(files, "_flush_disk", flush)
    monkeypatch.setattr("exercises.files.time.monotonic", lambda: now)
    with pytest.raises(KeyboardInterrupt), files.made_lasting(tmp_path) as now_and_then:  # also when it is stopped
        for moment in (0.5, 0.9, 1.5, 1.9, 5.0, 6.0):  # having taken 0.2 s, it is not asked again for 4 s
            now = moment
            now_and_then()
        raise KeyboardInterrupt
    assert asked == [(1.5, tmp_path), (6.0, tmp_path), (6.2, tmp_path)]


def test_the_students_notebook_gives_no_seed_away(folder: Path) -> None:
    (folder / "assignment.toml").write_text(TOML)
    outcomes(folder)
    assignment = load_assignment(folder)
    text = (folder / "released" / "s001" / "hw.ipynb").read_text()
    ((_, problem),) = assignment.problems("s001")
    assert str(problem.id.seed) not in text
    assert assignment.secret not in text


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names")
def test_a_device_or_a_pipe_is_written_in_place(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    read: list[bytes] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()))
    reader.start()
    files.write_atomically(pipe, "whole")
    reader.join()
    assert read == [b"whole"] and pipe.is_fifo() and list(tmp_path.iterdir()) == [pipe]
    (tmp_path / "null").symlink_to("/dev/null")
    files.write_atomically(tmp_path / "null", "whole")
    assert (tmp_path / "null").is_char_device()


def test_what_a_link_leads_to_is_written_and_the_link_stays(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "link").symlink_to("there/file")
    for text in ("first", "second"):
        files.write_atomically(tmp_path / "link", text)
        assert (tmp_path / "link").is_symlink() and (tmp_path / "there" / "file").read_text() == text


@pytest.mark.skipif(not Path("/dev/stdout").exists(), reason="no /dev/stdout")
def test_dev_stdout_is_written_to_and_stays(tmp_path: Path) -> None:
    program = "from pathlib import Path; from exercises.files import write_atomically as w; w(Path('/dev/stdout'), 'x')"
    link = Path("/dev/stdout").readlink()
    with (tmp_path / "out").open("wb") as out:
        subprocess.run([sys.executable, "-c", program], stdout=out, check=True)
    assert (tmp_path / "out").read_text() == "x" and list(tmp_path.iterdir()) == [tmp_path / "out"]
    piped = subprocess.run([sys.executable, "-c", program], stdout=subprocess.PIPE, check=True)
    assert piped.stdout == b"x" and Path("/dev/stdout").readlink() == link


@pytest.mark.skipif(not hasattr(os, "mknod") or os.geteuid() != 0, reason="only root can replace a device")
def test_a_device_is_not_replaced_by_root_either(tmp_path: Path) -> None:
    device = tmp_path / "null"
    try:
        os.mknod(device, 0o600 | stat.S_IFCHR, os.makedev(1, 3))
        device.write_bytes(b"")
    except OSError:
        pytest.skip("no devices here")
    files.write_atomically(device, "whole")
    assert device.is_char_device() and list(tmp_path.iterdir()) == [device]
