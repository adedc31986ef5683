"""Fault isolation: a failure in any step of one student's submission affects nobody else and gives no mark.

The class is graded in this process with the same steps as `qdot grade`.
"""

import csv
import errno
import os
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.common.errors import QdotError
from qdot.exercises.generation import generate
from qdot.grader.grading import attempt, batch
from qdot.grader.grading.batch import grade_class
from qdot.grader.grading.result import Result
from qdot.grader.judging.verdict import Outcome
from qdot.grader.marking import marking
from qdot.grader.reports import graded_folder
from qdot.grader.reports.graded_folder import write_reports
from qdot.grader.reports.grades_table import find_work_status
from qdot.grader.sandbox.notebook_process import folder_removal
from qdot.grader.sandbox.sandbox import Limits, Sandbox
from qdot.grader.submissions import submission
from qdot.grader.submissions.submission import find_modification_time, find_submissions
from tests.support.results import get_counted_file, index_by_student, read_results
from tests.support.submitting import make_class, make_correct_notebook, submit, work_in_one_process
from tests.support.suites import sample_for_suite

VICTIM = "s02"
PLANTED = "planted"


@pytest.fixture
def assignment(tmp_path: Path) -> Assignment:
    assignment = make_class(tmp_path / "hw", [Student(f"s0{i}") for i in (1, 2, 3)])
    for student in assignment.roster:
        submit(assignment, f"{student.id}/hw.ipynb", make_correct_notebook(assignment, student.id))
    return assignment


def grade_and_report(assignment: Assignment) -> dict[str, Result]:
    """Grade the class and write its reports; return the results, which must be those of results.jsonl."""
    with work_in_one_process():
        submissions = find_submissions(assignment, assignment.folder / "submitted").by_student
        results = grade_class(assignment, submissions, 0, Limits(seconds=20))
        results = write_reports(assignment, results)
    assert list(read_results(assignment.folder).values()) == results
    with (assignment.folder / "graded" / "grades.csv").open() as table:
        assert [row["status"] for row in csv.DictReader(table)] == [find_work_status(result) for result in results]
    return index_by_student(results)


def is_victims(value: object) -> bool:
    """Return whether an argument of a step belongs to the victim: a path, an id, a student, a notebook."""
    if isinstance(value, Student):
        return value.id == VICTIM
    if isinstance(value, Result):
        return value.student == VICTIM
    if isinstance(value, (list, tuple)):
        return any(not isinstance(item, Student) and is_victims(item) for item in value)  # not the whole roster
    return VICTIM in str(getattr(value, "path", value))


STEPS: dict[str, tuple[object, str]] = {
    "looked into": (submission, "_list_files"),
    "ranked": (submission, "sort_candidates"),
    "read": (attempt, "read_submission"),
    "taken from what is kept": (batch._GradingWorker, "load_marks"),
    "regenerated": (attempt, "load_stored_problems"),
    "compared with the assignment": (attempt, "explain_wrong_assignment"),
    "run": (Sandbox, "run"),
    "found among what was run": (attempt, "find_answers"),
    "marked": (attempt, "mark"),
    "judged": (marking, "judge_parsed"),
    "kept": (batch._GradingWorker, "store_marks"),
    "settled": (batch, "compute_final_result"),
    "made a line": (graded_folder, "make_results_jsonl"),
    "made a row": (graded_folder, "make_grades_csv"),
    "made a page": (graded_folder, "make_feedback_page"),
}
"""Every step of a submission, by the function that does it."""

REPORTING_STEPS = {"settled", "made a line", "made a row", "made a page"}
"""Steps that also process the result that replaces the failed one."""

FAULTS = {
    "run": MemoryError(PLANTED), "marked": RecursionError(PLANTED), "judged": OverflowError(PLANTED),
    "regenerated": QdotError(PLANTED), "read": OSError(PLANTED),
    "looked into": UnicodeEncodeError("utf-8", PLANTED, 0, 1, PLANTED),
}  # fmt: skip
"""The exception that a step raises, if it is not a KeyError."""


