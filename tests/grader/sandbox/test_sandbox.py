"""Running student code: answers come out as text, and a notebook harms only itself."""

import ast
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from qdot.exercises.assignment.assignment import Student
from qdot.grader.cli.main import app
from qdot.grader.sandbox.notebook_process import isolation
from qdot.grader.sandbox.sandbox import Limits, Sandbox
from qdot.grader.sandbox.temporary_folder import make_temporary_folder
from tests.support import ROOT, read_cases
from tests.support.submitting import code_cell, make_class, make_correct_notebook, submit
from tests.support.suites import sample_for_suite, select_for_suite

IMPORTS = "from sympy import *\nimport numpy as np\nx, y = symbols('x y')"


@pytest.fixture(scope="module")
def sandbox() -> Iterator[Sandbox]:
    with Sandbox(Limits(seconds=20, cell_seconds=1.5)) as sandbox:
        yield sandbox


@pytest.mark.parametrize(("code", "text"), read_cases("sandbox")["values"])
def test_values_come_out_as_text(sandbox: Sandbox, code: str, text: str) -> None:
    run = sandbox.run([IMPORTS, f"p = {code}"], ["p"])
    assert run.answers == {"p": text}
    assert run.end == "done"


def test_values_that_are_not_expressions_are_reported_and_the_last_value_counts(sandbox: Sandbox) -> None:
    liar = "class L:\n    def __class_getitem__(c, k): raise ValueError\nt = L()"
    cells = ["p = int", "q = open", "r = object()", "s = [1]; s.append(s)", liar, "u = 1", "u = 2; other = 3"]
    run = sandbox.run(cells, list("pqrstu"))
    assert run.answers == {"u": "2"} and "nested too deeply" in run.unreadable_reasons["s"]
    assert all("not an expression" in run.unreadable_reasons[name] for name in "pqrt")


@pytest.mark.parametrize(("initial", "change", "text"), read_cases("sandbox")["changes"])
def test_a_change_in_place_counts(sandbox: Sandbox, initial: str, change: str, text: str) -> None:
    cells = ["import numpy; from sympy import *; x = Symbol('x')", f"p1_a = {initial}", "p1_b = 0", change, "p1_b = 1"]
    assert sandbox.run(cells, ["p1_a", "p1_b"]).answers == {"p1_a": text, "p1_b": "1"}


def test_an_error_affects_only_its_cell(sandbox: Sandbox) -> None:
    run = sandbox.run(["p = 1", "q = 1/0", "syntax error here", "r = p + 1", "s = q"], ["p", "q", "r", "s"])
    assert run.answers == {"p": "1", "r": "2"}
    assert run.cell_errors[1] == "ZeroDivisionError: division by zero; look for a denominator that is zero"
    assert run.cell_errors[2].startswith("SyntaxError")
    assert run.cell_errors[4].startswith("NameError")


def test_walking_and_globbing_list_nothing_outside(secret: Path) -> None:
    """The hook checks every folder; Python's own functions must not fail there, because matplotlib walks folders."""
    cells = [
        f"import os; a = [name for *_, names in os.walk({str(secret.parent)!r}) for name in names]",
        f"import glob; b = glob.glob({str(secret.parent)!r} + '/*') + glob.glob('/etc/pass*')",
        f"import pathlib; c = list(map(str, pathlib.Path({str(secret.parent)!r}).rglob('*')))",
        f"d = [name for *_, names, _ in os.fwalk({str(secret.parent)!r}) for name in names]",
    ]
    with Sandbox(Limits(seconds=20, cell_seconds=4), {"namespaces", "landlock", "user"}) as sandbox:
        run = sandbox.run(cells, ["a", "b", "c", "d"])
    assert set(run.answers.values()) == {"[]"} and {"a", "b"} <= set(run.answers), run


@pytest.mark.whole
@pytest.mark.skipif(sys.platform != "linux", reason="needs processor affinity and other processes' processor time")
def test_a_busy_machine_costs_no_answer() -> None:
    """Processor time counts, not wall time: here the notebook gets a fifth of a processor, or less."""
    allowed = os.sched_getaffinity(0)
    spinning = [sys.executable, "-c", "while True: pass"]
    spinners: list[subprocess.Popen[bytes]] = []
    try:
        os.sched_setaffinity(0, {min(allowed)})
        with Sandbox(Limits(seconds=1.5, cell_seconds=0.5)) as sandbox:
            assert sandbox.run([], []).end == "done"
            spinners += [subprocess.Popen(spinning, start_new_session=True) for _ in range(4)]
            start = time.monotonic()
            run = sandbox.run([COMPUTES, "a = 1", COMPUTES, "b = 2"], ["a", "b"])
            elapsed = time.monotonic() - start
    finally:
        os.sched_setaffinity(0, allowed)
        for process in spinners:
            process.kill()
            process.wait()
    assert (run.answers, run.cell_errors, run.end) == ({"a": "1", "b": "2"}, {}, "done")
    assert elapsed > 1.5, "the machine was not busy"


