"""Earlier results are kept when they are replaced, and `qdot grade --diff` says whose mark changed, and why."""

import json
import tracemalloc
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.json_form import to_jsonable
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
from qdot.grader.reports.graded_folder import write_reports
from qdot.grader.reports.grades_table import make_results_jsonl
from tests.grader.grading.test_final_result import DUE, HOUR, RULE, TOML, folder, released, run, submit_answers
from tests.support.command import run_and_fail
from tests.support.results import change_part, make_part

__all__ = ["folder", "released"]


def read_history(folder: Path) -> dict[str, list[dict[str, Any]]]:
    paths = sorted((folder / "graded" / "history").glob("*"))
    return {path.stem: [json.loads(line) for line in path.read_text().splitlines()] for path in paths}


def list_changes(folder: Path) -> list[str]:
    return [" ".join(line.split()) for line in run(folder, "--diff")[1].splitlines()[:-1]]


@pytest.mark.whole
def test_a_large_class_is_written_in_little_memory(folder: Path, released: Path) -> None:
    """Results are read one after another: all of 100,000 would take gigabytes."""
    submit_answers(folder, released, "s1/hw.ipynb", -1)
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
    assert read_history(folder) == {}


def test_a_run_with_fewer_submissions_removes_no_mark(folder: Path, released: Path, tmp_path: Path) -> None:
    """For example, a second zip with late work only, or the folder after a platform's zip was graded."""
    for student in ("s1", "s2"):
        submit_answers(folder, released, f"{student}/hw.ipynb", -1)
    run(folder)
    before = results_path(load_assignment(folder)).read_bytes()
    late = tmp_path / "late"
    (folder / "submitted" / "s2").rename(late)
    with zipfile.ZipFile(tmp_path / "late.zip", "w") as archive:
        archive.write(late / "hw.ipynb", "s2/hw.ipynb")
    for source, missing in ((folder / "submitted", "s2"), (tmp_path / "late.zip", "s1")):
        message = run_and_fail("grade", folder, source)
        assert message.startswith(f"qdot: {source}: submissions of 1 of 3 students") and f" {missing}; " in message
        assert results_path(load_assignment(folder)).read_bytes() == before
    results, _ = run(folder, "--allow-missing")
    staff_files = [path for path in (folder / "graded").glob("[gr]*.*") if path.is_file()]
    staff_files += (folder / "graded" / "history").glob("*")
    assert len(staff_files) > 2 and {path.stat().st_mode & 0o777 for path in staff_files} == {0o600}
    assert results["s2"].submission is None and results["s1"].submission is not None
    run(folder)  # once is enough


def test_allow_missing_applies_to_a_whole_class(folder: Path) -> None:
    assert "--allow-missing applies to a whole class;" in run_and_fail(
        "grade", str(folder), "--allow-missing", "--student=ada"
    )


@pytest.mark.whole
def test_diff_says_whose_mark_changed_and_why(folder: Path, released: Path) -> None:
    submit_answers(folder, released, "s1/hw.ipynb", -1, position="blank")
    submit_answers(folder, released, "s2/hw.ipynb", 1)
    first, output = run(folder, "--diff")
    assert output.startswith("there is nothing to compare with, because this is the first run\n")
    assert read_history(folder) == {}
    assert list_changes(folder) == ["no mark has changed since the last run"]
    assert read_history(folder) == {}

    submit_answers(folder, released, "s1/hw.ipynb", -1)
    submit_answers(folder, released, "s3/hw.ipynb", -1, determinant="blank")
    assert list_changes(folder) == [
        "s1 p1.position 0 → 2 new submission", "s1 total 0.7 → 2.7 new submission",
        "s3 p1.position 0 → 2 new submission", "s3 total 0 → 2 new submission",
        "marks of 2 students changed since the last run; total points 3.4 → 7.4 (+4)",
    ]  # fmt: skip
    (line,) = read_history(folder)["s1"]
    assert (line["why"], line["result"]) == ("new submission", to_jsonable(first["s1"]))
    assert set(read_history(folder)) == {"s1", "s3"}

    (folder / "assignment.toml").write_text(TOML.format(RULE))
    (folder / "overrides.csv").write_text("student,part,points,comment\ns3,p1.determinant,0.5,on paper\ns1,,1,copied\n")
    assert list_changes(folder)[:-1] == [
        "s1 total 2.7 → 1 override", "s2 total 2.7 → 2.43 late rule",
        "s3 p1.determinant 0 → 0.5 override", "s3 total 2 → 2.5 override",
    ]  # fmt: skip
    assert [len(lines) for lines in read_history(folder).values()] == [2, 1, 2]

    (folder / "overrides.csv").unlink()
    (folder / "assignment.toml").write_text(TOML.format(RULE).replace("[2, 0.7]", "[1, 0.7]"))
    last = folder / "graded" / "results.jsonl"
    last.write_text(last.read_text().replace(f'"grader": {GRADER_VERSION}', '"grader": 0'))
    lines = list_changes(folder)
    assert "s1 total 1 → 1.7 assignment changed, grader changed, override" in lines
    assert "s2 p1.position 2 → 1 assignment changed, grader changed" in lines
    (folder / "roster.csv").write_text("student\ns1\ns2\ns4\n")
    lines = list_changes(folder)
    assert "s4 total – → 0 new on the roster" in lines
    assert "s3 total 1 → – no longer on the roster" in lines
    assert read_history(folder)["s3"][-1]["why"] == "no longer on the roster"


