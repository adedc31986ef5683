"""Diagnosis of wrong answers, for every arm and question: a known mistake is named with its place, and no other is.

Answers that are right except for rounding have no mistake. Advice without one is true and reveals no right answer.
"""

import json
import re
import warnings
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import CONVENTIONS
from qdot.exercises.chapter import make_planar_2r, make_scorbot_arm
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.graph import compute_numeric_stages, compute_symbolic_stages, to_sympy_matrix
from qdot.exercises.families import FAMILIES
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.formula.trees import Node, count_nodes, format_tree
from qdot.exercises.generation import generate, list_questions_of_family
from qdot.exercises.mistakes.catalogue import CATALOGUE, apply_mistake
from qdot.exercises.mistakes.configurations import SymbolValues, sample_configurations
from qdot.exercises.mistakes.formula_edits import edit_all_entries, edit_entry
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.custom import Definition
from qdot.exercises.questions.custom.definition import Texts
from qdot.exercises.questions.results import compute_answer
from qdot.exercises.reference_answers import ConditionSet, Expression, Matrix
from qdot.grader.diagnosis.advice import advise
from qdot.grader.diagnosis.formula_mistakes import locate_entries
from qdot.grader.judging.expected_form import read_answer
from qdot.grader.judging.functions import sample_function_arguments
from qdot.grader.judging.judge import judge
from qdot.grader.judging.verdict import Diagnosis, Outcome
from qdot.grader.marking.marking import MarkingRules, mark
from qdot.grader.sandbox.notebook_process.function_answers import TABLE_PREFIX
from tests.support import DATA, read_cases
from tests.support.judging import diagnose
from tests.support.problems import LONG_ARMS, ask_question, get_problem
from tests.support.suites import few_families, few_or_all_families, on_families, sample_for_suite, select_for_suite
from tests.tools.diagnoses import list_parts, sweep

FAMILY_NAMES = list(FAMILIES)
QUESTION_COUNT, LONG_ARM_COUNT = 4, select_for_suite(2, 4)
"""The number of questions tested per family, and per family of six or seven joints; `make diagnoses` tests all."""


def evaluate_reference(part: Part, values: SymbolValues) -> np.ndarray:
    """Return the entries of a reference at N configurations, shape (entries, N)."""
    nodes = [parse_formula(format_expression(entry), frozenset(values)) for entry in part.answer.as_matrix()]
    return evaluate(compile_program(nodes), values, len(next(iter(values.values())))).values


def choose_questions(family: str) -> tuple[str, ...]:
    names, first = [*list_questions_of_family(family)], 3 * FAMILY_NAMES.index(family)
    return tuple(
        names[(first + k * 7) % len(names)] for k in range(LONG_ARM_COUNT if family in LONG_ARMS else QUESTION_COUNT)
    )


@on_families(select_for_suite(("polar-rp",), tuple(FAMILIES)))
def test_mistakes_are_named_and_random_answers_are_not(family: str) -> None:
    counts, missed = sweep([family], (0,), choose_questions(family), max_count=2, random_count=2)
    wrong = counts["named"] + counts["same answer"] + counts["nothing"]
    assert counts["judged right"] == 0, missed
    assert counts["nothing"] <= 0.05 * wrong, missed
    assert counts["random, blamed"] == 0, missed


# --- checked answers ---

PLANAR, SCORBOT = make_planar_2r(), make_scorbot_arm()
CHAPTER_ARMS = {"Example 6.1": PLANAR, "Example 6.3": SCORBOT}
CASES = [json.loads(line) for line in (DATA / "diagnoses.jsonl").read_text(encoding="utf-8").splitlines()]


def diagnose_answer(question: str, answer: str, arm: str = "Example 6.1") -> tuple[str, str]:
    problem = ask_question(question, CHAPTER_ARMS[arm]) if arm in CHAPTER_ARMS else generate(arm, [question])
    diagnosis = diagnose(problem, problem.parts[0], answer, "chapter")
    return ("", "") if diagnosis is None else (" and ".join(diagnosis.mistakes), diagnosis.feedback)


@pytest.mark.parametrize(
    "case", sample_for_suite(CASES, 34), ids=lambda case: f"{case['arm']} {case['question']} {case['mistakes']}"
)
def test_a_mistake_gets_its_true_name(case: dict[str, Any]) -> None:
    """Most of these answers were once given a wrong name, two names, or none; without a name, none is right.

    In the words of a message, … stands for any text in the same sentence.
    """
    mistakes, message = diagnose_answer(case["question"], case["answer"], case["arm"])
    assert mistakes == case["mistakes"], message
    for words in case.get("words", ()):
        assert re.search(re.escape(words).replace(r"\ …\ ", "[^.]*"), message), message


