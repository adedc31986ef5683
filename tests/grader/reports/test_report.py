"""The class report: its statistics compared with NumPy and hand calculations, similar answers, and its page."""

import itertools
import json
import re
import stat
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from qdot.exercises.arm.chain import CONVENTIONS
from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.store import store_problems
from qdot.exercises.common.json_form import parse_dataclass
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.grader.grading.result import Override, Result
from qdot.grader.judging.verdict import Outcome
from qdot.grader.reports.class_page import make_class_page
from qdot.grader.reports.class_summary import summarize_mistakes, summarize_parts, summarize_scores
from qdot.grader.reports.grades_table import make_results_jsonl
from qdot.grader.statistics import class_statistics
from qdot.grader.statistics.fairness_tests import (
    FEATURES,
    OTHERS_GROUP,
    SCREW_FEATURES,
    compare_groups,
    correct_p_values,
    describe_p_value,
)
from tests.grader.reports.test_feedback import Page
from tests.support.command import run, run_and_fail
from tests.support.results import change_part, make_result
from tests.support.submitting import make_class

ROWS = [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 0, 0], [1, 1, 0], [1, 1, 1], [0, 1, 0], [1, 0, 0], [1, 1, 1], [0, 0, 0]]


def test_discrimination_is_the_correlation_with_the_other_parts() -> None:
    marks = np.array(ROWS, dtype=float)
    for part in range(3):
        discrimination = class_statistics.compute_discrimination(ROWS, part)
        assert discrimination is not None
        other_points = marks.sum(axis=1) - marks[:, part]
        assert discrimination.value == pytest.approx(np.corrcoef(marks[:, part], other_points)[0, 1])
        assert -1 <= discrimination.low < discrimination.value < discrimination.high <= 1
    everybody_has_the_point = [[1, k % 3] for k in range(12)]
    for rows in (ROWS[:9], everybody_has_the_point):
        assert class_statistics.compute_discrimination(rows, 0) is None


def test_reliability_agrees_with_numpy_and_hand_calculation() -> None:
    """By hand: part variances 4/15, 5/18, 5/18, total variance 1.6556, so 3/2 (1 - 0.8222/1.6556) = 0.7550."""
    marks = np.array(ROWS, dtype=float)
    by_numpy = 3 / 2 * (1 - marks.var(axis=0, ddof=1).sum() / marks.sum(axis=1).var(ddof=1))
    assert class_statistics.compute_reliability(ROWS) == pytest.approx(by_numpy)
    same = [[k % 2, k % 2] for k in range(10)]
    assert class_statistics.compute_reliability(same) == pytest.approx(1)
    assert class_statistics.compute_reliability([[1, 1]] * 10) is None
    assert class_statistics.compute_reliability(ROWS[:5]) is None
    assert class_statistics.compute_correlation([1, 1], [1, 2]) is None


def test_the_permutation_test_agrees_with_enumeration() -> None:
    values, groups = [3.0, 5, 6, 8, 1, 2, 4, 7], "aaaabbbb"
    divisions = list(itertools.combinations(range(8), 4))
    sums = [abs(sum(values[i] for i in chosen) - 18) for chosen in divisions]
    exact = sum(total >= abs(22 - 18) for total in sums) / len(divisions)
    p_value = class_statistics.compute_permutation_p_value(values, groups, "seed")
    assert p_value == pytest.approx(exact, abs=0.03)
    assert p_value == class_statistics.compute_permutation_p_value(values, groups, "seed")
    assert class_statistics.compute_permutation_p_value([1, 1, 1, 1], "aabb", "seed") == 1
    assert class_statistics.compute_permutation_p_value([1, 2], "aa", "seed") == 1
    smallest = class_statistics.compute_permutation_p_value([0.0] * 10 + [1.0] * 10, "a" * 10 + "b" * 10, "seed")
    assert smallest == pytest.approx(1 / 5000)  # never 0
    permutations = next(class_statistics._generate_permutations(5, "seed"))[:2].tolist()
    assert permutations == [[1, 2, 3, 4, 0], [0, 3, 1, 2, 4]], "permutations never change"


