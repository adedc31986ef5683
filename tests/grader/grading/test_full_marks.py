"""The whole loop on every family: generate a problem, run the staff's solution as a notebook, grade it: full marks."""

from qdot.exercises.problem.problem import Problem, name_answer_variable
from qdot.exercises.writing.problem_texts import write_answer_code
from qdot.grader.judging.verdict import Outcome
from qdot.grader.marking.marking import mark
from qdot.grader.sandbox.sandbox import Sandbox


def test_the_solution_earns_full_marks(problem: Problem, sandbox: Sandbox) -> None:
    names = list(problem.symbols)
    setup = f"from sympy import *\n{', '.join(names)} = symbols('{' '.join(names)}')"
    codes = {name_answer_variable("p1", part.name): write_answer_code(problem, part) for part in problem.parts}
    run = sandbox.run([setup, *(f"{name} = {code}" for name, code in codes.items())], list(codes))
    assert not run.cell_errors, run.cell_errors
    student_answers = {part.name: run.answers[name_answer_variable("p1", part.name)] for part in problem.parts}
    for verdict in mark(problem, student_answers, secret="secret"):
        assert verdict.judgement.outcome is Outcome.CORRECT, (verdict.part, verdict.judgement.reason)
        assert verdict.points == verdict.max_points
