"""The answer parser: what it reads in the expected form, once, and what it refuses."""

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
from qdot.exercises.notebook.notebook import (
    NotebookContent,
    make_notebook_metadata,
    make_student_notebook,
    write_notebook,
)
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.reference_answers import ConditionSet
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.grader.grading import check
from qdot.grader.grading.check import check_notebook, find_claimed_form
from qdot.grader.judging.answer_parser import OR_HINT, read_matrix, read_numbers
from qdot.grader.judging.expected_form import ExpectedForm, find_expected_form, read_answer, read_in_form
from qdot.grader.judging.formulas import judge_matrix
from qdot.grader.judging.judge import judge
from qdot.grader.judging.verdict import Outcome
from qdot.grader.marking.marking import mark
from qdot.grader.sandbox.sandbox import Sandbox
from tests.support import DATA, read_cases
from tests.support.judging import judge_direction, judge_expression, judge_numbers, judge_singular
from tests.support.problems import get_problem
from tests.support.submitting import Cells, make_class, make_correct_notebook, submit
from tests.support.suites import select_for_suite

FEW_FAMILIES = select_for_suite(("planar-2r", "polar-rp"), ("planar-2r", "elbow-3r", "polar-rp", "scara"))


@pytest.fixture(autouse=True)
def reuse_sandbox(sandbox: Sandbox, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let `qdot check` use the shared sandbox: starting one takes longer than running a notebook."""
    monkeypatch.setattr("qdot.grader.grading.check.Sandbox", lambda **_: nullcontext(sandbox))


def test_a_typed_reference_parses_to_its_own_tree(problem: Problem) -> None:
    roles = problem.domain.roles
    for part in problem.parts:
        answer = read_answer(problem, part, part.answer.as_typed())
        assert answer.refusal is None, (part.name, answer.refusal)
        if part.answer.offered_options:
            assert tuple(sorted(answer.chosen_indices)) == tuple(sorted(part.answer.correct_indices))
        elif not part.answer.is_set:
            shape = part.shape or (1, 1)
            assert answer.rows is not None and (len(answer.rows), len(answer.rows[0])) == shape
            if not part.answer.is_numeric:
                assert [list(row) for row in answer.rows] == part.answer.parse_trees(roles), part.name


@pytest.mark.families(FEW_FAMILIES)
def test_each_answer_is_parsed_once(problem: Problem, monkeypatch: pytest.MonkeyPatch) -> None:
    """Wrong answers are judged, credited, diagnosed and followed through after one parse."""
    parse_counts = Counter[str]()

    def parse_and_count(text: str, known: object) -> Node:
        parse_counts[text] += 1
        return parse_formula(text, known)  # type: ignore[arg-type]

    monkeypatch.setattr("qdot.grader.judging.answer_parser.parse_formula", parse_and_count)
    answers = {
        part.name: f"2*({part.answer.as_typed()})" if part.shape is None else part.answer.as_typed()
        for part in problem.parts
        if not part.answer.offered_options
    }
    first = next(name for name in answers if "sin" in answers[name])
    answers[first] = answers[first].replace("sin", "cos")
    verdicts = mark(problem, answers, secret="secret")
    assert any(verdict.judgement.outcome in (Outcome.WRONG, Outcome.PARTIAL) for verdict in verdicts)
    assert set(parse_counts) == set(answers.values())
    answer_counts = Counter(answers.values())
    assert all(parse_counts[text] == answer_counts[text] for text in parse_counts)


REFUSED_ANSWERS = (
    ("position", "[a1, a1, a1, a1]", "must have 2"), ("determinant", "[a1, a2]", "asks for a single expression"),
    ("jacobian", "a1", "must be"), ("determinant", "theta1 = a1", "expected a single expression"),
    ("joint-rates", "[a1, theta1]", "asks for numbers"), ("position", "[a1, {a2}]", "itself a list"),
    ("jacobian", "sin(", "couldn't parse"),
)  # fmt: skip


@pytest.mark.parametrize(("kind", "text", "reason"), REFUSED_ANSWERS)
def test_answers_of_another_form_are_refused(kind: str, text: str, reason: str) -> None:
    problem = get_problem("planar-2r", 0)
    part = next(part for part in problem.parts if part.kind == kind)
    answer = read_answer(problem, part, text)
    assert answer.refusal is not None and reason in answer.refusal.reason
    assert answer.text == text
    assert judge(problem, part, text, "seed") == answer.refusal


def test_check_refuses_what_the_grader_refuses(tmp_path: Path) -> None:
    assignment = make_class(tmp_path / "hw", [Student("ada")])
    assert all(
        row.is_readable
        for row in check_notebook(submit(assignment, "a.ipynb", make_correct_notebook(assignment, "ada"))).rows
    )
    typed = {kind: (text, reason) for kind, text, reason in REFUSED_ANSWERS if kind != "joint-rates"}
    assert len(typed) == 3

    def replace_answers(cells: Cells) -> None:
        for cell, kind in zip(cells[-3:], ("position", "jacobian", "determinant"), strict=True):
            cell["source"] = f"p1_{kind} = {typed[kind][0]!r}"

    rows = check_notebook(submit(assignment, "b.ipynb", make_correct_notebook(assignment, "ada", replace_answers))).rows
    assert len(rows) == 3
    for row in rows:
        assert not row.is_readable and typed[row.part.removeprefix("p1.")][1] in row.message, row


@pytest.mark.parametrize(("text", "is_explained"), read_cases("answers")["commas"])
def test_check_explains_a_comma_between_conditions_on_different_joints(text: str, is_explained: bool) -> None:
    expected_form = ExpectedForm(ConditionSet(()), Domain({"theta1": "angle", "theta3": "angle"}), ("theta1", "theta3"))
    row = check._check_answer("p1.singular-angles", text, expected_form)
    assert row.is_readable and row.message == text + (f" ({OR_HINT})" if is_explained else "")


@pytest.mark.parametrize(("text", "equivalent"), read_cases("answers")["lengths_with_commas"])
def test_decimal_commas_in_lengths_are_parsed_unless_ambiguous(text: str, equivalent: str) -> None:
    expected_form = ExpectedForm(ConditionSet(()), Domain({"theta1": "angle", "d3": "signed"}), ("theta1", "d3"))
    answer = read_in_form(expected_form, text)
    assert answer.text == text
    assert answer.tree == (read_in_form(expected_form, equivalent).tree if equivalent else None)
    assert (answer.refusal is None) == bool(equivalent)


def test_check_knows_the_symbols_of_the_students_problem(tmp_path: Path) -> None:
    assignment = make_class(tmp_path / "hw", [Student("ada")])

    def check_jacobian(text: str, claimed: object = None) -> tuple[bool, str]:
        source = f"p1_jacobian = {text!r}"
        notebook = json.loads(make_correct_notebook(assignment, "ada", lambda cells: cells[-2].update(source=source)))
        if claimed is not None:
            notebook["metadata"]["qdot"]["symbols"] = claimed
        rows = check_notebook(submit(assignment, "a/hw.ipynb", json.dumps(notebook))).rows
        return next((row.is_readable, row.message) for row in rows if row.part == "p1.jacobian")

    wrong = "[[x*cos(theta1), a2], [a1, a2*lamda]]"
    readable, reason = check_jacobian(wrong)
    assert not readable and reason.startswith("'lamda', 'x' ")
    assert check_jacobian("[[a1*cos(theta1), a2], [a1, a2]]")[0]
    claims: tuple[object, ...] = ({"p1": ["theta1", "a1", "a2", "x", "lamda"]}, {"p1": [3]}, {"p1": 5}, {}, 5, [])
    for claimed in (*claims, {"p1": []}):
        assert check_jacobian(wrong, claimed)[0], claimed


@pytest.mark.parametrize(("text", "reason"), read_cases("answers")["units"])
def test_units_are_converted_if_they_fit_the_entry(text: str, reason: str) -> None:
    problem = generate(ProblemId("polar-rp", 0, ("joint-rates",)))
    answer = read_answer(problem, problem["joint-rates"], text)
    if reason:
        assert answer.refusal is not None and fnmatchcase(answer.refusal.reason, reason)
    else:
        assert answer.refusal is None
        values = evaluate(compile_program(answer.entries), {}, 1)
        assert [round(float(value[0].real), 6) for value in values[0]] == [-0.1, 0.29]


@pytest.mark.parametrize(("text", "unit", "value"), json.loads((DATA / "units.json").read_text(encoding="utf-8")))
def test_a_number_may_have_any_unit_of_its_dimension(text: str, unit: str, value: float | None) -> None:
    answer = read_numbers(text, 1, ["v"], [unit])
    if value is None:
        assert answer.refusal is not None and answer.refusal.reason.endswith(
            f"does not fit: the result is in {unit}; use this unit or write only the number"
        )
    else:
        assert answer.refusal is None, answer.refusal
        assert evaluate(compile_program(answer.entries), {}, 1).values[0][0].real == pytest.approx(value, rel=1e-12)


def test_many_units_are_read_in_linear_time() -> None:
    assert read_numbers("1 g " + "g " * 9_000, 1, ["v"], ["kg"]).refusal is not None
    assert read_numbers(", ".join(["1 kN"] * 2_000), 1, ["v"], ["kg"]).refusal is not None


TYPED_COMPONENTS = {"vx": "vx", "v_y": "vy", "vz": "vz", "ẏ": "vy", "z_dot": "vz"}


@pytest.mark.parametrize("seed", select_for_suite((0, 1), range(4)))
def test_check_refuses_the_name_of_another_velocity_component(tmp_path: Path, seed: int) -> None:
    problem = generate(ProblemId("elbow-3r", seed, ("velocity-component",)))
    part = problem["velocity-component"]
    (expected,) = ALL_QUESTIONS[part.kind].list_names_to_type(problem.chain, part)
    path = tmp_path / "hw.ipynb"
    for name, component in TYPED_COMPONENTS.items():
        answer = f"{name} = a1 qd1"
        parsed = read_answer(problem, part, answer)
        notebook = make_student_notebook(NotebookContent("T", "hw", "ada", [("p1", problem)]))
        (cell,) = (cell for cell in notebook.cells if "qdot" in cell.metadata)
        cell.source = f"p1_velocity_component = {answer!r}"
        path.write_text(write_notebook(notebook), encoding="utf-8")
        (row,) = check_notebook(path).rows
        assert row.is_readable == (parsed.refusal is None) == (component == expected)
        assert parsed.refusal is None or (expected in row.message and row.message == parsed.refusal.reason)
        assert parsed.refusal is not None or row.message == answer


def test_a_notebooks_metadata_describes_the_expected_forms(problem: Problem) -> None:
    assert_metadata_describes_forms(problem)


@pytest.mark.parametrize("problem_id", ["planar-2r/0@chapter@screws", "scara/0@chapter@modified-dh"])
def test_metadata_describes_the_expected_forms_in_every_convention(problem_id: str) -> None:
    assert_metadata_describes_forms(generate(problem_id, ["position", "jacobian"]))


def assert_metadata_describes_forms(problem: Problem) -> None:
    """Compare the form that `qdot check` finds in a notebook's metadata with the form that the grader knows."""
    metadata = json.loads(json.dumps(make_notebook_metadata("student", "hw", "ada", [("p1", problem)])))
    for part in problem.parts:
        expected, claimed = find_expected_form(problem, part), find_claimed_form(metadata, "p1", part.name)
        assert claimed is not None and claimed.answer.shape == part.shape
        assert type(claimed.answer) is type(expected.answer)
        assert claimed.answer.expected_units == part.answer.expected_units
        options = part.answer.offered_options
        assert claimed.answer.offered_options == (("",) * len(options) if part.details.has_drawn_options else options)
        assert claimed.answer.matched_items == part.answer.matched_items
        assert set(claimed.domain.roles) == set(expected.domain.roles)
        assert replace(claimed, answer=expected.answer, domain=expected.domain) == expected


def test_metadata_do_not_reveal_the_configurations_in_drawings() -> None:
    problem = generate("planar-2r/1", ["singular-drawing"])
    metadata = json.dumps(make_notebook_metadata("student", "hw", "ada", [("p1", problem)]))
    assert " deg" in problem.parts[0].answer.offered_options[0] and " deg" not in metadata
    assert_metadata_describes_forms(problem)
    form = find_claimed_form(json.loads(metadata), "p1", "singular-drawing")
    assert form is not None and read_in_form(form, "b").chosen_indices == (1,)
    assert read_in_form(form, "z").refusal is not None


FORMS: dict[str, object] = {"type": "matrix", "shape": [2, 2], "labels": [], "columns": []}
INVALID_FORMS: tuple[object, ...] = (
    5, [], {"type": 5}, {"type": "choice"}, {"type": "pickle", "shape": [2, 2]}, {"shape": [2, 2]},
    *(FORMS | {"shape": shape} for shape in (5, [2], ["2", "2"], [2, 1e9], [0, 2], [2, -1], [10**9, 10**9], [[2], 2])),
    FORMS | {"labels": 5}, FORMS | {"columns": [5]}, FORMS | {"metres": "3"},
    {"type": "choice", "options": 5}, {"type": "selection", "options": [1]}, {"type": "choice", "options": ["a"] * 9},
    {"type": "matching", "options": ["a"]},
    {"type": "number", "shape": [2, 1], "units": ["m"]}, {"type": "number", "shape": [2, 1], "units": [1, 2]},
)  # fmt: skip


@pytest.mark.parametrize("form", INVALID_FORMS, ids=str)
def test_invalid_form_metadata_is_ignored(form: object) -> None:
    metadata: dict[str, object] = {"symbols": {"p1": ["theta1"]}, "joints": {"p1": ["theta1"]}}
    assert find_claimed_form(metadata | {"answers": {"p1": {"jacobian": FORMS}}}, "p1", "jacobian") is not None
    assert find_claimed_form(metadata | {"answers": {"p1": {"jacobian": form}}}, "p1", "jacobian") is None
    for key in ("symbols", "joints"):
        for claim in (5, {}, {"p1": 5}, {"p1": [3]}):
            invalid = metadata | {"answers": {"p1": {"jacobian": FORMS}}, key: claim}
            assert find_claimed_form(invalid, "p1", "jacobian") is None


MATRIX_OF_MASS = "[[m*cos(theta1), 1], [0, m]]"


@pytest.mark.parametrize(
    ("text", "is_accepted"),
    [
        (f"M = {MATRIX_OF_MASS}", True), (f"{MATRIX_OF_MASS} = M", True), (f"M(q) = {MATRIX_OF_MASS}", True),
        (f"M(θ) := {MATRIX_OF_MASS}", True), (f"M: {MATRIX_OF_MASS}", True), ("M = m [[c1, 1/m], [0, 1]]", True),
        (r"\mathbf{M} = m \begin{bmatrix} c_1 & \tfrac{1}{m} \\ 0 & 1 \end{bmatrix}", True),
        ("M = [m c1, 1; 0, m]", True), (f"2*M = {MATRIX_OF_MASS}", False), (f"m J = {MATRIX_OF_MASS}", False),
        ("M = 3", False),
    ],
)  # fmt: skip
def test_a_matrix_may_have_the_name_of_a_symbol(text: str, is_accepted: bool) -> None:
    domain = Domain(dict.fromkeys(("m", "theta1"), "signed"))
    answer = read_matrix(text, (2, 2), domain)
    expected = read_matrix(MATRIX_OF_MASS, (2, 2), domain)
    if is_accepted:
        assert answer.refusal is None and expected.rows is not None
        assert judge_matrix(answer, expected.rows, domain, "seed").outcome is Outcome.CORRECT
    else:
        assert answer.refusal is not None and answer.refusal.reason.endswith("write the expression alone")


@pytest.mark.parametrize(("problem_id", "question", "text"), read_cases("answers")["named_vectors"])
def test_named_vectors_are_accepted_in_every_convention(problem_id: str, question: str, text: str) -> None:
    problem = generate(problem_id, [question])
    assert judge(problem, problem[question], text, "seed").outcome is Outcome.CORRECT


@pytest.mark.parametrize("unit", ["m^3", "m³", "m^(3)", "[m^3]", "(m³)", r"\,\mathrm{m}^3"])
def test_a_determinant_of_three_linear_rows_is_in_cubic_metres(unit: str) -> None:
    for family, right_unit in (("elbow-3r", "m^3"), ("planar-2r", "m^2"), ("polar-rp", "m")):
        problem = generate(ProblemId(family, 0, ("determinant",)))
        part = problem["determinant"]
        answer = read_answer(problem, part, f"{part.answer.as_typed()} {unit}")
        if right_unit == "m^3":
            assert answer.refusal is None
        else:
            assert f"is in {right_unit}" in str(answer.refusal)


def test_too_many_conditions_on_an_integer_are_refused() -> None:
    problem = generate("planar-2r/0", ["singular-angles"])
    text = "theta2 = k*pi, " * 5000 + "k = 0" + ", 0" * 5000
    answer = read_answer(problem, problem["singular-angles"], text)
    assert answer.refusal is not None and "the conditions are too long" in answer.refusal.reason


@pytest.mark.parametrize("text", ["[1e999, 0]", "1e999 0", "[[1e999], [0]]", "(1, 1e999)"])
def test_numbers_out_of_range_are_refused(text: str) -> None:
    problem = generate("polar-rp/0", ["joint-rates", "position"])
    for part in problem.parts:
        answer = read_answer(problem, part, text)
        assert answer.refusal is not None and "out of range" in answer.refusal.reason


@pytest.mark.parametrize("text", ["0.5", "0,5", "０,５", "v = 0.5", "v = 0,5", "50 cm", "50,0 cm", "[0.5]", "1/2 m"])
def test_a_number_may_be_written_in_many_ways(text: str) -> None:
    assert judge_numbers(text, [0.5], ["m"], 0.005, 1e-6).outcome is Outcome.CORRECT


@pytest.mark.parametrize("text", ["a1*blank", "x = blank", "lambda theta1: 2*... "])
def test_a_formula_with_a_blank_is_wrong(text: str) -> None:
    assert judge_expression(text, "a1", Domain({"a1": "length"}), "s").outcome is Outcome.WRONG
    judged = judge_expression("cos(9e399*theta1)", "cos(theta1)", Domain({"theta1": "angle"}), "s")
    assert judged.outcome is Outcome.WRONG, "the factor overflows"


@pytest.mark.parametrize(
    "text", ["sin(theta2)^4 = 0", "-(a1*sin(theta2)^2)^2", "sqrt(sin(theta2)**6) = 0", "sin(theta2)^0.5"]
)
def test_a_power_has_the_zeros_of_its_base(text: str) -> None:
    domain = Domain({"theta1": "angle", "theta2": "angle", "a1": "length"})
    reference, joints = ["theta2 = 0", "theta2 = pi"], ["theta1", "theta2"]
    assert judge_singular(text, reference, joints, domain, "s").outcome is Outcome.CORRECT
    for wrong_text in (text.replace("sin", "cos"), "sin(theta2)^0", "sin(theta2)^-2"):
        assert judge_singular(wrong_text, reference, joints, domain, "s").outcome is not Outcome.CORRECT


def test_a_direction_is_judged_where_its_pivot_vanishes() -> None:
    """Sampled configurations have two decimals, so an entry vanishes in one of a few hundred answers."""
    domain, vanishing_count = Domain({"theta1": "angle"}), 0
    for k in range(1000):
        judged = judge_direction("[-cos(theta1), cos(theta1)]", ["-sin(theta1)", "cos(theta1)"], domain, f"{k}")
        assert judged.outcome is Outcome.WRONG
        example = judged.certificate.counterexample if judged.certificate else None
        assert isinstance(example, EntryDifference) and example.yours != example.expected
        vanishing_count += example.pivot is None
        assert ("should be 0" in judged.reason) == (example.pivot is None)
    assert vanishing_count


def test_decimal_commas_in_a_cell_are_recognised() -> None:
    """A cell with [0,471, -1,307] sets four whole numbers."""
    problem = generate("planar-2r/1@lengths", ["joint-rates"])
    for text, has_commas in (("[[0], [471], [-1], [307]]", True), ("[[0], [471], [1], [-3]]", False)):
        refusal = read_answer(problem, problem.parts[0], text).refusal
        assert refusal is not None and ("decimals with a point" in refusal.reason) == has_commas
