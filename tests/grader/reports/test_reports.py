"""Reports for other programs, parsed as those programs parse them; and grading a single student."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from junitparser import Error, Failure, JUnitXml
from markdown_it import MarkdownIt

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.grader.grading.result import Override, Result
from qdot.grader.judging.verdict import Outcome
from qdot.grader.reports.github import MAX_SUMMARY_BYTES, make_annotations, make_summary
from qdot.grader.reports.grades_table import has_points, make_grades_table
from qdot.grader.reports.gradescope import make_results_json
from qdot.grader.reports.junit import write_junit_xml
from tests.support.command import run, run_and_fail
from tests.support.results import change_part
from tests.support.submitting import (
    Cells,
    code_cell,
    grade,
    make_class,
    make_correct_notebook,
    submit,
    work_in_one_process,
)


@pytest.fixture(scope="module")
def assignment(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    """Return a class of three: Ada is right, Bo has one part half right and one wrong, Cy submitted nothing."""
    assignment = make_class(tmp_path_factory.mktemp("course") / "hw", [Student("ada"), Student("bo"), Student("cy")])

    def add_mistakes(cells: Cells) -> None:
        cells.insert(4, code_cell("p1_jacobian[0, 0] = 0"))
        cells[-1]["source"] = "p1_determinant = a1*a2"

    submit(assignment, "ada/hw.ipynb", make_correct_notebook(assignment, "ada"))
    submit(assignment, "bo/hw.ipynb", make_correct_notebook(assignment, "bo", add_mistakes))
    return assignment


@pytest.fixture(scope="module")
def results(assignment: Assignment) -> list[Result]:
    return list(grade(assignment)[0].values())


def leave_ungraded(result: Result) -> Result:
    return change_part(result, "p1.position", points=None, outcome=Outcome.UNGRADED, reason="qdot failed")


def set_reasons(result: Result, reason: str) -> Result:
    for name in result.parts:
        result = change_part(result, name, reason=reason, points=0.0, outcome=Outcome.WRONG)
    return result


def test_junit_is_valid_for_junitparser(assignment: Assignment, results: list[Result]) -> None:
    hostile = set_reasons(results[2], "a \x1b[2J\x00 <b> ]]> & é \ud800")
    report = JUnitXml.fromstring(
        write_junit_xml(assignment, [results[0], leave_ungraded(results[1]), hostile]).encode()
    )
    cases = [case for suite in report for case in suite]
    names = [(case.classname, case.name) for case in cases]
    assert len(set(names)) == len(names) == 9  # GitLab drops the second of a pair
    assert names[4] == ("hw.bo", "p1.jacobian: Jacobian by differentiation")
    kinds = [[type(outcome) for outcome in case.result] for case in cases]
    assert kinds[:5] == [[], [], [], [Error], [Failure]]
    assert re.match(r"\S+ of 2 points, partial: .*", cases[4].result[0].text)
    assert (report.tests, report.failures, report.errors) == (9, 5, 1)
    assert "<b> ]]> & é" in cases[-1].result[0].text


def test_no_report_shows_points_for_work_that_was_not_graded(assignment: Assignment, results: list[Result]) -> None:
    """Missing work used to have 0 points in some reports, and no mark in others."""
    suite = list(JUnitXml.fromstring(write_junit_xml(assignment, results).encode()))[2]
    assert [prop.name for prop in suite.properties()] == ["max_score"]  # type: ignore[no-untyped-call]
    header, rows = make_grades_table(results, assignment.roster)
    marks = [[row[header.index(name)] for name in ("score", "percent")] for row in rows]
    assert marks[2] == [None, None] and None not in marks[0] + marks[1]
    result = replace(results[2], override=Override(3.0, "", None))
    assert (
        has_points(result) and make_grades_table([result], assignment.roster)[1][0][header.index("score")] is not None
    )


def test_a_summary_contains_no_markup_from_students(assignment: Assignment, results: list[Result]) -> None:
    hostile = "a | b\n\n# c <img src=x> [l](javascript:x) `x` $y$ @me ![i](u) ::error::no"
    page = MarkdownIt("commonmark").enable("table").render(make_summary(assignment, [set_reasons(results[1], hostile)]))
    assert page.count("<tr>") == 4
    assert page.count("<td>") == 15  # five cells in each of three rows
    assert not re.search(r"<(img|a|code|h1)\b", page)
    assert "a | b # c &lt;img src=x&gt;" in page
    summary = make_summary(assignment, results)
    assert "| cy | no mark | 4 | missing |" in summary
    assert summary.count("<details>") == 3


def test_summaries_and_annotations_respect_githubs_limits(assignment: Assignment, results: list[Result]) -> None:
    many = [replace(set_reasons(results[1], "x" * 3000), student=f"s{number}") for number in range(800)]
    page = make_summary(assignment, many)
    assert 900_000 < len(page.encode()) <= MAX_SUMMARY_BYTES
    assert f"The parts of {800 - page.count('<details>')} more students" in page
    assert len(make_summary(assignment, many * 45).encode()) <= MAX_SUMMARY_BYTES
    result = set_reasons(results[1], "100%\r\n::error::forged")
    result = replace(
        result, problems=tuple(replace(result.problems[0], slot=slot) for slot in ("p1", "p2", "p3", "p4"))
    )
    lines = make_annotations(assignment, [result]).splitlines()
    assert len(lines) == 10 and lines[-1].startswith("::error title=hw::and 3 more")
    assert lines[0] == "::error title=p1.position%3A 0 of 1::100%25 ::error::forged"
    assert make_annotations(assignment, results) == ""
    assert "::error title=bo::" in make_annotations(assignment, [results[0], leave_ungraded(results[1])])


def test_reports_have_the_titles_of_own_questions(results: list[Result], tmp_path: Path) -> None:
    question = '[question.why]\ntitle = "Speed of P"\nprompt = "How fast is $P$?"\nanswer = "p.x"\n'
    (make_class(tmp_path / "hw", [Student("ada")]).folder / "assignment.toml").write_text(
        f'title = "T"\nkey = "hw"\n{question}[[problem]]\nfamily = "planar-2r"\nquestions = ["why"]\n'
    )
    assignment, (problem,) = load_assignment(tmp_path / "hw"), results[0].problems
    result = replace(results[0], problems=(replace(problem, parts=(replace(problem.parts[0], name="why"),)),))
    (test,) = json.loads(make_results_json(assignment, [result]))["tests"]
    assert test["name"] == "Speed of P"
    assert 'name="p1.why: Speed of P"' in write_junit_xml(assignment, [result])
    assert "Speed of P" in make_summary(assignment, [result])


def test_gradescope_shows_each_outcome_once(assignment: Assignment, results: list[Result]) -> None:
    outputs = [test["output"] for test in json.loads(make_results_json(assignment, [results[0]]))["tests"]]
    assert "correct" in outputs and not any("right" in output for output in outputs)


def test_gradescope_gets_no_ungraded_or_multiple_results(assignment: Assignment, results: list[Result]) -> None:
    with pytest.raises(QdotError, match="has no mark for"):
        make_results_json(assignment, [leave_ungraded(results[0])])
    with pytest.raises(QdotError, match="contains only one student"):
        make_results_json(assignment, results)


def test_grading_one_student_leaves_the_class_unchanged(assignment: Assignment, tmp_path: Path) -> None:
    folder = assignment.folder
    notebook = submit(assignment, "../elsewhere/mine.ipynb", make_correct_notebook(assignment, "cy"))
    reports = ("--report", f"gradescope={tmp_path / 'r.json'}", "--report", f"github={tmp_path / 's.md'}")
    with work_in_one_process():
        output = run("grade", folder, notebook, "--student", "cy", "--received", "2027-01-09T10:00:00+01:00", *reports)
        assert output == "cy: graded, 4 of 4 points\n"
        assert json.loads((tmp_path / "r.json").read_text())["score"] == 4
        assert not (folder / "graded" / "results.jsonl").exists()
        assert "::warning title=p1.jacobian" in run("grade", folder, "--student", "bo", *reports)
    for arguments, message in (
        (("--report", "gradescope=x"), "--student"), (("--student", "cyy"), "did you mean 'cy'"),
        (("--received", "2027-01-09"), "--received"), (("--student", "cy", "--received", "soon"), "soon"),
        ((tmp_path / "none.ipynb", "--student", "cy"), "none.ipynb"),
    ):  # fmt: skip
        assert message in run_and_fail("grade", folder, *arguments)


@pytest.mark.parametrize("option", ["csv", "csv=", "=grades.csv", ""])
def test_a_report_needs_a_format_and_a_path(option: str, tmp_path: Path) -> None:
    message = run_and_fail("grade", tmp_path, "--report", option)
    assert ("write FORMAT=PATH" if option[:1] != "=" else "--report") in message
