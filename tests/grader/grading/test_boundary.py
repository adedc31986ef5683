"""A boundary around each submission: a fault planted in any step of one student's stops nobody else, and is no mark.

The class is graded as `qdot grade` does it, in this process: found, read, run, judged, kept, settled, written.
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
from qdot.grader.grading import attempt, batch
from qdot.grader.grading.batch import grade_class
from qdot.grader.grading.result import Result
from qdot.grader.marking import marking
from qdot.grader.reports import write
from qdot.grader.reports.tables import find_work_status
from qdot.grader.reports.write import write_reports
from qdot.grader.sandbox.contained import folders
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
    made = make_class(tmp_path / "hw", [Student(f"s0{i}") for i in (1, 2, 3)])
    for student in made.roster:
        submit(made, f"{student.id}/hw.ipynb", make_correct_notebook(made, student.id))
    return made


def graded(assignment: Assignment) -> dict[str, Result]:
    """Grade the class and write its reports; return the results as they stand in results.jsonl."""
    with work_in_one_process():
        found = find_submissions(assignment, assignment.folder / "submitted").by_student
        results = grade_class(assignment, found, 0, Limits(seconds=20))
        results = write_reports(assignment, results)
    assert list(read_results(assignment.folder).values()) == results
    with (assignment.folder / "graded" / "grades.csv").open() as table:
        assert [row["status"] for row in csv.DictReader(table)] == [find_work_status(result) for result in results]
    return index_by_student(results)


def is_victims(about: object) -> bool:
    """Tell whether something that a step is given is the victim's: a path, an id, a student, a notebook."""
    if isinstance(about, Student):
        return about.id == VICTIM
    if isinstance(about, Result):
        return about.student == VICTIM
    if isinstance(about, (list, tuple)):
        return any(not isinstance(one, Student) and is_victims(one) for one in about)  # not the whole roster
    return VICTIM in str(getattr(about, "path", about))


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
    "made a line": (write, "make_results_jsonl"),
    "made a row": (write, "make_grades_csv"),
    "made a page": (write, "make_feedback_page"),
}
"""Every step of a submission, by the function that does it."""

ONCE = {"settled", "made a line", "made a row", "made a page"}
"""Where what stands for the student goes the same way as what failed did."""

KINDS = {
    "run": MemoryError(PLANTED), "marked": RecursionError(PLANTED), "judged": OverflowError(PLANTED),
    "regenerated": QdotError(PLANTED), "read": OSError(PLANTED),
    "looked into": UnicodeEncodeError("utf-8", PLANTED, 0, 1, PLANTED),
}  # fmt: skip
"""What the fault is, where it is no KeyError."""


@pytest.mark.parametrize("step", sample_for_suite(STEPS, 8))
def test_a_fault_in_any_step_is_its_students_alone(
    step: str, assignment: Assignment, monkeypatch: pytest.MonkeyPatch
) -> None:
    where, name = STEPS[step]
    real: Callable[..., Any] = getattr(where, name)
    current = [""]  # whose notebook is at work, for steps that are not told
    failed = []

    def planted(*about: Any, **options: Any) -> Any:
        whole = [one for one in about if isinstance(one, list) and len(one) > 1 and isinstance(one[0], dict)]
        is_told = step in ONCE and "qdot could not grade this" in repr(about)
        if (any(map(is_victims, about)) or current[0] == VICTIM) and not whole and not is_told:
            failed.append(step)
            raise KINDS.get(step, KeyError(PLANTED))
        return real(*about, **options)

    def told(*about: Any, **options: Any) -> Any:
        current[0] = about[1]
        try:
            return grade_attempt(*about, **options)
        finally:
            current[0] = ""

    grade_attempt = attempt.grade_attempt
    monkeypatch.setattr(where, name, planted)
    monkeypatch.setattr(attempt, "grade_attempt", told)
    results = graded(assignment)
    assert failed
    victim = results.pop(VICTIM)
    assert find_work_status(victim) == "ungraded" and victim.score == 0
    assert PLANTED in victim.parts["p1.position"].reason
    for result in results.values():
        assert result.score == result.max_score, result
    for student in assignment.roster:
        assert (assignment.folder / "graded" / "feedback" / f"{student.id}.html").read_text().endswith("</html>\n")
    assert PLANTED in (assignment.folder / "graded" / "feedback" / f"{VICTIM}.html").read_text()


@pytest.mark.parametrize("step", ["read", "run"])
def test_a_machine_that_opens_no_more_files_is_nobodys_failure(
    step: str, assignment: Assignment, monkeypatch: pytest.MonkeyPatch
) -> None:
    def planted(*about: Any, **options: Any) -> Any:
        raise OSError(errno.EMFILE, "Too many open files")

    where, name = STEPS[step]
    monkeypatch.setattr(where, name, planted)
    with pytest.raises(QdotError, match="ulimit -n"):
        graded(assignment)
    assert not (assignment.folder / "graded" / "results.jsonl").exists()