@pytest.mark.parametrize(("family", "formula", "first_mistake"), read_cases("answers")["wrong_signs"])
def test_a_wrong_sign_of_the_whole_answer_is_no_mistake_of_one_link(
    family: str, formula: str, first_mistake: str
) -> None:
    definition = Definition("mine", formula, (Texts("Mine", "x"),))
    problem = generate(f"{family}/1", ["mine"], definitions=[definition])
    answer = (-problem.parts[0].answer.as_matrix()).tolist()
    diagnosis = diagnose(problem, problem.parts[0], str(answer if len(answer) > 1 else answer[0][0]), "seed")
    assert diagnosis is not None and diagnosis.mistakes[0] == first_mistake
    assert "contribution of link" not in diagnosis.feedback


def test_a_wrong_sign_of_a_column_or_part_of_it_is_named() -> None:
    right = to_sympy_matrix(
        compute_answer(compute_symbolic_stages(SCORBOT), ask_question("jacobian", SCORBOT).parts[0])
    )
    wrong = right.copy()
    wrong[:, 1] = -wrong[:, 1]
    assert diagnose_answer("jacobian", str(wrong.tolist()), "Example 6.3")[0] == "column-sign"
    wrong[2, 1] = right[2, 1]  # now only part of the column has the wrong sign
    name, message = diagnose_answer("jacobian", str(wrong.tolist()), "Example 6.3")
    assert name == "term-sign-typed" and "entries (1, 2) and (2, 2)" in message


UNEXPLAINED = ("0", "1", "a1", "theta2", "sin(theta1)", "[1, 2, 3]", "{{{", "", "a1*a2*tan(theta2)")
NEVER_FINITE = ("(sin(theta1) + cos(theta2) + theta1)**9**9**9", "1/0*theta1", "tan(pi/2)")
"""Answers with infinite values, whose infinite tolerance once matched the first mistake."""


