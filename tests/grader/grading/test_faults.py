"""Nothing is lost: whatever ends `qdot grade`, and whenever, a rerun goes on and gives what an undisturbed run gives.

The faults are real: SIGKILL for the whole process group at drawn moments, workers that are killed, a limit on the size
of files as a disk that is full, a lock that another process holds. A run that is to be ended is a process of its own;
one that goes on after it, or only says what is wrong, is run in this process.
"""

import csv
import fcntl
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from qdot.exercises.assignment.assignment import Assignment, load_assignment
from qdot.exercises.assignment.release import init_assignment, release_notebooks
from qdot.exercises.common.json_form import from_json
from qdot.grader.cli.demo import fill_in_answers
from qdot.grader.cli.main import app
from qdot.grader.grading.attempt import Grader, grade_attempt, read_attempts
from qdot.grader.grading.batch import grade_class
from qdot.grader.grading.copied_answers import ClassAnswers
from qdot.grader.grading.result import Result
from qdot.grader.reports.tables import find_work_status
from qdot.grader.sandbox.sandbox import Limits, Run, Sandbox
from qdot.grader.submissions.submission import StudentFiles, find_submissions
from tests.support.problems import CrashingAssignment
from tests.support.results import index_by_student
from tests.support.submitting import UNCERTIFIED
from tests.support.suites import select_for_suite

TOML = """title = "T"
key = "hw"
[[problem]]
family = "planar-2r"
questions = ["position"]
"""
STUDENTS = [f"s{i:02d}" for i in range(8)]
CUT_OFF = "s03: hw.ipynb is not a Jupyter notebook, or it is incomplete (line 7)\n"
"""What an undisturbed run says on standard error."""
REPORTS = ("results.jsonl", "grades.csv")


