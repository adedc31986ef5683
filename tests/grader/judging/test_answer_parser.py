"""The door: what an answer is read as in the form that is due, once, and what is refused there."""

import json
from collections import Counter
from contextlib import nullcontext
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import Student
from qdot.exercises.formula.equality import Domain, EntryDifference
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node
from qdot.exercises.generation import generate
from qdot.exercises.notebook.notebook import make_notebook_metadata, make_student_notebook, write_notebook
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.reference_answers import ConditionSet
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.grader.grading import check
from qdot.grader.grading.check import check_notebook, find_claimed_form
from qdot.grader.judging.answer_parser import OR_HINT
from qdot.grader.judging.expected_form import ExpectedForm, find_expected_form, read_answer, read_in_form
from qdot.grader.judging.judge import judge
from qdot.grader.judging.verdict import Outcome
from qdot.grader.marking.marking import mark
from qdot.grader.sandbox.sandbox import Sandbox
from tests.support.judging import judge_direction, judge_expression, judge_numbers, judge_singular
from tests.support.problems import get_problem
from tests.support.submitting import Cells, make_class, make_correct_notebook, submit
from tests.support.suites import select_for_suite

SMALL = select_for_suite(("planar-2r", "polar-rp"), ("planar-2r", "elbow-3r", "polar-rp", "scara"))