@pytest.mark.parametrize("step", sample_for_suite(STEPS, 8))
def test_a_fault_in_any_step_affects_only_its_student(
    step: str, assignment: Assignment, monkeypatch: pytest.MonkeyPatch
) -> None:
    owner, name = STEPS[step]
    original: Callable[..., Any] = getattr(owner, name)
    current = [""]  # the student at work, for steps whose arguments don't say
    failed = []

    def fail_for_victim(*arguments: Any, **options: Any) -> Any:
        lists = [argument for argument in arguments if isinstance(argument, list) and len(argument) > 1]
        class_lists = [items for items in lists if isinstance(items[0], dict)]
        is_replacement = step in REPORTING_STEPS and "qdot could not grade this" in repr(arguments)
        if (any(map(is_victims, arguments)) or current[0] == VICTIM) and not class_lists and not is_replacement:
            failed.append(step)
            raise FAULTS.get(step, KeyError(PLANTED))
        return original(*arguments, **options)

    def grade_and_remember(*arguments: Any, **options: Any) -> Any:
        current[0] = arguments[1]
        try:
            return grade_attempt(*arguments, **options)
        finally:
            current[0] = ""

    grade_attempt = attempt.grade_attempt
    monkeypatch.setattr(owner, name, fail_for_victim)
    monkeypatch.setattr(attempt, "grade_attempt", grade_and_remember)
    results = grade_and_report(assignment)
    assert failed
    victim = results.pop(VICTIM)
    assert find_work_status(victim) == "ungraded" and victim.score == 0
    assert PLANTED in victim.parts["p1.position"].reason
    for result in results.values():
        assert result.score == result.max_score, result
    for student in assignment.roster:
        assert (assignment.folder / "graded" / "feedback" / f"{student.id}.html").read_text().endswith("</html>\n")
    assert PLANTED in (assignment.folder / "graded" / "feedback" / f"{VICTIM}.html").read_text()


