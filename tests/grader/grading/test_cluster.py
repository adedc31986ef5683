"""A class graded on a fake client and on a real Dask cluster whose workers die: the results are the same bytes.

The scheduler gives a task up when the first worker dies, so that retries are tested, too.
"""

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import psutil  # type: ignore[import-untyped]
import pytest
from typer.testing import CliRunner, Result

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import explain_missing
from qdot.exercises.common.files import write_atomically
from qdot.grader.cli.main import app
from qdot.grader.grading import batch, cluster
from qdot.grader.grading.batch import grade_class
from qdot.grader.grading.result import NotebookMarks
from qdot.grader.reports.grades_table import make_grades_csv, make_results_jsonl
from qdot.grader.sandbox import guarantees
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import Submission, find_submissions
from tests.support import ROOT
from tests.support.command import run_and_fail
from tests.support.submitting import answer_and_submit, find_stored_marks, release_class

pytestmark = [
    pytest.mark.xdist_group("cluster"),
    pytest.mark.skipif(sys.platform == "win32", reason="sandboxes need fork"),
]

TOML = """title = "T"
key = "hw"
[[problem]]
family = "planar-2r"
questions = ["position", "determinant"]
"""
STUDENTS = [f"s{i}" for i in range(9)]
OPTIONS = ("--seconds", "60", "--jobs", "1")
LIMITS = Limits(seconds=60.0, cell_seconds=30.0)  # the limits of --seconds 60
DEADLY = "import os\nos.kill(os.getppid(), 9)\n"