def test_arms_are_grouped_by_features_of_their_convention() -> None:
    """In a modified table the tilt of the base is the twist of the first row; screws have no frames."""
    shares = [float(k % 4) for k in range(24)]
    groups = {}
    for convention in CONVENTIONS:
        ids = [ProblemId("planar-2r", seed, variation="full", convention=convention) for seed in range(24)]
        entries = compare_groups("p1", [sample_chain(item) for item in ids], shares, "x", has_varied_structure=False)
        groups[convention] = {item.feature: tuple(item.shares_by_group) for item in entries}
    assert "base tilted" in groups["dh"]["base"]
    assert groups["modified-dh"]["base"] == ("base rotated", "base translated")
    assert groups["screws"].keys() <= {*FEATURES, *SCREW_FEATURES}
    assert groups["screws"].keys() & SCREW_FEATURES.keys()


def test_groups_that_are_too_small_are_not_compared() -> None:
    chains = [sample_chain(ProblemId("planar-2r", seed)) for seed in range(12)]
    shares = [100.0 if chain.base.is_world else 10.0 for chain in chains]
    entries = compare_groups("p1", chains, [float(k % 4) for k in range(12)], "x", has_varied_structure=False)
    for entry in entries:
        assert sum(map(len, entry.shares_by_group.values())) == 12
        assert all(len(group_shares) >= 3 for group_shares in entry.shares_by_group.values())
        assert OTHERS_GROUP not in list(entry.shares_by_group)[:-1]
    assert compare_groups("p1", chains, [50.0] * 12, "x", has_varied_structure=False) == []  # equal shares
    assert compare_groups("p1", chains[:2], shares[:2], "x", has_varied_structure=False) == []
    values = [replace(entry, p_value=chance) for entry, chance in zip(entries * 2, (0.01, 0.5), strict=False)]
    corrected = [round(entry.corrected_p_value, 3) for entry in correct_p_values(values)]
    assert corrected == [0.02, 0.5][: len(values)]
    assert "0.040" in describe_p_value(0.04)