@pytest.fixture(autouse=True)
def kept_open(sandbox: Sandbox, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have what is checked run in one sandbox: to start one takes longer than a notebook."""
    monkeypatch.setattr("qdot.grader.grading.check.Sandbox", lambda **_: nullcontext(sandbox))


def test_a_reference_as_it_is_typed_is_read_as_the_tree_that_it_is(problem: Problem) -> None:
    known = problem.domain.roles
    for part in problem.parts:
        given = read_answer(problem, part, part.answer.as_typed())
        assert given.refusal is None, (part.name, given.refusal)
        if part.answer.offered_options:
            assert tuple(sorted(given.chosen)) == tuple(sorted(part.answer.correct_indices))
        elif not part.answer.is_set:
            shape = part.shape or (1, 1)
            assert given.rows is not None and (len(given.rows), len(given.rows[0])) == shape
            if not part.answer.is_numeric:
                assert [list(row) for row in given.rows] == part.answer.parse_trees(known), part.name


@pytest.mark.families(SMALL)
def test_however_wrong_the_answers_are_each_is_read_once(problem: Problem, monkeypatch: pytest.MonkeyPatch) -> None:
    """Judged, credited, diagnosed and followed through; 0,5 alone is read a second time, with a point."""
    seen = Counter[str]()

    def counted(text: str, known: object) -> Node:
        seen[text] += 1
        return parse_formula(text, known)  # type: ignore[arg-type]

    monkeypatch.setattr("qdot.grader.judging.answer_parser.parse_formula", counted)
    answers = {
        part.name: f"2*({part.answer.as_typed()})" if part.shape is None else part.answer.as_typed()
        for part in problem.parts
        if not part.answer.offered_options
    }
    first = next(name for name in answers if "sin" in answers[name])
    answers[first] = answers[first].replace("sin", "cos")
    verdicts = mark(problem, answers, secret="secret")
    assert any(one.judgement.outcome in (Outcome.WRONG, Outcome.PARTIAL) for one in verdicts)
    assert set(seen) == set(answers.values())
    same = Counter(answers.values())
    assert all(seen[text] == same[text] for text in seen)


UNFIT = (
    ("position", "[a1, a1, a1, a1]", "must be"), ("determinant", "[a1, a2]", "asks for a single expression"),
    ("jacobian", "a1", "must be"), ("determinant", "theta1 = a1", "expected a single expression"),
    ("joint-rates", "[a1, theta1]", "asks for numbers"), ("position", "[a1, {a2}]", "itself a list"),
    ("jacobian", "sin(", "couldn't parse"),
)  # fmt: skip


@pytest.mark.parametrize(("kind", "text", "why"), UNFIT)
def test_what_is_no_answer_of_the_form_that_is_due_is_refused(kind: str, text: str, why: str) -> None:
    problem = get_problem("planar-2r", 0)
    part = next(part for part in problem.parts if part.kind == kind)
    given = read_answer(problem, part, text)
    assert given.refusal is not None and why in given.refusal.reason
    assert given.text == text
    assert judge(problem, part, text, "seed") == given.refusal


def test_check_says_of_every_answer_what_the_grader_says_of_its_form(tmp_path: Path) -> None:
    assignment = make_class(tmp_path / "hw", [Student("ada")])
    assert all(
        row.is_readable
        for row in check_notebook(submit(assignment, "a.ipynb", make_correct_notebook(assignment, "ada"))).rows
    )
    typed = {kind: (text, why) for kind, text, why in UNFIT if kind != "joint-rates"}
    assert len(typed) == 3

    def change(cells: Cells) -> None:
        for cell, kind in zip(cells[-3:], ("position", "jacobian", "determinant"), strict=True):
            cell["source"] = f"p1_{kind} = {typed[kind][0]!r}"

    rows = check_notebook(submit(assignment, "b.ipynb", make_correct_notebook(assignment, "ada", change))).rows
    assert len(rows) == 3
    for row in rows:
        assert not row.is_readable and typed[row.part.removeprefix("p1.")][1] in row.message, row


@pytest.mark.parametrize(
    ("text", "is_said"),
    [
        ("theta1 = 90° or -90°, theta3 = 0", True), ("theta1 = 0; theta3 = 0", True), ("theta3 = 0, pi", False),
        ("[Eq(theta1, 0), Eq(theta3, 0)]", False), ("theta1 = 0 and theta3 = 0", False),
    ],
)  # fmt: skip
def test_check_says_how_a_comma_between_conditions_on_other_joints_is_read(text: str, is_said: bool) -> None:
    due = ExpectedForm(ConditionSet(()), Domain({"theta1": "angle", "theta3": "angle"}), ("theta1", "theta3"))
    row = check._check_answer("p1.singular-angles", text, due)
    assert row.is_readable and row.message == text + (f" ({OR_HINT})" if is_said else "")


LENGTHS_WITH_COMMAS = (
    ("d3 = -0,2 m oder θ1 = 0", "d3 = -0.2 or theta1 = 0"),
    ("d3 = 0, 2,5 cm; theta1 = 0", "d3 = 0, 2.5 cm; theta1 = 0"),
    ("d3 = 0,2", ""), ("d3 = 0,2 m, theta1 = 0,180°", ""), ("d3 = 0,1,2 m", ""), ("theta1 = 0,2 m pi", ""),
    ("theta1 = d3 theta1 = pi", ""),
)  # fmt: skip


@pytest.mark.parametrize(("text", "same"), LENGTHS_WITH_COMMAS)
def test_what_may_mean_two_things_has_no_reading_and_a_comma_before_a_unit_means_one(text: str, same: str) -> None:
    due = ExpectedForm(ConditionSet(()), Domain({"theta1": "angle", "d3": "signed"}), ("theta1", "d3"))
    given = read_in_form(due, text)
    assert given.text == text
    assert given.tree == (read_in_form(due, same).tree if same else None)
    assert (given.refusal is None) == bool(same)


def test_check_knows_the_symbols_of_the_students_own_problem(tmp_path: Path) -> None:
    assignment = make_class(tmp_path / "hw", [Student("ada")])

    def checked(text: str, claimed: object = None) -> tuple[bool, str]:
        made = json.loads(
            make_correct_notebook(assignment, "ada", lambda cells: cells[-2].update(source=f"p1_jacobian = {text!r}"))
        )
        if claimed is not None:
            made["metadata"]["qdot"]["symbols"] = claimed
        rows = check_notebook(submit(assignment, "a/hw.ipynb", json.dumps(made))).rows
        return next((row.is_readable, row.message) for row in rows if row.part == "p1.jacobian")

    wrong = "[[x*cos(theta1), a2], [a1, a2*lamda]]"
    readable, reason = checked(wrong)
    assert not readable and reason.startswith("'lamda', 'x' ")
    assert checked("[[a1*cos(theta1), a2], [a1, a2]]")[0]
    claims: tuple[object, ...] = ({"p1": ["theta1", "a1", "a2", "x", "lamda"]}, {"p1": [3]}, {"p1": 5}, {}, 5, [])
    for claimed in (*claims, {"p1": []}):
        assert checked(wrong, claimed)[0], claimed


UNITS = (
    ("-0.1 rad/s, 290 mm/s", ""), ("qd2 = 29 cm/s, qd1 = -100 mrad/s", ""), ("[-0.1, 290 mm/s]", ""),
    ("-0.1 rad/s; 290 mm/s", ""), ("-0.1 rad/s\n0.29 m/s", ""),
    ("-100 mm/s, 0.29", "* mm/s * entry 1 is in rad/s*"), ("-0.1, 290 mrad/s", "* mrad/s * entry 2 is in m/s*"),
    ("qd2 = 290 mrad/s, qd1 = -0.1 rad/s", "* mrad/s * entry 2 is in m/s*"),
    ("-0.1 rad/s, 16°/s", "* °/s * entry 2 is in m/s*"),
)  # fmt: skip


@pytest.mark.parametrize(("text", "why"), UNITS)
def test_units_of_numbers_are_converted_each_where_it_can_be_right(text: str, why: str) -> None:
    problem = generate(ProblemId("polar-rp", 0, ("joint-rates",)))
    given = read_answer(problem, problem["joint-rates"], text)
    if why:
        assert given.refusal is not None and fnmatchcase(given.refusal.reason, why)
    else:
        assert given.refusal is None
        values = evaluate(compile_program(given.entries), {}, 1)
        assert [round(float(value[0].real), 6) for value in values[0]] == [-0.1, 0.29]


MEANT = {"vx": "vx", "v_y": "vy", "vz": "vz", "ẏ": "vy", "z_dot": "vz"}


@pytest.mark.parametrize("seed", select_for_suite((0, 1), range(4)))
def test_check_knows_which_component_of_a_velocity_the_student_is_asked(tmp_path: Path, seed: int) -> None:
    problem = generate(ProblemId("elbow-3r", seed, ("velocity-component",)))
    part = problem["velocity-component"]
    (asked,) = ALL_QUESTIONS[part.kind].list_names_to_type(problem.chain, part)
    file = tmp_path / "hw.ipynb"
    for name, meant in MEANT.items():
        answer = f"{name} = a1 qd1"
        given = read_answer(problem, part, answer)
        notebook = make_student_notebook("T", "hw", "ada", [("p1", problem)])
        (cell,) = (cell for cell in notebook.cells if "qdot" in cell.metadata)
        cell.source = f"p1_velocity_component = {answer!r}"
        file.write_text(write_notebook(notebook), encoding="utf-8")
        (row,) = check_notebook(file).rows
        assert row.is_readable == (given.refusal is None) == (meant == asked)
        assert given.refusal is None or (asked in row.message and row.message == given.refusal.reason)
        assert given.refusal is not None or row.message == answer


def test_a_notebook_says_in_which_form_its_answers_are_due_as_the_grader_knows_it(problem: Problem) -> None:
    says_its_forms(problem)


@pytest.mark.parametrize("told", ["planar-2r/0@chapter@screws", "scara/0@chapter@modified-dh"])
def test_it_says_so_in_every_convention(told: str) -> None:
    says_its_forms(generate(told, ["position", "jacobian"]))


def says_its_forms(problem: Problem) -> None:
    """Of arms that are drawn with their structure and of own ones, too: nothing is known but what the notebook says."""
    said = json.loads(json.dumps(make_notebook_metadata("student", "hw", "ada", [("p1", problem)])))
    for part in problem.parts:
        due, claimed = find_expected_form(problem, part), find_claimed_form(said, "p1", part.name)
        if part.answer.offered_options:
            assert claimed is None
            continue
        assert claimed is not None and (type(claimed.answer), claimed.answer.shape) == (type(due.answer), part.shape)
        assert claimed.answer.expected_units == part.answer.expected_units
        assert set(claimed.domain.roles) == set(due.domain.roles)
        assert replace(claimed, answer=due.answer, domain=due.domain) == due


FORMS: dict[str, object] = {"type": "matrix", "shape": [2, 2], "labels": [], "columns": []}
UNTOLD: tuple[object, ...] = (
    5, [], {"type": 5}, {"type": "choice"}, {"type": "pickle", "shape": [2, 2]}, {"shape": [2, 2]},
    *(FORMS | {"shape": shape} for shape in (5, [2], ["2", "2"], [2, 1e9], [0, 2], [2, -1], [10**9, 10**9], [[2], 2])),
    FORMS | {"labels": 5}, FORMS | {"columns": [5]}, FORMS | {"metres": "3"},
    {"type": "number", "shape": [2, 1], "units": ["m"]}, {"type": "number", "shape": [2, 1], "units": [1, 2]},
)  # fmt: skip


@pytest.mark.parametrize("form", UNTOLD, ids=str)
def test_what_a_notebook_says_of_forms_may_be_anything(form: object) -> None:
    said: dict[str, object] = {"symbols": {"p1": ["theta1"]}, "joints": {"p1": ["theta1"]}}
    assert find_claimed_form(said | {"answers": {"p1": {"jacobian": FORMS}}}, "p1", "jacobian") is not None
    assert find_claimed_form(said | {"answers": {"p1": {"jacobian": form}}}, "p1", "jacobian") is None
    for key in ("symbols", "joints"):
        for claim in (5, {}, {"p1": 5}, {"p1": [3]}):
            assert (
                find_claimed_form(said | {"answers": {"p1": {"jacobian": FORMS}}, key: claim}, "p1", "jacobian") is None
            )


NAMED_VECTORS = (
    ("planar-2r/0@chapter", "joint-axes", "z0 = [0, 0, 1], z1 = [0, 0, 1]"),
    ("planar-2r/0@chapter@modified-dh", "joint-axes", "z_2: [0, 0, 1]; z_1: [0, 0, 1]"),
    ("planar-2r/0@chapter@screws", "joint-axes", "omega_2 = [0, 0, 1], omega_1 = [0, 0, 1]"),
    ("scara/23@chapter", "joint-axes", "z0 = z1 = (0,0,1)^T, z2 = z3 = (0,0,-1)^T"),
    ("elbow-3r/5@zeros", "joint-axes", "z0 = (0, 0, 1), z1 = z2 = (cos(θ1+45°), sin(θ1+45°), 0)"),
    ("planar-2r/15@lengths@screws", "home-screws", "S1 = (0,0,1,0,0,0), S2 = (0,0,1,0,-a1,0)"),
    ("planar-2r/0@chapter@screws", "space-twist", "v = [a1 qd2 s1, -a1 qd2 c1, 0], ω = [0, 0, qd1 + qd2]"),
)  # fmt: skip


@pytest.mark.parametrize(("told", "question", "text"), NAMED_VECTORS)
def test_vectors_stand_for_columns_and_halves_by_their_names_in_every_convention(
    told: str, question: str, text: str
) -> None:
    problem = generate(told, [question])
    assert judge(problem, problem[question], text, "seed").outcome is Outcome.CORRECT


@pytest.mark.parametrize("unit", ["m^3", "m³", "m^(3)", "[m^3]", "(m³)", r"\,\mathrm{m}^3"])
def test_cubic_metres_are_the_unit_of_a_determinant_of_three_linear_rows(unit: str) -> None:
    for family, is_right in (("elbow-3r", True), ("planar-2r", False)):
        problem = generate(ProblemId(family, 0, ("determinant",)))
        part = problem["determinant"]
        given = read_answer(problem, part, f"{part.answer.as_typed()} {unit}")
        assert (given.refusal is None) == is_right and (is_right or "is in m^2" in str(given.refusal))


def test_many_conditions_for_many_values_of_a_whole_number_are_refused() -> None:
    problem = generate("planar-2r/0", ["singular-angles"])
    text = "theta2 = k*pi, " * 5000 + "k = 0" + ", 0" * 5000
    given = read_answer(problem, problem["singular-angles"], text)
    assert given.refusal is not None and "the conditions are too long" in given.refusal.reason


@pytest.mark.parametrize("text", ["[1e999, 0]", "1e999 0", "[[1e999], [0]]", "(1, 1e999)"])
def test_what_stays_a_table_when_it_is_read_as_one_is_refused_once(text: str) -> None:
    problem = generate("polar-rp/0", ["joint-rates", "position"])
    for part in problem.parts:
        given = read_answer(problem, part, text)
        assert given.refusal is not None and "out of range" in given.refusal.reason


@pytest.mark.parametrize("text", ["0.5", "0,5", "０,５", "v = 0.5", "v = 0,5", "50 cm", "50,0 cm", "[0.5]", "1/2 m"])
def test_one_number_may_be_written_as_a_formula_may(text: str) -> None:
    assert judge_numbers(text, [0.5], ["m"], 0.005, 1e-6).outcome is Outcome.CORRECT


@pytest.mark.parametrize("text", ["a1*blank", "x = blank", "lambda theta1: 2*... "])
def test_a_formula_with_a_blank_in_it_is_wrong(text: str) -> None:
    assert judge_expression(text, "a1", Domain({"a1": "length"}), "s").outcome is Outcome.WRONG
    judged = judge_expression("cos(9e399*theta1)", "cos(theta1)", Domain({"theta1": "angle"}), "s")
    assert judged.outcome is Outcome.WRONG, "no double holds the factor"


@pytest.mark.parametrize(
    "text", ["sin(theta2)^4 = 0", "-(a1*sin(theta2)^2)^2", "sqrt(sin(theta2)**6) = 0", "sin(theta2)^0.5"]
)
def test_zeros_of_a_power_are_those_of_its_base(text: str) -> None:
    domain = Domain({"theta1": "angle", "theta2": "angle", "a1": "length"})
    due, joints = ["theta2 = 0", "theta2 = pi"], ["theta1", "theta2"]
    assert judge_singular(text, due, joints, domain, "s").outcome is Outcome.CORRECT
    for other in (text.replace("sin", "cos"), "sin(theta2)^0", "sin(theta2)^-2"):
        assert judge_singular(other, due, joints, domain, "s").outcome is not Outcome.CORRECT


def test_a_direction_is_judged_where_an_entry_vanishes() -> None:
    """Configurations have two decimals, so that 0 comes up in one of some hundred answers."""
    domain, vanishing = Domain({"theta1": "angle"}), 0
    for k in range(1000):
        judged = judge_direction("[-cos(theta1), cos(theta1)]", ["-sin(theta1)", "cos(theta1)"], domain, f"{k}")
        assert judged.outcome is Outcome.WRONG
        example = judged.certificate.counterexample if judged.certificate else None
        assert isinstance(example, EntryDifference) and example.yours != example.expected
        vanishing += example.pivot is None
        assert ("should be 0" in judged.reason) == (example.pivot is None)
    assert vanishing
