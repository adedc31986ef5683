"""The command line as its contract says: results on stdout, one clear message and code 2 for bad input."""

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
from tests.support.command import run, run_and_fail, runner
from tests.support.submitting import TOML
from tests.support.suites import select_for_suite


def robot_of(task: str, *rows: tuple[str, str]) -> str:
    """Return a robot's file, with d and alpha of every joint."""
    joints = [
        f'[[joint]]\nkind = "R"\ntheta = "theta{i}"\nd = {d}\na = "a{i}"\nalpha = {alpha}\n'
        for i, (d, alpha) in enumerate(rows, 1)
    ]
    return f'name = "elbow"\ntask = {task}\n{"".join(joints)}'


ELBOW = robot_of('["vx", "vy", "vz"]', ('"d1"', '"-pi/2"'), ("0", "0"), ("0", "0"))
PLANAR = robot_of('["vx", "vy"]', ("0", "0"), ("0", "0"))


def test_help_lists_every_command_and_each_explains_itself() -> None:
    listed = run("--help").split("Commands:")[1]
    assert "..." not in listed
    for name in COMMANDS:
        assert f"  {name} " in listed
        assert len(run(name, "--help")) > 250


def test_families_and_questions() -> None:
    families = json.loads(run("families", "--json"))
    assert [family["name"] for family in families] == list(FAMILIES)
    assert [question["name"] for question in json.loads(run("questions", "--json"))] == list(ALL_QUESTIONS)
    assert "planar-2r" in run("families") and "difficulty" in run("families")
    assert "inverse-velocity" in run("questions")
    hard = {family["name"]: family["difficulty"] for family in families}
    assert hard["planar-2r"] < hard["elbow-3r"]


@pytest.mark.parametrize("like", select_for_suite(["planar-rpr"], ["planar-rpr", "random-2"]))
def test_a_family_that_is_new_in_the_registry_is_listed_without_more_ado(
    monkeypatch: pytest.MonkeyPatch, like: str
) -> None:
    family = replace(FAMILIES[like], name="my-arm", title="my arm")
    monkeypatch.setitem(FAMILIES, "my-arm", family)
    *others, found = json.loads(run("families", "--json"))
    assert (found["name"], found["title"]) == ("my-arm", "my arm")
    (known,) = [row for row in others if row["name"] == like]
    same = (
        ("joints", "questions")
        if family.has_varied_structure
        else ("joints", "questions", "difficulty", "difficulties")
    )
    assert [found[key] for key in same] == [known[key] for key in same]
    assert re.search(r"\n  my-arm +[RPvaried]+ .* my arm; ", run("families"))


@pytest.mark.parametrize(
    "family", select_for_suite(["planar-2r"], ["planar-2r", "random-2", "elbow-3r", "scara-rrrp", "random-3"])
)
def test_show_json_has_the_contracts_shape(family: str) -> None:
    shown = json.loads(run("show", f"{family}/7", "--solution", "--format", "json"))
    assert set(shown) >= {"id", "family", "seed", "engine", "robot", "symbols", "parts", "certificate"}
    assert shown["id"] == f"{family}/7"
    assert shown["certificate"]["passed"] is True
    for joint in shown["robot"]["joints"]:
        assert set(joint) >= {"kind", "theta", "d", "a", "alpha"}
    for part in shown["parts"]:
        assert set(part) >= {"name", "kind", "type", "prompt", "points", "needs", "reference"}
        assert "$" in part["prompt"] or part["prompt"]
    hidden = json.loads(run("show", f"{family}/7", "--format", "json"))
    assert all("reference" not in part for part in hidden["parts"])


