"""A class in which most students attack the grader: the honest ones keep full marks, and every report is harmless.

In `make whole` 25 of 30 students attack, in `make test` five of seven. test_sandbox_hostile.py tries each attack alone.
"""

import csv
import io
import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from qdot.exercises.assignment.assignment import Assignment, load_assignment
from qdot.exercises.assignment.release import init_assignment, release_notebooks
from qdot.exercises.common.console import escape_controls
from qdot.grader.cli.demo import fill_in_answers
from qdot.grader.cli.main import app
from qdot.grader.grading.batch import grade_class
from qdot.grader.grading.result import Result
from qdot.grader.reports.feedback import make_feedback_page
from qdot.grader.reports.graded_folder import write_reports
from qdot.grader.reports.grades_table import make_grades_csv, make_results_jsonl
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import find_submissions
from tests.support.submitting import UNCERTIFIED
from tests.support.suites import sample_for_suite, select_for_suite

TOML = 'title = "T"\nkey = "hw"\n[[problem]]\nfamily = "planar-2r"\nquestions = ["position", "determinant"]\n'
HONEST = ["s01", *select_for_suite(["s04"], ["s08", "s15", "s22", "s30"])]
STUDENTS = [f"s{i:02d}" for i in range(1, select_for_suite(8, 31))]
ATTACKS = [
    "while True: pass", "sum(range(10**12))", "import os; os._exit(0)", "import os; os.abort()",
    "import sys; sys.exit()", "import os; os.kill(os.getppid(), 9)", "import os; os.fork()",
    "import os; os.system('touch {folder}/planted')", "x = [bytearray(10**9) for _ in range(99)]",
    "import sys; sys.setrecursionlimit(10**9); l = []\nfor i in range(10**6): l = [l]\nrepr(l)",
    "import sympy; sympy.Basic.__eq__ = sympy.Basic.__str__ = lambda *a: True",
    "import builtins; builtins.isinstance = lambda *a: True", "import sys; sys.modules.clear()",
    "import os\nfor fd in range(3, 64):\n    try: os.write(fd, b'{{}}\\n' * 10**6)\n    except OSError: pass",
    "import os; os.closerange(3, 64)", "print('x' * 10**8)", "open('{folder}/submitted/s01/hw.ipynb', 'w').write('x')",
    "p1_determinant = open('{folder}/solutions/s02/hw.ipynb').read()",
    "p1_determinant = open('{folder}/secret.txt').read()", "import socket; socket.create_connection(('127.0.0.1', 80))",
    "raise SystemExit('<script>alert(1)</script>')",
    "raise ValueError('\\x1b[2J\\x9b31m=cmd|calc!A1 <img src=x onerror=alert(1)> \\u202egnp')",
    "p1_determinant = '<script>alert(1)</script>'", "p1_determinant = '=HYPERLINK(\"http://evil\")\\x1b]0;x\\x07'",
    "class L:\n    __class__ = str\n    def __reduce__(self): return (print, ())\np1_determinant = L()",
]  # fmt: skip


@pytest.fixture(scope="module")
def assignment(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    folder = tmp_path_factory.mktemp("class") / "hw"
    init_assignment(folder, "T", "hw", secret="CANARY0123456789abcdef")
    (folder / "assignment.toml").write_text(TOML)
    (folder / "roster.csv").write_text("student,name\n" + "".join(f"{s},\u202e\x1b[2J {s}\n" for s in STUDENTS))
    release_notebooks(load_assignment(folder), UNCERTIFIED, 0, lambda _: None)
    return load_assignment(folder)


def insert_attack(text: str, attack: str, is_last: bool) -> str:
    """Insert an attacking cell between the answers, or after the last one."""
    notebook = json.loads(text)
    cells = notebook["cells"]
    name = "p1_determinant" if is_last else "p1_position"
    index = next(i for i, cell in enumerate(cells) if re.search(rf"(?m)^{name} *=", "".join(cell["source"])))
    cells.insert(index + 1, {**cells[index], "id": "attack", "metadata": {}, "source": attack})
    return json.dumps(notebook)


def test_attacks_change_no_honest_mark_and_no_file(assignment: Assignment) -> None:
    attacks = iter(sample_for_suite(ATTACKS, 5))
    folder = assignment.folder
    for student in STUDENTS:
        text = fill_in_answers(
            (folder / "released" / student / "hw.ipynb").read_text(),
            assignment.generate_problems(student),
            lambda code, _: code,
        )
        if student not in HONEST:
            attack = next(attacks)
            text = insert_attack(text, attack.format(folder=folder), "p1_determinant" in attack)
        path = folder / "submitted" / student / "hw.ipynb"
        path.parent.mkdir(parents=True)
        path.write_text(text)
    assert next(attacks, None) is None
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    submissions = find_submissions(assignment, folder / "submitted").by_student
    results = grade_class(
        assignment, submissions, 2, Limits(seconds=4, cell_seconds=0.8, memory=1 << 30), lambda _: None
    )
    assert [result.student for result in results] == STUDENTS
    for result in results:
        position, determinant = result.problems[0].parts
        assert position.outcome == "correct", result
        if result.student in HONEST:
            assert determinant.outcome == "correct" and not result.staff_notes
        assert "ungraded" not in (position.outcome, determinant.outcome)
    assert {path: path.read_bytes() for path in before} == before
    assert not (folder / "planted").exists()
    write_reports(assignment, results)
    assert_reports_are_harmless(assignment, results)


def assert_reports_are_harmless(assignment: Assignment, results: list[Result]) -> None:
    table, lines = make_grades_csv(results, assignment.roster), make_results_jsonl(results).decode()
    assert escape_controls(table) == table and escape_controls(lines) == lines
    for row in csv.reader(io.StringIO(table)):
        assert len(row) == 12
        for cell in row:
            assert not re.match(r"\s*[=+@]|\s*-\D", cell), cell
    assert [json.loads(line)["student"] for line in lines.splitlines()] == STUDENTS
    for student, result in zip(assignment.roster, results, strict=True):
        page = make_feedback_page(assignment, student, result).replace(student.name, "")  # the staff wrote the roster
        assert "<script>alert" not in page and "<img src=x" not in page and "CANARY" not in page
        assert "\x1b" not in page and "\x9b" not in page


def test_check_prints_no_terminal_escapes(assignment: Assignment, tmp_path: Path) -> None:
    text = (assignment.folder / "released" / "s01" / "hw.ipynb").read_text()
    attack = "p1_position = '\\x1b[2J\\x9b31m'\np1_determinant = 1\nraise ValueError('\\x1b[2J')"
    path = tmp_path / "hw.ipynb"
    path.write_text(insert_attack(text, attack, is_last=True))
    result = CliRunner().invoke(app, ["check", str(path)])
    assert result.exit_code == 1 and not set("\x1b\x9b") & set(result.output)
