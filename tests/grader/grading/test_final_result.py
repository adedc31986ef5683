"""Overrides, lateness and several attempts: sums are exact in every report, and survive regrading."""

import csv
import datetime
import itertools
import os
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.attempt_policy import AttemptPolicy
from qdot.exercises.assignment.late_rule import LateRule
from qdot.exercises.common.errors import QdotError
from qdot.grader.grading.final_result import GradedNotebook, compute_final_result
from qdot.grader.grading.overrides import NO_OVERRIDES, Overrides, read_overrides
from qdot.grader.grading.result import Lateness, MarkingVersions, NotebookMarks, Override, ProblemResult, Result
from qdot.grader.judging.verdict import AWAITS_PERSON
from qdot.grader.reports.class_summary import find_late_or_unmarked
from qdot.grader.reports.feedback import make_feedback_page
from qdot.grader.reports.grades_table import SUMMARY_COLUMNS, find_work_status, make_grades_csv, make_to_mark_csv
from tests.support import command, read_cases
from tests.support.results import get_counted_file, make_override, make_part, read_results
from tests.support.submitting import answer_notebook, make_class, release_class, work_in_one_process

DUE = datetime.datetime(2027, 1, 15, 12, tzinfo=datetime.UTC)
HOUR = datetime.timedelta(hours=1)
TOML = """title = "T"
key = "hw"
due = 2027-01-15T12:00:00Z
{}
[[problem]]
family = "planar-2r"
questions = ["position", "determinant"]
points = [2, 0.7]
"""
RULE = 'late = {grace = "15 min", per_day = 0.1, at_most = 0.5, until = 2027-01-25T12:00:00Z}'
STUDENTS = [Student("s1", "Ada"), Student("s2", "Bo"), Student("s3", "Cy")]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return make_class(tmp_path / "hw", STUDENTS, TOML.format("")).folder


def make_marks(*points: float | None) -> NotebookMarks:
    outcomes = ["partial" if earned else "ungraded" if earned is None else "wrong" for earned in points]
    parts = tuple(
        make_part(name, outcome, most, points=earned, reason="the reason")
        for name, outcome, most, earned in zip(("position", "determinant"), outcomes, (2.0, 0.7), points, strict=True)
    )
    return NotebookMarks(sha256="0", made_from=MarkingVersions(), problems=(ProblemResult("planar-2r/1", "p1", parts),))


def attempt(assignment: Assignment, hours: float, *points: float | None, **overrides: Override) -> Result:
    notebooks = [GradedNotebook("hw.ipynb", DUE + hours * HOUR, make_marks(*points))]
    student = assignment.roster[0]
    by_part = {
        (student.id, {"total": ""}.get(name, f"p1.{name}"), ""): override for name, override in overrides.items()
    }
    return compute_final_result(assignment, student, notebooks, Overrides(by_part))


@pytest.mark.parametrize(("line", "message"), read_cases("refused")["overrides"])
def test_an_error_in_overrides_is_reported_with_its_line(folder: Path, line: str, message: str) -> None:
    (folder / "overrides.csv").write_text(f"student,part,points,comment\n{line}\n")
    with pytest.raises(QdotError) as caught:
        read_overrides(load_assignment(folder))
    assert str(caught.value).startswith(f"{folder / 'overrides.csv'}: line ")
    assert message in str(caught.value)


def test_overrides_are_read_from_spreadsheet_formats(folder: Path) -> None:
    assert read_overrides(load_assignment(folder)) == Overrides()
    (folder / "overrides.csv").write_text('﻿Student;Part;Points;Comment\ns1;p1.position;1,5;"a; b"\ns2;;2;\n\n')
    by_part = read_overrides(load_assignment(folder)).by_part
    assert by_part == {("s1", "p1.position", ""): make_override(1.5, "a; b"), ("s2", "", ""): make_override(2.0)}
    (folder / "overrides.csv").write_text('student,part,points\ns1,p1.position,33.3333%\ns1,,"12,5 %"\n')
    shares = {("s1", "p1.position", ""): make_override(0.6667), ("s1", "", ""): make_override(0.3375)}
    assert read_overrides(load_assignment(folder)).by_part == shares


def attempt_in_words(
    assignment: Assignment, overrides: Overrides = NO_OVERRIDES, answer: str = "=1 because\nit folds"
) -> Result:
    marks = make_marks(2.0, None)
    (problem,) = marks.problems
    text = replace(problem.parts[1], reason=AWAITS_PERSON, answer=answer)
    notebooks = [
        GradedNotebook("hw.ipynb", DUE, replace(marks, problems=(replace(problem, parts=(problem.parts[0], text)),)))
    ]
    return compute_final_result(assignment, assignment.roster[0], notebooks, overrides)