@pytest.mark.parametrize("format", ["text", "latex", "html", "ipynb"])
def test_show_in_every_format_is_the_same_twice(format: str) -> None:
    first = run("show", "polar-rp/3", "--solution", "-f", format)
    assert len(first) > 1000
    assert run("show", "polar-rp/3", "--solution", "-f", format) == first


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("show", "planar-2r"), "FAMILY/SEED"),
        (("show", "planar-2r/99999999999999999999999"), "9223372036854775807"),
        (("verify", "planar-2r/9223372036854775808"), "9223372036854775807"),
        (("show", "planer-2r/7"), "did you mean 'planar-2r'"),
        (("show", "planar-2r/7", "--format", "pdf"), "text, latex, html, json, ipynb"),
        (("show", "planar-2r/7", "--questions", "jacobean"), "did you mean 'jacobian'"),
        (("show", "planar-2r/7", "--questions", ""), "--questions is empty"),
        (("show", "planar-2r/7", "--questions", " , "), "--questions is empty"),
        (("show", "planar-3r/7", "--questions", "determinant"), "not square"),
        (("solve", "nowhere.toml"), "nowhere.toml"),
        (("verify",), "give problems"),
        (("verify", "planar-2r/3", "--family", "elbow-3r"), "'planar-2r/3'"),
        (("verify", "--family", "x"), "unknown family 'x'"),
        (("verify", "nodir"), "'nodir'"),
        (("generate", "nowhere"), "qdot init nowhere"),
        (("grade", "nowhere"), "qdot init nowhere"),
        (("check", "nowhere.ipynb"), "nowhere.ipynb"),
        (("compare", "a1"), "two texts"),
        (("compare", "a1", "a1", "--type", "word"), "not one of expression"),
        (("compare", "a1", "a1+"), "the reference can't be parsed"),
        (("compare", "--batch", "nowhere.jsonl"), "nowhere.jsonl"),
        (("export", "nowhere"), "--to html"),
    ],
)
def test_bad_input_gets_one_message_and_code_2(args: tuple[str, ...], said: str) -> None:
    assert said in run_and_fail(*args)
    assert runner.invoke(app, ["show", "planar-2r/7", "--solutoin"]).exit_code == 2
    assert runner.invoke(app, ["shwo"]).exit_code == 2


@pytest.mark.whole
def test_solve_prints_example_63(tmp_path: Path) -> None:
    (tmp_path / "elbow.toml").write_text(ELBOW)
    found = json.loads(run("solve", tmp_path / "elbow.toml", "--format", "json"))
    assert found["task"] == ["vx", "vy", "vz"]
    assert [len(found["jacobian"]), len(found["geometric_jacobian"])] == [3, 6]
    judged = run("compare", found["determinant"], "a2*a3*sin(theta3)*(a1 + a2*cos(theta2) + a3*cos(theta2 + theta3))")
    assert json.loads(judged)["outcome"] == "correct"
    elbow, shoulder = found["singular"]
    assert elbow["solutions"] == {"theta3": ["0", "pi"]}
    assert (elbow["condition"], elbow["type"]) == ("sin(theta3)", "boundary")
    assert shoulder["solutions"] is None
    assert shoulder["type"] == "internal"
    (tmp_path / "planar.toml").write_text(PLANAR)
    assert "det" in run("solve", tmp_path / "planar.toml")
    assert r"\begin{document}" in run("solve", tmp_path / "planar.toml", "--format", "latex")


def test_rank_lost_everywhere_is_null_in_json_and_is_said_in_words(tmp_path: Path) -> None:
    robot = tmp_path / "elbow.toml"
    robot.write_text(ELBOW.replace('["vx", "vy", "vz"]', '["wx", "wy"]'))
    found = json.loads(run("solve", robot, "--format", "json"))
    assert found["singular"] is None
    for text in (found["note"], run("solve", robot), run("solve", "--help")):
        assert "rank in every configuration" in " ".join(text.split())


def test_solve_notes_a_length_that_may_be_in_millimetres_beside_the_results(tmp_path: Path) -> None:
    robot = tmp_path / "elbow.toml"
    robot.write_text(PLANAR.replace('"a2"', "400"))
    result = runner.invoke(app, ["solve", str(robot), "--format", "json"])
    assert result.exit_code == 0
    assert json.loads(result.stdout)["task"] == ["vx", "vy"]
    assert result.stderr.startswith(f"{robot}: line 13: joint 2: a = 400: ") and result.stderr.count("\n") == 1