@pytest.fixture(scope="module")
def handed_in(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A class of eight: most are right, some are wrong, one is cut off, one is missing."""
    folder = tmp_path_factory.mktemp("class") / "hw"
    init_assignment(folder, "T", "hw", secret="0123456789abcdef")
    (folder / "assignment.toml").write_text(TOML)
    (folder / "roster.csv").write_text("student\n" + "".join(f"{student}\n" for student in STUDENTS))
    assignment = load_assignment(folder)
    release_notebooks(assignment, UNCERTIFIED, 1, lambda _: None)
    for number, student in enumerate(STUDENTS[:-1]):
        hand_in(folder, assignment, student, "a1" if number % 4 == 1 else "")
    path = folder / "submitted" / "s03" / "hw.ipynb"
    path.write_text(path.read_text()[:500])
    return folder


def hand_in(folder: Path, assignment: Assignment, student: str, answer: str = "") -> None:
    text = (assignment.folder / "released" / student / "hw.ipynb").read_text()
    path = folder / "submitted" / student / "hw.ipynb"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(fill_in_answers(text, assignment.generate_problems(student), lambda code, _: answer or code))
    os.utime(path, (1_700_000_000, 1_700_000_000))


def command(folder: Path, jobs: int = 2) -> list[str]:
    return [sys.executable, "-m", "qdot", "grade", str(folder), "--jobs", str(jobs)]


def started(folder: Path, jobs: int = 2) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        command(folder, jobs), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def finish(folder: Path, code: int = 0) -> str:
    """Run the command to its end, and return what it says on standard error."""
    result = CliRunner().invoke(app, ["grade", str(folder), "--jobs", "1"])
    assert result.exit_code == code, result.stderr
    return result.stderr


def reports(folder: Path) -> dict[str, bytes]:
    """Return what an instructor gets, byte for byte."""
    graded = folder / "graded"
    return {name: (graded / name).read_bytes() for name in REPORTS} | {
        path.name: path.read_bytes() for path in (graded / "feedback").iterdir()
    }


@pytest.fixture(scope="module")
def graded_once(handed_in: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The class graded by a run that nobody disturbed."""
    folder = copied(handed_in, tmp_path_factory.mktemp("undisturbed") / "hw")
    assert finish(folder) == CUT_OFF
    return folder


@pytest.fixture(scope="module")
def undisturbed(graded_once: Path) -> dict[str, bytes]:
    found = reports(graded_once)
    assert len(found) == len(STUDENTS) + len(REPORTS)
    return found


def copied(source: Path, target: Path) -> Path:
    return Path(shutil.copytree(source, target))  # with the times of the files


@pytest.fixture
def folder(handed_in: Path, tmp_path: Path) -> Path:
    return copied(handed_in, tmp_path / "hw")


# --- what must hold at any moment ---


def kept(folder: Path) -> dict[Path, int]:
    """Return what has been graded, and when."""
    return {path: path.stat().st_mtime_ns for path in (folder / "graded" / ".cache").glob("[!.]*.json")}


def check_whole(folder: Path) -> None:
    """No file that has its name holds half of what it should."""
    graded = folder / "graded"
    for path in kept(folder):
        assert set(json.loads(path.read_text())) == {"key", "marked"}
    if (graded / "results.jsonl").exists():
        text = (graded / "results.jsonl").read_text()
        assert text.endswith("\n")
        assert [json.loads(line)["student"] for line in text.splitlines()] == STUDENTS
    if (graded / "grades.csv").exists():
        rows = list(csv.DictReader((graded / "grades.csv").read_text().splitlines()))
        assert [row["student"] for row in rows] == STUDENTS
    for path in (graded / "feedback").glob("[!.]*"):
        assert path.read_text().endswith("</html>\n")


def check_done(folder: Path, undisturbed: dict[str, bytes]) -> None:
    check_whole(folder)
    assert reports(folder) == undisturbed
    assert len(kept(folder)) == len(STUDENTS)
    assert not list((folder / "graded").rglob("*.tmp"))


def written(folder: Path) -> int:
    return sum(1 for path in (folder / "graded").rglob("*") if path.is_file())


def wait_for(moment: float, files: int, folder: Path, process: "subprocess.Popen[str]") -> None:
    """Wait until a run has written so many more files, and then for some seconds."""
    before, deadline = written(folder), time.monotonic() + 60
    while process.poll() is None and written(folder) < before + files and time.monotonic() < deadline:
        time.sleep(0.003)
    time.sleep(moment)


def drawn(rng: random.Random) -> tuple[float, int]:
    """Return when a run is to be disturbed: at times any time since its start, mostly when it is writing."""
    return (rng.uniform(0.0, 2.0), 0) if rng.random() < 0.2 else (rng.uniform(0.0, 0.05), rng.randint(1, 5))


def kill(process: "subprocess.Popen[str]") -> bool:
    """Kill a run with everything that it started; tell whether it was still at work."""
    at_work = process.poll() is None
    if at_work:
        os.killpg(process.pid, signal.SIGKILL)
    process.communicate(timeout=60)
    return at_work


# --- kill -9, many times ---


@pytest.mark.parametrize(
    ("seed", "is_graded_before"), select_for_suite([(3, True)], [(0, False), (1, False), (2, True), (3, True)])
)
def test_a_grader_that_is_killed_again_and_again_loses_nothing(
    folder: Path, undisturbed: dict[str, bytes], graded_once: Path, seed: int, is_graded_before: bool
) -> None:
    """Where all is graded before, what is killed is the writing of reports."""

    def begin() -> None:
        shutil.rmtree(folder / "graded", ignore_errors=True)
        if is_graded_before:
            copied(graded_once / "graded" / ".cache", folder / "graded" / ".cache")

    rng, kills = random.Random(seed), 0
    begin()
    while kills < select_for_suite(1, 7):
        before, process = kept(folder), started(folder, select_for_suite(1, rng.choice((1, 1, 2))))
        wait_for(*drawn(rng), folder, process)
        kills += kill(process)
        check_whole(folder)
        assert before.items() <= kept(folder).items(), "a submission was graded twice"
        if process.returncode == 0:
            check_done(folder, undisturbed)
            begin()
    before = kept(folder)
    finish(folder)
    assert before.items() <= kept(folder).items(), "a submission was graded twice"
    check_done(folder, undisturbed)


# --- workers that die ---


AROUND = select_for_suite(slice(4, 7), slice(None))
"""The students who are graded with s05."""


def graded(folder: Path, times: int) -> dict[str, Result]:
    """Grade with a student, s05, who ends so many processes that come to the student's problems."""
    made = load_assignment(folder)
    own = {field.name: getattr(made, field.name) for field in fields(made)}
    assignment = CrashingAssignment(**own, victim="s05", times=times)
    shutil.rmtree(folder / ".qdot")  # where problems are kept, nobody comes to them
    found = find_submissions(assignment, folder / "submitted").by_student
    results = grade_class(assignment, found, 2, Limits(), lambda _: None, assignment.roster[AROUND])
    died = len(list(folder.glob("died.*")))
    assert min(times, 3) <= died <= times  # a pool may die more than once where the student before is slow
    return index_by_student(results)


def around(undisturbed: dict[str, bytes]) -> dict[str, Result]:
    results = [from_json(Result, line) for line in undisturbed["results.jsonl"].splitlines()]
    return index_by_student(results[AROUND])


@pytest.mark.whole
def test_who_ends_every_process_is_ungraded_and_the_others_are_not(folder: Path, undisturbed: dict[str, bytes]) -> None:
    expected = around(undisturbed)
    results = graded(folder, 9)
    lost = results.pop("s05")
    assert find_work_status(lost) == "ungraded"
    assert (lost.score, lost.max_score) == (0, 1)
    assert "the system ended its process twice" in (lost.obstacle or "")
    assert results == {student: result for student, result in expected.items() if student != "s05"}
    assert finish(folder) == CUT_OFF  # it is no mark, and not kept: the next run tries again
    check_done(folder, undisturbed)


@pytest.mark.whole  # as one who ends every process, without the end
def test_who_ends_a_process_once_is_graded(folder: Path, undisturbed: dict[str, bytes]) -> None:
    assert graded(folder, 2) == around(undisturbed)


class LosingSandbox(Sandbox):
    """A sandbox whose process is lost in some runs, as by the system's out-of-memory killer."""

    def __init__(self, *ends: str) -> None:
        super().__init__()
        self.ends: Iterator[str] = iter(ends)

    def run(self, *_: object) -> Run:
        return Run(end=next(self.ends))


@pytest.mark.parametrize(
    ("ends", "is_told"),
    [
        ("lost done", False), ("lost lost done", True), ("unbegun unbegun unbegun done", False),
        ("unbegun lost unbegun lost done", True),
    ],
)  # fmt: skip
def test_a_notebook_answers_for_its_process_only_if_it_is_lost_twice(handed_in: Path, ends: str, is_told: bool) -> None:
    assignment = load_assignment(handed_in)

    def grader(sandbox: Any) -> Grader:
        return Grader(assignment, sandbox, ClassAnswers(assignment))

    attempt = read_attempts(StudentFiles((handed_in / "submitted" / "s00" / "hw.ipynb",)), "hw")[0]
    marked = grade_attempt(grader(LosingSandbox(*ends.split())), "s00", attempt)
    assert marked.is_graded
    assert ("killed" in "".join(marked.notes), bool(marked.notes)) == (is_told, is_told)
    for always in ("lost", "unbegun"):
        with pytest.raises(RuntimeError, match="ends by itself"):
            grade_attempt(grader(LosingSandbox(*[always] * 9)), "s00", attempt)


# --- disks ---


@pytest.mark.parametrize("blocks", select_for_suite([24], [1, 8, 24]))
@pytest.mark.whole
def test_a_file_that_cannot_be_written_whole_is_one_message(
    folder: Path, undisturbed: dict[str, bytes], blocks: int
) -> None:
    """Blocks of 512 bytes: too few for a result, for a page."""
    limited = ["sh", "-c", f'ulimit -f {blocks}; exec "$@"', "sh", *command(folder, 1)]
    done = subprocess.run(limited, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    *others, line = done.stderr.splitlines()
    assert all("sandbox" in other for other in others)  # such a limit is one on what contains notebooks, too
    assert line.startswith(f"qdot: {folder / 'graded'}") and line.endswith("File too large")
    check_whole(folder)
    assert not list((folder / "graded").rglob("*.tmp"))
    before = kept(folder)
    assert before or blocks < 8
    finish(folder)
    assert before.items() <= kept(folder).items()
    check_done(folder, undisturbed)


def test_files_that_a_loss_of_power_emptied_or_tore_are_graded_again(
    folder: Path, undisturbed: dict[str, bytes], graded_once: Path
) -> None:
    copied(graded_once / "graded", folder / "graded")
    paths = sorted(kept(folder))
    for path, content in zip(paths, (b"", b"\0" * 4096, b'{"key": "', b"[]", b"\xff", b"null", b"{}"), strict=False):
        path.write_bytes(content)
    emptied, torn, hollow = (folder / "graded" / "feedback" / f"s0{n}.html" for n in range(3))
    emptied.write_bytes(b"")
    torn.write_bytes(torn.read_bytes()[:-4096])
    hollow.write_bytes(hollow.read_bytes()[:-4096] + bytes(4096))
    finish(folder)
    check_done(folder, undisturbed)


def test_a_second_grader_says_so_and_leaves(folder: Path, graded_once: Path) -> None:
    copied(graded_once / "graded", folder / "graded")
    with (folder / "graded" / ".cache" / "lock").open("w") as lock:  # whatever holds it
        fcntl.flock(lock, fcntl.LOCK_EX)
        before = {path: path.stat().st_mtime_ns for path in (folder / "graded").rglob("*")}
        err = finish(folder, code=2)
        assert f"{folder / 'graded'};" in err and "another 'qdot grade'" in err and err.count("\n") == 1
        assert before == {path: path.stat().st_mtime_ns for path in (folder / "graded").rglob("*")}
