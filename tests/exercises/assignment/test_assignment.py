"""Assignment folders: errors name file, line or key; releases survive killed runs; `decimals` allows rounding."""

import os
import re
import subprocess
import sys
import threading
from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest
import sympy as sp

from qdot.exercises.arm.chain import CONVENTIONS, Chain, Joint
from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import ReleaseResult, init_assignment, make_notebook_path, release_notebooks
from qdot.exercises.assignment.store import make_store_path
from qdot.exercises.common import files
from qdot.exercises.common.errors import QdotError
from qdot.exercises.formula.equality import Rounding
from qdot.exercises.generation import generate
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.problem.rounding import read_decimals
from qdot.exercises.reference_answers import ConditionSet, Matrix, Number
from qdot.exercises.robots.robot_file import Robot
from qdot.exercises.robots.robot_text import write_robot_text
from qdot.exercises.writing.problem_texts import write_prompt
from qdot.grader.cli.main import app
from qdot.grader.grading.certify import CERTIFIER
from qdot.grader.judging.judge import judge
from qdot.grader.judging.verdict import Outcome
from tests.support import read_cases
from tests.support.command import run, run_and_fail, runner
from tests.support.submitting import make_class

PROBLEM = '[[problem]]\nfamily = "planar-2r"\nquestions = ["position"]\n'
TOML = f'title = "T"\nkey = "hw"\n\n{PROBLEM}'


def contains_pieces(text: str, pieces: str) -> bool:
    """Return whether a text contains these pieces, which are separated by ellipses."""
    return all(piece in text for piece in pieces.split(" … "))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    init_assignment(tmp_path / "hw", "A title", "hw")
    return tmp_path / "hw"


def test_init_counts_the_students_of_a_roster_file_and_names_a_missing_one(tmp_path: Path) -> None:
    assert str(tmp_path / "class.csv") in run_and_fail("init", tmp_path / "hw", "--roster", tmp_path / "class.csv")
    (tmp_path / "class.csv").write_text("student,name\nada,Ada Lovelace\nzoe,Zoë Li\n", encoding="utf-8")
    output = run("init", tmp_path / "hw", "--roster", tmp_path / "class.csv")
    assert output.startswith(f"created {tmp_path / 'hw'} for 2 students: edit assignment.toml")


def test_init_creates_loadable_assignment(folder: Path) -> None:
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


REFUSED = read_cases("refused_assignments")


@pytest.mark.parametrize("case", REFUSED["assignment"], ids=lambda case: case["message"])
def test_error_in_assignment_toml_names_its_line(folder: Path, case: dict[str, str]) -> None:
    (folder / "assignment.toml").write_text(case["text"])
    with pytest.raises(QdotError, match=r"assignment\.toml") as caught:
        load_assignment(folder)
    assert contains_pieces(str(caught.value), case["message"])


NAMES_ON_WINDOWS = ("CON", "con.txt", "aux .b", "NUL", "Prn", "com1", "COM²", "lpt9.csv", "CONIN$", "ada.")


@pytest.mark.parametrize(
    ("roster", "message"),
    [
        *REFUSED["rosters"],
        *((f"student\ns1\n{name}\n", f"line 3 … '{name}' … Windows") for name in NAMES_ON_WINDOWS),
        (b"student\n\x81\n", "line 2 … UTF-8"),  # in none of Excel's encodings, or in two at once
        ("student\nZo\xeb\n".encode() + b"\xeb\n", "line 3 … UTF-8"),
        (b"\xff\xfes\0t\0\n\0\0\xd8", "line 2 … UTF-8"),
    ],
)
def test_error_in_roster_names_its_line(folder: Path, roster: str | bytes, message: str) -> None:
    (folder / "roster.csv").write_bytes(roster if isinstance(roster, bytes) else roster.encode())
    with pytest.raises(QdotError, match=r"roster\.csv") as caught:
        load_assignment(folder)
    assert contains_pieces(str(caught.value), message)


