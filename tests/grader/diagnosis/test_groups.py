"""Groups of equal wrong answers on different arms: they share a key, and one line of overrides.csv marks them all."""

import csv
import re
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path

import pytest
import sympy as sp

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.common.errors import QdotError
from qdot.exercises.generation import generate
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.reference_answers import Expression
from qdot.grader.cli.main import app
from qdot.grader.diagnosis.groups import KEY_LENGTH, KEY_LETTERS, find_group
from qdot.grader.grading.attempt import make_part_result
from qdot.grader.grading.final_result import GradedNotebook, compute_final_result
from qdot.grader.grading.history import describe_mark_changes
from qdot.grader.grading.overrides import Overrides, describe_unused_groups, read_overrides
from qdot.grader.grading.result import CountingSubmission, MarkingVersions, NotebookMarks, Override, PartResult, Result
from qdot.grader.judging.expected_form import read_answer
from qdot.grader.judging.verdict import Outcome
from qdot.grader.marking.marking import mark
from qdot.grader.reports.class_page import make_class_page
from qdot.grader.reports.class_summary import group_wrong_answers
from qdot.grader.reports.feedback import make_feedback_page
from qdot.grader.reports.grades_table import count_overridden, is_marked, make_grades_csv
from qdot.grader.reports.part_rows import make_part_rows
from tests.support import read_cases
from tests.support.command import runner
from tests.support.results import change_part, make_override, make_result, read_results
from tests.support.submitting import grade, make_class, make_correct_notebook, submit, work_in_one_process
from tests.support.suites import select_for_suite

SECRET = "secret"


def make_problem(family: str, seed: int, question: str, variation: str = "zeros") -> tuple[Problem, Part]:
    problem = generate(ProblemId(family, seed, (question,)).with_variation(variation), [question])
    return problem, problem.parts[0]


def find_key(problem: Problem, part: Part, text: str) -> str | None:
    return find_group(problem, part, read_answer(problem, part, text), None, SECRET)


def multiply_answer(part: Part, factor: str) -> str:
    """Return the right answer times an unrelated factor, not expanded."""
    rows = part.answer.as_matrix().tolist()
    return "[" + ", ".join("[" + ", ".join(f"{factor}*({entry})" for entry in row) + "]" for row in rows) + "]"


@pytest.mark.parametrize(
    ("family", "question"),
    [
        ("planar-2r", "position"), ("planar-2r", "jacobian"), ("elbow-3r", "determinant"), ("elbow-3r", "position"),
        ("polar-rp", "determinant"), ("planar-3r", "jacobian"), ("planar-3r", "twist"),
    ],
)  # fmt: skip
def test_the_same_wrong_formula_on_different_arms_has_one_key(family: str, question: str) -> None:
    """The arms differ in given lengths and joint offsets; another formula has another key."""
    arms = [make_problem(family, seed, question) for seed in range(select_for_suite(4, 8))]
    assert len({problem.chain for problem, _ in arms}) > 2
    keys = {find_key(problem, part, multiply_answer(part, "vx")) for problem, part in arms}
    other_keys = {find_key(problem, part, multiply_answer(part, "vy")) for problem, part in arms}
    assert len(keys) == len(other_keys) == 1 and not keys & other_keys


def test_a_key_is_six_stable_letters() -> None:
    problem, part = make_problem("planar-2r", 1, "determinant")
    letters = find_key(problem, part, "a1 + 1")
    assert letters is not None and len(letters) == KEY_LENGTH and set(letters) <= set(KEY_LETTERS)
    assert letters == find_key(problem, part, "1 + a1")
    answer = read_answer(problem, part, "a1 + 1")
    assert find_group(problem, part, answer, None, "another secret") != letters, "the key depends on the secret"
    (verdict,) = mark(problem, {"determinant": "a1 + 1"}, secret=SECRET)
    assert make_part_result("p1", verdict).group == f"p1.{verdict.part}/{letters}"
    assert mark(problem, {"determinant": "a1 + 1"})[0].group is None
    assert mark(problem, {"determinant": part.answer.write_code()}, secret=SECRET)[0].group is None
    assert mark(problem, {}, secret=SECRET)[0].group is None


