"""Answers that are Python functions: called with symbols if possible, otherwise at random configurations."""

import json
import re
from dataclasses import replace

import pytest
import sympy as sp

from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.problem.problem import Part, Problem, name_answer_variable
from qdot.exercises.reference_answers import Expression, Matrix
from qdot.grader.judging.functions import SAMPLE_COUNT, judge_function, read_table, sample_function_arguments
from qdot.grader.judging.judge import judge
from qdot.grader.judging.verdict import Outcome
from qdot.grader.marking.marking import mark
from qdot.grader.sandbox.notebook_process.function_answers import TABLE_PREFIX
from qdot.grader.sandbox.sandbox import FunctionArguments, Limits, Sandbox
from qdot.grader.submissions.answer_locator import Answers
from tests.support import DATA
from tests.support.problems import get_problem, sample_parts
from tests.support.suites import few_families, select_for_suite

IMPORTS = "import math\nfrom math import cos, sin\nimport numpy as np\nimport sympy as sp"
CALLS = FunctionArguments(
    ("theta1", "theta2"), ("theta1", "theta2", "a1", "a2", "qd1", "qd2"),
    ((0.1, 0.2, 1.0, 2.0, 0.3, 0.4), (0.5, 0.6, 1.0, 3.0, 0.7, 0.8)),
)  # fmt: skip


def run_answer(sandbox: Sandbox, code: str) -> tuple[str | None, str | None]:
    run = sandbox.run([IMPORTS, code], ["p1_a"], {"p1": CALLS})
    assert not run.cell_errors, run.cell_errors
    return run.answers.get("p1_a"), run.unreadable_reasons.get("p1_a")