def test_compare_by_argument_and_by_batch(tmp_path: Path) -> None:
    judged = json.loads(run("compare", "a1*a2*s2", "a1*a2*sin(theta2)"))
    assert judged["outcome"] == "correct"
    assert set(judged["certificate"]) == {"method", "points", "bound", "counterexample"}
    wrong = json.loads(run("compare", "a1*a2*c2", "a1*a2*sin(theta2)"))
    assert wrong["certificate"]["counterexample"]["at"]
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
    answered = [json.loads(line)["outcome"] for line in result.stdout.splitlines()]
    assert answered == ["ungraded"] * 3 + expected
    assert result.stderr.startswith("qdot: line 1: ") and "2 more lines" in result.stderr


@pytest.mark.whole
def test_verify_problems_and_families(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "qdot.exercises.common.console.PROGRESS_INTERVAL", 0.0
    )  # as long work tells its progress in a log
    result = runner.invoke(app, ["verify", "planar-pr/7", "polar-rp/1", "--jobs", "1"])
    assert result.exit_code == 0 and "2 problems verified, 0 failed" in result.stdout
    assert result.stderr.splitlines()[:2] == ["verifying: 1 of 2", "verifying: 2 of 2"]
    assert "2 problems verified, 0 failed" in run("verify", "--family", "all", "--count", "2", "--jobs", "2")


def test_verify_says_what_failed_and_a_sweep_begins_at_any_seed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Matrix, "as_typed", lambda answer: "theta1")
    said = run("verify", "--family", "planar-2r", "--count", "2", "--first-seed", "40", "--jobs", "1", code=1)
    assert {line.split()[0].rstrip(":") for line in said.splitlines()[:-1]} == {"planar-2r/40", "planar-2r/41"}
    assert "the reference answer is judged wrong" in said