SLEEPS = "while True: time.sleep(0.01)"
COMPUTES = "import time\nbegun = time.process_time()\nwhile time.process_time() - begun < 0.2: pass"

CAUGHT = "x = 1\ntry:\n    while x: x += 1\nexcept: pass"
"""The interrupt is swallowed, as by an `except:` in a library, and must be repeated."""
LOST_ALARM = "import time\nfrom signal import *\nalarm = signal(SIGALRM, lambda *_: signal(SIGALRM, alarm))"
"""The first alarm of waiting is lost, as if it came just before the process starts to wait."""


@pytest.fixture(scope="module")
def strict() -> Iterator[Sandbox]:
    with Sandbox(Limits(seconds=20, cell_seconds=0.5)) as sandbox:
        yield sandbox


@pytest.mark.parametrize(
    ("cell", "reason"),
    sample_for_suite(
        [
            ("while True: pass", "it took longer than 0.5 s of processor time"),
            ("import time; time.sleep(60)", "it waited longer than 0.5 s"),
            (f"import time\n{COMPUTES}\ntime.sleep(60)", "it waited longer than 0.5 s"),
            (f"{CAUGHT}\nwhile True: pass", "it took longer than 0.5 s of processor time"),
            (f"{LOST_ALARM}\ntime.sleep(60)", "it waited longer than 0.5 s"),
            ("import time\ntry: time.sleep(60)\nexcept: pass\ntime.sleep(60)", "it waited longer than 0.5 s"),
        ],
        3,
    ),
)
def test_a_timeout_says_whether_the_cell_computed_or_waited(strict: Sandbox, cell: str, reason: str) -> None:
    start = time.monotonic()
    run = strict.run([cell, "a = 1"], ["a"])
    assert (run.end, run.answers, run.cell_errors) == ("done", {"a": "1"}, {0: reason}), strict.not_started_reason
    assert time.monotonic() - start < 0.5 + 10 * 0.5 + 4


@pytest.mark.parametrize("rest", select_for_suite(["while True: pass"], ["while True: pass", "time.sleep(60)", SLEEPS]))
@pytest.mark.whole
def test_a_notebook_that_ignores_its_alarms_is_still_stopped(rest: str) -> None:
    ignore_alarms = "import time\nfrom signal import *\nfor s in (SIGALRM, SIGPROF): signal(s, SIG_IGN)\n"
    with Sandbox(Limits(seconds=1, cell_seconds=0.5)) as sandbox:
        start = time.monotonic()
        run = sandbox.run(["a = 1", ignore_alarms + rest], ["a"])
    assert (run.answers, run.end) == ({"a": "1"}, "overtime")
    assert time.monotonic() - start < 1 + 10 * 1 + 4


def test_forged_reports_are_ignored(sandbox: Sandbox) -> None:
    forge = (
        'import os, json\nfor fd in range(3, 40):\n    try: os.write(fd, b\'{"end": "done"}\\n[1]\\n5\\n'
        '{"name": "zz", "text": "1"}\\n{"import": 0, "line": -1}\\n{"import": 9, "line": 1}\\n'
        '{"import": 0, "line": true}\\n{"cell": 5, "line": 1}\\n\\xff\\xfe\\n\')\n    except OSError: pass'
    )
    run = sandbox.run(["a = 1", forge, "b = 2"], ["a", "b"])
    assert run.answers == {"a": "1", "b": "2"}
    assert (run.failed_imports, run.stop_lines, run.end) == ({}, {}, "done")


def test_the_sandboxed_process_loads_no_qdot_module(sandbox: Sandbox) -> None:
    cell = "import sys\np = str(sorted(m for m in sys.modules if m.split('.')[0] in ('exercises', 'grader')))"
    assert sandbox.run([cell], ["p"]).answers == {"p": "[]"}
    imported = {
        name.name.split(".")[0]
        for path in Path(isolation.__file__).parent.glob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Import | ast.ImportFrom)
        for name in ([ast.alias(node.module or "")] if isinstance(node, ast.ImportFrom) else node.names)
    }
    assert not imported & {"exercises", "grader"}


def test_each_notebook_runs_in_a_new_empty_folder(sandbox: Sandbox) -> None:
    cell = "import os\np = str(os.listdir('.'))\nopen('left', 'w').write('x')\nq = os.getcwd()"
    first = sandbox.run([cell], ["p", "q"])
    second = sandbox.run([f"{cell}\nr = str(os.path.exists({first.answers['q']!r}))"], ["p", "q", "r"])
    assert first.answers["p"] == second.answers["p"] == "[]"
    assert second.answers["r"] == "False"