@pytest.mark.parametrize(("first", "second", "is_same"), read_cases("answers")["notations"])
def test_the_notation_of_an_answer_does_not_change_its_key(first: str, second: str, is_same: bool) -> None:
    problem, part = make_problem("planar-2r", 1, "determinant", "chapter")
    assert (find_key(problem, part, first) == find_key(problem, part, second)) is is_same


def test_given_lengths_are_recognised_in_decimals_fractions_products_and_sums() -> None:
    """Compare an arm with a1 = 0.6 and a2 = 0.45 with the chapter's, whose lengths are symbols."""
    symbolic, part = make_problem("planar-2r", 1, "determinant", "chapter")
    lengths = sp.Rational(3, 5), sp.Rational(9, 20)
    joints = tuple(replace(joint, a=a) for joint, a in zip(symbolic.chain.joints, lengths, strict=True))
    numeric = generate("planar-2r/1", ["determinant"])
    numeric = replace(numeric, chain=replace(symbolic.chain, joints=joints))
    numeric_part = replace(part, answer=Expression(sp.sympify("27*sin(theta2)/100")))
    for typed, equivalent in (
        ("0.6*cos(theta2)", "a1*cos(theta2)"),
        ("3/5*cos(theta2)", "a1*cos(theta2)"),
        ("-9*cos(theta2)/20", "-a2*cos(theta2)"),
        ("0.27*cos(theta2)", "a1*a2*cos(theta2)"),
        ("(0.36 + 0.54*cos(theta2))*theta1", "(a1**2 + 2*a1*a2*cos(theta2))*theta1"),
        ("1.05*sin(theta2)", "(a1 + a2)*sin(theta2)"),
        ("cos(theta2) - 0.15", "cos(theta2) - (a1 - a2)"),
        ("a1*cos(theta2)", "a1*cos(theta2)"),
        ("0.5*cos(theta2)", "cos(theta2)/2"),
    ):
        assert find_key(numeric, numeric_part, typed) == find_key(symbolic, part, equivalent), typed
    assert find_key(numeric, numeric_part, "sin(0.6*theta2)") != find_key(symbolic, part, "sin(a1*theta2)")


def test_order_and_offsets_of_a_singular_set_do_not_change_its_key() -> None:
    arms = [make_problem("planar-2r", seed, "singular-angles") for seed in range(6)]
    offsets = [problem.chain.offsets[1] for problem, _ in arms]
    assert len(set(offsets)) > 2
    keys = {
        find_key(problem, part, f"{{theta2: [{sp.pi / 3 - offset}, {sp.pi / 5 - offset}]}}")
        for (problem, part), offset in zip(arms, offsets, strict=True)
    }
    assert len(keys) == 1
    problem, part = arms[0]
    assert find_key(problem, part, "theta2 = 1 or theta1 = 2") == find_key(problem, part, "[theta1 = 2, theta2 = 1]")
    assert find_key(problem, part, "theta2 = 1") != find_key(problem, part, "theta2 = 2")


def test_multiples_of_a_direction_have_one_key() -> None:
    problem = generate("planar-2r/1", ["lost-direction"])
    (part,) = problem.parts
    assert part.answer.is_direction
    assert find_key(problem, part, "[theta1, theta2]") == find_key(problem, part, "[-2*theta1, -2*theta2]")
    assert find_key(problem, part, "[theta1, theta2]") != find_key(problem, part, "[theta2, theta1]")


