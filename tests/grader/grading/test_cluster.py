"""A class graded by executors: threads, processes, and a real Dask cluster whose workers die; always the same bytes.

The scheduler gives a task up at the first worker that dies over it, so that this is met, too.
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

from qdot.exercises.assignment.assignment import Assignment, load_assignment
from qdot.exercises.assignment.release import init_assignment, release_notebooks
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import explain_missing
from qdot.exercises.common.files import write_atomically
from qdot.exercises.problem.problem import Part
from qdot.grader.cli.demo import fill_in_answers
from qdot.grader.cli.main import app
from qdot.grader.grading import batch, cluster
from qdot.grader.grading.batch import grade_class
from qdot.grader.grading.result import NotebookMarks
from qdot.grader.reports.tables import make_grades_csv, make_results_jsonl
from qdot.grader.sandbox import guarantees
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import Submission, find_submissions
from tests.support import ROOT
from tests.support.command import run_and_fail
from tests.support.submitting import UNCERTIFIED

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
LIMITS = Limits(seconds=60.0, cell_seconds=30.0)  # as --seconds 60 makes them
DEADLY = "import os\nos.kill(os.getppid(), 9)\n"


@pytest.fixture(scope="module")
def handed_in(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A class of nine: right, wrong, hostile, cut off, missing, and claims that nothing could send."""
    folder = tmp_path_factory.mktemp("class") / "hw"
    init_assignment(folder, "T", "hw", secret="0123456789abcdef")
    (folder / "assignment.toml").write_text(TOML)
    (folder / "roster.csv").write_text("student,name\n" + "".join(f"{student},N\n" for student in STUDENTS))
    assignment = load_assignment(folder)
    release_notebooks(assignment, UNCERTIFIED, 1, lambda _: None)
    written = {"s1": "a1 + theta1", "s2": f"exec({DEADLY!r})", "s3": "__import__('os')._exit(0)"}
    for student in STUDENTS[:-1]:
        text = (folder / "released" / student / "hw.ipynb").read_text()

        def edit(code: str, part: Part, instead: str = written.get(student, "")) -> str:
            return instead if instead and part.name == "determinant" else code

        path = folder / "submitted" / student / "hw.ipynb"
        path.parent.mkdir(parents=True)
        path.write_text(fill_in_answers(text, assignment.generate_problems(student), edit))
        os.utime(path, (1_700_000_000, 1_700_000_000))
    path = folder / "submitted" / "s4" / "hw.ipynb"
    path.write_text(path.read_text()[:500])
    path = folder / "submitted" / "s5" / "hw.ipynb"
    notebook = json.loads(path.read_text())
    notebook["metadata"]["qdot"]["digest"] = json.loads("[" * 300 + "]" * 300)
    path.write_text(json.dumps(notebook))
    return folder


def graded(folder: Path, executor: str = "", each: Callable[[int], None] = lambda _: None) -> dict[str, bytes]:
    """Grade a class and return what is stored and the tables, byte for byte; `each` is told how many are done.

    No feedback pages are written, which are made of these and take longest.
    """
    assignment, done = load_assignment(folder), []

    def count(_: object) -> None:
        done.append(1)
        each(len(done))

    found = find_submissions(assignment, folder / "submitted").by_student
    results = grade_class(assignment, found, 1, LIMITS, count, executor=executor)
    write_atomically(folder / "graded" / "results.jsonl", make_results_jsonl(results))
    write_atomically(folder / "graded" / "grades.csv", make_grades_csv(results, assignment.roster))
    return reports(folder)


def reports(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in (folder / "graded").rglob("*")
        if path.is_file() and path.name not in ("lock", "costs.csv")
    }


def kept_in(folder: Path) -> dict[Path, int]:
    """Return what has been graded, and when."""
    return {path: path.stat().st_mtime_ns for path in (folder / "graded" / ".cache").glob("[!.]*.json")}