@pytest.mark.parametrize("answer", [*UNEXPLAINED, *NEVER_FINITE])
def test_unexplained_answers_have_no_diagnosis_and_raise_no_warning(answer: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert diagnose_answer("determinant", answer) == ("", "")


def test_a_long_set_is_not_compared_with_mistakes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each comparison would take long and delay the class."""
    monkeypatch.setattr("qdot.grader.diagnosis.set_mistakes.judge_parsed", None)
    conditions = ", ".join(f"cos(theta1 + {k}*theta2) = 0" for k in range(60))
    assert diagnose_answer("singular-angles", f"[{conditions}]") == ("", "")


def test_an_answer_with_blanks_is_diagnosed() -> None:
    answer = "[[-a1*s1 - a2*s12, blank], [blank, -a2*c12]]"
    assert diagnose_answer("jacobian", answer)[0] != ""


# --- the catalogue ---


def test_every_mistake_has_a_message_without_formulas_and_a_source() -> None:
    assert len(CATALOGUE) >= 30
    for mistake in CATALOGUE.values():
        words = re.sub(r"{\w+}", "2", mistake.message)
        assert re.fullmatch(r"[A-Z*2{].*[.?)]", words), mistake.name
        assert not re.search(r"sin\(|cos\(|\w\*\w|theta\d", words), mistake.name
        assert re.search(r"6\.\d|appendix|^the product of exponentials$|^$", mistake.source), mistake.name


@few_or_all_families
def test_numeric_derivations_give_the_reference(family: str) -> None:
    """The numeric stages used for mistakes are a third derivation and must agree with the references."""
    for problem, part in list_parts(family, 0, tuple(name for name, question in QUESTIONS.items() if question.compute)):
        if isinstance(part.answer, (Expression, Matrix)):
            values = sample_configurations(problem.chain, part, problem.domain, 3, Stream("right"))
            derived = compute_answer(compute_numeric_stages(problem.chain, values), part)
            expected = evaluate_reference(part, values)
            error = abs(derived - expected.reshape(derived.shape)).max()
            assert error < 1e-9 * max(1.0, abs(expected).max()), part.name


def test_a_sampled_function_is_diagnosed_by_its_values() -> None:
    problem = ask_question("position", PLANAR)
    calls = sample_function_arguments(problem, problem.domain, "points")
    values_at = dict(zip(calls.symbols, np.array(calls.points).T, strict=True))
    a1, a2, theta1, theta2 = (values_at[name] for name in ("a1", "a2", "theta1", "theta2"))
    rows = [a1 * trig(theta1) + a2 * trig(theta2) for trig in (np.cos, np.sin)]
    values = [[[value, 0.0] for value in row] for row in np.array(rows).T.tolist()]
    table = TABLE_PREFIX + json.dumps({"shape": [2], "values": values})
    diagnosis = diagnose(problem, problem.parts[0], table, "s", "points")
    assert diagnosis is not None and diagnosis.mistakes == ("relative-angle",)


C1, S1, C12, S12 = "cos(theta1)", "sin(theta1)", "cos(theta1 + theta2)", "sin(theta1 + theta2)"


def test_relative_angles_in_a_whole_entry_are_one_mistake() -> None:
    entry = parse_formula(f"a1*{C1} + a2*{C12} + a3*cos(theta1 + theta2 + theta3 + pi/6)", {})
    changed = [format_tree(edit.entry) for edit in edit_entry(entry) if edit.mistake == "angles-typed"]
    expected = parse_formula("a1*cos(theta1) + a2*cos(theta2) + a3*cos(theta3 + pi/6)", {})
    assert changed[0] == format_tree(expected)


def test_a_missing_term_is_described_by_its_symbols() -> None:
    entry = parse_formula(f"0.5*{C1} + a2*qd1*{C12} + {S1}*{S12}", {})
    descriptions = {edit.term_words for edit in edit_entry(entry) if edit.mistake == "term-missing"}
    assert descriptions >= {" that contains 0.5", " that contains a2 and qd1", " that contains theta1 and theta2"}
    assert {edit.term_words for edit in edit_entry(entry) if edit.mistake == "trig-typed"} == {""}


def test_entries_are_located_by_row_and_column_or_number() -> None:
    assert locate_entries([(0, 0), (2, 0)], (3, 1)) == "In each of the entries 1 and 3,"
    assert locate_entries([(0, 2)], (1, 3)) == "In entry 3,"
    assert locate_entries([(0, 0)], (1, 1)) == "In your answer,"


def evaluate_rows(rows: list[list[Node]], values: dict[str, np.ndarray]) -> np.ndarray:
    with np.errstate(all="ignore"):
        return evaluate(compile_program([entry for row in rows for entry in row]), values, 4).values


def is_different(values: np.ndarray, right: np.ndarray) -> bool:
    return bool(np.isfinite(values).all()) and not np.allclose(values, right, rtol=1e-9)


def write_rows(part: Part, rows: list[list[Node]]) -> str:
    if part.shape is None:
        return format_tree(rows[0][0])
    return f"[{', '.join('[' + ', '.join(map(format_tree, row)) + ']' for row in rows)}]"


@few_families
def test_every_mistake_in_one_entry_is_diagnosed_on_every_arm(family: str) -> None:
    """Diagnose the first edit of each kind that changes the answer; another name for the same answer counts, too."""
    problem = get_problem(family, 0)
    for part in problem.parts:
        if part.name not in ("position", "jacobian", "determinant"):
            continue
        rows = [list(row) for row in part.answer.parse_trees(problem.domain.roles)]
        values = sample_configurations(problem.chain, part, problem.domain, 4, Stream("finished"))
        right, tried = evaluate_rows(rows, values), set()
        i, j = max(
            ((i, j) for i, row in enumerate(rows) for j in range(len(row))),
            key=lambda at: count_nodes(rows[at[0]][at[1]]),
        )
        for edit in edit_entry(rows[i][j]):
            wrong_rows = [row[:] for row in rows]
            wrong_rows[i][j] = edit.entry
            wrong_values = evaluate_rows(wrong_rows, values)
            if edit.mistake in tried or not is_different(wrong_values, right):
                continue
            if np.ptp(wrong_values[i * len(rows[0]) + j]) < 1e-9:  # a constant, which many mistakes give
                continue
            tried.add(edit.mistake)
            if count_nodes(edit.entry) > 150:
                continue
            answer = write_rows(part, wrong_rows)
            assert diagnose(problem, part, answer, "finished") is not None, (part.name, edit.mistake, answer)


@few_families
def test_every_mistake_throughout_an_answer_is_diagnosed_on_every_arm(family: str) -> None:
    problem = get_problem(family, 0)
    part = next(part for part in problem.parts if part.name in ("jacobian", "joint-axes", "link-velocity"))
    rows = [list(row) for row in part.answer.parse_trees(problem.domain.roles)]
    values = sample_configurations(problem.chain, part, problem.domain, 4, Stream("finished"))
    right, tried = evaluate_rows(rows, values), set()
    for name, changed in edit_all_entries(rows):
        wrong_values = evaluate_rows(changed, values)
        if name in tried or not is_different(wrong_values, right):
            continue
        tried.add(name)
        answer = write_rows(part, changed)
        assert diagnose(problem, part, answer, "finished") is not None, (name, answer)


def test_an_inherited_mistake_is_named_once() -> None:
    """A wrong sign of a twist is named in the joint axes; later parts refer to it."""
    problem = get_problem("elbow-3r", 0)
    names = ("joint-axes", "jacobian", "velocity")
    parts = {part.name: part for part in problem.parts if part.name in names}
    right = compute_symbolic_stages(problem.chain)
    variant = next(answer.variant for answer in apply_mistake(CATALOGUE["twist-sign"], right, parts["joint-axes"]))
    wrong_stages = right.with_mistakes(variant.changes)
    answers = {}
    for name, part in parts.items():
        matrix = to_sympy_matrix(compute_answer(wrong_stages, part))
        answers[name] = str(matrix[0, 0]) if part.shape is None else str(matrix.tolist())
    verdicts = {
        verdict.part: verdict for verdict in mark(problem, answers, secret="s", rules=MarkingRules(Fraction(0)))
    }
    diagnoses = {name: verdicts[name].diagnosis for name in names if name in parts}
    named = [name for name, diagnosis in diagnoses.items() if diagnosis is not None and diagnosis.mistakes]
    assert len(named) == 1, diagnoses
    first = named[0]
    for name, diagnosis in diagnoses.items():
        assert diagnosis is not None
        assert name == first or (diagnosis.inherited == first and "the same mistake as in" in diagnosis.feedback)
        assert name == first or not diagnosis.names


def test_a_missing_square_leaves_the_root_or_twice_the_root() -> None:
    entries = [edit.entry for edit in edit_entry(parse_formula("x^2"), ["x"]) if edit.mistake == "square-missing"]
    assert [format_tree(entry) for entry in entries] == ["x", "(2*x)"]


ROUNDED = (("planar-2r", 3), ("elbow-3r", 1), ("scara-rrrp", 2), ("cylindrical", 1))
ARMS = [(*case, convention) for convention in CONVENTIONS for case in ROUNDED[: select_for_suite(1, 4)]]
ARMS += select_for_suite([("elbow-3r", 1, "screws")], [])
DIGITS = 10


def find_constants(entry: sp.Expr) -> set[sp.Expr]:
    powers = {power for power in entry.atoms(sp.Pow) if power.is_number and not power.is_Rational}
    return powers | ({sp.pi} if entry.has(sp.pi) else set())


def round_constants(entry: sp.Expr) -> sp.Expr:
    return entry.xreplace({constant: constant.evalf(DIGITS) for constant in find_constants(entry)})


def replace_by_fractions(entry: sp.Expr) -> sp.Expr:
    def to_fraction(constant: sp.Expr) -> sp.Rational:
        value = Fraction(str(constant.evalf(DIGITS)))
        return sp.Rational(value.numerator, value.denominator)

    return entry.xreplace({constant: to_fraction(constant) for constant in find_constants(entry)})


def write_answer(part: Part, change: Callable[[sp.Expr], sp.Expr]) -> str:
    rows = [", ".join(format_expression(change(entry)) for entry in row) for row in part.answer.as_matrix().tolist()]
    return rows[0] if part.shape is None else f"[[{'], ['.join(rows)}]]"


def diagnose_rounded(problem: Problem, part: Part, text: str, points: str = "") -> Diagnosis | None:
    if judge(problem, part, text, "rounding").outcome is Outcome.CORRECT:
        return None
    return diagnose(problem, part, text, "rounding", points) or Diagnosis((), "nothing")


@pytest.mark.parametrize("change", [round_constants, replace_by_fractions])
@pytest.mark.parametrize(("family", "seed", "convention"), sample_for_suite(ARMS, 2))
def test_constants_with_ten_digits_are_no_mistake(
    family: str, seed: int, convention: str, change: Callable[[sp.Expr], sp.Expr]
) -> None:
    problem, diagnoses = get_problem(family, seed, convention=convention), {}
    for part in problem.parts:
        if part.answer.is_symbolic and any(map(find_constants, part.answer.as_matrix())):
            diagnosis = diagnose_rounded(problem, part, write_answer(part, change))
            diagnoses[part.name] = diagnosis and (diagnosis.mistakes, diagnosis.feedback)
    assert diagnoses
    assert not {name: diagnosis for name, diagnosis in diagnoses.items() if diagnosis and diagnosis[0]}
    assert convention != "screws" or "Your answer is correct except for rounding. Write exact values" in str(
        diagnoses.get("home-screws")
    )


@pytest.mark.parametrize("digits", [4, DIGITS])
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_singular_sets_with_decimals_for_pi_are_no_mistake(convention: str, digits: int) -> None:
    for family, seed in select_for_suite((("planar-2r", 3),), (("planar-2r", 3), ("scara-rrrp", 2), ("planar-3r", 2))):
        problem = get_problem(family, seed, convention=convention)
        part = problem["singular-angles"]
        assert isinstance(part.answer, ConditionSet)
        text = f"[{', '.join(part.answer.list_pieces())}]".replace("pi", f"{sp.pi.evalf(digits)}")
        diagnosis = diagnose_rounded(problem, part, text)
        assert diagnosis is not None and diagnosis.mistakes == (), text
        assert diagnosis.feedback.startswith("Your answer is correct except for rounding"), text
        incomplete = f"[{', '.join(part.answer.list_pieces()[:1])}]".replace("pi", f"{sp.pi.evalf(digits)}")
        incomplete_diagnosis = diagnose_rounded(problem, part, incomplete)
        assert incomplete_diagnosis is None or not incomplete_diagnosis.feedback.startswith("Right")


@pytest.mark.parametrize("digits", [7, 9])
@pytest.mark.parametrize(("family", "seed", "convention"), sample_for_suite(ARMS, 2))
def test_rounded_values_of_a_function_are_no_mistake(family: str, seed: int, convention: str, digits: int) -> None:
    problem = get_problem(family, seed, convention=convention)
    calls = sample_function_arguments(problem, problem.domain, "points")
    points = np.array(calls.points).T
    values_of, mistakes, messages = dict(zip(calls.symbols, points, strict=True)), {}, set()
    for part in problem.parts:
        if not part.answer.is_symbolic or part.answer.is_direction:
            continue
        rows = part.answer.parse_trees(problem.domain.roles)
        program = compile_program([entry for row in rows for entry in row])
        values = evaluate(program, values_of, points.shape[1]).values.T.real
        with np.errstate(all="ignore"):
            step = 10.0 ** (np.floor(np.log10(np.abs(values))) + 1 - digits)
            rounded = np.where(values == 0, 0, np.round(values / step) * step)
        table = [[[value, 0.0] for value in row] for row in rounded.tolist()]
        content = {"shape": [len(rows), len(rows[0])], "values": table}
        diagnosis = diagnose_rounded(problem, part, TABLE_PREFIX + json.dumps(content), "points")
        table[0][0][0] += 1.0  # now the function is wrong at one configuration
        wrong = diagnose_rounded(problem, part, TABLE_PREFIX + json.dumps(content), "points")
        assert wrong is None or "except for rounding" not in wrong.feedback
        if diagnosis is not None:
            messages.add(diagnosis.feedback)
            if diagnosis.mistakes:
                mistakes[part.name] = diagnosis
    assert not mistakes
    assert digits == 9 or any(text.startswith("Your function is correct except for rounding.") for text in messages)


TWO_R = (
    "[[a1*cos(theta1 + {pi}/3) - 0.35*sin(theta1 + theta2 + {pi}/3)],"
    " [a1*sin(theta1 + {pi}/3) {sign} 0.35*cos(theta1 + theta2 + {pi}/3)]]"
)


@pytest.mark.parametrize(("question", "answer", "beginning"), read_cases("answers")["advice"])
def test_advice_names_the_simplest_thing_that_is_wrong(question: str, answer: str, beginning: str) -> None:
    problem = ask_question(question, make_planar_2r())
    advice = advise(problem, problem.parts[0], read_answer(problem, problem.parts[0], answer), "advice")
    assert advice is not None and advice.mistakes == ()
    assert advice.feedback.startswith(beginning)


def test_advice_without_joint_angles_names_no_place() -> None:
    problem = get_problem("cartesian", 0)
    part = problem["determinant"]
    advice = advise(problem, part, read_answer(problem, part, "7"), "advice")
    assert advice is not None and advice.feedback.startswith("Draw the arm and calculate the result by hand.")


@pytest.mark.parametrize(("question", "answer"), [("jacobian-size", "12"), ("rank", "[1, 2]"), ("joint-rates", "0.5")])
def test_no_number_is_to_be_checked_in_an_answer_of_the_wrong_shape(question: str, answer: str) -> None:
    problem = ask_question(question, make_planar_2r())
    (part,) = problem.parts
    assert advise(problem, part, read_answer(problem, part, answer), "advice") is None


@pytest.mark.parametrize(
    ("arm", "question", "answer"),
    [
        ("planar-2r/3", "joint-rates", "-0.247, 0.580"), ("planar-2r/3", "manipulability", "0.35 m^2"),
        ("elbow-3r/2", "rank", "1"),
    ],
)  # fmt: skip
def test_numbers_and_counts_get_no_advice_on_factors(arm: str, question: str, answer: str) -> None:
    problem = generate(f"{arm}@chapter", [question])
    advice = advise(problem, problem.parts[0], read_answer(problem, problem.parts[0], answer), "advice")
    assert advice is not None and advice.feedback.startswith("Calculate ")


AXES = "[[0, {sign}s1, {cos}*s1*(1 - c2) + s2*c1], [0, c1, s1*s2 + {cos}*(c1*c2 - c1)], [1, {cos}, c2 + 0.00001*{cos}]]"


@pytest.mark.parametrize(
    ("arm", "question", "answer", "is_rounding"),
    [  # expected: 1.391223934 and 0.3918262811
        ("polar-rp/3@zeros", "joint-rates", "[1.4, 0.39]", True),
        ("polar-rp/3@zeros", "joint-rates", "[1.3, 0.39]", True),  # truncated
        ("polar-rp/3@zeros", "joint-rates", "[1.39, 0.4]", True),
        ("polar-rp/3@zeros", "joint-rates", "[1, 0.4]", False),
        ("polar-rp/3@zeros", "joint-rates", "[1.4, 0.38]", False),
        ("polar-rp/3@zeros", "joint-rates", "[-1.4, 0.39]", False),
        ("planar-2r/3@zeros", "position", TWO_R.format(pi="3.1416", sign="+"), True),
        ("planar-2r/3@zeros", "position", TWO_R.format(pi="3.14", sign="+"), True),
        ("planar-2r/3@zeros", "position", TWO_R.format(pi="3.1416", sign="-"), False),
        ("planar-2r/3@zeros", "position", TWO_R.format(pi="3.2", sign="+"), False),
        ("wrist-zyz/1@chapter", "joint-axes", AXES.format(cos="3.673e-6", sign="-"), True),  # of 1.5708, multiplied out
        ("wrist-zyz/1@chapter", "joint-axes", AXES.format(cos="7.963e-4", sign="-"), True),  # of 1.57
        ("wrist-zyz/1@chapter", "joint-axes", AXES.format(cos="3.673e-6", sign="+"), False),
    ],
)
def test_answers_right_except_for_rounding_are_recognised(
    arm: str, question: str, answer: str, is_rounding: bool
) -> None:
    problem = generate(arm, [question])
    (verdict,) = mark(problem, {question: answer}, secret="s")
    assert verdict.judgement.share < 1 and verdict.diagnosis is not None
    assert verdict.diagnosis.feedback.startswith("Your answer is correct except for rounding.") is is_rounding
    assert not (is_rounding and verdict.diagnosis.mistakes)
    assert "j" not in verdict.judgement.reason.split(": yours")[-1]


@pytest.mark.parametrize(("answer", "words"), read_cases("answers")["advice_on_sets"])
def test_advice_on_joined_conditions_is_true(answer: str, words: str) -> None:
    problem = get_problem("planar-3r", 0, variation="lengths")
    part = problem["singular-angles"]
    advice = advise(problem, part, read_answer(problem, part, answer), "advice")
    assert advice is not None and words in advice.feedback
    assert "whatever the other joints are" not in advice.feedback


def test_marking_gives_advice_if_no_mistake_is_named() -> None:
    problem = get_problem("elbow-3r", 0)
    verdicts = mark(problem, {"determinant": "theta1**2 + 3*theta3"}, secret="s")
    verdict = next(verdict for verdict in verdicts if verdict.part == "determinant")
    assert verdict.diagnosis is not None and verdict.diagnosis.feedback and not verdict.diagnosis.names