def test_ordinary_names_are_valid_student_ids(folder: Path) -> None:
    names = ("anna müller", "connie", "aux1", "com", "com10", "lpt", "nul-1", "Prnjak", "o'con", "a.b", "1", "=1", "~x")
    (folder / "roster.csv").write_text("\n".join(("student", *names, "")), encoding="utf-8")
    assert tuple(student.id for student in load_assignment(folder).roster) == names


def test_path_inside_assignment_is_refused_with_its_folder(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for inside in (folder / "submitted", folder / "assignment.toml"):
        with pytest.raises(QdotError, match=f"inside an assignment folder.* {re.escape(str(folder))}$"):
            load_assignment(inside)
    monkeypatch.chdir(folder / "submitted")
    with pytest.raises(QdotError, match=r"^\. .* \.\.$"):
        load_assignment(Path())
    with pytest.raises(QdotError, match="is not a folder; 'qdot init"):
        load_assignment(folder / "none")


def test_roster_keeps_names_and_extra_columns(folder: Path) -> None:
    (folder / "roster.csv").write_bytes("\ufeffStudent,Name,Email,Group\r\nzoë,Zoë É,z@x.org,B\r\n\r\n".encode())
    (student,) = load_assignment(folder).roster
    assert (student.id, student.name, student.email) == ("zoë", "Zoë É", "z@x.org")
    assert student.other_cells == (("group", "B"),)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-be", "cp1252", "utf-8"])
def test_roster_written_by_excel_is_read(folder: Path, encoding: str) -> None:
    rows = ("student name email", 's1 "Strauß,_Zoë_–_„Zo“" z@x.org', 's2 "Bo;_€" ', "  ")
    mark = "\ufeff" if encoding == "utf-16-be" else ""
    for separator, end in product(",;\t", ("\r\n", "\n", "\r")):
        text = mark + "".join(row.replace(" ", separator).replace("_", " ") + end for row in rows)
        (folder / "roster.csv").write_bytes(text.encode(encoding))
        read = [(student.id, student.name, student.email) for student in load_assignment(folder).roster]
        assert read == [("s1", "Strauß, Zoë – „Zo“", "z@x.org"), ("s2", "Bo; €", "")], (separator, end)


def test_separator_line_of_excel_is_respected(folder: Path) -> None:
    (folder / "roster.csv").write_text("sep=;\nstudent;name, or what stands for it\ns1;Ada\n")
    (student,) = load_assignment(folder).roster
    assert (student.id, student.other_cells) == ("s1", (("name, or what stands for it", "Ada"),))


@pytest.mark.parametrize("robot_convention", CONVENTIONS)
def test_nearest_convention_key_decides(folder: Path, robot_convention: str) -> None:
    arm = Chain("m", tuple(Joint("R", f"theta{i}", 0, f"a{i}", 0) for i in (1, 2)), ("vx", "vy"))
    (folder / "arm.toml").write_text(write_robot_text(Robot(arm), robot_convention))
    robot = PROBLEM.replace('family = "planar-2r"', 'robot = "arm.toml"')
    for top, nearest in product(("", *CONVENTIONS), repeat=2):
        keys = [f'convention = "{name}"\n' if name else "" for name in (top, nearest)]
        (folder / "assignment.toml").write_text(f'title = "T"\nkey = "hw"\n{keys[0]}{robot}{keys[1]}{PROBLEM}{keys[1]}')
        conventions = [problem.chain.convention for _, problem in load_assignment(folder).generate_problems("ada")]
        assert conventions == [nearest or top or robot_convention, nearest or top or "dh"], (top, nearest)


def test_error_in_robot_names_both_files_and_warning_is_a_note(folder: Path) -> None:
    rows = (("theta1", "90 deg"), ("theta2", 0))
    robot = 'name = "x"\n' + "".join(
        f'[[joint]]\nkind = "R"\ntheta = "{theta}"\nd = 0\na = 400\nalpha = "{alpha}"\n' for theta, alpha in rows
    )
    (folder / "arm.toml").write_text(robot)
    (folder / "assignment.toml").write_text(TOML.replace('family = "planar-2r"', 'robot = "arm.toml"'))
    with pytest.raises(QdotError) as caught:
        load_assignment(folder)
    places = f"{folder / 'assignment.toml'}: line 5 … {folder / 'arm.toml'}: line 7: joint 1"
    assert contains_pieces(str(caught.value), f'{places} … alpha = "90 deg" … "pi/2"')
    (folder / "arm.toml").write_text(robot.replace("90 deg", "0"))
    (message,) = load_assignment(folder).notes
    assert contains_pieces(message, "arm.toml: line 6: joint 1: a = 400 … millimetres … 1 more")


def test_secret_is_required_from_file_or_environment(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    secret = (folder / "secret.txt").read_text().strip()
    with_file = load_assignment(folder)
    (folder / "secret.txt").unlink()
    monkeypatch.delenv("QDOT_SECRET", raising=False)
    with pytest.raises(QdotError, match=r"secret\.txt: .*file not found"):
        load_assignment(folder)
    monkeypatch.setenv("QDOT_SECRET", secret)
    assert load_assignment(folder).problems_digest == with_file.problems_digest
    (folder / "secret.txt").write_text("short\n")
    with pytest.raises(QdotError, match="at least 16"):
        load_assignment(folder)


def test_problems_digest_ignores_changes_of_notebooks_only(folder: Path) -> None:
    (folder / "assignment.toml").write_text(TOML)
    before = load_assignment(folder)
    for changed, other_problems in (
        (TOML.replace('"T"', '"U"'), False),
        (TOML + "points = [3]\n", False),
        ('site = "https://example.edu"\n' + TOML, False),
        (TOML.replace("position", "jacobian"), True),
        (TOML.replace("planar-2r", "elbow-3r"), True),
        (TOML + PROBLEM, True),
    ):
        (folder / "assignment.toml").write_text(changed)
        after = load_assignment(folder)
        assert (after.problems_digest != before.problems_digest) == other_problems
        assert after.notebook_digest != before.notebook_digest


def test_unwritable_folder_is_reported(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(QdotError, match=r"file.*can't be written: "):
        init_assignment(tmp_path / "file" / "hw", "T", "hw")


def release_outcomes(folder: Path) -> dict[str, str]:
    outcomes: dict[str, str] = {}

    def record(released: ReleaseResult) -> None:
        outcomes[released.student] = released.outcome

    release_notebooks(load_assignment(folder), CERTIFIER, 1, record)
    return outcomes


@pytest.fixture
def released(folder: Path) -> Path:
    (folder / "assignment.toml").write_text(TOML)
    assert release_outcomes(folder) == {"s001": "written", "s002": "written"}
    return folder


def test_release_keeps_finished_notebooks_and_adds_missing_ones(released: Path) -> None:
    first = released / "released" / "s001" / "hw.ipynb"
    before = first.read_bytes()
    with (released / "roster.csv").open("a") as roster:
        roster.write("s003,Third,\n")
    (released / "solutions" / "s002" / "hw.ipynb").unlink()
    assert release_outcomes(released) == {"s001": "kept", "s002": "completed", "s003": "written"}
    assert first.read_bytes() == before
    for changed in (TOML + "points = [3]\n", TOML.replace("position", "jacobian")):
        (released / "assignment.toml").write_text(changed)
        assert set(release_outcomes(released).values()) == {"rewritten"}
    assert first.read_bytes() != before
    assert not list(released.rglob("*.tmp"))


@pytest.mark.parametrize("missing", ["released", "solutions", "certificates"])
def test_next_run_completes_what_a_killed_run_left_out(released: Path, missing: str) -> None:
    (path,) = (released / missing / "s002").iterdir()
    notebook = released / "released" / "s002" / "hw.ipynb"
    written, before = notebook.stat().st_mtime_ns, notebook.read_bytes()
    path.unlink()
    assert release_outcomes(released) == {"s001": "kept", "s002": "completed"}
    assert path.exists()
    assert notebook.read_bytes() == before
    assert missing == "released" or notebook.stat().st_mtime_ns == written
    assert set(release_outcomes(released).values()) == {"kept"}


def test_next_run_reports_changes_of_a_killed_run(released: Path) -> None:
    (released / "assignment.toml").write_text(TOML + "points = [3]\n")
    solution = released / "solutions" / "s001" / "hw.ipynb"
    old_solution = solution.read_bytes()
    release_outcomes(released)
    solution.write_bytes(old_solution)
    assert release_outcomes(released) == {"s001": "rewritten", "s002": "kept"}


def test_temporary_files_of_killed_runs_are_removed(released: Path) -> None:
    first_folder = released / "solutions" / "s001"
    stale = [
        first_folder / ".hw.ipynb.1ra2d1o5.tmp",
        released / "released" / "s002" / ".hw.ipynb.abcd_f_8.tmp",
        released / "certificates" / "s002" / ".hw.json.00000000.tmp",
        _temporary_path(make_store_path(released, "s001")),
    ]
    names = (".other.ipynb.1ra2d1o5.tmp", "hw.ipynb.1ra2d1o5.tmp", ".hw.ipynb.swp.tmp")
    unrelated = [*(first_folder / name for name in names), released / "submitted" / ".hw.ipynb.1ra2d1o5.tmp"]
    for path in (*stale, *unrelated):
        path.write_text("{")
    program = "import os, sys; from qdot.exercises.common.files import _open_temporary; from pathlib import Path; "
    program += "print(_open_temporary(Path(sys.argv[1]))[1], flush=True); sys.stdin.read()"
    command = [sys.executable, "-c", program, str(released / "released" / "s001" / "hw.ipynb")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as writer:
        assert writer.stdout is not None
        writing = Path(writer.stdout.readline().strip())
        assert set(release_outcomes(released).values()) == {"kept"}
        assert not [path for path in stale if path.exists()]
        assert all(path.exists() for path in (*unrelated, writing))
        writer.kill()
    release_outcomes(released)
    assert not writing.exists()


def test_temporary_files_of_dead_workers_are_removed(folder: Path) -> None:
    (folder / "assignment.toml").write_text(TOML)
    assignment = load_assignment(folder)
    paths = [make_notebook_path(assignment, "s002", "solutions"), make_store_path(assignment.folder, "s001")]

    def leave_temporary_files(_: ReleaseResult) -> None:
        for path in paths:
            path.parent.mkdir(parents=True, exist_ok=True)
            _temporary_path(path).write_text("{")

    release_notebooks(assignment, CERTIFIER, 0, leave_temporary_files)
    assert not list(folder.rglob("*.tmp"))
    with pytest.raises(ZeroDivisionError), files.clean_up_after(paths):
        leave_temporary_files(ReleaseResult("s001", "written"))
        raise ZeroDivisionError
    assert not list(folder.rglob("*.tmp"))


def _temporary_path(path: Path) -> Path:
    return path.with_name(f".{path.name}.1ra2d1o5.tmp")


def test_temporary_file_removed_before_locking_is_recreated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    begun: list[Path] = []
    lock = files.lock

    def lock_late(handle: int, **how: bool) -> None:
        begun.append(max(tmp_path.glob(".a.txt.*.tmp"), key=lambda path: path.stat().st_ctime_ns))
        if len(begun) == 1:
            begun[0].unlink()
        lock(handle, **how)

    monkeypatch.setattr(files, "lock", lock_late)
    files.write_atomically(tmp_path / "a.txt", "whole")
    assert len(begun) == 2
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]
    assert (tmp_path / "a.txt").read_text() == "whole"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes")
def test_device_or_pipe_is_written_in_place(tmp_path: Path) -> None:
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


def test_target_of_link_is_written_and_link_stays(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "link").symlink_to("there/file")
    for text in ("first", "second"):
        files.write_atomically(tmp_path / "link", text)
        assert (tmp_path / "link").is_symlink() and (tmp_path / "there" / "file").read_text() == text


@pytest.mark.skipif(not Path("/dev/stdout").exists(), reason="no /dev/stdout")
def test_dev_stdout_is_written_in_place(tmp_path: Path) -> None:
    program = "from pathlib import Path; from qdot.exercises.common.files import write_atomically as w\n"
    program += "w(Path('/dev/stdout'), 'x')"
    with (tmp_path / "out").open("wb") as out:
        subprocess.run([sys.executable, "-c", program], stdout=out, check=True)
    assert (tmp_path / "out").read_text() == "x" and list(tmp_path.iterdir()) == [tmp_path / "out"]
    piped = subprocess.run([sys.executable, "-c", program], stdout=subprocess.PIPE, check=True)
    assert piped.stdout == b"x" and Path("/dev/stdout").is_symlink()


THREE = Rounding(0.005, 0.0, "to three significant digits")
NAMES = ("position", "jacobian", "joint-rates", "singular-angles")


def make_problem(rounding: Rounding | None, *names: str) -> Problem:
    problem = generate(ProblemId("planar-2r", 3, names))
    return replace(problem, parts=tuple(replace(part, rounding=rounding) for part in problem.parts))


def is_correct(problem: Problem, answer: object) -> bool:
    return judge(problem, problem.parts[0], str(answer), "seed").outcome is Outcome.CORRECT


def round_reference(part: Part, digits: int) -> str:
    assert isinstance(part.answer, Matrix)
    numbers = {atom: sp.Float(atom, digits) for atom in part.answer.reference.atoms(sp.Rational) if atom.q > 1}
    return str(part.answer.reference.evalf(digits).xreplace(numbers).tolist())


def test_rounded_formulas_are_accepted_only_if_the_assignment_allows() -> None:
    for digits, policy, accepted in ((3, None, False), (3, THREE, True), (12, None, False), (1, THREE, False)):
        problem = make_problem(policy, "jacobian")
        assert is_correct(problem, round_reference(problem.parts[0], digits)) == accepted, (digits, policy)


def test_rounded_joint_values_are_accepted_only_if_the_assignment_allows() -> None:
    exact, loose = (make_problem(policy, "singular-angles") for policy in (None, THREE))
    answer = exact.parts[0].answer
    assert isinstance(answer, ConditionSet)
    values = [float(value) for part in answer.components for value in dict(part.solutions or ())[sp.Symbol("theta2")]]
    for digits, accepted in ((2, True), (0, False)):
        claimed = f"{{theta2: {[round(value, digits) for value in values]}}}"
        assert is_correct(loose, claimed) == accepted
        assert not is_correct(exact, claimed)


def test_tolerance_of_assignment_replaces_the_default() -> None:
    problem = make_problem(Rounding(0.0, 0.01, "within 0.01 rad/s"), "joint-rates")
    answer = problem.parts[0].answer
    assert isinstance(answer, Number)
    expected = [float(value) for value in answer.reference]
    assert is_correct(problem, [value + 0.009 for value in expected])
    assert not is_correct(problem, [value + 0.011 for value in expected])
    fine = make_problem(Rounding(5e-6, 0.0, "to six significant digits"), "joint-rates")
    assert is_correct(fine, expected)
    assert not is_correct(fine, [value * 1.001 for value in expected])


def test_prompt_states_the_rounding_rule() -> None:
    within = Rounding(0.0, 0.01, "within 0.01 rad/s")
    for policy, name, message in (
        (THREE, "jacobian", "three significant digits"), (None, "jacobian", ""), (within, "joint-rates", "within 0.01"),
        (THREE, "joint-rates", "three significant digits"),
    ):  # fmt: skip
        problem = make_problem(policy, name)
        text = write_prompt(problem, problem.parts[0])
        assert message in text and ("Decimals are" in text) == (bool(policy) and name == "jacobian"), name


@pytest.mark.parametrize(
    ("policy", "expected"),
    [
        (None, {}), ("exact", {}), (3, dict.fromkeys(NAMES, THREE)), ({"jacobian": 3}, {"jacobian": THREE}),
        (
            {"joint-rates": "1 deg/s", "jacobian": "exact"},
            {"joint-rates": Rounding(0.0, 0.017453292519943295, "within 1 deg/s")},
        ),
        ("2mm", dict.fromkeys(NAMES, Rounding(0.0, 0.002, "within 2 mm"))),
    ],
)  # fmt: skip
def test_decimals_key_is_read_as_rounding_rules(policy: object, expected: dict[str, Rounding]) -> None:
    assert dict(read_decimals(policy, NAMES)) == expected  # type: ignore[arg-type]


def _load_with_line(folder: Path, line: str) -> Assignment:
    problem = f'[[problem]]\nfamily = "planar-2r"\nquestions = ["jacobian"]\n{line}\n'
    (folder / "assignment.toml").write_text(f'title = "T"\nkey = "t"\n{problem}')
    return load_assignment(folder)


@pytest.mark.parametrize(("line", "message"), read_cases("refused")["decimals"])
def test_invalid_decimals_key_names_its_line(folder: Path, line: str, message: str) -> None:
    with pytest.raises(QdotError, match=f"line 6.*{message}"):
        _load_with_line(folder, line)


@pytest.mark.parametrize(("family", "question", "tolerance", "message"), read_cases("answers")["tolerances"])
def test_a_tolerance_has_the_unit_of_the_answer(
    folder: Path, family: str, question: str, tolerance: str, message: str
) -> None:
    other = "jacobian" if question != "jacobian" else "position"
    problem = f'family = "{family}"\nquestions = ["{question}", "{other}"]\ndecimals = {{{question} = "{tolerance}"}}\n'
    (folder / "assignment.toml").write_text(f'title = "T"\nkey = "t"\n[[problem]]\n{problem}')
    if not message:
        load_assignment(folder)
        return
    with pytest.raises(QdotError, match=f"line 6.*{tolerance}.*doesn't fit {question}.*{message}"):
        load_assignment(folder)


def test_decimals_key_changes_only_the_notebook_digest(folder: Path) -> None:
    exact, loose = _load_with_line(folder, ""), _load_with_line(folder, "decimals = 3")
    assert exact.notebook_digest != loose.notebook_digest and exact.problems_digest == loose.problems_digest
    assert loose.generate_problems("ann")[0][1].parts[0].rounding == THREE


def test_all_errors_of_an_assignment_are_reported_at_once(tmp_path: Path) -> None:
    folder = tmp_path / "hw"
    make_class(folder, [Student("ada")])
    (folder / "assignment.toml").write_text(
        'title = "T"\nkey = "a.ipynb"\nvariation = "nome"\nlat = 3\nfeedback = "all"\ndue = 2027-01-15T12:00:00\n'
        "late = {per_day = 2, grace = 15}\nattempts = {best_of = 0, apart = 3, tries = true}\n"
        "paper = {date = 3, time_allowed = 4}\n"
        '[[problem]]\nfamily = "planar-2r"\nquestons = ["position"]\n'
        '[[problem]]\nfamily = "planar-2"\npoints = "many"\ndifficulty = 9\n'
        '[[problem]]\nfamily = "planar-2r"\nquestions = ["positiom"]\npoints = [1, 2]\ncredit = "no"\n'
        '[[problem]]\nfamily = "planar-2r"\nquestions = ["mine"]\n'
        '[question.mine]\nprompt = "x"\nanswer = "ddt(o1 + o7"\n'
        "[question.other]\nprompt = 3\nanswer = 4\nx = 1\n"
    )
    (folder / "roster.csv").write_text("student,due\nada,soon\nAda,\n/x,\n")
    messages = run_and_fail_with_lines("generate", folder)
    places = [place for message in messages for place in re.findall(r"(\w+\.\w+): line (\d+)", message)[:1]]
    assert len(places) == len(messages)
    assert sorted(int(line) for file, line in places if file == "roster.csv") == [2, 3, 4]
    lines = [2, 3, 4, 5, 7, 7, 8, 8, 8, 9, 9, 12, 14, 15, 16, 19, 20, 21, 27, 29, 30, 31]
    assert sorted(int(line) for file, line in places if file == "assignment.toml") == lines
    (folder / "assignment.toml").write_text('title = "T\n')
    assert len(run_and_fail_with_lines("generate", folder)) == 4  # TOML has one error of syntax at a time


def run_and_fail_with_lines(*arguments: str | Path) -> list[str]:
    result = runner.invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == 2 and "Traceback" not in result.output
    return result.stderr.strip().splitlines()