@pytest.fixture(scope="module")
def undisturbed(handed_in: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """What a run on this machine gives."""
    made = graded(Path(shutil.copytree(handed_in, tmp_path_factory.mktemp("local") / "hw")))
    assert len(made) == len(STUDENTS) + 2
    results = [json.loads(line) for line in made["graded/results.jsonl"].decode().splitlines()]
    scores = {result["student"]: result["score"] for result in results}
    assert scores == {**dict.fromkeys(STUDENTS, 2), **dict.fromkeys(("s1", "s2", "s3"), 1), "s4": 0, "s8": 0}
    return made


@pytest.fixture
def folder(handed_in: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(handed_in, tmp_path / "hw"))


# --- workers of ours ---


class KilledWorker(Exception):
    """Called as Dask's."""


class Dying:
    """A client of one worker in this process, which dies over a student so many times."""

    def __init__(self, victim: str, times: int) -> None:
        self.victim, self.times, self.threads = victim, times, 1

    def nthreads(self) -> dict[str, int]:
        return {"here": 1}

    def submit(self, work: Callable[..., Any], *given: Any, pure: bool) -> "Future[Any]":
        future: Future[Any] = Future()
        arguments = [each.result() if isinstance(each, Future) else each for each in given]
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
def dying(monkeypatch: pytest.MonkeyPatch, victim: str = "", times: int = 0) -> Iterator[None]:
    @contextmanager
    def connect(address: str, assignment: Assignment, limits: Limits) -> Iterator[cluster.Cluster]:
        yield cluster.Cluster(cast(Any, Dying(victim, times)), address, cluster.make_brief(assignment, limits))

    monkeypatch.setattr(batch, "connect", connect)
    yield
    cluster.drop_assignment()


def test_a_student_who_ends_workers_twice_is_ungraded_and_once_is_not(
    folder: Path, undisturbed: dict[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    with dying(monkeypatch, "s0", 2):
        made = graded(folder, "tcp://here:1")
    lines = made["graded/results.jsonl"].decode().splitlines()
    assert "the system ended its process twice" in json.loads(lines[0])["obstacle"]
    assert lines[1:] == undisturbed["graded/results.jsonl"].decode().splitlines()[1:]
    assert len(list((folder / "graded" / ".cache").glob("[!.]*.json"))) == len(STUDENTS) - 1
    with dying(monkeypatch, "s0", 1):
        assert graded(folder, "tcp://here:1") == undisturbed
    assert not cluster._worker_state


def test_a_strict_sandbox_is_demanded_of_every_worker(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "assignment.toml").write_text('sandbox = "strict"\n' + TOML)
    probe = guarantees.probe
    monkeypatch.setattr(guarantees, "probe", lambda quick: probe(quick=True))
    monkeypatch.setattr(guarantees.Findings, "is_strict", False)
    with dying(monkeypatch), pytest.raises(QdotError, match=r"worker .*strict"):
        graded(folder, "tcp://here:1")


def test_a_worker_forgets_the_assignment_when_it_is_idle(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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
def started(*arguments: str, cwd: Path, pythonpath: Path = ROOT) -> Iterator["subprocess.Popen[bytes]"]:
    """Run one of Dask's programs; in the end, nothing of it is left."""
    dasks = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0", "TMPDIR": str(cwd)}
    environment = {**os.environ, "PYTHONPATH": str(pythonpath), **dasks}
    command = [sys.executable, "-m", *arguments]
    with (cwd / "log").open("ab") as log:
        process = subprocess.Popen(command, cwd=cwd, env=environment, stdout=log, stderr=log, start_new_session=True)
    try:
        yield process
    finally:
        below = children(process.pid)
        process.terminate()
        process.wait(60)
        assert not psutil.wait_procs(below, 30)[1], "it left something running"


def children(pid: int) -> list[psutil.Process]:
    try:
        found: list[psutil.Process] = psutil.Process(pid).children(recursive=True)
    except psutil.NoSuchProcess:
        return []
    return found


@contextmanager
def scheduler(place: Path) -> Iterator[str]:
    file = place / "scheduler.json"
    where = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file))
    with started("distributed.cli.dask_scheduler", *where, cwd=place):
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline:
            if file.exists() and (text := file.read_text()).endswith("}"):
                yield json.loads(text)["address"]
                return
            time.sleep(0.05)
        raise AssertionError((place / "log").read_text())


@contextmanager
def worker(address: str, place: Path, pythonpath: Path = ROOT) -> Iterator["subprocess.Popen[bytes]"]:
    """Run a worker, in a folder of its own."""
    place.mkdir()
    which = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--memory-limit", "0", "--host", "127.0.0.1")
    with started("distributed.cli.dask_worker", address, *which, cwd=place, pythonpath=pythonpath) as process:
        deadline = time.monotonic() + 60
        while "Registered to" not in (place / "log").read_text():
            assert time.monotonic() < deadline and process.poll() is None, (place / "log").read_text()
            time.sleep(0.05)
        yield process


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A scheduler with two workers."""
    place = tmp_path_factory.mktemp("cluster")
    with scheduler(place) as at, worker(at, place / "one"), worker(at, place / "two"):
        yield at
    assert not list(place.rglob("qdot-*")), "a sandbox left its folder"


def grade(folder: Path, address: str, *options: str) -> Result:
    return CliRunner().invoke(app, ["grade", str(folder), "--executor", address, *OPTIONS, *options])


@pytest.mark.integration
def test_a_cluster_gives_what_a_run_on_one_process_gives(
    folder: Path, address: str, handed_in: Path, undisturbed: dict[str, bytes], tmp_path: Path
) -> None:
    result = grade(folder, address)
    counts = f"{len(STUDENTS)} students: 7 graded, 1 unusable, 1 missing"
    assert (result.exit_code, result.stdout.split(";")[0]) == (0, counts)
    assert "Traceback" not in result.stderr and "distributed" not in result.stderr
    assert {name: made for name, made in reports(folder).items() if "feedback" not in name} == undisturbed
    local = Path(shutil.copytree(handed_in, tmp_path / "local"))
    on_one = CliRunner().invoke(app, ["grade", str(local), *OPTIONS])
    assert on_one.stdout.replace(str(local), str(folder)) == result.stdout
    assert reports(local) == reports(folder)


@pytest.mark.integration
def test_a_worker_that_is_killed_in_the_middle_costs_nobody_anything(
    folder: Path, address: str, undisturbed: dict[str, bytes], tmp_path: Path
) -> None:
    shutil.rmtree(folder / ".qdot")  # the problems that were kept
    with worker(address, tmp_path / "third") as third:
        below: list[psutil.Process] = []

        def kill(done: int) -> None:
            if done == 2:
                below.extend(children(third.pid))
                third.send_signal(signal.SIGKILL)

        assert graded(folder, address, kill) == undisturbed
        assert third.wait(10) == -signal.SIGKILL
        assert not psutil.wait_procs(below, 30)[1], "the dead worker's sandbox is still there"


@pytest.mark.integration
def test_a_worker_with_other_code_grades_nothing(folder: Path, address: str, tmp_path: Path) -> None:
    other = tmp_path / "other"
    for source, target in (("qdot", "qdot"), ("templates", "qdot/templates")):  # as in a wheel
        shutil.copytree(ROOT / source, other / target, ignore=shutil.ignore_patterns("__pycache__"))
    with (other / "qdot" / "grader" / "judging" / "judge.py").open("a") as file:
        file.write("# changed\n")
    with worker(address, tmp_path / "third", other):
        result = grade(folder, address)
    (line,) = result.stderr.splitlines()
    assert result.exit_code == 2
    assert line.startswith("qdot: worker ") and "install the same qdot" in line


@pytest.mark.integration
def test_workers_that_are_not_there_or_go_away_are_told_and_what_was_graded_is_kept(
    folder: Path, undisturbed: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "FIRST_WORKER_TIMEOUT", 0.3)
    monkeypatch.setattr(cluster, "WORKER_RETURN_TIMEOUT", 0.3)
    with scheduler(tmp_path) as at:
        result = grade(folder, at)
        assert result.exit_code == 2
        assert f"dask worker {at} " in result.stderr and result.stderr.count("\n") == 1
        gone = f"all workers of {at} have left"
        killed, try_to_mark = threading.Event(), cluster.Cluster._try_to_mark
        first_student = load_assignment(folder).roster[0].id

        def wait_for_kill(self: cluster.Cluster, student: str, submission: Submission | None) -> NotebookMarks | None:
            """The worker must not have graded all notebooks when it is killed."""
            if student != first_student:
                killed.wait(60)
            return try_to_mark(self, student, submission)

        monkeypatch.setattr(cluster.Cluster, "_try_to_mark", wait_for_kill)
        with worker(at, tmp_path / "only") as only, pytest.raises(QdotError, match=gone):

            def kill(_: int) -> None:
                only.send_signal(signal.SIGKILL)
                killed.set()

            graded(folder, at, kill)
    kept = kept_in(folder)
    assert kept
    assert graded(folder) == undisturbed
    assert kept_in(folder).items() >= kept.items()


NO_ADDRESSES = ("banana", "127.0.0.1:8786", "tcp://", "tcp://host", "http://h:1", "tcp://h:1/x")


@pytest.mark.parametrize("address", NO_ADDRESSES)
def test_what_is_no_address_is_told_in_one_line(folder: Path, address: str) -> None:
    message = run_and_fail("grade", folder, "--executor", address)
    assert message.startswith("qdot: ") and repr(address) in message and "tcp://" in message
    assert not (folder / "graded" / "results.jsonl").exists()


def test_where_no_scheduler_answers_is_told(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "SCHEDULER_TIMEOUT", 0.5)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        at = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
        result = grade(folder, at)
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert at in result.stderr
    monkeypatch.setitem(sys.modules, "distributed", None)  # without Dask, it is said how to get it
    result = grade(folder, at)
    assert (result.exit_code, result.stderr) == (2, f"qdot: {explain_missing('cluster', '--executor')}\n")