def test_the_list_of_answers_to_mark_becomes_overrides(folder: Path) -> None:
    assignment = load_assignment(folder)
    result = attempt_in_words(assignment)
    table = make_to_mark_csv([result, attempt(assignment, -1, None, 0.7)])
    assert table == "student,part,points,comment,answer\ns1,p1.determinant,,,'=1 because it folds\n"
    (folder / "overrides.csv").write_text(table)
    assert read_overrides(assignment) == Overrides(), "an answer without points is not marked yet"
    (folder / "overrides.csv").write_text(table.replace(",,,", ",0.5,good,"))
    overrides = read_overrides(assignment)
    assert overrides.by_part == {("s1", "p1.determinant", "=1 because it folds"): make_override(0.5, "good")}
    assert make_to_mark_csv([attempt_in_words(assignment, overrides)]) is None
    other_result = attempt_in_words(assignment, overrides, "because it is long")
    assert make_to_mark_csv([other_result]) == table.replace("'=1 because it folds", "because it is long")
    assert "the answer to p1.determinant has changed since a person marked it" in other_result.staff_notes
    (folder / "overrides.csv").write_text("student,part,points\ns1,p1.determinant,0.5\n")
    assert make_to_mark_csv([attempt_in_words(assignment, read_overrides(assignment), "any")]) is None
    (row,) = find_late_or_unmarked([result])
    assert (row.status, row.reason) == ("to mark", "an answer in words has no points yet")


def test_points_set_by_a_person_are_an_outcome_if_qdot_has_none(folder: Path) -> None:
    assignment = load_assignment(folder)
    for points, outcome in ((0, "wrong"), (0.5, "partial"), (0.7, "correct")):
        overrides = Overrides({("s1", "p1.determinant", ""): make_override(points)})
        part = attempt_in_words(assignment, overrides).parts["p1.determinant"]
        assert (part.outcome, part.points, part.reason) == (outcome, points, "a person marked this answer")
    part = attempt(assignment, -1, None, 0.7, position=make_override(2)).parts["p1.position"]
    assert (part.outcome, part.reason) == ("correct", "the reason")


def test_an_override_keeps_the_graders_verdict(folder: Path) -> None:
    assignment = load_assignment(folder)
    assert find_work_status(attempt(assignment, -1, None, 0.7)) == "ungraded"
    for overrides in ({"position": make_override(1)}, {"total": make_override(1)}):
        assert find_work_status(attempt(assignment, -1, None, 0.7, **overrides)) == "graded", (
            "an override replaces a failed grading"
        )
    result = attempt(assignment, -1, 0.5, 0.7, position=make_override(1.25, "the sketch is right"))
    part = result.parts["p1.position"]
    assert (part.outcome, part.reason, part.points) == ("partial", "the reason", 1.25)
    assert part.override == Override(1.25, "the sketch is right", 0.5)
    assert (result.score, result.override) == (1.95, None)


