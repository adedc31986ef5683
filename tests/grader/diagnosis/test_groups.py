"""Equal wrong answers of students with different arms have one key, and a line of overrides.csv is for all of them."""

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
from qdot.grader.grading.result import (
    CountingSubmission,
    MarkingVersions,
    NotebookMarks,
    Override,
    PartResult,
    Result,
)
from qdot.grader.judging.expected_form import read_answer
from qdot.grader.judging.verdict import Outcome
from qdot.grader.marking.marking import mark
from qdot.grader.reports.class_page import make_class_page
from qdot.grader.reports.class_view import group_wrong_answers
from qdot.grader.reports.feedback import make_feedback_page
from qdot.grader.reports.rows import make_rows
from qdot.grader.reports.tables import count_overridden, is_marked, make_grades_csv
from tests.support.command import runner
from tests.support.results import change_part, make_override, make_result, read_results
from tests.support.submitting import grade, make_class, make_correct_notebook, submit, work_in_one_process
from tests.support.suites import select_for_suite

SECRET = "secret"


def problem(family: str, seed: int, question: str, variation: str = "zeros") -> tuple[Problem, Part]:
    made = generate(ProblemId(family, seed, (question,)).with_variation(variation), [question])
    return made, made.parts[0]


def key(made: Problem, part: Part, text: str) -> str | None:
    """Return the group of an answer behind which no mistake is looked for."""
    return find_group(made, part, read_answer(made, part, text), None, SECRET)


def spoilt(part: Part, factor: str) -> str:
    """Return the right answer times something that it has no business with, not multiplied out."""
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
    """Of arms whose given lengths and zeros of joints differ; another formula has another key."""
    arms = [problem(family, seed, question) for seed in range(select_for_suite(4, 8))]
    assert len({made.chain for made, _ in arms}) > 2
    keys = {key(made, part, spoilt(part, "vx")) for made, part in arms}
    others = {key(made, part, spoilt(part, "vy")) for made, part in arms}
    assert len(keys) == len(others) == 1 and not keys & others


def test_a_key_is_letters_that_are_the_same_for_good() -> None:
    made, part = problem("planar-2r", 1, "determinant")
    letters = key(made, part, "a1 + 1")
    assert letters is not None and len(letters) == KEY_LENGTH and set(letters) <= set(KEY_LETTERS)
    assert letters == key(made, part, "1 + a1")
    given = read_answer(made, part, "a1 + 1")
    assert find_group(made, part, given, None, "another secret") != letters, "nobody can work out who shares a key"
    (verdict,) = mark(made, {"determinant": "a1 + 1"}, secret=SECRET)
    assert make_part_result("p1", verdict).group == f"p1.{verdict.part}/{letters}"
    assert mark(made, {"determinant": "a1 + 1"})[0].group is None
    assert mark(made, {"determinant": part.answer.write_code()}, secret=SECRET)[0].group is None
    assert mark(made, {}, secret=SECRET)[0].group is None


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("theta1*a1*a2", "a2*a1*theta1", True), ("2*sin(theta2)*cos(theta2)", "sin(2*theta2)", True),
        ("0.5*a1*theta1", "a1/2*theta1", True), ("a1*sqrt(theta1 + a1)", "sqrt(a1 + theta1)*a1", True),
        ("a1*sqrt(theta1 + a1)", "a1*sqrt(theta1 - a1)", False), ("a1*theta1", "a1*theta2", False),
        ("a1*sin(theta1)", "a1*sin(theta1 + pi/2)", False), ("I do ( not know", "I do (not  know", True),
        ("I do ( not know", "I (do not know", False),
    ],
)  # fmt: skip
def test_answers_are_the_same_however_they_are_written(one: str, other: str, same: bool) -> None:
    made, part = problem("planar-2r", 1, "determinant", "chapter")
    assert (key(made, part, one) == key(made, part, other)) is same


