"""Interrupted runs lose nothing: whatever ends `qdot grade`, a rerun continues and writes the same reports.

The interruptions are real: SIGKILL for the process group at random moments, killed workers, a file-size limit in place
of a full disk, a lock held by another process. Runs that are ended are separate processes; the others run in this one.
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

from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.common.json_form import parse_dataclass
from qdot.grader.cli.main import app
from qdot.grader.grading.attempt import Grader, grade_attempt, read_attempts
from qdot.grader.grading.batch import grade_class
from qdot.grader.grading.copied_answers import ClassAnswers
from qdot.grader.grading.result import Result
from qdot.grader.reports.grades_table import find_work_status
from qdot.grader.sandbox.sandbox import Limits, Run, Sandbox
from qdot.grader.submissions.submission import StudentFiles, find_submissions
from tests.support.problems import CrashingAssignment
from tests.support.results import index_by_student
from tests.support.submitting import answer_notebook, find_stored_marks, release_class, submit
from tests.support.suites import select_for_suite

TOML = """title = "T"
key = "hw"
[[problem]]
family = "planar-2r"
questions = ["position"]
"""
STUDENTS = [f"s{i:02d}" for i in range(8)]
TRUNCATED_MESSAGE = "s03: hw.ipynb is not a Jupyter notebook, or it is incomplete (an error in line 7 of the file)\n"
"""The messages of an undisturbed run."""
REPORTS = ("results.jsonl", "grades.csv")


@pytest.fixture(scope="module")
def submitted_class(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a class of eight: most are right, some are wrong, one is truncated, one is missing."""
    assignment = release_class(tmp_path_factory.mktemp("class") / "hw", list(map(Student, STUDENTS)), TOML)
    for number, student in enumerate(STUDENTS[:-1]):
        text = answer_notebook(assignment, student, lambda code, _: "a1" if number % 4 == 1 else code)  # noqa: B023
        path = submit(assignment, f"{student}/hw.ipynb", text[:500] if student == "s03" else text)
        os.utime(path, (1_700_000_000, 1_700_000_000))
    return assignment.folder


def make_command(folder: Path, jobs: int = 2) -> list[str]:
    return [sys.executable, "-m", "qdot", "grade", str(folder), "--jobs", str(jobs)]


def start_run(folder: Path, jobs: int = 2) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        make_command(folder, jobs), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def finish_run(folder: Path, code: int = 0) -> str:
    result = CliRunner().invoke(app, ["grade", str(folder), "--jobs", "1"])
    assert result.exit_code == code, result.stderr
    return result.stderr


def read_reports(folder: Path) -> dict[str, bytes]:
    graded = folder / "graded"
    return {name: (graded / name).read_bytes() for name in REPORTS} | {
        path.name: path.read_bytes() for path in (graded / "feedback").iterdir()
    }