@pytest.mark.parametrize(
    ("late", "message"),
    [
        ("late = 0.1", "late = 0.1: "), ("late = {}", "per_day, until"), ('late = {grace = "1 h"}', "per_day, until"),
        ("late = {perday = 0.1}", "unknown key 'perday' (did you mean 'per_day'?)"),
        ("late = {per_day = 10}", "late: per_day = "), ("late = {per_day = nan}", "late: per_day = "),
        ("late = {per_day = true}", "late: per_day = "), ('late = {per_day = "10%"}', "late: per_day = "),
        ("late = {at_most = 0.5}", "per_day, until"), ("late = {per_day = 0.1, at_most = 2}", "late: at_most = 2: "),
        ("late = {at_most = 0.5, until = 2027-01-25T12:00:00Z}", "at_most limits the deduction of per_day"),
        ("late = {per_day = 0.1, grace = 15}", 'grace = "15 min"'),
        ('late = {per_day = 0.1, grace = "15 minutes"}', "s, min, h, day, days"),
        ("late = {until = 2027-01-25}", "late: until = "), ("late = {until = 2027-01-10T12:00:00Z}", "late: until = "),
        ('attempts = "first"', 'attempts = "first": '), ("attempts = {best_of = 0}", "attempts: best_of = 0: "),
        ("attempts = {best = 2}", "unknown key 'best'"), ('attempts = {apart = "1 week"}', 'attempts: apart = "1 week'),
        ("attempts = 3", "attempts = 3: "), (f"{RULE}\n# no time: ", "due ="),
    ],
)  # fmt: skip
def test_an_error_in_the_late_rule_or_attempts_is_reported(folder: Path, late: str, message: str) -> None:
    text = TOML.format(late)
    (folder / "assignment.toml").write_text(text.replace("due", "# due", 1) if "no time" in late else text)
    with pytest.raises(QdotError) as caught:
        load_assignment(folder)
    assert str(caught.value).startswith(f"{folder / 'assignment.toml'}: line 4: ")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("hours", "penalty", "score"),
    [(-1, None, 2.7), (0.25, None, 2.7), (0.26, 0.1, 2.43), (24, 0.1, 2.43), (24.01, 0.2, 2.16), (119, 0.5, 1.35),
     (200, 0.5, 1.35), (240, 0.5, 1.35), (240.01, 1.0, 0.0)],
)  # fmt: skip
def test_late_work_loses_a_tenth_per_day(folder: Path, hours: float, penalty: float | None, score: float) -> None:
    (folder / "assignment.toml").write_text(TOML.format(RULE))
    result = attempt(load_assignment(folder), hours, 2.0, 0.7)
    received = (DUE + hours * HOUR).isoformat()
    late = penalty and Lateness("2027-01-15T12:00:00+00:00", received, int(hours * 3600), penalty, 2.7)
    assert (result.score, result.late) == (score, late)
    assert find_work_status(result) == ("graded" if penalty is None else "late")
    (folder / "assignment.toml").write_text(TOML.format(""))
    result = attempt(load_assignment(folder), hours, 2.0, 0.7)  # without a rule, lateness is recorded and costs nothing
    assert (result.score, bool(result.late)) == (2.7, hours > 0)


def test_sums_are_exact_whatever_the_points(folder: Path) -> None:
    (folder / "assignment.toml").write_text(TOML.format(RULE))
    assignment = load_assignment(folder)
    for a, b, hours in itertools.product((0.1, 0.3333, 1.0, 1.9999), (0.0667, 0.2, 0.7), (1, 30, 60)):
        result = attempt(assignment, hours, a, b)
        before = Fraction(str(a)) + Fraction(str(b))
        assert result.late is not None
        deduction = round(before * Fraction(str(result.late.penalty)), 4)
        assert Fraction(str(result.score)) == before - deduction
        (row,) = csv.DictReader(make_grades_csv([result], assignment.roster).splitlines())
        cells = {name: Fraction(row[name]) for name in ("p1.position", "p1.determinant", "late_penalty", "score")}
        assert cells["p1.position"] + cells["p1.determinant"] - cells["late_penalty"] == cells["score"]


def test_an_extension_moves_the_students_deadline(folder: Path) -> None:
    (folder / "assignment.toml").write_text(TOML.format(RULE))
    (folder / "roster.csv").write_text("student,due\ns1,2027-01-16T12:00:00+00:00\ns2,2027-01-16 13:00\ns3,\n")
    assignment = load_assignment(folder)
    scores = []
    for student, hours in itertools.product(assignment.roster, (24, 24.5, 250)):
        notebooks = [GradedNotebook("hw.ipynb", DUE + hours * HOUR, make_marks(2.0, 0.7))]
        scores.append(compute_final_result(assignment, student, notebooks).score)
    assert scores == [2.7, 2.43, 1.35, 2.7, 2.7, 1.35, 2.43, 2.16, 0.0]
    for invalid in ("2027-01-16", "16.1.2027", "Friday"):
        (folder / "roster.csv").write_text(f"student,due\ns1,{invalid}\n")
        with pytest.raises(QdotError, match=rf"roster.csv: line 2: due = '{invalid}': "):
            load_assignment(folder)


def test_times_without_a_zone_are_local(folder: Path) -> None:
    text = TOML.format("late = {until = 2027-01-20T12:00:00}").replace("00Z", "00")
    (folder / "assignment.toml").write_text(text)
    assignment = load_assignment(folder)
    deadline = assignment.due_date_of(assignment.roster[0])
    assert deadline == datetime.datetime(2027, 1, 15, 12).astimezone()
    assert assignment.late_rule == LateRule(until=datetime.datetime(2027, 1, 20, 12).astimezone())