@pytest.mark.parametrize("search", ["diagnose", "advise", "has_enough_terms", "find_group"])
def test_a_search_for_the_mistake_that_fails_changes_no_mark(search: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise RuntimeError(PLANTED)

    problem = generate("planar-2r/1", ["jacobian", "determinant"])
    monkeypatch.setattr(marking, search, fail)
    _, verdict = marking.mark(problem, {"determinant": "a1*a2"}, secret="s")
    assert (verdict.judgement.outcome, verdict.points) == (Outcome.WRONG, 0.0)


@pytest.mark.parametrize("step", ["read", "run"])
def test_running_out_of_open_files_ends_the_run(
    step: str, assignment: Assignment, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*arguments: Any, **options: Any) -> Any:
        raise OSError(errno.EMFILE, "Too many open files")

    owner, name = STEPS[step]
    monkeypatch.setattr(owner, name, fail)
    with pytest.raises(QdotError, match="ulimit -n"):
        grade_and_report(assignment)
    assert not (assignment.folder / "graded" / "results.jsonl").exists()


def test_ungraded_work_is_graded_once_the_fault_is_gone(
    assignment: Assignment, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(attempt, "mark", lambda *_, **__: 1 / 0)
        assert [find_work_status(result) for result in grade_and_report(assignment).values()] == ["ungraded"] * 3
    assert [find_work_status(result) for result in grade_and_report(assignment).values()] == ["graded"] * 3


def test_a_machine_that_cannot_run_notebooks_ends_the_run(
    assignment: Assignment, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise QdotError("the process in which notebooks run does not start")

    monkeypatch.setattr(Sandbox, "run", refuse)
    with pytest.raises(QdotError, match="does not start"):
        grade_and_report(assignment)


def make_deep_folders(name: str, depth: int) -> Callable[[Path], None]:
    """Return a function that nests folders more deeply than a path may be long."""

    def create(submitted: Path) -> None:
        top = os.open(submitted / "s03", os.O_RDONLY)
        for _ in range(depth):
            os.mkdir(name, dir_fd=top)
            inner = os.open(name, os.O_RDONLY, dir_fd=top)
            os.close(top)
            top = inner
        os.close(top)

    return create


def make_stray_file(path: str) -> Callable[[Path], None]:
    def create(submitted: Path) -> None:
        (submitted / path).parent.mkdir(exist_ok=True)
        (submitted / path).write_bytes(b"no notebook")

    return create


def make_links(submitted: Path) -> None:
    for name in ("s03/a.ipynb", "s03/folder", "stray"):
        (submitted / name).symlink_to("x" * 300)


def imitate_platform(submitted: Path) -> None:
    for student in ("s01", "s02"):
        (submitted / student / "hw.ipynb").rename(submitted / f"{student}.ipynb")
        (submitted / student).rmdir()
    (submitted / "s03" / "submission_metadata.yml").write_text("submission_7:\n")


STRAY_FILES: dict[str, tuple[Callable[[Path], None], str]] = {
    **{
        place: (make_stray_file(place), "")
        for place in ("s01/L\udcf6sung.txt", "s01/L\udcf6s/hw.ipynb", "L\udcf6sung.ipynb", "s02_\udcf6/a.ipynb")
        if sys.platform == "linux"  # only Linux allows file names that are not text
    },
    "deep folders": (make_deep_folders("d", 1200), ""),
    "a path that is too long": (make_deep_folders("d" * 200, 25), "File name too long"),
    "links to a name that is too long": (make_links, "symbolic link"),
    "a platform's file": (imitate_platform, ""),
}


@pytest.mark.parametrize("case", STRAY_FILES, ids=ascii)
def test_stray_files_stop_no_grading(assignment: Assignment, case: str) -> None:
    create, note = STRAY_FILES[case]
    create(assignment.folder / "submitted")
    results = grade_and_report(assignment)
    folder_removal.remove_folder(str(assignment.folder / "submitted"))  # pytest can't
    assert [(result.score, find_work_status(result)) for result in results.values()] == [(4, "graded")] * 3
    assert note in "".join(results["s03"].notes)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has names of files that are no text")
def test_a_notebook_whose_name_is_not_utf8_is_graded(assignment: Assignment) -> None:
    folder = assignment.folder / "submitted" / "s01"
    (folder / "hw.ipynb").rename(folder / "L\udcf6sung.ipynb")
    result = grade_and_report(assignment)["s01"]
    assert (result.score, get_counted_file(result)) == (4, "L\N{REPLACEMENT CHARACTER}sung.ipynb")
    assert grade_and_report(assignment)["s01"] == result  # from the stored marks
    assert not (assignment.folder / "graded" / "history").exists()


@pytest.mark.skipif(os.geteuid() == 0, reason="root looks into every folder")
def test_an_unreadable_folder_is_reported(assignment: Assignment) -> None:
    (assignment.folder / "submitted" / "s03" / "closed").mkdir(mode=0)
    result = grade_and_report(assignment)["s03"]
    assert result.score == 4 and "closed: " in result.notes[0]


def test_a_note_names_only_some_of_many_notebooks(assignment: Assignment) -> None:
    text = make_correct_notebook(assignment, "s01")
    for number in range(30):
        submit(assignment, f"s01/hw-{number:02d}.ipynb", text.replace("# T", f"# {number}"))
    note = grade_and_report(assignment)["s01"].staff_notes[0]
    assert "31 " in note and " 25 more" in note and len(note) < 250


def test_the_newest_of_thousands_of_notebooks_counts(assignment: Assignment, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its name doesn't matter, and a note counts the others. Beyond the limit on files, none counts."""
    for number in range(2100):
        path = submit(assignment, f"s01/v{number:04d}.ipynb", "{}")
        os.utime(path, (1_700_000_000 + number,) * 2)
    os.utime(submit(assignment, "s01/v9999.ipynb", make_correct_notebook(assignment, "s01")), (1_700_009_999,) * 2)
    (assignment.folder / "submitted" / "s01" / "hw.ipynb").unlink()
    result = grade_and_report(assignment)["s01"]
    assert (result.score, get_counted_file(result)) == (4, "v9999.ipynb")
    assert any("2101 notebooks were submitted, but qdot reads at most 50: " in note for note in result.notes)
    monkeypatch.setattr(submission, "MAX_FILES", 2000)
    result = grade_and_report(assignment)["s01"]
    assert find_work_status(result) == "over limit" and "2,000 files" in (result.obstacle or "")


@pytest.mark.parametrize(("seconds", "year"), [(10**12, 9999), (-(10**12), 1970), (1_700_000_000, 2023)])
def test_any_modification_time_becomes_a_valid_date(seconds: int, year: int) -> None:
    path: Any = SimpleNamespace(lstat=lambda: os.stat_result((0,) * 8 + (seconds, 0)))
    time = find_modification_time(path)
    assert time.year == year and time.astimezone().isoformat()
