"""The whole loop on every family: generate a problem, run the staff's solution as a notebook, grade it: full marks.

The usual mistakes in the answer to each question don't get full marks.
"""

from dataclasses import replace

import pytest

from qdot.exercises.problem.problem import Part, Problem, name_answer_variable
from qdot.exercises.reference_answers import ConditionSet, Direction, Expression, Matrix, Number
from qdot.exercises.writing.problem_texts import write_answer_code
from qdot.grader.judging.verdict import Outcome
from qdot.grader.marking.marking import mark
from qdot.grader.sandbox.sandbox import Sandbox
from tests.support.problems import sample_parts
from tests.support.suites import few_families, sample_for_suite


def run_answers(sandbox: Sandbox, problem: Problem, codes: dict[str, str]) -> dict[str, str]:
    """Run a notebook with an answer cell for each name, and return its answers."""
    names = list(problem.symbols)
    setup = f"from sympy import *\n{', '.join(names)} = symbols('{' '.join(names)}')"
    run = sandbox.run([setup, *(f"{name} = {code}" for name, code in codes.items())], list(codes))
    assert not run.cell_errors, run.cell_errors
    return run.answers


def test_the_solution_earns_full_marks(problem: Problem, sandbox: Sandbox) -> None:
    codes = {name_answer_variable("p1", part.name): write_answer_code(problem, part) for part in problem.parts}
    answers = run_answers(sandbox, problem, codes)
    student_answers = {part.name: answers[name_answer_variable("p1", part.name)] for part in problem.parts}
    for verdict in mark(problem, student_answers, secret="secret"):
        assert verdict.judgement.outcome is Outcome.CORRECT, (verdict.part, verdict.judgement.reason)
        assert verdict.points == verdict.max_points


def make_mistakes(part: Part, right: str) -> dict[str, str]:
    """Return code for the usual mistakes in an answer; `right` is the variable that holds the right answer."""
    answer = part.answer
    if isinstance(answer, ConditionSet):
        degrees, textbook_answer = "{Symbol('theta2'): [0, 180]}", "Eq(sin(Symbol('theta1')), 0)"
        return {"degrees": degrees, "none": "[]", "book": textbook_answer, "first": f"{right}[:-1]"}
    if isinstance(answer, Number):
        return {"sign": f"-{right}", "degrees": f"180/pi*{right}"}
    if isinstance(answer, Direction):
        entries = len(answer.reference)
        first = next(i for i, entry in enumerate(answer.reference) if entry != 0)
        another = f"{right} + 2*eye({entries})[:, {(first + 1) % entries}]"
        return {"zero": f"0*{right}", "nan": f"{right}*nan", "another": another}
    if not isinstance(answer, (Expression, Matrix)):
        return {}
    relative = {
        "theta1 + theta2 + theta3": "theta3", "theta1 + theta2": "theta2", "theta2 + theta3": "theta3",
        "theta1 - theta2": "theta2",
    }  # fmt: skip
    degrees = f"{right}.subs({{s: pi*s/180 for s in {right}.free_symbols if s.name[0] == 't'}})"
    codes = {"sign": f"-{right}", "nan": f"{right}*nan", "degrees": degrees, "unknown symbol": f"{right}*Symbol('k')"}
    if isinstance(answer, Matrix):
        reference = answer.reference
        if 1 not in reference.shape and reference != reference.T:
            codes["transposed"] = f"{right}.T"
        columns = reference.cols
        codes["dropped column"] = f"{right}*diag(*[0]*1, *[1]*{columns - 1})" if columns > 1 else f"{right}*0"
        codes["number for a matrix"] = "1"
    code = changed = part.answer.write_code()
    for absolute, wrong in relative.items():
        changed = changed.replace(absolute, wrong)
    if changed != code:
        codes["relative angle"] = changed
    angles = any(symbol.name.startswith("theta") for symbol in answer.reference.free_symbols)
    return {name: wrong for name, wrong in codes.items() if angles or name != "degrees"}


@few_families
def test_the_usual_mistakes_lose_points(problem: Problem, sandbox: Sandbox, monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the diagnosis, which changes no mark and takes most of the time; test_diagnosis.py tests it."""
    monkeypatch.setattr("qdot.grader.marking.marking.diagnose", lambda *_: None)
    parts = sample_for_suite(sample_parts(problem), 8)
    right = {f"right{i}": part.answer.write_code() for i, part in enumerate(parts)}
    pairs = zip(parts, right, strict=True)
    cases = [(part, *item) for part, name in pairs for item in make_mistakes(part, name).items()]
    answers = run_answers(sandbox, problem, right | {f"tried{i}": code for i, (_, _, code) in enumerate(cases)})
    for i, (part, mistake, code) in enumerate(cases):
        single_part = replace(problem, parts=(part,))
        (verdict,) = mark(single_part, {part.name: answers[f"tried{i}"]}, secret="secret")
        case = (problem.id, part.name, mistake, verdict.judgement.outcome, code)
        assert verdict.judgement.outcome in (Outcome.WRONG, Outcome.PARTIAL, Outcome.MISSING), case
        assert verdict.points is not None and verdict.points < verdict.max_points, case