def test_lateness_reduces_overridden_parts_but_no_overridden_total(folder: Path) -> None:
    (folder / "assignment.toml").write_text(TOML.format(RULE))
    assignment = load_assignment(folder)
    assert attempt(assignment, 1, 0.0, 0.7, position=make_override(1)).score == 1.53
    result = attempt(assignment, 1, 0.0, 0.7, position=make_override(1), total=make_override(2.5, "ill"))
    assert (result.score, result.override) == (2.5, Override(2.5, "ill", 1.53))
    (row,) = csv.DictReader(make_grades_csv([result], assignment.roster).splitlines())
    assert [row[name] for name in SUMMARY_COLUMNS[:-1]] == [
        "2.5", "2.7", "92.6", "late", "0.17", "p1.position: 1 (was 0); total: 2.5 (was 1.53), ill",
    ]  # fmt: skip


def test_notebooks_within_minutes_are_one_attempt_and_attempts_are_limited(folder: Path, released: Path) -> None:
    for k in range(4):  # within ten minutes
        submit_answers(folder, released, f"s1/hw-{k}.ipynb", -5 + k / 30, position="blank" if k != 1 else "0")
    for k in range(1, 6):  # the right one is the sixth attempt
        answers = {} if k == 5 else {"determinant": "blank"}
        submit_answers(folder, released, f"s1/later-{k}.ipynb", -5 + k / 2, **answers)
    (folder / "assignment.toml").write_text(TOML.format('attempts = "best"'))
    results, _ = run(folder)
    scores = {attempt.file: attempt.score for attempt in results["s1"].attempts}
    counted = ["hw-3.ipynb", *(f"later-{k}.ipynb" for k in range(1, 5))]
    assert [name for name, score in scores.items() if score is not None] == counted
    assert results["s1"].notes[0].endswith(" within 10 min, only the last counts; at most 5 attempts count")
    (folder / "assignment.toml").write_text(TOML.format('attempts = {best_of = 1, apart = "1 day"}'))
    assert get_counted_file(run(folder)[0]["s1"]) == "later-5.ipynb"


def compute_best(assignment: Assignment, *notebooks: GradedNotebook, **overrides: Override) -> Result:
    return compute_final_result(
        replace(assignment, attempt_policy=AttemptPolicy(5)), student := assignment.roster[0], notebooks,
        Overrides({(student.id, f"p1.{name}", ""): override for name, override in overrides.items()}),
    )  # fmt: skip


def test_the_best_attempt_counts_after_deductions(folder: Path) -> None:
    (folder / "assignment.toml").write_text(TOML.format(RULE))
    assignment = load_assignment(folder)
    early = GradedNotebook("a.ipynb", DUE - HOUR, make_marks(1.9, 0.7))
    late = GradedNotebook("b.ipynb", DUE + HOUR, make_marks(2.0, 0.7))
    result = compute_best(assignment, early, late)
    assert (result.score, get_counted_file(result), result.late) == (2.6, "a.ipynb", None)
    assert [(attempt.file, attempt.score) for attempt in result.attempts] == [("a.ipynb", 2.6), ("b.ipynb", 2.43)]
    assert result.attempts[1].received == "2027-01-15T13:00:00+00:00"
    expected_note = "2 notebooks were submitted; a.ipynb, the best one, counts, and b.ipynb does not"
    assert result.notes == result.staff_notes == (expected_note,)
    same_attempt = replace(early, file="c.ipynb", received=DUE - HOUR - HOUR / 60, marks=None)
    note = compute_best(assignment, same_attempt, early).notes[0]
    assert "a.ipynb counts, and c.ipynb does not" in note and "within 10 min" in note
    assert get_counted_file(compute_best(assignment, early, late, position=make_override(2))) == "a.ipynb"
    assert get_counted_file(compute_best(assignment, early, replace(early, file="c.ipynb"))) == "a.ipynb"


def test_a_failed_attempt_leaves_the_result_open_if_it_could_be_best(folder: Path) -> None:
    assignment = load_assignment(folder)
    failed = GradedNotebook("a.ipynb", DUE, make_marks(None, 0.2))
    for points, status in ((1.0, "ungraded"), (2.0, "graded")):
        other_attempt = GradedNotebook("b.ipynb", DUE, make_marks(points, 0.7))
        assert find_work_status(compute_best(assignment, failed, other_attempt)) == status