def test_what_was_ungraded_is_graded_when_the_fault_is_gone(
    assignment: Assignment, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(attempt, "mark", lambda *_, **__: 1 / 0)
        assert [find_work_status(result) for result in graded(assignment).values()] == ["ungraded"] * 3
    assert [find_work_status(result) for result in graded(assignment).values()] == ["graded"] * 3


def test_a_machine_that_runs_no_notebook_is_told_once(assignment: Assignment, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise QdotError("the process in which notebooks run does not start")

    monkeypatch.setattr(Sandbox, "run", refuse)
    with pytest.raises(QdotError, match="does not start"):
        graded(assignment)


def nested(name: str, depth: int) -> Callable[[Path], None]:
    """Make folders within folders, deeper than a path may be long."""

    def make(submitted: Path) -> None:
        top = os.open(submitted / "s03", os.O_RDONLY)
        for _ in range(depth):
            os.mkdir(name, dir_fd=top)
            inner = os.open(name, os.O_RDONLY, dir_fd=top)
            os.close(top)
            top = inner
        os.close(top)

    return make


def junk(place: str) -> Callable[[Path], None]:
    def make(submitted: Path) -> None:
        (submitted / place).parent.mkdir(exist_ok=True)
        (submitted / place).write_bytes(b"no notebook")

    return make


def links(submitted: Path) -> None:
    for name in ("s03/a.ipynb", "s03/folder", "stray"):
        (submitted / name).symlink_to("x" * 300)


def as_a_platforms(submitted: Path) -> None:
    """A student's folder with a file that is called as that of a platform is."""
    for student in ("s01", "s02"):
        (submitted / student / "hw.ipynb").rename(submitted / f"{student}.ipynb")
        (submitted / student).rmdir()
    (submitted / "s03" / "submission_metadata.yml").write_text("submission_7:\n")


PLACED: dict[str, tuple[Callable[[Path], None], str]] = {
    **{
        place: (junk(place), "")
        for place in ("s01/L\udcf6sung.txt", "s01/L\udcf6s/hw.ipynb", "L\udcf6sung.ipynb", "s02_\udcf6/a.ipynb")
        if sys.platform == "linux"  # only Linux has names of files that are no text
    },
    "deep folders": (nested("d", 1200), ""),
    "a path that is too long": (nested("d" * 200, 25), "File name too long"),
    "links to a name that is too long": (links, "symbolic link"),
    "a platform's file": (as_a_platforms, ""),
}


@pytest.mark.parametrize("case", PLACED, ids=ascii)
def test_what_lies_about_stops_nobody(assignment: Assignment, case: str) -> None:
    place, note = PLACED[case]
    place(assignment.folder / "submitted")
    results = graded(assignment)
    folders.remove(str(assignment.folder / "submitted"))  # pytest can't
    assert [(result.score, find_work_status(result)) for result in results.values()] == [(4, "graded")] * 3
    assert note in "".join(results["s03"].notes)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has names of files that are no text")
def test_a_notebook_whose_name_is_not_utf8_is_graded(assignment: Assignment) -> None:
    own = assignment.folder / "submitted" / "s01"
    (own / "hw.ipynb").rename(own / "L\udcf6sung.ipynb")
    result = graded(assignment)["s01"]
    assert (result.score, get_counted_file(result)) == (4, "L\N{REPLACEMENT CHARACTER}sung.ipynb")
    assert graded(assignment)["s01"] == result  # from what was kept
    assert not (assignment.folder / "graded" / "history").exists()


@pytest.mark.skipif(os.geteuid() == 0, reason="root looks into every folder")
def test_a_folder_that_cannot_be_looked_into_is_told(assignment: Assignment) -> None:
    (assignment.folder / "submitted" / "s03" / "closed").mkdir(mode=0)
    result = graded(assignment)["s03"]
    assert result.score == 4 and "closed: " in result.notes[0]


def test_fifty_notebooks_are_not_all_named_in_one_note(assignment: Assignment) -> None:
    text = make_correct_notebook(assignment, "s01")
    for number in range(30):
        submit(assignment, f"s01/hw-{number:02d}.ipynb", text.replace("# T", f"# {number}"))
    note = graded(assignment)["s01"].staff_notes[0]
    assert "31 " in note and " 25 more" in note and len(note) < 250


def test_of_thousands_of_notebooks_the_newest_counts(assignment: Assignment, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever its name is, and it is said that there are others; of more than may be handed in, none does."""
    for number in range(2100):
        path = submit(assignment, f"s01/v{number:04d}.ipynb", "{}")
        os.utime(path, (1_700_000_000 + number,) * 2)
    os.utime(submit(assignment, "s01/v9999.ipynb", make_correct_notebook(assignment, "s01")), (1_700_009_999,) * 2)
    (assignment.folder / "submitted" / "s01" / "hw.ipynb").unlink()
    result = graded(assignment)["s01"]
    assert (result.score, get_counted_file(result)) == (4, "v9999.ipynb")
    assert any("2101 notebooks were submitted, but qdot reads at most 50: " in said for said in result.notes)
    monkeypatch.setattr(submission, "MAX_FILES", 2000)
    result = graded(assignment)["s01"]
    assert find_work_status(result) == "over limit" and "2,000 files" in (result.obstacle or "")


@pytest.mark.parametrize(("seconds", "year"), [(10**12, 9999), (-(10**12), 1970), (1_700_000_000, 2023)])
def test_a_files_time_has_a_date_whatever_it_is(seconds: int, year: int) -> None:
    path: Any = SimpleNamespace(lstat=lambda: os.stat_result((0,) * 8 + (seconds, 0)))
    time = find_modification_time(path)
    assert time.year == year and time.astimezone().isoformat()