def test_lengths_are_undone_as_decimals_fractions_products_and_sums() -> None:
    """An arm with a1 = 0.6 and a2 = 0.45 against the chapter's, whose lengths are symbols."""
    plain, part = problem("planar-2r", 1, "determinant", "chapter")
    joints = (replace(plain.chain.joints[0], a=sp.Rational(3, 5)), replace(plain.chain.joints[1], a=sp.Rational(9, 20)))
    made = generate("planar-2r/1", ["determinant"])
    made = replace(made, chain=replace(plain.chain, joints=joints))
    own = replace(part, answer=Expression(sp.sympify("27*sin(theta2)/100")))
    for given, meant in (
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
        assert key(made, own, given) == key(plain, part, meant), given
    assert key(made, own, "sin(0.6*theta2)") != key(plain, part, "sin(a1*theta2)")


def test_singular_sets_are_the_same_in_any_order_and_from_any_zero() -> None:
    arms = [problem("planar-2r", seed, "singular-angles") for seed in range(6)]
    offsets = [made.chain.offsets[1] for made, _ in arms]
    assert len(set(offsets)) > 2
    keys = {
        key(made, part, f"{{theta2: [{sp.pi / 3 - offset}, {sp.pi / 5 - offset}]}}")
        for (made, part), offset in zip(arms, offsets, strict=True)
    }
    assert len(keys) == 1
    made, part = arms[0]
    assert key(made, part, "theta2 = 1 or theta1 = 2") == key(made, part, "[theta1 = 2, theta2 = 1]")
    assert key(made, part, "theta2 = 1") != key(made, part, "theta2 = 2")


def test_a_direction_is_the_same_as_its_multiples() -> None:
    made = generate("planar-2r/1", ["lost-direction"])
    (part,) = made.parts
    assert part.answer.counts_up_to_a_factor
    assert key(made, part, "[theta1, theta2]") == key(made, part, "[-2*theta1, -2*theta2]")
    assert key(made, part, "[theta1, theta2]") != key(made, part, "[theta2, theta1]")


def test_numbers_and_options_are_the_same_by_value_and_by_what_they_say() -> None:
    made, part = problem("planar-2r", 1, "joint-rates")
    assert key(made, part, "[0.12345, 7]") == key(made, part, "[0.1234, 7.0]") != key(made, part, "[0.13, 7]")
    arms = [problem("planar-2r", seed, "singularity-type") for seed in range(12)]
    said: dict[object, set[str | None]] = {}
    for made, part in arms:
        for index, option in enumerate(part.answer.offered_options):
            if index not in part.answer.correct_indices:
                right = tuple(part.answer.offered_options[k] for k in part.answer.correct_indices)
                said.setdefault((option, right), set()).add(key(made, part, "ABCDEF"[index]))
    assert len(said) > 1 and all(len(keys) == 1 for keys in said.values())
    assert len(set.union(*said.values())) == len(said)


RELATIVE = {
    "position": "[a1*cos(theta1) + {a2}*cos(theta2), a1*sin(theta1) + {a2}*sin(theta2)]",
    "jacobian": "[[-a1*sin(theta1), -{a2}*sin(theta2)], [a1*cos(theta1), {a2}*cos(theta2)]]",
}


def test_the_same_mistake_is_one_group_also_where_it_was_found_before_or_followed() -> None:
    """Relative for absolute angles in the position, then in J: found in J itself, or earned by follow-through."""
    made = generate(ProblemId("planar-2r", 3, ("position", "jacobian"), variation="chapter"))
    wrong = {name: text.format(a2="a2") for name, text in RELATIVE.items()}
    answers = ({"position": made["position"].answer.write_code(), "jacobian": wrong["jacobian"]}, wrong)
    by_itself, followed = (mark(made, each, secret=SECRET)[1] for each in answers)
    assert by_itself.diagnosis is not None and by_itself.diagnosis.mistakes and by_itself.followed_from is None
    assert followed.followed_from == "position"
    assert by_itself.group == followed.group is not None
    other = generate(ProblemId("planar-2r", 4, ("jacobian",), variation="lengths"))
    lengths = [joint.a for joint in other.chain.joints]
    text = re.sub(r"\ba([12])\b", lambda number: f"({lengths[int(number[1]) - 1]})", wrong["jacobian"])
    assert mark(other, {"jacobian": text}, secret=SECRET)[0].group == by_itself.group
    assert any(length.is_number for length in lengths)


def test_the_same_mistake_in_another_place_is_another_group() -> None:
    made = generate("planar-3r/1", ["jacobian"])
    (part,) = made.parts
    rows = part.answer.as_matrix()
    verdicts = []
    for column in range(2):
        changed = rows.copy()
        changed[:, column] = sp.zeros(rows.rows, 1)
        verdicts.append(mark(made, {"jacobian": str(changed.tolist())}, secret=SECRET)[0])
    one, other = verdicts
    assert one.diagnosis is not None and other.diagnosis is not None
    assert one.diagnosis.mistakes == other.diagnosis.mistakes != ()
    assert one.group != other.group


NAMES = ("ada", "bo", "cy", "di")
WRONG = "p1_determinant = ({}) + theta1"


@pytest.fixture
def assignment(tmp_path: Path) -> Assignment:
    """A class in which ada, bo and cy give the same wrong determinant of different arms, and di another."""
    made = make_class(tmp_path / "hw", [Student(name) for name in NAMES])
    for name in NAMES:
        ((_, own),) = made.generate_problems(name)
        reference = own["determinant"].answer.write_code()
        source = f"p1_determinant = theta2**2*({reference})" if name == "di" else WRONG.format(reference)
        notebook = make_correct_notebook(made, name, lambda cells, s=source: cells[-1].update(source=s))  # type: ignore[misc]
        submit(made, f"{name}/hw.ipynb", notebook)
    return made


def determinant(result: Result) -> PartResult:
    return result.parts["p1.determinant"]


def test_a_line_marks_and_explains_a_group_also_for_who_comes_later(assignment: Assignment) -> None:
    folder = assignment.folder
    late = folder / "submitted" / "cy"
    late.rename(folder / "away")
    first, _ = grade(assignment)
    group = determinant(first["ada"]).group
    assert group is not None and group.startswith("p1.determinant/") and group == determinant(first["bo"]).group
    assert determinant(first["di"]).group not in (None, group)
    assert (determinant(first["cy"]).group, first["ada"].parts["p1.position"].group) == (None, None)
    (folder / "overrides.csv").write_text(f'student,part,points,comment,group\n,,50 %,"theta1, again?",{group}\n')
    (folder / "away").rename(late)
    results, _ = grade(assignment)
    for name in ("ada", "bo", "cy"):
        part = determinant(results[name])
        assert part.override == Override(0.5, "theta1, again?", 0.0, group)
        assert (part.points, part.outcome, results[name].score) == (0.5, "wrong", 3.5)
    assert determinant(results["di"]).override is None

    assert "theta1, again?" in make_feedback_page(assignment, assignment.roster[0], results["ada"])
    ordered = [results[name] for name in NAMES]
    row = next(csv.DictReader(make_grades_csv(ordered, assignment.roster).splitlines()))
    assert row["override"] == "p1.determinant: 0.5 (was 0), theta1, again?" and group in row["note"]
    first_line = describe_mark_changes(first, ordered).splitlines()[0].split()
    assert (first_line[:5], first_line[-1]) == (["ada", "p1.determinant", "0", "→", "0.5"], group)
    changes = {"override": None, "group": None, "points": 1.0, "outcome": Outcome.CORRECT}
    mended = change_part(results["ada"], "p1.determinant", **changes)
    mended = replace(mended, submission=CountingSubmission("hw.ipynb", "another notebook", None))
    first_line = describe_mark_changes(results, [mended, *ordered[1:]]).splitlines()[0].split()
    assert (first_line[2:5], first_line[-1]) == (["0.5", "→", "1"], group)


def test_a_comment_alone_leaves_the_points(assignment: Assignment) -> None:
    first, _ = grade(assignment)
    group = determinant(first["ada"]).group
    assert group is not None
    letters = group.split("/")[1].upper()
    text = f"student;part;points;comment;group\r\n;p1.determinant;;look at θ1;{letters}\r\nbo;p1.determinant;1;;\r\n"
    (assignment.folder / "overrides.csv").write_bytes(text.encode("utf-16"))
    results, _ = grade(assignment)
    part = determinant(results["ada"])
    assert (part.points, part.override) == (0.0, Override(None, "look at θ1", 0.0, group))
    assert determinant(results["bo"]).override == Override(1.0, "", 0.0), "a student's own line"
    page = make_feedback_page(assignment, assignment.roster[0], results["ada"])
    assert "look at θ1</strong>" in page and "set by your instructor" not in page
    assert make_rows(results["ada"])[2].message.endswith("look at θ1")
    assert (count_overridden(results["ada"]), count_overridden(results["bo"])) == (0, 1)
    assert not is_marked(replace(results["ada"], submission=None))
    ordered = [results[name] for name in NAMES]
    assert describe_mark_changes({**first, "bo": results["bo"]}, ordered) == describe_mark_changes(results, ordered)


def test_what_qdot_failed_on_has_no_group_and_old_results_have_none(assignment: Assignment) -> None:
    made = make_result(assignment, "ada", ["correct", "correct", "wrong"])
    marked = NotebookMarks(sha256="0", made_from=MarkingVersions(), problems=made.problems)
    overrides = Overrides(by_group={"p1.position/bcdfgh": make_override(0)})
    one = compute_final_result(assignment, assignment.roster[0], [GradedNotebook(marks=marked)], overrides)
    assert one.score == 3


KEY = "p1.position/bcdfgh"


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (",,1,x,bcdfgh", "line 2: *'bcdfgh': *"), (",,1,x,p1.position/abc", "line 2: *'p1.position/abc': *"),
        (",,1,x,p1.positon/bcdfgh", "line 2: *'p1.positon' (did you mean 'p1.position'?)*"),
        (f"ada,,1,x,{KEY}", f"line 2: *'ada'*{KEY!r}*"), (f",p1.jacobian,1,x,{KEY}", f"line 2: *{KEY!r}*p1.jacobian*"),
        (f",,,,{KEY}", f"line 2: *points*comment*{KEY!r}*"), (f",,1.5,,{KEY}", "line 2: points = 1.5: *1 points*"),
        (f",,101 %,,{KEY}", "line 2: points = '101 %': *0 to 1*"),
        (f",,1,,{KEY}\n,p1.position,0,,BCDFGH", f"line 3: *{KEY!r}*line 2*"), (",p1.position,1,,", "line 2: * ''*"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_a_line_for_a_group_is_told(tmp_path: Path, line: str, said: str) -> None:
    made = make_class(tmp_path / "hw", [Student("ada")])
    (made.folder / "overrides.csv").write_text(f"student,part,points,comment,group\n{line}\n")
    with pytest.raises(QdotError) as caught:
        read_overrides(made)
    assert fnmatchcase(str(caught.value), f"{made.folder / 'overrides.csv'}: {said}")


def test_a_group_that_nobody_is_in_is_told_with_those_that_there_are(assignment: Assignment) -> None:
    group, typed, empty = "p1.determinant/kqvxwz", "p1.determinant/kqvxwb", "p1.position/bcdfgh"
    of_groups = {typed: make_override(1.0, "", typed), empty: make_override(1.0, "", empty)}
    overrides = Overrides(by_group=of_groups)
    first, other = describe_unused_groups(assignment, overrides, [group, "p1.determinant/zzzzzz"])
    where = assignment.folder / "overrides.csv"
    assert first.startswith(f"{where}: ") and f"{typed!r} (did you mean {group!r}?)" in first
    assert first.endswith(f"{group}, p1.determinant/zzzzzz; `qdot report` shows all groups")
    assert other.startswith(f"{where}: ") and repr(empty) in other and "p1.determinant" not in other
    assert describe_unused_groups(assignment, overrides, list(of_groups)) == []


@pytest.mark.whole
def test_the_page_shows_groups_with_their_key_and_the_command_tells_an_unknown_one(assignment: Assignment) -> None:
    def settled(points: str, comment: str, group: str) -> tuple[str, list[Result]]:
        line = f"student,part,points,comment,group\n,,{points},{comment},{group}\n"
        (assignment.folder / "overrides.csv").write_text(line)
        with work_in_one_process():
            errors = runner.invoke(app, ["grade", str(assignment.folder), "--jobs", "1"]).stderr
        return errors, list(read_results(assignment.folder).values())

    errors, results = settled("1", "x", "p1.determinant/bcdfgh")
    assert "overrides.csv: the group 'p1.determinant/bcdfgh'" in errors
    first, other = group_wrong_answers(results)
    assert (first.students, other.students) == (("ada", "bo", "cy"), ("di",))
    assert (first.part, first.points_range, first.max_points) == ("p1.determinant", (0.0, 0.0), 1.0)
    assert first.mistake == "Extra term"
    page = make_class_page(assignment, results)
    assert f'<code class="key">{first.key}</code> <strong>3 students</strong>, earned 0 of 1' in page
    assert page.index(first.key) < page.index("1 answer given by only one student") < page.index(other.key)
    _, results = settled("1", "fine", first.key)
    page = make_class_page(assignment, results)
    assert "<strong>set to 1</strong>" in page and "fine" in page and page == make_class_page(assignment, results)
    assert "line 2: points = 2: " in settled("2", "fine", first.key)[0]
