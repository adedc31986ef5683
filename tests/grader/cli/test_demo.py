"""The demonstration class: the mistake planted in a student's answers is diagnosed."""

from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.problem.problem import Problem
from qdot.grader.cli.demo import EDITS, SECRET
from qdot.grader.marking.marking import mark
from qdot.grader.sandbox.sandbox import Sandbox
from tests.support.suites import select_for_suite

MISTAKES = {
    "wrong sign throughout": {
        "sign", "determinant-sign", "determinant-plus",  # may give the same joint rates for 2 × 2 matrices
        "singular-taken-for-regular", "regular-taken-for-singular",  # the student answers every choice with A
        "arm-reversed",  # the same
    },
    "relative for absolute angles": {"relative-angle", "all-relative-angles", "relative-throughout"},
    "matrices transposed": {"transposed"},
    "joint 2 forgotten": {"joint-left-out"},
    "degrees for radians": {"angles-in-degrees", "rates-in-degrees"},
    "only the first condition": {"one-root-only", "shoulder-missed", "condition-missed"},
}  # fmt: skip
STUDENTS = ("s003", "s004", "s005", "s006", "s007", "s008")


@pytest.fixture(scope="module")
def demonstration(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    folder = tmp_path_factory.mktemp("demo") / "hw"
    init_assignment(folder, "T", "velocity", [Student(name) for name in STUDENTS], SECRET)
    return load_assignment(folder)


def make_answers(sandbox: Sandbox, problem: Problem, kind: str) -> dict[str, str]:
    edit, names = EDITS[kind], sorted({*problem.symbols, "theta1", "theta2", "theta3", "qd2"})
    codes = {part.name.replace("-", "_"): edit(part.answer.write_code(), part) for part in problem.parts}
    setup = f"from sympy import *\n{', '.join(names)} = symbols('{' '.join(names)}')"
    run = sandbox.run([setup, *(f"{name} = {code}" for name, code in codes.items())], list(codes))
    assert not run.cell_errors, run.cell_errors
    return {part.name: run.answers[part.name.replace("-", "_")] for part in problem.parts}


@pytest.mark.parametrize("kind", select_for_suite(["degrees for radians", "joint 2 forgotten"], list(MISTAKES)))
def test_planted_mistakes_are_diagnosed(kind: str, demonstration: Assignment, sandbox: Sandbox, tmp_path: Path) -> None:
    named: set[str] = set()
    for student in STUDENTS[: select_for_suite(1, 3)]:
        for slot, problem in demonstration.generate_problems(student):
            verdicts = mark(problem, make_answers(sandbox, problem, kind), secret=SECRET, functions_seed=slot)
            diagnoses = [verdict.diagnosis for verdict in verdicts if verdict.diagnosis and verdict.diagnosis.mistakes]
            named |= {name for diagnosis in diagnoses for name in diagnosis.mistakes}
            wrong = [verdict for verdict in verdicts if verdict.judgement.share < 1]
            assert not wrong or diagnoses, (problem.id, [verdict.judgement.reason for verdict in wrong])
    assert named and named <= MISTAKES[kind], named