FUNCTIONS = json.loads((DATA / "functions.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize(("function", "text"), FUNCTIONS["symbolic"])
def test_a_function_that_takes_symbols_becomes_a_formula(sandbox: Sandbox, function: str, text: str) -> None:
    assert run_answer(sandbox, f"p1_a = {function}") == (text, None)


@pytest.mark.parametrize("function", FUNCTIONS["numeric"])
def test_a_function_that_needs_numbers_is_sampled(sandbox: Sandbox, function: str) -> None:
    text, _ = run_answer(sandbox, f"p1_a = {function}")
    assert text is not None
    assert text.startswith(TABLE_PREFIX + '{"shape": [2], "values": [[[0.995')


@pytest.mark.parametrize(("function", "reason"), FUNCTIONS["refused"])
def test_functions_that_are_no_answer_are_refused(sandbox: Sandbox, function: str, reason: str) -> None:
    text, failure = run_answer(sandbox, f"p1_a = {function}")
    assert reason in (failure or "")
    assert text is None or text in ("a1a1", str([0] * 200))


def test_math_and_sympy_are_unchanged_afterwards(sandbox: Sandbox) -> None:
    cells = [
        IMPORTS,
        "p1_a = lambda theta1: cos(theta1)",
        "p1_b = str([math.cos, cos, hasattr(sp.Symbol('x'), 'cos')])",
        "try: p1_c = np.cos(sp.Symbol('x'))\nexcept TypeError: p1_c = 'refused'",
    ]
    run = sandbox.run(cells, ["p1_a", "p1_b", "p1_c"], {"p1": CALLS})
    assert run.answers["p1_b"] == "[<built-in function cos>, <built-in function cos>, False]"
    assert run.answers["p1_c"] == "refused"


def test_an_endless_function_costs_only_its_answer(sandbox: Sandbox) -> None:
    code = "def p1_a(theta1):\n    while True: pass\np1_b = 1"
    with Sandbox(Limits(seconds=30, cell_seconds=0.3)) as strict_sandbox:
        run = strict_sandbox.run([code], ["p1_a", "p1_b"], {"p1": CALLS})
    assert run.answers == {"p1_b": "1"}
    assert run.unreadable_reasons["p1_a"] == "computing the answer took longer than 0.3 s of processor time"


def test_the_counterexample_to_a_function_names_only_relevant_variables(sandbox: Sandbox) -> None:
    problem = get_problem("planar-2r", 3)
    calls = {"p1": sample_function_arguments(problem, problem.domain, "points")}
    run = sandbox.run(["p1_position = lambda theta1, theta2: [0.5 * float(theta1), 1]"], ["p1_position"], calls)
    answers = Answers(run).map_texts("p1", problem)
    verdicts = mark(problem, answers, secret="secret", functions_seed="points")
    (verdict,) = (verdict for verdict in verdicts if verdict.part == "position")
    assert verdict.judgement.certificate is not None
    assert "qd1" not in verdict.judgement.reason
    assert "theta2 = " in verdict.judgement.reason


def test_a_constant_function_with_an_imaginary_part_is_not_correct() -> None:
    problem, axes = get_problem("planar-2r", 3), [[0, 0], [0, 0], [0, 0], [0, 0], [1, 1], [1, 0]]
    table = json.dumps({"shape": [3, 2], "values": [axes] * SAMPLE_COUNT})
    assert judge(problem, problem["joint-axes"], TABLE_PREFIX + table, "seed").outcome is not Outcome.CORRECT


def formula_parts(problem: Problem) -> list[Part]:
    return [part for part in sample_parts(problem) if isinstance(part.answer, (Expression, Matrix))]


VARIATIONS = {
    "symbols": ("return f({names})", Outcome.CORRECT),
    "numbers": ("return np.array(f({names}), dtype=float)", Outcome.CORRECT),
    "a row": ("m = np.array(f({names}), dtype=float); return m.T if 1 in m.shape else m", Outcome.CORRECT),
    "wrong symbols": ("return 1.001 * f({names})", Outcome.WRONG),
    "wrong numbers": ("return np.array(f({names}), dtype=float) * (1 + 1e-6)", Outcome.WRONG),
    "opposite numbers": ("return -np.array(f({names}), dtype=float)", Outcome.WRONG),
    "wrong somewhere": ("return -1 * f({names}) if theta{first} > 0 else f({names})", Outcome.WRONG),
}


@few_families
def test_a_function_gets_the_outcome_of_its_formula(
    problem: Problem, sandbox: Sandbox, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Leave out the diagnosis, which changes no mark; test_diagnosis.py tests it."""
    monkeypatch.setattr("qdot.grader.marking.marking.diagnose", lambda *_: None)
    parts = formula_parts(problem)
    calls = {"p1": sample_function_arguments(problem, problem.domain, "points")}
    names = calls["p1"].symbols
    first = next((name.removeprefix("theta") for name in names if name.startswith("theta")), None)
    for variation, (body, expected) in list(VARIATIONS.items())[:: select_for_suite(2, 1)]:
        if first is None and "{first}" in body:
            continue
        cells = ["from sympy import *\nimport numpy as np", f"{', '.join(names)} = symbols('{' '.join(names)}')"]
        code = body.format(names=", ".join(names), first=first)
        for part in parts:
            cells.append(
                f"f = lambdify([{', '.join(names)}], {part.answer.write_code()}, 'numpy')\n"
                f"def {name_answer_variable('p1', part.name)}({', '.join(names)}, f=f):\n    {code}"
            )
        answer_names = [name_answer_variable("p1", part.name) for part in parts]
        run = sandbox.run(cells, answer_names, calls)
        assert not run.unreadable_reasons, run.unreadable_reasons
        for verdict in mark(problem, Answers(run).map_texts("p1", problem), secret="secret", functions_seed="points"):
            if verdict.part in {part.name for part in parts if not is_zero(part)}:
                outcome = verdict.judgement.outcome
                is_right = outcome is Outcome.CORRECT
                assert is_right == (expected is Outcome.CORRECT) and outcome is not Outcome.UNGRADED, (
                    variation,
                    verdict,
                )


@pytest.mark.parametrize(("factors", "share"), [((-2, 2), 0.6), ((-1, -1), 0.8), ((-1, 1), 0.8), ((2, 2), 0.8)])
def test_a_function_with_wrong_signs_or_a_factor_earns_what_its_formula_earns(
    factors: tuple[int, int], share: float, sandbox: Sandbox
) -> None:
    problem = get_problem("planar-2r", 0, variation="chapter")
    entries = ("a1*cos(theta1) + a2*cos(theta1 + theta2)", "a1*sin(theta1) + a2*sin(theta1 + theta2)")
    text = f"[{', '.join(f'{factor}*({entry})' for factor, entry in zip(factors, entries, strict=True))}]"
    calls = {"p1": sample_function_arguments(problem, problem.domain, "points")}
    code = f"def p1_position(theta1, theta2, a1, a2):\n    return np.array({text}, dtype=float)"
    run = sandbox.run(["import numpy as np\nfrom numpy import cos, sin", code], ["p1_position"], calls)
    for answers in (Answers(run).map_texts("p1", problem), {"position": text}):
        verdicts = mark(problem, answers, secret="secret", functions_seed="points")
        (verdict,) = (verdict for verdict in verdicts if verdict.part == "position")
        assert verdict.points == share * problem["position"].points, verdict


def is_zero(part: Part) -> bool:
    assert isinstance(part.answer, (Expression, Matrix))
    return sp.Matrix([part.answer.reference]).is_zero_matrix is True


def test_a_table_typed_by_a_student_is_wrong(problem: Problem) -> None:
    for part in formula_parts(problem)[:1]:
        domain, joints = problem.domain, [q.name for q in problem.chain.q]
        pairs = ['{"shape": [1], "values": [[["x", 0]]]}', '{"shape": [-1], "values": [[[1, 0]]]}']
        for text in (*pairs, "", "[]", "{}", '{"shape": [1], "values": []}', '{"shape": [1e400]}', "[" * 10000):
            judged = judge_function(part, read_table(TABLE_PREFIX + text, domain, "points"), joints, domain.roles)
            assert judged.outcome is Outcome.WRONG


def test_nearly_right_values_are_shown_with_enough_digits() -> None:
    problem = get_problem("planar-2r", 0, variation="chapter")
    part, domain, joints = problem["position"], problem.domain, [q.name for q in problem.chain.q]
    empty = read_table(f'{TABLE_PREFIX}{{"shape": [2], "values": []}}', domain, "points")
    rows = part.answer.parse_trees(domain.roles)
    right = evaluate(compile_program([row[0] for row in rows]), empty.arguments, SAMPLE_COUNT).values.T
    example = judge_function(part, replace(empty, shape=(2,), values=right * (1 + 1e-8)), joints, domain.roles)
    assert re.search(r"yours (\S+), expected (?!\1$)", example.reason), example.reason
