"""Diagnosis of wrong answers: the mistake is named if it is known, for every arm and question; otherwise none is."""

import json
import re
import warnings
from typing import Any

import numpy as np
import pytest

from qdot.exercises.chapter import make_planar_2r, make_scorbot_arm
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.graph import compute_numeric_stages, compute_symbolic_stages, to_sympy_matrix
from qdot.exercises.families import FAMILIES
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.generation import generate, list_questions_of_family
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.mistakes.configurations import SymbolValues, sample_configurations
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.custom import Definition
from qdot.exercises.questions.custom.definition import Texts
from qdot.exercises.questions.results import compute_answer
from qdot.exercises.reference_answers import Expression, Matrix
from qdot.grader.judging.functions import sample_function_arguments
from qdot.grader.sandbox.notebook_process.function_answers import TABLE_PREFIX
from tests.support import DATA, read_cases
from tests.support.judging import diagnose
from tests.support.problems import LONG_ARMS, ask_question
from tests.support.suites import few_or_all_families, select_for_suite
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


@few_or_all_families
def test_mistakes_are_named_and_random_answers_are_not(family: str) -> None:
    counts, missed = sweep([family], (0,), choose_questions(family), few=2, random_count=2)
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


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case['arm']} {case['question']} {case['mistakes']}")
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
