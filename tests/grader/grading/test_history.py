"""What earlier runs gave is kept when it is replaced, and `qdot grade --diff` says whose mark moved, and why."""

import json
import tracemalloc
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.json_form import as_json
from qdot.grader.grading import history
from qdot.grader.grading.attempt import GRADER_VERSION
from qdot.grader.grading.history import (
    describe_mark_changes,
    find_mark_changes,
    read_previous_results,
    results_path,
    store_previous_results,
)
from qdot.grader.grading.result import CountingSubmission, Lateness, ProblemResult, Result, SubmittedNotebook
from qdot.grader.reports.tables import make_results_jsonl
from qdot.grader.reports.write import write_reports
from tests.grader.grading.test_final_result import DUE, HOUR, RULE, STUDENTS, TOML, hand_in, released, run
from tests.support.command import run_and_fail
from tests.support.results import change_part, make_part

__all__ = ["released"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    init_assignment(tmp_path / "hw", "T", "hw", STUDENTS, "0123456789abcdef")
    (tmp_path / "hw" / "assignment.toml").write_text(TOML.format(""))
    return tmp_path / "hw"


def kept(folder: Path) -> dict[str, list[dict[str, Any]]]:
    paths = sorted((folder / "graded" / "history").glob("*"))
    return {path.stem: [json.loads(line) for line in path.read_text().splitlines()] for path in paths}


def diff(folder: Path) -> list[str]:
    """What --diff says, without the summary and with single spaces."""
    return [" ".join(line.split()) for line in run(folder, "--diff")[1].splitlines()[:-1]]


@pytest.mark.whole
def test_a_large_class_is_written_in_little_more_memory_than_its_results_take(folder: Path, released: Path) -> None:
    """One result after another: of 100,000, those of the run before would take gigabytes."""
    hand_in(folder, released, "s1/hw.ipynb", -1)
    results, _ = run(folder)
    many = [replace(results["s1"], student=f"s{number}") for number in range(1000)]
    students = tuple(Student(result.student) for result in many)
    assignment = replace(load_assignment(folder), roster=students)
    write_atomically(results_path(assignment), make_results_jsonl(many))
    size = results_path(assignment).stat().st_size
    tracemalloc.start()
    try:
        store_previous_results(assignment, many)
        assert tracemalloc.get_traced_memory()[1] < 3 * size  # all results at once take eight times as much
        tracemalloc.reset_peak()
        assert len(make_results_jsonl(many)) == size
        assert tracemalloc.get_traced_memory()[1] < 3 * size
    finally:
        tracemalloc.stop()
    assert kept(folder) == {}


def test_nobody_loses_a_mark_by_a_run_that_was_given_less(folder: Path, released: Path, tmp_path: Path) -> None:
    """As by a second zip, of latecomers, or by the folder's own after a platform's zip was graded."""
    for student in ("s1", "s2"):
        hand_in(folder, released, f"{student}/hw.ipynb", -1)
    run(folder)
    before = results_path(load_assignment(folder)).read_bytes()
    late = tmp_path / "late"
    (folder / "submitted" / "s2").rename(late)
    with zipfile.ZipFile(tmp_path / "late.zip", "w") as packed:
        packed.write(late / "hw.ipynb", "s2/hw.ipynb")
    for given, missing in ((folder / "submitted", "s2"), (tmp_path / "late.zip", "s1")):
        message = run_and_fail("grade", folder, given)
        assert message.startswith(f"qdot: {given}: submissions of 1 of 3 students") and f" {missing}; " in message
        assert results_path(load_assignment(folder)).read_bytes() == before
    gone, _ = run(folder, "--allow-missing")
    kept_for_staff = [path for path in (folder / "graded").glob("[gr]*.*") if path.is_file()]
    kept_for_staff += (folder / "graded" / "history").glob("*")
    assert len(kept_for_staff) > 2 and {path.stat().st_mode & 0o777 for path in kept_for_staff} == {0o600}
    assert gone["s2"].submission is None and gone["s1"].submission is not None
    run(folder)  # once is enough


def test_marks_are_taken_away_of_a_whole_class_only(folder: Path) -> None:
    assert "--allow-missing applies to a whole class;" in run_and_fail(
        "grade", str(folder), "--allow-missing", "--student=ada"
    )


@pytest.mark.whole
def test_whose_mark_moved_and_why(folder: Path, released: Path) -> None:
    hand_in(folder, released, "s1/hw.ipynb", -1, position="blank")
    hand_in(folder, released, "s2/hw.ipynb", 1)
    first, said = run(folder, "--diff")
    assert said.startswith("there is nothing to compare with, because this is the first run\n")
    assert kept(folder) == {}
    assert diff(folder) == ["no mark has changed since the last run"]
    assert kept(folder) == {}

    hand_in(folder, released, "s1/hw.ipynb", -1)
    hand_in(folder, released, "s3/hw.ipynb", -1, determinant="blank")
    assert diff(folder) == [
        "s1 p1.position 0 → 2 new submission", "s1 total 0.7 → 2.7 new submission",
        "s3 p1.position 0 → 2 new submission", "s3 total 0 → 2 new submission",
        "marks of 2 students changed since the last run; total points 3.4 → 7.4 (+4)",
    ]  # fmt: skip
    (line,) = kept(folder)["s1"]
    assert (line["why"], line["result"]) == ("new submission", as_json(first["s1"]))
    assert set(kept(folder)) == {"s1", "s3"}

    (folder / "assignment.toml").write_text(TOML.format(RULE))
    (folder / "overrides.csv").write_text("student,part,points,comment\ns3,p1.determinant,0.5,on paper\ns1,,1,copied\n")
    assert diff(folder)[:-1] == [
        "s1 total 2.7 → 1 override", "s2 total 2.7 → 2.43 late rule",
        "s3 p1.determinant 0 → 0.5 override", "s3 total 2 → 2.5 override",
    ]  # fmt: skip
    assert [len(lines) for lines in kept(folder).values()] == [2, 1, 2]

    (folder / "overrides.csv").unlink()
    (folder / "assignment.toml").write_text(TOML.format(RULE).replace("[2, 0.7]", "[1, 0.7]"))
    last = folder / "graded" / "results.jsonl"
    last.write_text(last.read_text().replace(f'"grader": {GRADER_VERSION}', '"grader": 0'))
    lines = diff(folder)
    assert "s1 total 1 → 1.7 assignment changed, grader changed, override" in lines
    assert "s2 p1.position 2 → 1 assignment changed, grader changed" in lines
    (folder / "roster.csv").write_text("student\ns1\ns2\ns4\n")
    lines = diff(folder)
    assert "s4 total – → 0 new on the roster" in lines
    assert "s3 total 1 → – no longer on the roster" in lines
    assert kept(folder)["s3"][-1]["why"] == "no longer on the roster"


def result(score: float, **others: Any) -> Result:
    position = make_part("position", "wrong", 2.0, points=score)
    made = Result(
        student="s1", assignment="hw", submission=CountingSubmission("hw.ipynb", "0", DUE.isoformat()), score=score,
        max_score=2.0, late=None, problems=(ProblemResult("planar-2r/1", "p1", (position,)),),
    )  # fmt: skip
    return replace(made, **others)


def line(score: float) -> str:
    return make_results_jsonl([result(score)]).decode()


def why(was: Result, now: Result) -> list[str]:
    return [f"{move.part}: {move.reason}" for move in find_mark_changes({"s1": was}, [now])]


def test_reasons_that_are_rare() -> None:
    two = (SubmittedNotebook("b.ipynb", DUE.isoformat(), None),)
    another = CountingSubmission("b.ipynb", "1", DUE.isoformat())
    later = (DUE + HOUR).isoformat()
    lateness = Lateness(DUE.isoformat(), later, 3600, 0.1, 1.0)
    late = replace(result(1), submission=CountingSubmission("hw.ipynb", "0", later), late=lateness, score=0.9)
    for was, now, expected in (
        (result(1, attempts=two), result(2, submission=another), "another attempt counts"),
        (result(1), result(0, submission=None), "submission missing"),
        (result(1), result(2), "graded again"),
    ):
        assert why(was, now) == [f"p1.position: {expected}", f": {expected}"]
    assert why(result(1), late) == [": received at another time"]
    failed = change_part(result(0), "p1.position", points=None)
    assert find_mark_changes({"s1": failed}, [result(1)])[0].old_points == "ungraded"
    assert describe_mark_changes({"s1": result(1)}, [result(2)]).endswith("1 → 2 (+1)")


def test_a_run_that_was_stopped_adds_nothing_twice(folder: Path) -> None:
    """It was stopped after the history was written, before results.jsonl was."""
    assignment = load_assignment(folder)
    path = history.results_path(assignment)
    path.parent.mkdir()
    path.write_text(line(1))
    for score in (2, 2, 1.5):
        store_previous_results(assignment, [result(score)])
        assert [each["result"]["score"] for each in kept(folder)["s1"]] == [1]
    path.write_text(line(1.5))
    store_previous_results(assignment, [result(1)])
    path.write_text(line(1))
    store_previous_results(assignment, [result(2)])
    assert [each["result"]["score"] for each in kept(folder)["s1"]] == [1, 1.5, 1]


def test_a_file_that_was_touched_is_no_change_unless_it_is_late(folder: Path, released: Path) -> None:
    hand_in(folder, released, "s1/hw.ipynb", -2)
    run(folder)
    hand_in(folder, released, "s1/hw.ipynb", -1)
    assert diff(folder) == ["no mark has changed since the last run"]
    assert kept(folder) == {}
    hand_in(folder, released, "s1/hw.ipynb", 1)
    results, _ = run(folder)
    assert results["s1"].late is not None and results["s1"].late.seconds == 3600
    assert [line["why"] for line in kept(folder)["s1"]] == ["received at another time"]


def test_names_that_no_file_can_hold_are_no_change(folder: Path) -> None:
    odd = result(1, submission=CountingSubmission("\udcff.ipynb", "0", None), obstacle="none", notes=("\u2028",))
    assignment = load_assignment(folder)
    for _ in range(2):
        write_reports(assignment, [odd])
    assert set(read_previous_results(assignment)) == {"s1"}
    assert kept(folder) == {}


def test_what_is_damaged_is_left_out(folder: Path) -> None:
    assignment = load_assignment(folder)
    path = history.results_path(assignment)
    path.parent.mkdir()
    path.write_bytes(b"\xff")
    assert read_previous_results(assignment) == {}
    damaged = '{"student": "s0"\n[]\n{"student": "s2"}\n{"student": "s3", "score": 1, "problems": []}\n'
    path.write_text(f"{damaged}{line(1)}")
    assert set(read_previous_results(assignment)) == {"s1"}
    log = folder / "graded" / "history" / "s1.jsonl"
    log.parent.mkdir()
    log.write_text("half a li")
    store_previous_results(assignment, [result(2)])
    assert [each.startswith("{") for each in log.read_text().splitlines()] == [False, True]