@pytest.fixture(scope="module")
def submitted_class(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a class of nine: right, wrong, hostile, truncated and missing work, and metadata too deep to pickle."""
    assignment = release_class(tmp_path_factory.mktemp("class") / "hw", [Student(name, "N") for name in STUDENTS], TOML)
    wrong_answers = {"s1": "a1 + theta1", "s2": f"exec({DEADLY!r})", "s3": "__import__('os')._exit(0)"}
    for student in STUDENTS[:-1]:
        wrong = wrong_answers.get(student, "")
        answer = {"determinant": wrong} if wrong else {}
        path = answer_and_submit(assignment, student, lambda code, part: answer.get(part.name, code))  # noqa: B023
        os.utime(path, (1_700_000_000, 1_700_000_000))
    folder = assignment.folder
    path = folder / "submitted" / "s4" / "hw.ipynb"
    path.write_text(path.read_text()[:500])
    path = folder / "submitted" / "s5" / "hw.ipynb"
    notebook = json.loads(path.read_text())
    notebook["metadata"]["qdot"]["problems_digest"] = json.loads("[" * 300 + "]" * 300)
    path.write_text(json.dumps(notebook))
    return folder


def grade_locally(
    folder: Path, executor: str = "", on_student: Callable[[int], None] = lambda _: None
) -> dict[str, bytes]:
    """Grade a class without feedback pages and return the bytes of its files; `on_student` gets the number done."""
    assignment, done = load_assignment(folder), []

    def count(_: object) -> None:
        done.append(1)
        on_student(len(done))

    submissions = find_submissions(assignment, folder / "submitted").by_student
    results = grade_class(assignment, submissions, 1, LIMITS, count, executor=executor)
    write_atomically(folder / "graded" / "results.jsonl", make_results_jsonl(results))
    write_atomically(folder / "graded" / "grades.csv", make_grades_csv(results, assignment.roster))
    return read_reports(folder)


def read_reports(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in (folder / "graded").rglob("*")
        if path.is_file() and path.name not in ("lock", "costs.csv")
    }


@pytest.fixture(scope="module")
def undisturbed(submitted_class: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    reports = grade_locally(Path(shutil.copytree(submitted_class, tmp_path_factory.mktemp("local") / "hw")))
    assert len(reports) == len(STUDENTS) + 2
    results = [json.loads(line) for line in reports["graded/results.jsonl"].decode().splitlines()]
    scores = {result["student"]: result["score"] for result in results}
    assert scores == {**dict.fromkeys(STUDENTS, 2), **dict.fromkeys(("s1", "s2", "s3"), 1), "s4": 0, "s8": 0}
    return reports


@pytest.fixture
def folder(submitted_class: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(submitted_class, tmp_path / "hw"))


# --- workers of ours ---


class KilledWorker(Exception):
    """Named like Dask's exception."""


class DyingClient:
    """A client with one worker in this process, which dies a number of times on one student."""

    def __init__(self, victim: str, times: int) -> None:
        self.victim, self.times, self.threads = victim, times, 1

    def nthreads(self) -> dict[str, int]:
        return {"here": 1}

    def submit(self, work: Callable[..., Any], *values: Any, pure: bool) -> "Future[Any]":
        future: Future[Any] = Future()
        arguments = [value.result() if isinstance(value, Future) else value for value in values]
        if arguments[1:] and arguments[1] == self.victim and self.times:
            self.times -= 1
            future.set_exception(KilledWorker())
            return future
        try:
            future.set_result(work(*arguments))
        except QdotError as error:
            future.set_exception(error)
        return future


@contextmanager
def use_dying_worker(monkeypatch: pytest.MonkeyPatch, victim: str = "", times: int = 0) -> Iterator[None]:
    @contextmanager
    def connect(address: str, assignment: Assignment, limits: Limits) -> Iterator[cluster.Cluster]:
        yield cluster.Cluster(cast(Any, DyingClient(victim, times)), address, cluster.make_brief(assignment, limits))

    monkeypatch.setattr(batch, "connect", connect)
    yield
    cluster.drop_assignment()


@pytest.mark.whole
def test_a_student_is_ungraded_after_killing_two_workers(
    folder: Path, undisturbed: dict[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    with use_dying_worker(monkeypatch, "s0", 2):
        reports = grade_locally(folder, "tcp://here:1")
    lines = reports["graded/results.jsonl"].decode().splitlines()
    assert "the system ended its process twice" in json.loads(lines[0])["obstacle"]
    assert lines[1:] == undisturbed["graded/results.jsonl"].decode().splitlines()[1:]
    assert len(find_stored_marks(folder)) == len(STUDENTS) - 1
    with use_dying_worker(monkeypatch, "s0", 1):
        assert grade_locally(folder, "tcp://here:1") == undisturbed
    assert not cluster._worker_state


def test_every_worker_must_have_a_strict_sandbox(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "assignment.toml").write_text('sandbox = "strict"\n' + TOML)
    probe = guarantees.probe
    monkeypatch.setattr(guarantees, "probe", lambda quick: probe(quick=True))
    monkeypatch.setattr(guarantees.Findings, "is_strict", False)
    with use_dying_worker(monkeypatch), pytest.raises(QdotError, match=r"worker .*strict"):
        grade_locally(folder, "tcp://here:1")


def test_an_idle_worker_forgets_the_assignment(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "IDLE_TIMEOUT", 0.2)
    brief = cluster.make_brief(load_assignment(folder), LIMITS)
    assert "N" not in [student.name for student in brief.assignment.roster]
    cluster.mark_on_worker(brief, "s8", None)
    deadline = time.monotonic() + 30
    while cluster._worker_state and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not cluster._worker_state


# --- a real cluster ---


@contextmanager
def run_dask(*arguments: str, cwd: Path, pythonpath: Path = ROOT) -> Iterator["subprocess.Popen[bytes]"]:
    """Run a Dask program, and check that it leaves no process behind."""
    settings = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0", "TMPDIR": str(cwd)}
    environment = {**os.environ, "PYTHONPATH": str(pythonpath), **settings}
    command = [sys.executable, "-m", *arguments]
    with (cwd / "log").open("ab") as log:
        process = subprocess.Popen(command, cwd=cwd, env=environment, stdout=log, stderr=log, start_new_session=True)
    try:
        yield process
    finally:
        processes = find_children(process.pid)
        process.terminate()
        process.wait(60)
        assert not psutil.wait_procs(processes, 30)[1], "it left something running"


def find_children(pid: int) -> list[psutil.Process]:
    try:
        processes: list[psutil.Process] = psutil.Process(pid).children(recursive=True)
    except psutil.NoSuchProcess:
        return []
    return processes


@contextmanager
def start_scheduler(folder: Path) -> Iterator[str]:
    path = folder / "scheduler.json"
    options = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(path))
    with run_dask("distributed.cli.dask_scheduler", *options, cwd=folder):
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline:
            if path.exists() and (text := path.read_text()).endswith("}"):
                yield json.loads(text)["address"]
                return
            time.sleep(0.05)
        raise AssertionError((folder / "log").read_text())


@contextmanager
def start_worker(address: str, folder: Path, pythonpath: Path = ROOT) -> Iterator["subprocess.Popen[bytes]"]:
    folder.mkdir()
    options = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--memory-limit", "0", "--host", "127.0.0.1")
    with run_dask("distributed.cli.dask_worker", address, *options, cwd=folder, pythonpath=pythonpath) as process:
        deadline = time.monotonic() + 60
        while "Registered to" not in (folder / "log").read_text():
            assert time.monotonic() < deadline and process.poll() is None, (folder / "log").read_text()
            time.sleep(0.05)
        yield process


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    folder = tmp_path_factory.mktemp("cluster")
    with (
        start_scheduler(folder) as scheduler,
        start_worker(scheduler, folder / "one"),
        start_worker(scheduler, folder / "two"),
    ):
        yield scheduler
    assert not list(folder.rglob("qdot-*")), "a sandbox left its folder"


def grade(folder: Path, address: str, *options: str) -> Result:
    return CliRunner().invoke(app, ["grade", str(folder), "--executor", address, *OPTIONS, *options])


@pytest.mark.integration
def test_a_cluster_writes_the_same_reports_as_one_process(
    folder: Path, address: str, submitted_class: Path, undisturbed: dict[str, bytes], tmp_path: Path
) -> None:
    result = grade(folder, address)
    counts = f"{len(STUDENTS)} students: 7 graded, 1 unusable, 1 missing"
    assert (result.exit_code, result.stdout.split(";")[0]) == (0, counts)
    assert "Traceback" not in result.stderr and "distributed" not in result.stderr
    assert {name: content for name, content in read_reports(folder).items() if "feedback" not in name} == undisturbed
    local = Path(shutil.copytree(submitted_class, tmp_path / "local"))
    local_run = CliRunner().invoke(app, ["grade", str(local), *OPTIONS])
    assert local_run.stdout.replace(str(local), str(folder)) == result.stdout
    assert read_reports(local) == read_reports(folder)


@pytest.mark.integration
def test_killing_a_worker_changes_no_result(
    folder: Path, address: str, undisturbed: dict[str, bytes], tmp_path: Path
) -> None:
    shutil.rmtree(folder / ".qdot")  # the stored problems
    with start_worker(address, tmp_path / "third") as third:
        processes: list[psutil.Process] = []

        def kill(done: int) -> None:
            if done == 2:
                processes.extend(find_children(third.pid))
                third.send_signal(signal.SIGKILL)

        assert grade_locally(folder, address, kill) == undisturbed
        assert third.wait(10) == -signal.SIGKILL
        assert not psutil.wait_procs(processes, 30)[1], "the dead worker's sandbox is still there"


@pytest.mark.integration
def test_a_worker_with_other_code_grades_nothing(folder: Path, address: str, tmp_path: Path) -> None:
    changed_code = tmp_path / "other"
    for source, target in (("qdot", "qdot"), ("templates", "qdot/templates")):  # as in a wheel
        shutil.copytree(ROOT / source, changed_code / target, ignore=shutil.ignore_patterns("__pycache__"))
    with (changed_code / "qdot" / "grader" / "judging" / "judge.py").open("a") as file:
        file.write("# changed\n")
    with start_worker(address, tmp_path / "third", changed_code):
        result = grade(folder, address)
    (line,) = result.stderr.splitlines()
    assert result.exit_code == 2
    assert line.startswith("qdot: worker ") and "install the same qdot" in line


@pytest.mark.integration
def test_missing_and_lost_workers_are_errors_and_marks_are_kept(
    folder: Path, undisturbed: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "FIRST_WORKER_TIMEOUT", 0.3)
    monkeypatch.setattr(cluster, "WORKER_RETURN_TIMEOUT", 0.3)
    with start_scheduler(tmp_path) as address:
        result = grade(folder, address)
        assert result.exit_code == 2
        assert f"dask worker {address} " in result.stderr and result.stderr.count("\n") == 1
        message = f"all workers of {address} have left"
        killed, try_to_mark = threading.Event(), cluster.Cluster._try_to_mark
        first_student = load_assignment(folder).roster[0].id

        def wait_for_kill(self: cluster.Cluster, student: str, submission: Submission | None) -> NotebookMarks | None:
            """Hold the other students back, so that work is left when the worker is killed."""
            if student != first_student:
                killed.wait(60)
            return try_to_mark(self, student, submission)

        monkeypatch.setattr(cluster.Cluster, "_try_to_mark", wait_for_kill)
        with start_worker(address, tmp_path / "only") as last_worker, pytest.raises(QdotError, match=message):

            def kill(_: int) -> None:
                last_worker.send_signal(signal.SIGKILL)
                killed.set()

            grade_locally(folder, address, kill)
    stored = find_stored_marks(folder)
    assert stored
    assert grade_locally(folder) == undisturbed
    assert find_stored_marks(folder).items() >= stored.items()


INVALID_ADDRESSES = ("banana", "127.0.0.1:8786", "tcp://", "tcp://host", "http://h:1", "tcp://h:1/x")


@pytest.mark.parametrize("address", INVALID_ADDRESSES)
def test_an_invalid_address_is_an_error(folder: Path, address: str) -> None:
    message = run_and_fail("grade", folder, "--executor", address)
    assert message.startswith("qdot: ") and repr(address) in message and "tcp://" in message
    assert not (folder / "graded" / "results.jsonl").exists()


def test_a_scheduler_that_does_not_answer_is_an_error(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "SCHEDULER_TIMEOUT", 0.5)
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{unused.getsockname()[1]}"
        result = grade(folder, address)
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert address in result.stderr
    monkeypatch.setitem(sys.modules, "distributed", None)  # pretend that Dask is not installed
    result = grade(folder, address)
    assert (result.exit_code, result.stderr) == (2, f"qdot: {explain_missing('cluster', '--executor')}\n")