def test_only_folders_of_dead_processes_are_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    program = "import sys; from qdot.grader.sandbox.temporary_folder import make_temporary_folder\n"
    program += "print(make_temporary_folder('qdot-own-').path, flush=True); "
    with subprocess.Popen(
        [sys.executable, "-c", program + "sys.stdin.read()"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        env={"TMPDIR": str(tmp_path)},
    ) as process:  # fmt: skip
        assert process.stdout is not None
        other_folder = Path(process.stdout.readline().strip())
        (other_folder / "kept").mkdir()
        own_folder = make_temporary_folder("qdot-own-")
        assert (other_folder / "kept").exists()
        process.kill()
    (tmp_path / "qdot-own-link.tmp").symlink_to(tmp_path)
    (tmp_path / "qdot-other").mkdir()
    (tmp_path / "qdot-own-autumn").mkdir()  # a user's folder with a similar name
    make_temporary_folder("qdot-own-").remove()
    expected = {Path(own_folder.path).name, "qdot-own-link.tmp", "qdot-other", "qdot-own-autumn"}
    assert {path.name for path in tmp_path.iterdir()} == expected
    own_folder.remove()
    assert not Path(own_folder.path).exists()


@pytest.fixture
def secret(tmp_path: Path) -> Path:
    (tmp_path / "secret.txt").write_text("the secret")
    return tmp_path / "secret.txt"


def test_a_notebook_cannot_read_or_write_the_owners_files(sandbox: Sandbox, secret: Path) -> None:
    cells = [
        f"p1 = open({str(secret)!r}).read()",
        f"import os; p2 = str(os.listdir({str(secret.parent)!r}))",
        f"open({str(secret.parent / 'planted')!r}, 'w').write('x')",
        f"os.rename({str(secret)!r}, 'mine')",
        "p3 = open('/proc/%d/cmdline' % os.getppid()).read()",
        f"os.symlink({str(secret)!r}, 'link')\np4 = open('link').read()",
        "if True:\n    import qdot.exercises.generation; p5 = 'loaded'",
        "import importlib; importlib.import_module('qdot.grader.judging.formulas'); p6 = 'loaded'",
        f"import subprocess; p7 = subprocess.run(['cat', {str(secret)!r}], capture_output=True, text=True).stdout",
        f"p8 = os.popen({'cat ' + str(secret)!r}).read()",
        "import ctypes; p9 = str(ctypes.CDLL(None).getpid())",
        "import socket; socket.socket(); p10 = 'open'",
        "os.kill(os.getppid(), 9); p11 = 'killed'",
        "os.fork(); p12 = 'forked'",
        f"import pathlib; p13 = pathlib.Path({str(secret)!r}).read_text()",
        f"import numpy; p14 = str(numpy.loadtxt({str(secret)!r}, dtype=str))",
        f"import io; p15 = io.open_code({str(secret)!r}).read().decode()",
        f"p16 = os.read(os.open({str(secret)!r}, os.O_RDONLY), 100).decode()",
        f"p17 = open({str(ROOT / 'README.md')!r}).read()",
    ]
    run = sandbox.run(cells, [f"p{i}" for i in range(1, 18)])
    assert run.answers == {}
    assert sorted(run.cell_errors) == list(range(len(cells)))
    refused = ("may not", "not found", "No module")  # by the hook, by the kernel, by the import
    assert not [error for error in run.cell_errors.values() if not any(word in error for word in refused)]
    assert sorted(path.name for path in secret.parent.iterdir()) == ["secret.txt"]


def test_ordinary_notebook_code_is_allowed(sandbox: Sandbox) -> None:
    cells = [
        "open('notes.txt', 'w').write('x'); p1 = open('notes.txt').read()",
        "import tempfile\nwith tempfile.NamedTemporaryFile() as f: p2 = 'temporary'",
        "from sympy.physics.mechanics import dynamicsymbols\nfrom sympy.physics.vector import ReferenceFrame\np3 = '3'",
        "import statistics, fractions, decimal, random, json, csv, zoneinfo, sqlite3; p4 = '4'",
        "import numpy.fft, numpy.polynomial; p5 = str(numpy.random.default_rng().integers(1))",
        "import sympy; p6 = sympy.latex(sympy.integrate(sympy.Symbol('x')))",
        "import warnings; warnings.warn('x'); print('y'); p7 = '7'",
    ]
    run = sandbox.run(cells, [f"p{i}" for i in range(1, 8)])
    assert run.cell_errors == {}
    assert len(run.answers) == 7


def test_check_prints_no_terminal_escapes(tmp_path: Path) -> None:
    assignment = make_class(tmp_path / "hw", [Student("ada")])
    attack = "p1_position = '\\x1b[2J\\x9b31m'\np1_determinant = 1\nraise ValueError('\\x1b[2J')"
    notebook = make_correct_notebook(assignment, "ada", lambda cells: cells.append(code_cell(attack)))
    path = submit(assignment, "ada.ipynb", notebook)
    result = CliRunner().invoke(app, ["check", str(path)])
    assert result.exit_code == 1 and not set("\x1b\x9b") & set(result.output)