@pytest.fixture(scope="module")
def assignment(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    students = [Student(f"s{k}", name) for k, name in enumerate(("Ada", "<script>alert(1)</script>", "Emmy", "Paul"))]
    assignment = make_class(tmp_path_factory.mktemp("report") / "hw", students)
    for student in students:  # as `qdot generate` does, so that they are derived once
        store_problems(assignment, student.id, assignment.generate_problems(student.id))
    return assignment


LONG = "a1*cos(theta1)*cos(theta2) + a2*sin(theta1 - theta2) + 7*a1"


def make_class_results(assignment: Assignment) -> list[Result]:
    """Return results: right in another form, two similar, one overridden, one ungraded."""
    answers = {}
    for student in ("s0", "s1", "s2", "s3"):
        ((_, problem),) = assignment.generate_problems(student)
        answers[student] = [part.answer.write_code() for part in problem.parts]
    odd = "(sin(theta1)*cos(theta2)*a1 - a1*cos(theta1)*sin(theta2))*(theta1 - theta1 + 1)/1"
    first = make_result(assignment, "s0", ["correct", "correct", "correct"], [*answers["s0"][:2], odd])
    hostile = "<img src=x onerror=alert(1)>"
    second = make_result(assignment, "s1", ["correct", "partial", "wrong"], [answers["s1"][0], LONG, hostile])
    third = make_result(assignment, "s2", ["wrong", "partial", "wrong"], [None, LONG, "a1"])
    third = change_part(third, "p1.determinant", mistake="determinant-sign and sine-for-cosine")
    third = change_part(third, "p1.position", override=Override(0.5, "<b>half</b>", 0.0))
    last = make_result(assignment, "s3", ["ungraded", "ungraded", "ungraded"], obstacle="qdot itself <failed>")
    return [first, second, third, last]


def test_scores_parts_and_mistakes_are_summarized(assignment: Assignment) -> None:
    results = make_class_results(assignment)
    scores = summarize_scores(results)
    assert scores is not None and scores.percents == (100.0, 50.0, 25.0)  # the fourth has no mark
    assert scores.full_score_count == 1
    position, jacobian, determinant = summarize_parts(assignment, results)
    counts = position.outcome_counts
    assert (counts[Outcome.CORRECT], counts[Outcome.WRONG], position.graded_count) == (2, 1, 3)
    assert jacobian.mean_share == pytest.approx(2 / 3)
    assert determinant.discrimination is None
    for mistake, name in zip(summarize_mistakes(results), ("determinant-sign", "sine-for-cosine"), strict=True):
        assert (mistake.name, mistake.students, mistake.parts) == (name, ("s2",), ("p1.determinant",))


def test_the_report_is_safe_and_reproducible(assignment: Assignment) -> None:
    results = make_class_results(assignment)
    results[1] = change_part(results[1], "p1.jacobian", mistake="sine-for-cosine")
    text = make_class_page(assignment, results)
    stored = [parse_dataclass(Result, line) for line in make_results_jsonl(results).splitlines()]
    assert text == make_class_page(assignment, stored)
    page = Page(text)
    # Students' text is not markup, and nothing is loaded from elsewhere.
    assert not {tag for tag, _, _ in page.elements} & {"script", "img", "iframe", "object", "link", "b", "failed"}
    attrs = [attrs for _, attrs, _ in page.elements]
    assert not [name for attrs in attrs for name in attrs if name.startswith("on")]
    links = [link for attrs in attrs for name in ("href", "src") if (link := attrs.get(name))]
    ids = [attrs["id"] for attrs in attrs if "id" in attrs]
    assert {link[:1] for link in links} <= {"#"} and {link[1:] for link in links} <= set(ids)
    assert len(ids) == len(set(ids)) and not re.findall(r"url\((?!#)", text)
    assert "<script>alert(1)</script> (s1)" in page.text
    assert "<b>half</b>" in page.text


def test_students_who_ignore_the_arm_are_listed(assignment: Assignment) -> None:
    results = make_class_results(assignment)
    for name in ("p1.position", "p1.jacobian"):
        results[0] = change_part(results[0], name, outcome=Outcome.WRONG, points=0.0, attempt=False)
    listing = Page(make_class_page(assignment, results)).text.split("seem to ignore the student's arm")[1]
    assert "(s0): p1.position, p1.jacobian" in listing
    results[0] = change_part(results[0], "p1.determinant", attempt=True)
    assert "seem to ignore the student's arm" not in make_class_page(assignment, results)


@pytest.mark.parametrize(
    ("outcomes", "message"),
    [
        ([], "No student has a mark yet."),
        (["ungraded"] * 3, "No student has a mark yet."),
        (["correct"] * 3, "the arms do not differ"),
        (["missing"] * 3, "No known mistake explains any of the wrong answers"),
    ],
    ids=["nothing", "ungraded", "right", "blank"],
)
def test_the_report_of_one_student_is_valid(assignment: Assignment, outcomes: Sequence[str], message: str) -> None:
    single = replace(assignment, roster=assignment.roster[:1])
    page = Page(make_class_page(single, [make_result(single, "s0", outcomes)]))
    assert message in page.text
    assert not re.search(r"\bnan\b", page.text)


def test_the_report_command_writes_every_format_and_refuses_stale_results(
    assignment: Assignment, tmp_path: Path
) -> None:
    folder = assignment.folder
    assert "nothing has been graded; run: qdot grade" in run_and_fail("report", folder)
    lines = make_results_jsonl(make_class_results(assignment)).decode().splitlines(keepends=True)
    (folder / "graded").mkdir()
    (folder / "graded" / "results.jsonl").write_text("".join(lines))
    assert "4 students" in run("report", folder)
    page = folder / "graded" / "report.html"
    assert stat.S_IMODE(page.stat().st_mode) == 0o600
    assert run("report", folder, "--report", "csv=-").startswith("student,name,email,p1.position")
    run("report", folder, "--report", f"xlsx={tmp_path / 'x.xlsx'}", "--out", tmp_path / "page.html")
    assert (tmp_path / "page.html").read_bytes() == page.read_bytes()
    assert (tmp_path / "x.xlsx").read_bytes()[:2] == b"PK"

    (folder / "graded" / "results.jsonl").write_text("".join(lines[:3]))
    assert "3 students" in run("report", folder, "--out", tmp_path / "page.html")
    old = json.loads(lines[0])
    del old["problems"][0]["parts"][0]["mistake"]
    (folder / "graded" / "results.jsonl").write_text(json.dumps(old) + "\n")
    assert "another version of qdot wrote the result" in run_and_fail("report", folder)
    (folder / "graded" / "results.jsonl").write_text("".join(lines))
    toml = (folder / "assignment.toml").read_text()
    (folder / "assignment.toml").write_text(toml.replace("[1, 2, 1]", "[1, 2, 2]"))
    assert "assignment.toml has changed since the grading" in run_and_fail("report", folder)
    (folder / "assignment.toml").write_text(toml)
    assert load_assignment(folder).slots[0].points == (1, 2, 1)