@pytest.fixture(scope="module")
def graded_once(submitted_class: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = copy_folder(submitted_class, tmp_path_factory.mktemp("undisturbed") / "hw")
    assert finish_run(folder) == TRUNCATED_MESSAGE
    return folder


@pytest.fixture(scope="module")
def undisturbed(graded_once: Path) -> dict[str, bytes]:
    reports = read_reports(graded_once)
    assert len(reports) == len(STUDENTS) + len(REPORTS)
    return reports


def copy_folder(source: Path, target: Path) -> Path:
    return Path(shutil.copytree(source, target))  # with the times of the files


@pytest.fixture
def folder(submitted_class: Path, tmp_path: Path) -> Path:
    return copy_folder(submitted_class, tmp_path / "hw")


# --- what must hold at any moment ---


def assert_files_complete(folder: Path) -> None:
    graded = folder / "graded"
    for path in find_stored_marks(folder):
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


def assert_finished(folder: Path, undisturbed: dict[str, bytes]) -> None:
    assert_files_complete(folder)
    assert read_reports(folder) == undisturbed
    assert len(find_stored_marks(folder)) == len(STUDENTS)
    assert not list((folder / "graded").rglob("*.tmp"))


def count_files(folder: Path) -> int:
    return sum(1 for path in (folder / "graded").rglob("*") if path.is_file())


def wait_for_files(moment: float, files: int, folder: Path, process: "subprocess.Popen[str]") -> None:
    """Wait until a run has written a number of files, and then some time more."""
    before, deadline = count_files(folder), time.monotonic() + 60
    while process.poll() is None and count_files(folder) < before + files and time.monotonic() < deadline:
        time.sleep(0.003)
    time.sleep(moment)


def choose_moment(rng: random.Random) -> tuple[float, int]:
    """Choose when to interrupt a run: sometimes at any time since its start, mostly while it writes."""
    return (rng.uniform(0.0, 2.0), 0) if rng.random() < 0.2 else (rng.uniform(0.0, 0.05), rng.randint(1, 5))


def kill_run(process: "subprocess.Popen[str]") -> bool:
    at_work = process.poll() is None
    if at_work:
        os.killpg(process.pid, signal.SIGKILL)
    process.communicate(timeout=60)
    return at_work


# --- kill -9, many times ---


@pytest.mark.parametrize(("seed", "is_graded_before"), select_for_suite([(3, True)], [(0, False), (3, True)]))
def test_repeated_kills_lose_nothing(
    folder: Path, undisturbed: dict[str, bytes], graded_once: Path, seed: int, is_graded_before: bool
) -> None:
    """If everything was graded before, the kill interrupts the writing of reports."""

    def begin() -> None:
        shutil.rmtree(folder / "graded", ignore_errors=True)
        if is_graded_before:
            copy_folder(graded_once / "graded" / ".cache", folder / "graded" / ".cache")

    rng, kills = random.Random(seed), 0
    begin()
    while kills < select_for_suite(1, 7):
        before, process = find_stored_marks(folder), start_run(folder, select_for_suite(1, rng.choice((1, 1, 2))))
        wait_for_files(*choose_moment(rng), folder, process)
        kills += kill_run(process)
        assert_files_complete(folder)
        assert before.items() <= find_stored_marks(folder).items(), "a submission was graded twice"
        if process.returncode == 0:
            assert_finished(folder, undisturbed)
            begin()
    before = find_stored_marks(folder)
    finish_run(folder)
    assert before.items() <= find_stored_marks(folder).items(), "a submission was graded twice"
    assert_finished(folder, undisturbed)


# --- workers that die ---


@pytest.mark.whole
def test_a_student_who_ends_every_process_is_ungraded(folder: Path, undisturbed: dict[str, bytes]) -> None:
    loaded = load_assignment(folder)
    values = {field.name: getattr(loaded, field.name) for field in fields(loaded)}
    assignment = CrashingAssignment(**values, victim="s05", times=9)
    shutil.rmtree(folder / ".qdot")  # stored problems would not be loaded again
    submissions = find_submissions(assignment, folder / "submitted").by_student
    results = index_by_student(grade_class(assignment, submissions, 2, Limits(), lambda _: None))
    assert 3 <= len(list(folder.glob("died.*"))) <= 9  # a pool may die more than once where the student before is slow
    lost = results.pop("s05")
    assert find_work_status(lost) == "ungraded"
    assert (lost.score, lost.max_score) == (0, 1)
    assert "the system ended its process twice" in (lost.obstacle or "")
    expected = [parse_dataclass(Result, line) for line in undisturbed["results.jsonl"].splitlines()]
    assert list(results.values()) == [result for result in expected if result.student != "s05"]
    assert finish_run(folder) == TRUNCATED_MESSAGE  # the failure is not stored: the next run tries again
    assert_finished(folder, undisturbed)


class LosingSandbox(Sandbox):
    """A sandbox whose process is lost in some runs, as if killed for lack of memory."""

    def __init__(self, *ends: str) -> None:
        super().__init__()
        self.ends: Iterator[str] = iter(ends)

    def run(self, *_: object) -> Run:
        return Run(end=next(self.ends))


@pytest.mark.parametrize(
    ("ends", "is_blamed"),
    [
        ("lost done", False), ("lost lost done", True), ("not-started not-started not-started done", False),
        ("not-started lost not-started lost done", True),
    ],
)  # fmt: skip
def test_a_notebook_is_blamed_only_if_its_process_is_lost_twice(
    submitted_class: Path, ends: str, is_blamed: bool
) -> None:
    assignment = load_assignment(submitted_class)

    def make_grader(sandbox: Any) -> Grader:
        return Grader(assignment, sandbox, ClassAnswers(assignment))

    attempt = read_attempts(StudentFiles((submitted_class / "submitted" / "s00" / "hw.ipynb",)), "hw")[0]
    marked = grade_attempt(make_grader(LosingSandbox(*ends.split())), "s00", attempt)
    assert marked.is_graded
    assert ("killed" in "".join(marked.notes), bool(marked.notes)) == (is_blamed, is_blamed)
    for end in ("lost", "not-started"):
        with pytest.raises(RuntimeError, match="ends by itself"):
            grade_attempt(make_grader(LosingSandbox(*[end] * 9)), "s00", attempt)


# --- disks ---


@pytest.mark.parametrize("blocks", select_for_suite([24], [1, 8, 24]))
@pytest.mark.whole
def test_a_full_disk_is_one_error_and_leaves_no_partial_file(
    folder: Path, undisturbed: dict[str, bytes], blocks: int
) -> None:
    """The file-size limit, in blocks of 512 bytes, is too small for a result or for a page."""
    limited = ["sh", "-c", f'ulimit -f {blocks}; exec "$@"', "sh", *make_command(folder, 1)]
    run = subprocess.run(limited, capture_output=True, text=True, timeout=120)
    assert (run.returncode, run.stdout) == (2, ""), run.stderr
    *warnings, line = run.stderr.splitlines()
    assert all("sandbox" in warning for warning in warnings)  # the limit affects the sandbox, too
    assert line.startswith(f"qdot: {folder / 'graded'}") and line.endswith("File too large")
    assert_files_complete(folder)
    assert not list((folder / "graded").rglob("*.tmp"))
    before = find_stored_marks(folder)
    assert before or blocks < 8
    finish_run(folder)
    assert before.items() <= find_stored_marks(folder).items()
    assert_finished(folder, undisturbed)


def test_files_damaged_by_a_power_failure_are_rewritten(
    folder: Path, undisturbed: dict[str, bytes], graded_once: Path
) -> None:
    copy_folder(graded_once / "graded", folder / "graded")
    paths = sorted(find_stored_marks(folder))
    for path, content in zip(paths, (b"", b"\0" * 4096, b'{"key": "', b"[]", b"\xff", b"null", b"{}"), strict=False):
        path.write_bytes(content)
    emptied, torn, hollow = (folder / "graded" / "feedback" / f"s0{n}.html" for n in range(3))
    emptied.write_bytes(b"")
    torn.write_bytes(torn.read_bytes()[:-4096])
    hollow.write_bytes(hollow.read_bytes()[:-4096] + bytes(4096))
    finish_run(folder)
    assert_finished(folder, undisturbed)


def test_a_second_grader_reports_the_lock_and_ends(folder: Path, graded_once: Path) -> None:
    copy_folder(graded_once / "graded", folder / "graded")
    with (folder / "graded" / ".cache" / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        before = {path: path.stat().st_mtime_ns for path in (folder / "graded").rglob("*")}
        err = finish_run(folder, code=2)
        assert f"{folder / 'graded'};" in err and "another 'qdot grade'" in err and err.count("\n") == 1
        assert before == {path: path.stat().st_mtime_ns for path in (folder / "graded").rglob("*")}
