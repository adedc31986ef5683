"""Answers that are right except for rounding: no mistake is named, in every notation and convention."""

import json
from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import CONVENTIONS
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.reference_answers import ConditionSet
from qdot.grader.judging.functions import sample_function_arguments
from qdot.grader.judging.judge import judge
from qdot.grader.judging.verdict import Diagnosis, Outcome
from qdot.grader.sandbox.notebook_process.function_answers import TABLE_PREFIX
from tests.support.judging import diagnose
from tests.support.problems import get_problem
from tests.support.suites import select_for_suite

CASES = (("planar-2r", 3), ("elbow-3r", 1), ("scara-rrrp", 2), ("cylindrical", 1))
ARMS = [(*case, convention) for convention in CONVENTIONS for case in CASES[: select_for_suite(1, 4)]]
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
@pytest.mark.parametrize(("family", "seed", "convention"), ARMS)
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
@pytest.mark.parametrize(("family", "seed", "convention"), ARMS)
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
        if diagnosis is not None:
            messages.add(diagnosis.feedback)
            if diagnosis.mistakes:
                mistakes[part.name] = diagnosis
    assert not mistakes
    assert digits == 9 or any(text.startswith("Your function is correct except for rounding.") for text in messages)
