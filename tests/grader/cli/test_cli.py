"""The command line: results on stdout; for bad input, one clear message and exit code 2."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import psutil  # type: ignore[import-untyped]
import pytest

from qdot.exercises.common.parallel import _defer_stop
from qdot.exercises.families import FAMILIES
from qdot.exercises.reference_answers import Matrix
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.grader.cli.main import COMMANDS, LIST_COMMANDS, app, make_program
from tests.support import read_cases
from tests.support.command import run, run_and_fail, runner
from tests.support.submitting import TOML
from tests.support.suites import select_for_suite


def test_help_lists_every_command_and_explains_each() -> None:
    listing = run("--help").split("Commands:")[1]
    assert "..." not in listing
    for name in COMMANDS:
        assert f"  {name} " in listing
        assert len(run(name, "--help")) > 250


def test_families_and_questions_list_the_registries() -> None:
    families = json.loads(run("families", "--json"))
    assert [family["name"] for family in families] == list(FAMILIES)
    assert [question["name"] for question in json.loads(run("questions", "--json"))] == list(ALL_QUESTIONS)
    assert "planar-2r" in run("families") and "inverse-velocity" in run("questions")
    difficulties = {family["name"]: family["difficulty"] for family in families}
    assert difficulties["planar-2r"] < difficulties["elbow-3r"]


@pytest.mark.parametrize("model", select_for_suite(["planar-rpr"], ["planar-rpr", "random-2"]))
def test_a_newly_registered_family_is_listed(monkeypatch: pytest.MonkeyPatch, model: str) -> None:
    family = replace(FAMILIES[model], name="my-arm", title="my arm")
    monkeypatch.setitem(FAMILIES, "my-arm", family)
    *other_rows, row = json.loads(run("families", "--json"))
    assert (row["name"], row["title"]) == ("my-arm", "my arm")
    (expected,) = [model_row for model_row in other_rows if model_row["name"] == model]
    keys = ["joints", "questions", *([] if family.has_varied_structure else ["difficulty", "difficulties"])]
    assert [row[key] for key in keys] == [expected[key] for key in keys]
    assert re.search(r"\n  my-arm +[RPvaried]+ .* my arm; ", run("families"))


@pytest.mark.parametrize("format", ["text", "latex", "html", "ipynb"])
def test_show_prints_the_same_twice_in_every_format(format: str) -> None:
    first = run("show", "polar-rp/3", "--solution", "-f", format)
    assert len(first) > 1000
    assert run("show", "polar-rp/3", "--solution", "-f", format) == first


@pytest.mark.parametrize(("args", "message"), read_cases("refused")["commands"])
def test_bad_input_gets_one_message_and_exit_code_2(args: tuple[str, ...], message: str) -> None:
    assert message in run_and_fail(*args)
    for words in (["show", "planar-2r/7", "--solutoin"], ["shwo"], ["compare", "--jonits", "theta1", "a", "b"]):
        assert runner.invoke(app, words).exit_code == 2


def test_solve_warns_of_a_length_in_millimetres_on_stderr(tmp_path: Path) -> None:
    robot = tmp_path / "elbow.toml"
    rows = (f'[[joint]]\nkind = "R"\ntheta = "theta{i}"\nd = 0\na = {a}\nalpha = 0\n' for i, a in ((1, 0.3), (2, 400)))
    robot.write_text('name = "elbow"\ntask = ["vx", "vy"]\n' + "".join(rows))
    result = runner.invoke(app, ["solve", str(robot), "--format", "json"])
    assert result.exit_code == 0
    assert json.loads(result.stdout)["task"] == ["vx", "vy"]
    assert result.stderr.startswith(f"{robot}: line 13: joint 2: a = 400: ") and result.stderr.count("\n") == 1


def test_compare_judges_arguments_and_batches(tmp_path: Path) -> None:
    right_answer = json.loads(run("compare", "a1*a2*s2", "a1*a2*sin(theta2)"))
    assert right_answer["outcome"] == "correct"
    assert set(right_answer["certificate"]) == {"method", "points", "bound", "counterexample"}
    wrong_answer = json.loads(run("compare", "a1*a2*c2", "a1*a2*sin(theta2)"))
    assert wrong_answer["certificate"]["counterexample"]["at"]
    requests: list[dict[str, Any]] = [
        {"id": 1, "type": "matrix", "reference": [["a1", "0"], ["0", "a2"]], "student": "[[a1, 0], [0, a2*2]]"},
        {"id": 2, "type": "angles", "reference": "{0, pi}", "student": "{pi, 2*pi}"},
        {"id": 3, "type": "singular", "reference": ["sin(theta3) = 0"], "student": "theta3 in {0, pi}",
         "joints": ["theta1", "theta2", "theta3"]},
        {"id": 4, "type": "matrix", "reference": ["a1", "a2"], "student": "[a1, a2]"},
        {"id": 5, "type": "expression", "reference": "a1", "student": ""},
        {"id": 6, "type": "matrix", "reference": 5, "student": 5},
        {"id": 7, "type": "matrix", "reference": ["a1"], "student": json.loads("[" * 900 + "]" * 900)},
        {"id": 8, "reference": [["a1", "0"], ["0", "a2"]], "student": "Matrix([[a1, 0], [0, a2]])"},
    ]  # fmt: skip
    lines = "".join(json.dumps(request) + "\n" for request in requests)
    (tmp_path / "b.jsonl").write_text(lines)
    expected = ["partial", "correct", "correct", "correct", "missing", "correct", "wrong", "correct"]
    for source, stdin in ((tmp_path / "b.jsonl", None), ("-", lines)):
        answers = [json.loads(line) for line in run("compare", "--batch", source, stdin=stdin).splitlines()]
        assert [answer["outcome"] for answer in answers] == expected
        assert [answer["id"] for answer in answers] == list(range(1, 9))
    (tmp_path / "b.jsonl").write_bytes(b'{"id": 1}\n\xff\n[]\n' + lines.encode())
    result = runner.invoke(app, ["compare", "--batch", str(tmp_path / "b.jsonl")])
    assert result.exit_code == 2
    outcomes = [json.loads(line)["outcome"] for line in result.stdout.splitlines()]
    assert outcomes == ["ungraded"] * 3 + expected
    assert result.stderr.startswith("qdot: line 1: ") and "2 more lines" in result.stderr


@pytest.mark.whole
def test_verify_counts_problems_and_reports_progress(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("qdot.exercises.common.console.PROGRESS_INTERVAL", 0.0)
    result = runner.invoke(app, ["verify", "planar-pr/7", "polar-rp/1", "--jobs", "1"])
    assert result.exit_code == 0 and "2 problems verified, 0 failed" in result.stdout
    assert result.stderr.splitlines()[:2] == ["verifying: 1 of 2", "verifying: 2 of 2"]
    assert "2 problems verified, 0 failed" in run("verify", "--family", "all", "--count", "2", "--jobs", "2")


QUESTIONS_OF_SEVERAL_FAMILIES = """
[question.tip]
prompt = "x"
answer = "p.x"
[question.slide]
prompt = "x"
answer = "d2*p.x"
[question.turn]
prompt = "x"
answer = "theta3*p.x"
"""


def test_verify_takes_the_families_of_an_assignment(tmp_path: Path) -> None:
    file = tmp_path / "assignment.toml"
    problems = '[[problem]]\nfamily = "polar-rp"\nquestions = ["slide"]\n[[problem]]\nrobot = "ur5"\n'
    file.write_text(QUESTIONS_OF_SEVERAL_FAMILIES + problems)
    output = run("verify", str(file), "--count", "1", "--jobs", "1")
    assert "tip for polar-rp/0" in output and "2 problems verified, 0 failed" in output


def test_verify_reports_every_question_that_fits_no_family(tmp_path: Path) -> None:
    file = tmp_path / "questions.toml"
    file.write_text(QUESTIONS_OF_SEVERAL_FAMILIES)
    result = runner.invoke(app, ["verify", str(file), "--family", "planar-2r", "--count", "1"])
    lines = result.stderr.strip().splitlines()
    assert (result.exit_code, ["question: slide" in line for line in lines]) == (2, [True, False]), lines
    assert "tip for planar-2r/0" in result.stdout
    assert "name the families" in run_and_fail("verify", str(file))


def test_verify_names_failed_problems_from_the_first_seed_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Matrix, "as_typed", lambda answer: "theta1")
    output = run("verify", "--family", "planar-2r", "--count", "2", "--first-seed", "40", "--jobs", "1", code=1)
    assert {line.split()[0].rstrip(":") for line in output.splitlines()[:-1]} == {"planar-2r/40", "planar-2r/41"}
    assert "the reference answer is judged wrong" in output


@pytest.mark.parametrize(
    ("command", "hint"),
    [(["verify", "--family", "planar-2r"], "--first-seed"), (["grade", "."], "again to continue"), (["families"], "")],
)
def test_ctrl_c_says_how_to_continue_the_command(
    monkeypatch: pytest.MonkeyPatch, command: list[str], hint: str
) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    for name in (
        "qdot.grader.cli.class_commands._list_family_problems",
        "qdot.grader.cli.grade_command.load_assignment",
        "qdot.grader.cli.problem_commands.describe_families",
    ):
        monkeypatch.setattr(name, stop)
    result = runner.invoke(app, command)
    assert result.exit_code == 130
    assert result.stderr.startswith("qdot: stopped") and hint in result.stderr
    assert ("again to continue" in result.stderr) == ("again to continue" in hint)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("cli") / "hw"
    run("init", folder, "--key", "hw", "--title", "Home work")
    toml = folder / "assignment.toml"
    toml.write_text('title = "T"\nkey = "hw"\n[[problem]]\nfamily = "polar-rp"\nquestions = ["position", "jacobian"]\n')
    output = run("generate", folder, "--jobs", "2")
    assert "2 written" in output
    return folder


def test_a_file_or_a_missing_file_instead_of_a_folder_is_named(tmp_path: Path) -> None:
    file = tmp_path / "notes.txt"
    file.write_text("hello", encoding="utf-8")
    assert "is not a qdot demonstration; choose another folder" in run_and_fail("demo", file)
    assert f"{file} is a file; give the assignment's folder" in run_and_fail("generate", file)
    assert run_and_fail("compare", "--batch", tmp_path / "no.jsonl").endswith(
        "no.jsonl can't be read: No such file or directory"
    )


def test_generate_grade_and_check(folder: Path) -> None:
    assert "2 kept" in run("generate", folder)
    assert "does not exist" in run_and_fail("grade", folder, folder / "nowhere")
    assert "nor a platform's zip" in run_and_fail("grade", folder, folder / "roster.csv")
    blank = folder / "released" / "s001" / "hw.ipynb"
    solved = folder / "solutions" / "s001" / "hw.ipynb"
    assert "p1.position: left blank\n" in run("check", blank, code=1)
    assert "2 of 2 answers can be read" in run("check", solved)
    target = folder / "in" / "s001" / "hw.ipynb"
    target.parent.mkdir(parents=True)
    target.write_bytes(solved.read_bytes())
    output = run("grade", folder, folder / "in", "--jobs", "1")
    assert "1 graded, 1 missing" in output
    rows = [json.loads(line) for line in (folder / "graded" / "results.jsonl").read_text().splitlines()]
    assert [(row["student"], row["score"], row["max_score"]) for row in rows] == [("s001", 3, 3), ("s002", 0, 3)]
    assert (folder / "graded" / "feedback" / "s002.html").exists()
    result = runner.invoke(app, ["grade", str(folder), str(folder / "in"), "--fail-under", "50"])
    assert result.exit_code == 1 and "1 of 2 students have less than 50 %, or no mark: s002" in result.stderr


def test_a_notebook_that_lies_in_nobodys_folder_is_told_of_one(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "hw.ipynb").write_bytes((folder / "released" / "s001" / "hw.ipynb").read_bytes())
    result = runner.invoke(app, ["grade", str(folder), str(tmp_path), "--jobs", "1"])
    said = "hw.ipynb does not name its student. Put it into a folder named after the student: STUDENT/hw.ipynb\n"
    assert said in result.stderr


def test_what_was_only_completed_need_not_be_handed_out_anew(folder: Path) -> None:
    (folder / "solutions" / "s002" / "hw.ipynb").unlink()
    result = runner.invoke(app, ["generate", str(folder), "--jobs", "1"])
    assert result.stdout.startswith("2 students: 1 completed, 1 kept; hand out")
    assert result.stderr == ""


def test_check_calls_a_list_of_conditions_no_matrix(tmp_path: Path) -> None:
    text = run("show", "planar-2r/7", "--questions", "jacobian,singular-angles", "--solution", "--format", "ipynb")
    (tmp_path / "n.ipynb").write_text(text)
    said = run("check", tmp_path / "n.ipynb")
    assert "jacobian: 2 × 2 matrix" in said
    assert said.count("matrix") == 1


def test_show_works_in_a_terminal_without_unicode() -> None:
    process = subprocess.run(
        [sys.executable, "-m", "qdot", "show", "planar-2r/7", "--questions", "position"],
        capture_output=True, env={**os.environ, "PYTHONIOENCODING": "ascii"}, timeout=60,
    )  # fmt: skip
    assert process.returncode == 0, process.stderr
    assert not process.stderr


WHILE_GENERATING = "at work"


@pytest.fixture
def ctrl_c() -> Iterator[None]:
    """Let Ctrl-C and a closed terminal end programs started by a test, even if the tests ignore them (nohup)."""
    numbers = (signal.SIGINT, signal.SIGHUP)
    handlers = [signal.signal(number, signal.default_int_handler) for number in numbers]
    yield
    for number, handler in zip(numbers, handlers, strict=True):
        signal.signal(number, handler)


def wait_for_end(process: subprocess.Popen[bytes]) -> tuple[bytes, bytes]:
    try:
        return process.communicate(timeout=60)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()


def make_large_assignment(folder: Path) -> Path:
    run("init", folder)
    (folder / "roster.csv").write_text("student\n" + "".join(f"s{i}\n" for i in range(2000)))
    (folder / "assignment.toml").write_text(TOML)
    return folder


def wait_for(moment: float | str, folder: Path) -> None:
    if isinstance(moment, float | int):
        time.sleep(moment)
        return
    deadline = time.monotonic() + 60
    while not list(folder.glob("released/*/*.ipynb")):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def assert_group_ended(group: int) -> None:
    deadline = time.monotonic() + 5
    while left := [process for process in psutil.process_iter(["status"]) if is_alive(process, group)]:
        assert time.monotonic() < deadline, left
        time.sleep(0.05)


@pytest.mark.parametrize(
    "texts",
    [["-a1*s1", "-a1*sin(theta1)"], ["-theta1*s2", "--type", "expression", "-theta1*sin(theta2)"], ["--", "-a1", "-a1"],
     ["--5", "5"]],
)  # fmt: skip
def test_compare_accepts_answers_that_begin_with_a_minus(texts: list[str]) -> None:
    assert json.loads(run("compare", *texts))["outcome"] == "correct"


def is_alive(process: psutil.Process, group: int) -> bool:
    try:
        return os.getpgid(process.pid) == group and process.status() != psutil.STATUS_ZOMBIE
    except (OSError, psutil.Error):
        return False


CONTINUE_HINT = b"run the same command again to continue"
FIRST_SEED_HINT = b"--first-seed SEED"
STOPS: list[tuple[str, str, signal.Signals, float | str]] = [
    ("generate", "group", signal.SIGINT, WHILE_GENERATING),
    ("generate", "group", signal.SIGHUP, WHILE_GENERATING),
    *(("generate", "group", signal.SIGINT, when) for when in (0.3, 1.2, 4)),
    *(("generate", whom, signal.SIGTERM, when) for whom in ("parent", "group") for when in (WHILE_GENERATING, 0.3, 4)),
    *(("verify", "parent", signal.SIGTERM, when) for when in (0.3, 4)),
]
"""Stops during imports, at 0.3 s, or while problems are generated; `make test` takes the first."""


@pytest.mark.parametrize(("command", "target", "number", "moment"), select_for_suite(STOPS[:1], STOPS))
@pytest.mark.usefixtures("ctrl_c")
def test_a_signal_ends_all_processes_with_one_line(
    tmp_path: Path, command: str, target: str, number: signal.Signals, moment: float | str
) -> None:
    folder = make_large_assignment(tmp_path / "hw")
    arguments = [str(folder)] if command == "generate" else ["--family", "elbow-3r", "--count", "2000"]
    process = subprocess.Popen(
        [sys.executable, "-m", "qdot", command, *arguments, "--jobs", "2"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
    )  # fmt: skip
    wait_for(moment, folder)
    (os.kill if target == "parent" else os.killpg)(process.pid, number)
    output, errors = wait_for_end(process)
    assert output == b""
    assert errors.startswith(b"qdot: stopped; ") and errors.count(b"\n") == 1
    assert (CONTINUE_HINT if command == "generate" else FIRST_SEED_HINT) in errors
    assert process.returncode == 128 + number
    assert_group_ended(process.pid)
    assert not list(folder.rglob("*.tmp"))


def test_a_signal_while_processes_start_outranks_other_errors() -> None:
    def stop(number: int, _: object) -> None:
        raise KeyboardInterrupt(number)

    handler = signal.signal(signal.SIGTERM, stop)
    try:
        with pytest.raises(KeyboardInterrupt) as caught, _defer_stop():
            signal.raise_signal(signal.SIGTERM)
            raise EOFError
        assert caught.value.args == (signal.SIGTERM,)
        assert signal.getsignal(signal.SIGTERM) is stop
    finally:
        signal.signal(signal.SIGTERM, handler)


def test_a_closed_pipe_causes_no_traceback() -> None:
    command = [sys.executable, "-m", "qdot", "questions", "--json"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.close()
    _, errors = process.communicate(timeout=60)
    assert b"Traceback" not in errors


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_loaded_alone_has_the_same_help(name: str) -> None:
    """The program loads only the modules of the command that is run."""
    alone, full = (runner.invoke(program, [name, "--help"]) for program in (make_program(name), make_program()))
    assert alone.exit_code == 0 and alone.output == full.output


def run_python(program: str) -> str:
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout


def test_the_list_of_commands_is_complete_and_loads_none() -> None:
    alone, full = (runner.invoke(program, ["--help"]) for program in (make_program(LIST_COMMANDS), make_program()))
    assert alone.output == full.output
    listing = "import sys; from qdot.grader.cli.main import main; sys.argv = ['qdot', '--help']\n"
    output = run_python(f"{listing}try: main()\nexcept SystemExit: print('sympy' in sys.modules)")
    assert output.startswith("Usage: qdot") and output.endswith("False\n")


@pytest.mark.parametrize("command", select_for_suite(["check"], ["show", "solve", "check"]))
def test_commands_on_single_problems_load_no_class_modules(command: str) -> None:
    load_command = f"import sys; from qdot.grader.cli.main import make_program; make_program({command!r})"
    names = ["qdot.exercises.assignment.assignment", "qdot.grader.grading.batch"]
    names += ["qdot.exercises.questions", "jinja2"] if command == "check" else []
    assert run_python(f"{load_command}; print([name for name in {names} if name in sys.modules])") == "[]\n"


def test_the_preview_of_a_class_loads_no_grader(tmp_path: Path) -> None:
    write_single_problem(tmp_path)
    program = f"import sys; from qdot.grader.cli.main import main; sys.argv = ['qdot', 'show', {str(tmp_path)!r}]\n"
    program += "try: main()\nexcept SystemExit: print([n for n in sys.modules if n.startswith('qdot.grader.')])"
    names = run_python(program).splitlines()[-1]
    assert "qdot.grader.cli.main" in names and "qdot.grader.grading" not in names and "qdot.grader.judging" not in names


def write_single_problem(folder: Path, settings: str = "") -> None:
    toml = '[[problem]]\nfamily = "planar-2r"\nquestions = ["determinant"]\n'
    (folder / "assignment.toml").write_text(f'title = "T"\nkey = "t"\n{settings}{toml}')


@pytest.mark.parametrize("format", ["text", "ipynb"])
def test_a_preview_shows_the_link_to_the_site(tmp_path: Path, format: str) -> None:
    write_single_problem(tmp_path, 'site = "https://example.edu/arms"\n')
    assert "https://example.edu/arms/check.html" in run("show", tmp_path, "--format", format)