def make_result(score: float, **changes: Any) -> Result:
    position = make_part("position", "wrong", 2.0, points=score)
    base = Result(
        student="s1", assignment="hw", submission=CountingSubmission("hw.ipynb", "0", DUE.isoformat()), score=score,
        max_score=2.0, late=None, problems=(ProblemResult("planar-2r/1", "p1", (position,)),),
    )  # fmt: skip
    return replace(base, **changes)


def make_line(score: float) -> str:
    return make_results_jsonl([make_result(score)]).decode()


def list_reasons(before: Result, after: Result) -> list[str]:
    return [f"{change.part}: {change.reason}" for change in find_mark_changes({"s1": before}, [after])]


def test_rare_reasons_for_changes() -> None:
    attempts = (SubmittedNotebook("b.ipynb", DUE.isoformat(), None),)
    another = CountingSubmission("b.ipynb", "1", DUE.isoformat())
    later = (DUE + HOUR).isoformat()
    lateness = Lateness(DUE.isoformat(), later, 3600, 0.1, 1.0)
    late = replace(make_result(1), submission=CountingSubmission("hw.ipynb", "0", later), late=lateness, score=0.9)
    for before, after, expected in (
        (make_result(1, attempts=attempts), make_result(2, submission=another), "another attempt counts"),
        (make_result(1), make_result(0, submission=None), "submission missing"),
        (make_result(1), make_result(2), "graded again"),
    ):
        assert list_reasons(before, after) == [f"p1.position: {expected}", f": {expected}"]
    assert list_reasons(make_result(1), late) == [": received at another time"]
    failed = change_part(make_result(0), "p1.position", points=None)
    assert find_mark_changes({"s1": failed}, [make_result(1)])[0].old_points == "ungraded"
    assert describe_mark_changes({"s1": make_result(1)}, [make_result(2)]).endswith("1 → 2 (+1)")


def test_an_interrupted_run_adds_no_history_twice(folder: Path) -> None:
    """The run was stopped between writing the history and results.jsonl."""
    assignment = load_assignment(folder)
    path = history.results_path(assignment)
    path.parent.mkdir()
    path.write_text(make_line(1))
    for score in (2, 2, 1.5):
        store_previous_results(assignment, [make_result(score)])
        assert [entry["result"]["score"] for entry in read_history(folder)["s1"]] == [1]
    path.write_text(make_line(1.5))
    store_previous_results(assignment, [make_result(1)])
    path.write_text(make_line(1))
    store_previous_results(assignment, [make_result(2)])
    assert [entry["result"]["score"] for entry in read_history(folder)["s1"]] == [1, 1.5, 1]


def test_a_new_file_time_is_a_change_only_if_it_is_late(folder: Path, released: Path) -> None:
    submit_answers(folder, released, "s1/hw.ipynb", -2)
    run(folder)
    submit_answers(folder, released, "s1/hw.ipynb", -1)
    assert list_changes(folder) == ["no mark has changed since the last run"]
    assert read_history(folder) == {}
    submit_answers(folder, released, "s1/hw.ipynb", 1)
    results, _ = run(folder)
    assert results["s1"].late is not None and results["s1"].late.seconds == 3600
    assert [line["why"] for line in read_history(folder)["s1"]] == ["received at another time"]


def test_unencodable_file_names_are_no_change(folder: Path) -> None:
    odd = make_result(1, submission=CountingSubmission("\udcff.ipynb", "0", None), obstacle="none", notes=("\u2028",))
    assignment = load_assignment(folder)
    for _ in range(2):
        write_reports(assignment, [odd])
    assert set(read_previous_results(assignment)) == {"s1"}
    assert read_history(folder) == {}


def test_damaged_results_are_ignored(folder: Path) -> None:
    assignment = load_assignment(folder)
    path = history.results_path(assignment)
    path.parent.mkdir()
    path.write_bytes(b"\xff")
    assert read_previous_results(assignment) == {}
    damaged = '{"student": "s0"\n[]\n{"student": "s2"}\n{"student": "s3", "score": 1, "problems": []}\n'
    path.write_text(f"{damaged}{make_line(1)}")
    assert set(read_previous_results(assignment)) == {"s1"}
    log = folder / "graded" / "history" / "s1.jsonl"
    log.parent.mkdir()
    log.write_text("half a li")
    store_previous_results(assignment, [make_result(2)])
    assert [entry.startswith("{") for entry in log.read_text().splitlines()] == [False, True]
