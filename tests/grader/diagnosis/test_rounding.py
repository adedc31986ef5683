"""What is right but for rounding: no mistake is named behind it, however it is written, in every convention."""

import json
from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import CONVENTIONS
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.sympy_text import expression_text
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.reference_answers import ConditionSet
from qdot.grader.judging.functions import make_calls
from qdot.grader.judging.judge import judge
from qdot.grader.judging.verdict import Diagnosis, Outcome
from qdot.grader.sandbox.contained.callables import TABLE_PREFIX
from tests.support.judging import diagnose
from tests.support.problems import get_problem
from tests.support.suites import select_for_suite

CASES = (("planar-2r", 3), ("elbow-3r", 1), ("scara-rrrp", 2), ("cylindrical", 1))
ARMS = [(*case, convention) for convention in CONVENTIONS for case in CASES[: select_for_suite(1, 4)]]
ARMS += select_for_suite([("elbow-3r", 1, "screws")], [])
DIGITS = 10


def _constants(entry: sp.Expr) -> set[sp.Expr]:
    powers = {power for power in entry.atoms(sp.Pow) if power.is_number and not power.is_Rational}
    return powers | ({sp.pi} if entry.has(sp.pi) else set())


def _as_decimals(entry: sp.Expr) -> sp.Expr:
    return entry.xreplace({constant: constant.evalf(DIGITS) for constant in _constants(entry)})


def _as_fractions(entry: sp.Expr) -> sp.Expr:
    def fraction(constant: sp.Expr) -> sp.Rational:
        value = Fraction(str(constant.evalf(DIGITS)))
        return sp.Rational(value.numerator, value.denominator)

    return entry.xreplace({constant: fraction(constant) for constant in _constants(entry)})


def _text(part: Part, form: Callable[[sp.Expr], sp.Expr]) -> str:
    rows = [", ".join(expression_text(form(entry)) for entry in row) for row in part.answer.as_matrix().tolist()]
    return rows[0] if part.shape is None else f"[[{'], ['.join(rows)}]]"


def _of_rounding(problem: Problem, part: Part, text: str, points: str = "") -> Diagnosis | None:
    """Return what is said of a text that is not right, and of none that is."""
    if judge(problem, part, text, "rounding").outcome is Outcome.CORRECT:
        return None
    return diagnose(problem, part, text, "rounding", points) or Diagnosis((), "nothing")


@pytest.mark.parametrize("form", [_as_decimals, _as_fractions])
@pytest.mark.parametrize(("family", "seed", "convention"), ARMS)
def test_constants_of_ten_digits_are_no_mistake(
    family: str, seed: int, convention: str, form: Callable[[sp.Expr], sp.Expr]
) -> None:
    problem, said = get_problem(family, seed, convention=convention), {}
    for part in problem.parts:
        if part.answer.is_symbolic and any(map(_constants, part.answer.as_matrix())):
            found = _of_rounding(problem, part, _text(part, form))
            said[part.name] = found and (found.mistakes, found.says)
    assert said
    assert not {name: told for name, told in said.items() if told and told[0]}
    assert convention != "screws" or "Your answer is correct except for rounding. Write exact values" in str(
        said.get("home-screws")
    )


@pytest.mark.parametrize("digits", [4, DIGITS])
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_singular_sets_with_decimals_for_pi_are_no_mistake(convention: str, digits: int) -> None:
    for family, seed in select_for_suite((("planar-2r", 3),), (("planar-2r", 3), ("scara-rrrp", 2), ("planar-3r", 2))):
        problem = get_problem(family, seed, convention=convention)
        part = problem["singular-angles"]
        assert isinstance(part.answer, ConditionSet)
        text = f"[{', '.join(part.answer.pieces())}]".replace("pi", f"{sp.pi.evalf(digits)}")
        found = _of_rounding(problem, part, text)
        assert found is not None
        assert (found.mistakes, found.says.startswith("Your answer is correct except for rounding")) == ((), True), text
        missed = f"[{', '.join(part.answer.pieces()[:1])}]".replace("pi", f"{sp.pi.evalf(digits)}")
        other = _of_rounding(problem, part, missed)
        assert other is None or not other.says.startswith("Right")


@pytest.mark.parametrize("digits", [7, 9])
@pytest.mark.parametrize(("family", "seed", "convention"), ARMS)
def test_a_function_that_returns_rounded_values_made_no_mistake(
    family: str, seed: int, convention: str, digits: int
) -> None:
    problem = get_problem(family, seed, convention=convention)
    calls = make_calls(problem, problem.domain, "points")
    points = np.array(calls.points).T
    at, named, said = dict(zip(calls.symbols, points, strict=True)), {}, set()
    for part in problem.parts:
        if not part.answer.is_symbolic or part.answer.counts_up_to_a_factor:
            continue
        rows = part.answer.parse_trees(problem.domain.roles)
        values = evaluate(compile_program([entry for row in rows for entry in row]), at, points.shape[1])[0].T.real
        with np.errstate(all="ignore"):
            step = 10.0 ** (np.floor(np.log10(np.abs(values))) + 1 - digits)
            short = np.where(values == 0, 0, np.round(values / step) * step)
        content = {"shape": [len(rows), len(rows[0])], "values": [[[v, 0.0] for v in row] for row in short.tolist()]}
        found = _of_rounding(problem, part, TABLE_PREFIX + json.dumps(content), "points")
        if found is not None:
            said.add(found.says)
            if found.mistakes:
                named[part.name] = found
    assert not named
    assert digits == 9 or any(text.startswith("Your function is correct except for rounding.") for text in said)