def test_numbers_are_grouped_by_value_and_options_by_text() -> None:
    problem, part = make_problem("planar-2r", 1, "joint-rates")
    keys = [find_key(problem, part, text) for text in ("[0.12345, 7]", "[0.1234, 7.0]", "[0.13, 7]")]
    assert keys[0] == keys[1] != keys[2]
    arms = [make_problem("planar-2r", seed, "singularity-type") for seed in range(12)]
    keys_by_option: dict[object, set[str | None]] = {}
    for problem, part in arms:
        for index, option in enumerate(part.answer.offered_options):
            if index not in part.answer.correct_indices:
                right = tuple(part.answer.offered_options[k] for k in part.answer.correct_indices)
                keys_by_option.setdefault((option, right), set()).add(find_key(problem, part, "ABCDEF"[index]))
    assert len(keys_by_option) > 1 and all(len(keys) == 1 for keys in keys_by_option.values())
    assert len(set.union(*keys_by_option.values())) == len(keys_by_option)


RELATIVE_ANGLES = {
    "position": "[a1*cos(theta1) + {a2}*cos(theta2), a1*sin(theta1) + {a2}*sin(theta2)]",
    "jacobian": "[[-a1*sin(theta1), -{a2}*sin(theta2)], [a1*cos(theta1), {a2}*cos(theta2)]]",
}


def test_a_mistake_is_one_group_with_and_without_follow_through() -> None:
    """Relative angles in J are diagnosed by themselves, or inherited from the position by follow-through."""
    problem = generate(ProblemId("planar-2r", 3, ("position", "jacobian"), variation="chapter"))
    wrong_answers = {name: text.format(a2="a2") for name, text in RELATIVE_ANGLES.items()}
    answers = wrong_answers | {"position": problem["position"].answer.write_code()}, wrong_answers
    by_itself, followed = (mark(problem, student_answers, secret=SECRET)[1] for student_answers in answers)
    assert by_itself.diagnosis is not None and by_itself.diagnosis.mistakes and by_itself.followed_from is None
    assert followed.followed_from == "position"
    assert by_itself.group == followed.group is not None
    other_problem = generate(ProblemId("planar-2r", 4, ("jacobian",), variation="lengths"))
    lengths = [joint.a for joint in other_problem.chain.joints]
    text = re.sub(r"\ba([12])\b", lambda match: f"({lengths[int(match[1]) - 1]})", wrong_answers["jacobian"])
    assert mark(other_problem, {"jacobian": text}, secret=SECRET)[0].group == by_itself.group
    assert any(length.is_number for length in lengths)


def test_the_same_mistake_in_another_place_is_another_group() -> None:
    problem = generate("planar-3r/1", ["jacobian"])
    (part,) = problem.parts
    rows = part.answer.as_matrix()
    verdicts = []
    for column in range(2):
        changed = rows.copy()
        changed[:, column] = sp.zeros(rows.rows, 1)
        verdicts.append(mark(problem, {"jacobian": str(changed.tolist())}, secret=SECRET)[0])
    first, second = verdicts
    assert first.diagnosis is not None and second.diagnosis is not None
    assert first.diagnosis.mistakes == second.diagnosis.mistakes != ()
    assert first.group != second.group


NAMES = ("ada", "bo", "cy", "di")
WRONG_SOURCE = "p1_determinant = ({}) + theta1"


@pytest.fixture
def assignment(tmp_path: Path) -> Assignment:
    """Return a class in which ada, bo and cy give the same wrong determinant for different arms, and di another."""
    assignment = make_class(tmp_path / "hw", [Student(name) for name in NAMES])
    for name in NAMES:
        ((_, problem),) = assignment.generate_problems(name)
        reference = problem["determinant"].answer.write_code()
        source = f"p1_determinant = theta2**2*({reference})" if name == "di" else WRONG_SOURCE.format(reference)
        notebook = make_correct_notebook(assignment, name, lambda cells, s=source: cells[-1].update(source=s))  # type: ignore[misc]
        submit(assignment, f"{name}/hw.ipynb", notebook)
    return assignment


def determinant_result(result: Result) -> PartResult:
    return result.parts["p1.determinant"]