@pytest.mark.parametrize(
    ("command", "said"),
    [(["verify", "--family", "planar-2r"], "--first-seed"), (["grade", "."], "again to continue"), (["families"], "")],
)
def test_ctrl_c_says_what_is_true_of_the_command(
    monkeypatch: pytest.MonkeyPatch, command: list[str], said: str
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
    assert result.stderr.startswith("qdot: stopped") and said in result.stderr
    assert ("again to continue" in result.stderr) == ("again to continue" in said)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("cli") / "hw"
    run("init", made, "--key", "hw", "--title", "Home work")
    toml = made / "assignment.toml"
    toml.write_text('title = "T"\nkey = "hw"\n[[problem]]\nfamily = "polar-rp"\nquestions = ["position", "jacobian"]\n')
    said = run("generate", made, "--jobs", "2")
    assert "2 written" in said
    return made


def test_generate_grade_and_check(folder: Path) -> None:
    assert "2 kept" in run("generate", folder)
    assert "does not exist" in run_and_fail("grade", folder, folder / "nowhere")
    assert "is not a folder; expected" in run_and_fail("grade", folder, folder / "roster.csv")
    blank = folder / "released" / "s001" / "hw.ipynb"
    solved = folder / "solutions" / "s001" / "hw.ipynb"
    assert "p1.position: left blank\n" in run("check", blank, code=1)
    assert "2 of 2 answers can be read" in run("check", solved)
    target = folder / "in" / "s001" / "hw.ipynb"
    target.parent.mkdir(parents=True)
    target.write_bytes(solved.read_bytes())
    said = run("grade", folder, folder / "in", "--jobs", "1")
    assert "1 graded, 1 missing" in said
    rows = [json.loads(line) for line in (folder / "graded" / "results.jsonl").read_text().splitlines()]
    assert [(row["student"], row["score"], row["max_score"]) for row in rows] == [("s001", 3, 3), ("s002", 0, 3)]
    assert (folder / "graded" / "feedback" / "s002.html").exists()
    result = runner.invoke(app, ["grade", str(folder), str(folder / "in"), "--fail-under", "50"])
    assert result.exit_code == 1 and "1 of 2 students below 50 %, or without a mark: s002" in result.stderr


def test_a_notebook_that_lies_in_nobodys_folder_is_told_of_one(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "hw.ipynb").write_bytes((folder / "released" / "s001" / "hw.ipynb").read_bytes())
    result = runner.invoke(app, ["grade", str(folder), str(tmp_path), "--jobs", "1"])
    said = "hw.ipynb does not name its student. Put it into a folder named after the student: STUDENT/hw.ipynb\n"
    assert said in result.stderr


def test_what_was_only_completed_need_not_be_handed_out_anew(folder: Path) -> None:
    (folder / "solutions" / "s002" / "hw.ipynb").unlink()
    result = runner.invoke(app, ["generate", str(folder), "--jobs", "1"])
    assert result.stdout.startswith("2 students: 1 completed, 1 kept; distribute")
    assert result.stderr == ""


def test_check_calls_a_list_of_conditions_no_matrix(tmp_path: Path) -> None:
    text = run("show", "planar-2r/7", "--questions", "jacobian,singular-angles", "--solution", "--format", "ipynb")
    (tmp_path / "n.ipynb").write_text(text)
    said = run("check", tmp_path / "n.ipynb")
    assert "jacobian: 2 × 2 matrix" in said
    assert said.count("matrix") == 1


def test_a_terminal_without_unicode_is_no_failure() -> None:
    shown = subprocess.run(
        [sys.executable, "-m", "qdot", "show", "planar-2r/7", "--questions", "position"],
        capture_output=True, env={**os.environ, "PYTHONIOENCODING": "ascii"}, timeout=60,
    )  # fmt: skip
    assert shown.returncode == 0, shown.stderr
    assert not shown.stderr


AT_WORK = "at work"


@pytest.fixture
def ctrl_c() -> Iterator[None]:
    """Have Ctrl-C and a closed terminal end what is started in a test, also where they don't end the tests (nohup)."""
    numbers = (signal.SIGINT, signal.SIGHUP)
    usual = [signal.signal(number, signal.default_int_handler) for number in numbers]
    yield
    for number, handler in zip(numbers, usual, strict=True):
        signal.signal(number, handler)


def ended(process: subprocess.Popen[bytes]) -> tuple[bytes, bytes]:
    """Return what a process that was stopped has printed; where it goes on, it is killed with all that it started."""
    try:
        return process.communicate(timeout=60)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()


def of_thousands(folder: Path) -> Path:
    """Make an assignment of few questions for more students than are generated before it is stopped."""
    run("init", folder)
    (folder / "roster.csv").write_text("student\n" + "".join(f"s{i}\n" for i in range(2000)))
    (folder / "assignment.toml").write_text(TOML)
    return folder


def wait_for(when: float | str, folder: Path) -> None:
    """Wait some seconds, or until the first notebook is written."""
    if isinstance(when, float | int):
        time.sleep(when)
        return
    deadline = time.monotonic() + 60
    while not list(folder.glob("released/*/*.ipynb")):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def all_gone(group: int) -> None:
    """Hold that no process of a group is left, within a time that a busy machine needs, too."""
    deadline = time.monotonic() + 5
    while left := [each for each in psutil.process_iter(["status"]) if is_alive(each, group)]:
        assert time.monotonic() < deadline, left
        time.sleep(0.05)


@pytest.mark.parametrize(
    "texts",
    [["-a1*s1", "-a1*sin(theta1)"], ["-theta1*s2", "--type", "expression", "-theta1*sin(theta2)"], ["--", "-a1", "-a1"],
     ["--5", "5"]],
)  # fmt: skip
def test_an_answer_to_compare_may_begin_with_a_minus(texts: list[str]) -> None:
    assert json.loads(run("compare", *texts))["outcome"] == "correct"


def test_an_option_of_compare_that_is_none_is_refused() -> None:
    assert runner.invoke(app, ["compare", "--jonits", "theta1", "a", "b"]).exit_code == 2


def is_alive(process: psutil.Process, group: int) -> bool:
    """Return whether a process of a group runs; an ended one that nobody has asked for doesn't."""
    try:
        return os.getpgid(process.pid) == group and process.status() != psutil.STATUS_ZOMBIE
    except (OSError, psutil.Error):
        return False


GO_ON = b"run the same command again to continue"
BEGIN_AGAIN = b"--first-seed SEED"
STOPS: list[tuple[str, str, signal.Signals, float | str]] = [
    ("generate", "group", signal.SIGINT, AT_WORK),
    ("generate", "group", signal.SIGHUP, AT_WORK),
    *(("generate", "group", signal.SIGINT, when) for when in (0.3, 1.2, 4)),
    *(("generate", whom, signal.SIGTERM, when) for whom in ("parent", "group") for when in (AT_WORK, 0.3, 4)),
    *(("verify", "parent", signal.SIGTERM, when) for when in (0.3, 4)),
]
"""Stopped while modules are loaded, at 0.3 s, or while problems are made; `make test` takes the first two alone."""


@pytest.mark.parametrize(("command", "whom", "number", "when"), select_for_suite(STOPS[:2], STOPS))
@pytest.mark.usefixtures("ctrl_c")
def test_a_stop_ends_everything_at_once_in_one_line(
    tmp_path: Path, command: str, whom: str, number: signal.Signals, when: float | str
) -> None:
    made = of_thousands(tmp_path / "hw")
    what = [str(made)] if command == "generate" else ["--family", "elbow-3r", "--count", "2000"]
    process = subprocess.Popen(
        [sys.executable, "-m", "qdot", command, *what, "--jobs", "2"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
    )  # fmt: skip
    wait_for(when, made)
    (os.kill if whom == "parent" else os.killpg)(process.pid, number)
    output, errors = ended(process)
    assert output == b""
    assert errors.startswith(b"qdot: stopped; ") and errors.count(b"\n") == 1
    assert (GO_ON if command == "generate" else BEGIN_AGAIN) in errors
    assert process.returncode == 128 + number
    all_gone(process.pid)
    assert not list(made.rglob("*.tmp"))


def test_a_stop_while_processes_start_is_a_stop_whatever_fails_then() -> None:
    def stop(number: int, _: object) -> None:
        raise KeyboardInterrupt(number)

    usual = signal.signal(signal.SIGTERM, stop)
    try:
        with pytest.raises(KeyboardInterrupt) as caught, _defer_stop():
            signal.raise_signal(signal.SIGTERM)
            raise EOFError
        assert caught.value.args == (signal.SIGTERM,)
        assert signal.getsignal(signal.SIGTERM) is stop
    finally:
        signal.signal(signal.SIGTERM, usual)


def test_a_stopped_pipe_and_ctrl_c_end_quietly(folder: Path) -> None:
    qdot = [sys.executable, "-m", "qdot"]
    shown = subprocess.Popen([*qdot, "questions", "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert shown.stdout is not None
    shown.stdout.close()
    _, errors = shown.communicate(timeout=60)
    assert b"Traceback" not in errors


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_by_itself_is_the_one_that_the_program_has(name: str) -> None:
    """Only its own modules are loaded for it."""
    alone, whole = (runner.invoke(made, [name, "--help"]) for made in (make_program(name), make_program()))
    assert alone.exit_code == 0 and alone.output == whole.output


def test_the_list_of_commands_is_that_of_the_program_and_loads_none_of_them() -> None:
    assert (
        runner.invoke(make_program(LIST_COMMANDS), ["--help"]).output
        == runner.invoke(make_program(), ["--help"]).output
    )
    listing = "import sys; from qdot.grader.cli.main import main; sys.argv = ['qdot', '--help']\n"
    listing += "try: main()\nexcept SystemExit: "
    made = subprocess.run(
        [sys.executable, "-c", f"{listing}print('sympy' in sys.modules)"], capture_output=True, text=True, check=True
    )
    assert made.stdout.startswith("Usage: qdot") and made.stdout.endswith("False\n")


@pytest.mark.parametrize("command", select_for_suite(["check"], ["show", "solve", "check"]))
def test_a_command_about_one_thing_loads_nothing_of_classes(command: str) -> None:
    loading = f"import sys; from qdot.grader.cli.main import make_program; make_program({command!r})"
    names = ("qdot.exercises.assignment.assignment", "qdot.grader.grading.batch")
    told = f"{loading}; print([name for name in {names} if name in sys.modules])"
    assert subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True).stdout == "[]\n"