@pytest.fixture(scope="module")
def released(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return release_class(tmp_path_factory.mktemp("released") / "hw", STUDENTS, TOML.format("")).folder


def submit_answers(folder: Path, released: Path, name: str, hours: float, **answers: str) -> None:
    student = name.split("/", maxsplit=1)[0]
    text = answer_notebook(load_assignment(released), student, lambda code, part: answers.get(part.name, code))
    path, timestamp = folder / "submitted" / name, (DUE + hours * HOUR).timestamp()
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    os.utime(path, (timestamp, timestamp))


def run(folder: Path, *options: str) -> tuple[dict[str, Result], str]:
    with work_in_one_process():
        output = command.run("grade", folder, "--jobs", "1", *options)
    return read_results(folder), output


def test_the_last_attempt_counts_unless_the_best_is_asked_for(folder: Path, released: Path) -> None:
    submit_answers(folder, released, "s1/hw.ipynb", -2)
    submit_answers(folder, released, "s1/hw-1.ipynb", -1, position="blank")
    submit_answers(folder, released, "s2/hw.ipynb", -1)
    submit_answers(folder, released, "s2/a.ipynb", -1, position="blank")
    scratch = folder / "submitted" / "s2" / "scratch.ipynb"
    scratch.write_text('{"cells": [], "metadata": {}, "nbformat": 4}')
    os.utime(scratch, (DUE.timestamp(), DUE.timestamp()))
    last, _ = run(folder)
    assert (get_counted_file(last["s1"]), last["s1"].score) == ("hw-1.ipynb", 0.7)
    assert [attempt.score for attempt in last["s1"].attempts] == [None, 0.7]
    assert last["s1"].notes[0].endswith("hw-1.ipynb, the last one, counts, and hw.ipynb does not")
    assert get_counted_file(last["s2"]) == "hw.ipynb"  # at the same time as a.ipynb, and named as handed out
    assert last["s2"].notes[0].endswith("same time; qdot chose the one with the likeliest name")
    assert last["s2"].attempts[-1].file == "scratch.ipynb"  # the last file, but no attempt
    assert (last["s3"].submission, last["s3"].attempts) == (None, ())
    (folder / "assignment.toml").write_text(TOML.format('attempts = "best"'))
    stored = {path: path.stat().st_mtime_ns for path in (folder / "graded" / ".cache").glob("*.json")}
    results, _ = run(folder)
    assert (get_counted_file(results["s1"]), results["s1"].score) == ("hw.ipynb", 2.7)
    assert {attempt.file: attempt.score for attempt in results["s1"].attempts} == {"hw.ipynb": 2.7, "hw-1.ipynb": 0.7}
    assert stored.items() <= {path: path.stat().st_mtime_ns for path in stored}.items()


def test_an_override_survives_every_regrade_and_is_in_every_report(folder: Path, released: Path) -> None:
    (folder / "assignment.toml").write_text(TOML.format(RULE))
    submit_answers(folder, released, "s1/hw.ipynb", 25, position="blank")
    (folder / "overrides.csv").write_text(
        "student,part,points,comment\ns1,p1.position,1.5,<on paper>\ns2,p1.position,2,told\ns3,,1,ill\n"
    )
    first, output = run(folder)
    assert "3 set by overrides.csv; see" in output
    assert {student: result.score for student, result in first.items()} == {"s1": 1.76, "s2": 2.0, "s3": 1.0}
    assert find_work_status(first["s3"]) == "missing"
    rows = {row["student"]: row for row in csv.DictReader((folder / "graded" / "grades.csv").read_text().splitlines())}
    assert rows["s1"]["override"] == "p1.position: 1.5 (was 0), <on paper>"
    assert (rows["s1"]["late_penalty"], rows["s1"]["score"]) == ("0.44", "1.76")
    pages = {student: (folder / "graded" / "feedback" / f"{student}.html").read_text() for student in first}
    for words in ("1.5 points: &lt;on paper&gt;", "1 day 1 h", "20 % of your 2.2 points"):
        assert words in pages["s1"]
    assert "2 points for p1.position: told" in pages["s2"] and "1 point in total: ill" in pages["s3"]
    (folder / "assignment.toml").write_text(TOML.format(RULE).replace('"T"', '"another title"'))
    submit_answers(folder, released, "s1/hw.ipynb", 25, position="blank", determinant="blank")
    again, _ = run(folder)
    assert {student: result.score for student, result in again.items()} == {"s1": 1.2, "s2": 2.0, "s3": 1.0}


def test_a_comment_becomes_no_formula_and_no_markup(folder: Path) -> None:
    assignment = load_assignment(folder)
    result = attempt(assignment, -1, 0.0, 0.7, total=make_override(1, "=1+1 <b>\x07"))
    page = make_feedback_page(assignment, assignment.roster[0], replace(result, obstacle="it can't be read"))
    assert "=1+1 &lt;b&gt;␇" in page
    result = replace(result, override=Override(1, "", 0.7))
    (row,) = csv.DictReader(make_grades_csv([result], assignment.roster).splitlines())
    assert row["override"] == "total: 1 (was 0.7)"