def test_a_line_for_a_group_also_marks_later_submissions(assignment: Assignment) -> None:
    folder = assignment.folder
    late_folder = folder / "submitted" / "cy"
    late_folder.rename(folder / "away")
    first, _ = grade(assignment)
    group = determinant_result(first["ada"]).group
    assert group is not None and group.startswith("p1.determinant/") and group == determinant_result(first["bo"]).group
    assert determinant_result(first["di"]).group not in (None, group)
    assert (determinant_result(first["cy"]).group, first["ada"].parts["p1.position"].group) == (None, None)
    (folder / "overrides.csv").write_text(f'student,part,points,comment,group\n,,50 %,"theta1, again?",{group}\n')
    (folder / "away").rename(late_folder)
    results, _ = grade(assignment)
    for name in ("ada", "bo", "cy"):
        part = determinant_result(results[name])
        assert part.override == Override(0.5, "theta1, again?", 0.0, group)
        assert (part.points, part.outcome, results[name].score) == (0.5, "wrong", 3.5)
    assert determinant_result(results["di"]).override is None

    assert "theta1, again?" in make_feedback_page(assignment, assignment.roster[0], results["ada"])
    ordered = [results[name] for name in NAMES]
    row = next(csv.DictReader(make_grades_csv(ordered, assignment.roster).splitlines()))
    assert row["override"] == "p1.determinant: 0.5 (was 0), theta1, again?" and group in row["note"]
    first_line = describe_mark_changes(first, ordered).splitlines()[0].split()
    assert (first_line[:5], first_line[-1]) == (["ada", "p1.determinant", "0", "→", "0.5"], group)
    changes = {"override": None, "group": None, "points": 1.0, "outcome": Outcome.CORRECT}
    corrected = change_part(results["ada"], "p1.determinant", **changes)
    corrected = replace(corrected, submission=CountingSubmission("hw.ipynb", "another notebook", None))
    first_line = describe_mark_changes(results, [corrected, *ordered[1:]]).splitlines()[0].split()
    assert (first_line[2:5], first_line[-1]) == (["0.5", "→", "1"], group)


def test_a_comment_without_points_changes_no_mark(assignment: Assignment) -> None:
    first, _ = grade(assignment)
    group = determinant_result(first["ada"]).group
    assert group is not None
    letters = group.split("/")[1].upper()
    text = f"student;part;points;comment;group\r\n;p1.determinant;;look at θ1;{letters}\r\nbo;p1.determinant;1;;\r\n"
    (assignment.folder / "overrides.csv").write_bytes(text.encode("utf-16"))
    results, _ = grade(assignment)
    part = determinant_result(results["ada"])
    assert (part.points, part.override) == (0.0, Override(None, "look at θ1", 0.0, group))
    assert determinant_result(results["bo"]).override == Override(1.0, "", 0.0), "a student's own line"
    page = make_feedback_page(assignment, assignment.roster[0], results["ada"])
    assert "look at θ1</strong>" in page and "set by your instructor" not in page
    assert make_part_rows(results["ada"], assignment)[2].message.endswith("look at θ1")
    assert (count_overridden(results["ada"]), count_overridden(results["bo"])) == (0, 1)
    assert not is_marked(replace(results["ada"], submission=None))
    ordered = [results[name] for name in NAMES]
    assert describe_mark_changes({**first, "bo": results["bo"]}, ordered) == describe_mark_changes(results, ordered)


def test_results_without_a_group_are_not_overridden(assignment: Assignment) -> None:
    graded = make_result(assignment, "ada", ["correct", "correct", "wrong"])
    marked = NotebookMarks(sha256="0", made_from=MarkingVersions(), problems=graded.problems)
    overrides = Overrides(by_group={"p1.position/bcdfgh": make_override(0)})
    final = compute_final_result(assignment, assignment.roster[0], [GradedNotebook(marks=marked)], overrides)
    assert final.score == 3


KEY = "p1.position/bcdfgh"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (",,1,x,bcdfgh", "line 2: *'bcdfgh': *"), (",,1,x,p1.position/abc", "line 2: *'p1.position/abc': *"),
        (",,1,x,p1.positon/bcdfgh", "line 2: *'p1.positon' (did you mean 'p1.position'?)*"),
        (f"ada,,1,x,{KEY}", f"line 2: *'ada'*{KEY!r}*"), (f",p1.jacobian,1,x,{KEY}", f"line 2: *{KEY!r}*p1.jacobian*"),
        (f",,,,{KEY}", f"line 2: *points*comment*{KEY!r}*"), (f",,1.5,,{KEY}", "line 2: points = 1.5: *1 points*"),
        (f",,101 %,,{KEY}", "line 2: points = '101 %': *0 to 1*"),
        (f",,1,,{KEY}\n,p1.position,0,,BCDFGH", f"line 3: *{KEY!r}*line 2*"), (",p1.position,1,,", "line 2: * ''*"),
    ],
)  # fmt: skip
def test_a_wrong_line_for_a_group_is_an_error_with_its_line(tmp_path: Path, line: str, message: str) -> None:
    assignment = make_class(tmp_path / "hw", [Student("ada")])
    (assignment.folder / "overrides.csv").write_text(f"student,part,points,comment,group\n{line}\n")
    with pytest.raises(QdotError) as caught:
        read_overrides(assignment)
    assert fnmatchcase(str(caught.value), f"{assignment.folder / 'overrides.csv'}: {message}")


def test_an_empty_group_is_reported_with_the_existing_groups(assignment: Assignment) -> None:
    group, misspelt, empty = "p1.determinant/kqvxwz", "p1.determinant/kqvxwb", "p1.position/bcdfgh"
    by_group = {misspelt: make_override(1.0, "", misspelt), empty: make_override(1.0, "", empty)}
    overrides = Overrides(by_group=by_group)
    first, second = describe_unused_groups(assignment, overrides, [group, "p1.determinant/zzzzzz"])
    path = assignment.folder / "overrides.csv"
    assert first.startswith(f"{path}: ") and f"{misspelt!r} (did you mean {group!r}?)" in first
    assert first.endswith(f"{group}, p1.determinant/zzzzzz; `qdot report` shows all groups")
    assert second.startswith(f"{path}: ") and repr(empty) in second and "p1.determinant" not in second
    assert describe_unused_groups(assignment, overrides, list(by_group)) == []


@pytest.mark.whole
def test_the_class_page_shows_groups_and_grade_reports_unknown_ones(assignment: Assignment) -> None:
    def grade_with_override(points: str, comment: str, group: str) -> tuple[str, list[Result]]:
        line = f"student,part,points,comment,group\n,,{points},{comment},{group}\n"
        (assignment.folder / "overrides.csv").write_text(line)
        with work_in_one_process():
            errors = runner.invoke(app, ["grade", str(assignment.folder), "--jobs", "1"]).stderr
        return errors, list(read_results(assignment.folder).values())

    errors, results = grade_with_override("1", "x", "p1.determinant/bcdfgh")
    assert "overrides.csv: the group 'p1.determinant/bcdfgh'" in errors
    first, second = group_wrong_answers(results)
    assert (first.students, second.students) == (("ada", "bo", "cy"), ("di",))
    assert (first.part, first.points_range, first.max_points) == ("p1.determinant", (0.0, 0.0), 1.0)
    assert first.mistake == "Extra term"
    page = make_class_page(assignment, results)
    assert f'<code class="key">{first.key}</code> <strong>3 students</strong>, earned 0 of 1' in page
    assert page.index(first.key) < page.index("1 answer given by only one student") < page.index(second.key)
    _, results = grade_with_override("1", "fine", first.key)
    page = make_class_page(assignment, results)
    assert "<strong>set to 1</strong>" in page and "fine" in page and page == make_class_page(assignment, results)
    assert "line 2: points = 2: " in grade_with_override("2", "fine", first.key)[0]
